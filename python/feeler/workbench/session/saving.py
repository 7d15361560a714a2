"""Saves the document of a session into its project, in a thread of its own.

The hand never waits: a change only wakes the thread, which writes all that changed since its last write in one
transaction, on the disk before the page says so. A write that fails is tried again.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from feeler.errors import FeelerError, LoadError
from feeler.mockup import Mockup, Tool
from feeler.project.book import Book, dumps, loads, now, open_or_make, row_id
from feeler.project.layout import MOST_ROWS, SUFFIX
from feeler.project.parts import PartContent, Revision, contents_of, rows_of
from feeler.project.renaming import Left, Names, checked_contents, renaming_changes, with_changes
from feeler.project.settings import FIELD
from feeler.project.store import Change, drop, put
from feeler.project.tools import tool_change, tool_of
from feeler.scene import Scene
from feeler.workbench.document import keeping
from feeler.workbench.document.document import Card, Document, ProjectFacts, ToolFacts
from feeler.workbench.document.revising import left_patterns, with_check, with_older, with_revision
from feeler.workbench.document.set_aside import Aside
from feeler.workbench.engine.hand import Hands
from feeler.workbench.session.record import digest

RETRY_S = 1.0
"""A write that failed is tried again after this time."""
_CLOSE_S = 20.0
_MOST_STALE = 20_000  # parts listed in the page

Told = Callable[[Document, str, "str | None"], None]
"""Called with the written document, the state and the trouble."""


class Saver:
    """Writes the newest document. Thread-safe; `changed` is called with the session's lock held, and never waits."""

    def __init__(self, project: Book, told: Told) -> None:
        self._project, self._told = project, told
        self._guard = threading.Condition()
        self._newest: Document | None = None
        self._written: Document | None = None
        self._shown: Document | None = None
        self._first: Callable[[], Iterator[Change]] | None = None
        """The changes that the first write makes besides: what is new in the mock-up."""
        self._renaming: list[Change] = []
        """The changes before that one: of findings, to the names of parts now."""
        self._answers: dict[int, Change] = {}
        """Answers of cards that are not written yet."""
        self._is_known = False
        """Whether the mock-up is the one that the project was saved with, so that answers are about its parts."""
        self._is_begun = self._is_closed = self._has_trouble = False
        self._trouble: str | None = None
        self._thread: threading.Thread | None = None

    @property
    def facts(self) -> ProjectFacts:
        """The facts before a mock-up is open."""
        return ProjectFacts(Path(self._project.path).name, "read only" if self._project.is_read_only else "saving")

    @staticmethod
    def is_same(one: Document, other: Document) -> bool:
        """Whether a project keeps the same of both."""
        return keeping.is_same(one, other) and _is_stale(one) == _is_stale(other)

    def begin(self, opened: Document, hands: Hands, tool: Tool | None) -> Document:
        """The document to go on with: the project's, for the opened mock-up. Raises `LoadError`.

        tool: that the workbench was opened with. Another one than last time replaces the project's.
        """
        project, scene = self._project, hands.scene
        before = _object(project.fact("mockup"))
        tool_facts = None if tool is None else {"name": tool.name, "hash": digest(tool)}
        assert opened.mockup is not None
        facts = replace(self.facts)
        document = opened
        revision: Revision | None = None
        aside: tuple[Aside, ...] = ()
        back: tuple[str, ...] = ()
        known = project.parts()
        if before.get("hash") == opened.mockup.hash:
            stale = {number: part.change for number, part in enumerate(known) if part.change is not None}
            facts = replace(facts, stale=_bounded(stale), gone=_keys(project.gone()))
        elif known:
            revision = project.revision(scene.mockup)
            facts = replace(facts, stale=_bounded(revision.stale), gone=_keys(revision.gone))
        self._is_known = revision is None
        fields, there = {row.id for row in project.rows("document")}, None
        # A clash check of the command line writes its settings and findings alone.
        is_known = bool(fields - {FIELD})
        if fields or project.rows("findings"):
            names = Names() if revision is None else Names.of(revision)
            self._renaming = renaming_changes(project, names)
            rows = with_changes(project.rows, self._renaming)
            kept = keeping.restored(
                opened,
                rows,
                project.marks(rows("marks")),
                lambda text, where: loads(text, f"{project.path}: {where}"),
                scene.mockup.parts,
                None if revision is None else _renumbering(revision),
                names,
                () if revision is None else [part.key for part in revision.parts],
                known,
            )
            number = _same if revision is None else _renumbering(revision)
            document, aside = with_older(kept.document, rows, known, number, scene.mockup.parts), kept.aside
            back = kept.back
            if revision is not None:
                document = with_revision(document, revision, scene.mockup.parts)
            document = with_check(document, checked_contents(rows), known if revision is None else revision.parts)
            # With the same mock-up, only what differs from the file is written.
            there = document if is_known and revision is None else None
            if document.tool is not None and document.tool.name not in hands.names:
                row = next((each for each in project.rows("tools") if each.id == row_id(document.tool.name)), None)
                if row is not None:
                    hands.add(tool_of(row, project.path))
            document = _with_tool(document, opened, hands, tool_facts != project.fact("tool"))
            renamed = project.renamed() if revision is None else project.part_changes(revision).renamed
            keys = [part.key for part in (known if revision is None else revision.parts)]
            left = Left(renamed, keys, scene.mockup.parts)
            facts = replace(facts, left=left_patterns(document, left))
        facts = replace(facts, aside=len(project.rows("aside")) + len(aside) - len(back))
        hands.begin(document)
        document = replace(document, project=facts, tools=hands.names, held_version=hands.version(document))
        with self._guard:
            self._written = None if there is None else replace(there, project=facts)
            lost = () if revision is None or revision.is_numbered_as_before else tuple(c.id for c in document.cards)
            lost += tuple(each.thing.id for each in aside if isinstance(each.thing, Card))
            self._first = lambda: self._opening(scene, opened, tool, tool_facts, revision, (aside, back), lost)
            self._is_begun = True
            if self._thread is None and not self._project.is_read_only:
                self._thread = threading.Thread(target=self._loop, name="feeler project", daemon=True)
                self._thread.start()
        return document

    def changed(self, before: Document, after: Document) -> Document:
        """Notes a document to save, and gives it with the state of the saving."""
        if after.project is None or not self._is_begun or self._project.is_read_only:
            return after
        with self._guard:
            if self._newest is not None and self.is_same(before, after):
                return after
            self._newest = replace(after, project=replace(after.project, state="saving"))
            self._guard.notify_all()
            return self._newest

    def answer(self, card: int) -> tuple[Any, bytes | None] | None:
        """The facts of a card's answer, and its bytes; None if the project has none of this mock-up."""
        return self._project.answer(_answer_id(card)) if self._is_known else None

    def keep_answer(self, card: int, facts: Mapping[str, Any], data: bytes | None) -> None:
        """Keeps the answer of a card, with the next change of the document."""
        change = put("answers", row_id(_answer_id(card)), card, dumps({"kind": "card", **facts}), data)
        with self._guard:
            self._answers[card] = change

    def wait(self, seconds: float) -> bool:
        """Waits until all is saved and told; whether it is, in time."""
        with self._guard:
            return self._guard.wait_for(lambda: self._newest is self._shown and self._first is None, seconds)

    def close(self) -> None:
        """Writes what is not written yet, if that is possible, and closes the project."""
        with self._guard:
            self._is_closed = True
            self._guard.notify_all()
        if self._thread is not None and threading.current_thread() is not self._thread:
            self._thread.join(_CLOSE_S)
        self._project.close()

    @property
    def unsaved(self) -> str | None:
        """Why the last changes are not in the project; None if they are."""
        with self._guard:
            is_behind = self._newest is not None and (self._newest is not self._written or self._first is not None)
            return (self._trouble or "writing takes too long") if is_behind else None

    # ---- the thread ----

    def _loop(self) -> None:
        while True:
            with self._guard:
                self._guard.wait_for(self._has_work, RETRY_S if self._has_trouble else None)
                is_last, target, first = self._is_closed, self._newest, self._first
            if target is not None and (target is not self._written or first is not None):
                self._save(target, first)
            if is_last:
                return

    def _has_work(self) -> bool:
        is_behind = self._newest is not None and (self._newest is not self._written or self._first is not None)
        return self._is_closed or (is_behind and not self._has_trouble)

    def _save(self, target: Document, first: Callable[[], Iterator[Change]] | None) -> None:
        try:
            with self._guard:
                answers = dict(self._answers)
            if self._renaming:  # first, so that the history does not take them for others
                self._project.write(self._renaming)
                self._renaming = []
            changes = [] if first is None else [*first()]
            changes += answers.values()
            changes += self._changes(target)
            self._project.write(changes)
        except Exception as error:
            # Every error is told: a page that waits for ever says nothing.
            text = str(error) if isinstance(error, FeelerError) else f"{type(error).__name__}: {error}"
            path = Path(self._project.path)
            for each in (str(path.absolute()), str(path)):
                text = text.replace(each, path.name)
            with self._guard:
                self._has_trouble, self._trouble = True, text
            self._told(target, "failed", text)
            return
        with self._guard:
            for card, change in answers.items():
                if self._answers.get(card) is change:
                    del self._answers[card]
            self._written, self._has_trouble, self._trouble = target, False, None
            if self._first is first:
                self._first = None
        self._told(target, "saved", None)
        with self._guard:
            self._shown = target
            self._guard.notify_all()

    def _changes(self, target: Document) -> Iterator[Change]:
        before = self._written
        if before is None:
            # The file has rows of another revision, with its numbers of parts: those of gone ones are set aside.
            yield from keeping.rows_to_drop(self._project.rows, target)
        yield from keeping.changes(before, target)
        there = {card.id for card in target.cards if card.state == "done"}
        for card in () if before is None else before.cards:
            if card.id not in there:
                yield drop("answers", row_id(_answer_id(card.id)))
        old, new = (None if before is None else before.findings), target.findings
        if before is None or (old is not new and (old is None or new is None or old.table is not new.table)):
            yield from self._all_findings(target)
        elif old is not new and old is not None and new is not None:
            yield from self._project.some_marks_changes(keeping.marks_that_differ(old, new), now())
        if before is not None and _is_stale(before) and not _is_stale(target):
            known = self._project.parts()
            yield from self._project.revision_changes(Revision(known, (), (), {}), is_accepted=True)

    def _all_findings(self, target: Document) -> Iterator[Change]:
        project = self._project
        rows = []
        for number, row in enumerate(keeping.finding_rows(target.findings)[:MOST_ROWS]):
            rows.append(row)
            if number % 16 == 0:
                time.sleep(0)
        there, here = {str(row.get("id")) for row in project.findings()}, [str(row["id"]) for row in rows]
        known = {row.value for row in project.rows("findings")}
        is_some_of_them = all(dumps(row) in known for row in rows)  # others are ignored now
        is_same = is_some_of_them or there == {*here}
        yield from keeping.check_changes(project, target.findings, is_same_check=is_same)
        yield from project.findings_changes(rows)
        gone = [] if target.findings is None else [str(row["id"]) for row in target.findings.resolved]
        yield from project.marks_changes(keeping.finding_marks(target.findings), here, gone)

    def _opening(
        self,
        scene: Scene,
        opened: Document,
        tool: Tool | None,
        tool_facts: dict[str, Any] | None,
        revision: Revision | None,
        aside: tuple[tuple[Aside, ...], tuple[str, ...]],
        lost: tuple[int, ...],
    ) -> Iterator[Change]:
        """What the project says of the mock-up and the tool.

        aside: what is set aside now, and the rows that are back. lost: cards whose answers name parts by the numbers
        of another revision.
        """
        project, facts = self._project, opened.mockup
        assert facts is not None
        mockup = {
            **_object(project.fact("mockup")),
            **{"name": facts.name, "hash": facts.hash, "triangles": scene.mockup.triangle_count, "parts": facts.parts},
        }
        for name, value in (("mockup", mockup), ("tool", tool_facts)):
            if project.fact(name) != value:
                yield put("facts", name, 0, dumps(value))
                if name == "tool" and tool is not None and tool_facts is not None:
                    change = tool_change(tool, tool_facts["hash"])
                    if change is not None:
                        yield change
        yield from (drop("answers", row_id(_answer_id(card))) for card in lost)
        keys = [part.key for part in project.parts()]  # of the revision before, by which things are set aside
        if revision is not None:
            yield from project.revision_changes(revision)
        elif not project.parts():
            yield from rows_of(contents_of(scene.mockup))
        there = project.rows("aside")
        yield from (drop("aside", row) for row in aside[1])
        for place, each in enumerate(aside[0], start=1 + max((row.place for row in there), default=-1)):
            yield put("aside", str(place), place, keeping.aside_row(each, keys, now()))


def _answer_id(card: int) -> str:
    return f"card {card}"


def project_of(document: Document, mockup: Mockup, kept: Mapping[str, Any] | None = None) -> bytes:
    """A new project of a document, as the bytes of its file. kept: how the files of the mock-up were read."""
    with tempfile.TemporaryDirectory() as folder:
        book = open_or_make(Path(folder) / f"new{SUFFIX}")
        try:
            facts = document.mockup
            assert facts is not None, "of a mock-up that is open"
            about = {"name": facts.name, "hash": facts.hash, "triangles": mockup.triangle_count, "parts": facts.parts}
            found = document.findings
            changes = [
                put("facts", "mockup", 0, dumps(about)),
                *([] if kept is None else [put("facts", "opened", 0, dumps(dict(kept)))]),
                *rows_of(contents_of(mockup)),
                *keeping.changes(None, document),
                *keeping.check_changes(book, found, is_same_check=False),
                *book.findings_changes(keeping.finding_rows(found)),
                *book.marks_changes(keeping.finding_marks(found), ()),
            ]
            book.write(changes)
            return book.copied()
        finally:
            book.close()


def _with_tool(document: Document, opened: Document, hands: Hands, is_chosen: bool) -> Document:
    """The document with a tool that is there."""
    if is_chosen and opened.tool is not None:
        pose = document.pose if document.gripped else opened.pose
        return replace(document, tool=opened.tool, pose=pose)
    if document.tool is None:
        return document
    name = document.tool.name
    if name not in hands.names:
        return replace(document, tool=opened.tool)
    return replace(document, tool=ToolFacts(name, hands.tool(name).triangle_count))


def _same(part: int) -> int:
    return part


def _renumbering(revision: Revision) -> Callable[[int], int | None]:
    rows = revision.row_of

    def number(part: int) -> int | None:
        if not 0 <= part < len(rows):
            raise LoadError(f"the project has no part {part}: it is damaged; use a copy")
        return rows[part]

    return number


def _bounded(stale: Mapping[int, str]) -> Mapping[int, str]:
    return MappingProxyType(dict(list(stale.items())[:_MOST_STALE]))


def _keys(gone: Sequence[PartContent]) -> tuple[str, ...]:
    return tuple(part.key for part in gone[:_MOST_STALE])


def _is_stale(document: Document) -> bool:
    facts = document.project
    return facts is not None and bool(facts.stale or facts.gone or facts.left)


def _object(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
