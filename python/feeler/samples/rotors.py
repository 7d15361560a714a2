"""Rotating parts and those between them: disks with blades, vane rings, shafts, bearings. All about the z axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import blades, hardware
from .casings import flat_segment, ring_profile
from .mesh import Mesh, around, at, circle_angles
from .plan import Plan
from .shapes import BoltCircle, revolve, revolve_flanged
from .tessellation import Tolerance, rounded


@dataclass(frozen=True)
class Row:
    """One row of blades: middle plane `z`, radii at platform and tip, `count` blades of `chord`."""

    z: float
    root: float
    tip: float
    count: int
    chord: float
    stagger: tuple[float, float] = (0.45, 1.0)
    bend: float = 0.07


def disk(root: float, bore: float, width: float, bolts: int, tol: Tolerance) -> Mesh:
    """A rotor disk about z, centred: thick bore, thin web with holes, rim at `root`."""
    rim, web, cob = width / 2.0, 0.14 * width, 0.42 * width
    if tol.coarse:
        return revolve(np.array([(bore, -rim), (root, -rim), (root, rim), (bore, rim)]), tol)
    deep = root - bore
    a, b = bore + 0.25 * deep, bore + 0.38 * deep
    c, d = root - 0.28 * deep, root - 0.2 * deep
    half = [(bore, cob), (a, cob), (b, web), (c, web), (d, rim), (root, rim)]
    corners = np.array([(r, -z) for r, z in half] + half[::-1])
    radii = np.array([0.001, 0.004, 0.006, 0.006, 0.004, 0.0005])
    profile = rounded(corners, np.concatenate([radii, radii[::-1]]), tol)
    pitch = 0.5 * (b + c)
    segments = flat_segment(profile, -web, pitch), flat_segment(profile, web, pitch)
    return revolve_flanged(profile, tol, [BoltCircle(*segments, pitch, min(0.006, 0.2 * (c - b)))], bolts)


def add_rotor(plan: Plan, base: str, row: Row, bore: float, bolts: int, details: bool = True) -> None:
    """A bladed disk: disk, blades, retaining ring, and a drum spacer behind."""
    foot = 0.35 * row.chord + 0.004
    rim = row.root - 0.0035 - 0.5 * foot
    width = row.chord * abs(np.cos(row.stagger[0])) + 0.004
    plan.add(f"{base}/disk", plan.shape(disk, rim, bore, width, bolts), at(z=row.z))
    pitch = 2.0 * np.pi * row.root / row.count
    shape = plan.shape(blades.blade, row.root, row.tip, row.chord, row.stagger, row.bend, pitch)
    angle = circle_angles(row.count, float(plan.rng.uniform(0.0, 2.0 * np.pi)))
    plan.add(f"{base}/blade", shape, around(angle, 0.0, row.z))
    if not details:
        return
    ring = ((rim - 0.012, 0.0), (rim - 0.001, 0.0), (rim - 0.001, 0.003), (rim - 0.012, 0.003))
    plan.add(f"{base}/retaining_ring", plan.shape(ring_profile, ring, 0.0004), at(z=row.z + width / 2.0))
    drum = rim - 0.03
    if drum > bore + 0.02:
        pitch_radius = bore + 0.5 * (0.38 + 0.72) * (rim - bore)
        bolt = plan.shape(hardware.cap_screw, 0.008, 0.3 * width + 0.006)
        poses = around(circle_angles(bolts, np.pi / bolts), pitch_radius, row.z + 0.14 * width, "axial")
        plan.add(f"{base}/bolt", bolt, poses)


def add_stator(plan: Plan, base: str, row: Row, details: bool = True) -> None:
    """A ring of vanes with its inner seal ring."""
    pitch = 2.0 * np.pi * row.root / row.count
    stagger = (-row.stagger[0], -row.stagger[1])
    shape = plan.shape(blades.vane, row.root, row.tip, row.chord, stagger, -row.bend, pitch)
    angle = circle_angles(row.count, float(plan.rng.uniform(0.0, 2.0 * np.pi)))
    plan.add(f"{base}/vane", shape, around(angle, 0.0, row.z))
    if not details:
        return
    half, r = 0.4 * row.chord, row.root - 0.0025
    ring = ((r - 0.01, -half), (r, -half), (r, half), (r - 0.01, half), (r - 0.01, 0.4 * half), (r - 0.02, 0.3 * half))
    seal = (*ring, (r - 0.02, -0.3 * half), (r - 0.01, -0.4 * half))
    plan.add(f"{base}/seal_ring", plan.shape(ring_profile, seal, 0.0006), at(z=row.z))


def shaft(z0: float, z1: float, outer: float, inner: float, steps: int, tol: Tolerance) -> Mesh:
    """A hollow shaft with `steps` shallow journals near its ends; the run between is one full-length strip."""
    points = [(outer, z0)]
    for k in range(steps):
        z = z0 + 0.03 + 0.05 * k
        points += [(outer, z), (outer * 1.08, z + 0.002), (outer * 1.08, z + 0.026), (outer, z + 0.028)]
    for k in reversed(range(steps)):
        z = z1 - 0.03 - 0.05 * k
        points += [(outer, z - 0.028), (outer * 1.08, z - 0.026), (outer * 1.08, z - 0.002), (outer, z)]
    if not tol.shows(0.04 * outer):
        points = [(outer, z0)]
    points += [(outer, z1), (inner, z1), (inner, z0)]
    return revolve(rounded(np.array(points), 0.0008, tol), tol)


def add_bearing(
    plan: Plan,
    base: str,
    z: float,
    inner: float,
    outer: float,
    count: int,
    rollers: bool = False,
) -> None:
    """A ball or roller bearing between two radii: races, cage, `count` balls."""
    size = 0.3 * (outer - inner)
    middle = 0.5 * (outer + inner)
    count = min(count, int(2.0 * np.pi * middle / (2.3 * size)))
    width = 2.6 * size
    track = 0.0 if rollers else size
    step = 0.75 * size
    plan.add(f"{base}/inner_race", plan.shape(hardware.race, inner, middle - step, width, track, False), at(z=z))
    plan.add(f"{base}/outer_race", plan.shape(hardware.race, middle + step, outer, width, track, True), at(z=z))
    cage = hardware.ring
    for name, offset in (("cage_front", -1.05 * size), ("cage_rear", 0.95 * size)):
        plan.add(
            f"{base}/{name}", plan.shape(cage, middle - 0.3 * size, middle + 0.3 * size, 0.1 * size), at(z=z + offset)
        )
    poses = around(circle_angles(count), middle, z, "axial")
    if rollers:
        plan.add(f"{base}/roller", plan.shape(hardware.roller, 0.72 * size, 1.6 * size), poses)
    else:
        plan.add(f"{base}/ball", plan.shape(hardware.ball, 0.9 * size), poses)


def spinner(length: float, radius: float, tol: Tolerance) -> Mesh:
    """A nose cone towards -z, its base at z = 0: a shell with a blunt tip."""
    count = tol.segments(1.5 * length, 1.0, 3)
    share = np.linspace(0.04, 1.0, count + 1)
    outside = np.stack([radius * np.sqrt(share), length * (share - 1.0)], axis=1)
    inside = outside[::-1] * [0.97, 0.98] - [0.001, 0.0]
    return revolve(np.concatenate([outside, inside]), tol)
