"""A report as an Excel workbook with a sheet for each kind of rows. Needs XlsxWriter, the extra `feeler[xlsx]`."""

from __future__ import annotations

import datetime
import io
import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from feeler.io.csv_table import Cell
from feeler.io.xlsx import xlsx_library
from feeler.workbench.report.values import (
    FindingRow,
    MaintenanceRow,
    Media,
    ReachRow,
    Report,
    RequirementRow,
    TaskStepRow,
    WayRow,
)

MOST_ROWS = 100_000
"""Rows of a sheet; JSON has all."""
_MOST_TEXT = 32_000  # characters that a cell of Excel holds, and some to spare
_CREATED = datetime.datetime(1980, 1, 1)
"""Fixed, so that equal reports give equal bytes."""
_WIDTHS = {
    **dict.fromkeys(("part", "other part"), 44.0),
    **dict.fromkeys(("parts", "sentence", "left out or moved"), 60.0),
    **dict.fromkeys(("note", "why"), 40.0),
    "name": 36.0,
}
_WIDTH = 14.0
_PICTURE_PX = 150
"""The height of a picture of a finding."""
_PICTURE_WIDTH = 32.0
_POINTS_PER_PX = 0.75

Rows = Iterable[Sequence[Cell]]


def xlsx_bytes(report: Report, media: Media | None = None) -> bytes:
    """The workbook. Texts are never stored as formulas; lengths are numbers in metres. Raises `OptionError` without
    XlsxWriter.

    media: its pictures of findings are in the last column of their sheet.
    """
    library = xlsx_library()
    data = io.BytesIO()
    options = {"strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
    book = library.Workbook(data, {"constant_memory": True, **options})
    try:
        book.set_properties({"title": "Report", "created": _CREATED})
        bold = book.add_format({"bold": True, "bottom": 1})
        top = book.add_format({"valign": "top", "text_wrap": True})
        for name, headings, rows in _sheets(report):
            sheet = book.add_worksheet(name)
            sheet.freeze_panes(1, 0)
            for column, heading in enumerate(headings):
                sheet.set_column(column, column, _WIDTHS.get(heading, _WIDTH))
                sheet.write_string(0, column, heading, bold)
            count = 0
            pictures = _pictures(report, media) if name == "findings" else []
            if any(pictures):
                sheet.set_column(len(headings), len(headings), _PICTURE_WIDTH)
                sheet.write_string(0, len(headings), "picture", bold)
            for number, row in enumerate(rows, start=1):
                if number > MOST_ROWS:
                    sheet.write_string(number, 0, f"The first {MOST_ROWS:,} rows; JSON has all.", bold)
                    break
                count = number
                for column, cell in enumerate(row):
                    _write(sheet, number, column, cell, top)
                if number <= len(pictures):
                    _draw(sheet, number, len(headings), pictures[number - 1])
            if count and name != "summary":
                sheet.autofilter(0, 0, count, len(headings) - 1)
    finally:
        book.close()
    return data.getvalue()


def _pictures(report: Report, media: Media | None) -> list[bytes]:
    """The picture of each finding, as PNG; empty for those without."""
    made = {} if media is None else media.pictures
    return [(made.get(f"finding-{row.id}") or [b""])[0] for row in report.findings]


def _draw(sheet: Any, row: int, column: int, png: bytes) -> None:
    if not png:
        return
    _, height = struct.unpack(">II", png[16:24])
    scale = _PICTURE_PX / height
    sheet.set_row(row, _POINTS_PER_PX * (_PICTURE_PX + 4))
    options = {"image_data": io.BytesIO(png), "x_scale": scale, "y_scale": scale, "x_offset": 2, "y_offset": 2}
    sheet.insert_image(row, column, "picture.png", {**options, "object_position": 1})


def _write(sheet: Any, row: int, column: int, cell: Cell, style: Any) -> None:
    """Text as text and numbers as numbers; unknown values stay empty."""
    if isinstance(cell, str):
        text = cell.encode("utf-8", errors="replace").decode("utf-8")[:_MOST_TEXT]
        sheet.write_string(row, column, text, style)
    elif cell is not None and math.isfinite(cell):
        sheet.write_number(row, column, cell, style)


def _sheets(report: Report) -> list[tuple[str, Sequence[str], Rows]]:
    ways = (
        (question, number, way)
        for question in report.questions
        for number, way in enumerate(question.ways or (None,), start=1)
    )
    reaches = ((question, row) for question in report.questions for row in question.reaches)
    run = report.maintenance
    return [
        ("summary", ("what", "sentence"), _summary(report)),
        ("requirements", _REQUIREMENT, map(_requirement, report.requirements)),
        ("findings", _FINDING, (_finding(number, row) for number, row in enumerate(report.findings, start=1))),
        ("ways", ("question", "sentence", "number", *_WAY), ([q.title, q.sentence, n, *_way(w)] for q, n, w in ways)),
        ("steps", ("number", *_WAY), ([number, *_way(way)] for number, way in enumerate(report.steps, start=1))),
        ("tasks", _TASK, ([question.title, *_task(row)] for question in report.questions for row in question.task)),
        ("access", _ACCESS, ([question.title, *_reach(row)] for question, row in reaches)),
        *([] if run is None else [("maintenance", _MAINTENANCE, map(_maintained, run.rows))]),
    ]


_REQUIREMENT = (
    *("name", "a", "b", "required, m", "verdict", "distance, m", "depth, m", "pairs", "part", "other part"),
    *("x, m", "y, m", "z, m", "out of date", "left out or moved"),
)


def _requirement(row: RequirementRow) -> list[Cell]:
    facts: list[Cell] = [row.name, row.a, row.b, row.required, row.status, row.gap, row.depth, row.pairs or None]
    return [*facts, row.path_a, row.path_b, *_xyz(row.point), row.stale, str(row.layout)]


_FINDING = (
    *("number", "id", "status", "verdict", "severity", "depth, m", "gap, m", "part", "other part", "group", "rule"),
    *("by", "note", "x, m", "y, m", "z, m", "out of date", "history"),
)


def _finding(number: int, row: FindingRow) -> list[Cell]:
    facts: list[Cell] = [f"F{number}", row.id, row.status, row.verdict, row.severity, row.depth, row.gap]
    history = "; ".join(f"{mark.at[:10]} {mark.status} {mark.by}".strip() for mark in row.history)
    return [*facts, row.a, row.b, row.group, row.rule, row.by, row.note, *_xyz(row.point), row.stale, history]


_ACCESS = (
    "question",
    "fastener",
    "kind",
    "tool",
    "tools that reach it",
    "reachable",
    "free swing, degrees",
    "why",
    "parts",
)


def _reach(row: ReachRow) -> list[Cell]:
    is_reachable = "yes" if row.is_reachable else "no"
    tools, blockers = "; ".join(row.tools), "; ".join(row.blockers)
    return [row.path, row.kind, row.tool, tools, is_reachable, row.swing_deg, row.because, blockers]


_TASK = (
    *("question", "number", "step", "part", "tool", "person", "start, s", "time, s", "spread, s", "edited"),
    *("arithmetic", "because"),
)


def _task(row: TaskStepRow) -> list[Cell]:
    facts: list[Cell] = [row.number, row.verb, row.path, row.tool, row.person, row.start, row.seconds, row.spread]
    return [*facts, row.edited, row.arithmetic, row.because]


_MAINTENANCE = (
    *("name", "parts", "state", "time, s", "spread, s", "steps", "tools", "reach, degrees", "sight", "heads not seen"),
    *("change", "why", "renamed from"),
)


def _maintained(row: MaintenanceRow) -> list[Cell]:
    facts: list[Cell] = [row.name, "; ".join(row.paths), row.state, row.seconds, row.spread, row.steps]
    return [*facts, "; ".join(row.tools), row.reach_deg, row.sight, row.hidden, row.change, row.why, row.renamed_from]


_WAY = (
    *("name", "parts", "way, m", "turned, degrees", "least clearance, m", "touched", "tool", "checked", "out of date"),
)


def _way(row: WayRow | None) -> list[Cell]:
    if row is None:  # a question without a way
        return [None] * len(_WAY)
    turned = None if row.rotation is None else float(np.degrees(row.rotation))
    paths, touched = "; ".join(row.paths), "; ".join(row.touched)
    return [row.title, paths, row.length, turned, row.clearance, touched, row.tool, row.checked, row.stale]


def _summary(report: Report) -> list[list[Cell]]:
    lines: list[list[Cell]] = [
        ["mock-up", ", ".join(report.sources) or report.title],
        ["content", report.content],
        ["parts", report.parts],
        ["triangles", report.triangles],
        ["project", report.project],
        ["tool", report.tool],
        ["changes", str(report.stale) if report.stale else "none since the results"],
        ["made", report.made],
        ["by", f"feeler {report.version}".strip()],
        ["requirements", len(report.requirements)],
        ["findings", len(report.findings)],
        ["questions", len(report.questions)],
        ["work steps", len(report.steps)],
    ]
    if report.check is not None and (said := str(report.check.layout)):
        lines.append(["clash check", said])
    if report.maintenance is not None:
        run = report.maintenance
        lines += [["maintenance", run.sentence], ["last run", run.at]]
        lines += [["changes since the run", run.stale]] if run.stale else []
    return lines + [["note", note] for note in report.notes]


def _xyz(point: Sequence[float] | None) -> list[Cell]:
    return [None] * 3 if point is None else list(point)
