"""OFF (Geomview), text: the word `OFF`, the counts, then vertices and polygons. Colours and normals are not used.

An OFF file is a sequence of words. Most writers put every vertex and polygon on a line of its own; then the rest of the
line (normals, colours) is skipped. Files with another layout are read word by word. What fits neither is refused for
what is wrong in the layout that its first lines show.
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
from feeler.words import counted, plural

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


class _Read(NamedTuple):
    vertices: NDArray[np.float64]
    polygons: _Polygons
    extra: int = 0  # lines after the last polygon


class _Walk(NamedTuple):
    """Words read as polygons of three or more valid corners, up to the first place that is none."""

    whole: NDArray[np.int64]  # all words; -1 for what is no whole number
    starts: list[int]  # the word of each polygon's number of corners
    end: int  # the word behind the last polygon


_WIDEST_VERTEX = 12  # x y z, a normal, a colour of four and a texture coordinate of two
_WORDS_SHOWN = 4


def read_off(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read an OFF file as one part named after the file."""
    data = decoded(path.read_bytes())
    header = _read_header(path, data)
    vertices, faces, extra = _read_body(path, data, header, progress)
    result = polygons.triangulate(faces.corners, faces.sizes, vertices)
    check_mesh(header.vertices, len(result.faces), 1, str(path))
    notes, doubts = polygons.describe(result)
    for size, what in ((0, "polygons without a corner"), (1, "points"), (2, "lines")):
        if count := int((faces.sizes == size).sum()):
            notes.append(counted(count, f"{what} were skipped: only triangles collide"))
    if extra:
        # They may be polygons that the header did not count.
        ignored = counted(extra, "lines after the last polygon were ignored")
        doubts.append(f"{ignored}: the header says {plural(header.polygons, 'polygon')}")
    sealed = seal_indices(result.faces, header.vertices)
    parts = np.zeros(len(sealed), dtype=np.uint32)
    return RawMesh(vertices, sealed, parts, [path.stem], [""], notes=notes, doubts=doubts)


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
        line = next((at for word, at, _ in words[:2] if not _WHOLE_NUMBER.fullmatch(word)), line)
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


def _read_body(path: Path, data: bytes, header: _Header, progress: Progress | None) -> _Read:
    """Read the body by its lines, or by its words where these fit the header and the lines do not."""
    try:
        read = _by_lines(path, data, header, progress)
    except LoadError as error:
        free = _by_words(path, data, header)
        if isinstance(free, _Read):
            return free
        raise (free if _is_free(path, data, header) else error) from None
    if read.extra and isinstance(free := _by_words(path, data, header), _Read):
        return free  # the lines matched by chance
    return read


def _is_free(path: Path, data: bytes, header: _Header) -> bool:
    """Tell from the lines that would be vertices that lines mean nothing: one is too long, or most too short."""
    _, chunk = next(chunks_of(data[header.body :], path, comments=True, first_line=header.line), (0.0, None))
    if chunk is None:
        return False
    lengths = chunk.tokens_in_line[chunk.tokens_in_line > 0][: header.vertices]
    return bool((lengths > _WIDEST_VERTEX).any() or 2 * (lengths < 3).sum() > len(lengths))


def _by_lines(path: Path, data: bytes, header: _Header, progress: Progress | None) -> _Read:
    """Read a file with a line for each vertex and polygon."""
    vertices = np.empty((header.vertices, 3))
    corners: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    sizes: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    have_vertices = have_faces = extra = words = 0
    for done, chunk in chunks_of(data[header.body :], path, comments=True, first_line=header.line):
        if progress:
            progress(0.9 * done, f"reading {path.name}")
        rows = np.flatnonzero(chunk.tokens_in_line)
        words += len(chunk.starts)
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
            f"{path}: the header promises {header.vertices:,} vertices and {header.polygons:,} polygons, and "
            f"{have_vertices + have_faces:,} lines with {words:,} words follow: truncated; copy or export it again"
        )
    return _Read(vertices, _Polygons(np.concatenate(corners), np.concatenate(sizes)), extra)


def _corner_counts(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    counts = chunk.integers(chunk.first_token[lines])
    wrong = (counts < 0) | (counts > chunk.tokens_in_line[lines] - 1)
    if wrong.any():
        line = int(lines[np.argmax(wrong)])
        raise chunk.fail(line, f"the polygon promises {int(counts[np.argmax(wrong)])} corners and the line has fewer")
    return counts


def _by_words(path: Path, data: bytes, header: _Header) -> _Read | LoadError:
    """Read a file without regard to lines, except that colours end at a line end; or return what is wrong.

    All words must be used, by polygons with three or more valid corners: otherwise the layout is ambiguous.
    """
    values, lines = [np.empty(0)], [np.empty(0, dtype=np.int64)]
    try:
        for _, chunk in chunks_of(data[header.body :], path, comments=True, first_line=header.line):
            tokens = np.arange(len(chunk.starts))
            values.append(chunk.floats(tokens))
            lines.append(chunk.first_line + chunk.token_line(tokens))
    except LoadError as error:
        return error
    words, line = np.concatenate(values), np.concatenate(lines)
    extra = 3 * ("N" in header.flags.upper()) + 2 * ("ST" in header.flags.upper())
    best: tuple[int, LoadError] | None = None  # the reading that goes farthest says what is wrong
    for colour in (4, 3) if "C" in header.flags.upper() else (0,):
        width = 3 + extra + colour
        body = header.vertices * width
        for colours_follow in (False, True):
            walk = _walk(words[body:], line[body:], header, colours_follow)
            if body + walk.end == len(words) and len(walk.starts) == header.polygons:
                return _Read(np.ascontiguousarray(words[:body].reshape(-1, width)[:, :3]), _walked(walk))
            if best is None or len(walk.starts) > best[0]:
                best = len(walk.starts), LoadError(f"{path}{_mismatch(walk, words, line, width, header)}")
    assert best is not None
    return best[1]


def _walk(words: NDArray[np.float64], line: NDArray[np.int64], header: _Header, colours_follow: bool) -> _Walk:
    """Read consecutive polygons, each perhaps with a colour up to the end of its line."""
    is_whole = (words == np.rint(words)) & (np.abs(words) < 2**53)
    whole = np.where(is_whole, words, -1).astype(np.int64)
    next_line = np.searchsorted(line, line, side="right").tolist() if colours_follow else []
    plain = whole.tolist()
    starts: list[int] = []
    at = 0
    while len(starts) < header.polygons and at < len(plain) and 3 <= plain[at] < len(plain) - at:
        corners = plain[at + 1 : at + 1 + plain[at]]
        if min(corners) < 0 or max(corners) >= header.vertices:
            break
        starts.append(at)
        at += 1 + plain[at]
        if colours_follow:
            at = next_line[at - 1]
    return _Walk(whole, starts, at)


def _walked(walk: _Walk) -> _Polygons:
    """Return the polygons of a walk."""
    begin = np.array(walk.starts, dtype=np.int64)
    sizes = walk.whole[begin]
    offsets = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return _Polygons(walk.whole[np.repeat(begin + 1, sizes) + offsets], sizes)


def _mismatch(walk: _Walk, words: NDArray[np.float64], line: NDArray[np.int64], width: int, header: _Header) -> str:
    """Say where words and header part, as the end of a message that begins with the file."""
    end = "it is truncated or damaged; copy or export it again"
    if len(words) < width * header.vertices:
        at = len(words) // width + 1
        return f": the file ends at vertex {at:,} of the {header.vertices:,} that the header promises: {end}"
    number, left = len(walk.starts) + 1, len(walk.whole) - walk.end
    polygon = f"polygon {number:,} of the {header.polygons:,} that the header promises"
    if not left:
        return f": the file ends before {polygon}: {end}"
    at = len(words) - left
    where = f", line {int(line[at]):,}"
    if number > header.polygons:
        return (
            f"{where}: {left:,} words are left over behind the last of {header.polygons:,} polygons: a count or a word "
            "is wrong; export it again"
        )
    if left <= (size := int(walk.whole[walk.end])) <= header.vertices:
        return f"{where}: the file ends in {polygon}, with {left - 1:,} of its {size:,} corners: {end}"
    shown = " ".join(f"{word:g}" for word in words[at : at + _WORDS_SHOWN].tolist())
    return (
        f"{where}: {polygon} cannot be '{shown} ...': it needs a number of corners, 3 or more, and vertices from 0 to "
        f"{header.vertices - 1:,}; a word is wrong, missing or left over, here or before; export it again"
    )
