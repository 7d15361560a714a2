"""Motions of a mechanism in legs, along each of which its numbers move at constant rates, and links against links."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler._core import Chain, Screw, Slide
from feeler.errors import MechanismError, OptionError
from feeler.mechanism.joint import JointKind
from feeler.mechanism.positions import Positions
from feeler.poses import inverse

Floats = npt.NDArray[np.float64]
Position = dict[str, float]

BENT_M = 1e-5
"""By how much a leg of a loop may be off, where no contact is near, metres."""
STRAIGHT_M = 1e-8
"""The same of the leg that meets a contact."""
_LOOP_LEGS = 45
_LEAST_LEG = 1e-6  # of the whole, where a loop ends


@dataclass(frozen=True)
class Leg:
    """A motion from one position to another at constant rates, and the values of the joint that is asked."""

    start: Position
    end: Position
    values: tuple[float, float]
    off: float = 0.0
    """How far the links of a loop are from where they should be, metres, about."""

    def at(self, share: float) -> Position:
        """The position after a share of it."""
        return {name: value + share * (self.end[name] - value) for name, value in self.start.items()}

    def value(self, share: float) -> float:
        """The value of the joint after a share of it."""
        return self.values[0] + share * (self.values[1] - self.values[0])


class Legs:
    """The motion of a joint and all that follows it from one value to another, leg by leg.

    One leg that is exact, or many where a loop follows: those are straight between positions, to within `BENT_M`.
    """

    def __init__(
        self,
        mechanism: Positions,
        name: str,
        at: Mapping[str, float],
        begin: float,
        end: float,
        start: Position | None = None,
    ) -> None:
        """start: the position that loops are followed from; None: where the parts are modelled."""
        self._start = start
        self._mechanism, self._name, self._at, self._values = mechanism, name, at, (begin, end)
        self.why = ""
        """Why it ends early, if it does, once all legs were taken."""

    def __iter__(self) -> Iterator[Leg]:
        mechanism, name, at, (begin, end) = self._mechanism, self._name, self._at, self._values
        here = mechanism.position({**at, name: begin}, self._start)
        if begin == end or not mechanism.loops_of(name):
            yield Leg(here, here if begin == end else mechanism.position({**at, name: end}), (begin, end))
            return
        longest = least = abs(end - begin)
        longest, least = longest / _LOOP_LEGS, least * _LEAST_LEG
        now, step, way = begin, longest, 1.0 if end > begin else -1.0
        while now != end:
            value = end if abs(end - now) <= step * (1.0 + 1e-9) else now + way * step
            half = 0.5 * (now + value)
            try:
                middle = mechanism.position({**at, name: half}, here)
                there = mechanism.position({**at, name: value}, middle)
            except (MechanismError, OptionError) as error:
                self.why = str(error)
                step *= 0.5
                if step < least:
                    return
                continue
            off = 0.25 * _bend(mechanism, here, middle, there)  # of each half
            if off > BENT_M and step > least:
                step *= 0.5
                continue
            yield Leg(here, middle, (now, half), off)
            yield Leg(middle, there, (half, value), off)
            here, now, self.why = there, value, ""
            if off < 0.2 * BENT_M:
                step = min(longest, 2.0 * step)


def whole(mechanism: Positions, name: str, at: Mapping[str, float], begin: float, end: float) -> list[Leg]:
    """All legs. Raises `MechanismError` where the way ends early."""
    way = Legs(mechanism, name, at, begin, end)
    found = list(way)
    if way.why:
        raise MechanismError(f"{name!r} does not get from {begin:.9g} to {end:.9g}: {way.why}")
    return found


def halves(mechanism: Positions, name: str, at: Mapping[str, float], leg: Leg) -> tuple[Leg, Leg]:
    """A leg of a loop in two."""
    begin, end = leg.values
    value = 0.5 * (begin + end)
    middle = mechanism.position({**at, name: value}, leg.start)
    found = []
    for here, there, values in ((leg.start, middle, (begin, value)), (middle, leg.end, (value, end))):
        between = mechanism.position({**at, name: 0.5 * (values[0] + values[1])}, here)
        found.append(Leg(here, there, values, _bend(mechanism, here, between, there)))
    return found[0], found[1]


def _bend(mechanism: Positions, start: Position, middle: Position, end: Position) -> float:
    """How far points are off the straight motion in its middle, metres, about."""
    size = mechanism.size
    return max(
        abs(middle[name] - 0.5 * (value + end[name])) * (size if mechanism.turns(name) else 1.0)
        for name, value in start.items()
    )


def relative(mechanism: Positions, one: int, other: int, leg: Leg) -> tuple[Floats, Chain]:
    """The motion of a link as seen from another: its pose in the other's frame where the leg starts, and its way."""
    poses = mechanism.links.poses(leg.start)
    back = inverse(poses[other])
    up, down = mechanism.links.between(one, other)
    ways = [Chain(_joints(mechanism, links, leg, poses, back)) for links in (up, down)]
    return back @ poses[one], ways[0].relative_to(ways[1])


def _joints(mechanism: Positions, links: list[int], leg: Leg, poses: list[Floats], back: Floats) -> list[Screw | Slide]:
    """The joints that move along a leg, the one that carries the others first, in the frame that `back` leads to."""
    found: list[Screw | Slide] = []
    for number in reversed(links):
        link = mechanism.links.links[number]
        place = back @ poses[link.above]
        axis = place[:3, :3] @ np.array(link.joint.axis)
        point = place[:3, :3] @ np.array(link.joint.point) + place[:3, 3]
        for name, turns in zip(link.joint.names, link.joint.turns, strict=True):
            by = leg.end[name] - leg.start[name]
            if by == 0.0:
                continue
            pitch = link.joint.pitch if link.joint.kind is JointKind.SCREW else 0.0
            found.append(Screw(axis, point, by, pitch) if turns else Slide(by * axis))
    return found
