"""`feeler path`: is the tool's path free, and if not, where is the first impact?"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import STORAGES
from feeler.cli.app import FOUND, command
from feeler.cli.findings import containment_facts, containment_lines, mesh_facts, scene_facts, unknown_lines
from feeler.cli.inputs import (
    AsJson,
    Choice,
    Context,
    MockupFiles,
    MockupUnit,
    Only,
    PartOption,
    SnapPose,
    Storage,
    Threads,
    ToolFile,
    ToolUnit,
    Touching,
    Up,
    Without,
    check_moving,
    read_both,
    read_path,
    warn_of_far_poses,
)
from feeler.cli.values import POSITIVE_LENGTH
from feeler.progress import bar
from feeler.scene import CAST_TOLERANCE
from feeler.words import plural

_SHOWN = 20


@command(
    examples="""
feeler path engine.step --tool wrench.stl --poses way_out.npy
feeler path engine.glb --tool wrench.stl --poses way_out.json --csv hits.csv --glb first.glb
feeler path engine.step --part "*fuel pump*" --poses way_out.json --touching free
feeler path sample:engine:200000 --tool sample:wrench --poses way_out.csv --tolerance 0.01mm --json
"""
)
def path(
    mockup: MockupFiles,
    *,
    tool: ToolFile = None,
    part: PartOption = None,
    without: Without = None,
    only: Only = None,
    touching: Touching = "counts",
    poses: Annotated[
        Path,
        typer.Option(
            help="world_from_tool, metres, one after the other: (n, 4, 4) as .npy or JSON, or as text or CSV with 16 "
            "numbers a pose, row by row; or the legs of a way, as remove --way writes them (JSON).",
        ),
    ],
    tolerance: Annotated[
        float, typer.Option(help="How much too early an impact may be reported; never too late."), POSITIVE_LENGTH
    ] = CAST_TOLERANCE,
    snap_pose: SnapPose = False,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    storage: Storage = "blocks",
    threads: Threads = None,
    csv: Annotated[Path | None, typer.Option(help="Write a line for each segment with an impact (CSV).")] = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write mock-up and tool at the first impact as GLB, the pair coloured.")
    ] = None,
    context: Context = None,
    as_json: AsJson = False,
) -> None:
    """Moves the tool along a path of poses, and finds the first impact of each segment by continuous collision
    detection.

    Between two poses the middle of the tool's box moves straight and the tool turns about it, the shorter way round.
    A tool that is inside a closed part at the first pose, or around one, is not free, even without an impact.
    Exit status: 0 the path is free, 1 it is not, 2 bad input.
    """
    from feeler.cli import outputs

    outputs.check_targets({"csv": csv, "glb": glb}, {"csv": (".csv",), "glb": (".glb",)}, mockup)
    check_moving(tool, tool_unit, part)
    way = read_path(poses, snap_pose)
    world, probe = read_both(mockup, unit, tool, tool_unit, up, part)
    places = [each for each in way if isinstance(each, np.ndarray)]
    warn_of_far_poses(world, probe, np.stack(places))
    kind = check_word("--storage", storage, STORAGES)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, storage=kind, tool=probe, threads=threads, progress=progress)
    scene = Choice(part, without, only).scene_of(scene)
    start = time.perf_counter()
    with bar(f"following {len(way) - 1:,} legs") as progress:
        check = scene.check_path(probe, way, tolerance=tolerance, touching=touching, progress=progress)
    seconds = time.perf_counter() - start
    hits = _hits(world, probe, check)
    assert check.containment is not None
    inside = containment_facts(world, check.containment)
    written = _write(scene, probe, check, hits, csv, glb, context)
    if as_json:
        outputs.print_json(
            {
                "free": check.is_free,
                "segments": len(check),
                "segments_hit": len(hits),
                "tolerance_m": tolerance,
                "touching": touching,
                "inside": inside,
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
        _print(len(check), hits, inside, seconds, written, probe.part_count > 1)
    if not check.is_free:
        raise typer.Exit(FOUND)


def _hits(mockup: feeler.Mockup, tool: feeler.Tool, check: feeler.PathCheck) -> list[dict[str, Any]]:
    """One entry per segment with an impact."""
    columns = (
        check.segments,
        check.fractions[check.segments],
        check.parts,
        check.tool_parts,
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
            "tool_part": int(tool_part),
            "tool_path": tool.part_paths[int(tool_part)],
            "tool_triangle": int(tool_triangle),
            "mockup_triangle": int(mockup_triangle),
            "point": point.tolist(),
            "normal": normal.tolist(),
            "world_from_tool": pose.tolist(),
        }
        for segment, fraction, part, tool_part, tool_triangle, mockup_triangle, point, normal, pose in zip(
            *columns, strict=True
        )
    ]


def _by_part(hits: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry per part that is hit first in any segment, in the order of impacts."""
    parts: dict[int, dict[str, Any]] = {}
    for hit in hits:
        entry = parts.setdefault(
            hit["part"],
            {"part": hit["part"], "path": hit["path"], "segments": 0, "first": hit["segment"] + hit["fraction"]},
        )
        entry["segments"] += 1
    return list(parts.values())


@dataclass(eq=False)
class _Pair:
    """The arguments of a picture of a collision."""

    tool_triangles: npt.NDArray[np.uint32]
    mockup_triangles: npt.NDArray[np.uint32]
    parts: npt.NDArray[np.uint32]


def _write(
    scene: feeler.Scene,
    tool: feeler.Tool,
    check: feeler.PathCheck,
    hits: list[dict[str, Any]],
    csv: Path | None,
    glb: Path | None,
    context: float | None,
) -> dict[str, str]:
    from feeler.atomic import atomic_file
    from feeler.picture import write_collision_glb

    written = {}
    if csv is not None:
        with atomic_file(csv, ".csv") as file:
            file.write(_csv(hits))
        written["csv"] = str(csv)
    first = check.first
    if glb is not None and first is not None:
        pair = _Pair(
            *(np.array([i], dtype=np.uint32) for i in (first.tool_triangle, first.mockup_triangle, first.part))
        )
        with bar(f"writing {glb}"):
            write_collision_glb(glb, scene.mockup, tool, first.pose, pair, context=context, parts=scene.part_mask)
        written["glb"] = str(glb)
    return written


def _csv(hits: list[dict[str, Any]]) -> bytes:
    from feeler.io.csv_table import csv_table

    vectors = [f"{what}_{axis}" for what in ("point", "normal") for axis in "xyz"]
    columns = ["segment", "fraction", "part", "path", "tool_triangle", "mockup_triangle"]
    rows = []
    for hit in hits:
        rows.append([*(hit[name] for name in columns), *hit["point"], *hit["normal"], hit["tool_path"]])
    return csv_table([*columns, *vectors, "tool_part"], rows)


def _print(
    segments: int,
    hits: list[dict[str, Any]],
    inside: dict[str, Any],
    seconds: float,
    written: dict[str, str],
    has_tool_parts: bool,
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    took = f" ({outputs.duration(seconds)})"
    what = plural(segments, "segment")
    lines = containment_lines(inside)
    for line in lines:
        outputs.print_finding(out, f"the path is not free: at the first pose {line}")
    for line in unknown_lines(inside):
        outputs.say(out, f"At the first pose it is {line}")
    if not hits:
        verdict = "No impact" if lines else "[bold green]The path is free[/bold green]"
        out.print(f"{verdict}: {what}{took}")
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
        [(part["path"], f"{part['segments']:,}", _first_of(part, hits)) for part in _by_part(hits)[:_SHOWN]],
        more=len(_by_part(hits)) - _SHOWN,
    )
    outputs.print_table(
        out,
        "Segments that are hit",
        [
            *(("segment", "right"), ("at", "right"), ("part", "left")),
            *([("tool part", "left")] if has_tool_parts else []),
            *(("point, m", "right"), ("normal", "right")),
        ],
        [
            (
                str(hit["segment"]),
                f"{100 * hit['fraction']:.4g} %",
                hit["path"],
                *([hit["tool_path"]] if has_tool_parts else []),
                " ".join(f"{x:.5g}" for x in hit["point"]),
                " ".join(f"{x:.3g}" for x in hit["normal"]),
            )
            for hit in hits[:_SHOWN]
        ],
        more=len(hits) - _SHOWN,
    )
    _print_written(out, written)


def _first_of(part: dict[str, Any], hits: list[dict[str, Any]]) -> str:
    first = next(hit for hit in hits if hit["part"] == part["part"])
    return f"{100 * first['fraction']:.3g} % of segment {first['segment']}"


def _print_written(out: Any, written: dict[str, str]) -> None:
    from feeler.cli import outputs

    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")
