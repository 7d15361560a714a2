"""The search of a task by itself, on problems that are tables: how many sets it looks at, and its bounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import pytest

from feeler.tasks import search
from feeler.tasks.problem import Choice, Way
from feeler.tasks.search import Search

TARGET = 0


@dataclass
class Table:
    """Parts with their ways, and fasteners with the seconds of a tool, infinite if none reaches."""

    ways_of: Mapping[int, Sequence[frozenset[int]]]
    joints: Mapping[int, Sequence[frozenset[int]]] = field(default_factory=dict)
    tools: Mapping[int, float] = field(default_factory=dict)
    axes: Sequence[frozenset[int]] = ()
    hands: Mapping[int, float] = field(default_factory=dict)
    get_seconds: float = 0.0
    quickest: float = 1.0

    def is_turned(self, item: int) -> bool:
        return item in self.tools

    def carriers(self, item: int) -> frozenset[int]:
        return frozenset()

    def riding(self, item: int, off: frozenset[int], on: frozenset[int]) -> frozenset[int]:
        return frozenset()

    def extensions(self, item: int, off: frozenset[int], on: frozenset[int]) -> Sequence[frozenset[int]]:
        return []

    def loads(self, item: int, riding: frozenset[int]) -> Sequence[int]:
        return []

    def holders(self, item: int, riding: frozenset[int]) -> Sequence[frozenset[int]]:
        return self.joints.get(item, ())

    def ways(self, item: int, riding: frozenset[int]) -> Sequence[Way]:
        found = [frozenset[int]()] if item in self.tools else self.ways_of.get(item, ())
        return [Way((f"{item} {n}",), blockers) for n, blockers in enumerate(found)]

    def mates(self, item: int) -> frozenset[int]:
        return frozenset[int]().union(*(axis for axis in self.axes if item in axis)) - {item}

    def tooled(self, item: int, out: frozenset[int]) -> tuple[Sequence[Choice], frozenset[int]]:
        return [Choice("spanner", self.tools[item], None)], frozenset()

    def expect(self, items: Sequence[int], out: frozenset[int] | None) -> None:
        pass

    def by_hand(self, items: Iterable[int]) -> Choice:
        return Choice("", max(self.hands.get(item, 1.0) for item in items), None)

    def first(self, item: int) -> float:
        return self.tools[item]

    def least(self, item: int) -> float:
        return min([self.tools[item], *([1.0] if self.mates(item) else [])])

    def needed(self, item: int) -> frozenset[int]:
        return frozenset()


def flanges(count: int, nut_s: float) -> Table:
    """Two cases, 1 under 0, with bolts and nuts: of each pair one is undone."""
    pairs = [frozenset([10 + n, 100 + n]) for n in range(count)]
    tools = {10 + n: 8.0 for n in range(count)} | {100 + n: nut_s for n in range(count)}
    return Table({TARGET: [frozenset([1])], 1: [frozenset([2])], 2: [frozenset()]}, {1: pairs}, tools, pairs)


@pytest.mark.parametrize("nut_s", [8.0, 5.0])
def test_many_bolts_with_nuts_are_chosen_one_by_one(nut_s: float) -> None:
    asked = Search(flanges(20, nut_s), TARGET)
    found = asked.best()
    assert found.steps is not None and found.is_complete and asked.sets < 60
    assert found.seconds == pytest.approx(20 * nut_s + 3.0) and found.bound == pytest.approx(found.seconds)


def misleading(depth: int) -> Table:
    """Of two ways at each of many parts one is cheaper at first, and waits for more in the end."""
    ways: dict[int, list[frozenset[int]]] = {0: [frozenset([1])]}
    hands: dict[int, float] = {}
    for part, after in pairwise(range(1, depth + 1)):
        dear, cheap, late = 100 + part, 200 + part, 300 + part
        ways |= {part: [frozenset([cheap, after]), frozenset([dear, after])]}
        ways |= {cheap: [frozenset([late])], dear: [frozenset()], late: [frozenset()]}
        hands |= {cheap: 1.0, dear: 2.0, late: 1.5}
    ways[depth] = [frozenset()]
    return Table(ways, hands=hands)


def test_where_bounds_mislead_a_plan_is_found_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "MOST_SETS", 2_000)
    monkeypatch.setattr(search, "MOST_MORE", 100)
    asked = Search(misleading(14), TARGET)
    found = asked.best()
    assert found.steps is not None and not found.is_full
    # Thirteen dear parts, and all others, is the quickest.
    assert found.bound <= 15.0 + 13 * 2.0 + 1e-6 <= found.seconds + 1e-6
    assert found.seconds <= 15.0 + 13 * 2.5 + 1e-6


def test_the_limit_of_sets_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "MOST_SETS", 2)
    found = Search(misleading(6), TARGET).best()
    assert found.steps is None and found.is_full and not found.is_complete


def test_without_time_it_is_no_limit_of_sets() -> None:
    found = Search(misleading(6), TARGET, lambda: False).best()
    assert found.steps is None and not found.is_full and not found.is_complete
