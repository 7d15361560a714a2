"""`feeler study`: the short form of each study, that it resumes, and what its curves say."""

from __future__ import annotations

import csv
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import feeler
from feeler.cli.app import app
from feeler.study.curves import Fit, Zone, epsilon, power_law, rank_correlation

SHORT = ["--quick", "--poses", "2", "--rounds", "1", "--json"]


def run(*words: str) -> dict[str, Any]:
    """What a study prints with --json."""
    result = CliRunner().invoke(app, ["study", *words, *SHORT])
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("voxel-size", ["--mockups", "differential", "--tools", "wrench,torque"]),
        ("hashing", ["--mockups", "differential", "--tools", "wrench"]),
        ("scaling", ["--tools", "wrench"]),
        ("filters", ["--mockups", "engine", "--tools", "wrench"]),
        ("piece-size", ["--mockups", "engine", "--tools", "wrench"]),
    ],
)
def test_a_study_writes_what_it_promises_and_resumes(name: str, words: list[str], tmp_path: Path) -> None:
    first = run(name, *words, "--out", str(tmp_path))
    folder = tmp_path / name
    page = (folder / "index.html").read_text()
    assert page.startswith("<!doctype html>") and "<table>" in page and 'src="http' not in page
    assert ("Upright lines" in page) == (name == "voxel-size")
    for kind in ("png", "svg"):
        assert (folder / f"{name}.{kind}").stat().st_size > 1000
    with open(folder / "samples.csv", newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    assert rows and all(float(row["seconds"]) > 0 for row in rows)
    written = json.loads((folder / "results.json").read_text())
    assert written["rows"] and "samples_s" not in json.dumps(written)
    again = run(name, *words, "--out", str(tmp_path))
    assert again["rows"] == first["rows"]  # times do not repeat by themselves: these were kept
    assert run(name, *words, "--out", str(tmp_path), "--seed", "1")["rows"] != first["rows"]


def test_voxel_size_judges_every_estimator(tmp_path: Path) -> None:
    found = run("voxel-size", "--mockups", "engine", "--tools", "wrench", "--out", str(tmp_path))
    (row,) = found["rows"]
    assert set(row["estimators"]) == {"area", "diagonal", "side", "calibrated"}
    sizes = [point["size_m"] for point in row["points"]]
    assert sizes == sorted(sizes) and len(sizes) == 7
    for estimator in row["estimators"].values():
        assert estimator["epsilon"]["absolute"] >= 0 and estimator["seconds"] > 0
    assert row["zones"]["relative"]["least_m"] <= row["fit"]["optimum_m"] <= row["zones"]["relative"]["most_m"]
    assert found["summary"]["pairs"] == 1
    assert -1 <= row["rank_correlation"] <= 1 and -1 <= row["rank_of_counted"] <= 1


def test_piece_size_judges_the_choice(tmp_path: Path) -> None:
    found = run("piece-size", "--mockups", "engine", "--tools", "wrench", "--out", str(tmp_path))
    (row,) = found["rows"]
    assert row["chosen"]["size_m"] < row["default"]["size_m"]  # the engine has large panels
    assert 0 < row["chosen"]["predicted_work"] < row["default"]["predicted_work"]
    assert 0 < row["choosing_share"] < 1 and -1 <= row["rank_correlation"] <= 1
    assert found["summary"]["over"]["chosen"]["best"]["worst"] == row["over"]["chosen"]["best"]


def test_what_is_compared_takes_turns() -> None:
    from feeler.study.timing import least_in_turns

    naps = iter([0.03, 0.01, 0.02])
    order: list[str] = []

    def nap() -> None:
        order.append("nap")
        time.sleep(next(naps))

    slow, fast = least_in_turns(nap, lambda: order.append("none"), rounds=3)
    assert 0.01 <= slow < 0.03 and fast < 0.01
    assert order == ["nap", "none"] * 3


def test_own_files(tmp_path: Path) -> None:
    from feeler.picture import write_collision_glb

    tool, mockup = feeler.sample_tool("torque"), feeler.sample("carcass", 10_000)
    hit = feeler.Scene(mockup).collide(tool, np.eye(4))
    write_collision_glb(tmp_path / "mine.glb", mockup, tool, np.eye(4), hit)
    found = run("filters", "--mockups", str(tmp_path / "mine.glb"), "--tools", "torque", "--out", str(tmp_path / "o"))
    assert found["rows"][0]["mockup"] == "mine"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--mockups", "nothing.stl"], "nothing.stl does not exist"),
        (["--mockups", " , "], "--mockups is empty"),
        (["--tools", "hammer"], "hammer does not exist"),
        (["--poses", "0"], "--poses is '0'"),
        (["--rounds", "-1"], "--rounds is '-1'"),
        (["--sizes", "2"], "--sizes is '2'"),
        (["--seed", "-1"], "--seed is '-1'"),
        (["--memory", "nan"], "--memory is 'nan'"),
        (["--storage", "blocks"], "--storage is 'blocks': choose dense, hashed"),
    ],
)
def test_bad_input_is_said_in_a_line(words: list[str], message: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["study", "voxel-size", "--quick", "--out", str(tmp_path), *words])
    assert result.exit_code == 2 and message in result.output


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = CliRunner().invoke(app, ["study", "filters", "--quick", "--out", str(tmp_path / "file")])
    assert result.exit_code == 2 and "choose another --out" in result.output


def test_curves() -> None:
    sizes = np.geomspace(0.004, 0.05, 13)
    seconds = 1e-4 * (0.25 + np.log(sizes / 0.012) ** 2)
    fit = Fit.of(sizes.tolist(), seconds.tolist())
    assert fit.optimum() == pytest.approx(0.012, rel=0.05)
    best = fit.seconds(fit.optimum())
    narrow, wide = fit.zone(1.1 * best), fit.zone(best + 1e-3)
    assert wide.least <= narrow.least < 0.012 < narrow.most <= wide.most and wide.is_cut and not narrow.is_cut
    zone = Zone(0.008, 0.02, False)
    assert epsilon(0.008, 0.012, zone) == pytest.approx(1.0)
    assert epsilon(0.016, 0.012, zone) == pytest.approx(0.5)
    assert epsilon(0.012, 0.012, zone) == 0.0
    assert rank_correlation([1, 2, 3], [10, 20, 40]) == pytest.approx(1.0)
    assert rank_correlation([1, 2, 3], [3, 2, 1]) == pytest.approx(-1.0)
    assert rank_correlation([1, 1, 1], [3, 2, 1]) == 0.0
    exponent, factor = power_law([1e2, 1e3, 1e4], [3e-5, 3e-4, 3e-3])
    assert exponent == pytest.approx(1.0) and factor == pytest.approx(3e-7)
