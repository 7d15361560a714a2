"""What is in each part of a mock-up, and what of it changed from one revision to the next.

The content of a part is a hash of all corners of its triangles. If it differs, the figures that no rigid motion changes
tell whether the part moved or has another shape: number of triangles, area, and the mean square and fourth power of the
distance from the centroid.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from feeler.clashes.shapes import shapes_of
from feeler.errors import LoadError
from feeler.field_docs import documented
from feeler.mockup import Mockup
from feeler.project.layout import MOST_TEXT
from feeler.project.store import Change as RowChange
from feeler.project.store import Row, put

Change = Literal["changed", "moved", "new"]
CHANGES: tuple[Change, ...] = ("changed", "moved", "new")

_EQUAL = 1e-6
"""How much figures of a moved part may differ, as a share, besides the rounding of its coordinates."""
_FLOAT32 = 2.0**-24
"""Rounding of a coordinate in most formats, as a share."""
_ROUNDINGS = 16.0
"""Roundings of a coordinate in the fourth power of a distance, in its radius."""
_MOST_SHARE = 0.01
"""Where rounding may change more than this, a part is called changed."""
_AT_ONCE = 65_536  # triangles
_MOST_FOLDERS = 32  # with another name


@dataclass(frozen=True)
class PartContent:
    """The content of one part.

    key: its path, with `#2` for the second part of a path. content: of its triangles, where they are. reach: its
    largest coordinate. base: the content that the project's answers are about; the same as `content` for a part that
    is not stale. change: how it differs.
    """

    key: str
    content: str
    triangles: int
    area: float
    second: float
    fourth: float
    reach: float
    base: str = ""
    change: Change | None = None

    def is_moved(self, before: PartContent) -> bool:
        """Whether this may be the other part after a rigid motion, and after rounding to float32."""
        if self.triangles != before.triangles or not self.area:
            return self.triangles == before.triangles and self.area == before.area
        radius = math.sqrt(self.second / (6.0 * self.area))  # the mean of the three corners, weighted by area
        rounding = _FLOAT32 * max(self.reach, before.reach)
        share = _EQUAL + _ROUNDINGS * rounding / max(radius, 1e-300)
        return share < _MOST_SHARE and all(
            math.isclose(getattr(self, name), getattr(before, name), rel_tol=share)
            for name in ("area", "second", "fourth")
        )


@documented
@dataclass(frozen=True)
class PartChanges:
    """The parts of a mock-up that differ from those that a project's answers are about.

    `changed`, `moved` and `new`: paths of parts of this mock-up, in its order; `gone`: paths of parts that it lacks;
    `renamed`: the present path by the previous one, of parts with the same triangles. Paths that several parts have end
    in `#2`, `#3` from the second part on. False if nothing differs.
    """

    changed: tuple[str, ...] = ()
    moved: tuple[str, ...] = ()
    new: tuple[str, ...] = ()
    gone: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.changed or self.moved or self.new or self.gone or self.renamed)

    def __str__(self) -> str:
        """In words."""
        counts = [(len(getattr(self, name)), name) for name in ("changed", "moved", "new", "gone", "renamed")]
        said = ", ".join(f"{count:,} {name}" for count, name in counts if count)
        return f"parts: {said}" if said else "no part changed"


def renamed_since(before: Mapping[str, str], revision: Revision) -> dict[str, str]:
    """The key of now by the first one. before: the same, up to this revision."""
    keys, middle = {part.key for part in revision.parts}, {*before.values()}
    found = {old: revision.renamed.get(new, new) for old, new in before.items()}
    found |= {old: new for old, new in revision.renamed.items() if old not in middle}
    return {old: new for old, new in found.items() if old != new and new in keys}


@dataclass(frozen=True)
class Revision:
    """A mock-up beside the parts that a project knows.

    parts: of the mock-up, in its order. gone: missing parts, of earlier revisions too. row_of: for each part
    that the project knew, its number now; None if it is gone. renamed: the key now by the key before. differs: by
    number, the parts that differ from the mock-up that was opened last: how, and their content then, empty for new
    ones.
    """

    parts: tuple[PartContent, ...]
    gone: tuple[PartContent, ...]
    row_of: tuple[int | None, ...]
    renamed: Mapping[str, str]
    differs: Mapping[int, tuple[Change, str]] = field(default_factory=dict)

    @cached_property
    def keys(self) -> frozenset[str]:
        """Those of the parts of the mock-up."""
        return frozenset(part.key for part in self.parts)

    @property
    def is_same(self) -> bool:
        """Whether all parts have the same numbers, keys and contents as before."""
        return not self.gone and self.is_numbered_as_before and not self.stale and not self.renamed

    @property
    def is_numbered_as_before(self) -> bool:
        """Whether each part has the number that it had, and there are no others."""
        return self.row_of == tuple(range(len(self.parts)))

    @property
    def stale(self) -> dict[int, Change]:
        """The change of each stale part by its number."""
        return {number: part.change for number, part in enumerate(self.parts) if part.change is not None}

    def changes(self) -> PartChanges:
        """The same by paths."""
        by_change: dict[Change, list[str]] = {each: [] for each in CHANGES}
        for part in self.parts:
            if part.change is not None:
                by_change[part.change].append(part.key)
        by_name = {name: tuple(keys) for name, keys in by_change.items()}
        gone = tuple(part.key for part in self.gone)
        return PartChanges(by_name["changed"], by_name["moved"], by_name["new"], gone, self.renamed)


def contents_of(mockup: Mockup, progress: Callable[[float, str], object] | None = None) -> tuple[PartContent, ...]:
    """The content of each part. Linear in the triangles."""
    shapes = shapes_of(mockup, with_chords=False)
    count = mockup.part_count
    part_of_face, faces, vertices = mockup.part_of_face, mockup.faces, mockup.vertices
    triangles = np.bincount(part_of_face, minlength=count)
    middle = np.nan_to_num(shapes.middle)
    second, fourth = np.zeros(count), np.zeros(count)
    for begin in range(0, len(faces), _AT_ONCE):
        if progress is not None:
            progress(begin / len(faces), "parts")
        part = part_of_face[begin : begin + _AT_ONCE]
        some = np.minimum(faces[begin : begin + _AT_ONCE], len(vertices) - 1)
        corners = vertices[some] - middle[part][:, None, :]
        with np.errstate(invalid="ignore", over="ignore"):
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            weight = np.sqrt((normal * normal).sum(axis=1))
            square = (corners * corners).sum(axis=2)
            for total, values in ((second, square.sum(axis=1)), (fourth, (square * square).sum(axis=1))):
                total += np.bincount(part, np.nan_to_num(weight * values, posinf=0.0, neginf=0.0), count)
    area = np.nan_to_num(shapes.area)
    reach = np.nan_to_num(np.abs(shapes.box).max(axis=(1, 2), initial=0.0))
    figures = np.stack([area, second, fourth, reach], axis=1).tolist()
    found = []
    for key, hashed, number, (one, two, four, most) in zip(
        shapes.keys, shapes.content.tolist(), triangles.tolist(), figures, strict=True
    ):
        content = f"{hashed:016x}"
        found.append(PartContent(key, content, number, one, two, four, most, content))
    return tuple(found)


def revised(before: Sequence[PartContent], gone: Sequence[PartContent], now: Sequence[PartContent]) -> Revision:
    """Compares a mock-up with the parts that a project knows, by key, then by content."""
    row_of_key = {part.key: number for number, part in enumerate(now)}
    row_of: list[int | None] = [row_of_key.get(part.key) for part in before]
    taken = {row for row in row_of if row is not None}
    free: dict[str, list[int]] = {}
    for number in range(len(now) - 1, -1, -1):
        if number not in taken:
            free.setdefault(now[number].content, []).append(number)
    renamed: dict[str, str] = {}
    for old, part in enumerate(before):
        if row_of[old] is None and free.get(part.content):
            row_of[old] = new = free[part.content].pop()
            taken.add(new)
            renamed[part.key] = now[new].key
    # A root or a sub-assembly with another name: its changed parts are known by the rest of their paths.
    for old_folder, new_folder in renamed_folders(renamed):
        for old, part in enumerate(before):
            if row_of[old] is not None or not part.key.startswith(old_folder):
                continue
            new = row_of_key.get(new_folder + part.key[len(old_folder) :], -1)
            if new >= 0 and new not in taken:
                row_of[old] = new
                taken.add(new)
                renamed[part.key] = now[new].key
    parts = [_with(each, None, "new") for each in now]
    for old, row in enumerate(row_of):
        if row is not None:
            parts[row] = _followed(before[old], now[row])
    missing = {part.key: part for part in gone}
    missing |= {
        part.key: part for part, row in zip(before, row_of, strict=True) if row is None and part.change != "new"
    }
    for key in [*missing]:
        row = row_of_key.get(key)
        if row is not None:  # it is back
            parts[row] = _followed(missing.pop(key), now[row])
    return Revision(tuple(parts), tuple(missing.values()), tuple(row_of), renamed, _differing(before, now, row_of))


def _differing(
    before: Sequence[PartContent], now: Sequence[PartContent], row_of: Sequence[int | None]
) -> dict[int, tuple[Change, str]]:
    """See `Revision.differs`."""
    found: dict[int, tuple[Change, str]] = {number: ("new", "") for number in range(len(now))}
    for part, row in zip(before, row_of, strict=True):
        if row is None:
            continue
        del found[row]
        if now[row].content != part.content:
            found[row] = ("moved" if now[row].is_moved(part) else "changed", part.content)
    return dict(sorted(found.items()))


def renamed_folders(renamed: Mapping[str, str]) -> list[tuple[str, str]]:
    """The folders that were renamed, by the parts in them, those with most parts first. With their last `/`."""
    counts: Counter[tuple[str, str]] = Counter()
    for old, new in renamed.items():
        before, after = old.split("/"), new.split("/")
        while before and after and before[-1] == after[-1]:
            before.pop()
            after.pop()
        if len(before) < len(old.split("/")):
            counts["/".join([*before, ""]), "/".join([*after, ""])] += 1
    return [pair for pair, _ in counts.most_common(_MOST_FOLDERS)]


def _followed(before: PartContent, now: PartContent) -> PartContent:
    """A part of this revision that the project knew."""
    if before.change == "new":
        return _with(now, None, "new")
    if now.content == before.base:
        return _with(now, before.base, None)
    if now.content == before.content:
        return _with(now, before.base, before.change)
    # Once its shape has changed, only the shape that the answers are about makes it unchanged again.
    is_moved = now.is_moved(before) and before.change != "changed"
    return _with(now, before.base, "moved" if is_moved else "changed")


def _with(part: PartContent, base: str | None, change: Change | None) -> PartContent:
    return replace(part, base=part.content if base is None else base, change=change)


def accepted(parts: Sequence[PartContent]) -> tuple[PartContent, ...]:
    """The parts, none of them stale: the answers are about these now."""
    return tuple(_with(part, None, None) for part in parts)


def rows_of(parts: Sequence[PartContent]) -> Iterator[RowChange]:
    """The rows of the table, as changes."""
    for number, part in enumerate(parts):
        yield put("parts", str(number), number, text_of(part))


def text_of(part: PartContent) -> str:
    """A part as JSON."""
    value = [
        part.key,
        part.content,
        part.triangles,
        part.area,
        part.second,
        part.fourth,
        part.reach,
        part.base,
        part.change,
    ]
    return json.dumps(value, allow_nan=False)


def parts_of(rows: Sequence[Row], where: str) -> tuple[PartContent, ...]:
    """The parts from the rows of a table. Raises `LoadError`."""
    found = []
    for number, row in enumerate(rows):
        try:
            key, content, triangles, area, second, fourth, reach, base, change = json.loads(row.value)
            if (
                not all(isinstance(each, str) and len(each) < MOST_TEXT for each in (key, content, base))
                or not isinstance(triangles, int)
                or not 0 <= triangles < 2**32
                or not all(isinstance(each, float) and math.isfinite(each) for each in (area, second, fourth, reach))
                or change not in (None, *CHANGES)
            ):
                raise ValueError
        except (ValueError, TypeError, RecursionError):
            raise LoadError(f"{where} is damaged: part {number} of its mock-up is not as written; use a copy") from None
        found.append(PartContent(key, content, triangles, area, second, fourth, reach, base, change))
    return tuple(found)
