"""What is aimed at, and whether a run met it. Goals are wishes: none of them decides the exit status."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

TIMES_FASTER = {
    ("collide", "nominal"): 5.0,
    ("collide", "deep"): 5.0,
    ("collide", "near"): 3.0,
    ("is_colliding", "nominal"): 3.0,
    ("is_colliding", "near"): 3.0,
    ("distance", "near"): 1.0,
    ("cast", "near"): 1.0,
}
GEOMETRIC_MEAN = 8.0  # of collide, nominal and deep
FINE_COST = 5.0  # a tool ten times finer, at the same place
WORST_US = 1000.0  # of a nominal pose; p99 of contacts
SMALL_TOOL = 5000  # triangles, for which those hold
BUILD_S = {1_600_000: 0.6, 6_400_000: 2.5}  # one core
BYTES_PER_TRIANGLE = 64.0
PEAK_OVER_RESULT = 2.0
BATCH_ON_TWO = 1.9
CALL_US = 2.0

MEASURES = {"median": "of_medians", "p95": "of_p95s"}


def against_best(cell: dict[str, Any]) -> dict[str, Any] | None:
    """feeler against the best peer of a cell, another maybe for the median than for the p95; None without peers."""
    if not cell["ratios"]:
        return None
    found: dict[str, Any] = {"wanted": TIMES_FASTER.get((cell["query"], cell["kind"]))}
    for measure, ratio in MEASURES.items():
        least, peer = min((own["wall"][ratio], name) for name, own in cell["ratios"].items())
        found[measure] = {"peer": peer, "times_faster": least}
    wanted = found["wanted"]
    found["met"] = None if wanted is None else all(found[measure]["times_faster"] >= wanted for measure in MEASURES)
    return found


def geometric_mean(values: Iterable[float]) -> float:
    """Of positive numbers; not a number for none."""
    logs = [math.log(value) for value in values]
    return math.exp(sum(logs) / len(logs)) if logs else math.nan


def scorecard(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Every goal of which something was measured: what was wanted, what was found, whether it is met.

    None: the machine was too busy to tell.
    """
    rows = [*_cells(record), *_contacts(record), *_growth(record), *_alone(record), *_builds(record)]
    return [{"goal": goal, "wanted": wanted, "found": found, "met": met} for goal, wanted, found, met in rows]


Row = tuple[str, str, str, bool | None]


def _cells(record: dict[str, Any]) -> Iterable[Row]:
    by: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for cell in record["cells"]:
        if cell.get("best"):
            by.setdefault((cell["query"], cell["kind"]), []).append(cell["best"])
    for (query, kind), found in by.items():
        wanted = found[0]["wanted"]
        if wanted is None:
            continue
        met = [one["met"] for one in found]
        least = min(one[measure]["times_faster"] for one in found for measure in MEASURES)
        yield (
            f"{query}, {kind}: times faster than the best peer, median and p95",
            f"{wanted:g} in every cell",
            f"{sum(met)} of {len(met)} cells, least {least:.2f}",
            all(met),
        )
    hard = [*by.get(("collide", "nominal"), []), *by.get(("collide", "deep"), [])]
    for measure in MEASURES if hard else ():
        mean = geometric_mean(one[measure]["times_faster"] for one in hard)
        what = f"collide, nominal and deep: {measure}, geometric mean of {len(hard)} cells"
        yield what, f"{GEOMETRIC_MEAN:g}", f"{mean:.2f}", mean >= GEOMETRIC_MEAN


def _contacts(record: dict[str, Any]) -> Iterable[Row]:
    for cell in record["cells"]:
        if cell["query"] == "contacts" and "engines" in cell and cell["tool_triangles"] <= SMALL_TOOL:
            slow = cell["engines"]["feeler"]["wall_us"]["p99"]
            what = f"contacts, {cell['kind']}, {cell['tool']}, {cell['triangles']:,} triangles: p99, µs"
            yield what, f"under {WORST_US:,.0f}", f"{slow:,.0f}", slow < WORST_US


def growth(record: dict[str, Any]) -> list[dict[str, Any]]:
    """From the smallest to the largest mock-up, per tool: how the nominal median grows, and the pairs found."""
    rows = []
    nominal = [c for c in record["cells"] if c["query"] == "collide" and c["kind"] == "nominal" and "engines" in c]
    for tool in dict.fromkeys(cell["tool"] for cell in nominal):
        own = sorted((cell for cell in nominal if cell["tool"] == tool), key=lambda cell: cell["triangles"])
        if len(own) < 2:
            continue
        small, large = own[0], own[-1]
        rows.append(
            {
                "tool": tool,
                "from": small["triangles"],
                "to": large["triangles"],
                "pairs": large["pairs"]["median"] / max(1.0, small["pairs"]["median"]),
                "median": {
                    name: large["engines"][name]["wall_us"]["median"] / small["engines"][name]["wall_us"]["median"]
                    for name in large["engines"]
                    if name in small["engines"]
                },
            }
        )
    return rows


def _growth(record: dict[str, Any]) -> Iterable[Row]:
    for row in record["growth"]:
        own = row["median"]["feeler"]
        what = f"growth of the nominal median, {row['tool']}, {row['from']:,} to {row['to']:,} triangles"
        yield what, f"less than the pairs', {row['pairs']:.2f}", f"{own:.2f}", own < row["pairs"]
    for row in record["fine"]:
        what = f"{row['tool']} {row['finer']:.0f} times finer, same poses, {row['triangles']:,} triangles: times slower"
        yield what, f"less than {FINE_COST:g}", f"{row['times_slower']:.2f}", row["times_slower"] < FINE_COST


def _alone(record: dict[str, Any]) -> Iterable[Row]:
    for row in record["worst"]:
        slowest = row["wall_us"]["worst"]
        what = f"worst of {row['poses']:,} nominal poses, {row['tool']}, {row['triangles']:,} triangles, µs"
        yield what, f"under {WORST_US:,.0f}", f"{slowest:,.0f}", slowest < WORST_US
    for row in record["batch"]:
        if "two_over_one" in row:
            what = f"collide_batch, {row['tool']}: rate on two threads over one"
            apart = f"; two apart {row['apart_over_one']:.2f}" if "apart_over_one" in row else ""
            found = f"{row['two_over_one']:.2f} (had {row['cores_had']:.2f} cores{apart})"
            met = row["two_over_one"] >= BATCH_ON_TWO
            # Without two free cores, nothing is known.
            yield what, f"{BATCH_ON_TWO:g}", found, met or (None if row["cores_had"] < BATCH_ON_TWO else False)
    if record["python_call"]:
        cost = record["python_call"]["over_core_us"]
        yield "a Python call over the core's time, µs", f"{CALL_US:g}", f"{cost:.2f}", cost <= CALL_US


def _builds(record: dict[str, Any]) -> Iterable[Row]:
    for size in record["sizes"]:
        build = next(row for row in size["builds"] if row["engine"] == "feeler")
        what = f"{size['triangles']:,} triangles"
        if size["triangles_asked"] in BUILD_S:
            wanted, seconds = BUILD_S[size["triangles_asked"]], build["one_core_s"]
            yield f"build of {what}, one core, s", f"at most {wanted:g}", f"{seconds:.2f}", seconds <= wanted
        each = build["bytes_per_triangle"]
        yield f"bytes a triangle, {what}", f"at most {BYTES_PER_TRIANGLE:g}", f"{each:.1f}", each <= BYTES_PER_TRIANGLE
        # Where the index is small beside what the process holds anyway, its peak cannot be told.
        if build["peak_growth_bytes"] and build["bytes"] > 50e6:
            # The engine counts the mock-up's arrays, which were there before: they are part of the peak as well.
            before = build["bytes"] - build["rss_growth_bytes"]
            peak = (before + build["peak_growth_bytes"]) / build["bytes"]
            what = f"peak while building over the result, {what}"
            yield what, f"at most {PEAK_OVER_RESULT:g}", f"{peak:.2f}", peak <= PEAK_OVER_RESULT
