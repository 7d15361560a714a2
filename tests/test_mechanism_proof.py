"""Mechanisms against closed forms: first contacts, seats, and certified bounds."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from commands import run
from shapes import box, mockup_of, prism_ring

import feeler
from feeler import Joint, JointCoupling, Mechanism
from feeler.io import write_glb
from feeler.mechanism.enclosing import enclosure
from feeler.mechanism.legs import Legs

Z = (0.0, 0.0, 1.0)
Mesh = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]


def parts(**meshes: Mesh | list[Mesh]) -> feeler.Mockup:
    """A mock-up of meshes by name; a list is one part."""
    vertices, faces, of = [], [], []
    count = 0
    for number, each in enumerate(meshes.values()):
        for own, triangles in each if isinstance(each, list) else [each]:
            vertices.append(own)
            faces.append(np.asarray(triangles) + count)
            of += [number] * len(triangles)
            count += len(own)
    return feeler.Mockup(np.concatenate(vertices), np.concatenate(faces), of, list(meshes))


def cube(x: float, y: float, z: float, half: float = 0.01) -> Mesh:
    """A small box about a point."""
    return box((x - half, y - half, z - half), (x + half, y + half, z + half))


def reach_of_edge(x: float, y: float, off: float) -> float:
    """The angle at which the face of a leaf, `off` beside the axis, meets an edge at (x, y)."""
    return math.atan2(y, x) - math.asin(off / math.hypot(x, y))


def slider_crank(far: float = 0.35) -> Mechanism:
    """It stands at 90 degrees, before a wall at `far`."""
    crank, rod = 0.1, 0.3
    along = math.sqrt(rod**2 - crank**2)
    mock = parts(
        a=cube(0, crank / 2, 0), b=cube(along / 2, crank / 2, 0.1), c=cube(along, 0, 0.2), d=cube(far + 0.02, 0, 0.2)
    )
    return Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("rod", "revolute", "a", "b", Z, (0, crank, 0)),
            Joint("slider", "prismatic", None, "c", (1, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (along, 0, 0))],
    )


def test_a_slider_crank_stops_where_its_slider_meets_a_wall() -> None:
    crank, rod, far = 0.1, 0.3, 0.35
    moved = slider_crank(far)
    # place^2 - 2 crank cos(angle) place + crank^2 - rod^2 = 0
    angle = math.acos((far**2 + crank**2 - rod**2) / (2 * crank * far))
    found = moved.range("crank")
    assert found.lower == pytest.approx(angle - math.pi / 2, abs=1e-6) and not found.is_certified
    assert found.below is not None and (found.below.path, found.below.other_path) == ("c", "d")
    assert found.below.normal == pytest.approx((-1.0, 0.0, 0.0), abs=1e-6)
    listed = moved.clash({"crank": (-1.2, 0.0)})
    assert [(each.path, each.other_path) for each in listed.contacts] == [("c", "d")]
    gap = moved.clearance({"crank": (-0.5, 0.0)}, error=1e-4)
    inner = math.pi / 2 - 0.5
    place = crank * math.cos(inner) + math.sqrt(rod**2 - (crank * math.sin(inner)) ** 2)
    assert gap.is_certified and gap.lower <= far - place <= gap.upper + 1e-12 and gap.upper - gap.lower <= 1.1e-4
    at = math.pi / 2 + gap.curve[:, 0]
    truth = far - crank * np.cos(at) - np.sqrt(rod**2 - (crank * np.sin(at)) ** 2)
    assert (gap.curve[:, 2] <= truth).all() and gap.curve[:, 1] == pytest.approx(truth, abs=1e-9)


def bennett(long: float = 1.0, twist: float = 0.6, short: float = 0.6) -> Mechanism:
    """Four bars in space: opposite ones alike, twists in the ratio of their lengths. See Bennett 1903."""
    other = math.asin(short * math.sin(twist) / long)
    place = np.eye(4)
    points, axes = [], []
    for far, lean, turn in zip(
        (long, short) * 2, (twist, other) * 2, (0.7, *bennett_turns(0.7, twist, other)), strict=True
    ):
        c, s, a, b = math.cos(turn), math.sin(turn), math.cos(lean), math.sin(lean)
        points.append(tuple(place[:3, 3].tolist()))
        axes.append(tuple(place[:3, 2].tolist()))
        place = place @ np.array([[c, -s * a, s * b, far * c], [s, c * a, -c * b, far * s], [0, b, a, 0], [0, 0, 0, 1]])
    assert place == pytest.approx(np.eye(4), abs=1e-12), "it closes where it is modelled"
    mids = [tuple(((np.array(points[n]) + points[(n + 1) % 4]) / 2).tolist()) for n in range(3)]
    mock = parts(a=cube(*mids[0]), b=cube(*mids[1]), c=cube(*mids[2]), d=cube(0, -3, 0))
    return Mechanism(
        mock,
        [
            Joint("one", "revolute", None, "a", axes[0], points[0]),
            Joint("two", "revolute", "a", "b", axes[1], points[1]),
            Joint("three", "revolute", "b", "c", axes[2], points[2]),
        ],
        loops=[Joint("four", "revolute", "c", "d", axes[3], points[3])],
    )


def bennett_turns(first: float, twist: float, other: float) -> tuple[float, float, float]:
    """The other three turns."""
    rate = math.sin((other + twist) / 2) / math.sin((other - twist) / 2)
    second = 2 * math.atan2(rate, math.tan(first / 2))
    return second, -first, -second


def test_a_loop_in_space_follows_its_closed_form() -> None:
    moved, twist = bennett(), 0.6
    other = math.asin(0.6 * math.sin(twist))
    start = bennett_turns(0.7, twist, other)
    for by in (-0.5, 0.4, 1.5):
        found = moved.position({"one": by})
        second, third, _ = bennett_turns(0.7 + by, twist, other)
        wrapped = [
            math.remainder(found[k] - (v - w), math.tau)
            for k, v, w in zip(("two", "three"), (second, third), start, strict=False)
        ]
        assert wrapped == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("which", ["crank", "bennett", "slider", "parallel"])
def test_loops_are_where_they_are_proven_to_be(which: str) -> None:
    """Positions between the ends of legs are within the boxes, which are not much wider than they are off."""
    if which == "bennett":
        moved, name, end = bennett(), "one", 0.3
    elif which == "parallel":
        moved, name, end = parallel(), "crank", 0.4
    else:
        moved, name, end = slider_crank(), which, 1.0 if which == "crank" else 0.117
    rng, positions = np.random.default_rng(3), moved._positions
    shares, count = [], 0
    for leg in list(Legs(positions, name, {}, 0.0, end))[::4]:
        box = enclosure(positions, name, {}, leg)
        assert box is not None and box[name] == 0.0
        for share in (0.5, rng.uniform()):
            place, straight = positions.position({name: leg.value(share)}, leg.start), leg.at(share)
            for each, value in place.items():
                off = abs(value - straight[each])
                assert off <= box[each] + 1e-13
                shares += [box[each] / off] if share == 0.5 and off > 1e-9 else []
        count += 1
    assert count > 5 and (which == "parallel" or 1.0 <= np.median(shares) < 8.0)


@pytest.mark.parametrize("seed", range(2))
def test_bounds_along_a_loop_hold_at_all_positions(seed: int) -> None:
    """A post stands where the coupler of a four-bar comes by."""
    rng = np.random.default_rng(seed)
    frame, side = rng.uniform(0.3, 0.5), rng.uniform(0.2, 0.35)
    moved = parallel(frame, side, tuple(rng.uniform((0.05, -0.02), (0.15, 0.15))))
    error = float(10 ** rng.uniform(-4.0, -3.0))
    found = moved.clearance({"crank": (-0.3, 0.3)}, error=error)
    assert found.is_certified and 0.0 <= found.upper - found.lower <= 1.1 * error
    for value in rng.uniform(-0.3, 0.3, 20).tolist():
        scene = moved.scene({"crank": value})
        tool = feeler.Tool.of_parts(scene.mockup, "d")
        near = scene.without("d").distance(tool, np.eye(4)).value
        assert found.lower <= near


@pytest.mark.parametrize("name", ["bar", "foot"])
def test_a_scissor_lift_comes_as_near_to_the_ceiling_as_its_bars_say(name: str) -> None:
    # Two bars of length 1 cross at their middles; a coupling keeps the table level; either end may drive.
    wide, high, ceiling = math.cos(0.5), math.sin(0.5), 0.9
    mock = parts(
        a=cube(wide / 4, high / 4, 0),
        b=cube(0.75 * wide, high / 4, 0.1),
        c=cube(wide, 0, 0.2),
        d=box((wide / 2 - 0.2, high, 0.28), (wide / 2 + 0.2, high + 0.05, 0.32)),
        e=box((-1, ceiling, 0.2), (2, ceiling + 0.1, 0.4)),
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
    ends = {"bar": (0.0, 0.25), "foot": (math.cos(0.75) - wide, 0.0)}[name]
    gap = moved.clearance({name: ends}, error=1e-4)
    assert gap.is_certified and gap.upper - gap.lower <= 1.1e-4 and (gap.path, gap.other_path) == ("d", "e")
    assert gap.lower <= ceiling - 0.05 - math.sin(0.75) == pytest.approx(gap.upper, abs=1e-9)
    free = moved.range(name)
    top = math.asin(ceiling - 0.05)
    assert (free.upper if name == "bar" else free.lower) == pytest.approx(
        top - 0.5 if name == "bar" else math.cos(top) - wide, abs=1e-6
    )


def parallel(frame: float = 0.4, side: float = 0.3, post: tuple[float, float] = (0.2, 0.1)) -> Mechanism:
    """A parallelogram, in which the rocker turns as the crank does, and a post."""
    low, high = (post[0], post[1], -0.3), (post[0] + 0.02, post[1] + 0.02, 0.3)
    mock = parts(a=cube(0, side / 2, 0), b=cube(frame / 2, side, 0.1), c=cube(frame, side / 2, 0.2), d=box(low, high))
    return Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("coupler", "revolute", "a", "b", Z, (0, side, 0)),
            Joint("rocker", "revolute", None, "c", Z, (frame, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (frame, side, 0))],
    )


def test_a_thin_plate_between_two_steps_of_a_loop_is_met() -> None:
    # A plate 10 um thick in the way of the rocker: no position of a loop followed in steps is within it.
    frame, side = 0.4, 0.3
    plate = box((frame + 0.0, side - 0.0005, 0.19), (frame + 1e-5, side + 0.02, 0.21))
    mock = parts(a=cube(0, side / 2, 0), b=cube(0.2, side, 0.1), c=cube(frame + 0.05, side, 0.2), d=plate)
    moved = Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("coupler", "revolute", "a", "b", Z, (0, side, 0)),
            Joint("rocker", "revolute", None, "c", Z, (frame, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (frame, side, 0))],
    )
    # A parallelogram: the rocker turns as the crank does. Its corner (0.04, 0.29) from the pivot reaches x 1e-5.
    far = math.hypot(0.04, side - 0.01)
    angle = math.acos(1e-5 / far) - math.atan2(side - 0.01, 0.04)
    found = moved.range("crank")
    assert found.above is not None and (found.above.path, found.above.other_path) == ("c", "d")
    assert found.upper < angle  # it is met before that corner comes there, by the face beside it


def test_a_four_bar_stops_where_its_rocker_meets_a_wall() -> None:
    # A parallelogram, in which the rocker turns as the crank does.
    frame, side = 0.4, 0.3
    mock = parts(
        a=cube(0, side / 2, 0),
        b=cube(frame / 2, side, -0.1),
        c=cube(frame, side, 0.2),
        d=box((frame - 0.2, 0.0, 0.15), (frame - 0.1, side, 0.3)),
    )
    moved = Mechanism(
        mock,
        [
            Joint("crank", "revolute", None, "a", Z),
            Joint("coupler", "revolute", "a", "b", Z, (0, side, 0)),
            Joint("rocker", "revolute", None, "c", Z, (frame, 0, 0)),
        ],
        loops=[Joint("pin", "revolute", "b", "c", Z, (frame, side, 0))],
    )
    found = moved.range("crank")
    # The corner at (-0.01, 0.31) from the rocker's pivot turns to x = -0.1; or a lower one that is there before.
    first = min(
        math.asin(0.1 / math.hypot(0.01, y)) - math.atan2(0.01, y)
        for y in (side - 0.01, side + 0.01)
        if math.hypot(0.01, y) * math.cos(math.asin(0.1 / math.hypot(0.01, y))) <= side
    )
    assert found.upper == pytest.approx(first, abs=1e-6) and found.upper <= first + 1e-7
    assert found.above is not None and (found.above.path, found.above.other_path) == ("c", "d")


def test_a_cam_comes_as_near_to_its_follower_as_its_radius_says() -> None:
    # The corner of the cam at radius hypot(0.3, 0.05) passes below the flat foot of the follower.
    far, height = math.hypot(0.3, 0.05), 0.4
    mock = parts(cam=box((-0.1, -0.05, 0), (0.3, 0.05, 0.1)), foot=box((-0.2, height, 0), (0.2, height + 0.1, 0.1)))
    cam = Joint("cam", "revolute", None, "cam", Z)
    follower = Joint("lift", "prismatic", None, "foot", (0, 1, 0))
    moved = Mechanism(mock, [cam, follower])
    found = moved.clearance({"cam": (0.0, math.pi)}, error=1e-6)
    assert found.lower <= height - far <= found.upper <= found.lower + 1.01e-6
    top = math.pi / 2 - math.atan2(0.05, 0.3)
    assert min(abs(found.worst["cam"] - each) for each in (top, math.pi - top)) < 5e-3
    # Lowered to 0.302 it is met where the corner comes to that height.
    low = moved.range("cam", {"lift": 0.302 - height})
    angle = math.asin(0.302 / far) - math.atan2(0.05, 0.3)
    assert low.upper == pytest.approx(angle, abs=1e-6) and low.upper <= angle
    assert low.above is not None and low.above.normal == pytest.approx((0.0, -1.0, 0.0), abs=1e-3)


def test_a_rack_keeps_up_with_its_worm() -> None:
    # Both advance alike, so the tooth of the worm only turns as seen from the rack, up to the rack's bar.
    pitch = 0.05
    mock = parts(
        worm=box((0, -0.01, 0), (0.1, 0.01, 0.02)), bar=box((-0.2, 0.06, -0.5), (0.2, 0.07, 0.5)), rest=cube(9, 9, 9)
    )
    joints = [
        Joint("worm", "screw", None, "worm", Z, pitch=pitch),
        Joint("rack", "prismatic", None, "bar", Z),
    ]
    moved = Mechanism(mock, joints, [JointCoupling("rack", "worm", pitch / math.tau)])
    angle = math.asin(0.06 / math.hypot(0.1, 0.01)) - math.atan2(0.01, 0.1)
    found = moved.range("worm")
    assert found.is_certified
    assert found.upper == pytest.approx(angle, abs=1e-6) and found.upper <= angle
    gap = moved.clearance({"worm": (0.0, 0.3)}, error=1e-6)
    truth = 0.06 - math.hypot(0.1, 0.01) * math.sin(0.3 + math.atan2(0.01, 0.1))
    assert gap.lower <= truth <= gap.upper + 1e-12 and gap.upper - gap.lower <= 1.01e-6
    assert [(each.path, each.other_path) for each in moved.clash({"worm": (0.0, 0.8)}).contacts] == [("worm", "bar")]
    two = moved.clearance({"rack": (0.0, 0.3 * pitch / math.tau)}, error=1e-6)
    assert two.upper == pytest.approx(gap.upper, abs=2e-6)


def test_a_scissor_lift_stops_at_the_ceiling() -> None:
    angle, bar, ceiling = 0.5, 1.0, 0.8
    wide, high = bar * math.cos(angle), bar * math.sin(angle)
    mock = parts(
        a=cube(wide / 4, high / 4, 0),
        b=cube(0.75 * wide, high / 4, 0.1),
        c=cube(wide, 0, 0.2),
        d=cube(wide / 2, high, 0.3),
        e=box((-2, ceiling + 0.01, 0.2), (2, 1, 0.4)),
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
    found = moved.range("bar")
    assert found.upper == pytest.approx(math.asin(ceiling / bar) - angle, abs=1e-6)
    assert found.above is not None and (found.above.path, found.above.other_path) == ("d", "e")


@pytest.mark.parametrize(
    ("pin", "hole", "sides", "turned"),
    [
        (0.01, 0.01, 24, 0.0),  # as deep as it gets when it has turned by half a facet
        (0.01, 0.01, 18, 0.1),
        (0.01, 0.010002, 24, 0.0),  # clear of its hole where it is modelled
        (0.0102, 0.01, 24, 0.0),  # pressed in
        (0.0102, 0.01, 8, 0.05),
    ],
)
@pytest.mark.parametrize("is_pin_moved", [True, False])
def test_a_pin_turns_in_a_hole_of_facets(
    pin: float, hole: float, sides: int, turned: float, is_pin_moved: bool
) -> None:
    mock = parts(
        pin=[prism_ring(pin, 0.0, sides, -0.02, 0.03, turned), prism_ring(0.03, 0.0, sides, 0.02, 0.03)],
        plate=prism_ring(0.05, hole, 24, 0.0, 0.02),
    )
    child, parent = ("pin", "plate") if is_pin_moved else ("plate", "pin")
    moved = Mechanism(mock, [Joint("hinge", "revolute", parent, child, Z)])
    found = moved.range("hinge")
    assert (found.lower, found.upper, found.below, found.above) == (-math.tau, math.tau, None, None)
    assert [(seat.path, seat.other_path) for seat in found.seats] == [(child, parent)]
    assert not moved.clash({"hinge": (-1.0, 1.0)}).contacts
    # Away from the collar it slides as well; against it not.
    slide = Mechanism(mock, [Joint("rod", "cylindrical", parent, child, Z)]).range("rod.slide")
    ends = (slide.lower, slide.upper) if is_pin_moved else (-slide.upper, -slide.lower)
    assert ends[0] == pytest.approx(0.0, abs=1e-5) and ends[1] > 0.02


@pytest.mark.parametrize("sides", [4, 6])
def test_a_pin_with_edges_jams_in_its_hole(sides: int) -> None:
    mock = parts(pin=prism_ring(0.01, 0.0, sides, -0.02, 0.03), plate=prism_ring(0.05, 0.01, sides, 0.0, 0.02))
    found = Mechanism(mock, [Joint("hinge", "revolute", "plate", "pin", Z)]).range("hinge")
    assert found.upper < 0.01 and found.lower > -0.01
    assert found.above is not None and found.above.other_path == "plate"


@pytest.mark.parametrize("kind", ["oval", "beside its axis", "with a flat"])
def test_a_pin_that_is_not_round_about_the_axis_jams_however_fine_its_facets(kind: str) -> None:
    shapes = {"pin": prism_ring(0.1, 0.0, 400, -0.1, 0.2), "plate": prism_ring(0.2, 0.1, 400, 0.0, 0.1)}
    for vertices, _ in shapes.values():
        if kind == "with a flat":  # the corners of one wide facet, on the circle
            radius, turn = np.hypot(*vertices[:, :2].T), np.arctan2(vertices[:, 1], vertices[:, 0])
            inside = np.abs(turn) < 0.2
            turn[inside & (radius < 0.15)] = np.copysign(0.2, turn[inside & (radius < 0.15)])
            vertices[:, 0], vertices[:, 1] = radius * np.cos(turn), radius * np.sin(turn)
        else:
            vertices[:, 0] = 1.02 * vertices[:, 0] if kind == "oval" else vertices[:, 0] + 0.002
    found = Mechanism(parts(**shapes), [Joint("hinge", "revolute", "plate", "pin", Z)]).range("hinge")
    assert -0.01 < found.lower <= found.upper < 0.01
    assert found.above is not None and found.above.other_path == "plate"


@pytest.mark.parametrize(("collar", "sides"), [(0.0003, 100), (0.003, 24), (0.003, 100)])
def test_a_collar_does_not_slide_out_of_its_groove(collar: float, sides: int) -> None:
    def lathe(outline: list[tuple[float, float]]) -> Mesh:
        circle = np.arange(sides) * math.tau / sides
        points = [np.column_stack([r * np.cos(circle), r * np.sin(circle), np.full(sides, z)]) for r, z in outline]
        a, faces = np.arange(sides), []
        for level in range(len(outline)):
            here, there = sides * level, sides * ((level + 1) % len(outline))
            b = (a + 1) % sides
            faces += [
                np.column_stack([here + a, here + b, there + b]),
                np.column_stack([here + a, there + b, there + a]),
            ]
        return np.concatenate(points), np.concatenate(faces)

    wide = 0.1 + collar
    steps = [(0.1, 0.03), (wide, 0.03), (wide, 0.07), (0.1, 0.07)]
    mock = parts(
        pin=lathe([(0.05, -0.1), (0.1, -0.1), *steps, (0.1, 0.2), (0.05, 0.2)]),
        plate=lathe([(0.2, 0.0), (0.2, 0.1), (0.1, 0.1), *steps[::-1], (0.1, 0.0)]),
    )
    moved = Mechanism(mock, [Joint("c", "cylindrical", "plate", "pin", Z)])
    turn, slide = moved.range("c.turn"), moved.range("c.slide")
    assert (turn.lower, turn.upper) == (-math.tau, math.tau)
    assert -1e-4 < slide.lower <= slide.upper < 1e-4
    assert moved.clearance({"c.slide": (0.0, 0.02)}).lower == 0.0
    screw = Mechanism(mock, [Joint("s", "screw", "plate", "pin", Z, pitch=0.01)]).range("s")
    assert -0.1 < screw.lower <= screw.upper < 0.1


def jamming_door() -> Mechanism:
    """A door that stands on the sill of its frame, all of one part, and meets a post of it at 45 degrees or so."""
    door = box((0.1, -0.01, 0.0), (1.0, 0.01, 1.0))
    sill, post = box((-0.5, -0.5, -0.1), (1.5, 1.5, 0.0)), box((0.5, 0.5, 0.5), (0.6, 0.6, 0.7))
    return Mechanism(parts(door=door, frame=[sill, post]), [Joint("hinge", "revolute", "frame", "door", Z)])


def test_a_door_that_jams_in_its_own_frame_is_told_by_all_answers(tmp_path: Path) -> None:
    moved = jamming_door()
    angle = reach_of_edge(0.6, 0.5, 0.01)  # the post's edge that the door's front comes to first
    found = moved.range("hinge")
    assert found.upper == pytest.approx(angle, abs=1e-6) and found.upper <= angle
    assert found.above is not None and found.above.other_path == "frame"
    assert [seat.kind for seat in found.seats] == ["touching"]
    listed = moved.clash({"hinge": (0.0, 1.5)}).contacts
    assert [(each.path, each.other_path) for each in listed] == [("door", "frame")]
    assert listed[0].value == pytest.approx(angle, abs=1e-6)
    gap = moved.clearance({"hinge": (0.0, 1.5)})
    assert (gap.lower, gap.upper, gap.path, gap.other_path) == (0.0, 0.0, "door", "frame")
    assert gap.worst["hinge"] == pytest.approx(angle, abs=1e-6) and gap.jams[0].value == gap.worst["hinge"]
    assert not moved.clearance({"hinge": (0.0, 0.5)}).jams
    # From beyond the post, where it touches the sill as well, it comes back to the other side of it.
    back = moved.range("hinge", {"hinge": 1.4})
    far = math.atan2(0.6, 0.5) + math.asin(0.01 / math.hypot(0.5, 0.6))
    assert back.lower == pytest.approx(far, abs=1e-6) and back.lower >= far
    # Within the post it does not move, either way.
    stuck = moved.range("hinge", {"hinge": 0.8})
    assert (stuck.lower, stuck.upper) == (0.8, 0.8)
    file, joints = tmp_path / "door.glb", tmp_path / "door.toml"
    write_glb(file, moved.mockup)
    joints.write_text('[[joint]]\nname = "hinge"\nkind = "revolute"\nparent = "*frame"\nchild = "*door"\n')
    words = ["move", str(file), "--mechanism", str(joints), "--joint"]
    assert run(*words, "hinge=0:85", code=1).stdout.startswith("does not hold: parts meet")
    run(*words, "hinge=0:25")


def test_a_jam_over_several_joints_is_found() -> None:
    mock = parts(
        door=box((0.1, -0.01, 0.0), (1.0, 0.01, 1.0)),
        frame=[box((-0.5, -0.5, -0.1), (1.5, 1.5, 0.0)), box((0.5, 0.5, 0.5), (0.6, 0.6, 0.7))],
        flap=box((0.1, -0.01, 1.1), (1.0, 0.01, 1.2)),
    )
    joints = [Joint("hinge", "revolute", "frame", "door", Z), Joint("flap", "revolute", "frame", "flap", Z)]
    moved = Mechanism(mock, joints)
    asked: dict[str, float | tuple[float, float]] = {"hinge": (0.0, 1.5), "flap": (0.0, 0.5)}
    found = moved.clearance(asked)
    assert (found.upper, found.is_certified) == (0.0, True) and found.jams[0].other_path == "frame"
    free = moved.clearance({"hinge": (0.0, 0.4), "flap": (0.0, 0.5)}, error=0.02)
    assert not free.jams and free.is_certified and free.lower <= 0.1 <= free.upper + 1e-9


def test_a_seat_that_parts_is_exact_afterwards_and_may_come_back() -> None:
    # The drawer stands at its stop. Behind it, the same part has a rail that ends 0.3 on.
    body = [box((-0.1, 0, 0), (0.0, 0.1, 0.1)), box((0.5, 0, 0), (0.6, 0.1, 0.1))]
    mock = parts(drawer=box((0.0, 0, 0), (0.2, 0.1, 0.1)), body=body)
    moved = Mechanism(mock, [Joint("slide", "prismatic", "body", "drawer", (1, 0, 0))])
    found = moved.range("slide")
    assert found.lower == pytest.approx(0.0, abs=2e-6) and found.upper == pytest.approx(0.3, abs=1e-7)
    again = moved.range("slide", {"slide": 0.1})
    assert again.lower == pytest.approx(0.0, abs=2e-6) and again.upper == pytest.approx(0.3, abs=1e-7)
    assert not moved.clash({"slide": (0.0, 0.2)}).contacts
    assert [each.value for each in moved.clash({"slide": (-0.1, 0.2)}).contacts] == [-0.1]


def random_arm(rng: np.random.Generator) -> tuple[Mechanism, list[str]]:
    """Three links, of all kinds of joints, and things around."""
    low = rng.uniform(-1, 1, (6, 3))
    meshes = {
        name: box(at, at + size) for name, at, size in zip("abcdef", low, rng.uniform(0.1, 0.4, (6, 3)), strict=True)
    }
    kinds = [str(kind) for kind in rng.choice(["revolute", "prismatic", "screw"], 3)]
    joints = [
        Joint(
            name, kind, parent, part, rng.normal(size=3), rng.uniform(-1, 1, 3), pitch=0.4 if kind == "screw" else 0.0
        )
        for name, kind, parent, part in zip("pqr", kinds, (None, "a", "b"), "abc", strict=True)
    ]
    return Mechanism(parts(**meshes), joints), list("pqr")


def least_gap(moved: Mechanism, values: dict[str, float]) -> float:
    """The least gap at a position, by poses: of links to what stands, and of all pairs of links."""
    poses = moved.poses(values)
    placed = {"a": poses["p"], "b": poses["q"], "c": poses["r"]}
    scene, least = moved.scene().only(["d", "e", "f"]), math.inf
    for name, pose in placed.items():
        least = min(least, scene.distance(feeler.Tool.of_parts(moved.mockup, name), pose).value)
    for one, other in ("ba", "ca", "cb"):
        alone, pose = moved.scene().only(other), np.linalg.inv(placed[other]) @ placed[one]
        least = min(least, alone.distance(feeler.Tool.of_parts(moved.mockup, one), pose).value)
    return least


@pytest.mark.parametrize("is_coupled", [False, True])
def test_certified_bounds_are_never_above_random_positions(is_coupled: bool) -> None:
    rng = np.random.default_rng(11)
    asked = 0
    while asked < 12:
        moved, names = random_arm(rng)
        if least_gap(moved, {}) == 0.0:
            continue  # seats
        asked += 1
        ranges: dict[str, float | tuple[float, float]] = {"p": (-0.2, 0.3)}
        if is_coupled:
            couplings = [JointCoupling("q", "p", 0.7), JointCoupling("r", "p", -1.2)]
            moved = Mechanism(moved.mockup, moved.joints, couplings)
        else:
            ranges["r"] = (-0.1, 0.2)
        asked_of = dict(ranges)
        found = moved.clearance(ranges, error=2e-3, most=400)
        assert found.is_certified and found.lower <= found.upper
        for _ in range(25):
            drawn = {name: float(rng.uniform(*np.array(ends))) for name, ends in asked_of.items()}
            position = moved.position(drawn)
            assert found.lower <= least_gap(moved, position) + 1e-9
        assert found.upper == pytest.approx(least_gap(moved, found.worst), abs=1e-9)
        if is_coupled and found.upper > 0.0:
            assert found.upper - found.lower <= 2.01e-3
            for value, gap, lower in found.curve[::10]:
                assert least_gap(moved, moved.position({"p": float(value)})) == pytest.approx(gap, abs=1e-9)
                assert lower <= gap
    assert names == ["p", "q", "r"]


def test_the_reach_of_an_arm_is_bounded_from_both_sides() -> None:
    # It comes nearest to the wall at the end of both ranges, by a corner of its tip.
    mock = parts(
        upper=box((0.0, -0.02, 0.0), (0.5, 0.02, 0.05)),
        lower=box((0.5, -0.02, 0.2), (1.0, 0.02, 0.25)),
        wall=box((1.05, -1.0, 0.2), (1.1, 1.0, 0.3)),
    )
    joints = [
        Joint("shoulder", "revolute", None, "upper", Z),
        Joint("elbow", "revolute", "upper", "lower", Z, (0.5, 0.0, 0.0)),
    ]
    truth = 1.05 - 0.5 * math.cos(0.4) - math.hypot(0.5, 0.02) * math.cos(0.5 - math.atan2(0.02, 0.5))
    found = Mechanism(mock, joints).clearance({"shoulder": (0.1, 0.4), "elbow": (-1.6, -0.9)}, error=1e-3)
    assert found.lower <= truth <= found.upper <= found.lower + 1.01e-3
    assert (found.path, found.other_path, found.undecided) == ("lower", "wall", 0.0)
    assert found.worst == pytest.approx({"shoulder": 0.4, "elbow": -0.9}, abs=0.01)


def test_the_part_that_the_asked_joint_moves_comes_first() -> None:
    # The hinge stands; the link that it moves is made before that of the slide.
    mock = mockup_of(
        {
            "door": box((0.0, 0.0, 0.0), (1.0, 0.05, 1.0)),
            "drawer": box((3.0, 0.0, 0.0), (3.5, 0.5, 0.2)),
            "stop": box((4.0, 0.0, 0.0), (4.1, 0.5, 0.2)),
        }
    )
    hinge = Joint("hinge", "revolute", None, "door", axis=(0, 0, 1), limits=(0, 2))
    slide = Joint("slide", "prismatic", None, "drawer", axis=(1, 0, 0))
    for joints in ([hinge, slide], [slide, hinge], [slide]):
        moved = Mechanism(mock, joints)
        found = moved.range("slide")
        assert found.below is not None and found.above is not None
        assert (found.below.path, found.below.other_path, found.below.normal) == ("drawer", "door", (1.0, 0.0, 0.0))
        assert (found.above.path, found.above.other_path, found.above.normal) == ("drawer", "stop", (-1.0, 0.0, 0.0))
        met = moved.clash({"slide": (-2.5, 0.0)}).contacts
        assert [(each.path, each.other_path) for each in met] == [("drawer", "door")]
