"""Timing that is robust to noise: settings are measured in turns, many times, and compared by medians."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt

from ..calibrate import NAMES, cpu_name, machine_constants, query_clock
from ..mockup import Tool
from ..scene import Scene

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Setting:
    """A scene and its query options."""

    scene: Scene
    filters: dict[str, bool]


@dataclass(frozen=True, eq=False)
class Times:
    """Seconds of every query: (settings, rounds, poses)."""

    samples: Floats

    def seconds(self) -> list[float]:
        """For each setting: the mean over the poses of the median over the rounds."""
        return [float(x) for x in np.median(self.samples, axis=1).mean(axis=1)]

    def spread(self) -> list[tuple[float, float]]:
        """For each setting: the quartiles over the rounds of the mean over the poses."""
        low, high = np.percentile(self.samples.mean(axis=2), [25, 75], axis=1)
        return [(float(a), float(b)) for a, b in zip(low, high, strict=True)]


def time_in_turns(
    settings: Sequence[Setting], tool: Tool, poses: Floats, rounds: int, seed: int, budget_s: float = 20.0
) -> Times:
    """Queries every setting at every pose, in rounds, each in another order.

    Before its poses are timed, a setting runs them once untimed, so that a tool moving in one scene with warm caches is
    measured. The clock is `query_clock`. After the budget is used up no new round begins; at least three rounds run.
    """
    rng = np.random.default_rng(seed)
    samples = np.empty((len(settings), rounds, len(poses)))
    clock, began = query_clock(), time.perf_counter()
    done = 0
    while done < rounds and (done < 3 or time.perf_counter() - began < budget_s):
        for number in rng.permutation(len(settings)):
            setting = settings[number]
            collide = setting.scene.collide
            for pose in poses:
                collide(tool, pose, **setting.filters)
            for p, pose in enumerate(poses):
                start = clock()
                collide(tool, pose, **setting.filters)
                samples[number, done, p] = clock() - start
        done += 1
    return Times(samples[:, :done])


def least_in_turns(*tasks: Callable[[], object], rounds: int = 5) -> list[float]:
    """Wall-clock seconds of each task, all threads: the least over rounds in which the tasks take turns."""
    least = [float("inf")] * len(tasks)
    for _ in range(rounds):
        for i, task in enumerate(tasks):
            start = time.perf_counter()
            task()
            least[i] = min(least[i], time.perf_counter() - start)
    return least


def mean_work(scene: Scene, tool: Tool, poses: Floats) -> dict[str, float]:
    """The counters of a query, mean over the poses."""
    stats = [scene.collide(tool, pose).stats for pose in poses]
    return {name: float(np.mean([each[name] for each in stats])) for name in stats[0]}


def machine() -> dict[str, Any]:
    """The circumstances that the times depend on."""
    return {
        "cpu": cpu_name(),
        "cores": os.cpu_count(),
        "system": platform.platform(terse=True),
        "feeler": version("feeler"),
        "constants_s": dict(zip(NAMES, machine_constants(), strict=True)),
    }
