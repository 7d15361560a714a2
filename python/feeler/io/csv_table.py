"""CSV that a spreadsheet opens without executing any of it.

Part names come from files, and a spreadsheet evaluates a cell that begins with `=`. Such text gets a leading apostrophe
(OWASP, "CSV Injection"); numbers stay numbers. The file begins with a UTF-8 byte order mark, because Excel reads a file
without one in the code page of the machine. Read it back as `utf-8-sig`.
"""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Iterable, Sequence

import numpy as np

from feeler.arguments import check_list, check_real

Cell = str | int | float | None

_FORMULA = tuple("=+-@\t\r\n\uff1d\uff0b\uff0d\uff20")
"""First characters of cells that spreadsheets evaluate, including the full-width forms of =, +, - and @. Some skip a
tab or a line break before them."""

_CONTROL = re.compile("[\0-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
"""Characters that no sheet shows, and that XML forbids or discourages."""

_QUOTED = frozenset('",;\t\r\n')
"""Characters that make a field quoted. The semicolon separates fields where the comma is the decimal mark."""


def csv_table(heading: Sequence[str], rows: Iterable[Sequence[Cell]]) -> bytes:
    """A CSV file: the heading, then a line for each row.

    Numbers have the fewest digits that read back the same; None, and numbers that are not finite, are empty fields.
    """
    heading = check_list("heading", heading, "a list of texts")
    rows = [check_list("rows", row, "a list of lists of cells") for row in check_list("rows", rows, "a list of rows")]
    lines = [",".join(_field(cell) for cell in row) + "\n" for row in (heading, *rows)]
    return codecs.BOM_UTF8 + "".join(lines).encode("utf-8", errors="replace")


def plain(text: str) -> str:
    """Text with the replacement character for control characters; tabs and line breaks stay."""
    return _CONTROL.sub("\ufffd", text)


def harmless(text: str) -> str:
    """Text that a spreadsheet shows unchanged: with a leading apostrophe if it would be evaluated."""
    return "'" + text if text.startswith(_FORMULA) or text.lstrip().startswith(_FORMULA) else text


def _field(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, (int, np.integer)):
        return str(int(cell))
    if not isinstance(cell, str):
        return _number(check_real("a cell", cell, "text, a number or None"))
    text = harmless(plain(cell))
    if _QUOTED.isdisjoint(text) and text == text.strip():
        return text
    return '"' + text.replace('"', '""') + '"'


def _number(value: float) -> str:
    return repr(value) if math.isfinite(value) else ""
