"""The aero-engine's core: casings, compressors, combustor, turbines, shafts, from z = 0 (front) to z = 3 m."""

from __future__ import annotations

import math

import numpy as np

from . import blades, hardware
from .casings import Shell, add_shell, liner, ring_profile
from .layout import Surface
from .mesh import Mesh, around, at, circle_angles
from .plan import Plan
from .rotors import Row, add_bearing, add_rotor, add_stator, shaft, spinner
from .shapes import revolve_sector
from .tessellation import Tolerance


class Amount:
    """How many of each thing: grows with the root of the mock-up's size; 1 for an engine of 5.2 million triangles."""

    def __init__(self, richness: float) -> None:
        self.richness = richness

    @property
    def rich(self) -> bool:
        """Whether the smallest parts (nuts, screws of clamps) are worth having."""
        return self.richness > 0.125

    @property
    def tiny(self) -> bool:
        """Whether there is room for the main parts only."""
        return self.richness < 0.07

    def many(self, count: float, low: int = 1, high: int = 100_000, power: float = 1.0) -> int:
        """`count` at richness 1, growing with its `power`, kept between `low` and `high`."""
        wish = count * math.pow(self.richness, power)
        return min(high, max(low, round(wish)))

    def bolts(self, radius: float) -> int:
        """Bolts on a joint of that radius; an even number."""
        most = int(2.0 * np.pi * radius / 0.026)
        return 2 * max(3 if self.rich else 2, min(most // 2, round(self.many(105.0 * radius, 3, most) / 2.0)))

    def blades(self, radius: float, gap: float) -> int:
        """Blades in a row that stand `gap` apart at `radius` in the engine at richness 1."""
        full = 2.0 * np.pi * radius / gap
        count = round(full * min(1.25, math.pow(self.richness, 0.7)))
        return max(7 if self.richness > 0.1 else 6, min(int(1.5 * full), count))


# z0, z1, inner radius at both: the outer casing
OUTER = (
    ("front_frame", 0.02, 0.20, 0.455, 0.455),
    ("lp_compressor", 0.20, 0.56, 0.455, 0.45),
    ("intermediate", 0.56, 0.80, 0.45, 0.44),
    ("bypass_front", 0.80, 1.14, 0.44, 0.43),
    ("bypass_rear", 1.14, 1.50, 0.43, 0.43),
    ("combustor_outer", 1.50, 1.94, 0.43, 0.44),
    ("hp_turbine", 1.94, 2.16, 0.44, 0.46),
    ("lp_turbine", 2.16, 2.62, 0.46, 0.50),
    ("rear_frame", 2.62, 2.86, 0.50, 0.50),
)
INNER = (
    ("hp_compressor_front", 0.82, 1.12, 0.352, 0.338),
    ("hp_compressor_rear", 1.12, 1.50, 0.338, 0.318),
    ("combustor_inner", 1.52, 1.92, 0.24, 0.24),
)


def outer_surface() -> Surface:
    """The outside of the outer casing."""
    z = np.array([row[1] for row in OUTER] + [OUTER[-1][2]])
    radius = np.array([max(row[3], row[4]) + 0.003 for row in OUTER])
    return Surface(z, radius, radius + 0.034)


def add_casings(plan: Plan, amount: Amount, *, inner: bool = True, outer: bool = True) -> None:
    """Outer and inner casings, with their joints."""
    if outer:
        for row in OUTER:
            add_outer(plan, amount, row)
    if inner:
        for name, z0, z1, r0, r1 in INNER:
            bolts = amount.bolts(r0)
            add_shell(
                plan, f"casings/{name}", Shell(z0, z1, r0, r1, flange=0.022, bolts=bolts, bolt_size=0.006, ribs=3)
            )


def add_outer(plan: Plan, amount: Amount, row: tuple[str, float, float, float, float]) -> None:
    """One section of the outer casing (a row of `OUTER`), with its rear joint."""
    name, z0, z1, r0, r1 = row
    shell = Shell(z0, z1, r0, r1, bolts=amount.bolts(0.47), ribs=2 if z1 - z0 < 0.3 else 4)
    add_shell(plan, f"casings/{name}", shell)


def add_frames(plan: Plan, amount: Amount) -> None:
    """The struts and hubs of front, intermediate and rear frames."""
    for name, z, hub, tip, chord in (
        ("front_frame", 0.11, 0.15, 0.456, 0.11),
        ("intermediate", 0.68, 0.20, 0.452, 0.16),
        ("rear_frame", 2.74, 0.20, 0.502, 0.14),
    ):
        count = amount.many(10, 5, 14, 0.3)
        plan.add(
            f"frames/{name}/strut", plan.shape(blades.strut, hub, tip, chord), around(circle_angles(count), 0.0, z)
        )
        if amount.tiny:
            continue
        half = chord * 0.6
        hub_ring = ((hub - 0.012, -half), (hub + 0.004, -half), (hub + 0.004, half), (hub - 0.012, half))
        plan.add(f"frames/{name}/hub", plan.shape(ring_profile, hub_ring, 0.003), at(z=z))
        bolts = amount.many(16, 3, 40)
        angle = circle_angles(bolts, 0.1)
        poses = around(angle, hub - 0.007, z + half, "axial")
        plan.add(f"frames/{name}/hub_bolt", plan.shape(hardware.hex_bolt, 0.006, 0.03), poses)


def add_compressors(plan: Plan, amount: Amount) -> None:
    """Low and high pressure compressors: rotors and stators in turn."""
    plan.add("lp_compressor/spinner", plan.shape(spinner, 0.16, 0.16), at(z=0.19))
    stages = amount.many(3, 2, 3, 0.2)
    for k in range(stages):
        base = f"lp_compressor/stage_{k + 1:02d}"
        z, hub = 0.235 + 0.115 * k, 0.20 + 0.015 * k
        tip = 0.448 - 0.002 * k
        rotor = Row(z, hub, tip, amount.blades(hub, 0.046), 0.07, (0.35, 1.0))
        add_rotor(plan, base, rotor, 0.085, amount.many(16, 3, 32), not amount.tiny)
        add_stator(
            plan,
            base,
            Row(z + 0.06, hub + 0.006, tip - 0.002, amount.blades(hub, 0.034), 0.042, (0.3, 0.45)),
            not amount.tiny,
        )
    stages = amount.many(7, 3, 9, 0.35)
    for k in range(stages):
        share = k / (stages - 1)
        base = f"hp_compressor/stage_{k + 1:02d}"
        pitch = 0.64 / stages
        z = 0.86 + pitch * k
        hub, tip = 0.235 + 0.04 * share, 0.345 - 0.031 * share
        chord = 0.42 * pitch * (1.1 - 0.25 * share)
        rotor = Row(z, hub, tip, amount.blades(hub, 0.75 * chord), chord, (0.5, 1.0))
        add_rotor(plan, base, rotor, 0.125, amount.many(16, 3, 32), not amount.tiny)
        vanes = Row(
            z + 0.5 * pitch, hub + 0.004, tip - 0.001, amount.blades(hub, 0.62 * chord), 0.85 * chord, (0.3, 0.5)
        )
        add_stator(plan, base, vanes, not amount.tiny)


def add_combustor(plan: Plan, amount: Amount) -> None:
    """Liners, fuel injectors with their manifold, igniters."""
    plan.add("combustor/liner_outer", plan.shape(liner, 1.56, 1.92, 0.375, 0.40, 0.0025, 12), np.eye(4))
    plan.add("combustor/liner_inner", plan.shape(liner, 1.56, 1.92, 0.275, 0.265, 0.0025, 12), np.eye(4))
    dome = ((0.275, 1.55), (0.372, 1.55), (0.372, 1.562), (0.33, 1.556), (0.275, 1.562))
    plan.add("combustor/dome", plan.shape(ring_profile, dome, 0.002), np.eye(4))
    count = amount.many(20, 6, 28, 0.5)
    angle = circle_angles(count, 0.05)
    plan.add("combustor/injector", plan.shape(hardware.injector, 0.12), around(angle, 0.446, 1.50, "radial"))
    pairs = (-2.0, 2.0) if amount.rich else (2.0,)
    bolts = np.concatenate([around(angle + side * 0.0125 / 0.44, 0.449, 1.50) for side in pairs])
    plan.add("combustor/injector_bolt", plan.shape(hardware.hex_bolt, 0.006, 0.02), bolts)
    plan.add("combustor/igniter", plan.shape(hardware.igniter, 0.075), around(np.array([0.8, 2.3]), 0.452, 1.66))
    if amount.tiny:
        return
    manifold = ((0.500, -0.007), (0.514, -0.007), (0.514, 0.007), (0.500, 0.007))
    plan.add("combustor/fuel_manifold", plan.shape(ring_profile, manifold, 0.0065), at(z=1.555))
    swirlers = around(angle, 0.325, 1.545, "axial")
    plan.add("combustor/swirler", plan.shape(hardware.ring, 0.018, 0.03, 0.02), swirlers)


def add_turbines(plan: Plan, amount: Amount, extra_stages: int = 0) -> None:
    """High and low pressure turbines: vanes before rotors, shroud segments outside."""
    for k in range(amount.many(2, 1, 2, 0.3)):
        base = f"hp_turbine/stage_{k + 1:02d}"
        z, hub, tip = 1.965 + 0.1 * k, 0.30 + 0.004 * k, 0.385 + 0.02 * k
        add_stator(plan, base, Row(z, hub, tip, amount.blades(hub, 0.038), 0.048, (0.2, 0.35), 0.12), not amount.tiny)
        rotor = Row(z + 0.05, hub, tip, amount.blades(hub, 0.026), 0.036, (0.35, 0.8), 0.13)
        add_rotor(plan, base, rotor, 0.125, amount.many(18, 3, 36), not amount.tiny)
        _shrouds(plan, amount, base, z + 0.05, tip + 0.001, 0.04)
    stages = amount.many(3, 1, 4, 0.3) + extra_stages
    for k in range(stages):
        share = k / max(1, stages - 1)
        base = f"lp_turbine/stage_{k + 1:02d}"
        pitch = 0.42 / stages
        z = 2.2 + pitch * k
        hub, tip = 0.30 - 0.01 * share, 0.42 + 0.05 * share
        chord = min(0.05, 0.42 * pitch)
        add_stator(
            plan, base, Row(z, hub, tip, amount.blades(hub, 0.7 * chord), chord, (0.25, 0.4), 0.11), not amount.tiny
        )
        row = Row(z + 0.48 * pitch, hub, tip, amount.blades(hub, 0.55 * chord), 0.85 * chord, (0.3, 0.85), 0.12)
        add_rotor(plan, base, row, 0.09, amount.many(18, 3, 36), not amount.tiny)
        _shrouds(plan, amount, base, z + 0.48 * pitch, tip + 0.001, chord)


def _shrouds(plan: Plan, amount: Amount, base: str, z: float, r: float, width: float) -> None:
    count = amount.many(14, 3, 28, 0.7)
    gap = 2.0 * np.pi / count
    segment = plan.shape(_shroud, r, width, 0.985 * gap)
    poses = np.zeros((count, 4, 4))
    poses[:, [0, 1], [0, 1]] = np.cos(circle_angles(count))[:, None]
    poses[:, 1, 0] = np.sin(circle_angles(count))
    poses[:, 0, 1] = -poses[:, 1, 0]
    poses[:, 2, 2] = poses[:, 3, 3] = 1.0
    poses[:, 2, 3] = z
    plan.add(f"{base}/shroud_segment", segment, poses)


def _shroud(r: float, width: float, angle: float, tol: Tolerance) -> Mesh:
    half = width / 2.0
    return revolve_sector(np.array([(r, -half), (r + 0.008, -half), (r + 0.008, half), (r, half)]), 0.0, angle, tol)


def add_shafts(plan: Plan, amount: Amount) -> None:
    """The two shafts, one inside the other, with their bearings."""
    plan.add("lp_shaft/tube", plan.shape(shaft, 0.0, 3.0, 0.052, 0.044, 4), np.eye(4))
    plan.add("hp_shaft/tube", plan.shape(shaft, 0.80, 2.15, 0.105, 0.096, 3), np.eye(4))
    for number, (z, inner, outer, rollers) in enumerate(
        (
            (0.06, 0.056, 0.12, False),
            (0.66, 0.056, 0.125, False),
            (0.79, 0.108, 0.17, False),
            (2.17, 0.108, 0.165, True),
            (2.72, 0.056, 0.12, True),
        ),
        start=1,
    ):
        base = f"bearings/bearing_{number}"
        if amount.tiny:
            plan.add(f"{base}/ring", plan.shape(hardware.ring, inner, outer, 0.03), at(z=z - 0.015))
            continue
        add_bearing(plan, base, z, inner, outer, amount.many(26, 7, 40, 0.5), rollers)
        housing = ((outer, -0.04), (outer + 0.012, -0.04), (outer + 0.03, 0.03), (outer + 0.03, 0.04), (outer, 0.04))
        plan.add(f"{base}/housing", plan.shape(ring_profile, housing, 0.003), at(z=z))
        bolts = amount.many(12, 3, 30)
        poses = around(circle_angles(bolts, 0.2), outer + 0.02, z + 0.04, "axial")
        plan.add(f"{base}/bolt", plan.shape(hardware.hex_bolt, 0.006, 0.03), poses)


def add_exhaust(plan: Plan, amount: Amount) -> None:
    """Tail cone and exhaust duct."""
    cone = ((0.198, 2.80), (0.204, 2.80), (0.16, 2.92), (0.07, 3.0), (0.064, 3.0), (0.154, 2.92))
    plan.add("exhaust/cone", plan.shape(ring_profile, cone, 0.05), np.eye(4))
    plan.add("exhaust/duct", plan.shape(liner, 2.86, 3.0, 0.498, 0.47, 0.004, 3), np.eye(4))
