"""The shortest disassembly sequence, searched over the possible motions of each part.

Each part has a few motions, and each motion has the parts that block it: the arcs of a directional blocking graph
(Wilson and Latombe 1994). A sequence chooses one motion for each part that must leave. Parts that block each other in a
cycle must move together, which they can if they share the motion: each strongly connected component is one step.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

STANDING_COST = 1000.0
"""Extra steps that a sequence may take so that a fastener does not stay behind in the parts that it joins."""
UNSEEN_COST = 0.75
"""Steps counted for a part whose blockers are still unknown. With less than 1 the search examines more parts, and
prefers sequences that are not fully known to known ones of the same length."""
MOST_STATES = 20_000
"""The most states of the search; beyond it the best sequence so far need not be the shortest, so none is returned."""


@dataclass(frozen=True)
class Exit:
    """A motion by which a part could leave, or several with the same blockers."""

    motions: tuple[Hashable, ...]
    """The preferred one first. Parts with a common motion can move together."""
    blockers: frozenset[int]
    """Blocking parts: they leave before, or along."""
    fasteners: frozenset[int] = frozenset()
    """Fasteners that join the part to another: they leave before, or along if the part blocks them."""


@dataclass(frozen=True)
class SequenceStep:
    """Parts that leave together, by one motion."""

    parts: frozenset[int]
    motion: Hashable


def undominated(exits: Sequence[Exit]) -> list[Exit]:
    """The exits of one part; merges those with the same blockers, and drops those that need all blockers of another.

    A part that could leave without others would: only parts that block each other move together.
    """
    by_needs: dict[tuple[frozenset[int], frozenset[int]], list[Hashable]] = {}
    for one in exits:
        by_needs.setdefault((one.blockers, one.fasteners), []).extend(one.motions)
    kept: list[Exit] = []
    for (blockers, fasteners), motions in sorted(by_needs.items(), key=lambda each: len(each[0][0] | each[0][1])):
        needs = blockers | fasteners
        if not any(other.blockers | other.fasteners < needs for other in kept):
            kept.append(Exit(tuple(dict.fromkeys(motions)), blockers, fasteners))
    return kept


class Graph(Protocol):
    """The source of the exits of parts."""

    def exits(self, node: int) -> Sequence[Exit]:
        """The exits of a part; computing them may take long."""

    def is_known(self, node: int) -> bool:
        """Whether they are already computed."""

    def holding(self, node: int) -> frozenset[int]:
        """The fasteners that join a part to others; faster to compute."""


def shortest_sequence(
    target: int,
    graph: Graph,
    node_count: int,
    goes_on: Callable[[], bool],
    expect: Callable[[Sequence[int]], object] = lambda nodes: None,
) -> list[SequenceStep] | None:
    """The steps that free `target`, its own last; `None` if there are none, or no time is left.

    Computes the exits of a part only if it may be in a shortest sequence. There are `node_count` parts; the last step
    must leave one behind. Best first: the cost is the number of steps, and a part without a chosen exit counts for one
    at most. `expect` hears of the parts whose exits are likely to be asked for soon; the steps do not depend on it.
    """
    count = 0
    queue: list[tuple[float, int, dict[int, Exit], float]] = [(0.0, 0, {}, 0.0)]
    while queue:
        _, _, chosen, penalty = heapq.heappop(queue)
        pending = _pending(target, chosen)
        if not pending:
            return _steps(chosen)
        if not goes_on() or count > MOST_STATES:
            return None
        # Continue with the open part that has the fewest exits.
        known = [part for part in pending if graph.is_known(part)]
        if not known:
            expect(pending)
        part = min(known, key=lambda each: len(graph.exits(each))) if known else pending[0]
        for one, more in _with_fasteners_standing(graph.exits(part)):
            grown = {**chosen, part: one}
            groups = _groups(grown)
            if not _can_go(groups, grown, node_count):
                continue
            count += 1
            cost = penalty + more
            rest = sum(_least_cost(each, grown, graph) for each in _pending(target, grown))
            heapq.heappush(queue, (len(groups) + rest + cost, count, grown, cost))
    return None


def _with_fasteners_standing(exits: Sequence[Exit]) -> Iterator[tuple[Exit, float]]:
    """Each exit with its fasteners removed before; and, at a cost, with them left."""
    for one in exits:
        yield one, 0.0
        standing = len(one.fasteners - one.blockers)
        if standing:
            yield Exit(one.motions, one.blockers), STANDING_COST * standing


def _pending(target: int, chosen: Mapping[int, Exit]) -> list[int]:
    """Parts that must leave and have no chosen exit, by index."""
    if not chosen:
        return [target]
    needed = {part for one in chosen.values() for part in one.blockers | one.fasteners}
    return sorted(needed - chosen.keys())


def _least_cost(part: int, chosen: Mapping[int, Exit], graph: Graph) -> float:
    """A part costs one more step, and so does each fastener that holds it, unless it and a chosen part block each other
    along the same motion."""
    if not graph.is_known(part):
        return UNSEEN_COST + len(graph.holding(part) - chosen.keys())
    along = any(
        other in chosen and part in chosen[other].blockers and _in_common([one, chosen[other]])
        for one in graph.exits(part)
        for other in one.blockers
    )
    return 0.0 if along else 1.0


def _can_go(groups: Sequence[Sequence[int]], chosen: Mapping[int, Exit], node_count: int) -> bool:
    """Whether the parts of each component share a motion, and the last component is not all that is left."""
    if len(groups[-1]) > 1 and len(chosen) >= node_count:
        return False
    return all(_in_common([chosen[part] for part in group]) for group in groups)


def _steps(chosen: Mapping[int, Exit]) -> list[SequenceStep]:
    groups = _groups(chosen)
    return [SequenceStep(frozenset(group), _in_common([chosen[part] for part in group])[0]) for group in groups]


def _in_common(exits: Sequence[Exit]) -> list[Hashable]:
    """The motions that all of these share."""
    return [motion for motion in exits[0].motions if all(motion in other.motions for other in exits[1:])]


def _groups(chosen: Mapping[int, Exit]) -> list[list[int]]:
    """The strongly connected components of the precedence relation, those that leave first come first (Tarjan 1972)."""
    number: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    waiting: set[int] = set()
    groups: list[list[int]] = []

    def visit(part: int) -> None:
        number[part] = low[part] = len(number)
        stack.append(part)
        waiting.add(part)
        one = chosen[part]
        for other in sorted(one.blockers | one.fasteners):
            if other not in chosen:
                continue
            if other not in number:
                visit(other)
                low[part] = min(low[part], low[other])
            elif other in waiting:
                low[part] = min(low[part], number[other])
        if low[part] == number[part]:
            group = stack[stack.index(part) :]
            del stack[len(stack) - len(group) :]
            waiting.difference_update(group)
            groups.append(sorted(group))

    for part in chosen:
        if part not in number:
            visit(part)
    return groups
