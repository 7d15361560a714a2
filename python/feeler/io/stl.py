"""STL, binary and text.

Binary: a header of 80 bytes, a uint32 count, 50 bytes a triangle (normal, three corners as float32, two spare bytes).
Which of the two a file is, its size tells: 84 + 50 * count is binary, whatever its first word. Text: every `solid` is a
part. Normals and spare bytes are not used.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io.limits import check_mesh
from feeler.io.raw import PathBook, Progress, RawMesh, clean_name, weld
from feeler.io.text import Chunk, chunks_of

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])

# Lines of a text STL, by code. One triangle is always the row _FACET_ROW.
_OTHER, _FACET, _OUTER, _VERTEX, _ENDLOOP, _ENDFACET, _SOLID, _ENDSOLID = range(8)
_FACET_ROW = np.array([_FACET, _OUTER, _VERTEX, _VERTEX, _VERTEX, _ENDLOOP, _ENDFACET], dtype=np.uint8)
_KEYWORDS = {
    _FACET: "facet",
    _OUTER: "outer",
    _VERTEX: "vertex",
    _ENDLOOP: "endloop",
    _ENDFACET: "endfacet",
    _SOLID: "solid",
    _ENDSOLID: "endsolid",
}


def is_binary(head: bytes, size: int) -> bool:
    """Tell from the first bytes and the size of a file whether it is a binary STL (perhaps a truncated one)."""
    if size >= _HEADER and _HEADER + 50 * int.from_bytes(head[80:84], "little") == size:
        return True
    return head.lstrip()[:5].lower() != b"solid" or b"\0" in head[:_HEADER]


def read_stl(path: Path, progress: Progress = None) -> RawMesh:
    """Read an STL file of either kind. Corners that are equal bit for bit become one vertex."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(512)
    if is_binary(head, size):
        return _read_binary(path, size, head, progress)
    return _read_text(path, progress)


def _read_binary(path: Path, size: int, head: bytes, progress: Progress) -> RawMesh:
    if size < _HEADER:
        raise LoadError(
            f"{path}: {size} bytes are too few for an STL file (a binary one has at least {_HEADER}, a text one starts "
            "with 'solid'); export the file again"
        )
    count = int.from_bytes(head[80:84], "little")
    if _HEADER + 50 * count > size:
        raise LoadError(
            f"{path}: the header promises {count:,} triangles ({_HEADER + 50 * count:,} bytes), the file has {size:,} "
            "bytes: it is truncated, or no STL file; copy or export it again"
        )
    check_mesh(3 * count, count, 1, str(path))
    notes = []
    if size > _HEADER + 50 * count:
        notes.append(f"{size - _HEADER - 50 * count:,} bytes after the last triangle were ignored")
    if progress:
        progress(0.0, f"reading {path.name}")
    records = np.fromfile(path, dtype=_RECORD, count=count, offset=_HEADER)
    if len(records) != count:
        raise LoadError(f"{path}: the file changed while it was read; try again")
    soup = records["corners"].astype(np.float64).reshape(-1, 3)
    del records
    if progress:
        progress(0.4, f"merging equal vertices of {path.name}")
    vertices, index = weld(soup, None)
    return RawMesh(vertices, index.reshape(-1, 3), np.zeros(count, dtype=np.uint32), [path.stem], [""], notes=notes)


def _read_text(path: Path, progress: Progress) -> RawMesh:
    codes: list[NDArray[np.uint8]] = []
    lines: list[NDArray[np.int64]] = []
    corners: list[NDArray[np.float64]] = []
    solids: list[str] = []
    strange, first_strange = 0, 0
    for done, chunk in chunks_of(path.read_bytes(), path, comments=False):
        if progress:
            progress(0.6 * done, f"reading {path.name}")
        full = np.flatnonzero(chunk.tokens_in_line)
        code = _line_codes(chunk, full)
        if (code == _OTHER).any():
            if not strange:
                first_strange = chunk.first_line + int(full[np.argmax(code == _OTHER)])
            strange += int((code == _OTHER).sum())
        for line in full[code == _SOLID].tolist():
            solids.append(chunk.line_text(line, skip_tokens=1))
        corners.append(_corner_values(chunk, full[code == _VERTEX]))
        codes.append(code[code != _OTHER])
        lines.append(chunk.first_line + full[code != _OTHER])
    solid_of_face = _check_order(path, np.concatenate(codes), np.concatenate(lines))
    soup = np.concatenate(corners)
    count = len(solid_of_face)
    check_mesh(3 * count, count, len(solids), str(path))
    notes = [f"{strange:,} lines that are not STL were ignored, the first is line {first_strange:,}"] if strange else []
    if progress:
        progress(0.6, f"merging equal vertices of {path.name}")
    vertices, index = weld(soup, None)
    used, part_of_face = np.unique(solid_of_face, return_inverse=True)
    if len(used) < len(solids):
        notes.append(f"{len(solids) - len(used):,} of {len(solids):,} solids hold no triangle")
    book = PathBook()
    names = [clean_name(solids[solid], "") for solid in used.tolist()]
    paths = [""] if names == [""] else [book.claim("", name or f"solid {i + 1}") for i, name in enumerate(names)]
    names = [name or (path.stem if len(names) == 1 else f"solid {i + 1}") for i, name in enumerate(names)]
    return RawMesh(vertices, index.reshape(-1, 3), part_of_face.astype(np.uint32), names, paths, notes=notes)


def _line_codes(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return what each line is, by its first word."""
    first = chunk.first_token[lines]
    length = chunk.length(first)
    start, fourth = chunk.letter(first), chunk.letter(first, 3)
    code = np.zeros(len(lines), dtype=np.uint8)
    for number, word in _KEYWORDS.items():
        code[(length == len(word)) & (start == ord(word[0])) & (fourth == ord(word[3]))] = number
    return code


def _corner_values(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.float64]:
    wrong = chunk.tokens_in_line[lines] != 4
    if wrong.any():
        raise chunk.fail(int(lines[np.argmax(wrong)]), "a vertex needs three numbers; export the file again")
    return chunk.floats(chunk.line_tokens(lines, 1, 3)).reshape(-1, 3)


def _check_order(path: Path, code: NDArray[np.uint8], line: NDArray[np.int64]) -> NDArray[np.int64]:
    """Check that the lines make whole triangles inside solids; return the solid of each triangle."""
    border = (code == _SOLID) | (code == _ENDSOLID)
    inner, inner_line = code[~border], line[~border]
    whole = len(inner) // 7
    wrong = np.flatnonzero((inner[: 7 * whole].reshape(-1, 7) != _FACET_ROW).ravel())
    if len(wrong) or len(inner) % 7:
        at = int(inner_line[wrong[0]]) if len(wrong) else int(inner_line[-1])
        expected = _KEYWORDS[int(_FACET_ROW[(int(wrong[0]) if len(wrong) else len(inner)) % 7])]
        raise LoadError(
            f"{path}, line {at}: the triangles are broken here ({expected!r} was expected): the file is truncated or "
            "damaged; copy or export it again"
        )
    before = np.cumsum(~border)[border]  # triangle lines in front of each solid or endsolid
    if (before % 7).any():
        raise LoadError(f"{path}, line {int(line[border][np.argmax(before % 7 != 0)])}: a solid ends inside a triangle")
    if not border.any() or code[border][-1] == _SOLID:
        raise LoadError(
            f"{path}: the last solid has no 'endsolid': the file is truncated; copy or export it again, or add the "
            "line if you know that it is complete"
        )
    solid: NDArray[np.int64] = np.cumsum(code == _SOLID)[code == _FACET] - 1
    return solid
