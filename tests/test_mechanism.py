"""Mechanisms against closed forms."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from commands import run, run_json
from shapes import box, prism_ring

import feeler
from feeler import Joint, JointCoupling, Mechanism
from feeler.errors import LoadError, MechanismError, OptionError
from feeler.io import write_glb
from feeler.mechanism.rounds import rounds_of

Z = (0.0, 0.0, 1.0)


def mockup(**boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> feeler.Mockup:
    """Boxes by name, from the lower corner to the upper."""
    made = [box(*ends) for ends in boxes.values()]
    return feeler.Mockup(
        np.concatenate([vertices for vertices, _ in made]),
        np.concatenate([np.asarray(faces) + 8 * i for i, (_, faces) in enumerate(made)]),
        np.repeat(np.arange(len(made)), 12),
        list(boxes),
    )


def hinge() -> Mechanism:
    """A thin door along x that turns about z through the origin, and a wall that it meets."""
    mock = mockup(door=((0.1, -0.01, 0.0), (1.0, 0.01, 1.0)), wall=((-0.5, 0.5, 0.0), (0.3, 0.6, 1.0)))
    return Mechanism(mock, [Joint("hinge", "revolute", None, "door", Z)])


def dots(*points: tuple[float, float, float]) -> feeler.Mockup:
    """Small boxes about points, called a, b, c, ..."""
    at = {chr(97 + n): (tuple(x - 0.01 for x in p), tuple(x + 0.01 for x in p)) for n, p in enumerate(points)}
    return mockup(**at)  # type: ignore[arg-type]


def hinge_contact() -> float:
    """The angle at which the door's front edge, at y 0.01, meets the wall's edge at (0.3, 0.5)."""
    far = math.hypot(0.3, 0.5)
    return math.atan2(0.5, 0.3) - math.asin(0.01 / far)


def test_a_mechanism_with_seats_travels_after_a_question() -> None:
    """A drawer that lies on its rail, up to a stop."""
    drawer, rail = ((0.0, 0.0, 0.0), (0.2, 0.1, 0.1)), ((-0.5, 0.0, -0.1), (1.0, 0.1, 0.0))
    mock = mockup(drawer=drawer, rail=rail, stop=((0.5, 0.0, 0.01), (0.6, 0.1, 0.2)))
    slide = Mechanism(mock, [Joint("slide", "prismatic", None, "drawer", (1.0, 0.0, 0.0))])
    found = slide.range("slide")
    assert found.seats and found.upper == pytest.approx(0.3, abs=1e-5)
    for again in (pickle.loads(pickle.dumps(slide)), copy.deepcopy(slide)):
        assert again.range("slide").upper == found.upper


def test_a_door_opens_up_to_the_wall_and_the_range_tells_what_it_met() -> None:
    found = hinge().range("hinge")
    assert found.upper == pytest.approx(hinge_contact(), abs=1e-6) and found.upper <= hinge_contact()
    assert found.above is not None
    assert (found.above.path, found.above.other_path) == ("door", "wall")
    assert found.above.point[:2] == pytest.approx((0.3, 0.5), abs=1e-6)
    # The other way round it meets the wall's other lower edge, or its back.
    assert found.below is not None and -2 * math.pi < found.lower < -math.pi
    assert found.is_certified and found.seats == ()


def test_the_scene_of_a_position_is_that_of_moved_parts() -> None:
    moved = hinge()
    scene = moved.scene({"hinge": math.pi / 2})
    part = scene.mockup.parts[0]
    assert (part.lower, part.upper) == (
        pytest.approx((-0.01, 0.1, 0.0), abs=1e-12),
        pytest.approx((0.01, 1.0, 1.0), abs=1e-12),
    )
    assert moved.scene().mockup is moved.mockup
    assert moved.scene({"hinge": math.pi / 2}) is scene


def test_clearance_is_bounded_and_never_above_the_truth() -> None:
    moved = hinge()
    found = moved.clearance({"hinge": (0.0, 0.5)}, error=1e-4)
    rng = np.random.default_rng(5)
    door, around = feeler.Tool.of_parts(moved.mockup, "door"), moved.scene().only("wall")
    poses = np.array([moved.poses({"hinge": q})["hinge"] for q in rng.uniform(0.0, 0.5, 300)])
    truth = float(around.distance_batch(door, poses).values.min())
    assert found.lower <= truth and found.upper - found.lower <= 1.01e-4
    assert found.worst["hinge"] == pytest.approx(0.5, abs=1e-3)
    assert (found.path, found.other_path, found.undecided) == ("door", "wall", 0.0)
    assert found.curve.shape == (121, 3) and (found.curve[:, 2] <= found.curve[:, 1]).all()
    assert moved.clearance({"hinge": (0.0, 1.2)}).upper == 0.0


def arm() -> Mechanism:
    mock = mockup(
        upper=((0.0, -0.02, 0.0), (0.5, 0.02, 0.05)),
        lower=((0.5, -0.02, 0.06), (1.0, 0.02, 0.1)),
        post=((0.9, 0.6, -0.2), (1.0, 0.7, 0.3)),
    )
    return Mechanism(
        mock,
        [
            Joint("elbow", "revolute", "upper", "lower", Z, (0.5, 0.0, 0.0)),
            Joint("shoulder", "revolute", None, "upper", Z, limits=(-1.0, 1.0)),
        ],
    )


def test_clearance_over_two_joints_is_certified() -> None:
    moved = arm()
    found = moved.clearance({"shoulder": (0.0, 0.3), "elbow": (-0.3, 0.3)}, error=1e-3)
    assert found.upper - found.lower <= 1.01e-3
    rng = np.random.default_rng(6)
    lower, around = feeler.Tool.of_parts(moved.mockup, "lower"), moved.scene().without("lower")
    asked = [{"shoulder": a, "elbow": b} for a, b in rng.uniform([0.0, -0.3], [0.3, 0.3], (500, 2))]
    poses = np.array([moved.poses(each)["elbow"] for each in asked])
    truth = float(around.only("post").distance_batch(lower, poses).values.min())
    # Both arms lie one above the other, 10 mm apart.
    assert found.lower <= min(truth, 0.01) and found.upper == pytest.approx(0.01, abs=1e-9)
    few = moved.clearance({"shoulder": (0.0, 0.8), "elbow": (-0.3, 0.8)}, error=1e-9, most=4)
    assert few.lower <= few.upper and few.undecided > 0.0


def test_children_move_with_their_parents() -> None:
    poses = arm().poses({"shoulder": math.pi / 6, "elbow": math.pi / 3})
    tip = poses["elbow"] @ [1.0, 0.0, 0.0, 1.0]
    assert tip[:2] == pytest.approx((0.5 * math.cos(math.pi / 6), 0.5 * math.sin(math.pi / 6) + 0.5))
    with pytest.raises(OptionError, match="limits"):
        arm().poses({"shoulder": 1.1})
    first = arm().chain("elbow", {"elbow": 0.1}, {"elbow": 0.4})
    assert isinstance(first[1], feeler.Screw) and first[1].angle == pytest.approx(0.3)


@pytest.mark.parametrize("seed", range(6))
def test_a_pin_of_millimetres_in_a_file_of_half_micrometres_is_round(seed: int) -> None:
    """Rounding puts the corners out of round by more than a share of so small a radius."""
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    centre, grid = rng.uniform(-0.3, 0.3, 3), 2.0**-21
    parts = {}
    for name, mesh in (
        ("pin", prism_ring(1.6e-3, 0.0, 12, -0.02, 0.02, rng.uniform())),
        ("eye", prism_ring(3.45e-3, 1.65e-3, 12, -0.01, 0.01, rng.uniform())),
    ):
        vertices = mesh[0] @ turn.T + centre
        parts[name] = (np.round(vertices / grid) * grid, mesh[1])
    joint = feeler.Joint("hinge", "revolute", None, ["eye"], axis=turn[:, 2], point=centre)
    found = feeler.Mechanism(feeler.Mockup(parts), [joint]).range("hinge")
    assert [seat.kind for seat in found.seats] == ["round"] and found.above is None


def test_an_oval_of_micrometres_is_not_round() -> None:
    vertices, faces = prism_ring(5e-6, 0.0, 24, -2e-5, 2e-5)
    axis, point = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    assert len(rounds_of(vertices, faces, axis, point)) == 1
    assert rounds_of(vertices * [1.1, 1.0, 1.0], faces, axis, point) == []


def test_a_rack_follows_its_pinion() -> None:
    radius = 0.1
    mock = dots((0, 0, 0), (0, -0.2, 0), (0.3, -0.2, 0))
    moved = Mechanism(
        mock,
        [Joint("pinion", "revolute", None, "a", Z), Joint("rack", "prismatic", None, "b", (1, 0, 0))],
        [JointCoupling("rack", "pinion", radius)],
    )
    assert moved.poses({"pinion": 2.0})["rack"][0, 3] == pytest.approx(0.2)
    assert moved.position({"rack": 0.2})["pinion"] == pytest.approx(2.0)
    found = moved.range("pinion")  # the rack meets c after 0.28 m
    assert found.upper == pytest.approx(0.28 / radius, abs=1e-6) and found.upper <= 0.28 / radius + 1e-12
    assert found.above is not None and found.above.other_path == "c"
    with pytest.raises(OptionError, match="both are given"):
        moved.position({"pinion": 1.0, "rack": 0.5})


def test_chains_of_couplings_hold_or_contradict() -> None:
    mock = dots(*((0.1 * n, 0, 0) for n in range(4)))
    joints = [Joint(name, "revolute", None, name, Z) for name in "abc"]
    moved = Mechanism(mock, joints, [JointCoupling("b", "a", -2.0), JointCoupling("c", "b", 0.5, 0.25)])
    assert moved.position({"a": 0.5}) == pytest.approx({"a": 0.5, "b": -1.0, "c": -0.25})
    with pytest.raises(OptionError, match="contradict"):
        Mechanism(
            mock, joints, [JointCoupling("b", "a", 2.0), JointCoupling("c", "b", 1.0), JointCoupling("c", "a", 1.0)]
        )


def test_coupled_joints_need_a_position() -> None:
    mock = dots(*((0.1 * n, 0, 0) for n in range(4)))
    first = Joint("x", "prismatic", None, "a", Z, limits=(0.0, 1.0))
    for limits, is_right in (((5.0, 6.0), False), ((3.0 * 0.1, 3.0 * 0.1), True)):
        joints = [replace(first, limits=(0.1, 0.1)) if is_right else first, Joint("y", "prismatic", None, "b", Z)]
        joints[1] = replace(joints[1], limits=limits)
        coupling = [JointCoupling("y", "x", 3.0 if is_right else 1.0)]
        if is_right:  # 3 * 0.1 is above 0.3 by a rounding
            assert Mechanism(mock, joints, coupling).limits("x") == pytest.approx((0.1, 0.1))
        else:
            with pytest.raises(OptionError, match="coupled with 'x' leave no position"):
                Mechanism(mock, joints, coupling)


def test_numbers_are_taken_as_arrays_have_them() -> None:
    moved = Mechanism(dots((0, 0, 0), (1, 0, 0)), [Joint("h", "revolute", None, "a", Z)])
    for one in (2.0, np.array(2.0), np.float32(2.0)):
        assert moved.clearance({"h": one}).lower == moved.clearance({"h": 2.0}).lower
    for wrong in (np.array("x"), np.array([2.0]), np.zeros((2, 2)), [1.0]):
        for ask in (moved.clearance, moved.clash):
            with pytest.raises(OptionError, match="give a number, or the least and greatest value"):
                ask({"h": wrong})


def test_the_limits_of_all_coupled_numbers_hold() -> None:
    mock = dots(*((0.1 * n, 0, 0) for n in range(4)))
    joints = [Joint("g", "revolute", None, "a", Z), Joint("h", "revolute", None, "b", Z, limits=(0.0, 1.0))]
    moved = Mechanism(mock, joints, [JointCoupling("h", "g", 2.0)])
    assert moved.position({"g": 0.5})["h"] == 1.0
    for ask in (moved.position, moved.poses, moved.scene):
        with pytest.raises(OptionError, match=r"'g' at 1 rad \(57.2958 degrees\) moves 'h' to 2 rad .* limits are 0"):
            ask({"g": 1.0})
    with pytest.raises(OptionError, match=r"moves 'h' to -0\.2 rad"):
        moved.clearance({"g": (-0.1, 0.3)})
    with pytest.raises(OptionError, match="'g' is coupled with 'h', and both are given, as numbers that disagree"):
        moved.position({"h": 1.0, "g": 0.1})
    with pytest.raises(OptionError, match="'g' is 1e\\+300: give at most 1e\\+06 radians"):
        Mechanism(mock, joints[:1]).position({"g": 1e300})


def test_what_a_loop_moves_keeps_the_limits_of_what_is_coupled_with_it() -> None:
    moved = off_centre()
    far = Joint("wheel", "revolute", None, "d", Z, limits=(-0.5, 0.5))
    coupled = Mechanism(moved.mockup, [*moved.joints, far], [JointCoupling("wheel", "slider", 100.0)], moved.loops)
    assert abs(coupled.position({"crank": 0.01})["wheel"]) < 0.5
    with pytest.raises(OptionError, match=r"'slider' at .* m moves 'wheel' to .* rad"):
        coupled.position({"crank": 0.3})


@pytest.mark.parametrize("short", [1e-2, 1e-4, 1e-6, 1e-8])
def test_a_loop_is_exact_near_its_dead_point(short: float) -> None:
    """The slider drives: where crank and rod are nearly in line, its place says little about the crank's angle."""
    crank, rod, along = 0.1, 0.3, math.sqrt(0.08)
    outer = crank + rod - short
    found = off_centre().position({"slider": outer - along})
    angle = math.acos((outer**2 + crank**2 - rod**2) / (2 * crank * outer))
    assert found["crank"] + math.pi / 2 == pytest.approx(angle, abs=1e-14 / math.sqrt(short) + 1e-12)


def slider_crank(crank: float = 0.1, rod: float = 0.3) -> Mechanism:
    mock = dots((crank / 2, 0, 0), (crank + rod / 2, 0, 0.1), (crank + rod, 0, 0.2), (0, -1, 0))
    return Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("rod", "revolute", "a", "b", Z, (crank, 0, 0)),
            Joint("slider", "prismatic", None, "c", (1, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (crank + rod, 0, 0))],
    )


def off_centre() -> Mechanism:
    """A slider-crank whose parts are modelled away from its dead point, at 90 degrees."""
    crank, rod = 0.1, 0.3
    along = math.sqrt(rod**2 - crank**2)
    mock = dots((0, crank / 2, 0), (along / 2, crank / 2, 0.1), (along, 0, 0.2), (0, -1, 0))
    return Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("rod", "revolute", "a", "b", Z, (0, crank, 0)),
            Joint("slider", "prismatic", None, "c", (1, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (along, 0, 0))],
    )


@pytest.mark.parametrize("angle", [-7.0, -0.5, 0.3, 1.0, 2.5, 6.0])
def test_a_slider_follows_its_crank(angle: float) -> None:
    crank, rod = 0.1, 0.3
    place = crank * math.cos(angle) + math.sqrt(rod**2 - (crank * math.sin(angle)) ** 2)
    assert slider_crank().position({"crank": angle})["slider"] == pytest.approx(place - crank - rod, abs=1e-9)


def test_a_slider_ends_at_the_dead_point_of_its_crank() -> None:
    moved = off_centre()
    along = math.sqrt(0.08)
    found = moved.position({"slider": 0.35 - along})
    inner = 0.5 * math.pi + found["crank"]
    assert 0.1 * math.cos(inner) + math.sqrt(0.09 - (0.1 * math.sin(inner)) ** 2) == pytest.approx(0.35, abs=1e-9)
    with pytest.raises(MechanismError, match=r"dead point at slider = 0\.117157"):
        moved.position({"slider": 0.45 - along})
    assert 0.4 - along == pytest.approx(0.117157, abs=1e-6)


def test_a_position_of_a_loop_can_be_given_back() -> None:
    whole = off_centre()
    crank = replace(whole.joints[0], limits=(-0.22, -0.15))
    moved = Mechanism(whole.mockup, [crank, *whole.joints[1:]], loops=whole.loops)
    position = moved.position({"crank": -0.2})
    assert moved.position(position) == pytest.approx(position, abs=1e-9)
    two = {"crank": -0.2, "slider": position["slider"]}
    assert moved.position(two) == pytest.approx(position, abs=1e-9)
    free = moved.range("crank", {"crank": -0.2})
    for at in (position, two):
        found = moved.range("crank", at)
        assert (found.lower, found.upper) == pytest.approx((free.lower, free.upper), abs=1e-9)
    driven = moved.range("slider", {"crank": -0.2})
    assert driven.start == position["slider"] and driven.lower < driven.start < driven.upper
    apart = {"crank": -0.2, "slider": position["slider"] + 1e-3}
    for ask in (moved.position, lambda values: moved.range("rod", values)):
        with pytest.raises(MechanismError, match=r"the loop does not close at crank = .*: give fewer of its joints"):
            ask(apart)


def test_a_four_bar_follows_and_ends_at_its_dead_point() -> None:
    # Frame 0.4, crank 0.1, coupler 0.35, rocker 0.3; the crank stands at 90 degrees.
    frame, crank, coupler, rocker = 0.4, 0.1, 0.35, 0.3

    def joint_of(angle: float) -> npt.NDArray[np.float64]:
        tip = crank * np.array([math.cos(angle), math.sin(angle)])
        to = np.array([frame, 0.0]) - tip
        far = float(np.linalg.norm(to))
        along = (coupler**2 - rocker**2 + far**2) / (2 * far)
        up = math.sqrt(coupler**2 - along**2)
        return tip + along * to / far + up * np.array([-to[1], to[0]]) / far

    start = joint_of(math.pi / 2)
    mock = dots((0, 0.05, 0), (*start / 2, 0.1), ((start[0] + frame) / 2, start[1] / 2, 0.2), (0, -1, 0))
    moved = Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("coupler", "revolute", "a", "b", Z, (0, crank, 0)),
            Joint("rocker", "revolute", None, "c", Z, (frame, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (*start, 0))],
    )
    for by in (-3.0, 0.7, 4.0):
        poses = moved.poses({"crank": by})
        pin = joint_of(math.pi / 2 + by)
        assert (poses["rocker"] @ [*start, 0, 1])[:2] == pytest.approx(pin, abs=1e-9)
        assert (poses["coupler"] @ [*start, 0, 1])[:2] == pytest.approx(pin, abs=1e-9)
    # Driven by the rocker it ends where crank and coupler are in line.
    first = math.atan2(start[1], start[0] - frame)
    cosine = (rocker**2 + frame**2 - (crank + coupler) ** 2) / (2 * rocker * frame)
    dead = math.pi - math.acos(cosine) - first
    with pytest.raises(MechanismError, match="dead point at rocker = ") as told:
        moved.position({"rocker": dead - 0.2})
    assert float(str(told.value).split("rocker = ")[1].split()[0]) == pytest.approx(dead, abs=1e-6)


def test_a_parallelogram_does_not_pass_where_its_bars_lie_in_line() -> None:
    """There it could go on as a parallelogram or crossed: nothing says which."""
    rng = np.random.default_rng(5)
    for name in ("", "clash", "clearance"):
        zero, far = rng.uniform(0.2, 2.9), rng.uniform(1.2, 4.0)
        tips = (math.cos(zero), math.sin(zero), 0.0), (far + math.cos(zero), math.sin(zero), 0.0)
        mock = dots((0.5, 0.0, 0.0), (1.0, 1.0, 0.0), (far, 0.5, 0.0), (50.0, 0.0, 0.0))
        joints = [
            Joint("a", "revolute", None, "a", Z),
            Joint("c", "revolute", "a", "b", Z, tips[0]),
            Joint("b", "revolute", None, "c", Z, (far, 0.0, 0.0)),
        ]
        moved = Mechanism(mock, joints, loops=[Joint("k", "revolute", "b", "c", Z, tips[1])])
        for inside in (-zero + 0.02, math.pi - zero - 0.02):
            assert moved.position({"a": inside})["b"] == pytest.approx(inside, abs=1e-9)
        for beyond in (-zero - rng.uniform(0.01, 1.5), math.pi - zero + rng.uniform(0.01, 1.5)):
            with pytest.raises(MechanismError, match="dead point"):
                moved.position({"a": beyond})
        if name:
            with pytest.raises(MechanismError, match=r"does not get from.*dead point"):
                getattr(moved, name)({"a": (0.0, math.pi - zero + 0.01)})
    # What follows may stand still where it turns back: a slider at the end of its stroke.
    assert slider_crank().position({"crank": 4.0})["slider"] == pytest.approx(
        0.1 * math.cos(4.0) + math.sqrt(0.09 - (0.1 * math.sin(4.0)) ** 2) - 0.4, abs=1e-9
    )


def test_a_scissor_lift_rises() -> None:
    # Two bars of length 1 cross at their middles; one foot is fixed, the other slides.
    angle, bar = 0.5, 1.0
    wide, high = bar * math.cos(angle), bar * math.sin(angle)
    mock = dots(
        (wide / 4, high / 4, 0), (0.75 * wide, high / 4, 0.1), (wide, 0, 0.2), (wide / 2, high, 0.3), (0, -1, 0)
    )
    moved = Mechanism(
        mock,
        [
            Joint("bar", "revolute", None, "a", Z),
            Joint("cross", "revolute", "a", "b", Z, (wide / 2, high / 2, 0)),
            Joint("foot", "prismatic", None, "c", (1, 0, 0)),
            Joint("table", "revolute", "a", "d", Z, (wide, high, 0)),
        ],
        [JointCoupling("table", "bar", -1.0)],
        [Joint("pin", "revolute", "b", "c", Z, (wide, 0, 0))],
    )
    poses = moved.poses({"bar": 0.3})
    assert moved.position({"bar": 0.3})["foot"] == pytest.approx(bar * math.cos(0.8) - wide, abs=1e-9)
    top = poses["table"]
    assert top[:3, :3] == pytest.approx(np.eye(3), abs=1e-12)
    assert top[1, 3] == pytest.approx(bar * math.sin(0.8) - high, abs=1e-9)


def test_a_scissor_of_two_loops_does_not_pass_where_its_bars_lie_on_each_other() -> None:
    """Both loops may go on otherwise there: the Jacobian loses two ranks at once, and its determinant its sign."""
    angle = math.radians(35.0)
    wide, high = 2.0 * math.cos(angle), 2.0 * math.sin(angle)
    mock = dots((0.2, 0.2, 0), (1, 0.3, 0.1), (wide, 0, 0.2), (wide, high, 0.3), (0, high, 0.4), (0, -1, 0))
    joints = [
        Joint("arm", "revolute", None, "a", Z),
        Joint("mid", "revolute", "a", "b", Z, (wide / 2, high / 2, 0)),
        Joint("foot", "revolute", "b", "c", Z, (wide, 0, 0)),
        Joint("table", "revolute", "a", "d", Z, (wide, high, 0)),
        Joint("slide", "prismatic", "d", "e", (1, 0, 0)),
    ]
    loops = [
        Joint("floor", "prismatic", None, "c", (1, 0, 0)),
        Joint("pin", "revolute", "b", "e", Z, (0, high, 0)),
    ]
    moved = Mechanism(mock, joints, loops=loops)
    for value in (-0.3, 0.9):
        assert moved.position({"arm": value})["mid"] == pytest.approx(-2.0 * value, abs=1e-9)
    for beyond in (math.pi / 2 - angle + 0.001, 1.4):
        with pytest.raises(MechanismError, match="dead point"):
            moved.position({"arm": beyond})


def test_a_seated_hinge_turns_and_names_its_seat() -> None:
    mock = mockup(door=((0.0, 0.0, 0.1), (1.0, 0.02, 1.0)), sill=((0.0, -0.5, 0.0), (1.0, 0.5, 0.1)))
    found = Mechanism(mock, [Joint("hinge", "revolute", "sill", "door", Z, limits=(0.0, 1.5))]).range("hinge")
    assert (found.lower, found.upper, found.below, found.above) == (0.0, 1.5, None, None)
    assert [(seat.path, seat.other_path) for seat in found.seats] == [("door", "sill")]


def test_a_slide_and_a_screw_stop_where_they_must() -> None:
    mock = mockup(block=((0, 0, 0), (0.1, 0.1, 0.1)), wall=((0, 0, 0.4), (0.1, 0.1, 0.5)))
    slide = Mechanism(mock, [Joint("slide", "prismatic", None, "block", Z)]).range("slide")
    assert slide.upper == pytest.approx(0.3, abs=1e-7) and slide.upper <= 0.3 and slide.below is None
    screw = Mechanism(mock, [Joint("screw", "screw", None, "block", Z, (0.05, 0.05, 0), pitch=0.1)])
    found = screw.range("screw")
    assert found.upper == 2 * math.pi and screw.poses({"screw": math.pi})["screw"][2, 3] == pytest.approx(0.05)
    both = Mechanism(mock, [Joint("rod", "cylindrical", None, "block", Z, (0.05, 0.05, 0), slide_limits=(0.0, 0.2))])
    assert both.names == ("rod.turn", "rod.slide")
    assert both.range("rod.slide").upper == 0.2


def test_a_joint_is_followed_to_its_limits_or_says_how_far_it_was_followed() -> None:
    mock = mockup(jack=((0, 0, 0), (0.1, 0.1, 0.1)), plate=((0, 0, 0.13), (0.1, 0.1, 0.15)))
    jack = Joint("jack", "screw", None, "jack", Z, (0.05, 0.05, 0), limits=(-70.0, 63.0), pitch=0.01)
    found = Mechanism(mock, [jack]).range("jack")
    assert found.lower == -70.0 and found.upper == pytest.approx(6 * math.pi, abs=1e-5)
    assert found.above is not None and found.above.other_path == "plate" and found.ended == ""
    long = Joint("jack", "screw", None, "jack", Z, (0.05, 0.05, 0), limits=(-1e4, 0.0), pitch=0.01)
    assert "not to its limit: it has too many turns" in Mechanism(mock, [long]).range("jack").ended
    slide = Joint("slide", "prismatic", None, "jack", (1, 0, 0), limits=(0.0, 10.0))
    assert Mechanism(mock, [slide]).range("slide").upper == 10.0
    turn = Joint("turn", "revolute", None, "jack", Z, limits=(-20.0, 1e5))
    assert (Mechanism(mock, [turn]).range("turn").lower, Mechanism(mock, [turn]).range("turn").upper) == (-20.0, 1e5)
    free = Mechanism(mock, [Joint("slide", "prismatic", None, "jack", (1, 0, 0))]).range("slide")
    assert "'slide' has no limit: it was followed to " in free.ended
    assert Mechanism(mock, [Joint("turn", "revolute", None, "jack", Z)]).range("turn").ended == ""


def test_clash_tells_each_pair_with_its_first_position() -> None:
    found = hinge().clash({"hinge": (0.0, 1.5)})
    assert [(each.path, each.other_path) for each in found.contacts] == [("door", "wall")]
    assert found.contacts[0].value == pytest.approx(hinge_contact(), abs=1e-6)


@pytest.mark.parametrize(
    ("joints", "says"),
    [
        ([Joint("j", "revolute", None, ["a", "b", "c"])], "whole mock-up"),
        ([Joint("j", "revolute", None, "a"), Joint("k", "revolute", None, ["a", "b"])], "two joints"),
        ([Joint("j", "revolute", "b", "a"), Joint("k", "revolute", "a", "b")], "circle"),
        ([Joint("j", "revolute", ["b", "c"], "a"), Joint("k", "revolute", None, "b")], "several links"),
        ([Joint("j", "revolute", None, "a"), Joint("j", "revolute", None, "b")], "called"),
        ([], "no joints"),
    ],
)
def test_joints_that_make_no_tree_are_refused(joints: list[Joint], says: str) -> None:
    with pytest.raises(OptionError, match=says):
        Mechanism(dots((0, 0, 0), (1, 0, 0), (2, 0, 0)), joints)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"axis": (0, 0, 0)}, "length zero"),
        ({"axis": (0, 0, math.nan)}, "not finite"),
        ({"limits": (1.0, 0.0)}, "cross"),
        ({"pitch": 1.0}, "only a screw"),
        ({"kind": "screw"}, "without pitch"),
        ({"name": "a.b"}, "without '.'"),
        ({"slide_limits": (0, 1)}, "only a cylindrical"),
    ],
)
def test_joints_that_cannot_be_are_refused(more: dict[str, object], says: str) -> None:
    with pytest.raises(OptionError, match=says):
        Joint(**{"name": "j", "kind": "revolute", "parent": None, "child": "a", **more})  # type: ignore[arg-type]


def test_groups_without_parts_and_names_given_twice_are_refused() -> None:
    moved = off_centre()
    with pytest.raises(OptionError, match="child of joint 'j' names no part"):
        Mechanism(moved.mockup, [Joint("j", "revolute", None, [], Z)])
    with pytest.raises(OptionError, match="parent of joint 'j' names no part"):
        Mechanism(moved.mockup, [Joint("j", "revolute", [], "a", Z)])
    pin = Joint("crank", "revolute", "b", "c", Z)
    for ends in ({"limits": (-0.1, 0.1)}, {"slide_limits": (0.0, 0.1)}):
        closing = Joint("pin", "cylindrical", "b", "c", Z, **ends)
        with pytest.raises(OptionError, match="joint 'pin' closes a loop and has limits"):
            Mechanism(moved.mockup, moved.joints, loops=[closing])
    with pytest.raises(OptionError, match="two joints are called 'crank', a loop and another"):
        Mechanism(moved.mockup, moved.joints, loops=[pin])


def test_a_mechanism_is_saved_and_loaded(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        joint = Joint("s", "screw", None, "a", tuple(rng.normal(size=3)), tuple(rng.normal(size=3)), pitch=rng.normal())
        moved = Mechanism(dots((0, 0, 0), (1, 0, 0)), [joint])
        moved.save(tmp_path / "screw.toml")
        assert Mechanism.load(tmp_path / "screw.toml", moved.mockup).joints == moved.joints, "to the bit"
    moved = off_centre()
    moved.save(tmp_path / "crank.toml")
    again = Mechanism.load(tmp_path / "crank.toml", moved.mockup)
    assert (again.joints, again.loops) == (moved.joints, moved.loops)
    file = tmp_path / "cowl.toml"
    text = '[[joint]]\nname = "j"\nkind = "revolute"\nchild = "a"\n'
    text += "axis = [0, 0, 1]\npoint_m = [0, 0, 0]\n"
    file.write_text(text + "limits_deg = [0, 90]\n")
    assert Mechanism.load(file, moved.mockup).limits("j") == pytest.approx((0.0, math.pi / 2))
    for line, says in (
        ("limits = [0, 1]", "line 7: 'limits' is unknown"),
        ("limits_m = [0, 1]", "line 7: a revolute joint has no limits_m"),
        ("limits_deg = [0]", "line 7: limits_deg is no pair"),
        ("limits_deg = [10, 1]", r"line 7: limits_deg is \[10, 1\]: give the least value first"),
        ("colour = 1", "line 7: 'colour' is unknown"),
        ('ignore = [["a", "b"]]', "line 7: 'ignore' is unknown here: it stands before all tables"),
        ("axis = [0, 0, 0]", "line 5: .*length zero"),
    ):
        file.write_text((text.replace("axis = [0, 0, 1]\n", line + "\n") if "axis" in line else text + line) + "\n")
        with pytest.raises(LoadError, match=says):
            Mechanism.load(file, moved.mockup)
    file.write_text("version = 1\n" + text)
    assert Mechanism.load(file, moved.mockup).names == ("j",)
    for version in ("2", '"1"', "true", "1.0"):
        file.write_text(f"# of another feeler\nversion = {version}\n" + text)
        with pytest.raises(LoadError, match=r"line 2 is of version .*, and this feeler reads 1"):
            Mechanism.load(file, moved.mockup)
    file.write_text(text + "version = 1\n")
    with pytest.raises(LoadError, match="line 7: 'version' is unknown here: it stands before all tables"):
        Mechanism.load(file, moved.mockup)


def test_the_command_bounds_a_range_and_tells_where_it_does_not_hold(tmp_path: Path) -> None:
    moved = hinge()
    file, joints = tmp_path / "door.glb", tmp_path / "door.toml"
    write_glb(file, moved.mockup)
    joints.write_text('[[joint]]\nname = "hinge"\nkind = "revolute"\nchild = "*door"\nlimits_deg = [0, 90]\n')
    words = ["move", str(file), "--mechanism", str(joints)]
    ranges = run_json(*words)["ranges"]
    assert ranges[0]["upper"] == pytest.approx(hinge_contact(), abs=1e-5)
    more = ["--csv", str(tmp_path / "g.csv"), "--glb", str(tmp_path / "w.glb")]
    facts = run_json(*words, "--joint", "hinge=0:30", "--require", "10cm", *more)
    assert facts["holds"] and facts["lower"] > 0.1 and facts["undecided"] == 0.0
    assert (tmp_path / "g.csv").read_text("utf-8-sig").startswith("hinge_rad,gap_m,lower_m") and (
        tmp_path / "w.glb"
    ).exists()
    assert run(*words, "--joint", "hinge=0:1.5rad", code=1).stdout.startswith("does not hold: parts meet")
    run(*words, "--joint", "hinge=0:30", "--require", "1", code=1)
    started = tmp_path / "new.toml"
    run("move", str(file), "--write-mechanism", str(started))
    assert Mechanism.load(started, feeler.load_mockup(file)).names == ("hinge",)


def test_random_mechanisms_are_never_late_and_their_bounds_never_above_samples() -> None:
    rng = np.random.default_rng(1)
    asked = 0
    for _ in range(25):
        ends = [(c - h, c + h) for c, h in zip(rng.uniform(-1, 1, (4, 3)), rng.uniform(0.05, 0.3, (4, 3)), strict=True)]
        mock = mockup(**{name: tuple(each) for name, each in zip("abcd", ends, strict=True)})
        joints = [
            Joint("p", "revolute", None, "a", rng.normal(size=3), rng.uniform(-1, 1, 3)),
            Joint("q", "screw", "a", "b", rng.normal(size=3), rng.uniform(-1, 1, 3), pitch=0.3),
        ]
        moved = Mechanism(mock, joints)
        one, two, both = (feeler.Tool.of_parts(mock, parts) for parts in ("a", "b", ["a", "b"]))
        first, rest = moved.scene().only("a"), moved.scene().only(["c", "d"])
        if rest.is_colliding(both, np.eye(4)) or first.is_colliding(two, np.eye(4)):
            continue  # seats
        asked += 1
        free = moved.range("p")
        between = np.array([moved.poses({"p": q})["p"] for q in np.linspace(free.lower, free.upper, 100)[1:-1]])
        assert not any(len(rest.collide(both, pose)) for pose in between)
        found = moved.clearance({"p": (-0.3, 0.4), "q": (-0.2, 0.5)}, error=5e-3, most=3000)
        for p, q in rng.uniform([-0.3, -0.2], [0.4, 0.5], (30, 2)):
            poses = moved.poses({"p": p, "q": q})
            own = first.distance(two, np.linalg.inv(poses["p"]) @ poses["q"]).value
            assert found.lower <= min(own, rest.distance(one, poses["p"]).value, rest.distance(two, poses["q"]).value)
    assert asked > 15


def two_slides(offset: float = 0.0) -> Mechanism:
    """Block a slides along x to wall b, 0.2 m away; c slides far from both. offset: that c carries a by."""
    mock = mockup(
        a=((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), b=((0.3, 0.0, 0.0), (0.4, 0.1, 0.1)), c=((5.0, 0.0, 0.0), (5.1, 0.1, 0.1))
    )
    joints = [Joint("s", "prismatic", None, "a", (1, 0, 0)), Joint("h", "prismatic", None, "c", Z)]
    joints += [Joint("t", "prismatic", None, "b", (0, 1, 0))] if offset else []
    return Mechanism(mock, joints, [JointCoupling("s", "t", 1.0, offset)] if offset else [])


def test_what_stands_in_a_wall_counts_though_another_joint_moves() -> None:
    moved = two_slides()
    for values in ({"s": 0.25, "h": (0.0, 1.0)}, {"s": 0.25, "h": 0.3}, {"s": 0.25}):
        found = moved.clearance(values)
        assert (found.lower, found.upper, found.path, found.other_path) == (0.0, 0.0, "a", "b")
        assert [each.path for each in moved.clash(values).contacts] == ["a"]
    for values, gap in (({"s": 0.15, "h": (0.0, 1.0)}, 0.05), ({"h": (0.0, 1.0)}, 0.2), ({}, 0.2)):
        found = moved.clearance(values)
        assert (found.lower, found.upper) == pytest.approx((gap, gap)) and len(moved.clash(values)) == 0
    assert moved.clearance({"s": 0.15, "h": (0.0, 1.0)}).curve[:, 1].max() == pytest.approx(0.05)
    # The offset of a coupling brings a to b, where t stands.
    assert two_slides(0.25).clearance({"t": 0.0, "h": (0.0, 1.0)}).upper == 0.0
    assert len(two_slides(0.25).clash({"t": 0.0, "h": (0.0, 1.0)})) == 1


def test_parts_that_stand_as_they_are_modelled_may_touch_and_seats_may_not_go_deeper() -> None:
    mock = mockup(
        a=((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), b=((0.1, 0.0, 0.0), (0.2, 0.1, 0.1)), c=((5.0, 0.0, 0.0), (5.1, 0.1, 0.1))
    )
    joints = [Joint("s", "prismatic", None, "a", (1, 0, 0)), Joint("h", "prismatic", None, "c", Z)]
    moved = Mechanism(mock, joints)
    found = moved.clearance({"h": (0.0, 1.0)})
    assert found.lower > 4.0 and [(seat.path, seat.other_path) for seat in found.seats] == [("a", "b")]
    found = moved.clearance({"s": 0.05, "h": (0.0, 1.0)})
    assert found.upper == 0.0 and [(jam.path, jam.other_path) for jam in found.jams] == [("a", "b")]
    assert [each.path for each in moved.clash({"s": 0.05, "h": (0.0, 1.0)}).contacts] == ["a"]
    assert moved.clearance({"s": -0.05, "h": (0.0, 1.0)}).jams == ()


def test_seats_that_two_joints_move_are_followed_over_all_their_values(tmp_path: Path) -> None:
    """A carriage slides on a table in x and y, towards a post that is one part with the table."""
    slabs = [((-1.0, -1.0, -0.1), (1.0, 1.0, 0.0)), ((0.45, 0.45, -0.05), (0.55, 0.55, 0.3))]
    slabs += [((-0.9, -0.95, 0.1), (-0.6, -0.7, 0.2)), ((-0.8, -0.9, 0.0), (-0.7, -0.8, 0.1))]
    made = [box(*ends) for ends in slabs]
    faces = np.concatenate([np.asarray(faces) + 8 * i for i, (_, faces) in enumerate(made)])
    points = np.concatenate([vertices for vertices, _ in made])
    mock = feeler.Mockup(points, faces, np.repeat([0, 0, 1, 2], 12), ["table", "beam", "carriage"])
    joints = [Joint("x", "prismatic", None, "beam", (1, 0, 0)), Joint("y", "prismatic", "beam", "carriage", (0, 1, 0))]
    moved = Mechanism(mock, joints)
    found = moved.clearance({"x": (0.0, 1.5), "y": (0.0, 1.7)})
    assert (found.lower, found.upper, found.jams[0].path, found.jams[0].other_path) == (0.0, 0.0, "carriage", "table")
    # Nothing is met here, and nothing is proven.
    ranges = {"x": (0.0, 1.0), "y": (0.0, 1.2)}
    found = moved.clearance(ranges)
    assert (found.lower, found.jams, found.is_certified) == (0.0, (), False) and found.upper > 0.09
    apart = Mechanism(mock, joints, ignore=[("carriage", "*")]).clearance(ranges)
    assert apart.lower == pytest.approx(0.1, abs=1e-3) and apart.is_certified
    write_glb(tmp_path / "table.glb", mock)
    text = "".join(
        f'[[joint]]\nname = "{name}"\nkind = "prismatic"\nchild = "*{child}"\naxis = {axis}\n{more}'
        for name, child, axis, more in (
            ("x", "beam", [1, 0, 0], ""),
            ("y", "carriage", [0, 1, 0], 'parent = "*beam"\n'),
        )
    )
    (tmp_path / "table.toml").write_text(text)
    words = ("move", str(tmp_path / "table.glb"), "--mechanism", str(tmp_path / "table.toml"), "--joint", "x=0:1")
    said = run(*words, "--joint", "y=0:1.2", code=1).stdout
    assert "not proven to hold" in said and "of parts in contact that several joints move" in said


def test_flush_faces_of_links_that_nothing_joins_have_one_answer() -> None:
    """Two drawers side by side: they slide along each other, from wherever, and may go no deeper."""
    mock = mockup(
        a=((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), b=((0.1, 0.0, 0.0), (0.2, 0.1, 0.1)), c=((5.0, 5.0, 5.0), (6.0, 6.0, 6.0))
    )
    drawers = [Joint("a", "prismatic", None, "a", Z), Joint("b", "prismatic", None, "b", Z)]
    moved = Mechanism(mock, drawers)
    for at in (0.0, -0.2):
        found = moved.range("a", {"a": at})
        assert (found.below, found.above) == (None, None)
        assert [(seat.path, seat.other_path) for seat in found.seats] == [("a", "b")]
        assert len(moved.clash({"a": (at, 0.05)})) == 0
        assert moved.clearance({"a": (at, 0.05)}).lower > 4.0
    across = Mechanism(mock, [Joint("a", "prismatic", None, "a", (1, 0, 0)), drawers[1]])
    assert across.range("a").upper == pytest.approx(0.0, abs=2e-6)
    assert [each.path for each in across.clash({"a": (0.0, 0.05)}).contacts] == ["a"]
    assert across.clearance({"a": (0.0, 0.05)}).upper == 0.0
    # What crosses where it is modelled clashes.
    sunk = mockup(
        a=((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)),
        b=((0.09, 0.0, 0.0), (0.2, 0.1, 0.1)),
        c=((5.0, 5.0, 5.0), (6.0, 6.0, 6.0)),
    )
    assert len(Mechanism(sunk, drawers).clash({"a": (0.0, 0.05)})) == 1


def test_ignored_pairs_are_looked_at_by_no_question(tmp_path: Path) -> None:
    """A door on a pin with 0.1 mm of play, and a wall 5 mm off its other end."""
    boxes = {
        "door": ((0.0, 0.0, 0.0), (1.0, 0.02, 0.1)),
        "pin": ((-0.01, 0.0, 0.0), (-0.0001, 0.02, 0.1)),
        "wall": ((1.005, 0.0, 0.0), (1.1, 0.02, 0.1)),
    }
    mock, slide = mockup(**boxes), [Joint("slide", "prismatic", None, "door", (1, 0, 0))]
    near = Mechanism(mock, slide).clearance({"slide": (0.0, 0.002)})
    assert near.upper == pytest.approx(1e-4, abs=1e-6)
    for pairs in ([("door", "p*")], [("pin", "door")], np.array([[0, 1]]), [(1, 0), ("wall", "pin")]):
        moved = Mechanism(mock, slide, ignore=pairs)
        found = moved.clearance({"slide": (0.0, 0.002)}, error=1e-5)
        assert (found.other_path, found.seats) == ("wall", ()) and found.upper == pytest.approx(0.003, abs=1e-6)
        assert moved.range("slide", {"slide": 0.001}).below is None
        assert moved.range("slide").upper == pytest.approx(0.005, abs=1e-6)
        assert len(moved.clash({"slide": (-0.008, 0.002)})) == 0
        # Links that do not move against each other too.
        still = Mechanism(mock, [*slide, Joint("wall", "prismatic", None, "wall", Z)], ignore=pairs)
        assert still.clearance({"wall": (0.0, 0.0)}).upper == pytest.approx(0.005, abs=1e-6)
        moved.save(tmp_path / "door.toml")
        again = Mechanism.load(tmp_path / "door.toml", mock)
        assert again.clearance({"slide": (0.0, 0.002)}, error=1e-5).upper == found.upper
    # A seat that is ignored is none, and may go deeper.
    touching = mockup(a=((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), b=((0.1, 0.0, 0.0), (0.2, 0.1, 0.1)))
    along = [Joint("s", "prismatic", None, "a", (1, 0, 0))]
    assert Mechanism(touching, along).clearance({"s": (0.0, 0.01)}).jams
    free = Mechanism(touching, along, ignore=[("a", "b")]).clearance({"s": (0.0, 0.01)})
    assert (free.jams, free.seats, free.upper) == ((), (), math.inf)
    file = tmp_path / "bad.toml"
    for line, says in (
        ('ignore = ["door", "pin"]', "line 1: ignore is no list of pairs"),
        ('ignore = [["door", "nothing*"]]', "line 1: ignore"),
    ):
        file.write_text(line + '\n[[joint]]\nname = "j"\nkind = "revolute"\nchild = "door"\n')
        with pytest.raises(LoadError, match=says):
            Mechanism.load(file, mock)
    for bad in ("door", ["door"], [("door", "nothing*")], 3):
        with pytest.raises(OptionError, match="ignore"):
            Mechanism(mock, slide, ignore=bad)  # type: ignore[arg-type]


def test_one_of_two_joints_that_drive_a_loop_moves_with_the_other_held(tmp_path: Path) -> None:
    """Five bars: two cranks, and two rods that meet."""
    left, right, top = (-0.3, 0.4, 0.0), (1.3, 0.4, 0.0), (0.5, 1.0, 0.0)
    mock = dots((-0.15, 0.2, 0), (0.1, 0.7, 0.1), (1.15, 0.2, 0.2), (0.9, 0.7, 0.3), (3, 3, 0), (5, 5, 0))
    joints = [
        Joint("a", "revolute", None, "a", Z, limits=(-0.1, 0.1)),
        Joint("p", "revolute", "a", "b", Z, left),
        Joint("b", "revolute", None, "c", Z, (1, 0, 0)),
        Joint("q", "revolute", "c", "d", Z, right),
        Joint("o", "prismatic", None, "e", Z, limits=(0.0, 0.5)),
    ]
    moved = Mechanism(mock, joints, loops=[Joint("top", "revolute", "b", "d", Z, top)])
    for values, start in (({"b": 0.1}, 0.0), ({"a": 0.05, "b": 0.0}, 0.05)):
        found = moved.range("a", values)
        assert found.start == start and found.lower < start < found.upper
    with pytest.raises(MechanismError, match="more freedom"):
        moved.range("a")
    write_glb(tmp_path / "five.glb", mock)
    moved.save(tmp_path / "five.toml")
    text = (tmp_path / "five.toml").read_text()
    for side in ("child", "parent"):
        text = text.replace(f'{side} = "', f'{side} = "*/')
    (tmp_path / "five.toml").write_text(text)
    ended = run("move", str(tmp_path / "five.glb"), "--mechanism", str(tmp_path / "five.toml"), code=2)
    assert "o" in ended.stdout and "500 mm" in ended.stdout and "a: the loop" in ended.stderr
