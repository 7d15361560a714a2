"""`feeler clearance`: how much room is left around the tool at a pose, part by part?"""

from __future__ import annotations

import csv
import math
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.findings import mesh_facts, scene_facts
from feeler.cli.inputs import (
    AsJson,
    At,
    MockupFiles,
    MockupUnit,
    PoseFile,
    Rotate,
    SnapPose,
    ToolFile,
    ToolUnit,
    Up,
    poses_of_options,
    read_both,
)
from feeler.errors import OptionError
from feeler.progress import bar

_SHOWN_PARTS = 40
_SHOWN_POSES = 20
_COLUMNS = (
    *("pose", "part", "path", "distance_m"),
    *("tool_x_m", "tool_y_m", "tool_z_m", "mockup_x_m", "mockup_y_m", "mockup_z_m"),
    *("tool_triangle", "mockup_triangle"),
)


@command(
    examples="""
feeler clearance engine.step --tool wrench.stl --pose pose.json --within 0.01
feeler clearance engine.glb --tool wrench.stl --tool-unit mm --at 0.42,-0.1,0.3 --require 0.002
feeler clearance engine.glb --tool wrench.stl --pose path.npy --csv gaps.csv --glb tightest.glb
feeler clearance sample:engine:200000 --tool sample:wrench --at 0,0,0 --json
"""
)
def clearance(
    mockup: MockupFiles,
    tool: ToolFile,
    pose: PoseFile = None,
    at: At = None,
    rotate: Rotate = None,
    snap_pose: SnapPose = False,
    within: Annotated[float, typer.Option(help="List parts up to so many metres away.")] = 0.005,
    require: Annotated[
        float | None, typer.Option(help="Metres of room that there must be: with less, the exit status is 1.")
    ] = None,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    threads: Annotated[
        int | None, typer.Option(help="For the build and for several poses; default: all cores.")
    ] = None,
    glb: Annotated[
        Path | None,
        typer.Option(help="Write mock-up, tool and a line from tool to each part listed as GLB (the tightest pose)."),
    ] = None,
    context: Annotated[
        float | None, typer.Option(help="In --glb, only parts within so many metres of the tool, and all listed.")
    ] = None,
    csv_: Annotated[Path | None, typer.Option("--csv", help="Write a row for each pose and part listed.")] = None,
    as_json: AsJson = False,
) -> None:
    """Measures the distance of the tool to each part that is near, with the closest points.

    Exit status: 0 fine, 1 less room than --require, 2 bad input.
    """
    from feeler.cli import outputs

    poses = poses_of_options(pose, at, rotate, snap_pose)
    for option, value in (("--within", within), ("--require", require)):
        if value is not None and not value >= 0:
            raise OptionError(f"{option} is {value}: give a distance in metres, 0 or more")
    for target, ending in ((glb, ".glb"), (csv_, ".csv")):
        if target is not None:
            _check_out(target, ending)
    world, probe = read_both(mockup, unit, tool, tool_unit, up)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, tool=probe, threads=threads, progress=progress)
    start = time.perf_counter()
    # What is required may reach farther than what is listed.
    least = _least(scene, probe, poses)
    with bar(f"measuring {len(poses):,} poses") as progress:
        found = scene.clearance_batch(probe, poses, within, progress=progress)
    seconds = time.perf_counter() - start
    worst = int(np.argmin(least))
    results = [
        {
            "pose": i,
            "world_from_tool": poses[i],
            "distance_m": float(least[i]),
            "met": None if require is None else bool(least[i] >= require),
            "parts": _rows(world, found[i]),
        }
        for i in range(len(poses))
    ]
    written = {}
    if csv_ is not None:
        _write_csv(csv_, results)
        written["csv"] = str(csv_)
    if glb is not None:
        from feeler.picture import write_clearance_glb

        with bar(f"writing {glb}"):
            write_clearance_glb(glb, world, probe, poses[worst], found[worst], context=context)
        written["glb"] = str(glb)
    is_met = require is None or bool((least >= require).all())
    if as_json:
        outputs.print_json(
            {
                "within_m": within,
                "required_m": require,
                "met": None if require is None else is_met,
                "distance_m": float(least.min()),
                "mockup": mesh_facts(world),
                "tool": mesh_facts(probe),
                "scene": scene_facts(scene),
                "query_s": seconds,
                "poses": results,
                "written": written,
            }
        )
    else:
        _print(results, worst, within, require, written)
    if not is_met:
        raise typer.Exit(FOUND)


def _least(scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The minimum distance at each pose, metres."""
    with bar("finding the nearest") as progress:
        return np.asarray(scene.distance_batch(tool, poses, progress=progress).values)


def _rows(mockup: feeler.Mockup, found: feeler.Clearance) -> list[dict[str, Any]]:
    """What is near at one pose, nearest part first."""
    return [
        {
            "part": int(part),
            "path": mockup.part_paths[int(part)],
            "name": mockup.part_names[int(part)],
            "distance_m": float(distance),
            "point_on_tool_m": on_tool,
            "point_on_mockup_m": on_mockup,
            "tool_triangle": int(tool_triangle),
            "mockup_triangle": int(mockup_triangle),
        }
        for part, distance, on_tool, on_mockup, tool_triangle, mockup_triangle in zip(
            found.parts,
            found.distances,
            found.points_on_tool,
            found.points_on_mockup,
            found.tool_triangles,
            found.mockup_triangles,
            strict=True,
        )
    ]


def _check_out(target: Path, ending: str) -> None:
    from feeler.io import check_target

    if target.suffix.lower() != ending:
        raise OptionError(f"{target}: the name must end in {ending}")
    check_target(target)


def _write_csv(path: Path, results: list[dict[str, Any]]) -> None:
    from feeler.io import WriteError

    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(_COLUMNS)
            for entry in results:
                for row in entry["parts"]:
                    writer.writerow(
                        [
                            entry["pose"],
                            row["part"],
                            row["path"],
                            repr(row["distance_m"]),
                            *(repr(float(x)) for x in row["point_on_tool_m"]),
                            *(repr(float(x)) for x in row["point_on_mockup_m"]),
                            row["tool_triangle"],
                            row["mockup_triangle"],
                        ]
                    )
    except OSError as error:
        raise WriteError(f"{path} cannot be written: {error.strerror or error}") from None


def _print(
    results: list[dict[str, Any]], worst: int, within: float, require: float | None, written: dict[str, str]
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    entry = results[worst]
    where = "" if len(results) == 1 else f" at pose {worst} of {len(results):,}"
    text = f"Least distance: {outputs.length(entry['distance_m'])}{where}"
    if require is not None:
        missing = sum(not each["met"] for each in results)
        verdict = "[bold green]enough[/bold green]" if not missing else "[bold red]too little[/bold red]"
        text += f"; {outputs.length(require)} are required: {verdict}"
        if missing and len(results) > 1:
            text += f" at {missing:,} poses"
    out.print(text)
    out.print()
    parts = entry["parts"]
    outputs.print_table(
        out,
        f"Parts within {outputs.length(within)}{where}",
        [("part", "left"), ("distance", "right"), ("on the tool, m", "right"), ("on the part, m", "right")],
        [
            (
                row["path"],
                outputs.length(row["distance_m"]),
                _point(row["point_on_tool_m"]),
                _point(row["point_on_mockup_m"]),
            )
            for row in parts[:_SHOWN_PARTS]
        ],
        more=len(parts) - _SHOWN_PARTS,
    )
    if len(results) > 1:
        outputs.print_table(
            out,
            "Poses",
            [("pose", "right"), ("distance", "right"), ("parts", "right"), ("nearest", "left")],
            [
                (
                    str(each["pose"]),
                    outputs.length(each["distance_m"]),
                    str(len(each["parts"])),
                    each["parts"][0]["path"] if each["parts"] else "",
                )
                for each in results[:_SHOWN_POSES]
            ],
            more=len(results) - _SHOWN_POSES,
        )
    for kind, path in written.items():
        outputs.say(out, f"{kind} written to {path}")


def _point(point: Any) -> str:
    return ", ".join(f"{x:.5f}" for x in point if math.isfinite(x))
