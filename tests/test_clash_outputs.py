"""What findings become: groups, CSV, JSON, a page, BCF, GLB; each read back."""

from __future__ import annotations

import csv
import datetime
import html
import importlib.util
import inspect
import json
import re
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from clash_scene import house, mockup_of, pairs, table
from shapes import box

import feeler
from feeler import Verdict
from feeler.clashes import as_html, report, write_bcf, write_clash_glb, write_csv, write_html, write_xlsx
from feeler.clashes.as_glb import COLOUR_OF, clash_bodies
from feeler.clashes.columns import COLUMNS
from feeler.clashes.words import extent, sentence, shared, title
from feeler.errors import OptionError
from feeler.io import WriteError
from feeler.io.body import LIGHT_GREY
from feeler.words import length
from feeler.workbench.document.findings import findings_of, read_findings

WHEN = datetime.datetime(2024, 5, 6, 7, 8, 9, tzinfo=datetime.timezone.utc)
HOSTILE = "</script><script>alert(1)</script>&\"'\x01"


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    return house()


@pytest.fixture(scope="module")
def hostile() -> feeler.Mockup:
    """Names that would be markup, were they not escaped."""
    return mockup_of({f"x/{HOSTILE}": box((0, 0, 0), (1, 1, 1)), "=cmd|'x'!A1": box((0.5, 0, 0), (2, 1, 1))})


# --- groups -----------------------------------------------------------------------------------------------------------


def test_groups_hold_each_row_once_the_worst_first(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    for by in ("part", "rule", "cluster"):
        groups = found.groups(by)
        assert sorted(row for group in groups for row in group.rows.tolist()) == list(range(len(found)))
        assert len({group.name for group in groups}) == len(groups)
        first = [int(group.rows[0]) for group in groups]
        assert first == sorted(first) and first[0] == 0
        for group in groups:
            assert group.rows.tolist() == sorted(group.rows.tolist())
            assert list(group.clashes) == [found[int(row)] for row in group.rows] and group.worst == group.clashes[0]


def test_one_part_that_is_in_the_way_is_one_group() -> None:
    paths = [f"x/{i}" for i in range(10)]
    rows = [{"a": i, "b": 9, "verdict": Verdict.CLASH, "depth": 0.01 * (i + 1)} for i in range(6)]
    rows += [{"a": 0, "b": 1, "verdict": Verdict.CLASH, "depth": 1.0}]
    groups = table(rows, paths).groups("part")
    assert {group.name: len(group) for group in groups} == {"x/0": 1, "x/9": 6}
    # The rows that are left count, not all that a part has: 2 has three, of which 1 has two.
    rows = [{"a": 0, "b": i, "verdict": Verdict.CLASH, "depth": 1.0 - 0.1 * i} for i in (3, 4, 5, 6)]
    rows += [{"a": 0, "b": 2, "verdict": Verdict.CLASH, "depth": 0.01}]
    rows += [{"a": 1, "b": 2, "verdict": Verdict.CLASH, "depth": 0.02}]
    rows += [{"a": 1, "b": 7, "verdict": Verdict.CLASH, "depth": 0.03}]
    assert {group.name: len(group) for group in table(rows, paths).groups("part")} == {"x/0": 5, "x/1": 2}


def test_duplicates_and_contained_parts_come_before_small_clashes() -> None:
    rows = [
        {"a": 0, "b": 1, "verdict": Verdict.CLASH, "depth": 1e-6},
        {"a": 0, "b": 2, "verdict": Verdict.CONTAINED, "depth": 0.02},
        {"a": 0, "b": 3, "verdict": Verdict.DUPLICATE},
        {"a": 1, "b": 2, "verdict": Verdict.CLASH, "depth": 0.03},
        {"a": 1, "b": 3, "verdict": Verdict.CLEARANCE, "gap": 0.001},
        {"a": 2, "b": 3, "verdict": Verdict.CONTACT, "depth": 0.04},
        {"a": 2, "b": 1, "verdict": Verdict.CLASH, "depth": np.nan},
        {"a": 3, "b": 1, "verdict": Verdict.CLEARANCE, "gap": 0.0005, "severity": 0},
    ]
    found = table(rows)
    assert [each.verdict.name for each in found] == [
        *("CLEARANCE", "DUPLICATE", "CLASH", "CONTAINED", "CLASH", "CLASH", "CONTACT", "CLEARANCE")
    ]
    assert np.isnan(found.depths[5])
    # The worst of a group is the first of these rows in it.
    assert table(rows[:7]).groups("rule")[0].worst.verdict == Verdict.DUPLICATE


def test_clusters_are_linked_by_steps(rng: np.random.Generator) -> None:
    reach = 0.25
    points = np.concatenate([rng.uniform(0, 2, (60, 3)), rng.normal(5, 1e-3, (40, 3)), np.full((3, 3), 9.0)])
    rows = [{"a": 0, "b": 1, "verdict": 0, "depth": 1.0, "point_a": p, "point_b": p} for p in points]
    found = table(rows)
    # All pairs, without a grid.
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= reach
    label = np.arange(len(points))
    for _ in points:
        label = np.array([label[row].min() for row in near])
    expected = {tuple(np.flatnonzero(label == each)) for each in np.unique(label)}
    assert {tuple(group.rows) for group in found.groups("cluster", reach=reach)} == expected
    assert 3 < len(expected) < 60
    assert len(found.groups("cluster", reach=0.0)) == 101
    assert len(found.groups("cluster", reach=100.0)) == 1
    far = table([{**row, "point_a": row["point_a"] + 3e6, "point_b": row["point_b"] + 3e6} for row in rows])
    assert [group.rows.tolist() for group in far.groups("cluster", reach=reach)] == [
        group.rows.tolist() for group in found.groups("cluster", reach=reach)
    ]


# --- words ------------------------------------------------------------------------------------------------------------


def test_sentences(mockup: feeler.Mockup) -> None:
    said = {(each.path_a, each.path_b): (sentence(each), extent(each)) for each in feeler.clash(mockup)}
    assert said["house/walls/left", "house/walls/right"] == ("left is 62.5 mm deep in right", "62.5 mm")
    assert said["house/walls/left", "house/copy/left"] == ("left and left have the same surface", "same surface")
    assert said["house/walls/left", "yard/flush"] == ("left touches flush", "touching")
    assert said["house/walls/right", "yard/near"] == ("right is 976.6 µm from near", "976.6 µm apart")
    contained = said["house/walls/right", "house/pins/core"]
    assert contained == ("right and core: one is inside the other, 500 mm from coming out", "500 mm")
    # The depth of a contained part and its way out may be different lengths.
    row = {"a": 0, "b": 1, "verdict": Verdict.CONTAINED, "depth": 0.002, "translation": (0.0, 0.03, 0.04)}
    (inside,) = table([row])
    assert sentence(inside) == "a and b: one is inside the other, 50 mm from coming out"
    assert extent(inside) == "2 mm"
    # What `contact` allows is said, but not the rounding of flush faces.
    allowed, flush = table([{"a": 0, "b": 1, "verdict": Verdict.CONTACT, "depth": depth} for depth in (0.3, 1e-7)])
    assert (sentence(allowed), extent(allowed)) == ("a overlaps b by 300 mm, allowed", "300 mm, allowed")
    assert (sentence(flush), extent(flush)) == ("a touches b", "touching")
    # A range only where the error is more than that of every measured depth.
    wide, usual = table([{"a": 0, "b": 1, "depth": 0.002, "depth_error": error} for error in (1e-4, 2e-6)])
    assert (extent(wide), extent(usual)) == ("2 mm to 2.1 mm", "2 mm")
    (estimate,) = table([{"a": 0, "b": 1, "depth": 0.002, "depth_kind": 1}])
    assert sentence(estimate) == "a is about 2 mm deep in b"
    (group,) = table([{"a": 0, "b": 1, "depth": 0.002}]).groups()
    assert title(group) == "x/a: 1 finding; a is 2 mm deep in b"


@pytest.mark.parametrize(
    ("metres", "text"),
    [(1.5, "1.5 m"), (0.00099999999, "1 mm"), (1e-6, "1 µm"), (2.5e-9, "2.5 nm"), (0.0, "0 m"), (1e-12, "1e-12 m")],
)
def test_lengths(metres: float, text: str) -> None:
    assert length(metres) == text
    assert length(float("nan")) == "an unknown length"


# --- CSV and JSON -----------------------------------------------------------------------------------------------------


def test_csv_reads_back_to_the_last_bit(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    found.set_status(found.ids[0], "approved", by="ada", note="a, b\nc")
    write_csv(tmp_path / "a.csv", found)
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8-sig") as file:
        head, *lines = csv.reader(file)
    assert head == [column.name for column in COLUMNS] and len(lines) == len(found)
    for line, row in zip(lines, found, strict=True):
        read = dict(zip(head, line, strict=True))
        assert (read["id"], read["verdict"], read["path_a"], read["path_b"]) == (
            *(row.id, row.verdict.name.lower(), row.path_a, row.path_b),
        )
        assert float(read["depth_m"]) == row.depth and float(read["gap_m"]) == row.gap and read["volume_m3"] == ""
        assert float(read["depth_error_m"]) == row.depth_error and read["depth_kind"] == row.depth_kind
        assert tuple(float(read[f"point_a_{axis}_m"]) for axis in "xyz") == row.point_a
        assert tuple(float(read[f"upper_{axis}_m"]) for axis in "xyz") == row.box[1]
        assert (read["status"], read["by"], read["note"]) == (row.status, row.by, row.note)
    assert {line[head.index("group")] for line in lines} == {group.name for group in found.groups()}


def test_the_workbench_shows_what_json_says(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    found.set_status(found.ids[1], "reviewed", by="ada")
    document = json.loads(json.dumps(report(found)))
    assert document["counts"] == {"clash": 4, "contact": 2, "clearance": 1, "contained": 1, "duplicate": 1}
    assert document["statuses"]["reviewed"] == 1 and document["partial"] is False
    table = findings_of(document, mockup.parts).table
    assert table.ids == found.ids, "in the same order"
    assert {name: table.status_of(name) for name in table.ids if table.status_of(name) != "new"} == {
        found.ids[1]: "reviewed"
    }
    assert set(table.groups) == {group.name for group in found.groups()}
    for place, row in enumerate(found):
        each = table.row_json(place)
        parts = [int(table.part_of_path[side[place]]) for side in (table.a, table.b)]
        assert all(part in (-1, of) for part, of in zip(parts, (row.a, row.b), strict=True))
        assert each["depth"] == row.depth and each["point_a"] == list(row.point_a)
    assert [each["id"] for each in document["clashes"]] == list(found.ids)


def test_json_is_what_load_clashes_reads(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    (tmp_path / "a.json").write_text(json.dumps(report(found, by="rule")))
    assert set(feeler.load_clashes(tmp_path / "a.json").ids) == set(found.ids)


def test_saved_findings_may_begin_with_a_byte_order_mark(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    found.save(tmp_path / "a.json")
    (tmp_path / "a.json").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "a.json").read_bytes())
    assert set(feeler.load_clashes(tmp_path / "a.json").ids) == set(found.ids)
    assert len(read_findings(tmp_path / "a.json")["clashes"]) == len(found)


# --- the page ---------------------------------------------------------------------------------------------------------


def data_of(page: str) -> list[dict[str, Any]]:
    (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return list(json.loads(data))


def test_the_page_has_all_findings_and_needs_nothing(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    write_html(tmp_path / "a.html", found, mockup)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    rows = data_of(page)
    assert [row["id"] for row in rows] == list(found.ids)
    assert [(row["a"], row["b"], row["verdict"]) for row in rows] == [
        (*pair, verdict) for pair, verdict in pairs(found).items()
    ]
    assert "4 clash, 2 contact, 1 clearance, 1 contained, 1 duplicate" in page and "9 new" in page
    assert page.count('<img alt="" loading=lazy src="data:image/png;base64,') == len(found.groups())
    assert not re.search(
        r"(src|href)=(?!\"data:)|https?:|//[a-z]|url\(|@import|fetch\(|XMLHttp", re.sub(r"base64,[^\"]*", "", page)
    )
    assert "default-src 'none'" in page and "connect-src" not in page
    assert "The check was stopped" not in page
    write_html(tmp_path / "b.html", found)
    assert "<img" not in (tmp_path / "b.html").read_text(encoding="utf-8")
    write_html(tmp_path / "c.html", found, mockup, pictures=1)
    assert (tmp_path / "c.html").read_text(encoding="utf-8").count("<img") == 1


def test_names_do_not_become_markup(tmp_path: Path, hostile: feeler.Mockup) -> None:
    found = feeler.clash(hostile)
    found.set_status(found.ids[0], "active", by="<b>", note="</script>")
    write_html(tmp_path / "a.html", found, hostile)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page.count("<script") == 2 and page.count("</script") == 2 and "<b>&" not in page
    assert "alert(1)</script>" not in page
    assert data_of(page)[0]["a"] == f"x/{HOSTILE}".replace("\x01", "\\x01")


def test_a_partial_check_is_told(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)[:2]
    found.is_partial = True
    write_html(tmp_path / "a.html", found, mockup)
    assert "The check was stopped. More findings may exist." in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert report(found)["partial"] is True


def test_a_page_says_what_rules_hide(tmp_path: Path, mockup: feeler.Mockup) -> None:
    rules = {"exclude": [{"name": "<copies>", "a": "*copy*"}, {"name": "none", "a": "*core*", "b": "*near*"}]}
    write_html(tmp_path / "a.html", feeler.clash(mockup, rules=rules))
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "<dt>hidden</dt><dd>4 by &lt;copies&gt;, 0 by none</dd>" in page


def test_a_page_has_a_stated_cap(tmp_path: Path, mockup: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(as_html, "MOST_ROWS", 5)
    found = feeler.clash(mockup)
    write_html(tmp_path / "a.html", found)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert [row["id"] for row in data_of(page)] == list(found.ids[:5]) and "The 5 worst of 9 findings are in" in page


def test_a_page_of_nothing(tmp_path: Path, mockup: feeler.Mockup) -> None:
    write_html(tmp_path / "a.html", feeler.clash(mockup)[:0], mockup)
    assert data_of((tmp_path / "a.html").read_text(encoding="utf-8")) == []


def test_the_page_filters(tmp_path: Path, hostile: feeler.Mockup, mockup: feeler.Mockup, context: Any) -> None:
    found = feeler.clash(mockup)
    write_html(tmp_path / "a.html", found, mockup)
    page = context.new_page()
    asked, wrong = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto((tmp_path / "a.html").as_uri())
    lines = page.locator("#rows tr")
    assert lines.count() == len(found)
    page.select_option("#verdict", "clash")
    assert lines.count() == 4 and page.inner_text("#count") == "4 of 9 findings"
    page.fill("#text", "BOLT copy")
    assert lines.count() == 1
    page.click("#clear")
    assert lines.count() == len(found)
    group = found.groups()[0]
    page.click(".group >> nth=0")
    assert lines.count() == len(group)
    page.click(".group >> nth=0")
    assert lines.count() == len(found)
    assert [url for url in asked if not url.startswith("data:")] == [(tmp_path / "a.html").as_uri()] and not wrong
    write_html(tmp_path / "b.html", feeler.clash(hostile), hostile)
    page.goto((tmp_path / "b.html").as_uri())
    assert lines.count() == 1 and "</script>" in lines.first.inner_text() and not wrong


def test_many_findings_are_shown_step_by_step(tmp_path: Path, context: Any) -> None:
    paths = [f"x/{i}" for i in range(500)]
    rows = [{"a": i, "b": i + 1, "verdict": 0, "depth": 1.0 / (i + 1)} for i in range(450)]
    write_html(tmp_path / "a.html", table(rows, paths))
    page = context.new_page()
    page.goto((tmp_path / "a.html").as_uri())
    assert page.locator("#rows tr").count() == 200 and page.inner_text("#more") == "Show 200 more"
    page.click("#more")
    page.click("#more")
    assert page.locator("#rows tr").count() == 450 and not page.is_visible("#more")


# --- BCF --------------------------------------------------------------------------------------------------------------


def test_bcf_is_the_same_for_the_same_findings(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    topics = write_bcf(tmp_path / "a.bcf", found, mockup, when=WHEN)
    assert topics == len(found.groups())
    write_bcf(tmp_path / "b.bcf", feeler.clash(mockup), mockup, when=WHEN)
    assert (tmp_path / "a.bcf").read_bytes() == (tmp_path / "b.bcf").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.bcf") as archive:
        names = archive.namelist()
        assert names[:3] == ["bcf.version", "project.bcfp", "extensions.xml"] and len(names) == 3 + 3 * topics
        assert ElementTree.fromstring(archive.read("bcf.version")).attrib == {"VersionId": "3.0"}
        folders = {name.split("/")[0] for name in names[3:]}
        assert len(folders) == topics and all(
            re.fullmatch(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", f) for f in folders
        )
        for folder in folders:
            markup = ElementTree.fromstring(archive.read(f"{folder}/markup.bcf"))
            assert markup.find("Topic").attrib["Guid"] == folder  # type: ignore[union-attr]
            assert archive.read(f"{folder}/snapshot.png").startswith(b"\x89PNG")
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    # A group that stays is the same topic, whatever else is found.
    last = found.groups()[-1]
    write_bcf(tmp_path / "c.bcf", last.clashes, mockup, when=WHEN)
    guids = []
    for name in ("a.bcf", "c.bcf"):
        with zipfile.ZipFile(tmp_path / name) as archive:
            markups = [ElementTree.fromstring(archive.read(n)) for n in archive.namelist() if n.endswith(".bcf")]
        topics = {topic.findtext("Title"): topic.attrib["Guid"] for each in markups for topic in each.iter("Topic")}
        guids.append(topics[title(last)])
    assert guids[0] == guids[1]


def test_bcf_has_a_stated_cap(tmp_path: Path, mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    assert write_bcf(tmp_path / "a.bcf", found, mockup, most=1) == 1
    with zipfile.ZipFile(tmp_path / "a.bcf") as archive:
        assert len(archive.namelist()) == 6
    with pytest.raises(OptionError, match="most is 0"):
        write_bcf(tmp_path / "a.bcf", found, mockup, most=0)


def test_bcf_read_by_a_library_of_others(tmp_path: Path, mockup: feeler.Mockup, hostile: feeler.Mockup) -> None:
    bcfxml = pytest.importorskip("bcf.v3.bcfxml")
    found = feeler.clash(mockup)
    found.set_status(found.ids[0], "reviewed")
    write_bcf(tmp_path / "a.bcf", found, mockup, author="ada", when=WHEN)
    groups = {title(group): group for group in found.groups()}
    with bcfxml.BcfXml.load(tmp_path / "a.bcf") as read:
        assert read.version.version_id == "3.0" and read.project.name == "mock-up"
        assert read.extensions.users.user == ["ada"] and "clash" in read.extensions.topic_labels.topic_label
        assert {topic.topic.title for topic in read.topics.values()} == groups.keys()
        for guid, handler in read.topics.items():
            topic = handler.topic
            group = groups[topic.title]
            assert topic.guid == guid and topic.topic_type == "Clash" and topic.creation_author == "ada"
            assert topic.creation_date.to_datetime() == WHEN and topic.priority == group.worst.severity
            assert topic.description.count("\n") == len(group) and all(
                i in topic.description for i in group.clashes.ids
            )
            assert topic.topic_status == "new" if len(group) > 1 or group.worst.id != found.ids[0] else "reviewed"
            (view,) = handler.viewpoints.values()
            assert view.snapshot is not None and view.snapshot.startswith(b"\x89PNG")
            info = view.visualization_info
            paths = [each.authoring_tool_id for each in info.components.selection.component]
            assert paths == [group.worst.path_a, group.worst.path_b]
            camera = info.perspective_camera
            eye, way, up = (
                np.array([each.x, each.y, each.z])
                for each in (camera.camera_view_point, camera.camera_direction, camera.camera_up_vector)
            )
            assert np.linalg.norm(way) == pytest.approx(1.0) and way @ up == pytest.approx(0.0, abs=1e-9)
            to_point = np.array(group.worst.point_a) - eye
            assert to_point @ way / np.linalg.norm(to_point) > np.cos(np.radians(camera.field_of_view / 2))
            assert 45 <= camera.field_of_view <= 60
    write_bcf(tmp_path / "b.bcf", feeler.clash(hostile), hostile, when=WHEN)
    with bcfxml.BcfXml.load(tmp_path / "b.bcf") as read:
        ((topic),) = read.topics.values()
        assert HOSTILE.replace("\x01", "?") in topic.topic.description


# --- GLB --------------------------------------------------------------------------------------------------------------


def test_glb_reads_back_with_its_colours(tmp_path: Path, mockup: feeler.Mockup) -> None:
    trimesh = pytest.importorskip("trimesh")
    found = feeler.clash(mockup)
    assert write_clash_glb(tmp_path / "a.glb", found, mockup) == (tmp_path / "a.glb").stat().st_size
    read = feeler.load_mockup(tmp_path / "a.glb")
    lines = [path for path in read.part_paths if "/witness lines/" in path]
    # A line for each way out, which duplicates have too, and for each gap.
    assert len(lines) == np.count_nonzero(found.translations.any(axis=1) | (found.gaps > 0)) == 7
    assert read.triangle_count == mockup.triangle_count + 8 * len(lines)
    scene = trimesh.load(tmp_path / "a.glb")
    colour = {name: np.array(mesh.visual.material.main_color[:3]) / 255 for name, mesh in scene.geometry.items()}
    # glTF has linear colours; what is compared is which parts are alike.
    assert not np.allclose(colour["near"], colour["flush"])
    assert len({tuple(each.round(3)) for each in colour.values()}) >= 4


def test_files_are_written_from_path_clashes_mockup(tmp_path: Path, mockup: feeler.Mockup) -> None:
    for write in (write_html, write_bcf, write_clash_glb):
        assert list(inspect.signature(write).parameters)[:3] == ["path", "clashes", "mockup"]
    with pytest.raises(OptionError, match=r"clashes is Mockup\(.*: give a feeler.Clashes"):
        write_clash_glb(tmp_path / "a.glb", mockup, feeler.clash(mockup))  # type: ignore[arg-type]


def test_glb_takes_names_that_no_file_can_store(tmp_path: Path) -> None:
    """Halves of surrogate pairs, which only Python can put into a name."""
    mockup = mockup_of({"\ud800/\udc00x": box((0, 0, 0), (1, 1, 1)), "ä/b": box((0.5, 0, 0), (2, 1, 1))})
    write_clash_glb(tmp_path / "a.glb", feeler.clash(mockup), mockup)
    paths = feeler.load_mockup(tmp_path / "a.glb").part_paths
    assert paths[0].endswith("?x") and paths[1].endswith("ä/b")


def test_glb_shows_the_worst_verdict_of_each_part(mockup: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    body, _ = clash_bodies(mockup, found)
    for part in range(mockup.part_count):
        rows = [row for row in found if part in (row.a, row.b)]
        expected = COLOUR_OF[rows[0].verdict] if rows else LIGHT_GREY
        (colour,) = {int(each) for each in body.colour_of_face[body.part_of_face == part]}
        assert tuple(body.palette[colour]) == expected
    (alone,) = clash_bodies(mockup, found[:0])
    assert len(alone.palette) == 1


def test_glb_draws_ways_out_whatever_the_depth() -> None:
    mockup = house()
    paths = tuple(mockup.part_paths)
    way = {"a": 0, "b": 4, "verdict": Verdict.DUPLICATE, "translation": (0.0, 0.0, 0.5)}
    contact = {"a": 0, "b": 1, "verdict": Verdict.CONTACT, "depth": 0.1}
    unknown = {"a": 0, "b": 2, "verdict": Verdict.CLASH, "depth": 0.1, "translation": (np.nan,) * 3}
    _, lines = clash_bodies(mockup, table([way, contact, unknown], paths))
    corners = lines.vertices
    assert np.ptp(corners[:, 2]) == pytest.approx(0.5, abs=0.01) and np.ptp(corners[:, :2], axis=0).max() < 0.01


def test_outputs_refuse_another_mock_up(tmp_path: Path, mockup: feeler.Mockup, hostile: feeler.Mockup) -> None:
    found = feeler.clash(mockup)
    found.save(tmp_path / "a.json")
    for clashes in (feeler.clash(hostile), feeler.load_clashes(tmp_path / "a.json")):
        with pytest.raises(OptionError, match="of other parts than the mock-up's"):
            write_clash_glb(tmp_path / "a.glb", clashes, mockup)
        with pytest.raises(OptionError, match="of other parts"):
            write_html(tmp_path / "a.html", clashes, mockup)
        with pytest.raises(OptionError, match="of other parts"):
            write_bcf(tmp_path / "a.bcf", clashes, mockup)
    write_html(tmp_path / "a.html", feeler.load_clashes(tmp_path / "a.json"))
    with pytest.raises(WriteError):
        write_csv(tmp_path / "no" / "a.csv", found)


# --- volumes and names ------------------------------------------------------------------------------------------------


def test_volumes_are_in_all_reports(tmp_path: Path) -> None:
    measured = table([{"a": 0, "b": 1, "volume": 0.0015}, {"a": 2, "b": 3, "volume": 2.5e-9}, {"a": 0, "b": 3}])
    none = table([{"a": 0, "b": 1}])
    assert (shared(measured), shared(none)) == ("1.5 l in all, unknown for 1 pair", "")
    write_html(tmp_path / "a.html", measured)
    write_html(tmp_path / "b.html", none)
    page, plain = ((tmp_path / name).read_text(encoding="utf-8") for name in ("a.html", "b.html"))
    assert sorted(row["volume"] for row in data_of(page)) == ["1.5 l", "2.5 mm³", "unknown"]
    assert "<th>shared volume</th>" in page and "<dd>1.5 l in all, unknown for 1 pair</dd>" in page
    assert "<th>shared volume</th>" not in plain and "volume" not in data_of(plain)[0]


CONTROLS = "".join(map(chr, [*range(32), 127, 128, 0x85, 0x9F, 0xFFFE, 0xFFFF, 0xD800]))


def test_control_characters_leave_files_valid(tmp_path: Path) -> None:
    """In names of parts, rules and people, and in notes."""
    mockup = mockup_of({f"x/a{CONTROLS}z": box((0, 0, 0), (1, 1, 1)), "y/nul\0": box((0.5, 0, 0), (2, 1, 1))})
    found = feeler.clash(mockup, rules={"rule": [{"name": "r\x01", "a": "x*"}]})
    found.set_status(found.ids[0], "approved", by="ada\x02", note=f"n{CONTROLS[:-1]}")
    write_html(tmp_path / "a.html", found)
    page = (tmp_path / "a.html").read_bytes().decode("utf-8")
    allowed = set("\n\t")
    assert {letter for letter in page if not letter.isprintable()} <= allowed
    assert (
        not {letter for letter in json.dumps(data_of(page), ensure_ascii=False) if not letter.isprintable()} - allowed
    )
    (group,) = re.findall(r'data-group="(.*?)"', page, re.DOTALL)
    assert html.unescape(group) == data_of(page)[0]["group"] and "\\x01" in group
    write_csv(tmp_path / "a.csv", found)
    text = (tmp_path / "a.csv").read_bytes().decode("utf-8-sig")
    assert {letter for letter in text if not letter.isprintable()} <= set("\n\t\r") and "\ufffd" in text
    write_bcf(tmp_path / "a.bcf", found, mockup)
    names = [("a.bcf", name) for name in zipfile.ZipFile(tmp_path / "a.bcf").namelist()]
    if importlib.util.find_spec("xlsxwriter"):
        write_xlsx(tmp_path / "a.xlsx", found)
        names += [("a.xlsx", name) for name in zipfile.ZipFile(tmp_path / "a.xlsx").namelist()]
    for file, name in names:
        if not name.endswith(".png"):
            data = zipfile.ZipFile(tmp_path / file).read(name).decode("utf-8")
            ElementTree.fromstring(data)
            assert not re.search("[^\t\n\r\x20-\ud7ff\ue000-\ufffd]", data), name
