"""The depth of any two closed meshes, by branch and bound over pieces of triangles of one surface.

The distance to a triangle is convex, so on a piece it is largest at a corner. The minimum of these maxima over all
triangles of the other surface is an upper bound of the depth on the piece. Centroids and corners inside the other mesh
give lower bounds. Winding numbers decide inside or outside; a piece that meets no triangle lies on one side.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .shapes import Bools, Floats, Mesh

PRECISION = 1e-5
MOST_ROUNDS, FEW_ROUNDS = 60, 7
MOST_PAIRS = 1_000_000
NOTHING = 1e-15
"""Metres. Smaller depths count as 0."""
Indices = npt.NDArray[np.int64]


def depth(a: Mesh, b: Mesh, precision: float = PRECISION) -> tuple[float, float]:
    """Bounds of D of two closed meshes."""
    # A few rounds each way first: a lower bound from one surface prunes most pieces of the other.
    known = max(deepest(a, b, 0.0, precision, FEW_ROUNDS)[0], deepest(b, a, 0.0, precision, FEW_ROUNDS)[0])
    first = deepest(a, b, known, precision)
    second = deepest(b, a, first[0], precision)
    return max(first[0], second[0]), max(first[1], second[1])


def deepest(
    a: Mesh, b: Mesh, known: float = 0.0, precision: float = PRECISION, rounds: int = MOST_ROUNDS
) -> tuple[float, float]:
    """Bounds of the largest distance to the surface of `b`, over points of the surface of `a` inside `b`.

    known: a lower bound of the depth; pieces below it are pruned.
    """
    pieces, targets = a[0][a[1]], b[0][b[1]]
    low, high = targets.min(axis=(0, 1)), targets.max(axis=(0, 1))
    pieces = pieces[(pieces.min(axis=1) <= high).all(axis=1) & (pieces.max(axis=1) >= low).all(axis=1)]
    piece, target = _near(pieces, targets)
    side = np.zeros(len(pieces), np.int8)  # 1 inside, 0 unknown
    best = known
    for _ in range(rounds):
        if len(pieces) == 0:
            break
        starts = np.searchsorted(piece, np.arange(len(pieces)))
        middle = pieces.mean(axis=1)
        radius = np.linalg.norm(pieces - middle[:, None], axis=-1).max(axis=1)
        points = np.concatenate([pieces, middle[:, None]], axis=1)
        distance = distances(points[piece], targets[target])
        of_middle = np.minimum.reduceat(distance[:, 3], starts)
        at_most = np.minimum(np.minimum.reduceat(distance[:, :3].max(axis=1), starts), of_middle + radius)
        # Inside or outside: decided once for each piece that meets no triangle.
        reach = distance[:, 3] <= radius[piece]
        may_meet = reach & ~_is_clear(pieces[piece], targets[target])
        is_whole = ~np.logical_or.reduceat(may_meet, starts)
        ask = (side == 0) & ((at_most > best * (1 + precision)) | (best == 0))
        inside = side == 1
        inside[ask] = is_inside(middle[ask], targets)
        known_inside = (side == 1) | (is_whole & inside & ask)
        outside = is_whole & ask & ~inside
        if inside.any():
            best = max(best, float(of_middle[inside].max()))
        if known_inside.any():
            at_corner = np.minimum.reduceat(distance[:, :3], starts, axis=0)
            best = max(best, float(at_corner[known_inside].max()))
        stays = ~outside & (at_most > best * (1 + precision)) & (at_most > NOTHING)
        if not stays.any():
            break
        # A triangle farther than the bound from the whole piece is nowhere the nearest.
        matters = stays[piece] & (distance[:, 3] - radius[piece] <= at_most[piece])
        change = _change(distance, matters, piece, starts, pieces)
        longest = np.linalg.norm(pieces - np.roll(pieces, -1, axis=1), axis=-1)
        edge = np.where(known_inside[:, None], change, longest).argmax(axis=1)
        new = np.cumsum(stays) - 1
        piece, target = new[piece[matters]], target[matters]
        pieces, side, edge = pieces[stays], known_inside[stays].astype(np.int8), edge[stays]
        bounds = at_most[stays]
        pieces = _halved(pieces, edge)
        side = np.repeat(side, 2)
        counts = np.bincount(piece, minlength=len(side) // 2)
        piece, target = _doubled(counts, target)
        if len(piece) > MOST_PAIRS:
            return best, max(best, float(bounds.max()))
    else:
        return best, max(best, float(bounds.max()))
    return best, max(best * (1 + precision), NOTHING)


def _near(pieces: Floats, targets: Floats) -> tuple[Indices, Indices]:
    """For each piece the triangles that may be nearest to one of its points, from bounding spheres."""
    middle, centre = pieces.mean(axis=1), targets.mean(axis=1)
    radius = np.linalg.norm(pieces - middle[:, None], axis=-1).max(axis=1)
    reach = np.linalg.norm(targets - centre[:, None], axis=-1).max(axis=1)
    apart = np.linalg.norm(middle[:, None] - centre[None], axis=-1)
    at_most = apart.min(axis=1) + radius
    piece, target = np.nonzero(apart - radius[:, None] - reach[None] <= at_most[:, None])
    return piece, target


def _change(distance: Floats, matters: Bools, piece: Indices, starts: Indices, pieces: Floats) -> Floats:
    """The largest change of a relevant distance along each side of a piece, plus a little for long sides."""
    along = np.abs(distance[:, :3] - distance[:, [1, 2, 0]]) * matters[:, None]
    long = np.linalg.norm(pieces - np.roll(pieces, -1, axis=1), axis=-1)
    found: Floats = np.maximum.reduceat(along, starts, axis=0) + 1e-3 * long
    return found


def _halved(pieces: Floats, edge: Indices) -> Floats:
    row = np.arange(len(pieces))
    after = (edge + 1) % 3
    middle = (pieces[row, edge] + pieces[row, after]) / 2
    both = np.repeat(pieces[:, None], 2, axis=1)
    both[row, 0, after] = middle
    both[row, 1, edge] = middle
    return both.reshape(-1, 3, 3)


def _doubled(counts: Indices, target: Indices) -> tuple[Indices, Indices]:
    """Repeats the triangles of each piece for both halves."""
    twice = np.repeat(counts, 2)
    first = np.cumsum(counts) - counts
    offset = np.arange(twice.sum()) - np.repeat(np.cumsum(twice) - twice, twice)
    return np.repeat(np.arange(len(twice)), twice), target[np.repeat(np.repeat(first, 2), twice) + offset]


def distances(points: Floats, triangles: Floats) -> Floats:
    """The distances (n, k) of points (n, k, 3) to triangles (n, 3, 3), row by row."""
    a, b, c = (triangles[:, None, i] for i in range(3))
    normal = np.cross(b - a, c - a)
    square = (normal * normal).sum(axis=-1)
    to_plane = ((points - a) * normal).sum(axis=-1)
    above = np.ones(points.shape[:2], bool)
    nearest = np.full(points.shape[:2], np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        along, off = q - p, points - p
        share = np.clip((off * along).sum(axis=-1) / (along * along).sum(axis=-1), 0, 1)
        rest = off - share[..., None] * along
        nearest = np.minimum(nearest, (rest * rest).sum(axis=-1))
        above &= (np.cross(along, off) * normal).sum(axis=-1) >= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        flat = to_plane * to_plane / square
    found: Floats = np.sqrt(np.where(above, flat, nearest))
    return found


def _is_clear(pieces: Floats, targets: Floats) -> Bools:
    """Whether one triangle lies strictly on one side of the plane of the other: then they do not meet."""
    found = np.zeros(len(pieces), bool)
    for one, other in ((pieces, targets), (targets, pieces)):
        normal = np.cross(one[:, 1] - one[:, 0], one[:, 2] - one[:, 0])
        height = ((other - one[:, :1]) * normal[:, None]).sum(axis=-1)
        size = np.abs(normal).sum(axis=-1) * (np.abs(other).max(axis=(1, 2)) + np.abs(one).max(axis=(1, 2)))
        found |= (height > 1e-14 * size[:, None]).all(axis=1) | (height < -1e-14 * size[:, None]).all(axis=1)
    return found


def is_inside(points: Floats, triangles: Floats) -> Bools:
    """Whether points are inside, by the winding number (van Oosterom and Strackee 1983). For any orientation."""
    winding = np.zeros(len(points))
    step = max(1, 400_000 // max(1, len(points)))
    for start in range(0, len(triangles), step):
        corners = triangles[None, start : start + step] - points[:, None, None]
        length = np.linalg.norm(corners, axis=-1)
        a, b, c = (corners[:, :, i] for i in range(3))
        above = (a * np.cross(b, c)).sum(axis=-1)
        dots = [
            (corners[:, :, i] * corners[:, :, j]).sum(axis=-1) * length[..., k]
            for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        ]
        winding += np.arctan2(above, length.prod(axis=-1) + sum(dots)).sum(axis=-1)
    found: Bools = np.abs(winding) > np.pi  # the arc tangents are half the solid angles, so inside they sum to 2 pi
    return found
