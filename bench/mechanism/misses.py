"""Hinges whose least gap is known, asked at 121 positions by what steps, and over all of them by feeler."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import feeler
from feeler import Joint, JointKind, Mechanism

from .steppers import FeelerStepper, Floats, Stepper

Result = dict[str, Any]
STEPS = 121
ERROR_M = 1e-6
RANGE = (0.0, 1.9)
Z = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Case:
    """A body that turns about z, and what stands; the least gap over the range, metres, 0 where they meet."""

    name: str
    moving: list[tuple[Floats, Floats]]
    standing: list[tuple[Floats, Floats]]
    truth: float


def cuboid(low: Sequence[float], high: Sequence[float], turned: float = 0.0) -> tuple[Floats, Floats]:
    """A box, turned about z."""
    lower, upper = np.array(low, dtype=float), np.array(high, dtype=float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])
    turn = np.array([[math.cos(turned), -math.sin(turned), 0], [math.sin(turned), math.cos(turned), 0], [0, 0, 1]])
    return (lower + corners * (upper - lower)) @ turn.T, faces


def cases() -> list[Case]:
    """The corner of a door passes a post closest between two steps; a thin door passes a thin sheet between two; a door
    with a window goes round a bar that its hull holds."""
    middle = 0.5 * (STEPS - 0.5) * RANGE[1] / (STEPS - 1)  # half way between two steps
    leaf = cuboid((0.1, -0.0001, 0.0), (1.0, 0.0001, 1.0))
    reach = math.hypot(1.0, 0.0001)
    angle = math.atan2(0.0001, 1.0)
    near = 0.002
    edge = cuboid((reach + near, -0.05, 0.2), (1.2, 0.05, 0.8), middle + angle)
    sheet = cuboid((0.5, -0.0001, 0.2), (0.9, 0.0001, 0.8), middle)
    window = [
        cuboid((0.1, -0.01, 0.0), (1.0, 0.01, 0.2)),
        cuboid((0.1, -0.01, 0.8), (1.0, 0.01, 1.0)),
        cuboid((0.1, -0.01, 0.0), (0.2, 0.01, 1.0)),
        cuboid((0.9, -0.01, 0.0), (1.0, 0.01, 1.0)),
    ]
    bar = cuboid((0.4, -0.01, 0.45), (0.6, 0.01, 0.55), 0.9)
    return [
        Case("a corner passes a post, closest between two steps", [leaf], [edge], near),
        Case("a door of 0.2 mm passes a sheet of 0.2 mm", [leaf], [sheet], 0.0),
        Case("a door with a window goes round a bar", window, [bar], 0.4 - math.hypot(0.2, 0.01)),
    ]


def measured(steppers: Sequence[Stepper]) -> Result:
    """The gaps that each finds."""
    rows = []
    for case in cases():
        moved = mechanism(case)
        found = moved.clearance({"hinge": RANGE}, error=ERROR_M)
        values = np.linspace(*RANGE, STEPS)
        poses = np.array([moved.poses({"hinge": float(value)})["hinge"] for value in values])
        tool, around = feeler.Tool.of_parts(moved.mockup, "door"), moved.mockup
        standing = one_part(case.standing, "wall")
        gaps = {each.name: each.least(tool, standing)(poses) for each in [FeelerStepper(), *steppers]}
        assert around.part_count == 2
        rows.append({"case": case.name, "truth": case.truth, "lower": found.lower, "upper": found.upper, "gaps": gaps})
    return {"steps": STEPS, "error": ERROR_M, "cases": rows}


def one_part(meshes: list[tuple[Floats, Floats]], name: str) -> feeler.Mockup:
    """A mock-up of one part."""
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = np.concatenate([faces + count for (_, faces), count in zip(meshes, counts, strict=False)])
    return feeler.Mockup(np.concatenate([vertices for vertices, _ in meshes]), faces, np.zeros(len(faces), int), [name])


def mechanism(case: Case) -> Mechanism:
    """The case as a hinge."""
    door, wall = one_part(case.moving, "door"), one_part(case.standing, "wall")
    faces = np.concatenate([door.faces, np.asarray(wall.faces) + len(door.vertices)])
    parts = np.repeat([0, 1], [len(door.faces), len(wall.faces)])
    mockup = feeler.Mockup(np.concatenate([door.vertices, wall.vertices]), faces, parts, ["door", "wall"])
    return Mechanism(mockup, [Joint("hinge", JointKind.REVOLUTE, None, "door", Z)])
