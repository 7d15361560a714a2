"""The results of `access` as GLB: the tool at each target, and its blockers."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from feeler.errors import OptionError
from feeler.io.body import LIGHT_GREY, ORANGE, RED, STEEL_BLUE, Body, Colour, body_of
from feeler.io.export import write_glb
from feeler.mockup import Mockup, Tool
from feeler.plan.reaching import Access

GREEN: Colour = (0.30, 0.62, 0.36)
TARGET, UNREACHED = STEEL_BLUE, ORANGE


def access_bodies(mockup: Mockup, tool: Tool, found: Access) -> tuple[Body, ...]:
    """The mock-up, and the tool seated at each target, coloured.

    The tool is green at reachable targets, in the middle of its swing, and orange at others. Fasteners are blue,
    blockers of unreachable targets red, the rest is light grey. `tool`: with its hand, if there was one
    (`Tool.assembly`).
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
        body = body_of(tool, colours=GREEN if row.is_reachable else UNREACHED, pose=row.pose)
        name = f"{tool.name} at targets/{row.target} {'reachable' if row.is_reachable else 'not reachable'}"
        paths = (name,) if len(body.paths) == 1 else tuple(f"{name}/{path}" for path in body.paths)
        bodies.append(replace(body, paths=paths))
    return tuple(bodies)


def write_access_glb(path: str | os.PathLike[str], mockup: Mockup, tool: Tool, found: Access) -> int:
    """Writes `access_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    return write_glb(path, *access_bodies(mockup, tool, found))
