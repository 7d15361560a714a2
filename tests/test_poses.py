"""Poses that rounding made not quite rigid: refused by queries, repaired by `nearest_rigid` and `--snap-pose`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import feeler
from feeler.cli.app import app
from feeler.poses import rotation_xyz

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
ALL_FACES = [*FACES, [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]


def turned(rx: float, ry: float, rz: float, at: tuple[float, float, float] = (0.1, -2.0, 3.0)) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_xyz(rx, ry, rz)
    matrix[:3, 3] = at
    return matrix


def rounded(decimals: int) -> np.ndarray:
    """By 10, 20 and 30 degrees, as a log prints it; with four decimals the first row has length 1.0000068."""
    return turned(10, 20, 30).round(decimals)


def queries() -> dict[str, Callable[[np.ndarray], Any]]:
    scene = feeler.Scene(feeler.Mockup(CUBE, ALL_FACES))
    tool = feeler.Tool(CUBE * 0.2, ALL_FACES)
    one = {name: getattr(scene, name) for name in ("collide", "is_colliding", "distance", "clearance", "contacts")}
    many = {name: getattr(scene, name) for name in ("collide_batch", "distance_batch", "clearance_batch", "check_path")}
    return {
        **{name: lambda pose, ask=ask: ask(tool, pose) for name, ask in one.items()},
        **{name: lambda pose, ask=ask: ask(tool, [np.eye(4), pose]) for name, ask in many.items()},
        "penetration": lambda pose: scene.penetration(tool, pose),
        "cast": lambda pose: scene.cast(tool, np.eye(4), pose),
        "reference": lambda pose: scene.contacts(tool, np.eye(4), reference=pose),
        "tracker": lambda pose: feeler.ContactTracker(scene, tool).contacts(pose),
    }


QUERIES = queries()


@pytest.mark.parametrize("name", sorted(QUERIES))
def test_every_query_says_how_to_repair_rounding(name: str) -> None:
    ask = QUERIES[name]
    with pytest.raises(feeler.PoseError, match=r"has length 1\.0000068, not 1 .*feeler\.nearest_rigid\(pose\) repairs"):
        ask(rounded(4))
    ask(feeler.nearest_rigid(rounded(4)))
    for wrong in (np.diag([2.0, 2.0, 2.0, 1.0]), np.diag([1.0, 1.0, -1.0, 1.0]), np.full((4, 4), np.nan)):
        with pytest.raises(feeler.PoseError) as refused:
            ask(wrong)
        assert "nearest_rigid" not in str(refused.value)


@pytest.mark.parametrize("decimals", [3, 4, 5, 6, 9])
def test_decimals_are_repaired(decimals: int) -> None:
    exact, given_pose = turned(10, 20, 30), rounded(decimals)
    repaired = feeler.nearest_rigid(given_pose)
    assert repaired.dtype == np.float64 and repaired.shape == (4, 4)
    assert np.abs(repaired - exact).max() <= 10.0**-decimals
    assert np.abs(repaired[:3, :3] @ repaired[:3, :3].T - np.eye(3)).max() < 1e-14
    assert np.linalg.det(repaired[:3, :3]) == pytest.approx(1.0, abs=1e-14)
    assert repaired[:3, 3].tolist() == given_pose[:3, 3].tolist() and repaired[3].tolist() == [0, 0, 0, 1]


@given(st.lists(st.floats(-180, 180), min_size=3, max_size=3), st.integers(0, 2**32 - 1))
def test_no_rotation_is_nearer(angles: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    rough = turned(*angles)
    rough[:3, :3] += rng.uniform(-1e-3, 1e-3, (3, 3))
    found = feeler.nearest_rigid(rough)
    assert np.array_equal(feeler.nearest_rigid(found), found)
    far = np.linalg.norm(found - rough)
    for turn in rng.uniform(-0.05, 0.05, (20, 3)):
        other = found[:3, :3] @ rotation_xyz(*turn)
        assert np.linalg.norm(other - rough[:3, :3]) >= far - 1e-12


def test_what_is_rigid_stays_as_it_is() -> None:
    poses = np.array([turned(*angles) for angles in ((0, 0, 0), (10, 20, 30), (90, 0, 180), (-77.3, 12.5, 1e-7))])
    assert np.array_equal(feeler.nearest_rigid(poses), poses)
    assert feeler.nearest_rigid(poses) is not poses


def test_many_at_once() -> None:
    poses = np.array([turned(10, 20, 30), rounded(4), rounded(3)])
    repaired = feeler.nearest_rigid(poses.astype(np.float32))
    assert repaired.shape == (3, 4, 4) and np.abs(repaired - poses).max() < 1e-3
    assert np.array_equal(repaired[1], feeler.nearest_rigid(poses[1].astype(np.float32)))
    assert feeler.nearest_rigid(np.empty((0, 4, 4))).shape == (0, 4, 4)
    poses[2, 0, 0] = 3.0
    with pytest.raises(feeler.PoseError, match=r"poses\[2\] is not rigid"):
        feeler.nearest_rigid(poses)


def test_a_last_row_that_is_nearly_right_is_set() -> None:
    pose = turned(10, 20, 30)
    pose[3] = 1e-5, 0, -1e-6, 0.9999
    assert feeler.nearest_rigid(pose)[3].tolist() == [0, 0, 0, 1]
    with pytest.raises(feeler.PoseError, match=r"deviates by 0\.5"):
        feeler.nearest_rigid(np.diag([1.0, 1.0, 1.0, 0.5]))


@pytest.mark.parametrize(
    ("matrix", "deviation"),
    [
        (np.diag([2.0, 2.0, 2.0, 1.0]), "3"),
        (np.diag([1.01, 1.01, 1.01, 1.0]), "0.0201"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "2"),
        (np.array([[1, 0.05, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]), "0.05"),
        (np.zeros((4, 4)), "1"),
        (np.diag([1e200, 1.0, 1.0, 1.0]), "inf"),
    ],
)
def test_what_is_no_rounding_is_refused(matrix: np.ndarray, deviation: str) -> None:
    with pytest.raises(feeler.PoseError, match=rf"it deviates by {deviation} \(max_deviation is 0\.01\)"):
        feeler.nearest_rigid(matrix)


def test_more_may_be_allowed() -> None:
    assert np.array_equal(feeler.nearest_rigid(np.diag([2.0, 2.0, 2.0, 1.0]), 3.0), np.eye(4))
    of_a_mirror = feeler.nearest_rigid(np.diag([1.0, 1.0, -0.9, 1.0]), 2.0)
    assert np.allclose(of_a_mirror, np.eye(4)), "proper, and nearer than half turns"
    with pytest.raises(feeler.PoseError, match="on one line"):
        feeler.nearest_rigid(np.diag([1.0, 0.0, 0.0, 1.0]), np.inf)


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(3), r"shape \(3, 3\)"),
        (np.zeros((2, 2, 4, 4)), r"shape \(2, 2, 4, 4\)"),
        ([["a"] * 4] * 4, "real numbers"),
        ([[1.0], [1.0, 2.0]], "cannot be read"),
        (np.eye(4, dtype=complex), "real numbers"),
        (np.full((4, 4), np.inf), r"the pose: entry \[0, 0\] is inf"),
        ([np.eye(4), np.diag([1, np.nan, 1, 1])], r"poses\[1\]: entry \[1, 1\] is nan"),
    ],
)
def test_what_is_no_pose_is_refused(pose: Any, message: str) -> None:
    with pytest.raises(feeler.PoseError, match=message):
        feeler.nearest_rigid(pose, np.inf)


@pytest.mark.parametrize("deviation", [-1.0, np.nan, "0.1", True])
def test_max_deviation_is_checked(deviation: Any) -> None:
    with pytest.raises(feeler.OptionError, match="max_deviation"):
        feeler.nearest_rigid(np.eye(4), deviation)


COMMANDS = {
    "collide": ["--pose"],
    "clearance": ["--pose"],
    "path": ["--poses"],
}


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_the_command_line_snaps(command: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.txt"
    np.savetxt(file, rounded(4), fmt="%.4f")
    words = [command, "sample:differential:10000", "--tool", "sample:wrench", *COMMANDS[command], str(file), "--json"]
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2 and "--snap-pose" in refused.output
    done = CliRunner().invoke(app, [*words, "--snap-pose"])
    assert done.exit_code in (0, 1), done.output
    if command != "path":
        used = np.array(json.loads(done.stdout)["poses"][0]["world_from_tool"])
        assert np.array_equal(used, feeler.nearest_rigid(rounded(4)))
    np.savetxt(file, np.diag([2.0, 2.0, 2.0, 1.0]))
    scaled = CliRunner().invoke(app, [*words, "--snap-pose"])
    assert scaled.exit_code == 2 and "robot.txt" in scaled.output and "not rigid" in scaled.output


class Transform:
    """As SciPy's `RigidTransform` and `Rotation` are."""

    def __init__(self, matrix: np.ndarray) -> None:
        self._matrix = matrix

    def as_matrix(self) -> np.ndarray:
        return self._matrix


def test_poses_of_other_libraries_are_read() -> None:
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = 0.1, 0.2, 0.3
    turn, shift = pose[:3, :3], pose[:3, 3]
    scene = feeler.Scene(feeler.sample("differential", 10_000))
    tool = feeler.sample_tool("wrench")
    expected = scene.distance(tool, pose).value
    kinds: dict[str, Any] = {
        "pair": (turn, shift),
        "lists": (turn.tolist(), shift.tolist()),
        "transform": Transform(pose),
        "rotation and translation": (Transform(turn), shift),
        "rows": pose.tolist(),
    }
    for name, kind in kinds.items():
        assert scene.distance(tool, kind).value == expected, name
        assert feeler.nearest_rigid(kind).tolist() == pose.tolist(), name
        assert scene.cast(tool, kind, kind) is None, name
        assert scene.distance_batch(tool, [kind, kind]).values.tolist() == [expected] * 2, name
        assert scene.check_path(tool, [kind, feeler.Screw([0, 0, 1], [0, 0, 0], 0.1)]).poses.shape[1:] == (4, 4), name
        session = feeler.haptics.Session(scene, tool)
        session.start(kind)
        assert session.step(kind).world_from_proxy.tolist() == pose.tolist(), name
    both = Transform(np.stack([pose, pose]))
    assert scene.distance_batch(tool, both).values.tolist() == [expected] * 2
    assert feeler.nearest_rigid((pose, pose)).shape == (2, 4, 4)
    for wrong in ((turn, pose), (shift, turn), Transform(turn), (Transform(pose), shift)):
        with pytest.raises(feeler.PoseError, match=r"shape"):
            scene.distance(tool, wrong)
