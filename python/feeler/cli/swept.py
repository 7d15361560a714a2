"""`feeler swept`: writes the swept volume of a tool as a closed mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import feeler
from feeler.cli.app import command
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import AsJson, SnapPose, Threads, ToolUnit, Up, check_unit, read_poses, read_tool
from feeler.cli.values import POSITIVE_LENGTH
from feeler.progress import bar
from feeler.words import volume as volume_text

_FLOAT32 = float(np.finfo(np.float32).eps)
_ROUNDING_SHARE = 0.1  # of the error: more rounding in a file raises a warning


@command(
    examples="""
feeler swept wrench.stl --poses way_out.npy --error 1mm --out swept.glb
feeler swept sample:wrench --poses way_out.csv --error 0.002 --out swept.stl --json
"""
)
def swept(
    tool: Annotated[str, typer.Argument(metavar="TOOL", help="Mesh file, or sample:NAME[:fine].")],
    *,
    poses: Annotated[
        Path,
        typer.Option(
            help="world_from_tool, metres, one after the other: (n, 4, 4) as .npy or JSON, or as text or CSV with 16 "
            "numbers a pose, row by row.",
        ),
    ],
    error: Annotated[
        float, typer.Option(help="How far the mesh may exceed the swept volume."), POSITIVE_LENGTH
    ] = 0.001,
    snap_pose: SnapPose = False,
    tool_unit: ToolUnit = None,
    up: Up = None,
    threads: Threads = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Write it: .glb in metres, .stl in millimetres. Without it: figures only."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Makes a closed mesh around the swept volume of a tool that moves from pose to pose.

    Between two poses the middle of the tool's box moves straight and the tool turns about it, the shorter way round.
    Half the error makes four times the triangles. Exit status: 0 done, 2 bad input.
    """
    from feeler.cli import outputs

    if out is not None:
        outputs.check_mesh_target(out)
    check_unit("--tool-unit", tool_unit, tool)
    way = read_poses(poses, snap_pose)
    probe = read_tool(tool, tool_unit, up)
    for doubt in probe.source.doubts:
        outputs.warn(f"tool: {doubt}")
    with bar(f"sweeping along {len(way):,} poses") as progress:
        mesh = feeler.swept(probe, way, error, threads=threads, progress=progress)
    size = None
    if out is not None:
        rounding = _FLOAT32 * float(np.abs(mesh.bounds).max())
        if out.suffix.lower() == ".stl" and rounding > _ROUNDING_SHARE * error:
            outputs.warn(
                f"{out}: numbers in an STL are rounded, here by up to {outputs.length(rounding)}; write a .glb, which "
                "has an origin near the mesh"
            )
        with bar(f"writing {out}"):
            size = outputs.write_mesh(out, mesh)
    volume, area = measures(mesh)
    facts = mesh_facts(mesh)
    if as_json:
        outputs.print_json(
            {
                "triangles": mesh.triangle_count,
                "volume_m3": volume,
                "area_m2": area,
                "lower": mesh.bounds[0],
                "upper": mesh.bounds[1],
                "error_m": error,
                "poses": len(way),
                "seconds": mesh.source.seconds,
                "tool": mesh_facts(probe),
                "mesh": facts,
                "out": None if out is None else str(out),
                "bytes": size,
            }
        )
        return
    rows = [
        ("poses", f"{len(way):,}"),
        ("triangles", f"{mesh.triangle_count:,} ({outputs.duration(mesh.source.seconds)})"),
        ("volume", volume_text(volume)),
        ("extent", outputs.extent(mesh.bounds[0], mesh.bounds[1])),
        ("error", f"{outputs.length(error)} at most, outwards only"),
    ]
    if size is not None:
        rows.append(("written", f"{out} ({outputs.size(size)})"))
    outputs.print_facts(outputs.console(), rows)


def measures(mesh: feeler.Mockup) -> tuple[float, float]:
    """Volume (cubic metres) and area (square metres) of a closed mesh, wound outwards."""
    middle = mesh.bounds.mean(axis=0)  # near the mesh, so that no digits are lost far from the origin
    a, b, c = np.moveaxis((mesh.vertices - middle)[mesh.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    return float(np.einsum("ij,ij->", a, normals)) / 6, float(np.linalg.norm(normals, axis=1).sum()) / 2
