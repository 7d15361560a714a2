"""Saved scenes of files that were loaded before: the cache that `load_mockup` keeps where it is asked to."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from feeler.arguments import check_path, shown
from feeler.errors import FeelerError, OptionError, WriteError
from feeler.io.files import PathLike, collect
from feeler.memory import free_memory
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.saved import SUFFIX, opened
from feeler.scene import Scene

_INPUTS = "load.inputs"
_read: ContextVar[set[str] | None] = ContextVar("feeler_files_read", default=None)


def note_read(path: Path) -> None:
    """Tells that a load reads a file beside those that it was given."""
    read = _read.get()
    if read is not None:
        read.add(str(path.resolve()))


class Cache:
    """The entry of one load in a folder of saved scenes."""

    def __init__(self, folder: PathLike, paths: PathLike | Iterable[PathLike], options: tuple[object, ...]) -> None:
        given = check_path("cache", folder, give="a folder")
        if not str(folder) or (os.path.exists(given) and not os.path.isdir(given)):
            raise OptionError(f"cache is {folder!r}: give a folder")
        self._files = sorted(str(found.path.resolve()) for found in collect(paths).files)
        key = hashlib.sha256(json.dumps([self._files, [repr(option) for option in options]]).encode("ascii"))
        stem = Path(self._files[0]).stem[:40]
        self.path = given / f"{stem}-{key.hexdigest()[:16]}{SUFFIX}"

    def find(self, progress: Progress | None) -> Mockup | None:
        """The mock-up, if it was loaded before and none of its files has changed since."""
        if not os.path.isfile(self.path):
            return None
        with suppress(FeelerError, ValueError, TypeError, OSError):  # damaged, or of another version: loaded again
            file = opened(str(self.path), True, free_memory() * 4 // 5, progress)
            inputs = json.loads(file.core.extra(_INPUTS) or b"")
            paths = [path for path, *_ in inputs]
            if inputs == _states(paths) and all(state[1:] for state in inputs) and {*self._files} <= {*paths}:
                return Mockup._of_file(file)
        return None

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Notes the files that are read meanwhile."""
        self._before = _states(self._files)
        token = _read.set(set())
        try:
            yield
            self._others = sorted(_read.get() or ())
        finally:
            _read.reset(token)

    def keep(self, mockup: Mockup) -> Mockup:
        """Saves a mock-up that was loaded while it was watched, and opens it from there. Where it cannot be saved,
        it is returned as it is, with a warning. Raises `WriteError` for a folder that cannot be made."""
        inputs = self._before + _states(path for path in self._others if path not in self._files)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise WriteError(
                f"the cache cannot be made: {error.strerror or error} ({shown(str(self.path.parent))})"
            ) from None
        try:
            Scene(mockup)._save_with(self.path, [(_INPUTS, json.dumps(inputs).encode("ascii"))])
        except WriteError as error:  # such as a full disk; the mock-up itself was loaded
            warnings.warn(f"nothing is kept in the cache: {error}", RuntimeWarning, stacklevel=4)
            return mockup
        return Mockup._of_file(opened(str(self.path), False, free_memory() * 4 // 5, None))


def _states(paths: Iterable[str]) -> list[list[object]]:
    """Of each file: its path, size, number in its file system, and the times of the last change of content and of
    anything at all. Only the path of one that cannot be asked.

    A program may set the time of the content back, as copies and archives do; the other time nobody sets. (On Windows
    that is the time when the file was made.)
    """
    found: list[list[object]] = []
    for path in paths:
        try:
            state = os.stat(path)
        except OSError:
            found.append([path])
        else:
            found.append([path, state.st_size, state.st_ino, state.st_mtime_ns, state.st_ctime_ns])
    return found
