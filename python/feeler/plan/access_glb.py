"""The results of `access` as GLB: the tool at each target, and its blockers."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from feeler.errors import OptionError
from feeler.io.body import LIGHT_GREY, ORANGE, RED, STEEL_BLUE, Body, Colour, body_of
from feeler.io.export import write_glb
from feeler.mockup import Mockup, Tool
from feeler.plan.catalogue import Catalogue, shaped, tool_of
from feeler.plan.reach import Access, Reach

GREEN: Colour = (0.30, 0.62, 0.36)
TARGET, UNREACHED = STEEL_BLUE, ORANGE


def access_bodies(mockup: Mockup, tool: Tool | Catalogue, found: Access, hand: Tool | None = None) -> tuple[Body, ...]:
    """The mock-up, and the tool seated at each target, coloured.

    The tool is green at reachable targets, in the middle of its swing, and orange at others. Fasteners are blue,
    blockers of unreachable targets red, the rest is light grey. `tool`, `hand`: as `access` took
    them.
    """
    colours = np.tile(np.array(LIGHT_GREY), (mockup.part_count, 1))
    for row in found:
        for part, path in [(row.part, row.path), *((each.part, each.path) for each in row.blockers)]:
            if part is not None and not (part < mockup.part_count and mockup.part_paths[part] == path):
                raise OptionError(f"part {path!r} is not in this mock-up: pass the mock-up of the access check")
        if row.part is not None:
            colours[row.part] = TARGET
    for each in found.blockers:
        colours[each.part] = RED
    bodies = [body_of(mockup, colours=colours)]
    for row in found:
        used = _used(tool, row, hand)
        if used is None:
            continue
        body = body_of(used, colours=GREEN if row.is_reachable else UNREACHED, pose=row.pose)
        name = f"{used.name} at targets/{row.target} {'reachable' if row.is_reachable else 'not reachable'}"
        paths = (name,) if len(body.paths) == 1 else tuple(f"{name}/{path}" for path in body.paths)
        bodies.append(replace(body, paths=paths))
    return tuple(bodies)


def _used(tool: Tool | Catalogue, row: Reach, hand: Tool | None) -> Tool | None:
    """The tool at a target, with its hand; None if none of a catalogue fits."""
    place = np.eye(4)
    if isinstance(tool, Catalogue):
        name = row.tool or row.nearest
        if name is None:
            return None
        pieces = tool.pieces(name)
        tool, place = tool_of(pieces), shaped(pieces).grip
    return tool if hand is None else Tool.assembly({"tool": tool, "hand": (hand, place)}, name=tool.name)


def write_access_glb(
    path: str | os.PathLike[str], mockup: Mockup, tool: Tool | Catalogue, found: Access, hand: Tool | None = None
) -> int:
    """Writes `access_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    return write_glb(path, *access_bodies(mockup, tool, found, hand))
