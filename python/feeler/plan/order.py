"""`feeler.removal_order`: the parts to remove before a part comes out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import ClassVar, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_length, check_number, check_progress, check_threads, check_whole
from feeler.errors import MeshError, OptionError
from feeler.field_docs import documented
from feeler.mockup import Tool
from feeler.parts import PartsLike
from feeler.plan.blocking import BlockingGraph
from feeler.plan.crew import Crew
from feeler.plan.question import TARGET, Attempt, Budget, Clock, Question
from feeler.plan.removal import LARGEST_ROUNDS, LARGEST_SEED, Allowed, Removal, RemovalBlocker, alone
from feeler.plan.sequence import Exit, SequenceStep, shortest_sequence
from feeler.poses import PoseLike
from feeler.progress import Progress
from feeler.renamed import ALLOW, OldAttributes, keywords
from feeler.scene import Scene
from feeler.spreading import check_executor
from feeler.words import plural

TRY_SHARE = 0.05
"""An attempt with pushes and random trees takes at most this share of the time, or of the rounds, at first. A larger
value finds harder ways, but fewer."""
LEAST_TRY_S, LEAST_TRY_ROUNDS = 0.25, 2
"""The least seconds, or rounds, of such an attempt, and of one along a direction."""
MOST_FULL_PASSES = 8
"""With `rounds`, the search gives up after it has tried what is stuck this often with all of them: a way that it finds
is rarely refused by every plan, but may be."""
_MOST_DOUBLINGS = 62
"""The time of an attempt doubles with each pass, this often: by then it is longer than anybody waits."""


@documented
@dataclass(frozen=True)
class RemovalStep:
    """Parts that leave together, and their way, in the mock-up without the parts of the previous steps."""

    parts: tuple[int, ...]
    removal: Removal
    """How they leave."""


@documented
@dataclass(frozen=True)
class RemovalOrder(OldAttributes):
    """The parts to remove, in order, the wanted ones last; true if found.

    - `is_found`: whether these steps free the wanted parts. False is no proof that nothing does.
    - `steps`: `RemovalStep`s in order. If no order was found: the best attempt of the wanted parts alone.
    - `seconds`: the time it took.
    - `is_out_of_time`: whether time cut the search or one of its attempts. If not, the order is the same on every
      machine, with any number of threads and any executor.
    - `stuck`: if no order was found, the last parts on the search's way that could not leave: the wanted ones, or some
      that stand in their way.
    - `blocked_by`: the parts that stood in the way of those, most frequent first. A part that no attempt met, but casts
      did, counts once for each direction, at the identity.
    """

    _RENAMED: ClassVar[Mapping[str, str]] = {"found": "is_found"}

    is_found: bool
    steps: tuple[RemovalStep, ...]
    seconds: float
    is_out_of_time: bool = False
    stuck: tuple[int, ...] = ()
    blocked_by: tuple[RemovalBlocker, ...] = ()

    @property
    def parts(self) -> tuple[int, ...]:
        """All removed parts, in order, including the wanted ones."""
        return tuple(part for step in self.steps for part in step.parts)

    def __bool__(self) -> bool:
        return self.is_found

    def __len__(self) -> int:
        return len(self.steps)

    @overload
    def __getitem__(self, index: int) -> RemovalStep: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[RemovalStep, ...]: ...
    def __getitem__(self, index: int | slice) -> RemovalStep | tuple[RemovalStep, ...]:
        return self.steps[index]

    def __iter__(self) -> Iterator[RemovalStep]:
        return iter(self.steps)

    def __repr__(self) -> str:
        said = plural(len(self.steps), "step") if self.is_found else "not found"
        return f"RemovalOrder({said})"


class RemovalOrderInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.order` has the best attempt of the wanted parts by then, if there was one, as if none was found."""

    def __init__(self, order: RemovalOrder) -> None:
        self.order = order
        super().__init__(f"interrupted: {order!r}")

    def __reduce__(self) -> tuple[type[RemovalOrderInterrupted], tuple[RemovalOrder]]:
        return (type(self), (self.order,))


@keywords({"part": "parts"}, gone={"allow": ALLOW})
def removal_order(
    scene: Scene,
    parts: PartsLike,
    tool: Tool | None = None,
    start: PoseLike | None = None,
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
    rounds: int | None = None,
    executor: Executor | None = None,
) -> RemovalOrder:
    """The parts to remove before these come out, in the fewest steps, and the way of each.

    Arguments as of `feeler.removal`; `parts` come out together, with the tool; those that go before go without it.

    - Parts that block each other leave together in one step if none comes out alone.
    - Fasteners leave before the parts that they join (`find_fasteners`), unless they are kept or do not come out.
    - `keep`: parts that must stay, as `Parts.select` takes them. Of an assembly, the wanted parts in it do leave.
    - `seconds`: in total. Without `rounds` the search ends earlier only if it finds an order.
    - `rounds`: the most rounds of each attempt with pushes and random trees, instead of a share of the time. The search
      ends when no attempt of that many helps. An order that `seconds` did not cut (`is_out_of_time`) is the same on
      every machine.
    - `executor`: where attempts that do not depend on each other are made, as in `removals`, one thread each. The order
      does not depend on it, except where time cut it.
    - `progress`: called with the share of the time, 0 to 1, and the current attempt.

    The order is the shortest of those with straight motions. A part that none of these takes out is tried by pushes and
    random trees as well; so are `parts` before it is said that others have to go.

    Raises the errors of `feeler.removal`, and `OptionError` for wanted parts that `keep` names by
    themselves. Ctrl-C ends it with `RemovalOrderInterrupted`, which has the best attempt.
    """
    limit = check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True)
    check_progress(progress)
    check_whole("seed", seed, 0, LARGEST_SEED)
    allowed = Allowed.of(scene, ignore, overlap, seats)
    check_length("clearance", clearance)
    check_threads(threads)
    most = None if rounds is None else check_whole("rounds", rounds, 0, LARGEST_ROUNDS)
    check_executor(executor)
    if not isinstance(tool, (Tool, type(None))):
        raise MeshError(f"tool is a feeler.Tool that grips the parts, not {type(tool).__name__}")
    wanted = tuple(int(each) for each in scene.mockup.parts.select(parts))
    kept = frozenset[int]() if keep is None else frozenset(scene.mockup.parts.select(keep).tolist())
    if (part := _kept_for_itself(scene, wanted, keep)) is not None:
        path = scene.mockup.part_paths[part]
        raise OptionError(f"part {path!r} is wanted and kept: leave it out of parts or of keep")
    kept -= set(wanted)
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
    clock = Clock(limit, progress)
    with Crew(question, clock, executor) as crew:
        search = _Search(question, clock, most, crew)
        try:
            return search.order()
        except KeyboardInterrupt:
            steps = () if search.last is None else (RemovalStep(wanted, search.last),)
            raise RemovalOrderInterrupted(RemovalOrder(False, steps, clock.spent)) from None


def _kept_for_itself(scene: Scene, wanted: Sequence[int], keep: PartsLike | None) -> int | None:
    """A wanted part that an entry of `keep` names without others."""
    if keep is None:
        return None
    select = scene.mockup.parts.select
    entries = keep if isinstance(keep, (list, tuple)) else [keep] if isinstance(keep, str) else select(keep).tolist()
    for each in entries:
        chosen: set[int] = set(select([each]).tolist())
        if chosen and chosen.issubset(wanted):
            return min(chosen)
    return None


class _Search:
    """Plans from the blockers of straight motions, checks each step, and tries bent ways for stuck parts."""

    def __init__(self, question: Question, clock: Clock, rounds: int | None, crew: Crew) -> None:
        self.question, self.clock, self.rounds, self.crew = question, clock, rounds, crew
        self.graph = BlockingGraph(question, clock, crew.exits if crew.has_workers else None)
        self.ways: dict[tuple[int, ...], list[tuple[frozenset[int], Removal]]] = {}
        self.tries = 0
        self.last: Removal | None = None
        self.failed: dict[int, Removal] = {}
        """The last attempts of parts alone that found no way."""

    def order(self) -> RemovalOrder:
        """The order; if there is none, the best attempt of the wanted parts."""
        question, target = self.question, frozenset([TARGET])
        if int(question.scene.part_mask.sum()) == len(question.wanted):
            return self._ended(True, [RemovalStep(question.wanted, alone(int(question.options["seed"])))])
        in_place, is_cut = question.straight_way(self._least, self.clock)
        self.crew.is_cut = is_cut
        is_held = bool(self.graph.holding(TARGET))
        if in_place is not None and not is_held:
            return self._ended(True, [RemovalStep(question.wanted, in_place)])
        plan = self._plan()
        is_short = plan is not None and len(plan) == 1
        if not (is_short or is_held) and self._try_bent(self._attempt(target, frozenset(), 0)):
            plan = self._plan()
        passes = full_passes = 0
        while self.clock.goes_on():
            steps = None if plan is None else self._checked(plan)
            if steps is not None:
                return self._ended(True, steps)
            if plan is None:
                is_full = self.rounds is not None and self._budget(passes).rounds == self.rounds
                has_helped = self._try_what_is_stuck(passes)
                passes, full_passes = passes + 1, full_passes + is_full
                if is_full and (not has_helped or full_passes == MOST_FULL_PASSES):
                    break
            plan = self._plan()
        last = self.last
        if last is None:
            last = self.crew.way(Attempt(target, frozenset(), None, (self._least,)))
        self._note_failed(target, last)
        stuck, blockers = self._stopped()
        ended = self._ended(False, [RemovalStep(question.wanted, last)])
        return replace(ended, stuck=question.parts_of([stuck]), blocked_by=blockers)

    def _ended(self, found: bool, steps: list[RemovalStep]) -> RemovalOrder:
        is_cut = self.crew.is_cut or not self.clock.goes_on()
        return RemovalOrder(found, tuple(steps), self.clock.spent, is_cut)

    def _note_failed(self, nodes: frozenset[int], way: Removal) -> None:
        if len(nodes) == 1 and not way.is_found:
            self.failed[next(iter(nodes))] = way

    def _stopped(self) -> tuple[int, tuple[RemovalBlocker, ...]]:
        """From the wanted parts on to what stands in their way, and in the way of that, as far as it is known: the last
        one that could not leave, and its blockers but those that it blocks itself."""
        gone, node, seen = self.graph.most_gone(), TARGET, frozenset([TARGET])
        blockers = self._blockers_of(TARGET, gone, seen)
        while True:
            others = [self.question.node_of(each.part) for each in blockers]
            for deeper in others:
                if not {deeper} & (gone | self.question.kept):
                    more = self._blockers_of(deeper, gone, seen | {deeper})
                    if more:
                        break
            else:
                return node, blockers
            node, blockers, seen = deeper, more, seen | {deeper}

    def _blockers_of(self, node: int, gone: frozenset[int], seen: frozenset[int]) -> tuple[RemovalBlocker, ...]:
        """The blockers of parts as their last attempt met them, else as casts did, without some parts. Those that come
        out are left out, unless there are no others."""
        tried = self.failed.get(node)
        found = () if tried is None else tried.blocked_by
        if not found:
            known = self.graph.known_blockers(node).items()
            counted = [(part, count) for other, count in known for part in self.question.parts_of([other])]
            paths = self.question.scene.mockup.part_paths
            found = tuple(
                RemovalBlocker(part, paths[part], count, 0.0, np.eye(4))
                for part, count in sorted(counted, key=lambda each: (-each[1], each[0]))
            )
        found = tuple(each for each in found if self.question.node_of(each.part) not in seen)
        return tuple(each for each in found if each.part not in gone) or found

    def _plan(self) -> list[SequenceStep] | None:
        goes_on, count = self.clock.goes_on, self.question.node_count
        return shortest_sequence(TARGET, self.graph, count, goes_on, self.graph.expect)

    def _checked(self, plan: list[SequenceStep]) -> list[RemovalStep] | None:
        """The steps with their ways. If a step has none, the graph learns its blockers, and the result is empty."""
        before = [frozenset().union(*(step.parts for step in plan[:i])) for i in range(len(plan))]
        new = [
            self._step_attempt(step, gone)
            for step, gone in zip(plan, before, strict=True)
            if self._known_way(step, gone) is None
        ]
        self.crew.try_ahead(new, lambda way: not way.is_found)
        steps: list[RemovalStep] = []
        for step, gone in zip(plan, before, strict=True):
            way = self._way(step, gone)
            if way is None:
                return None
            steps.append(RemovalStep(self.question.parts_of(step.parts), way))
        return steps

    def _known_way(self, step: SequenceStep, gone: frozenset[int]) -> Removal | None:
        question = self.question
        parts = question.parts_of(step.parts)
        if int(question.scene.part_mask.sum()) == len(parts) + len(question.parts_of(gone)):
            return alone(int(question.options["seed"]))
        return next((way for before, way in self.ways.get(parts, []) if before == gone), None)

    def _step_attempt(self, step: SequenceStep, gone: frozenset[int]) -> Attempt:
        direction = step.motion if isinstance(step.motion, tuple) else None
        # The second budget: there was no time left for the direction itself, or the way is bent.
        return Attempt(step.parts, gone, direction, (self._least, self._budget(0)))

    def _way(self, step: SequenceStep, gone: frozenset[int]) -> Removal | None:
        known = self._known_way(step, gone)
        if known is not None:
            return known
        parts = self.question.parts_of(step.parts)
        way = self.crew.way(self._step_attempt(step, gone))
        if not way.is_found:
            # A way that was found with more parts removed is valid if it is free of those still there.
            held = next((way for before, way in self.ways.get(parts, []) if before <= gone), None)
            if held is None:
                self._note_failed(step.parts, way)
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

    def _try_what_is_stuck(self, passes: int) -> bool:
        """Pushes and trees for stuck parts, with all removable parts gone: first for the wanted parts, then for small
        ones, longer in each pass. Ends with the first success, which may make a plan possible."""
        gone = self.graph.most_gone()
        stuck = [frozenset([node]) for node in sorted(self.graph.reached(), key=self.question.size) if node not in gone]
        worst = [] if self.last is None else [self.question.node_of(each.part) for each in self.last.blocked_by[:2]]
        pairs = [frozenset([TARGET, node]) for node in worst if node not in self.question.kept and node not in gone]
        sure = [nodes for nodes in [*stuck, *pairs] if len(nodes) + len(gone) < self.question.node_count]
        attempts = [self._attempt(nodes, gone, passes, later) for later, nodes in enumerate(sure)]
        self.crew.try_ahead(attempts, lambda way: way.is_found)
        return any(self.clock.goes_on() and self._try_bent(attempt) for attempt in attempts)

    def _attempt(self, nodes: frozenset[int], gone: frozenset[int], passes: int, later: int = 0) -> Attempt:
        """A search by pushes and trees. `later`: how many others are tried before it."""
        return Attempt(nodes, gone, None, (self._budget(passes),), self.tries + later)

    def _try_bent(self, attempt: Attempt) -> bool:
        """Whether a way exists with some parts gone; the graph learns it, with those of them that it collides with."""
        question, nodes, gone = self.question, attempt.nodes, attempt.gone
        if len(nodes) + len(gone) >= question.node_count:
            return False
        way = self.crew.way(attempt)
        self.tries += 1
        if nodes == {TARGET}:
            self.last = way
        self._note_failed(nodes, way)
        if not way.is_found:
            return False
        met = frozenset(node for node in gone if self._is_met(nodes, node, way))
        self.ways.setdefault(question.parts_of(nodes), []).append((met, way))
        for node in nodes:
            self.graph.learn(node, Exit((self.tries,), met | nodes - {node}, self.graph.holding(node)))
        return True

    def _is_met(self, nodes: frozenset[int], other: int, way: Removal) -> bool:
        self.clock.look()
        return self.question.is_met(nodes, other, way.poses)

    @property
    def _least(self) -> Budget:
        return Budget(LEAST_TRY_S) if self.rounds is None else Budget(rounds=min(LEAST_TRY_ROUNDS, self.rounds))

    def _budget(self, passes: int) -> Budget:
        # Attempts that end at once, as where all parts are held, make thousands of passes in a second.
        grown = 2 ** min(passes, _MOST_DOUBLINGS)
        if self.rounds is None:
            return Budget(max(LEAST_TRY_S, TRY_SHARE * self.clock.seconds) * grown)
        first = max(LEAST_TRY_ROUNDS, math.ceil(TRY_SHARE * self.rounds))
        return Budget(rounds=min(self.rounds, first * grown))
