"""The messages between the page and the server, and the JSON objects in them: their only definition.

`tools/protocol_ts.py` generates `viewer/src/link/protocol.ts` from this file. Everything is SI (metres, newtons,
radians, seconds unless the name says otherwise), in the mock-up's frame ("world"); a pose is world_from_tool, row by
row. `frames.py` has the encoding. `FROM_PAGE` are the page's messages, `FROM_SERVER` the server's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, TypedDict, cast

import numpy as np
import numpy.typing as npt

from feeler.workbench.document.frames import (
    VERSION,
    Array,
    Partial,
    ProtocolError,
    id_of,
    pack,
    unpack,
    version_of,
)
from feeler.workbench.document.openings import FilePiece, OpeningRequest, OpenMockup, Opens, SendFiles
from feeler.workbench.document.protocol_findings import (
    ClashSettings,
    Findings,
    FindingStatus,
    KeptClear,
    RequirementResult,
)
from feeler.workbench.document.protocol_joints import JointRange, Joints, JointStep, Mechanism
from feeler.workbench.document.protocol_people import Here, Named, People, PersonMessage, Seen, Turning
from feeler.workbench.document.protocol_task import TaskCatalogue, TaskEditKind, TaskEdits, TaskTimes
from feeler.workbench.document.protocol_values import Camera, CameraPlace, LeftPattern, StalePart, Vec3

__all__ = [
    "FROM_PAGE",
    "FROM_SERVER",
    "MOST_CLEARANCES",
    "MOST_HITS",
    "MOST_PLANES",
    "NOT_ALLOWED",
    "RELOAD",
    "TOO_MANY_PAGES",
    "VERSION",
    "Camera",
    "CameraPlace",
    "FindingStatus",
    "Here",
    "Joints",
    "Named",
    "People",
    "ProtocolError",
    "RequirementResult",
    "Seen",
    "TaskEditKind",
    "Turning",
    "Vec3",
    "decode_from_page",
    "decode_from_server",
    "encode",
    "id_of",
    "version_of",
]

NOT_ALLOWED = 1008
"""Closes a socket without the token, or past a limit."""

RELOAD = 4001
"""Closes a socket of another protocol version: the page must reload."""

TOO_MANY_PAGES = 4002
"""Closes a socket of a page beyond the limit: another one must be closed first."""

MOST_HITS = 20_000
"""Colliding triangles listed in a state, of each side."""

MOST_PLANES = 32
"""Contact planes listed in a state."""

MOST_CLEARANCES = 16
"""Clearance rows listed in a state."""

F8 = npt.NDArray[np.float64]
F4 = npt.NDArray[np.float32]
U4 = npt.NDArray[np.uint32]
U1 = npt.NDArray[np.uint8]

Pose = list[float]
"""16 numbers of a rigid pose, row by row."""

Selection = list[int | str] | int | str
"""Parts: indices, paths or patterns."""


class CommandAnswer(TypedDict, total=False):
    """What a command answers. `id`: of what it added. `pose`: of the hand."""

    id: int
    pose: Pose
    undo_depth: int
    redo_depth: int


Unit = Literal["mm", "cm", "m", "in"]
Mode = Literal["stop", "glide", "pass"]
UpAxis = Literal["x", "y", "z"]
MeasureType = Literal["point", "edge", "angle", "parts"]
Material = Literal["steel", "aluminium", "plastic", "rubber"]
CardQuestion = Literal["removal", "order", "access", "swept", "task"]
LineQuestion = Literal["way", "shorten"]
CardKind = Literal["removal", "order", "access", "swept", "task", "way", "shorten"]
CardState = Literal["waiting", "running", "done", "failed", "cancelled"]
DepthKind = Literal["exact", "bound", "estimate"]
Source = Literal["mouse", "keys", "gizmo", "spacemouse", "gamepad", "xr", "api"]


# ---- JSON objects in messages ----


class MockupFacts(TypedDict):
    """Facts about the mock-up."""

    name: str
    hash: str
    """Hash of its content, hex: the address of its geometry."""
    triangles: int
    """Of the parts in the scene."""
    parts: int
    """All, including excluded ones: the number of every part is below it."""


class ToolFacts(TypedDict):
    """Facts about the tool in hand."""

    name: str
    triangles: int


class RecordFacts(TypedDict):
    """A record for the job "replay"."""

    name: str
    is_playing: bool
    is_same: bool | None
    """Whether all results equalled the recorded ones; null before that is known."""
    verdict: str | None
    """The same as a sentence."""
    at: float | None
    """The moment that is shown, seconds of the replay; null before one was."""
    has_gaps: bool
    """Whether the timeline of the question "record" has gaps."""


class ProjectFacts(TypedDict):
    """The project file that the document is saved in."""

    name: str
    state: Literal["saved", "saving", "failed", "read only"]
    trouble: str | None
    """Why it is not saved."""
    stale: dict[str, Literal["changed", "moved", "new"]]
    """By part id: parts that differ from those that the project's answers are about."""
    gone: list[str]
    """Paths of parts that this revision lacks."""
    aside: int
    """Removals, measures and cards of missing parts, which only the file has until these are back."""
    left: list[LeftPattern]
    """Patterns of requirements and rules that parts with another name have left."""


class Loading(TypedDict):
    """Progress of reading and indexing."""

    stage: str
    share: float
    """0 to 1."""


class Section(TypedDict):
    """A section plane: keeps the points with normal . x >= offset."""

    id: int
    normal: Vec3
    """Unit."""
    offset: float
    """Metres along the normal."""
    is_on: bool


class SectionBox(TypedDict):
    """A section box along the world axes: keeps the points inside it."""

    lower: Vec3
    upper: Vec3
    is_on: bool


class SequenceLine(TypedDict):
    """One removal: parts, their way, and its clearance."""

    id: int
    name: str
    parts: list[int]
    way: list[Pose]
    """world_from_hand."""
    least_clearance: float | None
    """Metres; 0 if something touched, null if not known."""
    touched: list[str]
    """Part paths."""
    tool: str | None
    joint: JointStep | None
    """Null: parts were moved freely."""
    stale: dict[str, StalePart]
    """By part id: parts of any kind that differ since. Empty: it is of the present revision."""


class Measure(TypedDict):
    """A measure with its points."""

    id: int
    name: str
    type: MeasureType
    points: list[Vec3]
    """Metres."""
    value: float
    unit: Literal["m", "rad"]
    is_exact: bool
    """Computed by the engine on the triangles, not from the picture."""
    stale: dict[str, StalePart]
    """By part id: its parts that differ since."""


class Viewpoint(TypedDict):
    """A stored camera, and the sections of that moment."""

    id: int
    name: str
    camera: Camera
    sections: list[Section] | None
    """Null in viewpoints of older projects: they change no sections."""
    section_box: SectionBox | None


class Card(TypedDict):
    """A question about parts, and its answer in a sentence; `GET /cards/ID` and the question "card" have the rest."""

    id: int
    question: CardKind
    parts: list[int]
    """Empty: all fasteners."""
    without: list[int]
    """Parts left out for this question."""
    options: dict[str, Any]
    """Tool, tools, catalogue, people, grip, swing_deg, clearance, seconds, as far as given."""
    title: str
    setting: str
    """The mock-up that it is about: what is out of it, or moved."""
    state: CardState
    share: float
    """0 to 1."""
    stage: str
    sentence: str
    """The answer; empty before it."""
    is_good: bool | None
    """Whether the answer is what one hopes for; null before it, and if it is neither."""
    is_stale: bool
    """Parts were moved since it was asked; of a line: its way, what is before it, or parts outside of the sequence."""
    line: int | None
    """The line of the sequence that it is about; null for questions about parts."""
    is_earlier: bool
    """It is about an earlier revision of the mock-up, and so stale."""
    edits: TaskEdits
    """Of a task: what the user changed."""
    clearances: list[float | None]
    """Of a line: the least one of each way of the answer, metres; null where nothing is near."""


class GivenWay(TypedDict):
    """A way of parts: poses of their motion in the world, the first the identity."""

    parts: list[int]
    poses: list[Pose]
    clearance: float | None
    """Metres; null: nothing near, or not known."""


class Guiding(TypedDict):
    """A way that guides the hand, which holds its parts."""

    card: int | None
    line: int | None
    step: int
    """Of the ways of the card, from 0."""
    parts: list[int]
    way: list[Pose]
    """world_from_hand, from where the hand was when it began."""


class DocumentFields(TypedDict):
    """The state that a page shows and that commands may change; a reload restores it."""

    mockup: MockupFacts | None
    loading: Loading | None
    """Null once the engine answers."""
    failed: str | None
    """Why there is no mock-up."""
    tool: ToolFacts | None
    tools: list[str]
    """Names for `take_tool`."""
    record: RecordFacts | None
    project: ProjectFacts | None
    absent: list[int]
    """Parts excluded when the mock-up was opened: they do not collide and are not drawn."""
    held_version: int
    """Version of the mesh in hand: fetch `/held/VERSION` when it changes; 0: the hand is empty."""
    unit: Unit
    mode: Mode
    hidden: list[int]
    ghost: list[int]
    explode: float
    """0 to 1."""
    isolated: bool
    sections: list[Section]
    section_box: SectionBox | None
    pose: Pose
    """The last pose of the hand that a command set."""
    gripped: list[int]
    moved: dict[str, Pose]
    """Part id -> world_from_part; the identity is the loaded place."""
    out: list[int]
    """Parts taken out of the mock-up."""
    sequence: list[SequenceLine]
    replaying: int | None
    """The line of the sequence being replayed."""
    guiding: Guiding | None
    """Null: nothing draws the hand."""
    measures: list[Measure]
    viewpoints: list[Viewpoint]
    findings: Findings | None
    cards: list[Card]
    clash: ClashSettings
    task_times: TaskTimes
    task_catalogue: TaskCatalogue
    requirements: list[KeptClear]
    material: Material | None
    doubts: list[str]
    """What puts answers about mock-up and tool in doubt, as their loaders found."""
    mechanism: Mechanism | None
    joint_ranges: list[JointRange]
    """Of its numbers that follow no other."""
    on_joint: str | None
    """The number of the joint on which the hand holds its parts."""


class ManifestParts(TypedDict):
    """The parts of a mock-up by column."""

    paths: list[str]
    """Empty for excluded parts."""
    triangles: list[int]
    lower: list[Vec3]
    """Of each part's box, metres; an empty or excluded part has lower above upper."""
    upper: list[Vec3]
    small: list[int]
    """1: so small beside the mock-up that it may be skipped while the camera moves."""
    colours: list[int]
    """sRGB as 0xRRGGBB, -1 for a part without one; empty: the mock-up has no colours, and the page chooses some."""


class ManifestPiece(TypedDict):
    """One piece of geometry, `GET /scene/pieces/K`."""

    triangles: int
    vertices: int
    first: int
    """Packed index of its first triangle: the number of triangles in the pieces before it."""
    bytes: int
    lower: Vec3
    upper: Vec3
    small: bool
    """Of small parts only."""
    parts: int
    """Number of parts with triangles in it."""


class Manifest(TypedDict):
    """The geometry of the mock-up, `GET /scene`: pieces, big shapes first, small parts at the end.

    A piece is little-endian: float32 positions[vertices][3], metres from `middle`; the part of each vertex, uint16 or
    uint32 as `part_bytes` says, padded to 4 bytes; uint16 index[triangles][3], padded to 4 bytes. A packed triangle is
    the index of a triangle in the order of the pieces.
    """

    hash: str
    name: str
    unit: str
    """Of the files that it was read from."""
    up: UpAxis
    middle: Vec3
    lower: Vec3
    upper: Vec3
    triangles: int
    """In the pieces: the drawn ones."""
    vertices: int
    part_bytes: Literal[2, 4]
    parts: ManifestParts
    pieces: list[ManifestPiece]


class HeldManifest(TypedDict):
    """The geometry in hand, in the hand's frame: its pieces, one after the other, are `GET /held/VERSION`."""

    version: int
    middle: Vec3
    lower: Vec3
    upper: Vec3
    triangles: int
    vertices: int
    part_bytes: Literal[2, 4]
    parts: list[str]
    """Paths; the part of a vertex is an index into them."""
    pieces: list[ManifestPiece]


class NearestPoints(TypedDict):
    """The distance of tool and mock-up, and the two closest points."""

    value: float
    tool_point: Vec3
    mockup_point: Vec3
    part: int


class Trouble(TypedDict):
    """An error, its place and a remedy; "where" and "do" may be empty."""

    what: str
    where: str
    do: str


# ---- page -> server ----


@dataclass(frozen=True)
class Hello:
    """The first message, within 2 seconds; nothing else is read before it."""

    KIND: ClassVar[str] = "hello"
    protocol: int
    token: str
    session: str | None
    """The session of the page before its connection broke."""
    last_event: int
    """The newest that the page has; 0: none."""


@dataclass(frozen=True, eq=False)
class Wish:
    """The target of the hand. Only the newest counts."""

    KIND: ClassVar[str] = "pose"
    seq: int
    time_ms: float
    """By the page's clock."""
    source: Source
    pose: Annotated[F8, Array("f8", (4, 4))]
    """world_from_tool, row by row."""


@dataclass(frozen=True)
class Ack:
    """Acknowledges a state. At most two may be unacknowledged."""

    KIND: ClassVar[str] = "ack"
    seq: int


@dataclass(frozen=True)
class Command:
    """Changes the document. Answered by a reply."""

    KIND: ClassVar[str] = "command"
    id: int
    name: str
    args: dict[str, Any]


@dataclass(frozen=True)
class Ask:
    """A question, which changes nothing. Answered by a reply."""

    KIND: ClassVar[str] = "ask"
    id: int
    name: str
    args: dict[str, Any]


@dataclass(frozen=True)
class Job:
    """Starts a long task: progress comes in messages of the same id, the result as a reply."""

    KIND: ClassVar[str] = "job"
    id: int
    name: str
    args: dict[str, Any]


@dataclass(frozen=True)
class Cancel:
    """Cancels a job of this page, whose reply is then an error; or drops a file of which pieces came."""

    KIND: ClassVar[str] = "cancel"
    id: int


@dataclass(frozen=True)
class Ping:
    """Asks whether the server is there: it replies at once, whatever else it does."""

    KIND: ClassVar[str] = "ping"
    id: int


@dataclass(frozen=True)
class Shot:
    """The picture for a "shot" event, or the next piece of it: a message may have 1 MiB, a picture more."""

    KIND: ClassVar[str] = "shot"
    id: int
    name: str
    png_base64: str
    """A multiple of 4 characters in each piece but the last."""
    more: bool
    """Another piece follows."""


@dataclass(frozen=True)
class Benchmarked:
    """The measurements for a "benchmark" event."""

    KIND: ClassVar[str] = "benchmarked"
    id: int
    figures: dict[str, Any]
    """As `Figures` of `viewer/src/app/benchmark.ts`."""


# ---- server -> page ----


@dataclass(frozen=True)
class Welcome:
    """The answer to hello: the whole state."""

    KIND: ClassVar[str] = "welcome"
    protocol: int
    session: str
    document: DocumentFields
    event: int
    """The newest event included in the document; later ones are greater."""
    device: bool
    """A haptic device moves the hand."""
    recording: bool
    held: HeldManifest | None
    """Of the mesh in hand; null: the hand is empty, or there is no mock-up yet."""
    versions: dict[str, str]
    """Versions of the server's software, by name."""
    opens: Opens | None
    """Null: the mock-up cannot be replaced from a page."""


@dataclass(frozen=True, eq=False)
class State:
    """The engine's results at the newest pose. A newer state replaces it."""

    KIND: ClassVar[str] = "state"
    seq: int
    pose_seq: int
    """The number of the wish that it answers."""
    engine_us: float
    age_ms: float
    """Time from the wish to the answer."""
    rate_hz: float
    """Answers per second."""
    mode: Mode
    is_free: bool
    """No collision and no containment."""
    blocked: bool
    """Contact holds the solid tool back from the wish."""
    force: Vec3
    torque: Vec3
    """About the tool's centre of area, N m."""
    depth: float
    """The length of the way out of a penetration; 0: there is none, or it is not known yet."""
    depth_kind: DepthKind
    """Kind of the depth: no way out is shorter, one may be, or this one does not free the tool."""
    hit_count: int
    """Colliding triangles of the mock-up, listed or not."""
    hit_more: int
    """Number of those not listed."""
    contact_more: int
    """Number of contact planes not listed."""
    distance: NearestPoints | None
    parts: list[int]
    """Ids of touched parts."""
    pose: Annotated[F8, Array("f8", (4, 4))]
    """Of the solid tool."""
    wish: Annotated[F8, Array("f8", (4, 4))]
    """Of the hand."""
    hits: Annotated[U4, Array("u4", ("hits",), MOST_HITS)]
    """Packed triangles of the mock-up."""
    tool_hits: Annotated[U4, Array("u4", ("tool hits",), MOST_HITS)]
    """Packed triangles of the mesh in hand."""
    planes: Annotated[F4, Array("f4", ("planes", 8), MOST_PLANES)]
    """A row per contact: point 3, normal 3 (from the mock-up to the tool), gap, share of the force in newtons."""
    plane_parts: Annotated[U4, Array("u4", ("planes",), MOST_PLANES)]
    clearance: Annotated[F4, Array("f4", ("clearances", 7), MOST_CLEARANCES)]
    """A row per near part: distance, point on the tool 3, point on the mock-up 3."""
    clearance_parts: Annotated[U4, Array("u4", ("clearances",), MOST_CLEARANCES)]


@dataclass(frozen=True)
class Patch:
    """A change of the document: the new values of some fields."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "patch"}
    n: int
    fields: Annotated[dict[str, Any], Partial(DocumentFields)]
    command: str | None
    """The command behind it; null: none."""
    undo_depth: int
    redo_depth: int


@dataclass(frozen=True)
class Impact:
    """The tool hit a part that it did not touch before."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "impact"}
    n: int
    part: int
    part_size_m: float
    """The diagonal of its box."""
    speed_m_per_s: float
    point: Vec3
    material: str | None
    force: float
    """Newtons."""


@dataclass(frozen=True)
class Notice:
    """A notice for the user."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "notice"}
    n: int
    level: Literal["info", "warning", "error"]
    text: str


@dataclass(frozen=True)
class ShotWanted:
    """A script requests a picture: one page answers by a shot of the same id."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "shot"}
    n: int
    id: int
    width: int
    height: int
    camera: Camera | None
    """Null: the page's own camera."""


@dataclass(frozen=True)
class BenchmarkWanted:
    """Requests measurements of the frame rate: the page answers by a "benchmarked" message of the same id."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "benchmark"}
    n: int
    id: int


@dataclass(frozen=True)
class HeldChanged:
    """The content of the hand changed: fetch `/held/VERSION`."""

    KIND: ClassVar[str] = "event"
    TAG: ClassVar[dict[str, Any]] = {"type": "held"}
    n: int
    version: int
    manifest: HeldManifest | None
    """Null: the hand is empty."""


@dataclass(frozen=True)
class Progress:
    """Progress of a job of this page. A newer message replaces it; it is not an event, because other pages ignore
    it."""

    KIND: ClassVar[str] = "progress"
    id: int
    share: float
    """0 to 1."""
    stage: str


@dataclass(frozen=True)
class Answer:
    """A command, question or job succeeded."""

    KIND: ClassVar[str] = "reply"
    TAG: ClassVar[dict[str, Any]] = {"ok": True}
    id: int
    result: Any


@dataclass(frozen=True)
class Refusal:
    """A command, question or job failed; or a message was invalid."""

    KIND: ClassVar[str] = "reply"
    TAG: ClassVar[dict[str, Any]] = {"ok": False}
    id: int | None
    """Null: the message had none."""
    error: Trouble


class Grid(TypedDict):
    """The places of vertices in a saved page: `lower + whole numbers * step`."""

    lower: Vec3
    step: float


@dataclass(frozen=True, eq=False)
class SavedPage:
    """The mock-up inside an HTML file; it is never sent."""

    KIND: ClassVar[str] = "page"
    document: DocumentFields
    camera: Camera | None
    """The initial view. Null: the page's own."""
    manifest: Manifest
    """Of the included pieces."""
    left_out: int
    """Triangles that had no room in the file."""
    grid: Grid
    findings: Annotated[U1, Array("u1", ("findings",))]
    """The frame of `FindingRows`; empty: there are none."""
    pieces: Annotated[U1, Array("u1", ("n",))]
    """The pieces of the manifest in order, filtered: see `page.py`."""


PageMessage = Hello | Wish | Ack | Command | Ask | Job | Cancel | Ping | Shot | Benchmarked
FromPage = PageMessage | OpeningRequest | PersonMessage
Event = Patch | Impact | Notice | ShotWanted | BenchmarkWanted | HeldChanged
FromServer = Welcome | State | Event | Progress | Answer | Refusal | People | Seen | Joints

FROM_PAGE: tuple[type, ...] = (
    *(Hello, Wish, Ack, Command, Ask, Job, Cancel, Ping, Shot, Benchmarked),
    *(SendFiles, FilePiece, OpenMockup),
    *(Named, Here, Turning),
)
FROM_SERVER: tuple[type, ...] = (
    *(Welcome, State),
    *(Patch, Impact, Notice, ShotWanted, BenchmarkWanted, HeldChanged),
    *(Progress, Answer, Refusal),
    *(People, Seen, Joints),
)


def encode(message: FromPage | FromServer) -> str | bytes:
    """The frame of a message: text, or bytes if it has arrays.

    Raises `ProtocolError` for a wrong shape, too many rows, and NaN or infinity in the JSON.
    """
    return pack(message)


def decode_from_page(frame: str | bytes) -> FromPage:
    """The message of a frame from a page. Raises `ProtocolError` for anything invalid, and nothing else."""
    return cast(FromPage, unpack(frame, FROM_PAGE))


def decode_from_server(frame: str | bytes) -> FromServer:
    """The message of a frame from a server. Raises `ProtocolError` for anything invalid."""
    return cast(FromServer, unpack(frame, FROM_SERVER))
