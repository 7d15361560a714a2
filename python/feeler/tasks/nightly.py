"""`maintain`: how long it takes to take out each of a list of parts, and what changed since the last run."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import (
    check_array,
    check_kind,
    check_number,
    check_path,
    check_progress,
    check_threads,
    check_whole,
    shown,
)
from feeler.errors import FeelerError, OptionError
from feeler.plan.catalogue import catalogue
from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners
from feeler.plan.removal import LARGEST_SEED
from feeler.plan.sight import sight
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.spreading import Interrupted, check_executor, spread
from feeler.stopping import TaskStopped, check_stop
from feeler.tasks.answer import Task
from feeler.tasks.digests import digest_of, facts_of, short
from feeler.tasks.held_rows import Holds
from feeler.tasks.holding import holds
from feeler.tasks.listed import MaintainParts, Wanted, wanted_of
from feeler.tasks.memory import Answer, Memory, carried
from feeler.tasks.night_rows import Plan, Seeing
from feeler.tasks.planning import task
from feeler.tasks.reached import Reaching, TaskTools
from feeler.tasks.recognising import Names, Recognised, recognised, renamed, retimed
from feeler.tasks.regions import Regions, box_of
from feeler.tasks.run import Maintenance, MaintenanceInterrupted, load_maintenance
from feeler.tasks.snapshots import Changes, Seen, Snapshot, keys_of, parts_seen, scene_digest
from feeler.tasks.steps import clock
from feeler.tasks.stored_answers import StoredAnswers
from feeler.tasks.times import Times, TimesLike
from feeler.tasks.watched import Recall, WatchedScene

Floats = npt.NDArray[np.float64]

EYES = 32
EYE_M = 0.35
"""Without `eyes`: as many places of the eyes around each head, and how far from it they are, metres."""
LEAST_LEFT_S = 10.0
"""Shorter times that are left are not said."""
_UNREACHED = "no tool reaches it"
_VERSION = 5
"""Of what rows mean: a row of another version is not kept."""


def maintain(
    scene: Scene,
    parts: MaintainParts,
    *,
    tools: TaskTools = None,
    times: TimesLike = None,
    previous: Maintenance | str | os.PathLike[str] | None = None,
    eyes: npt.ArrayLike | None = None,
    seconds: float = 600.0,
    seed: int = 0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Maintenance:
    """`task` for each of a list of parts: a row each, compared with the last run.

    - `parts`: a list, each entry as `Parts.select` takes it or a dict of `part`, `keep` and `people`; or the name of a
      CSV file with these columns.
    - `tools`, `times`, `seconds`, `seed`: as of `task`, for each row.
    - `previous`: the last run, or the file that `Maintenance.save` wrote. It may be of a file with other paths: parts
      are recognised by path, else by shape and place; `hints` and `renamed` of the run say which.
    - `eyes`: places of the eyes, `(k, 3)`, metres, world; without them 32 around each head, 0.35 m from it.
    - `threads`: rows worked on at a time without an executor; default: all cores.
    - `executor`: where they are worked on, as of `removals`.

    A row is kept from the last run if its options are the same and no part bears on it that was added or removed, moved
    or changed its shape, or is held otherwise. Such a part bears on a row if its box, before or now, meets a region in
    which the search of the row asked anything, plans that it gave up included: the boxes of the moving parts and tools
    at each pose, along each cast up to what it hit, around each swing, and around each ray. A fastener also bears on
    rows that looked at what it newly holds; without tools, one with others on its axis, on rows that looked at what it
    holds or held. A row depends on the whole mock-up if it searched a bent way; all rows do if the box of all parts,
    its axes or the order of the parts are others. Rows that `seconds` ended are never kept. What is seen of a fastener
    is kept if no changed part meets the box around the eyes and it.

    Rows that are computed anew ask again only what looked at a change: answers of the last run are used where the same
    parts, unmoved, are where they looked; none if parts come in another order, or the box of all is another by several
    per cent. `save` writes them beside the run; `hints` says why they were not used.

    Ctrl-C raises `MaintenanceInterrupted` with the rows that are done. As `previous` of the next run they are not
    computed again, and its differences count from the run before.

    Raises `LoadError` for a bad CSV file, with its line, or a file that is no run; `OptionError` for a bad list, for
    parts that are not there, and if none of the parts of `previous` is recognised. What `task` raises for one row is
    its `error`.
    """
    check_kind("scene", scene, Scene)
    limit = check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True)
    check_whole("seed", seed, 0, LARGEST_SEED)
    count = check_threads(threads) or os.cpu_count() or 1
    pool = check_executor(executor)
    check_progress(progress)
    places = None if eyes is None else check_array("eyes", eyes, (None, 3))
    table = _table(times)
    wanted = wanted_of(scene, parts)
    tools = _tools(tools)
    Reaching(scene, tools, 1)  # it raises what is wrong with them
    before = _previous(previous)
    say = progress or (lambda _share, _stage: None)
    options = _digest(tools, table, limit, seed, places)
    is_here = pool is None or isinstance(pool, ThreadPoolExecutor)
    fixed = _Fixed(scene, say)
    night = _Night(scene, wanted, options, fixed, before, table, tools is None, is_here)
    if not night.jobs:
        return night.run({})
    asked = _Asked(tools, table, limit, seed, fixed.fasteners, fixed.held, places, night.memory)

    begin = time.monotonic()

    def heard(done: int, stage: str) -> None:
        say(done / max(1, len(night.jobs)), stage or _so_far(done, len(night.jobs), time.monotonic() - begin))

    own = None if pool is not None else ThreadPoolExecutor(count, thread_name_prefix="feeler-maintain")
    try:
        answers = dict(enumerate(spread(_answered, scene, asked, night.jobs, pool or own, heard)))
    except Interrupted as interrupted:
        raise MaintenanceInterrupted(night.run(interrupted.results)) from None
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)
    return night.run(answers)


def _so_far(done: int, count: int, seconds: float) -> str:
    """The rows that are done, and about how long the others take."""
    said = f"{done:,} of {count:,} rows"
    left = seconds * (count - done) / done if done else 0.0
    return f"{said}, about {clock(left)} left" if left >= LEAST_LEFT_S else said


def _table(times: Times | str | os.PathLike[str] | Mapping[str, Any] | None) -> Times:
    if isinstance(times, Times):
        return times
    if times is None or isinstance(times, Mapping):
        return Times(times)
    if isinstance(times, (str, os.PathLike)):
        return Times.load(check_path("times", times))
    raise OptionError(f"times is {shown(times)}: give feeler.Times, a TOML file, or a dict of elements")


def _tools(tools: TaskTools) -> TaskTools:
    """A file is read once, here: workers may be elsewhere, and rows depend on its content."""
    if not isinstance(tools, (str, os.PathLike)):
        return tools
    return catalogue(tools)


def _previous(given: Maintenance | str | os.PathLike[str] | None) -> Maintenance | None:
    if given is None or isinstance(given, Maintenance):
        return given
    if isinstance(given, (str, os.PathLike)):
        return load_maintenance(given)
    raise OptionError(f"previous is {shown(given)}: give a feeler.Maintenance, or the file that it wrote")


class _Fixed:
    """The fasteners of a scene and what they hold, found when they are asked for."""

    def __init__(self, scene: Scene, say: Progress) -> None:
        self._scene, self._say = scene, say
        self._parts: dict[str, Seen] | None = None

    @cached_property
    def fasteners(self) -> Fasteners:
        """All of them."""
        self._say(0.0, "looking for fasteners")
        return find_fasteners(self._scene)

    @cached_property
    def held(self) -> Holds:
        """What they hold."""
        fasteners = self.fasteners
        self._say(0.0, "looking at what they hold")
        return holds(self._scene, fasteners)

    @cached_property
    def digest(self) -> str:
        """Of the scene."""
        return scene_digest(self._scene)

    def parts(self, runs: Sequence[Maintenance], version: str) -> dict[str, Seen]:
        """The parts of the scene; those of a run that are as they were are not looked at again."""
        if self._parts is None:
            before = next((run.snapshot.parts for run in runs if run.options.get("version") == version), {})
            self._parts = parts_seen(self._scene, before.values())
        return self._parts

    def recognised(self, run: Maintenance, runs: Sequence[Maintenance], version: str) -> Recognised | None:
        """Which parts of a run these are; None if all are the same, in name, too."""
        if run.snapshot.scene == self.digest:
            return None
        return recognised(run.snapshot.parts, self.parts(runs, version))

    def snapshot(self, runs: Sequence[Maintenance], version: str) -> Snapshot:
        """That of the scene: that of a run where all is as it was, else a new one."""
        for run in runs:
            if run.snapshot.scene == self.digest and run.options.get("version") == version:
                return run.snapshot
        return Snapshot.of(self._scene, self.fasteners, self.held, self.parts(runs, version))


@dataclass(frozen=True, eq=False)  # it may hold an array
class _Asked:
    """What all rows share."""

    tools: TaskTools
    times: Times
    seconds: float
    seed: int
    fasteners: Fasteners
    held: Holds
    eyes: Floats | None
    memory: Memory


@dataclass(frozen=True)
class _Job:
    """One row: its whole plan, or what is seen of some fasteners of a plan that is kept."""

    number: int
    wanted: Wanted
    seeing: tuple[tuple[int, tuple[int, ...]], ...] | None
    """Fasteners, and the parts that are out before each."""
    answers: tuple[Answer, ...] = ()
    """For workers elsewhere: what this row asked in the last run."""


@dataclass(frozen=True)
class _Row:
    """What became of a job."""

    plan: Plan | None
    seen: list[Seeing]
    used: tuple[str, ...]
    """The names of the answers that it used."""
    new: tuple[Answer, ...]
    """Those of them that it computed."""


def _answered(scene: Scene, asked: _Asked, job: _Job) -> _Row:
    """The task of one row, in a worker."""
    keys = keys_of(scene.mockup)
    begin = time.monotonic()
    asked.memory.take(job.answers)
    recall = Recall(asked.memory, lambda: time.monotonic() - begin < asked.seconds)
    if job.seeing is not None:
        seen = _seen(WatchedScene.of(scene, recall), asked, keys, job.seeing)
        return _Row(None, seen, tuple(recall.used), tuple(recall.new))
    watched = WatchedScene.of(scene, recall)
    noted = watched.noted

    def heard(share: float, stage: str) -> None:
        watched.heard(share, stage)
        check_stop(share, stage)

    try:
        found = task(
            watched,
            list(job.wanted.parts),
            asked.tools,
            asked.times,
            list(job.wanted.keep) or None,
            job.wanted.people,
            fasteners=asked.fasteners,
            held=asked.held,
            seconds=asked.seconds,
            seed=asked.seed,
            threads=1,
            progress=heard,
        )
    except FeelerError as error:
        return _Row(Plan.failed(str(error)), [], tuple(recall.used), tuple(recall.new))
    except TaskStopped:
        raise
    except Exception as error:
        # A mistake of feeler's in one row must not lose the others of a night.
        said = f"a mistake of feeler, please report it ({type(error).__name__}: {error})"
        return _Row(Plan.failed(said), [], tuple(recall.used), tuple(recall.new))
    noted.is_on = True
    noted.ask(keys[part] for part in job.wanted.parts)
    is_cut = time.monotonic() - begin >= asked.seconds
    out = _out_before(found, asked.fasteners)
    plan = _plan(found, keys, noted.regions().coarse(), is_cut)
    seen = _seen(WatchedScene.of(scene, recall), asked, keys, out)
    return _Row(plan, seen, tuple(recall.used), tuple(recall.new))


def _out_before(found: Task, fasteners: Fasteners) -> tuple[tuple[int, tuple[int, ...]], ...]:
    """The fasteners that are undone, each with the parts that are out before."""
    known = {row.part for row in fasteners}
    gone: list[int] = []
    rows = []
    for step in found.steps:
        if step.verb in ("undo", "disconnect"):
            rows += [(part, tuple(gone)) for part in step.parts if part in known and step.part == _path(step, part)]
        if step.verb != "disconnect":
            gone += step.parts
    return tuple(rows)


def _path(step: Any, part: int) -> str:
    return str(dict(zip(step.parts, step.paths, strict=True))[part])


def _plan(found: Task, keys: Sequence[str], regions: Regions, is_cut: bool) -> Plan:
    swings = [step.swing_deg for step in found.steps if not math.isnan(step.swing_deg) and step.tool]
    looked = {keys[part] for step in found.steps for part in (*step.looked, *step.parts)}
    blocked = [each for each in found.blocked if each.because]
    return Plan(
        is_out=found.is_found,
        said=found.said,
        seconds=found.seconds if found.is_found else math.nan,
        low=found.low if found.is_found else math.nan,
        high=found.high if found.is_found else math.nan,
        steps=len(found.steps),
        undone=sum(step.verb in ("undo", "disconnect") for step in found.steps),
        tools=found.tools,
        reach_deg=min(swings, default=math.nan),
        is_unreachable=any(each.because.startswith(_UNREACHED) for each in blocked),
        blockers=tuple(dict.fromkeys(path for each in blocked for path in each.blockers)),
        looked=tuple(sorted(looked)),
        regions=regions,
        is_cut=is_cut,
        error="",
    )


def _seen(scene: Scene, asked: _Asked, keys: Sequence[str], out: Sequence[tuple[int, tuple[int, ...]]]) -> list[Seeing]:
    """What is seen of fasteners."""
    rows = {row.part: row for row in asked.fasteners}
    found = []
    for part, gone in out:
        check_stop()
        row = rows[part]
        places = eyes_over(row) if asked.eyes is None else asked.eyes
        there = scene.without(list(gone)) if gone else scene
        share = float(there._recalled("sight", [part], [*facts_of(row), places], partial(_share, there, row, places)))
        own = scene.mockup.part_bounds[2 * part : 2 * part + 2]
        lower, upper = np.minimum(places.min(axis=0), own[0]), np.maximum(places.max(axis=0), own[1])
        box = tuple(float(value) for value in (*lower, *upper))
        found.append(Seeing(keys[part], share, tuple(keys[each] for each in gone), box))
    return found


def _share(scene: Scene, row: Fastener, places: Floats) -> float:
    return sight(scene, Fasteners([row]), places)[0].share


def eyes_over(row: Fastener) -> Floats:
    """Places `(EYES, 3)` on the half sphere over a head, evenly (a Fibonacci lattice)."""
    number = np.arange(EYES) + 0.5
    height = number / EYES
    turn = np.pi * (1.0 + math.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - height * height)
    ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)
    return np.asarray(row.frame[:3, 3] + EYE_M * ways @ row.frame[:3, :3].T)


def _digest(tools: TaskTools, times: Times, seconds: float, seed: int, eyes: Floats | None) -> dict[str, str]:
    """What rows depend on beside the parts."""

    return {
        "version": f"{_VERSION} of {version('feeler')}",
        "tools": digest_of(tools),
        "times": short(times.to_toml().encode()),
        "search": repr((seconds, seed)),
        "eyes": "" if eyes is None else short(eyes.tobytes()),
    }


class _Night:
    """Which rows are computed, and the run that becomes of them."""

    def __init__(
        self,
        scene: Scene,
        wanted: Sequence[Wanted],
        options: Mapping[str, str],
        fixed: _Fixed,
        before: Maintenance | None,
        times: Times,
        is_bare: bool,
        is_here: bool,
    ) -> None:
        """is_bare: there are no tools. is_here: workers share the memory of this process. Raises `OptionError` if the
        run before is of another mock-up."""
        self._wanted, self._options = wanted, dict(options)
        self._keys = keys_of(scene.mockup)
        self._index = {key: part for part, key in enumerate(self._keys)}
        self._ids = _numbered([self._id(each) for each in wanted])
        base = before.base if before is not None and before.is_partial else before
        given = list({id(run): run for run in (before, base) if run is not None}.values())
        version = self._options["version"]
        found = [fixed.recognised(run, given, version) for run in given]
        paths: list[Names] = [{} if each is None else each.names for each in found]
        runs = [renamed(run, some) for run, some in zip(given, paths, strict=True)]
        self._names = {id(run): some for run, some in zip(runs, paths, strict=True)}
        self._base = runs[-1] if base is not None else None
        self._matched = found[-1] if base is not None else None
        """How the parts of the run that it is compared with were recognised."""
        self._retimed = retimed(times, self._matched.names) if self._matched is not None else frozenset[str]()
        self._snapshot = snapshot = fixed.snapshot(runs, version)
        self._changes = {
            id(run): Changes(run.snapshot, snapshot, is_bare, retimed(times, self._names[id(run)])) for run in runs
        }
        self._kept: dict[int, tuple[Plan, list[Seeing]]] = {}
        self.jobs: list[_Job] = []
        self._lower, self._upper = box_of(scene.mockup.part_bounds.reshape(-1, 2, 3))
        for number, each in enumerate(wanted):
            self._decide(number, each, runs)
        self.hints = [hint for run in runs if run.answers is None for hint in run.hints]
        self.hints += self._matched.hints if self._matched is not None else []
        self._used: dict[str, tuple[str, ...]] = {}
        is_same = len(runs) == 1 and not self.jobs and runs[0].snapshot == snapshot
        self._same = runs[0].answers if is_same else None
        self.memory = Memory(self._keys, snapshot)
        if not is_same:
            self._recall(runs)
        if not is_here:
            known = {answer.name: answer for answer in self.memory}
            for n, job in enumerate(self.jobs):
                names = self._used.get(self._ids[job.number], ())
                self.jobs[n] = replace(job, answers=tuple(known[name] for name in names if name in known))

    def _recall(self, runs: Sequence[Maintenance]) -> None:
        """Takes the answers of runs that can still hold."""
        for run in reversed(runs):
            if run.options.get("version") != self._options["version"] or run.answers is None:
                continue
            try:
                answers, rows = run.answers.read()
            except ValueError as error:
                self.hints.append(f"The answers of the last run are not used: {error}. Rows are computed in full.")
                continue
            self.memory.take(carried(answers, run.snapshot, self._snapshot, self._changes[id(run)]))
            self._used.update(rows)

    def _id(self, each: Wanted) -> str:
        return json.dumps(
            [sorted(self._keys[p] for p in each.parts), sorted(self._keys[p] for p in each.keep), each.people]
        )

    def _decide(self, number: int, each: Wanted, runs: Sequence[Maintenance]) -> None:
        for run in runs:
            known = run.plans.get(self._ids[number])
            if known is None or not self._is_kept(run, known[0]):
                continue
            changes = self._changes[id(run)]
            again = [seeing for seeing in known[1] if not self._is_seen_so(run, seeing, changes)]
            self._kept[number] = known
            if again:
                out = tuple((self._index[s.path], tuple(self._index[key] for key in s.out)) for s in again)
                self.jobs.append(_Job(number, each, out))
            return
        self.jobs.append(_Job(number, each, None))

    def _is_seen_so(self, run: Maintenance, seeing: Seeing, changes: Changes) -> bool:
        """Whether what is seen of a fastener is the same."""
        lower, upper = np.maximum(seeing.box[:3], self._lower), np.minimum(seeing.box[3:], self._upper)
        return run.options.get("eyes") == self._options["eyes"] and not changes.within(lower, upper)

    def _is_kept(self, run: Maintenance, plan: Plan) -> bool:
        is_same = all(run.options.get(name) == self._options[name] for name in ("version", "tools", "times", "search"))
        changes = self._changes[id(run)]
        is_borne_on = changes.is_beyond or bool(changes.bearing_on(plan.regions))
        return is_same and not plan.is_cut and not plan.error and not is_borne_on and not self._is_said_with(run, plan)

    def _is_said_with(self, run: Maintenance, plan: Plan) -> bool:
        """Whether a sentence of a row may have a path that is another one now: why a part is blocked is said so."""
        now = {*self._names[id(run)].values()}
        return not plan.is_out and not now.isdisjoint([*plan.looked, *plan.blockers, *plan.regions.asked])

    def run(self, answers: Mapping[int, _Row]) -> Maintenance:
        """The run, with the answers to some jobs."""
        found = {self.jobs[number].number: answer for number, answer in answers.items()}
        missing = {job.number for job in self.jobs} - found.keys()
        plans: dict[str, tuple[Plan, list[Seeing]]] = {}
        kept: set[str] = set()
        used = {name: self._used.get(name, ()) for name in self._ids}
        for number, name in enumerate(self._ids):
            row = found.get(number)
            if number in missing:
                continue
            if row is not None:
                self.memory.take(row.new)
                used[name] = row.used if row.plan is not None else (*used[name], *row.used)
            if row is not None and row.plan is not None:
                plans[name] = row.plan, row.seen
            else:
                own, old = self._kept[number]
                again = {each.path: each for each in (row.seen if row is not None else ())}
                plans[name] = own, [again.get(each.path, each) for each in old]
                kept.add(name)
        return Maintenance(
            names={self._ids[number]: each.name for number, each in enumerate(self._wanted)},
            paths={self._ids[n]: tuple(self._keys[p] for p in each.parts) for n, each in enumerate(self._wanted)},
            plans=plans,
            kept=frozenset(kept),
            options=self._options,
            snapshot=self._snapshot,
            base=self._base,
            is_partial=bool(missing),
            answers=self._answers(used),
            hints=self.hints,
            renamed={} if self._matched is None else self._matched.before,
            retimed=self._retimed,
        )

    def _answers(self, used: Mapping[str, Sequence[str]]) -> StoredAnswers | None:
        """Those that rows used, for the next run."""
        if self._same is not None:
            return self._same
        return StoredAnswers.of(list(self._snapshot.parts), self.memory, used)


def _numbered(names: Sequence[str]) -> list[str]:
    """Equal names, of rows that are listed twice, with their number."""
    count: dict[str, int] = {}
    found = []
    for name in names:
        count[name] = count.get(name, 0) + 1
        found.append(name if count[name] == 1 else f"{name} #{count[name]}")
    return found
