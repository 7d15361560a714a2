"""`catalogue`: the tools that `access` chooses from, as a TOML file of the user's or as built in."""

from __future__ import annotations

import fnmatch
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, overload

import numpy as np

from feeler.arguments import (
    RowsLike,
    check_array,
    check_kind,
    check_list,
    check_path,
    check_real,
    check_text,
    near,
    rows_at,
    shown,
)
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.io.text import text_of
from feeler.io.toml import parsed_toml
from feeler.mockup import Tool
from feeler.plan.tool_shapes import ToolShape, cores_of, fist, shape_of
from feeler.plan.tool_solids import Solid
from feeler.plan.tool_spec import HANDLES, HEADS, TOOL_KINDS, ToolSpec, suits
from feeler.words import plural

BUILT_IN_NAMES = ("built-in", "catalogue")
"""Instead of the path of a file: the built-in catalogue."""
_BUILT_IN_FILE = Path(__file__).with_name("catalogue.toml")
JOINT = " + "
"""Between the names of a chain's pieces."""
MM = 1e-3
LONGEST_MM = 10_000.0
"""The largest length in a catalogue."""
MOST_EXTENSIONS = 2
"""Extensions of one chain; two only where one is not long enough."""
_HAND = ("width_mm", "depth_mm", "height_mm")
_HEADER = re.compile(r"\s*\[\[\s*(\w+)\s*\]\]")
_LISTS = ("sizes", "sizes_mm", "lengths_mm", "threads_mm", "widths_mm")
_WORDS = ("name", "fits", *_LISTS, "drive_mm", "swing_deg", "step_deg")


class Catalogue(Sequence[ToolSpec]):
    """Tools by kind and size, in the order in which `access` prefers them. See `catalogue`."""

    def __init__(self, rows: Iterable[ToolSpec], hand: Sequence[float] | None = None) -> None:
        found = check_list("rows", rows, "a list of feeler.ToolSpec")
        self._rows = tuple(check_kind("rows", row, ToolSpec, "a list of feeler.ToolSpec") for row in found)
        self._hand: tuple[float, ...] | None = None
        if hand is not None:
            self._hand = tuple(check_array("hand", hand, (3,)).tolist())
            if min(self._hand) <= 0.0:
                raise OptionError(f"hand is {shown(hand)}: give width, depth and height, metres, above 0")
        names = [row.name for row in self._rows]
        twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
        if twice is not None:
            raise OptionError(f"two tools of the catalogue are named {twice!r}: give each a name of its own")

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> ToolSpec: ...
    @overload
    def __getitem__(self, index: RowsLike) -> Catalogue: ...
    def __getitem__(self, index: int | RowsLike) -> ToolSpec | Catalogue:
        at = rows_at(index, len(self))
        return self._rows[at] if isinstance(at, int) else Catalogue([self._rows[each] for each in at], self._hand)

    def __iter__(self) -> Iterator[ToolSpec]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Catalogue):
            return NotImplemented
        return self._rows == other._rows and self._hand == other._hand

    def __hash__(self) -> int:
        return hash((self._rows, self._hand))

    def __repr__(self) -> str:
        return f"Catalogue({plural(len(self), 'tool')})"

    def where(self, *names: str) -> Catalogue:
        """The tools of some kinds or names: "socket", "ring", "extension 100*". Raises `OptionError` for none."""
        wanted = [check_text("names", name, "a kind, or a pattern of names") for name in names]
        rows = [row for row in self._rows if any(row.kind == w or fnmatch.fnmatchcase(row.name, w) for w in wanted)]
        if not rows:
            kinds = list(dict.fromkeys(row.kind for row in self._rows))
            raise OptionError(f"no tool of the catalogue is {shown(list(wanted))}: {near(names[:1], kinds)}")
        return Catalogue(rows, self._hand)

    @property
    def hand(self) -> Tool | None:
        """A closed hand for `access(hand=)`, z along what it holds, by the numbers of the file; None without them."""
        return None if self._hand is None else _tool([("hand", fist(*self._hand))], "hand")

    def tool(self, name: str) -> Tool:
        """The shape of a tool, or of a chain such as "socket 10 + extension 100 (6.3) + ratchet (6.3)", as
        `Reach.tool` names it.

        Its frame: the origin on the axis at the lower end of what is on the fastener, z out of the joint, the handle
        towards x. Raises `OptionError` for a name that is not in the catalogue.
        """
        return tool_of(self.pieces(name))

    def pieces(self, name: str) -> tuple[ToolSpec, ...]:
        """The pieces of a tool, from the fastener on. Raises `OptionError` for a name that is not in the catalogue."""
        by_name = {row.name: row for row in self._rows}
        steps = check_text("name", name).split(JOINT)
        for step in steps:
            if step not in by_name:
                raise OptionError(f"the catalogue has no {shown(step)}: {near(step, by_name)}")
        return tuple(by_name[step] for step in steps)

    def fitting(
        self, drive: str, across_flats: float, thread: float, width: float = math.nan
    ) -> list[tuple[ToolSpec, ...]]:
        """The tools and chains that fit a fastener, in the order in which they are tried: sizes in metres, NaN if not
        known.

        `width`: as `Fastener.width`, where there are no flats. Kinds in the order of the catalogue; of chains the
        shortest extension first, then the smallest drive.
        """
        wanted = check_text("drive", drive, "a drive, as Fastener.drive")
        flats, diameter = check_real("across_flats", across_flats), check_real("thread", thread)
        wide = check_real("width", width) if math.isnan(flats) else flats
        suited = [row for row in self._rows if suits(row, wanted, wide, diameter)]
        found: list[tuple[ToolSpec, ...]] = []
        for kind in dict.fromkeys(row.kind for row in suited):
            some = _nearest([row for row in suited if row.kind == kind], wide)
            found += self._chains(some) if kind in HEADS else [(row,) for row in some]
        return found

    def _chains(self, heads: Sequence[ToolSpec]) -> list[tuple[ToolSpec, ...]]:
        found = []
        for order, head in enumerate(heads):
            handles = [row for row in self._rows if row.kind in HANDLES and row.drive == head.drive]
            for extensions in self._extensions(head.drive):
                for number, handle in enumerate(handles):
                    total = sum(each.size for each in extensions)
                    key = (round(total, 6), len(extensions), head.drive, number, order)
                    found.append((key, (head, *extensions, handle)))
        return [chain for _, chain in sorted(found, key=lambda each: each[0])]

    def _extensions(self, drive: float) -> list[tuple[ToolSpec, ...]]:
        """None, one, or two where that is longer than any single one."""
        single = sorted((r for r in self._rows if r.kind == "extension" and r.drive == drive), key=lambda r: r.size)
        return [(), *((each,) for each in single), *((single[-1], each) for each in single)]

    def __reduce__(self) -> tuple[Any, ...]:
        return (Catalogue, (self._rows, self._hand))


def catalogue(path: str | os.PathLike[str] | None = None) -> Catalogue:
    """The tools in a TOML file; None, "built-in" and "catalogue" are the built-in ones: our own numbers, of the kinds
    of ISO 1173, 2725, 3318 and 10102.

    `feeler access --write-catalogue tools.toml` writes the built-in file, which explains itself. Raises `LoadError`
    for an invalid file, naming the table, and `MissingFileError`.
    """
    if path is None or (isinstance(path, str) and path in BUILT_IN_NAMES):
        return _built_in()
    file = check_path("path", path)
    try:
        text = text_of(file)
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: feeler access --write-catalogue FILE writes one") from None
    return parsed_catalogue(text, str(file))


def parsed_catalogue(text: str, where: str) -> Catalogue:
    """The tools in the text of a file, which errors name as `where`. Raises `LoadError`, naming table and line."""
    data = parsed_toml(text, where)
    return _read(data, where, _lines(text, data))


def built_in_text() -> str:
    """The built-in file."""
    return text_of(_BUILT_IN_FILE)


@lru_cache(maxsize=1)
def _built_in() -> Catalogue:
    return parsed_catalogue(built_in_text(), "the built-in catalogue")


@lru_cache(maxsize=1024)
def shaped(pieces: tuple[ToolSpec, ...]) -> ToolShape:
    """The shape of a tool, made once."""
    return shape_of(pieces)


@lru_cache(maxsize=1024)
def core_of(pieces: tuple[ToolSpec, ...]) -> Tool | None:
    """What a chain contains at any angle about its axis; None for other tools."""
    solids = [("core", solid) for solid in cores_of(pieces)]
    return _tool(solids, "core") if solids else None


@lru_cache(maxsize=1024)
def tool_of(pieces: tuple[ToolSpec, ...]) -> Tool:
    """A tool of pieces, made once."""
    return _tool(shaped(pieces).solids, name_of(pieces))


def name_of(pieces: Iterable[ToolSpec]) -> str:
    """The name of a tool or chain."""
    return JOINT.join(piece.name for piece in pieces)


def _tool(solids: Sequence[tuple[str, Solid]], name: str) -> Tool:
    starts = np.cumsum([0, *(len(vertices) for _, (vertices, _) in solids)])
    faces = [faces + start for (_, (_, faces)), start in zip(solids, starts, strict=False)]
    parts = np.repeat(np.arange(len(solids)), [len(each) for each in faces])
    vertices = np.concatenate([vertices for _, (vertices, _) in solids])
    return Tool(vertices, np.concatenate(faces), name, parts, part_names=[name for name, _ in solids])


def _lines(text: str, data: Mapping[str, Any]) -> dict[tuple[str, int], int]:
    """The lines of the headers, by kind and number; of a kind whose tables are written otherwise, none."""
    found: dict[str, list[int]] = {}
    for line, each in enumerate(text.split("\n"), 1):
        if header := _HEADER.match(each):
            found.setdefault(header[1], []).append(line)
    kinds = [kind for kind in found if isinstance(data.get(kind), list) and len(data[kind]) == len(found[kind])]
    return {(kind, number): line for kind in kinds for number, line in enumerate(found[kind], 1)}


def _read(data: Mapping[str, Any], where: str, lines: Mapping[tuple[str, int], int]) -> Catalogue:
    if data.get("version") != 1:
        raise LoadError(f"{where}: version is {shown(data.get('version'))}: this feeler reads catalogues of version 1")
    known = ("version", "hand", *TOOL_KINDS)
    for key in data:
        if key not in known:
            raise LoadError(f"{where}: {shown(key)} is unknown: {near(key, known)}")
    hand = None if "hand" not in data else _hand(data["hand"], f"{where}, [hand]")
    rows: list[ToolSpec] = []
    for kind in data:
        if kind not in TOOL_KINDS:
            continue
        if not isinstance(data[kind], list) or not all(isinstance(each, dict) for each in data[kind]):
            raise LoadError(f"{where}: {kind!r} is no list of tables: begin each with [[{kind}]]")
        for number, table in enumerate(data[kind], 1):
            line = f" in line {lines[kind, number]}" if (kind, number) in lines else ""
            rows += _rows(kind, table, f"{where}, [[{kind}]] {number}{line}")
    if not rows:
        raise LoadError(f"{where}: there is no tool: add [[socket]], [[ring]] and the like")
    try:
        return Catalogue(rows, hand)
    except OptionError as error:
        raise LoadError(f"{where}: {error}") from None


def _nearest(rows: list[ToolSpec], width: float) -> list[ToolSpec]:
    """Of tools by width, those of the nearest size."""
    off = [abs(row.size - width) if row.size > 0.0 else 0.0 for row in rows]
    return [row for row, each in zip(rows, off, strict=True) if each <= min(off) + 1e-9]


def _hand(table: Any, where: str) -> tuple[float, float, float]:
    if not isinstance(table, dict) or set(table) != set(_HAND):
        raise LoadError(f"{where}: give {', '.join(_HAND)}")
    width, depth, height = (MM * _number(table[name], f"{where}: {name}") for name in _HAND)
    return width, depth, height


def _rows(kind: str, table: Mapping[str, Any], where: str) -> Iterator[ToolSpec]:
    """The tools of one table: one for each size."""
    says = TOOL_KINDS[kind]
    words = [*_WORDS, *(f"{name}_mm" for name in says.lengths)]
    for key in table:
        if key not in words:
            raise LoadError(f"{where}: {shown(key)} is unknown: {near(key, words)}")
    labels, sizes, threads, widths = _sizes(kind, table, where)
    count = len(labels)
    drive = MM * _number(table.get("drive_mm"), f"{where}: drive_mm") if says.has_drive else 0.0
    base = table.get("name", kind.replace("_", " "))
    if not isinstance(base, str) or not base or JOINT in base:
        raise LoadError(f"{where}: name is {shown(base)}: give a short text without {JOINT.strip()!r}")
    fits = _texts(table.get("fits", list(says.fits)), f"{where}: fits")
    swing = _number(table.get("swing_deg", says.swing_deg), f"{where}: swing_deg", 360.0)
    step = _number(table.get("step_deg", says.step_deg), f"{where}: step_deg", 360.0)
    columns = {name: _column(table.get(f"{name}_mm"), count, f"{where}: {name}_mm") for name in says.lengths}
    end = f" ({1e3 * drive:g})" if drive else ""
    for k in range(count):
        lengths = {name: MM * column[k] for name, column in columns.items()}
        for note, shape in _variants(kind, lengths):
            name = " ".join(each for each in (base, labels[k]) if each) + end + note
            _check(kind, sizes[k], shape, f"{where}: {name}")
            known = tuple(sorted(shape.items()))
            yield ToolSpec(kind, name, sizes[k], fits, threads[k], drive, swing, step, known, widths[k])


def _variants(kind: str, lengths: dict[str, float]) -> list[tuple[str, dict[str, float]]]:
    """A hexagon key goes in with either arm."""
    if kind != "hex_key":
        return [("", lengths)]
    short, long = lengths["short"], lengths["long"]
    return [("", {"up": short, "across": long}), (", long arm in", {"up": long, "across": short})]


def _check(kind: str, size: float, lengths: Mapping[str, float], where: str) -> None:
    """Raises `LoadError` for numbers that make no tool."""
    pairs = {
        "socket": (("depth", "length"),),
        "bit": (("reach", "length"),),
        "extension": (),
        "ratchet": (("grip", "length"), ("thick", "height")),
        "pliers": (("jaw", "length"),),
        "hex_key": (),
    }.get(kind, ())
    for less, more in pairs:
        if not lengths[less] < lengths[more]:
            raise LoadError(f"{where}: {less}_mm is not less than {more}_mm")
    outside = {"socket": "outer", "ring": "outer", "open": "width"}.get(kind)
    if outside is not None and not 1.02 * size < lengths[outside]:
        raise LoadError(f"{where}: {outside}_mm leaves no wall around the flats")
    if kind in ("ring", "open") and not 2.0 * size < lengths["length"]:
        raise LoadError(f"{where}: length_mm leaves no handle")
    if kind == "extension" and not lengths["end_length"] < size:
        raise LoadError(f"{where}: end_length_mm is not less than the length")


_Span = tuple[float, float] | None


def _sizes(kind: str, table: Mapping[str, Any], where: str) -> tuple[list[str], list[float], list[_Span], list[_Span]]:
    """Labels, widths or lengths in metres, threads, and widths of recesses of each size."""
    if kind in HANDLES:
        return [""], [0.0], [None], [None]
    if kind == "extension":
        lengths = _numbers(table.get("lengths_mm"), f"{where}: lengths_mm")
        return [f"{each:g}" for each in lengths], [MM * each for each in lengths], *_no_spans(len(lengths))
    if "threads_mm" in table or "widths_mm" in table:
        labels = list(_texts(table.get("sizes"), f"{where}: sizes"))
        threads, widths = (_spans(table, name, len(labels), where) for name in ("threads_mm", "widths_mm"))
        return labels, [0.0] * len(labels), threads, widths
    if kind == "pliers":
        return [""], [0.0], [None], [None]
    sizes = _numbers(table.get("sizes_mm"), f"{where}: sizes_mm")
    labels = [f"{each:g}" for each in sizes]
    if "sizes" in table:
        labels = list(_texts(table["sizes"], f"{where}: sizes"))
        if len(labels) != len(sizes):
            raise LoadError(f"{where}: {len(labels)} sizes for {len(sizes)} sizes_mm: give a name for each")
    return labels, [MM * each for each in sizes], *_no_spans(len(sizes))


def _no_spans(count: int) -> tuple[list[_Span], list[_Span]]:
    return [None] * count, [None] * count


def _spans(table: Mapping[str, Any], name: str, count: int, where: str) -> list[_Span]:
    """From and to of each size, metres; None where the table does not have them."""
    if name not in table:
        return [None] * count
    rows = table[name]
    if not isinstance(rows, list) or len(rows) != count:
        raise LoadError(f"{where}: {name}: give [from, to] for each of `sizes`")
    spans: list[_Span] = []
    for row in rows:
        if not isinstance(row, list) or len(row) != 2:
            raise LoadError(f"{where}: {name} is {shown(row)}: give [from, to]")
        low, high = (MM * _number(each, f"{where}: {name}", least=0.0) for each in row)
        if low > high:
            raise LoadError(f"{where}: {name} is {shown(row)}: give [from, to]")
        spans.append((low, high))
    return spans


def _column(value: Any, count: int, where: str) -> list[float]:
    """One number for all sizes, or one for each."""
    if isinstance(value, list):
        numbers = _numbers(value, where)
        if len(numbers) != count:
            raise LoadError(f"{where}: {len(numbers)} numbers for {count} sizes: give one for each, or one for all")
        return numbers
    return [_number(value, where, least=0.0)] * count


def _numbers(value: Any, where: str) -> list[float]:
    if not isinstance(value, list) or not value:
        raise LoadError(f"{where} is {shown(value)}: give a list of numbers")
    return [_number(each, where, least=0.0) for each in value]


def _number(value: Any, where: str, most: float = LONGEST_MM, least: float | None = None) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or value > most or (value <= 0.0 if least is None else value < least):
        above = "above 0" if least is None else f"from {least:g}"
        raise LoadError(f"{where} is {shown(value)}: give a number {above} up to {most:g}")
    return float(value)


def _texts(value: Any, where: str) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(each, str) and JOINT not in each for each in value):
        raise LoadError(f"{where} is {shown(value)}: give a list of texts")
    return tuple(value)
