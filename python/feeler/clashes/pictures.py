"""A picture of one finding: both parts near the place, cut open there."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.clashes.part_meshes import PartMeshes
from feeler.clashes.table import Clash
from feeler.io.body import ORANGE, RED, STEEL_BLUE, Body
from feeler.mockup import Mockup
from feeler.picture import Camera, Section, bars, render
from feeler.picture.camera import triple, usual_view
from feeler.picture.png import write_png

Floats = npt.NDArray[np.float64]

SIZE = (480, 300)
"""Width and height, pixels."""

FOV_DEG = 45.0
"""The vertical field of view: the least that BCF viewers have to show."""

_REACH = 1.6
"""How far around the smaller part is shown, of its box; more of the larger one would make both small."""

_LEAST_VIEW_M = 1e-6


@dataclass(frozen=True)
class View:
    """Where a finding is looked at from. point: where it is cut, `(3,)` metres; normal: of what is taken away, `(3,)`;
    reach: how far around it is shown, metres."""

    camera: Camera
    point: Floats
    normal: Floats
    reach: float


class Pictures:
    """Pictures of the findings of one mock-up."""

    def __init__(self, mockup: Mockup) -> None:
        self._meshes = PartMeshes(mockup)
        self._bounds = mockup.part_bounds.reshape(-1, 2, 3)

    def view(self, clash: Clash) -> View:
        """The camera on a finding: the whole of the smaller part, and of the larger what is around."""
        boxes = [self._bounds[clash.a], self._bounds[clash.b]]
        box = min(boxes, key=lambda each: float(np.linalg.norm(each[1] - each[0])))
        point = np.nan_to_num((np.array(clash.point_a) + np.array(clash.point_b)) / 2)
        low, high = np.minimum(box[0], point), np.maximum(box[1], point)
        reach = max(float(np.linalg.norm(high - low)) / 2 * _REACH, _LEAST_VIEW_M)
        middle = (low + high) / 2
        direction, up = usual_view([low, high])
        corners = [middle - reach / 2, middle + reach / 2]
        camera = Camera.framing(corners, direction, up, size=SIZE, fov_deg=FOV_DEG)
        axis = int(np.argmax(np.abs(direction)))
        return View(camera, point, -np.sign(direction[axis]) * np.eye(3)[axis], reach)

    def png(self, clash: Clash) -> bytes:
        """The picture as PNG: the first part blue, the second orange, the least way out red; cut through the place."""
        view = self.view(clash)
        middle = np.array(view.camera.target)
        bodies = [self._body(clash.a, 0, middle, view.reach), self._body(clash.b, 1, middle, view.reach)]
        start = view.point
        way = np.array(clash.translation) if clash.depth > 0.0 else np.subtract(clash.point_b, clash.point_a)
        line = bars(start[None], (start + np.nan_to_num(way))[None], view.reach * 0.012, ["way"], RED)
        shown = [body for body in bodies if len(body.faces)]
        section = Section(triple(start), triple(view.normal))
        image = render(
            None, *shown, *([line] if line is not None else []), camera=view.camera, size=SIZE, section=section
        )
        out = io.BytesIO()
        write_png(out, image)
        return out.getvalue()

    def _body(self, part: int, number: int, middle: Floats, reach: float) -> Body:
        """A part; of one that is much larger than the view only the triangles that come near it, so that five million
        of them do not take a minute."""
        corners = self._meshes.corners(part)
        box = self._bounds[part]
        if float(np.linalg.norm(box[1] - box[0])) > 8.0 * reach:
            low, high = corners.min(axis=1), corners.max(axis=1)
            corners = corners[((low <= middle + 2.0 * reach) & (high >= middle - 2.0 * reach)).all(axis=1)]
        corners = corners[np.isfinite(corners).all(axis=(1, 2))]
        return Body(
            vertices=corners.reshape(-1, 3),
            faces=np.arange(3 * len(corners)).reshape(-1, 3),
            part_of_face=np.zeros(len(corners), dtype=np.int64),
            paths=("ab"[number],),
            palette=np.array([STEEL_BLUE if number == 0 else ORANGE]),
            colour_of_face=np.zeros(len(corners), dtype=np.int64),
        )
