"""Who is right where two engines differ: exact, in whole numbers, and written apart from both.

Every float64 is a whole number over a power of two, so a common power of two turns the six corners of a pair into whole
numbers, and Python's have no limit. Two triangles meet if and only if an edge of one meets the other, so all there is
to decide is a segment against a triangle, by the signs of determinants.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Point = tuple[int, ...]
Floats = npt.NDArray[np.float64]

SIDES = ((0, 1), (1, 2), (2, 0))


def at_pose(vertices: Floats, world_from_tool: Floats) -> Floats:
    """Tool vertices in the world by feeler's contract: ((r0*x + r1*y) + r2*z) + t, each operation rounded once."""
    x, y, z = (vertices[..., axis] for axis in range(3))
    pose = world_from_tool
    rows = [((pose[i, 0] * x + pose[i, 1] * y) + pose[i, 2] * z) + pose[i, 3] for i in range(3)]
    return np.stack(rows, axis=-1)


def whole(*triangles: npt.ArrayLike) -> list[list[Point]]:
    """Corners `(3, 3)` of triangles as whole numbers, all scaled by one power of two."""
    flat = np.concatenate([np.asarray(triangle, dtype=np.float64).ravel() for triangle in triangles]).tolist()
    ratios = [number.as_integer_ratio() for number in flat]
    scale = max(bottom for _, bottom in ratios)
    numbers = [top * (scale // bottom) for top, bottom in ratios]
    points = [tuple(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
    return [points[i : i + 3] for i in range(0, len(points), 3)]


def meets(a: npt.ArrayLike, b: npt.ArrayLike) -> bool:
    """Whether two closed triangles `(3, 3)` share a point. Either may have no area, but not both."""
    p, q = whole(a, b)
    for one, other in ((p, q), (q, p)):
        if any(_normal(other)) and any(_segment_meets_triangle(one[i], one[j], other) for i, j in SIDES):
            return True
    return False


def has_area(triangle: npt.ArrayLike) -> bool:
    """Whether the corners `(3, 3)` do not lie on one line; a triangle without area is not queried."""
    (corners,) = whole(triangle)
    return any(_normal(corners))


def _minus(a: Point, b: Point) -> Point:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Point, b: Point) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _normal(t: list[Point]) -> Point:
    return _cross(_minus(t[1], t[0]), _minus(t[2], t[0]))


def _one_signed(numbers: list[int]) -> bool:
    return all(n >= 0 for n in numbers) or all(n <= 0 for n in numbers)


def _segment_meets_triangle(a: Point, b: Point, t: list[Point]) -> bool:
    normal = _normal(t)
    height_a, height_b = _dot(normal, _minus(a, t[0])), _dot(normal, _minus(b, t[0]))
    if height_a == 0 and height_b == 0:
        return _segment_meets_triangle_in_plane(a, b, t, normal)
    if height_a * height_b > 0:
        return False
    # The line through a and b meets the plane once: inside if it passes all three sides on the same hand.
    along = _minus(b, a)
    return _one_signed([_dot(along, _cross(_minus(t[i], a), _minus(t[j], a))) for i, j in SIDES])


def _segment_meets_triangle_in_plane(a: Point, b: Point, t: list[Point], normal: Point) -> bool:
    # Seen along the axis on which the plane stands steepest, nothing folds up.
    drop = max(range(3), key=lambda axis: abs(normal[axis]))
    first, second = ((1, 2), (2, 0), (0, 1))[drop]
    flat = [(p[first], p[second]) for p in (a, b, *t)]
    start, end, corners = flat[0], flat[1], flat[2:]
    inside = any(_one_signed([_turn(corners[i], corners[j], point) for i, j in SIDES]) for point in (start, end))
    return inside or any(_segments_meet(start, end, corners[i], corners[j]) for i, j in SIDES)


def _turn(a: Point, b: Point, c: Point) -> int:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _segments_meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    for axis in range(2):
        if max(a[axis], b[axis]) < min(c[axis], d[axis]) or max(c[axis], d[axis]) < min(a[axis], b[axis]):
            return False
    across = (_turn(c, d, a), _turn(c, d, b)), (_turn(a, b, c), _turn(a, b, d))
    return all(one <= 0 <= other or other <= 0 <= one for one, other in across)


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
