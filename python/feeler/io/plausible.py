"""Implausible sizes of mock-ups, mostly from a wrong unit, and the unit that would correct them."""

from __future__ import annotations

from feeler.io.units import Unit, parse_unit

LONGEST_M = 500.0
"""A large ship or plant; larger sizes raise a doubt."""

SHORTEST_M = 0.001
"""Smaller sizes raise a doubt: mock-ups are of things that people handle."""

# In the order of suggestion. One of these corrects every size that inches or centimetres would.
_USUAL = (("mm", "millimetres"), ("m", "metres"))


def size_note(length_m: float, units: list[Unit]) -> str | None:
    """Return the doubt about a mesh whose box is that long at its longest, read in these units; None if there is
    none."""
    if SHORTEST_M <= length_m <= LONGEST_M:
        return None
    size = f"{length_text(length_m)} long"
    if len(set(units)) != 1:
        return f"{size}: check the units of its files"
    for name, words in _USUAL:
        if SHORTEST_M <= length_m / units[0].metres * parse_unit(name).metres <= LONGEST_M:
            return f"{size}: if the file is in {words}, give the unit {name}"
    return f"{size}: check the unit ({units[0].name}), and the file for parts far from the rest"


def length_text(metres: float) -> str:
    """A length in words, in millimetres or metres."""
    if metres < 1.0:
        return f"{metres * 1000.0:.3g} mm"
    return f"{metres:,.0f} m" if 100.0 <= metres < 1e9 else f"{metres:.3g} m"
