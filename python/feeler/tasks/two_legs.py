"""Ways of two straight legs: out of a pocket until something stops it, or less far, and then sideways."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.plan.blocking import way_out
from feeler.plan.legs import RemovalLeg
from feeler.plan.question import Direction
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

STOPS = (0.998, 0.9, 0.7, 0.5)
"""Where the second leg is tried first: at shares of the first, as far as it is free."""
SHORTER = (1.0 / 32.0, 1.0 / 16.0, 0.125, 0.25, 0.5)
"""Shares of the first leg that are tried with a second leg that is known to be free."""
ACROSS = 0.9
"""Legs with a larger cosine are along each other."""
LEAST_SHARE = 0.02
"""The first leg is at least this long, in sizes of the part."""


def two_legs(
    scene: Scene, parts: Sequence[int], directions: Sequence[Direction], look: Callable[[], None]
) -> tuple[RemovalLeg, ...]:
    """The legs that take parts out of a scene along two of some directions; none where no two are free.

    directions: units, in the world; the first ones are tried first. look: called often; what it raises ends the work.
    """
    tool, rest = Tool.of_parts(scene.mockup, list(parts)), scene.without(list(parts))
    size = float(np.linalg.norm(tool.bounds[1] - tool.bounds[0]))

    def is_free(begin: Floats, way: Floats) -> bool:
        look()
        return rest.cast(tool, begin, _moved(begin, way), touching="free") is None

    for first in directions:
        look()
        along, out = np.array(first), way_out(scene, tool, first)
        hit = rest.cast(tool, np.eye(4), _moved(np.eye(4), out * along), touching="free")
        free = out if hit is None else float(hit.pose[:3, 3] @ along)
        if free < LEAST_SHARE * size:
            continue
        if hit is None:
            return (_leg(np.eye(4), along, out),)
        for second in directions:
            across = np.array(second)
            if abs(float(across @ along)) > ACROSS:
                continue
            far = way_out(scene, tool, second) + free
            for share in STOPS:
                stop = _moved(np.eye(4), share * free * along)
                if is_free(stop, far * across):
                    shares = (each for each in SHORTER if each < share)
                    low = (_moved(np.eye(4), each * free * along) for each in shares)
                    stop = next((each for each in low if is_free(each, far * across)), stop)
                    return (
                        _leg(np.eye(4), along, float(stop[:3, 3] @ along)),
                        _leg(stop, across, far),
                    )
    return ()


def _moved(pose: Floats, way: Floats) -> Floats:
    moved = np.eye(4)
    moved[:3, 3] = pose[:3, 3] + way
    return moved


def _leg(begin: Floats, unit: Floats, far: float) -> RemovalLeg:
    x, y, z = unit.tolist()
    return RemovalLeg(None, _moved(begin, far * unit), far, 0.0, (x, y, z))
