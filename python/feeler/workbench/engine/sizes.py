"""Area and volume of a part, from its triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup


@dataclass(frozen=True)
class Sizes:
    """area: square metres. volume: cubic metres; None if the triangles do not enclose one."""

    area: float
    volume: float | None


def sizes_of(mockup: Mockup, part: int) -> Sizes:
    """The sizes of a part. Its volume is that between the outer surface and the cavities."""
    faces = np.asarray(mockup.faces)[np.asarray(mockup.part_of_face) == part]
    corners = np.asarray(mockup.vertices, dtype=np.float64)[faces]
    if len(faces) == 0 or not np.isfinite(corners).all():
        return Sizes(0.0, None)
    # From a point nearby: large coordinates would cost digits.
    corners = corners - corners.reshape(-1, 3).mean(axis=0)
    one, two, three = corners[:, 0], corners[:, 1], corners[:, 2]
    area = 0.5 * float(np.linalg.norm(np.cross(two - one, three - one), axis=1).sum())
    if not _is_closed(corners):
        return Sizes(area, None)
    volume = float(np.einsum("ij,ij->i", one, np.cross(two, three)).sum()) / 6.0
    return Sizes(area, abs(volume))


def _is_closed(corners: npt.NDArray[np.float64]) -> bool:
    """Whether every edge has as many triangles on one side as on the other; corners are the same if their numbers are.

    corners: (n, 3, 3).
    """
    points = np.ascontiguousarray(corners.reshape(-1, 3)) + 0.0  # -0.0 is 0.0
    _, ids = np.unique(points.view([("", points.dtype)] * 3).ravel(), return_inverse=True)
    ids = ids.reshape(-1, 3).astype(np.int64)
    starts, ends = ids.ravel(), np.roll(ids, -1, axis=1).ravel()
    count = int(ids.max()) + 1
    return bool(np.array_equal(np.sort(starts * count + ends), np.sort(ends * count + starts)))
