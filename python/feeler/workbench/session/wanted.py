"""What pages are asked for: a picture, figures of what they draw. The first answer counts."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any

from feeler.workbench.session.events import Event


class Wanted:
    """Asks by events, and takes what comes. Thread-safe."""

    def __init__(self, tell: Callable[[Event], None]) -> None:
        """tell: sends an event to all pages."""
        self._tell = tell
        self._shot_lock, self._shot_id = threading.Lock(), 0
        self._shot: tuple[int, Future[bytes]] = (0, Future())
        self._benchmark: tuple[int, Future[dict[str, Any]]] = (0, Future())

    def shot(self, width: int, height: int, wait_s: float, camera: dict[str, Any] | None = None) -> bytes | None:
        """A picture by one of the pages, as PNG; None where none sends one in time."""
        with self._shot_lock:
            self._shot_id += 1
            waiting: Future[bytes] = Future()
            self._shot = (self._shot_id, waiting)
            self._tell({"type": "shot", "id": self._shot_id, "width": width, "height": height, "camera": camera})
            try:
                return waiting.result(wait_s)
            except FutureTimeoutError:
                return None

    def shot_taken(self, number: int, png: bytes) -> None:
        """A page's picture. One that nobody waits for any more, and all but the first, are dropped."""
        wanted, waiting = self._shot
        if wanted == number and not waiting.done():
            waiting.set_result(png)

    def benchmark(self) -> Future[dict[str, Any]]:
        """Asks the pages to measure what they draw; `benchmark.py` has the figures."""
        number, _ = self._benchmark
        self._benchmark = (number + 1, Future())
        self._tell({"type": "benchmark", "id": number + 1})
        return self._benchmark[1]

    def benchmarked(self, number: int, figures: dict[str, Any]) -> None:
        """What a page measured; dropped as pictures are."""
        wanted, waiting = self._benchmark
        if wanted == number and not waiting.done():
            waiting.set_result(figures)
