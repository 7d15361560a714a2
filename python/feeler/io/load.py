"""Files to mock-ups and tools."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from feeler.errors import FeelerError, LoadError, MeshError, OptionError
from feeler.io.collada import read_collada
from feeler.io.files import PathLike, collect
from feeler.io.gltf import read_gltf, shift_indices
from feeler.io.limits import check_memory, check_mesh
from feeler.io.obj import read_obj
from feeler.io.off import read_off
from feeler.io.ply import read_ply
from feeler.io.raw import PathBook, Progress, RawMesh, portion, weld
from feeler.io.sniff import identify
from feeler.io.step import read_step
from feeler.io.stl import read_stl
from feeler.io.threemf import read_3mf
from feeler.io.units import Unit, parse_unit
from feeler.mockup import Mockup, Source, Tool

DEFAULT_UNIT = "mm"
"""What a number means in a file that does not say (STL, OBJ, PLY, OFF) when no `unit=` is given."""

_READERS: dict[str, Callable[[Path, Progress], RawMesh]] = {
    "STL": read_stl,
    "OBJ": read_obj,
    "PLY": read_ply,
    "OFF": read_off,
    "glTF": read_gltf,
    "3MF": read_3mf,
    "COLLADA": read_collada,
}


def load_mockup(
    path: PathLike | Iterable[PathLike],
    unit: str | None = None,
    *,
    chord_tolerance: float | None = None,
    progress: Progress = None,
) -> Mockup:
    """Load one file, several, or a folder as one mock-up, in metres; its `.report` says what was met.

    path             a file, a folder (with subfolders, sorted by path) or several of either. STL, OBJ, PLY, OFF, glTF
                     and GLB, 3MF, STEP, and COLLADA with an extra package. Each file heads the paths of its parts:
                     `file/assembly/part`; a second part of the same path gets `#2`.
    unit             what a number in the files means: "mm", "m", "in" ... By default the unit the file states (glTF,
                     3MF, STEP, COLLADA), else the millimetre. If given, it counts more than the file's own.
    chord_tolerance  metres, only for STEP: how far a triangle may be from its surface; default 0.0001.
    progress         called with (fraction 0..1, stage).

    Nothing is dropped: triangles that cannot be queried stay and are counted in the report, what is no triangle
    (points, lines) is counted in its notes. A coordinate is the file's number as float64 times the unit's metres
    (`x * 0.001`).

    Raises `MissingFileError`, `LoadError` (what, where, what to do), `OptionError` for the options, `LimitError` for
    what does not fit in memory, `MeshError` if no triangle can be queried.
    """
    started = time.perf_counter()
    loaded = _load(path, unit, chord_tolerance, portion(progress, 0.0, 0.8))
    raw = loaded.raw
    if progress:
        progress(0.8, "checking triangles")
    with loaded.named_in_errors():
        mockup = Mockup(raw.vertices, raw.faces, raw.part_of_face, raw.part_names, part_paths=raw.part_paths)
    mockup.source = loaded.source(time.perf_counter() - started)
    if progress:
        progress(1.0, "loaded")
    return mockup


def load_tool(
    path: PathLike | Iterable[PathLike],
    unit: str | None = None,
    *,
    name: str | None = None,
    chord_tolerance: float | None = None,
    progress: Progress = None,
) -> Tool:
    """Load a tool, in metres: all triangles of the file as one body, called `name` (default: the file's name).

    Options and errors are those of `load_mockup`.
    """
    started = time.perf_counter()
    loaded = _load(path, unit, chord_tolerance, portion(progress, 0.0, 0.8))
    if progress:
        progress(0.8, "checking triangles")
    label = name if name is not None else Path(loaded.files[0]).stem
    with loaded.named_in_errors():
        tool = Tool(loaded.raw.vertices, loaded.raw.faces, label)
    tool.source = loaded.source(time.perf_counter() - started)
    if progress:
        progress(1.0, "loaded")
    return tool


@dataclass
class _Loaded:
    """Files read, scaled to metres and joined."""

    raw: RawMesh
    files: list[str]
    format: str
    unit: str
    unit_source: str

    def source(self, seconds: float) -> Source:
        """Return what the load report tells about the files."""
        return Source(tuple(self.files), self.format, self.unit, self.unit_source, seconds, tuple(self.raw.notes))

    @contextlib.contextmanager
    def named_in_errors(self) -> Iterator[None]:
        """Put the file in front of what the mesh checks say."""
        try:
            yield
        except MeshError as error:
            more = f" and {len(self.files) - 1} more files" if len(self.files) > 1 else ""
            raise MeshError(f"{self.files[0]}{more}: {error}") from error


def _load(
    paths: PathLike | Iterable[PathLike], unit: str | None, chord_tolerance: float | None, progress: Progress
) -> _Loaded:
    given = None if unit is None else parse_unit(unit)
    _check_tolerance(chord_tolerance)
    found = collect(paths)
    sniffed = [(path, label, *identify(path)) for path, label in found.files]
    sizes = np.cumsum([0, *(path.stat().st_size for path, *_ in sniffed)])
    sizes = sizes / sizes[-1]  # share of the bytes before each file
    notes = list(found.notes)
    pieces: list[RawMesh] = []
    units: list[tuple[str, str]] = []
    formats: list[str] = []
    files: list[str] = []
    said_by: dict[str, list[str]] = {}
    labels = PathBook()
    for number, (path, label, format_name, told) in enumerate(sniffed):
        share = portion(progress, float(sizes[number]), float(sizes[number + 1]))
        raw = _read(path, format_name, chord_tolerance, given, share)
        notes += told
        for note in raw.notes:
            said_by.setdefault(note, []).append(path.name)
        if not len(raw.faces):
            if len(sniffed) == 1:
                raise LoadError(f"{path}: the {format_name} file holds no triangle; export it again with surfaces")
            notes.append(f"{path.name}: the file holds no triangle and adds nothing")
            continue
        units.append(_scale(raw, given, format_name))
        top = labels.claim_path(label)
        raw.part_paths = [f"{top}/{below}" if below else top for below in raw.part_paths]
        pieces.append(raw)
        formats.append(format_name)
        files.append(str(path))
    notes += [_signed(note, names, len(sniffed)) for note, names in said_by.items()]
    if not pieces:
        raise LoadError(f"{sniffed[0][0]} and {len(sniffed) - 1} more files: none holds a triangle; export them again")
    if chord_tolerance is not None and "STEP" not in formats:
        notes.append("chord_tolerance is for STEP, and no file was STEP: it had no effect")
    joined = _join(pieces)
    joined.notes = notes
    return _Loaded(
        joined,
        files,
        ", ".join(dict.fromkeys(formats)),
        ", ".join(dict.fromkeys(name for name, _ in units)),
        "; ".join(dict.fromkeys(source for _, source in units)),
    )


def _signed(note: str, names: list[str], file_count: int) -> str:
    """Return a note with the files it is about, where there is more than one file."""
    if file_count == 1:
        return note
    return f"{names[0]}: {note}" if len(names) == 1 else f"{len(names)} files, {names[0]} first: {note}"


def _check_tolerance(chord_tolerance: float | None) -> None:
    if chord_tolerance is None:
        return
    tolerance: object = chord_tolerance
    good = isinstance(tolerance, (int, float, np.floating, np.integer)) and not isinstance(tolerance, bool)
    if not good or not math.isfinite(chord_tolerance) or chord_tolerance <= 0:
        raise OptionError(f"chord_tolerance={chord_tolerance!r} should be a positive number of metres, such as 0.0001")


def _read(
    path: Path, format_name: str, chord_tolerance: float | None, given: Unit | None, progress: Progress
) -> RawMesh:
    """Read one file. Whatever goes wrong in a reader or library leaves here as a `FeelerError`, with its cause."""
    watched = _Watched(progress)
    progress = watched if progress else None
    try:
        check_memory(2 * path.stat().st_size, str(path))
        if format_name == "STEP":
            tolerance = None if chord_tolerance is None else float(chord_tolerance)
            return read_step(path, progress, chord_tolerance=tolerance, given=given)
        raw = _READERS[format_name](path, progress)
    except FeelerError:
        raise
    except Exception as error:
        if error is watched.raised:
            raise  # the caller's own, to stop the load
        raise _as_load_error(path, format_name, error) from error
    if len(raw.vertices) > len(raw.faces) and format_name != "STL":
        # A closed mesh has about half as many vertices as triangles; here every triangle has its own (STL is welded).
        raw.vertices, raw.faces = weld(raw.vertices, raw.faces)
    return raw


def _as_load_error(path: Path, format_name: str, error: Exception) -> LoadError:
    """Return what to tell of an error that a reader or library did not foresee."""
    if isinstance(error, OSError):
        return LoadError(f"{path}: cannot be read ({error.strerror or error}); check the file and its permissions")
    if isinstance(error, MemoryError):
        return LoadError(f"{path}: there is not enough memory to read this file; load fewer or coarser files")
    what = f"{type(error).__name__}: {error}"[:200]
    return LoadError(
        f"{path}: this {format_name} file is damaged in a way that was not foreseen ({what}); export it again"
    )


class _Watched:
    """A progress callable that remembers what the caller's raised, so that it is not taken for a damaged file."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self.raised: Exception | None = None

    def __call__(self, fraction: float, stage: str) -> None:
        try:
            if self._progress:
                self._progress(fraction, stage)
        except Exception as error:
            self.raised = error
            raise


def _scale(raw: RawMesh, given: Unit | None, format_name: str) -> tuple[str, str]:
    """Bring the vertices to metres, in place; return (unit, where it came from)."""
    stated = raw.unit
    if given is not None:
        factor = given.metres / stated.metres if raw.in_metres and stated else given.metres
        source = "given by unit=" + (
            f", instead of the {stated.name} the file states" if stated and stated != given else ""
        )
        unit = given
    elif stated is not None:
        factor = 1.0 if raw.in_metres else stated.metres
        source = "glTF is always in metres" if format_name == "glTF" else f"stated in the {format_name} file"
        unit = stated
    else:
        unit = parse_unit(DEFAULT_UNIT)
        factor = unit.metres
        source = f"assumed: {format_name} has no unit and none was given by unit="
    if factor != 1.0:
        with np.errstate(all="ignore"):  # what leaves the range of float64 is counted by the mock-up
            raw.vertices = np.multiply(raw.vertices, factor, out=raw.vertices if raw.vertices.flags.writeable else None)
    return unit.name, source


def _join(pieces: list[RawMesh]) -> RawMesh:
    """Return several meshes in one, in order, with unique part paths."""
    if len(pieces) == 1:
        return pieces[0]
    check_mesh(
        sum(len(p.vertices) for p in pieces),
        sum(len(p.faces) for p in pieces),
        sum(len(p.part_names) for p in pieces),
        "all files together",
    )
    faces, parts, names, paths = [], [], [], []
    book = PathBook()
    vertex_base = part_base = 0
    for piece in pieces:
        faces.append(shift_indices(piece.faces, vertex_base, len(piece.vertices)))
        parts.append(piece.part_of_face + np.uint32(part_base))
        vertex_base += len(piece.vertices)
        part_base += len(piece.part_names)
        names += piece.part_names
        paths += [book.claim_path(path) for path in piece.part_paths]
    return RawMesh(
        np.concatenate([piece.vertices for piece in pieces]), np.concatenate(faces), np.concatenate(parts), names, paths
    )
