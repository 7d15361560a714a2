"""Ears of one polygon in the plane: triangles that cover it once.

An ear is a corner whose triangle lies inside the polygon; cut off, it leaves a polygon with a corner less (Meisters
1975). If a corner is in the triangle, then one that bends inwards is, for the one nearest to the tip does. So only
these are looked for (as in Held's FIST, 2001), in rows of about the square root of their number.

A corner is tried again only when a neighbour of it was cut, or the corner that lay in its triangle. Corners wait in a
queue, so that every second one around the polygon is cut first and triangles stay compact.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from collections import deque
from typing import NamedTuple

Point = list[float]
Triangle = tuple[int, int, int]

_ROUNDING = 1e-9
"""Of the area of the polygon: triangles that are turned over by less are flat. They come from rounding."""

_MARGIN = 1e-9
"""Of the width of a triangle: by so much its extent in a row is widened, so that rounding loses no corner."""


def cut_ears(xy: list[Point]) -> tuple[list[Triangle], bool]:
    """Return the triangles of a counter-clockwise polygon of three corners or more, and whether they cover it once.

    A polygon that crosses itself may have no ear left. The rest of it is then cut as a fan.
    """
    count = left = len(xy)
    before, after = [*range(-1, count - 1)], [*range(1, count + 1)]
    before[0], after[-1] = count - 1, 0
    is_left = [True] * count
    changes = [0] * count  # how often a neighbour of the corner was cut
    todo = deque((corner, 0) for corner in range(count))
    waiting: dict[int, list[tuple[int, int]]] = {}  # for the corner in their triangle to go
    triangles: list[Triangle] = []

    def bends_in(at: int) -> bool:
        return _turn(xy[before[at]], xy[at], xy[after[at]]) <= 0.0

    bends = _Bends(xy, [corner for corner in range(count) if bends_in(corner)])
    straightened = 0
    while left > 3 and todo:
        at, change = todo.popleft()
        if change != changes[at] or not is_left[at] or bends_in(at):
            continue
        a, c = before[at], after[at]
        inside = bends.first_in(a, at, c, is_left)
        if inside is not None:
            waiting.setdefault(inside, []).append((at, change))
            continue
        triangles.append((a, at, c))
        bent = [corner for corner in (a, c) if bends_in(corner)]
        after[a], before[c] = c, a
        is_left[at] = False
        left -= 1
        todo += waiting.pop(at, [])
        for corner in (a, c):
            changes[corner] += 1
            todo.append((corner, changes[corner]))
        straightened += sum(not bends_in(corner) for corner in bent)
        if 2 * straightened > bends.count:
            bends = _Bends(xy, [corner for corner in bends.corners() if is_left[corner] and bends_in(corner)])
            straightened = 0
    rest = [corner for corner in range(count) if is_left[corner]]
    fan = [(rest[0], b, c) for b, c in itertools.pairwise(rest[1:])]
    whole = sum(_turn(xy[a], xy[b], xy[c]) for a, b, c in triangles + fan)
    is_covered = all(_turn(xy[a], xy[b], xy[c]) >= -_ROUNDING * abs(whole) for a, b, c in fan)
    return triangles + fan, is_covered


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


class _Row(NamedTuple):
    corners: list[int]  # by x
    x: list[float]
    low: float  # the least and the largest y
    high: float


class _Bends:
    """The corners that bend inwards, or not at all, in rows from low y to high."""

    def __init__(self, xy: list[Point], corners: list[int]) -> None:
        self.xy = xy
        self.count = len(corners)
        upwards = sorted(corners, key=lambda corner: (xy[corner][1], xy[corner][0]))
        size = math.isqrt(self.count) + 1
        self.rows: list[_Row] = []
        for start in range(0, self.count, size):
            row = sorted(upwards[start : start + size], key=lambda corner: xy[corner][0])
            x, y = [xy[corner][0] for corner in row], [xy[corner][1] for corner in row]
            self.rows.append(_Row(row, x, min(y), max(y)))
        self.lows, self.highs = [row.low for row in self.rows], [row.high for row in self.rows]

    def corners(self) -> list[int]:
        """Return all of them."""
        return [corner for row in self.rows for corner in row.corners]

    def first_in(self, a: int, b: int, c: int, is_left: list[bool]) -> int | None:
        """Return one that is left and lies in the triangle or on it, other than where its corners are."""
        xy = self.xy
        corners = (xy[a], xy[b], xy[c])
        low, middle, high = sorted(corners, key=lambda point: point[1])
        edges = ((low, high), (low, middle), (middle, high))
        xs = (low[0], middle[0], high[0])
        margin = _MARGIN * (max(xs) - min(xs))
        for row in self.rows[bisect_left(self.highs, low[1]) : bisect_right(self.lows, high[1])]:
            extent = [x for p, q in edges for x in _extent(p, q, row.low, row.high)]
            if not extent:
                continue
            start = bisect_left(row.x, min(extent) - margin)
            for corner in row.corners[start : bisect_right(row.x, max(extent) + margin)]:
                point = xy[corner]
                if (
                    is_left[corner]
                    and _turn(corners[0], corners[1], point) >= 0.0
                    and _turn(corners[1], corners[2], point) >= 0.0
                    and _turn(corners[2], corners[0], point) >= 0.0
                    and point not in corners
                ):
                    return corner
        return None


def _extent(p: Point, q: Point, low: float, high: float) -> tuple[float, ...]:
    """Return the x at both ends of the piece of an edge, from p up to q, whose y is from low to high."""
    if q[1] < low or p[1] > high:
        return ()
    if low <= p[1] and q[1] <= high:
        return p[0], q[0]
    slope = (q[0] - p[0]) / (q[1] - p[1])
    return p[0] + (max(low, p[1]) - p[1]) * slope, p[0] + (min(high, q[1]) - p[1]) * slope
