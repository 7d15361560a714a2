"""The record as tables for people."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table

LEAST_WIDTH = 150  # in a narrower terminal lines fold, but no figure is cut off


def console() -> Console:
    """Standard output, wide enough for the tables wherever it goes."""
    return Console(width=max(Console().width, LEAST_WIDTH))


def show(record: dict[str, Any], out: Console) -> None:
    """Query times, builds, the funnel, whether the engines agree, and a summary."""
    peers = [name for name in record["engines"] if name != "feeler"]
    for size in record["sizes"]:
        cells = [cell for cell in record["cells"] if cell["triangles_asked"] == size["triangles_asked"]]
        out.print(_queries(size, cells, peers))
        out.print()
    out.print(_builds(record["sizes"]))
    out.print()
    out.print(_funnel(record["cells"]))
    out.print()
    for line in summary(record, peers):
        out.print(line, highlight=False, soft_wrap=True)


def _queries(size: dict[str, Any], cells: list[dict[str, Any]], peers: list[str]) -> Table:
    title = f"engine, {size['triangles']:,} triangles, {size['parts']:,} parts: µs a pose, wall, median / p95 / worst"
    table = _table(title, "tool", "triangles", "poses", "pairs")
    right = {"justify": "right", "no_wrap": True}
    table.add_column("feeler", **right)
    for peer in peers:
        table.add_column(peer, **right)
        table.add_column("times faster\nmedians / p95s", **right)
        table.add_column("per pose", **right)
        table.add_column("pairs in one only", **right)
    for cell in cells:
        head = (cell["tool"], f"{cell['tool_triangles']:,}", cell["kind"])
        if cell.get("poses", 0) < cell.get("poses_asked", 0):
            head = (*head[:2], f"{cell['kind']} ({cell['poses']} found)")
        if "problem" in cell:
            table.add_row(*head, "-", f"[yellow]{cell['problem'][:60]}")
            continue
        row = [*head, f"{cell['pairs']['median']:,.0f}", _times(cell["engines"]["feeler"])]
        for peer in peers:
            ratio = cell["ratios"][peer]["wall"]
            colour = "green" if ratio["of_medians"] >= 1 else "red"
            row += [
                _times(cell["engines"][peer]),
                f"[{colour}]{ratio['of_medians']:.2f} / {ratio['of_p95s']:.2f}",
                f"{ratio['median_per_pose']:.2f}",
                _agreement(cell["agreement"][peer]),
            ]
        table.add_row(*row)
    return table


def _times(figures: dict[str, Any]) -> str:
    wall = figures["wall_us"]
    return f"{_us(wall['median'])} / {_us(wall['p95'])} / {_us(wall['worst'])}"


def _us(value: float) -> str:
    return f"{value:,.1f}" if value < 100 else f"{value:,.0f}"


def _agreement(found: dict[str, Any]) -> str:
    if found["feeler_wrong"]:
        return f"[bold red]{found['feeler_wrong']} WRONG IN FEELER"
    missed, invented = found["feeler_only_true"], found["peer_only_false"]
    return f"{missed:,} missed, {invented:,} made up" if missed or invented else "none"


def _builds(sizes: list[dict[str, Any]]) -> Table:
    table = _table("Build and memory", "mock-up", "engine")
    for heading in ("one core, s", "all cores, s", "bytes / triangle", "process growth / triangle"):
        table.add_column(heading, justify="right")
    for size in sizes:
        for row in size["builds"]:
            growth = row["rss_growth_bytes_per_triangle"]
            table.add_row(
                f"{size['triangles']:,}",
                row["engine"],
                f"{row['one_core_s']:.3f}",
                "one core only" if row["all_cores_s"] is None else f"{row['all_cores_s']:.3f}",
                f"{row['bytes_per_triangle']:.1f}",
                "-" if growth is None else f"{growth:.1f}",
            )
    return table


def _funnel(cells: list[dict[str, Any]]) -> Table:
    cells = [cell for cell in cells if "funnel" in cell]
    stages = list(dict.fromkeys(stage for cell in cells for stage in cell["funnel"]))
    table = _table("What a feeler query does, mean over poses", "mock-up", "tool", "poses")
    for stage in stages:
        table.add_column(stage.replace("_", " "), justify="right")
    for cell in cells:
        counts = (f"{cell['funnel'].get(stage, 0.0):,.1f}" for stage in stages)
        table.add_row(f"{cell['triangles']:,}", cell["tool"], cell["kind"], *counts)
    return table


MEMORY_NOTE = (
    "Bytes are as each engine counts its own: feeler with the mock-up's arrays, Coal (memUsage) with its copy of them. "
    "Process growth is what the system saw during a build; feeler's mock-up was there before."
)


def summary(record: dict[str, Any], peers: list[str]) -> list[str]:
    """A few lines: what calls cost, how much faster overall, where not, and whether all pairs are right."""
    lines = [MEMORY_NOTE]
    costs = ", ".join(f"{name.replace('_', ' ')} {cost['wall_us']:.2f}" for name, cost in record["overheads"].items())
    lines.append(f"A call with nothing to do, µs (not subtracted): {costs}.")
    for peer in peers:
        cells = [cell for cell in record["cells"] if peer in cell.get("ratios", {})]
        for kind in dict.fromkeys(cell["kind"] for cell in cells):
            own = [cell["ratios"][peer]["wall"] for cell in cells if cell["kind"] == kind]
            medians, p95s = [r["of_medians"] for r in own], [r["of_p95s"] for r in own]
            lines.append(
                f"{kind}: feeler is {_geometric_mean(medians):.2f} times as fast as {peer} in median (least "
                f"{min(medians):.2f}), {_geometric_mean(p95s):.2f} in p95 (least {min(p95s):.2f}), "
                f"geometric means of {len(own)} cells."
            )
        found = [cell["agreement"][peer] for cell in cells]
        total = {key: sum(f[key] for f in found) for key in found[0] if key != "examples"} if found else {}
        if total:
            wrong = total["feeler_wrong"]
            lines.append(
                f"Pairs: feeler and {peer} agree on {total['agreed']:,}; of the others, judged in exact arithmetic, "
                f"{peer} missed {total['feeler_only_true']:,} and made up {total['peer_only_false']:,}; "
                + (f"[bold red]feeler is wrong on {wrong:,}[/]." if wrong else "feeler is wrong on none.")
            )
    load = record["load_average"]
    if load["before"] and max(load["before"][0], load["after"][0]) > 1.5:
        lines.append(
            f"[yellow]The machine was busy (load {load['before'][0]} before, {load['after'][0]} after): "
            "the figures are noisy.[/]"
        )
    return lines


def _geometric_mean(values: list[float]) -> float:
    return math.exp(sum(math.log(value) for value in values) / len(values))


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", header_style="dim", box=None, pad_edge=False)
    for column in columns:
        justify = "right" if column in ("triangles", "pairs") else "left"
        table.add_column(column, justify=justify, no_wrap=True)
    return table
