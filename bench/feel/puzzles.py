"""Puzzles with a known way out: two alpha-shaped rods, two coils, a hexagon key in its socket. Shapes are our own.

Alpha and coils are made with their way out. A curve in cylindrical coordinates whose height is `pitch * angle / turn`
lies on a screw surface (helicoid). Two rods on two such surfaces half a pitch apart never come nearer to each other
while one moves along its own surface, which is a screw motion: a turn about the axis and a rise in proportion. So the
way out is exact, and it needs translation and rotation together all along. This is not the alpha puzzle of the motion
planning benchmarks (Amato), whose narrow passage is short and has no formula.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .meshes import Floats, Mesh, polygon, regular, stack, tube
from .poses import pose

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Puzzle:
    """A mock-up, a tool, and poses (n, 4, 4) from where the tool sits to where it is free of all."""

    name: str
    mockup: Mesh
    tool: Mesh
    way: Floats
    clearance: float
    """Least distance of the two along the way, metres, as the construction says."""


def alpha(
    radius: float = 0.03,
    pitch: float = 0.024,
    rod: float = 0.004,
    leg: float = 0.06,
    *,
    steps: int = 48,
    sides: int = 12,
) -> Puzzle:
    """Two rods bent like the letter alpha, each with its loop through the other's.

    A loop of 300 degrees and two straight legs (seen along the axis) that cross; `steps` points a turn.
    """
    loop = np.linspace(-math.radians(150.0), math.radians(150.0), max(8, round(steps * 300 / 360)))
    reach = np.linspace(0.0, leg, max(4, steps // 6))[1:]
    # along a tangent of the circle, `s` from where it touches: the distance from the axis and the angle
    far, ahead = np.hypot(radius, reach), np.arctan2(reach, radius)
    angle = np.concatenate([loop[0] - ahead[::-1], loop, loop[-1] + ahead])
    distance = np.concatenate([far[::-1], np.full(len(loop), radius), far])
    turns = (angle[-1] - angle[0]) / TURN + 0.5
    return _screwed("alpha", angle, distance, pitch, rod, sides, turns, radius)


def coils(
    radius: float = 0.02,
    pitch: float = 0.016,
    rod: float = 0.003,
    turns: float = 2.0,
    *,
    steps: int = 48,
    sides: int = 12,
) -> Puzzle:
    """Two coils, each between the turns of the other."""
    angle = np.linspace(0.0, turns * TURN, max(8, round(turns * steps)))
    return _screwed("coils", angle, np.full(len(angle), radius), pitch, rod, sides, turns + 0.5, radius)


def _screwed(
    name: str, angle: Floats, distance: Floats, pitch: float, rod: float, sides: int, turns: float, radius: float
) -> Puzzle:
    curve = np.stack([distance * np.cos(angle), distance * np.sin(angle), pitch * angle / TURN], axis=1)
    mesh = tube(curve, rod, sides)
    # turned by half a turn a rod lies on the surface half a pitch away, and its loop opens to the other side
    other = mesh[0] * np.array([-1.0, -1.0, 1.0]), mesh[1]
    # of two screw surfaces half a pitch apart, where they are steepest; chords of the curves cut inside by a little
    slope = math.atan(pitch / (TURN * radius))
    clearance = 0.5 * pitch * math.cos(slope) - 2.0 * rod
    count = math.ceil(turns * 120)
    way = [pose((0.0, 0.0, pitch * t), (0.0, 0.0, TURN * t)) for t in np.linspace(0.0, turns, count + 1)]
    # the turn is a rotation vector: beyond half a turn the matrix is what counts
    above = way[-1].copy()
    above[2, 3] += 0.5 * float(np.ptp(curve[:, 2])) + pitch
    return Puzzle(name, other, mesh, np.array([*way, above]), clearance)


@dataclass(frozen=True)
class HexFit:
    """A hexagon key in its socket, millimetres, least and largest."""

    key_across: tuple[float, float]
    """Across flats: ISO 2936:2014, tolerance h10."""
    socket_across: tuple[float, float]
    """Across flats: ISO 4762:2004, s."""
    key_legs: tuple[float, float]
    """Long and short leg: ISO 2936."""
    head_diameter: float
    head_height: float
    socket_depth: float
    """ISO 4762: dk, k, and the least t."""


M10 = HexFit((7.942, 8.0), (8.025, 8.175), (100.0, 36.0), 16.0, 10.0, 5.0)
KEY_CHAMFER_M = 0.0004
SOCKET_CHAMFER_M = 0.0006


def hexagon_key(fit: HexFit = M10, share: float = 0.5) -> Puzzle:
    """A key in the socket of a cap screw: `share` 0 is the closest pair of sizes, 1 the loosest.

    The socket's mouth is at z = 0, the key's end 0.2 mm above its floor, its short leg along z; out along z.
    """
    key = 1e-3 * (fit.key_across[1] - share * (fit.key_across[1] - fit.key_across[0]))
    socket = 1e-3 * (fit.socket_across[0] + share * (fit.socket_across[1] - fit.socket_across[0]))
    depth, top = 1e-3 * fit.socket_depth, SOCKET_CHAMFER_M
    hexagon = regular(1.0, 6, around=True)
    outside = regular(0.5e-3 * fit.head_diameter, 6, around=True)

    def loop(flat: Floats, z: float) -> Floats:
        return polygon([(float(x), float(y)) for x, y in flat], z)

    half = 0.5 * socket
    head = [loop(hexagon * half, -depth), loop(hexagon * half, -top), loop(hexagon * (half + top), 0.0)]
    head += [loop(outside, 0.0), loop(outside, -1e-3 * fit.head_height)]
    return Puzzle(
        "hexagon key",
        stack(np.array(head)),
        _bent_key(0.5 * key, 1e-3 * fit.key_legs[1], 1e-3 * fit.key_legs[0]),
        np.array([pose((0.0, 0.0, z)) for z in np.linspace(-depth + 2e-4, 0.02, 40)]),
        0.5 * (socket - key),
    )


def _bent_key(half: float, short: float, long: float) -> Mesh:
    """A hexagonal bar from z = 0 up, bent towards x by a quarter turn; its first corners cut a little."""
    bend, corner = 2.0 * half, half / math.cos(math.pi / 6.0)  # legs are measured over the corners
    quarter = np.linspace(0.0, 0.5 * math.pi, 9)
    hexagon = regular(1.0, 6, around=True)
    rows: list[tuple[Floats, float, float]] = [
        (np.zeros(3), 0.0, half - KEY_CHAMFER_M),
        (np.array([0.0, 0.0, KEY_CHAMFER_M]), 0.0, half),
    ]
    for a in quarter:
        middle = np.array([bend - bend * math.cos(a), 0.0, short - corner - bend + bend * math.sin(a)])
        rows.append((middle, float(a), half))
    rows.append((np.array([long - corner, 0.0, short - corner]), 0.5 * math.pi, half))
    loops = []
    for middle, a, size in rows:
        across = np.array([math.cos(a), 0.0, -math.sin(a)])  # the section's x, turned towards the bend
        loops.append(middle + size * (hexagon[:, :1] * across + hexagon[:, 1:] * np.array([0.0, 1.0, 0.0])))
    return stack(np.array(loops))
