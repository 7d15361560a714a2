"""`feeler opening`: what goes through at a place along an axis, and whether a hand does."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    ChordTolerance,
    MockupFilesOrNone,
    MockupUnit,
    Only,
    Threads,
    Triple,
    Up,
    Without,
    indexed,
    needed,
    read_checked,
)
from feeler.cli.options import Ends
from feeler.cli.values import DIRECTION, POSITION, POSITIVE_LENGTH, Number
from feeler.errors import OptionError


@command(
    examples="""
feeler opening engine.step --at 0.42,-0.1,0.3 --axis 0,0,1
feeler opening engine.step --at 0.42,-0.1,0.3 --axis 0,0,1 --centre --limits limits.toml
feeler opening --write-limits limits.toml
"""
)
def opening(
    mockup: MockupFilesOrNone = None,
    *,
    at: Annotated[Triple | None, typer.Option(help="A point in the opening."), POSITION] = None,
    axis: Annotated[Triple | None, typer.Option(help="The direction in which things go through."), DIRECTION] = None,
    aspect: Annotated[float, typer.Option(help="Height by width of the box."), Number(least=0.01, most=100.0)] = 1.0,
    across: Annotated[
        Triple | None, typer.Option(help="The direction of the box's width; default: the best turn."), DIRECTION
    ] = None,
    reach: Annotated[
        float, typer.Option(help="How far things move before and behind the point."), POSITIVE_LENGTH
    ] = 0.05,
    centre: Annotated[
        bool, typer.Option("--centre", help="Move the point to the middle of the opening first.")
    ] = False,
    limits: Annotated[Path | None, typer.Option(help="The least openings, for hands and arms (TOML).")] = None,
    write_limits: Annotated[
        Path | None,
        typer.Option("--write-limits", help="Write a file of limits to be filled in, and stop. It must not exist yet."),
        Ends("--json"),
    ] = None,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Measures an opening: the largest ball, cylinder and box that go through along an axis, within 0.1 mm.

    Exit status: 0 all limits go through, 1 one does not, 2 bad input.
    """
    from feeler.cli import outputs
    from feeler.plan.opening import write_limits_template

    if write_limits is not None:
        outputs.check_targets({"write-limits": write_limits}, {"write-limits": (".toml",)}, mockup or [])
        write_limits_template(write_limits)
        if as_json:
            outputs.print_json({"written": {"limits": str(write_limits)}})
        else:
            outputs.say(outputs.console(), f"limits written to {write_limits}: fill in the numbers of your standard")
        return
    mockup = needed(mockup)
    if at is None or axis is None:
        raise OptionError("give --at X,Y,Z and --axis X,Y,Z")
    wanted = () if limits is None else feeler.opening_limits(limits)
    world = read_checked(mockup, unit, up, chord_tolerance)
    scene = indexed(world, without, only, threads)
    found = feeler.opening(scene, at, axis, aspect=aspect, across=across, reach=reach, centre=centre, limits=wanted)
    if as_json:
        outputs.print_json({"mockup": mesh_facts(world), **found.to_dict()})
    else:
        _print(found)
    if not all(fit.is_through for fit in found.fits):
        raise typer.Exit(FOUND)


def _print(found: feeler.Opening) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    stops = dict(found.stopped_by)
    sizes = {
        "ball": _size(found.ball),
        "cylinder": _size(found.cylinder),
        "box": _size(found.width) if math.isinf(found.width) else f"{_size(found.width)} x {_size(found.height)}",
    }
    outputs.print_table(
        out,
        "The largest that goes through",
        [("shape", "left"), ("size", "right"), ("stopped by", "left")],
        [(name, size, stops.get(name, "")) for name, size in sizes.items()],
    )
    if found.fits:
        outputs.print_table(
            out,
            "Limits",
            [("limit", "left"), ("goes through", "left"), ("needs", "right"), ("largest", "right"), ("source", "left")],
            [
                (
                    fit.limit.name,
                    "yes" if fit.is_through else "no",
                    _size(fit.limit.width),
                    _size(fit.largest),
                    fit.limit.source,
                )
                for fit in found.fits
            ],
        )


def _size(metres: float) -> str:
    return "over 1 m" if math.isinf(metres) else f"{1e3 * metres:.1f} mm"
