"""Pictures of `feeler move`: the worst position, and the motion as an animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

import feeler
from feeler.io.body import Body, body_of
from feeler.io.export import Motion, animated_glb, write_glb

Floats = npt.NDArray[np.float64]

_PART, _OTHER, _REST = (0.95, 0.55, 0.1), (0.8, 0.1, 0.1), (0.78, 0.78, 0.8)
_THICKNESS_SHARE = 0.002  # of the mock-up's size
_FRAMES = 121
_SECONDS = 4.0


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
    last: dict[str, float] | None = None
    for value in np.linspace(lower, upper, _FRAMES).tolist():
        last = moved.position({**stand, name: value}, last)
        for joint, pose in moved.poses(last, last).items():
            poses.setdefault(joint, []).append(pose)
    times = np.linspace(0.0, _SECONDS, _FRAMES)
    motions = [
        Motion(int(part), times, np.array(poses[joint.name]))
        for joint in moved.joints
        for part in moved.mockup.parts.select(joint.child)
    ]
    data = animated_glb(moved.mockup, motions, colours=_colours(moved.mockup, found))
    with atomic_file(path, ".glb") as file:
        file.write(data)
    return str(path)


def _colours(world: feeler.Mockup, found: feeler.MechanismClearance) -> Floats:
    colours = np.tile(np.array(_REST), (world.part_count, 1))
    if found.part is not None:
        colours[found.part] = _PART
    if found.other is not None:
        colours[found.other] = _OTHER
    return colours
