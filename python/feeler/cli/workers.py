"""Where the work of a command is done: `--workers` and `--dask`."""

from __future__ import annotations

import contextlib
import gc
import logging
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import TYPE_CHECKING, Annotated, Any

import typer

from feeler.cli.values import Value, Whole
from feeler.errors import OptionError

if TYPE_CHECKING:
    from concurrent.futures import Executor

MOST_WORKERS = 1024
PARENT_EVERY_S = 0.5
"""Between two looks of a worker whether its parent is there."""
AGAIN_AFTER_S = 5.0
"""Ctrl-C is heard again this long after the first, if the work has not ended by then."""
ENDS_WITHIN_S = 1.0
"""A worker that does not end within this time is killed."""
SCHEDULER_WITHIN_S = 5.0
"""A scheduler that does not answer within this time is none."""

_ADDRESS = re.compile(r"(?:[a-z]+://(?<!http://)(?<!https://))?(?:\[[0-9a-fA-F:.]+\]|[^\s:/\[\]]+):\d{1,5}")


@dataclass(frozen=True)
class _Scheduler(Value):
    """The address of a scheduler."""

    metavar: str = "tcp://HOST:PORT"

    def read(self, text: str) -> str:
        """See `Value.read`."""
        if _ADDRESS.fullmatch(text.strip()) is None:
            raise ValueError("give the address of a scheduler, such as tcp://127.0.0.1:8786")
        return text.strip()


Workers = Annotated[
    int | None,
    typer.Option("--workers", help="Processes that share the work, one thread each; default: threads of this one."),
    Whole(1, MOST_WORKERS),
]
Dask = Annotated[
    str | None,
    typer.Option(
        "--dask",
        help="Share the work with a Dask cluster, by the address of its scheduler. Its workers must reach the mock-up, "
        "a saved scene, by the same path.",
    ),
    _Scheduler(),
]


@contextlib.contextmanager
def executor_of(workers: int | None, dask: str | None) -> Iterator[Executor | None]:
    """The executor of the two options; None without them. Processes end with the block, also at Ctrl-C and SIGTERM,
    which raise `KeyboardInterrupt` there. What catches it has to be outside of the block."""
    if workers is not None and dask is not None:
        raise OptionError("--workers and --dask exclude each other: give one of them")
    if dask is not None:
        with _interrupted_once(), _client(dask) as client:
            yield client.get_executor()
    elif workers is not None:
        with _interrupted_once():
            context = _Context()
            pool = _Pool(workers, context, initializer=_begin, initargs=(os.getpid(),))
            try:
                yield pool
            except BaseException:
                _end(context)
                raise
            else:
                pool.shutdown()
    else:
        yield None


@contextlib.contextmanager
def _interrupted_once() -> Iterator[None]:
    """Of several Ctrl-C and SIGTERM only the first one raises `KeyboardInterrupt` here, so that what is done is not
    lost to the second; neither here nor, after the first one, while the command writes it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard_at: list[float] = []

    def hear(*_: object) -> None:
        if not heard_at or time.monotonic() - heard_at[-1] > AGAIN_AFTER_S:
            heard_at.append(time.monotonic())
            raise KeyboardInterrupt

    before = {number: signal.signal(number, hear) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items() if not heard_at else ():
            signal.signal(number, handler)


@contextlib.contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Ctrl-C and SIGTERM come after this block."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.signal(number, lambda number, _: came.append(number)) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


class _Worker(SpawnProcess):
    """A process that never hears Ctrl-C, not even while it starts: it inherits that SIGINT is blocked."""

    def start(self) -> None:
        """See `Process.start`."""
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            return super().start()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    """Makes workers, and keeps lists of them and of their pools."""

    def __init__(self) -> None:
        super().__init__()
        self.workers: list[_Worker] = []
        self.pools: list[_Pool] = []

    def Process(self, *args: Any, **kwargs: Any) -> _Worker:  # type: ignore[override]  # noqa: N802
        """See `multiprocessing.Process`."""
        self.workers.append(_Worker(*args, **kwargs))
        return self.workers[-1]


class _Pool(ProcessPoolExecutor):
    """A pool that Ctrl-C does not find half changed."""

    def __init__(self, max_workers: int, mp_context: _Context, **options: Any) -> None:
        super().__init__(max_workers, mp_context, **options)
        mp_context.pools.append(self)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """See `Executor.submit`."""
        with _interrupts_wait():
            return super().submit(fn, *args, **kwargs)


def _end(context: _Context) -> None:
    """Ends all workers at once, and what serves them in this process."""
    told, serving, queues = threading.excepthook, [], []

    def tell(args: Any) -> None:
        # The thread of a pool finds its workers gone, and fails with what nobody waits for.
        if args.thread not in serving:
            told(args)

    threading.excepthook = tell
    for pool in context.pools:
        inner: Any = pool
        if inner._executor_manager_thread is not None:
            serving.append(inner._executor_manager_thread)
        if inner._call_queue is not None:
            inner._call_queue.cancel_join_thread()  # its readers are ended
            queues.append(inner._call_queue)
        pool.shutdown(wait=False, cancel_futures=True)
    workers = [each for each in context.workers if each.pid is not None]
    for worker in workers:
        worker.terminate()
    until = time.monotonic() + ENDS_WITHIN_S
    for worker in workers:
        worker.join(max(0.0, until - time.monotonic()))
        if worker.is_alive():
            worker.kill()
    for thread in serving:
        thread.join(ENDS_WITHIN_S)
    for queue in queues:
        feeding = queue._thread
        queue.close()
        if feeding is not None:
            feeding.join(ENDS_WITHIN_S)
    # Their names in the system go here, not in a thread that the end of the program may stop half-way.
    queues.clear()
    gc.collect()
    threading.excepthook = told


def _begin(parent: int) -> None:
    """A worker does not hear Ctrl-C, which goes to all processes of a terminal: its parent ends it. It ends by itself
    if the parent is gone, by a signal that no program hears, for one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_EVERY_S)
        os._exit(1)

    threading.Thread(target=watch, name="parent", daemon=True).start()


def _client(address: str) -> Any:
    """A client of the scheduler there, which has answered. A client without a scheduler keeps trying long after it
    has failed, so the scheduler is asked before."""
    import asyncio

    try:
        distributed = import_module("distributed")
    except ImportError:
        raise OptionError("--dask needs the package distributed: pip install distributed") from None

    async def ask() -> None:
        async with distributed.rpc(address, timeout=SCHEDULER_WITHIN_S) as scheduler:
            await asyncio.wait_for(scheduler.identity(), SCHEDULER_WITHIN_S)

    try:
        with _silent():
            asyncio.run(asyncio.wait_for(ask(), SCHEDULER_WITHIN_S))
        return distributed.Client(address, timeout=SCHEDULER_WITHIN_S, set_as_default=False)
    except Exception as error:  # another server's answer may be anything, as a message of Dask
        reason = " ".join(str(error).split()) or f"nothing came within {SCHEDULER_WITHIN_S:g} s"
        raise OptionError(f"--dask is {address!r}: no scheduler answers there ({reason})") from None


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """What Dask logs of a scheduler that is none, feeler says itself."""
    logger = logging.getLogger("distributed")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before
