"""Findings as an Excel workbook with pictures, a row for each. Needs XlsxWriter, the extra `feeler[xlsx]`."""

from __future__ import annotations

import datetime
import io
import os
from collections.abc import Callable
from typing import Any

from feeler.arguments import check_kind, check_progress, check_whole, check_word
from feeler.atomic import atomic_file
from feeler.choices import GROUPS_BY, GroupBy
from feeler.clashes.advice import advice
from feeler.clashes.as_json import statuses
from feeler.clashes.columns import COLUMNS, cells
from feeler.clashes.result import Clashes
from feeler.clashes.verdict import Verdict
from feeler.clashes.words import capitalised, hidden, shared
from feeler.io.csv_table import Cell
from feeler.io.xlsx import write_cell, xlsx_library
from feeler.mockup import Mockup
from feeler.progress import Progress

MOST_PICTURES = 200
"""Most findings with a picture, the worst first: about 20 kB and 0.05 s each."""
MOST_ROWS = 100_000
"""Most findings in a workbook, the worst first: 30 MB. CSV and JSON have all."""

_SCALE, _ROW_HEIGHT, _PICTURE_WIDTH = 0.35, 80.0, 25.0
"""Of a picture of 480 by 300 pixels; points; characters of the sheet's font."""
_WIDTHS = {"id": 12.0, "group": 30.0, "path_a": 40.0, "path_b": 40.0, "note": 30.0}
_WIDTH = 12.0
_CREATED = datetime.datetime(1980, 1, 1)
"""Fixed, so that equal findings give equal bytes."""


def write_xlsx(
    path: str | os.PathLike[str],
    clashes: Clashes,
    mockup: Mockup | None = None,
    *,
    by: GroupBy = "part",
    pictures: int = MOST_PICTURES,
    progress: Progress | None = None,
) -> None:
    """Writes a sheet with a row for each of the `MOST_ROWS` worst findings, and a sheet with the summary.

    Text is never stored as a formula. Numbers are numbers, with units in the headings. With `mockup`, the `pictures`
    worst findings have a picture. by: how to group, as in `Clashes.groups`. Raises `WriteError`, and `OptionError` for
    clashes of another mock-up, or if XlsxWriter is not installed.
    """
    check_kind("clashes", clashes, Clashes)
    pictures = check_whole("pictures", pictures)
    check_progress(progress)
    check_word("by", by, GROUPS_BY)
    library = xlsx_library()
    drawn = _drawing(clashes, mockup) if mockup is not None else None
    count = min(len(clashes), MOST_ROWS)
    pictured = min(pictures, count) if drawn is not None else 0
    with atomic_file(path, ".xlsx") as file:
        # Into memory first: XlsxWriter has errors of its own for a full disk.
        data = io.BytesIO()
        book = library.Workbook(
            data,
            {
                "constant_memory": True,
                "strings_to_formulas": False,
                "strings_to_urls": False,
                "strings_to_numbers": False,
            },
        )
        try:
            book.set_properties({"title": "Clashes", "created": _CREATED})
            bold = book.add_format({"bold": True, "bottom": 1})
            top = book.add_format({"valign": "top"})
            sheet = book.add_worksheet("findings")
            sheet.freeze_panes(1, 0)
            sheet.autofilter(0, 0, max(count, 1), len(COLUMNS))
            sheet.set_column(0, 0, _PICTURE_WIDTH if pictured else 8.0)
            for place, column in enumerate(COLUMNS, start=1):
                sheet.set_column(place, place, _WIDTHS.get(column.name, _WIDTH))
            for place, title in enumerate(["picture", *(column.title for column in COLUMNS)]):
                sheet.write_string(0, place, title, bold)
            for number, row in enumerate(cells(clashes[:count], by), start=1):
                if number <= pictured and drawn is not None:
                    if progress is not None:
                        progress((number - 1) / pictured, f"picture {number} of {pictured}")
                    sheet.set_row(number, _ROW_HEIGHT)
                    image = {"image_data": io.BytesIO(drawn(number - 1)), "x_scale": _SCALE, "y_scale": _SCALE}
                    sheet.insert_image(number, 0, f"{number}.png", {**image, "object_position": 1})
                for place, cell in enumerate(row, start=1):
                    write_cell(sheet, number, place, cell, top)
            _summary(book.add_worksheet("summary"), clashes, count, pictured, bold)
        finally:
            book.close()  # removes its own files, too
        file.write(data.getvalue())


def _drawing(clashes: Clashes, mockup: Mockup) -> Callable[[int], bytes]:
    """The picture of a row, as PNG."""
    from feeler.clashes.pictures import Pictures
    from feeler.clashes.table import check_same

    check_same(mockup, clashes)
    pictures = Pictures(mockup)
    return lambda row: pictures.png(clashes[row])


def _summary(sheet: Any, clashes: Clashes, count: int, pictured: int, bold: Any) -> None:
    facts = clashes.facts
    verdicts = [(each.value, len(clashes.where(verdict=each))) for each in Verdict]
    lines: list[tuple[str, Cell]] = [
        ("mock-up", ", ".join(facts.files)),
        ("parts", facts.parts),
        ("triangles", facts.triangles),
        ("clearance, m", facts.clearance),
        ("contact, m", facts.contact),
        ("findings", len(clashes)),
        *verdicts,
        *statuses(clashes).items(),
        *([("shared volume", shared(clashes))] if shared(clashes) else []),
        *([("hidden", hidden(clashes))] if clashes.hidden else []),
        *([("partial", "the check was stopped. More findings may exist")] if clashes.is_partial else []),
        *(("note", capitalised(each)) for each in advice(clashes)),
        *([("note", f"The {count:,} worst findings are in this workbook")] if count < len(clashes) else []),
        *([("note", f"The {pictured:,} worst findings have pictures")] if 0 < pictured < count else []),
    ]
    sheet.set_column(0, 0, 16.0)
    sheet.set_column(1, 1, 80.0)
    for row, (name, value) in enumerate(lines):
        sheet.write_string(row, 0, name, bold)
        write_cell(sheet, row, 1, value)
