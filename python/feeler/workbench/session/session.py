"""The session of a workbench: document, undo, engine, jobs and record. Servers and scripts use it; no sockets.

Every change goes through `command`. It sends a patch event to the pages, writes a line to the record, and keeps the
previous document for undo. All methods may be called from any thread.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import near
from feeler.errors import FeelerError, OptionError, WorkbenchError
from feeler.mockup import Mockup, Tool
from feeler.poses import inverse
from feeler.progress import Progress
from feeler.project.book import Book
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.cards import tasks_again, tasks_of, told
from feeler.workbench.document.commands import COMMANDS, STEPS, applied
from feeler.workbench.document.document import UNITS, Document, Loading, ProjectFacts, RecordFacts, patch
from feeler.workbench.document.findings import doubt_of, findings_of, read_findings, saved
from feeler.workbench.document.guide_commands import GUIDES
from feeler.workbench.document.history import History, Step
from feeler.workbench.document.joint_commands import JOINTS, is_at_start
from feeler.workbench.document.known import Known
from feeler.workbench.document.line_facts import with_checked_lines
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol import CommandAnswer, DocumentFields, HeldManifest, Manifest, Turning
from feeler.workbench.engine import measuring
from feeler.workbench.engine.engine import Bump, Engine, Ticked
from feeler.workbench.engine.geometry import Geometry, scene_bounds
from feeler.workbench.engine.guide import Guide
from feeler.workbench.engine.hand import Hands, held_key
from feeler.workbench.engine.joint_hand import Freedom
from feeler.workbench.engine.snapshot import Snapshot
from feeler.workbench.engine.world import World
from feeler.workbench.session.answering import Answered, kept_answer
from feeler.workbench.session.asking import Place, Recorded
from feeler.workbench.session.cards import Cards
from feeler.workbench.session.events import Event, Events
from feeler.workbench.session.jobs import Job
from feeler.workbench.session.joints import Joints, Revised
from feeler.workbench.session.opening import beside, opening
from feeler.workbench.session.openings import Openings
from feeler.workbench.session.people import DEVICE, SCRIPT, PeopleOf
from feeler.workbench.session.record import Recorder
from feeler.workbench.session.requests import Requests
from feeler.workbench.session.saving import Saver
from feeler.workbench.session.wanted import Wanted

LEAST_TICK_S = 0.004
"""The engine's thread starts at most one round per this time: 250 Hz."""
IDLE_TICK_S = 0.05
"""Time between rounds while nothing happens; a wish or a command ends the wait."""
_CLOSE_S = 10.0  # for the current round of the engine


class Session:
    """See the module. Raises `OptionError` for an unknown unit."""

    def __init__(
        self,
        *,
        unit: str = "mm",
        record: Path | None = None,
        project: Book | None = None,
        seed: int = 0,
        clock: Callable[[], float] = time.monotonic,
        has_threads: bool = True,
    ) -> None:
        """record: a file for `feeler replay`. project: keeps the document; `close` closes it. clock: seconds.

        has_threads: False: `engine.tick()` is called by hand.
        """
        _checked_unit(unit)
        self._lock = threading.RLock()
        self._saver = None if project is None else Saver(project, self._saved)
        facts = None if self._saver is None else self._saver.facts
        self._document = Document(unit=unit, loading=Loading("starting", 0.0), project=facts)
        self._history = History()
        self._events = Events()
        self._wanted = Wanted(self._events.tell)
        self._cards = Cards(self._card_told, self._keep_answer)
        self.joints = Joints(self._ranges_told, self._events.show)
        """Moves the joints of the mechanism, and knows their ranges."""
        self.openings = Openings(tell=lambda text: self._events.tell({"type": "notice", "level": "info", "text": text}))
        """Files of pages, and the opening of other mock-ups, if somebody offers it."""
        self._requests = Requests(self.openings.files)
        self._requests.joint_to = self.joints.to
        self._requests.project = project
        self._clock, self._seed = clock, seed
        self.people = PeopleOf(clock, parts=self._part_count, is_playing=lambda: self._document.replaying is not None)
        """Who has a page, and who has the tool."""
        self.engine = Engine(clock=clock, on_bump=self._bumped, on_tick=self._ticked, on_guided=self._guided)
        self._recorder = None if record is None else Recorder(Path(record))
        self._hands: Hands | None = None
        self._geometry: Geometry | None = None
        self.pages = 0
        """Number of open pages, kept by the server."""
        self._snapshot_listeners: list[Callable[[], None]] = []
        self._wake, self._is_closed, self._is_warming = threading.Event(), False, False
        self._thread: threading.Thread | None = None
        if has_threads:
            self._thread = threading.Thread(target=self._loop, name="feeler engine", daemon=True)
            self._thread.start()

    # ---- opening ----

    def loading(self, stage: str, share: float) -> None:
        """Reports the progress of opening the mock-up."""
        self._show(replace(self._document, loading=Loading(str(stage), min(1.0, max(0.0, float(share))))), None)

    def failed(self, text: str) -> None:
        """Reports why there is no mock-up."""
        self._show(replace(self._document, loading=None, failed=str(text)), None)

    def not_opened(self, text: str) -> None:
        """Reports why another mock-up could not be opened: the present one stays."""
        self._show(replace(self._document, loading=None), None)
        self._events.tell({"type": "notice", "level": "error", "text": str(text)})

    def open(
        self,
        mockup: Mockup,
        scene: Scene,
        tool: Tool | None,
        *,
        pose: npt.ArrayLike | None = None,
        mode: str = "stop",
        unit: str | None = None,
        tools: Iterable[Tool] = (),
        name: str | None = None,
        doubts: Iterable[str] = (),
        kept: Mapping[str, Any] | None = None,
    ) -> None:
        """Opens a mock-up: a new document, with nothing to undo. Prepares the data that the first answers need.

        tool: in the hand at first; tools: others for `take_tool`. pose: of the hand at first, default beside the parts
        of the scene. unit: default as before. name: of the mock-up, default that of its file. doubts: of the loaders.
        kept: how it was read, for a project that is downloaded. A project that was saved before has its own document,
        which replaces tool, pose, mode and unit. Raises `WorkbenchError`, `OptionError`, and `LoadError` for a project
        of another mock-up, or a damaged one.
        """
        unit = self._document.unit if unit is None else _checked_unit(unit)
        if scene.mockup is not mockup:
            raise OptionError("the scene is of another mock-up: index the one that is opened")
        start = None if pose is None else motion.checked(pose, "pose")
        begun = opening(
            self._document, scene, tool, tools, pose=start, mode=mode, unit=unit, name=name, seed=self._seed
        )
        document = begun.document if self._saver is None else self._saver.begin(begun.document, begun.hands, tool)
        document = replace(document, doubts=tuple(doubts))
        with self.engine.paused(), self._lock:
            self._hands, self._geometry = begun.hands, begun.geometry
            self.joints.open(begun.hands)
            document = self.joints.restored(document)
            self._history = History()
            self._requests.forget(kept)
            self._cards.open(begun.hands, self._kept_answers(document, mockup))
            if self._recorder is not None:
                self._recorder.header(begun.header)
            self._engine_to(document)
            self._show(document, None)
            self._tell_held(document)
            if document.replaying is not None:
                self._play(document)
        # The pages fetch and draw meanwhile: for large mock-ups this takes longer than all the rest.
        self._is_warming = True
        try:
            self.engine.warm_up()
        finally:
            self._is_warming = False

    def load_findings(self, given: Any) -> str:
        """Opens findings of `feeler clash --json`, a file or its content; returns `doubt_of`. Raises `LoadError`."""
        data = read_findings(given) if isinstance(given, (str, Path)) else given
        with self._lock:
            parts = self._opened().scene.mockup.parts
            found = findings_of(data, parts, self._document.absent)
            # The user did not make this change: undo does not revert it.
            self._history.revise(lambda each: each if each.findings else replace(each, findings=found))
            self._show(replace(self._document, findings=found), None)
        return doubt_of(found, parts)

    # ---- a record that is gone through again ----

    def offer(self, record: RecordFacts, recorded: Recorded) -> None:
        """Lets pages replay a record, by the jobs "replay" and "replay_to"."""
        with self._lock:
            self._requests.recorded = recorded
            self.show_record(record)

    def show_record(self, record: RecordFacts) -> None:
        """Sets the facts about the record."""
        with self._lock:
            self._show(replace(self._document, record=record), None)

    def replaying(self) -> AbstractContextManager[None]:
        """During a `with`, only `replayed` and commands of a record change anything."""
        return self.engine.held()

    def replayed(self, wish: Floats, seq: int, source: str, steps: int) -> Ticked:
        """Runs a round from a record, and shows it to the pages."""
        ticked = self.engine.replayed(wish, seq, source, steps)
        self._tell_snapshot()
        return ticked

    def show_moment(self, document: Document, pose: Floats, wish: Floats, *, is_last: bool) -> None:
        """Shows a state of a record: a document, and the hand at a pose, held back from a wish. Undo begins anew there.

        is_last: work may go on from it; else others follow at once.
        """
        with self.engine.paused(), self._lock:
            now, hands = self._document, self._opened()
            after = self._of_this_run(document)
            after = replace(after, held_version=hands.version(after))
            if is_last or held_key(now) != held_key(after) or now.world != after.world or now.mode != after.mode:
                self._engine_to(replace(after, pose=motion.row(pose)))
            self.engine.shown(pose, wish, is_last=is_last)
            self._history = History()
            if after != now:
                self._show(after, None)
            if after.held_version != now.held_version:
                self._tell_held(after)
        self._tell_snapshot()

    # ---- state ----

    def document(self) -> DocumentFields:
        """The document as JSON."""
        return self._document.to_json()

    def document_and_event(self) -> tuple[DocumentFields, int]:
        """The document, and the number of the newest event included in it."""
        with self._lock:
            return self._document.to_json(), self._events.last

    @property
    def current(self) -> Document:
        """The document itself."""
        return self._document

    @property
    def last_event(self) -> int:
        """The number of the newest event."""
        return self._events.last

    @property
    def is_recording(self) -> bool:
        """Whether the session is recorded."""
        return self._recorder is not None and self._recorder.trouble is None

    def subscribe(self, listener: Callable[[Event], None]) -> Callable[[], None]:
        """Subscribes to events, as JSON with their number `n`; called in any thread, and must not block."""
        return self._events.subscribe(listener)

    def events_since(self, number: int) -> list[Event] | None:
        """The events after a number; None if a page needs the whole document."""
        return self._events.since(number)

    def tell(self, event: Event) -> None:
        """Sends an event for others, such as a notice or a request for a picture."""
        self._events.tell(event)

    def snapshot(self) -> Snapshot | None:
        """The engine's newest snapshot."""
        return self.engine.snapshot()

    def on_snapshot(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Subscribes to new snapshots, called in the engine's thread. Call the result to unsubscribe."""
        self._snapshot_listeners.append(listener)

        def end() -> None:
            with contextlib.suppress(ValueError):
                self._snapshot_listeners.remove(listener)

        return end

    def manifest(self) -> Manifest:
        """The geometry's manifest. Raises `WorkbenchError` before a mock-up is open."""
        return self._packed().manifest()

    def piece(self, number: int) -> bytes:
        """A packed piece. Raises `WorkbenchError` if it does not exist."""
        geometry = self._packed()
        return _piece(geometry, geometry.piece, number)

    def sent_piece(self, number: int) -> bytes:
        """A packed piece with copies as places: `Geometry.sent`. Raises `WorkbenchError` if it does not exist."""
        geometry = self._packed()
        return _piece(geometry, geometry.sent, number)

    def held_manifest(self, version: int) -> HeldManifest | None:
        """The manifest of the hand's content at a version; None: nothing. Raises `WorkbenchError`."""
        if version == 0:
            return None
        with self._lock:
            return self._opened().geometry(version).manifest()

    def held(self, version: int) -> bytes:
        """The hand's content at a version, packed. Raises `WorkbenchError`."""
        with self._lock:
            return self._opened().geometry(version).data()

    def finding_rows(self, version: str) -> bytes:
        """The rows of the findings of a version, packed. Raises `WorkbenchError` if there are none such."""
        found = self._document.findings
        if found is None or found.table.key != version:
            raise WorkbenchError("the findings are others now", "findings", "fetch those of the document")
        return found.table.frame()

    def export(self, name: str) -> bytes:
        """A file written by a job. Raises `WorkbenchError`."""
        return self._requests.export(name)

    def card_room(self, number: int) -> bytes:
        """The swept volume of a card, packed. Raises `WorkbenchError`."""
        return self._cards.room(number)

    # ---- requests ----

    def wish(self, pose: npt.ArrayLike, seq: int, source: str, by: int = SCRIPT) -> bool:
        """Sets the target of the hand; only the newest counts. Raises `WorkbenchError` for an invalid pose.

        by: the person of a page, else a script; a device by its source. False: somebody else has the tool.
        """
        wished = motion.checked(pose, "pose")
        if self.engine.is_held:
            return True
        if not self.people.may_move(DEVICE if source == "device" else by, wished):
            return False
        self.engine.wish(wished, int(seq), str(source))
        self._wake.set()
        return True

    def turn(self, person: int, turning: Turning) -> dict[str, Any]:
        """A person's wish about the turn of the tool; the answer is empty. Raises `WorkbenchError`."""
        if self.people.turn(person, turning) and self._document.replaying is None:
            self.hand_gone()  # it does not go on to where the other one wished it
        return {}

    def hand_gone(self) -> None:
        """Releases the hand: the tool stops where it is."""
        with self.engine.paused():
            if self.engine.is_held:
                return
            self.engine.let_go()
            if self._recorder is not None:
                self._recorder.let_go(self._clock())
        self._guided(None)
        self._wake.set()

    def command(
        self, name: str, args: dict[str, Any], by: int | None = SCRIPT, *, is_recorded: bool = False
    ) -> CommandAnswer:
        """Changes the document; see `commands.COMMANDS`, and `undo` and `redo`. Raises `WorkbenchError`.

        The result: "id" of an added thing, "pose" of the hand, "undo_depth", "redo_depth". by: the person of a page,
        else a script; None: the session itself. is_recorded: the command comes from a record being replayed; others
        are refused meanwhile.
        """
        if self.engine.is_held and not is_recorded:
            raise WorkbenchError("a record is being replayed", str(name), "wait until it has ended, or give it up")
        known = COMMANDS.get(name)
        moves_hand = name in STEPS if known is None else known.moves_hand
        is_of_cards = known is not None and known.is_of_cards
        # The engine's lock always before the session's; without it if the hand stays, so that it can go on meanwhile.
        with self.engine.paused() if moves_hand else contextlib.nullcontext(), self._lock:
            now = self._clock()
            if by is not None and not is_recorded:
                self._check_turn(name, by, moves_hand)
            if moves_hand:
                self.engine.flush()
            try:
                before = self._document
                if name == "task_edit" and not is_recorded:
                    Arguments(name, args, COMMANDS[name].arguments).place_of(tasks_of(before))
                step = Step(str(name), SCRIPT if by is None else by)
                after = self._stepped(name, args, step) if name in STEPS else self._changed(name, args, step)
            except FeelerError as error:
                if self._recorder is not None and not is_of_cards:
                    self._recorder.command(now, str(name), args, None, str(error))
                raise
            after = tasks_again(after, lambda: self._known(self._opened()))
            self._show(after, name)
            if after.guiding is not before.guiding:
                self.engine.set_guide(self._guide_of(after))
            if after.cards is not before.cards:
                self._cards.follow(before, after, self._opened())
            if after.held_version != before.held_version:
                self._tell_held(after)
            if self._recorder is not None and not is_of_cards:
                if name == "findings_take" and after.findings is not None:
                    args = {**args, "saved": saved(after.findings)}  # a replay has no jobs
                if name == "way_take":
                    args = self._with_ways(args, before, after)
                elif name == "way_keep":
                    args = self._with_short_way(args, before)
                self._recorder.command(now, name, args, after, None)
            if name == "sequence_replay":
                self._play(after)
            added: CommandAnswer = {"id": before.next_id} if after.next_id > before.next_id else {}
            if after.next_card > before.next_card:
                added = {"id": before.next_card}
        self._wake.set()
        return {**added, "pose": list(after.pose), **self._depths()}

    def ask(self, name: str, args: dict[str, Any]) -> dict[str, Any] | None:
        """A question that changes nothing; see `asking.ASKS`. Raises `WorkbenchError`."""
        return self._requests.ask(self._place, name, args)

    def job(self, name: str, args: dict[str, Any], on_progress: Progress | None = None) -> Job:
        """Runs a long task in the jobs thread; see `asking.JOBS`. Raises `WorkbenchError`."""
        return self._requests.job(self._place, name, args, on_progress)

    def shot(self, width: int, height: int, wait_s: float, camera: dict[str, Any] | None = None) -> bytes | None:
        """A picture by one of the pages, as PNG; None if none arrives in time. Pages send it to `shot_taken`."""
        return self._wanted.shot(width, height, wait_s if self.pages else 0.0, camera)

    def shot_taken(self, number: int, png: bytes) -> None:
        """Receives a page's picture. Late ones, and all but the first, are dropped."""
        self._wanted.shot_taken(number, png)

    def benchmark(self) -> Future[dict[str, Any]]:
        """Requests measurements from the pages; the first answer counts. `benchmark.py` has the figures."""
        return self._wanted.benchmark()

    def benchmarked(self, number: int, figures: dict[str, Any]) -> None:
        """Receives a page's measurements. Late ones, and all but the first, are dropped."""
        self._wanted.benchmarked(number, figures)

    @property
    def scene(self) -> Scene:
        """The open scene. Raises `WorkbenchError` before that."""
        return self._opened().scene

    def held_tool(self) -> Tool | None:
        """The content of the hand: the tool, gripped parts, or both as one."""
        with self._lock:
            return self._opened().held(self._document)

    def hand_key(self) -> object:
        """A key that changes whenever the hand's content, its placement or the world changes."""
        document = self._document
        return held_key(document), document.world, document.pose

    def guide_now(self) -> Guide | None:
        """The way that guides the hand of a device; None while somebody else has the tool."""
        return self.engine.guide if self.people.could_move(DEVICE) else None

    def hand_now(self) -> tuple[object, World, Tool | None, Floats]:
        """That key, the world around the hand, its content, and its pose (`world_from_tool`, `(4, 4)`)."""
        with self._lock:
            hands, document = self._opened(), self._document
            return self.hand_key(), hands.world(document), hands.held(document), self.engine.pose

    def put_down(self) -> list[Mockup]:
        """The parts that lie elsewhere than they were loaded, with their places."""
        with self._lock:
            return [scene.mockup for scene in self._opened().world(self._document).put_down.values()]

    def close(self) -> None:
        """Ends threads and record; a second call does nothing."""
        self._is_closed = True
        self._wake.set()
        # The data for the first answers is made with the engine's lock held, for seconds in large mock-ups, and cannot
        # be stopped: its daemon thread ends later. Nothing happens meanwhile that a record would lack.
        is_engine_free = not self._is_warming
        if is_engine_free and self._thread is not None and threading.current_thread() is not self._thread:
            self._thread.join(timeout=_CLOSE_S)
        self._requests.close()
        self._cards.close()
        self.joints.close()
        self.openings.close()
        if self._saver is not None:
            self._saver.close()
        if self._recorder is not None:
            if is_engine_free:
                self.engine.flush()
            self._recorder.close()

    def unsaved(self) -> str | None:
        """Why the last changes are not in the project; None if they are, or if there is no project."""
        return None if self._saver is None else self._saver.unsaved

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    # ---- changes ----

    def _check_turn(self, name: str, by: int, moves_hand: bool) -> None:
        """Refuses what moves the hand, while somebody else has it; a step of undo only if it does."""
        if name in STEPS:
            if self._history.is_empty(name):
                return
            after = self._history.next(name)
            moves_hand = self._moves_engine(self._document, after)
        if moves_hand or name in GUIDES:
            self.people.check_move(by)

    def _changed(self, name: str, args: Any, step: Step) -> Document:
        command = COMMANDS.get(name)
        hands = self._opened()
        before = self._document
        wanted = args.get("name") if isinstance(args, dict) else None
        if name == "take_tool" and isinstance(wanted, str) and wanted in hands.names:
            hands.tool(wanted)
        known = self._known(hands)
        if command is not None and command.moves_hand:
            # Undo returns the hand to its last pose, not to where it was last put down; undoing a motion, which ends
            # where the hand is put down, returns it to where the motion began.
            pose = before.pose if name == "place" else known.pose
            before = replace(before, pose=pose, trip=self.engine.trip())
            given = Arguments(name, args, command.arguments)
            if name == "place":
                reached = self.engine.place(motion.matrix(given.pose("pose")))
                known = replace(known, pose=motion.row(reached))
            elif name == "take_tool" and given.has("name"):
                tool = given.choice("name", hands.names)
                known = replace(known, tool_pose=motion.row(self._free_pose(hands, before, tool)))
            elif name == "release" and before.trip is not None:
                least = self.engine.least_clearance(before.trip)
                known = replace(known, trip=before.trip, least_clearance=least)
        elif name in ("measure_add", "measure_edit") and command is not None:
            given = Arguments(name, args, command.arguments)
            if name == "measure_add" or given.has("type"):
                found = measuring.measured(given, before, hands.scene, hands.meshes)
                known = replace(known, measured=found)
        elif name in ("finding_status", "finding_mark"):
            known = replace(known, author=self.people.author(step.by))
        elif name == "findings_take" and isinstance(args, dict):
            known = replace(known, findings=self._requests.taken.of(args.get("key"), before))
        if command is not None and (name in JOINTS or before.on_joint is not None):
            known = self.joints.known(known, Arguments(name, args, command.arguments), before, self.engine.guide)
        after = applied(before, name, args, known)
        if after.guiding is not None and held_key(after) != held_key(before):
            after = replace(after, guiding=None)
        after = replace(after, held_version=hands.version(after))
        if name != "place":
            self._engine_follows(before, after)
        # The parts are put down at the end of a replay: one step with it, unless something else was done meanwhile.
        is_end = name == "release" and before.replaying is not None and self._history.last == "sequence_replay"
        is_start = name == "mechanism_open" and is_at_start(Arguments(name, args, COMMANDS[name].arguments))
        if command is None or not (command.is_of_cards or is_end or is_start):
            self._history.changed(before, step)
        return after

    def _known(self, hands: Hands) -> Known:
        return Known(
            parts=hands.scene.mockup.parts,
            bounds=scene_bounds(hands.scene),
            tools=hands.counts(),
            pose=motion.row(self.engine.pose),
            absent=frozenset(self._document.absent),
            ways=self._cards.ways,
        )

    def _free_pose(self, hands: Hands, document: Document, name: object) -> Floats:
        """The pose of a newly taken tool: at the hand, if it is free there; else beside the mock-up."""
        pose = self.engine.pose
        if name not in hands.names:
            return pose
        tool = hands.tool(str(name))
        is_free = document.tool is not None and not hands.world(document).is_colliding(tool, pose)
        return pose if is_free else beside(hands.scene, tool)

    def _stepped(self, name: str, args: Any, step: Step) -> Document:
        Arguments(name, args, {})
        now, after = self._document, self._history.next(name)
        after = self._of_this_run(after)
        after = replace(after, guiding=now.guiding if held_key(after) == held_key(now) else None)
        self._engine_follows(now, after)
        taken = self._history.stepped(name, now)
        if taken.by != step.by and self.people.count > 1:
            who, whose = self.people.name_of(step.by, is_first=True), self.people.name_of(taken.by)
            text = (
                f"{who} {'undid' if name == 'undo' else 'redid'} a step of {whose} ({taken.command.replace('_', ' ')})"
            )
            self._events.tell({"type": "notice", "level": "info", "text": text})
        return after

    def _of_this_run(self, document: Document) -> Document:
        """An earlier document, with what the user did not change and what is no step of undo as it is now."""
        now = self._document
        document = replace(document, mockup=now.mockup, loading=now.loading, failed=now.failed, record=now.record)
        document = replace(document, joint_ranges=now.joint_ranges)
        document = replace(document, project=now.project, cards=now.cards, next_card=now.next_card)
        return with_checked_lines(document)

    def _engine_follows(self, before: Document, after: Document) -> None:
        if self._moves_engine(before, after):
            self._engine_to(after)

    @staticmethod
    def _moves_engine(before: Document, after: Document) -> bool:
        same_hand = held_key(before) == held_key(after) and before.world == after.world
        return not same_hand or before.mode != after.mode or before.pose != after.pose

    def _engine_to(self, document: Document) -> None:
        hands = self._opened()
        tool = hands.held(document)
        guide = self._guide_of(document)
        with self.engine.paused():  # no round without the guide
            self.engine.set(
                hands.world(document),
                tool,
                motion.matrix(document.pose),
                mode=document.mode,
                places=self._packed().places,
                held_places=hands.geometry(document.held_version).places if tool is not None else None,
                is_carrying=bool(document.gripped),
                trip=document.trip,
            )
            self.engine.set_guide(guide)

    def _with_ways(self, args: Any, before: Document, after: Document) -> Any:
        """The arguments of `way_take` with the ways that were taken, so that a record repeats them without the card."""
        if args.get("ways") is not None:
            return args
        ways = self._cards.ways.get(args["id"], ())
        begin = sum(all(part in before.out for part in way.parts) for way in ways)
        taken = ways[begin : begin + len(after.sequence) - len(before.sequence)]
        return {"ways": [{"parts": list(w.parts), "poses": w.poses, "clearance": w.clearance} for w in taken]}

    def _with_short_way(self, args: Any, before: Document) -> Any:
        """The same of `way_keep`."""
        if args.get("ways") is not None:
            return args
        line = next(card.line for card in before.cards if card.id == args["id"])
        ways = self._cards.ways[args["id"]]
        given = [{"parts": list(w.parts), "poses": w.poses, "clearance": w.clearance} for w in ways]
        return {"line": line, "ways": given, **({"is_added": True} if args.get("is_added") else {})}

    def _keep_answer(self, number: int, found: Answered) -> None:
        if self._saver is not None:
            self._saver.keep_answer(number, found.to_json(number), None if found.room is None else found.room.data)

    def _kept_answers(self, document: Document, mockup: Mockup) -> dict[int, Answered]:
        """The answers that the project has of the document's cards."""
        found = {}
        for card in document.cards if self._saver is not None else ():
            kept = self._saver.answer(card.id) if self._saver is not None and card.state == "done" else None
            answer = None if kept is None else kept_answer(card, *kept, mockup.part_count)
            if answer is not None:
                found[card.id] = answer
        return found

    def _card_told(self, number: int, **changes: Any) -> None:
        with self._lock:
            self._show(told(self._document, number, **changes), None)

    def _ranges_told(self, revised: Revised) -> None:
        with self._lock:
            self._show(replace(self._document, joint_ranges=revised(self._document.joint_ranges)), None)

    def _play(self, document: Document) -> None:
        line = next(each for each in document.sequence if each.id == document.replaying)
        way = [motion.matrix(each) for each in line.way]
        back = inverse(way[0]) @ motion.matrix(document.pose)
        self.engine.play([pose @ back for pose in way[1:]], self._played)

    def _played(self) -> None:
        with contextlib.suppress(WorkbenchError):  # they have already been put down
            self.command("release", {}, None)

    def _guide_of(self, document: Document) -> list[Floats] | Freedom | None:
        way = document.guiding
        if document.on_joint is not None:
            return self.joints.freedom(document)
        return None if way is None else [motion.matrix(pose) for pose in way.way]

    def _guided(self, guide: Guide | None) -> None:
        """The hand came to the end of its guide; None: it is gone."""
        with self._lock:
            if self._document.guiding is None or (guide is not None and guide is not self.engine.guide):
                return
            self._show(replace(self._document, guiding=None), None)
            self.engine.set_guide(None)

    def _show(self, document: Document, command: str | None) -> None:
        with self._lock:
            if self._saver is not None:
                document = self._saver.changed(self._document, document)
            document = self.joints.followed(document)
            before, self._document = self._document, document
            fields = patch(before, document)
            if fields or command is not None:
                self._events.tell({"type": "patch", "fields": fields, "command": command, **self._depths()})

    def _saved(self, document: Document, state: str, trouble: str | None) -> None:
        """The saver wrote a document, or could not. Only the present one counts."""
        with self._lock:
            now = self._document
            if now.project is not None and (trouble is not None or Saver.is_same(document, now)):
                facts: ProjectFacts = replace(now.project, state=state, trouble=trouble)
                self._show(replace(now, project=facts), None)

    def _depths(self) -> CommandAnswer:
        return {"undo_depth": self._history.undo_depth, "redo_depth": self._history.redo_depth}

    def _tell_held(self, document: Document) -> None:
        version = document.held_version
        self._events.tell({"type": "held", "version": version, "manifest": self.held_manifest(version)})

    # ---- the engine's thread ----

    def _loop(self) -> None:
        trouble = ""
        while not self._is_closed:
            try:
                has_news, text = self.engine.tick(), ""
            except Exception as error:
                # One bad pose must not stop the hand: release it, and notify users once.
                self.engine.let_go()
                has_news, text = False, f"the engine: {error}"
                if text != trouble:
                    self._events.tell({"type": "notice", "level": "error", "text": text})
            trouble = text
            if has_news:
                self._tell_snapshot()
            self._wake.wait(timeout=IDLE_TICK_S if self.engine.is_idle else LEAST_TICK_S)
            self._wake.clear()
            # From the start of the round, not from the call: it may have waited for a command.
            gone = self._clock() - self.engine.ticked_at
            time.sleep(min(LEAST_TICK_S, max(0.0, LEAST_TICK_S - gone)))

    def _tell_snapshot(self) -> None:
        if self._document.on_joint is not None:
            self.joints.hand(self._document, self.engine.guide, self.engine.pose)
        for listener in list(self._snapshot_listeners):
            listener()

    def _bumped(self, bump: Bump) -> None:
        hands = self._opened()
        part = hands.scene.mockup.parts[bump.part]
        size = float(np.linalg.norm(np.subtract(part.upper, part.lower)))
        self._events.tell(
            {
                "type": "impact",
                "part": bump.part,
                "part_size_m": size,
                "speed_m_per_s": bump.speed,
                "point": bump.point.tolist(),
                "material": self._document.material,
                "force": bump.force,
            }
        )

    def _ticked(self, ticked: Ticked) -> None:
        if self._recorder is not None and self._document.mockup is not None:
            self._recorder.ticked(ticked)

    # ---- helpers ----

    def _part_count(self) -> int:
        mockup = self._document.mockup
        return 0 if mockup is None else mockup.parts

    def _opened(self) -> Hands:
        if self._hands is None:
            raise WorkbenchError("no mock-up is open yet", "session", "wait until it is loaded")
        return self._hands

    def _packed(self) -> Geometry:
        if self._geometry is None:
            raise WorkbenchError("no mock-up is open yet", "scene", "wait until it is loaded")
        return self._geometry

    def _place(self) -> Place:
        with self._lock:
            return self._requests.place(self._document, self._opened(), self._packed(), self._cards.answer)


def _piece(geometry: Geometry, made: Callable[[int], bytes], number: int) -> bytes:
    try:
        return made(number)
    except IndexError:
        raise WorkbenchError(f"there is no piece {number}", "scene", f"there are {geometry.piece_count}") from None


def _checked_unit(unit: str) -> str:
    if unit not in UNITS:
        raise OptionError(f"unit is {unit!r}: {near(unit, UNITS)}")
    return unit
