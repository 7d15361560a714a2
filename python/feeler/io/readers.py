"""The reader of each format. It returns a mesh, or raises a `FeelerError` or the error of the caller's progress."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from feeler.errors import FeelerError, LoadError
from feeler.io.collada import read_collada
from feeler.io.gltf import read_gltf
from feeler.io.limits import check_memory
from feeler.io.obj import read_obj
from feeler.io.off import read_off
from feeler.io.ply import read_ply
from feeler.io.raw import RawMesh, weld
from feeler.io.step import read_step
from feeler.io.stl import read_stl
from feeler.io.threemf import read_3mf
from feeler.io.units import Unit
from feeler.progress import Progress

_READERS: dict[str, Callable[[Path, Progress | None], RawMesh]] = {
    "STL": read_stl,
    "OBJ": read_obj,
    "PLY": read_ply,
    "OFF": read_off,
    "glTF": read_gltf,
    "3MF": read_3mf,
    "COLLADA": read_collada,
}


class Watched:
    """A progress callable that remembers errors of the caller's, so that they do not count as a damaged file."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress = progress
        self.raised: Exception | None = None

    def __call__(self, fraction: float, stage: str) -> None:
        """Report the progress."""
        try:
            if self._progress:
                self._progress(fraction, stage)
        except Exception as error:
            self.raised = error
            raise


def read(path: Path, format_name: str, chord_tolerance: float | None, given: Unit | None, watched: Watched) -> RawMesh:
    """Read one file. Every error of a reader or library becomes a `FeelerError` with its cause."""
    try:
        check_memory(2 * path.stat().st_size, str(path))
        if format_name == "STEP":
            tolerance = None if chord_tolerance is None else float(chord_tolerance)
            return read_step(path, watched, chord_tolerance=tolerance, given=given)
        raw = _READERS[format_name](path, watched)
    except FeelerError:
        raise
    except Exception as error:
        if error is watched.raised:
            raise  # the caller's own error, to stop the load
        raise _as_load_error(path, format_name, error) from error
    if watched.raised is not None:
        raise watched.raised  # a reader took it for a defect of the file, and read on
    if len(raw.vertices) > len(raw.faces) and format_name != "STL":
        # A closed mesh has about half as many vertices as triangles; here every triangle has its own (STL is welded).
        raw.vertices, raw.faces = weld(raw.vertices, raw.faces)
    return raw


def _as_load_error(path: Path, format_name: str, error: Exception) -> LoadError:
    """Return the text for an unexpected error of a reader or library."""
    if isinstance(error, OSError):
        return LoadError(f"{path}: cannot be read ({error.strerror or error}); check the file and its permissions")
    if isinstance(error, MemoryError):
        return LoadError(f"{path}: there is not enough memory to read this file; load fewer or coarser files")
    what = f"{type(error).__name__}: {error}"[:200]
    return LoadError(
        f"{path}: this {format_name} file is damaged in a way that was not foreseen ({what}); export it again"
    )
