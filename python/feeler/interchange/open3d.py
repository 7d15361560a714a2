"""Triangle meshes of Open3D: legacy, tensor-based, and models of several meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from feeler.errors import MeshError
from feeler.interchange.assembly import Assembly


def is_ours(held: Any) -> bool:
    """Whether it is a mesh of either API, or a model."""
    return _is_plain(held) or _is_tensor(held) or _is_model(held)


def add(assembly: Assembly, held: Any, path: tuple[str, ...]) -> None:
    """Adds a mesh, or each mesh of a model."""
    if _is_model(held):
        for info in held.meshes:
            add(assembly, info.mesh, (*path, str(info.mesh_name) or "part"))
        return
    if _is_tensor(held):
        vertices, faces = _tensor(held.vertex, "positions"), _tensor(held.triangle, "indices")
    else:
        vertices, faces = held.vertices, held.triangles
    assembly.add(path or ("part",), vertices, faces)


def _is_plain(held: Any) -> bool:
    return hasattr(held, "vertices") and hasattr(held, "triangles")


def _is_tensor(held: Any) -> bool:
    return hasattr(held, "vertex") and hasattr(held, "triangle")


def _is_model(held: Any) -> bool:
    meshes = getattr(held, "meshes", None)
    return meshes is not None and all(hasattr(each, "mesh") and hasattr(each, "mesh_name") for each in meshes)


def _tensor(held: Any, name: str) -> Any:
    if name not in held:
        raise MeshError(f"a tensor mesh of Open3D has no {name}: it is empty, or not finished")
    values = held[name]
    if hasattr(values, "cpu"):
        values = values.cpu()
    return values.numpy() if hasattr(values, "numpy") else np.asarray(values)
