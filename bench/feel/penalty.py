"""A baseline: penalty forces summed over colliding triangles, as scene graphs for haptics commonly do it.

For each colliding pair of triangles, the tool's triangle is pushed out along the normal of the mock-up's, in proportion
to the depth of its deepest corner behind that plane. There is no memory, and no side except that of the normals: a
corner behind a triangle by more than half the tool's size does not penetrate this one. Written to be simple, not fast.
"""

from __future__ import annotations

import numpy as np

import feeler

from .faces import TICK_S, PlainCoupling, PlainStep, VirtualTool
from .meshes import Floats
from .poses import placed

STIFFNESS_N_PER_M = 500.0  # of each pair


class Penalty:
    """A virtual tool on a coupling, pushed by every pair of triangles that meets."""

    def __init__(
        self,
        scene: feeler.Scene,
        tool: feeler.Tool,
        *,
        coupling: PlainCoupling | None = None,
        stiffness_n_per_m: float = STIFFNESS_N_PER_M,
        seed: int = 0,
    ) -> None:
        del seed  # nothing here is random
        self.scene, self.tool, self.stiffness = scene, tool, stiffness_n_per_m
        self.virtual = VirtualTool(tool, coupling or PlainCoupling())
        mockup = scene.mockup
        self._vertices, self._faces = np.asarray(mockup.vertices), np.asarray(mockup.faces)
        self._tool_corners = np.asarray(tool.vertices)[np.asarray(tool.faces)]

    def start(self, pose: Floats) -> None:
        """Rest at a pose."""
        self.virtual.start(pose)

    def step(self, world_from_device: Floats, dt: float = TICK_S) -> PlainStep:
        """One tick."""
        force, torque, pairs = self.contact_wrench(self.virtual.pose)
        on_hand = self.virtual.step(world_from_device, force, torque, dt)
        return PlainStep(self.virtual.pose.copy(), *on_hand, planes=pairs, mode="contact" if pairs else "free")

    def contact_wrench(self, pose: Floats) -> tuple[Floats, Floats, int]:
        """Force and torque about the tool's middle at a pose, and how many pairs gave them."""
        pairs = np.asarray(self.scene.collide(self.tool, pose).pairs)
        if not len(pairs):
            return np.zeros(3), np.zeros(3), 0
        corners = placed(self._tool_corners[pairs[:, 0]].reshape(-1, 3), pose).reshape(-1, 3, 3)
        a, b, c = (self._vertices[self._faces[pairs[:, 1], k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.sqrt((normals**2).sum(axis=1, keepdims=True))
        heights = ((corners - a[:, None]) * normals[:, None]).sum(axis=2)
        deepest = heights.argmin(axis=1)
        rows = np.arange(len(pairs))
        depths = np.clip(-heights[rows, deepest], 0.0, self.virtual.size)
        forces = self.stiffness * depths[:, None] * normals
        arms = corners[rows, deepest] - placed(self.virtual.middle[None], pose)[0]
        return forces.sum(axis=0), np.cross(arms, forces).sum(axis=0), len(pairs)
