"""Boxes, cylinders and spheres as triangles, centred on the origin, faces outwards."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Mesh = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]

LEAST_SEGMENTS = 12
MOST_SEGMENTS = 256
"""Most segments around a cylinder or sphere: 65,000 triangles of a sphere. Larger ones exceed the given tolerance."""


def box(size: npt.ArrayLike) -> Mesh:
    """A box with sides of these lengths, (3,)."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return corners * np.asarray(size, dtype=np.float64), np.array(faces)


def cylinder(radius: float, length: float, tolerance: float) -> Mesh:
    """A cylinder along z, with corners on the surface and triangles within `tolerance` inside it."""
    n = segments(radius, tolerance)
    ring = _ring(n) * radius
    ends = [np.column_stack([ring, np.full(n, z)]) for z in (-0.5 * length, 0.5 * length)]
    vertices = np.concatenate([*ends, [[0, 0, -0.5 * length], [0, 0, 0.5 * length]]])
    i = np.arange(n)
    j = (i + 1) % n
    walls = [np.column_stack([i, j, n + j]), np.column_stack([i, n + j, n + i])]
    lids = [np.column_stack([j, i, np.full(n, 2 * n)]), np.column_stack([n + i, n + j, np.full(n, 2 * n + 1)])]
    return vertices, np.concatenate([*walls, *lids])


def sphere(radius: float, tolerance: float) -> Mesh:
    """A sphere, with corners on the surface and triangles within `tolerance` inside it."""
    return capsule(radius, 0.0, tolerance)


def capsule(radius: float, length: float, tolerance: float) -> Mesh:
    """A capsule along z: a cylinder of this length between two half spheres, or a sphere if it is 0. Its corners are on
    the surface, its triangles within `tolerance` inside it."""
    n = segments(radius, 0.5 * tolerance)  # half as much around, half from pole to pole
    rows = n // 2  # from pole to pole, as fine as around
    if length > 0.0:
        rows += rows % 2  # a ring on the equator, which is there twice
    turns = np.pi * np.arange(1, rows) / rows
    places = [(np.sin(turn), np.cos(turn) * radius + (0.5 if turn <= 0.5 * np.pi else -0.5) * length) for turn in turns]
    if length > 0.0:
        places[rows // 2 - 1 : rows // 2] = [(1.0, 0.5 * length), (1.0, -0.5 * length)]
    rings = [np.column_stack([_ring(n) * (width * radius), np.full(n, height)]) for width, height in places]
    far = radius + 0.5 * length
    vertices = np.concatenate([*rings, [[0, 0, far], [0, 0, -far]]])
    i = np.arange(n)
    j = (i + 1) % n
    top, bottom = len(vertices) - 2, len(vertices) - 1
    faces = [np.column_stack([i, j, np.full(n, top)])]
    for row in range(len(rings) - 1):
        upper, lower = row * n, (row + 1) * n
        faces += [
            np.column_stack([upper + i, lower + i, lower + j]),
            np.column_stack([upper + i, lower + j, upper + j]),
        ]
    last = (len(rings) - 1) * n
    faces.append(np.column_stack([last + j, last + i, np.full(n, bottom)]))
    return vertices, np.concatenate(faces)


def segments(radius: float, tolerance: float) -> int:
    """The number of segments, even, around a circle so that each is within `tolerance` of it."""
    half = math.acos(max(1.0 - tolerance / radius, 0.0)) if tolerance < radius else math.pi
    n = math.ceil(math.pi / half) if half > 0 else MOST_SEGMENTS
    return min(max(n + n % 2, LEAST_SEGMENTS), MOST_SEGMENTS)


def _ring(n: int) -> npt.NDArray[np.float64]:
    angles = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angles), np.sin(angles)])
