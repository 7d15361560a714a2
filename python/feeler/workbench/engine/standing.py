"""The mock-up as it stands: the scene that questions about parts are asked of."""

from __future__ import annotations

import threading

from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import Document, World


class Standing:
    """Makes the scene of a document: without parts that are out or in the hand, others where they were put down.

    Parts and triangles have the numbers of the mock-up. Thread-safe; the last scene with moved parts is kept.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
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
                kept = (document.world, self._moved(elsewhere, progress))
                self._kept = kept
            return kept[1]

    def _moved(self, elsewhere: dict[int, tuple[float, ...]], progress: Progress | None) -> Scene:
        if progress is not None:
            progress(0.0, "placing moved parts")
        by_place: dict[tuple[float, ...], list[int]] = {}
        for part, at in elsewhere.items():
            by_place.setdefault(at, []).append(part)
        return self._scene.moved({tuple(parts): motion.matrix(at) for at, parts in by_place.items()})
