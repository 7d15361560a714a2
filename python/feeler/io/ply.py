"""PLY (Stanford), text and binary of either byte order: vertices x, y, z; polygons; triangle strips."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import Progress, RawMesh, seal_indices
from feeler.io.text import Chunk, chunks_of

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_INDEX_NAMES = ("vertex_indices", "vertex_index")
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MAX_HEADER = 2**20


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
    """A list property: all its values in a row, and how many each row has."""

    values: NDArray[np.int64]
    sizes: NDArray[np.int64]


@dataclass
class _Body:
    """What the readers of the two encodings fill in."""

    vertices: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    faces: _Lists = field(default_factory=lambda: _Lists(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)))
    strips: _Lists = field(default_factory=lambda: _Lists(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)))


def read_ply(path: Path, progress: Progress = None) -> RawMesh:
    """Read a PLY file as one part named after the file."""
    data = path.read_bytes()
    order, elements, start = _read_header(path, data)
    if progress:
        progress(0.1, f"reading {path.name}")
    body = (
        _read_text(path, data, start, elements, progress)
        if not order
        else _read_binary(path, data, start, elements, order)
    )
    result = polygons.triangulate(body.faces.values, body.faces.sizes, body.vertices)
    triangles = np.concatenate([result.faces, _strip_triangles(body.strips)])
    check_mesh(len(body.vertices), len(triangles), 1, str(path))
    notes = polygons.describe(result)
    if result.thin:
        notes.append(f"{result.thin:,} faces with fewer than three corners hold no triangle")
    if len(body.strips.sizes):
        notes.append(f"{len(body.strips.sizes):,} rows of triangle strips were cut into triangles")
    faces = seal_indices(triangles, len(body.vertices))
    return RawMesh(body.vertices, faces, np.zeros(len(faces), dtype=np.uint32), [path.stem], [""], notes=notes)


def _read_header(path: Path, data: bytes) -> tuple[str, list[_Element], int]:
    """Return (byte order, "" for text; elements; offset of the body)."""
    end = data.find(b"end_header", 0, _MAX_HEADER)
    stop = data.find(b"\n", end)
    if data.startswith(b"ply\r") and not data.startswith(b"ply\r\n"):
        stop = data.find(b"\r", end)  # line ends of the old Mac
    if not data.startswith(b"ply") or end < 0 or stop < 0:
        raise LoadError(
            f"{path}: the PLY header has no 'end_header': the file is truncated or no PLY file; export it again"
        )
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(data[:end].decode("ascii", "replace").splitlines(), start=1):
        words = line.split()
        try:
            match words[:1]:
                case ["format"]:
                    order = _ORDERS[words[1]]
                case ["element"]:
                    elements.append(_Element(words[1], int(words[2])))
                    if elements[-1].count < 0:
                        raise ValueError
                case ["property"] if words[1] == "list":
                    elements[-1].properties.append(_Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
                case ["property"]:
                    elements[-1].properties.append(_Property(words[2], _TYPES[words[1]], None))
        except (IndexError, KeyError, ValueError):
            raise LoadError(f"{path}, line {number}: {line.strip()[:80]!r} is no valid PLY header line") from None
    if order is None:
        raise LoadError(f"{path}: the PLY header has no 'format' line; export the file again")
    left = len(data) - stop - 1
    # In text the shortest value is a digit and a space; checked before a count is believed.
    least = sum(e.count * sum(_least_bytes(p) if order else 2 for p in e.properties) for e in elements)
    if least > left + 1:
        promised = ", ".join(f"{e.count:,} x {e.name}" for e in elements)
        raise LoadError(
            f"{path}: the header promises {promised}: at least {least:,} bytes, and {left:,} follow; "
            "the file is truncated or damaged; copy or export it again"
        )
    return order, elements, stop + 1


def _least_bytes(prop: _Property) -> int:
    return np.dtype(prop.count_type or prop.type).itemsize


def _index_property(path: Path, element: _Element) -> int:
    """Return which property of a face or strip element holds the vertex indices."""
    lists = [at for at, prop in enumerate(element.properties) if prop.count_type]
    for at in lists:
        if element.properties[at].name in _INDEX_NAMES or len(lists) == 1:
            if element.properties[at].type[0] == "f":
                break
            return at
    raise LoadError(f"{path}: element {element.name!r} has no list of integers 'vertex_indices'; export the file again")


def _axes(path: Path, element: _Element) -> list[int]:
    names = [prop.name for prop in element.properties]
    if not all(axis in names for axis in "xyz"):
        raise LoadError(f"{path}: the vertices have no x, y and z (but {', '.join(names) or 'nothing'})")
    return [names.index(axis) for axis in "xyz"]


# --- binary ------------------------------------------------------------------------------------------------------


def _read_binary(path: Path, data: bytes, at: int, elements: list[_Element], order: str) -> _Body:
    body = _Body()
    for element in elements:
        if not element.count or not element.properties:
            continue
        wanted: int | None = None
        if element.name in ("face", "tristrips"):
            wanted = _index_property(path, element)
        rows, values, at = _binary_rows(path, data, at, element, order, wanted)
        if element.name == "vertex":
            if rows is None:
                raise LoadError(f"{path}: vertices with lists of varying length are not read; export the file again")
            check_mesh(element.count, 0, 1, str(path))
            body.vertices = np.empty((element.count, 3))
            for axis, prop in enumerate(_axes(path, element)):
                body.vertices[:, axis] = rows[f"f{prop}"]
        elif element.name == "face" and values:
            body.faces = values
        elif element.name == "tristrips" and values:
            body.strips = values
    return body


def _binary_rows(
    path: Path, data: bytes, at: int, element: _Element, order: str, wanted: int | None
) -> tuple[NDArray[np.void] | None, _Lists | None, int]:
    """Return (all rows of an element if they are alike, the wanted list property, offset behind the element)."""
    lists = [i for i, prop in enumerate(element.properties) if prop.count_type]
    # First guess: every list is as long as in the first row, as in nearly every file.
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
                values = _Lists(rows[f"f{wanted}"].astype(np.int64).ravel(), size)
            return rows, values, at + element.count * row.itemsize
    if not lists:
        raise _truncated(path, element)
    found: list[NDArray[np.int64]] = []
    counts = np.empty(element.count, dtype=np.int64)
    for index in range(element.count):
        sizes, ends = _walk_row(path, data, at, element, order)
        if wanted is not None:
            counts[index] = sizes[wanted]
            dtype = np.dtype(order + element.properties[wanted].type)
            found.append(np.frombuffer(data, dtype, sizes[wanted], ends[wanted] - sizes[wanted] * dtype.itemsize))
        at = ends[-1]
    values = _Lists(np.concatenate(found).astype(np.int64), counts) if wanted is not None else None
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


def _truncated(path: Path, element: _Element) -> LoadError:
    return LoadError(
        f"{path}: the file ends, or is damaged, inside its {element.count:,} rows of {element.name!r}: "
        "copy or export it again"
    )


# --- text --------------------------------------------------------------------------------------------------------


def _read_text(path: Path, data: bytes, start: int, elements: list[_Element], progress: Progress) -> _Body:
    body = _Body()
    vertices: list[NDArray[np.float64]] = []
    lists: dict[str, list[_Lists]] = {"face": [], "tristrips": []}
    pending = [element for element in elements if element.count and element.properties]
    left = pending[0].count if pending else 0
    for done, chunk in chunks_of(data[start:], path, comments=False, first_line=data.count(b"\n", 0, start) + 1):
        if progress:
            progress(0.1 + 0.8 * done, f"reading {path.name}")
        rows = np.flatnonzero(chunk.tokens_in_line)
        while len(rows) and pending:
            element, take = pending[0], rows[:left]
            if element.name == "vertex":
                vertices.append(_text_vertices(path, chunk, take, element))
            elif element.name in lists:
                lists[element.name].append(_text_lists(path, chunk, take, element))
            rows, left = rows[len(take) :], left - len(take)
            if not left:
                pending.pop(0)
                left = pending[0].count if pending else 0
    if pending:
        raise _truncated(path, pending[0])
    if vertices:
        body.vertices = np.concatenate(vertices)
    for name, found in lists.items():
        if found:
            joined = _Lists(np.concatenate([f.values for f in found]), np.concatenate([f.sizes for f in found]))
            if name == "face":
                body.faces = joined
            else:
                body.strips = joined
    return body


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
            return _Lists(chunk.integers(np.repeat(chunk.first_token[lines] + place + 1, sizes) + offsets), sizes)
        place += 1 + sizes
    raise AssertionError("the wanted property is among those walked")


def _strip_triangles(strips: _Lists) -> NDArray[np.int64]:
    """Cut triangle strips; a negative index starts a new strip. Every second triangle is turned, to keep its side."""
    found = [np.empty((0, 3), dtype=np.int64)]
    for row in np.split(strips.values, np.cumsum(strips.sizes)[:-1]) if len(strips.sizes) else []:
        for strip in np.split(row, np.flatnonzero(row < 0)):
            strip = strip[strip >= 0]
            if len(strip) > 2:
                triangles = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
                triangles[1::2, :2] = triangles[1::2, 1::-1]
                found.append(triangles)
    return np.concatenate(found)
