"""Devices: what a hand holds while a session runs.

    device = feeler.haptics.devices.Simulated("desktop_6dof", hand=(times, poses))
    device = feeler.haptics.open_device("haply")

A device's own frame has its origin in the middle of its workspace, x to the right, y away from the hand's owner, z up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.errors import OptionError

PRESETS = ("desktop_3dof", "desktop_6dof", "large_6dof")
FAULTS = ("nan", "nonsense", "lost", "silent", "jump", "slow")


class Device:
    """What all devices have. `Simulated`, `Mouse` and `open_device` make one."""

    _device: _core.HapticsDevice
    _is_absolute = False

    @property
    def name(self) -> str:
        """Maker and model, or what the device says of itself."""
        return self._device.name

    @property
    def sensed(self) -> tuple[str, ...]:
        """What it tells, of `translation` and `rotation`."""
        return tuple(self._device.sensed)

    @property
    def driven(self) -> tuple[str, ...]:
        """What it drives, of the same: without `rotation` it gets force without torque."""
        return tuple(self._device.driven)

    @property
    def workspace(self) -> tuple[float, float, float]:
        """Half the edges of the box that its handle can reach, metres."""
        x, y, z = self._device.workspace
        return x, y, z

    @property
    def buttons(self) -> int:
        """How many it has."""
        return self._device.button_count

    @property
    def limits(self) -> dict[str, float]:
        """What it can do and hold: `force_n`, `torque_nm`, `damping_n_s_per_m`, `friction_n`, `resolution_m`, the same
        three in rotation, `rate_hz` and `delay_s`. 0: none, or not known.
        """
        return self._device.limits

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.name}>"

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be pickled or copied: make one where it is used")


class Simulated(Device):
    """A device that is not there: mass, friction, encoders, delays, and a hand on it.

    - `preset`: `desktop_3dof` (12 N, no torque), `desktop_6dof` (12 N, 0.4 Nm) or `large_6dof` (60 N, 3 Nm).
    - `hand`: `(times, poses)`: where the hand wants the handle, `device_from_handle` `(n, 4, 4)`, metres, at times
      `(n,)`, seconds since the first run began; between them it moves evenly. None: nobody holds it.
    - `grip`: `firm` or `loose`: how stiff that hand is.
    - `delay_s`: of the pose told and of the force that acts, half each; `jitter_s`: up to so much more each way;
      `seed`: of the jitter.
    - `fault`: `(kind, value, from_s, until_s)`: something is wrong for a while, to see what becomes of the force.
      `nan`: its velocity is no number; `nonsense`, `lost`: it says so; `silent`: it tells nothing new; `jump`: it is
      `value` metres higher; `slow`: it tells `value` poses a second.

    Raises `OptionError` and `PoseError`.
    """

    def __init__(
        self,
        preset: str = "desktop_6dof",
        *,
        hand: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
        grip: str = "firm",
        delay_s: float = 0.0,
        jitter_s: float = 0.0,
        seed: int = 0,
        fault: tuple[str, float, float, float] | None = None,
    ) -> None:
        """See the class."""
        times, poses = (None, None) if hand is None else hand
        moments = None if times is None else np.asarray(times, dtype=np.float64)
        if moments is not None and moments.ndim != 1:
            raise OptionError(f"the times of a hand have shape {moments.shape}: (n,) is needed")
        self._device = _core.HapticsDevice.simulated(
            preset,
            None if moments is None else moments.tolist(),
            poses,
            grip,
            [0.5 * float(delay_s), 0.5 * float(delay_s), float(jitter_s)],
            int(seed),
            None if fault is None else (str(fault[0]), float(fault[1]), float(fault[2]), float(fault[3])),
        )


class Mouse(Device):
    """A device that goes, smoothly, where a program tells it to: the tool of a mouse in a window. It drives nothing.

    Its frame is the world's: the tool is where the mouse is. `pose`: where it begins, `world_from_tool`; `frequency`:
    natural frequency of its smoothing, radians a second, 1 to 1000: it is `2 / frequency` seconds behind.
    """

    _is_absolute = True

    def __init__(self, pose: npt.ArrayLike, *, frequency: float = 40.0) -> None:
        """See the class."""
        self._device = _core.HapticsDevice.mouse(pose, float(frequency))

    def set_target(self, pose: npt.ArrayLike) -> None:
        """Where to go from now on, `world_from_tool`; also while a session runs."""
        self._device.set_target(pose)

    def set_buttons(self, buttons: int) -> None:
        """Which buttons are held from now on, a bit each."""
        self._device.set_buttons(int(buttons))


class Opened(Device):
    """A device that is there. It serves one run, whose end lets go of it for good: open it again for another."""

    def __init__(self, name: str, options: dict[str, Any]) -> None:
        """See `open_device`."""
        self._device = _core.HapticsDevice.open(name, options)


def open_device(name: str, **options: Any) -> Opened:
    """Opens a device by the name of its driver.

    - `spacemouse`: through spacenavd. Options `socket`, `speed_m_per_s`, `turn_rad_per_s`, `dead_zone`, `reach_m`,
      `silence_s`.
    - `haply`: Inverse3, with or without a VerseGrip, through the Inverse Service. `address`, `device_id`, `grip_id`,
      `preset`, `force_n`.
    - `dhd`: Force Dimension and Novint Falcon, through libdhd. `library`, `force_n`, `torque_nm`.
    - `openhaptics`: 3D Systems Touch and Phantom, through OpenHaptics. `library`, `device`, `force_n`.

    Raises `DeviceError` where there is none, with what to do, and `OptionError` for an option that it does not have.
    """
    return Opened(str(name), dict(options))
