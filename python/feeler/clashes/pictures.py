"""Draws a finding: both parts near the contact, cut open there."""

from __future__ import annotations

import io
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler.io.body import ORANGE, RED, STEEL_BLUE, Body
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes
from feeler.picture import Camera, Section, bars
from feeler.picture.camera import triple, usual_view
from feeler.picture.ghosts import Ghosts
from feeler.picture.png import write_png

Floats = npt.NDArray[np.float64]

SIZE = (480, 300)
"""Width and height, pixels."""

FOV_DEG = 45.0
"""The vertical field of view: the smallest that BCF viewers must support."""

_REACH = 1.6
"""The extent of the picture, relative to the box of the smaller part. A larger extent would make both parts small."""

_LEAST_VIEW_M = 1e-6

_LEAST_CUT = 1e-6
"""Of the reach: the least that a section leaves of each part."""

_FAR = 8.0
"""A part whose box is more than this many times the reach is drawn only near the contact."""

_AROUND = 2.0
"""How far around the middle such a part is drawn, in reaches: more than the picture shows."""

_LARGE = 50_000
"""A part with more triangles is also drawn only near the contact, unless most of it is there."""

_KEPT_TRIANGLES = 3_000_000
"""Most triangles that are kept for the next pictures, 360 MB. A part with many findings is looked up once, not for each
picture."""


Point = tuple[float, float, float]


class Pair(Protocol):
    """Two parts and where they meet or are nearest: a `Clash`, for one."""

    @property
    def a(self) -> int:
        """The index of the first part."""

    @property
    def b(self) -> int:
        """The index of the second part."""

    @property
    def point_a(self) -> Point:
        """On the first part, metres; NaN if it is not known."""

    @property
    def point_b(self) -> Point:
        """On the second part."""

    @property
    def translation(self) -> Point:
        """That moves the first part out of the second, metres; zero or NaN if none is known."""


@dataclass(frozen=True, eq=False)
class View:
    """The view of a finding. point: on the section plane, `(3,)` metres. normal: `(3,)`, points to the side that is cut
    away. reach: the extent of the picture, metres."""

    camera: Camera
    point: Floats
    normal: Floats
    reach: float


class Pictures:
    """Pictures of the findings of one mock-up."""

    def __init__(self, mockup: Mockup) -> None:
        self._meshes = PartMeshes(mockup)
        self._bounds = mockup.part_bounds.reshape(-1, 2, 3)
        self._kept: OrderedDict[int, _Triangles] = OrderedDict()

    def view(self, clash: Pair) -> View:
        """The camera for a finding. It shows all of the smaller part, both points, and the larger part around it."""
        boxes = [self._bounds[clash.a], self._bounds[clash.b]]
        box = min(boxes, key=lambda each: float(np.linalg.norm(each[1] - each[0])))
        points = np.array([clash.point_a, clash.point_b])
        if not np.isfinite(points).all():
            points = box.mean(axis=0)[None]
        point = points.mean(axis=0)
        low, high = np.minimum(box[0], points.min(axis=0)), np.maximum(box[1], points.max(axis=0))
        reach = max(float(np.linalg.norm(high - low)) / 2 * _REACH, _LEAST_VIEW_M)
        middle = (low + high) / 2
        direction, up = usual_view([low, high])
        corners = [middle - reach / 2, middle + reach / 2]
        camera = Camera.framing(corners, direction, up, size=SIZE, fov_deg=FOV_DEG)
        axis = int(np.argmax(np.abs(direction)))
        return View(camera, point, -np.sign(direction[axis]) * np.eye(3)[axis], reach)

    def png(self, clash: Pair, others: Callable[[View], Sequence[Body]] | None = None) -> bytes:
        """The picture as PNG, cut at the contact: first part blue, second part orange, translation or gap red.

        It is not cut if that would remove a part as a whole. others: bodies to show faintly around them.
        """
        view = self.view(clash)
        middle = np.array(view.camera.target)
        bodies = [self._body(clash.a, 0, middle, view.reach), self._body(clash.b, 1, middle, view.reach)]
        start, way = view.point, np.array(clash.translation)
        points = np.array([clash.point_a, clash.point_b])
        if not np.nan_to_num(way).any() and np.isfinite(points).all():
            start, way = points[0], points[1] - points[0]
        line = bars(start[None], (start + np.nan_to_num(way))[None], view.reach * 0.012, ["way"], RED)
        shown = [body for body in bodies if len(body.faces)]
        ahead = (self._bounds[[clash.a, clash.b]] - view.point) @ view.normal  # of both ends of their boxes
        is_cut = bool((ahead.min(axis=1) < -_LEAST_CUT * view.reach).all())
        section = Section(triple(view.point), triple(view.normal)) if is_cut else None
        ghosts = [] if others is None else others(view)
        picture = Ghosts(ghosts, view.camera, SIZE, section).picture(*shown, *([line] if line is not None else []))
        out = io.BytesIO()
        write_png(out, picture)
        return out.getvalue()

    def _body(self, part: int, number: int, middle: Floats, reach: float) -> Body:
        """The part as a body. Of a part much larger than the view, only triangles near it: drawing five million would
        take a minute."""
        triangles = self._triangles(part)
        corners = triangles.corners
        box = self._bounds[part]
        is_far = float(np.linalg.norm(box[1] - box[0])) > _FAR * reach
        if is_far or len(corners) > _LARGE:
            near = triangles.near(middle - _AROUND * reach, middle + _AROUND * reach)
            if is_far or 2 * len(near) < len(corners):
                corners = corners[near]
        return Body(
            vertices=corners.reshape(-1, 3),
            faces=np.arange(3 * len(corners)).reshape(-1, 3),
            part_of_face=np.zeros(len(corners), dtype=np.int64),
            paths=("ab"[number],),
            palette=np.array([STEEL_BLUE if number == 0 else ORANGE]),
            colour_of_face=np.zeros(len(corners), dtype=np.int64),
        )

    def _triangles(self, part: int) -> _Triangles:
        """The triangles of a part, cached for the next pictures."""
        if part not in self._kept:
            corners = self._meshes.corners(part)
            self._kept[part] = _Triangles(corners[np.isfinite(corners).all(axis=(1, 2))])
            while len(self._kept) > 2 and sum(len(each.corners) for each in self._kept.values()) > _KEPT_TRIANGLES:
                self._kept.popitem(last=False)
        self._kept.move_to_end(part)
        return self._kept[part]


class _Triangles:
    """The triangles of one part, with boxes that are computed on first use."""

    def __init__(self, corners: Floats) -> None:
        self.corners = corners

    @cached_property
    def _boxes(self) -> list[tuple[Floats, Floats]]:
        """Minimum and maximum of the corners along each axis. Much faster than numpy reductions over three values."""
        sides = []
        for axis in range(3):
            one, two, three = (np.ascontiguousarray(self.corners[:, corner, axis]) for corner in range(3))
            sides.append((np.minimum(np.minimum(one, two), three), np.maximum(np.maximum(one, two), three)))
        return sides

    def near(self, low: Floats, high: Floats) -> npt.NDArray[np.intp]:
        """The indices of the triangles whose boxes overlap the given box."""
        found = np.ones(len(self.corners), dtype=bool)
        for axis, (least, largest) in enumerate(self._boxes):
            found &= (least <= high[axis]) & (largest >= low[axis])
        return np.flatnonzero(found)
