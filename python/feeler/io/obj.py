"""OBJ (Wavefront), text. Every object (`o`) and group (`g`) is a part; materials are attributes of parts, normals and
textures are not used.

A name runs to the end of its line, blanks and `#` included: exporters number instances as `Bolt #1`, and names cut at
the `#` would merge parts. Everywhere else a `#` begins a comment.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import PathBook, RawMesh, clean_name, seal_indices
from feeler.io.stated import Stated
from feeler.io.tally import Tally
from feeler.io.text import Chunk, chunks_of, decoded
from feeler.progress import Progress
from feeler.words import counted

# Elements with a shape but no triangles, by keyword.
_SHAPES = {
    b"p": "points",
    b"l": "lines",
    b"curv": "free-form curves (curv)",
    b"curv2": "free-form curves on a surface (curv2)",
    b"surf": "free-form surfaces (surf)",
    **{word: f"free-form shapes of old ({word.decode()})" for word in (b"bsp", b"bzp", b"cdc", b"cdp", b"res")},
    b"call": "calls of other files (call)",
    b"csh": "commands of a shell (csh)",
}  # fmt: skip
# Elements of free-form curves and surfaces, which mean nothing without them.
_OF_SHAPES = (
    b"vp", b"cstype", b"deg", b"bmat", b"step", b"parm", b"trim", b"hole", b"scrv", b"sp", b"end", b"con", b"ctech",
    b"stech",
)  # fmt: skip
# Known elements of appearance: they neither make nor move a vertex. Words are cut at twelve letters.
_KNOWN = (
    b"v", b"vt", b"vn", b"f", b"fo", b"o", b"g", b"s", b"mg", b"usemtl", b"mtllib", b"usemap", b"maplib", b"bevel",
    b"c_interp", b"d_interp", b"lod", b"shadow_obj", b"trace_obj",
)  # fmt: skip
_STRANGE_SHOWN = 5
_CONTINUED = re.compile(rb"\\[ \t]*\n")
_NAMING = re.compile(rb"\s*(?:[og]|usemtl|mtllib|usemap|maplib|shadow_obj|trace_obj)\s", re.IGNORECASE)


class _Reader:
    """The reader's state across the chunks of one file."""

    def __init__(self) -> None:
        self.vertices: list[NDArray[np.float64]] = []
        self.corners: list[NDArray[np.int64]] = []
        self.sizes: list[NDArray[np.int64]] = []
        self.lines: list[NDArray[np.int64]] = []
        self.parts: list[NDArray[np.int64]] = []
        self.vertex_count = 0
        self.endless = 0  # vertices with a coordinate that is no finite number
        self.first_endless = 0
        self.weighted = 0  # vertices with a weight w other than 1
        self.object = self.group = self.material = ""
        self.materials: dict[int, dict[str, None]] = {}  # by part, in the order of their first faces
        self.part_of: dict[tuple[str, str], int] = {}
        self.skipped: Counter[bytes] = Counter()
        self.first_strange = 0

    def take(self, chunk: Chunk) -> None:
        """Read one chunk."""
        rows = np.flatnonzero(chunk.tokens_in_line)
        first = chunk.first_token[rows]
        length, letter = chunk.length(first), chunk.letter(first)
        word = np.where(length == 1, letter, 0)
        word[(length == 2) & (letter == ord("f")) & (chunk.letter(first, 1) == ord("o"))] = ord("f")
        paint = np.flatnonzero((length == 6) & (letter == ord("u")))
        for at, sign in enumerate("semtl", 1):
            paint = paint[chunk.letter(first[paint], at) == ord(sign)]
        word[paint] = ord("u")
        self._take_faces(chunk, rows, word)
        self._take_vertices(chunk, rows[word == ord("v")])
        plain = np.isin(word, np.frombuffer(b"vfogu", dtype=np.uint8))
        plain |= (length == 2) & (letter == ord("v")) & np.isin(chunk.letter(first, 1), np.frombuffer(b"nt", np.uint8))
        self._count_others(chunk, rows[~plain])

    def _count_others(self, chunk: Chunk, rows: NDArray[np.int64]) -> None:
        words, where, counts = np.unique(chunk.words(chunk.first_token[rows]), return_index=True, return_counts=True)
        strange = []
        for word, at, count in zip(words.tolist(), where.tolist(), counts.tolist(), strict=True):
            if word in _KNOWN:
                continue
            self.skipped[word] += count
            if word not in _SHAPES and word not in _OF_SHAPES:
                strange.append(chunk.first_line + int(rows[at]))
        if strange and not self.first_strange:
            self.first_strange = min(strange)

    def _take_vertices(self, chunk: Chunk, rows: NDArray[np.int64]) -> None:
        tokens = chunk.tokens_in_line[rows]
        if (tokens < 4).any():
            raise chunk.fail(int(rows[np.argmax(tokens < 4)]), "a vertex needs three numbers; export the file again")
        self.vertices.append(chunk.floats(chunk.line_tokens(rows, 1, 3)).reshape(-1, 3))
        endless = ~np.isfinite(self.vertices[-1]).all(axis=1)
        if endless.any():
            self.endless += int(endless.sum())
            self.first_endless = self.first_endless or chunk.first_line + int(rows[np.argmax(endless)])
        self.vertex_count += len(rows)
        # Four numbers are x y z w, six and more x y z and a colour.
        self.weighted += int((chunk.floats(chunk.line_tokens(rows[tokens == 5], 4, 1)) != 1.0).sum())

    def _take_faces(self, chunk: Chunk, rows: NDArray[np.int64], word: NDArray[np.int64]) -> None:
        faces = rows[word == ord("f")]
        sizes = chunk.tokens_in_line[faces] - 1
        index = chunk.integers(chunk.line_tokens(faces, 1, sizes), until_slash=True)
        # OBJ counts from 1; a negative index counts back from the vertices seen so far.
        seen = self.vertex_count + np.searchsorted(rows[word == ord("v")], faces)
        seen_by_corner = np.repeat(seen, sizes)
        far = np.iinfo(np.int64).max  # stays out of range for any index of the file
        index = np.where(
            index > 0,
            index - 1,
            np.where(index < 0, np.where(-index <= seen_by_corner, index + seen_by_corner, far), far),
        )
        self.corners.append(index)
        self.sizes.append(sizes)
        self.lines.append(chunk.first_line + faces)
        parts = self._parts_of(chunk, faces, rows, word)
        self.parts.append(parts)
        painted = rows[word == ord("u")]
        if self.material or len(painted):
            self._take_materials(chunk, parts, faces, painted)

    def _parts_of(
        self, chunk: Chunk, faces: NDArray[np.int64], rows: NDArray[np.int64], word: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Return the part of each face, from the names between them."""
        naming = (word == ord("o")) | (word == ord("g"))
        upto = np.searchsorted(faces, rows[naming])
        runs = np.diff(upto, prepend=0, append=len(faces)).tolist()  # faces in front of each name, and behind the last
        part = np.empty(len(runs), dtype=np.int64)
        names = zip(rows[naming].tolist(), (word[naming] == ord("o")).tolist(), strict=True)
        for at, count in enumerate(runs):
            # A part begins to exist with its first face.
            part[at] = self.part_of.setdefault((self.object, self.group), len(self.part_of)) if count else 0
            if at < len(runs) - 1:
                row, is_object = next(names)
                name = chunk.line_text(row, skip_tokens=1)
                self.object, self.group = (name, self.group) if is_object else (self.object, name)
        return np.repeat(part, runs)

    def _take_materials(
        self, chunk: Chunk, parts: NDArray[np.int64], faces: NDArray[np.int64], rows: NDArray[np.int64]
    ) -> None:
        """Note which parts have faces of which material. `rows`: the lines `usemtl`, maybe one before every face."""
        texts = chunk.line_bytes(rows, skip=1)
        _, first, index = np.unique(texts, return_index=True, return_inverse=True)
        names = [self.material, *(clean_name(chunk.line_text(int(rows[at]), skip_tokens=1), "") for at in first)]
        number = np.append(0, index.reshape(-1) + 1)  # 0: the material from before
        pairs = np.stack([parts, number[np.searchsorted(rows, faces)]], axis=1)
        pairs, at = np.unique(pairs, axis=0, return_index=True)
        for part, name in pairs[np.argsort(at)].tolist():
            if names[name]:
                self.materials.setdefault(part, {})[names[name]] = None
        self.material = names[number[-1]]

    def notes(self) -> list[str]:
        """Return notes on all elements without triangles."""
        notes = [
            counted(self.skipped[word], f"{what} were skipped: only triangles collide")
            for word, what in _SHAPES.items()
            if word in self.skipped
        ]
        if of_shapes := [f"{word.decode()} ({self.skipped[word]:,})" for word in _OF_SHAPES if word in self.skipped]:
            notes.append("lines that describe free-form curves and surfaces were skipped: " + ", ".join(of_shapes))
        strange = {w: n for w, n in self.skipped.items() if w not in _SHAPES and w not in _OF_SHAPES}
        if strange:
            shown = [
                f"{clean_name(w.decode('latin-1'), '?')!r} ({n:,})" for w, n in list(strange.items())[:_STRANGE_SHOWN]
            ]
            notes.append(
                counted(sum(strange.values()), "lines with keywords that are not OBJ were ignored")
                + f", the first is line {self.first_strange:,}: "
                + ", ".join(shown)
                + (", ..." if len(strange) > _STRANGE_SHOWN else "")
            )
        if self.endless:
            notes.append(
                counted(self.endless, "vertices have a coordinate that is no finite number")
                + f", the first is line {self.first_endless:,}"
            )
        if self.weighted:
            notes.append(
                counted(self.weighted, "vertices have a weight w other than 1, which counts for free-form curves only")
                + ": their x, y, z were taken as they are"
            )
        return notes


def read_obj(path: Path, progress: Progress | None = None) -> RawMesh:
    """Read an OBJ file. A part is one pair of object and group; its path is `object/group`."""
    reader = _Reader()
    data, continued = _joined(decoded(path.read_bytes()))
    notes = []
    if continued:
        notes.append("lines continued with a backslash were joined: line numbers count joined lines once")
    for done, chunk in chunks_of(data, path, comments=True, names=b"og"):
        if progress:
            progress(0.9 * done, f"reading {path.name}")
        reader.take(chunk)
    last_line = data.rstrip().count(b"\n") + 1
    del data
    none = [np.empty(0, dtype=np.int64)]
    vertices = np.concatenate(reader.vertices or [np.empty((0, 3))])
    sizes = np.concatenate(reader.sizes or none)
    result = polygons.triangulate(np.concatenate(reader.corners or none), sizes, vertices)
    check_mesh(len(vertices), len(result.faces), len(reader.part_of), str(path))
    cut, doubts = polygons.describe(result)
    notes += cut
    if result.thin:
        lines = np.concatenate(reader.lines)
        if sizes[-1] < 3 and lines[-1] == last_line:
            doubts.append(
                "the last line is a face with fewer than three corners: the file may be truncated; copy it again"
            )
        line = int(lines[result.first_thin])
        notes.append(
            counted(result.thin, "faces with fewer than three corners hold no triangle")
            + f", the first is line {line:,}"
        )
    notes += reader.notes()
    parts = np.concatenate(reader.parts or none)[result.polygon]
    used, part_of_face = np.unique(parts, return_inverse=True)
    pairs = list(reader.part_of)
    names, paths = _names([pairs[part] for part in used.tolist()], path)
    faces = seal_indices(result.faces, len(vertices))
    tally = Tally()
    stated = Stated(tally)
    for part, name in zip(used.tolist(), names, strict=True):
        stated.add(stated.text("material", ", ".join(reader.materials.get(part, ()))), name=name)
    return RawMesh(
        vertices,
        faces,
        part_of_face.astype(np.uint32),
        names,
        paths,
        notes=notes,
        doubts=doubts + tally.doubts(),
        attributes=stated.attributes(),
    )


def _joined(data: bytes) -> tuple[bytes, int]:
    """Join continued lines; return the text and their number. A backslash ends comments and names as well."""
    if b"\\" not in data:
        return data, 0
    text: bytearray | None = None
    joined = 0
    for match in _CONTINUED.finditer(data):
        start = data.rfind(b"\n", 0, match.start()) + 1
        if b"#" in data[start : match.start()] or _NAMING.match(data, start, match.start()):
            continue  # most likely of a Windows path: the next line would be lost
        text = text if text is not None else bytearray(data)
        text[match.start() : match.end()] = b" " * (match.end() - match.start())
        joined += 1
    return (data if text is None else bytes(text)), joined


def _names(pairs: list[tuple[str, str]], path: Path) -> tuple[list[str], list[str]]:
    """Return names and paths of the parts; a single part without a name takes the file's."""
    book = PathBook()
    names, paths = [], []
    for owner, group in ((clean_name(o, ""), clean_name(g, "")) for o, g in pairs):
        names.append(group or owner or path.stem)
        levels = [level.replace("/", "_") for level in (owner, group) if level]
        if levels:
            paths.append(book.claim("/".join(levels[:-1]), levels[-1]))
        else:
            paths.append("" if len(pairs) == 1 else book.claim("", path.stem))
    return names, paths
