"""What films of moving parts share: how long a way takes, and which parts are shown beside those that move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from feeler.io.body import FloatArray
from feeler.mockup import Mockup

CONTEXT_M = 0.1
"""A film shows the parts that move, and those whose boxes are so near to where they begin."""
PAUSE_S = 0.5
"""Between two ways."""
_M_PER_S, _LEAST_S, _MOST_S = 0.25, 1.0, 20.0


def way_length(way: Sequence[FloatArray] | FloatArray) -> float:
    """Metres that the origin of what moves goes along poses `(n, 4, 4)`."""
    places = np.array([pose[:3, 3] for pose in way])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def seconds_of(length: float) -> float:
    """How long a film shows a way of so many metres."""
    return min(_MOST_S, max(_LEAST_S, length / _M_PER_S))


def with_neighbours(mockup: Mockup, moving: Sequence[int], absent: Sequence[int] = ()) -> list[int]:
    """Parts that move and those near them, ascending, but for those that are not there."""
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    near = np.zeros(len(boxes), dtype=bool)
    for part in moving:
        lower, upper = boxes[part, 0] - CONTEXT_M, boxes[part, 1] + CONTEXT_M
        near |= ((boxes[:, 0] <= upper) & (boxes[:, 1] >= lower)).all(axis=1)
    near[list(moving)] = True
    near[list(absent)] = False
    shown: list[int] = np.flatnonzero(near).tolist()
    return shown
