"""docs/real-data.md from the figures of bench/real_data.py."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from typing import Any

HEAD = """# Real models

feeler on CAD models by others: loading, indexing, and queries beside Coal, judged by exact arithmetic.
`bench/real_data.py` writes this page. The models are not in the repository; their
[sources and licences](#sources-and-licences) are at the end.

"""


def markdown(result: dict[str, Any]) -> str:
    """The whole document."""
    return "\n".join([HEAD + _where(result), *_files(result), *_indexes(result), *_queries(result), *_sources(result)])


def _where(result: dict[str, Any]) -> str:
    machine = result["machine"]
    commit = (result["commit"] or "unknown")[:12] + (" with changes" if result["dirty"] else "")
    versions = ", ".join(f"{name} {version}" for name, version in result["versions"].items())
    load = f", load {result['load_average'][0]} at the end" if result["load_average"] else ""
    arguments = "".join(f" {shlex.quote(word)}" for word in result["args"])
    return f"""- When: {result["when"][:10]}, commit {commit}
- Machine: {machine["cpu"]}, {machine["cores"]} cores, {machine["memory_gib"]} GiB, {machine["system"]}{load}
- Versions: {versions}
- Command: `python bench/real_data.py{arguments}` ({result["seconds"]:.0f} s)
"""


def _files(result: dict[str, Any]) -> list[str]:
    rows = []
    for row in result["files"]:
        if row["outcome"] == "loaded":
            defects = ", ".join(f"{count:,} {kind.replace('_', ' ')}" for kind, count in row["defects"].items())
            extent = " × ".join(f"{side:.4g}" for side in row["extent_m"])
            outcome = f"loaded{'; ' + defects if defects else ''}"
            figures = (f"{row['triangles']:,}", f"{row['parts']:,}", extent)
        else:
            what = "refused" if row["outcome"] == "refused" else "FAILED WITHOUT A TYPED ERROR"
            outcome, figures = f"{what}: {row['message']}", ("", "", "")
        rows.append((row["name"], f"{row['megabytes']:.2f}", *figures, f"{row['seconds']:.2f}", outcome))
    heads = ("file", "MB", "triangles", "parts", "extent, m", "load, s", "outcome")
    return [
        "## Files\n",
        "Packed files are unpacked before the clock starts; an archive of several files is one mock-up. Extents are "
        "those of the file; without a unit, numbers are millimetres. Triangles with defects are kept and counted; "
        "those of zero area, with a non-finite vertex or a wrong index are not queried.\n",
        *_table(heads, rows, "lrrrlrl"),
    ]


def _indexes(result: dict[str, Any]) -> list[str]:
    rows = []
    for row in result["mockups"]:
        for build in row["builds"]:
            every = build["all_cores_s"]
            rows.append(
                (
                    row["mockup"],
                    build["engine"],
                    f"{row['triangles']:,}",
                    f"{row['parts']:,}",
                    f"{row['scale']:.4g}",
                    f"{max(row['extent_m']):.3g}",
                    f"{build['one_core_s']:.2f}",
                    "one core only" if every is None else f"{every:.2f}",
                    f"{build['bytes_per_triangle']:.1f}",
                )
            )
    heads = ("mock-up", "engine", "triangles", "parts", "scaled by", "longest side, m", "one core, s")
    return [
        "## Indexes\n",
        "Mock-ups too small for a hand tool are scaled, as their source says or to one metre; stages with separate "
        "origins are put in place. Bytes are the resident memory of the index, including the mock-up's arrays.\n",
        *_table((*heads, "all cores, s", "bytes / triangle"), rows, "llrrrrrrr"),
    ]


def _queries(result: dict[str, Any]) -> list[str]:
    peers = "coal" in result["versions"]
    rows = []
    for cell in result["cells"]:
        head = (cell["mockup"], cell["tool"], cell["kind"])
        if "problem" in cell:
            rows.append((*head, "", "no such poses found", *([""] * (4 if peers else 2))))
            continue
        if cell["poses"] < result["poses"]:
            head = (*head[:2], f"{cell['kind']} ({cell['poses']} found)")
        pairs = f"{cell['pairs']['median']:,.0f} ({cell['pairs']['worst']:,})"
        row = [*head, pairs, *_times(cell["engines"]["feeler"])]
        if peers:
            coal = cell["engines"].get("coal")
            row += [_times(coal)[0] if coal else "", _agreement(cell["agreement"]) if coal else ""]
        rows.append(tuple(row))
    tools = ", ".join(
        f"{tool['name']} ({tool['triangles']:,} triangles, {max(tool['extent_m']):.2f} m)" for tool in result["tools"]
    )
    heads = ["mock-up", "tool", "poses", "pairs, median (most)", "median, µs", "p95, µs", "worst, µs"]
    heads += ["Coal's median, µs", "pairs in one only"] if peers else []
    return [
        "## Queries\n",
        f"All pairs, one core, {result['poses']} poses of each kind from `sample_poses`: *nominal*, 1 to 5 % of the "
        f"tool's triangles collide; *near*, close to the mock-up without a collision. Times are the minimum of "
        f"{result['rounds']} rounds per pose. Tools: {tools or 'none'}."
        + (" Pairs that only one engine finds are judged in exact arithmetic.\n" if peers else "\n"),
        *_table(heads, rows, "lll" + "r" * (len(heads) - 3)),
    ]


def _times(figures: dict[str, Any]) -> tuple[str, str, str]:
    wall = figures["wall_us"]
    return (f"{wall['median']:,.0f}", f"{wall['p95']:,.0f}", f"{wall['worst']:,.0f}")


def _agreement(found: dict[str, Any]) -> str:
    words = [
        (found["feeler_wrong"], "wrong in feeler"),
        (found["feeler_only_true"], "missed by Coal"),
        (found["peer_only_false"], "made up by Coal"),
        (found["not_queried"], "with a triangle of zero area"),
    ]
    return ", ".join(f"{count:,} {what}" for count, what in words if count) or "none"


def _sources(result: dict[str, Any]) -> list[str]:
    lines = ["## Sources and licences\n"]
    if not result["sources"]:
        lines.append("The folder names none (no SOURCE.txt).\n")
    for folder, said in result["sources"]:
        lines.append(f"**{folder}**\n")
        lines += [f"- {_plain(line)}" for line in said]
        lines.append("")
    return lines


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], aligned: str) -> list[str]:
    rule = ["--:" if side == "r" else "---" for side in aligned]
    lines = [heads, rule, *([_plain(field) for field in row] for row in rows)]
    return [*(f"| {' | '.join(line)} |" for line in lines), ""]


def _plain(text: str) -> str:
    """Text that Markdown leaves alone."""
    for character in ("\\", "|", "*", "_", "<", ">", "`"):
        text = text.replace(character, f"\\{character}")
    return " ".join(text.split())
