"""The nominal diameter of a thread, where the mesh shows its core."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from feeler.plan.fasteners import Fastener

WIDTHS_MM: dict[float, tuple[float, ...]] = {
    **{3.0: (5.5,), 4.0: (7.0,), 5.0: (8.0,), 6.0: (10.0,), 8.0: (13.0,), 10.0: (16.0, 17.0), 12.0: (18.0, 19.0)},
    **{14.0: (21.0, 22.0), 16.0: (24.0,), 18.0: (27.0,), 20.0: (30.0,), 24.0: (36.0,), 30.0: (46.0,), 36.0: (55.0,)},
}
"""Widths across flats by nominal diameter, ISO 272, millimetres: threads are drawn as core or outside."""
SOCKETS_MM: dict[float, tuple[float, ...]] = {
    **{1.6: (1.5,), 2.0: (1.5,), 2.5: (2.0,), 3.0: (2.5,), 4.0: (3.0,), 5.0: (4.0,), 6.0: (5.0,), 8.0: (6.0,)},
    **{10.0: (8.0,), 12.0: (10.0,), 14.0: (12.0,), 16.0: (14.0,), 20.0: (17.0,), 24.0: (19.0,), 30.0: (22.0,)},
    **{36.0: (27.0,), 42.0: (32.0,), 48.0: (36.0,), 56.0: (41.0,), 64.0: (46.0,)},
}
"""The same of hexagon sockets in cylindrical heads, ISO 4762."""
WIDTH_SHARE = 0.03
"""How near a width must be."""
SIZE_SHARE = (0.7, 1.3)
"""The diameter in the mesh, over that of the width, for the width to decide."""
CORE_SHARE = (0.7, 0.9)
"""The same for a shank that is drawn as the core of its thread: 0.75 for M2, 0.9 for M64 in ISO 724."""


def nominal(row: Fastener, size: float) -> float:
    """The nominal diameter, metres: by the width across flats, if the drive is a hexagon that fits; else `size`, that
    of the mesh."""
    return _by_width(row, size, SIZE_SHARE)


def thread_size(row: Fastener) -> float:
    """The diameter of the thread of a shank, metres: the nominal one, where the shank is drawn as its core."""
    return max(row.size, _by_width(row, row.size, CORE_SHARE)) if math.isfinite(row.size) else row.size


def radius_at(row: Fastener, corners: npt.NDArray[np.float64], height: float) -> float:
    """The outer radius of a fastener at a height in its frame, metres; 0 where it is not. corners: of its triangles."""
    below = (corners - row.frame[:3, 3]) @ row.frame[:3, :3]
    above = np.roll(below, -1, axis=1)
    is_across = (below[..., 2] <= height) != (above[..., 2] <= height)
    below, above = below[is_across], above[is_across]
    share = (height - below[:, 2:]) / (above[:, 2:] - below[:, 2:])
    points = below[:, :2] + share * (above[:, :2] - below[:, :2])
    return float(np.hypot(*points.T).max(initial=0.0))


def _by_width(row: Fastener, size: float, shares: tuple[float, float]) -> float:
    widths = {"hexagon": WIDTHS_MM, "hexagon socket": SOCKETS_MM}.get(row.drive)
    if widths is None or not math.isfinite(row.across_flats):
        return size
    fits = [
        1e-3 * thread
        for thread, some in widths.items()
        if any(abs(1e3 * row.across_flats - width) <= WIDTH_SHARE * width for width in some)
        and shares[0] <= 1e3 * size / thread <= shares[1]
    ]
    # M1.6 and M2 have one socket: their heads are as high as their threads are wide.
    likely = row.head_height if row.drive == "hexagon socket" and math.isfinite(row.head_height) else size
    return min(fits, key=lambda thread: abs(thread - likely), default=size)
