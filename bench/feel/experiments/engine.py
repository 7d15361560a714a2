"""Duration of a step in the sample engine, along a hand's way in and out."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler
from feeler.arguments import check_word
from feeler.choices import SAMPLE_TOOL_NAMES

from ..faces import TICK_S, Face
from .fitting import colliding

TOOLS = ("hand", "wrench")  # hand: 4,908 triangles
SERVO_HZ = 100.0  # of collision, where the steps between are timed: ten ticks are old, yet not too old
MARGIN_M = 0.002
PEAK_M_PER_S = 0.9  # of a reach that takes 0.5 m/s in the mean and starts and ends at rest (minimum jerk)
ROUGH_STEPS = 500


def run(
    make: Callable[..., Face],
    triangles: int,
    most_steps: int | None = None,
    tools: tuple[str, ...] = TOOLS,
    seed: int = 0,
) -> dict[str, Any]:
    """Times of a step with collision each time; of the contacts alone; of a step without collision.

    `most_steps`: not the whole way but as many ticks of its middle, where the tool works.
    """
    mockup = feeler.sample("engine", triangles)
    scene = feeler.Scene(mockup, threads=1)
    rows = []
    for name in tools:
        tool = feeler.sample_tool(check_word("name", name, SAMPLE_TOOL_NAMES))
        path = hand_path(scene, tool, seed)
        if most_steps is not None:
            first = max(0, (len(path) - most_steps) // 2)
            while first > 0 and not scene.is_free(tool, path[first]):
                first -= 1  # a session begins where the tool is free
            path = path[first : first + most_steps]
        whole, proxies, planes, _ = _timed(make(scene, tool, seed=seed), path)
        some, _, _, ages = _timed(make(scene, tool, seed=seed, collision_hz=SERVO_HZ), path)
        servo = some[ages > 0.0]
        alone, near = _contacts_alone(scene, tool, proxies)
        rows.append(
            {
                "tool": name,
                "tool_triangles": tool.triangle_count,
                "triangles": mockup.triangle_count,
                "steps": len(path),
                "planes_mean": float(np.mean(planes)),
                "step_us": quantiles(whole),
                "near_steps": int(near.sum()),
                "near_us": quantiles(whole[near]) if near.any() else None,
                "contacts_us": quantiles(alone),
                "servo_us": quantiles(servo) if len(servo) else None,
                "median_hz": 1.0 / float(np.median(whole)),
                "p99_hz": 1.0 / float(np.percentile(whole, 99)),
                "colliding_steps": colliding(scene, tool, proxies),
                "trace_us": [round(1e6 * float(t), 1) for t in whole[:: max(1, len(whole) // 500)]],
            }
        )
    return {"rows": rows, "sample": "engine", "triangles_asked": triangles}


def hand_path(scene: feeler.Scene, tool: feeler.Tool, seed: int) -> npt.NDArray[np.float64]:
    """The sample's way of a hand in and out, a pose a tick, at its own speed: about `PEAK_M_PER_S` at the most."""
    rough = feeler.sample_path(scene, tool, ROUGH_STEPS, seed)
    longest = float(np.sqrt((np.diff(rough[:, :3, 3], axis=0) ** 2).sum(axis=1)).max())
    return feeler.sample_path(scene, tool, round(ROUGH_STEPS * longest / (PEAK_M_PER_S * TICK_S)), seed)


def quantiles(seconds: npt.NDArray[np.float64]) -> dict[str, float]:
    """In microseconds."""
    shares = {"median": 50.0, "p95": 95.0, "p99": 99.0, "p99.9": 99.9, "worst": 100.0}
    return {name: 1e6 * float(np.percentile(seconds, share)) for name, share in shares.items()}


def _timed(
    face: Face, path: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], list[int], npt.NDArray[np.float64]]:
    """Seconds of each step, proxy poses, planes, and how old the planes were."""
    face.start(path[0])
    times, proxies, planes, ages = np.empty(len(path)), np.empty((len(path), 4, 4)), [], np.empty(len(path))
    clock = time.perf_counter
    for k, at in enumerate(path):
        begin = clock()
        step = face.step(at, TICK_S)
        times[k] = clock() - begin
        proxies[k] = step.world_from_proxy
        ages[k] = getattr(step, "age", 0.0)
        found = getattr(step, "planes", 0)
        planes.append(found if isinstance(found, int) else len(found))
    return times, proxies, planes, ages


def _contacts_alone(
    scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Seconds of the contact query at each of the proxy's poses, and whether it found anything."""
    times, near = np.empty(len(poses)), np.zeros(len(poses), dtype=bool)
    for k, at in enumerate(poses):
        begin = time.perf_counter()
        found = scene.contacts(tool, at, MARGIN_M)
        times[k] = time.perf_counter() - begin
        near[k] = len(found) > 0
    return times, near
