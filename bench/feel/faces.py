"""The common interface of feeler's session and the baselines, and the coupling that the baselines share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

import feeler

from .meshes import Floats
from .poses import moved, placed, rotation_vector

TICK_S = 0.001


class StepLike(Protocol):
    """The result of a step of a session."""

    @property
    def world_from_proxy(self) -> Floats:
        """The tool as it is shown, (4, 4)."""

    @property
    def force(self) -> Floats:
        """On the hand, newtons, world."""

    @property
    def torque(self) -> Floats:
        """On the hand about the device's centre, newton metres, world."""


class Face(Protocol):
    """A haptic session to measure."""

    def start(self, pose: Floats) -> object:
        """Begin with the tool at a free pose, world_from_tool."""

    def step(self, world_from_device: Floats, dt: float = TICK_S) -> StepLike:
        """One tick of the device."""


MakeFace = Callable[..., Face]


@dataclass(frozen=True)
class PlainStep:
    """A step of a baseline."""

    world_from_proxy: Floats
    force: Floats
    torque: Floats
    planes: int = 0
    age: float = 0.0
    mode: str = "free"


@dataclass(frozen=True)
class PlainCoupling:
    """Spring and damper between device and virtual tool (Colgate, Stanley, Brown 1995)."""

    stiffness_n_per_m: float = 1000.0
    damping_ns_per_m: float = 10.0
    rotational_stiffness_nm_per_rad: float = 1.0
    rotational_damping_nms_per_rad: float = 0.005
    force_limit_n: float = 20.0
    torque_limit_nm: float = 1.0


class VirtualTool:
    """A tool with mass that follows the device through a spring and damper, and is pushed by contact forces.

    Semi-implicit Euler at the device's rate. The mass is `mass_kg`, the inertia that of a ball of the tool's size;
    spring and damper act on the device as they act on the tool.
    """

    def __init__(self, tool: feeler.Tool, coupling: PlainCoupling, mass_kg: float = 0.05) -> None:
        bounds = np.asarray(tool.bounds)
        self.coupling, self.mass = coupling, mass_kg
        self.middle = bounds.mean(axis=0)
        self.size = 0.5 * float(np.linalg.norm(bounds[1] - bounds[0]))
        self.inertia = 0.4 * mass_kg * self.size * self.size
        self.pose: Floats = np.eye(4)
        self.velocity, self.spin = np.zeros(3), np.zeros(3)
        self._device: Floats | None = None

    def start(self, pose: Floats) -> None:
        """Rest at a pose."""
        self.pose, self._device = pose.copy(), pose.copy()
        self.velocity, self.spin = np.zeros(3), np.zeros(3)

    @property
    def centre(self) -> Floats:
        """The middle of the tool's box, world."""
        return np.asarray(placed(self.middle[None], self.pose)[0])

    def step(self, device: Floats, contact_force: Floats, contact_torque: Floats, dt: float) -> tuple[Floats, Floats]:
        """Move by one tick; the wrench on the hand, about the device's origin."""
        c = self.coupling
        before = self._device if self._device is not None else device
        wanted = placed(self.middle[None], device)[0]
        device_velocity = (wanted - placed(self.middle[None], before)[0]) / dt
        device_spin = rotation_vector(device[:3, :3] @ before[:3, :3].T) / dt
        self._device = device.copy()
        # the wrench is that before the tool moves on: a tool one tick ahead would pull the hand along
        reach, turn = wanted - self.centre, rotation_vector(device[:3, :3] @ self.pose[:3, :3].T)
        spring = c.stiffness_n_per_m * reach
        twist = c.rotational_stiffness_nm_per_rad * turn
        force = -spring - c.damping_ns_per_m * (device_velocity - self.velocity)
        torque = -twist - c.rotational_damping_nms_per_rad * (device_spin - self.spin)
        torque = torque + np.cross(wanted - device[:3, 3], force)
        # implicit in the tool's own velocity; the damper acts on both ends alike, or it would make energy
        push = spring + c.damping_ns_per_m * device_velocity + contact_force
        twist_by = twist + c.rotational_damping_nms_per_rad * device_spin + contact_torque
        light = 1.0 + dt * c.damping_ns_per_m / self.mass
        slow = 1.0 + dt * c.rotational_damping_nms_per_rad / self.inertia
        self.velocity = (self.velocity + dt / self.mass * push) / light
        self.spin = (self.spin + dt / self.inertia * twist_by) / slow
        self.pose = moved(self.pose, dt * self.velocity, dt * self.spin, self.centre)
        return limited(force, c.force_limit_n), limited(torque, c.torque_limit_nm)


def limited(vector: Floats, most: float) -> Floats:
    """A vector no longer than that."""
    length = float(np.sqrt(vector @ vector))
    return vector if length <= most else np.asarray(vector * (most / length))
