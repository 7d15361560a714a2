"""The bench and the real-data run at toy size: they run, and what they write is what they say. No times are judged."""

from __future__ import annotations

import importlib.util
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import oracle
import pytest

HAS_COAL = importlib.util.find_spec("coal") is not None
TINY = ["--sizes", "10000", "--tools", "torque,wrench", "--poses", "3", "--rounds", "1", "--builds", "1"]


def run(root: Path, script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, str(root / "bench" / script), *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONUTF8": "1", **environment},
        timeout=120,
        check=False,
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


@pytest.fixture(scope="module")
def record_folder(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the record of one small run."""
    folder = tmp_path_factory.mktemp("records")
    done = run(root, "run.py", *TINY, "--out", str(folder))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Written:" in done.stdout
    return folder


def read(folder: Path) -> dict[str, Any]:
    (path,) = folder.glob("*.json")
    record = json.loads(path.read_text(encoding="utf-8"))
    assert isinstance(record, dict)
    assert path.name.startswith(record["when"][:10]) and path.stem.endswith("-1")
    return record


def test_record_has_what_the_readme_of_records_promises(record_folder: Path) -> None:
    record = read(record_folder)
    documented = {
        *("schema", "when", "commit", "dirty", "args", "machine", "load_average", "versions", "cargo_profile"),
        *("engines", "absent", "method", "overheads", "sizes", "cells", "seconds"),
    }
    assert documented == set(record)
    assert {"cpu", "cores", "flags", "architecture", "memory_gib", "system"} == set(record["machine"])
    assert "--out" not in record["args"]
    cells = record["cells"]
    assert [(cell["tool"], cell["kind"]) for cell in cells] == [
        (tool, kind) for tool in ("torque", "wrench") for kind in ("nominal", "near")
    ]
    for cell in cells:
        assert cell["poses"] == 3 and cell["rounds"] == 1
        assert (cell["pairs"]["median"] > 0) == (cell["kind"] == "nominal")
        for figures in cell["engines"].values():
            wall = figures["wall_us"]
            assert 0 < wall["median"] <= wall["p95"] <= wall["p99"] <= wall["worst"]
        assert cell["funnel"]["pairs"] == pytest.approx(cell["pairs"]["mean"])
    (size,) = record["sizes"]
    assert 9_000 <= size["triangles"] <= 10_000
    for build in size["builds"]:
        assert build["one_core_s"] > 0 and build["bytes_per_triangle"] > 0


@pytest.mark.skipif(not HAS_COAL, reason="Coal is not installed")
def test_engines_agree_but_for_differences_that_are_judged(record_folder: Path) -> None:
    record = read(record_folder)
    assert set(record["engines"]) == {"feeler", "coal"}
    for cell in record["cells"]:
        found = cell["agreement"]["coal"]
        assert found["feeler_wrong"] == found["feeler_only_false"] == found["peer_only_true"] == 0
        # What feeler found is what both found, and what the peer missed.
        assert found["agreed"] + found["feeler_only_true"] == round(3 * cell["pairs"]["mean"])
        assert all(ratio > 0 for ratio in cell["ratios"]["coal"]["wall"].values())


def test_rows_are_flat_and_complete(record_folder: Path) -> None:
    (path,) = record_folder.glob("*.jsonl")
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    record = read(record_folder)
    assert len(rows) == len(record["cells"]) * len(record["engines"])
    for row in rows:
        assert not any(isinstance(value, (dict, list)) for value in row.values())
        assert {"when", "commit", "cpu", "cores", "flags", "args", "engine", "version", "tool", "kind"} <= set(row)
        assert {"wall_median_us", "wall_p95_us", "wall_worst_us", "cpu_median_us", "bytes_per_triangle"} <= set(row)
        assert ("mean_triangle_tests" in row) == (row["engine"] == "feeler")
        assert ("times_faster_wall_of_medians" in row) == (row["engine"] != "feeler")


def test_a_second_record_of_the_day_keeps_the_first_and_coal_may_be_absent(root: Path, tmp_path: Path) -> None:
    (tmp_path / "absent").mkdir()
    (tmp_path / "absent" / "coal.py").write_text("raise ImportError('not here')\n")
    arguments = [*TINY, "--kinds", "nominal", "--out", str(tmp_path / "records")]
    without = run(root, "run.py", *arguments, PYTHONPATH=str(tmp_path / "absent"))
    assert without.returncode == 0 and "Coal is not installed" in without.stderr
    alone = run(root, "run.py", *arguments, "--no-peers")
    assert alone.returncode == 0 and "Coal" not in alone.stderr
    first, second = sorted((tmp_path / "records").glob("*.json"))
    assert first.stem.endswith("-1") and second.stem.endswith("-2")
    assert json.loads(first.read_text())["absent"] == {"coal": "not here"}
    assert set(json.loads(second.read_text())["engines"]) == {"feeler"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sizes", "5"], "at least 10,000"),
        (["--sizes", "many"], "no size"),
        (["--tools", "spoon"], "spoon"),
        (["--kinds", "far"], "no kind"),
        (["--poses", "0"], "from 1"),
    ],
)
def test_options_out_of_range_are_refused(root: Path, arguments: list[str], said: str) -> None:
    done = run(root, "run.py", *arguments)
    assert done.returncode == 2 and said in done.stderr


@pytest.mark.parametrize("script", ["run.py", "real_data.py"])
def test_help_has_examples(root: Path, script: str) -> None:
    done = run(root, script, "--help")
    assert done.returncode == 0 and "examples:" in done.stdout and f"python bench/{script}" in done.stdout


# --- the judge -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def judge(root: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("bench_judge", root / "bench" / "judge.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("reach", [1, 2, 3, 1000])
@pytest.mark.parametrize("flat", [False, True])
def test_judge_equals_the_oracle(judge: ModuleType, rng: np.random.Generator, reach: int, flat: bool) -> None:
    met = 0
    for _ in range(300):
        a, b = rng.integers(-reach, reach + 1, (2, 3, 3)).astype(float) * 0.1
        if flat:
            a[:, 2] = b[:, 2] = 0.3
        if judge.has_area(b):
            met += judge.meets(a, b)
            assert judge.meets(a, b) == (oracle.kind_of_pair(a, b) is not None), (a, b)
    assert met > 10


def test_judge_tells_one_unit_in_the_last_place(judge: ModuleType) -> None:
    floor = np.array([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]])
    tip = np.array([[0.25, 0.25, 0.1], [0, 0, 1], [1, 0, 1]])
    assert judge.meets(tip, floor)
    tip[0, 2] = np.nextafter(0.1, 1)
    assert not judge.meets(tip, floor)


# --- real data -----------------------------------------------------------------------------------------------------


def test_real_data_on_a_small_folder(root: Path, tmp_path: Path) -> None:
    models = tmp_path / "models"
    (models / "machine").mkdir(parents=True)
    (models / "tools-mine").mkdir()
    (models / "machine" / "SOURCE.txt").write_text("Waves, made by a test.\nLicence: MIT.\nNot for the table.\n")
    write_waves(models / "machine" / "waves.stl", 40)
    write_waves(models / "tools-mine" / "probe.stl", 4, size_mm=200.0)
    (models / "machine" / "empty.ply").write_text("")
    (models / "machine" / "notes.md").write_text("no mesh")
    out, figures = tmp_path / "docs" / "table.md", tmp_path / "figures.json"
    arguments = ["--tools", "probe.stl,missing.stl", "--least", "1000", "--poses", "3", "--rounds", "1"]
    if HAS_COAL:
        arguments.append("--peers")
    done = run(root, "real_data.py", str(models), *arguments, "--out", str(out), "--json", str(figures))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 files: 2 loaded, 1 refused with a message, 0 failed otherwise" in done.stdout
    assert "no tool called missing.stl" in done.stderr

    found = json.loads(figures.read_text(encoding="utf-8"))
    assert [row["name"] for row in found["files"]] == ["machine/empty.ply", "machine/waves.stl", "tools-mine/probe.stl"]
    assert found["files"][0]["message"].startswith("LoadError: machine/empty.ply")
    (mockup,) = found["mockups"]
    assert mockup["mockup"] == "machine/waves.stl" and mockup["triangles"] == 3200
    assert [cell["kind"] for cell in found["cells"]] == ["nominal", "near"]
    for cell in found["cells"]:
        assert cell.get("agreement", {}).get("feeler_wrong", 0) == 0

    table = out.read_text(encoding="utf-8")
    assert str(tmp_path) not in table and "FOLDER" in table
    assert "| machine/waves.stl |" in table and "Licence: MIT." in table and "Not for the table" not in table
    # Every row of a table has as many fields as its heading.
    lines = table.splitlines()
    for above, line in itertools.pairwise(lines):
        if above.startswith("|") and line.startswith("|"):
            assert above.count(" | ") == line.count(" | ")


def test_real_data_says_when_there_is_no_folder(root: Path, tmp_path: Path) -> None:
    done = run(root, "real_data.py", FEELER_MODELS=str(tmp_path / "none"))
    assert done.returncode == 2 and "FEELER_MODELS" in done.stderr


def write_waves(path: Path, cells: int, size_mm: float = 1000.0) -> None:
    """A binary STL of a wavy sheet: 2 * cells^2 triangles."""
    steps = np.linspace(0, size_mm, cells + 1)
    x, y = np.meshgrid(steps, steps, indexing="ij")
    z = 0.05 * size_mm * np.sin(9 * x / size_mm) * np.cos(7 * y / size_mm)
    points = np.stack([x, y, z], axis=-1).astype(np.float32)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]).reshape(-1, 3, 3)
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = triangles
    path.write_bytes(b"made by a test".ljust(80) + len(triangles).to_bytes(4, "little") + rows.tobytes())
