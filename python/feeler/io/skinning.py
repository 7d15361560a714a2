"""Skins: vertices that each follow several joints."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_CHUNK = 65536  # vertices processed at once, each with its own matrix of 128 bytes


def skinned(
    points: NDArray[np.float64], joint: NDArray[Any], weight: NDArray[Any], matrices: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return (points (n, 3) placed by their joints, whether each is mirrored there)."""
    placed = np.empty_like(points)
    mirrored = np.empty(len(points), dtype=bool)
    with np.errstate(all="ignore"):
        for at in range(0, len(points), _CHUNK):
            part = slice(at, at + _CHUNK)
            blend = np.zeros((len(points[part]), 4, 4))
            for column in range(joint.shape[1]):
                blend += weight[part, column, None, None] * matrices[joint[part, column]]
            x, y, z = (points[part, axis, None] for axis in range(3))
            placed[part] = ((blend[:, :3, 0] * x + blend[:, :3, 1] * y) + blend[:, :3, 2] * z) + blend[:, :3, 3]
            mirrored[part] = np.linalg.det(blend[:, :3, :3]) < 0
    return placed, mirrored
