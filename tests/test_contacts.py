"""Contact planes, the tracker and penetration through the public face."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import feeler

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    """The script that makes the table of docs/contacts-figures.md: its contacts have known depths."""
    spec = importlib.util.spec_from_file_location("bench_contacts", ROOT / "bench" / "contacts.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "bench"))
        spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("place", ["flush", "turned"])
@pytest.mark.parametrize("name", ["box in a plate", "ball in a plate", "rod in a plate", "tooth in its slot"])
def test_depths_do_not_depend_on_the_triangles(bench: ModuleType, name: str, place: str) -> None:
    for cells in (1, 3, 12, 24):
        contact = bench.CASES[name](cells)
        if place == "turned":
            contact = bench.turned(contact)
        found = bench.by_feeler(contact)
        assert len(found) == len(contact.depths), (cells, found)
        assert np.allclose(found, contact.depths, rtol=0.01, atol=0), (cells, found)


def test_planes_say_what_they_are(bench: ModuleType) -> None:
    contact = bench.CASES["box in a plate"](5)
    scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
    found = scene.contacts(tool, contact.pose)
    assert len(found) == 1 and found and found.is_meeting and found.omitted == 0
    assert found.points.shape == found.normals.shape == (1, 3)
    assert np.allclose(found.normals, [[0, 0, 1]]) and np.allclose(found.gaps, [-0.0015])
    assert abs(found.points[0, 2]) < 1e-12
    assert found.parts.tolist() == [0]
    hit = scene.collide(tool, contact.pose)
    assert found.tool_offsets.tolist() == [0, len(found.tool_triangles)]
    assert found.mockup_offsets.tolist() == [0, len(found.mockup_triangles)]
    assert set(found.tool_triangles.tolist()) <= set(hit.tool_triangles.tolist())
    assert set(found.mockup_triangles.tolist()) <= set(hit.mockup_triangles.tolist())
    assert "1 plane," in repr(found)
    for array in (found.points, found.normals, found.gaps, found.parts, found.tool_triangles, found.mockup_offsets):
        assert not array.flags.writeable
    assert scene.memory()["adjacency"] > 0


def test_penetration_frees_the_tool(bench: ModuleType) -> None:
    expected = ("box in a plate", "tooth in its slot", "ball in a plate")
    for name in expected:
        contact = bench.turned(bench.CASES[name](6))
        scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
        out = scene.penetration(tool, contact.pose)
        assert out.kind == "bound", (name, out)
        assert out.depth == pytest.approx(np.linalg.norm(out.translation))
        assert len(out.contacts) >= len(contact.depths)
        moved = contact.pose.copy()
        moved[:3, 3] += out.translation
        assert not scene.is_colliding(tool, moved)
        if len(contact.depths) == 1:
            assert out.depth == pytest.approx(contact.depths[0], rel=0.01)
            moved[:3, 3] -= 0.02 * out.translation
            assert scene.is_colliding(tool, moved)


BOX = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
BOX_FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


@pytest.mark.parametrize(("degrees", "kind"), [(30.0, "bound"), (0.05, "estimate")])
def test_a_way_out_is_no_longer_than_the_tool(degrees: float, kind: str) -> None:
    # A cube between two walls that lean apart, 1 mm in both: it leaves along the gap, unless that is nearly parallel.
    lean = np.radians(degrees)
    wall = (BOX * [0.4, 4, 4]) - [0, 2, 2]
    turn = np.array([[np.cos(lean), -np.sin(lean), 0], [np.sin(lean), np.cos(lean), 0], [0, 0, 1]])
    right = wall @ turn.T
    left = right * [-1, 1, 1]
    walls = np.vstack([np.add(right, [0.05, 0, 0]), np.add(left, [-0.05, 0, 0])])
    scene = feeler.Scene(feeler.Mockup(walls, np.vstack([BOX_FACES, BOX_FACES[:, ::-1] + 8]), np.repeat([0, 1], 12)))
    # The cube's lower edges are what is nearest to the walls, which open downwards for a positive lean.
    upper = 0.05 - 0.05 * np.tan(lean)
    half = upper / np.cos(lean) + 0.001
    tool = feeler.Tool((BOX - 0.5) * [2 * half, 0.1, 0.1], BOX_FACES)
    out = scene.penetration(tool, np.eye(4))
    assert scene.is_colliding(tool, np.eye(4))
    assert out.kind == kind
    assert out.depth <= np.linalg.norm(np.ptp(tool.bounds, axis=0))
    moved = np.eye(4)
    moved[:3, 3] = out.translation
    assert scene.is_colliding(tool, moved) == (kind == "estimate")


def test_a_tool_that_is_free_needs_no_way_out(bench: ModuleType) -> None:
    contact = bench.CASES["box in a plate"](2)
    scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
    out = scene.penetration(tool, bench.shifted(0, 0, 1.0))
    assert (out.depth, out.kind, len(out.contacts)) == (0.0, "exact", 0)
    assert out.translation.tolist() == [0, 0, 0]


def test_a_tool_wholly_inside_a_solid_is_not_free() -> None:
    # Two boxes, the second flush beside the first: its wall is as near to what is in the first, and faces it.
    corners, faces = np.vstack([BOX, np.add(BOX, [1, 0, 0])]), np.vstack([BOX_FACES, BOX_FACES + 8])
    for parts in ([0, 1], [1, 0]):
        scene = feeler.Scene(feeler.Mockup(corners, faces, np.repeat(parts, 12)))
        tool = feeler.Tool((BOX - 0.5) * 0.1, BOX_FACES)
        for place, way in (((0.5, 0.4, 0.9), (0, 0, 0.15)), ((0.94, 0.5, 0.8), (0, 0, 0.25)), ((1.06, 0.3, 0.5), None)):
            pose = np.eye(4)
            pose[:3, 3] = place
            assert not scene.is_colliding(tool, pose)
            out = scene.penetration(tool, pose)
            assert (out.kind, len(out.contacts)) == ("bound", 0)
            if way is not None:
                assert out.translation == pytest.approx(way, rel=0.02, abs=1e-9)


def test_the_tracker_remembers_the_side(bench: ModuleType) -> None:
    vertices, faces = bench.sheet(9, 9, lambda s, t: (0.1 * (s - 0.5), 0.1 * (t - 0.5), 0 * s))
    scene, tool = feeler.Scene(feeler.Mockup(vertices, faces)), feeler.Tool(*bench.box((0.02,) * 3, (0, 0, 0), 4))
    for side in (1, -1):
        tracker = feeler.ContactTracker(scene, tool)
        assert tracker.last_free is None
        for step in range(30):
            height = side * (0.0203 - 0.0005 * step)
            found = tracker.contacts(bench.shifted(0.001, 0, height))
            depth = 0.01 - side * height
            assert np.allclose(found.normals[:, 2], side) if len(found) else depth < -0.002
            assert not len(found) or found.gaps[0] == pytest.approx(-depth, abs=1e-12)
        assert tracker.last_free is not None and side * tracker.last_free[2, 3] > 0.01
        again = scene.contacts(tool, bench.shifted(0.001, 0, side * 0.004), reference=tracker.last_free)
        assert np.allclose(again.normals[0], [0, 0, side]) and again.gaps[0] == pytest.approx(-0.006)
        tracker.last_free = None
        assert tracker.last_free is None


def test_the_same_answer_every_time_and_from_every_store(bench: ModuleType) -> None:
    mockup = feeler.sample("differential", triangles=20_000)
    tool = feeler.sample_tool("wrench")
    scenes = [feeler.Scene(mockup, storage=storage) for storage in ("blocks", "dense", "hashed")]
    freed = 0
    for pose in feeler.sample_poses(scenes[0], tool, "nominal", 12):
        first, *others = [scene.contacts(tool, pose) for scene in (*scenes, scenes[0])]
        assert 0 < len(first) <= 32
        assert np.allclose(np.linalg.norm(first.normals, axis=1), 1)
        assert np.isfinite(first.points).all() and (np.diff(first.gaps) >= 0).all()
        assert first.is_meeting == scenes[0].is_colliding(tool, pose)
        for other in others:
            assert np.array_equal(first.gaps, other.gaps) and np.array_equal(first.normals, other.normals)
            assert np.array_equal(first.points, other.points) and np.array_equal(first.parts, other.parts)
        out = scenes[0].penetration(tool, pose)
        if out.kind != "estimate":
            moved = pose.copy()
            moved[:3, 3] += out.translation
            assert not scenes[0].is_colliding(tool, moved)
            freed += 1
    assert freed > 3


def test_ids_stay_from_pose_to_pose_and_scene_to_scene(bench: ModuleType) -> None:
    contact = bench.CASES["box in a plate"](5)
    mockup, tool = feeler.Mockup(*contact.mockup), feeler.Tool(*contact.tool)
    scenes = [feeler.Scene(mockup), feeler.Scene(feeler.Mockup(*contact.mockup), storage="dense")]
    seen = set()
    for step in range(30):
        pose = contact.pose.copy()
        pose[:3, 3] += (0.0002 * step, -0.0001 * step, 0.00008 * step)
        found = [scene.contacts(tool, pose) for scene in (*scenes, scenes[0])]
        assert all(len(contacts) == 1 and contacts.ids.dtype == np.uint64 for contacts in found)
        seen |= {contacts.ids.item() for contacts in found}
    assert len(seen) == 1


def test_no_two_planes_share_an_id() -> None:
    scene = feeler.Scene(feeler.sample("differential", triangles=20_000))
    tool = feeler.sample_tool("hand")
    kept = asked = 0
    for pose in feeler.sample_poses(scene, tool, "nominal", 12):
        found = scene.contacts(tool, pose)
        assert len(set(found.ids.tolist())) == len(found)
        nudged = pose.copy()
        nudged[:3, 3] += 1e-6
        kept += len(set(found.ids.tolist()) & set(scene.contacts(tool, nudged).ids.tolist()))
        asked += len(found)
    assert asked > 50 and kept > 0.9 * asked


def test_a_flat_box_stands_on_its_corners(bench: ModuleType) -> None:
    contact = bench.CASES["box in a plate"](4)
    tool = feeler.Tool(*contact.tool)
    found = feeler.Scene(feeler.Mockup(*contact.mockup)).contacts(tool, contact.pose)
    assert found.footing.shape == (1, 4, 3) and found.footing_counts.tolist() == [4]
    assert not found.footing.flags.writeable
    vertices = np.asarray(contact.tool[0])
    down = contact.pose[:3, :3].T @ -found.normals[0]
    heights = vertices @ down
    lowest = vertices[heights > heights.max() - 1e-9]
    nearest = np.linalg.norm(found.footing[0][:, None] - lowest[None], axis=2)
    assert nearest.min(axis=1).max() < 1e-6
    assert np.ptp(found.footing[0], axis=0).max() == pytest.approx(np.ptp(lowest, axis=0).max())


def test_one_plane_as_an_object(bench: ModuleType) -> None:
    contact = bench.CASES["tooth in its slot"](4)
    tool = feeler.Tool(*contact.tool)
    scene = feeler.Scene(feeler.Mockup(*contact.mockup))
    tracker = feeler.ContactTracker(scene, tool)
    way_out = scene.penetration(tool, contact.pose)
    for found in (scene.contacts(tool, contact.pose), tracker.contacts(contact.pose), way_out.contacts):
        assert len(found) == len(list(found)) > 1
        for i, plane in enumerate(found):
            assert isinstance(plane, feeler.ContactPlane) and repr(plane).startswith("ContactPlane(gap ")
            assert np.array_equal(plane.point, found.points[i]) and np.array_equal(plane.normal, found.normals[i])
            assert (plane.gap, plane.part, plane.id) == (found.gaps[i], found.parts[i], found.ids[i])
            count = found.footing_counts[i]
            assert 1 <= count <= 4 and np.array_equal(plane.footing, found.footing[i, :count])
            assert (found.footing[i, count:] == found.footing[i, count - 1]).all()
            for name in ("tool", "mockup"):
                offsets = getattr(found, f"{name}_offsets")
                ids = getattr(found, f"{name}_triangles")[int(offsets[i]) : int(offsets[i + 1])]
                assert np.array_equal(getattr(plane, f"{name}_triangles"), ids)
        assert found[-1].id == found.ids[-1]
        for index in (len(found), -len(found) - 1, sys.maxsize, -sys.maxsize - 1):
            with pytest.raises(IndexError, match="plane"):
                found[index]
    nothing = scene.contacts(tool, bench.shifted(10.0, 0, 0))
    assert not nothing and list(nothing) == [] and nothing.footing.shape == (0, 4, 3) and nothing.ids.shape == (0,)


@pytest.mark.parametrize("margin", [-0.001, float("nan"), float("inf"), "near", None, True])
def test_bad_margins(bench: ModuleType, margin: object) -> None:
    contact = bench.CASES["box in a plate"](1)
    scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
    tracker = feeler.ContactTracker(scene, tool)
    for ask in (
        lambda: scene.contacts(tool, contact.pose, margin),  # type: ignore[arg-type]
        lambda: scene.penetration(tool, contact.pose, margin),  # type: ignore[arg-type]
        lambda: tracker.contacts(contact.pose, margin),  # type: ignore[arg-type]
    ):
        with pytest.raises(feeler.OptionError, match="within"):
            ask()


def test_bad_arguments(bench: ModuleType) -> None:
    contact = bench.CASES["box in a plate"](1)
    scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
    with pytest.raises(feeler.PoseError):
        scene.contacts(tool, np.ones((4, 4)))
    with pytest.raises(feeler.PoseError):
        scene.contacts(tool, contact.pose, reference=np.ones((4, 4)))
    with pytest.raises(feeler.MeshError):
        scene.contacts("wrench", contact.pose)  # type: ignore[arg-type]
    with pytest.raises(feeler.MeshError):
        feeler.ContactTracker(scene, scene)  # type: ignore[arg-type]
    with pytest.raises(feeler.MeshError):
        feeler.ContactTracker(tool, tool)  # type: ignore[arg-type]
    with pytest.raises(feeler.PoseError):
        feeler.ContactTracker(scene, tool).contacts(np.zeros((3, 3)))


def test_the_quick_tables(
    bench: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bench, "PEERS", {})
    page = bench.PAGE.read_text(encoding="utf-8")
    assert bench.main(["--quick", "--only", "depths"]) == 0
    assert "tooth in its slot, turned" in capsys.readouterr().out
    assert bench.main(["--quick", "--only", "ways"]) == 0
    printed = capsys.readouterr().out
    assert f"{bench.WAYS[0]}\n{printed.splitlines()[0]}\n" in page, "the page has the columns of the table"
    table = [line.split("|")[1:-1] for line in printed.splitlines()]
    rows = [row for row in table if row and row[0].strip() in ("torque", "wrench", "square", "hand")]
    assert len(rows) == 4 and all(sum(int(x) for x in row[1:3]) == 10 for row in rows)


@pytest.mark.parametrize(("name", "kind"), [("torque", "nominal"), ("square", "nominal"), ("wrench", "deep")])
def test_every_part_that_is_met_has_a_plane(name: str, kind: str) -> None:
    """However the tool came there: a force that does not feel a part lets the tool through."""
    scene = feeler.Scene(feeler.sample("engine", 100_000))
    tool = feeler.sample_tool(name)
    asked = 0
    for pose in feeler.sample_poses(scene, tool, kind, 200):
        found = scene.contacts(tool, pose)
        if found.omitted or np.count_nonzero(found.gaps < 0) >= 12:
            continue
        met = scene.collide(tool, pose).parts
        assert set(met.tolist()) <= set(found.parts[found.gaps <= 0].tolist()), pose
        asked += len(met)
    assert asked > 100


def test_a_fill_that_leaks_out_of_a_solid_does_not_count() -> None:
    """A hand across a thin vane: were what the leaking fill found counted, the vane would be twice as deep in it."""
    scene = feeler.Scene(feeler.sample("engine", 100_000))
    pose = np.array(
        [
            [0.13138698, -0.98693067, 0.09330224, -0.31143477],
            [-0.95550272, -0.10100175, 0.27715194, -0.10723861],
            [-0.26410606, -0.1255647, -0.95628526, 0.57434058],
            [0, 0, 0, 1],
        ]
    )
    found = scene.contacts(feeler.sample_tool("hand"), pose)
    assert scene.mockup.parts[int(found.parts[0])].name.endswith("vane_005")
    assert -0.012 < found.gaps[0] < -0.011
