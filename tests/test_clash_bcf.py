"""BCF is valid by its schemas for any name: no blank text where they ask for some, no character that XML lacks."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from clash_scene import mockup_of
from shapes import box

import feeler
from feeler.clashes import write_bcf
from feeler.clashes.as_bcf import left_out
from feeler.clashes.words import title

NAMES = {
    **{"blanks": "  ", "nothing": "", "tab": "\t", "no-break space": "\u00a0", "line breaks": "\r\n"},
    **{"control": "a\x01b", "surrogate": "\ud800x", "no character": "\ufffe", "folder": "a/ "},
    **{"long": "x" * 5000, "emoji": "\U0001f600", "end of CDATA": "]]>", "markup": "<b>&\"'"},
}


def elements(path: Path) -> list[ElementTree.Element]:
    """All elements of all documents; reading them is what finds characters that XML lacks."""
    with zipfile.ZipFile(path) as archive:
        texts = [archive.read(name) for name in archive.namelist() if not name.endswith(".png")]
    return [element for text in texts for element in ElementTree.fromstring(text).iter()]


def written(path: Path, name: str, **options: str) -> Path:
    mockup = mockup_of({name: box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (2, 1, 1))})
    assert write_bcf(path / "a.bcf", feeler.clash(mockup), mockup, **options) == 1  # type: ignore[arg-type]
    return path / "a.bcf"


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES.keys())
def test_no_text_is_blank(tmp_path: Path, name: str) -> None:
    found = elements(written(tmp_path, name))
    leaves = [element for element in found if not len(element) and not element.attrib]
    assert len(leaves) > 20 and all((element.text or "").strip() for element in leaves)


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES.keys())
def test_a_library_of_others_reads_any_name(tmp_path: Path, name: str) -> None:
    bcfxml = pytest.importorskip("bcf.v3.bcfxml")
    with bcfxml.BcfXml.load(written(tmp_path, name)) as read:
        ((topic),) = read.topics.values()
        (view,) = topic.viewpoints.values()
        assert all(each.authoring_tool_id for each in view.visualization_info.components.selection.component)
        assert topic.topic.title and topic.topic.description


def test_a_blank_author_is_feeler(tmp_path: Path) -> None:
    authors = [
        each.text for each in elements(written(tmp_path, "a", author=" ")) if each.tag in ("User", "CreationAuthor")
    ]
    assert authors == ["feeler", "feeler"]


def test_a_title_is_no_longer_than_trackers_show(tmp_path: Path) -> None:
    found = {element.tag: element.text or "" for element in elements(written(tmp_path, "x" * 5000))}
    assert len(found["Title"]) == 250 and found["Title"].endswith("\u2026") and "x" * 5000 in found["Description"]


def rows_of_pairs(count: int) -> tuple[feeler.Mockup, feeler.Clashes]:
    """Pairs of cubes far apart, each deeper than the next: a group each."""
    shapes = {}
    for k in range(count):
        shapes[f"a{k}"] = box((3 * k, 0, 0), (3 * k + 1, 1, 1))
        shapes[f"b{k}"] = box((3 * k + 0.5 + 0.01 * k, 0, 0), (3 * k + 2, 1, 1))
    mockup = mockup_of(shapes)
    return mockup, feeler.clash(mockup, 0.0)


def titles(path: Path) -> list[str]:
    return [each.text or "" for each in elements(path) if each.tag == "Title"]


def test_groups_with_decisions_come_before_worse_ones(tmp_path: Path) -> None:
    """The file is full: what somebody decided is in it, and what `diff` made active is no decision."""
    mockup, found = rows_of_pairs(6)
    before = rows_of_pairs(6)[1]
    before.set_status(before.ids[4], "approved")
    before.set_status(before.ids[5], "active", note="ask ada")
    found.diff(before)
    assert set(found.statuses.tolist()) == {"active", "approved"}
    for most, rows in ((1, [4]), (2, [4, 5]), (3, [0, 4, 5]), (6, [*range(6)])):
        assert write_bcf(tmp_path / "a.bcf", found, mockup, most=most) == most
        assert titles(tmp_path / "a.bcf") == [title(each) for each in (found.groups()[row] for row in rows)]
    assert left_out(found, "part", 1) == "has 1 of 6 groups, the worst of 2 with decisions"
    assert left_out(found, "part", 3) == "has 3 of 6 groups: 2 with decisions, and the worst of the others"
    assert left_out(found, "part", 6) == ""
    assert left_out(rows_of_pairs(6)[1], "part", 3) == "has the 3 worst of 6 groups"
