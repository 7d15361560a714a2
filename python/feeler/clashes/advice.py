"""Explains results that are empty or incomplete: a single part, open parts, nothing within the clearance."""

from __future__ import annotations

import numpy as np

from feeler.clashes.result import Clashes
from feeler.clashes.verdict import Verdict
from feeler.clashes.words import named
from feeler.words import length

_COARSE_M = 1e-5
"""From this least contact on a note says that the file is rounded: less is below what mechanical parts are made to."""


def advice(clashes: Clashes) -> list[str]:
    """Notes on what the check could not find, and what to do about it. Empty if nothing needs explaining."""
    facts = clashes.facts
    found = []
    present = facts.present if facts.present is not None else facts.parts
    if present < 2 and not len(clashes):
        what = "1 part" if present == 1 else "no part"
        if facts.parts > present:
            left = f"{what} of {facts.parts:,} is in the check"
            found.append(f"{left}, so there is nothing to check against: leave fewer parts out")
        else:
            found.append(
                f"{what} only: there is nothing to check against. Pass an assembly, or several files. A model that was "
                "exported as one body counts as one part"
            )
    elif not len(clashes) and not clashes.is_partial:
        found.append(_nothing(clashes))
    if facts.open_parts:
        count = len(facts.open_parts)
        are, them = ("is", "it") if count == 1 else ("s are", "them")
        found.append(
            f"{count:,} part{' ' * (count == 1)}{are} not closed, so parts inside {them} are not found: "
            f"{named(facts.open_parts)}. Export {them} as solid, or close the surfaces"
        )
    if crossing := _open_crossing(clashes):
        found.append(crossing)
    if facts.least_contact > _COARSE_M:
        found.append(
            f"the coordinates of the file are rounded, so parts up to {length(facts.least_contact)} in each other are "
            "contacts. Export nearer to the origin, or with more digits"
        )
    return [*found, *facts.notes]


def _open_crossing(clashes: Clashes) -> str:
    """What the depths of open parts mean; empty if no clash has one."""
    rows = clashes[(clashes.columns.verdict == Verdict.CLASH.code) & clashes.columns.is_open.any(axis=1)]
    if not len(rows):
        return ""
    sides = ((rows.parts_a, rows.is_open_a), (rows.parts_b, rows.is_open_b))
    parts = np.unique(np.concatenate([part[is_open] for part, is_open in sides]))
    paths = tuple(clashes.part_paths[part] for part in parts.tolist())
    what = "1 clash" if len(rows) == 1 else f"{len(rows):,} clashes"
    return (
        f"parts that are not closed are in {what}: {named(paths)}. They have no inside, so the depth is an estimate, "
        "and no shared volume is measured. Export them as solid, or close the surfaces"
    )


def _nothing(clashes: Clashes) -> str:
    facts = clashes.facts
    hidden = sum(clashes.hidden.values())
    if hidden:
        what = "the only finding" if hidden == 1 else f"all {hidden:,} findings"
        return f"the rules hide {what}. Check without rules to see {'it' if hidden == 1 else 'them'}"
    if facts.clearance == 0.0:
        return "no pair of parts collides. Pass a clearance, such as 0.002 metres, to find pairs that are too near"
    return (
        f"no pair of parts collides, or is within {length(facts.clearance)} of each other. Pass a larger clearance to "
        "find the nearest pairs"
    )
