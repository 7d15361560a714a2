"""Pictures of `feeler move`: the worst position, and the motion as an animation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

import feeler
from feeler.errors import OptionError
from feeler.io.body import Body, body_of
from feeler.io.export import Motion, animated_glb, write_glb

Floats = npt.NDArray[np.float64]

_PART, _OTHER, _REST = (0.95, 0.55, 0.1), (0.8, 0.1, 0.1), (0.78, 0.78, 0.8)
_THICKNESS_SHARE = 0.002  # of the mock-up's size
_FRAMES = 121
_SECONDS = 4.0
_TURN = math.pi / 6.0
"""Keys are nearer, radians: players take the short way between two."""
_MOST_FRAMES = 20_000


def write_worst(path: Path, world: feeler.Mockup, found: feeler.MechanismClearance) -> str:
    """Writes the mock-up at the worst position: the moving part orange, the other one red, a line between the closest
    points."""
    from feeler.picture.bars import LEAST_THICKNESS_M, bars

    bodies: list[Body] = [body_of(world, colours=_colours(world, found))]
    if found.points is not None:
        lower, upper = world.bounds
        thickness = max(_THICKNESS_SHARE * float(np.linalg.norm(np.subtract(upper, lower))), LEAST_THICKNESS_M)
        ends = [np.array([point]) for point in found.points]
        line = bars(ends[0], ends[1], thickness, ["closest points"])
        bodies += [] if line is None else [line]
    write_glb(path, *bodies)
    return str(path)


def write_film(
    path: Path,
    moved: feeler.Mechanism,
    ranges: dict[str, float | tuple[float, float]],
    found: feeler.MechanismClearance,
) -> str:
    """Writes the motion of the one joint with a range, in four seconds."""
    from feeler.atomic import atomic_file

    ((name, (lower, upper)),) = [(name, each) for name, each in ranges.items() if isinstance(each, tuple)]
    stand = {each: value for each, value in ranges.items() if not isinstance(value, tuple)}
    poses: dict[str, list[Floats]] = {}
    positions = _positions(moved, stand, name, (lower, upper))
    for position in positions:
        for joint, pose in moved.poses(position, position).items():
            poses.setdefault(joint, []).append(pose)
    times = np.linspace(0.0, _SECONDS, len(positions))
    motions = [
        Motion(int(part), times, np.array(poses[joint.name]))
        for joint in moved.joints
        for part in moved.mockup.parts.select(joint.child)
    ]
    data = animated_glb(moved.mockup, motions, colours=_colours(moved.mockup, found))
    with atomic_file(path, ".glb") as file:
        file.write(data)
    return str(path)


def _positions(
    moved: feeler.Mechanism, stand: dict[str, float], name: str, ends: tuple[float, float]
) -> list[dict[str, float]]:
    """The positions of the keys, so many that nothing turns far between two."""
    turning = [each for joint in moved.joints for each, turns in zip(joint.names, joint.turns, strict=True) if turns]
    count = _FRAMES
    while count <= _MOST_FRAMES:
        found: list[dict[str, float]] = []
        for value in np.linspace(*ends, count).tolist():
            found.append(moved.position({**stand, name: value}, found[-1] if found else None))
        turns = np.array([[each[joint] for joint in turning] for each in found])
        farthest = float(np.abs(np.diff(turns, axis=0)).sum(axis=1).max())
        if farthest <= _TURN:
            return found
        count = (count - 1) * math.ceil(farthest / _TURN) + 1
    raise OptionError(f"--film of {name!r} has too many turns to show: give a smaller range")


def _colours(world: feeler.Mockup, found: feeler.MechanismClearance) -> Floats:
    colours = np.tile(np.array(_REST), (world.part_count, 1))
    if found.part is not None:
        colours[found.part] = _PART
    if found.other is not None:
        colours[found.other] = _OTHER
    return colours
