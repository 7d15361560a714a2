"""What a pair of parts is said to do, and how sure its depth is."""

from __future__ import annotations

from enum import IntEnum


class Verdict(IntEnum):
    """What two parts do where they are."""

    CLASH = 0
    """They meet, and are deeper than `contact`; or both are walls thinner than that, each through the other."""
    CONTACT = 1
    """They meet and are no deeper than `contact`, or the gap between them is no more."""
    CLEARANCE = 2
    """They are apart, and nearer than their `clearance`."""
    CONTAINED = 3
    """One is closed and holds the other."""
    DUPLICATE = 4
    """They have the same surface, however it is cut into triangles."""


DEPTH_KINDS = ("measured", "estimate")
"""What a depth is, by the core's number: measured within its error, or, where a part is open, an estimate."""

SEVERITIES = ("critical", "major", "minor")
"""What a rule may say of its findings, the worst first."""

DEFAULT_SEVERITY = "major"
DEFAULT_RULE = "default"
"""The name of what holds for pairs that no rule names."""

OVERLAPS = (Verdict.CLASH, Verdict.CONTAINED, Verdict.DUPLICATE)
"""Verdicts of pairs that share a space, and not only a surface."""
