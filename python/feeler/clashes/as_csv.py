"""Findings as CSV, a line each, in SI units."""

from __future__ import annotations

import os

from feeler.arguments import check_kind
from feeler.atomic import atomic_file
from feeler.choices import GroupBy
from feeler.clashes.columns import COLUMNS, cells
from feeler.clashes.result import Clashes
from feeler.io.csv_table import csv_table


def write_csv(path: str | os.PathLike[str], clashes: Clashes, *, by: GroupBy = "part") -> None:
    """Writes a line for each finding, the worst first. Numbers have just enough digits to read back unchanged.

    Unknown values, such as a volume that was not measured, are empty fields. Text that a spreadsheet would take for a
    formula gets a leading apostrophe, and control characters are replaced. by: how to group, as in `Clashes.groups`.
    Raises `WriteError`.
    """
    check_kind("clashes", clashes, Clashes)
    with atomic_file(path, ".csv") as file:
        file.write(csv_table([column.name for column in COLUMNS], cells(clashes, by)))
