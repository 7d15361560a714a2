"""The ways of circlips, snap rings, E-clips and cotter pins in a task: opened out of their groove, or drawn out of
their hole with straight legs, and out from beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.depths import deepest
from feeler.plan.blocking import DEEPER_M, DEEPER_SHARE, MOST_BLOCKERS, BlockingGraph, Mover
from feeler.plan.sequence import Exit, undominated
from feeler.scene import Scene
from feeler.tasks.cotters import Drawing, drawings, nut_shank, rod_shank
from feeler.tasks.fixings import RINGS, Fixings
from feeler.tasks.rings import Ring, Slip, Slipping, ring_of, slippings

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)  # it holds arrays
class RingWay:
    """One way of a ring out of its groove."""

    slip: Slip
    slipping: Slipping
    blockers: frozenset[int]
    """The items in the way of the opened ring until it lies free."""


class Rings:
    """The rings among the fasteners of a scene that have a groove."""

    def __init__(self, graph: BlockingGraph, fixings: Fixings) -> None:
        self.graph, self.fixings = graph, fixings
        self._known: dict[int, tuple[RingWay, ...]] = {}

    def __contains__(self, item: object) -> bool:
        """Whether an item is a ring in the groove of another part that is there."""
        if not isinstance(item, int) or item not in self.fixings:
            return False
        hold = self.fixings.of(item).hold
        is_there = hold.anchor is not None and self.graph.question.scene.part_mask[hold.anchor]
        return hold.kind in RINGS and bool(is_there)

    def ways(self, item: int) -> tuple[RingWay, ...]:
        """How a ring leaves its groove, but for ways that a kept part or the part with the groove is in."""
        if item not in self._known:
            found = []
            anchor = self.fixings.of(item).hold.anchor
            assert anchor is not None
            is_cotter = self.fixings.of(item).hold.kind == "cotter"
            ring = None if is_cotter else ring_of(*self.graph.meshes.mesh(item))
            each = self._drawings(item, anchor) if is_cotter else self._slippings(ring, anchor)
            for number, slipping in enumerate(each):
                self.graph.clock.look()
                mover = self._mover(item, anchor, slipping)
                first = self._opened(ring, slipping, mover.rest, mover.passed)
                along = mover.blockers(slipping.direction, MOST_BLOCKERS, slipping.travel)
                if along is not None and not (first | along) & (self.graph.question.kept | {anchor}):
                    found.append(RingWay(Slip(item, number), slipping, self._items(first | along)))
            self._known[item] = tuple(found)
        return self._known[item]

    def _slippings(self, ring: Ring | None, anchor: int) -> Iterator[Slipping]:
        return slippings(ring, self.graph.question.scene.only([anchor])) if ring is not None else iter(())

    def _drawings(self, item: int, anchor: int) -> Iterator[Slipping]:
        """How a cotter pin is drawn out of a shank and the nut on it."""
        nuts = [part for part in self.fixings.of(item).hold.parts if self.fixings.is_turned(part)]
        row = self.fixings.shank(anchor)
        on = None if row is not None or not nuts else self.fixings.of(nuts[0]).row
        row = row if on is None else nut_shank(on, anchor)
        if row is None:
            row = rod_shank(self.graph.question.scene, anchor, *self.graph.meshes.mesh(anchor))
        if row is None:
            return iter(())
        reach = 0.5 * row.size
        for part in nuts:
            local = (self.graph.meshes.mesh(part)[0] - row.frame[:3, 3]) @ row.frame[:3, :3]
            reach = max(reach, float(np.hypot(local[:, 0], local[:, 1]).max()))
        return drawings(*self.graph.meshes.mesh(item), row, reach)

    def way(self, slip: Slip) -> RingWay:
        """The way of a name."""
        return next(way for way in self.ways(slip.part) if way.slip == slip)

    def exits(self, item: int) -> list[Exit]:
        """The ways of a ring that go straight on from beside its groove."""
        found = []
        anchor = self.fixings.of(item).hold.anchor
        assert anchor is not None
        for way in self.ways(item):
            on = self._mover(item, anchor, way.slipping).blockers(way.slipping.direction, MOST_BLOCKERS)
            if on is not None and anchor not in on:
                found.append(Exit((way.slip,), way.blockers | self._items(on), self.graph.holding(item)))
        return undominated(found)

    def _mover(self, item: int, anchor: int, slipping: Slipping) -> Mover:
        passed = frozenset([anchor]) if slipping.is_sideways else frozenset[int]()
        if isinstance(slipping, Drawing):  # what it goes through leaves it room
            hold = self.fixings.of(item).hold
            passed = frozenset([anchor, *(part for part in hold.parts if self.fixings.is_turned(part))])
        return Mover(self.graph, item, passed, slipping.tool)

    def _items(self, parts: frozenset[int]) -> frozenset[int]:
        return frozenset(map(self.graph.question.node_of, parts))

    @staticmethod
    def _opened(ring: Ring | None, slipping: Slipping, rest: Scene, passed: frozenset[int]) -> frozenset[int]:
        """The parts that leave no room to open a ring."""
        if ring is None:
            return frozenset()
        relaxed, opened = (deepest(rest, tool, np.eye(4)) for tool in (ring.opened(0.0), slipping.tool))
        limits = {part: DEEPER_M + (1.0 + DEEPER_SHARE) * relaxed.get(part, 0.0) for part in opened}
        return frozenset(part for part, depth in opened.items() if depth > limits[part]) - passed
