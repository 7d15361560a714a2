"""Near self-contacts of a mesh: pairs of its triangles without a common corner, by distances in plain NumPy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Pair = tuple[int, int, float]
BATCH = 100_000
DIRECTIONS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]]
)
"""Of the slabs that bound triangles: long thin ones are in all directions."""


def self_contacts(vertices: Floats, faces: Ints, within: float) -> list[Pair]:
    """Pairs of triangles without a common corner that are nearer than `within`, and their distance (0: they cross).

    A triangle that is lower than `within` is paired with itself.
    """
    corners = vertices[faces]
    found = [(k, k, float(h)) for k, h in enumerate(_height(corners)) if h < within]
    spans = corners @ DIRECTIONS.T
    for i, j in _box_pairs(spans.min(axis=1) - within, spans.max(axis=1) + within):
        apart = (faces[i][:, :, None] != faces[j][:, None, :]).all(axis=(1, 2))
        i, j = i[apart], j[apart]
        for _ in range(2):  # most are beyond the other's plane, or beyond one of its sides
            near = np.ones(len(i), dtype=bool)
            one, other = corners[i], corners[j]
            normal = np.cross(one[:, 1] - one[:, 0], one[:, 2] - one[:, 0])
            for k, way in enumerate(
                (normal, -normal, *(np.cross(one[:, m] - one[:, m - 1], normal) for m in range(3)))
            ):
                height = np.einsum("nj,nkj->nk", way, other - one[:, max(0, k - 2), None]).min(axis=1)
                near &= height < within * np.sqrt(_dot(way, way))
            i, j = j[near], i[near]
        if len(i):
            distance = triangle_distances(corners[i], corners[j])
            found += [(int(i[k]), int(j[k]), float(distance[k])) for k in np.flatnonzero(distance < within)]
    return found


def triangle_distances(a: Floats, b: Floats) -> Floats:
    """Distances of triangles (n, 3, 3), two and two; 0 where they cross."""
    least = np.full(len(a), np.inf)
    for one, other in ((a, b), (b, a)):
        for k in range(3):
            least = np.minimum(least, _point_distances(one[:, k], other))
            least[_pierces(one[:, k], one[:, (k + 1) % 3], other)] = 0.0
    for k in range(3):
        for m in range(3):
            distance = _segment_distances(a[:, k], a[:, (k + 1) % 3], b[:, m], b[:, (m + 1) % 3])
            least = np.minimum(least, distance)
    return least


def _dot(u: Floats, v: Floats) -> Floats:
    return np.asarray((u * v).sum(axis=-1))


def _height(corners: Floats) -> Floats:
    sides = np.roll(corners, -1, axis=1) - corners
    area = np.cross(sides[:, 0], sides[:, 1])
    return np.asarray(np.sqrt(_dot(area, area) / _dot(sides, sides).max(axis=1)))


def _point_distances(p: Floats, triangle: Floats) -> Floats:
    """To the triangle's inside; infinite where the foot is not there."""
    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    normal = np.cross(b - a, c - a)
    inside = np.ones(len(p), dtype=bool)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= _dot(np.cross(v - u, p - u), normal) >= 0.0
    return np.where(inside, np.abs(_dot(p - a, normal)) / np.sqrt(_dot(normal, normal)), np.inf)


def _pierces(p: Floats, q: Floats, triangle: Floats) -> npt.NDArray[np.bool_]:
    """Whether segments go through triangles."""
    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    normal = np.cross(b - a, c - a)
    high, low = _dot(p - a, normal), _dot(q - a, normal)
    sides = [_dot(np.cross(u - p, v - p), q - p) for u, v in ((a, b), (b, c), (c, a))]
    same = np.logical_and.reduce([s > 0.0 for s in sides]) | np.logical_and.reduce([s < 0.0 for s in sides])
    return np.asarray((high * low < 0.0) & same)


def _segment_distances(p: Floats, q: Floats, r: Floats, s: Floats) -> Floats:
    u, v, w = q - p, s - r, p - r
    uu, uv, vv, uw, vw = _dot(u, u), _dot(u, v), _dot(v, v), _dot(u, w), _dot(v, w)
    det = uu * vv - uv * uv
    at_u = np.clip(np.where(det > 1e-12 * uu * vv, (uv * vw - vv * uw) / np.where(det > 0.0, det, 1.0), 0.0), 0.0, 1.0)
    at_v = np.clip((at_u * uv + vw) / vv, 0.0, 1.0)
    at_u = np.clip((at_v * uv - uw) / uu, 0.0, 1.0)
    gap = w + at_u[:, None] * u - at_v[:, None] * v
    least = _dot(gap, gap)
    for point, start, way, length in ((p, r, v, vv), (q, r, v, vv), (r, p, u, uu), (s, p, u, uu)):
        share = np.clip(_dot(point - start, way) / length, 0.0, 1.0)
        gap = point - start - share[:, None] * way
        least = np.minimum(least, _dot(gap, gap))
    return np.asarray(np.sqrt(least))


def _box_pairs(low: Floats, high: Floats) -> Iterator[tuple[Ints, Ints]]:
    """Pairs of boxes (n, k) that meet, in batches: a tree over halves along the widest axis, walked level by level."""
    count, depth = len(low), int(np.ceil(np.log2(len(low))))
    order = np.minimum(np.arange(1 << depth), count - 1)  # the last box fills the tree up
    centre = low + high
    for level in range(depth):
        rows = order.reshape(1 << level, -1)
        axis = np.ptp(centre[rows], axis=1).argmax(axis=1)
        order = np.take_along_axis(rows, np.argsort(centre[rows, axis[:, None]], axis=1, kind="stable"), axis=1).ravel()
    lows, highs = [low[order]], [high[order]]
    for _ in range(depth):
        lows.append(lows[-1].reshape(-1, 2, low.shape[1]).min(axis=1))
        highs.append(highs[-1].reshape(-1, 2, low.shape[1]).max(axis=1))
    waiting = [(depth, np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))]
    while waiting:
        level, i, j = waiting.pop()
        if level == 0:
            one, other = np.minimum(order[i], order[j]), np.maximum(order[i], order[j])
            keys = np.unique((one * count + other)[one < other])
            yield keys // count, keys % count
            continue
        if len(i) > BATCH:
            half = len(i) // 2
            waiting += [(level, i[:half], j[:half]), (level, i[half:], j[half:])]
            continue
        i, j = np.stack([2 * i, 2 * i, 2 * i + 1, 2 * i + 1], 1).ravel(), np.stack([2 * j, 2 * j + 1] * 2, 1).ravel()
        i, j = i[i <= j], j[i <= j]
        for axis in range(low.shape[1]):
            lows_here, highs_here = lows[level - 1][:, axis], highs[level - 1][:, axis]
            meets = (lows_here[i] <= highs_here[j]) & (lows_here[j] <= highs_here[i])
            i, j = i[meets], j[meets]
        waiting.append((level - 1, i, j))
