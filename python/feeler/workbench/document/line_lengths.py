"""How long the way of a line of the sequence is: one rule for the page, its files and reports."""

from __future__ import annotations

import numpy as np

from feeler.poses import inverse
from feeler.workbench.document.document import Removal
from feeler.workbench.document.motion import Floats, matrix, middle_of, steps_of


def line_steps(line: Removal, motions: Floats, bounds: Floats) -> tuple[list[float], list[float]]:
    """Travel and rotation from pose to pose, as `steps_of`, of the parts of a line.

    motions: of the parts, `(n, 4, 4)`. bounds: of all parts of the mock-up.
    """
    boxes = bounds.reshape(-1, 2, 3)[list(line.parts)]
    return steps_of(motions, middle_of(boxes, [line.before[part] for part in line.parts]))


def line_length(line: Removal, bounds: Floats) -> float:
    """The length of its way, metres."""
    way = np.array([matrix(pose) for pose in line.way])
    return sum(line_steps(line, way @ inverse(way[0]), bounds)[0])
