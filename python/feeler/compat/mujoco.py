"""Geometries of a MuJoCo model as bodies: `from feeler.compat.mujoco import collision_manager`.

MuJoCo collides the convex hulls of meshes. Here they collide as they are. mujoco itself is not imported: a model and
its data are recognised by attributes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from feeler.arguments import check_kind, shown
from feeler.compat.meshes import Floats, Triangles
from feeler.compat.trimesh import CollisionManager
from feeler.errors import MeshError, PoseError
from feeler.mockup import mesh_indices, mesh_points

_MESH = 7
"""`mujoco.mjtGeom.mjGEOM_MESH`"""


def collision_manager(model: Any, data: Any = None) -> CollisionManager:
    """A manager of the geometries of a `mujoco.MjModel` that are meshes, by name (`geom_7` where number 7 has none).

    `data`: the `mujoco.MjData` that says where they are; None: move them later. Boxes, capsules and other shapes
    without triangles are left out. Raises `MeshError` for what is no model, and `PoseError` for data that
    `mujoco.mj_forward` has not seen.
    """
    manager = CollisionManager()
    for geom, name in _geoms(model):
        manager.add_object(name, _triangles(model, int(model.geom_dataid[geom])), _place(model, data, geom))
    return manager


def move(manager: CollisionManager, model: Any, data: Any) -> None:
    """Moves the bodies of a manager to where a `mujoco.MjData` has them: call it after `mujoco.mj_forward` or
    `mj_step`.

    Raises `OptionError` for a geometry that the manager does not have, `MeshError` for data of another model,
    `PoseError` for data that none of them has seen.
    """
    check_kind("manager", manager, CollisionManager, "a feeler.compat.trimesh.CollisionManager")
    if data is None:
        raise MeshError("a mujoco.MjData is needed, not None")
    for geom, name in _geoms(model):
        manager.set_transform(name, _place(model, data, geom))


def _geoms(model: Any) -> list[tuple[int, str]]:
    if not hasattr(model, "geom_dataid") or not hasattr(model, "mesh_vert"):
        raise MeshError(f"a mujoco.MjModel is needed, not {shown(model)}")
    meshes = [int(geom) for geom in np.flatnonzero(np.asarray(model.geom_type) == _MESH)]
    names = {geom: model.geom(geom).name for geom in meshes}
    taken = set(names.values())
    for geom in meshes:
        if not names[geom]:
            name = f"geom_{geom}"
            while name in taken:
                name += "_"
            taken.add(name)
            names[geom] = name
    return list(names.items())


def _triangles(model: Any, mesh: int) -> Triangles:
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    points = mesh_points(model.mesh_vert[first : first + count])
    return points, mesh_indices(model.mesh_face[start : start + faces], len(points))


def _place(model: Any, data: Any, geom: int) -> Floats:
    place = np.eye(4)
    if data is not None:
        turns, places = getattr(data, "geom_xmat", None), getattr(data, "geom_xpos", None)
        if turns is None or places is None or not len(turns) == len(places) == len(model.geom_type):
            raise MeshError(f"a mujoco.MjData of this model is needed, not {shown(data)}")
        place[:3, :3] = np.reshape(turns[geom], (3, 3))
        if not place[:3, :3].any():
            raise PoseError("the mujoco.MjData has no places yet: call mujoco.mj_forward(model, data) first")
        place[:3, 3] = places[geom]
    return place
