"""Casts and paths in Python and on the command line: what comes back, in which shape, and what is refused."""

from __future__ import annotations

import json
import math
import pickle
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import feeler
from feeler.cli import app
from feeler.io import write_stl

STORES = ("blocks", "dense", "hashed")


def box(size: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """A box about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners * size, np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])


def at(x: float, y: float, z: float, turn_z: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(turn_z), -math.sin(turn_z)], [math.sin(turn_z), math.cos(turn_z)]]
    pose[:3, 3] = x, y, z
    return pose


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    """A floor at z = 0 and a wall at x = 1, both without thickness."""
    floor = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    wall = np.array([[1, -1, 0.1], [1, 1, 0.1], [1, 1, 1], [1, -1, 1]], float)
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return feeler.Mockup(
        np.concatenate([floor, wall]), np.concatenate([faces, faces + 4]), [0, 0, 1, 1], ["floor", "wall"]
    )


@pytest.fixture(scope="module", params=STORES)
def scene(request: pytest.FixtureRequest, mockup: feeler.Mockup) -> feeler.Scene:
    return feeler.Scene(mockup, storage=request.param, voxel_size=0.25)


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    return feeler.Tool(*box((0.2, 0.1, 0.1)))


def test_a_fall_ends_on_the_floor(scene: feeler.Scene, tool: feeler.Tool) -> None:
    hit = scene.cast(tool, at(0, 0, 0.55), at(0, 0, -1.45))
    assert hit is not None
    assert hit.fraction == pytest.approx(0.25, abs=1e-6) and hit.fraction <= 0.25
    assert hit.pose.shape == (4, 4) and hit.pose[2, 3] >= 0.05
    assert hit.point.shape == hit.normal.shape == (3,)
    np.testing.assert_allclose(hit.normal, [0, 0, 1], atol=1e-9)
    assert abs(hit.point[2]) < 1e-9 and np.all(np.abs(hit.point[:2]) <= 0.11)
    assert hit.part == 0 and hit.mockup_triangle in (0, 1) and 0 <= hit.distance <= 1e-6
    assert not scene.is_colliding(tool, hit.pose) or hit.distance == 0
    assert repr(hit).startswith("Cast(fraction=0.2")


def test_a_free_way_is_none(scene: feeler.Scene, tool: feeler.Tool) -> None:
    assert scene.cast(tool, at(-3, 0, 0.3), at(0.8, 0, 0.3)) is None
    assert scene.cast(tool, at(0, 0, 0.2), at(0, 0, 0.2)) is None
    assert scene.cast(tool, at(0, 0, 9), at(7, 0, 9)) is None


def test_a_turn_sweeps_the_wall(scene: feeler.Scene, tool: feeler.Tool) -> None:
    # Lying along y, 0.07 m from the wall; a quarter turn brings the long side across.
    hit = scene.cast(tool, at(0.93, 0, 0.5, math.pi / 2), at(0.93, 0, 0.5, 0))
    assert hit is not None and hit.part == 1
    # The corner (0.1, 0.05) turns into the plane 0.07 m away.
    angle = math.acos(0.07 / math.hypot(0.1, 0.05)) + math.atan2(0.05, 0.1)
    assert hit.fraction == pytest.approx(1 - angle / (math.pi / 2), abs=1e-4)
    np.testing.assert_allclose(hit.normal, [-1, 0, 0], atol=1e-6)


def test_a_start_in_contact_is_an_impact_at_zero(scene: feeler.Scene, tool: feeler.Tool) -> None:
    for pose in (at(0, 0, 0), at(0, 0, 0.05), at(1, 0, 0.5)):
        hit = scene.cast(tool, pose, at(0, 0, 5))
        assert hit is not None and hit.fraction == 0.0
        np.testing.assert_array_equal(hit.pose, pose)


def test_nothing_is_later_than_the_first_sampled_collision(scene: feeler.Scene, tool: feeler.Tool) -> None:
    random = np.random.default_rng(5)
    sampled = 0
    for _ in range(30):
        a, b = (at(*random.uniform([-0.8, -0.8, 0.1], [1.5, 0.8, 0.9]), random.uniform(-3, 3)) for _ in range(2))
        b[2, 3] = random.uniform(-0.5, 0.5)
        hit = scene.cast(tool, a, b)
        turn = math.remainder(math.atan2(b[1, 0], b[0, 0]) - math.atan2(a[1, 0], a[0, 0]), 2 * math.pi)
        start = math.atan2(a[1, 0], a[0, 0])
        times = np.linspace(0, 1, 200)
        poses = np.array([at(*(a[:3, 3] + t * (b - a)[:3, 3]), start + t * turn) for t in times])
        counts = np.diff(scene.collide_batch(tool, poses).offsets.astype(np.int64))
        if counts.any():
            sampled += 1
            first = times[np.flatnonzero(counts)[0]]
            assert hit is not None and hit.fraction <= first + 1e-12
    assert sampled > 10


def test_tolerances_and_poses_are_checked(scene: feeler.Scene, tool: feeler.Tool) -> None:
    a, b = at(0, 0, 1), at(0, 0, -1)
    for bad in (0, -1e-6, math.nan, math.inf, "1", None, True, 10**400):
        with pytest.raises(feeler.OptionError, match="tolerance"):
            scene.cast(tool, a, b, tolerance=bad)  # type: ignore[arg-type]
        with pytest.raises(feeler.OptionError, match="tolerance"):
            scene.check_path(tool, [a, b], tolerance=bad)  # type: ignore[arg-type]
    for wrong in (np.zeros((4, 4)), np.full((4, 4), np.nan), np.eye(3), "pose"):
        with pytest.raises(feeler.PoseError):
            scene.cast(tool, a, wrong)  # type: ignore[arg-type]
        with pytest.raises(feeler.PoseError):
            scene.cast(tool, wrong, b)  # type: ignore[arg-type]
    with pytest.raises(feeler.PoseError, match="no pose"):
        scene.check_path(tool, np.zeros((0, 4, 4)))
    with pytest.raises(feeler.PoseError, match=r"poses\[1\]"):
        scene.check_path(tool, [a, 2 * a])
    with pytest.raises(feeler.MeshError):
        scene.cast("tool", a, b)  # type: ignore[arg-type]


def test_a_path_is_a_row_of_casts(scene: feeler.Scene, tool: feeler.Tool) -> None:
    poses = np.array([at(-3, 0, 0.3), at(0, 0, 0.3), at(0, 0, -0.3), at(0.9, 0, 0.4, 1.5), at(0, 0, 0.4)])
    check = scene.check_path(tool, poses)
    casts = [scene.cast(tool, a, b) for a, b in pairwise(poses)]
    assert not check.is_free and len(check) == 4
    assert [hit is None for hit in casts] == np.isnan(check.fractions).tolist()
    hits = [(i, hit) for i, hit in enumerate(casts) if hit is not None]
    assert check.segments.tolist() == [i for i, _ in hits] and len(hits) >= 2
    for row, (i, hit) in enumerate(hits):
        assert check.fractions[i] == hit.fraction
        assert check.parts[row] == hit.part
        assert check.tool_triangles[row] == hit.tool_triangle and check.mockup_triangles[row] == hit.mockup_triangle
        np.testing.assert_array_equal(check.points[row], hit.point)
        np.testing.assert_array_equal(check.normals[row], hit.normal)
        np.testing.assert_array_equal(check.poses[row], hit.pose)
    assert check.first is not None and check.first.fraction == hits[0][1].fraction
    assert repr(check) == f"PathCheck(4 segments, {len(hits)} hit)"


def test_a_free_path_and_a_path_of_one_pose(scene: feeler.Scene, tool: feeler.Tool) -> None:
    check = scene.check_path(tool, [at(0, 0, 0.3), at(0.2, 0, 0.3), at(0.2, 0, 0.5, 1)])
    assert check.is_free and check.first is None and np.isnan(check.fractions).all() and check.fractions.shape == (2,)
    assert check.points.shape == (0, 3) and check.poses.shape == (0, 4, 4)
    assert scene.check_path(tool, [at(0, 0, 0.3)]).is_free
    once = scene.check_path(tool, [at(0, 0, 0.02)])
    assert not once.is_free and once.fractions.tolist() == [0.0]


def test_a_long_path_tells_how_far_it_is_and_stops_when_asked(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup, threads=2)
    poses = np.array([at(0, 0, 0.5 + 0.3 * math.sin(i)) for i in range(20_000)])
    told: list[float] = []
    assert scene.check_path(tool, poses, progress=lambda done, stage: told.append(done)).is_free
    assert told == sorted(told) and told[-1] == 1.0 and len(told) > 5

    told.clear()

    def stop(done: float, stage: str) -> None:
        told.append(done)
        if done > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        scene.check_path(tool, poses, progress=stop)
    assert told[-1] < 0.5, "nothing is done after the interrupt"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory, mockup: feeler.Mockup, tool: feeler.Tool) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("path")
    write_stl(folder / "mockup.stl", mockup)
    write_stl(folder / "tool.stl", tool)
    poses = np.array([at(0, 0, 0.5), at(0.2, 0, 0.5), at(0.2, 0, -0.5)])
    np.save(folder / "hits.npy", poses)
    (folder / "free.json").write_text(json.dumps(poses[:2].tolist()))
    (folder / "hits.csv").write_text("\n".join(",".join(map(str, pose.ravel())) for pose in poses))
    return {path.name: path for path in folder.iterdir()} | {"folder": folder}


def run(files: dict[str, Path], poses: str, *words: str | Path, code: int) -> Any:
    start = ["path", files["mockup.stl"], "--tool", files["tool.stl"], "--poses", files.get(poses, Path(poses))]
    result = CliRunner().invoke(app, [str(word) for word in (*start, *words)])
    assert result.exit_code == code, f"{result.output}\n{result.exception!r}"
    return result


def test_the_command_says_where_a_path_is_blocked(files: dict[str, Path]) -> None:
    text = run(files, "hits.npy", code=1).stdout
    assert "not free" in text and "1 of 2 segments" in text and "mockup" in text
    assert "The path is free" in run(files, "free.json", code=0).stdout
    table, scene = files["folder"] / "hits.out.csv", files["folder"] / "hits.glb"
    said = json.loads(run(files, "hits.csv", "--json", "--csv", table, "--glb", scene, code=1).stdout)
    assert (said["free"], said["segments"], said["segments_hit"]) == (False, 2, 1)
    (hit,) = said["hits"]
    assert hit["segment"] == 1 and hit["fraction"] == pytest.approx(0.45, abs=1e-5)
    assert said["parts"][0]["segments"] == 1 and np.shape(hit["world_from_tool"]) == (4, 4)
    lines = table.read_text().splitlines()
    assert len(lines) == 2 and lines[1].startswith("1,0.4") and scene.stat().st_size > 500
    assert json.loads(run(files, "free.json", "--json", code=0).stdout)["hits"] == []


def test_the_command_refuses_what_it_cannot_use(files: dict[str, Path]) -> None:
    for words in (
        ["--tolerance", "0"],
        ["--csv", files["folder"] / "x.txt"],
        ["--glb", files["folder"] / "no" / "x.glb"],
    ):
        result = run(files, "hits.npy", *words, code=2)
        assert result.stdout == "" and result.stderr.startswith("feeler: ")
    assert "does not exist" in run(files, "none.npy", code=2).stderr


def test_a_door_swings_to_the_wall(scene: feeler.Scene, tool: feeler.Tool) -> None:
    """The box's far edge, 0.1 from the middle, is 0.6 from the hinge; turned by 90 degrees it is at the wall, x = 1."""
    hinge = feeler.Screw((0, 0, 5), (0.4, 0, 0), -math.pi / 2)
    hit = scene.cast(tool, at(0.4, 0.55, 0.5), screw=hinge, tolerance=1e-11)
    assert hit is not None
    # the corner at (0.1, 0.05) from the middle: at 0.1, 0.6 from the hinge, so x is 0.6 first where atan2 says
    reach, lean = math.hypot(0.1, 0.6), math.atan2(0.1, 0.6)
    assert hit.fraction * math.pi / 2 == pytest.approx(math.pi / 2 - lean - math.acos(0.6 / reach), abs=1e-9)
    assert scene.mockup.part_paths[hit.part] == "wall"
    assert np.allclose(hit.pose, hinge.at(at(0.4, 0.55, 0.5), hit.fraction), atol=1e-12)
    assert scene.cast(tool, at(0.4, 0.55, 0.5), screw=feeler.Screw((0, 0, 1), (0.4, 0, 0), math.pi / 2)) is None


def test_a_path_of_poses_and_screws(scene: feeler.Scene, tool: feeler.Tool) -> None:
    """Three turns down by 0.1 each, a pull, and a turn in the wall: only the last is hit."""
    down = feeler.Screw((0, 0, 1), (0, 0, 0), -6 * math.pi, 0.1)
    assert down.advance == pytest.approx(-0.3)
    path = [at(0, 0, 0.8), down, at(0.8, 0, 0.5, math.pi / 2), feeler.Screw((0, 0, 1), (0.8, 0, 0), math.pi / 2)]
    path.append(at(0.95, 0, 0.5))
    check = scene.check_path(tool, path)
    assert len(check) == 4 and check.segments.tolist() == [3]
    too_far = feeler.Screw((0, 0, 1), (0, 0, 0), -6 * math.pi, 0.3)
    (fraction,) = scene.check_path(tool, [at(0, 0, 0.5), too_far]).fractions
    assert 0.49 < fraction <= 0.5
    assert not scene.check_path(tool, [at(0, 0, 0.5), too_far], touching="free").is_free
    with pytest.raises(feeler.PoseError, match="begins with a pose"):
        scene.check_path(tool, [down, at(0, 0, 1)])
    with pytest.raises(feeler.PoseError):
        scene.check_path(tool, [at(0, 0, 1), down, np.eye(3)])


def test_screws_are_values(scene: feeler.Scene, tool: feeler.Tool) -> None:
    screw = feeler.Screw(np.array([0, 3, 0]), [1, 2, 3], 0.5, pitch=0.002)
    assert screw.axis == (0.0, 1.0, 0.0) and screw.point == (1.0, 2.0, 3.0) and screw.pitch == 0.002
    again = pickle.loads(pickle.dumps(screw))
    assert again == screw and hash(again) == hash(screw) and eval(repr(screw), {"Screw": feeler.Screw}) == screw
    assert screw != screw.reversed() and screw.reversed().reversed() == screw and screw != "screw"
    back = screw.reversed().at(screw.at(at(1, 1, 1, 0.3)))
    assert np.allclose(back, at(1, 1, 1, 0.3), atol=1e-12)
    for axis, point, angle, pitch, what in [
        ((0, 0, 0), (0, 0, 0), 1, 0, "axis"),
        ((0, 0, math.nan), (0, 0, 0), 1, 0, "axis"),
        ("up", (0, 0, 0), 1, 0, "axis"),
        ((0, 0, 1, 0), (0, 0, 0), 1, 0, "axis"),
        ((0, 0, 1), None, 1, 0, "point"),
        ((0, 0, 1), (0, 0, 0), "far", 0, "angle"),
        ((0, 0, 1), (0, 0, 0), 1e4, 0, "angle"),
        ((0, 0, 1), (0, 0, 0), 1, math.inf, "pitch"),
    ]:
        with pytest.raises(feeler.OptionError, match=what):
            feeler.Screw(axis, point, angle, pitch)  # type: ignore[arg-type]
    for wrong in ({}, {"end": at(0, 0, 1), "screw": screw}, {"screw": at(0, 0, 1)}):
        with pytest.raises(feeler.OptionError, match="screw"):
            scene.cast(tool, at(0, 0, 1), **wrong)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="fraction is nan"):
        screw.at(np.eye(4), math.nan)
