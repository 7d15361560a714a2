"""Clearances as coloured bodies: a thin bar from the tool to each near part's closest point."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt

from feeler._core import Clearance
from feeler.arguments import shown
from feeler.errors import OptionError
from feeler.io.body import Body, MeshLike
from feeler.io.export import write_glb
from feeler.picture.bars import LEAST_THICKNESS_M, bars
from feeler.picture.collision import collision_bodies
from feeler.poses import PoseLike

_THICKNESS_SHARE = 0.002  # of the tool's size


def clearance_bodies(
    mockup: MeshLike,
    tool: MeshLike,
    world_from_tool: PoseLike,
    clearance: Clearance,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
) -> tuple[Body, ...]:
    """The mock-up, the tool at its pose, and the witness lines, coloured.

    Listed parts are tinted, the triangles of closest points red (mock-up) and orange (tool), lines red. A line is a bar
    of three sides, as thick as 0.2 % of the tool, which every viewer shows; it is left out where tool and part collide.
    context, parts: as for `collision_bodies`.
    """
    if not hasattr(clearance, "points_on_tool"):
        raise OptionError(f"clearance is {shown(clearance)}: give a feeler.Clearance")
    body, tool_body = collision_bodies(mockup, tool, world_from_tool, clearance, context=context, parts=parts)
    size = float(np.linalg.norm(tool_body.bounds[1] - tool_body.bounds[0]))
    start, end = np.asarray(clearance.points_on_tool), np.asarray(clearance.points_on_mockup)
    paths = [f"witness lines/{row} to part {int(part)}" for row, part in enumerate(clearance.parts)]
    lines = bars(start, end, max(_THICKNESS_SHARE * size, LEAST_THICKNESS_M), paths)
    return (body, tool_body) if lines is None else (body, tool_body, lines)


def write_clearance_glb(
    path: str | os.PathLike[str],
    mockup: MeshLike,
    tool: MeshLike,
    world_from_tool: PoseLike,
    clearance: Clearance,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
) -> int:
    """Writes `clearance_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    return write_glb(path, *clearance_bodies(mockup, tool, world_from_tool, clearance, context=context, parts=parts))
