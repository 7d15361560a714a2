"""`feeler maintain`: how long each of a list of parts takes to take out, and what changed since the last run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

import feeler
from feeler.arguments import check_word, near
from feeler.choices import GRIP_AXES, MAINTAIN_FAULTS, MaintainFault
from feeler.cli.app import FOUND, INTERRUPTED, command
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    Choice,
    MockupFiles,
    MockupUnit,
    Only,
    Threads,
    ToolUnit,
    Triple,
    Up,
    Without,
    indexed,
    read_checked,
    read_tool,
)
from feeler.cli.options import Needs
from feeler.cli.projects import Work, files_of, fitted, named_project, open_for_writing, take_mockup
from feeler.cli.values import POSITION, SECONDS, SEED
from feeler.cli.workers import Dask, Workers, executor_of
from feeler.errors import OptionError
from feeler.io.xlsx import xlsx_library
from feeler.progress import bar
from feeler.tasks.run_files import renamed_from
from feeler.tasks.steps import clock
from feeler.words import plural

if TYPE_CHECKING:
    from feeler.project.book import Book
    from feeler.project.parts import PartContent

_ENDINGS = {"html": (".html",), "xlsx": (".xlsx",), "save": (".json",)}
_SHOWN = 50
_FAULTS = ", ".join(MAINTAIN_FAULTS)


@command(
    examples="""
feeler maintain engine.feeler --parts lru.csv --tools tools.toml --save last.json --html night.html
feeler maintain engine.feeler --parts lru.csv --tools tools.toml --previous last.json --save last.json --workers 2
feeler maintain engine.step --parts lru.csv --tool socket.stl --fail-on slower,unreachable --xlsx rows.xlsx
feeler maintain engine.step --parts lru.csv --tools tools.toml --project engine.feelproj
feeler maintain engine.feelproj --parts lru.csv --tools tools.toml --fail-on slower
feeler maintain sample:gearbox:100000 --part "*idler_front/cover" --part "*generator/body" --json
"""
)
def maintain(
    context: typer.Context,
    mockup: MockupFiles,
    *,
    parts: Annotated[
        Path | None,
        typer.Option(
            metavar="CSV",
            help="The list: a column part (a path or pattern) and, if needed, keep (a pattern) and people.",
        ),
    ] = None,
    part: Annotated[
        list[str] | None, typer.Option(metavar="PATTERN", help="Instead: a row for this pattern (repeat for more).")
    ] = None,
    tools: Annotated[
        Path | None, typer.Option(help="A catalogue of tools (TOML), or built-in. Default: reach is not checked.")
    ] = None,
    tool: Annotated[
        list[str] | None, typer.Option(metavar="FILE", help="Instead: a tool, as of feeler task (repeat for more).")
    ] = None,
    grip: Annotated[
        str | None,
        typer.Option(metavar="AXIS", help="The axis of the tools that points out of the joint: x, y, z, -x, -y, -z."),
        Needs("--tool"),
    ] = None,
    times: Annotated[
        Path | None, typer.Option(help="Times of the elements of a step (TOML). Default: figures that are examples.")
    ] = None,
    eye: Annotated[
        list[Triple] | None,
        typer.Option(help="A place of the eyes (repeat for more). Default: around each head."),
        POSITION,
    ] = None,
    previous: Annotated[
        Path | None,
        typer.Option(metavar="JSON", help="The last run, of --save: what differs, and rows that nothing bears on."),
    ] = None,
    save: Annotated[Path | None, typer.Option(metavar="JSON", help="Write the run, for --previous.")] = None,
    project: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A project (.feelproj): compare with its last run, and write the run into it; made if it is missing.",
        ),
    ] = None,
    html: Annotated[Path | None, typer.Option(help="Write a page with the rows, changed ones first.")] = None,
    xlsx: Annotated[Path | None, typer.Option(help="Write the rows as an Excel workbook.")] = None,
    fail_on: Annotated[
        str | None,
        typer.Option(
            "--fail-on",
            metavar="WORDS",
            help=f"Exit status 1 if a row is one of these: {_FAULTS}; by commas.",
        ),
    ] = None,
    seconds: Annotated[float, typer.Option(help="Time for the search of each row."), SECONDS] = 600.0,
    seed: Annotated[int, typer.Option(help="Seed of the search for bent ways."), SEED] = 0,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    tool_unit: Annotated[ToolUnit, Needs("--tool")] = None,
    up: Up = None,
    threads: Threads = None,
    workers: Workers = None,
    dask: Dask = None,
    as_json: AsJson = False,
) -> None:
    """Plans each of a list of parts as feeler task does, and compares with the last run.

    A row is kept from the last run if no part that changed was or is where its search looked; others ask again only
    where parts changed. --save writes FILE.json, and what was asked beside it, FILE.json.answers. A project keeps both;
    instead of the mock-up, it stands for the mock-up that it names. Ctrl-C writes the rows that are done; the next run
    goes on with them. Exit status: 0 fine, 1 rows that match --fail-on, 2 bad input.
    """
    from feeler.cli import outputs

    named = named_project(mockup, project)
    if named is not None and previous is not None:
        raise OptionError("--project has the last run: leave out --previous")
    targets = {"html": html, "xlsx": xlsx, "save": save}
    in_place = ["previous"]
    outputs.check_targets(targets, _ENDINGS, mockup, in_place)
    words = _words(fail_on)
    if parts is not None and part:
        raise OptionError("--parts and --part both say which parts: give one of them")
    if parts is None and not part:
        raise OptionError("nothing says which parts: give a list, --parts FILE.csv, or --part PATTERN")
    if tools is not None and tool:
        raise OptionError("--tools has all tools: leave out --tool")
    if xlsx is not None:
        xlsx_library()
    before = None if previous is None else feeler.load_maintenance(previous)
    table = None if times is None else feeler.Times.load(times)
    work = Work(files_of(mockup), None, None, unit, up, without, only)
    book: Book | None = None
    if named is not None:
        from feeler.cli.kept_runs import last_run

        book, work = open_for_writing(context, named, work)
        outputs.check_targets(targets, _ENDINGS, work.sources, in_place)
        before = last_run(book)
    held = feeler.catalogue(str(tools)) if tools is not None else _tools(tool, grip, tool_unit, work.up)
    world = read_checked(work.sources, work.unit, work.up)
    contents: tuple[PartContent, ...] = ()
    if book is not None:
        work = fitted(book, work, world)
        contents = take_mockup(book, world, work)
    scene = Choice(None, work.without, work.only).scene_of(indexed(world, None, None, threads))
    listed: Any = part if parts is None else Path(parts)
    options: dict[str, Any] = {
        "tools": held,
        "times": table,
        "previous": before,
        "eyes": np.asarray(eye, dtype=np.float64).reshape(-1, 3) if eye else None,
        "seconds": seconds,
        "seed": seed,
        "threads": threads,
    }
    try:
        with bar("planning") as progress, executor_of(workers, dask) as executor:
            run = feeler.maintain(scene, listed, **options, executor=executor, progress=progress)
    except feeler.MaintenanceInterrupted as stop:
        run = stop.maintenance
        if not len(run):
            raise KeyboardInterrupt from None
    except OptionError as error:
        if book is None:
            raise
        said = str(error).replace("previous is a run", f"the last run in {book.path} is one")
        raise OptionError(said.replace("give the last run of this mock-up, or none", "use another project")) from None
    hints = [*run.hints]
    try:
        if book is not None:
            from feeler.cli.kept_runs import keep_run

            hints += keep_run(book, run, contents)
    finally:  # what cannot be written into the project is in the files, at least
        written = _written(run, targets)
    if book is not None:
        written["project"] = book.path
    failing = {word: [row.name for row in run.failing(word)] for word in words}
    for hint in hints:
        outputs.warn(hint)
    if as_json:
        rows = [row.to_dict() for row in run]
        changes = [each.to_dict() for each in run.changes]
        facts = {"said": run.said, "is_partial": run.is_partial, "rows": rows, "changes": changes, "failing": failing}
        facts["renamed"] = run.renamed
        outputs.print_json({**facts, "mockup": mesh_facts(world), "written": written})
    else:
        _print(run, failing, written)
    if run.is_partial:
        raise typer.Exit(INTERRUPTED)
    if any(failing.values()):
        raise typer.Exit(FOUND)


def _words(fail_on: str | None) -> list[MaintainFault]:
    if fail_on is None:
        return []
    words: list[MaintainFault] = []
    for word in dict.fromkeys(word.strip().lower() for word in fail_on.split(",")):
        if word not in MAINTAIN_FAULTS:
            raise OptionError(f"--fail-on has {word!r}: {near(word, MAINTAIN_FAULTS)}")
        words.append(word)
    return words


def _tools(files: list[str] | None, grip: str | None, unit: str | None, up: str | None) -> dict[str, Any] | None:
    """Tools by name, with the axis by which they sit."""
    if not files:
        return None
    options = {} if grip is None else {"grip": check_word("--grip", grip, GRIP_AXES)}
    found: dict[str, Any] = {}
    for file in files:
        tool = read_tool(file, unit, up)
        found[tool.name if tool.name and tool.name not in found else f"{tool.name}_{len(found) + 1}"] = (tool, options)
    return found


def _written(run: feeler.Maintenance, targets: dict[str, Path | None]) -> dict[str, str]:
    written = {}
    for kind, target in targets.items():
        if target is not None:
            {"save": run.save, "html": run.to_html, "xlsx": run.to_xlsx}[kind](target)
            written[kind] = str(target)
    return written


def _print(run: feeler.Maintenance, failing: Mapping[MaintainFault, list[str]], written: dict[str, str]) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    outputs.say(out, run.said)
    for word, names in failing.items():
        if names:
            more = f" and {len(names) - 3:,} more" if len(names) > 3 else ""
            outputs.print_finding(out, f"{word}: {plural(len(names), 'row')}: {', '.join(names[:3])}{more}")
    out.print()
    heads = [("part", "left"), ("state", "left"), ("time", "right"), ("spread", "right"), ("tools", "left")]
    heads += [("reach", "right"), ("sight", "right"), ("change", "left")]
    rows = run.by_change
    outputs.print_table(out, "Parts", heads, [_line(row) for row in rows[:_SHOWN]], more=len(rows) - _SHOWN)
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}" if kind != "save" else f"run written to {target}")


def _line(row: feeler.MaintainRow) -> tuple[str, ...]:
    is_known = not math.isnan(row.seconds)
    spread = clock(row.high - row.seconds) if is_known else ""
    reach = "" if math.isnan(row.reach_deg) else f"{row.reach_deg:.0f}°"
    seen = "" if math.isnan(row.sight) else f"{row.sight:.0%}"
    said = row.change or row.error or ("" if row.state == "out" else row.said)
    time = clock(row.seconds) if is_known else ""
    said = "; ".join(each for each in (said, renamed_from(row)) if each)
    return (row.name, row.state, time, spread, ", ".join(row.tools), reach, seen, said)
