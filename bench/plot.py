"""The plot of a record: per tool, how the nominal times grow with the mock-up, one line an engine.

examples:
    python bench/plot.py bench/records/2026-11-20-x-1.json     again, from a record
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

COLOURS = {"feeler": "#d62728", "embree": "#1f77b4", "coal": "#2ca02c", "fcl": "#9467bd", "parry": "#8c6d31"}


def draw(record: dict[str, Any], path: Path) -> str | None:
    """Write the plot; or say why there is none."""
    cells = [c for c in record["cells"] if c["query"] == "collide" and c["kind"] == "nominal" and "engines" in c]
    if not cells:
        return "no plot: no nominal cells of collide"
    try:
        import matplotlib
    except ImportError:
        return "no plot: matplotlib is not installed (pip install 'feeler[study]')"
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    tools = list(dict.fromkeys(cell["tool"] for cell in cells))
    columns = min(3, len(tools) + 1)
    rows = -(-(len(tools) + 1) // columns)  # one more, for the legend
    figure, grid = pyplot.subplots(rows, columns, figsize=(4.4 * columns, 3.6 * rows), squeeze=False)
    panels = list(grid.flat)
    for panel, tool in zip(panels, tools, strict=False):
        own = sorted((cell for cell in cells if cell["tool"] == tool), key=lambda cell: cell["triangles"])
        for engine in record["engines"]:
            points = [
                (cell["triangles"], cell["engines"][engine]["wall_us"]) for cell in own if engine in cell["engines"]
            ]
            sizes = [size for size, _ in points]
            colour, heavy = COLOURS.get(engine, "#7f7f7f"), engine == "feeler"
            medians = [wall["median"] for _, wall in points]
            panel.plot(sizes, medians, "o-", color=colour, label=engine, linewidth=2.4 if heavy else 1.5, markersize=4)
            panel.plot(sizes, [wall["p95"] for _, wall in points], ":", color=colour, linewidth=0.9)
        panel.set_xscale("log")
        panel.set_yscale("log")
        ticks = [cell["triangles"] for cell in own]
        panel.set_xticks(ticks, [_short(size) for size in ticks])
        panel.set_xticks([], minor=True)
        panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.yaxis.set_minor_locator(NullLocator())
        panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
        panel.set_title(f"{tool}, {own[0]['tool_triangles']:,} triangles", fontsize=10)
        panel.set_xlabel("triangles of the mock-up", fontsize=9)
        panel.set_ylabel("µs a pose", fontsize=9)
        panel.grid(True, which="major", color="#e0e0e0", linewidth=0.7)
        panel.tick_params(labelsize=8)
    for panel in panels[len(tools) :]:
        panel.axis("off")
    legend = panels[len(tools)]
    handles, labels = panels[0].get_legend_handles_labels()
    legend.legend(handles, labels, loc="upper left", frameon=False, title="median; dotted: p95", alignment="left")
    machine = f"{record['machine']['cpu']}, {record['when'][:10]}"
    figure.suptitle(f"All colliding pairs, nominal poses, one core ({machine})", fontsize=11)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return None


def _short(count: int) -> str:
    return f"{count / 1e6:.3g}M" if count >= 999_500 else f"{count / 1e3:.0f}k"


def main() -> int:
    """Draw a record's plot beside it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("record", type=Path, help="a record of `make bench`")
    path: Path = parser.parse_args().record
    problem = draw(json.loads(path.read_text(encoding="utf-8")), path.with_suffix(".png"))
    print(problem or f"Written: {path.with_suffix('.png')}")
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
