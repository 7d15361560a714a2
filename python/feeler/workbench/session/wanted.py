"""Requests to pages: pictures and measurements. The first answer counts."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any

from feeler.workbench.session.events import Event


class Wanted:
    """Requests by events, and collects the answers. Thread-safe."""

    def __init__(self, tell: Callable[[Event], None]) -> None:
        """tell: sends an event to all pages."""
        self._tell = tell
        self._shot_lock, self._shot_id = threading.Lock(), 0
        self._shot: tuple[int, Future[bytes]] = (0, Future())
        self._benchmark: tuple[int, Future[dict[str, Any]]] = (0, Future())

    def shot(self, width: int, height: int, wait_s: float, camera: dict[str, Any] | None = None) -> bytes | None:
        """A picture by one of the pages, as PNG; None if none arrives in time."""
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
        """Receives a page's picture. Late ones, and all but the first, are dropped."""
        wanted, waiting = self._shot
        if wanted == number and not waiting.done():
            waiting.set_result(png)

    def benchmark(self) -> Future[dict[str, Any]]:
        """Requests measurements from the pages; `benchmark.py` has the figures."""
        number, _ = self._benchmark
        self._benchmark = (number + 1, Future())
        self._tell({"type": "benchmark", "id": number + 1})
        return self._benchmark[1]

    def benchmarked(self, number: int, figures: dict[str, Any]) -> None:
        """Receives a page's measurements; drops them as pictures are dropped."""
        wanted, waiting = self._benchmark
        if wanted == number and not waiting.done():
            waiting.set_result(figures)
