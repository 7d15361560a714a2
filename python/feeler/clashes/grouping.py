"""Groups findings by part, by rule, or by place."""

from __future__ import annotations

import heapq
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_length, check_word
from feeler.clashes.table import Table, places
from feeler.errors import OptionError

Ints = npt.NDArray[np.intp]

REACH_SHARE = 0.01
"""Default reach of a cluster, as a share of the diagonal of the box around all findings."""

_COMPARED = 1_000_000
"""Most distances between two cells that are computed at once, 24 MB."""


def grouped(clashes: Table, by: str, reach: float | None) -> list[tuple[str, Ints]]:
    """Name and rows of each group: see `Clashes.groups`. Rows keep their order; groups that of their first rows."""
    check_word("by", by, _MADE)
    if reach is not None:
        check_length("reach", reach)
        if by != "cluster":
            raise OptionError(f'reach is for groups by "cluster", not by {by!r}')
    if not len(clashes):
        return []
    label, name = _MADE[by](clashes, reach)
    order = np.argsort(label, kind="stable")
    starts = np.flatnonzero(np.diff(label[order], prepend=-1))
    members = sorted(np.split(order, starts[1:]), key=lambda rows: int(rows[0]))
    return [(name(int(label[rows[0]]), number), rows) for number, rows in enumerate(members, start=1)]


Labels = tuple[Ints, Callable[[int, int], str]]
"""The label of the group of each row, and a function from label and number of a group to its name."""


def _by_rule(clashes: Table, _reach: float | None) -> Labels:
    return clashes.columns.rule.astype(np.intp), lambda label, _number: clashes.rule_names[label]


def _by_part(clashes: Table, _reach: float | None) -> Labels:
    """Assigns rows to the part with most of the remaining rows: greedy cover, ties to the first by name."""
    label = np.full(len(clashes), -1, dtype=np.intp)
    rows_of: dict[int, list[int]] = {}
    pairs = list(zip(clashes.parts_a.tolist(), clashes.parts_b.tolist(), strict=True))
    for row, pair in enumerate(pairs):
        for part in pair:
            rows_of.setdefault(part, []).append(row)
    left = {part: len(rows) for part, rows in rows_of.items()}
    place = places(clashes.keys).tolist()
    # The largest first. A part that lost rows meanwhile goes back with its new count.
    heap = [(-count, place[part], part) for part, count in left.items()]
    heapq.heapify(heap)
    while heap:
        count, _, part = heapq.heappop(heap)
        if left[part] != -count:
            if left[part]:
                heapq.heappush(heap, (-left[part], place[part], part))
            continue
        for row in rows_of[part]:
            if label[row] < 0:
                label[row] = part
                for each in pairs[row]:
                    left[each] -= 1
    return label, lambda part, _number: clashes.keys[part]


def _by_cluster(clashes: Table, reach: float | None) -> Labels:
    """Single-linkage clusters: chains of findings, each within reach of the next."""
    points = np.nan_to_num((clashes.points_a + clashes.points_b) / 2)
    if reach is None:
        reach = REACH_SHARE * float(np.linalg.norm(np.ptp(points, axis=0)))
    label = _linked(points, reach)
    return label, lambda _label, number: f"cluster {number}"


def _linked(points: npt.NDArray[np.float64], reach: float) -> Ints:
    """The label of each point, `(n,)`; equal if a chain of steps of at most `reach` links the points."""
    # Points of one cell are within reach of each other. Points more than two cells apart are not.
    side = max(reach / np.sqrt(3.0), float(np.abs(points).max()) * 1e-12, 1e-300)
    cells, cell_of = np.unique(np.floor(points / side), axis=0, return_inverse=True)
    cell_of = cell_of.reshape(-1)
    order = np.argsort(cell_of, kind="stable")
    bounds = np.searchsorted(cell_of[order], np.arange(len(cells) + 1))
    members = [order[bounds[i] : bounds[i + 1]] for i in range(len(cells))]
    place = {tuple(cell): number for number, cell in enumerate(cells.tolist())}
    parent = list(range(len(cells)))

    def root(cell: int) -> int:
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    steps = [step for step in np.ndindex(5, 5, 5) if step > (2, 2, 2)]
    for cell, number in place.items():
        for step in steps:
            other = place.get((cell[0] + step[0] - 2, cell[1] + step[1] - 2, cell[2] + step[2] - 2))
            if other is None or root(number) == root(other):
                continue
            if _within(points[members[number]], points[members[other]], reach):
                parent[root(other)] = root(number)
    return np.array([root(cell) for cell in range(len(cells))], dtype=np.intp)[cell_of]


def _within(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64], reach: float) -> bool:
    """Whether a point of `one` is within reach of a point of `other`."""
    step = max(_COMPARED // len(other), 1)
    for begin in range(0, len(one), step):
        away = one[begin : begin + step, None] - other[None]
        if (np.einsum("ijk,ijk->ij", away, away) <= reach * reach).any():
            return True
    return False


_MADE: dict[str, Callable[[Table, float | None], Labels]] = {
    "part": _by_part,
    "rule": _by_rule,
    "cluster": _by_cluster,
}
