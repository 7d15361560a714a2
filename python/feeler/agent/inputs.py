"""Arguments of the tools: each kind has its JSON schema, and checks what an agent gave.

An agent may give anything, so every text, list and number has an end. Errors name the argument and say what to give.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from feeler.arguments import check_flag, check_number, check_whole, check_word, near, shown
from feeler.errors import OptionError, PoseError
from feeler.poses import one_pose, placed, rotation_xyz

FARTHEST_M = 1e5
"""The largest coordinate of a place, metres. A cast over distances at which coordinates round by millimetres takes for
ever."""
MOST_NAMES = 32
"""The most names or patterns of parts in one argument: each is compared with every part."""
MOST_CHARACTERS = 4_000
"""The longest name or pattern: also the path of a part in a deep assembly."""
NEEDED = object()
"""The default of an argument that must be given."""


class Kind(Protocol):
    """A kind of value."""

    def schema(self) -> dict[str, Any]:
        """Its JSON schema."""
        ...

    def read(self, what: str, value: object) -> Any:
        """Return the value, checked. `what`: its name in errors. Raises `OptionError`, `PoseError`."""
        ...


@dataclass(frozen=True)
class Argument:
    """An argument of a tool."""

    kind: Kind
    meaning: str
    default: Any = NEEDED


def read_arguments(given: object, known: Mapping[str, Argument]) -> dict[str, Any]:
    """The arguments of a call, with defaults for those that are absent or null. Raises `OptionError`, `PoseError`."""
    if given is None:
        given = {}
    if not isinstance(given, Mapping):
        raise OptionError(f"arguments are {shown(given)}: give an object with names and values")
    for name in given:
        if name not in known:
            hint = near(str(name), known, "it has none") if known else "it has none"
            raise OptionError(f"there is no argument {shown(name)}: {hint}")
    values = {}
    for name, argument in known.items():
        value = given.get(name)
        if value is not None:
            values[name] = argument.kind.read(name, value)
        elif argument.default is NEEDED:
            raise OptionError(f"{name} is missing: give it ({argument.meaning})")
        else:
            values[name] = argument.default
    return values


def input_schema(known: Mapping[str, Argument]) -> dict[str, Any]:
    """The JSON schema of all arguments of a tool."""
    properties = {}
    for name, argument in known.items():
        properties[name] = {**argument.kind.schema(), "description": argument.meaning}
        if argument.default is not NEEDED and argument.default is not None:
            properties[name]["default"] = argument.default
    needed = [name for name, argument in known.items() if argument.default is NEEDED]
    return {"type": "object", "properties": properties, "required": needed, "additionalProperties": False}


@dataclass(frozen=True)
class Number:
    """A number from `least` to `most`, above `above`."""

    give: str
    least: float = -FARTHEST_M
    most: float = FARTHEST_M
    above: float | None = None

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        begin = {"minimum": self.least} if self.above is None else {"exclusiveMinimum": self.above}
        return {"type": "number", **begin, "maximum": self.most}

    def read(self, what: str, value: object) -> float:
        """See `Kind`."""
        above = -np.inf if self.above is None else self.above
        return check_number(what, value, self.give, least=self.least, most=self.most, above=above)


@dataclass(frozen=True)
class Whole:
    """A whole number."""

    least: int = 0
    most: int = 2**32 - 1

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        return {"type": "integer", "minimum": self.least, "maximum": self.most}

    def read(self, what: str, value: object) -> int:
        """See `Kind`."""
        if isinstance(value, float) and value.is_integer():  # JSON has one kind of number: 3.0 is 3
            value = int(value)
        return check_whole(what, value, self.least, self.most)


@dataclass(frozen=True)
class Flag:
    """True or false."""

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        return {"type": "boolean"}

    def read(self, what: str, value: object) -> bool:
        """See `Kind`."""
        return check_flag(what, value)


@dataclass(frozen=True)
class Word:
    """One of some words."""

    words: Sequence[str]

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        return {"type": "string", "enum": list(self.words)}

    def read(self, what: str, value: object) -> str:
        """See `Kind`."""
        return check_word(what, value, self.words)


@dataclass(frozen=True)
class Text:
    """A short text."""

    give: str

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        return {"type": "string", "minLength": 1, "maxLength": MOST_CHARACTERS}

    def read(self, what: str, value: object) -> str:
        """See `Kind`."""
        if not isinstance(value, str) or not value.strip():
            raise OptionError(f"{what} is {shown(value)}: give {self.give}")
        if len(value) > MOST_CHARACTERS:
            raise OptionError(f"{what} has {len(value):,} characters: give at most {MOST_CHARACTERS:,}")
        return value


@dataclass(frozen=True)
class Names:
    """Names or patterns of parts: one, or a list."""

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        one = _NAME.schema()
        return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1, "maxItems": MOST_NAMES}]}

    def read(self, what: str, value: object) -> list[str]:
        """See `Kind`."""
        return [_NAME.read(what, value)] if isinstance(value, str) else _PATTERNS.read(what, value)


@dataclass(frozen=True)
class Many:
    """A list of values of one kind."""

    kind: Kind
    give: str
    least: int = 1
    most: int = MOST_NAMES

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        return {"type": "array", "items": self.kind.schema(), "minItems": self.least, "maxItems": self.most}

    def read(self, what: str, value: object) -> list[Any]:
        """See `Kind`."""
        if not isinstance(value, list):
            raise OptionError(f"{what} is {shown(value)}: give {self.give}")
        if not self.least <= len(value) <= self.most:
            raise OptionError(f"{what} has {len(value):,} entries: give {self.least} to {self.most}")
        return [self.kind.read(f"{what}[{i}]", each) for i, each in enumerate(value)]


@dataclass(frozen=True)
class Triple:
    """Three numbers. `is_direction`: not all of them zero."""

    give: str
    is_direction: bool = False
    most: float = FARTHEST_M

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        number = {"type": "number", "minimum": -self.most, "maximum": self.most}
        return {"type": "array", "items": number, "minItems": 3, "maxItems": 3}

    def read(self, what: str, value: object) -> tuple[float, float, float]:
        """See `Kind`."""
        if not isinstance(value, list) or len(value) != 3:
            raise OptionError(f"{what} is {shown(value)}: give {self.give}, as [x, y, z]")
        give = f"{self.give}, from {-self.most:g} to {self.most:g}"
        x, y, z = (check_number(what, each, give, least=-self.most, most=self.most) for each in value)
        if self.is_direction and not (x or y or z):
            raise OptionError(f"{what} is [0, 0, 0]: give three numbers, not all zero")
        return x, y, z


@dataclass(frozen=True)
class Record:
    """An object with some entries."""

    entries: Mapping[str, Kind]
    needed: Sequence[str]
    give: str

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        properties = {name: kind.schema() for name, kind in self.entries.items()}
        return {
            "type": "object",
            "properties": properties,
            "required": list(self.needed),
            "additionalProperties": False,
        }

    def read(self, what: str, value: object) -> dict[str, Any]:
        """See `Kind`."""
        if not isinstance(value, dict) or not set(self.needed) <= value.keys() <= self.entries.keys():
            raise OptionError(f"{what} is {shown(value)}: give {self.give}")
        return {name: self.entries[name].read(f"{what}.{name}", each) for name, each in value.items()}


@dataclass(frozen=True)
class Pose:
    """`world_from_tool`: a place and angles, or a matrix. Read as `(4, 4)`."""

    def schema(self) -> dict[str, Any]:
        """See `Kind`."""
        row = {"type": "array", "items": {"type": "number"}, "minItems": 4, "maxItems": 4}
        return {"anyOf": [_PLACE.schema(), {"type": "array", "items": row, "minItems": 4, "maxItems": 4}]}

    def read(self, what: str, value: object) -> Any:
        """See `Kind`."""
        if isinstance(value, dict):
            place = _PLACE.read(what, value)
            matrix = np.eye(4)
            matrix[:3, 3] = place["at_m"]
            matrix[:3, :3] = rotation_xyz(*place.get("rotate_deg", (0.0, 0.0, 0.0)))
            return matrix
        if not isinstance(value, list) or len(value) != 4 or any(not isinstance(r, list) or len(r) != 4 for r in value):
            raise PoseError(f"{what} is {shown(value)}: give {_POSE}")
        for number in (number for row in value for number in row):
            check_number(
                what,
                number,
                f"a matrix of numbers from {-FARTHEST_M:g} to {FARTHEST_M:g}",
                least=-FARTHEST_M,
                most=FARTHEST_M,
            )
        matrix = one_pose(value, what)
        try:
            placed(np.zeros((1, 3)), matrix, what)
        except PoseError:
            raise PoseError(
                f"{what} is not rigid: give a rotation without scale, shear or mirror, with seven digits or more; "
                "at_m and rotate_deg always give one"
            ) from None
        return matrix


_POSE = (
    '{"at_m": [x, y, z], "rotate_deg": [rx, ry, rz]} (about the mock-up\'s x, then y, then z axis), or a 4 by 4 matrix '
    "world_from_tool, row by row, metres"
)
_NAME = Text("the path or name of a part, its number such as #12, or a pattern such as *pump*")
_PATTERNS = Many(_NAME, "a name or pattern, or a list of them")
_PLACE = Record(
    {"at_m": Triple("three coordinates in metres"), "rotate_deg": Triple("three angles in degrees")}, ["at_m"], _POSE
)
