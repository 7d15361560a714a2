"""The messages about the people on a project and the turns of the tool: a part of `protocol.py`.

Nothing here is in the document, in undo or in a project.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypedDict

from feeler.workbench.document.protocol_values import Camera, Vec3

MOST_NAME = 40
"""Characters of a person's name."""

MOST_SELECTED = 1000
"""Parts of a selection that others see."""

LEAST_HERE_MS = 100
"""A page tells where its person is at most once in this time; the server passes it on no faster."""

Holder = Literal["page", "script", "device"]
TurnWish = Literal["take", "ask", "give", "keep", "let_go"]


class Person(TypedDict):
    """Somebody with a page."""

    id: int
    name: str
    """Plain text, different from all others."""
    colour: int
    """A number from 0, different from all others."""
    is_away: bool
    """The page has said nothing for some seconds: it is hidden, or its machine sleeps."""


class Turn(TypedDict):
    """Who has the tool, and what it holds."""

    kind: Holder | None
    """Null: nobody."""
    person: int | None
    """The page's; null: not a page."""
    is_free: bool
    """Anybody may take it, by moving it: nobody has it, or its holder has not moved it for some seconds."""
    asked: list[int]
    """Persons who asked for it, in this order."""


# ---- page -> server ----


@dataclass(frozen=True)
class Named:
    """The name of the page's person. Empty: the default, "Guest 1"."""

    KIND: ClassVar[str] = "name"
    name: str


@dataclass(frozen=True)
class Here:
    """Where the page's person points and looks, and what is selected. Only the newest counts."""

    KIND: ClassVar[str] = "here"
    point: Vec3 | None
    """On the mock-up, under the pointer. Null: nowhere."""
    selection: list[int]
    """Parts, at most `MOST_SELECTED`."""
    camera: Camera
    is_moving: bool
    """The person holds the tool, even if it does not move at this moment."""


@dataclass(frozen=True)
class Turning:
    """Takes the tool if it is free, asks for it, gives it to `to`, keeps it, or lets it go. Answered by a reply."""

    KIND: ClassVar[str] = "turn"
    id: int
    wish: TurnWish
    to: int | None
    """A person, for "give"."""


PersonMessage = Named | Here | Turning


# ---- server -> page ----


@dataclass(frozen=True)
class People:
    """The people with a page, and who has the tool. A newer message replaces it."""

    KIND: ClassVar[str] = "people"
    you: int
    people: list[Person]
    """In the order in which they came."""
    turn: Turn


@dataclass(frozen=True)
class Seen:
    """Where another person points and looks, and what is selected there. A newer message replaces it."""

    KIND: ClassVar[str] = "seen"
    person: int
    point: Vec3 | None
    selection: list[int]
    camera: Camera
