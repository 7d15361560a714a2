"""Reads BCF (2.0, 2.1, 3.0): what people decided about topics elsewhere goes back to the findings.

The file is a stranger's: nothing is unpacked to disk, sizes are counted while they are read, and XML with a document
type is refused, since entities can grow without bound.
"""

from __future__ import annotations

import io
import math
import os
import re
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from typing import IO
from xml.parsers import expat

from feeler.arguments import check_kind, check_length, check_list, check_path
from feeler.choices import GROUPS_BY, Status
from feeler.clashes.bcf_notes import LONGEST_NOTE, SYSTEM, FindingNote, Seen, is_further, note_of, seen_in, written_in
from feeler.clashes.result import Clashes
from feeler.clashes.tracking import DEPTH_GROWTH_M, Found, Mark, check_of, derived_id, outgrown
from feeler.errors import LoadError, MissingFileError
from feeler.field_docs import documented

MOST_BYTES = 1 << 30
"""Bytes of a file."""
MOST_MEMBERS = 50_000
"""Members of an archive."""
MOST_TOPICS = 10_000
"""Topics that are read."""
MOST_MEMBER_BYTES = 4 << 20
"""Bytes of one XML document, unpacked."""
MOST_UNPACKED_BYTES = 256 << 20
"""Bytes of all XML documents, unpacked."""
_MOST_LEVELS = 64
_MOST_ELEMENTS = 200_000  # of one document
_BLOCK_BYTES = 1 << 16

_STATUSES: dict[str, Status] = {
    **dict.fromkeys(("new", "open", "opened", "unassigned"), "new"),
    **dict.fromkeys(("active", "in progress", "assigned", "reopened", "re-opened", "ongoing"), "active"),
    **dict.fromkeys(("reviewed", "in review", "review", "resolved", "done", "fixed", "closed"), "reviewed"),
    **dict.fromkeys(("approved", "accepted", "ignored", "not an issue", "void"), "approved"),
}
"""What the words of trackers mean here. Whether a resolved clash is gone, the next check finds."""
_RANKS = {"active": 1, "reviewed": 2, "approved": 2}
"""How far a finding is decided; others are not."""


@documented
@dataclass(frozen=True)
class Comment:
    """A comment on a topic; author and date may be empty."""

    text: str
    """The text of the comment."""
    author: str = ""
    date: str = ""


@documented
@dataclass(frozen=True)
class Topic:
    """A topic of a BCF file.

    status: as the file has it. parts: the texts that name selected components, which are part paths in files of feeler.
    ids: the ids of findings that the description names, and the comment that goes on where it is cut. seen: of those,
    the verdict and the signed depth, metres, that they had; None where the file does not say. written, check: the
    status that the topic had when feeler wrote it, and the check that it is of; empty where the file does not say.
    """

    guid: str
    """Of the topic, as the file has it."""
    title: str
    """Its title."""
    status: str
    description: str = ""
    assigned_to: str = ""
    """Who is to look at it; empty if nobody is."""
    comments: tuple[Comment, ...] = ()
    """In the order of the file."""
    parts: tuple[str, ...] = ()
    ids: tuple[str, ...] = ()
    seen: tuple[Seen, ...] = ()
    written: str = ""
    check: str = ""


@documented
@dataclass(frozen=True)
class BcfChanges:
    """What `apply_bcf` did."""

    statuses: tuple[str, ...]
    """Ids of findings that got another status."""
    notes: tuple[str, ...]
    """Ids of findings that got another note."""
    unknown: tuple[Topic, ...]
    """Topics of no finding of the table."""
    outgrown: tuple[str, ...] = ()
    """Ids of findings that the file approves, but that are deeper now, or duplicates: they were not approved."""


def read_bcf(path: str | os.PathLike[str]) -> tuple[Topic, ...]:
    """The topics of a BCF file (`.bcf`, `.bcfzip`) of versions 2.0 to 3.0, in the order of their titles and GUIDs.

    Archive and XML are read with limits, and document types are refused. Raises `MissingFileError` if the file does not
    exist, and `LoadError` if it is no BCF file, is damaged, or is too large to be one.
    """
    file = check_path("path", path)
    try:
        with file.open("rb") as opened:
            return topics_in(opened, str(file))
    except FileNotFoundError:
        raise MissingFileError(f"{file} does not exist: give a BCF file") from None
    except OSError as error:
        raise LoadError(f"{file} cannot be read: {error.strerror or error}") from None


def topics_in(opened: IO[bytes], name: str) -> tuple[Topic, ...]:
    """The topics of an open file; see `read_bcf`."""
    opened.seek(0, io.SEEK_END)
    if opened.tell() > MOST_BYTES:
        raise LoadError(f"{name} has {opened.tell():,} bytes, and {MOST_BYTES:,} are the most of a BCF file")
    opened.seek(0)
    try:
        with zipfile.ZipFile(opened) as archive:
            return tuple(_Archive(archive, name).topics())
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        EOFError,
        NotImplementedError,
        RuntimeError,
        ValueError,
        OSError,
        zlib.error,
    ) as error:
        raise LoadError(f"{name} is not a BCF file, or is damaged ({error}): export it again") from None


def apply_bcf(clashes: Clashes, topics: Sequence[Topic], *, growth: float = DEPTH_GROWTH_M) -> BcfChanges:
    """Sets the statuses and notes of findings by the topics of a BCF file, as `read_bcf` reads them.

    A topic belongs to the findings that its description names. If it names none, it belongs to those of its group
    (`write_bcf` derives GUIDs from groups), else to those of the pair of parts that its viewpoint selects. An approval
    holds for the depth that the file says; as in `Clashes.diff`, it ends if a finding is `growth` metres deeper now, or
    a duplicate. After `diff`, topics of the previous check go to the findings that it matched. If nobody changed the
    status of a topic, later decisions here stay. Comments become the note, newest last; one that the note has already
    is not added again. A comment of `write_bcf` belongs to the one finding that it names; its status counts if the
    topic still has the status that it had then. A status without a counterpart here goes into the note. Statuses of
    trackers: open and new become new; active and in progress, active; resolved and closed, reviewed (the next check
    finds what is gone); approved and accepted become approved.
    """
    check_kind("clashes", clashes, Clashes, "feeler.Clashes")
    given = check_list("topics", topics, "a list of feeler.clashes.Topic")
    check_length("growth", growth)
    finder = _Finder(clashes)
    statuses, notes, unknown, deeper = [], [], [], []
    for topic in given:
        topic = check_kind("topics", topic, Topic, "a list of feeler.clashes.Topic")
        word = topic.status.strip().lower()
        own, topic = _split(replace(topic, comments=tuple(sorted(topic.comments, key=_time))))
        own = {here: said for each, said in own.items() if (here := finder.here(topic, each)) is not None}
        is_untouched = any(said.topic == word for _, said in own.values())
        found = tuple(dict.fromkeys((*finder.of(topic), *own)))
        seen = {finder.here(topic, each.finding): each for each in topic.seen}
        if not found:
            unknown.append(topic)
        for each in found:
            before, status = clashes.marks.of(each), _STATUSES.get(word)
            note, by = before.note, topic.comments[-1].author if topic.comments else before.by
            if is_untouched and each not in own:
                status = None
            if each in own:
                author, said = own[each]
                note = _joined([note, said.note])
                if said.topic == word:
                    status, by = said.status, "" if author == SYSTEM else author
            if topic.written == word and _RANKS.get(before.status, 0) > min(_RANKS.get(status or "new", 0), 1):
                status = None  # it was decided here since
            after = replace(before, note=noted(note, topic))
            approval = _approval(seen.get(each)) if status == "approved" != before.status else None
            if approval is not None and (why := outgrown(approval, finder.found(each), growth)):
                status, after = None, replace(after, note=_joined([after.note, why]))
                deeper.append(each)
            if status is not None and status != before.status and before.status != "resolved":
                clashes.marks.set(each, status, finder.found(each), by, after.note)
                if approval is not None:
                    clashes.marks.put(each, _approved_as(clashes.marks.of(each), approval))
                statuses.append(each)
            elif after != before:
                clashes.marks.put(each, after)
            if after.note != before.note:
                notes.append(each)
    changed, more, less = (tuple(dict.fromkeys(each)) for each in (statuses, notes, deeper))
    return BcfChanges(changed, more, tuple(unknown), less)


def _approval(seen: Seen | None) -> Mark | None:
    """An approval of a finding as a file says that it was; None if it does not."""
    if seen is None or seen.depth is None:
        return None
    return Mark("approved", approved_depth=seen.depth, approved_verdict=seen.verdict)


def _approved_as(mark: Mark, approval: Mark) -> Mark:
    depth, verdict = approval.approved_depth, approval.approved_verdict
    return replace(mark, approved_depth=depth, approved_error=None, approved_verdict=verdict)


def _time(comment: Comment) -> float:
    """When a comment was written; those without a date come first."""
    try:
        date = datetime.fromisoformat(re.sub(r"[zZ]$", "+00:00", comment.date.strip()))
        return (date if date.tzinfo else date.replace(tzinfo=timezone.utc)).timestamp()
    except (ValueError, OverflowError):
        return -math.inf


def noted(note: str, topic: Topic) -> str:
    """A note with the comments of a topic, each once."""
    lines = [note] if note else []
    if topic.status.strip() and topic.status.strip().lower() not in _STATUSES:
        lines.append(f"BCF: {topic.status.strip()}")
    for comment in topic.comments:
        text = " ".join(comment.text.split())
        lines.append(f"{comment.author}: {text}" if comment.author else text)
    return _joined(lines)


def _joined(lines: Iterable[str]) -> str:
    """Lines as one note, each once."""
    kept: list[str] = []
    for line in lines:
        words = line.strip()
        if words and not any(words in before.split("; ") or words == before.strip() for before in kept):
            kept.append(line)
    return "; ".join(kept)[:LONGEST_NOTE]


def _split(topic: Topic) -> tuple[dict[str, tuple[str, FindingNote]], Topic]:
    """The author and content of the comments on single findings, by finding, and the topic without these comments."""
    own: dict[str, tuple[str, FindingNote]] = {}
    rest = []
    for comment in topic.comments:
        said = note_of(comment.text)
        if said is None:
            rest.append(comment)
        else:
            own[said.finding] = (comment.author, said)
    return own, replace(topic, comments=tuple(rest))


class _Finder:
    """Finds the findings of topics."""

    def __init__(self, clashes: Clashes) -> None:
        self._ids = set(clashes.ids)
        self._marks = clashes.marks
        self._check = check_of(clashes.ids, (clashes.points_a, clashes.points_b))
        self._row = {each: row for row, each in enumerate(clashes.ids)}
        self._found = clashes.found()
        self._groups: dict[str, tuple[str, ...]] = {}
        for by in GROUPS_BY:
            for group in clashes.groups(by):
                self._groups[derived_id("topic", by, group.name)] = group.clashes.ids
        self._pairs: dict[frozenset[str], list[str]] = {}
        for each, a, b in zip(clashes.ids, clashes.paths_a.tolist(), clashes.paths_b.tolist(), strict=True):
            self._pairs.setdefault(frozenset((a, b)), []).append(each)

    def of(self, topic: Topic) -> tuple[str, ...]:
        """The ids of a topic's findings."""
        named = [here for each in topic.ids if (here := self.here(topic, each)) is not None]
        if named:
            return tuple(dict.fromkeys(named))
        if topic.ids and (topic.check or self._marks.former or topic.guid in self._groups):
            return ()  # of findings that are gone, it says nothing of those that are in their place now
        if topic.guid in self._groups:
            return self._groups[topic.guid]
        return tuple(self._pairs.get(frozenset(topic.parts), ()))

    def here(self, topic: Topic, each: str) -> str | None:
        """The id here of a finding that a topic names; None if it is gone, or if it is open which one it is."""
        former = self._marks.former
        if not former or topic.check == self._check:
            return each if each in self._ids else None
        moved = former.get(each, None if topic.check == self._marks.former_check else each)
        if topic.check != self._marks.former_check and moved != each and each in self._ids:
            return None
        return moved if moved in self._ids else None

    def found(self, each: str) -> Found:
        """What `diff` compares of a finding."""
        return self._found[self._row[each]]


@dataclass
class _Element:
    tag: str
    attributes: dict[str, str]
    children: list[_Element] = field(default_factory=list)
    text: str = ""

    def first(self, tag: str) -> _Element | None:
        return next((each for each in self.children if each.tag == tag), None)

    def said(self, tag: str) -> str:
        found = self.first(tag)
        return "" if found is None else found.text.strip()

    def every(self, tag: str) -> Iterator[_Element]:
        """All elements of a name below, in order."""
        waiting = [*reversed(self.children)]
        while waiting:
            each = waiting.pop()
            if each.tag == tag:
                yield each
            waiting += reversed(each.children)


class _Archive:
    def __init__(self, archive: zipfile.ZipFile, name: str) -> None:
        self._archive, self._name = archive, name
        self._unpacked = 0
        infos = archive.infolist()
        if len(infos) > MOST_MEMBERS:
            raise self.fail(f"it has {len(infos):,} members, and {MOST_MEMBERS:,} are the most")
        self._members = {info.filename.replace("\\", "/"): info for info in infos}

    def fail(self, what: str) -> LoadError:
        return LoadError(f"{self._name}: {what}; export it again")

    def topics(self) -> Iterator[Topic]:
        markups = sorted(each for each in self._members if each.lower().endswith("/markup.bcf"))
        if not markups and "bcf.version" not in self._members:
            raise self.fail("there is no bcf.version and no topic: it is not a BCF file")
        if len(markups) > MOST_TOPICS:
            raise self.fail(f"it has {len(markups):,} topics, and {MOST_TOPICS:,} are the most")
        found = [topic for each in markups if (topic := self._topic(each)) is not None]
        yield from sorted(found, key=lambda topic: (topic.title, topic.guid))

    def _topic(self, member: str) -> Topic | None:
        root = self._document(member)
        topic = root.first("Topic")
        if topic is None:
            return None
        # BCF 3.0 has the comments inside of the topic, earlier versions beside it.
        comments = [*topic.every("Comment"), *(each for each in root.children if each.tag == "Comment")]
        description = topic.said("Description")
        every = [_comment(each) for each in comments if each.said("Comment")]
        further = [each.text for each in every if is_further(each.text)]
        seen = seen_in("\n".join([description, *further]).lower())
        written, check = written_in(description)
        return Topic(
            guid=topic.attributes.get("Guid", "").strip().lower() or member.split("/")[0],
            title=topic.said("Title"),
            status=topic.attributes.get("TopicStatus", "").strip(),
            description=description,
            assigned_to=topic.said("AssignedTo"),
            comments=tuple(each for each in every if not is_further(each.text)),
            parts=self._parts(member, root),
            ids=tuple(each.finding for each in seen),
            seen=seen,
            written=written,
            check=check,
        )

    def _parts(self, member: str, root: _Element) -> tuple[str, ...]:
        """The components that the first viewpoint selects."""
        folder = member.rpartition("/")[0]
        named = [each.text.strip() for each in root.every("Viewpoint") if each.text.strip()]
        for name in [*named, "viewpoint.bcfv"]:
            path = f"{folder}/{name}"
            if path not in self._members:
                continue
            found = [each.said("AuthoringToolId") for each in _selected(self._document(path))]
            return tuple(dict.fromkeys(each for each in found if each))
        return ()

    def _document(self, member: str) -> _Element:
        """The root of an XML document."""
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.buffer_text = True
        root = _Element("", {})
        open_now, count = [root], 0
        text: list[list[str]] = [[]]

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal count
            count += 1
            if len(open_now) > _MOST_LEVELS or count > _MOST_ELEMENTS:
                raise self.fail(f"{member!r} has too many or too deeply nested elements")
            element = _Element(tag.rpartition(" ")[2], attributes)
            open_now[-1].children.append(element)
            open_now.append(element)
            text.append([])

        def end(_tag: str) -> None:
            open_now.pop().text = "".join(text.pop())

        def doctype(*_: object) -> None:
            raise self.fail(f"{member!r} declares a document type, which BCF has no use for: it was not opened")

        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.CharacterDataHandler = lambda piece: text[-1].append(piece)
        parser.StartDoctypeDeclHandler = doctype
        try:
            for block in self._blocks(member):
                parser.Parse(block)
            parser.Parse(b"", True)
        except expat.ExpatError as error:
            raise self.fail(f"the XML of {member!r} is damaged ({error})") from None
        return root.children[0]

    def _blocks(self, member: str) -> Iterable[bytes]:
        """The bytes of a member, counted as they come: the sizes in the archive may lie."""
        size = 0
        with self._archive.open(self._members[member]) as opened:
            while block := opened.read(_BLOCK_BYTES):
                size += len(block)
                self._unpacked += len(block)
                if size > MOST_MEMBER_BYTES or self._unpacked > MOST_UNPACKED_BYTES:
                    raise self.fail(f"{member!r} unpacks to more than a BCF file needs: it was not opened")
                yield block


def _selected(viewpoint: _Element) -> list[_Element]:
    """The components that a viewpoint selects. BCF 2.0 has no list of them: each component has a mark of its own."""
    for selection in viewpoint.every("Selection"):
        return [*selection.every("Component")]
    marked = viewpoint.every("Component")
    return [each for each in marked if each.attributes.get("Selected", "").strip().lower() in ("true", "1")]


def _comment(element: _Element) -> Comment:
    author = element.said("ModifiedAuthor") or element.said("Author")
    return Comment(element.said("Comment"), author, element.said("ModifiedDate") or element.said("Date"))
