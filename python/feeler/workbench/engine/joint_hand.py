"""The hand on a joint: parts that it holds move by their one degree of freedom, within their free range.

The range is cast exactly before, so that the hand needs no other contact. Beyond it, a spring along the joint pulls the
hand back: at contact and at limits alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from feeler.workbench.document import motion
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.guide import Guide, Near

STIFFNESS_N_PER_M = 300.0
"""Of the spring beyond the range, at the middle of what is held."""
MOST_N = 10.0
"""It pulls no harder, there."""
_NEWTON = 30


@dataclass(frozen=True, eq=False)
class Freedom:
    """A joint where it stands, and how far it is free. axis: unit, through `point`, world. pitch: metres a turn.

    value: radians of a turn, metres of a slide. lower, upper: the free range. hand: the hand's pose where the joint
    has that value. seats: pairs of a part of what is in the hand and one of the mock-up that are seats, or that the
    mechanism ignores: they are no contact.
    """

    is_turn: bool
    axis: Floats
    point: Floats
    pitch: float
    value: float
    lower: float
    upper: float
    hand: Floats
    seats: frozenset[tuple[int, int]] = frozenset()


class JointGuide(Guide):
    """Draws every wish onto the joint. Immutable, for any thread."""

    def __init__(self, free: Freedom, bounds: Floats) -> None:
        """bounds: `(2, 3)` of what is in the hand."""
        hand = free.hand
        super().__init__(np.stack([hand, hand]), bounds)
        self.free = free
        self._hand = hand
        corners = motion.corners(bounds)
        self._held = corners
        self._places = corners @ hand[:3, :3].T + hand[:3, 3]
        flat = self._across(self._places)
        self._lever = float(np.linalg.norm(flat.mean(axis=0)))

    def at(self, value: float) -> Floats:
        """The pose of the hand where the joint has a value."""
        free = self.free
        by = value - free.value
        moved = np.eye(4)
        if free.is_turn:
            moved[:3, :3] = _turn(free.axis, by)
            moved[:3, 3] = free.point - moved[:3, :3] @ free.point + free.pitch / math.tau * by * free.axis
        else:
            moved[:3, 3] = by * free.axis
        pose: Floats = moved @ self._hand
        return pose

    def value_of(self, pose: Floats) -> float:
        """The value of the joint that comes nearest to a pose of the hand, also beyond its range."""
        free = self.free
        there = self._held @ pose[:3, :3].T + pose[:3, 3]
        along = float(((there - self._places) @ free.axis).mean())
        if not free.is_turn:
            return free.value + along
        before, after = self._across(self._places), self._across(there)
        cosine = float((before * after).sum())
        sine = float((np.cross(before, after) @ free.axis).sum())
        angle = math.atan2(sine, cosine)
        rate = free.pitch / math.tau
        if rate:
            angle = self._of_screw(angle, math.hypot(sine, cosine), along / rate, rate)
        # Of the turns that look alike, one in the range, or the nearest to it.
        middle = 0.5 * (free.lower + free.upper) - free.value
        turns = [angle + math.tau * k for k in range(-4, 5)]
        return free.value + min(turns, key=lambda each: (self._off(free.value + each), abs(each - middle)))

    def _of_screw(self, angle: float, size: float, advance: float, rate: float) -> float:
        """The turn between what the turn of a hand says and what its advance says."""
        weight = len(self._held) * rate * rate
        found = angle + math.tau * round((advance - angle) / math.tau) if weight > size * 1e-9 else angle
        turn = found
        for _ in range(_NEWTON):
            slope = size * math.sin(found - turn) + weight * (found - advance)
            bend = max(size * math.cos(found - turn) + weight, weight)
            found -= slope / bend
        return found

    def _off(self, value: float) -> float:
        return max(0.0, self.free.lower - value, value - self.free.upper)

    def clipped(self, value: float) -> float:
        """A value within the range."""
        return min(max(value, self.free.lower), self.free.upper)

    def nearest(self, pose: Floats) -> Near | None:
        """The nearest free place of the joint; None for a pose that is none."""
        if not np.isfinite(pose).all():
            return None
        free = self.free
        value = self.clipped(self.value_of(pose))
        span = free.upper - free.lower
        share = (value - free.lower) / span if span > 0.0 else 0.0
        there = self.at(value)
        return Near(there, share, motion.carried(pose, there, self._held), np.zeros(3))

    def drawn(self, wish: Floats) -> Floats:
        """A wish, drawn onto the joint, also beyond its range."""
        return wish if not np.isfinite(wish).all() else self.at(self.value_of(wish))

    def reached(self, wish: Floats) -> tuple[Floats, Floats, Floats]:
        """Where the hand gets to, its force and its torque: those of a spring along the joint. A wish that is
        no pose has no force, and the hand stays."""
        if not np.isfinite(wish).all():
            return self._hand, np.zeros(3), np.zeros(3)
        free, wanted = self.free, self.value_of(wish)
        value = self.clipped(wanted)
        pose, beyond = self.at(value), wanted - value
        if beyond == 0.0:
            return pose, np.zeros(3), np.zeros(3)
        lever = max(self._lever, 1e-3) if free.is_turn else 1.0
        pull = -math.copysign(min(STIFFNESS_N_PER_M * abs(beyond) * lever, MOST_N), beyond)
        if free.is_turn:
            return pose, np.zeros(3), pull * lever * free.axis
        return pose, pull * free.axis, np.zeros(3)

    def pull_of(self, off: float) -> float:
        """The joint holds at any distance; in doubt it does not."""
        return 1.0 if math.isfinite(off) else 0.0

    def is_at_end(self, pose: Floats) -> bool:
        """A joint holds until the hand lets go."""
        return False

    def _across(self, points: Floats) -> Floats:
        arms = points - self.free.point
        across: Floats = arms - np.outer(arms @ self.free.axis, self.free.axis)
        return across


def _turn(axis: Floats, angle: float) -> Floats:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return turned
