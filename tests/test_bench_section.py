"""The part that the sections of the bench share: options, errors, results that are added, records."""

from __future__ import annotations

import argparse
import importlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

pages = importlib.import_module("pages")
section = importlib.import_module("section")

ABOUT = "What it does.\n\n    an example\n\nWhat it writes."


def judge(found: dict[str, Any]) -> Iterator[Any]:
    yield section.Goal("one", "value", "3", str(found["value"]), found["value"] == 3)


JUDGES = {"one": judge, "other": judge}


def scorecard(result: dict[str, Any]) -> list[Any]:
    return [goal for found in result["parts"].values() for goal in section.scorecard(JUDGES, found)]


def tables(result: dict[str, Any]) -> dict[str, str]:
    return {"one": ", ".join(result["parts"])}


TOY = section.Section("toy", "toy.md", list(JUDGES), tables, scorecard, "parts")


def parse(given: Sequence[str]) -> argparse.Namespace:
    parser = TOY.parser(ABOUT, "short")
    parser.add_argument("--value", type=int, default=section.Form(3, 1))
    parser.add_argument("--part", default="bolt")
    options: argparse.Namespace = TOY.options(parser, given)
    return options


def run(options: argparse.Namespace) -> dict[str, Any]:
    def one() -> dict[str, Any]:
        return {"value": options.value}

    def other() -> dict[str, Any]:
        raise ValueError("no such thing")

    ways = {"one": one, "other": other}
    found = section.attempted(options.part, {name: ways[name] for name in options.only})
    result: dict[str, Any] = section.measured(lambda: {"parts": {options.part: found}}, options)
    return result


def ran(*given: str) -> int:
    status: int = TOY.main(parse, run, given)
    return status


def test_a_default_has_two_forms_and_a_given_value_counts() -> None:
    values = [parse(given).value for given in ([], ["--quick"], ["--quick", "--value", "0"])]
    assert values == [3, 1, 0] and parse(["--only", ""]).only == ["one", "other"]
    with pytest.raises(SystemExit):
        parse(["--only", "third"])


def test_an_experiment_that_stops_is_a_missed_goal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ran(str(tmp_path), "--only", "one") == 0
    assert ran(str(tmp_path), "--only", "one", "--value", "2") == 1
    assert ran(str(tmp_path)) == 1
    said = capsys.readouterr().out
    assert "missed  one: value: 2 (wanted: 3)" in said
    assert "missed  other: it runs: ValueError: no such thing (wanted: no error)" in said
    found = json.loads((tmp_path / "toy.json").read_text(encoding="utf-8"))
    assert found["parts"]["bolt"]["one"] == {"value": 3}, "the other's error left it alone"
    assert (tmp_path / "tables.md").read_text(encoding="utf-8") == "# Toy\n\n## One\n\nbolt\n"


def test_results_are_added_and_the_record_is_the_whole(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(section, "RECORDS", tmp_path)
    out = str(tmp_path / "out")
    for part in ("bolt", "nut"):
        assert ran(out, "--add", "--part", part, "--only", "one", "--value", "3", "--quick") == 0
    assert ran(out, "--add", "--part", "nut", "--only", "other", "--record") == 1
    record = json.loads((tmp_path / "toy.json").read_text(encoding="utf-8"))
    assert [list(found) for found in record["parts"].values()] == [["one"], ["one", "other"]]
    bolt = ["--part", "bolt", "--only", "one", "--value", "3", "--quick"]
    nut = [*bolt[:1], "nut", *bolt[2:]]
    assert record["args"] == [*bolt, "and", *nut, "and", "--part", "nut", "--only", "other"]
    assert record["is_quick"] and record["parts"]["bolt"]["one"] == {"value": 3}
    assert ran(out, "--only", "one", "--record") == 0
    assert list(json.loads((tmp_path / "toy.json").read_text(encoding="utf-8"))["parts"]) == ["bolt"]


def test_peers_that_are_left_out_are_said_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = parse([str(tmp_path)])
    ways = {name: lambda: {"value": 3} for name in JUDGES}
    result = section.measured_each(ways, options, {"a peer": "1.0"}, {"another": "not installed"})
    assert capsys.readouterr().err == "another is left out: not installed\n"
    assert list(result) == options.only and all(found["value"] == 3 for found in result.values())
    assert result["one"]["versions"]["a peer"] == "1.0" and result["one"]["absent"] == {"another": "not installed"}


def test_what_the_record_lacks_is_said_and_what_nobody_makes_is_an_error() -> None:
    block = "<!-- toy: {0} -->\nold\n<!-- end of toy: {0} -->\n"
    result = {"parts": {"bolt": {}}}
    assert TOY.filled(block.format("one"), result) == block.format("one").replace("old", "bolt")
    assert TOY.filled(block.format("other"), result) == block.format("other").replace("old", "Not measured yet.")
    with pytest.raises(pages.PageError, match="'third'"):
        TOY.filled(block.format("third"), result)


@pytest.mark.parametrize("name", ["clash", "feel", "removal", "workbench"])
def test_a_section_runs_nothing_zero_times(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    count = {"feel": "--runs", "removal": "--seeds"}.get(name, "--repeats")
    with pytest.raises(SystemExit):
        importlib.import_module(f"{name}.run").parse([count, "0"])
    assert "no number of at least 1" in capsys.readouterr().err
