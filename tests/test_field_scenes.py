"""Small scene files that people's tools write, each with its right value. The files are in testdata/files."""

from __future__ import annotations

import numpy as np
import pytest

from feeler import Mockup
from feeler.io import load_mockup, load_tool


def volumes(mockup: Mockup) -> list[float]:
    """The signed volume of each part, cubic metres: positive with the outside out."""
    corners = mockup.vertices[mockup.faces]
    signed = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    return [float(signed[mockup.part_of_face == part].sum()) for part in range(mockup.part_count)]


def notes(mockup: Mockup) -> str:
    return "\n".join(mockup.report.source.notes)


# --- glTF --------------------------------------------------------------------------------------------------------


def test_packed_with_plain_bytes_beside_it(testdata):
    """As `gltfpack -cf` writes it: the extension is used and not required, and buffer 0 has the plain bytes."""
    mockup = load_mockup(testdata / "files" / "gltf_meshopt_fallback.gltf")
    assert mockup.triangle_count == 12
    assert np.allclose(mockup.bounds, [[0, 0, 0], [0.01, 0.01, 0.01]], atol=1e-9)


def test_a_mirrored_instance_keeps_its_outside(testdata):
    mockup = load_mockup(testdata / "files" / "gltf_mirrored_tool.gltf")
    assert volumes(mockup) == pytest.approx([1e-6, 1e-6], rel=1e-6)


def test_contacts_of_a_mirrored_tool(testdata, tmp_path):
    """The tool is 1 mm deep in a slab with its top at z = 0: both bodies are pushed up, and none sideways."""
    from feeler import Mockup, Scene

    x, z = 0.1, -0.05
    corners = np.array([[a, b, c] for a in (-x, x) for b in (-x, x) for c in (z, 0.0)])
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
         [1, 5, 7], [1, 7, 3]]
    )  # fmt: skip
    scene = Scene(Mockup(corners, faces))
    pose = np.eye(4)
    pose[2, 3] = -0.001
    found = scene.contacts(load_tool(testdata / "files" / "gltf_mirrored_tool.gltf"), pose)
    assert np.allclose(found.gaps, -0.001, atol=1e-9)
    assert np.allclose(found.normals, [0, 0, 1])


def test_morph_weights_of_the_mesh(testdata):
    mockup = load_mockup(testdata / "files" / "gltf_morph_weights.gltf")
    assert np.allclose(mockup.bounds, [[0, 0, 0.02], [0.01, 0.01, 0.03]], atol=1e-8)
    assert "morph targets" in notes(mockup)


# --- COLLADA -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "words"),
    [("dae_bad_colour", ("kind 'effect'", "'E'")), ("dae_bad_light", ("kind 'light'", "'lt'", "kind 'camera'", "'c'"))],
)
def test_looks_that_are_wrong_do_not_refuse_a_file(testdata, name, words):
    """A colour with decimal commas; a light and a camera without a common technique (trimesh 1384)."""
    mockup = load_mockup(testdata / "files" / f"{name}.dae")
    assert mockup.triangle_count == 12
    assert np.allclose(mockup.bounds, [[0, 0, 0], [0.01, 0.01, 0.01]], atol=1e-12)
    for word in (*words, "do not move a vertex"):
        assert word in notes(mockup)


def test_a_hollow_polygon_of_collada(testdata):
    """A flat U: 3 x 3 less a notch of 1 x 2."""
    mockup = load_mockup(testdata / "files" / "dae_concave.dae")
    corners = mockup.vertices[mockup.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(cross, axis=1).sum() / 2 == pytest.approx(7)
    assert "1 polygon with more than three corners was cut" in notes(mockup)


def test_a_library_node_is_placed_once(testdata):
    """At 10, then moved by 1 and turned by 90 degrees: x from 10 + 1 - 0.02."""
    mockup = load_mockup(testdata / "files" / "dae_instance_node.dae")
    assert np.allclose(mockup.bounds, [[10.98, 0, 0], [11, 0.01, 0.03]], atol=1e-12)


# --- 3MF ---------------------------------------------------------------------------------------------------------


def test_a_required_extension_that_makes_one_item(testdata):
    """The build has "cut", a cube less a cube by the boolean extension, and "other", a cube of 10 mm at x = 50 mm."""
    mockup = load_mockup(testdata / "files" / "3mf_boolean.3mf")
    assert [part.name for part in mockup.parts] == ["other"]
    assert np.allclose(mockup.bounds, [[0.05, 0, 0], [0.06, 0.01, 0.01]], atol=1e-12)
    assert volumes(mockup) == pytest.approx([1e-6])
    assert "1 object is boolean operations" in notes(mockup) and "is missing ('cut')" in notes(mockup)
    assert "box" not in notes(mockup) and "tool" not in notes(mockup)  # they are in the build, by what they make
    assert mockup.report.source.up == "z"
