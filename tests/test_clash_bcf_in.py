"""BCF comes back: statuses and comments go to their findings, and files of strangers do no harm."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import pytest
from clash_scene import mockup_of
from commands import run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapes import box
from workbench_scene import Bench, cube, sent

import feeler
from feeler.clashes import Comment, Topic, apply_bcf, bcf_in, read_bcf, write_bcf
from feeler.errors import LoadError, MissingFileError, OptionError

TOPIC = '<Markup><Topic Guid="{guid}" TopicStatus="{status}"><Title>t</Title>{more}</Topic>{beside}</Markup>'


def mockup() -> feeler.Mockup:
    """Two pins, each in a plate of its own, and a plate that both plates touch."""
    return mockup_of(
        {
            "a/plate": box((0, 0, 0), (1, 1, 1)),
            "a/pin": box((0.4, 0.4, 0.5), (0.6, 0.6, 2)),
            "b/plate": box((5, 0, 0), (6, 1, 1)),
            "b/pin": box((5.4, 0.4, 0.5), (5.6, 0.6, 2)),
        }
    )


def archive(path: Path, members: Mapping[str, str | bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as opened:
        for name, data in {"bcf.version": "<Version/>", **members}.items():
            opened.writestr(name, data)
    return path


def edited(path: Path, status: str, *comments: tuple[str, str]) -> Path:
    """A BCF file as another program gives it back: each topic with another status and some comments."""
    out = path.with_name("back.bcfzip")
    with zipfile.ZipFile(path) as before, zipfile.ZipFile(out, "w") as after:
        for name in before.namelist():
            data = before.read(name)
            if name.endswith("markup.bcf"):
                root = ElementTree.fromstring(data)
                topic = root.find("Topic")
                assert topic is not None
                topic.set("TopicStatus", status)
                inside = ElementTree.SubElement(topic, "Comments")
                for author, text in comments:
                    comment = ElementTree.SubElement(inside, "Comment", {"Guid": "c"})
                    for tag, value in (("Date", "2026-01-01T00:00:00"), ("Author", author), ("Comment", text)):
                        ElementTree.SubElement(comment, tag).text = value
                data = ElementTree.tostring(root)
            after.writestr(name, data)
    return out


def in_plate(*bolts: tuple[str, float, float]) -> feeler.Mockup:
    """A plate and what is in it: name, place, size."""
    boxes = {f"a/{name}": box((x, 0.2, 0.5), (x + size, 0.2 + size, 2)) for name, x, size in bolts}
    return mockup_of({"a/plate": box((0, 0, 0), (100, 1, 1)), **boxes})


def test_an_approval_does_not_pass_to_what_is_in_the_group_now(tmp_path: Path) -> None:
    then, now = in_plate(("b0", 1, 0.1), ("b1", 2, 0.1)), in_plate(("s0", 5, 0.3), ("s1", 7, 0.3))
    write_bcf(tmp_path / "out.bcf", feeler.clash(then), then)
    topics = read_bcf(edited(tmp_path / "out.bcf", "Accepted"))
    found = feeler.clash(now)
    assert apply_bcf(found, topics).unknown == topics and set(found.statuses.tolist()) == {"new"}
    # One that is still there has the status, the new one beside it has not.
    found = feeler.clash(in_plate(("b0", 1, 0.1), ("s1", 7, 0.3)))
    apply_bcf(found, topics)
    bolts = {({row.path_a, row.path_b} - {"a/plate"}).pop(): row.status for row in found}
    assert bolts == {"a/b0": "approved", "a/s1": "new"}


def test_a_status_reaches_all_findings_of_a_topic(tmp_path: Path) -> None:
    world = in_plate(*((f"b{n}", n + 1, 0.1) for n in range(60)))
    found = feeler.clash(world)
    write_bcf(tmp_path / "out.bcf", found, world)
    (topic,) = read_bcf(edited(tmp_path / "out.bcf", "Accepted", ("ada", "fits")))
    assert "... and 10 more" in topic.description and len(topic.ids) == 60
    changes = apply_bcf(found, [topic])
    assert len(changes.statuses) == 60 and set(found.statuses.tolist()) == {"approved"}
    assert {found.marks.of(each).note for each in found.ids} == {"ada: fits"}


@pytest.mark.parametrize("deep, growth, is_kept", [(0.1, 1e-4, True), (0.3, 1e-4, False), (0.3, 0.25, True)])
def test_an_approval_holds_for_the_depth_that_the_file_says(
    tmp_path: Path, deep: float, growth: float, is_kept: bool
) -> None:
    def world(sunk: float) -> feeler.Mockup:
        return mockup_of({"a": box((0, 0, 0), (1, 1, 1)), "b": box((1 - sunk, 0.1, 0.1), (3, 0.9, 0.9))})

    write_bcf(tmp_path / "out.bcf", feeler.clash(world(0.1)), world(0.1))
    topics = read_bcf(edited(tmp_path / "out.bcf", "Accepted"))
    found = feeler.clash(world(deep))
    changes = apply_bcf(found, topics, growth=growth)
    assert found.statuses.tolist() == ["approved" if is_kept else "new"]
    assert changes.outgrown == (() if is_kept else found.ids)
    if is_kept:
        assert found.marks.of(found.ids[0]).approved_depth == pytest.approx(0.1, rel=1e-3)
    else:
        assert "approved at 0.1 m" in found.marks.of(found.ids[0]).note


def bolts(*holes: int, root: str = "a") -> feeler.Mockup:
    """A plate, and a bolt in each hole, numbered from 0; each hole has bolts of its own size."""
    sizes = {f"{root}/bolt_{n}": (1 + 5 * hole, 0.1 + 0.02 * hole) for n, hole in enumerate(holes)}
    boxes = {name: box((x, 0.2, 0.5), (x + size, 0.2 + size, 2)) for name, (x, size) in sizes.items()}
    return mockup_of({f"{root}/plate": box((0, 0, 0), (100, 1, 1)), **boxes})


def by_hole(found: feeler.Clashes) -> dict[int, tuple[str, str]]:
    return {int(row.point_a[0] // 5): (row.status, row.note) for row in found}


@pytest.mark.parametrize("by", ["part", "cluster"])
def test_topics_follow_the_match_of_the_previous_check(tmp_path: Path, by: Literal["part", "cluster"]) -> None:
    before = feeler.clash(bolts(0, 1, 2))
    write_bcf(tmp_path / "out.bcf", before, bolts(0, 1, 2), by=by)
    (chosen,) = [row.id for row in before if int(row.point_a[0] // 5) == 1]
    before.set_status(chosen, "approved", note="hole 1")
    write_bcf(tmp_path / "out.bcf", before, bolts(0, 1, 2), by=by)
    topics = read_bcf(tmp_path / "out.bcf")
    # Deleted and numbered anew, in another order, all but one deleted, and with another root.
    for world, expected in (
        (bolts(1, 2), {1: ("approved", "hole 1"), 2: ("new", "")}),
        (bolts(2, 0, 1), {0: ("new", ""), 1: ("approved", "hole 1"), 2: ("new", "")}),
        (bolts(2), {2: ("new", "")}),
        (bolts(0, 1, 2, root="b"), {0: ("new", ""), 1: ("approved", "hole 1"), 2: ("new", "")}),
    ):
        previous = feeler.clash(bolts(0, 1, 2))
        previous.save(tmp_path / "last.json")
        now = feeler.clash(world)
        now.diff(feeler.load_clashes(tmp_path / "last.json"))
        apply_bcf(now, topics)
        status = {hole: (mark if mark[0] == "approved" else ("new", mark[1])) for hole, mark in by_hole(now).items()}
        assert status == expected


def test_a_topic_that_nobody_touched_leaves_later_decisions(tmp_path: Path) -> None:
    found = feeler.clash(bolts(0, 1))
    write_bcf(tmp_path / "out.bcf", found, bolts(0, 1))
    found.set_status(found.ids[0], "approved", note="later")
    apply_bcf(found, read_bcf(tmp_path / "out.bcf"))
    assert found[0].status == "approved" and found[0].note == "later"
    apply_bcf(found, read_bcf(edited(tmp_path / "out.bcf", "Active")))
    assert found[0].status == "active"


def test_statuses_and_comments_come_back(tmp_path: Path) -> None:
    found = feeler.clash(mockup())
    write_bcf(tmp_path / "out.bcf", found, mockup())
    assert {topic.status for topic in read_bcf(tmp_path / "out.bcf")} == {"new"}
    back = edited(tmp_path / "out.bcf", "In Progress", ("ada", "move  the\npin"), ("bob", "done"))
    topics = read_bcf(back)
    assert len(topics) == len(found.groups()) and topics[0].comments == (
        Comment("move  the\npin", "ada", "2026-01-01T00:00:00"),
        Comment("done", "bob", "2026-01-01T00:00:00"),
    )
    assert set(topics[0].parts) <= set(mockup().part_paths)
    changes = apply_bcf(found, topics)
    assert set(changes.statuses) == set(changes.notes) == set(found.ids) and changes.unknown == ()
    assert {(row.status, row.note, row.by) for row in found} == {("active", "ada: move the pin; bob: done", "bob")}
    assert apply_bcf(found, topics).notes == (), "a comment is noted once"
    found.save(tmp_path / "now.json")
    assert feeler.load_clashes(tmp_path / "now.json")[0].note == "ada: move the pin; bob: done"


@pytest.mark.parametrize(
    ("word", "status"),
    [
        *(("Open", "new"), ("ACTIVE", "active"), ("Resolved", "reviewed"), ("closed", "reviewed")),
        *(("Approved", "approved"), (" in review ", "reviewed"), ("Waiting for the customer", "new"), ("", "new")),
    ],
)
def test_the_words_of_trackers(word: str, status: str) -> None:
    found = feeler.clash(mockup())
    apply_bcf(found, [Topic(guid="x", title="t", status=word, ids=(found.ids[0],))])
    assert found[0].status == status
    assert found[0].note == ("BCF: Waiting for the customer" if word.startswith("Waiting") else "")


def test_an_approval_holds_for_the_depth_of_now() -> None:
    found = feeler.clash(mockup())
    apply_bcf(found, [Topic(guid="x", title="t", status="approved", ids=found.ids)])
    assert found.marks.of(found.ids[0]).approved_depth == found.signed_depths[0]


def test_topics_are_found_by_id_else_by_group_else_by_parts() -> None:
    found = feeler.clash(mockup())
    (group, *_) = found.groups()
    first = found[0]
    by_parts = Topic(guid="x", title="t", status="approved", parts=(first.path_b, first.path_a))
    assert apply_bcf(found, [by_parts]).statuses == (first.id,)
    from feeler.clashes.tracking import derived_id

    by_group = Topic(guid=derived_id("topic", "part", group.name), title="t", status="active")
    assert set(apply_bcf(found, [by_group]).statuses) == set(group.clashes.ids)
    stranger = Topic(guid="x", title="t", status="active", parts=("nowhere", "else"))
    assert apply_bcf(found, [stranger]).unknown == (stranger,)
    with pytest.raises(OptionError):
        apply_bcf(found, ["no topic"])  # type: ignore[list-item]


def test_comments_beside_the_topic_as_in_earlier_versions(tmp_path: Path) -> None:
    beside = "<Comment Guid='c'><Date>d</Date><Author>ada</Author><Comment>hm</Comment></Comment>"
    text = TOPIC.format(guid="G", status="Open", more="<AssignedTo>bob</AssignedTo>", beside=beside)
    (topic,) = read_bcf(archive(tmp_path / "a.bcfzip", {"g/markup.bcf": text}))
    assert topic == Topic("g", "t", "Open", "", "bob", (Comment("hm", "ada", "d"),))


@pytest.mark.parametrize("how", ["2.0", "2.1"])
def test_a_viewpoint_selects_the_pair_in_each_version(tmp_path: Path, how: str) -> None:
    """BCF 2.0 marks each component; later versions list those that are selected."""

    def component(name: str, more: str = "") -> str:
        return f"<Component {more}><AuthoringToolId>{name}</AuthoringToolId></Component>"

    pair = ("a/plate", "a/pin")
    if how == "2.0":
        marked = component(pair[0], 'Selected="true"') + component(pair[1], 'Selected="1" Visible="true"')
        listed = marked + component("b/pin", 'Selected="false"') + component("b/plate", 'Visible="true"')
    else:
        hidden = f"<Visibility><Exceptions>{component('b/pin')}</Exceptions></Visibility>"
        listed = f"<Selection>{''.join(map(component, pair))}</Selection>{hidden}"
    view = f"<VisualizationInfo><Components>{listed}</Components></VisualizationInfo>"
    markup = TOPIC.format(
        guid="g", status="Closed", more="", beside="<Viewpoints><Viewpoint>v</Viewpoint></Viewpoints>"
    )
    (topic,) = read_bcf(archive(tmp_path / "a.bcf", {"g/markup.bcf": markup, "g/v": view}))
    assert topic.parts == pair
    found = feeler.clash(mockup())
    assert apply_bcf(found, [topic]).unknown == ()
    assert {row.path_a: row.status for row in found} == {"a/plate": "reviewed", "b/plate": "new"}


def test_the_command_takes_them_over(tmp_path: Path) -> None:
    found = feeler.clash(mockup())
    write_bcf(tmp_path / "out.bcf", found, mockup())
    found.save(tmp_path / "last.json")
    back = edited(tmp_path / "out.bcf", "Approved", ("ada", "fits"))
    done = run("clash", tmp_path / "last.json", "--bcf-in", back, "--save", tmp_path / "now.json", "--json")
    answer = json.loads(done.stdout)
    assert answer["bcf"] == {"topics": 2, "statuses": 2, "notes": 2, "unknown": 0, "outgrown": 0}
    assert {each["status"] for each in answer["clashes"]} == {"approved"}
    assert {row.note for row in feeler.load_clashes(tmp_path / "now.json")} == {"ada: fits"}
    assert "2 statuses and 2 notes taken over" in run("clash", tmp_path / "last.json", "--bcf-in", back).stdout
    wrong = run("clash", tmp_path / "last.json", "--bcf-in", tmp_path / "last.json", code=2)
    assert "is not a BCF file" in wrong.stderr


def test_the_page_takes_them_over_in_one_step_of_undo(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=mockup())
    bench.command("findings_take", key=bench.session.job("clash", {}).result(60)["key"])
    written = bench.session.job("export_findings", {"format": "bcf"}).result(60)
    (tmp_path / "out.bcf").write_bytes(bench.session.export(written["name"]))
    back = edited(tmp_path / "out.bcf", "Approved", ("ada", "fits"))
    files = sent(bench.session, back.read_bytes())
    taken = bench.session.job("findings_bcf", {"files": files, "name": "back.bcfzip"}).result(60)
    assert taken["count"] == 2
    bench.command("findings_take", key=taken["key"])
    findings = bench.document["findings"]
    assert [*findings["status"].values()] == ["approved"] * 2 and [*findings["notes"].values()] == ["ada: fits"] * 2
    bench.command("undo")
    assert bench.document["findings"]["status"] == {}


def test_the_page_takes_them_over_where_something_was_said_before(tmp_path: Path) -> None:
    bench = Bench(cube(), mockup=mockup())
    bench.command("findings_take", key=bench.session.job("clash", {}).result(60)["key"])
    written = bench.session.job("export_findings", {"format": "bcf"}).result(60)
    (tmp_path / "out.bcf").write_bytes(bench.session.export(written["name"]))
    back = edited(tmp_path / "out.bcf", "Approved", ("ada", "fits"))
    version = bench.document["findings"]["version"]
    bench.command("finding_mark", version=version, rows=[0], status="reviewed", note="mine")
    files = sent(bench.session, back.read_bytes())
    taken = bench.session.job("findings_bcf", {"files": files, "name": "back.bcfzip"}).result(60)
    bench.command("finding_mark", version=version, rows=[1], note="said since")
    bench.command("findings_take", key=taken["key"])
    findings = bench.document["findings"]
    assert [*findings["status"].values()] == ["approved"] * 2
    assert {*findings["notes"].values()} == {"mine; ada: fits", "said since"}


def test_comments_become_the_note_by_their_dates() -> None:
    found = feeler.clash(mockup())
    comments = (
        Comment("third", "cy", "2026-03-01T00:00:00+02:00"),
        Comment("second", "bo", "2026-02-01T00:00:00Z"),
        Comment("no date", "dee"),
        Comment("first", "al", "2026-01-01T00:00:00"),
    )
    apply_bcf(found, [Topic("g", "t", "Approved", comments=comments, ids=(found[0].id,))])
    assert (found[0].note, found[0].by) == ("dee: no date; al: first; bo: second; cy: third", "cy")


def test_our_own_topic_says_nothing_of_findings_without_a_comment() -> None:
    """The file may have had no room for all comments."""
    found = feeler.clash(mockup())
    one, other = found.ids
    text = f"approved: fits\npin in plate. Finding {one}, topic active."
    found.set_status(other, "approved", by="Ada")
    apply_bcf(found, [Topic("g", "t", "active", comments=(Comment(text, "Ada"),), ids=(one, other))])
    assert [each.status for each in found] == ["approved", "approved"]
    apply_bcf(found, [Topic("g", "t", "In Progress", comments=(Comment(text, "Ada"),), ids=(one, other))])
    assert [each.status for each in found] == ["active", "active"]


# ---- strangers ----

BOMB = '<!DOCTYPE m [<!ENTITY a "{}">{}]><Markup><Topic Guid="g"><Title>&j;</Title></Topic></Markup>'.format(
    "x" * 1000, "".join(f'<!ENTITY {chr(98 + k)} "{(f"&{chr(97 + k)};") * 10}">' for k in range(9))
)
FILE = '<!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]><Markup><Topic><Title>&a;</Title></Topic></Markup>'


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"g/markup.bcf": BOMB}, "declares a document type"),
        ({"g/markup.bcf": FILE}, "declares a document type"),
        ({"g/markup.bcf": BOMB.encode("utf-16")}, "declares a document type|damaged"),
        ({"g/markup.bcf": "<Markup>" + " " * (5 << 20) + "</Markup>"}, "unpacks to more"),
        ({"g/markup.bcf": "<a>" * 100_000}, "too deeply nested"),
        ({"g/markup.bcf": "<Markup>" + "<a/>" * 250_000 + "</Markup>"}, "too many"),
        ({"g/markup.bcf": "<Markup>"}, "the XML of 'g/markup.bcf' is damaged"),
        ({"g/markup.bcf": "<Markup>&nothing;</Markup>"}, "damaged"),
        ({"g/markup.bcf": b"\xff\xfe<"}, "damaged"),
        ({"g/markup.bcf": ""}, "damaged"),
        ({f"{k}/markup.bcf": "<M/>" for k in range(20)}, "20 topics, and 10 are the most"),
        ({f"{k}.png": "" for k in range(40)}, "41 members, and 30 are the most"),
    ],
    ids=lambda each: each if isinstance(each, str) else None,
)
def test_hostile_archives_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, members: dict[str, str], words: str
) -> None:
    monkeypatch.setattr(bcf_in, "MOST_TOPICS", 10)
    monkeypatch.setattr(bcf_in, "MOST_MEMBERS", 30)
    path = archive(tmp_path / "a.bcf", members)
    with pytest.raises(LoadError, match=words):
        read_bcf(path)


def test_many_documents_that_unpack_to_little_each_are_refused_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bcf_in, "MOST_UNPACKED_BYTES", 1 << 20)
    text = "<Markup>" + " " * (300 << 10) + "</Markup>"
    with pytest.raises(LoadError, match="unpacks to more"):
        read_bcf(archive(tmp_path / "a.bcf", {f"{k}/markup.bcf": text for k in range(5)}))


def test_a_member_that_lies_about_its_size_is_counted(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.bcf", {"g/markup.bcf": "<Markup>" + " " * (8 << 20) + "</Markup>"})
    data = bytearray(path.read_bytes())
    size = (8 << 20) + 17
    at = data.rfind(size.to_bytes(4, "little"))
    data[at : at + 4] = (100).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(LoadError):
        read_bcf(path)


def test_names_that_lead_elsewhere_are_names(tmp_path: Path) -> None:
    view = "<Viewpoints><ViewPoint><Viewpoint>../../x</Viewpoint></ViewPoint></Viewpoints>"
    text = TOPIC.format(guid="", status="", more=view, beside="")
    (topic,) = read_bcf(archive(tmp_path / "a.bcf", {"../../etc/markup.bcf": text, "..\\..\\x": "no"}))
    assert (topic.guid, topic.parts) == ("..", ()) and [each.name for each in tmp_path.iterdir()] == ["a.bcf"]


def test_what_is_no_bcf_file(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError):
        read_bcf(tmp_path / "nothing.bcf")
    for data in (b"", b"PK", b"no zip at all" * 100):
        (tmp_path / "a.bcf").write_bytes(data)
        with pytest.raises(LoadError, match="is not a BCF file"):
            read_bcf(tmp_path / "a.bcf")
    with zipfile.ZipFile(tmp_path / "other.bcf", "w") as other:
        other.writestr("readme.txt", "hello")
    with pytest.raises(LoadError, match="it is not a BCF file"):
        read_bcf(tmp_path / "other.bcf")
    with pytest.raises(LoadError):
        read_bcf(tmp_path)


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(at=st.integers(0, 10**6), value=st.integers(0, 255), cut=st.integers(0, 10**6), how=st.booleans())
def test_damaged_files_raise_errors_of_feeler(tmp_path: Path, at: int, value: int, cut: int, how: bool) -> None:
    path = tmp_path / "whole.bcf"
    if not path.exists():
        write_bcf(path, feeler.clash(mockup()), mockup())
    data = bytearray(path.read_bytes())
    if how:
        data[at % len(data)] = value
    else:
        del data[cut % len(data) :]
    (tmp_path / "broken.bcf").write_bytes(data)
    try:
        topics = read_bcf(tmp_path / "broken.bcf")
    except LoadError:
        return
    apply_bcf(feeler.clash(mockup()), topics)


def pins() -> feeler.Mockup:
    """Three pins in one plate."""
    bodies = {"a/plate": box((0, 0, 0), (8, 1, 1))}
    bodies |= {f"a/pin_{i}": box((i, 0.4, 0.5), (i + 0.2, 0.6, 2)) for i in range(3)}
    return mockup_of(bodies)


def marked() -> feeler.Clashes:
    """Three findings of one group, each with another status, two with notes, and one of these on two lines."""
    found = feeler.clash(pins())
    found.set_status(found.ids[0], "approved", by="Ada", note='drawn so\nsee <sheet> 4; & "5"')
    found.set_status(found.ids[1], "reviewed", note="active: by hand")
    return found


def test_status_and_note_of_each_finding_go_out_and_come_back(tmp_path: Path) -> None:
    of = pins()
    found = marked()
    assert [len(group) for group in found.groups("part")] == [3], "one topic"
    write_bcf(tmp_path / "out.bcf", found, of)
    topics = read_bcf(tmp_path / "out.bcf")
    assert [topic.status for topic in topics] == ["new"] and len(topics[0].comments) == 2
    fresh = feeler.clash(of)
    changes = apply_bcf(fresh, topics)
    assert [(row.status, row.by, row.note) for row in fresh] == [(row.status, row.by, row.note) for row in found]
    assert set(changes.statuses) == {*found.ids[:2]} == {*changes.notes}
    again = apply_bcf(fresh, topics)
    assert (again.statuses, again.notes) == ((), ()), "the same file a second time changes nothing"


def test_a_topic_that_was_closed_since_counts_for_all_its_findings(tmp_path: Path) -> None:
    write_bcf(tmp_path / "out.bcf", marked(), pins())
    fresh = feeler.clash(pins())
    apply_bcf(fresh, read_bcf(edited(tmp_path / "out.bcf", "Closed", ("Bob", "all done"))))
    assert fresh.statuses.tolist() == ["reviewed"] * 3
    assert [row.note for row in fresh][1:] == ["active: by hand; Bob: all done", "Bob: all done"]


def test_comments_are_between_description_and_viewpoints(tmp_path: Path) -> None:
    """The order of the schema of BCF 3.0."""
    write_bcf(tmp_path / "out.bcf", marked(), pins())
    with zipfile.ZipFile(tmp_path / "out.bcf") as opened:
        (name,) = (each for each in opened.namelist() if each.endswith("markup.bcf"))
        topic = ElementTree.fromstring(opened.read(name)).find("Topic")
    assert topic is not None
    assert [each.tag for each in topic][-3:] == ["Description", "Comments", "Viewpoints"]
    comment = topic.find("Comments/Comment")
    assert comment is not None and [each.tag for each in comment] == ["Date", "Author", "Comment"]


def test_blanks_around_a_note_make_it_no_other_note(tmp_path: Path) -> None:
    """Files keep texts without them."""
    found = feeler.clash(pins())
    found.set_status(found.ids[0], "active", note=" ok\n")
    write_bcf(tmp_path / "out.bcf", found, pins())
    apply_bcf(found, read_bcf(tmp_path / "out.bcf"))
    assert found[0].note == " ok\n"
