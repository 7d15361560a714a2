"""Puts the goals that some machine misses into docs/performance.md, by machine: the newest whole record of each.

And beside them what each whole record found.

examples:
    python bench/machines.py                            the newest of each kind of machine in bench/records
    python bench/machines.py one.json another.json      given ones
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import Any

from goals import geometric_mean
from options import SIZES
from page import PERFORMANCE, fill
from readme import by_age, kind, read

Record = tuple[dict[str, Any], str]  # and its file's name


def whole() -> list[Record]:
    """The records of all sizes, the oldest first."""
    found = []
    for path in by_age():
        with contextlib.suppress(argparse.ArgumentTypeError):  # of an older layout
            record, name = read(path)
            if len(record["sizes"]) == len(SIZES.split(",")):
                found.append((record, name))
    return found


def newest_of_each(records: list[Record]) -> list[Record]:
    """The last record of each kind of machine, in the order in which the kinds came up."""
    return list({kind(record): (record, name) for record, name in records}.values())


def table(records: list[Record]) -> str:
    """A row for each goal that a record does not meet, or could not tell; a column for each record."""
    found = [{row["goal"]: row for row in record["goals"]} for record, _ in records]
    goals = {goal: row["wanted"] for own in found for goal, row in own.items()}
    open_goals = [goal for goal in goals if not all(own[goal]["met"] for own in found if goal in own)]
    lines = [
        f"| goal | wanted | {' | '.join(kind(record) for record, _ in records)} |",
        f"|---|---|{'---|' * len(records)}",
    ]
    for goal in open_goals:
        lines.append(f"| {goal} | {goals[goal]} | {' | '.join(_said(own.get(goal)) for own in found)} |")
    names = ", ".join(f"[{name}](../bench/records/{name})" for _, name in records)
    others = len(goals) - len(open_goals)
    note = f"Missed ones bold; the other {others} goals are met in each record that asks for them. "
    return "\n".join([*lines, "", f"{note}`python bench/machines.py`: {names}."])


def _said(row: dict[str, Any] | None) -> str:
    """What was found; nothing where the goal came later than the record."""
    if row is None:
        return "–"
    return f"**{row['found']}**" if row["met"] is False else row["found"]


# What is shown of each record: the head of a column, and of the goals whose findings stand there how they begin.
COLUMNS = {
    "means: median, p95": ("collide, nominal and deep: median", "collide, nominal and deep: p95"),
    "contacts, hand": ("contacts, nominal, hand",),
    "growth: torque, wrench, square, hand, hand-fine": tuple(
        f"growth of the nominal median, {tool}," for tool in ("torque", "wrench", "square", "hand", "hand-fine")
    ),
    "batches: torque, hand": ("collide_batch, torque", "collide_batch, hand"),
    "build, s": ("build of 1,", "build of 6,"),
}


def history(records: list[Record]) -> str:
    """A row for each record, by machine: what it found for a few goals, and how long feeler and Embree took there."""
    newest = {kind(record): record for record, _ in records}
    lines = [
        f"| machine | record | {' | '.join(COLUMNS)} | feeler | Embree |",
        f"|---|---|{'---:|' * (len(COLUMNS) + 2)}",
    ]
    for of, last in newest.items():
        for record, name in records:
            if kind(record) == of:
                found = [", ".join(_found(record, goal) for goal in goals) for goals in COLUMNS.values()]
                times = [_times(record, last, engine) for engine in ("feeler", "embree")]
                link = f"[{name.removesuffix('.json')}](../bench/records/{name}), {record['commit'][:7]}"
                lines.append(f"| {of} | {link} | {' | '.join([*found, *times])} |")
    note = (
        'What each record found for these goals, in microseconds and times; "–": not asked. feeler, Embree: how long '
        "`collide` takes at nominal and deep poses beside the newest record of that machine, "
        "geometric means of medians. `python bench/machines.py`."
    )
    return "\n".join([*lines, "", note])


def _found(record: dict[str, Any], begins: str) -> str:
    """The number that a record found for a goal."""
    rows = (row["found"].split()[0] for row in record["goals"] if row["goal"].startswith(begins))
    return next(rows, "–")


def _times(record: dict[str, Any], last: dict[str, Any], engine: str) -> str:
    """How many times as long an engine takes as in the last record, over the cells that both have."""
    own, newest = _medians(record, engine), _medians(last, engine)
    ratios = [own[cell] / newest[cell] for cell in own if cell in newest]
    return f"{geometric_mean(ratios):.3f}" if ratios else "–"


def _medians(record: dict[str, Any], engine: str) -> dict[tuple[Any, ...], float]:
    """By size, tool and kind of poses."""
    asked = (c for c in record["cells"] if c["query"] == "collide" and c["kind"] != "near")
    cells = [c for c in asked if engine in c.get("engines", ())]
    return {(c["triangles_asked"], c["tool"], c["kind"]): c["engines"][engine]["wall_us"]["median"] for c in cells}


def main() -> int:
    """Fill the page and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="*", type=read, help="of `make bench` (the newest of each kind of machine)")
    records = whole()
    texts = {
        "machines: bench/machines.py": table(parser.parse_args().records or newest_of_each(records)),
        "records: bench/machines.py": history(records),
    }
    for what, text in texts.items():
        fill(PERFORMANCE, what, text)
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
