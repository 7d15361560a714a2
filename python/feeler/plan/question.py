"""The problem of a removal order, in part indices, and its time limit."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import FeelerError
from feeler.mockup import Tool
from feeler.plan.removal import Removal, removal
from feeler.progress import Progress
from feeler.scene import Scene

TARGET = -1
"""The node of the wanted parts, which leave together, among the indices of all other parts."""
LEAST_S = 1e-3
"""Seconds of a removal that starts after the time is up."""
LOOK_S = 0.05
"""Long work reports at least this often, so that whoever waits for it can end it."""

Direction = tuple[float, float, float]


class _NotStraightError(FeelerError):
    """Ends a removal that would go on to other ways than straight ones."""


class StoppedError(FeelerError):
    """Nobody wants the answer any more."""


@dataclass(frozen=True)
class Budget:
    """The most work of one attempt: seconds, or rounds of the search."""

    seconds: float = math.inf
    rounds: int | None = None


@dataclass(frozen=True)
class Attempt:
    """A removal to try: one of some parts with others gone, along a direction first."""

    nodes: frozenset[int]
    gone: frozenset[int]
    direction: Direction | None
    budgets: tuple[Budget, ...]
    """Each is used if the one before ended without a way and without a part that blocks the direction."""
    seed: int = 0
    """Added to the seed of the options."""


class Clock:
    """The time limit, and the progress reports. `is_stopped`: whether it is to end before."""

    def __init__(
        self, seconds: float, progress: Progress | None = None, is_stopped: Callable[[], bool] = lambda: False
    ) -> None:
        self.seconds, self.progress, self._is_stopped = seconds, progress, is_stopped
        self._begun = time.monotonic()
        self._told, self._what = self._begun, ""

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._begun

    @property
    def left(self) -> float:
        """Seconds, at least `LEAST_S`."""
        return max(LEAST_S, self.seconds - self.spent)

    @property
    def share(self) -> float:
        """What is reported as done: the share of the time, 0 to 1."""
        return min(1.0, self.spent / self.seconds)

    def goes_on(self) -> bool:
        """Whether there is time left."""
        return self.spent < self.seconds and not self._is_stopped()

    def tell(self, what: str) -> None:
        """Reports the share that is done and the current attempt. Raises `StoppedError` if it was stopped."""
        self._told, self._what = time.monotonic(), what
        if self._is_stopped():
            raise StoppedError
        if self.progress is not None:
            self.progress(self.share, what)

    def look(self, _share: float = 0.0, _stage: str = "") -> None:
        """Reports the current attempt again, at most every `LOOK_S`. Raises what `tell` raises."""
        if time.monotonic() - self._told >= LOOK_S:
            self.tell(self._what)


@dataclass(frozen=True)
class Question:
    """Which parts leave which scene, how, and which parts must stay."""

    scene: Scene
    wanted: tuple[int, ...]
    kept: frozenset[int]
    grip: dict[str, Any]
    """`tool`, `start` and `directions` of the wanted parts."""
    options: dict[str, Any]
    """`ignore`, `overlap`, `seats`, `clearance`, `seed` and `threads` of each removal."""

    @property
    def node_count(self) -> int:
        """Number of present parts, the wanted ones counted as one."""
        return int(self.scene.part_mask.sum()) - len(self.wanted) + 1

    def node_of(self, part: int) -> int:
        """The part itself, or `TARGET` for a wanted one."""
        return TARGET if part in self.wanted else part

    def parts_of(self, nodes: Iterable[int]) -> tuple[int, ...]:
        """The parts of nodes, by index."""
        return tuple(sorted(part for node in nodes for part in (self.wanted if node == TARGET else (node,))))

    def size(self, node: int) -> float:
        """The diagonal of a part's box, metres; 0 for the wanted ones."""
        lower, upper = self.scene.mockup.part_bounds[2 * node : 2 * node + 2] if node != TARGET else np.zeros((2, 3))
        return float(np.linalg.norm(upper - lower))

    def names(self, nodes: Iterable[int]) -> str:
        """For people: the name of the first, and the number of others."""
        parts = self.parts_of(nodes)
        more = f" and {len(parts) - 1} more" if len(parts) > 1 else ""
        return f"{self.scene.mockup.part_names[parts[0]]}{more}"

    def moving(self, nodes: Iterable[int]) -> Tool:
        """The parts as one tool; the wanted ones with the tool that grips them."""
        nodes = frozenset(nodes)
        own = Tool.of_parts(self.scene.mockup, list(self.parts_of(nodes)))
        if TARGET not in nodes or self.grip["tool"] is None:
            return own
        place = np.eye(4) if self.grip["start"] is None else self.grip["start"]
        return Tool.assembly({"parts": own, "tool": (self.grip["tool"], place)})

    def tried(self, attempt: Attempt, clock: Clock) -> tuple[Removal, bool]:
        """The answer to an attempt, and whether time cut it."""
        gone, is_cut = attempt.gone, False
        name, after = self.names(attempt.nodes), f", {len(gone)} gone" if gone else ""

        def answer(seconds: float, rounds: int | None) -> Removal:
            return removal(
                self.scene.without(list(self.parts_of(gone))) if gone else self.scene,
                list(self.parts_of(attempt.nodes)),
                **self._held(attempt.nodes, attempt.direction),
                **{**self.options, "seed": self.options["seed"] + attempt.seed},
                seconds=seconds,
                rounds=rounds,
                progress=lambda _done, stage: clock.tell(f"{name}{after}: {stage}"),
            )

        for budget in attempt.budgets:
            way = answer(min(budget.seconds, clock.left), budget.rounds)
            if _is_unmeasured(way) and clock.goes_on():
                way = answer(clock.left, budget.rounds)  # the same way, and its clearance
            is_cut = is_cut or _is_cut(way)
            if way.is_found or (attempt.direction is not None and way.blocked_by):
                break
        return way, is_cut

    def straight_way(self, budget: Budget, clock: Clock) -> tuple[Removal | None, bool]:
        """A straight way of the wanted parts with all other parts in place, if there is one: `removal` without
        searches. And whether time cut it."""

        def only_straight(_done: float, stage: str) -> None:
            if stage != "straight ways":
                raise _NotStraightError
            clock.tell(f"{self.names([TARGET])}: {stage}")

        options = {**self.grip, **self.options, "progress": only_straight}
        try:
            way = removal(self.scene, list(self.wanted), seconds=min(budget.seconds, clock.left), **options)
            if _is_unmeasured(way) and clock.goes_on():
                way = removal(self.scene, list(self.wanted), seconds=clock.left, **options)
        except _NotStraightError:
            return None, False
        return way if way.is_found else None, _is_cut(way)

    def is_met(self, nodes: frozenset[int], other: int, poses: npt.NDArray[np.float64]) -> bool:
        """Whether a way, `(n, 4, 4)`, collides with another part, or the wanted ones."""
        there = self.scene.only(list(self.parts_of([other])))
        return not there.check_path(self.moving(nodes), poses, touching="free").is_free

    def _held(self, nodes: frozenset[int], direction: Direction | None) -> dict[str, Any]:
        grip = self.grip if TARGET in nodes else dict.fromkeys(self.grip)
        return grip if direction is None else {**grip, "directions": [direction]}


def _is_cut(way: Removal) -> bool:
    """Whether time cut a search, or the measurement of what it found."""
    return way.is_out_of_time or _is_unmeasured(way)


def _is_unmeasured(way: Removal) -> bool:
    """Whether a way was found, and time was up before its clearance was measured."""
    return way.is_found and math.isnan(way.clearance)
