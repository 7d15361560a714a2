"""Cutting triangles with a plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def clip_triangles(corners: FloatArray, normal: FloatArray, offset: float) -> tuple[FloatArray, IntArray]:
    """What of the triangles lies on the side n.x <= offset.

    corners: (m, 3, 3). Returns (k, 3, 3) triangles and, for each, the (k,) index of the one it was cut from. A
    triangle that is cut becomes one or two, with its orientation kept.
    """
    height = corners @ normal - offset
    outside = height > 0
    count = outside.sum(axis=1)
    whole = np.flatnonzero(count == 0)
    pieces, sources = [corners[whole]], [whole]
    for lost in (1, 2):
        cut = np.flatnonzero(count == lost)
        if not len(cut):
            continue
        # Turn each triangle so that the corner that stands alone (outside if one is lost, inside if two) is first.
        alone = np.argmax(outside[cut] if lost == 1 else ~outside[cut], axis=1)
        turn = (alone[:, None] + np.arange(3)) % 3
        c = np.take_along_axis(corners[cut], turn[:, :, None], axis=1)
        h = np.take_along_axis(height[cut], turn, axis=1)
        along_b = (h[:, 0] / (h[:, 0] - h[:, 1]))[:, None]
        along_c = (h[:, 0] / (h[:, 0] - h[:, 2]))[:, None]
        at_b = c[:, 0] + along_b * (c[:, 1] - c[:, 0])
        at_c = c[:, 0] + along_c * (c[:, 2] - c[:, 0])
        if lost == 2:
            pieces.append(np.stack([c[:, 0], at_b, at_c], axis=1))
            sources.append(cut)
        else:
            pieces.append(np.stack([at_b, c[:, 1], c[:, 2]], axis=1))
            pieces.append(np.stack([at_b, c[:, 2], at_c], axis=1))
            sources += [cut, cut]
    return np.concatenate(pieces), np.concatenate(sources)
