"""The document: the whole visible state, as one immutable value. Every change makes another.

Unchanged fields are shared between documents, so that undo can keep whole documents, and a patch consists of the fields
that differ. Lengths are metres, poses 16 numbers row by row (`motion.Row`), parts indices into `mockup.parts`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, cast

from feeler.clashes.tracking import NEW, Mark
from feeler.poses import inverse
from feeler.project.settings import ClashSettings
from feeler.workbench.document.finding_table import FindingTable
from feeler.workbench.document.joints import JointRange, JointStep, MechanismState
from feeler.workbench.document.motion import HOME, Row, matrix, row
from feeler.workbench.document.protocol import DocumentFields

Point = tuple[float, float, float]
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""Metres of each available unit."""
MODES = ("stop", "glide", "pass")
MEASURES = ("point", "edge", "angle", "parts")
NOTHING: Mapping[int, Row] = MappingProxyType({})
MATERIALS = ("steel", "aluminium", "plastic", "rubber")
"""Materials of parts, for their sounds."""


World = tuple[tuple[tuple[int, Row], ...], tuple[int, ...]]
"""Where the parts are: parts put down elsewhere, with their places, and parts in the hand."""


@dataclass(frozen=True)
class MockupFacts:
    """The open mock-up. triangles: of the parts in the scene; parts: all, so that every part's number is below it."""

    name: str
    hash: str
    triangles: int
    parts: int


@dataclass(frozen=True)
class ToolFacts:
    """The tool in hand, without gripped parts."""

    name: str
    triangles: int


@dataclass(frozen=True)
class RecordFacts:
    """A record for replay. is_playing: now. is_same, verdict: the result; None before there is one.

    at: the moment that is shown, seconds of the replay; None before one was. has_gaps: whether its timeline has gaps.
    """

    name: str
    is_playing: bool = False
    is_same: bool | None = None
    verdict: str | None = None
    at: float | None = None
    has_gaps: bool = False


@dataclass(frozen=True)
class LeftPattern:
    """A pattern that does not name a part any more, as that has another name: its paths now and before.

    of: "requirement" or "rule".
    """

    pattern: str
    of: str
    part: str
    was: str


@dataclass(frozen=True)
class ProjectFacts:
    """The project file that the document is saved in.

    state: "saved", "saving", "failed" or "read only". trouble: why it is not saved. stale: "changed", "moved" or "new"
    by part, for parts that differ from those that the project's answers are about. gone: paths of missing parts.
    aside: number of removals, measures and cards of missing parts, which only the file has until these are back.
    left: patterns of requirements and rules that parts with another name have left.
    """

    name: str
    state: str = "saving"
    trouble: str | None = None
    stale: Mapping[int, str] = field(default_factory=lambda: MappingProxyType({}))
    gone: tuple[str, ...] = ()
    aside: int = 0
    left: tuple[LeftPattern, ...] = ()


@dataclass(frozen=True)
class Loading:
    """The stage of opening a mock-up; share: 0 to 1."""

    stage: str
    share: float


@dataclass(frozen=True)
class SectionPlane:
    """A section: keeps the points with `normal . x >= offset`."""

    id: int
    normal: Point
    offset: float
    is_on: bool = True


@dataclass(frozen=True)
class SectionBox:
    """A section box along the world axes: keeps the points inside it."""

    lower: Point
    upper: Point
    is_on: bool = True

    @property
    def planes(self) -> list[tuple[Point, float]]:
        """Its faces: normals that point inward, and offsets."""
        lower = [(_axis(k, 1.0), at) for k, at in enumerate(self.lower)]
        return lower + [(_axis(k, -1.0), -at) for k, at in enumerate(self.upper)]


def _axis(k: int, sense: float) -> Point:
    x, y, z = (sense if axis == k else 0.0 for axis in range(3))
    return (x, y, z)


def active_planes(document: Document) -> list[tuple[Point, float]]:
    """The planes that cut the picture: normal and offset of the sections, and of the faces of the section box."""
    box = document.section_box
    cuts = [(each.normal, each.offset) for each in document.sections if each.is_on]
    return cuts + (box.planes if box is not None and box.is_on else [])


@dataclass(frozen=True)
class Since:
    """How a part differs from the one that a result was computed on. change: "changed", "moved" or "new"; content: a
    hash of the part then, empty for a new one."""

    change: str
    content: str


UP_TO_DATE: Mapping[int, Since] = MappingProxyType({})
"""Of a result: no part of it differs. Parts are those of an earlier revision of the mock-up otherwise."""
NONE_GONE: Mapping[str, str] = MappingProxyType({})
"""Of a result: the contents of parts that are gone since, as it knows them, by their keys; pages do not see them."""


@dataclass(frozen=True)
class Removal:
    """A line of the sequence: parts that were moved.

    way: poses of the hand, `world_from_hand`, from grip to release: `way[i] @ inverse(way[0])` moves the parts from
    where they were gripped. starts: these places, for parts that were not at home. least_clearance: of the moved parts,
    on the way, to all parts without seats, metres; None if no part came within reach. touched: paths of the parts that
    they touched or that stopped them. out: those of its parts that it took out of the mock-up. joint: the move of a
    joint that it is; None: parts were moved freely. stale: parts of any kind that differ since; gone: as `NONE_GONE`.
    """

    id: int
    name: str
    parts: tuple[int, ...]
    way: tuple[Row, ...]
    least_clearance: float | None
    touched: tuple[str, ...]
    tool: str | None
    starts: tuple[tuple[int, Row], ...] = ()
    out: tuple[int, ...] = ()
    joint: JointStep | None = None
    stale: Mapping[int, Since] = field(default_factory=lambda: UP_TO_DATE)
    gone: Mapping[str, str] = field(default_factory=lambda: NONE_GONE)

    @cached_property
    def before(self) -> Mapping[int, Row]:
        """Where its parts begin."""
        return {part: dict(self.starts).get(part, HOME) for part in self.parts}

    @cached_property
    def after(self) -> Mapping[int, Row]:
        """Where its parts end."""
        moves = matrix(self.way[-1]) @ inverse(matrix(self.way[0]))
        return {part: row(moves @ matrix(start)) for part, start in self.before.items()}

    @cached_property
    def way_key(self) -> str:
        """The same for the same parts on the same way, with the same tool."""
        told = repr((self.parts, self.way, self.starts, self.tool))
        return hashlib.blake2b(told.encode("utf-8", "surrogatepass"), digest_size=8).hexdigest()


@dataclass(frozen=True)
class Measure:
    """A measure. value: metres or radians, as in `unit`; is_exact: computed by the engine on the triangles. stale: its
    parts that differ since."""

    id: int
    name: str
    type: str
    points: tuple[Point, ...]
    value: float
    unit: str
    is_exact: bool
    parts: tuple[int, ...] = ()
    stale: Mapping[int, Since] = field(default_factory=lambda: UP_TO_DATE)


@dataclass(frozen=True)
class CameraView:
    """A camera: its position, target, up direction, vertical field of view, and projection."""

    position: Point
    target: Point
    up: Point
    fov_rad: float
    is_parallel: bool = False


@dataclass(frozen=True)
class Viewpoint:
    """A camera with a name, and the sections of that moment. sections: None in viewpoints of older projects."""

    id: int
    name: str
    camera: CameraView
    sections: tuple[SectionPlane, ...] | None = None
    section_box: SectionBox | None = None


@dataclass(frozen=True)
class OwnGroup:
    """A group of findings that somebody made."""

    id: int
    name: str


@dataclass(frozen=True)
class Check:
    """A clash check that was run here.

    clearance, contact: metres; contact None: the chordal errors of both parts. of: the parts whose pairs were checked;
    None: all. moved, out, gripped: where parts lay, as in `Document`: the findings are stale when that is no longer so.
    """

    clearance: float
    contact: float | None
    of: tuple[int, ...] | None
    moved: Mapping[int, Row]
    out: tuple[int, ...]
    gripped: tuple[int, ...]


_UNSEEN = ("table", "aside", "authors", "resolved", "gone")


@dataclass(frozen=True)
class Findings:
    """The findings of a clash check, and what people did with them.

    table: the findings themselves. status, notes: by the finding's id, those that differ from the table's. authors: who
    set these, or an empty name; pages do not see them. own_groups: made by hand, and `members` the group of a finding
    by its id. check: None for findings of a file. aside: the marks of findings that an exclusion hides, for when it is
    gone; pages do not see them. stale: parts that differ since, also those without findings; gone: as `NONE_GONE`.
    resolved: findings of the check before that are gone, as JSON; pages do not see them.
    """

    table: FindingTable
    status: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    notes: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    own_groups: tuple[OwnGroup, ...] = ()
    members: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    is_touching_hidden: bool = True
    check: Check | None = None
    aside: Mapping[str, Mark] = field(default_factory=lambda: MappingProxyType({}))
    stale: Mapping[int, Since] = field(default_factory=lambda: UP_TO_DATE)
    gone: Mapping[str, str] = field(default_factory=lambda: NONE_GONE)
    authors: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    resolved: tuple[Mapping[str, Any], ...] = ()

    def mark_of(self, name: str) -> Mark:
        """The mark of a finding, in the table or aside."""
        if name in self.table.row_of:
            return self.table.mark_of(name, self.status, self.notes, self.authors)
        return self.aside.get(name, NEW)

    def to_json(self) -> dict[str, Any]:
        """All but the rows, which pages fetch by their version."""
        return {
            "version": self.table.key,
            "count": len(self.table),
            "counts": self.table.counts,
            "hidden": dict(self.table.hidden),
            **{f.name: plain(getattr(self, f.name)) for f in fields(self) if f.name not in _UNSEEN},
        }


@dataclass(frozen=True)
class Verdict:
    """What a requirement was when it was checked last; lengths in metres. of: where parts lay, as in `Check`.

    status: "holds", "violated", or "unknown" with the reason in `trouble`. pairs: how many pairs of parts violate it;
    the others are of the worst of them. stale: parts that it is about and that differ since; gone: as `NONE_GONE`.
    """

    status: str
    pairs: int = 0
    gap: float | None = None
    depth: float | None = None
    parts: tuple[int, ...] = ()
    points: tuple[Point, ...] = ()
    trouble: str | None = None
    moved: Mapping[int, Row] = field(default_factory=lambda: NOTHING)
    out: tuple[int, ...] = ()
    gripped: tuple[int, ...] = ()
    stale: Mapping[int, Since] = field(default_factory=lambda: UP_TO_DATE)
    gone: Mapping[str, str] = field(default_factory=lambda: NONE_GONE)


@dataclass(frozen=True)
class KeptClear:
    """A clearance that must hold: parts of pattern `a` stay at least `gap` metres away from those of `b`.

    verdict: None before it was checked as it is.
    """

    id: int
    name: str
    a: str
    b: str
    gap: float
    verdict: Verdict | None = None


@dataclass(frozen=True)
class TaskEdits:
    """What the user changed of a task, by paths.

    off: parts that are off already. times: of parts, the seconds of their steps. before: pairs of parts of which the
    first goes before the second. table: of the table of times, a digest; empty: the examples. catalogue: likewise of
    that of tools, where they are chosen from it; empty: the built-in one.
    """

    off: tuple[str, ...] = ()
    times: tuple[tuple[str, float], ...] = ()
    before: tuple[tuple[str, str], ...] = ()
    table: str = ""
    catalogue: str = ""


@dataclass(frozen=True)
class TaskTimes:
    """The table of times that tasks use: the name of its file, TOML, and how many of the elements it gives. Empty: all
    are examples."""

    name: str = ""
    toml: str = ""
    given: int = 0

    @property
    def digest(self) -> str:
        """Of the content; empty without."""
        return _digest(self.toml)


@dataclass(frozen=True)
class TaskCatalogue:
    """The catalogue that tools of tasks are chosen from: the name of its file, TOML, and how many tools it has. Empty:
    the built-in one."""

    name: str = ""
    toml: str = ""
    tools: int = 0

    @property
    def digest(self) -> str:
        """Of the content; empty without."""
        return _digest(self.toml)


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode("utf-8", "surrogatepass"), digest_size=8).hexdigest() if text else ""


NO_EDIT = TaskEdits()


@dataclass(frozen=True)
class Card:
    """A question about parts, and its answer in a sentence.

    without: parts left out for this question. options: tool, tools, catalogue, grip and so on, as far as given.
    setting: the mock-up that it is about, in words; world: the same, as `Document.world`. share, stage: the progress.
    is_good: whether the answer is what one hopes for; None before it, and if it is neither. line: the line of the
    sequence that it is about, and way its `way_key`; world is that of `line_world` then. is_earlier: it is about an
    earlier revision of the mock-up. edits: of a task, those that its answer is about. clearances: of a line, the least
    one of each way of the answer, metres; None where nothing is near.
    """

    id: int
    question: str
    parts: tuple[int, ...]
    without: tuple[int, ...]
    options: Mapping[str, Any]
    title: str
    setting: str
    world: World
    state: str = "waiting"
    share: float = 0.0
    stage: str = ""
    sentence: str = ""
    is_good: bool | None = None
    line: int | None = None
    way: str = ""
    is_earlier: bool = False
    edits: TaskEdits = NO_EDIT
    clearances: tuple[float | None, ...] = ()


NO_EDITS: Mapping[int, TaskEdits] = MappingProxyType({})


@dataclass(frozen=True)
class Trip:
    """The trip of gripped parts so far.

    way: poses of the hand, as in `Removal`. touched: parts that they touched or that stopped them, ascending. seated:
    seats at the grip, as pairs of hand part and mock-up part; they count neither for clearance nor as touched.
    """

    way: tuple[Row, ...]
    touched: tuple[int, ...] = ()
    seated: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True)
class Guiding:
    """A way that guides the hand: step `step` of a card, or a line of the sequence. way: poses of the hand."""

    card: int | None
    line: int | None
    step: int
    parts: tuple[int, ...]
    way: tuple[Row, ...]


@dataclass(frozen=True)
class Isolation:
    """The isolated parts, and the parts hidden before."""

    parts: tuple[int, ...]
    hidden_before: tuple[int, ...]


@dataclass(frozen=True)
class Document:
    """The whole visible state.

    absent: parts excluded when the mock-up was opened. hidden: invisible parts; they still collide. gripped: parts in
    the hand, and their places in it (`hand_from_part`). moved: places of parts put down elsewhere (`world_from_part`).
    out: those of them outside the box of the scene. tools: names for `take_tool`. pose: the last pose of the hand that
    a command set (`world_from_tool`). doubts: of the loaders of mock-up and tool. mechanism: its links are among the
    moved parts. joint_ranges: of its numbers, as far as they are known. on_joint: the number of the joint on which the
    hand holds its parts. task_edits: by the number of the card.
    """

    mockup: MockupFacts | None = None
    loading: Loading | None = None
    failed: str | None = None
    tool: ToolFacts | None = None
    tools: tuple[str, ...] = ()
    record: RecordFacts | None = None
    project: ProjectFacts | None = None
    absent: tuple[int, ...] = ()
    held_version: int = 0
    unit: str = "mm"
    mode: str = "stop"
    hidden: tuple[int, ...] = ()
    ghost: tuple[int, ...] = ()
    explode: float = 0.0
    isolation: Isolation | None = None
    sections: tuple[SectionPlane, ...] = ()
    section_box: SectionBox | None = None
    pose: Row = HOME
    gripped: Mapping[int, Row] = field(default_factory=lambda: NOTHING)
    moved: Mapping[int, Row] = field(default_factory=lambda: NOTHING)
    out: tuple[int, ...] = ()
    sequence: tuple[Removal, ...] = ()
    trip: Trip | None = field(default=None, compare=False)
    replaying: int | None = None
    guiding: Guiding | None = None
    measures: tuple[Measure, ...] = ()
    viewpoints: tuple[Viewpoint, ...] = ()
    findings: Findings | None = None
    cards: tuple[Card, ...] = ()
    task_edits: Mapping[int, TaskEdits] = field(default_factory=lambda: NO_EDITS)
    task_times: TaskTimes = TaskTimes()
    task_catalogue: TaskCatalogue = TaskCatalogue()
    clash: ClashSettings = field(default_factory=ClashSettings)
    requirements: tuple[KeptClear, ...] = ()
    material: str | None = None
    doubts: tuple[str, ...] = ()
    mechanism: MechanismState | None = None
    joint_ranges: tuple[JointRange, ...] = ()
    on_joint: str | None = None
    next_id: int = 1
    next_card: int = 1

    @property
    def world(self) -> World:
        """A key of the world: parts put down elsewhere, and parts absent from it."""
        return (tuple((part, place) for part, place in self.moved.items() if place != HOME), tuple(self.gripped))

    def with_id(self, **changes: Any) -> Document:
        """A changed document with `next_id` used up."""
        return replace(self, next_id=self.next_id + 1, **changes)

    def to_json(self) -> DocumentFields:
        """All of it, in the form for the page."""
        return cast(DocumentFields, {name: _json_of(self, name) for name in JSON_FIELDS})


# The fields that the page gets. Only commands need the others.
_KEPT_BACK = {"isolation", "next_card", "next_id", "task_edits", "trip"}
_KEPT_BACK_OF = {
    Card: {"way", "world"},
    Removal: {"out", "starts", "gone"},
    Verdict: {"gone"},
    Measure: {"parts"},
    MechanismState: {"order", "text"},
    TaskTimes: {"toml"},
    TaskCatalogue: {"toml"},
    JointRange: {"key"},
    JointStep: {"start"},
    Since: {"content"},
}
JSON_FIELDS = (*(f.name for f in fields(Document) if f.name not in _KEPT_BACK), "isolated")


def line_places(document: Document, at: int) -> dict[int, Row]:
    """Where parts lie when a line of the sequence begins, as far as they are not where they were loaded: those of the
    lines before it at their ends, those of later ones where they begin, others where they lie now."""
    places = dict(document.moved)
    seen: set[int] = set()
    for number, line in enumerate(document.sequence):
        if number < at:
            places.update(line.after)
            seen.update(line.parts)
        else:
            places.update({part: start for part, start in line.before.items() if part not in seen})
            seen.update(line.parts)
    return {part: place for part, place in sorted(places.items()) if place != HOME}


def line_out(document: Document, at: int) -> tuple[int, ...]:
    """The parts that are out of the mock-up then."""
    out = set(document.out).difference(part for line in document.sequence for part in line.parts)
    for line in document.sequence[:at]:
        out = out.difference(line.parts).union(line.out)
    return tuple(sorted(out))


def line_world(document: Document, at: int) -> World:
    """A key of where parts lie when a line begins, and which of them are out."""
    # Asked for at each change of the document, also where a question only goes on.
    about = (document.sequence, document.moved, document.out)
    key = (*map(id, about), at)
    kept = _line_worlds.get(key)
    if kept is None:
        places = line_places(document, at)
        rounded = tuple((part, tuple(round(each, 9) for each in place)) for part, place in places.items())
        kept = (about, (rounded, line_out(document, at)))
        if len(_line_worlds) >= _MOST_LINE_WORLDS:
            _line_worlds.clear()
        _line_worlds[key] = kept
    return kept[1]


_MOST_LINE_WORLDS = 256
_line_worlds: dict[tuple[int, ...], tuple[object, World]] = {}
"""By the identity of what they are about, which is kept with them so that it stays theirs."""


def is_stale(document: Document, card: Card) -> bool:
    """Whether the answer of a card is about another mock-up, or another way."""
    if card.is_earlier:
        return True
    if card.line is None:
        return card.world != document.world
    at = next((at for at, line in enumerate(document.sequence) if line.id == card.line), None)
    return at is None or card.way != document.sequence[at].way_key or card.world != line_world(document, at)


def patch(before: Document, after: Document) -> dict[str, Any]:
    """The fields that differ, with their new values, as JSON."""
    return {name: _json_of(after, name) for name in JSON_FIELDS if _value(before, name) != _value(after, name)}


def _value(document: Document, name: str) -> Any:
    if name == "isolated":
        return document.isolation is not None
    if name == "cards":
        return tuple((card, is_stale(document, card)) for card in document.cards)
    return getattr(document, name)


def _json_of(document: Document, name: str) -> Any:
    if name == "gripped":
        return list(document.gripped)
    if name == "cards":
        return [{**plain(card), "is_stale": is_stale} for card, is_stale in _value(document, name)]
    return plain(_value(document, name))


def plain(value: Any) -> Any:
    """Dataclasses, tuples and mappings as JSON values."""
    if isinstance(value, (str, int, float)) or value is None:
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    if isinstance(value, Findings):
        return value.to_json()
    kept_back = _KEPT_BACK_OF.get(type(value), ())
    return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.name not in kept_back}
