"""What a project gives to scripts, as plain values: the types of their keys."""

from __future__ import annotations

from typing import Any, TypedDict

from feeler.choices import DepthKind, Severity, Status, VerdictName, ViewMode, ViewUnit


class Approval(TypedDict, total=False):
    """What an approval was given for. Without one, none of it is there."""

    approved_depth: float
    """Metres."""
    approved_error: float
    """Of that depth, metres."""
    approved_verdict: VerdictName


class FindingChange(Approval):
    """A change of a finding's status or note: a row of `Project.history`."""

    id: str
    """Of the finding."""
    at: str
    """UTC, `2026-01-31T12:00:00Z`."""
    status: Status
    by: str
    note: str


class _Said(Approval, total=False):
    by: str
    note: str
    changed: str
    """`renamed` or `renumbered` if the last comparison found one of its parts under another path or number."""
    group: str
    """Its group in the workbench."""


class FindingRow(_Said):
    """A finding as `feeler clash --json` lists it: a row of `Project.findings`. Metres; None for NaN.

    `by`, `note`, `changed`, `group` and the fields of an approval exist only if they are known. Findings that the
    workbench opened from a file have the keys of that file.
    """

    id: str
    rule: str
    a: str
    """The path of a part; `#2` for the second part of a path."""
    b: str
    verdict: VerdictName
    severity: Severity
    status: Status
    depth: float | None
    depth_error: float | None
    depth_kind: DepthKind
    translation: list[float | None]
    gap: float | None
    point_a: list[float | None]
    point_b: list[float | None]
    volume: float | None
    triangles: int
    box: list[list[float | None]]
    open: list[bool]
    """Whether `a`, and `b`, has no closed surface."""


class ProjectDocument(TypedDict, total=False):
    """What the workbench shows, by field: the answer of `Project.document`.

    A project that the workbench never opened has empty lists, and `clash` after a check of the command line. Parts are
    numbers, as keys of objects in text.
    """

    cards: list[dict[str, Any]]
    """Questions with their answers."""
    clash: dict[str, Any]
    """The settings of the clash check."""
    doubts: list[str]
    explode: float
    """0 to 1."""
    findings: dict[str, Any] | None
    """All about findings but their rows: see `Project.findings`."""
    ghost: list[int]
    """Transparent parts."""
    gripped: dict[str, list[float]]
    """By part in hand, as in `moved`."""
    held_version: int
    hidden: list[int]
    isolation: dict[str, Any] | None
    material: str | None
    measures: list[dict[str, Any]]
    mechanism: dict[str, Any] | None
    mode: ViewMode
    moved: dict[str, list[float]]
    """By part: 16 numbers, `world_from_part`, row by row."""
    next_card: int
    next_id: int
    on_joint: str | None
    out: list[int]
    """Parts taken out of the mock-up."""
    pose: list[float]
    """16 numbers: `world_from_tool`, row by row."""
    replaying: int | None
    requirements: list[dict[str, Any]]
    section_box: dict[str, Any] | None
    sections: list[dict[str, Any]]
    sequence: list[dict[str, Any]]
    """Its lines: parts that were moved, each with its way."""
    task_catalogue: dict[str, Any]
    task_edits: dict[str, Any]
    task_times: dict[str, Any]
    tool: dict[str, Any] | None
    trip: dict[str, Any] | None
    unit: ViewUnit
    viewpoints: list[dict[str, Any]]
