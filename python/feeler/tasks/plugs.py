"""Plugs and set screws that do not leave with the part that they are in: something beside it is in their way."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from feeler.mockup import Tool
from feeler.scene import Scene
from feeler.tasks.fixings import Fixings

REACH = 0.5
"""What is this near may be in the way of a plug, in diameters of its thread: its tip is in a groove, or on a flat."""


def plugs_in_the_way(scene: Scene, fixings: Fixings, parts: Iterable[int]) -> frozenset[int]:
    """The plugs that leave with parts of which they are in, and that are near to something else."""
    stuck = set(parts)
    own = [
        part for part in sorted(stuck) if part in fixings and fixings.is_plug(part) and fixings.anchor(part) in stuck
    ]
    return frozenset(part for part in own if _is_near(scene, fixings, part))


def _is_near(scene: Scene, fixings: Fixings, plug: int) -> bool:
    row, anchor = fixings.shank(plug), fixings.anchor(plug)
    if row is None or not np.isfinite(row.size) or anchor is None:
        return False
    others = scene.without([plug, anchor, *(each for each in fixings.washers(plug) if each != anchor)])
    return bool(len(others.clearance(Tool.of_parts(scene.mockup, [plug]), np.eye(4), REACH * row.size).parts))
