"""PLY (Stanford), text and binary of either byte order: vertices x, y, z; polygons; triangle strips.

Other properties of these are skipped; rows of other elements (edges, materials) are counted by name.

A text is a sequence of words. Most programs write each row of an element on a line of its own, and further words on the
line are skipped. A text whose lines hold more or less than a row is read word by word, if all its words are used up.
What fits neither is refused for what is wrong in the layout that its first lines show.
"""

from __future__ import annotations

import codecs
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import RawMesh, seal_indices
from feeler.io.text import Chunk, chunks_of, decoded
from feeler.progress import Progress
from feeler.words import counted

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MAX_HEADER = 2**20
_FIRST_LINE = re.compile(rb"ply[ \t]*(\r?\n|\r)")
_HEADER_END = re.compile(rb"(?<=[\r\n])[ \t]*end_header[ \t]*(\r?\n|\r)")
_IGNORED = ("ply", "comment", "obj_info")
_SHIFTED = "a word is wrong, missing or left over, here or before; export it again"
_LONG_ROW = 12  # more words than this are not one row, even with colours or normals that the header does not name


class _Property(NamedTuple):
    name: str
    type: str
    count_type: str | None  # of a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


class _Lists(NamedTuple):
    """A list property: all its values in a row, and the length of each row."""

    values: NDArray[np.int64]
    sizes: NDArray[np.int64]


@dataclass(eq=False)
class _Body:
    """The result of the readers of both encodings."""

    vertices: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    faces: _Lists = field(default_factory=lambda: _Lists(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)))
    strips: _Lists = field(default_factory=lambda: _Lists(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)))
    rest: int = 0  # what follows the last row: lines of a text, else bytes

    def add(self, name: str, lists: list[_Lists]) -> None:
        """Take the lists of all elements of that name, "face" or "tristrips", in order."""
        if lists:
            joined = _Lists(np.concatenate([found.values for found in lists]), np.concatenate([f.sizes for f in lists]))
            if name == "face":
                self.faces = joined
            else:
                self.strips = joined


def read_ply(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read a PLY file as one part named after the file."""
    data = path.read_bytes().removeprefix(codecs.BOM_UTF8)
    if not data.startswith(b"ply"):
        data = decoded(data)  # a text in UTF-16
    order, elements, start, line = _read_header(path, data)
    if progress:
        progress(0.1, f"reading {path.name}")
    body = (
        _read_text(path, decoded(data[start:]), line, elements, progress)
        if not order
        else _read_binary(path, data, start, elements, order)
    )
    result = polygons.triangulate(body.faces.values, body.faces.sizes, body.vertices)
    triangles = np.concatenate([result.faces, _strip_triangles(body.strips)])
    check_mesh(len(body.vertices), len(triangles), 1, str(path))
    notes, doubts = polygons.describe(result)
    if result.thin:
        notes.append(counted(result.thin, "faces with fewer than three corners hold no triangle"))
    if len(body.strips.sizes):
        notes.append(counted(len(body.strips.sizes), "rows of triangle strips were cut into triangles"))
    for element in elements:
        if element.name not in ("vertex", "face", "tristrips") and element.count and element.properties:
            notes.append(counted(element.count, f"rows of {element.name[:80]!r} were skipped: only triangles collide"))
    if body.rest:
        note = counted(body.rest, f"{'bytes' if order else 'lines'} after the last row were ignored")
        # Whole rows may be faces that the header did not count.
        said = ", ".join(f"{element.count:,} x {element.name[:80]}" for element in elements)
        is_row = not order or body.rest >= _least_row(elements)
        (doubts if is_row else notes).append(f"{note}: the header says {said}" if is_row else note)
    faces = seal_indices(triangles, len(body.vertices))
    parts = np.zeros(len(faces), dtype=np.uint32)
    return RawMesh(body.vertices, faces, parts, [path.stem], [""], notes=notes, doubts=doubts)


def _read_header(path: Path, data: bytes) -> tuple[str, list[_Element], int, int]:
    """Return (byte order, "" for text; elements; offset and line of the body)."""
    first = _FIRST_LINE.match(data)
    found = _HEADER_END.search(data, 0, _MAX_HEADER) if first else None
    if not first:
        raise LoadError(f"{path}: does not begin with a line 'ply', as PLY files do; export it again")
    if not found:
        raise LoadError(f"{path}: the PLY header has no 'end_header': the file is truncated; export it again")
    stop = found.end()
    if first[1] == b"\r" and found[1] == b"\r\n":
        stop -= 1  # lines end as on the old Mac: the other byte is the first of the body
    order: str | None = None
    elements: list[_Element] = []
    lines = re.split("\r\n|\r|\n", data[: found.start()].decode("ascii", "replace"))
    for number, line in enumerate(lines, start=1):
        words = line.split()
        try:
            match words[:1]:
                case ["format"]:
                    order = _ORDERS[words[1].lower()]
                case ["element"]:
                    elements.append(_Element(words[1], int(words[2])))
                    if elements[-1].count < 0:
                        raise ValueError
                case ["property"] if words[1] == "list":
                    count_type, value_type = (_TYPES[word.lower()] for word in words[2:4])
                    elements[-1].properties.append(_Property(words[4], value_type, count_type))
                case ["property"]:
                    elements[-1].properties.append(_Property(words[2], _TYPES[words[1].lower()], None))
                case [word] if word not in _IGNORED:
                    raise ValueError  # skipping it could shift all that follows
        except (IndexError, KeyError, ValueError):
            raise LoadError(f"{path}, line {number}: {line.strip()[:80]!r} is not a valid PLY header line") from None
    if order is None:
        raise LoadError(f"{path}: the PLY header has no 'format' line; export the file again")
    if sum(element.name == "vertex" for element in elements) > 1:
        raise LoadError(f"{path}: the PLY file has several elements 'vertex': which one do faces mean? Export it again")
    left = len(data) - stop
    # In text the shortest value is a digit and a space; checked before a count is used.
    least = sum(e.count * sum(_least_bytes(p) if order else 2 for p in e.properties) for e in elements)
    if least > left + 1:
        promised = ", ".join(f"{e.count:,} x {e.name}" for e in elements)
        raise LoadError(
            f"{path}: the header promises {promised}: at least {least:,} bytes, and {left:,} follow; "
            "the file is truncated or damaged; copy or export it again"
        )
    return order, elements, stop, len(lines) + 1


def _least_bytes(prop: _Property) -> int:
    return np.dtype(prop.count_type or prop.type).itemsize


def _least_row(elements: list[_Element]) -> int:
    """Return the bytes of the shortest row of the last element that has a triangle in its list, if it has one."""
    properties = elements[-1].properties if elements else []
    return sum(_least_bytes(prop) + (3 * np.dtype(prop.type).itemsize if prop.count_type else 0) for prop in properties)


def _index_property(path: Path, element: _Element) -> int:
    """Return the property of a face or strip element that holds the vertex indices."""
    lists = [at for at, prop in enumerate(element.properties) if prop.count_type]
    for at in lists:
        if element.properties[at].name in _INDEX_NAMES or len(lists) == 1:
            if element.properties[at].type[0] == "f" and element.properties[at].name not in _INDEX_NAMES:
                break
            return at
    raise LoadError(f"{path}: element {element.name!r} has no list of integers 'vertex_indices'; export the file again")


def _axes(path: Path, element: _Element) -> list[int]:
    names = [prop.name.lower() for prop in element.properties]
    if not all(axis in names for axis in "xyz"):
        raise LoadError(f"{path}: the vertices have no x, y and z (but {', '.join(names) or 'nothing'})")
    return [names.index(axis) for axis in "xyz"]


# --- binary ------------------------------------------------------------------------------------------------------


def _read_binary(path: Path, data: bytes, at: int, elements: list[_Element], order: str) -> _Body:
    body = _Body()
    lists: dict[str, list[_Lists]] = {"face": [], "tristrips": []}
    for element in elements:
        if not element.count or not element.properties:
            continue
        wanted: int | None = None
        if element.name in lists:
            wanted = _index_property(path, element)
        rows, values, at = _binary_rows(path, data, at, element, order, wanted)
        if element.name == "vertex":
            if rows is None:
                raise LoadError(f"{path}: vertices with lists of varying length are not read; export the file again")
            check_mesh(element.count, 0, 1, str(path))
            body.vertices = np.empty((element.count, 3))
            for axis, prop in enumerate(_axes(path, element)):
                body.vertices[:, axis] = rows[f"f{prop}"]
        elif values:
            lists[element.name].append(values)
    for name, found in lists.items():
        body.add(name, found)
    if at < len(data):
        body.rest = len(data) - at
    return body


def _binary_rows(
    path: Path, data: bytes, at: int, element: _Element, order: str, wanted: int | None
) -> tuple[NDArray[np.void] | None, _Lists | None, int]:
    """Return (all rows of an element if they have one layout, the wanted list property, offset behind the element)."""
    lists = [i for i, prop in enumerate(element.properties) if prop.count_type]
    # First guess: every list is as long as in the first row, as is true of nearly every file.
    sizes, _ = _walk_row(path, data, at, element, order)
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    for i, prop in enumerate(element.properties):
        if prop.count_type:
            fields.append((f"n{i}", order + prop.count_type))
            fields.append((f"f{i}", order + prop.type, (sizes[i],)))
        else:
            fields.append((f"f{i}", order + prop.type))
    row = np.dtype(fields)
    if at + element.count * row.itemsize <= len(data):
        rows = np.frombuffer(data, dtype=row, count=element.count, offset=at)
        if all((rows[f"n{i}"] == sizes[i]).all() for i in lists):
            values = None
            if wanted is not None:
                size = np.full(element.count, sizes[wanted], dtype=np.int64)
                values = _Lists(_whole(rows[f"f{wanted}"].ravel()), size)
            return rows, values, at + element.count * row.itemsize
    if not lists:
        raise _truncated(path, element)
    found: list[NDArray[Any]] = []
    counts = np.empty(element.count, dtype=np.int64)
    for index in range(element.count):
        sizes, ends = _walk_row(path, data, at, element, order)
        if wanted is not None:
            counts[index] = sizes[wanted]
            dtype = np.dtype(order + element.properties[wanted].type)
            found.append(np.frombuffer(data, dtype, sizes[wanted], ends[wanted] - sizes[wanted] * dtype.itemsize))
        at = ends[-1]
    values = _Lists(_whole(np.concatenate(found)), counts) if wanted is not None else None
    return None, values, at


def _walk_row(path: Path, data: bytes, at: int, element: _Element, order: str) -> tuple[list[int], list[int]]:
    """Return, for one row, the list length (1 for a scalar) and the end offset of each property."""
    sizes, ends = [], []
    for prop in element.properties:
        size = 1
        if prop.count_type:
            count_type = np.dtype(order + prop.count_type)
            if at + count_type.itemsize > len(data):
                raise _truncated(path, element)
            size = (
                int(struct.unpack_from((order or "=") + count_type.char, data, at)[0])
                if count_type.kind in "iu"
                else -1
            )
            at += count_type.itemsize
        at += size * np.dtype(prop.type).itemsize
        if size < 0 or at > len(data):
            raise _truncated(path, element)
        sizes.append(size)
        ends.append(at)
    return sizes, ends


def _whole(values: NDArray[Any]) -> NDArray[np.int64]:
    """Return indices as integers; a few writers store them as floating-point numbers. Others become invalid indices."""
    if values.dtype.kind in "iu":
        return values.astype(np.int64)
    good = (values == np.rint(values)) & (np.abs(values) < 2**53)
    return np.where(good, values, np.iinfo(np.int64).max // 2).astype(np.int64)


def _truncated(path: Path, element: _Element) -> LoadError:
    return LoadError(
        f"{path}: the file ends, or is damaged, inside its {element.count:,} rows of {element.name!r}: "
        "copy or export it again"
    )


# --- text --------------------------------------------------------------------------------------------------------


def _read_text(path: Path, data: bytes, first_line: int, elements: list[_Element], progress: Progress | None) -> _Body:
    """Read a text by its lines, or by its words where these fit the header and the lines do not."""
    try:
        body, is_tidy = _by_lines(path, data, first_line, elements, progress)
    except LoadError as error:
        free = _by_words(path, data, first_line, elements)
        if isinstance(free, _Body):
            return free
        raise (free if _is_free(path, data, elements) else error) from None
    if not is_tidy and isinstance(free := _by_words(path, data, first_line, elements), _Body):
        return free
    return body


def _is_free(path: Path, data: bytes, elements: list[_Element]) -> bool:
    """Tell from the first element that lines mean nothing: one has several rows, or most have no whole one."""
    first = next((element for element in elements if element.count and element.properties), None)
    _, chunk = next(chunks_of(data, path, comments=False), (0.0, None))
    if first is None or chunk is None or any(prop.count_type for prop in first.properties):
        return False
    lengths = chunk.tokens_in_line[chunk.tokens_in_line > 0][: first.count]
    width = len(first.properties)
    return bool((lengths > max(2 * width, _LONG_ROW)).any() or 2 * (lengths < width).sum() > len(lengths))


def _by_lines(
    path: Path, data: bytes, first_line: int, elements: list[_Element], progress: Progress | None
) -> tuple[_Body, bool]:
    """Read a text with a line for each row; return also whether each line holds its row and nothing else."""
    body = _Body()
    vertices: list[NDArray[np.float64]] = []
    lists: dict[str, list[_Lists]] = {"face": [], "tristrips": []}
    pending = [element for element in elements if element.count and element.properties]
    left = pending[0].count if pending else 0
    surplus, words, used = 0, 0, 0
    for done, chunk in chunks_of(data, path, comments=False, first_line=first_line):
        if progress:
            progress(0.1 + 0.8 * done, f"reading {path.name}")
        rows = np.flatnonzero(chunk.tokens_in_line)
        words += len(chunk.starts)
        while len(rows) and pending:
            element, take = pending[0], rows[:left]
            if element.name == "vertex":
                vertices.append(_text_vertices(path, chunk, take, element))
                used += len(take) * len(element.properties)
            elif element.name in lists:
                lists[element.name].append(_text_lists(path, chunk, take, element))
                sizes = lists[element.name][-1].sizes
                used += len(take) * len(element.properties) + int(sizes.sum())
            else:
                used += int(chunk.tokens_in_line[take].sum())
            rows, left = rows[len(take) :], left - len(take)
            if not left:
                pending.pop(0)
                left = pending[0].count if pending else 0
        surplus += len(rows)
    if pending:
        promised, found_rows = pending[0].count, pending[0].count - left
        raise LoadError(
            f"{path}: the header promises {promised:,} rows of {pending[0].name!r}, and {found_rows:,} lines follow "
            "for them: truncated; copy or export it again"
        )
    if vertices:
        body.vertices = np.concatenate(vertices)
    for name, found in lists.items():
        body.add(name, found)
    if surplus:
        body.rest = surplus
    return body, words == used


def _by_words(path: Path, data: bytes, first_line: int, elements: list[_Element]) -> _Body | LoadError:
    """Read a text whose lines mean nothing; or return where its words are not those that the header promises."""
    found, lines = [np.empty(0)], [np.empty(0, dtype=np.int64)]
    try:
        for _, chunk in chunks_of(data, path, comments=False, first_line=first_line):
            tokens = np.arange(len(chunk.starts))
            found.append(chunk.floats(tokens))
            lines.append(chunk.first_line + chunk.token_line(tokens))
    except LoadError as error:
        return error
    words, line = np.concatenate(found), np.concatenate(lines)
    body = _Body()
    lists: dict[str, list[_Lists]] = {"face": [], "tristrips": []}
    at = 0
    for element in elements:
        if not any(prop.count_type for prop in element.properties):
            width = len(element.properties)
            rows, at = words[at : at + element.count * width], at + element.count * width
            if at > len(words):
                return _words_end(path, element, len(rows) // width)
            if element.name == "vertex" and element.count:
                body.vertices = rows.reshape(-1, width)[:, _axes(path, element)]
            continue
        if element.name == "vertex":
            return LoadError(f"{path}: vertices with lists are read only with a row a line; export the file again")
        starts, done, at = _walk_words(words, at, element)
        if done < element.count:
            if at >= len(words):
                return _words_end(path, element, done)
            return LoadError(
                f"{path}, line {int(line[at]):,}: row {done + 1:,} of {element.count:,} of {element.name!r} cannot "
                f"have {words[at]:g} values in a list: {_SHIFTED}"
            )
        if element.name in lists and element.count:
            wanted = starts[_index_property(path, element)]
            sizes = words[wanted].astype(np.int64)
            offsets = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
            lists[element.name].append(_Lists(_whole(words[np.repeat(wanted + 1, sizes) + offsets]), sizes))
            # A row that is wrong tells that a word is, and shifts the others.
            if element.name == "face" and (row := _first_odd(lists["face"][-1], len(body.vertices))) is not None:
                return LoadError(
                    f"{path}, line {int(line[wanted[row]]):,}: row {row + 1:,} of the {element.count:,} rows of 'face' "
                    f"needs 3 or more corners, vertices from 0 to {len(body.vertices) - 1:,}: {_SHIFTED}"
                )
    if at != len(words):
        return LoadError(
            f"{path}, line {int(line[at]):,}: {len(words) - at:,} words are left over behind the last row that the "
            "header promises: a count or a word is wrong; export it again"
        )
    for name, each in lists.items():
        body.add(name, each)
    return body


def _first_odd(faces: _Lists, vertex_count: int) -> int | None:
    """Return the first polygon with fewer than three corners, or with one that does not exist."""
    odd = faces.sizes < 3
    outside = (faces.values < 0) | (faces.values >= vertex_count)
    odd[np.repeat(np.arange(len(odd)), faces.sizes)[outside]] = True
    return int(np.argmax(odd)) if odd.any() else None


def _words_end(path: Path, element: _Element, done: int) -> LoadError:
    return LoadError(
        f"{path}: the file ends in row {done + 1:,} of the {element.count:,} rows of {element.name!r} that the header "
        "promises: it is truncated or damaged; copy or export it again"
    )


def _walk_words(
    words: NDArray[np.float64], at: int, element: _Element
) -> tuple[dict[int, NDArray[np.int64]], int, int]:
    """Return where the count of each list property of an element stands, row by row; whole rows; the word behind them.

    Where rows are missing, that word is the count that is none, or the end of the words.
    """
    is_count = (words >= 0) & (words == np.rint(words)) & (words < len(words))
    counts = np.where(is_count, words, -1).astype(np.int64).tolist()
    lists = [bool(prop.count_type) for prop in element.properties]
    starts: dict[int, list[int]] = {place: [] for place, is_list in enumerate(lists) if is_list}
    done = 0
    while done < element.count:
        for place, is_list in enumerate(lists):
            if is_list and at < len(counts):
                if counts[at] < 0:
                    return {}, done, at
                starts[place].append(at)
                at += counts[at]
            at += 1
        if at > len(counts):
            return {}, done, len(counts)
        done += 1
    return {place: np.array(found, dtype=np.int64) for place, found in starts.items()}, done, at


def _text_vertices(path: Path, chunk: Chunk, lines: NDArray[np.int64], element: _Element) -> NDArray[np.float64]:
    axes = _axes(path, element)
    if any(prop.count_type for prop in element.properties[: max(axes)]):
        raise LoadError(f"{path}: a list in front of a vertex's x, y, z is not read; export the file again")
    short = chunk.tokens_in_line[lines] < len(element.properties)
    if short.any():
        raise chunk.fail(
            int(lines[np.argmax(short)]), f"a vertex here has {len(element.properties)} values, this line fewer"
        )
    tokens = chunk.first_token[lines][:, None] + np.array(sorted(axes))
    values = chunk.floats(tokens.ravel()).reshape(-1, 3)
    return values[:, np.argsort(np.argsort(axes))]


def _text_lists(path: Path, chunk: Chunk, lines: NDArray[np.int64], element: _Element) -> _Lists:
    wanted = _index_property(path, element)
    place = np.zeros(len(lines), dtype=np.int64)  # token of each line at which the next property starts
    for at, prop in enumerate(element.properties[: wanted + 1]):
        if not prop.count_type:
            place += 1
            continue
        here = chunk.tokens_in_line[lines] > place
        if not here.all():
            raise chunk.fail(int(lines[np.argmin(here)]), f"the {element.name} has too few values")
        sizes = chunk.integers(chunk.first_token[lines] + place)
        wrong = (sizes < 0) | (place + 1 + sizes > chunk.tokens_in_line[lines])
        if wrong.any():
            raise chunk.fail(int(lines[np.argmax(wrong)]), f"the {element.name} promises more values than the line has")
        if at == wanted:
            offsets = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
            tokens = np.repeat(chunk.first_token[lines] + place + 1, sizes) + offsets
            read = chunk.floats if prop.type[0] == "f" else chunk.integers
            return _Lists(_whole(read(tokens)), sizes)
        place += 1 + sizes
    raise AssertionError("the wanted property is among those walked")


def _strip_triangles(strips: _Lists) -> NDArray[np.int64]:
    """Cut triangle strips; a negative index starts a new strip. Every second triangle is turned, to keep its side."""
    values, count = strips.values, len(strips.values)
    if count < 3:
        return np.empty((0, 3), dtype=np.int64)
    # The place at which the strip of each index begins: the first of its row, or behind the last negative index.
    begins = np.zeros(count, dtype=np.int64)
    row_starts = np.cumsum(strips.sizes) - strips.sizes
    begins[row_starts[row_starts < count]] = row_starts[row_starts < count]
    after = np.flatnonzero(values[:-1] < 0) + 1
    begins[after] = after
    place = np.arange(count) - np.maximum.accumulate(begins)
    ends = np.flatnonzero((place >= 2) & (values >= 0))
    turned = place[ends] % 2 == 1
    first, second = np.where(turned, ends - 1, ends - 2), np.where(turned, ends - 2, ends - 1)
    return np.stack([values[first], values[second], values[ends]], axis=1)
