"""The differential: a gear box with a bevel drive, differential bevels, a spur gear train, bearings and a housing."""

from __future__ import annotations

import numpy as np

from . import gears, hardware
from .casings import Shell, add_shell, flanged_shell, panel, ring_profile
from .core_engine import Amount
from .mesh import Floats, Mesh, around, at, circle_angles, framed, moved, turned
from .plan import Plan
from .rotors import add_bearing, shaft
from .shapes import plate, rounded_box
from .tessellation import Tolerance

RING_TEETH, PINION_TEETH, RING_MODULE = 40, 12, 0.006
SIDE_TEETH, SPIDER_TEETH, SPIDER_MODULE = 16, 10, 0.0042
TRAIN_MODULE = 0.003


def axis_frame(
    origin: tuple[float, float, float], z: tuple[float, float, float], x: tuple[float, float, float]
) -> Floats:
    """The pose whose z and x axes are given, (4, 4)."""
    return np.asarray(framed([origin], [x], [np.cross(z, x)], [z])[0])


def bevel_poses() -> dict[str, tuple[tuple[int, int], Floats]]:
    """Teeth (own, mate's) and pose (4, 4) of each differential bevel gear; the common apex is the origin.

    Side gears look along +z and -z, spiders along +-x and +-y. Each spider's gap faces the side gears' teeth.
    """
    poses: dict[str, tuple[tuple[int, int], Floats]] = {}
    for name, sign in (("side_gear_1", 1.0), ("side_gear_2", -1.0)):
        poses[name] = (SIDE_TEETH, SPIDER_TEETH), axis_frame((0, 0, 0), (0, 0, sign), (1, 0, 0))
    gap = turned("z", np.pi / SPIDER_TEETH)
    for k, way in enumerate(((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)), start=1):
        poses[f"spider_gear_{k}"] = (SPIDER_TEETH, SIDE_TEETH), axis_frame((0, 0, 0), way, (0, 0, 1)) @ gap
    return poses


def drive_poses() -> tuple[Floats, Floats]:
    """Poses of ring gear (axis +z) and pinion (axis +x), meshing."""
    return np.eye(4), axis_frame((0, 0, 0), (1, 0, 0), (0, 0, 1)) @ turned("z", np.pi / PINION_TEETH)


def add_differential(plan: Plan, amount: Amount) -> None:
    """The whole gear box, about 0.7 m across; the output axis is z, the input comes along x."""
    _bevels(plan, amount)
    _output(plan, amount)
    _train(plan, amount)
    _housing(plan, amount)


def _bevels(plan: Plan, amount: Amount) -> None:
    ring, pinion = drive_poses()
    shape = plan.shape(gears.bevel_gear, RING_TEETH, PINION_TEETH, RING_MODULE, 0.03, 0.072)
    plan.add("drive/ring_gear", shape, ring)
    shape = plan.shape(gears.bevel_gear, PINION_TEETH, RING_TEETH, RING_MODULE, 0.03, 0.014)
    plan.add("drive/pinion", shape, pinion)
    for name, ((teeth, mate), pose) in bevel_poses().items():
        bore = 0.014 if name.startswith("side") else 0.0075
        plan.add(f"differential/{name}", plan.shape(gears.bevel_gear, teeth, mate, SPIDER_MODULE, 0.012, bore), pose)
        if name.startswith("spider"):
            washer = plan.shape(hardware.ring, 0.008, 0.02, 0.002)
            plan.add(f"differential/{name}_washer", washer, pose @ at(z=0.0425))
    for k, turn in enumerate((turned("y", np.pi / 2.0), turned("x", np.pi / 2.0)), start=1):
        plan.add(f"differential/spider_pin_{k}", plan.shape(hardware.roller, 0.0073, 0.11 - 0.016 * k + 0.016), turn)
    cage = ((0.060, -0.045), (0.070, -0.045), (0.070, 0.04), (0.088, 0.04), (0.088, 0.05), (0.060, 0.05))
    plan.add("differential/case", plan.shape(ring_profile, cage, 0.002), np.eye(4))
    bolts = amount.many(12, 6, 24, 0.5)
    cap = plan.shape(hardware.hex_bolt, 0.008, 0.025)
    plan.add("differential/case_bolt", cap, around(circle_angles(bolts), 0.0795, 0.04, "back"))


def _output(plan: Plan, amount: Amount) -> None:
    for side, sign in (("left", 1.0), ("right", -1.0)):
        base = f"output_{side}"
        pose = axis_frame((0, 0, 0), (0, 0, sign), (1, 0, 0))
        plan.add(f"{base}/half_shaft", plan.shape(shaft, 0.03, 0.36, 0.0138, 0.006, 2), pose)
        for number, z in enumerate((0.115, 0.27), start=1):
            name = f"{base}/bearing_{number}"
            add_bearing(plan, name, sign * z, 0.0155, 0.045, amount.many(14, 7, 20), rollers=number == 2)
        hub = ((0.014, 0.36), (0.06, 0.36), (0.06, 0.372), (0.025, 0.376), (0.025, 0.40), (0.014, 0.40))
        plan.add(f"{base}/hub", plan.shape(ring_profile, hub, 0.002), pose)
        count = amount.many(8, 5, 16, 0.5)
        stud = plan.shape(hardware.hex_bolt, 0.012, 0.05)
        plan.add(f"{base}/stud", stud, pose @ around(circle_angles(count), 0.045, 0.36, "back"))
        plan.add(
            f"{base}/stud_nut",
            plan.shape(hardware.nut, 0.012),
            pose @ around(circle_angles(count), 0.045, 0.373, "axial"),
        )
        seal = ((0.0145, 0.295), (0.045, 0.295), (0.045, 0.305), (0.024, 0.305), (0.0145, 0.302))
        plan.add(f"{base}/seal", plan.shape(ring_profile, seal, 0.001), pose)


def train_layout(stages: int) -> list[tuple[str, int, float, float, float, float, float]]:
    """The spur train: per gear its name, teeth, x, y, z, turn and helix; shafts are parallel to x."""
    layout: list[tuple[str, int, float, float, float, float, float]] = []
    y = z = turn = 0.0
    x = 0.245
    helix = 0.26
    for k in range(stages):
        pinion, wheel = 18 + 2 * (k % 3), 44 - 5 * (k % 3)
        angle = (0.9, -0.35, 1.9, 2.8, -2.6, -1.2)[k % 6]
        distance = TRAIN_MODULE * (pinion + wheel) / 2.0
        layout.append((f"stage_{k + 1}/pinion", pinion, x, y, z, turn, helix))
        other = gears.mate_turn(turn, pinion, wheel, angle)
        y, z = y + distance * np.cos(angle), z + distance * np.sin(angle)
        layout.append((f"stage_{k + 1}/wheel", wheel, x, y, z, other, -helix))
        turn = other + 0.37
        x += 0.034
        helix = -helix
    return layout


def _train(plan: Plan, amount: Amount) -> None:
    stages = amount.many(4, 2, 6, 0.3)
    along = axis_frame((0, 0, 0), (1, 0, 0), (0, 1, 0))  # a gear's x, y, z become y, z, x
    seen: list[tuple[float, float]] = []
    for name, teeth, x, y, z, turn, helix in train_layout(stages):
        pose = at(x, y, z) @ along @ turned("z", turn)
        plan.add(f"train/{name}", plan.shape(gears.spur_gear, teeth, TRAIN_MODULE, 0.022, 0.012, helix), pose)
        if (y, z) in seen:
            continue
        seen.append((y, z))
        shaft_name = f"train/shaft_{len(seen)}"
        line = at(0.0, y, z) @ along
        start = 0.085 if len(seen) == 1 else 0.2
        end = 0.245 + 0.034 * stages + 0.03
        plan.add(shaft_name, plan.shape(shaft, start, end, 0.0119, 0.004, 1), line)
        for number, at_x in enumerate((start + 0.018, end - 0.015), start=1):
            base = f"{shaft_name}_bearing_{number}"
            if not amount.rich:
                plan.add(f"{base}/bush", plan.shape(hardware.ring, 0.0121, 0.029, 0.012), line @ at(z=at_x - 0.006))
                continue
            ball_count = amount.many(10, 7, 14, 0.3)
            size = 0.0054
            plan.add(
                f"{base}/inner_race", plan.shape(hardware.race, 0.0121, 0.0165, 0.012, size, False), line @ at(z=at_x)
            )
            plan.add(
                f"{base}/outer_race", plan.shape(hardware.race, 0.0235, 0.029, 0.012, size, True), line @ at(z=at_x)
            )
            balls = line @ around(circle_angles(ball_count), 0.02, at_x, "axial")
            plan.add(f"{base}/ball", plan.shape(hardware.ball, 0.0049), balls)


def _housing(plan: Plan, amount: Amount) -> None:
    bolts = amount.bolts(0.2)
    cone = ((0.046, 0.10), (0.06, 0.10), (0.10, 0.12), (0.18, 0.12), (0.18, 0.132), (0.10, 0.134), (0.07, 0.16))
    cover = (*cone, (0.062, 0.30), (0.046, 0.30))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        pose = axis_frame((0, 0, 0), (0, 0, sign), (1, 0, 0))
        plan.add(f"housing/cover_{side}", plan.shape(ring_profile, cover, 0.004), pose)
        screw = plan.shape(hardware.hex_bolt, 0.008, 0.03)
        poses = pose @ around(circle_angles(bolts), 0.168, 0.132, "axial")
        plan.add(f"housing/cover_{side}_bolt", screw, poses)
        ribs = amount.many(8, 4, 16, 0.5)
        fin = plan.shape(_rib, 0.09, 0.006, 0.05)
        plan.add(f"housing/cover_{side}_rib", fin, pose @ around(circle_angles(ribs, 0.2), 0.105, 0.125, "axial"))
    back = plan.shape(panel, -0.12, 0.12, 0.175, 0.175, 0.006, np.pi / 2.0 - 0.2, np.pi + 0.4)
    plan.add("housing/back", back, np.eye(4))
    pose = at(0.19, 0.0, 0.0)
    shell = Shell(0.0, 0.1, 0.075, 0.075, wall=0.005, flange=0.02, bolts=amount.bolts(0.1), bolt_size=0.006, ribs=1)
    plan.add("housing/nose/shell", plan.shape(_along_x, shell), pose)
    add_shell(plan, "housing/nose_ring", Shell(-0.118, -0.09, 0.155, 0.155, wall=0.004, flange=0.018, bolts=bolts))
    base = plan.shape(plate, 0.5, 0.34, 0.014, 4, 3, 0.007)
    floor = at(0.16, -0.23, 0.0) @ turned("x", -np.pi / 2.0)
    plan.add("housing/base_plate", base, floor)
    anchors = [floor @ at(x, y, 0.014) for x in np.linspace(-0.1875, 0.1875, 4) for y in (-0.1133, 0.0, 0.1133)]
    plan.add("housing/anchor_bolt", plan.shape(hardware.hex_bolt, 0.012, 0.04), np.stack(anchors))
    plan.add("housing/sump", plan.shape(rounded_box, 0.34, 0.2, 0.03, 0.03, 0.01), floor @ at(z=0.014))
    end = 0.245 + 0.034 * amount.many(4, 2, 6, 0.3) + 0.03
    plan.add(
        "housing/end_plate",
        plan.shape(plate, 0.36, 0.36, 0.01, 5, 5, 0.006),
        at(end, 0.05, 0.04) @ turned("y", np.pi / 2.0),
    )
    spots = np.linspace(-0.144, 0.144, 5)
    if not amount.rich:
        spots = spots[::4]
    screws = [at(end, 0.05, 0.04) @ turned("y", np.pi / 2.0) @ at(x, y, 0.01) for x in spots for y in spots]
    plan.add("housing/end_screw", plan.shape(hardware.hex_bolt, 0.01, 0.03), np.stack(screws))
    breathers = amount.many(60, 4, 400)
    angle = plan.rng.uniform(np.pi / 2.0, 1.5 * np.pi, breathers)
    poses = around(angle, 0.181, plan.rng.uniform(-0.1, 0.1, breathers))
    plan.add("housing/screw", plan.shape(hardware.cap_screw, 0.005, 0.012), poses)
    for row in range(20):
        poses = around(np.linspace(1.5, 4.7, 120), 0.181, -0.1 + 0.01 * row)
        plan.add_filler("housing/rivet", plan.shape(hardware.rivet, 0.0025), poses)


def _along_x(shell: Shell, tol: Tolerance) -> Mesh:
    return moved(flanged_shell(shell, tol), turned("y", np.pi / 2.0))


def _rib(length: float, thickness: float, height: float, tol: Tolerance) -> Mesh:
    return rounded_box(length, thickness, height, 0.0015, 0.001, tol)
