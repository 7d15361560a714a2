"""A report as one JSON document, without pictures and poses. `docs/report.md` has its layout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from feeler.workbench.report.values import (
    Check,
    FindingRow,
    Layout,
    Maintenance,
    QuestionRow,
    Report,
    RequirementRow,
    WayRow,
)

VERSION = 1


def report_json(report: Report, written: Mapping[str, str] | None = None) -> dict[str, Any]:
    """The report as plain Python values. written: names of the files that were written, by kind."""
    stale = report.stale
    return {
        "version": VERSION,
        "title": report.title,
        "project": report.project,
        "made": report.made,
        "feeler": report.version,
        "mockup": {
            "files": list(report.sources),
            "content": report.content,
            "parts": report.parts,
            "triangles": report.triangles,
        },
        "tool": report.tool or None,
        "changes": {each.name: _listed(getattr(stale, each.name)) for each in fields(stale)},
        "notes": list(report.notes),
        "check": None if report.check is None else _check(report.check),
        "requirements": [_requirement(row) for row in report.requirements],
        "findings": [_finding(row) for row in report.findings],
        "resolved": [_finding(row) for row in report.resolved],
        "questions": [_question(row) for row in report.questions],
        "steps": [_way(row) for row in report.steps],
        "maintenance": None if report.maintenance is None else _maintenance(report.maintenance),
        **({} if written is None else {"written": dict(written)}),
    }


def _listed(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else list(value)


def _check(check: Check) -> dict[str, Any]:
    kept = _some(check, ("clearance", "contact", "hidden", "is_moved"))
    return {**kept, "of": list(check.of), **_layout(check.layout)}


def _layout(layout: Layout) -> dict[str, Any]:
    some = {each.name: getattr(layout, each.name) for each in fields(layout)}
    return {name: {"count": parts.count, "paths": list(parts.paths)} for name, parts in some.items()}


def _requirement(row: RequirementRow) -> dict[str, Any]:
    kept = ("name", "a", "b", "required", "status", "sentence", "gap", "depth", "pairs", "path_a", "path_b", "point")
    return {**_some(row, kept), "stale": row.stale or None, "is_moved": row.is_moved, **_layout(row.layout)}


def _finding(row: FindingRow) -> dict[str, Any]:
    kept = ("id", "a", "b", "verdict", "severity", "rule", "status", "group", "by", "note", "sentence", "depth", "gap")
    return {
        **_some(row, (*kept, "point")),
        "is_touching": row.is_touching,
        "stale": row.stale or None,
        "history": [asdict(mark) for mark in row.history],
    }


def _question(row: QuestionRow) -> dict[str, Any]:
    return {
        **_some(row, ("id", "kind", "title", "setting", "sentence", "is_good")),
        "stale": row.stale or None,
        "is_moved": row.is_moved,
        "ways": [_way(way) for way in row.ways],
        "blockers": [asdict(each) for each in row.blockers],
        "access": [
            {**asdict(each), "tools": list(each.tools), "blockers": list(each.blockers)} for each in row.reaches
        ],
        "task": [{**asdict(step), "edited": step.edited or None} for step in row.task],
        "notes": list(row.notes),
        "facts": [{"name": name, "figure": figure} for name, figure in row.facts],
    }


def _maintenance(run: Maintenance) -> dict[str, Any]:
    rows = [{**asdict(row), "paths": list(row.paths), "tools": list(row.tools)} for row in run.rows]
    return {**_some(run, ("at", "sentence", "is_partial")), "stale": run.stale or None, "rows": rows}


def _way(row: WayRow) -> dict[str, Any]:
    return {
        "name": row.title,
        "parts": list(row.paths),
        "length": row.length,
        "rotation": row.rotation,
        "clearance": row.clearance,
        "legs": list(row.legs),
        "gaps": [{"share": share, "gap": gap} for share, gap in row.gaps],
        "touched": list(row.touched),
        "tool": row.tool or None,
        "checked": row.checked or None,
        "joint": row.joint or None,
        "stale": row.stale or None,
    }


def _some(row: object, names: Sequence[str]) -> dict[str, Any]:
    return {name: getattr(row, name) for name in names}
