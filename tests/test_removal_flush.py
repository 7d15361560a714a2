"""Ways of parts that touch their neighbours without a gap, and of thin parts in thin walls: never through one."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, inverted, joined, mockup_of

import feeler

Floats = npt.NDArray[np.float64]
Cells = list[tuple[int, int, int]]

SIDE = 1 / 64
"""Of a cube, metres."""
RING: Cells = [(0, 0, 0), (0, 1, 0), (0, 2, 2), (0, 1, 2), (0, 0, 2), (0, 0, 1), (0, 2, 1)]
"""Two of its cubes meet at an edge alone."""
CORE: Cells = [(0, 1, 1)]
COVER: Cells = [(0, 0, 2), (0, 1, 2), (0, 2, 1), (0, 2, 2), (1, 0, 1), (1, 0, 2), (1, 1, 1), (1, 1, 2), (2, 0, 1)]
BASE: Cells = [
    *((0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (0, 2, 0), (1, 0, 0)),
    *((1, 1, 0), (1, 2, 0), (1, 2, 1), (1, 2, 2), (2, 0, 0), (3, 0, 0)),
]


def turned(seed: int) -> Floats:
    """A random rotation."""
    axes, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return np.asarray(axes * np.sign(np.linalg.det(axes)))


def blocks(cells: Cells, grown: float, turn: Floats) -> Mesh:
    """The surface of cubes of a grid, grown by so many metres each way: cells that touch are one solid."""
    coordinates = sorted({SIDE * (n + side) + sign * grown for n in range(5) for side in (0, 1) for sign in (-1, 1)})
    low = SIDE * np.array(cells) - grown
    high = SIDE * (np.array(cells) + 1) + grown
    middles = 0.5 * (np.array(coordinates[1:]) + np.array(coordinates[:-1]))
    grid = np.array(list(itertools.product(range(len(middles)), repeat=3)))
    at = middles[grid]
    is_in = ((at[:, None] > low) & (at[:, None] < high)).all(axis=2).any(axis=1)
    filled = set(map(tuple, grid[is_in].tolist()))
    corners: list[tuple[int, ...]] = []
    faces: list[tuple[int, int, int]] = []
    for cell in filled:
        for axis, side in itertools.product(range(3), (0, 1)):
            beside = list(cell)
            beside[axis] += 2 * side - 1
            if tuple(beside) in filled:
                continue
            a, b = [k for k in range(3) if k != axis][:: 1 if (axis == 1) != (side == 1) else -1]
            first = len(corners)
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = list(cell)
                corner[axis] += side
                corner[a] += u
                corner[b] += v
                corners.append(tuple(corner))
            faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    places, numbers = np.unique(np.array(corners), axis=0, return_inverse=True)
    return np.array(coordinates)[places] @ turn.T, numbers.reshape(-1)[np.array(faces)]


def deepest(one: Cells, other: Cells, ways: Floats, grown: float) -> float:
    """The least side of the largest box that a cube of one and a cube of the other have in common on ways (k, 3)."""
    a = SIDE * np.array(one)[None, :, None] + ways[:, None, None]
    b = SIDE * np.array(other)[None, None]
    sides = np.minimum(a, b) + SIDE + grown - np.maximum(a, b) + grown
    return float(sides.min(axis=3).max())


@pytest.mark.parametrize("grown", [0.0, 1e-6, 2e-5])
def test_a_way_of_flush_blocks_goes_into_no_neighbour(grown: float) -> None:
    # Pressed in, their depth is bounded in short steps, which takes longer.
    found, seeds = 0, 2 if grown else 5
    for (one, other), seed in itertools.product(((RING, CORE), (BASE, COVER)), range(seeds)):
        turn = turned(seed)
        parts = {"one": blocks(one, grown, turn), "other": blocks(other, grown, turn)}
        way = feeler.removal(feeler.Scene(mockup_of(parts), threads=1), "one", rounds=1, seconds=600.0, threads=1)
        found += way.is_found
        for leg, start in zip(way.legs, [np.eye(4), *(leg.pose for leg in way.legs)], strict=False):
            if leg.screw is not None or leg.rotation > 1e-9:
                break
            shares = np.linspace(0.0, 1.0, 201)[:, None]
            ways = (start[:3, 3] + shares * (leg.pose - start)[:3, 3]) @ turn
            assert deepest(one, other, ways, grown) < (2.2 * grown + 1.1e-5 if grown else 1.1e-6), (seed, str(leg))
    assert found == 2 * seeds


def boxed(part: Mesh) -> feeler.Scene:
    """A part in a closed box of 100 by 60 by 50 mm, with walls of 1 mm."""
    inner, outer = box((0, 0, 0), (0.1, 0.06, 0.05)), box((-0.001, -0.001, -0.001), (0.101, 0.061, 0.051))
    return feeler.Scene(mockup_of({"part": part, "box": joined(outer, inverted(inner))}), threads=1)


def wedge() -> Mesh:
    corners = [(0.01, y, 0.0) for y in (0.01, 0.05)] + [(0.09, y, z) for y in (0.01, 0.05) for z in (0.0, 2e-5)]
    faces = [(0, 1, 4), (0, 4, 2), (0, 3, 5), (0, 5, 1), (0, 2, 3), (1, 5, 4), (2, 4, 5), (2, 5, 3)]
    return np.array(corners), np.array(faces)


def sheet(z: float) -> Mesh:
    corners = [(0.02, 0.01, z), (0.07, 0.01, z), (0.07, 0.04, z), (0.02, 0.04, z)]
    return np.array(corners), np.array([(0, 1, 2), (0, 2, 3)])


THIN = {
    "pad": box((0.01, 0.01, 0.0), (0.09, 0.05, 2e-5)),
    "wedge": wedge(),
    "sheet on the floor": sheet(0.0),
    "sheet in the air": sheet(0.01),
}


@pytest.mark.parametrize("overlap", [1e-7, 1e-5])
@pytest.mark.parametrize("part", THIN.values(), ids=THIN)
def test_an_overlap_lets_nothing_thin_through_a_wall(part: Mesh, overlap: float) -> None:
    assert not feeler.removal(boxed(part), "part", overlap=overlap, rounds=2, seconds=1.0, threads=1).is_found


FIN: Cells = [(1, 1, 0), (2, 1, 0), (3, 1, 0), (4, 1, 0), (1, 1, 1), (1, 1, 2)]
"""A block with a fin, at its layer 1 of a grid, ..."""
FOIL: Cells = [(3, 0, 0), (3, 0, 1), (3, 0, 2), (3, 1, 2)]
"""... on the edge of a foil, at layer 3, which stands in the way of the fin."""


def fin_and_foil(thin: float, between: float, grown: float, turn: Floats) -> dict[str, Mesh]:
    widths = ((0.01, thin, between, thin, 0.02), (0.01, 0.02), (0.02, 0.002, 0.02))
    edges = [np.cumsum([0.0, *along]) for along in widths]

    def stretched(cells: Cells) -> Mesh:
        points, faces = blocks(cells, grown, np.eye(3))
        numbers = np.rint(points / SIDE).astype(int)
        places = [edges[axis][numbers[:, axis]] for axis in range(3)]
        return (np.column_stack(places) + points - SIDE * numbers) @ turn.T, faces

    return {"one": stretched(FIN), "other": stretched(FOIL)}


@pytest.mark.parametrize(("overlap", "grown"), [(0.0, 2e-5), (6e-5, 2e-5)])
def test_nothing_thin_goes_through_a_foil_between_two_looks(overlap: float, grown: float) -> None:
    """Narrow strips along the edges keep a smaller block from being made: pressed in, it is looked at, not cast."""
    for seed, between in enumerate((0.011, 0.0113, 0.0117)):
        turn = turned(seed)
        parts = fin_and_foil(2e-4, float(between), grown, turn)
        scene = feeler.Scene(mockup_of(parts), threads=1)
        way = feeler.removal(scene, "one", overlap=overlap, directions=[turn[:, 0]], rounds=1, seconds=600.0, threads=1)
        tool, others = feeler.Tool(*parts["one"]), scene.without("one")
        pose = np.eye(4)
        for leg in way.legs:
            assert leg.screw is None and leg.rotation < 1e-9, str(leg)
            for share in np.linspace(0.0, 1.0, 501):
                at = np.eye(4)
                at[:3, 3] = pose[:3, 3] + share * (leg.pose - pose)[:3, 3]
                # As deep as at the start, with the error of that, or as the overlap; and 10 um more between two looks.
                assert others.depth(tool, at).depths.max(initial=0.0) < 8.1e-5, (seed, str(leg))
            pose = leg.pose
        assert way.is_found


@pytest.mark.parametrize("is_rounded", [False, True])
def test_a_part_of_several_blocks_slides_between_flush_walls_in_any_pose(is_rounded: bool) -> None:
    """Blocks that share a whole side, as bodies of one part in CAD files do."""
    low, high = (-0.015, -0.015, 0.0), (0.015, 0.015, 0.015)
    middles = {"stacked": (*high[:2], 0.012), "in a row": (high[0], 0.0, high[2])}
    walls = {
        "left": box((-0.06, -0.04, 0.0), (-0.015, 0.04, 0.02)),
        "right": box((0.015, -0.04, 0.0), (0.06, 0.04, 0.02)),
    }
    for name, middle in middles.items():
        other = tuple(low[k] if middle[k] == high[k] else middle[k] for k in range(3))
        parts = {**walls, "block": joined(box(low, middle), box(other, high))}
        for seed in range(8):
            turn = turned(seed)
            corners = {key: (points @ turn.T, faces) for key, (points, faces) in parts.items()}
            if is_rounded:
                corners = {
                    key: (points.astype(np.float32).astype(float), faces) for key, (points, faces) in corners.items()
                }
            found = feeler.removal(feeler.Scene(mockup_of(corners)), "block", seconds=10.0)
            assert found.is_found, (name, seed)
