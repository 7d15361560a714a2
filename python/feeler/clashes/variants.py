"""`feeler.clash_variants`: the same check of many mock-ups, on an executor."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

from feeler.arguments import check_list, check_progress, shown
from feeler.choices import Chord
from feeler.clashes.finding import Exclude, clash
from feeler.clashes.result import Clashes
from feeler.clashes.rules import RulesLike
from feeler.errors import OptionError
from feeler.io import load_mockup
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.spreading import Interrupted, check_executor, spread


class VariantsInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.found` has the findings of the variants that were done, by their place in the list."""

    def __init__(self, found: dict[int, Clashes]) -> None:
        self.found = found
        super().__init__(f"interrupted: {len(found)} variants are done")

    def __reduce__(self) -> tuple[type[VariantsInterrupted], tuple[dict[int, Clashes]]]:
        return (type(self), (self.found,))


def clash_variants(
    variants: Sequence[Mockup | str | os.PathLike[str]],
    clearance: float = 0.002,
    contact: float | Chord = 0.0,
    rules: RulesLike | None = None,
    ignore: Exclude | None = None,
    volume: bool = False,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> list[Clashes]:
    """`clash` of each variant, in their order.

    - `variants`: mock-ups, or files as `load_mockup` takes them, saved scenes too; files are read by the workers.
    - `executor`: any `concurrent.futures.Executor`, as for `removals`; each variant is checked with one thread there.
      Default: one variant after the other, on all threads.
    - `progress`: called with the share of the variants done.

    Other arguments and errors as of `clash`. Ctrl-C ends it with `VariantsInterrupted`, which has the findings so far.
    """
    tasks = check_list("variants", variants, "a list of mock-ups or files")
    if not tasks:
        raise OptionError("variants is empty: give at least one mock-up or file")
    for i, variant in enumerate(tasks):
        if not isinstance(variant, (Mockup, str, os.PathLike)):
            raise OptionError(f"variants[{i}] is {shown(variant)}: give a mock-up, or the path of a file")
    check_progress(progress)
    options = {"clearance": clearance, "contact": contact, "rules": rules, "ignore": ignore, "volume": volume}
    pool = check_executor(executor)

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(tasks), stage or f"checking variants: {done:,} of {len(tasks):,}")

    # Threads of this process hear of Ctrl-C only so.
    stop = threading.Event() if isinstance(pool, ThreadPoolExecutor) else None
    try:
        return spread(_variant, None, (options, stop, None if pool is None else 1), tasks, pool, heard)
    except BaseException as error:
        if stop is not None:
            stop.set()
        if isinstance(error, Interrupted):
            raise VariantsInterrupted(error.results) from None
        raise


class _StopError(Exception):
    """The caller wants no more answers."""


def _variant(
    _: None,
    shared: tuple[dict[str, Any], threading.Event | None, int | None],
    variant: Mockup | str | os.PathLike[str],
) -> Clashes:
    """The task of one variant."""
    options, stop, threads = shared

    def check(_share: float, _stage: str) -> None:
        if stop is not None and stop.is_set():
            raise _StopError

    mockup = variant if isinstance(variant, Mockup) else load_mockup(variant)
    return clash(mockup, threads=threads, progress=check, **options)
