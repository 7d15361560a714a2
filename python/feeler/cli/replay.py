"""`feeler replay`: repeats a recorded workbench session, and compares the collisions."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.inputs import (
    AsJson,
    Choice,
    MockupUnit,
    Only,
    Threads,
    ToolUnit,
    Up,
    Without,
    check_unit,
    read_mockup,
    read_tool,
    warn_of_doubts,
)
from feeler.cli.options import Needs
from feeler.progress import bar

if TYPE_CHECKING:
    from feeler.workbench.session.record import Record
    from feeler.workbench.session.replaying import Replayed

_SAMPLE = "sample:gearbox"


@command(
    examples="""
feeler replay way.jsonl engine.step --tool wrench.stl
feeler replay way.jsonl sample:engine:1600000 --tool sample:wrench --json
feeler replay way.jsonl engine.step --without "*cover*"
feeler replay way.jsonl engine.step --tool wrench.stl --page
"""
)
def replay(
    record: Annotated[Path, typer.Argument(metavar="FILE", help="A record of feeler view --record.")],
    mockup: Annotated[
        list[str] | None,
        typer.Argument(metavar="[MOCKUP]...", help="The mock-up of the record; default: sample:gearbox."),
    ] = None,
    *,
    tool: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="The tool of the record: a file, or sample:NAME or sample:NAME:fine."),
    ] = None,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    tool_unit: Annotated[ToolUnit, Needs("--tool")] = None,
    up: Up = None,
    threads: Threads = None,
    page: Annotated[
        bool,
        typer.Option("--page", help="Replay it in the workbench, at the recorded speed, and continue there."),
    ] = False,
    browser: Annotated[
        bool,
        typer.Option("--browser/--no-browser", help="With --page: open the page in the browser."),
        Needs("--page"),
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Replays a workbench record and compares the colliding triangles, to the last one.

    Exit status: 0 they are equal, 1 they differ, 2 bad input, such as another mock-up. With --page it prints the
    address, Ctrl-C ends it, and the status is 0. If parts were left out, give the same --without and --only.
    """
    from feeler.cli import outputs
    from feeler.workbench.session.record import read_record
    from feeler.workbench.session.replaying import replay as go_through

    read = read_record(record)
    world = read_mockup(mockup or [_SAMPLE], unit, up)
    warn_of_doubts(world)
    if tool is not None:
        check_unit("--tool-unit", tool_unit, tool)
    probe = None if tool is None else read_tool(tool, tool_unit, up)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, tool=probe, threads=threads, progress=progress)
    scene = Choice(None, without, only).scene_of(scene)
    if page:
        _show_page(read, mockup or [_SAMPLE], scene, probe, browser, as_json)
        return
    with bar("replaying") as progress:
        found = go_through(read, world, scene, probe, progress)
    if found.is_torn:
        outputs.warn(f"{record}: its last line is cut off, as by a crash, and was skipped")
    if as_json:
        outputs.print_json(_facts(read, found, world))
    else:
        _show(read, found, world)
    if not found:
        raise typer.Exit(FOUND)


def _show_page(
    record: Record, sources: list[str], scene: feeler.Scene, tool: feeler.Tool | None, browser: bool, as_json: bool
) -> None:
    from feeler.cli.view import name_of, open_browser, say_where, wait_for_ctrl_c
    from feeler.workbench.net.server import Server
    from feeler.workbench.session.player import Player
    from feeler.workbench.session.session import Session

    with contextlib.suppress(KeyboardInterrupt), Session() as session:
        Player(record, session, scene.mockup, scene, tool, name=name_of(sources))
        with contextlib.closing(Server(session)) as server:
            server.start()
            say_where(server, False, as_json)
            if browser:
                open_browser(server.url)
            wait_for_ctrl_c()


def _facts(record: Record, found: Replayed, mockup: feeler.Mockup) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "record": str(record.path),
        "made_with": record.header.get("feeler"),
        **asdict(found),
        "touched": [mockup.part_paths[part] for part in found.touched],
        "same": bool(found),
    }


def _show(record: Record, found: Replayed, mockup: feeler.Mockup) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    paths = [mockup.part_paths[part] for part in found.touched]
    outputs.print_facts(
        out,
        [
            ("record", f"{record.path}, made with feeler {record.header.get('feeler')}"),
            ("rounds", f"{found.ticks:,}, {found.hits:,} of them with hits, {found.most_hits:,} triangles at most"),
            ("commands", f"{found.commands:,}"),
            ("touched", ", ".join(paths[:6]) + (f" and {len(paths) - 6} more" if len(paths) > 6 else "") or "nothing"),
        ],
    )
    parted = found.parted
    if parted is None:
        outputs.say(out, "The same to the last triangle.")
        return
    outputs.print_finding(out, f"entry {parted.entry}: {parted.what}")
    for word, ids in (("no longer", parted.missing), ("now", parted.added)):
        if ids:
            outputs.say(out, f"{word}: triangles {', '.join(map(str, ids))}")
