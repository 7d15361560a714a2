"""Names of parts in a project for a revision whose parts have other paths, such as those of a file with another name.

Findings name parts by their keys, and their ids are made of these. Requirements, rules and edits name parts by paths
and patterns.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from feeler.clashes.tracking import clash_id
from feeler.errors import FeelerError
from feeler.parts import Parts, escaped
from feeler.project.book import CHECK, PAIR, Book, dumps, loads, pair_of, row_id
from feeler.project.parts import Revision, renamed_folders
from feeler.project.store import Change, Row, drop, put

_SPECIAL = re.compile(r"[*?\[\]]")
_NUMBER = re.compile(r"#[0-9]+$")  # of a key, where several parts have its path
_REGEX = "re:"
_LISTS = ("earlier",)
_SHAPES = ("shapes", "earlier_shapes")


@dataclass(frozen=True)
class Names:
    """How parts are called now. keys: the key now by the key before. folders: the same of folders, with their last `/`,
    those with most parts first."""

    keys: Mapping[str, str] = field(default_factory=dict)
    folders: tuple[tuple[str, str], ...] = ()

    @classmethod
    def of(cls, revision: Revision) -> Names:
        """Those of a revision."""
        return cls(revision.renamed, tuple(renamed_folders(revision.renamed)))

    def key(self, key: str) -> str:
        """The key or path of a part now."""
        return self.keys.get(key, key)

    def pattern(self, pattern: str, parts: Parts) -> str:
        """A pattern with the names of now, if it names no part of the mock-up as it is, and one with them.

        A regular expression that begins with a folder gets the name that it has now.
        """
        if not self.keys:
            return pattern
        if pattern.startswith(_REGEX):
            return next(self._renamed(pattern), pattern)
        if named_parts(pattern, parts):
            return pattern
        renamed = (*self._renamed(pattern), *self._called(pattern, parts))
        return next((made for made in renamed if named_parts(made, parts)), pattern)

    def _called(self, name: str, parts: Parts) -> Iterator[str]:
        """The name now of the parts with this name; the path if other parts have that name, too."""
        now = [new for old, new in self.keys.items() if name in (last := _last(old), _NUMBER.sub("", last))]
        names = {_NUMBER.sub("", _last(key)) for key in now}
        yield from (each for each in names if len(names) == 1 and len(named_parts(each, parts)) == len(now))
        if len(now) == 1:
            yield now[0]

    def _renamed(self, pattern: str) -> Iterator[str]:
        if pattern in self.keys:
            yield self.keys[pattern]
        for old, new in self.folders:
            if pattern == old.rstrip("/"):
                yield new.rstrip("/")
            for before, now in ((old, new), *(_as_pattern(old, new, pattern))):
                if pattern.startswith(before):
                    yield now + pattern[len(before) :]


def _last(key: str) -> str:
    """The last step of a key: mostly the name of the part."""
    return key.rpartition("/")[2]


def _as_pattern(old: str, new: str, pattern: str) -> Iterator[tuple[str, str]]:
    """A folder as patterns and regular expressions write it."""
    if pattern.startswith(_REGEX):
        for lead in (_REGEX, f"{_REGEX}^"):
            yield lead + old, lead + re.escape(new)
            yield lead + re.escape(old), lead + re.escape(new)
    else:
        yield escaped(old), escaped(new)
        yield _SPECIAL.sub("?", old), _SPECIAL.sub("?", new)


def named_parts(pattern: str, parts: Parts) -> list[int]:
    """The parts that a pattern of a requirement or a rule names, ascending; none for one that is wrong.

    All for a regular expression: one of a stranger's project may take for ever, and is not tried before it is asked.
    """
    if pattern.startswith(_REGEX):
        return list(range(len(parts)))
    try:
        return [int(part) for part in parts.select(pattern)]
    except (FeelerError, ValueError, RecursionError, OverflowError):
        return []


class Left:
    """The parts that patterns named by their former keys, and name no more by those of now."""

    def __init__(self, renamed: Mapping[str, str], keys: Sequence[str], parts: Parts) -> None:
        """renamed: the key of now by the former one. keys: of the parts, all by now."""
        number = {key: part for part, key in enumerate(keys)} if renamed else {}
        self._pairs = [(old, new) for old, new in renamed.items() if new in number]
        self._now = np.array([number[new] for _, new in self._pairs], dtype=np.intp)
        self._before, self._parts = parts_of_keys([old for old, _ in self._pairs]), parts

    def of(self, pattern: str) -> list[tuple[str, str]]:
        """Those of a pattern: their key before, and now. Of a regular expression none: see `named_parts`."""
        if not self._pairs or pattern.startswith(_REGEX):
            return []
        is_named = np.zeros(len(self._parts), dtype=bool)
        is_named[named_parts(pattern, self._parts)] = True
        before = np.array(named_parts(pattern, self._before), dtype=np.intp)
        return [self._pairs[each] for each in before[~is_named[self._now[before]]].tolist()]


def parts_of_keys(keys: Sequence[str], triangles: Sequence[int] = ()) -> Parts:
    """Parts of which names and paths alone are known, and how many triangles they have."""
    empty = np.broadcast_to(np.array([[1.0] * 3, [0.0] * 3]), (len(keys), 2, 3))
    counts = np.array(triangles, dtype=np.uint32) if triangles else np.zeros(len(keys), np.uint32)
    return Parts([_last(key) for key in keys], list(keys), counts, empty)


def renaming_changes(book: Book, names: Names) -> list[Change]:
    """The changes that give findings the keys and the ids of now, with their statuses, notes, groups and history.

    They are the same findings: the history gets no line. Made twice, the changes are none.
    """
    if not names.keys:
        return []
    ids: dict[str, str] = {}
    rows = [(row, book.value(row, "findings")) for row in book.rows("findings")]
    head = book.fact(CHECK)
    head = head if isinstance(head, dict) else {}
    lists = {name: head[name] for name in _LISTS if isinstance(head.get(name), list)}
    every = [value for _, value in rows] + [each for listed in lists.values() for each in listed]
    known = {str(value.get("id")) for value in every if isinstance(value, dict)}
    for value in every:
        if isinstance(value, dict) and (new := _new_id(value, names)) is not None and new not in known:
            ids[str(value["id"])] = new
    pairs: dict[str, list[str]] = {}
    marks = [(row, value) for row in book.rows("marks") if isinstance(value := book.value(row, "marks"), dict)]
    taken = known | {str(value.get("id")) for _, value in marks}
    for _, value in marks:
        key, pair = value.get("id"), pair_of(value)
        if isinstance(key, str) and key not in known and pair is not None:
            finding = {"id": key, "rule": pair[0], "a": pair[1], "b": pair[2]}
            if (new := _new_id(finding, names)) is not None and new not in taken:
                ids[key] = new
            pairs[key] = [pair[0], names.key(pair[1]), names.key(pair[2])]
    found = [*_replaced("findings", rows, lambda value: _finding(value, names, ids))]
    found += book.history_changes(ids)
    for row, value in marks:
        key = str(value.get("id"))
        if key in ids:
            more = {PAIR: pairs[key]} if key in pairs else {}
            made = dumps({**value, "id": ids[key], **more})
            found += [drop("marks", row.id), put("marks", row_id(ids[key]), row.place, made)]
    if head:
        more = {name: [_finding(each, names, ids) for each in listed] for name, listed in lists.items()}
        more |= {name: [_shape(each, names) for each in head[name]] for name in _SHAPES if _is_list(head.get(name))}
        found += [put("facts", CHECK, 0, dumps({**head, **more}))]
    return found


def with_changes(rows: Callable[[str], list[Row]], changes: list[Change]) -> Callable[[str], list[Row]]:
    """The rows of tables as they are once changes are written."""
    by_table: dict[str, dict[str, Row | None]] = {}
    for each in changes:
        by_table.setdefault(each.table, {})[each.id] = each.row

    def changed(table: str) -> list[Row]:
        there = {row.id: row for row in rows(table)}
        for key, row in by_table.get(table, {}).items():
            if row is None:
                there.pop(key, None)
            else:
                there[key] = row
        return sorted(there.values(), key=lambda row: row.place)

    return changed


def checked_contents(rows: Callable[[str], list[Row]]) -> dict[str, str]:
    """The content of each part that the last check of the command line saw, by its key; empty without one."""
    text = next((row.value for row in rows("facts") if row.id == CHECK), "null")
    head = loads(text, "the clash check")
    shapes = head.get("shapes") if isinstance(head, dict) else None
    found = {}
    for each in shapes if isinstance(shapes, list) else ():
        key, content = (each.get(name) for name in ("part", "content")) if isinstance(each, dict) else (None, None)
        if isinstance(key, str) and isinstance(content, str):
            found[key] = content
    return found


def _replaced(
    table: str, rows: list[tuple[Row, Any]], change: Callable[[dict[str, Any]], dict[str, Any]]
) -> Iterator[Change]:
    for row, value in rows:
        if isinstance(value, dict) and (made := change(value)) != value:
            yield put(table, row.id, row.place, dumps(made), row.data)


def _new_id(finding: Mapping[str, Any], names: Names) -> str | None:
    """The id of a finding with the keys of now; None if it is no other, or was not made of keys."""
    rule, a, b = (str(finding.get(name) or "") for name in ("rule", "a", "b"))
    if (names.key(a), names.key(b)) == (a, b) or finding.get("id") != clash_id(rule, a, b):
        return None
    return clash_id(rule, names.key(a), names.key(b))


def _finding(value: Any, names: Names, ids: Mapping[str, str]) -> Any:
    if not isinstance(value, dict):
        return value
    sides = {side: names.key(value[side]) for side in ("a", "b") if isinstance(value.get(side), str)}
    return {**_with_id(value, ids), **sides}


def _with_id(value: dict[str, Any], ids: Mapping[str, str]) -> dict[str, Any]:
    key = value.get("id")
    return {**value, "id": ids[key]} if isinstance(key, str) and key in ids else value


def _shape(value: Any, names: Names) -> Any:
    if not isinstance(value, dict):
        return value
    return {**value, **{name: names.key(value[name]) for name in ("part", "path") if isinstance(value.get(name), str)}}


def _is_list(value: Any) -> bool:
    return isinstance(value, list)
