"""The way of parts that lie outside of all others: straight away from them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.motion import Floats, Row

_AXES = "xyz"


def way_apart(scene: Scene, parts: Sequence[int]) -> tuple[tuple[Row, Row], str, float] | None:
    """From where they lie to their own size farther, with the direction, such as "+z", and the length in metres.

    The boxes of the parts and of the rest lie on two sides of a plane, and no distance between two points on two sides
    of it gets less. None if there is no such plane along an axis.
    """
    rest = scene.part_mask.copy()
    rest[list(parts)] = False
    moving, others = (_box(scene, some) for some in (list(parts), np.flatnonzero(rest)))
    if moving is None or others is None:
        return None
    gaps = [(float(moving[0][k] - others[1][k]), k, 1.0) for k in range(3)]
    gaps += [(float(others[0][k] - moving[1][k]), k, -1.0) for k in range(3)]
    gap, axis, sense = max(gaps)
    if not gap >= 0.0:
        return None
    long = max(float(moving[1][axis] - moving[0][axis]), float(np.max(moving[1] - moving[0])) / 2.0)
    step = np.zeros(3)
    step[axis] = sense * long
    return (motion.HOME, motion.row(motion.shifted(step))), f"{'+' if sense > 0.0 else '-'}{_AXES[axis]}", long


def _box(scene: Scene, parts: list[int] | npt.NDArray[np.intp]) -> tuple[Floats, Floats] | None:
    bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)[parts]
    bounds = bounds[np.isfinite(bounds).all(axis=(1, 2)) & (bounds[:, 0] <= bounds[:, 1]).all(axis=1)]
    return (bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)) if len(bounds) else None
