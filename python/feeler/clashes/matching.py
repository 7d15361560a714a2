"""Matches the parts of the previous check to the parts of this check.

    same path, shape and place -> same content -> same shape and place -> same path alone, also below a renamed folder

Each step matches parts that the earlier steps left over, one to one. Parts with equal paths are matched by shape and
place only, since their order is arbitrary; also those that a reader numbered. If most parts moved, places are compared
after the motion of the whole, which `motions.py` chooses.
"""

from __future__ import annotations

import itertools
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from feeler.clashes.motions import Evidence, Motion, shared_steps
from feeler.clashes.shapes import Floats, Shapes
from feeler.clashes.tracking import DEPTH_GROWTH_M

Rows = npt.NDArray[np.intp]

_MOTION_M, _DIAGONAL_SHARE = 1e-5, 0.03
"""How far a part may have moved alone, metres, and at most as a share of its diagonal."""
_CHORD_SHARE = 1.05
"""How far facets may be from a surface, as a share of the estimate of `chord_errors`."""
_MOST_CHORD = 0.125
"""The largest estimate, as a share of the diagonal: a ball of eight chords has 0.09."""
_ROUNDING = 1e-6
"""Share of the largest coordinate: eight units in the last place of float32, the type in most formats."""
_AREA_ROUNDINGS = 8.0
"""How many roundings by the lengths of a part its area may be off."""
_LEAST_M = 1e-12
"""Added to every tolerance, so that none is zero."""
_OLD_SIDE_SHARE, _OLD_AREA_SHARE, _OLD_MOTION_M = 0.04, 0.12, DEPTH_GROWTH_M
"""Tolerances for parts of older files, which have no chords: shares of the side and the area, and metres."""
_NEAR_SHARE = 0.5
"""For parts with equal paths: how far the centre may move, as a share of the side along each axis, and how much the
diagonal may change. Bolts of a pattern are farther apart than that."""
_NUMBER = re.compile(r"#[1-9][0-9]*$")
_NO_SHIFT = np.zeros(3)
_MOST_ALIKE, _MOST_SHIFTS = 4096, 8
"""How many pairs of equal shape are asked for the motion of the whole, and how many of these motions are tried."""


@dataclass(frozen=True)
class PartMatch:
    """How many parts of the previous findings are in this mock-up. `str()` gives a sentence for people.

    parts: number of parts that had findings. by_path: of these, parts with the same path. altered: parts with the same
    path, but another shape or place. by_shape: parts with another path, or another number among equal paths. renamed:
    the current key of each part in `by_shape`, by its previous key. ambiguous: parts that match none since the assembly
    moved, and two copies of it are as likely the original.
    """

    parts: int
    by_path: int
    altered: int
    by_shape: int
    renamed: Mapping[str, str] = field(default_factory=dict)
    ambiguous: int = 0

    def __str__(self) -> str:
        """One line."""
        found = self.by_path + self.by_shape
        text = f"{found:,} of {self.parts:,} parts with findings before are in this mock-up"
        if self.is_plain:
            return text
        altered = f" ({self.altered:,} with another shape or place)" if self.altered else ""
        text += f": {self.by_path:,} by path{altered}, {self.by_shape:,} by shape and place"
        if self.renamed:
            before, now = min(self.renamed.items())
            text += f", such as {now}, before {before}"
        if self.ambiguous:
            text += f"; {self.ambiguous:,} match two copies equally well, and so neither"
        return text

    @property
    def is_plain(self) -> bool:
        """Whether all parts have the same path, shape and place as before."""
        return self.by_path == self.parts and not self.altered

    @property
    def is_doubtful(self) -> bool:
        """Whether less than half of the parts have the same shape and place as before."""
        return 2 * (self.by_path + self.by_shape - self.altered) < self.parts


class Match(NamedTuple):
    """The part now of each part before.

    new_of_old: its row, or -1. is_same: whether shape and place are unchanged. is_ambiguous: whether it matches none
    since nothing tells two copies of it apart.
    """

    new_of_old: Rows
    is_same: npt.NDArray[np.bool_]
    is_ambiguous: npt.NDArray[np.bool_]


def matched(old: Shapes, new: Shapes) -> Match:
    """Matches the rows of `old` and `new`.

    One to one, and the same on every machine. Nearly linear in the number of parts.
    """
    old, new = (replace(each, paths=unnumbered(each.paths)) for each in (old, new))
    search = _Search(old, new)
    still = search.found(_NO_SHIFT)
    shifts = [_NO_SHIFT, *search.common_shifts(still)]
    motions = [Motion(shift, search.found(shift) if shift.any() else still) for shift in shifts]
    found, is_doubtful = search.evidence().chosen(motions)
    new_of_old = search.by_path(found.copy())
    return Match(new_of_old, found >= 0, is_doubtful & (new_of_old < 0))


def unnumbered(paths: Sequence[str]) -> tuple[str, ...]:
    """Paths without the `#2` that readers give to the second part of a name: the next revision may count otherwise."""
    known = set(paths)
    bases = [_NUMBER.sub("", path) for path in paths]
    return tuple(base if base in known else path for base, path in zip(bases, paths, strict=True))


class _Search:
    """The data that all steps of the matching share."""

    def __init__(self, old: Shapes, new: Shapes) -> None:
        self.old, self.new = old, new
        self.sizes = [each.box[:, 1] - each.box[:, 0] for each in (old, new)]
        self.centres = [each.box.mean(axis=1) for each in (old, new)]
        self.diagonals = [np.sqrt((size * size).sum(axis=1)) for size in self.sizes]
        boxes = (each.box[each.is_known] for each in (old, new))
        self.rounding = _LEAST_M + _ROUNDING * max(float(np.abs(box).max(initial=0.0)) for box in boxes)
        self.chords = _chords(old, new)
        is_old = np.isnan(self.chords[0])
        most = np.where(is_old, _OLD_MOTION_M, _MOTION_M)
        self.motion = np.minimum(most, _DIAGONAL_SHARE * self.diagonals[0]) + self.rounding
        self.loose = np.where(is_old[:, None], _OLD_SIDE_SHARE * self.sizes[0], 0.0)
        """How much farther corners of parts of older files may be, `(n, 3)` metres."""
        chord = np.maximum(np.nan_to_num(self.chords[0]), self.chords[1].max(initial=0.0))
        self.reach = self.loose + (self.motion + np.minimum(chord, _MOST_CHORD * self.diagonals[0]))[:, None]
        """How far the centre of a part may be from its place before."""
        self.mates = _mates(old, new)
        self.by_shape = [_by_shape(each, size) for each, size in zip((old, new), self.sizes, strict=True)]
        self.shape, self.is_unique = np.full(len(old.keys), -1, dtype=np.intp), np.zeros(len(old.keys), dtype=bool)
        for number, rows in enumerate(self.by_shape[0].values()):
            self.shape[rows], self.is_unique[rows] = number, len(rows) == 1
        self.steps = [[path.split("/")[::-1] for path in each.paths] for each in (old, new)]

    def differences(self, olds: Rows, news: Rows, shift: Floats) -> Floats:
        """The distance of boxes and centroids for each pair, metres; infinite if shape or place differ."""
        box = np.abs(self.new.box[news] - self.old.box[olds] - shift).max(axis=1)
        middle = np.abs(self.new.middle[news] - self.old.middle[olds] - shift)
        away = np.maximum(box, middle)
        allowed = (self.motion[olds] + self.chord(olds, news))[:, None] + self.loose[olds]
        is_same = (away <= allowed).all(axis=1) & self.are_alike(olds, news)
        return np.where(is_same, away.max(axis=1, initial=0.0), np.inf)

    def chord(self, olds: Rows, news: Rows) -> Floats:
        """How far the surfaces of two meshes of one part may be from each other, metres; 0 for parts of older files."""
        return np.maximum(np.nan_to_num(self.chords[0][olds]), self.chords[1][news])

    def are_alike(self, olds: Rows, news: Rows) -> npt.NDArray[np.bool_]:
        """Which pairs have the same size and area, wherever they are."""
        grown = np.abs(self.sizes[1][news] - self.sizes[0][olds])
        allowed = (self.chord(olds, news) + self.rounding)[:, None] + self.loose[olds]
        is_same = (grown <= 2.0 * allowed).all(axis=1)
        areas, diagonal = (self.old.area[olds], self.new.area[news]), self.diagonals[0][olds] + _LEAST_M
        rounding = _AREA_ROUNDINGS * self.rounding * (diagonal + areas[0] / diagonal)
        # As many triangles: the same mesh, whose area a rotation does not change either.
        error = np.maximum(np.nan_to_num(self.old.area_error[olds]), self.new.area_error[news])
        error[self.old.triangles[olds] == self.new.triangles[news]] = 0.0
        is_old = np.isnan(self.chords[0][olds])
        error[is_old] = _OLD_AREA_SHARE * np.maximum(*areas)[is_old]
        same: npt.NDArray[np.bool_] = is_same & (np.abs(areas[0] - areas[1]) <= error + rounding)
        return same

    def found(self, shift: Floats) -> Rows:
        """Matches parts of equal shape whose places differ by `shift`."""
        new_of_old = np.full(len(self.old.keys), -1)
        olds, news = self.mates
        same = np.isfinite(self.differences(olds, news, shift))
        new_of_old[olds[same]] = news[same]
        if not shift.any():
            self._add_content(new_of_old)
        left = self._left(new_of_old)
        for old, new in self._near(*left, shift):
            new_of_old[old] = new
        return new_of_old

    def evidence(self) -> Evidence:
        """What motions are judged by."""
        olds, news = self.mates
        is_rigid = self.are_alike(olds, news)
        mates = olds[is_rigid], news[is_rigid]
        return Evidence((self.old.paths, self.new.paths), self.shape, self.is_unique, mates)

    def common_shifts(self, new_of_old: Rows) -> list[Floats]:
        """Motions that the whole may have made, if most parts moved, the likeliest first; else none.

        The median and the most frequent motions of parts with equal paths; and the most frequent motions to parts of
        equal shape, of the likest paths and of any: paths may be numbered anew.
        """
        if not len(self._left(new_of_old)[0]):
            return []  # all are in their places
        olds, news = self.mates
        alike = self._alike()
        if not len(olds):
            olds, news = alike
        is_rigid = self.are_alike(olds, news)
        is_moved = is_rigid & (new_of_old[olds] != news)
        if 2 * np.count_nonzero(is_moved) <= np.count_nonzero(is_rigid):
            return []
        mates = self._moves(olds[is_moved], news[is_moved])
        motions = mates, self._moves(*self._likest(*alike)), self._moves(*alike)
        return self._different([np.median(mates, axis=0), *(each for some in motions for each in self._frequent(some))])

    def _moves(self, olds: Rows, news: Rows) -> Floats:
        """How far each pair is apart, `(n, 3)` metres."""
        return np.asarray(self.centres[1][news] - self.centres[0][olds])

    def _likest(self, olds: Rows, news: Rows) -> tuple[Rows, Rows]:
        """Of these pairs, those whose paths share most steps, by the part before."""
        shared = np.array(
            [
                shared_steps(self.old.paths[old], self.new.paths[new])
                for old, new in zip(olds.tolist(), news.tolist(), strict=True)
            ],
            dtype=np.intp,
        )
        most = np.zeros(len(self.old.keys), dtype=np.intp)
        np.maximum.at(most, olds, shared)
        is_likest = (shared > 0) & (shared == most[olds])
        return olds[is_likest], news[is_likest]

    def _cells(self, motions: Floats) -> npt.NDArray[np.int64]:
        """Motions in units that are larger than tolerances."""
        return np.rint(motions / (2.0 * (DEPTH_GROWTH_M + self.rounding))).astype(np.int64)

    def _different(self, motions: Sequence[Floats]) -> list[Floats]:
        """The motions without those that are about zero, or about equal to an earlier one."""
        cells = [tuple(cell) for cell in self._cells(np.array([_NO_SHIFT, *motions])).tolist()]
        return [motion for n, motion in enumerate(motions, 1) if cells.index(cells[n]) == n]

    def _frequent(self, motions: Floats) -> list[Floats]:
        """The most frequent of some motions (n, 3), within a tolerance."""
        if not len(motions):
            return []
        places = self._cells(motions)
        _, first, counts = np.unique(places, axis=0, return_index=True, return_counts=True)
        order = np.lexsort((first, -counts))[:_MOST_SHIFTS]
        return [np.median(motions[(places == places[first[each]]).all(axis=1)], axis=0) for each in order]

    def by_path(self, new_of_old: Rows) -> Rows:
        """Adds matches by path alone: parts that moved or changed their shape."""
        is_taken = np.zeros(len(self.new.keys), dtype=bool)
        is_taken[new_of_old[new_of_old >= 0]] = True
        olds, news = self.mates
        free = (new_of_old[olds] < 0) & ~is_taken[news]
        new_of_old[olds[free]] = news[free]
        self._add_in_renamed_folders(new_of_old)
        self._add_siblings(new_of_old)
        self._add_unknown(new_of_old)
        return new_of_old

    def _left(self, new_of_old: Rows) -> tuple[Rows, Rows]:
        """The known rows that are not matched."""
        is_free = self.new.is_known
        is_free[new_of_old[new_of_old >= 0]] = False
        return np.flatnonzero((new_of_old < 0) & self.old.is_known), np.flatnonzero(is_free)

    def _add_content(self, new_of_old: Rows) -> None:
        """Adds pairs with equal corners. The last steps of the paths distinguish copies in one place."""
        olds, news = self._left(new_of_old)
        here: dict[int, list[int]] = defaultdict(list)
        for new in news.tolist():
            here[int(self.new.content[new])].append(new)
        before: dict[int, list[int]] = defaultdict(list)
        for old in olds.tolist():
            if int(self.old.content[old]) in here:
                before[int(self.old.content[old])].append(old)
        for content, some in before.items():
            for old, new in self._alike_in_path(some, here[content]):
                new_of_old[old] = new

    def _alike_in_path(self, olds: Sequence[int], news: Sequence[int]) -> Iterable[tuple[int, int]]:
        """Pairs of parts. Those with more equal last path steps come first."""
        left, free = list(olds), list(news)
        depth = max(len(self.steps[0][old]) for old in olds) if len(olds) > 1 or len(news) > 1 else 0
        for most in range(depth, -1, -1):
            by_end: dict[tuple[str, ...], list[int]] = defaultdict(list)
            for new in reversed(free):
                by_end[tuple(self.steps[1][new][:most])].append(new)
            pairs = [(old, by_end[end].pop()) for old in left if by_end.get(end := tuple(self.steps[0][old][:most]))]
            yield from pairs
            done, taken = {old for old, _ in pairs}, {new for _, new in pairs}
            left, free = [old for old in left if old not in done], [new for new in free if new not in taken]

    def _near(self, olds: Rows, news: Rows, shift: Floats) -> Iterable[tuple[int, int]]:
        """Pairs of equal shape and place, the nearest first. The last path steps break ties."""
        pairs = self._candidates(olds, news, shift, self.reach[olds])
        differences = self.differences(*pairs, shift)
        return self._nearest_first(*pairs, differences)

    def _nearest_first(self, olds: Rows, news: Rows, distances: Floats) -> Iterable[tuple[int, int]]:
        """Pairs at a finite distance, each part once."""
        order = [
            (distance, -_common(self.steps[0][old], self.steps[1][new]), old, new)
            for distance, old, new in zip(distances.tolist(), olds.tolist(), news.tolist(), strict=True)
            if math.isfinite(distance)
        ]
        return _one_to_one((old, new) for _, _, old, new in sorted(order))

    def _candidates(self, olds: Rows, news: Rows, shift: Floats, reach: Floats) -> tuple[Rows, Rows]:
        """Pairs of similar size with centres about `reach` apart or nearer. Uses a grid for each size."""
        sizes = [_doublings(diagonal) for diagonal in self.diagonals]
        cell_of_size = {size: math.ldexp(0.5, size) + 4.0 * self.rounding for size in {*sizes[1][news].tolist()}}
        grid: dict[tuple[int, tuple[int, ...]], list[int]] = defaultdict(list)
        for new, size, centre in zip(
            news.tolist(), sizes[1][news].tolist(), self.centres[1][news].tolist(), strict=True
        ):
            place = tuple(math.floor(x / cell_of_size[size]) for x in centre)
            grid[size, place].append(new)
        centres = self.centres[0][olds] + shift
        lower, upper = (centres - reach).tolist(), (centres + reach).tolist()
        pairs = []
        for old, around, low, high in zip(olds.tolist(), sizes[0][olds].tolist(), lower, upper, strict=True):
            for size in (around - 1, around, around + 1):
                if (cell := cell_of_size.get(size)) is None:
                    continue
                spans = [range(math.floor(a / cell), math.floor(b / cell) + 1) for a, b in zip(low, high, strict=True)]
                for place in itertools.product(*spans):
                    pairs += [(old, new) for new in grid.get((size, place), ())]
        return _columns(pairs)

    def _alike(self) -> tuple[Rows, Rows]:
        """Pairs of parts of equal shape, of the shapes that few parts have."""
        by_shape = self.by_shape
        both = [(rows, by_shape[1][shape]) for shape, rows in by_shape[0].items() if shape in by_shape[1]]
        both.sort(key=lambda rows: len(rows[0]) * len(rows[1]))
        pairs: list[tuple[int, int]] = []
        for olds, news in both:
            if pairs and len(pairs) + len(olds) * len(news) > _MOST_ALIKE:
                break
            pairs += itertools.islice(itertools.product(olds, news), _MOST_ALIKE)
        return _columns(pairs)

    def _add_in_renamed_folders(self, new_of_old: Rows) -> None:
        """Adds pairs by path below a root or sub-assembly that has another name: other parts of it say which."""
        folders = _renamed_folders(self.old.paths, self.new.paths, new_of_old)
        if not folders:
            return
        olds, news = self._left(new_of_old)
        counts = Counter(self.old.paths), Counter(self.new.paths)
        row_of_path = {self.new.paths[new]: new for new in news.tolist() if counts[1][self.new.paths[new]] == 1}
        for old in olds.tolist():
            path = self.old.paths[old]
            steps = path.split("/")
            folder = next((f for k in range(len(steps) - 1, -1, -1) if (f := tuple(steps[:k])) in folders), None)
            if folder is None or counts[0][path] > 1:
                continue
            new = row_of_path.pop("/".join([*folders[folder], *steps[len(folder) :]]), None)
            if new is not None:
                new_of_old[old] = new

    def _add_siblings(self, new_of_old: Rows) -> None:
        """Adds pairs among parts with equal paths: all moved as a part with a path of its own, or each a little."""
        motions = self._motions()
        olds, news = self._left(new_of_old)
        before, here = _by_path(self.old.paths, olds), _by_path(self.new.paths, news)
        counts = Counter(self.old.paths), Counter(self.new.paths)
        for path, some in before.items():
            others = here.get(path)
            if others is None:
                continue
            rows = np.array(some), np.array(others)
            pairs: list[tuple[int, int]] = []
            if len(some) == len(others) == counts[0][path] == counts[1][path]:
                shift = self.centres[1][rows[1]].mean(axis=0) - self.centres[0][rows[0]].mean(axis=0)
                away = np.abs(motions - shift)
                if (away <= self.reach[rows[0]].max(axis=0)).all(axis=1).any():
                    # Not the mean itself: facets that fell elsewhere move the middles of boxes.
                    pairs = list(self._near(*rows, motions[away.max(axis=1).argmin()]))
            if len(pairs) < len(some):
                pairs = list(self._nearest(*rows))
            for old, new in pairs:
                new_of_old[old] = new

    def _motions(self) -> Floats:
        """How parts with paths of their own moved, `(n, 3)` metres."""
        olds, news = self.mates
        rigid = self.are_alike(olds, news)
        return self._moves(olds[rigid], news[rigid])

    def _nearest(self, olds: Rows, news: Rows) -> Iterable[tuple[int, int]]:
        """Pairs of similar size whose new centre lies inside the old box."""
        reach = np.maximum(_NEAR_SHARE * self.sizes[0], self.reach)
        olds, news = self._candidates(olds, news, _NO_SHIFT, reach[olds])
        away = self.centres[1][news] - self.centres[0][olds]
        growth = np.abs(self.diagonals[1][news] - self.diagonals[0][olds])
        is_near = (np.abs(away) <= reach[olds]).all(axis=1) & (growth <= _NEAR_SHARE * self.diagonals[0][olds])
        return self._nearest_first(olds, news, np.where(is_near, np.sqrt((away * away).sum(axis=1)), np.inf))

    def _add_unknown(self, new_of_old: Rows) -> None:
        """Adds pairs with equal keys if a shape is unknown, as in files of older versions."""
        row_of_key = {key: row for row, key in enumerate(self.new.keys)}
        taken = set(new_of_old.tolist())
        is_known = self.old.is_known, self.new.is_known
        for old in np.flatnonzero(new_of_old < 0).tolist():
            new = row_of_key.get(self.old.keys[old], -1)
            if new >= 0 and new not in taken and not (is_known[0][old] and is_known[1][new]):
                new_of_old[old] = new


def _chords(old: Shapes, new: Shapes) -> tuple[Floats, Floats]:
    """How far facets may be from their surfaces, metres; NaN for parts of older files."""
    return _CHORD_SHARE * old.chord, np.nan_to_num(_CHORD_SHARE * new.chord)


def _renamed_folders(
    olds: Sequence[str], news: Sequence[str], new_of_old: Rows
) -> dict[tuple[str, ...], tuple[str, ...]]:
    """The steps of each folder that has another name now, by those before; the most frequent if parts disagree."""
    votes: Counter[tuple[tuple[str, ...], tuple[str, ...]]] = Counter()
    for old in np.flatnonzero(new_of_old >= 0).tolist():
        before, now = olds[old], news[int(new_of_old[old])]
        if before != now:
            one, other = before.split("/"), now.split("/")
            same = _common(one[::-1], other[::-1])
            if same:
                votes[tuple(one[: len(one) - same]), tuple(other[: len(other) - same])] += 1
    found: dict[tuple[str, ...], tuple[str, ...]] = {}
    for (before_steps, now_steps), _ in votes.most_common():
        found.setdefault(before_steps, now_steps)
    return found


def _mates(old: Shapes, new: Shapes) -> tuple[Rows, Rows]:
    """Pairs of parts with the same path, unique on both sides, and with known shapes."""
    single = [
        {path: rows[0] for path, rows in _by_path(each.paths, np.arange(len(each.keys))).items() if len(rows) == 1}
        for each in (old, new)
    ]
    is_known = old.is_known, new.is_known
    pairs = [(row, single[1][path]) for path, row in single[0].items() if path in single[1]]
    return _columns([(a, b) for a, b in pairs if is_known[0][a] and is_known[1][b]])


def _by_shape(shapes: Shapes, sizes: Floats) -> dict[tuple[float, ...], list[int]]:
    """The rows of each shape, by size and area."""
    found: dict[tuple[float, ...], list[int]] = defaultdict(list)
    for row, (size, area) in enumerate(zip(sizes.tolist(), shapes.area.tolist(), strict=True)):
        if math.isfinite(area):
            found[tuple(float(f"{each:.4g}") for each in (*size, area))].append(row)
    return found


def _by_path(paths: Sequence[str], rows: Rows) -> dict[str, list[int]]:
    found: dict[str, list[int]] = defaultdict(list)
    for row in rows.tolist():
        found[paths[row]].append(row)
    return found


def _columns(pairs: Sequence[tuple[int, int]]) -> tuple[Rows, Rows]:
    both = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    return both[:, 0], both[:, 1]


def _doublings(diagonals: Floats) -> npt.NDArray[np.int64]:
    """The exponent of the next power of two above each length."""
    return np.frexp(np.where(diagonals > 0.0, diagonals, 1e-9))[1].astype(np.int64)


def _common(one: Sequence[str], other: Sequence[str]) -> int:
    """The number of equal leading steps."""
    return next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


def _one_to_one(pairs: Iterable[tuple[int, int]]) -> Iterable[tuple[int, int]]:
    """Drops pairs that contain a part of an earlier pair."""
    olds: set[int] = set()
    news: set[int] = set()
    for old, new in pairs:
        if old not in olds and new not in news:
            olds.add(old)
            news.add(new)
            yield old, new
