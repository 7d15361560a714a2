"""Writes docs/figures.md and the figures in README.md from the records in bench/records. They are not edited by hand.

    make figures

The page shows the newest release of each kind of machine; cells, funnel and builds are from the machine that was last
measured completely.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import goals
from host import ROOT
from pages import markdown
from record import RECORDS, RecordError, Row, newest

README = ROOT / "README.md"
PAGE = ROOT / "docs" / "figures.md"
MARKERS = ("<!-- figures: make figures -->", "<!-- end of figures -->")
NAMES = {"feeler": "feeler", "coal": "Coal", "fcl": "FCL", "embree": "Embree", "parry": "parry3d"}
LEAST_WIDTH = 200  # in a narrower terminal lines fold, but no figure is cut off
SHOWN = 1_600_000  # triangles requested; without such a mock-up, the largest
SHOWN_KIND = "nominal"  # poses in README.md

# What `hit.stats` counts, in words.
STAGE_NAMES = {
    "voxels_visited": "nodes",
    "clusters_placed": "clusters placed",
    "pieces_scanned": "pieces scanned",
    "entries_scanned": "boxes meet",
    "box_survivors": "planes meet",
    "repeats_skipped": "repeats",
    "triangle_tests": "triangle tests",
    "exact_tests": "exact tests",
    "pairs_mean": "pairs",
}


@dataclass(frozen=True)
class Table:
    """A table for a page or a terminal: the first columns are text, the others numbers."""

    title: str
    heads: Sequence[str]
    texts: int
    lines: Sequence[Sequence[str]]
    note: str = ""

    def markdown(self) -> str:
        """With its title as a heading."""
        return f"## {self.title}\n\n{markdown(self.heads, self.texts, self.lines, self.note)}"


def page(records: Sequence[Sequence[Row]]) -> str:
    """docs/figures.md."""
    first = records[0]
    tables = [machines(records), scorecard(records), *queries(first), *of_one(first)]
    head = (
        "# Figures\n\n"
        "Speed of feeler beside other libraries. `make figures` makes this page from `bench/records/*.csv`. "
        "[bench/README.md](../bench/README.md) explains the timing and the columns of a record, "
        "[performance.md](performance.md) how feeler works and where it falls short.\n\n"
        "Microseconds per pose are wall-clock times on one core, called from Python: median (p95) over poses, each the "
        f"minimum of its rounds. All tables after the first two are from {first[0]['machine']}."
    )
    return "\n\n".join([head, *(table.markdown() for table in tables)]) + "\n"


def show(rows: Sequence[Row]) -> None:
    """Prints the tables of a run, as wide as they need to be."""
    from rich.console import Console
    from rich.table import Table as RichTable

    out = Console()
    out = Console(width=max(out.width, LEAST_WIDTH))
    for table in (*queries(rows), *of_one(rows), scorecard([rows])):
        shown = RichTable(title=table.title, title_justify="left", title_style="bold", box=None, pad_edge=False)
        for number, head in enumerate(table.heads):
            shown.add_column(head, justify="left" if number < table.texts else "right", no_wrap=True)
        for line in table.lines:
            shown.add_row(*(f"[red]{field[2:-2]}[/]" if field.startswith("**") else field for field in line))
        out.print(shown)
        out.print()


def of_one(rows: Sequence[Row]) -> list[Table]:
    """The rows of one machine other than the times of cells."""
    asked = (builds, funnel, agreement, growth, limit, levels)
    return [table for make in asked if (table := make(rows)) is not None]


def machines(records: Sequence[Sequence[Row]]) -> Table:
    """When and on what each record was measured."""
    lines = []
    for rows in records:
        cells = [row for row in rows if row["what"] == "cell"]
        dates, commits = sorted({row["date"] for row in cells}), dict.fromkeys(row["commit"][:7] for row in cells)
        versions = {row["engine"]: row["version"] for row in cells if row["engine"] in NAMES}
        engines = ", ".join(f"{NAMES[name]} {version}" for name, version in versions.items())
        when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
        lines.append([rows[0]["machine"], str(rows[0]["cores"]), when, ", ".join(commits), engines])
    note = "Columns: kind of machine, its cores, and the versions that its cells were measured with."
    return Table("Machines", ["machine", "cores", "measured", "commit", "engines"], 5, lines, note)


def scorecard(records: Sequence[Sequence[Row]]) -> Table:
    """Every goal, and what each machine makes of it."""
    found = [{goal.goal: goal for goal in goals.scorecard(rows)} for rows in records]
    wanted = {name: goal.wanted for own in found for name, goal in own.items()}
    lines = [[name, wanted[name], *(_goal(own.get(name)) for own in found)] for name in wanted]
    heads = ["goal", "wanted", *(str(rows[0]["machine"]) for rows in records)]
    note = "Bold: missed. –: not asked. A record of an older commit shows the code of that commit."
    return Table("Goals", heads, len(heads), lines, note)


def _goal(goal: goals.Goal | None) -> str:
    if goal is None:
        return "–"
    return f"**{goal.found}**" if goal.met is False else goal.found


def queries(rows: Sequence[Row]) -> list[Table]:
    """A table a mock-up: every cell, beside the other libraries."""
    peers = [name for name in NAMES if name != "feeler" and any(row["engine"] == name for row in _of(rows, "cell"))]
    heads = ["tool", "query, pose", "pairs", "feeler", *(NAMES[peer] for peer in peers), "times faster"]
    tables: list[Table] = []
    for size in dict.fromkeys(row["size"] for row in _of(rows, "cell")):
        own = [row for row in _of(rows, "cell") if row["size"] == size]
        times = {((row["tool"], row["query"], row["kind"]), row["engine"]): row for row in own}
        lines: list[list[str]] = []
        for row in (row for row in own if row["engine"] == "feeler"):
            at = (row["tool"], row["query"], row["kind"])
            line = [row["tool"], f"{row['query']}, {row['kind']}"]
            if not row["poses"]:
                lines.append([*line, "no such pose found", *[""] * (len(peers) + 2)])
                continue
            others = {peer: times[at, peer] for peer in peers if (at, peer) in times}
            line += [f"{row['pairs']:,.0f}", _us(row)]
            line += [_us(others[peer]) if peer in others else "–" for peer in peers]
            lines.append([*line, _faster(goals.against_best(list(others.values())))])
        title = f"Queries at {own[0]['triangles']:,} triangles in {own[0]['parts']:,} parts"
        tables.append(Table(title, heads, 2, lines, "" if tables else QUERY_NOTE))
    return tables


QUERY_NOTE = (
    "Times faster: than the fastest other library by median (by p95); missed: below the goal. Nominal: 1 to 5 % of the "
    "tool's triangles collide; near: among the parts, without a collision; deep: more collide. distance: the minimum; "
    "cast: the first impact within 20 mm; contacts: planes within 2 mm."
)


def _faster(best: goals.Best | None) -> str:
    if best is None:
        return ""
    return f"{best.median:.1f} ({best.p95:.1f}){' missed' if best.met is False else ''}"


def builds(rows: Sequence[Row]) -> Table | None:
    """Time and memory of an index."""
    lines: list[list[str]] = []
    for row in _of(rows, "build"):
        line: list[str] = [f"{row['triangles']:,}", str(NAMES.get(row["engine"], row["engine"]))]
        line += ["–" if row[name] is None else f"{row[name]:.3f}" for name in ("one_core_s", "all_cores_s")]
        for name in ("bytes", "growth_bytes", "peak_bytes"):
            line.append("–" if row[name] is None else f"{row[name] / row['triangles']:.0f}")
        lines.append(line)
    heads = ["triangles", "engine", "one core, s", "all cores, s", "bytes a triangle", "process grew", "at most"]
    note = (
        "Bytes as each engine reports them: feeler with the mock-up's arrays, Coal, Embree and parry3d with their "
        "copy; FCL reports none. Process grew: bytes per triangle after a build on one core, and at most during it; "
        "feeler's mock-up existed before."
    )
    return Table("Builds", heads, 2, lines, note) if lines else None


def funnel(rows: Sequence[Row]) -> Table | None:
    """Counts of a `collide`, stage by stage."""
    shown = _at_shown_size([row for row in _of(rows, "cell") if row["voxels_visited"] is not None])
    lines = [[row["tool"], row["kind"], *(f"{row[stage]:,.0f}" for stage in STAGE_NAMES)] for row in shown]
    heads = ["tool", "pose", *STAGE_NAMES.values()]
    title = f"The funnel at {shown[0]['triangles']:,} triangles, means over poses" if shown else ""
    return Table(title, heads, 2, lines) if lines else None


def agreement(rows: Sequence[Row]) -> Table | None:
    """Answers of each peer that differ, all cells together."""
    counted = [row for row in _of(rows, "cell") if row["agreed"] is not None]
    lines = []
    for query, engine in dict.fromkeys((row["query"], row["engine"]) for row in counted):
        own = [row for row in counted if (row["query"], row["engine"]) == (query, engine)]
        counts = [sum(row[name] for row in own) for name in ("agreed", "peer_wrong", "feeler_wrong", "unjudged")]
        lines.append([query, NAMES.get(engine, engine), *(f"{count:,}" for count in counts)])
    note = (
        "collide: pairs; differing ones are judged in exact arithmetic, at most 20,000 per cell. Others: poses; "
        "distances agree within 1e-9 m, casts (not judged) within 1 % of the motion."
    )
    heads = ["query", "peer", "agreed", "peer wrong", "feeler wrong", "unjudged"]
    return Table("Answers that differ", heads, 2, sorted(lines), note) if lines else None


def growth(rows: Sequence[Row]) -> Table | None:
    """The two sizes of `bench/claims/growth.py` side by side."""
    own = _of(rows, "growth")
    lines = []
    for tool in dict.fromkeys(row["tool"] for row in own):
        small, large = sorted((row for row in own if row["tool"] == tool), key=lambda row: int(row["size"]))
        line = [tool]
        for name in ("pairs", "median_us", "again_us"):
            digits = ",.0f" if name == "pairs" else ",.1f"
            ratio = large[name] / max(small[name], 1e-9)
            line += [f"{small[name]:{digits}}, {large[name]:{digits}}", f"{ratio:.2f}"]
        line += [f"{small[name]:.0f}, {large[name]:.0f}" for name in ("pair_ns", "again_pair_ns")]
        lines.append(line)
    heads = ["tool", "pairs, median", "growth", "caches emptied, µs, median", "growth", "asked again, µs, median"]
    heads += ["growth", "a pair found, ns, caches emptied", "asked again"]
    if not lines:
        return None
    sizes = " and ".join(f"{count:,}" for count in sorted({row["triangles"] for row in own}))
    note = f"`python bench/claims/growth.py`: {sizes} triangles in turns, nominal `collide`, {own[0]['poses']:,} poses."
    return Table("Growth", heads, 1, lines, note)


def limit(rows: Sequence[Row]) -> Table | None:
    """Times as multiples of the machine's limit."""
    lines = []
    for row in _of(rows, "limit"):
        least = [f"{row[name]:.2f}" for name in ("memory_us", "lanes_us", "limit_us")]
        took = [f"{row[name]:,.1f}" for name in ("median_us", "again_us")]
        ratio = f"{row['median_us'] / row['limit_us']:.1f}"
        lines.append([row["tool"], row["kind"], f"{row['lines']:,.0f}", *least, *took, ratio])
    heads = ["tool", "pose", "lines, at least", "memory, µs", "lanes, µs", "limit, µs", "measured, µs"]
    heads += ["asked again, µs", "times the limit"]
    note = (
        "`python bench/claims/limit.py`: the time for the cache lines that a `collide` must read, and for its vector "
        "instructions, at this core's best rates; the limit is the larger. Measured: without the cost of a Python call."
    )
    return Table("The machine's limit", heads, 2, lines, note) if lines else None


def levels(rows: Sequence[Row]) -> Table | None:
    """The instruction sets beside each other."""
    own = _of(rows, "level")
    names = dict.fromkeys(row["engine"].removeprefix("feeler-") for row in own)
    lines = []
    for tool, kind in dict.fromkeys((row["tool"], row["kind"]) for row in own):
        times = [row["median_us"] for row in own if (row["tool"], row["kind"]) == (tool, kind)]
        lines.append(
            [tool, kind, *(f"{us:,.1f}" + (f" ({us / times[0]:.1f})" if us > times[0] else "") for us in times)]
        )
    note = "`python bench/claims/limit.py`: medians of `collide`, microseconds (times the first's)."
    return Table("Instruction sets", ["tool", "pose", *names], 2, lines, note) if lines else None


def readme(rows: Sequence[Row]) -> str:
    """The table of one mock-up at nominal poses, and the setting of its measurement."""
    cells = _at_shown_size(_of(rows, "cell"))
    measured = [
        (feeler, peers)
        for feeler, peers in goals.cells(cells)
        if (feeler["query"], feeler["kind"]) == ("collide", SHOWN_KIND)
    ]
    rounds = [row["rounds"] for feeler, peers in measured for row in (feeler, *peers)]
    least, most = min(rounds, default=0), max(rounds, default=0)
    poses = measured[0][0]["poses"] if measured else 0
    lines = [
        f"All colliding pairs of a pose in the sample `engine` ({cells[0]['triangles']:,} triangles, "
        f"{cells[0]['parts']:,} parts).",
        f"Microseconds on one core: median (95th percentile) over {poses} poses, each the minimum of "
        f"{least if least == most else f'{least} to {most}'} runs.",
        "",
        "| tool | triangles | colliding pairs | feeler | fastest other library | ratio |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for feeler, peers in measured:
        row = [feeler["tool"], f"{feeler['tool_triangles']:,}", f"{feeler['pairs']:,.0f}", _whole(feeler)]
        if best := goals.against_best(peers):
            peer = next(peer for peer in peers if peer["engine"] == best.peer)
            row += [f"{NAMES[best.peer]} {_whole(peer)}", f"{best.median:.1f} ({best.p95:.1f})"]
        lines.append("| " + " | ".join([*row, *["–"] * (6 - len(row))]) + " |")
    return "\n".join([*lines, "", *_readme_notes(rows, cells)])


def _readme_notes(rows: Sequence[Row], cells: Sequence[Row]) -> Iterable[str]:
    built = {row["engine"]: row for row in _of(rows, "build") if row["size"] == cells[0]["size"]}
    if ours := built.pop("feeler", None):
        said = [
            f"Index built in {ours['all_cores_s']:.2f} s on {ours['cores']} cores ({ours['one_core_s']:.2f} s on one), "
            f"{ours['bytes'] / ours['triangles']:.0f} bytes per triangle including the triangles"
        ]
        for name, row in built.items():
            each = f" and {row['bytes'] / row['triangles']:.0f} bytes" if row["bytes"] else ""
            said.append(f"{NAMES[name]} {row['one_core_s']:.1f} s{each}")
        yield "; ".join(said) + "."
    any_contact = [
        (feeler, peers) for feeler, peers in goals.cells(cells) if feeler["query"] == "is_colliding" and peers
    ]
    if found := [best for _, peers in any_contact if (best := goals.against_best(peers))]:
        means = [goals.geometric_mean(getattr(best, measure) for best in found) for measure in goals.MEASURES]
        faster = f"{means[0]:.1f} ({means[1]:.1f}) times faster than the fastest other library, geometric mean"
        yield f"`is_colliding`: {faster}."
    versions = {row["engine"]: row["version"] for row in cells if row["engine"] != "feeler"}
    if versions:
        others = ", ".join(f"{NAMES[name]} {version}" for name, version in versions.items())
        yield f"Compared: {others}, each configured for speed, on the same poses in the same run."
    yield f"{rows[0]['machine']}. All cells, goals and machines: [docs/figures.md](docs/figures.md)."


def _of(rows: Sequence[Row], what: str) -> list[Row]:
    return [row for row in rows if row["what"] == what]


def _at_shown_size(rows: Sequence[Row]) -> list[Row]:
    sizes = {row["size"] for row in rows}
    shown = SHOWN if SHOWN in sizes else max(sizes, default=0)
    return [row for row in rows if row["size"] == shown]


def _us(row: Row) -> str:
    return f"{_short(row['median_us'])} ({_short(row['p95_us'])})"


def _short(value: float) -> str:
    return f"{value:.1f}" if value < 9.95 else f"{value:,.0f}"


def _whole(row: Row) -> str:
    return f"{row['median_us']:,.0f} ({row['p95_us']:,.0f})"


def filled(text: str, rows: Sequence[Row]) -> str:
    """README.md with its figures made anew."""
    before, rest = text.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    return f"{before}{MARKERS[0]}\n{readme(rows)}\n{MARKERS[1]}{after}"


def written(folder: Path = RECORDS) -> dict[Path, str]:
    """The pages that are made from the records in a folder, and their text."""
    records = newest(folder)
    if not records:
        raise RecordError(f"{folder} holds no record: run `make bench` first")
    return {README: filled(README.read_text(encoding="utf-8"), records[0]), PAGE: page(records)}


def main() -> int:
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    try:
        pages = written()
    except RecordError as error:
        print(error, file=sys.stderr)
        return 2
    for path, text in pages.items():
        path.write_text(text, encoding="utf-8")
        print(f"Written: {path.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
