"""`feeler access`: can a tool reach the fasteners, and how far can it swing there?"""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import FASTENER_KINDS, GRIP_AXES, GripAxis
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
    Triple,
    Up,
    Without,
    needed,
    read_both,
    read_mockup,
    read_poses,
    read_tool,
)
from feeler.cli.options import Ends, Needs
from feeler.cli.values import ANY_LENGTH, LENGTH, POSITION, POSITIVE_LENGTH, SWING, TURNS, Whole, Word
from feeler.cli.workers import Dask, Workers, executor_of
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.words import plural

_SHOWN = 30
_SHOWN_BLOCKERS = 10
_ENDINGS = {"csv": (".csv",), "glb": (".glb",)}


@command(
    examples="""
feeler access engine.step --tool socket.stl
feeler access engine.step --tool wrench.stl --grip y --targets "*pump*bolt*" --csv bolts.csv --glb bolts.glb
feeler access engine.glb --tool wrench.stl --hand hand.stl --targets "*bolt*" --swing 30 --json
feeler access sample:gearbox:100000 --tool sample:hand --targets "*covers*"
feeler access engine.step --catalogue built-in --targets "*pump*" --clearance 3mm --hand catalogue
feeler access --write-catalogue tools.toml
"""
)
def access(
    mockup: MockupFilesOrNone = None,
    *,
    tool: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="A file, or sample:NAME or sample:NAME:fine. Its z axis points out of the joint."
        ),
    ] = None,
    catalogue: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|built-in", help="Instead of a tool: choose for each fastener the first that fits and reaches."
        ),
    ] = None,
    write_catalogue: Annotated[
        Path | None,
        typer.Option(
            "--write-catalogue",
            help="Write the built-in catalogue, to be changed, and stop. The file must not exist yet.",
        ),
        Ends("--json"),
    ] = None,
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
    frames: Annotated[
        Path | None,
        typer.Option(
            help="Use these targets instead of detected fasteners: world_from_target, metres, z out of the joint; "
            "(n, 4, 4), as --poses of feeler path.",
        ),
    ] = None,
    hand: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="A hand that holds the tool: a file, or sample:NAME, in the tool's frame; with a catalogue in that of "
            "the grip, or catalogue for its own.",
        ),
    ] = None,
    grip: Annotated[
        str | None,
        typer.Option(
            metavar="AXIS|FILE",
            help="How the tool sits: its axis that points out of the joint (x, y, z, -x, -y, -z), or a file with "
            "tool_from_target, (4, 4); y for sample:wrench.",
        ),
    ] = None,
    lift: Annotated[
        float, typer.Option(help="How far the tool sits above the top of the head; negative: below."), ANY_LENGTH
    ] = 0.0,
    swing: Annotated[
        float | None,
        typer.Option(help="Required swing; default 60 degrees, or what each tool of a catalogue needs."),
        SWING,
    ] = None,
    angles: Annotated[
        int, typer.Option(help="Even steps around the axis that are tried first, and counted."), Whole(4, 3600)
    ] = 72,
    approach: Annotated[float, typer.Option(help="Length of the way in."), POSITIVE_LENGTH] = 0.1,
    clearance: Annotated[
        float, typer.Option(help="Room that the hand, the grip or the tool keeps from parts, as for gloves."), LENGTH
    ] = 0.0,
    eye: Annotated[
        list[Triple] | None, typer.Option(help="Where an eye may be (repeat for more): says what it sees."), POSITION
    ] = None,
    turns: Annotated[float, typer.Option(help="Turns of a fastener, for the strokes."), TURNS] = 1.0,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    tool_unit: Annotated[ToolUnit, Needs("--tool", "--hand")] = None,
    up: Up = None,
    threads: Threads = None,
    workers: Workers = None,
    dask: Dask = None,
    csv: Annotated[Path | None, typer.Option(help="Write a line for each target.")] = None,
    glb: Annotated[
        Path | None,
        typer.Option(help="Write the mock-up with the tool at each target as GLB, blockers coloured."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Tries a tool on each fastener: checks for a seat, a large enough swing, and a way in.

    Fasteners are recognised by shape and name; check the list. Swings are never reported larger than they are. Exit
    status: 0 all are reachable, 1 one is not, 2 bad input. Ctrl-C prints the results so far, and ends with 130.
    """
    from feeler.cli import outputs
    from feeler.plan.reach import AccessInterrupted

    wanted = {"csv": csv, "glb": glb}
    if write_catalogue is not None:
        outputs.check_targets({"write-catalogue": write_catalogue}, {"write-catalogue": (".toml",)}, mockup or [])
        _write_catalogue(write_catalogue, as_json)
        return
    mockup = needed(mockup)
    if (tool is None) == (catalogue is None):
        raise OptionError("give either --tool FILE or --catalogue FILE (or --catalogue built-in)")
    outputs.check_targets(wanted, _ENDINGS, mockup)
    if frames is not None and (targets or kind is not None):
        raise OptionError("--frames are the targets: leave out --targets and --kind")
    places = None if frames is None else read_poses(frames)
    grasp = _grip(grip)
    world, probe = _read(mockup, unit, tool, catalogue, hand, tool_unit, up)
    holding = _held(hand, probe, tool_unit, up)
    with bar("indexing") as progress:
        alone = probe if isinstance(probe, feeler.Tool) else None
        scene = feeler.Scene(world, tool=alone, threads=threads, progress=progress)
    scene = Choice(None, without, only).scene_of(scene)
    asked: feeler.Fasteners | npt.NDArray[np.float64]
    asked = fasteners_among(scene, targets, kind) if places is None else places
    start = time.perf_counter()
    is_interrupted = False
    try:
        with bar(f"reaching {plural(len(asked), 'target')}") as progress, executor_of(workers, dask) as executor:
            found = feeler.access(
                scene,
                probe,
                asked,
                swing,
                angles,
                holding,
                approach,
                grip=grasp,
                lift=lift,
                clearance=clearance,
                eyes=eye or None,
                turns=turns,
                threads=threads,
                executor=executor,
                progress=progress,
            )
    except AccessInterrupted as stop:
        found, is_interrupted = stop.access, True
    seconds = time.perf_counter() - start
    rows = _rows(asked, found)
    written = _write(world, probe, holding, found, rows, wanted)
    if as_json:
        outputs.print_json(
            {
                "reachable": int(found.is_reachable.sum()),
                "targets": len(asked),
                "partial": found.is_partial,
                "swing_deg": 60.0 if swing is None and catalogue is None else swing,
                "angles": angles,
                "approach_m": approach,
                "seconds": seconds,
                "rows": rows,
                "blockers": _blockers(found.blockers),
                "mockup": mesh_facts(world),
                "tool": mesh_facts(probe) if isinstance(probe, feeler.Tool) else None,
                "catalogue": catalogue,
                "tools": found.tools,
                "written": written,
            }
        )
    else:
        _print(found, rows, len(asked), approach, seconds, written)
    if is_interrupted:
        fail("interrupted: these are the results so far")
        raise typer.Exit(INTERRUPTED)
    if not found.is_reachable.all():
        raise typer.Exit(FOUND)


def _write_catalogue(path: Path, as_json: bool) -> None:
    """Writes the built-in catalogue."""
    from feeler.atomic import atomic_file
    from feeler.cli import outputs
    from feeler.plan.catalogue import built_in_text

    with atomic_file(path, ".toml") as file:
        file.write(built_in_text().encode())
    if as_json:
        outputs.print_json({"written": {"catalogue": str(path)}})
    else:
        outputs.say(outputs.console(), f"catalogue written to {path}")


def _read(
    mockup: list[str],
    unit: str | None,
    tool: str | None,
    catalogue: str | None,
    hand: str | None,
    tool_unit: str | None,
    up: str | None,
) -> tuple[feeler.Mockup, feeler.Tool | feeler.Catalogue]:
    """The mock-up, and the tool or tools."""
    if catalogue is None:
        return read_both(mockup, unit, tool, tool_unit, up, hand=hand)
    tools = feeler.catalogue(catalogue)
    return read_mockup(mockup, unit, up), tools


def _held(
    hand: str | None, probe: feeler.Tool | feeler.Catalogue, tool_unit: str | None, up: str | None
) -> feeler.Tool | None:
    """The hand."""
    if hand != "catalogue":
        return None if hand is None else read_tool(hand, tool_unit, up)
    if isinstance(probe, feeler.Tool) or probe.hand is None:
        raise OptionError("--hand catalogue needs a --catalogue with a [hand]")
    return probe.hand


def _grip(text: str | None) -> GripAxis | npt.NDArray[np.float64] | None:
    if text is None:
        return None
    for axis in GRIP_AXES:
        if text == axis:
            return axis
    if not os.path.isfile(text):
        raise OptionError(f"--grip is {text!r}: give one of {', '.join(GRIP_AXES)}, or a file with a (4, 4) matrix")
    poses = read_poses(Path(text))
    if len(poses) != 1:
        raise OptionError(f"--grip {text}: one matrix is needed, not {len(poses)}")
    matrix: npt.NDArray[np.float64] = poses[0]
    return matrix


def fasteners_among(scene: feeler.Scene, patterns: list[str] | None, kind: str | None) -> feeler.Fasteners:
    """The selected fasteners."""
    try:
        parts = None if not patterns else scene.mockup.parts.select(patterns)
    except OptionError as error:
        raise OptionError(f"--targets: {error} (feeler info --parts lists all)") from None
    with bar("looking for fasteners") as progress:
        found = feeler.find_fasteners(scene, parts, progress=progress)
    chosen = found if kind is None else found.where(kind=check_word("--kind", kind, FASTENER_KINDS))
    if not len(chosen):
        among = "of the mock-up" if parts is None else f"of the {len(parts):,} that --targets names"
        what = "fastener" if kind is None else kind
        others = repr(found).removeprefix("Fasteners(").removesuffix(")")
        raise OptionError(f"no part {among} looks like a {what}: feeler found {others}; or give --frames FILE")
    return chosen


def _rows(asked: feeler.Fasteners | npt.NDArray[np.float64], found: feeler.Access) -> list[dict[str, Any]]:
    """One entry per target."""
    rows = []
    for reach in found:
        row: dict[str, Any] = {"target": reach.target, "part": reach.part, "path": reach.path}
        if isinstance(asked, feeler.Fasteners):
            fastener = asked[reach.target]
            row |= {
                "kind": fastener.kind,
                "size_m": fastener.size,
                "across_flats_m": fastener.across_flats,
                "drive": fastener.drive,
                "width_m": fastener.width,
                "confidence": fastener.confidence,
                "fastener_because": fastener.because,
                "world_from_target": fastener.frame.tolist(),
            }
        else:
            row["world_from_target"] = asked[reach.target].tolist()
        rows.append(
            {
                **row,
                "reachable": reach.is_reachable,
                "tool": reach.tool,
                "nearest": reach.nearest,
                "swing_deg": reach.swing_deg,
                "angle_deg": reach.angle_deg,
                "stroke_deg": reach.stroke_deg,
                "strokes": reach.strokes,
                "seen": reach.seen,
                "comes_from": reach.comes_from.tolist(),
                "because": reach.because,
                "looked_m": reach.looked,
                "drawn_m": reach.drawn,
                "blockers": _blockers(reach.blockers),
                "world_from_tool": reach.pose.tolist(),
                "way": reach.way.tolist(),
                "tried": [{"tool": each.tool, "because": each.because} for each in reach.tried],
            }
        )
    return rows


def _blockers(blockers: tuple[feeler.Blocker, ...]) -> list[dict[str, Any]]:
    return [{"part": each.part, "path": each.path, "count": each.count} for each in blockers]


def _write(
    world: feeler.Mockup,
    tool: feeler.Tool | feeler.Catalogue,
    hand: feeler.Tool | None,
    found: feeler.Access,
    rows: list[dict[str, Any]],
    targets: dict[str, Path | None],
) -> dict[str, str]:
    """Writes the requested files; returns their names by kind."""
    from feeler.atomic import atomic_file
    from feeler.plan.access_glb import write_access_glb

    written = {}
    if targets["csv"] is not None:
        with atomic_file(targets["csv"], ".csv") as file:
            file.write(_csv(rows))
        written["csv"] = str(targets["csv"])
    if targets["glb"] is not None:
        with bar(f"writing {targets['glb']}"):
            write_access_glb(targets["glb"], world, tool, found, hand)
        written["glb"] = str(targets["glb"])
    return written


def _csv(rows: list[dict[str, Any]]) -> bytes:
    from feeler.io.csv_table import csv_table

    lines = []
    columns = ["target", "part", "path", "kind", "size_m", "across_flats_m", "reachable", "swing_deg", "angle_deg"]
    columns += ["looked_m", "drawn_m", "tool", "stroke_deg", "strokes", "seen", "drive", "width_m"]
    for row in rows:
        values = [row.get(column) for column in columns]
        blockers = [each["path"] for each in row["blockers"]]
        blocked = sum(each["count"] for each in row["blockers"])
        values[columns.index("reachable")] = "yes" if row["reachable"] else "no"
        lines.append([*values, row["because"], "; ".join(blockers[:3]), blocked])
    return csv_table([*columns, "because", "blockers", "blocked"], lines)


def _print(
    found: feeler.Access,
    rows: list[dict[str, Any]],
    targets: int,
    approach: float,
    seconds: float,
    written: dict[str, str],
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    if found.is_partial:
        outputs.print_finding(out, "interrupted: these are the results so far")
    reached = int(found.is_reachable.sum())
    line = f"{reached:,} of {plural(len(found), 'target')} reachable ({outputs.duration(seconds)})"
    line += f"; ways in of up to {outputs.length(approach)} were tried"
    if found.is_partial:
        line += f"; {targets - len(found):,} were not tried"
    if reached == len(found):
        outputs.say(out, line)
    else:
        outputs.print_finding(out, line)
    out.print()
    has_kind = any("kind" in row for row in rows)
    has_tools = len({row["tool"] for row in rows if row["tool"]}) > 1 or any(row["tried"] for row in rows)
    has_eyes = any(row["seen"] == row["seen"] for row in rows)
    # Unreachable targets come first.
    order = sorted(rows, key=lambda row: (row["reachable"], row["target"]))
    outputs.print_table(
        out,
        "Targets",
        [
            ("target", "left"),
            *([("kind", "left"), ("width", "right")] if has_kind else []),
            *(("reachable", "left"), ("swing", "right"), ("from", "right")),
            *([("strokes", "right")] if has_tools else []),
            *([("seen", "right")] if has_eyes else []),
            ("tool, or most in the way" if has_tools else "most in the way", "left"),
        ],
        [
            (
                row["path"] or f"target {row['target']}",
                *([row["kind"], _length(row["width_m"])] if has_kind else []),
                "yes" if row["reachable"] else "no",
                f"{row['swing_deg']:.1f}°",
                "" if row["angle_deg"] != row["angle_deg"] else f"{row['angle_deg']:.1f}°",
                *(["" if row["strokes"] is None else f"{row['strokes']:,}"] if has_tools else []),
                *([f"{100.0 * row['seen']:.0f} %"] if has_eyes else []),
                row["tool"] if has_tools and row["reachable"] else _in_the_way(row),
            )
            for row in order[:_SHOWN]
        ],
        more=len(rows) - _SHOWN,
    )
    blockers = found.blockers
    if blockers:
        outputs.print_table(
            out,
            "In the way",
            [("part", "left"), ("times", "right")],
            [(each.path, f"{each.count:,}") for each in blockers[:_SHOWN_BLOCKERS]],
            more=len(blockers) - _SHOWN_BLOCKERS,
        )
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")


def _length(metres: float) -> str:
    from feeler.cli import outputs

    return "" if metres != metres else outputs.length(metres)


def _in_the_way(row: dict[str, Any]) -> str:
    if row["reachable"]:
        return ""
    blockers = row["blockers"]
    return str(blockers[0]["path"] if blockers else row["because"])
