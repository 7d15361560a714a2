"""Tables of several checks in one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from feeler.clashes.table import Clashes, Columns
from feeler.clashes.tracking import Marks, part_keys


def joined(tables: Sequence[Clashes]) -> Clashes:
    """The rows of all tables, in their order, with the facts of the first. Parts are called by their keys."""
    keys: dict[str, int] = {}
    rules: dict[str, int] = {}
    moved = []
    marks = {}
    for table in tables:
        names = part_keys(table.part_paths)
        place = {part: keys.setdefault(names[part], len(keys)) for part in _parts_of(table)}
        of_part = np.zeros(len(names), dtype=np.uint32)
        of_part[list(place)] = list(place.values())
        of_rule = np.array([rules.setdefault(name, len(rules)) for name in table.rules], dtype=np.uint32)
        columns = table.columns
        moved.append(replace(columns, a=of_part[columns.a], b=of_part[columns.b], rule=of_rule[columns.rule]))
        marks.update({each: table.marks.of(each) for each in table.ids})
    rows = Columns(*(np.concatenate([getattr(each, f.name) for each in moved]) for f in fields(Columns)))
    return Clashes(rows, list(keys), list(rules), marks=Marks(marks), facts=tables[0].facts)


def _parts_of(table: Clashes) -> list[int]:
    return np.union1d(table.a, table.b).tolist()  # type: ignore[no-any-return]
