"""A call of a tool while it runs: its progress, its time limit, and whether the client cancelled it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Cancelled(Exception):  # noqa: N818  # not an error: nobody waits for the answer
    """The client cancelled the call."""


class Job:
    """A call that runs in a thread. The library asks `progress` whether to go on: it raises `KeyboardInterrupt`, which
    every long query ends at with what it found so far."""

    def __init__(self, tell: Callable[[], object] = lambda: None) -> None:
        """`tell`: called from the thread when there is progress to report."""
        self._tell = tell
        self._is_cancelled = threading.Event()
        self._ends = float("inf")
        self._base = 0.0
        self.report = (0.0, 1.0, "")
        """The work done, the whole, and the stage. The work done never decreases."""

    def cancel(self) -> None:
        """Ends the work at its next report of progress."""
        self._is_cancelled.set()

    @property
    def is_cancelled(self) -> bool:
        """Whether the client cancelled it."""
        return self._is_cancelled.is_set()

    @property
    def is_late(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() >= self._ends

    def limit(self, seconds: float) -> None:
        """Ends the work after some seconds from now."""
        self._ends = time.monotonic() + seconds

    def check(self) -> None:
        """Raises `Cancelled` if the client cancelled the call."""
        if self.is_cancelled:
            raise Cancelled

    def progress(self, fraction: float, stage: str = "") -> None:
        """The library's callback: the share done, 0 to 1, and the stage."""
        done, whole, _ = self.report
        self.report = (max(done, self._base + min(max(float(fraction), 0.0), 1.0)), whole, str(stage)[:200])
        self._tell()
        if self.is_cancelled or self.is_late:
            raise KeyboardInterrupt

    def next_step(self) -> None:
        """What follows has its own progress, from 0 to 1."""
        self._base += 1.0
        self.report = (self._base, self._base + 1.0, "")
