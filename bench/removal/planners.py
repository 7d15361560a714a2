"""The interface of planners, feeler's implementation, and the list of others."""

from __future__ import annotations

import importlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from contacts import Floats

import feeler


@dataclass(frozen=True)
class Answer:
    """Seconds, and the way that was found: poses `(n, 4, 4)`, a motion of the part in the world; None for none.

    blocked_by: names of the parts that stopped it, the worst first, of a planner that says so.
    """

    seconds: float
    poses: Floats | None
    blocked_by: tuple[str, ...] = ()


class Problem:
    """A mock-up of which some parts are to be taken out; the index is there before any clock starts."""

    def __init__(self, mockup: feeler.Mockup, parts: Sequence[str | int]) -> None:
        self.whole = feeler.Scene(mockup, threads=1)
        self.parts = list(parts)
        self.scene = self.whole.without(self.parts)
        self.tool = feeler.Tool.of_parts(mockup, self.parts)
        low, high = mockup.bounds
        self.middle, self.size = 0.5 * (low + high), float(np.linalg.norm(high - low))
        self.pivot = 0.5 * (self.tool.vertices.min(axis=0) + self.tool.vertices.max(axis=0))
        self.centred = np.eye(4)
        self.centred[:3, 3] = -self.pivot

    def is_free(self, poses: Floats) -> bool:
        """Whether nothing is met all along, exactly."""
        return self.scene.check_path(self.tool, poses).is_free


class Planner(Protocol):
    """Something that finds ways out."""

    name: str
    version: str

    def solve(self, problem: Problem, seed: int, seconds: float) -> Answer:
        """A way out, on one thread."""
        ...


class FeelerPlanner:
    """`feeler.removal` with its defaults, on one thread."""

    name = "feeler"
    version = feeler.__version__

    def solve(self, problem: Problem, seed: int, seconds: float) -> Answer:
        """A way out."""
        begun = time.perf_counter()
        found = feeler.removal(problem.whole, problem.parts, seconds=seconds, seed=seed, threads=1)
        taken = time.perf_counter() - begun
        names = problem.whole.mockup.part_names
        blocked = tuple(names[each.part] for each in found.blocked_by)
        return Answer(taken, found.poses if found.is_found else None, blocked)


OMPL = {
    "KPIECE1": (0.002, 0.0005),
    "RRTConnect": (0.002, 0.0005),
}
"""Planners of OMPL and the steps, metres, at which they check motions: a coarse one and a careful one."""


def peers() -> tuple[list[Planner], dict[str, str]]:
    """OMPL's planners, if it is there; and if not, why not."""
    try:
        kind = importlib.import_module("removal.ompl_planner").OmplPlanner
    except ImportError as error:
        return [], {"OMPL": f"not installed ({error})"}
    return [kind(name, step) for name, steps in OMPL.items() for step in steps], {}
