"""`feeler remove`: as people type it, and as machines read it."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of
from commands import run as run_program
from shapes import box, cube, inverted, joined, mockup_of, open_chest

import feeler
from feeler.io import write_glb

# An open chest with a thing in it under a lid, and a second thing on the lid; metres.
PARTS = {
    "chest": open_chest(),
    "lid": box((0.046875, 0.046875, 0.25), (0.453125, 0.453125, 0.28125)),
    "things/[1] lower": cube((0.1875, 0.1875, 0.125), 0.125),
    "things/upper": cube((0.25, 0.25, 0.34375), 0.125),
}


def run(*words: object, status: int = 0) -> Any:
    return run_program("remove", *map(str, words), code=status)


@pytest.fixture(scope="module")
def chest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("chest") / "chest.glb"
    write_glb(path, mockup_of(PARTS))
    return path


def test_a_part_that_comes_out(chest: Path, tmp_path: Path) -> None:
    way, glb = tmp_path / "way.npy", tmp_path / "way.glb"
    text = run(chest, "--part", "upper", "--way", way, "--glb", glb, "--threads", 1).stdout
    assert re.search(r"It comes out: move [\d.]+ mm along \+z\b", text) and "things/upper" in text
    poses = np.load(way)
    np.testing.assert_array_equal(poses[0], np.eye(4))
    # What was written is a way for `feeler path`.
    run_program("path", chest, "--part", "upper", "--poses", way, "--touching", "free")
    head = glb.read_bytes()
    length = int.from_bytes(head[12:16], "little")
    film = json.loads(head[20 : 20 + length])
    moved = {film["nodes"][channel["target"]["node"]]["name"] for channel in film["animations"][0]["channels"]}
    assert moved == {"upper"}
    assert len(film["materials"]) == 2  # blue and grey: nothing blocked it
    # What is near is shown.
    assert {"lid", "upper", "chest", "[1] lower"} <= {*feeler.load_mockup(glb).part_names}


def test_legs_are_saved_and_followed(chest: Path, tmp_path: Path) -> None:
    way = tmp_path / "way.json"
    run(chest, "--part", "upper", "--way", way, "--threads", 1)
    saved = json.loads(way.read_text())
    assert [leg["says"].split()[0] for leg in saved["legs"]] == ["move"] and len(saved["poses"]) == 2
    again = ["path", chest, "--part", "upper", "--touching", "free", "--poses", way]
    run_program(*again)
    # A turn by half a circle about an edge of the chest: into its side.
    screw = {"axis": [1, 0, 0], "point": [0, 0, 0], "angle": 3.0, "pitch": 0.0}
    way.write_text(json.dumps({"legs": [{"screw": screw}]}))
    run_program(*again, code=1)
    way.write_text(json.dumps({"legs": [{"screw": {**screw, "axis": [0, 0, 0]}}]}))
    assert "axis" in error_of(*again)


def test_a_part_that_does_not(chest: Path, tmp_path: Path) -> None:
    glb = tmp_path / "try.glb"
    words = ("--part", "*lower", "--seconds", 1, "--threads", 1, "--glb", glb)
    text = run(chest, *words, status=1).stdout
    assert "No path was found; that is no proof that there is none" in text
    assert "What blocked it" in text and "lid" in text
    length = int.from_bytes(glb.read_bytes()[12:16], "little")
    film = json.loads(glb.read_bytes()[20 : 20 + length])
    assert len(film["materials"]) == 3  # red: what blocked it
    found = json.loads(run(chest, *words[:-2], "--json", status=1).stdout)
    (step,) = found["parts"][0]["steps"]
    assert not found["found"] and "poses" not in step
    assert "lid" in {each["path"].split("/")[-1] for each in step["blocked_by"]}


def test_each_for_itself(chest: Path, tmp_path: Path) -> None:
    table = tmp_path / "parts.csv"
    words = ("--part", "*things*", "--each", "--seconds", 1, "--threads", 1)
    text = run(chest, *words, "--csv", table, status=1).stdout
    assert "1 of 2 parts come out" in text
    rows = list(csv.DictReader(table.read_text(encoding="utf-8-sig").splitlines()))
    assert [(row["path"].split("/")[-1], row["found"]) for row in rows] == [("[1] lower", "0"), ("upper", "1")]
    assert "lid" in rows[0]["blocked_by"] and float(rows[1]["path_length_m"]) > 0.0


def test_an_order(chest: Path) -> None:
    found: dict[str, Any] = json.loads(
        run(chest, "--part", "*lower", "--order", "--keep", "*/chest", "--seconds", 10, "--threads", 1, "--json").stdout
    )
    steps = found["parts"][0]["steps"]
    assert [step["parts"][0]["path"].split("/")[-1] for step in steps] == ["upper", "lid", "[1] lower"]
    assert all(step["found"] for step in steps) and "stuck" not in found["parts"][0]


def test_an_order_that_is_not_found_says_what_stops_it(tmp_path: Path) -> None:
    """The box is stopped by the lid, the lid by the room, and the room by the chest in it, which stays."""
    lid = box((0.0, 0.0, 0.3125), (0.5, 0.5, 0.34375))
    hollow = inverted(box((-1.0, -1.0, -0.125), (1.5, 1.5, 1.0)))
    room = joined(box((-1.125, -1.125, -0.25), (1.625, 1.625, 1.125)), hollow)
    thing = cube((0.1875, 0.1875, 0.125), 0.125)
    write_glb(tmp_path / "room.glb", mockup_of({"chest": open_chest(), "thing": thing, "lid": lid, "room": room}))
    words = (tmp_path / "room.glb", "--part", "thing", "--order", "--keep", "chest", "--threads", 1, "--rounds", 2)
    found = json.loads(run(*words, "--json", status=1).stdout)["parts"][0]
    assert [each["path"] for each in found["stuck"]] == ["room/room"]
    assert [each["path"] for each in found["blocked_by"]] == ["room/chest"] and found["blocked_by"][0]["count"] > 0
    text = " ".join(run(*words, status=1).stdout.split())
    assert "No order was found; that is no proof" in text
    assert "The search ended at room/room, which does not come out" in text
    assert re.search(r"What blocked it .* room/chest ", text)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "no part to take out"),
        (("--part", "pump"), "'pump'"),
        (("--part", "*"), "parts names all 4 parts of the scene"),
        (("--part", "lid", "--seconds", 0), "seconds"),
        (("--part", "lid", "--clearance", -1), "clearance"),
        (("--part", "lid", "--direction", "up"), "--direction"),
        (("--part", "lid", "--direction", "0,0,0"), "direction"),
        (("--part", "lid", "--overlap", "-0.001"), "--overlap is '-0.001'"),
        (("--part", "lid", "--ignore", "*gasket*"), "gasket"),
        (("--part", "lid", "--way", "way.txt"), ".npy or .json"),
        (("--part", "lid", "--each", "--order"), "--each"),
        (("--part", "lid", "--keep", "chest"), "--order"),
        (("--part", "lid", "--at", "0,0,0"), "--hand"),
        (("--part", "lid", "--hand", "nothing.stl"), "nothing.stl"),
    ],
)
def test_bad_words_are_told(chest: Path, words: tuple[object, ...], said: str) -> None:
    assert said in run(chest, *words, status=2).stderr


def test_a_path_in_is_told_and_written(chest: Path, tmp_path: Path) -> None:
    here, way = tmp_path / "here.json", tmp_path / "way.json"
    lies = np.eye(4)
    lies[:3, 3] = [1.0, 0.0, -0.25]
    here.write_text(json.dumps(lies.tolist()))
    text = run(chest, "--part", "upper", "--insert", "--from", here, "--way", way).stdout
    assert "It goes in:" in text
    np.testing.assert_allclose(json.loads(way.read_text())["poses"][0], lies)
    np.testing.assert_allclose(json.loads(way.read_text())["poses"][-1], np.eye(4))
    assert "Ways in" in text and "Ways out" not in text
    facts = json.loads(run(chest, "--part", "upper", "--insert", "--goal", here, "--json").stdout)
    np.testing.assert_allclose(facts["parts"][0]["steps"][0]["poses"][-1], lies)
    for words, said in (
        (["--goal", here], "--goal is for --insert"),
        (["--insert", "--each"], "--insert is for one path"),
        (["--insert", "--from", tmp_path / "none.json"], "none.json"),
    ):
        assert said in run(chest, "--part", "upper", *words, status=2).stderr


def test_what_holds_a_part_is_told(tmp_path: Path) -> None:
    shell = {
        f"shell/{'xyz'[axis]}{side}": box(
            [-0.02 if a != axis else (0.0101 if side else -0.02) for a in range(3)],
            [0.02 if a != axis else (0.02 if side else -0.0101) for a in range(3)],
        )
        for axis in range(3)
        for side in (0, 1)
    }
    path = tmp_path / "shell.glb"
    write_glb(path, mockup_of({"core": box((-0.01, -0.01, -0.01), (0.01, 0.01, 0.01)), **shell}))
    text = run(path, "--part", "core", status=1).stdout
    assert "It is held by" in text and "and 3 other parts" in text and "can move farther than" in text
    step = json.loads(run(path, "--part", "core", "--json", status=1).stdout)["parts"][0]["steps"][0]
    assert {each["path"].rpartition("/")[2] for each in step["held_by"]} == {"x0", "x1", "y0", "y1", "z0", "z1"}
    assert 1e-4 <= step["play_m"] < 1e-3
