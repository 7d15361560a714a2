"""`feeler mcp`: answers agents about a mock-up, over the Model Context Protocol."""

from __future__ import annotations

import os
import signal
import sys
from importlib.util import find_spec
from pathlib import PurePath
from typing import Annotated

import typer

import feeler
from feeler.cli.app import INTERRUPTED, command, fail
from feeler.cli.inputs import (
    Choice,
    ChordTolerance,
    MockupFiles,
    MockupUnit,
    Only,
    Threads,
    ToolUnit,
    Up,
    Without,
    read_mockup,
    read_tool,
    warn_of_doubts,
)
from feeler.cli.options import Needs
from feeler.errors import OptionError
from feeler.progress import Progress


@command(
    examples="""
feeler mcp engine.feeler
feeler mcp engine.step --tool wrench.stl --tool hand.stl --tool-unit mm
feeler mcp engine.step --catalogue tools.toml
feeler mcp plant/ --without "*scaffold*"
feeler mcp sample:gearbox:100000 --tool sample:hand
"""
)
def mcp(
    mockup: MockupFiles,
    *,
    tool: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE",
            help="A tool that agents may move: a file, or sample:NAME or sample:NAME:fine. Several are allowed; each "
            "has the name of its file.",
        ),
    ] = None,
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|built-in",
            help="The tools that agents choose from (.toml): see feeler access --write-catalogue. Default: built-in.",
        ),
    ] = None,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    tool_unit: Annotated[ToolUnit, Needs("--tool")] = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    threads: Threads = None,
) -> None:
    """Serves the mock-up to agents and scripts as tools of the Model Context Protocol (MCP), on stdin and stdout.

    The tools answer about collisions, clearance, clashes, removal, access, rays and pictures. They read the files named
    here and no others, and write nothing. Needs the package mcp: pip install "feeler\\[mcp]".

    Exit status: 0 the client closed stdin, or SIGTERM; 2 bad input; 130 interrupted.
    """
    if find_spec("mcp") is None or find_spec("mcp_types") is None:
        raise OptionError('feeler mcp needs the package mcp, 2.3 or later: pip install "feeler[mcp]"')
    from feeler.agent import Opening, Served
    from feeler.agent.protocol import Ended, serve
    from feeler.agent.wire import Wire

    names = _names(tool or [])
    usual = feeler.catalogue(catalogue)

    def open_(progress: Progress) -> Served:
        tools = {name: read_tool(source, tool_unit, up) for name, source in names.items()}
        world = read_mockup(mockup, unit, up, chord_tolerance=chord_tolerance, also=progress)
        warn_of_doubts(world)
        for name, each in tools.items():
            warn_of_doubts(each, name)
        scene = feeler.Scene(world, threads=threads, progress=progress)
        named = [source if source.startswith("sample:") else PurePath(source).name for source in mockup]
        return Served(Choice(None, without, only).scene_of(scene), tools, named, usual)

    wire = Wire()
    code = 0
    try:
        is_over = serve(Opening(open_), wire)
    except Ended as end:
        is_over = False
        if end.signal_number == signal.SIGINT:
            fail("interrupted")
            code = INTERRUPTED
    finally:
        wire.close()
    if not is_over:  # a query that nothing stops, or a client that reads nothing, must not keep the program
        sys.stderr.flush()
        os._exit(code)
    raise typer.Exit(code)


def _names(tools: list[str]) -> dict[str, str]:
    """The tools by name: that of the file, or of the sample, with a number if it is taken."""
    names: dict[str, str] = {}
    for source in tools:
        words = source.removeprefix("sample:")
        stem = words.replace(":", "_") if words != source else PurePath(source).stem
        name = base = stem or "tool"
        number = 1
        while name in names:
            number += 1
            name = f"{base}_{number}"
        names[name] = source
    return names
