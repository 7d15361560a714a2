"""CSV for spreadsheets: no cell is a formula, numbers read back, and every file begins with a byte order mark."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from clash_scene import mockup_of
from commands import run
from shapes import box

import feeler
from feeler.clashes import write_csv
from feeler.io import csv_table, write_glb

FORMULAS = ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =1", "\uff1d1", "-", "=cmd|' /C calc'!A0"]


def read(data: bytes) -> list[list[str]]:
    assert data.startswith(b"\xef\xbb\xbf")
    return list(csv.reader(io.StringIO(data.decode("utf-8-sig"), newline="")))


@pytest.mark.parametrize("text", FORMULAS)
def test_text_that_begins_a_formula_is_text(text: str) -> None:
    assert read(csv_table(["name"], [[text]])) == [["name"], ["'" + text]]


@pytest.mark.parametrize("text", ["a", "a=1", "", "Gehäuse", 'he said "x", twice', "two\nlines", "1e5", " a ", "'a"])
def test_other_text_reads_back_as_it_is(text: str) -> None:
    assert read(csv_table(["name", "also"], [[text, text]]))[1:] == [[text, text]]


@pytest.mark.parametrize("value", [-1.5, 0.1, 1e-300, -3, np.float64(-0.1), np.int64(-7)])
def test_numbers_read_back_the_same(value: float) -> None:
    ((text,),) = read(csv_table(["depth"], [[value]]))[1:]
    assert float(text) == value


@pytest.mark.parametrize("value", [None, float("nan"), float("inf")])
def test_what_is_not_known_is_an_empty_field(value: float | None) -> None:
    assert csv_table(["depth", "gap"], [[value, 1]]).endswith(b"\n,1\n")


def test_a_semicolon_begins_no_cell() -> None:
    """It separates fields where the comma is the decimal mark."""
    assert csv_table(["name"], [["a;=1+1"]]).endswith(b'\n"a;=1+1"\n')


def test_the_heading_is_text_too() -> None:
    assert read(csv_table(["=a"], [])) == [["'=a"]]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An assembly and its parts with names that a spreadsheet would compute."""
    path = tmp_path_factory.mktemp("formulas") / "=A1+B2.glb"
    write_glb(path, mockup_of({"=1+1": box((0, 0, 0), (1, 1, 1)), "@b": box((0.5, 0, 0), (2, 1, 1))}))
    return path


def cells_of(path: Path) -> list[str]:
    return [cell for row in read(path.read_bytes()) for cell in row]


def are_harmless(cells: list[str]) -> bool:
    def is_number(text: str) -> bool:
        try:
            float(text)
        except ValueError:
            return False
        return True

    return all(is_number(cell) or cell[:1] not in ("=", "+", "-", "@", "\t", "\r") for cell in cells)


def test_clashes(tmp_path: Path) -> None:
    found = feeler.clash(mockup_of({"=1+1": box((0, 0, 0), (1, 1, 1)), "@b": box((0.5, 0, 0), (2, 1, 1))}))
    found.set_status(found.ids[0], "reviewed", by="+ada", note="=note")
    write_csv(tmp_path / "a.csv", found)
    cells = cells_of(tmp_path / "a.csv")
    assert {"'=1+1", "'@b", "'+ada", "'=note"} <= set(cells) and are_harmless(cells)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["clash"], 0),
        (["clearance", "--tool", "{tool}", "--at", "0 0 1.5", "--within", "1"], 0),
        (["path", "--tool", "{tool}", "--poses", "{poses}"], 1),
        (["remove", "--part", "*b", "--seconds", "1"], 0),
        (["access", "--tool", "{tool}", "--grip", "z", "--frames", "{poses}"], 0),
    ],
    ids=["clash", "clearance", "path", "remove", "access"],
)
def test_every_command(tmp_path: Path, file: Path, words: list[str], code: int) -> None:
    write_glb(tmp_path / "tool.glb", mockup_of({"=tool": box((0, 0, 0), (0.1, 0.1, 0.1))}))
    poses = [np.eye(4).tolist() for _ in range(2)]
    poses[0][2][3] = 3.0
    (tmp_path / "poses.json").write_text(json.dumps(poses))
    given = {"{tool}": str(tmp_path / "tool.glb"), "{poses}": str(tmp_path / "poses.json")}
    command, *rest = [given.get(word, word) for word in words]
    run(command, file, *rest, "--csv", tmp_path / "a.csv", code=code)
    cells = cells_of(tmp_path / "a.csv")
    assert any("=A1+B2" in cell for cell in cells) and are_harmless(cells)
