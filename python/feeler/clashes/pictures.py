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

from feeler.clashes.sides import Sides, directions
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

_INNER = 0.8
"""Share of the picture, across and down, in which the place is rather than at its border."""

_RING_PX = 15.0

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
    away; None if nothing is cut. reach: the extent of the picture, metres."""

    camera: Camera
    point: Floats
    normal: Floats | None
    reach: float


class Pictures:
    """Pictures of the findings of one mock-up."""

    def __init__(self, mockup: Mockup) -> None:
        self._meshes, self._vertical = PartMeshes(mockup), mockup.source.vertical
        self._bounds = mockup.part_bounds.reshape(-1, 2, 3)
        self._kept: OrderedDict[int, _Triangles] = OrderedDict()

    def view(self, clash: Pair) -> View:
        """The camera for a finding. It shows all of the smaller part, both points, and the larger part around it.

        A gap is seen whole, with nothing before it; if there is no such side, or the parts overlap, they are cut open.
        Of all these sides it is one that shows enough of both parts, across the gap, and near to the usual one.
        """
        boxes = self._bounds[[clash.a, clash.b]]
        box = min(boxes, key=lambda each: float(np.linalg.norm(each[1] - each[0])))
        points, line = _line(clash)
        if not len(points):
            points = box.mean(axis=0)[None]
        point = points.mean(axis=0)
        low, high = np.minimum(box[0], points.min(axis=0)), np.maximum(box[1], points.max(axis=0))
        reach = max(float(np.linalg.norm(high - low)) / 2 * _REACH, _LEAST_VIEW_M)
        middle = (low + high) / 2
        usual, up = usual_view([low, high], self._vertical)
        corners = [middle - reach / 2, middle + reach / 2]
        looks = directions(usual, self._vertical)
        cameras = [Camera.framing(corners, look, up, size=SIZE, fov_deg=FOV_DEG) for look in looks]
        bodies = [self._body(part, 0, middle, reach) for part in (clash.a, clash.b)]
        score = looks @ looks[0]
        size = float(np.linalg.norm(line))
        if size > 0.0:
            score -= 0.5 * np.abs(looks @ (line / size))
        off = np.array([np.abs(camera.shares(point[None], SIZE)[0] - 0.5).max() for camera in cameras])
        score -= np.where(off > _INNER / 2, 1.0, 0.0)
        sides = Sides(cameras, [each.vertices[each.faces] for each in bodies], reach)
        rows: list[tuple[float, int, Floats | None]] = []
        is_overlap = bool(np.nan_to_num(np.array(clash.translation)).any())
        seen = sides.sees(points[0], points[-1])
        if not is_overlap and seen.any():
            which = np.flatnonzero(seen)
            rows += zip(
                score[which] + sides.shares(which, point, None), which.tolist(), [None] * len(which), strict=True
            )
        else:
            for normal in np.concatenate([np.eye(3), -np.eye(3)]):
                which = np.flatnonzero((-looks @ normal) >= np.abs(looks).max(axis=1))
                ahead = (boxes - point) @ normal  # of both ends of their boxes
                if len(which) and bool((ahead.min(axis=1) < -_LEAST_CUT * reach).all()):
                    found = score[which] + sides.shares(which, point, normal)
                    rows += zip(found, which.tolist(), [normal] * len(which), strict=True)
        _, best, normal = max(rows, key=lambda row: row[0], default=(0.0, 0, None))
        return View(cameras[best], point, normal, reach)

    def png(self, clash: Pair, others: Callable[[View], Sequence[Body]] | None = None) -> bytes:
        """The picture as PNG: first part blue, second part orange, translation or gap red, and a ring around it.

        It is cut at the contact if `view` says so. others: bodies to show faintly around them.
        """
        view = self.view(clash)
        middle = np.array(view.camera.target)
        bodies = [self._body(clash.a, 0, middle, view.reach), self._body(clash.b, 1, middle, view.reach)]
        points, way = _line(clash)
        start = points[0] if len(points) and not np.nan_to_num(clash.translation).any() else view.point
        line = bars(start[None], (start + way)[None], view.reach * 0.012, ["way"], RED)
        shown = [body for body in bodies if len(body.faces)]
        section = None if view.normal is None else Section(triple(view.point), triple(view.normal))
        ghosts = [] if others is None else others(view)
        picture = Ghosts(ghosts, view.camera, SIZE, section).picture(*shown, *([line] if line is not None else []))
        _mark(picture, view.camera.shares(view.point[None], SIZE)[0] * SIZE)
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


def _line(clash: Pair) -> tuple[Floats, Floats]:
    """Both points `(2, 3)`, none if they are not known; and the translation, or else the gap, zero if none is known."""
    points = np.array([clash.point_a, clash.point_b])
    points = points if np.isfinite(points).all() else np.empty((0, 3))
    way = np.nan_to_num(np.array(clash.translation))
    return points, points[1] - points[0] if len(points) and not way.any() else way


def _mark(picture: npt.NDArray[np.uint8], at: Floats) -> None:
    """A red ring with a white border around a place, pixels."""
    rows, columns = (np.arange(n) + 0.5 for n in picture.shape[:2])
    off = np.abs(np.hypot(columns - at[0], rows[:, None] - at[1]) - _RING_PX)
    for colour, width in (((1.0, 1.0, 1.0), 3.0), (RED, 1.5)):
        ink = np.clip(width - off, 0.0, 1.0)[..., None]
        picture[:] = np.round(picture * (1.0 - ink) + 255.0 * np.array(colour) * ink).astype(np.uint8)


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
