"""Sessions that run: with a device, in threads of their own, which enter Python only for a device written in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.errors import OptionError, SessionError
from feeler.haptics.coupling import Coupling
from feeler.haptics.devices import Device, Own
from feeler.haptics.record import Recorder

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """One tick of a run, for a picture."""

    number: int
    """Counts the servo's ticks; 0: there was none yet."""
    time: float
    """Seconds on the machine's clock."""
    world_from_proxy: Floats
    """`(4, 4)`: where the mock-up lets the tool be; free by the exact test."""
    world_from_device: Floats
    """`(4, 4)`: where the device wants it."""
    force: Floats
    """`(3,)`: on the hand, newtons, world axes."""
    torque: Floats
    """`(3,)`: on the hand, newton metres, world axes, at the origin of the tool's frame."""
    age: float
    """Of the contact planes, seconds."""
    mode: str
    """As `Step.mode`."""
    buttons: int
    """That are held, a bit each."""
    is_clutched: bool
    """Whether the clutch is held: the handle moves without the tool."""
    points: Floats
    """`(k, 3)`: of the planes that hold the proxy, on the mock-up, metres, world."""
    normals: Floats
    """`(k, 3)`: of the same, unit, from the mock-up to the tool."""
    gaps: Floats
    """`(k,)`: how far the proxy is off them, metres."""
    parts: npt.NDArray[np.uint32]
    """`(k,)`: what is touched: indices into `mockup.parts`."""


@dataclass(frozen=True)
class Distribution:
    """How durations are spread, in seconds, within one per cent."""

    count: int
    mean: float
    median: float
    p90: float
    p99: float
    p999: float
    max: float


@dataclass(frozen=True)
class Statistics:
    """What a run took."""

    servo_lateness: Distribution
    """From when a servo tick was due to when it began."""
    servo_tick: Distribution
    """Of a servo tick, in the thread's own time."""
    age: Distribution
    """Of the contact planes, at the servo's ticks."""
    collision_tick: Distribution
    """Of a search for contacts, with the proxy's motion, in the thread's own time."""
    ticks: int
    """Of the servo."""
    misses: int
    """Servo ticks left out, since the one before was later than a period."""
    doubts: int
    """Servo ticks without force since something was in doubt."""
    device_errors: int
    """Reads and writes that the device refused."""
    sets: int
    """Sets of contact planes handed over."""
    rounds: int
    """Motions that the proxy tried."""
    stopped: int
    """Of these, stopped by the cast."""
    collision_errors: int
    """Searches for contacts that failed."""
    servo_hz: float
    """Ticks a second."""
    collision_hz: float
    """Searches a second. Without news the thread rests, so it could be more: see `collision_tick`."""


@dataclass(frozen=True)
class Granted:
    """What the system and the device allowed a run."""

    priority: str
    """Of the servo thread, or why it has none; empty: it was not asked for."""
    has_priority: bool
    collision_priority: str
    """Of the collision thread, below the servo's, or why it has none; empty: it was not asked for."""
    has_collision_priority: bool
    memory: str
    """What is locked, or why nothing is; empty: it was not asked for."""
    is_locked: bool
    coupling: Coupling
    """In use."""
    limitations: tuple[str, ...]
    """What the device took away of the session's coupling: a sentence a number, with what is left, what was asked for
    and why."""


@dataclass(frozen=True)
class Trace:
    """Every tick of a while."""

    times: Floats
    """`(n,)`: seconds on the machine's clock."""
    world_from_device: Floats
    """`(n, 4, 4)`; the last one told, where the device told none."""
    world_from_proxy: Floats
    """`(n, 4, 4)`."""
    wrenches: Floats
    """`(n, 6)`: force and torque on the hand, as of a `View`."""
    modes: tuple[str, ...]
    has_device: npt.NDArray[np.bool_]
    """`(n,)`: whether the device told something that can be believed."""

    def __len__(self) -> int:
        return len(self.times)


class Runs(_core.HapticsSession):
    """What a session has to run with a device; `Session` is one."""

    _run: _core.HapticsRun | None = None
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
        world_from_device: npt.ArrayLike | None = None,
        absolute: bool | None = None,
        clutch_button: int | None = None,
        realtime: bool = True,
    ) -> None:
        """Runs with a device until `stop()`: a servo thread and a collision thread, at the session's `collision_hz`, or
        as fast as it can.

        - `rate_hz`: of the servo thread.
        - `scale`: how far the tool moves for a metre of the handle.
        - `world_from_device`: which way the device's axes point in the world, default as the world's.
        - `absolute`: the handle's place, by `world_from_device`, is the tool's. Default for a `Mouse`; else the tool
          stays where it is, with the handle where it is, and follows its motions from there.
        - `clutch_button`: number of the button (0 is the first) that lets the handle move without the tool.
        - `realtime`: asks for priority of both threads and locked memory; `granted()` says what came of it.

        The coupling is limited to what the device holds. Steps raise `SessionError` meanwhile; `start`, `grip` and
        `release` are done between two ticks. Raises `SessionError` before the start and while it runs, `DeviceError`
        for a device that is in use, `OptionError`.
        """
        if not isinstance(device, Device):
            raise OptionError(f"a session runs with a device of feeler.haptics.devices, not {type(device).__name__}")
        if self._run is not None:
            raise SessionError("the session runs already: stop it first")
        if self._recorder is not None:
            raise SessionError("a record is of steps: close it before the session runs")
        if isinstance(device, Own):
            device._serve(self)
        pose = np.eye(4) if world_from_device is None else np.array(world_from_device, dtype=np.float64)
        is_absolute = device._is_absolute if absolute is None else bool(absolute)
        self._held = tuple(self._gripped)
        self._run = _core.HapticsRun(
            self, device._device, float(rate_hz), float(scale), pose, is_absolute, clutch_button, bool(realtime)
        )
        self._ended = None

    @property
    def is_running(self) -> bool:
        """Whether both threads are at work."""
        return self._run is not None and self._run.is_running

    def stop(self) -> Statistics | None:
        """Lets go of the force, then ends the threads; the session can be stepped or run again. What the run took.

        A second time, nothing happens, and the same comes back; None where it never ran. Raises `SessionError` where a
        thread of the run failed, after all has ended.
        """
        run = self._run
        if run is None:
            return self._ended
        error, device_error, collision_error = run.stop()
        self._run = None
        self._ended = _statistics(run.statistics())
        self._why = tuple(why for why in (device_error, collision_error) if why)
        if error:
            raise SessionError(error)
        return self._ended

    @property
    def troubles(self) -> list[str]:
        """After a run: why the device, and the search for contacts, failed the last time, if they did."""
        return list(self._why)

    def stats(self) -> Statistics:
        """What the run took up to a tenth of a second ago; after its end, all of it.

        Raises `SessionError` where there was none.
        """
        if self._run is not None:
            return _statistics(self._run.statistics())
        if self._ended is None:
            raise SessionError("the session has not run: call run(device) first")
        return self._ended

    def view(self) -> View:
        """The newest tick. Waits for nothing. Raises `SessionError` where it does not run."""
        facts = self._running().view()
        planes, parts, _ids = facts.pop("held")
        return View(**facts, points=planes[:, :3], normals=planes[:, 3:6], gaps=planes[:, 6], parts=parts)

    def trace(self) -> Trace:
        """Every tick since the last call. There is room for four seconds at 1 kHz: what comes after is not kept."""
        times, devices, proxies, wrenches, modes, has_device = self._running().trace()
        return Trace(times, devices, proxies, wrenches, tuple(modes), has_device)

    def granted(self) -> Granted:
        """What system and device allowed."""
        run = self._running()
        numbers, limitations = run.coupling()
        servo, collision, memory = (said or (False, "") for said in run.granted())
        return Granted(*servo[::-1], *collision[::-1], *memory[::-1], Coupling(*numbers), tuple(limitations))

    def _running(self) -> _core.HapticsRun:
        if self._run is None:
            raise SessionError("the session does not run: call run(device) first")
        return self._run


def _statistics(facts: dict[str, Any]) -> Statistics:
    names = ("servo_lateness", "servo_tick", "age", "collision_tick")
    return Statistics(**{**facts, **{name: Distribution(**facts[name]) for name in names}})
