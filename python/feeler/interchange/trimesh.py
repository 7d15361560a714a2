"""Meshes and scenes of trimesh, and anything else with `.vertices` and `.faces`."""

from __future__ import annotations

from typing import Any

from feeler.interchange.assembly import Assembly
from feeler.words import counted


def is_ours(held: Any) -> bool:
    """Whether it is a scene, or has vertices and triangles."""
    return _is_scene(held) or (hasattr(held, "vertices") and hasattr(held, "faces"))


def hint(held: Any) -> str | None:
    """The error for an object of trimesh that is not a mesh."""
    if hasattr(held, "vertices") and not hasattr(held, "triangles"):
        return " (it has vertices and no faces: points or curves)"
    return None


def add(assembly: Assembly, held: Any, path: tuple[str, ...]) -> None:
    """Adds a mesh, or all meshes of a scene at all their places."""
    if not _is_scene(held):
        _add_mesh(assembly, held, path or (_name(held),), None, _units(held))
        return
    graph = held.graph
    parents = getattr(getattr(graph, "transforms", None), "parents", None) or {}
    base = getattr(graph, "base_frame", "world")
    placed = set()
    for node in graph.nodes_geometry:
        matrix, name = graph[node]
        placed.add(name)
        geometry = held.geometry[name]
        if not hasattr(geometry, "faces"):
            assembly.skip(f"geometries ({type(geometry).__name__})")
            continue
        units = _units(geometry) or _units(held)
        _add_mesh(assembly, geometry, (*path, *_ancestors(node, parents, base)), matrix, units)
    unused = len(set(held.geometry) - placed)
    if unused:
        assembly.notes.append(counted(unused, "geometries that the scene places nowhere add nothing"))


def _add_mesh(assembly: Assembly, mesh: Any, path: tuple[str, ...], matrix: Any, unit: str | None) -> None:
    assembly.add(path, mesh.vertices, mesh.faces, matrix=matrix, unit=unit)


def _is_scene(held: Any) -> bool:
    graph = getattr(held, "graph", None)
    return hasattr(graph, "nodes_geometry") and hasattr(held, "geometry")


def _ancestors(node: Any, parents: Any, base: Any) -> list[str]:
    """The names of a node and its ancestors, from the top down, without the world's."""
    names: list[str] = []
    seen = set()
    while node is not None and node != base and node not in seen:
        seen.add(node)
        names.append(str(node))
        node = parents.get(node)
    return names[::-1] or [str(base)]


def _units(held: Any) -> str | None:
    units = getattr(held, "units", None)
    return units if isinstance(units, str) and units.strip() else None


def _name(mesh: Any) -> str:
    metadata = getattr(mesh, "metadata", None)
    name = metadata.get("name") if isinstance(metadata, dict) else None
    return name if isinstance(name, str) else "part"
