"""3MF beyond its core: extensions by what they do to a shape, packages of several models, placements, names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from loading import notes, save
from test_field_scenes import volumes
from test_io_builders import CORE, zipped

from feeler import LoadError, Mockup
from feeler.io import load_mockup
from feeler.words import counted

MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing/"
CONSORTIUM = "http://schemas.3mf.io/3dmanufacturing/"
NAMESPACES = {
    "p": MICROSOFT + "production/2015/06",
    "pa": MICROSOFT + "production/alternatives/2021/04",
    "m": MICROSOFT + "material/2015/02",
    "s": MICROSOFT + "slice/2015/07",
    "b": MICROSOFT + "beamlattice/2017/02",
    "t": MICROSOFT + "trianglesets/2021/07",
    "bo": CONSORTIUM + "booleanoperations/2023/07",
    "v": CONSORTIUM + "volumetric/2022/01",
    "d": CONSORTIUM + "displacement/2023/10",
    "x": "http://example.com/bend/2031/01",
}
CORNERS = np.array([[x, y, z] for x in (0, 10) for y in (0, 10) for z in (0, 10)], dtype=float)
FACES = [
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
]  # fmt: skip
MOVED = "1 0 0 0 1 0 0 0 1 50 0 0"
MIRRORED = "-1 0 0 0 1 0 0 0 1 0 0 0"


def one(words: str) -> str:
    """A note on several, as it is on one."""
    return counted(1, words).removeprefix("1 ")


def cube(number: int, name: str = "", more: str = "", inside: str = "", lead: str = "", mesh: str = "mesh") -> str:
    """A cube of 10; `more` goes into the object's attributes, `inside` into its mesh."""
    label = f' name="{name}"' if name else ""
    vertices = "".join(f'<{lead}vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS.tolist())
    triangles = "".join(f'<{lead}triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
    content = f"<{lead}vertices>{vertices}</{lead}vertices><{lead}triangles>{triangles}</{lead}triangles>{inside}"
    return f'<object id="{number}"{label} {more}><{mesh}>{content}</{mesh}></object>'


def group(number: int, *components: str, name: str = "group") -> str:
    return f'<object id="{number}" name="{name}"><components>{"".join(components)}</components></object>'


def bare(number: int, name: str, content: str, more: str = "") -> str:
    return f'<object id="{number}" name="{name}" {more}>{content}</object>'


def use(number: int, transform: str = "", more: str = "", tag: str = "component") -> str:
    placed = f' transform="{transform}"' if transform else ""
    return f'<{tag} objectid="{number}"{placed} {more}/>'


def item(number: int, transform: str = "", more: str = "") -> str:
    return use(number, transform, more, "item")


def model(resources: str, items: str = "", required: str = "", more: str = "") -> str:
    declared = " ".join(f'xmlns:{prefix}="{uri}"' for prefix, uri in NAMESPACES.items())
    needed = f'requiredextensions="{required}"' if required else ""
    return (
        f'<?xml version="1.0"?><model {CORE} {declared} {needed} {more}><resources>{resources}</resources>'
        f"<build>{items}</build></model>"
    )


def load(folder: Path, root: str, **others: str) -> Mockup:
    members = {"3D/3dmodel.model": root} | {f"3D/parts/{name}.model": text for name, text in others.items()}
    return load_mockup(save(folder, "a.3mf", zipped({name: text.encode() for name, text in members.items()})))


def refused(folder: Path, root: str, *words: str, **others: str) -> None:
    with pytest.raises(LoadError) as error:
        load(folder, root, **others)
    for word in words:
        assert word in str(error.value)


def names(mockup: Mockup) -> list[str]:
    return [part.name for part in mockup.parts]


# --- what is not in triangles --------------------------------------------------------------------------------------

BEAMS = '<b:beamlattice radius="1"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice>'
POINTS = '<vertices><vertex x="0" y="0" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles/>'
NO_TRIANGLES = [
    (bare(2, "odd", f"<mesh>{POINTS}{BEAMS}</mesh>"), "b", "objects have a beam lattice"),
    (bare(2, "odd", '<bo:booleanshape objectid="1"><bo:boolean objectid="1"/></bo:booleanshape>'), "bo",
     "extension 'booleanoperations'"),
    (bare(2, "odd", '<v:levelset functionid="7" meshid="1" channel="c"/>'), "v", "objects are level sets"),
    (bare(2, "odd", "<mesh><vertices/><triangles/></mesh>", 's:slicestackid="5"'), "s", "objects are slices alone"),
    (bare(2, "odd", '<x:bend angle="3"><x:objects objectid="1"/></x:bend>'), "x", NAMESPACES["x"]),
    (cube(2, "odd", inside="<x:bend/>"), "x", NAMESPACES["x"]),
    (cube(2, "odd", more='x:bend="3"'), "x", NAMESPACES["x"]),
    (cube(2, "odd").replace('v3="3"', 'v3="3" x:bulge="3"'), "x", NAMESPACES["x"]),
    (cube(2, "odd").replace('z="0.0"', 'z="0.0" x:bulge="3"'), "x", NAMESPACES["x"]),
    (group(2, use(1), name="odd").replace("</object>", "<x:bend/></object>"), "x", "('odd')"),
    (cube(2, "odd", inside="<b:grid/>"), "b", NAMESPACES["b"]),  # of an extension that is known, and yet unknown
    (bare(2, "odd", "<mesh><vertices/><triangles/></mesh>"), "", "objects hold no triangle"),
]  # fmt: skip


@pytest.mark.parametrize(("resource", "required", "words"), NO_TRIANGLES)
def test_an_object_that_is_not_in_triangles_is_left_out_and_named(tmp_path, resource, required, words):
    mockup = load(tmp_path, model(cube(1, "plain") + resource, item(2) + item(1, MOVED), required))
    assert names(mockup) == ["plain"] and volumes(mockup) == pytest.approx([1e-6])
    assert mockup.bounds[0].tolist() == [0.05, 0, 0]
    assert one(words) in notes(mockup) and "'odd'" in notes(mockup)
    inner = load(tmp_path, model(cube(1, "plain") + resource + group(3, use(2), use(1)), item(3), required))
    assert [part.path for part in inner.parts] == ["a/group/plain"]
    assert one(words) in notes(inner) and "'odd'" in notes(inner)


@pytest.mark.parametrize(("resource", "required", "words"), NO_TRIANGLES)
def test_the_error_of_a_build_without_triangles_names_the_extension_and_the_objects(
    tmp_path, resource, required, words
):
    refused(tmp_path, model(cube(1, "plain") + resource, item(2), required), "no triangle", one(words), "'odd'")


@pytest.mark.parametrize(
    "build",
    [item(1, more='x:bend="3"') + item(2), '<item objectid="1"><x:bend/></item>' + item(2), item(3)],
)
def test_a_use_that_needs_an_extension_is_left_out(tmp_path, build):
    resources = cube(1, "bent") + cube(2, "plain") + group(3, use(1, more='x:bend="3"'), use(2))
    mockup = load(tmp_path, model(resources, build, "p x"))
    assert names(mockup) == ["plain"]
    assert f"1 use of objects needs the extension '{NAMESPACES['x']}'" in notes(mockup) and "'bent'" in notes(mockup)


def test_a_required_extension_that_no_object_uses_is_told(tmp_path):
    mockup = load(tmp_path, model(cube(1), item(1), "x nowhere"))
    assert mockup.triangle_count == 12
    for name in (NAMESPACES["x"], "nowhere"):
        assert f"the file requires the extension '{name}', which is not read" in notes(mockup)


def test_what_is_not_required_is_passed_over(tmp_path):
    resource = cube(1, "plain", more='x:bend="3"', inside="<x:bend><x:vertex/><x:arc/></x:bend>")
    mockup = load(tmp_path, model(resource, item(1)))
    assert mockup.triangle_count == 12
    assert "1 element of objects is of no extension that is read, and was passed over ('bend')" in notes(mockup)


@pytest.mark.parametrize(
    ("resource", "required", "words"),
    [
        (cube(1, "plain", inside=BEAMS), "b", "objects have a beam lattice"),
        (cube(1, "plain", 's:slicestackid="5" s:meshresolution="lowres"'), "s", "the coarse mesh"),
        (cube(1, "plain", 'pa:modelresolution="obfuscated"'), "pa", "obfuscated stand-ins"),
        (cube(1, "plain", inside='<v:volumedata><v:boundary functionid="7"/></v:volumedata>'), "v",
         "objects have a volumetric boundary"),
        (cube(1, "plain", lead="d:", mesh="d:displacementmesh"), "d", "objects have a displaced surface"),
        (cube(1, "plain", 'type="support"'), "", "objects of the type 'support' were taken like all others"),
        (cube(1, "plain", 'type="surface"'), "", "objects of the type 'surface' were taken like all others"),
        (cube(1, "plain", 'type="other"'), "", "objects of the type 'other' were taken like all others"),
        (cube(1, "plain", 'type="lid"'), "", "objects of an unknown type were taken like all others"),
    ],
)  # fmt: skip
def test_triangles_with_more_beside_them_are_taken_and_counted(tmp_path, resource, required, words):
    mockup = load(tmp_path, model(resource, item(1) + item(1, MOVED), required))
    assert volumes(mockup) == pytest.approx([1e-6, 1e-6])
    assert one(words) in notes(mockup) and "('plain')" in notes(mockup) and notes(mockup).startswith("1 ")
    is_stand_in = words in ("the coarse mesh", "obfuscated stand-ins")
    assert [one(words) in doubt for doubt in mockup.report.source.doubts] == [True] * is_stand_in


@pytest.mark.parametrize(
    ("resource", "required"),
    [
        (cube(1, "plain", 's:slicestackid="5" s:meshresolution="fullres"'), "s"),
        (cube(1, "plain", 'pid="3" p:UUID="0" pa:modelresolution="fullres"'), "p pa m"),
        (cube(1, "plain", inside="<t:trianglesets><t:triangleset><t:ref/></t:triangleset></t:trianglesets>"), "t"),
        (cube(1, "plain", inside='<v:volumedata><v:color functionid="7"/></v:volumedata>'), "v"),
        (cube(1, "plain", 'type="model"', "").replace("<mesh>", "<metadatagroup/><mesh>"), ""),
        ('<s:slicestack id="5"><s:slice ztop="1"><s:vertices><s:vertex x="0" y="0"/></s:vertices></s:slice>'
         "</s:slicestack>" + cube(1, "plain"), "s"),
    ],
)  # fmt: skip
def test_what_moves_no_surface_is_not_told(tmp_path, resource, required):
    mockup = load(tmp_path, model(resource, item(1), required))
    assert mockup.triangle_count == 12 and not mockup.report.source.notes


def test_a_coarse_mesh_that_is_empty_was_not_taken(tmp_path):
    sliced = bare(2, "odd", "<mesh><vertices/><triangles/></mesh>", 's:slicestackid="5" s:meshresolution="lowres"')
    mockup = load(tmp_path, model(cube(1) + sliced, item(1) + item(2), "s"))
    assert "slices alone" in notes(mockup) and "coarse" not in notes(mockup)


def test_the_mesh_in_place_of_a_beam_lattice(tmp_path):
    beams = BEAMS.replace("radius", 'representationmesh="1" radius')
    lattice = bare(2, "lattice", f"<mesh>{POINTS}{beams}</mesh>")
    mockup = load(tmp_path, model(cube(1, "shown") + lattice, item(2, MOVED), "b"))
    assert [part.path for part in mockup.parts] == ["a/lattice/shown"]
    assert mockup.bounds[0].tolist() == [0.05, 0, 0]
    assert "the mesh that the file gives in their place was taken ('lattice')" in mockup.report.source.doubts[0]


def test_objects_outside_the_build_are_counted(tmp_path):
    mockup = load(tmp_path, model(cube(1, "in") + cube(2, "out"), item(1)))
    assert mockup.triangle_count == 12
    assert "1 object with triangles is reached from no item of the build and was left out ('out')" in notes(mockup)


# --- several models ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "path", ["/3D/parts/far.model", "3D/parts/far.model", "parts/FAR.model", "/3D/parts/f%61r.model"]
)
def test_objects_of_other_models(tmp_path, path):
    root = model(group(1, use(5, MOVED, f'p:path="{path}"'), name="top"), item(1), "p")
    far = model(cube(4, "leaf") + group(5, use(4, MIRRORED), name="far"), item(4))
    mockup = load(tmp_path, root, far=far)
    assert [part.path for part in mockup.parts] == ["a/top/far/leaf"]
    assert np.allclose(mockup.bounds, [[0.04, 0, 0], [0.05, 0.01, 0.01]])
    assert not notes(mockup)


def test_ids_are_those_of_their_model(tmp_path):
    items = item(1) + item(1, more='p:path="/3D/parts/a.model"') + item(1, more='p:path="/3D/parts/b.model"')
    others = {"a": model(cube(1, "of a")), "b": model(cube(1, "of b"))}
    assert names(load(tmp_path, model(cube(1, "root"), items), **others)) == ["root", "of a", "of b"]


def test_a_model_that_is_not_there_is_named(tmp_path):
    root = model(cube(1) + group(2, use(1), use(8, more='p:path="/3D/gone.model"'), name="pump"), item(2), "p")
    refused(tmp_path, root, "object '8' is used by 'pump'", "'/3D/gone.model' is not in the archive")
    refused(tmp_path, model("", item(7, more='p:path="/3D/gone.model"')), "used by an item", "'/3D/gone.model'")
    root = model("", item(7, more='p:path="/3D/parts/there.model"'))
    refused(tmp_path, root, "'7' is used by an item", "not defined in '3d/parts/there.model'", there=model(cube(1)))


def test_a_cycle_over_several_models_is_refused(tmp_path):
    root = model(group(1, use(1, more='p:path="/3D/parts/a.model"'), name="head"), item(1), "p")
    other = model(group(1, use(1, more='p:path="/3D/3dmodel.model"'), name="tail"))
    refused(tmp_path, root, "contains itself", a=other)


def test_another_unit_in_another_model_is_told(tmp_path):
    root = model(cube(1), item(1) + item(2, more='p:path="/3D/parts/a.model"'), more='unit="inch"')
    mockup = load(tmp_path, root, a=model(cube(2), more='unit="meter"'))
    assert "1 model file states another unit than the root model" in notes(mockup)
    assert np.allclose(mockup.bounds[1], 0.254)


def test_an_encrypted_model_is_left_out_and_named(tmp_path):
    root = model(cube(1, "plain"), item(1) + item(2, more='p:path="/3D/parts/a.model"'))
    mockup = load(tmp_path, root, a="%3McF\0\0\0\0")
    assert names(mockup) == ["plain"] and "1 object is encrypted" in notes(mockup)
    refused(tmp_path, "%3McF\0\0\0\0", "root model is encrypted")


def test_a_file_that_is_no_model(tmp_path):
    refused(tmp_path, "<html/>", "<html>, and not <model>")


# --- placement, units, names ---------------------------------------------------------------------------------------


def test_mirrored_instances_keep_their_outside(tmp_path):
    """By the item, by the component, by both: a mirror of a mirror is none."""
    resources = cube(1, "c") + group(2, use(1, MIRRORED), use(1))
    mockup = load(tmp_path, model(resources, item(1, MIRRORED) + item(2) + item(2, MIRRORED)))
    assert volumes(mockup) == pytest.approx([1e-6] * 5)
    lower = [part.lower[0] for part in mockup.parts]
    assert np.allclose(lower, [-0.01, -0.01, 0, 0, -0.01])


def test_transforms_of_nested_components(tmp_path):
    """Quarter turn about z and 5 along x, below 2 times as large, below 100 along y: row vectors, innermost first."""
    resources = cube(1) + group(2, use(1, "0 1 0 -1 0 0 0 0 1 5 0 0")) + group(3, use(2, "2 0 0 0 2 0 0 0 2 0 0 0"))
    mockup = load(tmp_path, model(resources, item(3, "1 0 0 0 1 0 0 0 1 0 100 0"), more='unit="meter"'))
    assert np.array_equal(mockup.bounds, [[-10, 100, 0], [10, 120, 20]])


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("micron", 1e-6), ("millimeter", 1e-3), ("centimeter", 1e-2), ("inch", 0.0254), ("foot", 0.3048), ("meter", 1)],
)
def test_units(tmp_path, unit, metres):
    mockup = load(tmp_path, model(cube(1), item(1), more=f'unit="{unit}"'))
    assert mockup.bounds[1].tolist() == [10 * metres] * 3


def test_names(tmp_path):
    resources = cube(1, "by name", 'partnumber="N-1"') + cube(2, more='partnumber="N-2"') + cube(3)
    items = item(1) + item(2) + item(3) + item(1, more='partnumber="N-4"')
    assert names(load(tmp_path, model(resources, items))) == ["by name", "N-2", "object 3", "N-4"]


def test_items_that_are_not_printed_are_taken_and_counted(tmp_path):
    mockup = load(tmp_path, model(cube(1), item(1, more='printable="0" partnumber="spare"') + item(1)))
    assert mockup.triangle_count == 24
    assert "1 item is not to be printed" in notes(mockup) and "('spare')" in notes(mockup)


def test_z_is_up(tmp_path):
    mockup = load(tmp_path, model(cube(1), item(1)))
    assert mockup.report.source.up == "z"
    turned = load_mockup(tmp_path / "a.3mf", up="y")
    assert np.allclose(turned.bounds, [[0, 0, -0.01], [0.01, 0.01, 0]])


# --- settings of slicers -------------------------------------------------------------------------------------------


def load_sliced(folder: Path, root: str, config: str, file: str) -> Mockup:
    members = {"3D/3dmodel.model": root.encode(), f"Metadata/{file}.config": config.encode()}
    return load_mockup(save(folder, "a.3mf", zipped(members)))


def test_parts_of_bambu_studio_and_orca(tmp_path):
    """Objects have no name in their models; a part of the settings goes with a component by its id."""
    config = (
        '<config><object id="3">'
        '<part id="1" subtype="normal_part"><metadata key="name" value="body"/></part>'
        '<part id="2" subtype="negative_part"><metadata key="name" value="drill"/></part>'
        '<metadata key="name" value="bracket"/></object><plate><metadata key="name" value="plate"/></plate></config>'
    )
    root = model(cube(1) + cube(2) + group(3, use(1), use(2, MOVED), name=""), item(3))
    mockup = load_sliced(tmp_path, root, config, "model_settings")
    assert [part.path for part in mockup.parts] == ["a/bracket/body", "a/bracket/drill"]
    named = load_sliced(tmp_path, root.replace('id="1"', 'id="1" name="own"'), config, "model_settings")
    assert [part.path for part in named.parts] == ["a/bracket/own", "a/bracket/drill"]
    assert "1 part is holes to the slicer" in notes(mockup) and "('drill')" in notes(mockup)
    assert notes(mockup).count("to the slicer") == 1


@pytest.mark.parametrize(
    ("key", "value", "kind"),
    [
        ("volume_type", "NegativeVolume", "holes"),
        ("volume_type", "ParameterModifier", "modifiers"),
        ("volume_type", "SupportBlocker", "support blockers"),
        ("volume_type", "Unheard", "no bodies"),
        ("modifier", "1", "modifiers"),
    ],
)
def test_volumes_of_prusa_slicer(tmp_path, key, value, kind):
    config = (
        '<config><object id="1"><metadata type="object" key="name" value="bracket"/>'
        '<volume firstid="0" lastid="5"><metadata key="name" value="body"/>'
        '<metadata key="volume_type" value="ModelPart"/></volume><volume><metadata key="modifier" value="0"/></volume>'
        f'<volume firstid="6" lastid="11"><metadata key="name" value="odd"/><metadata key="{key}" value="{value}"/>'
        "</volume></object></config>"
    )
    mockup = load_sliced(tmp_path, model(cube(1, "named"), item(1)), config, "Slic3r_PE_model")
    assert names(mockup) == ["named"] and mockup.triangle_count == 12
    assert f"1 part is {kind} to the slicer" in notes(mockup) and "('odd')" in notes(mockup)
    assert notes(mockup).count("to the slicer") == 1


def test_damaged_settings_refuse_no_file(tmp_path):
    mockup = load_sliced(tmp_path, model(cube(1), item(1)), "<config><object", "model_settings")
    assert mockup.triangle_count == 12 and "1 setting of slicers was not understood" in notes(mockup)
