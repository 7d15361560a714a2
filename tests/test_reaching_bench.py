"""The bench of the tool catalogue: a short run meets its goals, wrong results are seen, the page is the record's."""

from __future__ import annotations

import importlib
import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

goals = importlib.import_module("reaching.goals")
run = importlib.import_module("reaching.run")
section = importlib.import_module("section")
tables = importlib.import_module("reaching.tables")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What a short run leaves."""
    folder: Path = tmp_path_factory.mktemp("reaching")
    assert run.main([str(folder), "--quick"]) == 0
    return json.loads((folder / "reaching.json").read_text(encoding="utf-8"))


def test_a_short_run_has_both_experiments(result: Any) -> None:
    assert list(result) == ["engine", "gearbox"]
    assert result["engine"]["bolts"] == 12 and result["engine"]["reachable"] > 0
    assert set(result["gearbox"]["rows"]) == {"socket", "hex key", "open-end wrench"}


def test_what_is_wrong_is_seen(result: Any) -> None:
    wrong = deepcopy(result)
    wrong["engine"]["wrong"] = 1
    wrong["gearbox"]["planted"] = ["ring 8"]
    wrong["gearbox"]["rows"]["socket"]["found"] -= 1
    missed = [goal for goal in goals.scorecard(wrong) if not goal.is_met and not goal.is_timed]
    assert len(missed) == 3
    assert "**1**" in tables.engine(wrong["engine"]) and "**1**" in tables.gearbox(wrong["gearbox"])


def test_the_page_is_what_the_record_makes_it(root: Path) -> None:
    record = json.loads((root / "bench" / "records" / "reaching.json").read_text(encoding="utf-8"))
    text = (root / "docs" / "access.md").read_text(encoding="utf-8")
    assert tables.SECTION.filled(text, record) == text, "run bench/reaching/figures.py"
    assert section.judged(goals.scorecard(record)) == 0
