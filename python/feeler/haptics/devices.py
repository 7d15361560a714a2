"""Haptic devices: simulated, mouse, your own, or opened by the name of a driver.

    device = feeler.haptics.devices.Simulated("desktop_6dof", hand=(times, poses))
    device = feeler.haptics.open_device("haply")

A device's own frame has its origin in the middle of its workspace, x to the right, y away from the user, z up.
"""

from __future__ import annotations

import atexit
import contextlib
import weakref
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import (
    check_array,
    check_flag,
    check_number,
    check_real,
    check_text,
    check_whole,
    check_word,
    shown,
)
from feeler.choices import DEVICE_FAULTS, DEVICE_PRESETS, HAND_GRIPS, DeviceDriver, DeviceFault, DevicePreset, HandGrip
from feeler.errors import DeviceError, OptionError
from feeler.figures import DeviceLimits
from feeler.poses import PoseLike

PRESETS = DEVICE_PRESETS
FAULTS = DEVICE_FAULTS


class Device:
    """The base of all devices. `Simulated`, `Mouse` and `open_device` make one; subclass `Own` for another."""

    _device: _core.HapticsDevice
    _is_absolute = False

    @property
    def name(self) -> str:
        """Maker and model, or the name that the device reports."""
        return self._device.name

    @property
    def sensed(self) -> tuple[str, ...]:
        """The degrees of freedom that it measures, of `translation` and `rotation`."""
        return tuple(self._device.sensed)

    @property
    def driven(self) -> tuple[str, ...]:
        """The degrees of freedom that it actuates, of the same: without `rotation` it gets force without torque."""
        return tuple(self._device.driven)

    @property
    def workspace(self) -> tuple[float, float, float]:
        """Half the edges of the box that its handle can reach, metres; 0: not known."""
        x, y, z = self._device.workspace
        return x, y, z

    @property
    def buttons(self) -> int:
        """Number of buttons."""
        return self._device.button_count

    @property
    def limits(self) -> DeviceLimits:
        """The limits of the device: `force_n`, `torque_nm`, `stiffness_n_per_m`, `damping_n_s_per_m`, `friction_n`,
        `resolution_m`, the same four in rotation, `rate_hz` and `delay_s`. 0: none, or not known.
        """
        return DeviceLimits(**self._device.limits)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.name}>"

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be pickled or copied: make one where it is used")


class Simulated(Device):
    """A simulated device: mass, friction, encoders, delays, and a hand that holds it.

    - `preset`: `desktop_3dof` (12 N, no torque), `desktop_6dof` (12 N, 0.4 Nm) or `large_6dof` (60 N, 3 Nm).
    - `hand`: `(times, poses)`: the target of the hand, `device_from_handle` `(n, 4, 4)`, metres, at times `(n,)`,
      seconds since the first run began, interpolated linearly. None: the device is not held.
    - `grip`: the stiffness of that hand, `firm` or `loose`.
    - `delay_s`: of the measured pose and of the force, half each; `jitter_s`: the most by which each half grows at
      random; `seed`: of the jitter.
    - `fault`: `(kind, value, from_s, until_s)`: a temporary fault, to test how the force reacts. `nan`: its velocity is
      NaN; `nonsense`, `lost`: it reports that fault; `silent`: it reports nothing new; `jump`: it is `value` metres
      higher; `slow`: it reports `value` poses per second.

    Raises `OptionError` and `PoseError`.
    """

    def __init__(
        self,
        preset: DevicePreset = "desktop_6dof",
        *,
        hand: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        grip: HandGrip = "firm",
        delay_s: float = 0.0,
        jitter_s: float = 0.0,
        seed: int = 0,
        fault: tuple[DeviceFault, float, float, float] | None = None,
    ) -> None:
        """See the class."""
        times, poses = (None, None) if hand is None else _hand(hand)
        delay = check_number("delay_s", delay_s, "seconds, 0 or more", least=0.0)
        self._device = _core.HapticsDevice.simulated(
            check_word("preset", preset, PRESETS),
            times,
            poses,
            check_word("grip", grip, HAND_GRIPS),
            [0.5 * delay, 0.5 * delay, check_number("jitter_s", jitter_s, "seconds, 0 or more", least=0.0)],
            check_whole("seed", seed, 0, 2**64 - 1),
            None if fault is None else _fault(fault),
        )


def _hand(hand: object) -> tuple[list[float], Any]:
    if not isinstance(hand, (tuple, list)) or len(hand) != 2:
        raise OptionError(f"hand is {shown(hand)}: give a pair of times (n,) and poses (n, 4, 4)")
    return check_array("the times of hand", hand[0], (None,)).tolist(), hand[1]


def _fault(fault: object) -> tuple[str, float, float, float]:
    if not isinstance(fault, (tuple, list)) or len(fault) != 4:
        raise OptionError(f"fault is {shown(fault)}: give (kind, value, from_s, until_s)")
    kind, value, begin, end = fault
    numbers = {"value": value, "from_s": begin, "until_s": end}
    value, begin, end = (check_real(f"fault: {name}", each) for name, each in numbers.items())
    return check_word("fault: kind", kind, FAULTS), value, begin, end


class Mouse(Device):
    """A device that follows a target smoothly: a tool on the mouse pointer of a window. It has no actuators.

    Its frame is the world's: the tool is at the target. `pose`: the start, `world_from_tool`; `frequency`: natural
    frequency of the smoothing, radians per second, 1 to 1000; the delay is `2 / frequency` seconds.
    """

    _is_absolute = True

    def __init__(self, pose: PoseLike, *, frequency: float = 40.0) -> None:
        """See the class."""
        self._device = _core.HapticsDevice.mouse(
            pose, check_number("frequency", frequency, "radians per second, 1 to 1000", least=1.0, most=1000.0)
        )

    def set_target(self, pose: PoseLike) -> None:
        """Sets the target, `world_from_tool`; also while a session runs."""
        self._device.set_target(pose)

    def set_buttons(self, buttons: int) -> None:
        """Sets the pressed buttons, a bit each."""
        self._device.set_buttons(check_whole("buttons", buttons, 0, 2**32 - 1))


_LIMITS = (
    "force_n",
    "torque_nm",
    "stiffness_n_per_m",
    "rotational_stiffness_nm_per_rad",
    "damping_n_s_per_m",
    "rotational_damping_nm_s_per_rad",
    "friction_n",
    "rotational_friction_nm",
    "resolution_m",
    "rotational_resolution_rad",
    "rate_hz",
    "delay_s",
)


@dataclass(frozen=True)
class Info:
    """The properties of your own device. Unknown values stay 0, and limit nothing.

    Raises `OptionError` for an empty name, values below 0 and a workspace without size.
    """

    name: str
    force_n: float = 0.0
    """Largest force; 0: translation is not actuated."""
    torque_nm: float = 0.0
    """Largest torque; 0: rotation is not actuated."""
    workspace: tuple[float, float, float] | None = None
    """Half the edges of the box that its handle can reach, metres: a soft wall begins at 90 % of them, and pushes with
    at most half of `force_n`. None: not known, no wall."""
    senses_rotation: bool = False
    buttons: int = 0
    stiffness_n_per_m: float = 0.0
    """Largest stable value in a loop of 1 kHz without delay. Without `damping_n_s_per_m`, it falls in proportion in
    slower loops, and with `delay_s`."""
    rotational_stiffness_nm_per_rad: float = 0.0
    damping_n_s_per_m: float = 0.0
    """Its own viscous damping: limits the stiffness (Colgate)."""
    rotational_damping_nm_s_per_rad: float = 0.0
    friction_n: float = 0.0
    """Coulomb friction: limits the stiffness, with the resolution (Abbott and Okamura)."""
    rotational_friction_nm: float = 0.0
    resolution_m: float = 0.0
    """Smallest step of the measured position."""
    rotational_resolution_rad: float = 0.0
    rate_hz: float = 0.0
    """Rate at which it reports poses and takes forces. During a run the stiffness follows the measured rate."""
    delay_s: float = 0.0
    """From a motion of the handle to the force in response, beyond half a period."""

    def __post_init__(self) -> None:
        if not check_text("name", self.name):
            raise OptionError("name is empty: give the name of the device")
        check_flag("senses_rotation", self.senses_rotation)
        check_whole("buttons", self.buttons, 0, 32)
        if self.workspace is not None and (check_array("workspace", self.workspace, (3,)) <= 0.0).any():
            raise OptionError(f"workspace is {shown(self.workspace)}: give three lengths in metres, more than 0")
        for name in _LIMITS:
            check_number(name, getattr(self, name), "a number, 0 or more", least=0.0)


class Own(Device):
    """Your own device: subclass it, set `info`, and write `read` and `write`. See `examples/own_device.py`.

    The servo thread calls both at its rate. For each call it enters Python and may have to wait for other Python
    threads, up to 5 ms each (`sys.setswitchinterval`). Keep both methods short, and do not block in them; 200 to 1000
    Hz is possible while the main thread sleeps. An exception in them releases the force and ends the run: `stop()`
    raises `SessionError` with it.
    """

    info: Info
    _runs: weakref.ref[Any] | None = None

    def read(self) -> Any:
        """Returns the pose of the handle, in the device's frame: a position `(3,)` in metres or a pose `(4, 4)`, alone
        or as `(pose, buttons)`, a bit a button. None: no new pose; after 50 ms without one there is no force.
        Do not return an old pose again instead: the stiffness follows the rate of new poses.
        """
        raise NotImplementedError

    def write(self, force: npt.NDArray[np.float64], torque: npt.NDArray[np.float64]) -> None:
        """Sets force `(3,)`, newtons, and torque `(3,)`, newton metres, on the hand, in the device's frame; they never
        exceed `info`.
        """
        raise NotImplementedError

    def release(self) -> None:
        """Releases the force; called whenever a run ends. Default: writes zeros."""
        self.write(np.zeros(3), np.zeros(3))

    @property
    def _device(self) -> _core.HapticsDevice:  # type: ignore[override]
        what = getattr(self, "info", None)
        if not isinstance(what, Info):
            raise OptionError(f"{type(self).__name__}.info is {what!r}: set it to a feeler.haptics.devices.Info")
        limits = [float(getattr(what, name)) for name in _LIMITS]
        workspace = [float(half) for half in what.workspace or (0.0, 0.0, 0.0)]
        return _core.HapticsDevice.own(
            self, str(what.name), bool(what.senses_rotation), workspace, int(what.buttons), limits
        )

    def _read(self) -> tuple[npt.NDArray[np.float64], int] | None:
        """In the form that the core takes."""
        told = self.read()
        if told is None:
            return None
        place, buttons = told if isinstance(told, tuple) and len(told) == 2 else (told, 0)
        pose = np.asarray(place, dtype=np.float64)
        if pose.shape == (3,):
            pose, place = np.eye(4), pose
            pose[:3, 3] = place
        return pose, int(buttons)

    def _serve(self, session: Any) -> None:
        """Assigns it to a session. Raises `DeviceError` while another session uses it."""
        other = self._runs() if self._runs is not None else None
        if other is not None and other.is_running:
            raise DeviceError(f"{self.name} is in use by another run: stop that one first")
        self._runs = weakref.ref(session)
        _SERVED.add(session)


_SERVED: weakref.WeakSet[Any] = weakref.WeakSet()
"""Sessions that ran with a device written in Python: their threads must not outlive the interpreter."""


@atexit.register
def _stop_all() -> None:
    for session in list(_SERVED):
        with contextlib.suppress(Exception):
            session.stop()


class Opened(Device):
    """An opened device. It serves one run, whose end closes it: open it again for another."""

    def __init__(self, name: str, options: dict[str, object]) -> None:
        """See `open_device`."""
        self._device = _core.HapticsDevice.open(name, options)


def open_device(name: DeviceDriver, **options: object) -> Opened:
    """Opens a device by the name of its driver.

    - `spacemouse`: through spacenavd. Options `socket`, `speed_m_per_s`, `turn_rad_per_s`, `dead_zone`, `reach_m`,
      `silence_s`.
    - `haply`: Inverse3, with or without a VerseGrip, through the Inverse Service. `address`, `device_id`, `grip_id`,
      `preset`, `force_n`, `stiffness_n_per_m`.
    - `dhd`: Force Dimension and Novint Falcon, through libdhd. `library`, `force_n`, `torque_nm`, `stiffness_n_per_m`.
    - `openhaptics`: 3D Systems Touch and Phantom, through OpenHaptics. `library`, `device`, `force_n`,
      `stiffness_n_per_m`.

    `stiffness_n_per_m`: the stable stiffness of this device in a loop of 1 kHz, if you know it; default: from published
    values (docs/devices.md).

    `force_n`, `torque_nm`: the most that it may give, 0 or more; above what the device can give, its own limit holds.

    Raises `DeviceError` with advice if no such device is found, and, before it is looked for, `OptionError` for an
    option that it does not have or a number out of range.
    """
    return Opened(check_text("name", name, "the name of a driver"), dict(options))
