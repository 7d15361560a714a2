"""`Times`: how long the elements of a step take, in a table that the user owns, and the arithmetic of a step."""

from __future__ import annotations

import fnmatch
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from feeler.arguments import check_number, check_path, check_text, shown
from feeler.atomic import atomic_file
from feeler.errors import LoadError, OptionError
from feeler.io.toml import check_version, parsed_toml, toml_of

LEAST_STROKE = 1e-4
"""A last stroke that is less than this share of one is rounding, and left out."""
LONGEST_S = 1e6
"""The longest element, seconds."""

EXAMPLES: dict[str, tuple[float, float, str]] = {
    "get": (8.0, 3.0, "take a tool from the trolley, or change it"),
    "reach": (3.0, 1.0, "bring hand and tool to a fastener and seat it"),
    "stroke": (1.2, 0.3, "one stroke of a tool, and back"),
    "draw": (3.0, 1.0, "draw an undone fastener with its washers"),
    "slide": (3.0, 1.0, "push an undone union nut back"),
    "clip": (12.0, 4.0, "take a circlip or a clip off"),
    "pin": (8.0, 3.0, "drive a pin out"),
    "take": (6.0, 2.0, "grasp a part and lead it out"),
    "aside": (4.0, 1.5, "put a part or a fastener aside"),
}
"""Element: mean and spread, seconds, and what it is. The figures are examples, not measurements."""

PITCHES_MM: dict[float, float] = {
    **{1.6: 0.35, 2.0: 0.4, 2.5: 0.45, 3.0: 0.5, 4.0: 0.7, 5.0: 0.8, 6.0: 1.0, 8.0: 1.25, 10.0: 1.5, 12.0: 1.75},
    **{14.0: 2.0, 16.0: 2.0, 18.0: 2.5, 20.0: 2.5, 22.0: 2.5, 24.0: 3.0, 27.0: 3.0, 30.0: 3.5, 33.0: 3.5, 36.0: 4.0},
    **{39.0: 4.0, 42.0: 4.5, 45.0: 4.5, 48.0: 5.0, 52.0: 5.0, 56.0: 5.5, 60.0: 5.5, 64.0: 6.0},
}
"""Coarse pitch of the ISO 261 sizes, by nominal diameter, millimetres."""


class Element(NamedTuple):
    """How long something takes."""

    mean: float
    """Seconds."""
    spread: float
    """Its standard deviation, seconds."""


TimeLike: TypeAlias = float | Sequence[float] | Element
"""Seconds, or mean and spread."""


class WholePath(str):
    """A pattern that matches this path alone, whatever its signs. It is not equal to the same text as a pattern."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, WholePath) and str.__eq__(self, other)

    def __hash__(self) -> int:
        return hash((WholePath, str(self)))


@dataclass(frozen=True)
class Timed:
    """The time of a step, with its arithmetic."""

    mean: float
    spread: float
    arithmetic: str


@dataclass(frozen=True)
class Turns:
    """How often a fastener is turned until it is free."""

    count: float
    arithmetic: str


class Times:
    """How long the elements of a step take, which pitches threads have, and steps whose time is typed.

    - `elements`: element -> mean, or (mean, spread), seconds; those left out have the figures of `EXAMPLES`.
    - `pitches_mm`: pattern -> pitch of these fasteners, millimetres; others have the coarse pitch of ISO 261.
    - `typed`: pattern -> mean, or (mean, spread), seconds, of the whole step of a fastener or part.

    A pattern is a path, a name, or has `*`, `?` or `[...]` and matches a whole path or name, as in `Parts.select`, but
    names nothing below a path. The first that matches counts.

    Spreads are standard deviations. Elements vary independently: their squares add. Raises `OptionError` for unknown
    elements and numbers out of range.
    """

    def __init__(
        self,
        elements: Mapping[str, TimeLike] | None = None,
        *,
        pitches_mm: Mapping[str, float] | None = None,
        typed: Mapping[str, TimeLike] | None = None,
    ) -> None:
        given = _table("elements", elements)
        unknown = [name for name in given if name not in EXAMPLES]
        if unknown:
            raise OptionError(f"elements has {unknown[0]!r}: an element is one of {', '.join(EXAMPLES)}")
        own = {name: _element(f"elements.{name}", value) for name, value in given.items()}
        self.elements: dict[str, Element] = {
            name: own.get(name, Element(mean, spread)) for name, (mean, spread, _) in EXAMPLES.items()
        }
        self.examples: tuple[str, ...] = tuple(name for name in EXAMPLES if name not in own)
        """The elements whose figures are the built-in examples."""
        self.pitches_mm = {
            name: check_number(f"pitches_mm[{name!r}]", value, "millimetres, above 0", above=0.0, most=100.0)
            for name, value in _table("pitches_mm", pitches_mm).items()
        }
        self.typed = {name: _element(f"typed[{name!r}]", value) for name, value in _table("typed", typed).items()}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Times:
        """Reads a TOML file with the tables `elements`, `pitches_mm` and `typed`. Raises `LoadError`."""
        file = check_path("path", path)
        return cls._of(toml_of(file, "write one with feeler.Times().save('times.toml')"), str(file))

    @classmethod
    def parse(cls, text: str) -> Times:
        """Reads what a file has. Raises `LoadError`."""
        return cls._of(parsed_toml(check_text("text", text), "times"), "times")

    @classmethod
    def _of(cls, data: Mapping[str, Any], file: str) -> Times:
        check_version(data, file)
        unknown = sorted(data.keys() - {"version", "elements", "pitches_mm", "typed"})
        if unknown:
            raise LoadError(f"{file}: [{unknown[0]}] is unknown: the tables are elements, pitches_mm and typed")
        try:
            return cls(data.get("elements"), pitches_mm=data.get("pitches_mm"), typed=data.get("typed"))
        except OptionError as error:
            raise LoadError(f"{file}: {error}") from None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as TOML. Raises `WriteError`."""
        with atomic_file(path, ".toml") as file:
            file.write(self.to_toml().encode())

    def to_toml(self) -> str:
        """As TOML, which `load` reads. Examples are commented out, so that they are examples when it is read again."""
        lines = ["# Seconds: [mean, spread]. The spread is a standard deviation."]
        if self.examples:
            lines.append(
                "# Where a line begins with #, its figures are an example, not measured: put in yours, without the #."
            )
        lines.append("[elements]")
        for name, (mean, spread) in self.elements.items():
            lines.append(f"{'# ' * (name in self.examples)}{name} = [{mean!r}, {spread!r}]  # {EXAMPLES[name][2]}")
        lines += [
            "",
            "# Pitches that are not the coarse ones of ISO 261, millimetres, by pattern of paths.",
            "[pitches_mm]",
        ]
        lines += [f"{_quoted(name)} = {pitch!r}" for name, pitch in self.pitches_mm.items()]
        lines += ["", "# Whole steps, by pattern of paths, seconds: [mean, spread].", "[typed]"]
        lines += [f"{_quoted(name)} = [{mean!r}, {spread!r}]" for name, (mean, spread) in self.typed.items()]
        return "\n".join(lines) + "\n"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Times) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]  # it holds dicts

    def __repr__(self) -> str:
        count = len(self.elements) - len(self.examples)
        return f"Times({count} of {len(self.elements)} elements given)"


def strokes_for(turns: float, stroke_deg: float) -> int:
    """Strokes of a tool for some turns, of at most a full turn each."""
    return max(1, math.ceil(turns * 360.0 / min(stroke_deg, 360.0) - LEAST_STROKE))


TimesLike: TypeAlias = Times | str | os.PathLike[str] | Mapping[str, TimeLike] | None
"""A table, its file, elements by name, or the examples."""


def times_of(times: TimesLike) -> Times:
    """A table as `task` takes it: one, a file, a dict of elements, or None for the examples."""
    if isinstance(times, Times):
        return times
    if times is None or isinstance(times, Mapping):
        return Times(times)
    if isinstance(times, (str, os.PathLike)):
        return Times.load(times)
    raise OptionError(f"times is {shown(times)}: give feeler.Times, a TOML file, or a dict of elements")


class Arithmetic:
    """Adds up the times of steps by a table."""

    def __init__(self, times: Times) -> None:
        self.times, self.elements = times, times.elements

    def typed_for(self, path: str) -> Timed | None:
        """The typed time of the step of a fastener or part."""
        element = _matching(self.times.typed, path)
        if element is None:
            return None
        mean, spread = element
        return Timed(mean, spread, f"{_spread(mean, spread)} s, typed")

    def turns(self, path: str, size: float, engaged: float) -> Turns:
        """How often a fastener is turned. size: diameter of its thread, engaged: length of the thread, metres."""
        if not (math.isfinite(size) and math.isfinite(engaged) and size > 0.0):
            return Turns(1.0, "1 turn: the mesh does not show its thread")
        own = _matching(self.times.pitches_mm, path)
        nominal = min(PITCHES_MM, key=lambda each: (abs(math.log(1e3 * size / each)), each))
        pitch = PITCHES_MM[nominal] if own is None else own
        count = 1e3 * engaged / pitch
        said = f"M{nominal:g}, ISO 261 coarse" if own is None else "pitch given"
        return Turns(count, f"{1e3 * engaged:.3g} mm / {pitch:g} mm ({said}) = {count:.3g} turns")

    def undo(self, path: str, turns: Turns, swing_deg: float, strokes: int, last: Sequence[str]) -> Timed:
        """A fastener by a tool in hand. last: the elements after the strokes."""
        typed = self.typed_for(path)
        if typed is not None:
            return typed
        said = f"{turns.arithmetic}; at {min(swing_deg, 360.0):.4g} deg a stroke: {strokes} strokes; "
        found = self.sum([("reach", 1), ("stroke", strokes), *((name, 1) for name in last)])
        return Timed(found.mean, found.spread, said + found.arithmetic)

    def by_hand(self, path: str, elements: Sequence[str]) -> Timed:
        """A step without a tool."""
        return self.typed_for(path) or self.sum([(name, 1) for name in elements])

    def sum(self, elements: Sequence[tuple[str, int]]) -> Timed:
        """Elements, each so often."""
        mean = math.fsum(count * self.elements[name].mean for name, count in elements)
        spread = math.sqrt(math.fsum(count * self.elements[name].spread ** 2 for name, count in elements))
        terms = [
            f"{'' if count == 1 else f'{count} x '}{name} {self.elements[name].mean:g}" for name, count in elements
        ]
        return Timed(mean, spread, f"{' + '.join(terms)} = {_spread(mean, spread)} s")


def _spread(mean: float, spread: float) -> str:
    return f"{mean:.4g} +- {spread:.2g}"


def _table(name: str, value: object) -> dict[str, Any]:
    if value is None:
        return {}
    if not isinstance(value, Mapping) or any(not isinstance(key, str) for key in value):
        raise OptionError(f"{name} is {shown(value)}: give a dict of names and numbers")
    return dict(value)


def _element(name: str, value: object) -> Element:
    pair = [value, 0.0] if isinstance(value, (int, float)) else value
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise OptionError(f"{name} is {shown(value)}: give seconds, or [mean, spread]")
    mean, spread = (
        check_number(name, each, f"seconds, 0 to {LONGEST_S:,.0f}", least=0.0, most=LONGEST_S) for each in pair
    )
    return Element(mean, spread)


def _matching(table: Mapping[str, Any], path: str) -> Any:
    """The entry of the first pattern that a path, or its last step, matches."""
    return next((value for name, value in table.items() if _is_named(path, name)), None)


def entries_for(times: Times, path: str) -> tuple[Any, Any]:
    """The pitch and the typed time that a table has for a path; None where it has none."""
    return _matching(times.pitches_mm, path), _matching(times.typed, path)


def idle_patterns(times: Times, paths: Iterable[str]) -> tuple[str, ...]:
    """The patterns of a table that match none of some paths."""
    every = list(paths)
    patterns = dict.fromkeys([*times.pitches_mm, *times.typed])
    return tuple(each for each in patterns if not any(_is_named(path, each) for path in every))


def _is_named(path: str, pattern: str) -> bool:
    """Whether a path, or its last step, matches a pattern."""
    if isinstance(pattern, WholePath):
        return path == str(pattern)
    return any(fnmatch.fnmatchcase(name, pattern) for name in (path, path.rsplit("/", 1)[-1]))


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'
