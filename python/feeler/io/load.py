"""Loads files as mock-ups and tools."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.arguments import check_number, check_progress, check_text
from feeler.choices import UnitName, UpAxis
from feeler.errors import FeelerError, LimitError, LoadError, MeshError, OptionError
from feeler.io import axes
from feeler.io.cache import Cache
from feeler.io.files import Found, PathLike, collect
from feeler.io.gltf import shift_indices
from feeler.io.limits import check_mesh
from feeler.io.plausible import LONGEST_M, size_note
from feeler.io.raw import AT_REST, Axis, PathBook, RawMesh, joined_attributes, portion
from feeler.io.readers import Watched, read
from feeler.io.rounding import state_rounding
from feeler.io.sniff import identify
from feeler.io.step import DEFAULT_CHORD_TOLERANCE, FINEST_CHORD_TOLERANCE
from feeler.io.units import Unit, parse_unit
from feeler.memory import free_memory
from feeler.mockup import Mockup, Tool, lost_note
from feeler.progress import Progress
from feeler.saved import MAGIC, opened
from feeler.source import Source
from feeler.words import counted, plural

DEFAULT_UNIT = "mm"
"""The unit of files that do not state one (STL, OBJ, PLY, OFF), unless `unit=` is given."""

_FAILURES_SHOWN = 20


def load_mockup(
    path: PathLike | Iterable[PathLike],
    unit: UnitName | None = None,
    *,
    up: UpAxis | None = None,
    chord_tolerance: float | None = None,
    cache: PathLike | None = None,
    progress: Progress | None = None,
) -> Mockup:
    """Load one file, several, or a folder as one mock-up, in metres; its `.report` lists contents and defects.

    path             a file, a folder (with subfolders, sorted by path) or several of either. STL, OBJ, PLY, OFF, glTF
                     and GLB, 3MF, STEP and COLLADA; or one saved scene (`Scene.save`), which brings its index. Paths
                     of parts start with the file: `file/assembly/part`; a second part with the same path gets `#2`.
    unit             the unit of the numbers: "mm", "m", "in" ... By default the unit that the file states (glTF, 3MF,
                     STEP, COLLADA), else the millimetre. If given, it overrides the file's own, also the metre of
                     glTF.
    up               "x", "y" or "z": turn each file with a known other up axis so that this axis is up (glTF has y up,
                     STEP and 3MF z, COLLADA states it); `(x, y, z)` with y up becomes `(x, -z, y)` with z up. Files of
                     other formats are not turned. By default nothing is turned.
    chord_tolerance  metres, only for STEP: the largest chordal error; default 0.0001.
    cache            a folder: the mock-up is saved there with its index (`Scene.save`), and opened from there the next
                     time, unless one of its files has changed. Nothing is kept without it.
    progress         called with (fraction 0..1, stage).

    Nothing is dropped: triangles that cannot be queried are kept and counted in the report; points and lines are
    counted in its notes. A coordinate is the file's number as float64 times the unit's metres (`x * 0.001`).
    `part_colours` are the base colours of glTF's materials, unless these are all alike. `part_attributes` are texts
    that glTF, STEP, 3MF and OBJ state of parts, such as materials and layers (docs/files.md). An unreadable file in a
    folder is skipped, with a note that says why; an unreadable file that you name raises an error.

    Raises `MissingFileError`, `LoadError` (what, where, what to do), `OptionError` for the options, `LimitError` for
    files that do not fit in memory, `MeshError` if no triangle can be queried.
    """
    started = time.perf_counter()
    check_progress(progress)
    if (scene := _saved_scene(path)) is not None:
        return _of_saved(scene, unit, up, chord_tolerance, progress)
    if cache is not None:
        entry = Cache(cache, path, (unit, up, chord_tolerance))
        if (known := entry.find(progress)) is not None:
            return known
        with entry.watched():
            mockup = load_mockup(path, unit, up=up, chord_tolerance=chord_tolerance, progress=progress)
        return entry.keep(mockup)
    loaded = _load(path, unit, up, chord_tolerance, portion(progress, 0.0, 0.8))
    mockup = _checked(loaded, started, progress)
    if progress:
        progress(1.0, "loaded")
    return mockup


def load_with_nodes(
    path: PathLike, up: UpAxis | None, progress: Progress | None
) -> tuple[Mockup, list[int], Axis | None]:
    """The mock-up of a glTF file, as of `load_mockup`, the node of each part, and the file's up axis.

    For one that plays the animations: no note says that they are not. Raises `LoadError` for other files.
    """
    started = time.perf_counter()
    loaded = _load(path, None, up, None, portion(progress, 0.0, 0.8))
    if loaded.raw.nodes is None:
        raise LoadError(f"{path}: this is no glTF file, and only these have animations: export .glb or .gltf")
    loaded.notes = [note for note in loaded.notes if note != AT_REST]
    return _checked(loaded, started, progress), loaded.raw.nodes, loaded.raw.up


def _checked(loaded: _Loaded, started: float, progress: Progress | None) -> Mockup:
    raw = loaded.raw
    if progress:
        progress(0.8, "checking triangles")
    with loaded.named_in_errors():
        mockup = Mockup(raw.vertices, raw.faces, raw.part_of_face, raw.part_names, part_paths=raw.part_paths)
    mockup.part_colours = _telling(raw.colours)
    mockup._keep_attributes(raw.attributes)
    mockup.source = loaded.source(time.perf_counter() - started, mockup)
    return mockup


def load_tool(
    path: PathLike | Iterable[PathLike],
    unit: UnitName | None = None,
    *,
    name: str | None = None,
    up: UpAxis | None = None,
    chord_tolerance: float | None = None,
    progress: Progress | None = None,
) -> Tool:
    """Load a tool, in metres: the whole file moves as one, named `name` (default: the file's name), with its parts.

    Options and errors are those of `load_mockup`.
    """
    started = time.perf_counter()
    check_progress(progress)
    if (scene := _saved_scene(path)) is not None:
        label = name if name is not None else Path(scene).stem
        return Tool(_of_saved(scene, unit, up, chord_tolerance, progress), name=label)
    loaded = _load(path, unit, up, chord_tolerance, portion(progress, 0.0, 0.8))
    if progress:
        progress(0.8, "checking triangles")
    label = check_text("name", name) if name is not None else loaded.pieces[0].file.path.stem
    with loaded.named_in_errors():
        raw = loaded.raw
        tool = Tool(raw.vertices, raw.faces, label, raw.part_of_face, raw.part_names, part_paths=raw.part_paths)
    tool._keep_attributes(raw.attributes)
    tool.source = loaded.source(time.perf_counter() - started, tool)
    if progress:
        progress(1.0, "loaded")
    return tool


def check_files(path: PathLike | Iterable[PathLike]) -> None:
    """Check what `load_mockup` checks before it reads: that the files are there, in formats that feeler reads.

    Raises `MissingFileError`, `LoadError`.
    """
    if _saved_scene(path) is None:
        for file in collect(path).files:
            if file.is_named:
                identify(file.path)


def is_saved(path: PathLike | Iterable[PathLike]) -> bool:
    """Whether it is the path of a saved scene, which can be read."""
    return _saved_scene(path) is not None


def _saved_scene(path: PathLike | Iterable[PathLike]) -> str | None:
    """The path, where it is that of a saved scene."""
    given: object = path
    if isinstance(given, (list, tuple)) and len(given) == 1:
        given = given[0]
    if isinstance(given, (str, os.PathLike)):
        with contextlib.suppress(OSError, ValueError, TypeError):  # told by `collect`
            plain = os.fspath(given)
            # A pipe would keep its reader waiting.
            if isinstance(plain, str) and os.path.isfile(plain):
                with open(plain, "rb") as file:
                    return plain if file.read(len(MAGIC)) == MAGIC else None
    return None


def _of_saved(
    path: str, unit: str | None, up: str | None, chord_tolerance: float | None, progress: Progress | None
) -> Mockup:
    """The mock-up of a saved scene. A scene that is made of it takes the index from the file."""
    for name, value in (("unit", unit), ("chord_tolerance", chord_tolerance)):
        if value is not None:
            raise OptionError(
                f"{name} is {value!r}, which is for meshes, but {path} is a saved scene: give it when the scene is made"
            )
    mockup = Mockup._of_file(opened(path, True, free_memory() * 4 // 5, progress))
    if up not in (None, mockup.source.up):
        made = "without an axis" if mockup.source.up is None else f"with {mockup.source.up} up"
        raise OptionError(
            f"up is {up!r}, which is for meshes, but {path} is a scene that was saved {made}: give it when it is made"
        )
    return mockup


@dataclass
class _Piece:
    """The entry of the report for one file."""

    file: Found
    format: str
    up: Axis | None
    unit: Unit
    unit_source: str
    triangles: slice  # in the joined mesh


@dataclass
class _Loaded:
    """Files read, scaled to metres and joined."""

    raw: RawMesh
    pieces: list[_Piece]
    up: Axis | None
    chord_tolerance: float | None = None
    rounding: float = 0.0
    notes: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)

    def source(self, seconds: float, mesh: Mockup | Tool) -> Source:
        """Return the entry of the load report on the files. `mesh` is the result."""
        doubts = list(self.doubts)
        lower, upper = mesh.bounds
        if note := size_note(float(np.max(upper - lower)), [piece.unit for piece in self.pieces]):
            doubts.append(note + self._culprits(mesh, float(np.max(upper - lower))))
        if lost := lost_note(mesh):
            doubts.append(f"{lost}: export the file again")
        return Source(
            tuple(str(piece.file.path) for piece in self.pieces),
            ", ".join(dict.fromkeys(piece.format for piece in self.pieces)),
            ", ".join(dict.fromkeys(piece.unit.name for piece in self.pieces)),
            "; ".join(dict.fromkeys(piece.unit_source for piece in self.pieces)),
            seconds,
            (*doubts, *self.notes),
            self.up,
            tuple(doubts),
            self.chord_tolerance,
            self.rounding,
        )

    def _culprits(self, mesh: Mockup | Tool, length: float) -> str:
        """Return the files that are too long by themselves, if there are several."""
        if length <= LONGEST_M or len(self.pieces) == 1:
            return ""
        long = []
        for piece in self.pieces:
            used = np.unique(mesh.faces[piece.triangles])
            points = mesh.vertices[used[used < len(mesh.vertices)]]
            points = points[np.isfinite(points).all(axis=1)]
            if len(points) and np.ptp(points, axis=0).max() > LONGEST_M:
                long.append(piece.file.shown)
        return f" (by themselves too long: {axes.listed(long)})" if long else " (no file is too long by itself)"

    @contextlib.contextmanager
    def named_in_errors(self) -> Iterator[None]:
        """Put the file in front of errors of the mesh checks."""
        try:
            yield
        except MeshError as error:
            more = f" and {len(self.pieces) - 1} more files" if len(self.pieces) > 1 else ""
            raise MeshError(f"{self.pieces[0].file.path}{more}: {error}") from error


class _Notes:
    """The notes of the readers, each once, with the files it is about."""

    def __init__(self, several: bool) -> None:
        self.several = several
        self._said_by: dict[str, list[str]] = {}
        self.failures: list[tuple[str, FeelerError]] = []

    def add(self, file: Found, said: list[str]) -> None:
        for note in said:
            self._said_by.setdefault(note, []).append(file.shown)

    def left_out(self) -> list[str]:
        """Return the files that could not be read, with reasons."""
        lines = [f"left out, as it cannot be read: {error}" for _, error in self.failures[:_FAILURES_SHOWN]]
        if len(self.failures) > _FAILURES_SHOWN:
            lines.append(counted(len(self.failures) - _FAILURES_SHOWN, "more files cannot be read and were left out"))
        return lines

    def said(self) -> list[str]:
        """Return the notes of the readers."""
        return [_signed(note, names, self.several) for note, names in self._said_by.items()]


def _load(
    paths: PathLike | Iterable[PathLike],
    unit: str | None,
    up: str | None,
    chord_tolerance: float | None,
    progress: Progress | None,
) -> _Loaded:
    given = None if unit is None else parse_unit(unit)
    wanted = axes.parse_axis(up)
    _check_tolerance(chord_tolerance)
    found = collect(paths)
    said, doubted = _Notes(len(found.files) > 1), _Notes(len(found.files) > 1)
    told: list[str] = []
    sniffed: list[tuple[Found, str, int]] = []
    for file in found.files:
        with _left_out_if_it_fails(file, said, None):
            format_name, notes = identify(file.path)
            told += notes
            sniffed.append((file, format_name, file.path.stat().st_size))
    ends = np.cumsum([size for *_, size in sniffed]) / max(sum(size for *_, size in sniffed), 1)  # share of the bytes
    pieces: list[_Piece] = []
    meshes: list[RawMesh] = []
    triangles, labels = 0, PathBook()
    for number, (file, format_name, _) in enumerate(sniffed):
        watched = Watched(portion(progress, float(ends[number - 1]) if number else 0.0, float(ends[number])))
        with _left_out_if_it_fails(file, said, watched):
            raw = read(file.path, format_name, chord_tolerance, given, watched)
            if not len(raw.faces):
                points = f" (but {plural(len(raw.vertices), 'point')})" if len(raw.vertices) else ""
                said.add(file, [f"the {format_name} file holds no triangle{points}"])
            said.add(file, raw.notes)
            doubted.add(file, raw.doubts)
            if not len(raw.faces):
                continue
            state_rounding(raw, format_name)
            scale, source = _scale(raw, given, format_name)
            axes.align(raw, wanted)
            top = labels.claim_path(file.label)
            root = f"{file.label}/"
            if all(below.startswith(root) for below in raw.part_paths):  # the paths already start with the file
                raw.part_paths = [below[len(root) :] for below in raw.part_paths]
            raw.part_paths = [f"{top}/{below}" if below else top for below in raw.part_paths]
            here = slice(triangles, triangles + len(raw.faces))
            pieces.append(_Piece(file, format_name, raw.up, scale, source, here))
            meshes.append(raw)
            triangles = here.stop
    if not pieces:
        raise _no_triangle(found.files, said)
    ups = [(piece.file.shown, piece.up) for piece in pieces]
    clash, turned = axes.describe(ups, wanted)
    notes = [*found.notes, *told, *said.said(), *turned]
    if chord_tolerance is not None and all(piece.format != "STEP" for piece in pieces):
        notes.append("chord_tolerance is for STEP, and no file was STEP: it had no effect")
    common = axes.common_axis(ups, wanted)
    # The chordal errors of other formats are unknown.
    is_step = all(piece.format == "STEP" for piece in pieces)
    tolerance = (DEFAULT_CHORD_TOLERANCE if chord_tolerance is None else float(chord_tolerance)) if is_step else None
    rounding = max(raw.rounding or 0.0 for raw in meshes)
    doubts = [*said.left_out(), *doubted.said(), *clash]
    return _Loaded(_join(meshes), pieces, common, tolerance, rounding, notes, doubts)


@contextlib.contextmanager
def _left_out_if_it_fails(file: Found, said: _Notes, watched: Watched | None) -> Iterator[None]:
    """Note the error of a file in a folder; raise that of a file that the caller named."""
    try:
        yield
    except (LoadError, LimitError) as error:
        if file.is_named or (watched and watched.raised is not None):
            raise
        said.failures.append((file.shown, error))


def _no_triangle(files: list[Found], said: _Notes) -> LoadError:
    """Return the error for a load without triangles, with all notes."""
    if len(files) == 1 and said.failures:
        error = said.failures[0][1]
        return error if isinstance(error, LoadError) else LoadError(str(error))
    lines = said.left_out() + said.said()
    shown = "; ".join(lines[:_FAILURES_SHOWN]) + ("; ..." if len(lines) > _FAILURES_SHOWN else "")
    if len(files) == 1:
        return LoadError(f"{files[0].path}: {shown}; export it again with surfaces")
    return LoadError(f"{files[0].path} and {len(files) - 1} more files: none holds a triangle: {shown}")


def _signed(note: str, names: list[str], several: bool) -> str:
    """Return a note with the files it is about, if there are several files."""
    if not several:
        return note
    return f"{names[0]}: {note}" if len(names) == 1 else f"{len(names)} files, {names[0]} first: {note}"


def _check_tolerance(chord_tolerance: float | None) -> None:
    if chord_tolerance is not None:
        finest = f"metres, at least {FINEST_CHORD_TOLERANCE:g}, such as 0.0001"
        check_number("chord_tolerance", chord_tolerance, finest, least=FINEST_CHORD_TOLERANCE)


def _scale(raw: RawMesh, given: Unit | None, format_name: str) -> tuple[Unit, str]:
    """Convert the vertices to metres, in place; return (unit, its source)."""
    stated = raw.unit
    if given is not None:
        factor = given.metres / stated.metres if raw.in_metres and stated else given.metres
        source = "given" + (f", instead of the {stated.name} the file states" if stated and stated != given else "")
        unit = given
    elif stated is not None:
        factor = 1.0 if raw.in_metres else stated.metres
        source = "glTF is always in metres" if format_name == "glTF" else f"stated in the {format_name} file"
        unit = stated
    else:
        unit = parse_unit(DEFAULT_UNIT)
        factor = unit.metres
        source = f"assumed: {format_name} has no unit, and none was given"
    if factor != 1.0:
        raw.rounding = (raw.rounding or 0.0) * factor
        with np.errstate(all="ignore"):  # the mock-up counts values outside the range of float64
            raw.vertices = np.multiply(raw.vertices, factor, out=raw.vertices if raw.vertices.flags.writeable else None)
    return unit, source


def _join(pieces: list[RawMesh]) -> RawMesh:
    """Join several meshes in order, with unique part paths."""
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
    none = [np.full((len(piece.part_names), 3), np.nan) for piece in pieces]
    return RawMesh(
        np.concatenate([piece.vertices for piece in pieces]),
        np.concatenate(faces),
        np.concatenate(parts),
        names,
        paths,
        colours=np.concatenate([n if p.colours is None else p.colours for p, n in zip(pieces, none, strict=True)]),
        attributes=joined_attributes(pieces),
    )


def _telling(colours: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    """The colours of parts; None if all parts have the same or none: then distinct default colours show more."""
    if colours is None or np.isnan(colours).all():
        return None
    is_one = len(colours) > 1 and np.array_equal(colours, np.broadcast_to(colours[0], colours.shape), equal_nan=True)
    return None if is_one else colours
