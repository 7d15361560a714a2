"""`feeler sight`: how much of bolts, parts or points is seen from where the eyes may be?"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.cli.access import fasteners_among
from feeler.cli.app import FOUND, command
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    MockupFiles,
    MockupUnit,
    Only,
    Threads,
    Triple,
    Up,
    Without,
    indexed,
    read_checked,
)
from feeler.cli.options import Needs
from feeler.cli.values import POSITION, SHARE, Whole, Word
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.words import plural

_SHOWN = 30
_SHOWN_HIDERS = 3
_COLUMNS = ("target", "part", "path", "share", "eye", "eye_x_m", "eye_y_m", "eye_z_m", "hidden_by", "hidden_share")


@command(
    examples="""
feeler sight engine.step --eye 0.4,-0.6,1.2 --targets "*pump*bolt*"
feeler sight engine.glb --from 0.2,-0.8,1.0 --to 0.6,-0.4,1.4 --eyes 64 --require 0.5 --csv seen.csv
feeler sight sample:gearbox:100000 --eye 0.1,0,-0.6 --parts "*oil_filter*" --json
"""
)
def sight(
    mockup: MockupFiles,
    *,
    eye: Annotated[
        list[Triple] | None, typer.Option(help="A place of the eyes. Several are allowed."), POSITION
    ] = None,
    lower: Annotated[
        Triple | None, typer.Option("--from", help="Eyes anywhere in a box: its lower corner."), POSITION
    ] = None,
    upper: Annotated[Triple | None, typer.Option("--to", help="And its upper corner."), POSITION] = None,
    eyes: Annotated[
        int, typer.Option(help="As many eyes in the box, spread evenly."), Whole(1, 10_000), Needs("--from")
    ] = 64,
    targets: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN",
            help="Only fasteners among these parts: a path with all below it, a name, or a pattern. Several are "
            "allowed.",
        ),
    ] = None,
    kind: Annotated[
        str | None, typer.Option(help="Only this kind of fastener."), Word(("bolt", "screw", "nut", "stud"))
    ] = None,
    parts: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Look at whole parts, as --targets names them, not at fasteners."),
    ] = None,
    require: Annotated[
        float | None, typer.Option(help="Required share, 0 to 1: with less, the exit status is 1."), SHARE
    ] = None,
    samples: Annotated[int, typer.Option(help="Points of each target."), Whole(1, 100_000)] = 64,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    threads: Threads = None,
    csv: Annotated[Path | None, typer.Option(help="Write a line for each target.")] = None,
    as_json: AsJson = False,
) -> None:
    """Looks at heads of fasteners, or at parts, from one place or from anywhere in a box.

    A point is seen if no triangle is between it and the eye. Exit status: 0 all are seen, as far as --require asks, or
    at all; 1 one is not; 2 bad input.
    """
    from feeler.cli import outputs

    outputs.check_targets({"csv": csv}, {"csv": (".csv",)}, mockup)
    places = _eyes(eye, lower, upper, eyes)
    if parts and (targets or kind is not None):
        raise OptionError("--parts are the targets: leave out --targets and --kind")
    world = read_checked(mockup, unit, up)
    scene = indexed(world, without, only, threads)
    asked: Any = _parts(world, parts) if parts else fasteners_among(scene, targets, kind)
    start = time.perf_counter()
    with bar(f"looking at {plural(len(asked), 'target')}") as progress:
        found = feeler.sight(scene, asked, places, samples=samples, progress=progress)
    seconds = time.perf_counter() - start
    short = [row for row in found if row.share < require] if require is not None else [r for r in found if not r.share]
    written = {} if csv is None else {"csv": _written(csv, found, places)}
    if as_json:
        rows = [{**row.to_dict(), "eye_m": None if row.eye is None else places[row.eye].tolist()} for row in found]
        outputs.print_json(
            {
                "targets": len(found),
                "not_seen": len(short),
                "require": require,
                "eyes_m": places.tolist(),
                "samples": samples,
                "seconds": seconds,
                "rows": rows,
                "mockup": mesh_facts(world),
                "written": written,
            }
        )
    else:
        _print(found, places, short, require, seconds, written)
    if short:
        raise typer.Exit(FOUND)


def _eyes(eye: list[Triple] | None, lower: Triple | None, upper: Triple | None, count: int) -> npt.NDArray[np.float64]:
    """`(k, 3)`, metres: the eyes given, and those of the box."""
    if (lower is None) != (upper is None):
        raise OptionError("--from and --to are two corners of a box: give both")
    given = [np.asarray(eye, dtype=np.float64).reshape(-1, 3)] if eye else []
    if lower is not None and upper is not None:
        try:
            given.append(feeler.eyes_in(lower, upper, count))
        except OptionError:
            raise OptionError("--from has a number above that of --to: give the lower corner first") from None
    if not given:
        raise OptionError("there are no eyes: give --eye X,Y,Z, or a box by --from X,Y,Z and --to X,Y,Z")
    return np.concatenate(given)


def _parts(world: feeler.Mockup, patterns: list[str]) -> list[int]:
    try:
        return [int(part) for part in world.parts.select(patterns)]
    except OptionError as error:
        raise OptionError(f"--parts: {error} (feeler info --parts lists all)") from None


def _written(path: Path, found: feeler.Sight, eyes: npt.NDArray[np.float64]) -> str:
    from feeler.atomic import atomic_file
    from feeler.io.csv_table import csv_table

    lines = []
    for row in found:
        place = [None] * 3 if row.eye is None else eyes[row.eye].tolist()
        hider, hidden = row.hidden_by[0] if row.hidden_by else ("", None)
        lines.append([row.target, row.part, row.path, row.share, row.eye, *place, hider, hidden])
    with atomic_file(path, ".csv") as file:
        file.write(csv_table(_COLUMNS, lines))
    return str(path)


def _print(
    found: feeler.Sight,
    eyes: npt.NDArray[np.float64],
    short: list[feeler.Seen],
    require: float | None,
    seconds: float,
    written: dict[str, str],
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    verb = "is" if len(found) == 1 else "are"
    wanted = f"{verb} seen" if require is None else f"{verb} seen by {require:.0%} or more"
    line = f"{len(found) - len(short):,} of {plural(len(found), 'target')} {wanted}"
    line += f" from {plural(len(eyes), 'eye')} ({outputs.duration(seconds)})"
    (outputs.print_finding if short else outputs.say)(out, line)
    out.print()
    # What is seen least comes first.
    order = sorted(found, key=lambda row: (row.share, row.target))
    outputs.print_table(
        out,
        "Targets",
        [("target", "left"), ("seen", "right"), ("best eye", "left"), ("hidden by", "left")],
        [(row.path, f"{row.share:.0%}", _place(row, eyes), _hiders(row)) for row in order[:_SHOWN]],
        more=len(found) - _SHOWN,
    )
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")


def _place(row: feeler.Seen, eyes: npt.NDArray[np.float64]) -> str:
    return "none" if row.eye is None else ", ".join(f"{each:.3f}" for each in eyes[row.eye])


def _hiders(row: feeler.Seen) -> str:
    """The parts in front, with their shares."""
    named = [f"{path} {share:.0%}" for path, share in row.hidden_by[:_SHOWN_HIDERS]]
    more = len(row.hidden_by) - _SHOWN_HIDERS
    return "; ".join([*named, *([f"{more:,} more"] if more > 0 else [])])
