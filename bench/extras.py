"""feeler alone: batches on one and two cores, the cost of a Python call, and a fine tool against its coarse twin."""

from __future__ import annotations

import functools
import os
import threading
import time
from typing import Any

import numpy as np
from engines import Floats
from measure import clock_once, far_away, find_poses, spread

import feeler

BATCH_TOOLS = ("torque", "hand")
ROUNDS = 3
BATCHES = 8  # a round


def batch(scene: feeler.Scene, tool: feeler.Tool, count: int, seed: int) -> dict[str, Any]:
    """Poses a second: one call each, and `collide_batch` with one and with two threads; the best of a few rounds each.

    The poses are nominal, all different, one anywhere from the last. Calls and batches take turns. So do two batches of
    half the poses each, on one thread each, which share nothing but the machine: more than their rate it does not have.
    """
    many = find_poses(scene, tool, "nominal", count, seed + 2)
    count, mockup = len(many), scene.mockup
    halves = [np.ascontiguousarray(many[from_::2]) for from_ in range(2)]
    scenes = {threads: feeler.Scene(mockup, threads=threads) for threads in (1, 2) if threads <= (os.cpu_count() or 1)}
    other = feeler.Scene(mockup, threads=1) if 2 in scenes else None
    best: dict[str, float] = {}

    def keep(what: str, seconds: float) -> None:
        best[what] = max(best.get(what, 0.0), count / seconds)

    pairs, cores = set(), 0.0
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for pose in many:
            scenes[1].collide(tool, pose)
        keep("calls", time.perf_counter() - start)
        # They are short: more often, since other processes of the machine take a share of one of two cores.
        for threads, scene in [*scenes.items()] * BATCHES:
            start, cpu = time.perf_counter(), time.process_time()
            found = scene.collide_batch(tool, many)
            seconds = time.perf_counter() - start
            keep(f"batch_{threads}", seconds)
            cores = max(cores, (time.process_time() - cpu) / seconds)
            pairs.add(int(found.offsets[-1]))
            if threads == 2 and other is not None:
                start = time.perf_counter()
                beside = threading.Thread(target=other.collide_batch, args=(tool, halves[1]))
                beside.start()
                scenes[1].collide_batch(tool, halves[0])
                beside.join()
                keep("apart_2", time.perf_counter() - start)
    row = {f"{what}_per_s": rate for what, rate in best.items()}
    row |= {"poses": count, "pairs": max(pairs), "pairs_equal": len(pairs) == 1}
    if "batch_2" in best:
        row["two_over_one"] = best["batch_2"] / best["batch_1"]
        row["apart_over_one"] = best["apart_2"] / best["batch_1"]
        row["cores_had"] = cores  # CPU time over wall time, at best: below 2, other processes were running
    return row


def python_call(mockup: feeler.Mockup, tool: feeler.Tool, calls: int = 2000) -> dict[str, float]:
    """Microseconds that a Python call of `collide` costs over the core's work, with the tool far outside.

    The core's time is that of a pose within a batch of such poses on one thread: one call for all of them.
    """
    scene, away = feeler.Scene(mockup, threads=1), far_away(mockup, tool)
    many = np.repeat(away[None], calls, axis=0)
    call = float(np.median([clock_once(lambda: scene.collide(tool, away))[0] for _ in range(calls)]))
    clock = float(np.median([clock_once(lambda: None)[0] for _ in range(calls)]))
    core = min(clock_once(lambda: scene.collide_batch(tool, many))[0] for _ in range(5)) / calls
    return {"call_us": call, "clock_us": clock, "core_us": core, "over_core_us": call - clock - core}


def fine_and_coarse(
    scene: feeler.Scene, coarse: feeler.Tool, fine: feeler.Tool, poses: Floats, rounds: int
) -> dict[str, Any]:
    """The cost of the fine tool beside its coarse twin, at the coarse one's nominal poses."""
    tools = (coarse, fine)
    wall = np.full((2, rounds, len(poses)), np.inf)
    pairs = np.array([[len(scene.collide(tool, pose).pairs) for pose in poses] for tool in tools])
    for turn in range(rounds):
        for k, tool in enumerate(tools):
            for i, pose in enumerate(poses):
                wall[k, turn, i], _ = clock_once(functools.partial(scene.collide, tool, pose))
    one, two = (spread(own.min(axis=0)) for own in wall)
    return {
        "poses": len(poses),
        "finer": fine.triangle_count / coarse.triangle_count,
        "coarse_us": one,
        "fine_us": two,
        "pairs": [float(np.median(own)) for own in pairs],
        "times_slower": two["median"] / one["median"],
        "times_slower_p95": two["p95"] / one["p95"],
    }
