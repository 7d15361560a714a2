"""Pegs into holes by an unsteady hand, and known paths: puzzles, a hexagon key, parts of the engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import feeler

from .. import engine_parts, fits, hands, puzzles
from ..faces import TICK_S, Face
from ..meshes import Floats, mockup_of, tool_of
from ..poses import placed, pose, rotation_vector

DEPTH_M = 0.03
ABOVE_M = 0.004
AT_BOTTOM_M = 0.0002
PATIENCE_S = 6.0
WAY_M_PER_S = 0.05
WAY_RAD_PER_S = 2.0
WAY_OFF = 3.0  # how far the hand is off a known way, aside, in clearances: it must be led
WAY_OFF_M = (0.0003, 0.008)  # and never less or more than this
FADE_S = 0.3
KEPT_UP_M = 0.002


def pegs(
    make: Callable[..., Face],
    seeds: int = 20,
    names: tuple[str, ...] = ("H11/c11", "H7/g6"),
    shapes: tuple[str, ...] = fits.SHAPES,
    tick: Callable[[], object] | None = None,
) -> dict[str, Any]:
    """Each fit and shape, pushed in by each seed's hand."""
    rows = []
    for name in names:
        for shape in shapes:
            pair = fits.peg_in_hole(name, shape, depth=DEPTH_M, length=DEPTH_M + 0.02)
            scene, tool = feeler.Scene(mockup_of(pair.hole), threads=1), tool_of(pair.peg, "peg")
            for seed in range(seeds):
                rows.append({"fit": name, "shape": shape, "seed": seed, **_pushed(make, scene, tool, pair, seed)})
                if tick is not None:
                    tick()
    return {"rows": rows, "off_m": hands.OFF_M, "off_rad": float(hands.OFF_RAD), "depth_m": DEPTH_M}


def _pushed(
    make: Callable[..., Face], scene: feeler.Scene, tool: feeler.Tool, pair: fits.PegInHole, seed: int
) -> dict[str, Any]:
    face = make(scene, tool, seed=seed)
    wants = hands.unsure(np.eye(4), DEPTH_M, seed, above=ABOVE_M)
    start = next(wants)
    hand = hands.Hand(start)
    face.start(start)
    step = face.step(start)
    forces, torques, proxies = [], [], []
    bottom: float | None = None
    for k in range(round(PATIENCE_S / TICK_S)):
        step = face.step(hand.tick(next(wants), np.asarray(step.force), np.asarray(step.torque)))
        forces.append(float(np.linalg.norm(step.force)))
        torques.append(float(np.linalg.norm(step.torque)))
        proxies.append(np.array(step.world_from_proxy))
        if proxies[-1][2, 3] < -DEPTH_M + AT_BOTTOM_M:
            bottom = (k + 1) * TICK_S
            break
    return {
        "is_in": bottom is not None,
        "seconds": bottom,
        "reached_m": -float(min(at[2, 3] for at in proxies)),
        "clearance_m": pair.clearance,
        "force_median_n": float(np.median(forces)),
        "force_max_n": max(forces),
        "torque_max_nm": max(torques),
        "steps": len(proxies),
        "colliding_steps": colliding(scene, tool, np.array(proxies)),
    }


def colliding(scene: feeler.Scene, tool: feeler.Tool, poses: Floats) -> int:
    """At how many poses something meets, by the exact test."""
    return int((np.diff(np.asarray(scene.collide_batch(tool, poses).offsets).astype(np.int64)) > 0).sum())


def ways(make: Callable[..., Face], engine_triangles: int | None = 1_600_000) -> dict[str, Any]:
    """The known ways, each gone out and, from there, back in; the device a little off them."""
    rows = []
    for puzzle in (puzzles.alpha(), puzzles.coils(), puzzles.hexagon_key()):
        scene, tool = feeler.Scene(mockup_of(puzzle.mockup), threads=1), tool_of(puzzle.tool, puzzle.name)
        rows += _there_and_back(make, puzzle.name, scene, tool, puzzle.way, puzzle.clearance)
    if engine_triangles is not None:
        scene = feeler.Scene(feeler.sample("engine", engine_triangles))
        for removal in engine_parts.removals(scene):
            clearance = removal.scene.distance(removal.tool, removal.way[0]).value
            rows += _there_and_back(make, removal.name, removal.scene, removal.tool, removal.way, clearance)
            rows[-1]["left_out"] = rows[-2]["left_out"] = list(removal.left_out)
    return {"rows": rows}


def _there_and_back(
    make: Callable[..., Face], name: str, scene: feeler.Scene, tool: feeler.Tool, way: Floats, clearance: float
) -> list[dict[str, Any]]:
    is_free = bool(scene.check_path(tool, way).is_free)
    rows = []
    for direction, knots in (("out", way), ("in", way[::-1])):
        face = make(scene, tool, seed=0)
        path = _off(hands.along(knots, WAY_M_PER_S, WAY_RAD_PER_S), float(np.clip(WAY_OFF * clearance, *WAY_OFF_M)))
        face.start(path[0])
        forces, proxies = [], []
        for at in [*path, *([path[-1]] * 50)]:
            step = face.step(at)
            forces.append(float(np.linalg.norm(step.force)))
            proxies.append(np.array(step.world_from_proxy))
        middle = np.asarray(tool.bounds).mean(axis=0)[None]
        left = placed(middle, proxies[-1]) - placed(middle, path[-1])
        turn = rotation_vector(proxies[-1][:3, :3] @ path[-1][:3, :3].T)
        rows.append(
            {
                "way": name,
                "direction": direction,
                "is_free": is_free,
                "clearance_m": clearance,
                "steps": len(proxies),
                "colliding_steps": colliding(scene, tool, np.array(proxies)),
                "force_max_n": max(forces),
                "left_behind_m": float(np.linalg.norm(left)),
                "left_behind_rad": float(np.linalg.norm(turn)),
                "is_there": bool(np.linalg.norm(left) < KEPT_UP_M and np.linalg.norm(turn) < 0.1),
                "left_out": [],
            }
        )
    return rows


def _off(path: Floats, far: float) -> Floats:
    """A path that strays aside that far, slowly; at its ends it is as it was."""
    time = np.arange(len(path)) * TICK_S
    fade = np.minimum(1.0, np.minimum(time, time[::-1]) / FADE_S)
    aside = far * fade[:, None] * np.stack([np.sin(9 * time), np.cos(9 * time), np.sin(7 * time)], axis=1)
    return np.array([pose(shift) @ at for shift, at in zip(aside, path, strict=True)])
