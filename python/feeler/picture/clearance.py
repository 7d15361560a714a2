"""What is near the tool, as coloured bodies: a thin bar from the tool to each part's closest point."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.io.body import RED, Body
from feeler.io.export import write_glb
from feeler.picture.collision import collision_bodies

_THICKNESS_SHARE = 0.002  # of the tool's size
_LEAST_THICKNESS_M = 2e-5


def clearance_bodies(
    mockup: Any,
    tool: Any,
    world_from_tool: npt.ArrayLike,
    clearance: Any,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
) -> tuple[Body, ...]:
    """The mock-up, the tool at its pose, and the witness lines, coloured.

    Parts that are listed are tinted, the triangles that hold closest points red (mock-up) and orange (tool), lines red.
    A line is a bar of three sides, as thick as 0.2 % of the tool, so that any viewer shows it; where tool and part
    meet, it has no length and is left out. context, parts: as for `collision_bodies`.
    """
    body, tool_body = collision_bodies(mockup, tool, world_from_tool, clearance, context=context, parts=parts)
    size = float(np.linalg.norm(tool_body.bounds[1] - tool_body.bounds[0]))
    lines = _bars(clearance, max(_THICKNESS_SHARE * size, _LEAST_THICKNESS_M))
    return (body, tool_body) if lines is None else (body, tool_body, lines)


def write_clearance_glb(
    path: str | os.PathLike[str],
    mockup: Any,
    tool: Any,
    world_from_tool: npt.ArrayLike,
    clearance: Any,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
) -> int:
    """Writes `clearance_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    return write_glb(path, *clearance_bodies(mockup, tool, world_from_tool, clearance, context=context, parts=parts))


def _bars(clearance: Any, thickness: float) -> Body | None:
    """One bar for each row whose points differ."""
    start, end = np.asarray(clearance.points_on_tool), np.asarray(clearance.points_on_mockup)
    kept = np.flatnonzero(np.abs(end - start).max(axis=1, initial=0.0) > 0.0)
    if not len(kept):
        return None
    start, end = start[kept], end[kept]
    along = end - start
    along /= np.abs(along).max(axis=1, keepdims=True)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    one = np.cross(along, least)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    two = np.cross(along, one)
    angles = 2.0 * np.pi * np.arange(3) / 3.0
    ring = 0.5 * thickness * (np.cos(angles)[:, None, None] * one + np.sin(angles)[:, None, None] * two)
    corners = np.concatenate([start + ring, end + ring]).transpose(1, 0, 2).reshape(-1, 3)
    sides = [face for i in range(3) for face in ([i, (i + 1) % 3, 3 + i], [(i + 1) % 3, 3 + (i + 1) % 3, 3 + i])]
    faces = np.array([*sides, [0, 2, 1], [3, 4, 5]], dtype=np.uint32)
    all_faces = (faces[None] + 6 * np.arange(len(kept), dtype=np.uint32)[:, None, None]).reshape(-1, 3)
    return Body(
        vertices=corners,
        faces=all_faces,
        part_of_face=np.repeat(np.arange(len(kept)), len(faces)),
        paths=tuple(f"witness lines/{row} to part {int(clearance.parts[row])}" for row in kept),
        palette=np.array([RED]),
        colour_of_face=np.zeros(len(all_faces), dtype=np.int64),
        cut=False,
    )
