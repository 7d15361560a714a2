"""`feeler verify`: do the clearances that a mock-up must keep hold?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import feeler
from feeler.cli.app import BAD_INPUT, FOUND, command, fail
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    ChordTolerance,
    MockupFiles,
    MockupUnit,
    Only,
    Threads,
    Up,
    Without,
    indexed,
    read_checked,
)
from feeler.cli.projects import Work, completed, files_of, fitted, named_project, open_named
from feeler.errors import LoadError, OptionError
from feeler.progress import Progress, bar
from feeler.requirements import Requirement, Verified
from feeler.words import plural

if TYPE_CHECKING:
    from feeler.project.book import Book


@command(
    examples="""
feeler verify engine.step --requirements clearances.toml
feeler verify engine.step --requirements clearances.toml --without "*cover*" --json
feeler verify engine.feelproj
feeler verify engine-2.step --project engine.feelproj --json
"""
)
def verify(
    context: typer.Context,
    mockup: MockupFiles,
    requirements: Annotated[
        Path | None, typer.Option(help="Pairs of parts by patterns, and their least distance (TOML).")
    ] = None,
    project: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A project (.feelproj): check the requirements that it keeps, unless --requirements has others. It is "
            "only read.",
        ),
    ] = None,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Checks clearances that must hold: named pairs of parts, each with its least distance.

    A project instead of the mock-up, or beside it, has the requirements of the workbench. Alone it stands for the
    mock-up that it names. Its parts are checked where the file has them, also those that were moved in the workbench.

    Exit status: 0 all hold, 1 one is violated, 2 bad input, or one that names no part of the scene.
    """
    from feeler.cli import outputs

    named = named_project(mockup, project)
    if named is None and requirements is None:
        raise OptionError("nothing says what must hold: give --requirements FILE, or a project that has requirements")
    asked = () if requirements is None else feeler.read_requirements(requirements)
    work = Work(files_of(mockup), None, None, unit, up, without, only)
    book: Book | None = None
    if named is not None:
        book = open_named(named, read_only=True)
        context.call_on_close(book.close)
        work = completed(book, work)
    world = read_checked(work.sources, work.unit, work.up, chord_tolerance)
    if book is not None:
        work = fitted(book, work, world)
        asked = asked if requirements is not None else _kept(book, world)
    scene = indexed(world, work.without, work.only, threads)
    with bar("checking") as progress:
        found = [_checked(scene, asked, number, threads, progress) for number in range(len(asked))]
    if as_json:
        rows = [each.to_dict() if isinstance(each, Verified) else _unknown(*each) for each in found]
        outputs.print_json({"mockup": mesh_facts(world), "holds": all(map(_is_kept, found)), "requirements": rows})
    else:
        out = outputs.console()
        unknown = sum(map(_is_unknown, found))
        kept = sum(map(_is_kept, found))
        hold = "holds" if kept == 1 else "hold"
        more = f", {unknown:,} not checked" if unknown else ""
        said = f"{len(found) - kept - unknown:,} violated, {kept:,} {hold}{more}"
        outputs.say(out, f"{plural(len(found), 'requirement')}: {said}")
        for each in found:
            outputs.say(out, f"  {_line(each) if isinstance(each, Verified) else _why(*each)}")
    if lost := [_asked(each).name for each in found if _is_unknown(each)]:
        fail(f"not checked, since parts that they name are missing: {', '.join(map(repr, lost))}")
        raise typer.Exit(BAD_INPUT)
    if not all(map(_is_kept, found)):
        raise typer.Exit(FOUND)


_Checked = Verified | tuple[Requirement, str]
"""An answer, or why there is none."""


def _checked(
    scene: feeler.Scene, asked: Sequence[Requirement], number: int, threads: int | None, progress: Progress
) -> _Checked:
    """The answer to one of the requirements; one that names no part does not keep the others from theirs."""
    progress(number / len(asked), asked[number].name)
    try:
        return feeler.verify(scene, [asked[number]], threads=threads)[0]
    except OptionError as error:
        return asked[number], str(error)


def _asked(each: _Checked) -> Requirement:
    return each.requirement if isinstance(each, Verified) else each[0]


def _is_unknown(each: _Checked) -> bool:
    return not isinstance(each, Verified) or each.status == "unknown"


def _is_kept(each: _Checked) -> bool:
    return isinstance(each, Verified) and bool(each)


def _unknown(asked: Requirement, trouble: str) -> dict[str, object]:
    row = {"name": asked.name, "a": list(asked.a), "b": list(asked.b), "required_gap": asked.gap}
    return {**row, "status": "unknown", "trouble": trouble}


def _why(asked: Requirement, trouble: str) -> str:
    return f"unknown   {asked.name}: {trouble.removeprefix(f'requirement {asked.name!r}, ')}"


def _kept(book: Book, world: feeler.Mockup) -> tuple[Requirement, ...]:
    """The requirements in a project, with the names that parts have now. Raises `LoadError`, `OptionError`."""
    from feeler.workbench.document.requirement_commands import requirements_of
    from feeler.workbench.report.source import of_book

    with bar("comparing parts") as progress:
        kept = of_book(book, world, progress=progress).document.requirements
    if not kept:
        raise OptionError(f"{book.path} has no requirements: add them in the workbench, or give --requirements FILE")
    try:
        return requirements_of(kept)
    except OptionError as error:
        raise LoadError(f"{book.path} is damaged: {error}; use a copy") from None


def _line(each: Verified) -> str:
    """A requirement in one line."""
    from feeler.cli.outputs import length

    asked = each.requirement
    if each:
        return f"holds     {asked.name}: at least {length(asked.gap)}"
    if each.trouble:
        return _why(asked, each.trouble)
    one, other = ((path or "").rpartition("/")[2] for path in (each.path_a, each.path_b))
    if each.depth:
        what = f"{one} is {length(each.depth)} deep in {other}"
    elif each.gap:
        what = f"{one} is {length(each.gap)} from {other}"
    else:
        what = f"{one} touches {other}"
    more = f", and {plural(each.pairs - 1, 'pair')} more" if each.pairs > 1 else ""
    return f"violated  {asked.name}: {what}, {length(asked.gap)} required{more}"
