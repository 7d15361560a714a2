"""Questions and jobs by name, with their arguments and functions."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar, cast

import numpy as np

from feeler.errors import OptionError, WorkbenchError
from feeler.mockup import Tool
from feeler.progress import Progress
from feeler.project.layout import SUFFIX
from feeler.project.runs import RunFacts
from feeler.scene import Scene
from feeler.words import plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import (
    CardAnswer,
    FoundParts,
    JointGhost,
    JointPlace,
    Measured,
    Outline,
    PartFacts,
    RayHit,
    RecordTimeline,
    Replayed,
    SequenceFilm,
    Snapped,
    TaskSight,
    ToolGhost,
    Written,
    WrittenPage,
)
from feeler.workbench.document.arguments import Arguments, Maybe, Shape
from feeler.workbench.document.commands import MEASURED, camera_of
from feeler.workbench.document.document import Card, Document, active_planes, plain
from feeler.workbench.document.joints import is_at, loose
from feeler.workbench.document.protocol import Camera, MeasureType, Pose, Selection, Vec3
from feeler.workbench.document.protocol_findings import FindingFormat
from feeler.workbench.engine import measuring
from feeler.workbench.engine.geometry import Geometry, HeldGeometry
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.standing import Standing
from feeler.workbench.files import static_files
from feeler.workbench.session import export, films, page, saving
from feeler.workbench.session.access_answers import tool_in_hand
from feeler.workbench.session.finding_jobs import (
    TakenFindings,
    clash,
    export_findings,
    finding_alike,
    finding_hides,
    finding_side,
    findings_bcf,
    findings_file,
    pair_side,
)
from feeler.workbench.session.report_jobs import report_file
from feeler.workbench.session.requirement_jobs import export_requirements, verified
from feeler.workbench.session.sent_files import SentFiles
from feeler.workbench.session.task_answers import parts_at, tool_at
from feeler.workbench.session.task_sight import gone_before, seen_at

PAGE = "mock-up.html"
MOST_QUERY = 1_000
"""The most characters of a search that count."""
_SNAP_M = 0.005
SPEEDS = (0.05, 20.0)
"""Of a replay, at least and at most."""

Found = TypeVar("Found")


class Recorded(Protocol):
    """A record to replay; `player.Player` has the meanings."""

    def timeline(self) -> RecordTimeline:
        """Commands and gaps over time."""
        ...

    def play(self, progress: Progress, start: float | None = None, speed: float = 1.0) -> dict[str, Any]:
        """Replays it."""
        ...

    def seek(self, progress: Progress, at: float) -> dict[str, Any]:
        """Shows a moment of it."""
        ...


@dataclass(frozen=True)
class Place:
    """The subject of questions and jobs.

    exports: files written by jobs, by name. files: sent by pages. taken: findings of jobs. cards: the answer of a
    card. recorded: the record to replay, if there is one. history, run, renamed: of a project: statuses, the last run
    of `feeler maintain`, and the names of parts now. joint_to: shows a joint at a value. tool: of a card, by its name.
    kept: how the mock-up was read, as a project keeps it.
    """

    document: Document
    scene: Scene
    meshes: PartTools
    sight: measuring.Sight
    geometry: Geometry
    exports: dict[str, bytes]
    files: SentFiles
    taken: TakenFindings
    cards: Callable[[int], CardAnswer]
    recorded: Recorded | None = None
    history: Callable[[], Sequence[Mapping[str, Any]]] = tuple
    run: Callable[[], RunFacts | None] = lambda: None
    joint_to: Callable[[Document, str, float | None], JointPlace] | None = None
    tool: Callable[[Card, str], Tool] | None = None
    renamed: Callable[[], Mapping[str, str]] = dict
    kept: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Question(Generic[Found]):
    """A question, its arguments, and the type of its answer."""

    work: Callable[[Place, Arguments], Found]
    arguments: Shape


@dataclass(frozen=True)
class Work(Generic[Found]):
    """A job, its arguments, and the type of its answer."""

    work: Callable[[Place, Arguments, Progress], Found]
    arguments: Shape = field(default_factory=dict)


def ray(place: Place, given: Arguments) -> RayHit | None:
    """The first visible hit of a ray; None if there is none."""
    picked = place.sight.pick(given.point("origin"), given.unit("direction"))
    return None if picked is None else cast(RayHit, picked.to_json())


def snap(place: Place, given: Arguments) -> Snapped | None:
    """As `ray`, with the snapped point; `within` in metres."""
    within = given.number("within", 0.0, 1e3) if given.has("within") else _SNAP_M
    picked = place.sight.pick(given.point("origin"), given.unit("direction"))
    return None if picked is None else cast(Snapped, measuring.snapped(picked, within, place.sight))


def measure(place: Place, given: Arguments) -> Measured:
    """The value of a measure; arguments as of `measure_add`."""
    found = measuring.measured(given, place.document, place.scene, place.meshes)
    return cast(Measured, plain(found))


def part(place: Place, given: Arguments) -> PartFacts:
    """Facts about a part."""
    (number,) = given.parts("part", place.scene.mockup.parts, most=1)
    return cast(PartFacts, measuring.part_facts(number, place.document, place.scene))


def find(place: Place, given: Arguments) -> FoundParts:
    """The parts that a search finds, by words of paths and by attributes: see `Parts.search`."""
    query = given.text("query")[:MOST_QUERY]
    found = place.scene.mockup.parts.search(query)
    found = found[place.scene.part_mask[found]]
    return {"count": len(found), "parts": _base64(found.astype("<u4"))}


def card(place: Place, given: Arguments) -> CardAnswer:
    """The whole answer of a card. Its ways begin where the parts lay when it was asked, also once they were taken."""
    answer = place.cards(given.whole("id"))
    asked = card_of(place.document, answer["id"])
    if asked is None or asked.line is not None:
        return answer
    places: dict[str, Pose] = {str(part): list(at) for part, at in asked.world[0]}
    return {**answer, "ways": [{**way, "places": places} for way in answer["ways"]]}


def task_tool(place: Place, given: Arguments) -> ToolGhost | None:
    """The tool of a step of a task in its seat; None: the step has none."""
    which, number = given.whole("id"), given.whole("step")
    found = place.cards(which).get("task")
    steps = [] if found is None else found["steps"]
    if number >= len(steps):
        raise given.fail("step", f"there is no step {number}", f"it has {plural(len(steps), 'step')}")
    way, card = steps[number]["tool_way"], card_of(place.document, which)
    if not way or place.tool is None or card is None:
        return None
    geometry = HeldGeometry(tool_at(place.tool(card, steps[number]["tool"]), way[-1]), 0)
    return {"manifest": geometry.manifest(), "data": base64.b64encode(geometry.data()).decode("ascii")}


def reach_tool(place: Place, given: Arguments) -> ToolGhost | None:
    """The tool of a row of access in its seat, with the hand if one fits; None: the row has none of the catalogue."""
    rows, number = place.cards(given.whole("id"))["reaches"], given.whole("row")
    if number >= len(rows):
        raise given.fail("row", f"there is no row {number}", f"it has {plural(len(rows), 'row')}")
    row = rows[number]
    if not row["is_catalogue"] or not row["tool"]:
        return None
    try:
        tool = tool_in_hand(place.document.task_catalogue.toml, row["tool"], row["has_hand"] is True)
    except OptionError:
        raise given.fail("row", "its tool is not in the catalogue any more", "ask again") from None
    geometry = HeldGeometry(tool_at(tool, row["pose"]), 0)
    return {"manifest": geometry.manifest(), "data": base64.b64encode(geometry.data()).decode("ascii")}


def card_of(document: Document, number: int) -> Card | None:
    """A card by its number; None: it is gone."""
    return next((each for each in document.cards if each.id == number), None)


def task_sight(place: Place, given: Arguments) -> TaskSight | None:
    """What is seen of the fastener of a step of a task before it is undone; None: the step has none."""
    number, which = given.whole("id"), given.whole("step")
    answer = place.cards(number)
    steps = answer["task"]["steps"] if "task" in answer else []
    if which >= len(steps):
        raise given.fail("step", f"there is no step {which}", f"it has {plural(len(steps), 'step')}")
    card = card_of(place.document, number)
    if card is None or steps[which]["verb"] not in ("undo", "disconnect"):
        return None
    gone = {*gone_before(steps, answer["ways"], which), *card.without}
    gone |= {*parts_at(place.scene.mockup, card.edits.off)}
    scene = Standing(place.scene).scene(place.document, tuple(gone))
    part = steps[which]["part"]
    return seen_at(scene, part) if scene.part_mask[part] else None


def joint_to(place: Place, given: Arguments) -> JointPlace:
    """Shows a joint at a value to all pages, as far as contact lets it, until the next change; null: as it stands."""
    if place.joint_to is None:
        raise WorkbenchError("there are no joints", given.command, "open a mechanism")
    value = given.number("value") if given.has("value") else None
    return place.joint_to(place.document, given.text("name"), value)


def joint_ghost(place: Place, given: Arguments) -> JointGhost:
    """The parts that a joint moves, at its worst position."""
    document, name = place.document, given.text("name")
    worst = next((each.worst for each in document.joint_ranges if each.name == name), None)
    state = document.mechanism
    if worst is None or state is None:
        raise WorkbenchError(f"the worst position of {name} is not known", given.command, "wait for its range")
    away = loose(state, document.moved, frozenset((*document.out, *document.gripped)))
    items: dict[str, Tool | tuple[Tool, motion.Floats]] = {}
    for link, pose in zip(state.links, worst.poses, strict=True):
        if is_at(link.pose, pose):
            continue
        items.update(
            {str(part): (place.meshes.of(part)[0], motion.matrix(pose)) for part in link.parts if part not in away}
        )
    if not items:
        raise WorkbenchError("it stands at its worst position", given.command, "move it")
    geometry = HeldGeometry(Tool.assembly(items, name), 0)
    return {"manifest": geometry.manifest(), "data": base64.b64encode(geometry.data()).decode("ascii")}


def outline(place: Place, given: Arguments, progress: Progress) -> Outline:
    """The exact outlines of the active sections and of the section box, or of one plane."""
    if given.has("normal"):
        planes = [(given.unit("normal"), given.number("offset"))]
    else:
        planes = active_planes(place.document)
    segments, owners = [np.empty((0, 2, 3))], []
    for number, (normal, offset) in enumerate(planes):
        progress(number / len(planes), "outlines")
        others = [each for at, each in enumerate(planes) if at != number]
        found, parts = measuring.clipped(*place.sight.outline(normal, offset), others)
        segments.append(found)
        owners += parts
    return {
        "count": len(owners),
        "segments": _base64(np.concatenate(segments).astype("<f4")),
        "parts": _base64(np.array(owners, dtype="<u4")),
    }


def page_file(place: Place, given: Arguments, progress: Progress) -> WrittenPage:
    """One HTML file with the mock-up inside, to download; see `page`. `camera`: the initial view."""
    document, geometry = place.document, place.geometry
    camera = cast(Camera, plain(camera_of(given))) if given.has("camera") else None
    rows = b"" if document.findings is None else document.findings.table.frame()
    data, left_out = page.page(
        {**document.to_json(), "project": None, "guiding": None},
        camera,
        geometry.manifest(),
        geometry.piece,
        static_files(),
        progress,
        findings=rows,
    )
    place.exports[PAGE] = data
    return {"name": PAGE, "bytes": len(data), "left_out": left_out}


def project_file(place: Place, given: Arguments, progress: Progress) -> Written:
    """A project of the document, to download. It names the mock-up by its content, and no folder of this machine."""
    progress(0.0, "project")
    named = place.document.mockup.name if place.document.mockup else "mock-up"
    name = (re.sub(r"[^A-Za-z0-9_.-]+", "-", named).strip("-.")[:80] or "mock-up") + SUFFIX
    data = saving.project_of(place.document, place.scene.mockup, place.kept)
    place.exports[name] = data
    return {"name": name, "bytes": len(data)}


def replay(place: Place, given: Arguments, progress: Progress) -> Replayed:
    """Replays the record that the workbench was opened with: exactly; or shows it from some seconds on."""
    start = given.number("start", 0.0) if given.has("start") else None
    speed = given.number("speed", *SPEEDS) if given.has("speed") else 1.0
    return cast(Replayed, _recorded(place, given).play(progress, start, speed))


def replay_to(place: Place, given: Arguments, progress: Progress) -> Replayed:
    """Shows the record at some seconds of its replay."""
    return cast(Replayed, _recorded(place, given).seek(progress, given.number("at", 0.0)))


def record(place: Place, given: Arguments) -> RecordTimeline:
    """The record over time."""
    return _recorded(place, given).timeline()


def _recorded(place: Place, given: Arguments) -> Recorded:
    if place.recorded is None:
        raise WorkbenchError("there is no record", given.command, "start by feeler replay FILE --page")
    return place.recorded


def film(place: Place, given: Arguments, progress: Progress) -> SequenceFilm:
    """The sequence as a film."""
    return {"ways": films.ways(place.document, place.scene, place.meshes, progress)}


def _writing(name: str, write: Callable[..., bytes]) -> Work[Written]:
    def work(place: Place, given: Arguments, progress: Progress) -> Written:
        if not place.document.sequence:
            raise WorkbenchError("the sequence is empty", given.command, "take a part out first")
        data = write(place.document, place.scene.mockup, progress)
        place.exports[name] = data
        return {"name": name, "bytes": len(data)}

    return Work(work)


def _base64(array: Any) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


ASKS: dict[str, Question[Any]] = {
    "ray": Question(ray, {"origin": Vec3, "direction": Vec3}),
    "snap": Question(snap, {"origin": Vec3, "direction": Vec3, "within": Maybe(float)}),
    "measure": Question(measure, {"type": MeasureType, **MEASURED}),
    "part": Question(part, {"part": Selection}),
    "find": Question(find, {"query": str}),
    "card": Question(card, {"id": int}),
    "task_tool": Question(task_tool, {"id": int, "step": int}),
    "reach_tool": Question(reach_tool, {"id": int, "row": int}),
    "task_sight": Question(task_sight, {"id": int, "step": int}),
    "joint_ghost": Question(joint_ghost, {"name": str}),
    "joint_to": Question(joint_to, {"name": str, "value": float | None}),
    "record": Question(record, {}),
    "finding_alike": Question(finding_alike, {"version": str, "row": int}),
    "finding_side": Question(finding_side, {"version": str, "row": int}),
    "pair_side": Question(pair_side, {"parts": Selection, "point": Vec3}),
    "finding_hides": Question(finding_hides, {"a": str, "b": str}),
}
JOBS: dict[str, Work[Any]] = {
    "outline": Work(outline, {"normal": Maybe(Vec3), "offset": Maybe(float)}),
    "export_csv": _writing("sequence.csv", export.sequence_csv),
    "export_html": _writing("sequence.html", export.sequence_html),
    "export_glb": _writing("sequence.glb", export.sequence_glb),
    "export_project": Work(project_file),
    "report": Work(report_file, {"pictures": Maybe(int)}),
    "page": Work(page_file, {"camera": Maybe(Camera)}),
    "replay": Work(replay, {"start": Maybe(float), "speed": Maybe(float)}),
    "replay_to": Work(replay_to, {"at": float}),
    "film": Work(film),
    "clash": Work(clash, {"parts": Maybe(Selection)}),
    "findings_file": Work(findings_file, {"files": int, "name": str}),
    "findings_bcf": Work(findings_bcf, {"files": int, "name": str}),
    "verify": Work(verified),
    "export_requirements": Work(export_requirements),
    "export_findings": Work(export_findings, {"format": FindingFormat}),
}
