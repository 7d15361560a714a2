"""Parts that block a motion."""

from __future__ import annotations

from dataclasses import dataclass

from feeler.field_docs import documented


@documented
@dataclass(frozen=True)
class Blocker:
    """A part that stopped attempts, and how often."""

    part: int
    """Index into `mockup.parts`."""
    path: str
    """Its path; empty if it has none."""
    count: int
    """Attempts that it stopped: seats at which the tool collides with it, and casts that end at it."""
