"""`task`: how parts are taken out: which fasteners, with which tools, in which order, and how long it takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_list, check_number, check_progress, check_threads, check_whole
from feeler.choices import TaskVerb
from feeler.errors import OptionError
from feeler.io.plausible import length_text
from feeler.parts import PartsLike
from feeler.plan.blocking import box_of_parts
from feeler.plan.fasteners import Fasteners, find_fasteners
from feeler.plan.question import TARGET
from feeler.plan.removal import LARGEST_SEED
from feeler.plan.sequence import Exit
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.spreading import check_executor
from feeler.tasks.actions import Actions
from feeler.tasks.ahead import Ahead
from feeler.tasks.answer import Task, TaskInterrupted
from feeler.tasks.beside import asks_beside
from feeler.tasks.crewed import Job, Slot, critical, scheduled
from feeler.tasks.fixings import Fixings
from feeler.tasks.forced import forced_order
from feeler.tasks.held_rows import Holds
from feeler.tasks.holding import holds
from feeler.tasks.leading import Leading, Led
from feeler.tasks.pacing import Pace
from feeler.tasks.plugs import plugs_in_the_way
from feeler.tasks.problem import Ordered, Unit
from feeler.tasks.reached import TaskTools, Tooled
from feeler.tasks.replanning import Found as Known
from feeler.tasks.replanning import Memory
from feeler.tasks.riding_rings import better, riding_rings
from feeler.tasks.search import Found, Search
from feeler.tasks.staying import Staying
from feeler.tasks.steps import TaskStep
from feeler.tasks.studs import with_wanted_studs
from feeler.tasks.times import Arithmetic, Timed, TimesLike, idle_patterns, strokes_for, times_of
from feeler.tasks.together import Together
from feeler.words import plural

Floats = npt.NDArray[np.float64]

MOST_AROUND = 40
"""Parts around one that is stuck whose ways out are looked for, before a bent way of it is searched."""
MOST_PLANS = 30
"""Plans whose ways are checked; each that fails teaches a blocker."""
MOST_PEOPLE = 100
MOST_NAMED = 3
"""Parts that ride along and are named."""
_FULL = (
    "The search ended at its limit of {:,} sets of parts, not of time: more seconds do not help. Ask for fewer parts "
    "at once, leave out of the scene what is off already, or say with keep what stays."
)
FOUND, HELD, READY, SEARCHED = 0.1, 0.2, 0.25, 0.85
"""Shares of the progress when fasteners are found, what they hold, what leaves together, and the order."""


def task(
    scene: Scene,
    parts: PartsLike,
    tools: TaskTools = None,
    times: TimesLike = None,
    keep: PartsLike | None = None,
    people: int = 1,
    *,
    fasteners: Fasteners | None = None,
    held: Holds | None = None,
    before: Sequence[tuple[PartsLike, PartsLike]] | None = None,
    seconds: float = 600.0,
    seed: int = 0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Task:
    """How parts are taken out: the quickest plan that was found, step by step, and what no plan is below.

    A state is what is out. In each state fasteners can be undone that a tool reaches and that come out along their
    axis, and parts can be taken out that nothing holds any more and that have a way out (`removal`). What stands in the
    way goes first; nothing else is touched.

    - `parts`: as `Parts.select` takes them; they come out together, with fasteners that join them alone. Wanted
      fasteners that hold them to others are undone before.
    - `tools`: a `Catalogue`, its TOML file, or "built-in"; or a `Tool` as `access` takes it, a list of them, or a dict
      of names; each may be a pair of the tool and a dict of options of `access`, such as `{"grip": "y"}`. None: their
      reach is not checked.
    - `times`: `Times`, its TOML file, or a dict of its elements. None: the built-in figures, which are examples.
    - `keep`: parts that stay, as `Parts.select` takes them.
    - `people`: who can work at once. Steps that look at other parts can be done at the same time.
    - `fasteners`, `held`: what `find_fasteners` and `holds` found, if you have it or know better.
    - `before`: pairs of parts: of a plan that takes both out, the first goes before the second. `bound` does not count
      these.
    - `seconds`: the search ends then. The plan depends neither on it, unless it ended it (`is_complete`), nor on
      `threads`.
    - `executor`: where questions that do not depend on each other are asked, as in `removals`, one thread each. The
      plan does not depend on it.
    - `progress`: called with the share of the work that is done, as far as it is known, or of the time if that is more,
      0 to 1, and what is done. It never goes back.

    Raises `OptionError` for parts that are not there, for all parts of the scene, and for numbers out of range,
    `MeshError` for other objects as tools, `LoadError` for a bad file of times. Ctrl-C ends the search with
    `TaskInterrupted`, which has the best plan until then.
    """
    given = locals()
    return planned(Memory(), **given)


def planned(
    memory: Memory,
    scene: Scene,
    parts: PartsLike,
    tools: TaskTools = None,
    times: TimesLike = None,
    keep: PartsLike | None = None,
    people: int = 1,
    *,
    fasteners: Fasteners | None = None,
    held: Holds | None = None,
    before: Sequence[tuple[PartsLike, PartsLike]] | None = None,
    seconds: float = 600.0,
    seed: int = 0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Task:
    """As `task`, with what earlier plans found. Fasteners that are given are those of these plans, too."""
    check_kind("scene", scene, Scene)
    limit = check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True)
    crew = check_whole("people", people, 1, MOST_PEOPLE)
    check_whole("seed", seed, 0, LARGEST_SEED)
    workers = check_threads(threads)
    check_progress(progress)
    check_executor(executor)
    table = Arithmetic(times_of(times))
    pairs = check_list("before", [] if before is None else before, "a list of pairs of parts")
    wanted = _wanted(scene, parts)
    kept = frozenset[int]() if keep is None else frozenset(scene.mockup.parts.select(keep).tolist())
    if kept & set(wanted):
        path = scene.mockup.part_paths[min(kept & set(wanted))]
        raise OptionError(f"keep has {path!r}, which is wanted: leave it out of one of them")
    reaching = memory.reaching(scene, tools, workers, table.times.pitches_mm)
    clock = Pace(limit, progress)

    @cache
    def looked() -> tuple[Fasteners, Holds]:
        clock.stage(FOUND, "looking for fasteners")
        rows = find_fasteners(scene, None, clock.heard) if fasteners is None else fasteners
        check_kind("fasteners", rows, Fasteners, "the result of feeler.find_fasteners")
        clock.stage(HELD, "looking at what they hold")
        joined = holds(scene, rows, progress=clock.heard) if held is None else held
        check_kind("held", joined, Holds, "the result of feeler.holds")
        return with_wanted_studs(scene, rows, joined, wanted)

    def plan(
        stays: frozenset[int],
        riding: frozenset[int],
        loose: frozenset[int],
        gives_up: Callable[[frozenset[int]], bool],
    ) -> tuple[Task, _Planner]:
        """The answer if circlips in `riding` leave with their part, plugs in `loose` do not, and `stays` is kept."""

        def look() -> Known:
            rows, joined = looked()
            fixings = Fixings(scene, rows, joined, table, loose, riding)
            clock.stage(READY, "looking at what leaves together")
            return Known(fixings, _question(scene, wanted, stays, fixings, seed, workers))

        known = memory.found((wanted, stays, seed, loose, riding), scene, look)
        forced = forced_order(scene, pairs, known.question)
        with Ahead(scene, reaching, clock, executor, known.ways) as ahead:
            actions = Actions(known.question, clock, known.fixings, reaching, table, ahead)
            if known.actions is not None:
                actions.know(known.actions)
            known.actions = actions
            leading = Leading(actions, clock, crew == 1, known.searched)
            planner = _Planner(actions, leading, clock, crew, paths, forced, gives_up)
            return planner.task(), planner

    def best(riding: frozenset[int], stays: frozenset[int] = kept) -> tuple[Task, _Planner]:
        """The answer. A set screw may be in the way of its own part: it is undone if no straight way takes both out,
        before bent ones are searched."""
        answer, planner = plan(stays, riding, frozenset(), bool)
        loose = frozenset[int]()
        while planner.plugs and not answer.is_found and clock.goes_on():
            loose |= planner.plugs
            answer, planner = plan(stays, riding, loose, lambda _: True)
        for some in [frozenset[int](), loose] if loose else []:
            if not answer.is_found and clock.goes_on():
                answer, planner = plan(stays, riding, some, lambda _: False)
        return answer, planner

    paths = tuple(scene.mockup.part_paths[part] for part in wanted)
    answer, planner = best(frozenset())
    around = planner.carriers(answer)
    if around and clock.goes_on():
        # It would leave in a larger part, as a key in its shaft, and not be out of that.
        try:
            alone, other = best(frozenset(), kept | around)
        except TaskInterrupted:
            raise TaskInterrupted(answer) from None
        if alone.is_found:
            answer, planner = replace(alone, bound=min(answer.bound, alone.bound)), other
        else:
            named = ", ".join(repr(scene.mockup.part_paths[part]) for part in sorted(around)[:MOST_NAMED])
            said = f"{', '.join(map(repr, paths[:MOST_NAMED]))} leaves together with {named}: take it out of that."
            answer = replace(answer, notes=(said, *answer.notes))
    if pairs:
        return answer  # it may be about circlips
    for riding in riding_rings(scene, planner.actions.fixings.held, answer, wanted, kept, planner.stuck):
        if clock.goes_on():
            try:
                answer = better(answer, best(riding)[0])
            except TaskInterrupted as stopped:
                raise (TaskInterrupted(answer) if answer.is_found else stopped) from None
    return answer


def _wanted(scene: Scene, parts: PartsLike) -> tuple[int, ...]:
    wanted = tuple(int(part) for part in scene.mockup.parts.select(parts))
    if not wanted:
        raise OptionError("parts names no part: name one at least")
    away = [part for part in wanted if not scene.part_mask[part]]
    if away:
        raise OptionError(f"part {scene.mockup.part_paths[away[0]]!r} is not in the scene: it is out already")
    if int(scene.part_mask.sum()) == len(wanted):
        raise OptionError(f"parts names all {plural(len(wanted), 'part')} of the scene: leave at least one out of it")
    return wanted


def _question(
    scene: Scene, wanted: tuple[int, ...], kept: frozenset[int], fixings: Fixings, seed: int, threads: int | None
) -> Together:
    """What leaves with what. Wanted fasteners are undone, unless they join wanted parts to each other; studs in other
    parts stay there."""
    under = {washer: part for part in fixings if scene.part_mask[part] for washer in fixings.washers(part)}
    bodies = [body for body in fixings.bodies if not (set(body) & kept and set(body) & set(wanted))]
    under |= {part: body[0] for body in bodies for part in body[1:]}
    kept = kept.union(*(body for body in bodies if set(body) & kept))
    wanted = tuple(dict.fromkeys(under.get(part, part) for part in wanted))  # washers come off with what clamps them
    own = {part for part in wanted if part not in fixings and fixings.studs.get(part, part) in (part, *wanted)}
    whole = own.union(*(body for body in bodies if body[0] in own))
    inner = {part for part in fixings if set(fixings.joins(part)) <= whole and fixings.joins(part)} - fixings.loose
    undone = tuple(part for part in wanted if part in fixings and part not in inner | fixings.riding)
    riders: dict[int, list[int]] = {body[0]: list(body[1:]) for body in bodies}
    lead: dict[int, int] = {part: body[0] for body in bodies for part in body[1:]}
    for part in (each for each in fixings if scene.part_mask[each]):
        for washer in (each for each in fixings.washers(part) if each not in kept):
            riders.setdefault(part, []).append(washer)
            lead[washer] = part
        if part in kept:
            continue
        pipe, anchor = fixings.captive_on(part), fixings.anchor(part)
        if part in fixings.riding and anchor is not None:
            pipe = anchor
        if pipe is not None:
            riders.setdefault(pipe, []).append(part)
            lead[part] = pipe
        elif part in inner:
            riders.setdefault(min(own), []).append(part)
        elif fixings.is_plug(part) and anchor is not None:
            riders.setdefault(anchor, []).append(part)
    for stud, anchor in fixings.studs.items():
        if stud not in kept:
            riders.setdefault(anchor, []).append(stud)
            lead[stud] = anchor
    options = {"ignore": [], "overlap": 0.0, "seats": True, "clearance": 0.0, "seed": seed, "threads": threads}
    grip = {"tool": None, "start": None, "directions": None}
    all_riders = {part: _all_riders(part, riders) for part in riders}
    lead = {part: lead.get(leader, leader) for part, leader in lead.items()}
    wanted_own = tuple(sorted(own - set(undone)))
    return Together(scene, wanted_own, kept, grip, options, all_riders, lead, undone)


def _all_riders(part: int, riders: Mapping[int, list[int]]) -> tuple[int, ...]:
    """Those of a part, those of these, and so on."""
    found: list[int] = []
    waiting = list(riders[part])
    while waiting:
        each = waiting.pop(0)
        if each not in found and each != part:
            found.append(each)
            waiting += riders.get(each, [])
    return tuple(found)


@dataclass(frozen=True, eq=False)  # it holds an array
class _Checked:
    """A step with its way."""

    ordered: Ordered
    parts: tuple[int, ...]
    way: Floats
    looked: frozenset[int]
    because: str


def _others(sets: Sequence[frozenset[int]], n: int) -> list[frozenset[int]]:
    """All but the n-th."""
    return [each for m, each in enumerate(sets) if m != n]


class _Planner:
    """Searches plans, and checks the ways of their steps."""

    def __init__(
        self,
        actions: Actions,
        leading: Leading,
        clock: Pace,
        people: int,
        wanted: tuple[str, ...],
        forced: Mapping[int, frozenset[int]],
        gives_up: Callable[[frozenset[int]], bool],
    ) -> None:
        """gives_up: whether no bent ways are searched, by the plugs that may be in the way of their own parts."""
        self.gives_up, self.plugs = gives_up, frozenset[int]()
        self.stuck: tuple[int, ...] = ()
        """The parts that nothing frees, and what would leave with them."""
        self.actions, self.clock, self.people, self.wanted, self.forced = actions, clock, people, wanted, forced
        self.question = actions.question
        self.mockup = self.question.scene.mockup
        self.leading = leading
        self._search: Search | None = None

    @property
    def search(self) -> Search:
        """The last search."""
        assert self._search is not None
        return self._search

    def carriers(self, answer: Task) -> frozenset[int]:
        """The parts larger than the wanted ones that leave together with these in an answer."""
        if not answer.is_found or not self.question.wanted:
            return frozenset()
        others = set(answer.steps[-1].parts) - set(self.question.parts_of([TARGET]))
        return frozenset(part for part in others if self.actions.is_smaller(TARGET, part))

    def task(self) -> Task:
        """The best plan whose ways hold. Raises `TaskInterrupted` at Ctrl-C."""
        try:
            answer = self._best()
        except KeyboardInterrupt:
            raise TaskInterrupted(self._so_far("Interrupted")) from None
        self.clock.stage(1.0, "done")
        self.clock.within(1.0)
        self.clock.tell("done")
        return answer

    def _best(self) -> Task:
        self.clock.stage(SEARCHED, "searching the quickest order")
        found = self._found(self.clock.within)
        for _ in range(MOST_PLANS):
            if found.steps is None:
                self.stuck = self.question.parts_of([*found.stuck, *self._riders(found.stuck)])
                self.plugs = plugs_in_the_way(self.question.scene, self.actions.fixings, self.stuck)
                if self.gives_up(self.plugs) or not (found.is_complete and self._try_bent(found)):
                    break
            else:
                is_new = self._asks_before(found.steps) or self._frees_riders(found) or self._asks_beside(found)
                checked = None if is_new else self._checked(found.steps)
                if checked is not None:
                    return self._answer(found, checked)
            if not self.clock.goes_on():
                break
            found = self._found()
        if found.steps is None:
            return self._blocked(found)
        is_late = not self.clock.goes_on()
        return self._so_far("The time was up" if is_late else f"The ways of {MOST_PLANS} plans did not hold, its limit")

    def _riders(self, items: Iterable[int]) -> frozenset[int]:
        """What can ride on parts."""
        parts = [item for item in items if not self.actions.is_turned(item)]
        return frozenset[int]().union(*map(self.actions.riding, parts))

    def _found(self, told: Callable[[float], None] = lambda share: None) -> Found:
        self.clock.tell("searching the quickest order")
        self._search = Search(self.actions, TARGET, self.clock.goes_on, self.forced, told)
        return self._search.best()

    def _checked(self, steps: tuple[Ordered, ...]) -> list[_Checked] | None:
        """The steps with their ways; None if one does not hold, and then its blockers are known."""
        out: frozenset[int] = frozenset()
        checked, asked = [], []
        self.clock.stage(1.0, "checking the ways")
        if self.actions.ahead.has_workers:
            for step in steps:
                if not self.actions.is_turned(step.unit.items[0]):
                    asked.append(self.leading.asked(step.unit, self._left(step, out), out))
                out |= self._leaving(step.unit, out)
            self.actions.ahead.try_ways([each for each in asked if each is not None])
        out = frozenset()
        for n, step in enumerate(steps):
            self.clock.within(n / len(steps))
            one = self._checked_step(step, out)
            if one is None:
                return None
            if one.parts:
                checked.append(one)
            out |= self._leaving(step.unit, out)
        return checked

    def _checked_step(self, step: Ordered, out: frozenset[int]) -> _Checked | None:
        """A step with its way; None if none was found."""
        actions, item = self.actions, step.unit.items[0]
        gone = actions.gone(out)
        parts = self._left(step, out)
        if actions.is_turned(item):
            fixing = actions.fixings.of(item)
            way = np.stack([np.eye(4), actions.drawn(fixing)])
            looked = actions.looked([item], way) - gone
            tooled = step.choice.key
            said = "loose: what it was fastened with is undone"
            if isinstance(tooled, Tooled):
                looked |= actions.reaching.near(fixing.row) if fixing.row is not None else frozenset()
                said = tooled.because
            return _Checked(step, parts, way, looked - set(parts), f"{fixing.hold.because}; {said}")
        if not parts:
            return _Checked(step, (), np.eye(4)[None], frozenset(), "")
        found = self.leading.way(step.unit, parts, out)
        if not found.is_found:
            if self.clock.goes_on():
                self._learn(step, found)
            return None
        looked = actions.looked(step.unit.leaving, found.poses)
        return _Checked(step, parts, found.poses, looked, found.said + self._carried(step.unit))

    def _carried(self, unit: Unit) -> str:
        """What stays on the parts of a step, in words."""
        names = [self.mockup.part_names[each] for each in unit.riding if each not in self.actions.fixings]
        if not names:
            return ""
        first, more = ", ".join(names[:MOST_NAMED]), len(names) - MOST_NAMED
        return f"; {first}{f' and {more} more' if more > 0 else ''} {'stay' if len(names) > 1 else 'stays'} on it"

    def _left(self, step: Ordered, out: frozenset[int]) -> tuple[int, ...]:
        """The parts that leave in a step."""
        gone = self.actions.gone(out)
        return tuple(part for part in self.question.parts_of(self._leaving(step.unit, out)) if part not in gone)

    def _leaving(self, unit: Unit, out: frozenset[int]) -> frozenset[int]:
        """The items that leave in a step: with a rod the nut at its other end, if it was drawn from between them."""
        nuts = [self.actions.fixings.nuts.get(part, frozenset()) for part in self.question.parts_of(unit.leaving)]
        left = frozenset[int]().union(*(each - out for each in nuts if each & out))
        return frozenset(unit.leaving) | (left - self.question.kept)

    def _learn(self, step: Ordered, tried: Led) -> None:
        """A motion that does not hold has more blockers than casts along it met."""
        graph, question = self.actions.graph, self.question
        items = set(step.unit.leaving)
        more = None if tried.worst is None else question.node_of(tried.worst)
        for item, riding in zip(step.unit.items, step.unit.bodies, strict=True):
            node = self.actions.node(item, riding)
            for one in graph.forget(node, step.unit.motion):
                if more is not None and more not in items | question.kept | {TARGET}:
                    graph.learn(node, Exit(one.motions, one.blockers | {more}, one.fasteners))

    def _try_bent(self, found: Found, is_wide: bool = True) -> bool:
        """Pushes and random trees for parts that no straight motion takes out, with all gone that is known to leave.
        is_wide: how what stands around them comes out is looked for."""
        question = self.question
        stuck = [item for item in found.stuck if not (self.actions.is_turned(item) or item in question.kept)]
        for item in sorted((item for item in stuck if all(self.actions.certain(item))), key=question.size):
            if item == TARGET and not question.wanted:
                continue
            for riding in self._bodies(item):
                if any(
                    self.leading.search(item, riding, gone - {TARGET, item})
                    for gone in self._gone(item, riding, is_wide)
                ):
                    return True
        return False

    def _gone(self, item: int, riding: frozenset[int], is_wide: bool) -> Iterator[frozenset[int]]:
        """What may be out when a bent way of a part is searched: few items first, since a way that avoids the others
        needs none of them undone."""
        graph, node = self.actions.graph, self.actions.node(item, riding)
        off = self.actions.riding(item) - riding
        yield graph.most_gone() | graph.holding(node) | off
        if not is_wide:
            return
        fasteners = self._look_around(node)
        gone = graph.most_gone() | off
        gone |= graph.holding(node).union(*map(graph.holding, gone)) - riding
        yield gone
        yield gone | fasteners

    def _look_around(self, node: int) -> frozenset[int]:
        """Lets the graph know how what stands around a part comes out; the fasteners among it, which may be undone."""
        graph, actions = self.actions.graph, self.actions
        seen, fasteners, waiting = set[int](), set[int](), sorted(graph.obstacles(node))
        while waiting and len(seen) < MOST_AROUND and self.clock.goes_on():
            item = waiting.pop(0)
            if item in seen or item == TARGET or item in self.question.kept:
                continue
            seen.add(item)
            if actions.is_turned(item):
                fasteners.add(item)
                continue
            exits = graph.exits(item)
            more = frozenset[int]().union(*(one.blockers for one in exits)) if exits else graph.obstacles(item)
            waiting += sorted(more - seen)
        return frozenset(fasteners)

    def _frees_riders(self, found: Found) -> bool:
        """Whether a way is found for something that only had to ride along since no straight motion takes it out."""
        has_riders = any(step.unit.riding for step in found.steps or ())
        return found.is_complete and has_riders and self._try_bent(found, is_wide=False)

    def _asks_beside(self, found: Found) -> bool:
        """Whether a part that the plan leaves in place has a bent way that the search did not know."""
        return found.steps is not None and asks_beside(self.actions, self.leading, found.steps, found.seconds)

    def _bodies(self, item: int) -> list[frozenset[int]]:
        """What rode on a part where its ways were looked for, and nothing."""
        return [*(riding for own, riding in self.question.bodies.values() if own == item), frozenset()]

    def _asks_before(self, steps: tuple[Ordered, ...]) -> bool:
        """Whether a part has a way without others that are out for it alone: `removal` is asked before it is said that
        these have to go."""
        actions, out = self.actions, frozenset[int]()
        needs = [self._needed(step.unit) for step in steps]
        held = [frozenset[int]().union(*step.unit.joints) for step in steps]
        sure = self.search.sure()
        for n, step in enumerate(steps):
            # Parts that leave together may come out alone: a bayonet is turned, which no straight motion is.
            is_joint = len(step.unit.items) > 1
            for item, riding in zip(step.unit.items, step.unit.bodies, strict=False):
                if actions.is_turned(item):
                    continue
                needed = step.unit.before
                if is_joint:
                    needed = needs[n].difference(*actions.holders(item, riding))
                alone = needed - sure.union(*_others(needs, n))
                if is_joint:
                    is_loose = self._is_loose(item, riding, out - alone)
                else:
                    is_loose = bool(alone) and self.leading.has_play(item, riding, out - alone)
                if is_loose and self.leading.search(item, riding, out - alone):
                    return True
                # What is in the way of several parts may be in the way of none, and a part may come out below one once
                # another is out. A long search for each would be too much.
                some = needed - sure.union(*_others(held, n))
                for less in [some, *(frozenset([each]) for each in sorted(some))]:
                    is_loose = bool(less) and self.leading.has_play(item, riding, out - less)
                    if is_loose and self.leading.search(item, riding, out - less, is_short=True):
                        return True
            if self._asks_riders(step.unit, out):
                return True
            out |= self._leaving(step.unit, out)
        return False

    def _asks_riders(self, unit: Unit, out: frozenset[int]) -> bool:
        """Whether something that rides along has a way of its own without what is in its way, by two straight legs: it
        could be undone before."""
        actions, graph = self.actions, self.actions.graph
        for item in sorted(unit.riding):
            blockers = [one.blockers for one in graph.known(item)]
            if item in actions.fixings or not blockers:
                continue
            before = out | graph.holding(item)
            for less in sorted(map(sorted, blockers)):
                gone = before - frozenset(less)
                is_loose = self.leading.has_play(item, frozenset(), gone)
                if is_loose and self.leading.search(item, frozenset(), gone, is_short=True):
                    return True
        return False

    def _answer(self, found: Found, checked: list[_Checked]) -> Task:
        timed = [self._timed(one) for one in checked]
        after = self._after(checked)
        jobs = [
            Job(one.ordered.choice.tool, each.mean, before)
            for one, each, before in zip(checked, timed, after, strict=True)
        ]
        slots = scheduled(jobs, self.actions.get_seconds, self.people)
        steps = tuple(self._step(n, checked[n], timed[n], after[n], slots[n]) for n in range(len(checked)))
        chain = [steps[n] for n in critical(slots)]
        spent = max((slot.end for slot in slots), default=0.0)
        bound = found.bound if self.people == 1 else max(found.bound / self.people, self.search.longest())
        notes = []
        if self.actions.fixings.is_empty:
            low, high = box_of_parts(self.actions.question.scene)
            size = length_text(float((high - low).max()))
            notes.append(f"No part looks like a fastener, so nothing is undone. Is the unit right? All is {size} long.")
        left = {path for step in steps for path in step.paths}
        stay = [self.mockup.part_paths[stud] for stud in self.actions.fixings.studs]
        stay = [path for path in stay if path in self.wanted and path not in left]
        if stay:
            notes.append(f"Studs stay in their parts: {', '.join(map(repr, stay[:MOST_NAMED]))}.")
        if not self.actions.reaching.is_checked:
            notes.append("No tools were given: that a tool reaches each fastener was not checked.")
        if self.actions.times.times.examples:
            notes.append(f"Example figures, not measured: {', '.join(self.actions.times.times.examples)}.")
        idle = idle_patterns(self.actions.times.times, self.actions.question.scene.mockup.part_paths)
        if idle:
            notes.append(f"Patterns of the times that match no part: {', '.join(map(repr, idle))}.")
        return Task(
            parts=self.wanted,
            is_found=True,
            steps=steps,
            seconds=spent,
            spread=math.sqrt(math.fsum(step.spread**2 for step in chain)),
            bound=min(bound, spent),
            blocked=(),
            people=self.people,
            is_complete=found.is_complete,
            elements=dict(self.actions.times.elements),
            examples=self.actions.times.times.examples,
            notes=tuple(notes),
        )

    def _so_far(self, because: str) -> Task:
        """The best plan until now. Nothing is asked of the geometry any more, so its ways are not checked. because: why
        it ends."""
        found = Found(None, math.nan, 0.0, False, {}) if self._search is None else self._search.so_far
        out: frozenset[int] = frozenset()
        steps: list[TaskStep] = []
        now = 0.0
        for ordered in found.steps or ():
            parts = self._left(ordered, out)
            out |= self._leaving(ordered.unit, out)
            if not parts:
                continue
            tooled = ordered.choice.key
            said = tooled.because if isinstance(tooled, Tooled) else "its way is not checked"
            one = _Checked(ordered, parts, np.empty((0, 4, 4)), frozenset(), said)
            timed, number = self._timed(one), len(steps)
            end = now + timed.mean + self.actions.get_seconds * ordered.is_changed
            slot = Slot(0, now, end, ordered.is_changed, None)
            steps.append(self._step(number, one, timed, tuple(range(number)), slot))
            now = end
        return Task(
            parts=self.wanted,
            is_found=False,
            steps=tuple(steps),
            seconds=now if steps else math.nan,
            spread=math.sqrt(math.fsum(step.spread**2 for step in steps)) if steps else math.nan,
            bound=found.bound / self.people,
            blocked=(),
            people=self.people,
            is_complete=False,
            elements=dict(self.actions.times.elements),
            examples=self.actions.times.times.examples,
            notes=(f"{because}: nothing says that the ways of these steps hold.",) if steps else (),
        )

    def _timed(self, one: _Checked) -> Timed:
        items, tooled = one.ordered.unit.items, one.ordered.choice.key
        return self.actions.undone(items[0], tooled) if isinstance(tooled, Tooled) else self.actions.taken(items)

    def _after(self, checked: list[_Checked]) -> list[tuple[int, ...]]:
        """Of each step those before it that it depends on."""
        found = []
        for n, one in enumerate(checked):
            needed = self._needed(one.ordered.unit)
            if isinstance(one.ordered.choice.key, Tooled):
                after = self._with_room(checked, n, needed)
            else:
                is_known = self.actions.is_turned(one.ordered.unit.items[0]) or self._is_along(one)
                looked = frozenset[int]() if is_known else one.looked | set(one.parts)
                after = [
                    m
                    for m, other in enumerate(checked[:n])
                    if set(other.ordered.unit.leaving) & needed or set(other.parts) & looked
                ]
            found.append(tuple(after))
        return found

    def _with_room(self, checked: list[_Checked], n: int, needed: frozenset[int]) -> list[int]:
        """The steps before one that gives its tool its room: without any other it is done as quickly."""
        actions, choice, item = self.actions, checked[n].ordered.choice, checked[n].ordered.unit.items[0]
        after = list(range(n))
        for m in reversed(range(n)):
            if set(checked[m].ordered.unit.leaving) & needed:
                continue
            fewer = [each for each in after if each != m]
            out = frozenset(each for k in fewer for each in checked[k].ordered.unit.leaving)
            if any((each.tool, each.seconds) == choice[:2] for each in actions.tooled(item, out)[0]):
                after = fewer
        return after

    def _is_loose(self, item: int, riding: frozenset[int], out: frozenset[int]) -> bool:
        """Whether a part can be moved or turned a little while items are out."""
        return self.leading.has_play(item, riding, out) or self.leading.can_turn(item, riding, out)

    def _needed(self, unit: Unit) -> frozenset[int]:
        """The items that have to be out for a step: those that hold it, and those in the way of its motion."""
        actions = self.actions
        joints = frozenset[int]().union(*unit.joints)
        mates = actions.mates(unit.items[0]) if actions.is_turned(unit.items[0]) else frozenset[int]()
        return joints | mates | unit.before

    @staticmethod
    def _is_along(one: _Checked) -> bool:
        """Whether the way is the straight motion whose blockers are known."""
        motion = one.ordered.unit.motion
        if not (isinstance(motion, tuple) and len(motion) == 3 and len(one.way) == 2):
            return False
        step = one.way[1][:3, 3]
        is_turning = not np.allclose(one.way[1][:3, :3], np.eye(3))
        return not is_turning and float(step @ np.array(motion)) >= (1.0 - 1e-9) * float(np.linalg.norm(step))

    def _step(self, number: int, one: _Checked, timed: Timed, after: tuple[int, ...], slot: Slot) -> TaskStep:
        actions, item = self.actions, one.ordered.unit.items[0]
        tooled = one.ordered.choice.key
        verb: TaskVerb = "take out"
        strokes, swing, tool_way = 0, math.nan, np.empty((0, 4, 4))
        if isinstance(tooled, Tooled):
            verb = "disconnect" if actions.is_captive(item) else "undo"
            swing, tool_way = tooled.swing_deg, tooled.way
            strokes = strokes_for(actions.fixings.of(item).turns.count, tooled.stroke_deg)
        get = actions.times.elements["get"]
        variance = timed.spread**2 + (get.spread**2 if slot.is_changed else 0.0)
        first = item if item != TARGET else next(part for part in one.parts if self._is_wanted(part))
        said = timed.arithmetic + (f"; get {one.ordered.choice.tool}: {get.mean:g} s" if slot.is_changed else "")
        return TaskStep(
            number=number,
            verb=verb,
            part=self.mockup.part_paths[first],
            parts=one.parts,
            paths=tuple(self.mockup.part_paths[part] for part in one.parts),
            tool=one.ordered.choice.tool,
            swing_deg=swing,
            strokes=strokes,
            way=one.way,
            tool_way=tool_way,
            person=slot.person,
            start=slot.start,
            seconds=slot.end - slot.start,
            spread=math.sqrt(variance),
            after=after,
            looked=tuple(sorted(one.looked)),
            because=one.because,
            arithmetic=said,
        )

    def _is_wanted(self, part: int) -> bool:
        """Whether a part is wanted, or leaves with the wanted ones in any case."""
        return part in self.question.parts_of([TARGET])

    def _blocked(self, found: Found) -> Task:
        staying = Staying(self.actions, self.wanted, self.forced, found.stuck)
        rows = [staying.blocker(item) for item in found.stuck] or [staying.in_its_way()]
        is_complete = found.is_complete and self.clock.goes_on()
        notes: tuple[str, ...] = ()
        if found.is_full:
            notes = (_FULL.format(self.search.sets),)
        elif not is_complete:
            notes = ("The time was up before the search ended: give it more seconds.",)
        if self.forced:
            notes += ("An order was forced: there may be a plan without it.",)
        nan = math.nan
        # Without a straight plan there may be one of bent ways that was not searched.
        bound = nan if is_complete else (found.bound if math.isfinite(found.bound) else 0.0) / self.people
        elements, examples = dict(self.actions.times.elements), self.actions.times.times.examples
        return Task(
            *(self.wanted, False, (), nan, nan, bound, tuple(rows), self.people, is_complete, elements, examples),
            notes=notes,
        )
