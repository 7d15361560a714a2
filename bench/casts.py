"""Measures `scene.cast` over short motions from near poses, beside parry's shape casts.

    python bench/casts.py                                    1.6M triangles, 100 poses, 20 mm, 0 and 10 degrees
    python bench/casts.py --triangles 400000 --poses 40 --no-parry

From each near pose (among the parts, nothing collides) the tool's middle moves 20 mm in a random direction, and the
tool turns about it. Per motion the least time of a few rounds counts, one core. parry is asked for its linear cast
where nothing turns, else for its nonlinear one; a cast of it that takes longer than a second is done once.
"""

from __future__ import annotations

import argparse
import functools
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
    given = parser.parse_args()
    mockup = feeler.sample("engine", given.triangles)
    scene = feeler.Scene(mockup, threads=1)
    parry = None if given.no_parry else parry_with(mockup)
    print("| tool | triangles | turn, degrees | hits | feeler, us | parry, us | earlier than feeler's by 1 % | later |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name in given.tools:
        sample, _, fine = name.partition(":")
        tool = feeler.sample_tool(sample, fine=bool(fine))
        poses = find_poses(scene, tool, "near", given.poses)
        if parry is not None:
            parry.prepare(tool)
        for turn in given.turns:
            print(row(name, scene, tool, parry, poses, given.way, turn, given.rounds), flush=True)


def parry_with(mockup: feeler.Mockup) -> ParryEngine | None:
    """parry, if it is there."""
    try:
        engine = ParryEngine()
    except AbsentError as why:
        print(f"without parry: {why}")
        return None
    engine.build(mockup, 1)
    return engine


def row(
    name: str,
    scene: feeler.Scene,
    tool: feeler.Tool,
    parry: ParryEngine | None,
    poses: Floats,
    way_m: float,
    turn_deg: float,
    rounds: int,
) -> str:
    """One line: median (p95; worst) of each."""
    random = np.random.default_rng(0)
    centre = tool.bounds.mean(axis=0)
    ours, theirs, fractions = np.full(len(poses), np.inf), np.full(len(poses), np.inf), []
    for i, pose in enumerate(poses):
        way, axis = (vector / np.linalg.norm(vector) for vector in random.normal(size=(2, 3)))
        way, turn = way_m * way, np.radians(turn_deg) * axis
        end = moved(pose, centre, way, turn)
        for _ in range(rounds):
            ours[i] = min(ours[i], clock_once(functools.partial(scene.cast, tool, pose, end))[0])
        hit = scene.cast(tool, pose, end)
        their_fraction = np.nan
        if parry is not None:
            call = parry.aim_cast(pose, centre, way, turn)
            for _ in range(rounds):
                theirs[i] = min(theirs[i], clock_once(call)[0])
                if theirs[i] > SECOND_US:
                    break
            their_fraction = call()
        fractions.append((2.0 if hit is None else hit.fraction, their_fraction))
    own, other = np.array(fractions).T
    figures = [cell(ours), "" if parry is None else cell(theirs), str((other < own - 0.01).sum())]
    figures.append(str((other > own + 0.01).sum()))
    hits = f"{(own <= 1).sum()} of {len(poses)}"
    return f"| {' | '.join([name, f'{tool.triangle_count:,}', f'{turn_deg:g}', hits, *figures])} |"


def cell(us: Floats) -> str:
    """Median, p95 and worst."""
    figures: dict[str, Any] = spread(us)
    return f"{figures['median']:,.0f} ({figures['p95']:,.0f}; {figures['worst']:,.0f})"


def moved(pose: Floats, centre: Floats, way: Floats, turn: Floats) -> Floats:
    """The pose after the tool's point `centre` has moved by `way` and the tool has turned about it by `turn`."""
    end = pose.copy()
    angle = np.linalg.norm(turn)
    if angle > 0:
        x, y, z = turn / angle
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        end[:3, :3] = (np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k) @ pose[:3, :3]
    end[:3, 3] = pose[:3, :3] @ centre + pose[:3, 3] + way - end[:3, :3] @ centre
    return end


if __name__ == "__main__":
    main()
