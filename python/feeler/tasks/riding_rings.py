"""Circlips that stay on their part: one stops it on one side alone, and the parts may come apart by the other."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.scene import Scene
from feeler.tasks.answer import Task
from feeler.tasks.captive import free_travel
from feeler.tasks.held_rows import Hold, Holds
from feeler.tasks.rings import ring_of

MOST_ALONE = 4
"""Up to so many are also tried one at a time, where others come off."""


def riding_rings(
    scene: Scene, held: Holds, answer: Task, wanted: Collection[int], kept: Collection[int], stuck: Collection[int]
) -> Iterator[frozenset[int]]:
    """The sets of circlips with which it is asked again: those that come off in an answer, or are on parts that nothing
    frees, and leave these free on one side."""
    gone = {part for step in answer.steps for part in step.parts}
    meshes, rings = PartMeshes(scene.mockup), []
    for row in held:
        if row.kind != "circlip" or row.anchor is None or row.fastener in kept or not row.parts:
            continue
        on = {row.anchor, *row.parts}
        is_asked = row.fastener in gone or (not answer.is_found and bool({row.fastener, *on} & {*stuck, *wanted}))
        is_alone = row.fastener in wanted and not on & {*wanted}
        if is_asked and not is_alone and _comes_apart(scene, meshes, row, row.anchor):
            rings.append(row.fastener)
    if rings:
        yield frozenset(rings)
    if 1 < len(rings) <= MOST_ALONE:
        yield from (frozenset([ring]) for ring in rings)


def _comes_apart(scene: Scene, meshes: PartMeshes, row: Hold, anchor: int) -> bool:
    """Whether what a circlip holds slips off the part with its groove, with it on that."""
    ring = ring_of(*meshes.mesh(row.fastener))
    if ring is None or not all(scene.part_mask[part] for part in (row.fastener, anchor, *row.parts)):
        return False
    bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)[[anchor, *row.parts]]
    far = float(np.linalg.norm(bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)))
    there = scene.only([anchor, row.fastener])
    own = Tool.of_parts(scene.mockup, list(row.parts))
    return any(free_travel(there, own, sign * ring.axis, far) is None for sign in (1.0, -1.0))


def better(one: Task, other: Task) -> Task:
    """Of two answers the quicker one, the first if both are as quick; no plan of either is below its bound."""
    best = other if other.is_found and not (one.is_found and one.seconds <= other.seconds) else one
    bounds = [each.bound for each in (one, other) if math.isfinite(each.bound)]
    return replace(best, bound=min(bounds), is_complete=one.is_complete and other.is_complete) if bounds else best
