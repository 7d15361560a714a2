"""Replays records of sessions and compares the results bit for bit."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from feeler.arguments import check_path, shown
from feeler.errors import LoadError, MissingFileError, OptionError
from feeler.field_docs import documented
from feeler.haptics.coupling import Coupling
from feeler.haptics.record import ALSO, FORMAT, GRIP, MODES, PUT_BACK, RELEASE, START, digest_of
from feeler.haptics.session import Session, one_part
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene

_READ = (1, 2, 3)  # format 1 has no parts that lie elsewhere from the start; before 3, parts are gripped one at a time


@documented
@dataclass(frozen=True)
class Parted:
    """Whether the steps of a record gave the same results, bit for bit."""

    steps: int
    """Replayed."""
    at: int | None
    """The first step with another result; None: all are equal."""
    by: float
    """The difference of that step, in metres, newtons or newton metres."""

    def __bool__(self) -> bool:
        return self.at is None


def replay(
    path: str | Path,
    scene: Scene | None = None,
    tool: Tool | None = None,
    put_down: Mapping[int, Scene] | Mapping[str, Scene] | None = None,
) -> Parted:
    """Replays the steps of a record, and reports whether the results are equal bit for bit, or where they differ.

    Records of large meshes do not contain them: pass the original `scene` and `tool`, and the parts that lay elsewhere
    (`put_down`, as in `Session`). Raises `LoadError` for files that are not records, and for other meshes.
    """
    for what, given, kind in (("scene", scene, Scene), ("tool", tool, Tool), ("put_down", put_down, Mapping)):
        if given is not None and not isinstance(given, kind):
            wanted = "a dict of parts and scenes" if kind is Mapping else f"a feeler.{kind.__name__}"
            raise OptionError(f"{what} is {shown(given)}: give {wanted}, or None")
    with _opened(check_path("path", path)) as record:
        try:
            head = json.loads(str(record["head"]))
            events, inputs, outputs = record["events"], record["inputs"], record["outputs"]
            if head["format"] not in _READ:
                raise LoadError(f"{path}: format {head['format']}, this feeler reads {FORMAT}")
            # Records from before shading was added have none.
            options, coupling = {"shading": False, **head["options"]}, Coupling(**head["coupling"])
            if "margin" in options:  # its name in records of early builds
                options["within"] = options.pop("margin")
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
        except (KeyError, ValueError, TypeError, BadZipFile, zlib.error) as error:
            if isinstance(error, LoadError):
                raise
            raise LoadError(f"{path} is not a record of a session: {error}") from error
    for what, mesh in (("mockup", scene.mockup), ("tool", tool)):
        if digest_of(mesh) != head[what]:
            raise LoadError(f"{path} was made with another {what}")
    lies = {one_part(scene, part, "put_down"): each for part, each in (put_down or {}).items()}
    if {part: digest_of(each.mockup) for part, each in lies.items()} != lying:
        raise LoadError(f"{path} was made with other parts put down elsewhere: it has parts {sorted(lying)}")
    session = Session(scene, tool, coupling=coupling, put_down={part: lies[part] for part in lying}, **options)
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
        raise MissingFileError(f"{path} does not exist") from error
    except OSError as error:  # a folder, or a file that this user may not read
        raise LoadError(f"{path} cannot be read: {error.strerror}; give a file that Session.record wrote") from error
    with opened:
        try:
            record = np.load(opened, allow_pickle=False)
        except (OSError, ValueError, EOFError, BadZipFile) as error:
            raise LoadError(f"{path} is not a record of a session: give a file that Session.record wrote") from error
        if not isinstance(record, np.lib.npyio.NpzFile):
            raise LoadError(f"{path} is not a record of a session")
        with record:
            yield record


def _mockup_of(record: Any, name: str) -> Mockup:
    vertices, faces, owners = (record[f"{name}.{each}"] for each in ("vertices", "faces", "part_of_face"))
    return Mockup(vertices, faces, owners, record[f"{name}.part_names"].tolist())


def _tool_of(record: Any) -> Tool:
    names = record["tool.part_names"].tolist()
    return Tool(
        record["tool.vertices"], record["tool.faces"], part_of_face=record["tool.part_of_face"], part_names=names
    )
