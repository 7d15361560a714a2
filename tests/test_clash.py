"""`feeler.clash` and its table: what is found, in which order, how it is read, and what is refused."""

from __future__ import annotations

import dataclasses
import itertools
import math
import pickle
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import clash_twin
import numpy as np
import pytest
import shapes
from clash.cases import cut_box
from clash.judge.shapes import random_turn
from clash_scene import FOUND, PARTS, house, mockup_of, open_box, pairs, table
from point_depths import boxes_depth
from shapes import box, inverted, joined

import feeler
from feeler import Verdict, _core
from feeler.clashes import ClashInterrupted, finding, limits
from feeler.clashes.pictures import Pictures
from feeler.errors import MeshError, OptionError

RANK = {"clash": 0, "duplicate": 0, "contained": 0, "contact": 1, "clearance": 2}


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


def test_rules_that_allow_the_fits_leave_what_was_planted(faulty_gearbox: Any) -> None:
    """In the sample gearbox: fits may be as deep as its truth names them, and pipes keep 5 mm off the bracket."""
    truth, fault = faulty_gearbox.truth, faulty_gearbox.fault
    pipes = {"name": "pipes", "a": "*/pipe", "b": "gearbox/bracket", "clearance": 5e-3}
    fits = [
        {"name": f"{fit.kind} {i}", "a": fit.a, "b": fit.b, "contact": fit.deepest_m + 1e-6}
        for i, fit in enumerate(truth.fits)
        if fit.deepest_m > 0.0
    ]
    found = feeler.clash(faulty_gearbox.mockup, clearance=5e-4, rules={"rule": [pipes]})
    left = {frozenset((row.path_a, row.path_b)): row for row in found.with_rules({"rule": [pipes, *fits]})}
    (washer,) = fault["wrong_unit"].parts
    wrong = {pair for pair, row in left.items() if row.verdict not in (Verdict.CONTACT, Verdict.CLEARANCE)}
    around = {pair for pair in wrong if washer in pair}
    said = {"pipe_clash": "CLASH", "missing_hole": "CLASH", "mirrored": "CLASH"}
    said |= {"duplicate": "DUPLICATE", "inside": "CONTAINED"}
    assert len(around) >= 4
    assert {pair: left[pair].verdict.name for pair in wrong - around} == {
        frozenset(fault[name].parts): verdict for name, verdict in said.items()
    }

    def row_of(name: str) -> feeler.Clash:
        return left[frozenset(fault[name].parts)]

    deep = row_of("pipe_clash")
    assert fault["pipe_clash"].value - truth.chord_m <= deep.depth <= fault["pipe_clash"].value + deep.depth_error
    assert row_of("missing_hole").depth == pytest.approx(3e-3, rel=1e-3), "a bolt M6 in a plate without a hole"
    near = [row for row in left.values() if row.rule == "pipes" and row.verdict == Verdict.CLEARANCE]
    assert [frozenset((row.path_a, row.path_b)) for row in near] == [frozenset(fault["too_near"].parts)]
    assert fault["too_near"].value <= near[0].gap <= fault["too_near"].value + truth.chord_m
    assert {*faulty_gearbox.mockup.part_paths} - {p for pair in left for p in pair} == {*fault["floating"].parts}


def test_each_kind_is_found_and_told_apart(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    assert pairs(found) == FOUND
    assert all(each.a < each.b for each in found)
    for each in found:
        one, other = (
            np.array([ends.min(axis=0), ends.max(axis=0)]) for ends, _ in (PARTS[each.path_a], PARTS[each.path_b])
        )
        is_apart = each.verdict in (Verdict.CLEARANCE, Verdict.DUPLICATE)
        depth = 0.0 if is_apart else boxes_depth(one.tolist(), other.tolist())
        assert each.depth <= depth + 1e-15 and depth <= each.depth + each.depth_error + 1e-15
        assert 0.0 <= each.depth_error <= max(1e-9, 1e-3 * each.depth) and each.depth_kind == "measured"
        assert (each.depth > 0) == (each.verdict in (Verdict.CLASH, Verdict.CONTAINED))
        assert (each.gap > 0) == (each.verdict in (Verdict.CLEARANCE, Verdict.CONTAINED))
        assert (each.triangles > 0) == (each.verdict not in (Verdict.CLEARANCE, Verdict.CONTAINED))
        assert not each.is_open_a and not each.is_open_b
        assert all(low <= high for low, high in zip(*each.box, strict=True))
    walls = next(each for each in found if each.path_b == "house/walls/right")
    assert walls.depth == pytest.approx(0.0625, abs=1e-12)
    # The bottom of the bolt is 125 mm below the top of the wall, and as far from its own sides the top is in the bolt.
    (bolt, *_) = (each for each in found if "bolt" in each.path_b)
    assert bolt.depth == pytest.approx(0.125, abs=1e-12)
    assert next(each for each in found if each.path_b == "house/pins/core").depth == pytest.approx(0.5, abs=1e-12)
    near = next(each for each in found if each.verdict == Verdict.CLEARANCE)
    assert near.gap == 0.0009765625 and near.point_a[0] == 2.0 and near.point_b[0] == 2.0009765625


def test_the_way_out_is_that_of_the_first_part(mockup: feeler.Mockup) -> None:
    for each in feeler.clash(mockup).where(verdict="clash"):
        (low, high), (other_low, other_high) = (
            (corners.min(axis=0), corners.max(axis=0)) for corners, _ in (PARTS[each.path_a], PARTS[each.path_b])
        )
        least = np.minimum(other_high - low, high - other_low).min()
        length = np.linalg.norm(each.translation)
        # An upper bound, which leaves the parts apart.
        assert least < length <= least * (1 + 1e-5)
        way = np.eye(4)
        way[:3, 3] = np.array(each.translation) * 1.001
        tool = feeler.Tool.of_parts(mockup, each.a)
        rest = feeler.Scene(mockup).only(each.b)
        assert rest.is_colliding(tool, np.eye(4)) and not rest.is_colliding(tool, way, touching="free")


def test_duplicates_have_a_way_out_and_no_depth(mockup: feeler.Mockup) -> None:
    (row,) = feeler.clash(mockup).where(verdict="duplicate")
    # Some units in the last place of the coordinates, which are about 1 m.
    assert row.depth == 0.0 and row.depth_error <= 1e-14
    assert np.linalg.norm(row.translation) == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("cut", [1, 4])
def test_the_same_surface_cut_otherwise_is_a_duplicate(cut: int) -> None:
    whole, cut_up = box((0, 0, 0), (1, 1, 1)), cut_box([0, 0, 0], [1, 1, 1], cut)
    hollow = inverted(box((0.25, 0.25, 0.25), (0.75, 0.75, 0.75)))
    for more in ([], [hollow]):
        (row,) = feeler.clash(mockup_of({"whole": joined(whole, *more), "cut": joined(cut_up, *more)}))
        assert (row.verdict, row.depth) == (Verdict.DUPLICATE, 0.0) and row.depth_error <= 1e-9
    # A cavity in one of them alone is a difference.
    (row,) = feeler.clash(mockup_of({"hollow": joined(whole, hollow), "cut": cut_up}))
    assert row.verdict in (Verdict.CLASH, Verdict.CONTAINED) and row.depth == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize("width", [1e-3, 8e-5])
def test_a_slender_strip_flush_on_a_block_touches_it_at_any_turn(width: float) -> None:
    """Its triangles are 800 and 10,000 times longer than wide, so that rounding tilts their planes."""
    strip, block = box((0, 0, 0), (0.8, width, width)), box((-0.1, -0.2, width), (0.3, 0.2, 0.4))
    for seed in range(40):
        turn = random_turn(np.random.default_rng(seed))
        parts = {name: (mesh[0] @ turn.T, mesh[1]) for name, mesh in (("strip", strip), ("block", block))}
        for pair in (parts, dict(reversed(parts.items()))):
            found = feeler.clash(mockup_of(pair))
            # Rounding may leave a gap.
            assert all(row.verdict == Verdict.CONTACT for row in found), (seed, list(found))


@pytest.mark.parametrize("depth", [4e-14, 4e-13, 1e-11, 1e-8])
def test_a_tip_that_is_deeper_than_rounding_clashes_however_narrow(depth: float) -> None:
    """The narrowest is narrower where it goes in than the last place of its coordinates."""
    block, faces = box((-1, -1, -0.2), (1, 1, 0)), [[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]
    for seed, width in itertools.product(range(10), (0.5, 0.02, 0.002)):
        rng = np.random.default_rng(seed)
        at, turn = np.append(rng.uniform(-0.3, 0.3, 2), 0.0), random_turn(rng)
        tip = [[-width, -width, 0.6], [width, -width, 0.6], [width, width, 0.6], [-width, width, 0.6], [0, 0, -depth]]
        parts = {"tip": ((np.array(tip) + at) @ turn.T, np.array(faces)), "block": (block[0] @ turn.T, block[1])}
        (row,) = feeler.clash(mockup_of(parts))
        rounding = 8 * float(np.spacing(1.0))
        assert row.verdict == Verdict.CLASH, (seed, width, row)
        assert row.depth - rounding <= depth <= row.depth + row.depth_error + rounding, (seed, width, row)


@pytest.mark.parametrize("thickness", [1e-2, 1e-3, 1e-4])
def test_a_thin_plate_cut_otherwise_is_a_duplicate_at_any_turn(thickness: float) -> None:
    low, high = [0.0, 0.0, 0.0], [1.0, 0.8, thickness]
    whole, cut_up = cut_box(low, high, 1), cut_box(low, high, 4)
    for seed in range(5):
        turn = random_turn(np.random.default_rng(seed))
        parts = {name: (mesh[0] @ turn.T, mesh[1]) for name, mesh in (("whole", whole), ("cut", cut_up))}
        (row,) = feeler.clash(mockup_of(parts))
        assert row.verdict == Verdict.DUPLICATE, (seed, row)


def test_pierced_foils_clash_although_they_are_thin() -> None:
    foil, rod = box((-0.01, -0.01, 0), (0.01, 0.01, 5e-5)), box((-1e-3, -1e-3, -0.01), (1e-3, 1e-3, 0.01))
    (row,) = feeler.clash(mockup_of({"foil": foil, "rod": rod}), contact=1e-4)
    assert row.verdict == Verdict.CLASH
    other = box((-4e-5, -0.02, -0.02), (4e-5, 0.02, 0.02))
    (row,) = feeler.clash(mockup_of({"foil": foil, "other foil": other}), contact=1e-4)
    # The middle of the edge of each foil is half as deep as the other is thick.
    assert row.verdict == Verdict.CLASH and row.depth == pytest.approx(4e-5, rel=1e-3)


@pytest.mark.parametrize("sides", range(3, 10))
def test_a_needle_of_any_section_pierces_a_foil(sides: int) -> None:
    """It is as thin as the foil, and its faces are not parallel where their number is odd."""
    foil = box((-0.01, -0.01, 0), (0.01, 0.01, 5e-5))
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = 4e-5 * np.stack([np.cos(angles), np.sin(angles), np.zeros(sides)], axis=1)
    after = np.roll(np.arange(sides), -1)
    fan = [[0, i, i + 1] for i in range(1, sides - 1)]
    side = [[i, j, j + sides] for i, j in enumerate(after)] + [[i, j + sides, i + sides] for i, j in enumerate(after)]
    faces = [face[::-1] for face in fan] + [[i + sides for i in face] for face in fan] + side
    up = np.array([0, 0, 0.01])
    needle = np.concatenate([ring - up, ring + up]), np.array(faces)
    (row,) = feeler.clash(mockup_of({"foil": foil, "needle": needle}), contact=1e-4)
    assert row.verdict == Verdict.CLASH and row.depth < 1e-4
    # Sunk into the foil as far as it may be, it does not go through.
    sunk = (needle[0] + [0, 0, 0.01 + 4e-5], needle[1])
    (row,) = feeler.clash(mockup_of({"foil": foil, "needle": sunk}), contact=1e-4)
    assert row.verdict == Verdict.CONTACT


def test_thin_walls_in_line_touch_up_to_the_contact() -> None:
    # Both are 0.1 mm thick and flush with each other; they overlap by less than the contact.
    one, other = box((0, 0, 0), (0.01, 0.01, 1e-4)), box((0.01 - 8e-5, 0, 0), (0.02, 0.01, 1e-4))
    (row,) = feeler.clash(mockup_of({"one": one, "other": other}), contact=1e-4)
    assert row.verdict == Verdict.CONTACT and row.depth == pytest.approx(5e-5, rel=1e-3)


@pytest.mark.parametrize("cut", [1, 2])
@pytest.mark.parametrize("far", [0.0, 100.0, 3000.0, 65000.0])
def test_turned_boxes_far_off_are_as_deep_as_at_the_origin(far: float, cut: int, rng: np.random.Generator) -> None:
    """Most of these boxes are flush somewhere, but for the rounding of their coordinates."""
    rounding = 50 * float(np.spacing(far + 5.0))
    wrong = []
    for _ in range(100):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        rotation *= np.sign(np.linalg.det(rotation))
        low = rng.integers(0, 6, (2, 3)) / 4
        high = low + rng.integers(1, 6, (2, 3)) / 4
        if (low[0] == low[1]).all() and (high[0] == high[1]).all():
            continue
        depth = boxes_depth(*([low[i].tolist(), high[i].tolist()] for i in (0, 1)))
        shift = far * np.array([1.0, -1.0, 1.0])
        meshes = [cut_box(low[i].tolist(), high[i].tolist(), cut) for i in (0, 1)]
        turned = [(vertices @ rotation.T + shift, faces) for vertices, faces in meshes]
        found = feeler.clash(mockup_of({"a": turned[0], "b": turned[1]}), clearance=0.0)
        measured, error = (found[0].depth, found[0].depth_error) if len(found) else (0.0, 0.0)
        is_overlap = bool((np.minimum(*high) > np.maximum(*low)).all())
        is_deep = len(found) > 0 and found[0].verdict in (Verdict.CLASH, Verdict.CONTAINED)
        is_within = measured <= depth + rounding and depth <= measured + error + rounding
        if is_deep != is_overlap or not is_within or error > max(1e-9, 1e-3 * measured):
            wrong.append((low.tolist(), high.tolist(), depth, list(found)))
    assert not wrong, f"{len(wrong)} of 100, the first: {wrong[0]}"


@pytest.mark.parametrize("offset", [0.0, 3000.0, 65000.0])
def test_contact_is_at_least_the_rounding_of_the_coordinates(offset: float) -> None:
    ulp = np.spacing(offset + 3.0)
    for overlap, verdict in ((4 * ulp, Verdict.CONTACT), (40 * ulp, Verdict.CLASH)):
        one, other = box((0, 0, 0), (2, 2, 2)), box((2, 0.5, 0.5), (3, 1.5, 1.5))
        vertices = other[0] + offset
        vertices[vertices[:, 0] == 2 + offset, 0] -= overlap
        (row,) = feeler.clash(mockup_of({"one": (one[0] + offset, one[1]), "other": (vertices, other[1])}))
        assert row.verdict == verdict and row.depth <= overlap <= row.depth + row.depth_error + 4 * ulp


def test_the_worst_is_first() -> None:
    rows = [
        {"a": 0, "b": 1, "verdict": Verdict.CLEARANCE, "gap": 0.001},
        {"a": 0, "b": 2, "verdict": Verdict.CLASH, "depth": 0.01},
        {"a": 0, "b": 3, "verdict": Verdict.CONTACT},
        {"a": 1, "b": 2, "verdict": Verdict.CONTAINED, "depth": 0.5},
        {"a": 1, "b": 3, "verdict": Verdict.CLEARANCE, "gap": 0.0005},
        {"a": 2, "b": 3, "verdict": Verdict.CONTACT, "severity": 0},
        {"a": 3, "b": 1, "verdict": Verdict.CLASH, "depth": 0.01},
        {"a": 3, "b": 2, "verdict": Verdict.DUPLICATE, "depth": 9.0, "severity": 2},
    ]
    found = [(each.a, each.b) for each in table(rows)]
    assert found == [(2, 3), (1, 2), (0, 2), (3, 1), (0, 3), (1, 3), (0, 1), (3, 2)]


def test_columns_and_rows_say_the_same(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    columns = {
        "a": found.parts_a,
        "b": found.parts_b,
        "verdict": found.verdicts,
        "depth": found.depths,
        "depth_error": found.depth_errors,
        "depth_kind": found.depth_kinds,
        "gap": found.gaps,
        "triangles": found.triangles,
        "rule": found.rules,
        "severity": found.severities,
        "status": found.statuses,
        "translation": found.translations,
        "point_a": found.points_a,
        "point_b": found.points_b,
        "id": found.ids,
    }
    for place, each in enumerate(found):
        assert found[place] == each == found[place - len(found)]
        for name, column in columns.items():
            value = column[place]
            assert (tuple(value) if isinstance(value, np.ndarray) else value) == getattr(each, name), name
        assert found.boxes[place].tolist() == [list(corner) for corner in each.box]
        assert each.verdict == Verdict(int(found.columns.verdict[place])) == str(each.verdict)
    assert len(set(found.ids)) == len(found)
    with pytest.raises(ValueError, match="read-only"):
        found.depths[0] = 7.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        found[0].depth = 7.0  # type: ignore[misc]
    with pytest.raises(IndexError):
        found[len(found)]


def test_slices_are_tables_that_share_their_status(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    part = found[2:5]
    assert isinstance(part, feeler.Clashes) and len(part) == 3 and list(part) == list(found)[2:5]
    deep = found[found.depths > 0.1]
    assert len(deep) == np.count_nonzero(found.depths > 0.1)
    part.set_status(part.ids[0], "reviewed", by="ada", note="seen")
    assert found[2].status == "reviewed" and found[2].by == "ada" and found[2].note == "seen"
    assert list(found.where(status="reviewed")) == [found[2]]
    assert len(found.where(verdict="clash", status="new")) == len(found.where(verdict=Verdict.CLASH)) - 1
    assert len(found[:0]) == 0 and repr(found[:0]) == "Clashes(0: none)"
    with pytest.raises(OptionError, match="mask of shape"):
        found[np.array([True])]


def test_wrong_choices_of_rows(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    with pytest.raises(OptionError, match="verdict is 'crash': do you mean clash"):
        found.where(verdict="crash")
    with pytest.raises(OptionError, match="severity is 'bad': choose critical, major, minor"):
        found.where(severity="bad")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="depth"):
        found.where(depth="0")  # type: ignore[call-arg]
    with pytest.raises(OptionError, match="by is 'colour': do you mean cluster\\? choose part, rule, cluster"):
        found.groups("colour")
    with pytest.raises(OptionError, match="reach is for groups by"):
        found.groups("part", reach=1.0)
    with pytest.raises(OptionError, match="reach is -1"):
        found.groups("cluster", reach=-1.0)


def test_repr_counts(mockup: feeler.Mockup) -> None:
    text = repr(feeler.clash(mockup))
    assert text == "Clashes(9: 4 clash, 2 contact, 1 clearance, 1 contained, 1 duplicate)"


def test_dicts(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    rows = found.to_dicts()
    assert [row["verdict"] for row in rows] == [each.verdict.name.lower() for each in found]
    assert rows[0]["path_a"] == found[0].path_a and math.isnan(rows[0]["volume"])
    assert all(not isinstance(value, np.generic) for row in rows for value in row.values())


def test_pandas_if_it_is_there(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    found = feeler.clash(mockup)
    monkeypatch.setitem(sys.modules, "pandas", None)  # as if it were not installed
    with pytest.raises(OptionError, match="to_pandas needs pandas: pip install pandas"):
        found.to_pandas()
    monkeypatch.undo()
    pandas = pytest.importorskip("pandas")
    frame = found.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == len(found)
    assert frame.index.name == "id" and list(frame.depths) == found.depths.tolist()
    assert found[:0].to_pandas().shape[0] == 0


def test_limits(mockup: feeler.Mockup) -> None:
    meeting = {pair: verdict for pair, verdict in FOUND.items() if verdict != "clearance"}
    near = ("house/walls/right", "yard/near")
    assert pairs(feeler.clash(mockup, clearance=0.0, contact=0.001))[near] == "contact"
    assert pairs(feeler.clash(mockup, clearance=0.0)) == meeting
    assert pairs(feeler.clash(mockup, clearance=0.0009)) == meeting
    assert len(feeler.clash(mockup, clearance=3.0)) == len(PARTS) * (len(PARTS) - 1) // 2
    found = feeler.clash(mockup, contact=0.0625 + 1e-9)
    touching = found.where(verdict="contact")
    assert touching.depths.tolist() == pytest.approx([0.0625, 0.0625, 0.0, 0.0, 0.0], abs=1e-12)
    assert not touching.translations.any() and set(touching.depth_kinds) == {"measured"}
    deep = pairs(found)
    # Parts that are no deeper than the contact touch.
    assert {pair: verdict for pair, verdict in deep.items() if FOUND[pair] != verdict} == {
        ("house/walls/left", "house/walls/right"): "contact",
        ("house/walls/right", "house/copy/left"): "contact",
        ("house/walls/right", "yard/near"): "contact",
    }


def test_rows_that_are_not_there_are_named(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    with pytest.raises(IndexError, match=f"there is no row 70: there are {len(found)}, 0 to {len(found) - 1}"):
        found[70]
    with pytest.raises(TypeError, match=r"rows are chosen by a number, a slice, .*, not by 'x'"):
        found["x"]  # type: ignore[call-overload]
    wrong: Any
    for wrong in (None, 3, [3]):
        for kind in (feeler.Access, feeler.Removals):
            with pytest.raises(OptionError, match="rows "):
                kind(wrong)


def test_excluded_pairs_are_not_asked(mockup: feeler.Mockup) -> None:
    left = {pair: verdict for pair, verdict in FOUND.items() if "bolt" not in "".join(pair)}
    assert pairs(feeler.clash(mockup, ignore=[("*bolt*", "*")])) == left
    left = {pair: verdict for pair, verdict in FOUND.items() if pair != ("house/walls/left", "house/walls/right")}
    for exclude in (np.array([[1, 0]]), np.array([[0, 1], [3, 3]]), [("house/walls", "house/walls")]):
        assert pairs(feeler.clash(mockup, ignore=exclude)) == left


@pytest.mark.parametrize("rules", [None, {"exclude": [{"name": "x", "a": "row/1*", "b": "*2"}]}])
def test_patterns_that_match_many_parts_skip_by_classes(monkeypatch: pytest.MonkeyPatch, rules: Any) -> None:
    """No pair is written down: 100,000 parts have ten thousand million. The findings are those of the long way."""
    rows = {f"row/{i}": shapes.cube((0.011 * (i % 20), 0.011 * (i // 20), 0), 0.01) for i in range(300)}
    mockup = shapes.mockup_of(rows)
    ignore = [("*1*", "*2*"), ("row/*", ["*5", "*7"]), (3, 4), ("*9", "*9")]
    parts = "*3*" if rules is None else None
    short = feeler.clash(mockup, ignore=ignore, rules=rules, parts=parts)
    monkeypatch.setattr(finding, "MANY_PAIRS", 10**9)
    long = feeler.clash(mockup, ignore=ignore, rules=rules, parts=parts)
    assert 0 < len(long) < len(feeler.clash(mockup, rules=rules, parts=parts))
    assert pairs(short) == pairs(long) and short.ids == long.ids
    monkeypatch.setattr(finding, "MANY_PAIRS", 3)
    assert len(finding._limits(mockup, 0.002, 0.0, None, ignore).exclude) == 1
    monkeypatch.setattr(limits, "CLASS_LIMIT", 3)  # too many classes: pair by pair
    assert len(finding._limits(mockup, 0.002, 0.0, None, ignore).exclude) > 10_000


def test_a_scene_serves_and_says_who_is_there(mockup: feeler.Mockup) -> None:
    scene = feeler.Scene(mockup)
    found = feeler.clash(mockup, scene=scene)
    assert list(found.ids) == list(feeler.clash(mockup).ids)
    assert "index" in dict(found.facts.seconds)
    here = pairs(feeler.clash(mockup, scene=scene.without("house/copy")))
    assert here == {pair: verdict for pair, verdict in FOUND.items() if "house/copy/left" not in pair}
    assert len(feeler.clash(mockup, scene=scene.only("yard/near"))) == 0


def test_open_parts_are_told_and_hold_nothing() -> None:
    inside = box((0.25, 0.25, 0.25), (0.5, 0.5, 0.5))
    found = feeler.clash(mockup_of({"tub": open_box((0, 0, 0), (1, 1, 1)), "duck": inside}))
    assert len(found) == 0
    found = feeler.clash(mockup_of({"duck": inside, "tub": open_box((0.375, 0, 0), (1, 1, 1))}))
    (row,) = found
    assert (row.is_open_a, row.is_open_b) == (False, True) and row.verdict == Verdict.CLASH
    # Points of the tub inside the duck count: the middle of its wall is 0.125 from a side. The duck is in nothing.
    assert row.depth_kind == "estimate" and row.depth == pytest.approx(0.125, rel=1e-3)
    assert row.depth_error <= 1e-3 * row.depth


def test_two_open_parts_have_a_depth_without_an_error() -> None:
    one, other = open_box((0, 0, 0), (1, 1, 1)), open_box((0.9, 0.25, -0.5), (1.5, 0.75, 0.5))
    (row,) = feeler.clash(mockup_of({"one": one, "other": other}))
    assert row.verdict == Verdict.CLASH and row.depth_kind == "estimate"
    assert row.depth > 0.0 and math.isnan(row.depth_error)
    (row,) = feeler.clash(mockup_of({"one": one, "twice": open_box((0, 0, 0), (1, 1, 1))}))
    assert (row.verdict, row.depth) == (Verdict.DUPLICATE, 0.0)
    finer = cut_box([0, 0, 0], [1, 1, 1], 2)
    finer = finer[0], finer[1][~(finer[0][finer[1]][:, :, 2] == 1.0).all(axis=1)]
    (row,) = feeler.clash(mockup_of({"one": one, "finer": finer}))
    assert (row.verdict, row.depth) == (Verdict.DUPLICATE, 0.0)


@pytest.mark.parametrize("count", [0, 1])
def test_mockups_of_few_parts(count: int) -> None:
    mockup = mockup_of({"alone": box((0, 0, 0), (1, 1, 1))})
    scene = feeler.Scene(mockup)
    found = feeler.clash(mockup, scene=scene if count else scene.without("alone"))
    assert len(found) == 0 and found.ids == () and found.groups() == [] and list(found) == []
    assert found.rules.shape == (0,) and found.statuses.shape == (0,) and found.boxes.shape == (0, 2, 3)


def test_many_coincident_parts() -> None:
    number = 12
    mockup = mockup_of({f"copies/{i}": box((0, 0, 0), (1, 1, 1)) for i in range(number)})
    found = feeler.clash(mockup)
    assert len(found) == number * (number - 1) // 2 and set(found.verdicts.tolist()) == {Verdict.DUPLICATE}
    assert len(set(found.ids)) == len(found)
    assert sum(len(group) for group in found.groups()) == len(found) == len(found.groups("cluster")[0])


def copies(number: int) -> feeler.Mockup:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    return feeler.Mockup(
        np.tile(vertices, (number, 1)),
        np.concatenate([faces + 8 * i for i in range(number)]),
        np.repeat(np.arange(number), 12),
        [f"copy {i}" for i in range(number)],
    )


def test_a_thousand_coincident_parts() -> None:
    found = feeler.clash(copies(1000))
    assert len(found) == 1000 * 999 // 2 and set(found.verdicts.tolist()) == {Verdict.DUPLICATE}
    assert len(np.unique(np.stack([found.parts_a, found.parts_b]), axis=1).T) == len(found)
    assert set(found[:1000].rules.tolist()) == {"default"} and found[499_499].b == 999


@pytest.mark.slow
def test_a_part_of_millions_against_bolts(rng: np.random.Generator) -> None:
    vertices, faces = cut_box([0, 0, 0], [1, 1, 1], 650)
    meshes = [(vertices, faces)]
    places = rng.uniform(0.05, 0.95, (200, 2))
    for x, y in places:
        meshes.append(box((x - 0.01, y - 0.01, 0.9), (x + 0.01, y + 0.01, 1.05)))
    mockup = mockup_of({f"part {i}": mesh for i, mesh in enumerate(meshes)})
    assert mockup.part_triangles[0] > 5_000_000
    found = feeler.clash(mockup, clearance=0.0)
    against = found[found.parts_a == 0]
    assert len(against) == 200 and set(against.verdicts.tolist()) == {Verdict.CLASH}
    cube = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    bolts = [((x - 0.01, y - 0.01, 0.9), (x + 0.01, y + 0.01, 1.05)) for x, y in places.tolist()]
    depth = np.array([boxes_depth(cube, bolt) for bolt in bolts])
    measured, error = (column[np.argsort(against.parts_b)] for column in (against.depths, against.depth_errors))
    assert (measured <= depth + 1e-12).all() and (depth <= measured + error + 1e-12).all()
    assert (error <= np.maximum(1e-9, 1e-3 * measured)).all()
    assert set(against.depth_kinds.tolist()) == {"measured"}
    # A picture of one needs no picture of all.
    assert Pictures(mockup).png(against[0]).startswith(b"\x89PNG")


def test_wrong_arguments(mockup: feeler.Mockup) -> None:
    asked: Any = feeler.clash
    with pytest.raises(MeshError, match=r"needs a feeler\.Mockup, not list"):
        asked([])
    for value in (-1.0, math.nan, math.inf, "2 mm", True, None):
        with pytest.raises(OptionError, match=r"clearance is .*: give metres, 0 or more"):
            asked(mockup, clearance=value)
    for value in (-1e-9, math.nan, "chrod", None):
        with pytest.raises(OptionError, match=r'contact is .*: give metres, 0 or more, or "chord"'):
            asked(mockup, contact=value)
    with pytest.raises(OptionError, match="scene is of another mock-up"):
        asked(mockup, scene=feeler.Scene(house()))
    with pytest.raises(OptionError, match=r"ignore, of the mock-up: no part matches '\*blot\*'; do you mean 'bolt"):
        asked(mockup, ignore=[("*blot*", "*")])
    with pytest.raises(OptionError, match="the mock-up has no part 99"):
        asked(mockup, ignore=np.array([[0, 99]]))
    with pytest.raises(OptionError, match="ignore holds 'bolt'"):
        asked(mockup, ignore=["bolt"])
    with pytest.raises(OptionError, match="threads is 0"):
        asked(mockup, threads=0)


@pytest.mark.parametrize("scale", [1e-12, 1e39, 1e41, 1e60, 1e99])
def test_coordinates_are_right_or_refused(scale: float) -> None:
    parts = {"a": box((0, 0, 0), (1, 1, 1)), "x/b": box((0.875, 0.25, 0.25), (2, 0.75, 0.75))}
    mockup = mockup_of({name: (scale * vertices, faces) for name, (vertices, faces) in parts.items()})
    if scale > 1e40:
        with pytest.raises(
            MeshError, match=r"part 'a' has coordinates of 1e\+\d+ m, and a clash check takes up to 1e\+40 m"
        ):
            feeler.clash(mockup)
    else:
        (row,) = feeler.clash(mockup)
        assert row.verdict == "clash" and row.depth == pytest.approx(0.125 * scale, rel=1e-3)


def test_a_triangle_that_is_not_queried_is_not_refused() -> None:
    vertices, faces = box((0, 0, 0), (1, 1, 1))
    torn = np.append(vertices, [[1e150, 0, 0]], axis=0), np.append(faces, [[0, 1, 8]], axis=0)
    assert len(feeler.clash(mockup_of({"a": torn, "b": box((0.5, 0, 0), (2, 1, 1))}))) == 1


def test_chordal_errors_are_known_of_step_alone(mockup: feeler.Mockup, testdata: Path) -> None:
    with pytest.raises(OptionError, match=r'contact="chord".*only of STEP files.*give contact in metres'):
        feeler.clash(mockup, contact="chord")
    step = feeler.load_mockup(testdata / "meshes" / "assembly.step", chord_tolerance=2e-4)
    assert step.source.chord_tolerance == 2e-4
    assert feeler.load_mockup(testdata / "meshes" / "assembly.step").source.chord_tolerance == 1e-4
    assert feeler.load_mockup(testdata / "files" / "stl_end_loop.stl").source.chord_tolerance is None
    by_chord, by_hand = feeler.clash(step, contact="chord"), feeler.clash(step, contact=4e-4)
    assert pairs(by_chord) == pairs(by_hand)
    assert by_chord.facts.contact == "chord"


def test_contact_by_chord_is_the_sum_of_both(testdata: Path) -> None:
    overlap = 0.0003
    mockup = mockup_of({"a": box((0, 0, 0), (1, 1, 1)), "b": box((1 - overlap, 0.25, 0.25), (2, 0.75, 0.75))})
    for tolerance, verdict in ((1e-4, "clash"), (2e-4, "contact")):
        mockup.source = feeler.mockup.Source(chord_tolerance=tolerance)
        assert list(pairs(feeler.clash(mockup, contact="chord")).values()) == [verdict]
        assert list(pairs(feeler.clash(mockup)).values()) == ["clash"]


def test_volumes(mockup: feeler.Mockup) -> None:
    pytest.importorskip("manifold3d")
    found = feeler.clash(mockup, volume=True)
    volume = {(each.path_a, each.path_b): each.volume for each in found}
    assert volume["house/walls/left", "house/walls/right"] == pytest.approx(0.0625, rel=1e-9)
    assert volume["house/walls/left", "house/copy/left"] == pytest.approx(1.0, rel=1e-9)
    assert volume["house/walls/right", "house/pins/core"] == pytest.approx(1 / 64, rel=1e-9)
    assert volume["house/walls/left", "yard/flush"] == 0.0 == volume["house/walls/right", "yard/near"]
    assert np.isnan(feeler.clash(mockup).volumes).all()


def test_volumes_of_what_is_open_mirrored_or_far_off() -> None:
    pytest.importorskip("manifold3d")
    solid, tub = box((0, 0, 0), (1, 1, 1)), open_box((0.5, 0.25, 0.25), (1.5, 0.75, 0.75))
    (row,) = feeler.clash(mockup_of({"a": solid, "b": tub}), volume=True)
    assert math.isnan(row.volume)
    other = box((0.5, 0.25, 0.25), (1.5, 0.75, 0.75))
    mirrored = other[0], other[1][:, ::-1]
    (row,) = feeler.clash(mockup_of({"a": solid, "b": mirrored}), volume=True)
    assert row.volume == pytest.approx(0.125, rel=1e-9)
    # Thin, and far off: there manifold3d takes lengths of a few nanometres for none.
    thin = box((1 - 2.0**-29, 0.25, 0.25), (1.5, 0.75, 0.75))
    far = {name: (mesh[0] + 4096.0, mesh[1]) for name, mesh in {"a": solid, "b": thin}.items()}
    (row,) = feeler.clash(mockup_of(far), volume=True)
    assert row.volume == pytest.approx(2.0**-31, rel=1e-3)


def test_volumes_need_their_extra(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)  # as if it were not installed
    with pytest.raises(OptionError, match=r'volumes need manifold3d: pip install "feeler\[volume\]"'):
        feeler.clash(mockup, volume=True)


@pytest.mark.parametrize("volume", [False, True])
def test_progress_ends_with_1_and_never_goes_back(mockup: feeler.Mockup, volume: bool) -> None:
    if volume:
        pytest.importorskip("manifold3d")
    told: list[float] = []
    feeler.clash(mockup, volume=volume, progress=lambda fraction, _stage: told.append(fraction))
    assert told == sorted(told) and told[-1] == 1.0


def test_verdicts_have_numbers_and_words() -> None:
    words = ["clash", "contact", "clearance", "contained", "duplicate"]
    assert list(Verdict) == words and [each.code for each in Verdict] == list(range(5))
    assert [Verdict(np.uint8(code)) for code in range(5)] == words == Verdict.words(np.arange(5)).tolist()
    assert f"{Verdict.CLASH}" == str(Verdict.CLASH) == "clash"
    for wrong in (5, -1, True, "crash"):
        with pytest.raises(ValueError, match="is not a valid Verdict"):
            Verdict(wrong)


COLUMN_OF = {
    **{field.name: f"{field.name}s" for field in fields(feeler.Clash)},
    **{"a": "parts_a", "b": "parts_b", "path_a": "paths_a", "path_b": "paths_b", "severity": "severities"},
    **{"point_a": "points_a", "point_b": "points_b", "box": "boxes", "status": "statuses"},
    **{name: name for name in ("triangles", "is_open_a", "is_open_b", "by", "changed")},
}
"""The column of each field of a row."""


@pytest.mark.parametrize("field", list(COLUMN_OF))
def test_every_field_of_a_row_has_a_column(field: str, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup, clearance=1.0)
    found.set_status(found.ids[0], "approved", by="me", note="fits")
    column = getattr(found, COLUMN_OF[field])
    assert len(found) > 3 and len(column) == len(found)
    for value, row in zip(column, found, strict=True):
        expected = getattr(row, field)
        assert repr(np.asarray(value).tolist()) == repr(np.asarray(expected).tolist())


def test_columns_go_by_their_old_names_too(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    with pytest.warns(DeprecationWarning, match="Clashes.depth is now Clashes.depths"):
        assert found.depth is found.depths  # type: ignore[attr-defined]
    with pytest.warns(DeprecationWarning, match="verdict is now"):
        assert [Verdict(each) for each in found.verdict] == found.verdicts.tolist()  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match="no attribute 'deep'"):
        found.deep  # type: ignore[attr-defined]  # noqa: B018


def test_an_interrupted_check_leaves_what_it_found(mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    # By the plain twin: the core may be done before it hears.
    monkeypatch.setattr(_core, "clash", clash_twin.clash)

    def stop(fraction: float, stage: str) -> None:
        if fraction > 0.35:  # some way into the first stage
            raise KeyboardInterrupt

    with pytest.raises(ClashInterrupted) as caught:
        feeler.clash(mockup, progress=stop)
    found = caught.value.clashes
    assert found.is_partial and len(found) < len(FOUND) and pairs(found).items() <= FOUND.items()
    assert repr(found).endswith("partial)")
    assert isinstance(caught.value, KeyboardInterrupt)
    there = pickle.loads(pickle.dumps(caught.value))
    assert pairs(there.clashes) == pairs(found) and there.clashes.is_partial


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 1.0])
def test_ctrl_c_at_any_moment_keeps_what_there_is(mockup: feeler.Mockup, share: float) -> None:
    def stop(fraction: float, stage: str) -> None:
        if fraction >= share:
            raise KeyboardInterrupt

    scene = feeler.Scene(mockup)
    with pytest.raises(ClashInterrupted) as caught:
        feeler.clash(mockup, scene=scene, progress=stop)
    assert pairs(caught.value.clashes).keys() <= FOUND.keys()


def test_what_a_progress_function_raises_is_raised(mockup: feeler.Mockup) -> None:
    def fail(_fraction: float, _stage: str) -> None:
        raise RuntimeError("full")

    with pytest.raises(RuntimeError, match="full"):
        feeler.clash(mockup, progress=fail)


def test_threads_change_nothing(mockup: feeler.Mockup) -> None:
    one, many = (feeler.clash(mockup, threads=threads) for threads in (1, 3))
    assert list(one) == list(many)


def test_the_package_is_not_hidden_by_the_function() -> None:
    code = "import feeler, feeler.clashes as room; assert callable(feeler.clash) and room.clash is feeler.clash"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_so_many_threads_are_refused_with_a_scene_too() -> None:
    mockup = feeler.sample("gearbox", 40_000)
    with pytest.raises(OptionError, match="threads"):
        feeler.clash(mockup, scene=feeler.Scene(mockup), threads=2**63)
