"""Lines as thin three-sided bars, which every viewer shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_list, check_number, check_text
from feeler.errors import OptionError
from feeler.io.body import RED, Body, Colour

LEAST_THICKNESS_M = 2e-5


def bars(
    start: npt.NDArray[np.float64],
    end: npt.NDArray[np.float64],
    thickness: float,
    paths: Sequence[str],
    colour: Colour = RED,
) -> Body | None:
    """A bar between each two points `(k, 3)`, metres, with its path, if it has a length. None if none has."""
    start, end = check_array("start", start, (None, 3)), check_array("end", end, (None, 3))
    thickness = check_number("thickness", thickness, "metres, more than 0", above=0.0)
    paths = [check_text("paths", path) for path in check_list("paths", paths, "a path for each bar")]
    if not len(start) == len(end) == len(paths):
        raise OptionError(
            f"there are {len(start)} starts, {len(end)} ends and {len(paths)} paths: give as many of each"
        )
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
        paths=tuple(paths[int(row)] for row in kept),
        palette=check_array("colour", colour, (3,))[None],
        colour_of_face=np.zeros(len(all_faces), dtype=np.int64),
        cut=False,
    )
