"""The sample gearbox: every fit has a name, every way is free, every fault is there; judged by other libraries."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler
from feeler.samples import FAULTS, KEEPS
from feeler.samples.accessory import polygon
from feeler.samples.accessory.polygon import triangulated
from feeler.samples.accessory.solid import Cut, Solid
from feeler.samples.accessory.swings import widest_swing
from feeler.tasks.rings import ring_of, slippings

judge = pytest.importorskip("gearbox_judge", exc_type=ImportError)  # it needs coal and manifold3d
from mesh_contacts import self_contacts  # noqa: E402

LEAST, FINE = 40_000, 250_000
PRESS_M = -5e-6


@lru_cache(maxsize=3)
def drawn(triangles: int = LEAST, seed: int = 0) -> Any:
    return judge.of_sample(triangles, seed)


@lru_cache(maxsize=1)
def fine() -> Any:
    return feeler.sample_truth("gearbox", FINE)


def test_the_chord_shrinks_with_the_triangles() -> None:
    chords = [drawn().truth.chord_m, feeler.sample_truth("gearbox", 80_000).chord_m, fine().chord_m]
    assert chords == sorted(chords, reverse=True)
    assert chords[-1] < 1.1e-4 < 1e-3 < chords[0]


def test_a_press_shares_volume() -> None:
    """Unless its facets are larger than it."""
    shared = {frozenset(pair) for pair in judge.shared_volumes(drawn(100_000, 5))}
    pressed = {frozenset((fit.a, fit.b)) for fit in drawn(100_000, 5).truth.fits if fit.play_m < PRESS_M}
    assert pressed <= shared and len(pressed) > 100


@pytest.mark.parametrize(("triangles", "seed"), [(100_000, 5), (LEAST, 0)])
def test_only_named_fits_share_volume_and_none_is_deeper_than_named(triangles: int, seed: int) -> None:
    assert not judge.too_deep(drawn(triangles, seed), every=9)


def test_no_part_comes_near_itself() -> None:
    """Some shapes at coarse and fine chords; by distances of all their triangles."""
    assert not judge.touching(LEAST, 2)
    assert not judge.touching(100_000, 3, ["flanged", "circlip", "spur_gear", "threaded_plug"])


def test_the_judge_of_contacts_sees_what_touches() -> None:
    """Two boxes that share a volume, that are flush, and that are 2 um apart."""
    box = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([face for a, b, c, d in sides for face in ([a, b, c], [a, c, d])])
    for offset, touches in ((0.5, True), (1.0, True), (1.0 + 2e-6, False)):
        points = np.concatenate([box, box * 0.5 + [offset, 0.2, 0.2]])
        assert bool(self_contacts(points, np.concatenate([faces, faces + 8]), 1e-6)) == touches


def test_all_others_keep_a_gap() -> None:
    """By coal; the least is between a ball and its cage."""
    least = judge.gaps(drawn(), 5e-4)
    assert len(least) > 300
    assert min(least.values()) > 2e-4


@pytest.mark.parametrize("seed", [0, 19116, 466068])
def test_pipes_and_hoses_keep_5_mm(seed: int) -> None:
    """Of two of these seeds, the hose would pass a nut of the pressure pipe by 2.3 mm at its usual height."""
    gearbox = drawn(70_000, seed)
    lines = [path for path in gearbox.meshes if path.rpartition("/")[2] in ("pipe", "hose")]
    assert len(lines) > 2 and not [
        found for found in judge.gaps(gearbox, 0.006, lines).items() if found[1] < 0.005 - 2e-6
    ]


def test_plays_and_presses_are_drawn_as_named() -> None:
    """A pair of each kind and play, at a chord that is less than the plays."""
    fits = judge.Fits()
    assert len({fit.kind for fit in fits.truth.fits if fit.play_m}) > 12
    assert not fits.wrong(1)


def test_the_judge_of_plays_sees_what_is_not_drawn() -> None:
    fits = judge.Fits()
    kinds = {"spline": -20e-6, "gear mesh": 20e-6, "H7/g6": -5e-6, "H7/p6": -8e-6, "clearance": 50e-6}
    named = sorted((fit for fit in fits.truth.fits if fit.kind in kinds), key=fits.size, reverse=True)
    wrong = {}
    for fit in named:
        off = kinds[fit.kind]
        wrong[fit.kind] = dataclasses.replace(fit, play_m=fit.play_m + off, deepest_m=max(0.0, fit.deepest_m - off))
    fits.truth = dataclasses.replace(fits.truth, fits=tuple(wrong.values()))
    assert len(fits.wrong()) == len(kinds)


def test_fits_do_not_depend_on_the_triangles() -> None:
    """One entry a pair, of the same kind and play."""
    named = []
    for chord in (1.6, 0.13, 0.005):  # about 40,000, 200,000 and 1,300,000 triangles
        fits = judge.Fits(0, chord).truth.fits
        assert len({frozenset((fit.a, fit.b)) for fit in fits}) == len(fits)
        named.append([(fit.a, fit.b, fit.kind, fit.play_m, fit.flush) for fit in fits])
    assert named[0] == named[1] == named[2]
    gear = judge.Fits(0, 1.6).truth.fit(
        "gearbox/gear_train/idler_shaft/spur_gear", "gearbox/gear_train/idler_shaft/shaft"
    )
    assert gear.kind == "H7/g6" and gear.flush


def test_plays_are_those_of_the_standard() -> None:
    """ISO 286: 20 H7 is 0 to +21 um, 20 g6 is -7 to -20 um: 24 um between the middles, half of it on each side."""
    fit = drawn().truth.fit("gearbox/gear_train/idler_shaft/spur_gear", "gearbox/gear_train/idler_shaft/shaft")
    assert fit is not None and fit.kind == "H7/g6"
    assert fit.play_m == pytest.approx(12e-6, abs=0.3e-6)
    assert drawn().truth.fit("gearbox/bracket/beam", "gearbox/housing/front_case") is None


@lru_cache(maxsize=1)
def ways() -> Any:
    return judge.Ways(judge.faultless(0))


def test_ways_are_free_with_only_what_they_need_taken_out() -> None:
    steps = ways().truth.steps
    assert all(step.legs for step in steps)
    large = [step for step in steps if len(step.parts) > 3 or step.door_open]
    rings = [step for step in steps if not step.rigid]
    for step in {id(step): step for step in [*steps[::15], *large[::3], *rings]}.values():
        assert not ways().blocked(step), step.parts[0]


def test_steps_wait_only_for_what_is_in_the_way() -> None:
    steps = [s for s in ways().truth.steps if s.removes and s.after]
    assert len(steps) > 200
    large = ("cover", "shaft", "gasket", "body", "case", "head", "panel", "pipe", "split_bolts/bolt_7")
    for step in [s for s in steps if s.parts[0].endswith(large)] + steps[::12]:
        assert not ways().superfluous(step), step.parts[0]


def test_the_judge_of_needs_sees_what_is_not_in_the_way() -> None:
    drive = ways().truth.way("gearbox/starter/drive_shaft")[-1]
    more = dataclasses.replace(drive, after=(*drive.after, "gearbox/starter/gasket"))
    assert ways().superfluous(more) == ["gearbox/starter/gasket"]


def test_the_judge_of_ways_sees_what_is_in_the_way() -> None:
    """The bowl without its turn, without the door open, and a case that is still bolted."""
    truth = ways().truth
    bowl = truth.way("gearbox/oil_filter/bowl")[-1]
    assert [leg.kind for leg in bowl.legs] == ["turn", "pull"]
    pulled = dataclasses.replace(bowl, legs=bowl.legs[1:])
    assert ("gearbox/oil_filter/bowl", "gearbox/oil_filter/head") in ways().blocked(pulled)
    closed = dataclasses.replace(bowl, door_open=False)
    assert ("gearbox/oil_filter/bowl", "gearbox/door/panel") in ways().blocked(closed)
    case = truth.way("gearbox/housing/front_case")[-1]
    for ring in [step for step in truth.steps if not step.rigid]:
        assert ways().blocked(dataclasses.replace(ring, spread_m=ring.spread_m - 2.5e-4)), "it does not pass its shaft"
    found = ways().blocked(dataclasses.replace(case, after=()))
    assert any(other.startswith("gearbox/housing/split_bolts/") for _, other in found)


def test_circlips_are_spread_as_the_planner_opens_them() -> None:
    """`feeler.task` opens the ring of the mesh until it passes: that much, less the play."""
    truth, mockup = drawn().truth, feeler.sample("gearbox", LEAST)
    rings = [step for step in truth.steps if not step.rigid]
    assert len(rings) == 5 and all(step.spread_m == 0.0 for step in truth.steps if step.rigid)
    for step in rings[1:3]:
        ring = ring_of(*dataclasses.astuple(drawn().meshes[step.parts[0]])[:2])
        shaft = feeler.Scene(mockup).only([step.parts[0].replace("circlip", "shaft")])
        way = next(way for way in slippings(ring, shaft) if np.dot(way.direction, step.legs[0].axis) > 0.9)
        assert way.opening < step.spread_m < way.opening + 2e-4
        off = np.array(step.spread_about_m) - ring.middle
        assert np.abs(off - (off @ ring.axis) * ring.axis).max() < 1e-4


@pytest.mark.parametrize("faults", [(), tuple(FAULTS)])
def test_every_part_comes_out_once_or_stays_for_a_reason(faults: tuple[str, ...]) -> None:
    truth = judge.of_sample(LEAST, 0, faults).truth if faults else drawn().truth
    stays = {stay.path for stay in truth.stays}
    assert stays == {"gearbox/bracket/beam", *(("gearbox/bracket/lost_ball",) if faults else ())}
    removed = [path for step in truth.steps if step.removes for path in step.parts]
    assert sorted(removed) == sorted({body.path for body in truth.bodies} - stays)
    assert all(stay.because for stay in truth.stays)
    out: set[str] = set()
    for step in truth.steps:  # the whole order is right, too
        assert set(step.after) <= out
        out |= set(step.parts)


def test_a_way_has_what_it_needs_and_no_more() -> None:
    truth = drawn().truth
    way = [step.parts[0] for step in truth.way("gearbox/gear_train/idler_shaft/spur_gear")]
    assert way[-1] == "gearbox/gear_train/idler_shaft/spur_gear"
    assert "gearbox/gear_train/idler_shaft/circlip" in way and "gearbox/housing/front_case" in way
    assert "gearbox/oil_filter/bowl" not in way and "gearbox/starter/body" not in way
    assert truth.way("gearbox/bracket/beam") == ()
    assert "gearbox/starter/gasket" not in [s.parts[0] for s in truth.way("gearbox/starter/drive_shaft")]
    assert [s.parts[0] for s in truth.way("gearbox/starter/terminal_nut")] == ["gearbox/starter/terminal_nut"]


def test_what_comes_out_as_one_unit() -> None:
    """A bearing whole; a dowel with the half that it is pressed into; a union nut with its pipe."""
    truth = drawn().truth
    bearing = "gearbox/gear_train/idler_shaft/front_bearing/"
    for path, unit in (
        (bearing + "ball_3", {bearing + "inner_ring", bearing + "outer_ring", bearing + "cage", bearing + "ball_1"}),
        ("gearbox/housing/dowel_1", {"gearbox/housing/front_case"}),
        ("gearbox/lines/pressure_pipe/union_nut_1", {"gearbox/lines/pressure_pipe/pipe"}),
    ):
        last = truth.way(path)[-1]
        assert last.removes and {path, *unit} <= set(last.parts)
        assert truth.way(path) == truth.way(min(unit))


@pytest.mark.parametrize("faults", [(), tuple(FAULTS)])
def test_something_holds_each_part(faults: tuple[str, ...]) -> None:
    """But the beam, and what faults leave in the air or in the beam; all of the holders touch or fit what they hold."""
    truth = judge.of_sample(LEAST, 0, faults).truth if faults else drawn().truth
    free = {body.path.removeprefix("gearbox/") for body in truth.bodies if not truth.holds(body.path)}
    assert free == {"bracket/beam", *(("bracket/lost_ball", "bracket/lost_washer") if faults else ())}
    assert {keeper.kind for keeper in truth.keepers} | {"welded"} == set(KEEPS)
    fits = {frozenset((fit.a, fit.b)) for fit in truth.fits}
    broken = {path for fault in truth.faults for path in fault.parts}
    loose = ("bearing", "stop", "latch")  # a cage runs free, and stops are met at the end
    for keeper in truth.keepers:
        for held in keeper.holds if "input_drive/circlip" not in keeper.path else keeper.holds[:1]:  # then one behind
            touches = frozenset((keeper.path, held)) in fits or {keeper.path, held} & broken
            assert touches or keeper.kind in loose, (keeper, held)


def test_what_holds_what() -> None:
    truth = drawn().truth
    for path, holder, kind in (
        ("gear_train/idler_shaft/spur_gear", "gear_train/idler_shaft/circlip", "circlip"),
        ("gear_train/idler_shaft/spur_gear", "gear_train/idler_shaft/key", "key"),
        ("housing/front_case", "housing/dowel_1", "dowel"),
        ("lines/oil_pipe/pipe", "lines/oil_pipe/clip", "clip"),
        ("lines/oil_pipe/adapter_2", "lines/oil_pipe/elbow_clamp", "clamp"),
        ("oil_filter/bowl", "oil_filter/head", "bayonet"),
        ("door/panel", "door/latch", "latch"),
        ("door/door_leaf_1", "door/pin_1", "hinge"),
    ):
        assert f"gearbox/{holder}" in truth.holds(f"gearbox/{path}")
        (keeper,) = [k for k in truth.keepers if k.path == f"gearbox/{holder}" and k.kind == kind]
        assert f"gearbox/{path}" in keeper.holds


def test_fasteners_hold_and_have_tools() -> None:
    truth = drawn().truth
    assert len(truth.fasteners) > 100
    assert {fastener.tool for fastener in truth.fasteners} == {"socket", "hex key", "open-end wrench"}
    holders = truth.holds("gearbox/covers/main_front/cover")
    assert len(holders) == 6 and all("/covers/main_front/bolt_" in path for path in holders)
    paths = {body.path for body in truth.bodies}
    for fastener in truth.fasteners:
        assert {fastener.path, *fastener.holds} <= paths
        mesh = drawn().meshes[fastener.path]
        height = (mesh.vertices - fastener.top_m) @ fastener.axis
        assert height.max() < (0.03 if "sensor" in fastener.path else 1e-5)  # nothing of it is above its top


def test_each_fastener_holds_something() -> None:
    """A sensor holds itself by its thread, an elbow is held by the screw of its clamp, a pipe by that of its clip."""
    truth = drawn().truth
    assert all(fastener.holds for fastener in truth.fasteners)
    for path, holder in (
        ("harness/main_sensor", "harness/main_sensor"),
        ("lines/pressure_pipe/adapter_2", "lines/pressure_pipe/clamp_screw"),
        ("lines/oil_pipe/pipe", "lines/oil_pipe/clip_bolt"),
    ):
        assert f"gearbox/{holder}" in truth.holds(f"gearbox/{path}")


def test_fittings_are_bored() -> None:
    """The bore of a pipe goes on through the fittings at both ends: one hole runs through each."""
    meshes = drawn(100_000, 5).meshes
    for name in ("adapter_1", "adapter_2", "pipe"):
        assert judge.manifold(meshes[f"gearbox/lines/pressure_pipe/{name}"]).genus() == 1


def test_tools_reach_the_fasteners() -> None:
    """Sockets and keys turn in full, wrenches as far as the truth says; but for the bolt that a fault covers."""
    judged = ways()
    driven = [fastener for fastener in judged.truth.fasteners if fastener.tool != "open-end wrench"]
    assert all(fastener.swing_rad == 2.0 * np.pi for fastener in driven)
    for fastener in driven[::3]:
        assert not judged.in_the_way(fastener), fastener.path
    turned = [fastener for fastener in judged.truth.fasteners if fastener.tool == "open-end wrench"]
    assert len(turned) == 9 and min(fastener.swing_rad for fastener in turned) > np.deg2rad(60.0)
    for fastener in turned[::2]:
        assert not judged.wrong_swing(fastener)
        assert judged.wrong_swing(dataclasses.replace(fastener, swing_rad=fastener.swing_rad - np.deg2rad(0.5)))
    faulty = judge.Ways(judge.of_sample(LEAST, 0, ["blocked_bolt"]))
    bolt, guard, sleeve = faulty.truth.faults[0].parts
    assert sorted(faulty.in_the_way(next(f for f in faulty.truth.fasteners if f.path == bolt))) == [guard, sleeve]


def boxes_of(fastener: Any) -> feeler.Tool:
    """The wrench of a fastener as a mesh."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=bool)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([face for a, b, c, d in sides for face in ([a, b, c], [a, c, d])])
    points = [np.where(corner, high, low) for low, high in fastener.tool_boxes_m]
    return feeler.Tool(np.concatenate(points), np.concatenate([faces + 8 * k for k in range(len(points))]))


def test_wrenches_swing_as_far_as_feeler_finds(gearbox: Any) -> None:
    """By `feeler.access`, with the stated tool where the truth puts it; its length and width are those of its boxes."""
    found = {row.path: row for row in feeler.find_fasteners(gearbox.mockup)}
    for fastener in (fastener for fastener in gearbox.truth.fasteners if fastener.tool_boxes_m):
        handle = np.array(fastener.tool_boxes_m[-1])
        assert fastener.tool_length_m == pytest.approx(handle[1, 0]) == pytest.approx(9.0 * fastener.size_m)
        assert fastener.tool_width_m == pytest.approx(np.ptp(handle[:, 1]))
        step = next(step for step in gearbox.truth.steps if fastener.path in step.parts)
        target = found[fastener.path]
        lift = float((np.array(fastener.top_m) - target.frame[:3, 3]) @ target.frame[:3, 2])
        scene = gearbox.scene.without(gearbox.out(step))
        wrench, targets = boxes_of(fastener), feeler.Fasteners([target])
        row = feeler.access(scene, wrench, targets, approach=0.05, lift=lift, threads=1)[0]
        assert row.is_reachable and 0.0 <= row.swing_deg - np.rad2deg(fastener.swing_rad) < 0.1, fastener.path


def test_the_swing_of_boxes() -> None:
    """By hand: a post, two posts, a plate around all, a tilted triangle that only its edge brings into the way."""
    box = (((10.0, -1.0, -1.0), (20.0, 1.0, 1.0)),)
    half = np.arcsin(1.0 / 15.0)
    post = np.array([[15.0, 0.0, -3.0], [15.0, 0.0, 3.0], [15.0, 1e-9, 0.0]])
    assert widest_swing(post[None], box) == pytest.approx(2.0 * np.pi - 2.0 * half)
    other = post @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert widest_swing(np.stack([post, other]), box) == pytest.approx(1.5 * np.pi - 2.0 * half)
    plate = 1e3 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]])
    assert widest_swing(plate[None], box) == 0.0
    assert widest_swing(plate[None] + [0.0, 0.0, 1.1], box) == widest_swing(plate[None][:0], box) == 2.0 * np.pi
    tilted = np.array([[15.0, 0.0, 0.9], [15.0, -3.0, 5.0], [15.0, 3.0, 5.0]])
    assert 2.0 * half < 2.0 * np.pi - widest_swing(tilted[None], box) < 2.2 * half


def test_masses() -> None:
    """A bolt M6x20 is about 6.5 g; the rear case some kilograms."""
    mass = {body.path: body.mass_kg for body in fine().bodies}
    assert mass["gearbox/covers/main_front/bolt_1"] == pytest.approx(6.5e-3, rel=0.1)
    assert 2.0 < mass["gearbox/housing/rear_case"] < 6.0
    assert min(mass.values()) > 0.0
    ball = mass["gearbox/gear_train/main_shaft/front_bearing/ball_1"]
    assert ball == pytest.approx(7850.0 * np.pi / 6.0 * 7.938e-3**3, rel=0.05)


def test_joints_turn_within_their_limits_and_stop_beyond() -> None:
    """Each with all that moves along, past all others; trains of gears through two teeth and a turn."""
    truth = ways().truth
    assert [joint.name for joint in truth.joints if not joint.follows] == ["main_shaft", "filter_bowl", "door", "latch"]
    assert {joint.kind for joint in truth.joints if joint.low is None} == {"continuous"}
    assert not ways().wrong_joints(each=5)


def test_shafts_turn_by_the_ratios_of_their_teeth() -> None:
    """Gears of 36, 44, 28, 34 and 26 teeth, a bevel pair of 30 and 20; cages turn less than half as far."""
    joints = {joint.name: joint for joint in ways().truth.joints}
    ratios = {
        ("starter_shaft", "main_shaft"): -44 / 36,
        ("idler_shaft", "main_shaft"): -44 / 28,
        ("oil_pump_shaft", "idler_shaft"): -28 / 34,
        ("breather_shaft", "oil_pump_shaft"): -34 / 26,
        ("pinion_shaft", "main_shaft"): 30 / 20,
    }
    for (driven, driver), ratio in ratios.items():
        assert joints[driven].follows == driver and joints[driven].ratio == pytest.approx(ratio)
    cages = [joint for joint in joints.values() if "/" in joint.name]
    assert len(cages) == 12 and all(0.3 < joint.ratio < 0.5 for joint in cages)
    assert "gearbox/starter/drive_shaft" in joints["starter_shaft"].parts


def test_the_judge_of_joints_sees_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shaft that turns the other way, a gear that stays, limits before or beyond the stops, a latched door."""
    joints = {joint.name: joint for joint in ways().truth.joints}
    pinion, door = joints["pinion_shaft"], joints["door"]
    gear = tuple(path for path in joints["idler_shaft"].parts if not path.endswith("spur_gear"))
    wrong = [
        ("main_shaft", dataclasses.replace(pinion, ratio=-1.5), 0.1),
        ("main_shaft", dataclasses.replace(joints["idler_shaft"], parts=gear), 0.1),
        ("door", dataclasses.replace(door, needs=()), 0.1),
    ]
    for name, joint, angle in wrong:
        assert not ways().stopped_at(joints[name], angle)
        with monkeypatch.context() as patch:
            patch.setitem(ways().joints, joint.name, joint)
            assert ways().stopped_at(ways().joints[name], angle), joint.name
    for low, high, said in ((0.0, 1.9, "no stop above"), (-0.1, door.high, "meets")):
        found = ways().wrong_joints([dataclasses.replace(door, low=low, high=high)], each=3)
        assert found and said in found[0]


@pytest.mark.parametrize("name", ["filter_bowl", "door", "latch"])
def test_a_cast_ends_at_the_stop(name: str) -> None:
    """By feeler's casts along a screw: free from limit to limit, and an impact beyond both."""
    judged = ways()
    joint = judged.joints[name]
    fits = {path for fit in judged.truth.fits for path in (fit.a, fit.b) if {fit.a, fit.b} & set(joint.parts)}
    meshes = {path: judge.moved_mesh(mesh, judged.latched(joint, path)) for path, mesh in judged.drawn.meshes.items()}
    moving = feeler.Mockup({p: mesh for p, mesh in meshes.items() if p in joint.parts})
    stops = {"gearbox/oil_filter/head"}
    others = {p: mesh for p, mesh in meshes.items() if p not in joint.parts and p not in fits - stops}
    scene = feeler.Scene(feeler.Mockup(others))
    tool = feeler.Tool(moving.vertices, moving.faces)
    low, high = joint.low + 1e-3, joint.high - 1e-3
    start = judge.joint_pose(joint, low)
    assert scene.cast(tool, start, screw=feeler.Screw(joint.axis, joint.point_m, high - low)) is None
    for begin, way in ((low, -1e-3 - judge.STOP_RAD), (high, 1e-3 + judge.STOP_RAD)):
        screw = feeler.Screw(joint.axis, joint.point_m, way)
        assert scene.cast(tool, judge.joint_pose(joint, begin), screw=screw) is not None


def test_the_page_has_the_fits(root: Path) -> None:
    """`python tools/gearbox_docs.py` keeps the table of docs/samples.md."""
    done = subprocess.run([sys.executable, root / "tools" / "gearbox_docs.py", "--check"], check=False)
    assert done.returncode == 0, "run python tools/gearbox_docs.py"


def plain(value: Any) -> bool:
    """Whether all of it is of Python's own types: no subclass of float either."""
    if isinstance(value, (list, tuple)):
        return all(map(plain, value))
    return (
        all(map(plain, value.values()))
        if isinstance(value, dict)
        else type(value) in (str, int, float, bool, type(None))
    )


@pytest.mark.parametrize("faults", [(), tuple(FAULTS)])
def test_truth_is_of_plain_numbers(faults: tuple[str, ...]) -> None:
    """JSON gives back the same ones, and has no NaN or Infinity."""
    made = judge.of_sample(LEAST + 4_000, 0, faults) if faults else drawn(LEAST + 4_000)
    held = dataclasses.asdict(made.truth)
    assert plain(held)
    text = json.dumps(held, allow_nan=False)
    assert json.dumps(json.loads(text)) == text


def test_truth_as_json() -> None:
    truth = drawn().truth
    held = json.loads(truth.to_json())
    assert set(held) == {field.name for field in dataclasses.fields(truth)}
    assert len(held["fits"]) == len(truth.fits)
    assert held["steps"][0]["legs"][0]["kind"] in ("pull", "turn", "screw")


BYTES_OF_TRUTH = """
import hashlib, sys, numpy, feeler
rng = numpy.random.default_rng(1)
print(hashlib.sha256((rng.normal(size=(300, 300)) @ rng.normal(size=(300, 300))).tobytes()).hexdigest())
for seed in (6, 13, 18):
    text = feeler.sample_truth("gearbox", 45_000, seed, faults=["blocked_bolt", "duplicate"]).to_json()
    mockup = feeler.sample("gearbox", 45_000, seed, faults=["blocked_bolt", "duplicate"])
    print(hashlib.sha256(text.encode() + mockup.vertices.tobytes() + mockup.faces.tobytes()).hexdigest())
"""
"""Prints what tells the kernels of BLAS apart, and then what they must not change."""


def test_truth_has_the_same_bytes_on_all_processors() -> None:
    """Whatever the kernels of BLAS: those of older processors have no fused sums."""

    def told(kernels: str) -> list[str]:
        env = {**os.environ, "OPENBLAS_CORETYPE": kernels}
        done = subprocess.run(
            [sys.executable, "-c", BYTES_OF_TRUTH], env=env, capture_output=True, text=True, check=True
        )
        return done.stdout.split()

    (kernels, *own), *others = [told(name) for name in ("", "Haswell", "Nehalem")]
    if all(other[0] == kernels for other in others):
        pytest.skip("this BLAS has one set of kernels")
    assert len(own) == 3 and all(other[1:] == own for other in others)


def test_unknown_paths_are_refused_with_near_names() -> None:
    truth = drawn().truth
    cover = "gearbox/covers/main_front/cover"
    for ask in (truth.way, truth.holds, lambda path: truth.fit(path, cover), lambda path: truth.fit(cover, path)):
        with pytest.raises(feeler.OptionError, match="'gearbox/oil_filter/bowl'"):
            ask("gearbox/oil_filter/bowel")


def test_what_is_no_path_or_step_is_refused() -> None:
    truth, other = drawn().truth, feeler.sample_truth("gearbox", LEAST, seed=1)
    cover: Any = "gearbox/covers/main_front/cover"
    for wrong in (None, 5, b"gearbox", [cover], truth.steps[0]):
        for ask in (truth.way, truth.holds, lambda path: truth.fit(path, cover), lambda path: truth.fit(cover, path)):
            with pytest.raises(feeler.OptionError, match="give the path of a part"):
                ask(wrong)
    for step in (None, cover, 3):
        with pytest.raises(feeler.OptionError, match="give one of the truth's `steps`"):
            truth.needed(step)
    with pytest.raises(feeler.OptionError, match="none of this truth"):
        truth.needed(other.way("gearbox/oil_filter/bowl")[-1])
    way = truth.way("gearbox/oil_filter/head")
    assert truth.needed(way[-1]) == way[:-1] and len(way) > 1


def test_names_of_faults_in_any_collection() -> None:
    """A set has no order of its own: the order is that of FAULTS, whatever the hashes of texts in this run."""
    names = ["pipe_clash", "too_near", "inside"]
    for faults in (tuple(names), np.array(names), iter(names), dict.fromkeys(names), set(names), frozenset(names)):
        assert [fault.name for fault in feeler.sample_truth("gearbox", LEAST + 4_000, faults=faults).faults] == names
    mockup = feeler.sample("gearbox", LEAST + 4_000, faults=np.array(names[:1]))
    assert "gearbox/bracket/pipe_support" in mockup.part_paths
    assert feeler.sample("carcass", 10_000, faults=np.array([])).triangle_count
    for wrong in ("pipe_clash", b"pipe_clash", 5, None, [1], np.array([1.0]), np.array("pipe_clash"), [["inside"]]):
        with pytest.raises(feeler.OptionError, match="give a list of names"):
            feeler.sample_truth("gearbox", LEAST + 4_000, faults=wrong)
    with pytest.raises(feeler.OptionError, match="no faults to plant"):
        feeler.sample("engine", 20_000, faults=np.array(names))


def test_arrays_and_truth_are_built_once(monkeypatch: pytest.MonkeyPatch) -> None:
    mockup = feeler.sample("gearbox", 41_000, seed=6)
    monkeypatch.setattr("feeler.samples.accessory.sample.Drawn", None)  # another one would fail
    truth = feeler.sample_truth("gearbox", 41_000, seed=6)
    assert [body.path for body in truth.bodies] == list(mockup.part_paths)
    again = feeler.sample("gearbox", 41_000, seed=6)
    assert np.array_equal(again.vertices, mockup.vertices)


def test_heads_of_cap_screws_are_round_at_any_size() -> None:
    """At least 12 sides around a hexagon: at few triangles no head could be taken for one to put a socket on."""
    truth = drawn().truth
    screws = [fastener for fastener in truth.fasteners if fastener.kind == "screw"]
    assert {f.path for f in truth.fasteners if "screw" in f.path.rsplit("/", 1)[1]} == {f.path for f in screws}
    for screw in screws:
        arms = drawn().meshes[screw.path].vertices - screw.top_m
        top = arms[np.abs(arms @ screw.axis) < 1e-5]
        radius = np.sqrt((top * top).sum(axis=1))
        assert (radius > 0.9 * radius.max()).sum() >= 12
        assert (np.abs(radius - screw.size_m / np.sqrt(3.0)) < 1e-5).sum() == 6


# --- faults -----------------------------------------------------------------------------------------------------------


def of_faults(names: list[str], triangles: int = LEAST) -> tuple[Any, set[frozenset[str]]]:
    faulty = judge.of_sample(triangles, 0, names)
    assert [fault.name for fault in faulty.truth.faults] == names
    fits = {frozenset((fit.a, fit.b)) for fit in faulty.truth.fits}
    return faulty, {frozenset(pair) for pair, volume in judge.shared_volumes(faulty).items() if volume > 1e-6} - fits


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_all_faults_at_once(seed: int) -> None:
    """Nothing beside what they name shares volume, touches, or is nearer to a pipe than the rule."""
    faulty, clean = judge.of_sample(50_000, seed, FAULTS), judge.of_sample(50_000, seed)
    assert [fault.name for fault in faulty.truth.faults] == list(FAULTS)
    assert not judge.unplanned(faulty, clean)
    assert not judge.wrong_values(faulty)
    fits = {frozenset((fit.a, fit.b)) for fit in faulty.truth.fits}
    planted = {fault.name: frozenset(fault.parts) for fault in faulty.truth.faults}
    (washer,) = planted["wrong_unit"]
    shared = {frozenset(pair) for pair in judge.shared_volumes(faulty)} - fits
    volumes = {planted[name] for name in ("pipe_clash", "missing_hole", "duplicate", "inside", "mirrored")}
    assert {pair for pair in shared if washer not in pair} == volumes
    near = {frozenset(pair) for pair in judge.near_pipes(faulty) if washer not in pair}
    assert near == {planted["pipe_clash"], planted["too_near"]} and not judge.near_pipes(clean)


@pytest.mark.parametrize("names", [("no_way_out", "pipe_clash"), ("too_near", "wrong_unit")])
def test_two_faults_at_once(names: tuple[str, str]) -> None:
    faulty = judge.of_sample(LEAST + 4_000, 0, names)
    assert not judge.unplanned(faulty, drawn(LEAST + 4_000)) and not judge.wrong_values(faulty)


def test_faults_that_share_volume() -> None:
    """The pairs that the faults name, and no others, share volume without a fit."""
    faulty, stray = of_faults(["pipe_clash", "missing_hole", "duplicate", "inside", "mirrored"])
    clash, _, twice, _, _ = faulty.truth.faults
    assert stray == {frozenset(fault.parts) for fault in faulty.truth.faults}
    depth = judge.depth(*(faulty.meshes[path] for path in clash.parts))
    assert clash.value == 3e-3 and depth <= 3e-3
    first, second = (faulty.meshes[path] for path in twice.parts)
    assert np.array_equal(first.vertices, second.vertices)


def test_faults_that_share_none() -> None:
    faulty, stray = of_faults(["too_near", "blocked_bolt", "no_way_out", "floating"], 100_000)
    assert not stray
    near, blocked, _, floating = faulty.truth.faults
    least = judge.gaps(faulty, 6e-3, [near.parts[0], blocked.parts[0]])
    a, b = near.parts
    assert min(gap for pair, gap in least.items() if set(pair) == {a, b}) == pytest.approx(4.5e-3, abs=2e-4)
    bolt, guard, _ = blocked.parts
    assert 1e-3 < min(gap for pair, gap in least.items() if set(pair) == {bolt, guard}) < 3e-3
    assert not [pair for pair in judge.near_pairs(faulty.meshes, 5e-3) if floating.parts[0] in pair]


def test_a_wrong_unit_is_25_times_too_large() -> None:
    faulty, stray = of_faults(["wrong_unit"])
    (path,) = faulty.truth.faults[0].parts
    size = np.ptp(faulty.meshes[path].vertices, axis=0).max() / np.ptp(drawn().meshes[path].vertices, axis=0).max()
    assert size == pytest.approx(25.4, rel=0.02)
    assert stray and all(path in pair for pair in stray)


def test_the_bowl_that_does_not_come_out() -> None:
    faulty = judge.of_sample(LEAST, 0, ["no_way_out"])
    guarded = judge.Drawn(
        {**ways().drawn.meshes, **{p: faulty.meshes[p] for p in faulty.truth.faults[0].parts[1:]}}, ways().truth
    )
    found = judge.Ways(guarded).blocked(ways().truth.way("gearbox/oil_filter/bowl")[-1])
    assert {pair[1] for pair in found} == {"gearbox/bracket/filter_guard"}


@pytest.mark.parametrize(("seed", "names"), [(0, ("wrong_unit",)), (3, tuple(FAULTS))])
def test_steps_and_swings_know_the_faults(seed: int, names: tuple[str, ...]) -> None:
    """A step is blocked if and only if it says so; `python bench/gearbox_judge.py` asks for each fault."""
    assert not judge.wrong_steps(seed, [names])


def test_faults_name_all_that_they_change() -> None:
    """Parts that are added, or drawn otherwise or elsewhere; and tools go where the heads are."""
    clean = judge.faultless(0)
    for name in FAULTS:
        faulty = judge.eased(0, faults=(name,))
        (fault,) = faulty.truth.faults
        new = judge.changed(faulty, clean)
        assert new <= {*fault.parts, *fault.moved} and new >= set(fault.moved), name
        tops = {f.path: f for f in faulty.truth.fasteners}
        for before in clean.truth.fasteners:
            shift = np.subtract(tops[before.path].top_m, before.top_m) @ before.axis
            heads = [(drawn.meshes[before.path].vertices @ before.axis).max() for drawn in (clean, faulty)]
            if name != "wrong_unit":
                assert shift == pytest.approx(heads[1] - heads[0], abs=1e-6), (name, before.path)


@pytest.mark.parametrize("seed", [0, 4])
def test_faults_leave_all_other_parts_as_they_are(seed: int) -> None:
    """The same bytes, in the same order, before the parts that they add; at any number of triangles."""
    triangles = 46_000
    clean, faulty = drawn(triangles, seed), judge.of_sample(triangles, seed, FAULTS)
    assert list(faulty.meshes)[: len(clean.meshes)] == list(clean.meshes)
    named = {path for fault in faulty.truth.faults for path in (*fault.parts, *fault.moved)}
    for path, mesh in clean.meshes.items():
        other = faulty.meshes[path]
        same = mesh.vertices.tobytes() == other.vertices.tobytes() and mesh.faces.tobytes() == other.faces.tobytes()
        assert same or path in named, path
    more = [mesh.triangle_count for path, mesh in faulty.meshes.items() if path not in clean.meshes]
    assert sum(more) < 0.1 * triangles


def test_the_guard_comes_out_after_its_plug() -> None:
    truth = feeler.sample_truth("gearbox", LEAST, faults=["blocked_bolt"])
    bolt, guard, sleeve = truth.faults[0].parts
    way = truth.way(guard)
    assert [step.parts[0] for step in way] == [guard.replace("guard", "blanking_plug"), guard]
    assert not way[-1].blocked_by and guard in truth.way(guard.replace("guard", "cover"))[-1].after
    assert truth.holds(guard) == (guard.replace("guard", "blanking_plug"),) and truth.holds(sleeve) == (guard,)
    mockup = feeler.sample("gearbox", LEAST, faults=["blocked_bolt"])
    found = feeler.access(feeler.Scene(mockup), feeler.catalogue(), feeler.find_fasteners(mockup, bolt))
    assert not found[0].is_reachable
    assert truth.way(bolt)[-1].blocked_by == ("blocked_bolt",)


def test_what_a_fault_blocks() -> None:
    """The step in whose way it is and all that need it; nothing else."""
    truth = feeler.sample_truth("gearbox", LEAST + 4_000, faults=["no_way_out", "duplicate"])
    blocked = {step.parts[0].removeprefix("gearbox/"): step.blocked_by for step in truth.steps if step.blocked_by}
    assert set(blocked.values()) == {("no_way_out",)}
    assert set(blocked) == {"oil_filter/bowl", "oil_filter/head", "oil_filter/gasket", "housing/rear_case"}
    assert truth.way("gearbox/oil_filter/head")[-1].blocked_by == ("no_way_out",)
    twice = truth.way("gearbox/housing/split_bolts/bolt_5_copy")[-1]
    assert "gearbox/housing/split_bolts/bolt_5" in twice.parts and not twice.blocked_by
    assert not any(step.blocked_by for step in drawn().truth.steps)
    bolt = feeler.sample_truth("gearbox", LEAST + 4_000, faults=["blocked_bolt"]).faults[0].parts[0]
    swings = feeler.sample_truth("gearbox", LEAST + 4_000, faults=["blocked_bolt"]).fasteners
    assert {fastener.path for fastener in swings if fastener.swing_rad == 0.0} == {bolt}


def test_the_judge_of_blocked_steps_sees_what_is_not_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without what the faults say of steps and swings."""
    judge.faultless(0)  # it is kept for other tests: made before the patches
    monkeypatch.setattr("feeler.samples.accessory.assembly.Assembly.block", lambda *_: None)
    monkeypatch.setattr("feeler.samples.accessory.assembly.Assembly.stop_tool", lambda *_: None)
    wrong = judge.wrong_steps(0, [("no_way_out",)])
    assert len(wrong) == 2 and "oil_filter/bowl is blocked" in wrong[0]


def test_unknown_faults_and_other_samples() -> None:
    assert len(FAULTS) == 10
    with pytest.raises(feeler.OptionError, match="pipe_clash"):
        feeler.sample("gearbox", 100_000, faults=["rust"])
    with pytest.raises(feeler.OptionError, match="gearbox"):
        feeler.sample("engine", 20_000, faults=["pipe_clash"])
    with pytest.raises(feeler.OptionError, match="gearbox"):
        feeler.sample_truth("engine")


# --- the builder ------------------------------------------------------------------------------------------------------


def test_no_triangle_is_lower_than_the_grid_where_the_face_can_be_cut_otherwise() -> None:
    """The middle of the upper side is a tenth of a grid step below its ends: as an ear it would be turned over."""
    points = np.array([[0.0, 0.0], [200.0, 0.0], [200.0, 10.0], [100.0, 10.0 - 5e-5], [0.0, 10.0]])
    rows = polygon._lifted(points, np.array([[2, 3, 4], [0, 2, 4], [0, 1, 2]]))
    heights = polygon._height(points[rows])
    assert heights.min() > 1.0
    assert sorted({*rows.ravel().tolist()}) == [0, 1, 2, 3, 4]


def test_low_triangles_beside_low_ones_are_cut_otherwise() -> None:
    """All corners of the upper side are nearly on one line, in one fan: no single exchange helps."""
    upper = [[200.0 - 10.0 * k, 10.0 - 5e-5 * (k % 3)] for k in range(21)]
    points = np.array([[0.0, 0.0], [200.0, 0.0], *upper])
    fan = [[2, k, k + 1] for k in range(3, 22)]
    rows = polygon._lifted(points, np.array([[0, 1, 2], [0, 2, 22], *fan]))
    heights = polygon._height(points[rows])
    assert len(rows) == 21 and heights.min() > 0.4
    sides = np.sort(rows[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert sorted(np.unique(sides, axis=0, return_counts=True)[1].tolist()) == [1] * 23 + [2] * 20


def test_polygons_with_holes() -> None:
    """The triangles of random polygons with holes tile them: all positive, and their areas add up."""
    rng = np.random.default_rng(3)
    for _ in range(30):
        n = int(rng.integers(5, 40))
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, n))
        if np.diff(np.append(angle, angle[0] + 2.0 * np.pi)).max() > 2.5:
            continue
        radius = rng.uniform(5.0, 9.0, n)[:, None]
        loops = [radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)]
        for centre in ((1.2, 0.0), (-1.2, 0.1), (0.0, 1.4), (0.1, -1.3)):
            turn = -np.arange(7) * (2.0 * np.pi / 7.0) + rng.uniform()
            loops.append(np.array(centre) + 0.5 * np.stack([np.cos(turn), np.sin(turn)], axis=1))
        points = np.concatenate(loops)
        faces = triangulated(loops)
        a, b, c = (points[faces[:, k]] for k in range(3))
        areas = np.cross(np.pad(b - a, ((0, 0), (0, 1))), np.pad(c - a, ((0, 0), (0, 1))))[:, 2] / 2.0
        whole = sum(0.5 * np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1)) for p in loops)
        assert (areas > 0.0).all() and areas.sum() == pytest.approx(whole)
        assert len(faces) == len(points) + 2 * 4 - 2


def test_an_open_solid_is_refused() -> None:
    solid = Solid()
    first, _ = solid.turned([(1.0, 0.0), (1.0, 2.0)], 8)
    solid.face(first)
    with pytest.raises(ValueError, match="loop"):
        solid.mesh()
    assert Cut(0.01).sag(10.0) <= 0.01


@pytest.mark.parametrize("triangles", [40_000, 42_000])
def test_coarse_parts_are_no_deeper_than_their_fits(triangles: int) -> None:
    """The element in the neck of its bowl, and the collars of pipes in their nuts, are drawn with few sides there."""
    assert judge.too_deep(judge.of_sample(triangles, 0)) == []


def test_screwing_out_is_part_of_the_way_past_a_cable() -> None:
    truth = feeler.sample_truth("gearbox", 40_000, seed=77123)
    (step,) = [step for step in truth.steps if step.parts[0] == "gearbox/housing/split_bolts/bolt_7"]
    assert any("cable" in path for path in step.after)
