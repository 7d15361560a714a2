"""`feeler.insertion`: the path of parts into their place, or to another place."""

from __future__ import annotations

import itertools
import math
import time
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_progress
from feeler.errors import OptionError
from feeler.io.film import corners_of
from feeler.mockup import Tool
from feeler.parts import PartsLike
from feeler.plan.legs import RemovalLeg
from feeler.plan.removal import DIRECT, Allowed, Removal, alone, rigid_pose, way_from
from feeler.poses import PoseLike, rotation_vector
from feeler.progress import Progress
from feeler.renamed import ALLOW, keywords
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

ROOM = 2.0
"""How far the moving parts stay off everything when they go around it, in diagonals of the whole."""


@keywords(gone={"allow": ALLOW})
def insertion(
    scene: Scene,
    parts: PartsLike,
    start: PoseLike | None = None,
    goal: PoseLike | None = None,
    tool: Tool | None = None,
    grip: PoseLike | None = None,
    ignore: PartsLike | None = None,
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 30.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    *,
    overlap: float = 0.0,
    seats: bool = True,
) -> Removal:
    """A path that brings parts into their place in the mock-up of a scene, or to another place.

    - `scene`, `parts`: with the parts in their places, as `feeler.removal` takes them.
    - `start`: `(4, 4)`, the pose where the parts are now, as a motion in the world from their place. The path begins
      there: out of the neighbours, around the mock-up, and in. Without it the path begins outside.
    - `goal`: `(4, 4)`, the final pose, as a motion from their place. Default: their place, the identity.
    - `tool`, `grip`: a hand or tool that holds the parts and moves with them; its pose `world_from_tool` when the parts
      are in their place, by default the identity. It must be free at `start` and `goal`.
    - all others: as `feeler.removal`; `directions` lead out of the goal.

    With `start`, the straight path is tried first; its `clearance` is not measured (NaN).

    Returns a `Removal` whose legs and poses lead from `start` to `goal`. If no path was found, it lists the blockers at
    the goal if the parts could not leave it, else those at the start.

    Raises the errors of `feeler.removal`, and `PoseError` for a `start` or `goal` that is not rigid.
    """
    begin = time.perf_counter()
    check_progress(progress)
    end = np.eye(4) if goal is None else rigid_pose(goal, "goal")
    lies = None if start is None else rigid_pose(start, "start")
    if tool is None and grip is not None:
        raise OptionError("grip is the pose of a tool that holds the parts, but there is no tool: give one")
    held = np.eye(4) if grip is None else rigid_pose(grip, "grip")
    allowed = Allowed.of(scene, ignore, overlap, seats)
    options: dict[str, Any] = {
        "tool": tool,
        "start": None if tool is None else held,
        "allowed": allowed,
        "clearance": clearance,
        "seed": seed,
        "threads": threads,
        "progress": _of_all(progress, begin, seconds),
    }
    direct = None if lies is None or clearance > 0.0 else partial(_direct, lies, end, allowed, seed)
    out = way_from(end, scene, parts, directions=directions, seconds=seconds, where="goal", first=direct, **options)
    if out.certificate.method == DIRECT:
        return replace(out, seconds=time.perf_counter() - begin)
    if lies is None:
        return replace(turned_round(out), seconds=time.perf_counter() - begin)
    moving = Tool.of_parts(scene.mockup, scene.mockup.parts.select(parts))
    if tool is not None:
        moving = Tool.assembly({"parts": moving, "tool": (tool, held)})
    middle = moving.bounds.mean(axis=0)
    if not out.is_found:
        if _moved_by(moving, lies, end) <= out.play:  # Within its play there may be a path, and this was not it.
            out = replace(out, held_by=(), play=math.nan)
        return replace(turned_round(out), seconds=time.perf_counter() - begin)
    left = max(seconds - (time.perf_counter() - begin), 1e-3)
    away = way_from(lies, scene, parts, directions=None, seconds=left, where="start", **options)
    link = _link(scene, parts, moving, away.poses[-1], out.poses[-1], clearance) if away.is_found else None
    if link is None:
        return replace(away, is_found=False, legs=(), poses=lies[None], seconds=time.perf_counter() - begin)
    back = turned_round(out)
    between = [_straight(a, b, middle) for a, b in itertools.pairwise(link) if not np.array_equal(a, b)]
    legs = (*away.legs, *between, *back.legs)
    return replace(
        back,
        legs=legs,
        poses=np.concatenate([away.poses, link[1:], back.poses[1:]]),
        path_length=sum(leg.path_length for leg in legs),
        rotation=sum(leg.rotation for leg in legs),
        clearance=min(away.clearance, back.clearance),
        certificate=replace(
            back.certificate,
            method=f"{away.certificate.method}, {back.certificate.method}",
            casts=away.certificate.casts + back.certificate.casts,
        ),
        seconds=time.perf_counter() - begin,
    )


def _of_all(progress: Progress | None, begin: float, seconds: float) -> Progress | None:
    """Progress of both searches as one: the share of the total time."""
    if not callable(progress):
        return progress
    told = progress
    return lambda _, stage: told(min(1.0, (time.perf_counter() - begin) / seconds), stage)


def _direct(lies: Floats, end: Floats, allowed: Allowed, seed: int, rest: Scene, moving: Tool) -> Removal | None:
    """The straight path from `lies` to `end`, without a leg where they are the same; None where it is not free. What
    touches may slide and part, unless there are no seats."""
    touching: Literal["counts", "free"] = "free" if allowed.seats else "counts"
    if not rest.check_path(moving, np.stack([lies, end]), touching=touching, ignore=allowed.pairs).is_free:
        return None
    is_there = np.array_equal(lies, end)
    legs = () if is_there else (_straight(lies, end, moving.bounds.mean(axis=0)),)
    found = alone(seed)
    return replace(
        found,
        legs=legs,
        poses=lies[None] if is_there else np.stack([lies, end]),
        path_length=sum(leg.path_length for leg in legs),
        rotation=sum(leg.rotation for leg in legs),
        clearance=math.nan,
        certificate=replace(found.certificate, method=DIRECT, casts=1),
    )


def _moved_by(moving: Tool, one: Floats, other: Floats) -> float:
    """The largest travel of a corner of its box to another pose, metres."""
    corners = corners_of(moving.bounds)
    places = [corners @ pose[:3, :3].T + pose[:3, 3] for pose in (one, other)]
    return float(np.linalg.norm(places[1] - places[0], axis=1).max())


def turned_round(way: Removal) -> Removal:
    """The reverse of a way."""
    if not way.is_found:
        return way
    ends = [way.poses[0], *(leg.pose for leg in way.legs)]

    def back(leg: RemovalLeg, to: Floats) -> RemovalLeg:
        x, y, z = (0.0 - number for number in leg.direction)
        screw = None if leg.screw is None else leg.screw.reversed()
        return replace(leg, screw=screw, pose=to, direction=(x, y, z))

    legs = [back(leg, to) for leg, to in zip(way.legs, ends[:-1], strict=True)]
    return replace(way, legs=tuple(reversed(legs)), poses=way.poses[::-1].copy())


def _link(scene: Scene, parts: PartsLike, moving: Tool, first: Floats, last: Floats, clearance: float) -> Floats | None:
    """Poses from one to another, both outside the box of the whole: straight if no clearance is required, or around the
    box; None if no attempt was free."""
    rest = scene.without(scene.mockup.parts.select(parts))
    bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)[rest.part_mask]
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    far = ROOM * float(np.linalg.norm(high - low) + np.linalg.norm(moving.bounds[1] - moving.bounds[0]))
    axes = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]

    def outwards(pose: Floats) -> list[Floats]:
        """Directions that lead away from the box: along them it gets no nearer to anything."""
        corners = moving.vertices @ pose[:3, :3].T + pose[:3, 3]
        return [axis for axis in axes if (corners @ axis).min() >= max(low @ axis, high @ axis)]

    ways = [np.stack([first, last])] if clearance == 0.0 else []
    for one, other in itertools.product(outwards(first), outwards(last)):
        for third in axes:
            ends = _moved(first, far * one), _moved(last, far * other)
            ways.append(np.stack([first, ends[0], *(_moved(end, far * third) for end in ends), ends[1], last]))
    return next((way for way in ways if rest.check_path(moving, way, inside=False).is_free), None)


def _moved(pose: Floats, by: Floats) -> Floats:
    moved = np.array(pose)
    moved[:3, 3] += by
    return moved


def _straight(before: Floats, pose: Floats, middle: Floats) -> RemovalLeg:
    """A leg from pose to pose."""
    by = (pose[:3, :3] - before[:3, :3]) @ middle + pose[:3, 3] - before[:3, 3]
    length = float(np.linalg.norm(by))
    x, y, z = (by / length if length > 0.0 else np.zeros(3)).tolist()
    angle = float(np.linalg.norm(rotation_vector(pose[:3, :3] @ before[:3, :3].T)))
    return RemovalLeg(None, pose, length, angle, (x, y, z))
