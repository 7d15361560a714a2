"""Motion of a hand guided by contact: the proxy of `feeler.haptics`, with the mouse as its device."""

from __future__ import annotations

from dataclasses import dataclass

from feeler.haptics import Session
from feeler.mockup import Tool
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.world import World

STEP_S = 0.002
"""Of the session."""
MOST_STEPS = 16
"""The most steps per tick: after a longer pause the hand catches up in the next ones."""


@dataclass(frozen=True, eq=False)
class Glided:
    """The proxy's pose, force and torque on the hand, and the active planes with their parts."""

    pose: Floats
    force: Floats
    torque: Floats
    points: Floats
    normals: Floats
    parts: tuple[int, ...]


class Glide:
    """The proxy of a tool in a world, from a pose on; restarted when either changes."""

    def __init__(self, world: World, tool: Tool, pose: Floats) -> None:
        self._session = Session(world.in_place, tool, put_down=world.put_down)
        self._session.start(pose)

    def step(self, wish: Floats, steps: int) -> Glided:
        """Some steps towards a wish. The force is zero while the session is in doubt."""
        step = self._session.step(wish, STEP_S)
        for _ in range(steps - 1):
            step = self._session.step(wish, STEP_S)
        planes, holds = step.planes, step.planes.is_holding
        parts = tuple(int(part) for part in planes.parts[holds])
        pose = step.world_from_proxy
        return Glided(pose, step.force, step.torque, planes.points[holds], planes.normals[holds], parts)
