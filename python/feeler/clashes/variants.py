"""`feeler.clash_variants`: the same check of many mock-ups, on an executor."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

from feeler.arguments import check_progress
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
    contact: float | str = 0.0,
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
    given: object = variants
    if isinstance(given, (str, bytes, os.PathLike, Mockup)) or not hasattr(given, "__iter__"):
        raise OptionError(f"variants is {variants!r}: a list of mock-ups or files is needed")
    tasks = list(variants)
    if not tasks:
        raise OptionError("variants is empty: give at least one mock-up or file")
    for i, variant in enumerate(tasks):
        if not isinstance(variant, (Mockup, str, os.PathLike)):
            raise OptionError(f"variants[{i}] is {variant!r}: a mock-up or the path of a file is needed")
    check_progress(progress)
    options = {"clearance": clearance, "contact": contact, "rules": rules, "ignore": ignore, "volume": volume}
    own = None if executor is not None else ThreadPoolExecutor(1, thread_name_prefix="feeler-variants")
    pool = check_executor(executor) or own
    assert pool is not None

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(tasks), stage or f"checking variants: {done:,} of {len(tasks):,}")

    try:
        return spread(_variant, None, (options, None if own is not None else 1), tasks, pool, heard)
    except Interrupted as interrupted:
        raise VariantsInterrupted(interrupted.results) from None
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)


def _variant(_: None, shared: tuple[dict[str, Any], int | None], variant: Mockup | str | os.PathLike[str]) -> Clashes:
    """The task of one variant."""
    options, threads = shared
    mockup = variant if isinstance(variant, Mockup) else load_mockup(variant)
    return clash(mockup, threads=threads, **options)
