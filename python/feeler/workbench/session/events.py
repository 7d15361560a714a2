"""The events of a session: numbered, sent to listeners, and kept for a while for pages that reconnect."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

MOST_KEPT = 2000
"""Events kept for pages; one that missed more gets the whole document."""

Event = dict[str, Any]


class Events:
    """Thread-safe. Listeners are called in the thread of the event, in its order; they must not block."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._kept: deque[Event] = deque(maxlen=MOST_KEPT)
        self._listeners: list[Callable[[Event], None]] = []
        self.last = 0

    def tell(self, event: Event) -> None:
        """An event without its number."""
        with self._lock:
            self.last += 1
            numbered = {"n": self.last, **event}
            self._kept.append(numbered)
            for listener in list(self._listeners):
                listener(numbered)

    def show(self, message: Event) -> None:
        """A message that counts only until the next of its type: it has no number, and is not kept."""
        with self._lock:
            for listener in list(self._listeners):
                listener(message)

    def subscribe(self, listener: Callable[[Event], None]) -> Callable[[], None]:
        """Subscribes a listener. Call the result to unsubscribe."""
        with self._lock:
            self._listeners.append(listener)

        def end() -> None:
            with self._lock:
                if listener in self._listeners:
                    self._listeners.remove(listener)

        return end

    def since(self, number: int) -> list[Event] | None:
        """The events after a number; None if some are no longer kept, or the number was never used."""
        with self._lock:
            missed = self.last - number
            if not 0 <= missed <= len(self._kept):
                return None
            return list(self._kept)[len(self._kept) - missed :]
