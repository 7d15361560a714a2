"""`feeler report`: one report of a project, to hand on."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import feeler
from feeler.cli.app import INTERRUPTED, command, fail
from feeler.cli.inputs import AsJson, MockupUnit, Only, Up, Without, read_mockup, warn_of_doubts
from feeler.cli.options import Needs
from feeler.cli.projects import Work, completed, files_of, fitted, named_project, open_named
from feeler.cli.values import Whole
from feeler.errors import MissingFileError, OptionError, WriteError
from feeler.progress import bar
from feeler.words import plural

if TYPE_CHECKING:
    from feeler.project.book import Book
    from feeler.workbench.report.source import Source
    from feeler.workbench.report.values import Media, Report

_ENDINGS = {"html": (".html",), "xlsx": (".xlsx",)}
_FILES = "-files"
"""At the end of the name of the folder beside the page."""
_OWN_FILE = re.compile(r"question-\d+\.glb|sequence\.glb|mock-up\.html")


@command(
    examples="""
feeler report gearbox.feelproj --html report.html
feeler report gearbox.feelproj --html report.html --xlsx report.xlsx --pictures 200
feeler report gearbox.feelproj --html report.html --one-file
feeler report gearbox.feelproj gearbox-2.step --html report.html
feeler report gearbox.feelproj --json
"""
)
def report(
    context: typer.Context,
    project: Annotated[str, typer.Argument(metavar="PROJECT", help="A project (.feelproj).")],
    mockup: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MOCKUP]...",
            help="Its mock-up as it is now: files or folders (several are one mock-up), or sample:NAME. Default: the "
            "one that the project names.",
        ),
    ] = None,
    *,
    html: Annotated[
        Path | None,
        typer.Option(
            help="Write one page with pictures; films and the mock-up are in the folder NAME-files beside it."
        ),
    ] = None,
    xlsx: Annotated[
        Path | None, typer.Option(help="Write a workbook with a sheet for each kind of rows (needs feeler\\[xlsx]).")
    ] = None,
    pictures: Annotated[
        int,
        typer.Option(help="Most findings with a picture, as many requirements and as many ways; the lists have all."),
        Whole(0, 100_000),
        Needs("--html", "--xlsx"),
    ] = 60,
    one_file: Annotated[
        bool,
        typer.Option("--one-file", help="Films inside of the page (up to 24 MB), and no folder beside it."),
        Needs("--html"),
    ] = False,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    as_json: AsJson = False,
) -> None:
    """Makes one report of a project: requirements, findings, questions with their ways, work steps, and maintenance.

    The project is only read: another process may have it open. If the files of its mock-up are not there, the report
    has no pictures. Exit status: 0 fine, 2 bad input. Ctrl-C writes the report with the pictures made so far, and ends
    with 130.
    """
    from feeler.cli import outputs
    from feeler.io.xlsx import xlsx_library
    from feeler.workbench.report.as_json import report_json
    from feeler.workbench.report.content import report_of
    from feeler.workbench.report.media import media_of
    from feeler.workbench.report.values import Media

    given = [project, *(mockup or [])]
    path = named_project(given, None)
    if path is None:
        raise OptionError(f"{project} is no project: give a project (.feelproj), then its mock-up if you want another")
    outputs.check_targets({"html": html, "xlsx": xlsx}, _ENDINGS)
    if xlsx is not None:
        xlsx_library()
    folder = None if html is None or one_file else _folder(html)
    book = open_named(path, read_only=True)
    context.call_on_close(book.close)
    work = Work(files_of(given), None, None, unit, up, without, only)
    source = _source(book, work)
    with bar("reading the project"):
        made = report_of(source)
    media = Media()
    if html is not None or xlsx is not None:
        with bar("drawing") as progress:
            media = media_of(source, made, pictures, progress, has_ways=html is not None)
        if folder is not None and not media.is_partial:
            _add_page(source, made, media)
    written = _write(made, media, html, xlsx, folder)
    if as_json:
        outputs.print_json(report_json(made, written))
    else:
        _print(made, media, written)
    if media.is_partial:
        fail("interrupted: the report has the pictures made so far; its lists are complete")
        raise typer.Exit(INTERRUPTED)


def _source(book: Book, given: Work) -> Source:
    """The project with its mock-up, if that is there."""
    from feeler.cli.outputs import warn
    from feeler.workbench.report.source import of_book
    from feeler.workbench.session.record import digest

    try:
        work = completed(book, given)
    except (MissingFileError, OptionError) as error:
        text = "The files of the mock-up are not there: this report has no pictures and no films."
        warn(f"{str(error).partition(': give the mock-up')[0]}: the report has no pictures; give the mock-up, too")
        return of_book(book, None, notes=[text])
    mockup = read_mockup(work.sources, work.unit, work.up)
    warn_of_doubts(mockup)
    absent = _absent(mockup, fitted(book, work, mockup))
    with bar("comparing parts") as progress:
        return of_book(book, mockup, absent, content=digest(mockup), progress=progress)


def _absent(mockup: feeler.Mockup, work: Work) -> list[int]:
    """The parts that are left out."""
    left_out: set[int] = set()
    if work.only:
        left_out = set(range(mockup.part_count)) - set(mockup.parts.select(work.only).tolist())
    if work.without:
        left_out |= set(mockup.parts.select(work.without).tolist())
    return sorted(left_out)


def _add_page(source: Source, made: Report, media: Media) -> None:
    """Adds the page with the mock-up, which plays the ways."""
    from feeler.workbench.session.report_page import mockup_page

    if source.mockup is None:
        return
    try:
        with bar("packing the mock-up") as progress:
            media.page = mockup_page(source, made, progress)
    except KeyboardInterrupt:
        media.is_partial = True


def _folder(html: Path) -> Path:
    """The folder of the files beside a page. Raises `WriteError` if something else has its name."""
    folder = html.with_name(html.stem + _FILES)
    if os.path.lexists(folder) and not folder.is_dir():
        raise WriteError(f"cannot write {folder}: it is not a folder; move it, or give --one-file")
    return folder


def _write(made: Report, media: Media, html: Path | None, xlsx: Path | None, folder: Path | None) -> dict[str, str]:
    from feeler.atomic import atomic_file
    from feeler.workbench.report.as_html import files_of as films_of
    from feeler.workbench.report.as_html import html_page
    from feeler.workbench.report.as_xlsx import xlsx_bytes

    written: dict[str, str] = {}
    if html is not None:
        if folder is not None:
            written |= _write_files(folder, films_of(media))
        page = html_page(made, media, None if folder is None else folder.name)
        with atomic_file(html, ".html") as file:
            file.write(page)
        written = {"html": str(html), **written}
    if xlsx is not None:
        data = xlsx_bytes(made, media)
        with atomic_file(xlsx, ".xlsx") as file:
            file.write(data)
        written["xlsx"] = str(xlsx)
    return written


def _write_files(folder: Path, files: Mapping[str, bytes]) -> dict[str, str]:
    """Writes the files into the folder, and removes those of an earlier report there."""
    from feeler.atomic import atomic_file

    if folder.is_dir():
        for there in folder.iterdir():
            if _OWN_FILE.fullmatch(there.name) and there.name not in files:
                with contextlib.suppress(OSError):
                    there.unlink()
    if not files:
        return {}
    is_folder_new = not folder.is_dir()
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise WriteError(f"cannot make {folder}: {error.strerror or error}; choose another place") from None
    made: list[Path] = []
    try:
        for name, data in files.items():
            is_new = not (folder / name).exists()
            with atomic_file(folder / name) as file:
                file.write(data)
            if is_new:
                made.append(folder / name)
    except BaseException:
        # Half of the files is nothing to hand on: of a full disk, the room is given back.
        for each in made:
            with contextlib.suppress(OSError):
                each.unlink()
        if is_folder_new:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
    return {"files": str(folder)}


def _print(made: Report, media: Media, written: Mapping[str, str]) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    counts: Sequence[tuple[int, str]] = [
        (len(made.requirements), "requirement"),
        (len(made.findings), "finding"),
        (len(made.questions), "question"),
        (len(made.steps), "work step"),
        (0 if made.maintenance is None else len(made.maintenance.rows), "maintenance row"),
    ]
    said = ", ".join(plural(count, noun) for count, noun in counts if count) or "nothing yet"
    outputs.say(out, f"{made.project}: {said}")
    wrong = sum(row.status == "violated" for row in made.requirements)
    left = sum(row.status in ("new", "active") and not row.is_touching for row in made.findings)
    if wrong:
        outputs.say(out, f"  {plural(wrong, 'requirement')} violated")
    if left:
        outputs.say(out, f"  {plural(left, 'finding')} open")
    if made.stale:
        outputs.say(out, f"  changed since the results: {made.stale}")
    if "html" in written:
        drawn = sum(map(len, media.pictures.values()))
        outputs.say(out, f"  {plural(drawn, 'picture')}, {plural(len(media.films), 'film')}")
    for what in media.left_out[:5]:
        outputs.say(out, f"  left out: {what}")
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")
