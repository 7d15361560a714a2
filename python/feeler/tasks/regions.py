"""Where a row of the nightly run looked: boxes, and boxes that move straight. It tells which changes bear on it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

GROWN_M = 2e-6
"""What regions are grown by, metres: more than casts, and the decimals of a file, are off by."""
SHORT_M = 1e-12
"""Sweeps that are no longer are boxes, metres."""
_DECIMALS = 7
_LOOSE = 1.2
"""A box takes in others, the largest first, until it is this much larger."""
_MOST_LOOSE = 400
"""Boxes that are joined at a time."""
_MOST_SWEEPS = 400
"""Sweeps that `coarse` leaves as they are."""
_MOST_TOOLS = 16
"""Tools of which boxes are kept."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Where questions looked. `asked` names parts that they depend on wherever these are."""

    is_all: bool
    """Whether they depend on the whole mock-up."""
    boxes: Floats
    """`(n, 2, 3)`: lower and upper corners, metres, world. There they looked for surfaces."""
    sweeps: Floats
    """`(m, 3, 3)`: lower and upper corners of boxes, and how far each of them moved. Surfaces as well."""
    solids: Floats
    """`(k, 2, 3)`: where they also asked what is around."""
    asked: frozenset[str]

    @classmethod
    def everything(cls) -> Regions:
        """The whole mock-up."""
        return cls(True, np.empty((0, 2, 3)), np.empty((0, 3, 3)), np.empty((0, 2, 3)), frozenset())

    def bear(self, bounds: Floats, surface: Floats) -> bool:
        """Whether they looked at a part. bounds: its box `(2, 3)`; surface: boxes `(n, 2, 3)` around its triangles."""
        if self.is_all or not np.isfinite(bounds).all():
            return True
        if ((self.solids[:, 0] <= bounds[1] + GROWN_M) & (self.solids[:, 1] >= bounds[0] - GROWN_M)).all(axis=1).any():
            return True
        return self.meets(*bounds) and self._meet(surface)

    def around(self) -> Floats:
        """`(n, 2, 3)`: boxes around all that they looked at."""
        ends = self.sweeps[:, :2] + self.sweeps[:, 2:]
        swept = np.stack([np.minimum(self.sweeps[:, 0], ends[:, 0]), np.maximum(self.sweeps[:, 1], ends[:, 1])], axis=1)
        return np.concatenate([self.boxes, self.solids, swept])

    def meets(self, lower: Floats, upper: Floats) -> bool:
        """Whether a box `(3,)`, `(3,)` meets where they looked for surfaces. A box that is not finite does."""
        return self._meet(np.stack([lower, upper])[None])

    def _meet(self, surface: Floats) -> bool:
        """Whether one of boxes `(n, 2, 3)` does."""
        if self.is_all or not np.isfinite(surface).all():
            return True
        lower, upper = surface[None, :, 0] - GROWN_M, surface[None, :, 1] + GROWN_M
        if ((self.boxes[:, None, 0] <= upper) & (self.boxes[:, None, 1] >= lower)).all(axis=2).any():
            return True
        sweeps = self.sweeps[:, None]
        # A box that moves meets another where its corner meets that one, grown by its sides.
        begin, way = sweeps[:, :, 0], sweeps[:, :, 2]
        lower = lower - (sweeps[:, :, 1] - begin)
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (lower - begin) / way, (upper - begin) / way
        stays, is_in = way == 0.0, (begin >= lower) & (begin <= upper)
        first = np.where(stays, np.where(is_in, -np.inf, np.inf), np.minimum(one, other))
        last = np.where(stays, np.where(is_in, np.inf, -np.inf), np.maximum(one, other))
        return bool((np.maximum(first.max(axis=2), 0.0) <= np.minimum(last.min(axis=2), 1.0)).any())

    def coarse(self) -> Regions:
        """At most about so many sweeps: beyond, boxes that move alike are one."""
        if len(self.sweeps) <= _MOST_SWEEPS:
            return self
        ways, group = np.unique(np.round(self.sweeps[:, 2], _DECIMALS), axis=0, return_inverse=True)
        low, high = np.full((len(ways), 3), np.inf), np.full((len(ways), 3), -np.inf)
        exact = np.empty((len(ways), 3))
        group = group.reshape(-1)
        np.minimum.at(low, group, self.sweeps[:, 0])
        np.maximum.at(high, group, self.sweeps[:, 1])
        exact[group] = self.sweeps[:, 2]
        return replace(self, sweeps=np.stack([low, high, exact], axis=1).reshape(-1, 3, 3))

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return {
            "is_all": self.is_all,
            "boxes": np.round(self.boxes.reshape(-1, 6), _DECIMALS).tolist(),
            "sweeps": np.round(self.sweeps.reshape(-1, 9), _DECIMALS).tolist(),
            "solids": np.round(self.solids.reshape(-1, 6), _DECIMALS).tolist(),
            "asked": sorted(self.asked),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Regions:
        """What `to_dict` gave. Raises `KeyError`, `TypeError`, `ValueError` for other data."""
        boxes = np.array(data["boxes"], dtype=np.float64).reshape(-1, 2, 3)
        sweeps = np.array(data["sweeps"], dtype=np.float64).reshape(-1, 3, 3)
        solids = np.array(data["solids"], dtype=np.float64).reshape(-1, 2, 3)
        return cls(bool(data["is_all"]), boxes, sweeps, solids, frozenset(str(each) for each in data["asked"]))


class Columns:
    """Boxes `(n, 2, 3)` by coordinate: asked many times for those that meet another."""

    def __init__(self, boxes: Floats) -> None:
        self._lower, self._upper = np.ascontiguousarray(boxes.transpose(1, 2, 0))

    def meeting(self, lower: Floats, upper: Floats) -> Bools:
        """`(n,)`: which of them meet a box `(3,)`, `(3,)`; boxes with NaN meet none."""
        found = np.ones(self._lower.shape[1], dtype=bool)
        for low, high, begin, end in zip(self._lower, self._upper, lower.tolist(), upper.tolist(), strict=True):
            found &= low <= end
            found &= high >= begin
        return found


def near(regions: Sequence[Regions], bounds: Floats) -> Bools:
    """Whether `bear` of regions may be true of boxes `(n, 2, 3)`, by boxes around sweeps: `(len(regions), n)`."""
    looked = [each.around() for each in regions]
    owners = np.repeat(np.arange(len(looked)), [len(each) for each in looked])
    boxes = np.concatenate([np.empty((0, 2, 3)), *looked])
    found = np.zeros((len(regions), len(bounds)), dtype=bool)
    for n, (lower, upper) in enumerate(bounds):
        is_met = ((lower - GROWN_M <= boxes[:, 1]) & (upper + GROWN_M >= boxes[:, 0])).all(axis=1)
        found[owners[is_met], n] = True
    found[[each.is_all for each in regions]] = True
    found[:, np.logical_not(np.isfinite(bounds).all(axis=(1, 2)))] = True
    return found


class Noted:
    """Collects regions."""

    def __init__(self, lower: Floats, upper: Floats) -> None:
        """lower, upper: the box of the mock-up. Regions end there."""
        self.lower, self.upper = lower, upper
        self.is_on = True
        self._layers = [_Layer()]
        self._leaves: dict[tuple[int, int], tuple[Any, Floats]] = {}

    @property
    def is_all(self) -> bool:
        """Whether the whole mock-up was noted."""
        return self._layers[-1].is_all

    def boxes_of(self, tool: Any, most: int = 16) -> Floats:
        """Boxes `(n, 2, 3)` around the triangles of a tool, at most so many, in its frame."""
        key = (id(tool), most)
        known = self._leaves.get(key)
        if known is None or known[0] is not tool:
            while len(self._leaves) >= _MOST_TOOLS:
                del self._leaves[next(iter(self._leaves))]
            known = self._leaves[key] = tool, leaves(np.asarray(tool.vertices)[np.asarray(tool.faces)], most)
        return known[1]

    @contextmanager
    def apart(self) -> Iterator[Callable[[], Regions]]:
        """Notes what follows also by itself. Gives a function that says where it looked so far."""
        layer, was_on = _Layer(), self.is_on
        self._layers.append(layer)
        self.is_on = True
        try:
            yield layer.regions
        finally:
            self._layers.pop()
            self.is_on = was_on
            self.add(layer.regions())

    def all(self) -> None:
        """Notes the whole mock-up."""
        layer = self._layers[-1]
        layer.is_all = layer.is_all or self.is_on

    def add(self, regions: Regions) -> None:
        """Notes all of some regions."""
        if regions.is_all:
            return self.all()
        layer = self._layers[-1]
        self.ask(regions.asked)
        if self.is_on and not layer.is_all and layer.is_new(regions):
            layer.boxes.extend(regions.boxes)
            layer.solids.extend(regions.solids)
            layer.swept.append(regions.sweeps)

    def ask(self, parts: Iterable[str]) -> None:
        """Notes parts, wherever they are."""
        if self.is_on:
            self._layers[-1].asked.update(parts)

    def box(self, lower: Floats, upper: Floats, is_solid: bool = False) -> None:
        """Notes a box. is_solid: also what is around it."""
        layer = self._layers[-1]
        if not self.is_on or layer.is_all:
            return
        low, high = np.maximum(lower, self.lower), np.minimum(upper, self.upper)
        if (low <= high).all():
            layer.boxes.extend([np.stack([low, high])])
            if is_solid:
                layer.solids.extend([np.stack([low, high])])

    def sweep(self, boxes: Floats, way: Floats) -> None:
        """Notes boxes `(n, 2, 3)` that move straight."""
        layer = self._layers[-1]
        if not self.is_on or layer.is_all:
            return
        if float(np.linalg.norm(way)) < SHORT_M:
            for lower, upper in boxes:
                self.box(lower, upper)
        else:
            layer.sweep(boxes, way)

    def regions(self) -> Regions:
        """All that was noted."""
        return self._layers[-1].regions()


class NotedParts(Noted):
    """Of a scene of few parts: all its queries look at these, and at no others."""

    def __init__(self, noted: Noted, parts: Iterable[str]) -> None:
        super().__init__(noted.lower, noted.upper)
        self._noted, self._parts = noted, frozenset(parts)

    def all(self) -> None:
        """Notes the parts."""
        self._noted.ask(self._parts)

    def box(self, lower: Floats, upper: Floats, is_solid: bool = False) -> None:
        """Notes the parts."""
        self.all()

    def sweep(self, boxes: Floats, way: Floats) -> None:
        """Notes the parts."""
        self.all()

    def add(self, regions: Regions) -> None:
        """Notes the parts."""
        self._noted.ask(regions.asked)
        self.all()

    @contextmanager
    def apart(self) -> Iterator[Callable[[], Regions]]:
        """As `Noted`."""
        with self._noted.apart() as looked:
            yield looked


class _Layer:
    """Regions that grow."""

    def __init__(self) -> None:
        self.is_all = False
        self.asked: set[str] = set()
        self.boxes, self.solids = _Boxes(), _Boxes()
        self.swept: list[Floats] = []
        """Sweeps `(n, 3, 3)` that stay as they are."""
        self._sweeps: dict[bytes, list[float]] = {}
        self._shapes: dict[bytes, tuple[Floats, Floats, Floats]] = {}
        self._added: dict[int, Regions] = {}

    def is_new(self, regions: Regions) -> bool:
        """Whether regions were not added yet; they are taken for added. Answers are recalled again and again."""
        known = id(regions) in self._added
        self._added[id(regions)] = regions
        return not known

    def sweep(self, boxes: Floats, way: Floats) -> None:
        """Boxes that move straight; those of the same boxes along one line become one."""
        length = float(np.linalg.norm(way))
        along, half, middles = way / length, 0.5 * (boxes[:, 1] - boxes[:, 0]), 0.5 * (boxes[:, 1] + boxes[:, 0])
        start = float(middles[0] @ along)
        across = middles - start * along
        key = np.round(np.concatenate([half.ravel(), along, across.ravel()]), 8).tobytes()
        self._shapes.setdefault(key, (half, along, across))
        known = self._sweeps.setdefault(key, [start, start])
        known[0], known[1] = min(known[0], start), max(known[1], start + length)

    def regions(self) -> Regions:
        """All of it."""
        if self.is_all:
            return replace(Regions.everything(), asked=frozenset(self.asked))
        sweeps = [np.empty((0, 3, 3)), *self.swept]
        for key, (begin, end) in self._sweeps.items():
            half, along, across = self._shapes[key]
            middles = across + begin * along
            ways = np.broadcast_to((end - begin) * along, half.shape)
            sweeps.append(np.stack([middles - half, middles + half, ways], axis=1))
        boxes, solids = self.boxes.joined().copy(), self.solids.joined().copy()
        return Regions(False, boxes, np.concatenate(sweeps), solids, frozenset(self.asked))


class _Boxes:
    """Boxes, of which those that are nearly one become one."""

    def __init__(self) -> None:
        self._new: list[Floats] = []
        self._kept = np.empty((0, 2, 3))
        self._most = np.empty(0)

    def extend(self, boxes: Iterable[Floats]) -> None:
        """Adds boxes, each `(2, 3)`."""
        self._new.extend(boxes)
        if len(self._new) >= _MOST_LOOSE:
            self.joined()

    def joined(self) -> Floats:
        """All of them, `(n, 2, 3)`."""
        new = np.array(self._new).reshape(-1, 2, 3)
        self._new = []
        for box in new[np.argsort(-_size(new), kind="stable")]:
            joined = np.stack([np.minimum(self._kept[:, 0], box[0]), np.maximum(self._kept[:, 1], box[1])], axis=1)
            size = _size(joined)
            near = np.flatnonzero(size <= self._most)
            if len(near):
                best = near[int(np.argmin(size[near] - _size(self._kept[near])))]
                self._kept[best] = joined[best]
            else:
                self._kept = np.concatenate([self._kept, box[None]])
                self._most = np.append(self._most, _LOOSE * _size(box[None]))
        return self._kept


def _size(boxes: Floats) -> Floats:
    """The sums of the sides of boxes, which flat boxes have too."""
    return np.asarray((boxes[:, 1] - boxes[:, 0]).sum(axis=1))


def box_of(bounds: Iterable[Floats]) -> tuple[Floats, Floats]:
    """The box of boxes `(2, 3)`, of the finite ones alone; empty at the origin if there are none."""
    known = np.array([each for each in bounds if np.isfinite(each).all()]).reshape(-1, 2, 3)
    if not len(known):
        return np.zeros(3), np.zeros(3)
    return known[:, 0].min(axis=0), known[:, 1].max(axis=0)


def leaves(corners: Floats, most: int = 16) -> Floats:
    """At most so many boxes `(n, 2, 3)` around triangles `(k, 3, 3)`, halved along their longest sides."""
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    groups = [np.arange(len(corners))] if len(corners) else []
    boxes = [_around(lower, upper, each) for each in groups]
    while 0 < len(groups) < most:
        sizes = [(box[1] - box[0]).sum() if len(group) > 1 else -1.0 for box, group in zip(boxes, groups, strict=True)]
        n = int(np.argmax(sizes))
        group = groups[n]
        if len(group) < 2:
            break
        axis = int(np.argmax(boxes[n][1] - boxes[n][0]))
        order = group[np.argsort(lower[group, axis] + upper[group, axis], kind="stable")]
        halves = [order[: len(order) // 2], order[len(order) // 2 :]]
        groups[n : n + 1] = halves
        boxes[n : n + 1] = [_around(lower, upper, each) for each in halves]
    return np.array(boxes).reshape(-1, 2, 3)


def _around(lower: Floats, upper: Floats, group: npt.NDArray[np.intp]) -> Floats:
    return np.stack([lower[group].min(axis=0), upper[group].max(axis=0)])
