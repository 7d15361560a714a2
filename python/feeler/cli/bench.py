"""`feeler bench`: how fast is feeler on this machine, with these files?"""

from __future__ import annotations

import time
from typing import Annotated, Any

import numpy as np
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import POSE_KINDS, STORAGES, PoseKind
from feeler.cli.app import command
from feeler.cli.findings import mesh_facts, scene_facts
from feeler.cli.inputs import AsJson, BuildThreads, Hashing, MockupUnit, Storage, ToolUnit, Up, VoxelSize, read_both
from feeler.cli.values import POSES, SEED
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.words import plural


@command(
    examples="""
feeler bench
feeler bench engine.step --tool wrench.stl
feeler bench sample:engine:1600000 --tool sample:hand --poses 500 --json
"""
)
def bench(
    mockup: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MOCKUP",
            help="Files or folders (several are one mock-up), or sample:NAME[:TRIANGLES[:SEED[:FAULTS]]].",
            show_default="sample:engine:100000",
        ),
    ] = None,
    tool: Annotated[
        str, typer.Option(metavar="FILE", help="A file, or sample:NAME or sample:NAME:fine.")
    ] = "sample:wrench",
    poses: Annotated[int, typer.Option(help="Poses of each kind."), POSES] = 200,
    kinds: Annotated[
        str, typer.Option(metavar="LIST", help="Which poses, split by commas: nominal, near, deep.")
    ] = "nominal,near",
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    voxel_size: VoxelSize = None,
    storage: Storage = "blocks",
    hashing: Hashing = 0.0,
    threads: BuildThreads = None,
    seed: Annotated[int, typer.Option(help="Another seed, other poses."), SEED] = 0,
    as_json: AsJson = False,
) -> None:
    """Measures build time, memory and query times.

    Poses: nominal (1 to 5 % of the tool's triangles collide), near (inside the mock-up, nothing collides), deep.
    """
    from feeler.cli import outputs

    chosen = [check_word("--kinds", kind.strip(), POSE_KINDS) for kind in kinds.split(",") if kind.strip()]
    if not chosen:
        raise OptionError(f"--kinds is {kinds!r}: choose from {', '.join(POSE_KINDS)}, split by commas")
    world, probe = read_both(mockup or ["sample:engine:100000"], unit, tool, tool_unit, up)
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
    rows = [_measure(scene, probe, kind, poses, seed) for kind in chosen]
    if as_json:
        outputs.print_json(
            {"mockup": mesh_facts(world), "tool": mesh_facts(probe), "scene": scene_facts(scene), "runs": rows}
        )
        return
    _print(scene, probe, rows)


def _measure(scene: feeler.Scene, tool: feeler.Tool, kind: PoseKind, count: int, seed: int) -> dict[str, Any]:
    """One row: times of single queries, and the rate of the whole batch on all threads."""
    from feeler.cli.measure import collide_each, warm_up
    from feeler.cli.outputs import times

    with bar(f"looking for {kind} poses") as progress:
        poses = np.asarray(feeler.sample_poses(scene, tool, kind, count, seed=seed, progress=progress))
    with bar(f"measuring {kind}") as progress:
        warm_up(scene, tool, poses)
        seconds, hits = collide_each(scene, tool, poses, progress)
        start = time.perf_counter()
        scene.collide_batch(tool, poses)
        batch = time.perf_counter() - start
    pairs = np.array([len(hit.pairs) for hit in hits])
    return {
        "kind": kind,
        **times(seconds),
        "batch_queries_per_s": len(poses) / batch,
        "median_pairs": float(np.median(pairs)),
    }


def _print(scene: feeler.Scene, tool: feeler.Tool, rows: list[dict[str, Any]]) -> None:
    from feeler.cli import outputs

    out, facts = outputs.console(), scene_facts(scene)
    memory = facts["memory_bytes"]["total"]
    cell = "piece size" if scene.storage == "blocks" else "voxel size"
    outputs.print_facts(
        out,
        [
            (
                "mock-up",
                f"{plural(scene.mockup.triangle_count, 'triangle')}, {plural(scene.mockup.part_count, 'part')}",
            ),
            ("tool", f"{tool.name}, {plural(tool.triangle_count, 'triangle')}"),
            ("storage", f"{scene.storage}, {cell} {outputs.length(scene.voxel_size)}"),
            ("build", outputs.duration(scene.build_seconds)),
            ("memory", f"{outputs.size(memory)}, {facts['bytes_per_triangle']:.0f} bytes a triangle"),
        ],
    )
    out.print()
    microseconds = [(heading, "right") for heading in ("median", "p95", "p99", "worst")]
    outputs.print_table(
        out,
        "Queries: all pairs, one thread; the batch on all threads",
        [("poses", "left"), ("pairs", "right"), *microseconds, ("per second", "right"), ("batch", "right")],
        [
            (
                row["kind"],
                f"{row['median_pairs']:,.0f}",
                *(outputs.duration(row[f"{name}_us"] * 1e-6) for name in ("median", "p95", "p99", "worst")),
                f"{row['queries_per_s']:,.0f}",
                f"{row['batch_queries_per_s']:,.0f}",
            )
            for row in rows
        ],
    )
