"""Captive screws: a neck in the hole of a part, and a thread below it that does not go through that hole."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler.depths import deepest
from feeler.mockup import Tool
from feeler.plan.blocking import DEEPER_M, DEEPER_SHARE
from feeler.plan.fasteners import Fastener
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

NECK = 0.985
"""A shank with less than this share of the radius of its thread has a neck there."""
_SHARES = np.linspace(0.0, 1.0, 33)[1:]
"""Where, on the way of a screw that crosses its hole, depths are measured."""
_CLOSER = 12
"""How often the way between two of them is halved."""


def has_neck(vertices: Floats, row: Fastener) -> bool:
    """Whether a shank is wider somewhere below a narrower place, as threads of captive screws and wound ones are."""
    local = (vertices - row.frame[:3, 3]) @ row.frame[:3, :3]
    head = row.head_height if np.isfinite(row.head_height) else 0.0
    shank = local[local[:, 2] <= -head + 1e-3 * row.size]
    if not len(shank):
        return False
    order = np.argsort(shank[:, 2])
    radii = np.hypot(shank[order, 0], shank[order, 1])
    return bool((radii < NECK * np.maximum.accumulate(radii)).any())


def free_travel(alone: Scene, own: Tool, axis: Floats, far: float) -> float | None:
    """How far a screw is drawn out of one part before it meets it, metres; None if it comes out. alone: that part."""

    def pose(along: float) -> Floats:
        moved = np.eye(4)
        moved[:3, 3] = along * axis
        return moved

    contacts = alone.collide(own, np.eye(4))
    if not (contacts.kinds == "crossing").any():
        hit = alone.cast(own, np.eye(4), pose(far), touching="free")
        return None if hit is None else float(hit.pose[:3, 3] @ axis)
    # The facets of its hole may cross it all the way: it is met where it is entered deeper.
    limit = DEEPER_M + (1.0 + DEEPER_SHARE) * depth(alone, own, np.eye(4))
    last = 0.0
    for share in _SHARES:
        if depth(alone, own, pose(far * share)) > limit:
            first = far * float(share)
            for _ in range(_CLOSER):
                middle = 0.5 * (last + first)
                last, first = (last, middle) if depth(alone, own, pose(middle)) > limit else (middle, first)
            return last
        last = far * float(share)
    return None


def depth(alone: Scene, tool: Tool, pose: Floats) -> float:
    """How deep a tool is in a part that is alone in its scene, metres."""
    return max(deepest(alone, tool, pose).values(), default=0.0)
