"""Triangulates polygons: a fan if the polygon is convex, ear clipping otherwise."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

MAX_EAR_CORNERS = 2000
"""Larger polygons that are not convex are cut as a fan: ear clipping takes cubic time at worst."""

_MANY = 100  # corners from which NumPy is faster than a loop


_Ring: TypeAlias = list[tuple[int, list[float]]]
"""A polygon as (vertex, [x, y]) of each corner."""


class Triangulated(NamedTuple):
    """Triangles in the order of their polygons, and counts of defects."""

    faces: NDArray[np.int64]  # (m, 3)
    polygon: NDArray[np.int64]  # (m,) the polygon each triangle came from
    cut: int  # polygons with more than three corners
    rough: int  # polygons that are not convex but had to be cut as a fan
    thin: int  # polygons with fewer than three corners: they have no triangle
    first_thin: int  # index of the first of those, or -1


def triangulate(corners: NDArray[np.int64], sizes: NDArray[np.int64], vertices: NDArray[np.float64]) -> Triangulated:
    """Triangulate polygons given as one row of corners and the number of corners of each. Order is kept."""
    thin = sizes < 3
    first_thin = int(np.argmax(thin)) if thin.any() else -1
    starts = np.cumsum(sizes) - sizes
    pieces = np.maximum(sizes - 2, 0)
    out_starts = np.cumsum(pieces) - pieces
    faces = np.empty((int(pieces.sum()), 3), dtype=np.int64)
    rough = 0
    for size in np.unique(sizes[~thin]).tolist():
        which = np.flatnonzero(sizes == size)
        block = corners[starts[which][:, None] + np.arange(size)]
        if size == 4:
            # A fan from the one corner that is reflex serves every simple quad.
            turn_back = np.argmax(_reflex(block, vertices), axis=1)
            block = np.take_along_axis(block, (turn_back[:, None] + np.arange(4)) % 4, axis=1)
        fan = np.empty((len(block), size - 2, 3), dtype=np.int64)
        fan[:, :, 0] = block[:, :1]
        fan[:, :, 1] = block[:, 1:-1]
        fan[:, :, 2] = block[:, 2:]
        if size > 4:
            hollow = np.flatnonzero(_reflex(block, vertices).any(axis=1)).tolist()
            if size > MAX_EAR_CORNERS:
                rough += len(hollow)
            else:
                for row in hollow:
                    fan[row] = _ears(block[row], vertices)
        faces[out_starts[which][:, None] + np.arange(size - 2)] = fan
    polygon = np.repeat(np.arange(len(sizes)), pieces)
    return Triangulated(faces, polygon, int((sizes > 3).sum()), rough, int(thin.sum()), first_thin)


def describe(result: Triangulated) -> list[str]:
    """Return the notes for the reader's report."""
    notes = []
    if result.cut:
        notes.append(f"{result.cut:,} polygons with more than three corners were cut into triangles")
    if result.rough:
        notes.append(
            f"{result.rough:,} hollow polygons with more than {MAX_EAR_CORNERS:,} corners were cut as fans: "
            "their triangles may overlap"
        )
    return notes


def _any_inside(left: NDArray[np.int64], a: int, b: int, c: int, plane: NDArray[np.float64]) -> bool:
    """Tell whether a remaining corner lies in the triangle, or on it; those equal to its corners do not count."""
    x, y = plane[left].T
    inside = np.ones(len(left), dtype=bool)
    for (from_x, from_y), (to_x, to_y) in zip(plane[[a, b, c]].tolist(), plane[[b, c, a]].tolist(), strict=True):
        inside &= (to_x - from_x) * (y - from_y) - (to_y - from_y) * (x - from_x) >= 0
        inside &= (x != from_x) | (y != from_y)
    return bool(inside.any())


def _reflex(block: NDArray[np.int64], vertices: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell, for polygons (p, k), which corners are reflex; none if a corner does not exist or is not finite."""
    reflex = np.zeros(block.shape, dtype=bool)
    good = ((block >= 0) & (block < len(vertices))).all(axis=1)
    if good.any():
        points = vertices[block[good]]
        with np.errstate(all="ignore"):
            edges = np.roll(points, -1, axis=1) - points
            turns = np.cross(np.roll(edges, 1, axis=1), edges)
            reflex[good] = (turns * _area_vector(points)[:, None, :]).sum(axis=2) < 0
    return reflex


def _area_vector(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the area vectors of polygons (p, k, 3), twice their area long, after Newell."""
    relative = points - points[:, :1]
    area: NDArray[np.float64] = np.cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    return area


def _flat(points: NDArray[np.float64], normal: NDArray[np.float64]) -> list[list[float]]:
    """Return points (n, 3) projected along a normal, as x and y: counter-clockwise seen from the normal's tip."""
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(points, drop, axis=1)
    if (normal[drop] < 0) != (drop == 1):
        flat = flat[:, ::-1]
    rows: list[list[float]] = flat.tolist()
    return rows


def _ears(corners: NDArray[np.int64], vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut ears off one polygon, seen along its area vector. A rest without an ear is cut as a fan."""
    xy = _flat(vertices[corners], _area_vector(vertices[corners][None])[0])

    def turn(a: int, b: int, c: int) -> float:
        return (xy[b][0] - xy[a][0]) * (xy[c][1] - xy[a][1]) - (xy[b][1] - xy[a][1]) * (xy[c][0] - xy[a][0])

    def is_ear(a: int, b: int, c: int) -> bool:
        if turn(a, b, c) <= 0:
            return False
        if len(left) > _MANY:
            return not _any_inside(np.array(left), a, b, c, plane)
        return not any(
            turn(a, b, p) >= 0 and turn(b, c, p) >= 0 and turn(c, a, p) >= 0
            for p in left
            if xy[p] not in (xy[a], xy[b], xy[c])
        )

    plane = np.array(xy)
    left = list(range(len(corners)))
    triangles: list[list[int]] = []
    while len(left) > 3:
        for at in range(len(left)):
            ear = [left[at - 1], left[at], left[(at + 1) % len(left)]]
            if is_ear(*ear):
                triangles.append(ear)
                del left[at]
                break
        else:
            break
    triangles += [[left[0], left[i], left[i + 1]] for i in range(1, len(left) - 1)]
    ears: NDArray[np.int64] = corners[np.array(triangles)]
    return ears


def bridged(
    outline: NDArray[np.int64], holes: list[NDArray[np.int64]], vertices: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return one polygon for an outline with holes: it goes to each hole, around it, and back on the same line.

    The hole with the rightmost corner goes first, and is joined to a visible corner of the polygon (after Eberly).
    Holes with an invalid corner, or with fewer than three, are skipped.
    """
    count = len(vertices)
    holes = [hole for hole in holes if len(hole) > 2 and ((hole >= 0) & (hole < count)).all()]
    if not holes or len(outline) < 3 or not ((outline >= 0) & (outline < count)).all():
        return outline
    normal = _area_vector(vertices[outline][None])[0]
    if not np.isfinite(normal).all():
        return outline
    rows = [list(zip(ring.tolist(), _flat(vertices[ring], normal), strict=True)) for ring in (outline, *holes)]
    left, rings = rows[0], rows[1:]
    for ring in sorted(rings, key=lambda ring: -max(at[0] for _, at in ring)):
        if _area(ring) > 0:
            ring.reverse()  # a hole runs against its outline
        start = max(range(len(ring)), key=lambda i: ring[i][1][0])
        ring = ring[start:] + ring[:start]
        tie = _seen_from(ring[0][1], left)
        left[tie + 1 : tie + 1] = [*ring, ring[0], left[tie]]
    return np.array([corner for corner, _ in left], dtype=np.int64)


def _area(ring: _Ring) -> float:
    return sum(a[1][0] * b[1][1] - b[1][0] * a[1][1] for a, b in zip(ring, ring[1:] + ring[:1], strict=True))


def _seen_from(point: list[float], ring: _Ring) -> int:
    """Return a corner of a counter-clockwise ring that is visible from a point inside, looking to the right."""
    x, y = point
    best, at = float("inf"), -1
    for i, (_, a) in enumerate(ring):
        b = ring[(i + 1) % len(ring)][1]
        # Edges ahead have the inside on their left, so they go up.
        if a[1] <= y < b[1] or (a[1] < y <= b[1]):
            hit = a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            if x <= hit < best:
                begins = y == a[1] or (y != b[1] and a[0] > b[0])
                best, at = hit, i if begins else (i + 1) % len(ring)
    if at < 0:
        # The hole is not inside: any corner will do, so take the nearest.
        return min(range(len(ring)), key=lambda i: (ring[i][1][0] - x) ** 2 + (ring[i][1][1] - y) ** 2)
    tip = ring[at][1]
    if tip[1] == y:
        return at
    # Reflex corners may lie in between, inside the triangle of point, hit and tip: take the one with the least angle.
    corners = ([x, y], [best, y], tip) if tip[1] > y else ([x, y], tip, [best, y])
    least, nearest = (abs(tip[1] - y) / max(tip[0] - x, 1e-300), (tip[0] - x) ** 2 + (tip[1] - y) ** 2), at
    for i, (_, p) in enumerate(ring):
        if i == at or p == tip or p[0] < x or not _inside(p, corners):
            continue
        angle = (abs(p[1] - y) / max(p[0] - x, 1e-300), (p[0] - x) ** 2 + (p[1] - y) ** 2)
        if angle < least and _is_open(ring, i, point):
            least, nearest = angle, i
    return nearest


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _inside(p: list[float], corners: tuple[list[float], list[float], list[float]]) -> bool:
    a, b, c = corners
    return _turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0


def _is_open(ring: _Ring, i: int, point: list[float]) -> bool:
    """Tell whether the inside of the ring at its corner `i` is towards the point."""
    before, at, after = ring[i - 1][1], ring[i][1], ring[(i + 1) % len(ring)][1]
    if _turn(before, at, after) >= 0:
        return _turn(before, at, point) >= 0 and _turn(at, after, point) >= 0
    return _turn(before, at, point) >= 0 or _turn(at, after, point) >= 0
