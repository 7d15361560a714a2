"""Parts of a scene, out and in: chosen by path, name, pattern, number or mask, and answered as if the rest were all."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import oracle
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import at, box, cube, inverted, joined, mockup_of, tool_of

import feeler
from feeler.parts import Parts

PATHS = [
    "engine/pump/housing",
    "engine/pump/[1] lid",
    "engine/pump",
    "engine/gasket",
    "frame",
    "frame_2",
    "Frame",
    "é/x",
]
STORES: list[dict[str, Any]] = [
    {"storage": "blocks"},
    {"storage": "blocks", "voxel_size": 0.2},
    {"storage": "dense", "voxel_size": 0.3},
    {"storage": "hashed", "voxel_size": 0.3, "hashing": 0.7},
]


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    """A row of cubes of 1 m, each 0.1 m into the next; the frame has a hollow in which the seventh part is."""
    shapes = {path: cube((0.9 * i, 0, 0), 1.0) for i, path in enumerate(PATHS)}
    shapes["frame"] = joined(cube((10, 0, 0), 4), inverted(cube((10, 0, 0), 3)))
    shapes["Frame"] = cube((10, 0, 0), 1)
    return mockup_of(shapes)


@pytest.fixture(scope="module", params=STORES, ids=["blocks", "pieces", "dense", "hashed"])
def scene(request: pytest.FixtureRequest, mockup: feeler.Mockup) -> feeler.Scene:
    return feeler.Scene(mockup, threads=2, **request.param)


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    """Two bodies, one of them a flat bar."""
    return tool_of({"grip": cube((0, 0, 0), 0.4), "arm/bar": box((0.2, -0.05, -0.05), (1.1, 0.05, 0.05))})


# --- what a caller names ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        (0, [0]),
        (np.int64(7), [7]),
        ([2, 0, 2], [0, 2]),
        (range(3), [0, 1, 2]),
        (np.array([5, 1], dtype=np.uint8), [1, 5]),
        ("engine/pump", [0, 1, 2]),
        ("engine/pump/", [0, 1]),
        ("engine", [0, 1, 2, 3]),
        ("pump", [2]),
        ("housing", [0]),
        ("frame", [4]),
        ("[1] lid", [1]),
        ("engine/pump/[1] lid", [1]),
        ("frame*", [4, 5]),
        ("?rame", [4, 6]),
        ("[Ff]rame", [4, 6]),
        ("frame[!_]*", None),
        ("*pump*", [0, 1, 2]),
        ("*/housing", [0]),
        ("gask?t", [3]),
        ("engine/*", [0, 1, 2, 3]),
        ("*", [0, 1, 2, 3, 4, 5, 6, 7]),
        ("é/x", [7]),
        (["gasket", 4, "*lid"], [1, 3, 4]),
        (("gasket", "gasket"), [3]),
        ({"gasket"}, [3]),
        ((name for name in ["x"]), [7]),
        ([], []),
        (np.array([], dtype=np.int64), []),
        ([True] + [False] * 7, [0]),
        ([True] * 3, None),
        (np.array([True] + [False] * 6 + [True]), [0, 7]),
        (np.array([True]), None),
        (8, None),
        (-1, None),
        (1.0, None),
        (True, None),
        (None, None),
        (b"frame", None),
        (b"\x00", None),
        ("FRAME", None),
        ("pump/housing", None),
        ("", None),
        (["frame", None], None),
        (["frame", "nothing*"], None),
        (np.zeros((2, 2), dtype=int), None),
    ],
    ids=repr,
)
def test_select(mockup: feeler.Mockup, parts: Any, expected: list[int] | None) -> None:
    if expected is None:
        with pytest.raises(feeler.OptionError):
            mockup.parts.select(parts)
    else:
        found = mockup.parts.select(parts)
        assert (found.tolist(), found.dtype) == (expected, np.uint32)


# Beside what lies below a path, what only begins alike: "." comes before "/", "0" right after it.
NAME = st.sampled_from(["", "/", "a", "a/", "a//", "a.", "a0", "a/b", "a/0", "a/b/c", "ab", "/a", "b", "a.b"])
NAMES = st.lists(NAME, min_size=1, max_size=9)


@given(paths=NAMES, asked=NAME, data=st.data())
def test_what_is_called_so_or_lies_below(paths: list[str], asked: str, data: st.DataObject) -> None:
    names = data.draw(st.lists(NAME, min_size=len(paths), max_size=len(paths)))
    parts = Parts(names, paths, np.zeros(len(paths), np.uint32), np.zeros((len(paths), 2, 3)))
    below = asked.rstrip("/") + "/"
    expected = [
        i
        for i, (name, path) in enumerate(zip(names, paths, strict=True))
        if asked in (name, path) or path.startswith(below)
    ]
    for there in (parts, pickle.loads(pickle.dumps(parts))):
        assert [part.index for part in there.find(asked)] == expected


def test_select_takes_parts_of_this_mesh_only(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    parts = mockup.parts
    assert parts.select(parts[3]).tolist() == [3]
    assert parts.select([pickle.loads(pickle.dumps(parts[3])), parts[1]]).tolist() == [1, 3]
    # Numbers of another mesh's parts mean nothing here.
    for stranger in (tool.parts[0], feeler.Tool.of_parts(mockup, "gasket").parts[0]):
        with pytest.raises(feeler.OptionError, match="of another mesh"):
            parts.select(stranger)
    with pytest.raises(feeler.OptionError, match="part 3, 'engine/gasket', is of another mesh"):
        tool.parts.select([parts[3]])


def test_the_error_names_what_is_spelt_alike(mockup: feeler.Mockup) -> None:
    with pytest.raises(feeler.OptionError, match="'gaskets'; do you mean 'gasket'"):
        mockup.parts.select("gaskets")
    with pytest.raises(feeler.OptionError, match=r"'\*zzz\*'$"):
        mockup.parts.select("*zzz*")
    with pytest.raises(feeler.OptionError, match="there are 8, 0 to 7"):
        mockup.parts.select(8)


def test_a_name_with_signs_of_patterns_is_a_name_first() -> None:
    odd = mockup_of(
        {"[ab]": cube((0, 0, 0), 1), "a": cube((2, 0, 0), 1), "a*": cube((4, 0, 0), 1), "ab": cube((6, 0, 0), 1)}
    )
    assert [odd.parts.select(name).tolist() for name in ("[ab]", "a*", "?", "[ab]?")] == [[0], [2], [1], [2, 3]]


# --- what is left is all ---------------------------------------------------------------------------------------------


def built_without(mockup: feeler.Mockup, gone: list[int]) -> tuple[feeler.Mockup | None, np.ndarray]:
    """A mock-up made without some parts, and what its triangles are in the whole; None if nothing is left."""
    keep = ~np.isin(mockup.part_of_face, gone)
    if not keep.any():
        return None, np.flatnonzero(keep)
    parts, names = mockup.part_of_face[keep], mockup.part_names
    rest = feeler.Mockup(mockup.vertices, mockup.faces[keep], parts, names, part_paths=mockup.part_paths)
    return rest, np.flatnonzero(keep)


def same_distance(ours: feeler.Distance, other: feeler.Distance, number: np.ndarray) -> None:
    assert ours.value == other.value
    if ours.value > 0 and math.isfinite(ours.value):
        # Of several that meet, any may be the closest.
        assert ours.mockup_triangle == number[other.mockup_triangle]
        assert (ours.part, ours.tool_part, ours.tool_triangle) == (other.part, other.tool_part, other.tool_triangle)
        np.testing.assert_array_equal(ours.point_on_mockup, other.point_on_mockup)


def rows_of(near: feeler.Clearance) -> list[tuple[float, int]]:
    """Distance and part of each row; which of those that meet comes first depends on the pair that was found."""
    return sorted(zip(near.distances.tolist(), near.parts.tolist(), strict=True))


def same_contacts(ours: feeler.Contacts, other: feeler.Contacts) -> None:
    assert len(ours) == len(other)
    np.testing.assert_allclose(ours.gaps, other.gaps, atol=1e-12)
    assert sorted(ours.parts.tolist()) == sorted(other.parts.tolist())
    assert sorted(ours.tool_parts.tolist()) == sorted(other.tool_parts.tolist())
    assert ours.is_meeting == other.is_meeting


POSES = st.builds(
    at,
    st.sampled_from([0.0, 0.3, 0.5, 1.75, 2.7, 3.15, 6.1, 8.2, 10.0, 10.4]) | st.floats(-1, 12),
    st.sampled_from([0.0, 0.5, 0.7]) | st.floats(-0.8, 0.8),
    st.sampled_from([0.0, 0.25, 0.7]) | st.floats(-0.8, 0.8),
    st.sampled_from([0.0, 90.0, 180.0]) | st.floats(0, 360),
    st.integers(0, 2),
)


@given(gone=st.sets(st.integers(0, 7)), poses=st.tuples(POSES, POSES))
def test_a_scene_without_parts_answers_as_one_built_without_them(
    scene: feeler.Scene, mockup: feeler.Mockup, tool: feeler.Tool, gone: set[int], poses: tuple[np.ndarray, np.ndarray]
) -> None:
    left = scene.without(sorted(gone))
    left.validate()
    assert left.mockup is mockup
    assert left.part_mask.tolist() == [i not in gone for i in range(8)]
    rest, number = built_without(mockup, sorted(gone))
    if rest is None:
        assert not left.collide(tool, poses[0]) and math.isinf(left.distance(tool, poses[0]).value)
        return
    other = feeler.Scene(rest, storage=scene.storage, voxel_size=scene.voxel_size, hashing=scene.hashing, threads=2)
    pose = poses[0]

    hit, expected = left.collide(tool, pose), other.collide(tool, pose)
    pairs = np.column_stack([expected.pairs[:, 0], number[expected.pairs[:, 1]]])
    assert (hit.pairs.tolist(), hit.kind_codes.tolist()) == (pairs.tolist(), expected.kind_codes.tolist())
    assert (hit.parts.tolist(), hit.tool_parts.tolist()) == (expected.parts.tolist(), expected.tool_parts.tolist())
    assert left.is_colliding(tool, pose) == bool(expected)
    assert left.is_colliding(tool, pose, touching="free") == other.is_colliding(tool, pose, touching="free")
    assert left.is_free(tool, pose) == other.is_free(tool, pose)
    ours, others = left.containment(tool, pose), other.containment(tool, pose)
    for name in ("containing_pairs", "contained_pairs", "unknown"):
        assert getattr(ours, name).tolist() == getattr(others, name).tolist(), name

    for triangles in (False, True):
        near, expected_near = (each.clearance(tool, pose, 0.3, triangles) for each in (left, other))
        assert near.distances.tolist() == expected_near.distances.tolist()
        assert rows_of(near) == rows_of(expected_near)
    # Rows of triangles: the loop ends with them.
    assert near.mockup_triangles.tolist() == number[expected_near.mockup_triangles].tolist()
    same_distance(left.distance(tool, pose), other.distance(tool, pose), number)
    for one, two in zip(left.nearest(tool, pose, 3), other.nearest(tool, pose, 3), strict=True):
        same_distance(one, two, number)

    same_contacts(left.contacts(tool, pose), other.contacts(tool, pose))
    way, expected_way = left.penetration(tool, pose), other.penetration(tool, pose)
    assert way.kind == expected_way.kind and way.depth == pytest.approx(expected_way.depth, abs=1e-9)
    for touching in ("counts", "free"):
        cast, expected_cast = (each.cast(tool, *poses, touching=touching) for each in (left, other))
        assert (cast is None) == (expected_cast is None)
        if cast is not None and expected_cast is not None:
            # Both may be early by a tolerance of a micrometre.
            assert cast.fraction == pytest.approx(expected_cast.fraction, abs=1e-4)
            assert left.part_mask[cast.part]

    batch, expected_batch = (each.collide_batch(tool, poses) for each in (left, other))
    assert batch.offsets.tolist() == expected_batch.offsets.tolist()
    assert batch.pairs[:, 1].tolist() == number[expected_batch.pairs[:, 1]].tolist()
    values, expected_values = (each.distance_batch(tool, poses).values for each in (left, other))
    assert values.tolist() == expected_values.tolist()
    rows, expected_rows = (each.clearance_batch(tool, poses, 0.3) for each in (left, other))
    assert rows.offsets.tolist() == expected_rows.offsets.tolist()
    assert [rows_of(rows[i]) for i in (0, 1)] == [rows_of(expected_rows[i]) for i in (0, 1)]
    check, expected_check = (each.check_path(tool, poses) for each in (left, other))
    assert check.is_free == expected_check.is_free


@given(gone=st.sets(st.integers(0, 7)), pose=POSES)
def test_a_scene_without_parts_is_right_by_the_judge(
    scene: feeler.Scene, mockup: feeler.Mockup, tool: feeler.Tool, gone: set[int], pose: np.ndarray
) -> None:
    hit = scene.without(sorted(gone)).collide(tool, pose)
    found = {(int(t), int(m)): int(kind) for (t, m), kind in zip(hit.pairs, hit.kind_codes, strict=True)}
    expected = oracle.collide(mockup, tool, pose)
    assert found == {pair: kind for pair, kind in expected.items() if mockup.part_of_face[pair[1]] not in gone}


def test_out_stays_out(scene: feeler.Scene, tool: feeler.Tool) -> None:
    first = scene.without("engine/pump")
    assert first.without(["gasket", 0]).part_mask.tolist() == [False] * 4 + [True] * 4
    assert first.only("engine").part_mask.tolist() == [False] * 3 + [True] + [False] * 4
    assert scene.only(["frame", "frame_2"]).without("frame").part_mask.tolist() == [False] * 5 + [True, False, False]
    assert scene.only([]).part_mask.any() == False  # noqa: E712
    assert scene.without([]).part_mask.all() and scene.only("*").part_mask.all()
    assert first.only(first.part_mask).part_mask.tolist() == first.part_mask.tolist()
    # What another was made of stays as it was.
    assert scene.part_mask.all() and scene.is_colliding(tool, at()) and not first.is_colliding(tool, at())


def test_nothing_there_is_free(scene: feeler.Scene, tool: feeler.Tool) -> None:
    nothing = scene.without("*")
    assert "0 of 8 parts there" in repr(nothing)
    assert not nothing.collide(tool, at()) and nothing.is_free(tool, at())
    assert nothing.distance(tool, at()).part is None and nothing.nearest(tool, at(), 2) == []
    assert len(nothing.contacts(tool, at())) == 0 and nothing.penetration(tool, at()).depth == 0
    assert nothing.check_path(tool, [at(), at(3)]).is_free and nothing.cast(tool, at(), at(3)) is None


def test_the_mask_is_of_the_scene_alone(scene: feeler.Scene) -> None:
    mask = scene.without(1).part_mask
    assert (mask.dtype, mask.shape) == (np.bool_, (8,))
    assert "7 of 8 parts there" in repr(scene.without(1)) and "there" not in repr(scene)


def test_a_scene_without_parts_shares_the_index(scene: feeler.Scene) -> None:
    whole, less = dict(scene.memory()), dict(scene.without(1).memory())
    own = less.pop("selection")
    # A bit a triangle and a byte a part at least; blocks have a word a node beside these.
    assert 8 + 12 <= own <= 2000
    assert less.pop("total") == whole.pop("total") + own
    assert less == whole
    assert scene.without(1).build_seconds == 0.0
    assert scene.without(1).voxel_size == scene.voxel_size and scene.without(1).storage == scene.storage


def test_threads_select_and_ask_at_once(scene: feeler.Scene, mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    poses = [at(0.9 * i, 0.7, 0.1, 30) for i in range(6)]

    def ask(i: int) -> list[Any]:
        left = scene.without(i % 8)
        return [(left.collide(tool, p).pairs.tolist(), left.distance(tool, p).value) for p in poses]

    expected = [ask(i) for i in range(8)]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, range(64))) == 8 * expected


WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("way", WAYS)
def test_a_scene_without_parts_travels(scene: feeler.Scene, tool: feeler.Tool, way: str) -> None:
    class Own(feeler.Scene):
        pass

    left = scene.without(["gasket", "engine/pump"])
    there = WAYS[way](left)
    assert there.part_mask.tolist() == left.part_mask.tolist()
    assert there.collide(tool, at(2.7)).pairs.tolist() == left.collide(tool, at(2.7)).pairs.tolist()
    assert type(Own(scene.mockup).without(0)) is Own
    assert Own(scene.mockup, threads=1).without(0)._given["threads"] == 1


def test_wrong_parts_change_nothing(scene: feeler.Scene) -> None:
    for select in (scene.without, scene.only):
        for wrong in ("nothing", 8, None, [0, "nothing"], np.array([True])):
            with pytest.raises(feeler.OptionError):
                select(wrong)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="do you mean 'frame'"):
        scene.without("frames")


def test_defects_and_empty_parts_may_be_out() -> None:
    vertices, faces = joined(cube((0, 0, 0), 1), cube((2, 0, 0), 1))
    faces = np.concatenate([faces, [[0, 1, 99], [3, 3, 3]]])
    mockup = feeler.Mockup(vertices, faces, [0] * 12 + [2] * 12 + [3, 3], ["a", "empty", "b", "bad"])
    scene, probe = feeler.Scene(mockup), feeler.Tool(*cube((0, 0, 0), 1))
    for gone, hits in (("empty", True), ("bad", True), ("a", False), (["empty", "bad", "a"], False)):
        assert scene.without(gone).is_colliding(probe, at(0.2)) == hits
    for kept in ("empty", "bad"):
        assert scene.only(kept).is_free(probe, at(0.2))


class Column:
    """A column of booleans of a table, as pandas has it: of objects where it may have gaps."""

    def __init__(self, entries: list[Any], dtype: type[Any]) -> None:
        self.entries, self.dtype = entries, dtype

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray[Any, Any]:
        return np.array(self.entries, dtype=self.dtype)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.entries)


def test_booleans_of_any_kind_are_a_mask() -> None:
    mockup = mockup_of({name: cube((0, 0, 0), 1) for name in "abc"})
    entries = [True, False, True]
    masks = [np.array(entries), entries, tuple(entries), Column(entries, bool), Column(entries, object)]
    for mask in masks:
        assert mockup.parts.select(mask).tolist() == [0, 2]  # type: ignore[arg-type]
        assert feeler.Scene(mockup).only(mask).part_mask.tolist() == entries  # type: ignore[arg-type]
    for few in ([True], np.array([True]), Column([True], bool)):
        with pytest.raises(feeler.OptionError, match=r"a mask of shape \(1,\) does not fit 3 parts"):
            mockup.parts.select(few)  # type: ignore[arg-type]
    for mixed in ([True, 1, 2], Column([True, None, False], object), True):
        with pytest.raises(feeler.OptionError, match="True names no part: a mask is"):
            mockup.parts.select(mixed)  # type: ignore[arg-type]
    found = feeler.clash(mockup)
    rows = [True] + [False] * (len(found) - 1)
    assert found[rows].ids == found[np.array(rows)].ids == found[:1].ids
    with pytest.raises(feeler.OptionError, match="a mask of shape"):
        found[[True]]


def test_a_part_of_another_mesh_with_its_name_is_refused() -> None:
    block = cube((0, 0, 0), 1)
    one, other = mockup_of({"a": block}), mockup_of({"a": joined(block, cube((5, 0, 0), 1))})
    with pytest.raises(feeler.OptionError, match="of another mesh"):
        one.parts.select(other.parts[0])


def test_parts_are_found_among_others(mockup: feeler.Mockup) -> None:
    """By their index: thousands are not gone through for each."""
    parts, other = mockup.parts, feeler.Mockup({"a": box((0, 0, 0), (1, 1, 1)), "b": box((2, 0, 0), (3, 1, 1))}).parts
    assert all(each in parts for each in parts)
    for wrong in (other[1], 3, "a", None):
        assert wrong not in parts


def test_parts_cannot_be_exchanged(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    for mesh in (mockup, tool):
        with pytest.raises(AttributeError):
            mesh.parts = other_parts()  # type: ignore[misc]


def other_parts() -> feeler.Parts:
    return feeler.Mockup({"a": box((0, 0, 0), (1, 1, 1))}).parts
