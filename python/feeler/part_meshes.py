"""The triangles of each part of a mock-up, sorted once for all parts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler import _core


class PartMeshes:
    """Looks up the triangles of a part. Thread-safe."""

    def __init__(self, mockup: _core.Mockup) -> None:
        self.vertices = mockup.vertices
        self._faces = mockup.faces
        part_of_face = mockup.part_of_face
        is_sorted = bool((part_of_face[1:] >= part_of_face[:-1]).all())
        self._order = None if is_sorted else np.argsort(part_of_face, kind="stable")
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(part_of_face, minlength=mockup.part_count))])

    def triangles(self, part: int) -> npt.NDArray[np.intp]:
        """The indices of the triangles of a part, ascending."""
        begin, end = self._starts[part], self._starts[part + 1]
        return np.arange(begin, end, dtype=np.intp) if self._order is None else self._order[begin:end]

    def corners(self, part: int) -> npt.NDArray[np.float64]:
        """`(k, 3, 3)`: the corners of the triangles of a part, metres, without triangles with an invalid index."""
        return np.asarray(self.vertices[self._valid(part)])

    def mesh(self, part: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """A part alone: its vertices `(n, 3)`, metres, in the mock-up's order, and its triangles `(m, 3)`.

        Without triangles with an invalid index.
        """
        faces = self._valid(part).astype(np.int64)
        if not len(faces):
            return np.empty((0, 3)), faces
        low, high = int(faces.min()), int(faces.max()) + 1
        if high - low <= 3 * len(faces):
            used = np.zeros(high - low, dtype=bool)
            used[faces - low] = True
            index = np.cumsum(used) - 1
            return self.vertices[low:high][used], np.asarray(index[faces - low], dtype=np.int64)
        used_ids, index = np.unique(faces, return_inverse=True)
        return self.vertices[used_ids], index.reshape(-1, 3).astype(np.int64)

    def _valid(self, part: int) -> npt.NDArray[np.uint32]:
        begin, end = self._starts[part], self._starts[part + 1]
        faces = self._faces[begin:end] if self._order is None else self._faces[self._order[begin:end]]
        return faces[(faces < len(self.vertices)).all(axis=1)]
