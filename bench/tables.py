"""The record as tables for people."""

from __future__ import annotations

from typing import Any

from goals import MEASURES, geometric_mean
from rich.console import Console
from rich.table import Table

LEAST_WIDTH = 200  # in a narrower terminal lines fold, but no figure is cut off


def console() -> Console:
    """Standard output, wide enough for the tables wherever it goes."""
    return Console(width=max(Console().width, LEAST_WIDTH))


def show(record: dict[str, Any], out: Console) -> None:
    """Query times against the best peer, builds, the funnel, what feeler was asked alone, the goals, a summary."""
    peers = [name for name in record["engines"] if name != "feeler"]
    for size in record["sizes"]:
        cells = [cell for cell in record["cells"] if cell["triangles_asked"] == size["triangles_asked"]]
        out.print(_queries(size, cells, peers))
        out.print()
    tables = [_builds(record["sizes"])]
    tables += [_funnel(record["cells"])] if any("funnel" in cell for cell in record["cells"]) else []
    tables += [_agreement(record["cells"], peers)] if peers else []
    tables += [_growth(record["growth"])] if record["growth"] else []
    tables += [_alone(record)] if record["worst"] or record["batch"] else []
    for table in (*tables, _goals(record["goals"])):
        out.print(table)
        out.print()
    for line in summary(record, peers):
        out.print(line, highlight=False, soft_wrap=True)


def _queries(size: dict[str, Any], cells: list[dict[str, Any]], peers: list[str]) -> Table:
    title = f"engine, {size['triangles']:,} triangles, {size['parts']:,} parts: µs a pose, wall, median / p95"
    table = _table(title, "tool", "triangles", "query", "poses", "pairs")
    right: dict[str, Any] = {"justify": "right", "no_wrap": True}
    table.add_column("feeler", **right)
    table.add_column("worst", **right)
    for peer in peers:
        table.add_column(peer, **right)
    if peers:
        table.add_column("times faster than\nthe best, median", **right)
        table.add_column("\np95", **right)
        table.add_column("goal", no_wrap=True)
    for cell in cells:
        head = (cell["tool"], f"{cell['tool_triangles']:,}", cell["query"], cell["kind"])
        if "problem" in cell:
            table.add_row(*head, "-", f"[yellow]{cell['problem'][:60]}")
            continue
        if cell["poses"] < cell["poses_asked"]:
            head = (*head[:3], f"{cell['kind']} ({cell['poses']} found)")
        feeler = cell["engines"]["feeler"]
        row = [*head, f"{cell['pairs']['median']:,.0f}", _times(feeler), _us(feeler["wall_us"]["worst"])]
        row += [_times(cell["engines"][peer]) if peer in cell["engines"] else "-" for peer in peers]
        best = cell["best"]
        if best:
            row += [f"{best[measure]['times_faster']:.2f} {best[measure]['peer']}" for measure in MEASURES]
            wanted = "" if best["wanted"] is None else f"{best['wanted']:g}"
            row.append("[green]met" if best["met"] else f"[red]{wanted} missed" if wanted else "")
        table.add_row(*row)
    return table


def _times(figures: dict[str, Any]) -> str:
    wall = figures["wall_us"]
    return f"{_us(wall['median'])} / {_us(wall['p95'])}"


def _us(value: float) -> str:
    return f"{value:,.1f}" if value < 100 else f"{value:,.0f}"


def _builds(sizes: list[dict[str, Any]]) -> Table:
    table = _table("Build and memory", "mock-up", "engine")
    headings = (
        "one core, s",
        "all cores, s",
        "bytes / triangle",
        "process growth / triangle",
        "peak growth / triangle",
    )
    for heading in headings:
        table.add_column(heading, justify="right")
    for size in sizes:
        for row in size["builds"]:
            names = ("bytes", "rss_growth_bytes", "peak_growth_bytes")
            each = [row[f"{name}_per_triangle"] for name in names]
            table.add_row(
                f"{size['triangles']:,}",
                row["engine"],
                f"{row['one_core_s']:.3f}",
                "one core only" if row["all_cores_s"] is None else f"{row['all_cores_s']:.3f}",
                *("-" if value is None else f"{value:.1f}" for value in each),
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


def _agreement(cells: list[dict[str, Any]], peers: list[str]) -> Table:
    """One row a peer: all cells together."""
    table = _table("Pairs in feeler and in each peer, all cells; differences judged in exact arithmetic", "peer")
    shown = {
        "agreed": "agreed",
        "differing": "differ",
        "unjudged": "unjudged",
        "feeler_only_true": "missed by the peer",
        "peer_only_false": "made up by the peer",
        "not_queried": "zero area",
        "feeler_wrong": "feeler wrong",
    }
    for heading in (
        *shown.values(),
        *(f"{query}: {name}" for query in ANSWERED for name in ("agreed", "peer wrong", "feeler wrong")),
    ):
        table.add_column(heading, justify="right")
    for peer in peers:
        counts = []
        answers = ("agreed", "peer_wrong", "feeler_wrong")
        for query, names in (("collide", shown), *((query, answers) for query in ANSWERED)):
            own = [c["agreement"][peer] for c in cells if c["query"] == query and peer in c.get("agreement", ())]
            for name in names:
                total = sum(found[name] for found in own)
                counts.append(f"[bold red]{total:,}" if name == "feeler_wrong" and total else f"{total:,}")
        table.add_row(peer, *counts)
    return table


def _growth(rows: list[dict[str, Any]]) -> Table:
    title = f"Growth of the nominal median, {rows[0]['from']:,} to {rows[0]['to']:,}"
    table = _table(title, "tool", "pairs")
    engines = list(rows[0]["median"])
    for engine in engines:
        table.add_column(engine, justify="right")
    for row in rows:
        table.add_row(row["tool"], f"{row['pairs']:.2f}", *(f"{row['median'][engine]:.2f}" for engine in engines))
    return table


def _alone(record: dict[str, Any]) -> Table:
    table = _table("feeler alone", "tool", "what", "figures")
    for row in record["worst"]:
        wall = row["wall_us"]
        table.add_row(
            row["tool"],
            f"{row['poses']:,} nominal poses, µs",
            f"median {_us(wall['median'])}, p95 {_us(wall['p95'])}, p99.9 {_us(wall['p99_9'])}, "
            f"worst {_us(wall['worst'])}, worst single call {_us(row['worst_single_call_us'])}; "
            f"{row['over_1_ms']} above 1 ms",
        )
    for row in record["batch"]:
        rates = ", ".join(
            f"{name.removesuffix('_per_s').replace('_', ' on ')} {rate:,.0f}"
            for name, rate in row.items()
            if name.endswith("_per_s")
        )
        table.add_row(row["tool"], f"{row['poses']:,} poses, a second", rates)
    return table


def _goals(rows: list[dict[str, Any]]) -> Table:
    table = _table("Goals", "goal", "wanted", "found", "")
    for row in rows:
        said = {True: "[green]met", False: "[red]missed", None: "[yellow]not known"}[row["met"]]
        table.add_row(row["goal"], row["wanted"], row["found"], said)
    return table


ANSWERED = ("is_colliding", "distance")

NOTE = (
    "Bytes are as each engine counts its own: feeler with the mock-up's arrays, Coal, Embree and parry with their copy "
    "of them; FCL does not tell. Growth is what the system saw during a build on one core; feeler's mock-up was there "
    "before. Times of all engines are of calls from Python; those of peers far from the best are of fewer rounds."
)


def summary(record: dict[str, Any], peers: list[str]) -> list[str]:
    """A few lines: what calls cost, how much faster overall than each peer and than the best, and who was absent."""
    lines = [NOTE]
    costs = ", ".join(f"{name.replace('_', ' ')} {cost['wall_us']:.2f}" for name, cost in record["overheads"].items())
    lines.append(f"A call with nothing to do, µs (not subtracted): {costs}.")
    cells = [cell for cell in record["cells"] if cell.get("best")]
    for query, kind in dict.fromkeys((cell["query"], cell["kind"]) for cell in cells):
        own = [cell for cell in cells if (cell["query"], cell["kind"]) == (query, kind)]
        best = [geometric_mean(cell["best"][measure]["times_faster"] for cell in own) for measure in MEASURES]
        each = [
            f"{peer} {geometric_mean(cell['ratios'][peer]['wall']['of_medians'] for cell in own):.2f}"
            for peer in peers
            if peer in own[0]["ratios"]
        ]
        lines.append(
            f"{query}, {kind}: feeler is {best[0]:.2f} times as fast as the best peer in median, {best[1]:.2f} in p95, "
            f"geometric means of {len(own)} cells. In median against {', '.join(each)}."
        )
    for peer, reason in record["absent"].items():
        lines.append(f"[yellow]{peer} is absent: {reason}[/]")
    load = record["load_average"]
    if load["before"] and max(load["before"][0], load["after"][0]) > 1.5:
        lines.append(
            f"[yellow]The machine was busy (load {load['before'][0]} before, {load['after'][0]} after): "
            "the figures are noisy.[/]"
        )
    return lines


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", header_style="dim", box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in ("triangles", "pairs") else "left", no_wrap=True)
    return table
