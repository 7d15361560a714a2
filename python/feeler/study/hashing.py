"""Figures 4, 5 and 11: memory and collision time by hashing level, dense, hashed and blocks side by side."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..errors import LimitError
from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene, optimal_voxel_size
from .cells import Cell, plain
from .page import write_study
from .plots import draw_lines
from .runs import measure_pairs
from .subjects import Plan
from .timing import Setting, machine, time_in_turns

LEVELS = (0.0, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
FREE = 1.10

_FACTORS = (1.0, 1.6, 2.5)  # of the calibrated size
_FILTERS = {"repeat_filter": True, "box_filter": True}


def study_hashing(plan: Plan) -> dict[str, Any]:
    """Measures, writes the study's files, returns the results."""
    pairs, limit = plan.pairs(), plan.memory_limit
    measure = partial(_measure, plan=plan)
    rows = list(measure_pairs("hashing", plan, pairs, measure, memory_limit=limit))
    free = [at["free_level"] for row in rows for at in row["sizes"]]
    summary = {"free_level_median": float(np.median(free)), "free_level_least": min(free)}
    results: dict[str, Any] = plain({"study": "hashing", "machine": machine(), "rows": rows, "summary": summary})
    plots = draw_lines(plan.folder, "hashing", [panel for row in rows for panel in _panels(row)], columns=2)
    write_study(plan.folder, results, _samples(rows), plots)
    plan.progress(1.0, "done")
    return results


def _measure(mockup: Mockup, tool: Tool, plan: Plan) -> Cell:
    blocks = Scene(mockup)
    poses = np.asarray(sample_poses(blocks, tool, "nominal", plan.poses, seed=plan.seed))
    chosen = optimal_voxel_size(mockup, tool, memory_limit=plan.memory_limit)
    sizes: list[Cell] = []
    blocks_seconds: list[float] = []
    for factor in _FACTORS:
        size = factor * chosen
        try:
            dense = Scene(mockup, voxel_size=size, storage="dense", memory_limit=plan.memory_limit)
            hashed = [
                Scene(mockup, voxel_size=size, storage="hashed", hashing=level, memory_limit=plan.memory_limit)
                for level in LEVELS
            ]
        except LimitError:
            continue
        scenes = [blocks, dense, *hashed]
        times = time_in_turns([Setting(scene, _FILTERS) for scene in scenes], tool, poses, plan.rounds, plan.seed)
        seconds = times.seconds()
        figures = [
            {"seconds": seconds[i], "bytes": _index_bytes(scene), "samples_s": times.samples[i]}
            for i, scene in enumerate(scenes)
        ]
        blocks_seconds.append(seconds[0])
        levels = [{"level": level, **figure} for level, figure in zip(LEVELS, figures[2:], strict=True)]
        free = [each["level"] for each in levels if each["seconds"] <= FREE * levels[0]["seconds"]]
        sizes.append({"size_m": size, "dense": figures[1], "hashed": levels, "free_level": max(free)})
    if not sizes:
        raise LimitError(f"no voxel size fits into {plan.memory_limit} bytes: allow more, or take a smaller mock-up")
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "sizes": sizes,
        "blocks": {"seconds": float(np.median(blocks_seconds)), "bytes": _index_bytes(blocks)},
    }


def _index_bytes(scene: Scene) -> int:
    return sum(count for name, count in scene.memory().items() if name not in ("total", "triangles", "parts"))


def _panels(row: Cell) -> list[dict[str, Any]]:
    percent = [100 * level for level in LEVELS]
    shades = ("#d6a73a", "#8c6d31", "#4d3c1a")
    panels = []
    for what, factor, unit in (("seconds", 1e6, "µs a query"), ("bytes", 1e-6, "MB of index")):
        lines = [
            {"label": f"hashed, {1e3 * at['size_m']:.1f} mm", "colour": shade, "x": percent,
             "y": [factor * each[what] for each in at["hashed"]]}
            for at, shade in zip(row["sizes"], shades, strict=False)
        ]  # fmt: skip
        lines += [
            {"label": "_" if i else "dense, the same sizes", "colour": "dense", "dash": ":", "x": [0, 95],
             "y": [factor * at["dense"][what]] * 2}
            for i, at in enumerate(row["sizes"])
        ]  # fmt: skip
        lines.append(
            {"label": "blocks", "colour": "blocks", "dash": "--", "x": [0, 95], "y": [factor * row["blocks"][what]] * 2}
        )
        panels.append(
            {"title": f"{row['mockup']}, {row['tool']}", "x": "hashing level, %", "y": unit, "log": "y", "lines": lines}
        )
    return panels


def _samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    heading = ["mockup", "tool", "voxel_size_m", "hashing_level", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], at["size_m"], each["level"], number, pose, seconds]
        for row in rows
        for at in row["sizes"]
        for each in at["hashed"]
        for number, round_ in enumerate(each["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
