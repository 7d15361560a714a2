"""The shortest disassembly sequence, searched over the ways that each part could go.

Each part has a few motions, and for each motion the parts that block it: the arcs of a directional blocking graph
(Wilson and Latombe 1994). A sequence chooses one motion for each part that has to go. Parts that block each other, in a
cycle, must move together, which they can where they share the motion: each strongly connected component is one step.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

STANDING_COST = 1000.0
"""Steps that a sequence may be longer so that one fastener is not left standing in what it joins."""
UNSEEN_COST = 0.75
"""Steps that a part counts for as long as its blockers are not known. Less than 1 looks at more parts, and prefers
sequences that are not known in full to known ones of the same length."""
MOST_STATES = 20_000
"""States of the search: of more, the sequence so far is not the shortest, so none is given."""


@dataclass(frozen=True)
class Exit:
    """A motion by which a part could go, or several that the same parts block."""

    motions: tuple[Hashable, ...]
    """The one that is preferred first. Parts with a motion in common can move together."""
    blockers: frozenset[int]
    """Parts that are in the way: they go before, or along."""
    fasteners: frozenset[int] = frozenset()
    """Fasteners that join the part to another: they go before, or along where the part blocks them."""


@dataclass(frozen=True)
class SequenceStep:
    """Parts that go together, by one motion."""

    parts: frozenset[int]
    motion: Hashable


def undominated(exits: Sequence[Exit]) -> list[Exit]:
    """The exits of one part, those with the same needs as one, and without those that need all that another does.

    A part that could go without others would go without them: only those that block each other move together.
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
    """Where the exits of parts come from."""

    def exits(self, node: int) -> Sequence[Exit]:
        """The exits of a part; to find them may take long."""

    def is_known(self, node: int) -> bool:
        """Whether they are known already."""

    def holding(self, node: int) -> frozenset[int]:
        """The fasteners that join a part to others: found in less time."""


def shortest_sequence(
    target: int, graph: Graph, node_count: int, goes_on: Callable[[], bool]
) -> list[SequenceStep] | None:
    """The steps after which `target` is out, it last; `None` where there are none, or no time is left.

    The exits of a part are asked for only if it may be in a shortest sequence. `node_count` parts are all there is: not
    all that is left can be moved out together. Best first: the cost is the number of steps, and a part whose exit is
    not chosen yet counts for one at most.
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
        # Of the parts that are left, the one with the fewest exits.
        known = [part for part in pending if graph.is_known(part)]
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
    """Each exit with its fasteners gone before; and, at a cost, with them left."""
    for one in exits:
        yield one, 0.0
        standing = len(one.fasteners - one.blockers)
        if standing:
            yield Exit(one.motions, one.blockers), STANDING_COST * standing


def _pending(target: int, chosen: Mapping[int, Exit]) -> list[int]:
    """Parts that have to go, and of which no exit is chosen; in order of their numbers."""
    if not chosen:
        return [target]
    needed = {part for one in chosen.values() for part in one.blockers | one.fasteners}
    return sorted(needed - chosen.keys())


def _least_cost(part: int, chosen: Mapping[int, Exit], graph: Graph) -> float:
    """A part is a step more, and so is each fastener that holds it, unless it and one that is chosen block each other
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
    """Whether the parts of each component have a motion in common, and the last is not all that is left."""
    if len(groups[-1]) > 1 and len(chosen) >= node_count:
        return False
    return all(_in_common([chosen[part] for part in group]) for group in groups)


def _steps(chosen: Mapping[int, Exit]) -> list[SequenceStep]:
    groups = _groups(chosen)
    return [SequenceStep(frozenset(group), _in_common([chosen[part] for part in group])[0]) for group in groups]


def _in_common(exits: Sequence[Exit]) -> list[Hashable]:
    """The motions that all of these have."""
    return [motion for motion in exits[0].motions if all(motion in other.motions for other in exits[1:])]


def _groups(chosen: Mapping[int, Exit]) -> list[list[int]]:
    """The strongly connected components of who has to go before whom, those first that go first (Tarjan 1972)."""
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
