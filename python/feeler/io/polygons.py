"""Triangulates polygons: a fan if the polygon is convex, ear clipping otherwise."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from feeler.io.ears import cut_ears
from feeler.words import counted

CROSSING = "polygons cross themselves: triangles of such a polygon overlap, or stand out of it"

_NO_AREA = 1e-9
"""The area of a polygon below which it has none, as a share of its longest edge squared."""

_Points: TypeAlias = NDArray[np.float64]
"""Points of a plane, (k, 2), or one of them."""


class Triangulated(NamedTuple):
    """Triangles in the order of their polygons, and counts of defects."""

    faces: NDArray[np.int64]  # (m, 3)
    polygon: NDArray[np.int64]  # (m,) the polygon each triangle came from
    cut: int  # polygons with more than three corners
    rough: int  # polygons that cross themselves, so that their triangles overlap
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
        if size > 3:
            rough += int(_is_knotted(block, vertices).sum())
        if size == 4:
            # A fan from the one corner that is reflex serves every simple quad.
            reflex = _reflex(block, vertices)
            rough += int((reflex.sum(axis=1) > 1).sum())
            turn_back = np.argmax(reflex, axis=1)
            block = np.take_along_axis(block, (turn_back[:, None] + np.arange(4)) % 4, axis=1)
        fan = np.empty((len(block), size - 2, 3), dtype=np.int64)
        fan[:, :, 0] = block[:, :1]
        fan[:, :, 1] = block[:, 1:-1]
        fan[:, :, 2] = block[:, 2:]
        if size > 4:
            hollow = np.flatnonzero(_reflex(block, vertices).any(axis=1)).tolist()
            for row in hollow:
                fan[row], is_covered = _ears(block[row], vertices)
                rough += not is_covered
        faces[out_starts[which][:, None] + np.arange(size - 2)] = fan
    polygon = np.repeat(np.arange(len(sizes)), pieces)
    return Triangulated(faces, polygon, int((sizes > 3).sum()), rough, int(thin.sum()), first_thin)


def describe(result: Triangulated) -> tuple[list[str], list[str]]:
    """Return the notes and the doubts for the reader's report."""
    notes = []
    if result.cut:
        notes.append(counted(result.cut, "polygons with more than three corners were cut into triangles"))
    return notes, [counted(result.rough, CROSSING)] if result.rough else []


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


def _is_knotted(block: NDArray[np.int64], vertices: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell which polygons (p, k) cross themselves although no corner looks reflex: they go round more than once, as a
    pentagram does, or their area is zero and they are not on one line, as in a bow tie. Others are tested as ears."""
    knotted = np.zeros(len(block), dtype=bool)
    good = ((block >= 0) & (block < len(vertices))).all(axis=1) & ~_reflex(block, vertices).any(axis=1)
    if not good.any():
        return knotted
    points = vertices[block[good]]
    with np.errstate(all="ignore"):
        edges = np.roll(points, -1, axis=1) - points
        before = np.roll(edges, 1, axis=1)
        turns, area = np.cross(before, edges), _area_vector(points)
        largest = np.linalg.norm(turns, axis=2).max(axis=1)
        size = np.linalg.norm(area, axis=1)
        angles = np.arctan2(np.linalg.norm(turns, axis=2), (before * edges).sum(axis=2))
        winds = angles.sum(axis=1) > 3.0 * np.pi
        length = np.linalg.norm(edges, axis=2).max(axis=1)
        is_flat = (size <= _NO_AREA * length**2) & (largest > _NO_AREA * length**2)
    knotted[good] = is_flat | (winds & (size > _NO_AREA * length**2))
    return knotted


def _area_vector(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the area vectors of polygons (p, k, 3), twice their area long, after Newell."""
    relative = points - points[:, :1]
    area: NDArray[np.float64] = np.cross(relative, np.roll(relative, -1, axis=1)).sum(axis=1)
    return area


def _flat(points: NDArray[np.float64], normal: NDArray[np.float64]) -> _Points:
    """Return points (n, 3) projected along a normal, as x and y: counter-clockwise seen from the normal's tip."""
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(points, drop, axis=1)
    if (normal[drop] < 0) != (drop == 1):
        flat = flat[:, ::-1]
    return flat


def _ears(corners: NDArray[np.int64], vertices: NDArray[np.float64]) -> tuple[NDArray[np.int64], bool]:
    """Return the triangles of one polygon, seen along its area vector, and whether they cover it once."""
    points = vertices[corners]
    triangles, is_covered = cut_ears(_flat(points, _area_vector(points[None])[0]).tolist())
    ears: NDArray[np.int64] = corners[np.array(triangles)]
    return ears, is_covered


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
    ring, plane = outline, _flat(vertices[outline], normal)
    rings = [(hole, _flat(vertices[hole], normal)) for hole in holes]
    for hole, at in sorted(rings, key=lambda ring: -ring[1][:, 0].max()):
        start = int(np.argmax(at[:, 0]))
        order = np.roll(np.arange(len(hole)), -start)
        if _area(at) > 0:
            order = np.roll(order[::-1], 1)  # a hole runs against its outline
        order = np.append(order, order[0])
        tie = _seen_from(at[start], plane)
        ring = np.concatenate([ring[: tie + 1], hole[order], ring[tie:]])
        plane = np.concatenate([plane[: tie + 1], at[order], plane[tie:]])
    return ring


def _area(ring: _Points) -> float:
    """Return twice the area of a polygon in the plane, positive if it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _seen_from(point: _Points, ring: _Points) -> int:
    """Return a corner of a counter-clockwise ring that is visible from a point inside, looking to the right."""
    x, y = point.tolist()
    (ax, ay), (bx, by) = ring.T, np.roll(ring, -1, axis=0).T
    # Edges ahead have the inside on their left, so they go up.
    ahead = np.flatnonzero(((ay <= y) & (y < by)) | ((ay < y) & (y <= by)))
    hits = ax[ahead] + (y - ay[ahead]) * (bx[ahead] - ax[ahead]) / (by[ahead] - ay[ahead])
    ahead, hits = ahead[hits >= x], hits[hits >= x]
    if not len(ahead):
        # The hole is not inside: any corner will do, so take the nearest.
        return int(np.argmin((ax - x) ** 2 + (ay - y) ** 2))
    best, at = float(hits.min()), int(ahead[np.argmin(hits)])
    begins = y == ay[at] or (y != by[at] and ax[at] > bx[at])
    at = at if begins else (at + 1) % len(ring)
    tip = ring[at].tolist()
    if tip[1] == y:
        return at
    # Reflex corners may lie in between, inside the triangle of point, hit and tip: take the one with the least angle.
    a, b, c = ([x, y], [best, y], tip) if tip[1] > y else ([x, y], tip, [best, y])
    between = (_turn(a, b, ring.T) >= 0) & (_turn(b, c, ring.T) >= 0) & (_turn(c, a, ring.T) >= 0) & (ax >= x)
    least, nearest = (abs(tip[1] - y) / max(tip[0] - x, 1e-300), (tip[0] - x) ** 2 + (tip[1] - y) ** 2), at
    for i in np.flatnonzero(between).tolist():
        p = ring[i].tolist()
        if i == at or p == tip:
            continue
        angle = (abs(p[1] - y) / max(p[0] - x, 1e-300), (p[0] - x) ** 2 + (p[1] - y) ** 2)
        if angle < least and _is_open(ring[[i - 1, i, (i + 1) % len(ring)]].tolist(), [x, y]):
            least, nearest = angle, i
    return nearest


def _turn(a: Any, b: Any, c: Any) -> Any:
    """Return twice the area of triangles, from points, or from x and y of many."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _is_open(corners: list[list[float]], point: list[float]) -> bool:
    """Tell whether the inside of a ring at the second of three corners in a row is towards the point."""
    before, at, after = corners
    if _turn(before, at, after) >= 0:
        return bool(_turn(before, at, point) >= 0 and _turn(at, after, point) >= 0)
    return bool(_turn(before, at, point) >= 0 or _turn(at, after, point) >= 0)
