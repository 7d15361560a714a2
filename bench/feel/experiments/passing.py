"""Motions against thin objects: does the tool ever pass through, is the proxy ever in collision?

Each run throws a spinning tool at one thin object, continues well beyond it, and drags on there. The number of the run
selects tool, direction, spin and speed. Everything is rotated as a whole, so that nothing lies along an axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

import feeler

from .. import scenes
from ..faces import TICK_S, Face
from ..meshes import Floats, Mesh, mockup_of, tool_of, turned_mesh
from ..poses import placed, pose, random_turn, rotation_vector

SPEEDS_M_PER_S = (0.1, 1.0, 3.0)
BEYOND_M = 0.04  # how far the device goes past the obstacle
SPIN_RAD_PER_S = 20.0  # at most
SLANT_RAD = np.radians(50.0)  # at most, from straight on
DRAG_TICKS = 40
FRAME_SHIFT_M = 0.2


@dataclass(frozen=True)
class Throw:
    """One run: mock-up, tool, device poses; and whether it passed, by proxy poses in the frame of the thin thing."""

    kind: str
    tool_name: str
    speed: float
    mockup: Mesh
    tool: Mesh
    path: Floats
    frame: Floats
    has_passed: Callable[[Floats], bool]


def throw(index: int, seed: int = 0) -> Throw:
    """Run `index` of a seed."""
    rng = np.random.default_rng([seed, index])
    kind = tuple(KINDS)[index % len(KINDS)]
    speed = SPEEDS_M_PER_S[index // len(KINDS) % len(SPEEDS_M_PER_S)]
    mockup, tool_name, tool, path, passed = KINDS[kind](rng, speed)
    frame = pose(rng.uniform(-FRAME_SHIFT_M, FRAME_SHIFT_M, 3))
    frame[:3, :3] = random_turn(rng)
    return Throw(kind, tool_name, speed, turned_mesh(mockup, frame), tool, frame @ path, frame, passed)


Made = tuple[Mesh, str, Mesh, Floats, Callable[[Floats], bool]]


def _across(mockup: Mesh) -> Callable[[np.random.Generator, float], Made]:
    """Onto something that fills the plane z = 0 as far as the tool gets: it passed if it is ever wholly below."""

    def make(rng: np.random.Generator, speed: float) -> Made:
        name, tool = _tool(rng)
        reach = float(np.sqrt((tool[0] ** 2).sum(axis=1)).max())
        slant, around = rng.uniform(0.0, SLANT_RAD), rng.uniform(0.0, 2 * np.pi)
        way = np.array([np.sin(slant) * np.cos(around), np.sin(slant) * np.sin(around), -np.cos(slant)])
        start = pose((*rng.uniform(-0.02, 0.02, 2), reach + 0.001))
        start[:3, :3] = random_turn(rng)
        path = _path(rng, start, way, speed, (reach + BEYOND_M) / np.cos(slant))

        def passed(proxies: Floats) -> bool:
            return any(placed(tool[0], at)[:, 2].max() < 0.0 for at in proxies)

        return mockup, name, tool, path, passed

    return make


def _edge(rng: np.random.Generator, speed: float) -> Made:
    """Onto the edge of a half sheet: it passed if it is on one side and then on the other, never in between.

    A tick may take it around the edge, where the device pulls it there: a change of sides counts where the device, or
    the tool before or after, is wholly over the sheet, whose edge is then not in the way's reach.
    """
    name, tool = _tool(rng)
    reach = float(np.sqrt((tool[0] ** 2).sum(axis=1)).max())
    slant, around = rng.uniform(0.0, SLANT_RAD), rng.uniform(0.0, 2 * np.pi)
    way = np.array([-np.cos(slant), np.sin(slant) * np.cos(around), np.sin(slant) * np.sin(around)])
    start = pose((reach + 0.001, 0.0, rng.uniform(-0.5, 0.5) * reach))
    start[:3, :3] = random_turn(rng)
    path = _path(rng, start, way, speed, (reach + BEYOND_M) / np.cos(slant))

    def is_over(at: Floats) -> bool:
        return bool(placed(tool[0], at)[:, 0].max() < 0.0)

    def passed(proxies: Floats) -> bool:
        before, last = 0, proxies[0]
        for at, device in zip(proxies, path, strict=False):
            heights = placed(tool[0], at)[:, 2]
            side = 1 if heights.min() > 0.0 else -1 if heights.max() < 0.0 else 0
            if side * before < 0 and (is_over(device) or is_over(last) or is_over(at)):
                return True
            before, last = side, at
        return False

    return scenes.half_sheet(), name, tool, path, passed


def _threaded(rng: np.random.Generator, speed: float) -> Made:
    """A ring on a wire, torn away: it passed if the wire's middle line ever does not go through it any more."""
    radius = 0.02
    tool = scenes.thread_ring(radius)
    start = pose(
        (0.0, rng.uniform(-0.02, 0.02), 0.0), (np.pi / 2 + rng.uniform(-0.4, 0.4), 0.0, rng.uniform(-0.4, 0.4))
    )
    way = rng.normal(size=3) * np.array([1.0, 0.3, 1.0])
    path = _path(rng, start, way / np.sqrt(way @ way), speed, 2 * radius + BEYOND_M)

    def passed(proxies: Floats) -> bool:
        for at in proxies:
            axis, centre = at[:3, 2], at[:3, 3]
            if abs(axis[1]) < 1e-9:
                return True
            # where the y axis meets the ring's plane
            meets = np.array([0.0, float(axis @ centre) / axis[1], 0.0])
            if np.sqrt(((meets - centre) ** 2).sum()) > radius:
                return True
        return False

    return scenes.wire(), "ring", tool, path, passed


def _tool(rng: np.random.Generator) -> tuple[str, Mesh]:
    tools = scenes.thin_tools()
    name = sorted(tools)[int(rng.integers(len(tools)))]
    return name, tools[name]


def _path(rng: np.random.Generator, start: Floats, way: Floats, speed: float, length: float) -> Floats:
    """Straight on at a speed while spinning; then sideways, still spinning."""
    axis = rng.normal(size=3)
    spin = axis / np.sqrt(axis @ axis) * rng.uniform(0.0, SPIN_RAD_PER_S)
    aside = np.cross(way, rng.normal(size=3))
    aside /= np.sqrt(aside @ aside)
    ticks = int(np.ceil(length / (speed * TICK_S))) + 1
    made = []
    for k in range(ticks + DRAG_TICKS):
        on, beside = min(k, ticks - 1), max(0, k - ticks + 1)
        at = pose((0.0, 0.0, 0.0), spin * (k * TICK_S)) @ start
        at[:3, 3] = start[:3, 3] + speed * TICK_S * (on * way + beside * aside)
        made.append(at)
    return np.array(made)


KINDS: dict[str, Callable[[np.random.Generator, float], Made]] = {
    "sheet": _across(scenes.thin_sheet()),
    "wires": _across(scenes.wires()),
    "strips": _across(scenes.strips()),
    "edge": _edge,
    "ring on a wire": _threaded,
}


def one(make: Callable[..., Face], index: int, seed: int = 0) -> dict[str, Any]:
    """A run: its kind and speed, how many steps, how many of them with the proxy in collision, whether it passed."""
    run = throw(index, seed)
    scene, tool = feeler.Scene(mockup_of(run.mockup), threads=1), tool_of(run.tool, run.tool_name)
    face = make(scene, tool, seed=seed)
    face.start(run.path[0])
    proxies = np.array([np.array(face.step(at).world_from_proxy) for at in run.path])
    batch = scene.collide_batch(tool, proxies)
    colliding = int((np.diff(np.asarray(batch.offsets).astype(np.int64)) > 0).sum())
    own = np.linalg.inv(run.frame) @ proxies
    left = rotation_vector(run.path[-1][:3, :3] @ proxies[-1][:3, :3].T)
    return {
        "index": index,
        "kind": run.kind,
        "tool": run.tool_name,
        "speed_m_per_s": run.speed,
        "steps": len(run.path),
        "colliding_steps": colliding,
        "passed": bool(run.has_passed(own)),
        "left_behind_m": float(np.sqrt(((run.path[-1] - proxies[-1])[:3, 3] ** 2).sum())),
        "left_behind_rad": float(np.sqrt(left @ left)),
    }


def summary(found: list[dict[str, Any]], seed: int = 0) -> dict[str, Any]:
    """A row for each kind and speed, and the runs that passed or collided, to be done again alone (`one`)."""
    return {"runs": len(found), "seed": seed, "rows": list(_rows(found)), "bad": [r for r in found if _is_bad(r)][:100]}


def _is_bad(result: dict[str, Any]) -> bool:
    return bool(result["passed"] or result["colliding_steps"])


def _rows(found: list[dict[str, Any]]) -> Iterable[dict[str, Any]]:
    for kind in KINDS:
        for speed in SPEEDS_M_PER_S:
            own = [r for r in found if r["kind"] == kind and r["speed_m_per_s"] == speed]
            if own:
                yield {
                    "kind": kind,
                    "speed_m_per_s": speed,
                    "runs": len(own),
                    "passed": sum(r["passed"] for r in own),
                    "steps": sum(r["steps"] for r in own),
                    "colliding_steps": sum(r["colliding_steps"] for r in own),
                }
