"""The sample engine: its removable parts, and the time to find out; and its bolts, with a wrench."""

from __future__ import annotations

import sys
import time
from typing import Any

import host
import numpy as np

import feeler
from feeler.types import GripAxis

Result = dict[str, Any]

WRENCH_GRIP: GripAxis = "y"
LIFTS = {"at the heads": 0.0, "40 mm above them": 0.04, "in free space": 5.0}
"""Where the wrench is held, metres above the heads. In free space each swing goes all the way round: the most work."""
LEAST_S = 0.25
"""Time for a part of the small engine: a straight way is found long before."""


def straight_ways(size: int, every: int) -> Result:
    """Every `every`-th part of an engine, all others in place, on one core: those with a straight way."""
    mockup = feeler.sample("engine", size)
    scene = feeler.Scene(mockup, threads=1)
    print(f"{mockup.triangle_count:,} triangles: straight ways", file=sys.stderr)
    straight: list[float] = []
    others: list[float] = []
    with host.on_core(host.last_core()):
        for part in range(0, mockup.part_count, every):
            found, seconds = _timed(scene, part, LEAST_S)
            (straight if found.is_found and is_straight(found) else others).append(seconds)
    return {
        "triangles": mockup.triangle_count,
        "parts": len(straight) + len(others),
        "straight": len(straight),
        "straight_s": _spread(straight),
        "limit_s": LEAST_S,
    }


def rate(size: int, count: int, seconds: float) -> Result:
    """Parts of an engine, evenly spread over its list, one after the other on one core."""
    mockup = feeler.sample("engine", size)
    scene = feeler.Scene(mockup, threads=1)
    print(f"{mockup.triangle_count:,} triangles: {count} parts", file=sys.stderr)
    chosen = np.linspace(0, mockup.part_count - 1, count).astype(int).tolist()
    with host.on_core(host.last_core()):
        answers = [_timed(scene, part, seconds) for part in chosen]
    times = [taken for _, taken in answers]
    return {
        "triangles": mockup.triangle_count,
        "all_parts": mockup.part_count,
        "parts": count,
        "found": sum(found.is_found for found, _ in answers),
        "straight": sum(found.is_found and is_straight(found) for found, _ in answers),
        "free": sum(found.is_found for found, _ in answers),
        "total_s": float(f"{sum(times):.4g}"),
        "spread_s": _spread(times),
        "limit_s": seconds,
    }


def access(size: int, count: int, angles: int) -> Result:
    """Bolts of an engine, a wrench at several angles on each, on one core."""
    mockup = feeler.sample("engine", size)
    scene = feeler.Scene(mockup, threads=1)
    wrench = feeler.sample_tool("wrench")
    print(f"{mockup.triangle_count:,} triangles: access to {count} bolts", file=sys.stderr)
    begun = time.perf_counter()
    fasteners = feeler.find_fasteners(scene)
    finding = time.perf_counter() - begun
    bolts = fasteners.where("*bolt*")
    targets = bolts[:: max(1, len(bolts) // count)][:count]
    rows: list[Result] = []
    with host.on_core(host.last_core()):
        for where, lift in LIFTS.items():
            begun = time.perf_counter()
            found = feeler.access(scene, wrench, targets, angles=angles, grip=WRENCH_GRIP, lift=lift, threads=1)
            taken = time.perf_counter() - begun
            reachable = int(np.count_nonzero(found.is_reachable))
            rows.append({"where": where, "reachable": reachable, "total_s": float(f"{taken:.4g}")})
    return {
        "triangles": mockup.triangle_count,
        "fasteners": len(fasteners),
        "finding_s": float(f"{finding:.4g}"),
        "targets": len(targets),
        "angles": angles,
        "rows": rows,
        "worst_s": max(row["total_s"] for row in rows),
    }


def is_straight(found: feeler.Removal) -> bool:
    """Whether the way is one leg without a turn."""
    return len(found.poses) == 2 and found.rotation == 0.0


def _timed(scene: feeler.Scene, part: int, seconds: float) -> tuple[feeler.Removal, float]:
    begun = time.perf_counter()
    found = feeler.removal(scene, [part], seconds=seconds, threads=1)
    return found, time.perf_counter() - begun


def _spread(times: list[float]) -> Result:
    if not times:
        return {}
    p50, p99, worst = np.percentile(times, [50, 99, 100])
    return {"median": float(f"{p50:.3g}"), "p99": float(f"{p99:.3g}"), "worst": float(f"{worst:.3g}")}
