"""Pictures and films of a report: pairs of parts, and parts along their way, among faint others."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.choices import UpAxis
from feeler.clashes.pictures import Pictures, View
from feeler.io.body import LIGHT_GREY, ORANGE, STEEL_BLUE, Body, body_of
from feeler.io.export import animated_glb
from feeler.io.film import Leg, corners_of, moments, motions_of, with_neighbours
from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.picture import Camera, bars
from feeler.picture.camera import usual_view
from feeler.picture.ghosts import Ghosts
from feeler.picture.png import write_png
from feeler.poses import between
from feeler.workbench.document import motion
from feeler.workbench.report.values import PairPlace, WayRow

Floats = npt.NDArray[np.float64]

SIZE = (560, 350)
"""Width and height of the picture of a way, pixels."""
FRAMES = 6
"""Pictures along a way."""
_MOST_GHOSTS = 80_000
"""Triangles of the parts around; the smallest parts are left out first."""
_FEW = 100
"""Triangles for which it is not worth to look for more parts."""
_MOST_CONTEXT = 400_000
"""Triangles of the parts around in a film."""
_GHOST_REACH = 1.5  # of the extent of a picture
_WAY_REACH = 2.5  # how far of a way is in the picture, in diagonals of the moving parts
_MARGIN = 0.12  # of what moves, around it
_LINE = 48  # points of the line along a way
_WIDTH = 0.006  # of the line along the way, of the extent
_LEAST_M = 1e-6


class Drawing:
    """Draws one mock-up. absent: parts that are left out."""

    def __init__(self, mockup: Mockup, absent: Sequence[int] = ()) -> None:
        self._mockup = mockup
        self._pictures, self._meshes = Pictures(mockup), PartMeshes(mockup)
        self._boxes = np.asarray(mockup.part_bounds, dtype=np.float64).reshape(-1, 2, 3)
        with np.errstate(invalid="ignore"):
            self._sizes = np.nan_to_num(np.linalg.norm(self._boxes[:, 1] - self._boxes[:, 0], axis=1), posinf=0.0)
        is_whole = np.isfinite(self._boxes).all(axis=(1, 2)) & (self._boxes[:, 0] <= self._boxes[:, 1]).all(axis=1)
        self._is_there = np.array(is_whole, dtype=bool)
        self._is_there[list(absent)] = False

    def can_show(self, parts: Iterable[int]) -> bool:
        """Whether all these parts have triangles."""
        return all(0 <= part < len(self._is_there) and self._is_there[part] for part in parts)

    def pair(self, place: PairPlace, gone: Iterable[int] = ()) -> bytes:
        """Two parts in blue and orange, cut open where they meet, as PNG."""
        place = self._near(place)
        without = {place.a, place.b, *gone}

        def others(view: View) -> list[Body]:
            middle, reach = np.array(view.camera.target), _GHOST_REACH * view.reach
            return self._ghosts(np.stack([middle - reach, middle + reach]), without)

        return self._pictures.png(place, others)

    def way(self, row: WayRow, frames: int = FRAMES) -> list[bytes]:
        """The parts at `frames` times along their way, in blue, as PNG; the line is the way of their middle."""
        poses = np.stack([motion.matrix(pose) for pose in row.poses])
        moving = self._moving(row)
        low, high = moving.min(axis=(0, 1)), moving.max(axis=(0, 1))
        size = max(float(np.linalg.norm(high - low)), _LEAST_M)
        middle = (low + high) / 2
        bounds = np.stack([low, high])
        end = _share_near(poses, bounds, _WAY_REACH * size)
        shown = _at_times(poses, bounds, frames, end)
        framed = np.concatenate([_at(pose, corners_of(bounds)) for pose in shown])
        around = np.stack([framed.min(axis=0), framed.max(axis=0)])
        around = _grown(around, _MARGIN * float(np.linalg.norm(around[1] - around[0])))
        along = _at(shown[-1], middle[None])[0] - middle
        camera = _camera(around, along, self._mockup.source.vertical)
        extent = float(np.linalg.norm(around[1] - around[0]))
        ghosts = Ghosts(self._ghosts(_grown(around, 0.5 * extent), {*row.parts, *row.gone}), camera, SIZE)
        places = np.stack([_at(pose, middle[None])[0] for pose in _at_times(poses, bounds, _LINE)])
        line = bars(places[:-1], places[1:], max(_WIDTH * extent, _LEAST_M), ["way"] * (len(places) - 1), ORANGE)
        lines = [] if line is None else [line]
        return [_png(ghosts.picture(_body(_at(pose, moving.reshape(-1, 3))), *lines)) for pose in shown]

    def film(self, rows: Sequence[WayRow], absent: Sequence[int] = ()) -> bytes:
        """The ways one after the other as an animated glTF: moving parts in blue, others near them grey."""
        mockup = self._mockup
        moving = sorted({part for row in rows for part in row.parts})
        elsewhere = {part for row in rows[:1] for part in row.gone}
        shown = self._bounded(with_neighbours(mockup, moving, sorted({*absent, *elsewhere} - {*moving})), moving)
        place = {part: number for number, part in enumerate(shown)}
        colours = np.tile(np.array(LIGHT_GREY), (len(shown), 1))
        colours[[place[part] for part in moving]] = STEEL_BLUE
        legs = [
            Leg(
                np.stack([motion.matrix(pose) for pose in row.poses]),
                {part: motion.matrix(row.starts.get(part, motion.HOME)) for part in row.parts},
            )
            for row in rows
        ]
        motions = motions_of(legs, mockup, place)
        return animated_glb(body_of(Tool.of_parts(mockup, shown, "report"), colours=colours), motions)

    # ---- parts ----

    def _near(self, place: PairPlace) -> PairPlace:
        """The pair with points that are near its parts: a file may name any."""
        boxes = self._boxes[[place.a, place.b]]
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        size = float(np.linalg.norm(high - low))
        given = np.array([place.point_a, place.point_b])
        is_near = bool(((given >= low - size) & (given <= high + size)).all())
        points = given if is_near else np.full((2, 3), np.nan)
        way = np.array(place.translation)
        if not (np.abs(way) <= 2.0 * size).all():
            way = np.zeros(3)
        (one, other, third) = (tuple(each.tolist()) for each in (*points, way))
        return PairPlace(place.a, place.b, one, other, third)

    def _moving(self, row: WayRow) -> Floats:
        """The corners `(k, 3, 3)` of the triangles of the moving parts, where they start."""
        found = []
        for part in row.parts:
            corners = self._meshes.corners(part)
            corners = corners[np.isfinite(corners).all(axis=(1, 2))]
            start = motion.matrix(row.starts.get(part, motion.HOME))
            found.append(_at(start, corners.reshape(-1, 3)).reshape(-1, 3, 3))
        return np.concatenate(found)

    def _ghosts(self, box: Floats, without: Iterable[int]) -> list[Body]:
        """The parts in a box, the large ones first, as far as they are quick to draw."""
        is_near = self._is_there & (self._boxes[:, 0] <= box[1]).all(axis=1) & (self._boxes[:, 1] >= box[0]).all(axis=1)
        is_near[[part for part in without if 0 <= part < len(is_near)]] = False
        parts = np.flatnonzero(is_near)
        found: list[Floats] = []
        left = _MOST_GHOSTS
        for part in parts[np.argsort(-self._sizes[parts], kind="stable")].tolist():
            if left < _FEW:
                break
            corners = self._meshes.corners(part)
            if len(corners) > left:
                low, high = corners.min(axis=1), corners.max(axis=1)
                corners = corners[((low <= box[1]) & (high >= box[0])).all(axis=1)]
            if len(corners) > left:
                continue
            corners = corners[np.isfinite(corners).all(axis=(1, 2))]
            left -= len(corners)
            found.append(corners)
        return [_body(each.reshape(-1, 3), LIGHT_GREY) for each in found if len(each)]

    def _bounded(self, shown: Sequence[int], moving: Sequence[int]) -> list[int]:
        """The parts of a film: those with most triangles are left out if there are too many in all."""
        kept, left = set(moving), _MOST_CONTEXT
        count = self._mockup.part_triangles
        for part in sorted(set(shown) - kept, key=lambda each: int(count[each])):
            left -= int(count[part])
            if left < 0:
                break
            kept.add(part)
        return sorted(kept)


def _body(points: Floats, colour: tuple[float, float, float] = STEEL_BLUE) -> Body:
    count = len(points) // 3
    zeros = np.zeros(count, dtype=np.int64)
    return Body(points, np.arange(3 * count).reshape(-1, 3), zeros, ("part",), np.array([colour]), zeros)


def _png(image: npt.NDArray[np.uint8]) -> bytes:
    out = io.BytesIO()
    write_png(out, image)
    return out.getvalue()


def _at(pose: Floats, points: Floats) -> Floats:
    moved: Floats = points @ pose[:3, :3].T + pose[:3, 3]
    return moved


def _share_near(poses: Floats, bounds: Floats, reach: float) -> float:
    """The share of a way, by time, after which the middle of the box is farther than `reach` from its start."""
    middle = bounds.mean(axis=0)
    places = np.stack([_at(pose, middle[None])[0] for pose in _at_times(poses, bounds, _LINE)])
    is_near = np.linalg.norm(places - middle, axis=1) <= reach
    far = np.flatnonzero(~is_near)
    return 1.0 if not len(far) or len(places) < 2 else max(1, int(far[0]) - 1) / (len(places) - 1)


def _at_times(poses: Floats, bounds: Floats, count: int, end: float = 1.0) -> list[Floats]:
    """The poses at `count` times spread evenly over the way up to a share of it, its first and its last among them."""
    if len(poses) < 2:
        return [poses[0]]
    times = moments(poses, bounds)
    middle = bounds.mean(axis=0)
    found = []
    for time in np.linspace(0.0, end * times[-1], count):
        after = int(np.clip(np.searchsorted(times, time), 1, len(times) - 1))
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        found.append(between(poses[after - 1], poses[after], middle, float(share)))
    return found


def _grown(box: Floats, by: float) -> Floats:
    return np.stack([box[0] - by, box[1] + by])


def _camera(around: Floats, way: Floats, vertical: UpAxis) -> Camera:
    """From above, from the corner that sees the way from the side, and the parts come towards it rather than away."""
    usual, up = usual_view(around, vertical)
    size = float(np.linalg.norm(way))
    best, least = usual, np.inf
    upright = int(np.argmax(up))
    sides = [axis for axis in range(3) if axis != upright]
    for one in (1.0, -1.0):
        for other in (1.0, -1.0):
            direction = np.array(usual)
            direction[sides] *= (one, other)
            along = float(direction @ way) / size if size > 0.0 else 0.0
            cost = abs(along) + 0.3 * max(along, 0.0)
            if cost < least - 1e-9:
                best, least = direction, cost
    return Camera.framing(around, best, up, size=SIZE, box=(0.16, 0.16, 0.68, 0.68))
