"""Seats: pairs of parts of a joint that are in contact where they are modelled, followed by the one rule of seats."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler._core import Chain, GuardedMove, World
from feeler.choices import MechanismSeatKind
from feeler.mechanism.joint import Joint, JointKind
from feeler.mechanism.rounds import Round, clear_radii, moved, rounds_of
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

_BESIDE_M = 1e-3  # parts whose boxes are farther apart have no pin in a hole of the other
TOLERANCE_M = 2e-8
TOUCH_M = 1e-6
"""Parts that are nearer are seated in each other."""


class Sides(Protocol):
    """The links of a mechanism, where they are modelled; -1: the frame."""

    mockup: Mockup

    @property
    def scene(self) -> Scene:
        """All parts."""

    def parts(self, link: int) -> tuple[int, ...]:
        """The parts of a link."""

    def tool(self, link: int) -> Tool:
        """A link as a tool."""

    def alone(self, link: int) -> Scene:
        """A link as a scene."""

    def mesh(self, part: int) -> tuple[Floats, npt.NDArray[np.int64]]:
        """The vertices and faces of a part."""

    def joint_between(self, one: int, other: int) -> Joint | None:
        """The joint that joins two links."""


@dataclass(eq=False)
class Seated:
    """A part of a link that is seated in a part of another where they are modelled."""

    number: int
    """Of the link's tool."""
    part: int
    other: int
    kind: MechanismSeatKind
    """`touching`, `fit` or `sunk`, as in `removal`; `round`: only facets of a pin and its hole about the axis cross."""
    tool: Tool
    """The part alone, its round surfaces about the axis of the joint clear of those that they turn in."""
    around: Scene = field(repr=False)
    """The other part alone."""
    guard: GuardedMove = field(repr=False)

    def meets(self, pose: Floats, way: Chain) -> tuple[float, Floats, Floats] | None:
        """Where on a way, in the frame of the other link, it goes deeper than where it is modelled, or meets the other
        elsewhere: the share of the way, point and normal."""
        ended, share = self.guard.along(self.tool, pose, way, TOLERANCE_M)
        if ended.impact is None:
            return None
        return share, ended.impact.point, ended.impact.normal

    def is_apart(self, pose: Floats) -> bool:
        """Whether the parts are off each other at a pose."""
        return not math.isfinite(self.around.distance(self.tool, pose, TOUCH_M).value)


def seated(bodies: Sides, one: int, other: int) -> tuple[Seated, ...]:
    """The seats of a link in another, both with triangles."""
    tool, around = bodies.tool(one), bodies.alone(other)
    own = bodies.parts(one)
    pairs = {(int(a), int(b)) for a, b in World(around, []).seated_parts(tool, np.eye(4))}
    radii = _round_pairs(bodies, one, other)
    found = []
    for number, part in sorted(pairs | set(radii)):
        vertices, faces = bodies.mesh(own[number])
        by = radii.get((number, part), [])
        if by:
            joint = bodies.joint_between(one, other)
            assert joint is not None
            vertices = moved(vertices, np.array(joint.axis), np.array(joint.point), by)
        alone = Tool(vertices, faces)
        around = bodies.scene.only([part])
        guard = GuardedMove(World(around, []), alone, np.eye(4))
        kinds = [seat.kind for seat in guard.seats()]
        kind: MechanismSeatKind = kinds[0] if kinds else "touching"
        if by and kind == "touching":
            kind = "round"
        found.append(Seated(number, own[number], part, kind, alone, around, guard))
    return tuple(found)


def _round_pairs(bodies: Sides, one: int, other: int) -> dict[tuple[int, int], list[tuple[Round, float]]]:
    """The pairs whose round surfaces about the axis of the joint turn in each other, with what makes them clear."""
    joint = bodies.joint_between(one, other)
    if joint is None or joint.kind in (JointKind.PRISMATIC, JointKind.FIXED):
        return {}
    axis, point = np.array(joint.axis), np.array(joint.point)
    bounds = bodies.mockup.part_bounds.reshape(-1, 2, 3)
    others = np.array(bodies.parts(other))
    others = others[bodies.scene.part_mask[others]]
    known: dict[int, tuple[Floats, npt.NDArray[np.int64]]] = {}
    found = {}
    for number, part in enumerate(bodies.parts(one)):
        mine = rounds_of(*bodies.mesh(part), axis, point)
        if not mine:
            continue
        low, high = bounds[part]
        beside = (bounds[others, 0] <= high + _BESIDE_M).all(axis=1) & (bounds[others, 1] >= low - _BESIDE_M).all(
            axis=1
        )
        for neighbour in others[beside].tolist():
            if neighbour not in known:
                known[neighbour] = bodies.mesh(neighbour)
            by = clear_radii(mine, rounds_of(*known[neighbour], axis, point, mine))
            if by:
                found[(number, neighbour)] = by
    return found
