"""Puts the goals that some machine misses into docs/performance.md, by machine: the newest whole record of each.

examples:
    python bench/machines.py                            the newest of each kind of machine in bench/records
    python bench/machines.py one.json another.json      given ones
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import Any

from options import SIZES
from page import PERFORMANCE, fill
from readme import by_age, kind, read

Record = tuple[dict[str, Any], str]  # and its file's name


def newest_of_each() -> list[Record]:
    """The last record of all sizes of each kind of machine, in the order in which the kinds came up."""
    last: dict[str, Record] = {}
    for path in by_age():
        with contextlib.suppress(argparse.ArgumentTypeError):  # of an older layout
            record, name = read(path)
            if len(record["sizes"]) == len(SIZES.split(",")):
                last[kind(record)] = record, name
    return list(last.values())


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


def main() -> int:
    """Fill the page and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", nargs="*", type=read, help="of `make bench` (the newest of each kind of machine)")
    text = table(parser.parse_args().records or newest_of_each())
    fill(PERFORMANCE, "machines: bench/machines.py", text)
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
