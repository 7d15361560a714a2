"""`feeler index`: saves a mock-up with its index, ready for all commands."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Annotated

import typer

import feeler
from feeler.atomic import check_target
from feeler.cli.app import command
from feeler.cli.inputs import (
    AsJson,
    BuildThreads,
    ChordTolerance,
    MockupFiles,
    MockupUnit,
    Up,
    VoxelSize,
    read_mockup,
    warn_of_doubts,
)
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.saved import SUFFIX


@command(
    examples="""
feeler index engine.step -o engine.feeler
feeler index plant/ --unit mm --up z -o plant.feeler
feeler clash engine.feeler
feeler view engine.feeler
"""
)
def index(
    mockup: MockupFiles,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help=f"The file to write; default: the mock-up's name with {SUFFIX}, here."),
    ] = None,
    unit: MockupUnit = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    voxel_size: VoxelSize = None,
    threads: BuildThreads = None,
    as_json: AsJson = False,
) -> None:
    """Saves a mock-up with its index in one file that opens in milliseconds.

    Every command takes such a file where it takes a mock-up, and several processes share its memory.
    """
    from feeler.cli import outputs

    target = check_target(out if out is not None else _default(mockup))
    if target.suffix.lower() != SUFFIX:
        raise OptionError(f"--out is {target}: the name of a saved scene ends in {SUFFIX}")
    if any(os.path.exists(source) and target.exists() and target.samefile(source) for source in mockup):
        raise OptionError(f"--out is {target}, which is the mock-up itself: choose another name")
    start = time.perf_counter()
    world = read_mockup(mockup, unit, up, chord_tolerance=chord_tolerance)
    warn_of_doubts(world)
    with bar("building index") as progress:
        scene = feeler.Scene(world, voxel_size, threads=threads, progress=progress)
    with bar(f"saving {target}") as progress:
        content = scene.save(target, progress=progress)
    seconds, size = time.perf_counter() - start, target.stat().st_size
    report = world.report
    if as_json:
        outputs.print_json(
            {
                "out": str(target),
                "bytes": size,
                "content_hash": content,
                "voxel_size": scene.voxel_size,
                "seconds": seconds,
                **report.to_dict(),
            }
        )
        return
    outputs.print_facts(
        outputs.console(),
        [
            ("triangles", f"{report.triangles:,}"),
            ("parts", f"{report.parts:,}"),
            ("extent", outputs.extent(report.lower, report.upper)),
            ("written", f"{target} ({outputs.size(size)}) in {seconds:.1f} s"),
            ("content", content),
        ],
    )


def _default(sources: list[str]) -> Path:
    """The name of the first source, with the extension of saved scenes."""
    if sources[0].startswith("sample:"):
        return Path(sources[0].split(":")[1] + SUFFIX)
    return Path((Path(sources[0]).stem or "mockup") + SUFFIX)
