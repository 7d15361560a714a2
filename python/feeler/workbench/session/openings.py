"""Opening another mock-up from a page: files that it sends, into a temporary folder, or a sample.

Who started the workbench offers an opener, which loads as `feeler view FILE` does. Without one nothing can be opened.
Names of files come from strangers: they are names in a fresh folder, never paths.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from feeler.arguments import near
from feeler.choices import SAMPLE_NAMES
from feeler.errors import WorkbenchError
from feeler.io.sniff import COMPANIONS, EXTENSIONS
from feeler.workbench.document.openings import FilePiece, OpeningRequest, OpenMockup, Opens, SendFiles

SAVED = ".feeler"
"""Suffix of saved scenes, which may have any."""

_MOST_WAITING = 4  # announced sets of files; the oldest is dropped
_MOST_NAME_BYTES = 200
_NOT_IN_NAMES = frozenset('<>:"/\\|?*')  # of any system: a name must not be a path, and not be refused
_SPARE_BYTES = 256 << 20  # left on the disk


@dataclass(frozen=True)
class Wanted:
    """A mock-up to open. sources: files, or "sample:NAME"; None: the present one. unit: of the files, None: theirs."""

    sources: tuple[str, ...] | None
    unit: str | None = None


Opener = Callable[[Wanted], bool]
"""Opens it, and tells the session of progress and failure. Returns whether it is open."""


@dataclass(frozen=True)
class OpeningLimits:
    """Of the files that a page sends at a time."""

    bytes: int = 4 << 30
    files: int = 200


@dataclass
class _Sent:
    """Announced files: their places and sizes, and how many bytes came."""

    folder: Path
    paths: list[Path]
    sizes: list[int]
    came: list[int] = field(default_factory=list)


class Openings:
    """Thread-safe. `close` removes all files."""

    def __init__(self, limits: OpeningLimits | None = None, folder: Path | None = None) -> None:
        """folder: where the temporary folder is made; default the system's."""
        self._limits = limits or OpeningLimits()
        self._parent = folder
        self._lock = threading.Lock()
        self._opener: Opener | None = None
        self._root: Path | None = None
        self._sent: dict[int, _Sent] = {}
        self._next = 1
        self._open: int | None = None
        self._is_opening = False
        self._is_closed = False

    def offer(self, opener: Opener) -> None:
        """Lets pages open mock-ups."""
        self._opener = opener

    def facts(self) -> Opens | None:
        """What pages may open; None: nothing."""
        if self._opener is None:
            return None
        return {
            "formats": [*EXTENSIONS, SAVED],
            "companions": sorted(COMPANIONS),
            "samples": list(SAMPLE_NAMES),
            "most_bytes": self._limits.bytes,
            "most_files": self._limits.files,
        }

    def request(self, message: OpeningRequest) -> dict[str, Any]:
        """Carries out a page's message. Raises `WorkbenchError`."""
        opener = self._opener
        if opener is None or self._is_closed:
            raise WorkbenchError("no other mock-up can be opened here", "open", "start feeler view with it")
        match message:
            case SendFiles():
                return {"files": self._announce(message)}
            case FilePiece():
                return {"bytes": self._take(message)}
            case OpenMockup():
                self._begin(message, opener)
                return {}

    def close(self) -> None:
        """Removes all files; a second call does nothing."""
        with self._lock:
            self._is_closed = True
            root, self._root, self._sent = self._root, None, {}
        if root is not None:
            shutil.rmtree(root, ignore_errors=True)

    # ---- files ----

    def _announce(self, message: SendFiles) -> int:
        names = [_checked(each["name"]) for each in message.files]
        sizes = [each["bytes"] for each in message.files]
        if not names:
            raise WorkbenchError("no file was chosen", "open", "choose one")
        if len(names) > self._limits.files:
            raise WorkbenchError(
                f"{len(names)} files are more than {self._limits.files}", "open", "start feeler view with the folder"
            )
        if not any(Path(name).suffix.lower() in {*EXTENSIONS, SAVED} for name in names):
            known = ", ".join([*EXTENSIONS, SAVED])
            raise WorkbenchError(f"{names[0]} is in no format that feeler reads", "open", f"choose one of {known}")
        if len({name.lower() for name in names}) < len(names):
            raise WorkbenchError("two files have the same name", "open", "rename one, or open them one by one")
        if min(sizes) < 0 or sum(sizes) > self._limits.bytes:
            most = self._limits.bytes / 1e9
            raise WorkbenchError(f"the files are larger than {most:.3g} GB", "open", "start feeler view with them")
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
            self._sent[number] = _Sent(folder, paths, sizes, [0] * len(paths))
            waiting = [each for each in self._sent if each != self._open]
            for old in waiting[:-_MOST_WAITING]:
                self._drop(old)
        return number

    def _take(self, message: FilePiece) -> int:
        data = np.ascontiguousarray(message.data).tobytes()
        with self._lock:
            sent = self._known(message.files)
            if message.files == self._open or not 0 <= message.file < len(sent.paths):
                raise WorkbenchError(f"there is no file {message.file} to send", "open", "choose the files again")
            came = sent.came[message.file] + len(data)
            if came > sent.sizes[message.file]:
                self._drop(message.files)
                raise WorkbenchError("more bytes came than were announced", "open", "choose the files again")
            sent.came[message.file] = came
            try:
                with sent.paths[message.file].open("ab") as file:
                    file.write(data)
            except OSError as error:
                self._drop(message.files)
                text = error.strerror or str(error)
                raise WorkbenchError(f"the file cannot be kept: {text}", "open", "free space on the disk") from error
        return came

    def _known(self, number: int) -> _Sent:
        sent = self._sent.get(number)
        if sent is None:
            raise WorkbenchError(f"there are no files {number}", "open", "choose the files again")
        return sent

    def _drop(self, number: int) -> None:
        sent = self._sent.pop(number, None)
        if sent is not None:
            shutil.rmtree(sent.folder, ignore_errors=True)

    # ---- opening ----

    def _begin(self, message: OpenMockup, opener: Opener) -> None:
        with self._lock:
            wanted = self._wanted(message)
            if self._is_opening:
                raise WorkbenchError("a mock-up is being opened", "open", "wait until it is there")
            self._is_opening = True
        work = (wanted, message.files, opener)
        threading.Thread(target=self._run, args=work, name="feeler opening", daemon=True).start()

    def _wanted(self, message: OpenMockup) -> Wanted:
        if message.files is not None and message.sample is not None:
            raise WorkbenchError("files and a sample are given", "open", "choose one")
        if message.sample is not None:
            if message.sample not in SAMPLE_NAMES:
                raise WorkbenchError(
                    f"there is no sample {message.sample!r}", "open", near(message.sample, SAMPLE_NAMES)
                )
            return Wanted((f"sample:{message.sample}",))
        if message.files is None:
            return Wanted(None, message.unit)
        sent = self._known(message.files)
        if sent.came != sent.sizes:
            raise WorkbenchError("not all of the files came", "open", "choose the files again")
        return Wanted(_meshes(sent.paths), message.unit)

    def _run(self, wanted: Wanted, number: int | None, opener: Opener) -> None:
        is_open = False
        try:
            is_open = opener(wanted)
        finally:
            with self._lock, contextlib.suppress(OSError):
                self._is_opening = False
                if is_open and wanted.sources is not None:
                    # The files of the mock-up that is open stay, for another unit.
                    old, self._open = self._open, number
                    if old is not None:
                        self._drop(old)
                elif not is_open and number is not None:
                    self._drop(number)


def _meshes(paths: Sequence[Path]) -> tuple[str, ...]:
    """The files to load; the others lie beside them, where these look for them."""
    return tuple(str(path) for path in paths if path.suffix.lower() in {*EXTENSIONS, SAVED})


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
    if suffix not in {*EXTENSIONS, *COMPANIONS, SAVED}:
        known = ", ".join([*EXTENSIONS, SAVED])
        raise WorkbenchError(f"{made} is in no format that feeler reads", "open", f"choose one of {known}")
    return made
