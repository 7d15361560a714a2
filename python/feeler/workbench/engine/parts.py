"""Parts of a mock-up as tools and scenes of their own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.poses import placed
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.motion import Floats, Row

Ints = npt.NDArray[np.intp]


class PartTools:
    """Parts of a mock-up as tools of their own, each made once. Thread-safe."""

    def __init__(self, mockup: Mockup) -> None:
        self.mockup = mockup
        self._meshes = PartMeshes(mockup)
        self._kept: dict[int, tuple[Tool, Ints]] = {}
        self._lying: dict[int, tuple[Row, Scene]] = {}

    def of(self, part: int) -> tuple[Tool, Ints]:
        """A part in the mock-up's frame, and the mock-up's index of each of its triangles."""
        if part not in self._kept:
            ids = self._meshes.triangles(part)
            faces, vertices = self.mockup.faces[ids], self.mockup.vertices
            used = np.unique(faces)
            used = used[used < len(vertices)]
            # Indices out of range stay out of range.
            own = np.where(faces < len(vertices), np.searchsorted(used, faces), 2**32 - 1)
            name, path = self.mockup.part_names[part], self.mockup.part_paths[part]
            tool = Tool(vertices[used], own, name, part_paths=[path], source=self.mockup.source)
            self._kept[part] = (tool, ids)
        return self._kept[part]

    def at(self, part: int, place: Row) -> tuple[Floats, Ints]:
        """Vertices and faces of a part at a `world_from_part`."""
        mesh, _ = self.of(part)
        faces = np.where(mesh.faces < len(mesh.vertices), mesh.faces.astype(np.int64), 2**32 - 1)
        return placed(mesh.vertices, motion.matrix(place), "a part that was put down"), faces

    def lying(self, part: int, place: Row) -> Scene:
        """The scene of a part alone at a `world_from_part`; the last one of each part is cached."""
        kept = self._lying.get(part)
        if kept is None or kept[0] != place:
            vertices, faces = self.at(part, place)
            lying = Mockup(vertices, faces, part_names=[self.mockup.part_names[part]])
            if self.mockup.part_colours is not None:
                lying.part_colours = self.mockup.part_colours[[part]]
            kept = (place, Scene(lying))
            self._lying[part] = kept
        return kept[1]


def with_places(mockup: Mockup, moved: Mapping[int, Row], meshes: PartTools | None = None) -> Mockup:
    """The mock-up with some parts elsewhere, at their `world_from_part`.

    Their vertices are added, since others may share the old ones. meshes: its parts, if they are known.
    """
    meshes = PartTools(mockup) if meshes is None else meshes
    vertices, faces = [mockup.vertices], np.array(mockup.faces)
    count = len(mockup.vertices)
    for part, at in moved.items():
        there, own = meshes.at(part, at)
        triangles = meshes.of(part)[1]
        is_there = own < len(there)
        faces[triangles] = np.where(is_there, own + count, faces[triangles])
        vertices.append(there)
        count += len(there)
    made = Mockup(
        np.concatenate(vertices),
        faces,
        mockup.part_of_face,
        mockup.part_names,
        part_paths=mockup.part_paths,
        source=mockup.source,
    )
    made._keep_attributes(mockup._part_attributes)  # rules may ask for them
    return made
