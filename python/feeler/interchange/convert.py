"""Recognises the library of an object, and converts its meshes."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from feeler import _core
from feeler.arguments import UNREADABLE
from feeler.choices import UnitName
from feeler.errors import MeshError
from feeler.interchange import open3d, pyvista, trimesh
from feeler.interchange.assembly import Assembly
from feeler.mesh_types import MeshSource
from feeler.mockup import Meshes, Mockup, register_converter

ACCEPTED = (
    "a mesh or scene of trimesh, PyVista or Open3D, something with .vertices and .faces, or a list or dict of such, or "
    "of pairs (vertices, faces)"
)
_MAX_DEPTH = 50

_LIBRARIES: dict[str, tuple[Callable[[Any], bool], Callable[[Assembly, Any, tuple[str, ...]], None]]] = {
    "trimesh": (trimesh.is_ours, trimesh.add),
    "pyvista": (pyvista.is_ours, pyvista.add),
    "open3d": (open3d.is_ours, open3d.add),
}


def from_trimesh(mesh: MeshSource, unit: UnitName | None = None) -> Mockup:
    """A mock-up from a `trimesh.Trimesh` or `trimesh.Scene`, or a list or dict of such.

    Each geometry of a scene becomes a part at each of its places, with the names of the graph's nodes as path;
    triangles are reversed where a placement mirrors. `unit`: the unit of the numbers ("mm", "in", ...), which overrides
    the object's; by default its `.units`, else the metre. `feeler.Tool(mesh)` makes a tool.

    Raises `MeshError` for other objects, and for objects without triangles; `OptionError` for an unknown unit.
    """
    return _mockup(mesh, unit, "trimesh")


def from_pyvista(mesh: MeshSource, unit: UnitName | None = None) -> Mockup:
    """A mock-up from a PyVista `PolyData`, or a `MultiBlock`, whose blocks become parts; or a list or dict of such.

    Polygons and strips are cut into triangles; volumes (`UnstructuredGrid`, ...) contribute their surface. `unit`: the
    unit of the numbers, by default the metre, because PyVista stores none. `feeler.Tool(mesh)` makes a tool.

    Raises as `from_trimesh`.
    """
    return _mockup(mesh, unit, "pyvista")


def from_open3d(mesh: MeshSource, unit: UnitName | None = None) -> Mockup:
    """A mock-up from an Open3D `TriangleMesh`, of either API, or a `TriangleMeshModel`; or a list or dict of such.

    `unit`: the unit of the numbers, by default the metre, because Open3D stores none. `feeler.Tool(mesh)` makes a tool.

    Raises as `from_trimesh`.
    """
    return _mockup(mesh, unit, "open3d")


def _mockup(mesh: object, unit: str | None, library: str) -> Mockup:
    found = convert(mesh, unit, library)
    return Mockup(
        found.vertices,
        found.faces,
        found.part_of_face,
        found.part_names,
        part_paths=found.part_paths,
        source=found.source,
    )


def convert(held: Any, unit: str | None = None, library: str | None = None) -> Meshes:
    """All meshes of an object, in metres. `library`: refuses objects of others."""
    started = time.perf_counter()
    assembly = Assembly(_describe(held), unit)
    _add(assembly, held, (), library, 0)
    return assembly.meshes(time.perf_counter() - started)


register_converter(convert)


def _add(assembly: Assembly, held: Any, path: tuple[str, ...], library: str | None, depth: int) -> None:
    if depth > _MAX_DEPTH:
        raise MeshError(f"lists within lists, more than {_MAX_DEPTH} deep: does one contain itself?")
    if isinstance(held, (_core.Mockup, _core.Tool)) and library is None:
        _add_ours(assembly, held, path)
        return
    if path and library is None and _is_pair(held):
        assembly.add(path, held[0], held[1], in_metres=True)
        return
    if isinstance(held, np.ndarray):
        raise MeshError(f"faces are missing: an array of shape {held.shape} has none; give them, or {ACCEPTED}")
    for name, (is_ours, add) in _LIBRARIES.items():
        if library in (None, name) and is_ours(held):
            add(assembly, held, path)
            return
    if isinstance(held, Mapping):
        for name, each in held.items():
            levels = [level for level in str(name).split("/") if level] or [str(name)]
            _add(assembly, each, (*path, *levels), library, depth + 1)
        return
    if isinstance(held, Sequence) and not isinstance(held, (str, bytes)):
        if held and not _is_number_list(held):
            for i, each in enumerate(held):
                _add(assembly, each, (*path, f"part_{i}"), library, depth + 1)
            return
        if held:
            raise MeshError(f"faces are missing: a list of numbers has none; give them, or {ACCEPTED}")
    wanted = ACCEPTED if library is None else f"an object of {library}, or a list or dict of such"
    at = f"{'/'.join(path)}: " if path else ""
    hint = trimesh.hint(held) or pyvista.hint(held) or _file_hint(held)
    raise MeshError(f"{at}{_describe(held)} cannot be made a mesh{hint}: give {wanted}")


def _file_hint(held: Any) -> str:
    is_path = isinstance(held, (str, os.PathLike))
    return " (a file: feeler.load_mockup, load_tool or from_urdf reads it)" if is_path else ""


def _add_ours(assembly: Assembly, mesh: _core.Mockup | _core.Tool, path: tuple[str, ...]) -> None:
    """A mock-up or tool with its parts; a tool with one part is a part itself."""
    faces, vertices = np.asarray(mesh.faces), np.asarray(mesh.vertices)
    paths = getattr(mesh, "part_paths", None)
    if paths is None or (isinstance(mesh, _core.Tool) and mesh.part_count == 1):
        assembly.add(path or (str(getattr(mesh, "name", "part")),), vertices, faces, in_metres=True)
        return
    below = [tuple(each.split("/")) for each in paths]
    assembly.add_parts(path, vertices, faces, mesh.part_of_face, below, in_metres=True)


def _is_pair(held: Any) -> bool:
    """Whether these are vertices and faces."""
    if not isinstance(held, (list, tuple)) or len(held) != 2:
        return False
    try:
        vertices, faces = (np.asarray(each) for each in held)
    except UNREADABLE:
        return False
    rows = vertices.ndim == faces.ndim == 2 and vertices.shape[1] == faces.shape[1] == 3
    return bool(rows and vertices.dtype.kind in "fiu" and faces.dtype.kind in "iu")


def _is_number_list(held: Sequence[Any]) -> bool:
    first: Any = held
    for _ in range(3):  # vertices are lists of lists
        first = first[0] if isinstance(first, (list, tuple)) and first else first
    return isinstance(first, (int, float, np.number))


def _describe(held: Any) -> str:
    kind = type(held)
    module = kind.__module__.partition(".")[0]
    return kind.__name__ if module in ("builtins", "feeler") else f"{module}.{kind.__name__}"
