"""The findings of a clash check in messages: a part of `protocol.py`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, TypedDict

import numpy as np
import numpy.typing as npt

from feeler.workbench.document.frames import Array
from feeler.workbench.document.protocol_values import StalePart

F4 = npt.NDArray[np.float32]
U4 = npt.NDArray[np.uint32]
U1 = npt.NDArray[np.uint8]

FindingStatus = Literal["new", "active", "reviewed", "approved", "resolved"]
FindingFormat = Literal["json", "csv", "xlsx", "html", "bcf", "rules"]


class OwnGroup(TypedDict):
    """A group of findings that somebody made."""

    id: int
    name: str


class Check(TypedDict):
    """A clash check that was run here."""

    clearance: float
    """Metres."""
    contact: float | None
    """Metres; null: the chordal errors of both parts."""
    of: list[int] | None
    """The parts whose pairs were checked; null: all."""
    moved: dict[str, list[float]]
    """Where parts lay, as `moved`, `out` and `gripped` of the document: the findings are stale if that changed."""
    out: list[int]
    gripped: list[int]


class Findings(TypedDict):
    """The findings of a clash check, without their rows, which are `GET /findings/VERSION`: see `FindingRows`."""

    version: str
    count: int
    counts: dict[str, int]
    """Number of findings by verdict."""
    hidden: dict[str, int]
    """Number of findings that each exclusion of the rules hides, by its name."""
    status: dict[str, FindingStatus]
    """By the finding's id, where it is not that of its row."""
    notes: dict[str, str]
    """The same."""
    own_groups: list[OwnGroup]
    members: dict[str, int]
    """The own group of a finding, by the finding's id."""
    is_touching_hidden: bool
    check: Check | None
    """Null: the findings are of a file."""
    stale: dict[str, StalePart]
    """By part id: parts that differ since, in another revision, also those without findings."""


class ClashSettings(TypedDict):
    """How the next clash check is made."""

    clearance: float
    """Metres."""
    contact: float | None
    """Metres; null: the chordal errors of both parts."""
    rules: str
    """TOML, as for `feeler clash --rules`."""


class RequirementVerdict(TypedDict):
    """What a requirement was when it was checked last. Metres."""

    status: Literal["holds", "violated", "unknown"]
    pairs: int
    """Pairs of parts that violate it; the others are of the worst of them."""
    gap: float | None
    depth: float | None
    parts: list[int]
    points: list[tuple[float, float, float]]
    trouble: str | None
    """Why it is not known."""
    moved: dict[str, list[float]]
    """Where parts lay, as in `Check`."""
    out: list[int]
    gripped: list[int]
    stale: dict[str, StalePart]
    """By part id: parts that it is about and that differ since, in another revision."""


class RequirementResult(TypedDict):
    """The verdict of a requirement, by its id."""

    id: int
    verdict: RequirementVerdict


class KeptClear(TypedDict):
    """A clearance that must hold: parts of pattern `a` stay at least `gap` metres away from those of `b`."""

    id: int
    name: str
    a: str
    b: str
    gap: float
    verdict: RequirementVerdict | None
    """Null: it was not checked as it is."""


class Taken(TypedDict):
    """Findings that the command "findings_take" opens."""

    key: str
    count: int
    gone: int
    """Findings of before that were not found again."""
    notes: list[str]
    """What the check did not do, for people."""


class Alike(TypedDict):
    """Patterns of paths for pairs like that of a finding, and how many findings they hide."""

    a: str
    b: str
    count: int


class FindingSide(TypedDict):
    """From where a finding is seen."""

    direction: tuple[float, float, float]
    """From the contact to the eye, unit."""
    cover: int | None
    """The part around the other one: to be drawn see-through."""


class Hides(TypedDict):
    """How many findings an exclusion would hide."""

    count: int
    trouble: str | None
    """What is wrong with the patterns."""


@dataclass(frozen=True, eq=False)
class FindingRows:
    """The rows of the findings, `GET /findings/VERSION`; it is never sent by the socket. The worst come first."""

    KIND: ClassVar[str] = "findings"
    version: str
    words: Annotated[U1, Array("u1", ("bytes",))]
    """JSON: `FindingWords`."""
    part_of_path: Annotated[U4, Array("u4", ("paths",))]
    """The part of each of the words' paths; 4294967295: none in this mock-up."""
    pairs: Annotated[U4, Array("u4", ("rows", 2))]
    """Indices into the paths."""
    labels: Annotated[U4, Array("u4", ("rows", 3))]
    """Indices into verdicts, rules and groups."""
    codes: Annotated[U1, Array("u1", ("rows", 4))]
    """Severity (critical, major, minor), status, kind of depth (none, measured, estimate, bound, exact), touches."""
    sizes: Annotated[F4, Array("f4", ("rows", 4))]
    """Depth, its error, gap, shared volume: metres, NaN where not known."""
    places: Annotated[F4, Array("f4", ("rows", 9))]
    """Point of the first part, of the second, translation of the first out of the second; NaN where not known."""


class FindingWords(TypedDict):
    """The texts of findings."""

    ids: list[str]
    paths: list[str]
    verdicts: list[str]
    rules: list[str]
    groups: list[str]
    notes: dict[str, str]
    """By id."""
