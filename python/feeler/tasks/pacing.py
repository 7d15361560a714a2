"""How far a task is: by what is known of the work, not by its time limit."""

from __future__ import annotations

from feeler.plan.question import Clock
from feeler.progress import Progress


class Pace(Clock):
    """A clock whose progress is the share of the work that is done, as far as it is known, or of the time, if that is
    nearer to its end. It never goes back."""

    def __init__(self, seconds: float, progress: Progress | None = None) -> None:
        super().__init__(seconds, progress)
        self._begin, self._end, self._furthest = 0.0, 0.0, 0.0

    @property
    def share(self) -> float:
        """0 to 1."""
        self._furthest = max(self._furthest, super().share)
        return self._furthest

    def stage(self, end: float, what: str) -> None:
        """Begins a stage of the work, which ends at a share of all; goes on with it if it has begun."""
        if end > self._end:
            self.within(1.0)
            self._begin, self._end = self._end, end
        self.tell(what)

    def within(self, share: float) -> None:
        """Notes how much of the stage is done, 0 to 1."""
        now = self._begin + (self._end - self._begin) * min(1.0, max(0.0, share))
        self._furthest = max(self._furthest, now)

    def heard(self, share: float, _stage: str = "") -> None:
        """As a `Progress` of the stage."""
        self.within(share)
        self.look()
