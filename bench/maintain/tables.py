"""The tables of a run, as Markdown."""

from __future__ import annotations

from functools import partial

from pages import bold, markdown
from section import Result, Section, busy, by_experiment

from . import goals


def _table(name: str, found: Result) -> str:
    heads = [
        f"sample {name}",
        "rows",
        "come out",
        "ended by time",
        "seconds",
        "of a full run",
        "rows kept",
        "rows unlike a full run",
    ]
    is_quick_enough = not goals.is_full(found) or found["seconds"] <= goals.HOUR_S
    whole = bold(f"{found['seconds']:.3g}", is_quick_enough)
    lines = [["in full", f"{found['rows']}", f"{found['out']}", f"{found['cut']}", whole, "", "", ""]]
    wrong, seconds = len(found["same_differs"]), found["same_seconds"]
    share, kept = seconds / found["seconds"], f"{found['same_kept']}"
    wrong_said = bold(f"{wrong}", wrong == 0)
    lines.append(["nothing changed", f"{found['rows']}", "", "", f"{seconds:.3g}", f"{share:.1%}", kept, wrong_said])
    for each in found["moved"]:
        share, wrong = each["seconds"] / each["full_seconds"], len(each["differs"])
        cells = [
            f"{each['parts']} of {found['parts']:,} parts moved",
            f"{found['rows']}",
            "",
            "",
            f"{each['seconds']:.3g}",
        ]
        cells += [bold(f"{share:.1%}", share <= goals.SHARE), f"{each['kept']}", bold(f"{wrong}", wrong == 0)]
        lines.append(cells)
    note = f"{found['triangles']:,} triangles, one thread, seconds of the processor. Bold: misses its goal."
    return f"{SECTION.origin(found, *busy(found))}\n\n{markdown(heads, 1, lines, note)}"


MAKERS = {name: partial(_table, name) for name in ("engine", "gearbox")}
SECTION = Section("maintain", "task.md", list(MAKERS), partial(by_experiment, MAKERS), goals.scorecard)
