"""Commands of mechanisms: opens one, moves its joints, and keeps positions as lines of the sequence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from feeler.errors import WorkbenchError
from feeler.poses import inverse
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Document, Removal
from feeler.workbench.document.joints import MechanismState, figure, laid, loose
from feeler.workbench.document.known import Known
from feeler.workbench.document.motion import HOME, Row

JOINTS = ("mechanism_open", "joint_move", "joint_step", "joint_step_go")
"""Commands that need what is known of joints."""
MOST_TEXT = 100_000
"""Characters of a mechanism."""
SMALLEST = 1e-9
"""Numbers that differ by less are the same."""


def mechanism_open(document: Document, given: Arguments, known: Known) -> Document:
    """Opens a mechanism: the text of a TOML file, and its name. Links of the one before go back to where they are
    modelled. `is_start`: it was there from the start, and is no step of undo."""
    given.text("name")
    is_at_start(given)
    if document.gripped:
        raise WorkbenchError("the hand holds parts", given.command, "release them first")
    back = _closed(document)
    return _placed(replace(back, mechanism=_found(known, given)), known, given)


def is_at_start(given: Arguments) -> bool:
    """Whether a mechanism is opened that was there from the start."""
    return given.has("is_start") and given.flag("is_start")


def mechanism_close(document: Document, given: Arguments, _known: Known) -> Document:
    """Closes the mechanism: its links go back to where they are modelled. Lines of the sequence stay."""
    _state(document, given)
    if document.gripped:
        raise WorkbenchError("the hand holds parts", given.command, "release them first")
    return _closed(document)


def joint_move(document: Document, given: Arguments, known: Known) -> Document:
    """Moves a joint to a value, radians or metres, as far as contact lets it; joints that follow it follow."""
    given.number("value")
    _named(document, given)
    return _placed(document, known, given, given.text("name"))


def joint_step(document: Document, given: Arguments, known: Known) -> Document:
    """Keeps the position as lines of the sequence: one for each joint that stands elsewhere than after the lines
    before. In the order in which they were moved."""
    state = _state(document, given)
    for step, bodies in known.joint_steps:
        number = state.number(step.name)
        kind = "turn" if number is None else number.kind
        for count, (parts, poses, starts) in enumerate(bodies):
            name = f"Move {step.name} to {figure(kind, step.end, document.unit)}"
            line = Removal(
                id=document.next_id,
                name=name if count == 0 else f"{name}, {known.parts[parts[0]].name}",
                parts=parts,
                way=poses,
                least_clearance=None,
                touched=(),
                tool=None,
                starts=starts,
                joint=step,
            )
            document = document.with_id(sequence=(*document.sequence, line))
    if not known.joint_steps:
        raise WorkbenchError("the joints stand where the sequence has them", given.command, "move one first")
    return document


def joint_step_go(document: Document, given: Arguments, known: Known) -> Document:
    """Puts the joints where a line of the sequence leaves them, without a motion that contact could stop."""
    line = document.sequence[given.place_of(document.sequence)]
    if line.joint is None:
        raise WorkbenchError("this line moves no joint", given.command, "replay it")
    return _placed(document, known, given, line.joint.name)


def joint_grip(document: Document, given: Arguments, _known: Known) -> tuple[int, ...]:
    """The parts that go with a joint: those of its link, and of all that hang on it and do not move on their own."""
    state = _state(document, given)
    _named(document, given)
    if document.gripped:
        raise WorkbenchError("the hand holds parts", given.command, "release them first")
    number = state.number(given.choice("name", [each.name for each in state.numbers]))
    assert number is not None, "a name was chosen"
    others = state.others(number)
    if others & {number.link, *state.above(number.link)}:
        what = f"what {number.name} moves is carried by joints that move with it"
        raise WorkbenchError(what, given.command, "take one of these, or use its slider")
    away = loose(state, document.moved, frozenset(document.out))
    parts = [part for part in state.with_number(number) if part not in away]
    if not parts:
        raise WorkbenchError("all its parts are out", given.command, "put one back")
    return tuple(sorted(parts))


def laid_down(document: Document, known: Known) -> Document:
    """The document after the hand has let go of what it held on a joint."""
    state, at = document.mechanism, known.joints
    if state is None or at is None or len(at[1]) != len(state.links):
        raise WorkbenchError("the position is not known", "release", "put the parts back")
    held = laid(state, document.moved, document.gripped)
    down = replace(document, moved=held, gripped=MappingProxyType({}), trip=None, replaying=None, on_joint=None)
    return _at(down, known, document.on_joint)


def steps_before(document: Document) -> Mapping[str, float]:
    """The numbers after the last line of the sequence that moves a joint."""
    found: dict[str, float] = {}
    for line in document.sequence:
        if line.joint is not None:
            found = {**line.joint.start, line.joint.name: line.joint.end}
    return found


def ways_of(
    document: Document, poses: Sequence[Sequence[Row]], boxes: Mapping[int, motion.Floats]
) -> list[tuple[tuple[int, ...], tuple[Row, ...], tuple[tuple[int, Row], ...]]]:
    """What moves alike at some positions, each with its way and its starts, as a line of the sequence has them.

    poses: of the links at each position.
    """
    state = document.mechanism
    assert state is not None
    away = loose(state, document.moved, frozenset((*document.out, *document.gripped)))
    groups: list[tuple[list[motion.Floats], list[int], dict[int, Row]]] = []
    for place, link in enumerate(state.links):
        parts = [part for part in link.parts if part not in away]
        way = [motion.matrix(each[place]) for each in poses]
        moves = [pose @ inverse(way[0]) for pose in way]
        if not parts or all(np.abs(move - np.eye(4)).max() <= SMALLEST for move in moves):
            continue
        same = next(
            (each for each in groups if all(np.abs(a - b).max() <= 1e-9 for a, b in zip(each[0], moves, strict=True))),
            None,
        )
        if same is None:
            same = (moves, [], {})
            groups.append(same)
        same[1].extend(parts)
        same[2].update({part: poses[0][place] for part in parts})
    found = []
    for moves, parts, starts in groups:
        corners = np.concatenate([motion.corners(boxes[part]) for part in parts])
        hand = motion.shifted(np.asarray(np.round(corners.mean(axis=0) * 1024.0) / 1024.0))
        rows = tuple(motion.row(move @ hand) for move in moves)
        begin = tuple((part, start) for part, start in sorted(starts.items()) if start != HOME)
        found.append((tuple(sorted(parts)), rows, begin))
    return found


def with_links(document: Document, state: MechanismState) -> Document:
    """The document with the links of its mechanism elsewhere, and their parts with them, except loose ones."""
    before = document.mechanism
    moved = dict(document.moved)
    if before is not None:
        away = loose(before, document.moved, frozenset((*document.out, *document.gripped)))
        for old, new in zip(before.links, state.links, strict=True):
            _carry(moved, (part for part in old.parts if part not in away), new.pose)
    return replace(document, mechanism=state, moved=MappingProxyType(dict(sorted(moved.items()))))


def _placed(document: Document, known: Known, given: Arguments, name: str | None = None) -> Document:
    state = _state(document, given)
    if known.joints is None or len(known.joints[1]) != len(state.links):
        raise WorkbenchError("the position is not known", given.command, "send it to an open workbench")
    return _at(document, known, name)


def _at(document: Document, known: Known, name: str | None) -> Document:
    """The document with the joints elsewhere. name: of the number that was moved; others follow it."""
    state, at = document.mechanism, known.joints
    assert state is not None and at is not None, "both are there"
    values, poses = at
    order = state.order
    changed = [name for name, value in values.items() if abs(value - state.values.get(name, 0.0)) > SMALLEST]
    changed.sort(key=lambda each: each != name)
    order = (*(each for each in order if each not in changed), *changed)
    links = tuple(replace(link, pose=pose) for link, pose in zip(state.links, poses, strict=True))
    now = replace(state, values=MappingProxyType(dict(values)), links=links, order=order)
    return replace(with_links(document, now), pose=known.pose)


def _closed(document: Document) -> Document:
    state = document.mechanism
    if state is None:
        return document
    home = replace(state, links=tuple(replace(link, pose=HOME) for link in state.links))
    return replace(with_links(document, home), mechanism=None)


def _carry(moved: dict[int, Row], parts: Iterable[int], pose: Row) -> None:
    for part in parts:
        if pose == HOME:
            moved.pop(part, None)
        else:
            moved[part] = pose


def _found(known: Known, given: Arguments) -> MechanismState:
    given.text("text", MOST_TEXT, may_be_empty=True)
    if known.mechanism is None:
        raise WorkbenchError("the mechanism is not known", given.command, "send it to an open workbench")
    return known.mechanism


def _state(document: Document, given: Arguments) -> MechanismState:
    if document.mechanism is None:
        raise WorkbenchError("there is no mechanism", given.command, "open one: a TOML file, see docs/mechanisms.md")
    return document.mechanism


def _named(document: Document, given: Arguments) -> None:
    state = _state(document, given)
    given.choice("name", [each.name for each in state.numbers])
