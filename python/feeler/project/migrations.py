"""Migrations of project files from older layouts, one version at a time."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator
from typing import Any

from feeler.errors import LoadError
from feeler.project.layout import MODULUS, seal_of


def migrate(connection: sqlite3.Connection, version: int, newest: int) -> None:
    """Changes a file of an older layout to the newest one, all or nothing. Raises `LoadError` for a damaged file."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        for each in range(version, newest):
            MIGRATIONS[each](connection)
        connection.execute(f"PRAGMA user_version = {newest}")
        connection.execute("COMMIT")
    except BaseException:
        connection.execute("ROLLBACK")
        raise


def _one_form_of_notes(connection: sqlite3.Connection) -> None:
    """Version 1 to 2: the workbench wrote the note of a finding as `notes`, scripts wrote it as `note`.

    A mark had only what differed from the row of the finding. Now it has all that people said, under one name.
    """
    marks = {str(mark.get("id")): mark for _, mark in _values(connection, "marks")}
    made: dict[str, dict[str, Any]] = {}
    for _, row in _values(connection, "findings"):
        name = str(row.get("id"))
        mark = marks.get(name)
        if mark is None and row.get("status", "new") == "new" and not row.get("note"):
            continue
        made[name] = _mark(mark or {}, row)
    made |= {name: _mark(mark, {}) for name, mark in marks.items() if name not in made}
    rows = [(json.dumps(name)[1:-1], {"id": name, **mark}) for name, mark in made.items()]
    _rewrite(connection, "marks", [(key, place, value) for place, (key, value) in enumerate(rows)])
    lines: list[tuple[str, int, dict[str, Any]]] = []
    last: dict[object, dict[str, Any]] = {}
    for _, line in _values(connection, "history"):
        finding, note = line.get("id"), line.pop("notes", line.get("note", ""))
        line.pop("members", None)
        before = last.get(finding) or {"status": "new"}
        made_line = {"status": before["status"], **line, "by": line.get("by", ""), "note": note}
        said: dict[str, Any] = {**made_line, "at": None}
        last[finding] = said
        if said != before:  # not only a group that was made by hand
            lines.append((str(len(lines)), len(lines), made_line))
    _rewrite(connection, "history", lines)


def _mark(mark: dict[str, Any], row: dict[str, Any]) -> dict[str, Any]:
    """A mark of version 2, from one of version 1 and the row of its finding."""
    status = mark.get("status", row.get("status") or "new")
    note = mark.get("notes", mark.get("note", row.get("note")))
    is_of_row = status == row.get("status")
    more = {name: mark.get(name, row.get(name) if is_of_row else None) for name in ("by", "approved_depth")}
    found = {"status": status, "by": more["by"], "note": note, "approved_depth": more["approved_depth"]}
    kept = {name: value for name, value in found.items() if value not in (None, "")}
    return {**kept, **({"members": mark["members"]} if "members" in mark else {})}


def _values(connection: sqlite3.Connection, table: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """The id and value of each row of a table, in order. Raises `LoadError` for a changed one."""
    statement = f"SELECT id, place, value, data, seal FROM {table} ORDER BY place, id"
    for key, place, value, data, seal in connection.execute(statement).fetchall():
        try:
            found = json.loads(value) if seal == seal_of(table, key, place, value, data) else None
        except (ValueError, TypeError, AttributeError, RecursionError):
            found = None
        if not isinstance(found, dict):
            raise LoadError(f"{key!r:.60} of {table} is not as it was written: the project is damaged; use a copy")
        yield key, found


def _rewrite(connection: sqlite3.Connection, table: str, rows: list[tuple[str, int, dict[str, Any]]]) -> None:
    """Replaces the rows of a table, unless some of them were lost before. Raises `LoadError`."""
    seals = [int(seal) for (seal,) in connection.execute(f"SELECT seal FROM {table}")]
    sums = connection.execute("SELECT number, seal FROM sums WHERE id = ?", (table,)).fetchone()
    if sums != (len(seals), sum(seals) % MODULUS):
        raise LoadError(f"rows of {table} are missing or doubled: the project is damaged; use a copy")
    connection.execute(f"DELETE FROM {table}")
    total = 0
    for key, place, value in rows:
        text = json.dumps(value, separators=(",", ":"), allow_nan=False)
        seal = seal_of(table, key, place, text, None)
        total = (total + seal) % MODULUS
        connection.execute(f"INSERT INTO {table} VALUES (?, ?, ?, NULL, ?)", (key, place, text, seal))
    connection.execute("UPDATE sums SET number = ?, seal = ? WHERE id = ?", (len(rows), total, table))


MIGRATIONS: dict[int, Callable[[sqlite3.Connection], None]] = {1: _one_form_of_notes}
"""For each older version: changes a file to the next version."""
