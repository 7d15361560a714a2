"""The picture of a collision: the mock-up cut open where it is hit, and a close view beside it."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.io.body import Body, only_faces
from feeler.picture.camera import Camera, Section, usual_view
from feeler.picture.collision import collision_bodies
from feeler.picture.renderer import Inset, render

Box = tuple[float, float, float, float]

_INSET = (0.36, 0.44)  # width and height of the close view, shares of the picture
_MARGIN = 0.025
_SAMPLED = 20_000  # points that stand for a mock-up while the layout is sought
_COVERED = 0.003  # share of the points that the close view may hide


def render_collision(
    path: str | os.PathLike[str],
    mockup: Any,
    tool: Any,
    world_from_tool: npt.ArrayLike,
    collision: Any,
    *,
    size: tuple[int, int] = (1600, 1000),
    direction: npt.ArrayLike | None = None,
    up: npt.ArrayLike | None = None,
    parts: npt.ArrayLike | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> npt.NDArray[np.uint8]:
    """The whole mock-up cut open at the tool, and a close view of what collides; returns the pixels.

    direction, up: of the view, (3,); None: `usual_view` of the mock-up's box. parts: which are drawn, (parts,) bool,
    such as `scene.part_mask`; None: all. Raises `WriteError`, `OptionError`.
    """
    body, tool_body = collision_bodies(mockup, tool, world_from_tool, collision, grey=False)
    views = collision_views(body, tool_body, collision, size, direction, up)
    if parts is not None:
        body = only_faces(body, np.asarray(parts, dtype=bool)[body.part_of_face])
    return render(path, body, tool_body, size=size, progress=progress, **views)


def collision_views(
    body: Body,
    tool_body: Body,
    collision: Any,
    size: tuple[int, int] = (1600, 1000),
    direction: npt.ArrayLike | None = None,
    up: npt.ArrayLike | None = None,
) -> dict[str, Any]:
    """Camera, section and inset that show a collision: keyword arguments for `render`.

    The mock-up is cut upright through what collides, and what stands before the cut is taken away. The inset shows
    the place from near, in the corner of the picture that leaves the whole largest.
    """
    hit = np.asarray(collision.mockup_triangles, dtype=np.int64)
    tool_box = tool_body.bounds
    focus = tool_box.mean(axis=0)
    if len(hit):
        focus = np.clip(body.vertices[body.faces[hit]].reshape(-1, 3).mean(axis=0), tool_box[0], tool_box[1])
    usual = usual_view(body.bounds)
    forward = np.asarray(usual[0] if direction is None else direction, dtype=np.float64)
    upright = np.asarray(usual[1] if up is None else up, dtype=np.float64)
    across = forward - upright * (forward @ upright) / (upright @ upright)
    axis = int(np.argmax(np.abs(across)))
    normal = np.zeros(3)
    normal[axis] = -np.sign(across[axis])
    section = Section(_xyz(focus), _xyz(normal))
    points = body.points
    points = points[points @ normal <= focus @ normal]
    main_box, inset_box = _layout(points, tool_body.points, forward, upright, size)
    points = np.concatenate([points, tool_body.points])
    camera = Camera.framing(points, forward, upright, size=size, box=main_box)
    reach = float(np.linalg.norm(tool_box[1] - tool_box[0])) * 0.28
    close = Camera.framing(
        np.stack([focus - reach / 2, focus + reach / 2]),
        forward,
        upright,
        size=(int(size[0] * inset_box[2]), int(size[1] * inset_box[3])),
    )
    return {"camera": camera, "section": section, "insets": [Inset(close, inset_box, section)]}


def _layout(
    points: npt.NDArray[np.float64],
    tool_points: npt.NDArray[np.float64],
    forward: npt.NDArray[np.float64],
    up: npt.NDArray[np.float64],
    size: tuple[int, int],
) -> tuple[Box, Box]:
    """The box for the whole and the box for the inset: the whole as large as it can be without being covered.

    Of the mock-up a little may be covered, of the tool nothing.
    """
    few_of_tool = tool_points[:: max(len(tool_points) // _SAMPLED, 1)]
    few = np.concatenate([points[:: max(len(points) // _SAMPLED, 1)], few_of_tool])
    width, height = _INSET
    best: tuple[float, Box, Box] | None = None
    for right in (True, False):
        for top in (True, False):
            inset = (1 - _MARGIN - width if right else _MARGIN, _MARGIN if top else 1 - _MARGIN - height, width, height)
            for w in (1.0, 0.92, 0.84, 0.76, 0.68, 1 - width - _MARGIN):
                for h in (1.0, 0.9, 0.8, 0.7, 1 - height - _MARGIN):
                    left, above = (0.0 if right else 1 - w), (1 - h if top else 0.0)
                    main = (left + _MARGIN, above + _MARGIN, w - 2 * _MARGIN, h - 2 * _MARGIN)
                    camera = Camera.framing(few, forward, up, size=size, box=main)
                    seen = camera.shares(few, size)
                    low = np.array(inset[:2]) - 0.01
                    hidden = np.all((seen > low) & (seen < low + np.array(inset[2:]) + 0.02), axis=1)
                    clear = hidden.mean() <= _COVERED and not hidden[-len(few_of_tool) :].any()
                    distance = float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
                    if clear and (best is None or distance < best[0] * 0.995):
                        best = (distance, main, inset)
    assert best is not None  # the narrowest boxes beside the inset are never covered
    return best[1], best[2]


def _xyz(vector: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
