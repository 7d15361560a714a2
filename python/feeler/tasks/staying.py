"""Why parts stay: what a task says if it finds no plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum

from feeler.plan.question import TARGET
from feeler.tasks.actions import Actions
from feeler.tasks.forced import behind, turned
from feeler.tasks.steps import TaskBlocker


class _Need(Enum):
    """Why one item has to go after another: words for the item, and for the other."""

    HELD = "a fastener that holds it", "a part that it holds"
    TOOL = "what is in the way of its tool", "a fastener whose tool it keeps out"
    WAY = "what is in its way", "a part that it blocks"

    def __init__(self, first: str, second: str) -> None:
        self.first, self.second = first, second


class Staying:
    """The reasons for items that nothing frees."""

    def __init__(
        self, actions: Actions, wanted: tuple[str, ...], forced: Mapping[int, frozenset[int]], stuck: Iterable[int]
    ) -> None:
        """wanted: paths. forced: of items those that have to go before them. stuck: the items."""
        self._actions, self._wanted, self._stuck = actions, wanted, frozenset(stuck)
        self._ahead, self._behind = forced, turned(forced)
        self._question = actions.question
        self._paths = self._question.scene.mockup.part_paths

    def in_its_way(self) -> TaskBlocker:
        """Of the wanted parts what is known to hold them, and to be in their way where the fewest are, if the search
        ended before it knew what stays."""
        actions = self._actions
        first = sorted({item for joint in actions.certain(TARGET) for item in joint})
        node = actions.node(TARGET, actions.riding(TARGET))
        ways = [sorted(one.blockers) for one in actions.graph.known(node)]
        more = min(ways, key=len) if ways else []
        nodes = dict.fromkeys([*(more or sorted(actions.graph.touching(node))), *first])
        firsts = [part for each in nodes for part in self._question.parts_of([each])[:1]]
        return self._row(self._wanted[0], "the search ended before a plan was found", firsts)

    def blocker(self, item: int) -> TaskBlocker:
        """Why an item stays."""
        actions, question = self._actions, self._question
        parts = question.parts_of([item])
        first = next(iter([*(part for part in question.wanted if item == TARGET), *parts]), None)
        path = ", ".join(self._wanted) if first is None else self._paths[first if item == TARGET else item]
        for because, items in self._by_order(item) if item in self._ahead or item in self._behind else ():
            if items:
                return self._row(path, because, question.parts_of(sorted(items)))
        if not actions.is_turned(item):
            empty = any(not joint for joint in actions.certain(item))
            said = "a fastener that holds it is kept" if empty else "no way out was found"
            ahead = actions.kept_holders(self._node(item)) if empty else question.parts_of(self._around(item))
            return self._row(path, said, ahead)
        if item in actions.met:
            return self._row(path, "it does not come out along its axis", actions.met[item])
        answer = actions.answer(item, frozenset())
        if answer.tooled:
            before = question.parts_of(sorted(actions.needed(item)))
            return self._row(path, "what has to go before it does not come out", before)
        return self._row(path, f"no tool reaches it: {answer.because}", answer.blockers)

    def _by_order(self, item: int) -> Iterable[tuple[str, Iterable[int]]]:
        """What the forced order makes wait for an item, and what has to go before it."""
        ahead = behind(self._ahead, item)
        for need in _Need:
            yield f"by the forced order it goes before {need.first}", self._later(item, need)
        for need in _Need:
            yield f"by the forced order it goes after {need.second}", [o for o in ahead if item in self._later(o, need)]
        yield "what has to go before it by the forced order does not come out", ahead & self._stuck

    def _later(self, item: int, need: _Need) -> frozenset[int]:
        """The items that have to be out before this one, but that the forced order puts after it."""
        actions, later = self._actions, behind(self._behind, item)
        if need is _Need.HELD:
            return frozenset[int]().union(*(joint for joint in actions.certain(item) if joint <= later))
        if need is _Need.TOOL:
            return later & actions.needed(item) if actions.is_turned(item) else frozenset()
        return frozenset() if actions.is_turned(item) else later & self._known(item).keys()

    def _around(self, item: int) -> list[int]:
        """What is in the way of a part, most often first; what touches it, if that is not known."""
        known = self._known(item)
        touching = self._actions.graph.touching(self._node(item))
        return sorted(known, key=lambda each: (-known[each], each)) or sorted(touching)

    def _known(self, item: int) -> Mapping[int, int]:
        """As `known_blockers` of the graph."""
        return self._actions.graph.known_blockers(self._node(item))

    def _node(self, item: int) -> int:
        return self._actions.node(item, self._actions.riding(item))

    def _row(self, path: str, because: str, blockers: Iterable[int]) -> TaskBlocker:
        return TaskBlocker(path, because, tuple(self._paths[part] for part in blockers))
