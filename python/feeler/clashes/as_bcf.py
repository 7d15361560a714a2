"""Findings as BCF 3.0, the BIM Collaboration Format of buildingSMART: a topic for each group.

A zip with `bcf.version`, `project.bcfp`, `extensions.xml` and a folder for each topic: `markup.bcf`, `viewpoint.bcfv`
and `snapshot.png`. GUIDs follow from the names of groups, so that the same group is the same topic in every file.
"""

from __future__ import annotations

import datetime
import itertools
import os
import re
import zipfile
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from feeler.arguments import check_kind, check_progress, check_text, check_whole
from feeler.atomic import atomic_file
from feeler.choices import GroupBy
from feeler.clashes.bcf_notes import SYSTEM, comment_of, further_text, seen_text, written_text
from feeler.clashes.result import Clashes, Group
from feeler.clashes.table import Clash
from feeler.clashes.tracking import Mark, check_of, derived_id
from feeler.clashes.verdict import SEVERITIES, Verdict
from feeler.clashes.words import sentence, title
from feeler.mockup import Mockup
from feeler.progress import Progress

if TYPE_CHECKING:
    from feeler.clashes.pictures import View

MOST_TOPICS = 100
"""Most topics in a file. Nobody reads thousands."""
MOST_LINES = 50
"""Most findings that the description of a topic lists."""
MOST_COMMENT_TEXT = 1_000_000
"""Most characters of the comments of a topic, those of the worst findings first."""

MOST_FURTHER_TEXT = 2_000_000
"""Most characters of the ids of findings that the description of a topic leaves out: some 30,000 findings."""

_STATUSES = ("new", "active", "reviewed", "approved")
_DECIDED = ("reviewed", "approved")
_COLOURS = ("4580CC", "FF850D")  # of the first and the second part, as in the picture
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can store: equal findings give equal bytes
_LONGEST_TITLE = 250
"""Characters of a title; the description has the paths in full."""
_UNNAMED = "(no name)"
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_bcf(
    path: str | os.PathLike[str],
    clashes: Clashes,
    mockup: Mockup,
    *,
    by: GroupBy = "part",
    most: int = MOST_TOPICS,
    author: str = SYSTEM,
    when: datetime.datetime | None = None,
    progress: Progress | None = None,
) -> int:
    """Writes a topic for each group, with a viewpoint and a picture. Returns the number of topics.

    If there are more than `most` groups, those with decisions are kept first, whatever their rank: a finding that is
    reviewed or approved, has a note, or names who set its status. Then the worst are kept. The others are left out. The
    viewpoint and the picture show the worst finding of the group. The description lists the 50 worst findings, and a
    comment the ids of some 30,000 more. `AuthoringToolId` holds the path of a part. A finding with a note, or with
    another status than its topic, has a comment, which `apply_bcf` reads back. by: how to group, as in
    `Clashes.groups`. author, when: of the topics; `when` is now by default. Raises `WriteError`, and `OptionError` if
    the clashes are of another mock-up or `most` is less than 1.
    """
    from feeler.clashes.pictures import Pictures
    from feeler.clashes.table import check_same

    most = check_whole("most", most, 1)
    check_text("author", author)
    check_progress(progress)
    if when is not None:
        check_kind("when", when, datetime.datetime, "a datetime.datetime, or None")
    check_same(mockup, clashes)
    author = _named(author, SYSTEM)
    date = (when or datetime.datetime.now(datetime.timezone.utc)).isoformat(timespec="seconds")
    groups = _chosen(clashes.groups(by), most)
    pictures = Pictures(mockup)
    files = {
        "bcf.version": _xml(_element("Version", {"VersionId": "3.0"})),
        "project.bcfp": _xml(_project(clashes)),
        "extensions.xml": _xml(_extensions(author)),
    }
    for number, group in enumerate(groups):
        if progress is not None:
            progress(number / len(groups), f"topic {number + 1} of {len(groups)}")
        guid = derived_id("topic", by, group.name)
        view = derived_id("viewpoint", by, group.name)
        files[f"{guid}/markup.bcf"] = _xml(_markup(group, clashes, number, guid, view, author, date))
        files[f"{guid}/viewpoint.bcfv"] = _xml(_viewpoint(group.worst, pictures.view(group.worst), view))
        files[f"{guid}/snapshot.png"] = pictures.png(group.worst)
    with atomic_file(path, ".bcf", ".bcfzip") as out, zipfile.ZipFile(out, "w") as archive:
        for name, data in files.items():
            kind = zipfile.ZIP_STORED if name.endswith(".png") else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(name, _EPOCH), data, kind)
    return len(groups)


def left_out(clashes: Clashes, by: GroupBy, topics: int) -> str:
    """Says which groups a file with this many topics lacks: "has the 100 worst of 120 groups". Empty if it has all."""
    groups = clashes.groups(by)
    if topics >= len(groups):
        return ""
    decided = sum(map(_is_decided, groups))
    if not decided:
        return f"has the {topics:,} worst of {len(groups):,} groups"
    said = f"has {topics:,} of {len(groups):,} groups"
    if decided > topics:
        return f"{said}, the worst of {decided:,} with decisions"
    return f"{said}: {decided:,} with decisions, and the worst of the others"


def _chosen(groups: list[Group], most: int) -> list[Group]:
    """The groups of a file, the worst first: those with decisions before others."""
    ranks = sorted(range(len(groups)), key=lambda rank: (not _is_decided(groups[rank]), rank))
    return [groups[rank] for rank in sorted(ranks[:most])]


def _is_decided(group: Group) -> bool:
    """Whether somebody decided about one of its findings. `diff` makes findings active, so that this alone is none."""
    marks = map(group.clashes.marks.of, group.clashes.ids)
    return any(mark.status in _DECIDED or mark.by or mark.note for mark in marks)


Element = ElementTree.Element


def _element(name: str, attributes: Mapping[str, str] | None = None, *inside: Element | str) -> Element:
    """An XML element with its text or child elements. Characters that XML forbids become question marks."""
    made = Element(name, {key: _NO_XML.sub("?", value) for key, value in (attributes or {}).items()})
    for each in inside:
        if isinstance(each, str):
            made.text = _NO_XML.sub("?", each)
        else:
            made.append(each)
    return made


def _named(text: str, otherwise: str = _UNNAMED) -> str:
    """The text, or `otherwise` if it is blank: the schema forbids blank text (`NonEmptyOrBlankString`)."""
    return text if text.strip() else otherwise


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_TITLE else text[: _LONGEST_TITLE - 1] + "…"


def _file_name(file: str) -> str:
    return _named(file.replace("\\", "/").rpartition("/")[2])


def _xml(root: Element) -> bytes:
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text


def _project(clashes: Clashes) -> Element:
    name = ", ".join(map(_file_name, clashes.facts.files)) or "mock-up"
    return _element(
        "ProjectInfo", {}, _element("Project", {"ProjectId": derived_id("project", name)}, _element("Name", {}, name))
    )


def _extensions(author: str) -> Element:
    def words(several: str, one: str, values: Iterable[str]) -> Element:
        return _element(several, {}, *(_element(one, {}, value) for value in values))

    return _element(
        "Extensions",
        {},
        words("TopicTypes", "TopicType", ["Clash"]),
        words("TopicStatuses", "TopicStatus", _STATUSES),
        words("Priorities", "Priority", SEVERITIES),
        words("TopicLabels", "TopicLabel", list(Verdict)),
        words("Users", "User", [author]),
    )


def _markup(group: Group, clashes: Clashes, number: int, guid: str, view: str, author: str, date: str) -> Element:
    members = group.clashes
    statuses = set(members.statuses.tolist())
    # The least reviewed finding gives the status of the topic.
    status = next((each for each in _STATUSES if each in statuses), "new")
    labels = sorted(set(members.verdicts.tolist()))
    seen = [seen_text(each, found) for each, found in zip(members.ids, members.found(), strict=True)]
    first = zip(members[:MOST_LINES], seen, strict=False)
    lines = [f"{sentence(clash)} ({clash.path_a}; {clash.path_b}; {said})" for clash, said in first]
    if len(members) > MOST_LINES:
        lines.append(f"... and {len(members) - MOST_LINES:,} more")
    lines.append(written_text(status, check_of(clashes.ids, (clashes.points_a, clashes.points_b))))
    files = [
        _element("File", {"IsExternal": "true"}, _element("Filename", {}, _file_name(file)))
        for file in clashes.facts.files
    ]
    topic = _element(
        "Topic",
        {
            "Guid": guid,
            "TopicType": "Clash",
            "TopicStatus": status,
        },
        _element("Title", {}, _shortened(title(group))),
        _element("Priority", {}, group.worst.severity),
        _element("Index", {}, str(number)),
        _element("Labels", {}, *(_element("Label", {}, each) for each in labels)),
        _element("CreationDate", {}, date),
        _element("CreationAuthor", {}, author),
        _element("Description", {}, "\n".join(lines)),
        _element(
            "Viewpoints",
            {},
            _element(
                "ViewPoint",
                {"Guid": view},
                _element("Viewpoint", {}, "viewpoint.bcfv"),
                _element("Snapshot", {}, "snapshot.png"),
                _element("Index", {}, "0"),
            ),
        ),
    )
    comments = [*_comments(group, guid, status, author, date), *_further(seen[MOST_LINES:], guid, date)]
    if comments:
        # The schema wants them between the description and the viewpoints.
        topic.insert(len(topic) - 1, _element("Comments", {}, *comments))
    header = [_element("Header", {}, _element("Files", {}, *files))] if files else []
    return _element("Markup", {}, *header, topic)


def _further(seen: list[str], guid: str, date: str) -> list[Element]:
    """The comment with the findings that the description leaves out, if there are any."""
    kept = list(itertools.takewhile(lambda size: size <= MOST_FURTHER_TEXT, itertools.accumulate(map(len, seen))))
    if not kept:
        return []
    said = (("Date", date), ("Author", SYSTEM), ("Comment", further_text(seen[: len(kept)])))
    made = _element("Comment", {"Guid": derived_id("comment", guid, "further")})
    made.extend(_element(name, {}, text) for name, text in said)
    return [made]


def _comments(group: Group, guid: str, status: str, author: str, date: str) -> list[Element]:
    """A comment for each finding of which the topic does not say enough."""
    found, size = [], 0
    for clash in group.clashes:
        mark = Mark(clash.status, clash.by, clash.note)
        text = comment_of(clash.id, mark, sentence(clash), status)
        if text is None:
            continue
        size += len(text)
        if size > MOST_COMMENT_TEXT:
            break
        by = _element("Author", {}, _named(mark.by, author))
        said = _element("Date", {}, date), by, _element("Comment", {}, text)
        found.append(_element("Comment", {"Guid": derived_id("comment", guid, clash.id)}, *said))
    return found


def _viewpoint(clash: Clash, view: View, guid: str) -> Element:
    camera = view.camera
    _, up, forward = camera.axes()

    def part(path: str) -> Element:
        known = _element("OriginatingSystem", {}, SYSTEM), _element("AuthoringToolId", {}, _named(path))
        return _element("Component", {}, *known)

    def vector(name: str, values: Iterable[float]) -> Element:
        axes = [_element(axis, {}, repr(float(value))) for axis, value in zip("XYZ", values, strict=True)]
        return _element(name, {}, *axes)

    planes = [] if view.normal is None else [(vector("Location", view.point), vector("Direction", view.normal))]
    paths = (clash.path_a, clash.path_b)
    colours = [
        _element("Color", {"Color": colour}, _element("Components", {}, part(path)))
        for colour, path in zip(_COLOURS, paths, strict=True)
    ]
    from feeler.clashes.pictures import SIZE

    return _element(
        "VisualizationInfo",
        {"Guid": guid},
        _element(
            "Components",
            {},
            _element("Selection", {}, *(part(path) for path in paths)),
            _element("Visibility", {"DefaultVisibility": "true"}),
            _element("Coloring", {}, *colours),
        ),
        _element(
            "PerspectiveCamera",
            {},
            vector("CameraViewPoint", camera.eye),
            vector("CameraDirection", forward),
            vector("CameraUpVector", up),
            _element("FieldOfView", {}, repr(camera.fov_deg)),
            _element("AspectRatio", {}, repr(SIZE[0] / SIZE[1])),
        ),
        *(_element("ClippingPlanes", {}, _element("ClippingPlane", {}, *plane)) for plane in planes),
    )
