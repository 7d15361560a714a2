"""Joins the tables of several checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from feeler.choices import Status
from feeler.clashes.shapes import PartShapes
from feeler.clashes.table import AnyTable, Columns
from feeler.clashes.tracking import Mark


def joined(
    tables: Sequence[AnyTable], keys: Sequence[Sequence[str]], shapes: PartShapes | None, status: Status | None = None
) -> AnyTable:
    """The rows of all tables, the worst first, with the facts of the first table. Of rows with equal ids, the first
    stays.

    keys: the key of each part of each table. status: for all rows; None keeps the status of each row.
    """
    part_of_key: dict[str, int] = {}
    rules: dict[str, int] = {}
    moved = []
    marks_of_rows = []
    for table, names in zip(tables, keys, strict=True):
        of_part = np.zeros(len(names), dtype=np.uint32)
        for part in np.union1d(table.parts_a, table.parts_b).tolist():
            of_part[part] = part_of_key.setdefault(names[part], len(part_of_key))
        of_rule = np.array([rules.setdefault(name, len(rules)) for name in table.rule_names], dtype=np.uint32)
        columns = table.columns
        moved.append(replace(columns, a=of_part[columns.a], b=of_part[columns.b], rule=of_rule[columns.rule]))
        marks_of_rows += [table.marks.of(each) for each in table.ids]
    rows = Columns(*(np.concatenate([getattr(each, f.name) for each in moved]) for f in fields(Columns)))
    found = type(tables[0])(rows, list(part_of_key), list(rules), facts=tables[0].facts, shapes=shapes)
    marks: dict[str, Mark] = {}
    first = []
    for row, (each, mark) in enumerate(zip(found.ids, marks_of_rows, strict=True)):
        if each not in marks:
            marks[each] = replace(mark, status=status or mark.status)
            first.append(row)
    found.marks.replace(marks)
    found = found[np.array(first, dtype=np.intp)]
    return found[found.columns.order(found.keys, found.rule_names)]
