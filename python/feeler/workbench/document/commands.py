"""All changes of the document: command names -> functions of the document, the arguments and `Known` facts.

The functions are pure: the same document, arguments and facts give the same document. Before a command, the session
puts facts that only the engine has (pose of the hand, its path, measured values) into `Known`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from feeler.arguments import near
from feeler.errors import WorkbenchError
from feeler.poses import inverse
from feeler.workbench.document import cards, motion
from feeler.workbench.document.arguments import Arguments, Maybe, Shape, replaced, without
from feeler.workbench.document.document import (
    MATERIALS,
    MODES,
    UNITS,
    CameraView,
    Document,
    Isolation,
    Measure,
    Removal,
    SectionBox,
    SectionPlane,
    ToolFacts,
    Trip,
    Viewpoint,
)
from feeler.workbench.document.finding_commands import (
    clash_settings,
    finding_filter,
    finding_group_add,
    finding_group_remove,
    finding_group_rename,
    finding_ignore,
    finding_mark,
    finding_status,
    findings_close,
    findings_open,
    findings_take,
)
from feeler.workbench.document.guide_commands import guide, guide_end
from feeler.workbench.document.joint_commands import (
    joint_grip,
    joint_move,
    joint_step,
    joint_step_go,
    laid_down,
    mechanism_close,
    mechanism_open,
)
from feeler.workbench.document.joints import is_at
from feeler.workbench.document.known import Known, Measured
from feeler.workbench.document.line_cards import way_check, way_keep, way_shorten
from feeler.workbench.document.motion import Row
from feeler.workbench.document.protocol import (
    Camera,
    CardQuestion,
    GivenWay,
    Material,
    MeasureType,
    Mode,
    Pose,
    Selection,
    Unit,
    Vec3,
)
from feeler.workbench.document.protocol_findings import FindingStatus, RequirementResult
from feeler.workbench.document.protocol_task import TaskEditKind
from feeler.workbench.document.requirement_commands import (
    requirement_add,
    requirement_edit,
    requirement_remove,
    requirements_checked,
)
from feeler.workbench.document.task_commands import task_catalogue, task_edit, task_times

LEAST_MOVED_M = 1e-3
"""Parts that a release left nearer than this to where they were gripped add no line to the sequence."""
_GRID_M = 2.0**-10  # of the pose of a hand that holds only parts: subtracting it from a coordinate loses no digit
_MOST_SECTIONS = 6


Change = Callable[[Document, Arguments, Known], Document]


@dataclass(frozen=True)
class Command:
    """A change and its arguments. moves_hand: the document before it has the hand where it is. is_of_cards: undo does
    not revert it, and records leave it out."""

    change: Change
    arguments: Shape = field(default_factory=dict)
    moves_hand: bool = False
    is_of_cards: bool = False


def hide(document: Document, given: Arguments, known: Known) -> Document:
    """Hides parts; they still collide."""
    return replace(document, hidden=_united(document.hidden, _there(given, known)))


def show(document: Document, given: Arguments, known: Known) -> Document:
    """Shows hidden parts again."""
    return replace(document, hidden=_less(document.hidden, given.parts("parts", known.parts)))


def show_all(document: Document, _given: Arguments, _known: Known) -> Document:
    """Shows all parts, and none as a ghost."""
    return replace(document, hidden=(), ghost=(), isolation=None)


def hide_all(document: Document, _given: Arguments, known: Known) -> Document:
    """Hides all parts."""
    return replace(document, hidden=known.there, isolation=None)


def isolate(document: Document, given: Arguments, known: Known) -> Document:
    """Shows these parts alone; the same call again restores what was hidden before."""
    parts = _there(given, known)
    before = document.isolation
    if before is not None and before.parts == parts:
        return replace(document, hidden=before.hidden_before, isolation=None)
    hidden_before = document.hidden if before is None else before.hidden_before
    hidden = _less(known.there, parts)
    return replace(document, hidden=hidden, isolation=Isolation(parts, hidden_before))


def ghost(document: Document, given: Arguments, known: Known) -> Document:
    """Draws parts see-through, or solid again."""
    change = _united if given.flag("is_on") else _less
    return replace(document, ghost=change(document.ghost, _there(given, known)))


def single_out(document: Document, given: Arguments, known: Known) -> Document:
    """Draws these parts solid and all others see-through."""
    parts = _there(given, known)
    return replace(document, hidden=_less(document.hidden, parts), ghost=_less(known.there, parts))


def explode(document: Document, given: Arguments, _known: Known) -> Document:
    """Draws the parts apart by a share, 0 to 1."""
    return replace(document, explode=given.number("share", 0.0, 1.0))


def section_add(document: Document, given: Arguments, _known: Known) -> Document:
    """Adds a section plane; `offset` is its distance from the origin along `normal`, metres."""
    if len(document.sections) >= _MOST_SECTIONS:
        raise WorkbenchError(f"there are {_MOST_SECTIONS} sections already", given.command, "remove one first")
    plane = SectionPlane(document.next_id, given.unit("normal"), given.number("offset"))
    return document.with_id(sections=(*document.sections, plane))


def section_move(document: Document, given: Arguments, _known: Known) -> Document:
    """Moves a section plane."""
    place = given.place_of(document.sections)
    plane = replace(document.sections[place], normal=given.unit("normal"), offset=given.number("offset"))
    return replace(document, sections=replaced(document.sections, place, plane))


def section_switch(document: Document, given: Arguments, _known: Known) -> Document:
    """Switches a section plane on or off."""
    place = given.place_of(document.sections)
    plane = replace(document.sections[place], is_on=given.flag("is_on"))
    return replace(document, sections=replaced(document.sections, place, plane))


def section_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes a section plane."""
    return replace(document, sections=without(document.sections, given.place_of(document.sections)))


def section_box(document: Document, given: Arguments, _known: Known) -> Document:
    """Cuts everything outside a box along the world axes away; replaces the box that was there. Metres."""
    lower, upper = given.point("lower"), given.point("upper")
    if not all(low < high for low, high in zip(lower, upper, strict=True)):
        raise WorkbenchError("a section box has no inside", given.command, "give lower corners below the upper ones")
    return replace(document, section_box=SectionBox(lower, upper))


def section_box_switch(document: Document, given: Arguments, _known: Known) -> Document:
    """Switches the section box on or off."""
    box = _box_of(document, given)
    return replace(document, section_box=replace(box, is_on=given.flag("is_on")))


def section_box_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes the section box."""
    _box_of(document, given)
    return replace(document, section_box=None)


def _box_of(document: Document, given: Arguments) -> SectionBox:
    if document.section_box is None:
        raise WorkbenchError("there is no section box", given.command, "make one first")
    return document.section_box


def set_unit(document: Document, given: Arguments, _known: Known) -> Document:
    """Sets the unit in which lengths are shown."""
    return replace(document, unit=given.choice("unit", UNITS))


def set_material(document: Document, given: Arguments, _known: Known) -> Document:
    """Sets the material that contact sounds like; null: steel."""
    return replace(document, material=given.choice("material", MATERIALS) if given.has("material") else None)


def set_mode(document: Document, given: Arguments, known: Known) -> Document:
    """Sets what contact does to the tool: stop, glide or pass."""
    return replace(document, mode=given.choice("mode", MODES), pose=known.pose)


def place(document: Document, given: Arguments, known: Known) -> Document:
    """Moves the tool to a pose, as far as contact lets it: 16 numbers of world_from_tool, row by row, metres."""
    given.pose("pose")
    return replace(document, pose=known.pose)


def seat(document: Document, given: Arguments, known: Known) -> Document:
    """Puts the tool at a pose at once, without a motion that contact could stop, as into a seat that was found."""
    if document.tool is None or document.gripped:
        raise WorkbenchError("the hand holds no tool alone", given.command, "take a tool, and release parts")
    return replace(document, pose=given.pose("pose"))


def grip(document: Document, given: Arguments, known: Known) -> Document:
    """Grips parts: they leave the scene and move with the hand, together with those that it holds already."""
    parts = tuple(part for part in given.parts("parts", known.parts) if part not in document.gripped)
    if not parts:
        raise WorkbenchError("the hand holds these already", given.command, "release them, or grip others")
    empty = [known.parts[part].path for part in parts if not np.isfinite(known.parts[part].lower[0])]
    if empty:
        raise WorkbenchError(f"{empty[0]} has no triangle that can be queried", given.command, "grip another part")
    gone = [known.parts[part].path for part in parts if part in known.absent]
    if gone:
        raise WorkbenchError(f"{gone[0]} was left out of the scene", given.command, "grip a part that is there")
    places = {part: motion.matrix(document.moved.get(part, motion.HOME)) for part in parts}
    pose = motion.matrix(known.pose)
    if document.tool is None and not document.gripped:
        # The hand is empty, so it may be anywhere: in the middle of the gripped parts.
        boxes = np.array([[known.parts[part].lower, known.parts[part].upper] for part in parts])
        around = np.concatenate(
            [
                motion.corners(box) @ places[part][:3, :3].T + places[part][:3, 3]
                for part, box in zip(parts, boxes, strict=True)
            ]
        )
        middle = (around.min(axis=0) + around.max(axis=0)) / 2
        pose = motion.shifted(np.round(middle / _GRID_M) * _GRID_M)
    back = inverse(pose)
    held = {part: motion.row(back @ place) for part, place in places.items()}
    moved = {part: place for part, place in document.moved.items() if part not in held}
    return replace(
        document,
        pose=motion.row(pose),
        gripped=_sorted({**document.gripped, **held}),
        moved=_sorted(moved),
        out=_less(document.out, parts),
        trip=None,
    )


def joint_take(document: Document, given: Arguments, known: Known) -> Document:
    """Takes the parts of a joint in the hand, on the joint: they move along it alone. The tool is put away."""
    inner = Arguments(given.command, {"parts": list(joint_grip(document, given, known))}, {"parts": Selection})
    gripped = grip(replace(document, tool=None), inner, known)
    return replace(gripped, on_joint=given.text("name"))


def release(document: Document, given: Arguments, known: Known) -> Document:
    """Releases the gripped parts where they are; if they moved, this adds a step to the sequence."""
    if not document.gripped:
        raise WorkbenchError("the hand holds no part", given.command, "grip one first")
    if document.on_joint is not None:
        return replace(laid_down(document, known), pose=known.pose)
    pose = motion.matrix(known.pose)
    placed = {part: motion.row(pose @ motion.matrix(held)) for part, held in document.gripped.items()}
    trip = known.trip or Trip((known.pose,))
    first = motion.matrix(trip.way[0])
    boxes = {part: np.array([known.parts[part].lower, known.parts[part].upper]) for part in placed}
    outside = tuple(
        part for part, at in placed.items() if motion.is_outside(boxes[part], motion.matrix(at), known.bounds)
    )
    starts = {part: first @ motion.matrix(held) for part, held in document.gripped.items()}
    moves = max(
        motion.carried(starts[part], motion.matrix(at), motion.corners(boxes[part])) for part, at in placed.items()
    )
    changed = replace(
        document,
        pose=known.pose,
        gripped=_sorted({}),
        moved=_sorted({**document.moved, **placed}),
        out=_united(document.out, outside),
        trip=None,
        replaying=None,
    )
    if moves <= LEAST_MOVED_M or document.replaying is not None:
        return changed
    names = [known.parts[part].name for part in placed]
    away = {
        part: at for part, at in starts.items() if motion.carried(np.eye(4), at, motion.corners(boxes[part])) > 1e-9
    }
    line = Removal(
        id=document.next_id,
        name=names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more",
        parts=tuple(placed),
        way=trip.way,
        least_clearance=known.least_clearance,
        touched=tuple(known.parts[part].path for part in trip.touched),
        tool=document.tool.name if document.tool else None,
        starts=tuple((part, motion.row(at)) for part, at in away.items()),
        out=outside,
    )
    return changed.with_id(sequence=(*document.sequence, line))


def put_back(document: Document, given: Arguments, known: Known) -> Document:
    """Puts parts back into their places."""
    parts = given.parts("parts", known.parts)
    away = [part for part in parts if _is_away(document, part)]
    if not away:
        raise WorkbenchError("these are where they were loaded", given.command, "name parts that were moved")
    gripped = {part: held for part, held in document.gripped.items() if part not in away}
    homes = _homes(document)
    if document.on_joint is not None:
        away = list(document.gripped)
        gripped = {}
    moved = {part: at for part, at in document.moved.items() if part not in away}
    moved.update({part: homes[part] for part in away if part in homes})
    return replace(
        document,
        pose=known.pose,
        gripped=_sorted(gripped),
        moved=_sorted(moved),
        on_joint=document.on_joint if gripped else None,
        out=_less(document.out, tuple(away)),
        trip=document.trip if gripped == document.gripped else None,
        replaying=document.replaying if gripped else None,
    )


def take_tool(document: Document, given: Arguments, known: Known) -> Document:
    """Takes another tool, or none; where it would collide, it starts beside the mock-up."""
    if document.gripped:
        raise WorkbenchError("the hand holds parts", given.command, "release them first")
    if not given.has("name"):
        return replace(document, tool=None, pose=known.pose)
    name = given.choice("name", known.tools)
    return replace(document, tool=ToolFacts(name, known.tools[name]), pose=known.tool_pose)


def measure_add(document: Document, given: Arguments, known: Known) -> Document:
    """Adds a measure.

    `type`: "point": the distance of two `points`; "edge": the length between two `points`; "angle": of three `points`,
    the corner in the middle, or of the planes of two `triangles` (indices into `mockup.faces`); "parts": the least
    distance of two `parts`. Points are world, metres; angles are kept in radians.
    """
    found = _measured(given, known)
    name = given.text("name") if given.has("name") else f"{found.type} {document.next_id}"
    return document.with_id(measures=(*document.measures, _measure(document.next_id, name, found)))


def measure_edit(document: Document, given: Arguments, known: Known) -> Document:
    """Renames the measure `id`, or measures something else, as `measure_add` does."""
    at = given.place_of(document.measures)
    old = document.measures[at]
    name = given.text("name") if given.has("name") else old.name
    new = replace(old, name=name) if known.measured is None else _measure(old.id, name, known.measured)
    return replace(document, measures=replaced(document.measures, at, new))


def measure_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes a measure."""
    return replace(document, measures=without(document.measures, given.place_of(document.measures)))


def camera_of(given: Arguments) -> CameraView:
    """The argument "camera"."""
    inner = given.inner("camera", Camera)
    return CameraView(
        inner.point("position"),
        inner.point("target"),
        inner.unit("up"),
        inner.number("fov_rad", 0.01, 3),
        inner.has("is_parallel") and inner.flag("is_parallel"),
    )


def viewpoint_add(document: Document, given: Arguments, _known: Known) -> Document:
    """Saves a camera, and the sections as they are.

    `camera`: a dict of `position` and `target`, world, metres, `up`, a direction, `fov_rad`, the whole vertical angle,
    and if wanted `is_parallel`.
    """
    seen = camera_of(given)
    name = given.text("name") if given.has("name") else f"view {document.next_id}"
    viewpoint = Viewpoint(document.next_id, name, seen, document.sections, document.section_box)
    return document.with_id(viewpoints=(*document.viewpoints, viewpoint))


def viewpoint_show(document: Document, given: Arguments, _known: Known) -> Document:
    """Restores the sections that a viewpoint was saved with; the camera belongs to the page."""
    kept = document.viewpoints[given.place_of(document.viewpoints)]
    if kept.sections is None:
        return document
    return replace(document, sections=kept.sections, section_box=kept.section_box)


def viewpoint_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes a saved camera."""
    return replace(document, viewpoints=without(document.viewpoints, given.place_of(document.viewpoints)))


def sequence_rename(document: Document, given: Arguments, _known: Known) -> Document:
    """Renames a step of the sequence."""
    at = given.place_of(document.sequence)
    return replace(
        document, sequence=replaced(document.sequence, at, replace(document.sequence[at], name=given.text("name")))
    )


def sequence_move(document: Document, given: Arguments, _known: Known) -> Document:
    """Moves a step of the sequence to another place in the order."""
    at = given.place_of(document.sequence)
    to = given.whole("index", 0, len(document.sequence) - 1)
    rest = without(document.sequence, at)
    return replace(document, sequence=(*rest[:to], document.sequence[at], *rest[to:]))


def sequence_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes a step of the sequence; its parts stay where they are."""
    return replace(document, sequence=without(document.sequence, given.place_of(document.sequence)))


def sequence_replay(document: Document, given: Arguments, known: Known) -> Document:
    """Replays a step of the sequence: grips its parts where they were and moves them along its path."""
    line = document.sequence[given.place_of(document.sequence)]
    if line.joint is not None:
        raise WorkbenchError("this line moves a joint", given.command, "go to its position")
    if document.gripped:
        raise WorkbenchError("the hand holds parts", given.command, "release them first")
    starts = {part: row for part, row in dict(line.starts).items() if part in line.parts}
    moved = {part: at for part, at in document.moved.items() if part not in line.parts}
    home = replace(document, moved=_sorted({**moved, **starts}), out=_less(document.out, line.parts), tool=None)
    inner = Arguments(given.command, {"parts": list(line.parts)}, {"parts": Selection})
    return replace(grip(home, inner, known), replaying=line.id)


def accept_revision(document: Document, given: Arguments, _known: Known) -> Document:
    """Accepts the present revision of the mock-up: the project's answers are about its parts from now on."""
    facts = document.project
    if facts is None or not (facts.stale or facts.gone or facts.left):
        raise WorkbenchError("no part is stale", given.command, "open a newer revision with a project")
    return replace(document, project=replace(facts, stale=MappingProxyType({}), gone=(), left=()))


MEASURED: Shape = {"points": Maybe(list[Vec3]), "parts": Maybe(Selection), "triangles": Maybe(list[int])}
"""The objects of a measure; each type needs one of them."""

ASKED: Shape = {
    "question": CardQuestion,
    "parts": Maybe(Selection),
    "without": Maybe(Selection),
    "tool": Maybe(str),
    "tools": Maybe(list[str]),
    "catalogue": Maybe(bool),
    "grip": Maybe(str),
    "swing_deg": Maybe(float),
    "clearance": Maybe(float),
    "seconds": Maybe(float),
    "people": Maybe(int),
}
"""A question of a card: which, of what, and how."""

ROWS: Shape = {"version": str, "rows": list[int]}
"""Findings by their rows, in the findings of a version."""

COMMANDS: dict[str, Command] = {
    "hide": Command(hide, {"parts": Selection}),
    "show": Command(show, {"parts": Selection}),
    "show_all": Command(show_all),
    "hide_all": Command(hide_all),
    "isolate": Command(isolate, {"parts": Selection}),
    "ghost": Command(ghost, {"parts": Selection, "is_on": bool}),
    "single_out": Command(single_out, {"parts": Selection}),
    "explode": Command(explode, {"share": float}),
    "section_add": Command(section_add, {"normal": Vec3, "offset": float}),
    "section_move": Command(section_move, {"id": int, "normal": Vec3, "offset": float}),
    "section_switch": Command(section_switch, {"id": int, "is_on": bool}),
    "section_remove": Command(section_remove, {"id": int}),
    "section_box": Command(section_box, {"lower": Vec3, "upper": Vec3}),
    "section_box_switch": Command(section_box_switch, {"is_on": bool}),
    "section_box_remove": Command(section_box_remove),
    "set_unit": Command(set_unit, {"unit": Unit}),
    "set_material": Command(set_material, {"material": Material | None}),
    "set_mode": Command(set_mode, {"mode": Mode}, moves_hand=True),
    "place": Command(place, {"pose": Pose}, moves_hand=True),
    "grip": Command(grip, {"parts": Selection}, moves_hand=True),
    "release": Command(release, moves_hand=True),
    "put_back": Command(put_back, {"parts": Selection}, moves_hand=True),
    "take_tool": Command(take_tool, {"name": str | None}, moves_hand=True),
    "measure_add": Command(measure_add, {"type": MeasureType, **MEASURED, "name": Maybe(str)}),
    "measure_edit": Command(measure_edit, {"id": int, "type": Maybe(MeasureType), **MEASURED, "name": Maybe(str)}),
    "measure_remove": Command(measure_remove, {"id": int}),
    "viewpoint_add": Command(viewpoint_add, {"name": Maybe(str), "camera": Camera}),
    "viewpoint_show": Command(viewpoint_show, {"id": int}),
    "viewpoint_remove": Command(viewpoint_remove, {"id": int}),
    "sequence_rename": Command(sequence_rename, {"id": int, "name": str}),
    "sequence_move": Command(sequence_move, {"id": int, "index": int}),
    "sequence_remove": Command(sequence_remove, {"id": int}),
    "sequence_replay": Command(sequence_replay, {"id": int}, moves_hand=True),
    "findings_open": Command(findings_open, {"findings": Any}),
    "findings_take": Command(findings_take, {"key": str, "saved": Maybe(Any)}),
    "findings_close": Command(findings_close),
    "finding_status": Command(finding_status, {"id": str, "status": FindingStatus}),
    "finding_mark": Command(
        finding_mark, {**ROWS, "status": Maybe(FindingStatus), "note": Maybe(str), "group": Maybe(int)}
    ),
    "finding_filter": Command(finding_filter, {"is_touching_hidden": bool}),
    "finding_group_add": Command(finding_group_add, {**ROWS, "name": str}),
    "finding_group_rename": Command(finding_group_rename, {"id": int, "name": str}),
    "finding_group_remove": Command(finding_group_remove, {"id": int}),
    "finding_ignore": Command(finding_ignore, {"name": str, "a": str, "b": str}),
    "requirement_add": Command(requirement_add, {"name": str, "a": str, "b": str, "gap": float}),
    "requirement_edit": Command(
        requirement_edit,
        {"id": int, "name": Maybe(str), "a": Maybe(str), "b": Maybe(str), "gap": Maybe(float)},
    ),
    "requirement_remove": Command(requirement_remove, {"id": int}),
    "requirements_checked": Command(requirements_checked, {"results": list[RequirementResult]}),
    "clash_settings": Command(
        clash_settings, {"clearance": Maybe(float), "contact": Maybe(float | str), "rules": Maybe(str)}
    ),
    "accept_revision": Command(accept_revision),
    "ask": Command(cards.ask, {**ASKED}, is_of_cards=True),
    "card_again": Command(cards.card_again, {"id": int}, is_of_cards=True),
    "card_cancel": Command(cards.card_cancel, {"id": int}, is_of_cards=True),
    "card_remove": Command(cards.card_remove, {"id": int}, is_of_cards=True),
    "task_edit": Command(
        task_edit,
        {"id": int, "edit": TaskEditKind, "parts": Selection, "seconds": Maybe(float), "later": Maybe(Selection)},
    ),
    "task_times": Command(task_times, {"toml": str, "name": Maybe(str)}),
    "task_catalogue": Command(task_catalogue, {"toml": str, "name": Maybe(str)}),
    "way_take": Command(
        cards.way_take, {"id": Maybe(int), "steps": Maybe(int), "ways": Maybe(list[GivenWay])}, moves_hand=True
    ),
    "way_check": Command(way_check, {"id": int}, is_of_cards=True),
    "way_shorten": Command(way_shorten, {"id": int}, is_of_cards=True),
    "way_keep": Command(
        way_keep, {"id": Maybe(int), "is_added": Maybe(bool), "line": Maybe(int), "ways": Maybe(list[GivenWay])}
    ),
    "guide": Command(guide, {"card": Maybe(int), "step": Maybe(int), "line": Maybe(int)}, is_of_cards=True),
    "guide_end": Command(guide_end, is_of_cards=True),
    "seat": Command(seat, {"pose": Pose}, moves_hand=True),
    "mechanism_open": Command(mechanism_open, {"name": str, "text": str, "is_start": Maybe(bool)}, moves_hand=True),
    "mechanism_close": Command(mechanism_close, moves_hand=True),
    "joint_move": Command(joint_move, {"name": str, "value": float}, moves_hand=True),
    "joint_take": Command(joint_take, {"name": str}, moves_hand=True),
    "joint_step": Command(joint_step),
    "joint_step_go": Command(joint_step_go, {"id": int}, moves_hand=True),
}
STEPS = ("undo", "redo")
"""Commands that choose between documents instead of making one."""


def applied(document: Document, name: str, args: Any, known: Known) -> Document:
    """The document after a command. Raises `WorkbenchError` for an invalid command or arguments."""
    command = COMMANDS.get(name)
    if command is None:
        raise WorkbenchError(f"there is no command {name!r}", "command", near(name, [*COMMANDS, *STEPS]))
    return command.change(document, Arguments(name, args, command.arguments), known)


def _there(given: Arguments, known: Known) -> tuple[int, ...]:
    """The argument "parts", without those that are not in the scene."""
    return tuple(part for part in given.parts("parts", known.parts) if part not in known.absent)


def _homes(document: Document) -> dict[int, Row]:
    """Where the joints have the parts that they moved."""
    state = document.mechanism
    links = () if state is None else state.links
    return {part: link.pose for link in links for part in link.parts if link.pose != motion.HOME}


def _is_away(document: Document, part: int) -> bool:
    if part in document.gripped:
        return True
    place, home = document.moved.get(part), _homes(document).get(part)
    return place is not None and (home is None or not is_at(place, home))


def _united(parts: tuple[int, ...], more: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted({*parts, *more}))


def _less(parts: tuple[int, ...], fewer: tuple[int, ...]) -> tuple[int, ...]:
    gone = set(fewer)
    return tuple(part for part in parts if part not in gone)


def _sorted(places: dict[int, Row]) -> Mapping[int, Row]:
    return MappingProxyType(dict(sorted(places.items())))


def _measured(given: Arguments, known: Known) -> Measured:
    if known.measured is None:
        raise WorkbenchError("nothing was measured", given.command, "send an object to measure")
    return known.measured


def _measure(number: int, name: str, found: Measured) -> Measure:
    return Measure(number, name, found.type, found.points, found.value, found.unit, found.is_exact, found.parts)
