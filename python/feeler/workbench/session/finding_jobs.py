"""Questions and jobs of findings: the clash check, files of findings in and out, "ignore like this".

A check runs in the jobs' thread with one thread less than the machine has, so that the hand does not feel it. Its
findings are kept by a key until the command "findings_take" opens them, so that they are one step of undo.
"""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from feeler import clashes as room
from feeler.clashes import Clashes, Rules
from feeler.clashes.advice import advice
from feeler.clashes.as_bcf import left_out
from feeler.clashes.bcf_in import topics_in
from feeler.clashes.limits import unmatched
from feeler.clashes.rules import tolerant
from feeler.clashes.saving import rows as rows_of
from feeler.clashes.tracking import NEW, Mark, part_keys
from feeler.errors import OptionError, WorkbenchError
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.words import plural
from feeler.workbench.document import finding_rules, findings
from feeler.workbench.document.answers import WrittenFindings
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Check, Document, Findings
from feeler.workbench.document.finding_table import STATUS, FindingTable
from feeler.workbench.document.frames import dumps
from feeler.workbench.document.protocol_findings import Alike, FindingSide, Hides, Taken
from feeler.workbench.engine.parts import PartTools, with_places
from feeler.workbench.session.finding_view import side_of, side_of_pair
from feeler.workbench.session.sent_files import SentFiles

_MOST_TAKEN = 8
_FORMATS = ("json", "csv", "xlsx", "html", "bcf", "rules")
_NAMES = {"rules": "clash-rules.toml", "bcf": "clashes.bcf"}
_READ = 0.5  # share of the progress of a job that reads a file
_CHECKED = 0.98  # and of one that checks
_Writer = Callable[[Findings, Mockup, Progress], tuple[bytes, str]]
"""Gives the bytes of a file, and how it falls short; empty if it does not."""


class FindingPlace(Protocol):
    """What these questions and jobs need of `asking.Place`."""

    @property
    def document(self) -> Document:
        """As it is at the start."""

    @property
    def scene(self) -> Scene:
        """The mock-up as it was loaded."""

    @property
    def meshes(self) -> PartTools:
        """Its parts."""

    @property
    def exports(self) -> dict[str, bytes]:
        """Files written by jobs, by name."""

    @property
    def files(self) -> SentFiles:
        """Files that pages sent."""

    @property
    def taken(self) -> TakenFindings:
        """Findings for `findings_take`."""


class TakenFindings:
    """Findings of jobs, each with those that the document had when the job began."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[Findings, Findings | None]] = {}

    def keep(self, found: Findings, since: Findings | None) -> str:
        """Keeps findings, the last few; the result is their key."""
        key = found.table.key
        self._kept.pop(key, None)
        self._kept[key] = (found, since)
        while len(self._kept) > _MOST_TAKEN:
            del self._kept[next(iter(self._kept))]
        return key

    def of(self, key: object, now: Document) -> Findings | None:
        """The findings of a key, with what people did since the job began; None if there are none."""
        kept = self._kept.get(key) if isinstance(key, str) else None
        return None if kept is None else findings.carried(kept[0], now.findings, kept[1])


def clash(place: FindingPlace, given: Arguments, progress: Progress) -> Taken:
    """Checks the scene as it is now: parts taken out and parts in the hand do not count, hidden ones do.

    `parts`: only pairs with one of these. Clearance, contact and rules are those of the document's `clash`.
    """
    document, settings = place.document, place.document.clash
    mockup, scene = placed(place, progress)
    chosen = given.parts("parts", mockup.parts) if given.has("parts") else None
    rules = Rules.parse(settings.rules)
    notes = [f"{what} names no part" for what in unmatched(rules, mockup.parts, mockup.part_paths)]
    found = room.clash(
        mockup,
        settings.clearance,
        "chord" if settings.contact is None else settings.contact,
        tolerant(rules),
        scene=scene,
        threads=threads(),
        progress=lambda share, stage: progress(_CHECKED * share, stage),
        parts=None if chosen is None else list(chosen),
    )
    resolved, aside = _tracked(found, document.findings, mockup)
    made = findings.findings_of_clashes(found, mockup, document.absent)
    check = Check(settings.clearance, settings.contact, chosen, document.moved, document.out, tuple(document.gripped))
    made = replace(made, check=check, aside=aside, resolved=resolved)
    progress(1.0, "done")
    return _taken(place, made, len(resolved), [*notes, *advice(found)])


def findings_file(place: FindingPlace, given: Arguments, progress: Progress) -> Taken:
    """Opens a file that a page sent: findings of `feeler clash --json` or --save."""
    progress(0.0, "reading")
    data = findings.parsed_findings(place.files.read(given.whole("files")), given.text("name"))
    progress(_READ, "reading")
    found = findings.findings_of(data, place.scene.mockup.parts, place.document.absent)
    doubt = findings.doubt_of(found, place.scene.mockup.parts)
    progress(1.0, "done")
    return _taken(place, found, 0, [doubt] if doubt else [])


def findings_bcf(place: FindingPlace, given: Arguments, progress: Progress) -> Taken:
    """Takes statuses and comments of a BCF file that a page sent: `count` findings have changed."""
    found = place.document.findings
    if found is None:
        raise WorkbenchError("there are no findings", given.command, "check clashes first: BCF has no geometry")
    progress(0.0, "reading")
    name = given.text("name")
    topics = topics_in(io.BytesIO(place.files.read(given.whole("files"))), name)
    progress(_READ, "reading")
    clashes = found.table.clashes(place.scene.mockup, found.mark_of)
    changes = room.apply_bcf(clashes, topics)
    names = [found.table.ids[row] for row in found.table.placed.tolist()]
    own = dict(zip(clashes.ids, names, strict=True))
    status = {own[each]: clashes.marks.of(each).status for each in changes.statuses}
    notes = {own[each]: clashes.marks.of(each).note for each in changes.notes}
    authors = {own[each]: clashes.marks.of(each).by for each in (*changes.statuses, *changes.notes)}
    made = replace(
        found,
        status=findings.changed(found.status, status, found.table.status_of),
        notes=findings.changed(found.notes, notes, found.table.note_of),
    )
    made = findings.signed(made, authors)
    unknown = len(changes.unknown)
    said = [f"{unknown} of {len(topics)} topics are of no finding here"] if unknown else []
    if changes.outgrown:
        said.append(f"{plural(len(changes.outgrown), 'finding')} approved there not taken over: deeper now")
    progress(1.0, "done")
    key = place.taken.keep(made, found)
    return {"key": key, "count": len({*status, *notes}), "gone": 0, "notes": said}


def export_findings(place: FindingPlace, given: Arguments, progress: Progress) -> WrittenFindings:
    """Writes the findings with their statuses and notes, or the rules."""
    kind = given.choice("format", _FORMATS)
    name = _NAMES.get(kind, f"findings.{kind}")
    notes: list[str] = []
    progress(0.0, "writing")
    if kind == "rules":
        data = place.document.clash.rules.encode()
        if not data:
            raise WorkbenchError("there are no rules", given.command, "write some, or ignore a finding")
    else:
        found = place.document.findings
        if found is None:
            raise WorkbenchError("there are no findings", given.command, "check clashes first")
        data, short = _WRITERS[kind](found, _mockup_of(place, found), progress)
        notes = [f"{name} {short}"] if short else []
    place.exports[name] = data
    return {"name": name, "bytes": len(data), "notes": notes}


def finding_alike(place: FindingPlace, given: Arguments) -> Alike:
    """Patterns for the parts of a finding and their numbered siblings, and how many findings they hide."""
    found, row = _row(place, given)
    table = found.table
    a, b = (finding_rules.alike(table.paths[each[row]]) for each in (table.a, table.b))
    count = int(finding_rules.mask_of(table, place.scene.mockup.parts, a, b).sum())
    return {"a": a, "b": b, "count": count}


def finding_side(place: FindingPlace, given: Arguments) -> FindingSide | None:
    """From where a finding is seen; null if none of its parts is here."""
    found, row = _row(place, given)
    return side_of(found.table, row, place.scene, place.meshes, place.document.moved)


def pair_side(place: FindingPlace, given: Arguments) -> FindingSide:
    """From where two parts are seen at a point between them."""
    parts = given.parts("parts", place.scene.mockup.parts, most=2)
    point = np.array(given.point("point"))
    return side_of_pair(list(parts), point, 0.0, np.zeros(3), place.scene, place.meshes, place.document.moved)


def finding_hides(place: FindingPlace, given: Arguments) -> Hides:
    """How many findings an exclusion with two patterns would hide."""
    found = place.document.findings
    if found is None:
        return {"count": 0, "trouble": None}
    a, b = given.text("a"), given.text("b")
    try:
        return {
            "count": int(finding_rules.mask_of(found.table, place.scene.mockup.parts, a, b).sum()),
            "trouble": None,
        }
    except OptionError as error:
        what = str(error).partition(", a: ")[2] or str(error).partition(", b: ")[2]
        return {"count": 0, "trouble": what.partition(" (optional")[0]}


def threads() -> int:
    """How many threads a job may have: one less than there are."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, count - 1)


def placed(place: FindingPlace, progress: Progress) -> tuple[Mockup, Scene]:
    """The mock-up with its parts where they lie now, and the scene without those that are out or in the hand."""
    document, mockup, scene = place.document, place.scene.mockup, place.scene
    gone = {*document.out, *document.gripped}
    moved = {part: at for part, at in document.moved.items() if part not in gone}
    if moved:
        progress(0.0, "placing parts")
        mockup = with_places(mockup, moved, place.meshes)
        scene = Scene(mockup, threads=threads()).without(list(document.absent))
    return mockup, scene.without(sorted(gone)) if gone else scene


def _tracked(
    found: Clashes, before: Findings | None, mockup: Mockup
) -> tuple[tuple[Mapping[str, Any], ...], Mapping[str, Mark]]:
    """Takes over statuses and notes by id; the findings that are gone, and marks of those not looked at."""
    if before is None:
        return (), MappingProxyType({})
    keys = part_keys(mockup.part_paths)
    then = before.table.named_clashes(keys, before.mark_of)
    marks = {**{name: then.marks.of(name) for name in then.ids}, **before.aside}
    if {*keys}.isdisjoint(then.keys):  # of another mock-up
        then = then[:0]
    then.marks.aside = {name: replace(mark, pair=None) for name, mark in before.aside.items()}
    resolved: tuple[Mapping[str, Any], ...] = ()
    if len(then) or before.aside:
        found.diff(then)
        resolved = tuple(rows_of(found.earlier().where(status="resolved")))
    here = {*found.ids, *(row["id"] for row in resolved)}
    kept = {name: mark for name, mark in marks.items() if name not in here and (mark != NEW or name in before.members)}
    return resolved, MappingProxyType({name: findings.paired(before.table, name, mark) for name, mark in kept.items()})


def _taken(place: FindingPlace, found: Findings, gone: int, notes: list[str]) -> Taken:
    key = place.taken.keep(found, place.document.findings)
    return {"key": key, "count": len(found.table), "gone": gone, "notes": notes}


def _row(place: FindingPlace, given: Arguments) -> tuple[Findings, int]:
    found = place.document.findings
    if found is None or given.text("version") != found.table.key:
        raise WorkbenchError("the findings are others now", given.command, "choose one again")
    return found, given.whole("row", 0, len(found.table) - 1)


def _mockup_of(place: FindingPlace, found: Findings) -> Mockup:
    """The mock-up as it was checked: pictures show parts where they lay."""
    check = found.check
    if check is None:
        return place.scene.mockup
    gone = {*check.out, *check.gripped}
    moved = {part: at for part, at in check.moved.items() if part not in gone}
    return with_places(place.scene.mockup, moved, place.meshes) if moved else place.scene.mockup


def _as_json(found: Findings, mockup: Mockup, _progress: Progress) -> tuple[bytes, str]:
    """As `feeler clash --json` writes them, where all are of this mock-up; else as they were read."""
    clashes = found.table.clashes(mockup, found.mark_of)
    if len(clashes) == len(found.table) and set(clashes.ids) == set(found.table.ids):
        return dumps(room.report(clashes)).encode(), ""
    return dumps(marked(found.table, found).to_json()).encode(), ""


def marked(table: FindingTable, found: Findings) -> FindingTable:
    """The table with the statuses and notes that people set, and who they are."""
    status = table.status.copy()
    for name, word in found.status.items():
        status[table.row_of[name]] = STATUS.index(word)
    marks = dict(table.marks)
    for name in {**found.status, **found.notes, **found.authors}:
        mark = found.mark_of(name)
        marks[name] = replace(marks.get(name, NEW), note=mark.note, by=mark.by)
    return replace(table, status=status, marks=MappingProxyType(marks))


def _written(suffix: str, write: Callable[[Path, Clashes, Mockup, Progress], object]) -> _Writer:
    """A writer of files as a function that gives bytes, and what people should know, if it says so."""

    def made(found: Findings, mockup: Mockup, progress: Progress) -> tuple[bytes, str]:
        clashes = found.table.clashes(mockup, found.mark_of)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"findings{suffix}"
            said = write(path, clashes, mockup, progress)
            return path.read_bytes(), said if isinstance(said, str) else ""

    return made


def _bcf(path: Path, found: Clashes, mockup: Mockup, progress: Progress) -> str:
    """Writes BCF; says what is left out."""
    return left_out(found, "part", room.write_bcf(path, found, mockup, progress=progress))


_WRITERS: dict[str, _Writer] = {
    "json": _as_json,
    "csv": _written(".csv", lambda path, found, _mockup, _said: room.write_csv(path, found)),
    "xlsx": _written(".xlsx", lambda path, found, mockup, said: room.write_xlsx(path, found, mockup, progress=said)),
    "html": _written(".html", lambda path, found, mockup, said: room.write_html(path, found, mockup, progress=said)),
    "bcf": _written(".bcf", _bcf),
}
