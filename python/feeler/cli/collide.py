"""`feeler collide`: does the tool, at a pose, collide with the mock-up, and where?"""

from __future__ import annotations

import time
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import STORAGES
from feeler.cli.app import FOUND, command
from feeler.cli.findings import (
    containment_facts,
    containment_lines,
    kind_counts,
    mesh_facts,
    part_findings,
    scene_facts,
    unknown_lines,
)
from feeler.cli.inputs import (
    AsJson,
    At,
    BuildThreads,
    Choice,
    Context,
    Hashing,
    MockupFiles,
    MockupUnit,
    Only,
    PartOption,
    PoseFile,
    Rotate,
    SnapPose,
    Storage,
    ToolFile,
    ToolUnit,
    Touching,
    Up,
    VoxelSize,
    Without,
    check_moving,
    poses_of_options,
    read_both,
    warn_of_far_poses,
)
from feeler.cli.options import Needs
from feeler.cli.values import PIXELS
from feeler.progress import bar
from feeler.words import plural

_SHOWN_PARTS = 40
_SHOWN_POSES = 20
_SHOWN_TOOL_PARTS = 3


@command(
    examples="""
feeler collide engine.step --tool wrench.stl --pose pose.json
feeler collide engine.glb --tool wrench.stl --tool-unit mm --at 0.42,-0.1,0.3 --rotate 0,90,0
feeler collide engine.glb --tool wrench.stl --pose pose.json --glb hit.glb --picture hit.png
feeler collide engine.step --part "*fuel pump*" --without "*gasket*" --touching free --at 0,0,0.02
feeler collide sample:gearbox --tool sample:wrench --at 0,0,0.1 --json
"""
)
def collide(
    mockup: MockupFiles,
    tool: ToolFile = None,
    part: PartOption = None,
    without: Without = None,
    only: Only = None,
    touching: Touching = "counts",
    pose: PoseFile = None,
    at: At = None,
    rotate: Rotate = None,
    snap_pose: Annotated[SnapPose, Needs("--pose")] = False,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    voxel_size: VoxelSize = None,
    storage: Storage = "blocks",
    hashing: Hashing = 0.0,
    threads: BuildThreads = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write mock-up and tool as GLB, colliding triangles red and orange.")
    ] = None,
    context: Context = None,
    picture: Annotated[Path | None, typer.Option(help="Write a picture (PNG).")] = None,
    picture_size: Annotated[
        tuple[int, int], typer.Option(help="Size of --picture, pixels."), PIXELS, Needs("--picture")
    ] = (1600, 1000),
    list_pairs: Annotated[
        bool,
        typer.Option("--pairs", help="With --json: list every pair (tool triangle, mock-up triangle)."),
        Needs("--json"),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Finds every colliding pair of triangles of tool and mock-up, and names the parts.

    Also detects a tool wholly inside a closed part, or around one. Exit status: 0 no collision and no containment, 1
    otherwise, 2 bad input.
    """
    from feeler.cli import outputs

    check_moving(tool, tool_unit, part)
    poses = poses_of_options(pose, at, rotate, snap_pose, bool(part))
    outputs.check_targets({"glb": glb, "picture": picture}, {"glb": (".glb",), "picture": (".png",)}, mockup)
    world, probe = read_both(mockup, unit, tool, tool_unit, up, part)
    warn_of_far_poses(world, probe, poses)
    with bar("indexing") as progress:
        scene = feeler.Scene(
            world,
            voxel_size=voxel_size,
            storage=check_word("--storage", storage, STORAGES),
            hashing=hashing,
            tool=probe,
            threads=threads,
            progress=progress,
        )
    scene = Choice(part, without, only).scene_of(scene)
    results = _query(scene, probe, poses, touching == "free")
    worst = max(range(len(results)), key=lambda i: (results[i]["colliding"], results[i]["pairs"]))
    written = {}
    if glb is not None or picture is not None:
        collision = scene.collide(probe, poses[worst])
        written = _write(scene, probe, poses[worst], collision, glb, context, picture, picture_size)
    if as_json:
        if list_pairs:
            for entry, matrix in zip(results, poses, strict=True):
                hit = scene.collide(probe, matrix)
                entry["pair_list"] = hit.pairs
                entry["pair_kinds"] = hit.kinds.tolist()
        outputs.print_json(
            {
                "colliding": any(entry["colliding"] for entry in results),
                "free": all(entry["free"] for entry in results),
                "mockup": mesh_facts(world),
                "tool": mesh_facts(probe),
                "scene": scene_facts(scene),
                "poses": results,
                "written": written,
            }
        )
    else:
        _print(probe, bool(part), scene, results, worst, written)
    if not all(entry["free"] for entry in results):
        raise typer.Exit(FOUND)


def _query(
    scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64], free_touch: bool
) -> list[dict[str, Any]]:
    """One entry per pose: its matrix, pairs, kinds, parts, containment, and whether it is free."""
    results = _meetings(scene, tool, poses)
    for entry, pose in zip(results, poses, strict=True):
        if free_touch and entry["pairs"]:
            entry["colliding"] = scene.is_colliding(tool, pose, touching="free")
        entry["inside"] = containment_facts(scene.mockup, scene.containment(tool, pose))
        inside = entry["inside"]["containing"] or entry["inside"]["contained"]
        entry["free"] = not entry["colliding"] and not inside
    return results


def _meetings(scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]) -> list[dict[str, Any]]:
    """One entry per pose: its matrix, pairs, kinds, parts."""
    if len(poses) == 1:
        start = time.perf_counter()
        hit = scene.collide(tool, poses[0])
        seconds = time.perf_counter() - start
        return [
            {
                **_entry(scene.mockup, tool, 0, poses[0], hit.pairs, hit.kind_codes),
                "query_us": seconds * 1e6,
                "stats": dict(hit.stats),
            }
        ]
    with bar(f"querying {len(poses):,} poses") as progress:
        batch = scene.collide_batch(tool, poses, progress=progress)
    offsets = np.asarray(batch.offsets).astype(np.int64)
    pairs, kinds = np.asarray(batch.pairs), np.asarray(batch.kind_codes)
    return [
        _entry(scene.mockup, tool, i, poses[i], pairs[begin:end], kinds[begin:end])
        for i, (begin, end) in enumerate(pairwise(offsets))
    ]


def _entry(
    mockup: feeler.Mockup, tool: feeler.Tool, number: int, matrix: Any, pairs: Any, kinds: Any
) -> dict[str, Any]:
    return {
        "pose": number,
        "world_from_tool": matrix,
        "colliding": len(pairs) > 0,
        "pairs": len(pairs),
        "kinds": kind_counts(kinds),
        "parts": part_findings(mockup, tool, pairs, kinds) if len(pairs) else [],
    }


def _write(
    scene: feeler.Scene,
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
    mockup, there = scene.mockup, scene.part_mask
    if glb is not None:
        with bar(f"writing {glb}"):
            write_collision_glb(glb, mockup, tool, pose, collision, context=context, parts=there)
        written["glb"] = str(glb)
    if picture is not None:
        with bar("rendering") as progress:
            render_collision(picture, mockup, tool, pose, collision, size=pixels, parts=there, progress=progress)
        written["picture"] = str(picture)
    return written


def _print(
    tool: feeler.Tool,
    is_of_mockup: bool,
    scene: feeler.Scene,
    results: list[dict[str, Any]],
    worst: int,
    written: dict[str, str],
) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    facts = []
    out_of_it = np.count_nonzero(~scene.part_mask) - (tool.part_count if is_of_mockup else 0)
    for role, mesh in (("mock-up", scene.mockup), ("tool", tool)):
        report = mesh.report
        text = plural(report.triangles, "triangle")
        if role == "mock-up" or report.parts > 1:
            text += f", {plural(report.parts, 'part')}"
        if role == "mock-up" and out_of_it > 0:
            text += f" ({out_of_it:,} left out)"
        text += f", {outputs.extent(report.lower, report.upper)}"
        if role == "tool" and is_of_mockup:
            text = f"{tool.part_paths[0] if report.parts == 1 else 'parts'} of the mock-up: {text}"
        else:
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
        _print_one(out, results[0], tool.part_count > 1)
    else:
        _print_many(out, results, worst)
    for kind, path in written.items():
        where = "" if len(results) == 1 else f" of pose {worst}"
        outputs.say(out, f"{kind}{where} written to {path}")


def _print_one(out: Any, entry: dict[str, Any], has_tool_parts: bool) -> None:
    from feeler.cli import outputs

    query = f" (query: {outputs.duration(entry['query_us'] * 1e-6)})"
    inside = containment_lines(entry["inside"])
    for line in inside:
        outputs.print_finding(out, line)
    if not entry["pairs"]:
        out.print(f"The surfaces do not collide{query}" if inside else f"[bold green]No collision[/bold green]{query}")
    else:
        _print_parts(out, entry, has_tool_parts, query)
    for line in unknown_lines(entry["inside"]):
        outputs.say(out, line[:1].upper() + line[1:])


def _print_parts(out: Any, entry: dict[str, Any], has_tool_parts: bool, query: str) -> None:
    from feeler.cli import outputs

    parts = entry["parts"]
    kinds = ", ".join(f"{count:,} {kind}" for kind, count in entry["kinds"].items() if count)
    verdict = "[bold red]Collision[/bold red]" if entry["colliding"] else "[bold green]Contact only[/bold green]"
    out.print(f"{verdict}: {entry['pairs']:,} pairs ({kinds}) with {plural(len(parts), 'part')}{query}")
    out.print()
    outputs.print_table(
        out,
        "Colliding parts" if entry["colliding"] else "Parts in contact",
        [
            ("part", "left"),
            *([("by", "left")] if has_tool_parts else []),
            ("triangles hit", "right"),
            ("of the tool", "right"),
            ("pairs", "right"),
            *((kind, "right") for kind in entry["kinds"]),
        ],
        [
            (
                part["path"],
                *([_listed(part["tool_parts"])] if has_tool_parts else []),
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

    colliding = [entry for entry in results if entry["colliding"]]
    inside = [entry for entry in results if not entry["colliding"] and not entry["free"]]
    inside_told = any(containment_lines(entry["inside"]) for entry in results)
    colour = "red" if colliding or inside else "green"
    out.print(
        f"[bold {colour}]{len(colliding):,} of {len(results):,} poses collide[/bold {colour}]"
        + (f", and {len(inside):,}{' more' if colliding else ''} have one body inside the other" if inside else "")
        + (f"; most pairs: {results[worst]['pairs']:,} at pose {worst}" if colliding else "")
    )
    out.print()
    outputs.print_table(
        out,
        "Poses",
        [("pose", "right"), ("finding", "left"), ("pairs", "right"), ("parts", "right"), ("most pairs with", "left")]
        + ([("inside", "left")] if inside_told else []),
        [
            (
                str(entry["pose"]),
                _verdict(entry),
                f"{entry['pairs']:,}" if entry["pairs"] else "-",
                str(len(entry["parts"])) if entry["pairs"] else "-",
                entry["parts"][0]["path"] if entry["pairs"] else "",
                *(["; ".join(containment_lines(entry["inside"]))] if inside_told else []),
            )
            for entry in results[:_SHOWN_POSES]
        ],
        more=len(results) - _SHOWN_POSES,
    )


def _listed(paths: list[str]) -> str:
    more = len(paths) - _SHOWN_TOOL_PARTS
    return ", ".join(paths[:_SHOWN_TOOL_PARTS]) + (f" and {more:,} more" if more > 0 else "")


def _verdict(entry: dict[str, Any]) -> str:
    if entry["colliding"]:
        return "collides"
    return "inside" if not entry["free"] else "touches" if entry["pairs"] else "free"
