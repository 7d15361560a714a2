"""What a pair of parts is said to do, and how sure its depth is."""

from __future__ import annotations

from enum import IntEnum


class Verdict(IntEnum):
    """What two parts do where they are."""

    CLASH = 0
    """They meet, and one is deeper in the other than their `contact`."""
    CONTACT = 1
    """They meet no deeper than that, or are no farther apart."""
    CLEARANCE = 2
    """They are apart, and nearer than their `clearance`."""
    CONTAINED = 3
    """One is closed and holds the other, and their surfaces do not cross."""
    DUPLICATE = 4
    """They have the same triangles, corner by corner."""


DEPTH_KINDS = ("exact", "bound", "estimate")
"""How sure a depth is, by the core's number: as `Penetration.kind`."""

SEVERITIES = ("critical", "major", "minor")
"""What a rule may say of its findings, the worst first."""

DEFAULT_SEVERITY = "major"
DEFAULT_RULE = "default"
"""The name of what holds for pairs that no rule names."""

OVERLAPS = (Verdict.CLASH, Verdict.CONTAINED, Verdict.DUPLICATE)
"""Verdicts of pairs that share a space, and not only a surface."""
