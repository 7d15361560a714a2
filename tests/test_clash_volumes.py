"""Shared volumes of parts whose surfaces overlap, repeat, or are wound against each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapes import Mesh, box, inverted, joined, mockup_of

import feeler

pytest.importorskip("manifold3d")

UNIT = box((0, 0, 0), (1, 1, 1))
SECOND = box((3, 0, 0), (4, 1, 1))
AROUND = box((2, -1, -1), (5.5, 2, 2))
BAR = box((0.6, 0.4, 0.4), (0.9, 0.6, 1.5))
LONG = box((3.8, 0.4, 0.4), (5, 0.6, 0.6))
INSIDE = box((3.4, 0.4, 0.4), (3.6, 0.6, 0.6))
LARGE = box((-9, -9, -9), (9, 9, -5))


def turned_diagonals(mesh: Mesh) -> Mesh:
    """The same box with the other diagonals."""
    vertices, faces = mesh
    return 1.0 - vertices, faces[:, ::-1]


DOUBLED = UNIT[0], np.concatenate([UNIT[1], np.roll(UNIT[1], 1, axis=1)])
CASES: dict[str, tuple[Mesh, Mesh, float]] = {
    "triangles twice": (DOUBLED, BAR, 0.036),
    "some triangles twice": ((UNIT[0], np.concatenate([UNIT[1], UNIT[1][:5]])), BAR, 0.036),
    "surface twice": (joined(UNIT, UNIT), BAR, 0.036),
    "surface twice, cut otherwise": (joined(UNIT, turned_diagonals(UNIT)), BAR, 0.036),
    "overlapping solids": (joined(UNIT, box((0.5, 0, 0), (2, 1, 1))), BAR, 0.036),
    "flush solids": (joined(UNIT, box((1, 0, 0), (2, 1, 1))), box((0.9, 0.4, 0.4), (1.1, 0.6, 1.5)), 0.024),
    "second inside out": (joined(UNIT, inverted(SECOND)), LONG, 0.008),
    "second inside out, contained": (joined(UNIT, inverted(SECOND)), INSIDE, 0.008),
    "larger, and inside out": (joined(LARGE, inverted(SECOND)), LONG, 0.008),
    "one of three inside out": (joined(UNIT, LARGE, inverted(SECOND)), INSIDE, 0.008),
    "all inside out": (inverted(joined(UNIT, SECOND)), LONG, 0.008),
    "hollow": (joined(AROUND, inverted(SECOND)), LONG, 0.04),
    "hollow, inside out": (inverted(joined(AROUND, inverted(SECOND))), LONG, 0.04),
    "solid in a solid": (joined(AROUND, SECOND), LONG, 0.048),
    "solid in a hollow in a hollow": (
        joined(
            *(box((-3, -3, -3), (4, 4, 4)), inverted(box((-2, -2, -2), (3, 3, 3)))),
            *(box((-1, -1, -1), (2, 2, 2)), inverted(UNIT)),
        ),
        BAR,
        0.03,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_volumes_are_those_of_the_union(name: str) -> None:
    part, other, volume = CASES[name]
    for given in ({"a": part, "b": other}, {"a": other, "b": part}):
        (row,) = feeler.clash(mockup_of(given), clearance=0, volume=True)
        assert row.depth_kind == "measured" and row.volume == pytest.approx(volume, rel=1e-9)


def test_no_volume_is_negative_or_more_than_the_smaller_part() -> None:
    """Where the surfaces leave open what is inside, there is no volume."""
    sharing = joined(UNIT, box((0, 0, 0), (1, 1, 0.99)))  # four edges of four triangles, paired in no certain way
    flush = joined(UNIT, inverted(box((1, 0, 0), (2, 1, 1))))
    for part in (sharing, flush, joined(UNIT, inverted(UNIT))):
        (row,) = feeler.clash(mockup_of({"a": part, "b": BAR}), clearance=0, volume=True)
        assert math.isnan(row.volume) or row.volume == pytest.approx(0.036)


def test_many_surfaces_in_one_part() -> None:
    """Solids and hollows in turn, in and out of a block; triangles of a surface need not follow each other."""
    cubes = [box(corner, np.add(corner, 0.5)) for corner in np.ndindex(3, 3, 8)]
    turned = [inverted(cube) if place % 2 else cube for place, cube in enumerate(cubes)]
    vertices, faces = joined(*turned)
    faces = np.random.default_rng(1).permutation(faces)
    other = box((-2, -2, -2), (1.25, 1.25, 1.25))
    (row,) = feeler.clash(mockup_of({"a": (vertices, faces), "b": other}), clearance=0, volume=True)
    assert row.volume == pytest.approx(0.75**3)
    block = joined(box((-1, -1, -1), (4, 4, 9)), (vertices, faces))
    (row,) = feeler.clash(mockup_of({"a": block, "b": other}), clearance=0, volume=True)
    assert row.volume == pytest.approx(2.25**3 - 0.25 * 0.75**2)  # the odd ones are hollows: those at z = 1


def loose(mesh: Mesh, noise: float) -> Mesh:
    """Triangles that share no corners, each of which is off by up to `noise`, metres."""
    corners = mesh[0][mesh[1]].reshape(-1, 3)
    off = np.random.default_rng(2).uniform(-noise, noise, corners.shape)
    return corners + off, np.arange(len(corners)).reshape(-1, 3)


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-9, 1e-7, 8e-7])
@pytest.mark.parametrize("name", ["hollow", "all inside out", "second inside out", "overlapping solids"])
def test_seams_that_do_not_quite_meet_are_merged(name: str, noise: float) -> None:
    part, other, volume = CASES[name]
    for far in (0.0, 5000.0):
        placed = {"a": (loose(part, noise)[0] + far, loose(part, noise)[1]), "b": (other[0] + far, other[1])}
        found = feeler.clash(mockup_of(placed), clearance=0, volume=True)
        assert found[0].depth_kind == "measured" and not found.facts.notes
        assert found[0].volume == pytest.approx(volume, rel=1e-9 + 100 * noise + 1e-15 * far)


def test_a_note_names_parts_without_a_volume() -> None:
    """The lid of a box is lifted by a crack, which closes for depths and not for volumes."""
    lifted = joined((UNIT[0], UNIT[1][(UNIT[0][UNIT[1]][:, :, 2] < 1).any(axis=1)]), (UNIT[0] + [0, 0, 2e-4], UNIT[1]))
    lid = (lifted[0][lifted[1]][:, :, 2] > 1).all(axis=1)
    lifted = lifted[0], lifted[1][lid | (lifted[1] < len(UNIT[0])).all(axis=1)]
    parts = {"top/lifted": lifted, "top/bar": BAR, "top/other": box((0.7, 0.5, 0.5), (0.8, 0.55, 3))}
    found = feeler.clash(mockup_of(parts), clearance=0, volume=True)
    assert not found.columns.is_open.any()
    volumes = {(row.path_a, row.path_b): row.volume for row in found}
    assert [math.isnan(volumes[pair]) for pair in sorted(volumes)] == [False, True, True]
    (note,) = found.facts.notes
    assert note.startswith("no shared volume is measured of lifted:")
    assert not feeler.clash(mockup_of(parts), clearance=0).facts.notes


@pytest.mark.parametrize("contact", [0.0, 5e-4, 1e-2])
def test_a_contact_that_overlaps_shares_volume(contact: float) -> None:
    parts = {"a": UNIT, "b": box((0.999, 0.1, 0.1), (2, 0.9, 0.9)), "flush": box((-1, 0, 0), (0, 1, 1))}
    found = {
        frozenset((row.path_a, row.path_b)): row for row in feeler.clash(mockup_of(parts), contact=contact, volume=True)
    }
    assert found[frozenset("ab")].volume == pytest.approx(0.00064)
    assert found[frozenset(("a", "flush"))].volume == 0.0
