"""Puts every cell of a benchmark record, the funnel and the goals into docs/performance.md, between its markers.

examples:
    python bench/cells.py                                    the newest record in bench/records
    python bench/cells.py bench/records/2026-11-20-x-1.json  a given one
"""

from __future__ import annotations

import sys
from typing import Any

from goals import MEASURES
from page import PERFORMANCE, fill
from readme import NAMES, SHOWN, asked_for

STAGES = {
    "voxels_visited": "nodes",
    "clusters_placed": "clusters placed",
    "pieces_scanned": "pieces scanned",
    "entries_scanned": "boxes meet",
    "box_survivors": "planes meet",
    "repeats_skipped": "repeats",
    "triangle_tests": "triangle tests",
    "exact_tests": "exact tests",
    "pairs": "pairs",
}


def figures(record: dict[str, Any], name: str) -> str:
    """A table a mock-up, the funnel of the one shown in README.md, the goals, and what it was measured with."""
    parts = [part for size in record["sizes"] for part in _size(record, size)]
    return "\n\n".join([*parts, *_funnel(record), *_goals(record), _about(record, name)])


def _asked(cell: dict[str, Any], engine: str) -> str:
    """The times of an engine in a cell, where it can answer such a query."""
    return _times(cell["engines"][engine]) if engine in cell["engines"] else "–"


def _size(record: dict[str, Any], size: dict[str, Any]) -> list[str]:
    """Heading and table of one mock-up."""
    peers = [peer for peer in record["engines"] if peer != "feeler"]
    own = [cell for cell in record["cells"] if cell["triangles_asked"] == size["triangles_asked"]]
    heads = ["feeler", *(NAMES[peer] for peer in peers)]
    lines = [
        f"| tool | query, pose | pairs | {' | '.join(heads)} |{' times faster |' if peers else ''}",
        f"|---|---|---:|{'---:|' * len(heads)}{'---:|' if peers else ''}",
    ]
    for cell in own:
        head = f"| {cell['tool']} | {cell['query']}, {cell['kind']} |"
        if "problem" in cell:
            lines.append(f"{head} no such pose found |{' |' * (len(heads) + bool(peers))}")
            continue
        row = [f"{cell['pairs']['median']:,.0f}", *(_asked(cell, engine) for engine in ("feeler", *peers))]
        if best := cell["best"]:
            median, p95 = (f"{best[measure]['times_faster']:.1f}" for measure in MEASURES)
            row.append(f"{median} ({p95}){' missed' if best['met'] is False else ''}")
        elif peers:
            row.append("")
        lines.append(f"{head} {' | '.join(row)} |")
    return [f"### {size['triangles']:,} triangles in {size['parts']:,} parts", "\n".join(lines)]


def _funnel(record: dict[str, Any]) -> list[str]:
    """The funnel at the size README.md shows, or the largest."""
    sizes = [size["triangles_asked"] for size in record["sizes"]]
    shown = SHOWN if SHOWN in sizes else sizes[-1]
    cells = [cell for cell in record["cells"] if cell["triangles_asked"] == shown and "funnel" in cell]
    if not cells:
        return []
    lines = [
        f"| tool | pose | {' | '.join(STAGES.values())} |",
        f"|---|---|{'---:|' * len(STAGES)}",
    ]
    for cell in cells:
        counts = [f"{cell['funnel'][stage]:,.0f}" if stage in cell["funnel"] else "" for stage in STAGES]
        lines.append(f"| {cell['tool']} | {cell['kind']} | {' | '.join(counts)} |")
    heading = f"### The funnel at {cells[0]['triangles']:,} triangles, means over poses"
    return [heading, "\n".join(lines)]


def _goals(record: dict[str, Any]) -> list[str]:
    said = {True: "met", False: "**missed**", None: "machine too busy to tell"}
    lines = ["| goal | wanted | found | |", "|---|---|---|---|"]
    lines += [f"| {row['goal']} | {row['wanted']} | {row['found']} | {said[row['met']]} |" for row in record["goals"]]
    return ["### Goals", "\n".join(lines)]


def _about(record: dict[str, Any], name: str) -> str:
    commit = [f"commit {record['commit'][:7]}"] if record["commit"] else []
    versions = [f"{NAMES[peer]} {version}" for peer, version in record["versions"].items() if peer in NAMES]
    facts = ", ".join([record["machine"]["cpu"], record["when"][:10], *commit, *versions])
    absent = "".join(f" {NAMES[peer]} was absent." for peer in record["absent"])
    return (
        "Microseconds a pose, wall clock, one core, called from Python: median (p95) over poses, each the best of its "
        'rounds. Times faster: than the best of the others by median (by p95); "missed": less than was aimed at. '
        f"{facts}, [{name}](../bench/records/{name}).{absent}"
    )


def _times(figures: dict[str, Any]) -> str:
    median, p95 = (figures["wall_us"][measure] for measure in MEASURES)
    return f"{_us(median)} ({_us(p95)})"


def _us(value: float) -> str:
    return f"{value:.1f}" if value < 9.95 else f"{value:,.0f}"


def main() -> int:
    text = figures(*asked_for(__doc__))
    fill(PERFORMANCE, "cells: bench/cells.py", text)
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
