"""The layout of project files: tables, versions and limits.

All tables have one form: `id`, `place` (the order), `value` (JSON in ASCII), `data` (bytes, or null) and `seal`, the
digest of the row. `sums` has the number of rows and the sum of the seals of each table, so that a lost row is noticed
as a changed one is. SQLite checks neither.
"""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterable

SUFFIX = ".feelproj"
"""The extension of project files."""

APPLICATION_ID = 0x6665656C
"""`feel`, in the header of the file: programs such as `file` show it."""

VERSION = 2
"""The version of the layout: `PRAGMA user_version`. A layout that older versions cannot read gets the next number, an
entry in `migrations.MIGRATIONS`, and a fixture in `testdata/projects`."""

TABLES = (
    # The mock-up, the tool, and the options that both were opened with.
    "facts",
    # Fields of the document that are not lists.
    "document",
    *("sequence", "measures", "views", "cards", "requirements", "rules"),
    # Findings of the last clash check; then what people say of them by id, and each change of that.
    *("findings", "marks", "history"),
    # Long answers by id, with their bytes.
    "answers",
    "tools",
    # The parts of the mock-up by number, with their content; parts that are gone; things that belonged to these.
    *("parts", "gone", "aside"),
)

FORM = "id TEXT PRIMARY KEY NOT NULL, place INTEGER NOT NULL, value TEXT NOT NULL, data BLOB, seal INTEGER NOT NULL"
SUMS = "CREATE TABLE sums (id TEXT PRIMARY KEY NOT NULL, number INTEGER NOT NULL, seal INTEGER NOT NULL)"

MOST_FILE_BYTES = 4 << 30
MOST_TEXT = 64 << 20
"""Characters of one value. The longest of ours is the list of the hidden parts of a million."""
MOST_TABLE_TEXT = 512 << 20
"""Characters of all values of a table. Damaged files can show one value in many rows."""
MOST_DATA = 256 << 20
"""Bytes of one answer or one tool."""
MOST_ROWS = 4_000_000
MODULUS = 1 << 62
"""Seals and their sums are smaller: SQLite keeps 64 bits with a sign."""


def create(connection: sqlite3.Connection) -> None:
    """Makes the tables of the present layout in an empty file."""
    for statement in statements(VERSION):
        connection.execute(statement)
    connection.executemany("INSERT INTO sums VALUES (?, 0, 0)", [(name,) for name in TABLES])
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {VERSION}")


def statements(version: int) -> Iterable[str]:
    """The statements that make the tables of a layout."""
    assert 1 <= version <= VERSION
    return (*(f"CREATE TABLE {name} ({FORM})" for name in TABLES), SUMS)


def schema(version: int) -> set[tuple[object, ...]]:
    """The rows of `sqlite_master` in a file of a layout, without their pages."""
    with_tables = sqlite3.connect(":memory:")
    try:
        for statement in statements(version):
            with_tables.execute(statement)
        return schema_of(with_tables)
    finally:
        with_tables.close()


def schema_of(connection: sqlite3.Connection) -> set[tuple[object, ...]]:
    """The rows of `sqlite_master`, without their pages."""
    limit = 4 * len(TABLES)  # more are strange, however many they are
    return set(connection.execute(f"SELECT type, name, tbl_name, sql FROM sqlite_master LIMIT {limit}"))


def seal_of(table: str, key: str, place: int, value: str, data: bytes | None) -> int:
    """The digest of a row: against damage, not against forgery."""
    found = hashlib.blake2b(digest_size=8)
    for field in (table, key, str(place), value):
        text = field.encode("utf-8", "surrogatepass")
        found.update(b"%d:" % len(text))
        found.update(text)
    found.update(b"-" if data is None else b"%d:" % len(data))
    found.update(data or b"")
    return int.from_bytes(found.digest(), "little") % MODULUS
