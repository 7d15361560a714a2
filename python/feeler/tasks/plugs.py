"""Fasteners that do not leave with the part that they are in: set screws, pinch bolts and pressed nuts of which
something beside it is in the way."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from feeler.mockup import Tool
from feeler.scene import Scene
from feeler.tasks.fixings import Fixings

REACH = 0.5
"""What is this near may be in the way of a fastener, in diameters of its thread: its tip or its shank is in a groove,
or on a flat."""


def plugs_in_the_way(scene: Scene, fixings: Fixings, parts: Iterable[int]) -> frozenset[int]:
    """The fasteners that leave with the parts that they join, and that are near to something else; with them the
    others on their axes."""
    stuck = set(parts)
    found: set[int] = set()
    for part in sorted(stuck):
        joined = fixings.joins(part) if part in fixings else ()
        if joined and part not in found and stuck.issuperset(joined) and _is_unscrewed(fixings, part):
            axis = frozenset([part, *fixings.axis_mates(part)])
            found |= axis if any(_is_near(scene, fixings, each, axis) for each in sorted(axis)) else set()
    return frozenset(found - fixings.loose)


def _is_unscrewed(fixings: Fixings, part: int) -> bool:
    return fixings.is_turned(part) or fixings.is_plug(part)


def _is_near(scene: Scene, fixings: Fixings, part: int, axis: frozenset[int]) -> bool:
    """Whether a fastener is near to something but what it joins and what is on its axis."""
    row = fixings.shank(part)
    if row is None or not np.isfinite(row.size):
        return False
    own = {*axis, *(joined for each in axis for joined in fixings.joins(each))}
    own.update(washer for each in axis for washer in fixings.washers(each))
    others = scene.without(sorted(own))
    return bool(len(others.clearance(Tool.of_parts(scene.mockup, [part]), np.eye(4), REACH * row.size).parts))
