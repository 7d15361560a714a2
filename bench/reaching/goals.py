"""The goals, and whether a run meets them. There is a goal for a time too, but no run fails because of it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import section
from section import Goal, Result

ENGINE_S = 60.0
"""Seconds on one core for 200 bolts of the engine of 1.6 million triangles, with the whole catalogue."""
FULL, BOLTS = 1_500_000, 200


def _engine(found: Result) -> Iterator[Goal]:
    about = f"{found['bolts']} bolts, {found['triangles']:,} triangles, one core"
    if found["triangles"] > FULL and found["bolts"] == BOLTS:
        seconds = found["seconds"]
        yield Goal("engine", about, f"{ENGINE_S:g} s", f"{seconds:.3g} s", seconds <= ENGINE_S, True)
    yield Goal("engine", "answers that casts refute", "0", f"{found['wrong']}", found["wrong"] == 0)


def _gearbox(found: Result) -> Iterator[Goal]:
    for tool, row in found["rows"].items():
        is_all = row["found"] == row["fasteners"]
        yield Goal("gearbox", f"{tool}: found", f"{row['fasteners']}", f"{row['found']}", is_all)
        yield Goal("gearbox", f"{tool}: answers that casts refute", "0", f"{row['wrong']}", row["wrong"] == 0)
    planted = len(found["planted"])
    yield Goal("gearbox", "tools on the bolt under the planted guard", "0", f"{planted}", planted == 0)


JUDGES = {"engine": _engine, "gearbox": _gearbox}
scorecard = partial(section.scorecard, JUDGES)
