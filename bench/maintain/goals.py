"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import section
from section import Goal, Result

HOUR_S = 3600.0
"""For 100 parts of the engine of 1.6 million triangles, on one core."""
SHARE = 0.1
"""Of a full run, where one part in a hundred moved."""
FULL, PARTS = 1_500_000, 100


def is_full(found: Result) -> bool:
    """Whether the goal for the time is for this run."""
    return bool(found["triangles"] > FULL and found["rows"] == PARTS)


def _judge(name: str, found: Result) -> Iterator[Goal]:
    if is_full(found):
        seconds = found["seconds"]
        about = f"{found['rows']} parts, {found['triangles']:,} triangles, one core"
        yield Goal(name, about, f"{HOUR_S:g} s", f"{seconds:.3g} s", seconds <= HOUR_S, True)
    differing = len(found["same_differs"]) + sum(len(each["differs"]) for each in found["moved"])
    yield Goal(name, "rows that a full run finds otherwise", "0", f"{differing}", differing == 0)
    for each in found["moved"]:
        share = each["seconds"] / each["full_seconds"]
        yield Goal(name, "1 % moved, of a full run", f"{SHARE:.0%}", f"{share:.1%}", share <= SHARE, True)


JUDGES = {name: partial(_judge, name) for name in ("engine", "gearbox")}
scorecard = partial(section.scorecard, JUDGES)
