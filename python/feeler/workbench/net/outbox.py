"""What waits to be sent to one page: messages that none may miss, in their order, and the newest state.

A queue of messages is kept until it is too long, which means that the page does not take them; then it is over with the
page, and a new connection has everything anew. Of states only the newest counts: one is made as it is sent, and none
while two are on their way that the page has not acknowledged.
"""

from __future__ import annotations

from collections import deque

MOST_STATES = 2
"""On their way, sent and not acknowledged."""

MOST_WAITING = 4000
"""Messages."""

MOST_WAITING_BYTES = 32 << 20
"""Characters and bytes of the messages."""


class Outbox:
    """Of one page. Not thread-safe: the net thread's own."""

    def __init__(self, most_waiting: int = MOST_WAITING, most_bytes: int = MOST_WAITING_BYTES) -> None:
        self._waiting: deque[str | bytes] = deque()
        self._progress: dict[int, str] = {}
        self._bytes = 0
        self._most_waiting, self._most_bytes = most_waiting, most_bytes
        self._on_their_way: deque[int] = deque()
        self._newest_state = 0

    def put(self, frame: str | bytes) -> bool:
        """One more message that the page may not miss. False: it takes too few, and is to be closed."""
        self._waiting.append(frame)
        self._bytes += len(frame)
        return len(self._waiting) <= self._most_waiting and self._bytes <= self._most_bytes

    def put_progress(self, job: int, frame: str) -> None:
        """How far a job is; the newest of a job counts."""
        self._progress[job] = frame

    def end_progress(self, job: int) -> None:
        """The job is over: what its reply says is all there is to say."""
        self._progress.pop(job, None)

    def take(self) -> str | bytes | None:
        """The next message; None: none waits."""
        if self._waiting:
            frame = self._waiting.popleft()
            self._bytes -= len(frame)
            return frame
        if self._progress:
            return self._progress.pop(next(iter(self._progress)))
        return None

    def wants_state(self, number: int) -> bool:
        """Whether a state of that number is newer than the last, and may be sent now."""
        return number > self._newest_state and len(self._on_their_way) < MOST_STATES

    def sent_state(self, number: int) -> None:
        """A state is on its way."""
        self._newest_state = number
        self._on_their_way.append(number)

    def acknowledged(self, number: int) -> None:
        """The page has a state, and so every one before it. What was never sent is no news."""
        if number in self._on_their_way:
            while self._on_their_way.popleft() != number:
                pass
