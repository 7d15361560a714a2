"""Verdicts, severities and kinds of depth."""

from __future__ import annotations

from feeler import choices
from feeler.choices import Severity
from feeler.enumerations import CodedEnum


class Verdict(CodedEnum):
    """The relation of two parts: words, with numbers (`.code`) from 0 on in their order."""

    CLASH = "clash"
    """They collide and are deeper than `contact`, or they are thin walls that cross or share their thickness."""
    CONTACT = "contact"
    """They collide and are at most `contact` deep, or they are at most `contact` apart."""
    CLEARANCE = "clearance"
    """They are farther apart than `contact`, but at most `clearance`."""
    CONTAINED = "contained"
    """They do not cross; one is closed and contains the other, which is closed or deeper than `contact`."""
    DUPLICATE = "duplicate"
    """They have the same surface but for rounding, however it is cut into triangles."""


DEPTH_KINDS = choices.DEPTH_KINDS
"""Kinds of depth, by the number of the core: measured within its error, or an estimate if a part is open."""

SEVERITIES = choices.SEVERITIES
"""The severities that a rule can set, the worst first."""

DEFAULT_SEVERITY: Severity = "major"
DEFAULT_RULE = "default"
"""The rule of pairs that no rule names."""

OVERLAPS = (Verdict.CLASH, Verdict.CONTAINED, Verdict.DUPLICATE)
"""Verdicts of pairs that share volume."""
