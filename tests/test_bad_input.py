"""Whatever a caller passes in gets a right answer, or a typed error that says what, where and what to do."""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import oracle
import pytest
from shapes import box

import feeler
from feeler.io import body_of

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
IDENTITY = np.eye(4)

STORES: list[dict[str, Any]] = [{}, {"storage": "dense"}, {"storage": "hashed", "hashing": 0.5}]
stores = pytest.mark.parametrize("store", STORES, ids=["blocks", "dense", "hashed"])
meshes = pytest.mark.parametrize("make", [feeler.Mockup, feeler.Tool], ids=["mockup", "tool"])


@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use stays")
def test_a_current_folder_that_is_gone(tmp_path: Path) -> None:
    program = "import os, sys, feeler; os.rmdir(os.getcwd()); feeler.open_scene('x.feeler')"
    command = "import os; os.rmdir(os.getcwd()); from feeler.cli import main; main()"
    for code, said in ((program, "MissingFileError: x.feeler: the"), (command, "feeler: the")):
        here = tmp_path / "here"
        here.mkdir()
        run = subprocess.run([sys.executable, "-c", code, "info", "x.stl"], capture_output=True, text=True, cwd=here)
        assert run.returncode != 0 and f"{said} current folder is gone" in run.stderr


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return feeler.Mockup(CORNERS, FACES)


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    return feeler.Tool(CORNERS, FACES)


@pytest.fixture(scope="module")
def scene(mockup: feeler.Mockup) -> feeler.Scene:
    return feeler.Scene(mockup)


def moved(x: float, y: float, z: float) -> npt.NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


# --- meshes --------------------------------------------------------------------------------------------------------

NOT_A_TABLE: list[tuple[str, Any, str]] = [
    ("none", None, "shape"),
    ("a string", "abc", "shape"),
    ("a number", 7, "shape"),
    ("a dict", {}, "shape"),
    ("a generator", (x for x in [[0, 0, 0]]), "shape"),
    ("one dimension", [0, 1, 2], "shape"),
    ("three dimensions", np.zeros((2, 3, 3)), "shape"),
    ("two columns", np.zeros((3, 2)), "shape"),
    ("four columns", np.zeros((3, 4)), "shape"),
    ("ragged", [[0, 0, 0], [1, 0]], "read as an array"),
    ("complex", np.zeros((3, 3), dtype=complex), "dtype complex128"),
    ("objects", np.zeros((3, 3), dtype=object), "dtype object"),
    ("booleans", np.zeros((3, 3), dtype=bool), "dtype bool"),
    ("strings", np.full((3, 3), "1"), "dtype <U1"),
    ("bytes", np.full((3, 3), b"1"), "dtype |S1"),
    ("durations", np.zeros((3, 3), dtype="m8[s]"), "dtype timedelta64"),
    ("integers beyond 64 bits", [[0, 1, 2**70]] * 3, "dtype object"),
]


@meshes
@pytest.mark.parametrize(("bad", "words"), [case[1:] for case in NOT_A_TABLE], ids=[case[0] for case in NOT_A_TABLE])
def test_vertices_and_faces_that_are_no_table_of_numbers(make: Any, bad: Any, words: str) -> None:
    with pytest.raises(feeler.MeshError) as error:
        make(bad, FACES)
    assert str(error.value).startswith("vertices") and words in str(error.value)
    with pytest.raises(feeler.MeshError) as error:
        make(CORNERS, bad)
    assert str(error.value).startswith("faces") and words in str(error.value)
    assert isinstance(error.value, ValueError)


@meshes
@pytest.mark.parametrize("empty", [[], np.empty((0, 3), dtype=int), np.empty((0, 3)), np.empty(0, dtype=int)])
def test_no_faces(make: Any, empty: Any) -> None:
    with pytest.raises(feeler.MeshError, match=r"faces is empty: a mesh needs at least one triangle"):
        make(CORNERS, empty)


@meshes
def test_no_vertices(make: Any) -> None:
    with pytest.raises(feeler.MeshError, match=r"can be queried, of 4 \(4 index_out_of_range\)"):
        make(np.empty((0, 3)), FACES)
    with pytest.raises(feeler.MeshError, match=r"vertices has shape \(0,\)"):
        make([], FACES)


@meshes
@pytest.mark.parametrize(
    ("bad", "words"),
    [(np.nan, "nan"), (np.inf, "inf"), (-np.inf, "-inf"), (0.5, "0.5"), (2.0**53, "9007199254740992.0")],
)
def test_faces_that_are_not_whole_say_where(make: Any, bad: float, words: str) -> None:
    faces = FACES.astype(float)
    faces[2, 1] = bad
    with pytest.raises(feeler.MeshError) as error:
        make(CORNERS, faces)
    assert "faces[2, 1]" in str(error.value) and words in str(error.value) and "whole numbers" in str(error.value)


@meshes
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300, -1e101])
def test_a_mesh_of_nothing_but_defects(make: Any, bad: float) -> None:
    kind = "too_large" if np.isfinite(bad) else "non_finite"
    with pytest.raises(feeler.MeshError, match=rf"can be queried, of 4 \(4 {kind}\): repair the mesh"):
        make(np.full((4, 3), bad), FACES)
    with pytest.raises(feeler.MeshError, match="4 zero_area"):
        make(np.zeros((4, 3)), FACES)


def test_a_long_double_beyond_float64_is_a_defect_not_a_warning() -> None:
    if np.finfo(np.longdouble).max <= np.finfo(np.float64).max:
        pytest.skip("long double is float64 here")
    vertices = np.vstack([CORNERS, CORNERS[:1]]).astype(np.longdouble)
    vertices[4, 0] = np.longdouble("1e4000")
    assert feeler.Mockup(vertices, [*FACES.tolist(), [1, 2, 4]]).report.defects["non_finite"].first == (4,)


@pytest.mark.parametrize(
    ("part_of_face", "names", "words"),
    [
        ([0, 1], ["a", "b"], "part_of_face has 2 entries but there are 4 triangles"),
        ([], ["a"], "part_of_face has 0 entries but there are 4 triangles"),
        ([0, 0, 0, 2], ["a", "b"], "part_of_face[3] is 2, but there are 2 parts (0 to 1)"),
        ([0, -1, 0, 0], ["a"], "part_of_face has values from -1 to 0"),
        ([0, 0, 0, 2**32 - 1], ["a"], "part_of_face has values from 0 to 4294967295"),
        ([0, 0, 0.5, 0], ["a"], "part_of_face[2] is 0.5"),
        ([0, 0, np.nan, 0], ["a"], "part_of_face[2] is nan"),
        ([[0, 0, 0, 0]], ["a"], "part_of_face has shape (1, 4)"),
        ("abcd", ["a"], "part_of_face has shape ()"),
        ([0, 0, 0, 4_000_000_000], None, "part_of_face goes up to 4000000000: give part_names"),
        (None, [], "part_names is empty"),
        (None, "abc", "part_names is 'abc': give a sequence of strings"),
        (None, 5, "part_names is 5: give a sequence of strings"),
        (None, ["a", 5], "part_names[1] is 5: give a string"),
        (None, [b"a"], "part_names[0] is b'a': give a string"),
    ],
)
def test_parts_that_do_not_fit(part_of_face: Any, names: Any, words: str) -> None:
    with pytest.raises(feeler.MeshError) as error:
        feeler.Mockup(CORNERS, FACES, part_of_face, names)
    assert words in str(error.value)


def test_as_many_paths_as_names() -> None:
    with pytest.raises(feeler.MeshError, match="part_paths has 2 entries but part_names has 1"):
        feeler.Mockup(CORNERS, FACES, None, ["a"], part_paths=["a", "b"])


# --- coordinates ---------------------------------------------------------------------------------------------------


@stores
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_one_bad_coordinate_costs_only_its_triangles(store: dict[str, Any], bad: float, tool: feeler.Tool) -> None:
    vertices = np.vstack([CORNERS, [[bad, 0.0, 0.0], [0.0, bad, 0.0]]])
    faces = [[0, 1, 4], *FACES.tolist(), [1, 2, 5]]
    hit = feeler.Scene(feeler.Mockup(vertices, faces), **store).collide(tool, moved(0.25, 0.25, -0.5))
    clean = feeler.Scene(feeler.Mockup(CORNERS, FACES), **store).collide(tool, moved(0.25, 0.25, -0.5))
    assert len(clean) > 2
    assert hit.pairs.tolist() == (clean.pairs.astype(int) + np.array([0, 1])).tolist()
    # The same for a tool with defects.
    broken = feeler.Tool(vertices, faces)
    hit = feeler.Scene(feeler.Mockup(CORNERS, FACES), **store).collide(broken, moved(0.25, 0.25, -0.5))
    assert hit.pairs.tolist() == (clean.pairs.astype(int) + np.array([1, 0])).tolist()


@stores
@pytest.mark.parametrize("scale", [5e-324, 1e-310, 1e-200, 1e-150, 1e-30, 1e30, 1e77, 1e90, 1e99])
def test_huge_tiny_and_denormal_meshes_get_right_answers(store: dict[str, Any], scale: float) -> None:
    corners = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [1, 1, -2], [1, 1, 2], [3, 1, 2], [1, 4, 4]])
    faces = [[0, 1, 2], [0, 1, 3], [4, 5, 6], [1, 2, 7], [5, 6, 7]]
    mockup, tool = feeler.Mockup(corners * scale, faces), feeler.Tool(corners[::-1] * scale, faces)
    scene = feeler.Scene(mockup, **store)
    scene.validate()
    for pose in (IDENTITY, moved(scale, 0, 0), moved(-2 * scale, scale, 0), moved(9 * scale, 0, 0)):
        hit = scene.collide(tool, pose)
        found = {(int(t), int(s)): int(k) for (t, s), k in zip(hit.pairs, hit.kind_codes, strict=True)}
        assert found == oracle.collide(mockup, tool, pose)
        assert scene.is_colliding(tool, pose) == bool(found)
    assert len(scene.collide(tool, IDENTITY)) > 5


@stores
def test_a_mesh_that_spans_all_magnitudes(store: dict[str, Any]) -> None:
    # A denormal triangle, a normal one and one of 1e99 m in one mock-up.
    shape = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    vertices = np.vstack([shape * 5e-324, shape, shape * 1e99])
    mockup = feeler.Mockup(vertices, np.arange(9).reshape(3, 3))
    scene = feeler.Scene(mockup, **store)
    sizes_met: dict[float, set[int]] = {}
    for size in (5e-324, 1e-200, 1.0, 1e50, 1e99):
        tool = feeler.Tool(np.array([[1.0, 1, -1], [1, 1, 1], [2, 1, 1]]) * size, [[0, 1, 2]])
        hit = scene.collide(tool, IDENTITY)
        found = {(int(t), int(s)): int(k) for (t, s), k in zip(hit.pairs, hit.kind_codes, strict=True)}
        assert found == oracle.collide(mockup, tool)
        sizes_met[size] = {s for _, s in found}
    assert sizes_met[1.0] == {1, 2} and sizes_met[1e99] == {2}


@stores
def test_a_tool_triangle_that_rounds_to_a_point_or_a_segment(store: dict[str, Any], mockup: feeler.Mockup) -> None:
    scene = feeler.Scene(mockup, **store)
    for corners in (
        [[0, 0, 0], [1e-20, 0, 0], [0, 1e-20, 0]],
        [[0, 0, -1], [0, 0, 1], [1e-20, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0.5, 1e-20, 0]],
        [[0, 0, -0.25], [0.25, 0.25, -0.25], [0.25, 0, -0.25 + 1e-20]],
    ):
        tool = feeler.Tool(corners, [[0, 1, 2]])
        met = 0
        for pose in (moved(0.25, 0.25, 0), moved(0.25, 0.25, 0.5), moved(0.25, 0.25, 0.25), moved(2, 2, 2)):
            hit = scene.collide(tool, pose)
            found = {(int(t), int(s)): int(k) for (t, s), k in zip(hit.pairs, hit.kind_codes, strict=True)}
            assert found == oracle.collide(mockup, tool, pose)
            met += len(found)
        assert met


@stores
@pytest.mark.parametrize("distance", [5.0, 1e9, 1e50, 1e99, 1e100])
def test_a_tool_wholly_outside(
    store: dict[str, Any], distance: float, mockup: feeler.Mockup, tool: feeler.Tool
) -> None:
    scene = feeler.Scene(mockup, **store)
    poses = []
    for axis, sign in itertools.product(range(3), (1, -1)):
        pose = np.eye(4)
        pose[axis, 3] = sign * distance
        poses.append(pose)
        hit = scene.collide(tool, pose)
        assert len(hit) == 0
        assert hit.stats["entries_scanned"] == 0, "clear of the mock-up's box: no pair is worth a look"
        assert not scene.is_colliding(tool, pose)
    assert len(scene.collide_batch(tool, poses).pairs) == 0


@stores
def test_a_tool_far_larger_than_the_mock_up(store: dict[str, Any], mockup: feeler.Mockup) -> None:
    scene = feeler.Scene(mockup, voxel_size=0.01, **store)
    for size in (1e3, 1e15, 1e99):
        big = feeler.Tool(np.array([[-1, -1, 0], [2, -1, 0], [-1, 2, 0]]) * size, [[0, 1, 2]])
        assert scene.collide(big, moved(0, 0, 0.5)).pairs[:, 1].tolist() == [1, 2, 3]
        assert len(scene.collide(big, moved(0, 0, 1.5))) == 0


# --- poses ---------------------------------------------------------------------------------------------------------


def changed(**entries: float) -> npt.NDArray[np.float64]:
    pose = np.eye(4)
    for place, value in entries.items():
        pose[int(place[1]), int(place[2])] = value
    return pose


NOT_A_POSE: list[tuple[str, Any, str]] = [
    ("none", None, "dtype object"),
    ("a string", "x", "dtype <U1"),
    ("empty", [], "shape (0,)"),
    ("3 x 3", np.eye(3), "a pose has shape (3, 3): (4, 4) is needed"),
    ("3 x 4", np.eye(4)[:3], "a pose has shape (3, 4): (4, 4) is needed"),
    ("a batch of one", np.eye(4)[None], "shape (1, 4, 4)"),
    ("sixteen numbers", np.eye(4).ravel(), "shape (16,)"),
    ("ragged", [[1.0], [1.0, 2.0]], "a pose is a pair of shapes (1,) and (2,): give a rotation (3, 3)"),
    ("complex", np.eye(4, dtype=complex), "dtype complex128"),
    ("objects", np.eye(4, dtype=object), "dtype object"),
    ("booleans", np.eye(4, dtype=bool), "dtype bool"),
    ("NaN", changed(_12=np.nan), "pose[1, 2] is NaN"),
    ("infinite", changed(_03=np.inf), "pose[0, 3] is inf"),
    ("minus infinite", changed(_33=-np.inf), "pose[3, 3] is -inf"),
    ("too far", changed(_23=1e101), "at most 1e100"),
    ("mirror", np.diag([-1.0, 1, 1, 1]), "it mirrors"),
    ("point mirror", np.diag([-1.0, -1, -1, 1]), "it mirrors"),
    ("scale", np.diag([2.0, 2, 2, 1]), "have length 2, not 1: the pose scales"),
    ("millimetres to metres", np.diag([1e-3, 1e-3, 1e-3, 1]), "have length 0.001, not 1: the pose scales"),
    ("stretch", np.diag([1.0, 1.0, 1.00001, 1]), "row 2 of the rotation has length 1.00001, not 1 "),
    ("shear", changed(_01=1e-3), "rows 0 and 1 of the rotation are 89.942704 degrees apart, not 90"),
    ("flat", np.diag([1.0, 1, 0, 1]), "row 2 of the rotation has length 0, not 1 "),
    ("all zero", np.zeros((4, 4)), "not rigid"),
    ("projective", changed(_30=0.1), "the last row"),
    ("homogeneous scale", np.diag([1.0, 1, 1, 2]), "the last row"),
    ("transposed", changed(_30=1.0, _31=2.0, _32=3.0), "it looks transposed"),
]


@pytest.mark.parametrize(("bad", "words"), [case[1:] for case in NOT_A_POSE], ids=[case[0] for case in NOT_A_POSE])
def test_poses_that_are_none(scene: feeler.Scene, tool: feeler.Tool, bad: Any, words: str) -> None:
    for query in (scene.collide, scene.is_colliding):
        with pytest.raises(feeler.PoseError) as error:
            query(tool, bad)
        assert words in str(error.value)
        assert isinstance(error.value, ValueError)


NOT_NUMBERS: list[tuple[str, Any, str]] = [
    ("a complex rotation", (np.eye(3, dtype=complex), np.zeros(3)), "dtypes complex128 and float64: real numbers"),
    ("a complex translation", (np.eye(3), [0.0, 0.0, 5j]), "dtypes float64 and complex128: real numbers"),
    ("a translation in words", (np.eye(3), ["1", "2", "3"]), "dtypes float64 and <U1: real numbers"),
    ("a rotation of booleans", (np.eye(3, dtype=bool), np.zeros(3)), "dtypes bool and float64: real numbers"),
    ("a pair of objects", (np.eye(3, dtype=object), np.zeros(3)), "dtypes object and float64: real numbers"),
]


@pytest.mark.parametrize(("bad", "words"), [case[1:] for case in NOT_NUMBERS], ids=[case[0] for case in NOT_NUMBERS])
def test_pairs_of_other_than_real_numbers_are_no_poses(
    scene: feeler.Scene, tool: feeler.Tool, bad: Any, words: str
) -> None:
    for query, pose in ((scene.collide, bad), (scene.distance, bad), (scene.collide_batch, [IDENTITY, bad, IDENTITY])):
        with pytest.raises(feeler.PoseError) as error:
            query(tool, pose)  # type: ignore[operator]
        assert words in str(error.value)


@pytest.mark.parametrize("bad", [case[1] for case in NOT_A_POSE[11:]], ids=[case[0] for case in NOT_A_POSE[11:]])
def test_the_bad_pose_of_a_batch_is_named(scene: feeler.Scene, tool: feeler.Tool, bad: Any) -> None:
    with pytest.raises(feeler.PoseError, match=r"^poses\[7\]: "):
        scene.collide_batch(tool, [*[IDENTITY] * 7, bad, IDENTITY])


@pytest.mark.parametrize(
    "bad",
    [None, "x", np.eye(4), np.zeros((2, 3, 3)), np.zeros((2, 4, 3)), np.zeros((0, 4)), np.zeros((1, 2, 4, 4))],
)
def test_batches_of_the_wrong_shape(scene: feeler.Scene, tool: feeler.Tool, bad: Any) -> None:
    with pytest.raises(feeler.PoseError, match=r"(shape|dtype)"):
        scene.collide_batch(tool, bad)


def test_poses_of_any_real_dtype_and_order(scene: feeler.Scene, tool: feeler.Tool) -> None:
    turned = np.array([[0.0, -1, 0, 0.25], [1, 0, 0, 0.5], [0, 0, 1, 0], [0, 0, 0, 1]])
    expected = scene.collide(tool, turned).pairs.tolist()
    wide = np.zeros((8, 12))
    wide[::2, ::3] = turned
    unaligned = np.frombuffer(b"x" + turned.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(4, 4)
    for pose in (
        turned.tolist(), turned.astype("f4"), turned.astype("f2"), turned.astype("g"), turned.astype(">f8"),
        np.asfortranarray(turned), wide[::2, ::3], turned[::-1].copy()[::-1], unaligned,
    ):  # fmt: skip
        assert scene.collide(tool, pose).pairs.tolist() == expected
        assert scene.collide_batch(tool, np.asarray(pose)[None])[0].tolist() == expected
    for dtype in ("i1", "i8", "u1", "u8"):
        assert (
            scene.collide(tool, np.eye(4, dtype=dtype)).pairs.tolist() == scene.collide(tool, IDENTITY).pairs.tolist()
        )


def test_a_pose_within_tolerance_is_used_as_given() -> None:
    # Rigid to 4e-7: accepted, and not made exact in silence. The point reaches 1 + 4e-7 and no further.
    mockup = feeler.Mockup([[1.0 + 4e-7, -1, -1], [1.0 + 4e-7, 1, -1], [1.0 + 4e-7, 0, 1]], [[0, 1, 2]])
    tool = feeler.Tool([[1.0, 0, 0], [0, 0.1, 0], [0, -0.1, 0]], [[0, 1, 2]])
    assert feeler.Scene(mockup).is_colliding(tool, changed(_00=1.0 + 4e-7))
    assert not feeler.Scene(mockup).is_colliding(tool, changed(_00=1.0 + 3.9e-7))


def test_an_empty_batch(scene: feeler.Scene, tool: feeler.Tool) -> None:
    batch = scene.collide_batch(tool, np.empty((0, 4, 4)))
    assert len(batch) == 0
    assert batch.offsets.tolist() == [0]
    assert batch.pairs.shape == (0, 2)
    assert batch.kind_codes.shape == (0,)
    with pytest.raises(IndexError):
        batch[0]


def test_a_million_poses(scene: feeler.Scene, tool: feeler.Tool) -> None:
    poses = np.tile(np.eye(4), (1_000_000, 1, 1))
    poses[:, 0, 3] = 50.0
    poses[::1000, 0, 3] = 0.5
    told: list[float] = []
    batch = scene.collide_batch(tool, poses, progress=lambda done, stage: told.append(done))
    assert told == sorted(told) and len(told) > 100
    one = scene.collide(tool, poses[0])
    assert len(batch) == 1_000_000
    assert batch.offsets[-1] == len(batch.pairs) == 1000 * len(one)
    assert batch[999_000].tolist() == one.pairs.tolist()
    assert len(batch[999_999]) == 0
    assert (np.diff(batch.offsets.astype(np.int64)) == np.where(poses[:, 0, 3] < 1, len(one), 0)).all()
    # A pose clear of the mock-up's box costs no step of a query.
    assert not any(scene.collide(tool, poses[1]).stats.values())


def test_a_million_poses_can_be_interrupted(scene: feeler.Scene, tool: feeler.Tool) -> None:
    told: list[float] = []

    def interrupt(done: float, stage: str) -> None:
        told.append(done)
        if done > 0.01:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        scene.collide_batch(tool, np.tile(np.eye(4), (1_000_000, 1, 1)), progress=interrupt)
    assert told[-1] < 0.02, "nothing is done after the interrupt"


# --- options -------------------------------------------------------------------------------------------------------


@stores
@pytest.mark.parametrize("bad", [0, 0.0, -0.0, -1, np.nan, np.inf, -np.inf])
def test_voxel_sizes_that_are_none(mockup: feeler.Mockup, store: dict[str, Any], bad: float) -> None:
    with pytest.raises(feeler.OptionError, match=r"voxel_size is .*: it must be a positive, finite length in metres"):
        feeler.Scene(mockup, voxel_size=bad, **store)


@stores
@pytest.mark.parametrize("bad", ["0.1", b"1", [1.0], np.array([0.5, 1.0]), 1j, True, {}, 10**400])
def test_voxel_sizes_that_are_no_number(mockup: feeler.Mockup, store: dict[str, Any], bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match="voxel_size is "):
        feeler.Scene(mockup, voxel_size=bad, **store)


@stores
@pytest.mark.parametrize("absurd", [1e-9, 1e-100, 1e-300, 5e-324])
def test_absurdly_small_voxels_are_refused_at_once(mockup: feeler.Mockup, store: dict[str, Any], absurd: float) -> None:
    told: list[float] = []
    with pytest.raises(feeler.LimitError, match="choose") as error:
        feeler.Scene(mockup, voxel_size=absurd, progress=lambda done, stage: told.append(done), **store)
    assert set(told) <= {0.0}, "no stage of the build is done before the refusal"
    assert isinstance(error.value, MemoryError)
    assert len(str(error.value)) < 300


@stores
@pytest.mark.parametrize("absurd", [1e3, 1e100, 1e300, 1.7e308])
def test_absurdly_large_voxels_work(
    mockup: feeler.Mockup, tool: feeler.Tool, store: dict[str, Any], absurd: float
) -> None:
    scene = feeler.Scene(mockup, voxel_size=absurd, **store)
    assert scene.voxel_size == absurd
    expected = feeler.Scene(mockup).collide(tool, moved(0.3, 0, 0)).pairs.tolist()
    assert scene.collide(tool, moved(0.3, 0, 0)).pairs.tolist() == expected


@pytest.mark.parametrize("bad", [-0.1, 1, 1.0, 0.995, 2, np.nan, np.inf])
def test_hashing_out_of_range(mockup: feeler.Mockup, bad: float) -> None:
    with pytest.raises(feeler.OptionError, match=r"hashing is .*: it must be between 0 .* and 0\.99"):
        feeler.Scene(mockup, storage="hashed", hashing=bad)


@pytest.mark.parametrize("bad", ["0.5", None, [0.5], 1j, True])
def test_hashing_that_is_no_number(mockup: feeler.Mockup, bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match=r"hashing is .*: give a number"):
        feeler.Scene(mockup, storage="hashed", hashing=bad)


@pytest.mark.parametrize("storage", ["blocks", "dense"])
@pytest.mark.parametrize("level", [0.5, -0.1, np.nan])
def test_hashing_without_a_hashed_store(mockup: feeler.Mockup, storage: str, level: float) -> None:
    with pytest.raises(feeler.OptionError, match="the storage is not 'hashed': leave hashing at 0 or choose"):
        feeler.Scene(mockup, storage=storage, hashing=level)


@pytest.mark.parametrize("bad", ["", "octree", "BLOCKS", None, 5, ["blocks"]])
def test_unknown_storage(mockup: feeler.Mockup, bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match="choose blocks, dense, hashed"):
        feeler.Scene(mockup, storage=bad)


@pytest.mark.parametrize("bad", ["", "median", "AREA", None, 5])
def test_unknown_estimator(mockup: feeler.Mockup, tool: feeler.Tool, bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match="estimator is "):
        feeler.optimal_voxel_size(mockup, tool, bad)


@pytest.mark.parametrize("bad", [0, -1, 1025, 10**30, 1.5, 2.0, True, "2", [2], np.nan])
def test_thread_counts_that_are_none(mockup: feeler.Mockup, bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match="threads is"):
        feeler.Scene(mockup, threads=bad)


@pytest.mark.parametrize("bad", [-1, 2**64, 1e9, True, "1 GB", None.__class__])
def test_memory_limits_that_are_none(mockup: feeler.Mockup, bad: Any) -> None:
    with pytest.raises(feeler.OptionError, match="memory_limit is"):
        feeler.Scene(mockup, memory_limit=bad)


@pytest.mark.parametrize("bad", [5, "bar", [print], True])
def test_progress_that_cannot_be_called(
    mockup: feeler.Mockup, tool: feeler.Tool, scene: feeler.Scene, bad: Any
) -> None:
    with pytest.raises(feeler.OptionError, match="progress is"):
        feeler.Scene(mockup, progress=bad)
    with pytest.raises(feeler.OptionError, match="progress is"):
        scene.collide_batch(tool, [IDENTITY], progress=bad)


# --- memory --------------------------------------------------------------------------------------------------------


@stores
@pytest.mark.parametrize("limit", [0, 1, 10])
def test_a_limit_too_small_to_build(mockup: feeler.Mockup, store: dict[str, Any], limit: int) -> None:
    with pytest.raises(feeler.LimitError, match=rf"would need at least \d+ bytes but {limit} are allowed: choose"):
        feeler.Scene(mockup, memory_limit=limit, **store)


@stores
def test_a_size_beyond_the_limit_says_how_much(mockup: feeler.Mockup, store: dict[str, Any]) -> None:
    with pytest.raises(feeler.LimitError) as error:
        feeler.Scene(mockup, voxel_size=0.02, memory_limit=100_000, **store)
    needed = int(str(error.value).split("at least ")[1].split()[0])
    assert needed > 100_000
    scene = feeler.Scene(mockup, voxel_size=0.02, memory_limit=8 * needed, **store)
    assert scene.memory()["total"] < 8 * needed


def test_a_batch_too_large_for_the_limit(mockup: feeler.Mockup, tool: feeler.Tool) -> None:
    scene = feeler.Scene(mockup, memory_limit=100_000)
    assert len(scene.collide_batch(tool, [IDENTITY] * 10).pairs) > 0
    with pytest.raises(
        feeler.LimitError, match=r"this batch would need at least \d+ bytes but 100000 are allowed: pass fewer"
    ):
        scene.collide_batch(tool, np.tile(IDENTITY, (5_000, 1, 1)))
    # Nothing is left broken.
    assert len(scene.collide_batch(tool, [IDENTITY] * 10).pairs) > 0


@pytest.mark.parametrize("storage", ["dense", "hashed", "blocks"])
def test_a_limit_beyond_the_machine_does_not_kill_the_process(storage: str) -> None:
    # The limit promises memory that is not there; what then fails must fail as an error.
    code = f"""
import feeler
mockup = feeler.Mockup([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 3]])
try:
    feeler.Scene(mockup, voxel_size=1e-6, storage="{storage}", memory_limit=2**64 - 1)
except feeler.LimitError as error:
    print("refused:", error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-500:]
    assert done.stdout.startswith("refused:")


# --- classes -------------------------------------------------------------------------------------------------------


def test_the_wrong_kind_of_object(mockup: feeler.Mockup, tool: feeler.Tool, scene: feeler.Scene) -> None:
    for bad in (None, 5, "engine.stl", tool, (CORNERS, FACES)):
        with pytest.raises(feeler.MeshError, match=r"a scene needs a feeler\.Mockup, not "):
            feeler.Scene(bad)
        with pytest.raises(feeler.MeshError, match=r"needs a feeler\.Mockup, not "):
            feeler.optimal_voxel_size(bad, tool)
    for bad in (None, 5, "wrench.stl", mockup, scene, (CORNERS, FACES)):
        queries: list[Callable[[], object]] = [
            lambda bad=bad: scene.collide(bad, IDENTITY),
            lambda bad=bad: scene.is_colliding(bad, IDENTITY),
            lambda bad=bad: scene.collide_batch(bad, [IDENTITY]),
            lambda bad=bad: feeler.optimal_voxel_size(mockup, bad),
        ]
        if bad is not None:
            queries.append(lambda bad=bad: feeler.Scene(mockup, tool=bad))
        for query in queries:
            with pytest.raises(feeler.MeshError, match=rf"a feeler.Tool is needed, not {type(bad).__name__}"):
                query()


@pytest.mark.parametrize(
    "name", ["MeshError", "PoseError", "OptionError", "LimitError", "LoadError", "MissingFileError"]
)
def test_every_error_is_a_feeler_error(name: str) -> None:
    assert issubclass(getattr(feeler, name), feeler.FeelerError)
    assert name in feeler.__all__


AWKWARD: dict[str, Callable[[feeler.Scene, feeler.Tool], object]] = {
    "triangles": lambda scene, tool: scene.clearance(tool, np.eye(4), triangles=np.zeros(3)),  # type: ignore[arg-type]
    "inside": lambda scene, tool: scene.check_path(tool, [np.eye(4)], inside="no"),  # type: ignore[call-overload]
    "a filter": lambda scene, tool: scene.collide(tool, np.eye(4), box_filter=np.zeros(3)),  # type: ignore[arg-type]
    "rules": lambda scene, tool: feeler.clash(scene.mockup, rules=[]),  # type: ignore[arg-type]
    "scene": lambda scene, tool: feeler.clash(scene.mockup, scene="x"),  # type: ignore[arg-type]
    "volume": lambda scene, tool: feeler.clash(scene.mockup, volume="no"),  # type: ignore[arg-type]
    "progress": lambda scene, tool: feeler.sample("gearbox", 50_000, progress=3),  # type: ignore[arg-type]
    "poses need": lambda scene, tool: feeler.sample_path("x", tool, 3),  # type: ignore[arg-type]
    "n is": lambda scene, tool: feeler.sample_path(scene, tool, 2**63),
    "start": lambda scene, tool: feeler.insertion(scene, 0, start=[10**400] * 16),
    "max_deviation": lambda scene, tool: feeler.nearest_rigid(np.eye(4), None),  # type: ignore[arg-type]
    "name is": lambda scene, tool: feeler.sample_tool([]),  # type: ignore[arg-type]
    "storage": lambda scene, tool: feeler.optimal_voxel_size(scene.mockup, tool, "area", storage="abc"),
    "stiffness": lambda scene, tool: feeler.haptics.Coupling(stiffness_n_per_m="abc"),  # type: ignore[arg-type]
    "shading": lambda scene, tool: feeler.haptics.Session(scene, tool, shading="off"),  # type: ignore[arg-type]
    "path is None": lambda scene, tool: feeler.clash(scene.mockup).save(None),  # type: ignore[arg-type]
    "path is 5": lambda scene, tool: feeler.load_clashes(5),  # type: ignore[arg-type]
    "seed": lambda scene, tool: feeler.removal_order(scene, 0, seed="abc"),  # type: ignore[arg-type]
    "not rigid": lambda scene, tool: body_of(tool, pose=2 * np.eye(4)),
}
"""Arguments of the wrong kind, by what the error has to name."""


@pytest.mark.parametrize("named", list(AWKWARD))
def test_arguments_of_the_wrong_kind_are_named(named: str) -> None:
    mockup = feeler.Mockup(*box((0, 0, 0), (1, 1, 1)))
    with pytest.raises(feeler.FeelerError, match=named):
        AWKWARD[named](feeler.Scene(mockup), feeler.Tool(*box((2, 0, 0), (3, 1, 1))))


def test_a_list_of_rotation_and_translation_is_a_pose() -> None:
    scene = feeler.Scene(feeler.Mockup(*box((0, 0, 0), (1, 1, 1))))
    tool = feeler.Tool(*box((0, 0, 0), (1, 1, 1)))
    assert scene.distance(tool, [np.eye(3), [3.0, 0.0, 0.0]]).value == pytest.approx(2.0)
