"""Attributes of parts: read from files, bounded, kept and searched; also hostile ones."""

from __future__ import annotations

import base64
import importlib.util
import json
import pickle
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from commands import error_of, run, run_json
from loading import CORNERS, TETRAHEDRON, instances, save
from workbench_scene import LEFT, PATHS, PLATE, RIGHT, SHEET, Bench, cube, stand

import feeler
from feeler import LimitError, MeshError, OptionError
from feeler.attributes import from_bytes, terms, to_bytes
from feeler.io import load_mockup, load_tool
from feeler.io.body import only_faces
from feeler.io.step_attributes import product_attributes

STEP = (Path(__file__).parent.parent / "testdata" / "files" / "step_two_colours.step").read_text()
needs_step = pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")

HTML = '<img src=x onerror="alert(1)">'


def row(*attributes: dict[str, str]) -> feeler.Mockup:
    """A tetrahedron for each."""
    count = len(attributes)
    vertices = np.concatenate([np.add(CORNERS, [2.0 * i, 0, 0]) for i in range(count)])
    faces = np.concatenate([TETRAHEDRON + 4 * i for i in range(count)])
    paths = [f"plant/{name}" for name in ("pump", "Pipe", "a:b", "valve", "bolt")[:count]]
    return feeler.Mockup(
        vertices, faces, np.repeat(range(count), 4), paths, part_paths=paths, part_attributes=attributes
    )


def test_written_glb_keeps_attributes(tmp_path):
    given = [{"material": "Steel", "a.b": "1, 2"}, {"layer": HTML}, {}, {"material": "Steel"}]
    mockup = row(*given)
    mockup.part_colours = np.full((4, 3), 0.5)
    feeler.io.write_glb(tmp_path / "a.glb", mockup)
    again = load_mockup(tmp_path / "a.glb")
    assert again.part_attributes == mockup.part_attributes == given and not again.report.source.doubts
    assert again.parts.select("material:steel").tolist() == [0, 3]
    document = json.loads((tmp_path / "a.glb").read_bytes()[20:].split(b"BIN\0")[0].rpartition(b"}")[0] + b"}")
    # Others read the names; a colour that an unnamed part has, too, stays without one.
    assert sorted(each.get("name", "") for each in document["materials"]) == ["", "Steel"]
    body = feeler.io.body_of(mockup)
    kept = only_faces(body, body.part_of_face == 1)
    feeler.io.write_glb(tmp_path / "c.glb", kept)
    assert load_mockup(tmp_path / "c.glb").part_attributes == [{"layer": HTML}]
    with pytest.raises(MeshError, match="attributes has 1 entries but there are 4 parts"):
        replace(body, attributes=[{}])


# --- files -------------------------------------------------------------------------------------------------------


def test_gltf_extras_of_nodes_and_meshes_and_names_of_materials(tmp_path):
    nodes = [
        {"name": "a", "extras": {"layer": "piping", "size": [1, 2.5, True], "sub": {"x": {"y": 1e-3}}, "no": None}},
        {"name": "b", "translation": [2, 0, 0], "extras": {"material": "Brass"}},
        {"name": "c", "translation": [4, 0, 0], "extras": "text, no object"},
    ]
    mockup = load_mockup(instances(tmp_path / "a.glb", nodes, {"std": "M8"}, [{"name": " Cast\nIron "}]))
    common = {"material": "CastIron", "std": "M8"}
    assert mockup.part_attributes == [
        {"layer": "piping", "size": "1, 2.5, true", "sub.x.y": "0.001", **common},
        {"material": "Brass", "std": "M8"},
        {"extras": "text, no object", **common},
    ]
    assert mockup.parts[1].attributes == {"material": "Brass", "std": "M8"} and not mockup.report.source.doubts
    assert "('b: material: CastIron')" in "".join(mockup.report.source.notes)
    assert load_tool(tmp_path / "a.glb").parts.select("material:brass").tolist() == [1]


def test_attributes_of_one_name_keep_all_values_or_say_which_counts(tmp_path, monkeypatch):
    nodes = [{"name": "a", "extras": {"a": {"b": 1}, "a.b": 2, "std": "M8"}}, {"name": "b", "translation": [2, 0, 0]}]
    mesh = {"std": "M8", "material": "iron", "extras": {"x": None}}
    mockup = load_mockup(instances(tmp_path / "a.glb", nodes, mesh, [{"name": "steel"}]))
    assert mockup.part_attributes == [
        {"a.b": "1, 2", "std": "M8", "material": "iron"},
        {"std": "M8", "material": "iron"},
    ]
    notes = "".join(mockup.report.source.notes)
    assert "a: material: steel" in notes and "b: material: steel" in notes and "M8" not in notes
    monkeypatch.setattr("feeler.io.gltf.material_names", lambda *_: ["", "steel"])
    bare = load_mockup(instances(tmp_path / "b.glb", nodes))
    assert bare.part_attributes[1] == {"material": "steel"}


def test_instances_share_one_dict(tmp_path):
    nodes = [{"translation": [2 * i, 0, 0]} for i in range(100)]
    mockup = load_mockup(instances(tmp_path / "a.glb", nodes, {"std": "M8"}))
    assert len({id(each) for each in mockup._part_attributes}) == 1
    mockup.part_attributes[3]["std"] = "changed"  # copies
    mockup.parts[3].attributes["std"] = "changed"
    assert mockup.part_attributes == [{"std": "M8"}] * 100


def test_hostile_extras_are_bounded(tmp_path):
    deep: dict[str, Any] = {"x": 1}
    for _ in range(400):
        deep = {"k": deep}
    nodes = [
        {"extras": {f"key {i}": i for i in range(1_000_000)}},
        {"extras": {"deep": deep, "long": "y" * 50_000, "many": list(range(100_000)), HTML: HTML}},
        {"extras": {"nan": float("nan"), "endless": [float("inf"), 2], "data": "data:image/png;base64,AAAA"}},
        {"extras": {"nul": "a\0b", "": "no name", "\x1b[31m": "\x1b[0m", "huge": 10**300, "n" * 101: "x"}},
    ]
    mockup = load_mockup(instances(tmp_path / "a.glb", nodes, {"std": "M8"}))
    many, long, odd, names = mockup.part_attributes
    assert len(many) == 100 and many["key 99"] == "99"
    assert [len(long[name]) for name in ("long", "many")] == [1000, 1000] and long["long"].endswith("y…")
    assert long[HTML] == HTML and not any(name.startswith("deep") for name in long)
    assert odd == {"endless": "2", "std": "M8"} and names == {"[31m": "[0m", "std": "M8"}
    doubts = "\n".join(mockup.report.source.doubts)
    for said in (
        "attributes were left out of parts that have more than 100",
        "2 attributes have values longer than 1,000 characters, which were cut ('long', 'many')",
        "attributes have names longer than 100 characters, or are nested deeper, and were left out",
        "attributes are binary data or no finite numbers, and were left out ('nan', 'endless', 'data', 'nul', 'huge')",
    ):
        assert said in doubts, doubts


def test_the_number_in_all_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr("feeler.attributes.MOST_IN_ALL", 5)
    nodes = [{"extras": {"a": i, "b": i}} for i in (1, 1, 1, 2, 3, 1)]
    mockup = load_mockup(instances(tmp_path / "a.glb", nodes))
    assert [len(each) for each in mockup.part_attributes] == [2, 2, 2, 2, 0, 2]
    assert "1 part lost its attributes: the file states too many" in "".join(mockup.report.source.doubts)
    with pytest.raises(LimitError, match="more than"):
        row({"a": "1", "b": "1"}, {"a": "2", "b": "2"}, {"a": "3", "b": "3"})


PROPERTIES = """#900=PROPERTY_DEFINITION('user defined attribute','',#7);
#901=PROPERTY_DEFINITION_REPRESENTATION(#900,#902);
#902=REPRESENTATION('',(#903,#904,#905,#906),#9);
#903=DESCRIPTIVE_REPRESENTATION_ITEM('Supplier','Acme; it''s \\X\\E4');
#904=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(LENGTH_MEASURE(2.5),#1)
REPRESENTATION_ITEM('wall thickness'));
#905=MEASURE_REPRESENTATION_ITEM('mass',MASS_MEASURE(7.25E-1),#1);
#906=VALUE_REPRESENTATION_ITEM('pieces',COUNT_MEASURE(4.));
#910=PROPERTY_DEFINITION('material property','material name',#6);
#911=PROPERTY_DEFINITION_REPRESENTATION(#910,#912);
#912=REPRESENTATION('material name',(#913),#9);
#913=DESCRIPTIVE_REPRESENTATION_ITEM('S235JR','');
#920=PROPERTY_DEFINITION('geometric validation property','volume',#6);
#921=PROPERTY_DEFINITION_REPRESENTATION(#920,#922);
#922=REPRESENTATION('volume',(#905),#9);
#930=PRESENTATION_LAYER_ASSIGNMENT('Sheet metal','',(SOLID));
#931=PRESENTATION_LAYER_ASSIGNMENT('Other','',(#16));
ENDSEC;
END"""


def step_text() -> str:
    """The bracket with properties of all kinds. Its entities by keyword, as numbers move when the file is made anew."""

    def number(keyword: str) -> str:
        return next(line.split("=")[0] for line in STEP.splitlines() if line.partition("=")[2].startswith(keyword))

    more = PROPERTIES.replace("#7)", number("PRODUCT_DEFINITION(") + ")")
    more = more.replace("#6)", number("PRODUCT_DEFINITION_SHAPE(") + ")").replace("SOLID", number("MANIFOLD_SOLID"))
    return STEP.replace("'bracket','bracket',''", "'P-17','bracket','Holds it'").replace("ENDSEC;\nEND", more)


EXPECTED = {
    "Supplier": "Acme; it's ä",
    "mass": "0.725",
    "pieces": "4",
    "wall thickness": "2.5",
    "material": "S235JR",
    "layer": "Sheet metal",
    "number": "P-17",
    "description": "Holds it",
}


def test_properties_layers_and_product_of_step():
    (found,) = product_attributes(step_text().encode()).values()
    assert found == EXPECTED
    assert product_attributes(STEP.encode()) == {}


@needs_step
def test_step_parts_have_them(tmp_path):
    mockup = load_mockup(save(tmp_path, "a.step", step_text()))
    assert mockup.part_attributes == [EXPECTED]
    assert load_mockup(save(tmp_path, "b.step", STEP)).part_attributes == [{}]


def test_material_designations_of_step():
    text = STEP.replace("ENDSEC;\nEND", "#900=MATERIAL_DESIGNATION('Al 6061',(#7));\nENDSEC;\nEND")
    shape = next(line.split("=")[0] for line in STEP.splitlines() if "=PRODUCT_DEFINITION_SHAPE(" in line)
    assert list(product_attributes(text.replace("(#7)", f"({shape})").encode()).values()) == [{"material": "Al 6061"}]


def test_metadata_and_numbers_of_3mf(tmp_path):
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    corners = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS.tolist())
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in TETRAHEDRON.tolist())
    group = (
        '<metadatagroup><metadata name="v:Material"> PA <!-- --> 12 </metadata>'
        '<metadata name="note">&lt;b&gt;</metadata></metadatagroup>'
    )
    text = (
        f'<model unit="meter" xmlns="{core}" xmlns:v="urn:v"><metadata name="Title">t</metadata><resources>'
        f'<object id="1" name="lid" partnumber="L-1">{group}<mesh><vertices>{corners}</vertices>'
        f"<triangles>{faces}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/><item objectid="1" partnumber="L-2"><metadatagroup>'
        '<metadata name="note">second</metadata></metadatagroup></item></build></model>'
    )
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
    mockup = load_mockup(tmp_path / "a.3mf")
    assert mockup.part_attributes == [
        {"number": "L-1", "Material": "PA 12", "note": "<b>"},
        {"number": "L-2", "note": "second", "Material": "PA 12"},
    ]


def test_materials_of_obj(tmp_path):
    lines = (
        "o A\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nusemtl Stainless steel\nf 1 2 4\nusemtl\tBrass\nf 1 3 4\n"
    )
    mockup = load_mockup(save(tmp_path, "a.obj", lines + "o B\nf 2 3 4\nusemtl Stainless steel\no C\nf 2 3 4\n"))
    found = [each.get("material") for each in mockup.part_attributes]
    assert found == ["Stainless steel, Brass", "Brass", "Stainless steel"]


def test_several_files_keep_theirs(tmp_path):
    save(tmp_path, "b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    instances(tmp_path / "a.glb", [{"extras": {"a": 1}}])
    instances(tmp_path / "c.glb", [{"extras": {"c": 1}}])
    assert load_mockup(tmp_path, unit="m").part_attributes == [{"a": "1"}, {}, {"c": "1"}]


# --- the face ----------------------------------------------------------------------------------------------------


def test_attributes_of_callers_are_checked():
    mockup = row({"a": "1"}, {})
    for wrong, kind in (
        ([{}], MeshError),
        ([{"a": 1}, {}], MeshError),
        ([{1: "a"}, {}], MeshError),
        (["text", {}], MeshError),
        (7, MeshError),
        ([{"": "a"}, {}], LimitError),
        ([{"n" * 101: "a"}, {}], LimitError),
        ([{"a": "v" * 1001}, {}], LimitError),
        ([{str(i): "a" for i in range(101)}, {}], LimitError),
    ):
        with pytest.raises(kind, match="part_attributes"):
            mockup.part_attributes = wrong
    assert mockup.part_attributes == [{"a": "1"}, {}]
    assert mockup.parts.search("a:1").tolist() == [0]
    mockup.part_attributes = [{}, {"a": "1"}]
    assert mockup.parts.search("a:1").tolist() == [1]  # the parts know of the new ones
    mockup.part_attributes = None
    assert mockup.part_attributes == [{}, {}] and mockup.parts.search("a:1").tolist() == []


def test_they_are_saved_and_travel(tmp_path):
    given = [{"material": HTML}, {}, {"material": "é\ud800"}]
    scene = feeler.Scene(row(*given))
    scene.save(tmp_path / "a.feeler")
    opened = feeler.open_scene(tmp_path / "a.feeler")
    for each in (opened.mockup, pickle.loads(pickle.dumps(opened.mockup)), pickle.loads(pickle.dumps(scene.mockup))):
        assert each.part_attributes == given and each.parts.select("material:IMG").tolist() == [0]
    assert feeler.Tool(opened.mockup).part_attributes == given
    assert load_tool(tmp_path / "a.feeler").part_attributes == given
    gone = feeler.open_scene(tmp_path / "a.feeler").mockup
    (tmp_path / "a.feeler").rename(tmp_path / "b.feeler")
    assert pickle.loads(pickle.dumps(gone)).part_attributes == given, "its file is elsewhere"
    (tmp_path / "b.feeler").rename(tmp_path / "a.feeler")
    gone.part_attributes = None
    assert pickle.loads(pickle.dumps(gone)).part_attributes == [{}] * 3
    opened.mockup.part_attributes = [{}, {}, {"a": "b"}]
    assert pickle.loads(pickle.dumps(opened)).mockup.part_attributes == [{}, {}, {"a": "b"}]
    assert feeler.Tool.of_parts(scene.mockup, [0, 2]).part_attributes == [given[0], given[2]]
    path = instances(tmp_path / "a.glb", [{"extras": {"a": 1}}])
    for _ in range(2):
        assert load_mockup(path, cache=tmp_path / "cache").part_attributes == [{"a": "1"}]


def test_sections_of_later_versions_are_passed_over_and_damaged_ones_refused():
    data = to_bytes(row({"a": "1"}, {})._part_attributes)
    assert from_bytes(data, 2) == ({"a": "1"}, {})
    assert from_bytes(data.replace(b'"version":1', b'"version":2'), 2) is None
    for wrong in (
        data.replace(b'"1"', b"1"),
        data.replace(b"[0,1]", b"[0,9]"),
        data.replace(b"[0,1]", b"[0]"),
        data.replace(b'[{"a"', b'{"a":[{"a"').replace(b"}]", b"}]}"),
    ):
        assert wrong != data
        with pytest.raises(ValueError):
            from_bytes(wrong, 2)


# --- search ------------------------------------------------------------------------------------------------------

PARTS = (
    {"Material": "Stainless Steel", "size": "M8"},
    {"props.material": "steel", "note": "for 12:30"},
    {"material": "PVC"},
    {"size": "12"},
    {},
)


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ("material:steel", [0, 1]),
        ("MATERIAL:STEEL", [0, 1]),
        ('material:"stainless steel"', [0]),
        ('"material:stainless steel"', [0]),
        ('material:"stainless steel', [0]),
        ("material:steel pump", [0]),
        ("pump material:steel size:m", [0]),
        ("material:", [0, 1, 2]),
        ("material:st??l", [1]),
        ("material:*steel*", [0, 1]),
        ("props.material:steel", [1]),
        ("note:12:30", [1]),
        ("a:b", [2]),
        ("plant a:b material:pvc", [2]),
        ("erial:steel", []),
        ("steel:material", []),
        ("", []),
        (":", [2]),
        ("PLANT", [0, 1, 2, 3, 4]),
    ],
)
def test_search(query, found):
    parts = row(*PARTS).parts
    assert parts.search(query).tolist() == found
    words = [term for term in terms(query) if term.name]
    if not words:
        return
    if found:
        assert parts.select(query).tolist() == found
    else:
        with pytest.raises(OptionError, match="no part has"):
            parts.select(query)


def test_paths_and_patterns_come_before_attributes():
    mockup = row(*PARTS)
    mockup = feeler.Mockup(
        mockup.vertices,
        mockup.faces,
        mockup.part_of_face,
        ["material:pvc", "x/a:b", "C:/b", "valve", "bolt"],
        part_attributes=[{"material": "PVC"}] * 5,
    )
    select = mockup.parts.select
    assert select("material:pvc").tolist() == [0] and select("material:p*").tolist() == [0]
    assert select("x/a:b").tolist() == [1] and select("C:").tolist() == [2] and select("*:b").tolist() == [1]
    assert select("material:PVC").tolist() == [0, 1, 2, 3, 4]
    with pytest.raises(OptionError, match=r"no part has the path, name or attribute 'materiel:pvc'; .* 'material'"):
        select("materiel:pvc")
    with pytest.raises(OptionError, match="no part has the path or name 'valvo'; do you mean 'valve'"):
        select("valvo")


def test_scenes_and_rules_take_them():
    mockup = row(*PARTS)
    scene = feeler.Scene(mockup)
    assert scene.without("material:steel").part_mask.tolist() == [False, False, True, True, True]
    assert scene.only(["material:pvc", "size:"]).part_mask.tolist() == [True, False, True, True, False]
    rule = {"name": "dear", "a": "material:steel", "b": "material:pvc", "clearance": 1.5}
    found = feeler.clash(mockup, rules={"rule": [rule]})
    assert [(each.a, each.b, each.rule) for each in found] == [(1, 2, "dear")]


# --- commands and the page ---------------------------------------------------------------------------------------


def test_info_lists_them(tmp_path):
    path = instances(tmp_path / "a.glb", [{"extras": {"layer": "piping"}}, {"translation": [2, 0, 0]}], {"std": HTML})
    (report,) = run_json("info", path)["files"]
    assert [part["attributes"] for part in report["part_list"]] == [{"layer": "piping", "std": HTML}, {"std": HTML}]
    assert "std (2 parts), layer (1 part)" in run("info", path).stdout


def test_options_take_searches(tmp_path):
    path = instances(
        tmp_path / "a.glb", [{"extras": {"layer": str(i)}, "translation": [2 * i, 0, 0]} for i in range(3)]
    )
    words = ("clearance", path, "--part", "layer:0", "--within", "100")
    assert len(run_json(*words)["poses"][0]["parts"]) == 2
    assert len(run_json(*words, "--without", "layer:1")["poses"][0]["parts"]) == 1
    said = "--without: no part has the path, name or attribute 'layer:7'"
    assert said in error_of(*words, "--without", "layer:7")


def attributed() -> feeler.Mockup:
    mockup = stand()
    mockup.part_attributes = [{"material": f"{HTML} steel"} if path != PATHS[RIGHT] else {} for path in PATHS]
    return mockup


def found(made: Bench, query: str) -> list[int]:
    answer = made.session.ask("find", {"query": query})
    parts = np.frombuffer(base64.b64decode(answer["parts"]), "<u4").tolist()
    assert len(parts) == answer["count"]
    return parts


def test_the_page_gets_attributes_when_it_asks():
    made = Bench(cube(), mockup=attributed(), absent=[PLATE, SHEET])
    assert "steel" not in json.dumps(made.session.manifest()) + json.dumps(made.document)
    assert made.session.ask("part", {"part": LEFT})["attributes"] == {"material": f"{HTML} steel"}
    assert made.session.ask("part", {"part": RIGHT})["attributes"] == {}
    assert made.session.ask("part", {"part": PLATE})["attributes"] == {}, "it was left out"
    assert found(made, "material:STEEL") == [1, 3] and found(made, "material:steel peg") == [3]
    assert found(made, "posts") == [1, 2] and found(made, "material:brass") == []
    made.command("hide", parts="material:steel posts")
    assert made.document["hidden"] == [LEFT]
    for wrong in ({"query": 1}, {"query": " "}, {"query": "x" * 100_000}, {}):
        with pytest.raises(feeler.WorkbenchError):
            made.session.ask("find", wrong)


def test_names_are_given_when_a_mesh_is_made() -> None:
    """The parts, their index, and what is found by them would keep the former ones."""
    mesh = trimesh.creation.box()
    for made in (feeler.Mockup({"a": mesh}), feeler.Tool(mesh.vertices, mesh.faces, "a")):
        for name in ("part_names", "part_paths"):
            with pytest.raises(AttributeError):
                setattr(made, name, ["b"])
            assert getattr(made, name) == ("a",) == (made.parts[0].name,)
        assert getattr(pickle.loads(pickle.dumps(made)), name) == ("a",)
