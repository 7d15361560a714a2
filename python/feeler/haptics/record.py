"""Records of sessions: the input from the device, and the results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.atomic import atomic_file
from feeler.haptics.coupling import Coupling
from feeler.mockup import Mockup, Tool
from feeler.scene import Scene

FORMAT = 3
KEPT_TRIANGLES = 200_000
"""A record contains mock-up and tool up to this many triangles; for larger ones pass scene and tool to `replay`."""

# Events: a step, a start, a grip, a release, a release that puts back; a further part of the next grip.
STEP, START, GRIP, RELEASE, PUT_BACK, ALSO = range(6)
MODES = ("free", "contact", "bound", "colliding", "doubt")
"""Modes by number; `colliding` occurs only in records of format 1 and 2."""
Floats = npt.NDArray[np.float64]


class Recorder:
    """Collects the events of a session, and writes them when it is closed."""

    def __init__(
        self,
        path: Path,
        scene: Scene,
        tool: Tool,
        coupling: Coupling,
        options: Mapping[str, Any],
        put_down: Mapping[int, Scene],
        ended: Callable[[], None],
    ) -> None:
        """A recorder for these. ended: called once, before the file is written."""
        self.path = path
        self._session = (scene, tool, coupling, options, put_down)
        self._ended: Callable[[], None] | None = ended
        self._events: list[tuple[int, int]] = []
        self._inputs: list[Floats] = []
        self._outputs: list[Floats] = []

    @property
    def is_begun(self) -> bool:
        """Whether it has a start, without which nothing can be replayed."""
        return bool(self._events)

    def start(self, pose: Floats) -> None:
        """A start with the device at a pose."""
        self._add(START, 0, pose, 0.0)

    def step(self, pose: Floats, dt: float, proxy: Floats, force: Floats, torque: Floats, mode: int) -> None:
        """A step and its results."""
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
        """Writes the file; further calls do nothing. Raises `WriteError`."""
        ended, self._ended = self._ended, None
        if ended is None:
            return
        ended()
        scene, tool, coupling, options, put_down = self._session
        mockup = scene.mockup
        lying = {part: alone.mockup for part, alone in put_down.items()}
        head = {
            "format": FORMAT,
            "options": options,
            "coupling": asdict(coupling),
            "mockup": digest_of(mockup),
            "tool": digest_of(tool),
            "put_down": [[part, digest_of(each)] for part, each in lying.items()],
        }
        meshes: dict[str, Any] = {}
        count = len(mockup.faces) + len(tool.faces) + sum(len(each.faces) for each in lying.values())
        if count <= KEPT_TRIANGLES:
            meshes = {**_arrays("mockup", mockup), **_arrays("tool", tool)}
            for part, each in lying.items():
                meshes |= _arrays(f"put_down.{part}", each)
        with atomic_file(self.path, ".npz") as file:
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


def digest_of(mesh: Mockup | Tool) -> str:
    """A hash of triangles and parts: equal for equal meshes."""
    digest = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces, mesh.part_of_face):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _arrays(name: str, mesh: Mockup | Tool) -> dict[str, Any]:
    return {
        f"{name}.vertices": mesh.vertices,
        f"{name}.faces": mesh.faces,
        f"{name}.part_of_face": mesh.part_of_face,
        f"{name}.part_names": np.array(list(mesh.part_names) or [""]),
    }
