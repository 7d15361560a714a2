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
from feeler.workbench.world import NO_PAIRS, Impact, Pairs, World

OFF_M = 5e-7
"""The tool stops so far before an impact, along its way: where it rests, rounding cannot bring it into contact."""
_TOLERANCE_M = 2.5e-7  # of the casts: with `OFF_M`, a stop is early by less than the tolerance of `Scene.cast`
_STUCK_M = 1e-9  # so near to an impact that rounding decides which way is free; the planes tell better
_SLACK_M = 1e-9  # what rounding may do to a height above a plane; in a second of pushing less than the skin
_HALVINGS = 24
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
        self._core: _core.World | None = None
        if world.is_colliding(tool, pose):
            self._core = _core.World(world.in_place, tool, list(world.each_put_down().items()))
            self._core.begin(pose)

    def __bool__(self) -> bool:
        return self._core is not None

    def move(self, pose: Floats, wish: Floats) -> Moved:
        """From a pose toward a wish."""
        if self._core is None:
            return move(self._world, self._tool, pose, wish)
        goal, share, stop = self._core.stop(pose, wish, _TOLERANCE_M, OFF_M)
        if not self._core.seats():
            self._core = None
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


def move(world: World, tool: Tool, pose: Floats, wish: Floats) -> Moved:
    """From a pose at which nothing meets toward a wish."""
    found = _moved(world, tool, pose, wish, NO_PAIRS)
    impact = found.impact
    if impact is not None:
        way = motion.carried(pose, wish, motion.corners(tool.bounds))
        if impact.fraction * way < _STUCK_M < way:
            # No plane there may get deeper, and what is free stays free, by the exact test.
            along = _moved(world, tool, pose, wish, frozenset({(impact.tool_part, impact.part)}))
            if not world.is_colliding(tool, along.pose):
                found = along
    return found


def _moved(world: World, tool: Tool, pose: Floats, wish: Floats, seated: Pairs) -> Moved:
    impact: Impact | None = None
    goal = wish
    if seated:
        goal, impact = _kept_out(world, tool, pose, wish, seated)
    hit = world.cast(tool, pose, goal, seated, _TOLERANCE_M)
    if hit is not None:
        impact, goal = hit, _before(world, tool, pose, goal, hit, seated)
    return Moved(goal, impact)


def _before(world: World, tool: Tool, pose: Floats, goal: Floats, hit: Impact, seated: Pairs) -> Floats:
    """The pose `OFF_M` before an impact, from which on nothing meets by the exact test; or the one it came from."""
    way = motion.carried(pose, goal, motion.corners(tool.bounds))
    back = OFF_M / way if way > 0.0 else 1.0
    centre = tool.bounds.mean(axis=0)
    while back < hit.fraction:
        candidate = between(pose, goal, centre, hit.fraction - back)
        if world.cast(tool, pose, candidate, seated, _TOLERANCE_M) is None:
            return candidate
        back *= 2
    return pose


def _kept_out(world: World, tool: Tool, pose: Floats, wish: Floats, seated: Pairs) -> tuple[Floats, Impact | None]:
    """How far toward the wish no plane between some parts gets deeper, and the plane that ends it."""
    planes = world.contacts(tool, pose, _NEAR_M)
    holding = [i for i in range(len(planes)) if (int(planes.tool_parts[i]), int(planes.parts[i])) in seated]
    if not holding:
        return wish, None
    normals, points, footing = planes.normals[holding], planes.points[holding], planes.footing[holding]
    least = np.minimum(_heights(pose, normals, points, footing), 0.0) - _SLACK_M
    below = _heights(wish, normals, points, footing) - least
    if (below >= 0.0).all():
        return wish, None
    if np.array_equal(pose[:3, :3], wish[:3, :3]):
        share, plane = _share_of_shift(_heights(pose, normals, points, footing) - least, below)
        goal = pose.copy()
        goal[:3, 3] += share * (wish[:3, 3] - pose[:3, 3])
    else:
        centre = tool.bounds.mean(axis=0)
        share, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = (share + high) / 2
            at = _heights(between(pose, wish, centre, middle), normals, points, footing) - least
            if (at >= 0.0).all():
                share = middle
            else:
                high, below = middle, at
        goal, plane = between(pose, wish, centre, share), int(below.min(axis=1).argmin())
    at_plane = holding[plane]
    part, ours = int(planes.parts[at_plane]), int(planes.tool_parts[at_plane])
    return goal, Impact(share, goal, planes.points[at_plane], planes.normals[at_plane], part, ours)


def _heights(pose: Floats, normals: Floats, points: Floats, footing: Floats) -> Floats:
    """How far each point `(k, 4, 3)` of the contacts' footing is in front of its plane, metres, `(k, 4)`."""
    placed = footing @ pose[:3, :3].T + pose[:3, 3] - points[:, None]
    heights: Floats = np.einsum("kij,kj->ki", placed, normals)
    return heights


def _share_of_shift(before: Floats, after: Floats) -> tuple[float, int]:
    """Of a motion without a turn: the share at which the first height is 0, and the plane it belongs to."""
    falling = after < 0.0
    shares = np.where(falling, before / np.where(falling, before - after, 1.0), np.inf).min(axis=1)
    plane = int(shares.argmin())
    return max(0.0, float(shares[plane])), plane
