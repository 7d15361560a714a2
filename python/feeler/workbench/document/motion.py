"""Rigid motions: poses as rows of 16 numbers, and the distance between two."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import WorkbenchError
from feeler.poses import nearest_rigid, one_pose, rotation_vector

Floats = npt.NDArray[np.float64]
Row = tuple[float, ...]
"""A pose `(4, 4)`, row by row: 16 numbers."""

HOME: Row = tuple(np.eye(4).ravel().tolist())
"""The identity: the loaded place of a part."""

_NEARLY_RIGID = 1e-4  # deviation of rotations in single precision, or accumulated by a page
_LARGEST_M = 1e9


def row(pose: npt.ArrayLike) -> Row:
    """A pose as 16 numbers."""
    return tuple(np.asarray(pose, dtype=np.float64).ravel().tolist())


def matrix(pose: Row) -> Floats:
    """16 numbers as a pose `(4, 4)`."""
    return np.array(pose, dtype=np.float64).reshape(4, 4)


def checked(given: Any, where: str) -> Floats:
    """A received pose: 16 numbers, or of any kind that queries take; rigid up to rounding, which is repaired.

    Raises `WorkbenchError`.
    """
    try:
        pose = np.reshape(given, (4, 4)).astype(np.float64) if is_row(given) else one_pose(given, "it")
        if not np.isfinite(pose).all() or np.abs(pose[:3, 3]).max() > _LARGEST_M:
            raise ValueError("a number that is not finite, or is out of all reach")
        return nearest_rigid(pose, _NEARLY_RIGID)
    except (TypeError, ValueError, OverflowError) as error:
        raise WorkbenchError(
            f"this is not a pose: {error}", where, "give 16 numbers, row by row, or (4, 4), rigid, metres"
        ) from None


def is_row(given: Any) -> bool:
    """Whether these are 16 numbers."""
    is_list = isinstance(given, (list, tuple)) or (isinstance(given, np.ndarray) and given.ndim == 1)
    return is_list and len(given) == 16 and np.shape(given[:1]) == (1,)


def shifted(offset: npt.ArrayLike) -> Floats:
    """A translation."""
    pose = np.eye(4)
    pose[:3, 3] = offset
    return pose


def corners(bounds: Floats) -> Floats:
    """The eight corners `(8, 3)` of a box `(2, 3)`."""
    picks = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return bounds[picks, [0, 1, 2]]


def is_outside(box: Floats, place: Floats, bounds: Floats) -> bool:
    """Whether a box `(2, 3)` at a place lies beside `bounds` `(2, 3)`."""
    around = corners(box) @ place[:3, :3].T + place[:3, 3]
    return bool((around.max(axis=0) < bounds[0]).any() or (around.min(axis=0) > bounds[1]).any())


def carried(start: Floats, end: Floats, points: Floats) -> float:
    """The largest travel of `(n, 3)` points between two poses, metres."""
    moved = points @ (end[:3, :3] - start[:3, :3]).T + (end[:3, 3] - start[:3, 3])
    return float(np.sqrt((moved * moved).sum(axis=1).max()))


def middle_of(bounds: Floats, places: Sequence[Row]) -> Floats:
    """The middle `(3,)` of the box of parts where they lie. bounds: `(n, 2, 3)` of the parts where they were loaded."""
    around = []
    for box, place in zip(bounds, map(matrix, places), strict=True):
        around.append(corners(box) @ place[:3, :3].T + place[:3, 3])
    points = np.concatenate([each for each in around if np.isfinite(each).all()] or [np.zeros((1, 3))])
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2.0)


def steps_of(motions: Sequence[Floats] | Floats, middle: Floats) -> tuple[list[float], list[float]]:
    """The travel of a point from pose to pose, metres, and the rotation, radians.

    The length of a way is that of the middle of what moves, as `feeler.Removal.path_length`.
    """
    pairs = [*pairwise(motions)]
    travel = [carried(one, other, middle[None]) for one, other in pairs]
    return travel, [float(np.linalg.norm(rotation_vector(b[:3, :3] @ a[:3, :3].T))) for a, b in pairs]
