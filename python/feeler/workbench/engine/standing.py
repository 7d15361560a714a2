"""The mock-up as it stands: the scene that questions about parts are asked of."""

from __future__ import annotations

import threading

import numpy as np

from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document.document import Document, World
from feeler.workbench.engine.parts import PartTools


class Standing:
    """Makes the scene of a document: without parts that are out or in the hand, others where they were put down.

    Parts and triangles have the numbers of the mock-up, except that triangles of parts that lie elsewhere come last.
    Thread-safe; the last scene with such parts is kept, for its index takes time.
    """

    def __init__(self, scene: Scene, meshes: PartTools) -> None:
        self._scene, self._meshes = scene, meshes
        self._lock = threading.Lock()
        self._kept: tuple[World, Scene] | None = None

    def scene(self, document: Document, without: tuple[int, ...] = (), progress: Progress | None = None) -> Scene:
        """without: parts left out besides."""
        gone = sorted({*document.out, *document.gripped, *without})
        elsewhere = {part: at for part, at in document.moved.items() if part not in document.out}
        base = self._scene if not elsewhere else self._placed(document, elsewhere, progress)
        gone = [part for part in gone if base.part_mask[part]]
        return base.without(gone) if gone else base

    def _placed(self, document: Document, elsewhere: dict[int, tuple[float, ...]], progress: Progress | None) -> Scene:
        with self._lock:
            kept = self._kept
            if kept is None or kept[0] != document.world:
                kept = (document.world, self._indexed(elsewhere, progress))
                self._kept = kept
            return kept[1]

    def _indexed(self, elsewhere: dict[int, tuple[float, ...]], progress: Progress | None) -> Scene:
        mockup = self._scene.mockup
        stays = ~np.isin(mockup.part_of_face, sorted(elsewhere))
        vertices, faces, owners = [mockup.vertices], [mockup.faces[stays]], [mockup.part_of_face[stays]]
        count = len(mockup.vertices)
        for part, at in elsewhere.items():
            own_vertices, own_faces = self._meshes.at(part, at)
            vertices.append(own_vertices)
            faces.append(np.where(own_faces < len(own_vertices), own_faces + count, 2**32 - 1).astype(np.uint32))
            owners.append(np.full(len(own_faces), part, dtype=np.uint32))
            count += len(own_vertices)
        placed = Mockup(
            np.concatenate(vertices),
            np.concatenate(faces),
            np.concatenate(owners),
            mockup.part_names,
            part_paths=mockup.part_paths,
        )
        placed._keep_attributes(mockup._part_attributes)  # rules may ask for them
        absent = np.flatnonzero(~self._scene.part_mask).tolist()
        scene = Scene(placed, progress=progress)
        return scene.without(absent) if absent else scene
