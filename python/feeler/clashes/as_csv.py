"""Findings as CSV, a line each, in SI units."""

from __future__ import annotations

import os

from feeler.clashes.table import Clashes
from feeler.io.atomic import atomic_file
from feeler.io.csv_table import Cell, csv_table

_XYZ = ("x", "y", "z")
COLUMNS = (
    *("id", "status", "severity", "verdict", "rule", "group", "part_a", "path_a", "part_b", "path_b"),
    *("depth_m", "depth_kind", "gap_m", "volume_m3", "triangle_pairs", "open_a", "open_b"),
    *(f"{what}_{axis}_m" for what in ("translation", "point_a", "point_b", "lower", "upper") for axis in _XYZ),
    *("by", "note"),
)


def write_csv(path: str | os.PathLike[str], clashes: Clashes, *, by: str = "part") -> None:
    """Writes a line for each finding, the worst first; numbers are the shortest that read back the same.

    Unknown values, such as a volume that was not measured, are empty fields. Text that a spreadsheet would compute gets
    an apostrophe in front. by: how groups are made. Raises `WriteError`.
    """
    rows: list[list[Cell]] = []
    group_of = {int(row): group.name for group in clashes.groups(by) for row in group.rows}
    for place, clash in enumerate(clashes):
        vectors = (clash.translation, clash.point_a, clash.point_b, *clash.box)
        rows.append(
            [
                *(clash.id, clash.status, clash.severity, clash.verdict.name.lower(), clash.rule, group_of[place]),
                *(clash.a, clash.path_a, clash.b, clash.path_b),
                *(clash.depth, clash.depth_kind, clash.gap, clash.volume),
                *(clash.triangles, int(clash.is_open_a), int(clash.is_open_b)),
                *(value for vector in vectors for value in vector),
                *(clash.by, clash.note),
            ]
        )
    with atomic_file(path) as file:
        file.write(csv_table(COLUMNS, rows))
