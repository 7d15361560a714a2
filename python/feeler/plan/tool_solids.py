"""Closed meshes of tools from rings of points: lathed bodies, beams and prisms, metres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Solid = tuple[Floats, Ints]
"""Vertices (n, 3) and faces (m, 3), counter-clockwise from outside."""

AROUND = 24
"""Points of a ring: a multiple of 12, so that hexagons and stars of 12 points lie on it."""
_ANGLES = 2.0 * np.pi * np.arange(AROUND) / AROUND


def disc(radius: float, z: float) -> Floats:
    """A ring (AROUND, 3) around a circle: no body made of it is narrower than a round one."""
    r = radius / np.cos(np.pi / AROUND)
    return np.stack([r * np.cos(_ANGLES), r * np.sin(_ANGLES), np.full(AROUND, z)], axis=1)


def inside(radius: float, z: float) -> Floats:
    """A ring (AROUND, 3) in a circle."""
    return disc(radius * np.cos(np.pi / AROUND), z)


def flats(across: float, z: float, corners: int = 6) -> Floats:
    """A ring (AROUND, 3) on a hexagon, or on the star of two (12), or of two squares (8), by its width across flats; a
    flat faces y."""
    turn = _ANGLES - np.pi / 2.0
    sides = 4 if corners == 8 else 6
    first, second = (_on_sides(across, turn + shift, sides) for shift in (0.0, np.pi / sides))
    r = first if corners == sides else np.maximum(first, second)
    return np.stack([r * np.cos(_ANGLES), r * np.sin(_ANGLES), np.full(AROUND, z)], axis=1)


def _on_sides(across: float, turn: Floats, sides: int) -> Floats:
    """Distances of a regular polygon from the middle, by its width across flats; one flat is at 0."""
    half = np.pi / sides
    return np.asarray(0.5 * across / np.cos((turn + half) % (2.0 * half) - half))


def lathed(rings: Sequence[Floats], *, is_ring: bool = False) -> Solid:
    """The body between rings (n, 3) that follow each other along its outside, from the lower end to the upper.

    `is_ring`: the last joins the first; otherwise the first and the last get a cap, which they must be convex for.
    """
    count, n = len(rings), len(rings[0])
    index = np.arange(count * n).reshape(count, n)
    lower, upper = (index, np.roll(index, -1, axis=0)) if is_ring else (index[:-1], index[1:])
    beside, above = np.roll(lower, -1, axis=1), np.roll(upper, -1, axis=1)
    faces = [np.stack([lower, beside, above], axis=2), np.stack([lower, above, upper], axis=2)]
    if not is_ring:
        fan = np.array([[0, k + 1, k] for k in range(1, n - 1)])
        faces += [index[0][fan], index[-1][fan[:, ::-1]]]
    return np.concatenate(rings), np.concatenate([each.reshape(-1, 3) for each in faces])


def beam(sections: Sequence[tuple[float, float, float, float]]) -> Solid:
    """A body along x through upright rectangles: x, the middle's z, width (y), thickness (z)."""
    rings = []
    for x, z, width, thick in sections:
        y, h = 0.5 * width, 0.5 * thick
        rings.append(np.array([[x, -y, z - h], [x, y, z - h], [x, y, z + h], [x, -y, z + h]]))
    return lathed(rings)


def prism(outline: npt.ArrayLike, low: float, high: float) -> Solid:
    """A convex outline (n, 2), counter-clockwise, from z = low to z = high."""
    plane = np.asarray(outline, dtype=np.float64)
    return lathed([np.column_stack([plane, np.full(len(plane), z)]) for z in (low, high)])


def moved(solid: Solid, pose: Floats) -> Solid:
    """At a pose (4, 4)."""
    return solid[0] @ pose[:3, :3].T + pose[:3, 3], solid[1]


def merged(solids: Sequence[Solid]) -> Solid:
    """Several as one; each keeps its own vertices."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(faces)
