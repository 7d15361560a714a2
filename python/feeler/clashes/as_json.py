"""Findings as one JSON document: printed by `feeler clash --json`, shown by `feeler view`, read by `load_clashes`."""

from __future__ import annotations

from typing import Any

from feeler.arguments import check_kind
from feeler.choices import GroupBy
from feeler.clashes import saving
from feeler.clashes.advice import advice
from feeler.clashes.result import Clashes
from feeler.clashes.verdict import Verdict


def report(clashes: Clashes, *, by: GroupBy = "part") -> dict[str, Any]:
    """Counts, groups and findings as plain Python values, the worst first. Each finding has the name of its group.

    by: how to group, as in `Clashes.groups`.
    """
    check_kind("clashes", clashes, Clashes)
    groups = clashes.groups(by)
    group_of = {int(row): group.name for group in groups for row in group.rows}
    return {
        **saving.head(clashes),
        "seconds": dict(clashes.facts.seconds),
        "looked_at": dict(clashes.facts.counts),
        "counts": {each.value: len(clashes.where(verdict=each)) for each in Verdict},
        "statuses": statuses(clashes),
        "advice": advice(clashes),
        "groups": [
            {"name": group.name, "findings": len(group), "worst": group.worst.id, "depth": group.worst.depth}
            for group in groups
        ],
        "clashes": [{**row, "group": group_of[place]} for place, row in enumerate(saving.rows(clashes))],
        "earlier": list(saving.rows(clashes.earlier())),
        **saving.shapes_of_file(clashes),
    }


def statuses(clashes: Clashes) -> dict[str, int]:
    """The number of findings of each status, including resolved ones."""
    found = {name: len(clashes.where(status=name)) for name in ("new", "active", "reviewed", "approved")}
    return {**found, "resolved": len(clashes.earlier().where(status="resolved"))}
