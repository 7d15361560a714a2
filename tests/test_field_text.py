"""Text files as people's programs write them: encodings, spellings, layouts."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from loading import notes, save, soup
from shapes import box
from test_io_builders import SOUP, Gltf, obj_text, off_text, ply, stl_binary, stl_text

import feeler
from feeler import LoadError, Mockup, PoseError
from feeler.clashes.rules import Rules
from feeler.cli.inputs import read_path, read_poses
from feeler.io import load_mockup
from feeler.io.sniff import identify
from feeler.io.text import text_of
from feeler.workbench.document.findings import read_findings


def volume(mockup: Mockup) -> float:
    a, b, c = np.moveaxis(soup(mockup), 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


# --- cubes of 10 mm: 8 vertices, 12 triangles, closed ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("obj_bom.obj", ["obj_bom"]),  # begins with a byte order mark, and at once with a vertex
        ("obj_hash_names.obj", ["obj_hash_names/Bolt #1", "obj_hash_names/Bolt #2"]),  # named apart behind the #
        ("off_free_lines.off", ["off_free_lines"]),  # all vertices on one line, all triangles on the next
        ("off_modelnet.off", ["off_modelnet"]),  # "OFF8 12 0"
        ("stl_end_loop.stl", ["stl_end_loop/box"]),  # "end loop", "end facet"
        ("stl_end_solid.stl", ["stl_end_solid/box"]),  # "end solid box"
        ("stl_endsolidname.stl", ["stl_endsolidname/box"]),  # "endsolidbox"
    ],
)
def test_a_cube(testdata, name, parts):
    mockup = load_mockup(testdata / "files" / name)
    assert list(mockup.part_paths) == parts
    assert [part.triangles for part in mockup.parts] == [12 // len(parts)] * len(parts)
    assert len(mockup.vertices) == 8
    assert volume(mockup) == pytest.approx(1e-6, rel=1e-12)
    assert mockup.report.not_queried == 0 and not mockup.report.source.notes


# --- encodings ------------------------------------------------------------------------------------------------------

TEXTS = {
    "a.stl": stl_text({"Größe 5 мм": SOUP}),
    "a.obj": obj_text().replace("left side", "Größe 5 мм"),
    "a.off": off_text(),
    "a.ply": ply("ascii").decode(),
}


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize(
    "encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-16-be with a mark", "utf-32"]
)
def test_every_encoding_reads_as_plain_text_does(tmp_path, name, encoding):
    plain = load_mockup(save(tmp_path, name, TEXTS[name]))
    mark, _, _ = encoding.partition(" with")
    content = (("\ufeff" if " with" in encoding else "") + TEXTS[name]).encode(mark)
    assert content != TEXTS[name].encode()
    (tmp_path / "other").mkdir()
    mockup = load_mockup(save(tmp_path / "other", name, content))
    assert np.array_equal(soup(mockup), soup(plain))
    assert mockup.part_paths == plain.part_paths
    if name in ("a.stl", "a.obj"):
        assert any("Größe 5 мм" in path for path in mockup.part_paths)
    # The content tells the format, whatever the name says (of OBJ, where it says nothing).
    assert identify(save(tmp_path, "a" if name == "a.obj" else "a.glb", content))[0] == plain.report.source.format


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le"])
@pytest.mark.parametrize(
    ("text", "format_name"),
    [
        ("ISO-10303-21;\nHEADER;\n", "STEP"),
        ('{"asset": {"version": "2.0"}}', "glTF"),
        ('<?xml version="1.0"?>\n<COLLADA version="1.4.1">', "COLLADA"),
    ],
)
def test_a_mark_does_not_hide_the_format(tmp_path, encoding, text, format_name):
    assert identify(save(tmp_path, "a.bin", text.encode(encoding)))[0] == format_name


def test_a_binary_stl_with_a_wide_header_is_binary(tmp_path):
    header = "Größe, made by a program".encode("utf-16")
    assert np.array_equal(soup(load_mockup(save(tmp_path, "a.stl", stl_binary(header=header)), unit="m")), SOUP)


def test_names_in_the_encoding_of_windows_stay_apart(tmp_path):
    text = obj_text().replace("left side", "Gehäuse").replace("g right", "g Gehöuse")
    mockup = load_mockup(save(tmp_path, "m.obj", text.encode("cp1252")))
    assert mockup.part_names == ("Gehäuse", "Gehöuse", "plate")
    assert load_mockup(save(tmp_path, "e.obj", TRIANGLE.encode() + b"g \x80 5\nf 1 2 3\n")).part_names == (
        "\N{EURO SIGN} 5",
    )
    # 0x81 and 0x9d are no characters there.
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\ng \x81\nf 1 2 3\ng \x9d\nf 1 2 3\n"
    assert load_mockup(save(tmp_path, "n.obj", text)).part_count == 2


@pytest.mark.parametrize("name", TEXTS)
def test_line_ends_of_any_kind_even_mixed(tmp_path, name):
    lines = TEXTS[name].splitlines()
    mixed = "".join(line + ("\n", "\r\n", "\r")[i % 3] for i, line in enumerate(lines))
    if name == "a.ply":
        mixed = TEXTS[name].replace("\n", "\r\n")  # the first line of a PLY file says how the lines of its header end
    plain = load_mockup(save(tmp_path, name, TEXTS[name]))
    assert np.array_equal(soup(load_mockup(save(tmp_path, name, mixed))), soup(plain))


def test_gltf_text_with_a_mark(tmp_path):
    g = Gltf()
    g.node(mesh=g.mesh(), name="part")
    uri = "data:application/octet-stream;base64," + base64.b64encode(g.blob).decode()
    mockup = load_mockup(save(tmp_path, "a.gltf", b"\xef\xbb\xbf" + g.gltf(uri)))
    assert np.array_equal(soup(mockup), SOUP)


# --- poses, rules and findings ----------------------------------------------------------------------------------------

POSE = np.array([[0.0, -1.0, 0.0, 0.5], [1.0, 0.0, 0.0, -1.25], [0.0, 0.0, 1.0, 1e-3], [0.0, 0.0, 0.0, 1.0]])
ROWS = [[f"{value:g}" for value in row] for row in POSE.tolist()]
POSE_TEXTS = {
    "blanks": "\n".join(" ".join(row) for row in ROWS),
    "commas": "\n".join(", ".join(row) for row in ROWS),
    "commas, one line": ",".join(",".join(row) for row in ROWS),
    "semicolons": ";".join(";".join(row) for row in ROWS) + "\n",
    "semicolons at the ends": "\n".join(";".join(row) + ";" for row in ROWS),
    "semicolons between rows": "; ".join(", ".join(row) for row in ROWS),
    "decimal commas": "\n".join(";".join(row) for row in ROWS).replace(".", ","),
    "decimal commas and tabs": "\t".join("\t".join(row) for row in ROWS).replace(".", ","),
    "comments": "# a; b, c\n" + "\n".join("; ".join(row) + " # 1,5; Höhe" for row in ROWS),
}


@pytest.mark.parametrize("layout", POSE_TEXTS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
@pytest.mark.parametrize("count", [1, 3])
def test_poses_as_text(tmp_path, layout, encoding, count):
    text = (POSE_TEXTS[layout] + "\n") * count
    for first in ("sep=;\n", '"sep=;"\n'):  # of Excel
        assert np.array_equal(read_poses(save(tmp_path, "b.csv", (first + text).encode(encoding))), [POSE] * count)
    poses = read_poses(save(tmp_path, "a.csv", text.replace("\n", "\r\n").encode(encoding)))
    assert np.array_equal(poses, [POSE] * count)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (POSE_TEXTS["decimal commas"].replace("0,5", "0,5,1"), "not a multiple of 16"),
        (POSE_TEXTS["semicolons"].replace("0.5", "0.5x"), "'0.5x' is not a number"),
        ("x;y;z\n" + POSE_TEXTS["semicolons"], "'x' is not a number"),
    ],
)
def test_poses_as_text_that_are_refused(tmp_path, text, words):
    with pytest.raises(PoseError, match=words):
        read_poses(save(tmp_path, "a.csv", text))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_rules_findings_and_poses_in_any_encoding(tmp_path, encoding):
    """As PowerShell and editors of Windows save them."""
    cubes = Mockup({"Größe 5": Mockup(*box([0, 0, 0], [1, 1, 1])), "b": Mockup(*box([0.9, 0, 0], [2, 1, 1]))})
    found = feeler.clash(cubes)
    found.save(tmp_path / "plain.json")
    text = (tmp_path / "plain.json").read_text(encoding="utf-8")
    again = feeler.load_clashes(save(tmp_path, "a.json", text.encode(encoding)))
    assert again.ids == found.ids and again[0].path_a == found[0].path_a
    rules = 'version = 1\n[[exclude]]\nname = "Größe"\na = "Größe 5"\nb = "*"\n'
    left = feeler.clash(cubes, rules=save(tmp_path, "r.toml", rules.encode(encoding)))
    assert len(found) == 1 and len(left) == 0
    poses = read_poses(save(tmp_path, "p.json", json.dumps({"pose": POSE.tolist()}).encode(encoding)))
    assert np.array_equal(poses, [POSE])


@pytest.mark.parametrize(
    ("name", "read", "kind"),
    [
        ("r.toml", Rules.read, LoadError),
        ("c.json", feeler.load_clashes, LoadError),
        ("f.json", read_findings, LoadError),
        ("p.json", read_poses, PoseError),
        ("q.json", read_path, PoseError),
        ("m.gltf", load_mockup, LoadError),
    ],
)
def test_text_of_an_encoding_that_does_not_say_so(tmp_path, name, read, kind):
    """As old programs of Windows write it: the message has the file, the line and the encoding, nothing of codecs."""
    text = (
        'version = 1\n# "Gehäuse"\n' if name.endswith("toml") else '{"asset": {"version": "2.0"},\n"name": "Gehäuse"}'
    )
    path = save(tmp_path, name, text.encode("cp1252"))
    with pytest.raises(kind, match=r", line 2: this is not UTF-8 .* such as Windows-1252 \('.*Gehäuse") as error:
        read(path)
    assert str(path) in str(error.value) and "codec" not in str(error.value) and "0x" not in str(error.value)


# --- OBJ --------------------------------------------------------------------------------------------------------------

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def test_obj_names_keep_their_hash_and_other_lines_lose_it(tmp_path):
    text = "# a comment\n  # another\n" + TRIANGLE.replace("0\n", "0 # corner\n")
    text += "o Bolt #1 # left\ng #7\nf 1 2 3#first\no Bolt #2\ng\nf 1 3 2 # second\n#g none\nf 2 3 1\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert mockup.part_paths == ("m/Bolt #1 # left/#7", "m/Bolt #2")
    assert mockup.part_of_face.tolist() == [0, 1, 1]
    assert not mockup.report.source.notes


@pytest.mark.parametrize("end", ["\\\n", "\\ \t\r\n"])
def test_obj_continued_lines(tmp_path, end):
    text = f"v 0 0 {end} 0\nv 1{end}0 0\nv 0 1 0\nv 1 1 0\nf 1 {end} 2 {end} 3\nf 2 4 3\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert mockup.faces.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert "joined" in notes(mockup)


def test_obj_a_windows_path_does_not_swallow_the_next_line(tmp_path):
    text = (
        f"# from C:\\models\\\n{TRIANGLE}mtllib C:\\models\\\nv 0 0 1\ng C:\\parts\\\nf 1 2 3\nf 1 2 4 # \\\nf 1 3 4\n"
    )
    mockup = load_mockup(save(tmp_path, "m.obj", text))
    assert mockup.triangle_count == 3 and len(mockup.vertices) == 4
    assert mockup.part_names == ("C:\\parts\\",)
    assert mockup.report.not_queried == 0 and not mockup.report.source.notes


def test_obj_colours_and_weights(tmp_path):
    text = "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0 1\nv 0 1 0 1\nv 0 0 1 2.5\nv 1 1 1 1.0 0 0 1\nf 1 2 3\nf 2 3 4\nf 3 4 5\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text), unit="m")
    expected = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    assert np.array_equal(soup(mockup), expected[[[0, 1, 2], [1, 2, 3], [2, 3, 4]]])
    assert notes(mockup).startswith("1 vertex has a weight w other than 1")


@pytest.mark.parametrize(
    "word", ["-1.#IND", "1.#IND00", "1.#QNAN", "1.#SNAN0", "-1.#inf", "1.#INF00", "nan", "-nan(ind)", "inf"]
)
@pytest.mark.parametrize("chunk_bytes", [None, 40])
def test_obj_vertices_that_are_no_numbers(tmp_path, monkeypatch, word, chunk_bytes):
    """Such a vertex keeps its place, or faces would take others. It puts answers in doubt only if a face uses it."""
    if chunk_bytes:
        monkeypatch.setattr("feeler.io.text.CHUNK_BYTES", chunk_bytes)
    text = f"v 7 {word} 0 # no corner\n{TRIANGLE}vn {word} {word} {word}\nf 2//1 3//1 4//1 # {word}\n"
    mockup = load_mockup(save(tmp_path, "m.obj", text), unit="m")
    assert np.array_equal(soup(mockup), [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    assert notes(mockup) == "1 vertex has a coordinate that is no finite number, the first is line 1"
    assert not mockup.report.source.doubts
    mockup = load_mockup(save(tmp_path, "n.obj", text + "f 1 2 3\n"))
    assert mockup.report.defects["non_finite"].first == (1,)
    assert mockup.report.source.doubts[0].startswith("1 triangle has a vertex that does not exist or is no finite")


def test_obj_names_keep_what_looks_like_no_number(tmp_path):
    text = f"{TRIANGLE}g 1.#IND 1.#INF\nv 0 0 1.#IND\nf 1 2 3\n"
    assert load_mockup(save(tmp_path, "m.obj", text)).part_names == ("1.#IND 1.#INF",)


def test_obj_group_of_several_names_is_one_part(tmp_path):
    text = TRIANGLE + "g arm left\nf 1 2 3\ng left arm\nf 1 2 3\ng\nf 1 2 3\n"
    assert load_mockup(save(tmp_path, "m.obj", text)).part_names == ("arm left", "left arm", "m")


def test_obj_old_word_for_a_face(tmp_path):
    assert load_mockup(save(tmp_path, "m.obj", TRIANGLE + "fo 1 2 3\n")).triangle_count == 1


@pytest.mark.parametrize("chunk_bytes", [None, 40])
def test_obj_counts_by_name_what_is_no_triangle(tmp_path, monkeypatch, chunk_bytes):
    if chunk_bytes:
        monkeypatch.setattr("feeler.io.text.CHUNK_BYTES", chunk_bytes)
    text = TRIANGLE + "s off\nusemtl red\nvn 0 0 1\nvt 0 0\nlod 1\nf 1 2 3\np 1 2\np 3\nl 1 2\nvp 0 1\nvp 1 1\n"
    text += "cstype bezier\ndeg 3\nCurv 0 1 1 2 3\ncurv2 1 2\nparm u 0 1\nend\nsurf 0 1 0 1 1\nbzp 1\ncall other.obj\n"
    text += "blob 5\nblob 6\nwhatnot\n"
    said = notes(load_mockup(save(tmp_path, "m.obj", text)))
    for words in (
        "2 points were skipped", "1 line was skipped", "1 free-form curve (curv) was skipped",
        "1 free-form curve on a surface (curv2)", "1 free-form surface (surf)", "shape of old (bzp)",
        "1 call of other files (call)", "vp (2), cstype (1), deg (1), parm (1), end (1)",
        "3 lines with keywords that are not OBJ were ignored, the first is line 24: 'blob' (2), 'whatnot' (1)",
    ):  # fmt: skip
        assert words in said
    for word in ("usemtl", "vn", "lod", "'s'"):
        assert word not in said


@pytest.mark.parametrize(
    ("cut", "is_doubtful"), [("f", True), ("f 1", True), ("f 1 2", True), ("f 1 2\nv 1 1 1", False)]
)
def test_obj_that_ends_in_a_face(tmp_path, cut, is_doubtful):
    doubts = load_mockup(save(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n" + cut)).report.source.doubts
    assert [doubt.startswith("the last line is a face") for doubt in doubts] == [True] * is_doubtful


def test_a_binary_file_is_no_text(tmp_path: Path) -> None:
    file = tmp_path / "mesh.toml"
    file.write_bytes(b"glTF\x02\x00\x00\x00\xff\xfe\x80")
    with pytest.raises(LoadError, match="is no text file"):
        text_of(file)
