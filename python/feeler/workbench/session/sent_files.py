"""Files that pages send, piece by piece, into a temporary folder: for another mock-up, or for a job.

Names of files come from strangers: they are names in a fresh folder, never paths.
"""

from __future__ import annotations

import shutil
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from feeler.errors import WorkbenchError
from feeler.io.sniff import COMPANIONS, EXTENSIONS
from feeler.project.layout import SUFFIX as PROJECT
from feeler.workbench.document.openings import FilePiece, SendFiles

SAVED = ".feeler"
"""Suffix of saved scenes, which may have any."""

_MOST_WAITING = 4  # announced sets of files; the oldest is dropped
_MOST_NAME_BYTES = 200
_NOT_IN_NAMES = frozenset('<>:"/\\|?*')  # of any system: a name must not be a path, and not be refused
_SPARE_BYTES = 256 << 20  # left on the disk


@dataclass(frozen=True)
class FileLimits:
    """Of the files that a page sends at a time. job_bytes: of the one for a job."""

    bytes: int = 4 << 30
    files: int = 200
    job_bytes: int = 200 << 20


@dataclass
class _Sent:
    """Announced files: their places and sizes, and how many bytes came."""

    purpose: str
    folder: Path
    paths: list[Path]
    sizes: list[int]
    came: list[int] = field(default_factory=list)


class SentFiles:
    """Thread-safe. `close` removes all files."""

    def __init__(self, limits: FileLimits | None = None, folder: Path | None = None) -> None:
        """folder: where the temporary folder is made; default the system's."""
        self.limits = limits or FileLimits()
        self._parent = folder
        self._lock = threading.RLock()
        self._root: Path | None = None
        self._sent: dict[int, _Sent] = {}
        self._next = 1
        self._kept: int | None = None
        self._is_closed = False

    def announce(self, message: SendFiles) -> int:
        """Files that are to come; the result is the number of the set. Raises `WorkbenchError`."""
        sizes = [each["bytes"] for each in message.files]
        names = self._names(message, sizes)
        with self._lock:
            if self._is_closed:
                raise WorkbenchError("the session is closed", "open", "start feeler view again")
            if self._root is None:
                self._root = Path(tempfile.mkdtemp(prefix="feeler-", dir=self._parent))
            if sum(sizes) + _SPARE_BYTES > shutil.disk_usage(self._root).free:
                raise WorkbenchError("the disk has no room for these files", "open", "free some space")
            number, self._next = self._next, self._next + 1
            folder = self._root / str(number)
            folder.mkdir()
            paths = [folder / name for name in names]
            for path in paths:
                path.touch()
            self._sent[number] = _Sent(message.purpose, folder, paths, sizes, [0] * len(paths))
            waiting = [each for each in self._sent if each != self._kept]
            for old in waiting[:-_MOST_WAITING]:
                self.drop(old)
        return number

    def take(self, message: FilePiece) -> int:
        """The next bytes of a file; the result is how many came. Raises `WorkbenchError`."""
        data = np.ascontiguousarray(message.data).tobytes()
        with self._lock:
            sent = self._known(message.files)
            if message.files == self._kept or not 0 <= message.file < len(sent.paths):
                raise WorkbenchError(f"there is no file {message.file} to send", "open", "choose the files again")
            came = sent.came[message.file] + len(data)
            if came > sent.sizes[message.file]:
                self.drop(message.files)
                raise WorkbenchError("more bytes came than were announced", "open", "choose the files again")
            sent.came[message.file] = came
            try:
                with sent.paths[message.file].open("ab") as file:
                    file.write(data)
            except OSError as error:
                self.drop(message.files)
                text = error.strerror or str(error)
                raise WorkbenchError(f"the file cannot be kept: {text}", "open", "free space on the disk") from error
        return came

    def whole(self, number: int, purpose: str) -> list[Path]:
        """The files of a set, once all of them came. Raises `WorkbenchError`."""
        with self._lock:
            sent = self._known(number)
            if sent.purpose != purpose:
                raise WorkbenchError(f"there are no files {number} for this", "open", "choose the files again")
            if sent.came != sent.sizes:
                raise WorkbenchError("not all of the files came", "open", "choose the files again")
            return sent.paths

    def read(self, number: int) -> bytes:
        """The content of the file of a job, which is dropped. Raises `WorkbenchError`."""
        with self._lock:
            (path,) = self.whole(number, "job")
            try:
                return path.read_bytes()
            finally:
                self.drop(number)

    def keep(self, number: int | None) -> None:
        """Keeps a set until another one is kept, however many are sent."""
        with self._lock:
            old, self._kept = self._kept, number
            if old is not None:
                self.drop(old)

    def drop(self, number: int) -> None:
        """Removes a set, if it is there."""
        with self._lock:
            sent = self._sent.pop(number, None)
        if sent is not None:
            shutil.rmtree(sent.folder, ignore_errors=True)

    def close(self) -> None:
        """Removes all files; a second call does nothing."""
        with self._lock:
            self._is_closed = True
            root, self._root, self._sent = self._root, None, {}
        if root is not None:
            shutil.rmtree(root, ignore_errors=True)

    def _names(self, message: SendFiles, sizes: list[int]) -> list[str]:
        """The names in the folder. Raises `WorkbenchError` for files that are not wanted."""
        if message.purpose == "job":
            if len(sizes) != 1 or not 0 <= sizes[0] <= self.limits.job_bytes:
                most = self.limits.job_bytes >> 20
                raise WorkbenchError(f"the file has more than {most} MiB", "open", "open a smaller one")
            return ["file"]
        names = [_checked(each["name"]) for each in message.files]
        if not names:
            raise WorkbenchError("no file was chosen", "open", "choose one")
        if len(names) > self.limits.files:
            raise WorkbenchError(
                f"{len(names)} files are more than {self.limits.files}", "open", "start feeler view with the folder"
            )
        if not any(Path(name).suffix.lower() in {*EXTENSIONS, SAVED} for name in names):
            known = ", ".join([*EXTENSIONS, SAVED])
            raise WorkbenchError(f"{names[0]} is in no format that feeler reads", "open", f"choose one of {known}")
        if len({name.lower() for name in names}) < len(names):
            raise WorkbenchError("two files have the same name", "open", "rename one, or open them one by one")
        if min(sizes) < 0 or sum(sizes) > self.limits.bytes:
            most_gb = self.limits.bytes / 1e9
            raise WorkbenchError(f"the files are larger than {most_gb:.3g} GB", "open", "start feeler view with them")
        return names

    def _known(self, number: int) -> _Sent:
        sent = self._sent.get(number)
        if sent is None:
            raise WorkbenchError(f"there are no files {number}", "open", "choose the files again")
        return sent


def _checked(name: str) -> str:
    """A name for a file in a fresh folder. Raises `WorkbenchError`."""
    made = "".join("_" if each in _NOT_IN_NAMES or ord(each) < 32 else each for each in name)
    try:
        size = len(made.encode())
    except UnicodeEncodeError:
        size = 0
    if not 0 < size <= _MOST_NAME_BYTES or made.strip(". ") == "":
        raise WorkbenchError("the name of a file cannot be kept", "open", f"rename it: {name[:40]!r}")
    suffix = Path(made).suffix.lower()
    if suffix == PROJECT:
        raise WorkbenchError(f"{made} is a project", "open", "start feeler view with it")
    if suffix not in {*EXTENSIONS, *COMPANIONS, SAVED}:
        known = ", ".join([*EXTENSIONS, SAVED])
        raise WorkbenchError(f"{made} is in no format that feeler reads", "open", f"choose one of {known}")
    return made
