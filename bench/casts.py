"""Measures `scene.cast` over short motions from near poses, beside parry's shape casts.

    python bench/casts.py                                    1.6M triangles, 100 poses, 20 mm, 0 and 10 degrees
    python bench/casts.py --triangles 400000 --poses 40 --no-parry

From each near pose (among the parts, without a collision) the tool's middle moves 20 mm in a random direction, and the
tool turns about it. For each motion the least time of a few rounds counts, on one core. Without a rotation parry uses
its linear cast, else its nonlinear one. A cast of parry that takes longer than a second runs once, and a row whose
casts take longer than --patience is cut off: its figures are then of the motions done by that time.
"""

from __future__ import annotations

import argparse
import functools
import time
from typing import Any

import numpy as np
from engines import Floats
from measure import clock_once, find_poses, spread
from native import AbsentError
from parry_engine import ParryEngine

import feeler

TOOLS = ("torque", "wrench", "hand", "hand:fine")
SECOND_US = 1e6


def main() -> None:
    """Run and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=1_600_000)
    parser.add_argument("--poses", type=int, default=100)
    parser.add_argument("--way", type=float, default=0.02, help="metres")
    parser.add_argument("--turns", type=float, nargs="+", default=[0.0, 10.0], help="degrees")
    parser.add_argument("--tools", nargs="+", default=list(TOOLS))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--no-parry", action="store_true")
    parser.add_argument("--patience", type=float, default=120.0, help="seconds for parry's casts of a row (120)")
    given = parser.parse_args()
    mockup = feeler.sample("engine", given.triangles)
    scene = feeler.Scene(mockup, threads=1)
    parry = None if given.no_parry else parry_with(mockup)
    print("| tool | triangles | turn, degrees | hits | feeler | parry | its motions | earlier by 1 % | later by 1 % |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for name in given.tools:
        sample, _, fine = name.partition(":")
        tool = feeler.sample_tool(sample, fine=bool(fine))
        poses = find_poses(scene, tool, "near", given.poses)
        if parry is not None:
            parry.prepare(tool)
        for turn in given.turns:
            label = f"{name.replace(':', '-')} | {tool.triangle_count:,} | {turn:g}"
            random = np.random.default_rng(0)
            motions = [(pose, *motion(tool, pose, given.way, turn, random)) for pose in poses]
            print(f"| {label} | {row(scene, tool, parry, motions, given.rounds, given.patience)} |", flush=True)
    print(
        f"\nOver {1000 * given.way:g} mm from near poses of `engine`, {mockup.triangle_count:,} triangles, one core, "
        f"microseconds: median (p95; worst) over {given.poses} motions. Its motions: those parry came to in "
        f"{given.patience:g} s; earlier, later: of these, where its impact is so by more than 1 % of the way."
    )


def parry_with(mockup: feeler.Mockup) -> ParryEngine | None:
    """parry, if it is there."""
    try:
        engine = ParryEngine()
    except AbsentError as why:
        print(f"without parry: {why}")
        return None
    engine.build(mockup, 1)
    return engine


def motion(
    tool: feeler.Tool, pose: Floats, way_m: float, turn_deg: float, random: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """A random way and turn of the tool's middle, and the pose at its end."""
    one, other = random.normal(size=(2, 3))
    way: Floats = way_m * one / np.linalg.norm(one)
    turn: Floats = np.radians(turn_deg) * other / np.linalg.norm(other)
    return way, turn, moved(pose, tool.bounds.mean(axis=0), way, turn)


def row(
    scene: feeler.Scene,
    tool: feeler.Tool,
    parry: ParryEngine | None,
    motions: list[tuple[Floats, Floats, Floats, Floats]],
    rounds: int,
    patience_s: float,
) -> str:
    """The cells of one line."""
    centre = tool.bounds.mean(axis=0)
    ours, own = np.full(len(motions), np.inf), np.full(len(motions), 2.0)
    for i, (pose, _, _, end) in enumerate(motions):
        for _ in range(rounds):
            ours[i] = min(ours[i], clock_once(functools.partial(scene.cast, tool, pose, end))[0])
        if (hit := scene.cast(tool, pose, end)) is not None:
            own[i] = hit.fraction
    hits = f"{(own <= 1).sum()} of {len(motions)}"
    if parry is None:
        return " | ".join([hits, cell(ours), "", "0", "", ""])
    theirs, fractions, begun = [], [], time.monotonic()
    for pose, way, turn, _ in motions:
        fraction, us = parry_cast(parry, pose, centre, way, turn, rounds)
        theirs.append(us)
        fractions.append(fraction)
        if time.monotonic() - begun > patience_s:
            break
    other, own = np.array(fractions), own[: len(fractions)]
    counts = [str(len(other)), str((other < own - 0.01).sum()), str((other > own + 0.01).sum())]
    return " | ".join([hits, cell(ours), cell(np.array(theirs)), *counts])


def parry_cast(
    parry: ParryEngine, pose: Floats, centre: Floats, way: Floats, turn: Floats, rounds: int
) -> tuple[float, float]:
    """The fraction of the way up to parry's impact (2: none), and microseconds."""
    call, fractions, best = parry.aim_cast(pose, centre, way, turn), [], np.inf
    for _ in range(rounds):
        best = min(best, clock_once(lambda: fractions.append(call()))[0])
        if best > SECOND_US:
            break
    return float(fractions[0]), best


def cell(us: Floats) -> str:
    """Median, p95 and worst."""
    figures: dict[str, Any] = spread(us)
    return f"{figures['median']:,.0f} ({figures['p95']:,.0f}; {figures['worst']:,.0f})"


def moved(pose: Floats, centre: Floats, way: Floats, turn: Floats) -> Floats:
    """The pose after the tool's point `centre` has moved by `way` and the tool has turned about it by `turn`."""
    end: Floats = pose.copy()
    angle = np.linalg.norm(turn)
    if angle > 0:
        x, y, z = turn / angle
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        end[:3, :3] = (np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k) @ pose[:3, :3]
    end[:3, 3] = pose[:3, :3] @ centre + pose[:3, 3] + way - end[:3, :3] @ centre
    return end


if __name__ == "__main__":
    main()
