"""`feeler verify`: do the clearances that a mock-up must keep hold?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import feeler
from feeler.cli.app import FOUND, command
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
from feeler.progress import bar
from feeler.requirements import Verified
from feeler.words import plural


@command(
    examples="""
feeler verify engine.step --requirements clearances.toml
feeler verify engine.step --requirements clearances.toml --without "*cover*" --json
"""
)
def verify(
    mockup: MockupFiles,
    requirements: Annotated[Path, typer.Option(help="Pairs of parts by patterns, and their least distance (TOML).")],
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Checks clearances that must hold: named pairs of parts, each with its least distance.

    Exit status: 0 all hold, 1 one is violated, 2 bad input.
    """
    from feeler.cli import outputs

    asked = feeler.read_requirements(requirements)
    world = read_checked(mockup, unit, up, chord_tolerance)
    scene = indexed(world, without, only, threads)
    with bar("checking") as progress:
        found = feeler.verify(scene, asked, threads=threads, progress=progress)
    is_violated = not all(found)
    if as_json:
        rows = [each.to_dict() for each in found]
        outputs.print_json({"mockup": mesh_facts(world), "holds": not is_violated, "requirements": rows})
    else:
        out = outputs.console()
        wrong = sum(not each for each in found)
        kept = len(found) - wrong
        hold = "holds" if kept == 1 else "hold"
        outputs.say(out, f"{plural(len(found), 'requirement')}: {wrong:,} violated, {kept:,} {hold}")
        for each in found:
            outputs.say(out, f"  {_line(each)}")
    if is_violated:
        raise typer.Exit(FOUND)


def _line(each: Verified) -> str:
    """A requirement in one line."""
    from feeler.cli.outputs import length

    asked = each.requirement
    if each:
        return f"holds     {asked.name}: at least {length(asked.gap)}"
    one, other = ((path or "").rpartition("/")[2] for path in (each.path_a, each.path_b))
    if each.depth:
        what = f"{one} is {length(each.depth)} deep in {other}"
    elif each.gap:
        what = f"{one} is {length(each.gap)} from {other}"
    else:
        what = f"{one} touches {other}"
    more = f", and {plural(each.pairs - 1, 'pair')} more" if each.pairs > 1 else ""
    return f"violated  {asked.name}: {what}, {length(asked.gap)} required{more}"
