"""What the piece size, the blocks' counterpart of the voxel size, is worth: time by piece size beside the default's."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene
from .cells import Cell, plain
from .page import write_study
from .plots import draw_lines
from .runs import measure_pairs
from .subjects import Plan
from .timing import Setting, machine, time_in_turns

_RANGE = (0.25, 8.0)  # of the default
_FILTERS = {"repeat_filter": True, "box_filter": True}


def study_piece_size(plan: Plan) -> dict[str, Any]:
    """Measures, writes the study's files, returns the results."""
    measure = partial(_measure, plan=plan)
    rows = [_judged(cell) for cell in measure_pairs("piece-size", plan, plan.pairs(), measure, sizes=plan.sizes)]
    results: dict[str, Any] = plain(
        {"study": "piece-size", "machine": machine(), "rows": rows, "summary": _summary(rows)}
    )
    panels = [
        {
            "title": name, "x": "piece size over the default", "y": "time over the default's", "log": "x",
            "lines": [
                {"label": row["tool"], "colour": f"C{i}", "x": [p["over_default"] for p in row["points"]],
                 "y": [p["seconds"] / row["default"]["seconds"] for p in row["points"]]}
                for i, row in enumerate(each for each in rows if each["mockup"] == name)
            ],
        }
        for name in dict.fromkeys(row["mockup"] for row in rows)
    ]  # fmt: skip
    write_study(plan.folder, results, _samples(rows), draw_lines(plan.folder, "piece-size", panels))
    plan.progress(1.0, "done")
    return results


def _measure(mockup: Mockup, tool: Tool, plan: Plan) -> Cell:
    default = Scene(mockup)
    poses = np.asarray(sample_poses(default, tool, "nominal", plan.poses, seed=plan.seed))
    factors = [1.0, *(float(f) for f in np.geomspace(*_RANGE, plan.sizes))]
    scenes = [default, *(Scene(mockup, voxel_size=f * default.voxel_size) for f in factors[1:])]
    times = time_in_turns([Setting(scene, _FILTERS) for scene in scenes], tool, poses, plan.rounds, plan.seed)
    seconds, spread = times.seconds(), times.spread()
    points = [
        {
            "over_default": factor,
            "size_m": scene.voxel_size,
            "seconds": seconds[i],
            "quartiles_s": spread[i],
            "samples_s": times.samples[i],
            "build_s": scene.build_seconds,
            "bytes": scene.memory()["total"],
        }
        for i, (factor, scene) in enumerate(zip(factors, scenes, strict=True))
    ]
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "default": points[0],
        "points": sorted(points[1:], key=lambda point: float(point["over_default"])),
    }


def _judged(cell: Cell) -> Cell:
    best = min(cell["points"], key=lambda point: point["seconds"])
    over = cell["default"]["seconds"] / best["seconds"] - 1.0
    return {**cell, "best": {**best, "samples_s": []}, "default_over_best": over}


def _summary(rows: list[Cell]) -> dict[str, Any]:
    over = [row["default_over_best"] for row in rows]
    curves = np.array([[p["seconds"] / row["default"]["seconds"] for p in row["points"]] for row in rows])
    memory = np.array([[p["bytes"] / row["default"]["bytes"] for p in row["points"]] for row in rows])
    return {
        "pairs": len(rows),
        "default_over_best_median": float(np.median(over)),
        "default_over_best_worst": max(over),
        "over_default": [point["over_default"] for point in rows[0]["points"]],
        "median_time": np.median(curves, axis=0),
        "median_memory": np.median(memory, axis=0),
    }


def _samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    heading = ["mockup", "tool", "piece_size_m", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], point["size_m"], number, pose, seconds]
        for row in rows
        for point in (row["default"], *row["points"])
        for number, round_ in enumerate(point["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
