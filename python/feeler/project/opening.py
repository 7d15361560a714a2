"""Connections to project files, which may come from strangers.

Nothing that a file contains is executed. Its tables must be exactly ours, so it has no triggers, views, computed
columns or virtual tables. SQLite trusts no schema, attaches no file, and runs our own kinds of statements only.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sqlite3
import stat
from pathlib import Path
from urllib.parse import quote

from feeler.errors import FeelerError, LoadError, MissingFileError, WriteError
from feeler.project import layout
from feeler.project.migrations import migrate

_WAIT_S = 5.0
"""For another connection: readers hold a project for milliseconds."""

_LIMITS = {
    "SQLITE_LIMIT_ATTACHED": 0,
    "SQLITE_LIMIT_LENGTH": max(layout.MOST_TEXT, layout.MOST_DATA) + 4096,
    "SQLITE_LIMIT_SQL_LENGTH": 100_000,
    "SQLITE_LIMIT_COLUMN": 100,
    "SQLITE_LIMIT_EXPR_DEPTH": 50,
    "SQLITE_LIMIT_COMPOUND_SELECT": 10,
    "SQLITE_LIMIT_FUNCTION_ARG": 10,
    "SQLITE_LIMIT_TRIGGER_DEPTH": 1,
    "SQLITE_LIMIT_LIKE_PATTERN_LENGTH": 100,
}
_CONFIGURATION = {
    "SQLITE_DBCONFIG_DEFENSIVE": True,
    "SQLITE_DBCONFIG_TRUSTED_SCHEMA": False,
    "SQLITE_DBCONFIG_ENABLE_TRIGGER": False,
    "SQLITE_DBCONFIG_ENABLE_VIEW": False,
}
_ALLOWED = {
    sqlite3.SQLITE_SELECT,
    sqlite3.SQLITE_READ,
    sqlite3.SQLITE_INSERT,
    sqlite3.SQLITE_UPDATE,
    sqlite3.SQLITE_DELETE,
    sqlite3.SQLITE_TRANSACTION,
}
_FUNCTIONS = {"count", "coalesce", "length", "max"}
_PRAGMAS = {"max_page_count"}
_CHECKED_BYTES = 256 << 20  # of files: larger ones are checked row by row, as they are read


def connect(path: Path, *, read_only: bool) -> sqlite3.Connection:
    """Opens an existing project, checked. Raises `MissingFileError`, `LoadError`, `WriteError`."""
    size = check_file(path)
    if size > layout.MOST_FILE_BYTES:
        raise LoadError(f"{path} has {size:,} bytes, and a project has at most {layout.MOST_FILE_BYTES:,}")
    try:
        return _connect(path, size, "ro" if read_only else "rw", read_only)
    except _CannotOpenError:
        # A folder that nobody may write: SQLite cannot share memory there, and nobody changes the file either.
        if read_only and not _has_wal(path):
            with contextlib.suppress(_CannotOpenError):
                return _connect(path, size, "ro&immutable=1", read_only)
        what = "read" if read_only else "written"
        raise (LoadError if read_only else WriteError)(
            f"{path} cannot be {what}: check the permissions of the file and of its folder"
        ) from None


class _CannotOpenError(Exception):
    pass


def _connect(path: Path, size: int, mode: str, read_only: bool) -> sqlite3.Connection:
    try:
        found = sqlite3.connect(
            f"file:{quote(_absolute(path))}?mode={mode}",
            timeout=_WAIT_S,
            isolation_level=None,
            check_same_thread=False,
            uri=True,
        )
    except sqlite3.Error:
        raise _CannotOpenError from None
    try:
        _harden(found)
        version = check(found, path)
        if size <= _CHECKED_BYTES:
            (said,) = found.execute("PRAGMA integrity_check(1)").fetchone()
            if said != "ok":
                raise LoadError(f"{path} is damaged ({str(said).splitlines()[-1]:.120}): use a copy")
        if version < layout.VERSION:
            if read_only:
                found = _copied(found, path, size)
            _migrate(found, path, version)
        found.execute("PRAGMA query_only = ON" if read_only else "PRAGMA synchronous = FULL")
        if not read_only:
            # Readers do not wait for the writer, and a commit is one append.
            (mode,) = found.execute("PRAGMA journal_mode = WAL").fetchone()
            if mode != "wal":
                found.execute("PRAGMA journal_mode = DELETE")  # a disk that cannot share memory
        found.set_authorizer(_authorize)
    except (sqlite3.Error, UnicodeError) as error:  # names in a damaged schema are decoded, too
        found.close()
        if "unable to open" in str(error) or "readonly" in str(error):
            raise _CannotOpenError from None
        raise refusal(path, error) from None
    except BaseException:
        found.close()
        raise
    return found


def _harden(connection: sqlite3.Connection) -> None:
    for name, most in _LIMITS.items():
        if hasattr(connection, "setlimit"):  # Python 3.11
            connection.setlimit(getattr(sqlite3, name), most)
    if hasattr(connection, "setconfig"):  # Python 3.12
        for name, is_on in _CONFIGURATION.items():
            connection.setconfig(getattr(sqlite3, name), is_on)
    for pragma in ("trusted_schema = OFF", "cell_size_check = ON", "mmap_size = 0", "foreign_keys = OFF"):
        connection.execute(f"PRAGMA {pragma}")


def check(connection: sqlite3.Connection, path: Path) -> int:
    """The version of a project's layout. Raises `LoadError` for a file that is no project, or has strange tables."""
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if application != layout.APPLICATION_ID:
        raise LoadError(f"{path} is not a project of feeler: give a file of feeler view --project")
    if version > layout.VERSION:
        raise LoadError(
            f"{path} has layout {version}, and this feeler reads layouts up to {layout.VERSION}: use a newer feeler"
        )
    if version < 1:
        raise LoadError(f"{path} is damaged: layout {version} does not exist; use a copy")
    there, expected = layout.schema_of(connection), layout.schema(version)
    if there != expected:
        strange = sorted(f"{kind} {name}" for kind, name, *_ in there - expected)
        missing = sorted(f"{kind} {name}" for kind, name, *_ in expected - there)
        what = f"it has a strange {strange[0]!r:.80}" if strange else f"it lacks {missing[0]!r:.80}"
        raise LoadError(f"{path} is damaged, or was changed by another program: {what}; use a copy")
    return int(version)


def _migrate(connection: sqlite3.Connection, path: Path, version: int) -> None:
    try:
        migrate(connection, version, layout.VERSION)
    except LoadError as error:
        raise LoadError(f"{path}: {error}") from None


def _copied(connection: sqlite3.Connection, path: Path, size: int) -> sqlite3.Connection:
    """A project of an older layout in memory, where it can be migrated without writing the file."""
    if size > _CHECKED_BYTES:
        raise LoadError(f"{path} has an older layout and is large: open it once for writing")
    copied = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
    try:
        connection.backup(copied)
    finally:
        connection.close()
    _harden(copied)
    return copied


def _authorize(action: int, one: str | None, two: str | None, _base: str | None, _by: str | None) -> int:
    is_allowed = (
        action in _ALLOWED
        or (action == sqlite3.SQLITE_FUNCTION and two in _FUNCTIONS)
        or (action == sqlite3.SQLITE_PRAGMA and one in _PRAGMAS)
    )
    return sqlite3.SQLITE_OK if is_allowed else sqlite3.SQLITE_DENY


def leave_wal(connection: sqlite3.Connection) -> None:
    """Makes a project one file without others beside it, unless somebody reads it; then the last reader does."""
    connection.set_authorizer(lambda *_: sqlite3.SQLITE_OK)  # Python 3.10 takes no None
    connection.execute("PRAGMA busy_timeout = 0")
    with contextlib.suppress(sqlite3.Error):
        connection.execute("PRAGMA journal_mode = DELETE")


def create(path: Path) -> None:
    """Makes an empty project, completely or not at all. The caller has the lock. Raises `WriteError`."""
    for beside in files_beside(path):
        if not beside.name.endswith("-shm") and beside.stat().st_size:
            raise WriteError(
                f"cannot make {path}: {beside.name} beside it has changes of a project that is not there; put the "
                f"project back, or delete {beside.name}"
            )
        beside.unlink()
    temporary = path.with_name(f".{path.name[:32]}.{secrets.token_hex(6)}.part")
    try:
        made = sqlite3.connect(f"file:{quote(_absolute(temporary))}?mode=rwc", isolation_level=None, uri=True)
        try:
            made.execute("BEGIN")
            layout.create(made)
            made.execute("COMMIT")
        finally:
            made.close()
        os.replace(temporary, path)
    except (sqlite3.Error, OSError) as error:
        raise not_written(path, error) from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(temporary)


def files_beside(path: Path) -> list[Path]:
    """Files of SQLite beside a project that is open, or was open when its process was killed."""
    real = Path(os.path.realpath(path))
    beside = [real.with_name(real.name + ending) for ending in ("-wal", "-shm", "-journal")]
    return [each for each in beside if os.path.lexists(each)]


def refusal(path: Path, error: Exception) -> LoadError:
    """The error for a file that SQLite cannot read."""
    text = " ".join(str(error).split())
    if "not a database" in text:
        return LoadError(f"{path} is not a project of feeler: give a file of feeler view --project")
    return LoadError(f"{path} is damaged ({text[:120]}): use a copy")


def not_written(path: Path, error: Exception) -> FeelerError:
    """The error for a file that cannot be written."""
    text = " ".join(((error.strerror if isinstance(error, OSError) else None) or str(error)).split())
    if "disk is full" in text or "No space" in text:
        return WriteError(f"cannot write {path}: the disk is full; free some space")
    if "malformed" in text or "not a database" in text:
        return LoadError(f"{path} is damaged ({text[:120]}): use a copy")
    if "locked" in text:
        return WriteError(f"cannot write {path}: another program holds it; close that program")
    return WriteError(f"cannot write {path}: {text[:120]}; check the disk and the permissions")


def check_file(path: Path) -> int:
    """The size of a file. Raises `MissingFileError`, and `LoadError` for folders and devices."""
    try:
        there = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        raise MissingFileError(f"{path} does not exist: give a project, a file of feeler view --project") from None
    except (OSError, ValueError) as error:
        what = error.strerror if isinstance(error, OSError) else str(error)
        raise LoadError(f"{str(path)[:200]} cannot be read: {what}") from None
    if not stat.S_ISREG(there.st_mode):
        what = "a folder" if stat.S_ISDIR(there.st_mode) else "a device or a pipe"
        raise LoadError(f"{path} is {what}: give a project, a file of feeler view --project")
    return there.st_size


def _has_wal(path: Path) -> bool:
    with contextlib.suppress(OSError):
        return os.stat(path.with_name(path.name + "-wal")).st_size > 0
    return False


def _absolute(path: Path) -> str:
    text = path.absolute().as_posix()
    return text if text.startswith("/") else f"/{text}"  # drives of Windows
