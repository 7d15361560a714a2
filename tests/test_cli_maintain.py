"""feeler maintain: lists, the last run, --fail-on, what it writes, and Ctrl-C."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from commands import error_of, run, run_json
from night_scene import driver, lid, parts, saved

import feeler
from feeler.io import write_stl


@pytest.fixture
def engine(tmp_path: Path) -> Path:
    return saved(tmp_path, "engine.feeler", parts(2))


def moved(tmp_path: Path) -> Path:
    meshes = parts(2)
    meshes["s1/lid"] = lid(1.0)
    return saved(tmp_path, "moved.feeler", meshes)


def test_the_last_run_and_what_differs(engine: Path, tmp_path: Path) -> None:
    (tmp_path / "lru.csv").write_text("part,keep,people\ns0/cover,,1\ns1/cover,s0/*,2\n")
    write_stl(tmp_path / "driver.stl", driver())
    options = ["--parts", tmp_path / "lru.csv", "--tool", tmp_path / "driver.stl"]
    last = tmp_path / "last.json"
    first = run_json("maintain", engine, *options, "--save", last, "--fail-on", "slower,unreachable")
    assert [row["state"] for row in first["rows"]] == ["out", "out"] and first["changes"] == []
    assert first["failing"] == {"slower": [], "unreachable": []} and first["written"] == {"save": str(last)}
    files = ["--html", tmp_path / "night.html", "--save", last, "--previous", last]
    said = run("maintain", moved(tmp_path), *options, *files, "--fail-on", "slower", code=1).stdout
    assert "2 of 2 come out, 1 changed, 1 kept" in said and "Slower: 1 row: s1/cover" in said
    assert "+10 s since lid moved" in said and f"run written to {last}" in said
    assert "+10 s since lid moved" in (tmp_path / "night.html").read_text()
    again = run_json("maintain", moved(tmp_path), *options, "--previous", last, "--fail-on", "slower")
    assert all(row["is_kept"] and row["delta"] == 0.0 for row in again["rows"])


def test_workers_find_the_same_rows(engine: Path) -> None:
    asked = ["maintain", engine, "--part", "s0/cover", "--part", "s1/cover"]
    assert run_json(*asked)["rows"] == run_json(*asked, "--workers", "2")["rows"]


def test_what_is_wrong_is_said(engine: Path, tmp_path: Path) -> None:
    asked = ["maintain", engine]
    assert "give a list" in error_of(*asked)
    one = [*asked, "--part", "s0/cover"]
    assert "give one of them" in error_of(*one, "--parts", tmp_path / "lru.csv")
    assert "do you mean slower" in error_of(*one, "--fail-on", "slow")
    assert "leave out --tool" in error_of(*one, "--tools", "built-in", "--tool", "sample:wrench")
    assert "--grip is for --tool" in error_of(*one, "--grip", "z")
    assert "first run" in error_of(*one, "--previous", tmp_path / "none.json")
    assert "must end in .json" in error_of(*one, "--save", tmp_path / "last.txt")
    assert "parts[0]" in error_of(*asked, "--part", "s9/*")
    (tmp_path / "lru.csv").write_text("part\ns0/cover\n\ns9/cover\n")
    assert f"{tmp_path / 'lru.csv'}, line 4: " in error_of(*asked, "--parts", tmp_path / "lru.csv")
    assert "does not exist" in error_of(*asked, "--parts", tmp_path / "none.csv")


def test_ctrl_c_writes_what_is_done(engine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = feeler.maintain(feeler.open_scene(engine), ["s0/cover", "s1/cover"])
    first = next(iter(whole.plans))
    rest = (whole.names, whole.own_paths, {first: whole.plans[first]}, frozenset(), whole.options, whole.snapshot)
    some = feeler.Maintenance(*rest, None, True)

    def interrupted(*_: Any, **__: Any) -> None:
        raise feeler.MaintenanceInterrupted(some)

    monkeypatch.setattr(feeler, "maintain", interrupted)
    asked = ["maintain", engine, "--part", "s0/cover", "--part", "s1/cover", "--save", tmp_path / "last.json"]
    assert "interrupted" in run(*asked, code=130).stdout
    assert json.loads((tmp_path / "last.json").read_text())["is_partial"]
    monkeypatch.undo()
    rows = run_json(*asked, "--previous", tmp_path / "last.json")["rows"]
    assert [row["is_kept"] for row in rows] == [True, False]
