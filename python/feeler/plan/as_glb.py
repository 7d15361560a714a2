"""Removal paths as an animated GLB: the moving parts, their blockers, and the parts nearby."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence

import numpy as np

from feeler.atomic import atomic_file
from feeler.errors import OptionError
from feeler.io.body import LIGHT_GREY, RED, STEEL_BLUE, FloatArray, body_of
from feeler.io.export import animated_glb
from feeler.io.film import PAUSE_S, moments, motion_of, with_neighbours
from feeler.mockup import Mockup, Tool
from feeler.plan.order import RemovalStep
from feeler.plan.removal import Removal
from feeler.poses import between, rotation_vector

STEP_RAD = 0.1
"""The largest turn from pose to pose in a film: at 0.1 rad, the poses in between are off by 1/800 of the radius."""
MOST_BLOCKERS = 20


def write_removal_glb(
    path: str | os.PathLike[str],
    mockup: Mockup,
    steps: Sequence[RemovalStep],
    tool: Tool | None = None,
    start: FloatArray | None = None,
) -> int:
    """Writes the steps one after the other as a binary glTF 2.0 film; returns its size in bytes.

    Moving parts are blue, blockers of parts without a way red, parts nearby grey. A part without a way shows its best
    attempt. tool: moves with the parts of the last step, at the pose `start` in the world. Raises `WriteError`,
    `MeshError`, and `OptionError` for steps of another mock-up.
    """
    _check_same(mockup, steps)
    moving = sorted({part for step in steps for part in step.parts})
    blockers = sorted(
        {
            int(each.part)
            for step in steps
            if not step.removal.is_found
            for each in step.removal.blocked_by[:MOST_BLOCKERS]
        }
    )
    shown = sorted({*with_neighbours(mockup, moving), *blockers})
    place = {part: number for number, part in enumerate(shown)}
    colours = np.tile(np.array(LIGHT_GREY), (len(shown), 1))
    colours[[place[part] for part in blockers]] = RED
    colours[[place[part] for part in moving]] = STEEL_BLUE
    scene = Tool.of_parts(mockup, shown, "removal")
    held = [] if tool is None else list(range(len(shown), len(shown) + tool.part_count))
    if tool is not None:
        at = np.eye(4) if start is None else start
        scene = Tool.assembly({"removal": scene, "tool": (tool, at)}, "removal")
        colours = np.concatenate([colours, np.tile(np.array(STEEL_BLUE), (len(held), 1))])
    motions = []
    now = 0.0
    for number, step in enumerate(steps):
        held_here = tool if number == len(steps) - 1 else None
        bounds = bounds_of(mockup, step.parts, held_here, start)
        poses = in_steps(shown_way(step.removal), bounds.mean(axis=0))
        times = now + moments(poses, bounds)
        together = [place[part] for part in step.parts] + (held if number == len(steps) - 1 else [])
        # A part rests before and after its motion.
        whole = np.concatenate([[0.0], times]) if now > 0.0 else times
        path_of = np.concatenate([np.eye(4)[None], poses]) if now > 0.0 else poses
        motions += [motion_of(each, whole, path_of) for each in together]
        now = float(times[-1]) + PAUSE_S
    with atomic_file(path, ".glb") as file:
        data = animated_glb(body_of(scene, colours=colours), motions)
        file.write(data)
    return len(data)


def _check_same(mockup: Mockup, steps: Sequence[RemovalStep]) -> None:
    named = [(each.part, each.path) for step in steps for each in step.removal.blocked_by]
    is_there = all(part < mockup.part_count for step in steps for part in step.parts)
    if not is_there or any(tuple(mockup.part_paths[part : part + 1]) != (path,) for part, path in named):
        raise OptionError("the steps are of another mock-up: give the mock-up that the parts come out of")


def shown_way(removal: Removal) -> FloatArray:
    """The way `(n, 4, 4)`; if none was found, from the part's place to the end of its best attempt."""
    if removal.is_found or not removal.blocked_by:
        return removal.poses
    return np.stack([np.eye(4), max(removal.blocked_by, key=lambda each: each.reach).pose])


def bounds_of(mockup: Mockup, parts: Sequence[int], tool: Tool | None, start: FloatArray | None) -> FloatArray:
    """The box `(2, 3)` of the moving parts; its middle moves straight from pose to pose."""
    moving = Tool.of_parts(mockup, list(parts))
    if tool is not None:
        moving = Tool.assembly({"parts": moving, "tool": (tool, np.eye(4) if start is None else start)})
    bounds: FloatArray = moving.bounds
    return bounds


def in_steps(poses: FloatArray, middle: FloatArray) -> FloatArray:
    """The way with more poses where it turns: a film moves the origin straight, a way the middle of the box."""
    way = [poses[0]]
    for before, after in itertools.pairwise(poses):
        angle = float(np.linalg.norm(rotation_vector(after[:3, :3] @ before[:3, :3].T)))
        steps = max(1, math.ceil(angle / STEP_RAD))
        way += [between(before, after, middle, step / steps) for step in range(1, steps + 1)]
    return np.stack(way)
