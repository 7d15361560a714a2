"""Axes of loops that are parallel, or at right angles, but for rounding: a loop only moves if they are so exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from feeler.mechanism.joint import Joint, JointKind

Floats = npt.NDArray[np.float64]

ROUNDING_RAD = 1e-5
"""Axes that are off by less are meant to be parallel, or at right angles."""
_MEANT_RAD = 0.1  # a smaller angle between two axes may be intended: it is reported if the loop does not move


def aligned(joints: Sequence[Joint]) -> list[Joint]:
    """The joints of a loop with axes that are exactly parallel, or at right angles, where they are so but for
    rounding; joints whose axes are exact stay as they are."""
    if not joints:
        return []
    axes = np.array([joint.axis for joint in joints])
    known: list[Floats] = [_main(joints, axes)]
    found = []
    for joint, axis in zip(joints, axes, strict=True):
        near = next((each for each in known if _angle(each, axis) <= ROUNDING_RAD), None)
        if near is None:
            along = float(known[0] @ axis)
            near = axis
            if 0.0 < abs(along) <= ROUNDING_RAD:
                near = axis - along * known[0]
                near /= np.linalg.norm(near)
            known.append(near)
        turned = near if near @ axis > 0.0 else 0.0 - near
        found.append(joint if np.array_equal(turned, axis) else replace(joint, axis=tuple(turned.tolist())))
    return found


def skew(joints: Sequence[Joint]) -> str:
    """Which axis of a loop is nearly parallel to the others, but by more than rounding; empty for none."""
    axes = np.array([joint.axis for joint in joints])
    main = _main(joints, axes)
    off = [(_angle(main, axis), joint.name) for joint, axis in zip(joints, axes, strict=True)]
    angle, name = max((each for each in off if each[0] <= _MEANT_RAD), default=(0.0, ""))
    if angle <= ROUNDING_RAD:
        return ""
    return (
        f"the axes of the loop are not parallel: {name!r} is off by {angle:.3g} rad ({math.degrees(angle):.3g} degrees)"
    )


def _main(joints: Sequence[Joint], axes: Floats) -> Floats:
    """The direction about which most joints turn: the mean of those that are parallel but for rounding."""
    weights = np.array([1.0 if joint.kind is JointKind.PRISMATIC else len(joints) for joint in joints])
    near = np.array([[_angle(one, other) <= ROUNDING_RAD for other in axes] for one in axes])
    best = int(np.argmax(near @ weights))
    same = axes[near[best]]
    same = same * np.where(same @ axes[best] > 0.0, 1.0, -1.0)[:, None]
    if (same == axes[best]).all():
        return np.asarray(axes[best], dtype=np.float64)
    mean = same.sum(axis=0)
    return np.asarray(mean / np.linalg.norm(mean), dtype=np.float64)


def _angle(one: Floats, other: Floats) -> float:
    """Between two lines."""
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), abs(float(one @ other)))
