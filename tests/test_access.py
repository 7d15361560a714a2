"""Access: places with answers that are known, and random ones held to a dense sampling."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import at, box, joined, mockup_of, tool_of

import feeler
from feeler.errors import MeshError, OptionError, PoseError
from feeler.plan.pair_turns import blocked_turns
from feeler.plan.reaching import AccessInterrupted
from feeler.plan.tool_seat import seated_tool
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

Floats = npt.NDArray[np.float64]
Mesh = tuple[Floats, npt.NDArray[np.int64]]

HEAD_TOP = 0.68 * 0.008


def bolt(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
    """An M8 hexagon bolt, its head on z."""
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    return mesh.vertices + np.array([x, y, z]), mesh.faces


def bar(start: float = 0.012, end: float = 0.2, low: float = -0.004, high: float = 0.004) -> feeler.Tool:
    """A flat spanner as a bar along x, its own origin where the bolt's head is."""
    return feeler.Tool(*box((start, -0.004, low), (end, 0.004, high)), "bar")


def sheet(degrees: float, start: float, end: float, low: float = -0.01, high: float = 0.01) -> Mesh:
    """A sheet without thickness through the z axis."""
    corners = np.array([[start, 0, low], [end, 0, low], [end, 0, high], [start, 0, high]])
    return corners @ at(degrees=degrees)[:3, :3].T, np.array([[0, 1, 2], [0, 2, 3]])


BLADE = feeler.Tool(*sheet(0.0, 0.02, 0.1, -0.005, 0.005), "blade")
PLATE = box((-0.5, -0.5, -0.02), (0.5, 0.5, -0.001))
TOP = at(z=HEAD_TOP)


def asked(parts: dict[str, Mesh], tool: feeler.Tool, **options: Any) -> feeler.Reach:
    """The answer for the bolt at the origin."""
    scene = feeler.Scene(mockup_of({"bolt": bolt(), **parts}))
    (row,) = feeler.access(scene, tool, TOP, threads=1, **options)
    return row


def test_a_bolt_in_the_open() -> None:
    row = asked({"plate": PLATE}, bar())
    assert row.is_reachable and row.swing_deg == 360.0 and row.angle_deg == 0.0
    assert row.part == 0 and row.path == "bolt" and row.blockers == ()
    assert row.way.shape == (2, 4, 4)
    assert np.allclose(row.way[0] - row.way[1], at(z=0.1) - np.eye(4))
    assert row.because == "360.0 degrees are free, with a way in over 100 mm"


def test_a_well_too_deep_for_a_bar_and_not_for_a_driver() -> None:
    walls = [
        box((x - 0.03, y - 0.03, 0.0), (x + 0.03, y + 0.03, 0.2))
        for x, y in ((0.06, 0), (-0.06, 0), (0, 0.06), (0, -0.06))
    ]
    row = asked({"well": joined(*walls)}, bar())
    assert not row.is_reachable and row.swing_deg == 0.0 and np.isnan(row.angle_deg) and row.way.shape == (0, 4, 4)
    assert row.because == "no swing of 0.001 degrees or more is free"
    assert row.blockers == (feeler.Blocker(1, "well", 72),)
    driver = feeler.Tool(*box((-0.005, -0.005, -0.002), (0.005, 0.005, 0.3)), "driver")
    row = asked({"well": joined(*walls)}, driver)
    assert row.is_reachable and row.swing_deg == 360.0 and row.way.shape == (2, 4, 4)
    # A handle that is wider than the well stands above it, but does not get in deeper.
    handle = joined(box((-0.005, -0.005, -0.002), (0.005, 0.005, 0.3)), box((-0.04, -0.04, 0.1), (0.04, 0.04, 0.3)))
    assert not asked({"well": joined(*walls)}, feeler.Tool(*handle, "driver")).is_reachable


@pytest.mark.parametrize("angles", [7, 72, 360])
@pytest.mark.parametrize("first", [0.0, 33.3, 211.0])
def test_walls_that_leave_90_degrees(angles: int, first: float) -> None:
    walls = [sheet(first + turn, 0.05, 0.12) for turn in (0, 90, 120, 150, 180, 210, 240, 270, 300, 330)]
    row = asked({"walls": joined(*walls)}, BLADE, angles=angles)
    assert 89.99 < row.swing_deg <= 90.0
    assert abs(row.angle_deg - first) < 0.01
    assert row.is_reachable and np.allclose(row.pose, TOP @ at(degrees=row.angle_deg + 0.5 * row.swing_deg))
    assert not asked({"walls": joined(*walls)}, BLADE, angles=angles, swing_deg=90.1).is_reachable


def test_a_swing_goes_over_the_first_angle() -> None:
    walls = [sheet(turn, 0.05, 0.12) for turn in (40, 60, 90, 120, 150, 180, 210, 240, 270, 300, 320)]
    row = asked({"walls": joined(*walls)}, BLADE)
    assert 79.99 < row.swing_deg <= 80.0 and abs(row.angle_deg - 320.0) < 0.01


def test_one_wall_leaves_all_but_itself() -> None:
    row = asked({"wall": sheet(12.5, 0.05, 0.12)}, BLADE)
    assert 359.9 < row.swing_deg < 360.0 and abs(row.angle_deg - 12.5) < 0.01


def test_it_turns_about_the_axis_between_the_angles() -> None:
    """A post that only the arc of the tool's tip meets, and not the chord."""
    tool = feeler.Tool(*box((0.02, -0.001, 0.0), (0.1, 0.001, 0.004)), "bar")
    middle = 0.099 * np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    post = box((*(middle - 0.0005), -0.01), (*(middle + 0.0005), 0.02))
    row = asked({"post": post}, tool, angles=4)
    assert row.swing_deg < 360.0 and row.blockers[0].path == "post"
    assert abs(row.angle_deg - 45.0) < 2.0


def test_each_swing_is_free_and_hardly_larger_ones_are() -> None:
    """Held to seats every tenth of a degree: random posts around a bolt, and a crooked spanner."""
    rng = np.random.default_rng(5)
    tool = tool_of(
        {
            "jaw": box((0.012, -0.006, -0.004), (0.03, 0.006, 0.004)),
            "handle": box((0.03, 0.0, 0.0), (0.15, 0.008, 0.006)),
            "knob": box((0.14, 0.0, 0.006), (0.16, 0.02, 0.03)),
        }
    )
    partly = 0
    for _ in range(12):
        posts = {}
        for i in range(int(rng.integers(2, 6))):
            radius, turn = rng.uniform(0.03, 0.16), rng.uniform(0, 2 * np.pi)
            middle = radius * np.array([np.cos(turn), np.sin(turn)])
            half = rng.uniform(0.001, 0.02)
            posts[f"post {i}"] = box((*(middle - half), -0.02), (*(middle + half), rng.uniform(-0.002, 0.05)))
        mockup = mockup_of({"bolt": bolt(), **posts})
        scene = feeler.Scene(mockup)
        (row,) = feeler.access(scene, tool, TOP, threads=1, angles=int(rng.integers(5, 40)))
        dense = np.arange(3600) / 10.0
        ignore = feeler.IgnoredPairs(tool, mockup, [("*", "bolt")])
        free = np.array([not scene.is_colliding(tool, TOP @ at(degrees=a), ignore=ignore) for a in dense])
        inside = ((dense - row.angle_deg) % 360.0 < row.swing_deg) if row.swing_deg else np.zeros(len(dense), bool)
        assert free[inside].all()
        if free.all() or not free.any():
            continue
        runs = np.diff(np.flatnonzero(~np.concatenate([free, free, free[:1] & False]))) - 1
        partly += 1
        assert abs(row.swing_deg - runs.max(initial=0) / 10.0) <= 0.2
    assert partly >= 6


def jaw() -> Mesh:
    """An open jaw about an M8 head, its handle along x."""
    return joined(
        box((-0.012, 0.007, -0.004), (0.012, 0.012, -0.001)),
        box((-0.012, -0.012, -0.004), (0.012, -0.007, -0.001)),
        box((0.012, -0.012, -0.004), (0.1, 0.012, -0.001)),
    )


def test_under_a_roof_a_jaw_comes_in_sideways_and_a_ring_does_not() -> None:
    roof = {"roof": box((-0.5, -0.5, 0.006), (0.5, 0.5, 0.01))}
    row = asked(roof, feeler.Tool(*jaw(), "open"))
    assert row.is_reachable and row.swing_deg == 360.0
    out = row.way[1][:3, :3].T @ (row.way[0] - row.way[1])[:3, 3]
    assert np.allclose(out, [0.1, 0, 0])
    vertices, faces = jaw()
    aslant = asked(roof, feeler.Tool(vertices @ at(degrees=100.0)[:3, :3].T, faces, "open"))
    out = aslant.way[1][:3, :3].T @ (aslant.way[0] - aslant.way[1])[:3, 3]
    assert aslant.is_reachable and np.allclose(out, 0.1 * at(degrees=100.0)[:3, 0])
    ring = joined(jaw(), box((-0.02, -0.012, -0.004), (-0.012, 0.012, -0.001)))
    row = asked(roof, feeler.Tool(*ring, "ring"))
    assert not row.is_reachable and row.swing_deg == 360.0 and not len(row.way)
    assert row.because == (
        "a swing of 360.0 degrees is free, but no way in was found within 100 mm: it comes out 4.38 mm at most"
    )
    assert row.blockers[0].path == "roof"
    assert asked({}, feeler.Tool(*ring, "ring")).is_reachable


def test_a_jaw_without_play_slides_off() -> None:
    """A square head, of binary fractions: what is flush is flush to the last bit."""
    head = box((-0.0078125, -0.0078125, -0.0078125), (0.0078125, 0.0078125, 0.0))
    sides = [
        box((-0.0078125, y, -0.00390625), (0.0078125, y + 0.0078125, -0.001953125)) for y in (0.0078125, -0.015625)
    ]
    back = box((0.0078125, -0.015625, -0.00390625), (0.125, 0.015625, -0.001953125))
    roof = box((-0.5, -0.5, 0.0078125), (0.5, 0.5, 0.015625))
    scene = feeler.Scene(mockup_of({"head": head, "roof": roof}))
    (row,) = feeler.access(scene, feeler.Tool(*joined(*sides, back), "jaw"), np.eye(4), angles=4)
    assert row.is_reachable and np.allclose((row.way[0] - row.way[1])[2, 3], 0.0)


def test_what_is_wholly_inside_something_is_no_way() -> None:
    """A block without a hollow: nothing is met in it."""
    row = asked({"block": box((-1, -1, -1), (1, 1, 1))}, bar())
    assert row.swing_deg == 360.0 and not row.is_reachable and not len(row.way)
    assert [each.path for each in row.blockers] == ["block"]
    # Out of the block its surface is met.
    assert asked({"block": box((-1, -1, -1), (1, 1, 1))}, bar(), approach=1.5).blockers[0].path == "block"


def test_ways_are_those_of_the_tool_as_given() -> None:
    """A tool modelled elsewhere, brought to its seat by its grip."""
    place = at(0.3, -0.2, 0.7, degrees=90.0, axis=0)  # seat_from_tool
    seated = bar()
    moved = seated.vertices @ np.linalg.inv(place)[:3, :3].T + np.linalg.inv(place)[:3, 3]
    tool = feeler.Tool(moved, seated.faces, "bar")
    wall = {"wall": box((0.05, 0.03, -0.1), (0.06, 0.2, 0.1)), "plate": PLATE}
    plain, gripped = asked(wall, seated), asked(wall, tool, grip=np.linalg.inv(place))
    assert 0 < plain.swing_deg < 360.0 and abs(plain.swing_deg - gripped.swing_deg) < 0.01
    for one, other in ((plain.pose, gripped.pose), *zip(plain.way, gripped.way, strict=True)):
        assert np.allclose(one, other @ np.linalg.inv(place), atol=1e-4)


@pytest.mark.parametrize(("grip", "direction"), [("x", 0), ("y", 1), ("z", 2), ("-x", 0), ("-y", 1), ("-z", 2)])
def test_a_grip_by_name_puts_that_axis_out_of_the_joint(grip: str, direction: int) -> None:
    seated = seated_tool(bar(), None, grip)
    turn = seated.seat_from_tool[:3, :3]
    assert np.allclose(turn @ np.eye(3)[direction] * (-1 if grip[0] == "-" else 1), [0, 0, 1])
    assert np.isclose(np.linalg.det(turn), 1.0)


def test_the_sample_wrench_turns_about_its_jaw() -> None:
    scene = feeler.Scene(mockup_of({"bolt": bolt(), "plate": PLATE}))
    (row,) = feeler.access(scene, feeler.sample_tool("wrench"), TOP, grip="y")
    assert row.is_reachable and row.swing_deg == 360.0
    assert np.allclose(row.pose[:3, 3], TOP[:3, 3])
    (stuck,) = feeler.access(scene, feeler.sample_tool("wrench"), TOP, grip="y", lift=-0.004)
    assert not stuck.is_reachable and stuck.blockers[0].path == "plate"


@pytest.mark.parametrize("seed", range(12))
def test_the_swing_in_a_sector_is_its_closed_form(seed: int) -> None:
    """A bar between two walls at random angles, in a random frame; sheets close the rest of the circle."""
    rng = np.random.default_rng(seed)
    half, near = rng.uniform(1e-4, 4e-3), rng.uniform(0.0205, 0.05)
    play = 4.4354 if seed == 0 else 10 ** rng.uniform(-1.5, 2.3)
    lean = float(np.degrees(np.arcsin(half / near)))  # where the bar's side meets the near edge of a wall
    first, opening = rng.uniform(0.0, 360.0), play + 2.0 * lean
    count = int((360.0 - opening) / min(0.9 * lean, 3.0)) + 2
    walls = [sheet(turn, near, 0.12, -0.02, 0.02) for turn in np.linspace(first + opening, first + 360.0, count)]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    frame = at(*rng.uniform(-3.0, 3.0, 3))
    frame[:3, :3] = turn * np.sign(np.linalg.det(turn))
    vertices, faces = joined(*walls)
    scene = feeler.Scene(mockup_of({"walls": (vertices @ frame[:3, :3].T + frame[:3, 3], faces)}))
    tool = feeler.Tool(*box((0.6 * near, -half, -0.005), (0.1, half, 0.005)), "bar")
    (row,) = feeler.access(scene, tool, frame, swing_deg=60.0, angles=int(rng.integers(4, 100)), threads=1)
    assert play - 1e-3 < row.swing_deg <= play
    assert abs((row.angle_deg - first - lean + 180.0) % 360.0 - 180.0) < 1e-3
    assert row.is_reachable == (play >= 60.0) and len(row.way)


def test_two_triangles_meet_over_the_angles_of_the_closed_form() -> None:
    """Random pairs, some of them level and flush: just inside the ends they meet, just outside they do not."""
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 1500, 3, 3))
    a[::4, :, 2] = b[::4, :, 2] = 0.0
    low, high = blocked_turns(a, b)
    checked = 0
    for one, other, first, last in zip(a, b, low, high, strict=True):
        scene = feeler.Scene(mockup_of({"b": (other, np.array([[0, 1, 2]]))}), threads=1)
        tool = feeler.Tool(one, [[0, 1, 2]])

        def meets(turn: float, scene: feeler.Scene = scene, tool: feeler.Tool = tool) -> bool:
            return scene.is_colliding(tool, at(degrees=float(np.degrees(turn))))

        assert meets(0.0) == (first < 0.0 < last)
        if first < 0.0:
            assert meets(first + 1e-9) and meets(last - 1e-9) and meets(rng.uniform(first, last))
        for end, way in ((first, -1e-9), (last, 1e-9)):
            if first < 0.0 and abs(end) < np.pi - 1e-6:  # half a turn either way is the most that is told
                checked += 1
                assert not meets(end + way)
    assert checked > 200


def test_a_slot_above_the_seat_is_found_at_any_angle() -> None:
    """Below the roof the blade turns freely; it comes in only where the slot is."""
    for turn in (0.0, 17.3, 101.9, 261.4):
        half = 0.0006
        sides = [box((-0.2, half, 0.03), (0.2, 0.3, 0.04)), box((-0.2, -0.3, 0.03), (0.2, -half, 0.04))]
        vertices, faces = joined(*sides)
        row = asked({"roof": (vertices @ at(degrees=turn)[:3, :3].T, faces)}, BLADE, approach=0.08)
        assert row.is_reachable and row.swing_deg == 360.0 and row.drawn == row.looked == 0.08
        assert np.allclose(row.way[0] - row.way[1], at(z=0.08) - np.eye(4))


def test_it_says_how_far_it_looked_for_a_way_in() -> None:
    roof = {"lid": box((-0.5, -0.5, 0.06), (0.5, 0.5, 0.07)), "wall": PLATE}
    ring = feeler.Tool(*joined(jaw(), box((-0.02, -0.012, -0.004), (-0.012, 0.012, -0.001))), "ring")
    short, far = asked(roof, ring, approach=0.04), asked(roof, ring, approach=0.1)
    assert short.is_reachable and short.looked == short.drawn == 0.04
    assert not far.is_reachable and far.looked == 0.1
    assert far.drawn == pytest.approx(0.06 + 0.001 - HEAD_TOP, abs=2e-6)
    assert far.because.endswith("no way in was found within 100 mm: it comes out 55.6 mm at most")
    blocked = asked({"lid": box((-0.5, -0.5, -0.01), (0.5, 0.5, 0.01))}, bar(end=1.0))
    assert blocked.looked == 0.1 and blocked.drawn == 0.0


def test_a_hand_goes_along() -> None:
    post = {"post": box((0.2, -0.01, 0.03), (0.22, 0.01, 0.06)), "plate": PLATE}
    hand = feeler.Tool(*box((0.15, -0.03, 0.0), (0.25, 0.03, 0.06)), "hand")
    assert asked(post, bar()).swing_deg == 360.0
    alone = asked(post, bar(), hand=hand)
    assert 0.0 < alone.swing_deg < 360.0 and alone.blockers[0].path == "post"
    assert asked(post, bar(), hand=(hand, at(z=-0.05))).swing_deg == 0.0  # through the plate
    higher = asked(post, bar(), hand=(hand, at(z=0.1)))
    assert higher.swing_deg == 360.0


def test_frames_and_fasteners_say_the_same() -> None:
    mockup = mockup_of({"bolt": bolt(), "other bolt": bolt(0.05), "plate": PLATE})
    scene = feeler.Scene(mockup)
    found = feeler.find_fasteners(mockup)
    assert len(found) == 2
    by_fastener = feeler.access(scene, bar(), found)
    by_frame = feeler.access(scene, bar(), found.frames)
    assert [row.part for row in by_frame] == [row.part for row in by_fastener] == [0, 1]
    assert np.allclose(by_frame.swings_deg, by_fastener.swings_deg, atol=1e-6) and (by_frame.swings_deg < 360.0).all()
    (row,) = feeler.access(scene, bar(), at(x=0.3, z=0.3))
    assert row.part is None and row.path is None and row.is_reachable


def test_parts_that_are_out_are_not_in_the_way() -> None:
    mockup = mockup_of({"bolt": bolt(), "wall": box((0.05, -0.2, -0.1), (0.06, 0.2, 0.1))})
    scene = feeler.Scene(mockup)
    stopped = feeler.access(scene, bar(), TOP)
    assert stopped.is_reachable.all() and stopped[0].swing_deg < 360.0
    assert stopped[0].blockers and stopped.blockers == (), "nothing is in the way of what is reachable"
    assert feeler.access(scene.without("wall"), bar(), TOP)[0].swing_deg == 360.0
    assert feeler.access(scene.without("bolt"), bar(), feeler.find_fasteners(mockup))[0].part == 0


def test_tools_reach_what_the_truth_of_the_gearbox_says(gearbox: Any, faulty_gearbox: Any) -> None:
    """Each socket and hexagon key turns in full once that is out which the truth takes out before; but for the bolt
    under the guard that was planted."""

    def stuck(of: Any, pattern: str, every: int) -> dict[str, list[str]]:
        wanted = {f.path: f for f in of.truth.fasteners if f.tool != "open-end wrench"}
        rows = [row for row in feeler.find_fasteners(of.mockup, pattern) if row.path in wanted][::every]
        assert len(rows) > 3
        left = {}
        for row in rows:
            fastener = wanted[row.path]
            width = (0.6 if fastener.tool == "hex key" else 0.7) * fastener.size_m + 5e-4
            half = width / np.sqrt(2.0)  # the corners of the bar are where a socket's wall is
            out = of.out(of.step(row.path))
            if fastener.kind == "nut":  # a socket is hollow: what the nut is on goes into it
                threads = [fit for fit in of.truth.fits if "thread" in fit.kind and row.path in (fit.a, fit.b)]
                out += [path for fit in threads for path in (fit.a, fit.b) if path != row.path]
            tool = feeler.Tool(*box((-half, -half, 2e-4), (half, half, 0.055)), fastener.tool)
            (reach,) = feeler.access(of.scene.without(out), tool, feeler.Fasteners([row]), 360.0, 12)
            if not reach.is_reachable:
                left[row.path] = [each.path for each in reach.blockers]
        return left

    assert stuck(gearbox, "*", 2) == {}
    bolt, *guards = faulty_gearbox.fault["blocked_bolt"].parts
    found = stuck(faulty_gearbox, "gearbox/covers/idler_front", 1)
    assert list(found) == [bolt] and set(found[bolt]) <= set(guards) and found[bolt]


@pytest.fixture
def bolts(gearbox: Any) -> tuple[feeler.Scene, feeler.Fasteners]:
    return gearbox.scene, feeler.find_fasteners(gearbox.mockup)[::6]


def key(row: feeler.Reach) -> tuple[Any, ...]:
    arrays = (row.pose.tobytes(), row.way.tobytes(), np.float64(row.angle_deg).tobytes())
    return (row.target, row.part, row.path, row.is_reachable, row.swing_deg, row.because, row.blockers, *arrays)


def test_any_threads_one_answer_in_order(bolts: tuple[feeler.Scene, feeler.Fasteners]) -> None:
    scene, targets = bolts
    told: list[float] = []
    one = feeler.access(scene, feeler.sample_tool("torque"), targets, threads=1, progress=lambda f, _: told.append(f))
    assert told == [(i + 1) / len(targets) for i in range(len(targets))]
    for threads in (2, 5, None):
        other = feeler.access(scene, feeler.sample_tool("torque"), targets, threads=threads)
        assert [key(row) for row in other] == [key(row) for row in one]
    assert 0 < one.is_reachable.sum() < len(one)
    assert one.swings_deg.shape == one.angles_deg.shape == (len(targets),)
    assert repr(one) == f"Access({one.is_reachable.sum()} of {len(targets)} reachable)"
    worst = one.blockers
    assert [each.count for each in worst] == sorted((each.count for each in worst), reverse=True)
    assert one[1:3] == list(one)[1:3]


@pytest.mark.parametrize("threads", [1, 3])
def test_what_was_found_until_ctrl_c_is_kept(threads: int, bolts: tuple[feeler.Scene, feeler.Fasteners]) -> None:
    scene, targets = bolts

    def stop(fraction: float, stage: str) -> None:
        assert stage == "reaching targets"
        if fraction > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(AccessInterrupted) as stopped:
        feeler.access(scene, feeler.sample_tool("torque"), targets, threads=threads, progress=stop)
    found = stopped.value.access
    assert found.is_partial and 0 < len(found) < len(targets)
    numbers = [row.target for row in found]
    assert numbers == sorted(set(numbers)) and set(numbers) < set(range(len(targets)))
    assert "interrupted" in repr(found)


SCENE = feeler.Scene(mockup_of({"bolt": bolt(), "plate": PLATE}))
FRAME = np.eye(4)[None]
SKEW = np.diag([1.0, 1.0, 1.001, 1.0])


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda: feeler.access(SCENE, bar(), []), OptionError, "there are no targets"),
        (lambda: feeler.access(SCENE, bar(), np.empty((0, 4, 4))), OptionError, "there are no targets"),
        (lambda: feeler.access(SCENE, bar(), feeler.Fasteners([])), OptionError, "there are no targets"),
        (lambda: feeler.access(SCENE, bar(), "bolts"), PoseError, "targets is 'bolts': give feeler.find_fasteners"),
        (lambda: feeler.access(SCENE, bar(), np.eye(3)), PoseError, r"shape \(3, 3\)"),
        (lambda: feeler.access(SCENE, bar(), [np.eye(4), SKEW]), PoseError, "target 1 is not a rigid"),
        (lambda: feeler.access(SCENE, bar(), FRAME * np.nan), PoseError, "target 0 is not a rigid"),
        (lambda: feeler.access(SCENE, bar(), FRAME, swing_deg=0), OptionError, "swing_deg is 0"),
        (lambda: feeler.access(SCENE, bar(), FRAME, swing_deg=361), OptionError, "swing_deg is 361"),
        (lambda: feeler.access(SCENE, bar(), FRAME, swing_deg="far"), OptionError, "swing_deg is 'far'"),
        (lambda: feeler.access(SCENE, bar(), FRAME, angles=3), OptionError, "angles is 3"),
        (lambda: feeler.access(SCENE, bar(), FRAME, angles=72.5), OptionError, "angles is 72.5"),
        (lambda: feeler.access(SCENE, bar(), FRAME, angles=10**6), OptionError, "angles is 1000000"),
        (lambda: feeler.access(SCENE, bar(), FRAME, approach=-0.1), OptionError, "approach is -0.1"),
        (lambda: feeler.access(SCENE, bar(), FRAME, approach=np.inf), OptionError, "approach is inf"),
        (lambda: feeler.access(SCENE, bar(), FRAME, approach=np.nan), OptionError, "approach is nan"),
        (lambda: feeler.access(SCENE, bar(), FRAME, grip="up"), OptionError, "grip is 'up'"),
        (lambda: feeler.access(SCENE, bar(), FRAME, grip=SKEW), PoseError, "the grip is not a rigid"),
        (lambda: feeler.access(SCENE, bar(), FRAME, grip=["a"]), PoseError, r"grip is \['a'\]: give real numbers"),
        (lambda: feeler.access(SCENE, bar(), FRAME, lift=[1, 2]), OptionError, "one for each of 1 targets"),
        (lambda: feeler.access(SCENE, bar(), FRAME, lift=np.nan), OptionError, "lift is nan"),
        (lambda: feeler.access(SCENE, bar(), FRAME, lift="up"), OptionError, "lift is 'up'"),
        (lambda: feeler.access(SCENE, bar(), FRAME, threads=0), OptionError, "threads is 0"),
        (lambda: feeler.access(SCENE, bar(), FRAME, progress=3), OptionError, "progress is 3"),
        (lambda: feeler.access(SCENE, None, FRAME), MeshError, "the tool is NoneType"),
        (lambda: feeler.access(SCENE.mockup, bar(), FRAME), MeshError, "needs a feeler.Scene"),
        (lambda: feeler.access(SCENE, bar(), FRAME, hand=3), MeshError, "hand is a feeler.Tool"),
        (lambda: feeler.access(SCENE, bar(), FRAME, hand=(bar(), SKEW)), PoseError, "'hand' is not a rigid"),
    ],
)
def test_bad_input(ask: Callable[[], object], error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        ask()


def test_fasteners_of_another_mockup() -> None:
    found = feeler.find_fasteners(mockup_of({"elsewhere": bolt()}))
    with pytest.raises(OptionError, match="'elsewhere' is of another mock-up"):
        feeler.access(SCENE, bar(), found)


def test_ways_of_a_thousand_kilometres_are_refused(bolts: tuple[feeler.Scene, feeler.Fasteners]) -> None:
    scene, targets = bolts
    for wrong in ({"approach": 1e6}, {"approach": 1e12}, {"lift": -1e6}, {"lift": [1e12] * len(targets)}):
        with pytest.raises(feeler.OptionError, match=f"{next(iter(wrong))} is .*1,000"):
            feeler.access(scene, feeler.sample_tool("torque"), targets, **wrong)  # type: ignore[arg-type]
