"""Rings and splines of thick pins are no thin walls; thin fins of thick parts, needles and screws through foils are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from clash.judge.shapes import random_turn
from shapes import Floats, Mesh, box, joined, mockup_of, prism_ring

import feeler
from feeler import Verdict


def pin(radii: Floats, heights: Floats, turns: Floats) -> Mesh:
    """Closed, of rings at some heights about z, each turned. radii: `(rings, sides)`."""
    rings, sides = radii.shape
    angles = np.arange(sides) / sides * 2 * math.pi + turns[:, None]
    z = np.broadcast_to(heights[:, None], radii.shape)
    vertices = np.stack([radii * np.cos(angles), radii * np.sin(angles), z], axis=2).reshape(-1, 3)
    a = np.arange(rings * sides).reshape(rings, sides)
    b = np.roll(a, -1, axis=1)
    around = np.stack([a[:-1], b[:-1], b[1:], a[:-1], b[1:], a[1:]], axis=2).reshape(-1, 3)
    ends = [
        [rings * sides + np.zeros(sides, int), b[0], a[0]],
        [rings * sides + 1 + np.zeros(sides, int), a[-1], b[-1]],
    ]
    caps = np.concatenate([np.stack(end, axis=1) for end in ends])
    middles = [[0, 0, heights[0]], [0, 0, heights[-1]]]
    return np.concatenate([vertices, middles]), np.concatenate([around, caps])


def ridged(kind: str, height: float) -> Mesh:
    """A pin of radius 1 with ridges of a height; as high as 0, without."""
    z = np.linspace(-3, 3, 97)
    still = np.zeros(len(z))
    if kind == "rings":
        return pin(np.tile(1 - height * (np.arange(len(z)) % 2)[:, None], (1, 32)), z, still)
    return pin(np.tile(1 - height * (np.arange(32) % 2), (2, 1)), z[[0, -1]], still[:2])


def screw(sides: int, steps: int) -> Mesh:
    """M6 of pitch 1 mm, closed, in millimetres."""
    z, angles = np.arange(-8 * steps, 8 * steps + 1) / steps, np.arange(sides) / sides
    return pin(3 - 0.61 * np.abs(2 * ((z[:, None] - angles) % 1) - 1), z, np.zeros(len(z)))


@pytest.mark.parametrize("kind", ["rings", "splines"])
def test_a_ridged_pin_that_is_too_thick_is_no_wall(kind: str) -> None:
    """It is in contact as it would be without ridges: its plate stays away from its middle."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        turn, thick, hole = random_turn(rng), float(rng.choice([0.05, 0.25, 0.5])), float(rng.uniform(0.45, 0.8))
        low, high = prism_ring(5.0, hole, 48, -thick / 2, thick / 2), float(rng.uniform(0.0, 0.3))
        for height in (0.0, 0.075):
            vertices, faces = ridged(kind, height)
            moved = {"plate": (low[0] @ turn.T, low[1]), "pin": ((vertices + np.array([high, 0, 0])) @ turn.T, faces)}
            mockup = mockup_of(moved)
            deep = feeler.clash(mockup)[0]
            assert deep.verdict == Verdict.CLASH
            for share in (1.02, 1.3, 2.0):
                (row,) = feeler.clash(mockup, contact=share * (deep.depth + deep.depth_error))
                assert row.verdict == Verdict.CONTACT, (height, thick, hole, high, share)


@pytest.mark.parametrize("slant", [0.0, 0.5])
@pytest.mark.parametrize("sides", [3, 4, 5, 8, 16])
def test_a_thin_fin_of_a_thick_part_is_a_wall(sides: int, slant: float) -> None:
    """A flange of a thick pin, pierced by a rod that is much thinner than it, also at a slant."""
    flange = pin(np.repeat([[2.0], [2.0], [6.0], [6.0], [2.0], [2.0]], 24, axis=1), FLANGE, np.zeros(6))
    leaning = np.array([[math.cos(slant), 0, math.sin(slant)], [0, 1, 0], [-math.sin(slant), 0, math.cos(slant)]])
    rod, its_faces = prism_ring(0.12, 0.0, sides, -4, 4, 0.1)
    rng = np.random.default_rng(7)
    for _ in range(3):
        turn, aside = random_turn(rng), np.array([4, rng.uniform(-0.5, 0.5), 0])
        moved = {"flange": (flange[0] @ turn.T, flange[1]), "rod": ((rod @ leaning.T + aside) @ turn.T, its_faces)}
        (row,) = feeler.clash(mockup_of(moved), contact=1.0)
        assert row.verdict == Verdict.CLASH and row.depth < 1.0


@pytest.mark.parametrize("points", [3, 5, 8])
@pytest.mark.parametrize("inner", [0.3, 0.6, 0.9])
def test_a_star_needle_through_a_foil_clashes(points: int, inner: float) -> None:
    rng = np.random.default_rng(7)
    radii = np.tile(np.where(np.arange(2 * points) % 2, 0.1 * inner, 0.1), (2, 1))
    needle, its_faces = pin(radii, np.array([-4.0, 4.0]), np.zeros(2))
    for _ in range(3):
        turn, lean = random_turn(rng), np.array([rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), 0.0])
        foil, faces = box((-3, -3, -0.05), (3, 3, 0.05))
        leaning = needle + needle[:, 2:] * lean
        moved = {"foil": (foil @ turn.T, faces), "needle": (leaning @ turn.T, its_faces)}
        (row,) = feeler.clash(mockup_of(moved), contact=0.5)
        assert row.verdict == Verdict.CLASH and row.depth < 0.5


FLANGE = np.array([-4.0, -0.6, -0.6, 0.6, 0.6, 4.0])


def test_parallel_fins_clash_with_a_sheet_through_them() -> None:
    comb = joined(box((-9, -9, -6), (9, 9, 0)), *(box((x, -8, -1), (x + 0.7, 8, 6)) for x in (-6.0, 0.0, 6.0)))
    sheet = box((-8, -2, 3), (8, 2, 3.5))
    for number in range(3):
        turn = random_turn(np.random.default_rng(number))
        moved = {name: (mesh[0] @ turn.T, mesh[1]) for name, mesh in (("comb", comb), ("sheet", sheet))}
        assert feeler.clash(mockup_of(moved), contact=1.0)[0].verdict == Verdict.CLASH


@pytest.mark.parametrize("thick", [0.5, 1.8, 3.0])
@pytest.mark.parametrize(("sides", "steps"), [(12, 4), (24, 8), (32, 12)])
def test_a_screw_through_a_sheet_clashes_whatever_its_facets(sides: int, steps: int, thick: float) -> None:
    rng = np.random.default_rng(7)
    vertices, faces = screw(sides, steps)
    sheet, its_faces = box((-20, -20, -thick / 2), (20, 20, thick / 2))
    for shift in (0.0, 0.2, 0.6):
        turn = random_turn(rng)
        moved = {
            "sheet": (sheet @ turn.T, its_faces),
            "screw": ((vertices + np.array([0, 0, shift])) @ turn.T, faces),
        }
        (row,) = feeler.clash(mockup_of(moved), contact=4.0)
        assert row.verdict == Verdict.CLASH and row.depth < 4.0
