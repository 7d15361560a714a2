"""Clearance and distance: shapes, conventions, the command; the numbers are held to exact arithmetic in Rust."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from typer.testing import CliRunner

import feeler
from feeler.cli.app import app

Floats = npt.NDArray[np.float64]

STORES: list[dict[str, Any]] = [{"storage": "blocks"}, {"storage": "dense"}, {"storage": "hashed", "hashing": 0.5}]
stores = pytest.mark.parametrize("store", STORES, ids=["blocks", "dense", "hashed"])

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
SIDES = np.array([face for a, b, c, d in QUADS for face in ([a, b, c], [a, c, d])])


def at(x: float, y: float = 0.0, z: float = 0.0) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    """Three unit cubes along x, 2 m from one to the next; the second part is empty."""
    vertices = np.vstack([CUBE + np.array([3.0 * i, 0, 0]) for i in range(3)])
    faces = np.vstack([SIDES + 8 * i for i in range(3)])
    part = np.repeat([0, 2, 3], len(SIDES))
    return feeler.Mockup(vertices, faces, part, ["first", "ghost", "second", "third"])


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    """A cube of 0.5 m."""
    return feeler.Tool(0.5 * CUBE, SIDES, name="die")


def is_on(point: Floats, corners: Floats) -> bool:
    """Whether a point lies on a triangle: a mean of its corners, with weights from 0 to 1."""
    equations, target = np.vstack([corners.T, np.ones(3)]), np.append(point, 1.0)
    weights = np.linalg.lstsq(equations, target, rcond=None)[0]
    return bool(np.abs(equations @ weights - target).max() < 1e-12 and weights.min() > -1e-12)


@stores
def test_distance_of_cubes(mockup: feeler.Mockup, tool: feeler.Tool, store: dict[str, Any]) -> None:
    scene = feeler.Scene(mockup, **store)
    d = scene.distance(tool, at(1.25, 0.25, 0.25))
    assert d.value == 0.25 and d.part == 0
    assert d.point_on_tool is not None and d.point_on_mockup is not None
    assert d.point_on_tool[0] == 1.25 and d.point_on_mockup[0] == 1.0
    assert np.linalg.norm(d.point_on_tool - d.point_on_mockup) == d.value
    assert d.tool_triangle is not None and d.mockup_triangle is not None
    assert is_on(d.point_on_tool - [1.25, 0.25, 0.25], tool.vertices[tool.faces[d.tool_triangle]])
    assert is_on(d.point_on_mockup, mockup.vertices[mockup.faces[d.mockup_triangle]])
    rows = scene.nearest(tool, at(1.25, 0.25, 0.25), 5)
    assert isinstance(rows, list)
    assert [(row.part, row.value) for row in rows] == [(0, 0.25), (2, 1.25), (3, 4.25)]
    assert scene.distance(tool, at(0.75)).value == 0.0, "the surfaces meet"
    assert scene.distance(tool, at(0.25, 0.25, 0.25)).value == 0.25, "inside: surfaces, not solids"
    assert scene.distance(tool, at(1e9)).value == pytest.approx(1e9 - 7, rel=1e-15)


@stores
def test_clearance_of_cubes(mockup: feeler.Mockup, tool: feeler.Tool, store: dict[str, Any]) -> None:
    scene = feeler.Scene(mockup, **store)
    near = scene.clearance(tool, at(1.25, 0.25, 0.25), within=1.25)
    assert near.parts.tolist() == [0, 2] and near.distances.tolist() == [0.25, 1.25]
    assert (near.points_on_tool.shape, near.points_on_mockup.shape) == ((2, 3), (2, 3))
    assert (near.parts.dtype, near.tool_triangles.dtype, near.mockup_triangles.dtype) == (np.uint32,) * 3
    assert mockup.part_of_face[near.mockup_triangles].tolist() == [0, 2]
    pairs = scene.clearance(tool, at(1.25, 0.25, 0.25), within=0.25, triangles=True)
    assert len(pairs) >= 2 and set(pairs.distances.tolist()) == {0.25}
    assert len(scene.clearance(tool, at(1.5, 0.25, 0.25))) == 0, "5 mm unless asked otherwise"
    assert len(scene.clearance(tool, at(1e9), within=np.inf)) == 3


def test_nothing_within_max(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup)
    d = scene.distance(tool, at(1.5), within=0.25)
    assert d.value == np.inf
    for name in ("point_on_tool", "point_on_mockup", "tool_triangle", "mockup_triangle", "part"):
        assert getattr(d, name) is None
    assert scene.nearest(tool, at(1.5), 2, within=0.25) == []
    assert scene.distance(tool, at(1.5), within=0.5).value == 0.5, "max itself is within"


@pytest.mark.parametrize("threads", [1, 2])
def test_batches_are_as_single_queries(mockup: feeler.Mockup, tool: feeler.Tool, threads: int) -> None:
    scene = feeler.Scene(mockup, threads=threads)
    poses = np.stack([at(0.1 * i - 2.0, 0.3, 0.2) for i in range(90)])
    told: list[float] = []
    distances = scene.distance_batch(tool, poses, within=1.0, progress=lambda done, stage: told.append(done))
    assert told[-1] == 1.0 and len(distances) == 90
    clearances = scene.clearance_batch(tool, poses, within=1.0)
    assert len(clearances) == 90 and clearances.offsets.dtype == np.uint64
    assert distances.points_on_tool.shape == distances.points_on_mockup.shape == (90, 3)
    for i, pose in enumerate(poses):
        one, near = scene.distance(tool, pose, within=1.0), scene.clearance(tool, pose, within=1.0)
        assert distances.values[i] == one.value == distances[i].value
        assert clearances[i].distances.tolist() == near.distances.tolist()
        assert clearances[i].parts.tolist() == near.parts.tolist()
        if one.part is None:
            assert distances.parts[i] == distances.tool_triangles[i] == distances.mockup_triangles[i] == -1
            assert np.isnan(distances.points_on_tool[i]).all() and len(near) == 0
        else:
            assert near.distances[0] == one.value
            if one.value > 0.0:
                assert (near.tool_triangles[0], near.mockup_triangles[0]) == (one.tool_triangle, one.mockup_triangle)
    assert np.isinf(distances.values).any() and (distances.values == 0.0).any()
    assert len(scene.distance_batch(tool, np.zeros((0, 4, 4)))) == 0
    with pytest.raises(IndexError):
        distances[90]


def test_bad_arguments(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene: Any = feeler.Scene(mockup, memory_limit=1 << 17)
    for bad in (-1.0, np.nan, -np.inf, "far", None, True):
        for query in (
            lambda bad: scene.distance(tool, at(0), within=bad),
            lambda bad: scene.nearest(tool, at(0), 2, within=bad),
            lambda bad: scene.clearance(tool, at(0), within=bad),
            lambda bad: scene.clearance(tool, at(0), within=bad, triangles=True),
            lambda bad: scene.distance_batch(tool, at(0)[None], within=bad),
            lambda bad: scene.clearance_batch(tool, at(0)[None], within=bad),
        ):
            with pytest.raises(feeler.OptionError):
                query(bad)
    for k in (0, -1, 1.5, 2**40):
        with pytest.raises(feeler.OptionError, match="k is"):
            scene.nearest(tool, at(0), k)
    with pytest.raises(feeler.PoseError):
        scene.distance(tool, 2.0 * np.eye(4))
    with pytest.raises(feeler.PoseError):
        scene.clearance(tool, np.eye(3))
    with pytest.raises(feeler.MeshError):
        scene.distance(mockup, at(0))
    with pytest.raises(feeler.LimitError, match="within this distance"):
        scene.clearance_batch(tool, np.tile(at(0), (100, 1, 1)), within=np.inf, triangles=True)
    with pytest.raises(feeler.PoseError, match=r"poses\[1\]"):
        scene.distance_batch(tool, np.stack([at(0), 2.0 * np.eye(4)]))


# --- the command ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory, mockup: feeler.Mockup, tool: feeler.Tool) -> tuple[str, str]:
    from feeler.io import write_glb

    folder = tmp_path_factory.mktemp("clearance")
    write_glb(folder / "cubes.glb", mockup)
    write_glb(folder / "die.glb", tool)
    return str(folder / "cubes.glb"), str(folder / "die.glb")


def run(*words: object, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["clearance", *map(str, words)])
    assert result.exit_code == code, result.output
    return result.stdout


def test_the_command_says_where_it_is_tight(files: tuple[str, str], tmp_path: Path) -> None:
    cubes, die = files
    words = [cubes, "--tool", die, "--at", "1.25,0.25,0.25", "--within", "1.5"]
    text = run(*words)
    assert "Smallest distance: 250 mm" in text and "first" in text and "second" in text and "third" not in text
    assert "enough" in run(*words, "--require", "0.25")
    assert "too little" in run(*words, "--require", "0.26", code=1)
    document = json.loads(run(*words, "--require", "0.26", "--json", code=1))
    assert document["met"] is False and document["distance_m"] == 0.25
    assert [part["name"] for part in document["poses"][0]["parts"]] == ["first", "second"]
    assert json.loads(run(*words, "--json"))["met"] is None
    glb, table = tmp_path / "gaps.glb", tmp_path / "gaps.csv"
    run(*words, "--glb", glb, "--csv", table, "--context", "1.5")
    written = feeler.load_mockup(glb)
    assert any("witness" in path for path in written.part_paths)
    with table.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    assert [(row["path"], float(row["distance_m"])) for row in rows] == [("cubes/first", 0.25), ("cubes/second", 1.25)]


def test_the_command_takes_many_poses(files: tuple[str, str], tmp_path: Path) -> None:
    cubes, die = files
    np.save(tmp_path / "path.npy", np.stack([at(1.1 + 0.1 * i, 0.25, 0.25) for i in range(10)]))
    words = [cubes, "--tool", die, "--pose", tmp_path / "path.npy", "--within", "0.5"]
    text = run(*words, "--require", "0.15", code=1)
    assert "at pose 0 of 10" in text and "too little" in text and "at 1 pose\n" in text
    document = json.loads(run(*words, "--json"))
    assert len(document["poses"]) == 10 and document["poses"][3]["distance_m"] == pytest.approx(0.4)


def test_the_command_refuses_bad_input(files: tuple[str, str], tmp_path: Path) -> None:
    cubes, die = files
    words = [cubes, "--tool", die, "--at", "0,0,0"]
    for more in (
        ["--within", "-1"],
        ["--within", "nan"],
        ["--require", "-0.1"],
        ["--glb", tmp_path / "a.png"],
        ["--csv", tmp_path / "no" / "a.csv"],
        ["--glb", tmp_path / "a.glb", "--context", "-1"],
    ):
        run(*words, *more, code=2)


@stores
def test_a_gap_of_exactly_the_limit_is_within_it(store: dict[str, Any]) -> None:
    """Of every query: a limit is the largest gap that is reported."""
    gap = 0.25
    mockup, tool = feeler.Mockup(CUBE, SIDES), feeler.Tool(CUBE, SIDES)
    scene, pose = feeler.Scene(mockup, voxel_size=0.5, **store), at(1.0 + gap)
    both = np.concatenate([CUBE, CUBE + np.array([1.0 + gap, 0, 0])])
    pair = feeler.Mockup(both, np.concatenate([SIDES, SIDES + 8]), np.repeat([0, 1], 12), ["a", "b"])
    for within, is_found in ((np.nextafter(gap, 0.0), False), (gap, True), (np.nextafter(gap, 1.0), True)):
        found = [
            len(scene.clearance(tool, pose, within)) > 0,
            len(scene.clearance(tool, pose, within, True)) > 0,
            len(scene.clearance_batch(tool, [pose], within).parts) > 0,
            scene.distance(tool, pose, within) is not None and scene.distance(tool, pose, within).value == gap,
            len(scene.nearest(tool, pose, 3, within=within)) > 0,
            scene.distance_batch(tool, [pose], within).values[0] == gap,
            len(scene.contacts(tool, pose, within)) > 0,
            scene.clearance_along(tool, pose, pose, within=within).upper == gap,
            scene.rays([[1.0 + gap, 0.4, 0.5]], [[-1, 0, 0]], within=within).triangles[0] >= 0,
            len(feeler.clash(pair, clearance=within)) > 0,
        ]
        assert found == [is_found] * len(found)
