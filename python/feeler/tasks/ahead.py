"""Questions of a task that do not depend on each other, on the workers of an executor.

The search stays in the calling process. It hands over what it is likely to ask next, and takes the answers where it
would have asked. An answer that it does not ask for is thrown away, so that the plan does not depend on the workers.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from feeler.plan.fasteners import Fastener
from feeler.plan.question import LEAST_S, Clock
from feeler.plan.removal import Removal, removal
from feeler.scene import Scene
from feeler.spreading import Workers, spread
from feeler.stopping import check_stop
from feeler.tasks.reached import Reached, Reaching, TaskTools


@dataclass(frozen=True)
class ReachAsked:
    """Which tools reach a fastener while parts are out."""

    row: Fastener
    out: frozenset[int]
    turns: float
    enough: int | None
    """As `Reaching.ask`."""


@dataclass(frozen=True)
class WayAsked:
    """How parts come out while others are gone."""

    parts: tuple[int, ...]
    gone: frozenset[int]
    direction: tuple[float, float, float] | None
    """That of a straight one; None: any way."""
    rounds: int
    seed: int


def way_of(
    scene: Scene,
    asked: WayAsked,
    threads: int | None,
    seconds: float,
    progress: Callable[[float, str], object] | None = None,
) -> Removal:
    """The answer to a question for a way."""
    return removal(
        scene.without(sorted(asked.gone)) if asked.gone else scene,
        list(asked.parts),
        directions=None if asked.direction is None else [asked.direction],
        seconds=seconds,
        rounds=asked.rounds,
        seed=asked.seed,
        threads=threads,
        progress=progress,
    )


class Ahead:
    """Hands questions to the workers of an executor; without one it does nothing."""

    def __init__(
        self,
        scene: Scene,
        reaching: Reaching,
        clock: Clock,
        executor: Executor | None,
        ways: dict[WayAsked, Removal] | None = None,
    ) -> None:
        """ways: those that are known, and become known."""
        self._here = self._scene = scene
        self._reaching, self._clock = reaching, clock
        self._executor = executor
        self._shared = _Shared(reaching.given)
        self._workers: Workers | None = None
        self._ways: dict[WayAsked, Removal] = {} if ways is None else ways
        self._stack = ExitStack()

    def __enter__(self) -> Ahead:
        if self._executor is not None:
            self._workers = self._stack.enter_context(Workers(self._executor))
            if not self._workers.is_here:  # saved once for all that they do
                self._scene = self._stack.enter_context(self._scene._in_a_file())
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def has_workers(self) -> bool:
        """Whether an executor was given."""
        return self._executor is not None

    def reach(self, questions: Sequence[tuple[Fastener, frozenset[int], float]]) -> None:
        """Asks for several fasteners at once, and lets `Reaching` know the answers."""
        if self._workers is None or not self._reaching.is_checked:
            return
        new: dict[Hashable, ReachAsked] = {}
        for row, out, turns in questions:
            if not self._reaching.knows(row, out, turns):
                key = (row.part, out & self._reaching.near(row))
                new.setdefault(key, ReachAsked(row, out, turns, self._reaching.enough(row)))
        if len(new) > 1:
            tasks = list(new.values())
            for one, answer in zip(tasks, self._spread(tasks, "fasteners"), strict=False):
                self._reaching.foretell(one.row, one.out, answer)

    def try_ways(self, questions: Sequence[WayAsked]) -> None:
        """Tries several ways at once, up to the first that is not found."""
        new = [each for each in questions if each not in self._ways]
        if self._workers is not None and len(new) > 1:
            answers = self._spread(new, "ways", lambda way: not way.is_found)
            self._ways.update(zip(new, answers, strict=False))

    def way(self, asked: WayAsked, threads: int | None) -> Removal:
        """The answer to one."""
        if asked not in self._ways:
            left = self._clock.left
            found = way_of(self._here, asked, threads, left, lambda _share, _stage: self._clock.look())
            if found.is_out_of_time:
                return found
            self._ways[asked] = found
        return self._ways[asked]

    def _spread(
        self, tasks: Sequence[Any], what: str, is_last: Callable[[Any], bool] = lambda _: False
    ) -> Sequence[Any]:
        def heard(done: int, stage: str) -> None:
            self._clock.tell(stage or f"{what} at once: {done} of {len(tasks)}")

        assert self._workers is not None
        left = self._clock.left
        return spread(
            *(_done, self._scene, self._shared, [(task, left) for task in tasks], self._workers, heard),
            is_last=is_last,
            goes_on=self._clock.goes_on,
        )


class _Shared:
    """The tools, and what a thread made of them."""

    def __init__(self, tools: TaskTools) -> None:
        self._tools, self._own = tools, threading.local()

    def __getstate__(self) -> object:
        return {"tools": self._tools}

    def __setstate__(self, state: dict[str, TaskTools]) -> None:
        self._tools, self._own = state["tools"], threading.local()

    def reaching(self, scene: Scene) -> Reaching:
        """That of this thread."""
        made: Reaching | None = getattr(self._own, "reaching", None)
        if made is None:
            made = self._own.reaching = Reaching(scene, self._tools, 1)
        return made


def _done(scene: Scene, shared: _Shared, task: tuple[ReachAsked | WayAsked, float]) -> Reached | Removal:
    """The task of a worker."""
    asked, seconds = task
    check_stop()
    if isinstance(asked, ReachAsked):
        return shared.reaching(scene).ask(asked.row, asked.out, asked.turns, asked.enough)
    return way_of(scene, asked, 1, max(LEAST_S, seconds), check_stop)
