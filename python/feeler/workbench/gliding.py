"""How a hand moves that contact leads: the proxy of `feeler.haptics`, with the mouse as its device.

A haptics session knows one scene, that of the parts in place. Parts that were put down elsewhere stop the tool: it does
not glide along them, and there is no force from them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from feeler.haptics import Session
from feeler.mockup import Tool
from feeler.workbench.motion import Floats
from feeler.workbench.world import Impact, World

STEP_S = 0.002
"""Of the session. One length for all steps: another would begin the force anew."""
MOST_STEPS = 16
"""Steps a tick at most: after a longer pause the hand catches up in the next ones."""


@dataclass(frozen=True)
class Glided:
    """Where the proxy is, force and torque on the hand, and the planes that hold it, with their parts."""

    pose: Floats
    force: Floats
    torque: Floats
    points: Floats
    normals: Floats
    parts: tuple[int, ...]
    impact: Impact | None


class Glide:
    """A proxy of a tool in a world; begun anew where either changes."""

    def __init__(self, world: World, tool: Tool) -> None:
        self._world, self._tool = world, tool
        self._session = Session(world.in_place, tool)

    def start(self, pose: Floats) -> bool:
        """Begins at a pose. False where the tool is in collision there."""
        return bool(self._session.start(pose))

    def step(self, pose: Floats, wish: Floats, steps: int) -> Glided:
        """Some steps toward a wish; `pose` is where the proxy is."""
        step = self._session.step(wish, STEP_S)
        for _ in range(steps - 1):
            step = self._session.step(wish, STEP_S)
        force, torque = step.force, step.torque  # zero where the session is in doubt
        after, impact = step.world_from_proxy, self._stopped(pose, step.world_from_proxy)
        if impact is not None:
            after = impact.pose if not self._world.is_colliding(self._tool, impact.pose) else pose
            force, torque = np.zeros(3), np.zeros(3)
            self._session.start(after)
        holds = step.planes.is_holding
        parts = tuple(int(part) for part in step.planes.parts[holds])
        return Glided(after, force, torque, step.planes.points[holds], step.planes.normals[holds], parts, impact)

    def _stopped(self, before: Floats, after: Floats) -> Impact | None:
        """What stops the proxy among the parts that were put down."""
        if self._world.put_down is None or np.array_equal(before, after):
            return None
        return self._world.cast_put_down(self._tool, before, after)
