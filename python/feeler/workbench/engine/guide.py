"""A way that guides the hand: draws wishes towards it, and tells a device where its nearest place is.

The pull is bounded: from a distance of the way on there is none, so that the hand can always leave it. It changes the
wish alone; what contact allows stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from feeler.poses import between
from feeler.workbench.document import motion
from feeler.workbench.document.motion import Floats

SNAP_SHARE, REACH_SHARE = 0.1, 0.4
"""Of the size of what is in the hand: nearer than the first, the hand is on the way; farther than the second, it is
free. Larger values hold it more firmly."""
LEAST_SNAP_M, MOST_SNAP_M = 0.002, 0.05
LEAST_REACH_M, MOST_REACH_M = 0.01, 0.2
ALONG_N = 0.3
"""The pull along the way, of a device."""
_AT_END = 0.999


@dataclass(frozen=True, eq=False)
class Near:
    """The nearest place of a way. share: of its length, 0 to 1. off: of the fastest corner, metres. along: the unit
    direction of the middle of what is in the hand, or zeros where it only turns."""

    pose: Floats
    share: float
    off: float
    along: Floats


class Guide:
    """Immutable, for any thread."""

    def __init__(self, way: Floats, bounds: Floats) -> None:
        """way: `(n, 4, 4)` world_from_hand; bounds: `(2, 3)` of what is in the hand."""
        self._way, self._middle, self._corners = way, bounds.mean(axis=0), motion.corners(bounds)
        # A place of the way is where the corners are: turns count by how far they carry these.
        self._points = (self._corners @ way[:, :3, :3].transpose(0, 2, 1) + way[:, None, :3, 3]).reshape(len(way), -1)
        steps = np.diff(self._points, axis=0)
        self._steps, self._squares = steps, np.maximum((steps * steps).sum(axis=1), 1e-300)
        lengths = np.sqrt(self._squares)
        self._gone = np.concatenate([[0.0], np.cumsum(lengths)])
        size = float(np.linalg.norm(bounds[1] - bounds[0]))
        self.snap = float(np.clip(SNAP_SHARE * size, LEAST_SNAP_M, MOST_SNAP_M))
        self.reach = float(np.clip(REACH_SHARE * size, LEAST_REACH_M, MOST_REACH_M))

    def nearest(self, pose: Floats) -> Near | None:
        """The nearest place of the way; None for a pose that is none."""
        if not np.isfinite(pose).all():
            return None
        points = (self._corners @ pose[:3, :3].T + pose[:3, 3]).ravel()
        if len(self._way) == 1:
            off = motion.carried(pose, self._way[0], self._corners)
            return Near(self._way[0], 1.0, off, np.zeros(3))
        shares = np.clip(((points - self._points[:-1]) * self._steps).sum(axis=1) / self._squares, 0.0, 1.0)
        rest = points - self._points[:-1] - shares[:, None] * self._steps
        # Of equally near places the last one: a way that waits goes on.
        squares = (rest * rest).sum(axis=1)
        leg = len(squares) - 1 - int(np.argmin(squares[::-1]))
        share = float(shares[leg])
        there = between(self._way[leg], self._way[leg + 1], self._middle, share)
        whole = max(float(self._gone[-1]), 1e-300)
        gone = float(self._gone[leg] + share * (self._gone[leg + 1] - self._gone[leg])) / whole
        step = self._middle_at(self._way[leg + 1]) - self._middle_at(self._way[leg])
        length = float(np.linalg.norm(step))
        along = step / length if length > 1e-9 else np.zeros(3)
        return Near(there, gone, motion.carried(pose, there, self._corners), along)

    def drawn(self, wish: Floats) -> Floats:
        """A wish, drawn towards the nearest place of the way: onto it from nearby, less from farther away, and not at
        all from afar."""
        near = self.nearest(wish)
        if near is None:
            return wish
        share = self.pull_of(near.off)
        return between(wish, near.pose, self._middle, share)

    def pull_of(self, off: float) -> float:
        """How much of the way's pull acts so far off it: 1 on it, 0 from afar and in doubt."""
        if not 0.0 <= off < self.reach:
            return 0.0
        return 1.0 if off <= self.snap else (self.reach - off) / (self.reach - self.snap)

    def held(self, pose: Floats) -> tuple[Floats, Floats] | None:
        """For a device: the place of the way that draws it, and the pull along the way in newtons; None: nothing."""
        near = self.nearest(pose)
        share = 0.0 if near is None else self.pull_of(near.off)
        if near is None or share <= 0.0:
            return None
        along = near.along * (ALONG_N * share if near.share < _AT_END else 0.0)
        return near.pose, along

    def is_at_end(self, pose: Floats) -> bool:
        """Whether the hand has come to the end of the way."""
        near = self.nearest(pose)
        return near is not None and near.share >= _AT_END and near.off <= self.snap

    def _middle_at(self, pose: Floats) -> Floats:
        middle: Floats = pose[:3, :3] @ self._middle + pose[:3, 3]
        return middle
