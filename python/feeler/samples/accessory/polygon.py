"""Plane polygons: triangles of one with holes, and outlines with round corners."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..mesh import Floats, Ints, times

MARGIN_MM = 1.5e-3
"""No triangle is lower or nearer to a corner of another one, where that can be: three steps of the vertex grid."""
LOW_MM = 5e-4
"""A step of the vertex grid."""
LEAST_GAIN = 1e-9
"""By which the sine of an angle has to grow: below it are rounding, and four corners on one circle."""
PASSES = ((MARGIN_MM, MARGIN_MM), (0.0, MARGIN_MM), (0.0, 0.0))
"""How near to a corner and how low ears may be: better one that is near than none, better a low one than none."""


def triangulated(loops: Sequence[Floats]) -> Ints:
    """Triangles of a polygon: `loops[0]` counter-clockwise, holes clockwise, each (n, 2).

    Holes are joined to the outline by bridges, then ears are clipped. There are vertices + 2 holes - 2 triangles, whose
    indices run through all loops.
    """
    points = np.concatenate(list(loops))
    return _clipped(points, _bridged(points, [len(loop) for loop in loops]))


def _bridged(points: Floats, sizes: list[int]) -> list[int]:
    """One closed walk along the outline and all holes."""
    starts = np.cumsum([0, *sizes])
    walk = list(range(sizes[0]))
    rest = [list(range(starts[k], starts[k + 1])) for k in range(1, len(sizes))]
    rest.sort(key=lambda hole: -float(points[hole, 0].max()))
    while rest:
        edges = np.array([(a, b) for loop in (walk, *rest) for a, b in zip(loop, [*loop[1:], loop[0]], strict=True)])
        for number, hole in enumerate(rest):
            best = hole[int(np.argmax(points[hole, 0]))]
            place = _seen(points, walk, edges, best)
            if place is not None:
                k = hole.index(best)
                walk[place + 1 : place + 1] = [*hole[k:], *hole[: k + 1], walk[place]]
                del rest[number]
                break
        else:
            raise ValueError("no bridge leads to a hole: loops of the face cross")
    return walk


def _seen(points: Floats, walk: list[int], edges: Ints, start: int) -> int | None:
    """The place in the walk of the nearest vertex that a straight bridge from `start` reaches."""
    p = points[start]
    corners = points[walk]
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    convex = _cross(corners - before, after - corners) >= 0.0
    left, right = _cross(after - corners, p - corners) > 0.0, _cross(corners - before, p - corners) > 0.0
    inside = np.where(convex, left & right, left | right)
    distance = ((corners - p) ** 2).sum(axis=1)
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    everywhere = points[np.unique(edges)]
    for place in np.argsort(distance, kind="stable"):
        if not inside[place]:
            continue
        end = walk[place]
        q = points[end]
        free = (edges != start).all(axis=1) & (edges != end).all(axis=1)
        u, v = a[free], b[free]
        crosses = (_cross(q - p, u - p) * _cross(q - p, v - p) <= 0.0) & (
            _cross(v - u, p - u) * _cross(v - u, q - u) <= 0.0
        )
        way = q - p
        share = np.clip(times(everywhere - p, way) / times(way, way), 0.0, 1.0)[:, None]
        near = (((everywhere - p - share * way) ** 2).sum(axis=1) < MARGIN_MM**2).sum() > 2  # both ends are
        if not crosses.any() and not near:
            return int(place)
    return None


def _clipped(points: Floats, walk: list[int]) -> Ints:
    """Triangles of a weakly simple closed walk by ear clipping."""
    n = len(walk)
    xy = points[walk]
    x, y = xy[:, 0].tolist(), xy[:, 1].tolist()
    all_x, all_y = np.ascontiguousarray(xy[:, 0]), np.ascontiguousarray(xy[:, 1])
    ahead, back = [*range(1, n), 0], [n - 1, *range(n - 1)]
    least = 1e-10 * float(np.ptp(xy, axis=0).max()) ** 2

    def is_ear(a: int, b: int, c: int, margin: float, low: float) -> bool:
        ax, ay, bx, by, cx, cy = x[a], y[a], x[b], y[b], x[c], y[c]
        ux, uy = cx - ax, cy - ay
        area, long = (bx - ax) * uy - (by - ay) * ux, ux * ux + uy * uy
        if area <= least or area * area < low * low * long:
            return False
        beside = (all_x >= min(ax, bx, cx) - margin) & (all_x <= max(ax, bx, cx) + margin)
        beside &= (all_y >= min(ay, by, cy) - margin) & (all_y <= max(ay, by, cy) + margin)
        for k in np.flatnonzero(beside).tolist():
            px, py = x[k], y[k]
            if (px, py) in ((ax, ay), (bx, by), (cx, cy)):
                continue
            share = min(1.0, max(0.0, ((px - ax) * ux + (py - ay) * uy) / long))
            if (px - ax - share * ux) ** 2 + (py - ay - share * uy) ** 2 < margin * margin:
                return False
            if (
                (bx - ax) * (py - ay) >= (by - ay) * (px - ax)
                and (cx - bx) * (py - by) >= (cy - by) * (px - bx)
                and (ax - cx) * (py - cy) >= (ay - cy) * (px - cx)
            ):
                return False
        return True

    triangles: list[tuple[int, int, int]] = []
    refused: dict[int, tuple[int, int, int]] = {}
    here, left, misses, each = 0, n, 0, 0
    while left > 3 and misses <= left:
        a, c = back[here], ahead[here]
        if refused.get(here) != (a, c, each) and is_ear(a, here, c, *PASSES[each]):
            triangles.append((walk[a], walk[here], walk[c]))
            ahead[a], back[c] = c, a
            left -= 1
            misses = each = 0
            here = ahead[c]  # every other corner, not one fan
        else:
            refused[here] = (a, c, each)
            here = c
            misses += 1
            if misses == left and each + 1 < len(PASSES):
                misses, each = 0, each + 1
    if left > 3:
        raise ValueError(f"a face cannot be cut into triangles: {left} corners are left of {n}")
    triangles.append((walk[back[here]], walk[here], walk[ahead[here]]))
    return _lifted(points, np.array(triangles, dtype=np.int64))


def _lifted(points: Floats, triangles: Ints) -> Ints:
    """The triangles, with diagonals exchanged if one is so low that the vertex grid could turn it over.

    The diagonal of two triangles is exchanged for the other one where their least angle grows, until none does: that is
    Delaunay's triangulation, which has a low triangle only where each has. First about the low ones: mostly enough.
    """
    rows = triangles.tolist()
    for share in (LOW_MM, np.inf):
        low = _height(points[np.array(rows)]) < share
        if (_height(points[np.array(rows)]) < LOW_MM).any():
            _exchange(points.tolist(), rows, np.flatnonzero(low).tolist())
    return np.array(rows, dtype=np.int64)


def _exchange(points: list[list[float]], rows: list[list[int]], about: list[int]) -> None:
    """Exchanges diagonals in place, beginning with those of the triangles numbered in `about`."""
    owner = {(row[k - 1], row[k]): n for n, row in enumerate(rows) for k in range(3)}
    waiting = [(rows[n][k - 1], rows[n][k]) for n in about for k in range(3)]
    while waiting:
        a, b = waiting.pop()
        one, other = owner.get((a, b)), owner.get((b, a))
        if one is None or other is None:
            continue  # of the border, or exchanged meanwhile
        c, d = (next(each for each in rows[n] if each not in (a, b)) for n in (one, other))
        p, q, r, s = points[a], points[b], points[c], points[d]
        if min(_sharpness(p, s, r), _sharpness(s, q, r)) > min(_sharpness(p, q, r), _sharpness(q, p, s)) + LEAST_GAIN:
            rows[one], rows[other] = [a, d, c], [d, b, c]
            del owner[a, b], owner[b, a]
            owner |= {(row[k - 1], row[k]): n for n, row in ((one, rows[one]), (other, rows[other])) for k in range(3)}
            waiting += [(a, d), (d, b), (b, c), (c, a)]


def _sharpness(a: list[float], b: list[float], c: list[float]) -> float:
    """The sine of the least angle of a triangle; negative for one that is turned over."""
    u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])
    w = (v[0] - u[0], v[1] - u[1])
    squares = sorted(each[0] * each[0] + each[1] * each[1] for each in (u, v, w))
    return (u[0] * v[1] - u[1] * v[0]) / math.sqrt(squares[1] * squares[2])


def _height(corners: Floats) -> Floats:
    """The least height of each triangle (n, 3, 2); negative for one that is turned over."""
    sides = corners - np.roll(corners, -1, axis=1)
    return np.asarray(_cross(sides[:, 0], sides[:, 1]) / np.sqrt((sides**2).sum(axis=2).max(axis=1)))


def _cross(u: Floats, v: Floats) -> Floats:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def rounded(corners: Floats, radius: float, pieces: Sequence[int] | int) -> Floats:
    """A counter-clockwise polygon (k, 2) with its corners turned into arcs of `pieces` chords."""
    counts = [pieces] * len(corners) if isinstance(pieces, int) else pieces
    out: list[Floats] = []
    for k, corner in enumerate(corners):
        back, on = corners[k - 1] - corner, corners[(k + 1) % len(corners)] - corner
        u, v = back / np.hypot(*back), on / np.hypot(*on)
        turn = float(np.arctan2(_cross(-u, v), times(-u, v)))  # positive to the left
        reach = radius * np.tan(abs(turn) / 2.0)
        centre = corner + u * reach + np.sign(turn) * radius * np.array([u[1], -u[0]])
        start = float(np.arctan2(*(corner + u * reach - centre)[::-1]))
        angle = start + np.linspace(0.0, turn, counts[k] + 1)
        out.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.concatenate(out)


def offset(corners: Floats, distance: float) -> Floats:
    """A counter-clockwise polygon (k, 2) with each side moved outwards by a distance."""
    side = np.roll(corners, -1, axis=0) - corners
    normal = np.stack([side[:, 1], -side[:, 0]], axis=1) / np.hypot(side[:, 0], side[:, 1])[:, None]
    height = (normal * corners).sum(axis=1) + distance
    return meeting(np.roll(normal, 1, axis=0), np.roll(height, 1), normal, height)


def meeting(normal_a: Floats, height_a: Floats, normal_b: Floats, height_b: Floats) -> Floats:
    """Where lines n . x = h meet, two and two: (k, 2)."""
    det = _cross(normal_a, normal_b)
    x = (height_a * normal_b[:, 1] - height_b * normal_a[:, 1]) / det
    y = (height_b * normal_a[:, 0] - height_a * normal_b[:, 0]) / det
    return np.stack([x, y], axis=1)


def support(normals: Floats, centres: Floats, radii: Floats) -> Floats:
    """The convex polygon (k, 2) with sides of the given normals (k, 2) that holds all circles and touches some."""
    height = (times(normals, centres.T) + radii).max(axis=1)
    return meeting(np.roll(normals, 1, axis=0), np.roll(height, 1), normals, height)


def along(outline: Floats, shares: Floats) -> tuple[Floats, Floats]:
    """Points (k, 2) and outward normals (k, 2) at shares (k,) of a closed outline's length, counter-clockwise."""
    closed = np.concatenate([outline, outline[:1]])
    step = np.diff(closed, axis=0)
    length = np.hypot(step[:, 0], step[:, 1])
    way = np.concatenate([[0.0], np.cumsum(length)])
    at = (shares % 1.0) * way[-1]
    k = np.clip(np.searchsorted(way, at, side="right") - 1, 0, len(step) - 1)
    points = closed[k] + step[k] * ((at - way[k]) / length[k])[:, None]
    return points, np.stack([step[k, 1], -step[k, 0]], axis=1) / length[k][:, None]


def rectangle(x: float, y: float, radius: float, pieces: int) -> Floats:
    """A rectangle about the origin with round corners, (n, 2)."""
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * [x / 2.0, y / 2.0]
    return rounded(corners, radius, pieces)
