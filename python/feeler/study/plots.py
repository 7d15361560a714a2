"""The plots of the studies, each as PNG and SVG. Without matplotlib there are none, and the page says so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import OptionError

COLOURS = {
    "measured": "#222222", "predicted": "#d62728", "area": "#1f77b4", "diagonal": "#2ca02c", "side": "#9467bd",
    "calibrated": "#d62728", "dense": "#1f77b4", "hashed": "#8c6d31", "blocks": "#d62728",
}  # fmt: skip
MISSING = "There are no plots: matplotlib is not installed (pip install 'feeler[study]')."


@contextmanager
def _pictures(folder: Path, name: str, rows: int, columns: int, side: tuple[float, float]) -> Iterator[Any]:
    """Yields a grid of axes, (rows, columns), saves it as NAME.png and NAME.svg."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, grid = pyplot.subplots(rows, columns, figsize=(side[0] * columns, side[1] * rows), squeeze=False)
    try:
        yield grid
        figure.tight_layout()
        with matplotlib.rc_context({"svg.hashsalt": name}):
            figure.savefig(folder / f"{name}.png", dpi=80)
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    except OSError as error:
        raise OptionError(f"cannot write plots to {folder}: {error.strerror or error}; choose another --out") from None
    finally:
        pyplot.close(figure)


def _is_there() -> bool:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return False
    return True


def _plain_axes(axes: Any, title: str, x: str, y: str) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for scale, axis in ((axes.get_xscale(), axes.xaxis), (axes.get_yscale(), axes.yaxis)):
        if scale == "log":
            axis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=12))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
    axes.set_title(title, fontsize=9)
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.grid(True, color="#e4e4e4", linewidth=0.6)


def _short(value: float) -> str:
    for factor, letter in ((1e6, "M"), (1e3, "k")):
        if value >= factor:
            return f"{value / factor:g}{letter}"
    return f"{value:g}"


def draw_voxel_size(folder: Path, rows: list[dict[str, Any]]) -> list[str]:
    """One panel per pair: measured and predicted time by voxel size, the fit, and the size of each estimator."""
    if not _is_there():
        return []
    mockups, tools = ([*dict.fromkeys(row[what] for row in rows)] for what in ("mockup", "tool"))
    with _pictures(folder, "voxel-size", len(mockups), len(tools), (3.4, 2.7)) as grid:
        for axes in grid.flat:
            axes.axis("off")
        for row in rows:
            axes = grid[mockups.index(row["mockup"])][tools.index(row["tool"])]
            axes.axis("on")
            sizes = [1e3 * p["size_m"] for p in row["points"]]
            low = [1e6 * min(p["quartiles_s"][0], p["seconds"]) for p in row["points"]]
            high = [1e6 * max(p["quartiles_s"][1], p["seconds"]) for p in row["points"]]
            axes.fill_between(sizes, low, high, color="#bbbbbb", alpha=0.6, linewidth=0)
            axes.plot(sizes, [1e6 * p["seconds"] for p in row["points"]], "o", color=COLOURS["measured"], markersize=3)
            axes.plot([1e3 * d for d, _ in row["fit"]["curve"]], [1e6 * t for _, t in row["fit"]["curve"]], "-",
                      color=COLOURS["measured"], linewidth=0.9)  # fmt: skip
            axes.plot(
                sizes, [1e6 * p["predicted_s"] for p in row["points"]], "--", color=COLOURS["predicted"], linewidth=1.2
            )
            for name, found in row["estimators"].items():
                if sizes[0] * 0.5 <= 1e3 * found["size_m"] <= sizes[-1] * 2.0:
                    axes.axvline(1e3 * found["size_m"], color=COLOURS[name], linewidth=1.0, label=name)
            axes.set_xscale("log")
            axes.set_yscale("log")
            _plain_axes(axes, f"{row['mockup']}, {row['tool']}", "voxel size, mm", "µs a query")
        grid.flat[0].legend(fontsize=6, frameon=False)
    return ["voxel-size"]


def draw_lines(folder: Path, name: str, panels: Sequence[dict[str, Any]], columns: int = 3) -> list[str]:
    """Panels with lines: {title, x, y, log, lines: [{label, colour, dash, x: [...], y: [...]}]}."""
    if not _is_there():
        return []
    rows = -(-len(panels) // columns)
    with _pictures(folder, name, rows, min(columns, len(panels)), (4.0, 3.0)) as grid:
        for axes in grid.flat[len(panels) :]:
            axes.axis("off")
        for axes, panel in zip(grid.flat, panels, strict=False):
            for line in panel["lines"]:
                colour = COLOURS.get(line["colour"], line["colour"])
                axes.plot(line["x"], line["y"], line.get("dash", "o-"), color=colour, label=line["label"],
                          linewidth=1.3, markersize=3)  # fmt: skip
            if "x" in panel["log"]:
                axes.set_xscale("log")
            if "y" in panel["log"]:
                axes.set_yscale("log")
            _plain_axes(axes, panel["title"], panel["x"], panel["y"])
            if isinstance(panel["lines"][0]["x"][0], str):
                axes.tick_params(axis="x", labelrotation=70)
            axes.legend(fontsize=6, frameon=False)
    return [name]
