"""Compressor and turbine blades, vanes and struts: lofted airfoils on platforms, span along z, chord near y."""

from __future__ import annotations

import numpy as np

from .mesh import Floats, Mesh, merge, moved, turned
from .shapes import box, extrude, skin
from .tessellation import Tolerance, lifted


def airfoil(chord: float, thickness: float, camber: float, side: int) -> Floats:
    """A cambered section (2 side, 2), counter-clockwise from the leading edge, chord along x, about its middle.

    `thickness` and `camber` are shares of the chord; `side` the number of pieces on each side, denser at the edges.
    """
    x = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, side + 1))
    half = 5.0 * thickness * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
    mean = 4.0 * camber * x * (1.0 - x)
    half[-1] = 0.0
    half[1:-1] = np.maximum(half[1:-1], 0.012)
    lower, upper = np.stack([x, mean - half], axis=1), np.stack([x, mean + half], axis=1)
    loop = np.concatenate([lower[:-1], upper[:0:-1]])
    return np.asarray((loop - [0.5, camber * 0.5]) * chord)


def airfoil_loft(
    low: float, high: float, chord: tuple[float, float], stagger: tuple[float, float], bend: float, tol: Tolerance
) -> Mesh:
    """An airfoil from z = `low` to `high`: chords and stagger angles (from y, radians) at root and tip, and camber."""
    size = max(chord)
    side = max(2, tol.segments(size * 1.1, 0.9, 2) + (2 if tol.shows(size * 0.02) else 0))
    twist = abs(stagger[1] - stagger[0])
    span = tol.segments(0.5 * size + (high - low) * 0.5, 0.15 + twist + 2.0 * bend, 1)
    share = np.linspace(0.0, 1.0, span + 1)
    thick = 0.11 - 0.05 * share
    rings = []
    for s, t in zip(share, thick, strict=True):
        outline = airfoil(chord[0] + (chord[1] - chord[0]) * s, t, bend * (1.0 - 0.4 * s), side)
        angle = np.pi / 2.0 - (stagger[0] + (stagger[1] - stagger[0]) * s)
        cosine, sine = np.cos(angle), np.sin(angle)
        loop = np.stack(
            [outline[:, 0] * cosine - outline[:, 1] * sine, outline[:, 0] * sine + outline[:, 1] * cosine], 1
        )
        loop[:, 0] += 0.03 * (high - low) * np.sin(np.pi * s)  # a little lean: no ruled surface
        rings.append(lifted(loop, low + (high - low) * float(s)))
    return skin(np.stack(rings))


def fir_tree(width: float, depth: float, length: float, tol: Tolerance) -> Mesh:
    """A blade's root: a notched wedge below z = 0, along y."""
    w, d = width / 2.0, depth
    notched = tol.shows(0.06 * depth)
    right = [
        (0.5 * w, -d),
        (0.75 * w, -0.85 * d),
        (0.45 * w, -0.6 * d),
        (0.9 * w, -0.5 * d),
        (0.6 * w, -0.2 * d),
        (w, 0.0),
    ]
    half = np.array(right if notched else [(0.5 * w, -d), (w, 0.0)])
    outline = np.concatenate([half, half[::-1] * [-1.0, 1.0]])
    return moved(extrude(outline, -length / 2.0, length / 2.0), turned("x", np.pi / 2.0))


def blade(
    root: float,
    tip: float,
    chord: float,
    stagger: tuple[float, float],
    bend: float,
    pitch: float,
    tol: Tolerance,
) -> Mesh:
    """A rotor blade: airfoil, platform and fir tree root; z = radius, y = the engine's axis, x = the circumference.

    `pitch` is the room along the circumference at the root, metres.
    """
    foil = airfoil_loft(root - 5e-4, tip, (chord, chord * 0.8), stagger, bend, tol)
    deep = chord * abs(np.cos(stagger[0])) + 0.006
    if not tol.shows(0.0012):
        return foil
    foot = 0.35 * chord + 0.004
    pieces = [
        foil,
        moved(box(pitch * 0.96, deep, 0.0035), _shift(root - 0.0035)),
        moved(fir_tree(pitch * 0.6, foot, deep, tol), _shift(root - 0.0035)),
    ]
    return merge(pieces)


def fan_blade(root: float, tip: float, chord: float, pitch: float, tol: Tolerance) -> Mesh:
    """A wide-chord fan blade: more twist, a dovetail root."""
    foil = airfoil_loft(root - 1e-3, tip, (chord * 0.75, chord * 1.1), (0.35, 1.05), 0.06, tol)
    if not tol.shows(0.002):
        return foil
    return merge([foil, moved(fir_tree(pitch * 0.7, 0.05, chord * 0.8, tol), _shift(root))])


def vane(
    root: float, tip: float, chord: float, stagger: tuple[float, float], bend: float, pitch: float, tol: Tolerance
) -> Mesh:
    """A stator vane between two platforms; frame as `blade`, `pitch` at the root."""
    foil = airfoil_loft(root, tip, (chord * 0.85, chord), stagger, bend, tol)
    if not tol.shows(0.0015):
        return foil
    deep = chord * abs(np.cos(stagger[0])) + 0.006
    inner = moved(box(pitch * 0.95, deep, 0.003), _shift(root - 0.0025))
    outer = moved(box(pitch * 0.95 * tip / root, deep, 0.003), _shift(tip - 0.0005))
    return merge([foil, inner, outer])


def strut(root: float, tip: float, chord: float, tol: Tolerance) -> Mesh:
    """A straight symmetrical strut along z, chord along y."""
    return airfoil_loft(root, tip, (chord, chord), (0.0, 0.0), 0.0, tol)


def _shift(z: float) -> Floats:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose
