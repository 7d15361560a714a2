"""Length units: their accepted names, and their lengths in metres."""

from __future__ import annotations

from typing import NamedTuple

from feeler.arguments import check_word, shown
from feeler.choices import UnitName
from feeler.errors import OptionError


class Unit(NamedTuple):
    """A length unit: its short name and its length in metres."""

    name: str
    metres: float


_UNITS: dict[UnitName, tuple[float, tuple[str, ...]]] = {
    "m": (1.0, ("metre", "metres", "meter", "meters")),
    "mm": (0.001, ("millimetre", "millimetres", "millimeter", "millimeters")),
    "cm": (0.01, ("centimetre", "centimetres", "centimeter", "centimeters")),
    "dm": (0.1, ("decimetre", "decimetres", "decimeter", "decimeters")),
    "um": (1e-6, ("micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers", "\N{MICRO SIGN}m")),
    "nm": (1e-9, ("nanometre", "nanometres", "nanometer", "nanometers")),
    "km": (1000.0, ("kilometre", "kilometres", "kilometer", "kilometers")),
    "in": (0.0254, ("inch", "inches", '"')),
    "ft": (0.3048, ("foot", "feet")),
    "yd": (0.9144, ("yard", "yards")),
    "mil": (0.0000254, ("mils", "thou")),
}

_BY_NAME: dict[str, Unit] = {
    alias: Unit(name, metres) for name, (metres, aliases) in _UNITS.items() for alias in (name, *aliases)
}

KNOWN_UNITS: tuple[UnitName, ...] = tuple(_UNITS)
"""The short names, in the order of messages."""


def parse_name(unit: object) -> UnitName | None:
    """Return the short name of a unit, None for None; raise `OptionError` for an unknown one."""
    return None if unit is None else check_word("unit", parse_unit(unit).name, KNOWN_UNITS)


def parse_unit(unit: object) -> Unit:
    """Return the unit of that name; case does not matter. Raise `OptionError` for an unknown name."""
    if isinstance(unit, str):
        found = _BY_NAME.get(unit.strip()) or _BY_NAME.get(unit.strip().lower())
        if found is not None:
            return found
    raise OptionError(f"unit is {shown(unit)}, which is no unit that feeler knows: choose {', '.join(KNOWN_UNITS)}")
