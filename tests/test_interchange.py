"""Mock-ups and tools from meshes of other libraries: trimesh itself, stand-ins with the attributes of the others."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh

import feeler

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = np.concatenate([QUADS[:, :3], QUADS[:, [0, 2, 3]]])


def volume(mesh: feeler.Mockup | feeler.Tool, part: int | None = None) -> float:
    """Positive where the triangles face outwards."""
    faces = mesh.faces if part is None else mesh.faces[mesh.part_of_face == part]
    a, b, c = np.moveaxis(mesh.vertices[faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def bounds(mockup: feeler.Mockup) -> dict[str, list[list[float]]]:
    return {part.path: np.round([part.lower, part.upper], 9).tolist() for part in mockup.parts}


def placed(matrix: Any = None, x: float = 0.0) -> np.ndarray:
    result = np.diag([1.0, 1.0, 1.0, 1.0]) if matrix is None else np.diag([*matrix, 1.0])
    result[0, 3] = x
    return result


# trimesh


def test_a_trimesh_keeps_its_order() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES, process=False, metadata={"name": "cube"})
    for mockup in (feeler.from_trimesh(mesh), feeler.Mockup(mesh)):
        assert np.array_equal(mockup.vertices, CUBE) and np.array_equal(mockup.faces, TRIANGLES)
        assert mockup.part_paths == ("cube",)
        source = mockup.report.source
        assert (source.format, source.unit) == ("trimesh.Trimesh", "m") and "none is stated" in source.unit_source
    tool = feeler.Tool(mesh, name="probe")
    assert tool.name == "probe" and np.array_equal(tool.faces, TRIANGLES) and tool.source.unit == "m"


def test_units_are_the_objects_or_the_callers() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES, process=False)
    for stated, metres in (("mm", 0.001), ("inches", 0.0254), ("meters", 1.0), ("millimeters", 0.001)):
        mesh.units = stated
        mockup = feeler.from_trimesh(mesh)
        assert np.array_equal(mockup.vertices, CUBE * metres) and "stated" in mockup.source.unit_source
        assert np.array_equal(feeler.Tool(mesh).vertices, CUBE * metres)
    given = feeler.from_trimesh(mesh, unit="cm")
    assert np.array_equal(given.vertices, CUBE * 0.01)
    assert given.source.unit_source == "given by unit=, instead of the mm stated"
    assert np.array_equal(feeler.Mockup(mesh, unit="cm").vertices, CUBE * 0.01)
    assert np.array_equal(feeler.Tool(mesh, unit="cm").vertices, CUBE * 0.01)
    for unit in ("parsecs", 1):
        with pytest.raises(feeler.OptionError, match="unit is "):
            feeler.from_trimesh(mesh, unit=unit)  # type: ignore[arg-type]
    mesh.units = "cubits"
    with pytest.raises(feeler.OptionError, match="cubits"):
        feeler.from_trimesh(mesh)
    with pytest.raises(feeler.OptionError, match="arrays are in metres"):
        feeler.Mockup(CUBE, TRIANGLES, unit="mm")
    with pytest.raises(feeler.OptionError, match="arrays are in metres"):
        feeler.Tool(CUBE, TRIANGLES, unit="mm")


def scene() -> trimesh.Scene:
    """One geometry at three places, one of them mirrored, in an assembly; and points, which are no triangles."""
    mesh = trimesh.Trimesh(CUBE, TRIANGLES, process=False)
    made = trimesh.Scene()
    made.add_geometry(mesh, node_name="frame", geom_name="cube")
    made.graph.update("arm", "frame", matrix=placed(x=2), geometry="cube")
    made.graph.update("hand", "arm", matrix=placed((-0.5, 0.5, 0.5), x=3), geometry="cube")
    made.add_geometry(trimesh.PointCloud(CUBE), node_name="dust")
    return made


def test_a_scene_gives_a_part_for_every_place() -> None:
    for mockup in (feeler.from_trimesh(scene()), feeler.Mockup(scene())):
        assert bounds(mockup) == {
            "frame": [[0, 0, 0], [1, 1, 1]],
            "frame/arm": [[2, 0, 0], [3, 1, 1]],
            "frame/arm/hand": [[4.5, 0, 0], [5, 0.5, 0.5]],
        }
        assert mockup.part_names == ("frame", "arm", "hand")
        assert [volume(mockup, part) for part in range(3)] == pytest.approx([1, 1, 0.125]), "none inside out"
        assert any("PointCloud" in note for note in mockup.source.notes)
    assert feeler.Tool(scene()).triangle_count == 36


def test_units_of_a_scene() -> None:
    made = scene()
    made.geometry["cube"].units = "mm"
    assert np.allclose(feeler.from_trimesh(made).bounds, [[0, 0, 0], [0.005, 0.001, 0.001]])
    other = trimesh.Trimesh(CUBE, TRIANGLES, process=False)
    other.units = "inches"
    made.add_geometry(other, node_name="other")
    with pytest.raises(feeler.MeshError, match=r"different units \(in, mm\): bring them to one"):
        feeler.from_trimesh(made)
    assert np.allclose(feeler.from_trimesh(made, unit="m").bounds[1], [5, 1, 1])
    half = {"a": trimesh.Trimesh(CUBE, TRIANGLES), "b": other}
    with pytest.raises(feeler.MeshError, match=r"different units \(in, and none\)"):
        feeler.Mockup(half)


def test_lists_and_dicts_name_their_parts() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES, process=False)
    found = feeler.Mockup({"left": mesh, "right": [mesh, scene()], "a/b": mesh})
    assert list(found.part_paths) == [
        "left",
        "right/part_0",
        "right/part_1/frame",
        "right/part_1/frame/arm",
        "right/part_1/frame/arm/hand",
        "a/b",
    ]
    assert feeler.Tool([mesh, mesh]).triangle_count == 24
    assert feeler.from_trimesh((mesh, mesh)).part_paths == ("part_0", "part_1")


def test_bad_indices_stay_bad_among_several() -> None:
    good = trimesh.Trimesh(CUBE, TRIANGLES, process=False)
    bad = SimpleNamespace(vertices=CUBE, faces=np.array([[0, 1, 2], [0, 1, 8], [-1, 0, 1]]))
    mockup = feeler.Mockup([bad, good])
    assert mockup.report.defects["index_out_of_range"].count == 2
    assert mockup.report.defects["index_out_of_range"].first == (1, 2)
    lost = "2 triangles have a vertex that does not exist or is no finite number, and take part in no query"
    assert mockup.source.doubts == (lost,) and lost in str(mockup.report)
    assert feeler.Tool(mockup).source.doubts == (lost,) and feeler.Mockup([good]).source.doubts == ()


def test_our_own_meshes() -> None:
    made = feeler.Mockup(scene())
    tool = feeler.Tool(made)
    assert np.array_equal(tool.vertices, made.vertices) and np.array_equal(tool.faces, made.faces)
    assert tool.part_paths == made.part_paths
    alone = feeler.Tool(tool.vertices, tool.faces, "alone")
    again = feeler.Mockup({"one": made, "two": alone, "three": tool})
    parts = ["frame", "frame/arm", "frame/arm/hand"]
    assert again.part_paths == (*(f"one/{part}" for part in parts), "two", *(f"three/{part}" for part in parts))
    assert again.triangle_count == 108 and again.parts[1].triangles == 12
    assert feeler.Mockup(made).part_paths == made.part_paths


# PyVista


def padded(cells: Any) -> np.ndarray:
    """As VTK lists cells: the number of corners, then the corners."""
    return np.concatenate([[len(cell), *cell] for cell in cells]).astype(np.int64) if len(cells) else np.empty(0, int)


def poly_data(points: Any = CUBE, faces: Any = QUADS, lines: Any = (), verts: Any = (), strips: Any = ()) -> Any:
    return SimpleNamespace(
        points=np.asarray(points, dtype=np.float32),
        faces=padded(faces),
        lines=padded(lines),
        verts=padded(verts),
        strips=padded(strips),
    )


class MultiBlock:
    """As `pyvista.MultiBlock`: found by number, and it iterates over its blocks."""

    def __init__(self, blocks: dict[str, Any]) -> None:
        self._blocks = blocks
        self.n_blocks = len(blocks)

    def keys(self) -> list[str]:
        return list(self._blocks)

    def __getitem__(self, index: int) -> Any:
        return list(self._blocks.values())[index]

    def __iter__(self) -> Any:
        return iter(self._blocks.values())


class Volume:
    """As a volume of PyVista, whose surface is asked for in one of two ways."""

    def __init__(self) -> None:
        self.points = CUBE
        self.cells = np.array([8, *range(8)])

    def extract_surface(self, *, algorithm: str | None = None) -> Any:
        assert algorithm == "dataset_surface", "newer versions warn without"
        return poly_data()


def test_polygons_of_any_size_become_triangles() -> None:
    mockup = feeler.from_pyvista(poly_data())
    assert mockup.triangle_count == 12 and volume(mockup) == pytest.approx(1)
    assert any("6 polygons with more than three corners" in note for note in mockup.source.notes)
    mixed = feeler.from_pyvista(poly_data(faces=[*QUADS[:5].tolist(), *TRIANGLES[[5, 11]].tolist()]))
    assert volume(mixed) == pytest.approx(1)
    # Hollow: a fan from its first corner would lie outside of it.
    hollow = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.2, 0], [0, 2, 0]]
    area = feeler.from_pyvista(poly_data(hollow, [[0, 1, 2, 3, 4]]))
    a, b, c = np.moveaxis(area.vertices[area.faces], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(2.2, abs=1e-6)
    plain = feeler.from_pyvista(poly_data(faces=TRIANGLES))
    assert np.array_equal(plain.faces, TRIANGLES) and not plain.source.notes


def test_strips_keep_their_side() -> None:
    wall = [[i % 8, 8 + i % 8] for i in range(9)]
    ring = [[np.cos(i * np.pi / 4), np.sin(i * np.pi / 4)] for i in range(8)]
    points = [[x, y, z] for z in (1, 0) for x, y in ring]
    strip = [corner for pair in wall for corner in pair]
    mockup = feeler.from_pyvista(poly_data(points, [list(range(8)), list(range(15, 7, -1))], strips=[strip]))
    assert mockup.triangle_count == 16 + 2 * 6
    assert volume(mockup) == pytest.approx(8 * 0.5 * np.sin(np.pi / 4), rel=1e-6)


def test_blocks_are_parts_and_what_has_no_surface_is_counted() -> None:
    line = poly_data(faces=(), lines=[[0, 1]])
    blocks = MultiBlock(
        {"body": poly_data(), "inner": MultiBlock({"core": poly_data(faces=TRIANGLES)}), "gone": None, "line": line}
    )
    for mockup in (feeler.from_pyvista(blocks, unit="mm"), feeler.Mockup(blocks, unit="mm")):
        assert mockup.part_paths == ("body", "inner/core")
        assert np.allclose(mockup.bounds, [[0, 0, 0], [0.001] * 3])
        notes = "; ".join(mockup.source.notes)
        assert "1 empty block" in notes and "1 list of lines" in notes
    with pytest.raises(feeler.MeshError, match=r"no triangle in it \(1 list of lines"):
        feeler.Mockup(line)


def test_a_volume_gives_its_surface() -> None:
    mockup = feeler.from_pyvista(Volume())
    assert volume(mockup) == pytest.approx(1)
    assert any("the surface of a Volume" in note for note in mockup.source.notes)


@pytest.mark.parametrize("faces", [[3, 0, 1], [-1, 0, 1, 2, 3], [4, 0, 1, 2, 3, 3, 0, 1]])
def test_damaged_lists_of_cells_are_refused(faces: list[int]) -> None:
    data = poly_data()
    data.faces = np.array(faces)
    with pytest.raises(feeler.MeshError, match="corners follow"):
        feeler.from_pyvista(data)


def test_objects_of_vtk_are_told_apart() -> None:
    with pytest.raises(feeler.MeshError, match=r"first: pyvista\.wrap"):
        feeler.Mockup(SimpleNamespace(GetNumberOfPoints=lambda: 3))


# Open3D


class Tensor:
    """As a tensor of Open3D, on another device."""

    def __init__(self, values: np.ndarray, device: str = "CUDA:0") -> None:
        self._values, self._device = values, device

    def cpu(self) -> Tensor:
        return Tensor(self._values, "CPU:0")

    def numpy(self) -> np.ndarray:
        assert self._device == "CPU:0"
        return self._values


def test_open3d_of_either_api() -> None:
    plain = SimpleNamespace(vertices=CUBE.tolist(), triangles=TRIANGLES.tolist())
    tensors = SimpleNamespace(vertex={"positions": Tensor(CUBE)}, triangle={"indices": Tensor(TRIANGLES)})
    for mesh in (plain, tensors):
        for mockup in (feeler.from_open3d(mesh), feeler.Mockup(mesh)):
            assert np.array_equal(mockup.vertices, CUBE) and np.array_equal(mockup.faces, TRIANGLES)
        assert feeler.Tool(mesh, unit="mm").bounds[1].tolist() == [0.001] * 3
    model = SimpleNamespace(
        meshes=[SimpleNamespace(mesh=plain, mesh_name="lid"), SimpleNamespace(mesh=tensors, mesh_name="pot")]
    )
    assert feeler.from_open3d({"set": model}).part_paths == ("set/lid", "set/pot")
    with pytest.raises(feeler.MeshError, match="no positions"):
        feeler.from_open3d(SimpleNamespace(vertex={}, triangle={}))


# What is none of them


@pytest.mark.parametrize(
    "held", [3, None, "cube.stl", b"", [], {}, [[0.0, 0, 0]], CUBE, [CUBE], object(), [3], {"a": 3}]
)
def test_other_objects_are_refused_in_words(held: Any) -> None:
    for make in (feeler.Mockup, feeler.Tool, feeler.from_trimesh, feeler.from_pyvista, feeler.from_open3d):
        with pytest.raises(feeler.MeshError, match="give"):
            make(held)


def test_each_function_takes_its_library() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES)
    open3d = SimpleNamespace(vertices=CUBE, triangles=TRIANGLES)
    with pytest.raises(feeler.MeshError, match="an object of pyvista"):
        feeler.from_pyvista(mesh)
    with pytest.raises(feeler.MeshError, match="an object of open3d"):
        feeler.from_open3d(poly_data())
    with pytest.raises(feeler.MeshError, match="an object of trimesh"):
        feeler.from_trimesh(open3d)
    with pytest.raises(feeler.MeshError, match=r"PointCloud .*points or curves"):
        feeler.from_trimesh(trimesh.PointCloud(CUBE))


def test_a_path_names_the_loaders() -> None:
    for held in ("cube.stl", Path("cube.stl")):
        with pytest.raises(feeler.MeshError, match=r"feeler\.load_mockup"):
            feeler.Mockup(held)


def test_arrays_beside_a_mesh_object_are_refused() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES)
    with pytest.raises(feeler.MeshError, match="part_of_face, part_names without faces"):
        feeler.Mockup(mesh, None, np.zeros(12, dtype=int), ["a"])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (CUBE[:, :2], TRIANGLES, r"a: its vertices have shape \(8, 2\)"),
        (CUBE, QUADS, r"a: its faces have shape \(6, 4\)"),
        (CUBE, TRIANGLES + 0.5, r"dtype float64: \(n, 3\) whole numbers are needed"),
        (CUBE.astype(complex), TRIANGLES, "real"),
        ([[0, 0, 0], [1]], TRIANGLES, "cannot be read"),
    ],
)
def test_meshes_that_are_none(vertices: Any, faces: Any, message: str) -> None:
    held = SimpleNamespace(vertices=vertices, faces=faces)
    with pytest.raises(feeler.MeshError, match=message):
        feeler.Mockup({"a": held})


def test_placements_that_are_none() -> None:
    for matrix in (np.full((4, 4), np.nan), np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1.0, 1]])):
        graph = SimpleNamespace(nodes_geometry=["n"], base_frame="world")
        graph = type("Graph", (), {"nodes_geometry": ["n"], "__getitem__": lambda self, n, m=matrix: (m, "g")})()
        held = SimpleNamespace(graph=graph, geometry={"g": SimpleNamespace(vertices=CUBE, faces=TRIANGLES)})
        with pytest.raises(feeler.MeshError, match="n: its placement"):
            feeler.from_trimesh(held)


def test_what_holds_itself_ends() -> None:
    held: list[Any] = []
    held.append(held)
    with pytest.raises(feeler.MeshError, match="contain itself"):
        feeler.Mockup(held)
    blocks = MultiBlock({})
    blocks._blocks["self"] = blocks
    with pytest.raises(feeler.MeshError, match="contain itself"):
        feeler.Mockup(blocks)


def test_faces_of_whole_floats_are_faces() -> None:
    mesh = SimpleNamespace(vertices=CUBE, faces=TRIANGLES.astype(float))
    assert feeler.Mockup(mesh).triangle_count == len(TRIANGLES)


def test_names_that_are_odd() -> None:
    mesh = trimesh.Trimesh(CUBE, TRIANGLES)
    mockup = feeler.Mockup({"a\x1b[31m": mesh, "": mesh, "x" * 500: mesh})
    assert mockup.part_paths == ("a[31m", "part", "x" * 200)
