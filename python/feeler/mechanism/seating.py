"""Seats: pairs of parts of a joint that are in contact where they are modelled, followed by the one rule of seats."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler._core import Chain, GuardedMove, World
from feeler.choices import MechanismSeatKind
from feeler.ignored import IgnoredPairs
from feeler.mechanism.rounds import Round, clearing, discs_of, moved, rounds_of
from feeler.mechanism.walls import cleared
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Mesh = tuple[Floats, Ints]
Meshed = tuple[Floats, Ints, Ints]
"""Vertices, faces, and the numbers of those that go all around."""
Met = tuple[float, Floats, Floats]
"""The share of a way, a point and a normal."""

_BESIDE_M = 1e-3  # parts whose boxes are farther apart have no pin in a hole of the other
TOLERANCE_M = 2e-8
TOUCH_M = 1e-6
"""Parts that are nearer are seated in each other."""


@dataclass(frozen=True, eq=False)
class Turn:
    """An axis that links turn about."""

    axis: Floats
    point: Floats
    is_alone: bool
    """Whether they do not slide along it as well."""


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

    def turn_between(self, one: int, other: int) -> Turn | None:
        """The axis about which two links turn against each other."""

    def slide_between(self, one: int, other: int) -> Floats | None:
        """The axis along which two links slide against each other."""


class Turning:
    """Two parts that turn about the axis of their surfaces of revolution.

    Those that go all around stay on themselves: pairs of these are not asked. All others are, if they do not touch
    where they are modelled.
    """

    def __init__(self, mine: Meshed, its: Meshed, pose: Floats) -> None:
        names = ["others", "round"]
        self._tool = Tool(mine[0], mine[1], "", _numbered(mine), names)
        mockup = Mockup(its[0], its[1], _numbered(its), names)
        self._around = Scene(mockup)
        self._ignore = IgnoredPairs(self._tool, mockup, np.array([[1, 1]]))
        near = self._around.distance(self._tool, pose, TOUCH_M, ignore=self._ignore)
        self.touches = math.isfinite(near.value)
        """Whether others touch."""

    def is_apart(self, pose: Floats) -> bool:
        """Never: the same surfaces are asked all along."""
        return False

    def meets(self, pose: Floats, way: Chain) -> Met | None:
        """Where they first meet."""
        hit = self._around.cast(self._tool, pose, screw=way, tolerance=TOLERANCE_M, ignore=self._ignore)
        return None if hit is None else (hit.fraction, hit.point, hit.normal)


def _numbered(mesh: Meshed) -> npt.NDArray[np.int64]:
    """1 for the faces that go all around."""
    found = np.zeros(len(mesh[1]), dtype=np.int64)
    found[mesh[2]] = 1
    return found


class Guarded:
    """Two parts by the rule of seats: they go no deeper than at a pose."""

    def __init__(self, tool: Tool, around: Scene, pose: Floats) -> None:
        self.tool, self.around = tool, around
        self._guard = GuardedMove(World(around, []), tool, pose)
        kinds = [seat.kind for seat in self._guard.seats()]
        self._is_seated = bool(kinds)
        self.kind: MechanismSeatKind = kinds[0] if kinds else "touching"

    def meets(self, pose: Floats, way: Chain) -> Met | None:
        """Where they go deeper, or meet elsewhere."""
        ended, share = self._guard.along(self.tool, pose, way, TOLERANCE_M)
        return None if ended.impact is None else (share, ended.impact.point, ended.impact.normal)

    def is_apart(self, pose: Floats) -> bool:
        """Whether the parts are off each other at a pose; never where the same surfaces are asked all along."""
        return self._is_seated and not math.isfinite(self.around.distance(self.tool, pose, TOUCH_M).value)


@dataclass(eq=False)
class Seated:
    """A part of a link that is seated in a part of another where they are modelled."""

    number: int
    """Of the link's tool."""
    part: int
    other: int
    kind: MechanismSeatKind
    """`touching`, `fit` or `sunk`, as in `removal`; `round`: only facets of surfaces of revolution about the axis
    cross."""
    rule: Guarded | Turning = field(repr=False)
    """It follows the part alone, its surfaces of revolution about the axis clear of those that they turn in."""

    def meets(self, pose: Floats, way: Chain) -> Met | None:
        """Where on a way, in the frame of the other link, it goes deeper than where it is modelled, or meets the other
        elsewhere: the share of the way, point and normal."""
        return self.rule.meets(pose, way)

    def is_apart(self, pose: Floats) -> bool:
        """Whether the parts are off each other at a pose, so that surfaces that were not asked now are."""
        return self.rule.is_apart(pose)


def seated(bodies: Sides, one: int, other: int) -> tuple[Seated, ...]:
    """The seats of a link in another, both with triangles."""
    tool, around = bodies.tool(one), bodies.alone(other)
    own = bodies.parts(one)
    pairs = {(int(a), int(b)) for a, b in World(around, []).seated_parts(tool, np.eye(4))}
    fits, slide = _round_pairs(bodies, one, other), bodies.slide_between(one, other)
    found = []
    for number, part in sorted(pairs | set(fits)):
        mesh, its, around = bodies.mesh(own[number]), bodies.mesh(part), bodies.scene.only([part])
        fit = fits.get((number, part))
        sliding = None if fit is not None or slide is None else _sliding(mesh, its, around, slide)
        if fit is not None:
            mesh = (fit.moved(mesh[0]), mesh[1])
        kind, rule = sliding or rule_of(mesh, fit, its, around, np.eye(4))
        found.append(Seated(number, own[number], part, kind, rule))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class RoundFit:
    """Two parts whose surfaces of revolution about an axis lie in each other."""

    turn: Turn
    by: list[tuple[Round, float]]
    mine: Ints
    its: Ints
    """The faces that go all around."""

    def moved(self, vertices: Floats) -> Floats:
        """The vertices of the part that moves, clear of the other."""
        return moved(vertices, self.turn.axis, self.turn.point, self.by)


def rounds_about(turn: Turn, mesh: Mesh) -> list[Round]:
    """The surfaces of revolution of a part that moves, which stay on themselves."""
    found = rounds_of(*mesh, turn.axis, turn.point)
    return found if turn.is_alone else [each for each in found if each.is_upright]


def round_fit(turn: Turn, mesh: Mesh, mine: list[Round], its: Mesh) -> RoundFit | None:
    """How a part with surfaces of revolution turns in another; None if none of them lie in each other."""
    axis, point = turn.axis, turn.point
    others = rounds_of(*its, axis, point, mine) if mine else []
    by = clearing(mine, others)
    if not by:
        return None
    whole = (
        np.concatenate([discs_of(*each, axis, point), *(found.facets for found in rounds)])
        for each, rounds in ((mesh, mine), (its, others))
    )
    return RoundFit(turn, by, *whole)


def rule_of(
    mesh: Mesh, fit: RoundFit | None, its: Mesh, around: Scene, pose: Floats
) -> tuple[MechanismSeatKind, Guarded | Turning]:
    """What follows a part in another, alone in a scene, and its kind. mesh: clear of the other."""
    if fit is not None and fit.turn.is_alone:
        turning = Turning((*mesh, fit.mine), (*its, fit.its), pose)
        if not turning.touches:
            return "round", turning
    guarded = Guarded(Tool(*mesh), around, pose)
    return ("round" if fit is not None and guarded.kind == "touching" else guarded.kind), guarded


def _sliding(mesh: Mesh, its: Mesh, around: Scene, axis: Floats) -> tuple[MechanismSeatKind, Guarded] | None:
    """What follows a part along a slide in another, alone in a scene, and its kind; None without walls in walls."""
    vertices, deep = cleared(*mesh, its, axis)
    if deep == -math.inf:
        return None
    guarded = Guarded(Tool(vertices, mesh[1]), around, np.eye(4))
    if guarded.kind != "touching":  # walls narrower than they move cross each other
        whole = Guarded(Tool(*mesh), around, np.eye(4))
        if guarded.kind == "sunk" or whole.kind != "sunk":
            return whole.kind, whole
    return ("fit" if guarded.kind == "touching" and deep > TOUCH_M else guarded.kind), guarded


def _round_pairs(bodies: Sides, one: int, other: int) -> dict[tuple[int, int], RoundFit]:
    """The pairs whose surfaces of revolution about the axis of the joint turn in each other."""
    turn = bodies.turn_between(one, other)
    if turn is None:
        return {}
    bounds = bodies.mockup.part_bounds.reshape(-1, 2, 3)
    others = np.array(bodies.parts(other))
    others = others[bodies.scene.part_mask[others]]
    known: dict[int, Mesh] = {}
    found = {}
    for number, part in enumerate(bodies.parts(one)):
        mesh = bodies.mesh(part)
        mine = rounds_about(turn, mesh)
        if not mine:
            continue
        low, high = bounds[part]
        beside = (bounds[others, 0] <= high + _BESIDE_M).all(axis=1) & (bounds[others, 1] >= low - _BESIDE_M).all(
            axis=1
        )
        for neighbour in others[beside].tolist():
            if neighbour not in known:
                known[neighbour] = bodies.mesh(neighbour)
            fit = round_fit(turn, mesh, mine, known[neighbour])
            if fit is not None:
                found[(number, neighbour)] = fit
    return found
