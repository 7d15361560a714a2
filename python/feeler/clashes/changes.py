"""Changes from one check to the next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Generic

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_length
from feeler.clashes.joining import joined
from feeler.clashes.matching import PartMatch, matched
from feeler.clashes.shapes import PartShapes, Shapes, shapes_of, unknown
from feeler.clashes.table import AnyTable, Table
from feeler.clashes.tracking import Mark, check_of, clash_id, followed, part_keys
from feeler.errors import LoadError, OptionError
from feeler.mockup import Mockup

Pair = tuple[str, str, str]
"""A finding by its rule and the keys of both parts, in the order of their characters."""


class _Known(Generic[AnyTable]):
    """A table of the previous check, with the part of this check that each of its parts matches."""

    def __init__(self, table: AnyTable, now: Shapes) -> None:
        self.table = table
        names = [table.keys[part] for part in np.union1d(table.parts_a, table.parts_b)]
        self.shapes = table.shapes.joined(unknown(names))
        new_of_old, is_same, is_ambiguous = matched(self.shapes, now)
        row_of_key = {key: row for row, key in enumerate(self.shapes.keys)}
        self.key_now: dict[str, str] = {}
        """The key of each matched part now, by its previous key."""
        self.renamed: dict[str, str] = {}
        """How a key changed, "renamed" or "renumbered", by the previous key; only keys that changed."""
        self.altered = 0
        """The number of parts with the same key, but another shape or place."""
        self.ambiguous = int(np.count_nonzero(is_ambiguous[[row_of_key[name] for name in names]]))
        """The number of parts that match two copies equally well, and so neither."""
        is_altered = self.shapes.is_known & ~is_same
        is_known_now = now.is_known
        for name in names:
            row = row_of_key[name]
            new = int(new_of_old[row])
            if new < 0:
                continue
            self.key_now[name] = key = now.keys[new]
            if key != name:
                self.renamed[name] = "renumbered" if self.shapes.paths[row] == now.paths[new] else "renamed"
            else:
                self.altered += int(is_altered[row] and is_known_now[new])
        self.names = names
        self._gone = [i for i, new in enumerate(new_of_old.tolist()) if new < 0]

    def rows(self) -> Iterator[tuple[Pair | None, str]]:
        """For each finding: its pair now, None if a part is gone; and how the keys of its parts changed."""
        keys, table = self.table.keys, self.table
        for rule, a, b in zip(table.rules.tolist(), table.parts_a.tolist(), table.parts_b.tolist(), strict=True):
            one, other = keys[a], keys[b]
            if one not in self.key_now or other not in self.key_now:
                yield None, ""
                continue
            changed = {self.renamed.get(one, ""), self.renamed.get(other, "")} - {""}
            yield _pair(rule, self.key_now[one], self.key_now[other]), min(changed, default="")

    def gone(self) -> Shapes:
        """The parts that match no part of this check."""
        return self.shapes.rows(self._gone)

    def match(self) -> PartMatch:
        """How many parts with findings match a part of this check."""
        renamed = {name: self.key_now[name] for name in self.renamed}
        by_path = len(self.key_now) - len(renamed)
        return PartMatch(len(self.names), by_path, self.altered, len(renamed), renamed, self.ambiguous)


def compare(now: AnyTable, before: AnyTable, growth: float) -> PartMatch:
    """See `Clashes.diff`: gives `now` its statuses and earlier findings, and says how the parts match."""
    given: object = before
    if not isinstance(given, type(now)):
        raise OptionError(f"previous is {type(given).__name__}: give Clashes, such as of feeler.load_clashes")
    check_length("growth", growth)
    shapes = now.shapes.joined(unknown(now.keys))
    known = _known(before, shapes)
    _check_match(known, shapes)
    marks, left = _carried(now, known, growth)
    # Findings of pairs that were not checked, or that a rule hides now, keep their status.
    skipped = [_skipped(now, each, rows) for each, rows in zip(known, left, strict=True)]
    waiting = _waiting(known, [rows[is_out] for rows, is_out in zip(left, skipped, strict=True)], shapes)
    gone = [each.table[rows[~is_out]] for each, rows, is_out in zip(known, left, skipped, strict=True)]
    resolved = joined(gone, [table.keys for table in gone], None, "resolved")
    earlier = waiting if not len(resolved) else resolved
    if len(waiting) and len(resolved):
        both = waiting, resolved
        earlier = joined(both, [table.keys for table in both], waiting._shapes)
    now.marks.replace(marks)
    now.marks.former, now.marks.former_check = (
        _former(now, known[0]),
        check_of(before.ids, (before.points_a, before.points_b)),
    )
    now.marks.renamed = _renamed(known)
    ended = {*resolved.ids, *marks}
    now.marks.aside = {each: mark for each, mark in before.marks.aside.items() if each not in ended}
    now._set_earlier(earlier)
    return known[0].match()


def _former(now: AnyTable, known: _Known[AnyTable]) -> dict[str, str | None]:
    """The id here of each finding of the previous check; None if it is gone."""
    keys = now.keys
    rows = zip(now.ids, now.rules.tolist(), now.parts_a.tolist(), now.parts_b.tolist(), strict=True)
    here = {_pair(rule, keys[a], keys[b]): each for each, rule, a, b in rows}
    pairs = zip(known.table.ids, known.rows(), strict=True)
    return {each: None if pair is None else here.get(pair) for each, (pair, _) in pairs}


def _renamed(known: Sequence[_Known[AnyTable]]) -> dict[str, str]:
    """The id of now by the earlier one, of findings whose parts have other keys."""
    found = {}
    for each in known:
        for before, (pair, changed) in zip(each.table.ids, each.rows(), strict=True):
            if pair is not None and changed:
                found[before] = clash_id(*pair)
    return found


def _known(before: AnyTable, now: Shapes) -> list[_Known[AnyTable]]:
    """The findings of the previous check, and the unresolved ones that it kept from earlier checks."""
    waiting = before.earlier()
    waiting = waiting[waiting.statuses != "resolved"]
    return [_Known(table, now) for table in ((before, waiting) if len(waiting) else (before,))]


def _carried(
    now: AnyTable, known: Sequence[_Known[AnyTable]], growth: float
) -> tuple[dict[str, Mark], list[npt.NDArray[np.intp]]]:
    """The mark of each finding by id, and the rows of each previous table that were not found again."""
    keys = now.keys
    rows = zip(now.rules.tolist(), now.parts_a.tolist(), now.parts_b.tolist(), strict=True)
    here = {_pair(rule, keys[a], keys[b]) for rule, a, b in rows}
    before: dict[Pair, Mark] = {}
    left = []
    for each in known:
        lost = []
        for row, (pair, changed) in enumerate(each.rows()):
            if pair in here and pair is not None:
                mark = each.table.marks.of(each.table.ids[row])
                before.setdefault(pair, replace(mark, changed=changed))
            else:
                lost.append(row)
        left.append(np.array(lost, dtype=np.intp))
    after = {}
    aside = known[0].table.marks.aside
    rows = zip(now.rules.tolist(), now.parts_a.tolist(), now.parts_b.tolist(), strict=True)
    for each_id, found, (rule, a, b) in zip(now.ids, now.found(), rows, strict=True):
        known_mark = before.get(_pair(rule, keys[a], keys[b]), aside.get(each_id))
        after[each_id] = followed(known_mark, found, growth)
    return after, left


def _skipped(now: Table, known: _Known[AnyTable], rows: npt.NDArray[np.intp]) -> npt.NDArray[np.bool_]:
    """Which rows of an earlier table this check did not look at."""
    if now.is_partial:
        return np.ones(len(rows), dtype=bool)
    found = np.zeros(len(rows), dtype=bool)
    if now._scope is None or not len(rows):
        return found
    part_of_key = {key: part for part, key in enumerate(now.keys)}
    pairs = [*known.rows()]
    places, sides = [], []
    for place, row in enumerate(rows.tolist()):
        pair, _ = pairs[row]
        if pair is not None and pair[1] in part_of_key and pair[2] in part_of_key:
            places.append(place)
            sides.append((part_of_key[pair[1]], part_of_key[pair[2]]))
    if sides:
        a, b = np.array(sides, dtype=np.uint32).T
        gaps = -known.table.signed_depths[rows[places]]
        found[places] = now._scope.leaves_out(a, b, gaps)
    return found


def _waiting(known: Sequence[_Known[AnyTable]], left: Sequence[npt.NDArray[np.intp]], now: Shapes) -> AnyTable:
    """Rows that were not found again, with the current keys of their parts.

    Leaves out a row if one of its parts is gone and another part now has its key.
    """
    taken = set(now.keys)
    tables: list[AnyTable] = []
    keys = []
    shapes = now
    for each, rows in zip(known, left, strict=True):
        table = each.table
        is_clear = np.array([key in each.key_now or key not in taken for key in table.keys], dtype=bool)
        tables.append(table[rows[is_clear[table.parts_a[rows]] & is_clear[table.parts_b[rows]]]])
        keys.append([each.key_now.get(key, key) for key in table.keys])
        shapes = shapes.joined(each.gone())
    return joined(tables, keys, PartShapes(shapes))


def _pair(rule: str, one: str, other: str) -> Pair:
    return (rule, one, other) if one <= other else (rule, other, one)


def check_previous(mockup: Mockup, before: Table) -> None:
    """Raises `LoadError` if no part of the previous findings is in the mock-up, by path or by shape.

    Compares shapes only if no path matches.
    """
    keys = part_keys(mockup.part_paths)
    names = {before.keys[part] for part in np.union1d(before.parts_a, before.parts_b)}
    if names.isdisjoint(keys):
        shapes = shapes_of(mockup)
        _check_match(_known(before, shapes), shapes)


def _check_match(known: Sequence[_Known[AnyTable]], now: Shapes) -> None:
    names = sorted({name for each in known for name in each.names})
    if not names or any(each.key_now or each.ambiguous for each in known):
        return
    hint = "" if any(each.shapes.is_known.any() for each in known) else "; they were saved without shapes"
    raise LoadError(
        f"none of the saved parts exist in this mock-up (0 of {len(names):,}, such as {names[0]!r}, match one of its "
        f"{len(now.keys):,} parts by path or by shape{hint}). Give the findings of this mock-up, or run without them."
    )
