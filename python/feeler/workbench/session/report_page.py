"""The page with the mock-up that goes with a report: it plays the ways of cards and of the sequence offline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import NOTHING, Document, Removal
from feeler.workbench.engine.geometry import Geometry
from feeler.workbench.files import static_files
from feeler.workbench.report.source import Source
from feeler.workbench.report.values import Report
from feeler.workbench.session import page


def mockup_page(source: Source, report: Report, progress: Progress) -> bytes:
    """The page, as "One HTML file to send", with the ways of questions as lines of its sequence."""
    mockup = source.mockup
    assert mockup is not None, "there is nothing to show"
    document = with_ways(source.document, report)
    scene = Scene(mockup)
    if document.absent:
        scene = scene.without(list(document.absent))
    about = document.mockup
    geometry = Geometry(scene, about.hash if about else "", about.name if about else "mock-up")
    rows = b"" if document.findings is None else document.findings.table.frame()
    fields = {**document.to_json(), "project": None, "cards": []}
    data, _ = page.page(
        fields,  # type: ignore[arg-type]
        None,
        geometry.manifest(),
        geometry.piece,
        static_files(),
        progress,
        findings=rows,
    )
    return data


def with_ways(document: Document, report: Report) -> Document:
    """The document with the ways of questions after its own sequence, as far as each part moves once."""
    lines = list(document.sequence)
    taken = {part for line in lines for part in line.parts}
    number = document.next_id
    for question in report.questions:
        ways = [way for way in question.ways if len(way.poses) > 1]
        if not ways or any(part in taken for way in ways for part in way.parts):
            continue
        for way in ways:
            lines.append(
                _line(number, f"{way.title}: {question.title}", way.parts, way.poses, way.starts, way.clearance)
            )
            taken |= set(way.parts)
            number += 1
    return replace(document, sequence=tuple(lines), gripped=NOTHING, trip=None, replaying=None, next_id=number)


def _line(
    number: int,
    name: str,
    parts: tuple[int, ...],
    poses: Sequence[motion.Row],
    starts: Mapping[int, motion.Row],
    clearance: float | None,
) -> Removal:
    return Removal(number, name, parts, tuple(poses), clearance, (), None, tuple(sorted(starts.items())))
