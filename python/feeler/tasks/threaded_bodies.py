"""Parts that a name calls a fastener, but that no tool turns: U-bolts, T-slot nuts, weld nuts. They have a thread, as
any other part may, and a nut or a bolt is undone from it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from feeler.part_meshes import PartMeshes
from feeler.plan.fasteners import NAMED, Fastener
from feeler.scene import Scene
from feeler.tasks.passing import in_bore, passed_by

ROUND = 0.95
"""The least share of the widest that a round nut measures in any direction across its axis."""
_DIRECTIONS = 24


def threaded_bodies(scene: Scene, rows: Sequence[Fastener]) -> set[int]:
    """The parts among fasteners that are known by name alone and are no fasteners: nuts that are neither prisms nor
    round, nuts that a shank is in across their axis, and bolts on which a nut is whose axis is another."""
    named = [row for row in rows if row.confidence <= NAMED and not row.drive]
    if not named:
        return set()
    meshes = PartMeshes(scene.mockup)
    nuts = {row.part: row for row in named if row.kind == "nut"}
    found = {part for part, row in nuts.items() if not _is_round(meshes, row)}
    found |= _crossed(scene, {part: row for part, row in nuts.items() if part not in found}, rows)
    bolts = {row.part: row for row in named if row.kind != "nut"}
    if not bolts:
        return found
    alone = scene.only(sorted(bolts))
    for nut in rows:
        if nut.kind != "nut" or nut.part in found:
            continue
        for each in in_bore(alone, nut, meshes):
            if not _is_along(bolts[each.part], nut):
                found.add(each.part)
    return found


def _crossed(scene: Scene, nuts: dict[int, Fastener], rows: Sequence[Fastener]) -> set[int]:
    """The nuts in which a shank is on another axis than theirs: barrel nuts, which have their thread across."""
    shanks = [row for row in rows if row.kind != "nut"]
    if not nuts or not shanks:
        return set()
    passed = zip(shanks, passed_by(scene.only(sorted(nuts)), shanks), strict=True)
    return {each.part for shank, parts in passed for each in parts if not _is_along(nuts[each.part], shank)}


def _is_along(row: Fastener, other: Fastener) -> bool:
    """Whether a fastener is on the axis of another one."""
    off = np.cross(row.axis, other.frame[:3, 3] - row.frame[:3, 3])
    return abs(float(row.axis @ other.axis)) >= 0.99 and float(np.linalg.norm(off)) <= 0.3 * other.size


def _is_round(meshes: PartMeshes, nut: Fastener) -> bool:
    """Whether a nut is as wide in all directions across its axis."""
    turns = np.arange(_DIRECTIONS) * (2.0 * np.pi / _DIRECTIONS)
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    local = (meshes.mesh(nut.part)[0] - nut.frame[:3, 3]) @ nut.frame[:3, :2]
    wide = (local @ ways.T).max(axis=0)
    return bool(wide.min() >= ROUND * wide.max())
