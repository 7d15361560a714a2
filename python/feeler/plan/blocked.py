"""What was in the way."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Blocker:
    """A part that was in the way, and how often."""

    part: int
    """Index into `mockup.parts`."""
    path: str
    count: int
    """Tries that it stopped: seats at which a tool meets it, and casts that end at it."""
