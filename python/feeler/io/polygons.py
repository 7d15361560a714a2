"""Polygons to triangles: a fan where the polygon is convex, ears where it is not."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MAX_EAR_CORNERS = 2000
"""Above this a polygon that is not convex is cut as a fan: looking for ears takes the cube of the corners at worst."""

_MANY = 100  # corners from which on NumPy is faster than a loop over them


class Triangulated(NamedTuple):
    """Triangles in the order of their polygons, and what was met on the way."""

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
    """Return the notes a reader adds to its report."""
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
    """Tell whether a corner that is left lies in the triangle, or on it; those that equal its corners do not count."""
    x, y = plane[left].T
    inside = np.ones(len(left), dtype=bool)
    for (from_x, from_y), (to_x, to_y) in zip(plane[[a, b, c]].tolist(), plane[[b, c, a]].tolist(), strict=True):
        inside &= (to_x - from_x) * (y - from_y) - (to_y - from_y) * (x - from_x) >= 0
        inside &= (x != from_x) | (y != from_y)
    return bool(inside.any())


def _reflex(block: NDArray[np.int64], vertices: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell, for polygons (p, k), which corners turn back; none where a corner does not exist or is not finite."""
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


def _ears(corners: NDArray[np.int64], vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut ears off one polygon, seen along its area vector. What has no ear left is cut as a fan."""
    points = vertices[corners]
    normal = _area_vector(points[None])[0]
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(points, drop, axis=1)
    if (normal[drop] < 0) != (drop == 1):
        flat = flat[:, ::-1]  # so that the polygon runs counter-clockwise
    xy: list[list[float]] = flat.tolist()

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
