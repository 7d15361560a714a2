"""Pegs and holes with ISO fits at 20 mm, round and square, cut finely enough that facets do not eat the clearance.

Limit deviations are those of ISO 286-2:2010 for the step of nominal sizes 18 to 30 mm (of letter c: 18 to 24 mm); the
clearance of a fit is hole minus peg. Chamfers of a peg are those of parallel pins, ISO 2338:1997: 3.5 mm long at
15 degrees for 20 mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .meshes import Floats, Mesh, regular, stack

NOMINAL_M = 0.020
PIN_CHAMFER_M = 0.0035
PIN_CHAMFER_RAD = math.radians(15.0)
HOLE_CHAMFER_M = 0.0005  # at 45 degrees
FACET_SHARE = 0.05  # of the radial clearance: the deviation of a facet from its circle
LEAST_SAGITTA_M = 1e-7  # no finer than this, or a fit without clearance would want endless facets
SHAPES = ("round", "square")
SIDES = 96  # of the shafts and bores that are timed
BORE_PLAY = 0.01  # of the shaft's radius
BORE_M = 0.05
PITCH_M = 0.0015  # M10
MINOR_RADIUS_M, FLANK_M = 0.0042, 0.0008  # of its bolt
TURNS = 4
THREAD_SIDES = 32


@dataclass(frozen=True)
class Fit:
    """Limit deviations from the nominal size, micrometres: of the hole and of the peg, lower and upper."""

    name: str
    hole_um: tuple[float, float]
    peg_um: tuple[float, float]

    def clearance_m(self, share: float) -> float:
        """The clearance, metres, on the diameter (or across): least at `share` 0, most at 1, the mean at 0.5."""
        least = self.hole_um[0] - self.peg_um[1]
        most = self.hole_um[1] - self.peg_um[0]
        return 1e-6 * (least + share * (most - least))

    def sizes_m(self, share: float) -> tuple[float, float]:
        """Hole and peg, across: each as far in its own tolerance as the clearance is in the fit's."""
        hole = self.hole_um[0] + share * (self.hole_um[1] - self.hole_um[0])
        peg = self.peg_um[1] - share * (self.peg_um[1] - self.peg_um[0])
        return NOMINAL_M + 1e-6 * hole, NOMINAL_M + 1e-6 * peg


FITS = {
    "H11/c11": Fit("H11/c11", (0.0, 130.0), (-240.0, -110.0)),
    "H7/g6": Fit("H7/g6", (0.0, 21.0), (-20.0, -7.0)),
    "H7/h6": Fit("H7/h6", (0.0, 21.0), (-13.0, 0.0)),
}


@dataclass(frozen=True)
class PegInHole:
    """A block with a blind hole along z, its mouth at z = 0, and a peg along z, its tip at z = 0 of the tool."""

    hole: Mesh
    peg: Mesh
    depth: float
    """Of the hole, metres."""
    clearance: float
    """On the diameter, or across, metres."""
    sides: int
    sagitta: float
    """How far the middle of a facet is off its circle, metres; 0 of a square."""


def sides_for(radius: float, clearance: float) -> int:
    """The least multiple of 16 of sides with facets off their circle by at most `FACET_SHARE` of half the clearance."""
    most = max(FACET_SHARE * 0.5 * clearance, LEAST_SAGITTA_M)
    return 16 * math.ceil(math.pi / math.acos(1.0 - most / radius) / 16.0)


def peg_in_hole(
    fit: str,
    shape: str = "round",
    *,
    share: float = 0.5,
    depth: float = 0.05,
    length: float = 0.07,
    chamfer: float = PIN_CHAMFER_M,
    hole_chamfer: float = HOLE_CHAMFER_M,
    sides: int | None = None,
) -> PegInHole:
    """A peg and its hole; round ones have `sides`, or as many as the fit needs.

    A round peg's corners lie on its circle and a round hole's sides touch its circle: neither reaches into the
    clearance. Square ones have sharp corners in the hole and corners cut by 0.3 mm on the peg.
    """
    hole_across, peg_across = FITS[fit].sizes_m(share)
    clearance = hole_across - peg_across
    drop = chamfer * math.tan(PIN_CHAMFER_RAD)
    if shape == "round":
        sides = sides or sides_for(0.5 * hole_across, clearance)
        sagitta = 0.5 * hole_across * (1.0 / math.cos(math.pi / sides) - 1.0)
        hole_section, peg_section = regular(1.0, sides, around=True), regular(1.0, sides)
    elif shape == "square":
        sides, sagitta = 8, 0.0
        # as many corners as the peg, the pairs of each corner in one place
        corners = np.array([(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)])
        hole_section = np.repeat(corners, 2, axis=0)
        cut = 0.0003 / (0.5 * peg_across)
        a = 1.0 - cut
        peg_section = np.array([(a, -1), (1, -a), (1, a), (a, 1), (-a, 1), (-1, a), (-1, -a), (-a, -1)], dtype=float)
    else:
        raise ValueError(f"shape is {shape!r}: choose one of {', '.join(SHAPES)}")
    r, mouth, wall = 0.5 * hole_across, 0.5 * hole_across + hole_chamfer, 0.5 * NOMINAL_M + 0.01
    hole_rows = [(r, -depth), (r, -hole_chamfer), (mouth, 0.0), (wall, 0.0), (wall, -depth - 0.01)]
    p = 0.5 * peg_across
    peg_rows = [(p - drop, 0.0), (p, chamfer), (p, length)]
    return PegInHole(_lathe(hole_section, hole_rows), _lathe(peg_section, peg_rows), depth, clearance, sides, sagitta)


def shaft_in_bore() -> tuple[Mesh, Mesh]:
    """A block with a blind bore along z, its mouth at z = 0; a shaft of 10 mm radius, its end at z = 0 of the tool."""
    r = 0.5 * NOMINAL_M
    rows = [(r * (1.0 + BORE_PLAY), -BORE_M), (r * (1.0 + BORE_PLAY), 0.0), (2 * r, 0.0), (2 * r, -BORE_M - 0.01)]
    around, within = regular(1.0, SIDES, around=True), regular(1.0, SIDES)
    return _lathe(around, rows), _lathe(within, [(r, 0.0), (r, BORE_M + 0.02)])


def bolt_in_nut(play: float = 6e-5) -> tuple[Mesh, Mesh]:
    """The thread of an M10 nut and that of its bolt, `play` metres off it, as open surfaces about z."""
    return _thread(MINOR_RADIUS_M + play), _thread(MINOR_RADIUS_M)


def _thread(radius: float) -> Mesh:
    """Flanks of 45 degrees or so and flats between them, wound up: a quarter of the pitch each."""
    turn = 2 * np.pi * np.arange(THREAD_SIDES + 1) / THREAD_SIDES
    rows = []
    for quarter in range(4 * TURNS + 1):
        r, z = radius + FLANK_M * (quarter % 4 // 2), PITCH_M * (0.25 * quarter + turn / (2 * np.pi))
        rows.append(np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1))
    first = np.arange(4 * TURNS)[:, None] * (THREAD_SIDES + 1) + np.arange(THREAD_SIDES)
    a, b, c, d = (first + off for off in (0, 1, THREAD_SIDES + 1, THREAD_SIDES + 2))
    faces = np.concatenate([np.stack([a, b, d], axis=-1), np.stack([a, d, c], axis=-1)], axis=1)
    return np.concatenate(rows), faces.reshape(-1, 3)


def _lathe(section: Floats, rows: list[tuple[float, float]]) -> Mesh:
    """A section of unit radius at each radius and height, closed by fans."""
    loops = [np.concatenate([section * r, np.full((len(section), 1), z)], axis=1) for r, z in rows]
    return stack(np.array(loops))
