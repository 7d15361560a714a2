"""The turbofan's fan, bypass duct and nacelle around the core engine: from z = -0.9 to z = 3.4 m, 1.7 m across."""

from __future__ import annotations

import numpy as np

from . import blades, hardware
from .casings import Shell, add_shell, frame, panel, ring_profile
from .core_engine import Amount
from .externals import Dresser
from .layout import Surface
from .mesh import Floats, Mesh, around, at, circle_angles, turned
from .plan import Plan
from .rotors import disk, spinner
from .shapes import box, revolve
from .tessellation import Tolerance

FAN_TIP, FAN_CASE, COWL = 0.70, 0.715, 0.84


def nacelle_surface() -> Surface:
    """The outside of the fan case."""
    return Surface(np.array([-0.60, 0.10]), np.array([FAN_CASE + 0.004]), np.array([FAN_CASE + 0.03]))


def add_fan(plan: Plan, amount: Amount) -> None:
    """Fan, its case, outlet guide vanes, and the duct behind."""
    count = amount.many(22, 11, 26, 0.3)
    pitch = 2.0 * np.pi * 0.22 / count
    shape = plan.shape(blades.fan_blade, 0.22, FAN_TIP, 0.20, pitch)
    plan.add("fan/blade", shape, around(circle_angles(count), 0.0, -0.32))
    plan.add("fan/disk", plan.shape(disk, 0.19, 0.06, 0.14, amount.many(16, 6, 36)), at(z=-0.32))
    plan.add("fan/spinner", plan.shape(spinner, 0.3, 0.218), at(z=-0.41))
    filler = plan.shape(_platform, 0.6 * pitch)
    if not amount.tiny:
        plan.add("fan/annulus_filler", filler, around(circle_angles(count, np.pi / count), 0.214, -0.32))
    vanes = amount.many(50, 11, 60, 0.5)
    stagger = (-0.1, -0.3)
    guide = plan.shape(blades.vane, 0.50, FAN_CASE + 0.001, 0.11, stagger, -0.06, 2.0 * np.pi * 0.5 / vanes)
    plan.add("fan/guide_vane", guide, around(circle_angles(vanes), 0.0, -0.06))
    bolts = amount.bolts(0.75)
    add_shell(plan, "fan_case/front", Shell(-0.60, -0.14, FAN_CASE, FAN_CASE, wall=0.004, bolts=bolts, ribs=5))
    add_shell(plan, "fan_case/rear", Shell(-0.14, 0.10, FAN_CASE, FAN_CASE, wall=0.004, bolts=bolts, ribs=2))
    splitter = ((0.49, -0.12), (0.50, -0.13), (0.505, -0.12), (0.505, 0.02), (0.49, 0.02))
    plan.add("fan/splitter", plan.shape(ring_profile, splitter, 0.003), np.eye(4))
    if amount.tiny:
        return
    liners = amount.many(12, 4, 24, 0.5)
    for k, start in enumerate(circle_angles(liners), start=1):
        lining = plan.shape(panel, -0.56, -0.44, 0.703, 0.703, 0.010, float(start), 0.97 * 2.0 * np.pi / liners)
        plan.add(f"fan_case/acoustic_liner_{k:02d}", lining, np.eye(4))
    if amount.tiny:
        return
    dresser = Dresser(plan, nacelle_surface(), "fan_case_externals", (-0.55, 0.08), amount.rich, not amount.tiny)
    dresser.boxes(amount.many(6, 1, 12, 0.6))
    dresser.pipes(amount.many(16, 2, 80))
    dresser.harness(amount.many(8, 1, 40))


def inlet(tol: Tolerance) -> Mesh:
    """The inlet lip and duct: a hollow ring of aerofoil section, from z = -0.9 to the fan case."""
    n = max(3 if tol.coarse else 5, tol.segments(0.07, np.pi) + 1)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, n)[::-1]
    lip = np.stack([0.758 + 0.052 * np.sin(angle), -0.83 - 0.07 * np.cos(angle)], axis=1)
    outer = np.array([(COWL, -0.62), (COWL, -0.60), (COWL - 0.003, -0.60)])
    back = np.array([0.758, -0.83]) + (lip[::-1] - [0.758, -0.83]) * 0.93
    inside = np.array([(0.703, -0.60), (0.700, -0.60), (0.700, -0.62)])
    profile = np.concatenate([inside[1:], lip[::-1], outer, [(COWL - 0.003, -0.62)], back[::-1][1:-1], inside[:1]])
    return revolve(profile[::-1] if _area(profile) < 0.0 else profile, tol)


def _area(profile: Floats) -> float:
    x, y = profile.T
    return float(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def add_nacelle(plan: Plan, amount: Amount) -> None:
    """Inlet, cowl doors with frames and latches, reverser cascades, core cowl, nozzle, pylon."""
    plan.add("nacelle/inlet", plan.shape(inlet), np.eye(4))
    sections = (
        ("fan_cowl", -0.60, 0.30, COWL, COWL),
        ("reverser", 0.30, 1.30, COWL, 0.80),
        ("aft", 1.30, 2.40, 0.80, 0.66),
    )
    doors = amount.many(6, 2, 16, 0.5)
    gap = 2.0 * np.pi / doors
    for name, z0, z1, r0, r1 in sections:
        for k in range(doors):
            base = f"nacelle/{name}/door_{k + 1:02d}"
            start = np.pi / 2.0 + gap * k + 0.012
            plan.add(f"{base}/skin", plan.shape(panel, z0, z1 - 0.004, r0, r1, 0.002, start, gap - 0.024), np.eye(4))
            ribs = amount.many(5, 1, 12, 0.5)
            for rib in range(ribs):
                share = (rib + 0.7) / (ribs + 0.4)
                z, r = z0 + share * (z1 - z0), r0 + share * (r1 - r0) - 0.001
                plan.add(f"{base}/frame_{rib + 1}", plan.shape(frame, z, r, start + 0.01, gap - 0.044), np.eye(4))
            latches = amount.many(4, 1, 10, 0.5)
            spots = np.linspace(z0 + 0.08, z1 - 0.08, latches)
            under = r0 + (spots - z0) / (z1 - z0) * (r1 - r0) - 0.012
            latch = plan.shape(hardware.angle_bracket, 0.05, 0.035, 0.04)
            plan.add(f"{base}/latch", latch, around(start + 0.03, under, spots) @ turned("x", np.pi))
            bolt = plan.shape(hardware.hex_bolt, 0.006, 0.016)
            plan.add(f"{base}/latch_bolt", bolt, around(start + 0.055, under - 0.003, spots) @ turned("x", np.pi))
    boxes = 0 if amount.tiny else amount.many(16, 4, 32, 0.5)
    slats = amount.many(8, 2, 16, 0.5)
    for k, angle in enumerate(circle_angles(max(1, boxes))[:boxes], start=1):
        half = 0.45 * 2.0 * np.pi * 0.76 / boxes
        slat = plan.shape(blades.airfoil_loft, -half, half, (0.03, 0.03), (0.7, 0.7), 0.1)
        poses = around(np.full(slats, angle), 0.765, np.linspace(0.45, 0.75, slats)) @ turned("y", np.pi / 2.0)
        plan.add(f"nacelle/cascade_{k:02d}/vane", slat, poses)
    nozzle = ((0.64, 2.40), (0.66, 2.40), (0.58, 3.1), (0.576, 3.1))
    plan.add("nacelle/nozzle", plan.shape(ring_profile, nozzle, 0.001), np.eye(4))
    mixer = ((0.475, 3.0), (0.48, 3.0), (0.40, 3.4), (0.396, 3.4))
    plan.add("nacelle/plug_shroud", plan.shape(ring_profile, mixer, 0.001), np.eye(4))
    _pylon(plan, amount)


def _pylon(plan: Plan, amount: Amount) -> None:
    frames = amount.many(9, 4, 24, 0.5)
    for k, z in enumerate(np.linspace(0.3, 2.6, frames), start=1):
        rib = plan.shape(_pylon_rib, 0.16, 0.26)
        plan.add(f"pylon/rib_{k:02d}", rib, at(0.0, 0.62, float(z)) @ turned("x", -np.pi / 2.0))
    for side in (-1.0, 1.0):
        name = "left" if side > 0 else "right"
        spar = plan.shape(_slab, 0.004, 0.26, 2.4)
        plan.add(f"pylon/side_{name}", spar, at(side * 0.084, 0.75, 0.25))
        if amount.tiny:
            continue
        rows = np.linspace(0.28, 2.62, amount.many(40, 4, 160))
        outwards = turned("y", side * np.pi / 2.0)
        pose = np.stack([at(side * 0.086, y, float(z)) @ outwards for z in rows for y in (0.64, 0.86)])
        plan.add(f"pylon/fastener_{name}", plan.shape(hardware.rivet, 0.004), pose)
    plan.add("pylon/top", plan.shape(_slab, 0.17, 0.004, 2.4), at(0.0, 0.882, 0.25))


def _pylon_rib(width: float, height: float, tol: Tolerance) -> Mesh:
    return box(width, 0.006, height)


def _platform(width: float, tol: Tolerance) -> Mesh:
    return box(width, 0.16, 0.003)


def _slab(x: float, y: float, z: float, tol: Tolerance) -> Mesh:
    return box(x, y, z)
