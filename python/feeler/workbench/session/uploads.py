"""Files that pages opened, for jobs: a few, and none for longer than it is needed."""

from __future__ import annotations

import threading
from typing import IO

from feeler.errors import WorkbenchError

MOST_UPLOADS = 4
"""Files kept at once: an older one is dropped."""


class Uploads:
    """Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._files: dict[str, IO[bytes]] = {}
        self._next = 1

    def keep(self, file: IO[bytes]) -> str:
        """Takes a whole file; the result is its name for a job."""
        with self._lock:
            name = f"upload-{self._next}"
            self._next += 1
            self._files[name] = file
            while len(self._files) > MOST_UPLOADS:
                self._files.pop(next(iter(self._files))).close()
            return name

    def take(self, name: str) -> bytes:
        """The content of a file, which is dropped. Raises `WorkbenchError` if it is not there."""
        with self._lock:
            file = self._files.pop(name, None)
        if file is None:
            raise WorkbenchError(f"there is no file {name!r}", "upload", "open it again")
        with file:
            file.seek(0)
            return file.read()

    def close(self) -> None:
        """Drops all."""
        with self._lock:
            for file in self._files.values():
                file.close()
            self._files = {}
