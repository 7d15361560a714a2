"""The findings of a check: a table with a row for each pair of parts, the worst first."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from feeler.clashes.shapes import PartShapes, Shapes, unknown
from feeler.clashes.tracking import DEPTH_GROWTH_M, Marks, clash_id, part_keys
from feeler.clashes.verdict import DEPTH_KINDS, SEVERITIES, Verdict
from feeler.errors import OptionError

if TYPE_CHECKING:
    from feeler.clashes.changes import Changes
    from feeler.clashes.grouping import Group
    from feeler.mockup import Mockup

Floats = npt.NDArray[np.float64]
Point = tuple[float, float, float]


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
    path_b: str
    verdict: Verdict
    depth: float
    """The farthest that a point of one surface is inside the other part: a lower bound. 0 for duplicates and for parts
    that only touch or are apart; NaN if Ctrl-C came first."""
    depth_error: float
    """How much more the depth can be: at most a thousandth of it, or a nanometre. NaN if both parts are open."""
    depth_kind: str
    """`"measured"`, or `"estimate"` if a part is open and has no inside."""
    translation: Point
    """A way by which `a` comes out of `b`, the shortest known: an upper bound. Zero for contacts; NaN if not known."""
    gap: float
    """How far their surfaces are apart; 0 where they meet."""
    point_a: Point
    """A point of `a` that is closest to `b`, or in contact with it where it is deepest."""
    point_b: Point
    """The point of `b` that belongs to it."""
    volume: float
    """What they share, cubic metres; NaN where that was not asked for, or one of them is not closed."""
    triangles: int
    """How many pairs of triangles meet."""
    box: tuple[Point, Point]
    """Lower and upper corner of what meets, else of the two points."""
    is_open_a: bool
    """Whether `a` has no inside, so that it contains nothing."""
    is_open_b: bool
    rule: str
    severity: str
    status: str
    """One of `"new"`, `"active"`, `"reviewed"`, `"approved"`, `"resolved"`."""
    by: str
    """Who set the status; empty where nobody did."""
    note: str
    changed: str
    """`"renamed"` or `"renumbered"` where `Clashes.diff` found a part under another key, else empty."""


@dataclass(frozen=True)
class Columns:
    """The arrays of a table, a row for each finding."""

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

    def rows(self, chosen: Any) -> Columns:
        """Some of the rows, in a given order."""
        return Columns(*(getattr(self, each.name)[chosen] for each in fields(self)))

    def order(self) -> npt.NDArray[np.intp]:
        """The worst first: by severity, then by verdict, then by depth or gap, then by parts.

        Duplicates come first: their depth is 0, and one of the two parts is surplus. Clashes and contained parts follow
        together, the deepest first: a contained part is as deep as its farthest point. Then contacts, the deepest
        first; then parts that are apart, the nearest first. Depths that were not measured (NaN) come last.
        """
        rank = np.array(_RANKS)[self.verdict]
        return np.lexsort((self.b, self.a, self.gap, -self.depth, rank, self.severity))


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


@dataclass(frozen=True)
class Facts:
    """What a check was about, for reports and for the checks that follow.

    clearance, contact: metres, of pairs that no rule names; `contact` may be "chord". seconds: by stage. files: of the
    mock-up. hidden: how many findings each rule hides, in the order in which they are tried. present: how many parts
    were checked; None: all. open_parts: paths of parts that are not closed and have another part in their box. notes:
    sentences on what the rows cannot say. rules: name, clearance and contact of each rule, metres; NaN: not known.
    """

    clearance: float = 0.0
    contact: float | str = 0.0
    parts: int = 0
    triangles: int = 0
    files: tuple[str, ...] = ()
    seconds: tuple[tuple[str, float], ...] = ()
    counts: tuple[tuple[str, int], ...] = ()
    hidden: tuple[tuple[str, int], ...] = ()
    present: int | None = None
    open_parts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    rules: tuple[tuple[str, float, float], ...] = ()


class Clashes(Sequence[Clash]):
    """What `feeler.clash` found, the worst first: a row for each pair of parts.

    `clashes[i]` is a `Clash`, `clashes[i:j]` and `clashes[mask]` are tables, which share the status of their findings.
    Columns are arrays of a row each, read-only: `.a .b .verdict .depth .depth_error .depth_kind .translation .gap
    .point_a .point_b .volume .triangles .box .rule .severity .ids .status`, as in `Clash`. Sorted by severity; then
    duplicates; then clashes and contained parts, the deepest first; then contacts; then parts that are apart, the
    nearest first; then by parts.
    """

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
    ) -> None:
        """Rows as they are, in their order. rules: the name of each rule that `columns.rule` counts.

        shapes: of the parts, by which `diff` finds them under other paths; None: it goes by paths alone.
        """
        self.columns = columns
        for each in fields(columns):
            getattr(columns, each.name).flags.writeable = False
        self.part_paths = tuple(part_paths)
        self.rules = tuple(rules)
        self.marks = marks if marks is not None else Marks()
        self.facts = facts or Facts()
        self.is_partial = is_partial
        self._shapes = shapes
        self._earlier: Clashes | None = None

    @property
    def a(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the first part of each pair."""
        return self.columns.a

    @property
    def b(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: the second part."""
        return self.columns.b

    @property
    def verdict(self) -> npt.NDArray[np.uint8]:
        """`(n,)`: a `feeler.Verdict` each."""
        return self.columns.verdict

    @property
    def depth(self) -> Floats:
        """`(n,)`: the farthest that a point of one surface is inside the other part, metres: a lower bound."""
        return self.columns.depth

    @property
    def depth_error(self) -> Floats:
        """`(n,)`: how much more the depth can be, metres."""
        return self.columns.depth_error

    @property
    def depth_kind(self) -> npt.NDArray[np.str_]:
        """`(n,)`: `"measured"`, or `"estimate"` if a part is open."""
        return np.array(DEPTH_KINDS)[self.columns.depth_kind]

    @property
    def translation(self) -> Floats:
        """`(n, 3)`: the shortest known way of `a` out of `b`, metres: an upper bound."""
        return self.columns.translation

    @property
    def gap(self) -> Floats:
        """`(n,)`: metres; 0 where they meet."""
        return self.columns.gap

    @property
    def point_a(self) -> Floats:
        """`(n, 3)`: a point of `a`, metres."""
        return self.columns.point_a

    @property
    def point_b(self) -> Floats:
        """`(n, 3)`: the point of `b` that belongs to it."""
        return self.columns.point_b

    @property
    def volume(self) -> Floats:
        """`(n,)`: what they share, cubic metres, or NaN."""
        return self.columns.volume

    @property
    def signed_depth(self) -> Floats:
        """`(n,)`: the depth, metres; of what is apart the gap, negative: what is compared from check to check."""
        return np.where(self.depth > 0.0, self.depth, -self.gap)

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """`(n,)`: how many pairs of triangles meet."""
        return self.columns.triangles

    @property
    def box(self) -> Floats:
        """`(n, 2, 3)`: lower and upper corner of what meets, metres."""
        return self.columns.box

    @property
    def rule(self) -> npt.NDArray[np.str_]:
        """`(n,)`: the rule's name."""
        return np.array(self.rules or ("",))[self.columns.rule]

    @property
    def severity(self) -> npt.NDArray[np.str_]:
        """`(n,)`: `"critical"`, `"major"` or `"minor"`."""
        return np.array(SEVERITIES)[self.columns.severity]

    @cached_property
    def ids(self) -> tuple[str, ...]:
        """Each finding's id."""
        rows = zip(self.columns.rule.tolist(), self.a.tolist(), self.b.tolist(), strict=True)
        return tuple(clash_id(self.rules[rule], self.keys[a], self.keys[b]) for rule, a, b in rows)

    @property
    def status(self) -> npt.NDArray[np.str_]:
        """`(n,)`: each finding's status."""
        return np.array([self.marks.of(each).status for each in self.ids], dtype="U8")

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The key of each of `part_paths`: the path, with a number behind it where parts have one path."""
        return tuple(part_keys(self.part_paths))

    @property
    def shapes(self) -> Shapes:
        """Shape and place of parts, those in findings at least; the first call of a check looks at all triangles."""
        return unknown(self.keys, self.part_paths) if self._shapes is None else self._shapes.get()

    @property
    def hidden(self) -> dict[str, int]:
        """How many findings each rule hides, by its name: exclusions, and rules with a level."""
        found: dict[str, int] = {}
        for name, count in self.facts.hidden:
            found[name] = found.get(name, 0) + count
        return found

    def where(self, **where: object) -> Clashes:
        """The rows of a verdict, a severity, a status or a rule: `clashes.where(verdict="clash", rule="default")`."""
        return self[self._mask(where)]

    def _mask(self, where: dict[str, object]) -> npt.NDArray[np.bool_]:
        mask = np.ones(len(self), dtype=bool)
        for name, value in where.items():
            if name == "verdict":
                wanted = value if isinstance(value, Verdict) else Verdict.__members__.get(str(value).upper())
                if wanted is None:
                    raise OptionError(f"there is no verdict {value!r}: choose {', '.join(Verdict.__members__).lower()}")
                mask &= self.verdict == wanted
            elif name in ("severity", "status", "rule"):
                mask &= getattr(self, name) == value
            else:
                raise OptionError(f"rows are not chosen by {name!r}: give verdict, severity, status or rule")
        return mask

    def __len__(self) -> int:
        return len(self.columns.a)

    @overload
    def __getitem__(self, index: int) -> Clash: ...
    @overload
    def __getitem__(self, index: slice | npt.NDArray[Any]) -> Clashes: ...
    def __getitem__(self, index: int | slice | npt.NDArray[Any]) -> Clash | Clashes:
        if isinstance(index, (slice, np.ndarray)):
            if isinstance(index, np.ndarray) and index.dtype == bool and index.shape != (len(self),):
                raise OptionError(f"a mask of shape {index.shape} does not fit {len(self)} rows: give one entry each")
            return self._some(self.columns.rows(index))
        return self._row(range(len(self))[index])

    def __iter__(self) -> Iterator[Clash]:
        return (self._row(row) for row in range(len(self)))

    def _some(self, columns: Columns) -> Clashes:
        found = Clashes(
            columns,
            self.part_paths,
            self.rules,
            marks=self.marks,
            facts=self.facts,
            is_partial=self.is_partial,
            shapes=self._shapes,
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
            verdict=Verdict(int(c.verdict[row])),
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
            rule=self.rules[c.rule[row]],
            severity=SEVERITIES[c.severity[row]],
            status=mark.status,
            by=mark.by,
            note=mark.note,
            changed=mark.changed,
        )

    def to_dicts(self) -> list[dict[str, Any]]:
        """A dict for each row, of plain Python values: as `Clash`, the verdict by its name in small letters."""
        names = [each.name for each in fields(Clash)]
        found = []
        for clash in self:
            row = {name: getattr(clash, name) for name in names}
            row["verdict"] = clash.verdict.name.lower()
            found.append(row)
        return found

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each finding, its index the id; points as tuples.

        Raises `OptionError` where pandas is not installed.
        """
        import importlib

        try:
            pandas: Any = importlib.import_module("pandas")
        except ImportError:
            raise OptionError("to_pandas needs pandas: pip install pandas, or take to_dicts()") from None
        columns = [each.name for each in fields(Clash)]
        return pandas.DataFrame(self.to_dicts(), columns=columns).set_index("id")

    def groups(self, by: str = "part", *, reach: float | None = None) -> list[Group]:
        """The rows in groups, so that thousands can be read; the group with the worst row first.

        by: "part" (each row goes to the part that has most of those left: one that is out of place is one group),
        "rule", or "cluster" (what is within `reach` metres of each other, by way of others; default: a hundredth of the
        box around all). Raises `OptionError` for others.
        """
        from feeler.clashes.grouping import groups

        return groups(self, by, reach)

    def set_status(self, clash: str, status: str, *, by: str = "", note: str = "") -> None:
        """Says what somebody thinks of a finding: `"new"`, `"active"`, `"reviewed"` or `"approved"`; by whom, and why.

        `clash` is its id. An approval is of the depth that the finding has now: see `diff`. Raises `OptionError` for
        another status, and for an id that is not in the table.
        """
        if clash not in self._row_of:
            raise OptionError(f"there is no clash {clash!r} in this table: give one of its ids")
        row = self._row_of[clash]
        self.marks.set(clash, status, float(self.signed_depth[row]), by, note)

    @cached_property
    def _row_of(self) -> dict[str, int]:
        return {each: row for row, each in enumerate(self.ids)}

    def diff(self, previous: Clashes, *, growth: float = DEPTH_GROWTH_M) -> Changes:
        """What changed since the check before, whose statuses this table takes over.

        What was there before is active, reviewed or approved as it was; what was not, or was resolved, is new; what is
        gone is resolved. An approved finding is new again where it is more than `growth` metres deeper than when it was
        approved. A partial check resolves nothing.

        A part keeps its findings by its path; under another path, or among parts of one path, by its shape and place:
        `changed` of such a finding is "renamed" or "renumbered", and `Changes.parts` says how many parts were found.
        Raises `LoadError` where no part of what was found before is in this mock-up, by path or by shape.
        """
        from feeler.clashes.changes import changes

        return changes(self, previous, growth)

    def with_rules(self, rules: Any, mockup: Mockup | None = None) -> Clashes:
        """The same findings under other rules, without another check: to try rules on what was saved.

        rules: as of `feeler.clash`. mockup: the one that was checked, for the shapes of fasteners; None: names decide.
        Verdicts, severities and ids follow the new rules, statuses stay with their pairs, and `hidden` counts anew.
        `facts.notes` says what only another check can tell: pairs that were hidden before, or are farther apart than
        the clearance then, and verdicts that the depth alone does not decide. Raises as `feeler.clash` does.
        """
        from feeler.clashes.retried import with_rules
        from feeler.clashes.rules_file import rules_from

        return with_rules(self, rules_from(rules), mockup)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the findings with their status, and the `earlier` ones, as JSON: a line each, in an order that stays.

        The same findings give the same bytes. `feeler.load_clashes` reads it. Raises `WriteError`.
        """
        from feeler.clashes.saving import save

        save(self, path)

    def earlier(self) -> Clashes:
        """What the check before found and this one did not, as `diff` told: resolved, but where this one is partial."""
        return self._earlier if self._earlier is not None else self[:0]

    def set_earlier(self, earlier: Clashes) -> None:
        """Takes over what `diff`, or a file, says of the check before."""
        self._earlier = earlier

    def __reduce__(self) -> tuple[Any, ...]:
        columns = tuple(getattr(self.columns, each.name) for each in fields(self.columns))
        state = (
            columns,
            self.part_paths,
            self.rules,
            self.marks,
            self.facts,
            self.is_partial,
            self._earlier,
            self._shapes,
        )
        return (_restored, state)

    def __repr__(self) -> str:
        counts = [(np.count_nonzero(self.verdict == each), each.name.lower()) for each in Verdict]
        said = ", ".join(f"{count:,} {name}" for count, name in counts if count) or "none"
        return f"Clashes({len(self):,}: {said}{'; partial' if self.is_partial else ''})"


def _restored(
    columns: tuple[Any, ...],
    paths: tuple[str, ...],
    rules: tuple[str, ...],
    marks: Marks,
    facts: Facts,
    is_partial: bool,
    earlier: Clashes | None,
    shapes: PartShapes | None = None,
) -> Clashes:
    found = Clashes(Columns(*columns), paths, rules, marks=marks, facts=facts, is_partial=is_partial, shapes=shapes)
    if earlier is not None:
        found.set_earlier(earlier)
    return found


def _point(row: Any) -> Point:
    x, y, z = row.tolist()
    return (x, y, z)
