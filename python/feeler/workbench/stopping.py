"""How a hand moves that contact stops: from the pose it has to the one it is wished at, as far as the way is free.

`Scene.cast` goes the whole way between the two, so that how often the hand is asked, and how fast it moves, changes
nothing: the tool stands at the same pose, within the cast's tolerance, and passes nothing.

A tool that meets something where it begins (a part in its seat, a tool put down inside) may move out of it and slide
along it, and nothing else: pairs of parts that meet, or are nearer than `SEAT_M`, are *seated*. They are not cast, but
no contact plane between them may get deeper. Once a pair is farther apart it is as any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from feeler.mockup import Tool
from feeler.workbench import motion
from feeler.workbench.motion import Floats
from feeler.workbench.world import NO_PAIRS, Impact, Pairs, Planes, World

SEAT_M = 2e-5
"""A pair of parts that met at the start is seated until it is farther apart than this: the skin of `feeler.haptics`."""
OFF_M = 5e-7
"""The tool stops so far before an impact, along its way: where it rests, rounding cannot bring it into contact."""
_TOLERANCE_M = 2.5e-7  # of the casts: with `OFF_M`, a stop is early by less than the tolerance of `Scene.cast`
_STUCK_M = 1e-9  # so near to an impact that rounding decides which way is free; the planes tell better
_SLACK_M = 1e-9  # what rounding may do to a height above a plane; in a second of pushing less than the skin
_HALVINGS = 24


@dataclass(frozen=True)
class Moved:
    """Where the hand came. impact: what stopped it, None where it got where it was wished; seated: pairs now."""

    pose: Floats
    seated: Pairs
    impact: Impact | None


def seated_at(world: World, tool: Tool, pose: Floats) -> Pairs:
    """The pairs of parts that meet at a pose."""
    return frozenset(world.collide(tool, pose).part_pairs)


def move(world: World, tool: Tool, pose: Floats, wish: Floats, seated: Pairs) -> Moved:
    """From a pose toward a wish. `seated`: pairs as of the last move, or of `seated_at`."""
    found = _moved(world, tool, pose, wish, seated)
    impact = found.impact
    if impact is not None and (impact.tool_part, impact.part) not in seated:
        way = motion.carried(pose, wish, motion.corners(tool.bounds))
        if impact.fraction * way < _STUCK_M < way:
            # As if they were seated; what is free stays free, by the exact test.
            along = _moved(world, tool, pose, wish, seated | {(impact.tool_part, impact.part)})
            if not world.is_colliding(tool, along.pose, seated):
                found = along
    return Moved(found.pose, _still(world, tool, found.pose, seated), found.impact)


def _moved(world: World, tool: Tool, pose: Floats, wish: Floats, seated: Pairs) -> Moved:
    impact: Impact | None = None
    goal = wish
    if seated:
        goal, impact = _kept_out(world, tool, pose, wish, seated)
    hit = world.cast(tool, pose, goal, seated, _TOLERANCE_M)
    if hit is not None:
        impact, goal = hit, _before(world, tool, pose, goal, hit, seated)
    return Moved(goal, seated, impact)


def _before(world: World, tool: Tool, pose: Floats, goal: Floats, hit: Impact, seated: Pairs) -> Floats:
    """The pose `OFF_M` before an impact, from which on nothing meets by the exact test; or the one it came from."""
    way = motion.carried(pose, goal, motion.corners(tool.bounds))
    back = OFF_M / way if way > 0.0 else 1.0
    centre = tool.bounds.mean(axis=0)
    while back < hit.fraction:
        candidate = motion.between(pose, goal, centre, hit.fraction - back)
        if world.cast(tool, pose, candidate, seated, _TOLERANCE_M) is None:
            return candidate
        back *= 2
    return pose


def _still(world: World, tool: Tool, pose: Floats, seated: Pairs) -> Pairs:
    """The seated pairs that are not yet apart."""
    return frozenset(pair for pair in seated if world.is_near(tool, pose, pair, SEAT_M)) if seated else NO_PAIRS


def _kept_out(world: World, tool: Tool, pose: Floats, wish: Floats, seated: Pairs) -> tuple[Floats, Impact | None]:
    """How far toward the wish no plane between seated parts gets deeper, and the plane that ends it."""
    planes = world.contacts(tool, pose, SEAT_M)
    holding = [i for i in range(len(planes)) if (int(planes.tool_parts[i]), int(planes.parts[i])) in seated]
    if not holding:
        return wish, None
    centre = tool.bounds.mean(axis=0)

    def worst(share: float) -> tuple[float, int]:
        """By how much the deepest-going plane is deeper than at the start, and which it is."""
        at = motion.between(pose, wish, centre, share)
        return max((_deeper(planes, i, pose, at), i) for i in holding)

    deeper, plane = worst(1.0)
    if deeper <= _SLACK_M:
        return wish, None
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        deeper, at = worst(middle)
        if deeper <= _SLACK_M:
            low = middle
        else:
            high, plane = middle, at
    goal = motion.between(pose, wish, centre, low)
    part, ours = int(planes.parts[plane]), int(planes.tool_parts[plane])
    return goal, Impact(low, goal, planes.points[plane], planes.normals[plane], part, ours)


def _deeper(planes: Planes, plane: int, before: Floats, after: Floats) -> float:
    """How much deeper a contact's footing lies behind its plane, metres; what is in front of it may come to it."""
    normal, point, footing = planes.normals[plane], planes.points[plane], planes.footing[plane]
    was, now = ((footing @ p[:3, :3].T + p[:3, 3] - point) @ normal for p in (before, after))
    return float((np.minimum(was, 0.0) - now).max())
