"""Parts of the carcass beyond casings and frames: covers, stiffeners, access panels, mounts."""

from __future__ import annotations

import numpy as np

from . import hardware
from .casings import Shell, add_shell, panel
from .core_engine import Amount, outer_surface
from .mesh import Floats, Mesh, around, at, circle_angles, merge, moved, turned
from .plan import Plan
from .shapes import box, extrude, plate
from .tessellation import Tolerance, rounded


def add_carcass(plan: Plan, amount: Amount) -> None:
    """A duct around the core, stringers, access panels with screws, mounting lugs, drain masts."""
    bolts = amount.bolts(0.6)
    for k, (z0, z1) in enumerate(((0.60, 1.10), (1.10, 1.62), (1.62, 2.14), (2.14, 2.60)), start=1):
        shell = Shell(z0, z1, 0.60, 0.60, wall=0.0025, flange=0.022, bolts=bolts, bolt_size=0.006, ribs=3)
        add_shell(plan, f"outer_duct/section_{k}", shell)
        count = amount.many(24, 6, 48, 0.5)
        length = z1 - z0 - 0.05
        poses = around(circle_angles(count), 0.6, 0.5 * (z0 + z1)) @ turned("z", np.pi)
        plan.add(f"outer_duct/section_{k}/stringer", plan.shape(stringer, length), poses)
    surface = outer_surface()
    panels = amount.many(36, 5, 160)
    for k in range(panels):
        low = k % 4
        z0 = 0.63 + 0.51 * low + float(plan.rng.uniform(0.0, 0.1))
        slot = 2.0 * np.pi / -(-panels // 4)
        wide, long = min(0.85 * slot, float(plan.rng.uniform(0.2, 0.5))), float(plan.rng.uniform(0.16, 0.3))
        start = 0.3 * low + slot * (k // 4) + float(plan.rng.uniform(0.0, 0.95 * slot - wide))
        base = f"outer_duct/access_panel_{k + 1:02d}"
        plan.add(f"{base}/cover", plan.shape(panel, z0, z0 + long, 0.612, 0.612, 0.002, start, wide), np.eye(4))
        screws = amount.many(7, 2, 14, 0.6)
        angles = np.concatenate([np.linspace(start + 0.02, start + wide - 0.02, screws)] * 2)
        heights = np.repeat([z0 + 0.012, z0 + long - 0.012], screws)
        screw = plan.shape(hardware.cap_screw, 0.005, 0.014)
        plan.add(f"{base}/screw", screw, around(angles, 0.614, heights))
    for k, (_, z) in enumerate((("front", 0.68), ("rear", 2.66))):
        for side, angle in (("left", np.pi / 2 + 0.5), ("right", np.pi / 2 - 0.5), ("top", np.pi / 2)):
            base = f"mounts/mount_{k + 1}_{side}"
            pose = around(angle, surface.at(z) - 0.002, z)[0]
            plan.add(f"{base}/lug", plan.shape(lug, 0.09, 0.11, 0.03, 0.02), pose)
            sides = np.stack([pose @ at(x, y, 0.012) for x in (-0.045, 0.045) for y in (-0.035, 0.035)])
            plan.add(f"{base}/bolt", plan.shape(hardware.hex_bolt, 0.012, 0.03), sides)
    _bosses(plan, amount)
    for row in range(10):
        angles = 0.3 * row + np.arange(200) * 0.025
        poses = around(angles, 0.6025, 0.75 + 0.19 * row)
        plan.add_filler("outer_duct/rivet", plan.shape(hardware.rivet, 0.004), poses)


def _bosses(plan: Plan, amount: Amount) -> None:
    surface, count = outer_surface(), amount.many(60, 6, 400)
    z = plan.rng.uniform(0.1, 2.8, count)
    angle = plan.rng.uniform(0.0, 2.0 * np.pi, count)
    poses = around(angle, np.array([surface.at(float(h)) for h in z]), z)
    plan.add("bosses/boss", plan.shape(hardware.boss, 0.016, 0.014, 0.007), poses)
    plan.add("bosses/plug", plan.shape(hardware.hex_bolt, 0.012, 0.014), poses @ at(z=0.014))
    count = amount.many(80, 6, 400)
    z = plan.rng.uniform(0.65, 2.5, count)
    poses = around(plan.rng.uniform(0.0, 2.0 * np.pi, count), 0.4495 + 0.055 * (z > 2.1), z)
    plan.add("brackets/bracket", plan.shape(hardware.angle_bracket, 0.05, 0.045, 0.04), poses)
    plan.add("brackets/bolt", plan.shape(hardware.hex_bolt, 0.006, 0.014), poses @ at(0.02, 0.0125, 0.003))


def stringer(length: float, tol: Tolerance) -> Mesh:
    """A long stiffener of L section along y, standing on z = 0."""
    corners = np.array([(-0.012, 0.0), (0.012, 0.0), (0.012, 0.002), (-0.01, 0.002), (-0.01, 0.022), (-0.012, 0.022)])
    if not tol.shows(0.001):
        return box(0.002, length, 0.022)
    outline = rounded(corners, np.array([0.0, 0.0005, 0.0005, 0.003, 0.0005, 0.0]), tol)
    return moved(extrude(outline, -length / 2.0, length / 2.0), turned("x", np.pi / 2.0))


def lug(width: float, height: float, thickness: float, bore: float, tol: Tolerance) -> Mesh:
    """A mounting lug on z = 0: base plate and an upright eye with a bore, the eye's axis along y."""
    radius = 0.42 * width
    foot = plate(1.6 * width, 1.2 * width, 0.012, 2, 2, 0.0065, tol)
    eye = moved(
        extrude(_half_round(width, height, radius, tol), -thickness / 2.0, thickness / 2.0), turned("x", np.pi / 2.0)
    )
    bush = hardware.ring(bore, 1.4 * bore, 1.2 * thickness, tol)
    at_eye = at(y=0.6 * thickness, z=height - radius) @ turned("x", np.pi / 2.0)
    return merge([foot, eye, moved(bush, at_eye)])


def _half_round(width: float, height: float, radius: float, tol: Tolerance) -> Floats:
    n = tol.segments(radius, np.pi, 3)
    angle = np.linspace(0.0, np.pi, n + 1)
    top = np.stack([radius * np.cos(angle), height - radius + radius * np.sin(angle)], axis=1)
    return np.concatenate([[[width / 2.0, 0.01]], top, [[-width / 2.0, 0.01]]])
