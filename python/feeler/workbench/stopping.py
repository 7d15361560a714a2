"""How a hand moves that contact stops: from the pose it has to the one it is wished at, as far as the way is free.

`Scene.cast` goes the whole way between the two, so that how often the hand is asked, and how fast it moves, changes
nothing: the tool stands at the same pose, within the cast's tolerance, and passes nothing.

What a tool meets where it begins (a part in its seat, a tool put down inside) is a seat, by the one rule of
`feeler._core.World`: it may slide along that and part from it, goes no deeper, and meets all other surfaces exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from feeler import _core
from feeler.mockup import Tool
from feeler.poses import between
from feeler.workbench import motion
from feeler.workbench.motion import Floats
from feeler.workbench.world import Impact, World

OFF_M = 5e-7
"""The tool stops so far before an impact, along its way: where it rests, rounding cannot bring it into contact."""
_TOLERANCE_M = 2.5e-7  # of the casts: with `OFF_M`, a stop is early by less than the tolerance of `Scene.cast`
_STUCK_M = 1e-9  # so near to an impact that rounding decides which way is free; seats tell better
_NEAR_M = 2e-5  # planes that may stop the tool: more than it is off them


@dataclass(frozen=True)
class Moved:
    """Where the hand came. impact: what stopped it, None where it got where it was wished."""

    pose: Floats
    impact: Impact | None


class Seats:
    """What a tool is seated on: all that it meets at a pose, until it has parted from it."""

    def __init__(self, world: World, tool: Tool, pose: Floats) -> None:
        """Where nothing meets, nothing is sought."""
        self._world, self._tool = world, tool
        self._core = self._begun(pose) if world.is_colliding(tool, pose) else None
        self._near: tuple[Floats, _core.World] | None = None

    def move(self, pose: Floats, wish: Floats) -> Moved:
        """From a pose toward a wish."""
        if self._core is None:
            return self._move_free(pose, wish)
        moved = self._move_seated(self._core, pose, wish)
        if not self._core.seats():
            self._core = None
        return moved

    def _begun(self, pose: Floats) -> _core.World:
        core = _core.World(self._world.in_place, self._tool, list(self._world.each_put_down().items()))
        core.begin(pose)
        return core

    def _move_free(self, pose: Floats, wish: Floats) -> Moved:
        """From a pose at which nothing meets."""
        world, tool = self._world, self._tool
        hit = world.cast(tool, pose, wish, tolerance=_TOLERANCE_M)
        if hit is None:
            return Moved(wish, None)
        way = motion.carried(pose, wish, motion.corners(tool.bounds))
        if hit.fraction * way < _STUCK_M < way:
            # As a seat; what is free stays free, by the exact test.
            if self._near is None or not np.array_equal(self._near[0], pose):
                self._near = pose, self._begun(pose)
            along = self._move_seated(self._near[1], pose, wish)
            if not world.is_colliding(tool, along.pose):
                return along
        return Moved(_before(world, tool, pose, wish, hit), hit)

    def _move_seated(self, core: _core.World, pose: Floats, wish: Floats) -> Moved:
        goal, share, stop = core.stop(pose, wish, _TOLERANCE_M, OFF_M)
        if stop is None:
            return Moved(goal, None)
        part, ours, _ = stop
        return Moved(goal, self._impact(share, goal, wish, part, ours))

    def _impact(self, share: float, pose: Floats, wish: Floats, part: int, ours: int) -> Impact:
        """At the contact plane of the part that the wish leads through; where there is none, at the nearest point."""
        ahead = wish[:3, 3] - pose[:3, 3]
        planes = self._world.contacts(self._tool, pose, _NEAR_M)
        own = np.flatnonzero(planes.parts == part)
        if len(own):
            plane = own[(planes.normals[own] @ ahead).argmin()]
            ours = int(planes.tool_parts[plane])
            return Impact(share, pose, planes.points[plane], planes.normals[plane], part, ours)
        near = self._world.distance(self._tool, pose, np.inf)
        point = pose[:3, 3] if near is None else near.mockup_point
        length = float(np.linalg.norm(ahead))
        return Impact(share, pose, point, -ahead / length if length else np.array([0.0, 0.0, 1.0]), part, ours)


def _before(world: World, tool: Tool, pose: Floats, goal: Floats, hit: Impact) -> Floats:
    """The pose `OFF_M` before an impact, from which on nothing meets by the exact test; or the one it came from."""
    way = motion.carried(pose, goal, motion.corners(tool.bounds))
    back = OFF_M / way if way > 0.0 else 1.0
    centre = tool.bounds.mean(axis=0)
    while back < hit.fraction:
        candidate = between(pose, goal, centre, hit.fraction - back)
        if world.cast(tool, pose, candidate, tolerance=_TOLERANCE_M) is None:
            return candidate
        back *= 2
    return pose
