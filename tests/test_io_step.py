"""STEP: parts in other files, colours, names, encodings, and what is no surface. Variants are made by editing text."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest
from loading import notes, save, soup

import feeler.io.step
from feeler import LoadError, Mockup
from feeler.io import load_mockup
from feeler.io.step_external import Named, find, referenced_files
from feeler.io.step_names import Assembly, place_name
from feeler.io.step_source import for_converter, left_out, misplaced
from feeler.io.step_text import entities, plain_text, string_text

needs_step = pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")

FILES = Path(__file__).parent.parent / "testdata" / "files"
ASSEMBLY = (FILES / "step_external_some.step").read_text()  # asm: housing here, bolt in bolt.step, at x = 100 mm
COLOURS = (FILES / "step_two_colours.step").read_text()  # a box "bracket" of 10 x 20 x 30 mm, two faces coloured
BOLT = COLOURS.replace("'bracket','bracket'", "'screw','screw'")
NOT_FOUND = 'part "bolt" is in the file bolt.step, which was not found beside it'
BOX = [[0, 0, 0], [0.01, 0.02, 0.03]]


def paths(mockup: Mockup) -> list[str]:
    return [part.path for part in mockup.parts]


def boxes(mockup: Mockup) -> np.ndarray:
    return np.array([[part.lower, part.upper] for part in mockup.parts])


def moved(*offset: float) -> np.ndarray:
    return np.add(BOX, offset)


def without_housing(text: str) -> str:
    return text.replace("MANIFOLD_SOLID_BREP", "NO_SOLID")


def is_closed(mockup: Mockup) -> bool:
    """Tell whether every edge, of corners that lie together, is there once in each direction."""
    around = np.unique(soup(mockup).reshape(-1, 3).round(9), axis=0, return_inverse=True)[1].reshape(-1, 3)
    edges = [tuple(edge) for edge in np.stack([around, np.roll(around, -1, axis=1)], axis=-1).reshape(-1, 2).tolist()]
    return len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)


def fails(path: Path, *words: str) -> str:
    with pytest.raises(LoadError) as caught:
        load_mockup(path)
    for word in words:
        assert word in str(caught.value)
    return str(caught.value)


# --- parts in other files ----------------------------------------------------------------------------------------


@needs_step
@pytest.mark.parametrize(
    ("named", "lies"),
    [
        ("bolt.step", "bolt.step"),
        ("bolt.step", "Bolt.STEP"),
        ("bolt.step", "bolt.stp"),
        ("bolt.STP", "bolt.step"),
        ("bolt", "bolt.stp"),
        ("parts/m6/bolt.step", "parts/m6/bolt.step"),
        (r".\\Parts\\m6\\bolt.step", "parts/M6/bolt.step"),
        ("my%20bolt.step", "my bolt.step"),
        (r"bolt \X2\00E4\X0\.step", "bolt ä.step"),
    ],
)
def test_a_part_in_another_file_is_placed_where_the_assembly_has_it(tmp_path, named, lies):
    (tmp_path / lies).parent.mkdir(parents=True, exist_ok=True)
    save(tmp_path, lies, BOLT)
    mockup = load_mockup(save(tmp_path, "main.step", ASSEMBLY.replace("bolt.step", named)))
    assert paths(mockup) == ["main/asm/housing", "main/asm/bolt/screw"]
    assert np.allclose(boxes(mockup), [BOX, moved(0.1, 0, 0)], atol=1e-8)
    assert mockup.triangle_count == 24 and is_closed(mockup)
    assert "parts were read from other files" in notes(mockup) and "OpenCASCADE said" not in notes(mockup)


@needs_step
def test_a_part_whose_file_is_missing_is_named(tmp_path):
    mockup = load_mockup(save(tmp_path, "main.step", ASSEMBLY))
    assert paths(mockup) == ["main/asm/housing"]
    assert mockup.report.source.notes.count(NOT_FOUND) == 1
    assert "OpenCASCADE said" not in notes(mockup)


@needs_step
def test_many_missing_parts_leave_room_for_what_the_converter_says(tmp_path):
    """Seven products without a shape, and a reference to an entity that is not there."""
    more = "".join(
        f"#{n}0=PRODUCT('p{n}','p{n}','',(#3));\n#{n}1=PRODUCT_DEFINITION_FORMATION('','',#{n}0);\n"
        f"#{n}2=PRODUCT_DEFINITION('','',#{n}1,#4);\n#{n}3=PRODUCT_DEFINITION_SHAPE('','',#{n}2);\n"
        f"#{n}4=SHAPE_REPRESENTATION('',(#193),#9);\n#{n}5=SHAPE_DEFINITION_REPRESENTATION(#{n}3,#{n}4);\n"
        for n in range(31, 38)
    )
    text = ASSEMBLY.replace("ENDSEC;\nEND", more + "#999=VECTOR('',#998,1.);\nENDSEC;\nEND")
    mockup = load_mockup(save(tmp_path, "main.step", text))
    assert "7 parts have no surface in the file ('p31', 'p32', 'p33', 'p34', 'p35', ...)" in notes(mockup)
    said = [note for note in mockup.report.source.notes if note.startswith("OpenCASCADE said")]
    assert said and all("Unresolved" in note for note in said)


@needs_step
def test_no_part_in_the_file_and_none_found(tmp_path):
    fails(save(tmp_path, "main.step", without_housing(ASSEMBLY)), "main.step", NOT_FOUND, "put these files")


@needs_step
def test_no_part_in_the_file_and_all_found(tmp_path):
    save(tmp_path, "bolt.step", BOLT)
    mockup = load_mockup(save(tmp_path, "main.step", without_housing(ASSEMBLY)))
    assert paths(mockup) == ["main/asm/bolt/screw"]
    assert np.allclose(mockup.bounds, moved(0.1, 0, 0), atol=1e-8)
    assert "1 part has no surface in the file ('housing')" in notes(mockup)


@needs_step
def test_a_folder_with_the_assembly_and_its_parts(tmp_path):
    save(tmp_path, "bolt.step", BOLT)
    save(tmp_path, "main.step", ASSEMBLY)
    mockup = load_mockup(tmp_path)
    assert paths(mockup) == ["bolt/screw", "main/asm/housing", "main/asm/bolt/screw"]
    assert "they are there twice" in notes(mockup)
    (tmp_path / "bolt.step").unlink()
    save(tmp_path, "main.step", without_housing(ASSEMBLY))
    shutil.copy(FILES / "up_axis.step", tmp_path / "post.step")
    partly = load_mockup(tmp_path)
    assert paths(partly) == ["post/post"]
    assert any(NOT_FOUND in doubt for doubt in partly.report.source.doubts)


@needs_step
def test_assemblies_in_assemblies_move_their_parts_by_both_placements(tmp_path):
    """The inner assembly is turned by 90 degrees about z and moved by 50 mm in y; its bolt is at x = 100 mm in it."""
    turned = ASSEMBLY.replace("(100.0,0.0,0.0)", "(0.0,50.0,0.0)").replace(
        "#188=DIRECTION('',(1.0,0.0,0.0))", "#188=DIRECTION('',(0.0,1.0,0.0))"
    )
    save(tmp_path, "bolt.step", BOLT)
    save(tmp_path, "inner.step", ASSEMBLY)
    mockup = load_mockup(save(tmp_path, "outer.step", turned.replace("bolt.step", "inner.step")))
    assert paths(mockup) == ["outer/asm/housing", "outer/asm/bolt/asm/housing", "outer/asm/bolt/asm/bolt/screw"]
    near, far = [[-0.02, 0.05, 0], [0, 0.06, 0.03]], [[-0.02, 0.15, 0], [0, 0.16, 0.03]]
    assert np.allclose(boxes(mockup), [BOX, near, far], atol=1e-7)


@needs_step
def test_units_of_other_files_are_their_own(tmp_path):
    save(tmp_path, "bolt.step", BOLT.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)"))
    mockup = load_mockup(save(tmp_path, "main.step", ASSEMBLY))
    assert mockup.report.source.unit == "mm"
    assert np.allclose(mockup.parts[1].upper, [0.2, 0.2, 0.3], atol=1e-7)


@needs_step
def test_files_that_hold_each_other(tmp_path):
    save(tmp_path, "bolt.step", ASSEMBLY.replace("bolt.step", "main.step"))
    mockup = load_mockup(save(tmp_path, "main.step", ASSEMBLY))
    assert paths(mockup) == ["main/asm/housing", "main/asm/bolt/asm/housing"]
    around = 'part "bolt" is in the file main.step, which holds itself (main.step > bolt.step > main.step)'
    assert around in notes(mockup)
    own = load_mockup(save(tmp_path, "own.step", ASSEMBLY.replace("bolt.step", "own.step")))
    assert paths(own) == ["own/asm/housing"] and "own.step > own.step" in notes(own)


@needs_step
@pytest.mark.parametrize(
    "named", ["../bolt.step", "sub/../../bolt.step", r"..\\bolt.step", "{}/bolt.step", "link.step"]
)
def test_files_outside_of_the_folder_are_not_read(tmp_path, named):
    folder = tmp_path / "here"
    (folder / "sub").mkdir(parents=True)
    outside = save(tmp_path, "bolt.step", BOLT)
    if named == "link.step":
        (folder / "link.step").symlink_to(outside)
    name = named.format(tmp_path.as_posix())
    mockup = load_mockup(save(folder, "main.step", ASSEMBLY.replace("bolt.step", name)))
    assert paths(mockup) == ["main/asm/housing"]
    assert "so was not read" in notes(mockup) and name.replace(r"\\", "\\") in notes(mockup)


@pytest.mark.parametrize("name", ["C:/cad/b.step", "C:b.step", r"\\host\b.step", "http://h/b.step", "file:b.step"])
def test_full_paths_and_addresses_are_not_looked_up(tmp_path, name):
    save(tmp_path, "b.step", "")
    place = find(Named((name,)), tmp_path, tmp_path)
    assert place.path is None and "full path or address" in place.why_not


def test_a_file_in_a_subfolder_may_name_one_above_it(tmp_path):
    (tmp_path / "sub").mkdir()
    save(tmp_path, "b.step", "")
    assert find(Named(("../b.step",)), tmp_path / "sub", tmp_path).path == (tmp_path / "b.step").resolve()
    assert find(Named(("../b.step",)), tmp_path / "sub", tmp_path / "sub").path is None
    (tmp_path / "loop.step").symlink_to("loop.step")
    assert find(Named(("loop.step",)), tmp_path, tmp_path).path is None
    save(tmp_path, "b.prt", "")
    assert "not a STEP file" in find(Named(("b.prt",)), tmp_path, tmp_path).why_not


@needs_step
@pytest.mark.parametrize(("content", "words"), [(BOLT[:3000], "truncated"), ("", "ISO-10303-21")])
def test_a_damaged_file_of_a_part_is_named(tmp_path, content, words):
    save(tmp_path, "bolt.step", content)
    mockup = load_mockup(save(tmp_path, "main.step", ASSEMBLY))
    assert paths(mockup) == ["main/asm/housing"]
    assert 'part "bolt" is in the file bolt.step, which cannot be read' in notes(mockup) and words in notes(mockup)


LINKS = {
    "the document itself": (
        "#196=DOCUMENT_FILE('bolt.step','','',#195,'','');\n#197=APPLIED_DOCUMENT_REFERENCE(#196,'',(#184));"
    ),
    "AP203, with its documents": (
        "#196=DOCUMENT_FILE('bolt.step','','',#195,'','');\n"
        "#184=PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS('','',#183,#4,(#196));"
    ),
    "a number, and the file as source": (
        "#196=DOCUMENT_FILE('D-17','Bolt M6','',#195,'',$);\n#197=APPLIED_DOCUMENT_REFERENCE(#196,'',(#184));\n"
        "#198=EXTERNAL_SOURCE(IDENTIFIER('bolt.step'));\n"
        "#200=APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT('#196',#199,#198,(#196));"
    ),
    "a folder as source": (
        "#196=DOCUMENT_FILE('D-17','','',#195,'',$);\n#197=APPLIED_DOCUMENT_REFERENCE(#196,'',(#184));\n"
        "#198=EXTERNAL_SOURCE(IDENTIFIER('./'));\n"
        "#200=APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT('bolt.step',#199,#198,(#196));"
    ),
    "the formation": (
        "#196=DOCUMENT_FILE('bolt.step','','',#195,'','');\n#197=APPLIED_DOCUMENT_REFERENCE(#196,'',(#183));"
    ),
    "a property of the file that is the shape": (
        "#196=DOCUMENT_FILE('bolt.step','','',#195,'','');\n#301=PROPERTY_DEFINITION('external definition',$,#196);\n"
        "#302=PROPERTY_DEFINITION_REPRESENTATION(#301,#194);"
    ),
    "a document that stands for a definition with files": (
        "#196=DOCUMENT_FILE('bolt.step','','',#195,'','');\n#310=DOCUMENT('d','','',#195);\n"
        "#197=APPLIED_DOCUMENT_REFERENCE(#310,'',(#184));\n"
        "#311=PRODUCT('doc','doc','',(#3));\n#312=PRODUCT_DEFINITION_FORMATION('','',#311);\n"
        "#313=PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS('','',#312,#4,(#196));\n"
        "#314=DOCUMENT_PRODUCT_EQUIVALENCE('equivalence',$,#310,#312);"
    ),
}


def linked(way: str) -> str:
    lines = [line for line in ASSEMBLY.split("\n") if line.split("=")[0] not in ("#196", "#197", "#198", "#200")]
    text = "\n".join(lines).replace("ENDSEC;\nEND-ISO", LINKS[way] + "\nENDSEC;\nEND-ISO")
    return text.replace("#184=PRODUCT_DEFINITION('','',#183,#4);\n", "") if "#184=" in LINKS[way] else text


@needs_step
@pytest.mark.parametrize("way", LINKS)
def test_ways_to_name_the_file_of_a_part(tmp_path, way):
    save(tmp_path, "bolt.step", BOLT)
    mockup = load_mockup(save(tmp_path, "main.step", linked(way)))
    assert sorted(paths(mockup)) == ["main/asm/bolt/screw", "main/asm/housing"]
    assert np.allclose(boxes(mockup)[1], moved(0.1, 0, 0), atol=1e-8)
    assert "OpenCASCADE said" not in notes(mockup)


def test_the_converter_opens_no_other_file():
    for way in LINKS:
        text = for_converter(linked(way).encode())
        assert not list(entities(text, "APPLIED_DOCUMENT_REFERENCE", "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"))
        if "#184=" in LINKS[way]:
            assert b"#184=PRODUCT_DEFINITION('','',#183,#4);" in text


# --- colours and faces -------------------------------------------------------------------------------------------


@needs_step
def test_colours_are_no_missing_faces(testdata):
    mockup = load_mockup(testdata / "files" / "step_two_colours.step")
    assert mockup.triangle_count == 12 and is_closed(mockup)
    assert len(mockup.report.source.notes) == 1 and "chord tolerance" in notes(mockup)


@needs_step
def test_a_missing_face_is_noted_also_beside_colours(tmp_path):
    """The first plane, of a coloured face, becomes something that OpenCASCADE does not know."""
    mockup = load_mockup(save(tmp_path, "a.step", COLOURS.replace("#64=PLANE(", "#64=PLAIN(")))
    assert mockup.triangle_count == 10
    assert "1 of the 6 faces in the STEP file have no triangle" in notes(mockup)


# --- names and encodings -----------------------------------------------------------------------------------------

NAMES = {
    r"M6 \X2\00E400DF\X0\ \X2\4E2D6587\X0\ ": "M6 äß 中文",
    r"it''s": "it's",
    r"\X\E9t\X\E9": "été",
    r"\S\d": "ä",
    r"\PE\\S\2": "\N{CYRILLIC CAPITAL LETTER VE}",
    r"\X4\0001F600\X0\ ": "😀",
    r"a\\b": "a\\b",
    r"a/* no comment */b; #10=PRODUCT(": "a_* no comment *_b; #10=PRODUCT(",
}


@needs_step
@pytest.mark.parametrize("written", NAMES)
def test_names_of_parts(tmp_path, written):
    mockup = load_mockup(save(tmp_path, "a.step", COLOURS.replace("'bracket','bracket'", f"'','{written}'")))
    assert paths(mockup) == [f"a/{NAMES[written]}"]


def test_escapes_are_undone_once():
    assert string_text(rb"\\X2\\00E4\\X0\\") == r"\X2\00E4\X0" + "\\"
    assert string_text(b"two\nlines") == "twolines"
    assert string_text(rb"\X2\D83DDE00\X0\ \X2\zz\X0\ \Q") == "\U0001f600 \\X2\\zz\\X0\\ \\Q"


@needs_step
@pytest.mark.parametrize(
    ("occurrence", "name"),
    [
        ("left \\X2\\00E4\\X0\\", "left ä (housing)"),
        ("Housing:1", "Housing:1"),
        ("housing-12", "housing-12"),
        ("HOUSING", "housing"),
        ("A", "A (housing)"),
        ("NAUO17", "housing"),
        ("17", "housing"),
        ("", "housing"),
    ],
)
def test_a_part_is_called_by_its_place_and_product(tmp_path, occurrence, name):
    """The product is "housing"; the second occurrence has no name."""
    again = (
        "#304=NEXT_ASSEMBLY_USAGE_OCCURRENCE('9','','',#12,#20,$);\n#305=PRODUCT_DEFINITION_SHAPE('','',#304);\n"
        "#306=ITEM_DEFINED_TRANSFORMATION('','',#29,#189);\n"
        "#307=(REPRESENTATION_RELATIONSHIP('','',#180,#202) REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#306) "
        "SHAPE_REPRESENTATION_RELATIONSHIP());\n#308=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#307,#305);\n"
    )
    text = ASSEMBLY.replace("'1','housing'", f"'1','{occurrence}'").replace("ENDSEC;\nEND", again + "ENDSEC;\nEND")
    mockup = load_mockup(save(tmp_path, "a.step", text))
    assert paths(mockup) == [f"a/asm/{name}", "a/asm/housing" + ("#2" if name == "housing" else "")]
    assert [part.name for part in mockup.parts] == [name, "housing"]
    assert np.allclose(boxes(mockup), [BOX, moved(0.1, 0, 0)], atol=1e-8)


def test_a_product_without_a_name_leaves_that_of_its_place():
    assert place_name("Shaft", "2ec63c74-e48c-11f1-bab7-02fc00000001") == "Shaft"
    assert place_name("4", "2ec63c74-e48c-11f1-bab7-02fc00000001") == "2ec63c74-e48c-11f1-bab7-02fc00000001"


TESSELLATED = (
    "#300=COORDINATES_LIST('',4,((0.,0.,0.),(10.,0.,0.),(0.,10.,0.),(0.,0.,10.)));\n"
    "#301=TRIANGULATED_FACE('',#300,4,((0.,0.,1.)),$,(),((1,3,2),(1,2,4),(2,3,4),(1,4,3)));\n"
    "#302=TESSELLATED_SOLID('mesh',(#301),$);\n#303=TESSELLATED_SHAPE_REPRESENTATION('',(#302),#9);\n"
    "#304=SHAPE_DEFINITION_REPRESENTATION(#13,#303);\nENDSEC;\nEND"
)  # a tetrahedron as triangles (AP242), a shape of the product "bracket" beside the box


@needs_step
@pytest.mark.parametrize("plane", ["#64=PLANE(", "#64=PLAIN("])
def test_a_mesh_that_is_the_copy_of_a_solid_is_left_out(tmp_path, plane):
    text = COLOURS.replace("ENDSEC;\nEND", TESSELLATED.replace("(#301),$)", "(#301),#167)")).replace(
        "#64=PLANE(", plane
    )
    mockup = load_mockup(save(tmp_path, "a.step", text))
    assert paths(mockup) == ["a/bracket"]
    assert "1 mesh of parts that is there as B-rep was left out: the B-rep was taken ('mesh')" in notes(mockup)
    assert ("1 of the 6 faces" in notes(mockup)) == ("PLAIN" in plane) == (mockup.triangle_count == 10)


@needs_step
def test_a_missing_face_is_noted_also_beside_triangles(tmp_path):
    text = COLOURS.replace("ENDSEC;\nEND", TESSELLATED).replace("#64=PLANE(", "#64=PLAIN(")
    mockup = load_mockup(save(tmp_path, "a.step", text))
    assert mockup.triangle_count == 14 and "1 of the 7 faces" in notes(mockup)


@needs_step
def test_several_shapes_of_a_product_have_its_name(tmp_path):
    mockup = load_mockup(save(tmp_path, "a.step", COLOURS.replace("ENDSEC;\nEND", TESSELLATED)))
    assert paths(mockup) == ["a/bracket/bracket", "a/bracket/bracket#2"]
    assert mockup.triangle_count == 16 and "have no triangle" not in notes(mockup)


@needs_step
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings(tmp_path, encoding, end):
    text = COLOURS.replace("'bracket','bracket'", "'brücke','brücke'").replace("\n", end)
    mockup = load_mockup(save(tmp_path, "a.step", text.encode(encoding)))
    assert paths(mockup) == ["a/brücke"] and mockup.triangle_count == 12
    assert mockup.report.source.unit == "mm"


@needs_step
def test_comments_are_no_entities(tmp_path):
    commented = COLOURS.replace("#10=PRODUCT", "/* #10=PRODUCT('x','x','',(#3)); it's */ #10 /* a */ = PRODUCT")
    mockup = load_mockup(save(tmp_path, "a.step", commented))
    assert paths(mockup) == ["a/bracket"]
    assert plain_text(b"'/*' /* ' */ '*/' /* open") == b"'/*'   '*/'  "


SIGNATURE = "SIGNATURE;\n" + "MIIC6QYJKoZIhvcNAQcCoIIC2jCCAtYCAQExCTAHBgUrDgMCGjALBgkqhkiG9w0B\n" * 200 + "ENDSEC;\n"
FRAMES = {
    "a long signature": (COLOURS + SIGNATURE, "the signature was not checked"),
    "two signatures": (COLOURS + SIGNATURE + SIGNATURE, "the signature was not checked"),
    "zeros": (COLOURS + "\0" * 9000 + "\x1a", ""),
    "another file": (COLOURS + COLOURS.replace("bracket", "lid"), "another STEP file follows"),
    "a text": (COLOURS + "\nmade by hand\n", "a text of 12 bytes follows"),
    "comments in front": ("/* by x */\n /* it's\n longer" + "x" * 2000 + " */\n" + COLOURS, ""),
    "a blank in the end": (COLOURS.replace("END-ISO-10303-21;", "END-ISO-10303-21 ;\n/* by x */"), ""),
    "the end in a name": (COLOURS.replace("'bracket','bracket'", "'END-ISO-10303-21;','bracket'"), ""),
    "a section with parameters": (COLOURS.replace("DATA;", "DATA ('one',('AP214')) ;"), ""),
    "two sections": (COLOURS.replace("#64=PLANE(", "ENDSEC;\nDATA('two',('AP214'));\n#64=PLANE("), ""),
    "sections of edition 3": (COLOURS.replace("DATA;", "ANCHOR;\n<a>=#10;\nENDSEC;\nREFERENCE;\nENDSEC;\nDATA;"), ""),
    "sections in a name": (COLOURS.replace("'bracket','bracket'", "'ENDSEC; DATA; HEADER;','bracket'"), ""),
}  # fmt: skip


@needs_step
@pytest.mark.parametrize("frame", FRAMES)
def test_sections_and_what_follows_the_end(tmp_path, frame):
    text, words = FRAMES[frame]
    assert text != COLOURS
    mockup = load_mockup(save(tmp_path, "a.step", text))
    assert paths(mockup) == ["a/bracket"] and mockup.triangle_count == 12
    assert np.allclose(mockup.bounds, BOX)
    said = "\n".join(mockup.report.source.notes[:2])
    assert words in said and len(mockup.report.source.notes) == 1 + bool(words)
    assert bool(mockup.report.source.doubts) == (frame in ("another file", "a text"))


def test_without_opencascade_the_error_says_what_to_install(tmp_path, monkeypatch):
    """The converter has no wheels for some systems; all else of feeler works there."""
    worker = save(tmp_path, "worker.py", f"import sys\nsys.exit({feeler.io.step._NOT_INSTALLED})\n")
    monkeypatch.setattr("feeler.io.step._WORKER", worker)
    fails(save(tmp_path, "a.step", COLOURS), 'pip install "feeler[step]"')


@needs_step
def test_a_signature_alone_is_no_end(tmp_path):
    fails(save(tmp_path, "a.step", COLOURS.replace("END-ISO-10303-21;\n", "") + SIGNATURE), "truncated")


def test_arguments():
    (found,) = entities(b"#7 = PRODUCT ( $,'a''b',(#1,(.T.,#2),()),IDENTIFIER('c'),-1.5E0,($),*)", "PRODUCT")
    assert found.arguments == [None, "a'b", [1, [None, 2], []], ["c"], -1.5, [], None]
    assert found.all(2) == [1, 2] and found.text(3) == "c" and found.numbers(4) == [-1.5] and found.number == 7
    (open_list,) = entities(b"#7=PRODUCT((,'a'", "PRODUCT")
    assert open_list.text(0) == "" and open_list.all(0) == []


def test_damaged_arguments_end_somewhere():
    for text in (b"#1=PRODUCT('a", b"#1=PRODUCT((((", b"#1=PRODUCT('a','b';\n#2=X()", b"#1=PRODUCT(" + b"(" * 10**5):
        found = list(entities(text, "PRODUCT"))
        assert len(found) == 1 and found[0].refers(7) == 0 and found[0].text(7) == "" and found[0].all(7) == []
    assembly = Assembly(
        b"#1=PRODUCT_DEFINITION();#2=NEXT_ASSEMBLY_USAGE_OCCURRENCE($);#3=PRODUCT_DEFINITION('','',#1,#2);"
    )
    assert assembly.name(1) == "" and assembly.name(99) == ""
    broken = b"DOCUMENT_FILE #4=DOCUMENT_FILE();#5=APPLIED_DOCUMENT_REFERENCE();#6=DOCUMENT_FILE('a.stp');"
    assert referenced_files(broken, assembly) == {}


# --- placements --------------------------------------------------------------------------------------------------


def placed_by(way: str, first: str, second: str, third: str, scale: str) -> str:
    """The box or housing, placed by an operator at x = 50 mm: as a mapped item, or in the assembly."""
    operator = (
        f"#310=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',{first},{second},#307,{scale},{third});\n"
        "#307=CARTESIAN_POINT('',(50.,0.,0.));\n#321=DIRECTION('',(1.,0.,0.));\n#322=DIRECTION('',(0.,1.,0.));\n"
        "#323=DIRECTION('',(0.,0.,1.));\n#324=DIRECTION('',(-1.,0.,0.));\n#325=DIRECTION('',(0.,-1.,0.));\n"
    )
    if way == "assembly":
        text = ASSEMBLY.replace("#206=ITEM_DEFINED_TRANSFORMATION('','',#29,#25);", "")
        text = text.replace("_WITH_TRANSFORMATION(#206)", "_WITH_TRANSFORMATION(#310)")
    else:
        text = COLOURS.replace("REPRESENTATION('',(#17,#167),#9)", "REPRESENTATION('',(#17,#312),#9)")
        kind = "ADVANCED_BREP_SHAPE_REPRESENTATION" if way == "mapped" else "DRAUGHTING_SYMBOL_REPRESENTATION"
        operator += (
            f"#311={kind}('',(#17,#167),#9);\n#313=REPRESENTATION_MAP(#17,#311);\n#312=MAPPED_ITEM('',#313,#310);\n"
        )
    return text.replace("ENDSEC;\nEND", operator + "ENDSEC;\nEND")


@needs_step
@pytest.mark.parametrize("way", ["mapped", "assembly"])
@pytest.mark.parametrize(
    ("axes", "scale", "box"),
    [
        (("#321", "#322", "#323"), "1.", [[0.05, 0, 0], [0.06, 0.02, 0.03]]),
        (("$", "$", "$"), "$", [[0.05, 0, 0], [0.06, 0.02, 0.03]]),
        (("#324", "#325", "#323"), "1.0000000000001", [[0.04, -0.02, 0], [0.05, 0, 0.03]]),
        (("#324", "#322", "#323"), "1.", None),
        (("$", "#325", "$"), "1.", None),
        (("#321", "#322", "#323"), "2.", None),
    ],
)
def test_placements_by_an_operator(tmp_path, way, axes, scale, box):
    path = save(tmp_path, "a.step", placed_by(way, *axes, scale))
    if box is None:
        fails(path, "1 placement mirrors or scales a shape (#310)", "export the file again")
    else:
        assert np.allclose(boxes(load_mockup(path))[0], box, atol=1e-8)


def test_operators_of_drawings_may_scale():
    assert misplaced(placed_by("mapped", "$", "$", "$", "2.").encode()) == [310]
    assert misplaced(placed_by("drawing", "$", "$", "$", "2.").encode()) == []


# --- what is no surface ------------------------------------------------------------------------------------------


def test_references_of_edition_3_are_counted():
    text = b"ENDSEC;\nREFERENCE;\n#1=<bolt.step#part>;\n#2 = <nut.step#part> ;\nENDSEC;\nDATA;\n"
    said = "2 references by address (edition 3 of STEP) were not followed ('bolt.step#part', 'nut.step#part')"
    assert left_out(text) == [said] and left_out(COLOURS.encode()) == []


@needs_step
def test_curves_and_points_are_counted(tmp_path):
    drawn = (
        "#190=GEOMETRIC_CURVE_SET('sketch',(#37,#43,#18));\n#191=EDGE_BASED_WIREFRAME_MODEL('frame',(#192));\n"
        "#192=CONNECTED_EDGE_SET('',(#38));\n"
    )
    text = COLOURS.replace("ENDSEC;\nEND", drawn + "ENDSEC;\nEND")
    mockup = load_mockup(save(tmp_path, "a.step", text))
    said = [
        "1 point was left out: only surfaces collide ('sketch')",
        "2 curves were left out: only surfaces collide ('sketch')",
        "1 wireframe model was left out: only surfaces collide ('frame')",
    ]
    assert mockup.triangle_count == 12 and all(line in mockup.report.source.notes for line in said)
    nothing = text.replace(
        "ADVANCED_BREP_SHAPE_REPRESENTATION('',(#17,#167),#9)", "SHAPE_REPRESENTATION('',(#17,#190),#9)"
    )
    fails(save(tmp_path, "b.step", nothing), "found no surface", "export it with solids or shells", *said)
