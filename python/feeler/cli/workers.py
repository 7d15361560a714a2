"""Where the work of a command is done: `--workers` and `--dask`."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer

from feeler.cli.values import Text, Whole
from feeler.errors import OptionError

if TYPE_CHECKING:
    from concurrent.futures import Executor

MOST_WORKERS = 1024
PARENT_EVERY_S = 0.5
"""Between two looks of a worker whether its parent is there."""

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
    Text("tcp://HOST:PORT"),
]


@contextlib.contextmanager
def executor_of(workers: int | None, dask: str | None) -> Iterator[Executor | None]:
    """The executor of the two options; None without them. Processes end with the block, also at Ctrl-C."""
    if workers is not None and dask is not None:
        raise OptionError("--workers and --dask exclude each other: give one of them")
    if dask is not None:
        with _client(dask) as client:
            yield client.get_executor()
    elif workers is not None:
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        context = multiprocessing.get_context("spawn")
        pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(os.getpid(),))
        try:
            yield pool
        except BaseException:
            processes = list((pool._processes or {}).values())
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            raise
        else:
            pool.shutdown()
    else:
        yield None


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
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise OptionError("--dask needs the package distributed: pip install distributed") from None
    try:
        return distributed.Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise OptionError(f"--dask is {address!r}: no scheduler answers there ({error})") from None
