"""Which parts are closed in a clash check: seams, edges cut differently on both sides, torn and repeated triangles."""

from __future__ import annotations

import numpy as np
import pytest
from clash.judge.shapes import random_turn
from shapes import Mesh, box, cube, inverted, joined, mockup_of

import feeler
from feeler import Verdict

PLACES = [0.0, 1.0, 65e3]
"""How far off the parts are, metres. All but at the origin they are turned."""
UNIT = box((0, 0, 0), (1, 1, 1))
CROSSING = box((0.5, 0.25, 0.25), (2, 0.75, 0.75))
INSIDE = cube((0.5, 0.5, 0.5), 0.2)
FAN = 6


def row_of(one: Mesh, other: Mesh) -> feeler.Clash:
    (row,) = feeler.clash(mockup_of({"one": one, "other": other}))
    return row


def placed(mesh: Mesh, far: float) -> Mesh:
    turn = random_turn(np.random.default_rng(7)) if far else np.eye(3)
    return mesh[0] @ turn.T + far, mesh[1]


def unwelded(mesh: Mesh) -> Mesh:
    corners = mesh[0][mesh[1]].reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def worn(mesh: Mesh, by: float, count: int, rng: np.random.Generator) -> Mesh:
    """Unwelded; some of the corners are moved."""
    corners, faces = unwelded(mesh)
    some = rng.permutation(len(corners))[:count]
    corners[some] += rng.uniform(-by, by, (len(some), 3))
    return corners, faces


def recut(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Each face is a fan around its middle, with points on its edges that its neighbours do not have."""
    corners, faces = [], []
    for a, b, c in mesh[0][mesh[1]]:
        rim = []
        for start, end in ((a, b), (b, c), (c, a)):
            shares = np.sort(np.concatenate([[0.0], rng.uniform(0.05, 0.95, rng.integers(1, FAN))]))
            rim.append(start + shares[:, None] * (end - start))
        around = np.concatenate(rim)
        first, n = len(np.concatenate(corners)) if corners else 0, len(around)
        corners.append(np.concatenate([around, [(a + b + c) / 3]]))
        faces += [[first + i, first + (i + 1) % n, first + n] for i in range(n)]
    return np.concatenate(corners), np.array(faces)


def without(mesh: Mesh, face: int) -> Mesh:
    return mesh[0], np.delete(mesh[1], face, axis=0)


def repeated(mesh: Mesh, faces: slice) -> Mesh:
    """Some triangles twice, from another corner on."""
    return mesh[0], np.concatenate([mesh[1], np.roll(mesh[1][faces], 1, axis=1)])


def assert_closed(mesh: Mesh, within: float, far: float = 0.0) -> None:
    """It is a unit cube in all but its triangles."""
    for other, depth, verdict in ((CROSSING, 0.5, Verdict.CLASH), (INSIDE, 0.4, Verdict.CONTAINED)):
        row = row_of(placed(mesh, far), placed(other, far))
        assert (row.verdict, row.is_open_a, row.is_open_b, row.depth_kind) == (verdict, False, False, "measured")
        assert row.depth == pytest.approx(depth, abs=1e-3 * depth + within)


@pytest.mark.parametrize("far", PLACES)
@pytest.mark.parametrize("by", [1e-16, 1e-9, 5e-7])
def test_seams_within_two_millionths_are_closed(by: float, far: float, rng: np.random.Generator) -> None:
    for count in (1, 3, 6, 12, 24, 36):
        assert_closed(worn(UNIT, by, count, rng), 2 * by, far)


@pytest.mark.parametrize("far", PLACES)
def test_seams_of_slivers_are_closed(far: float, rng: np.random.Generator) -> None:
    # A face in slivers from one corner to points of the opposite edges that are a nanometre apart.
    corners, faces = UNIT
    ends = corners[3] + np.array([[0.0], [1e-9], [2e-9]]) * (corners[1] - corners[3])
    vertices = np.concatenate([corners, ends[1:]])
    slivers = np.array([[0, 1, 9], [0, 9, 8], [0, 8, 3]])
    cut = vertices, np.concatenate([faces[1:], slivers])
    cut = cut[0], cut[1][[set(face.tolist()) != {0, 1, 3} for face in cut[1]]]
    for count in (0, 9, 3 * len(cut[1])):
        assert_closed(worn(cut, 1e-10, count, rng), 1e-9, far)


@pytest.mark.parametrize("far", PLACES)
def test_edges_cut_differently_on_both_sides_are_closed(far: float, rng: np.random.Generator) -> None:
    for _ in range(5):
        assert_closed(recut(UNIT, rng), 1e-9, far)
    corners = np.array([[-48, -96, -64], [80, -64, -32], [32, 0, 0], [48, -16, 32]]) / 64
    tetrahedron = corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    pin = cube(corners.mean(axis=0), 0.05)
    expected = row_of(placed(tetrahedron, far), placed(pin, far))
    for _ in range(5):
        row = row_of(placed(recut(tetrahedron, rng), far), placed(pin, far))
        assert (row.verdict, row.is_open_a) == (expected.verdict, False)
        assert row.depth == pytest.approx(expected.depth, rel=2e-3)


@pytest.mark.parametrize("far", PLACES)
def test_holes_and_sheets_stay_open(far: float, rng: np.random.Generator) -> None:
    for mesh in (UNIT, recut(UNIT, rng)):
        for face in rng.permutation(len(mesh[1]))[:4]:
            torn = worn(without(mesh, face), 1e-9, 20, rng)
            assert row_of(placed(torn, far), placed(CROSSING, far)).is_open_a
    sheet = np.array([[0.0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]]), np.array([[0, 1, 2], [0, 2, 3]])
    for mesh in (sheet, joined(sheet, inverted(sheet)), recut(sheet, rng), joined(unwelded(sheet), inverted(sheet))):
        assert row_of(placed(mesh, far), placed(CROSSING, far)).is_open_a


@pytest.mark.parametrize("far", PLACES)
def test_a_partition_is_no_part_of_a_solid(far: float, rng: np.random.Generator) -> None:
    # A wall in the middle of a box: its border runs along edges, one of whose sides it would be.
    low, high = box((0, 0, 0), (1, 1, 0.5)), box((0, 0, 0.5), (1, 1, 1))
    is_top = (low[0][low[1]][:, :, 2] == 0.5).all(axis=1)
    is_bottom = (high[0][high[1]][:, :, 2] == 0.5).all(axis=1)
    halves = joined((low[0], low[1][~is_top]), (high[0], high[1][~is_bottom]))
    assert_closed(halves, 1e-9, far)
    wall = low[0], low[1][is_top]
    for mesh in (joined(halves, wall), recut(joined(halves, wall), rng)):
        assert row_of(placed(mesh, far), placed(CROSSING, far)).is_open_a


@pytest.mark.parametrize("far", PLACES)
@pytest.mark.parametrize("apart", [1e-4, 1e-5])
def test_near_surfaces_stay_apart(apart: float, far: float, rng: np.random.Generator) -> None:
    by = 1e-9 if apart > 1e-5 else 1e-10
    plate = box((0, 0, 0), (1, 1, apart))
    for mesh in (worn(plate, by, 36, rng), recut(plate, rng)):
        row = row_of(placed(mesh, far), placed(box((0.25, 0.25, -1), (0.75, 0.75, apart / 4)), far))
        assert not row.is_open_a and row.depth == pytest.approx(apart / 4, rel=2e-3, abs=4 * by + far * 1e-15)
    # A hollow almost as large as its solid: what is in the hollow is in nothing.
    shells = joined(UNIT, inverted(box((apart,) * 3, (1 - apart,) * 3)))
    for mesh in (worn(shells, by, 72, rng), recut(shells, rng)):
        assert len(feeler.clash(mockup_of({"a": placed(mesh, far), "b": placed(INSIDE, far)}))) == 0
        row = row_of(placed(mesh, far), placed(CROSSING, far))
        assert not row.is_open_a and row.depth == pytest.approx(0.25, rel=2e-3)


@pytest.mark.parametrize("torn", [True, False])
def test_a_torn_shell_opens_its_part_and_leaves_the_others_their_inside(torn: bool) -> None:
    beside = box((5, 0, 0), (5.5, 0.5, 0.5))
    part = joined(UNIT, without(beside, 3) if torn else beside)
    kind = "estimate" if torn else "measured"
    for other, depth, verdict in ((CROSSING, 0.5, Verdict.CLASH), (INSIDE, 0.4, Verdict.CONTAINED)):
        row = row_of(part, other)
        assert (row.verdict, row.is_open_a, row.depth_kind) == (verdict, torn, kind)
        assert row.depth == pytest.approx(depth, rel=1e-3)
        of_tool = feeler.Scene(mockup_of({"part": part})).depth(feeler.Tool(*other), np.eye(4))
        assert of_tool.is_estimate.tolist() == [torn] and of_tool.depths[0] == pytest.approx(depth, rel=1e-3)
    # What is in the torn shell is in nothing.
    found = feeler.clash(mockup_of({"part": part, "other": cube((5.25, 0.25, 0.25), 0.1)}))
    assert len(found) == (0 if torn else 1)


@pytest.mark.parametrize("far", PLACES)
@pytest.mark.parametrize("faces", [slice(3, 4), slice(2, 7), slice(0, 12)])
def test_triangles_listed_twice_open_nothing(faces: slice, far: float, rng: np.random.Generator) -> None:
    twice = repeated(UNIT, faces)
    thrice = repeated(twice, faces)
    for mesh in (twice, thrice, joined(twice, box((5, 0, 0), (6, 1, 1))), joined(box((5, 0, 0), (6, 1, 1)), twice)):
        assert_closed(mesh, 1e-9, far)
    cut = recut(UNIT, rng)
    for mesh in (repeated(cut, faces), repeated(worn(UNIT, 1e-9, 20, rng), faces)):
        assert_closed(mesh, 1e-9, far)
    # Beside it what is outside stays so.
    beside = cube((-0.5, 0.6, 0.3), 0.2)
    assert len(feeler.clash(mockup_of({"a": placed(twice, far), "b": placed(beside, far)}))) == 0
    scene = feeler.Scene(mockup_of({"part": placed(twice, far)}))
    tool = feeler.Tool(*placed(beside, far))
    assert scene.containment(tool, np.eye(4)).containing.tolist() == []
    assert scene.containment(tool, np.eye(4)).unknown.tolist() == []
    # A hole beside it is one.
    torn = placed(without(twice, 0 if faces.start else 11), far)
    assert faces.stop == 12 or row_of(torn, placed(CROSSING, far)).is_open_a


def test_a_triangle_and_its_reverse_enclose_nothing() -> None:
    back = UNIT[0], np.concatenate([UNIT[1], UNIT[1][3:4, ::-1]])
    assert row_of(back, CROSSING).is_open_a
    # Two solids that share a face bound one together.
    halves = joined(box((0, 0, 0), (0.5, 1, 1)), box((0.5, 0, 0), (1, 1, 1)))
    row = row_of(halves, INSIDE)
    assert not row.is_open_a


def test_depths_do_not_depend_on_how_loose_the_seams_are() -> None:
    """A corner of a cut polygon may lie in the gap of a seam, on the wrong side of the surface."""
    ends = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    rng = np.random.default_rng(0)
    deep = 0
    for n in range(150):
        moved = ends[faces].reshape(-1, 3) + rng.uniform(-1, 1, (24, 3)) * (loose := 10.0 ** -rng.integers(9, 14))
        half = 10.0 ** rng.uniform(-1.5, -0.3, 3)
        corners, sides = box(-half, half)
        turn, way = random_turn(rng), rng.normal(size=3) * rng.choice([0.0, 1e-3, 1.0], 3)
        block = (corners @ turn.T + way / max(np.abs(way).sum(), 1e-6) * rng.uniform(0.6, 1.0), sides)
        tight, slack = (
            feeler.clash(mockup_of({"solid": solid, "block": block}))
            for solid in ((ends, faces), (moved, np.arange(24).reshape(-1, 3)))
        )
        if tight and slack and tight[0].verdict == Verdict.CLASH and tight[0].depth > 1e-6:
            deep += 1
            error = max(tight[0].depth_error, slack[0].depth_error) + 4 * loose
            assert slack[0].depth == pytest.approx(tight[0].depth, abs=error), (n, tight[0], slack[0])
    assert deep > 60
