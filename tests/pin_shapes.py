"""Pins, cotter pins and castle nuts about z, for tests; metres."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from bearing_shapes import circle, plate
from shapes import Mesh, joined

Floats = npt.NDArray[np.float64]


def wire(points: list[tuple[float, float, float]], radius: float, sides: int = 8) -> Mesh:
    """A round wire along points in the plane of x and z."""
    path = np.array(points)
    steps = np.diff(path, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    along = np.concatenate([steps[:1], steps[1:] + steps[:-1], steps[-1:]])
    along /= np.linalg.norm(along, axis=1)[:, None]
    beside = np.cross(np.array([0.0, 1.0, 0.0]), along)
    turn = np.arange(sides) * math.tau / sides
    rings = [
        point + radius * (np.cos(turn)[:, None] * one + np.sin(turn)[:, None] * np.array([0.0, 1.0, 0.0]))
        for point, one in zip(path, beside, strict=True)
    ]
    a = np.arange(sides)
    b, last, faces = (a + 1) % sides, sides * (len(path) - 1), []
    for low in range(0, last, sides):
        high = low + sides
        faces += [np.column_stack([low + a, high + b, low + b]), np.column_stack([low + a, high + a, high + b])]
    end = np.arange(1, sides - 1)
    faces.append(np.column_stack([np.zeros(sides - 2, dtype=int), end, end + 1]))
    faces.append(np.column_stack([np.full(sides - 2, last), last + end + 1, last + end]))
    return np.concatenate(rings), np.concatenate(faces)


def cotter(radius: float, reach: float, leg: float, bent_deg: tuple[float, float] = (90.0, 90.0)) -> Mesh:
    """A cotter pin along x through the origin: its eye at x > reach, its legs bent up and down at x < -reach."""
    thin = 0.5 * radius
    turn = np.linspace(-0.6 * math.pi, 0.6 * math.pi, 13)
    eye = [(reach + 2.2 * radius + 2.0 * radius * math.cos(t), 0.0, 2.0 * radius * math.sin(t)) for t in turn]
    ends = []
    for sign, bend in ((-1.0, bent_deg[0]), (1.0, bent_deg[1])):
        angle = math.radians(bend)
        tip = (-reach - leg * math.cos(angle), 0.0, sign * (thin + leg * math.sin(angle)))
        ends.append([tip, (-reach, 0.0, sign * thin), (reach, 0.0, sign * thin)])
    return wire([*ends[0], *eye, *reversed(ends[1])], 0.98 * thin)


def hairpin(radius: float, reach: float) -> Mesh:
    """An R-clip: a straight leg along x through the origin, its bow at x > reach, and a leg over the shank."""
    turn = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 9)
    bow = [(reach + 4.0 * radius + 3.0 * radius * math.cos(t), 0.0, 3.0 * radius * (1.0 + math.sin(t))) for t in turn]
    over = [(reach, 0.0, 6.0 * radius), (0.0, 0.0, reach + 2.0 * radius), (-reach, 0.0, 7.0 * radius)]
    return wire([(-reach - 3.0 * radius, 0.0, 0.0), (0.0, 0.0, 0.0), (reach, 0.0, 0.0), *bow, *over], radius)


def drilled(radius: float, low: float, high: float, hole: float, at_height: float) -> Mesh:
    """A rod about z with a square hole along x at a height."""
    turn = np.arange(48) * math.tau / 48 + math.pi / 48
    round_ = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    halves = [round_[round_[:, 1] > hole], round_[round_[:, 1] < -hole]]
    sides = []
    for half in halves:
        x = math.sqrt(radius**2 - hole**2)
        edge = hole if half[0, 1] > 0.0 else -hole
        ends = np.array([[-x, edge], [x, edge]])
        sides.append(np.concatenate([half, ends if half[0, 1] > 0.0 else ends[::-1]]))
    low_end, high_end = at_height - hole, at_height + hole
    pieces = [plate([round_], low, low_end), plate([round_], high_end, high)]
    pieces += [plate([side], low_end, high_end) for side in sides]
    return joined(*pieces)


def castle_nut(flats: float, bore: float, low: float, foot: float, high: float, slot: float) -> Mesh:
    """A hexagon about z up to its foot, and six pieces of a crown above it, with slots along x."""
    turn = np.arange(6) * math.tau / 6 + math.pi / 6
    hexagon = flats / math.sqrt(3.0) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    pieces = [plate([hexagon, circle(bore)], low, foot)]
    outer = 0.48 * flats
    for k in range(6):
        inner_half, outer_half = math.asin(slot / bore), math.asin(slot / outer)
        first, last = k * math.tau / 6, (k + 1) * math.tau / 6
        out = np.linspace(first + outer_half, last - outer_half, 7)
        back = np.linspace(last - inner_half, first + inner_half, 7)
        piece = [
            outer * np.stack([np.cos(out), np.sin(out)], axis=1),
            bore * np.stack([np.cos(back), np.sin(back)], axis=1),
        ]
        pieces.append(plate([np.concatenate(piece)], foot, high))
    return joined(*pieces)
