"""Which parts have to go, and in which order, for the least time: a best-first search with a bound.

The plan is an AND/OR graph (Homem de Mello and Sanderson 1990). A *set* is what a plan takes out. Each of its items has
needs: fasteners that hold it, parts in the way of a motion, parts in the way of a tool. A need has alternatives; a set
grows by one of them. Needs with one alternative are settled at once. Sets wait in order of their bound, the sum of the
least times of their items; of equal ones the newest is first. A set without open needs is put in
order by a second search, over what is out and which tool is in hand.

Where bounds are low, many sets are below every plan. If none was found for long, each second set is thus the one that
has come furthest. All others wait, so the bound is as good.

What is out never blocks, so more parts out never close a way. Hence at a need one of its alternatives is in every plan
that grows from the set, and the least bound of all sets that have not been given up is a bound of every plan.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

MOST_SETS = 20_000
"""Sets of one search; beyond it the best order so far is returned, with the bound of those that wait."""
PATIENCE = 200
"""Sets by their bound alone; after these, without a plan, each second one is that which has come furthest."""
MOST_MORE = 500
"""Sets that are still looked at once a plan was found."""
MOST_STATES = 5_000
"""States of one order; beyond it the order is the best that a beam search finds."""
MOST_AHEAD = 60
"""States with equally many steps in a beam search."""
SETTLED = 0.75
"""The share of the progress of a search when it has a plan."""
SLACK = 1e-6
"""Seconds that do not count."""
_DIGITS = 6
"""To which bounds are rounded: sums of the same times in another order are equal."""

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


class Problem(Protocol):
    """What the search asks. Items are numbers: fasteners that are undone, and parts that are taken out."""

    get_seconds: float
    """For each change of the tool in hand."""
    quickest: float
    """The least seconds of any step by hand."""

    def is_turned(self, item: int) -> bool:
        """Whether it is a fastener, which leaves alone along its axis and needs a tool."""

    def holders(self, item: int) -> Sequence[frozenset[int]]:
        """Of each joint of a part, the items of which one has to be undone first."""

    def ways(self, item: int) -> Sequence[Way]:
        """How a part can leave, or a fastener can be drawn."""

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


class Need(NamedTuple):
    """Something that has to be settled: the way of a fastener or part, a joint, or the reach of a tool. Joints come
    after ways, as these often settle them, and reach last: what is out gives room."""

    rank: int
    item: int
    joint: int


_NEVER, _AXIS, _WAY, _JOINT, _REACH = range(5)


@dataclass(frozen=True)
class Unit:
    """Items that leave in one step."""

    items: tuple[int, ...]
    motion: Hashable
    before: frozenset[int]
    """Items that have to be out before, but for loose fasteners and reach."""


@dataclass(frozen=True)
class Ordered:
    """One step of an order."""

    unit: Unit
    choice: Choice
    is_changed: bool
    """Whether the tool in hand is changed for it."""


@dataclass(frozen=True)
class Found:
    """The answer: the steps, None if there are none; their seconds, and what no plan is below."""

    steps: tuple[Ordered, ...] | None
    seconds: float
    bound: float
    is_complete: bool
    """Whether the search ended by itself."""
    stuck: Mapping[int, frozenset[int]]
    """Of items that nothing frees: what is in their way."""
    is_full: bool = False
    """Whether it ended at the limit of sets: more time does not help."""


@dataclass(frozen=True)
class _Set:
    items: frozenset[int]
    needs: tuple[Need, ...]
    chosen: Mapping[int, Way] = field(default_factory=dict)
    costs: Mapping[int, float] = field(default_factory=dict)
    """Seconds of fasteners whose tools get no more room than now."""
    stays: frozenset[int] = frozenset()
    """Items that plans of this set leave in place: they would give room to those."""

    @property
    def key(self) -> Hashable:
        """Equal for equal sets."""
        chosen = tuple(sorted(self.chosen.items(), key=lambda each: each[0]))
        return (self.items, self.needs, chosen, tuple(sorted(self.costs.items())), self.stays)


class Search:
    """Searches the plans of a problem that take out `target`."""

    def __init__(
        self,
        problem: Problem,
        target: int,
        goes_on: Callable[[], bool] = lambda: True,
        forced: Mapping[int, frozenset[int]] | None = None,
        told: Callable[[float], None] = lambda share: None,
    ) -> None:
        """forced: of items those that go before them, if they go at all. told: called with the share of the search that
        is done, as far as it is known: of the needs of a plan, then of the way from its bound to its seconds."""
        self._forced, self._told = forced or {}, told
        self.problem, self.target, self._goes_on = problem, target, goes_on
        self.sets = 0
        """Sets that were looked at."""
        self.stuck: dict[int, frozenset[int]] = {}
        self.so_far = Found(None, math.inf, 0.0, False, self.stuck)
        """The best plan and the bound until now, for whoever ends the search."""
        self._makes_room = False
        self._axes: dict[int, frozenset[int]] = {}

    def best(self) -> Found:
        """The quickest plan found, and its bound.

        First what gives tools room is only taken out where no tool reaches; then also where it saves strokes.
        """
        first = self._run(Found(None, math.inf, math.inf, True, self.stuck))
        if first.steps is None or first.bound >= first.seconds - SLACK:
            return first
        self._makes_room = True
        second = self._run(first)
        is_complete = first.is_complete and second.is_complete
        is_full = first.is_full or second.is_full
        return Found(second.steps, second.seconds, max(first.bound, second.bound), is_complete, self.stuck, is_full)

    def sure(self) -> frozenset[int]:
        """The items that every plan takes out."""
        first = self._grown(_Set(frozenset(), ()), [self.target])
        assert first is not None
        return first.items

    def longest(self) -> float:
        """The least seconds of the longest chain of steps that every plan has: none is done in less, by any number of
        people. A fastener waits for what is on its axis and in the way of its tool, a part for the fasteners that hold
        it; whoever undoes one has taken a tool before."""
        ends: dict[int, float] = {}
        return max(self._end(item, frozenset([item]), ends) for item in self.sure())

    def _end(self, item: int, above: frozenset[int], ends: dict[int, float]) -> float:
        """When an item of a plan is out at the earliest, seconds. above: what waits for it; ends: those known."""
        if item not in ends:
            problem, is_turned = self.problem, self.problem.is_turned(item)
            before = {next(iter(joint)) for joint in problem.holders(item) if len(joint) == 1}
            before |= problem.needed(item) if is_turned else set()
            ways = [way.blockers for way in problem.ways(item)]
            in_all = frozenset.intersection(*ways) if ways else frozenset[int]()
            before |= {each for each in in_all if is_turned or self._leaves_alone(each)}
            start = max((self._end(each, above | {each}, ends) for each in before - above), default=0.0)
            if is_turned:
                least = problem.least(item)
                needs_tool = least > 0.0 and not problem.mates(item)
                ends[item] = max(start, problem.get_seconds if needs_tool else 0.0) + least
            else:
                own = problem.by_hand([item]).seconds
                # A part may leave together with another one, whose time then counts.
                is_own = item == self.target or self._leaves_alone(item)
                ends[item] = start + (own if is_own else min(own, problem.quickest))
        return ends[item]

    def _leaves_alone(self, item: int) -> bool:
        """Whether no plan takes it out together with another item."""
        return self.problem.is_turned(item) or not any(way.blockers for way in self.problem.ways(item))

    def _run(self, known: Found) -> Found:
        """The search over sets. known: a plan from before."""
        best, seconds = known.steps, known.seconds
        waiting = _Waiting()
        least_leaf, looked, opened = math.inf, 0, 0.0
        limit = MOST_SETS if best is None else MOST_MORE
        first = self._grown(_Set(frozenset(), ()), [self.target])
        assert first is not None
        new = [first]
        is_full = False
        while True:
            for one in reversed(new):  # the first is the newest
                waiting.add(self._bound(one), one)
            if waiting.lowest >= seconds - SLACK:
                is_complete = True
                break
            is_full = looked >= limit
            if is_full or not self._goes_on():
                is_complete = False
                break
            lowest = max(self.so_far.bound, min(seconds, least_leaf, waiting.lowest))
            self.so_far = Found(best, seconds, lowest, False, self.stuck)
            bound, one = waiting.take(best is None and looked > PATIENCE and looked % 2 == 1)
            looked += 1
            if best is None:
                self._told(SETTLED * self._settled(one))
            else:
                closed = (bound - opened) / (seconds - opened) if seconds > opened else 1.0
                self._told(SETTLED + (1.0 - SETTLED) * max(closed, looked / limit))
            if one.needs:
                new = list(self._children(one))
                continue
            new = []
            steps, blocked = self._in_order(one)
            if steps is None:
                new = [each for item in sorted(blocked) if (each := self._grown(one, [item])) is not None]
                continue
            least_leaf = min(least_leaf, bound)
            if best is None:
                opened = bound
                limit = min(limit, looked + MOST_MORE)
            cost = self._seconds(steps)
            if cost < seconds - SLACK:
                best, seconds = steps, cost
        self.sets += looked
        self.so_far = Found(
            best, seconds, min(seconds, least_leaf, waiting.lowest), is_complete, self.stuck, is_full and best is None
        )
        return self.so_far

    def _settled(self, one: _Set) -> float:
        """The share of the needs of a set that are settled."""
        return max(0.0, 1.0 - len(one.needs) / len(one.items))

    def _bound(self, one: _Set) -> float:
        """The least seconds of all plans that take this set out: of its fasteners, one of each axis with a tool, and
        one of each open joint; of its parts with a known way, as many as cannot leave together; and of the first
        tool."""
        problem = self.problem
        turned = [item for item in one.items if problem.is_turned(item)]
        found = sum(one.costs.get(item, problem.least(item)) for item in turned)
        found += sum(self._started(axis, one) for axis in set(map(self._axis, turned)) if axis)
        found += self._joined(one)
        parts = {item: way for item, way in one.chosen.items() if not problem.is_turned(item)}
        open_ = _leading_to({need.item for need in one.needs if need.rank == _WAY}, parts)
        found += sum(problem.by_hand(group).seconds for group in _groups(parts) if not open_ & set(group))
        found += min((problem.by_hand([item]).seconds for item in open_ & parts.keys()), default=0.0)
        needs_tool = any(problem.least(item) > 0.0 and not problem.mates(item) for item in turned)
        return found + (problem.get_seconds if needs_tool else 0.0)

    def _axis(self, item: int) -> frozenset[int]:
        """A fastener with all others on its axis, if there are others."""
        if item not in self._axes:
            found = {item}
            while more := frozenset[int]().union(*map(self.problem.mates, found)) - found:
                found |= more
            self._axes[item] = frozenset(found) if len(found) > 1 else frozenset()
        return self._axes[item]

    def _joined(self, one: _Set) -> float:
        """The least seconds of the fasteners that its open joints will need: of each axis that none is of yet."""
        found, counted = 0.0, set(one.items)
        for need in one.needs:
            if need.rank == _JOINT:
                joint = self._joint(need)
                axes = joint.union(*map(self._axis, joint))
                if not axes & counted:
                    counted |= axes
                    found += min(map(self._alone, joint))
        return found

    def _alone(self, item: int) -> float:
        """The least seconds of a fastener and of what is undone on its axis before."""
        others = min(map(self.problem.first, self._axis(item) - {item}), default=math.inf)
        return min(self.problem.first(item), self.problem.least(item) + others)

    def _started(self, axis: frozenset[int], one: _Set) -> float:
        """The least seconds more of the first fastener of an axis, which is not loose yet: one of the set, or another,
        which is then undone too."""
        own = [self.problem.first(item) - self.problem.least(item) for item in axis & one.items]
        return min([*own, *(self.problem.first(item) for item in axis - one.items - one.stays)])

    def _grown(self, one: _Set, more: Iterable[int]) -> _Set | None:
        """The set with more items, and what each of them needs for sure; None if that has to stay."""
        items, needs, chosen = set(one.items), list(one.needs), dict(one.chosen)
        waiting = [item for item in more if item not in items]
        while waiting:
            item = waiting.pop(0)
            if item in items:
                continue
            if item in one.stays:
                return None
            items.add(item)
            if not self.problem.is_turned(item):
                held = sorted({each for joint in self.problem.holders(item) for each in joint} - items)
                self.problem.expect(held, None)
                self.problem.expect(held, frozenset())
            for index, joint in enumerate(self.problem.holders(item)):
                if len(joint) == 1:
                    waiting += sorted(joint - items)
                else:
                    needs.append(Need(_JOINT if joint else _NEVER, item, index))
            if self.problem.is_turned(item):
                if math.isinf(self.problem.least(item)):
                    self._note(item, frozenset())
                    needs.append(Need(_NEVER, item, 0))
                    continue
                waiting += sorted(self.problem.needed(item) - items)
                ways = self.problem.ways(item)
                if len(ways) == 1:
                    chosen[item] = ways[0]
                    waiting += sorted(ways[0].blockers - items)
                else:
                    needs.append(Need(_AXIS, item, 0))
                needs.append(Need(_REACH, item, 0))
            else:
                needs.append(Need(_WAY, item, 0))
        open_ = (need for need in needs if need.rank != _JOINT or not self._joint(need) & items)
        return replace(one, items=frozenset(items), needs=tuple(sorted(open_)), chosen=chosen)

    def _joint(self, need: Need) -> frozenset[int]:
        return self.problem.holders(need.item)[need.joint]

    def _children(self, one: _Set) -> Iterator[_Set]:
        """The sets that settle the first need of a set, each in one way."""
        need = one.needs[0]
        left = replace(one, needs=one.needs[1:])
        item, problem = need.item, self.problem
        if need.rank == _NEVER:
            self._note(item, frozenset())
        elif need.rank == _JOINT:
            yield from self._with_each(left, self._joint(need))
        elif need.rank in (_AXIS, _WAY):
            ways = problem.ways(item)
            if not ways:
                self._note(item, frozenset())
            for way in ways:
                grown = self._grown(replace(left, chosen={**one.chosen, item: way}), sorted(way.blockers - one.items))
                if grown is not None:
                    yield grown
        else:
            yield from self._reached(one, item, left)

    def _with_each(self, one: _Set, items: Iterable[int]) -> Iterator[_Set]:
        """A set for each item more."""
        for item in sorted(items):
            grown = self._grown(one, [item])
            if grown is not None:
                yield grown

    def _reached(self, one: _Set, item: int, left: _Set) -> Iterator[_Set]:
        problem = self.problem
        mates = problem.mates(item)
        if mates & one.items:
            yield left
            return
        choices, blockers = problem.tooled(item, one.items - {item} - self._after(item, one))
        more = blockers - one.items - {item}
        if not choices:
            yield from self._with_each(one, more)
            yield from self._with_each(left, mates)
            if not (more or mates):
                self._note(item, blockers)
            return
        seconds = min(each.seconds for each in choices)
        if not self._makes_room or mates:
            yield left
        elif seconds <= problem.least(item) + SLACK:
            yield replace(left, costs={**one.costs, item: seconds})
        else:
            yield replace(left, costs={**one.costs, item: seconds}, stays=one.stays | more)
            yield from self._with_each(one, more)

    def _note(self, item: int, blockers: frozenset[int]) -> None:
        self.stuck.setdefault(item, blockers)

    def _after(self, item: int, one: _Set) -> frozenset[int]:
        """Items of a set that cannot leave before one: it alone holds them, or they wait for such ones."""
        found = {each for each in one.items if frozenset([item]) in self.problem.holders(each)}
        while True:
            more = {each for each, way in one.chosen.items() if way.blockers & found}
            if self.target in one.items:
                more.add(self.target)
            if more <= found:
                return frozenset(found - {item})
            found |= more

    def _in_order(self, one: _Set) -> tuple[tuple[Ordered, ...] | None, frozenset[int]]:
        """The quickest order of a set; if there is none, items beyond it that may help."""
        units = self._units(one)
        if units is None:
            return None, frozenset()
        order = _Order(self.problem, units, self._goes_on)
        steps = order.best()
        if steps is not None:
            last = next(n for n, step in enumerate(steps) if self.target in step.unit.items)
            return steps[: last + 1], frozenset()
        for item, blockers in order.blocked.items():
            if not blockers - one.items:
                self._note(item, blockers)
        for item, blockers in order.waiting.items():
            self._note(item, blockers)
        helping = frozenset[int]().union(*order.blocked.values()) if order.blocked else frozenset[int]()
        return None, helping - one.items

    def _units(self, one: _Set) -> list[Unit] | None:
        """The steps of a set, without their order: parts that block each other leave together."""
        problem = self.problem
        parts = {item: way for item, way in one.chosen.items() if not problem.is_turned(item)}
        units = []
        for group in _groups(parts):
            motion = _in_common([parts[item].motions for item in group])
            if motion is None:
                self._note(group[0], frozenset(group[1:]))
                return None
            before = frozenset[int]().union(*(parts[item].blockers | self._first(item, one) for item in group))
            before -= set(group)
            units.append(Unit(tuple(group), motion, before))
        for item in sorted(one.items - parts.keys()):
            way = one.chosen[item]
            units.append(Unit((item,), way.motions[0], way.blockers | self._first(item, one)))
        return units

    def _first(self, item: int, one: _Set) -> frozenset[int]:
        """The items of a set that are forced to go before one of them."""
        return self._forced.get(item, frozenset()) & one.items - {item}

    def _seconds(self, steps: Sequence[Ordered]) -> float:
        return sum(step.choice.seconds + self.problem.get_seconds * step.is_changed for step in steps)


class _Waiting:
    """The sets that wait, each once; of equal ones the newest is first."""

    def __init__(self) -> None:
        self._by_bound: list[tuple[float, int, _Set]] = []
        self._by_needs: list[tuple[int, float, int, _Set]] = []
        self._seen: set[Hashable] = set()
        self._taken: set[int] = set()
        self._number = 0

    def add(self, bound: float, one: _Set) -> None:
        """Has a set wait, but for one that never leads to a plan."""
        if math.isinf(bound) or one.key in self._seen:
            return
        self._seen.add(one.key)
        self._number += 1
        rounded = round(bound, _DIGITS)
        heapq.heappush(self._by_bound, (rounded, -self._number, one))
        heapq.heappush(self._by_needs, (len(one.needs) - len(one.chosen), rounded, -self._number, one))

    @property
    def lowest(self) -> float:
        """The least bound; infinite if none waits."""
        while self._by_bound and self._by_bound[0][1] in self._taken:
            heapq.heappop(self._by_bound)
        return self._by_bound[0][0] if self._by_bound else math.inf

    def take(self, is_furthest: bool) -> tuple[float, _Set]:
        """The set with the least bound, or that with the most items settled, and its bound. One waits at least."""
        if not is_furthest:
            assert not math.isinf(self.lowest)
            bound, number, one = heapq.heappop(self._by_bound)
        else:
            while self._by_needs[0][2] in self._taken:
                heapq.heappop(self._by_needs)
            _, bound, number, one = heapq.heappop(self._by_needs)
        self._taken.add(number)
        return bound, one


class _State(NamedTuple):
    """What is out, after which steps."""

    spent: float
    out: frozenset[int]
    tool: str
    """In hand."""
    steps: tuple[Ordered, ...]


class _Order:
    """The quickest order of units: A* over what is out and which tool is in hand.

    A step that has to be done, costs as little as it ever will and needs no other tool is done at once: to do it
    earlier makes no other step longer.
    """

    def __init__(self, problem: Problem, units: Sequence[Unit], goes_on: Callable[[], bool]) -> None:
        self.problem, self.units, self._goes_on = problem, units, goes_on
        self.all = frozenset(item for unit in units for item in unit.items)
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
            more = {each for unit in self.units if self._needs(unit) & found for each in unit.items}
            if more <= found:
                return frozenset(found - {item})
            found |= more

    def _needs(self, unit: Unit) -> frozenset[int]:
        """The items that have to be out before a unit: of joints those that are alone in it."""
        if unit not in self._needed:
            joints = [joint & self.all for item in unit.items for joint in self.problem.holders(item)]
            alone = frozenset[int]().union(*(joint for joint in joints if len(joint) == 1))
            self._needed[unit] = (unit.before | alone) - set(unit.items)
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
                grown = out | set(step.unit.items)
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
                    out, tool = state.out | set(step.unit.items), step.choice.tool or state.tool
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
        gone = out | set(unit.items)
        return all(joint & gone for item in unit.items for joint in self.problem.holders(item))

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


def _leading_to(items: set[int], chosen: Mapping[int, Way]) -> set[int]:
    """Items, and the parts that wait for them: these may turn out to leave together."""
    found = set(items)
    while more := {item for item, way in chosen.items() if item not in found and way.blockers & found}:
        found |= more
    return found


def _in_common(motions: Sequence[Motions]) -> Hashable | None:
    """The first motion that all have."""
    return next((one for one in motions[0] if all(one in other for other in motions[1:])), None)


def _groups(chosen: Mapping[int, Way]) -> list[list[int]]:
    """The parts that block each other in a circle, together (Tarjan 1972), those that leave first come first."""
    number: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    groups: list[list[int]] = []

    def visit(item: int) -> None:
        number[item] = low[item] = len(number)
        stack.append(item)
        for other in sorted(chosen[item].blockers & chosen.keys()):
            if other not in number:
                visit(other)
                low[item] = min(low[item], low[other])
            elif other in stack:
                low[item] = min(low[item], number[other])
        if low[item] == number[item]:
            group = stack[stack.index(item) :]
            del stack[len(stack) - len(group) :]
            groups.append(sorted(group))

    for item in sorted(chosen):
        if item not in number:
            visit(item)
    return groups
