"""Parts that a name calls a fastener, but that no tool turns: U-bolts, T-slot nuts, weld nuts. They have a thread, as
any other part may, and a nut or a bolt is undone from it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from feeler.part_meshes import PartMeshes
from feeler.plan.fasteners import NAMED, Fastener
from feeler.scene import Scene
from feeler.tasks.passing import around, in_bore, passed_by
from feeler.tasks.thread_sizes import thread_size

ROUND = 0.95
"""The least share of the widest that a round nut measures in any direction across its axis."""
TIGHT = 1.014
"""Radius of a thread over that of the shank in it, at most."""
_DIRECTIONS = 24
_LEVELS = 16  # heights of a nut, of which two are pressed into a part
_SAME = 2e-3  # how near the radii of a cylinder are, as a share
_PRESSED = (0.94, 1.015)  # where its walls are then, in radii of the nut
_FILLED = 0.8  # the share of them around it


def threaded_bodies(scene: Scene, rows: Sequence[Fastener]) -> set[int]:
    """The parts among fasteners that are known by name alone and are no fasteners: nuts that are neither prisms nor
    round, nuts that are pressed into a part or have their thread across their axis, and bolts on which a nut is whose
    axis is another."""
    named = [row for row in rows if row.confidence <= NAMED and not row.drive]
    if not named:
        return set()
    meshes = PartMeshes(scene.mockup)
    nuts = {row.part: row for row in named if row.kind == "nut"}
    found = {part for part, row in nuts.items() if not _is_round(meshes, row)}
    found |= _holders(scene, {part: row for part, row in nuts.items() if part not in found}, rows, meshes)
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


def _holders(scene: Scene, nuts: dict[int, Fastener], rows: Sequence[Fastener], meshes: PartMeshes) -> set[int]:
    """The nuts that no tool turns for the shank in them: it is on another axis than theirs, as in barrel nuts, which
    have their thread across; or they are pressed into another part, as rivet nuts are."""
    shanks = [row for row in rows if row.kind != "nut"]
    if not nuts or not shanks:
        return set()
    bare = scene.without([row.part for row in rows])
    found = set()
    for shank, parts in zip(shanks, passed_by(scene.only(sorted(nuts)), shanks), strict=True):
        for each in parts:
            nut, is_tight = nuts[each.part], each.radius <= TIGHT * 0.5 * thread_size(shank)
            if not _is_along(nut, shank) or (is_tight and _is_pressed(bare, meshes, nut)):
                found.add(each.part)
    return found


def _is_pressed(bare: Scene, meshes: PartMeshes, nut: Fastener) -> bool:
    """Whether a part is around a nut without play at some heights, where it is a cylinder: cones and balls only lie on
    their seats. bare: the scene without fasteners."""
    vertices, faces = meshes.mesh(nut.part)
    local = (vertices - nut.frame[:3, 3]) @ nut.frame[:3, :3]
    begin, end = local[faces].reshape(-1, 3), local[faces[:, [1, 2, 0]]].reshape(-1, 3)
    ways = around(nut.frame, _DIRECTIONS)
    pressed: list[float] = []
    for height in np.linspace(local[:, 2].min(), local[:, 2].max(), _LEVELS + 2)[1:-1]:
        crossing = (begin[:, 2] < height) != (end[:, 2] < height)
        if not crossing.any():
            continue
        low, high = begin[crossing], end[crossing]
        at = low + ((height - low[:, 2]) / (high[:, 2] - low[:, 2]))[:, None] * (high - low)
        wide = float(np.hypot(at[:, 0], at[:, 1]).max())
        origins = nut.frame[:3, 3] + height * nut.axis + _PRESSED[0] * wide * ways
        hits = bare.rays(origins, ways, within=(_PRESSED[1] - _PRESSED[0]) * wide)
        if (np.asarray(hits.triangles) >= 0).mean() >= _FILLED:
            pressed.append(wide)
    return any(abs(a - b) <= _SAME * a for a, b in itertools.pairwise(pressed))


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
