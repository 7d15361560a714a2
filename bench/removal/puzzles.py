"""The puzzles: linked tubes, pegs in tight holes, a closed box without a way out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from feel.meshes import Floats, Mesh, box, polygon, regular, stack

import feeler

from .alpha import alpha

MOVING = "moving"
PEG_RADIUS, PEG_LENGTH = 0.01, 0.04
SIDES = 64
TILT = (0.3, -0.5, 0.7)
"""Radians about x, y and z: no way out is parallel to a world axis."""


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
    block = [(wall, -gap), (wall, PEG_LENGTH), (3.0 * wall, PEG_LENGTH), (3.0 * wall, -2.0 * wall)]
    return mockup_of(turned_around(block), turned_around([(PEG_RADIUS, 0.0), (PEG_RADIUS, 1.5 * PEG_LENGTH)]))


def closed_box() -> feeler.Mockup:
    """A box in the hollow of another that has room to turn in, and no opening."""
    outer, inner, moving = (cube(side) for side in (0.1, 0.09, 0.03))
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


def turned_around(outline: Sequence[tuple[float, float]]) -> Mesh:
    """An outline of radius and height, turned around z; a flat closes each end."""
    return stack(np.array([polygon(regular(radius, SIDES).tolist(), height) for radius, height in outline]))


def cube(side: float) -> Mesh:
    """About the origin."""
    return box((side, side, side), (0.0, 0.0, 0.0), 1)


PUZZLES = [
    Puzzle("peg, 1 %", lambda: peg(0.01)),
    Puzzle("peg, 0.1 %", lambda: peg(0.001)),
    Puzzle("tubes, 1.6", lambda: tubes(1.6)),
    Puzzle("tubes, 1.2", lambda: tubes(1.2)),
    Puzzle("tubes, 1.0", lambda: tubes(1.0)),
    Puzzle("closed box", closed_box, has_way=False),
]
BY_NAME = {puzzle.name: puzzle for puzzle in PUZZLES}
