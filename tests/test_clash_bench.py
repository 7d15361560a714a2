"""The bench of clash checks: it judges as it says, its peers are asked rightly, its tables are the record's."""

from __future__ import annotations

import importlib
import json
import math
import os
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from clash.cases import FAR_M, Case, cases

import feeler

checkers = importlib.import_module("clash.checkers")
goals = importlib.import_module("clash.goals")
hard_cases = importlib.import_module("clash.hard_cases")
host = importlib.import_module("host")
pages = importlib.import_module("pages")
run = importlib.import_module("clash.run")
section = importlib.import_module("section")
tables = importlib.import_module("clash.tables")
timings = importlib.import_module("clash.timings")

Answer = checkers.Answer
SMALL = 10_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a short run of feeler alone leaves."""
    found: Path = tmp_path_factory.mktemp("clash")
    asked = ["--quick", "--only", "cases,times", "--peers", "none", "--sizes", "10k"]
    assert run.main([str(found), *asked]) == 0
    return found


@pytest.fixture
def result(folder: Path) -> Any:
    return json.loads((folder / "clash.json").read_text(encoding="utf-8"))


def case_of(name: str, root: Path) -> Case:
    (case,) = (case for case in cases(root / "testdata") if case.name == name)
    return case


def test_a_short_run_has_every_pair_and_stage(folder: Path, result: Any, root: Path) -> None:
    names = [case.name for case in cases(root / "testdata")]
    assert [case["name"] for case in result["cases"]["cases"]] == names
    (row,) = result["times"]["sizes"]
    found = feeler.clash(feeler.sample("engine", SMALL))
    assert row["pairs"]["clearance"] == len(found) > row["pairs"]["verdicts"] > row["pairs"]["depths"] > 0
    for cores in ("one_core_s", "all_cores_s"):
        assert {"index", "verdicts", "clearance", "depths"} <= row[cores].keys()
    text = (folder / "tables.md").read_text(encoding="utf-8")
    runs = sum(len(case["runs"]) for case in result["cases"]["cases"])
    assert f"| **right: verdicts** |  | {runs} of {runs} |" in text
    assert "| walls in line | clash, 50 mm | right |" in text
    assert "a short run" in text and "how deep" in text


@pytest.mark.parametrize(
    ("verdict", "figure", "checker", "answer", "is_verdict_right", "is_right"),
    [
        ("clash", 1.5, "peer", Answer("clash", 1.49), True, True),
        ("clash", 1.5, "peer", Answer("clash", 0.4), True, False),
        ("clash", 1.5, "peer", Answer("clash"), True, False),
        ("clash", None, "peer", Answer("clash"), True, True),
        ("clash", 1.5, "feeler", Answer("contact", 0.0), False, False),
        ("clash", 1e-6, "feeler", Answer("clash", 1.02e-6), True, False),
        ("contained", 0.75, "peer", Answer("clash", 0.75), True, True),
        ("contained", 0.75, "feeler", Answer("clash", 0.75), False, False),
        ("duplicate", 1.0, "peer", Answer("contact", 0.0), False, False),
        ("contact", 0.0, "peer", Answer("contact", 0.0), True, True),
        ("contact", 0.0, "peer", Answer("contact", 1e-6), True, False),
        ("none", None, "feeler", Answer("none"), True, True),
    ],
)
def test_right_from_wrong(
    verdict: str, figure: float | None, checker: str, answer: Any, is_verdict_right: bool, is_right: bool
) -> None:
    case = {"verdict": verdict, "figure": figure}
    assert hard_cases.is_verdict_right(case, checker, answer) == is_verdict_right
    assert hard_cases.is_right(case, checker, answer) == is_right


def test_a_wrong_verdict_is_missed_and_a_slow_stage_fails_nothing(result: Any) -> None:
    assert section.judged(goals.scorecard(result)) == 0
    wrong = deepcopy(result)
    wrong["cases"]["cases"][3]["runs"][0]["answers"]["feeler"] = ["contact", 0.0]
    assert section.judged(goals.scorecard(wrong)) == 1
    slow = deepcopy(result)
    (row,) = slow["times"]["sizes"]
    row["size"], row["one_core_s"]["verdicts"] = 1_600_000, 1.01
    row["one_core_s"].pop("volumes", None)
    missed = {goal.goal for goal in goals.scorecard(slow) if not goal.is_met}
    assert missed == {"verdicts", "volumes"} and section.judged(goals.scorecard(slow)) == 0
    assert "| 1 s | **1.01 s** |" in tables.times(slow["times"])


def test_a_cell_says_what_is_wrong(result: Any) -> None:
    found = deepcopy(result["cases"])
    (case,) = (each for each in found["cases"] if each["name"] == "one and a half metres of two")
    said: list[list[Any]] = [["clash", 0.9], ["clash", 0.4], ["clash", 0.4], ["contact", 0.0]]
    for each, given in zip(case["runs"], said, strict=True):
        each["answers"]["feeler"] = given
    assert "| clash, 900 mm | **1 of 4**: clash, 400 mm; contact |" in tables.cases(found)
    said = [["none", None], ["clash", None], ["clash", 2, "estimate"], ["clash", 0.9, "estimate"]]
    for each, given in zip(case["runs"], said, strict=True):
        each["answers"]["feeler"] = given
    assert "**1 of 4**: none; clash, no depth, ... |" in tables.cases(found)


def test_peers_that_are_missing_are_said(monkeypatch: pytest.MonkeyPatch, result: Any) -> None:
    monkeypatch.setitem(sys.modules, "fcl", None)
    monkeypatch.delitem(sys.modules, "fcl_engine", raising=False)
    monkeypatch.delitem(sys.modules, "clash.fcl_checker", raising=False)
    there, absent = checkers.peers(["python-fcl"])
    assert not there and absent["python-fcl"].startswith("not installed (")
    for name, make in (("cases", tables.cases), ("times", tables.times)):
        assert make({**result[name], "absent": absent}).count("python-fcl: not installed") == 1


def test_pairs_that_differ_are_counted() -> None:
    assert timings.compared({(0, 1), (0, 2)}, {(0, 1), (1, 2), (1, 3)}) == {"found": 2, "missed": 2, "made_up": 1}


def test_fcl_is_asked_rightly(root: Path) -> None:
    pytest.importorskip("fcl")
    (fcl,), _ = checkers.peers(["python-fcl"])
    gap = fcl.pair(case_of("gap of a millimetre", root).mockup(FAR_M))
    assert gap.verdict == "clearance" and math.isclose(gap.figure, 1e-3, rel_tol=1e-6)
    assert fcl.pair(case_of("apart by half a metre", root).mockup()) == Answer("none")
    assert fcl.pair(case_of("a corner on a corner", root).mockup()) == Answer("contact", 0.0)
    deep = fcl.pair(case_of("overlap of a micrometre", root).mockup())
    assert deep.verdict == "clash" and math.isclose(deep.figure, 1e-6, rel_tol=1e-6)
    mockup = feeler.sample("engine", SMALL)
    found, right = fcl.whole(mockup, 1), checkers.FeelerChecker().whole(mockup, 1)
    assert found.pairs["verdicts"] == right.pairs["verdicts"] and found.pairs["clearance"] == right.pairs["clearance"]
    assert found.pairs["depths"] & right.pairs["depths"] and found.seconds.keys() == {"index", *checkers.QUERIES}


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of SWIG's types
def test_ifcclash_is_asked_rightly(root: Path) -> None:
    pytest.importorskip("ifcclash")
    (ifcclash,), _ = checkers.peers(["ifcclash"])
    gap = ifcclash.pair(case_of("gap of a millimetre", root).mockup(FAR_M))
    assert gap.verdict == "clearance" and math.isclose(gap.figure, 1e-3, rel_tol=1e-6)
    assert ifcclash.pair(case_of("apart by half a metre", root).mockup()) == Answer("none")
    assert ifcclash.pair(case_of("flush, faces of equal size", root).mockup()) == Answer("contact", 0.0)
    deep = ifcclash.pair(case_of("walls in line, one of them lower", root).mockup())
    assert deep.verdict == "clash" and math.isclose(deep.figure, 0.05, rel_tol=1e-6)
    mockup = case_of("walls in line, one of them lower", root).mockup()
    found = ifcclash.whole(mockup, 2)
    assert found.pairs == {query: {(0, 1)} for query in checkers.QUERIES}
    assert found.seconds.keys() == {"index", *checkers.QUERIES}
    flush = ifcclash.whole(case_of("flush, faces of unequal size", root).mockup(), 1)
    assert flush.pairs == {"verdicts": {(0, 1)}, "clearance": {(0, 1)}, "depths": set()}


def test_figures_are_filled_where_the_markers_are(tmp_path: Path, root: Path, result: Any) -> None:
    blocks = [f"<!-- clash: {name} -->\nwhat was here\n<!-- end of clash: {name} -->\n" for name in tables.MAKERS]
    text = "# Clash\n\n" + "\n".join(blocks) + "\nafter\n"
    made = tables.SECTION.filled(text, result)
    assert (
        "what was here" not in made
        and "right: verdicts" in made
        and "how deep" in made
        and made.endswith("\n\nafter\n")
    )
    assert tables.SECTION.filled(made, result) == made
    assert "Not measured yet." in tables.SECTION.filled(text, {"cases": result["cases"]})
    for old, new in (("end of clash: times", "end of clash: time"), ("<!-- clash: times -->", "")):
        with pytest.raises(pages.PageError, match="has no end"):
            tables.SECTION.filled(text.replace(old, new), result)
    with pytest.raises(pages.PageError, match="'others'"):
        tables.SECTION.filled(text.replace("clash: times", "clash: others"), result)
    record, there = tmp_path / "record.json", tmp_path / "page.md"
    record.write_text(json.dumps(result), encoding="utf-8")
    there.write_text(text, encoding="utf-8")
    asked = [sys.executable, root / "bench" / "clash" / "figures.py", "--record", record, "--page", there]
    for extra, code in (["--check"], 1), ([], 0), (["--check"], 0):
        assert subprocess.run([*asked, *extra], capture_output=True, check=False).returncode == code
    assert there.read_text(encoding="utf-8") == made


def test_the_page_is_what_the_record_makes_it(root: Path) -> None:
    record = json.loads((root / "bench" / "records" / "clash.json").read_text(encoding="utf-8"))
    text = (root / "docs" / "clash.md").read_text(encoding="utf-8")
    assert tables.SECTION.filled(text, record) == text, "run bench/clash/figures.py"
    assert section.judged(goals.scorecard(record)) == 0


def test_a_record_keeps_what_a_run_leaves_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, result: Any) -> None:
    monkeypatch.setattr(section, "RECORDS", tmp_path)
    kept = tmp_path / "clash.json"
    kept.write_text(json.dumps({"cases": result["cases"], "times": {"of": "before"}}), encoding="utf-8")
    asked = ["--quick", "--only", "times", "--peers", "none", "--sizes", "10k", "--record", str(tmp_path / "out")]
    assert run.main(asked) == 0
    record = json.loads(kept.read_text(encoding="utf-8"))
    assert record["cases"] == result["cases"] and record["times"]["args"] == asked[:-2]


def test_one_core_is_given_and_taken_back(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[set[int]] = []
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {2, 5}, raising=False)
    monkeypatch.setattr(os, "sched_setaffinity", lambda _, cores: given.append(cores), raising=False)
    assert host.last_core() == 5
    with pytest.raises(KeyError), host.on_core(5):
        assert given == [{5}]
        raise KeyError
    with host.on_core(None):
        assert given == [{5}, {2, 5}]
