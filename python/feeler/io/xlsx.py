"""What all Excel workbooks need. XlsxWriter is the extra `feeler[xlsx]`."""

from __future__ import annotations

import importlib
import math
from typing import Any

from feeler.errors import OptionError
from feeler.io.csv_table import Cell, plain


def xlsx_library() -> Any:
    """The module XlsxWriter. Raises `OptionError` if it is not installed."""
    try:
        return importlib.import_module("xlsxwriter")
    except ImportError:
        raise OptionError('--xlsx needs XlsxWriter: pip install "feeler[xlsx]", or write CSV') from None


def write_cell(sheet: Any, row: int, column: int, cell: Cell, style: Any = None) -> None:
    """Writes text as text and numbers as numbers. Unknown values stay empty."""
    if isinstance(cell, str):
        sheet.write_string(row, column, plain(cell), style)  # it cuts text that is too long for a cell of Excel
    elif cell is not None and math.isfinite(cell):
        sheet.write_number(row, column, cell, style)
