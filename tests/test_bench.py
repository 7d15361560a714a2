"""The bench and the real-data run at toy size: they run, and what they write is what they say. No times are judged."""

from __future__ import annotations

import importlib.util
import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import feeler

PEERS = [name for name in ("coal", "fcl") if importlib.util.find_spec(name) is not None]
HAS_EMBREE = shutil.which("g++") is not None and Path("/usr/include/embree3/rtcore.h").exists()
TINY = ["--sizes", "10000", "--tools", "torque,wrench", "--poses", "3", "--rounds", "1", "--builds", "1"]
ALONE = ["--worst", "20", "--batch", "10"]
SKIP = ["--worst", "0", "--batch", "0"]


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
    done = run(root, "run.py", *TINY, *ALONE, "--peers", "coal,fcl", "--out", str(folder))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Written:" in done.stdout and "Goals" in done.stdout
    return folder


def read(folder: Path) -> dict[str, Any]:
    (path,) = folder.glob("*.json")
    record = json.loads(path.read_text(encoding="utf-8"))
    assert isinstance(record, dict)
    assert path.name.startswith(record["when"][:10]) and path.stem.endswith("-1")
    return record


def test_record_has_what_the_readme_of_records_promises(root: Path, record_folder: Path) -> None:
    record = read(record_folder)
    documented = {
        *("schema", "when", "commit", "dirty", "args", "machine", "load_average", "versions", "cargo_profile"),
        *("engines", "absent", "method", "overheads", "python_call", "sizes", "cells", "seconds"),
        *("growth", "fine", "worst", "batch", "goals"),
    }
    assert documented == set(record)
    page = (root / "bench" / "README.md").read_text(encoding="utf-8")
    assert all(f"`{key}`" in page for key in documented)
    assert {"cpu", "cores", "flags", "architecture", "memory_gib", "system"} == set(record["machine"])
    assert "--out" not in record["args"]
    cells = record["cells"]
    asked = [
        *(("nominal", "collide"), ("nominal", "is_colliding"), ("nominal", "contacts")),
        *(("near", "collide"), ("near", "is_colliding"), ("near", "distance"), ("near", "cast")),
        ("deep", "collide"),
    ]
    expected = [(tool, *of) for tool in ("torque", "wrench") for of in asked]
    assert [(cell["tool"], cell["kind"], cell["query"]) for cell in cells] == expected
    for cell in cells:
        assert cell["poses"] == 3 and cell["rounds"] == 1
        assert (cell["pairs"]["median"] > 0) == (cell["kind"] != "near")
        for figures in cell["engines"].values():
            wall = figures["wall_us"]
            assert 0 < wall["median"] <= wall["p95"] <= wall["p99"] <= wall["worst"]
        if cell["query"] == "collide":
            assert cell["funnel"]["pairs"] == pytest.approx(cell["pairs"]["mean"])
    (size,) = record["sizes"]
    assert 9_000 <= size["triangles"] <= 10_000
    for build in size["builds"]:
        assert build["one_core_s"] > 0
        assert build["bytes"] is None or build["bytes_per_triangle"] > 0


def test_feeler_alone_and_goals(record_folder: Path) -> None:
    record = read(record_folder)
    assert [row["tool"] for row in record["worst"]] == ["torque", "wrench"]
    for row in record["worst"]:
        assert row["poses"] == 20 and row["poses_found_alone"] == 2 and row["pairs_at_slowest"] > 0
        assert row["wall_us"]["worst"] <= row["worst_single_call_us"]
    (batch,) = record["batch"]
    assert batch["tool"] == "torque" and batch["pairs_equal"] and batch["batch_1_per_s"] > 0
    assert ("batch_2_per_s" in batch) == ("apart_2_per_s" in batch) == ((os.cpu_count() or 1) > 1)
    for goal in record["goals"]:
        assert set(goal) == {"goal", "wanted", "found", "met"} and goal["met"] in (True, False, None)
    assert any("Python call" in goal["goal"] for goal in record["goals"])
    assert record["growth"] == record["fine"] == []


@pytest.mark.skipif(not PEERS, reason="neither Coal nor python-fcl is installed")
def test_engines_agree_but_for_differences_that_are_judged(record_folder: Path) -> None:
    record = read(record_folder)
    assert set(record["engines"]) == {"feeler", *PEERS}
    for cell in record["cells"]:
        able = [] if cell["query"] in ("contacts", "cast") else PEERS
        assert set(cell["engines"]) == {"feeler", *able}
        for peer in able:
            found = cell["agreement"][peer]
            assert found["feeler_wrong"] == 0
            if cell["query"] == "collide":
                assert found["feeler_only_false"] == found["peer_only_true"] == found["unjudged"] == 0
                # What feeler found is what both found, and what the peer missed.
                assert found["agreed"] + found["feeler_only_true"] == round(3 * cell["pairs"]["mean"])
            else:
                assert found["agreed"] + found["peer_wrong"] == 3
            assert all(ratio > 0 for ratio in cell["ratios"][peer]["wall"].values())
        for measure, ratio in (("median", "of_medians"), ("p95", "of_p95s")) if able else ():
            best = cell["best"][measure]
            assert best["times_faster"] == min(cell["ratios"][peer]["wall"][ratio] for peer in PEERS)
            assert best["times_faster"] == cell["ratios"][best["peer"]]["wall"][ratio]


def test_rows_are_flat_and_complete(record_folder: Path) -> None:
    (path,) = record_folder.glob("*.jsonl")
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    record = read(record_folder)
    assert len(rows) == sum(len(cell["engines"]) for cell in record["cells"])
    for row in rows:
        assert not any(isinstance(value, (dict, list)) for value in row.values())
        assert {"when", "commit", "cpu", "cores", "flags", "args", "engine", "version", "tool", "kind"} <= set(row)
        assert {"wall_median_us", "wall_p95_us", "wall_worst_us", "cpu_median_us", "bytes_per_triangle"} <= set(row)
        feeler = row["engine"] == "feeler"
        assert ("mean_pairs" in row) == (feeler and row["query"] == "collide")
        assert ("times_faster_wall_of_medians" in row) != feeler
        assert ("times_faster_best_median" in row) == (
            feeler and bool(PEERS) and row["query"] not in ("contacts", "cast")
        )


def test_plot_is_beside_the_record(record_folder: Path) -> None:
    if importlib.util.find_spec("matplotlib") is None:
        assert not list(record_folder.glob("*.png"))
    else:
        (path,) = record_folder.glob("*.png")
        assert path.read_bytes().startswith(b"\x89PNG")


def test_figures_of_a_record_for_the_readme(root: Path, record_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    text = importlib.import_module("readme").figures(read(record_folder), "a-record.json")
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert len(rows) == 2 + 2 * 3 and len({row.count("|") for row in rows}) == 1
    assert "Index built in" in text and "(bench/records/a-record.json)" in text


def test_goals_by_machine(root: Path, record_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    machines = importlib.import_module("machines")
    one = read(record_folder)
    one["machine"] = {**one["machine"], "cpu": "A CPU(R) Processor", "flags": ["avx2"]}
    one["goals"] = [
        {"goal": "speed", "wanted": "5", "found": "4", "met": False},
        {"goal": "size", "wanted": "2", "found": "1", "met": True},
    ]
    speed = {"goal": "speed", "wanted": "5", "found": "6", "met": True}
    other = {**one, "machine": {**one["machine"], "flags": ["avx2", "avx512f"]}, "goals": [speed]}
    lines = machines.table([(one, "one.json"), (other, "other.json")]).splitlines()
    assert lines[0] == "| goal | wanted | A CPU, AVX2 | A CPU, AVX-512 |" and lines[2] == "| speed | 5 | **4** | 6 |"
    assert len(lines) == 5 and "other 1 goals" in lines[4] and "bench/records/other.json" in lines[4]


def test_record_after_record(root: Path, record_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    machines = importlib.import_module("machines")
    one = read(record_folder)
    one["machine"] = {**one["machine"], "cpu": "A CPU", "flags": ["avx2"]}
    one["goals"] = [{"goal": "contacts, nominal, hand, p99", "wanted": "5", "found": "4 (or so)", "met": True}]
    slower = json.loads(json.dumps(one))
    for cell in slower["cells"]:
        cell["engines"]["feeler"]["wall_us"]["median"] *= 3
    other = {**one, "machine": {**one["machine"], "cpu": "Another"}, "goals": []}
    rows = machines.history([(slower, "slow.json"), (other, "other.json"), (one, "one.json")]).splitlines()
    assert len({row.count("|") for row in rows[:5]}) == 1 and not rows[5]
    cells = [[cell.strip() for cell in row.split("|")[1:-1]] for row in rows[2:5]]
    # By machine, and beside the newest of each.
    assert [row[0].split(",")[0] for row in cells] == ["A CPU", "A CPU", "Another"]
    assert [row[1].split("]")[0] for row in cells] == ["[slow", "[one", "[other"]
    assert [row[3] for row in cells] == ["4", "4", "–"] and [row[-2] for row in cells] == ["3.000", "1.000", "1.000"]


def test_cells_of_a_record_for_the_page_on_performance(
    root: Path, record_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    cells, page = importlib.import_module("cells"), importlib.import_module("page")
    record = read(record_folder)
    text = cells.figures(record, "a-record.json")
    assert "(../bench/records/a-record.json)" in text and text.count("\n### ") == 2
    assert text.count("| torque | collide, ") == 3 and text.count("| wrench | is_colliding, ") == 2
    record["cells"][0] = {**{key: record["cells"][0][key] for key in ("tool", "query", "kind")}, "problem": "none"}
    record["cells"][0]["triangles_asked"] = 10_000
    for table in (text, cells.figures(record, "a-record.json")):
        for above, line in itertools.pairwise(table.splitlines()):
            if above.startswith("|") and line.startswith("|"):
                assert above.count("|") == line.count("|")
    # Every stage has its column, and the page has the place for it all.
    assert [set(cell["funnel"]) for cell in record["cells"] if "funnel" in cell] == [set(cells.STAGES)] * 5
    written = tmp_path / "page.md"
    written.write_bytes(page.PERFORMANCE.read_bytes())
    page.fill(written, "cells: bench/cells.py", text)
    page.fill(written, "limit: bench/limit.py", "here")
    assert text in written.read_text(encoding="utf-8")
    assert "-->\nhere\n<!--" in written.read_text(encoding="utf-8")


def test_records_go_by_age_without_those_of_a_disturbed_machine(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    readme = importlib.import_module("readme")
    monkeypatch.setattr(readme, "RECORDS", tmp_path)
    records = {"a": {"when": "2"}, "b": {"when": "1"}, "c": {"when": "3", "disturbed": "others on the host"}}
    for name, record in records.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(record), encoding="utf-8")
    assert [path.stem for path in readme.by_age()] == ["b", "a"] and readme.newest().stem == "a"


@pytest.mark.parametrize(("more_s", "most", "expected"), [(60.0, 0, 2), (60.0, 5, 5), (0.0, 5, 2)])
def test_those_in_play_have_more_rounds(
    root: Path, monkeypatch: pytest.MonkeyPatch, more_s: float, most: int, expected: int
) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    measure = importlib.import_module("measure")
    monkeypatch.setattr(measure, "MORE_S", more_s)
    asked: list[str] = []
    took = {"a": 5.0, "b": 2.0, "c": 3.0, "d": 3.1}

    def clock_once(call: Any) -> tuple[float, float]:
        asked.append(call())
        return took[asked[-1]], took[asked[-1]]

    monkeypatch.setattr(measure, "clock_once", clock_once)
    engines = [SimpleNamespace(name=name, aim=lambda *_, own=name: lambda: own) for name in "abcd"]
    times = measure.clock(engines, np.zeros((3, 4, 4)), 2, "collide", most)
    # The first, the best of the others, and who is close to that.
    rounds = {"a": expected, "b": expected, "c": expected, "d": 2}
    assert {name: (own.wall.shape, own.cpu.shape) for name, own in times.items()} == {
        name: ((count, 3), (count, 3)) for name, count in rounds.items()
    }
    assert all(
        (own.wall == took[name]).all() and own.figures()["rounds"] == rounds[name] for name, own in times.items()
    )
    # Of the rounds that both have: what one was spared in a later round does not count against the other.
    times["a"].wall[2:] = times["a"].cpu[2:] = 0.1
    assert measure.ratios(times["a"], times["d"])["wall"]["of_medians"] == pytest.approx(3.1 / 5.0)
    # One engine after the other, and who is first changes.
    turns = ["abcd", "bcda", "cab", "abc", "bca"][:expected]
    assert "".join(asked) == "".join(own * 3 for turn in turns for own in turn)


def test_what_a_query_needs_at_least(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    limit = importlib.import_module("limit")
    faces = np.array([[0, 1, 2], [2, 1, 3], [100, 101, 102]] * 100)
    stats = dict.fromkeys(("voxels_visited", "clusters_placed", "pieces_scanned", "entries_scanned"), 16)
    nothing = limit.needed(faces, np.zeros((0, 2), dtype=np.uint32), {**stats, "triangle_tests": 0})
    assert (nothing.scattered, nothing.in_row, nothing.answer) == (0, 16 * 836 // 64, 0)
    pairs = np.array([[0, 0], [0, 1], [1, 1], [1, 2]])
    some = limit.needed(faces, pairs, {**stats, "triangle_tests": 20})
    # Faces 0 to 2 lie in one line, corners 0 to 3 in two, 100 to 102 in two more.
    assert some.scattered == 1 + 2 + 2
    assert some.answer == 4 * (limit.TEST + limit.MEET) / 16
    assert some.instructions == nothing.instructions + some.answer + limit.TEST
    core = limit.Machine([64, 6400], [1.0, 3.0], [1.0, 1.0], [1.0, 1.0], 1.0, 1.0)
    assert [core.price("random", size) for size in (1, 640, 10**9)] == pytest.approx([1.0, 2.0, 3.0])


@pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")
def test_the_limit_at_toy_size(root: Path, tmp_path: Path) -> None:
    arguments = ["--size", "10000", "--tools", "torque", "--poses", "2", "--rounds", "1"]
    done = run(root, "limit.py", *arguments, CARGO_TARGET_DIR=str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split(" | ") for line in done.stdout.splitlines() if line.startswith("| torque")]
    assert [row[1] for row in rows] == ["nominal", "near", "deep", "nominal", "deep"]
    for row in rows[3:]:
        assert "nan" not in row and len(row) >= 3  # by instruction set; this CPU has one at least
    for row in rows[:3]:
        memory, lanes, limit = (float(row[i]) for i in (3, 5, 7))
        assert limit > 0 and limit >= max(memory, lanes) - 0.02


def test_growth_of_toy_engines(root: Path) -> None:
    done = run(root, "growth.py", "--sizes", "10k,20k", "--tools", "torque", "--poses", "4", "--rounds", "1")
    assert done.returncode == 0, done.stderr
    (row,) = [line for line in done.stdout.splitlines() if line.startswith("| torque")]
    figures = [float(x) for x in row.replace(",", "|").split("|")[2:-1]]
    assert len(figures) == 13 and all(x > 0 for x in figures)
    assert run(root, "growth.py", "--sizes", "10k").returncode == 2


def test_a_second_record_of_the_day_keeps_the_first_and_peers_may_be_absent(root: Path, tmp_path: Path) -> None:
    (tmp_path / "absent").mkdir()
    for name in ("coal", "fcl"):
        (tmp_path / "absent" / f"{name}.py").write_text("raise ImportError('not here')\n")
    arguments = [*TINY, *SKIP, "--kinds", "nominal", "--out", str(tmp_path / "records")]
    # No compiler and no cargo on the path, and nothing built before.
    nothing = {"PATH": str(tmp_path), "CARGO_TARGET_DIR": str(tmp_path / "target"), "CXX": ""}
    without = run(root, "run.py", *arguments, PYTHONPATH=str(tmp_path / "absent"), **nothing)
    assert without.returncode == 0 and "coal is absent: not here" in without.stderr
    alone = run(root, "run.py", *arguments, "--no-peers", "--queries", "collide")
    assert alone.returncode == 0 and "absent" not in alone.stderr
    first, second = sorted((tmp_path / "records").glob("*.json"))
    assert first.stem.endswith("-1") and second.stem.endswith("-2")
    absent = json.loads(first.read_text())["absent"]
    assert absent["coal"] == absent["fcl"] == "not here"
    assert "compiler" in absent["embree"] and "cargo" in absent["parry"]
    record = json.loads(second.read_text())
    assert set(record["engines"]) == {"feeler"} and record["absent"] == {}
    assert {cell["query"] for cell in record["cells"]} == {"collide"} and record["worst"] == record["batch"] == []


@pytest.mark.skipif(not HAS_EMBREE, reason="no g++, or no Embree 3 to build against")
def test_embree_agrees(root: Path, tmp_path: Path) -> None:
    asked = ("--peers", "embree", "--kinds", "nominal", "--queries", "collide,is_colliding")
    done = run(root, "run.py", *TINY, *SKIP, *asked, "--out", str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    record = read(tmp_path)
    assert set(record["engines"]) == {"feeler", "embree"} and record["versions"]["embree"].startswith("3.")
    for cell in record["cells"]:
        assert cell["agreement"]["embree"]["agreed"] > 0 and cell["agreement"]["embree"]["feeler_wrong"] == 0
        assert cell["best"]["median"]["peer"] == "embree"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sizes", "5"], "at least 10,000"),
        (["--sizes", "many"], "no size"),
        (["--tools", "spoon"], "spoon"),
        (["--kinds", "far"], "no kind"),
        (["--queries", "weigh"], "no query"),
        (["--peers", "spoon"], "no peer"),
        (["--worst", "-1"], "from 1"),
        (["--poses", "0"], "from 1"),
    ],
)
def test_options_out_of_range_are_refused(root: Path, arguments: list[str], said: str) -> None:
    done = run(root, "run.py", *arguments)
    assert done.returncode == 2 and said in done.stderr


@pytest.mark.parametrize("script", ["run.py", "real_data.py", "readme.py", "cells.py", "machines.py", "plot.py"])
def test_help_has_examples(root: Path, script: str) -> None:
    done = run(root, script, "--help")
    assert done.returncode == 0 and "examples:" in done.stdout and f"python bench/{script}" in done.stdout


@pytest.mark.parametrize("script", ["readme.py", "cells.py", "machines.py"])
@pytest.mark.parametrize(("text", "said"), [(None, "no record"), ("[1]", "no record"), ('{"schema": 1}', "older")])
def test_what_is_no_record_is_refused(root: Path, tmp_path: Path, script: str, text: str | None, said: str) -> None:
    path = tmp_path / "record.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    done = run(root, script, str(path))
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


# --- the judge -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def judge(root: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("bench_judge", root / "bench" / "judge.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_judge_tells_one_unit_in_the_last_place(judge: ModuleType) -> None:
    floor = np.array([[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]])
    tip = np.array([[0.25, 0.25, 0.1], [0, 0, 1], [1, 0, 1]])
    assert judge.meets(tip, floor)
    tip[0, 2] = np.nextafter(0.1, 1)
    assert not judge.meets(tip, floor)


def test_judging_is_bounded_and_says_what_was_left(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(root / "bench"))
    agreement, measure = importlib.import_module("agreement"), importlib.import_module("measure")
    tool = feeler.sample_tool("torque")
    mockup = feeler.sample("engine", 10_000)
    scene, pose = feeler.Scene(mockup), np.eye(4)
    pose = feeler.sample_poses(scene, tool, "nominal", 1)[0]
    true = np.asarray(scene.collide(tool, pose).pairs)
    made_up = np.array([[i, j] for i in range(10) for j in range(10)], dtype=np.uint32)
    ours, theirs = measure.Findings(pairs=[true[1:]]), measure.Findings(pairs=[np.unique([*true, *made_up], axis=0)])
    whole = agreement.compare(mockup, tool, pose[None], ours, theirs)
    assert whole.differing >= 1 + 90 and whole.unjudged == 0
    assert whole.agreed == len(true) - 1 and whole.feeler_wrong == 1
    some = agreement.compare(mockup, tool, pose[None], ours, theirs, most=10)
    judged = some.peer_only_true + some.peer_only_false + some.not_queried
    assert judged == 10 and some.unjudged == some.differing - 10


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
    if "coal" in PEERS:
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
