"""`feeler sight`: what it says, what it writes, how it ends."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from commands import error_of, run, run_json
from shapes import box, mockup_of

from feeler.io import write_glb
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two bolts on a plate, one of them under a roof, and a wall beside."""
    bolt = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    parts = {
        "plate": box((-0.1, -0.1, -0.02), (1.0, 0.1, -0.001)),
        "open/bolt": (bolt.vertices, bolt.faces),
        "roof/bolt": (np.add(bolt.vertices, (0.6, 0.0, 0.0)), bolt.faces),
        "roof/box": box((0.5, -0.1, 0.006), (0.7, 0.1, 0.1)),
    }
    path = tmp_path_factory.mktemp("stand") / "stand.glb"
    write_glb(path, mockup_of(parts))
    return path


def test_what_people_read(stand: Path) -> None:
    text = run("sight", stand, "--eye", "0,0,1", "--kind", "bolt", code=1).stdout
    assert "1 of 2 targets are seen from 1 eye" in text
    rows = [line.split() for line in text.splitlines() if line.lstrip().startswith("stand/")]
    assert [row[:2] for row in rows] == [["stand/roof/bolt", "0%"], ["stand/open/bolt", "100%"]]
    assert rows[0][2:] == ["none", "stand/roof/box", "100%"]
    open_one = run("sight", stand, "--eye", "0,0,1", "--targets", "*open*").stdout
    assert "1 of 1 target are seen" not in open_one and "1 of 1 target is seen" in open_one


def test_what_machines_read(stand: Path, tmp_path: Path) -> None:
    table = tmp_path / "seen.csv"
    words = ["--from", "-0.1,-0.1,0.9", "--to", "0.1,0.1,1", "--eyes", "8", "--eye", "0.1m,0m,1m"]
    document = run_json("sight", stand, *words, "--kind", "bolt", "--csv", table, code=1)
    assert (document["targets"], document["not_seen"], len(document["eyes_m"])) == (2, 1, 9)
    assert document["eyes_m"][0] == [0.1, 0.0, 1.0]
    seen, hidden = document["rows"]
    assert seen["share"] == 1.0 and seen["eye_m"] == document["eyes_m"][seen["eye"]] and seen["hidden_by"] == []
    assert hidden["share"] == 0.0 and hidden["eye"] is None and hidden["hidden_by"] == [["stand/roof/box", 1.0]]
    with table.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["share"] for row in rows] == ["1.0", "0.0"] and rows[1]["hidden_by"] == "stand/roof/box"


def test_parts_are_looked_at_from_all_sides(stand: Path) -> None:
    # A closed part is seen by half from one side, so that more than half is required in vain.
    row = run_json("sight", stand, "--eye", "0,0,1", "--parts", "*roof/box", "--require", "0.1")["rows"][0]
    assert 0.1 < row["share"] < 0.6
    run("sight", stand, "--eye", "0,0,1", "--parts", "*roof/box", "--require", "0.7", code=1)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "there are no eyes: give --eye X,Y,Z, or a box by --from X,Y,Z and --to X,Y,Z"),
        (["--from", "0,0,0"], "--from and --to are two corners of a box: give both"),
        (["--from", "0,0,1", "--to", "0,0,0"], "give the lower corner first"),
        (["--eye", "0,0"], "--eye is '0,0': give three lengths"),
        (["--eye", "0,0,1", "--parts", "nothing*"], "--parts: "),
        (["--eye", "0,0,1", "--parts", "*bolt", "--kind", "bolt"], "leave out --targets and --kind"),
        (["--eye", "0,0,1", "--require", "50"], "--require is '50': give a share from 0 to 1"),
        (["--eye", "0,0,1", "--kind", "nut"], "no part of the mock-up looks like a nut"),
    ],
)
def test_what_is_wrong_is_said(stand: Path, words: list[str], said: str) -> None:
    assert said in error_of("sight", stand, *words)
