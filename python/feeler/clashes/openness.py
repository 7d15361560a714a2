"""Finds open parts that may contain others, which a check cannot decide."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes

Ints = npt.NDArray[np.intp]


def open_holders(
    mockup: Mockup,
    a: npt.NDArray[np.uint32],
    b: npt.NDArray[np.uint32],
    is_open: npt.NDArray[np.bool_],
    present: npt.NDArray[np.bool_],
) -> list[int]:
    """The open parts whose box contains the box of another part, ascending.

    a, b, is_open: the pairs of the check, and whether their parts are open. present: `(parts,)`, the parts of the
    scene. Examines only parts with another box inside their box, so it costs little more than a sort.
    """
    known = np.full(mockup.part_count, -1, dtype=np.int8)
    known[a], known[b] = is_open[:, 0], is_open[:, 1]
    holders = [part for part in _holders(mockup, present) if known[part] != 0]
    if not holders:
        return []
    meshes = PartMeshes(mockup)
    return [part for part in holders if known[part] == 1 or _has_rim(meshes.corners(part))]


def _holders(mockup: Mockup, present: npt.NDArray[np.bool_]) -> list[int]:
    """The parts whose box contains the box of another part."""
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    parts = np.flatnonzero(present & (bounds[:, 0] <= bounds[:, 1]).all(axis=1))
    # Sorted along the axis of the largest spread: boxes that start within a part form one run.
    axis = int(np.argmax(np.ptp(bounds[parts, 0], axis=0))) if len(parts) else 0
    parts = parts[np.argsort(bounds[parts, 0, axis], kind="stable")]
    low, high = bounds[parts, 0], bounds[parts, 1]
    first = np.searchsorted(low[:, axis], low[:, axis], side="left")
    last = np.searchsorted(low[:, axis], high[:, axis], side="right")
    found = []
    for place in range(len(parts)):
        run = slice(int(first[place]), int(last[place]))
        if last[place] - first[place] < 2:
            continue
        inside = (low[run] >= low[place]).all(axis=1) & (high[run] <= high[place]).all(axis=1)
        if np.count_nonzero(inside) > 1:
            found.append(int(parts[place]))
    return sorted(found)


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
