"""The document: all that is drawn and known, as one immutable value. Every change makes another.

What did not change is shared between the two, so that undo keeps whole documents, and a patch is the fields that are
not the same. Lengths are metres, poses 16 numbers row by row (`motion.Row`), parts indices into `mockup.parts`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, cast

from feeler.workbench.document.motion import HOME, Row
from feeler.workbench.document.protocol import DocumentFields

Point = tuple[float, float, float]
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""Metres of each unit that can be shown."""
MODES = ("stop", "glide", "pass")
MEASURES = ("point", "edge", "angle", "parts")
MATERIALS = ("steel", "aluminium", "plastic", "rubber")
"""Of which parts may be, as far as they are heard."""


@dataclass(frozen=True)
class MockupFacts:
    """What is open. triangles: of the parts that are in the scene; parts: all, so that every part's number is below."""

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
    """A record that can be replayed. is_playing: now. is_same, verdict: what came of it; None before that."""

    name: str
    is_playing: bool = False
    is_same: bool | None = None
    verdict: str | None = None


@dataclass(frozen=True)
class Loading:
    """What is being done until a mock-up is open; share: 0 to 1."""

    stage: str
    share: float


@dataclass(frozen=True)
class SectionPlane:
    """A cut: kept is where `normal . x >= offset`."""

    id: int
    normal: Point
    offset: float
    is_on: bool = True


@dataclass(frozen=True)
class Removal:
    """A line of the sequence: parts that were moved.

    way: poses of the hand, `world_from_hand`, from grip to release: `way[i] @ inverse(way[0])` carries the parts from
    where they were gripped. starts: where that was, of those that were not at home. least_clearance: of what moved, on
    the way, to all it was not seated on, metres; None where nothing was within reach. touched: paths of what it met or
    was stopped by.
    """

    id: int
    name: str
    parts: tuple[int, ...]
    way: tuple[Row, ...]
    least_clearance: float | None
    touched: tuple[str, ...]
    tool: str | None
    starts: tuple[tuple[int, Row], ...] = ()


@dataclass(frozen=True)
class Measure:
    """Something measured. value: metres or radians, as `unit` says; is_exact: found by the engine on the triangles."""

    id: int
    name: str
    type: str
    points: tuple[Point, ...]
    value: float
    unit: str
    is_exact: bool
    parts: tuple[int, ...] = ()


@dataclass(frozen=True)
class CameraView:
    """A camera: where it is, what it looks at, what is up, and its vertical field of view."""

    position: Point
    target: Point
    up: Point
    fov_rad: float


@dataclass(frozen=True)
class Viewpoint:
    """A camera with a name."""

    id: int
    name: str
    camera: CameraView


@dataclass(frozen=True)
class Findings:
    """What a clash check found. groups: as `findings.grouped` makes them; status: by the finding's id."""

    groups: tuple[Mapping[str, Any], ...]
    status: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    is_touching_hidden: bool = True


@dataclass(frozen=True)
class Trip:
    """What gripped parts went through so far.

    way: poses of the hand, as of `Removal`. touched: parts that were met or stopped them, ascending. seated: pairs of
    the hand's and the mock-up's parts that met at the grip, which count neither as clearance nor as touched.
    """

    way: tuple[Row, ...]
    touched: tuple[int, ...] = ()
    seated: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True)
class Isolation:
    """Which parts are isolated, and what was hidden before."""

    parts: tuple[int, ...]
    hidden_before: tuple[int, ...]


NOTHING: Mapping[int, Row] = MappingProxyType({})


@dataclass(frozen=True)
class Document:
    """All that is drawn and known.

    absent: parts that were left out of the scene from the start. hidden: only out of sight; such parts still collide.
    gripped: parts in the hand, and where there (`hand_from_part`). moved: where parts are that were put down elsewhere
    (`world_from_part`). out: those of them that lie outside the box of what is in the scene. tools: names of what
    `take_tool` can take. pose: where the hand was last put down by a command (`world_from_tool`).
    """

    mockup: MockupFacts | None = None
    loading: Loading | None = None
    failed: str | None = None
    tool: ToolFacts | None = None
    tools: tuple[str, ...] = ()
    record: RecordFacts | None = None
    absent: tuple[int, ...] = ()
    held_version: int = 0
    unit: str = "mm"
    mode: str = "stop"
    hidden: tuple[int, ...] = ()
    ghost: tuple[int, ...] = ()
    explode: float = 0.0
    isolation: Isolation | None = None
    sections: tuple[SectionPlane, ...] = ()
    pose: Row = HOME
    gripped: Mapping[int, Row] = field(default_factory=lambda: NOTHING)
    moved: Mapping[int, Row] = field(default_factory=lambda: NOTHING)
    out: tuple[int, ...] = ()
    sequence: tuple[Removal, ...] = ()
    trip: Trip | None = field(default=None, compare=False)
    replaying: int | None = None
    measures: tuple[Measure, ...] = ()
    viewpoints: tuple[Viewpoint, ...] = ()
    findings: Findings | None = None
    material: str | None = None
    next_id: int = 1

    def with_id(self, **changes: Any) -> Document:
        """Changed, with the number `next_id` used up."""
        return replace(self, next_id=self.next_id + 1, **changes)

    def to_json(self) -> DocumentFields:
        """All of it, as the page gets it."""
        return cast(DocumentFields, {name: _json_of(self, name) for name in JSON_FIELDS})


# What the page is told. The rest is what commands have to remember.
_KEPT_BACK = {"isolation", "next_id", "trip"}
_KEPT_BACK_OF = {Removal: {"starts"}, Measure: {"parts"}}
JSON_FIELDS = (*(f.name for f in fields(Document) if f.name not in _KEPT_BACK), "isolated")


def patch(before: Document, after: Document) -> dict[str, Any]:
    """The fields that are not the same, with their new values, as JSON."""
    return {name: _json_of(after, name) for name in JSON_FIELDS if _value(before, name) != _value(after, name)}


def _value(document: Document, name: str) -> Any:
    return document.isolation is not None if name == "isolated" else getattr(document, name)


def _json_of(document: Document, name: str) -> Any:
    if name == "gripped":
        return list(document.gripped)
    return plain(_value(document, name))


def plain(value: Any) -> Any:
    """Dataclasses, tuples and mappings as what JSON has."""
    if isinstance(value, (str, int, float)) or value is None:
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    kept_back = _KEPT_BACK_OF.get(type(value), ())
    return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.name not in kept_back}
