"""Parts that are one shape at several places, so that each shape is looked at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SAME_SHARE = 1e-3
"""How far corners of two parts of one shape may differ, as a share of the part's size: files round coordinates, and a
guess at what a part is does not turn on so little."""
BATCH_NUMBERS = 3_000_000
"""Numbers that are aligned at once: 24 MB a copy."""
HELD_NUMBERS = 30_000_000
"""Numbers that are held of parts with the same triangles: 240 MB."""


@dataclass(frozen=True)
class SameShape:
    """One shape, and the parts that have it."""

    vertices: Floats
    """(n, 3), metres, about the middle of its corners."""
    faces: Ints
    parts: Ints
    places: Floats
    """(k, 4, 4): where the shape is for each part."""


class PartMeshes:
    """The triangles of each part of a mock-up, without searching all of them for each."""

    def __init__(self, mockup: Mockup) -> None:
        part_of_face = mockup.part_of_face
        self._vertices, self._faces = mockup.vertices, mockup.faces
        is_sorted = bool((part_of_face[1:] >= part_of_face[:-1]).all())
        self._order = None if is_sorted else np.argsort(part_of_face, kind="stable")
        counts = np.bincount(part_of_face, minlength=mockup.part_count)
        self._starts = np.concatenate([[0], np.cumsum(counts)])

    def __getitem__(self, part: int) -> tuple[Floats, Ints]:
        """Corners (n, 3) that the part's triangles have, in the mock-up's order, and its triangles (m, 3)."""
        begin, end = int(self._starts[part]), int(self._starts[part + 1])
        given = self._faces[begin:end] if self._order is None else self._faces[self._order[begin:end]]
        faces = given[(given < len(self._vertices)).all(axis=1)].astype(np.int64)
        if not len(faces):
            return np.empty((0, 3)), faces
        low, high = int(faces.min()), int(faces.max()) + 1
        if high - low <= 3 * len(faces):
            used = np.zeros(high - low, dtype=bool)
            used[faces - low] = True
            index = np.cumsum(used) - 1
            return self._vertices[low:high][used], np.asarray(index[faces - low], dtype=np.int64)
        used_ids, index = np.unique(faces, return_inverse=True)
        return self._vertices[used_ids], index.reshape(-1, 3).astype(np.int64)


def same_shapes(mockup: Mockup, parts: Ints) -> Iterator[SameShape]:
    """The shapes of these parts: the same triangles over the same corners, but for a rigid motion.

    Parts without triangles, and with corners that are not finite, are left out.
    """
    meshes = PartMeshes(mockup)
    alike: dict[tuple[int, int, int], list[int]] = {}
    for part in parts.tolist():
        vertices, faces = meshes[part]
        if len(faces) and np.isfinite(vertices).all():
            alike.setdefault((len(vertices), len(faces), hash(faces.tobytes())), []).append(part)
    for (count, _, _), group in alike.items():
        # Of very many parts, shares one after the other: a shape may then come more than once.
        step = max(1, HELD_NUMBERS // (3 * count))
        for begin in range(0, len(group), step):
            share = group[begin : begin + step]
            corners = np.stack([meshes[part][0] for part in share])
            yield from _told_apart(corners, meshes[share[0]][1], np.array(share))


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
    """Which of `corners` (k, n, 3) are `shape` (n, 3) moved, and by what (least squares: Arun 1987)."""
    middles = corners.mean(axis=1)
    u, _, v = np.linalg.svd(np.einsum("ni,knj->kij", shape, corners - middles[:, None]))
    v[:, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
    turns = (u @ v).transpose(0, 2, 1)
    off = np.abs(np.einsum("kij,nj->kni", turns, shape) + middles[:, None] - corners).max(axis=(1, 2))
    places = np.tile(np.eye(4), (len(corners), 1, 1))
    places[:, :3, :3], places[:, :3, 3] = turns, middles
    return off <= tolerance, places
