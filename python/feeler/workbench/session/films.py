"""The sequence of removals as a film: its lines as ways, with the gaps along each."""

from __future__ import annotations

import numpy as np

from feeler.mockup import Tool
from feeler.poses import inverse
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.words import length_in
from feeler.workbench.document import motion
from feeler.workbench.document.answers import FilmWay, Gap
from feeler.workbench.document.document import Document, Removal
from feeler.workbench.document.line_facts import least_clearance, line_steps
from feeler.workbench.document.motion import Floats, Row
from feeler.workbench.engine.gaps import Gaps, gap_json
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.world import World
from feeler.workbench.session.answering import spread


def ways(document: Document, scene: Scene, meshes: PartTools, progress: Progress) -> list[FilmWay]:
    """The lines of the sequence, each in the mock-up as the lines before it leave it."""
    found: list[FilmWay] = []
    lines = document.sequence
    in_lines = {part for line in lines for part in line.parts}
    # Parts that no line moves lie where they are now; the others where their first line began.
    moved = {part: at for part, at in document.moved.items() if part not in in_lines}
    for line in reversed(lines):
        moved.update(_starts(line))
    # Parts that are out do not hinder others, as when a line is replayed by hand.
    out = {part for part in document.out if part not in in_lines}
    for number, line in enumerate(lines):
        progress(number / len(lines), "film")
        way = np.stack([motion.matrix(pose) for pose in line.way])
        motions = way @ inverse(way[0])
        starts = _starts(line)
        out -= {*line.parts}
        there = {part: at for part, at in moved.items() if part not in line.parts and part not in out}
        around = World(scene, meshes, there, {*line.parts, *document.gripped, *out})
        found.append(_way(document, line, motions, around, meshes, scene.mockup.part_bounds))
        for part in line.parts:
            moved[part] = motion.row(motions[-1] @ motion.matrix(starts.get(part, motion.HOME)))
        out |= {part for part in line.parts if part in document.out}
    return found


def _starts(line: Removal) -> dict[int, Row]:
    return {part: row for part, row in line.starts if part in line.parts}


def _way(
    document: Document, line: Removal, motions: Floats, around: World, meshes: PartTools, bounds: Floats
) -> FilmWay:
    starts = _starts(line)
    items: dict[str, Tool | tuple[Tool, Floats]] = {
        str(part): (meshes.of(part)[0], motion.matrix(starts.get(part, motion.HOME))) for part in line.parts
    }
    moving = Tool.assembly(items, line.name)
    poses, shares = spread(motions, moving.bounds)
    nearest = Gaps(around, moving, poses[0])
    gaps: list[Gap] = [gap_json(share, nearest.at(pose)) for pose, share in zip(poses, shares, strict=True)]
    steps, turns = line_steps(line, motions, bounds)
    travel = sum(steps)
    return {
        "id": line.id,
        "parts": list(line.parts),
        "poses": [list(motion.row(pose)) for pose in motions],
        "starts": {str(part): list(row) for part, row in starts.items()},
        "clearance": least_clearance(document, line),
        "legs": [f"{length_in(travel, document.unit)} by hand"],
        "length": travel,
        "rotation": sum(turns),
        "gaps": gaps,
    }
