"""Projects on the command line: finds the project that the user named, and the mock-up and tool that it names."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import feeler
from feeler.errors import LoadError, MissingFileError, OptionError, ProjectError

if TYPE_CHECKING:
    from feeler.project.book import Book
    from feeler.project.parts import PartContent

_SUFFIX = ".feelproj"
_SAMPLE = "sample:"
_MOST_SOURCES = 10_000
_NO_TOOL = "sample:wrench"
"""For commands without the tool of the project: that may be gone."""

ProjectFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Save the work in this project (.feelproj), and go on with it; it is made if it is missing.",
    ),
]


@dataclass(frozen=True)
class Work:
    """What a project is opened with: files or a sample, the tool, and the options of both."""

    sources: list[str]
    tool: str | None = None
    tool_unit: str | None = None
    unit: str | None = None
    up: str | None = None
    without: list[str] | None = None
    only: list[str] | None = None


def named_project(mockup: list[str] | None, option: Path | None, read_only: bool = False) -> Path | None:
    """The project of --project, or among the files. Raises `OptionError` for more than one."""
    named = [Path(each) for each in mockup or [] if _is_project(each)]
    for path in named:
        if not os.path.lexists(path):
            raise MissingFileError(f"{path} does not exist: to make a project, give feeler view MOCKUP --project FILE")
    named += [option] if option is not None else []
    if len(named) > 1:
        raise OptionError(f"{' and '.join(map(str, named))}: give one project")
    if read_only and not named:
        raise OptionError("--read-only is for a project: give --project FILE")
    return named[0] if named else None


def files_of(mockup: list[str] | None) -> list[str]:
    """The files without a project among them."""
    return [each for each in mockup or [] if not _is_project(each)]


def _is_project(source: str) -> bool:
    return not source.startswith(_SAMPLE) and Path(source).suffix.lower() == _SUFFIX


def open_named(path: Path, read_only: bool = False, *, can_read_only: bool = True) -> Book:
    """Opens the project, or makes it. Raises its errors, with the options to use.

    can_read_only: whether the command has --read-only.
    """
    from feeler.project.book import open_or_make

    try:
        return open_or_make(path, read_only=read_only)
    except ProjectError as error:
        offer = ", or open it read-only"
        said = str(error).replace(" (--read-only, read_only=True)", " with --read-only")
        raise ProjectError(said if can_read_only else said.partition(offer)[0]) from None


def work_of(project: Book, given: Work) -> Work:
    """What a project was opened with last, for one that is opened without a mock-up; given options come first.

    Raises `OptionError` if it names no mock-up, `MissingFileError` if that is gone, and `LoadError`.
    """
    known = project.fact("opened")
    if known is None:
        raise OptionError(
            f"{project.path} does not say where its mock-up is: give the mock-up, too, and --project FILE"
        )
    try:
        if not isinstance(known, dict) or not 0 < len(known["sources"]) < _MOST_SOURCES:
            raise ValueError
        sources = [_found(project, each) for each in known["sources"]]
        tool = given.tool or (None if known["tool"] is None else _found(project, known["tool"]))
        words = {name: known[name] for name in ("tool_unit", "unit", "up")}
        patterns = {name: known[name] for name in ("without", "only")}
        if not all(value is None or isinstance(value, str) for value in words.values()):
            raise ValueError
        if not all(isinstance(each, str) for value in patterns.values() for each in value):
            raise ValueError
    except MissingFileError:
        raise
    except (ValueError, TypeError, KeyError):
        raise LoadError(f"{project.path} is damaged: its mock-up is not as written; give the mock-up, too") from None
    if given.tool is not None:
        words["tool_unit"] = None
    mine = {each.name: getattr(given, each.name) for each in fields(Work) if each.name in {*words, *patterns}}
    chosen = {**words, **patterns, **{name: value for name, value in mine.items() if value}}
    return replace(Work(sources, tool), **chosen)


def open_for_writing(context: typer.Context, path: Path, given: Work) -> tuple[Book, Work]:
    """The project, which is closed at the end of the command, with the given files, or the mock-up that it names.

    Raises the errors of `open_named` and `work_of`.
    """
    book = open_named(path, can_read_only=False)
    context.call_on_close(book.close)
    return book, given if given.sources else mockup_of(book, given)


def mockup_of(project: Book, given: Work) -> Work:
    """As `work_of`, without the tool."""
    return replace(work_of(project, replace(given, tool=_NO_TOOL)), tool=None)


def with_options(project: Book, given: Work) -> Work:
    """The given files with the options that the project was opened with; without files, the mock-up that it names."""
    if not given.sources:
        return mockup_of(project, given)
    try:
        known = mockup_of(project, given)
    except (MissingFileError, OptionError, LoadError):
        return given
    return replace(known, sources=given.sources)


def tool_of(project: Book) -> tuple[str | None, str | None]:
    """The tool that a project was opened with last, and its unit; None if it is not there."""
    known = project.fact("opened")
    try:
        return _found(project, known["tool"]), None if known["tool_unit"] is None else str(known["tool_unit"])
    except (ValueError, TypeError, KeyError, MissingFileError):
        return None, None


def keep_work(project: Book, work: Work) -> None:
    """Writes into a project which files and options it was opened with. Paths are kept relative to it, and absolute."""
    from feeler.project.book import dumps
    from feeler.project.store import put

    facts = _facts(project, work)
    if project.fact("opened") != facts:
        project.write([put("facts", "opened", 0, dumps(facts))])


def _facts(project: Book, work: Work) -> dict[str, Any]:
    facts: dict[str, Any] = asdict(work)
    facts["sources"] = [_place(project, each) for each in work.sources]
    facts["tool"] = None if work.tool is None else _place(project, work.tool)
    return {**facts, "without": work.without or [], "only": work.only or []}


def _names_same(known: Any, places: list[list[str]]) -> bool:
    """Whether a project names these files already, by the path from its folder or by the absolute one."""
    sources = known.get("sources") if isinstance(known, dict) else None
    return (
        isinstance(sources, list)
        and len(sources) == len(places)
        and all(
            isinstance(one, list) and any(each in one for each in other)
            for one, other in zip(sources, places, strict=True)
        )
    )


def take_mockup(project: Book, mockup: feeler.Mockup, work: Work) -> tuple[PartContent, ...]:
    """Makes a new project one of a mock-up, and returns its parts. Raises `LoadError` for a project of another one."""
    from feeler.project.book import CHECK, dumps
    from feeler.project.parts import contents_of, rows_of
    from feeler.project.renaming import Names, renaming_changes
    from feeler.project.store import put

    if project.parts():
        revision = project.revision(mockup)
        parts = revision.parts
        if "shapes" not in (project.fact(CHECK) or ()):
            # Findings of the workbench, without the shapes that a check compares: the project knows its parts.
            project.write(renaming_changes(project, Names.of(revision)))
    else:
        parts = contents_of(mockup)
        project.write(rows_of(parts))
    known = project.fact("opened")
    if known is None:
        keep_work(project, work)
    elif not _names_same(known, [_place(project, each) for each in work.sources]):
        # Another revision: the project names it from now on. Its tool stays.
        kept = known if isinstance(known, dict) else {}
        facts = {**_facts(project, work), **{name: kept.get(name) for name in ("tool", "tool_unit")}}
        project.write([put("facts", "opened", 0, dumps(facts))])
    return parts


def _place(project: Book, source: str) -> list[str]:
    if source.startswith(_SAMPLE):
        return [source]
    absolute = os.path.abspath(source)
    try:
        near = os.path.relpath(absolute, os.path.dirname(os.path.abspath(project.path)))
    except ValueError:  # another drive of Windows
        return [absolute]
    return [near.replace(os.sep, "/"), absolute]


def _found(project: Book, place: Any) -> str:
    """A file that a project names. It may be of a stranger: only files and folders of this machine are opened."""
    if not isinstance(place, list) or not 0 < len(place) < 3 or not all(isinstance(each, str) for each in place):
        raise ValueError
    if place[0].startswith(_SAMPLE):
        return str(place[0])
    folder = os.path.dirname(os.path.abspath(project.path))
    for each in place:
        if "\0" in each or len(each) > 4096 or each.startswith(("//", "\\\\")):
            continue  # a name of another machine: Windows would tell it who asks
        path = os.path.normpath(os.path.join(folder, each))
        if os.path.isfile(path) or os.path.isdir(path):
            return path
    raise MissingFileError(
        f"{project.path} names {place[-1][:200]!r}, which is not there: give the mock-up or the tool, too, as in "
        "feeler view MOCKUP --project FILE"
    )
