"""What steps through positions: FCL and MuJoCo at given poses, and feeler at the same.

Each gives the least gap of a moving body over poses; 0 where it collides. None sees what lies between two.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import feeler

Floats = npt.NDArray[np.float64]
FAR_M = 1.0
"""Gaps beyond are not asked of MuJoCo."""


class Stepper(Protocol):
    """A library that is asked pose by pose."""

    name: str
    version: str

    def least(self, tool: feeler.Tool, around: feeler.Mockup) -> Callable[[Floats], float]:
        """Loads both; then the least gap over poses `(n, 4, 4)`, metres."""


class FeelerStepper:
    """feeler itself, `distance_batch`."""

    name = "feeler, stepped"
    version = feeler.__version__

    def least(self, tool: feeler.Tool, around: feeler.Mockup) -> Callable[[Floats], float]:
        scene = feeler.Scene(around, threads=1)
        return lambda poses: float(scene.distance_batch(tool, poses).values.min())


class FclStepper:
    """python-fcl: a `BVHModel` of all that moves and one of all that stands, `fcl.distance` at each pose."""

    name = "python-fcl"
    version = ""

    def __init__(self) -> None:
        self._fcl: Any = importlib.import_module("fcl")
        self.version = version("python-fcl")

    def least(self, tool: feeler.Tool, around: feeler.Mockup) -> Callable[[Floats], float]:
        fcl = self._fcl
        objects = []
        for mesh in (tool, around):
            model = fcl.BVHModel()
            vertices, faces = np.array(mesh.vertices), np.array(mesh.faces).astype(np.int64)
            model.beginModel(len(vertices), len(faces))
            model.addSubModel(vertices, faces)
            model.endModel()
            objects.append(fcl.CollisionObject(model, fcl.Transform()))
        moving, standing = objects

        def ask(poses: Floats) -> float:
            found = np.inf
            for pose in poses:
                moving.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
                if fcl.collide(moving, standing, fcl.CollisionRequest(), fcl.CollisionResult()):
                    return 0.0
                found = min(found, fcl.distance(moving, standing, fcl.DistanceRequest(), fcl.DistanceResult()))
            return float(found)

        return ask


class MujocoStepper:
    """MuJoCo: a mesh geom for each part, of which it takes the convex hull; `mj_geomDistance` of all pairs at each
    pose."""

    name = "MuJoCo"
    version = ""

    def __init__(self) -> None:
        self._mujoco: Any = importlib.import_module("mujoco")
        self.version = version("mujoco")

    def least(self, tool: feeler.Tool, around: feeler.Mockup) -> Callable[[Floats], float]:
        mujoco = self._mujoco
        spec = mujoco.MjSpec()
        mover = spec.worldbody.add_body(name="mover", mocap=True)
        for body, mesh, what in ((mover, tool, "t"), (spec.worldbody, around, "m")):
            of = np.asarray(mesh.part_of_face)
            for part in range(mesh.part_count):
                faces = np.asarray(mesh.faces)[of == part]
                used, index = np.unique(faces, return_inverse=True)
                name = f"{what}{part}"
                spec.add_mesh(
                    name=name,
                    uservert=np.asarray(mesh.vertices, dtype=np.float64)[used].ravel(),
                    userface=index.astype(np.int32).ravel(),
                )
                body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name)
        model = spec.compile()
        data = mujoco.MjData(model)
        ours, theirs = (
            [model.geom(f"{what}{part}").id for part in range(mesh.part_count)]
            for what, mesh in (("t", tool), ("m", around))
        )
        quaternion = np.empty(4)

        def ask(poses: Floats) -> float:
            found = np.inf
            for pose in poses:
                mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(pose[:3, :3]).ravel())
                data.mocap_pos[0], data.mocap_quat[0] = pose[:3, 3], quaternion
                mujoco.mj_kinematics(model, data)
                for one in ours:
                    for other in theirs:
                        found = min(found, mujoco.mj_geomDistance(model, data, one, other, FAR_M, None))
            return max(0.0, float(found))

        return ask


PEERS: dict[str, Callable[[], Stepper]] = {"python-fcl": FclStepper, "MuJoCo": MujocoStepper}


def peers(names: Sequence[str]) -> tuple[list[Stepper], dict[str, str]]:
    """The peers of these names that are installed; and of the others, why not."""
    there: list[Stepper] = []
    absent: dict[str, str] = {}
    for name in names:
        try:
            there.append(PEERS[name]())
        except ImportError as error:
            absent[name] = str(error)
    return there, absent
