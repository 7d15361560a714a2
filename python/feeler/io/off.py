"""OFF (Geomview), text: the word `OFF`, the counts, then vertices and polygons. Colours and normals are not used.

An OFF file is a sequence of words. Most writers put every vertex and polygon on a line of its own; then the rest of the
line (normals, colours) is skipped. Files with another layout are read word by word.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import RawMesh, seal_indices
from feeler.io.text import Chunk, chunks_of, decoded
from feeler.progress import Progress
from feeler.words import counted

_KEYWORD = re.compile(rb"((?:ST|[CN4n])*)(?:OFF|off)(\d+)?", re.ASCII)
_SMALL = re.compile(rb"((?:st|[cn4])*)off(\d+)?", re.ASCII)
_WHOLE_NUMBER = re.compile(rb"[+-]?\d+", re.ASCII)


class _Header(NamedTuple):
    flags: str  # before OFF
    vertices: int
    polygons: int
    body: int  # offset of the first word after the counts
    line: int  # and its line


class _Polygons(NamedTuple):
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]


def read_off(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read an OFF file as one part named after the file."""
    data = decoded(path.read_bytes())
    header = _read_header(path, data)
    try:
        vertices, faces, extra = _by_lines(path, data, header, progress)
    except LoadError:
        free = _by_words(path, data, header)
        if free is None:
            raise  # its line is what helps
        vertices, faces, extra = *free, 0
    else:
        if extra and (free := _by_words(path, data, header)):  # the lines matched by chance
            vertices, faces, extra = *free, 0
    result = polygons.triangulate(faces.corners, faces.sizes, vertices)
    check_mesh(header.vertices, len(result.faces), 1, str(path))
    notes = polygons.describe(result)
    for size, what in ((0, "polygons without a corner"), (1, "points"), (2, "lines")):
        if count := int((faces.sizes == size).sum()):
            notes.append(counted(count, f"{what} were skipped: only triangles collide"))
    if extra:
        notes.append(counted(extra, "lines after the last polygon were ignored"))
    sealed = seal_indices(result.faces, header.vertices)
    return RawMesh(vertices, sealed, np.zeros(len(sealed), dtype=np.uint32), [path.stem], [""], notes=notes)


def _read_header(path: Path, data: bytes) -> _Header:
    """Read the keyword, which may be missing, and the counts; the number of edges may be missing as well."""
    words: list[tuple[bytes, int, int]] = []  # word, line, offset behind it
    at, line = 0, 0
    while at < len(data) and len(words) < 5:
        line += 1
        end = data.find(b"\n", at) + 1 or len(data)
        text = data[at:end].split(b"#", 1)[0]
        for match in re.finditer(rb"\S+", text[:4096]):
            words.append((match[0], line, at + match.end()))
        at = end
    if not words:
        raise LoadError(f"{path}: an OFF file starts with 'OFF'; this one holds nothing")
    first = words[0][0]
    keyword = _KEYWORD.fullmatch(first) or _SMALL.fullmatch(first)
    flags = keyword[1].decode() if keyword else ""
    if keyword and words[1:2] and words[1][0].upper() == b"BINARY":
        raise LoadError(f"{path}: binary OFF is not read; save it as text OFF, or as PLY")
    if "4" in flags or ("n" in flags and b"OFF" in first):  # "noff" is NOFF in small letters
        raise LoadError(f"{path}, line 1: OFF with more than three dimensions is not read; save it as plain OFF")
    if keyword:
        glued = [(keyword[2], *words[0][1:])] if keyword[2] else []
        words = glued + words[1:]
    elif not _WHOLE_NUMBER.fullmatch(first):
        raise LoadError(f"{path}, line 1: an OFF file starts with 'OFF'; this one is something else")
    if len(words) < 2 or not all(_WHOLE_NUMBER.fullmatch(word) for word, *_ in words[:2]):
        raise LoadError(f"{path}, line {line}: the numbers of vertices and polygons are missing")
    vertices, faces = int(words[0][0][:30]), int(words[1][0][:30])
    # The shortest vertex is "0 0 0" and the shortest polygon "0", which allows checking a count before using it.
    if vertices < 0 or faces < 0 or 6 * vertices + 2 * faces > len(data) + 1:
        raise LoadError(
            f"{path}: the header promises {vertices:,} vertices and {faces:,} polygons, which do not fit into "
            f"{len(data):,} bytes: the file is damaged or truncated; export it again"
        )
    last = words[1]
    if len(words) > 2 and _WHOLE_NUMBER.fullmatch(words[2][0]):
        # A number of edges stands on the line of the other counts, or on a line of its own; a vertex does neither.
        alone = len(words) == 3 or words[3][1] > words[2][1]
        if words[2][1] == last[1] or alone:
            last = words[2]
    return _Header(flags, vertices, faces, last[2], last[1])


def _by_lines(
    path: Path, data: bytes, header: _Header, progress: Progress | None
) -> tuple[NDArray[np.float64], _Polygons, int]:
    """Read a file with a line for each vertex and polygon; return also the number of remaining lines."""
    vertices = np.empty((header.vertices, 3))
    corners: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    sizes: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    have_vertices = have_faces = extra = 0
    for done, chunk in chunks_of(data[header.body :], path, comments=True, first_line=header.line):
        if progress:
            progress(0.9 * done, f"reading {path.name}")
        rows = np.flatnonzero(chunk.tokens_in_line)
        take = rows[: header.vertices - have_vertices]
        if len(take):
            if (chunk.tokens_in_line[take] < 3).any():
                line = int(take[np.argmax(chunk.tokens_in_line[take] < 3)])
                raise chunk.fail(line, "a vertex needs three numbers; export the file again")
            vertices[have_vertices : have_vertices + len(take)] = chunk.floats(chunk.line_tokens(take, 0, 3)).reshape(
                -1, 3
            )
            have_vertices += len(take)
            rows = rows[len(take) :]
        take = rows[: header.polygons - have_faces]
        if len(take):
            counts = _corner_counts(chunk, take)
            sizes.append(counts)
            corners.append(chunk.integers(chunk.line_tokens(take, 1, counts)))
            have_faces += len(take)
        extra += len(rows) - len(take)
    if have_vertices < header.vertices or have_faces < header.polygons:
        raise LoadError(
            f"{path}: the header promises {header.vertices:,} vertices and {header.polygons:,} polygons, the file has "
            f"{have_vertices:,} and {have_faces:,}: it is truncated; copy or export it again"
        )
    return vertices, _Polygons(np.concatenate(corners), np.concatenate(sizes)), extra


def _corner_counts(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    counts = chunk.integers(chunk.first_token[lines])
    wrong = (counts < 0) | (counts > chunk.tokens_in_line[lines] - 1)
    if wrong.any():
        line = int(lines[np.argmax(wrong)])
        raise chunk.fail(line, f"the polygon promises {int(counts[np.argmax(wrong)])} corners and the line has fewer")
    return counts


def _by_words(path: Path, data: bytes, header: _Header) -> tuple[NDArray[np.float64], _Polygons] | None:
    """Read a file without regard to lines, except that colours end at a line end; None if the words do not match.

    All words must be used, by polygons with three or more valid corners: otherwise the layout is ambiguous.
    """
    values, lines = [np.empty(0)], [np.empty(0, dtype=np.int64)]
    try:
        for _, chunk in chunks_of(data[header.body :], path, comments=True, first_line=header.line):
            tokens = np.arange(len(chunk.starts))
            values.append(chunk.floats(tokens))
            lines.append(chunk.first_line + chunk.token_line(tokens))
    except LoadError:
        return None
    words, line = np.concatenate(values), np.concatenate(lines)
    extra = 3 * ("N" in header.flags.upper()) + 2 * ("ST" in header.flags.upper())
    for colour in (4, 3) if "C" in header.flags.upper() else (0,):
        width = 3 + extra + colour
        body = header.vertices * width
        if body > len(words):
            continue
        for colours_follow in (False, True):
            faces = _walk(words[body:], line[body:], header.polygons, colours_follow)
            if faces is not None and _exist(faces, header.vertices):
                return np.ascontiguousarray(words[:body].reshape(-1, width)[:, :3]), faces
    return None


def _walk(words: NDArray[np.float64], line: NDArray[np.int64], count: int, colours_follow: bool) -> _Polygons | None:
    """Read `count` consecutive polygons, each perhaps with a colour up to the end of its line."""
    if not ((words == np.rint(words)) & (np.abs(words) < 2**53)).all() and not colours_follow:
        return None
    whole = np.where(np.abs(words) < 2**53, words, -1).astype(np.int64)
    next_line = np.searchsorted(line, line, side="right").tolist() if colours_follow else []
    plain = whole.tolist()
    starts, at = [], 0
    for _ in range(count):
        if at >= len(plain) or not 3 <= plain[at] < len(plain) - at:
            return None
        starts.append(at)
        at += 1 + plain[at]
        if colours_follow:
            at = next_line[at - 1]
    if at != len(plain):
        return None
    begin = np.array(starts, dtype=np.int64)
    sizes = whole[begin]
    offsets = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return _Polygons(whole[np.repeat(begin + 1, sizes) + offsets], sizes)


def _exist(faces: _Polygons, vertex_count: int) -> bool:
    return not faces.corners.size or (int(faces.corners.min()) >= 0 and int(faces.corners.max()) < vertex_count)
