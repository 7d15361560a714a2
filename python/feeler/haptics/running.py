"""Sessions that run with a device, in threads that enter Python only for a device written in Python."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import check_array, check_flag, check_number, check_whole
from feeler.choices import ProxyMode
from feeler.errors import OptionError, SessionError
from feeler.field_docs import documented
from feeler.haptics.coupling import Coupling
from feeler.haptics.devices import Device, Own
from feeler.haptics.record import Recorder
from feeler.poses import QUERY_DEVIATION, PoseLike, nearest_rigid, one_pose
from feeler.rows import Columns

if TYPE_CHECKING:
    from typing_extensions import Self

Floats = npt.NDArray[np.float64]


@documented
@dataclass(frozen=True, eq=False)
class View:
    """One tick of a run, for display."""

    number: int
    """Number of the servo tick; 0: none yet."""
    time: float
    """Seconds on the machine's clock."""
    world_from_proxy: Floats
    """`(4, 4)`: the proxy, free by the exact test."""
    world_from_device: Floats
    """`(4, 4)`: where the device wants the tool, as `Session.step` is given it."""
    force: Floats
    """`(3,)`: on the hand, newtons, world axes; without the soft wall inside the borders of the device's workspace."""
    torque: Floats
    """`(3,)`: on the hand, newton metres, world axes, about the tool's centre of area."""
    age: float
    """Age of the contact planes, seconds."""
    mode: ProxyMode
    """As `Step.mode`."""
    buttons: int
    """Pressed buttons, a bit each."""
    is_clutched: bool
    """Whether the clutch is pressed: the handle moves without the tool."""
    points: Floats
    """`(k, 3)`: points of the planes that hold the proxy, on the mock-up, metres, world."""
    normals: Floats
    """`(k, 3)`: their normals, unit, from the mock-up to the tool."""
    gaps: Floats
    """`(k,)`: their distances from the proxy, metres."""
    parts: npt.NDArray[np.uint32]
    """`(k,)`: the touched parts, as indices into `mockup.parts`."""


@documented
@dataclass(frozen=True)
class Distribution:
    """The distribution of durations, in seconds, within one per cent."""

    count: int
    """How many values there are."""
    mean: float
    """Their mean."""
    median: float
    """Half of them are no more."""
    p90: float
    """90 % of them are no more."""
    p99: float
    """99 % of them are no more."""
    p999: float
    """99.9 % of them are no more."""
    max: float
    """The largest."""


@documented
@dataclass(frozen=True)
class Statistics:
    """Timings and counts of a run."""

    servo_lateness: Distribution
    """Delay of servo ticks, from the due time to the start."""
    servo_tick: Distribution
    """CPU time of a servo tick."""
    age: Distribution
    """Age of the contact planes at the servo's ticks."""
    collision_tick: Distribution
    """CPU time of a search for contacts, with the proxy's motion."""
    ticks: int
    """Number of servo ticks."""
    misses: int
    """Servo ticks skipped because the previous one was late by more than a period."""
    doubts: int
    """Servo ticks without force because the input was doubtful."""
    device_errors: int
    """Reads and writes that the device refused."""
    sets: int
    """Sets of contact planes sent to the servo."""
    rounds: int
    """Motions of the proxy that were tried."""
    stopped: int
    """Those stopped by the cast."""
    collision_errors: int
    """Searches for contacts that failed."""
    servo_hz: float
    """Ticks per second."""
    collision_hz: float
    """Searches per second. Without new input the thread sleeps; `collision_tick` shows how fast it could be."""


@documented
@dataclass(frozen=True)
class Granted:
    """The privileges and limits that the system and the device granted to a run."""

    priority: str
    """Priority of the servo thread, or why it has none; empty if not requested."""
    has_priority: bool
    """Whether the servo thread has it."""
    collision_priority: str
    """Priority of the collision thread, below the servo's, or why it has none; empty if not requested."""
    has_collision_priority: bool
    """Whether the collision thread has it."""
    memory: str
    """The locked memory, or why none is locked; empty if not requested."""
    is_locked: bool
    """Whether memory is locked."""
    coupling: Coupling
    """In use while servo and device keep their rates; in the tool's world, not the hand's, if `scale` is not 1."""
    limitations: tuple[str, ...]
    """Reductions of the session's coupling because of the device, and at present because the servo or the device is
    slow or late: a sentence per value, with the reduced value, the requested one and the reason."""


@documented
@dataclass(frozen=True, eq=False)  # it holds arrays
class Tick:
    """One tick of the servo: a row of `Trace`."""

    time: float
    """Seconds on the machine's clock."""
    world_from_device: Floats
    """`(4, 4)`; the last known one if the device reported none."""
    world_from_proxy: Floats
    """`(4, 4)`."""
    wrench: Floats
    """`(6,)`: force and torque on the hand."""
    mode: ProxyMode
    """What the proxy does."""
    has_device: bool
    """Whether the device reported a valid pose."""


@documented
@dataclass(frozen=True, eq=False)
class Trace(Columns[Tick]):
    """All ticks of a period. `trace[i]` is a `Tick`; slices are traces."""

    _ROW = Tick

    times: Floats
    """`(n,)`: seconds on the machine's clock."""
    world_from_device: Floats
    """`(n, 4, 4)`; the last known one where the device reported none."""
    world_from_proxy: Floats
    """`(n, 4, 4)`."""
    wrenches: Floats
    """`(n, 6)`: force and torque on the hand, as in `View`."""
    modes: tuple[ProxyMode, ...]
    """What the proxy does in each row."""
    has_device: npt.NDArray[np.bool_]
    """`(n,)`: whether the device reported a valid pose."""


class Runs(_core.HapticsSession):
    """The part of a session that runs with a device; `Session` derives from it."""

    _run: _core.HapticsRun | None = None
    _rest: Trace | None = None
    _ended: Statistics | None = None
    _held: tuple[int, ...] = ()
    _why: tuple[str, ...] = ()
    _recorder: Recorder | None = None

    def run(
        self,
        device: Device,
        *,
        rate_hz: float = 1000.0,
        scale: float = 1.0,
        world_from_device: PoseLike | None = None,
        absolute: bool | None = None,
        clutch_button: int | None = None,
        realtime: bool = True,
    ) -> None:
        """Runs with a device until `stop()`: a servo thread and a collision thread, at the session's `collision_hz`, or
        as fast as possible.

        - `rate_hz`: of the servo thread, 50 to 100000.
        - `scale`: travel of the tool for a metre of the handle.
        - `world_from_device`: rotation of the device's axes into the world; default: none.
        - `absolute`: the handle's pose, by `world_from_device`, is the tool's, though a device with force turns the
          tool about its centre of area. Default for a `Mouse`; otherwise the tool starts where it is, whatever the
          pose of the handle, and follows its motions.
        - `clutch_button`: number of the button (0 is the first) that lets the handle move without the tool.
        - `realtime`: requests priority for both threads and locked memory; `granted()` reports the outcome.

        The coupling is limited to values that the device can hold. During the run, `step` raises `SessionError`;
        `start`, `grip` and `release` take effect between two ticks. Raises `SessionError` before the start and during a
        run, `DeviceError` for a device in use, `OptionError`.
        """
        if not isinstance(device, Device):
            raise OptionError(f"a session runs with a device of feeler.haptics.devices, not {type(device).__name__}")
        if self._run is not None:
            raise SessionError("the session runs already: stop it first")
        if self._recorder is not None:
            raise SessionError("a record is of steps: close it before the session runs")
        handle = np.eye(4) if world_from_device is None else one_pose(world_from_device, "world_from_device")
        pose = nearest_rigid(handle, QUERY_DEVIATION)
        is_absolute = device._is_absolute if absolute is None else check_flag("absolute", absolute)
        rate = check_number("rate_hz", rate_hz, "a rate, more than 0", above=0.0)
        ratio = check_number("scale", scale, "a number, more than 0", above=0.0)
        clutch = None if clutch_button is None else check_whole("clutch_button", clutch_button, 0, 31)
        is_realtime = check_flag("realtime", realtime)
        if isinstance(device, Own):
            device._serve(self)
        self._held = tuple(self._gripped)
        self._run = _core.HapticsRun(self, device._device, rate, ratio, pose, is_absolute, clutch, is_realtime)
        self._ended = self._rest = None

    def guide(self, world_from_tool: PoseLike | None, pull: npt.ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Draws the hand softly to a pose while the session runs, such as the nearest place of a way.

        - `world_from_tool`: the place to draw it to, at the tool's centre of area; turns do not count. None: ends it.
        - `pull`: `(3,)`, newtons, world axes: a pull besides, such as along the way.

        Call it again at least every 0.1 s: without news there is no force, and none in doubt. The force is at most 1.5
        N, and less where contact needs the device's whole force; contact stays what it is. Raises `PoseError`,
        `OptionError`, and `SessionError` if the session does not run.
        """
        place = None if world_from_tool is None else nearest_rigid(one_pose(world_from_tool), QUERY_DEVIATION)
        self._running().guide(place, check_array("pull", pull, (3,)).tolist())

    @property
    def is_running(self) -> bool:
        """Whether both threads are running."""
        return self._run is not None and self._run.is_running

    def stop(self) -> Statistics | None:
        """Releases the force, then ends the threads; the session can be stepped or run again. Returns the statistics.

        A second call returns the same; None if the session never ran. Raises `SessionError` if a thread of the run
        failed, after all have ended.
        """
        run = self._run
        if run is None:
            return self._ended
        end = run.stop()
        self._run, self._rest = None, _trace(run.trace())
        self._ended = _statistics(run.statistics())
        self._why = tuple(why for why in (end.device_error, end.collision_error) if why)
        if end.error:
            raise SessionError(end.error)
        return self._ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Ends `with session:` as `stop()` does."""
        self.stop()

    @property
    def troubles(self) -> list[str]:
        """After a run: the last failure of the device, and of the search for contacts, if any."""
        return list(self._why)

    def stats(self) -> Statistics:
        """The statistics of the run up to a tenth of a second ago; after its end, all of it.

        Raises `SessionError` if there was no run.
        """
        if self._run is not None:
            return _statistics(self._run.statistics())
        if self._ended is None:
            raise SessionError("the session has not run: call run(device) first")
        return self._ended

    def view(self) -> View:
        """The newest tick, without waiting. Raises `SessionError` if the session does not run."""
        return View(**_facts(View, self._running().view()))

    def trace(self) -> Trace:
        """All ticks since the last call; after the end of the run, those that are left.

        The buffer holds four seconds at 1 kHz; later ticks are dropped. Raises `SessionError` if the session has not
        run.
        """
        rest = self._rest
        if self._run is not None or rest is None:
            return _trace(self._running().trace())
        self._rest = Trace(**{each.name: getattr(rest, each.name)[:0] for each in fields(Trace)})
        return rest

    def granted(self) -> Granted:
        """What the system and the device granted."""
        facts = _facts(Granted, self._running().granted())
        return Granted(
            **{**facts, "coupling": Coupling(*facts["coupling"]), "limitations": tuple(facts["limitations"])}
        )

    def _running(self) -> _core.HapticsRun:
        if self._run is None:
            raise SessionError("the session does not run: call run(device) first")
        return self._run


def _trace(answer: _core.TraceAnswer) -> Trace:
    facts = _facts(Trace, answer)
    return Trace(**{**facts, "modes": tuple(facts["modes"])})


def _statistics(answer: _core.StatisticsAnswer) -> Statistics:
    facts = _facts(Statistics, answer)
    durations = ("servo_lateness", "servo_tick", "age", "collision_tick")
    return Statistics(**{**facts, **{name: Distribution(**_facts(Distribution, facts[name])) for name in durations}})


def _facts(kind: type, answer: object) -> dict[str, Any]:
    """The fields of a dataclass, from an answer of the core that has them by the same names."""
    return {each.name: getattr(answer, each.name) for each in fields(kind)}
