"""What fasteners hold, as `holds` answers it: rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, overload

from feeler.arguments import check_kind, check_list, check_whole
from feeler.field_docs import documented
from feeler.mockup import Mockup
from feeler.renamed import OldAttributes
from feeler.words import plural

BODY = "bearing"
"""The kind of parts that leave as one."""


@documented
@dataclass(frozen=True)
class Hold:
    """What one fastener holds."""

    fastener: int
    """Its part, an index into `mockup.parts`."""
    path: str
    """The path of its part."""
    kind: str
    """"bolt", "screw", "nut" or "stud" as of `find_fasteners`; "circlip", "pin", "fitting" or "clip"; "given" if a
    table says so. "cotter": a cotter pin or the like across a bolt or a pin. "dowel": a pin through parts one behind
    the other, which come off along it. "bearing": no fastener, but the parts of a rolling bearing, which leave as
    one."""
    parts: tuple[int, ...]
    """The parts that come loose when it is undone, from its head inwards; itself if it is a plug or a sensor."""
    paths: tuple[str, ...]
    """The paths of `parts`."""
    washers: tuple[int, ...]
    """Washers on it, which come loose too."""
    anchor: int | None
    """The part, or the nut or bolt, that it is fastened in; None if none was found."""
    anchor_path: str
    """The path of `anchor`; empty if there is none."""
    mates: tuple[int, ...]
    """Other fasteners on its axis: to undo one of them is enough."""
    because: str
    """Why, in words."""

    def to_dict(self) -> dict[str, Any]:
        """A dict of plain Python values, as JSON takes them."""
        return dict(vars(self))


class Holds(OldAttributes, Sequence[Hold]):
    """What fasteners hold, sorted by their parts. See `holds`."""

    _RENAMED: ClassVar[Mapping[str, str]] = {"to_dict": "to_dicts"}

    def __init__(self, rows: Iterable[Hold]) -> None:
        found = [check_kind("rows", row, Hold) for row in check_list("rows", rows, "a list of feeler.Hold")]
        self._rows = tuple(sorted(found, key=lambda row: row.fastener))
        self._of = {row.fastener: row for row in self._rows}

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Hold: ...
    @overload
    def __getitem__(self, index: slice) -> Holds: ...
    def __getitem__(self, index: int | slice) -> Hold | Holds:
        return Holds(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[Hold]:
        return iter(self._rows)

    def __repr__(self) -> str:
        return f"Holds({plural(len(self), 'fastener')})"

    def of(self, fastener: int) -> Hold | None:
        """What the fastener of a part holds; None if the part is none."""
        return self._of.get(check_whole("fastener", fastener))

    def holding(self, part: int) -> Holds:
        """The fasteners that hold a part, washers included."""
        what = check_whole("part", part)
        return Holds(row for row in self._rows if what in row.parts or what in row.washers)

    def to_dicts(self) -> list[dict[str, Any]]:
        """A dict of plain Python values for each row."""
        return [row.to_dict() for row in self._rows]


def hold_of(
    mockup: Mockup,
    fastener: int,
    kind: str,
    parts: tuple[int, ...],
    washers: tuple[int, ...],
    anchor: int | None,
    mates: tuple[int, ...],
    because: str,
) -> Hold:
    """A row, with the paths of its parts."""
    paths = mockup.part_paths
    return Hold(
        fastener,
        paths[fastener],
        kind,
        parts,
        tuple(paths[each] for each in parts),
        washers,
        anchor,
        "" if anchor is None else paths[anchor],
        mates,
        because,
    )
