"""Meshes as plain arrays: stacks of loops, tubes along curves, rings; and what tests ask of a mesh.

Boxes, balls, rods, ridges and sheets are those of `bench/contacts.py`. All in metres.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from contacts import Faces, Floats, Mesh, ball, box, joined, ridge, rod, sheet

import feeler

from .poses import placed

__all__ = [
    "Faces",
    "Floats",
    "Mesh",
    "ball",
    "boundary_edges",
    "box",
    "joined",
    "mockup_of",
    "outwards",
    "polygon",
    "regular",
    "ridge",
    "ring",
    "rod",
    "sheet",
    "shifted_mesh",
    "stack",
    "tool_of",
    "tube",
    "turned_mesh",
    "volume",
    "welded",
]


def welded(mesh: Mesh) -> Mesh:
    """The mesh with vertices of one place made one."""
    vertices, faces = mesh
    places, which = np.unique(np.round(vertices, 12), axis=0, return_inverse=True)
    first = np.full(len(places), len(vertices))
    np.minimum.at(first, which.ravel(), np.arange(len(vertices)))
    return vertices[first], np.asarray(which.ravel()[faces], dtype=np.int64)


def volume(mesh: Mesh) -> float:
    """The volume of a closed mesh, cubic metres: positive where its triangles face outwards."""
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def boundary_edges(mesh: Mesh) -> int:
    """How many edges have no triangle on their other side; 0 of a closed mesh that is wound one way."""
    _, faces = welded(mesh)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = {(int(a), int(b)) for a, b in ends}
    return sum((b, a) not in edges for a, b in edges)


def outwards(mesh: Mesh) -> Mesh:
    """A closed mesh with all triangles facing outwards, if they all faced one way."""
    return mesh if volume(mesh) > 0.0 else (mesh[0], mesh[1][:, [0, 2, 1]])


def shifted_mesh(mesh: Mesh, by: npt.ArrayLike) -> Mesh:
    """A mesh moved."""
    return mesh[0] + np.asarray(by, dtype=np.float64), mesh[1]


def turned_mesh(mesh: Mesh, frame: Floats) -> Mesh:
    """A mesh carried along by a pose."""
    return placed(mesh[0], frame), mesh[1]


def stack(loops: Floats, *, caps: bool = True, closed: bool = False) -> Mesh:
    """The skin over loops (k, n, 3), each joined to the next.

    `caps`: the first and last loop are closed by a fan about their middle. `closed`: the last is joined to the first.
    """
    k, n, _ = loops.shape
    vertices = [loops.reshape(-1, 3)]
    corner = np.arange(k * n).reshape(k, n)
    rows = np.concatenate([corner, corner[:1]]) if closed else corner
    a, b = rows[:-1], np.roll(rows[:-1], -1, axis=1)
    d, c = rows[1:], np.roll(rows[1:], -1, axis=1)
    faces = [np.stack([a.ravel(), b.ravel(), c.ravel()], 1), np.stack([a.ravel(), c.ravel(), d.ravel()], 1)]
    if caps and not closed:
        vertices.append(np.stack([loops[0].mean(axis=0), loops[-1].mean(axis=0)]))
        first, last = k * n, k * n + 1
        low, high = corner[0], corner[-1]
        faces.append(np.stack([np.full(n, first), np.roll(low, -1), low], 1))
        faces.append(np.stack([np.full(n, last), high, np.roll(high, -1)], 1))
    made = np.concatenate(vertices), np.concatenate(faces).astype(np.int64)
    return outwards(joined(made)) if caps or closed else made


def regular(radius: float, sides: int, *, around: bool = False, start: float = 0.0) -> Floats:
    """A regular polygon (sides, 2) about the origin: in the circle, or (`around`) about it, touching with its sides."""
    angle = start + np.arange(sides) * (2.0 * np.pi / sides)
    reach = radius / np.cos(np.pi / sides) if around else radius
    return np.asarray(reach * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def polygon(corners: Sequence[tuple[float, float]], z: float) -> Floats:
    """A loop (n, 3) at a height."""
    flat = np.asarray(corners, dtype=np.float64)
    return np.concatenate([flat, np.full((len(flat), 1), z)], axis=1)


def tube(curve: Floats, radius: float, sides: int, *, closed: bool = False) -> Mesh:
    """A tube about a curve (n, 3), its section a regular polygon in the circle; frames without twist."""
    after, before = np.roll(curve, -1, axis=0), np.roll(curve, 1, axis=0)
    tangents = after - before
    if not closed:
        tangents[0], tangents[-1] = curve[1] - curve[0], curve[-1] - curve[-2]
    tangents /= np.sqrt((tangents**2).sum(axis=1, keepdims=True))
    normal = np.cross(tangents[0], np.eye(3)[int(np.argmin(np.abs(tangents[0])))])
    section = regular(radius, sides)
    loops = []
    for point, tangent in zip(curve, tangents, strict=True):
        normal = normal - tangent * float(normal @ tangent)
        normal = normal / np.sqrt(normal @ normal)
        loops.append(point + section[:, :1] * normal + section[:, 1:] * np.cross(tangent, normal))
    if closed:
        raise ValueError("a closed tube twists where it meets its start: use ring()")
    return stack(np.array(loops))


def ring(radius: float, thickness: float, around: int, sides: int) -> Mesh:
    """A ring about z: the middle line at `radius`, its section a polygon in a circle of radius `thickness`."""
    section = regular(thickness, sides)
    loops = []
    for angle in np.arange(around) * (2.0 * np.pi / around):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        loops.append((radius + section[:, :1]) * out + section[:, 1:] * np.array([0.0, 0.0, 1.0]))
    return stack(np.array(loops), closed=True)


def mockup_of(mesh: Mesh) -> feeler.Mockup:
    """A mock-up of one part."""
    return feeler.Mockup(*mesh)


def tool_of(mesh: Mesh, name: str = "tool") -> feeler.Tool:
    """A tool of one part."""
    return feeler.Tool(mesh[0], mesh[1], name)
