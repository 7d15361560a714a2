"""Every pair, and every kind, is what exact rational arithmetic says: on meshes that hypothesis makes hard."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import judge
import numpy as np
import numpy.typing as npt
import oracle
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import feeler

STORES: list[dict[str, Any]] = [
    {"storage": "blocks"},
    {"storage": "dense"},
    {"storage": "hashed", "hashing": 0.0},
    {"storage": "hashed", "hashing": 0.8},
]

Corners = list[list[float]]


def as_dict(hit: Any) -> oracle.Found:
    return {(int(t), int(s)): int(k) for (t, s), k in zip(hit.pairs, hit.kind_codes, strict=True)}


def mesh(triangles: list[Corners], shared: bool = False) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    vertices = np.array(triangles, dtype=np.float64).reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    if shared:
        vertices, index = np.unique(vertices, axis=0, return_inverse=True)
        faces = index.reshape(-1, 3)
    return vertices, faces


def check(
    mockup_triangles: list[Corners],
    tool_triangles: list[Corners],
    pose: npt.NDArray[np.float64] | None = None,
    sizes: tuple[float | None, ...] = (None,),
) -> oracle.Found:
    """All stores against the oracle; the answer. Skips what has nothing to query."""
    pose = np.eye(4) if pose is None else pose
    try:
        mockup = feeler.Mockup(*mesh(mockup_triangles, shared=True))
        tool = feeler.Tool(*mesh(tool_triangles))
    except feeler.MeshError:
        assume(False)
    expected = oracle.collide(mockup, tool, pose)
    for store, size in itertools.product(STORES, sizes):
        scene = feeler.Scene(mockup, voxel_size=size, **store)
        scene.validate()
        hit = scene.collide(tool, pose)
        assert as_dict(hit) == expected, (store, size)
        assert scene.is_colliding(tool, pose) == bool(expected), (store, size)
        batch = scene.collide_batch(tool, np.stack([pose, pose]))
        assert batch.pairs.tolist() == 2 * hit.pairs.tolist()
        assert batch.kind_codes.tolist() == 2 * hit.kind_codes.tolist()
    return expected


def triangles(coordinate: st.SearchStrategy[float], most: int) -> st.SearchStrategy[list[Corners]]:
    point = st.lists(coordinate, min_size=3, max_size=3)
    return st.lists(st.lists(point, min_size=3, max_size=3), min_size=1, max_size=most)


def ulps(x: float, n: int) -> float:
    """`x` moved by `n` steps of float64."""
    for _ in range(abs(n)):
        x = float(np.nextafter(x, np.inf if n > 0 else -np.inf))
    return x


whole = st.integers(0, 3).map(float)
nearly_whole = st.builds(ulps, whole, st.integers(-2, 2))
tenths = st.integers(-3, 3).map(lambda i: i * 0.1)
any_size = st.one_of(
    whole,
    tenths,
    st.integers(-2, 2).map(lambda i: i * 5e-324),
    st.integers(-2, 2).map(lambda i: i * 1e-160),
    st.integers(-2, 2).map(lambda i: i * 1e-30),
    st.integers(-2, 2).map(lambda i: i * 1e30),
    st.integers(-2, 2).map(lambda i: i * 4e99),
)

# Rotations whose numbers are exact (right angles), and not.
_c, _s = np.cos(0.3), np.sin(0.3)
ROTATIONS = [
    np.eye(3),
    np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    np.array([[_c, -_s, 0.0], [_s, _c, 0.0], [0.0, 0.0, 1.0]]),
    np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]),
]


def placed(rotation: int, translation: list[float]) -> npt.NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, :3] = ROTATIONS[rotation]
    pose[:3, 3] = translation
    return pose


shifts = st.lists(st.sampled_from([0.0, 1.0, -1.0, 0.1, 1e-16, 5e-324, 0.5]), min_size=3, max_size=3)


@given(triangles(whole, 12), triangles(whole, 8), st.integers(0, 3), shifts)
def test_lattice(mockup: list[Corners], tool: list[Corners], rotation: int, shift: list[float]) -> None:
    check(mockup, tool, placed(rotation, shift), (None, 0.7, 50.0))


@given(triangles(nearly_whole, 10), triangles(nearly_whole, 6), shifts)
def test_off_the_lattice_by_ulps(mockup: list[Corners], tool: list[Corners], shift: list[float]) -> None:
    check(mockup, tool, placed(0, shift), (None, 1.0))


@given(triangles(st.one_of(tenths, nearly_whole), 8), triangles(st.one_of(tenths, whole), 8), st.integers(0, 3), shifts)
def test_numbers_that_round(mockup: list[Corners], tool: list[Corners], rotation: int, shift: list[float]) -> None:
    check(mockup, tool, placed(rotation, shift), (None, 0.25))


@given(triangles(any_size, 5), triangles(any_size, 5))
def test_all_magnitudes_at_once(mockup: list[Corners], tool: list[Corners]) -> None:
    check(mockup, tool)


@given(
    triangles(whole, 8),
    triangles(whole, 8),
    st.sampled_from([5e-324, 1e-310, 1e-200, 1e-100, 1e-9, 1e9, 1e60, 1e90, 1e99]),
)
def test_one_magnitude_at_a_time(mockup: list[Corners], tool: list[Corners], scale: float) -> None:
    def scaled(t: list[Corners]) -> list[Corners]:
        return (np.array(t) * scale).tolist()

    check(scaled(mockup), scaled(tool))


@given(triangles(whole, 8), triangles(whole, 8), st.sampled_from([1e6, -1e9, 1e15, 1e16]), st.integers(0, 2))
def test_far_from_the_origin(mockup: list[Corners], tool: list[Corners], offset: float, rotation: int) -> None:
    # The pose takes the tool to where the mock-up is; at 1e16 m the numbers are coarser than the lattice.
    check((np.array(mockup) * 0.3 + offset).tolist(), (np.array(tool) * 0.3).tolist(), placed(rotation, [offset] * 3))


@given(
    triangles(whole, 6),
    triangles(whole, 6),
    st.sampled_from([1e-3, 1e-9, 1e-16, 1e-30, 5e-324]),
    st.integers(0, 2),
    st.integers(0, 3),
)
def test_slivers(mockup: list[Corners], tool: list[Corners], width: float, axis: int, rotation: int) -> None:
    flat = np.ones(3)
    flat[axis] = width
    check((np.array(mockup) * flat).tolist(), (np.array(tool) * flat).tolist(), placed(rotation, [0.0, 0.0, 0.0]))


@given(triangles(whole, 8), st.permutations([0, 1, 2]), st.integers(0, 2), st.sampled_from([0.0, 1e-16, 1e-300]))
def test_the_mock_up_as_its_own_tool(mockup: list[Corners], order: list[int], axis: int, shift: float) -> None:
    tool = np.array(mockup)[:, order]
    translation = [0.0, 0.0, 0.0]
    translation[axis] = shift
    check(mockup, tool.tolist(), placed(0, translation))


@given(triangles(whole, 4), st.sampled_from([1e-17, 1e-20, 1e-200, 5e-324]), st.integers(0, 3), shifts)
def test_tool_triangles_that_round_to_less_than_a_triangle(
    tool: list[Corners], scale: float, axis: int, shift: list[float]
) -> None:
    # Squeezed along one axis (or all) below the grain of the numbers at the pose: segments, points.
    squeeze = np.full(3, scale)
    if axis < 3:
        squeeze[:] = 1.0
        squeeze[axis] = scale
    base = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]], [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [1.0, 1.0, 4.0]]]
    base += [[[1.0, 1.0, 1.0], [1.0, 3.0, 1.0], [1.0, 1.0, 3.0]]]
    check(base, (np.array(tool) * squeeze).tolist(), placed(0, (np.array(shift) + 1.0).tolist()))


BASE = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]
CASES: list[tuple[str, Corners, int | None]] = [
    ("pierces the face", [[1, 1, -1], [1, 1, 1], [2, 1, 1]], oracle.CROSSING),
    ("cuts right across", [[-9, 1, -1], [9, 1, -1], [0, 1, 9]], oracle.CROSSING),
    ("cut off at a corner", [[-1, 1, -1], [-1, 1, 1], [1, 1, 0.5]], oracle.CROSSING),
    ("vertex on face", [[1, 1, 0], [1, 1, 1], [2, 1, 1]], oracle.TOUCHING),
    ("vertex on edge", [[1, 0, 0], [1, -1, 1], [1, -1, -1]], oracle.TOUCHING),
    ("vertex on vertex", [[0, 0, 0], [-1, 0, 1], [-1, 0, -1]], oracle.TOUCHING),
    ("edge on face", [[1, 1, 0], [2, 1, 0], [2, 1, 1]], oracle.TOUCHING),
    ("edge on edge", [[1, 0, 0], [2, 0, 0], [2, -1, 1]], oracle.TOUCHING),
    ("edge across edge", [[4, 0, -1], [4, 0, 1], [9, 0, 0]], oracle.TOUCHING),
    ("shared edge, folded", [[0, 0, 0], [4, 0, 0], [0, 0, 1]], oracle.TOUCHING),
    ("edge through the plane, past the face", [[5, 0, -1], [5, 0, 1], [6, 1, 0]], None),
    ("edge through a vertex", [[0, 0, -1], [0, 0, 1], [-3, 1, 1]], oracle.TOUCHING),
    ("planes cross in the face's edge", [[1, 0, -1], [3, 0, -1], [2, 0, 1]], oracle.TOUCHING),
    ("vertices on both sides, but one point is shared", [[4, 0, -1], [4, 0, 2], [8, 1, 1]], oracle.TOUCHING),
    ("in one plane, overlapping", [[1, 1, 0], [9, 1, 0], [1, 9, 0]], oracle.COPLANAR),
    ("in one plane, inside", [[1, 1, 0], [1.5, 1, 0], [1, 1.5, 0]], oracle.COPLANAR),
    ("in one plane, the same", BASE, oracle.COPLANAR),
    ("in one plane, shared edge", [[4, 0, 0], [0, 4, 0], [4, 4, 0]], oracle.COPLANAR),
    ("in one plane, shared vertex", [[4, 0, 0], [5, 0, 0], [5, 1, 0]], oracle.COPLANAR),
    ("in one plane, beside", [[5, 0, 0], [6, 0, 0], [5, 1, 0]], None),
    ("parallel", [[0, 0, 1], [4, 0, 1], [0, 4, 1]], None),
    ("parallel, a denormal apart", [[0, 0, 5e-324], [4, 0, 5e-324], [0, 4, 5e-324]], None),
    ("a denormal above", [[1, 1, 5e-324], [1, 1, 1], [2, 1, 1]], None),
    ("a denormal below", [[1, 1, -5e-324], [1, 1, 1], [2, 1, 1]], oracle.CROSSING),
]


@pytest.mark.parametrize(("triangle", "expected"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_named_cases_in_all_72_orders(triangle: Corners, expected: int | None) -> None:
    assert oracle.kind_of_pair(triangle, BASE) == oracle.kind_of_pair(BASE, triangle) == expected
    orders = [list(order) for order in itertools.permutations(range(3))]
    want = set() if expected is None else {expected}
    for first, second in ((triangle, BASE), (BASE, triangle)):
        # All six orders of the one are triangles of a mock-up, all six of the other of a tool.
        mockup = [[first[i] for i in order] for order in orders]
        tool = [[second[i] for i in order] for order in orders]
        found = check(mockup, tool)
        assert set(found.values()) == want
        assert len(found) == (36 if want else 0)


def test_the_oracle_knows_the_corpus(testdata: Path) -> None:
    """Another oracle wrote the answers: the one in Rust, in rationals."""
    words = {"apart": None, "coplanar": oracle.COPLANAR, "crossing": oracle.CROSSING, "touching": oracle.TOUCHING}
    lines = [line for line in (testdata / "triangle_pairs.txt").read_text(encoding="utf-8").splitlines() if line]
    cases = [[field.strip() for field in line.split("|")] for line in lines if not line.startswith("#")]
    assert len(cases) > 900 and {answer for *_, answer in cases} == set(words)
    wrong = []
    for name, first, second, answer in cases:
        p, q = (np.array(numbers.split(), dtype=np.float64).reshape(3, 3) for numbers in (first, second))
        for turn in range(3):
            if oracle.kind_of_pair(np.roll(p, turn, axis=0), q[::-1]) != words[answer]:
                wrong.append(name)
    assert not wrong


def test_the_oracle_names_a_shared_point_in_one_way() -> None:
    p, q = judge.whole([[1, 1, -1], [1, 1, 1], [3, 1, 1]], BASE)
    assert judge.shared_points(p, q) == {(1, 1, 0, 1), (2, 1, 0, 1)}


def test_the_oracle_refuses_a_mock_up_triangle_without_area() -> None:
    with pytest.raises(ValueError, match="no area"):
        oracle.kind_of_pair(BASE, [[0, 0, 0], [1, 1, 1], [2, 2, 2]])


def test_the_pose_is_applied_without_fused_multiply_add(make_pose: Callable[..., npt.NDArray[np.float64]]) -> None:
    # A point of the tool on the plane z = h, where h is what the contract's formula gives and a fused one would not.
    rng = np.random.default_rng(5)
    fused_differs = 0
    for _ in range(60):
        pose = make_pose(rng.normal(size=3), rng.normal(size=3), rng.uniform(5, 175))
        tip = rng.normal(size=3)
        x, y, z = oracle.at_pose(tip, pose)
        tool = [[tip.tolist(), (tip + np.array([0.5, 0.0, 0.1])).tolist(), (tip + np.array([0.0, 0.5, 0.1])).tolist()]]
        mockup = [[[x - 1.0, y - 1.0, z], [x + 2.0, y - 1.0, z], [x - 1.0, y + 2.0, z]]]
        found = check(mockup, tool, pose)
        assert found, "the tip lies in the plane"
        r = [Fraction(v) for v in pose[2].tolist()]
        t = [Fraction(v) for v in tip.tolist()]
        fused = float(Fraction(float(Fraction(float(r[0] * t[0])) + r[1] * t[1])) + r[2] * t[2]) + pose[2, 3]
        fused_differs += fused != z
    assert fused_differs > 5


@given(st.data())
@settings(max_examples=30)
def test_the_float_brute_force_agrees_with_the_exact_oracle(data: st.DataObject) -> None:
    coordinate = data.draw(st.sampled_from([whole, tenths, st.floats(-1, 1, width=32).map(float)]))
    mockup = mesh(data.draw(triangles(coordinate, 10)))
    tool = mesh(data.draw(triangles(coordinate, 6)))
    pose = placed(data.draw(st.integers(0, 3)), data.draw(shifts))
    found, _ = oracle.collide_floats(mockup, tool, pose)
    assert found == oracle.collide(mockup, tool, pose)


def test_random_meshes_of_a_few_hundred_triangles(make_pose: Callable[..., npt.NDArray[np.float64]]) -> None:
    rng = np.random.default_rng(1)
    centres = rng.uniform(0, 1, size=(300, 1, 3))
    mockup = feeler.Mockup(*mesh((centres + rng.normal(scale=0.1, size=(300, 3, 3))).tolist()))
    tool = feeler.Tool(*mesh(rng.normal(scale=0.2, size=(80, 3, 3)).tolist()))
    scenes = [feeler.Scene(mockup, voxel_size=size, **store) for store in STORES for size in (None, 0.03)]
    for i in range(8):
        pose = make_pose(rng.uniform(0, 1, size=3), rng.normal(size=3), rng.uniform(0, 180))
        expected = oracle.collide(mockup, tool, pose)
        by_floats, doubts = oracle.collide_floats(mockup, tool, pose)
        assert by_floats == expected
        assert doubts < 50
        assert len(expected) > 50, i
        for scene in scenes:
            assert as_dict(scene.collide(tool, pose)) == expected
