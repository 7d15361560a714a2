"""The content of a project: mock-up, document, findings with their history, and answers, on the rows of the store."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn

from feeler.atomic import check_target
from feeler.choices import GroupBy
from feeler.clashes import saving
from feeler.clashes.result import Clashes
from feeler.clashes.tracking import APPROVAL, Mark, check_of, mark_of_json
from feeler.errors import LoadError, OptionError
from feeler.mockup import Mockup
from feeler.project.layout import SUFFIX
from feeler.project.parts import (
    PartChanges,
    PartContent,
    Revision,
    accepted,
    contents_of,
    parts_of,
    renamed_since,
    revised,
    rows_of,
    text_of,
)
from feeler.project.store import Change, Row, Store, drop, put

_MARKED = ("status", "by", "note", *APPROVAL)
"""What a mark has of `tracking.Mark`. The workbench adds the number of a group that was made by hand."""
PAIR = "pair"
"""Of a mark whose finding is not listed: its rule and the keys of its parts, so that it follows other names."""
_NEW = {"status": "new"}
_RESOLVED = {"status": "resolved"}
_FACTS = ("version", "clearance", "contact", "parts", "triangles", "files", "hidden")
"""Of the head of a check, as the workbench keeps them."""
_MOST_HISTORY = 1_000_000
_RENAMED = "renamed"  # a fact: see `Book.renamed`

CHECK = "clashes"
"""The fact that has the last clash check without its findings."""


def open_or_make(path: Path, *, read_only: bool = False) -> Book:
    """Opens a project, or makes an empty one; closing deletes that again if no mock-up came into it."""
    is_new = not read_only and not os.path.lexists(path)
    if is_new:
        check_target(path, SUFFIX)
    return Book(Store(path, read_only=read_only, is_made=not read_only), is_new=is_new)


class Book:
    """An open project. Thread-safe. Raises errors as the `Store` does."""

    def __init__(self, store: Store, *, is_new: bool = False) -> None:
        self._store, self._is_new = store, is_new

    @property
    def path(self) -> str:
        """The file."""
        return str(self._store.path)

    @property
    def is_read_only(self) -> bool:
        """Whether nothing can be written."""
        return self._store.is_read_only

    # ---- findings ----

    def clashes(self) -> Clashes | None:
        """The findings of the last clash check, with their statuses and notes; None if there was none.

        Set statuses by `Clashes.set_status`, and write them by `write_clashes`.
        """
        data, rows = self.fact(CHECK), self.findings()
        if data is None and rows:
            # Findings that were opened in the workbench: of a clash check, or from elsewhere.
            try:
                found = saving.table_of({"version": saving.VERSION, "clashes": rows}, self.path, Clashes)
            except LoadError:
                return None
        elif data is None:
            return None
        elif not isinstance(data, dict):
            raise LoadError(f"{self.path} is damaged: its clash check is not as written; use a copy")
        else:
            found = saving.table_of({**data, "clashes": rows}, self.path, Clashes)
        found.marks.aside = self._aside({*found.ids})
        return found

    def _aside(self, listed: set[str]) -> dict[str, Mark]:
        """The marks of findings that the workbench ignores."""
        try:
            return {key: mark_of_json(mark) for key, mark in self.marks().items() if key not in listed}
        except ValueError as error:
            raise LoadError(f"{self.path} is damaged: {error}; use a copy") from None

    def findings(self) -> list[dict[str, Any]]:
        """The findings as `feeler clash --json` lists them, in the order of the workbench."""
        marks = self.marks()
        found = []
        for row in self._store.rows("findings"):
            value = self.value(row, "findings")
            if not isinstance(value, dict):
                raise LoadError(f"{self.path} is damaged: a finding is not as written; use a copy")
            for name in _MARKED:
                value.pop(name, None)
            found.append({**value, **_NEW, **marks.get(str(value.get("id")), {})})
        return found

    def history(self, finding: str | None = None) -> list[dict[str, Any]]:
        """Each change of a finding's status or note, or of those of all findings, the oldest first."""
        rows = (self.value(row, "history") for row in self._store.rows("history"))
        return [row for row in rows if isinstance(row, dict) and finding in (None, row.get("id"))]

    def write_clashes(self, clashes: Clashes, by: GroupBy = "part", beside: Iterable[Change] = ()) -> None:
        """Writes the findings of a clash check in place of the previous ones, and each change of a status or note.

        beside: changes to write with them. To keep statuses, compare first: `clashes.diff(project.clashes())`.
        """
        self._check_parts(clashes)
        earlier = list(saving.rows(clashes.earlier()))
        head = {**saving.head(clashes), "earlier": earlier, **saving.shapes_of_file(clashes)}
        groups = {int(row): group.name for group in clashes.groups(by) for row in group.rows}
        rows = [{**row, "group": groups[place]} for place, row in enumerate(saving.rows(clashes))]
        gone = [row["id"] for row in resolved_of(head)]
        waiting = {row["id"]: row for row in earlier if row["status"] != "resolved"}
        every = {**{row["id"]: row for row in rows}, **waiting}
        here = {key: {name: row[name] for name in _MARKED if name in row} for key, row in every.items()}
        ids = {before: now for before, now in self._renamed(clashes).items() if now in here}
        known, listed = renamed_marks(self.marks(), ids), {str(row.get("id")) for row in self.findings()}
        marks = {}
        others = {*here, *gone, *listed}
        # Findings that the workbench ignores are not listed: their marks stay.
        for key in [*here, *(key for key in known if key not in others)]:
            is_known = key in here
            before = known.get(key, {})
            more = {name: value for name, value in before.items() if not is_known or name not in (*_MARKED, PAIR)}
            mark = {**here.get(key, {}), **more}
            if mark != _NEW:
                marks[key] = mark
        changes = [put("facts", CHECK, 0, dumps(head)), *self.findings_changes(rows), *self.history_changes(ids)]
        changes += self.marks_changes(marks, here, gone, ids)
        self.write([*changes, *self._of_another_check(head), *beside])

    def check_changes(
        self, facts: Mapping[str, Any], resolved: Sequence[Mapping[str, Any]], *, is_same_check: bool
    ) -> Iterator[Change]:
        """Makes these the findings that are gone. facts: of a check that is not of the findings in the file."""
        there = self.fact(CHECK) if is_same_check else None
        head = there if isinstance(there, dict) else None
        if head is None and not resolved:
            yield drop("facts", CHECK)
        elif head is None or resolved_of(head) != [*resolved]:
            waiting = [] if head is None else [each for each in _earlier(head) if each.get("status") != "resolved"]
            yield put("facts", CHECK, 0, dumps({**(head or facts), "earlier": [*resolved, *waiting]}))

    def _renamed(self, clashes: Clashes) -> Mapping[str, str]:
        """The id now by the id before, of findings that a comparison with the last check found under other names."""
        last = self.clashes() if clashes.marks.renamed else None
        if last is None or check_of(last.ids, (last.points_a, last.points_b)) != clashes.marks.former_check:
            return {}
        return clashes.marks.renamed

    def _check_parts(self, clashes: Clashes) -> None:
        """Raises `OptionError` for findings of another mock-up: no part is known by path or by content."""
        parts, keys = self.parts(), {*clashes.keys}
        if not parts or not keys or any(part.key in keys for part in parts):
            return
        contents = {f"{each:016x}" for each in clashes.shapes.content.tolist()}
        if not any(part.content in contents for part in parts):
            raise OptionError(
                f"the clashes are of another mock-up: none of their {len(keys):,} parts is in {self.path}; give those "
                "of the project's mock-up, or make another project"
            )

    def _of_another_check(self, head: Mapping[str, Any]) -> Iterator[Change]:
        """What the workbench has of its findings besides rows: groups by hand stay, the facts are of the new check."""
        row = self._store.row("document", "findings")
        value = None if row is None else self.value(row, "document")
        if row is not None and isinstance(value, dict):
            facts = {name: head[name] for name in _FACTS}
            yield put("document", row.id, row.place, dumps({**value, "table": facts, "check": None, "stale": {}}))

    # ---- the mock-up ----

    def parts(self) -> tuple[PartContent, ...]:
        """The parts of the mock-up that was opened last; empty before the first."""
        return parts_of(self._store.rows("parts"), self.path)

    def gone(self) -> tuple[PartContent, ...]:
        """Parts that newer revisions lack."""
        return parts_of(self._store.rows("gone"), self.path)

    def revision(self, mockup: Mockup, progress: Callable[[float, str], object] | None = None) -> Revision:
        """A mock-up beside the parts that the project knows. Raises `LoadError` if it has none of these."""
        known, now = self.parts(), contents_of(mockup, progress)
        found = revised(known, self.gone(), now)
        if known and all(row is None for row in found.row_of):
            raise LoadError(
                f"{self.path} is about another mock-up: none of its {len(known):,} parts is in this one; give the "
                "mock-up of the project, or another project"
            )
        return found

    def renamed(self) -> dict[str, str]:
        """The key of each renamed part by the one that the project's answers are about."""
        value = self.fact(_RENAMED)
        return {old: new for old, new in value.items() if isinstance(new, str)} if isinstance(value, dict) else {}

    def part_changes(self, revision: Revision) -> PartChanges:
        """What differs in a revision from the mock-up that the project's answers are about."""
        return replace(revision.changes(), renamed=renamed_since(self.renamed(), revision))

    def revision_changes(self, revision: Revision, *, is_accepted: bool = False) -> Iterator[Change]:
        """Makes a revision the one that the project is about."""
        rows = self._store.rows("parts")
        now = accepted(revision.parts) if is_accepted else revision.parts
        known = {row.id: row for row in rows}
        for change in rows_of(now):
            if known.pop(change.id, None) != change.row:
                yield change
        yield from (drop("parts", key) for key in known)
        gone = () if is_accepted else revision.gone
        yield from self.list_changes("gone", {part.key: text_of(part) for part in gone})
        before = self.renamed()
        renamed = {} if is_accepted else renamed_since(before, revision)
        if renamed != before:
            yield put("facts", _RENAMED, 0, dumps(renamed))

    def list_changes(self, table: str, values: Mapping[str, str]) -> Iterator[Change]:
        """Makes these the rows of a table, in this order."""
        known = {row.id: row for row in self._store.rows(table)}
        for place, (key, value) in enumerate(values.items()):
            row = Row(row_id(key), place, value)
            if known.pop(row.id, None) != row:
                yield Change(table, row.id, row)
        yield from (drop(table, key) for key in known)

    def findings_changes(self, rows: Sequence[Mapping[str, Any]]) -> Iterator[Change]:
        """Makes these the findings, each with an id."""
        return self.list_changes("findings", {str(place): dumps(row) for place, row in enumerate(rows)})

    def marks(self, rows: Iterable[Row] | None = None) -> dict[str, dict[str, Any]]:
        """What people said of findings: by id, with the `status`, and others. rows: these instead of the file's."""
        found = {}
        for row in self._store.rows("marks") if rows is None else rows:
            value = self.value(row, "marks")
            if not isinstance(value, dict) or not isinstance(key := value.pop("id", None), str):
                raise LoadError(f"{self.path} is damaged: a status is not as written; use a copy")
            found[key] = value
        return found

    def marks_changes(
        self,
        marks: Mapping[str, Mapping[str, Any]],
        listed: Iterable[str],
        gone: Iterable[str] = (),
        ids: Mapping[str, str] = MappingProxyType({}),
    ) -> Iterator[Change]:
        """Makes these the marks of the findings, and adds a line to the history of each that says something else.

        Findings that are gone are resolved; others without a mark are new, also those that were gone and are listed
        again. ids: as for `history_changes`.
        """
        at, number = now(), self.history_length()
        said, before, resolved = self._last_lines(ids), renamed_marks(self.marks(), ids), dict.fromkeys(gone)
        for key in dict.fromkeys((*marks, *before, *resolved, *listed)):
            known = said.get(key) or _line(key, at, before.get(key, _NEW))
            line = _line(key, at, marks.get(key, _RESOLVED if key in resolved else _NEW))
            if line != {**known, "id": key, "at": at} and number < _MOST_HISTORY:
                yield put("history", str(number), number, dumps(line))
                number += 1
        yield from self.list_changes("marks", {key: dumps({"id": key, **mark}) for key, mark in marks.items()})

    def _last_lines(self, ids: Mapping[str, str]) -> dict[str, dict[str, Any]]:
        """The last line of the history of each finding."""
        return renamed_marks({row["id"]: row for row in self.history() if isinstance(row.get("id"), str)}, ids)

    def some_marks_changes(self, marks: Mapping[str, Mapping[str, Any] | None], at: str) -> Iterator[Change]:
        """Replaces some marks, None: by none, and adds a line to the history for each change."""
        number, length = self.history_length(), self._store.length("marks")
        for key, mark in marks.items():
            row = self._store.row("marks", row_id(key))
            known = None if row is None else self.value(row, "marks")
            if known is not None and not isinstance(known, dict):
                raise LoadError(f"{self.path} is damaged: a status is not as written; use a copy")
            if mark is None:
                yield drop("marks", row_id(key))
            else:
                place = length if row is None else row.place
                length += row is None
                yield put("marks", row_id(key), place, dumps({"id": key, **mark}))
            line = _line(key, at, mark or _NEW)
            if line != _line(key, at, known or _NEW) and number < _MOST_HISTORY:
                yield put("history", str(number), number, dumps(line))
                number += 1

    def history_changes(self, ids: Mapping[str, str]) -> Iterator[Change]:
        """Gives the lines of findings with other ids now, by the ids before, to these."""
        for row in self._store.rows("history") if ids else ():
            value = self.value(row, "history")
            if isinstance(value, dict) and isinstance(key := value.get("id"), str) and key in ids:
                yield put("history", row.id, row.place, dumps({**value, "id": ids[key]}), row.data)

    def history_length(self) -> int:
        """The number of rows of the history."""
        return self._store.length("history")

    def fact(self, name: str) -> Any:
        """A fact about the project; None if it is not known."""
        row = self._store.row("facts", name)
        return None if row is None else self.value(row, "facts")

    def rows(self, table: str) -> list[Row]:
        """The rows of a table, in their order."""
        return self._store.rows(table)

    def answer(self, key: str) -> tuple[Any, bytes | None] | None:
        """A long answer by its id: its facts, with their `kind`, and its bytes; None if there is none."""
        row = self._store.row("answers", row_id(key))
        return None if row is None else (self.value(row, "answers"), row.data)

    def write_answer(self, key: str, kind: str, facts: Mapping[str, Any], data: bytes | None = None) -> None:
        """Keeps a long answer by its id."""
        self.write([put("answers", row_id(key), 0, dumps({"kind": kind, **facts}), data)])

    def write(self, changes: Iterable[Change]) -> None:
        """Makes changes, all or none, on the disk when it returns."""
        self._store.write(changes)

    def copied(self) -> bytes:
        """The file as it is now."""
        return self._store.copy()

    def close(self) -> None:
        """Closes the file, and lets other processes write it; a second call does nothing."""
        is_empty = self._is_new and self._store.is_open and not self._store.length("parts")
        self._store.close(is_deleted=is_empty)

    @property
    def is_open(self) -> bool:
        """Whether it is not closed."""
        return self._store.is_open

    def value(self, row: Row, table: str) -> Any:
        """The value of a row of a table. Raises `LoadError`."""
        return loads(row.value, f"{self.path}: {row.id[:60]!r} of {table}")


def pair_of(mark: Mapping[str, Any]) -> tuple[str, str, str] | None:
    """The `pair` of a mark of a file; None if it has none."""
    value = mark.get(PAIR)
    if not isinstance(value, list) or len(value) != 3 or not all(isinstance(each, str) for each in value):
        return None
    rule, a, b = value
    return rule, a, b


def renamed_marks(marks: Mapping[str, dict[str, Any]], ids: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Marks by the ids of now. ids: by the ids before; a mark goes if another finding has its id now."""
    taken = {*ids.values()}
    return {ids.get(key, key): mark for key, mark in marks.items() if key in ids or key not in taken}


def _earlier(head: Any) -> list[dict[str, Any]]:
    listed = head.get("earlier") if isinstance(head, dict) else None
    return [each for each in listed if isinstance(each, dict)] if isinstance(listed, list) else []


def resolved_of(head: Any) -> list[dict[str, Any]]:
    """The findings of the check before that are gone, as JSON. head: the fact `CHECK` of a project of anybody."""
    return [each for each in _earlier(head) if each.get("status") == "resolved" and isinstance(each.get("id"), str)]


def _line(finding: str, at: str, mark: Mapping[str, Any]) -> dict[str, Any]:
    """A line of the history: always with `by` and `note`. Groups have no history."""
    return {"id": finding, "at": at, "by": "", "note": "", **{name: mark[name] for name in _MARKED if name in mark}}


def loads(text: str, where: str) -> Any:
    """A value of a row. Raises `LoadError` for anything but JSON, and for numbers that are not finite."""
    try:
        value = json.loads(text, parse_constant=_refuse)
        _check(value)
    except (ValueError, RecursionError, MemoryError) as error:
        raise LoadError(f"{where} is damaged ({error!s:.80}): use a copy of the project") from None
    return value


def _refuse(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number")


def _check(value: object) -> None:
    """Raises `ValueError` for numbers beyond float64, which JSON can write, and deep nests, which nobody writes."""
    level = [value]
    for _ in range(32):
        inner: list[object] = []
        for each in level:
            if isinstance(each, dict):
                inner += each.values()
            elif isinstance(each, list):
                inner += each
            elif isinstance(each, float) and not abs(each) <= 1.8e308:
                raise ValueError("a number is too large")
        if not inner:
            return
        level = inner
    raise ValueError("it is too deep")


def dumps(value: object) -> str:
    """A value as ASCII JSON; equal values give equal text."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def row_id(key: str) -> str:
    """A key as the id of a row: ASCII, different for different keys."""
    return json.dumps(key)[1:-1]


def now() -> str:
    """The time, UTC."""
    return datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
