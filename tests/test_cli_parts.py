"""Parts out, parts as the tool, touching and insides on the command line: what is answered, said and refused."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of, run, run_json
from shapes import box, cube, inverted, joined, mockup_of

import feeler
from feeler.io import write_glb

COMMANDS = ("collide", "clearance", "path")


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pump seated in a case, a gasket around it that it crosses, and a hood 30 mm above."""
    path = tmp_path_factory.mktemp("engine") / "engine.glb"
    shapes = {
        "case/left": box((-0.03125, -0.03125, -0.03125), (-0.0078125, 0.03125, 0)),
        "case/right": box((0.0078125, -0.03125, -0.03125), (0.03125, 0.03125, 0)),
        "fuel pump": box((-0.0078125, -0.0078125, -0.03125), (0.0078125, 0.0078125, 0.015625)),
        "seals/gasket": box((-0.015625, -0.015625, 0), (0.015625, 0.015625, 0.001953125)),
        "hood": box((-0.0625, -0.0625, 0.0625), (0.0625, 0.0625, 0.078125)),
    }
    write_glb(path, mockup_of(shapes))
    return path


@pytest.fixture(scope="module")
def way_out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Poses from 0 to 40 mm up: the first two under the hood, the last less than 10 mm from it."""
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 2, 3] = 0, 0.015625, 0.04
    path = tmp_path_factory.mktemp("poses") / "out.npy"
    np.save(path, poses)
    return path


def ask(command: str, engine: Path, way: Path, *words: str | Path, code: int = 0) -> Any:
    """A command that asks for a way, or for its first pose."""
    where = ["--poses", way] if command == "path" else ["--pose", way]
    return run_json(command, engine, *words, *where, code=code)


PUMP = ["--part", "*pump*"]


# --- what moves, stays and is left out -------------------------------------------------------------------------------


def test_a_part_moves_and_is_not_in_its_own_way(engine: Path) -> None:
    document = run_json("collide", engine, *PUMP, code=1)
    (entry,) = document["poses"]
    hit = {part["path"].partition("engine/")[2]: part for part in entry["parts"]}
    assert set(hit) == {"case/left", "case/right", "seals/gasket"}
    assert hit["seals/gasket"]["kinds"]["crossing"] > 0 and hit["case/left"]["kinds"]["crossing"] == 0
    assert document["tool"]["name"] == "fuel pump" and document["tool"]["triangles"] == 12
    assert hit["case/left"]["tool_parts"] == ["engine/fuel pump"]
    assert document["scene"]["build_s"] > 0, "the index's, not the selection's"
    # Without a pose the part is where it is; elsewhere by --at.
    assert entry["world_from_tool"] == np.eye(4).tolist()
    far = run_json("collide", engine, *PUMP, "--at", "1,0,0")
    assert far["colliding"] is False and far["free"] is True


def test_the_same_with_meshes_made_by_hand(engine: Path, way_out: Path, tmp_path: Path) -> None:
    whole = feeler.load_mockup(engine)
    out = np.isin(whole.part_of_face, whole.parts.select(["fuel pump", "gasket"]))
    moving = whole.part_of_face == whole.parts.select("fuel pump")[0]
    rest = feeler.Mockup(whole.vertices, whole.faces[~out], whole.part_of_face[~out], whole.part_names)
    write_glb(tmp_path / "rest.glb", rest)
    write_glb(tmp_path / "pump.glb", feeler.Mockup(whole.vertices, whole.faces[moving]))
    by_hand = ["--tool", tmp_path / "pump.glb"]
    for command, key in (("collide", "pairs"), ("clearance", "distance_m")):
        ours = ask(command, engine, way_out, *PUMP, "--without", "gasket", code=int(command == "collide"))
        theirs = ask(command, tmp_path / "rest.glb", way_out, *by_hand, code=int(command == "collide"))
        assert [entry[key] for entry in ours["poses"]] == [entry[key] for entry in theirs["poses"]]
    ours = ask("path", engine, way_out, *PUMP, "--without", "gasket", code=1)
    theirs = ask("path", tmp_path / "rest.glb", way_out, *by_hand, code=1)
    assert [hit["segment"] for hit in ours["hits"]] == [hit["segment"] for hit in theirs["hits"]]


@pytest.mark.parametrize(
    ("words", "free"),
    [
        (PUMP, False),
        ([*PUMP, "--without", "*gasket*"], True),
        ([*PUMP, "--without", "seals"], True),
        ([*PUMP, "--only", "case", "--only", "hood"], True),
        ([*PUMP, "--only", "*gasket*"], False),
        ([*PUMP, "--part", "*gasket*"], True),
        ([*PUMP, "--without", "gasket", "--without", "case"], True),
    ],
    ids=str,
)
def test_a_pump_is_drawn_out(engine: Path, way_out: Path, words: list[str], free: bool) -> None:
    # The names of parts have the file's in front: a path is given as the file has it below that.
    words = [f"engine/{word}" if word in ("seals", "case") else word for word in words]
    document = ask("path", engine, way_out, *words, "--touching", "free", code=int(not free))
    assert document["free"] is free and document["touching"] == "free"
    assert document["inside"] == {"containing": [], "contained": [], "unknown": []}
    if not free:
        assert document["hits"][0]["path"].endswith("gasket") and document["hits"][0]["tool_path"].endswith("fuel pump")
        assert {part["path"] for part in document["parts"]} == {document["hits"][0]["path"]}


def test_touching_counts_unless_it_is_free(engine: Path, way_out: Path) -> None:
    words = [*PUMP, "--without", "gasket"]
    for command in ("collide", "path"):
        assert ask(command, engine, way_out, *words, code=1)["free"] is False
        assert ask(command, engine, way_out, *words, "--touching", "counts", code=1)["free"] is False
        assert ask(command, engine, way_out, *words, "--touching", "free")["free"] is True
    document = ask("collide", engine, way_out, *words, "--touching", "free")
    assert [entry["colliding"] for entry in document["poses"]] == [False] * 3
    # Pairs and parts that touch are listed all the same.
    assert document["poses"][0]["pairs"] > 0 and len(document["poses"][0]["parts"]) == 2
    text = run("collide", engine, *words, "--touching", "free").stdout
    assert "Contact only" in text and "Parts in contact" in text and "hit" not in text.split("\n\n")[0]
    text = run("collide", engine, *words, "--touching", "free", "--pose", way_out).stdout
    assert "0 of 3 poses collide" in text and text.count("touches") == 2 and "most pairs:" not in text


def test_the_pose_that_is_shown_is_one_that_collides(engine: Path, tmp_path: Path) -> None:
    """Where touching is free, the most pairs may be at a pose that only touches."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, :3, 3] = 0.05, 0.001, 0.0703125
    np.save(tmp_path / "two.npy", poses)
    words = ["collide", engine, *PUMP, "--without", "gasket", "--touching", "free", "--pose", tmp_path / "two.npy"]
    document = run_json(*words, code=1)
    assert [entry["colliding"] for entry in document["poses"]] == [False, True]
    assert document["poses"][0]["pairs"] > document["poses"][1]["pairs"]
    text = run(*words, "--glb", tmp_path / "a.glb", code=1).stdout
    assert "at pose 1" in text and "glb of pose 1 written" in text


def test_several_parts_move_as_one(engine: Path, way_out: Path, tmp_path: Path) -> None:
    words = [*PUMP, "--part", "gasket"]
    document = run_json("collide", engine, *words, code=1)
    left = next(part for part in document["poses"][0]["parts"] if part["path"].endswith("left"))
    assert left["tool_parts"] == ["engine/fuel pump", "engine/seals/gasket"]
    assert document["tool"]["parts"] == 2
    text = run("collide", engine, *words, code=1).stdout
    assert "parts of the mock-up: 24 triangles, 2 parts" in text and "engine/seals/gasket" in text
    rows = run_json("clearance", engine, *words, "--within", "0.1")["poses"][0]["parts"]
    hood = next(row for row in rows if row["path"].endswith("hood"))
    assert (hood["tool_path"], hood["tool_part"]) == ("engine/fuel pump", 0)
    assert hood["distance_m"] == pytest.approx(0.046875, abs=1e-6)
    assert "tool part" in run("clearance", engine, *words, "--within", "0.1").stdout
    target = tmp_path / "gaps.csv"
    run("clearance", engine, *words, "--within", "0.1", "--csv", target)
    lines = rows_of(target)
    assert {line["tool_part"] for line in lines if line["path"].endswith("hood")} == {"engine/fuel pump"}
    run("path", engine, *words, "--poses", way_out, "--csv", tmp_path / "hits.csv", code=1)
    lines = rows_of(tmp_path / "hits.csv")
    assert lines and {line["tool_part"] for line in lines} <= {"engine/fuel pump", "engine/seals/gasket"}
    assert "tool part" in run("path", engine, *words, "--poses", way_out, code=1).stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_a_picture_shows_what_is_there(engine: Path, way_out: Path, tmp_path: Path, command: str) -> None:
    """Neither what is left out, nor what moves in its old place."""
    target = tmp_path / "out.glb"
    words = [*PUMP, "--without", "*right", "--glb", target]
    ask(command, engine, way_out, *words, code=int(command != "clearance"))
    shown = feeler.load_mockup(target)
    assert sum("right" in path for path in shown.part_paths) == 0
    assert sum("pump" in path for path in shown.part_paths) == 1
    assert sum("hood" in path for path in shown.part_paths) == 1
    if command == "collide":
        run("collide", engine, *words, "--picture", tmp_path / "out.png", "--picture-size", "160x100", code=1)
        assert (tmp_path / "out.png").is_file()


def test_what_is_left_out_is_counted(engine: Path) -> None:
    text = run("collide", engine, *PUMP, "--without", "gasket", "--without", "hood", code=1).stdout
    assert "60 triangles, 5 parts (2 left out)" in text
    assert "engine/fuel pump of the mock-up: 12 triangles" in text
    assert "left out" not in run("collide", engine, *PUMP, code=1).stdout


# --- what is inside --------------------------------------------------------------------------------------------------


def test_a_pin_in_a_block(testdata: Path, tmp_path: Path) -> None:
    """It meets nothing, and has no room: exit status 1, and the block is named."""
    files = testdata / "files"
    words = [files / "contain_block.obj", "--tool", files / "contain_pin.obj"]
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = 0.05
    np.save(tmp_path / "two.npy", poses)
    here, way = ["--at", "0,0,0"], ["--poses", tmp_path / "two.npy"]

    result = run("collide", *words, *here, code=1)
    assert "The tool is inside contain_block" in result.stdout and "No collision" not in result.stdout
    document = run_json("collide", *words, *here, code=1)
    assert (document["colliding"], document["free"]) == (False, False)
    inside = [{"part": 0, "path": "contain_block", "name": "contain_block"}]
    assert document["poses"][0]["inside"] == {"containing": inside, "contained": [], "unknown": []}
    text = run("collide", *words, "--pose", tmp_path / "two.npy", code=1).stdout
    assert "0 of 2 poses collide, and 2 have one body inside the other" in text

    text = run("clearance", *words, *here, "--require", "0.002", code=1).stdout
    assert "The tool is inside contain_block" in text and "95 mm" in text and "no clearance" in text
    assert "enough" not in text and "No part is within 5 mm" in text
    document = run_json("clearance", *words, *here, "--require", "0.002", code=1)
    assert document["met"] is False and document["distance_m"] == pytest.approx(0.095)
    assert document["poses"][0]["inside"]["containing"] == inside
    assert run_json("clearance", *words, *here, code=1)["met"] is None

    text = run("path", *words, *way, code=1).stdout
    assert "The path is not free: at the first pose the tool is inside contain_block" in text
    document = run_json("path", *words, *way, code=1)
    assert document["free"] is False and document["hits"] == [] and document["inside"]["containing"] == inside
    # The same with roles exchanged.
    words = [files / "contain_pin.obj", "--tool", files / "contain_block.obj"]
    assert "Inside the tool: contain_pin" in run("collide", *words, *here, code=1).stdout
    # Beside it there is room.
    away = [files / "contain_block.obj", "--tool", files / "contain_pin.obj", "--at", "0.2,0,0"]
    assert "No collision" in run("collide", *away).stdout
    assert "enough" in run("clearance", *away, "--require", "0.002").stdout


def test_clearance_shows_the_pose_that_is_inside(testdata: Path, tmp_path: Path) -> None:
    """Though another pose is nearer to a surface, from outside."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[0, 0, 3] = 0.11
    np.save(tmp_path / "two.npy", poses)
    files = testdata / "files"
    words = [files / "contain_block.obj", "--tool", files / "contain_pin.obj", "--pose", tmp_path / "two.npy"]
    text = run("clearance", *words, "--require", "0.004", code=1).stdout
    assert "The tool is inside contain_block at pose 1 of 2" in text and "too little at 1 pose\n" in text
    document = run_json("clearance", *words, "--require", "0.004", code=1)
    assert [entry["met"] for entry in document["poses"]] == [True, False]


def test_what_cannot_be_told_is_said(tmp_path: Path) -> None:
    vertices, faces = cube((0, 0, 0), 4)
    hollow = joined(cube((10, 0, 0), 4), inverted(cube((10, 0, 0), 2)))
    world = mockup_of({"tub": (vertices, faces[:-2]), "vessel": hollow})
    write_glb(tmp_path / "world.glb", world)
    write_glb(tmp_path / "pea.glb", mockup_of({"pea": cube((0, 0, 0), 0.1)}))
    words = [tmp_path / "world.glb", "--tool", tmp_path / "pea.glb"]
    for command in ("collide", "clearance"):
        text = run(command, *words, "--at", "0,0,0").stdout
        assert "Containment not known, because these parts are open: world/tub" in text
        assert "Not known" not in run(command, *words, "--at", "10,0,0").stdout, "in a hollow there is room"
        assert "inside world/vessel" in run(command, *words, "--at", "11.5,0,0", code=1).stdout
    assert [part["name"] for part in run_json("collide", *words, "--at", "0,0,0")["poses"][0]["inside"]["unknown"]] == [
        "tub"
    ]
    np.save(tmp_path / "one.npy", np.eye(4))
    assert "containment not known" in run("path", *words, "--poses", tmp_path / "one.npy").stdout


# --- what is refused, and help ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--part", "*pumb*"],
            "--part: no part matches '*pumb*'; do you mean 'fuel pump'? (feeler info --parts",
        ),
        (["--part", "FUEL PUMP"], "do you mean 'fuel pump'"),
        ([*PUMP, "--without", "gaskets"], "--without: no part has the path or name 'gaskets'; do you mean 'gasket'?"),
        ([*PUMP, "--only", "*zzzz*"], "--only: no part matches '*zzzz*'"),
        ([*PUMP, "--only", "*pump*"], "no part of the mock-up is left"),
        (["--part", "*"], "no part of the mock-up is left"),
        ([*PUMP, "--without", "*"], "no part of the mock-up is left"),
        ([], "nothing moves: give --tool FILE, or --part PATTERN"),
        ([*PUMP, "--tool", "sample:wrench"], "--tool and --part are both given"),
        ([*PUMP, "--tool-unit", "mm"], "--tool-unit is for --tool"),
    ],
    ids=str,
)
def test_wrong_words(engine: Path, way_out: Path, command: str, words: list[str], said: str) -> None:
    where = ["--poses", way_out] if command == "path" else ["--pose", way_out]
    assert said in error_of(command, engine, *words, *where)


def test_wrong_touching(engine: Path, way_out: Path) -> None:
    for command, where in (("collide", "--pose"), ("path", "--poses")):
        message = error_of(command, engine, *PUMP, "--touching", "maybe", where, way_out)
        assert "--touching is 'maybe': choose counts, free" in message


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_examples(command: str) -> None:
    text = run(command, "--help").stdout
    examples = text.partition("Examples")[2]
    assert "--part" in examples
    for option in ("--part", "--without", "--only"):
        assert option in text
    assert ("--touching" in text) == (command != "clearance")
