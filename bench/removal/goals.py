"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import section
from section import Goal, Result

MEDIAN_S = {"peg, 1 %": 0.05, "peg, 0.1 %": 0.05, "tubes, 1.6": 0.1}
"""Of every seed a way, on one core; the median."""
AIMED_FOUND = {"tubes, 1.2": 0.9}
"""Share of the seeds, within the time of a try."""
STRAIGHT_S = 0.05
PARTS_A_MINUTE = 100
ACCESS_S = 5.0


def _puzzles(found: Result) -> Iterator[Goal]:
    for row in found["puzzles"]:
        name, ours = row["name"], row["tries"][0]
        seeds = ours["seeds"]
        if not row["has_way"]:
            is_right = ours["found"] == 0 and ours["named"] == seeds
            said = "the box named" if is_right else f"{ours['found']} found, {ours['named']} named"
            yield Goal(name, "ends, and names the box", "the box named", said, is_right)
            continue
        yield Goal(name, "ways that are free", "all that are found", f"{ours['free']}", ours["free"] == ours["found"])
        if name in MEDIAN_S:
            wanted = f"{seeds} of {seeds}"
            # That a way is found before the time of a try is up is a matter of the clock.
            yield Goal(name, "seeds", wanted, f"{ours['found']} of {seeds}", ours["found"] == seeds, True)
            said, is_met = f"{ours['median_s']:.3g} s", ours["median_s"] <= MEDIAN_S[name]
            yield Goal(name, "median", f"{MEDIAN_S[name]:g} s", said, is_met, True)
        if name in AIMED_FOUND:
            share = AIMED_FOUND[name]
            is_met = ours["found"] >= share * seeds
            said = f"{ours['found']} of {seeds}"
            yield Goal(name, f"seeds within {found['seconds']:g} s", f"{100 * share:g} %", said, is_met, True)


def _engine(found: Result) -> Iterator[Goal]:
    straight, rate, access = found["straight"], found["rate"], found["access"]
    name = f"engine, {straight['triangles']:,} triangles"
    worst = straight["straight_s"].get("worst")
    said = "none" if worst is None else f"{1e3 * worst:.3g} ms"
    is_met = worst is not None and worst <= STRAIGHT_S
    yield Goal(name, "a straight way, the slowest", f"{1e3 * STRAIGHT_S:g} ms", said, is_met, True)
    name = f"engine, {rate['triangles']:,} triangles"
    a_minute = 60.0 * rate["parts"] / rate["total_s"]
    yield Goal(name, "parts a minute", f"{PARTS_A_MINUTE}", f"{a_minute:.3g}", a_minute >= PARTS_A_MINUTE, True)
    yield Goal(name, "ways that are free", "all that are found", f"{rate['free']}", rate["free"] == rate["found"])
    what = f"{access['targets']} bolts x {access['angles']} angles"
    is_met = access["worst_s"] <= ACCESS_S
    yield Goal(name, what, f"{ACCESS_S:g} s", f"{access['worst_s']:.3g} s at most", is_met, True)


JUDGES = {"puzzles": _puzzles, "engine": _engine}
scorecard = partial(section.scorecard, JUDGES)
