"""The virtual coupling between the device and the tool."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields

from feeler.arguments import check_kind, check_number
from feeler.field_docs import documented
from feeler.haptics.devices import Device


@documented
@dataclass(frozen=True)
class Coupling:
    """A spring and a damper between the device's pose and the proxy, and their limits.

    The default suits a desktop device of 8 N at 1 kHz. Raises `OptionError` for negative values and a slew of 0.
    """

    stiffness_n_per_m: float = 1000.0
    """Of the translational spring, at the tool's centre of area, where the hand holds it."""
    damping_n_s_per_m: float = 0.1
    """Of the same spring."""
    rotational_stiffness_nm_per_rad: float = 2.0
    """Of the rotational spring."""
    rotational_damping_nm_s_per_rad: float = 2e-4
    """Of the rotational spring."""
    max_force_n: float = 8.0
    """The largest force of the spring; beyond it the spring stretches on."""
    max_torque_nm: float = 0.3
    """The largest torque of the rotational spring."""
    slew_n_per_s: float = 2000.0
    """Slew: the largest change of the force per second, above 0."""
    slew_nm_per_s: float = 75.0
    """The largest change of the torque per second."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name.startswith("slew"):
                check_number(each.name, value, "a number, more than 0", above=0.0)
            else:
                check_number(each.name, value, "a number, 0 or more", least=0.0)

    @classmethod
    def for_device(cls, device: Device) -> Coupling:
        """The stiffest useful coupling that a device can hold, with the tool's centre at its handle: full force at 2 mm
        or 0.05 rad, less if the device's largest stiffness, damping, friction, resolution, rate or delay require it; a
        fifth of it if neither damping nor largest stiffness is known. An unknown rate counts as 1 kHz.
        """
        return cls(*check_kind("device", device, Device, "a device of feeler.haptics.devices")._device.coupling())

    def as_numbers(self) -> list[float]:
        """All eight values, in this order."""
        return [float(value) for value in astuple(self)]
