"""The joints of a session: moves them as far as contact lets them, and finds their ranges in the background.

The range of a joint, cast exactly from where it stands, decides where it stops. From elsewhere in the range its ends
differ by rounding: a slider asks for it once, and what is near an end is cast from where the joint stands, so that a
record gives the same bits again. Live moves are shown to the pages and change nothing; the command `joint_move` puts
the joint there.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from feeler.errors import FeelerError, WorkbenchError
from feeler.mechanism.answers import MechanismContact, Range
from feeler.mechanism.gaps import clearance_of
from feeler.mechanism.positions import Positions
from feeler.poses import inverse
from feeler.progress import Progress
from feeler.workbench.document import motion
from feeler.workbench.document.answers import JointPlace
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import Document
from feeler.workbench.document.joint_commands import MOST_TEXT, steps_before, ways_of
from feeler.workbench.document.joints import (
    JointMet,
    JointRange,
    JointStep,
    JointWorst,
    MechanismState,
    laid,
)
from feeler.workbench.document.known import Along, Known
from feeler.workbench.document.motion import Row
from feeler.workbench.engine.guide import Guide
from feeler.workbench.engine.hand import Hands
from feeler.workbench.engine.joint_hand import Freedom, JointGuide
from feeler.workbench.engine.mechanism import (
    STEP_M,
    STEP_RAD,
    Heard,
    Standings,
    asked_key,
    given_values,
    state_of,
)
from feeler.workbench.session.jobs import Job, JobCancelledError, Jobs
from feeler.workbench.session.joint_free import SLACK, Went, is_inside, range_from, went

LIVE = "joints"
"""The type of the message that shows a position."""
FOLLOW_S = 1.0 / 30.0
"""Between two places of what follows the hand, at least."""
TELL_S = 0.2
"""Progress is told at most this often."""
KNOWN_SHARE = 0.2
"""Of the work: from there on it is known how far a number moves."""
ERROR_M, MOST_BOXES = 2e-4, 4000
"""Of the curve of gaps: to which its bounds agree, and the most boxes that are tried."""
_DIP_M = 1e-7  # gaps that differ by less are the same
_SAME = 1e-6  # numbers that followed a loop differ by less


@dataclass(frozen=True)
class Reached:
    """A position, and what stopped the joint there. values, poses: all numbers, and those of the links."""

    values: Mapping[str, float]
    poses: tuple[Row, ...]
    went: Went

    @property
    def met(self) -> JointMet | None:
        """What it meets there."""
        return None if self.went.met is None else _met(self.went.met)


Revised = Callable[[tuple[JointRange, ...]], tuple[JointRange, ...]]


class Joints:
    """Thread-safe. The thread of ranges begins with the first mechanism."""

    def __init__(self, revise: Callable[[Revised], None], show: Callable[[dict[str, Any]], None]) -> None:
        """revise: changes the ranges of the document. show: sends a message that only counts until the next."""
        self._revise, self._show = revise, show
        self._lock = threading.RLock()
        self._ranges: dict[str, tuple[str, Mapping[str, float], Range]] = {}
        self._hands: Hands | None = None
        self._live: Standings | None = None
        self._jobs: Jobs | None = None
        self._job: Job | None = None
        self._about: tuple[object, ...] = ()
        self._is_closed = False
        self._hand: tuple[Document, str, float] | None = None
        self._has_hand = threading.Event()
        self._follower: threading.Thread | None = None

    def open(self, hands: Hands) -> None:
        """Another mock-up is open."""
        with self._lock:
            if self._job is not None:
                self._job.cancel()
            self._ranges, self._about, self._job = {}, (), None
            self._hands, self._live = hands, Standings(hands.scene)

    def close(self) -> None:
        """Gives up all work."""
        self._is_closed = True
        self._has_hand.set()
        if self._jobs is not None:
            self._jobs.close()

    # ---- positions ----

    def opened(self, text: str, name: str, values: Mapping[str, float] | None = None) -> MechanismState:
        """The mechanism of a text, as a document has it. Raises `WorkbenchError`."""
        if len(text) > MOST_TEXT:
            raise WorkbenchError(f"{name} is too long", "mechanism", "name parts by patterns")
        with self._lock:
            positions = self._standings().whole(text, name)
            try:
                return state_of(positions, text, name, values)
            except FeelerError as error:
                raise WorkbenchError(f"{name}: {error}", "mechanism", "see docs/mechanisms.md") from None

    def restored(self, document: Document) -> Document:
        """A document of a project, with its mechanism on the parts of now; without it if it does not fit."""
        state = document.mechanism
        if state is None:
            return document
        try:
            made = self.opened(state.text, state.name, given_values(self._whole(state), state.values))
        except FeelerError:
            return replace(document, mechanism=None, on_joint=None)
        return replace(document, mechanism=replace(made, order=state.order))

    def reached(self, document: Document, name: str, value: float) -> Reached:
        """The position with a joint at a value, as far as contact lets it. Raises `WorkbenchError`."""
        with self._lock:
            state = _state(document)
            try:
                positions = self._standings().asked(document)
                positions.check_name(name)
                others = given_values(positions, state.values, name)
                known = self._ranges.get(name)
                if (
                    known is not None
                    and known[0] == range_key(document, name)
                    and is_inside(positions, known[2], state.values.get(name, 0.0), value)
                ):
                    at = Went(value)
                else:
                    at = went(positions, name, others, self._range(positions, document, name), value)
                position = {**state.values, **positions.position({**others, name: at.value}, _start(positions, state))}
                poses = self._whole(state).links.poses(position)
            except FeelerError as error:
                raise _told(error) from None
        return Reached(position, tuple(motion.row(poses[link]) for link in range(len(state.links))), at)

    def to(self, document: Document, name: str, value: float | None) -> JointPlace:
        """As `reached`, shown to all pages until the next change; None: they show where the joints stand."""
        if value is None:
            state = _state(document)
            self._show({"type": LIVE, "poses": None, "values": dict(state.values)})
            place = state.values.get(name, 0.0)
            return {"name": name, "value": place, "stop": None, "met": None, "why": "", "values": dict(state.values)}
        found = self.reached(document, name, value)
        self._show({"type": LIVE, "poses": [list(row) for row in found.poses], "values": dict(found.values)})
        met, at = found.met, found.went
        return {
            "name": name,
            "value": at.value,
            "stop": "contact" if met is not None else "limit" if at.is_limit else "end" if at.why else None,
            "met": None if met is None else {"part": met.part, "other": met.other, "point": met.point},
            "why": at.why,
            "values": dict(found.values),
        }

    # ---- the hand ----

    def hand(self, document: Document, guide: Guide | None, pose: motion.Floats) -> None:
        """Hears where the hand has a joint: a thread shows its value, and all that follows it, as fast as it can."""
        if document.on_joint is None or not isinstance(guide, JointGuide) or self._is_closed:
            return
        self._hand = (document, document.on_joint, guide.clipped(guide.value_of(pose)))
        if self._follower is None:
            self._follower = threading.Thread(target=self._follow, name="feeler joint in the hand", daemon=True)
            self._follower.start()
        self._has_hand.set()

    def _follow(self) -> None:
        while True:
            self._has_hand.wait()
            self._has_hand.clear()
            if self._is_closed:
                return
            held, self._hand = self._hand, None
            if held is not None:
                with contextlib.suppress(FeelerError):
                    self.follow(*held)
            time.sleep(FOLLOW_S)

    def follow(self, document: Document, name: str, value: float) -> None:
        """Shows a joint that the hand has, and what follows it. Raises `WorkbenchError`."""
        found = self.reached(_laid(document), name, value)
        self._show({"type": LIVE, "poses": [list(row) for row in found.poses], "values": dict(found.values)})

    # ---- lines of the sequence ----

    def after(self, document: Document, line: int) -> tuple[Mapping[str, float], tuple[Row, ...]]:
        """The numbers and poses where a line of the sequence leaves the joints. Raises `WorkbenchError`."""
        step = next((each.joint for each in document.sequence if each.id == line), None)
        state = _state(document)
        if step is None:
            return state.values, tuple(link.pose for link in state.links)
        with self._lock:
            whole = self._whole(state)
            try:
                others = given_values(whole, step.start, step.name)
                position = whole.position(
                    {**others, step.name: step.end}, _start(whole, replace(state, values=step.start))
                )
            except FeelerError as error:
                raise _told(error) from None
            poses = whole.links.poses(position)
        return position, tuple(motion.row(poses[link]) for link in range(len(state.links)))

    def steps(self, document: Document) -> tuple[tuple[JointStep, list[Along]], ...]:
        """The moves from where the sequence leaves the joints to where they stand."""
        state, hands = _state(document), self._hands
        assert hands is not None, "a mock-up is open"
        bounds = hands.scene.mockup.part_bounds.reshape(-1, 2, 3)
        boxes = {part: bounds[part] for link in state.links for part in link.parts}
        found = []
        with self._lock:
            whole = self._whole(state)
            try:
                now = whole.position(given_values(whole, steps_before(document)))
                for name in state.order:
                    number, end = state.number(name), state.values[name]
                    if number is None or abs(now[name] - end) <= _SAME:
                        continue
                    rows, last = [], now
                    step = STEP_RAD if number.kind == "turn" else STEP_M
                    for value in np.linspace(now[name], end, 2 + int(abs(end - now[name]) / step)):
                        others = given_values(whole, now, name)
                        last = whole.position({**others, name: float(value)}, last if whole.groups else None)
                        poses = whole.links.poses(last)
                        rows.append([motion.row(poses[link]) for link in range(len(state.links))])
                    move = JointStep(name, number.kind, now[name], end, MappingProxyType(now))
                    found.append((move, ways_of(document, rows, boxes)))
                    now = last
            except FeelerError as error:
                raise _told(error) from None
        return tuple(found)

    def known(self, known: Known, given: Arguments, document: Document, guide: Guide | None) -> Known:
        """What a command needs of joints. guide: of the hand."""
        if given.command == "mechanism_open":
            made = self.opened(given.text("text", MOST_TEXT, may_be_empty=True), given.text("name"))
            return replace(known, mechanism=made, joints=(made.values, tuple(link.pose for link in made.links)))
        if given.command == "joint_move":
            found = self.reached(document, given.text("name"), given.number("value"))
            return replace(known, joints=(found.values, found.poses))
        if given.command == "joint_step":
            return replace(known, joint_steps=self.steps(document))
        if given.command == "joint_step_go":
            return replace(known, joints=self.after(document, given.whole("id")))
        if given.command in ("release",) and document.on_joint is not None:
            down = _laid(document)
            value = _state(document).values[document.on_joint]
            if isinstance(guide, JointGuide):
                value = guide.clipped(guide.value_of(motion.matrix(known.pose)))
            found = self.reached(down, document.on_joint, value)
            return replace(known, joints=(found.values, found.poses))
        return known

    def freedom(self, document: Document) -> Freedom | None:
        """The joint on which the hand holds its parts, and how far it is free; None if that is not known: the hand is
        held by nothing then."""
        name, state = document.on_joint, document.mechanism
        number = None if name is None or state is None else state.number(name)
        if name is None or state is None or number is None:
            return None
        with self._lock:
            try:
                positions = self._standings().asked(_laid(document))
                found = self._range(positions, _laid(document), name)
                poses = self._whole(state).links.poses(dict(state.values))
            except FeelerError:
                return None
        above = state.links[number.link].above
        frame = poses[above]
        part = next(part for part in state.with_number(number) if part in document.gripped)
        own = next(link for link in state.links if part in link.parts)
        pairs = {(seat.part, seat.other) for seat in found.seats} | positions.bodies.skipped
        held = self._held_numbers(document)
        seats = {(held[a], b) for pair in pairs for a, b in (pair, pair[::-1]) if a in held and b not in held}
        return Freedom(
            number.kind == "turn",
            frame[:3, :3] @ np.array(number.axis),
            frame[:3, :3] @ np.array(number.point) + frame[:3, 3],
            number.pitch,
            state.values[name],
            found.lower,
            found.upper,
            motion.matrix(own.pose) @ inverse(motion.matrix(document.gripped[part])),
            frozenset(seats),
        )

    def _held_numbers(self, document: Document) -> dict[int, int]:
        """The gripped parts, with the number of each in what is in the hand."""
        assert self._hands is not None, "a mock-up is open"
        tool = self._hands.held(document)
        assert tool is not None, "the hand holds parts"
        first = tool.part_count - len(document.gripped)
        return {part: first + number for number, part in enumerate(document.gripped)}

    # ---- ranges ----

    def followed(self, after: Document) -> Document:
        """A document with the ranges that are still true, and others begun; called whenever it changes."""
        state = after.mechanism
        if after.on_joint is not None:
            return after  # the ranges hold until it is put down
        about = (state, after.moved, after.out, after.gripped)
        if (
            self._hands is None
            or self._is_closed
            or (
                len(about) == len(self._about)
                and all(one is other for one, other in zip(about, self._about, strict=True))
            )
        ):
            return after
        self._about = about
        if state is None:
            if self._job is not None:
                self._job.cancel()
            return after if not after.joint_ranges else replace(after, joint_ranges=())
        keys = {each.name: range_key(after, each.name) for each in state.numbers if each.root == each.name}
        known = {each.name: each for each in after.joint_ranges if keys.get(each.name) == each.key}
        known = {name: each for name, each in known.items() if _is_inside(each, state.values.get(name, 0.0))}
        if len(known) == len(keys):
            return after
        ranges = tuple(known.get(name, JointRange(name, key)) for name, key in keys.items())
        if self._job is not None:
            self._job.cancel()
        if self._jobs is None:
            self._jobs = Jobs()
        hands, open_ = self._hands, [each.name for each in ranges if each.state == "running"]
        self._job = self._jobs.start(lambda progress: self._work(hands, after, open_, progress), lambda *_: None)
        return replace(after, joint_ranges=ranges)

    def _work(self, hands: Hands, document: Document, names: list[str], progress: Progress) -> None:
        state = _state(document)
        standings = Standings(hands.scene)
        try:
            positions = standings.asked(document, progress)
            whole = standings.whole(state.text, state.name)
        except JobCancelledError:
            return
        except (FeelerError, MemoryError) as error:
            for name in names:
                self._tell(name, range_key(document, name), state="failed", trouble=str(error))
            return
        # How far all of them go is known first: their gaps take longer.
        found: dict[str, JointRange] = {}

        def ended(name: str) -> JointRange:
            found[name] = self._ended(positions, document, name)
            return replace(found[name], state="running", share=KNOWN_SHARE)

        def measured(name: str) -> JointRange:
            return self._measured(positions, whole, document, found[name])

        try:
            self._each(names, document, positions, progress, ended, KNOWN_SHARE)
            self._each(list(found), document, positions, progress, measured, 1.0)
        except JobCancelledError:
            return

    def _each(
        self,
        names: list[str],
        document: Document,
        positions: Heard,
        progress: Progress,
        find: Callable[[str], JointRange],
        most: float,
    ) -> None:
        """Tells what is found of each number. most: the share of the work that is done then."""
        told = [time.monotonic()]
        for count, name in enumerate(names):
            key = range_key(document, name)

            def heard(name: str = name, key: str = key, count: int = count) -> None:
                progress(count / len(names), name)
                now = time.monotonic()
                if now - told[0] >= TELL_S:
                    told[0] = now
                    # How long it takes is not known: it comes nearer to the end, and never gets there.
                    self._tell(name, key, towards=most)

            positions.heard = heard
            try:
                heard()
                done = find(name)
            except JobCancelledError:
                raise
            except (FeelerError, MemoryError) as error:
                self._tell(name, key, state="failed", trouble=str(error) or "not enough memory")
            except Exception as error:
                self._tell(name, key, state="failed", trouble=f"{type(error).__name__}: {error}")
            else:
                self._tell(name, key, found=done)

    def _ended(self, positions: Heard, document: Document, name: str) -> JointRange:
        """How far a number moves, and what stops it."""
        state, key = _state(document), range_key(document, name)
        if name not in positions.names:
            raise WorkbenchError("its parts are out", "mechanism", "put one back")
        found = _asked(positions, state, name)
        with self._lock:
            self._ranges[name] = (key, state.values, found)
        return JointRange(
            name,
            key,
            "done",
            1.0,
            found.lower,
            found.upper,
            None if found.below is None else _met(found.below),
            None if found.above is None else _met(found.above),
            trouble=found.ended if positions.loops_of(name) else "",
        )

    def _measured(self, positions: Heard, whole: Positions, document: Document, done: JointRange) -> JointRange:
        """A range with its gaps and its narrowest position."""
        if not done.lower < done.upper:
            return done
        state, name = _state(document), done.name
        others = given_values(positions, state.values, name)
        gaps = clearance_of(positions, {**others, name: (done.lower, done.upper)}, ERROR_M, MOST_BOXES, False)
        curve = tuple((float(row[0]), float(row[1]) if math.isfinite(row[1]) else None) for row in gaps.curve)
        inside = narrow_span(gaps.curve[:, :2], done.below is not None, done.above is not None)
        if inside is not None:
            gaps = clearance_of(positions, {**others, name: inside}, ERROR_M, MOST_BOXES, False)
        worst = None
        if gaps.part is not None and gaps.other is not None and gaps.points is not None and math.isfinite(gaps.upper):
            poses = whole.links.poses({**state.values, **gaps.worst})
            rows = tuple(motion.row(poses[link]) for link in range(len(state.links)))
            worst = JointWorst(gaps.worst.get(name, 0.0), float(gaps.upper), gaps.part, gaps.other, gaps.points, rows)
        return replace(done, curve=curve, worst=worst)

    def _tell(
        self, name: str, key: str, *, found: JointRange | None = None, towards: float = 0.0, **changes: Any
    ) -> None:
        """towards: a share of the work that it comes nearer to."""

        def revised(ranges: tuple[JointRange, ...]) -> tuple[JointRange, ...]:
            out = []
            for each in ranges:
                if each.name == name and each.key == key:
                    each = found or replace(each, share=each.share + 0.2 * max(0.0, towards - each.share), **changes)
                out.append(each)
            return tuple(out)

        self._revise(revised)

    def _range(self, positions: Heard, document: Document, name: str) -> Range:
        """The range of a number from where a document has it, and of that alone."""
        state, key = _state(document), range_key(document, name)
        kept = self._ranges.get(name)
        if kept is None or kept[0] != key or kept[1] != state.values:
            kept = self._ranges[name] = (key, state.values, _asked(positions, state, name))
        return kept[2]

    def _standings(self) -> Standings:
        if self._live is None:
            raise WorkbenchError("no mock-up is open yet", "mechanism", "wait until it is loaded")
        return self._live

    def _whole(self, state: MechanismState) -> Positions:
        return self._standings().whole(state.text, state.name)


def _laid(document: Document) -> Document:
    """The document as if the hand held nothing of the mechanism."""
    held = laid(_state(document), document.moved, document.gripped)
    return replace(document, moved=held, gripped=MappingProxyType({}))


def range_key(document: Document, name: str) -> str:
    """A key of all that the range of a number depends on, which is not the number itself."""
    state = _state(document)
    own = state.number(name)
    group = name if own is None else own.group
    others = [(each.name, round(state.values.get(each.name, 0.0), 9)) for each in state.numbers if each.group != group]
    told = repr((name, asked_key(document), others))
    return hashlib.blake2b(told.encode("utf-8", "surrogatepass"), digest_size=12).hexdigest()


def narrow_span(curve: motion.Floats, is_below: bool, is_above: bool) -> tuple[float, float] | None:
    """The part of a curve of gaps `(n, 2)` that does not merely lead away from the stops at its ends; None if all of it
    does, or if there are no stops: then the least gap of all is the one to show."""
    if not (is_below or is_above):
        return None
    falls = np.flatnonzero(curve[1:, 1] < curve[:-1, 1] - _DIP_M)
    rises = np.flatnonzero(curve[1:, 1] > curve[:-1, 1] + _DIP_M)
    first = (int(falls[0]) if len(falls) else len(curve) - 1) if is_below else 0
    last = (int(rises[-1]) + 1 if len(rises) else 0) if is_above else len(curve) - 1
    return (float(curve[first, 0]), float(curve[last, 0])) if first < last else None


def _asked(positions: Positions, state: MechanismState, name: str) -> Range:
    """The range of a number from where it stands."""
    start = state.values.get(name, 0.0)
    return range_from(positions, name, {**given_values(positions, state.values), name: start})


def _start(positions: Positions, state: MechanismState) -> dict[str, float] | None:
    """Where loops are followed from: where they stand."""
    if not positions.groups:
        return None
    return {name: value for name, value in state.values.items() if name in positions.names}


def _is_inside(known: JointRange, value: float) -> bool:
    return known.state != "done" or known.lower - SLACK <= value <= known.upper + SLACK


def _met(found: MechanismContact) -> JointMet:
    return JointMet(found.part, found.other, found.point)


def _state(document: Document) -> MechanismState:
    if document.mechanism is None:
        raise WorkbenchError("there is no mechanism", "mechanism", "open one: a TOML file, see docs/mechanisms.md")
    return document.mechanism


def _told(error: FeelerError) -> WorkbenchError:
    if isinstance(error, WorkbenchError):
        return error
    return WorkbenchError(str(error), "mechanism", "see docs/mechanisms.md")
