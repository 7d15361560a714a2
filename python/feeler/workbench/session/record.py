"""Records of a session: JSON lines, each written as a whole, so that a crash leaves a readable record.

The first line is the header. The others, in order, are commands with a digest of the resulting document, and rounds of
the engine that changed something, with the wish, the hand's pose, and the collisions. Triangles are written as the
changes since the previous round.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from feeler._core import Collision
from feeler.errors import LoadError, MissingFileError, WorkbenchError
from feeler.io.text import decoded
from feeler.mockup import Mockup, Tool
from feeler.workbench.document import motion
from feeler.workbench.document.document import Document
from feeler.workbench.engine.engine import Ticked
from feeler.workbench.engine.world import NO_HITS

FORMAT = 1


def digest(mesh: Mockup | Tool) -> str:
    """Digest of a mesh: vertices, faces and parts, names included; hex."""
    found = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces, mesh.part_of_face):
        found.update(np.ascontiguousarray(array).data)
    found.update("\0".join(mesh.part_paths).encode("utf-8", "surrogatepass"))
    return found.hexdigest()


def is_recorded(document: Document, digest: str) -> bool:
    """Whether a digest in a record is that of the document: of this version, or of one whose viewpoints had no cuts."""
    return digest == document_digest(document) or (
        bool(document.viewpoints) and digest == document_digest(document, has_viewpoint_cuts=False)
    )


def document_digest(document: Document, *, has_viewpoint_cuts: bool = True) -> str:
    """Digest of everything that commands can change; hex."""
    facts = dict(document.to_json())
    for name in ("mockup", "loading", "failed", "tools", "record", "project", "absent", "cards", "joint_ranges"):
        del facts[name]
    # As in records of versions without them.
    for name in ("section_box", "mechanism", "on_joint"):
        if facts[name] is None:
            del facts[name]
    lines = document.to_json()["sequence"]
    facts["sequence"] = [{k: v for k, v in line.items() if k != "joint" or v is not None} for line in lines]
    if not has_viewpoint_cuts:
        cuts = ("sections", "section_box")
        views = document.to_json()["viewpoints"]
        facts["viewpoints"] = [{name: value for name, value in each.items() if name not in cuts} for each in views]
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def hits_digest(hits: Collision) -> str:
    """Digest of the colliding pairs of triangles, and their kinds; hex."""
    found = hashlib.sha256(np.ascontiguousarray(hits.pairs, dtype="<i8").data)
    found.update(np.ascontiguousarray(hits.kind_codes, dtype=np.uint8).data)
    return found.hexdigest()[:32]


class Recorder:
    """Writes a record. Thread-safe. After the first disk error it stops writing, and `trouble` has the reason."""

    def __init__(self, path: Path) -> None:
        """Raises `WorkbenchError` if the file cannot be written."""
        self.path = path
        self.trouble: str | None = None
        self._lock = threading.Lock()
        self._before = NO_HITS.mockup_triangles
        try:
            self._file = path.open("w", encoding="utf-8", newline="\n")
        except OSError as error:
            what = f"{path} cannot be written: {error.strerror or error}"
            raise WorkbenchError(what, "record", "give another file") from None

    def header(self, facts: dict[str, Any]) -> None:
        """The first line."""
        self._write({"kind": "header", "format": FORMAT, **facts})

    def command(self, time: float, name: str, args: Any, after: Document | None, error: str | None) -> None:
        """A command, and the document after it; or its error."""
        result = {"error": error} if after is None else {"document": document_digest(after), "pose": list(after.pose)}
        self._write({"kind": "command", "time": time, "name": name, "args": args, **result})

    def let_go(self, time: float) -> None:
        """The hand was released."""
        self._write({"kind": "let_go", "time": time})

    def ticked(self, ticked: Ticked) -> None:
        """A round of the engine."""
        now = ticked.hits.mockup_triangles
        self._write(
            {
                "kind": "tick",
                "time": ticked.time,
                "seq": ticked.seq,
                "source": ticked.source,
                "mode": ticked.mode,
                "steps": ticked.steps,
                "wish": motion.row(ticked.wish),
                "pose": motion.row(ticked.pose),
                "hits": hits_digest(ticked.hits),
                "came": np.setdiff1d(now, self._before, assume_unique=True).tolist(),
                "went": np.setdiff1d(self._before, now, assume_unique=True).tolist(),
                "parts": ticked.hits.parts.tolist(),
            }
        )
        self._before = now

    def close(self) -> None:
        """Ends the record; a second call does nothing."""
        with self._lock:
            self._file.close()

    def _write(self, entry: dict[str, Any]) -> None:
        with self._lock:
            if self.trouble is not None or self._file.closed:
                return
            try:
                # A line at once, flushed out of this process: a crash loses nothing.
                self._file.write(json.dumps(entry, separators=(",", ":"), allow_nan=False) + "\n")
                self._file.flush()
            except (OSError, ValueError) as error:
                self.trouble = f"{self.path}: {error}"


@dataclass(frozen=True)
class Record:
    """The content of a record. is_torn: its last line was cut off, as by a crash, and is ignored."""

    path: Path
    header: dict[str, Any]
    entries: tuple[dict[str, Any], ...]
    is_torn: bool


def read_record(path: str | Path) -> Record:
    """Reads a record. Raises `MissingFileError`, and `LoadError` for other files, and for errors before the end."""
    file = Path(path)
    try:
        data = decoded(file.read_bytes())
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give a record of feeler view --record") from None
    except OSError as error:
        raise LoadError(f"{file} cannot be read: {error.strerror or error}") from None
    lines = data.split(b"\n")
    rest = lines.pop()
    entries, is_torn = [], bool(rest.strip())
    for number, entry in _entries(file, lines):
        if entry is None:
            if number < len(lines):
                raise LoadError(f"{file}, line {number} is broken, and not the last: the record cannot be trusted")
            is_torn = True
        else:
            entries.append(entry)
    if not entries or entries[0].get("kind") != "header":
        raise LoadError(f"{file} is not a record of a session: its first line is not a header")
    header = entries[0]
    if header.get("format") != FORMAT:
        raise LoadError(f"{file} has format {header.get('format')!r}: this feeler reads {FORMAT}")
    return Record(file, header, tuple(entries[1:]), is_torn)


def _entries(file: Path, lines: list[bytes]) -> Iterator[tuple[int, dict[str, Any] | None]]:
    for number, line in enumerate(lines, start=1):
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            entry = None
        yield number, entry if isinstance(entry, dict) else None
