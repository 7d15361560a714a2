"""How far an open-end wrench swings: the exact arcs in which its boxes meet triangles. Any one unit of length.

Everything is in the frame of the wrench on a seat: z along the fastener's axis, the handle along x. A box meets a
triangle where its rectangle meets the part of the triangle between the box's ends, seen along z. While the rectangle
turns, that changes only where a corner of one passes a side of the other: all those angles are computed, and between
two of them one test decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from ..mesh import Floats

Bools = npt.NDArray[np.bool_]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]
FULL = float(2.0 * np.pi)
SEAT = float(np.pi / 3.0)
"""Between two seats of a wrench on a hexagon, radians."""
LENGTH, WIDTH, THICK = 9.0, 0.9, 0.38
"""Length of a wrench from the axis, width of its handle, and thickness of its jaws, in flats."""
MANY = 4096


def wrench(flats: float) -> tuple[Box, ...]:
    """Boxes (low, high) of an open-end wrench: two jaws, the neck and the handle; sizes about as DIN 3110.

    z = 0 is the top of the head.
    """
    inside, outside, back, neck = 0.51 * flats, 1.08 * flats, -0.35 * flats, 0.95 * flats
    thick, half = THICK * flats, 0.5 * WIDTH * flats
    return (
        ((back, inside, -thick), (neck, outside, 0.0)),
        ((back, -outside, -thick), (neck, -inside, 0.0)),
        ((0.61 * flats, -outside, -thick), (neck, outside, 0.0)),
        ((neck, -half, -0.9 * thick), (LENGTH * flats, half, -0.1 * thick)),
    )


def widest_swing(corners: Floats, boxes: Sequence[Box]) -> float:
    """The widest arc, radians, in which boxes that turn about z meet no triangle and that contains a seat.

    `corners`: of the triangles, (n, 3, 3). The seats are at multiples of `SEAT`. 0 if no seat is free.
    """
    ends = np.array(boxes)
    near = corners[_near(corners, ends.min(axis=(0, 1)), ends.max(axis=(0, 1)))]
    arcs = [arc for box in boxes for arc in _blocked(near, box)]
    if not arcs:
        return FULL
    starts, ends = (np.concatenate(each) for each in zip(*arcs, strict=True))
    order = np.argsort(starts)
    starts, ends = starts[order], np.maximum.accumulate(ends[order])
    nexts = np.append(starts[1:], starts[0] + FULL)
    ends = np.maximum(ends, ends[-1] - FULL)  # the last arcs may go on past the first
    has_seat = np.ceil(ends / SEAT) * SEAT <= nexts
    return float(np.max(np.where(has_seat, nexts - ends, 0.0), initial=0.0))


def _blocked(corners: Floats, box: Box) -> list[tuple[Floats, Floats]]:
    """Starts (0 to a full turn) and ends of arcs in which a box meets triangles."""
    low, high = np.array(box)
    found = []
    chosen = corners[_near(corners, low, high)]
    for begin in range(0, len(chosen), MANY):
        some = chosen[begin : begin + MANY]
        sides = _sides(some, float(low[2]), float(high[2]))
        found += [_arcs_of_sides(sides.reshape(-1, 2, 2), low, high), _arcs_around(some, sides, low, high)]
    return [arcs for arcs in found if len(arcs[0])]


def _near(corners: Floats, low: Floats, high: Floats) -> Bools:
    """Which triangles a box that turns about z may meet."""
    least, most = (far(far(corners[:, 0], corners[:, 1]), corners[:, 2]) for far in (np.minimum, np.maximum))
    gap = np.maximum(np.maximum(least, -most), 0.0)
    reach = float(np.hypot(*np.maximum(np.abs(low), np.abs(high))[:2]))
    return np.asarray((least[:, 2] < high[2]) & (most[:, 2] > low[2]) & (np.hypot(gap[:, 0], gap[:, 1]) < reach))


def _sides(corners: Floats, low: float, high: float) -> Floats:
    """The outlines of the triangles between two heights, seen along z: (n, 5, 2, 2), NaN where there is no side."""
    start, way = corners, np.roll(corners, -1, axis=1) - corners
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = (np.array([low, high]) - start[:, :, 2, None]) / way[:, :, 2, None]
    first, last = np.fmax(np.fmin(cuts[..., 0], cuts[..., 1]), 0.0), np.fmin(np.fmax(cuts[..., 0], cuts[..., 1]), 1.0)
    share = np.stack([first, last], axis=2)
    level = (way[:, :, 2] == 0.0) & (start[:, :, 2] >= low) & (start[:, :, 2] <= high)
    share = np.where(level[..., None], [0.0, 1.0], np.where((first <= last)[..., None], share, np.nan))
    edges = start[:, :, None, :2] + share[..., None] * way[:, :, None, :2]
    across = np.full((len(corners), 2, 2, 2), np.nan)
    for k in range(2):  # where the plane of a height cuts the triangle
        cut = np.where((cuts[..., k] >= 0.0) & (cuts[..., k] <= 1.0), cuts[..., k], np.nan)
        points = start[:, :, :2] + cut[..., None] * way[:, :, :2]
        order = np.argsort(np.isnan(cut), axis=1, kind="stable")[:, :2]
        across[:, k] = np.take_along_axis(points, order[..., None], axis=1)
    return np.concatenate([edges, across], axis=1)


def _arcs_of_sides(sides: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Arcs in which a rectangle meets sides (n, 2, 2)."""
    sides = sides[~np.isnan(sides).any(axis=(1, 2))]
    events = [_passed(sides, np.array([x, y])) for x in (low[0], high[0]) for y in (low[1], high[1])]
    for k in range(2):  # an end of the side on a side of the rectangle
        radius, angle = np.hypot(*sides[:, k].T), np.arctan2(sides[:, k, 1], sides[:, k, 0])
        with np.errstate(divide="ignore", invalid="ignore"):
            for x in (low[0], high[0]):
                turn = np.arccos(x / radius)
                events.append(angle[:, None] + np.stack([turn, -turn], axis=1))
            for y in (low[1], high[1]):
                turn = np.arcsin(y / radius)
                events.append(angle[:, None] - np.stack([turn, np.pi - turn], axis=1))
    return _arcs(np.concatenate(events, axis=1), lambda middle: _meets(sides, middle, low, high))


def _arcs_around(corners: Floats, sides: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Arcs in which the middle of a rectangle is inside the outline of a triangle (a rectangle may be inside it)."""
    wide = np.ptp(corners[:, :, :2], axis=1).max(axis=1) > (high - low)[:2].min()
    corners, sides = corners[wide], sides[wide]
    middle = (low + high)[:2] / 2.0
    events = _passed(sides.reshape(-1, 2, 2), middle).reshape(len(corners), 10)

    def inside(angle: Floats) -> Bools:
        turn = angle + np.arctan2(middle[1], middle[0])
        point = np.hypot(*middle) * np.stack([np.cos(turn), np.sin(turn)], axis=2)
        a, b, c = (corners[:, None, k, :2] for k in range(3))
        area = _cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v, w = (_cross(q - p, point - p) / area for p, q in ((b, c), (c, a), (a, b)))
            z = u * corners[:, None, 0, 2] + v * corners[:, None, 1, 2] + w * corners[:, None, 2, 2]
        return np.asarray((u > 0.0) & (v > 0.0) & (w > 0.0) & (z > low[2]) & (z < high[2]))

    return _arcs(events, inside)


def _passed(sides: Floats, point: Floats) -> Floats:
    """The angles (n, 2) by which a point turns about the origin onto sides (n, 2, 2); NaN where it does not."""
    start, way = sides[:, 0], sides[:, 1] - sides[:, 0]
    a, b, c = (way * way).sum(axis=1), (start * way).sum(axis=1), (start * start).sum(axis=1) - (point * point).sum()
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        share = np.stack([(-b - root) / a, (root - b) / a], axis=1)
        share = np.where((share >= 0.0) & (share <= 1.0), share, np.nan)
    onto = start[:, None] + share[..., None] * way[:, None]
    return np.asarray(np.arctan2(onto[..., 1], onto[..., 0]) - np.arctan2(point[1], point[0]))


def _arcs(events: Floats, meets: Callable[[Floats], Bools]) -> tuple[Floats, Floats]:
    """Arcs between neighbouring events (n, k), NaN for none, for which `meets` is true of their middles (n, k)."""
    starts = np.sort(np.where(np.isnan(events), 0.0, events % FULL), axis=1)
    ends = np.concatenate([starts[:, 1:], starts[:, :1] + FULL], axis=1)
    chosen = meets((starts + ends) / 2.0) & (ends > starts)
    return starts[chosen], ends[chosen]


def _meets(sides: Floats, angle: Floats, low: Floats, high: Floats) -> Bools:
    """Whether sides (n, 2, 2) meet the rectangle turned by angles (n, k)."""
    cos, sin = np.cos(angle), np.sin(angle)
    first, last = np.zeros_like(angle), np.ones_like(angle)
    points = [(cos * x + sin * y, cos * y - sin * x) for x, y in (sides[:, k].T[:, :, None] for k in range(2))]
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(2):
            start, way = points[0][axis], points[1][axis] - points[0][axis]
            near, far = (low[axis] - start) / way, (high[axis] - start) / way
            first, last = np.fmax(first, np.fmin(near, far)), np.fmin(last, np.fmax(near, far))
    return np.asarray(first <= last)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
