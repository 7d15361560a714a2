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
from feeler.poses import between
from feeler.workbench import motion
from feeler.workbench.motion import Floats
from feeler.workbench.world import NO_PAIRS, Impact, Pairs, World

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
    still = seated if np.array_equal(found.pose, pose) else _still(world, tool, found.pose, seated)
    return Moved(found.pose, still, found.impact)


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
        candidate = between(pose, goal, centre, hit.fraction - back)
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
