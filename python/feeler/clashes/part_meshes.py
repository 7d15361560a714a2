"""The triangles of each part of a mock-up, found once for all parts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup


class PartMeshes:
    """Which triangles each part of a mock-up has."""

    def __init__(self, mockup: Mockup) -> None:
        self.vertices = mockup.vertices
        self._faces = mockup.faces
        part_of_face = mockup.part_of_face
        self._order = np.argsort(part_of_face, kind="stable")
        self._starts = np.searchsorted(part_of_face[self._order], np.arange(mockup.part_count + 1))

    def triangles(self, part: int) -> npt.NDArray[np.intp]:
        """The numbers of a part's triangles, ascending."""
        return self._order[self._starts[part] : self._starts[part + 1]]

    def corners(self, part: int) -> npt.NDArray[np.float64]:
        """`(k, 3, 3)`: the corners of a part's triangles, metres; none of those with an index out of range."""
        faces = self._faces[self.triangles(part)]
        return np.asarray(self.vertices[faces[(faces < len(self.vertices)).all(axis=1)]])
