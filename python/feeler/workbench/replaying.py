"""A record gone through again, without a page: the same hits to the last triangle, or where they part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from feeler.errors import FeelerError, LoadError
from feeler.mockup import Mockup, Tool
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench import motion
from feeler.workbench.engine import Ticked
from feeler.workbench.record import Record, digest, document_digest, hits_digest
from feeler.workbench.session import Session

_MOST_IDS = 20


@dataclass(frozen=True)
class Parted:
    """The first entry that came out otherwise. entry: its number in the record, from 1, without the header."""

    entry: int
    what: str
    missing: tuple[int, ...] = ()
    """Triangles of the mock-up that met then, and not now; the first of them."""
    added: tuple[int, ...] = ()


@dataclass(frozen=True)
class Replayed:
    """What came of a record; true where all of it came out the same.

    ticks, commands: gone through. hits: ticks at which something met. most_hits: triangles of the mock-up at the worst.
    touched: ids of all parts that were met.
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


def check_meshes(record: Record, mockup: Mockup, tool: Tool | None) -> None:
    """Raises `LoadError` where a record was made with another mock-up or tool."""
    facts: Any = record.header.get("mockup")
    if not isinstance(facts, dict) or facts.get("hash") != digest(mockup):
        made = facts if isinstance(facts, dict) else {}
        raise LoadError(
            f"{record.path} was made with another mock-up: {made.get('name')!r}, {made.get('triangles')} triangles in "
            f"{made.get('parts')} parts; this one has {mockup.triangle_count} in {mockup.part_count}"
        )
    held: Any = record.header.get("tool")
    if (held is None) != (tool is None) or (tool is not None and held.get("hash") != digest(tool)):
        name = held.get("name") if isinstance(held, dict) else None
        raise LoadError(f"{record.path} was made with {'no tool' if held is None else f'another tool, {name!r}'}")


def replay(
    record: Record, mockup: Mockup, scene: Scene, tool: Tool | None, progress: Progress = lambda share, stage: None
) -> Replayed:
    """Does again what a record has: every command, and every wish that was used. Raises `LoadError`.

    What `stop` and `pass` decide is exact, and so is the proxy of `glide` with the steps that it was recorded with.
    """
    check_meshes(record, mockup, tool)
    with Session(has_threads=False, clock=lambda: 0.0) as session:
        try:
            options = record.header["options"]
            session.open(mockup, scene, tool, pose=record.header["pose"], mode=options["mode"])
            if options["unit"] != session.current.unit:
                session.command("set_unit", {"unit": options["unit"]})
            return _Replay(record, session).run(progress)
        except (KeyError, TypeError, ValueError) as error:
            if isinstance(error, FeelerError):
                raise
            raise LoadError(f"{record.path} is no record this feeler can read: {error!r}") from None


class _Replay:
    def __init__(self, record: Record, session: Session) -> None:
        self._record, self._session = record, session
        self._recorded: set[int] = set()
        self._ticks = self._commands = self._hits = self._most = 0
        self._touched: set[int] = set()

    def run(self, progress: Progress) -> Replayed:
        entries = self._record.entries
        parted: Parted | None = None
        for number, entry in enumerate(entries, start=1):
            if number % 100 == 0:
                progress(number / len(entries), "replay")
            kind = entry["kind"]
            if kind == "tick":
                parted = self._tick(number, entry)
            elif kind == "command":
                parted = self._command(number, entry)
            elif kind == "let_go":
                self._session.engine.let_go()
            if parted is not None:
                break
        touched = tuple(sorted(self._touched))
        return Replayed(self._ticks, self._commands, self._hits, self._most, touched, self._record.is_torn, parted)

    def _tick(self, number: int, entry: dict[str, Any]) -> Parted | None:
        wish = np.array(entry["wish"], dtype=np.float64).reshape(4, 4)
        ticked = self._session.engine.replayed(wish, int(entry["seq"]), str(entry["source"]), int(entry["steps"]))
        self._ticks += 1
        self._hits += bool(ticked.hits)
        self._most = max(self._most, len(ticked.hits.mockup_triangles))
        self._touched.update(ticked.hits.parts)
        self._recorded = (self._recorded | set(entry["came"])) - set(entry["went"])
        return self._compared(number, entry, ticked)

    def _compared(self, number: int, entry: dict[str, Any], ticked: Ticked) -> Parted | None:
        then, now = self._recorded, set(ticked.hits.mockup_triangles.tolist())
        missing, added = sorted(then - now)[:_MOST_IDS], sorted(now - then)[:_MOST_IDS]
        if missing or added:
            return Parted(number, "other triangles of the mock-up meet", tuple(missing), tuple(added))
        if hits_digest(ticked.hits) != entry["hits"]:
            return Parted(number, "the same triangles of the mock-up meet others of the tool, or meet them otherwise")
        if motion.row(ticked.pose) != tuple(entry["pose"]):
            off = float(np.abs(np.subtract(motion.row(ticked.pose), entry["pose"])).max())
            return Parted(number, f"the hand comes elsewhere, by {off:.3g}")
        return None

    def _command(self, number: int, entry: dict[str, Any]) -> Parted | None:
        self._commands += 1
        trouble: str | None = None
        try:
            self._session.command(entry["name"], entry["args"])
        except FeelerError as error:
            trouble = str(error)
        if (trouble is None) != ("error" not in entry):
            said = trouble or "it is done, and was refused then"
            return Parted(number, f"the command {entry['name']} ends otherwise: {said}")
        if trouble is None and document_digest(self._session.current) != entry["document"]:
            return Parted(number, f"after the command {entry['name']} the document is another")
        return None
