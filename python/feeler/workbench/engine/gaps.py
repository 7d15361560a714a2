"""The nearest neighbour of moving parts, pose by pose."""

from __future__ import annotations

from collections.abc import Set
from typing import NamedTuple

import numpy as np

from feeler.mockup import Tool
from feeler.scene import Scene
from feeler.workbench.document.answers import Gap
from feeler.workbench.document.document import Point
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.world import World

SEATED_M = 1e-6
"""Parts as near as this at the start are in contact."""
WITHIN_M = 0.05
"""Larger distances are not reported as gaps."""


class Near(NamedTuple):
    """The nearest neighbour: its distance, its part, and the point on it."""

    gap: float
    part: int
    point: Point


def nearest(around: Scene | World, moving: Tool, pose: Floats, seated: Set[int]) -> Near | None:
    """The nearest neighbour at a pose, without seated parts; None: nothing is within reach."""
    rows = around.clearance(moving, pose, WITHIN_M)
    parts, distances = rows.parts.tolist(), rows.distances.tolist()
    others = [row for row, part in enumerate(parts) if part not in seated]
    if not others:
        return None
    row = min(others, key=lambda row: distances[row])
    x, y, z = np.asarray(rows.points_on_mockup[row], dtype=np.float64).tolist()
    return Near(distances[row], parts[row], (x, y, z))


class Gaps:
    """Gaps of a tool on a way, to all neighbours except those in contact at its start, as `feeler.removal` has them."""

    def __init__(self, around: Scene | World, moving: Tool, start: Floats) -> None:
        self._around, self._moving = around, moving
        self._seated = set(around.clearance(moving, start, SEATED_M).parts.tolist())

    def at(self, pose: Floats) -> Near | None:
        """The nearest neighbour at a pose; None: nothing is within reach."""
        return nearest(self._around, self._moving, pose, self._seated)


def gap_json(share: float, near: Near | None) -> Gap:
    """In the form for the page."""
    if near is None:
        return {"share": share, "gap": None, "part": None, "point": None}
    return {"share": share, "gap": near.gap, "part": near.part, "point": near.point}
