"""The effect of the piece size, the blocks' counterpart of the voxel size: time by size, default and chosen size."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .. import _core
from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene
from .cells import Cell, plain
from .curves import rank_correlation
from .page import write_study
from .plots import draw_lines
from .runs import measure_pairs
from .subjects import Plan
from .timing import Setting, least_in_turns, machine, time_in_turns

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
            "title": name, "x": "piece size over the default", "y": "over the default's", "log": "x",
            "lines": [line for i, row in enumerate(r for r in rows if r["mockup"] == name) for line in _lines(row, i)],
        }
        for name in dict.fromkeys(row["mockup"] for row in rows)
    ]  # fmt: skip
    write_study(plan.folder, results, _samples(rows), draw_lines(plan.folder, "piece-size", panels))
    plan.progress(1.0, "done")
    return results


def _lines(row: Cell, number: int) -> list[dict[str, Any]]:
    """Measured time; predicted work, dashed; the chosen size, a diamond."""
    sizes = [point["over_default"] for point in row["points"]]
    default, chosen, colour = row["default"], row["chosen"], f"C{number}"
    times = [point["seconds"] / default["seconds"] for point in row["points"]]
    works = [point["predicted_work"] / default["predicted_work"] for point in row["points"]]
    return [
        {"label": row["tool"], "colour": colour, "x": sizes, "y": times},
        {"label": None, "colour": colour, "dash": "--", "x": sizes, "y": works},
        {"label": None, "colour": colour, "dash": "D", "x": [chosen["over_default"]],
         "y": [chosen["seconds"] / default["seconds"]]},
    ]  # fmt: skip


def _measure(mockup: Mockup, tool: Tool, plan: Plan) -> Cell:
    default = Scene(mockup)
    poses = np.asarray(sample_poses(default, tool, "nominal", plan.poses, seed=plan.seed))
    predictor = _core.PiecePredictor(mockup, tool)
    size = predictor.optimal_size(plan.memory_limit)
    choosing_s, building_s = least_in_turns(
        lambda: _core.PiecePredictor(mockup, tool).optimal_size(plan.memory_limit),
        lambda: Scene(mockup, voxel_size=size),
    )
    sizes = [size, *(float(f) * default.voxel_size for f in np.geomspace(*_RANGE, plan.sizes))]
    scenes = [default, *(Scene(mockup, voxel_size=size) for size in sizes)]
    times = time_in_turns([Setting(scene, _FILTERS) for scene in scenes], tool, poses, plan.rounds, plan.seed)
    seconds, spread = times.seconds(), times.spread()
    points = [
        {
            "over_default": scene.voxel_size / default.voxel_size,
            "size_m": scene.voxel_size,
            "seconds": seconds[i],
            "quiet_s": float(np.percentile(times.samples[i], 25, axis=0).mean()),
            "quartiles_s": spread[i],
            "samples_s": times.samples[i],
            "predicted_work": predictor.work(scene.voxel_size)[0],
            "build_s": scene.build_seconds,
            "bytes": scene.memory()["total"],
        }
        for i, scene in enumerate(scenes)
    ]
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "default": points[0],
        "chosen": points[1],
        "choosing_s": choosing_s,
        "building_s": building_s,
        "points": points[2:],
    }


def _judged(cell: Cell) -> Cell:
    """The cell with the extra time of the default and the chosen size over the best of the sweep."""
    points = cell["points"]
    best = min(points, key=lambda point: point["seconds"])
    quiet = min(point["quiet_s"] for point in points)
    over = {
        which: {"best": cell[which]["seconds"] / best["seconds"] - 1.0, "quiet": cell[which]["quiet_s"] / quiet - 1.0}
        for which in ("default", "chosen")
    }
    return {
        **cell,
        "best": {**best, "samples_s": []},
        "over": over,
        "chosen_over_default": cell["chosen"]["seconds"] / cell["default"]["seconds"] - 1.0,
        "choosing_share": cell["choosing_s"] / cell["building_s"],
        "rank_correlation": rank_correlation([p["predicted_work"] for p in points], [p["quiet_s"] for p in points]),
    }


def _summary(rows: list[Cell]) -> dict[str, Any]:
    curves = np.array([[p["seconds"] / row["default"]["seconds"] for p in row["points"]] for row in rows])
    memory = np.array([[p["bytes"] / row["default"]["bytes"] for p in row["points"]] for row in rows])
    by_chosen = {
        "over_default": [row["chosen_over_default"] for row in rows],
        "memory": [row["chosen"]["bytes"] / row["default"]["bytes"] for row in rows],
        "bytes_a_triangle": [row["chosen"]["bytes"] / row["mockup_triangles"] for row in rows],
        "build": [row["chosen"]["build_s"] / row["default"]["build_s"] for row in rows],
        "choosing_share": [row["choosing_share"] for row in rows],
    }
    ranks = [row["rank_correlation"] for row in rows]
    return {
        "pairs": len(rows),
        "over": {
            which: {
                key: {"median": float(np.median(found)), "worst": max(found)}
                for key in ("best", "quiet")
                for found in [[row["over"][which][key] for row in rows]]
            }
            for which in ("default", "chosen")
        },
        "chosen": {
            key: {"median": float(np.median(found)), "least": min(found), "most": max(found)}
            for key, found in by_chosen.items()
        },
        "rank_correlation_median": float(np.median(ranks)),
        "rank_correlation_worst": min(ranks),
        "over_default": np.geomspace(*_RANGE, len(rows[0]["points"])),
        "median_time": np.median(curves, axis=0),
        "median_memory": np.median(memory, axis=0),
    }


def _samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    heading = ["mockup", "tool", "piece_size_m", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], point["size_m"], number, pose, seconds]
        for row in rows
        for point in (row["default"], row["chosen"], *row["points"])
        for number, round_ in enumerate(point["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
