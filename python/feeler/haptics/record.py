"""Records of sessions: what the device did, what came of it, and whether the same comes of it again."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from feeler.errors import LoadError
from feeler.haptics.coupling import Coupling
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene

if TYPE_CHECKING:
    from feeler.haptics.session import Session

FORMAT = 3
_READ = (1, 2, 3)  # in 1 no parts lie elsewhere from the beginning; before 3 one part is gripped at a time
KEPT_TRIANGLES = 200_000
"""Up to so many triangles of mock-up and tool a record has them with it; beyond, `replay` is given scene and tool."""

# What happened: a step, a start, a grip, a release, a release that puts back; a part that the next grip takes, too.
STEP, START, GRIP, RELEASE, PUT_BACK, ALSO = range(6)
Floats = npt.NDArray[np.float64]


class Recorder:
    """Keeps what happens in a session, and writes it when it is closed."""

    def __init__(self, path: Path, session: Session) -> None:
        self.path = path
        self._session: Session | None = session
        self._events: list[tuple[int, int]] = []
        self._inputs: list[Floats] = []
        self._outputs: list[Floats] = []

    def start(self, pose: Floats) -> None:
        """A start with the device at a pose."""
        self._add(START, 0, pose, 0.0)

    def step(self, pose: Floats, dt: float, proxy: Floats, force: Floats, torque: Floats, mode: int) -> None:
        """A step and what came of it."""
        self._add(STEP, mode, pose, dt)
        self._outputs.append(np.concatenate([proxy.ravel(), force, torque]))

    def grip(self, parts: Sequence[int]) -> None:
        """A grip."""
        for part in parts[:-1]:
            self._add(ALSO, part, np.eye(4), 0.0)
        self._add(GRIP, parts[-1], np.eye(4), 0.0)

    def release(self, put_back: bool) -> None:
        """A release."""
        self._add(PUT_BACK if put_back else RELEASE, 0, np.eye(4), 0.0)

    def _add(self, kind: int, number: int, pose: Floats, dt: float) -> None:
        self._events.append((kind, number))
        self._inputs.append(np.append(pose.ravel(), dt))

    def close(self) -> None:
        """Writes the file; a second time does nothing."""
        session, self._session = self._session, None
        if session is None:
            return
        session._recorder = None
        mockup, tool = session.scene.mockup, session.tool
        lying = {part: scene.mockup for part, scene in session._lying.items()}
        head = {
            "format": FORMAT,
            "options": session._options,
            "coupling": asdict(session.coupling),
            "mockup": _digest(mockup),
            "tool": _digest(tool),
            "put_down": [[part, _digest(each)] for part, each in lying.items()],
        }
        meshes: dict[str, Any] = {}
        count = len(mockup.faces) + len(tool.faces) + sum(len(each.faces) for each in lying.values())
        if count <= KEPT_TRIANGLES:
            meshes = {**_arrays("mockup", mockup), **_arrays("tool", tool)}
            for part, each in lying.items():
                meshes |= _arrays(f"put_down.{part}", each)
        with self.path.open("wb") as file:
            np.savez_compressed(
                file,
                head=np.array(json.dumps(head)),
                events=np.array(self._events, dtype=np.int64).reshape(-1, 2),
                inputs=np.array(self._inputs).reshape(-1, 17),
                outputs=np.array(self._outputs).reshape(-1, 22),
                **meshes,
            )

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


@dataclass(frozen=True)
class Parted:
    """Whether the steps of a record came out the same, bit for bit."""

    steps: int
    """Replayed."""
    at: int | None
    """The first step that came out otherwise; None: all are the same."""
    by: float
    """By how much that one did, in metres, newtons or newton metres."""

    def __bool__(self) -> bool:
        return self.at is None


def replay(
    path: str | Path,
    scene: Scene | None = None,
    tool: Tool | None = None,
    put_down: Mapping[int, Scene] | None = None,
) -> Parted:
    """Runs the steps of a record again, and says whether they come out the same bit for bit, or where they part.

    A record of large meshes has none with it: pass the `scene` and the `tool` it was made with, and the parts that lay
    elsewhere (`put_down`, as of `Session`). Raises `LoadError` for what is no record, or of other meshes.
    """
    from feeler.haptics.session import MODES, Session

    with _opened(Path(path)) as record:
        try:
            head = json.loads(str(record["head"]))
            events, inputs, outputs = record["events"], record["inputs"], record["outputs"]
            if head["format"] not in _READ:
                raise LoadError(f"{path}: format {head['format']}, this feeler reads {FORMAT}")
            # A record from before there was shading has none.
            options, coupling = {"shading": False, **head["options"]}, Coupling(**head["coupling"])
            lying = {int(part): str(digest) for part, digest in head.get("put_down", [])}
            has_meshes = "tool.faces" in record
            if scene is None or tool is None:
                if not has_meshes:
                    raise LoadError(f"{path} has no meshes with it: pass the scene and the tool it was made with")
                scene, tool = Scene(_mockup_of(record, "mockup")), _tool_of(record)
            if put_down is None and lying:
                if not has_meshes:
                    raise LoadError(f"{path} has no meshes with it: pass put_down, the parts that lay elsewhere")
                put_down = {part: Scene(_mockup_of(record, f"put_down.{part}")) for part in lying}
            put_down = put_down or {}
        except (KeyError, ValueError, TypeError, BadZipFile, zlib.error) as error:
            if isinstance(error, LoadError):
                raise
            raise LoadError(f"{path} is no record of a session: {error}") from error
    for what, mesh in (("mockup", scene.mockup), ("tool", tool)):
        if _digest(mesh) != head[what]:
            raise LoadError(f"{path} was made with another {what}")
    if {part: _digest(each.mockup) for part, each in put_down.items()} != lying:
        raise LoadError(f"{path} was made with other parts put down elsewhere: it has parts {sorted(lying)}")
    session = Session(scene, tool, coupling=coupling, put_down={part: put_down[part] for part in lying}, **options)
    steps = 0
    also: list[int] = []
    for (kind, number), row in zip(events.tolist(), inputs, strict=True):
        pose = row[:16].reshape(4, 4)
        if kind == START:
            session.start(pose)
        elif kind == ALSO:
            also.append(number)
        elif kind == GRIP:
            session.grip([*also, number])
            also = []
        elif kind in (RELEASE, PUT_BACK):
            session.release(put_back=kind == PUT_BACK)
        else:
            step = session.step(pose, float(row[16]))
            now = np.concatenate([step.world_from_proxy.ravel(), step.force, step.torque])
            if not np.array_equal(now, outputs[steps]) or MODES.index(step.mode) != number:
                return Parted(steps + 1, steps, float(np.abs(now - outputs[steps]).max()))
            steps += 1
    return Parted(steps, None, 0.0)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        opened = path.open("rb")
    except FileNotFoundError as error:
        raise LoadError(f"{path}: no such file") from error
    with opened:
        try:
            record = np.load(opened, allow_pickle=False)
        except (OSError, ValueError, EOFError, BadZipFile) as error:
            raise LoadError(f"{path} is no record of a session: {error}") from error
        if not isinstance(record, np.lib.npyio.NpzFile):
            raise LoadError(f"{path} is no record of a session")
        with record:
            yield record


def _arrays(name: str, mesh: Mockup | Tool) -> dict[str, Any]:
    return {
        f"{name}.vertices": mesh.vertices,
        f"{name}.faces": mesh.faces,
        f"{name}.part_of_face": mesh.part_of_face,
        f"{name}.part_names": np.array(list(mesh.part_names) or [""]),
    }


def _mockup_of(record: Any, name: str) -> Mockup:
    vertices, faces, owners = (record[f"{name}.{each}"] for each in ("vertices", "faces", "part_of_face"))
    return Mockup(vertices, faces, owners, record[f"{name}.part_names"].tolist())


def _tool_of(record: Any) -> Tool:
    names = record["tool.part_names"].tolist()
    return Tool(
        record["tool.vertices"], record["tool.faces"], part_of_face=record["tool.part_of_face"], part_names=names
    )


def _digest(mesh: Mockup | Tool) -> str:
    digest = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces, mesh.part_of_face):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
