"""The effect of each filter before the triangle test (the paper: half the time, together)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene, optimal_voxel_size
from .cells import Cell, plain
from .page import write_study
from .plots import draw_lines
from .runs import measure_pairs
from .subjects import Plan
from .timing import Setting, machine, time_in_turns

CASES = {
    "neither": {"repeat_filter": False, "box_filter": False},
    "repeats": {"repeat_filter": True, "box_filter": False},
    "boxes": {"repeat_filter": False, "box_filter": True},
    "both": {"repeat_filter": True, "box_filter": True},
}
STORES = ("dense", "blocks")


def study_filters(plan: Plan) -> dict[str, Any]:
    """Measures, writes the study's files, returns the results."""
    pairs, limit = plan.pairs(), plan.memory_limit
    measure = partial(_measure, plan=plan)
    rows = list(measure_pairs("filters", plan, pairs, measure, memory_limit=limit))
    summary = {}
    for storage in STORES:
        saved = [1.0 - row["seconds"][storage]["both"] / row["seconds"][storage]["neither"] for row in rows]
        summary[storage] = {
            "saved_median": float(np.median(saved)),
            "saved_least": min(saved),
            "saved_most": max(saved),
        }
    results: dict[str, Any] = plain({"study": "filters", "machine": machine(), "rows": rows, "summary": summary})
    write_study(plan.folder, results, _samples(rows), draw_lines(plan.folder, "filters", _panels(rows), columns=2))
    plan.progress(1.0, "done")
    return results


def _measure(mockup: Mockup, tool: Tool, plan: Plan) -> Cell:
    blocks = Scene(mockup)
    poses = np.asarray(sample_poses(blocks, tool, "nominal", plan.poses, seed=plan.seed))
    size = optimal_voxel_size(mockup, tool, memory_limit=plan.memory_limit)
    scenes = {
        "dense": Scene(mockup, voxel_size=size, storage="dense", memory_limit=plan.memory_limit),
        "blocks": blocks,
    }
    keys = [(storage, case) for storage in STORES for case in CASES]
    settings = [Setting(scenes[storage], CASES[case]) for storage, case in keys]
    times = time_in_turns(settings, tool, poses, plan.rounds, plan.seed)
    seconds: dict[str, dict[str, float]] = {storage: {} for storage in STORES}
    raw: dict[str, dict[str, Any]] = {storage: {} for storage in STORES}
    for (storage, case), value, samples in zip(keys, times.seconds(), times.samples, strict=True):
        seconds[storage][case] = value
        raw[storage][case] = {"samples_s": samples}
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "dense_size_m": size,
        "seconds": seconds,
        "samples": raw,
    }


def _panels(rows: list[Cell]) -> list[dict[str, Any]]:
    colours = {"neither": "#7f7f7f", "repeats": "#1f77b4", "boxes": "#2ca02c", "both": "#d62728"}
    names = [f"{row['mockup'][:4]} {row['tool'][:3]}" for row in rows]
    return [
        {
            "title": f"{storage}, times over those with both filters", "x": "pair", "y": "times", "log": "",
            "lines": [
                {"label": case, "colour": colours[case], "dash": "o", "x": names,
                 "y": [row["seconds"][storage][case] / row["seconds"][storage]["both"] for row in rows]}
                for case in CASES
            ],
        }
        for storage in STORES
    ]  # fmt: skip


def _samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    heading = ["mockup", "tool", "storage", "filters", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], storage, case, number, pose, seconds]
        for row in rows
        for storage, cases in row["samples"].items()
        for case, each in cases.items()
        for number, round_ in enumerate(each["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
