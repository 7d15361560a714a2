"""Spreads tasks over an executor: threads, processes, or another machine's workers.

A task carries the path and hash of a saved scene, never its arrays: each process opens the file once and keeps it. Any
`concurrent.futures.Executor` will do. Results come in the order of the tasks, whatever the workers.
"""

from __future__ import annotations

import hashlib
import pickle
import threading
import warnings
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Generic, Protocol, TypeVar

from feeler.errors import FeelerError, OptionError
from feeler.stopping import Stop, check_stop
from feeler.stopping import task as task_of


class Scene(Protocol):
    """A `feeler.Scene`, which uses this module."""

    def _in_a_file(self) -> AbstractContextManager[Any]: ...


Shared = TypeVar("Shared")
Task = TypeVar("Task")
Result = TypeVar("Result")

MOST_WAITING = 256
"""Tasks that are handed to the executor at a time: more would only fill its memory."""
CANCELLED_EVERY_S = 0.2
"""How often cancelled tasks are looked for."""
MOST_LOSSES = 3
"""So often tasks that were lost with their worker are done again."""
KEPT_IN_A_PROCESS = 2
"""Questions (a scene and all that tasks share) that a worker process keeps."""

_NONE = object()


class Interrupted(KeyboardInterrupt, Generic[Result]):
    """Ctrl-C; `.results` has those of the tasks that were done, by number."""

    def __init__(self, results: dict[int, Result]) -> None:
        self.results = results
        super().__init__(f"interrupted after {len(results)} tasks")


class WorkerLost(RuntimeWarning):
    """A worker died; its tasks are done again."""


def check_executor(executor: object) -> Executor | None:
    """The argument `executor`. Raises `OptionError` for anything that cannot take tasks."""
    if executor is None or (callable(getattr(executor, "submit", None)) and not isinstance(executor, type)):
        return executor  # type: ignore[return-value]
    raise OptionError(
        f"executor is {executor!r}: a concurrent.futures executor is needed, such as ProcessPoolExecutor(), "
        "loky.get_reusable_executor() or dask's client.get_executor()"
    )


class Workers:
    """An executor for several `spread`s. What takes its place when a worker dies serves those after it, too."""

    def __init__(self, executor: Executor) -> None:
        self.executor = executor
        self._made: list[Executor] = []

    @property
    def is_here(self) -> bool:
        """Whether they are threads of this process."""
        return isinstance(self.executor, ThreadPoolExecutor)

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        for pool in self._made:
            pool.shutdown(wait=False, cancel_futures=True)

    def renew(self) -> None:
        """A new executor in place of one that cannot go on after the death of a worker."""
        from concurrent.futures import ProcessPoolExecutor

        broken: Any = self.executor
        if isinstance(self.executor, ProcessPoolExecutor):
            # Of its own kind where that is feeler's: it takes the same arguments, and knows its processes.
            kind = type(self.executor) if type(self.executor).__module__.startswith("feeler.") else ProcessPoolExecutor
            self.executor = kind(
                broken._max_workers, broken._mp_context, initializer=broken._initializer, initargs=broken._initargs
            )
            self._made.append(self.executor)
        elif type(broken).__module__.startswith("loky"):
            self.executor = import_module("loky").get_reusable_executor(max_workers=broken._max_workers)
        else:
            raise FeelerError(f"a worker of {broken!r} died, and it takes no more tasks: start it again") from None


def spread(
    function: Callable[[Any, Shared, Task], Result],
    scene: Scene | None,
    shared: Shared,
    tasks: Sequence[Task],
    executor: Executor | Workers | None,
    heard: Callable[[int, str], object] = lambda done, stage: None,
    *,
    is_last: Callable[[Result], bool] = lambda result: False,
    goes_on: Callable[[], bool] = lambda: True,
) -> list[Result]:
    """`function(scene, shared, task)` for each task, in their order.

    - `function`: of a module, so that it can be pickled.
    - `scene`: None if the tasks need none.
    - `executor`: None for one task after the other in this thread.
    - `heard`: called with the number of tasks done and the stage, in the thread of the caller.
    - `is_last`: whether no result after this one is of use. The first such one, in the order of the tasks, ends it.
      The tasks after it are cancelled, and those that run already are told to end (`stopping.check_stop`).
    - `goes_on`: asked several times a second; where it says no, the results up to the first missing one are returned.

    A scene that is not in a file is saved to a temporary one for other processes. Tasks lost with a worker are done
    again, with a `WorkerLost` warning. Ctrl-C raises `Interrupted`; it and an error of a task end all others.
    """
    if executor is None:
        return _one_by_one(lambda task: function(scene, shared, task), tasks, heard, is_last, goes_on)
    with ExitStack() as stack:
        workers = executor if isinstance(executor, Workers) else stack.enter_context(Workers(executor))
        place: _Here[Shared, Task, Result] | _Elsewhere[Shared, Task, Result]
        if workers.is_here:
            place = _Here(function, scene, shared)
        else:
            saved = None if scene is None else stack.enter_context(scene._in_a_file())
            place = _Elsewhere(function, saved, shared)
        return _Round(place, tasks, workers, heard, is_last, goes_on).run()


def _one_by_one(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    heard: Callable[[int, str], object],
    is_last: Callable[[Result], bool],
    goes_on: Callable[[], bool],
) -> list[Result]:
    found: dict[int, Result] = {}
    try:
        for i, task in enumerate(tasks):
            if not goes_on():
                break
            found[i] = function(task)
            heard(i + 1, "")
            if is_last(found[i]):
                break
    except KeyboardInterrupt:
        raise Interrupted(found) from None
    return list(found.values())


@dataclass(frozen=True, eq=False)
class Done(Generic[Result]):
    """What a task returned, as an executor has to hand it on."""

    result: Result


class _Here(Generic[Shared, Task, Result]):
    """What a thread of this process does."""

    def __init__(self, function: Callable[[Any, Shared, Task], Result], scene: Scene | None, shared: Shared) -> None:
        self._function, self._scene, self._shared = function, scene, shared

    def submit(self, executor: Executor, task: Task, stop: Stop) -> Future[Done[Result]]:
        """Hands a task over."""
        return executor.submit(self._do, task, stop)

    def _do(self, task: Task, stop: Stop) -> Done[Result]:
        with task_of(stop):
            return Done(self._function(self._scene, self._shared, task))


class _Elsewhere(Generic[Shared, Task, Result]):
    """What another process does."""

    def __init__(self, function: Callable[[Any, Shared, Task], Result], scene: Scene | None, shared: Shared) -> None:
        self._question = pickle.dumps((function, scene, shared), protocol=pickle.HIGHEST_PROTOCOL)
        self._key = hashlib.sha256(self._question).hexdigest()

    def submit(self, executor: Executor, task: Task, stop: Stop) -> Future[Done[Result]]:
        """Hands a task over."""
        return executor.submit(work, self._key, self._question, task, stop)


_questions: OrderedDict[str, tuple[Callable[..., Any], Any, Any]] = OrderedDict()
_questions_lock = threading.Lock()


def work(key: str, question: bytes, task: Any, stop: Stop) -> Done[Any]:
    """One task, in a worker. The question is unpickled once in a process, which opens its scene."""
    with _questions_lock:
        known = _questions.get(key)
        if known is None:
            known = _questions[key] = pickle.loads(question)
            while len(_questions) > KEPT_IN_A_PROCESS:
                _questions.popitem(last=False)
    function, scene, shared = known
    with task_of(stop):
        check_stop()  # it may have waited in a queue
        return Done(function(scene, shared, task))


def _future(given: Future[Done[Result]]) -> Future[Done[Result]]:
    if not isinstance(given, Future):
        kind = type(given).__name__
        raise OptionError(f"executor.submit answered with a {kind}, no future: give one of concurrent.futures")
    return given


def _result(given: Done[Result]) -> Result:
    if not isinstance(given, Done):
        kind = type(given).__name__
        raise OptionError(f"the executor answered a task with a {kind}, not with what the task returned")
    return given.result


class _Round(Generic[Task, Result]):
    """All tasks on one executor, and what was lost again."""

    def __init__(
        self,
        place: _Here[Any, Task, Result] | _Elsewhere[Any, Task, Result],
        tasks: Sequence[Task],
        workers: Workers,
        heard: Callable[[int, str], object],
        is_last: Callable[[Result], bool],
        goes_on: Callable[[], bool],
    ) -> None:
        self._place, self._tasks, self._workers, self._heard = place, tasks, workers, heard
        self._is_last, self._goes_on = is_last, goes_on
        self._results: dict[int, Result] = {}
        self._looked_at = 0
        self._is_ended = False
        self._losses = 0
        self._stop = Stop()

    def run(self) -> list[Result]:
        try:
            while len(self._results) < len(self._tasks) and not self._is_ended:
                lost = self._try([i for i in range(len(self._tasks)) if i not in self._results])
                if lost is not None and not self._is_ended:
                    self._recover(lost)
            return [self._results[i] for i in range(self._looked_at)]
        except KeyboardInterrupt:
            raise Interrupted(self._results) from None

    def _try(self, numbers: list[int]) -> BaseException | None:
        """Does these tasks; the error of a lost worker if there was one."""
        waiting: dict[Future[Done[Result]], int] = {}
        lost: BaseException | None = None
        left = iter(numbers)
        try:
            while True:
                while lost is None and len(waiting) < MOST_WAITING and (i := next(left, None)) is not None:
                    try:
                        waiting[_future(self._place.submit(self._workers.executor, self._tasks[i], self._stop))] = i
                    except BrokenExecutor as error:
                        lost = error
                    except RuntimeError as error:  # of an executor that was shut down
                        raise FeelerError(f"the executor takes no more tasks: {error}; give one that runs") from None
                if not waiting:
                    return lost
                # Futures that somebody cancels, by ending the executor, are not among those that are waited for.
                finished = set(wait(waiting, CANCELLED_EVERY_S, FIRST_COMPLETED).done)
                finished |= {future for future in waiting if future.cancelled()}
                before = len(self._results)
                for future in sorted(finished, key=waiting.__getitem__):
                    i = waiting.pop(future)
                    try:
                        self._results[i] = _result(future.result())
                    except BaseException as error:
                        if not _is_loss(error):
                            raise
                        lost = error
                for done in range(before + 1, len(self._results) + 1):
                    self._heard(done, "")
                if self._ends():
                    return lost
        finally:
            running = [future for future in waiting if not future.cancel() and not future.done()]
            if running:
                self._stop.set(running)
            for future, i in waiting.items():
                if future.done() and not future.cancelled() and future.exception() is None:
                    with suppress(OptionError):
                        self._results[i] = _result(future.result())  # finished while nobody looked

    def _ends(self) -> bool:
        """Whether no further result is of use."""
        while not self._is_ended and self._looked_at in self._results:
            self._is_ended = self._is_last(self._results[self._looked_at])
            self._looked_at += 1
        self._is_ended = self._is_ended or not self._goes_on()
        return self._is_ended

    def _recover(self, error: BaseException) -> None:
        self._losses += 1
        missing = len(self._tasks) - len(self._results)
        if self._losses > MOST_LOSSES and isinstance(error, CancelledError):
            raise FeelerError(
                f"tasks were cancelled {self._losses} times, and {missing} of {len(self._tasks)} are not done: is the "
                "executor in use by something that cancels its tasks?"
            ) from None
        if self._losses > MOST_LOSSES:
            raise FeelerError(
                f"workers died {self._losses} times, and {missing} of {len(self._tasks)} tasks are not done: is there "
                f"enough memory for all of them? ({str(error) or type(error).__name__})"
            ) from error
        told = f"a worker died: {missing} tasks are done again"
        warnings.warn(f"{told} ({type(error).__name__})", WorkerLost, stacklevel=5)
        self._heard(len(self._results), told)
        if isinstance(error, BrokenExecutor):
            self._workers.renew()
        elif isinstance(error, CancelledError) and isinstance(self._place, _Here):
            raise FeelerError("tasks were cancelled: the executor was shut down while they waited") from None


def _is_loss(error: BaseException) -> bool:
    """Whether it says that a worker died, or that its results are lost."""
    if isinstance(error, (BrokenExecutor, CancelledError)):
        return True
    # Dask's, which need not be installed.
    return type(error).__module__.startswith("distributed") and type(error).__name__ in (
        "KilledWorker",
        "CommClosedError",
    )
