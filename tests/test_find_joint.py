"""Joints found by surfaces in contact: drawn ones of known kind and axis, and those of the sample gearbox."""

from __future__ import annotations

import math
from typing import Any

import joint_shapes as drawn_joints
import numpy as np
import pytest
from joint_shapes import KINDS, circle, drawn, fault_of, levels, rectangle, ring, sleeve, solid, walls
from shapes import Mesh, box, joined, mockup_of

import feeler
from feeler.errors import MeshError, OptionError
from feeler.mechanism.finding import JointError
from feeler.mechanism.slipping import matrix_of
from feeler.mechanism.surfaces import surfaces_of


def shown(rng_seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(rng_seed)


@pytest.mark.parametrize("kind", KINDS)
def test_drawn_joints(kind: str) -> None:
    faults = [(seed, fault) for seed in range(6) if (fault := fault_of(drawn(kind, seed), feeler.find_joint))]
    assert not faults


def test_the_judge_sees_a_wrong_axis() -> None:
    right = drawn("hinge", 0)
    wrong = drawn_joints.Drawn(
        right.kind, right.child, right.parent, right.axis, right.point + 0.2 * right.off + [0.1, 0, 0], right.off
    )
    assert not fault_of(right, feeler.find_joint)
    assert fault_of(wrong, feeler.find_joint)


def block(play: float = 0.01, count: int = 32, length: float = 2.0) -> Mesh:
    return sleeve(rectangle(3.0, 3.0), circle(1.0 + play, count), 0.0, length, shown())


def rod(low: float = -1.0, high: float = 3.0, count: int = 24) -> Mesh:
    return solid(circle(1.0, count, 0.1), low, high, shown())


def collar(low: float, high: float) -> Mesh:
    return solid(circle(1.5, 20), low, high, shown())


def found(child: Any, parent: Any, **options: Any) -> feeler.Joint:
    of = {f"child/{i}": mesh for i, mesh in enumerate(child)} | {f"parent/{i}": mesh for i, mesh in enumerate(parent)}
    return feeler.find_joint(mockup_of(of), "child", "parent", **options)


def test_shoulders_decide_between_revolute_and_cylindrical() -> None:
    """One shoulder makes a hinge; the bottom of a bore does not."""
    plain = found([rod()], [block()])
    assert plain.kind is feeler.JointKind.CYLINDRICAL and "no shoulders" in plain.because
    one = found([rod(), collar(2.01, 2.5)], [block()])
    assert one.kind is feeler.JointKind.REVOLUTE and "a shoulder at one end" in one.because
    both = found([rod(), collar(2.01, 2.5), collar(-0.5, -0.01)], [block()])
    assert both.kind is feeler.JointKind.REVOLUTE and "both ends" in both.because
    bottom = found([rod(0.005, 3.0)], [block(), box((-3, -3, -1), (3, 3, 0))])
    assert bottom.kind is feeler.JointKind.CYLINDRICAL and "a bottom at one end" in bottom.because


def test_the_reason_names_sizes_and_parts() -> None:
    joint = found([rod()], [block(0.05)], name="ram")
    assert joint.because == "coaxial cylinders of 2 m in 2.1 m on 'child/0' and 'parent/0', no shoulders"
    assert joint.name == "ram" and joint.child == "child" and joint.parent == "parent"
    assert np.allclose(joint.axis, (0, 0, 1), atol=1e-9)
    assert np.allclose(joint.point[:2], 0, atol=1e-9)


@pytest.mark.parametrize("count", [8, 12, 97])
def test_press_fits_of_facets_that_cross(count: int) -> None:
    """The facets of a shaft that is larger than its hole are inside and outside of it in turn."""
    joint = found([rod(count=count)], [block(-0.002, 16)])
    assert joint.kind is feeler.JointKind.CYLINDRICAL
    assert np.allclose(joint.axis, (0, 0, 1), atol=1e-6)


def test_a_key_stops_the_turn() -> None:
    """A rod with a key in a block whose wall stands beside the key; the key is a part of its own."""
    key = box((0.98, -0.2, -1.0), (1.3, 0.2, 3.0))
    one, other = box((1.02, 0.21, 0.0), (1.6, 0.8, 2.0)), box((1.02, -0.8, 0.0), (1.6, -0.21, 2.0))
    assert found([rod(), key], [block(), one, other]).kind is feeler.JointKind.PRISMATIC
    assert found([rod(), key], [block(), one]).kind is feeler.JointKind.CYLINDRICAL, "it stops on one side only"


def test_a_locked_door_is_still_a_hinge() -> None:
    """Stops far from the axis, one for each way, of different parts, are no keys."""
    panel = box((1.5, -0.5, 0.1), (30.0, 0.5, 1.9))
    outer, inner = box((28.0, 0.52, 0.0), (31.0, 1.0, 2.0)), box((28.0, -1.0, 0.0), (31.0, -0.52, 2.0))
    knuckle = sleeve(circle(1.4, 24), circle(1.01, 24), 0.02, 1.98, shown())
    pin = [rod(), *(sleeve(circle(1.4, 24), circle(1.01, 24), a, b, shown()) for a, b in ((-1, 0), (2, 3)))]
    shut = found([panel, knuckle], [*pin, outer])
    assert shut.kind is feeler.JointKind.REVOLUTE and "a stop on one side" in shut.because
    locked = found([panel, knuckle], [*pin, outer, inner])
    assert locked.kind is feeler.JointKind.REVOLUTE and "stop it both ways" in locked.because


def test_a_large_door_with_an_even_gap_is_a_hinge() -> None:
    """5 by 10 metres, 0.1 m from its frame all round: gaps are no contact, whatever their share of the size."""
    rng = shown()
    panel = box((-0.3, -0.6, 0.0), (4.7, 0.6, 10.0))
    pins = [solid(circle(0.1, 16), low, low + 0.3, rng) for low in (-0.3, 10.0)]
    frame = [box((-0.9, -0.6, -0.6), (-0.4, 0.6, 10.6)), box((4.8, -0.6, -0.6), (5.3, 0.6, 10.6))]
    frame += [sleeve(rectangle(0.3, 0.6), circle(0.101, 16), low, low + 0.5, rng) for low in (-0.6, 10.1)]
    frame += [box((a, -0.6, low), (b, 0.6, low + 0.5)) for low in (-0.6, 10.1) for a, b in ((-0.4, -0.3), (0.3, 4.8))]
    joint = found([panel, *pins], frame)
    assert joint.kind is feeler.JointKind.REVOLUTE and "held at both ends" in joint.because
    assert np.allclose(np.abs(joint.axis), (0, 0, 1), atol=1e-6) and np.allclose(joint.point[:2], 0, atol=1e-6)


def test_dowels_hold_a_large_plate() -> None:
    """The holes are under 1 % of the faces in contact, and still leave no turn about any other axis."""
    rng, wide = shown(), rectangle(1.0, 1.0)
    at = [(-9.0, 0.0), (9.0, 0.0)]

    def put(mesh: Mesh, x: float, y: float) -> Mesh:
        return mesh[0] + [x, y, 0.0], mesh[1]

    dowels = [put(solid(circle(0.3, 12), -1.0, 0.5, rng), x, y) for x, y in at]
    base = [put(sleeve(wide, circle(0.3, 12), -2.0, 0.0, rng), x, y) for x, y in at]
    base += [box((-8, -10, -2), (8, 10, 0)), box((-12, -1, 1), (12, 1, 2)), box((-12, -1, -2), (-10.5, 1, 1))]
    joint = found([box((-10, -10, 0), (10, 10, 1)), *dowels], base)
    assert joint.kind is feeler.JointKind.FIXED


def test_a_loose_bar_slides_along_its_channel_only() -> None:
    """Its play is most of what counts as near, so that slanted ways seem free for a short while."""
    channel = sleeve(rectangle(3.0, 3.0), rectangle(1.02, 0.42), 0.0, 2.0, shown())
    joint = found([solid(rectangle(1.0, 0.4), -1.0, 4.0, shown())], [channel])
    assert joint.kind is feeler.JointKind.PRISMATIC
    assert np.allclose(np.abs(joint.axis), (0, 0, 1), atol=1e-6)


def test_a_short_taper_is_no_cylinder() -> None:
    """1 in 50, and no longer than wide: the radius changes by 1 %, but all facets lean one way."""
    rng = shown()
    ends = [solid(circle(1.0, 24), 0.0, 1.0, rng), sleeve(circle(2.0, 24), circle(1.0, 24), 0.0, 1.0, rng)]
    for points, _ in ends:
        inner = np.linalg.norm(points[:, :2], axis=1) < 1.5
        points[inner, :2] *= (1.0 + 0.01 * points[inner, 2])[:, None]
    joint = found(ends[:1], ends[1:])
    assert joint.kind is feeler.JointKind.REVOLUTE and "a cone" in joint.because


def test_what_is_free_is_told() -> None:
    with pytest.raises(JointError, match=r"free in . ways") as plate:
        found([box((0, 0, 0), (1, 1, 1))], [box((-2, -2, -1), (3, 3, 0))])
    kinds = sorted(str(joint.kind) for joint in plate.value.candidates)
    assert kinds.count("prismatic") == 2 and kinds.count("revolute") >= 1
    with pytest.raises(JointError, match="ball joint") as socket:
        found([drawn_joints.ball(1.0, 24, True)], [drawn_joints.ball(1.01, 20, False, -1.4, 0.6)])
    assert {joint.kind for joint in socket.value.candidates} == {feeler.JointKind.REVOLUTE}
    with pytest.raises(JointError, match="nothing in contact") as apart:
        found([box((0, 0, 0), (1, 1, 1))], [box((5, 5, 5), (6, 6, 6))])
    assert apart.value.candidates == ()


def test_arguments() -> None:
    mockup = mockup_of({"a": rod(), "b": block()})
    for wrong, error, said in (
        (lambda: feeler.find_joint(None, "a", "b"), MeshError, "not of NoneType"),  # type: ignore[arg-type]
        (lambda: feeler.find_joint(mockup, "a", "c"), OptionError, "no part"),
        (lambda: feeler.find_joint(mockup, "a", ["a", "b"]), OptionError, "'a' is in child and in parent"),
        (lambda: feeler.find_joint(mockup, [], "b"), OptionError, "child names no part"),
        (lambda: feeler.find_joint(mockup, "a", "b", name=3), OptionError, "name"),  # type: ignore[arg-type]
        (lambda: feeler.find_joint(mockup, "a", "b", name="a.b"), OptionError, "without"),
        (lambda: feeler.find_joint(feeler.Scene(mockup).without("b"), "a", "b"), OptionError, "parent names no part"),
    ):
        with pytest.raises(error, match=said):
            wrong()
    assert feeler.find_joint(feeler.Scene(mockup), "a", "b").kind is feeler.JointKind.CYLINDRICAL


def test_cylinders_of_a_stepped_shaft() -> None:
    """Each run of facets is a cylinder of its own, with its radius to the last digits; a hexagon is none."""
    rng = shown()
    mesh = joined(
        walls(circle(1.0, 8), levels(0, 2, rng), True, rng),
        ring(circle(1.5, 40), circle(1.0, 8), 2.0, False),
        walls(circle(1.5, 40), levels(2, 3, rng), True, rng),
        walls(circle(3.0, 6), np.array([3.0, 4.0]), True, rng),
    )
    corners = mesh[0][mesh[1]]
    of = surfaces_of(corners, np.zeros(len(corners), dtype=np.int64), 4.0)
    assert sorted(c.radius for c in of.cylinders) == pytest.approx([1.0, 1.5])
    assert not any(c.is_hole for c in of.cylinders)


def moved_joints(truth: feeler.samples.Truth) -> dict[str, tuple[list[str], set[str]]]:
    """For each joint its parts, and those of the others that move by themselves."""
    found = {}
    for joint in truth.joints:
        others = {
            part
            for other in truth.joints
            if joint.name != "latch" and not (other.name + "/").startswith(joint.name + "/")
            if not (joint.name + "/").startswith(other.name + "/")
            for part in other.parts
        }
        found[joint.name] = (list(joint.parts), others)
    return found


def test_the_joints_of_the_gearbox() -> None:
    """All of them: shafts in ball bearings, cages, a bayonet, a door that its latch locks, and the latch."""
    mockup, truth = feeler.sample("gearbox", 75_000), feeler.sample_truth("gearbox", 75_000)
    moved = moved_joints(truth)
    for joint in truth.joints:
        parts, others = moved[joint.name]
        rest = sorted({*mockup.part_paths} - set(parts) - others)
        got = feeler.find_joint(mockup, parts, rest)
        assert got.kind is feeler.JointKind.REVOLUTE, joint.name
        assert np.linalg.norm(np.cross(got.axis, joint.axis)) < 1e-3, joint.name
        off = np.linalg.norm(np.cross(np.subtract(got.point, joint.point_m), joint.axis))
        assert off < 1e-4, f"{joint.name}: {off}"
    shaft = "gearbox/gear_train/main_shaft/"
    hub = feeler.find_joint(mockup, shaft + "spur_gear", [shaft + "shaft", shaft + "key", shaft + "circlip"])
    assert hub.kind is feeler.JointKind.FIXED


def test_the_matrix_of_a_cylinder_has_two_free_motions() -> None:
    from feeler.mechanism.touching import touches_of

    sides = []
    for mesh in (rod(), block()):
        corners = mesh[0][mesh[1]]
        sides.append(surfaces_of(corners, np.zeros(len(corners), dtype=np.int64), 4.0))
    values = np.linalg.eigvalsh(matrix_of(touches_of(*sides, 0.05))[0])
    assert (values[:2] < 1e-9).all() and (values[2:] > 1e-3).all()


def grid_of_thread(sides: int, turns: int, is_nut: bool) -> Mesh:
    """A thread of 20 mm pitch as a grid of sides and 24 steps a turn, whose diagonals run from flank to flank."""
    angle = np.linspace(0.0, math.tau, sides, endpoint=False) + 0.1
    height = np.linspace(0.0, 0.02 * turns, 24 * turns + 1)
    around, along = (each.ravel() for each in np.meshgrid(angle, height, indexing="ij"))
    flank = 1.0 - np.abs(2.0 * ((along / 0.02 - around / math.tau) % 1.0) - 1.0)
    radius = 0.022 + 0.008 * flank + 0.001 * is_nut
    points = np.column_stack([radius * np.cos(around), radius * np.sin(around), along + 0.04 * is_nut])
    rows = len(height)
    a = (np.arange(sides)[:, None] * rows + np.arange(rows - 1)).ravel()
    b = (a + rows) % len(points)
    faces = np.concatenate([np.column_stack([a, b, b + 1]), np.column_stack([a, b + 1, a + 1])])
    return points, faces[:, ::-1] if is_nut else faces


@pytest.mark.parametrize("sides", [17, 23, 27, 31])
def test_edges_over_the_crest_of_a_thread_give_no_pitch(sides: int) -> None:
    shapes = {"nut": grid_of_thread(sides, 3, True), "screw": grid_of_thread(24, 8, False)}
    found = feeler.find_joint(mockup_of(shapes), "nut", "screw")
    assert found.kind == "screw" and found.pitch == pytest.approx(0.02, rel=0.01)


def drawn_wide(core: float, gap: float, seed: int, has_head: bool = True, is_nut: bool = False) -> tuple[Mesh, Mesh]:
    """A bolt of radius 1 in a plate, or in a nut, with a hole of `core`; its head is off the plate by `gap`."""
    rng, (n, m) = shown(seed), np.random.default_rng(seed).integers(16, 96, 2).tolist()
    shank, head = circle(1.0, n), circle(1.9, 6) if has_head else circle(1.0, n)
    low, high, long = -0.7, 2.0 + gap, 2.0 if not is_nut else 1.6
    bolt = joined(
        walls(shank, np.array([low, high]), True, rng),
        drawn_joints.cap(shank, low, False),
        ring(head, shank, high, False) if has_head else walls(shank, np.array([high, high + 1.0]), True, rng),
        *([walls(head, np.array([high, high + 1.0]), True, rng)] if has_head else []),
        drawn_joints.cap(head, high + 1.0, True),
    )
    return bolt, sleeve(circle(1.9, 6) if is_nut else rectangle(4.0, 5.0), circle(core, m), 0.0, long, rng)


@pytest.mark.parametrize("core", [0.74, 0.8, 0.86])
def test_a_bolt_as_wide_as_its_thread_is_found_in_a_hole_as_wide_as_its_core(core: float) -> None:
    for seed in range(3):
        bolt, plate = drawn_wide(core, 0.0, seed)
        for sides in ((bolt, plate), (plate, bolt)):
            joint = found(sides[:1], sides[1:])
            assert joint.kind is feeler.JointKind.REVOLUTE
            assert "a thread drawn as wide as the bolt" in joint.because and "a shoulder at one end" in joint.because
            assert np.allclose(np.abs(joint.axis), (0, 0, 1), atol=1e-6) and np.allclose(joint.point[:2], 0, atol=1e-6)
        off, nut = drawn_wide(core, 0.5, seed), drawn_wide(core, 0.5, seed, has_head=False, is_nut=True)
        for child, parent in (off, nut):
            joint = found([child], [parent])
            assert joint.kind is feeler.JointKind.CYLINDRICAL and "in a hole as wide as its core" in joint.because


def test_a_pin_in_a_hole_that_is_too_narrow_is_no_thread() -> None:
    """Nothing says that it is a bolt: it has no head, and a ring around it is no nut."""
    pin, plate = drawn_wide(0.8, 0.0, 1, has_head=False)
    bush = sleeve(circle(1.5, 40), circle(0.8, 40), 0.0, 1.6, shown())
    for parent in (plate, bush):
        with pytest.raises(JointError, match="a pin in a hole that is too narrow"):
            found([pin], [parent])


def test_bolts_beside_each_other_leave_no_joint() -> None:
    bolt, plate = drawn_wide(0.8, 0.0, 2)
    other = [(points + np.array([9.0, 0.0, 0.0]), faces) for points, faces in (bolt, plate)]
    with pytest.raises(JointError, match="free in 3 ways"):
        found([bolt, other[0]], [plate, other[1]])


@pytest.mark.parametrize("how", ["noise", "rounded"])
@pytest.mark.parametrize("is_left", [False, True])
def test_the_pitch_of_a_ragged_thread(how: str, is_left: bool) -> None:
    """Their facets lean too little; edges that are rounded all alike agree on a wrong pitch."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        pitch, depth = rng.uniform(0.2, 0.5), rng.uniform(0.4, 0.6)
        line = np.array([[1.0 - depth * pitch, 0.0], [1.0 - depth * pitch, 0.1], [1.0, 0.5], [1.0, 0.6]]) * [1, pitch]
        turns, sides = rng.uniform(4.0, 8.0), rng.integers(16, 48, 2).tolist()
        shapes = {
            "screw": drawn_joints.thread(line, pitch, turns + 2.0, sides[0], True, -math.tau),
            "nut": drawn_joints.thread(line + np.array([0.01, 0.0]), pitch, turns, sides[1], False),
        }
        for name, (points, faces) in shapes.items():
            points = np.round(points, 3) if how == "rounded" else points + rng.normal(size=points.shape) * 2e-4
            shapes[name] = (points * [1, -1, 1], faces[:, ::-1].copy()) if is_left else (points, faces)
        joint = feeler.find_joint(mockup_of(shapes), "nut", "screw")
        assert joint.kind == "screw" and joint.pitch == pytest.approx(-pitch if is_left else pitch, rel=0.005)
