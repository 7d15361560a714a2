"""The loop of all studies: every pair of a mock-up and a tool, measured now or loaded from disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ..mockup import Mockup, Tool
from .cells import Cell, Cells
from .subjects import Plan, Subject, Workshop

Pair = tuple[Subject[Mockup], Subject[Tool]]

_LAYOUT = 2  # of the cells; cells of another layout are measured anew


def measure_pairs(
    study: str, plan: Plan, pairs: Sequence[Pair], measure: Callable[[Mockup, Tool], Cell], **settings: Any
) -> Iterator[Cell]:
    """The cell of each pair, with both names, in order; cells measured with the same settings are reused.

    A measurement depends on the pair, on poses, rounds and seed of the plan, and on `settings`.
    """
    cells, workshop = Cells(plan.folder, plan.resume), Workshop()
    for number, (mockup, tool) in enumerate(pairs):
        plan.progress(number / len(pairs), f"{mockup.name} and {tool.name}")
        asked = {
            "layout": _LAYOUT, "mockup": mockup.key, "tool": tool.key,
            "poses": plan.poses, "rounds": plan.rounds, "seed": plan.seed,
        }  # fmt: skip

        def now(mockup: Subject[Mockup] = mockup, tool: Subject[Tool] = tool) -> Cell:
            return measure(workshop.mockup(mockup), tool.make())

        cell = cells.get(f"{study}-{mockup.name}-{tool.name}", asked | settings, now)
        yield {"mockup": mockup.name, "tool": tool.name} | cell
