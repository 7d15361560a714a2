"""What a result says where nothing is found: one part, open parts, nothing near, all hidden."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from clash_scene import house, joined, mockup_of, open_box
from commands import run, run_json
from shapes import Mesh, box

import feeler
from feeler.clashes import write_html
from feeler.clashes.advice import advice
from feeler.io import write_glb

CUBE = box((0, 0, 0), (1, 1, 1))
FAR = box((2, 0, 0), (3, 1, 1))
INSIDE = box((0.25, 0.25, 0.25), (0.5, 0.5, 0.5))
HOUSING = open_box((0, 0, 0), (1, 1, 1))


def said(parts: dict[str, Mesh], **options: float) -> list[str]:
    return advice(feeler.clash(mockup_of(parts), **options))


def test_one_part_has_nothing_to_be_checked_against() -> None:
    (only,) = said({"cube": CUBE})
    assert only.startswith("1 part only: there is nothing to check against. Pass an assembly")


def test_one_part_that_is_left_of_several(tmp_path: Path) -> None:
    mockup = mockup_of({"cube": CUBE, "far": FAR})
    found = feeler.clash(mockup, scene=feeler.Scene(mockup).without("far"))
    assert [each.partition(",")[0] for each in advice(found)] == ["1 part of 2 is in the check"]


def test_an_open_part_that_holds_another_is_named() -> None:
    (nothing, rim) = said({"case/housing": HOUSING, "pump": INSIDE})
    assert nothing.startswith("no pair of parts collides, or is within 2 mm of each other. Pass a larger clearance")
    assert rim.startswith("1 part is not closed, so parts inside it are not found: housing. Export it as solid")


def test_several_open_parts_are_counted_and_three_named() -> None:
    shift = [(vertices + np.array([3.0 * i, 0, 0]), faces) for i in range(5) for vertices, faces in (HOUSING, INSIDE)]
    (*_, rim) = said({f"{'ab'[i % 2]}{i // 2}": mesh for i, mesh in enumerate(shift)})
    assert "5 parts are not closed, so parts inside them are not found: a0, a1, a2 and 2 more" in rim


def test_an_open_part_that_holds_nothing_is_no_matter() -> None:
    assert [each[:7] for each in said({"housing": HOUSING, "far": FAR})] == ["no pair"]


def test_a_closed_part_is_not_called_open() -> None:
    assert said({"cube": CUBE, "pump": INSIDE}) == []


def test_a_closed_part_that_is_in_no_finding_is_not_called_open() -> None:
    """Its box holds the other's, but the part does not: an L."""
    ell = joined(box((0, 0, 0), (4, 1, 1)), box((0, 0, 1), (1, 1, 4)))
    assert [each[:7] for each in said({"ell": ell, "free": box((2, 0.25, 2), (2.5, 0.75, 2.5))})] == ["no pair"]


def test_depths_of_open_parts_are_called_estimates() -> None:
    sheet = open_box((-1, -1, 0.5), (2, 2, 0.9))
    (line,) = said({"a/tub": sheet, "b/lid": open_box((0, 0, 0.25), (0.5, 0.5, 0.75))}, clearance=0.0)
    assert line.startswith(
        "parts that are not closed are in 1 clash: tub, lid. They have no inside, so the depth is an"
    )
    assert line.endswith("and no shared volume is measured. Export them as solid, or close the surfaces")
    (line,) = said({"tub": sheet, "cube": CUBE, "cut": box((0.5, 0.5, 0.25), (2, 2, 2))}, clearance=0.0)
    assert line.startswith("parts that are not closed are in 2 clashes: tub. They")


def test_no_clearance_asks_for_one() -> None:
    assert said({"cube": CUBE, "far": FAR}, clearance=0.0) == [
        "no pair of parts collides. Pass a clearance, such as 0.002 metres, to find pairs that are too near"
    ]


def test_rules_that_hide_everything_say_so() -> None:
    rules = {"exclude": [{"name": "all", "a": "*"}]}
    assert advice(feeler.clash(house(), rules=rules)) == [
        "the rules hide all 9 findings. Check without rules to see them"
    ]
    one = mockup_of({"a": CUBE, "b": CUBE})
    assert advice(feeler.clash(one, rules=rules)) == ["the rules hide the only finding. Check without rules to see it"]


def test_findings_need_no_advice() -> None:
    assert advice(feeler.clash(house())) == []


@pytest.fixture
def housing(tmp_path: Path) -> Path:
    write_glb(tmp_path / "open.glb", mockup_of({"<housing>": HOUSING, "pump": INSIDE}))
    return tmp_path / "open.glb"


def test_the_command_says_it(housing: Path) -> None:
    assert "1 part is not closed, so parts inside it are not found: <housing>" in run("clash", housing).stdout


def test_json_says_it(housing: Path) -> None:
    assert ["not closed" in each for each in run_json("clash", housing)["advice"]] == [False, True]


def test_the_page_says_it(tmp_path: Path) -> None:
    write_html(tmp_path / "a.html", feeler.clash(mockup_of({"<housing>": HOUSING, "pump": INSIDE})))
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "<p class=advice>1 part is not closed, so parts inside it are not found: &lt;housing&gt;." in page


def test_a_file_that_rounds_much_is_told(tmp_path: Path) -> None:
    for away, is_told in ((65_536.0, True), (1.0, False)):
        for name, low in (("a", away), ("b", away + 1.0)):
            vertices, faces = box((low, 0, 0), (low + 1.0, 1, 1))
            trimesh.Trimesh(vertices, faces).export(tmp_path / f"{name}.stl")
        found = feeler.clash(feeler.load_mockup(tmp_path, unit="m"))
        lines = [line for line in advice(found) if "are rounded" in line]
        assert len(lines) == is_told
        assert not is_told or "parts up to 15.62 mm in each other are contacts" in lines[0]
