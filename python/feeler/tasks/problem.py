"""What the search of a task asks, and the steps that it puts in order."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

SLACK = 1e-6
"""Seconds that do not count."""

Motions = tuple[Hashable, ...]


class Choice(NamedTuple):
    """One way to do a step: with a tool ("" for none), for so many seconds."""

    tool: str
    seconds: float
    key: object
    """For the problem: what it answered."""


class Way(NamedTuple):
    """Motions by which a part leaves, and the items that have to go before."""

    motions: Motions
    blockers: frozenset[int]
    riding: frozenset[int] = frozenset()
    """The items that leave with it: they are fastened to it alone."""


class Problem(Protocol):
    """What the search asks. Items are numbers: fasteners that are undone, and parts that are taken out."""

    get_seconds: float
    """For each change of the tool in hand."""
    quickest: float
    """The least seconds of any step by hand."""

    def is_turned(self, item: int) -> bool:
        """Whether it is a fastener, which leaves alone along its axis and needs a tool."""

    def carriers(self, item: int) -> frozenset[int]:
        """The parts that an item can leave with."""

    def riding(self, item: int, off: frozenset[int], on: frozenset[int]) -> frozenset[int]:
        """Items that leave with a part, since they are fastened to it alone when some items are off; none of a
        fastener. on: parts that are to leave with it, though they are fastened to others, too."""

    def extensions(self, item: int, off: frozenset[int], on: frozenset[int]) -> Sequence[frozenset[int]]:
        """Parts that are fastened to others, too, and can leave with a part all the same, once undone from these."""

    def loads(self, item: int, riding: frozenset[int]) -> Sequence[int]:
        """Of the items that ride on a part, those that are in the way of a motion by which it could leave."""

    def holders(self, item: int, riding: frozenset[int]) -> Sequence[frozenset[int]]:
        """Of each joint of a part and what rides on it, the items of which one has to be undone first."""

    def ways(self, item: int, riding: frozenset[int]) -> Sequence[Way]:
        """How a part with what rides on it can leave, or a fastener can be drawn."""

    def mates(self, item: int) -> frozenset[int]:
        """Other fasteners on the axis of one: once one of them is undone, it is loose."""

    def tooled(self, item: int, out: frozenset[int]) -> tuple[Sequence[Choice], frozenset[int]]:
        """How a fastener is undone while items are out; and the items in the way of a tool, or of a larger swing."""

    def expect(self, items: Sequence[int], out: frozenset[int] | None) -> None:
        """Fasteners that are likely to be asked for together, while items are out; None: while all is out that can be.
        No answer depends on it."""

    def by_hand(self, items: Iterable[int]) -> Choice:
        """How parts, which leave together, or a loose fastener are taken out."""

    def least(self, item: int) -> float:
        """The least seconds of a fastener in any order; infinite if it cannot be undone in any."""

    def first(self, item: int) -> float:
        """The least seconds of a fastener that is undone before all others on its axis: with a tool."""

    def needed(self, item: int) -> frozenset[int]:
        """Items each of which has to be out before a fastener is undone: with it alone in place no tool reaches it."""


@dataclass(frozen=True)
class Unit:
    """Items that leave in one step."""

    items: tuple[int, ...]
    motion: Hashable
    before: frozenset[int]
    """Items that have to be out before, but for loose fasteners and reach."""
    joints: tuple[frozenset[int], ...] = ()
    """Items of which one each has to be undone before."""
    bodies: tuple[frozenset[int], ...] = ()
    """Of each of its items, with what the motion was found."""
    riding: tuple[int, ...] = ()
    """The items that leave with them."""

    @property
    def leaving(self) -> tuple[int, ...]:
        """All items that are out after it."""
        return (*self.items, *self.riding)


@dataclass(frozen=True)
class Ordered:
    """One step of an order."""

    unit: Unit
    choice: Choice
    is_changed: bool
    """Whether the tool in hand is changed for it."""
