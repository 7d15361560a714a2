"""Sessions: proxy, coupling and clock, stepped by the caller."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import OptionError, PoseError, SessionError
from feeler.haptics.coupling import Coupling
from feeler.haptics.record import Recorder
from feeler.haptics.running import Runs
from feeler.mockup import Tool
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
MODES = ("free", "contact", "bound", "colliding", "doubt")


@dataclass(frozen=True)
class Planes:
    """The contact planes at the proxy, nearest first."""

    points: Floats
    """`(k, 3)`: on the mock-up, metres, world."""
    normals: Floats
    """`(k, 3)`: unit, from the mock-up to the tool."""
    gaps: Floats
    """`(k,)`: how far the proxy is off, metres."""
    parts: npt.NDArray[np.uint32]
    """`(k,)`: indices into `mockup.parts`."""
    ids: npt.NDArray[np.uint64]
    """`(k,)`: the same for the same two surfaces from step to step."""
    is_holding: npt.NDArray[np.bool_]
    """`(k,)`: whether the plane holds the proxy back."""

    def __len__(self) -> int:
        return len(self.gaps)


@dataclass(frozen=True)
class Step:
    """What one step gives."""

    world_from_proxy: Floats
    """`(4, 4)`: where the mock-up lets the tool be; free by the exact test, and reached by a free motion."""
    force: Floats
    """`(3,)`: on the hand, newtons, world axes."""
    torque: Floats
    """`(3,)`: on the hand, newton metres, world axes, at the origin of the device's frame."""
    planes: Planes
    age: float
    """Of the contact planes, seconds."""
    mode: str
    """What holds the proxy: `free`, `contact`, `bound` (the planes are good for no more: it moves on with the next),
    `colliding` (the session began in collision, and the device is not free yet), `doubt` (the force is let go: the pose
    was not one, or the planes are too old)."""


@dataclass(frozen=True)
class Start:
    """How a session began."""

    is_free: bool
    """False: the tool is in collision there. There is no force until the device is where it is free."""
    way_out: Floats | None
    """`(3,)`: the shortest translation found that frees it, metres, world; None where it is free."""

    def __bool__(self) -> bool:
        return self.is_free


class Session(Runs):
    """A tool held by a device: stepped in one thread, deterministic, its clock the `dt` of each step; or run.

    - `coupling`: how the hand is held to the tool; default `Coupling()`.
    - `margin`: what is nearer than this (metres) is a contact.
    - `skin`: how far the proxy stays off (metres); where the clearance is less than twice that, half of it.
    - `shading`: the force on the facets of a curved surface has the direction that it has on the smooth surface; False:
      that of the facet.
    - `collision_hz`: how often contacts are found, to the nearest step; default: each step.
    - `put_down`: parts that lie elsewhere than in the mock-up from the beginning, as if the session had put them down:
      by part (index, path or pattern that names one), a scene of that part alone, where it lies. Each is felt there,
      can be gripped, and is not where it was.
    - `seed`: for what is random in a session. Nothing is at present; records keep it.

    Raises `OptionError` for values out of range and parts that are not there, `SessionError` for a part that is put
    down twice, or as a scene that is not of one part.
    """

    scene: Scene
    tool: Tool
    coupling: Coupling
    _options: dict[str, Any]
    _put_down: dict[int, Scene]
    _recorder: Recorder | None

    def __new__(
        cls,
        scene: Scene,
        tool: Tool,
        *,
        coupling: Coupling | None = None,
        margin: float = 0.002,
        skin: float = 2e-5,
        shading: bool = True,
        collision_hz: float | None = None,
        seed: int = 0,
        put_down: Mapping[int, Scene] | Mapping[str, Scene] | None = None,
    ) -> Session:
        """See the class."""
        if not isinstance(scene, Scene):
            raise OptionError(f"a session needs a feeler.Scene, not {type(scene).__name__}")
        coupling = coupling or Coupling()
        if not isinstance(coupling, Coupling):
            raise OptionError(f"coupling is a {type(coupling).__name__}: pass a feeler.haptics.Coupling")
        options: dict[str, Any] = {
            "margin": float(margin),
            "skin": float(skin),
            "shading": bool(shading),
            "collision_hz": None if collision_hz is None else float(collision_hz),
            "seed": int(seed),
        }
        lying = [(_one_part(scene, part, "put_down"), alone) for part, alone in (put_down or {}).items()]
        for part, alone in lying:
            if not isinstance(alone, Scene):
                raise OptionError(f"put_down has a {type(alone).__name__} for part {part}: pass a feeler.Scene of it")
        margin, skin, rate = options["margin"], options["skin"], options["collision_hz"]
        shading = options["shading"]
        self = super().__new__(cls, scene, tool, coupling.as_numbers(), margin, skin, shading, rate, lying)
        self.scene, self.tool, self.coupling = scene, tool, coupling
        self._options, self._put_down, self._recorder = options, dict(lying), None
        return self

    def start(self, pose: npt.ArrayLike) -> Start:
        """Begins, or begins anew, with the device at `pose` (`world_from_tool`).

        Where the tool is in collision there the result says so and has the way out; steps give no force until the
        device is where the tool is free. Where parts lie elsewhere, the way out is out of the one of them, or the
        mock-up, that the tool is deepest in. Raises `PoseError` for what is no pose.
        """
        pose = np.array(pose, dtype=np.float64)
        way_out = super().begin(pose) if self._run is None else self._run.begin(pose)
        if self._recorder:
            self._recorder.start(pose)
        return Start(way_out is None, None if way_out is None else np.array(way_out))

    def step(self, world_from_device: npt.ArrayLike, dt: float = 0.001) -> Step:
        """One step of `dt` seconds (above 0, at most 1) with the device at a pose (`world_from_tool`).

        A pose that is not finite or not rigid, as a device may tell it, gives no force and mode `doubt`. Raises
        `PoseError` for the wrong shape, `SessionError` before the start, `OptionError` for a `dt` out of range.
        """
        pose = np.array(world_from_device, dtype=np.float64)
        if pose.shape != (4, 4):
            raise PoseError(f"a pose has shape {pose.shape}: (4, 4) is needed")
        dt = float(dt)
        proxy, force, torque, age, mode = super().advance(pose if _is_rigid(pose) else None, dt)
        numbers, parts, ids, is_holding = super().planes()
        planes = Planes(numbers[:, :3], numbers[:, 3:6], numbers[:, 6], parts, ids, is_holding)
        step = Step(proxy, force, torque, planes, age, mode)
        if self._recorder:
            self._recorder.step(pose, dt, step.world_from_proxy, step.force, step.torque, MODES.index(mode))
        return step

    def grip(self, part: int | str) -> None:
        """Takes a part: it leaves the scene and joins the tool, without a jump of force.

        `part`: index, path or pattern that names one part. A part that was put down elsewhere can be taken again.
        What the part was seated on is not asked until it is off that by a skin; planes of the seat hold it until
        then. Raises `OptionError` for a part that is not there, `SessionError` where one is held already.
        """
        part = _one_part(self.scene, part, "grip")
        if self._run is None:
            super().take(part)
        else:
            self._run.take(part)
            self._held = part
        if self._recorder:
            self._recorder.grip(part)

    def release(self, *, put_back: bool = False) -> None:
        """Lets go of the part that is held: it stays where it is, a part of the scene again.

        `put_back`: it goes back to its place in the mock-up instead. Raises `SessionError` where nothing is held, or
        the tool is in the part's place.
        """
        run = self._run
        if put_back:
            super().put_back() if run is None else run.put_back()
        else:
            super().put_down() if run is None else run.put_down()
        self._held = None
        if self._recorder:
            self._recorder.release(put_back)

    @property
    def gripped(self) -> int | None:
        """The part that is held, by its index in `mockup.parts`."""
        return super().held_part if self._run is None else self._held

    def set_scene(self, scene: Scene) -> Start:
        """Puts another scene in the place of the present one; while the session runs, between two ticks.

        What is held or was put down belongs to the old one, and is gone, but for the parts that the session began with
        (`put_down`): these lie there again. The tool stays where it is; where it is in collision there, there is no
        force until the device is where it is free. Raises `OptionError` where a part that lies elsewhere is none of the
        new mock-up.
        """
        if not isinstance(scene, Scene):
            raise OptionError(f"a session needs a feeler.Scene, not {type(scene).__name__}")
        if self._recorder:
            raise SessionError("a record is of one scene: close it first")
        way_out = super().swap(scene) if self._run is None else self._run.set_scene(scene)
        self.scene, self._held = scene, None
        return Start(way_out is None, None if way_out is None else np.array(way_out))

    def record(self, path: str | Path) -> Recorder:
        """Writes what happens from the next start on into a file, for `replay`; `.close()` or `with` ends it."""
        self._recorder = Recorder(Path(path), self)
        return self._recorder


def _one_part(scene: Scene, part: int | str, where: str) -> int:
    chosen = scene.mockup.parts.select(part)
    if len(chosen) != 1:
        raise OptionError(f"{part!r} names {len(chosen)} parts: {where} takes one")
    return int(chosen[0])


def _is_rigid(pose: Floats) -> bool:
    """As the core judges it: within 1e-6."""
    if not np.isfinite(pose).all() or np.abs(pose[:3, 3]).max() > 1e100:
        return False
    rotation = pose[:3, :3]
    if np.abs(rotation).max() > 2.0:
        return False
    off = max(np.abs(rotation @ rotation.T - np.eye(3)).max(), np.abs(pose[3] - [0, 0, 0, 1]).max())
    return bool(off <= 0.99e-6 and np.linalg.det(rotation) > 0 and math.isfinite(off))
