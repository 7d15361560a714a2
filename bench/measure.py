"""The clock: the same poses for every engine, interleaved, and what the figures are made of.

Rounds of all poses; at each pose every engine is called once, and who comes first changes from pose to pose and from
round to round, so that a busy moment of the machine, a slow clock or a cold cache hits all of them alike. Of each pose
the least time over the rounds is kept: the machine can only add to it. Median, p95 and worst are over poses.
"""

from __future__ import annotations

import functools
import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from engines import Engine, Floats, Pairs
from judge import judge

import feeler
from feeler.progress import bar
from feeler.samples.poses import sample_poses

US_PER_NS = 1e-3


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
        }


@dataclass
class Findings:
    """What an engine found at each pose, and what it did for it, from a pass outside the clock."""

    pairs: list[Pairs] = field(default_factory=list)
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


def find_poses(scene: feeler.Scene, tool: feeler.Tool, kind: str, count: int, seed: int = 0) -> Floats:
    """Poses of a kind; where they are rare, fewer than asked. Raises `OptionError` when not even one is found."""
    with bar(f"finding {kind} poses") as progress:
        while True:
            try:
                return sample_poses(scene, tool, kind, count, seed, progress=progress)
            except feeler.OptionError:
                if count == 1:
                    raise
                count = max(1, count // 4)


def look(engines: Sequence[Engine], poses: Floats) -> dict[str, Findings]:
    """Every pose once, unclocked: what each engine finds. It also warms all of them up."""
    found = {engine.name: Findings() for engine in engines}
    for pose in poses:
        for engine in engines:
            result = engine.aim(pose)()
            found[engine.name].pairs.append(engine.pairs(result))
            found[engine.name].stats.append(engine.stats(result))
    return found


def clock(engines: Sequence[Engine], poses: Floats, rounds: int) -> dict[str, Times]:
    """Every pose `rounds` times, engines interleaved."""
    shape = (rounds, len(poses))
    times = {engine.name: Times(np.zeros(shape), np.zeros(shape)) for engine in engines}
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for turn in range(rounds):
            for i, pose in enumerate(poses):
                first = (turn + i) % len(engines)
                for engine in (*engines[first:], *engines[:first]):
                    wall, cpu = clock_once(engine.aim(pose))
                    times[engine.name].wall[turn, i] = wall
                    times[engine.name].cpu[turn, i] = cpu
    finally:
        if collecting:
            gc.enable()
    return times


def clock_once(call: Callable[[], Any]) -> tuple[float, float]:
    """(wall, thread CPU) microseconds of one call. The wall clock is read inside the CPU clock, which is the slower."""
    cpu = time.thread_time_ns()
    start = time.perf_counter_ns()
    result = call()
    end = time.perf_counter_ns()
    cpu = time.thread_time_ns() - cpu
    del result  # freed after the clock has stopped
    return (end - start) * US_PER_NS, cpu * US_PER_NS


def overheads(engines: Sequence[Engine], mockup: feeler.Mockup, tool: feeler.Tool, calls: int = 500) -> dict[str, Any]:
    """Microseconds of a call that has nothing to do, the tool far outside: what binding and clock cost. Medians."""
    away = np.eye(4)
    away[:3, 3] = mockup.bounds[1] + 10.0 * (np.ptp(mockup.bounds, axis=0) + np.ptp(tool.bounds, axis=0))
    rows: dict[str, Any] = {"clock_alone": _median_call(lambda: functools.partial(int), calls)}
    for engine in engines:
        engine.prepare(tool)
        rows[engine.name] = _median_call(functools.partial(engine.aim, away), calls)
    return rows


def _median_call(aim: Callable[[], Callable[[], Any]], calls: int) -> dict[str, float]:
    both = np.array([clock_once(aim()) for _ in range(calls)])
    return {"wall_us": float(np.median(both[:, 0])), "cpu_us": float(np.median(both[:, 1]))}


def ratios(ours: Times, theirs: Times) -> dict[str, dict[str, float]]:
    """How many times faster ours is: of the medians, of the p95s, of the worst, and the median of per-pose ratios."""
    table = {}
    for kind, mine, other in (("wall", ours.wall, theirs.wall), ("cpu", ours.cpu, theirs.cpu)):
        # The CPU clock of some systems is coarse: below one tick it says 0.
        a, b = np.maximum(mine.min(axis=0), 1e-3), np.maximum(other.min(axis=0), 1e-3)
        one, two = spread(a), spread(b)
        table[kind] = {
            "of_medians": two["median"] / one["median"],
            "of_p95s": two["p95"] / one["p95"],
            "of_worsts": two["worst"] / one["worst"],
            "median_per_pose": float(np.median(b / a)),
        }
    return table


EXAMPLES_KEPT = 5


@dataclass
class Agreement:
    """Pairs two engines agree on, and where they differ, who is right by exact arithmetic."""

    agreed: int = 0
    feeler_only_true: int = 0  # the peer missed it
    peer_only_false: int = 0  # the peer made it up
    feeler_only_false: int = 0  # feeler made it up
    peer_only_true: int = 0  # feeler missed it
    not_queried: int = 0  # a triangle without area: feeler leaves it out and says so in the load report
    examples: dict[str, list[list[int]]] = field(default_factory=dict)  # [pose, tool triangle, mock-up triangle]

    @property
    def feeler_wrong(self) -> int:
        """Pairs on which feeler breaks its contract; anything but 0 is a bug."""
        return self.feeler_only_false + self.peer_only_true

    def row(self) -> dict[str, Any]:
        """For the record."""
        counts = {name: value for name, value in vars(self).items() if name != "examples"}
        return counts | {"feeler_wrong": self.feeler_wrong, "examples": self.examples}

    def _add(self, what: str, pose: int, pair: npt.NDArray[np.uint32]) -> None:
        setattr(self, what, getattr(self, what) + 1)
        kept = self.examples.setdefault(what, [])
        if len(kept) < EXAMPLES_KEPT:
            kept.append([pose, *(int(i) for i in pair)])


def compare(mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats, ours: Findings, theirs: Findings) -> Agreement:
    """Hold the pairs of all poses side by side, and have the differences judged."""
    agreement = Agreement()
    for number, (pose, mine, other) in enumerate(zip(poses, ours.pairs, theirs.pairs, strict=True)):
        mine_keys, other_keys = _keys(mine), _keys(other)
        agreement.agreed += len(np.intersect1d(mine_keys, other_keys, assume_unique=True))
        for pairs, keys, rest, if_true, if_false in (
            (mine, mine_keys, other_keys, "feeler_only_true", "feeler_only_false"),
            (other, other_keys, mine_keys, "peer_only_true", "peer_only_false"),
        ):
            extra = pairs[~np.isin(keys, rest)]
            for pair, true in zip(extra, judge(mockup, tool, pose, extra), strict=True):
                agreement._add("not_queried" if true is None else if_true if true else if_false, number, pair)
    return agreement


def _keys(pairs: Pairs) -> npt.NDArray[np.uint64]:
    return pairs[:, 0].astype(np.uint64) << np.uint64(32) | pairs[:, 1].astype(np.uint64)
