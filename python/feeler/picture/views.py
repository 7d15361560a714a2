"""The picture of a collision: the mock-up cut open at the hit, and a close view beside it."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_progress
from feeler.errors import OptionError
from feeler.io.body import MeshLike, only_faces
from feeler.picture.camera import Camera, Section, check_size, triple, usual_view, vertical_of
from feeler.picture.collision import Hits, check_mask, collision_bodies
from feeler.picture.renderer import Inset, render
from feeler.poses import PoseLike
from feeler.progress import Progress

_INSET = (0.615, 0.535, 0.36, 0.44)  # the close view's left, top, width and height, shares of the picture
_WHOLES = ((0.025, 0.025, 0.79, 0.75), (0.025, 0.025, 0.565, 0.95))  # the main view under the close view; beside it
_COVERED = 0.003  # share of the mock-up's vertices that the close view may hide
_CLOSE = 0.28  # extent of the close view, share of the tool's diagonal


def render_collision(
    path: str | os.PathLike[str] | None,
    mockup: MeshLike,
    tool: MeshLike,
    world_from_tool: PoseLike,
    collision: Hits,
    *,
    size: tuple[int, int] = (1600, 1000),
    direction: npt.ArrayLike | None = None,
    up: npt.ArrayLike | None = None,
    parts: npt.ArrayLike | None = None,
    progress: Progress | None = None,
) -> npt.NDArray[np.uint8]:
    """The whole mock-up cut open at the tool, and a close view of the collision; returns the pixels.

    The mock-up is cut vertically through the collision, and everything in front of the cut is removed. direction, up:
    of the view, (3,); None: upright as in the page, by `mockup.source`. parts: which parts are drawn, (parts,) bool,
    such as `scene.part_mask`; None: all. path: None writes no file. Raises `WriteError`, `OptionError`.
    """
    size = check_size(size)
    check_progress(progress)
    body, tool_body = collision_bodies(mockup, tool, world_from_tool, collision, grey=False)
    hit = np.asarray(collision.mockup_triangles, dtype=np.int64)
    low, high = tool_body.bounds
    focus = (low + high) / 2
    if len(hit):
        focus = np.clip(body.vertices[body.faces[hit]].mean(axis=(0, 1)), low, high)
    usual = usual_view(body.bounds, vertical_of(mockup))
    forward = check_array("direction", usual[0] if direction is None else direction, (3,))
    upright = check_array("up", usual[1] if up is None else up, (3,))
    if not forward.any() or not upright.any():
        raise OptionError("direction or up is zero: give three numbers, not all zero")
    across = forward - upright * (forward @ upright) / (upright @ upright)
    axis = int(np.argmax(np.abs(across)))
    normal = -np.sign(across[axis]) * np.eye(3)[axis]
    points, tool_points = body.points, tool_body.points
    points = np.concatenate([points[points @ normal <= focus @ normal], tool_points])
    for whole in _WHOLES:
        camera = Camera.framing(points, forward, upright, size=size, box=whole)
        seen = camera.shares(points, size)
        covered = np.all(seen > np.array(_INSET[:2]) - 0.01, axis=1)
        # The close view may cover a little of the mock-up, and nothing of the tool.
        if covered.mean() <= _COVERED and not covered[-len(tool_points) :].any():
            break
    reach = float(np.linalg.norm(high - low)) * _CLOSE / 2
    close_size = int(size[0] * _INSET[2]), int(size[1] * _INSET[3])
    close = Camera.framing([focus - reach, focus + reach], forward, upright, size=close_size)
    if parts is not None:
        body = only_faces(body, check_mask(parts, max(len(body.paths), 1))[body.part_of_face])
    return render(
        path,
        body,
        tool_body,
        camera=camera,
        size=size,
        section=Section(triple(focus), triple(normal)),
        inset=Inset(close, _INSET),
        progress=progress,
    )
