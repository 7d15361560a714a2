"""What a report is made of: the document, the parts, the answers and the history, of a project or of a session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from feeler.errors import FeelerError, LoadError, WorkbenchError
from feeler.mockup import Mockup
from feeler.parts import Parts
from feeler.project.book import Book, loads
from feeler.project.parts import PartChanges, PartContent, Revision, contents_of, revised
from feeler.project.renaming import Left, Names, checked_contents, parts_of_keys, renaming_changes, with_changes
from feeler.project.runs import RunFacts, shown_of
from feeler.workbench.document import keeping, motion
from feeler.workbench.document.answers import CardAnswer
from feeler.workbench.document.cards import task_parts
from feeler.workbench.document.document import Document, MockupFacts
from feeler.workbench.document.frames import check
from feeler.workbench.document.revising import left_patterns, with_check, with_older, with_revision
from feeler.workbench.document.set_aside import Renumber

_SOURCES = 1000


@dataclass(frozen=True, eq=False)
class Source:
    """See the module. mockup: None without its files: no pictures. changes: against the mock-up as it is now.

    stale: how parts changed, by number. history: of statuses, as JSON. run: the last one of `feeler maintain`.
    since_run: how the mock-up changed after it.
    """

    name: str
    document: Document
    parts: Parts
    mockup: Mockup | None
    sources: tuple[str, ...]
    answers: Mapping[int, CardAnswer] = field(default_factory=dict)
    history: Sequence[Mapping[str, Any]] = ()
    changes: PartChanges = field(default_factory=PartChanges)
    stale: Mapping[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    run: RunFacts | None = None
    since_run: PartChanges = field(default_factory=PartChanges)


def of_book(
    book: Book,
    mockup: Mockup | None,
    absent: Sequence[int] = (),
    *,
    content: str = "",
    notes: Sequence[str] = (),
    progress: Callable[[float, str], object] | None = None,
) -> Source:
    """The source of an open project. mockup: as it is now; None: its files are not there. content: its digest.

    absent: parts left out. Raises `LoadError` for a damaged project, and one of another mock-up.
    """
    known, gone = book.parts(), book.gone()
    if not known:
        raise LoadError(f"{book.path} has no mock-up yet: open it with feeler view MOCKUP --project FILE")
    revision = book.revision(mockup, progress) if mockup is not None else revised(known, gone, known)
    parts = mockup.parts if mockup is not None else _named_parts(known)
    is_numbered = revision.is_numbered_as_before
    facts = _object(book.fact("mockup"))
    opened = _object(book.fact("opened"))
    sources = _sources(opened)
    name = _text(facts.get("name")) or (sources[0] if sources else Path(book.path).stem)
    triangles = mockup.triangle_count if mockup is not None else sum(part.triangles for part in known)
    about = MockupFacts(name, content or _text(facts.get("hash")), triangles, len(parts))
    names, keys = Names.of(revision), [part.key for part in revision.parts]
    rows = with_changes(book.rows, renaming_changes(book, names))
    kept = keeping.restored(
        Document(mockup=about, absent=tuple(absent)),
        rows,
        book.marks(rows("marks")),
        lambda text, where: loads(text, f"{book.path}: {where}"),
        parts,
        None if is_numbered else _numbering(revision, book.path),
        names,
        keys,
        known,
    )
    document = with_older(kept.document, rows, known, _numbering(revision, book.path), parts)
    document = with_revision(document, revision, parts)
    document = with_check(document, checked_contents(rows), revision.parts)
    answers = {}
    said = list(notes)
    if is_numbered:
        answers = _answers(book, document, len(parts))
    elif document.cards:
        said.append("The parts have other numbers now: details of answers are left out. Ask the questions again.")
    for each in left_patterns(document, Left(book.part_changes(revision).renamed, keys, parts)):
        said.append(f"{each.pattern!r} of a {each.of} does not name {each.part} any more, which was {each.was}.")
    if kept.aside:
        said.append("Removals, measures and questions of parts that are gone are left out.")
    run = run_facts(book)
    return Source(
        Path(book.path).name,
        document,
        parts,
        mockup,
        sources,
        answers,
        [each for each in (loads(row.value, "the history") for row in rows("history")) if isinstance(each, dict)],
        book.part_changes(revision),
        {number: str(change) for number, change in revision.stale.items()},
        tuple(said),
        run,
        PartChanges() if run is None or mockup is None else _since(run, revision.parts),
    )


def of_document(
    document: Document,
    mockup: Mockup,
    answers: Mapping[int, CardAnswer],
    history: Sequence[Mapping[str, Any]] = (),
    run: RunFacts | None = None,
    renamed: Mapping[str, str] = MappingProxyType({}),
) -> Source:
    """The source of a session's document. history, run, renamed: of its project."""
    project = document.project
    stale = {} if project is None else dict(project.stale)
    by_change: dict[str, list[str]] = {name: [] for name in ("changed", "moved", "new")}
    paths = mockup.part_paths
    for part, change in stale.items():
        by_change.setdefault(change, []).append(paths[part])
    changes = PartChanges(
        tuple(by_change["changed"]),
        tuple(by_change["moved"]),
        tuple(by_change["new"]),
        () if project is None else project.gone,
        renamed,
    )
    name = document.mockup.name if document.mockup else "mock-up"
    return Source(
        name if project is None else project.name,
        document,
        mockup.parts,
        mockup,
        tuple(Path(each).name for each in mockup.source.files),
        answers,
        history,
        changes,
        stale,
        run=run,
        since_run=PartChanges() if run is None else _since(run, contents_of(mockup)),
    )


def run_facts(book: Book) -> RunFacts | None:
    """The last run of `feeler maintain` in a project of anybody; None if there is none. Raises `LoadError`."""
    shown = shown_of(book)
    try:
        run: RunFacts | None = None if shown is None else check(shown, RunFacts, "run")
    except FeelerError as error:
        raise LoadError(
            f"{book.path} is damaged: its last run of feeler maintain is not as written ({error!s:.80}); use a copy"
        ) from None
    return run


def _since(run: RunFacts, now: Sequence[PartContent]) -> PartChanges:
    """How parts differ from those of a run. Their names do not matter to it."""
    before = [PartContent(key, each, 0, 0.0, 0.0, 0.0, 0.0, each) for key, each in run["contents"].items()]
    return replace(revised(before, (), now).changes(), renamed={})


def checked_answer(facts: Any, parts: int) -> CardAnswer | None:
    """An answer from a project of anybody; None for anything else. parts: their number."""
    try:
        if not isinstance(facts, dict):
            return None
        answer: CardAnswer = check({key: value for key, value in facts.items() if key != "kind"}, CardAnswer, "answer")
        for way in answer["ways"]:
            for pose in (*way["poses"], *way.get("places", {}).values()):
                motion.checked(pose, "pose")
    except (WorkbenchError, FeelerError, RecursionError):
        return None
    named = [part for way in answer["ways"] for part in way["parts"]]
    elsewhere = [part for way in answer["ways"] for part in way.get("places", {})]
    named += [int(part) if part.isascii() and part.isdecimal() and len(part) < 12 else -1 for part in elsewhere]
    named += [each["part"] for each in answer["blockers"]]
    named += [part for each in answer["reaches"] for part in (each["part"], *each["blockers"]) if part is not None]
    named += task_parts(answer)
    is_whole = all(0 <= part < parts for part in named)
    return answer if is_whole and all(way["poses"] and way["parts"] for way in answer["ways"]) else None


def _answers(book: Book, document: Document, parts: int) -> dict[int, CardAnswer]:
    found = {}
    for card in document.cards:
        kept = book.answer(f"card {card.id}") if card.state == "done" else None
        answer = None if kept is None else checked_answer(kept[0], parts)
        if answer is not None:
            found[card.id] = answer
    return found


def _named_parts(known: Sequence[PartContent]) -> Parts:
    """The parts of a project without its mock-up: names and paths alone."""
    return parts_of_keys([part.key for part in known], [part.triangles for part in known])


def _numbering(revision: Revision, where: str) -> Renumber:
    rows = revision.row_of

    def number(part: int) -> int | None:
        if not 0 <= part < len(rows):
            raise LoadError(f"{where} names part {part}, which it does not have: it is damaged; use a copy")
        return rows[part]

    return number


def _sources(opened: Mapping[str, Any]) -> tuple[str, ...]:
    """The names of the files of the mock-up, without folders: a report is passed on."""
    given = opened.get("sources")
    listed = given[:_SOURCES] if isinstance(given, list) else []
    places = [each[-1] for each in listed if isinstance(each, list) and each]
    return tuple(each.replace("\\", "/").rstrip("/").rpartition("/")[2] for each in places if isinstance(each, str))


def _object(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""
