"""Figures 9 and 10: collision time by the size of the mock-up, and by the size of the tool."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..errors import LimitError
from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene, optimal_voxel_size
from .cells import Cell, plain
from .curves import power_law
from .page import write_study
from .plots import draw_lines
from .runs import Pair, measure_pairs
from .subjects import Plan
from .timing import Setting, machine, time_in_turns

_FILTERS = {"repeat_filter": True, "box_filter": True}
STORES = ("dense", "blocks")


def study_scaling(plan: Plan, by_mockup: list[Pair], by_tool: list[Pair]) -> dict[str, Any]:
    """Measures, writes the study's files, returns the results.

    by_mockup: pairs with one or more tools and growing mock-ups; by_tool: one mock-up and growing tools.
    """
    pairs = {(m.key, t.key): (m, t) for m, t in sorted([*by_mockup, *by_tool], key=lambda pair: pair[0].key)}
    measure = partial(_measure, plan=plan)
    cells = measure_pairs("scaling", plan, list(pairs.values()), measure, memory_limit=plan.memory_limit)
    done = dict(zip(pairs, cells, strict=True))
    trends, panels = [], []
    for of, chosen, fixed, count in (
        ("mock-up", by_mockup, "tool", "mockup_triangles"),
        ("tool", by_tool, "mockup", "tool_triangles"),
    ):
        rows = [done[m.key, t.key] for m, t in chosen]
        for name in dict.fromkeys(row[fixed] for row in rows):
            own = sorted((row for row in rows if row[fixed] == name), key=lambda row: float(row[count]))
            lines = []
            for storage in STORES:
                known = [row for row in own if row["seconds"][storage] is not None]
                if len(known) < 2 or known[0][count] == known[-1][count]:
                    continue
                x, y = [row[count] for row in known], [row["seconds"][storage] for row in known]
                exponent, factor = power_law(x, y)
                trends.append({"of": of, "with": name, "storage": storage, "exponent": exponent})
                lines.append({"label": storage, "colour": storage, "x": x, "y": [1e6 * t for t in y]})
                lines.append({"label": f"size to the {exponent:.2f}", "colour": storage, "dash": ":", "x": x,
                              "y": [1e6 * factor * n**exponent for n in x]})  # fmt: skip
            if lines:
                panels.append(
                    {"title": name, "x": f"triangles of the {of}", "y": "µs a query", "log": "xy", "lines": lines}
                )
    rows = list(done.values())
    results: dict[str, Any] = plain(
        {"study": "scaling", "machine": machine(), "rows": rows, "summary": {"trends": trends}}
    )
    write_study(plan.folder, results, _samples(rows), draw_lines(plan.folder, "scaling", panels) if panels else [])
    plan.progress(1.0, "done")
    return results


def _measure(mockup: Mockup, tool: Tool, plan: Plan) -> Cell:
    scenes = {"blocks": Scene(mockup)}
    poses = np.asarray(sample_poses(scenes["blocks"], tool, "nominal", plan.poses, seed=plan.seed))
    size: float | None = optimal_voxel_size(mockup, tool, memory_limit=plan.memory_limit)
    try:
        scenes["dense"] = Scene(mockup, voxel_size=size, storage="dense", memory_limit=plan.memory_limit)
    except LimitError:
        size = None
    times = time_in_turns([Setting(scene, _FILTERS) for scene in scenes.values()], tool, poses, plan.rounds, plan.seed)
    seconds: dict[str, float | None] = dict.fromkeys(STORES)
    seconds.update(zip(scenes, times.seconds(), strict=True))
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "dense_size_m": size,
        "seconds": seconds,
        "build_s": {name: scene.build_seconds for name, scene in scenes.items()},
        "samples": {name: {"samples_s": times.samples[i]} for i, name in enumerate(scenes)},
    }


def _samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    heading = ["mockup", "tool", "mockup_triangles", "tool_triangles", "storage", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], row["mockup_triangles"], row["tool_triangles"], storage, number, pose, seconds]
        for row in rows
        for storage, each in row["samples"].items()
        for number, round_ in enumerate(each["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
