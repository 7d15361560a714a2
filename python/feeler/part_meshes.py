"""The triangles of each part of a mock-up, sorted once for all parts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup


class PartMeshes:
    """Looks up the triangles of a part."""

    def __init__(self, mockup: Mockup) -> None:
        self.vertices = mockup.vertices
        self._faces = mockup.faces
        part_of_face = mockup.part_of_face
        self._order = np.argsort(part_of_face, kind="stable")
        self._starts = np.searchsorted(part_of_face[self._order], np.arange(mockup.part_count + 1))

    def triangles(self, part: int) -> npt.NDArray[np.intp]:
        """The indices of the triangles of a part, ascending."""
        return self._order[self._starts[part] : self._starts[part + 1]]

    def corners(self, part: int) -> npt.NDArray[np.float64]:
        """`(k, 3, 3)`: the corners of the triangles of a part, metres, without triangles with an invalid index."""
        faces = self._faces[self.triangles(part)]
        return np.asarray(self.vertices[faces[(faces < len(self.vertices)).all(axis=1)]])
