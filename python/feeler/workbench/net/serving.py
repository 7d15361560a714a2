"""What the server needs of a session, and its limits: names only, so that neither knows the other's insides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from feeler.progress import Progress
from feeler.workbench.document.protocol import DocumentFields, HeldManifest, Manifest, State


class SnapshotLike(Protocol):
    """What the engine found at one moment."""

    @property
    def number(self) -> int:
        """Grows."""

    def message(self) -> State:
        """The state that pages get."""


class JobLike(Protocol):
    """A job under way; a `concurrent.futures.Future` is one."""

    def result(self) -> Any:
        """What came of it, once it is done."""

    def cancel(self) -> bool:
        """Gives it up."""

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        """Calls back when it is done, in any thread."""


class SessionLike(Protocol):
    """The session of a workbench. All of it may be called from any thread."""

    pages: int
    """How many pages look at it; the server keeps the number."""

    @property
    def is_recording(self) -> bool:
        """Whether what happens is written down."""

    def document_and_event(self) -> tuple[DocumentFields, int]:
        """The document as JSON, and the number of the newest event that it has in it."""

    def subscribe(self, listener: Callable[[dict[str, Any]], None], /) -> Callable[[], None]:
        """Every event from now on, with its number "n". Call the result to end that."""

    def events_since(self, number: int, /) -> list[dict[str, Any]] | None:
        """The events after a number; None where not all of them are kept."""

    def snapshot(self) -> SnapshotLike | None:
        """The engine's newest."""

    def on_snapshot(self, listener: Callable[[], None], /) -> Callable[[], None]:
        """Told that there is a newer snapshot. Call the result to end that."""

    def wish(self, pose: npt.NDArray[np.float64], seq: int, source: str, /) -> None:
        """Where the hand wants to be. The newest counts; waits for nothing."""

    def hand_gone(self) -> None:
        """No page is left."""

    def command(self, name: str, args: dict[str, Any], /) -> Any:
        """Changes the document."""

    def ask(self, name: str, args: dict[str, Any], /) -> Any:
        """Answers a question."""

    def job(self, name: str, args: dict[str, Any], on_progress: Progress, /) -> JobLike:
        """Starts what takes a while."""

    def shot_taken(self, number: int, png: bytes, /) -> None:
        """A page's picture."""

    def benchmarked(self, number: int, figures: dict[str, Any], /) -> None:
        """What a page measured."""

    def manifest(self) -> Manifest:
        """Of the geometry."""

    def piece(self, number: int, /) -> bytes:
        """A piece of the geometry."""

    def held_manifest(self, version: int, /) -> HeldManifest | None:
        """Of the mesh in hand; None for version 0."""

    def held(self, version: int, /) -> bytes:
        """The mesh in hand."""

    def export(self, name: str, /) -> bytes:
        """What a job wrote."""


@dataclass(frozen=True)
class Limits:
    """How much a page may ask of the server.

    hello_s: until the first message; message_bytes: of one; pages: at once; waiting: sockets that have not said hello;
    messages_per_s; requests: commands, questions and jobs of a page that are not answered yet; shot_bytes: of a picture
    in base64, all pieces together.
    """

    hello_s: float = 2.0
    message_bytes: int = 1 << 20
    pages: int = 4
    waiting: int = 16
    messages_per_s: int = 1000
    requests: int = 256
    shot_bytes: int = 32 << 20
