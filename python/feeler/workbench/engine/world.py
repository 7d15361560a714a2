"""The present state of the mock-up: parts in place, and parts put down elsewhere, queried as one.

`feeler._core.World` answers. Parts and triangles are those of the mock-up throughout, wherever they lie.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import cast

import numpy as np

from feeler import _core
from feeler._core import Clearance, Collision, Contacts
from feeler.scene import Scene
from feeler.workbench.document.motion import Row
from feeler.workbench.engine.parts import PartTools

Pairs = frozenset[tuple[int, int]]
"""Pairs of a tool's and a mock-up's part."""


class World(_core.World):
    """The surroundings of a tool. Immutable, except for caches."""

    in_place: Scene
    """The parts at their loaded places."""
    put_down: dict[int, Scene]
    """The parts that lie elsewhere, each with a scene of it alone."""
    _meshes: PartTools

    def __new__(cls, scene: Scene, meshes: PartTools, moved: Mapping[int, Row], gone: Iterable[int] = ()) -> World:
        """moved: `world_from_part` of parts put down elsewhere; gone: parts in the hand."""
        absent = sorted({*moved, *gone})
        in_place = scene.without(absent) if absent else scene
        put_down = {part: meshes.lying(part, place) for part, place in moved.items()}
        world = super().__new__(cls, in_place, list(put_down.items()))
        world.in_place, world.put_down, world._meshes = in_place, put_down, meshes
        return world

    def triangle_of(self, part: int, own: int) -> int:
        """The mock-up's triangle of a triangle of a part put down elsewhere."""
        return int(self._meshes.of(part)[1][own])


_NONE = np.empty(0, np.uint32)
_START = np.zeros(1, np.uint64)
NO_HITS = cast(
    Collision, _core.restore("Collision", (np.empty((0, 2), np.uint32), np.empty(0, np.uint8), _NONE, _NONE, {}))
)
NO_ROWS = cast(Clearance, _core.restore("Clearance", (np.empty((0, 4), np.uint32), np.empty((0, 7)))))
NO_PLANES = cast(
    Contacts,
    _core.restore(
        "Contacts",
        (
            (np.empty((0, 3)), np.empty((0, 3)), np.empty(0), _NONE, _NONE, np.empty(0, np.uint64)),
            (_NONE, _START),
            (_NONE, _START),
            (np.empty((0, 4, 3)), _NONE),
            0,
            False,
        ),
    ),
)
