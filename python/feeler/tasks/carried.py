"""What can leave with a part: smaller parts that are fastened to it alone, with their fasteners, where they are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from feeler.part_meshes import PartMeshes
from feeler.plan.question import TARGET
from feeler.tasks.fixings import Fixings
from feeler.tasks.together import Together

SMALLER = 1.0 - 1e-6
"""A part is smaller if it is by more than this share: in another pose sizes differ by rounding."""
LITTLE = 0.5
"""What a part carries that is fastened to no larger one: all riders together have less than this share of its surface.
With a larger value, what it was to be taken off may leave with it."""


@dataclass(frozen=True)
class _Edge:
    """A fastener, and what it fastens to each other."""

    loosened_by: frozenset[int]
    """The items of which one is undone: it, or its nut."""
    members: frozenset[int]
    """The items that it joins, and itself."""


@dataclass(frozen=True)
class _Around:
    """What is fastened to a part, as far as it is small enough to leave with it."""

    here: frozenset[int]
    """The part, and what leaves with it in any case."""
    edges: tuple[_Edge, ...]
    reached: frozenset[int]
    """All items that these join, and all that loosen them."""
    hangs: bool
    """Whether the part is fastened to a larger one, or to one that stays."""


class Carried:
    """The riders of the parts of a question, worked out when they are asked for.

    A part rides on another one that is larger, in surface and in reach from its middle, if nothing fastens it to
    others, but for other riders. One that is fastened to the part itself, but to others, too, can ride on it when it is
    undone from these: an extension. What is kept does not ride, nor what a kept fastener holds. A part that is fastened
    to no larger one, and to none that is kept, may be what the others hang on: it carries little only, `LITTLE`, and
    only if it is wanted or smaller than that. Nothing rides where nothing would be left.
    """

    def __init__(self, question: Together, fixings: Fixings) -> None:
        self.question, self.fixings = question, fixings
        self._arounds: dict[int, _Around] = {}
        self._riding: dict[tuple[int, frozenset[int], frozenset[int]], frozenset[int]] = {}
        self._carriers: dict[int, frozenset[int]] = {}
        self._sizes: dict[int, tuple[float, float]] = {}

    def riding(self, item: int, off: frozenset[int] = frozenset(), on: frozenset[int] = frozenset()) -> frozenset[int]:
        """What rides on a part when items are off. on: parts that are to, though they are fastened to others."""
        around = self._around(item)
        key = (item, off & around.reached, on)
        if key not in self._riding:
            self._riding[key] = self._found(item, around, off & around.reached, on)
        return self._riding[key]

    def extensions(self, item: int, off: frozenset[int], on: frozenset[int]) -> list[frozenset[int]]:
        """Parts that are fastened to a part and to others, and can ride on it all the same; together if one fastener
        holds them."""
        around = self._around(item)
        riding = self.riding(item, off, on)
        found = set()
        for edge in around.edges:
            more = edge.members - around.here - riding - edge.loosened_by
            if not (edge.members & around.here and more) or (edge.loosened_by | more) & off:
                continue
            may = all(each not in self.fixings and self._may_ride(each, item) for each in more)
            if may and more <= self.riding(item, off, on | more):
                found.add(more)
        return sorted(found, key=sorted)

    def carriers(self, item: int) -> frozenset[int]:
        """The parts that an item can ride on."""
        if item not in self._carriers:
            found, seen, waiting = set[int](), {item}, [item]
            while waiting:
                for edge in self._by_member.get(waiting.pop(0), ()):
                    for other in sorted(edge.members - seen):
                        seen.add(other)
                        is_carrier = item in self.riding(other)
                        if is_carrier or any(self._rides(item, other, more) for more in self._extended(other)):
                            found.add(other)
                        if is_carrier or other in self.fixings or self.is_smaller(other, item):
                            waiting.append(other)
            self._carriers[item] = frozenset(found)
        return self._carriers[item]

    def _extended(self, item: int) -> list[frozenset[int]]:
        return self.extensions(item, frozenset(), frozenset())

    def _rides(self, item: int, carrier: int, more: frozenset[int]) -> bool:
        return item in self.riding(carrier, frozenset(), more)

    @cached_property
    def _by_member(self) -> dict[int, list[_Edge]]:
        """The fasteners of each item."""
        question, fixings, found = self.question, self.fixings, dict[int, list[_Edge]]()
        mask = question.scene.part_mask
        for part in fixings:
            joined = [each for each in fixings.joins(part) if mask[each]]
            if mask[part] and joined and part not in fixings.loose:
                axis = frozenset([part, *fixings.axis_mates(part)])
                edge = _Edge(axis, frozenset(map(question.node_of, (part, *joined))))
                for each in edge.members:
                    found.setdefault(each, []).append(edge)
        return found

    def _around(self, item: int) -> _Around:
        if item not in self._arounds:
            self._arounds[item] = self._looked(item)
        return self._arounds[item]

    def _looked(self, item: int) -> _Around:
        """All fasteners of a part, and of what is small enough to leave with it, from one to the next."""
        is_part = bool(self.question.wanted) if item == TARGET else item not in self.fixings
        own = frozenset(map(self.question.node_of, self.question.parts_of([item]))) | {item}
        touching = [edge for each in sorted(own) for edge in self._by_member.get(each, ()) if edge.members - own]
        hangs = self._hangs(item, own, touching)
        if not is_part or self._is_kept(item) or not (hangs or self._is_light(item)):
            return _Around(own, (), frozenset(), hangs)
        edges, seen, waiting = dict.fromkeys(touching), set(own), [each for edge in touching for each in edge.members]
        while waiting:
            each = waiting.pop(0)
            if each not in seen and self._may_ride(each, item):
                more = self._by_member.get(each, ())
                edges.update(dict.fromkeys(more))
                waiting += [other for edge in more for other in sorted(edge.members)]
            seen.add(each)
        reached = frozenset[int]().union(*(edge.members | edge.loosened_by for edge in edges)) - own
        return _Around(own, tuple(edges), reached, hangs)

    def _found(self, item: int, around: _Around, off: frozenset[int], on: frozenset[int]) -> frozenset[int]:
        """What rides on a part."""
        edges = [edge for edge in around.edges if not edge.loosened_by & off]
        here = around.here | on
        touching = [edge for edge in edges if edge.members & here and edge.members - here]
        good, inner = self._free(item, here, edges, off)
        inner += [edge for edge in edges if edge.members <= here]
        # One that joins something else, too, will be undone, and what is on its axis is loose then.
        undone = [edge.loosened_by for edge in touching if not edge.members - here <= good]
        inner += [edge for edge in touching if edge.members - here <= good]
        inner = [edge for edge in inner if not any(edge.loosened_by & axis for axis in undone)]
        riders = _joined(around.here, inner) - around.here
        question = self.question
        is_all = len(question.parts_of(around.here | riders)) >= int(question.scene.part_mask.sum())
        return frozenset() if is_all or not (around.hangs or self._is_little(riders, item)) else riders

    def _free(
        self, item: int, here: frozenset[int], all_: Iterable[_Edge], off: frozenset[int]
    ) -> tuple[frozenset[int], list[_Edge]]:
        """What fasteners join to a part that may ride and is fastened to nothing else, and the fasteners among that."""
        by_member: dict[int, list[_Edge]] = {}
        for edge in all_:
            for each in edge.members - here:
                by_member.setdefault(each, []).append(edge)
        good: set[int] = set()
        bad: set[int] = set()
        inner: list[_Edge] = []
        for start in sorted(by_member):
            if start in good | bad:
                continue
            seen, waiting, edges, is_good = {start}, [start], list[_Edge](), True
            while waiting and is_good:
                each = waiting.pop(0)
                is_good = self._may_ride(each, item) and each not in bad | off
                for edge in by_member[each] if is_good else ():
                    if not edge.members & here:
                        edges.append(edge)
                        waiting += sorted(edge.members - seen)
                        seen |= edge.members
            (good if is_good else bad).update(seen)
            inner += edges if is_good else []
        return frozenset(good), inner

    def _may_ride(self, each: int, item: int) -> bool:
        is_small = each in self.fixings or self.is_smaller(each, item)
        return each != TARGET and is_small and not self._is_kept(each)

    def _is_kept(self, item: int) -> bool:
        return bool(self.question.kept.intersection(self.question.parts_of([item])))

    def _hangs(self, item: int, own: frozenset[int], touching: Iterable[_Edge]) -> bool:
        """Whether a part is fastened to a larger one, or to one that stays."""
        others = {each for edge in touching for each in edge.members} - own
        parts = [each for each in others if each not in self.fixings]
        return any(self._is_kept(each) or not self.is_smaller(each, item) for each in parts)

    def _is_light(self, item: int) -> bool:
        """Whether a part may carry something though it is fastened to no larger one."""
        return item == TARGET or self.is_smaller(item, TARGET)

    def _is_little(self, riders: Iterable[int], item: int) -> bool:
        """Whether all riders together have little surface beside a part."""
        all_ = sum(self._size(each)[0] for each in riders if each not in self.fixings)
        return all_ < SMALLER * LITTLE * self._size(item)[0]

    def is_smaller(self, one: int, other: int) -> bool:
        """Whether a part is smaller than another one, by its surface and by its reach."""
        mine, its = self._size(one), self._size(other)
        return mine[0] < SMALLER * its[0] and mine[1] < SMALLER * its[1]

    def _size(self, item: int) -> tuple[float, float]:
        """The surface of a part, square metres, and how far it reaches from its middle, metres; the largest of wanted
        ones."""
        if item not in self._sizes:
            parts = self.question.wanted if item == TARGET else (item,)
            sizes = [self._measured(part) for part in parts] or [(0.0, 0.0)]
            self._sizes[item] = max(each[0] for each in sizes), max(each[1] for each in sizes)
        return self._sizes[item]

    def _measured(self, part: int) -> tuple[float, float]:
        corners = self._meshes.corners(part)
        if not len(corners):
            return 0.0, 0.0
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        surface = float(areas.sum())
        middles = corners.mean(axis=1)
        middle = (areas @ middles) / surface if surface > 0.0 else middles.mean(axis=0)
        return surface, float(np.linalg.norm(corners - middle, axis=2).max())

    @cached_property
    def _meshes(self) -> PartMeshes:
        return PartMeshes(self.question.scene.mockup)


def _joined(here: frozenset[int], edges: Iterable[_Edge]) -> frozenset[int]:
    """All that is fastened to some items, with these."""
    found, left = set(here), list(edges)
    while near := [edge for edge in left if edge.members & found]:
        found.update(*(edge.members for edge in near))
        left = [edge for edge in left if edge not in near]
    return frozenset(found)
