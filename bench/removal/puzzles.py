"""What is to be taken out: linked tubes, pegs in tight holes, a box that nothing leads out of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import feeler

from .alpha import Floats, Mesh, alpha

MOVING = "moving"
PEG_RADIUS, PEG_LENGTH = 0.01, 0.04
SIDES = 64
TILT = (0.3, -0.5, 0.7)
"""Radians about x, y and z: no way out lies along an axis of the world."""


@dataclass(frozen=True)
class Puzzle:
    """A mock-up of two parts, one of which is named `MOVING`. has_way: whether there is a way out."""

    name: str
    make: Callable[[], feeler.Mockup]
    has_way: bool = True


def peg(share: float) -> feeler.Mockup:
    """A peg at the bottom of a blind hole, wider by a share of its radius all around, and as much below."""
    gap = share * PEG_RADIUS
    wall = PEG_RADIUS + gap
    outline = [(0.0, -gap), (wall, -gap), (wall, PEG_LENGTH), (3.0 * wall, PEG_LENGTH), (3.0 * wall, -2.0 * wall)]
    block = turned_around([*outline, (0.0, -2.0 * wall)])
    moving = turned_around([(0.0, 1.5 * PEG_LENGTH), (PEG_RADIUS, 1.5 * PEG_LENGTH), (PEG_RADIUS, 0.0), (0.0, 0.0)])
    return mockup_of(block, moving)


def closed_box() -> feeler.Mockup:
    """A box in the hollow of another that has room to turn in, and no opening."""
    outer, inner, moving = cuboid(0.1), cuboid(0.09), cuboid(0.03)
    walls = np.concatenate([outer[1], inner[1][:, ::-1] + len(outer[0])])
    return mockup_of((np.concatenate([outer[0], inner[0]]), walls), moving)


def tubes(stretch: float) -> feeler.Mockup:
    """The linked tubes."""
    return mockup_of(*alpha(stretch), tilt=(0.0, 0.0, 0.0))


def mockup_of(obstacle: Mesh, moving: Mesh, tilt: tuple[float, float, float] = TILT) -> feeler.Mockup:
    """Both as parts, tilted."""
    turn = rotation(tilt)
    vertices = np.concatenate([obstacle[0], moving[0]]) @ turn.T
    faces = np.concatenate([obstacle[1], moving[1] + len(obstacle[0])])
    part = np.repeat([0, 1], [len(obstacle[1]), len(moving[1])])
    return feeler.Mockup(vertices, faces, part_of_face=part, part_names=["obstacle", MOVING])


def rotation(angles: tuple[float, float, float]) -> Floats:
    """About x, then y, then z."""
    turn = np.eye(3)
    for axis, angle in enumerate(angles):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        one = np.eye(3)
        one[i, i] = one[j, j] = np.cos(angle)
        one[j, i], one[i, j] = np.sin(angle), -np.sin(angle)
        turn = one @ turn
    return turn


def turned_around(outline: list[tuple[float, float]]) -> Mesh:
    """An outline of radius and height, from axis to axis, turned around z in `SIDES` steps."""
    turns = 2.0 * np.pi * np.arange(SIDES) / SIDES
    rings = [np.stack([r * np.cos(turns), r * np.sin(turns), np.full(SIDES, z)], axis=1) for r, z in outline[1:-1]]
    ends = np.array([(0.0, 0.0, outline[0][1]), (0.0, 0.0, outline[-1][1])])
    vertices = np.concatenate([*rings, ends])
    k = np.arange(SIDES)
    after = (k + 1) % SIDES
    faces: list[npt.NDArray[np.int64]] = [np.stack([np.full(SIDES, len(vertices) - 2), k, after], axis=1)]
    for ring in range(len(rings) - 1):
        a, b, up = ring * SIDES + k, ring * SIDES + after, SIDES
        faces += [np.stack([a, a + up, b + up], axis=1), np.stack([a, b + up, b], axis=1)]
    top = (len(rings) - 1) * SIDES
    faces.append(np.stack([np.full(SIDES, len(vertices) - 1), top + after, top + k], axis=1))
    return vertices, np.concatenate(faces)


def cuboid(side: float) -> Mesh:
    """About the origin, outside outwards."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * (0.5 * side)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


PUZZLES = [
    Puzzle("peg, 1 %", lambda: peg(0.01)),
    Puzzle("peg, 0.1 %", lambda: peg(0.001)),
    Puzzle("tubes, 1.6", lambda: tubes(1.6)),
    Puzzle("tubes, 1.2", lambda: tubes(1.2)),
    Puzzle("tubes, 1.0", lambda: tubes(1.0)),
    Puzzle("closed box", closed_box, has_way=False),
]
BY_NAME = {puzzle.name: puzzle for puzzle in PUZZLES}
