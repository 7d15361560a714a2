"""Two tubes, each bent to an alpha, linked: after the alpha puzzle of B. Yamrom (a known test of motion planners).

The geometry is our own: a loop of three quarters of a circle, and two straight prongs that cross over it with a gap. As
in the puzzle, the obstacle is stretched along z by a factor, which widens the gap that a tube of the robot must pass.
The identity is the robot's linked pose.
"""

from __future__ import annotations

import numpy as np
from feel.meshes import Floats, Mesh, tube

RADIUS = 0.005  # of a tube, metres
LOOP = 0.035  # radius of the loop
PRONG = 0.09  # from the loop to the tip
RISE = 4.1 * RADIUS  # from prong to prong where they cross: unstretched, the gap is 5 % wider than a tube
RINGS, AROUND = 54, 9


def alpha(stretch: float) -> tuple[Mesh, Mesh]:
    """The obstacle, stretched, and the robot where it is linked with it: (vertices, faces) of 972 triangles each."""
    vertices, faces = tube(centre_line(), RADIUS, AROUND)
    # The robot's loop stands upright in the obstacle's, and its prongs point away.
    turn = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    robot = vertices @ turn.T + (LOOP, 0.0, 0.0)
    return (vertices * (1.0, 1.0, stretch), faces), (robot, faces)


def centre_line() -> Floats:
    """`(RINGS, 3)`: up one prong, around the loop, down the other; it rises all the way."""
    arc = 1.5 * np.pi * LOOP
    half = 0.5 * arc + PRONG
    # Rings lie closer where the tube bends.
    straight = (RINGS - 36) // 2
    lengths = np.concatenate(
        [
            np.linspace(-half, -0.5 * arc, straight + 1)[:-1],
            np.linspace(-0.5 * arc, 0.5 * arc, 36),
            np.linspace(0.5 * arc, half, straight + 1)[1:],
        ]
    )
    # The loop is open at the bottom: its middle is at the top, its ends at 45 degrees below.
    angle = np.clip(lengths, -0.5 * arc, 0.5 * arc) / LOOP + 0.5 * np.pi
    over = lengths - np.clip(lengths, -0.5 * arc, 0.5 * arc)
    x = LOOP * np.cos(angle) - over * np.sin(angle)
    y = LOOP * np.sin(angle) + over * np.cos(angle)
    crossing = 0.5 * arc + LOOP  # where the prongs cross, along the line
    return np.stack([x, y, 0.5 * RISE * np.clip(lengths / crossing, -1.6, 1.6)], axis=1)
