"""A nightly run as one HTML page that loads nothing, and as an Excel workbook."""

from __future__ import annotations

import datetime
import io
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from feeler.atomic import atomic_file
from feeler.io.csv_table import Cell
from feeler.io.xlsx import write_cell, xlsx_library
from feeler.tasks.night_rows import MaintainRow
from feeler.tasks.snapshots import MaintainChange
from feeler.tasks.steps import clock

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'"
_STYLE = """
:root { color-scheme: light dark; --line: #8885; --soft: #8882; }
body { font: 14px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1400px; padding: 1.5em; }
h1, p { overflow-wrap: anywhere; }
h1 { font-size: 1.5em; margin: 0 0 .2em; } h2 { font-size: 1.15em; margin: 2em 0 .6em; }
table { border-collapse: collapse; width: 100%; }
th, td { padding: .35em .6em; text-align: left; vertical-align: top; overflow-wrap: anywhere; }
th { border-bottom: 2px solid var(--line); white-space: nowrap; } td { border-bottom: 1px solid var(--soft); }
.number { text-align: right; white-space: nowrap; } .small { opacity: .75; font-size: .9em; }
tr.worse td:first-child { border-left: 4px solid #d33; } tr.better td:first-child { border-left: 4px solid #2a4; }
tr.other td:first-child { border-left: 4px solid #38f; }
.note { border-left: 4px solid #38f; padding: .4em .8em; background: #38f1; }
@media (max-width: 800px) { table { display: block; overflow-x: auto; } td { overflow-wrap: break-word; } }
"""
_CREATED = datetime.datetime(1980, 1, 1)
"""Fixed, so that equal runs give equal bytes."""
_MOST_CHANGES = 500
_WIDE = {"part", "paths", "change", "why", "tools", "path", "causes", "hidden fasteners", "renamed from"}


def write_html(
    path: str | os.PathLike[str],
    said: str,
    rows: Sequence[MaintainRow],
    changes: Sequence[MaintainChange],
    is_partial: bool,
    renamed: Mapping[str, str],
) -> None:
    """Writes the page. renamed: paths of the last run by those of today. Raises `WriteError`."""
    changed = [row for row in rows if row.change or row.state == "failed"]
    rest = [row for row in rows if not (row.change or row.state == "failed")]
    page = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Maintenance</title><style>{_STYLE}</style></head><body><main>",
        f"<h1>Maintenance</h1><p>{escape(said)}</p>",
        *(['<p class="note">The run was interrupted: rows are missing.</p>'] if is_partial else []),
        *(["<h2>Changed</h2>", *_table(changed)] if changed else []),
        *(["<h2>As before</h2>" if changed else "<h2>Parts</h2>", *_table(rest)] if rest else []),
        *_changes(changes),
        *_renamed(renamed),
        "</main></body></html>",
    ]
    with atomic_file(path, ".html") as file:
        file.write("\n".join(page).encode("utf-8", errors="replace"))


def why(row: MaintainRow) -> str:
    """Why a row has no time; empty if it has one."""
    if row.error:
        return row.error
    if row.state == "out":
        return ""
    return row.said + (f"; in the way: {', '.join(row.blockers[:5])}" if row.blockers else "")


def renamed_from(row: MaintainRow) -> str:
    """Which paths the parts of a row had in the last run; empty if they are the same."""
    first, more = row.renamed_from[:1], len(row.renamed_from) - 1
    return "".join(f"renamed from {each}" for each in first) + (f" and {more:,} more" if more > 0 else "")


def _table(rows: Iterable[MaintainRow]) -> list[str]:
    heads = ("part", "state", "time", "low", "high", "steps", "tools", "reach", "sight", "change")
    numbers = {2, 3, 4, 5, 7, 8}
    lines = [
        "<table>",
        "<tr>" + "".join(_cell("th", n in numbers, escape(each)) for n, each in enumerate(heads)) + "</tr>",
    ]
    for row in rows:
        kind = "worse" if row.is_slower or row.state == "failed" else "better" if row.delta < 0.0 else "other"
        paths = escape(", ".join(row.paths[:5]) + (f" and {len(row.paths) - 5} more" if len(row.paths) > 5 else ""))
        name = escape(row.name) + (f'<div class="small">{paths}</div>' if row.paths != (row.name,) else "")
        name += f'<div class="small">{escape(said)}</div>' if (said := renamed_from(row)) else ""
        reason = why(row)
        state = escape(row.state) + (f'<div class="small">{escape(reason)}</div>' if reason else "")
        causes = "; ".join(str(each) for each in row.causes[:8])
        change = escape(row.change) + (f'<div class="small">{escape(causes)}</div>' if causes else "")
        cells = [
            *(name, state, _time(row.seconds), _time(row.low), _time(row.high), str(row.steps)),
            *(escape(", ".join(row.tools)), _shown(row.reach_deg, "{:.0f}°"), _sight(row), change),
        ]
        mark = f' class="{kind}"' if row.change or row.state == "failed" else ""
        lines.append(f"<tr{mark}>" + "".join(_cell("td", n in numbers, cell) for n, cell in enumerate(cells)) + "</tr>")
    return [*lines, "</table>"]


def _cell(tag: str, is_number: bool, text: str) -> str:
    return f"<{tag}{' class=number' if is_number else ''}>{text}</{tag}>"


def _time(seconds: float) -> str:
    return "" if math.isnan(seconds) else escape(clock(seconds))


def _shown(value: float, form: str) -> str:
    return "" if math.isnan(value) else form.format(value)


def _sight(row: MaintainRow) -> str:
    text = _shown(row.sight, "{:.0%}")
    return text + (f'<div class="small">{len(row.hidden)} hidden</div>' if row.hidden else "")


def _changes(changes: Sequence[MaintainChange]) -> list[str]:
    if not changes:
        return []
    rows = [f"<tr><td>{escape(each.path)}</td><td>{escape(each.what)}</td></tr>" for each in changes[:_MOST_CHANGES]]
    more = len(changes) - _MOST_CHANGES
    note = [f"<p>{more:,} more are in the JSON file.</p>"] if more > 0 else []
    return ["<h2>Parts that changed</h2>", "<table><tr><th>part</th><th>what</th></tr>", *rows, "</table>", *note]


def _renamed(renamed: Mapping[str, str]) -> list[str]:
    if not renamed:
        return []
    some = sorted(renamed.items())[:_MOST_CHANGES]
    rows = [f"<tr><td>{escape(now)}</td><td>{escape(then)}</td></tr>" for now, then in some]
    more = len(renamed) - len(some)
    note = [f"<p>{more:,} more are in the JSON file.</p>"] if more > 0 else []
    return ["<h2>Renamed parts</h2>", "<table><tr><th>part</th><th>renamed from</th></tr>", *rows, "</table>", *note]


def write_xlsx(
    path: str | os.PathLike[str],
    rows: Sequence[MaintainRow],
    changes: Sequence[MaintainChange],
    renamed: Mapping[str, str],
) -> None:
    """Writes sheets of the rows, of the parts that changed, and of those with other paths. Text is never a formula.

    Raises `WriteError`, and `OptionError` if XlsxWriter is not installed.
    """
    library = xlsx_library()
    with atomic_file(path, ".xlsx") as file:
        data = io.BytesIO()
        options = {"strings_to_formulas": False, "strings_to_urls": False, "strings_to_numbers": False}
        book = library.Workbook(data, options)
        try:
            book.set_properties({"title": "Maintenance", "created": _CREATED})
            bold = book.add_format({"bold": True, "bottom": 1})
            for name, heads, lines in _sheets(rows, changes, renamed):
                sheet = book.add_worksheet(name)
                sheet.freeze_panes(1, 0)
                for column, head in enumerate(heads):
                    sheet.set_column(column, column, 40.0 if head in _WIDE else 12.0)
                    sheet.write_string(0, column, head, bold)
                for number, row in enumerate(lines, start=1):
                    for column, cell in enumerate(row):
                        write_cell(sheet, number, column, cell)
        finally:
            book.close()
        file.write(data.getvalue())


def _sheets(
    rows: Sequence[MaintainRow], changes: Sequence[MaintainChange], renamed: Mapping[str, str]
) -> Iterable[tuple[str, Sequence[str], list[Sequence[Cell]]]]:
    heads = ("part", "paths", "state", "seconds", "low, s", "high, s", "steps", "fasteners", "tools", "reach, deg")
    lines: list[Sequence[Cell]] = [
        (
            *(row.name, ", ".join(row.paths), row.state, row.seconds, row.low, row.high, row.steps, row.undone),
            *(", ".join(row.tools), row.reach_deg, row.sight, ", ".join(row.hidden), row.delta, row.change),
            *("; ".join(str(each) for each in row.causes), why(row), "yes" if row.is_kept else "no"),
        )
        for row in rows
    ]
    yield "rows", (*heads, "sight", "hidden fasteners", "more, s", "change", "causes", "why", "kept"), lines
    yield "changes", ("path", "what"), [(each.path, each.what) for each in changes]
    if renamed:
        yield "renamed", ("path", "renamed from"), [(now, then) for now, then in sorted(renamed.items())]
