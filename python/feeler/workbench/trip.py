"""The way of gripped parts while they are in the hand: thinned, with what it came near and touched."""

from __future__ import annotations

import numpy as np

from feeler.mockup import Tool
from feeler.workbench import motion
from feeler.workbench.commands import Trip
from feeler.workbench.motion import Floats
from feeler.workbench.world import Hits, Impact, Pairs, World

STEP_M = 1e-3
"""Poses of the way are at first so far apart, by the corner of the hand's box that is carried farthest."""
MOST_POSES = 500
"""With more, every other one is left out, and the step doubled."""
REACH_M = 0.1
"""What was never nearer than this is no clearance worth a figure."""


class TripRecorder:
    """Watches the hand from a grip to the release."""

    def __init__(self, tool: Tool, pose: Floats, seated: Pairs) -> None:
        """seated: pairs of parts that meet at the grip; they are neither clearance nor touch."""
        self._corners = motion.corners(tool.bounds)
        self._poses, self._step = [pose], STEP_M
        self._seated = seated
        self._seat_parts = {part for _, part in seated}
        self._touched: set[int] = set()

    def moved(self, pose: Floats, impact: Impact | None, hits: Hits) -> None:
        """The hand is at another pose, or was stopped."""
        if motion.carried(self._poses[-1], pose, self._corners) >= self._step:
            self._poses.append(pose)
            if len(self._poses) > MOST_POSES:
                self._poses, self._step = self._poses[::2], 2 * self._step
        self._touched |= {part for part in hits.parts if part not in self._seat_parts}
        if impact is not None and impact.part not in self._seat_parts:
            self._touched.add(impact.part)

    def ended(self, world: World, tool: Tool, pose: Floats) -> Trip:
        """All of it, with the hand at its last pose."""
        if not np.array_equal(self._poses[-1], pose):
            self._poses.append(pose)
        way = tuple(motion.row(each) for each in self._poses)
        least: float | None = None
        for each in self._poses:
            near = world.distance(tool, each, REACH_M if least is None else least, self._seated)
            if near is not None and (least is None or near.value < least):
                least = near.value
                if least == 0.0:
                    break
        paths = world.mockup.part_paths
        return Trip(way, least, tuple(paths[part] for part in sorted(self._touched)))
