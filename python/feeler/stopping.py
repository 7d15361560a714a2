"""Tells tasks that nobody waits for any more to end: threads of this process, and processes that share its files.

A task looks a few times a second, where it reports progress. Workers on other machines do not see the file that tells
them, and end with their task.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import tempfile
import threading
import time
import uuid
from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from typing import Any

LOOKED_EVERY_S = 0.1
"""Between two looks of a task for the file that stops it."""

_tasks = threading.local()


class TaskStopped(Exception):  # noqa: N818, it is no error
    """The caller wants no more answers."""


class Stop:
    """Whether tasks are to end. A pickle of it looks for a file, which `set` makes."""

    def __init__(self) -> None:
        self._event = threading.Event()
        self._path: str | None = None
        self._looked = -1.0

    def __getstate__(self) -> str:
        if self._path is None:
            self._path = os.path.join(tempfile.gettempdir(), f"feeler-stop-{uuid.uuid4().hex}")
        return self._path

    def __setstate__(self, path: str) -> None:
        self._event, self._path, self._looked = threading.Event(), path, -1.0

    def is_set(self) -> bool:
        """Whether it is time to end."""
        if not self._event.is_set() and self._path is not None and time.monotonic() - self._looked > LOOKED_EVERY_S:
            self._looked = time.monotonic()
            if os.path.exists(self._path):
                self._event.set()
        return self._event.is_set()

    def set(self, running: Iterable[Future[Any]] = ()) -> None:
        """Ends all. The file goes when those that run have ended, at the latest with this process."""
        self._event.set()
        path, left = self._path, list(running)
        if path is None or not left:
            return
        with contextlib.suppress(OSError):  # a full disk: they end on their own
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))

        def clean() -> None:
            with contextlib.suppress(OSError):
                os.remove(path)

        def end(_: Future[Any]) -> None:
            if all(future.done() for future in left):
                clean()
                atexit.unregister(clean)

        atexit.register(clean)
        for future in left:
            future.add_done_callback(end)


@contextlib.contextmanager
def task(stop: Stop) -> Iterator[None]:
    """What runs inside, in this thread, is a task that `stop` ends."""
    before = getattr(_tasks, "stop", None)
    _tasks.stop = stop
    try:
        yield
    finally:
        _tasks.stop = before


def is_stopped() -> bool:
    """Whether the task of this thread is to end."""
    stop: Stop | None = getattr(_tasks, "stop", None)
    return stop is not None and stop.is_set()


def check_stop(_share: float = 0.0, _stage: str = "") -> None:
    """The progress callback of tasks. Raises `TaskStopped` if the task of this thread is to end."""
    if is_stopped():
        raise TaskStopped
