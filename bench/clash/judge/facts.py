"""The expected facts of a pair, and the verdicts that follow."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Facts:
    """The expected facts of a pair of parts.

    low, high: bounds of the penetration depth D, metres. gap: 0 if the parts meet; None if they are apart by an unknown
    distance. is_same: equal surfaces. is_inside: one closed part contains the other. is_touching: the surfaces have a
    common point. share: the shared volume as a fraction of the smaller volume. is_open: a part is open.
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
"""Above this share, a pair that is at most `contact` deep may count as copies, or as one inside the other."""


def wanted(facts: Facts, contact: float | None, clearance: float, rounding: float) -> frozenset[str] | None:
    """The right verdicts; None if rounding or the bounds of the depth leave them open.

    contact: None is the default, 32 units in the last place. rounding: how much it may change a depth, metres; 0 for
    exact coordinates.
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
    if facts.is_open and 0 < facts.high <= least and contact is not None:
        return frozenset({"contact"})  # also inside: a sheet that is nowhere deeper than `contact`
    if facts.is_open and facts.low <= least < facts.high:
        return None
    if facts.is_inside:
        # If the surfaces touch, rounding may move a face to the outside.
        return frozenset({"contained", "clash"} if rounding and facts.is_touching else {"contained"})
    if facts.high <= least and (contact is not None or facts.high == 0):
        return frozenset({"contact", *(["duplicate", "clash"] if facts.share > NEARLY_ALL else [])})
    if facts.low > least:
        is_nearly_inside = contact is not None and facts.share > NEARLY_ALL
        return frozenset({"clash", *(["contained"] if is_nearly_inside else [])})
    return None
