"""The calibrated estimator: the machine's constants, their cache, and the size that is chosen with them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import feeler
from feeler import _core, calibrate


@pytest.fixture(scope="module")
def pair() -> tuple[feeler.Mockup, feeler.Tool]:
    return feeler.sample("engine", 20_000), feeler.sample_tool("wrench")


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A process that knows nothing yet, and an empty cache; measuring takes no time and gives the typical constants."""
    monkeypatch.setattr(calibrate, "_known", None)
    monkeypatch.setattr(calibrate, "measure_constants", lambda: calibrate.TYPICAL)
    monkeypatch.setenv("FEELER_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_the_least_time_of_each_query_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    spans = np.random.default_rng(3).integers(1, 1000, (2, 3, 5, 8)).astype(float)  # tools, rounds, voxel sizes, poses
    ticks = iter(np.cumsum(np.column_stack([np.ones(spans.size), spans.ravel()]).ravel()).tolist())
    fitted: list[tuple[np.ndarray, np.ndarray]] = []
    monkeypatch.setattr(calibrate, "query_clock", lambda: lambda: next(ticks))
    monkeypatch.setattr(calibrate, "fit_constants", lambda *found: fitted.append(found) or calibrate.TYPICAL)
    assert calibrate.measure_constants() == calibrate.TYPICAL
    ((steps, seconds),) = fitted
    np.testing.assert_array_equal(seconds, spans.min(axis=1).ravel())
    assert next(ticks, None) is None, "no other call of the clock"
    assert steps.shape == (80, len(calibrate.NAMES))
    queries, tool_triangles, voxels, entries, pairs, tests = steps.T
    assert (queries == 1).all() and tool_triangles.tolist() == [192.0] * 40 + [1920.0] * 40
    assert (np.diff(voxels.reshape(2, 5, 8), axis=1) < 0).all(), "larger voxels, fewer of them"
    assert (entries >= pairs).all() and (pairs >= tests).all(), "the stages of a query, each with less to do"
    assert entries.sum() > pairs.sum() > tests.sum() > 0


def test_what_is_measured_here_makes_sense(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(calibrate, "_ROUNDS", 1)
    constants = calibrate.measure_constants()
    calibrate._write(tmp_path / "constants.json", constants)
    assert calibrate._read(tmp_path / "constants.json") == constants


def test_the_fit_finds_the_constants_again() -> None:
    rng = np.random.default_rng(1)
    steps = np.column_stack([np.ones(80), *(rng.uniform(0, size, 80) for size in (1e3, 1e4, 1e5, 1e4, 1e3))])
    true = np.array(calibrate.TYPICAL) * [0.5, 2.0, 0.7, 1.5, 1.2, 0.8]
    seconds = steps @ true
    found = np.array(calibrate.fit_constants(steps, seconds))
    error = np.abs(steps @ found / seconds - 1)  # the pull to the typical ratios is weak, but there
    assert np.median(error) < 0.1 and error.max() < 0.5


def test_no_constant_is_negative() -> None:
    rng = np.random.default_rng(1)
    steps = np.column_stack([np.ones(80), *(rng.uniform(0, size, 80) for size in (1e3, 1e4, 1e5, 1e4, 1e3))])
    # The more pairs, the less time: the least squares alone would say so.
    seconds = steps @ (np.array(calibrate.TYPICAL) * [1.0, 1.0, 1.0, 1.0, -0.3, 1.0])
    assert (seconds > 0).all()
    found = calibrate.fit_constants(steps, seconds)
    assert found[calibrate.NAMES.index("pair")] == 0.0
    assert all(value >= 0.0 for value in found) and min(found[:4]) > 0.0
    assert all(0.0 <= value < 1e-9 for value in calibrate.fit_constants(steps, np.zeros(80)))


def test_the_cache_is_written_and_read(fresh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert calibrate.machine_constants() == calibrate.TYPICAL
    (file,) = fresh.iterdir()
    values = json.loads(file.read_text())["seconds"]
    values["voxel"] = 7e-9
    file.write_text(json.dumps({"seconds": values}))
    monkeypatch.setattr(calibrate, "_known", None)
    assert calibrate.machine_constants()[calibrate.NAMES.index("voxel")] == 7e-9


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", '{"seconds": 3}', '{"seconds": {"query": 1}}', "\0" * 40]
    + [json.dumps({"seconds": dict.fromkeys(calibrate.NAMES, bad)}) for bad in (0.0, -1.0, 1e9, "x", None)]
    + [json.dumps({"seconds": dict.fromkeys(calibrate.NAMES, float("nan"))})],
)
def test_a_spoilt_cache_is_measured_anew(fresh: Path, text: str) -> None:
    file = calibrate.cache_file()
    file.parent.mkdir(parents=True)
    file.write_text(text)
    assert calibrate.machine_constants() == calibrate.TYPICAL
    assert json.loads(file.read_text())["seconds"]["query"] == calibrate.TYPICAL[0]


def test_a_cache_that_cannot_be_written_costs_nothing_more(fresh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fresh.write_text("a file where the folder should be")
    assert calibrate.machine_constants() == calibrate.TYPICAL
    monkeypatch.setenv("FEELER_CACHE_DIR", "")
    monkeypatch.delenv("HOME", raising=False)
    assert calibrate.cache_file().name.startswith("constants-")


def test_a_memory_limit_is_kept(pair: tuple[feeler.Mockup, feeler.Tool]) -> None:
    mockup, tool = pair
    free = feeler.optimal_voxel_size(mockup, tool)
    predictor = _core.Predictor(mockup, tool, "dense", 0.0)
    limit = int(0.5 * predictor.bytes(free))
    size = feeler.optimal_voxel_size(mockup, tool, memory_limit=limit)
    assert size > free and predictor.bytes(size) <= limit
    memory = feeler.Scene(mockup, voxel_size=size, storage="dense").memory()
    assert abs(memory["voxels"] + memory["lists"] - predictor.bytes(size)) < 0.1 * limit


def test_work_is_predicted_within_a_small_factor(pair: tuple[feeler.Mockup, feeler.Tool]) -> None:
    mockup, tool = pair
    poses = feeler.sample_poses(feeler.Scene(mockup), tool, "nominal", 10)
    predictor = _core.Predictor(mockup, tool, "dense", 0.0)
    for size in (0.01, 0.03):
        scene = feeler.Scene(mockup, voxel_size=size, storage="dense")
        visited = np.mean([scene.collide(tool, pose).stats["voxels_visited"] for pose in poses])
        entries = np.mean([scene.collide(tool, pose).stats["entries_scanned"] for pose in poses])
        _, voxels, listed, pairs, tests = predictor.work(size)
        assert 0.5 < voxels / visited < 2.0
        assert 0.2 < listed / entries < 5.0
        assert listed > pairs > tests > 0


def test_the_piece_size_follows_the_tool(pair: tuple[feeler.Mockup, feeler.Tool]) -> None:
    mockup, tool = pair
    coarse = feeler.Tool(8.0 * tool.vertices, tool.faces)
    sizes = [feeler.optimal_voxel_size(mockup, each, storage="blocks") for each in (tool, coarse)]
    assert sizes[0] < feeler.Scene(mockup).voxel_size  # the engine has large panels: smaller pieces pay
    assert sizes[0] < sizes[1]
    assert [feeler.Scene(mockup, tool=each).voxel_size for each in (tool, coarse)] == sizes


def test_the_piece_size_keeps_its_memory(pair: tuple[feeler.Mockup, feeler.Tool]) -> None:
    mockup, tool = pair
    needle = feeler.Tool(1e-4 * tool.vertices, tool.faces)  # would like mock-ups of dust
    scene = feeler.Scene(mockup, tool=needle)
    assert scene.memory()["pieces"] <= 20 * 3.3 * mockup.triangle_count  # three pieces each, by estimate
    assert scene.memory()["total"] <= 130 * mockup.triangle_count
    limit = 3_000_000
    tight = feeler.optimal_voxel_size(mockup, needle, storage="blocks", memory_limit=limit)
    assert tight > scene.voxel_size
    feeler.Scene(mockup, tool=needle, memory_limit=limit)  # is not refused


def test_what_cannot_be_predicted_is_said(pair: tuple[feeler.Mockup, feeler.Tool]) -> None:
    mockup, tool = pair
    with pytest.raises(feeler.OptionError, match="storage is 'sparse': do you mean"):
        feeler.optimal_voxel_size(mockup, tool, storage="sparse")
    for storage in ("dense", "blocks"):
        with pytest.raises(feeler.OptionError, match="leave hashing at 0"):
            feeler.optimal_voxel_size(mockup, tool, storage=storage, hashing=0.5)
    for hashing in (-0.1, 1.0, float("nan")):
        with pytest.raises(feeler.OptionError, match="hashing"):
            feeler.optimal_voxel_size(mockup, tool, storage="hashed", hashing=hashing)
    predictor = _core.Predictor(mockup, tool, "dense", 0.0)
    pieces = _core.PiecePredictor(mockup, tool)
    for size in (0.0, -1.0, float("nan"), float("inf")):
        for predicted in (predictor, pieces):
            with pytest.raises(feeler.OptionError, match="voxel_size"):
                predicted.work(size)


def test_tiny_and_huge_meshes_fall_back_to_the_papers_rule() -> None:
    for scale in (1e-160, 1e98):
        corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * scale
        faces = [[0, 1, 2], [0, 1, 3]]
        mockup, tool = feeler.Mockup(corners, faces), feeler.Tool(corners, faces)
        for storage in ("dense", "blocks"):
            assert feeler.optimal_voxel_size(mockup, tool, storage=storage) > 0
            scene = feeler.Scene(mockup, storage=storage, tool=tool)
            assert len(scene.collide(tool, np.eye(4)).pairs) > 0
