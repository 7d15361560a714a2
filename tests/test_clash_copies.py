"""Copies of one surface that a file rounded: duplicates, however they are cut; thin parts near each other are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from clash.judge.shapes import cut_finer, random_turn
from shapes import Mesh, box, inverted, joined, mockup_of

import feeler
from feeler.source import Source

UNIT = box((0, 0, 0), (1, 0.8, 0.6))
SHAPES: dict[str, Mesh] = {
    "box": UNIT,
    "hollow": joined(UNIT, inverted(box((0.2, 0.2, 0.2), (0.7, 0.5, 0.4)))),
    "two solids": joined(UNIT, box((1.5, 0, 0), (2, 1, 1))),
    "open": (UNIT[0], UNIT[1][2:]),
    "sheet": (UNIT[0], UNIT[1][:2]),
}


def placed(mesh: Mesh, seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    return mesh[0] @ random_turn(rng).T + 3 * rng.normal(size=3), mesh[1]


def loaded(folder: Path, ending: str, parts: dict[str, Mesh]) -> feeler.Mockup:
    """The parts from a file each."""
    files = []
    for name, mesh in parts.items():
        files.append(folder / f"{name}.{ending}")
        trimesh.Trimesh(*mesh, process=False).export(files[-1])
    return feeler.load_mockup(files, unit=None if ending == "glb" else "m")


def rounded(parts: dict[str, Mesh], rounding: float) -> feeler.Mockup:
    """A mock-up whose numbers are told to be rounded by so much, metres."""
    plain = mockup_of(parts)
    return feeler.Mockup(
        plain.vertices, plain.faces, plain.part_of_face, plain.part_names, source=Source(rounding=rounding)
    )


@pytest.mark.parametrize("ending", ["glb", "stl", "ply", "obj"])
@pytest.mark.parametrize("name", SHAPES)
def test_copies_in_files_are_duplicates_however_they_are_cut(tmp_path: Path, name: str, ending: str) -> None:
    for seed in range(3):
        one = placed(SHAPES[name], seed)
        mockup = loaded(tmp_path, ending, {"a": one, "b": cut_finer(one, 2)})
        for clearance in (0.0, 0.002):
            (row,) = feeler.clash(mockup, clearance=clearance)
            assert (row.verdict, row.depth) == ("duplicate", 0.0), seed
            assert 0 < row.depth_error <= 4 * mockup.source.rounding


def test_only_the_rounding_of_the_file_makes_duplicates(tmp_path: Path) -> None:
    shifts = {"a": 0.0, "b": 2e-5, "c": 4e-5}
    parts = {name: placed((UNIT[0] + [shift, 0, 0], UNIT[1]), 1) for name, shift in shifts.items()}
    sheets = {f"{name} sheet": (vertices, faces[:2]) for name, (vertices, faces) in parts.items()}
    for mockup in (loaded(tmp_path, "glb", parts), mockup_of(parts), mockup_of(sheets)):
        found = feeler.clash(mockup, clearance=0.0, contact=1e-3)
        allowed = feeler.clash(mockup, clearance=0.0).with_rules({"rule": [{"name": "fit", "a": "*", "contact": 1e-3}]})
        assert len(found) == 3 and "duplicate" not in {*found.verdicts, *allowed.verdicts}
    # Arrays have no rounding but that of double precision.
    parts = {name: placed((UNIT[0] + [1e-10 * (name == "b"), 0, 0], UNIT[1]), 1) for name in "ab"}
    assert "duplicate" not in feeler.clash(mockup_of(parts), contact=1e-3).verdicts
    assert feeler.clash(rounded(parts, 1e-10)).verdicts.tolist() == ["duplicate"]


def test_copies_of_a_sheet_may_have_a_gap() -> None:
    parts = {name: placed((UNIT[0] + [1e-10 * (name == "b"), 0, 0], UNIT[1][:2]), 1) for name in "ab"}
    parts["b"] = cut_finer(parts["b"], 2)
    for clearance in (0.0, 0.002):
        (row,) = feeler.clash(rounded(parts, 1e-10), clearance=clearance)
        assert row.verdict == "duplicate" and row.gap == pytest.approx(1e-10, rel=1e-3) and row.depth == 0
        assert feeler.clash(mockup_of(parts), clearance=0.002).verdicts.tolist() == ["clearance"]


def test_thin_parts_near_each_other_are_no_duplicates(tmp_path: Path) -> None:
    def foil(low: float, thick: float, size: float) -> Mesh:
        return box((0, 0, low), (size, size, low + thick))

    pairs = {
        # At 10 m single precision is off by half a micrometre.
        "foils on each other": (10.0, {"a": foil(0, 1e-6, 10), "b": foil(1e-6, 1e-6, 10)}),
        "a foil and its base": (10.0, {"a": foil(0, 1e-6, 10), "b": foil(1e-6, 1.0, 10)}),
        "a foil and a sheet": (10.0, {"a": foil(0, 1e-6, 10), "b": (UNIT[0] * [10, 12.5, 0], UNIT[1][8:10])}),
        "plates that are apart": (0.01, {"a": foil(0, 1e-3, 0.01), "b": foil(1.1e-6, 1e-3, 0.01)}),
        "plates 0.1 um apart": (0.01, {"a": foil(0, 1e-3, 0.01), "b": foil(1e-7, 1e-3, 0.01)}),
    }
    for name, (size, parts) in pairs.items():
        mockup = loaded(tmp_path, "glb", parts)
        assert 0 < mockup.source.rounding < 1e-7 * size, name
        for cut in (0, 2):
            finer = {"a": parts["a"], "b": cut_finer(parts["b"], cut)}
            assert "duplicate" not in feeler.clash(loaded(tmp_path, "glb", finer)).verdicts, name
    # One far part makes the rounding as large as washers are thick.
    washers = {"a": foil(0, 1e-3, 0.02), "b": foil(1e-3, 1e-3, 0.02)}
    assert "duplicate" not in feeler.clash(rounded(washers, 1e-3)).verdicts


def test_rules_and_saved_findings_keep_duplicates(tmp_path: Path) -> None:
    one = placed(UNIT, 4)
    mockup = loaded(tmp_path, "stl", {"a": one, "b": cut_finer(one, 1)})
    rules = {"rule": [{"name": "fit", "a": "*", "contact": 1e-3}]}
    found = feeler.clash(mockup)
    found.save(tmp_path / "last.json")
    kept = feeler.load_clashes(tmp_path / "last.json")
    for each in (feeler.clash(mockup, rules=rules), found.with_rules(rules), kept.with_rules(rules)):
        (row,) = each
        assert (row.verdict, row.depth, row.depth_error) == ("duplicate", 0.0, found[0].depth_error)


@pytest.mark.parametrize("ending", ["glb", "stl"])
def test_what_is_flush_from_inside_in_a_file_is_contained(tmp_path: Path, ending: str) -> None:
    for name, inner in {
        "a face": box((0.2, 0.2, 0), (0.8, 0.6, 0.5)),
        "three faces": box((0, 0, 0), (0.5, 0.5, 0.5)),
        "both ends": box((0.2, 0.2, 0), (0.4, 0.4, 0.6)),
    }.items():
        for seed in range(4):
            (tmp_path / f"{name} {seed}").mkdir()
            parts = {"outer": placed(UNIT, seed), "inner": placed(inner, seed)}
            (row,) = feeler.clash(loaded(tmp_path / f"{name} {seed}", ending, parts))
            assert row.verdict == feeler.Verdict.CONTAINED, (name, seed)
