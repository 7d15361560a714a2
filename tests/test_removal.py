"""`feeler.removal`: parts that come out, parts that do not, and what cannot be asked."""

import pickle
import warnings
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import feeler
from feeler.plan.removal import RemovalInterrupted

Floats = npt.NDArray[np.float64]
Mesh = tuple[Floats, npt.NDArray[np.int64]]


def box(lower: Sequence[float], upper: Sequence[float]) -> Mesh:
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return np.add(lower, corners * np.subtract(upper, lower)), np.array(
        [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
    )


def scene_of(**parts: Mesh) -> feeler.Scene:
    vertices, faces = zip(*parts.values(), strict=True)
    counts = np.cumsum([0, *map(len, vertices)])
    mockup = feeler.Mockup(
        np.concatenate(vertices),
        np.concatenate([f + n for f, n in zip(faces, counts[:-1], strict=True)]),
        np.repeat(range(len(parts)), [len(f) for f in faces]),
        list(parts),
    )
    return feeler.Scene(mockup)


W = 0.007
DUCT = {  # a cube of 10 mm in a duct of 14 mm that bends
    "cube": box([-0.005] * 3, [0.005] * 3),
    "floor": box([-0.02, -0.02, -0.02], [0.07, 0.08, -W]),
    "ceiling": box([-0.02, -0.02, W], [0.07, 0.08, 0.02]),
    "end": box([-0.02, -0.02, -W], [-0.01, 0.02, W]),
    "south": box([-0.01, -0.02, -W], [0.07, -W, W]),
    "north": box([-0.01, W, -W], [0.046, 0.08, W]),
    "east": box([0.06, -W, -W], [0.07, 0.08, W]),
}
LID = box([0.04, 0.08, -0.02], [0.07, 0.09, 0.02])


@pytest.fixture(scope="module")
def duct() -> feeler.Scene:
    return scene_of(**DUCT)


@pytest.fixture(scope="module")
def found(duct: feeler.Scene) -> feeler.Removal:
    return feeler.removal(duct, "cube", seed=3)


def samples(tool: feeler.Tool, poses: Floats, count: int = 300) -> Floats:
    """Poses between those of a way: the middle of the tool's box on a line, and its turn about one axis."""
    middle = tool.bounds.mean(axis=0)
    all_of_them = []
    for first, last in pairwise(poses):
        turn = last[:3, :3] @ first[:3, :3].T
        angle = np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
        axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
        cross = np.cross(np.eye(3), axis)
        a, b = (pose[:3, :3] @ middle + pose[:3, 3] for pose in (first, last))
        for t in np.linspace(0.0, 1.0, count):
            part = np.eye(3) + np.sin(t * angle) * cross + (1.0 - np.cos(t * angle)) * cross @ cross
            pose = np.eye(4)
            pose[:3, :3] = part @ first[:3, :3]
            pose[:3, 3] = (1.0 - t) * a + t * b - pose[:3, :3] @ middle
            all_of_them.append(pose)
    return np.array(all_of_them)


def test_the_way_is_free_by_another_look(duct: feeler.Scene, found: feeler.Removal) -> None:
    assert found.is_found and found.certificate.method != "straight"
    assert found.rotation == 0.0  # none is needed
    assert (found.poses[0] == np.eye(4)).all() and len(found.poses) > 2
    cube, rest = feeler.Tool.of_parts(duct.mockup, "cube"), duct.without("cube")
    assert rest.check_path(cube, found.poses).is_free
    poses = samples(cube, found.poses)
    batch = rest.collide_batch(cube, np.array([feeler.nearest_rigid(pose) for pose in poses]))
    assert len(batch.pairs) == 0
    gaps = [rest.distance(cube, feeler.nearest_rigid(pose)).value for pose in poses[::10]]
    assert min(gaps) >= found.clearance - 3e-4 and found.clearance > 0.0
    end = cube.vertices @ found.poses[-1][:3, :3].T + found.poses[-1][:3, 3]
    assert end[:, 1].min() > 0.08 or (np.abs(end - (0.025, 0.03, 0.0)) > 0.05).all(axis=0).any()


def test_the_same_on_any_number_of_threads(duct: feeler.Scene, found: feeler.Removal) -> None:
    for threads in (1, 2, 5):
        again = feeler.removal(duct, "cube", seed=3, threads=threads, seconds=1000)
        assert (again.poses == found.poses).all()
        assert again.certificate == found.certificate
        assert [(b.path, b.count) for b in again.blocked_by] == [(b.path, b.count) for b in found.blocked_by]
    other = feeler.removal(duct, "cube", seed=4)
    assert other.is_found and other.certificate.casts != found.certificate.casts


def test_a_closed_box_ends_in_time_and_is_named() -> None:
    closed = scene_of(**DUCT, lid=LID)
    asked: list[str] = []
    answer = feeler.removal(closed, "cube", seconds=1.5, progress=lambda _, stage: asked.append(stage))
    assert not answer.is_found and answer.is_out_of_time
    assert np.isnan(answer.clearance) and (answer.poses == np.eye(4)).all()
    names = [blocker.path for blocker in answer.blocked_by]
    assert "lid" in names and set(names) <= set(closed.mockup.part_paths) - {"cube"}
    counts = [blocker.count for blocker in answer.blocked_by]
    assert counts == sorted(counts, reverse=True) and min(counts) > 0
    lid = answer.blocked_by[names.index("lid")]
    cube = feeler.Tool.of_parts(closed.mockup, "cube")
    assert closed.only("lid").distance(cube, lid.pose).value < 2e-6
    assert "straight ways" in asked and "pushes" in asked
    assert "not found, blocked by" in repr(answer)


def test_what_may_meet() -> None:
    # Between walls without play, on a gasket that it presses 1 mm into, below a loose strip that lies on it.
    scene = scene_of(
        plug=box([-0.01, -0.01, 0.0], [0.01, 0.01, 0.02]),
        left=box([-0.03, -0.01, -0.01], [-0.01, 0.01, 0.03]),
        right=box([0.01, -0.01, -0.01], [0.03, 0.01, 0.03]),
        gasket=box([-0.01, -0.01, -0.005], [0.01, 0.01, 0.001]),
        strip=box([-0.01, -0.005, 0.02], [0.01, 0.005, 0.03]),
    )
    up = [0.0, 0.0, 1.0]
    assert feeler.removal(scene, "plug", seconds=20.0).is_found
    for names in (["left", "right", "gasket", "strip"], "*"):
        assert feeler.removal(scene, "plug", seats=False, ignore=names, directions=up).certificate.method == "straight"
    # Sideways, or down through the gasket, since the strip is in the way and is not named.
    way = feeler.removal(scene, "plug", ignore="gasket", directions=up)
    assert way.is_found and (abs(way.poses[-1][1, 3]) > 0.01 or way.poses[-1][2, 3] < -0.01)
    refused = feeler.removal(scene, "plug", seats=False, ignore=["gasket"])
    assert not refused.is_found and {b.path for b in refused.blocked_by} == {"left", "right", "strip"}
    for nothing in (None, []):
        refused = feeler.removal(scene, "plug", seats=False, ignore=nothing)
        assert {b.path for b in refused.blocked_by} == {"left", "right", "strip", "gasket"}
    # By as much as the gasket is pressed.
    assert feeler.removal(scene, "plug", seats=False, overlap=0.0011).is_found
    assert not feeler.removal(scene, "plug", seats=False, overlap=0.0009).is_found


def test_what_grips_moves_along(duct: feeler.Scene) -> None:
    handle = feeler.Tool(*box([0.0, -0.001, -0.001], [0.004, 0.001, 0.001]), name="handle")
    inside = np.eye(4)
    inside[0, 3] = 0.004
    answer = feeler.removal(duct, "cube", tool=handle, start=inside)
    assert answer.is_found
    both = feeler.Tool.assembly({"cube": feeler.Tool.of_parts(duct.mockup, "cube"), "handle": (handle, inside)})
    assert duct.without("cube").check_path(both, answer.poses).is_free
    inside[0, 3] = 0.058
    with pytest.raises(feeler.PoseError, match=r"start: the tool 'handle' collides with 'east'"):
        feeler.removal(duct, "cube", tool=handle, start=inside)
    deep = np.eye(4)
    deep[:3, 3] = 0.02, 0.04, 0.0
    with pytest.raises(feeler.PoseError, match=r"start: the tool 'handle' collides with 'north'"):
        feeler.removal(duct, "cube", tool=handle, start=deep)


def test_directions_come_first() -> None:
    below, above = box([-0.1, -0.1, -0.01], [0.1, 0.1, 0.0]), box([-0.1, -0.1, 0.04], [0.1, 0.1, 0.05])
    scene = scene_of(block=box([0, 0, 0.01], [0.02, 0.03, 0.03]), below=below, above=above)
    way = feeler.removal(scene, "block", directions=[1.0, -1.0, 0.0]).poses[-1][:3, 3]
    assert way[0] > 0.1 and way[0] == -way[1] and way[2] == 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        large = feeler.removal(scene, "block", directions=[1e300, -1e300, 0.0]).poses[-1][:3, 3]
    assert np.allclose(large, way)
    assert 0.1 < feeler.removal(scene, "block").path_length < 0.11


def test_several_parts_move_as_one() -> None:
    with_passenger = scene_of(**DUCT, passenger=box([-0.001] * 3, [0.001] * 3))
    both = feeler.removal(with_passenger, ["cube", "passenger"])
    assert both.is_found
    alone = feeler.removal(with_passenger, "passenger", seconds=0.1)
    assert not alone.is_found and {b.path for b in alone.blocked_by} == {"cube"}


def test_a_result_travels(found: feeler.Removal) -> None:
    again = pickle.loads(pickle.dumps(found))
    assert (again.poses == found.poses).all() and again.certificate == found.certificate
    assert repr(again) == repr(found) and found.certificate.method in repr(found)
    assert [b.path for b in again.blocked_by] == [b.path for b in found.blocked_by]


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"parts": "pump"}, feeler.OptionError, "no part has the path or name 'pump'"),
        ({"parts": []}, feeler.OptionError, "names no part"),
        ({"parts": list(DUCT)}, feeler.OptionError, "parts names all 7 parts of the scene"),
        ({"seconds": 0}, feeler.OptionError, "seconds is 0"),
        ({"seconds": -1.0}, feeler.OptionError, "seconds is -1.0"),
        ({"seconds": float("nan")}, feeler.OptionError, "seconds is nan"),
        ({"seed": -1}, feeler.OptionError, "seed is -1"),
        ({"seed": 0.5}, feeler.OptionError, "seed is 0.5"),
        ({"threads": 0}, feeler.OptionError, "threads is 0"),
        ({"clearance": -0.001}, feeler.OptionError, "clearance is -0.001"),
        ({"clearance": float("inf")}, feeler.OptionError, "clearance is inf"),
        ({"clearance": "1 mm"}, feeler.OptionError, "clearance is '1 mm'"),
        ({"ignore": "*gasket*"}, feeler.OptionError, "no part matches"),
        ({"ignore": [0.5]}, feeler.OptionError, "0.5"),
        ({"ignore": object()}, feeler.OptionError, "object"),
        ({"overlap": -0.1}, feeler.OptionError, "overlap is -0.1"),
        ({"overlap": [0.1, 0.2]}, feeler.OptionError, "overlap is"),
        ({"seats": "start"}, feeler.OptionError, "seats is 'start': True or False"),
        ({"directions": [[0, 0, 0]]}, feeler.OptionError, "zero or not finite"),
        ({"directions": [[0, 0]]}, feeler.OptionError, r"\(1, 2\)"),
        ({"directions": "up"}, feeler.OptionError, "dtype <U2: real numbers"),
        ({"tool": "hand"}, feeler.MeshError, "tool is a feeler.Tool"),
        ({"start": np.eye(4)}, feeler.OptionError, "there is no tool"),
        ({"progress": 3}, feeler.OptionError, "progress is 3"),
    ],
)
def test_what_cannot_be_asked(
    duct: feeler.Scene, arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        feeler.removal(duct, **{"parts": "cube", **arguments})


def test_more_that_cannot_be_asked(duct: feeler.Scene) -> None:
    with pytest.raises(feeler.MeshError, match=r"a feeler\.Scene is needed, not Mockup"):
        feeler.removal(duct.mockup, "cube")  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="'cube' is not in the scene"):
        feeler.removal(duct.without("cube"), "cube")
    handle = feeler.Tool(*box([0.0] * 3, [0.01] * 3))
    with pytest.raises(feeler.PoseError, match="not rigid"):
        feeler.removal(duct, "cube", tool=handle, start=np.diag([2.0, 1, 1, 1]))


def test_progress_may_stop_it() -> None:
    closed = scene_of(**DUCT, lid=LID)
    told: list[tuple[float, str]] = []

    def stop(share: float, stage: str) -> None:
        told.append((share, stage))
        if share > 3e-4:
            raise KeyboardInterrupt

    with pytest.raises(RemovalInterrupted) as stopped:
        feeler.removal(closed, "cube", seconds=1000, progress=stop)
    until_then = stopped.value.removal
    assert not until_then.is_found and "lid" in [each.path for each in until_then.blocked_by]
    assert [stage for _, stage in told if stage == "straight ways"] and told == sorted(told, key=lambda each: each[0])

    def fail(_: float, stage: str) -> None:
        raise ValueError(stage)

    with pytest.raises(ValueError, match="straight ways"):
        feeler.removal(closed, "cube", seconds=1000, progress=fail)


# --- the sample gearbox, whose ways are known ------------------------------------------------------------------------

COVER = "gearbox/covers/idler_front"


@pytest.mark.parametrize(
    "path",
    [
        f"{COVER}/bolt_1",
        f"{COVER}/cover",
        "gearbox/oil_pump/body",
        "gearbox/input_drive/cartridge",
        "gearbox/lines/oil_pipe/pipe",
        "gearbox/gear_train/idler_shaft/shaft",
    ],
)
def test_ways_are_those_of_the_truth(gearbox: Any, path: str) -> None:
    step = gearbox.step(path)
    found = feeler.removal(gearbox.scene.without(gearbox.out(step)), list(step.parts), seconds=60.0)
    assert found.is_found and found.certificate.method == "straight"
    pull = step.legs[-1]
    assert found.poses[-1][:3, 3] / found.path_length @ pull.axis == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("path", "holds"),
    [
        (f"{COVER}/cover", f"{COVER}/blanking_plug"),
        ("gearbox/gear_train/main_shaft/front_bearing/ball_1", "gearbox/housing/front_case"),
    ],
)
def test_what_the_truth_takes_out_first_is_in_the_way(gearbox: Any, path: str, holds: str) -> None:
    step = gearbox.step(path)
    out = [each for each in gearbox.out(step) if each != holds]
    pull = step.legs[-1].axis
    found = feeler.removal(gearbox.scene.without(out), list(step.parts), directions=[pull], seconds=1.0, threads=1)
    assert not found.is_found and holds in [each.path for each in found.blocked_by]


def test_a_bowl_turns_out_of_its_bayonet_and_not_through_a_guard(gearbox: Any, faulty_gearbox: Any) -> None:
    """Its seat crosses by facets, and is not asked."""
    step = gearbox.step("gearbox/oil_filter/bowl")
    seat = [("*bowl", "*oil_filter/head"), ("*o_ring", "*oil_filter/head")]

    def first_met(of: Any, out: list[str], way: Floats) -> str | None:
        moving = feeler.Tool.of_parts(of.mockup, list(step.parts))
        scene = of.scene.without([*out, *step.parts])
        check = scene.check_path(moving, way, touching="free", ignore=seat)
        return None if check.is_free else str(of.mockup.part_paths[check.first.part])

    way, out = gearbox.poses(step), gearbox.out(step)
    assert first_met(gearbox, out, way) is None
    assert first_met(gearbox, [], way) == "gearbox/door/panel", "the door is shut"
    assert first_met(faulty_gearbox, out, way) == "gearbox/bracket/filter_guard"


def test_what_its_neighbours_leave_no_way_is_held_by_them(duct: feeler.Scene) -> None:
    core = {"core": box([-0.01] * 3, [0.01] * 3)}
    walls = {
        f"{'xyz'[axis]}{side}": box(
            [-0.02 if a != axis else (0.0101 if side else -0.02) for a in range(3)],
            [0.02 if a != axis else (0.02 if side else -0.0101) for a in range(3)],
        )
        for axis in range(3)
        for side in (0, 1)
    }
    held = feeler.removal(scene_of(**core, **walls), "core", seconds=60.0)
    assert not held.is_found and not held.is_out_of_time and held.seconds < 30.0
    assert {part.path for part in held.held_by} == set(walls)
    assert 0.0001 <= held.play < 0.001
    assert "held by x0" in repr(held)
    assert pickle.loads(pickle.dumps(held)).held_by == held.held_by
    # Without one of them, with it allowed, and where nobody can say, nothing holds it.
    for name in walls:
        rest = {other: mesh for other, mesh in walls.items() if other != name}
        free = feeler.removal(scene_of(**core, **rest), "core")
        assert free.is_found and free.held_by == () and np.isnan(free.play)
        assert feeler.removal(scene_of(**core, **walls), "core", ignore=name).is_found
    stuck = feeler.removal(scene_of(**DUCT, lid=LID), "cube", seconds=0.5)
    assert not stuck.is_found and stuck.held_by == () and np.isnan(stuck.play)


@pytest.mark.parametrize("gap", [0.0019, 0.0021])
def test_the_clearance_at_the_start_counts(gap: float) -> None:
    """In a slot with less than the clearance asked for on both sides, all along: what is told is what there is."""
    x = 0.1 + gap
    scene = scene_of(
        part=box([-0.1, -0.05, 0.01], [0.1, 0.05, 0.4]),
        left=box([-x - 1.0, -0.1, 0.0], [-x, 0.1, 0.5]),
        right=box([x, -0.1, 0.0], [x + 1.0, 0.1, 0.5]),
        floor=box([-2.0, -0.1, -0.1], [2.0, 0.1, 0.0]),
        back=box([-x, 0.1, 0.0], [x, 0.2, 0.5]),
        front=box([-x, -0.2, 0.0], [x, -0.1, 0.5]),
    )
    found = feeler.removal(scene, "part", clearance=0.002, seconds=2.0)
    assert found.clearance == pytest.approx(gap, rel=1e-9) if found.is_found else gap < 0.002


@pytest.mark.parametrize("overlap", [0.02, 0.1, 1.0])
def test_an_overlap_larger_than_a_fit_ends(overlap: float) -> None:
    """Surfaces free at the first depth, which was the most, of a part that was inside all the same: for ever."""
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    assert feeler.removal(scene, 0, seconds=0.2, overlap=overlap).seconds > 0.0


@pytest.mark.parametrize("clearance", [0.1, 1.5, 2.0**31])
def test_a_large_clearance_keeps_the_time(clearance: float) -> None:
    """All pairs of triangles within it were found first: half a minute of a fifth of a second."""
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    for ask in (feeler.removal, feeler.insertion, feeler.removal_order):
        assert not ask(scene, 0, seconds=0.2, clearance=clearance).is_found
