"""Parts that a name calls a fastener, but that no tool turns: U-bolts, T-slot nuts, weld nuts. They have a thread, as
any other part may, and a nut or a bolt is undone from it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from feeler.part_meshes import PartMeshes
from feeler.plan.fasteners import NAMED, Fastener
from feeler.scene import Scene
from feeler.tasks.passing import in_bore

ROUND = 0.95
"""The least share of the widest that a round nut measures in any direction across its axis."""
_DIRECTIONS = 24


def threaded_bodies(scene: Scene, rows: Sequence[Fastener]) -> set[int]:
    """The parts among fasteners that are known by name alone and are no fasteners: nuts that are neither prisms nor
    round, and bolts on which a nut is whose axis is another."""
    named = [row for row in rows if row.confidence <= NAMED and not row.drive]
    if not named:
        return set()
    meshes = PartMeshes(scene.mockup)
    found = {row.part for row in named if row.kind == "nut" and not _is_round(meshes, row)}
    bolts = {row.part: row for row in named if row.kind != "nut"}
    if not bolts:
        return found
    alone = scene.only(sorted(bolts))
    for nut in rows:
        if nut.kind != "nut" or nut.part in found:
            continue
        for each in in_bore(alone, nut, meshes):
            bolt = bolts[each.part]
            off = np.cross(bolt.axis, nut.frame[:3, 3] - bolt.frame[:3, 3])
            if abs(float(bolt.axis @ nut.axis)) < 0.99 or float(np.linalg.norm(off)) > 0.3 * nut.size:
                found.add(each.part)
    return found


def _is_round(meshes: PartMeshes, nut: Fastener) -> bool:
    """Whether a nut is as wide in all directions across its axis."""
    turns = np.arange(_DIRECTIONS) * (2.0 * np.pi / _DIRECTIONS)
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    local = (meshes.mesh(nut.part)[0] - nut.frame[:3, 3]) @ nut.frame[:3, :2]
    wide = (local @ ways.T).max(axis=0)
    return bool(wide.min() >= ROUND * wide.max())
