"""Verdicts of parts whose faces or halves are a little apart, with others that go through the gaps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from clash.judge.shapes import random_turn
from shapes import Floats, Mesh, box, joined, mockup_of, prism_ring

import feeler
from feeler import Verdict

GAPS = [1e-6, 1e-5, 1e-4]
TURNS = 6
BLOCK = box((0.3, 0.3, 0.3), (0.7, 0.7, 0.7))


def plate(corner: Floats, along: Floats, aside: Floats, cells: tuple[int, int]) -> Mesh:
    """A rectangle of cells, each cut in two."""
    u, v = (np.linspace(0, 1, n + 1)[:, None] for n in cells)
    vertices = corner + (u * along)[:, None] + (v * aside)[None]
    at = np.arange(u.size * v.size).reshape(u.size, v.size)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    return vertices.reshape(-1, 3), np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def sides(low: Floats, high: Floats, rng: np.random.Generator | None = None) -> Iterator[Mesh]:
    """The sides of a box, wound outwards, by axes, the lower one first; with `rng` each cut otherwise."""
    for axis in range(3):
        out, along, aside = np.diag(high - low)[[axis, (axis + 1) % 3, (axis + 2) % 3]]
        for corner, pair in ((low, (aside, along)), (low + out, (along, aside))):
            m, n = (1, 1) if rng is None else rng.integers(1, 6, 2).tolist()
            yield plate(corner, *pair, (m, n))


def loose_box(gap: float, rng: np.random.Generator | None) -> Mesh:
    """A unit box of six faces, each moved outwards by the gap."""
    ways = [sense * gap * axis for axis in np.eye(3) for sense in (-1, 1)]
    faces = sides(np.zeros(3), np.ones(3), rng)
    return joined(*((vertices + way, cut) for (vertices, cut), way in zip(faces, ways, strict=True)))


def halves(gap: float) -> Mesh:
    """A unit box in two halves, a gap above each other, and open where they were cut."""
    below, above = np.array([0, 0, 0.5 + gap]), np.array([1, 1, 1 + gap])
    _, _, _, _, _, top = lower = list(sides(np.zeros(3), np.array([1, 1, 0.5])))
    upper = list(sides(below, above))
    assert (top[0][:, 2] == 0.5).all()
    return joined(*lower[:5], *upper[:4], upper[5])


def split_drum(gap: float, below: int, above: int) -> Mesh:
    """A drum of radius 0.5 in two halves, as `halves`, with some facets around."""
    lower, upper = prism_ring(0.5, 0, below, -0.5, -gap / 2), prism_ring(0.5, 0, above, gap / 2, 0.5, 0.01)
    cut = [
        (vertices, faces[~(vertices[faces][:, :, 2] == height).all(axis=1)])
        for (vertices, faces), height in ((lower, -gap / 2), (upper, gap / 2))
    ]
    return joined(*cut)


def through_edge(gap: float, out: float, deep: float, wide: float) -> Mesh:
    """A blade through the edge of a loose box, a third as thick as the gap."""
    axes = np.array([[1, 1, 0], [1, -1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    vertices, faces = box((-deep, -gap / 6, -wide / 2), (out, gap / 6, wide / 2))
    return vertices @ axes + [1 + gap / 2, 1 + gap / 2, 0.5], faces


def said(one: Mesh, other: Mesh, rng: np.random.Generator) -> tuple[set[Verdict | None], list[float]]:
    """Verdicts and depths of all turns and orders; None for no finding."""
    verdicts: set[Verdict | None] = set()
    depths = []
    for number in range(TURNS):
        turn = random_turn(rng) if number else np.eye(3)
        place = rng.normal(size=3) * [0, 1, 100][number % 3]
        parts = {name: (mesh[0] @ turn.T + place, mesh[1]) for name, mesh in (("a", one), ("b", other))}
        rows = feeler.clash(mockup_of({name: parts[name] for name in ("ab", "ba")[number % 2]}), clearance=0)
        verdicts |= {row.verdict for row in rows} or {None}
        depths += [row.depth for row in rows]
    return verdicts, depths


@pytest.mark.parametrize("out", [1e-3, 2e-2])
@pytest.mark.parametrize("gap", GAPS)
@pytest.mark.parametrize("is_cut", [False, True])
def test_a_blade_through_a_loose_edge_clashes(gap: float, out: float, is_cut: bool, rng: np.random.Generator) -> None:
    loose = loose_box(gap, rng if is_cut else None)
    for wide in (gap / 3, 0.01, 0.6):
        for deep in (0.01, 0.3):
            verdicts, depths = said(loose, through_edge(gap, out, deep, wide), rng)
            assert verdicts == {Verdict.CLASH}
            assert depths == pytest.approx([deep / np.sqrt(2)] * TURNS, rel=2e-3, abs=2 * gap)
    blade = through_edge(gap, out, 0.3, 0.3)
    for block in (BLOCK, box((0.3, 0.3, -gap), (0.7, 0.7, 0.7))):
        verdicts, depths = said(loose, joined(block, blade), rng)
        assert verdicts == {Verdict.CLASH}
        assert depths == pytest.approx([0.3] * TURNS, rel=2e-3, abs=2 * gap)


@pytest.mark.parametrize("gap", GAPS)
def test_a_loose_box_contains_what_is_inside(gap: float, rng: np.random.Generator) -> None:
    for loose in (loose_box(gap, None), loose_box(gap, rng)):
        for inside in (BLOCK, through_edge(gap, -1e-3, 0.3, 0.3), joined(BLOCK, through_edge(gap, -0.01, 0.2, 0.3))):
            assert said(loose, inside, rng)[0] == {Verdict.CONTAINED}
        assert said(loose, box((1 + 2 * gap, 0.1, 0.1), (1.5, 0.9, 0.9)), rng)[0] == {None}


@pytest.mark.parametrize("out", [1e-3, 2e-2])
@pytest.mark.parametrize("gap", GAPS)
def test_plates_across_a_split_part_clash(gap: float, out: float, rng: np.random.Generator) -> None:
    split, low, high = halves(gap), 0.5 + gap / 3, 0.5 + 2 * gap / 3
    sheet = plate(np.array([-out, -out, low]), np.array([1 + 2 * out, 0, 0]), np.array([0, 1 + 2 * out, 0]), (1, 1))
    for plates, depth in (
        (box((0.5, 0.3, low), (1 + out, 0.6, high)), 0.5),
        (box((0.9, 0.3, low), (1 + out, 0.3 + gap, high)), 0.1),
        (box((-out, 0.3, low), (1 + out, 0.6, high)), 0.5),
        (box((-out, -out, low), (1 + out, 1 + out, high)), 0.5),
        (sheet, 0.5),
        (joined(box((0.2, 0.2, 0.2), (0.4, 0.8, 0.45)), box((0.5, 0.3, low), (1 + out, 0.6, high))), 0.5),
    ):
        verdicts, depths = said(split, plates, rng)
        assert verdicts == {Verdict.CLASH}
        assert depths == pytest.approx([depth] * TURNS, rel=2e-3, abs=2 * gap)
    assert said(split, box((0.1, 0.1, low), (0.9, 0.9, high)), rng)[0] == {Verdict.CONTAINED}


@pytest.mark.parametrize("gap", GAPS)
@pytest.mark.parametrize("facets", [(24, 24), (200, 200), (200, 150)])
def test_a_gasket_in_the_seam_of_a_split_drum_clashes(
    gap: float, facets: tuple[int, int], rng: np.random.Generator
) -> None:
    drum = split_drum(max(gap, 1e-5), *facets)
    for inner in (0.0, 0.45):
        gasket = prism_ring(0.55, inner, 48, -gap / 6, gap / 6)
        assert said(drum, gasket, rng)[0] == {Verdict.CLASH}
    assert said(drum, prism_ring(0.47, 0.4, 48, -gap / 6, gap / 6), rng)[0] == {Verdict.CONTAINED}
