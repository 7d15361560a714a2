"""`feeler.insertion`: the way of parts into their place."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import PoseError
from feeler.mockup import Tool
from feeler.parts import PartsLike
from feeler.plan.legs import RemovalLeg
from feeler.plan.removal import Allow, Progress, Removal, way_from
from feeler.poses import nearest_rigid, rotation_vector
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

ROOM = 2.0
"""How far what moves keeps off everything on its way around it, in diagonals of all there is."""


def insertion(
    scene: Scene,
    parts: PartsLike,
    start: npt.ArrayLike | None = None,
    allow: Allow = "start",
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 30.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Removal:
    """A way by which parts come into their place in the mock-up of a scene: that of a removal, turned round.

    - `scene`, `parts`: with the parts in their places, as `feeler.removal` takes them.
    - `start`: `(4, 4)`, where they lie now: their motion in the world from their place until there. The way begins
      there: out of what is around them, around all that is there, and in. Without it the way begins outside.
    - all else: as `feeler.removal`; `directions` lead out of the place.

    The answer is a `Removal` whose legs and poses lead from where the parts lie to the identity. Where no way was found
    it tells what was in the way, of the place if that was it, else of where they lie.

    Raises what `feeler.removal` raises, and `PoseError` for a `start` that is not rigid.
    """
    begin = time.perf_counter()
    lies = np.eye(4) if start is None else np.asarray(start, dtype=np.float64)
    if lies.shape != (4, 4):
        raise PoseError(f"start has shape {lies.shape}: one pose (4, 4) is needed")
    nearest_rigid(lies)  # An error where it is not rigid; its numbers are used as they are.
    options: dict[str, Any] = {
        "tool": None,
        "start": None,
        "allow": allow,
        "clearance": clearance,
        "seed": seed,
        "threads": threads,
        "progress": progress,
    }
    out = way_from(np.eye(4), scene, parts, directions=directions, seconds=seconds, **options)
    if start is None or not out.found:
        return replace(turned_round(out), seconds=time.perf_counter() - begin)
    left = max(seconds - (time.perf_counter() - begin), 1e-3)
    away = way_from(lies, scene, parts, directions=None, seconds=left, **options)
    link = _link(scene, parts, away.poses[-1], out.poses[-1], clearance) if away.found else None
    if link is None:
        return replace(away, found=False, legs=(), poses=lies[None], free=False, seconds=time.perf_counter() - begin)
    back = turned_round(out)
    middle = Tool.of_parts(scene.mockup, scene.mockup.parts.select(parts)).bounds.mean(axis=0)
    legs = (*away.legs, *(_straight(a, b, middle) for a, b in itertools.pairwise(link)), *back.legs)
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


def turned_round(way: Removal) -> Removal:
    """The way back along a way."""
    if not way.found:
        return way
    ends = [way.poses[0], *(leg.pose for leg in way.legs)]

    def back(leg: RemovalLeg, to: Floats) -> RemovalLeg:
        x, y, z = (0.0 - number for number in leg.direction)
        screw = None if leg.screw is None else leg.screw.reversed()
        return replace(leg, screw=screw, pose=to, direction=(x, y, z))

    legs = [back(leg, to) for leg, to in zip(way.legs, ends[:-1], strict=True)]
    return replace(way, legs=tuple(reversed(legs)), poses=way.poses[::-1].copy())


def _link(scene: Scene, parts: PartsLike, first: Floats, last: Floats, clearance: float) -> Floats | None:
    """Poses from one to another, both outside of the box of all there is: straight, where no clearance is asked for, or
    around it; None: none of the tries was free."""
    chosen = scene.mockup.parts.select(parts)
    moving, rest = Tool.of_parts(scene.mockup, chosen), scene.without(chosen)
    bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)[rest.part_mask]
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    far = ROOM * float(np.linalg.norm(high - low) + np.linalg.norm(moving.bounds[1] - moving.bounds[0]))
    axes = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]

    def outwards(pose: Floats) -> list[Floats]:
        """Along which it is beyond the box: from there it gets no nearer to anything."""
        corners = moving.vertices @ pose[:3, :3].T + pose[:3, 3]
        return [axis for axis in axes if (corners @ axis).min() >= max(low @ axis, high @ axis)]

    ways = [np.stack([first, last])] if clearance == 0.0 else []
    for one, other in itertools.product(outwards(first), outwards(last)):
        for third in axes:
            ends = _moved(first, far * one), _moved(last, far * other)
            ways.append(np.stack([first, ends[0], *(_moved(end, far * third) for end in ends), ends[1], last]))
    return next((way for way in ways if rest.check_path(moving, way, inside=False).free), None)


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
