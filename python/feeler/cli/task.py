"""`feeler task`: how parts are taken out: what is undone, with which tools, in which order, and how long it takes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import GRIP_AXES
from feeler.cli.app import FOUND, INTERRUPTED, command, fail
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    Choice,
    MockupFilesOrNone,
    MockupUnit,
    Only,
    Threads,
    ToolUnit,
    Up,
    Without,
    indexed,
    needed,
    read_checked,
    read_tool,
)
from feeler.cli.options import Ends, Needs
from feeler.cli.values import SECONDS, SEED, Whole
from feeler.cli.workers import Dask, Workers, executor_of
from feeler.errors import OptionError
from feeler.io.xlsx import xlsx_library
from feeler.progress import bar
from feeler.tasks.planning import MOST_PEOPLE
from feeler.tasks.steps import clock
from feeler.tasks.times import times_of

_ENDINGS = {"html": (".html",), "xlsx": (".xlsx",), "glb": (".glb",), "write-times": (".toml",)}
_SHOWN_BLOCKERS = 3


@command(
    examples="""
feeler task engine.step --part "*fuel pump*"
feeler task engine.step --part "*fuel pump*" --catalogue built-in --times times.toml --html task.html
feeler task engine.step --part "*fuel pump*" --tool socket.stl --tool key.stl --glb film.glb
feeler task engine.step --part "*generator*" --keep "*casing*" --people 2 --xlsx task.xlsx
feeler task --write-times times.toml
feeler task sample:gearbox:100000 --part gearbox/covers/idler_front/cover --json
"""
)
def task(
    mockup: MockupFilesOrNone = None,
    *,
    part: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN",
            help="The parts to take out: a path with all below it, a name, or a pattern such as '*pump*'. All matches "
            "come out together, with fasteners that join them alone.",
        ),
    ] = None,
    tool: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE",
            help="A tool, as of feeler access: a file, or sample:NAME (repeat for more). The quickest that reaches is "
            "used. Default: reach is not checked.",
        ),
    ] = None,
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Choose the tools from a catalogue (TOML), or built-in, as of feeler access --catalogue.",
        ),
    ] = None,
    grip: Annotated[
        str | None,
        typer.Option(metavar="AXIS", help="The axis of the tools that points out of the joint: x, y, z, -x, -y, -z."),
        Needs("--tool"),
    ] = None,
    times: Annotated[
        Path | None, typer.Option(help="Times of the elements of a step (TOML). Default: figures that are examples.")
    ] = None,
    write_times: Annotated[
        Path | None,
        typer.Option(help="Write a file of times to fill in, with the examples, and end. It must not exist yet."),
        Ends("--times", "--json"),
    ] = None,
    keep: Annotated[
        list[str] | None, typer.Option(metavar="PATTERN", help="Parts that must stay (repeat for more).")
    ] = None,
    people: Annotated[
        int,
        typer.Option(help="How many work at once on steps that do not depend on each other."),
        Whole(1, MOST_PEOPLE),
    ] = 1,
    seconds: Annotated[float, typer.Option(help="Time for the search."), SECONDS] = 600.0,
    seed: Annotated[int, typer.Option(help="Seed of the search for bent ways."), SEED] = 0,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    tool_unit: Annotated[ToolUnit, Needs("--tool")] = None,
    up: Up = None,
    threads: Threads = None,
    workers: Workers = None,
    dask: Dask = None,
    html: Annotated[Path | None, typer.Option(help="Write a page with a Gantt chart and the arithmetic.")] = None,
    xlsx: Annotated[
        Path | None, typer.Option(help="Write the steps, totals and elements as an Excel workbook.")
    ] = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write a film as GLB, ten times as fast as the work: parts leave, tools come.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Finds a quick order to take parts out: fasteners undone, tools, strokes, ways and times.

    Only what stands in the way is touched. The result is the best that was found, with a bound that no plan of this
    model is below. Exit status: 0 they come out, 1 blocked, 2 bad input. Ctrl-C prints the best so far, and ends with
    130.
    """
    from feeler.cli import outputs

    outputs.check_targets(
        {"html": html, "xlsx": xlsx, "glb": glb, "write-times": write_times}, _ENDINGS, [*(mockup or []), times]
    )
    table = times_of(times)
    if write_times is not None:
        table.save(write_times)
        if as_json:
            outputs.print_json({"written": {"times": str(write_times)}})
        else:
            outputs.say(outputs.console(), f"times written to {write_times}")
        return
    mockup = needed(mockup)
    if not part:
        raise OptionError("nothing says what comes out: give --part, such as --part '*fuel pump*'")
    if xlsx is not None:
        xlsx_library()
    tools: Any = _tools(tool, grip, tool_unit, up)
    if catalogue is not None:
        if tools is not None:
            raise OptionError("--tool and --catalogue are both tools: give one")
        tools = feeler.catalogue(catalogue)
    world = read_checked(mockup, unit, up)
    scene = Choice(None, without, only).scene_of(indexed(world, None, None, threads))
    is_interrupted = False
    try:
        with bar("planning") as progress, executor_of(workers, dask) as executor:
            found = feeler.task(
                scene,
                _selected(world, part),
                tools,
                table,
                keep,
                people,
                seconds=seconds,
                seed=seed,
                threads=threads,
                executor=executor,
                progress=progress,
            )
    except feeler.TaskInterrupted as stop:
        found, is_interrupted = stop.task, True
    written = _written(found, world, tools, {"html": html, "xlsx": xlsx, "glb": glb})
    if as_json:
        outputs.print_json({**found.to_dict(), "mockup": mesh_facts(world), "written": written})
    else:
        _print(found, written)
    if is_interrupted:
        fail("interrupted: this is the best so far")
        raise typer.Exit(INTERRUPTED)
    if not found.is_found:
        raise typer.Exit(FOUND)


def _written(found: feeler.Task, world: feeler.Mockup, tools: Any, targets: dict[str, Path | None]) -> dict[str, str]:
    """Writes the requested files; returns their names by kind. There is no film of a task without a plan."""
    written = {}
    for kind, target in targets.items():
        if target is None or (kind == "glb" and not found.is_found):
            continue
        if kind == "glb":
            found.to_glb(target, world, tools)
        elif kind == "html":
            found.to_html(target)
        else:
            found.to_xlsx(target)
        written[kind] = str(target)
    return written


def _selected(world: feeler.Mockup, patterns: list[str]) -> list[int]:
    try:
        return [int(each) for each in world.parts.select(patterns)]
    except OptionError as error:
        raise OptionError(f"--part: {error} (feeler info --parts lists all)") from None


def _tools(files: list[str] | None, grip: str | None, unit: str | None, up: str | None) -> dict[str, Any] | None:
    """Tools by name, with the axis by which they sit."""
    if not files:
        return None
    options = {} if grip is None else {"grip": check_word("--grip", grip, GRIP_AXES)}
    found: dict[str, Any] = {}
    for file in files:
        tool = read_tool(file, unit, up)
        name = tool.name if tool.name and tool.name not in found else f"{tool.name}_{len(found) + 1}"
        found[name] = (tool, options)
    return found


def _print(found: feeler.Task, written: dict[str, str]) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    if found.is_found:
        outputs.say(out, found.said)
    else:
        outputs.print_finding(out, found.said)
    for note in found.notes:
        outputs.say(out, note)
    if found.steps:
        out.print()
        outputs.print_table(
            out,
            "Steps",
            [
                *(("#", "right"), ("step", "left"), ("tool", "left"), ("swing", "right"), ("strokes", "right")),
                *((("who", "right"), ("from", "right")) if found.people > 1 else ()),
                *(("time", "right"), ("spread", "right")),
            ],
            [_line(found, step) for step in found.steps],
        )
        rows = [(name or "by hand", clock(each.mean), clock(each.spread)) for name, each in found.by_tool.items()]
        people = [(f"person {person + 1}", clock(e.mean), clock(e.spread)) for person, e in found.by_person.items()]
        outputs.print_table(
            out, "Totals", [("", "left"), ("time", "right"), ("spread", "right")], rows + people * (found.people > 1)
        )
    elif found.blocked:
        out.print()
        outputs.print_table(
            out,
            "Blocked",
            [("part", "left"), ("why", "left"), ("in its way", "left")],
            [(each.part, each.because, ", ".join(each.blockers[:_SHOWN_BLOCKERS])) for each in found.blocked],
        )
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")


def _line(found: feeler.Task, step: feeler.TaskStep) -> tuple[str, ...]:
    more = len(step.paths) - 1
    name = f"{step.verb} {step.part}" + (f" and {more} more" if more > 0 else "")
    swing = "" if math.isnan(step.swing_deg) or not step.tool else f"{step.swing_deg:.0f}°"
    strokes = str(step.strokes) if step.strokes else ""
    who = (str(step.person + 1), clock(step.start)) if found.people > 1 else ()
    return (str(step.number + 1), name, step.tool, swing, strokes, *who, clock(step.seconds), clock(step.spread))
