"""The tables of a run, as Markdown."""

from __future__ import annotations

from functools import partial

from pages import bold, markdown
from section import Result, Section, busy, by_experiment

from . import goals


def engine(found: Result) -> str:
    """Bolts of the engine."""
    is_full = found["triangles"] > goals.FULL and found["bolts"] == goals.BOLTS
    kinds = ", ".join(f"{kind.replace('_', ' ')} {count}" for kind, count in found["kinds"].items())
    line = [
        f"{found['triangles']:,} triangles",
        f"{found['bolts']}",
        f"{found['tools']}",
        f"{found['without_fit']}",
        f"{found['reachable']}",
        kinds,
        bold(f"{found['wrong']}", found["wrong"] == 0),
        f"{goals.ENGINE_S:g} s" if is_full else "",
        bold(f"{found['seconds']:.3g} s", not is_full or found["seconds"] <= goals.ENGINE_S),
    ]
    heads = ["sample engine", "bolts", "tools", "none fits", "reachable", "by", "refuted by casts", "goal", "one core"]
    note = f"Least of {found['repeats']} runs. Bold: misses its goal."
    return f"{SECTION.origin(found, *busy(found))}\n\n{markdown(heads, 1, [line], note)}"


def gearbox(found: Result) -> str:
    """The tools of the gearbox's truth."""
    lines = [
        [
            tool,
            f"{row['fasteners']}",
            bold(f"{row['found']}", row["found"] == row["fasteners"]),
            bold(f"{row['wrong']}", row["wrong"] == 0),
        ]
        for tool, row in found["rows"].items()
    ]
    planted = len(found["planted"])
    lines.append(["under the planted guard", "1", bold(f"{planted}", planted == 0), ""])
    note = (
        f"{found['triangles']:,} triangles, all in {found['seconds']:.3g} s. For each fastener the parts are out that "
        "the truth takes out before. Under the guard: sockets and rings, and all tools with a hand."
    )
    heads = ["tool of the truth", "fasteners", "found", "refuted by casts"]
    return f"{SECTION.origin(found)}\n\n{markdown(heads, 1, lines, note)}"


MAKERS = {"engine": engine, "gearbox": gearbox}
SECTION = Section("reaching", "access.md", list(MAKERS), partial(by_experiment, MAKERS), goals.scorecard)
