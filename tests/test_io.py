"""Loading good files: every format, names, paths, instances, units, several files, reports."""

from __future__ import annotations

import base64
import importlib.util
import json
import os
import struct
from pathlib import Path

import numpy as np
import pytest
from test_io_builders import (
    CORNERS,
    FACES,
    SOUP,
    Gltf,
    obj_text,
    off_text,
    ply,
    stl_binary,
    stl_text,
    threemf,
    threemf_components,
    threemf_mesh,
    zipped,
)

from feeler import MissingFileError, Mockup, OptionError
from feeler.io import KNOWN_UNITS, load_mockup, load_tool


def save(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def soup(mockup: Mockup) -> np.ndarray:
    """The corners of every triangle, (m, 3, 3), metres."""
    return mockup.vertices[mockup.faces]


def names(mockup: Mockup) -> list[str]:
    return [part.name for part in mockup.parts]


def paths(mockup: Mockup) -> list[str]:
    return [part.path for part in mockup.parts]


# --- STL ---------------------------------------------------------------------------------------------------------


def test_binary_stl_keeps_every_corner_and_shares_equal_ones(tmp_path):
    values = np.array([[0.1, 0.2, 0.3], [1 / 3, -0.0, 7.5], [1e-7, 1e7, 2.0]], dtype=np.float32)
    triangles = np.stack([values, values[[1, 0, 2]]])
    mockup = load_mockup(save(tmp_path, "part.stl", stl_binary(triangles)))
    assert len(mockup.vertices) == 3
    # The arithmetic that the documentation promises: float32 -> float64 -> times 0.001.
    assert np.array_equal(soup(mockup), triangles.astype(np.float64) * 0.001)
    assert names(mockup) == ["part"] and paths(mockup) == ["part"]
    assert mockup.report.source.format == "STL"
    assert mockup.report.source.unit == "mm" and "assumed" in mockup.report.source.unit_source


def test_binary_stl_whose_header_says_solid(tmp_path):
    path = save(tmp_path, "part.stl", stl_binary(header=b"solid something facet normal"))
    assert np.array_equal(soup(load_mockup(path)), SOUP * 0.001)


def test_bytes_after_a_binary_stl_are_noted(tmp_path):
    mockup = load_mockup(save(tmp_path, "part.stl", stl_binary() + b"tail"))
    assert mockup.triangle_count == 4
    assert any("4 bytes after the last triangle" in note for note in mockup.report.source.notes)


def test_a_binary_stl_that_counts_too_few_triangles_is_in_doubt(tmp_path):
    content = bytearray(stl_binary())
    content[80:84] = (3).to_bytes(4, "little")
    mockup = load_mockup(save(tmp_path, "part.stl", bytes(content)))
    assert mockup.triangle_count == 3
    assert any("50 bytes after the last triangle" in doubt for doubt in mockup.report.source.doubts)


@pytest.mark.parametrize("tail", [stl_binary(), b"x" * 83, b"x" * 149])
def test_bytes_that_can_hold_triangles_are_a_doubt(tmp_path, tail):
    """As where two exports were joined to one file."""
    mockup = load_mockup(save(tmp_path, "part.stl", stl_binary() + tail))
    assert mockup.triangle_count == 4
    (doubt,) = mockup.report.source.doubts
    assert f"{len(tail)} bytes after the last triangle were ignored: the header says 4 triangles" in doubt


def polygon_text(name, points):
    count = len(points)
    corners = "".join(f"{x} {y} 0\n" for x, y in points)
    indices = " ".join(map(str, range(count)))
    return {
        "a.obj": "".join(f"v {line}\n" for line in corners.splitlines())
        + f"f {' '.join(str(i + 1) for i in range(count))}\n",
        "a.off": f"OFF {count} 1 0\n{corners}{count} {indices}\n",
        "a.ply": f"ply\nformat ascii 1.0\nelement vertex {count}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face 1\nproperty list uchar int vertex_indices\nend_header\n{corners}{count} {indices}\n",
    }[name]


PENTAGON = [(np.cos(0.4 * np.pi * i), np.sin(0.4 * np.pi * i)) for i in range(5)]


@pytest.mark.parametrize(
    ("points", "crosses"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], True),
        ([(0, 0), (1, 1), (1, 0), (0, 0.4)], True),
        ([PENTAGON[2 * i % 5] for i in range(5)], True),
        ([(0, 0), (1, 0), (1, 1), (0, 1)], False),
        ([(0, 0), (2, 1), (0, 2), (0.5, 1)], False),
        (PENTAGON, False),
    ],
    ids=["bow tie", "uneven bow tie", "pentagram", "square", "dart", "pentagon"],
)
@pytest.mark.parametrize("name", ["a.obj", "a.off", "a.ply"])
def test_polygons_that_cross_themselves_are_counted(tmp_path, name, points, crosses):
    source = load_mockup(save(tmp_path, name, polygon_text(name, points))).report.source
    assert any("1 polygon crosses itself: triangles of such" in line for line in source.doubts) == crosses, source


def test_text_stl_has_a_part_for_every_solid(tmp_path):
    text = stl_text({"left side": SOUP, "right/side": SOUP[:1] + 1.0, "": SOUP[:2] - 1.0, "empty": SOUP[:0]})
    mockup = load_mockup(save(tmp_path, "two.stl", text), unit="m")
    assert names(mockup) == ["left side", "right/side", "solid 3"]
    assert paths(mockup) == ["two/left side", "two/right_side", "two/solid 3"]
    assert [part.triangles for part in mockup.parts] == [4, 1, 2]
    assert np.array_equal(soup(mockup), np.concatenate([SOUP, SOUP[:1] + 1.0, SOUP[:2] - 1.0]))
    assert any("1 of 4 solids hold no triangle" in note for note in mockup.report.source.notes)


def test_text_stl_in_capitals_with_windows_line_ends(tmp_path):
    text = stl_text().upper().replace("\n", "\r\n")
    assert np.array_equal(soup(load_mockup(save(tmp_path, "a.STL", text))), SOUP * 0.001)


def test_text_stl_with_old_mac_line_ends(tmp_path):
    assert load_mockup(save(tmp_path, "a.stl", stl_text().replace("\n", "\r"))).triangle_count == 4


def test_text_stl_over_many_chunks(tmp_path, monkeypatch):
    monkeypatch.setattr("feeler.io.text.CHUNK_BYTES", 100)
    mockup = load_mockup(save(tmp_path, "a.stl", stl_text({"one": SOUP, "two": SOUP + 3.0})))
    assert names(mockup) == ["one", "two"]
    assert np.array_equal(soup(mockup), np.concatenate([SOUP, SOUP + 3.0]) * 0.001)


def test_text_stl_with_nan_and_inf_keeps_those_triangles(tmp_path):
    bad = SOUP.copy()
    bad[1, 0, 0], bad[2, 1, 1] = np.nan, -np.inf
    mockup = load_mockup(save(tmp_path, "a.stl", stl_text({"x": bad})))
    assert mockup.triangle_count == 4
    assert mockup.report.defects["non_finite"].first == (1, 2)


# --- OBJ ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("chunk_bytes", [None, 60])
def test_obj_objects_and_groups_are_parts(tmp_path, monkeypatch, chunk_bytes):
    if chunk_bytes:
        monkeypatch.setattr("feeler.io.text.CHUNK_BYTES", chunk_bytes)
    mockup = load_mockup(save(tmp_path, "model.obj", obj_text()), unit="m")
    assert names(mockup) == ["left side", "right", "plate"]
    assert paths(mockup) == ["model/frame/left side", "model/frame/right", "model/plate"]
    plate = np.array([[0, 0, 5.0], [1, 0, 5], [1, 1, 5], [0, 1, 5]])
    expected = [*SOUP[:2], CORNERS[[1, 2, 3]], plate[[0, 1, 2]], plate[[0, 2, 3]]]
    assert np.array_equal(soup(mockup), np.array(expected))
    notes = " ".join(mockup.report.source.notes)
    assert "1 polygon with more than three corners" in notes
    assert "1 point was skipped" in notes and "1 line was skipped" in notes


def test_obj_objects_and_groups_hold_until_the_next_of_their_kind(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    text = corners + "g bolt_1\no mesh\nf 1 2 3\ng bolt_2\no mesh\nf 1 3 2\no other\nf 2 3 1\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert paths(mockup) == ["m/mesh/bolt_1", "m/mesh/bolt_2", "m/other/bolt_2"]


def test_obj_group_named_again_is_the_same_part(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\ng b\nf 1 3 2\ng a\nf 2 3 1\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert names(mockup) == ["a", "b"] and mockup.part_of_face.tolist() == [0, 1, 0]


def test_obj_without_names_takes_the_name_of_the_file(tmp_path):
    mockup = load_mockup(save(tmp_path, "plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n 3\n"))
    assert names(mockup) == ["plain"] and paths(mockup) == ["plain"]


def test_obj_indices_out_of_range_stay_and_are_counted(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\nf 0 1 2\nf -9 1 2\nf 99999999999999999999 1 2\nf 1 2\nf\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert mockup.triangle_count == 5
    assert mockup.report.defects["index_out_of_range"].first == (1, 2, 3, 4)
    assert any("2 faces with fewer than three corners" in n and "line 9" in n for n in mockup.report.source.notes)


@pytest.mark.parametrize("turn", range(4))
def test_a_hollow_quad_is_cut_along_the_right_diagonal(tmp_path, turn):
    corners = np.roll(np.array([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], dtype=float), turn, axis=0)
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in corners.tolist())
    mockup = load_mockup(save(tmp_path, "m.obj", rows + "f 1 2 3 4\n"), unit="m")
    assert total_area(soup(mockup)) == pytest.approx(4.0)  # a fan over the wrong diagonal covers more


def test_a_hollow_polygon_is_cut_into_ears(tmp_path):
    comb = np.array([[0, 0], [7, 0], [7, 5], [6, 5], [6, 1], [4, 1], [4, 5], [3, 5], [3, 1], [1, 1], [1, 5], [0, 5]])
    for order, lift in (((0, 1), False), ((1, 0), True)):
        flat = comb[:, order] * 1.0
        points = np.insert(flat, 1 if lift else 2, 0.25, axis=1)
        rows = "".join(f"v {x} {y} {z}\n" for x, y, z in points.tolist())
        mockup = load_mockup(save(tmp_path, "m.obj", rows + "f " + " ".join(map(str, range(1, 13))) + "\n"), unit="m")
        assert mockup.triangle_count == 10
        assert total_area(soup(mockup)) == pytest.approx(7 + 3 * 4)


def total_area(triangles: np.ndarray) -> float:
    edges = triangles[:, 1:] - triangles[:, :1]
    return float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum() / 2)


# --- OFF and PLY -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("header", ["OFF\n4 4 6\n", "OFF 4 4 6\n", "COFF\n# c\n4 4\n"])
def test_off(tmp_path, header):
    text = off_text().split("\n", 3)[3]
    mockup = load_mockup(save(tmp_path, "t.off", header + text))
    assert np.array_equal(soup(mockup), SOUP * 0.001)
    assert paths(mockup) == ["t"]


@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply(tmp_path, encoding, extra):
    mockup = load_mockup(save(tmp_path, "t.ply", ply(encoding, extra_face_values=extra)))
    assert np.array_equal(soup(mockup), SOUP * 0.001)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_with_polygons_of_several_sizes(tmp_path, encoding):
    mockup = load_mockup(
        save(tmp_path, "t.ply", ply(encoding, [[0, 1, 2, 3], [0, 1], [0, 1, 2], [1, 2, 77]])), unit="m"
    )
    assert mockup.triangle_count == 4
    assert mockup.report.defects["index_out_of_range"].first == (3,)
    notes = " ".join(mockup.report.source.notes)
    assert "1 polygon with more than three corners" in notes and "1 face with fewer than three" in notes


def test_ply_triangle_strips(tmp_path):
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
    head += b"property float x\nproperty float y\nproperty float z\n"
    head += b"element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    strip = [0, 1, 2, 3, -1, 1, 2, 3]
    path = save(tmp_path, "t.ply", head + CORNERS.astype("<f4").tobytes() + struct.pack("<9i", len(strip), *strip))
    assert load_mockup(path).faces.tolist() == [[0, 1, 2], [2, 1, 3], [1, 2, 3]]


# --- glTF --------------------------------------------------------------------------------------------------------


def assembly() -> Gltf:
    """A mesh used three times: below a node that moves, on a turned node, and scaled by a matrix."""
    g = Gltf()
    mesh = g.mesh(name="bolt")
    leaf = g.node(is_root=False, mesh=mesh, translation=[1, 2, 3])
    turned = g.node(is_root=False, mesh=mesh, name="turned", rotation=[0, 0, 2**-0.5, 2**-0.5], scale=[2, 1, 1])
    g.node(name="fan/blade", children=[leaf, turned], translation=[100, 0, 0])
    g.node(name="turned", mesh=mesh, matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5, 0, 0, 0, 7, 1])
    g.node(name="turned", mesh=mesh)
    return g


def test_glb_instances_are_parts_with_transforms_names_and_paths(tmp_path):
    mockup = load_mockup(save(tmp_path, "engine.glb", assembly().glb()))
    assert names(mockup) == ["bolt", "turned", "turned", "turned"]
    assert paths(mockup) == [
        "engine/fan_blade/bolt", "engine/fan_blade/turned", "engine/turned", "engine/turned#2",
    ]  # fmt: skip
    first, second, third, fourth = soup(mockup).reshape(4, 4, 3, 3)
    assert np.array_equal(first, np.add(SOUP, [101, 2, 3]))
    assert np.allclose(second, np.stack([-SOUP[..., 1] + 100, 2 * SOUP[..., 0], SOUP[..., 2]], axis=-1), atol=1e-12)
    assert np.array_equal(third, SOUP * [1, 1, 0.5] + [0, 0, 7])
    assert np.array_equal(fourth, SOUP)
    assert mockup.report.source.unit == "m" and "always" in mockup.report.source.unit_source


@pytest.mark.parametrize("how", ["data", "file", "file with a space"])
def test_gltf_with_its_buffer_elsewhere(tmp_path, how):
    g = assembly()
    save(tmp_path, "sub/the data.bin", g.blob)
    save(tmp_path, "data.bin", g.blob)
    uri = "data:application/octet-stream;base64," + base64.b64encode(g.blob).decode()
    uri = {"data": uri, "file": "data.bin", "file with a space": "sub/the%20data.bin"}[how]
    mockup = load_mockup(save(tmp_path, "engine.gltf", g.gltf(uri)))
    assert mockup.triangle_count == 16 and mockup.part_count == 4


def test_gltf_strips_fans_points_and_lines(tmp_path):
    g = Gltf()
    for mode in (5, 6, 0, 1):
        g.node(mesh=g.mesh(indices=np.arange(4), mode=mode), name=f"mode {mode}")
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert names(mockup) == ["mode 5", "mode 6"]
    expected = CORNERS[[[0, 1, 2], [1, 3, 2], [1, 2, 0], [2, 3, 0]]]
    assert np.array_equal(soup(mockup), expected)
    notes = " ".join(mockup.report.source.notes)
    assert "1 primitive of points" in notes and "1 primitive of lines" in notes


def test_gltf_without_indices_and_with_small_ones(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(SOUP.reshape(-1, 3), None), name="soup")
    small = g.mesh()
    g.root["meshes"][small]["primitives"][0]["indices"] = g.accessor(FACES.astype("u1").ravel(), "SCALAR")
    g.node(mesh=small, name="bytes")
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert np.array_equal(soup(mockup), np.concatenate([SOUP, SOUP]))
    assert len(mockup.vertices) <= 16


def test_gltf_index_out_of_range_stays_out_of_range(tmp_path):
    g = Gltf()
    wrong = FACES.copy()
    wrong[1, 2] = 4  # would be the first vertex of the next mesh
    g.node(mesh=g.mesh(indices=wrong))
    g.node(mesh=g.mesh())
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert mockup.triangle_count == 8
    assert mockup.report.defects["index_out_of_range"].first == (1,)


def test_gltf_sparse_interleaved_and_quantised_accessors(tmp_path):
    g = Gltf()
    mesh = g.mesh()
    # Interleaved: each corner followed by twelve bytes of something else.
    rows = np.zeros((4, 6), dtype="<f4")
    rows[:, :3] = CORNERS
    g.root["accessors"][0]["bufferView"] = g.view(rows.tobytes(), stride=24)
    # Sparse: corner 3 is replaced.
    at, new = g.view(np.array([3], dtype="<u2").tobytes()), g.view(np.array([[1, 1, 1]], dtype="<f4").tobytes())
    sparse = {"count": 1, "indices": {"bufferView": at, "componentType": 5123}, "values": {"bufferView": new}}
    g.root["accessors"][0]["sparse"] = sparse
    g.node(mesh=mesh)
    # Quantised (KHR_mesh_quantization): int16, normalised, in a stride of eight bytes.
    shorts = np.zeros((4, 4), dtype="<i2")
    shorts[:, :3] = [[0, 0, 0], [32767, 0, 0], [0, 32767, 0], [0, 0, -32768]]
    quantised = g.mesh()
    position = g.root["meshes"][quantised]["primitives"][0]["attributes"]["POSITION"]
    view = g.view(shorts.tobytes(), stride=8)
    g.root["accessors"][position] = {
        "bufferView": view, "componentType": 5122, "normalized": True, "count": 4, "type": "VEC3",
    }  # fmt: skip
    g.node(mesh=quantised)
    g.root["extensionsUsed"] = g.root["extensionsRequired"] = ["KHR_mesh_quantization"]
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    changed = CORNERS.copy()
    changed[3] = 1
    assert np.array_equal(soup(mockup)[:4], changed[FACES])
    assert np.array_equal(soup(mockup)[4:], np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1.0]])[FACES])


def test_gltf_primitives_that_share_one_accessor_take_what_they_use(tmp_path):
    g = Gltf()
    many = np.concatenate([CORNERS + 100 * i for i in range(50)])
    shared = g.accessor(many.astype("<f4"), "VEC3")
    primitives = [
        {"attributes": {"POSITION": shared}, "indices": g.accessor((FACES + 4 * i).astype("<u4").ravel(), "SCALAR")}
        for i in range(50)
    ]
    g.root["meshes"].append({"primitives": primitives, "name": "all"})
    g.node(mesh=0)
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert mockup.part_count == 1 and len(mockup.vertices) == 200
    assert np.array_equal(soup(mockup), many[np.concatenate([FACES + 4 * i for i in range(50)])])


def test_gltf_gpu_instancing(tmp_path):
    g = Gltf()
    moves = g.accessor(np.array([[1, 0, 0], [0, 2, 0]], dtype="<f4"), "VEC3")
    g.node(mesh=g.mesh(), name="bolt", extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}})
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert paths(mockup) == ["m/bolt/bolt", "m/bolt/bolt#2"]
    assert np.array_equal(soup(mockup), np.concatenate([np.add(SOUP, [1, 0, 0]), np.add(SOUP, [0, 2, 0])]))


def test_gltf_notes_what_is_not_in_the_scene(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(), name="in")
    g.node(is_root=False, mesh=0, name="out")
    mockup = load_mockup(save(tmp_path, "m.glb", g.glb()))
    assert names(mockup) == ["in"]
    assert any("1 node with a mesh is not in the scene" in note for note in mockup.report.source.notes)
    g.root["meshes"].append({**g.root["meshes"][0], "name": "spare"})
    notes = load_mockup(save(tmp_path, "b.glb", g.glb())).report.source.notes
    assert "1 mesh is in no node and was left out ('spare')" in notes


# --- 3MF ---------------------------------------------------------------------------------------------------------


def test_3mf_items_components_transforms_and_unit(tmp_path):
    resources = threemf_mesh(1, "bolt") + threemf_components(2, "pair", [(1, ""), (1, "0 1 0 -1 0 0 0 0 1 5 6 7")])
    items = '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 100 0 0"/><item objectid="1" partnumber="P-7"/>'
    mockup = load_mockup(save(tmp_path, "build.3mf", threemf(resources, items)))
    assert names(mockup) == ["bolt", "bolt", "P-7"]
    assert paths(mockup) == ["build/pair/bolt", "build/pair/bolt#2", "build/P-7"]
    turned = np.stack([-SOUP[..., 1] + 105, SOUP[..., 0] + 6, SOUP[..., 2] + 7], axis=-1)
    assert np.array_equal(soup(mockup), np.concatenate([np.add(SOUP, [100, 0, 0]), turned, SOUP]) * 0.0254)
    assert mockup.report.source.unit == "in" and "stated" in mockup.report.source.unit_source


def test_3mf_with_models_in_several_files(tmp_path):
    core = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'
    production = 'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'
    root = (
        f'<model {core} {production}><resources/><build><item objectid="5" p:path="/3D/other.model"/></build></model>'
    )
    other = f"<model {core}><resources>{threemf_mesh(5, 'far')}</resources><build/></model>"
    relations = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/start.model"/></Relationships>'
    )
    members = {"_rels/.rels": relations, "3D/start.model": root, "3D/other.model": other}
    path = save(tmp_path, "b.3mf", zipped({name: text.encode() for name, text in members.items()}))
    mockup = load_mockup(path)
    assert names(mockup) == ["far"] and mockup.report.source.unit == "mm"


# --- STEP --------------------------------------------------------------------------------------------------------

needs_step = pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")


@needs_step
def test_step_assembly_in_millimetres(testdata):
    seen: list[tuple[float, str]] = []
    mockup = load_mockup(testdata / "meshes" / "assembly.step", progress=lambda f, stage: seen.append((f, stage)))
    assert names(mockup) == ["base", "pin", "pin"]
    # "pins" is placed by an occurrence without a name; the converter would call it by its number.
    assert paths(mockup) == ["assembly/press/base", "assembly/press/pins/pin", "assembly/press/pins/pin#2"]
    assert np.allclose(mockup.bounds, [[0, 0, 0], [0.040, 0.020, 0.022]], atol=1e-8)
    assert np.allclose(mockup.parts[2].lower, [0.027, 0.007, 0.010], atol=1e-4)
    assert mockup.report.source.unit == "mm" and "stated" in mockup.report.source.unit_source
    assert any("chord tolerance 0.0001 m" in note for note in mockup.report.source.notes)
    assert any("triangulating" in stage for _, stage in seen)


@needs_step
def test_step_chord_tolerance_is_kept_in_metres(testdata):
    path = testdata / "meshes" / "assembly.step"
    fine = load_mockup(path, chord_tolerance=2e-6)
    coarse = load_mockup(path, chord_tolerance=1e-3)
    assert fine.triangle_count > 2 * coarse.triangle_count
    for mockup, tolerance in ((fine, 2e-6), (coarse, 1e-3)):
        # The middle of every edge on the rim of the first pin is at most the tolerance inside the true radius.
        triangles = soup(mockup)[mockup.part_of_face == 1]
        middles = (triangles + np.roll(triangles, 1, axis=1)) / 2 - [0.010, 0.010, 0]
        radius = np.linalg.norm(middles[..., :2], axis=-1)
        side = (
            np.abs(
                np.linalg.norm(
                    np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[:, 2:], axis=1
                )
            )
            < 1e-12
        )
        assert (0.003 - radius[side]).max() <= tolerance + 1e-8


@needs_step
@pytest.mark.parametrize(("stated", "metres"), [("in", 0.0254), ("m", 1.0)])
def test_step_in_other_units(tmp_path, testdata, stated, metres):
    text = (testdata / "meshes" / "assembly.step").read_text()
    if stated == "in":
        text = text.replace(
            "LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.)",
            "CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9003)",
        )
        inch = (
            "#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9002);\n"
            "#9002 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );\n"
            "#9003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\nENDSEC;\nEND-ISO"
        )
        text = text.replace("ENDSEC;\nEND-ISO", inch)
    else:
        text = text.replace(".MILLI.", "$")
    path = save(tmp_path, "a.step", text)
    mockup = load_mockup(path)
    assert mockup.report.source.unit == stated
    assert np.allclose(mockup.bounds[1], np.array([40, 20, 22]) * metres, rtol=1e-6)
    given = load_mockup(path, unit="cm")
    assert np.allclose(given.bounds[1], [0.4, 0.2, 0.22], rtol=1e-6)
    assert "instead of the" in given.report.source.unit_source


def test_the_step_file_is_what_its_script_writes(tmp_path, testdata, monkeypatch):
    script = testdata / "meshes" / "make_step.py"
    spec = importlib.util.spec_from_file_location("make_step", script)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "__file__", str(tmp_path / "make_step.py"))
    module.main()
    assert (tmp_path / "assembly.step").read_bytes() == (script.parent / "assembly.step").read_bytes()


# --- COLLADA -----------------------------------------------------------------------------------------------------


def collada_text() -> str:
    numbers = " ".join(str(v) for v in CORNERS.ravel())
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="bolt"><mesh>
<source id="s"><float_array id="a" count="12">{numbers}</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(map(str, FACES.ravel()))}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="vs"><node id="n1" name="left"><translate>1 2 3</translate>
<instance_geometry url="#g"/></node><node id="n2" name="right"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#vs"/></scene></COLLADA>"""


def test_collada(tmp_path):
    mockup = load_mockup(save(tmp_path, "tool.dae", collada_text()))
    assert paths(mockup) == ["tool/left/bolt", "tool/right/bolt"]
    assert np.array_equal(soup(mockup), np.concatenate([np.add(SOUP, [1, 2, 3]), SOUP]) * 0.0254)
    assert mockup.report.source.unit == "inch"


# --- units, several files, tools -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("m", 1.0), ("mm", 0.001), ("cm", 0.01), ("in", 0.0254), ("Inch", 0.0254), ("ft", 0.3048), (" MM ", 0.001),
     ("millimetres", 0.001), ("um", 1e-6), ("µm", 1e-6)],
)  # fmt: skip
def test_unit_names(tmp_path, unit, metres):
    mockup = load_mockup(save(tmp_path, "p.stl", stl_binary()), unit=unit)
    assert np.array_equal(soup(mockup), SOUP * metres)
    assert mockup.report.source.unit_source == "given"


@pytest.mark.parametrize("unit", ["parsec", "", 5, "m m"])
def test_unknown_unit_lists_the_known(tmp_path, unit):
    with pytest.raises(OptionError) as error:
        load_mockup(save(tmp_path, "p.stl", stl_binary()), unit=unit)
    assert str(error.value).endswith("choose " + ", ".join(KNOWN_UNITS))


@pytest.mark.parametrize("tolerance", [0, 1e-12, -1.0, float("nan"), float("inf"), "fine", True])
def test_wrong_chord_tolerance(tmp_path, tolerance):
    with pytest.raises(OptionError, match="chord_tolerance"):
        load_mockup(save(tmp_path, "p.stl", stl_binary()), chord_tolerance=tolerance)


def test_chord_tolerance_without_step_is_noted(tmp_path):
    mockup = load_mockup(save(tmp_path, "p.stl", stl_binary()), chord_tolerance=1e-3)
    assert any("had no effect" in note for note in mockup.report.source.notes)


def test_given_unit_counts_more_than_the_stated_one(tmp_path):
    mockup = load_mockup(save(tmp_path, "p.glb", assembly().glb()), unit="mm")
    assert np.array_equal(soup(mockup)[12:], SOUP * 0.001)
    assert "instead of the m" in mockup.report.source.unit_source


def test_a_folder_is_one_mockup_sorted_with_subfolders(tmp_path):
    save(tmp_path, "b.stl", stl_binary())
    save(tmp_path, "a.stl", stl_text({"x": SOUP + 1}))
    save(tmp_path, "a.obj", obj_text())
    save(tmp_path, "sub/deep/c.glb", assembly().glb())
    save(tmp_path, "sub/readme.txt", "hello")
    save(tmp_path, "notes.md", "hello")
    save(tmp_path, "empty.stl", stl_text({"nothing": SOUP[:0]}))
    save(tmp_path, ".hidden.stl", b"broken")
    save(tmp_path, ".git/x.stl", b"broken")
    seen: list[float] = []
    mockup = load_mockup(tmp_path, progress=lambda fraction, stage: seen.append(fraction))
    assert paths(mockup) == [
        "a/frame/left side", "a/frame/right", "a/plate", "a#2/x", "b",
        "sub/deep/c/fan_blade/bolt", "sub/deep/c/fan_blade/turned", "sub/deep/c/turned", "sub/deep/c/turned#2",
    ]  # fmt: skip
    assert mockup.triangle_count == 5 + 4 + 4 + 16
    assert np.array_equal(soup(mockup)[5:9], (SOUP + 1) * 0.001)
    assert np.array_equal(soup(mockup)[-4:], SOUP)  # glTF: metres
    source = mockup.report.source
    assert source.format == "OBJ, STL, glTF" and source.unit == "mm, m"
    assert [Path(f).name for f in source.files] == ["a.obj", "a.stl", "b.stl", "c.glb"]
    notes = " ".join(source.notes)
    assert "2 files of other kinds" in notes and "notes.md, sub/readme.txt" in notes
    assert "empty.stl: the STL file holds no triangle" in notes
    assert seen == sorted(seen) and seen[-1] == 1.0


def test_several_files_in_the_order_given(tmp_path):
    files = [save(tmp_path, "2.stl", stl_binary(SOUP + 1)), save(tmp_path, "1.stl", stl_binary())]
    mockup = load_mockup(files)
    assert paths(mockup) == ["2", "1"] and np.array_equal(soup(mockup)[4:], SOUP * 0.001)
    assert paths(load_mockup([str(files[0]), str(files[0])])) == ["2", "2#2"]


def test_tool(tmp_path):
    path = save(tmp_path, "wrench.obj", obj_text())
    tool = load_tool(path, unit="cm")
    assert tool.name == "wrench" and tool.triangle_count == 5
    assert np.array_equal(tool.vertices[tool.faces][:2], SOUP[:2] * 0.01)
    assert load_tool(path, name="10 mm").name == "10 mm"
    assert tool.report.source.unit == "cm"


def test_report_tells_where_things_came_from(tmp_path):
    mockup = load_mockup(save(tmp_path, "p.stl", stl_binary(np.concatenate([SOUP, SOUP[:1]]))))
    text = str(mockup.report)
    assert "p.stl" in text and "unit mm (assumed: STL has no unit" in text
    assert mockup.report.defects["duplicate"].count == 1
    assert json.loads(json.dumps(mockup.report.to_dict()))["defects"]["duplicate"] == {"count": 1, "first": [4]}
    assert mockup.report.source.seconds > 0


def test_wrong_extension_is_read_by_content_and_noted(tmp_path):
    mockup = load_mockup(save(tmp_path, "really.stl", ply("ascii")))
    assert mockup.report.source.format == "PLY"
    assert any("its content is PLY" in note for note in mockup.report.source.notes)
    assert load_mockup(save(tmp_path, "really2.stl", obj_text())).report.source.format == "OBJ"
    assert load_mockup(save(tmp_path, "noextension", stl_binary())).report.source.format == "STL"
    assert load_mockup(save(tmp_path, "x.obj", assembly().glb())).part_count == 4


def test_path_like_and_unicode_names(tmp_path):
    class Path2(os.PathLike):
        def __fspath__(self) -> str:
            return str(path)

    path = save(tmp_path, "Schraube Größe 5 ✓.stl", stl_binary())
    assert names(load_mockup(Path2())) == ["Schraube Größe 5 ✓"]


def test_names_cannot_steer_a_terminal(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(), name="red\x1b[31m\nalert\ud800")
    name = names(load_mockup(save(tmp_path, "m.glb", g.glb())))[0]
    assert name == "red[31malert?"


# --- real models, where there are some --------------------------------------------------------------------------------

REAL = {
    "axial-compressor-mark1/mark1_simple_coarse.glb": (1_000_182, 856),
    "cylinder2-engine/2CylinderEngine.glb": (121_496, 67),  # 67 nodes with a mesh; they have 115 primitives
    "degenerate/occt_motor.stl": (13_506, 1),
    "degenerate/trimesh_busted.STL": (3_878, 1),
    "degenerate/trimesh_chair_model.obj": (12_756, 4),
    "degenerate/trimesh_P_XPM_0331_01.3mf": (6, 1),
    "degenerate/cgal_diplodocus.off": (47_960, 1),
    "tools-utias/hammer.ply": (115_886, 1),
}


@pytest.mark.parametrize("name", REAL)
def test_real_model(models, name):
    if not (models / name).is_file():
        pytest.skip("not in this folder of models")
    mockup = load_mockup(models / name)
    assert (mockup.triangle_count, mockup.part_count) == REAL[name]


def test_paths_are_echoed_as_they_were_given(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"^http://x/y\.stl: feeler loads nothing from a network"):
        load_mockup("http://x/y.stl")
    with pytest.raises(OptionError, match=r"path is b'a\.stl': give the path of a file"):
        load_mockup(b"a.stl")  # type: ignore[arg-type]
    plain = tmp_path / "plain"
    plain.write_bytes(stl_binary(SOUP))
    assert "plain has no extension, but its content is STL: read as STL" in load_mockup(plain).source.notes[0]
