"""Rigid motions: poses as rows of 16 numbers, what lies between two, and how far one carries."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import WorkbenchError
from feeler.poses import nearest_rigid, quaternion

Floats = npt.NDArray[np.float64]
Row = tuple[float, ...]
"""A pose `(4, 4)`, row by row: 16 numbers."""

HOME: Row = tuple(np.eye(4).ravel().tolist())
"""The identity: where a part was loaded."""

_NEARLY_RIGID = 1e-4  # what single precision, or a page that turns step by step, makes of a rotation
_LARGEST_M = 1e9


def row(pose: npt.ArrayLike) -> Row:
    """A pose as 16 numbers."""
    return tuple(np.asarray(pose, dtype=np.float64).ravel().tolist())


def matrix(pose: Row) -> Floats:
    """16 numbers as a pose `(4, 4)`."""
    return np.array(pose, dtype=np.float64).reshape(4, 4)


def checked(given: Any, where: str) -> Floats:
    """A pose somebody sent: 16 numbers or `(4, 4)`, rigid but for rounding, which is repaired.

    Raises `WorkbenchError`.
    """
    try:
        pose = np.array(given, dtype=np.float64)
        if pose.size != 16:
            raise ValueError(f"{pose.size} numbers")
        pose = pose.reshape(4, 4)
        if not np.isfinite(pose).all() or np.abs(pose[:3, 3]).max() > _LARGEST_M:
            raise ValueError("a number that is not finite, or is out of all reach")
        return nearest_rigid(pose, _NEARLY_RIGID)
    except (TypeError, ValueError) as error:
        raise WorkbenchError(f"this is no pose: {error}", where, "give 16 numbers, row by row, rigid, metres") from None


def inverse(pose: Floats) -> Floats:
    """The rigid inverse."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -(pose[:3, :3].T @ pose[:3, 3])
    return back


def shifted(offset: npt.ArrayLike) -> Floats:
    """A pose that only moves."""
    pose = np.eye(4)
    pose[:3, 3] = offset
    return pose


def rotation_vector(turn: Floats) -> Floats:
    """Axis times angle (radians, at most pi) of a rotation `(3, 3)`."""
    x, y, z, w = quaternion(turn)
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    axis = np.array([x, y, z])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-15:
        return np.zeros(3)
    return axis / sine * (2.0 * math.atan2(sine, w))


def rotation(vector: Floats) -> Floats:
    """The rotation `(3, 3)` of an axis times an angle (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-300:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Floats = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)
    return turn


def between(start: Floats, end: Floats, centre: Floats, share: float) -> Floats:
    """The pose at a share of the way: `centre` (of the tool, its frame) moves straight, the tool turns the shorter way.

    The motion that `Scene.cast` goes along.
    """
    if share <= 0.0:
        return start
    if share >= 1.0:
        return end
    turn = rotation_vector(end[:3, :3] @ start[:3, :3].T)
    pose = np.eye(4)
    pose[:3, :3] = rotation(share * turn) @ start[:3, :3]
    first, last = (p[:3, :3] @ centre + p[:3, 3] for p in (start, end))
    pose[:3, 3] = first + share * (last - first) - pose[:3, :3] @ centre
    return nearest_rigid(pose)


def corners(bounds: Floats) -> Floats:
    """The eight corners `(8, 3)` of a box `(2, 3)`."""
    picks = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return bounds[picks, [0, 1, 2]]


def carried(start: Floats, end: Floats, points: Floats) -> float:
    """How far, metres, the farthest of `(n, 3)` points is carried from one pose to the other."""
    moved = points @ (end[:3, :3] - start[:3, :3]).T + (end[:3, 3] - start[:3, 3])
    return float(np.sqrt((moved * moved).sum(axis=1).max()))
