"""The best of several runs: other work on the machine can only make results slower."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

Result = dict[str, Any]


def best(runs: Sequence[Result]) -> Result:
    """One result of several of `feeler view --benchmark`: each figure from the run that has it least."""
    first = runs[0]
    found = {**first, "page": {**first["page"]}, "runs": len(runs)}
    for name in ("read_s", "index_s", "first_picture_s", "whole_picture_s"):
        there = [run[name] for run in runs if run[name] is not None]
        found[name] = min(there) if there else None
    for name, value in first["page"].items():
        if isinstance(value, Mapping):
            found["page"][name] = min((run["page"][name] for run in runs), key=_order(value))
    return found


def _order(value: Mapping[str, Any]) -> Callable[[Mapping[str, Any]], float]:
    if "input_to_drawn_ms" in value:
        return lambda run: float(run["input_to_drawn_ms"]["p99"])
    if "interval_ms" in value:
        return lambda run: -float(run["frames_per_s"])
    return lambda run: float(run["p50"])
