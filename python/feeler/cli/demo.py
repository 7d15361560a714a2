"""`feeler demo`: a complete run on a built-in engine, in under a minute."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.cli.app import command
from feeler.cli.findings import mesh_facts, scene_facts
from feeler.cli.inputs import AsJson
from feeler.cli.values import COUNT, Word
from feeler.progress import bar

_POSES = 1000
_SHOWN_PARTS = 12
_DIRECTION, _UP = (0.75, -0.42, 0.55), (0.0, 1.0, 0.0)  # of the picture: the engine lies along z


@command(
    examples="""
feeler demo
feeler demo --triangles 200000 --out /tmp/demo
feeler demo --json
"""
)
def demo(
    triangles: Annotated[int, typer.Option(help="Size of the engine."), COUNT] = 1_600_000,
    tool: Annotated[
        str, typer.Option(help="Built-in tool to move."), Word(("torque", "wrench", "square", "hand"))
    ] = "wrench",
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder for the picture, the GLB and the pose.")] = Path(
        "feeler-demo"
    ),
    as_json: AsJson = False,
) -> None:
    """Moves a wrench in and out of an engine of 1.6 million triangles and reports its collisions."""
    from feeler.cli import outputs
    from feeler.cli.measure import collide_each, warm_up

    _make_folder(out)
    with bar("making the engine") as progress:
        engine = feeler.sample("engine", triangles, progress=progress)
    probe = feeler.sample_tool(check_word("--tool", tool, SAMPLE_TOOL_NAMES))
    predicted = feeler.optimal_voxel_size(engine, probe)
    with bar("indexing") as progress:
        scene = feeler.Scene(engine, tool=probe, progress=progress)
    with bar("planning the path") as progress:
        path = np.asarray(feeler.sample_path(scene, probe, _POSES, progress=progress))
    with bar("moving the tool") as progress:
        warm_up(scene, probe, path)
        seconds, hits = collide_each(scene, probe, path, progress)
    deepest = max(range(len(hits)), key=lambda i: len(hits[i].pairs))
    files = _write(out, engine, probe, path[deepest], hits[deepest])
    findings = _parts_on_path(engine, hits)
    colliding = np.array([len(hit.pairs) > 0 for hit in hits])
    next_command = _next_command(files["pose"])
    if as_json:
        outputs.print_json(
            {
                "mockup": mesh_facts(engine),
                "tool": mesh_facts(probe),
                "predicted_voxel_size_m": predicted,
                "scene": scene_facts(scene),
                "path": {"poses": len(path), "colliding": int(colliding.sum()), "deepest": deepest},
                "queries": outputs.times(seconds),
                "colliding_queries": outputs.times(seconds[colliding]),
                "deepest_pairs": len(hits[deepest].pairs),
                "parts": findings,
                "files": files,
                "next": next_command,
            }
        )
        return
    _print(scene, probe, predicted, seconds, colliding, findings, len(hits[deepest].pairs))
    console = outputs.console()
    for name, file in files.items():
        outputs.say(console, f"{name + ' of the deepest moment:':32}{file}")
    outputs.say(console, f"The same with your own files: {next_command}")


def _make_folder(folder: Path) -> None:
    from feeler.io import WriteError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WriteError(f"cannot make the folder {folder}: {error.strerror or error}; choose another --out") from None


def _write(
    folder: Path, mockup: feeler.Mockup, tool: feeler.Tool, pose: npt.NDArray[np.float64], hit: Any
) -> dict[str, str]:
    from feeler.atomic import atomic_file
    from feeler.picture import render_collision, write_collision_glb

    files = {"picture": folder / "deepest.png", "glb": folder / "deepest.glb", "pose": folder / "pose.json"}
    with bar("rendering the picture") as progress:
        render_collision(files["picture"], mockup, tool, pose, hit, direction=_DIRECTION, up=_UP, progress=progress)
    with bar("writing the GLB"):
        write_collision_glb(files["glb"], mockup, tool, pose, hit)
    with atomic_file(files["pose"]) as file:
        file.write(json.dumps({"world_from_tool": pose.tolist()}, indent=1).encode() + b"\n")
    return {name: str(path) for name, path in files.items()}


def _parts_on_path(mockup: feeler.Mockup, hits: list[Any]) -> list[dict[str, Any]]:
    """The parts hit along the path: number of poses, and most triangles at once; most poses first."""
    part_of_face = np.asarray(mockup.part_of_face)
    poses: dict[int, int] = {}
    most: dict[int, int] = {}
    for hit in hits:
        parts, counts = np.unique(part_of_face[hit.mockup_triangles], return_counts=True)
        for part, count in zip(parts.tolist(), counts.tolist(), strict=True):
            poses[part] = poses.get(part, 0) + 1
            most[part] = max(most.get(part, 0), count)
    return [
        {"part": part, "path": mockup.part_paths[part], "poses": poses[part], "most_triangles": most[part]}
        for part in sorted(poses, key=lambda part: (-poses[part], -most[part], part))
    ]


def _next_command(pose_file: str) -> str:
    words = ["feeler", "collide", "YOUR_MOCKUP.step", "--tool", "YOUR_TOOL.stl", "--pose", pose_file]
    return shlex.join([*words, "--glb", "hit.glb", "--picture", "hit.png"])


def _print(
    scene: feeler.Scene,
    tool: feeler.Tool,
    predicted: float,
    seconds: npt.NDArray[np.float64],
    colliding: npt.NDArray[np.bool_],
    findings: list[dict[str, Any]],
    deepest: int,
) -> None:
    from feeler.cli import outputs

    out, report, times = outputs.console(), scene.mockup.report, outputs.times(seconds)
    facts, memory = scene_facts(scene), dict(scene.memory())
    total = memory.pop("total")
    structures = ", ".join(f"{name.replace('_', ' ')} {outputs.size(count)}" for name, count in memory.items() if count)
    outputs.print_facts(
        out,
        [
            (
                "engine",
                f"{report.triangles:,} triangles, {report.parts:,} parts, {outputs.extent(report.lower, report.upper)}",
            ),
            ("tool", f"{tool.name}, {tool.triangle_count:,} triangles"),
            (
                "voxel size",
                f"{outputs.length(predicted)} predicted for voxels; "
                f"piece size of the blocks {outputs.length(scene.voxel_size)}",
            ),
            ("build", outputs.duration(facts["build_s"])),
            ("memory", f"{outputs.size(total)}, {facts['bytes_per_triangle']:.0f} bytes a triangle ({structures})"),
            ("path", f"{len(seconds):,} poses in and out, {colliding.sum():,} collide, up to {deepest:,} pairs"),
            ("speed", f"{times['queries_per_s']:,.0f} queries a second on one thread, every pair found"),
            ("query time", _percentiles(seconds)),
            ("", f"{_percentiles(seconds[colliding])}, of the poses that collide"),
        ],
    )
    out.print()
    outputs.print_table(
        out,
        f"Collisions of {tool.name} on its path: {len(findings):,} parts",
        [("part", "left"), ("poses", "right"), ("most triangles at once", "right")],
        [(f["path"], f"{f['poses']:,}", f"{f['most_triangles']:,}") for f in findings[:_SHOWN_PARTS]],
        more=len(findings) - _SHOWN_PARTS,
    )
    out.print()


def _percentiles(seconds: npt.NDArray[np.float64]) -> str:
    from feeler.cli.outputs import duration, times

    if not len(seconds):
        return "none"
    found = times(seconds)
    return ", ".join(f"{name} {duration(found[f'{name}_us'] * 1e-6)}" for name in ("median", "p99", "worst"))
