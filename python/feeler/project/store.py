"""The rows of a project: read with all checks, and written in transactions."""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from feeler.errors import LoadError, ProjectError, WriteError
from feeler.project import layout
from feeler.project.lock import Lock
from feeler.project.opening import check_file, connect, create, leave_wal, not_written, refusal

_OPENINGS = "openings"


class Row(NamedTuple):
    """A row of a table. value: JSON."""

    id: str
    place: int
    value: str
    data: bytes | None = None


@dataclass(frozen=True)
class Change:
    """A row to write, or to delete if `row` is None."""

    table: str
    id: str
    row: Row | None


def put(table: str, key: str, place: int, value: str, data: bytes | None = None) -> Change:
    """Writes a row in the place of the one with its id."""
    return Change(table, key, Row(key, place, value, data))


def drop(table: str, key: str) -> Change:
    """Deletes the row with an id, if there is one."""
    return Change(table, key, None)


class Store:
    """An open project file. Thread-safe. Raises `MissingFileError`, `LoadError`, `ProjectError`, `WriteError`."""

    def __init__(self, path: Path, *, read_only: bool, is_made: bool) -> None:
        """is_made: a file that does not exist is made."""
        self.path, self.is_read_only = path, read_only
        self._guard = threading.RLock()
        self._process = os.getpid()
        self._connection: sqlite3.Connection | None = None
        self._lock = None if read_only else _locked(path, is_made)
        try:
            if is_made and not read_only and not os.path.lexists(path):
                create(path)
            self._connection = connect(path, read_only=read_only)
            self._file = _identity(path)
            self._sums = self._read_sums()
            self._whole: set[str] = set()
            """Tables of which all rows are there; only this process changes them."""
            self.rows("facts")  # they are read one by one: a lost one would be noticed by nobody
            self._openings = 0
            if not read_only:
                self._openings = self._count_opening()
        except BaseException:
            self.close()
            raise

    # ---- reading ----

    def rows(self, table: str) -> list[Row]:
        """The rows of a table in their order. Raises `LoadError` for a damaged one."""
        assert table in layout.TABLES
        found: list[Row] = []
        total = text = 0
        with self._guard, self._reading() as connection:
            number, seal = self._sums[table] if not self.is_read_only else self._sum_of(connection, table)
            for values in connection.execute(f"SELECT id, place, value, data, seal FROM {table} ORDER BY place, id"):
                row, its = self._checked(table, values)
                total = (total + its) % layout.MODULUS
                text += len(row.value) + len(row.data or b"")
                if text > layout.MOST_TABLE_TEXT or len(found) >= layout.MOST_ROWS:
                    raise LoadError(f"{self.path}: the table {table} is too large; use a copy")
                found.append(row)
            if (len(found), total) != (number, seal):
                raise LoadError(f"{self.path} is damaged: rows of {table} are missing or doubled; use a copy")
        return found

    def row(self, table: str, key: str) -> Row | None:
        """One row, None if there is none. Raises `LoadError` for a damaged one."""
        assert table in layout.TABLES
        with self._guard, self._reading() as connection:
            statement = f"SELECT id, place, value, data, seal FROM {table} WHERE id = ?"
            values = connection.execute(statement, (key,)).fetchone()
            if values is None:
                self._check_whole(connection, table)
        return None if values is None else self._checked(table, values)[0]

    def _check_whole(self, connection: sqlite3.Connection, table: str) -> None:
        """Raises `LoadError` if rows of a table are lost: one that is not there may be one of these."""
        if table in self._whole:
            return
        number, seal = self._sums[table] if not self.is_read_only else self._sum_of(connection, table)
        seals = [each for (each,) in connection.execute(f"SELECT seal FROM {table}")]
        if not all(isinstance(each, int) for each in seals) or (len(seals), sum(seals) % layout.MODULUS) != (
            number,
            seal,
        ):
            raise LoadError(f"{self.path} is damaged: rows of {table} are missing or doubled; use a copy")
        if not self.is_read_only:
            self._whole.add(table)

    def length(self, table: str) -> int:
        """The number of rows of a table."""
        with self._guard, self._reading() as connection:
            return (self._sum_of(connection, table) if self.is_read_only else self._sums[table])[0]

    def _checked(self, table: str, values: tuple[object, ...]) -> tuple[Row, int]:
        key, place, value, data, seal = values
        if (
            not isinstance(key, str)
            or not isinstance(place, int)
            or not isinstance(value, str)
            or not isinstance(data, bytes | None)
            or len(value) > layout.MOST_TEXT
            or (data is not None and len(data) > layout.MOST_DATA)
            or seal != layout.seal_of(table, key, place, value, data)
        ):
            raise LoadError(f"{self.path} is damaged: {_shown(key)} of {table} is not as it was written; use a copy")
        assert isinstance(seal, int)
        return Row(key, place, value, data), seal

    @contextlib.contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection]:
        connection = self._opened()
        try:
            if connection.in_transaction:
                yield connection
                return
            connection.execute("BEGIN")
            try:
                yield connection
            finally:
                if connection.in_transaction:
                    connection.execute("ROLLBACK")
        except (sqlite3.Error, UnicodeError, OverflowError, MemoryError) as error:
            if isinstance(error, (sqlite3.Error, UnicodeError)):
                raise refusal(self.path, error) from None
            raise LoadError(f"{self.path} is damaged: a value is too large; use a copy") from None

    def _read_sums(self) -> dict[str, tuple[int, int]]:
        with self._reading() as connection:
            return {table: self._sum_of(connection, table) for table in layout.TABLES}

    def _sum_of(self, connection: sqlite3.Connection, table: str) -> tuple[int, int]:
        found = connection.execute("SELECT number, seal FROM sums WHERE id = ?", (table,)).fetchone()
        if found is None or not all(isinstance(each, int) and 0 <= each < layout.MODULUS for each in found):
            raise LoadError(f"{self.path} is damaged: the sums of {table} are missing; use a copy")
        number, seal = found
        return int(number), int(seal)

    # ---- writing ----

    def write(self, changes: Iterable[Change]) -> None:
        """Makes changes, all or none, on the disk when it returns. Raises `WriteError`, `ProjectError`, `LoadError`."""
        with self._guard:
            if self.is_read_only:
                raise ProjectError(f"{self.path} is open read-only: nothing is written to it")
            connection = self._opened()
            if _identity(self.path) != self._file:
                raise WriteError(f"cannot write {self.path}: the file was moved or deleted; put it back")
            sums = dict(self._sums)
            try:
                connection.execute("BEGIN IMMEDIATE")
                try:
                    self._check_openings(connection)
                    for change in changes:
                        self._change(connection, change, sums)
                    for table, (number, seal) in sums.items():
                        if self._sums[table] != (number, seal):
                            statement = "UPDATE sums SET number = ?, seal = ? WHERE id = ?"
                            connection.execute(statement, (number, seal, table))
                    connection.execute("COMMIT")
                except BaseException:
                    with contextlib.suppress(sqlite3.Error):
                        connection.execute("ROLLBACK")
                    raise
            except (sqlite3.Error, UnicodeError) as error:
                raise not_written(self.path, error) from None
            self._sums = sums

    def _change(self, connection: sqlite3.Connection, change: Change, sums: dict[str, tuple[int, int]]) -> None:
        table, row = change.table, change.row
        assert table in layout.TABLES
        number, total = sums[table]
        before = connection.execute(f"SELECT seal FROM {table} WHERE id = ?", (change.id,)).fetchone()
        if before is not None:
            if not isinstance(before[0], int):
                raise LoadError(f"{self.path} is damaged: {_shown(change.id)} of {table} has no seal; use a copy")
            number, total = number - 1, (total - before[0]) % layout.MODULUS
        if row is not None:
            if len(row.value) > layout.MOST_TEXT or len(row.data or b"") > layout.MOST_DATA:
                raise WriteError(f"cannot write {self.path}: {_shown(row.id)} of {table} is too large for a project")
            seal = layout.seal_of(table, row.id, row.place, row.value, row.data)
            number, total = number + 1, (total + seal) % layout.MODULUS
            connection.execute(f"INSERT OR REPLACE INTO {table} VALUES (?, ?, ?, ?, ?)", (*row, seal))
        elif before is not None:
            connection.execute(f"DELETE FROM {table} WHERE id = ?", (change.id,))
        sums[table] = number, total

    def _count_opening(self) -> int:
        """Counts the openings for writing: a process that lost the project unnoticed finds another count."""
        found = self.row("facts", _OPENINGS)
        try:
            number = 0 if found is None else int(found.value)
        except ValueError:
            raise LoadError(f"{self.path} is damaged: the count of its openings is no number; use a copy") from None
        self._openings = number
        number += 1
        self.write([put("facts", _OPENINGS, 0, str(number))])
        return number

    def _check_openings(self, connection: sqlite3.Connection) -> None:
        found = connection.execute("SELECT value FROM facts WHERE id = ?", (_OPENINGS,)).fetchone()
        if (found[0] if found else "0") != str(self._openings):
            raise ProjectError(f"{self.path} was taken over by another process: open it again; nothing was written")

    # ---- the rest ----

    def copy(self) -> bytes:
        """The file as it is now, as bytes, whole without the files beside it."""
        with self._guard, self._reading() as connection:
            copied = sqlite3.connect(":memory:")
            try:
                connection.execute("ROLLBACK")  # a backup reads by itself
                connection.backup(copied)
                data = bytearray(_serialized(copied))
                data[18:20] = b"\1\1"  # not in the mode of several files
                return bytes(data)
            finally:
                copied.close()

    def close(self, *, is_deleted: bool = False) -> None:
        """Closes the file, and gives back the lock; a second call does nothing. is_deleted: deletes the file, too."""
        with self._guard:
            connection, self._connection = self._connection, None
            if connection is not None and os.getpid() == self._process:
                with contextlib.suppress(sqlite3.Error):
                    if not self.is_read_only:
                        leave_wal(connection)
                    connection.close()
                if is_deleted:
                    with contextlib.suppress(OSError):
                        os.unlink(self.path)
            if self._lock is not None:
                self._lock.release()

    def __del__(self) -> None:
        with contextlib.suppress(AttributeError):  # of one that could not be opened
            self.close()

    @property
    def is_open(self) -> bool:
        """Whether it can be read."""
        return self._connection is not None

    def _opened(self) -> sqlite3.Connection:
        if os.getpid() != self._process:
            raise ProjectError(f"{self.path} was opened by the parent of this process: open it here, too")
        if self._connection is None:
            raise ProjectError(f"{self.path} is closed: open it again")
        return self._connection


def _locked(path: Path, is_made: bool) -> Lock:
    """The lock of a project; of a file that is there, or can be made."""
    if not is_made or os.path.lexists(path):
        check_file(path)
    return Lock(path)


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        there = os.stat(path)
    except OSError:
        return None
    return there.st_dev, there.st_ino


def _serialized(connection: sqlite3.Connection) -> bytes:
    if hasattr(connection, "serialize"):  # Python 3.11
        return bytes(connection.serialize())
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "copy")
        target = sqlite3.connect(path)
        try:
            connection.backup(target)
        finally:
            target.close()
        with open(path, "rb") as file:
            return file.read()


def _shown(key: object) -> str:
    return f"{key!r:.60}"
