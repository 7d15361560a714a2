"""Names that are not UTF-8, as old drives have: Python shows each of their bytes as half of a surrogate pair."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from commands import error_of, run
from shapes import box, mockup_of

import feeler
from feeler import Joint, Mechanism
from feeler.io import write_stl
from feeler.words import printable

NAME = os.fsdecode(b"Geh\xe4use")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / f"{NAME}.stl"
    try:
        write_stl(path, mockup_of({"a": box((0, 0, 0), (1, 1, 1))}))
    except (OSError, feeler.FeelerError):
        pytest.skip("the file system takes no such names")
    return path


def named() -> feeler.Mockup:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    return feeler.Mockup(vertices, faces, None, [NAME])


def test_the_workbench_opens_a_file_and_parts_with_such_names(file: Path) -> None:
    for mockup in (feeler.load_mockup(file), named()):
        with feeler.view(mockup, browser=False) as view:
            assert view.url.startswith("http")


def test_such_bytes_are_shown_as_bytes(file: Path) -> None:
    assert printable(NAME) == "Geh\\xe4use"
    assert printable("\udc80\udcff\ud800\udc00\udd00\x1b") == "\\x80\\xff\\ud800\\udc00\\udd00\\x1b"
    assert "Geh\\xe4use.stl" in run("info", file).stdout
    assert "Geh\\xe4use.obj" in error_of("info", file.with_suffix(".obj"))


def test_a_project_of_such_a_file_is_reported(file: Path, tmp_path: Path) -> None:
    run("clash", file, "--project", tmp_path / "p.feelproj")
    run("report", tmp_path / "p.feelproj", "--html", tmp_path / "r.html")
    assert (tmp_path / "r.html").read_bytes().decode("utf-8")


def test_a_mechanism_of_such_parts_is_saved_and_found_again(tmp_path: Path) -> None:
    (one, faces), (two, _) = box((0, 0, 0), (1, 1, 1)), box((3, 0, 0), (4, 1, 1))
    mockup = feeler.Mockup(
        np.concatenate([one, two]), np.concatenate([faces, faces + len(one)]), [0] * 12 + [1] * 12, [NAME, "b"]
    )
    Mechanism(mockup, [Joint("j", "prismatic", None, NAME, axis=(1, 0, 0))]).save(tmp_path / "m.toml")
    assert "Geh?use" in (tmp_path / "m.toml").read_text(encoding="utf-8")
    assert len(Mechanism.load(tmp_path / "m.toml", mockup).joints) == 1
