"""One collision as coloured bodies: mock-up triangles in red, tool triangles in orange."""

from __future__ import annotations

import os
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_flag, check_number, shown
from feeler.errors import OptionError
from feeler.io.body import (
    LIGHT_GREY,
    ORANGE,
    RED,
    STEEL_BLUE,
    TINT,
    Body,
    Mark,
    MeshLike,
    body_of,
    only_faces,
    with_marks,
)
from feeler.io.export import write_glb
from feeler.poses import PoseLike


class Hits(Protocol):
    """The triangles and parts to be coloured: a `feeler.Collision`, or a `feeler.Clearance` with triangles."""

    @property
    def tool_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: triangles of the tool."""

    @property
    def mockup_triangles(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: triangles of the mock-up."""

    @property
    def parts(self) -> npt.NDArray[np.uint32]:
        """`(k,)`: parts of the mock-up."""


def collision_bodies(
    mockup: MeshLike,
    tool: MeshLike,
    world_from_tool: PoseLike,
    collision: Hits,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
    grey: bool = True,
) -> tuple[Body, Body]:
    """The mock-up and the tool at its pose, coloured: colliding triangles red (mock-up) and orange (tool).

    Parts that are hit are tinted, the tool is blue, the rest is light grey, or, if `grey` is false, coloured by
    assembly. context: None keeps every part; a distance in metres keeps only parts whose box is that near to the tool's
    box (and all parts that are hit). parts: which parts are drawn, (parts,) bool, such as `scene.part_mask`; None: all.
    """
    if context is not None:
        context = check_number("context", context, "metres, 0 or more, or None", least=0.0, is_endless=True)
    check_flag("grey", grey)
    check_hits(collision)
    tool_body = body_of(tool, colours=STEEL_BLUE, pose=world_from_tool, cut=False)
    body = body_of(mockup, colours=LIGHT_GREY if grey else None)
    _check_same(body, tool_body, collision)
    tool_body = with_marks(tool_body, [Mark(np.asarray(collision.tool_triangles, dtype=np.int64), ORANGE)])
    is_hit = np.zeros(max(len(body.paths), 1), dtype=bool)
    is_hit[np.asarray(collision.parts, dtype=np.int64)] = True
    tinted = np.flatnonzero(is_hit[body.part_of_face])
    body = with_marks(body, [Mark(tinted, TINT), Mark(np.asarray(collision.mockup_triangles, dtype=np.int64), RED)])
    if context is None and parts is None:
        return body, tool_body
    drawn = is_hit | True if context is None else is_hit | _near_parts(body, tool_body.bounds, context)
    if parts is not None:
        drawn &= check_mask(parts, len(drawn))
    return only_faces(body, drawn[body.part_of_face]), tool_body


def check_hits(hits: object) -> None:
    """Raises `OptionError` for what has no triangles and parts."""
    if not all(hasattr(hits, name) for name in ("tool_triangles", "mockup_triangles", "parts")):
        raise OptionError(f"{shown(hits)} has no triangles to show: give a feeler.Collision or feeler.Clearance")


def _check_same(mockup: Body, tool: Body, hits: Hits) -> None:
    """Raises `OptionError` for hits of another mock-up or tool: triangles that they do not have, or of other parts."""
    given = (hits.parts, hits.mockup_triangles, hits.tool_triangles)
    parts, triangles, of_tool = (np.asarray(each, dtype=np.int64) for each in given)
    is_there = bool((triangles < len(mockup.faces)).all() and (parts < max(len(mockup.paths), 1)).all())
    if not is_there or not np.isin(mockup.part_of_face[triangles], parts).all():
        raise OptionError("the triangles are of another mock-up: give the mock-up that was queried")
    if (of_tool >= len(tool.faces)).any():
        raise OptionError("the triangles are of another tool: give the tool that was queried")


def check_mask(parts: npt.ArrayLike, count: int) -> npt.NDArray[np.bool_]:
    """Which parts are drawn, (count,) bool. Raises `OptionError` for others."""
    try:
        mask = np.asarray(parts)
    except ValueError:
        mask = np.empty(0)
    if mask.dtype != bool or mask.shape != (count,):
        raise OptionError(f"parts is {shown(parts)}: give True or False for each of {count} parts")
    return mask


def write_collision_glb(
    path: str | os.PathLike[str],
    mockup: MeshLike,
    tool: MeshLike,
    world_from_tool: PoseLike,
    collision: Hits,
    *,
    context: float | None = None,
    parts: npt.ArrayLike | None = None,
) -> int:
    """Writes `collision_bodies` as GLB; returns its size in bytes. Raises `WriteError`, `OptionError`."""
    body, tool_body = collision_bodies(mockup, tool, world_from_tool, collision, context=context, parts=parts)
    return write_glb(path, body, tool_body)


def _near_parts(body: Body, box: npt.NDArray[np.float64], distance: float) -> npt.NDArray[np.bool_]:
    """The parts with a box nearer than `distance` to `box`."""
    count = max(len(body.paths), 1)
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    order = np.argsort(body.part_of_face, kind="stable")
    parts, starts = np.unique(body.part_of_face[order], return_index=True)
    if len(starts):
        corners = body.vertices[body.faces[order]]
        lower[parts] = np.minimum.reduceat(corners.min(axis=1), starts, axis=0)
        upper[parts] = np.maximum.reduceat(corners.max(axis=1), starts, axis=0)
    gap = np.maximum(np.maximum(lower - box[1], box[0] - upper), 0.0)
    return np.asarray(np.square(gap).sum(axis=1) <= distance * distance)
