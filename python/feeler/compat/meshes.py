"""Triangles of other libraries' objects, shapes made of them, and what a matrix with scale or mirror does to both."""

from __future__ import annotations

import zlib
from collections import OrderedDict
from collections.abc import Hashable
from threading import Lock
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import UNREADABLE, shown
from feeler.errors import FeelerError, MeshError, PoseError
from feeler.mockup import mesh_indices, mesh_points

Floats = npt.NDArray[np.float64]
Triangles = tuple[Floats, npt.NDArray[np.uint32]]

MOST_KEPT = 64
"""Shapes that are kept though no body has them: `in_collision_single` is often asked with one mesh at many places."""

LEAST_STRETCH = 1e-12
"""Of the largest stretch of a transform, at least so much is needed in all directions: with less, rounding flattens."""

_lock = Lock()
_kept: OrderedDict[Hashable, _core.Shape] = OrderedDict()
_alive: WeakValueDictionary[Hashable, _core.Shape] = WeakValueDictionary()


def triangles_of(mesh: Any) -> Triangles:
    """Vertices and faces of a mesh of trimesh, of FreeCAD (`Mesh.Mesh`, or an object with one), of anything with
    `.vertices` and `.faces`, or of a pair of arrays. Raises `MeshError` for others."""
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        vertices, faces = mesh.vertices, mesh.faces
    elif hasattr(getattr(mesh, "Mesh", mesh), "Topology"):
        try:
            corners, faces = getattr(mesh, "Mesh", mesh).Topology
            vertices = [tuple(corner) for corner in corners]
        except (TypeError, ValueError) as error:
            raise MeshError(f"a topology of points and triangles is needed, not that of {shown(mesh)}") from error
    elif isinstance(mesh, tuple) and len(mesh) == 2:
        vertices, faces = mesh
    else:
        raise MeshError(f"a mesh with vertices and faces is needed, not {shown(mesh)}")
    points = mesh_points(vertices)
    return points, mesh_indices(faces, len(points))


def shape_of(triangles: Triangles, stretch: Floats | None, memory_limit: int) -> _core.Shape:
    """The shape of triangles, stretched by a matrix `(3, 3)`; the same for the same triangles, while it is in use or
    was lately. `memory_limit`: the most bytes of its index."""
    vertices, faces = triangles
    if stretch is not None:
        with np.errstate(over="ignore", invalid="ignore"):  # beyond float64: triangles that are not queried
            vertices = np.ascontiguousarray(vertices @ stretch.T)
        if np.linalg.det(stretch) < 0:
            faces = np.ascontiguousarray(faces[:, ::-1])
    key = (len(vertices), len(faces), zlib.crc32(vertices.data), zlib.crc32(faces.data))
    with _lock:
        shape = _alive.get(key)
    if shape is None or not shape.is_of(vertices, faces):
        try:
            shape = _core.Shape(vertices, faces, memory_limit)
        except FeelerError as error:  # of the index, in which it is what stands
            raise type(error)(str(error).replace("mock-up", "mesh")) from None
    with _lock:
        _alive[key] = _kept[key] = shape
        _kept.move_to_end(key)
        while len(_kept) > MOST_KEPT:
            _kept.popitem(last=False)
    return shape


def affine(matrix: npt.ArrayLike | None) -> Floats:
    """A matrix `(4, 4)`, the identity for None. Raises `PoseError` for one that is not affine, finite and
    invertible."""
    if matrix is None:
        return np.eye(4)
    try:
        read = np.asarray(matrix)
        if read.dtype.kind not in "fiub":
            raise PoseError(f"a transform has dtype {read.dtype}: real numbers are needed")
        given = read.astype(np.float64)
    except UNREADABLE as error:
        raise PoseError(f"a transform cannot be read as a matrix: {error}") from error
    if given.shape != (4, 4):
        raise PoseError(f"a transform has shape {given.shape}: (4, 4) is needed")
    if not np.isfinite(given).all():
        raise PoseError("a transform has numbers that are not finite")
    if not np.allclose(given[3], [0, 0, 0, 1], rtol=0, atol=1e-6):
        raise PoseError(f"the last row of a transform is {given[3].tolist()}, not [0, 0, 0, 1]")
    return given


def split(matrix: Floats) -> tuple[Floats, Floats]:
    """A matrix `(4, 4)` as a rigid one and the stretch `(3, 3)` before it, which mirrors if the matrix does (polar
    decomposition). Raises `PoseError` if it flattens."""
    linear = matrix[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        u, scales, v = np.linalg.svd(linear)
    if not scales[2] > 0:
        raise PoseError("a transform flattens: its linear part has no inverse")
    if not scales[2] > LEAST_STRETCH * scales[0]:
        raise PoseError(
            f"a transform stretches {scales[0] / scales[2]:.3g} times as much in one direction as in another: at most "
            f"{1 / LEAST_STRETCH:g} times is possible"
        )
    turn = u @ v
    if np.linalg.det(turn) < 0:
        turn = -turn
    return _with(matrix, turn), turn.T @ linear


def rigid_after(matrix: Floats, stretch: Floats) -> Floats:
    """The matrix that comes after a stretch, so that both together are the one given."""
    return _with(matrix, matrix[:3, :3] @ np.linalg.inv(stretch))


def _with(matrix: Floats, linear: Floats) -> Floats:
    rigid = np.eye(4)
    rigid[:3, :3], rigid[:3, 3] = linear, matrix[:3, 3]
    return rigid
