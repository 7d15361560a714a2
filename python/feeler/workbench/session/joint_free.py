"""How far a joint goes on its way to a value: to a contact or a limit, or all the way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from feeler.mechanism.answers import MechanismContact, Range
from feeler.mechanism.positions import Positions
from feeler.mechanism.ranging import range_of, repeats

SLACK = 1e-9
"""Radians, metres: a value that is so near to an end is at it."""
_ROUND = 2.0**-31  # radians, metres
_MARGIN = 1e-4  # radians, metres: ranges found from different places agree to less
_MOST_RANGES = 20  # one after the other, of a joint without limits, in one move


@dataclass(frozen=True)
class Went:
    """Where a joint got to. met: the contact there. is_limit: its limit is there. why: what else ended it, or empty."""

    value: float
    met: MechanismContact | None = None
    is_limit: bool = False
    why: str = ""


def range_from(positions: Positions, name: str, given: Mapping[str, float]) -> Range:
    """The range of a number from a position. Ends at contact are rounded inwards, and the position stays inside."""
    found = range_of(positions, name, given)
    lower, upper = found.lower, found.upper
    if found.below is not None:
        lower = min(math.ceil(lower / _ROUND) * _ROUND, max(lower, found.start))
    if found.above is not None:
        upper = max(math.floor(upper / _ROUND) * _ROUND, min(upper, found.start))
    return replace(found, lower=lower, upper=upper)


def is_inside(positions: Positions, found: Range, start: float, value: float) -> bool:
    """Whether a range says that the way between two values is free, wherever in the range it was found from."""
    ends = positions.limits(found.joint) or (-math.inf, math.inf)
    is_closed = (found.upper == ends[1] or found.above) if value > start else (found.lower == ends[0] or found.below)
    least = found.lower + (_MARGIN if found.below else 0.0)
    most = found.upper - (_MARGIN if found.above else 0.0)
    is_start = found.lower - SLACK <= start <= found.upper + SLACK
    return bool(is_closed) and is_start and least <= value <= most


def went(positions: Positions, name: str, others: Mapping[str, float], found: Range, value: float) -> Went:
    """Where a number gets to on its way to a value: where a joint has no limits, the range that ends is followed by
    the next one. found: its range from where it stands. others: the numbers that do not follow it."""
    limits = positions.limits(name)
    is_loop = bool(positions.loops_of(name))
    for _ in range(_MOST_RANGES):
        if limits is None and found.below is None and found.above is None and repeats(positions, name):
            return Went(value)  # a whole turn is free, and so are all others
        at = min(max(value, found.lower), found.upper)
        if found.below is not None and value <= found.lower + SLACK:
            return Went(at, found.below)
        if found.above is not None and value >= found.upper - SLACK:
            return Went(at, found.above)
        if at == value:
            return Went(at)
        if limits is not None and at in limits:
            return Went(at, is_limit=True)
        if is_loop or at == found.start:
            break
        found = range_from(positions, name, {**others, name: at})
    return Went(at, why=found.ended or f"{name!r} was followed to {positions.said(name, at)}")
