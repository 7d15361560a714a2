"""A nightly run of a sample, the next one where nothing changed, and the next where parts moved."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from section import Result

import feeler

SHIFT_M = 2e-3
"""The most by which a part moves along each axis."""
SHARE = 0.01
"""Of the parts that move."""
SAME = (
    *("name", "paths", "state", "seconds", "low", "high", "steps", "undone", "tools", "reach_deg", "sight", "hidden"),
    *("is_unreachable", "blockers", "said"),
)
"""What two rows have to say alike."""
GEARBOX = (
    *("oil_pump/body", "starter/body", "generator/body", "oil_filter/head", "covers/main_front/cover"),
    *("covers/idler_front/cover", "covers/oil_pump_front/cover", "covers/breather_rear/cover"),
    *("bracket/left_mount/retainer", "bracket/right_mount/retainer"),
)


def gearbox(triangles: int, count: int, moves: int) -> Result:
    """Units of the sample gearbox."""
    mockup = feeler.sample("gearbox", triangles)
    return _nights(mockup, [f"gearbox/{name}" for name in GEARBOX][:count], moves)


def engine(triangles: int, count: int, moves: int) -> Result:
    """What is changed on the sample engine in service: units on its accessory gearbox, control boxes, and pipes."""
    mockup = feeler.sample("engine", triangles)
    found: list[str] = []
    for ending in ("/body", "/tube", "/clamp_001", "/clamp_002"):
        found += [path for path in mockup.part_paths if path.startswith("engine/externals/") and path.endswith(ending)]
    return _nights(mockup, found[:count], moves)


def _nights(mockup: feeler.Mockup, parts: list[str], moves: int) -> Result:
    scene = feeler.Scene(mockup, threads=1)
    first, seconds = _timed(lambda: _run(scene, parts, None))
    with TemporaryDirectory() as folder:
        last = Path(folder) / "last.json"
        first.save(last)
        sizes = [last.stat().st_size, Path(f"{last}.answers").stat().st_size]
        again, same_seconds = _timed(lambda: _run(scene, parts, last))
        moved = [_moved(scene, parts, last, seed) for seed in range(moves)]
    return {
        "triangles": mockup.triangle_count,
        "parts": mockup.part_count,
        "rows": len(first),
        "out": sum(row.state == "out" for row in first),
        "cut": sum(plan.is_cut for plan, _ in first.plans.values()),
        "with_errors": sum(row.state == "failed" for row in first),
        "seconds": seconds,
        "bytes": sizes,
        "same_seconds": same_seconds,
        "same_kept": sum(row.is_kept for row in again),
        "same_differs": _differing(again, first),
        "moved": moved,
    }


def _moved(scene: feeler.Scene, parts: list[str], last: Path, seed: int) -> Result:
    """The next run where one part in a hundred moved, beside a full one."""
    poses = _poses(scene.mockup, np.random.default_rng(seed))
    there = feeler.Scene(scene.moved(poses).mockup, threads=1)
    run, seconds = _timed(lambda: _run(there, parts, last))
    full, full_seconds = _timed(lambda: _run(there, parts, None))
    return {
        "parts": len(poses),
        "seconds": seconds,
        "full_seconds": full_seconds,
        "kept": sum(row.is_kept for row in run),
        "changed": sum(bool(row.change) for row in run),
        "differs": _differing(run, full),
    }


def _run(scene: feeler.Scene, parts: list[str], previous: Path | None) -> feeler.Maintenance:
    return feeler.maintain(scene, parts, tools="built-in", previous=previous, threads=1)


def _timed(work: Callable[[], feeler.Maintenance]) -> tuple[feeler.Maintenance, float]:
    """A run, and the seconds of the processor: others may use it, too."""
    begin = time.process_time()
    run = work()
    seconds = time.process_time() - begin
    print(f"{run.said}: {seconds:.3g} s", file=sys.stderr)
    return run, seconds


def _differing(run: feeler.Maintenance, other: feeler.Maintenance) -> list[str]:
    """The rows that say other things."""
    facts: list[list[dict[str, Any]]] = [
        [{name: repr(row.to_dict()[name]) for name in SAME} for row in each] for each in (run, other)
    ]
    return [row.name for row, one, two in zip(run, *facts, strict=True) if one != two]


def _poses(mockup: feeler.Mockup, rng: np.random.Generator) -> dict[int, np.ndarray[Any, Any]]:
    """Small moves of one part in a hundred, inside the box of all."""
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    lower, upper = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    poses: dict[int, np.ndarray[Any, Any]] = {}
    for part in rng.permutation(mockup.part_count).tolist():
        by = rng.uniform(-SHIFT_M, SHIFT_M, 3)
        if len(poses) >= round(SHARE * mockup.part_count):
            break
        if (boxes[part, 0] + by >= lower).all() and (boxes[part, 1] + by <= upper).all():
            poses[part] = np.eye(4)
            poses[part][:3, 3] = by
    return poses
