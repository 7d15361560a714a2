"""Projects on the command line: finds the project that the user named, and the mock-up and tool that it names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import typer

import feeler
from feeler.errors import LoadError, MissingFileError, OptionError, ProjectError
from feeler.io.load import is_saved

if TYPE_CHECKING:
    from feeler.project.book import Book
    from feeler.project.parts import PartContent

_SUFFIX = ".feelproj"
_SAMPLE = "sample:"
_MOST_SOURCES = 10_000
_FACT = "opened"
_WORDS = ("unit", "up")
_PATTERNS = ("without", "only")
_EMPTY: Mapping[str, Any] = MappingProxyType(
    {"sources": [], "tool": None, "tool_unit": None, "unit": None, "up": None, "without": [], "only": []}
)
"""What a project keeps if nothing is given."""

ProjectFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Save the work in this project (.feelproj), and go on with it; it is made if it is missing.",
    ),
]


@dataclass(frozen=True)
class Work:
    """What a project is opened with: files or a sample, the tool, and the options of both; None: not given.

    is_choice_given: `without` or `only` is of this command, not what the project keeps.
    """

    sources: list[str]
    tool: str | None = None
    tool_unit: str | None = None
    unit: str | None = None
    up: str | None = None
    without: list[str] | None = None
    only: list[str] | None = None
    is_choice_given: bool = False


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


def open_for_writing(context: typer.Context, path: Path, given: Work) -> tuple[Book, Work]:
    """The project, which is closed at the end of the command, and the work that it completes (`completed`).

    Raises the errors of `open_named` and `completed`.
    """
    book = open_named(path, can_read_only=False)
    context.call_on_close(book.close)
    return book, completed(book, given)


def completed(project: Book, given: Work, *, has_tool: bool = False) -> Work:
    """The work of this command: files and options that are not given are those that the project was opened with last.

    has_tool: the tool, too; beside files that are given it may be gone.
    Raises `OptionError` if there is no mock-up, `MissingFileError` if that of the project is gone, and `LoadError`.
    """
    known = project.fact(_FACT)
    if not given.sources and (known is None or (isinstance(known, dict) and known.get("sources") == [])):
        raise OptionError(
            f"{project.path} does not say where its mock-up is: give the mock-up, too, and --project FILE"
        )
    tool, its_unit = given.tool, given.tool_unit
    try:
        sources = given.sources or _sources_of(project, known)
        if has_tool and tool is None:
            tool, kept_unit = _tool_of(project, known, may_be_gone=bool(given.sources))
            its_unit = its_unit or kept_unit
        kept = _options_of(known)
    except MissingFileError:
        raise
    except (ValueError, TypeError, KeyError):
        if not given.sources:
            raise LoadError(
                f"{project.path} is damaged: its mock-up is not as written; give the mock-up, too"
            ) from None
        kept, sources = {}, given.sources
    if sources[0].startswith(_SAMPLE) or is_saved(sources):
        kept |= dict.fromkeys(_WORDS)  # these are as they were made
    if given.without or given.only:
        kept |= {name: [] for name in _PATTERNS}  # the choice of parts is one
        kept["is_choice_given"] = True
    return replace(Work(sources, tool, its_unit), **(kept | _given_options(given)))


def fitted(project: Book, work: Work, mockup: feeler.Mockup) -> Work:
    """With the patterns that the project keeps as its parts are called in this mock-up.

    Raises `OptionError` if one of them names no part any more.
    """
    from feeler.project.renaming import Names, named_parts

    try:
        kept = _options_of(project.fact(_FACT))
    except (ValueError, TypeError, KeyError):
        return work
    names: Names | None = None
    fits: dict[str, Any] = {}
    for option in _PATTERNS:
        patterns = getattr(work, option)
        if not patterns or patterns != kept.get(option):
            continue
        for pattern in patterns:
            here = pattern
            if not named_parts(pattern, mockup.parts):
                names = names or (Names.of(project.revision(mockup)) if project.parts() else Names())
                here = names.pattern(pattern, mockup.parts)
            if not named_parts(here, mockup.parts):
                raise OptionError(
                    f"{project.path} keeps --{option} {pattern!r}, which names no part of this mock-up: give "
                    f'--{option} again, or --only "*" for all parts'
                )
            fits.setdefault(option, []).append(here)
    return replace(work, **fits)


def keep_work(project: Book, work: Work) -> None:
    """Writes into a project which files, tool and options it was opened with.

    Paths are kept relative to it, and absolute. Options that are not given stay as they are.
    """
    _keep(project, _facts(project, work))


def unplaced(work: Work) -> dict[str, Any]:
    """What a project keeps of the options, which names no file: for one that is downloaded."""
    return {**_EMPTY, **_given_options(work)}


def _keep(project: Book, facts: dict[str, Any]) -> None:
    from feeler.project.book import dumps
    from feeler.project.store import put

    if project.fact(_FACT) != facts:
        project.write([put("facts", _FACT, 0, dumps(facts))])


def _facts(project: Book, work: Work) -> dict[str, Any]:
    try:
        kept = _options_of(project.fact(_FACT))
    except (ValueError, TypeError, KeyError):
        kept = {}
    facts = {**_EMPTY, **kept, **_given_options(work), "sources": [_place(project, each) for each in work.sources]}
    return {**facts, "tool": None if work.tool is None else _place(project, work.tool), "tool_unit": work.tool_unit}


def _given_options(work: Work) -> dict[str, Any]:
    """The options of the mock-up that are given."""
    return {name: value for name in (*_WORDS, *_PATTERNS) if (value := getattr(work, name)) is not None}


def _options_of(known: Any) -> dict[str, Any]:
    """The options that a project keeps. Raises `ValueError`, `TypeError`, `KeyError` if it is damaged."""
    if known is None:
        return {}
    words = {name: known[name] for name in _WORDS}
    patterns = {name: list(known[name]) for name in _PATTERNS}
    if not all(value is None or isinstance(value, str) for value in words.values()):
        raise ValueError
    if not all(isinstance(each, str) for value in patterns.values() for each in value):
        raise ValueError
    return {**words, **patterns}


def _sources_of(project: Book, known: Any) -> list[str]:
    if not isinstance(known, dict) or not 0 < len(known["sources"]) < _MOST_SOURCES:
        raise ValueError
    return [_found(project, each) for each in known["sources"]]


def _tool_of(project: Book, known: Any, *, may_be_gone: bool) -> tuple[str | None, str | None]:
    """The tool that a project was opened with last, and its unit; None if it has none."""
    if known is None or known["tool"] is None:
        return None, None
    try:
        tool = _found(project, known["tool"])
    except MissingFileError:
        if may_be_gone:
            return None, None
        raise
    unit = known["tool_unit"]
    if unit is not None and not isinstance(unit, str):
        raise ValueError
    return tool, unit


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
    from feeler.project.book import CHECK
    from feeler.project.parts import contents_of, rows_of
    from feeler.project.renaming import Names, renaming_changes

    if project.parts():
        revision = project.revision(mockup)
        parts = revision.parts
        if "shapes" not in (project.fact(CHECK) or ()):
            # Findings of the workbench, without the shapes that a check compares: the project knows its parts.
            project.write(renaming_changes(project, Names.of(revision)))
    else:
        parts = contents_of(mockup)
        project.write(rows_of(parts))
    known = project.fact(_FACT)
    before = known if isinstance(known, dict) else {}
    facts = _facts(project, work)
    if _names_same(known, facts["sources"]):
        facts["sources"] = before["sources"]
    # Another revision: the project names it from now on. Its tool stays, and the parts that it leaves out: one check of
    # a few parts does not make later ones smaller.
    is_for_once = bool(before) and work.is_choice_given and work.only != ["*"]
    stays = ("tool", "tool_unit", *(_PATTERNS if is_for_once else ()))
    _keep(project, {**facts, **{name: before.get(name) for name in stays}})
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
