"""Groups parts of one shape at several places, so that each shape is examined once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SAME_SHARE = 1e-3
"""How far corners of two parts of one shape may differ, as a share of the part's size: files round coordinates, and the
recognition of fasteners does not need more."""
BATCH_NUMBERS = 3_000_000
"""Numbers aligned at once: 24 MB a copy."""
HELD_NUMBERS = 30_000_000
"""Numbers kept of parts with the same triangles: 240 MB."""


@dataclass(frozen=True, eq=False)
class SameShape:
    """One shape, and the parts that have it."""

    vertices: Floats
    """(n, 3), metres, about the middle of its corners."""
    faces: Ints
    parts: Ints
    places: Floats
    """(k, 4, 4): the place of the shape for each part."""


def same_shapes(mockup: Mockup, parts: Ints) -> Iterator[SameShape]:
    """The shapes of these parts: the same triangles over the same corners, up to a rigid motion.

    Skips parts without triangles, and with corners that are not finite.
    """
    meshes = PartMeshes(mockup)
    alike: dict[tuple[int, int, int], list[int]] = {}
    for part in parts.tolist():
        vertices, faces = meshes.mesh(part)
        if len(faces) and np.isfinite(vertices).all():
            alike.setdefault((len(vertices), len(faces), hash(faces.tobytes())), []).append(part)
    for (count, _, _), group in alike.items():
        # Very many parts are processed in shares; a shape can then occur more than once.
        step = max(1, HELD_NUMBERS // (3 * count))
        for begin in range(0, len(group), step):
            share = group[begin : begin + step]
            corners = np.stack([meshes.mesh(part)[0] for part in share])
            yield from _told_apart(corners, meshes.mesh(share[0])[1], np.array(share))


def _told_apart(corners: Floats, faces: Ints, parts: Ints) -> Iterator[SameShape]:
    """The shapes among parts with the same triangles; `corners` (k, n, 3)."""
    step = max(1, BATCH_NUMBERS // corners[0].size)
    while len(parts):
        middle = corners[0].mean(axis=0)
        shape = corners[0] - middle
        tolerance = SAME_SHARE * float(np.ptp(shape, axis=0).max()) + 1e-12
        begins = range(0, len(parts), step)
        batches = [_aligned(shape, corners[begin : begin + step], tolerance) for begin in begins]
        is_same, places = (np.concatenate(each) for each in zip(*batches, strict=True))
        is_same[0], places[0, :3, :3], places[0, :3, 3] = True, np.eye(3), middle
        yield SameShape(shape, faces, parts[is_same], places[is_same])
        corners, parts = corners[~is_same], parts[~is_same]


def _aligned(shape: Floats, corners: Floats, tolerance: float) -> tuple[npt.NDArray[np.bool_], Floats]:
    """Which of `corners` (k, n, 3) are `shape` (n, 3) moved, and the motion (least squares: Arun 1987)."""
    middles = corners.mean(axis=1)
    u, _, v = np.linalg.svd(np.einsum("ni,knj->kij", shape, corners - middles[:, None]))
    v[:, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
    turns = (u @ v).transpose(0, 2, 1)
    off = np.abs(np.einsum("kij,nj->kni", turns, shape) + middles[:, None] - corners).max(axis=(1, 2))
    places = np.tile(np.eye(4), (len(corners), 1, 1))
    places[:, :3, :3], places[:, :3, 3] = turns, middles
    return off <= tolerance, places
