"""What is true of a pair, and which verdicts say so."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Facts:
    """low, high: bounds of the penetration depth D, metres. gap: 0 where the parts meet, None where it is not known.

    is_inside: one closed part holds the other. is_touching: they share a point of their surfaces. share: of the smaller
    volume, how much they have in common.
    """

    low: float
    high: float
    gap: float | None = 0.0
    is_same: bool = False
    is_inside: bool = False
    is_touching: bool = True
    share: float = 0.0
    is_open: bool = False

    def scaled(self, by: float) -> Facts:
        gap = None if self.gap is None else self.gap * by
        return replace(self, low=self.low * by, high=self.high * by, gap=gap)


NEARLY_ALL = 0.5
"""From this share on, parts that overlap by `contact` or less are copies of each other, or one is in the other."""


def wanted(facts: Facts, contact: float | None, clearance: float, rounding: float) -> frozenset[str] | None:
    """The right verdicts; None where rounding, or the bounds of the depth, leave it open.

    contact: None is the default, a few units in the last place. rounding: how far coordinates may have moved, metres;
    0 where they are exact.
    """
    least = 16 * rounding if contact is None else contact
    if facts.gap is None or facts.gap > least:
        if facts.gap is None or facts.gap > clearance + rounding:
            return frozenset({"none"})
        return frozenset({"clearance"}) if facts.gap < clearance - rounding else None
    if 0 < facts.gap <= least and contact is None:
        return None
    if facts.is_same:
        return frozenset({"duplicate"})
    if facts.is_inside:
        # Where they touch, a face may be out of the other by rounding.
        return frozenset({"contained", "clash"} if rounding and facts.is_touching else {"contained"})
    if facts.high <= least and (contact is not None or facts.high == 0):
        return frozenset({"contact", *(["duplicate", "clash"] if facts.share > NEARLY_ALL else [])})
    if facts.low > least:
        is_nearly_inside = contact is not None and facts.share > NEARLY_ALL
        return frozenset({"clash", *(["contained"] if is_nearly_inside else [])})
    return None
