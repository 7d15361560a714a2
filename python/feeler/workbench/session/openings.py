"""Opening another mock-up from a page: files that it sent, or a sample.

Who started the workbench offers an opener, which loads as `feeler view FILE` does. Without one nothing can be opened.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from feeler.arguments import near
from feeler.choices import SAMPLE_NAMES
from feeler.errors import WorkbenchError
from feeler.io.sniff import COMPANIONS, EXTENSIONS
from feeler.workbench.document.openings import FilePiece, OpeningRequest, OpenMockup, Opens, SendFiles
from feeler.workbench.session.sent_files import SAVED, FileLimits, SentFiles


@dataclass(frozen=True)
class Wanted:
    """A mock-up to open. sources: files, or "sample:NAME"; None: the present one. unit: of the files, None: theirs."""

    sources: tuple[str, ...] | None
    unit: str | None = None


Opener = Callable[[Wanted], bool]
"""Opens it, and tells the session of progress and failure. Returns whether it is open."""


class Openings:
    """Thread-safe. `close` removes all files."""

    def __init__(
        self,
        limits: FileLimits | None = None,
        folder: Path | None = None,
        tell: Callable[[str], object] = lambda _text: None,
    ) -> None:
        """folder: where the temporary folder is made; default the system's. tell: says something to all pages."""
        self._tell = tell
        self.files = SentFiles(limits, folder)
        """The files that pages sent."""
        self._lock = threading.Lock()
        self._opener: Opener | None = None
        self._is_opening = False
        self._is_closed = False

    def offer(self, opener: Opener) -> None:
        """Lets pages open mock-ups."""
        self._opener = opener

    def begin(self, work: Callable[[], object]) -> None:
        """Opens the mock-up that the workbench was started with, in a thread; pages open another one after it."""
        with self._lock:
            self._is_opening = True
        _start(self._first, work)

    def facts(self) -> Opens | None:
        """What pages may open; None: nothing."""
        if self._opener is None:
            return None
        return {
            "formats": [*EXTENSIONS, SAVED],
            "companions": sorted(COMPANIONS),
            "samples": list(SAMPLE_NAMES),
            "most_bytes": self.files.limits.bytes,
            "most_files": self.files.limits.files,
        }

    def request(self, message: OpeningRequest, by: str | None = None) -> dict[str, Any]:
        """Carries out a page's message. Raises `WorkbenchError`.

        by: the name of its person, if others are there: they are told who opens what.
        """
        match message:
            case SendFiles():
                if message.purpose == "open":
                    self._offered()
                return {"files": self.files.announce(message)}
            case FilePiece():
                return {"bytes": self.files.take(message)}
            case OpenMockup():
                self._begin(message, self._offered(), by)
                return {}

    def close(self) -> None:
        """Removes all files; a second call does nothing."""
        self._is_closed = True
        self.files.close()

    def _offered(self) -> Opener:
        if self._opener is None or self._is_closed:
            raise WorkbenchError("no other mock-up can be opened here", "open", "start feeler view with it")
        return self._opener

    def _begin(self, message: OpenMockup, opener: Opener, by: str | None) -> None:
        with self._lock:
            wanted = self._wanted(message)
            if self._is_opening:
                raise WorkbenchError("a mock-up is being opened", "open", "wait until it is there")
            self._is_opening = True
        if by is not None:
            self._tell(f"{by} {_what(wanted)}")
        _start(self._run, wanted, message.files, opener)

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
        return Wanted(_meshes(self.files.whole(message.files, "open")), message.unit)

    def _first(self, work: Callable[[], object]) -> None:
        try:
            work()
        finally:
            with self._lock:
                self._is_opening = False

    def _run(self, wanted: Wanted, number: int | None, opener: Opener) -> None:
        is_open = False
        try:
            is_open = opener(wanted)
        finally:
            with self._lock, contextlib.suppress(OSError):
                self._is_opening = False
                if is_open and wanted.sources is not None:
                    # The files of the mock-up that is open stay, for another unit.
                    self.files.keep(number)
                elif not is_open and number is not None:
                    self.files.drop(number)


def _start(work: Callable[..., object], *args: object) -> None:
    # A daemon thread, so that Ctrl-C does not wait for a large file.
    threading.Thread(target=work, args=args, name="feeler opening", daemon=True).start()


def _what(wanted: Wanted) -> str:
    """What somebody does, for others."""
    if wanted.sources is None:
        return f"loads the mock-up again, unit {wanted.unit}" if wanted.unit else "loads the mock-up again"
    first, *others = (Path(source).name.removeprefix("sample:") for source in wanted.sources)
    is_sample = wanted.sources[0].startswith("sample:")
    more = f" and {len(others)} more" if others else ""
    return f"opens {'the sample ' if is_sample else ''}{first}{more}"


def _meshes(paths: Sequence[Path]) -> tuple[str, ...]:
    """The files to load; the others lie beside them, where these look for them."""
    return tuple(str(path) for path in paths if path.suffix.lower() in {*EXTENSIONS, SAVED})
