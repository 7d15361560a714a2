"""Walls along a slide: they stay on themselves, so parts that are pressed into each other by them get no deeper.

Seen along the slide a wall is a line. A part is tested with its walls moved in until they are clear of those of the
other part that stand beside them: all that it meets on its way, it meets exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mechanism.rounds import CLEAR_M

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Row = tuple[float, float, float]
"""A normal, and how far a wall moves in."""

_UPRIGHT = 1e-3  # cosine of a wall's normal with the slide
_OPPOSED = -0.7  # cosine of the normals of two walls that lie in each other: facets of coarse holes are turned
_PRESS = 0.28  # a part is pressed into the other by this share of the half width of either at most
_MOST_PAIRS = 20_000_000
_TABLE = 2_000_000
_SAME = 1e-5  # normals that differ by less are one
_ROUNDING = 2.0**-21  # places as well, as a share of the largest coordinate
_BENT = 0.1  # sine of the angle from which on two walls meet in an edge


@dataclass(frozen=True, eq=False)
class _Walls:
    """The walls of a part: lines across the slide, metres."""

    ends: Floats
    """`(k, 2, 2)`, the outside on the right."""
    normal: Floats
    way: Floats
    length: Floats
    low: Floats
    high: Floats
    """Their heights."""

    def seen(self, rows: Ints, points: Floats) -> tuple[Floats, Floats]:
        """Where points are along some of them, and beside: `(walls, points)`."""
        start = self.ends[rows, 0]
        along, beside = (
            way @ points.T - np.einsum("ij,ij->i", way, start)[:, None] for way in (self.way[rows], self.normal[rows])
        )
        return along, beside

    def __len__(self) -> int:
        return len(self.length)


class _Across:
    """Points in numbers along and across a slide."""

    def __init__(self, axis: Floats, origin: Floats, slack: float) -> None:
        """slack: points that differ by less are one."""
        self.axis, self.origin, self.slack = axis, origin, slack
        u = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        u /= np.linalg.norm(u)
        self.base = np.array([u, np.cross(axis, u)])

    def flat(self, points: Floats) -> Floats:
        """Where they are across."""
        return np.asarray((points - self.origin) @ self.base.T)

    def height(self, points: Floats) -> Floats:
        """Where they are along."""
        return np.asarray((points - self.origin) @ self.axis)


def cleared(vertices: Floats, faces: Ints, others: tuple[Floats, Ints], axis: Floats) -> tuple[Floats, float]:
    """The vertices of a part with the walls moved in that lie in walls of another, and how deep these are, metres; the
    same and -inf where none do."""
    if not len(faces) or not len(others[1]):
        return vertices, -math.inf
    far = max(float(np.abs(vertices).max()), float(np.abs(others[0]).max()))
    across = _Across(axis, vertices[faces[0, 0]], _ROUNDING * far)
    mine, its = (
        _walls(*_beside(one, other, across), across)
        for one, other in (((vertices, faces), others), (others, (vertices, faces)))
    )
    if not len(mine) or not len(its) or len(mine) * len(its) > _MOST_PAIRS:
        return vertices, -math.inf
    wide = max(float(np.ptp(walls.ends, axis=(0, 1)).max()) for walls in (mine, its))
    deep = _depths(mine, its, _PRESS * 0.5 * wide)
    if not (deep > -CLEAR_M).any():
        return vertices, -math.inf
    by = _in_line(mine, np.where(deep > -CLEAR_M, deep + CLEAR_M, 0.0), across.slack)
    return _moved(vertices, mine, by, across), float(deep.max())


def _beside(mesh: tuple[Floats, Ints], other: tuple[Floats, Ints], across: _Across) -> tuple[Floats, Ints]:
    """The faces of a part that may meet another as it slides."""
    (vertices, faces), (points, used) = mesh, other
    around = across.flat(points[used.ravel()])
    low, high = around.min(axis=0) - CLEAR_M, around.max(axis=0) + CLEAR_M
    flat = across.flat(vertices)[faces]
    return vertices, faces[((flat.min(axis=1) <= high) & (flat.max(axis=1) >= low)).all(axis=1)]


def _in_line(mine: _Walls, by: Floats, slack: float) -> Floats:
    """How far walls move in, also those in line with one that does: they follow it."""
    found: Floats = by.copy()
    rest, moves = np.flatnonzero(by == 0.0), np.flatnonzero(by > 0.0)
    for rows in _shared(moves, len(rest)):
        (begin, off), (end, out) = (mine.seen(rows, mine.ends[rest, at]) for at in (0, 1))
        is_one = (np.abs(off) <= slack) & (np.abs(out) <= slack) & (end > begin)  # that is: their normals are alike
        is_one &= (begin < mine.length[rows, None] - slack) & (end > slack)
        found[rest] = np.maximum(found[rest], np.where(is_one, by[rows, None], 0.0).max(axis=0, initial=0.0))
    return found


def _shared(numbers: Ints, each: int) -> list[Ints]:
    """Numbers in shares, of which tables with `each` columns are of a size that memory bears."""
    return np.array_split(numbers, max(1, math.ceil(len(numbers) * each / _TABLE))) if len(numbers) and each else []


def _walls(vertices: Floats, faces: Ints, across: _Across) -> _Walls:
    """The faces along a slide; those side by side in one plane are one wall."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    kept = (twice > 0.0) & (np.abs(normal @ across.axis) <= _UPRIGHT * twice)
    corners, faces = corners[kept], faces[kept]
    out = normal[kept] @ across.base.T
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    flat, height = across.flat(corners), across.height(corners)
    planes = np.column_stack([out / _SAME, np.einsum("ij,ij->i", flat[:, 0], out) / across.slack])
    first, number = _pieces(np.round(planes).astype(np.int64), faces)
    way = np.column_stack([-out[first, 1], out[first, 0]])
    along = np.einsum("ikj,ij->ik", flat - flat[first, :1][number], way[number])
    low, high, begin, end = (np.full(len(first), far) for far in (np.inf, -np.inf, np.inf, -np.inf))
    for found, values in ((low, height.min(axis=1)), (begin, along.min(axis=1))):
        np.minimum.at(found, number, values)
    for found, values in ((high, height.max(axis=1)), (end, along.max(axis=1))):
        np.maximum.at(found, number, values)
    ends = flat[first, :1] + np.stack([begin, end], axis=1)[:, :, None] * way[:, None]
    return _Walls(ends, out[first], way, end - begin, low, high)


def _pieces(keys: Ints, faces: Ints) -> tuple[Ints, Ints]:
    """Faces with the same keys that share corners: the first of each piece, and by face the number of its piece."""
    above = np.arange(len(faces))
    _, key = np.unique(keys, axis=0, return_inverse=True)
    known: dict[tuple[int, int], int] = {}

    def top(of: int) -> int:
        while above[of] != of:
            above[of] = above[above[of]]
            of = int(above[of])
        return of

    for n, (own, corners) in enumerate(zip(key.reshape(-1).tolist(), faces.tolist(), strict=True)):
        for corner in corners:
            one, other = top(n), top(known.setdefault((own, corner), n))
            above[max(one, other)] = min(one, other)
    first, number = np.unique([top(n) for n in range(len(faces))], return_inverse=True)
    return first.astype(np.int64), number.reshape(-1).astype(np.int64)


def _depths(mine: _Walls, its: _Walls, most: float) -> Floats:
    """How deep walls of the other part are behind each, metres; -inf where none is, or one is deeper than `most`.

    A piece of a line that is behind several lies in the nearest of these.
    """
    beside = np.minimum(mine.high[:, None], its.high) - np.maximum(mine.low[:, None], its.low)
    k, j = np.nonzero((mine.normal @ its.normal.T < _OPPOSED) & (beside > 2.0 * CLEAR_M))
    off = its.ends[j] - mine.ends[k, :1]
    along, behind = np.einsum("nij,nj->ni", off, mine.way[k]), -np.einsum("nij,nj->ni", off, mine.normal[k])
    span = along[:, 1] - along[:, 0]  # opposed lines run back
    shares = (np.stack([mine.length[k], np.zeros(len(k))], axis=1) - along[:, :1]) / span[:, None]
    shares = np.clip(shares, 0.0, 1.0)
    depth = behind[:, :1] + shares * (behind[:, 1:] - behind[:, :1])
    kept = (shares[:, 1] > shares[:, 0]) & (depth.max(axis=1) > -most) & (depth.min(axis=1) <= most)
    # what shares less of the slide than it is deep is pressed in along it, as a shoulder
    kept &= beside[k, j] > 2.0 * depth.max(axis=1)
    k, j, shares, depth = k[kept], j[kept], shares[kept], depth[kept]
    # where the middle of a piece is behind several walls, it is in the nearest
    order = np.argsort(j, kind="stable")
    k, j, shares, depth = k[order], j[order], shares[order], depth[order]
    first, count = np.searchsorted(j, j, "left"), np.searchsorted(j, j, "right")
    count -= first
    one = np.repeat(np.arange(len(k)), count)
    other = np.repeat(first - np.cumsum(count) + count, count) + np.arange(len(one))
    share = shares.mean(axis=1)[one]
    at = depth[other, 0] + (share - shares[other, 0]) / np.ptp(shares, axis=1)[other] * np.diff(depth, axis=1)[other, 0]
    at[(share < shares[other, 0]) | (share > shares[other, 1])] = np.inf
    least = np.full(len(k), np.inf)
    np.minimum.at(least, one, np.abs(at))
    nearest = np.abs(depth.mean(axis=1)) <= least + CLEAR_M
    found = np.full(len(mine), -np.inf)
    np.maximum.at(found, k[nearest], depth[nearest].max(axis=1))
    return np.where(found <= most, found, -np.inf)


def _moved(vertices: Floats, mine: _Walls, by: Floats, across: _Across) -> Floats:
    """The vertices on walls moved in with them."""
    flat, height, slack = across.flat(vertices), across.height(vertices), across.slack
    # those above each other are seen at one place
    _, first, place = np.unique(np.round(flat / slack).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(place.reshape(-1), kind="stable")
    begin = np.concatenate([[0], np.cumsum(np.bincount(place.reshape(-1)))])
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for rows in _shared(np.arange(len(mine)), len(first)):
        along, beside = mine.seen(rows, flat[first])
        is_on = (np.abs(beside) <= slack) & (along >= -slack) & (along <= mine.length[rows, None] + slack)
        wall, at = np.nonzero(is_on)
        count = begin[at + 1] - begin[at]
        wall = np.repeat(rows[wall], count)
        vertex = order[np.repeat(begin[at] - np.cumsum(count) + count, count) + np.arange(len(wall))]
        is_on = (height[vertex] >= mine.low[wall] - slack) & (height[vertex] <= mine.high[wall] + slack)
        pairs.append(np.column_stack([vertex[is_on], wall[is_on]]))
    on = np.concatenate(pairs)
    on = on[np.isin(on[:, 0], on[by[on[:, 1]] > 0.0, 0])]
    on = on[np.argsort(on[:, 0], kind="stable")]
    found: Floats = vertices.copy()
    known: dict[frozenset[Row], Floats] = {}
    for own in np.split(on, np.flatnonzero(np.diff(on[:, 0])) + 1) if len(on) else []:
        walls = frozenset(zip(*mine.normal[own[:, 1]].T.tolist(), by[own[:, 1]].tolist(), strict=True))
        if walls not in known:
            known[walls] = np.array(_shift(sorted(walls))) @ across.base
        found[own[0, 0]] += known[walls]
    return found


def _shift(walls: list[Row]) -> tuple[float, float]:
    """The shortest way by which a corner is moved in by all of its walls."""
    ways = [(-by * x, -by * y) for x, y, by in walls if by > 0.0]
    for n, (x, y, by) in enumerate(walls):
        for x1, y1, by1 in walls[:n]:
            turn = x * y1 - y * x1
            if abs(turn) > _BENT:
                ways.append(((by1 * y - by * y1) / turn, (by * x1 - by1 * x) / turn))
    slack = 1e-3 * max(by for *_, by in walls)
    good = [way for way in ways if all(way[0] * x + way[1] * y <= slack - by for x, y, by in walls)]
    if good:
        return min(good, key=lambda way: math.hypot(*way))
    # walls that nearly are one: by as much as the farthest, along their mean
    total = np.array([(x, y) for x, y, _ in walls]).sum(axis=0)
    mean = total / (np.linalg.norm(total) or 1.0)
    least = min(float(x * mean[0] + y * mean[1]) for x, y, _ in walls)
    far = max(by for *_, by in walls) / max(least, _BENT)
    return float(-far * mean[0]), float(-far * mean[1])
