"""The content of a report as plain values, ready to be written: texts are bounded, parts are paths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from feeler.project.parts import PartChanges
from feeler.workbench.document.motion import Row

Point = tuple[float, float, float]
_SHOWN = 3  # paths in a sentence


@dataclass(frozen=True)
class Mark:
    """A line of the history of a finding. at: UTC."""

    at: str
    status: str
    by: str
    note: str


@dataclass(frozen=True)
class PairPlace:
    """Two parts and where they meet, for a picture."""

    a: int
    b: int
    point_a: Point
    point_b: Point
    translation: Point


@dataclass(frozen=True)
class SomeParts:
    """How many parts, and the paths of the first of them."""

    count: int = 0
    paths: tuple[str, ...] = ()

    def __str__(self) -> str:
        shown = self.paths[:_SHOWN]
        left = self.count - len(shown)
        return ", ".join(shown) + (f" and {left:,} more" if left else "")


@dataclass(frozen=True)
class Layout:
    """What a check was of: parts that were out and those in the hand did not count, others were moved."""

    out: SomeParts = SomeParts()
    in_hand: SomeParts = SomeParts()
    moved: SomeParts = SomeParts()

    def __str__(self) -> str:
        left = [f"{parts} ({how})" for parts, how in ((self.out, "out"), (self.in_hand, "in the hand")) if parts.count]
        said = [f"Left out of this check: {', '.join(left)}."] if left else []
        return " ".join([*said, f"Moved at this check: {self.moved}."] if self.moved.count else said)


@dataclass(frozen=True)
class RequirementRow:
    """A clearance that must hold. status: "holds", "violated", "unknown" or "not checked". stale: what of the mock-up
    changed since; is_moved: parts lie elsewhere since. layout: of its check.

    gap, depth: metres, of the worst pair. pairs: how many violate it.
    """

    id: int
    name: str
    a: str
    b: str
    required: float
    status: str
    sentence: str
    stale: str = ""
    is_moved: bool = False
    layout: Layout = Layout()
    gap: float | None = None
    depth: float | None = None
    pairs: int = 0
    path_a: str = ""
    path_b: str = ""
    point: Point | None = None
    place: PairPlace | None = None


@dataclass(frozen=True)
class FindingRow:
    """A finding of a clash check. stale: how its parts differ now. place: None if a part is not in the mock-up."""

    id: str
    a: str
    b: str
    verdict: str
    severity: str
    rule: str
    status: str
    group: str
    by: str
    note: str
    sentence: str
    extent: str
    depth: float | None
    gap: float | None
    point: Point | None
    is_touching: bool
    stale: str = ""
    history: tuple[Mark, ...] = ()
    place: PairPlace | None = None


@dataclass(frozen=True)
class Check:
    """The clash check: its limits, the parts that it was limited to, and whether parts were moved after it.

    contact: metres, or how it was chosen ("chord"). of: only pairs with these.
    """

    clearance: float
    contact: float | str
    hidden: Mapping[str, int]
    is_moved: bool
    of: tuple[str, ...]
    layout: Layout = Layout()


@dataclass(frozen=True)
class WayRow:
    """A way of parts. poses: their motion, the first the identity; starts: their places before, if not home.

    gone: parts that are not there, or elsewhere. length, clearance: metres; rotation: radians. gaps: to the nearest
    neighbour, metres, at shares of the way; None: none is near. checked: what a check of the way says. joint: its move
    in words, if a joint moves the parts; they do not leave then.
    """

    key: str
    title: str
    paths: tuple[str, ...]
    parts: tuple[int, ...]
    poses: tuple[Row, ...]
    starts: Mapping[int, Row]
    gone: frozenset[int]
    legs: tuple[str, ...]
    length: float
    rotation: float | None
    clearance: float | None
    touched: tuple[str, ...] = ()
    tool: str = ""
    stale: str = ""
    gaps: tuple[tuple[float, float | None], ...] = ()
    checked: str = ""
    joint: str = ""


@dataclass(frozen=True)
class BlockerRow:
    """A part that stops others."""

    path: str
    attempts: int
    is_proof: bool


@dataclass(frozen=True)
class ReachRow:
    """Which tools reach a fastener. tool: the one that the figures are of; tools: all that reach it."""

    path: str
    kind: str
    tool: str
    tools: tuple[str, ...]
    is_reachable: bool
    swing_deg: float
    because: str
    blockers: tuple[str, ...]


@dataclass(frozen=True)
class TaskStepRow:
    """A step of a task. person: from 1. start, seconds, spread: seconds. edited: what the user changed of it."""

    number: int
    verb: str
    path: str
    tool: str
    person: int
    start: float
    seconds: float
    spread: float
    arithmetic: str
    because: str
    edited: str


@dataclass(frozen=True)
class QuestionRow:
    """A card: its question, the answer in words, and the ways.

    stale: which of its parts changed since; is_moved: parts were moved since. is_order: the ways are the steps of an
    order.
    """

    id: int
    kind: str
    title: str
    setting: str
    sentence: str
    is_good: bool | None
    stale: str
    is_moved: bool = False
    ways: tuple[WayRow, ...] = ()
    blockers: tuple[BlockerRow, ...] = ()
    reaches: tuple[ReachRow, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    task: tuple[TaskStepRow, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def is_order(self) -> bool:
        """Whether its ways are steps, one after the other."""
        return self.kind in ("order", "task")


@dataclass(frozen=True)
class MaintenanceRow:
    """A part, or several, of a run of `feeler maintain`. seconds, spread: None if they do not come out; why says why.

    reach: the least free swing of a tool, degrees. sight: the share that is seen of heads; hidden: heads not seen.
    """

    name: str
    paths: tuple[str, ...]
    state: str
    seconds: float | None
    spread: float | None
    steps: int
    tools: tuple[str, ...]
    reach_deg: float | None
    sight: float | None
    hidden: int
    change: str
    is_worse: bool
    why: str
    renamed_from: str


@dataclass(frozen=True)
class Maintenance:
    """The last run of `feeler maintain`. at: UTC. stale: how the mock-up changed since."""

    at: str
    sentence: str
    is_partial: bool
    stale: str
    rows: tuple[MaintenanceRow, ...]


@dataclass(frozen=True)
class Report:
    """The whole content.

    sources: names of the files of the mock-up. content: its digest. stale: the parts that differ from those that the
    answers are about. notes: what is to be known about the report itself.
    """

    title: str
    project: str
    made: str
    version: str
    sources: tuple[str, ...]
    content: str
    parts: int
    triangles: int
    tool: str
    stale: PartChanges
    check: Check | None
    requirements: tuple[RequirementRow, ...]
    findings: tuple[FindingRow, ...]
    resolved: tuple[FindingRow, ...]
    questions: tuple[QuestionRow, ...]
    steps: tuple[WayRow, ...]
    maintenance: Maintenance | None = None
    notes: tuple[str, ...] = ()


@dataclass
class Media:
    """Pictures (PNG) and films (GLB) by the key of their row; files beside the report by name.

    is_partial: the work was stopped before all were made.
    """

    pictures: dict[str, list[bytes]] = field(default_factory=dict)
    films: dict[str, bytes] = field(default_factory=dict)
    page: bytes | None = None
    is_partial: bool = False
    left_out: list[str] = field(default_factory=list)
