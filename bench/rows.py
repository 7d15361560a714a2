"""The rows of a run, in the form of `record.py`, from the results of `run.py`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from record import STAGES, Row


def rows(found: dict[str, Any]) -> Iterator[Row]:
    """A row per cell and engine, per build, and per measurement of feeler alone."""
    versions = found["versions"]
    for cell in found["cells"]:
        for row in _cell(cell):
            yield {"what": "cell", "version": versions[row["engine"]], **row}
    for size in found["sizes"]:
        about = {"size": size["triangles_asked"], "triangles": size["triangles"], "parts": size["parts"]}
        for build in size["builds"]:
            yield {
                **{"what": "build", **about, "engine": build["engine"], "version": versions[build["engine"]]},
                **{name: build[name] for name in ("one_core_s", "all_cores_s", "bytes")},
                "growth_bytes": build["rss_growth_bytes"],
                "peak_bytes": build["peak_growth_bytes"],
            }
    for what in ("fine", "worst", "batch"):
        for one in found[what]:
            about = {"size": one["triangles_asked"], "triangles": one["triangles"], "parts": one["parts"]}
            about |= {"what": what, "tool": one["tool"], "kind": "nominal", "query": "collide", "poses": one["poses"]}
            yield {**about, "engine": "feeler", "version": versions["feeler"], **_alone(what, one)}
    for engine, cost in found["overheads"].items():
        if engine != "clock_alone":
            call: Row = {"what": "call", "query": "collide", "engine": engine, "version": versions[engine]}
            call["median_us"] = cost["wall_us"]
            if engine == "feeler" and found["python_call"]:
                call["over_core_us"] = found["python_call"]["over_core_us"]
            yield call


def _cell(cell: dict[str, Any]) -> Iterator[Row]:
    about: Row = {"size": cell["triangles_asked"]}
    about |= {name: cell[name] for name in ("tool", "kind", "query", "triangles", "parts", "tool_triangles")}
    if "problem" in cell:
        yield {**about, "engine": "feeler", "poses": 0}
        return
    about |= {"poses": cell["poses"], "pairs": cell["pairs"]["median"]}
    for engine, figures in cell["engines"].items():
        row = {**about, "engine": engine, "rounds": figures.get("rounds", cell["rounds"]), **_times(figures["wall_us"])}
        if engine == "feeler":
            row["pairs_mean"] = cell["pairs"]["mean"]
            row |= {stage: cell["funnel"][stage] for stage in STAGES[:-1]} if "funnel" in cell else {}
        else:
            ratios = cell["ratios"][engine]["wall"]
            row |= {"times_faster": ratios["of_medians"], "times_faster_p95": ratios["of_p95s"]}
            row |= agreement_counts(cell["agreement"][engine])
        yield row


def _times(spread: dict[str, float]) -> Row:
    return {f"{name}_us": spread[name] for name in ("median", "p95", "p99", "worst")}


def agreement_counts(counts: dict[str, Any]) -> Row:
    """Pairs, or answers of a pose: of those where the two differ, who is wrong."""
    peer = ("feeler_only_true", "peer_only_false", "peer_wrong", "peer_earlier", "peer_later")
    return {
        "agreed": counts["agreed"],
        "peer_wrong": sum(counts.get(name, 0) for name in peer),
        "feeler_wrong": counts.get("feeler_wrong", 0),
        "unjudged": counts.get("unjudged", 0),
    }


def _alone(what: str, one: dict[str, Any]) -> Row:
    if what == "fine":
        return {**_times(one["fine_us"]), "times_slower": one["times_slower"]}
    if what == "worst":
        return {**_times(one["wall_us"]), "tool_triangles": one["tool_triangles"]}
    rates = ("calls_per_s", "batch_1_per_s", "batch_2_per_s", "apart_2_per_s", "cores_had")
    return {name: one.get(name) for name in rates}
