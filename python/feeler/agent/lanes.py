"""Threads that run calls, so that the server goes on answering meanwhile.

They are daemons: a query that cannot be stopped must not keep the program from ending.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

Work = Callable[[], object]


class Lane:
    """Some threads, and the work that waits for them."""

    def __init__(self, name: str, threads: int) -> None:
        self._waiting: queue.SimpleQueue[Work | None] = queue.SimpleQueue()
        self._threads = [threading.Thread(target=self._run, name=f"feeler-{name}", daemon=True) for _ in range(threads)]
        for thread in self._threads:
            thread.start()

    def submit(self, work: Work) -> None:
        """Runs it when a thread is free. It must not raise."""
        self._waiting.put(work)

    def end(self, seconds: float) -> bool:
        """Ends the threads after the work that is left; whether they ended in time."""
        for _ in self._threads:
            self._waiting.put(None)
        for thread in self._threads:
            thread.join(seconds)
        return not any(thread.is_alive() for thread in self._threads)

    def _run(self) -> None:
        while (work := self._waiting.get()) is not None:
            work()
