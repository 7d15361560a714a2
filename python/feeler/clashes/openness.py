"""Finds open parts that may contain others, which a check cannot decide."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes

Ints = npt.NDArray[np.intp]
Floats = npt.NDArray[np.float64]


def open_holders(
    mockup: Mockup,
    a: npt.NDArray[np.uint32],
    b: npt.NDArray[np.uint32],
    is_open: npt.NDArray[np.bool_],
    present: npt.NDArray[np.bool_],
) -> list[int]:
    """The open parts whose box contains the box of another part, ascending.

    a, b, is_open: the pairs of the check, and whether their parts are open. present: `(parts,)`, the parts of the
    scene. Examines only parts with another box inside their box, so it costs little.
    """
    known = np.full(mockup.part_count, -1, dtype=np.int8)
    known[a], known[b] = is_open[:, 0], is_open[:, 1]
    holders = [part for part in _holders(mockup, present) if known[part] != 0]
    if not holders:
        return []
    meshes = PartMeshes(mockup)
    return [part for part in holders if known[part] == 1 or _has_rim(meshes.corners(part))]


def _holders(mockup: Mockup, present: npt.NDArray[np.bool_]) -> list[int]:
    """The parts whose box contains the box of another part, ascending."""
    return _holders_of(mockup.part_bounds.tobytes(), present.tobytes())


@lru_cache(maxsize=2)  # requirements are many questions about one scene
def _holders_of(boxes: bytes, present: bytes) -> list[int]:
    bounds = np.frombuffer(boxes).reshape(-1, 2, 3)
    parts = np.flatnonzero(np.frombuffer(present, dtype=bool) & (bounds[:, 0] <= bounds[:, 1]).all(axis=1))
    return [int(part) for part in parts[_containing(bounds[parts, 0], bounds[parts, 1])]]


_CHILDREN = 8  # of a node; only costs time
_AT_ONCE = 1 << 14  # boxes that go down the tree together; only costs memory
_CELLS = 1 << 10  # along each axis, for the order of boxes


class _Level(NamedTuple):
    """Nodes of a tree of boxes: the least and largest lower and upper corners, and how many boxes each node has."""

    low_least: Floats
    low_most: Floats
    high_least: Floats
    high_most: Floats
    boxes: Ints


def _containing(low: Floats, high: Floats) -> npt.NDArray[np.bool_]:
    """Whether each box, (n, 3) lower and (n, 3) upper corners, contains another one, or is equal to one.

    All boxes go down a tree of boxes together, level by level, so the time is about in proportion to the boxes.
    """
    found = np.zeros(len(low), dtype=bool)
    if len(low) < 2:
        return found
    order = _near_each_other(low, high)
    low, high = low[order], high[order]
    levels = [_Level(low, low, high, high, np.ones(len(low), dtype=np.intp))]
    while len(levels[-1].boxes) > _CHILDREN:
        below, starts = levels[-1], np.arange(0, len(levels[-1].boxes), _CHILDREN)
        levels.append(
            _Level(
                np.minimum.reduceat(below.low_least, starts),
                np.maximum.reduceat(below.low_most, starts),
                np.minimum.reduceat(below.high_least, starts),
                np.maximum.reduceat(below.high_most, starts),
                np.add.reduceat(below.boxes, starts),
            )
        )
    holds = np.zeros(len(low), dtype=bool)
    for start in range(0, len(low), _AT_ONCE):
        boxes = np.arange(start, min(start + _AT_ONCE, len(low)))
        top = len(levels[-1].boxes)
        box, node = np.repeat(boxes, top), np.tile(np.arange(top), len(boxes))
        for depth in range(len(levels) - 1, -1, -1):
            level = levels[depth]
            inside = (level.low_least[node] >= low[box]).all(axis=1) & (level.high_most[node] <= high[box]).all(axis=1)
            # A node of one box may be that box itself.
            other = level.boxes[node] > 1 if depth else node != box
            holds[box[inside & other]] = True
            may = (level.low_most[node] >= low[box]).all(axis=1) & (level.high_least[node] <= high[box]).all(axis=1)
            may &= ~holds[box]
            box, node = box[may], node[may]
            if depth:
                box = np.repeat(box, _CHILDREN)
                node = (_CHILDREN * node[:, None] + np.arange(_CHILDREN)).ravel()
                is_there = node < len(levels[depth - 1].boxes)
                box, node = box[is_there], node[is_there]
    found[order] = holds
    return found


def _near_each_other(low: Floats, high: Floats) -> Ints:
    """An order in which boxes that are near each other follow each other: Morton's, and by size where they coincide."""
    middle = 0.5 * low + 0.5 * high
    least, extent = middle.min(axis=0), np.ptp(middle, axis=0)
    scale = np.divide(_CELLS - 1, extent, out=np.zeros(3), where=extent > 0)
    cells = ((middle - least) * scale).astype(np.int64)
    code = np.zeros(len(low), dtype=np.int64)
    for bit in range(_CELLS.bit_length() - 1):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.lexsort(((high - low).sum(axis=1), code))


def _has_rim(corners: npt.NDArray[np.float64]) -> bool:
    """Whether some edge belongs to an odd number of triangles, after welding equal corners."""
    if not len(corners):
        return False
    _, index = _core.weld_vertices(np.ascontiguousarray(corners.reshape(-1, 3)))
    faces = index.reshape(-1, 3).astype(np.int64)
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    keys = edges[:, 0] * (int(index.max()) + 1) + edges[:, 1]
    return bool((np.unique(keys, return_counts=True)[1] % 2).any())
