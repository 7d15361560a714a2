"""A question in which fasteners leave with their washers, and parts with what is fastened to them alone."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from feeler.plan.question import TARGET, Question


@dataclass(frozen=True)
class Together(Question):
    """A question in which fasteners leave with their washers, and parts with what is fastened to them alone."""

    riders: dict[int, tuple[int, ...]] = field(default_factory=dict)
    lead: dict[int, int] = field(default_factory=dict)
    """What leaves with another item: a washer with its fastener, a union nut with its pipe."""
    undone: tuple[int, ...] = ()
    """Fasteners that are wanted themselves."""
    bodies: dict[int, tuple[int, frozenset[int]]] = field(default_factory=dict)
    """Nodes that are a part with what rides on it: the part, and these items."""
    _nodes: dict[tuple[int, frozenset[int]], int] = field(default_factory=dict)

    def with_riders(self, item: int, riding: frozenset[int]) -> int:
        """The node of a part with what rides on it."""
        if not riding:
            return item
        if (item, riding) not in self._nodes:
            node = TARGET - 1 - len(self.bodies)
            self._nodes[item, riding] = node
            self.bodies[node] = (item, riding)
        return self._nodes[item, riding]

    def leaving(self, node: int) -> frozenset[int]:
        """The items that are out with a node."""
        item, riding = self.bodies.get(node, (node, frozenset[int]()))
        return riding | {item}

    def size(self, node: int) -> float:
        """As of each question; of a part with riders its own."""
        return super().size(self.bodies[node][0] if node in self.bodies else node)

    def node_of(self, part: int) -> int:
        """The item that has to leave for a part to be gone."""
        if part in self.wanted:
            return TARGET
        leader = self.lead.get(part, part)
        return TARGET if leader in self.wanted else leader

    def parts_of(self, nodes: Iterable[int]) -> tuple[int, ...]:
        """All parts that leave with items."""
        found: set[int] = set()
        for node in (each for given in nodes for each in self.leaving(given)):
            own = self.wanted if node == TARGET else (node,)
            found.update(own)
            found.update(rider for part in own for rider in self.riders.get(part, ()))
        return tuple(sorted(found))
