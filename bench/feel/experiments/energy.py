"""Does the session produce energy? Closed motions, a hand that steps into a wall, one that releases.

A simulated hand (`hands.Hand`) holds the device; its mechanics run ten times a tick. A force holds for a tick, so the
work of a tick is that force times the device's motion: the work that a real hand would feel.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import feeler

from .. import hands, scenes
from ..faces import TICK_S, Face, limited
from ..meshes import Floats, Mesh, ball, box, mockup_of, tool_of
from ..poses import pose

SETTLE_S = 3.0
BOUND_SHARE = 0.9  # of the stiffness that the device can hold
LOOKED_AT_S = 0.4
RELEASE_DEPTHS_M = (0.002, 0.005)
RELEASE_S = 0.6


def closed_motions() -> dict[str, tuple[Mesh, Mesh, Floats]]:
    """Mock-up, tool and device poses of motions that end where they begin, free of everything."""
    plate, sheet, half = box((0.2, 0.2, 0.02), (0, 0, -0.01), 1), scenes.thin_sheet(), scenes.half_sheet()
    block = box((0.03, 0.02, 0.04), (0.0, 0.0, 0.02), 1)
    slot = scenes.tooth_in_slot(2)
    up, down, across = np.array([0, 0, 1.0]), np.array([0, 0, -1.0]), np.array([1.0, 0, 0])
    over = pose(0.002 * up)
    press = np.array([over, pose(-0.004 * up), over])
    tilt = np.array([over, pose(-0.002 * up), pose(-0.002 * up, (0.12, 0.2, 0.0)), over])
    rub = np.array([over, pose(-0.003 * up), pose(-0.003 * up + 0.02 * across), pose(0.002 * up + 0.02 * across), over])
    lifted = slot.touching.copy()
    lifted[:3, 3] += 0.002 * up
    corner = lifted @ pose((0.0015, 0.0, -0.004), (0.0, 0.04, 0.0))
    by_edge = pose((0.02, 0.0, 0.001))
    return {
        "press": (plate, block, hands.through(press, 0.3)),
        "press fast": (plate, block, hands.through(press, 0.04)),
        "tilt": (plate, block, hands.through(tilt, 0.3)),
        "rub": (plate, block, hands.through(rub, 0.2)),
        "circle": (plate, ball(0.02, 16), hands.circle(pose(0.022 * up), across, down, 0.004, 0.5)),
        "circles on a sheet": (sheet, block, np.concatenate([hands.circle(over, across, down, 0.003, 0.25)] * 4)),
        "corner of a slot": (slot.mockup, slot.tool, hands.through(np.array([lifted, corner, lifted]), 0.3)),
        "edge of a sheet": (half, ball(0.01, 16), hands.circle(by_edge, np.array([0, 0, 1.0]), -across, 0.008, 0.6)),
    }


def closed(make: Callable[..., Face], seed: int = 0) -> dict[str, Any]:
    """The energy that each closed motion cost, and the share that came back."""
    rows = []
    for name, (mockup, tool, path) in closed_motions().items():
        scene = feeler.Scene(mockup_of(mockup), threads=1)
        face = make(scene, tool_of(tool), seed=seed)
        face.start(path[0])
        # at rest before and after: the energy in the damper comes out
        steps = [*path, *([path[-1]] * 100)]
        works, largest = [], 0.0
        step = face.step(steps[0])
        for before, after in itertools.pairwise(steps):
            works.append(hands.work_j(before, after, np.asarray(step.force), np.asarray(step.torque)))
            largest = max(largest, float(np.linalg.norm(step.force)))
            step = face.step(after)
        went_in = -sum(w for w in works if w < 0.0)
        rows.append(
            {
                "motion": name,
                "went_in_j": went_in,
                "came_out_j": sum(w for w in works if w > 0.0),
                "gain": sum(works) / went_in if went_in > 0.0 else 0.0,
                "largest_n": largest,
                "force_after_n": float(np.linalg.norm(step.force)),
            }
        )
    return {"rows": rows}


def bound_n_per_m(delay_ticks: int, grip: hands.Grip | None = None) -> float:
    """The largest stiffness that a damped device can hold at 1 kHz, late by whole ticks.

    From `b > K T / 2` (Colgate and Schenkel 1997) and the delay's share, `K delay`; `b` is that of device and hand.
    """
    return (grip or hands.Grip()).damping_ns_per_m / (0.5 * TICK_S + delay_ticks * TICK_S)


def step_response(
    make: Callable[..., Face],
    stiffened: Callable[[float], dict[str, Any] | None],
    delays_ticks: Sequence[int] = (0, 1, 3),
    seed: int = 0,
) -> dict[str, Any]:
    """A hand that suddenly wants to be 5 mm inside a wall: does the device come to rest?

    With the face's own coupling, and at `BOUND_SHARE` of the device's bound (`stiffened`: options for that, or None).
    `swing_m`: from top to bottom over the last ticks, `swing_before_m`: over as many before these.
    """
    rows = []
    for delay in delays_ticks:
        stiffness = BOUND_SHARE * bound_n_per_m(delay)
        near_bound = stiffened(stiffness)
        couplings: list[tuple[str, dict[str, Any]]] = [("its own", {})]
        if near_bound is not None:
            couplings.append((f"{stiffness:,.0f} N/m", near_bound))
        for name, options in couplings:
            face = make(_wall(), _block(), seed=seed, **options)
            start, wanted = pose((0, 0, 0.002)), pose((0, 0, -0.005))
            hand = hands.Hand(start, delay_ticks=delay)
            heights, sizes = _held(face, hand, start, wanted, SETTLE_S)
            last = round(LOOKED_AT_S / TICK_S)
            rows.append(
                {
                    "coupling": name,
                    "delay_ticks": delay,
                    "swing_m": float(np.ptp(heights[-last:])),
                    "swing_before_m": float(np.ptp(heights[-2 * last : -last])),
                    "unrest_n": float(np.ptp(sizes[-last:])),
                    "force_n": float(sizes[-last:].mean()),
                    "overshoot_m": float(heights[-last:].mean() - heights.min()),
                    "trace_m": [round(float(z), 7) for z in heights[:: max(1, len(heights) // 600)]],
                }
            )
    return {"rows": rows, "hand": vars(hands.Grip()), "seconds": SETTLE_S}


def release(make: Callable[..., Face], seed: int = 0, delays_ticks: Sequence[int] = (0, 1, 3)) -> dict[str, Any]:
    """A device held at depth, then let go.

    `stored_j`: energy that the hand put in until then; the device must not fly off with more.
    """
    rows = []
    for depth in RELEASE_DEPTHS_M:
        for delay in delays_ticks:
            face = make(_wall(), _block(), seed=seed)
            start, wanted = pose((0, 0, 0.002)), pose((0, 0, -depth))
            strong = hands.Grip(stiffness_n_per_m=5000.0, damping_ns_per_m=70.0)
            hand = hands.Hand(start, strong, delay)
            face.start(start)
            step, stored = face.step(start), 0.0
            ticks = round(0.5 / TICK_S)
            for k in range(2 * ticks):
                share = min(1.0, k / ticks)
                before = hand.pose
                at = hand.tick(pose((0, 0, 0.002 - share * (0.002 + depth))), step.force, step.torque)
                stored -= hands.work_j(before, at, step.force, step.torque)
                step = face.step(at)
            held = float(np.linalg.norm(step.force))
            sunk = -float(hand.pose[2, 3])
            hand.grip = hands.LOOSE
            sizes, kinetic, heights = [], [], []
            for _ in range(round(RELEASE_S / TICK_S)):
                at = hand.tick(wanted, step.force, step.torque)
                step = face.step(at)
                sizes.append(float(np.linalg.norm(step.force)))
                kinetic.append(hand.kinetic_j)
                heights.append(float(at[2, 3]))
            rows.append(
                {
                    "depth_m": depth,
                    "delay_ticks": delay,
                    "held_n": held,
                    "sunk_m": sunk,
                    "stored_j": stored,
                    "largest_n": max(sizes),
                    "bound_n": getattr(getattr(face, "coupling", None), "max_force_n", None),
                    "kinetic_j": max(kinetic),
                    "speed_m_per_s": math.sqrt(2.0 * max(kinetic) / hands.LOOSE.mass_kg),
                    "is_out": bool(heights[-1] > 0.0),
                }
            )
    return {"rows": rows}


def _held(face: Face, hand: hands.Hand, start: Floats, wanted: Floats, seconds: float) -> tuple[Floats, Floats]:
    """Heights of the device and sizes of the force at each tick of a hand that wants to be somewhere."""
    face.start(start)
    step = face.step(start)
    heights, sizes = [], []
    for _ in range(round(seconds / TICK_S)):
        at = hand.tick(wanted, limited(np.asarray(step.force), 1e3), np.asarray(step.torque))
        step = face.step(at)
        heights.append(float(at[2, 3]))
        sizes.append(float(np.linalg.norm(step.force)))
    return np.array(heights), np.array(sizes)


def _wall() -> feeler.Scene:
    return feeler.Scene(mockup_of(box((0.2, 0.2, 0.02), (0, 0, -0.01), 1)), threads=1)


def _block() -> feeler.Tool:
    return tool_of(box((0.03, 0.02, 0.04), (0.0, 0.0, 0.02), 1))
