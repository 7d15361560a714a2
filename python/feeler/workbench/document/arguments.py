"""Arguments of commands, questions and jobs, from a page or a script, checked."""

from __future__ import annotations

import math
import types
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from feeler._core import Cast, Collision
from feeler.arguments import mask_of, near
from feeler.errors import OptionError, PoseError, WorkbenchError
from feeler.parts import Part, Parts, PartsLike
from feeler.poses import PoseLike, one_pose
from feeler.workbench.document import motion
from feeler.workbench.document.document import Point
from feeler.workbench.document.protocol import Pose, Selection, Vec3
from feeler.workbench.document.values import LARGEST, is_number, is_sequence

_MOST_TEXT = 10_000

Item = TypeVar("Item")


@dataclass(frozen=True)
class Maybe:
    """Marks the type of an argument that may be absent."""

    type: Any


VectorLike: TypeAlias = Sequence[float] | npt.NDArray[np.floating[Any]] | npt.NDArray[np.integer[Any]]
"""Three numbers."""
VectorsLike: TypeAlias = Sequence[VectorLike] | npt.NDArray[np.floating[Any]] | npt.NDArray[np.integer[Any]]
"""Rows of three numbers, `(n, 3)`."""
IndicesLike: TypeAlias = Sequence[int] | npt.NDArray[np.integer[Any]]
"""Whole numbers, `(n,)`."""


def plain_parts(parts: PartsLike | None) -> object:
    """Parts as the page sends them: a path, a pattern, an index, or a list of these. None stays."""
    if isinstance(parts, Part):
        return parts.index
    if isinstance(parts, (Collision, Cast)):  # what `View.show` took in early builds
        raise WorkbenchError("an answer of the scene names no part", "show", "call show_hit(hit)")
    mask = mask_of(parts)
    if mask is not None:
        return np.flatnonzero(mask).tolist()
    if isinstance(parts, np.ndarray):
        return parts.tolist()
    if isinstance(parts, np.integer):
        return int(parts)
    if parts is None or isinstance(parts, (str, int)) or not isinstance(parts, Iterable):
        return parts
    return [plain_parts(each) for each in parts]


def plain_numbers(numbers: object) -> object:
    """Vectors or indices as the page sends them: lists. A value that is neither stays, for the command to refuse."""
    if isinstance(numbers, (np.ndarray, np.generic)):
        return numbers.tolist()
    return [plain_numbers(each) for each in numbers] if isinstance(numbers, (list, tuple)) else numbers


def plain_pose(pose: Pose | PoseLike) -> object:
    """A pose as the page sends it: 16 numbers. A value that is no pose stays, for the command to refuse."""
    if motion.is_row(pose):
        return np.asarray(pose).tolist()
    try:
        return list(motion.row(one_pose(cast("PoseLike", pose))))
    except PoseError:
        return pose


Shape = Mapping[str, Any]
"""The arguments by name, and their types, as in `protocol.py`, from which the page's types are generated."""


class Arguments:
    """The arguments of a command. Every access checks, and errors name the argument."""

    def __init__(self, command: str, given: Any, shape: Shape) -> None:
        """Raises `WorkbenchError` for values that are not objects, and for names unknown to the command."""
        self.command, self._shape = command, shape
        if not isinstance(given, Mapping):
            raise WorkbenchError("the arguments are not an object", command, "send names with their values")
        self._given: Mapping[str, Any] = given
        expected = list(shape)
        for name in given:
            if name not in expected:
                raise WorkbenchError(
                    f"there is no argument {name!r}", command, near(name, expected, "it takes no arguments")
                )

    def fail(self, name: str, what: str, do: str) -> WorkbenchError:
        """An error of an argument, to raise."""
        return WorkbenchError(what, f"{self.command}, {name}", do)

    def has(self, name: str) -> bool:
        """Whether it is present, and not null."""
        return self._given.get(name) is not None

    def raw(self, name: str, kind: Any) -> Any:
        """The raw value, None if absent. kind: its type, which must match the shape.

        Raises `TypeError` if a command reads an argument that its row in the table lacks: the page would not send it.
        """
        declared = _bare(self._shape[name])
        if declared != kind:
            raise TypeError(f"{self.command} reads {name} as {kind}, and the table says {declared}")
        return self._given.get(name)

    def inner(self, name: str, kind: type) -> Arguments:
        """An object, of a `TypedDict`, as arguments of its own."""
        return Arguments(f"{self.command}, {name}", self.raw(name, kind), get_type_hints(kind))

    def flag(self, name: str) -> bool:
        """True or false."""
        value = self.raw(name, bool)
        if not isinstance(value, bool):
            raise self.fail(name, f"{_shown(value)} is neither true nor false", "send true or false")
        return value

    def number(self, name: str, low: float = -LARGEST, high: float = LARGEST) -> float:
        """A finite number within bounds."""
        value: Any = self.raw(name, float)
        if not is_number(value) or not low <= value <= high:
            raise self.fail(name, f"{_shown(value)} is not a number from {low:g} to {high:g}", "send one that is")
        return float(value)

    def whole(self, name: str, low: int = 0, high: int = 2**53) -> int:
        """A whole number within bounds."""
        value = self.raw(name, int)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self.fail(name, f"{_shown(value)} is not a whole number from {low} to {high}", "send one that is")
        return value

    def text(self, name: str, most: int = _MOST_TEXT, *, may_be_empty: bool = False) -> str:
        """A text; `may_be_empty`: of a file, whose reader reports what is missing in it."""
        value = self.raw(name, str)
        if not isinstance(value, str) or not (value.strip() or may_be_empty) or len(value) > most:
            least = 0 if may_be_empty else 1
            raise self.fail(name, f"{_shown(value)} is not text, or too long", f"send {least} to {most} characters")
        if any("\ud800" <= each <= "\udfff" for each in value):
            raise self.fail(name, f"{_shown(value)} has half a character", "send characters that can be written")
        return value

    def choice(self, name: str, choices: Iterable[str]) -> str:
        """One of several words."""
        words = list(choices)
        # The page has lists of words that are known beforehand.
        is_listed = get_origin(_bare(self._shape[name])) is Literal
        value = self.raw(name, Literal[tuple(words)] if is_listed else str)
        if not isinstance(value, str) or value not in words:
            raise self.fail(name, f"there is no {_shown(value)}", near(value, words))
        return str(value)

    def point(self, name: str) -> Point:
        """Three numbers."""
        return self._triple(name, self.raw(name, Vec3))

    def points(self, name: str, least: int, most: int) -> tuple[Point, ...]:
        """Several points."""
        value: Any = self.raw(name, list[Vec3])
        if not is_sequence(value) or not least <= len(value) <= most:
            count = f"{least}" if least == most else f"{least} to {most}"
            raise self.fail(name, f"{_shown(value)} is not a list of {count} points", "send lists of three numbers")
        return tuple(self._triple(name, each) for each in value)

    def unit(self, name: str) -> Point:
        """A direction, normalised."""
        x, y, z = self.point(name)
        length = math.sqrt(x * x + y * y + z * z)
        if not 1e-12 < length < LARGEST:
            raise self.fail(name, f"{_shown([x, y, z])} has no direction", "send three numbers that are not all 0")
        return (x / length, y / length, z / length)

    def pose(self, name: str) -> motion.Row:
        """16 numbers of a rigid pose."""
        return motion.row(motion.checked(self.raw(name, Pose), f"{self.command}, {name}"))

    def parts(self, name: str, parts: Parts, most: int | None = None) -> tuple[int, ...]:
        """Parts by indices, paths or patterns: their indices, ascending. Errors list similar names."""
        value: Any = self.raw(name, Selection)
        if not isinstance(value, (int, str)) and not is_sequence(value):
            raise self.fail(name, f"{_shown(value)} names no part", "send indices, paths or patterns")
        try:
            found = tuple(parts.select(value).tolist())
        except OptionError as error:
            raise self.fail(name, str(error), "send an index, a path or a pattern of a part that is there") from None
        if not found or (most is not None and len(found) > most):
            raise self.fail(name, f"{len(found)} parts are named", f"name {'one' if most == 1 else 'one at least'}")
        return found

    def place_of(self, items: Sequence[Any], name: str = "id") -> int:
        """The position in a list of the item with a given number."""
        wanted = self.whole(name)
        for place, item in enumerate(items):
            if item.id == wanted:
                return place
        there = ", ".join(str(item.id) for item in items[:20])
        raise self.fail(name, f"there is no {wanted}", f"there is {there}" if there else "there is none at all")

    def _triple(self, name: str, value: Any) -> Point:
        value = value.tolist() if isinstance(value, np.ndarray) else value
        if not is_sequence(value) or len(value) != 3 or not all(is_number(each) for each in value):
            raise self.fail(name, f"{_shown(value)} is not three numbers", "send x, y and z")
        x, y, z = (float(each) for each in value)
        return (x, y, z)


def _bare(kind: Any) -> Any:
    """A type without its markers for absent and null."""
    inside = kind.type if isinstance(kind, Maybe) else kind
    if get_origin(inside) in (Union, types.UnionType):
        some = [each for each in get_args(inside) if each is not type(None)]
        return some[0] if len(some) == 1 else inside
    return inside


def replaced(items: tuple[Item, ...], place: int, item: Item) -> tuple[Item, ...]:
    """The items, with one replaced."""
    return (*items[:place], item, *items[place + 1 :])


def without(items: tuple[Item, ...], place: int) -> tuple[Item, ...]:
    """The items without one."""
    return (*items[:place], *items[place + 1 :])


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."
