"""The virtual coupling: how the hand is held to the tool."""

from __future__ import annotations

from dataclasses import astuple, dataclass

from feeler.haptics.devices import Device


@dataclass(frozen=True)
class Coupling:
    """A spring and a damper between where the hand wants the tool and where the mock-up lets it be, and their bounds.

    The default suits a desktop device of 8 N at 1 kHz.
    """

    stiffness_n_per_m: float = 1000.0
    """Of the spring of translation, at the tool's centre of area."""
    damping_n_s_per_m: float = 0.1
    rotational_stiffness_nm_per_rad: float = 2.0
    rotational_damping_nm_s_per_rad: float = 2e-4
    max_force_n: float = 8.0
    """The spring stretches on at this force."""
    max_torque_nm: float = 0.3
    slew_n_per_s: float = 2000.0
    """Largest change of the force a second."""
    slew_nm_per_s: float = 75.0

    @classmethod
    def for_device(cls, device: Device) -> Coupling:
        """The stiffest coupling of use that a device holds, with the tool's centre at its handle: full force at 2 mm or
        0.05 rad, less where the device's largest stiffness, damping, friction, resolution, rate or delay do not hold
        that; a fifth of it where neither damping nor largest stiffness is known.
        """
        return cls(*device._device.coupling())

    def as_numbers(self) -> list[float]:
        """All eight, in this order."""
        return [float(value) for value in astuple(self)]
