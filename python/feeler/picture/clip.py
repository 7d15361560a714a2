"""Clips triangles by a plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def clip_triangles(corners: FloatArray, normal: FloatArray, offset: float) -> tuple[FloatArray, IntArray]:
    """The pieces of the triangles on the side n.x <= offset.

    corners: (m, 3, 3). Returns (k, 3, 3) triangles and, for each, the (k,) index of the one it was cut from. A
    triangle that is cut becomes one or two, with its orientation kept.
    """
    height = corners @ normal - offset
    outside = height > 0
    lost = outside.sum(axis=1)
    whole, cut = np.flatnonzero(lost == 0), np.flatnonzero((lost == 1) | (lost == 2))
    # Rotate each triangle so that its single corner (outside if one is lost, inside if two) is first.
    blunt = lost[cut] == 1
    turn = (np.argmax(outside[cut] == blunt[:, None], axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners[cut], turn[:, :, None], axis=1).transpose(1, 0, 2)
    at_a, at_b, at_c = np.take_along_axis(height[cut], turn, axis=1).T[:, :, None]
    ab, ac = a + at_a / (at_a - at_b) * (b - a), a + at_a / (at_a - at_c) * (c - a)
    tips, left, right = (np.stack(triangle, axis=1) for triangle in ((a, ab, ac), (ab, b, c), (ab, c, ac)))
    pieces = np.concatenate([corners[whole], tips[~blunt], left[blunt], right[blunt]])
    return pieces, np.concatenate([whole, cut[~blunt], cut[blunt], cut[blunt]])
