"""`feeler.removal_order`: the parts to remove before a part comes out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy.typing as npt

from feeler.arguments import check_length, check_number, check_progress, check_threads, check_whole
from feeler.errors import MeshError
from feeler.mockup import Tool
from feeler.parts import PartsLike
from feeler.plan.blocking import BlockingGraph
from feeler.plan.question import TARGET, Clock, Question
from feeler.plan.removal import LARGEST_SEED, Allowed, Removal, alone
from feeler.plan.sequence import Exit, SequenceStep, shortest_sequence
from feeler.progress import Progress
from feeler.renamed import ALLOW, OldAttributes, keywords
from feeler.scene import Scene

TRY_SHARE = 0.05
"""An attempt with pushes and random trees takes at most this share of the time, at first. A larger value finds harder
ways, but fewer."""
LEAST_TRY_S = 0.25
"""The least seconds of such an attempt, and of one along a direction."""


@dataclass(frozen=True)
class RemovalStep:
    """Parts that leave together, and their way, in the mock-up without the parts of the previous steps."""

    parts: tuple[int, ...]
    removal: Removal


@dataclass(frozen=True)
class RemovalOrder(OldAttributes):
    """The parts to remove, in order, the wanted ones last.

    - `is_found`: whether these steps free the wanted parts. False is no proof that nothing does.
    - `steps`: `RemovalStep`s in order. If no order was found: the best attempt of the wanted parts alone.
    - `seconds`: the time it took.
    """

    _RENAMED: ClassVar[Mapping[str, str]] = {"found": "is_found"}

    is_found: bool
    steps: tuple[RemovalStep, ...]
    seconds: float

    @property
    def parts(self) -> tuple[int, ...]:
        """All removed parts, in order, including the wanted ones."""
        return tuple(part for step in self.steps for part in step.parts)

    def __len__(self) -> int:
        return len(self.steps)

    def __iter__(self) -> Iterator[RemovalStep]:
        return iter(self.steps)

    def __repr__(self) -> str:
        said = f"{len(self.steps)} steps" if self.is_found else "not found"
        return f"RemovalOrder({said})"


@keywords({"part": "parts"}, gone={"allow": ALLOW})
def removal_order(
    scene: Scene,
    parts: PartsLike,
    tool: Tool | None = None,
    start: npt.ArrayLike | None = None,
    ignore: PartsLike | None = None,
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 60.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    keep: PartsLike | None = None,
    *,
    overlap: float = 0.0,
    seats: bool = True,
) -> RemovalOrder:
    """The parts to remove before these come out, in the fewest steps, and the way of each.

    Arguments as of `feeler.removal`; `parts` come out together, with the tool; those that go before go without it.

    - Parts that block each other leave together in one step if none comes out alone.
    - Fasteners leave before the parts that they join (`find_fasteners`), unless they are kept or do not come out.
    - `keep`: parts that must stay, as `Parts.select` takes them.
    - `seconds`: in total. The search ends earlier only if it finds an order.
    - `progress`: called with the share of the time, 0 to 1, and the current attempt.

    The order is the shortest of those with straight motions. A part that none of these takes out is tried by pushes and
    random trees as well; so are `parts` before it is said that others have to go.

    Raises the errors of `feeler.removal`; Ctrl-C ends it with `KeyboardInterrupt`.
    """
    limit = check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True)
    check_progress(progress)
    check_whole("seed", seed, 0, LARGEST_SEED)
    allowed = Allowed.of(scene, ignore, overlap, seats)
    check_length("clearance", clearance)
    check_threads(threads)
    if not isinstance(tool, (Tool, type(None))):
        raise MeshError(f"tool is a feeler.Tool that grips the parts, not {type(tool).__name__}")
    wanted = tuple(int(each) for each in scene.mockup.parts.select(parts))
    kept = frozenset() if keep is None else frozenset(scene.mockup.parts.select(keep).tolist()).difference(wanted)
    question = Question(
        scene,
        wanted,
        kept,
        {"tool": tool, "start": start, "directions": directions},
        {
            "ignore": list(allowed.parts),
            "overlap": allowed.overlap,
            "seats": allowed.seats,
            "clearance": clearance,
            "seed": seed,
            "threads": threads,
        },
    )
    return _Search(question, Clock(limit, progress)).order()


class _Search:
    """Plans from the blockers of straight motions, checks each step, and tries bent ways for stuck parts."""

    def __init__(self, question: Question, clock: Clock) -> None:
        self.question, self.clock = question, clock
        self.graph = BlockingGraph(question, clock)
        self.ways: dict[tuple[int, ...], list[tuple[frozenset[int], Removal]]] = {}
        self.tries = 0
        self.last: Removal | None = None

    def order(self) -> RemovalOrder:
        """The order; if there is none, the best attempt of the wanted parts."""
        question, target = self.question, frozenset([TARGET])
        if int(question.scene.part_mask.sum()) == len(question.wanted):
            return self._ended(True, [RemovalStep(question.wanted, alone(int(question.options["seed"])))])
        in_place = question.straight_way(LEAST_TRY_S, self.clock)
        is_held = bool(self.graph.holding(TARGET))
        if in_place is not None and not is_held:
            return self._ended(True, [RemovalStep(question.wanted, in_place)])
        plan = self._plan()
        if (plan is None or len(plan) > 1) and not is_held and self._try_bent(target, frozenset(), self._try_s(0)):
            plan = self._plan()
        rounds = 0
        while self.clock.goes_on():
            steps = None if plan is None else self._checked(plan)
            if steps is not None:
                return self._ended(True, steps)
            if plan is None:
                self._try_what_is_stuck(rounds)
                rounds += 1
            plan = self._plan()
        last = self.last or question.removal(target, frozenset(), None, LEAST_TRY_S, self.clock)
        return self._ended(False, [RemovalStep(question.wanted, last)])

    def _ended(self, found: bool, steps: list[RemovalStep]) -> RemovalOrder:
        return RemovalOrder(found, tuple(steps), self.clock.spent)

    def _plan(self) -> list[SequenceStep] | None:
        return shortest_sequence(TARGET, self.graph, self.question.node_count, self.clock.goes_on)

    def _checked(self, plan: list[SequenceStep]) -> list[RemovalStep] | None:
        """The steps with their ways. If a step has none, the graph learns its blockers, and the result is empty."""
        steps: list[RemovalStep] = []
        gone: frozenset[int] = frozenset()
        for step in plan:
            way = self._way(step, gone)
            if way is None:
                return None
            steps.append(RemovalStep(self.question.parts_of(step.parts), way))
            gone |= step.parts
        return steps

    def _way(self, step: SequenceStep, gone: frozenset[int]) -> Removal | None:
        question = self.question
        parts = question.parts_of(step.parts)
        if int(question.scene.part_mask.sum()) == len(parts) + len(question.parts_of(gone)):
            return alone(int(question.options["seed"]))
        known = next((way for before, way in self.ways.get(parts, []) if before == gone), None)
        if known is not None:
            return known
        direction = step.motion if isinstance(step.motion, tuple) else None
        way = question.removal(step.parts, gone, direction, LEAST_TRY_S, self.clock)
        if not way.is_found and (direction is None or not way.blocked_by):
            # There was no time left for the direction itself, or the way is bent.
            way = question.removal(step.parts, gone, direction, self._try_s(0), self.clock)
        if not way.is_found:
            # A way that was found with more parts removed is valid if it is free of those still there.
            held = next((way for before, way in self.ways.get(parts, []) if before <= gone), None)
            if held is None:
                self._learn_blockers(step, gone, way)
                return None
            way = held
        self.ways.setdefault(parts, []).append((gone, way))
        return way

    def _learn_blockers(self, step: SequenceStep, gone: frozenset[int], tried: Removal) -> None:
        """Adds blockers: a step that is not free has more of them than casts along it found."""
        worst = (self.question.node_of(each.part) for each in tried.blocked_by)
        more = next((node for node in worst if node not in step.parts), None)
        for node in step.parts:
            for one in self.graph.forget(node, step.motion):
                if more is not None and more not in self.question.kept:
                    self.graph.learn(node, replace(one, blockers=one.blockers | {more}))

    def _try_what_is_stuck(self, rounds: int) -> None:
        """Pushes and trees for stuck parts, with all removable parts gone: first for the wanted parts, then for small
        ones, longer in each round. Ends with the first success, which may make a plan possible."""
        gone = self.graph.most_gone()
        stuck = [frozenset([node]) for node in sorted(self.graph.reached(), key=self.question.size) if node not in gone]
        worst = [] if self.last is None else [self.question.node_of(each.part) for each in self.last.blocked_by[:2]]
        pairs = [frozenset([TARGET, node]) for node in worst if node not in self.question.kept and node not in gone]
        for nodes in [*stuck, *pairs]:
            if not self.clock.goes_on() or self._try_bent(nodes, gone, self._try_s(rounds)):
                return

    def _try_bent(self, nodes: frozenset[int], gone: frozenset[int], seconds: float) -> bool:
        """Whether a way exists with some parts gone; the graph learns it, with those of them that it collides with."""
        question = self.question
        if len(nodes) + len(gone) >= question.node_count:
            return False
        way = question.removal(nodes, gone, None, seconds, self.clock, seed=self.tries)
        self.tries += 1
        if nodes == {TARGET}:
            self.last = way
        if not way.is_found:
            return False
        met = frozenset(node for node in gone if question.is_met(nodes, node, way))
        self.ways.setdefault(question.parts_of(nodes), []).append((met, way))
        for node in nodes:
            self.graph.learn(node, Exit((self.tries,), met | nodes - {node}, self.graph.holding(node)))
        return True

    def _try_s(self, rounds: int) -> float:
        return max(LEAST_TRY_S, TRY_SHARE * self.clock.seconds) * 2.0**rounds
