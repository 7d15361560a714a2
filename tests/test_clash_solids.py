"""Verdicts of parts of several solids, of which one is in both parts, inside the other part, or beside it."""

from __future__ import annotations

import numpy as np
import pytest
from clash.judge.shapes import cut_finer, random_turn
from shapes import Mesh, box, inverted, joined, mockup_of

import feeler
from feeler import Verdict

SOLID = box((0, 0, 0), (1, 1, 1))
INNER = box((0.4, 0.4, 0.4), (0.6, 0.6, 0.6))
BESIDE = box((1, 0, 0), (2, 1, 1))
FAR_A, FAR_B = box((5, 0, 0), (6, 1, 1)), box((8, 0, 0), (9, 1, 1))
HOLLOW = joined(box((-1, -1, -1), (2, 2, 2)), inverted(SOLID))
THROUGH = (
    np.array([[0.2, 0.2, 0.5], [0.8, 0.2, 0.5], [0.8, 0.8, 1.5], [0.2, 0.8, 1.5]]),
    np.array([[0, 1, 2], [0, 2, 3]]),
)
FLAT = np.array([[0, 1, 2], [0, 2, 3]])


def sheet(height: float, low: float = 0.3, high: float = 0.7) -> Mesh:
    """A level square."""
    return np.array([[x, y, height] for x, y in ((low, low), (high, low), (high, high), (low, high))]), FLAT


LID = box((0.3, 0.3, 0.9), (0.6, 0.6, 1))
PAIRS: dict[str, tuple[Mesh, Mesh, Verdict, float]] = {
    "one solid in both": (joined(SOLID, FAR_A), joined(SOLID, FAR_B), Verdict.CONTAINED, 0),
    "one solid in both, one beside it in a face": (
        joined(SOLID, box((1, 0.2, 0.2), (2, 0.4, 0.4))),
        SOLID,
        Verdict.CONTAINED,
        0,
    ),
    "one solid in both, one on its edge": (joined(SOLID, box((1, 1, 0), (2, 2, 1))), SOLID, Verdict.CONTAINED, 0),
    "one solid in both, one on its edge, inside out": (
        inverted(joined(SOLID, box((1, 1, 0), (2, 2, 1)))),
        SOLID,
        Verdict.CONTAINED,
        0,
    ),
    "a hollow solid in both": (joined(HOLLOW, FAR_A), joined(FAR_B, HOLLOW), Verdict.CONTAINED, 0),
    "one in both, others cross": (
        joined(SOLID, FAR_A),
        joined(SOLID, box((5.5, 0.25, 0.25), (7, 0.5, 0.5))),
        Verdict.CLASH,
        0.5,
    ),
    "a plug in a hollow": (joined(HOLLOW, FAR_A), joined(SOLID, FAR_B), Verdict.CONTACT, 0),
    "solids side by side": (joined(SOLID, FAR_A), joined(BESIDE, FAR_B), Verdict.CONTACT, 0),
    "one inside, one on a face": (SOLID, joined(INNER, BESIDE), Verdict.CONTAINED, 0.4),
    "one inside, one on a corner": (SOLID, joined(INNER, box((1, 1, 1), (2, 2, 2))), Verdict.CONTAINED, 0.4),
    "one inside, one in by a micrometre": (
        SOLID,
        joined(INNER, box((1 - 1e-6, 0, 0), (2, 1, 1))),
        Verdict.CLASH,
        0.4,
    ),
    "one inside, a sheet through a face": (SOLID, joined(INNER, THROUGH), Verdict.CLASH, 0.4),
    "a sheet on a face, a solid apart": (SOLID, joined(sheet(1), FAR_A), Verdict.CONTACT, 0),
    "a sheet inside, a solid apart": (SOLID, joined(sheet(0.9), FAR_A), Verdict.CONTAINED, 0.1),
    "a sheet inside, a solid on a face": (SOLID, joined(sheet(0.9), BESIDE), Verdict.CONTAINED, 0.1),
    "a sheet inside, one on a face": (SOLID, joined(sheet(0.9), sheet(1, 0.5, 1.5)), Verdict.CONTAINED, 0.1),
    "a sheet inside, one through a face": (SOLID, joined(sheet(0.9), THROUGH), Verdict.CLASH, 0.3125),
    "flush inside a face": (SOLID, LID, Verdict.CONTAINED, 0.1),
    "flush inside a face, a sheet apart": (SOLID, joined(LID, sheet(5)), Verdict.CONTAINED, 0.1),
    "flush inside a face, a solid apart": (SOLID, joined(LID, FAR_A), Verdict.CONTAINED, 0.1),
    "a plug larger than its hollow": (HOLLOW, box((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1)), Verdict.CLASH, 0.1 * 3**0.5),
    "a lining sunk into its wall": (
        HOLLOW,
        joined(box((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1)), inverted(INNER)),
        Verdict.CLASH,
        0.1 * 3**0.5,
    ),
    "a plug larger than its hollow, one beside": (
        joined(HOLLOW, FAR_A),
        joined(box((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1)), FAR_B),
        Verdict.CLASH,
        0.1 * 3**0.5,
    ),
    "a hollow solid, and all of its outside": (box((-1, -1, -1), (2, 2, 2)), HOLLOW, Verdict.CONTAINED, 1.0),
    "a thinner wall of the same outside": (
        joined(box((-1, -1, -1), (2, 2, 2)), inverted(box((-0.5, -0.5, -0.5), (1.5, 1.5, 1.5)))),
        HOLLOW,
        Verdict.CONTAINED,
        0.5,
    ),
    "a shell around the same hollow": (
        joined(box((-4, -4, -4), (5, 5, 5)), inverted(SOLID)),
        joined(box((-2, -2, -2), (3, 3, 3)), inverted(SOLID)),
        Verdict.CONTAINED,
        2.0,
    ),
    "a block beside a hollow, flush": (
        joined(box((-4, -4, -4), (5, 5, 5)), inverted(SOLID)),
        box((1, 0, 0), (2, 1, 1)),
        Verdict.CONTAINED,
        1.0,
    ),
    "a hollow solid inside": (box((-2, -2, -2), (3, 3, 3)), HOLLOW, Verdict.CONTAINED, 2.0),
    "a shell in a wall, around its hollow": (
        joined(box((-2, -2, -2), (3, 3, 3)), inverted(SOLID)),
        joined(box((-1, -1, -1), (2, 2, 2)), inverted(box((-0.5, -0.5, -0.5), (1.5, 1.5, 1.5)))),
        Verdict.CONTAINED,
        1.0,
    ),
}


def test_contact_allows_a_plug_that_is_larger_than_its_hollow() -> None:
    mockup = mockup_of({"housing": HOLLOW, "plug": box((-1e-3, -1e-3, -1e-3), (1.001, 1.001, 1.001))})
    for contact, verdict in ((1.7e-3, Verdict.CLASH), (1.8e-3, Verdict.CONTACT)):
        (row,) = feeler.clash(mockup, contact=contact)
        assert row.verdict == verdict and row.depth <= 1e-3 * 3**0.5 <= row.depth + row.depth_error


def test_the_gravest_piece_decides_with_a_given_contact() -> None:
    thin = box((0.3, 0.3, 0.96), (0.6, 0.6, 1))
    pressed = box((0.95, 0.3, 0.3), (2, 0.6, 0.6))
    upright = (np.array([[0.4, 0.5, 0.5], [0.4, 0.5, 1.02], [0.6, 0.5, 1.02], [0.6, 0.5, 0.5]]), FLAT)
    for alone, verdict in (
        (sheet(0.95), Verdict.CONTACT),
        (sheet(0.8), Verdict.CONTAINED),
        (thin, Verdict.CONTAINED),
        (pressed, Verdict.CONTACT),
        (upright, Verdict.CLASH),
        (joined(INNER, pressed), Verdict.CONTAINED),
        (joined(sheet(0.8), pressed), Verdict.CONTAINED),
        (joined(thin, pressed), Verdict.CONTAINED),
        (joined(INNER, upright), Verdict.CLASH),
    ):
        for more in ((), (FAR_A,), (sheet(5),), (FAR_A, sheet(5))):
            for turn in (np.eye(3), random_turn(np.random.default_rng(len(more)))):
                parts = {"a": SOLID, "b": joined(alone, *more)}
                placed = {name: (mesh[0] @ turn.T, mesh[1]) for name, mesh in parts.items()}
                (row,) = feeler.clash(mockup_of(placed), contact=0.1)
                assert row.verdict == verdict


def test_points_of_a_plug_larger_than_its_closed_hollow_are_the_deepest() -> None:
    (row,) = feeler.clash(mockup_of({"a": HOLLOW, "b": box((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1))}))
    assert row.verdict == Verdict.CLASH and row.gap > 0
    assert np.linalg.norm(np.subtract(row.point_a, row.point_b)) == pytest.approx(row.depth, rel=1e-3)


def test_open_surfaces_that_cross_clash_beside_solids() -> None:
    for one, other in ((joined(sheet(1), FAR_A), joined(THROUGH, FAR_B)), (joined(sheet(1), FAR_A), THROUGH)):
        (row,) = feeler.clash(mockup_of({"a": one, "b": other}))
        assert row.verdict == Verdict.CLASH and row.depth == pytest.approx(3 - 8**0.5, rel=2e-3)


@pytest.mark.parametrize("gap", [1e-5, 1e-4, 1e-3])
def test_what_leaves_through_a_crack_clashes(gap: float, rng: np.random.Generator) -> None:
    # A box whose lid is lifted, and a block in it with a blade that leaves through the crack: nothing crosses.
    corners, faces = SOLID
    is_lid = (corners[faces][:, :, 2] == 1).all(axis=1)
    lifted = (
        np.concatenate([corners, corners + np.array([0, 0, gap])]),
        np.where(is_lid[:, None], faces + len(corners), faces),
    )
    for far in (0.0, 1.0):
        turn = random_turn(rng) if far else np.eye(3)
        for out in (-0.2, 0.01 * gap, gap, 0.3):
            block, low, high = box((0.4, 0.4, 0.4), (0.6, 0.6, 1 + gap / 3)), 1 + gap / 3, 1 + 2 * gap / 3
            blade = box((0.4, 0.4, low), (1 + out, 0.6, high))
            parts = {"box": lifted, "block": joined(block, blade)}
            placed = {name: (mesh[0] @ turn.T + far, mesh[1]) for name, mesh in parts.items()}
            (row,) = feeler.clash(mockup_of(placed))
            assert row.verdict == (Verdict.CLASH if out > 0 else Verdict.CONTAINED)
            assert row.depth == pytest.approx(0.4, rel=2e-3)
            assert len(feeler.clash(mockup_of(placed | {"block": box((1.01, 0, 0), (2, 1, 1))}))) == 0


@pytest.mark.parametrize("name", PAIRS)
def test_a_solid_of_a_part_is_contained_if_no_other_crosses(name: str, rng: np.random.Generator) -> None:
    *pair, verdict, depth = PAIRS[name]
    for far in (0.0, 1.0, 3000.0):
        turn = random_turn(rng) if far else np.eye(3)
        for cut in ((0, 0), (1, 0), (1, 2)):
            a, b = (cut_finer(mesh, levels) for mesh, levels in zip(pair, cut, strict=True))
            parts = {"a": (a[0] @ turn.T + far, a[1]), "b": (b[0] @ turn.T + far, b[1])}
            for names in (("a", "b"), ("b", "a")):
                (row,) = feeler.clash(mockup_of({name: parts[name] for name in names}))
                assert row.verdict == verdict
                assert row.depth == pytest.approx(depth, rel=1e-3, abs=1e-8)
