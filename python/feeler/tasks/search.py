"""Which parts have to go, and in which order, for the least time: a best-first search with a bound.

The plan is an AND/OR graph (Homem de Mello and Sanderson 1990). A *set* is what a plan takes out. Each of its items has
needs: fasteners that hold it, parts in the way of a motion, parts in the way of a tool. A need has alternatives; a set
grows by one of them. Needs with one alternative are settled at once. Sets wait in order of their bound, the sum of the
least times of their items; of equal ones the newest is first. A set without open needs is put in
order by a second search, over what is out and which tool is in hand.

Where bounds are low, many sets are below every plan. If none was found for long, each second set is thus the one that
has come furthest. All others wait, so the bound is as good.

A part may leave with what is fastened to it alone, its riders, where they are. So an item in the way is out with a part
that it rides on, too; and of a part and its riders those may be undone before that are in the way of its motions.

What is out never blocks, so more parts out never close a way. Hence at a need one of its alternatives is in every plan
that grows from the set, and the least bound of all sets that have not been given up is a bound of every plan.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from feeler.tasks.ordering import Order
from feeler.tasks.problem import SLACK, Motions, Ordered, Problem, Unit, Way

MOST_SETS = 20_000
"""Sets of one search; beyond it the best order so far is returned, with the bound of those that wait."""
PATIENCE = 200
"""Sets by their bound alone; after these, without a plan, each second one is that which has come furthest."""
MOST_MORE = 500
"""Sets that are still looked at once a plan was found."""
SETTLED = 0.75
"""The share of the progress of a search when it has a plan."""
_DIGITS = 6
"""To which bounds are rounded: sums of the same times in another order are equal."""


class Need(NamedTuple):
    """Something that has to be settled: whether parts ride on another one, what an item in the way leaves with, the way
    of a fastener or part, a joint, or the reach of a tool. Joints come after ways, as these often settle them, and
    reach last: what is out gives room."""

    rank: int
    item: int
    more: tuple[int, ...] = ()
    """The parts that may ride on a part; the parts that an item in the way may leave with; of a joint the fasteners of
    which one is undone."""


_NEVER, _RIDE, _WITH, _AXIS, _WAY, _JOINT, _REACH = range(7)


class _Asked(NamedTuple):
    """An item that a set has to have."""

    item: int
    is_alone: bool
    """Whether it has to be undone or taken out by itself: no part that it rides on will do."""
    but: frozenset[int] = frozenset()
    """Parts that it may not leave with."""


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
    on: Mapping[int, frozenset[int]] = field(default_factory=dict)
    """Of parts, those that ride on them though they are fastened to others, too."""
    less: Mapping[int, frozenset[int]] = field(default_factory=dict)
    """Of parts, those that do not ride on them though they could."""

    @property
    def key(self) -> Hashable:
        """Equal for equal sets."""
        chosen = tuple(sorted(self.chosen.items(), key=lambda each: each[0]))
        costs = tuple(sorted(self.costs.items()))
        return (self.items, self.needs, chosen, costs, self.stays, _plain(self.on), _plain(self.less))


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
        self._fixed: dict[int, frozenset[int]] = {}

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
            nothing = _Set(frozenset(), ())
            alone = {next(iter(joint)) for joint in self._certain(nothing, item) if len(joint) == 1}
            before = set(problem.needed(item)) if is_turned else set[int]()
            has_riders = bool(self._riding(nothing, item) or self._extensions(nothing, item))
            ways = [] if has_riders else [way.blockers for way in problem.ways(item, frozenset())]
            in_all = frozenset.intersection(*ways) if ways else frozenset[int]()
            before |= {each for each in in_all if is_turned or self._leaves_alone(each)}
            before = alone | {each for each in before if not problem.carriers(each)}
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
        """Whether no plan takes it out together with another item, but for its riders."""
        if self.problem.is_turned(item):
            return True
        nothing = _Set(frozenset(), ())
        ways = self.problem.ways(item, self._riding(nothing, item))
        return not (self._extensions(nothing, item) or any(way.blockers for way in ways))

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
            dragging = self._dragging(one)
            new = []
            if dragging:
                bare = self._bared(one, dragging)
                new = [bare] if bare is not None else []
                continue
            steps, blocked = self._in_order(one)
            if steps is None:
                new = list(self._with_each(one, blocked))
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
        parts = self._parts(one, self._carried(one))
        open_ = _leading_to({need.item for need in one.needs if need.rank in (_WITH, _WAY)}, parts)
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
                joint = frozenset(need.more)
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

    def _grown(self, one: _Set, more: Iterable[int], asked: Iterable[_Asked] = ()) -> _Set | None:
        """The set with more items, and what each of them needs for sure; None if that has to stay."""
        items, needs, chosen = set(one.items), list(one.needs), dict(one.chosen)
        problem = self.problem
        waiting = [*(_Asked(item, True) for item in more), *asked]
        while waiting:
            item, is_alone, but = waiting.pop(0)
            if item in items:
                continue
            carriers = frozenset[int]() if is_alone else problem.carriers(item) - but
            if carriers:
                needs.append(Need(_WITH, item, tuple(sorted(carriers))))
                continue
            if item in one.stays:
                return None
            items.add(item)
            if problem.is_turned(item):
                if math.isinf(problem.least(item)):
                    self._note(item, frozenset())
                    needs.append(Need(_NEVER, item))
                    continue
                ways = problem.ways(item, frozenset())
                in_its_way = set(problem.needed(item))
                if len(ways) == 1:
                    chosen[item] = ways[0]
                    in_its_way |= ways[0].blockers
                else:
                    needs.append(Need(_AXIS, item))
                waiting += self._in_the_way(item, in_its_way - items)
                needs.append(Need(_REACH, item))
            else:
                so_far = replace(one, items=frozenset(items), chosen=chosen)
                certain = self._certain(so_far, item)
                held = sorted({each for joint in certain for each in joint} - items)
                problem.expect(held, None)
                problem.expect(held, frozenset())
                alone, joined = self._held(so_far, item, certain)
                waiting += alone
                needs += [*joined, Need(_WAY, item)]
        grown = replace(one, items=frozenset(items), needs=tuple(sorted(set(needs))), chosen=chosen)
        carried = self._carried(grown)
        again = self._again(grown, carried)
        if again is not None:
            return self._grown(*again)
        if any(each in one.stays and carrier != self.target for each, carrier in carried.items()):
            return None
        return replace(grown, needs=tuple(need for need in grown.needs if self._is_open(need, grown, carried)))

    def _again(self, one: _Set, carried: Mapping[int, int]) -> tuple[_Set, tuple[()], list[_Asked]] | None:
        """A set in which less rides on its parts than when their ways were found: it needs these anew, and what is in
        the way of others by other means."""
        there = one.items | carried.keys()
        lost = [item for item, way in one.chosen.items() if way.riding - there]
        if lost:
            left = {item: way for item, way in one.chosen.items() if item not in lost}
            fewer = replace(one, chosen=left)
            held = [self._held(fewer, item, self._certain(fewer, item)) for item in lost]
            needs = [*(Need(_WAY, item) for item in lost), *(need for _, more in held for need in more)]
            asked = [each for alone, _ in held for each in alone]
            return replace(fewer, needs=(*one.needs, *needs)), (), asked
        there |= {need.item for need in one.needs if need.rank == _WITH}
        missing = [(item, way.blockers - there) for item, way in one.chosen.items() if way.blockers - there]
        if missing:
            return one, (), [each for item, more in missing for each in self._in_the_way(item, more)]
        return None

    def _is_open(self, need: Need, one: _Set, carried: Mapping[int, int]) -> bool:
        """Whether a set has not settled a need yet."""
        if need.rank == _RIDE:
            return frozenset(need.more) in self._extensions(one, need.item)
        if need.rank == _JOINT:
            return not one.items & set(need.more)
        if need.rank != _WITH or need.item in one.items:
            return need.rank != _WITH
        return carried.get(need.item, self.target) == self.target

    def _in_the_way(self, item: int, blockers: Iterable[int]) -> list[_Asked]:
        """What is in the way of an item: out alone, or with another part before it. Parts can leave with the wanted
        ones, which fasteners cannot wait for."""
        is_last = item == self.target or self.problem.is_turned(item)
        but = frozenset([item, self.target] if is_last else [item])
        return [_Asked(each, False, but) for each in sorted(blockers)]

    def _held(self, one: _Set, item: int, certain: Iterable[frozenset[int]]) -> tuple[list[_Asked], list[Need]]:
        """What has to be undone for a part to leave with what rides on it, and what may ride on it."""
        joints = [joint for joint in certain if not joint & one.items]
        alone = [_Asked(each, True) for joint in joints if len(joint) == 1 for each in joint]
        needs = [Need(_RIDE, item, tuple(sorted(more))) for more in self._extensions(one, item)]
        needs += [Need(_JOINT if joint else _NEVER, item, tuple(sorted(joint))) for joint in joints if len(joint) != 1]
        return alone, needs

    def _certain(self, one: _Set, item: int) -> list[frozenset[int]]:
        """The joints of a part that are undone whatever else rides on it."""
        riding, off, on = self._riding(one, item), self._off(one, item), one.on.get(item, frozenset())
        found = list(self.problem.holders(item, riding))
        for more in self._extensions(one, item):
            longer = set(self.problem.holders(item, self.problem.riding(item, off, on | more)))
            found = [joint for joint in found if joint in longer]
        return found

    def _off(self, one: _Set, item: int) -> frozenset[int]:
        """What does not ride on a part: it is out alone, left behind, or forced to go before or after others of it."""
        if item not in self._fixed:
            problem = self.problem
            own = [
                {each, ahead} - {item}
                for each, all_ in self._forced.items()
                for ahead in all_
                if all(one == item or item in problem.carriers(one) for one in (each, ahead))
            ]
            self._fixed[item] = frozenset[int]().union(*own)
        return one.items | one.less.get(item, frozenset()) | self._fixed[item]

    def _riding(self, one: _Set, item: int) -> frozenset[int]:
        """What rides on a part of a set; once its way is known, nothing more than then."""
        found = self.problem.riding(item, self._off(one, item), one.on.get(item, frozenset()))
        return found & one.chosen[item].riding if item in one.chosen else found

    def _extensions(self, one: _Set, item: int) -> Sequence[frozenset[int]]:
        """Parts of which it is open whether they ride on a part."""
        return self.problem.extensions(item, self._off(one, item), one.on.get(item, frozenset()))

    def _carried(self, one: _Set) -> dict[int, int]:
        """What a set takes out with its parts, and with which of them."""
        found: dict[int, int] = {}
        for item in sorted(one.items):
            if not self.problem.is_turned(item):
                found.update((each, item) for each in sorted(self._riding(one, item)) if each not in found)
        return found

    def _parts(self, one: _Set, carried: Mapping[int, int]) -> dict[int, Way]:
        """The ways of the parts of a set; of what rides on a part, that part is in the way instead."""
        found = {}
        for item, way in one.chosen.items():
            if not self.problem.is_turned(item):
                blockers = frozenset(carried.get(each, each) for each in way.blockers) - {item}
                found[item] = way._replace(blockers=blockers)
        return found

    def _children(self, one: _Set) -> Iterator[_Set]:
        """The sets that settle the first need of a set, each in one way."""
        need = one.needs[0]
        left = replace(one, needs=one.needs[1:])
        item, problem = need.item, self.problem
        if need.rank == _NEVER:
            self._note(item, frozenset())
        elif need.rank == _RIDE:
            more = frozenset(need.more)
            yield from self._rode(replace(left, on={**one.on, item: one.on.get(item, frozenset()) | more}), item)
            yield from self._rode(replace(left, less={**one.less, item: one.less.get(item, frozenset()) | more}), item)
        elif need.rank == _WITH:
            yield from self._with_each(left, [item])
            yield from self._with_each(left, set(need.more) - one.items)
            if self.target in need.more:
                yield left  # it leaves with the wanted parts
        elif need.rank == _JOINT:
            yield from self._with_each(left, need.more)
        elif need.rank == _AXIS:
            ways = problem.ways(item, frozenset())
            if not ways:
                self._note(item, frozenset())
            yield from self._by_each(left, item, ways)
        elif need.rank == _WAY:
            yield from self._led(left, need)
        else:
            yield from self._reached(one, item, left)

    def _rode(self, one: _Set, item: int) -> Iterator[_Set]:
        """The set in which it is settled what rides on a part: what holds it then has to be undone."""
        alone, needs = self._held(one, item, self._certain(one, item))
        grown = self._grown(replace(one, needs=(*one.needs, *needs)), (), alone)
        if grown is not None:
            yield grown

    def _led(self, left: _Set, need: Need) -> Iterator[_Set]:
        """The sets in which a part leaves in each of its ways, or with less on it."""
        item, problem = need.item, self.problem
        riding = self._riding(left, item)
        ways = [way._replace(riding=riding) for way in problem.ways(item, riding)]
        if not ways:
            self._note(item, frozenset())
        yield from self._by_each(left, item, ways)
        if riding and all(way.blockers for way in ways):
            for load in problem.loads(item, riding):
                less = {**left.less, item: left.less.get(item, frozenset()) | {load}}
                yield from self._rode(replace(left, less=less, needs=(*left.needs, need)), item)

    def _by_each(self, one: _Set, item: int, ways: Iterable[Way]) -> Iterator[_Set]:
        """A set for each way of an item."""
        for way in ways:
            asked = self._in_the_way(item, way.blockers - one.items)
            grown = self._grown(replace(one, chosen={**one.chosen, item: way}), (), asked)
            if grown is not None:
                yield grown

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
        choices, blockers = problem.tooled(item, self._out_before(item, one))
        more = blockers - one.items - {item}
        carriers = frozenset[int]().union(*map(problem.carriers, more)) - one.items - {item}
        if not choices:
            yield from self._with_each(one, more | carriers)
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
            yield from self._with_each(one, more | carriers)

    def _note(self, item: int, blockers: frozenset[int]) -> None:
        self.stuck.setdefault(item, blockers)

    def _out_before(self, item: int, one: _Set) -> frozenset[int]:
        """What a set can have out before a fastener is undone: not what it alone holds, nor what waits for that."""
        carried = self._carried(one)
        parts = [each for each in one.items if not self.problem.is_turned(each)]
        found = {each for each in parts if frozenset([item]) in self._joints(one, each)}
        while True:
            more = {each for each, way in one.chosen.items() if {carried.get(b, b) for b in way.blockers} & found}
            if self.target in one.items:
                more.add(self.target)
            if more <= found:
                break
            found |= more
        with_them = {each for each, carrier in carried.items() if carrier not in found}
        return frozenset(one.items - found | with_them) - {item}

    def _in_order(self, one: _Set) -> tuple[tuple[Ordered, ...] | None, frozenset[int]]:
        """The quickest order of a set; if there is none, items beyond it that may help."""
        carried = self._carried(one)
        for item in one.chosen:
            for joint in () if self.problem.is_turned(item) else self._joints(one, item):
                if not joint & one.items:
                    return None, joint
        units = self._units(one, carried)
        if units is None:
            return None, frozenset()
        order = Order(self.problem, units, self._goes_on)
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
        # What waits for a part that leaves too late may be out alone.
        late = frozenset[int]().union(*order.waiting.values()) if order.waiting else frozenset[int]()
        return None, helping - one.items | late & carried.keys()

    def _dragging(self, one: _Set) -> list[int]:
        """Parts with riders that leave together with the wanted ones: these are led out of them, not with all of it."""
        carried = self._carried(one)
        groups = _groups(self._parts(one, carried))
        last = next((set(group) for group in groups if self.target in group), set[int]()) - {self.target}
        return sorted(last & set(carried.values()))

    def _bared(self, one: _Set, items: Sequence[int]) -> _Set | None:
        """A set in which nothing rides on some of its parts."""
        carried, less = self._carried(one), dict(one.less)
        for item in items:
            less[item] = less.get(item, frozenset()) | {each for each, carrier in carried.items() if carrier == item}
        chosen = {item: way for item, way in one.chosen.items() if item not in items}
        bare = replace(one, less=less, chosen=chosen)
        held = [self._held(bare, item, self._certain(bare, item)) for item in items]
        needs = [*(Need(_WAY, item) for item in items), *(need for _, more in held for need in more)]
        return self._grown(replace(bare, needs=(*one.needs, *needs)), (), [each for alone, _ in held for each in alone])

    def _units(self, one: _Set, carried: Mapping[int, int]) -> list[Unit] | None:
        """The steps of a set, without their order: parts that block each other leave together."""
        parts = self._parts(one, carried)
        units = []
        for group in _groups(parts):
            motion = _in_common([parts[item].motions for item in group])
            if motion is None:
                self._note(group[0], frozenset(group[1:]))
                return None
            riding = tuple(sorted(each for each, carrier in carried.items() if carrier in group))
            before = frozenset[int]().union(*(one.chosen[item].blockers for item in group))
            before |= frozenset[int]().union(*(self._first(item, one, carried) for item in (*group, *riding)))
            before |= frozenset[int]().union(*(one.chosen[item].riding & one.items for item in group))
            joints = [self._joints(one, item) for item in group]
            bodies = tuple(one.chosen[item].riding for item in group)
            out = before - set(group) - set(riding)
            units.append(
                Unit(tuple(group), motion, out, tuple(each for some in joints for each in some), bodies, riding)
            )
        for item in sorted(one.items - parts.keys()):
            way = one.chosen[item]
            units.append(Unit((item,), way.motions[0], way.blockers | self._first(item, one, carried)))
        return units

    def _joints(self, one: _Set, item: int) -> Sequence[frozenset[int]]:
        """The joints of a part, with what rides on it, that are undone before it leaves."""
        return self.problem.holders(item, self._riding(one, item))

    def _first(self, item: int, one: _Set, carried: Mapping[int, int]) -> frozenset[int]:
        """The items of a set that are forced to go before one of them."""
        return self._forced.get(item, frozenset()) & (one.items | carried.keys()) - {item}

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


def _plain(sets: Mapping[int, frozenset[int]]) -> Hashable:
    """Equal for equal sets."""
    return tuple(sorted((item, tuple(sorted(found))) for item, found in sets.items()))


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
