"""The mechanism of a document: its numbers, its links and where they stand; and what is known of their ranges.

Angles are radians, slides and points metres, world. A link is a group of parts that a joint moves as one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from feeler.words import length_in
from feeler.workbench.document.motion import HOME, Row

Point = tuple[float, float, float]
SAME = 1e-7
"""Places that differ by less in each of their 16 numbers are the same."""
_NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class JointNumber:
    """A number of a position. kind: "turn" or "slide". link: its place among the links. axis, point: where its link is
    modelled. root: the number that it follows by couplings; itself if it follows none. group: one of the numbers that
    move with it, the same of all."""

    name: str
    kind: str
    link: int
    root: str
    group: str
    axis: Point
    point: Point
    pitch: float = 0.0
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class JointLink:
    """A link. above: the place of the link that it hangs on; -1: the frame. pose: world_from_modelled."""

    name: str
    above: int
    parts: tuple[int, ...]
    pose: Row = HOME


@dataclass(frozen=True)
class MechanismState:
    """A mechanism, and its position.

    name: of its file. text: the file, TOML. order: the numbers that were moved, the last one last.
    """

    name: str
    text: str
    numbers: tuple[JointNumber, ...]
    links: tuple[JointLink, ...]
    values: Mapping[str, float]
    order: tuple[str, ...] = ()

    def number(self, name: str) -> JointNumber | None:
        """A number by its name."""
        return next((each for each in self.numbers if each.name == name), None)

    def below(self, link: int, but: frozenset[int] = frozenset()) -> tuple[int, ...]:
        """A link, and all that hang on it, without some links and what hangs on these."""
        found = [link]
        for place, each in enumerate(self.links):
            if each.above in found and place not in found and place not in but:
                found.append(place)
        return tuple(found)

    def above(self, link: int) -> tuple[int, ...]:
        """The links that a link hangs on, the nearest first."""
        found: list[int] = []
        here = self.links[link].above
        while here >= 0:
            found.append(here)
            here = self.links[here].above
        return tuple(found)

    def others(self, number: JointNumber) -> frozenset[int]:
        """The links of the numbers that move with a number, its own left out."""
        return frozenset(each.link for each in self.numbers if each.group == number.group and each != number)

    def with_number(self, number: JointNumber) -> tuple[int, ...]:
        """The parts that move as one with the link of a number while it moves."""
        links = self.below(number.link, self.others(number))
        return tuple(part for link in links for part in self.links[link].parts)

    def followers(self, number: JointNumber) -> frozenset[int]:
        """The other parts that move while it does."""
        links = {each for link in self.others(number) for each in self.below(link)}
        moving = frozenset(part for link in links for part in self.links[link].parts)
        return moving - frozenset(self.with_number(number))


@dataclass(frozen=True)
class JointMet:
    """A moving part, the other one that it meets, and where."""

    part: int
    other: int
    point: Point


@dataclass(frozen=True)
class JointWorst:
    """The position with the least gap: metres, the two parts, their nearest points, and the poses of the links."""

    value: float
    gap: float
    part: int
    other: int
    points: tuple[Point, Point]
    poses: tuple[Row, ...]


@dataclass(frozen=True)
class JointRange:
    """How far a number moves freely, with the others where they stand.

    state: "running", "done" or "failed", for which `trouble` says why. share: of the work. below, above: what ends it;
    None: its limit, or the end of what was looked at. curve: values and the gap there, metres, None where nothing is
    near. key: of all that it depends on.
    """

    name: str
    key: str
    state: str = "running"
    share: float = 0.0
    lower: float = 0.0
    upper: float = 0.0
    below: JointMet | None = None
    above: JointMet | None = None
    curve: tuple[tuple[float, float | None], ...] = ()
    worst: JointWorst | None = None
    trouble: str = ""


@dataclass(frozen=True)
class JointStep:
    """The move of a line of the sequence: a number, and from which value to which. start: all numbers before it."""

    name: str
    kind: str
    begin: float
    end: float
    start: Mapping[str, float] = field(default_factory=lambda: _NOTHING)


def figure(kind: str, value: float, unit: str) -> str:
    """A value in words; unit: of lengths."""
    return f"{math.degrees(value):.4g}°" if kind == "turn" else length_in(value, unit)


def is_at(place: Row, other: Row) -> bool:
    """Whether two places are the same but for rounding."""
    return all(abs(a - b) <= SAME for a, b in zip(place, other, strict=True))


def laid(state: MechanismState, moved: Mapping[int, Row], gripped: Mapping[int, Row]) -> Mapping[int, Row]:
    """Where parts lie if those of the links that the hand holds are where the links have them."""
    back = {part: link.pose for link in state.links for part in link.parts if part in gripped}
    return MappingProxyType(dict(sorted({**moved, **back}.items())))


def loose(state: MechanismState, moved: Mapping[int, Row], away: frozenset[int]) -> frozenset[int]:
    """The parts of links that do not go with them: taken out, in the hand, or put down elsewhere."""
    return frozenset(
        part
        for link in state.links
        for part in link.parts
        if part in away or not is_at(moved.get(part, HOME), link.pose)
    )
