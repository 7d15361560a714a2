"""`feeler clearance`: how much clearance does the tool have at a pose, part by part?"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.findings import containment_facts, containment_lines, mesh_facts, scene_facts, unknown_lines
from feeler.cli.inputs import (
    AsJson,
    At,
    Choice,
    Context,
    MockupFiles,
    MockupUnit,
    Only,
    PartOption,
    PoseFile,
    Rotate,
    SnapPose,
    Threads,
    ToolFile,
    ToolUnit,
    Up,
    Without,
    check_moving,
    poses_of_options,
    read_both,
    warn_of_far_poses,
)
from feeler.cli.options import Needs
from feeler.cli.values import LENGTH
from feeler.progress import bar
from feeler.words import plural

_SHOWN_PARTS = 40
_SHOWN_POSES = 20
_COLUMNS = (
    *("pose", "part", "path", "distance_m"),
    *("tool_x_m", "tool_y_m", "tool_z_m", "mockup_x_m", "mockup_y_m", "mockup_z_m"),
    *("tool_triangle", "mockup_triangle", "tool_part"),
)


@command(
    examples="""
feeler clearance engine.step --tool wrench.stl --pose pose.json --within 10mm
feeler clearance engine.glb --tool wrench.stl --tool-unit mm --at 0.42,-0.1,0.3 --require 2mm
feeler clearance engine.glb --tool wrench.stl --pose path.npy --csv gaps.csv --glb tightest.glb
feeler clearance engine.step --part "*fuel pump*" --at 0,0,0.02 --require 0.001
feeler clearance sample:gearbox --tool sample:wrench --at 0,0,0.2 --within 0.1 --json
"""
)
def clearance(
    mockup: MockupFiles,
    tool: ToolFile = None,
    part: PartOption = None,
    without: Without = None,
    only: Only = None,
    pose: PoseFile = None,
    at: At = None,
    rotate: Rotate = None,
    snap_pose: Annotated[SnapPose, Needs("--pose")] = False,
    within: Annotated[float, typer.Option(help="List parts up to this distance."), LENGTH] = 0.005,
    require: Annotated[
        float | None, typer.Option(help="Required clearance: with less, the exit status is 1."), LENGTH
    ] = None,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    threads: Threads = None,
    glb: Annotated[
        Path | None,
        typer.Option(help="Write mock-up, tool and a line from the tool to each listed part as GLB (tightest pose)."),
    ] = None,
    context: Context = None,
    csv_: Annotated[Path | None, typer.Option("--csv", help="Write a row for each pose and listed part.")] = None,
    as_json: AsJson = False,
) -> None:
    """Measures the distance of the tool to each nearby part, with the closest points.

    A tool wholly inside a closed part, or around one, has no clearance, and the output says so.

    Exit status: 0 fine, 1 containment or less clearance than --require, 2 bad input.
    """
    from feeler.cli import outputs

    check_moving(tool, tool_unit, part)
    poses = poses_of_options(pose, at, rotate, snap_pose, bool(part))
    outputs.check_targets({"glb": glb, "csv": csv_}, {"glb": (".glb",), "csv": (".csv",)}, mockup)
    world, probe = read_both(mockup, unit, tool, tool_unit, up, part)
    warn_of_far_poses(world, probe, poses)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, tool=probe, threads=threads, progress=progress)
    scene = Choice(part, without, only).scene_of(scene)
    start = time.perf_counter()
    # --require may reach farther than --within.
    least = _least(scene, probe, poses)
    with bar(f"measuring {len(poses):,} poses") as progress:
        found = scene.clearance_batch(probe, poses, within, progress=progress)
    seconds = time.perf_counter() - start
    worst = int(np.argmin(least))
    inside = [containment_facts(world, scene.containment(probe, matrix)) for matrix in poses]
    is_inside = np.array([bool(each["containing"] or each["contained"]) for each in inside])
    if is_inside.any() and not is_inside[worst]:
        worst = int(np.flatnonzero(is_inside)[np.argmin(least[is_inside])])
    results = [
        {
            "pose": i,
            "world_from_tool": poses[i],
            "distance_m": float(least[i]),
            "met": None if require is None else bool(least[i] >= require and not is_inside[i]),
            "inside": inside[i],
            "parts": _rows(world, probe, found[i]),
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
            write_clearance_glb(glb, world, probe, poses[worst], found[worst], context=context, parts=scene.part_mask)
        written["glb"] = str(glb)
    is_met = require is None or all(entry["met"] for entry in results)
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
        _print(results, worst, within, require, written, probe.part_count > 1)
    if not is_met or is_inside.any():
        raise typer.Exit(FOUND)


def _least(scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The minimum distance at each pose, metres."""
    with bar("finding the nearest") as progress:
        return np.asarray(scene.distance_batch(tool, poses, progress=progress).values)


def _rows(mockup: feeler.Mockup, tool: feeler.Tool, found: feeler.Clearance) -> list[dict[str, Any]]:
    """The parts near at one pose, nearest first."""
    return [
        {
            "part": int(part),
            "path": mockup.part_paths[int(part)],
            "name": mockup.part_names[int(part)],
            "tool_part": int(tool_part),
            "tool_path": tool.part_paths[int(tool_part)],
            "distance_m": float(distance),
            "point_on_tool_m": on_tool,
            "point_on_mockup_m": on_mockup,
            "tool_triangle": int(tool_triangle),
            "mockup_triangle": int(mockup_triangle),
        }
        for part, tool_part, distance, on_tool, on_mockup, tool_triangle, mockup_triangle in zip(
            found.parts,
            found.tool_parts,
            found.distances,
            found.points_on_tool,
            found.points_on_mockup,
            found.tool_triangles,
            found.mockup_triangles,
            strict=True,
        )
    ]


def _write_csv(path: Path, results: list[dict[str, Any]]) -> None:
    from feeler.atomic import atomic_file
    from feeler.io.csv_table import csv_table

    rows = [
        [
            *(entry["pose"], row["part"], row["path"], row["distance_m"]),
            *(*row["point_on_tool_m"], *row["point_on_mockup_m"]),
            *(row["tool_triangle"], row["mockup_triangle"], row["tool_path"]),
        ]
        for entry in results
        for row in entry["parts"]
    ]
    with atomic_file(path, ".csv") as file:
        file.write(csv_table(_COLUMNS, rows))


def _print(
    results: list[dict[str, Any]],
    worst: int,
    within: float,
    require: float | None,
    written: dict[str, str],
    has_tool_parts: bool,
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    entry = results[worst]
    where = "" if len(results) == 1 else f" at pose {worst} of {len(results):,}"
    inside = containment_lines(entry["inside"])
    for line in inside:
        outputs.print_finding(out, line + where)
    text = f"Smallest distance{' of surfaces' if inside else ''}: {outputs.length(entry['distance_m'])}{where}"
    if require is not None:
        missing = sum(not each["met"] for each in results)
        verdict = "[bold green]enough[/bold green]" if not missing else "[bold red]too little[/bold red]"
        if inside:
            verdict = "[bold red]no clearance[/bold red]"
        text += f"; {outputs.length(require)} are required: {verdict}"
        if missing and len(results) > 1:
            text += f" at {plural(missing, 'pose')}" if not inside else f"; too little at {plural(missing, 'pose')}"
    out.print(text)
    for line in unknown_lines(entry["inside"]):
        outputs.say(out, line[:1].upper() + line[1:])
    parts = entry["parts"]
    if not parts:
        out.print(f"No part is within {outputs.length(within)}{where}")
    out.print()
    if parts:
        _print_parts(out, f"Parts within {outputs.length(within)}{where}", parts, has_tool_parts)
    if len(results) > 1:
        told = any(containment_lines(each["inside"]) for each in results)
        outputs.print_table(
            out,
            "Poses",
            [("pose", "right"), ("distance", "right"), ("parts", "right"), ("nearest", "left")]
            + ([("inside", "left")] if told else []),
            [
                (
                    str(each["pose"]),
                    outputs.length(each["distance_m"]),
                    str(len(each["parts"])),
                    each["parts"][0]["path"] if each["parts"] else "",
                    *(["; ".join(containment_lines(each["inside"]))] if told else []),
                )
                for each in results[:_SHOWN_POSES]
            ],
            more=len(results) - _SHOWN_POSES,
        )
    for kind, path in written.items():
        outputs.say(out, f"{kind} written to {path}")


def _print_parts(out: Any, title: str, parts: list[dict[str, Any]], has_tool_parts: bool) -> None:
    from feeler.cli import outputs

    columns = [("part", "left"), ("distance", "right"), ("on the tool, m", "right"), ("on the part, m", "right")]
    if has_tool_parts:
        columns.insert(1, ("tool part", "left"))
    outputs.print_table(
        out,
        title,
        columns,
        [
            (
                row["path"],
                *([row["tool_path"]] if has_tool_parts else []),
                outputs.length(row["distance_m"]),
                _point(row["point_on_tool_m"]),
                _point(row["point_on_mockup_m"]),
            )
            for row in parts[:_SHOWN_PARTS]
        ],
        more=len(parts) - _SHOWN_PARTS,
    )


def _point(point: Any) -> str:
    return ", ".join(f"{x:.5f}" for x in point if math.isfinite(x))
