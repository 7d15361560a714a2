"""Meshes and poses of the sample makers: plain arrays, not public."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# Vertices of a finished sample lie on this grid (about half a micrometre). Below 8 m every such number is exact in
# single precision too, so a sample written to STL or GLB and read again is the same sample, and the last-bit noise of
# sines and cosines does not reach the result. Change it and every sample's bytes change.
VERTEX_GRID_M = 2.0**-21


@dataclass(frozen=True, eq=False)
class Mesh:
    """One tessellated shape: vertices (n, 3) float64 in metres, faces (m, 3) int64, counter-clockwise from outside."""

    vertices: Floats
    faces: Ints

    @property
    def triangle_count(self) -> int:
        """Number of faces."""
        return int(self.faces.shape[0])


@dataclass(frozen=True, eq=False)
class MeshParts:
    """A whole mock-up as arrays.

    vertices (n, 3) float64, metres; faces (m, 3) uint32; part_of_face (m,) uint32, not decreasing; one name and one
    path per part; where the sample has materials, sRGB colours (parts, 3).
    """

    vertices: Floats
    faces: npt.NDArray[np.uint32]
    part_of_face: npt.NDArray[np.uint32]
    part_names: list[str]
    part_paths: list[str]
    colours: Floats | None = None


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one, their vertices kept apart."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]),
    )


def moved(mesh: Mesh, pose: Floats) -> Mesh:
    """The mesh at one pose, (4, 4)."""
    return Mesh(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces)


def scaled(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """The mesh stretched along the axes; the factors are positive, so the orientation stays."""
    return Mesh(mesh.vertices * np.array([x, y, z]), mesh.faces)


def snapped(vertices: Floats) -> Floats:
    """Vertices rounded to `VERTEX_GRID_M`, in place."""
    np.multiply(vertices, 1.0 / VERTEX_GRID_M, out=vertices)
    np.rint(vertices, out=vertices)
    np.multiply(vertices, VERTEX_GRID_M, out=vertices)
    vertices += 0.0  # turns -0.0 into 0.0
    return vertices


def times(first: npt.ArrayLike, *factors: npt.ArrayLike) -> Floats:
    """The product of matrices and vectors, as `@` gives it, by plain products and sums from the left.

    Of it the last bits are the same on all processors; those of `@` depend on the kernels that BLAS has for one.
    """
    out = np.asarray(first, dtype=np.float64)
    for factor in factors:
        a, b = out, np.asarray(factor, dtype=np.float64)
        rows = [b[k] if b.ndim == 1 else b[..., k, :] for k in range(a.shape[-1])]
        if a.ndim > 1 and b.ndim > 1:
            a, rows = a[..., None], [row[..., None, :] for row in rows]
            terms = [a[..., k, :] * row for k, row in enumerate(rows)]
        else:
            terms = [a[..., k] * row for k, row in enumerate(rows)]
        out = np.asarray(terms[0])
        for term in terms[1:]:
            out = out + term
    return np.asarray(out)


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Floats:
    """The pose that only shifts, (4, 4)."""
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


def turned(axis: str, angle: float) -> Floats:
    """The pose that turns about `x`, `y` or `z` by `angle` radians, (4, 4)."""
    pose = np.eye(4)
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    cosine, sine = np.cos(angle), np.sin(angle)
    pose[first, first] = pose[second, second] = cosine
    pose[first, second], pose[second, first] = -sine, sine
    return pose


def framed(origin: npt.ArrayLike, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike) -> Floats:
    """Poses (k, 4, 4) from origins and axes, each (k, 3) or one (3,) for all."""
    parts = np.broadcast_arrays(*(np.atleast_2d(np.asarray(a, dtype=np.float64)) for a in (x, y, z, origin)))
    poses = np.zeros((len(parts[0]), 4, 4))
    for column, values in enumerate(parts):
        poses[:, :3, column] = values
    poses[:, 3, 3] = 1.0
    return poses


def aimed(origin: npt.ArrayLike, z: npt.ArrayLike, y_hint: npt.ArrayLike) -> Floats:
    """Poses (k, 4, 4) whose z axis is `z` and whose y axis is as near to `y_hint` as it can be."""
    z_axis = unit(np.atleast_2d(np.asarray(z, dtype=np.float64)))
    hint = np.broadcast_to(np.asarray(y_hint, dtype=np.float64), z_axis.shape)
    x_axis = unit(np.cross(hint, z_axis))
    return framed(origin, x_axis, np.cross(z_axis, x_axis), z_axis)


def unit(vectors: Floats) -> Floats:
    """Vectors of length one."""
    length = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    return np.asarray(vectors / length, dtype=np.float64)


def around(angles: npt.ArrayLike, radius: npt.ArrayLike, z: npt.ArrayLike, up: str = "radial") -> Floats:
    """Poses (k, 4, 4) on a cylinder about z.

    `up="radial"`: the part's z points outwards, its y along the cylinder's axis, its x along the circumference.
    `up="axial"`: the part's z points along the axis, its x outwards. `up="back"`: z against the axis, x outwards.
    """
    angle, r, height = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(a, dtype=np.float64)) for a in (angles, radius, z))
    )
    cosine, sine, zero = np.cos(angle), np.sin(angle), np.zeros(angle.shape)
    outward = np.stack([cosine, sine, zero], axis=1)
    along = np.stack([-sine, cosine, zero], axis=1)
    axis = np.stack([zero, zero, zero + 1.0], axis=1)
    origin = np.stack([r * cosine, r * sine, height], axis=1)
    if up == "radial":
        return framed(origin, along, axis, outward)
    if up == "axial":
        return framed(origin, outward, along, axis)
    return framed(origin, outward, -along, -axis)


def circle_angles(count: int, phase: float = 0.0) -> Floats:
    """`count` equally spaced angles, from `phase`."""
    return np.asarray(np.arange(count) * (2.0 * np.pi / count) + phase, dtype=np.float64)
