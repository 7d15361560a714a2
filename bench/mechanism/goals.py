"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import section
from section import Goal, Result

DOOR_S = {"clearance": 0.5, "curve": 2.0}
"""Seconds on one core, of the engine of 1.6 million triangles."""
FULL = 1_500_000
POSITIONS = 1_000_000


def _door(found: Result) -> Iterator[Goal]:
    for row in found["sizes"]:
        about = f"{row['triangles']:,} triangles, one core"
        for what, wanted in DOOR_S.items() if row["triangles"] > FULL else ():
            seconds = row["seconds"][what]
            yield Goal(about, what, f"{wanted:g} s", f"{seconds:.3g} s", seconds <= wanted, True)
        is_bounded = row["lower"] <= row["upper"] <= row["lower"] + 1.01 * row["error"] or row["upper"] == 0.0
        yield Goal(
            about, "bounds of the gap", f"{row['error']:g} m apart", f"{row['upper'] - row['lower']:.2g} m", is_bounded
        )


def _misses(found: Result) -> Iterator[Goal]:
    for row in found["cases"]:
        is_held = row["lower"] <= row["truth"] + 1e-9 and row["upper"] >= row["truth"] - 1e-9
        is_near = row["upper"] - row["truth"] <= 1.01 * found["error"]
        yield Goal("steps", row["case"], f"{row['truth']:g} m", f"{row['upper']:.6g} m", is_held and is_near)


def _bounds(found: Result) -> Iterator[Goal]:
    positions, above = (sum(row[key] for row in found["kinds"]) for key in ("positions", "above"))
    if not found["is_quick"]:
        yield Goal("bounds", "random positions", f"{POSITIONS:,}", f"{positions:,}", positions >= POSITIONS)
    yield Goal("bounds", f"bounds above the gap at {positions:,} positions", "0", f"{above}", above == 0)


JUDGES = {"door": _door, "steps": _misses, "bounds": _bounds}
scorecard = partial(section.scorecard, JUDGES)
