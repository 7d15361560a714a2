"""Answers about mechanisms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from feeler.choices import MechanismSeatKind
from feeler.field_docs import documented
from feeler.short_reprs import shortly

Vector = tuple[float, float, float]


@documented
@dataclass(frozen=True)
class MechanismSeat:
    """A pair of parts of a joint, coupling or loop that are in contact where they are modelled, or of other links that
    touch there.

    It is followed by the rule of seats: it may slide and separate, but go no deeper than there.
    """

    part: int
    other: int
    path: str
    """The path of `part`."""
    other_path: str
    """The path of `other`."""
    kind: MechanismSeatKind = "touching"
    """`touching`, `fit` or `sunk`, as in `removal`; `round`: surfaces of revolution about the axis, such as a pin in
    its hole or a ball in its socket, of which only the facets cross."""


@documented
@dataclass(frozen=True)
class MechanismContact:
    """The first contact of a moving part with another, at a value of a joint."""

    value: float
    """Radians or metres; never late."""
    part: int
    other: int
    path: str
    """The path of `part`."""
    other_path: str
    """The path of `other`."""
    point: Vector
    """Metres, world."""
    normal: Vector
    """Unit, world, from the other part to the moving one; zero where it is unknown."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return {**vars(self), "point": list(self.point), "normal": list(self.normal)}


@documented
@dataclass(frozen=True)
class Range:
    """How far a joint moves freely from where it stands."""

    joint: str
    start: float
    """The value that it was asked from, radians or metres."""
    lower: float
    upper: float
    """From `lower` to `upper` it is free, radians or metres."""
    below: MechanismContact | None
    """What ends the range below; None if nothing or its limit does."""
    above: MechanismContact | None
    """What ends it on both sides; None: a limit, or all that was looked at."""
    seats: tuple[MechanismSeat, ...]
    """Pairs that may stay as deep as they are modelled; all others are exact."""
    is_certified: bool = True
    """False for joints of loops, which are followed in small steps."""
    ended: str = ""
    """Why it ends early where nothing was met: a dead point of a loop, or a joint without limits, which is followed for
    one turn, or twice the size of the mock-up."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        found = dict(vars(self))
        found["below"] = None if self.below is None else self.below.to_dict()
        found["above"] = None if self.above is None else self.above.to_dict()
        found["seats"] = [vars(seat) for seat in self.seats]
        return found


@documented
@dataclass(frozen=True, eq=False)
class MechanismClearance:
    """Bounds of the least gap over a range of positions, of all pairs of parts but those that are seated.

    A seated pair has no gap: where one goes deeper than where it is modelled, both bounds are 0.
    """

    lower: float
    """No position has a smaller gap, metres; 0 if nothing is certified; infinite if nothing moves against anything."""
    upper: float
    """The gap at `worst`."""
    worst: dict[str, float]
    """The position with the smallest gap found."""
    part: int | None
    other: int | None
    path: str
    """The path of `part`; empty if there is none."""
    other_path: str
    """The path of `other`; empty if there is none."""
    points: tuple[Vector, Vector] | None
    """The closest points there, of `part` and `other`, metres, world."""
    boxes: int
    """Boxes of positions that were tried."""
    undecided: float
    """The share of positions whose gap is not decided to within the error."""
    seats: tuple[MechanismSeat, ...]
    """Pairs whose gap is not asked; they are followed by the rule of seats instead."""
    curve: npt.NDArray[np.float64]
    """`(n, 3)`: of one joint its value, the gap there, and a lower bound around it up to the middle of the next."""
    is_certified: bool = True
    """False where `lower` is not proven, and then 0: near a dead point of a loop, and where several joints move a seat
    at once, which is followed along some lines. False too for seats of loops: their legs are a little off."""
    jams: tuple[MechanismContact, ...] = ()
    """The seated pairs that go deeper than where they are modelled, and their first values of the joint."""

    def to_dict(self) -> dict[str, Any]:
        """As JSON; infinite gaps are None."""
        found = dict(vars(self))
        found["jams"] = [jam.to_dict() for jam in self.jams]
        for name in ("lower", "upper"):
            found[name] = found[name] if np.isfinite(found[name]) else None
        found["seats"] = [vars(seat) for seat in self.seats]
        found["points"] = None if self.points is None else [list(point) for point in self.points]
        found["curve"] = [[each if np.isfinite(each) else None for each in row] for row in self.curve.tolist()]
        return found


@shortly
@documented
@dataclass(frozen=True)
class MechanismClashes:
    """The pairs of parts that clash at some position of a joint, by its value."""

    joint: str
    """Empty where none has a range: then all values are 0."""
    lower: float
    """The least value of `joint`, radians or metres."""
    upper: float
    """The largest."""
    contacts: tuple[MechanismContact, ...]
    """A row for each pair of parts that meets: where on the way it does first."""
    seats: tuple[MechanismSeat, ...]
    """Pairs that clash only where they go deeper than where they are modelled."""
    is_certified: bool = True
    """False for joints of loops, which are followed in small steps."""

    def __len__(self) -> int:
        return len(self.contacts)

    @overload
    def __getitem__(self, index: int) -> MechanismContact: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[MechanismContact, ...]: ...
    def __getitem__(self, index: int | slice) -> MechanismContact | tuple[MechanismContact, ...]:
        return self.contacts[index]

    def __iter__(self) -> Iterator[MechanismContact]:
        return iter(self.contacts)
