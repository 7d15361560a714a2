"""Answers to questions and jobs, as JSON objects; `asking.py` has the names and arguments of these."""

from __future__ import annotations

from typing import Literal, TypedDict

from feeler.workbench.document.protocol import GivenWay, HeldManifest, MeasureType, Pose, Vec3
from feeler.workbench.document.protocol_joints import JointMet


class JointGhost(TypedDict):
    """The parts that a joint moves, at its worst position."""

    manifest: HeldManifest
    """In the world's frame."""
    data: str
    """Base64 of its pieces, one after the other."""


class JointPlace(TypedDict):
    """Where a joint got to, as far as contact let it."""

    name: str
    value: float
    """Radians or metres."""
    stop: Literal["contact", "limit", "end"] | None
    """What ends it there. end: neither contact nor a limit, and `why` says what."""
    met: JointMet | None
    """The contact that stops the joint; null without one."""
    why: str
    values: dict[str, float]
    """All numbers."""


class RayHit(TypedDict):
    """The first visible hit of a ray."""

    distance: float
    point: Vec3
    normal: Vec3
    part: int
    triangle: int
    """Of the mock-up; -1: the fill of a section."""


class Snapped(RayHit):
    """The same, with the point snapped to a near corner or edge."""

    type: Literal["vertex", "edge", "face"]
    corners: tuple[Vec3, Vec3, Vec3]
    """Of the triangle, at its present place."""


class Measured(TypedDict):
    """The value of a measure."""

    type: MeasureType
    points: list[Vec3]
    value: float
    unit: Literal["m", "rad"]
    is_exact: bool
    parts: list[int]


class PartFacts(TypedDict):
    """Facts about a part."""

    part: int
    name: str
    path: str
    triangles: int
    lower: Vec3 | None
    """Null: the part has no triangle that can be queried."""
    upper: Vec3 | None
    is_closed: bool
    """Each edge has as many triangles on one side as on the other."""
    volume: float | None
    """Cubic metres; null: it is not closed."""
    area: float
    """Square metres."""
    state: Literal["gripped", "moved", "in place", "left out"]
    is_hidden: bool
    attributes: dict[str, str]
    """As its file states them; at most 100."""


class FoundParts(TypedDict):
    """The parts that a search finds."""

    count: int
    parts: str
    """Base64 of little-endian uint32 `(count,)`, ascending."""


class Outline(TypedDict):
    """The cuts of the mock-up by planes."""

    count: int
    segments: str
    """Base64 of little-endian float32 `(count, 2, 3)`: metres, world."""
    parts: str
    """Base64 of little-endian uint32 `(count,)`."""


class Written(TypedDict):
    """A file to fetch: `GET /exports/NAME`."""

    name: str
    bytes: int


class WrittenFindings(Written):
    """A file of findings or rules."""

    notes: list[str]
    """How the file falls short, for people."""


class WrittenPage(Written):
    """One HTML file with the mock-up inside."""

    left_out: int
    """Triangles that did not fit."""


class Replayed(TypedDict):
    """The result of a replay."""

    is_same: bool
    verdict: str


class Gap(TypedDict):
    """The nearest neighbour at one pose of a way, without parts in contact since the start."""

    share: float
    """Of the length of the way, 0 to 1."""
    gap: float | None
    """Metres; null: none within the distance looked at."""
    part: int | None
    point: Vec3 | None
    """On the part, world."""


class WayHit(TypedDict):
    """Where a way does not hold."""

    share: float
    """Of the length of the way, 0 to 1."""
    part: int
    point: Vec3
    """On the part, world."""


class RecordStep(TypedDict):
    """A command of a record."""

    at: float
    """Of the replay, seconds."""
    time: float
    """Of the recorded session, seconds since its start."""
    title: str


class RecordTimeline(TypedDict):
    """A record over time."""

    seconds: float
    """Of a replay at the recorded speed: pauses are cut."""
    steps: list[RecordStep]
    gaps: list[Gap]
    """At some moments, `share` of `seconds`; empty before the record was replayed."""


class FoundWay(GivenWay):
    """A way that was found, with what it passes."""

    legs: list[str]
    length: float
    """The travel of the middle of the parts, metres."""
    rotation: float
    """Radians in total."""
    gaps: list[Gap]
    """At some poses of it, in order: between them the gap may be smaller."""


class WayFacts(FoundWay, total=False):
    """The same, with where parts lie when it begins; of a removal in the sequence also where it does not hold."""

    places: dict[str, Pose]
    """Part id -> world_from_part, of parts that are not where they were loaded."""
    hit: WayHit


class FilmWay(WayFacts):
    """A line of the sequence, as a way."""

    id: int
    starts: dict[str, Pose]
    """world_from_part of its parts before it; those that are missing were at home."""


class SequenceFilm(TypedDict):
    """The sequence of removals as a film."""

    ways: list[FilmWay]


class BlockerFacts(TypedDict):
    """A part that stops others."""

    part: int
    attempts: int
    """How many attempts it stopped; 0 for one that holds them by proof."""
    is_proof: bool
    """No path exists while it stays."""
    pose: Pose
    """The motion of the moving parts where it stopped the best attempt."""


class ReachFacts(TypedDict):
    """Which tools reach a fastener."""

    part: int | None
    name: str
    kind: str
    tool: str
    """The one that swings farthest, or the first of the catalogue; the other figures are of it. If none reaches, the
    one that came nearest; empty: none fits."""
    tools: list[str]
    """All that reach it, of those that were tried; of a catalogue the first."""
    is_catalogue: bool
    """It is a tool, or a chain, of the catalogue."""
    head: str
    """Its drive and width, in words; empty: the mesh does not show them."""
    strokes: int | None
    """For one turn; null: it is not reached, or not known."""
    has_hand: bool | None
    """Whether a hand fits at the grip; null: not asked."""
    is_reachable: bool
    swing_deg: float
    because: str
    pose: Pose
    """world_from_tool of the tool in its seat, in the middle of the swing."""
    way: list[Pose]
    """The way in; empty: none was found."""
    point: Vec3
    axis: Vec3
    """Out of the joint."""
    fan: list[Vec3]
    """The path of the tool's far end over its free swing; empty without one."""
    blockers: list[int]


class Fact(TypedDict):
    """A figure with its name, in words."""

    name: str
    figure: str


class TaskStepFacts(TypedDict):
    """A step of a task; its way is that of the answer with the same number."""

    verb: str
    """"undo", "disconnect" or "take out"."""
    part: int
    """The fastener, or the first part."""
    tool: str
    """Empty: by hand, or without tools."""
    swing_deg: float | None
    strokes: int
    tool_way: list[Pose]
    """world_from_tool: the tool's way in, the last one in its seat; empty without one."""
    person: int
    """From 0."""
    start: float
    """Seconds from the beginning."""
    seconds: float
    spread: float
    """The standard deviation, seconds."""
    after: list[int]
    """Steps that have to be done before, by number."""
    because: str
    arithmetic: str
    is_typed: bool
    """The user typed its time."""


class TaskBlockerFacts(TypedDict):
    """Something that nothing frees."""

    part: int | None
    """Null: all parts asked for, together."""
    because: str
    blockers: list[int]


class TaskAnswer(TypedDict):
    """How parts are taken out; without steps if no plan was found."""

    steps: list[TaskStepFacts]
    seconds: float | None
    """Of the best plan that was found; null: none was."""
    spread: float | None
    bound: float | None
    """No plan takes fewer seconds."""
    people: int
    is_complete: bool
    """The search ended by itself, not at a limit."""
    blocked: list[TaskBlockerFacts]
    notes: list[str]


class ToolGhost(TypedDict):
    """A tool in its seat."""

    manifest: HeldManifest
    """In the world's frame."""
    data: str
    """Base64 of its pieces, one after the other."""


class TaskSight(TypedDict):
    """What is seen of the fastener of a step, from the best of the eyes around its head."""

    share: float
    """Of the head, 0 to 1."""
    hidden_by: list[int]
    """The parts in front of the rest, the worst first."""
    picture: str
    """Base64 of a PNG from that eye; the fastener is blue."""
    size: tuple[int, int]
    """Width and height, pixels."""


class AnswerFacts(TypedDict):
    """The answer of a card, without a task."""

    id: int
    ways: list[WayFacts]
    """One after the other; for an order, the last one is of the parts asked for."""
    blockers: list[BlockerFacts]
    reaches: list[ReachFacts]
    room: HeldManifest | None
    """The swept volume, in the world's frame: its pieces are `GET /cards/ID`."""
    facts: list[Fact]
    """What else is to be said."""


class CardAnswer(AnswerFacts, total=False):
    """The whole answer of a card."""

    task: TaskAnswer
    """Of a task."""
