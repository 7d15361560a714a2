"""The accessory gearbox of the sample engine as a door: 121 positions, the curve over all of them, and its range."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import host
import numpy as np

import feeler
from feeler import Joint, JointKind, Mechanism

from .steppers import Stepper

Result = dict[str, Any]
DOOR = "*accessory_gearbox*"
THROUGH = "*harness_17*"
"""Its cable goes through the gearbox as drawn, and is taken out."""
HINGE = (0.43, -0.40, 0.9)
OPEN = (0.0, 1.9)
STEPS = 121
WITHIN_M = 0.005
ERROR_M = 1e-4


def measured(size: int, repeats: int, steppers: Sequence[Stepper]) -> Result:
    """Seconds on one core, the least of some runs; peers once."""
    mockup = feeler.sample("engine", size)
    scene = feeler.Scene(mockup, threads=1)
    through = [path for path in mockup.part_paths if "harness_17" in path]
    scene = scene.without(through) if through else scene
    print(f"{mockup.triangle_count:,} triangles: the door", file=sys.stderr)
    hinge = Joint("door", JointKind.REVOLUTE, None, DOOR, (0.0, 0.0, 1.0), HINGE, limits=OPEN)
    with host.on_core(host.last_core()):
        moved = Mechanism(mockup, [hinge], scene=scene)
        first, free = _least(lambda: moved.range("door"), 1)
        tool, around = feeler.Tool.of_parts(mockup, DOOR), scene.without(DOOR)
        values = np.linspace(*OPEN, STEPS)
        poses = np.array([moved.poses({"door": float(value)})["door"] for value in values])
        curve, gap = _least(lambda: moved.clearance({"door": OPEN}, error=ERROR_M), repeats)
        stepped, _ = _least(lambda: around.clearance_batch(tool, poses, WITHIN_M), repeats)
        again, _ = _least(lambda: moved.range("door"), repeats)
        clashes, listed = _least(lambda: moved.clash({"door": OPEN}), repeats)
        theirs: Result = {}
        whole = _mockup_of(mockup, around)
        for each in steppers:
            loaded, ask = _least(lambda each=each: each.least(tool, whole), 1)  # type: ignore[misc]
            taken, least = _least(lambda ask=ask: ask(poses), 1)  # type: ignore[misc]
            theirs[each.name] = {"load_s": loaded, "steps_s": taken, "gap": least}
    parts = mockup.parts.select(DOOR)
    return {
        "triangles": mockup.triangle_count,
        "parts": len(parts),
        "door_triangles": int(np.isin(mockup.part_of_face, parts).sum()),
        "steps": STEPS,
        "error": ERROR_M,
        "seconds": {
            "clearance": stepped,
            "curve": curve,
            "range": again,
            "clash": clashes,
            "first": first,
        },
        "free": [free.lower, free.upper],
        "lower": gap.lower,
        "upper": gap.upper,
        "curve_lower": float(gap.curve[:, 2].min()),
        "curve_gap": float(gap.curve[:, 1].min()),
        "clashes": len(listed),
        "seats": len(gap.seats),
        "jams": len(gap.jams),
        "peers": theirs,
    }


def _mockup_of(mockup: feeler.Mockup, scene: feeler.Scene) -> feeler.Mockup:
    """What stands, as a mock-up of its own."""
    tool = feeler.Tool.of_parts(mockup, np.flatnonzero(scene.part_mask).tolist())
    return feeler.Mockup(tool.vertices, tool.faces, tool.part_of_face, tool.part_names)


def _least(work: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    times, found = [], None
    for _ in range(repeats):
        begun = time.perf_counter()
        found = work()
        times.append(time.perf_counter() - begun)
    return float(f"{min(times):.4g}"), found
