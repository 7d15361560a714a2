"""The columns of a table of findings, for CSV and for spreadsheets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter

from feeler.choices import GroupBy
from feeler.clashes.result import Clashes
from feeler.clashes.table import Clash
from feeler.io.csv_table import Cell


@dataclass(frozen=True)
class Column:
    """One column. name: with its unit, as in CSV. value: makes the cell from a finding and the name of its group."""

    name: str
    value: Callable[[Clash, str], Cell]

    @property
    def title(self) -> str:
        """The heading in a spreadsheet, such as "depth, m"."""
        for ending, unit in (("_m3", ", m³"), ("_m", ", m")):
            if self.name.endswith(ending):
                return self.name.removesuffix(ending).replace("_", " ") + unit
        return self.name.replace("_", " ")


def _field(name: str, attribute: str) -> Column:
    get = attrgetter(attribute)
    return Column(name, lambda clash, _group: get(clash))


def _vector(name: str, get: Callable[[Clash], tuple[float, float, float]]) -> Iterator[Column]:
    for place, axis in enumerate("xyz"):
        yield Column(f"{name}_{axis}_m", lambda clash, _group, place=place: get(clash)[place])  # type: ignore[misc]


COLUMNS = (
    *(_field(name, name) for name in ("id", "status", "severity")),
    Column("verdict", lambda clash, _group: clash.verdict.value),
    _field("rule", "rule"),
    Column("group", lambda _clash, group: group),
    *(_field("part_a", "a"), _field("path_a", "path_a"), _field("part_b", "b"), _field("path_b", "path_b")),
    _field("depth_m", "depth"),
    _field("depth_error_m", "depth_error"),
    *(_field("depth_kind", "depth_kind"), _field("gap_m", "gap"), _field("volume_m3", "volume")),
    _field("triangle_pairs", "triangles"),
    Column("open_a", lambda clash, _group: int(clash.is_open_a)),
    Column("open_b", lambda clash, _group: int(clash.is_open_b)),
    *_vector("translation", lambda clash: clash.translation),
    *_vector("point_a", lambda clash: clash.point_a),
    *_vector("point_b", lambda clash: clash.point_b),
    *_vector("lower", lambda clash: clash.box[0]),
    *_vector("upper", lambda clash: clash.box[1]),
    *(_field("by", "by"), _field("note", "note")),
)


def cells(clashes: Clashes, by: GroupBy) -> Iterator[list[Cell]]:
    """The cells of each finding, the worst first. by: how to group, as in `Clashes.groups`."""
    group_of = {int(row): group.name for group in clashes.groups(by) for row in group.rows}
    for place, clash in enumerate(clashes):
        yield [column.value(clash, group_of[place]) for column in COLUMNS]
