"""A task as an Excel workbook. Needs XlsxWriter, the extra `feeler[xlsx]`."""

from __future__ import annotations

import datetime
import io
import math
import os
from collections.abc import Iterable, Sequence
from typing import Any

from feeler.atomic import atomic_file
from feeler.io.csv_table import Cell
from feeler.io.xlsx import write_cell, xlsx_library
from feeler.tasks.steps import TaskFacts
from feeler.tasks.times import EXAMPLES

_CREATED = datetime.datetime(1980, 1, 1)
"""Fixed, so that equal tasks give equal bytes."""
_WIDE = {"part", "arithmetic", "because", "parts", "in its way", "what"}


def write_xlsx(path: str | os.PathLike[str], task: TaskFacts) -> None:
    """Writes sheets of the steps, the totals and the elements, and of what is blocked. Text is never a formula.

    Raises `WriteError`, and `OptionError` if XlsxWriter is not installed.
    """
    library = xlsx_library()
    with atomic_file(path, ".xlsx") as file:
        data = io.BytesIO()
        book = library.Workbook(
            data, {"strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
        )
        try:
            book.set_properties({"title": "Task", "created": _CREATED})
            bold = book.add_format({"bold": True, "bottom": 1})
            for name, heads, rows in _sheets(task):
                _write(book.add_worksheet(name), heads, rows, bold)
        finally:
            book.close()
        file.write(data.getvalue())


def _sheets(task: TaskFacts) -> Iterable[tuple[str, Sequence[str], list[Sequence[Cell]]]]:
    heads = ("number", "verb", "part", "parts", "tool", "swing, deg", "strokes", "person", "start, s", "seconds")
    steps: list[Sequence[Cell]] = [
        (
            *(step.number + 1, step.verb, step.part, ", ".join(step.paths), step.tool),
            *(None if math.isnan(step.swing_deg) else step.swing_deg, step.strokes, step.person + 1, step.start),
            *(step.seconds, step.low, step.high, ", ".join(str(n + 1) for n in step.after), step.arithmetic),
            step.because,
        )
        for step in task.steps
    ]
    yield "steps", (*heads, "low, s", "high, s", "after", "arithmetic", "because"), steps
    total: list[Sequence[Cell]] = [
        ("result", task.said, None),
        ("from beginning to end", task.seconds, task.spread),
        ("no plan is below", task.bound, None),
        ("work of all", *task.work),
        *((f"tool: {name or 'by hand'}", *each) for name, each in task.by_tool.items()),
        *((f"person {person + 1}", *each) for person, each in task.by_person.items()),
        *(("note", note, None) for note in task.notes),
    ]
    yield "totals", ("what", "seconds", "spread"), total
    yield (
        "elements",
        ("element", "seconds", "spread", "what", "example"),
        [
            (name, mean, spread, EXAMPLES[name][2], "yes" if name in task.examples else "no")
            for name, (mean, spread) in task.elements.items()
        ],
    )
    if task.blocked:
        rows = [(each.part, each.because, ", ".join(each.blockers)) for each in task.blocked]
        yield "blocked", ("part", "because", "in its way"), list(rows)


def _write(sheet: Any, heads: Sequence[str], rows: Sequence[Sequence[Cell]], bold: Any) -> None:
    sheet.freeze_panes(1, 0)
    for column, head in enumerate(heads):
        sheet.set_column(column, column, 40.0 if head in _WIDE else 12.0)
        sheet.write_string(0, column, head, bold)
    for number, row in enumerate(rows, start=1):
        for column, cell in enumerate(row):
            write_cell(sheet, number, column, cell)
