"""The quickest order of the steps of a task: a search over what is out and which tool is in hand."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from feeler.tasks.problem import SLACK, Choice, Ordered, Problem, Unit

MOST_STATES = 5_000
"""States of one order; beyond it the order is the best that a beam search finds."""
MOST_AHEAD = 60
"""States with equally many steps in a beam search."""


class _State(NamedTuple):
    """What is out, after which steps."""

    spent: float
    out: frozenset[int]
    tool: str
    """In hand."""
    steps: tuple[Ordered, ...]


class Order:
    """The quickest order of units: A* over what is out and which tool is in hand.

    A step that has to be done, costs as little as it ever will and needs no other tool is done at once: to do it
    earlier makes no other step longer.
    """

    def __init__(self, problem: Problem, units: Sequence[Unit], goes_on: Callable[[], bool]) -> None:
        self.problem, self.units, self._goes_on = problem, units, goes_on
        self.all = frozenset(item for unit in units for item in unit.leaving)
        self.blocked: dict[int, frozenset[int]] = {}
        self.waiting: dict[int, frozenset[int]] = {}
        """Where no tool lacks room: what waits for what waits for it, parts if there are any."""
        self._needed: dict[Unit, frozenset[int]] = {}
        self._at_best = [self._cheapest(unit) for unit in units]
        self._least = [min((each.seconds for each in some), default=0.0) for some in self._at_best]

    def _cheapest(self, unit: Unit) -> Sequence[Choice]:
        """How a unit leaves once all others are out that need not wait for it."""
        item = unit.items[0]
        if not self.problem.is_turned(item):
            return [self.problem.by_hand(unit.items)]
        choices, _ = self.problem.tooled(item, self.all - {item} - self._waiting_for(item))
        loose = [self.problem.by_hand(unit.items)] if self.problem.mates(item) & self.all else []
        return [*choices, *loose]

    def _waiting_for(self, item: int) -> frozenset[int]:
        """The items that cannot leave before one: it is in their way or holds them, or they wait for such ones."""
        found = {item}
        while True:
            more = {each for unit in self.units if self._needs(unit) & found for each in unit.leaving}
            if more <= found:
                return frozenset(found - {item})
            found |= more

    def _needs(self, unit: Unit) -> frozenset[int]:
        """The items that have to be out before a unit: of joints those that are alone in it."""
        if unit not in self._needed:
            joints = [joint & self.all for joint in unit.joints]
            alone = frozenset[int]().union(*(joint for joint in joints if len(joint) == 1))
            self._needed[unit] = (unit.before | alone) - set(unit.leaving)
        return self._needed[unit]

    def best(self) -> tuple[Ordered, ...] | None:
        """The order; None if there is none, and then `blocked` has what is in the way of what."""
        count = len(self.units)
        start = frozenset[int]()
        queue: list[tuple[float, int, float, frozenset[int], str, tuple[Ordered, ...]]] = []
        heapq.heappush(queue, (sum(self._least), 0, 0.0, start, "", ()))
        done: set[tuple[frozenset[int], str]] = set()
        number, furthest = 0, start
        while queue:
            _, _, spent, out, tool, steps = heapq.heappop(queue)
            if len(steps) == count:
                return steps
            if (out, tool) in done:
                continue
            done.add((out, tool))
            if len(out) > len(furthest):
                furthest = out
            self.problem.expect([unit.items[0] for unit in self.units if self._is_next(unit, out)], out)
            ready = list(self._ready(out, tool))
            if len(done) > MOST_STATES:
                return self._hastily()
            for n, step in self._worth(ready, tool):
                left = self._left(out)
                after = spent + step.choice.seconds + self.problem.get_seconds * step.is_changed
                number += 1
                grown = out | set(step.unit.leaving)
                entry = (after + left - self._least[n], number, after, grown, step.choice.tool or tool, (*steps, step))
                heapq.heappush(queue, entry)
        self._note_blocked(furthest)
        return None

    def _hastily(self) -> tuple[Ordered, ...] | None:
        """An order by a beam search: of the states with equally many steps only those that promise most go on."""
        beam: list[_State] = [_State(0.0, frozenset(), "", ())]
        for _ in self.units:
            grown: dict[tuple[frozenset[int], str], _State] = {}
            for state in beam:
                ready = list(self._ready(state.out, state.tool))
                for _, step in self._worth(ready, state.tool):
                    spent = state.spent + step.choice.seconds + self.problem.get_seconds * step.is_changed
                    out, tool = state.out | set(step.unit.leaving), step.choice.tool or state.tool
                    if (out, tool) not in grown or spent < grown[out, tool].spent - SLACK:
                        grown[out, tool] = _State(spent, out, tool, (*state.steps, step))
            if not grown:
                self._note_blocked(beam[0].out)
                return None
            beam = sorted(grown.values(), key=self._promised)[:MOST_AHEAD]
        return min(beam, key=lambda each: each.spent).steps

    def _promised(self, state: _State) -> float:
        """The seconds of an order that goes on from a state, by a guess: each unit at its least, and a change of the
        tool for those that no tool in hand serves, the units with the fewest tools first."""
        tools = [
            {each.tool for each in some}
            for unit, some in zip(self.units, self._at_best, strict=True)
            if not state.out & set(unit.items) and all(each.tool for each in some)
        ]
        held, changes = {state.tool}, 0
        for some in sorted(tools, key=len):
            if not some & held:
                changes += 1
                held |= some
        return state.spent + self._left(state.out) + self.problem.get_seconds * changes

    def _left(self, out: frozenset[int]) -> float:
        """The least seconds of the units that are still there."""
        return sum(least for each, least in zip(self.units, self._least, strict=True) if not out & {*each.items})

    def _ready(self, out: frozenset[int], tool: str) -> Iterator[tuple[int, Ordered]]:
        """The steps that can be done now."""
        for n, unit in enumerate(self.units):
            if not self._is_next(unit, out):
                continue
            for choice in self._choices(unit, out):
                yield n, Ordered(unit, choice, bool(choice.tool) and choice.tool != tool)

    def _is_next(self, unit: Unit, out: frozenset[int]) -> bool:
        return not out & set(unit.items) and unit.before <= out and self._is_free(unit, out)

    def _is_free(self, unit: Unit, out: frozenset[int]) -> bool:
        gone = out | set(unit.leaving)
        return all(joint & gone for joint in unit.joints)

    def _choices(self, unit: Unit, out: frozenset[int]) -> Sequence[Choice]:
        item = unit.items[0]
        if not self.problem.is_turned(item) or self.problem.mates(item) & out:
            return [self.problem.by_hand(unit.items)]
        return self.problem.tooled(item, out)[0]

    def _worth(self, ready: Sequence[tuple[int, Ordered]], tool: str) -> Iterator[tuple[int, Ordered]]:
        """The steps to go on with: the first that is best done at once; else all, but of those that are as quick as
        they will be and need the same other tool one."""
        for n, step in ready:
            if not step.is_changed and step.choice.seconds <= self._least[n] + SLACK:
                yield n, step
                return
        tools: set[str] = set()
        for n, step in ready:
            if step.choice.seconds <= self._least[n] + SLACK:
                if step.choice.tool in tools:
                    continue
                tools.add(step.choice.tool)
            yield n, step

    def _note_blocked(self, out: frozenset[int]) -> None:
        for unit in self.units:
            item = unit.items[0]
            if not out & set(unit.items) and self.problem.is_turned(item) and unit.before <= out:
                choices, blockers = self.problem.tooled(item, out)
                if not choices:
                    self.blocked[item] = blockers - {item}
        if not self.blocked:
            left = [unit for unit in self.units if not out & set(unit.items) and not unit.before <= out]
            parts = [unit for unit in left if not self.problem.is_turned(unit.items[0])]
            self.waiting = {item: unit.before - out for unit in parts or left for item in unit.items}
