"""The measurement: the same poses for every engine, in passes, and the statistics.

In each round each engine runs one whole pass over the poses of the cell, in a changing order: as in a user's loop, an
engine's own index fills the caches. For each pose the least time over the rounds is kept, because the machine can only
add to it. Median, p95 and worst are over poses. Further rounds run for feeler and for those peers of which one will be
the best.
"""

from __future__ import annotations

import functools
import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from engines import Engine, Floats, Pairs

import feeler
from feeler.choices import PoseKind
from feeler.progress import bar
from feeler.samples.poses import sample_poses

US_PER_NS = 1e-3
WAY_M = 0.02  # of a cast
MORE_S = 3.0  # of further rounds of a cell, where these are allowed
CLOSE = 1.5  # times the best peer's figure: who is above that in median and in p95 will not be the best


@dataclass
class Times:
    """Microseconds of one engine, `(rounds, poses)`: wall clock, and CPU time of the calling thread."""

    wall: Floats
    cpu: Floats

    def figures(self) -> dict[str, Any]:
        """Median, p95, p99 and worst over poses of the least over rounds."""
        return {
            "wall_us": spread(self.wall.min(axis=0)),
            "cpu_us": spread(self.cpu.min(axis=0)),
            "worst_single_call_us": float(self.wall.max()),
            "rounds": len(self.wall),
        }


@dataclass
class Findings:
    """An engine's answers and counts at each pose, from a pass outside the clock."""

    pairs: list[Pairs] = field(default_factory=list)  # of collide
    answers: list[bool] = field(default_factory=list)  # of is_colliding
    values: list[float] = field(default_factory=list)  # of the others, what they said in one number
    stats: list[dict[str, int]] = field(default_factory=list)


def spread(per_pose: Floats) -> dict[str, float]:
    """Median, p95, p99, worst and mean."""
    median, p95, p99 = np.percentile(per_pose, [50, 95, 99])
    return {
        "median": float(median),
        "p95": float(p95),
        "p99": float(p99),
        "worst": float(per_pose.max()),
        "mean": float(per_pose.mean()),
    }


def find_poses(scene: feeler.Scene, tool: feeler.Tool, kind: PoseKind, count: int, seed: int = 0) -> Floats:
    """Poses of a kind; where they are rare, fewer than requested. Raises `OptionError` when not even one is found."""
    with bar(f"finding {kind} poses") as progress:
        while True:
            try:
                return sample_poses(scene, tool, kind, count, seed, progress=progress)
            except feeler.OptionError:
                if count == 1:
                    raise
                count = max(1, count // 4)


def ways(poses: Floats, seed: int = 0) -> Floats:
    """Straight motions from the poses, `(n, 2, 4, 4)`: each `WAY_M` long, in a random direction."""
    both = np.stack([poses, poses], axis=1)
    directions = np.random.default_rng(seed).normal(size=(len(poses), 3))
    both[:, 1, :3, 3] += WAY_M * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return both


def look(engines: Sequence[Engine], poses: Floats, query: str = "collide") -> dict[str, Findings]:
    """Every pose once, unclocked: what each engine says. It also warms all of them up."""
    found = {engine.name: Findings() for engine in engines}
    for engine in engines:
        own = found[engine.name]
        for pose in poses:
            result = engine.aim(query, pose)()
            if query == "collide":
                own.pairs.append(engine.pairs(result))
                own.stats.append(engine.stats(result))
            elif query == "is_colliding":
                own.answers.append(engine.answer(result))
            else:
                own.values.append(engine.value(result))  # type: ignore[attr-defined]
    return found


def clock(
    engines: Sequence[Engine], poses: Floats, rounds: int, query: str = "collide", most_rounds: int = 0
) -> dict[str, Times]:
    """Every pose `rounds` times; in each round one engine after the other.

    Then up to `most_rounds` times, but for no longer than `MORE_S` seconds, with the first engine and those of the
    others that may be the best of them: what else runs on the machine comes and goes within seconds, and in a few
    rounds short cells would have all of it or nothing.
    """
    most = max(rounds, most_rounds)
    shape = (most, len(poses))
    times = {engine.name: Times(np.zeros(shape), np.zeros(shape)) for engine in engines}
    done = dict.fromkeys(times, 0)
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        asked, until = list(engines), np.inf
        for turn in range(most):
            if turn == rounds:
                asked, until = [engines[0], *_close(engines[1:], times, rounds)], time.perf_counter() + MORE_S
            if time.perf_counter() >= until:
                break
            first = turn % len(asked)
            for engine in (*asked[first:], *asked[:first]):
                own = times[engine.name]
                for i, pose in enumerate(poses):
                    own.wall[turn, i], own.cpu[turn, i] = clock_once(engine.aim(query, pose))
                done[engine.name] = turn + 1
    finally:
        if collecting:
            gc.enable()
    return {name: Times(own.wall[: done[name]], own.cpu[: done[name]]) for name, own in times.items()}


def _close(engines: Sequence[Engine], times: dict[str, Times], rounds: int) -> list[Engine]:
    """The engines of which one is the best in median or p95, as far as the first rounds can tell."""
    found = {engine.name: spread(times[engine.name].wall[:rounds].min(axis=0)) for engine in engines}
    limits = {what: CLOSE * min((own[what] for own in found.values()), default=0.0) for what in ("median", "p95")}
    return [engine for engine in engines if any(found[engine.name][what] <= limits[what] for what in limits)]


def clock_once(call: Callable[[], Any]) -> tuple[float, float]:
    """(wall, thread CPU) microseconds of one call. The wall clock is read inside the CPU clock, which is the slower."""
    cpu = time.thread_time_ns()
    start = time.perf_counter_ns()
    result = call()
    end = time.perf_counter_ns()
    cpu = time.thread_time_ns() - cpu
    del result  # freed after the clock has stopped
    return (end - start) * US_PER_NS, cpu * US_PER_NS


def far_away(mockup: feeler.Mockup, tool: feeler.Tool) -> Floats:
    """A pose far outside the mock-up, where a query has nothing to do."""
    away = np.eye(4)
    away[:3, 3] = mockup.bounds[1] + 10.0 * (np.ptp(mockup.bounds, axis=0) + np.ptp(tool.bounds, axis=0))
    return away


def overheads(engines: Sequence[Engine], mockup: feeler.Mockup, tool: feeler.Tool, calls: int = 500) -> dict[str, Any]:
    """Microseconds of a `collide` with nothing to do, the tool far outside: what binding and clock cost. Medians."""
    away = far_away(mockup, tool)
    rows: dict[str, Any] = {"clock_alone": _median_call(lambda: functools.partial(int), calls)}
    for engine in engines:
        engine.prepare(tool)
        rows[engine.name] = _median_call(functools.partial(engine.aim, "collide", away), calls)
    return rows


def _median_call(aim: Callable[[], Callable[[], Any]], calls: int) -> dict[str, float]:
    both = np.array([clock_once(aim()) for _ in range(calls)])
    return {"wall_us": float(np.median(both[:, 0])), "cpu_us": float(np.median(both[:, 1]))}


def ratios(ours: Times, theirs: Times) -> dict[str, dict[str, float]]:
    """How many times faster ours is: of the medians, of the p95s, of the worst, and the median of per-pose ratios.

    Of as many rounds as both have: an engine with more rounds has had more quiet moments.
    """
    table = {}
    rounds = min(len(ours.wall), len(theirs.wall))
    for kind, mine, other in (("wall", ours.wall, theirs.wall), ("cpu", ours.cpu, theirs.cpu)):
        # The CPU clock of some systems is coarse: below one tick it says 0.
        a, b = (np.maximum(times[:rounds].min(axis=0), 1e-3) for times in (mine, other))
        one, two = spread(a), spread(b)
        table[kind] = {
            "of_medians": two["median"] / one["median"],
            "of_p95s": two["p95"] / one["p95"],
            "of_worsts": two["worst"] / one["worst"],
            "median_per_pose": float(np.median(b / a)),
        }
    return table
