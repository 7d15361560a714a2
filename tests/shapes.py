"""Shapes and mock-ups of them for tests: boxes by their corners, metres."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

import feeler

Floats = npt.NDArray[np.float64]
Mesh = tuple[Floats, npt.NDArray[np.int64]]


def box(lower: Iterable[float], upper: Iterable[float]) -> Mesh:
    """A box, wound outwards."""
    low, high = np.array([*lower], dtype=float), np.array([*upper], dtype=float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return low + corners * (high - low), np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])


def cube(centre: Iterable[float], size: float) -> Mesh:
    middle = np.array([*centre], dtype=float)
    return box(middle - size / 2, middle + size / 2)


def inverted(mesh: Mesh) -> Mesh:
    """Wound the other way round: a hollow, or a solid that a mirror turned inside out."""
    return mesh[0], mesh[1][:, ::-1].copy()


def joined(*meshes: Mesh) -> Mesh:
    """Several in one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def open_chest() -> Mesh:
    """A floor and four walls, 0.5 m wide and 0.375 m high, open above."""
    return joined(
        box((0, 0, 0), (0.5, 0.5, 0.03125)),
        box((0, 0, 0.03125), (0.03125, 0.5, 0.375)),
        box((0.46875, 0, 0.03125), (0.5, 0.5, 0.375)),
        box((0.03125, 0, 0.03125), (0.46875, 0.03125, 0.375)),
        box((0.03125, 0.46875, 0.03125), (0.46875, 0.5, 0.375)),
    )


def arrays_of(parts: Mapping[str, Mesh]) -> tuple[Floats, npt.NDArray[np.int64], npt.NDArray[np.int64], list[str]]:
    """Vertices, faces, part of each face, and names: the last piece of each path."""
    part = np.repeat(np.arange(len(parts)), [len(faces) for _, faces in parts.values()])
    return *joined(*parts.values()), part, [path.split("/")[-1] for path in parts]


def mockup_of(parts: Mapping[str, Mesh]) -> feeler.Mockup:
    """A part for each path."""
    vertices, faces, part, names = arrays_of(parts)
    return feeler.Mockup(vertices, faces, part, names, part_paths=list(parts))


def tool_of(parts: Mapping[str, Mesh], name: str = "tool") -> feeler.Tool:
    """A tool with a part for each path."""
    vertices, faces, part, names = arrays_of(parts)
    return feeler.Tool(vertices, faces, name, part, names, part_paths=list(parts))


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0, degrees: float = 0.0, axis: int = 2) -> Floats:
    """A pose: turned about a coordinate axis, then moved. Quarter turns are exact."""
    pose = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    if degrees % 90 == 0:
        c, s = np.rint(c), np.rint(s)
    pose[i, i], pose[i, j], pose[j, i], pose[j, j] = c, -s, s, c
    pose[:3, 3] = x, y, z
    return pose


def prism_ring(outer: float, inner: float, sides: int, low: float, high: float, turned: float = 0.0) -> Mesh:
    """A plate with a hole of some sides about z; without a hole a pin."""
    angles = turned + np.arange(sides) * 2.0 * math.pi / sides
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    levels = [(outer, low), (outer, high), (inner, high), (inner, low)]
    vertices = np.concatenate([np.column_stack([r * circle, np.full(sides, z)]) for r, z in levels])
    faces = []
    for level in range(4):
        for i in range(sides):
            a, b = level * sides + i, level * sides + (i + 1) % sides
            c, d = (level + 1) % 4 * sides + i, (level + 1) % 4 * sides + (i + 1) % sides
            faces += [[a, b, d], [a, d, c]]
    if inner == 0.0:
        vertices = np.concatenate([vertices[: 2 * sides], [[0, 0, high], [0, 0, low]]])
        faces = [[min(v, 2 * sides) if v < 3 * sides else 2 * sides + 1 for v in face] for face in faces]
        faces = [face for face in faces if len(set(face)) == 3]
    return vertices, np.array(faces)
