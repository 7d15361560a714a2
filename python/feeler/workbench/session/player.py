"""Plays a record in a session with pages: at the recorded speed, from any moment, any number of times.

The first replay, or the first jump, repeats the whole record exactly and notes the document after each command. From
then on every moment can be shown at once: that document, with the hand at its recorded pose.
"""

from __future__ import annotations

import time
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from feeler.errors import LoadError
from feeler.mockup import Mockup, Tool
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.answers import Gap, RecordStep, RecordTimeline
from feeler.workbench.document.document import Document, RecordFacts
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.values import is_number
from feeler.workbench.engine.gaps import gap_json
from feeler.workbench.session.record import Record
from feeler.workbench.session.replaying import Replay, Replayed, check_meshes, sentence
from feeler.workbench.session.session import Session

LONGEST_REST_S = 0.5
"""Pauses of a record are cut to this."""
TOLD_S = 0.1
"""Pages are told so often how far a replay is."""
MOST_GAPS = 200
"""Moments of a record at which the gap is looked for."""
_TITLES = {
    "place": "Move",
    "seat": "Seat the tool",
    "release": "Put down",
    "way_take": "Take a way",
    "sequence_replay": "Replay a removal",
    "set_mode": "Contact mode",
    "section_add": "Cut",
    "section_move": "Move a cut",
    "section_switch": "Cut on or off",
    "section_remove": "Delete a cut",
    "section_box_switch": "Section box on or off",
    "section_box_remove": "Delete the section box",
    "measure_add": "Measure",
    "measure_edit": "Change a measure",
    "measure_remove": "Delete a measure",
    "viewpoint_add": "Keep a viewpoint",
    "viewpoint_show": "Cuts of a viewpoint",
    "viewpoint_remove": "Delete a viewpoint",
    "sequence_rename": "Rename a removal",
    "sequence_move": "Reorder removals",
    "sequence_remove": "Delete a removal",
    "findings_take": "Findings",
    "finding_mark": "Mark findings",
    "finding_status": "Mark a finding",
    "clash_settings": "Settings of the clash check",
}


class _Moment(NamedTuple):
    """After an entry: the document, and the pose of the hand."""

    entry: int
    document: Document
    pose: Floats


@dataclass
class _Known:
    """What an exact replay found: the documents, gaps by time, and the last entry that gave the same."""

    moments: list[_Moment]
    gaps: list[Gap]
    end: int


class Player:
    """See the module."""

    def __init__(
        self,
        record: Record,
        session: Session,
        mockup: Mockup,
        scene: Scene,
        tool: Tool | None,
        *,
        name: str | None = None,
    ) -> None:
        """Opens the session at the record's start, and offers the record. Raises `LoadError` for other meshes."""
        check_meshes(record, scene, tool)
        self._record, self._session = record, session
        self._meshes = (mockup, scene, tool, name)
        self._facts = RecordFacts(record.path.name)
        self._ats = _moments_of(record)
        self._known: _Known | None = None
        Replay(record, session).open(*self._meshes)
        session.offer(self._facts, self)

    @property
    def seconds(self) -> float:
        """The length of a replay at the recorded speed."""
        return self._ats[-1]

    def timeline(self) -> RecordTimeline:
        """The commands of the record over time, and the gaps that the last replay found."""
        gaps = [] if self._known is None else self._known.gaps
        return {"seconds": self.seconds, "steps": self._steps(), "gaps": gaps}

    def play(self, progress: Progress, start: float | None = None, speed: float = 1.0) -> dict[str, Any]:
        """Replays to the end, or to a difference: {"is_same", "verdict"}.

        start: seconds; None: from the start, and exactly. From elsewhere the recorded poses are shown.
        """
        with self._session.replaying():
            try:
                self._tell(is_playing=True)
                if start is None:
                    self._go_through(progress, speed)
                else:
                    self._show_from(start, speed, progress)
            finally:
                self._tell(is_playing=False)
        return {"is_same": self._facts.is_same, "verdict": self._facts.verdict}

    def seek(self, progress: Progress, at: float) -> dict[str, Any]:
        """Shows the moment at some seconds of the replay: {"is_same", "verdict"}, as of `play`."""
        with self._session.replaying():
            known = self._knowledge(progress)
            self._show(min(self._entry_at(at), known.end), known)
        return {"is_same": self._facts.is_same, "verdict": self._facts.verdict}

    # ---- the exact replay ----

    def _knowledge(self, progress: Progress) -> _Known:
        if self._known is None:
            try:
                self._tell(is_playing=True)
                self._go_through(progress, None)
            finally:
                self._tell(is_playing=False)
        assert self._known is not None
        return self._known

    def _go_through(self, progress: Progress, speed: float | None) -> None:
        """Repeats the record exactly. speed: None: without pauses."""
        session, entries = self._session, self._record.entries
        self._tell(is_same=None, verdict=None)
        gone = Replay(self._record, session)
        gone.open(*self._meshes)
        known = _Known([_Moment(0, session.current, session.engine.pose)], [], 0)
        told = float("-inf")
        every = self.seconds / MOST_GAPS
        for number, _ in gone.steps():
            # What the entry before came to: this one follows.
            self._note(number - 1, known, every)
            if speed is not None:
                time.sleep((self._ats[number] - self._ats[number - 1]) / speed)
            if time.monotonic() - told > TOLD_S:
                told = time.monotonic()
                progress(number / len(entries), "replay" if speed is not None else "reading the record")
                if speed is not None:
                    self._tell(at=self._ats[number - 1])
        found = gone.found
        known.end = len(entries) if found.parted is None else found.parted.entry - 1
        if found.parted is None:
            self._note(known.end, known, every)
        self._known = known
        self._ended(found, known)

    def _ended(self, found: Replayed, known: _Known) -> None:
        self._tell(at=self._ats[known.end], is_same=bool(found), verdict=sentence(found), has_gaps=bool(known.gaps))

    def _note(self, number: int, known: _Known, every: float) -> None:
        """Notes the state after an entry."""
        if number == 0:
            return
        session = self._session
        entry = self._record.entries[number - 1]
        if entry.get("kind") == "command":
            known.moments.append(_Moment(number, session.current, session.engine.pose))
        share = self._ats[number] / self.seconds if self.seconds > 0.0 else 0.0
        last = known.gaps[-1]["share"] if known.gaps else -1.0
        if self.seconds > 0.0 and (share - last) * self.seconds >= every:
            known.gaps.append(gap_json(share, session.engine.nearest()))

    # ---- showing moments ----

    def _show_from(self, start: float, speed: float, progress: Progress) -> None:
        known = self._knowledge(progress)
        self._tell(is_playing=True)
        first = min(self._entry_at(start), known.end)
        self._show(first, known)
        begun = told = time.monotonic()
        for number in range(first + 1, known.end + 1):
            due = begun + (self._ats[number] - self._ats[first]) / speed
            now = time.monotonic()
            is_late = now > due
            time.sleep(max(0.0, due - now))
            # Behind time, only commands are shown.
            if not is_late or self._record.entries[number - 1].get("kind") == "command":
                self._show(number, known, is_told=False)
            if time.monotonic() - told > TOLD_S:
                told = time.monotonic()
                progress(number / known.end, "replay")
                self._tell(at=self._ats[number])
        self._show(known.end, known)

    def _show(self, number: int, known: _Known, *, is_told: bool = True) -> None:
        """Shows the state after an entry. is_told: the last one for now: pages are told where it is."""
        moment = known.moments[bisect_right(known.moments, number, key=lambda each: each.entry) - 1]
        pose = wish = moment.pose
        for entry in reversed(self._record.entries[moment.entry : number]):
            if entry.get("kind") == "tick":
                pose, wish = motion.matrix(entry["pose"]), motion.matrix(entry["wish"])
                break
        self._session.show_moment(moment.document, pose, wish, is_last=is_told)
        if is_told:
            self._tell(at=self._ats[number])

    def _entry_at(self, at: float) -> int:
        """The last entry at some seconds, or before; 0: the start."""
        return bisect_right(self._ats, at + 1e-9) - 1

    def _tell(self, **facts: Any) -> None:
        self._facts = replace(self._facts, **facts)
        self._session.show_record(self._facts)

    def _steps(self) -> list[RecordStep]:
        steps: list[RecordStep] = []
        entries = self._record.entries
        start = _time(entries[0]) if entries else 0.0
        for number, entry in enumerate(entries, start=1):
            if entry.get("kind") == "command":
                passed = max(0.0, _time(entry) - start)
                steps.append({"at": self._ats[number], "time": passed, "title": self._title(entry)})
        return steps

    def _title(self, entry: dict[str, Any]) -> str:
        """A command in words: "Grip pump and 2 more"."""
        name, args = str(entry.get("name")), entry.get("args")
        title = _TITLES.get(name, name.replace("_", " ").capitalize())
        given = args.get("parts") if isinstance(args, dict) else None
        parts = given if isinstance(given, list) else [] if given is None else [given]
        if parts:
            names = self._meshes[0].part_names
            first = parts[0]
            is_part = isinstance(first, int) and 0 <= first < len(names)
            title += f" {names[first] if is_part else str(first).rpartition('/')[2]}"
            title += f" and {len(parts) - 1} more" if len(parts) > 1 else ""
        return f"{title} (refused)" if "error" in entry else title


def _moments_of(record: Record) -> list[float]:
    """Seconds of a replay after each entry, after 0 of the start: as recorded, with long pauses cut."""
    ats, before = [0.0], None
    for entry in record.entries:
        now = _time(entry)
        ats.append(ats[-1] + (0.0 if before is None else min(LONGEST_REST_S, max(0.0, now - before))))
        before = now
    return ats


def _time(entry: dict[str, Any]) -> float:
    time = entry.get("time", 0.0)
    if not is_number(time):
        raise LoadError(f"an entry of the record has the time {time!r:.40}")
    return float(time)
