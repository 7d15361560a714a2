"""Hands: paths of a device, and a device with mass that a simulated hand holds. Time is simulated, a tick at a time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .faces import TICK_S
from .meshes import Floats
from .poses import moved, pose, rotation, rotation_vector

SUBSTEPS = 10  # of a tick: the hand's own mechanics are continuous beside a device at 1 kHz


def straight(start: Floats, velocity: npt.ArrayLike, spin: npt.ArrayLike, ticks: int, about: npt.ArrayLike) -> Floats:
    """Poses (ticks, 4, 4) from `start` on, at m/s, and turning at rad/s about a point of the tool that moves along."""
    v, w = np.asarray(velocity, dtype=np.float64), np.asarray(spin, dtype=np.float64)
    middle = start[:3, :3] @ np.asarray(about, dtype=np.float64) + start[:3, 3]
    return np.array([moved(start, v * (k * TICK_S), w * (k * TICK_S), middle) for k in range(ticks)])


def through(keys: Floats, seconds: npt.ArrayLike) -> Floats:
    """Poses at each tick through key poses (k, 4, 4): each leg takes its seconds and starts and ends at rest."""
    made = [keys[0]]
    legs = np.broadcast_to(np.asarray(seconds, dtype=np.float64), (len(keys) - 1,))
    for first, last, time in zip(keys[:-1], keys[1:], legs, strict=True):
        turn = rotation_vector(last[:3, :3] @ first[:3, :3].T)
        count = max(1, round(time / TICK_S))
        for t in np.arange(1, count + 1) / count:
            share = t * t * t * (10.0 + t * (6.0 * t - 15.0))
            at = np.eye(4)
            at[:3, :3] = rotation(share * turn) @ first[:3, :3]
            at[:3, 3] = first[:3, 3] + share * (last[:3, 3] - first[:3, 3])
            made.append(at)
    made[-1] = keys[-1]
    return np.array(made)


def along(way: Floats, speed_m_per_s: float, spin_rad_per_s: float = 2.0) -> Floats:
    """Poses at each tick along a given way, no faster than either speed: the knots joined, without rests."""
    made = [way[0]]
    for first, last in itertools.pairwise(way):
        shift, turn = last[:3, 3] - first[:3, 3], rotation_vector(last[:3, :3] @ first[:3, :3].T)
        time = max(np.linalg.norm(shift) / speed_m_per_s, np.linalg.norm(turn) / spin_rad_per_s)
        count = max(1, int(np.ceil(time / TICK_S)))
        for t in np.arange(1, count + 1) / count:
            at = np.eye(4)
            at[:3, :3], at[:3, 3] = rotation(t * turn) @ first[:3, :3], first[:3, 3] + t * shift
            made.append(at)
        made[-1] = last
    return np.array(made)


def circle(start: Floats, across: npt.ArrayLike, down: npt.ArrayLike, radius: float, seconds: float) -> Floats:
    """A closed circle through `start` in the plane of two unit vectors, its middle one radius along `down`."""
    a, d = np.asarray(across, dtype=np.float64), np.asarray(down, dtype=np.float64)
    made = []
    for angle in np.linspace(0.0, 2.0 * np.pi, max(2, round(seconds / TICK_S)) + 1):
        at = start.copy()
        at[:3, 3] += radius * (np.sin(angle) * a + (1.0 - np.cos(angle)) * d)
        made.append(at)
    made[-1] = start.copy()
    return np.array(made)


@dataclass(frozen=True)
class Grip:
    """A hand on a device, of the order that is usual: mass and stiffness of both together, alike along all axes."""

    mass_kg: float = 0.25
    stiffness_n_per_m: float = 300.0
    damping_ns_per_m: float = 4.0
    inertia_kgm2: float = 2e-4
    rotational_stiffness_nm_per_rad: float = 1.0
    rotational_damping_nms_per_rad: float = 0.02


LOOSE = Grip(
    stiffness_n_per_m=0.0,
    rotational_stiffness_nm_per_rad=0.0,
    damping_ns_per_m=0.3,
    rotational_damping_nms_per_rad=1e-4,
)
"""A released device: its mass and a little friction."""


class Hand:
    """A device of some mass, held by a spring and damper to where the hand wants it, pushed by the session.

    The wrench acts about the device's origin. It may come late by whole ticks (`delay_ticks`).
    """

    def __init__(self, start: Floats, grip: Grip | None = None, delay_ticks: int = 0) -> None:
        self.grip = grip or Grip()
        self.pose: Floats = start.copy()
        self.velocity, self.spin = np.zeros(3), np.zeros(3)
        self._late: list[tuple[Floats, Floats]] = [(np.zeros(3), np.zeros(3))] * delay_ticks

    def tick(self, wanted: Floats, force: Floats, torque: Floats, dt: float = TICK_S) -> Floats:
        """One tick under a wrench that is held for its length; the device's pose after it."""
        self._late.append((force, torque))
        force, torque = self._late.pop(0)
        g, h = self.grip, dt / SUBSTEPS
        at, turned = self.pose[:3, 3].copy(), self.pose[:3, :3].copy()
        for _ in range(SUBSTEPS):
            pull = g.stiffness_n_per_m * (wanted[:3, 3] - at) - g.damping_ns_per_m * self.velocity
            turn = rotation_vector(wanted[:3, :3] @ turned.T)
            twist = g.rotational_stiffness_nm_per_rad * turn - g.rotational_damping_nms_per_rad * self.spin
            self.velocity = self.velocity + h / g.mass_kg * (pull + force)
            self.spin = self.spin + h / g.inertia_kgm2 * (twist + torque)
            at, turned = at + h * self.velocity, rotation(h * self.spin) @ turned
        u, _, vt = np.linalg.svd(turned)  # what rounding did to it is undone
        self.pose = np.eye(4)
        self.pose[:3, :3], self.pose[:3, 3] = u @ vt, at
        return self.pose

    @property
    def kinetic_j(self) -> float:
        """The device's kinetic energy."""
        g = self.grip
        return 0.5 * g.mass_kg * float(self.velocity @ self.velocity) + 0.5 * g.inertia_kgm2 * float(
            self.spin @ self.spin
        )


OFF_M = 0.001
OFF_RAD = np.radians(1.0)
SEARCH_M = 0.0006  # how far a hand looks about when nothing gives way
SEARCH_HZ = 1.3
TREMOR_M = 1e-4
TREMOR_HZ = 8.5


def unsure(axis_top: Floats, depth: float, seed: int, *, above: float, speed: float = 0.03) -> Iterator[Floats]:
    """A hand that pushes along -z of `axis_top` from above to a little deeper than `depth`, and then keeps pushing.

    Its axis is off by `OFF_M` in a direction and by `OFF_RAD` about another; both are the seed's. It looks about in a
    slow circle and trembles a little, as hands do. Endless: at the end it stays where it wants to be.
    """
    rng = np.random.default_rng(seed)
    side, lean, phase = rng.uniform(0.0, 2.0 * np.pi, 3)
    off = OFF_M * np.array([np.cos(side), np.sin(side), 0.0])
    tilt = OFF_RAD * np.array([np.cos(lean), np.sin(lean), 0.0])
    height, tick = above, 0
    while True:
        time = tick * TICK_S
        circling = SEARCH_M * np.array(
            [np.cos(2 * np.pi * SEARCH_HZ * time), np.sin(2 * np.pi * SEARCH_HZ * time), 0.0]
        )
        shaking = TREMOR_M * np.sin(2 * np.pi * TREMOR_HZ * time + phase + np.array([0.0, 2.0, 4.0]))
        yield axis_top @ pose(off + circling + shaking + np.array([0.0, 0.0, height]), tilt)
        height = max(height - speed * TICK_S, -depth - 0.003)
        tick += 1


def work_j(before: Floats, after: Floats, force: Floats, torque: Floats) -> float:
    """The work of a wrench on a device that moves from one pose to another: positive where the device is driven."""
    shift = after[:3, 3] - before[:3, 3]
    return float(force @ shift + torque @ rotation_vector(after[:3, :3] @ before[:3, :3].T))
