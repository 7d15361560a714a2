"""The hard pairs of testdata/clash: each at the origin and far off, however finely its boxes are cut."""

from __future__ import annotations

from pathlib import Path

import pytest
from clash.cases import CUTS, FAR_M, Case, cases, rational

import feeler
from feeler import Verdict

ROOT = Path(__file__).resolve().parent.parent
CASES = cases(ROOT / "testdata")
MIXED = [(1, 4), (16, 1), (2, 16)]
"""Both parts cut differently; the same corners are no duplicate then."""

# What a bound may be of the least way out: where one goes right through the other, which axis is tried follows from how
# both are cut (docs/contacts.md).
BOUND = 2.0
# By how much of itself a way out of a solid goes beyond its surface, so that it is out.
BEYOND = 2e-6


def tolerance(offset: float) -> float:
    """What rounding may make of a length: a few units in the last place of the coordinates."""
    return 16 * 2.0**-53 * (offset + 4.0)


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
            verdict, figure = rational(case.mockup(offset, cuts))
            assert verdict == case.verdict
            if case.figure is not None:
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
        expected = rational(mockup)[1] if case.is_boxes else case.figure
        allowed = tolerance(offset)
        if case.verdict in ("contact", "clearance"):
            assert row.depth == 0.0 and row.translation == (0.0, 0.0, 0.0)
            assert (row.gap == 0.0) == (case.verdict == "contact")
            if expected is not None:
                assert row.gap == pytest.approx(expected, abs=allowed), cuts
        else:
            assert row.depth > 0.0 and (row.gap > 0.0) == (row.verdict == Verdict.CONTAINED and not row.triangles), cuts
            if row.verdict == Verdict.CONTAINED and expected is not None:
                allowed += BEYOND * expected
            if expected is not None and row.depth_kind == "exact":
                assert row.depth == pytest.approx(expected, abs=allowed), cuts
            elif expected is not None:
                assert expected - allowed <= row.depth <= BOUND * expected, (cuts, row.depth_kind)


@pytest.mark.parametrize("name", ["overlap of a micrometre", "walls in line", "one and a half metres of two"])
def test_plain_overlaps_are_exact(name: str) -> None:
    """Of two convex bodies that are not pierced nobody has to be content with a bound, but where it is as short."""
    (case,) = (case for case in CASES if case.name == name)
    for offset in (0.0, FAR_M):
        for cuts in runs(case):
            (row,) = feeler.clash(case.mockup(offset, cuts))
            least = case.figure
            assert row.depth_kind == "exact" or (row.depth_kind == "bound" and row.depth <= least * (1 + 1e-12)), cuts


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_which_part_is_first_does_not_matter(case: Case) -> None:
    turned = Case(case.name, (case.parts[1], case.parts[0]), case.verdict, case.figure)
    for mockup in (turned.mockup(0.0), turned.mockup(FAR_M)):
        found = feeler.clash(mockup)
        assert [row.verdict.name.lower() for row in found] == [case.verdict] * (case.verdict != "none")
