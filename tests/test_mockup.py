"""Mock-ups and tools from arrays: what is accepted, how it reads back, parts, defects and reports."""

from __future__ import annotations

import gc
import json
import pickle
import re
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import feeler
from feeler.parts import Part
from feeler.source import Source

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])

Arrays = tuple[npt.NDArray[Any], npt.NDArray[Any]]
INTEGERS = ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", ">i4", ">u4", ">i8"]
FLOATS = ["f2", "f4", "f8", ">f8", ">f4", "g"]


def unaligned(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The same values one byte off every boundary."""
    raw = np.frombuffer(b"x" + array.tobytes(), dtype=np.uint8)[1:]
    return raw.view(array.dtype).reshape(array.shape)


def orders(array: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    wide = np.zeros((2 * array.shape[0], 3 * array.shape[1]), dtype=array.dtype)
    wide[::2, ::3] = array
    read_only = array.copy()
    read_only.flags.writeable = False
    return {
        "C": array,
        "Fortran": np.asfortranarray(array),
        "strided": wide[::2, ::3],
        "backwards": array[::-1, ::-1].copy()[::-1, ::-1],
        "unaligned": unaligned(array),
        "read-only": read_only,
        "broadcast": np.broadcast_to(array, (1, *array.shape))[0],
    }


@pytest.mark.parametrize("dtype", INTEGERS + FLOATS)
def test_any_real_dtype(dtype: str) -> None:
    for mesh in (feeler.Mockup(CORNERS.astype(dtype), FACES), feeler.Tool(CORNERS.astype(dtype), FACES)):
        assert mesh.vertices.dtype == np.float64
        assert mesh.vertices.tolist() == CORNERS.tolist()
    for mesh in (feeler.Mockup(CORNERS, FACES.astype(dtype)), feeler.Tool(CORNERS, FACES.astype(dtype))):
        assert mesh.faces.dtype == np.uint32
        assert mesh.faces.tolist() == FACES.tolist()


@pytest.mark.parametrize("order", orders(CORNERS))
@pytest.mark.parametrize("dtype", ["f8", "f4", "i4", "u4"])
def test_any_memory_order(order: str, dtype: str) -> None:
    mockup = feeler.Mockup(orders(CORNERS.astype(dtype))[order], orders(FACES.astype(dtype))[order])
    assert mockup.vertices.tolist() == CORNERS.tolist()
    assert mockup.faces.tolist() == FACES.tolist()
    assert mockup.report.not_queried == 0


def test_lists_tuples_and_subclasses_of_arrays() -> None:
    class Tagged(np.ndarray):
        pass

    for wrap in (lambda a: a.tolist(), lambda a: tuple(map(tuple, a.tolist())), lambda a: a.view(Tagged)):
        mockup = feeler.Mockup(wrap(CORNERS), wrap(FACES))
        assert mockup.vertices.tolist() == CORNERS.tolist()
        assert type(mockup.vertices) is np.ndarray


def test_numbers_are_kept_to_the_last_bit() -> None:
    vertices = np.array([[0.1, 1 / 3, 5e-324], [-0.0, 1e100, np.pi], [2.0**-1074, -1e-300, 1e16 + 2]])
    assert feeler.Mockup(vertices, [[0, 1, 2]]).vertices.tobytes() == vertices.tobytes()


def test_the_arrays_are_copied_in() -> None:
    vertices, faces, part_of_face = CORNERS.copy(), FACES.astype(np.uint32), np.zeros(4, dtype=np.uint32)
    mockup = feeler.Mockup(vertices, faces, part_of_face, ["a", "b"])
    vertices[:], faces[:], part_of_face[:] = 9.0, 9, 1
    assert mockup.vertices.tolist() == CORNERS.tolist()
    assert mockup.faces.tolist() == FACES.tolist()
    assert mockup.part_of_face.tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("make", [feeler.Mockup, feeler.Tool])
def test_arrays_are_read_only_and_outlive_the_mesh(make: Any) -> None:
    mesh = make(CORNERS, FACES)
    vertices, faces = mesh.vertices, mesh.faces
    del mesh
    gc.collect()
    _ = [np.full(1000, 7.0) for _ in range(100)]  # overwrites what was freed, if it was
    assert vertices.tolist() == CORNERS.tolist()
    assert faces.tolist() == FACES.tolist()
    for array in (vertices, faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True


def test_one_triangle_is_a_mesh() -> None:
    mockup = feeler.Mockup(CORNERS, FACES[:1])
    assert mockup.triangle_count == 1
    assert mockup.bounds.tolist() == [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0]]
    assert len(mockup.parts) == mockup.part_count == 1


def test_bounds_are_of_queried_triangles_only() -> None:
    # A stray vertex, one of a triangle without area, and one that is not finite: none of them counts.
    vertices = np.vstack([CORNERS, [[50.0, 0, 0], [60.0, 0, 0], [70.0, 0, 0], [np.nan, 0, 0]]])
    mockup = feeler.Mockup(vertices, [*FACES.tolist(), [4, 5, 6], [0, 1, 7]])
    assert mockup.bounds.tolist() == [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]
    assert mockup.report.extent == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("dtype", "bad"),
    [
        ("i1", -1), ("i1", 100), ("i2", -(2**15)), ("i4", 2**31 - 1), ("i8", -(2**63)), ("i8", 2**62), ("i8", 2**32),
        ("i8", 2**32 + 1), ("u1", 255), ("u2", 65535), ("u4", 2**32 - 1), ("u4", 4), ("u8", 2**64 - 1),
        ("u8", 2**32 + 1), ("f8", -1), ("f8", 2.0**40), ("f4", 2.0**40), ("f2", 1000),
    ],
)  # fmt: skip
def test_an_index_out_of_range_is_a_defect_of_its_triangle(dtype: str, bad: float) -> None:
    faces = np.array(FACES, dtype=dtype)
    faces[2, 1] = bad
    for mesh in (feeler.Mockup(CORNERS, faces), feeler.Tool(CORNERS, faces)):
        assert mesh.report.defects["index_out_of_range"].first == (2,)
        assert mesh.report.not_queried == 1
        assert mesh.faces[2, 1] >= len(CORNERS)
        assert mesh.faces[[0, 1, 3]].tolist() == FACES[[0, 1, 3]].tolist()


def test_every_kind_of_defect_is_counted_and_listed() -> None:
    vertices = [
        *CORNERS.tolist(),
        [np.nan, 0, 0],
        [0, np.inf, 0],
        [0, 0, -np.inf],
        [1e300, 0, 0],
        [2, 0, 0],
        [1e99, 0, 0],
    ]
    faces = [
        [0, 1, 2],
        [0, 1, 4],  # not finite
        [0, 1, 5],
        [0, 1, 6],
        [0, 2, 7],  # too large
        [0, 1, 8],  # on one line
        [1, 1, 2],  # two corners the same
        [3, 3, 3],  # three
        [2, 0, 1],  # a duplicate of 0, turned
        [0, 2, 1],  # and flipped
        [0, 1, 99],  # out of range
        [0, 2, 9],  # large, but fine
    ]
    report = feeler.Mockup(vertices, faces).report
    assert {kind: defect.first for kind, defect in report.defects.items()} == {
        "index_out_of_range": (10,),
        "non_finite": (1, 2, 3),
        "too_large": (4,),
        "zero_area": (5, 6, 7),
        "duplicate": (8, 9),
    }
    assert all(len(defect.first) == defect.count for defect in report.defects.values())
    assert report.not_queried == 8
    assert report.triangles == 12
    text = str(report)
    for words in (
        "3 non finite",
        "1 too large",
        "3 zero area",
        "2 duplicate",
        "1 index out of range",
        "not queried: 1, 2, 3",
    ):
        assert words in text


def test_many_defects_list_the_first_hundred() -> None:
    report = feeler.Tool(CORNERS, FACES.tolist() + [[1, 1, 1]] * 1000).report
    assert report.defects["zero_area"].count == 1000
    assert report.defects["zero_area"].first == tuple(range(4, 104))
    assert "1,000 zero area triangles, not queried: 4, 5, 6, 7, 8, ..." in str(report)


def test_zero_area_is_exact() -> None:
    # Nearly on one line is not on one line: 0.1 + 0.2 is not 0.3.
    nearly = [[0.0, 0.0, 0.0], [0.1, 0.1, 0.1], [0.3, 0.3, 0.1 + 0.2]]
    assert feeler.Mockup(nearly, [[0, 1, 2]]).report.not_queried == 0
    smallest = [[0.0, 0.0, 0.0], [5e-324, 0.0, 0.0], [0.0, 5e-324, 0.0]]
    assert feeler.Mockup(smallest, [[0, 1, 2]]).report.not_queried == 0
    exactly = [[0.0, 0.0, 0.0], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6]]
    with pytest.raises(feeler.MeshError, match="1 zero_area"):
        feeler.Mockup(exactly, [[0, 1, 2]])


def test_the_report_is_for_people_and_machines() -> None:
    source = Source(files=("a.stl",), format="stl", unit="mm", unit_source="given", seconds=0.5, notes=("binary",))
    mockup = feeler.Mockup(CORNERS, FACES, [0, 0, 1, 1], ["left", "right"], source=source)
    report = mockup.report
    assert (report.triangles, report.vertices, report.parts) == (4, 4, 2)
    text = str(report)
    for words in ("a.stl", "4 triangles in 2 parts", "1 x 2 x 3 m", "unit mm (given)", "no defects", "binary"):
        assert words in text
    figures = json.loads(json.dumps(report.to_dict()))
    assert figures["files"] == ["a.stl"]
    assert figures["extent"] == [1.0, 2.0, 3.0]
    assert figures["not_queried"] == 0
    assert figures["defects"]["zero_area"] == {"count": 0, "first": []}
    assert feeler.Tool(CORNERS, FACES).report.to_dict()["format"] == "arrays"


def test_parts() -> None:
    mockup = feeler.Mockup(
        CORNERS, FACES, np.array([0, 2, 2, 0], dtype=np.int8), ["frame", "spare", "cover"],
        part_paths=["car/frame", "car/spare", "car/lid/cover"],
    )  # fmt: skip
    parts = mockup.parts
    assert len(parts) == mockup.part_count == 3
    assert parts[0] == Part(0, "frame", "car/frame", 2, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    assert parts[-1].name == "cover"
    assert parts[1].triangles == 0
    assert np.isnan(parts[1].lower).all() and np.isnan(parts[1].upper).all()
    assert [p.name for p in parts] == [p.name for p in parts[:]] == list(mockup.part_names)
    assert [p.index for p in parts[::2]] == [0, 2]
    assert [p.name for p in parts.find("car/lid")] == ["cover"]
    assert [p.name for p in parts.find("car")] == ["frame", "spare", "cover"]
    assert [p.name for p in parts.find("cover")] == ["cover"]
    assert parts.find("nothing") == parts.find("car/li") == []
    assert mockup.part_of_face.tolist() == [0, 2, 2, 0]
    for index in (3, -4):
        with pytest.raises(IndexError):
            parts[index]


def test_parts_have_names_and_paths_when_none_are_given() -> None:
    assert feeler.Mockup(CORNERS, FACES).part_names == ("part",)
    assert feeler.Mockup(CORNERS, FACES, [0, 1, 1, 2]).part_names == ("part_0", "part_1", "part_2")
    assert feeler.Mockup(CORNERS, FACES, part_paths=["a/b"]).part_names == ("a/b",)
    assert feeler.Mockup(CORNERS, FACES, None, ["x"]).part_paths == ("x",)
    assert feeler.Mockup(CORNERS, FACES, [0, 0, 1, 1], (n for n in ("x", "y"))).part_names == ("x", "y")
    assert feeler.Mockup(CORNERS, FACES, [0, 0, 1, 1], ("same", "same")).part_names == ("same", "same")


def test_part_of_face_of_any_dtype() -> None:
    for dtype in ["i1", "u2", "i8", "u8", ">i4", "f4"]:
        mockup = feeler.Mockup(CORNERS, FACES, np.array([0, 1, 1, 0], dtype=dtype), ["a", "b"])
        assert mockup.part_of_face.tolist() == [0, 1, 1, 0]
        assert mockup.part_of_face.dtype == np.uint32


def test_names_of_parts_cannot_be_changed_or_lose_their_order() -> None:
    mockup, tool = feeler.Mockup(CORNERS, FACES, [0, 0, 1, 1], ["b", "a"]), feeler.Tool(CORNERS, FACES, "w")
    for names in (mockup.part_names, mockup.part_paths, tool.part_names, tool.part_paths):
        assert not hasattr(names, "sort") and not hasattr(names, "append")
    for name in ("part_names", "part_paths"):
        with pytest.raises(feeler.MeshError, match=f"{name} is a set, which has no order: give a list"):
            feeler.Mockup(CORNERS, FACES, [0, 0, 1, 1], **{name: {"a", "b"}})  # type: ignore[arg-type]


def test_a_source_is_a_source() -> None:
    for mesh in (feeler.Mockup(CORNERS, FACES), feeler.Tool(CORNERS, FACES, "w")):
        for wrong in (None, "m", 3):
            with pytest.raises(feeler.OptionError, match=r"source is .*: give a feeler\.types\.Source"):
                mesh.source = wrong  # type: ignore[assignment]
        mesh.source = Source(format="mine")
        assert "mine" in str(mesh.report.source)


class _Refusing:
    """As a tensor of another device, or one that is being learned."""

    def __init__(self, error: type[Exception]) -> None:
        self.error = error

    def __array__(self, dtype: Any = None, copy: Any = None) -> npt.NDArray[Any]:
        raise self.error("no array")


@pytest.mark.parametrize("error", [RuntimeError, TypeError, ValueError])
def test_what_refuses_to_be_an_array_is_an_error_of_ours(error: type[Exception]) -> None:
    wrong: Any = _Refusing(error)
    scene, tool = feeler.Scene(feeler.Mockup(CORNERS, FACES)), feeler.Tool(CORNERS, FACES, "w")
    with pytest.raises(feeler.MeshError, match="vertices cannot be read as an array"):
        feeler.Mockup(wrong, FACES)
    with pytest.raises(feeler.PoseError):
        scene.collide(tool, wrong)
    with pytest.raises(feeler.PoseError):
        scene.collide(tool, (wrong, np.zeros(3)))
    with pytest.raises(feeler.OptionError):
        scene.rays(wrong, [[0.0, 0.0, 1.0]])


def test_subclassing() -> None:
    class Engine(feeler.Mockup):
        """With a maker."""

        def __init__(self, *_: Any, **__: Any) -> None:
            self.maker = "nobody"

    class Wrench(feeler.Tool):
        """Nothing of its own."""

    engine, wrench = Engine(CORNERS, FACES), Wrench(CORNERS, FACES, "w")
    assert (engine.maker, wrench.name) == ("nobody", "w")
    scene = feeler.Scene(engine)
    assert scene.mockup is engine
    assert scene.is_colliding(wrench, np.eye(4))


def test_tools_have_names() -> None:
    assert feeler.Tool(CORNERS, FACES).name == "tool"
    assert "wrench" in repr(feeler.Tool(CORNERS, FACES, name="wrench"))
    assert "4 triangles" in repr(feeler.Mockup(CORNERS, FACES))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("red", "is 'red'"),
        ([[0, 0, 0]], "has shape (1, 3)"),
        (np.zeros((2, 4)), "has shape (2, 4)"),
        (np.zeros((2, 3), complex), "is array"),
        ([["a", "b", "c"]] * 2, "is [["),
        (np.array([[0, 0, 0], [255, 0, 0]], np.uint8), "[1] is [255.0, 0.0, 0.0]: "),
        ([[0, 0, 0], [0, -0.1, 0]], "[1] is [0.0, -0.1, 0.0]"),
        ([[0, np.nan, 0], [0, 0, 0]], "[0] is [0.0, nan, 0.0]"),
    ],
)
def test_colours_are_checked_where_they_are_set(wrong: Any, said: str) -> None:
    mesh = (np.eye(3), [[0, 1, 2]] * 2)
    for made in (feeler.Mockup(*mesh, [0, 1]), feeler.Tool(*mesh, part_of_face=[0, 1])):
        with pytest.raises(feeler.MeshError, match=re.escape(f"part_colours{said if said[0] == '[' else f' {said}'}")):
            made.part_colours = wrong
        assert made.part_colours is None


def test_colours_are_kept_as_a_read_only_copy() -> None:
    mockup = feeler.Mockup(np.eye(3), [[0, 1, 2]] * 2, [0, 1])
    mockup.part_colours = [[1, 0, 0], [np.nan] * 3]
    for colours in (mockup.part_colours, pickle.loads(pickle.dumps(mockup)).part_colours):
        assert np.array_equal(colours, [[1.0, 0.0, 0.0], [np.nan] * 3], equal_nan=True)
        with pytest.raises(ValueError, match="read-only"):
            colours[0] = 255.0
    mockup.part_colours = None
    assert mockup.part_colours is None


def test_all_arrays_of_a_mesh_are_read_only() -> None:
    mesh = (np.eye(3), [[0, 1, 2]])
    for made in (feeler.Mockup(*mesh), feeler.Tool(*mesh)):
        arrays = {name: each for name in dir(made) if isinstance(each := getattr(made, name), np.ndarray)}
        assert {"vertices", "faces", "part_of_face", "bounds", "part_bounds", "part_triangles"} <= set(arrays)
        assert [name for name, array in arrays.items() if array.flags.writeable] == []
