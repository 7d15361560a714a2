"""Mechanisms in messages: a part of `protocol.py`. Angles are radians, slides and points metres, world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypedDict

from feeler.workbench.document.protocol_values import Vec3


class JointNumber(TypedDict):
    """A number of a position."""

    name: str
    kind: Literal["turn", "slide"]
    link: int
    """Its place among the links."""
    root: str
    """The number that it follows; its own name if it follows none."""
    group: str
    """One of the numbers that move with it, the same of all."""
    axis: Vec3
    """Where its link is modelled."""
    point: Vec3
    pitch: float
    """Metres a turn of a screw; else 0."""
    limits: tuple[float, float] | None


class JointLink(TypedDict):
    """Parts that a joint moves as one."""

    name: str
    above: int
    """The place of the link that it hangs on; -1: the frame."""
    parts: list[int]
    pose: list[float]
    """world_from_modelled, row by row."""


class Mechanism(TypedDict):
    """A mechanism, and its position."""

    name: str
    numbers: list[JointNumber]
    links: list[JointLink]
    values: dict[str, float]


class JointMet(TypedDict):
    """A moving part, the other one that it meets, and where."""

    part: int
    other: int
    point: Vec3


class JointWorst(TypedDict):
    """The position with the least gap."""

    value: float
    gap: float
    """Metres; no smaller one was found."""
    part: int
    other: int
    points: tuple[Vec3, Vec3]
    poses: list[list[float]]
    """Of the links."""


class JointRange(TypedDict):
    """How far a number moves freely, with the others where they stand."""

    name: str
    state: Literal["running", "done", "failed"]
    share: float
    """Of the work, 0 to 1; the range itself is known from 0.2 on."""
    lower: float
    upper: float
    below: JointMet | None
    """What ends it; null: a limit, or the end of what was looked at."""
    above: JointMet | None
    curve: list[tuple[float, float | None]]
    """Values, and the gap there in metres; null: nothing is near."""
    worst: JointWorst | None
    trouble: str


class JointStep(TypedDict):
    """The move of a line of the sequence."""

    name: str
    kind: Literal["turn", "slide"]
    begin: float
    end: float


@dataclass(frozen=True)
class Joints:
    """Where the links are shown, until the next message or patch. A newer message replaces it."""

    KIND: ClassVar[str] = "joints"
    poses: list[list[float]] | None
    """Of the links, world_from_modelled; null: where the document has them."""
    values: dict[str, float]
