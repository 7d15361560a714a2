"""STL, OFF and PLY as people's programs write them: every spelling and layout that can be told reads alike."""

from __future__ import annotations

import re

import numpy as np
import pytest
from loading import notes, save, soup
from test_io_builders import CORNERS, FACES, SOUP, stl_binary, stl_text

from feeler import LoadError
from feeler.io import load_mockup

# --- STL --------------------------------------------------------------------------------------------------------------

SPELLINGS = {
    "capitals": str.upper,
    "end in two words": lambda t: t.replace("endloop", "end loop").replace("endfacet", "end facet"),
    "endsolid in two words": lambda t: t.replace("endsolid", "End Solid"),
    "endsolid and the name in one": lambda t: t.replace("endsolid ", "endsolid"),
    "endsolid without a name": lambda t: t.replace("endsolid one", "endsolid").replace("endsolid two", "endsolid"),
    "endsolid with another name": lambda t: t.replace("endsolid ", "endsolid another "),
    "outerloop": lambda t: t.replace("outer loop", "outerloop"),
    "no loops": lambda t: "\n".join(line for line in t.splitlines() if "loop" not in line),
    "no endfacet": lambda t: "\n".join(line for line in t.splitlines() if "endfacet" not in line),
    "no normals": lambda t: t.replace("facet normal 0 0 1", "facet"),
    "normals that are no numbers": lambda t: t.replace("normal 0 0 1", "normal -1.#IND nan nan"),
    "facetnormal": lambda t: t.replace("facet normal", "facetnormal"),
    "tabs and empty lines": lambda t: t.replace(" ", "\t").replace("\n", "\n\n \n"),
    "a line ahead": lambda t: "\n\n  " + t,
    "one endsolid for all": lambda t: t.replace("endsolid one\n", ""),
    "statements share lines": lambda t: t.replace("\n    outer", " outer").replace("\n    endloop\n", " endloop "),
    "a facet a line": lambda t: t.replace("\n    ", " ").replace("\n  endfacet", " endfacet"),
    "one line": lambda t: t.replace("\n", " "),
    "two solids share a line": lambda t: t.replace("endsolid one\nsolid two", "endsolid one solid two"),
    "a solid on one line": lambda t: t[: t.index("solid two")].replace("\n", " ") + "\n" + t[t.index("solid two") :],
    "one line and no blanks at its ends": lambda t: " ".join(t.split()),
    "broken vertices": lambda t: t.replace("vertex ", "vertex\n").replace(".0 ", ".0\n"),
    "no blanks ahead": lambda t: "\n".join(line.strip() for line in t.splitlines()),
    "no last line end": str.rstrip,
    "exponents": lambda t: t.replace(" 10.0", " 1.0E+01").replace(" 20.0", " +2.e1").replace(" 30.0", " 3.0e+001"),
}  # fmt: skip


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_stl_spelling(tmp_path, spelling):
    text = SPELLINGS[spelling](stl_text({"one": SOUP, "two": SOUP + 100}))
    assert text != stl_text({"one": SOUP, "two": SOUP + 100})
    mockup = load_mockup(save(tmp_path, "a.stl", text), unit="m")
    assert np.array_equal(soup(mockup), np.concatenate([SOUP, SOUP + 100]))
    assert [name.lower() for name in mockup.part_names] == ["one", "two"]
    assert mockup.part_of_face.tolist() == [0] * 4 + [1] * 4
    assert not mockup.report.source.notes


def test_stl_names_may_hold_keywords_and_blanks(tmp_path):
    wanted = ["end facet normal", "solid vertex x 1", "my solid  part #3", "endsolid"]
    mockup = load_mockup(save(tmp_path, "a.stl", stl_text({name: SOUP for name in wanted})))
    assert list(mockup.part_names) == wanted and mockup.triangle_count == 16


def test_stl_with_the_name_glued_to_solid(tmp_path):
    assert load_mockup(save(tmp_path, "a.stl", stl_text().replace("solid tet", "solidtet"))).part_names == ("tet",)


def test_stl_triangles_outside_of_solids_are_read(tmp_path):
    lines = stl_text().splitlines()
    mockup = load_mockup(save(tmp_path, "a.stl", "\n".join(lines[1:])))
    assert mockup.triangle_count == 4 and mockup.part_names == ("a",)
    mockup = load_mockup(save(tmp_path, "a.stl", "\n".join(lines + lines[1:])))
    assert mockup.triangle_count == 8


def test_stl_lines_of_other_kinds_are_counted(tmp_path):
    text = stl_text().replace("  facet", "color 1 0 0\n  facet", 2)
    assert "2 lines that are not STL were ignored, the first is line 2" in notes(
        load_mockup(save(tmp_path, "a.stl", text))
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("      vertex 10.0 0.0 0.0\n", ""),
        ("endloop", "vertex 1 1 1\nendloop"),
        ("vertex 10.0 0.0 0.0", "vertex 10.0 0.0"),
        ("vertex 10.0 0.0 0.0", "vertex 10.0 0.0 0,5"),
        ("vertex 10.0 0.0 0.0", "corner 10.0 0.0 0.0"),
        ("facet normal 0 0 1\n", "\n"),
        ("endloop", "endloop\nendsolid\nsolid"),
    ],
)
@pytest.mark.parametrize("relay", [False, True])
def test_stl_that_is_broken_in_the_middle(tmp_path, old, new, relay):
    good = stl_text()
    text = good.replace(old, new, 1)
    if relay:
        good, text = good.replace("\n    endloop", " endloop"), text.replace("\n    endloop", " endloop")
    assert load_mockup(save(tmp_path, "good.stl", good)).triangle_count == 4
    with pytest.raises(LoadError, match=r"a\.stl, line \d"):
        load_mockup(save(tmp_path, "a.stl", text))


@pytest.mark.parametrize("layout", ["lines", "one line"])
def test_stl_cut_anywhere_is_refused_or_noted(tmp_path, layout):
    text = stl_text() if layout == "lines" else stl_text().replace("\n", " ")
    whole = 0
    for length in range(6, text.index("endsolid") + 8):
        path = save(tmp_path, "a.stl", text[:length])
        try:
            mockup = load_mockup(path)
        except LoadError:
            continue
        whole += 1
        # Only a cut between two triangles is not to be told from a file that never had an endsolid.
        assert text[:length].rstrip().endswith("endfacet") or length == text.index("endsolid") + 8 - 1 + 1
        assert "truncated" in notes(mockup)
    assert (whole > 0) == (layout == "lines")


@pytest.mark.parametrize("layout", ["one line", "a facet a line", "a word a line"])
def test_stl_of_another_layout_is_refused_for_what_is_wrong(tmp_path, layout):
    text = stl_text()
    relay = {
        "one line": lambda t: t.replace("\n", " "),
        "a facet a line": lambda t: re.sub(r"\n(?!  facet|endsolid)", " ", t),
        "a word a line": lambda t: "\n".join(t.split()),
    }[layout]
    name = text.index("\n") + 1
    for end in [
        found.end() for found in re.finditer(r"\S+", text[: text.index("endsolid")]) if found.end() > name + 80
    ]:
        with pytest.raises(LoadError) as error:
            load_mockup(save(tmp_path, "a.stl", relay(text[:end])))
        said = str(error.value)
        whole = text[:end].split()
        at = len(whole) - max(i for i, word in enumerate(whole) if word in ("vertex", "facet", "endfacet"))
        if whole[-at] == "vertex" and at < 4:
            assert "statement" in said and ("a vertex needs three numbers" in said or "broken here" in said)
        else:
            assert "truncated" in said


@pytest.mark.parametrize("header", [b"made by a test", b"solid of spaces".ljust(80)])
@pytest.mark.parametrize("count", [0, 5, 2**32 - 1])
def test_stl_binary_with_a_wrong_count_is_read_by_its_size(tmp_path, header, count):
    content = bytearray(stl_binary(header=header))
    content[80:84] = count.to_bytes(4, "little")
    mockup = load_mockup(save(tmp_path, "a.stl", bytes(content)), unit="m")
    assert np.array_equal(soup(mockup), SOUP)
    assert len(mockup.report.source.doubts) == 1
    assert f"the header says {count:,} triangles, and the file holds 4" in mockup.report.source.doubts[0]


def test_stl_binary_without_a_count_and_with_bytes_behind_it_is_refused_for_that(tmp_path):
    content = bytearray(stl_binary()) + b"end"
    content[80:84] = bytes(4)
    with pytest.raises(LoadError, match="the header says 0 triangles, and 4 triangles and 3 bytes of another follow"):
        load_mockup(save(tmp_path, "a.stl", bytes(content)), unit="m")


@pytest.mark.parametrize("count", [0, 4, 5, 6, 2**32 - 1])
@pytest.mark.parametrize("cut", [10, 49, 51])
def test_stl_binary_that_is_cut_is_refused(tmp_path, count, cut):
    content = bytearray(stl_binary())
    content[80:84] = count.to_bytes(4, "little")
    with pytest.raises(LoadError, match=r"truncated|no triangle"):
        load_mockup(save(tmp_path, "a.stl", bytes(content[:-cut])))


# --- OFF --------------------------------------------------------------------------------------------------------------

VERTICES = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS.tolist())
POLYGONS = "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES.tolist())
WHOLE = VERTICES.replace(".0", "")
PLAIN = VERTICES + POLYGONS


def with_more(text: str, more: str) -> str:
    return text.replace("\n", f" {more}\n")


OFF_FILES = {
    "no keyword": "4 4 6\n" + PLAIN,
    "no keyword, one line": ("4 4 6\n" + PLAIN).replace("\n", " "),
    "small letters": "off\n4 4 6\n" + PLAIN,
    "no number of edges": "OFF\n4 4\n" + PLAIN,
    "no number of edges, behind the keyword": "OFF 4 4\n" + PLAIN,
    "a count a line": "OFF\n4\n4\n6\n" + PLAIN,
    "a count a line, no edges": "OFF\n4\n4\n" + PLAIN,
    "the count glued to the keyword": "OFF4 4 6\n" + PLAIN,
    "glued, no edges": "OFF4 4\n" + PLAIN,
    "comments": "# a  \n# b\nOFF # c\n# d\n4 4 6 # e\n\n# f\n" + with_more(PLAIN, "# 1 2 3") + "# end\n",
    "colours": "COFF\n4 4 6\n" + with_more(VERTICES, "255 0 0 255") + POLYGONS,
    "colours in a row": ("COFF\n4 4 6\n" + with_more(VERTICES, "255 0 0 255") + POLYGONS).replace("\n", " "),
    "three colours in a row": ("COFF\n4 4 6\n" + with_more(VERTICES, "0.5 0 0") + POLYGONS).replace("\n", " "),
    "colours on lines of their own": "COFF\n4 4 6\n" + VERTICES.replace("\n", "\n3 0 1 2\n") + POLYGONS,
    "whole colours on lines of their own": "COFF\n4 4 6\n" + WHOLE.replace("\n", "\n3 0 1 2\n") + POLYGONS,
    "whole coordinates, no edges": "OFF\n4 4\n" + WHOLE + POLYGONS,
    "colours of polygons": "OFF\n4 4 6\n" + VERTICES + with_more(POLYGONS, "0.5 0.5 0.5"),
    "colours of some": "OFF\n4 4 6\n" + PLAIN.replace("3 1 2 3", "3 1 2 3 7").replace("3 2 0 3", "3 2 0 3 1 1 1"),
    "normals": "NOFF\n4 4 6\n" + with_more(VERTICES, "0 0 1") + POLYGONS,
    "normals in a row": ("NOFF\n4 4 6\n" + with_more(VERTICES, "0 0 1") + POLYGONS).replace("\n", " "),
    "all": "STCNOFF\n4 4 6\n" + with_more(VERTICES, "0 0 1 1 1 1 1 0.5 0.5") + with_more(POLYGONS, "1 0 0"),
    "all in a row": ("STCNOFF\n4 4 6\n" + with_more(VERTICES, "0 0 1 1 1 1 1 0.5 0.5") + POLYGONS).replace("\n", " "),
    "two a line": "OFF\n4 4 6\n0 0 0 10 0 0\n0 20 0 0 0 30\n3 0 2 1 3 0 1 3\n3 1 2 3 3 2 0 3\n",
    "wrapped, colours": "OFF\n4 4 6\n" + PLAIN.replace("10.0 0", "10.0\n0").replace("3 0 2 1", "3 0\n2 1 9 9 9"),
    "one line": ("OFF\n4 4 6\n" + PLAIN).replace("\n", " "),
}  # fmt: skip


@pytest.mark.parametrize("layout", OFF_FILES)
def test_off_layout(tmp_path, layout):
    mockup = load_mockup(save(tmp_path, "a.off", OFF_FILES[layout]), unit="m")
    assert np.array_equal(soup(mockup), SOUP)
    assert not mockup.report.source.notes


def test_off_points_and_lines_are_counted(tmp_path):
    text = "OFF\n4 7 6\n" + PLAIN + "1 0\n2 0 1\n2 1 2\nrest\n"
    said = notes(load_mockup(save(tmp_path, "a.off", text)))
    assert "1 point was skipped" in said and "2 lines were skipped" in said and "1 line after the last" in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("4OFF\n4 4 6\n" + PLAIN, "three dimensions"),
        ("nOFF\n3\n4 4 6\n" + PLAIN, "three dimensions"),
        ("OFF BINARY\n" + PLAIN, "binary OFF"),
        ("OFF\n4 5 6\n" + PLAIN, "truncated"),
        ("OFF 4 5 6 " + PLAIN.replace("\n", " "), "truncated"),
        (
            "OFF 4 4 6 " + PLAIN.replace("3 0 1 3", "3 0 1 9").replace("\n", " "),
            r"line 1: polygon 2 of the 4 .*'3 0 1 9",
        ),
        ("OFF\n4 four 6\n" + PLAIN, "missing"),
        ("blob\n4 4 6\n" + PLAIN, "starts with 'OFF'"),
        ("OFF\n4 4 6\n" + PLAIN.replace("3 0 1 3", "5 0 1 3"), "line 8: the polygon promises 5 corners"),
    ],
)
def test_off_that_is_refused(tmp_path, text, words):
    with pytest.raises(LoadError, match=words):
        load_mockup(save(tmp_path, "a.off", text))


# --- words and header that disagree -----------------------------------------------------------------------------------

CUBE_VERTICES = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1"
CUBE_FACES = "3 0 2 1 3 0 3 2 3 4 5 6 3 4 6 7 3 0 1 5 3 0 5 4 3 1 2 6 3 1 6 5 3 2 3 7 3 2 7 6 3 3 0 4 3 3 4 7"
CUBE = f"{CUBE_VERTICES} {CUBE_FACES}".split()
IN_WORDS = {
    "a.off": "OFF 8 12 18 ",
    "a.ply": "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 12\nproperty list uchar int vertex_indices\nend_header\n",
}
ROW = {"a.off": "polygon {} of the 12", "a.ply": "row {} of the 12 rows of 'face'"}


@pytest.mark.parametrize("name", IN_WORDS)
@pytest.mark.parametrize("between", [" ", "\n", "  \n\n"])
def test_words_cut_anywhere(tmp_path, name, between):
    for count in range(len(CUBE)):
        path = save(tmp_path, name, IN_WORDS[name] + between.join(CUBE[:count]))
        with pytest.raises(LoadError) as error:
            load_mockup(path)
        said = str(error.value)
        row = ROW[name].format((count - 24) // 4 + 1) if count >= 24 else "vertex"
        assert row in said or (count < 36 and "bytes" in said)  # fewer bytes than the shortest numbers need
        assert "truncated" in said


@pytest.mark.parametrize("name", IN_WORDS)
@pytest.mark.parametrize("between", [" ", "\n"])
@pytest.mark.parametrize("word", ["7", "0", "3", "0.5", "1e3"])
def test_a_word_too_many_anywhere(tmp_path, name, between, word):
    for at in range(len(CUBE) + 1):
        words = [*CUBE[:at], word, *CUBE[at:]]
        path = save(tmp_path, name, IN_WORDS[name] + between.join(words))
        try:
            mockup = load_mockup(path)
        except LoadError as error:
            assert re.search("left over|the file ends (in|before) (polygon|row)", str(error))
            if at == len(CUBE):
                assert ": 1 words are left over" in str(error)
        else:
            # The words fit: a triangle became a quad whose corners all exist.
            assert word in "703" and 44 <= at <= 67 and mockup.triangle_count == 13


@pytest.mark.parametrize("name", IN_WORDS)
@pytest.mark.parametrize("between", [" ", "\n"])
def test_a_word_that_is_no_number(tmp_path, name, between):
    head = IN_WORDS[name]
    for at in range(len(CUBE)):
        words = [*CUBE[:at], "seven", *CUBE[at + 1 :]]
        line = head.count("\n") + 1 + (at if between == "\n" else 0)
        with pytest.raises(LoadError, match=rf"line {line}: 'seven' is not"):
            load_mockup(save(tmp_path, name, head + between.join(words)))


@pytest.mark.parametrize("name", IN_WORDS)
@pytest.mark.parametrize("count", [8, 19])
def test_lines_cut_anywhere(tmp_path, name, count):
    lines = [" ".join(CUBE[3 * i : 3 * i + 3]) + " 100 100 100 255" for i in range(8)]
    lines += [" ".join(CUBE[24 + 4 * i : 28 + 4 * i]) for i in range(12)]
    promised = {"a.off": f"and {count} lines with", "a.ply": f"and {count - 8} lines follow"}[name]
    with pytest.raises(LoadError, match=promised):
        load_mockup(save(tmp_path, name, IN_WORDS[name].rstrip() + "\n" + "\n".join(lines[:count]) + "\n"))


# --- PLY --------------------------------------------------------------------------------------------------------------

HEAD = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
FACE_HEAD = "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
PLY_FILES = {
    "vertex_index": HEAD + FACE_HEAD.replace("indices", "index") + PLAIN,
    "another name": HEAD + FACE_HEAD.replace("vertex_indices", "corners") + PLAIN,
    "indices as float": HEAD + FACE_HEAD.replace("uchar int", "uint8 float32") + PLAIN.replace("3 0 2", "3 0. 2"),
    "types in capitals": HEAD.replace("float", "Float64") + FACE_HEAD.replace("uchar int", "UINT8 Int32") + PLAIN,
    "axes in capitals": HEAD.replace("t x", "t X").replace("t z", "t Z") + FACE_HEAD + PLAIN,
    "comments": HEAD.replace("element", "comment the\ncomment end_header\nobj_info x\nelement") + FACE_HEAD + PLAIN,
    "comment with a long word": HEAD.replace("element", "comment no end_header here\nelement") + FACE_HEAD + PLAIN,
    "blanks": HEAD.replace("\n", " \t\n") + FACE_HEAD.replace("end_header", "  end_header  ") + PLAIN,
    "one line": HEAD + FACE_HEAD + PLAIN.replace("\n", " "),
    "a word a line": HEAD + FACE_HEAD + PLAIN.replace(" ", "\n"),
    "two a line": HEAD + FACE_HEAD + "0 0 0 10 0 0\n0 20 0 0 0 30\n3 0 2 1 3 0 1 3\n3 1 2 3 3 2 0 3\n",
    "two vertices a line": HEAD + FACE_HEAD + "0 0 0 10 0 0\n0 20 0 0 0 30\n" + POLYGONS,
    "two a line, values behind them": HEAD + FACE_HEAD.replace("end_header", "property uchar red\nend_header")
    + "0 0 0 10 0 0\n0 20 0 0 0 30\n3 0 2 1 9 3 0 1 3 9\n3 1 2 3 9 3 2 0 3 9\n",
    "wrapped": HEAD + FACE_HEAD + PLAIN.replace("10.0 0", "10.0\n0").replace("3 0 2 1", "3 0\n2 1"),
    "more on a line than a row": HEAD + FACE_HEAD + with_more(PLAIN, "7"),
    "empty lines": HEAD + FACE_HEAD + PLAIN.replace("\n", "\n\n"),
    "windows": (HEAD + FACE_HEAD + PLAIN).replace("\n", "\r\n"),
    "old mac": (HEAD + FACE_HEAD + PLAIN).replace("\n", "\r"),
    "axes in another order": HEAD.replace("t x", "t w").replace("t z", "t x").replace("t w", "t z")
    + FACE_HEAD + "".join(f"{z} {y} {x}\n" for x, y, z in CORNERS.tolist()) + POLYGONS,
}  # fmt: skip


@pytest.mark.parametrize("layout", PLY_FILES)
def test_ply_layout(tmp_path, layout):
    mockup = load_mockup(save(tmp_path, "a.ply", PLY_FILES[layout]), unit="m")
    assert np.array_equal(soup(mockup), SOUP)
    assert not mockup.report.source.notes


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_ply_binary_whose_body_begins_with_a_line_end(tmp_path, end, mark):
    corners = CORNERS.astype("<f4")
    corners[0, 0] = np.frombuffer(b"\n\r\n\0", dtype="<f4")[0]
    head = (HEAD.replace("ascii", "binary_little_endian") + FACE_HEAD).encode().replace(b"\n", end)
    body = corners.tobytes() + b"".join(b"\3" + row.astype("<i4").tobytes() for row in FACES)
    mockup = load_mockup(save(tmp_path, "a.ply", mark + head + body), unit="m")
    assert np.array_equal(soup(mockup), corners[FACES])
    source = load_mockup(save(tmp_path, "b.ply", head + body + b"end")).report.source
    assert any("3 bytes after" in note for note in source.notes) and not source.doubts


@pytest.mark.parametrize("encoding", ["ascii", "binary_big_endian"])
def test_ply_rows_of_other_elements_are_counted_by_name(tmp_path, encoding):
    head = HEAD.replace("ascii", encoding) + "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
    head += "element material 1\nproperty list uchar float colour\n" + FACE_HEAD
    if encoding == "ascii":
        content = (head + VERTICES + "0 1\n1 2\n2 0.5 0.5\n" + POLYGONS + "surplus\n").encode()
    else:
        content = head.encode() + CORNERS.astype(">f4").tobytes() + np.array([0, 1, 1, 2], dtype=">i4").tobytes()
        content += b"\2" + np.array([0.5, 0.5], dtype=">f4").tobytes()
        content += b"".join(b"\3" + row.astype(">i4").tobytes() for row in FACES) + b"end"
    mockup = load_mockup(save(tmp_path, "a.ply", content), unit="m")
    assert np.array_equal(soup(mockup), SOUP)
    said = notes(mockup)
    assert "2 rows of 'edge' were skipped" in said and "1 row of 'material' was skipped" in said
    assert ("1 line after the last row" if encoding == "ascii" else "3 bytes after the last row") in said


def test_ply_words_of_other_elements_are_passed_over(tmp_path):
    """Rows of two lists, and edges, two a line: what is no face is counted, and moves nothing."""
    edges = "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
    marks = FACE_HEAD.replace("end_header", "property list uchar float mark\nend_header")
    rows = "0 1 1 2\n3 0 2 1 0 3 0 1 3 2 0.5 0.5\n3 1 2 3 1 7 3 2 0 3 0\n"
    mockup = load_mockup(save(tmp_path, "a.ply", HEAD + edges + marks + VERTICES + rows), unit="m")
    assert np.array_equal(soup(mockup), SOUP)
    assert mockup.report.source.notes == ("2 rows of 'edge' were skipped: only triangles collide",)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_ply_two_elements_of_faces_are_both_read(tmp_path, encoding):
    half = FACE_HEAD.replace("face 4", "face 2").replace("end_header\n", "")
    head = HEAD.replace("ascii", encoding) + half + half + "end_header\n"
    rows = b"".join(b"\3" + row.astype("<i4").tobytes() for row in FACES)
    content = (head + PLAIN).encode() if encoding == "ascii" else head.encode() + CORNERS.astype("<f4").tobytes() + rows
    assert np.array_equal(soup(load_mockup(save(tmp_path, "a.ply", content), unit="m")), SOUP)


def test_ply_strips_restart_and_rows_do_not_run_together(tmp_path):
    head = HEAD + "element tristrips 5\nproperty list int int vertex_indices\nend_header\n"
    rows = "4 0 1 2 3\n0\n9 0 1 2 -1 3 2 -1 1 0\n2 1 2\n5 -1 1 2 3 0\n"
    mockup = load_mockup(save(tmp_path, "a.ply", head + VERTICES + rows))
    assert mockup.faces.tolist() == [[0, 1, 2], [2, 1, 3], [0, 1, 2], [1, 2, 3], [3, 2, 0]]
    assert "5 rows of triangle strips" in notes(mockup)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("property float y", "propperty float y", r"line 5: 'propperty float y' is not a valid"),
        ("element face", "element vertex 1\nproperty float x\nelement face", "several elements 'vertex'"),
        ("3 0 2 1", "3 0 2", r"line 14: the face promises more values"),
        ("float x", "float q", "no x, y and z"),
        ("3 2 0 3\n", "", "promises 4 rows of 'face', and 3 lines follow"),
    ],
)
def test_ply_that_is_refused(tmp_path, old, new, words):
    with pytest.raises(LoadError, match=words):
        load_mockup(save(tmp_path, "a.ply", (HEAD + FACE_HEAD + PLAIN).replace(old, new, 1)))


def test_ply_index_that_is_no_whole_number_is_out_of_range(tmp_path):
    text = HEAD + FACE_HEAD.replace("uchar int", "uchar float") + PLAIN.replace("3 0 2 1", "3 0 2.5 1")
    assert load_mockup(save(tmp_path, "a.ply", text)).report.defects["index_out_of_range"].first == (0,)


@pytest.mark.parametrize("kind", ["off", "ply in text", "ply"])
def test_faces_that_the_header_did_not_count_are_a_doubt(tmp_path, kind):
    few = len(FACES) - 1
    if kind == "off":
        path = save(tmp_path, "a.off", f"OFF\n4 {few} 6\n{PLAIN}{POLYGONS}")
    else:
        head = (HEAD + FACE_HEAD).replace(f"face {len(FACES)}", f"face {few}")
        if kind == "ply":
            rows = b"".join(b"\3" + row.astype(">i4").tobytes() for row in FACES)
            head = head.replace("ascii", "binary_big_endian")
            path = save(tmp_path, "a.ply", head.encode() + CORNERS.astype(">f4").tobytes() + rows)
        else:
            path = save(tmp_path, "a.ply", head + VERTICES + POLYGONS)
    mockup = load_mockup(path, unit="m")
    assert len(mockup.faces) == few
    (doubt,) = mockup.report.source.doubts
    assert "after the last" in doubt and "ignored: the header says" in doubt and str(few) in doubt
