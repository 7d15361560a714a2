"""Swept volumes: closed, around the whole motion, nowhere farther than the error; refused where they cannot be."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from commands import error_of, run, run_json
from shapes import at, box, cube, inverted, joined

import feeler
from feeler.cli.swept import measures
from feeler.errors import LimitError, MeshError, OptionError, PoseError
from feeler.io import write_stl

Floats = npt.NDArray[np.float64]

BAR = feeler.Tool(*box((-0.1, -0.015, -0.01), (0.1, 0.015, 0.01)), name="bar")
WAYS: dict[str, list[Floats]] = {
    "straight": [at(), at(0.15, 0.05, 0.02)],
    "a turn": [at(), at(degrees=90), at(degrees=180)],
    "both": [at(), at(0.1, 0.02, 0.05, 70, axis=1), at(0.1, 0.1, 0.05, 120, axis=0)],
    "no way": [at(0.1, 0.2, 0.3, 30)],
    "far away": [at(1e4, -1e4, 1e4), at(1e4 + 0.1, -1e4, 1e4, 40)],
}


def assert_closed(mesh: feeler.Mockup) -> None:
    """Each edge belongs to two triangles, once each way."""
    faces = mesh.faces.astype(np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    one, other = (np.sort(edges[:, i] << 32 | edges[:, 1 - i]) for i in (0, 1))
    assert (np.diff(one) > 0).all()
    np.testing.assert_array_equal(one, other)


def assert_around(mesh: feeler.Mockup, tool: feeler.Tool, poses: list[Floats]) -> None:
    """The tool is in the mesh at the start, and meets it at no time: casts are never late."""
    scene = feeler.Scene(mesh)
    assert scene.containment(tool, poses[0]).containing.tolist() == [0]
    assert len(scene.check_path(tool, poses, tolerance=1e-9).segments) == 0


def assert_tight(mesh: feeler.Mockup, tool: feeler.Tool, poses: list[Floats], error: float) -> None:
    """Points of the mesh are within the error of the tool at one of many times."""
    corners = mesh.vertices[mesh.faces[:: max(1, mesh.triangle_count // 150)]]
    points = np.concatenate([corners[:, 0], corners.mean(axis=1)])
    size = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) * 1e-3 * error
    probes = [feeler.Tool(size, [[0, 1, 2]])]
    scene = feeler.Scene(feeler.Mockup(tool.vertices, tool.faces))
    least = np.full(len(points), np.inf)
    for pose in between(tool, poses, 0.1 * error):
        own = np.tile(np.eye(4), (len(points), 1, 1))
        own[:, :3, 3] = (points - pose[:3, 3]) @ pose[:3, :3]
        least = np.minimum(least, scene.distance_batch(probes[0], own, within=1.5 * error).values)
    # What lies between two times, and the size of the probe.
    assert least.max() <= 1.06 * error


def between(tool: feeler.Tool, poses: list[Floats], apart: float) -> list[Floats]:
    """Poses on the way of `tool` whose box's middle moves straight, every so many metres of its corners' way."""
    middle = np.append(tool.bounds.mean(axis=0), 1.0)
    reach = np.linalg.norm(np.ptp(tool.bounds, axis=0)) / 2
    found = [poses[0]]
    for first, last in pairwise(poses):
        turn = last[:3, :3] @ first[:3, :3].T
        axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        angle = np.arctan2(np.linalg.norm(axis) / 2, (np.trace(turn) - 1) / 2)
        x, y, z = axis / max(np.linalg.norm(axis), 1e-300)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        start, end = (first @ middle)[:3], (last @ middle)[:3]
        steps = int((np.linalg.norm(end - start) + reach * angle) / apart) + 1
        for share in np.arange(1, steps + 1) / steps:
            pose = np.eye(4)
            part = np.eye(3) + np.sin(share * angle) * cross + (1 - np.cos(share * angle)) * cross @ cross
            pose[:3, :3] = part @ first[:3, :3]
            pose[:3, 3] = start + share * (end - start) - pose[:3, :3] @ middle[:3]
            found.append(pose)
    return found


@pytest.mark.parametrize("name", WAYS)
def test_a_bar_on_its_way(name: str) -> None:
    poses, error = WAYS[name], 0.008
    mesh = feeler.swept(BAR, poses, error)
    assert_closed(mesh)
    assert_around(mesh, BAR, poses)
    assert_tight(mesh, BAR, poses, error)
    assert mesh.part_names == ("bar swept",) and mesh.report.not_queried == 0


def test_a_hand_and_a_wrench() -> None:
    for name, error in (("wrench", 0.006), ("hand", 0.012)):
        tool = feeler.sample_tool(name)
        poses = [at(), at(0.2, 0.1, 0.1, 40)]
        mesh = feeler.swept(tool, poses, error)
        assert_closed(mesh)
        assert_around(mesh, tool, poses)


def test_hollows_and_open_tools() -> None:
    outer, inner = cube((0, 0, 0), 0.1), inverted(cube((0, 0, 0), 0.06))
    shell, solid = feeler.Tool(*joined(outer, inner)), feeler.Tool(*outer)
    way = [at(), at(0.02)]
    hollow, full = (measures(feeler.swept(tool, way, 0.006))[0] for tool in (shell, solid))
    left = (0.06 - 0.02) * 0.06 * 0.06  # what the inner sides do not come to
    assert full - left < hollow < full - (0.04 - 0.012) * (0.06 - 0.012) ** 2
    square = feeler.Tool([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])
    volume, _ = measures(feeler.swept(square, [at(), at(0, 0, 0.05)], 0.006))
    assert 0.1 * 0.1 * 0.05 < volume < 0.112 * 0.112 * 0.062


def test_poses_that_repeat_and_threads_make_no_difference() -> None:
    first, last = WAYS["both"][:2]
    mesh = feeler.swept(BAR, [first, last], 0.01)
    for poses, threads in (([first, first, last, last], 1), ([first, last], 3)):
        other = feeler.swept(BAR, poses, 0.01, threads=threads)
        assert np.array_equal(mesh.vertices, other.vertices) and np.array_equal(mesh.faces, other.faces)


def test_progress_is_told_and_may_stop_it() -> None:
    told: list[tuple[float, str]] = []
    feeler.swept(BAR, WAYS["straight"], 0.008, progress=lambda done, stage: told.append((done, stage)))
    shares = [done for done, _ in told]
    assert shares == sorted(shares) and shares[-1] > 0.99
    assert {stage for _, stage in told} >= {"cutting the way into steps", "finding the surface"}

    class EnoughError(Exception):
        pass

    def stop(done: float, _stage: str) -> None:
        if done > 0.2:
            raise EnoughError

    with pytest.raises(EnoughError):
        feeler.swept(BAR, WAYS["straight"], 0.004, progress=stop)


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: feeler.swept(BAR, np.empty((0, 4, 4))), PoseError, "no pose"),
        (lambda: feeler.swept(BAR, [np.eye(4), np.diag([2.0, 1, 1, 1])]), PoseError, r"poses\[1\].*not rigid"),
        (lambda: feeler.swept(BAR, np.eye(4)), PoseError, "n, 4, 4"),
        (lambda: feeler.swept(BAR, [np.full((4, 4), np.nan)]), PoseError, r"poses\[0\]"),
        (lambda: feeler.swept(np.eye(4), [np.eye(4)]), MeshError, "feeler.Tool"),  # type: ignore[arg-type]
        (lambda: feeler.swept(BAR, [np.eye(4)], 0.0), OptionError, "error is 0"),
        (lambda: feeler.swept(BAR, [np.eye(4)], -1), OptionError, "error is -1"),
        (lambda: feeler.swept(BAR, [np.eye(4)], np.nan), OptionError, "error is nan"),
        (lambda: feeler.swept(BAR, [np.eye(4)], np.inf), OptionError, "error is inf"),
        (lambda: feeler.swept(BAR, [np.eye(4)], 10**400), OptionError, "error is beyond"),
        (lambda: feeler.swept(BAR, [np.eye(4)], "1mm"), OptionError, "error is '1mm'"),  # type: ignore[arg-type]
        (lambda: feeler.swept(BAR, [np.eye(4)], threads=0), OptionError, "threads is 0"),
        (lambda: feeler.swept(BAR, [np.eye(4)], memory_limit=-1), OptionError, "memory_limit is -1"),
        (lambda: feeler.swept(BAR, [np.eye(4)], progress=3), OptionError, "progress is 3"),  # type: ignore[arg-type]
    ],
)
def test_bad_input(call: Callable[[], Any], error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        call()


@pytest.mark.parametrize("error", [1e-5, 1e-8, 1e-14, 1e-300])
def test_an_error_that_is_too_small_is_refused_with_one_that_fits(error: float) -> None:
    poses, limit = WAYS["both"], 50_000_000
    with pytest.raises(LimitError, match="choose at least") as raised:
        feeler.swept(BAR, poses, error, memory_limit=limit)
    least = float(str(raised.value).split("at least ")[1].split(" m")[0])
    assert error < least < 0.1
    assert feeler.swept(BAR, poses, 1.06 * least, memory_limit=limit).triangle_count > 0


def test_far_coordinates_bound_the_error() -> None:
    small = feeler.Tool(*cube((0, 0, 0), 0.001))
    with pytest.raises(LimitError, match="exact"):
        feeler.swept(small, [at(1e7), at(1e7, degrees=20)], 1e-5)


@pytest.fixture
def files(tmp_path: Path) -> Path:
    write_stl(tmp_path / "bar.stl", BAR)
    np.save(tmp_path / "way.npy", np.array(WAYS["both"]))
    (tmp_path / "way.json").write_text(json.dumps({"poses": np.array(WAYS["both"]).tolist()}))
    return tmp_path


def test_the_command_writes_what_it_says(files: Path) -> None:
    words = ("swept", files / "bar.stl", "--error", "8mm")
    for ending in ("stl", "glb"):
        out = files / f"swept.{ending}"
        said = run_json(*words, "--poses", files / "way.npy", "--out", out)
        assert said["error_m"] == pytest.approx(0.008) and said["poses"] == 3 and said["bytes"] == out.stat().st_size
        read = feeler.load_mockup(out)
        assert read.triangle_count == said["triangles"] > 1000
        assert said["volume_m3"] == pytest.approx(measures(read)[0], rel=1e-4)
    text = run(*words, "--poses", files / "way.json").stdout
    assert f"{said['triangles']:,}" in text and "volume" in text and "8 mm at most" in text and "written" not in text


def test_the_command_refuses_bad_input(files: Path) -> None:
    words = ("swept", files / "bar.stl", "--poses", files / "way.npy")
    assert "--error is '1 parsec'" in error_of(*words, "--error", "1 parsec")
    assert "--error is '-1mm': give a length above 0," in error_of(*words, "--error", "-1mm")
    assert "choose at least" in error_of(*words, "--error", "1e-14")
    assert "must end in .glb or .stl" in error_of(*words, "--out", files / "swept.step")
    assert "does not exist" in error_of("swept", files / "bar.stl", "--poses", files / "none.npy")
    assert "no such file" in error_of("swept", files / "none.stl", "--poses", files / "way.npy")


def test_an_stl_far_away_is_warned_of(files: Path) -> None:
    np.save(files / "far.npy", np.array(WAYS["far away"]))
    words = ("swept", files / "bar.stl", "--poses", files / "far.npy", "--error", "8mm", "--out")
    assert "rounded" in run(*words, files / "far.stl").stderr
    assert "rounded" not in run(*words, files / "far.glb").stderr
