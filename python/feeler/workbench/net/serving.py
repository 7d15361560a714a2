"""The server's view of a session, and its limits: protocols only, so that neither depends on the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from feeler.errors import WorkbenchError
from feeler.progress import Progress
from feeler.workbench.document.openings import OpeningRequest, Opens
from feeler.workbench.document.protocol import (
    DocumentFields,
    HeldManifest,
    Here,
    Manifest,
    People,
    Seen,
    State,
    Turning,
)


class SnapshotLike(Protocol):
    """The engine's results at one moment."""

    @property
    def number(self) -> int:
        """Grows."""

    def message(self) -> State:
        """The state for pages."""


class JobLike(Protocol):
    """A running job; a `concurrent.futures.Future` is one."""

    def result(self) -> Any:
        """The result, once it is done."""

    def cancel(self) -> bool:
        """Cancels it."""

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        """Calls back when it is done, in any thread."""


class OpeningsLike(Protocol):
    """What opens other mock-ups for pages."""

    def facts(self) -> Opens | None:
        """What they may open; None: nothing."""

    def request(self, message: OpeningRequest, by: str | None = None, /) -> Any:
        """Carries out a page's message. by: the name of its person, for others who are there; None: nobody is."""


class NewsLike(Protocol):
    """What pages do not know yet of each other."""

    @property
    def is_about_people(self) -> bool:
        """Whether people came, left or changed, or the turn."""

    @property
    def seen(self) -> tuple[int, ...]:
        """The pages' numbers that show something else."""


class PeopleLike(Protocol):
    """The people of a session. Nothing here waits."""

    @property
    def look_s(self) -> float | None:
        """After how long to look for news, if none is told; None: there can be none."""

    def on_news(self, listener: Callable[[], None], /) -> Callable[[], None]:
        """Calls a function whenever there is news, in any thread. Call the result to end that."""

    def join(self) -> int:
        """A page came; the result is its number."""

    def leave(self, person: int, /) -> bool:
        """A page is gone. Whether it had the tool."""

    def name(self, person: int, name: str, /) -> None:
        """Sets a name."""

    def here(self, person: int, here: Here, /) -> None:
        """Where a person points and looks."""

    def news(self) -> NewsLike:
        """What changed since the last call."""

    def people(self, you: int, /) -> People:
        """All people and the turn, for one of them."""

    def seen(self, person: int, /) -> Seen | None:
        """What others see of a person."""

    def refusal(self) -> WorkbenchError:
        """Why the tool cannot be moved, to raise."""

    def name_of(self, mover: int, /) -> str:
        """The name of a person."""

    @property
    def count(self) -> int:
        """The number of pages."""


class SessionLike(Protocol):
    """The session of a workbench. All methods may be called from any thread."""

    pages: int
    """Number of open pages, kept by the server."""

    @property
    def people(self) -> PeopleLike:
        """Who has a page, and who has the tool."""

    @property
    def openings(self) -> OpeningsLike:
        """Opens other mock-ups."""

    @property
    def is_recording(self) -> bool:
        """Whether the session is recorded."""

    def document_and_event(self) -> tuple[DocumentFields, int]:
        """The document as JSON, and the number of the newest event included in it."""

    def subscribe(self, listener: Callable[[dict[str, Any]], None], /) -> Callable[[], None]:
        """Subscribes to events, with their number "n". Call the result to unsubscribe."""

    def events_since(self, number: int, /) -> list[dict[str, Any]] | None:
        """The events after a number; None if some were dropped."""

    def snapshot(self) -> SnapshotLike | None:
        """The engine's newest results."""

    def on_snapshot(self, listener: Callable[[], None], /) -> Callable[[], None]:
        """Subscribes to new snapshots. Call the result to unsubscribe."""

    def wish(self, pose: npt.NDArray[np.float64], seq: int, source: str, by: int, /) -> bool:
        """Sets the target of the hand; only the newest counts. Never waits. False: somebody else has the tool."""

    def hand_gone(self) -> None:
        """The last page has left, or the one that had the tool."""

    def turn(self, person: int, turning: Turning, /) -> Any:
        """A person's wish about the turn of the tool."""

    def command(self, name: str, args: dict[str, Any], by: int, /) -> Any:
        """Changes the document."""

    def ask(self, name: str, args: dict[str, Any], /) -> Any:
        """Answers a question."""

    def job(self, name: str, args: dict[str, Any], on_progress: Progress, /) -> JobLike:
        """Starts a long task."""

    def shot_taken(self, number: int, png: bytes, /) -> None:
        """Receives a page's picture."""

    def benchmarked(self, number: int, figures: dict[str, Any], /) -> None:
        """Receives a page's measurements."""

    def manifest(self) -> Manifest:
        """Manifest of the geometry."""

    def piece(self, number: int, /) -> bytes:
        """A piece of the geometry."""

    def sent_piece(self, number: int, /) -> bytes:
        """The same, with copies of parts as places of shapes."""

    def held_manifest(self, version: int, /) -> HeldManifest | None:
        """Manifest of the mesh in hand; None for version 0."""

    def held(self, version: int, /) -> bytes:
        """The mesh in hand."""

    def card_room(self, number: int, /) -> bytes:
        """The swept volume of a card."""

    def finding_rows(self, version: str, /) -> bytes:
        """The rows of the findings of a version."""

    def export(self, name: str, /) -> bytes:
        """A file written by a job."""


@dataclass(frozen=True)
class Limits:
    """Limits for a page.

    hello_s: time until the first message; message_bytes: of one message; pages: at once; waiting: sockets before their
    hello; messages_per_s; requests: unanswered commands, questions and jobs of a page; pieces: unanswered ones of
    files; shot_bytes: of a picture in base64, all pieces together.
    """

    hello_s: float = 2.0
    message_bytes: int = 1 << 20
    pages: int = 4
    waiting: int = 16
    messages_per_s: int = 1000
    requests: int = 256
    pieces: int = 4
    shot_bytes: int = 32 << 20
