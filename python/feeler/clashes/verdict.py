"""Verdicts, severities and kinds of depth."""

from __future__ import annotations

from feeler import choices
from feeler.choices import Severity
from feeler.enumerations import CodedEnum


class Verdict(CodedEnum):
    """The relation of two parts: words, with numbers (`.code`) from 0 on in their order.

    Thin walls: two walls thinner than `2 contact` clash at any depth if they pierce each other, that is, each reaches
    the middle (98 %) of the other and their surfaces cross there; or if they share more than `contact` of their
    thickness side by side. A wall has faces that are parallel within 26 degrees; one of the two may be a needle of any
    section. Blunter tips and edges are no walls, and their depth says how far they penetrate. Walls side by side are
    found at the deepest point of each part. At the edge of this rule, rotation and triangulation can change the
    verdict.

    Duplicates: no point of either surface is farther from the other than the default of `contact`; a larger `contact`
    makes no more duplicates. In files that round, closed duplicates must also share material: they are thicker than 2.5
    times that distance. A part and its copy with faces missing are in contact.

    Contained parts: a closed part that is flush with the inside of a face is contained however thin it is; in files
    that round, if it is deeper than `contact`. An open part that is nowhere deeper than `contact` is in contact, on
    either side of the face. A part that is larger than the closed hollow that it fills clashes, or is in contact if
    `contact` allows. Parts of several bodies, solids with their hollows and connected open surfaces, get the verdict of
    the gravest body: clash before contained before contact, each as if it were alone. A solid that is in both parts is
    contained; that is missed, and the parts are in contact, if another solid of one part shares a whole face with it,
    or if neither part has other solids, but open surfaces. Gaps in the seams and cracks of a closed part count as
    filled: a part that goes through a gap without touching its borders clashes, at any rotation and in any order; one
    that ends in a gap may be either. Parts with loose seams, of gaps up to four millionths of their length, contain
    parts that stick out by less than
    four times these gaps.
    """

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
