"""The truth about two triangles: whether and how they collide, in whole numbers, independent of every engine.

Every float64 is a whole number over a power of two, so one power of two turns the six corners of a pair into whole
numbers, which are unlimited in Python. A triangle is the set of points spanned by its three corners. The intersection
of two triangles is found by cutting one with the plane and the three sides of the other; it shows whether and how they
collide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

COPLANAR, CROSSING, TOUCHING = 0, 1, 2  # the numbers of feeler.PairKind

Point = tuple[int, ...]  # x, y, z
Homogeneous = tuple[int, ...]  # x, y, z, w: the point (x / w, y / w, z / w), w positive, no factor in common
Floats = npt.NDArray[np.float64]

SIDES = ((0, 1), (1, 2), (2, 0))


def at_pose(vertices: Floats, world_from_tool: Floats) -> Floats:
    """Tool vertices in the world by feeler's contract: ((r0*x + r1*y) + r2*z) + t, each operation rounded once."""
    x, y, z = (vertices[..., axis] for axis in range(3))
    pose = world_from_tool
    rows = [((pose[i, 0] * x + pose[i, 1] * y) + pose[i, 2] * z) + pose[i, 3] for i in range(3)]
    return np.stack(rows, axis=-1)


def kind_of_pair(tool_triangle: npt.ArrayLike, mockup_triangle: npt.ArrayLike) -> int | None:
    """How two closed triangles `(3, 3)` meet, None when they do not.

    The tool's triangle may have lost its area by rounding at its pose; the mock-up's has one.
    """
    p, q = whole(tool_triangle, mockup_triangle)
    n, m = _normal(q), _normal(p)
    if not any(n):
        raise ValueError("the mock-up's triangle has no area: it is not queried")
    p_heights = [_dot(n, _minus(x, q[0])) for x in p]
    q_heights = [_dot(m, _minus(x, p[0])) for x in q]
    # The plane of one with the other strictly on one side of it holds them apart.
    if any(min(heights) > 0 or max(heights) < 0 for heights in (p_heights, q_heights)):
        return None
    shared = shared_points(p, q)
    if not shared:
        return None
    if not any(p_heights):
        return COPLANAR
    two_sided = all(min(heights) < 0 < max(heights) for heights in (p_heights, q_heights))
    return CROSSING if two_sided and len(shared) > 1 else TOUCHING


def meets(tool_triangle: npt.ArrayLike, mockup_triangle: npt.ArrayLike) -> bool:
    """Whether two closed triangles `(3, 3)` share a point."""
    return kind_of_pair(tool_triangle, mockup_triangle) is not None


def has_area(triangle: npt.ArrayLike) -> bool:
    """Whether the corners `(3, 3)` do not lie on one line; a triangle without area is not queried."""
    (corners,) = whole(triangle)
    return any(_normal(corners))


def judge(mockup: Any, tool: Any, world_from_tool: Floats, pairs: npt.NDArray[np.uint32]) -> list[bool | None]:
    """Whether each (tool triangle, mock-up triangle) meets at the pose; None if one has no area and is not queried."""
    verdicts: list[bool | None] = []
    for i, j in pairs.tolist():
        corners, static = tool.vertices[tool.faces[i]], mockup.vertices[mockup.faces[j]]
        if has_area(corners) and has_area(static):
            verdicts.append(meets(at_pose(corners, world_from_tool), static))
        else:
            verdicts.append(None)
    return verdicts


def whole(*triangles: npt.ArrayLike) -> list[list[Point]]:
    """Corners `(3, 3)` of triangles as whole numbers, all scaled by one power of two."""
    flat = np.concatenate([np.asarray(triangle, dtype=np.float64).ravel() for triangle in triangles]).tolist()
    ratios = [number.as_integer_ratio() for number in flat]
    scale = max(bottom for _, bottom in ratios)
    numbers = [top * (scale // bottom) for top, bottom in ratios]
    points = [tuple(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
    return [points[i : i + 3] for i in range(0, len(points), 3)]


def shared_points(p: Sequence[Point], q: Sequence[Point]) -> set[Homogeneous]:
    """Corners of the convex set that two triangles share; empty when they share nothing. `q` must have an area."""
    n = _normal(q)
    polygon: list[Homogeneous] = [(*corner, 1) for corner in p]
    for outward in (n, _minus((0, 0, 0), n)):  # the plane of q: two closed half-spaces
        polygon = _cut(polygon, outward, q[0])
    for i, j in SIDES:  # its three sides, which are upright on it and face outwards
        polygon = _cut(polygon, _cross(_minus(q[j], q[i]), n), q[i])
    return set(polygon)


def _cut(polygon: list[Homogeneous], outward: Point, corner: Point) -> list[Homogeneous]:
    """The part of a convex polygon (also a segment or a point) in a closed half-space."""
    plane = (*outward, -_dot(outward, corner))
    heights = [sum(a * b for a, b in zip(plane, x, strict=True)) for x in polygon]  # times w, which is positive
    kept = []
    for i, (x, h) in enumerate(zip(polygon, heights, strict=True)):
        y, k = polygon[i - 1], heights[i - 1]
        if h * k < 0:
            between = [abs(k) * a + abs(h) * b for a, b in zip(x, y, strict=True)]
            factor = math.gcd(*between)
            kept.append(tuple(a // factor for a in between))
        if h <= 0:
            kept.append(x)
    return kept


def _minus(a: Point, b: Point) -> Point:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Point, b: Point) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _normal(t: Sequence[Point]) -> Point:
    return _cross(_minus(t[1], t[0]), _minus(t[2], t[0]))
