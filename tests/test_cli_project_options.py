"""How the files of a project are read: options that are not given are those of last time, in all commands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from commands import error_of, run, run_json
from test_cli_project import POSIX, document_when, is_saved
from test_cli_view import viewed
from test_workbench_openings import cube, loaded
from workbench_fake import WAIT_S, Page
from workbench_scene import PEG, stand

import feeler
from feeler.cli.projects import Work
from feeler.cli.view import _Opening
from feeler.io import write_glb, write_stl
from feeler.workbench.session.session import Session

HALF_INCH = 0.0127
ASKED = '[[requirement]]\nname = "apart"\na = "a"\nb = "b"\ngap = 0.012\n'


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """Two cubes of a file each, half a unit apart; they are drawn in inches."""
    (tmp_path / "a.stl").write_bytes(cube(1.0))
    one = feeler.load_mockup(tmp_path / "a.stl", "m")
    write_stl(tmp_path / "b.stl", feeler.Mockup(one.vertices + np.array((1.5, 0.0, 0.0)), one.faces), unit="m")
    return tmp_path / "a.stl", tmp_path / "b.stl"


def gap(*words: str | Path) -> float:
    (found,) = run_json("clash", *words, "--clearance", "20mm")["clashes"]
    return float(found["gap"])


def test_files_are_read_in_the_unit_that_the_project_keeps(files: tuple[Path, Path], tmp_path: Path) -> None:
    path = tmp_path / "y.feelproj"
    assert gap(*files, "--unit", "in", "--project", path) == pytest.approx(HALF_INCH)
    for words in ((path,), (*files, "--project", path), (path,)):
        assert gap(*words) == pytest.approx(HALF_INCH)
    (tmp_path / "asked.toml").write_text(ASKED)
    asked = ("--requirements", tmp_path / "asked.toml", "--project", path)
    assert run_json("verify", *files, *asked)["holds"]
    assert not run_json("verify", *files, *asked, "--unit", "mm", code=1)["holds"]
    page = tmp_path / "report.html"
    assert "changed" not in run("report", path, *files, "--html", page, "--pictures", "0").stdout
    run("maintain", *files, "--project", path, "--part", "a", "--seconds", "1")
    # A unit that is given is kept from then on; verify only reads.
    assert gap(path) == pytest.approx(HALF_INCH)
    assert gap(path, "--unit", "mm") == gap(path) == gap(*files, "--project", path) == pytest.approx(0.0005)


def test_the_unit_stays_when_files_have_other_places(files: tuple[Path, Path], tmp_path: Path) -> None:
    path = tmp_path / "y.feelproj"
    gap(*files, "--unit", "in", "--project", path)
    (tmp_path / "new").mkdir()
    moved = [each.rename(tmp_path / "new" / each.name) for each in files]
    assert gap(*moved, "--project", path) == gap(path) == pytest.approx(HALF_INCH)
    scene = feeler.Scene(feeler.load_mockup(moved, "in"))
    scene.save(tmp_path / "y.feeler")
    # A saved scene has its unit in it; the project keeps the one for files.
    assert gap(tmp_path / "y.feeler", "--project", path) == gap(path) == pytest.approx(HALF_INCH)
    assert gap(*moved, "--project", path) == pytest.approx(HALF_INCH)


def test_up_is_kept(tmp_path: Path) -> None:
    """glTF has y up."""
    (tmp_path / "box.glb").write_bytes(trimesh.creation.box((0.1, 0.2, 0.4)).export(file_type="glb"))
    path = tmp_path / "y.feelproj"

    def height(*words: str | Path) -> Any:
        return run_json("clash", *words)["mockup"]["extent"][2]

    assert height(tmp_path / "box.glb", "--project", path) == height(path) == pytest.approx(0.4)
    assert height(tmp_path / "box.glb", "--up", "z", "--project", path) == pytest.approx(0.2)
    assert height(tmp_path / "box.glb", "--project", path) == height(path) == pytest.approx(0.2)
    assert height(path, "--up", "y") == height(path) == pytest.approx(0.4)


@POSIX
def test_the_page_reads_files_in_the_unit_that_is_kept(files: tuple[Path, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.feelproj"
    (tmp_path / "asked.toml").write_text(ASKED)
    asked = ("--requirements", tmp_path / "asked.toml", "--project", path)
    for words in (("--unit", "in"), ()):
        with viewed(tmp_path, *files, *words, "--project", path) as (url, _), Page(url) as page:
            document = document_when(page, is_saved)
            assert document["project"]["stale"] == {}
        assert run_json("verify", *files, *asked)["holds"] and run_json("verify", path, *asked[:2])["holds"]


def test_parts_that_a_project_leaves_out(tmp_path: Path) -> None:
    whole = stand()
    write_glb(tmp_path / "old.glb", whole)
    write_glb(tmp_path / "new.glb", whole)
    path, peg = tmp_path / "x.feelproj", f"old/{whole.part_paths[PEG]}"

    def found(*words: str | Path) -> set[str]:
        rows = run_json("clash", *words, "--clearance", "0.1")["clashes"]
        return {row[side] for row in rows for side in "ab"}

    everything = found(tmp_path / "old.glb")
    assert peg in everything
    less = found(tmp_path / "old.glb", "--without", peg, "--project", path)
    assert peg not in less and found(path) == found(tmp_path / "old.glb", "--project", path) == less
    # A check of a few parts later on is one check, and not smaller ones from then on.
    assert found(path, "--only", "*/post*") < less | everything and found(path) == less
    # Another file calls the part otherwise.
    there = found(tmp_path / "new.glb", "--project", path)
    assert there == {each.replace("old/", "new/", 1) for each in less} == found(path)
    few = whole.part_of_face != PEG
    left = feeler.Mockup(
        whole.vertices, whole.faces[few], whole.part_of_face[few], whole.part_names, part_paths=whole.part_paths
    )
    write_glb(tmp_path / "left.glb", left)
    (tmp_path / "newer").mkdir()
    (tmp_path / "left.glb").rename(tmp_path / "newer" / "new.glb")
    for command in (("clash",), ("maintain", "--part", "*")):
        said = error_of(command[0], tmp_path / "newer" / "new.glb", *command[1:], "--project", path)
        assert 'names no part of this mock-up: give --without again, or --only "*" for all parts' in said
    assert found(tmp_path / "newer" / "new.glb", "--only", "*", "--project", path)
    assert found(tmp_path / "old.glb", "--project", path) == everything


def test_a_download_keeps_how_its_files_were_read(files: tuple[Path, Path], tmp_path: Path) -> None:
    path = tmp_path / "saved.feelproj"
    with Session(has_threads=False) as session:
        opening = _Opening(session, Work(["sample:differential:10000"]))
        session.openings.offer(opening.again)
        assert opening._run()
        sent = {each.name: each.read_bytes() for each in files}
        loaded(session, session.openings, sent)
        loaded(session, session.openings, {}, "in")
        written = session.job("export_project", {}).result(WAIT_S)
        path.write_bytes(session.export(written["name"]))
    (tmp_path / "asked.toml").write_text(ASKED)
    asked = ("--requirements", tmp_path / "asked.toml", "--project", path)
    assert run_json("verify", *files, *asked)["holds"]
    assert "does not say where its mock-up is" in error_of("clash", path)
    assert gap(*files, "--project", path) == gap(path) == pytest.approx(HALF_INCH)


def test_a_download_keeps_what_is_left_out(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand.glb", stand())
    path = tmp_path / "saved.feelproj"
    with Session(has_threads=False) as session:
        assert _Opening(session, Work([str(tmp_path / "stand.glb")], without=["*/peg"]))._run()
        written = session.job("export_project", {}).result(WAIT_S)
        path.write_bytes(session.export(written["name"]))
    rows = run_json("clash", tmp_path / "stand.glb", "--clearance", "0.1", "--project", path)["clashes"]
    assert rows and not any(row[side].endswith("/peg") for row in rows for side in "ab")
