"""Geometries of a MuJoCo model as bodies: `from feeler.compat.mujoco import collision_manager`.

MuJoCo collides the convex hulls of meshes. Here they collide as they are. mujoco itself is not imported: a model and
its data are recognised by attributes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from feeler.arguments import shown
from feeler.compat.meshes import Floats, Triangles
from feeler.compat.trimesh import CollisionManager
from feeler.errors import MeshError
from feeler.mockup import mesh_indices, mesh_points

_MESH = 7
"""`mujoco.mjtGeom.mjGEOM_MESH`"""


def collision_manager(model: Any, data: Any = None) -> CollisionManager:
    """A manager of the geometries of a `mujoco.MjModel` that are meshes, by name (`geom_7` where the seventh has none).

    `data`: the `mujoco.MjData` that says where they are; None: move them later. Boxes, capsules and other shapes
    without triangles are left out. Raises `MeshError` for what is no model.
    """
    if not hasattr(model, "geom_dataid") or not hasattr(model, "mesh_vert"):
        raise MeshError(f"a mujoco.MjModel is needed, not {shown(model)}")
    manager = CollisionManager()
    for geom, name in _geoms(model):
        manager.add_object(name, _triangles(model, int(model.geom_dataid[geom])), _place(data, geom))
    return manager


def move(manager: CollisionManager, model: Any, data: Any) -> None:
    """Moves the bodies of a manager to where a `mujoco.MjData` has them: call it after `mujoco.mj_forward` or
    `mj_step`."""
    for geom, name in _geoms(model):
        manager.set_transform(name, _place(data, geom))


def _geoms(model: Any) -> list[tuple[int, str]]:
    meshes = np.flatnonzero(np.asarray(model.geom_type) == _MESH)
    return [(int(geom), model.geom(int(geom)).name or f"geom_{geom}") for geom in meshes]


def _triangles(model: Any, mesh: int) -> Triangles:
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    points = mesh_points(model.mesh_vert[first : first + count])
    return points, mesh_indices(model.mesh_face[start : start + faces], len(points))


def _place(data: Any, geom: int) -> Floats:
    place = np.eye(4)
    if data is not None:
        place[:3, :3] = np.reshape(data.geom_xmat[geom], (3, 3))
        place[:3, 3] = data.geom_xpos[geom]
    return place
