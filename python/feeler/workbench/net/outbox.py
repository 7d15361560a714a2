"""Messages waiting for one page: a queue in order, without loss, and the newest state, progress and people.

If the queue gets too long, the page does not read its messages: it is closed, and a new connection gets the whole
state. Of states only the newest counts: it is encoded when sent, and none is sent while the page has two to
acknowledge.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable

MOST_STATES = 2
"""States sent and not acknowledged."""

MOST_WAITING = 4000
"""Messages in the queue."""

MOST_WAITING_BYTES = 32 << 20
"""Characters and bytes of the messages."""


class Outbox:
    """The outbox of one page. Not thread-safe: it belongs to the net thread."""

    def __init__(self, most_waiting: int = MOST_WAITING, most_bytes: int = MOST_WAITING_BYTES) -> None:
        self._waiting: deque[str | bytes] = deque()
        self._newest: dict[Hashable, str] = {}
        self._bytes = 0
        self._most_waiting, self._most_bytes = most_waiting, most_bytes
        self._on_their_way: deque[int] = deque()
        self._newest_state = 0

    def put(self, frame: str | bytes) -> bool:
        """Adds a message. False: the page reads too slowly, and must be closed."""
        self._waiting.append(frame)
        self._bytes += len(frame)
        return len(self._waiting) <= self._most_waiting and self._bytes <= self._most_bytes

    def put_newest(self, about: Hashable, frame: str) -> None:
        """Sets the message about something, such as the progress of a job; only the newest counts."""
        self._newest[about] = frame

    def drop_newest(self, about: Hashable) -> None:
        """Drops the message about something that has ended."""
        self._newest.pop(about, None)

    def take(self) -> str | bytes | None:
        """The next message; None if there is none."""
        if self._waiting:
            frame = self._waiting.popleft()
            self._bytes -= len(frame)
            return frame
        if self._newest:
            return self._newest.pop(next(iter(self._newest)))
        return None

    def wants_state(self, number: int) -> bool:
        """Whether the state of that number is newer than the last, and may be sent now."""
        return number > self._newest_state and len(self._on_their_way) < MOST_STATES

    def sent_state(self, number: int) -> None:
        """Records a state as sent."""
        self._newest_state = number
        self._on_their_way.append(number)

    def acknowledged(self, number: int) -> None:
        """Acknowledges a state, and all before it. Ignores states never sent."""
        if number in self._on_their_way:
            while self._on_their_way.popleft() != number:
                pass
