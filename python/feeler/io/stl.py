"""STL, binary and text.

Binary: a header of 80 bytes, a uint32 count, 50 bytes a triangle (normal, three corners as float32, two spare bytes). A
file with a size of 84 + 50 * count is binary, whatever its first word. A count of 0 or of one too many, which several
exporters write, is replaced by that of the size. Text: every `solid` is a part, and its name runs to the end of the
line. Normals and spare bytes are not used.

Text is accepted in the variants that programs write: keywords of any case, in one word or two (`endloop`, `end loop`),
a name attached to `endsolid`, several statements on a line or one on several. Only two things count: every `facet` has
three vertices, and the file does not end inside one.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io.limits import check_mesh
from feeler.io.raw import PathBook, RawMesh, clean_name, weld
from feeler.io.sniff import is_binary_stl
from feeler.io.text import Chunk, chunks_of, decoded
from feeler.progress import Progress
from feeler.words import counted

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
_UNKNOWN = 2**32 - 1  # the count of programs that do not know it when they begin to write

# Lines of a text STL, by code. _LOOP: begin or end of a facet's loop, which adds no information.
_OTHER, _FACET, _VERTEX, _ENDFACET, _SOLID, _ENDSOLID, _LOOP = range(7)
_KEYWORDS = {
    "facet": _FACET,
    "outer": _LOOP,
    "vertex": _VERTEX,
    "endloop": _LOOP,
    "endfacet": _ENDFACET,
    "solid": _SOLID,
    "endsolid": _ENDSOLID,
}
_TWO_WORDS = {b"solid": _ENDSOLID, b"facet": _ENDFACET, b"loop": _LOOP}
_GLUED = {b"outerloop": _LOOP, b"facetnormal": _FACET}

_FACET_NORMAL = re.compile(rb"\bfacet\s*normal\b", re.IGNORECASE)
_CORNER = re.compile(r"\bvertex\s+[-+.\d]", re.IGNORECASE)
# For laying out a text anew, one statement a line: ends of names, beginnings of statements, a solid after a name.
_NAME_END = re.compile(rb"^([ \t]*(?:end[ \t]*)?solid\b[^\n]*)\n", re.IGNORECASE | re.MULTILINE)
_STATEMENT = re.compile(
    rb"\s+(?=(?:end\s*(?:solid|facet|loop)|facet\s*normal|outer\s*loop)\b|vertex\s+[-+.\d])", re.IGNORECASE
)
_NEXT_SOLID = re.compile(rb"^(end\s*solid\b[^\n]*?)[ \t]+(?=solid\b)", re.IGNORECASE | re.MULTILINE)


def is_binary(head: bytes, size: int) -> bool:
    """Tell from the first bytes and the size of a file whether it is a binary STL (perhaps a truncated one)."""
    if is_binary_stl(head, size) or head[80:84] == _UNKNOWN.to_bytes(4, "little"):
        return True
    text = decoded(head).lstrip()
    return b"\0" in text[:_HEADER] or not (text[:5].lower() == b"solid" or _FACET_NORMAL.search(text))


def read_stl(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read an STL file of either kind. Corners that are equal bit for bit become one vertex."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(512)
    if is_binary(head, size):
        return _read_binary(path, size, head, progress)
    return _read_text(path, progress)


def _read_binary(path: Path, size: int, head: bytes, progress: Progress | None) -> RawMesh:
    if size < _HEADER:
        raise LoadError(
            f"{path}: {size} bytes are too few for an STL file (a binary one has at least {_HEADER}, a text one starts "
            "with 'solid'); export the file again"
        )
    count = int.from_bytes(head[80:84], "little")
    doubts: list[str] = []
    whole, rest = divmod(size - _HEADER, 50)
    if not rest and whole and count in (0, whole + 1, _UNKNOWN):
        doubts.append(
            f"the header says {count:,} triangles, and the file holds {whole:,}: all of them were read; if some are "
            "missing, export the file again"
        )
        count = whole
    if count == 0 and rest and whole:
        raise LoadError(
            f"{path}: the header says 0 triangles, and {whole:,} triangles and {rest} bytes of another follow: the "
            "file is truncated, or the bytes do not belong to it; copy or export it again"
        )
    if _HEADER + 50 * count > size:
        raise LoadError(
            f"{path}: the header promises {count:,} triangles ({_HEADER + 50 * count:,} bytes), the file has {size:,} "
            "bytes: it is truncated, or no STL file; copy or export it again"
        )
    check_mesh(3 * count, count, 1, str(path))
    notes: list[str] = []
    if size > _HEADER + 50 * count:
        surplus = size - _HEADER - 50 * count
        note = f"{surplus:,} bytes after the last triangle were ignored"
        # They may be triangles that the header did not count, or another file.
        is_doubt = surplus >= _RECORD.itemsize
        (doubts if is_doubt else notes).append(f"{note}: the header says {count:,} triangles" if is_doubt else note)
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
    parts = np.zeros(count, dtype=np.uint32)
    return RawMesh(vertices, index.reshape(-1, 3), parts, [path.stem], [""], notes=notes, doubts=doubts)


def _read_text(path: Path, progress: Progress | None) -> RawMesh:
    data = decoded(path.read_bytes())
    try:
        return _parse(path, data, progress, relaid=False)
    except LoadError as error:
        relaid = _one_statement_a_line(data)
        try:
            return _parse(path, relaid, None, relaid=True)
        except LoadError as second:
            # The first error has the file's lines; it is wrong where the lines are far from one statement each.
            before, after = len(data.split(b"\n")), len(relaid.split(b"\n"))
            if before < 2 * after and after < 2 * before:
                raise error from None
            raise LoadError(re.sub(r", line (\d+):", r", statement \1:", str(second), count=1)) from None


def _one_statement_a_line(data: bytes) -> bytes:
    marked = _NAME_END.sub(rb"\1\0", data).replace(b"\n", b" ").replace(b"\0", b"\n")
    return _NEXT_SOLID.sub(rb"\1\n", _STATEMENT.sub(b"\n", marked))


def _parse(path: Path, data: bytes, progress: Progress | None, relaid: bool) -> RawMesh:
    """Read a text of one statement a line. Where it was laid out anew, triangles may stand outside of solids."""
    codes: list[NDArray[np.uint8]] = []
    lines: list[NDArray[np.int64]] = []
    corners: list[NDArray[np.float64]] = []
    solids: list[str] = []
    strange, first_strange, last_strange = 0, 0, 0
    for done, chunk in chunks_of(data, path, comments=False):
        if progress:
            progress(0.6 * done, f"reading {path.name}")
        full = np.flatnonzero(chunk.tokens_in_line)
        code = _line_codes(chunk, full)
        if (code == _OTHER).any():
            where = chunk.first_line + full[code == _OTHER]
            first_strange = first_strange or int(where[0])
            last_strange = int(where[-1])
            strange += len(where)
        for line in full[code == _SOLID].tolist():
            solids.append(chunk.line_text(line)[5:].strip())
            if _CORNER.search(solids[-1]):
                raise chunk.fail(line, "triangles begin on the line of the solid's name")
        corners.append(_corner_values(chunk, full[code == _VERTEX]))
        told = (code != _OTHER) & (code != _LOOP)
        codes.append(code[told])
        lines.append(chunk.first_line + full[told])
    code, line = np.concatenate(codes), np.concatenate(lines)
    solid_of_face, has_end = _check_order(path, code, line, last_strange, relaid)
    soup = np.concatenate(corners)
    count = len(solid_of_face)
    check_mesh(3 * count, count, len(solids), str(path))
    doubts: list[str] = []
    notes: list[str] = []
    if strange:
        notes.append(counted(strange, "lines that are not STL were ignored") + _first_line(first_strange, relaid))
    if not has_end:
        doubts.append("the last solid has no 'endsolid': if it is not complete, the file is truncated; copy it again")
    if progress:
        progress(0.6, f"merging equal vertices of {path.name}")
    vertices, index = weld(soup, None)
    used, part_of_face = np.unique(solid_of_face, return_inverse=True)
    empty = len(solids) - int((used >= 0).sum())
    if empty:
        notes.append(f"{empty:,} of {len(solids):,} solids hold no triangle")
    book = PathBook()
    names = [clean_name(solids[solid], "") if solid >= 0 else "" for solid in used.tolist()]
    paths = [""] if names == [""] else [book.claim("", name or f"solid {i + 1}") for i, name in enumerate(names)]
    names = [name or (path.stem if len(names) == 1 else f"solid {i + 1}") for i, name in enumerate(names)]
    return RawMesh(
        vertices, index.reshape(-1, 3), part_of_face.astype(np.uint32), names, paths, notes=notes, doubts=doubts
    )


def _first_line(line: int, relaid: bool) -> str:
    return "" if relaid else f", the first is line {line:,}"


def _line_codes(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return the code of each line, from its first word or two."""
    first = chunk.first_token[lines]
    length = chunk.length(first)
    start, fourth = chunk.letter(first), chunk.letter(first, 3)
    code = np.zeros(len(lines), dtype=np.uint8)
    for word, number in _KEYWORDS.items():
        code[(length == len(word)) & (start == ord(word[0])) & (fourth == ord(word[3]))] = number
    others = np.flatnonzero(code == _OTHER)
    if len(others):
        words = chunk.words(first[others])
        for glued, number in _GLUED.items():
            code[others[words == glued]] = number
        code[others[words.astype("S8") == b"endsolid"]] = _ENDSOLID
        ends = others[(words == b"end") & (chunk.tokens_in_line[lines[others]] > 1)]
        second = chunk.words(first[ends] + 1)
        for second_word, number in _TWO_WORDS.items():
            code[ends[second == second_word]] = number
        if chunk.first_line == 1 and others[0] == 0 and bytes(words[0]).startswith(b"solid"):
            code[0] = _SOLID
    return code


def _corner_values(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.float64]:
    wrong = chunk.tokens_in_line[lines] != 4
    if wrong.any():
        raise chunk.fail(int(lines[np.argmax(wrong)]), "a vertex needs three numbers; export the file again")
    return chunk.floats(chunk.line_tokens(lines, 1, 3)).reshape(-1, 3)


def _check_order(
    path: Path, code: NDArray[np.uint8], line: NDArray[np.int64], last_strange: int, relaid: bool
) -> tuple[NDArray[np.int64], bool]:
    """Check that the lines make whole triangles inside solids.

    Return the solid of each triangle (-1: none yet), and whether the last solid has an end.
    """
    border = (code == _SOLID) | (code == _ENDSOLID)
    inner, inner_line = code[~border], line[~border]
    starts = np.flatnonzero(inner == _FACET)
    if len(inner) and inner[0] != _FACET:
        raise _broken(path, int(inner_line[0]), "facet")
    size = np.diff(starts, append=len(inner))
    # A facet is three vertices and, mostly, an endfacet.
    padded = np.concatenate([inner, np.zeros(4, dtype=np.uint8)])
    good = (size == 4) | ((size == 5) & (padded[starts + 4] == _ENDFACET))
    for step in (1, 2, 3):
        good &= padded[starts + step] == _VERTEX
    if not good.all():
        at = int(starts[np.argmin(good)])
        wanted = [_FACET, _VERTEX, _VERTEX, _VERTEX, _ENDFACET, _FACET]
        off = next((i for i in range(1, 6) if at + i >= len(inner) or inner[at + i] != wanted[i]), 5)
        names = {number: word for word, number in _KEYWORDS.items()}
        raise _broken(path, int(inner_line[min(at + off, len(inner) - 1)]), names[wanted[off]])
    before = np.cumsum(~border)[border]  # lines of triangles in front of each solid or endsolid
    inside = ~np.isin(before, np.append(starts, len(inner)))
    if inside.any():
        raise LoadError(f"{path}, line {int(line[border][np.argmax(inside)])}: a solid ends inside a triangle")
    has_end = bool(border.any() and code[border][-1] == _ENDSOLID)
    # Without an end, the text may be cut between two triangles; nothing may indicate a cut elsewhere.
    cut = not len(code) or code[-1] != _ENDFACET or last_strange > int(line[-1])
    if not has_end and (cut or relaid):
        raise LoadError(
            f"{path}: the last solid has no 'endsolid': the file is truncated; copy or export it again, or add the "
            "line if you know that it is complete"
        )
    facets = code == _FACET
    solid: NDArray[np.int64] = np.cumsum(code == _SOLID)[facets] - 1
    outside = np.cumsum(code == _ENDSOLID)[facets] > solid
    if outside.any() and not relaid:
        raise LoadError(f"{path}, line {int(line[facets][np.argmax(outside)])}: a triangle stands outside of solids")
    return solid, has_end


def _broken(path: Path, line: int, expected: str) -> LoadError:
    return LoadError(
        f"{path}, line {line}: the triangles are broken here ({expected!r} was expected): the file is truncated or "
        "damaged; copy or export it again"
    )
