"""Verdicts that must not depend on the place, turn, order, triangulation and handedness of the parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from clash.judge.shapes import random_turn
from clash_scene import open_box
from shapes import Mesh, box, joined, mockup_of
from test_clash_seams import worn

import feeler
from feeler import Verdict
from feeler.clashes import Rule, Rules

UNIT = box((0, 0, 0), (1, 1, 1))


def plate(corner: tuple[float, ...], u: tuple[float, ...], v: tuple[float, ...]) -> Mesh:
    at, along, aside = (np.array(each, dtype=float) for each in (corner, u, v))
    return np.array([at, at + along, at + along + aside, at + aside]), np.array([[0, 1, 2], [0, 2, 3]])


def quartered(mesh: Mesh) -> Mesh:
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.concatenate([np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, faces.reshape(-1, 3)


def poses(one: Mesh, other: Mesh) -> Iterator[dict[str, Mesh]]:
    """The two at the origin and elsewhere, turned, mirrored, cut, and in both orders."""
    rng = np.random.default_rng(7)
    for number in range(12):
        turn = random_turn(rng) if number else np.eye(3)
        place = rng.normal(size=3) * [0.0, 1.0, 100.0, 3000.0][number % 4]
        pair = [quartered(one) if number % 3 == 1 else one, quartered(other) if number % 3 == 2 else other]
        if number % 5 == 4:
            turn = turn @ np.diag([1.0, 1.0, -1.0])
            pair = [(vertices, faces[:, ::-1]) for vertices, faces in pair]
        moved = [(vertices @ turn.T + place, faces) for vertices, faces in pair]
        yield dict(zip("ab", moved[:: 1 - 2 * (number % 2)], strict=True))


def said(one: Mesh, other: Mesh, contact: float = 0.0) -> tuple[set[Verdict], list[float]]:
    """The verdicts and depths at all poses."""
    rows = [feeler.clash(mockup_of(parts), contact=contact)[0] for parts in poses(one, other)]
    return {row.verdict for row in rows}, [row.depth for row in rows]


FLOOR = plate((-1, -1, 0), (2, 0, 0), (0, 2, 0))
TONGUE = plate((0.1, -0.5, -1e-3), (0, 1, 0), (0, 0, 1))


@pytest.mark.parametrize(
    ("one", "other", "contact", "verdict", "depth"),
    [
        (FLOOR, plate((0, -0.5, -1), (0, 1, 0), (0, 0, 2)), 0.0, Verdict.CLASH, 0.5),
        (FLOOR, TONGUE, 0.0, Verdict.CLASH, 1e-3),
        (FLOOR, TONGUE, 0.01, Verdict.CONTACT, 1e-3),
        (FLOOR, plate((0, -0.5, 0), (0, 1, 0), (0, 0, 2)), 0.0, Verdict.CONTACT, 0.0),
        (FLOOR, plate((0.5, -0.5, 0), (2, 0, 0), (0, 1, 0)), 0.0, Verdict.CONTACT, 0.0),
        (open_box((0, 0, 0), (1, 1, 1)), open_box((0.9, 0, 0), (1.9, 1, 1)), 0.0, Verdict.CLASH, 0.1),
        (open_box((0, 0, 0), (1, 1, 1)), open_box((1, 0, 0), (2, 1, 1)), 0.0, Verdict.CONTACT, 0.0),
    ],
    ids=["through", "tongue", "forgiven tongue", "web", "coplanar", "tubs", "tubs side by side"],
)
def test_open_surfaces_clash_where_they_cross(
    one: Mesh, other: Mesh, contact: float, verdict: Verdict, depth: float
) -> None:
    verdicts, depths = said(one, other, contact)
    assert verdicts == {verdict}
    assert depths == pytest.approx([depth] * len(depths), rel=2e-3, abs=1e-9)


def test_the_depth_of_open_surfaces_is_an_estimate() -> None:
    (row,) = feeler.clash(mockup_of({"a": FLOOR, "b": TONGUE}))
    assert row.depth_kind == "estimate" and math.isnan(row.depth_error)
    assert np.linalg.norm(row.translation) >= row.depth
    scene = feeler.Scene(mockup_of({"a": FLOOR}))
    found = scene.depth(feeler.Tool(TONGUE[0], TONGUE[1]), np.eye(4))
    assert found.depths == pytest.approx([row.depth]) and found.is_estimate.all() and np.isnan(found.errors).all()


@pytest.mark.parametrize("contact", [0.0, 1e-3, 0.3])
def test_a_sheet_on_a_face_is_in_contact(contact: float) -> None:
    for sheet in (plate((0.25, 0.25, 1), (0.5, 0, 0), (0, 0.5, 0)), plate((0, 0, 1), (1, 0, 0), (0, 1, 0))):
        assert said(UNIT, sheet, contact)[0] == {Verdict.CONTACT}


def test_a_sheet_below_a_face_is_contained_if_it_is_deeper_than_contact() -> None:
    sheet = plate((0.25, 0.25, 1 - 1e-6), (0.5, 0, 0), (0, 0.5, 0))
    assert said(UNIT, sheet)[0] == {Verdict.CONTAINED}
    assert said(UNIT, sheet, 1e-5)[0] == {Verdict.CONTACT}
    (row,) = feeler.clash(mockup_of({"a": UNIT, "b": sheet}), contact=1e-5)
    assert row.gap == pytest.approx(1e-6) and np.isfinite(row.box).all()


@pytest.mark.parametrize("contact", [0.0, 1e-4])
def test_a_foil_buried_flush_is_contained(contact: float) -> None:
    assert said(UNIT, box((0.25, 0.25, 1 - 5e-5), (0.75, 0.75, 1)), contact)[0] == {Verdict.CONTAINED}


@pytest.mark.parametrize(
    ("low", "thick", "contact", "verdict"),
    [
        ((0.02, 0.0, 0.0), 1e-3, 0.51e-3, Verdict.CLASH),
        ((0.3, 0.2, 0.0), 1e-3, 0.51e-3, Verdict.CLASH),
        ((0.3, 0.2, 0.3e-3), 1e-3, 0.51e-3, Verdict.CLASH),
        ((0.3, 0.2, 0.6e-3), 1e-3, 0.51e-3, Verdict.CONTACT),
        ((1 - 0.4e-3, 0.0, 0.0), 1e-3, 0.51e-3, Verdict.CONTACT),
        ((1 - 4e-5, 0.0, 0.0), 5e-5, 1e-4, Verdict.CONTACT),
        ((0.3, 0.0, 2e-5), 5e-5, 1e-4, Verdict.CONTACT),
    ],
    ids=["in line", "aside", "a little up", "half up", "by the edge", "foils by the edge", "foils"],
)
def test_walls_side_by_side_clash_if_they_share_more_than_contact(
    low: tuple[float, ...], thick: float, contact: float, verdict: Verdict
) -> None:
    other = box(low, (low[0] + 1, low[1] + 1, low[2] + thick))
    assert said(box((0, 0, 0), (1, 1, thick)), other, contact)[0] == {verdict}


def test_loose_seams_contain_what_they_touch() -> None:
    rng = np.random.default_rng(7)
    outer = quartered(quartered(UNIT))
    for by in (1e-12, 1e-9):
        for _ in range(8):
            low = rng.uniform(0.1, 0.4, 3)
            low[rng.integers(3)] = by * rng.uniform(0.1, 1.5)
            turn = random_turn(rng)
            parts = {"outer": worn(outer, by, 200, rng), "inner": box(low, low + 0.5)}
            moved = {name: (vertices @ turn.T, faces) for name, (vertices, faces) in parts.items()}
            assert feeler.clash(mockup_of(moved))[0].verdict is Verdict.CONTAINED
    # Farther out than the seams are loose.
    out = {"outer": worn(outer, 1e-9, 200, rng), "inner": box((-1e-6, 0.2, 0.2), (0.5, 0.7, 0.7))}
    assert feeler.clash(mockup_of(out))[0].verdict is Verdict.CLASH


def mixed(rng: np.random.Generator) -> dict[str, Mesh]:
    """Foils, needles, sheets, tubs and blocks near each other, with names in any order."""
    parts = {}
    for number in rng.permutation(12).tolist():
        low = np.round(rng.uniform(0, 1, 3), int(rng.integers(1, 4)))
        sizes = [[1, 1, 1e-3], [0.3, 0.3, 2e-4], [0.25, 0.25, 0.25], [2e-4, 2e-4, 0.5], rng.uniform(0.1, 1, 3)]
        size = rng.permutation(sizes[int(rng.integers(5))])
        shapes = [box(low, low + size), open_box(low, low + size), plate(low, (size[0], 0, 0), (0, size[1], 0))]
        parts[f"r{number % 3}/p{number}"] = shapes[int(rng.choice(3, p=[0.7, 0.15, 0.15]))]
    return parts


def test_rules_on_saved_findings_agree_with_a_fresh_check_or_say_why_not(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    agreed = 0
    for _ in range(16):
        mockup = mockup_of(mixed(rng))
        contact, clearance = float(rng.choice([0, 1e-6, 1e-4, 1e-3])), float(rng.choice([0.0, 0.1]))
        found = feeler.clash(mockup, contact=contact, clearance=clearance)
        found.save(tmp_path / "a.json")
        rules = Rules((Rule("x", "r0", contact=float(rng.choice([0.0, 4e-5, 1e-4, 2e-4, 0.02]))),))
        tried = feeler.load_clashes(tmp_path / "a.json").with_rules(rules)
        fresh = feeler.clash(mockup, contact=contact, clearance=clearance, rules=rules)
        is_same = {(r.id, r.verdict) for r in tried} == {(r.id, r.verdict) for r in fresh}
        assert is_same or tried.facts.notes
        agreed += is_same
        order = {row.id: (row.path_a, row.path_b) for row in fresh}
        assert all(order.get(row.id, (row.path_a, row.path_b)) == (row.path_a, row.path_b) for row in tried)
    assert agreed > 7


def test_an_angle_on_a_tub_is_in_contact_and_one_through_it_a_clash() -> None:
    angle = joined(
        plate((-0.2, -0.5, 0), (1.8, 0, 0), (0, 1, 0)),
        plate((-0.2, -0.5, 0), (0, 1, 0), (0, 0, 0.5)),
    )
    tub = open_box((-1, -1, 0), (1, 1, 1))
    assert said(tub, angle)[0] == {Verdict.CLASH}
    turned = tub[0] * [1, 1, -1], tub[1]
    assert said(turned, angle)[0] == {Verdict.CONTACT}
