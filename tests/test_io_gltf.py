"""glTF beyond plain meshes: morphs, skins, instances, hidden nodes, packed geometry, and what is left out."""

from __future__ import annotations

import base64
import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_field_scenes import notes, volumes
from test_io_builders import CORNERS, FACES, SOUP, Gltf

from feeler import LoadError, Mockup
from feeler.io import load_mockup, meshopt, write_glb
from feeler.io.raw import RawMesh

needs_draco = pytest.mark.skipif(importlib.util.find_spec("DracoPy") is None, reason="DracoPy is not installed")
VOLUME = 10 * 20 * 30 / 6  # of the tetrahedron of the builders


def load(folder: Path, g: Gltf) -> Mockup:
    path = folder / "m.glb"
    path.write_bytes(g.glb())
    return load_mockup(path)


def soup(mockup: Mockup) -> np.ndarray:
    return mockup.vertices[mockup.faces]


def names(mockup: Mockup) -> list[str]:
    return [part.name for part in mockup.parts]


def morphing(g: Gltf, weights: list[float] | None) -> int:
    """A mesh with two targets: up by one, along x by ten."""
    mesh = g.mesh(name="soft")
    moves = [np.tile(np.array(move, dtype="<f4"), (4, 1)) for move in ([0, 0, 1], [10, 0, 0])]
    targets = [{"POSITION": g.accessor(move, "VEC3")} for move in moves]
    g.root["meshes"][mesh]["primitives"][0]["targets"] = targets
    if weights is not None:
        g.root["meshes"][mesh]["weights"] = weights
    return mesh


# --- colours ----------------------------------------------------------------------------------------------------

RED, GREY = {"baseColorFactor": [1.0, 0.0, 0.0, 1.0]}, {"baseColorFactor": [0.2158605, 0.2158605, 0.2158605, 1.0]}
NONE = [np.nan] * 3


def painted(folder: Path, *materials: object, **root: object) -> np.ndarray | None:
    """The colours of parts, one for each material's `pbrMetallicRoughness`; None: it names no material."""
    g = Gltf()
    g.root["materials"] = [{"pbrMetallicRoughness": material} for material in materials if material is not None]
    numbers = iter(range(len(materials)))
    for material in materials:
        mesh = g.mesh()
        if material is not None:
            g.root["meshes"][mesh]["primitives"][0]["material"] = next(numbers)
        g.node(mesh=mesh)
    g.root.update(root)
    return load(folder, g).part_colours


def test_base_colours_are_read_as_srgb(tmp_path):
    np.testing.assert_array_equal(painted(tmp_path, RED, GREY, None), [[1, 0, 0], [0.502, 0.502, 0.502], NONE])
    np.testing.assert_array_equal(painted(tmp_path, RED), [[1, 0, 0]])


def test_colours_that_tell_no_part_from_another_are_left_out(tmp_path):
    assert painted(tmp_path, GREY, GREY, GREY) is None
    assert painted(tmp_path, None, None) is None


@pytest.mark.parametrize(
    "material",
    [{}, [], 1, "red", {"baseColorFactor": None}, {"baseColorFactor": [1, 0]}, {"baseColorFactor": ["1", 0, 0, 1]}]
    + [{"baseColorFactor": [level, 0, 0, 1]} for level in (-0.1, 1.1, float("nan"), True, None, [1])]
    + [{"baseColorFactor": [1, 0, 0, 1], "baseColorTexture": {"index": 0}}],
)
def test_a_material_that_states_no_colour_is_no_error(tmp_path, material):
    np.testing.assert_array_equal(painted(tmp_path, RED, material), [[1, 0, 0], NONE])


@pytest.mark.parametrize("materials", [None, 3, {}, [], [7, 8], "ab"])
def test_materials_that_are_damaged_are_no_error(tmp_path, materials):
    assert painted(tmp_path, RED, GREY, materials=materials) is None


def test_a_part_of_several_colours_has_that_of_most_of_it(tmp_path):
    g = Gltf()
    g.root["materials"] = [{"pbrMetallicRoughness": RED}, {"pbrMetallicRoughness": GREY}]
    small, large = g.mesh(indices=FACES[:1]), g.mesh()
    lines = g.mesh(indices=np.tile(FACES, (9, 1)), mode=1)
    primitives = [g.root["meshes"][mesh]["primitives"][0] for mesh in (lines, small, large)]
    for primitive, material in zip(primitives, (0, 0, 1), strict=True):
        primitive["material"] = material
    g.root["meshes"] = [{"primitives": primitives}]
    g.node(mesh=0)
    np.testing.assert_array_equal(load(tmp_path, g).part_colours, [[0.502] * 3])


def test_glb_of_feeler_reads_back_with_its_colours_beside_files_without(tmp_path):
    corners = np.concatenate([CORNERS, CORNERS + 100]).astype(float)
    written = Mockup(corners, np.concatenate([FACES, FACES + 4]), [0] * 4 + [1] * 4, ["a", "b"])
    written.part_colours = np.array([[0.62, 0.65, 0.67], [0.10, 0.10, 0.11]])
    write_glb(tmp_path / "a.glb", written)
    np.testing.assert_array_equal(load_mockup(tmp_path / "a.glb").part_colours, written.part_colours)
    (tmp_path / "b.off").write_text("OFF\n3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n")
    both = load_mockup([tmp_path / "a.glb", tmp_path / "b.off"])
    np.testing.assert_array_equal(both.part_colours, [*written.part_colours, NONE])


# --- transforms --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("outer", "inner", "mirrored"), [(-1, 1, True), (1, -1, True), (-1, -1, False)])
def test_mirrored_once_and_twice(tmp_path, outer, inner, mirrored):
    g = Gltf()
    leaf = g.node(is_root=False, mesh=g.mesh(), scale=[1, inner, 1])
    g.node(children=[leaf], scale=[outer, 1, 1])
    mockup = load(tmp_path, g)
    assert volumes(mockup) == pytest.approx([VOLUME])
    assert (mockup.faces.tolist() != FACES.tolist()) == mirrored


def test_instances_that_are_mirrored_and_turned_by_small_integers(tmp_path):
    """Scale -1 is in the accessor; a rotation in bytes is not of length one, and must not scale the part."""
    g = Gltf()
    turn = np.array([[0, 0, 90, 90], [0, 0, 0, 127]], dtype="i1")
    view = g.view(turn.tobytes())
    g.root["accessors"].append(
        {"bufferView": view, "componentType": 5120, "normalized": True, "count": 2, "type": "VEC4"}
    )
    spread = {
        "ROTATION": len(g.root["accessors"]) - 1,
        "SCALE": g.accessor(np.array([[1, 1, 1], [1, 1, -1]], dtype="<f4"), "VEC3"),
    }
    g.node(mesh=g.mesh(), extensions={"EXT_mesh_gpu_instancing": {"attributes": spread}})
    mockup = load(tmp_path, g)
    turned = np.stack([-SOUP[..., 1], SOUP[..., 0], SOUP[..., 2]], axis=-1)
    assert np.allclose(soup(mockup)[:4], turned, atol=1e-12)
    assert volumes(mockup) == pytest.approx([VOLUME, VOLUME], rel=1e-12)


def test_a_rotation_of_length_zero_is_refused(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(), rotation=[0, 0, 0, 0])
    with pytest.raises(LoadError, match=r"nodes\[0\] has a rotation of length zero"):
        load(tmp_path, g)


# --- morph targets, skins, animations ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("of_mesh", "of_node", "move"),
    [
        ([1.0, 0.5], None, [5, 0, 1]),
        ([1.0, 0.5], [0.0, 2.0], [20, 0, 0]),
        (None, [0.25, 0.0], [0, 0, 0.25]),
        (None, None, [0, 0, 0]),
        ([2.0], None, [0, 0, 2]),
    ],
)
def test_morph_weights(tmp_path, of_mesh, of_node, move):
    g = Gltf()
    node: dict[str, Any] = {"mesh": morphing(g, of_mesh)}
    g.node(**node | ({} if of_node is None else {"weights": of_node}))
    mockup = load(tmp_path, g)
    assert np.array_equal(soup(mockup), SOUP + move)
    assert "1 mesh has morph targets" in notes(mockup)
    assert ("more or fewer weights" in notes(mockup)) == (of_mesh == [2.0])


def test_one_mesh_with_other_weights_on_each_node(tmp_path):
    g = Gltf()
    mesh = morphing(g, [1.0, 0.0])
    g.node(mesh=mesh)
    g.node(mesh=mesh, weights=[0.0, 1.0])
    assert np.array_equal(soup(load(tmp_path, g)), np.concatenate([np.add(SOUP, [0, 0, 1]), np.add(SOUP, [10, 0, 0])]))


def test_a_morph_target_of_another_length(tmp_path):
    g = Gltf()
    mesh = morphing(g, [1.0, 0.0])
    target = g.root["meshes"][mesh]["primitives"][0]["targets"][0]
    target["POSITION"] = g.accessor(np.zeros((3, 3), dtype="<f4"), "VEC3")
    g.node(mesh=mesh)
    with pytest.raises(LoadError, match="3 positions for 4 vertices"):
        load(tmp_path, g)


def skinned(joint_scale: int = 1) -> Gltf:
    """Two joints, at x = 100 and y = 200; the tip (corner 3) follows the second, the rest the first."""
    g = Gltf()
    mesh = g.mesh(name="arm")
    attributes = g.root["meshes"][mesh]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = g.accessor(np.array([[0, 1, 0, 0]] * 4, dtype="u1"), "VEC4")
    weights = np.array([[255, 0, 0, 0]] * 3 + [[0, 255, 0, 0]], dtype="u1")
    attributes["WEIGHTS_0"] = g.accessor(weights, "VEC4", normalized=True)
    joints = [
        g.node(translation=[100, 0, 0], scale=[joint_scale, 1, 1]),
        g.node(translation=[0, 200, 0], scale=[joint_scale, 1, 1]),
    ]
    inverse = np.tile(np.eye(4, dtype="<f4"), (2, 1, 1))
    inverse[:, 3, 0] = -1  # column-major: a move by -1 along x
    skin = {"joints": joints, "inverseBindMatrices": g.accessor(inverse.reshape(2, 16), "MAT4")}
    g.root["skins"] = [skin]
    g.node(mesh=mesh, skin=0, translation=[7000, 0, 0])
    return g


def test_a_skin_places_its_mesh_and_its_node_does_not(tmp_path):
    mockup = load(tmp_path, skinned())
    placed = CORNERS + np.array([[99, 0, 0]] * 3 + [[-1, 200, 0]])
    assert np.array_equal(soup(mockup), placed[FACES])
    assert "1 skinned mesh was placed by its joints as these stand at rest ('arm')" in notes(mockup)


def test_a_mirrored_skin_keeps_its_outside(tmp_path):
    mockup = load(tmp_path, skinned(-1))
    assert mockup.faces.tolist() == FACES[:, [0, 2, 1]].tolist()


def test_a_skin_whose_joint_is_not_there(tmp_path):
    g = skinned()
    g.root["skins"][0]["joints"][1] = 99
    with pytest.raises(LoadError, match=r"skins\[0\] has joint 99"):
        load(tmp_path, g)


def test_animations_are_noted(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh())
    g.root["animations"] = [{"channels": [], "samplers": []}]
    assert "animations were not played" in notes(load(tmp_path, g))


# --- what is left out ----------------------------------------------------------------------------------------------


def test_hidden_nodes_and_all_below_are_left_out_by_name(tmp_path):
    g = Gltf()
    hide = {"KHR_node_visibility": {"visible": False}}
    show = {"KHR_node_visibility": {"visible": True}}
    mesh = g.mesh()
    below = g.node(is_root=False, mesh=mesh, name="screw", extensions=show)
    g.node(name="cover", mesh=mesh, children=[below], extensions=hide)
    g.node(name="shown", mesh=mesh, extensions=show)
    g.root["extensionsUsed"] = g.root["extensionsRequired"] = ["KHR_node_visibility"]
    mockup = load(tmp_path, g)
    assert names(mockup) == ["shown"]
    assert "2 hidden parts (KHR_node_visibility) were left out ('cover', 'screw')" in notes(mockup)


def test_points_and_lines_are_counted_by_kind(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(), name="solid")
    for mode in (0, 1, 2, 3, 3):
        g.node(mesh=g.mesh(indices=np.arange(4), mode=mode), name=f"mode {mode}")
    said = notes(load(tmp_path, g))
    for line in (
        "1 primitive of points was left out: only triangles collide ('mode 0')",
        "1 primitive of lines was left out: only triangles collide ('mode 1')",
        "1 primitive of line loops was left out: only triangles collide ('mode 2')",
        "2 primitives of line strips were left out: only triangles collide ('mode 3')",
    ):
        assert line in said


def test_notes_of_a_file_without_a_triangle(tmp_path):
    from feeler.io.gltf import read_gltf

    g = Gltf()
    g.node(mesh=g.mesh(mode=0), name="cloud")
    path = tmp_path / "m.glb"
    path.write_bytes(g.glb())
    raw: RawMesh = read_gltf(path)
    assert not len(raw.faces) and raw.up == "y"
    assert raw.notes == ["1 primitive of points was left out: only triangles collide ('cloud')"]


def test_which_of_several_scenes(tmp_path):
    g = Gltf()
    mesh = g.mesh()
    for name in ("a", "b"):
        g.node(is_root=False, mesh=mesh, name=name)
    g.root["scenes"] = [{"nodes": [0]}, {"nodes": [1]}]
    g.root["scene"] = 1
    mockup = load(tmp_path, g)
    assert names(mockup) == ["b"]
    assert "the default one was taken" in notes(mockup) and "not in the scene and was left out ('a')" in notes(mockup)
    del g.root["scene"]
    assert names(load(tmp_path, g)) == ["a"]


# --- packed geometry -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [0, 1])
def test_meshopt_gives_what_the_plain_bytes_give(testdata, tmp_path, version):
    """Streams of the reference encoder: triangles, a strip, filters, and the plain bytes beside them."""
    path = testdata / "files" / f"meshopt_v{version}.gltf"
    plain = load_mockup(path)
    root = json.loads(path.read_text())
    del root["buffers"][0]["uri"]
    root["extensionsRequired"] = root["extensionsUsed"]
    bare = tmp_path / "bare.gltf"
    bare.write_text(json.dumps(root))
    packed = load_mockup(bare)
    assert plain.triangle_count == packed.triangle_count == 2 * 23 * 23 + 21 * 46
    assert plain.part_count == 22
    assert np.array_equal(soup(plain), soup(packed))


@pytest.mark.parametrize("cut", range(0, 300, 7))
def test_damaged_meshopt_streams(testdata, cut):
    root = json.loads((testdata / "files" / "meshopt_v1.gltf").read_text())
    blob = base64.b64decode(root["buffers"][1]["uri"].partition(",")[2])
    for view in root["bufferViews"]:
        packed = view["extensions"]["KHR_meshopt_compression"]
        stream = blob[packed["byteOffset"] :][: packed["byteLength"]]
        more = (packed["count"], packed["byteStride"], packed["mode"], packed["filter"])
        meshopt.decode(memoryview(stream), *more)
        with pytest.raises(meshopt.DamagedError):
            meshopt.decode(memoryview(stream[: len(stream) - 1 - cut % len(stream)]), *more)
        changed = bytearray(stream)
        changed[cut % len(stream)] ^= 0x55
        try:
            made = meshopt.decode(memoryview(bytes(changed)), *more)
        except meshopt.DamagedError:
            continue
        assert len(made) == packed["count"] * packed["byteStride"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mode": "WAVES"}, "WAVES"),
        ({"filter": "COLOR"}, "COLOR"),
        ({"byteStride": 6}, "6 bytes"),
        ({"count": 10**7}, "too few"),
        ({"byteLength": 10**9}, "buffer of"),
        ({"count": -1}, "count"),
    ],
)
def test_meshopt_parameters_that_are_wrong(testdata, tmp_path, change, words):
    root = json.loads((testdata / "files" / "meshopt_v0.gltf").read_text())
    root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(change)
    root["extensionsRequired"] = ["EXT_meshopt_compression"]
    path = tmp_path / "m.gltf"
    path.write_text(json.dumps(root))
    with pytest.raises(LoadError, match=words):
        load_mockup(path)


def draco(*, plain: bool, required: bool) -> Gltf:
    import DracoPy

    g = Gltf()
    mesh = g.mesh(name="packed")
    blob = DracoPy.encode(CORNERS.astype("<f4"), FACES.astype("<u4"), quantization_bits=20, preserve_order=True)
    extension = {"bufferView": g.view(blob), "attributes": {"POSITION": 0}}
    g.root["meshes"][mesh]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": extension}
    if not plain:
        for accessor in g.root["accessors"]:
            del accessor["bufferView"]
    g.root["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    if required:
        g.root["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    g.node(mesh=mesh, scale=[1, 1, -1])
    return g


@needs_draco
@pytest.mark.parametrize(("plain", "required"), [(True, False), (False, True), (True, True), (False, False)])
def test_draco(tmp_path, plain, required):
    mockup = load(tmp_path, draco(plain=plain, required=required))
    assert mockup.triangle_count == 4
    assert np.allclose(soup(mockup), SOUP[:, [0, 2, 1]] * [1, 1, -1], atol=1e-4)
    assert volumes(mockup) == pytest.approx([VOLUME], rel=1e-4)


@needs_draco
@pytest.mark.parametrize("change", ["bytes", "attribute", "count", "view"])
def test_damaged_draco(tmp_path, change):
    g = draco(plain=False, required=True)
    extension = g.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    if change == "bytes":
        g.blob = g.blob[:-20] + bytes(20)
    elif change == "attribute":
        extension["attributes"] = {"POSITION": 7}
    elif change == "count":
        g.root["accessors"][0]["count"] = 3
    else:
        extension["bufferView"] = 44
    with pytest.raises(LoadError):
        load(tmp_path, g)


def test_draco_without_its_package_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    g = Gltf()
    g.node(mesh=g.mesh())
    g.root["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    assert load(tmp_path, g).triangle_count == 4  # the plain copy is there
    del g.root["accessors"][0]["bufferView"]
    with pytest.raises(LoadError, match=r"pip install feeler\[gltf\]"):
        load(tmp_path, g)


@pytest.mark.parametrize(
    ("other", "is_doubtful"),
    [
        ({"scale": [2, 2, 2]}, True),
        ({"translation": [0, 0, 9]}, True),
        ({"translation": [1, 2, 3.000001], "scale": [1, 1, 1]}, False),
        ({"rotation": [0, 0, 0, 1]}, False),
    ],
)
def test_a_node_that_is_placed_twice(tmp_path, other, is_doubtful):
    """The standard forbids a matrix beside other placements: which one was used is told where it matters."""
    g = Gltf()
    matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]
    g.node(mesh=g.mesh(), name="twice", matrix=matrix, **other)
    mockup = load(tmp_path, g)
    assert np.allclose(soup(mockup), CORNERS[FACES] + [1, 2, 3])
    said = [doubt for doubt in mockup.report.source.doubts if "1 node is placed twice" in doubt]
    assert len(said) == is_doubtful and all("the matrix was used ('twice')" in doubt for doubt in said)
