"""Findings as data: a table with a row for each pair of parts, the worst first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, TypeAlias, TypeVar, cast, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import RowsLike, check_kind, check_text, check_word, rows_at, shown
from feeler.choices import Chord, DepthKind, SettableStatus, Severity, Status, VerdictName
from feeler.clashes.scope import Scope
from feeler.clashes.shapes import PartShapes, Shapes, unknown
from feeler.clashes.tracking import STATUSES, Found, Marks, clash_id, part_keys
from feeler.clashes.verdict import DEFAULT_RULE, DEPTH_KINDS, SEVERITIES, Verdict
from feeler.errors import OptionError
from feeler.field_docs import documented
from feeler.mockup import Mockup
from feeler.renamed import OldAttributes
from feeler.rows import AnyArray, read_only
from feeler.short_reprs import shortly

Floats = npt.NDArray[np.float64]
VerdictLike: TypeAlias = Verdict | VerdictName
AnyTable = TypeVar("AnyTable", bound="Table")
Point = tuple[float, float, float]


@documented
@dataclass(frozen=True)
class Clash:
    """One finding: a pair of parts. Metres, in the mock-up's frame."""

    id: str
    """A UUID of the rule and both part paths, the same in every check and on every machine."""
    a: int
    """The first part, an index into `Clashes.part_paths`."""
    b: int
    """The second part."""
    path_a: str
    """The path of the first part."""
    path_b: str
    """The path of the second part."""
    verdict: Verdict
    """What the two are to each other."""
    depth: float
    """How far the deepest point of one surface lies inside the other part: a lower bound. 0 for duplicates and for
    parts that only touch or are apart; NaN if Ctrl-C came first. Overlapping or flush closed shells within one part
    reduce it."""
    depth_error: float
    """How much larger the depth can be: at most a thousandth of it, or a nanometre; more if the search stopped after
    two million cuts of the surfaces, which takes seconds. NaN if both parts are open. Of duplicates, how far apart they
    can be."""
    depth_kind: DepthKind
    """`"measured"`, or `"estimate"` if a surface of a part is open and so has no inside. The estimate says how deep the
    open surface lies in the closed surfaces of the other part. If neither part has a closed surface, it says how far
    they cross: a point where they cross is as deep as the shorter of two lengths, which are the distance to the nearest
    border, and how far each surface goes on away from the other, on its shorter side. So a sheet that ends on another
    has depth 0, and a tongue through a sheet is as deep as it sticks out, at most half its width. Up to 2,048 points
    are looked at, and another triangulation can change the estimate by 1 %, which approvals allow for. Seams that do
    not meet count as borders."""
    translation: Point
    """The shortest known translation that moves `a` out of `b`: an upper bound. 0 for contacts; NaN if not known."""
    gap: float
    """The distance of the surfaces; 0 if they collide."""
    point_a: Point
    """The point of `a` nearest to `b`; if they collide, the point of the deepest contact."""
    point_b: Point
    """The point of `b` that corresponds to `point_a`."""
    volume: float
    """The shared volume, cubic metres, at most the smaller part; NaN if it was not measured, if a part is open, or if
    its surfaces do not say what is inside. Where a closed shell overlaps itself, it can be off by the overlap, and by a
    few percent."""
    triangles: int
    """The number of colliding pairs of triangles."""
    box: tuple[Point, Point]
    """Lower and upper corner of a box around the colliding triangles, else around the two points."""
    is_open_a: bool
    """Whether the surface of `a` is not closed: it has no inside and contains nothing."""
    is_open_b: bool
    """The same of `b`."""
    rule: str
    severity: Severity
    """As the rule says, else as the verdict does."""
    status: Status
    """One of `"new"`, `"active"`, `"reviewed"`, `"approved"`, `"resolved"`."""
    by: str
    """The person who set the status; else empty."""
    note: str
    """What was noted with the status; else empty."""
    changed: str
    """`"renamed"` or `"renumbered"` if `Clashes.diff` found a part under another key, else empty."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        # One and the same NaN, so that equal rows are equal.
        self.__dict__.update({name: _with_one_nan(value) for name, value in state.items()})


@shortly
@dataclass(frozen=True, eq=False)
class Columns:
    """The arrays of a table, a row for each finding: `a`, `b`, `depth`, `depth_error`, `translation`, `gap`, `point_a`,
    `point_b`, `volume`, `triangles`, `box`, `rule` and `severity` as of `Clash`; `verdict` and `depth_kind` by number;
    `is_open` of both parts.
    """

    a: npt.NDArray[np.uint32]
    b: npt.NDArray[np.uint32]
    verdict: npt.NDArray[np.uint8]
    depth: Floats
    depth_error: Floats
    depth_kind: npt.NDArray[np.uint8]
    translation: Floats
    gap: Floats
    point_a: Floats
    point_b: Floats
    volume: Floats
    triangles: npt.NDArray[np.uint32]
    box: Floats
    is_open: npt.NDArray[np.bool_]
    rule: npt.NDArray[np.uint32]
    severity: npt.NDArray[np.uint8]

    def rows(self, chosen: slice | npt.NDArray[Any]) -> Columns:
        """The chosen rows, in the given order."""
        return Columns(*(getattr(self, each.name)[chosen] for each in fields(self)))

    def order(self, keys: Sequence[str], rules: Sequence[str]) -> npt.NDArray[np.intp]:
        """The worst first: by severity, then by verdict, then by depth or gap, then by the names of parts and rules.

        Duplicates come first: one of the two parts is superfluous, and their depth of 0 says nothing. Clashes and
        contained parts follow together, the deepest first; then contacts, the deepest first; then clearances, the
        nearest first. Depths that were not measured (NaN) come last. keys, rules: what parts and rules are called;
        their numbers are not the same in a file.
        """
        rank = np.array(_RANKS)[self.verdict]
        place = places(keys)
        first, second = np.sort([place[self.a], place[self.b]], axis=0)
        return np.lexsort((places(rules)[self.rule], second, first, self.gap, -self.depth, rank, self.severity))


def places(names: Sequence[str]) -> npt.NDArray[np.intp]:
    """The place of each name in their order."""
    found = np.empty(len(names), dtype=np.intp)
    found[sorted(range(len(names)), key=names.__getitem__)] = np.arange(len(names))
    return found


_FIRST = (Verdict.DUPLICATE,), (Verdict.CLASH, Verdict.CONTAINED), (Verdict.CONTACT,), (Verdict.CLEARANCE,)
_RANKS = [next(rank for rank, verdicts in enumerate(_FIRST) if verdict in verdicts) for verdict in Verdict]
"""The rank of each verdict in `Columns.order`, by its number."""


SHAPES: dict[str, tuple[type, tuple[int, ...]]] = {
    "a": (np.uint32, ()),
    "b": (np.uint32, ()),
    "verdict": (np.uint8, ()),
    "depth": (np.float64, ()),
    "depth_error": (np.float64, ()),
    "depth_kind": (np.uint8, ()),
    "translation": (np.float64, (3,)),
    "gap": (np.float64, ()),
    "point_a": (np.float64, (3,)),
    "point_b": (np.float64, (3,)),
    "volume": (np.float64, ()),
    "triangles": (np.uint32, ()),
    "box": (np.float64, (2, 3)),
    "is_open": (np.bool_, (2,)),
    "rule": (np.uint32, ()),
    "severity": (np.uint8, ()),
}
"""The type of each column, and the shape of a row's entry."""


@shortly
@documented
@dataclass(frozen=True)
class Facts:
    """Settings and statistics of a check, for reports and later checks.

    clearance, contact: metres, for pairs that no rule names; `contact` may be "chord". seconds: by stage. files: of the
    mock-up. hidden: how many findings each rule hides, in the order in which rules are tried. present: how many parts
    were checked; None: all. open_parts: paths of open parts with another part in their box. notes: what the findings
    do not show, for users. rules: name, clearance and contact of each rule, metres; NaN: not known.
    least_contact: the least that `contact` can be by the rounding of the coordinates in the file, metres; 0 for double
    precision. names: key and name of each part whose name is not the last step of its path; of loaded findings, only
    parts with findings.
    """

    clearance: float = 0.0
    contact: float | Chord = 0.0
    parts: int = 0
    triangles: int = 0
    """Of the parts that were checked."""
    files: tuple[str, ...] = ()
    seconds: tuple[tuple[str, float], ...] = ()
    counts: tuple[tuple[str, int], ...] = ()
    """Counters of the check, by name."""
    hidden: tuple[tuple[str, int], ...] = ()
    present: int | None = None
    open_parts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    rules: tuple[tuple[str, float, float], ...] = ()
    least_contact: float = 0.0
    names: tuple[tuple[str, str], ...] = ()


_PLURALS = {
    "a": "parts_a",
    "b": "parts_b",
    "verdict": "verdicts",
    "depth": "depths",
    "depth_error": "depth_errors",
    "depth_kind": "depth_kinds",
    "translation": "translations",
    "gap": "gaps",
    "point_a": "points_a",
    "point_b": "points_b",
    "volume": "volumes",
    "signed_depth": "signed_depths",
    "box": "boxes",
    "rule": "rules",
    "severity": "severities",
    "status": "statuses",
}
"""Old names of columns, those of the fields of `Clash`, and their names now."""


class Table(OldAttributes, Sequence[Clash]):
    """Rows for pairs of parts, with names of parts and rules, and the statuses of the rows. See `Clashes`."""

    def __init__(
        self,
        columns: Columns,
        part_paths: Sequence[str],
        rules: Sequence[str],
        *,
        marks: Marks | None = None,
        facts: Facts | None = None,
        is_partial: bool = False,
        shapes: PartShapes | None = None,
        scope: Scope | None = None,
    ) -> None:
        """Takes rows in the given order. rules: the names that `columns.rule` indexes.

        shapes: of the parts, so that `diff` can match renamed parts; None: `diff` matches by path alone. scope: what
        the check looked at; None: every pair.
        """
        self.columns = columns
        for each in fields(columns):
            getattr(columns, each.name).flags.writeable = False
        self.part_paths = tuple(part_paths)
        self.rule_names = tuple(rules)
        self.marks = marks if marks is not None else Marks()
        self.facts = facts or Facts()
        self.is_partial = is_partial
        self._shapes = shapes
        self._scope = scope
        self._earlier: Table | None = None
        self._computed: dict[str, npt.NDArray[Any]] = {}
        self._of_marks: dict[str, tuple[int | None, tuple[str, ...]]] = {}
        self._statuses: tuple[tuple[str, ...], npt.NDArray[np.str_]] | None = None

    _RENAMED = _PLURALS

    def _old_value(self, name: str) -> object:
        # `verdict` was an array of numbers.
        return self.columns.verdict if name == "verdict" else super()._old_value(name)

    @property
    def parts_a(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the first part of each pair."""
        return self.columns.a

    @property
    def parts_b(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the second part."""
        return self.columns.b

    @property
    def paths_a(self) -> npt.NDArray[np.object_]:
        """`(n,)`: the path of the first part, text."""
        return self._once("paths_a", lambda: self._paths[self.columns.a])

    @property
    def paths_b(self) -> npt.NDArray[np.object_]:
        """`(n,)`: the path of the second part."""
        return self._once("paths_b", lambda: self._paths[self.columns.b])

    @cached_property
    def _paths(self) -> npt.NDArray[np.object_]:
        return np.array([*self.part_paths, None], dtype=object)[:-1]  # never read as an array of arrays

    @property
    def is_open_a(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether the surface of `a` is not closed."""
        return self.columns.is_open[:, 0]

    @property
    def is_open_b(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether the surface of `b` is not closed."""
        return self.columns.is_open[:, 1]

    @property
    def by(self) -> tuple[str, ...]:
        """The person who set each status; else empty."""
        return self._marked("by")

    @property
    def notes(self) -> tuple[str, ...]:
        """Each finding's note."""
        return self._marked("note")

    @property
    def changed(self) -> tuple[str, ...]:
        """`"renamed"` or `"renumbered"` for findings that `diff` found under another key, else empty."""
        return self._marked("changed")

    def _once(self, name: str, make: Callable[[], AnyArray]) -> AnyArray:
        """A column that is computed at its first use, read-only."""
        if name not in self._computed:
            self._computed[name] = read_only(make())
        return cast(AnyArray, self._computed[name])

    def _marked(self, name: str) -> tuple[str, ...]:
        """A field of the mark of each finding: the same tuple until a mark changes."""
        version, found = self._of_marks.get(name, (None, ()))
        if version != self.marks.version:
            found = tuple(getattr(self.marks.of(each), name) for each in self.ids)
            self._of_marks[name] = (self.marks.version, found)
        return found

    @property
    def verdicts(self) -> npt.NDArray[np.str_]:
        """`(n,)`: the word of a `feeler.Verdict` for each finding, `numpy.str_`."""
        return self._once("verdicts", lambda: Verdict.words(self.columns.verdict))

    @property
    def depths(self) -> Floats:
        """`(n,)`: how far the deepest point of one surface lies inside the other part, metres: a lower bound."""
        return self.columns.depth

    @property
    def depth_errors(self) -> Floats:
        """`(n,)`: how much larger the depth can be, metres."""
        return self.columns.depth_error

    @property
    def depth_kinds(self) -> npt.NDArray[np.str_]:
        """`(n,)`: `"measured"`, or `"estimate"` if a part is open, `numpy.str_`."""
        return self._once("depth_kinds", lambda: np.array(DEPTH_KINDS)[self.columns.depth_kind])

    @property
    def translations(self) -> Floats:
        """`(n, 3)`: the shortest known translation that moves `a` out of `b`, metres: an upper bound."""
        return self.columns.translation

    @property
    def gaps(self) -> Floats:
        """`(n,)`: the distance of the surfaces, metres; 0 if they collide."""
        return self.columns.gap

    @property
    def points_a(self) -> Floats:
        """`(n, 3)`: a point of `a`, metres."""
        return self.columns.point_a

    @property
    def points_b(self) -> Floats:
        """`(n, 3)`: the point of `b` that corresponds to `point_a`, metres."""
        return self.columns.point_b

    @property
    def volumes(self) -> Floats:
        """`(n,)`: the shared volume, cubic metres, or NaN."""
        return self.columns.volume

    @property
    def signed_depths(self) -> Floats:
        """`(n,)`: the depth, or the negative gap, metres. `diff` compares this between checks."""
        return self._once("signed_depths", lambda: np.where(self.depths > 0.0, self.depths, -self.gaps))

    @property
    def are_thin(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether it is a clash at most as deep as the `contact` of its rule, by the rule of thin walls."""
        contacts = {name: contact for name, _, contact in self.facts.rules}
        known = {
            DEFAULT_RULE: self.facts.contact if isinstance(self.facts.contact, (int, float)) else np.nan
        } | contacts
        contact = np.array([*(known.get(name, known[DEFAULT_RULE]) for name in self.rule_names), np.nan])
        is_clash: npt.NDArray[np.bool_] = self.columns.verdict == Verdict.CLASH.code
        return read_only(is_clash & (self.depths <= contact[self.columns.rule]))

    def found(self) -> list[Found]:
        """What `diff` compares of each row."""
        columns = (self.signed_depths, self.depth_errors, self.verdicts, self.are_thin)
        rows = zip(*(each.tolist() for each in columns), strict=True)
        return [Found(depth, error, verdict, is_thin) for depth, error, verdict, is_thin in rows]

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the number of colliding pairs of triangles."""
        return self.columns.triangles

    @property
    def boxes(self) -> Floats:
        """`(n, 2, 3)`: lower and upper corner of a box around the colliding triangles, metres."""
        return self.columns.box

    @property
    def rules(self) -> npt.NDArray[np.str_]:
        """`(n,)`: the name of the rule, `numpy.str_`."""
        return self._once("rules", lambda: np.array(self.rule_names or ("",))[self.columns.rule])

    @property
    def severities(self) -> npt.NDArray[np.str_]:
        """`(n,)`: `"critical"`, `"major"` or `"minor"`, `numpy.str_`."""
        return self._once("severities", lambda: np.array(SEVERITIES)[self.columns.severity])

    @cached_property
    def ids(self) -> tuple[str, ...]:
        """Each finding's id."""
        rows = zip(self.columns.rule.tolist(), self.parts_a.tolist(), self.parts_b.tolist(), strict=True)
        return tuple(clash_id(self.rule_names[rule], self.keys[a], self.keys[b]) for rule, a, b in rows)

    @property
    def statuses(self) -> npt.NDArray[np.str_]:
        """`(n,)`: each finding's status, `numpy.str_`."""
        words = self._marked("status")
        if self._statuses is None or self._statuses[0] is not words:
            self._statuses = (words, read_only(np.array(words, dtype="U8")))
        return self._statuses[1]

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The unique key of each part: its path, followed by a number if other parts have the same path."""
        return tuple(part_keys(self.part_paths))

    @property
    def shapes(self) -> Shapes:
        """Shape and place of parts, at least of those in findings. The first call reads all triangles."""
        return unknown(self.keys, self.part_paths) if self._shapes is None else self._shapes.get()

    @property
    def hidden(self) -> dict[str, int]:
        """How many findings each exclusion, and each rule with a level, hides; by name."""
        found: dict[str, int] = {}
        for name, count in self.facts.hidden:
            found[name] = found.get(name, 0) + count
        return found

    def where(
        self: AnyTable,
        *,
        verdict: VerdictLike | None = None,
        severity: Severity | None = None,
        status: Status | None = None,
        rule: str | None = None,
    ) -> AnyTable:
        """The rows with this verdict, severity, status and rule: `clashes.where(verdict="clash", rule="default")`.

        Raises `OptionError` for an unknown verdict, severity or status.
        """
        mask = np.ones(len(self), dtype=bool)
        if verdict is not None:
            mask &= self.columns.verdict == Verdict(check_word("verdict", verdict, list(Verdict))).code
        if severity is not None:
            mask &= self.severities == check_word("severity", severity, SEVERITIES)
        if status is not None:
            mask &= self.statuses == check_word("status", status, STATUSES)
        if rule is not None:
            mask &= self.rules == check_text("rule", rule, "the name of a rule")
        return self[mask]

    def __len__(self) -> int:
        return len(self.columns.a)

    @overload
    def __getitem__(self, index: int) -> Clash: ...
    @overload
    def __getitem__(self: AnyTable, index: RowsLike) -> AnyTable: ...
    def __getitem__(self: AnyTable, index: int | RowsLike) -> Clash | AnyTable:
        at = rows_at(index, len(self))
        return self._row(at) if isinstance(at, int) else self._some(self.columns.rows(np.array(at, dtype=np.intp)))

    def __iter__(self) -> Iterator[Clash]:
        return (self._row(row) for row in range(len(self)))

    def _some(self: AnyTable, columns: Columns) -> AnyTable:
        found = type(self)(
            columns,
            self.part_paths,
            self.rule_names,
            marks=self.marks,
            facts=self.facts,
            is_partial=self.is_partial,
            shapes=self._shapes,
            scope=self._scope,
        )
        found.__dict__["keys"] = self.keys  # made once for all slices
        return found

    def _row(self, row: int) -> Clash:
        c = self.columns
        a, b = int(c.a[row]), int(c.b[row])
        mark = self.marks.of(self.ids[row])
        return Clash(
            id=self.ids[row],
            a=a,
            b=b,
            path_a=self.part_paths[a],
            path_b=self.part_paths[b],
            verdict=Verdict(c.verdict[row]),
            depth=float(c.depth[row]),
            # One and the same NaN, so that equal rows are equal.
            depth_error=math.nan if np.isnan(c.depth_error[row]) else float(c.depth_error[row]),
            depth_kind=DEPTH_KINDS[c.depth_kind[row]],
            translation=_point(c.translation[row]),
            gap=float(c.gap[row]),
            point_a=_point(c.point_a[row]),
            point_b=_point(c.point_b[row]),
            volume=math.nan if np.isnan(c.volume[row]) else float(c.volume[row]),
            triangles=int(c.triangles[row]),
            box=(_point(c.box[row, 0]), _point(c.box[row, 1])),
            is_open_a=bool(c.is_open[row, 0]),
            is_open_b=bool(c.is_open[row, 1]),
            rule=self.rule_names[c.rule[row]],
            severity=SEVERITIES[c.severity[row]],
            status=mark.status,
            by=mark.by,
            note=mark.note,
            changed=mark.changed,
        )

    def to_dicts(self) -> list[dict[str, Any]]:
        """A dict of plain Python values for each row, with the fields of `Clash`. The verdict is a lower-case name."""
        names = [each.name for each in fields(Clash)]
        found = []
        for clash in self:
            row = {name: getattr(clash, name) for name in names}
            row["verdict"] = clash.verdict.value
            found.append(row)
        return found

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each finding and the ids as index. Points are tuples.

        Raises `OptionError` if pandas is not installed.
        """
        import importlib

        try:
            pandas: Any = importlib.import_module("pandas")
        except ImportError:
            raise OptionError("to_pandas needs pandas: pip install pandas, or take to_dicts()") from None
        columns = [each.name for each in fields(Clash)]
        return pandas.DataFrame(self.to_dicts(), columns=columns).set_index("id")

    def set_status(self, clash: str, status: SettableStatus, *, by: str = "", note: str = "") -> None:
        """Sets the status of a finding: `"new"`, `"active"`, `"reviewed"` or `"approved"`. by, note: who, and why.

        `clash` is the id of the finding. An approval holds for the current depth and verdict: see `diff`. Raises
        `OptionError` for another status, and for an id that is not in the table.
        """
        given: object = clash
        if not isinstance(given, str) or clash not in self._row_of:
            raise OptionError(f"there is no clash {shown(clash)} in this table: give one of its ids")
        row = self._row_of[clash]
        self.marks.set(clash, status, self[row : row + 1].found()[0], by, note)

    @cached_property
    def _row_of(self) -> dict[str, int]:
        return {each: row for row, each in enumerate(self.ids)}

    def earlier(self: AnyTable) -> AnyTable:
        """Findings of the previous check that `diff` did not find again.

        They are resolved, or keep their status if this check is partial, or did not look at their parts.
        """
        return cast(AnyTable, self._earlier) if self._earlier is not None else self[:0]

    def _set_earlier(self: AnyTable, earlier: AnyTable) -> None:
        """Sets `earlier()`."""
        self._earlier = earlier

    def __reduce__(self) -> tuple[Any, ...]:
        columns = tuple(getattr(self.columns, each.name) for each in fields(self.columns))
        state = (
            type(self),
            columns,
            self.part_paths,
            self.rule_names,
            self.marks,
            self.facts,
            self.is_partial,
            self._earlier,
            self._shapes,
            self._scope,
        )
        return (_restored, state)

    def __repr__(self) -> str:
        counts = [(np.count_nonzero(self.columns.verdict == each.code), each.value) for each in Verdict]
        said = ", ".join(f"{count:,} {name}" for count, name in counts if count) or "none"
        return f"{type(self).__name__}({len(self):,}: {said}{'; partial' if self.is_partial else ''})"


def _restored(
    kind: type[AnyTable],
    columns: tuple[Any, ...],
    paths: tuple[str, ...],
    rules: tuple[str, ...],
    marks: Marks,
    facts: Facts,
    is_partial: bool,
    earlier: AnyTable | None,
    shapes: PartShapes | None,
    scope: Scope | None = None,
) -> AnyTable:
    found = kind(
        Columns(*columns), paths, rules, marks=marks, facts=facts, is_partial=is_partial, shapes=shapes, scope=scope
    )
    if earlier is not None:
        found._set_earlier(earlier)
    return found


def check_same(mockup: Mockup, clashes: Table) -> None:
    """Raises `OptionError` if the findings are of another mock-up, or these are neither."""
    check_kind("mockup", mockup, Mockup)
    check_kind("clashes", clashes, Table, "feeler.Clashes")
    if tuple(mockup.part_paths) != clashes.part_paths:
        raise OptionError(
            "the clashes are of other parts than the mock-up's: give the mock-up that was checked, and the result of "
            "feeler.clash (clashes loaded from a file have no part numbers)"
        )


def _with_one_nan(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_with_one_nan, value))
    return math.nan if value != value else value


def _point(row: Any) -> Point:
    x, y, z = _with_one_nan(tuple(row.tolist()))
    return (x, y, z)
