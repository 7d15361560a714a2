"""Values of options: lengths, angles, times, numbers, words. Each kind is read from text in one way by all commands.

A command annotates an option with its type, `typer.Option`, and a `Value`; `command` in `app.py` reads the text and
puts the option's name in front of errors.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from feeler.arguments import MOST_THREADS, near

_NUMBER = re.compile(r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(.*)", re.ASCII)
_GROUPED = re.compile(r"[-+]?[1-9]\d*,\d{3}", re.ASCII)
_PIXELS = re.compile(r"(\d{1,5})x(\d{1,5})", re.ASCII)
_WHOLE = re.compile(r"[-+]?\d[\d_]{0,30}", re.ASCII)
_ANGLES = {"": 1.0, "deg": 1.0, "degrees": 1.0, "\N{DEGREE SIGN}": 1.0, "rad": 180.0 / math.pi}
_TIMES = {"": 1.0, "s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}


class Value:
    """A kind of value. `metavar` is its word in --help."""

    metavar: str

    def read(self, text: str) -> Any:
        """Return the value of a text. Raise `ValueError` that says what to give."""
        raise NotImplementedError

    def shown(self, value: Any) -> str:
        """Return a text that reads as this value, for --help."""
        return str(value)


@dataclass(frozen=True)
class Text(Value):
    """Any text but none: the name of a file, a pattern, a list of words."""

    metavar: str = "TEXT"

    def read(self, text: str) -> str:
        """See `Value.read`."""
        if text.strip():
            return text
        raise ValueError("give a text that is not empty")


@dataclass(frozen=True)
class FileName(Value):
    """The name of a file or folder."""

    metavar: str = "FILE"

    def read(self, text: str) -> Path:
        """See `Value.read`."""
        if text.strip() and "\0" not in text:
            return Path(text)
        raise ValueError("give the name of a file")


@dataclass(frozen=True)
class Number(Value):
    """A number from `least` to `most`, above `above`; with one of the units, as a multiple of the documented one.

    A comma begins decimals, unless it may group thousands: "0,5" is a half, "1,000" is refused.
    """

    metavar: str = "NUMBER"
    what: str = "a number"
    example: str = ""
    units: Mapping[str, float] = field(default_factory=lambda: {"": 1.0})
    least: float = -math.inf
    above: float = -math.inf
    most: float = math.inf
    suffix: str = ""  # of shown values

    def read(self, text: str) -> float:
        """See `Value.read`."""
        found = _NUMBER.fullmatch(text.strip())
        factor = self.factor(found[2].strip()) if found else None
        value = math.nan
        if found and _GROUPED.fullmatch(found[1]):
            plain, decimal = found[1].replace(",", ""), found[1].replace(",", ".")
            raise ValueError(f"its comma may group thousands or begin decimals: give {plain} or {decimal}")
        if found and factor is not None:
            number = float(found[1].replace(",", "."))
            # Divided where the unit is a fraction: 5 mm are the double nearest to 0.005, and 5 * 0.001 may not be.
            value = number / round(1.0 / factor) if factor < 1.0 and (1.0 / factor).is_integer() else number * factor
            if self.least <= value <= self.most and value > self.above and math.isfinite(value):
                return value
        span = self._range(is_too_large=value > self.most)
        raise ValueError(f"give {self.what}{span}{self.example and ', such as ' + self.example}")

    def shown(self, value: float) -> str:
        """See `Value.shown`."""
        return f"{value:g}{self.suffix}"

    def factor(self, unit: str) -> float | None:
        """Return the multiple that a unit is of the documented one; None for an unknown unit."""
        return self.units.get(unit, self.units.get(unit.lower()))

    def _range(self, is_too_large: bool) -> str:
        """The range in words. An upper end that serves arithmetic alone is told to those who meet it."""
        has_end = self.most < 1e9 or is_too_large
        if math.isfinite(self.above):
            return f" above {self.above:g}" + (f", up to {self.most:g}" if has_end else "")
        if self.least == -self.most:
            return ""
        return f" from {self.least:g} to {self.most:g}" if has_end else f" of {self.least:g} or more"


@dataclass(frozen=True)
class Length(Number):
    """A length in metres; with any unit that files may have."""

    metavar: str = "LENGTH"
    what: str = "a length"
    example: str = "5mm, 0.2in or 0.005 (metres)"

    def factor(self, unit: str) -> float | None:
        """See `Number.factor`."""
        from feeler.errors import OptionError
        from feeler.io.units import parse_unit

        try:
            return parse_unit(unit).metres if unit else 1.0
        except OptionError:
            return None

    def shown(self, value: float) -> str:
        """See `Value.shown`."""
        from feeler.words import length

        return length(value).replace(" ", "").replace("µ", "u") if value else "0"


@dataclass(frozen=True)
class Whole(Value):
    """A whole number from `least` to `most`. Underscores may group its digits."""

    least: int = 0
    most: int = 2**64 - 1
    metavar: str = "INTEGER"

    def read(self, text: str) -> int:
        """See `Value.read`."""
        if _WHOLE.fullmatch(text.strip()) and self.least <= int(text) <= self.most:
            return int(text)
        span = f"of {self.least:,} or more" if self.most == 2**64 - 1 else f"from {self.least:,} to {self.most:,}"
        raise ValueError(f"give a whole number {span}")


@dataclass(frozen=True)
class Word(Value):
    """One of some words."""

    words: Sequence[str]

    @property
    def metavar(self) -> str:  # type: ignore[override]
        """See `Value`."""
        return "|".join(self.words)

    def read(self, text: str) -> str:
        """See `Value.read`."""
        word = text.strip().lower()
        if word in self.words:
            return word
        raise ValueError(near(word, self.words) if word else f"choose {', '.join(self.words)}")


@dataclass(frozen=True)
class Or(Value):
    """A value, or a word that stands for another rule."""

    value: Value
    word: str

    @property
    def metavar(self) -> str:  # type: ignore[override]
        """See `Value`."""
        return f"{self.value.metavar}|{self.word}"

    def read(self, text: str) -> Any:
        """See `Value.read`."""
        if text.strip().lower() == self.word:
            return self.word
        try:
            return self.value.read(text)
        except ValueError as error:
            raise ValueError(f"{error}; or {self.word}") from None

    def shown(self, value: Any) -> str:
        """See `Value.shown`."""
        return self.word if value == self.word else self.value.shown(value)


@dataclass(frozen=True)
class Triple(Value):
    """Three numbers, separated by commas, semicolons or blanks. With decimal commas, semicolons separate them."""

    each: Number
    metavar: str
    what: str

    def read(self, text: str) -> tuple[float, ...]:
        """See `Value.read`."""
        separator = ";" if ";" in text else "," if "," in text else None
        words = [word for word in text.split(separator) if word.strip()]
        try:
            values = [self.each.read(word) for word in words]
        except ValueError:
            values = []
        # A unit behind the last number alone could be meant for all three, or for it.
        has_unit = [bool(found[2]) for word in words if (found := _NUMBER.fullmatch(word.strip()))]
        if len(values) != 3 or len({unit for unit, value in zip(has_unit, values, strict=False) if value}) > 1:
            raise ValueError(f"give three {self.what}, all with a unit or all without")
        return tuple(values)


@dataclass(frozen=True)
class Pixels(Value):
    """Width and height of a picture."""

    metavar: str = "WxH"

    def read(self, text: str) -> tuple[int, int]:
        """See `Value.read`."""
        found = _PIXELS.fullmatch(text.strip().lower())
        if found and int(found[1]) and int(found[2]):
            return int(found[1]), int(found[2])
        raise ValueError("give width and height in pixels, such as 1600x1000")

    def shown(self, value: tuple[int, int]) -> str:
        """See `Value.shown`."""
        return f"{value[0]}x{value[1]}"


@dataclass(frozen=True)
class UnitName(Value):
    """The unit of the numbers in a file."""

    metavar: str = "UNIT"

    def read(self, text: str) -> str:
        """See `Value.read`."""
        from feeler.errors import OptionError
        from feeler.io.units import KNOWN_UNITS, parse_unit

        try:
            return parse_unit(text).name
        except OptionError:
            raise ValueError(f"choose {', '.join(KNOWN_UNITS)}") from None


_FARTHEST = 1e12
"""A limit of lengths, metres, far beyond all mock-ups: products of larger numbers would be infinite."""

LENGTH = Length(least=0.0, most=_FARTHEST)
POSITIVE_LENGTH = Length(above=0.0, most=_FARTHEST)
ANY_LENGTH = Length(least=-_FARTHEST, most=_FARTHEST)
SWING = Number("ANGLE", "an angle", "60 (degrees), 60deg or 1.05rad", _ANGLES, above=0.0, most=360.0, suffix="deg")
SECONDS = Number("TIME", "a time", "30 (seconds), 500ms or 2min", _TIMES, above=0.0, most=1e9, suffix="s")
STIFFNESS = Number(what="a stiffness", above=0.0, most=1e9)
SHARE = Number(what="a share", least=0.0, most=1.0)
SHARE_SAVED = Number(least=0.0, most=0.99)
SERVO_RATE = Number(what="a rate", least=50.0, most=100_000.0)
COLLISION_RATE = Number(what="a rate", least=1.0, most=1e6)  # a slower search would end that much later, too
COUNT = Whole(1, 2**32 - 1)
POSES = Whole(1, 10_000_000)
SEED = Whole(0)
THREADS = Whole(1, MOST_THREADS)
POSITION = Triple(ANY_LENGTH, "X,Y,Z", "lengths, such as 0.42,-0.1,0.3 (metres) or 420mm,-100mm,300mm")
ANGLE = Number("ANGLE", "an angle", "110 (degrees), 110deg or 1.9rad", _ANGLES)
TURNS = Number(what="a number of turns", above=0.0, most=1e6)
TURN = Triple(ANGLE, "RX,RY,RZ", "angles, such as 0,90,0 (degrees)")
DIRECTION = Triple(Number(), "X,Y,Z", "numbers, such as 0,0,1")
PIXELS = Pixels()
UNIT = UnitName()
UP = Word(("x", "y", "z"))
TOUCHING = Word(("counts", "free"))
STORAGE = Word(("blocks", "dense", "hashed"))
