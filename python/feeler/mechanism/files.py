"""Mechanisms as TOML files."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from feeler.atomic import atomic_file
from feeler.errors import FeelerError, LoadError
from feeler.io.text import text_of
from feeler.io.toml import check_version, quoted, toml_of
from feeler.mechanism.coupling import JointCoupling
from feeler.mechanism.joint import Joint, JointKind
from feeler.mockup import Mockup
from feeler.parts import Part, PartsLike

_TABLES = ("joint", "coupling", "loop")
_IGNORE, _VERSION = "ignore", "version"
_LIMITS = {"limits_deg": math.radians(1.0), "limits_rad": 1.0, "limits_m": 1.0}
_SLIDES = ("slide_limits_m",)
_KEYS = {"point": "point_m", "pitch": "pitch_m", "slide_limits": "slide_limits_m"}
"""The keys of what errors of joints begin with, where they differ."""
_JOINT = ("name", "kind", "parent", "child", "axis", "point_m", "pitch_m", "because", *_LIMITS, *_SLIDES)
_COUPLING = ("joint", "of", "ratio", "offset_deg", "offset_rad", "offset_m")


class Drawn(NamedTuple):
    """What a file of joints holds."""

    joints: Sequence[Joint]
    couplings: Sequence[JointCoupling]
    loops: Sequence[Joint]
    ignore: Sequence[tuple[PartsLike, PartsLike]] = ()
    """Pairs of parts that no question looks at."""


def read(path: Path, mockup: Mockup | None = None) -> Drawn:
    """The joints, couplings, loops and ignored pairs of a file, of parts of a mock-up; None: they are not looked up.

    Raises `LoadError`, naming the line.
    """
    data = toml_of(path, "write one with Mechanism.save, or feeler move --write-mechanism")
    lines = _Lines(path, text_of(path))
    check_version(data, lines.of(_VERSION) if _VERSION in data else str(path))
    data.pop(_VERSION, None)
    ignore = _ignored(data.pop(_IGNORE, []), lines, mockup)
    for key in data:
        if key not in _TABLES:
            raise LoadError(
                f"{lines.of(key)}: {key!r} is unknown: there are [[joint]], [[coupling]], [[loop]] and ignore"
            )
        if not isinstance(data[key], list) or not all(isinstance(each, dict) for each in data[key]):
            raise LoadError(f"{lines.of(key)}: {key!r} is no list of tables: begin each with [[{key}]]")
    joints = [_joint(table, lines.table("joint", n), mockup) for n, table in enumerate(data.get("joint", []))]
    couplings = [_coupling(table, lines.table("coupling", n)) for n, table in enumerate(data.get("coupling", []))]
    loops = [_joint(table, lines.table("loop", n), mockup) for n, table in enumerate(data.get("loop", []))]
    if not joints:
        raise LoadError(f"{path}: there is no [[joint]]")
    return Drawn(joints, couplings, loops, ignore)


def _ignored(rows: object, lines: _Lines, mockup: Mockup | None) -> list[tuple[PartsLike, PartsLike]]:
    """The pairs of parts of the key `ignore`, which stands before the tables."""
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        raise LoadError(f'{lines.of(_IGNORE)}: ignore is no list of pairs of parts, such as [["pin*", "bracket"]]')
    for row in rows:
        for parts in row:
            if mockup is not None:
                _check_parts(parts, _IGNORE, lines, mockup)
    return [(row[0], row[1]) for row in rows]


class _Lines:
    """Where things are in a file."""

    def __init__(self, path: Path, text: str, first: int = 0, last: int | None = None) -> None:
        self.path, self.text = path, text
        self._lines = text.splitlines()
        self.first, self.last = first, len(self._lines) if last is None else last

    def of(self, key: str) -> str:
        """The file and line of a key."""
        said = re.compile(rf"""\s*(?:\[\[?\s*)?["']?{re.escape(key)}["']?\s*(?:[=.\]]|$)""")
        for number in range(self.first, self.last):
            if said.match(self._lines[number]):
                return f"{self.path}, line {number + 1}"
        return self.here()

    def here(self) -> str:
        """The file and line of the table."""
        return f"{self.path}, line {self.first + 1}" if self.first or self._lines else str(self.path)

    def table(self, name: str, number: int) -> _Lines:
        """Those of one table."""
        starts = [n for n, line in enumerate(self._lines) if re.match(rf"\s*\[\[\s*{name}\s*\]\]", line)]
        if number >= len(starts):
            return self
        begins = [n for n, line in enumerate(self._lines) if re.match(r"\s*\[", line)]
        later = [n for n in begins if n > starts[number]]
        return _Lines(self.path, self.text, starts[number], later[0] if later else len(self._lines))


def _check(table: dict[str, Any], known: Sequence[str], needed: Sequence[str], lines: _Lines) -> None:
    for key in table:
        if key not in known:
            hint = f"known are {', '.join(known)}"
            before = dict.fromkeys((_IGNORE, _VERSION), "it stands before all tables")
            hint = {"limits": "say limits_deg, limits_rad or limits_m", **before}.get(key, hint)
            raise LoadError(f"{lines.of(key)}: {key!r} is unknown here: {hint}")
    for key in needed:
        if key not in table:
            raise LoadError(f"{lines.here()}: {key!r} is missing")


def _joint(table: dict[str, Any], lines: _Lines, mockup: Mockup | None) -> Joint:
    _check(table, _JOINT, ("name", "kind", "child"), lines)
    for side in ("child", "parent"):
        if mockup is not None and table.get(side) not in (None, ""):
            _check_parts(table[side], side, lines, mockup)
    kind = table["kind"]
    said = [key for key in _LIMITS if key in table]
    if len(said) > 1:
        raise LoadError(f"{lines.of(said[1])}: limits are said twice, as {' and '.join(said)}")
    limits = None
    for key in said:
        if (key == "limits_m") != (kind == "prismatic"):
            right = "limits_m" if kind == "prismatic" else "limits_deg or limits_rad"
            raise LoadError(f"{lines.of(key)}: a {kind} joint has no {key}: say {right}")
        low, high = _pair(table[key], key, lines)
        limits = (_LIMITS[key] * low, _LIMITS[key] * high)
    slide = _pair(table["slide_limits_m"], "slide_limits_m", lines) if "slide_limits_m" in table else None
    parent = table.get("parent")
    try:
        return Joint(
            table["name"],
            kind,
            None if parent in (None, "") else parent,
            table["child"],
            table.get("axis", (0.0, 0.0, 1.0)),
            table.get("point_m", (0.0, 0.0, 0.0)),
            limits,
            table.get("pitch_m", 0.0),
            table.get("because", ""),
            slide,
        )
    except FeelerError as error:
        said_of = {"limits": said[0] if said else "limits", **_KEYS}
        word = str(error).split()[0]
        raise LoadError(f"{lines.of(said_of.get(word, word))}: {error}") from None


def _check_parts(value: object, side: str, lines: _Lines, mockup: Mockup) -> None:
    try:
        chosen = mockup.parts.select(value)  # type: ignore[arg-type]
    except FeelerError as error:
        raise LoadError(f"{lines.of(side)}: {side}: {error}") from None
    if not len(chosen):
        raise LoadError(f"{lines.of(side)}: {side} names no part: give one at least")


def _coupling(table: dict[str, Any], lines: _Lines) -> JointCoupling:
    _check(table, _COUPLING, ("joint", "of", "ratio"), lines)
    said = [key for key in _COUPLING[3:] if key in table]
    if len(said) > 1:
        raise LoadError(f"{lines.of(said[1])}: the offset is said twice, as {' and '.join(said)}")
    try:
        offset = table[said[0]] if said else 0.0
        made = JointCoupling(table["joint"], table["of"], table["ratio"], offset)
    except FeelerError as error:
        raise LoadError(f"{lines.here()}: {error}") from None
    if said == ["offset_deg"]:
        return JointCoupling(made.joint, made.of, made.ratio, math.radians(made.offset))
    return made


def _pair(value: object, key: str, lines: _Lines) -> tuple[float, float]:
    """The least and the greatest value of a key."""
    is_list = isinstance(value, list) and len(value) == 2
    if not is_list or not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in value):  # type: ignore[attr-defined]
        raise LoadError(f"{lines.of(key)}: {key} is no pair of numbers: say {key} = [0, 1]")
    if not all(math.isfinite(each) for each in value):  # type: ignore[attr-defined]
        raise LoadError(f"{lines.of(key)}: {key} is {value}: give finite numbers")
    low, high = (float(each) for each in value)  # type: ignore[attr-defined]
    if low > high:
        raise LoadError(f"{lines.of(key)}: {key} is {value}: give the least value first")
    return low, high


def write(path: Path, mockup: Mockup, drawn: Drawn) -> None:
    """Writes a file. Raises `WriteError`."""
    joints, couplings, loops, ignore = drawn
    lines = ["# A mechanism of feeler: lengths in metres, world, where the parts are modelled.", ""]
    if ignore:
        pairs = [f"    [{_parts(mockup, one)}, {_parts(mockup, other)}]," for one, other in ignore]
        lines += ["# Pairs of parts that no question looks at.", "ignore = [", *pairs, "]", ""]
    for table, rows in (("joint", joints), ("loop", loops)):
        for joint in rows:
            lines += [f"[[{table}]]", *_lines_of(mockup, joint), ""]
    for each in couplings:
        lines += ["[[coupling]]", f"joint = {quoted(each.joint)}", f"of = {quoted(each.of)}", f"ratio = {each.ratio!r}"]
        is_turn = any(
            name == each.joint and turns for j in joints for name, turns in zip(j.names, j.turns, strict=True)
        )
        lines += [f"offset_{'rad' if is_turn else 'm'} = {each.offset!r}"] if each.offset else []
        lines += [""]
    with atomic_file(path, ".toml") as file:
        file.write("\n".join(lines).encode())


def _lines_of(mockup: Mockup, joint: Joint) -> list[str]:
    lines = [f"name = {quoted(joint.name)}", f"kind = {quoted(str(joint.kind))}"]
    if joint.parent is not None:
        lines.append(f"parent = {_parts(mockup, joint.parent)}")
    lines.append(f"child = {_parts(mockup, joint.child)}")
    if joint.kind is not JointKind.FIXED:
        lines += [f"axis = {list(joint.axis)}", f"point_m = {list(joint.point)}"]
    if joint.limits is not None:
        unit = "m" if joint.kind is JointKind.PRISMATIC else "rad"
        lines.append(f"limits_{unit} = {list(joint.limits)}")
    if joint.slide_limits is not None:
        lines.append(f"slide_limits_m = {list(joint.slide_limits)}")
    if joint.pitch:
        lines.append(f"pitch_m = {joint.pitch!r}")
    if joint.because:
        lines.append(f"because = {quoted(joint.because)}")
    return lines


def _parts(mockup: Mockup, parts: PartsLike) -> str:
    if isinstance(parts, str):
        return quoted(parts)
    if isinstance(parts, Part):
        return quoted(parts.path)
    if isinstance(parts, (int, np.integer)):
        return str(int(parts))
    return f"[{', '.join(_parts(mockup, each) for each in parts)}]"
