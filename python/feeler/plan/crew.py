"""The parts of a search for a removal order that do not depend on each other, on the workers of an executor.

The search itself stays in the calling process. It hands over attempts and parts that it is likely to ask about next,
and takes the answers in the order in which it would have found them. An answer that it does not ask for is thrown away.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from typing import Any

from feeler.plan.blocking import BlockingGraph, FirstExits
from feeler.plan.question import Attempt, Clock, Question
from feeler.plan.removal import Removal
from feeler.scene import Scene
from feeler.spreading import Workers, spread
from feeler.stopping import is_stopped

Tried = tuple[Removal, bool]


class Crew:
    """Answers attempts: on workers ahead of time, if there are any, or here when they are asked for."""

    def __init__(self, question: Question, clock: Clock, executor: Executor | None) -> None:
        self.question, self.clock = question, clock
        self.is_cut = False
        """Whether time cut an attempt that was asked for."""
        self._executor = executor
        self._workers: Workers | None = None
        self._scene = question.scene
        self._shared = _Shared(question)
        self._ahead: dict[Attempt, Tried] = {}
        self._stack = ExitStack()

    def __enter__(self) -> Crew:
        if self._executor is not None:
            self._workers = self._stack.enter_context(Workers(self._executor))
            if not self._workers.is_here:  # saved once for all that they do
                self._scene = self._stack.enter_context(self.question.scene._in_a_file())
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def way(self, attempt: Attempt) -> Removal:
        """The answer to an attempt."""
        known = self._ahead.pop(attempt, None)
        way, is_cut = self.question.tried(attempt, self.clock) if known is None else known
        self.is_cut = self.is_cut or is_cut
        return way

    def try_ahead(self, attempts: Sequence[Attempt], is_last: Callable[[Removal], bool]) -> None:
        """Tries several attempts at once, if there are workers. The first for which `is_last` holds is the last one
        that is needed."""
        if self._workers is not None and len(attempts) > 1:
            answers = self._spread(attempts, "attempts", lambda tried: is_last(tried[0]))
            self._ahead = dict(zip(attempts, answers, strict=False))

    def exits(self, nodes: Sequence[int]) -> dict[int, FirstExits]:
        """The first exits of several parts."""
        return dict(zip(nodes, self._spread(nodes, "parts", lambda _: False), strict=False))

    @property
    def has_workers(self) -> bool:
        """Whether an executor was given."""
        return self._executor is not None

    def _spread(self, tasks: Sequence[Any], what: str, is_last: Callable[[Any], bool]) -> list[Any]:
        def heard(done: int, stage: str) -> None:
            self.clock.tell(stage or f"{what} at once: {done} of {len(tasks)}")

        assert self._workers is not None
        self.clock.tell(f"{what} at once: 0 of {len(tasks)}")
        left = self.clock.left
        return spread(
            *(done, self._scene, self._shared, [(task, left) for task in tasks], self._workers, heard),
            is_last=is_last,
            goes_on=self.clock.goes_on,
        )


class _Shared:
    """The question without its scene, which workers have from its file; and what a thread found of it so far."""

    def __init__(self, question: Question) -> None:
        self._asked: dict[str, Any] = {
            "wanted": question.wanted,
            "kept": question.kept,
            "grip": question.grip,
            "options": {**question.options, "threads": 1},
        }
        self._own = threading.local()

    def __getstate__(self) -> dict[str, Any]:
        return self._asked

    def __setstate__(self, asked: dict[str, Any]) -> None:
        self._asked, self._own = asked, threading.local()

    def graph(self, scene: Scene, clock: Clock) -> BlockingGraph:
        """The graph of this thread, which knows the fasteners that it has seen."""
        graph: BlockingGraph | None = getattr(self._own, "graph", None)
        if graph is None:
            graph = self._own.graph = BlockingGraph(Question(scene, **self._asked), clock)
        graph.clock = clock
        return graph


def done(scene: Scene, shared: _Shared, task: tuple[Attempt | int, float]) -> Tried | FirstExits:
    """The task of a worker: an attempt, or the exits of a part."""
    what, seconds = task
    graph = shared.graph(scene, Clock(seconds, is_stopped=is_stopped))
    return graph.question.tried(what, graph.clock) if isinstance(what, Attempt) else graph.first_exits(what)
