"""The bench of mechanisms: its truths hold, its peers are asked rightly, its tables are the record's."""

from __future__ import annotations

import importlib
import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

goals = importlib.import_module("mechanism.goals")
misses = importlib.import_module("mechanism.misses")
run = importlib.import_module("mechanism.run")
section = importlib.import_module("section")
steppers = importlib.import_module("mechanism.steppers")
tables = importlib.import_module("mechanism.tables")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What a short run of feeler alone leaves."""
    folder: Path = tmp_path_factory.mktemp("mechanism")
    assert run.main([str(folder), "--quick", "--peers", "none", "--arms", "6", "--positions", "20"]) == 0
    return json.loads((folder / "mechanism.json").read_text(encoding="utf-8"))


def test_a_short_run_has_all_experiments(result: Any) -> None:
    assert list(result) == ["door", "steps", "bounds"]
    (row,) = result["door"]["sizes"]
    assert row["lower"] <= row["curve_gap"] and row["curve_lower"] >= row["lower"] - 1e-12
    assert sum(each["positions"] for each in result["bounds"]["kinds"]) == 120


def test_steps_miss_what_the_bench_says_they_do(result: Any) -> None:
    corner, sheet, window = result["steps"]["cases"]
    assert corner["gaps"]["feeler, stepped"] > corner["truth"] + 5e-6
    assert sheet["upper"] == 0.0 < 1e-3 < sheet["gaps"]["feeler, stepped"]
    assert window["gaps"]["feeler, stepped"] == pytest.approx(window["truth"], abs=1e-6)


@pytest.mark.parametrize("name", list(steppers.PEERS))
def test_peers_find_the_gaps_of_feeler_at_the_same_poses(name: str) -> None:
    there, absent = steppers.peers([name])
    if absent:
        pytest.skip(f"{name} is not installed")
    found = misses.measured(there)["cases"]
    for row in found[:2]:  # convex bodies
        assert row["gaps"][name] == pytest.approx(row["gaps"]["feeler, stepped"], abs=1e-5)


def test_what_is_wrong_is_seen(result: Any) -> None:
    wrong = deepcopy(result)
    wrong["bounds"]["kinds"][0]["above"] = 1
    wrong["steps"]["cases"][0]["lower"] = 0.01
    missed = [goal for goal in goals.scorecard(wrong) if not goal.is_met and not goal.is_timed]
    assert len(missed) == 2
    assert "**1**" in tables.bounds(wrong["bounds"])


def test_the_page_is_what_the_record_makes_it(root: Path) -> None:
    record = json.loads((root / "bench" / "records" / "mechanism.json").read_text(encoding="utf-8"))
    text = (root / "docs" / "mechanisms.md").read_text(encoding="utf-8")
    assert tables.SECTION.filled(text, record) == text, "run bench/mechanism/figures.py"
    assert section.judged(goals.scorecard(record)) == 0
