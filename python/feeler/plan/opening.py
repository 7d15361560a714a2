"""`opening`: the largest ball, cylinder and box that go through at a place along an axis; limits for hands and arms."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_flag, check_kind, check_list, check_number, check_path, near, shown
from feeler.atomic import atomic_file
from feeler.choices import OPENING_SHAPES, OpeningShape
from feeler.errors import LoadError, OptionError
from feeler.field_docs import documented
from feeler.io.toml import toml_of
from feeler.mockup import Tool
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ERROR_M = 1e-4
"""What is said to go through does; what is larger by this does not, metres."""
REACH_M = 0.05
"""How far before and behind the place a probe moves, metres."""
MOST_M = 1.0
"""The largest probe, metres: openings beyond it are endless."""
TURNS = 36
"""Turns of a box that are tried first."""
MOST_TURNS = 1_000
"""The most turns at which a larger box is ruled out afterwards."""
FINE = 0.25
"""The share of the error to which sizes of boxes at different turns are known, and that the turn may cost."""
CENTRING = 8
"""Directions across the axis in which a wider place is sought."""
_THIN = 1e-9  # the width of a triangle that stands for a line, metres
_ROUNDING = 1e-12  # of sizes, metres: a body exactly as wide as the limit goes through


@documented
@dataclass(frozen=True)
class OpeningLimit:
    """The least opening for a hand, an arm or a tool."""

    name: str
    """What it is called in the table."""
    shape: OpeningShape
    """"ball", "cylinder" or "box"."""
    width: float
    """Its diameter, or the width of the box, metres."""
    height: float
    """The height of the box, metres; 0 for others."""
    source: str
    """Where the number comes from, such as a standard and its table."""


@documented
@dataclass(frozen=True)
class OpeningFit:
    """Whether an opening is large enough for a limit; true if it is."""

    limit: OpeningLimit
    is_through: bool
    """Whether what the limit asks for goes through."""
    largest: float
    """The largest width or diameter of this shape that goes through, metres; of a box with its proportions."""

    def __bool__(self) -> bool:
        return self.is_through


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Opening:
    """What goes through at a place along an axis, metres; infinite beyond `most`, 0 if nothing does."""

    at: Floats
    """`(3,)`: the place, world."""
    axis: Floats
    """`(3,)`, unit, world."""
    ball: float
    """Diameter of the largest ball whose centre moves along the axis."""
    cylinder: float
    """Diameter of the largest cylinder along the axis."""
    width: float
    """Of the largest box along the axis of the proportions that were asked for."""
    height: float
    """Of that box, metres."""
    turn_deg: float
    """The turn of the box about the axis: from the direction `across`."""
    across: Floats
    """`(3,)`, unit, world: the direction of the box's width."""
    stopped_by: tuple[tuple[str, str], ...]
    """Of "ball", "cylinder" and "box", the path of a part that stops a larger one."""
    fits: tuple[OpeningFit, ...]
    """One for each limit."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them; None for what is infinite."""
        row = {name: value for name, value in vars(self).items() if name not in ("at", "axis", "across", "fits")}
        row |= {name: getattr(self, name).tolist() for name in ("at", "axis", "across")}
        row |= {name: _finite(row[name]) for name in ("ball", "cylinder", "width", "height")}
        row["stopped_by"] = dict(self.stopped_by)
        return {**row, "fits": [{**asdict(each), "largest": _finite(each.largest)} for each in self.fits]}


def _finite(size: float) -> float | None:
    return size if math.isfinite(size) else None


def opening(
    scene: Scene,
    at: npt.ArrayLike,
    axis: npt.ArrayLike,
    *,
    aspect: float = 1.0,
    across: npt.ArrayLike | None = None,
    reach: float = REACH_M,
    centre: bool = False,
    error: float = ERROR_M,
    most: float = MOST_M,
    limits: Sequence[OpeningLimit] = (),
) -> Opening:
    """The largest ball, cylinder and box that go through at `at` `(3,)`, metres, along `axis` `(3,)`.

    Each moves with its middle on the axis, from `reach` metres before the place to `reach` behind it, and is cast. What
    is said to go through does, and what is larger by `error` does not. The size of the ball is exact, from the distance
    of its path.

    - `aspect`: height by width of the box, 0.01 to 100.
    - `across`: the direction of the box's width; None: the best turn. That of a box of which many turns are about
      as good, such as a slender one in a round hole, may be missed after 1,000 turns.
    - `centre`: moves the place across the axis first, to where a larger ball goes through, step by step uphill.
    - `most`: sizes beyond it, metres, count as infinite.
    - `limits`: as `opening_limits` reads them; `Opening.fits` says which go through.

    Raises `OptionError` for an invalid place or direction, and numbers out of range.
    """
    check_kind("scene", scene, Scene)
    place, along = check_array("at", at, (3,)), _direction("axis", axis)
    shape = check_number("aspect", aspect, "a number from 0.01 to 100", least=0.01, most=100.0)
    half = check_number("reach", reach, "metres, above 0 up to 100", above=0.0, most=100.0)
    fine = check_number("error", error, "metres, from 0.000001 to 0.1", least=1e-6, most=0.1)
    far = check_number("most", most, "metres, above the error up to 100", above=fine, most=100.0)
    wanted = [check_kind("limits", each, OpeningLimit) for each in check_list("limits", limits, "feeler.OpeningLimit")]
    side = None if across is None else _across(along, _direction("across", across))
    if check_flag("centre", centre):
        place = _centred(scene, place, along, half, fine, far)
    passage = _Passage(scene, place, along, half, fine, far)
    ball, ball_by = passage.ball()
    cylinder, cylinder_by = passage.cylinder(ball)
    box, turn, box_by = passage.box(shape, side, ball)
    first = passage.first_side if side is None else side
    fits = [_fit(passage, limit, ball, cylinder, side) for limit in wanted]
    stops = (("ball", ball_by), ("cylinder", cylinder_by), ("box", box_by))
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    return Opening(
        at=place,
        axis=along,
        ball=ball,
        cylinder=cylinder,
        width=box,
        height=shape * box,
        turn_deg=turn,
        across=c * first + s * np.cross(along, first),
        stopped_by=tuple((name, scene.mockup.part_paths[part]) for name, part in stops if part is not None),
        fits=tuple(fits),
    )


def _fit(passage: _Passage, limit: OpeningLimit, ball: float, cylinder: float, side: Floats | None) -> OpeningFit:
    if limit.shape == "box":
        largest = passage.box(limit.height / limit.width, side, ball)[0]
    else:
        largest = ball if limit.shape == "ball" else cylinder
    return OpeningFit(limit, largest >= limit.width - _ROUNDING, largest)


class _Passage:
    """A place and an axis, through which probes are cast."""

    def __init__(self, scene: Scene, place: Floats, along: Floats, reach: float, error: float, most: float) -> None:
        self._scene, self._place, self._along, self._reach = scene, place, along, reach
        self._error, self._most = error, most
        self.first_side = _any_across(along)
        self._inside = _inside_of(scene, place, along, reach)

    def ball(self) -> tuple[float, int | None]:
        """Its diameter, and the part that stops a larger one."""
        if self._inside is not None:
            return 0.0, self._inside
        return _ball(self._scene, self._place, self._along, self._reach, self._most)

    def cylinder(self, ball: float) -> tuple[float, int | None]:
        """Its diameter, at least that of the ball, and the part that stops a larger one.

        Polygons around the circle are cast, which are larger by less than a tenth of the error.
        """

        def stopped(size: float) -> int | None:
            count = _sides_of(0.5 * size, self._error)
            turn = 2.0 * np.pi * np.arange(count) / count
            circle = np.column_stack([np.cos(turn), np.sin(turn)])
            # Where the ball goes through, the middle does.
            rings = [0.49 * ball * circle, 0.5 * size / math.cos(math.pi / count) * circle]
            return self._stopped(np.concatenate(rings), _band(count), 0.0)

        return self._largest(stopped, ball)

    def box(self, aspect: float, side: Floats | None, ball: float) -> tuple[float, float, int | None]:
        """Its width, its turn in degrees from a side, and the part that stops a larger one."""
        if ball == math.inf:
            return math.inf, 0.0, None
        corners = 0.5 * np.array([[-1.0, -aspect], [1.0, -aspect], [1.0, aspect], [-1.0, aspect]])
        known = ball / math.hypot(1.0, aspect)

        def largest(angle: float, least: float) -> tuple[float, int | None]:
            return self._largest(
                lambda width: self._stopped(width * corners, _SQUARE, angle), least, FINE * self._error
            )

        if side is not None:
            start = math.degrees(math.atan2(side @ np.cross(self._along, self.first_side), side @ self.first_side))
            size, part = largest(start, known)
            return size, 0.0, part
        whole = 90.0 if aspect == 1.0 else 180.0
        step = whole / TURNS
        best, turn = known, 0.0
        by: int | None = None
        turns = [step * k for k in range(TURNS)]
        slender = max(aspect, 1.0 / aspect)  # how much more width a small turn costs in a slit
        while best < math.inf:
            for angle in turns:
                size, part = largest(angle, best)
                if size > best or by is None:
                    best, turn, by = size, angle % whole, part
            if math.radians(step) * best * slender <= FINE * self._error:
                break
            step *= 0.5
            turns = [turn - step, turn + step]
        # A box that fits at one turn contains a smaller one of the same shape at any other turn. So if that smaller one
        # does not fit in the middle of a range of turns, no larger box than the best fits in the whole range.
        step, middles, tried = whole / TURNS, [whole / TURNS * k for k in range(TURNS)], 0
        while middles and best < math.inf and tried + len(middles) <= MOST_TURNS:
            tried, off, inner = tried + len(middles), math.radians(0.5 * step), list[float]()
            for angle in middles:
                least = (best + 2.0 * FINE * self._error) / (math.cos(off) + slender * math.sin(off))
                if self._stopped(least * corners, _SQUARE, angle) is not None:
                    continue  # so no turn within half a step has a larger one
                size, part = largest(angle, best)
                if size > best:
                    best, turn, by = size, angle % whole, part
                inner += [angle - 0.25 * step, angle + 0.25 * step]
            step, middles = 0.5 * step, inner
        return best, turn, by

    def _largest(
        self, stopped: Callable[[float], int | None], known: float, error: float | None = None
    ) -> tuple[float, int | None]:
        """The largest size that nothing stops, at least `known`, and what stops one that is larger by the error."""
        error = self._error if error is None else error
        if self._inside is not None or known >= self._most:
            return (0.0, self._inside) if self._inside is not None else (math.inf, None)
        low, step = known, error
        while (part := stopped(min(low + step, self._most))) is None:
            if low + step >= self._most:
                return math.inf, None
            low, step = low + step, 2.0 * step
        high = min(low + step, self._most)
        while high - low > error:
            middle = 0.5 * (low + high)
            met = stopped(middle)
            low, high, part = (middle, high, part) if met is None else (low, middle, met)
        return low, part

    def _stopped(self, outline: Floats, faces: Ints, turn: float) -> int | None:
        """The part that stops a flat outline (n, 2) on its way, turned by degrees; None if none does."""
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        x = c * self.first_side + s * np.cross(self._along, self.first_side)
        corners = outline[:, :1] * x + outline[:, 1:] * np.cross(self._along, x)
        pose = np.eye(4)
        pose[:3, 3] = self._place - self._reach * self._along
        end = pose.copy()
        end[:3, 3] += 2.0 * self._reach * self._along
        impact = self._scene.cast(Tool(corners, faces), pose, end, tolerance=min(1e-6, 0.1 * self._error))
        return None if impact is None else impact.part


_SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def _band(count: int) -> Ints:
    """Faces (2 count, 3) between two rings."""
    k = np.arange(count)
    after = (k + 1) % count
    return np.concatenate([np.stack([k, after, count + after], 1), np.stack([k, count + after, count + k], 1)])


def _ball(scene: Scene, place: Floats, along: Floats, reach: float, most: float) -> tuple[float, int | None]:
    """Twice the distance of its path.

    The triangle that stands for the path has a width, so the point that it is nearest to is taken, and its distance
    from the path itself.
    """
    near_by = scene.distance(_segment(along, reach), _at(place), within=0.5 * most)
    if near_by.part is None or near_by.point_on_mockup is None:
        return math.inf, None
    if near_by.value == 0.0:
        return 0.0, int(near_by.part)
    off = near_by.point_on_mockup - place
    distance = float(np.linalg.norm(off - np.clip(off @ along, -reach, reach) * along))
    return 2.0 * max(distance, near_by.value), int(near_by.part)


def _segment(along: Floats, reach: float) -> Tool:
    side = _THIN * _any_across(along)
    return Tool([-reach * along, reach * along, reach * along + side], [[0, 1, 2]])


def _inside_of(scene: Scene, place: Floats, along: Floats, reach: float) -> int | None:
    """The part in which the place is."""
    inside = scene.containment(_segment(along, reach), _at(place)).containing
    return int(inside[0]) if len(inside) else None


def _centred(scene: Scene, place: Floats, along: Floats, reach: float, error: float, most: float) -> Floats:
    """Goes across the axis to where the ball is larger, with shorter and shorter steps, at most `most` far."""
    x = _any_across(along)
    y = np.cross(along, x)
    start = place
    best = _ball(scene, place, along, reach, most)[0]
    # Within the ball nothing is in the way; at a rim, where it is smaller than the error, less is no step.
    step = max(0.5 * best, error) if 0.0 < best < math.inf else 0.05 * most
    while step > 0.1 * error and best < math.inf:
        turns = 2.0 * np.pi * np.arange(CENTRING) / CENTRING
        tried = [place + step * (math.cos(turn) * x + math.sin(turn) * y) for turn in turns]
        sizes = [_ball(scene, each, along, reach, most)[0] for each in tried]
        if max(sizes) > best and np.linalg.norm(place - start) <= most:
            best = max(sizes)
            place, step = tried[sizes.index(best)], max(step, min(0.5 * best, most))
        else:
            step *= 0.5
    return place


def _sides_of(radius: float, error: float) -> int:
    """Sides of a polygon that is within a tenth of the error of a circle."""
    return min(2000, max(24, math.ceil(math.pi / math.sqrt(0.2 * error / radius))))


def _direction(what: str, value: npt.ArrayLike) -> Floats:
    vector = check_array(what, value, (3,))
    length = float(np.linalg.norm(vector))
    if not 1e-12 < length < 1e12:
        raise OptionError(f"{what} is {shown(value)}: give a direction, such as [0, 0, 1]")
    return np.asarray(vector / length)


def _across(along: Floats, side: Floats) -> Floats:
    flat = side - (side @ along) * along
    length = float(np.linalg.norm(flat))
    if length < 1e-6:
        raise OptionError("across is along the axis: give another direction")
    return np.asarray(flat / length)


def _any_across(along: Floats) -> Floats:
    return _across(along, np.eye(3)[int(np.argmin(np.abs(along)))])


def _at(place: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def opening_limits(path: str | os.PathLike[str]) -> tuple[OpeningLimit, ...]:
    """The limits in a TOML file of the user's; `feeler opening --write-limits` writes a first one.

    Raises `LoadError`, naming the table, and `MissingFileError`.
    """
    file = check_path("path", path)
    data = toml_of(file, "feeler opening --write-limits FILE writes one")
    known = ("version", "limit")
    for key in data:
        if key not in known:
            raise LoadError(f"{file}: {shown(key)} is unknown: {near(key, known)}")
    if data.get("version") != 1:
        raise LoadError(f"{file}: version is {shown(data.get('version'))}: this feeler reads limits of version 1")
    tables = data.get("limit", [])
    if not isinstance(tables, list) or not all(isinstance(each, dict) for each in tables):
        raise LoadError(f"{file}: 'limit' is no list of tables: begin each with [[limit]]")
    if not tables:
        raise LoadError(f"{file}: there is no [[limit]]: fill in those of your standard")
    return tuple(_limit(table, f"{file}, [[limit]] {number}") for number, table in enumerate(tables, 1))


def _limit(table: dict[str, Any], where: str) -> OpeningLimit:
    known = ("name", "shape", "source", "diameter_mm", "width_mm", "height_mm")
    for key in table:
        if key not in known:
            raise LoadError(f"{where}: {shown(key)} is unknown: {near(key, known)}")
    name, shape, source = table.get("name"), table.get("shape"), table.get("source", "")
    if not isinstance(name, str) or not name or not isinstance(source, str):
        raise LoadError(f"{where}: name is {shown(name)}: give a text")
    if shape not in OPENING_SHAPES:
        raise LoadError(f"{where}: shape is {shown(shape)}: choose {', '.join(OPENING_SHAPES)}")
    sizes = ("width_mm", "height_mm") if shape == "box" else ("diameter_mm",)
    for key in ("diameter_mm", "width_mm", "height_mm"):
        if (key in table) != (key in sizes):
            raise LoadError(f"{where}: a {shape} has {' and '.join(sizes)}")
    values = []
    for key in sizes:
        value = table[key]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value <= 1e4:
            raise LoadError(f"{where}: {key} is {shown(value)}: give millimetres, above 0 up to 10,000")
        values.append(1e-3 * float(value))
    if shape == "box" and not 0.01 <= values[1] / values[0] <= 100.0:
        raise LoadError(f"{where}: height_mm is {shown(table['height_mm'])}: give 0.01 to 100 times the width")
    return OpeningLimit(name, shape, values[0], values[1] if shape == "box" else 0.0, source)


LIMITS_TEMPLATE = """\
# The least openings for hands, arms and tools: fill in the numbers of the standard that you work by.
#
# ISO 15534-2 (access openings) and MIL-STD-1472 (clearances for hands and arms) have such tables. Their texts are not
# part of feeler: type the numbers that apply to you, with gloves and clothes, and say where they come from.
#
#   shape        "box" with width_mm and height_mm; "cylinder" or "ball" with diameter_mm
#   source       the standard, its year, and the table
version = 1

# [[limit]]
# name = "flat hand, up to the wrist"
# shape = "box"
# width_mm =
# height_mm =
# source = "ISO 15534-2"
#
# [[limit]]
# name = "fist"
# shape = "cylinder"
# diameter_mm =
# source = "MIL-STD-1472"
#
# [[limit]]
# name = "forearm, with sleeve"
# shape = "cylinder"
# diameter_mm =
# source = "ISO 15534-2"
"""


def write_limits_template(path: str | os.PathLike[str]) -> None:
    """Writes a file to be filled in. Raises `WriteError`."""
    with atomic_file(check_path("path", path), ".toml") as file:
        file.write(LIMITS_TEMPLATE.encode())
