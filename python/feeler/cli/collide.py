"""`feeler collide`: does the tool, at a pose, meet the mock-up, and where?"""

from __future__ import annotations

import time
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.findings import kind_counts, mesh_facts, part_findings, scene_facts
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


@command(
    examples="""
feeler collide engine.step --tool wrench.stl --pose pose.json
feeler collide engine.glb --tool wrench.stl --tool-unit mm --at 0.42,-0.1,0.3 --rotate 0,90,0
feeler collide engine.glb --tool wrench.stl --pose pose.json --glb hit.glb --picture hit.png
feeler collide sample:engine:200000 --tool sample:wrench --at 0,0,0 --json
"""
)
def collide(
    mockup: MockupFiles,
    tool: ToolFile,
    pose: PoseFile = None,
    at: At = None,
    rotate: Rotate = None,
    snap_pose: SnapPose = False,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    voxel_size: Annotated[
        float | None,
        typer.Option(help="Metres; default: predicted. With blocks it is the piece size."),
    ] = None,
    storage: Annotated[str, typer.Option(help="blocks, dense or hashed.")] = "blocks",
    hashing: Annotated[float, typer.Option(help="Hashing level of hashed, 0 to 0.99: memory saved.")] = 0.0,
    threads: Annotated[int | None, typer.Option(help="For the build; default: all cores.")] = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write mock-up and tool as GLB, colliding triangles red and orange.")
    ] = None,
    context: Annotated[
        float | None, typer.Option(help="In --glb, only parts within so many metres of the tool, and all that are hit.")
    ] = None,
    picture: Annotated[Path | None, typer.Option(help="Write a picture (PNG).")] = None,
    picture_size: Annotated[str, typer.Option(metavar="WxH", help="Of --picture, pixels.")] = "1600x1000",
    list_pairs: Annotated[
        bool, typer.Option("--pairs", help="With --json: list every pair (tool triangle, mock-up triangle).")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Finds every pair of triangles of tool and mock-up that meets, and names the parts.

    Exit status: 0 nothing meets, 1 something does, 2 bad input.
    """
    from feeler.cli import outputs

    poses = poses_of_options(pose, at, rotate, snap_pose)
    pixels = _pixels(picture_size)
    for target, ending in ((glb, ".glb"), (picture, ".png")):
        if target is not None:
            _check_out(target, ending)
    world, probe = read_both(mockup, unit, tool, tool_unit, up)
    with bar("indexing") as progress:
        scene = feeler.Scene(
            world,
            voxel_size=voxel_size,
            storage=storage,
            hashing=hashing,
            tool=probe,
            threads=threads,
            progress=progress,
        )
    results = _query(scene, probe, poses)
    worst = max(range(len(results)), key=lambda i: results[i]["pairs"])
    written = {}
    if glb is not None or picture is not None:
        collision = scene.collide(probe, poses[worst])
        written = _write(world, probe, poses[worst], collision, glb, context, picture, pixels)
    if as_json:
        if list_pairs:
            for entry, matrix in zip(results, poses, strict=True):
                hit = scene.collide(probe, matrix)
                entry["pair_list"] = hit.pairs
                entry["pair_kinds"] = [feeler.PairKind(kind).name.lower() for kind in hit.kinds]
        outputs.print_json(
            {
                "colliding": any(entry["pairs"] for entry in results),
                "mockup": mesh_facts(world),
                "tool": mesh_facts(probe),
                "scene": scene_facts(scene),
                "poses": results,
                "written": written,
            }
        )
    else:
        _print(world, probe, scene, results, worst, written)
    if any(entry["pairs"] for entry in results):
        raise typer.Exit(FOUND)


def _query(scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]) -> list[dict[str, Any]]:
    """One entry per pose: its matrix, pairs, kinds, parts."""
    if len(poses) == 1:
        start = time.perf_counter()
        hit = scene.collide(tool, poses[0])
        seconds = time.perf_counter() - start
        return [
            {
                **_entry(scene.mockup, 0, poses[0], hit.pairs, hit.kinds),
                "query_us": seconds * 1e6,
                "stats": dict(hit.stats),
            }
        ]
    with bar(f"querying {len(poses):,} poses") as progress:
        batch = scene.collide_batch(tool, poses, progress=progress)
    offsets = np.asarray(batch.offsets).astype(np.int64)
    pairs, kinds = np.asarray(batch.pairs), np.asarray(batch.kinds)
    return [
        _entry(scene.mockup, i, poses[i], pairs[begin:end], kinds[begin:end])
        for i, (begin, end) in enumerate(pairwise(offsets))
    ]


def _entry(mockup: feeler.Mockup, number: int, matrix: Any, pairs: Any, kinds: Any) -> dict[str, Any]:
    return {
        "pose": number,
        "world_from_tool": matrix,
        "colliding": len(pairs) > 0,
        "pairs": len(pairs),
        "kinds": kind_counts(kinds),
        "parts": part_findings(mockup, pairs, kinds) if len(pairs) else [],
    }


def _pixels(text: str) -> tuple[int, int]:
    words = text.lower().split("x")
    if len(words) != 2 or not all(word.isdecimal() for word in words):
        raise OptionError(f"--picture-size is {text!r}: give width and height in pixels, such as 1600x1000")
    return int(words[0]), int(words[1])


def _check_out(target: Path, ending: str) -> None:
    from feeler.io import check_target

    if target.suffix.lower() != ending:
        raise OptionError(f"{target}: the name must end in {ending}")
    check_target(target)


def _write(
    mockup: feeler.Mockup,
    tool: feeler.Tool,
    pose: npt.NDArray[np.float64],
    collision: Any,
    glb: Path | None,
    context: float | None,
    picture: Path | None,
    pixels: tuple[int, int],
) -> dict[str, str]:
    from feeler.picture import render_collision, write_collision_glb

    written = {}
    if glb is not None:
        with bar(f"writing {glb}"):
            write_collision_glb(glb, mockup, tool, pose, collision, context=context)
        written["glb"] = str(glb)
    if picture is not None:
        with bar("rendering") as progress:
            render_collision(picture, mockup, tool, pose, collision, size=pixels, progress=progress)
        written["picture"] = str(picture)
    return written


def _print(
    mockup: feeler.Mockup,
    tool: feeler.Tool,
    scene: feeler.Scene,
    results: list[dict[str, Any]],
    worst: int,
    written: dict[str, str],
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    facts = []
    for role, mesh in (("mock-up", mockup), ("tool", tool)):
        report = mesh.report
        text = f"{report.triangles:,} triangles"
        if role == "mock-up":
            text += f", {report.parts:,} parts"
        text += f", {outputs.extent(report.lower, report.upper)}"
        text += f"; unit {report.source.unit} ({report.source.unit_source})"
        facts.append((role, text))
        if report.not_queried:
            facts.append(("", f"{report.not_queried:,} defective triangles are not queried (see feeler info)"))
    facts.append(
        (
            "index",
            f"{scene.storage}, {'piece' if scene.storage == 'blocks' else 'voxel'} size "
            f"{outputs.length(scene.voxel_size)}, built in {outputs.duration(scene.build_seconds)}, "
            f"{outputs.size(scene.memory()['total'])}",
        )
    )
    outputs.print_facts(out, facts)
    out.print()
    if len(results) == 1:
        _print_one(out, results[0])
    else:
        _print_many(out, results, worst)
    for kind, path in written.items():
        where = "" if len(results) == 1 else f" of pose {worst}"
        outputs.say(out, f"{kind}{where} written to {path}")


def _print_one(out: Any, entry: dict[str, Any]) -> None:
    from feeler.cli import outputs

    query = f" (query: {outputs.duration(entry['query_us'] * 1e-6)})"
    if not entry["pairs"]:
        out.print(f"[bold green]No collision[/bold green]{query}")
        return
    parts = entry["parts"]
    kinds = ", ".join(f"{count:,} {kind}" for kind, count in entry["kinds"].items() if count)
    out.print(
        f"[bold red]Collision[/bold red]: {entry['pairs']:,} pairs ({kinds}) with {_count(len(parts), 'part')}{query}"
    )
    out.print()
    outputs.print_table(
        out,
        "Parts that are hit",
        [
            ("part", "left"),
            ("triangles hit", "right"),
            ("of the tool", "right"),
            ("pairs", "right"),
            *((kind, "right") for kind in entry["kinds"]),
        ],
        [
            (
                part["path"],
                f"{part['mockup_triangles']:,}",
                f"{part['tool_triangles']:,}",
                f"{part['pairs']:,}",
                *(f"{count:,}" for count in part["kinds"].values()),
            )
            for part in parts[:_SHOWN_PARTS]
        ],
        more=len(parts) - _SHOWN_PARTS,
    )


def _print_many(out: Any, results: list[dict[str, Any]], worst: int) -> None:
    from feeler.cli import outputs

    colliding = [entry for entry in results if entry["pairs"]]
    colour = "red" if colliding else "green"
    out.print(
        f"[bold {colour}]{len(colliding):,} of {len(results):,} poses collide[/bold {colour}]"
        + (f"; most pairs: {results[worst]['pairs']:,} at pose {worst}" if colliding else "")
    )
    out.print()
    outputs.print_table(
        out,
        "Poses",
        [("pose", "right"), ("pairs", "right"), ("parts", "right"), ("most hit", "left")],
        [
            (
                str(entry["pose"]),
                f"{entry['pairs']:,}" if entry["pairs"] else "-",
                str(len(entry["parts"])) if entry["pairs"] else "-",
                entry["parts"][0]["path"] if entry["pairs"] else "",
            )
            for entry in results[:_SHOWN_POSES]
        ],
        more=len(results) - _SHOWN_POSES,
    )


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"
