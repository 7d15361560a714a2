"""Figure 7 and Table 2: collision time by voxel size, the measured optimum, and the prediction of each estimator."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .. import _core
from ..calibrate import counted, machine_constants
from ..choices import Estimator, Storage
from ..errors import LimitError, OptionError
from ..mockup import Mockup, Tool
from ..samples import sample_poses
from ..scene import Scene, optimal_voxel_size
from .cells import Cell, plain
from .curves import ZONE_ABSOLUTE_S, ZONE_RELATIVE, Fit, epsilon, rank_correlation
from .page import write_study
from .plots import draw_voxel_size
from .runs import measure_pairs
from .subjects import Plan
from .timing import Setting, least_in_turns, machine, mean_work, time_in_turns

PAPERS: tuple[Estimator, ...] = ("area", "diagonal", "side")
ALL = (*PAPERS, "calibrated")

_RANGE = (0.4, 3.6)  # of the ladder's middle
_FILTERS = {"repeat_filter": True, "box_filter": True}


def study_voxel_size(plan: Plan, storage: Storage = "dense", hashing: float = 0.0) -> dict[str, Any]:
    """Measures, writes the study's files, returns the results (as in `results.json`)."""
    if storage not in ("dense", "hashed"):
        raise OptionError(f"storage is {storage!r}: the study of voxel sizes is about 'dense' and 'hashed'")
    machine_constants()
    measure = partial(_measure, plan=plan, storage=storage, hashing=hashing)
    settings = {"sizes": plan.sizes, "storage": storage, "hashing": hashing, "memory_limit": plan.memory_limit}
    rows = [judged(cell) for cell in measure_pairs("voxel-size", plan, plan.pairs(), measure, **settings)]
    found = {"study": "voxel-size", "machine": machine(), "storage": storage, "hashing": hashing, "rows": rows}
    results: dict[str, Any] = plain({**found, "summary": summary(rows)})
    plots = draw_voxel_size(plan.folder, rows)
    write_study(plan.folder, results, samples(rows), plots)
    plan.progress(1.0, "done")
    return results


def _measure(mockup: Mockup, tool: Tool, plan: Plan, storage: Storage, hashing: float) -> Cell:
    """The cell of one pair: the size of each estimator, and the times at a ladder of sizes and at these sizes."""
    around = Scene(mockup)
    poses = np.asarray(sample_poses(around, tool, "nominal", plan.poses, seed=plan.seed))
    del around
    limit = plan.memory_limit
    predicted = {name: optimal_voxel_size(mockup, tool, name) for name in PAPERS}

    def choose() -> float:
        return _core.Predictor(mockup, tool, storage, hashing).optimal_size(machine_constants(), limit)

    predicted["calibrated"] = choose()
    predictor = _core.Predictor(mockup, tool, storage, hashing)
    # The ladder depends only on the paper's estimator, to avoid favouring ours. That one errs to large sizes.
    middle = 0.7 * predicted["area"]
    ladder = [float(size) for size in np.geomspace(_RANGE[0] * middle, _RANGE[1] * middle, plan.sizes)]
    sizes, left_out, scenes = [], [], []

    def build(size: float) -> Scene:
        return Scene(mockup, voxel_size=size, storage=storage, hashing=hashing, memory_limit=limit)

    for size in [*ladder, predicted["area"], predicted["calibrated"]]:
        try:
            scenes.append(build(size))
            sizes.append(size)
        except LimitError:
            left_out.append(size)
    if len(sizes) < 4:
        raise LimitError(
            f"{len(sizes)} of {len(ladder)} sizes fit into {limit} bytes: allow more, or take a smaller mock-up"
        )
    # If the chosen size does not fit, the previous build takes its place.
    choosing_s, building_s = least_in_turns(choose, partial(build, sizes[-1]))
    times = time_in_turns([Setting(scene, _FILTERS) for scene in scenes], tool, poses, plan.rounds, plan.seed)
    seconds, spread = times.seconds(), times.spread()
    points = []
    for i, (size, scene) in enumerate(zip(sizes, scenes, strict=True)):
        points.append(
            {
                "size_m": size,
                "is_ladder": size in ladder,
                "seconds": seconds[i],
                "quartiles_s": spread[i],
                "samples_s": times.samples[i],
                "build_s": scene.build_seconds,
                "bytes": scene.memory()["total"],
                "predicted_s": predictor.seconds(size, machine_constants()),
                "predicted_work": dict(
                    zip(("voxels", "entries", "pairs", "tests"), predictor.work(size)[1:], strict=True)
                ),
                "work": mean_work(scene, tool, poses),
            }
        )
    return {
        "mockup_triangles": mockup.triangle_count,
        "tool_triangles": tool.triangle_count,
        "predicted_m": predicted,
        "choosing_s": choosing_s,
        "building_s": building_s,
        "points": sorted(points, key=lambda point: point["size_m"]),
        "left_out_m": left_out,
    }


def judged(cell: Cell) -> Cell:
    """The cell with the evaluation of its points: optimum, zones, errors of the estimators."""
    points = cell["points"]
    ladder = [point for point in points if point["is_ladder"]]
    fit = Fit.of([p["size_m"] for p in points], [p["seconds"] for p in points])
    optimum = fit.optimum()
    best = fit.seconds(optimum)
    quiet = {p["size_m"]: float(np.percentile(p["samples_s"], 25, axis=0).mean()) for p in points}
    quiet_best = min(quiet[p["size_m"]] for p in ladder)
    measured_best = min(ladder, key=lambda point: point["seconds"])
    zones = {"absolute": fit.zone(best + ZONE_ABSOLUTE_S), "relative": fit.zone(best * (1.0 + ZONE_RELATIVE))}
    estimators = {}
    for name in ALL:
        size = cell["predicted_m"][name]
        exact = [p["seconds"] for p in points if p["size_m"] == size]
        at = exact[0] if exact else fit.seconds(size)
        estimators[name] = {
            "size_m": size,
            "seconds": at,
            "is_measured": bool(exact),
            "over_best": at / measured_best["seconds"] - 1.0,
            "over_quiet_best": quiet[size] / quiet_best - 1.0 if exact else None,
            "over_fit": fit.seconds(size) / best - 1.0,
            "epsilon": {which: epsilon(size, optimum, zone) for which, zone in zones.items()},
        }
    ranked = [quiet[p["size_m"]] for p in points]
    counted_s = [float(np.dot(counted(p["work"], cell["tool_triangles"]), machine_constants())) for p in points]
    return {
        **cell,
        "fit": {
            "optimum_m": optimum,
            "seconds": best,
            "curve": [[p["size_m"], fit.seconds(p["size_m"])] for p in points],
        },
        "best": {"size_m": measured_best["size_m"], "seconds": measured_best["seconds"]},
        "zones": {which: {"least_m": z.least, "most_m": z.most, "is_cut": z.is_cut} for which, z in zones.items()},
        "estimators": estimators,
        "rank_correlation": rank_correlation([p["predicted_s"] for p in points], ranked),
        "rank_of_counted": rank_correlation(counted_s, ranked),
        "choosing_share": cell["choosing_s"] / cell["building_s"],
    }


def summary(rows: list[Cell]) -> dict[str, Any]:
    """Over all pairs: the slowdown of each estimator's size over the sweep's best, and the goals."""
    table = {}
    for name in ALL:
        over = [row["estimators"][name]["over_best"] for row in rows]
        quiet = [row["estimators"][name]["over_quiet_best"] for row in rows]
        is_measured = None not in quiet
        inside = {
            which: sum(row["estimators"][name]["epsilon"][which] <= 1.0 for row in rows)
            for which in ("relative", "absolute")
        }
        table[name] = {
            "over_best_median": float(np.median(over)),
            "over_best_worst": float(max(over)),
            "over_quiet_median": float(np.median(quiet)) if is_measured else None,
            "over_quiet_worst": max(quiet) if is_measured else None,
            "over_fit_median": float(np.median([row["estimators"][name]["over_fit"] for row in rows])),
            "over_fit_worst": float(max(row["estimators"][name]["over_fit"] for row in rows)),
            "in_relative_zone": inside["relative"],
            "in_absolute_zone": inside["absolute"],
        }
    ranks = [row["rank_correlation"] for row in rows]
    shares = [row["choosing_share"] for row in rows]
    return {
        "pairs": len(rows),
        "estimators": table,
        "rank_correlation_median": float(np.median(ranks)),
        "rank_correlation_worst": min(ranks),
        "rank_of_counted_median": float(np.median([row["rank_of_counted"] for row in rows])),
        "rank_of_counted_worst": min(row["rank_of_counted"] for row in rows),
        "choosing_share_median": float(np.median(shares)),
        "choosing_share_worst": max(shares),
    }


def samples(rows: list[Cell]) -> tuple[list[str], list[list[Any]]]:
    """Every measured time: the heading and the rows of the CSV."""
    heading = ["mockup", "tool", "voxel_size_m", "round", "pose", "seconds"]
    return heading, [
        [row["mockup"], row["tool"], point["size_m"], number, pose, seconds]
        for row in rows
        for point in row["points"]
        for number, round_ in enumerate(point["samples_s"])
        for pose, seconds in enumerate(round_)
    ]
