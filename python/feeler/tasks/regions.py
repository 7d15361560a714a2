"""Where a row of the nightly run looked: boxes, and boxes that move straight. It tells which changes bear on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

GROWN_M = 2e-6
"""What regions are grown by, metres: more than casts, and the decimals of a file, are off by."""
_DECIMALS = 7
_LOOSE = 1.2
"""A box takes in others, the largest first, until it is this much larger."""
_MOST_LOOSE = 400
"""Boxes that are joined at a time."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Where questions looked. `asked` names parts that they depend on wherever these are."""

    is_all: bool
    """Whether they depend on the whole mock-up."""
    boxes: Floats
    """`(n, 2, 3)`: lower and upper corners, metres, world."""
    sweeps: Floats
    """`(m, 3, 3)`: lower and upper corners of boxes, and how far each of them moved."""
    asked: frozenset[str]

    @classmethod
    def everything(cls) -> Regions:
        """The whole mock-up."""
        return cls(True, np.empty((0, 2, 3)), np.empty((0, 3, 3)), frozenset())

    def meets(self, lower: Floats, upper: Floats) -> bool:
        """Whether a box `(3,)`, `(3,)` meets one of the regions. A box that is not finite does."""
        if self.is_all or not (np.isfinite(lower).all() and np.isfinite(upper).all()):
            return True
        if ((self.boxes[:, 0] <= upper + GROWN_M) & (self.boxes[:, 1] >= lower - GROWN_M)).all(axis=1).any():
            return True
        # A box that moves meets another where its corner meets that one, grown by its sides.
        low = lower - GROWN_M - (self.sweeps[:, 1] - self.sweeps[:, 0])
        begin, way = self.sweeps[:, 0], self.sweeps[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([(low - begin) / way, (upper + GROWN_M - begin) / way])
        stays = way == 0.0
        is_in = (begin >= low) & (begin <= upper + GROWN_M)
        first = np.where(stays, np.where(is_in, -np.inf, np.inf), ends.min(axis=0))
        last = np.where(stays, np.where(is_in, np.inf, -np.inf), ends.max(axis=0))
        return bool((np.maximum(first.max(axis=1), 0.0) <= np.minimum(last.min(axis=1), 1.0)).any())

    def to_dict(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "is_all": self.is_all,
            "boxes": np.round(self.boxes.reshape(-1, 6), _DECIMALS).tolist(),
            "sweeps": np.round(self.sweeps.reshape(-1, 9), _DECIMALS).tolist(),
            "asked": sorted(self.asked),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Regions:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        boxes = np.array(data["boxes"], dtype=np.float64).reshape(-1, 2, 3)
        sweeps = np.array(data["sweeps"], dtype=np.float64).reshape(-1, 3, 3)
        return cls(bool(data["is_all"]), boxes, sweeps, frozenset(str(each) for each in data["asked"]))


class Noted:
    """Collects regions."""

    def __init__(self, lower: Floats, upper: Floats) -> None:
        """lower, upper: the box of the mock-up. Regions end there."""
        self.lower, self.upper = lower, upper
        self.is_all = False
        self.is_on = True
        self.asked: set[str] = set()
        self._boxes: list[Floats] = []
        self._kept = np.empty((0, 2, 3))
        self._sweeps: dict[bytes, list[float]] = {}
        self._shapes: dict[bytes, tuple[Floats, Floats, Floats]] = {}

    def all(self) -> None:
        """Notes the whole mock-up."""
        self.is_all = self.is_all or self.is_on

    def box(self, lower: Floats, upper: Floats) -> None:
        """Notes a box."""
        if not self.is_on or self.is_all:
            return
        low, high = np.maximum(lower, self.lower), np.minimum(upper, self.upper)
        if (low <= high).all():
            self._boxes.append(np.stack([low, high]))
            if len(self._boxes) >= _MOST_LOOSE:
                self._join()

    def sweep(self, lower: Floats, upper: Floats, way: Floats) -> None:
        """Notes a box that moves straight."""
        length = float(np.linalg.norm(way))
        if not self.is_on or self.is_all:
            return
        if length < 1e-12:
            return self.box(lower, upper)
        along, half, middle = way / length, 0.5 * (upper - lower), 0.5 * (upper + lower)
        start = float(middle @ along)
        across = middle - start * along
        key = np.round(np.concatenate([half, along, across]), 8).tobytes()
        self._shapes.setdefault(key, (half, along, across))
        known = self._sweeps.setdefault(key, [start, start])
        known[0], known[1] = min(known[0], start), max(known[1], start + length)

    def regions(self) -> Regions:
        """All that was noted."""
        if self.is_all:
            return Regions(True, np.empty((0, 2, 3)), np.empty((0, 3, 3)), frozenset(self.asked))
        self._join()
        sweeps = [
            np.stack([across + begin * along - half, across + begin * along + half, (end - begin) * along])
            for key, (begin, end) in self._sweeps.items()
            for half, along, across in [self._shapes[key]]
        ]
        return Regions(False, self._kept, np.array(sweeps).reshape(-1, 3, 3), frozenset(self.asked))

    def _join(self) -> None:
        """Boxes that are nearly one become one."""
        boxes = np.concatenate([self._kept, np.array(self._boxes).reshape(-1, 2, 3)])
        self._boxes = []
        kept, most = np.empty((0, 2, 3)), np.empty(0)
        for box in boxes[np.argsort(-_size(boxes), kind="stable")]:
            joined = np.stack([np.minimum(kept[:, 0], box[0]), np.maximum(kept[:, 1], box[1])], axis=1)
            size = _size(joined)
            near = np.flatnonzero(size <= np.maximum(most, _size(kept)))
            if len(near):
                best = near[int(np.argmin(size[near] - _size(kept[near])))]
                kept[best] = joined[best]
            else:
                kept, most = np.concatenate([kept, box[None]]), np.append(most, _LOOSE * _size(box[None]))
        self._kept = kept


def _size(boxes: Floats) -> Floats:
    """The sums of the sides of boxes, which flat boxes have too."""
    return np.asarray((boxes[:, 1] - boxes[:, 0]).sum(axis=1))


def box_of(bounds: Iterable[Floats]) -> tuple[Floats, Floats]:
    """The box of boxes `(2, 3)`, of the finite ones alone; empty at the origin if there are none."""
    known = np.array([each for each in bounds if np.isfinite(each).all()]).reshape(-1, 2, 3)
    if not len(known):
        return np.zeros(3), np.zeros(3)
    return known[:, 0].min(axis=0), known[:, 1].max(axis=0)
