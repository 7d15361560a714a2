"""OFF (Geomview), text: a line `OFF`, the counts, then vertices and polygons. Colours and normals are not used."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io import polygons
from feeler.io.limits import check_mesh
from feeler.io.raw import Progress, RawMesh, seal_indices
from feeler.io.text import Chunk, chunks_of

_KEYWORD = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(\s+BINARY)?", re.ASCII)


def read_off(path: Path, progress: Progress = None) -> RawMesh:
    """Read an OFF file as one part named after the file."""
    data = path.read_bytes()
    body, first_line, vertex_count, face_count = _read_header(path, data)
    vertices = np.empty((vertex_count, 3))
    corners: list[NDArray[np.int64]] = []
    sizes: list[NDArray[np.int64]] = []
    have_vertices = have_faces = 0
    extra = 0
    for done, chunk in chunks_of(data[body:], path, comments=True, first_line=first_line):
        if progress:
            progress(0.9 * done, f"reading {path.name}")
        rows = np.flatnonzero(chunk.tokens_in_line)
        take = rows[: vertex_count - have_vertices]
        if len(take):
            if (chunk.tokens_in_line[take] < 3).any():
                line = int(take[np.argmax(chunk.tokens_in_line[take] < 3)])
                raise chunk.fail(line, "a vertex needs three numbers; export the file again")
            vertices[have_vertices : have_vertices + len(take)] = chunk.floats(chunk.line_tokens(take, 0, 3)).reshape(
                -1, 3
            )
            have_vertices += len(take)
            rows = rows[len(take) :]
        take = rows[: face_count - have_faces]
        if len(take):
            counts = _corner_counts(chunk, take)
            sizes.append(counts)
            corners.append(chunk.integers(chunk.line_tokens(take, 1, counts)))
            have_faces += len(take)
        extra += len(rows) - len(take)
    if have_vertices < vertex_count or have_faces < face_count:
        raise LoadError(
            f"{path}: the header promises {vertex_count:,} vertices and {face_count:,} polygons, the file has "
            f"{have_vertices:,} and {have_faces:,}: it is truncated; copy or export it again"
        )
    no_rows = [np.empty(0, dtype=np.int64)]
    result = polygons.triangulate(np.concatenate(corners or no_rows), np.concatenate(sizes or no_rows), vertices)
    check_mesh(vertex_count, len(result.faces), 1, str(path))
    notes = polygons.describe(result)
    if result.thin:
        notes.append(f"{result.thin:,} polygons with fewer than three corners hold no triangle")
    if extra:
        notes.append(f"{extra:,} lines after the last polygon were ignored")
    faces = seal_indices(result.faces, vertex_count)
    return RawMesh(vertices, faces, np.zeros(len(faces), dtype=np.uint32), [path.stem], [""], notes=notes)


def _read_header(path: Path, data: bytes) -> tuple[int, int, int, int]:
    """Return (offset and line of the first line after the counts, vertices, polygons)."""
    words: list[bytes] = []
    at, line = 0, 1
    while at < len(data) and len(words) < 3:
        end = data.find(b"\n", at) + 1 or len(data)
        words += data[at:end].split(b"#", 1)[0].split()
        if words[:1] and words[0].endswith(b"OFF") and words[1:2] == [b"BINARY"]:
            raise LoadError(f"{path}: binary OFF is not read; save it as text OFF, or as PLY")
        at, line = end, line + 1
    keyword = _KEYWORD.fullmatch(words[0]) if words else None
    if keyword is None:
        raise LoadError(f"{path}, line 1: an OFF file starts with 'OFF'; this one is something else")
    if keyword[4] or keyword[5]:
        raise LoadError(f"{path}, line 1: OFF with more than three dimensions is not read; save it as plain OFF")
    try:
        vertex_count, face_count = int(words[1]), int(words[2])
    except (IndexError, ValueError):
        raise LoadError(f"{path}, line {line - 1}: the numbers of vertices and polygons are missing") from None
    # The shortest vertex is "0 0 0" and the shortest polygon "0": a count can be checked before it is believed.
    if vertex_count < 0 or face_count < 0 or 6 * vertex_count + 2 * face_count > len(data) + 1:
        raise LoadError(
            f"{path}: the header promises {vertex_count:,} vertices and {face_count:,} polygons, which do not fit into "
            f"{len(data):,} bytes: the file is damaged or truncated; export it again"
        )
    return at, line, vertex_count, face_count


def _corner_counts(chunk: Chunk, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    counts = chunk.integers(chunk.first_token[lines])
    wrong = (counts < 0) | (counts > chunk.tokens_in_line[lines] - 1)
    if wrong.any():
        line = int(lines[np.argmax(wrong)])
        raise chunk.fail(line, f"the polygon promises {int(counts[np.argmax(wrong)])} corners and the line has fewer")
    return counts
