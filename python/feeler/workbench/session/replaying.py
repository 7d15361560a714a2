"""Replays a record without a page, and compares the collisions to the last triangle."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from feeler.errors import FeelerError, LoadError
from feeler.mockup import Mockup, Tool
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.engine.engine import Ticked
from feeler.workbench.engine.geometry import absent_parts
from feeler.workbench.session.record import Record, digest, hits_digest, is_recorded
from feeler.workbench.session.session import Session

_MOST_IDS = 20


@dataclass(frozen=True)
class Parted:
    """The first entry with another result. entry: its number in the record, from 1, without the header."""

    entry: int
    what: str
    missing: tuple[int, ...] = ()
    """Triangles of the mock-up that collided then, and do not now; the first of them."""
    added: tuple[int, ...] = ()


@dataclass(frozen=True)
class Replayed:
    """The result of a replay; true if all entries gave the same.

    ticks, commands: replayed ones. hits: ticks with a collision. most_hits: the most triangles of the mock-up at once.
    touched: ids of all colliding parts.
    """

    ticks: int
    commands: int
    hits: int
    most_hits: int
    touched: tuple[int, ...]
    is_torn: bool
    parted: Parted | None

    def __bool__(self) -> bool:
        return self.parted is None


def check_meshes(record: Record, scene: Scene, tool: Tool | None) -> None:
    """Raises `LoadError` if a record was made with another mock-up or tool, or with other parts excluded."""
    mockup = scene.mockup
    facts: Any = record.header.get("mockup")
    if not isinstance(facts, dict) or facts.get("hash") != digest(mockup):
        made = facts if isinstance(facts, dict) else {}
        raise LoadError(
            f"{record.path} was made with another mock-up: {made.get('name')!r}, {made.get('triangles')} triangles in "
            f"{made.get('parts')} parts; this one has {mockup.triangle_count} in {mockup.part_count}"
        )
    # Older records lack this value: their replay differs at the entry where it matters.
    absent = facts.get("absent", list(absent_parts(scene)))
    if absent != list(absent_parts(scene)):
        raise LoadError(f"{record.path} was made with other parts left out: {_difference(absent, scene)}")
    held: Any = record.header.get("tool")
    if (held is None) != (tool is None) or (tool is not None and held.get("hash") != digest(tool)):
        name = held.get("name") if isinstance(held, dict) else None
        raise LoadError(f"{record.path} was made with {'no tool' if held is None else f'another tool, {name!r}'}")


def _difference(absent: Any, scene: Scene) -> str:
    then, now = set(absent) if isinstance(absent, list) else set(), set(absent_parts(scene))
    told = []
    for word, parts in (("only then", then - now), ("only now", now - then)):
        known = sorted(part for part in parts if isinstance(part, int) and 0 <= part < scene.mockup.part_count)
        if known:
            more = f" and {len(known) - 1} more" if len(known) > 1 else ""
            told.append(f"{scene.mockup.part_paths[known[0]]}{more} {word}")
    return f"{', '.join(told) or 'it is broken'}; give --without and --only as then"


def replay(
    record: Record, mockup: Mockup, scene: Scene, tool: Tool | None, progress: Progress = lambda share, stage: None
) -> Replayed:
    """Repeats a record: every command, and every wish that was used. Raises `LoadError`.

    The results of `stop` and `pass` are exact, and so is the proxy of `glide` with the recorded steps.
    """
    check_meshes(record, scene, tool)
    with Session(has_threads=False, clock=lambda: 0.0) as session:
        gone = Replay(record, session)
        gone.open(mockup, scene, tool)
        for number, _ in gone.steps():
            if number % 100 == 0:
                progress(number / len(record.entries), "replay")
        return gone.found


class Replay:
    """A record, and a session that replays it."""

    def __init__(self, record: Record, session: Session) -> None:
        self._record, self._session = record, session
        self._recorded: set[int] = set()
        self._ticks = self._commands = self._hits = self._most = 0
        self._touched: set[int] = set()
        self._parted: Parted | None = None

    def open(self, mockup: Mockup, scene: Scene, tool: Tool | None, name: str | None = None) -> None:
        """Starts as the record does. Raises `LoadError`."""
        with self._readable():
            header = self._record.header
            unit, mode = header["options"]["unit"], header["options"]["mode"]
            self._session.open(mockup, scene, tool, pose=header["pose"], mode=mode, unit=unit, name=name)

    def steps(self) -> Iterator[tuple[int, float]]:
        """Replays entries up to a difference; yields the number and the time (s) of each before it.

        Raises `LoadError`.
        """
        for number, entry in enumerate(self._record.entries, start=1):
            yield number, float(entry.get("time", 0.0))
            with self._readable():
                self._parted = self._step(number, entry)
            if self._parted is not None:
                return

    @property
    def found(self) -> Replayed:
        """The result so far."""
        touched = tuple(sorted(self._touched))
        return Replayed(
            self._ticks, self._commands, self._hits, self._most, touched, self._record.is_torn, self._parted
        )

    @contextmanager
    def _readable(self) -> Iterator[None]:
        try:
            yield
        except (KeyError, TypeError, ValueError) as error:
            if isinstance(error, FeelerError):
                raise
            raise LoadError(f"{self._record.path} is not a record that this feeler can read: {error!r}") from None

    def _step(self, number: int, entry: dict[str, Any]) -> Parted | None:
        kind = entry["kind"]
        if kind == "tick":
            return self._tick(number, entry)
        if kind == "command":
            return self._command(number, entry)
        if kind == "let_go":
            self._session.engine.let_go()
        return None

    def _tick(self, number: int, entry: dict[str, Any]) -> Parted | None:
        wish = np.array(entry["wish"], dtype=np.float64).reshape(4, 4)
        ticked = self._session.replayed(wish, int(entry["seq"]), str(entry["source"]), int(entry["steps"]))
        self._ticks += 1
        self._hits += bool(ticked.hits)
        self._most = max(self._most, len(ticked.hits.mockup_triangles))
        self._touched.update(ticked.hits.parts.tolist())
        self._recorded = (self._recorded | set(entry["came"])) - set(entry["went"])
        return self._compared(number, entry, ticked)

    def _compared(self, number: int, entry: dict[str, Any], ticked: Ticked) -> Parted | None:
        then, now = self._recorded, set(ticked.hits.mockup_triangles.tolist())
        missing, added = sorted(then - now)[:_MOST_IDS], sorted(now - then)[:_MOST_IDS]
        if missing or added:
            return Parted(number, "other triangles of the mock-up collide", tuple(missing), tuple(added))
        if hits_digest(ticked.hits) != entry["hits"]:
            return Parted(
                number, "the same triangles of the mock-up collide, but with others of the tool or in another way"
            )
        if motion.row(ticked.pose) != tuple(entry["pose"]):
            off = float(np.abs(np.subtract(motion.row(ticked.pose), entry["pose"])).max())
            return Parted(number, f"the hand comes elsewhere, by {off:.3g}")
        return None

    def _command(self, number: int, entry: dict[str, Any]) -> Parted | None:
        self._commands += 1
        trouble: str | None = None
        try:
            self._session.command(entry["name"], entry["args"], is_recorded=True)
        except FeelerError as error:
            trouble = str(error)
        if (trouble is None) != ("error" not in entry):
            said = trouble or "it is done, and was refused then"
            return Parted(number, f"the command {entry['name']} ends otherwise: {said}")
        if trouble is None and not is_recorded(self._session.current, entry["document"]):
            return Parted(number, f"after the command {entry['name']} the document is another")
        return None


def sentence(found: Replayed) -> str:
    """The result of a replay, for people."""
    if found.parted is None:
        return f"The same hits to the last triangle: {found.ticks:,} rounds, {found.commands:,} commands."
    text = f"It parts at entry {found.parted.entry}: {found.parted.what}."
    for word, ids in (("No longer", found.parted.missing), ("Now", found.parted.added)):
        if ids:
            text += f" {word}: triangles {', '.join(map(str, ids))}."
    return text
