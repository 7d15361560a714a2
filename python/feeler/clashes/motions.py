"""Decides which motion the whole assembly made: it stayed in its place, or all of it is shifted.

    matches under each motion -> two by two: which one takes the parts, and which one a copy of them

Copies and patterns match under wrong motions, too, and often more parts than under the right one. So paths and places
decide before numbers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.clashes.shapes import Floats

Rows = npt.NDArray[np.intp]
Mask = npt.NDArray[np.bool_]

_BY_PATH_SHARE = 0.75
"""The share of parts with unchanged paths that must make a motion for it to be that of the whole. Numbered names that
move up do not reach it, since the part that they are fastened to does not move with them."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Parts that match under one motion of the whole.

    shift: metres. new_of_old: the row of now for each row of before, or -1.
    """

    shift: Floats
    new_of_old: Rows

    @property
    def is_still(self) -> bool:
        """Whether the whole stayed in its place."""
        return not self.shift.any()

    @property
    def is_matched(self) -> Mask:
        """Which rows of before match."""
        return self.new_of_old >= 0

    @property
    def count(self) -> int:
        """How many parts match."""
        return int(np.count_nonzero(self.is_matched))


@dataclass(frozen=True)
class Evidence:
    """What motions are judged by.

    paths: before and now. shape: the number of the shape of each row of before, or -1. is_unique: whether no other part
    before has its shape. mates: rows with the same path, unique on both sides, and the same shape.
    """

    paths: tuple[Sequence[str], Sequence[str]]
    shape: Rows
    is_unique: Mask
    mates: tuple[Rows, Rows]

    def chosen(self, motions: Iterable[Motion]) -> tuple[Rows, Mask]:
        """The matches under the motion of the whole, the first of several that are equally likely; and which parts
        match none since paths and places do not tell their copies apart.
        """
        best, *others = motions
        is_doubtful = np.zeros(len(best.new_of_old), dtype=bool)
        for other in others:
            rivals = self._rivals(other, best)
            is_better, is_certain = self._is_better(other, best, rivals)
            if is_better:
                best, is_doubtful = other, np.zeros_like(is_doubtful)
            if not is_certain:
                is_doubtful |= self._is_beside(rivals)
        return np.where(is_doubtful, -1, best.new_of_old), is_doubtful

    def _rivals(self, one: Motion, other: Motion) -> Mask:
        """The parts that match two parts of the new mock-up, one under each motion. A pattern that moved by its pitch
        has none: the place of each part had another part of the pattern before."""
        a, b = one.new_of_old, other.new_of_old
        is_image = [self._images(each) for each in (one, other)]
        found: Mask = (a >= 0) & (b >= 0) & (a != b) & ~is_image[1][a] & ~is_image[0][b]
        return found

    def _images(self, motion: Motion) -> Mask:
        """Which rows of now match."""
        found = np.zeros(len(self.paths[1]) + 1, dtype=bool)
        found[motion.new_of_old] = True
        return found[:-1]

    def _is_better(self, one: Motion, other: Motion, rivals: Mask) -> tuple[bool, bool]:
        """Whether the whole made the first motion rather than the second; and whether it is certain which of two copies
        is the original.
        """
        for still, moved in ((one, other), (other, one)):
            # If all that has moved is in the place of an equal part, names were exchanged.
            if still.is_still and still.count and not (self._images(moved) & ~self._images(still)).any():
                return still is one, True
        counts = one.count, other.count
        is_close = 2 * min(counts) > max(counts)
        by_path = [self._path_share(each) >= _BY_PATH_SHARE for each in (one, other)]
        if by_path[0] != by_path[1]:
            winner = by_path.index(True)
            if rivals.any():
                # The paths that only the copy has are of parts that the original lost.
                same = self._kept_paths(rivals, one), self._kept_paths(rivals, other)
                is_told = same[winner] > same[1 - winner]
            else:
                is_told = is_close or counts[winner] > counts[1 - winner]
            if is_told:
                return winner == 0, True
        if rivals.any() and one.is_still != other.is_still:
            return one.is_still, True
        weights = self._weight(one), self._weight(other)
        likeness, outside = self._likeness(rivals, one, other), self._more_outside(rivals, one, other)
        uniques = int(np.count_nonzero(rivals & self.is_unique)), max(weights[0][0], weights[1][0])
        # Bolts that are new in a pattern are no copy: its plate is there once.
        if 2 * np.count_nonzero(rivals) > max(counts) and (uniques[0] or not uniques[1]):
            more = likeness or outside
            return more > 0, more != 0
        if rivals.any() and outside:
            return outside > 0, True
        if weights[0] == weights[1] and is_close:
            if one.is_still != other.is_still:
                return one.is_still, True
            likeness = self._likeness(one.is_matched & other.is_matched, one, other)
            if likeness:
                return likeness > 0, True
        is_better = (weights[0], counts[0]) > (weights[1], counts[1])
        # If most parts with a shape of their own have two copies, paths must say that the fuller one is the original.
        return is_better, 2 * uniques[0] <= uniques[1] or (likeness > 0 if is_better else likeness < 0)

    def _path_share(self, motion: Motion) -> float:
        """The share of parts with unchanged paths and shapes that made a motion: the mean over all shapes."""
        olds, news = self.mates
        if not len(olds):
            return 0.0
        shape = self.shape[olds] + 1  # those of no shape first
        totals = np.bincount(shape)
        moved = np.bincount(shape, motion.new_of_old[olds] == news)
        return float((moved[totals > 0] / totals[totals > 0]).mean())

    def _kept_paths(self, olds: Mask, motion: Motion) -> int:
        """How many of these parts match parts of the same path."""
        rows = np.flatnonzero(olds)
        pairs = zip(rows.tolist(), motion.new_of_old[rows].tolist(), strict=True)
        return sum(self.paths[0][old] == self.paths[1][new] for old, new in pairs)

    def _weight(self, motion: Motion) -> tuple[int, int]:
        """How many parts of a shape of their own match, and how many shapes.

        Not how many parts: a pattern matches itself when it moves by its pitch.
        """
        is_matched = motion.is_matched
        shapes = np.count_nonzero(np.bincount(self.shape[is_matched & (self.shape >= 0)]))
        return int(np.count_nonzero(self.is_unique & is_matched)), int(shapes)

    def _more_outside(self, rivals: Mask, one: Motion, other: Motion) -> int:
        """How many more parts match under the first motion, of the sub-assemblies that have no rivals: those that were
        not copied."""
        outside = ~self._is_beside(rivals)
        return int(np.count_nonzero(one.is_matched & outside) - np.count_nonzero(other.is_matched & outside))

    def _is_beside(self, rivals: Mask) -> Mask:
        """Which parts are in a sub-assembly with one of these."""
        folders = [path.rpartition("/")[0] for path in self.paths[0]]
        some = {folders[row] for row in np.flatnonzero(rivals).tolist()}
        return np.array([folder in some for folder in folders], dtype=bool)

    def _likeness(self, olds: Mask, one: Motion, other: Motion) -> int:
        """How many more path steps parts share with their match under the first motion."""
        rows = np.flatnonzero(olds)
        return sum(
            self._shared(old, a) - self._shared(old, b)
            for old, a, b in zip(
                rows.tolist(), one.new_of_old[rows].tolist(), other.new_of_old[rows].tolist(), strict=True
            )
            if a != b
        )

    def _shared(self, old: int, new: int) -> int:
        return shared_steps(self.paths[0][old], self.paths[1][new])


def shared_steps(one: str, other: str) -> int:
    """How many steps two paths share, in any place: a level may have come between."""
    return (Counter(one.split("/")) & Counter(other.split("/"))).total()
