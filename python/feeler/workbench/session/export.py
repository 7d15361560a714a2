"""Exports the sequence of removals: as a table (CSV), a page (HTML), or an animated model (GLB)."""

from __future__ import annotations

import html

import numpy as np

from feeler.io.csv_table import Cell, csv_table
from feeler.io.export import animated_glb
from feeler.io.film import Leg, motions_of, with_neighbours
from feeler.mockup import Mockup, Tool
from feeler.poses import inverse
from feeler.progress import Progress
from feeler.workbench.document import motion
from feeler.workbench.document.document import UNITS, Document, Removal
from feeler.workbench.document.line_facts import least_clearance, line_length, newest_check


def sequence_csv(document: Document, mockup: Mockup, progress: Progress) -> bytes:
    """A line for each removal, in order; lengths in the document's unit."""
    progress(0.0, "table")
    rows = [_cells(number, line, document, mockup) for number, line in enumerate(document.sequence, start=1)]
    return csv_table(_headings(document.unit), rows)


def sequence_html(document: Document, mockup: Mockup, progress: Progress) -> bytes:
    """A page with the same table; it loads no other files."""
    progress(0.0, "page")
    name = html.escape(document.mockup.name if document.mockup else "mock-up")
    head = "".join(f"<th>{html.escape(each)}</th>" for each in _headings(document.unit))
    rows = "\n".join(
        "<tr>"
        + "".join(f"<td>{html.escape(_shown(cell))}</td>" for cell in _cells(number, line, document, mockup))
        + "</tr>"
        for number, line in enumerate(document.sequence, start=1)
    )
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Removal sequence: {name}</title>
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; margin: 1rem; color: #1c2024; background: #fff; }}
h1 {{ font-size: 1.5rem; overflow-wrap: anywhere; }}
table {{ border-collapse: collapse; display: block; overflow-x: auto; }}
th, td {{ border-bottom: 1px solid #ccd2d8; padding: .4rem .8rem; text-align: left; vertical-align: top; }}
</style></head>
<body><main><h1>Removal sequence: {name}</h1>
<table><thead><tr>{head}</tr></thead>
<tbody>
{rows}
</tbody></table></main></body></html>
""".encode("utf-8", "replace")


def sequence_glb(document: Document, mockup: Mockup, progress: Progress) -> bytes:
    """The removals one after the other as an animated glTF: the moving parts, and the parts nearby."""
    progress(0.0, "parts")
    moving = sorted({part for line in document.sequence for part in line.parts})
    shown = with_neighbours(mockup, moving, document.absent)
    body = Tool.of_parts(mockup, shown, "sequence")
    place = {part: number for number, part in enumerate(shown)}
    legs = []
    for number, line in enumerate(document.sequence):
        progress(number / len(document.sequence), "way")
        way = np.stack([motion.matrix(each) for each in line.way])
        starts = {part: motion.matrix(dict(line.starts).get(part, motion.HOME)) for part in line.parts}
        legs.append(Leg(way @ inverse(way[0]), starts))
    return animated_glb(body, motions_of(legs, mockup, place))


def _headings(unit: str) -> list[str]:
    return ["step", "name", "parts", f"way ({unit})", f"least clearance ({unit})", "touched", "tool", "checked", "end"]


def _cells(number: int, line: Removal, document: Document, mockup: Mockup) -> list[Cell]:
    per_unit = UNITS[document.unit]
    clearance = least_clearance(document, line)
    return [
        number,
        line.name,
        "; ".join(mockup.part_paths[part] for part in line.parts),
        _rounded(line_length(line, mockup.part_bounds) / per_unit),
        None if clearance is None else _rounded(clearance / per_unit),
        "; ".join(line.touched),
        line.tool or "",
        checked(line, document),
        _end(number, line, document),
    ]


def checked(line: Removal, document: Document) -> str:
    """What the newest check of its way found, if the way, and what is around it, is still that one."""
    check = newest_check(document, line)
    return "not checked" if check is None or check.is_good is None else "holds" if check.is_good else "does not hold"


def _end(number: int, line: Removal, document: Document) -> str:
    """Where its parts are since: a short shove is not a removal, and a joint takes nothing out."""
    if any(part in later.parts for later in document.sequence[number:] for part in line.parts):
        return "moved again"
    if line.joint is not None:
        return "moved by a joint"
    if all(part in document.out for part in line.parts):
        return "out"
    return "not out" if any(part in document.moved for part in line.parts) else "put back"


def _rounded(length: float) -> float:
    return float(f"{length:.4g}")


def _shown(cell: Cell) -> str:
    return "" if cell is None else f"{cell:.4g}" if isinstance(cell, float) else str(cell)
