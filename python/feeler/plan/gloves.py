"""Room around a hand: which part of a free swing keeps it farther than a clearance from all parts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.plan.swings import FINEST_DEG, Swing, turned
from feeler.plan.tool_seat import ignoring
from feeler.scene import Scene
from feeler.stopping import check_stop

Floats = npt.NDArray[np.float64]

STEP_DEG = 0.02
"""A swing ends at most this much too early where a hand comes near a part, degrees. Less: more distances."""
FARTHER = 20.0
"""Distances are measured up to so many clearances: farther ones allow longer steps, and take longer each."""
LEAST_RADIUS_M = 1e-6
"""Of a hand on the axis, metres: it does not move."""


def wide_swings(
    scene: Scene,
    kept: Tool,
    frame: Floats,
    swings: Sequence[Swing],
    clearance: float,
    part: int | None,
    blocked: Counter[int],
) -> list[Swing]:
    """The free swings in which `kept` stays at least a clearance away from all parts but `part`, the largest first.

    Never too large: no point of it moves farther than the angle times its distance from the axis, so a gap at one angle
    is a bound for those around it.
    """
    ignore = ignoring(kept, scene.mockup, part)
    radius = max(LEAST_RADIUS_M, float(np.hypot(kept.vertices[:, 0], kept.vertices[:, 1]).max()))

    def gap(angle: float) -> float:
        check_stop()
        near = scene.distance(kept, frame @ turned(angle), within=FARTHER * clearance, ignore=ignore)
        if near.value < clearance and near.part is not None:
            blocked[near.part] += 1
        return min(near.value, FARTHER * clearance)

    found = [each for swing in swings for each in gloved(gap, swing, clearance, radius)]
    return sorted(found, key=lambda swing: (-swing.span, swing.start))


def gloved(gap: Callable[[float], float], swing: Swing, clearance: float, radius: float) -> list[Swing]:
    """The parts of a swing at which a gap (metres, by angle in degrees) is at least a clearance.

    The gap changes by at most `radius` metres a radian.
    """
    runs: list[tuple[float, float]] = []
    begin: float | None = None
    at = 0.0
    while at < swing.span:
        room = gap(swing.start + at) - clearance
        step = math.degrees(abs(room) / radius)
        if room >= 0.0:
            begin = at if begin is None else begin
            if step < STEP_DEG:
                runs.append((begin, at + step))
                begin = None
        elif begin is not None:
            runs.append((begin, at))
            begin = None
        at += max(step, STEP_DEG)
    if begin is not None:
        runs.append((begin, swing.span))
    runs = [(low, min(high, swing.span)) for low, high in runs]
    if swing.span == 360.0 and len(runs) > 1 and runs[0][0] == 0.0 and runs[-1][1] == 360.0:
        first = runs.pop(0)
        runs[-1] = (runs[-1][0], 360.0 + first[1])
    return [Swing((swing.start + low) % 360.0, high - low) for low, high in runs if high - low >= FINEST_DEG]
