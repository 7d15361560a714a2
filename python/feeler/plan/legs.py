"""The legs of a way, and their description in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler._core import Screw
from feeler.field_docs import documented
from feeler.renamed import OldAttributes

STRAIGHT_RAD = 1e-6
"""A leg with a smaller rotation is straight."""
STILL_M = 1e-9
"""A leg whose middle moves less is a rotation in place."""
_UNITS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "um"))


@documented
@dataclass(frozen=True, eq=False)
class RemovalLeg(OldAttributes):
    """One leg of a way, from the end of the previous one; the first begins where the parts are."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"as_json": "to_dict"}

    screw: Screw | None
    """A rotation about a world axis with an advance along it, exact; None: a motion to `pose`, as in `Scene.cast`."""
    pose: npt.NDArray[np.float64]
    """`(4, 4)`: the motion of the parts in the world at its end."""
    path_length: float
    """The travel of the middle of the moving parts' box, metres."""
    rotation: float
    """The rotation, radians."""
    direction: tuple[float, float, float]
    """Unit, world: the direction of the motion; for a screw its axis, right-handed; zero without a translation."""

    def __str__(self) -> str:
        return leg_words(self, _length)

    def to_dict(self) -> dict[str, object]:
        """`{"screw": {...}}` or `{"to": pose}`, as `feeler remove --json` writes a leg and `feeler path` reads it."""
        if self.screw is None:
            return {"to": self.pose.tolist()}
        screw = self.screw
        return {
            "screw": {
                "axis": list(screw.axis),
                "point": list(screw.point),
                "angle": screw.angle,
                "pitch": screw.pitch,
            }
        }


def leg_words(leg: RemovalLeg, length: Callable[[float], str]) -> str:
    """A leg in words. length: of metres, in words."""
    along = _named(leg.direction)
    if leg.screw is not None and leg.screw.pitch:
        turns = leg.rotation / (2.0 * math.pi)
        return f"screw {turns:.3g} turns about {along}, {length(abs(leg.screw.advance))} along it"
    if leg.screw is not None:
        return f"turn {math.degrees(leg.rotation):.3g} degrees about {along}"
    if leg.rotation <= STRAIGHT_RAD:
        return f"move {length(leg.path_length)} along {along}"
    if leg.path_length <= STILL_M:
        return f"turn {math.degrees(leg.rotation):.3g} degrees in place"
    return f"move {length(leg.path_length)} and turn {math.degrees(leg.rotation):.3g} degrees"


def legs_of(
    answer: _core.RemovalAnswer, middle: npt.NDArray[np.float64], lies: npt.NDArray[np.float64]
) -> tuple[RemovalLeg, ...]:
    """The legs that the core found. middle: of the box of the moving parts, in their place; lies: their motion up to
    the start of the way."""
    legs: list[RemovalLeg] = []
    before = lies[:3, :3] @ middle + lies[:3, 3]
    lengths, angles = answer.leg_lengths.tolist(), answer.leg_angles.tolist()
    rows = zip(answer.leg_screws, answer.leg_ends, lengths, angles, strict=True)
    for screw, pose, length, angle in rows:
        here = pose[:3, :3] @ middle + pose[:3, 3]
        if screw is None:
            direction = _unit(here - before)
        else:
            direction = _unit(np.copysign(1.0, screw.angle) * np.array(screw.axis))
        legs.append(RemovalLeg(screw, np.array(pose), length, angle, direction))
        before = here
    return tuple(legs)


def path_of_json(legs: list[dict[str, Any]]) -> list[npt.NDArray[np.float64] | Screw]:
    """A path as `Scene.check_path` takes it, from legs as `RemovalLeg.to_dict` gives them.

    Raises `ValueError` for entries that are not legs, `OptionError` for numbers that do not define a screw.
    """
    path: list[npt.NDArray[np.float64] | Screw] = [np.eye(4)]
    for leg in legs:
        match leg:
            case {"to": pose}:
                path.append(np.asarray(pose, dtype=np.float64))
            case {"screw": {"axis": axis, "point": point, "angle": angle, "pitch": pitch}}:
                path.append(Screw(axis, point, angle, pitch))
            case _:
                raise ValueError('a leg is {"to": pose} or {"screw": {"axis", "point", "angle", "pitch"}}')
    return path


def _unit(vector: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    size = float(np.linalg.norm(vector))
    x, y, z = (vector / size if size > 0.0 else np.zeros(3)).tolist()
    return x, y, z


def _named(direction: tuple[float, float, float]) -> str:
    """A world axis by its name, where two decimals show no other direction; else these."""
    rounded = [round(number, 2) + 0.0 for number in direction]
    largest = max(range(3), key=lambda axis: abs(rounded[axis]))
    if sorted(map(abs, rounded)) == [0.0, 0.0, 1.0]:
        return ("-" if rounded[largest] < 0.0 else "+") + "xyz"[largest]
    return "({:.2f}, {:.2f}, {:.2f})".format(*rounded)


def _length(metres: float) -> str:
    size, name = next((unit for unit in _UNITS if metres >= unit[0]), _UNITS[-1])
    return f"{metres / size:.3g} {name}"
