"""The hard pairs of testdata/clash: each at the origin and far off, however finely its boxes are cut."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from clash.cases import CUTS, FAR_M, Case, cases, rational
from point_depths import boxes_depth

import feeler
from feeler import Verdict

ROOT = Path(__file__).resolve().parent.parent
CASES = cases(ROOT / "testdata")
MIXED = [(1, 4), (16, 1), (2, 16)]
"""Both parts cut differently; the same corners are no duplicate then."""

# How much longer than the least way out a translation may be: where one part goes right through the other, the axis
# that is tried depends on how both are cut (docs/contacts.md).
LONGEST_WAY = 2.0
# By how much of itself a way out of a solid goes beyond its surface, so that it is out.
BEYOND = 1e-5
OVERLAPS = ("clash", "contained", "duplicate")


def tolerance(offset: float) -> float:
    """What rounding may make of a length: a few units in the last place of the coordinates."""
    return 16 * 2.0**-53 * (offset + 4.0)


def depth_of_boxes(mockup: feeler.Mockup) -> float:
    """The depth by points, without rounding."""
    parts = (mockup.vertices[mockup.faces[mockup.part_of_face == part]].reshape(-1, 3) for part in (0, 1))
    ends = ([corners.min(axis=0).tolist(), corners.max(axis=0).tolist()] for corners in parts)
    return float(boxes_depth(*([[Fraction(x) for x in corner] for corner in both] for both in ends)))


def figure_of(case: Case, mockup: feeler.Mockup) -> float | None:
    """The depth, of a clearance the gap."""
    if not case.is_boxes:
        return case.figure
    if case.verdict == "duplicate":
        return 0.0
    return depth_of_boxes(mockup) if case.verdict in OVERLAPS else rational(mockup)[1]


def runs(case: Case) -> list[tuple[int, int]]:
    if not any(part.startswith("box ") for part in case.parts):
        return [(1, 1)]
    return [(cut, cut) for cut in CUTS] + ([] if case.verdict == "duplicate" else MIXED)


def test_the_file_has_what_is_hard() -> None:
    assert len({case.name for case in CASES}) == len(CASES) > 25
    assert {case.verdict for case in CASES} == {"none", "clash", "contact", "clearance", "contained", "duplicate"}
    mockup = CASES[0].mockup(cuts=(16, 1))
    assert mockup.part_triangles.tolist() == [3072, 12]
    for case in CASES:
        assert not case.mockup(FAR_M).report.defects["zero_area"].count


@pytest.mark.parametrize("case", [case for case in CASES if case.is_boxes], ids=lambda case: case.name)
def test_what_the_file_says_of_boxes_follows_from_their_corners(case: Case) -> None:
    for offset in (0.0, FAR_M):
        for cuts in runs(case):
            mockup = case.mockup(offset, cuts)
            assert rational(mockup)[0] == case.verdict
            if case.figure is not None:
                figure = figure_of(case, mockup)
                assert figure == pytest.approx(case.figure, abs=2.0**-40 if offset else 1e-15)


@pytest.mark.parametrize("offset", [0.0, FAR_M])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_verdict_and_depth(case: Case, offset: float) -> None:
    for cuts in runs(case):
        mockup = case.mockup(offset, cuts)
        found = feeler.clash(mockup)
        if case.verdict == "none":
            assert len(found) == 0, cuts
            continue
        (row,) = found
        assert row.verdict.name.lower() == case.verdict, cuts
        assert [row.is_open_a, row.is_open_b] == [part.startswith("sheet") for part in case.parts]
        expected = figure_of(case, mockup)
        allowed = tolerance(offset)
        if case.verdict in ("contact", "clearance"):
            assert row.depth == 0.0 and row.translation == (0.0, 0.0, 0.0)
            assert (row.gap == 0.0) == (case.verdict == "contact")
            if expected is not None:
                assert row.gap == pytest.approx(expected, abs=allowed), cuts
            continue
        assert (row.depth > 0.0) == (row.verdict != Verdict.DUPLICATE), cuts
        assert (row.gap > 0.0) == (row.verdict == Verdict.CONTAINED and not row.triangles), cuts
        assert row.depth_kind == ("estimate" if row.is_open_a or row.is_open_b else "measured")
        assert 0.0 <= row.depth_error <= max(1e-9, 1e-3 * row.depth), cuts
        if expected is not None:
            assert row.depth <= expected + allowed and expected <= row.depth + row.depth_error + allowed, cuts


def way_out_of_boxes(mockup: feeler.Mockup) -> float:
    """The least translation of one box out of the other, by their sides."""
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    (low, high), (other_low, other_high) = bounds
    return float(min((high - other_low).min(), (other_high - low).min()))


@pytest.mark.parametrize("offset", [0.0, FAR_M])
@pytest.mark.parametrize(
    "case", [case for case in CASES if case.is_boxes and case.verdict in OVERLAPS], ids=lambda case: case.name
)
def test_the_way_out_is_an_upper_bound(case: Case, offset: float) -> None:
    for cuts in runs(case):
        mockup = case.mockup(offset, cuts)
        (row,) = feeler.clash(mockup)
        least, length = way_out_of_boxes(mockup), float(np.linalg.norm(row.translation))
        assert least <= length <= LONGEST_WAY * least + tolerance(offset), cuts


@pytest.mark.parametrize("name", ["overlap of a micrometre", "walls in line", "one and a half metres of two"])
def test_the_way_out_of_plain_overlaps_is_the_shortest(name: str) -> None:
    (case,) = (case for case in CASES if case.name == name)
    for offset in (0.0, FAR_M):
        for cuts in runs(case):
            mockup = case.mockup(offset, cuts)
            (row,) = feeler.clash(mockup)
            least = way_out_of_boxes(mockup)
            excess = np.linalg.norm(row.translation) - least
            assert 0.0 <= excess <= BEYOND * least + 1e-13 * (offset + 4.0), cuts


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_which_part_is_first_does_not_matter(case: Case) -> None:
    turned = Case(case.name, (case.parts[1], case.parts[0]), case.verdict, case.figure)
    for mockup in (turned.mockup(0.0), turned.mockup(FAR_M)):
        found = feeler.clash(mockup)
        assert [row.verdict.name.lower() for row in found] == [case.verdict] * (case.verdict != "none")
