"""Removable parts of the sample engine, and their paths.

The blades of the samples overlap their disk, where real ones sit in slots, so that they cannot move while the disk is
there. The blade therefore comes out from between its neighbours without the disk and its retaining ring (1.3 mm of play
at 1.6 million triangles). The cage of a bearing comes out with everything there: 1 mm of play on its shaft.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import feeler

from .meshes import Floats
from .poses import pose

STEPS = 60


@dataclass(frozen=True)
class Removal:
    """A part as a tool, the scene without it, and poses (n, 4, 4) from its seat to the outside."""

    name: str
    scene: feeler.Scene
    tool: feeler.Tool
    way: Floats
    left_out: tuple[str, ...]
    """Paths of what must go besides, since the sample has it overlap the part."""


def removals(scene: feeler.Scene) -> list[Removal]:
    """A part that comes out of an engine, with the way out."""
    return [fan_blade(scene), bearing_cage(scene)]


def fan_blade(scene: feeler.Scene) -> Removal:
    """The first blade of the first stage, forwards."""
    blade = scene.mockup.parts.find("engine/lp_compressor/stage_01/blade_001")[0]
    seat = scene.without([blade.index])
    tool = feeler.Tool.of_parts(scene.mockup, [blade.index], "fan blade")
    return _forwards("fan blade", seat, tool, 0.45)


def bearing_cage(scene: feeler.Scene) -> Removal:
    """The front half of the first bearing's cage, forwards."""
    part = next(p for p in scene.mockup.parts if p.path.endswith("cage_front"))
    tool = feeler.Tool.of_parts(scene.mockup, [part.index], "bearing cage")
    return _forwards("bearing cage", scene.without([part.index]), tool, 0.35)


def _forwards(name: str, seat: feeler.Scene, tool: feeler.Tool, distance: float) -> Removal:
    overlapping = [int(k) for k in seat.collide(tool, pose()).parts]
    free = seat.without(overlapping) if overlapping else seat
    way = np.array([pose((0.0, 0.0, -z)) for z in np.linspace(0.0, distance, STEPS)])
    return Removal(name, free, tool, way, tuple(seat.mockup.parts[k].path for k in overlapping))
