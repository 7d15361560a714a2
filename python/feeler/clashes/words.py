"""Describes findings in words, for tables, pages and topics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from feeler.clashes.result import Clashes, Group
from feeler.clashes.table import Clash
from feeler.clashes.verdict import Verdict
from feeler.words import length, plural, volume

_ERROR_SHARE, _LEAST_ERROR_M = 1.001e-3, 1e-9
"""The largest error of a measured depth, as a share and in metres, plus rounding: see `Clash.depth_error`."""
_TOUCHING_M = 1e-6
"""Contacts that overlap less than this touch: flush faces do so by rounding."""

_NAMED = 3
"""How many parts a note lists by name."""


def named(paths: Sequence[str]) -> str:
    """The names of some parts, of which there may be many, from their paths."""
    names = [path.rpartition("/")[2] or path for path in paths[:_NAMED]]
    more = len(paths) - _NAMED
    return ", ".join(names) + (f" and {more:,} more" if more > 0 else "")


def sentence(clash: Clash) -> str:
    """A sentence for one finding, with the last step of both paths."""
    one, other = (path.rpartition("/")[2] or "a part" for path in (clash.path_a, clash.path_b))
    if clash.verdict == Verdict.CLASH:
        return f"{one} is {deep(clash)} deep in {other}"
    if clash.verdict == Verdict.CONTAINED:
        return f"{one} and {other}: one is inside the other, {length(math.hypot(*clash.translation))} from coming out"
    if clash.verdict == Verdict.DUPLICATE:
        return f"{one} and {other} have the same surface"
    if is_allowed(clash):
        return f"{one} overlaps {other} by {deep(clash)}, allowed"
    if clash.verdict == Verdict.CONTACT and clash.gap == 0.0:
        return f"{one} touches {other}"
    return f"{one} is {length(clash.gap)} from {other}"


def is_allowed(clash: Clash) -> bool:
    """Whether the parts overlap by more than rounding, but at most by the `contact` of their rule."""
    return clash.verdict == Verdict.CONTACT and clash.depth > _TOUCHING_M


def deep(clash: Clash) -> str:
    """The depth; a range if the error is unusually large."""
    said = "about " if clash.depth_kind == "estimate" else ""
    least, most = length(clash.depth), length(clash.depth + clash.depth_error)
    is_wide = clash.depth_error > max(_ERROR_SHARE * clash.depth, _LEAST_ERROR_M)
    return said + (f"{least} to {most}" if is_wide and least != most else least)


def extent(clash: Clash) -> str:
    """Depth or gap, for one column of a table."""
    if clash.verdict == Verdict.DUPLICATE:
        return "same surface"
    if clash.verdict in (Verdict.CLASH, Verdict.CONTAINED):
        return deep(clash)
    if is_allowed(clash):
        return f"{deep(clash)}, allowed"
    return f"{length(clash.gap)} apart" if clash.gap > 0.0 else "touching"


def shared(clashes: Clashes) -> str:
    """The sum of the shared volumes; empty if none was measured."""
    is_known = np.isfinite(clashes.volumes)
    if not is_known.any():
        return ""
    unknown = int(np.count_nonzero(~is_known))
    more = f", unknown for {plural(unknown, 'pair')}" if unknown else ""
    return f"{volume(float(clashes.volumes[is_known].sum()))} in all{more}"


def hidden(clashes: Clashes) -> str:
    """How many findings each rule hides; empty if no rule hides pairs."""
    return ", ".join(f"{count:,} by {name}" for name, count in clashes.hidden.items())


def title(group: Group) -> str:
    """A group in one line: name, number of findings, and the worst."""
    more = plural(len(group), "finding")
    return f"{group.name}: {more}; {sentence(group.worst)}"


def capitalised(text: str) -> str:
    """The text with a capital first letter."""
    return text[:1].upper() + text[1:]
