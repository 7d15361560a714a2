"""OBJ (Wavefront), text. Every object (`o`) and group (`g`) is a part; materials, normals and textures are not used."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import PathBook, Progress, RawMesh, clean_name, seal_indices
from feeler.io.text import Chunk, chunks_of

_SKIPPED = {ord("p"): "points", ord("l"): "lines"}


class _Reader:
    """The state that runs through the chunks of one file."""

    def __init__(self) -> None:
        self.vertices: list[NDArray[np.float64]] = []
        self.corners: list[NDArray[np.int64]] = []
        self.sizes: list[NDArray[np.int64]] = []
        self.lines: list[NDArray[np.int64]] = []
        self.parts: list[NDArray[np.int64]] = []
        self.vertex_count = 0
        self.object = self.group = ""
        self.part_of: dict[tuple[str, str], int] = {}
        self.skipped: dict[str, int] = {}

    def take(self, chunk: Chunk) -> None:
        """Read one chunk."""
        rows = np.flatnonzero(chunk.tokens_in_line)
        first = chunk.first_token[rows]
        word = np.where(chunk.length(first) == 1, chunk.letter(first), 0)
        self._take_names_and_faces(chunk, rows, word)
        self._take_vertices(chunk, rows[word == ord("v")])
        for letter, what in _SKIPPED.items():
            if count := int((word == letter).sum()):
                self.skipped[what] = self.skipped.get(what, 0) + count
        curves = (
            (chunk.length(first) == 4) & (chunk.letter(first, 1) == ord("u")) & (chunk.letter(first, 3) != ord("p"))
        )
        for row in rows[curves].tolist():
            keyword = chunk.line_text(row).split()[0]
            if keyword.lower() in ("curv", "surf"):
                self.skipped["free-form curves and surfaces"] = self.skipped.get("free-form curves and surfaces", 0) + 1

    def _take_vertices(self, chunk: Chunk, rows: NDArray[np.int64]) -> None:
        short = chunk.tokens_in_line[rows] < 4
        if short.any():
            raise chunk.fail(int(rows[np.argmax(short)]), "a vertex needs three numbers; export the file again")
        self.vertices.append(chunk.floats(chunk.line_tokens(rows, 1, 3)).reshape(-1, 3))
        self.vertex_count += len(rows)

    def _take_names_and_faces(self, chunk: Chunk, rows: NDArray[np.int64], word: NDArray[np.int64]) -> None:
        faces = rows[word == ord("f")]
        sizes = chunk.tokens_in_line[faces] - 1
        index = chunk.integers(chunk.line_tokens(faces, 1, sizes), until_slash=True)
        # OBJ counts from 1; a negative index counts back from the vertices seen so far.
        seen = self.vertex_count + np.searchsorted(rows[word == ord("v")], faces)
        seen_by_corner = np.repeat(seen, sizes)
        far = np.iinfo(np.int64).max  # stays out of range, whatever the file's index was
        index = np.where(
            index > 0,
            index - 1,
            np.where(index < 0, np.where(-index <= seen_by_corner, index + seen_by_corner, far), far),
        )
        self.corners.append(index)
        self.sizes.append(sizes)
        self.lines.append(chunk.first_line + faces)
        part = np.empty(len(faces), dtype=np.int64)
        done = 0
        for row in rows[(word == ord("o")) | (word == ord("g"))].tolist():
            upto = int(np.searchsorted(faces, row))
            if upto > done:
                part[done:upto] = self._part()
                done = upto
            name = chunk.line_text(row, skip_tokens=1)
            if chunk.line_text(row)[:1].lower() == "o":
                self.object, self.group = name, ""
            else:
                self.group = name
        if done < len(faces):
            part[done:] = self._part()
        self.parts.append(part)

    def _part(self) -> int:
        return self.part_of.setdefault((self.object, self.group), len(self.part_of))


def read_obj(path: Path, progress: Progress = None) -> RawMesh:
    """Read an OBJ file. A part is one pair of object and group; its path is `object/group`."""
    reader = _Reader()
    data = path.read_bytes()
    notes = []
    if b"\\\n" in data or b"\\\r\n" in data:
        data = data.replace(b"\\\r\n", b"   ").replace(b"\\\n", b"  ")
        notes.append("lines continued with a backslash were joined: line numbers count joined lines once")
    for done, chunk in chunks_of(data, path, comments=True):
        if progress:
            progress(0.9 * done, f"reading {path.name}")
        reader.take(chunk)
    del data
    none = [np.empty(0, dtype=np.int64)]
    vertices = np.concatenate(reader.vertices or [np.empty((0, 3))])
    sizes = np.concatenate(reader.sizes or none)
    result = polygons.triangulate(np.concatenate(reader.corners or none), sizes, vertices)
    check_mesh(len(vertices), len(result.faces), len(reader.part_of), str(path))
    notes += polygons.describe(result)
    if result.thin:
        line = int(np.concatenate(reader.lines)[result.first_thin])
        notes.append(
            f"{result.thin:,} faces with fewer than three corners hold no triangle, the first is line {line:,}"
        )
    notes += [f"{count:,} {what} were skipped: only triangles collide" for what, count in reader.skipped.items()]
    parts = np.concatenate(reader.parts or none)[result.polygon]
    used, part_of_face = np.unique(parts, return_inverse=True)
    names, paths = _names([list(reader.part_of)[part] for part in used.tolist()], path)
    faces = seal_indices(result.faces, len(vertices))
    return RawMesh(vertices, faces, part_of_face.astype(np.uint32), names, paths, notes=notes)


def _names(pairs: list[tuple[str, str]], path: Path) -> tuple[list[str], list[str]]:
    """Return names and paths of the parts; one part with no name takes the file's."""
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
