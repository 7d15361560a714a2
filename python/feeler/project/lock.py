"""Who writes a project: one process at a time, which a file beside the project names.

The operating system keeps the lock and gives it back when the process ends, however it ends: no lock is ever stale. The
text in the file only tells others who has it.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
import sys
import time
import weakref
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from feeler.errors import ProjectError, WriteError

ENDING = "-lock"
_MOST_BYTES = 4096
_LOCKED_BYTE = 1 << 30  # behind the text, which Windows would lock otherwise
_TRIES = 10


@dataclass(frozen=True)
class Holder:
    """The process that writes a project. since: ISO 8601, UTC."""

    pid: int
    host: str
    since: str

    def __str__(self) -> str:
        """In words."""
        return f"process {self.pid} on {self.host}, since {self.since}"


def _this() -> Holder:
    return Holder(os.getpid(), socket.gethostname(), datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC"))


class Lock:
    """The lock of a project, until `release`. Raises `ProjectError` if another has it, and `WriteError`."""

    def __init__(self, project: Path) -> None:
        self._path = _beside(project)
        for _ in range(_TRIES):
            self._file = self._opened(project)
            if not _locked(self._file):
                there = holder(project)
                os.close(self._file)
                who = str(there) if there is not None else "another process"
                raise ProjectError(
                    f"{project} is open in {who}: close it there, or open it read-only (--read-only, read_only=True)"
                )
            # Its last owner may have deleted the file after it was opened here and before it was locked.
            if self._is_ours():
                break
            os.close(self._file)
        else:
            raise ProjectError(f"{project} is being opened by other processes: try again")
        holding = _this()
        text = json.dumps({"pid": holding.pid, "host": holding.host, "since": holding.since}).encode()
        with contextlib.suppress(OSError):  # a full disk: the lock holds without its text
            os.ftruncate(self._file, 0)
            os.write(self._file, text)
        _held.add(self)

    def _opened(self, project: Path) -> int:
        try:
            flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
            return os.open(self._path, flags, 0o644)
        except OSError as error:
            raise WriteError(
                f"cannot write {project}: {self._path.name} cannot be made beside it ({error.strerror or error}); "
                "open it read-only, or copy it to another folder"
            ) from None

    def _is_ours(self) -> bool:
        if os.name == "nt":
            return True  # an open file cannot be deleted there
        try:
            there = os.stat(self._path)
        except FileNotFoundError:
            return False
        here = os.fstat(self._file)
        return (there.st_ino, there.st_dev) == (here.st_ino, here.st_dev)

    def release(self) -> None:
        """Gives it back; a second call does nothing."""
        if self._file < 0:
            return
        _held.discard(self)
        if os.name != "nt":
            with contextlib.suppress(OSError):
                os.unlink(self._path)
        self._forget()
        if os.name == "nt":
            with contextlib.suppress(OSError):
                os.unlink(self._path)

    def _forget(self) -> None:
        file, self._file = self._file, -1
        with contextlib.suppress(OSError):
            os.close(file)


def _beside(project: Path) -> Path:
    """The file of the lock: one for all names of a project that are symbolic links."""
    real = Path(os.path.realpath(project))
    return real.with_name(real.name + ENDING)


def holder(project: Path) -> Holder | None:
    """Who writes a project, by the file beside it; None if that cannot be said."""
    path = _beside(project)
    for _ in range(_TRIES):
        try:
            with open(path, "rb") as file:
                told = json.loads(file.read(_MOST_BYTES))
            return Holder(int(told["pid"]), str(told["host"])[:100], str(told["since"])[:40])
        except (ValueError, TypeError, KeyError, RecursionError):
            time.sleep(0.01)  # it has just been made, and is still empty
        except OSError:
            return None
    return None


if sys.platform == "win32":
    import msvcrt

    def _locked(file: int) -> bool:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            os.lseek(file, 0, os.SEEK_SET)
        return True

else:
    import fcntl

    def _locked(file: int) -> bool:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            # A disk without locks: the project's own count of its openings still refuses a second writer's changes.
            return error.errno not in (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)
        return True


_held: weakref.WeakSet[Lock] = weakref.WeakSet()


def _forget_all() -> None:
    """In a forked child: the lock stays with the parent, and ends with it."""
    for lock in list(_held):
        lock._forget()
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_all)
