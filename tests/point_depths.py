"""Depths by points in plain Python: a closed form for boxes, and bounds by branch and bound for any two surfaces.

The depth of two solids is the farthest that a point of one surface lies inside the other solid.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

# Points nearer than this share of the size of both surfaces lie on the surface.
ON_SURFACE = 1e-12


def boxes_depth(one: Sequence[Sequence[Any]], other: Sequence[Sequence[Any]]) -> Any:
    """The depth of two axis-aligned boxes, each by its lower and upper corner; exact for fractions.

    On a face, each coordinate can be chosen on its own, so the best point is the best along each axis.
    """
    return max(_farthest_inside(one, other), _farthest_inside(other, one))


def _farthest_inside(box: Sequence[Sequence[Any]], other: Sequence[Sequence[Any]]) -> Any:
    deepest = 0 * box[0][0]
    for axis in range(3):
        for side in (0, 1):
            rooms = []
            for a in range(3):
                low, high = (box[side][a], box[side][a]) if a == axis else (box[0][a], box[1][a])
                low, high = max(low, other[0][a]), min(high, other[1][a])
                best = min(max((other[0][a] + other[1][a]) / 2, low), high)
                rooms.append(min(best - other[0][a], other[1][a] - best) if low <= high else 0 * low)
            deepest = max(deepest, min(rooms))
    return deepest


class Bounds(NamedTuple):
    low: float
    high: float


def depth_bounds(one: Floats, other: Floats, *, closed: tuple[bool, bool] = (True, True), **how: Any) -> Bounds:
    """Bounds of the depth of two surfaces, `(n, 3, 3)` each. Points count inside closed surfaces only."""
    both = [
        farthest_inside(surface, body, **how) if is_closed else Bounds(0.0, 0.0)
        for surface, body, is_closed in ((one, other, closed[1]), (other, one, closed[0]))
    ]
    return Bounds(max(each.low for each in both), max(each.high for each in both))


def farthest_inside(surface: Floats, body: Floats, *, error: float = 2e-3, most: int = 6000) -> Bounds:
    """Bounds of the farthest that a point of a surface lies inside a closed one.

    The distance to a surface changes by at most the motion of the point, so the distance at the middle of a piece
    bounds all of the piece. Pieces that can hold the farthest point are cut in four, up to `most` of them.
    """
    middle = body.reshape(-1, 3).mean(axis=0)
    pieces, body = surface - middle, body - middle
    least = ON_SURFACE * max(np.abs(pieces).max(), np.abs(body).max())
    low, left = 0.0, 0.0
    while True:
        centres = pieces.mean(axis=1)
        reach = np.linalg.norm(pieces - centres[:, None], axis=2).max(axis=1)
        distance = distances(centres, body)
        may_enter = (distance > least) & (np.abs(windings(centres, body)) > 0.5)
        low = max(low, distance[may_enter].max(initial=0.0))
        # A point inside is farther from a middle outside than that is from the surface between them.
        bound = np.where(may_enter, reach + distance, reach - distance) + 2 * least
        pieces, bound = pieces[bound > low], bound[bound > low]
        is_done = bound <= low * (1.0 + error) + least
        left = max(left, bound[is_done].max(initial=0.0))
        pieces, bound = pieces[~is_done], bound[~is_done]
        if len(pieces) == 0 or 4 * len(pieces) > most:
            return Bounds(low, max(low, left, bound.max(initial=0.0)))
        pieces = quartered(pieces)


def quartered(triangles: Floats) -> Floats:
    """Each triangle cut in four by the middles of its sides."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.concatenate([np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])


def distances(points: Floats, triangles: Floats) -> Floats:
    """The distance of each point to the nearest of some triangles."""
    found = [_distances(part, triangles) for part in _parts(points, len(triangles))]
    return np.concatenate(found) if found else np.empty(0)


def _distances(points: Floats, triangles: Floats) -> Floats:
    p = points[:, None]
    best = np.full((len(points), len(triangles)), np.inf)
    a, b, c = np.moveaxis(triangles, 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    is_over = np.ones(best.shape, dtype=bool)
    for start, end in ((a, b), (b, c), (c, a)):
        side, to = end - start, p - start
        share = np.clip((to * side).sum(2) / np.maximum((side * side).sum(1), 1e-300), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(to - share[..., None] * side, axis=2))
        is_over &= (to * np.cross(normal, side)).sum(2) >= 0.0
    height = np.abs(((p - a) * normal).sum(2))
    nearest: Floats = np.where(is_over, np.minimum(height, best), best).min(axis=1)
    return nearest


def windings(points: Floats, triangles: Floats) -> Floats:
    """How often a surface goes around each point, by solid angles (van Oosterom and Strackee 1983); on it, a share."""
    found = [_windings(part, triangles) for part in _parts(points, len(triangles))]
    return np.concatenate(found) if found else np.empty(0)


def _windings(points: Floats, triangles: Floats) -> Floats:
    a, b, c = np.moveaxis(triangles[None] - points[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    top = (a * np.cross(b, c)).sum(2)
    bottom = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    # A triangle covers nothing for points in its plane. For points on the triangle, either side is as good.
    is_flat = np.abs(top) <= 1e-12 * la * lb * lc
    whole: Floats = np.where(is_flat, 0.0, np.arctan2(top, bottom)).sum(axis=1) / (2 * np.pi)
    return whole


def _parts(points: Floats, triangles: int, most: int = 400_000) -> list[Floats]:
    """Points in parts that need little memory."""
    step = max(1, most // max(triangles, 1))
    return [points[i : i + step] for i in range(0, len(points), step)]
