"""The way of gripped parts in the hand: thinned, with its clearance and touched parts."""

from __future__ import annotations

import numpy as np

from feeler._core import Collision, Impact
from feeler.mockup import Tool
from feeler.workbench.document import motion
from feeler.workbench.document.document import Trip
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.world import Pairs, World

STEP_M = 1e-3
"""Initial distance between poses of the way, by the fastest corner of the hand's box."""
MOST_POSES = 500
"""With more poses, every other one is dropped, and the distance doubled."""
REACH_M = 0.1
"""Larger distances are not reported as clearance."""


class TripRecorder:
    """Watches the hand from a grip to the release."""

    def __init__(self, tool: Tool, pose: Floats, trip: Trip | None, seated: Pairs) -> None:
        """trip: continues it; None: begins at a pose, with seated pairs of parts."""
        self._corners = motion.corners(tool.bounds)
        self._poses = [pose] if trip is None else [motion.matrix(each) for each in trip.way]
        self._step = STEP_M
        self._seated = seated if trip is None else trip.seated
        self.seat_parts = frozenset(part for _, part in self._seated)
        """Parts in contact at the grip."""
        self._touched: set[int] = set() if trip is None else set(trip.touched)

    def moved(self, pose: Floats, impact: Impact | None, hits: Collision) -> None:
        """Records a new pose of the hand, or a stop."""
        if motion.carried(self._poses[-1], pose, self._corners) >= self._step:
            self._poses.append(pose)
            if len(self._poses) > MOST_POSES:
                self._poses, self._step = self._poses[::2], 2 * self._step
        self._touched |= {part for part in hits.parts.tolist() if part not in self.seat_parts}
        if impact is not None and impact.part not in self.seat_parts:
            self._touched.add(impact.part)

    def so_far(self, pose: Floats) -> Trip:
        """The trip up to the hand's present pose."""
        poses = self._poses if np.array_equal(self._poses[-1], pose) else [*self._poses, pose]
        return Trip(tuple(motion.row(each) for each in poses), tuple(sorted(self._touched)), self._seated)


def least_clearance(world: World, tool: Tool, trip: Trip) -> float | None:
    """The smallest distance on the way of a trip, to all parts without seats; None beyond `REACH_M`."""
    way = np.array([motion.matrix(each) for each in trip.way])
    least = world.least_distance(tool, way, REACH_M, sorted(trip.seated))
    return least if least < REACH_M else None
