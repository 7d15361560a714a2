"""`feeler access`: what it says, what it writes, how it ends."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from commands import error_of, run, run_json
from shapes import at, box, mockup_of

import feeler
from feeler.io import write_glb, write_stl
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance


def bolt(x: float) -> tuple[np.ndarray, np.ndarray]:
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    return mesh.vertices + np.array([x, 0.0, 0.0]), mesh.faces


@pytest.fixture(scope="module")
def stand(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three bolts on a plate: one in the open, one beside a wall, one under a roof; and a washer."""
    ring = hardware.washer(0.008, Tolerance(1e-4))
    parts = {
        "plate": box((-0.1, -0.1, -0.02), (1.0, 0.1, -0.001)),
        "open/bolt": bolt(0.0),
        "wall/bolt": bolt(0.3),
        "[1] roof/screw": bolt(0.6),
        "walls": box((0.315, -0.1, 0.0), (0.32, 0.1, 0.1)),
        "[1] roof/box": box((0.5, -0.1, 0.006), (0.7, 0.1, 0.1)),
        "washer": (ring.vertices + np.array([0.9, 0.0, 0.0]), ring.faces),
    }
    path = tmp_path_factory.mktemp("stand") / "stand.glb"
    write_glb(path, mockup_of(parts))
    return path


@pytest.fixture(scope="module")
def bar(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A flat bar as a spanner, in millimetres."""
    path = tmp_path_factory.mktemp("bar") / "bar.stl"
    write_stl(path, feeler.Tool(*box((0.008, -0.004, 0.0), (0.05, 0.004, 0.01)), name="bar"))
    return path


def test_what_people_read(stand: Path, bar: Path) -> None:
    text = run("access", stand, "--tool", bar, "--swing", "300", code=1).stdout
    assert "1 of 3 targets reachable" in text.replace("\n", " ")
    table, _, blockers = text.partition("\nIn the way")
    rows = [line.split() for line in table.splitlines() if line.lstrip().startswith("stand/")]
    assert [row[0] for row in rows] == ["stand/wall/bolt", "stand/[1]", "stand/open/bolt"], table
    assert "yes" in rows[2] and "360.0°" in rows[2] and "13.2" in rows[2]
    assert "no" in rows[0] and rows[0][-1] == "stand/walls"
    assert "stand/walls" in blockers and "stand/[1] roof/box" in blockers
    assert "3 of 3" not in text and "2 of 2" in run("access", stand, "--tool", bar, "--targets", "*/bolt").stdout


def test_what_machines_read(stand: Path, bar: Path) -> None:
    document = run_json("access", stand, "--tool", bar, "--threads", "1", code=1)
    assert document["reachable"] == 2 and document["targets"] == 3 and document["partial"] is False
    assert all(row["looked_m"] == 0.1 and 0.0 <= row["drawn_m"] <= 0.1 for row in document["rows"])
    assert document["swing_deg"] == 60.0 and document["angles"] == 72 and document["approach_m"] == 0.1
    assert [row["path"] for row in document["rows"]] == ["stand/open/bolt", "stand/wall/bolt", "stand/[1] roof/screw"]
    first, second, third = document["rows"]
    assert first["reachable"] and first["swing_deg"] == 360.0 and first["kind"] == "bolt"
    assert np.allclose([first["across_flats_m"], first["width_m"]], 0.0132, rtol=1e-4) and first["blockers"] == []
    assert first["drive"] == "hexagon"
    assert np.array(first["way"]).shape == (2, 4, 4) and "hexagon" in first["fastener_because"]
    assert 60 < second["swing_deg"] < 360 and second["blockers"][0]["path"] == "stand/walls"
    assert third["swing_deg"] == 0.0 and third["angle_deg"] is None and third["way"] == []
    assert third["kind"] == "bolt", "a hexagon is a bolt, whatever its name says"
    assert document["blockers"][0]["path"] == "stand/[1] roof/box"


def test_options_are_passed_on(stand: Path, bar: Path, tmp_path: Path) -> None:
    words = ["access", stand, "--tool", bar]
    assert run_json(*words, "--kind", "bolt", "--targets", "*open*")["targets"] == 1
    assert run_json(*words, "--without", "*roof/box")["reachable"] == 3
    assert run_json(*words, "--only", "*/bolt")["targets"] == 2
    below = run_json(*words, "--targets", "stand/open", "--targets", "stand/wall")
    assert [row["path"] for row in below["rows"]] == ["stand/open/bolt", "stand/wall/bolt"]
    assert run_json(*words, "--targets", "*/bolt", "--swing", "359", code=1)["reachable"] == 1
    assert run_json(*words, "--targets", "*open*", "--lift", "-0.01", code=1)["reachable"] == 0
    turned = run_json(*words, "--targets", "*open*", "--grip", "-z", "--lift", "0.01")["rows"][0]
    assert np.allclose(np.array(turned["world_from_tool"])[:3, 2], [0, 0, -1])
    np.save(tmp_path / "grip.npy", at(z=0.01))  # 10 mm below the tool's origin, in its plate then
    assert run_json(*words, "--targets", "*open*", "--grip", tmp_path / "grip.npy", code=1)["reachable"] == 0
    np.save(tmp_path / "frames.npy", np.stack([at(z=0.00544), at(x=0.3, z=0.00544)]))
    document = run_json(*words, "--frames", tmp_path / "frames.npy")
    assert [row["path"] for row in document["rows"]] == ["stand/open/bolt", "stand/wall/bolt"]
    assert "kind" not in document["rows"][0]
    hand = tmp_path / "hand.stl"
    write_stl(hand, feeler.Tool(*box((0.05, -0.02, -0.02), (0.08, 0.02, 0.03)), name="hand"))
    assert run_json(*words, "--targets", "*open*", "--hand", hand, code=1)["blockers"][0]["path"] == "stand/plate"


def test_everything_is_written(stand: Path, bar: Path, tmp_path: Path) -> None:
    words = ["access", stand, "--tool", bar, "--csv", tmp_path / "a.csv", "--glb", tmp_path / "a.glb"]
    assert f"csv written to {tmp_path / 'a.csv'}" in run(*words, code=1).stdout
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8-sig") as file:
        lines = list(csv.DictReader(file))
    assert [line["reachable"] for line in lines] == ["yes", "yes", "no"]
    assert lines[2]["angle_deg"] == "" and lines[2]["blockers"] == "stand/[1] roof/box"
    picture = feeler.load_mockup(tmp_path / "a.glb")
    assert picture.part_count == 7 + 3
    paths = [path for path in picture.part_paths if "bar at targets" in path]
    assert [path.split("/")[-1] for path in paths] == ["0 reachable", "1 reachable", "2 not reachable"]
    # The colours of what is there: grey, the fasteners' blue, red in the way, green and orange tools.
    header = (tmp_path / "a.glb").read_bytes()
    size = int.from_bytes(header[12:16], "little")
    materials = json.loads(header[20 : 20 + size])["materials"]
    assert len(materials) == 5


def test_bad_input(stand: Path, bar: Path, tmp_path: Path) -> None:
    words = ["access", stand, "--tool", bar]
    assert "--targets: no part matches '*blot*'" in error_of(*words, "--targets", "*blot*")
    assert "of the 1 that --targets names looks like a fastener" in error_of(*words, "--targets", "*plate")
    assert "looks like a nut: feeler found 3 bolts" in error_of(*words, "--kind", "nut")
    assert "kind is 'rivet'" in error_of(*words, "--kind", "rivet")
    assert "--frames are the targets" in error_of(*words, "--frames", bar, "--kind", "nut")
    assert "pose file" in error_of(*words, "--frames", tmp_path / "no.npy")
    assert "--grip is 'up'" in error_of(*words, "--grip", "up")
    np.save(tmp_path / "two.npy", np.stack([np.eye(4)] * 2))
    assert "one matrix is needed, not 2" in error_of(*words, "--grip", tmp_path / "two.npy")
    assert "--swing is '0': give an angle above 0" in error_of(*words, "--swing", "0")
    assert "--angles is '2'" in error_of(*words, "--angles", "2")
    assert "--approach is '-1'" in error_of(*words, "--approach", "-1")
    assert "--threads is '0'" in error_of(*words, "--threads", "0")
    assert "--csv" in error_of(*words, "--csv", tmp_path / "a.txt")
    assert "there is no such file" in error_of(*words, "--hand", tmp_path / "no.stl")
    assert "looks like a fastener" in error_of(*words, "--only", "*plate")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_tells_what_was_found(stand: Path, bar: Path) -> None:
    """The signal comes out of the progress function, so that there is such a moment."""
    code = (
        "import os, signal\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import feeler.cli.access as command\n"
        "from contextlib import contextmanager\n"
        "@contextmanager\n"
        "def bar(label):\n"
        "    def report(fraction, stage=''):\n"
        "        if label == 'reaching 3 targets':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "    yield report\n"
        "command.bar = bar\n"
        "from feeler.cli import main; main()"
    )
    words = ["access", str(stand), "--tool", str(bar), "--threads", "1"]
    for json_too in ([], ["--json"]):
        done = subprocess.run(
            [sys.executable, "-c", code, *words, *json_too], capture_output=True, text=True, check=False
        )
        assert done.returncode == 130, done.stderr
        assert "interrupted" in done.stderr and "Traceback" not in done.stderr
        if json_too:
            document = json.loads(done.stdout)
            assert document["partial"] is True and [row["target"] for row in document["rows"]] == [0]
        else:
            assert "1 of 1 target reachable" in done.stdout and "2 were not tried" in done.stdout


def test_a_catalogue_chooses(stand: Path, tmp_path: Path) -> None:
    words = ["access", stand, "--catalogue"]
    text = run(*words, "built-in", "--eye", "0,0,1", code=1).stdout
    assert (
        "2 of 3 targets reachable" in text.replace("\n", " ")
        and "socket 13 (6.3) + ratchet" in text
        and "100 %" in text
    )
    own = tmp_path / "own.toml"
    assert "catalogue written to" in run("access", "--write-catalogue", own).stdout.replace("\n", " ")
    glb, csv_ = tmp_path / "a.glb", tmp_path / "a.csv"
    more = ["--hand", "catalogue", "--clearance", "2mm", "--turns", "10", "--glb", glb, "--csv", csv_]
    document = run_json(*words, own, *more, code=1)
    rows = {row["path"]: row for row in document["rows"]}
    free, stuck = rows["stand/open/bolt"], rows["stand/[1] roof/screw"]
    assert (
        free["tool"] == "socket 13 (6.3) + ratchet (6.3)" and free["strokes"] == 10 and free["comes_from"] == [0, 0, 1]
    )
    assert not stuck["reachable"] and stuck["tried"] and stuck["strokes"] is None
    assert document["tools"]["socket 13 (6.3) + ratchet (6.3)"] >= 1 and document["tool"] is None
    lines = list(csv.DictReader(csv_.read_text(encoding="utf-8-sig").splitlines()))
    assert {line["tool"] for line in lines if line["reachable"] == "yes"} == set(document["tools"])
    names = feeler.load_mockup(glb).part_paths
    assert any("ratchet (6.3) at targets/" in name and name.endswith("/hand") for name in names)
    own.write_text("version = 1\n[[open]]\n")
    assert "[[open]] 1 in line 2: sizes_mm is None" in error_of(*words, own)
    assert "give either --tool FILE or --catalogue FILE" in error_of("access", stand)
    assert "give either" in error_of(*words, "built-in", "--tool", "sample:hand")
    assert "needs a --catalogue with a [hand]" in error_of(
        "access", stand, "--tool", "sample:hand", "--hand", "catalogue"
    )
    assert "there is no mock-up" in error_of("access", "--catalogue", "built-in")
