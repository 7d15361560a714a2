"""The parts that the nightly run takes out: a list, or a table in a CSV file."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from feeler.arguments import check_path, check_whole, near, shown
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io.text import SEPARATOR_LINE, text_of
from feeler.parts import PartsLike
from feeler.scene import Scene
from feeler.tasks.planning import MOST_PEOPLE

MaintainParts: TypeAlias = str | os.PathLike[str] | Sequence[PartsLike | Mapping[str, Any]]
"""A CSV file, or a list of parts, each also as a dict of the columns."""
COLUMNS = ("part", "keep", "people")


@dataclass(frozen=True)
class Wanted:
    """One row of the list."""

    name: str
    """What the list says."""
    parts: tuple[int, ...]
    keep: tuple[int, ...]
    people: int


@dataclass(frozen=True)
class _Line:
    part: Any
    keep: Any
    people: Any
    where: str


def wanted_of(scene: Scene, parts: MaintainParts) -> list[Wanted]:
    """The rows of a list or a CSV file, with their parts. Raises `LoadError` for the file, `OptionError` for a list."""
    is_file = isinstance(parts, os.PathLike) or (isinstance(parts, str) and parts.lower().endswith(".csv"))
    error: type[LoadError] | type[OptionError]
    if is_file:
        lines, error = _read(check_path("parts", parts)), LoadError
    else:
        lines, error = _listed(parts), OptionError
    return [_wanted(scene, line, error) for line in lines]


def _listed(parts: object) -> list[_Line]:
    if not isinstance(parts, Sequence) or isinstance(parts, (str, bytes)):
        raise OptionError(f"parts is {shown(parts)}: give a list of parts, or the name of a CSV file")
    if not parts:
        raise OptionError("parts is empty: give one entry at least")
    lines = []
    for number, each in enumerate(parts):
        where = f"parts[{number}]"
        if not isinstance(each, Mapping):
            lines.append(_Line(each, None, 1, where))
            continue
        odd = [name for name in each if name not in COLUMNS]
        if odd or "part" not in each:
            raise OptionError(f"{where} is {shown(each)}: give part, and if needed keep and people")
        lines.append(_Line(each["part"], each.get("keep"), each.get("people", 1), where))
    return lines


def _read(file: Path) -> list[_Line]:
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give a CSV file with a column part") from None
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=_separator(text))
    try:
        rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as wrong:
        raise LoadError(f"{file}, line {reader.line_num}: {wrong}") from None
    filled = [(number, row) for number, row in rows if any(row) and not (number == 1 and SEPARATOR_LINE.match(text))]
    if not filled:
        raise LoadError(f"{file}: it is empty; its first line names columns: {', '.join(COLUMNS)}")
    first, heads = filled[0]
    heads = [head.lower() for head in heads]
    for head in heads:
        if head not in COLUMNS:
            raise LoadError(f"{file}, line {first}: the column {head!r} is unknown: {near(head, COLUMNS)}")
    if "part" not in heads or len(set(heads)) < len(heads):
        raise LoadError(f"{file}, line {first}: the columns are part, and if needed keep and people, each once")
    lines = []
    for number, row in filled[1:]:
        where = f"{file}, line {number}"
        if len(row) > len(heads) and any(row[len(heads) :]):
            raise LoadError(f"{where}: there are {len(row)} cells for {len(heads)} columns")
        cells = dict(zip(heads, row, strict=False))
        if not cells.get("part"):
            raise LoadError(f"{where}: the part is missing")
        people = cells.get("people") or "1"
        if not people.isdecimal():
            raise LoadError(f"{where}: people is {people!r}: give a whole number")
        lines.append(_Line(cells["part"], cells.get("keep") or None, int(people), where))
    if not lines:
        raise LoadError(f"{file}: it names no part")
    return lines


def _separator(text: str) -> str:
    """What separates the columns: as the first line says, `sep=;`, else what is between the names of the columns."""
    said = SEPARATOR_LINE.match(text)
    if said:
        return said[1]
    heads = re.split(r"[\r\n]", text.lstrip(), maxsplit=1)[0]
    return next((each for each in ";\t" if each in heads), ",")


def _wanted(scene: Scene, line: _Line, error: type[LoadError] | type[OptionError]) -> Wanted:
    mockup = scene.mockup
    try:
        parts = _selected(scene, line.part)
        if not parts:
            raise OptionError("it names no part")
        keep = () if line.keep is None else _selected(scene, line.keep)
        people = check_whole("people", line.people, 1, MOST_PEOPLE)
    except OptionError as wrong:
        raise error(f"{line.where}: {wrong}") from None
    away = [part for part in parts if not scene.part_mask[part]]
    if away:
        raise error(f"{line.where}: part {mockup.part_paths[away[0]]!r} is not in the scene: it is out already")
    if set(parts) & set(keep):
        path = mockup.part_paths[min(set(parts) & set(keep))]
        raise error(f"{line.where}: {path!r} is wanted and kept: leave it out of one of them")
    if len(parts) == int(np.count_nonzero(scene.part_mask)):
        raise error(f"{line.where}: these are all parts of the scene: leave at least one out")
    name = line.part if isinstance(line.part, str) else ", ".join(mockup.part_paths[part] for part in parts[:3])
    return Wanted(name + (", ..." if not isinstance(line.part, str) and len(parts) > 3 else ""), parts, keep, people)


def _selected(scene: Scene, parts: PartsLike) -> tuple[int, ...]:
    return tuple(int(part) for part in scene.mockup.parts.select(parts))
