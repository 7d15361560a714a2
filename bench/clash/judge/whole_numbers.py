"""The depth of boxes by a closed form, and of polycubes by branch and bound over rectangles, in integer arithmetic.

Lattice planes are integers in float64, so comparisons are exact. Only the square root of a distance and the last
bisections round, by a few 1e-16 of the depth.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from .facts import Facts
from .shapes import Bools, Floats, Polycube

PRECISION = 1e-9
"""The relative distance of the bounds at which branch and bound stops."""
MOST_ROUNDS = 120


def boxes(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> Facts:
    """Two boxes with parallel edges, by a closed form.

    Inside a box, the distance to its surface is the minimum of six plane distances. On a face of the other box, each of
    them depends on one coordinate, so the maximum of the minimum is the minimum of the maxima.
    """
    apart = np.maximum(np.maximum(low_b - high_a, low_a - high_b), 0)
    gap = float(np.sqrt((apart * apart).sum()))
    overlap = np.minimum(high_a, high_b) - np.maximum(low_a, low_b)
    if not (overlap > 0).all():
        return Facts(0.0, 0.0, gap)
    depth = 0.0
    for (low, high), (other_low, other_high) in (
        ((low_a, high_a), (low_b, high_b)),
        ((low_b, high_b), (low_a, high_a)),
    ):
        first, last = np.maximum(low, other_low), np.minimum(high, other_high)
        middle = np.clip((other_low + other_high) / 2, first, last)
        most = np.minimum(middle - other_low, other_high - middle)
        for axis in range(3):
            across = min(float(most[axis - 1]), float(most[axis - 2]))
            for plane in (low[axis], high[axis]):
                depth = max(depth, min(across, float(plane - other_low[axis]), float(other_high[axis] - plane)))
    is_a_in_b = bool((low_b <= low_a).all() and (high_a <= high_b).all())
    is_b_in_a = bool((low_a <= low_b).all() and (high_b <= high_a).all())
    is_touching = bool((low_a == low_b).any() or (high_a == high_b).any()) or not (is_a_in_b or is_b_in_a)
    least = min(float(np.prod(high_a - low_a)), float(np.prod(high_b - low_b)))
    return Facts(
        depth,
        depth,
        0.0,
        is_same=is_a_in_b and is_b_in_a,
        is_inside=is_a_in_b or is_b_in_a,
        is_touching=is_touching,
        share=float(np.prod(overlap)) / least,
    )


def polycubes(a: Polycube, b: Polycube) -> Facts:
    """Two polycubes with parallel axes."""
    (low_a, high_a), (low_b, high_b) = a.ends(), b.ends()
    apart = np.maximum(np.maximum(low_b[None] - high_a[:, None], low_a[:, None] - high_b[None]), 0)
    gap = float(np.sqrt((apart * apart).sum(axis=-1).min()))
    if gap > 0:
        return Facts(0.0, 0.0, gap)
    planes = [np.unique(np.concatenate([a.planes[axis], b.planes[axis]])) for axis in range(3)]
    in_a, in_b = (_occupied(body, planes) for body in (a, b))
    both = in_a & in_b
    if not both.any():
        return Facts(0.0, 0.0, 0.0)
    sizes = np.diff(planes[0])[:, None, None] * np.diff(planes[1])[:, None] * np.diff(planes[2])
    volume_a, volume_b, shared = (float((sizes * each).sum()) for each in (in_a, in_b, both))
    is_inside = bool((both == in_a).all() or (both == in_b).all())
    depth = (0.0, 0.0)
    for own, other, body in ((in_a, in_b, b), (in_b, in_a, a)):
        found = _deepest(*_squares_inside(own, other, planes), *body.rectangles(), depth[0])
        depth = max(depth[0], found[0]), max(depth[1], found[1])
    return Facts(
        *depth,
        0.0,
        is_same=bool((in_a == in_b).all()),
        is_inside=is_inside,
        is_touching=not is_inside or _is_touching(a, b),
        share=shared / min(volume_a, volume_b),
    )


def _occupied(body: Polycube, planes: list[Floats]) -> Bools:
    """The cells of a finer lattice that the body fills."""
    found = np.zeros([len(each) - 1 for each in planes], bool)
    for low, high in zip(*body.ends(), strict=True):
        where = tuple(
            slice(int(np.searchsorted(planes[i], low[i])), int(np.searchsorted(planes[i], high[i]))) for i in range(3)
        )
        found[where] = True
    return found


def _squares_inside(own: Bools, other: Bools, planes: list[Floats]) -> tuple[Floats, Floats]:
    """Lower and upper corners of the squares of one surface inside the other body."""
    lows, highs = [np.empty((0, 3))], [np.empty((0, 3))]
    for axis in range(3):
        before = tuple(slice(None, -1) if i == axis else slice(None) for i in range(3))
        after = tuple(slice(1, None) if i == axis else slice(None) for i in range(3))
        index = np.argwhere((own[before] != own[after]) & other[before] & other[after])
        low = np.stack([planes[i][index[:, i] + (i == axis)] for i in range(3)], axis=1)
        lows.append(low)
        highs.append(np.stack([planes[i][index[:, i] + 1] for i in range(3)], axis=1))
    return np.concatenate(lows), np.concatenate(highs)


def _is_touching(a: Polycube, b: Polycube) -> bool:
    (low_a, high_a), (low_b, high_b) = a.rectangles(), b.rectangles()
    meet = (low_a[:, None] <= high_b[None]) & (low_b[None] <= high_a[:, None])
    return bool(meet.all(axis=-1).any())


def _deepest(low: Floats, high: Floats, to_low: Floats, to_high: Floats, known: float) -> tuple[float, float]:
    """Bounds of the largest distance from a point of the squares to the nearest rectangle.

    The distance to a rectangle is convex, so on a square it is largest at a corner. The axes are independent, so each
    axis has its own maximum. known: a lower bound; squares below it are pruned.
    """
    best = known**2
    for _ in range(MOST_ROUNDS):
        if len(low) == 0:
            return best**0.5, best**0.5
        ends = np.stack([low, (low + high) / 2, high])[:, :, None, :]
        apart = np.maximum(np.maximum(to_low - ends, ends - to_high), 0) ** 2  # of (end, square, rectangle, axis)
        most = np.maximum(apart[0], apart[2])
        upper = most.sum(axis=-1)
        bound = upper.min(axis=1)
        # The centre and the corners of each square. Some coincide, since a square is flat along one axis.
        best = max(best, float(apart[1].sum(axis=-1).min(axis=1).max()))
        for which in product((0, 2), repeat=3):
            corner = sum(apart[end, ..., axis] for axis, end in enumerate(which))
            best = max(best, float(np.asarray(corner).min(axis=1).max()))
        stays = bound > best * (1 + PRECISION)
        if not stays.any():
            return best**0.5, (best * (1 + PRECISION)) ** 0.5
        low, high, bound, most, apart = low[stays], high[stays], bound[stays], most[stays], apart[:, stays]
        # Halved along the axis with the largest change of a relevant distance.
        least = (np.maximum(np.maximum(to_low - high[:, None], low[:, None] - to_high), 0) ** 2).sum(axis=-1)
        change = most - np.minimum(np.minimum(apart[0], apart[2]), apart[1])
        change = np.where((least <= bound[:, None])[..., None], change, 0).max(axis=1)
        change = np.where(high > low, change + 1e-12 * (high - low) ** 2, -1)
        axis = change.argmax(axis=1)
        row = np.arange(len(low))
        middle = (low[row, axis] + high[row, axis]) / 2
        first_high, last_low = high.copy(), low.copy()
        first_high[row, axis] = middle
        last_low[row, axis] = middle
        low, high = np.concatenate([low, last_low]), np.concatenate([first_high, high])
    return best**0.5, float(bound.max()) ** 0.5
