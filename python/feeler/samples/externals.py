"""Parts mounted around a casing: pipes with clamps and brackets, harness, boxes, valves, the accessory gearbox."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import gears, hardware
from .casings import ring_profile
from .layout import Room, Surface, block
from .mesh import Floats, Mesh, around, at, circle_angles, framed, turned, unit
from .plan import Plan, Shape
from .shapes import bent_path, revolve_sector, tube
from .tessellation import Tolerance, rounded

# system, share of all pipes, outer radii in metres
SYSTEMS: tuple[tuple[str, float, tuple[float, ...]], ...] = (
    ("fuel", 0.26, (0.0048, 0.0064, 0.008, 0.0095)),
    ("oil", 0.22, (0.0064, 0.008, 0.0127)),
    ("air", 0.18, (0.0095, 0.0127, 0.016)),
    ("hydraulic", 0.14, (0.0048, 0.008)),
    ("drain", 0.12, (0.004, 0.0048)),
    ("bleed", 0.08, (0.019, 0.0254)),
)


@dataclass(frozen=True)
class Run:
    """One pipe's way around the casing, in angle and z: along z, around at `z_turn`, along z again; at radius `r`."""

    angle: tuple[float, float]
    z: tuple[float, float]
    z_turn: float
    r: float

    def around_angles(self) -> Floats:
        """The angles of the leg around the casing, every 12 degrees or so."""
        span = self.angle[1] - self.angle[0]
        return np.linspace(self.angle[0], self.angle[1], max(2, int(abs(span) / 0.2) + 1))

    def samples(self) -> Floats:
        """Cylindrical points (n, 3) along the way, about every centimetre."""
        legs = []
        for angle, z in zip(self.angle, self.z, strict=True):
            heights = np.linspace(z, self.z_turn, max(2, int(abs(self.z_turn - z) / 0.01)))
            legs.append(np.stack([np.full(len(heights), angle), heights, np.full(len(heights), self.r)], axis=1))
        turn = np.linspace(*self.angle, max(2, int(abs(self.angle[1] - self.angle[0]) * self.r / 0.01)))
        legs.append(np.stack([turn, np.full(len(turn), self.z_turn), np.full(len(turn), self.r)], axis=1))
        return np.concatenate(legs)


def in_space(angle: Floats | float, z: Floats | float, r: Floats | float) -> Floats:
    """Cylindrical to plain coordinates, (n, 3)."""
    a, h, radius = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=np.float64)) for v in (angle, z, r)))
    return np.stack([radius * np.cos(a), radius * np.sin(a), h], axis=1)


class Dresser:
    """Dresses a casing, remembering which room is taken."""

    def __init__(
        self, plan: Plan, surface: Surface, base: str, z_range: tuple[float, float], rich: bool, details: bool
    ) -> None:
        self.rich, self.details = rich, details  # whether there is room for the smallest parts; for small ones
        self.plan, self.surface, self.base, self.z_range = plan, surface, base, z_range
        self.room = Room(z_range[0] - 0.1, z_range[1] + 0.1, float(surface.radius.min()))

    def pipes(self, count: int) -> None:
        """Pipes of all systems with unions, bosses, clamps, brackets and screws."""
        numbers: dict[str, int] = {}
        shares = np.array([share for _, share, _ in SYSTEMS])
        # the big ones first: they find room more easily
        kinds = np.sort(self.plan.rng.choice(len(SYSTEMS), size=count, p=shares / shares.sum()))[::-1]
        for kind in kinds:
            system, _, radii = SYSTEMS[kind]
            numbers[system] = numbers.get(system, 0) + 1
            radius = float(self.plan.rng.choice(np.array(radii)))
            self._pipe(f"{self.base}/{system}_pipe_{numbers[system]:02d}", radius)

    def _pipe(self, base: str, radius: float) -> None:
        run = self._free_run(radius)
        self.room.take(run.samples())
        surface = self.surface
        corners, bends = _corners(run, radius, surface)
        bore = radius - max(0.0007, 0.09 * radius)
        self.plan.add(f"{base}/tube", Shape(lambda tol: _pipe_mesh(corners, bends, radius, bore, tol)), np.eye(4))
        ends = around(np.array(run.angle), np.array([surface.at(z) for z in run.z]), np.array(run.z))
        self.plan.add(f"{base}/boss", self.plan.shape(hardware.boss, radius * 1.8 + 0.003, 0.012, radius), ends)
        self.plan.add(f"{base}/union", self.plan.shape(hardware.union, radius), ends @ at(z=0.012))
        self._clamps(base, run, radius)

    def _free_run(self, radius: float) -> Run:
        rng, best, least = self.plan.rng, None, np.inf
        low, high = self.z_range
        for _ in range(14):
            angle = float(rng.uniform(0.0, 2.0 * np.pi))
            span = float(rng.choice([-1.0, 1.0]) * (0.35 + rng.exponential(0.75)))
            span = float(np.clip(span, -2.6, 2.6))
            z = np.clip(rng.uniform(low, high) + np.array([-0.5, 0.5, 0.0]) * (0.25 + rng.exponential(0.5)), low, high)
            turn = float(rng.uniform(z[0] + 0.06, max(z[1] - 0.06, z[0] + 0.07)))
            layer = 0.014 + 1.4 * radius + 0.02 * min(5, int(rng.exponential(1.4)))
            r = self.surface.top(float(z[0]), float(z[1])) + layer
            run = Run((angle, angle + span), (float(z[0]), float(z[1])), turn, r)
            cost = self.room.clashes(run.samples()) + 60.0 * layer
            if cost < least:
                best, least = run, cost
        assert best is not None
        return best

    def _clamps(self, base: str, run: Run, radius: float) -> None:
        spacing = (0.11 if self.rich else 0.22) + 4.0 * radius
        poses: list[Floats] = []
        for angle, z in zip(run.angle, run.z, strict=True):
            length = abs(run.z_turn - z) - 2.0 * _margin(radius)
            count = int(length / spacing + 0.7)
            if count > 0:
                share = (np.arange(count) + 0.5) / count
                sign = np.sign(run.z_turn - z)
                heights = z + sign * (_margin(radius) + share * length)
                poses.append(_clamp_poses(np.full(count, angle), heights, run.r, around_axis=False))
        length = abs(run.angle[1] - run.angle[0]) * run.r - 2.0 * _margin(radius)
        count = int(length / spacing + 0.7)
        if count > 0:
            share = (_margin(radius) + (np.arange(count) + 0.5) / count * length) / (length + 2.0 * _margin(radius))
            angles = run.angle[0] + share * (run.angle[1] - run.angle[0])
            poses.append(_clamp_poses(angles, np.full(count, run.z_turn), run.r, around_axis=True))
        if not poses:
            return
        clamp = np.concatenate(poses)
        plan = self.plan
        plan.add(f"{base}/clamp", plan.shape(hardware.saddle_clamp, radius), clamp)
        foot = hardware.clamp_foot(radius)
        up = turned("x", -np.pi / 2.0)
        screw = plan.shape(hardware.cap_screw, 0.005, 0.009)
        sides_kept = (-1.0, 1.0) if self.rich else ()
        sides = [clamp @ at(x=side * foot, y=-(radius + 0.0002)) @ up for side in sides_kept]
        if sides:
            plan.add(f"{base}/screw", screw, np.concatenate(sides))
        # brackets: their heights in steps of 6 mm, so that there are few kinds
        gap = [run.r - radius - 0.002 - self.surface.at(float(pose[2, 3])) for pose in clamp]
        steps = np.ceil((np.array(gap) + 0.002) / 0.006).astype(np.int64)
        for step in np.unique(steps):
            shape = plan.shape(hardware.standoff, 2.0 * foot + 0.012, round(float(step) * 0.006, 4), 0.018)
            plan.add(f"{base}/bracket", shape, clamp[steps == step] @ at(y=-(radius + 0.002)))

    def harness(self, count: int) -> None:
        """Cables: thin, wavy, in small bundles, with connectors at their ends and ties."""
        rng, plan = self.plan.rng, self.plan
        low, high = self.z_range
        for number in range(1, count + 1):
            base = f"{self.base}/harness_{number:02d}"
            start, end = np.sort(rng.uniform(low, high, 2))
            end = min(float(end) + 0.12, high)
            angle, span = float(rng.uniform(0.0, 2.0 * np.pi)), float(rng.normal(0.0, 0.9))
            r = self.surface.top(float(start), end) + float(rng.uniform(0.012, 0.05))
            knots = max(8, int((end - start) / 0.055))
            share = np.linspace(0.0, 1.0, knots)
            eased = share * share * (3.0 - 2.0 * share)
            wave = rng.normal(0.0, 0.006, (knots, 3)) * np.minimum(1.0, 4.0 * share * (1.0 - share))[:, None]
            middle = in_space(angle + span * eased, start + (end - start) * share, r) + wave
            radius = float(rng.choice(np.array([0.0025, 0.0035, 0.005])))
            strands = int(rng.integers(1, 4))
            for strand in range(strands):
                turn = 2.0 * np.pi * strand / strands + 3.0 * share
                side = 1.05 * radius * (1.0 if strands > 1 else 0.0)
                outward = unit(middle * [1.0, 1.0, 0.0])
                along = np.cross([0.0, 0.0, 1.0], outward)
                line = middle + side * (np.cos(turn)[:, None] * outward + np.sin(turn)[:, None] * along)
                plan.add(f"{base}/cable_{strand + 1}", _cable_shape(line, radius), np.eye(4))
            ends = np.stack([np.array([angle, start]), np.array([angle + span, end])])
            z_way = np.array([-1.0, 1.0])[:, None] * [0.0, 0.0, 1.0]
            outward = unit(in_space(ends[:, 0], 0.0, 1.0))
            plug = framed(in_space(ends[:, 0], ends[:, 1], r), np.cross(outward, z_way), outward, z_way)
            size = 2.2 * radius + 0.004
            plan.add(f"{base}/connector", plan.shape(hardware.connector, size, 0.045), plug @ at(z=-0.01))

    def boxes(self, count: int) -> None:
        """Electronic control boxes on the casing, each with connectors and feet bolts."""
        rng, plan = self.plan.rng, self.plan
        sizes = ((0.20, 0.26, 0.075), (0.14, 0.18, 0.06), (0.11, 0.12, 0.05), (0.09, 0.16, 0.045))
        low, high = self.z_range
        for number in range(1, count + 1):
            x, y, z = sizes[int(rng.integers(len(sizes)))]
            best, least = (0.0, 0.0, 0.0), np.inf
            for _ in range(20):
                angle = float(rng.uniform(-0.35, np.pi + 0.35))  # above the gearbox
                height = float(rng.uniform(low + 0.6 * y, high - 0.6 * y))
                r = self.surface.top(height - 0.6 * y, height + 0.6 * y) + 0.004
                half = 0.6 * x / r
                cells = block((angle - half, angle + half), (height - 0.6 * y, height + 0.6 * y), (r, r + z + 0.02))
                cost = self.room.clashes(cells)
                if cost < least:
                    best, least = (angle, height, r), cost
            angle, height, r = best
            half = 0.6 * x / r
            self.room.take(block((angle - half, angle + half), (height - 0.6 * y, height + 0.6 * y), (r, r + z + 0.02)))
            base = f"{self.base}/control_box_{number:02d}"
            pose = around(angle, r, height)[0]
            plan.add(f"{base}/body", plan.shape(hardware.control_box, x, y, z, 7), pose)
            corners = [(sx * (x + 0.012), sy * y * 0.8) for sx in (-0.5, 0.5) for sy in (-0.5, 0.5)]
            bolts = np.stack([pose @ at(cx, cy, 0.008) for cx, cy in corners])
            plan.add(f"{base}/bolt", plan.shape(hardware.hex_bolt, 0.006, 0.02), bolts)
            plugs = max(1, int(x / 0.05))
            face = turned("x", np.pi / 2.0)
            places = [at((k + 0.5 - plugs / 2.0) * 0.045, -y / 2.0, 0.55 * z) @ face for k in range(plugs)]
            plan.add(f"{base}/connector", plan.shape(hardware.connector, 0.013, 0.05), pose @ np.stack(places))

    def valves(self, count: int) -> None:
        """Valves standing free on the casing, with their ring of bolts."""
        rng, plan = self.plan.rng, self.plan
        for number in range(1, count + 1):
            radius = float(rng.choice(np.array([0.014, 0.02, 0.028])))
            z = float(rng.uniform(self.z_range[0] + 0.1, self.z_range[1] - 0.1))
            angle = float(rng.uniform(0.0, 2.0 * np.pi))
            r = self.surface.top(z - 2.0 * radius, z + 2.0 * radius) + 1.6 * radius
            half = 2.0 * radius / r
            cells = block((angle - half, angle + half), (z - 2 * radius, z + 2 * radius), (r, r + 4 * radius))
            self.room.take(cells)
            base = f"{self.base}/valve_{number:02d}"
            pose = around(angle, r, z, "axial")[0]
            plan.add(f"{base}/body", plan.shape(hardware.valve, radius), pose)
            if not self.rich:
                continue
            ring = pose @ at(x=2.15 * radius) @ turned("y", np.pi / 2.0)
            bolts = [ring @ at(1.05 * radius * np.cos(a), 1.05 * radius * np.sin(a)) for a in circle_angles(6)]
            plan.add(f"{base}/screw", plan.shape(hardware.cap_screw, 0.004, 0.01), np.stack(bolts))

    def bosses(self, count: int) -> None:
        """Inspection bosses with plugs, scattered over the casing."""
        rng, plan = self.plan.rng, self.plan
        z = rng.uniform(self.z_range[0] + 0.03, self.z_range[1] - 0.03, count)
        poses = around(rng.uniform(0.0, 2.0 * np.pi, count), np.array([self.surface.at(float(h)) for h in z]), z)
        plan.add(f"{self.base}/inspection_boss", plan.shape(hardware.boss, 0.014, 0.01, 0.006), poses)
        plug = plan.shape(hardware.hex_bolt, 0.011, 0.012)
        plan.add(f"{self.base}/inspection_plug", plug, poses @ at(z=0.01))

    def rivets(self, count: int) -> None:
        """Filler: rivets in rows on the casing; as many as the requested size needs."""
        rng, plan = self.plan.rng, self.plan
        rows = max(1, count // 60)
        for _ in range(rows):
            z = float(rng.uniform(*self.z_range))
            angles = float(rng.uniform(0.0, 6.28)) + 0.02 * np.arange(60)
            poses = around(angles, self.surface.at(z), z)
            plan.add_filler(f"{self.base}/rivet", plan.shape(hardware.rivet, 0.004), poses)

    def gearbox(self, z: float, accessories: int) -> None:
        """The accessory gearbox under the casing: curved body, gear train, accessories on both faces."""
        plan, base = self.plan, f"{self.base}/accessory_gearbox"
        inner = self.surface.top(z - 0.05, z + 0.18) + 0.03
        deep, wide, half = 0.13, 0.12, 0.72
        down = -np.pi / 2.0
        plan.add(f"{base}/housing", plan.shape(_gearbox_body, inner, deep, z, wide, down - half, 2.0 * half), np.eye(4))
        self.room.take(block((down - half, down + half), (z - 0.3, z + wide + 0.35), (inner, inner + deep)))
        middle = inner + deep / 2.0
        count = max(3, min(7, accessories))
        angles = np.linspace(down - half * 0.82, down + half * 0.82, count)
        spacing = 2.0 * middle * np.sin(0.5 * (angles[1] - angles[0]))
        teeth = 28 if self.rich else 14
        module = float(spacing / teeth)
        turn = 0.0
        for k in range(count if self.details else 0):
            pose = at(*in_space(angles[k], z + wide / 2.0, middle)[0])
            gear = plan.shape(gears.spur_gear, teeth, module, 0.02, 0.012, 0.0)
            plan.add(f"{base}/gear_{k + 1}", gear, pose @ turned("z", turn))
            plan.add(f"{base}/shaft_{k + 1}", plan.shape(_plain_shaft, 0.0115, wide * 1.05), pose)
            if k + 1 < count:
                way = in_space(angles[k + 1], 0.0, middle)[0] - in_space(angles[k], 0.0, middle)[0]
                turn = gears.mate_turn(turn, teeth, teeth, float(np.arctan2(way[1], way[0])))
        names = ("fuel_pump", "oil_pump", "starter", "generator", "hydraulic_pump", "scavenge_pump", "breather")
        for k in range(min(accessories, 2 * count)):
            rear = k % 2 == 0
            angle = angles[(k // 2) % count] if accessories > count else angles[k % count]
            name = f"{base}/{names[k % len(names)]}_{k // len(names) + 1}"
            size = min(0.055, 0.46 * float(spacing)) * (0.85 + 0.15 * ((k * 7) % 3))
            length = 0.15 + 0.04 * ((k * 5) % 4)
            make = hardware.generator if k % 7 in (2, 3) else hardware.pump
            pose = around(angle, middle, z + wide if rear else z, "axial" if rear else "back")[0]
            plan.add(f"{name}/body", plan.shape(make, size, length), pose)
            if not self.rich:
                continue
            bolts = [pose @ at(1.02 * size * np.cos(a), 1.02 * size * np.sin(a), 0.012) for a in circle_angles(8)]
            plan.add(f"{name}/bolt", plan.shape(hardware.hex_bolt, 0.006, 0.02), np.stack(bolts))
        if not self.rich:
            return
        edge = np.linspace(down - half * 0.95, down + half * 0.95, max(4, 3 * count))
        for r, row in ((inner + 0.012, "inner"), (inner + deep - 0.012, "outer")):
            screw = plan.shape(hardware.cap_screw, 0.006, 0.03)
            plan.add(f"{base}/cover_screw_{row}", screw, around(edge, r, z + wide, "axial"))

    def rails(self, count: int) -> None:
        """Stiff rings around the casing that carry brackets."""
        low, high = self.z_range
        for number, z in enumerate(np.linspace(low + 0.1, high - 0.1, count), start=1):
            r = self.surface.at(float(z)) - 0.001
            shape = ((r, -0.008), (r + 0.014, -0.008), (r + 0.014, 0.008), (r, 0.008))
            self.plan.add(f"{self.base}/rail_{number:02d}", self.plan.shape(ring_profile, shape, 0.002), at(z=float(z)))


def _margin(radius: float) -> float:
    return 0.03 + 2.5 * radius


def _clamp_poses(angle: Floats, z: Floats, r: float, *, around_axis: bool) -> Floats:
    """Clamp frames (k, 4, 4): z along the pipe, y outwards."""
    outward, along = in_space(angle, 0.0, 1.0), in_space(angle + np.pi / 2.0, 0.0, 1.0)
    axis = np.broadcast_to([0.0, 0.0, 1.0], outward.shape)
    way = along if around_axis else axis
    return framed(in_space(angle, z, r), np.cross(outward, way), outward, way)


def _corners(run: Run, radius: float, surface: Surface) -> tuple[Floats, Floats]:
    """Corner points of a run with its two ends, and the bend radius at each."""
    turn = run.around_angles()
    feet = [surface.at(z) + 0.018 for z in run.z]
    points = np.concatenate(
        [
            in_space(run.angle[0], run.z[0], np.array([feet[0], run.r])),
            in_space(turn, run.z_turn, run.r / np.cos(0.5 * (turn[1] - turn[0]))),
            in_space(run.angle[1], run.z[1], np.array([run.r, feet[1]])),
        ]
    )
    points[[2, -3]] = in_space(turn[[0, -1]], run.z_turn, run.r)
    bends = np.full(len(points), 5.0)  # around the casing: as round as there is room for
    bends[[1, 2, -3, -2]] = 0.012 + 2.6 * radius
    return points, bends


def _pipe_mesh(corners: Floats, bends: Floats, radius: float, bore: float, tol: Tolerance) -> Mesh:
    return tube(bent_path(corners, bends, radius, tol), radius, bore, tol)


def _cable_shape(line: Floats, radius: float) -> Shape:
    def make(tol: Tolerance) -> Mesh:
        step = 1 if tol.shows(0.002) else (4 if tol.coarse else 2)
        kept = line if step == 1 else np.concatenate([line[:-1:step], line[-1:]])
        return tube(bent_path(kept, 5.0, radius, tol), radius, 0.0, tol, least=3 if tol.coarse else 5)

    return Shape(make)


def _gearbox_body(inner: float, deep: float, z: float, wide: float, start: float, angle: float, tol: Tolerance) -> Mesh:
    """A curved channel, open towards the casing."""
    t = 0.006
    low, top, out = z + t, z + wide - t, inner + deep
    profile = np.array(
        [
            (inner, z), (out, z), (out, z + wide), (inner, z + wide), (inner, top), (out - t, top), (out - t, low),
            (inner, low),
        ]
    )  # fmt: skip
    return revolve_sector(rounded(profile, 0.004, tol), start, angle, tol)


def _plain_shaft(radius: float, length: float, tol: Tolerance) -> Mesh:
    return hardware.roller(radius, length, tol)
