"""Sessions: proxy, coupling and clock, stepped by the caller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import check_flag, check_number, check_real, check_whole, shown
from feeler.atomic import check_target
from feeler.choices import ProxyMode, SeatKind
from feeler.errors import OptionError, SessionError
from feeler.field_docs import documented
from feeler.haptics.coupling import Coupling
from feeler.haptics.record import MODES, Recorder
from feeler.haptics.running import Runs
from feeler.mockup import Tool
from feeler.poses import PoseLike, one_pose
from feeler.renamed import keywords
from feeler.rows import Columns
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Plane:
    """A contact plane at the proxy: a row of `Planes`."""

    point: Floats
    """`(3,)`: on the mock-up, metres, world."""
    normal: Floats
    """`(3,)`: unit, from the mock-up to the tool."""
    gap: float
    """Distance of the proxy, metres."""
    part: int
    """Index into `mockup.parts`."""
    id: int
    """Identifies the pair of surfaces, the same from step to step."""
    is_holding: bool
    """Whether the plane holds the proxy."""


@documented
@dataclass(frozen=True, eq=False)
class Planes(Columns[Plane]):
    """The contact planes at the proxy, nearest first. `planes[i]` is a `Plane`; slices are tables."""

    _ROW = Plane

    points: Floats
    """`(k, 3)`: on the mock-up, metres, world."""
    normals: Floats
    """`(k, 3)`: unit, from the mock-up to the tool."""
    gaps: Floats
    """`(k,)`: distance of the proxy, metres."""
    parts: npt.NDArray[np.uint32]
    """`(k,)`: indices into `mockup.parts`."""
    ids: npt.NDArray[np.uint64]
    """`(k,)`: identify the pair of surfaces, the same from step to step."""
    is_holding: npt.NDArray[np.bool_]
    """`(k,)`: whether the plane holds the proxy."""


@documented
@dataclass(frozen=True, eq=False)
class Step:
    """The result of one step."""

    world_from_proxy: Floats
    """`(4, 4)`: the proxy; free by the exact test except for seats, and reached by a free motion."""
    force: Floats
    """`(3,)`: on the hand, newtons, world axes."""
    torque: Floats
    """`(3,)`: on the hand, newton metres, world axes, about the tool's centre of area, where the hand holds it."""
    planes: Planes
    age: float
    """Age of the contact planes, seconds."""
    mode: ProxyMode
    """The proxy's constraint: `free`, `contact`, `bound` (it reached the limit of the planes and moves on with the next
    ones), `doubt` (no force: the pose was invalid, or the planes are too old)."""


@documented
@dataclass(frozen=True)
class Seat:
    """A part of the tool and one of the mock-up in contact at the start of a session: how its parts may move."""

    part: int
    """Index into `mockup.parts`."""
    tool_part: int
    """Index into `tool.parts`."""
    kind: SeatKind
    """`touching`: at most 1 um apart, or 0.5 um deep. `fit`: deeper, up to 2 % of the tool's size, such as press fits
    and parts that overlap by their facets. `sunk`: deeper still, such as a bolt in a plate without a hole."""
    depth: float
    """How far the surfaces of the tool's part must move inwards, each along its normal, until the two parts are free,
    metres; found to 7 %. It limits how deep the pair may go, and is not the penetration depth, `Scene.depth`: of a bolt
    that goes through a plate it can be 0."""


@documented
@dataclass(frozen=True, eq=False)
class Start:
    """The start of a session; true unless the tool is sunk.

    Parts in contact at the start are seats: the tool may slide along them and separate, but not move deeper. A sunk
    part leaves through the space that it fills. All other surfaces collide as usual.
    """

    seats: tuple[Seat, ...]
    way_out: Floats | None
    """`(3,)`: the shortest translation found that frees the tool, metres, world; None unless it is sunk. It is a place
    without contact, not a way there: the session lets a sunk part leave only through the volume that it filled."""

    @property
    def is_free(self) -> bool:
        """Whether the tool has no contact there."""
        return not self.seats

    def __bool__(self) -> bool:
        return self.way_out is None


class Session(Runs):
    """A tool held by a device: stepped in one thread, deterministic, with the `dt` of each step as clock; or run.

    - `coupling`: between the device and the tool; default `Coupling()`.
    - `within`: surfaces nearer than this (metres, above 0) are contacts.
    - `skin`: the distance that the proxy keeps (metres, above 0); half the clearance if that is less.
    - `shading`: the force on the facets of a curved surface has the direction of the smooth surface; False: that of the
      facet.
    - `collision_hz`: rate of the search for contacts, to the nearest step; default: each step.
    - `put_down`: parts that lie elsewhere than in the mock-up from the start, as if the session had put them down: a
      dict from part (index, path or pattern that names one) to a scene of that part alone, at its new place. Each is
      felt there, can be gripped, and is absent from its old place.
    - `seed`: reserved for random choices; records keep it. There are none at present.

    Raises `OptionError` for values out of range and parts that do not exist, `SessionError` for a part put down twice,
    or as a scene that is not of one part.
    """

    scene: Scene
    tool: Tool
    coupling: Coupling
    _options: dict[str, Any]
    _lying: dict[int, Scene]
    _recorder: Recorder | None
    _displaced: set[int]

    @keywords({"margin": "within"})
    def __new__(
        cls,
        scene: Scene,
        tool: Tool,
        *,
        coupling: Coupling | None = None,
        within: float = 0.002,
        skin: float = 2e-5,
        shading: bool = True,
        collision_hz: float | None = None,
        seed: int = 0,
        put_down: Mapping[int, Scene] | Mapping[str, Scene] | None = None,
    ) -> Session:
        """See the class."""
        if not isinstance(scene, Scene):
            raise OptionError(f"a session needs a feeler.Scene, not {type(scene).__name__}")
        coupling = Coupling() if coupling is None else coupling
        if not isinstance(coupling, Coupling):
            raise OptionError(f"coupling is a {type(coupling).__name__}: pass a feeler.haptics.Coupling")
        options: dict[str, Any] = {
            "within": check_number("within", within, "metres, above 0", above=0.0),
            "skin": check_number("skin", skin, "metres, above 0", above=0.0),
            "shading": check_flag("shading", shading),
            "collision_hz": None if collision_hz is None else check_real("collision_hz", collision_hz),
            "seed": check_whole("seed", seed, 0, 2**64 - 1),
        }
        if put_down is not None and not isinstance(put_down, Mapping):
            raise OptionError(f"put_down is {shown(put_down)}: give a dict of parts and scenes")
        lying = [(one_part(scene, part, "put_down"), alone) for part, alone in (put_down or {}).items()]
        for part, alone in lying:
            if not isinstance(alone, Scene):
                raise OptionError(f"put_down has a {type(alone).__name__} for part {part}: pass a feeler.Scene of it")
        within, skin, rate = options["within"], options["skin"], options["collision_hz"]
        shading = options["shading"]
        self = super().__new__(cls, scene, tool, coupling.as_numbers(), within, skin, shading, rate, lying)
        self.scene, self.tool, self.coupling = scene, tool, coupling
        self._options, self._lying, self._recorder = options, dict(lying), None
        self._displaced = set()
        return self

    @keywords({"pose": "world_from_tool"})
    def start(self, world_from_tool: PoseLike) -> Start:
        """Starts, or restarts, with the device at this pose `(4, 4)`.

        Contacts at that pose are seats, and force acts from the first step on. If parts lie elsewhere, the way out
        frees the tool from the one body that it is deepest in. Raises `PoseError` for an invalid pose.
        """
        pose = one_pose(world_from_tool)
        started = super()._begin(pose) if self._run is None else self._run.start(pose)
        if self._recorder:
            self._recorder.start(pose)
        return _start_of(started)

    @keywords({"world_from_device": "world_from_tool"})
    def step(self, world_from_tool: PoseLike, dt: float = 0.001) -> Step:
        """One step of `dt` seconds (above 0, at most 1).

        `world_from_tool`: where the device wants the tool, `(4, 4)`; the proxy is where contacts let it be. A pose that
        is not finite or not rigid, as a device may report, gives no force and mode `doubt`. Raises
        `PoseError` for the wrong shape, `SessionError` before the start, also that of a record, `OptionError` for a
        `dt` out of range.
        """
        self._check_begun()
        pose = one_pose(world_from_tool)
        dt = check_real("dt", dt, "seconds, above 0, at most 1")
        made = super()._advance(pose, dt)
        planes = Planes(made.points, made.normals, made.gaps, made.parts, made.ids, made.is_holding)
        step = Step(made.world_from_proxy, made.force, made.torque, planes, made.age, made.mode)
        if self._recorder:
            self._recorder.step(pose, dt, step.world_from_proxy, step.force, step.torque, MODES.index(step.mode))
        return step

    def grip(self, parts: int | str | Sequence[int | str]) -> None:
        """Takes a part, or several as one: they leave the scene and join the tool, without a jump of force.

        Each is an index, path or pattern that names one part. Parts that were put down elsewhere can be taken again.
        Contacts of the tool and its parts at this moment are seats, as at the start. Raises `OptionError` for parts
        that do not exist, none, or one twice, `SessionError` if a part is already held, or before a record's start.
        """
        self._check_begun()
        each = [parts] if isinstance(parts, int | str) or not isinstance(parts, Sequence) else parts
        chosen = [one_part(self.scene, part, "grip") for part in each]
        if not chosen or len(set(chosen)) < len(chosen):
            raise OptionError(f"{parts!r} names {'a part twice' if chosen else 'no part'}: give each once")
        if self._run is None:
            super()._grip(chosen)
        else:
            self._run.grip(chosen)
            self._held = tuple(chosen)
        self._displaced.update(chosen)
        if self._recorder:
            self._recorder.grip(chosen)

    def release(self, *, put_back: bool = False) -> None:
        """Releases the held parts: they stay where they are, as parts of the scene.

        `put_back`: they return to their place in the mock-up instead. Raises `SessionError` if nothing is held, or the
        tool occupies a part's place, or before the start of a record.
        """
        put_back = check_flag("put_back", put_back)
        self._check_begun()
        run, held = self._run, self.gripped
        if run is None:
            super()._release(put_back)
        else:
            run.release(put_back)
        self._held = ()
        if put_back:
            self._displaced.difference_update(held)
        if self._recorder:
            self._recorder.release(put_back)

    @property
    def gripped(self) -> tuple[int, ...]:
        """The held parts, as indices into `mockup.parts`."""
        return tuple(super()._gripped) if self._run is None else self._held

    def set_scene(self, scene: Scene) -> Start:
        """Replaces the scene; while the session runs, between two ticks.

        Parts held or put down belong to the old scene and are gone, except those given as `put_down` at the beginning,
        which lie there again. The tool stays where it is; its contacts there are seats. Raises `OptionError` if a part
        that lies elsewhere does not exist in the new mock-up, `SessionError` during a record, which is of one scene.
        """
        if not isinstance(scene, Scene):
            raise OptionError(f"a session needs a feeler.Scene, not {type(scene).__name__}")
        if self._recorder:
            raise SessionError("a record is of one scene: close it first")
        started = super()._swap(scene) if self._run is None else self._run.set_scene(scene)
        self.scene, self._held = scene, ()
        self._displaced.clear()
        return _start_of(started)

    def record(self, path: str | Path) -> Recorder:
        """Records into a file, from the next start on, for `replay`; `.close()` or `with` ends it.

        A session that is started already waits for that start: until then it takes no step. The name ends in .npz.
        Raises `WriteError`, and `SessionError` while another record is open, or a part is held or lies where this
        session put it, since a record begins with the scene as the session got it.
        """
        target = check_target(path, ".npz")
        if self._recorder:
            raise SessionError(f"a record into {shown(self._recorder.path.name)} is open: close it first")
        if self._displaced:
            names = ", ".join(shown(self.scene.mockup.parts[part].path) for part in sorted(self._displaced)[:3])
            raise SessionError(f"{names} left its place before the record: put it back, or make a new session")
        self._recorder = Recorder(
            target,
            self.scene,
            self.tool,
            self.coupling,
            self._options,
            self._lying,
            self._end_of_record,
        )
        return self._recorder

    def _check_begun(self) -> None:
        if self._recorder and not self._recorder.is_begun:
            raise SessionError("the record begins with a start: call start() first")

    def _end_of_record(self) -> None:
        self._recorder = None


def _start_of(started: _core.StartAnswer) -> Start:
    seats = tuple(Seat(each.part, each.tool_part, each.kind, each.depth) for each in started.seats)
    return Start(seats, started.way_out)


def one_part(scene: Scene, part: int | str, where: str) -> int:
    """The index of the only part of this name. Raises `OptionError` for none and several."""
    chosen = scene.mockup.parts.select(part)
    if len(chosen) != 1:
        raise OptionError(f"{part!r} names {len(chosen)} parts: {where} takes one")
    return int(chosen[0])
