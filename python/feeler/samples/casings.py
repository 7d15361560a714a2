"""Casings: flanged shells with stiffening ribs, their bolted joints, panels, nested liners. All about the z axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import hardware
from .mesh import Floats, Mesh, around, circle_angles
from .plan import Plan
from .shapes import BoltCircle, revolve, revolve_flanged, revolve_sector
from .tessellation import Tolerance, rounded


@dataclass(frozen=True)
class Shell:
    """A flanged shell: inner radii at its ends `z0 < z1`, wall thickness, `bolts` on each flange, `ribs` between."""

    z0: float
    z1: float
    r0: float
    r1: float
    wall: float = 0.003
    flange: float = 0.026
    bolts: int = 24
    bolt_size: float = 0.008
    ribs: int = 2

    @property
    def flange_thickness(self) -> float:
        """Metres, along z."""
        return 0.008

    def pitch_radius(self, end: int) -> float:
        """Radius of the bolt circle at end 0 or 1."""
        return (self.r0, self.r1)[end] + self.wall + 0.55 * (self.flange - self.wall)


def flat_segment(profile: Floats, z: float, radius: float) -> int:
    """The number of the profile segment that lies at height `z` and passes `radius`."""
    ahead = np.roll(profile, -1, axis=0)
    flat = (np.abs(profile[:, 1] - z) < 1e-9) & (np.abs(ahead[:, 1] - z) < 1e-9)
    low, high = np.minimum(profile[:, 0], ahead[:, 0]), np.maximum(profile[:, 0], ahead[:, 0])
    found = np.flatnonzero(flat & (low < radius) & (radius < high))
    return int(found[0])


def flanged_shell(shell: Shell, tol: Tolerance) -> Mesh:
    """The shell as one closed ring, bolt holes through both flanges, fillets where the flanges meet the wall."""
    if tol.coarse:
        high = shell.flange
        corners = [
            (shell.r0, shell.z0),
            (shell.r0 + high, shell.z0),
            (shell.r1 + shell.wall, shell.z1),
            (shell.r1, shell.z1),
        ]
        return revolve(np.array(corners), tol)
    t = shell.flange_thickness
    span = shell.z1 - shell.z0

    def inner(z: float) -> float:
        return shell.r0 + (shell.r1 - shell.r0) * (z - shell.z0) / span

    wall, high = shell.wall, shell.flange
    front = high + 0.0004  # and wider holes: where two flanges meet, no triangle of one repeats one of the other
    points = [(shell.r0, shell.z0), (shell.r0 + front, shell.z0), (shell.r0 + front, shell.z0 + t)]
    points.append((inner(shell.z0 + t) + wall, shell.z0 + t))
    radii = [0.0, 0.0008, 0.0008, 0.003]
    if tol.shows(0.004):
        for rib in range(shell.ribs):
            z = shell.z0 + span * (rib + 1.0) / (shell.ribs + 1.0)
            out = inner(z) + wall
            points += [(inner(z - 0.004) + wall, z - 0.004), (out + 0.009, z - 0.003), (out + 0.009, z + 0.003)]
            points.append((inner(z + 0.004) + wall, z + 0.004))
            radii += [0.002, 0.0006, 0.0006, 0.002]
    points += [(inner(shell.z1 - t) + wall, shell.z1 - t), (shell.r1 + high, shell.z1 - t), (shell.r1 + high, shell.z1)]
    points.append((shell.r1, shell.z1))
    radii += [0.003, 0.0008, 0.0008, 0.0]
    profile = rounded(np.array(points), np.array(radii), tol)
    circles = []
    for end, (front, back) in enumerate(((shell.z0, shell.z0 + t), (shell.z1 - t, shell.z1))):
        pitch = shell.pitch_radius(end)
        segments = flat_segment(profile, front, pitch), flat_segment(profile, back, pitch)
        circles.append(BoltCircle(*segments, pitch, (0.57, 0.55)[end] * shell.bolt_size))
    return revolve_flanged(profile, tol, circles, shell.bolts)


def add_shell(plan: Plan, base: str, shell: Shell, *, joint: bool = True) -> None:
    """A shell and, with `joint`, the bolts, washers and nuts of its rear flange."""
    plan.add(f"{base}/shell", plan.shape(flanged_shell, shell), np.eye(4))
    if joint:
        add_joint(plan, base, shell.pitch_radius(1), shell.z1, shell.bolts, shell.bolt_size, shell.flange_thickness)


def add_joint(plan: Plan, base: str, radius: float, z: float, count: int, size: float, thickness: float) -> None:
    """Bolts with washers and nuts through two flanges that meet at `z`."""
    angle = circle_angles(count, np.pi / count)
    bolt = plan.shape(hardware.hex_bolt, size, 2.0 * thickness + 1.3 * size)
    plan.add(f"{base}/bolt", bolt, around(angle, radius, z + thickness, "axial"))
    if count <= 8:  # the smallest mock-ups go without nuts
        return
    plan.add(f"{base}/nut", plan.shape(hardware.nut, size), around(angle, radius, z - thickness, "back"))


def liner(z0: float, z1: float, r0: float, r1: float, wall: float, waves: int, tol: Tolerance) -> Mesh:
    """A thin inner ring with `waves` shallow cooling steps."""
    steps = waves if tol.shows(0.0015) else 0
    z = np.linspace(z0, z1, 2 * steps + 2)
    r = np.linspace(r0, r1, 2 * steps + 2) + np.where(np.arange(len(z)) % 2 == 0, 0.0, 0.003 if steps else 0.0)
    profile = np.concatenate([np.stack([r + wall, z], axis=1), np.stack([r, z], axis=1)[::-1]])
    return revolve(profile, tol)


def ring_profile(points: tuple[tuple[float, float], ...], fillet: float, tol: Tolerance) -> Mesh:
    """A ring from profile corners (radius, z), counter-clockwise, with fillets."""
    return revolve(rounded(np.array(points), fillet, tol), tol)


def panel(z0: float, z1: float, r0: float, r1: float, wall: float, start: float, angle: float, tol: Tolerance) -> Mesh:
    """A curved panel between two angles, its long edges bent inwards."""
    lip = 0.012
    profile = np.array(
        [
            (r0, z0), (r0 + wall, z0), (r1 + wall, z1), (r1, z1), (r1 - lip, z1), (r1 - lip, z1 - wall),
            (r1, z1 - wall), (r0, z0 + wall), (r0 - lip, z0 + wall), (r0 - lip, z0),
        ]
    )  # fmt: skip
    if not tol.shows(0.002):
        profile = profile[:4]
    return revolve_sector(profile, start, angle, tol)


def frame(z: float, r: float, start: float, angle: float, tol: Tolerance) -> Mesh:
    """A curved stiffener of Z section under a panel of inner radius `r`."""
    t, high, flange = 0.002, 0.03, 0.015
    profile = np.array(
        [
            (r - high, z), (r - t, z), (r - t, z - flange), (r, z - flange), (r, z + t), (r - high + t, z + t),
            (r - high + t, z + flange), (r - high, z + flange),
        ]
    )  # fmt: skip
    if not tol.shows(0.002):
        profile = np.array([(r - high, z), (r, z), (r, z + t), (r - high, z + t)])
    return revolve_sector(rounded(profile, 0.0006, tol), start, angle, tol)
