"""`feeler path`: is the tool's way from pose to pose free, and if not, where does it first touch what?"""

from __future__ import annotations

import time
from dataclasses import dataclass
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
    MockupFiles,
    MockupUnit,
    SnapPose,
    ToolFile,
    ToolUnit,
    Up,
    read_both,
    read_poses,
)
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.scene import CAST_TOLERANCE

_SHOWN = 20


@command(
    examples="""
feeler path engine.step --tool wrench.stl --poses way_out.npy
feeler path engine.glb --tool wrench.stl --poses way_out.json --csv hits.csv --glb first.glb
feeler path sample:engine:200000 --tool sample:wrench --poses way_out.csv --tolerance 1e-5 --json
"""
)
def path(
    mockup: MockupFiles,
    tool: ToolFile,
    poses: Annotated[
        Path,
        typer.Option(
            help="world_from_tool, metres, one after the other: (n, 4, 4) as .npy or JSON, or as text or CSV with 16 "
            "numbers a pose, row by row.",
        ),
    ],
    tolerance: Annotated[
        float, typer.Option(help="Metres by which an impact may be given too early; never too late.")
    ] = CAST_TOLERANCE,
    snap_pose: SnapPose = False,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    storage: Annotated[str, typer.Option(help="blocks, dense or hashed.")] = "blocks",
    threads: Annotated[int | None, typer.Option(help="Default: all cores.")] = None,
    csv: Annotated[Path | None, typer.Option(help="Write a line per segment that is hit (CSV).")] = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write the mock-up and the tool at the first impact as GLB, the pair coloured.")
    ] = None,
    context: Annotated[
        float | None, typer.Option(help="In --glb, only parts within so many metres of the tool, and the one hit.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Moves the tool from pose to pose, and finds the first impact of each segment: nothing is passed through.

    Between two poses the middle of the tool's box moves straight and the tool turns about it, the shorter way round.
    Exit status: 0 the path is free, 1 it is not, 2 bad input.
    """
    from feeler.cli import outputs
    from feeler.io import check_target

    for target, ending in ((csv, ".csv"), (glb, ".glb")):
        if target is not None:
            if target.suffix.lower() != ending:
                raise OptionError(f"{target}: the name must end in {ending}")
            check_target(target)
    way = read_poses(poses, snap_pose)
    world, probe = read_both(mockup, unit, tool, tool_unit, up)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, storage=storage, tool=probe, threads=threads, progress=progress)
    start = time.perf_counter()
    with bar(f"following {len(way):,} poses") as progress:
        check = scene.check_path(probe, way, tolerance=tolerance, progress=progress)
    seconds = time.perf_counter() - start
    hits = _hits(world, check)
    written = _write(world, probe, check, hits, csv, glb, context)
    if as_json:
        outputs.print_json(
            {
                "free": check.free,
                "segments": len(check),
                "segments_hit": len(hits),
                "tolerance_m": tolerance,
                "seconds": seconds,
                "mockup": mesh_facts(world),
                "tool": mesh_facts(probe),
                "scene": scene_facts(scene),
                "hits": hits,
                "parts": _by_part(hits),
                "written": written,
            }
        )
    else:
        _print(len(check), hits, seconds, written)
    if not check.free:
        raise typer.Exit(FOUND)


def _hits(mockup: feeler.Mockup, check: feeler.PathCheck) -> list[dict[str, Any]]:
    """One entry per segment that is hit."""
    columns = (
        check.segments,
        check.fraction[check.segments],
        check.parts,
        check.tool_triangles,
        check.mockup_triangles,
        check.points,
        check.normals,
        check.poses,
    )
    return [
        {
            "segment": int(segment),
            "fraction": float(fraction),
            "part": int(part),
            "path": mockup.part_paths[int(part)],
            "tool_triangle": int(tool_triangle),
            "mockup_triangle": int(mockup_triangle),
            "point": point.tolist(),
            "normal": normal.tolist(),
            "world_from_tool": pose.tolist(),
        }
        for segment, fraction, part, tool_triangle, mockup_triangle, point, normal, pose in zip(*columns, strict=True)
    ]


def _by_part(hits: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry per part that is hit first by any segment, in the order in which they are met."""
    parts: dict[int, dict[str, Any]] = {}
    for hit in hits:
        entry = parts.setdefault(
            hit["part"],
            {"part": hit["part"], "path": hit["path"], "segments": 0, "first": hit["segment"] + hit["fraction"]},
        )
        entry["segments"] += 1
    return list(parts.values())


@dataclass
class _Pair:
    """What a picture of a collision asks for."""

    tool_triangles: npt.NDArray[np.int64]
    mockup_triangles: npt.NDArray[np.int64]
    parts: npt.NDArray[np.int64]


def _write(
    mockup: feeler.Mockup,
    tool: feeler.Tool,
    check: feeler.PathCheck,
    hits: list[dict[str, Any]],
    csv: Path | None,
    glb: Path | None,
    context: float | None,
) -> dict[str, str]:
    from feeler.io.atomic import atomic_file
    from feeler.picture import write_collision_glb

    written = {}
    if csv is not None:
        with atomic_file(csv) as file:
            file.write(_csv(hits).encode())
        written["csv"] = str(csv)
    first = check.first
    if glb is not None and first is not None:
        pair = _Pair(*(np.array([i]) for i in (first.tool_triangle, first.mockup_triangle, first.part)))
        with bar(f"writing {glb}"):
            write_collision_glb(glb, mockup, tool, first.pose, pair, context=context)
        written["glb"] = str(glb)
    return written


def _csv(hits: list[dict[str, Any]]) -> str:
    import csv
    import io

    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    vectors = [f"{what}_{axis}" for what in ("point", "normal") for axis in "xyz"]
    rows.writerow(["segment", "fraction", "part", "path", "tool_triangle", "mockup_triangle", *vectors])
    for hit in hits:
        values = [hit[name] for name in ("segment", "fraction", "part", "path", "tool_triangle", "mockup_triangle")]
        rows.writerow([*values, *hit["point"], *hit["normal"]])
    return out.getvalue()


def _print(segments: int, hits: list[dict[str, Any]], seconds: float, written: dict[str, str]) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    took = f" ({outputs.duration(seconds)})"
    what = f"{segments:,} segment{'' if segments == 1 else 's'}"
    if not hits:
        out.print(f"[bold green]The path is free[/bold green]: {what}{took}")
        _print_written(out, written)
        return
    first = hits[0]
    out.print(
        f"[bold red]The path is not free[/bold red]: {len(hits):,} of {what} hit; the first impact is at "
        f"{100 * first['fraction']:.3g} % of segment {first['segment']}{took}"
    )
    out.print()
    outputs.print_table(
        out,
        "Parts that are hit",
        [("part", "left"), ("segments", "right"), ("first impact", "right")],
        [(part["path"], f"{part['segments']:,}", f"segment {part['first']:.6g}") for part in _by_part(hits)[:_SHOWN]],
        more=len(_by_part(hits)) - _SHOWN,
    )
    outputs.print_table(
        out,
        "Segments that are hit",
        [("segment", "right"), ("at", "right"), ("part", "left"), ("point, m", "right"), ("normal", "right")],
        [
            (
                str(hit["segment"]),
                f"{100 * hit['fraction']:.4g} %",
                hit["path"],
                " ".join(f"{x:.5g}" for x in hit["point"]),
                " ".join(f"{x:.3g}" for x in hit["normal"]),
            )
            for hit in hits[:_SHOWN]
        ],
        more=len(hits) - _SHOWN,
    )
    _print_written(out, written)


def _print_written(out: Any, written: dict[str, str]) -> None:
    from feeler.cli import outputs

    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")
