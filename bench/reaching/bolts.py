"""Fasteners, the whole built-in catalogue, and casts of their own that judge each answer."""

from __future__ import annotations

import time
from collections import Counter

import numpy as np
from section import Result

import feeler

KINDS = {"socket": {"socket"}, "hex key": {"bit", "hex_key"}, "open-end wrench": {"open"}}
"""Kinds of the catalogue for the tools of the gearbox's truth."""


def engine(triangles: int, bolts: int, repeats: int) -> Result:
    """Bolts of the sample engine, one core."""
    mockup = feeler.sample("engine", triangles)
    scene = feeler.Scene(mockup, threads=1)
    found = feeler.find_fasteners(scene).where("*bolt*")
    targets = found[:: max(1, len(found) // bolts)][:bolts]
    tools = feeler.catalogue()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        access = feeler.access(scene, tools, targets, threads=1)
        seconds.append(time.perf_counter() - start)
    return {
        "triangles": mockup.triangle_count,
        "bolts": len(targets),
        "tools": len(tools),
        "repeats": repeats,
        "seconds": min(seconds),
        "reachable": int(access.is_reachable.sum()),
        "without_fit": sum(row.tool is None and row.nearest is None for row in access),
        "wrong": sum(not holds(scene, tools, targets[row.target], row) for row in access if row.is_reachable),
        "kinds": dict(Counter(kind_of(tools, row) for row in access if row.is_reachable).most_common()),
    }


def gearbox(triangles: int, every: int) -> Result:
    """The tools of the sample gearbox's truth, with what goes before out; and its bolt under a guard."""
    mockup, truth = feeler.sample("gearbox", triangles), feeler.sample_truth("gearbox", triangles)
    scene, tools = feeler.Scene(mockup, threads=1), feeler.catalogue()
    found = {row.path: row for row in feeler.find_fasteners(mockup)}
    door = next(joint.parts for joint in truth.joints if joint.name == "door")
    rows: dict[str, Counter[str]] = {}
    start = time.perf_counter()
    for fastener in truth.fasteners[::every]:
        step = next(step for step in truth.steps if fastener.path in step.parts)  # where the tool loosens it
        out = [path for earlier in truth.needed(step) if earlier.removes for path in earlier.parts]
        there = scene.without([*out, *(door if step.door_open else ())])
        targets = feeler.Fasteners([found[fastener.path]])
        # A deep socket goes over the plug of a sensor, whose truth is an open spanner.
        asked = tools.where("open") if fastener.tool == "open-end wrench" else tools
        (row,) = feeler.access(there, asked, targets, threads=1)
        is_right = row.is_reachable and kind_of(tools, row) in KINDS[fastener.tool]
        is_right = is_right and abs(tools.pieces(str(row.tool))[0].size - fastener.size_m) < 1e-6
        counts = rows.setdefault(fastener.tool, Counter(fasteners=0, found=0, wrong=0))
        counts.update(fasteners=1, found=int(is_right))
        if row.is_reachable:
            counts.update(wrong=int(not holds(there, tools, targets[0], row)))
    seconds = time.perf_counter() - start
    return {
        "triangles": mockup.triangle_count,
        "seconds": seconds,
        "rows": {tool: dict(counts) for tool, counts in rows.items()},
        "planted": planted(triangles),
    }


def planted(triangles: int) -> list[str]:
    """Tools that reach the bolt under the planted guard: by themselves, and in a hand."""
    mockup = feeler.sample("gearbox", triangles, faults=["blocked_bolt"])
    truth = feeler.sample_truth("gearbox", triangles, faults=["blocked_bolt"])
    scene, tools = feeler.Scene(mockup, threads=1), feeler.catalogue()
    targets = feeler.find_fasteners(mockup, truth.faults[0].parts[0])
    rows = [*feeler.access(scene, tools, targets), *feeler.access(scene, tools, targets, hand=tools.hand)]
    return [str(row.tool) for row in rows if row.is_reachable]


def kind_of(tools: feeler.Catalogue, row: feeler.Reach) -> str:
    """The kind of the piece on the fastener."""
    return tools.pieces(str(row.tool))[0].kind


def holds(scene: feeler.Scene, tools: feeler.Catalogue, fastener: feeler.Fastener, row: feeler.Reach) -> bool:
    """Whether the tool is free on its way, over its swing both ways, and at its ends, by casts and collisions of its
    own: it starts from the answer's poses alone."""
    tool, ignore = tools.tool(str(row.tool)), [("*", fastener.part)]
    for start, end in zip(row.way[:-1], row.way[1:], strict=True):
        if scene.cast(tool, start, end, touching="free", ignore=ignore) is not None:
            return False
    half = np.radians(0.5 * row.swing_deg)
    for angle in (-half, half):
        screw = feeler.Screw(fastener.axis, fastener.frame[:3, 3], 0.999999 * angle)
        if scene.cast(tool, row.pose, screw=screw, tolerance=1e-9, ignore=ignore) is not None:
            return False
    return not len(scene.collide(tool, row.way[0], ignore=ignore)) and not scene.containment(tool, row.way[0])
