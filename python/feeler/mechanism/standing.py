"""Pairs of links that stand: they keep their place to each other in a question, and are asked once.

Where two links stand as they are modelled, the parts that touch there may: they are named as seats. All else that
touches or comes near counts, as for pairs that move.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from feeler.mechanism.answers import MechanismContact, MechanismSeat
from feeler.mechanism.legs import Leg
from feeler.mechanism.positions import Positions
from feeler.mechanism.ranging import Near, contact, exactly, gap, is_moved, seat_meeting, seats_of, solid_pairs
from feeler.mechanism.seating import TOUCH_M
from feeler.poses import inverse

Floats = npt.NDArray[np.float64]
Pair = tuple[int, int]

_SAME = 1e-9  # metres and shares of one: links whose pose differs by less stand as they are modelled


@dataclass
class Standing:
    """The pairs of links that do not move against each other at a position.

    value: of the joint that is asked, there.
    """

    mechanism: Positions
    roots: set[str]
    position: dict[str, float]
    value: float = 0.0
    near: Near | None = None
    """The least gap, without seats."""
    seats: list[MechanismSeat] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.poses = self.mechanism.links.poses(self.position)
        found = [pair for pair in solid_pairs(self.mechanism) if not is_moved(self.mechanism, pair, self.roots)]
        self.modelled = [pair for pair in found if self._is_modelled(pair)]
        self.moved = [pair for pair in found if not self._is_modelled(pair)]

    def measure(self) -> None:
        """Finds the least gap and the seats."""
        for pair in self.modelled:
            near = self._gap(pair, ())
            if near is not None and near[0] <= TOUCH_M:
                touching = self.mechanism.bodies.touching(*pair)
                self.seats += self._named(pair, touching)
                near = self._gap(pair, touching)
            self._take(near)
        for pair in self.moved:
            self._take(self._gap(pair))
        self.seats += seats_of(self.mechanism, self.moved)

    def jams(self) -> list[MechanismContact]:
        """The seats that are deeper than where they are modelled."""
        leg, found = self._leg(), []
        for pair in self.moved:
            for seat in self.mechanism.bodies.seats(*pair):
                met = seat_meeting(self.mechanism, pair, seat, leg)
                found += [] if met is None else [contact(self.mechanism, leg, pair, met)]
        return found

    def clashes(self) -> list[MechanismContact]:
        """All parts that cross; links that stand as they are modelled have none that count."""
        leg, found = self._leg(), self.jams()
        for pair in self.moved:
            skipped: set[Pair] = set()
            while (met := exactly(self.mechanism, pair, leg, skipped)) is not None:
                found.append(contact(self.mechanism, leg, pair, met))
                skipped.add((met.number, met.other))
        return found

    def _leg(self) -> Leg:
        return Leg(self.position, self.position, (self.value, self.value))

    def _is_modelled(self, pair: Pair) -> bool:
        one, other = pair
        return bool(np.abs(inverse(self.poses[other]) @ self.poses[one] - np.eye(4)).max() <= _SAME)

    def _gap(self, pair: Pair, skipped: Iterable[Pair] | None = None) -> Near | None:
        """The gap of two links if it is less than what is known. skipped: pairs of parts in place of the seats."""
        within = math.inf if self.near is None else self.near[0]
        return gap(self.mechanism, *pair, self.position, max(within, TOUCH_M), self.poses, skipped)

    def _take(self, near: Near | None) -> None:
        if near is not None and (self.near is None or near[0] < self.near[0]):
            self.near = near

    def _named(self, pair: Pair, touching: Iterable[Pair]) -> list[MechanismSeat]:
        own, paths = self.mechanism.bodies.parts(pair[0]), self.mechanism.mockup.part_paths
        return [MechanismSeat(own[number], part, paths[own[number]], paths[part]) for number, part in touching]
