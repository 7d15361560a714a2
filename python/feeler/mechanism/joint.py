"""Joints of mechanisms: how one part moves against another."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_number, check_text, check_word, mask_of, shown
from feeler.choices import JointKindName
from feeler.enumerations import CodedEnum
from feeler.errors import OptionError
from feeler.field_docs import documented
from feeler.parts import Part, PartsLike

_SHORTEST_AXIS = 1e-9  # shorter ones are zero but for rounding
_UNIT = 2e-15  # axes whose square is this near 1 are kept as they are, so that files give them back
_ORIGIN = (0.0, 0.0, 0.0)
_LAST = [0.0, 0.0, 0.0, 1.0]
Row = tuple[list[float], list[float], float, float, float]

Vector = tuple[float, float, float]


class JointKind(CodedEnum):
    """How the child of a joint moves against its parent."""

    REVOLUTE = "revolute"
    """It turns about the axis: one number, radians."""
    PRISMATIC = "prismatic"
    """It slides along the axis: one number, metres."""
    SCREW = "screw"
    """It turns about the axis and advances `pitch` metres a turn along it: one number, radians."""
    CYLINDRICAL = "cylindrical"
    """It turns about the axis and slides along it: two numbers, radians and metres."""
    FIXED = "fixed"
    """It is fastened to the parent: no number."""


@documented
@dataclass(frozen=True)
class Joint:
    """A joint between two links of a mechanism, in the world, at the zero position (where the parts are modelled).

    name: how positions call it; no `.`, which separates the two numbers of a cylindrical joint (`name.turn`,
    `name.slide`). kind: see `JointKind`, or its word.
    parent and child: parts, as `Parts.select` takes them; a parent of None is the frame, what does not move.
    axis: a direction; kept with length one. A positive angle turns about it by the right-hand rule.
    point: any point of the axis, metres. limits: least and greatest value, radians of a revolute, screw or cylindrical
    joint and metres of a prismatic one; None for none. slide_limits: those of a cylindrical joint along its axis.
    pitch: metres a turn of a screw, negative for a left-hand thread. because: a sentence, why the joint is believed.
    Raises `OptionError` for axes of length zero, crossed limits and numbers that are not finite.
    """

    name: str
    kind: JointKind
    parent: PartsLike | None
    child: PartsLike
    axis: Vector = (0.0, 0.0, 1.0)
    point: Vector = _ORIGIN
    limits: tuple[float, float] | None = None
    pitch: float = 0.0
    because: str = ""
    slide_limits: tuple[float, float] | None = None

    if TYPE_CHECKING:  # it takes more than its fields become

        def __init__(
            self,
            name: str,
            kind: JointKind | JointKindName,
            parent: PartsLike | None,
            child: PartsLike,
            axis: npt.ArrayLike = (0.0, 0.0, 1.0),
            point: npt.ArrayLike = _ORIGIN,
            limits: Sequence[float] | None = None,
            pitch: float = 0.0,
            because: str = "",
            slide_limits: Sequence[float] | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        put = object.__setattr__
        check_text("name", self.name, "the name of a joint")
        if not self.name.strip() or "." in self.name or "=" in self.name:
            raise OptionError(f"a joint is called {self.name!r}: give a name without '.' and '='")
        where = f"joint {self.name!r}"
        put(self, "kind", _kind(f"kind of {where}", self.kind))
        put(self, "parent", None if self.parent is None else _kept(self.parent))
        put(self, "child", _kept(self.child))
        put(self, "axis", _unit(f"axis of {where}", self.axis))
        put(self, "point", _vector(f"point of {where}", self.point))
        put(self, "limits", _limits(f"limits of {where}", self.limits))
        put(self, "slide_limits", _limits(f"slide_limits of {where}", self.slide_limits))
        put(self, "pitch", check_number(f"pitch of {where}", self.pitch, "metres a turn"))
        put(self, "because", check_text(f"because of {where}", self.because, "a sentence"))
        if self.kind is JointKind.SCREW and self.pitch == 0.0:
            raise OptionError(f"{where} is a screw without pitch: give metres a turn, or kind='revolute'")
        if self.kind is not JointKind.SCREW and self.pitch != 0.0:
            raise OptionError(f"{where} has a pitch, but is {self.kind}: only a screw has one")
        if self.kind is JointKind.FIXED and self.limits is not None:
            raise OptionError(f"{where} is fixed and has limits: leave them out")
        if self.kind is not JointKind.CYLINDRICAL and self.slide_limits is not None:
            raise OptionError(f"{where} has slide_limits, but is {self.kind}: only a cylindrical joint has them")

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its numbers in positions: its own; two for a cylindrical joint; none for a fixed one."""
        if self.kind is JointKind.FIXED:
            return ()
        if self.kind is JointKind.CYLINDRICAL:
            return (f"{self.name}.turn", f"{self.name}.slide")
        return (self.name,)

    @property
    def turns(self) -> tuple[bool, ...]:
        """Whether each number is an angle, in radians, instead of a length."""
        if self.kind is JointKind.CYLINDRICAL:
            return (True, False)
        return (self.kind is not JointKind.PRISMATIC,) * len(self.names)

    def pose(self, *values: float) -> npt.NDArray[np.float64]:
        """The motion of the child, `(4, 4)`, in the world at the zero position, at the values of its numbers."""
        if len(values) != len(self.names):
            raise OptionError(f"joint {self.name!r} is {self.kind}: give {len(self.names)} numbers, not {len(values)}")
        given = (
            check_number(f"joint {self.name!r}", value, "radians" if is_angle else "metres")
            for value, is_angle in zip(values, self.turns, strict=True)
        )
        return self._moved_by(*given)

    def _moved_by(self, *values: float) -> npt.NDArray[np.float64]:
        """The same of numbers that were checked: as many finite ones as it has names."""
        angle = slide = 0.0
        if self.kind is JointKind.CYLINDRICAL:
            angle, slide = values
        elif self.kind is JointKind.PRISMATIC:
            (slide,) = values
        elif self.kind is not JointKind.FIXED:
            (angle,) = values
            slide = self.pitch * angle / math.tau
        return screw_pose(self.axis, self.point, angle, slide)


def screw_pose(axis: Vector, point: Vector, angle: float, slide: float) -> npt.NDArray[np.float64]:
    """A turn about an axis of length one through a point, and a slide along it, `(4, 4)`."""
    half = math.sin(angle / 2.0)
    sine, more = math.sin(angle), 2.0 * half * half
    # in plain numbers: loops ask for thousands, and arrays of three take longer
    found = [
        [sine * c + more * t, sine * c1 + more * t1, sine * c2 + more * t2, slide * way - sine * cf - more * tf]
        for (c, c1, c2), (t, t1, t2), way, cf, tf in _frame(axis, point)
    ]
    for number, row in enumerate(found):
        row[number] += 1.0
    return np.array([*found, _LAST])


@lru_cache(maxsize=4096)
def _frame(axis: Vector, point: Vector) -> tuple[Row, ...]:
    """What poses about an axis are made of, by row: the matrix of its cross product and the square of that, its
    direction, and both matrices of the point."""
    x, y, z = axis
    foot = np.array(point)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    twice = cross @ cross
    feet = (cross @ foot).tolist(), (twice @ foot).tolist()
    return tuple(zip(cross.tolist(), twice.tolist(), axis, *feet, strict=True))


def _kind(what: str, value: object) -> JointKind:
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
        return JointKind(value)
    return check_word(what, value, JointKind)


def _kept(parts: PartsLike) -> PartsLike:
    """Parts as a joint keeps them: what can change is copied."""
    if isinstance(parts, (str, int, np.integer, Part)) or not isinstance(parts, Iterable):
        return parts
    if isinstance(parts, (bytes, bytearray)) or (isinstance(parts, np.ndarray) and parts.ndim != 1):
        raise OptionError(f"{shown(parts)} names no part: give an index, a path or pattern, or several")
    mask = mask_of(parts)
    if mask is not None:
        return tuple(int(i) for i in np.flatnonzero(mask))
    return tuple(int(each) if isinstance(each, np.integer) else each for each in parts)


def _vector(what: str, value: npt.ArrayLike) -> Vector:
    x, y, z = check_array(what, value, (3,)).astype(np.float64)
    return (float(x), float(y), float(z))


def _unit(what: str, value: npt.ArrayLike) -> Vector:
    given = np.array(_vector(what, value))
    largest = float(np.abs(given).max())
    if largest < _SHORTEST_AXIS:
        raise OptionError(f"{what} is {shown(value)}, of length zero: give a direction, such as (0, 0, 1)")
    if abs(float(given @ given) - 1.0) > _UNIT:
        given /= largest
        given /= np.linalg.norm(given)
    x, y, z = given
    return (float(x), float(y), float(z))


def _limits(what: str, value: tuple[float, float] | None) -> tuple[float, float] | None:
    if value is None:
        return None
    lower, upper = (float(each) for each in check_array(what, value, (2,)))
    if lower > upper:
        raise OptionError(f"{what} are {shown(value)}, which cross: give the least and the greatest value")
    return (lower, upper)
