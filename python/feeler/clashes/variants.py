"""`feeler.clash_variants`: the same check of many mock-ups, on an executor."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any

from feeler.arguments import check_list, check_progress, shown
from feeler.choices import Chord
from feeler.clashes.finding import Exclude, checked_limits, clash
from feeler.clashes.result import Clashes
from feeler.clashes.rules import RulesLike, rules_from
from feeler.errors import FeelerError, OptionError
from feeler.io.load import is_saved, load_mockup
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.spreading import Interrupted, check_executor, spread
from feeler.stopping import check_stop
from feeler.words import plural

_SAID = 3
"""Errors that `VariantsError` says."""


class VariantsInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.found` has the findings of the variants that were done, by their place in the list."""

    def __init__(self, found: dict[int, Clashes]) -> None:
        self.found = found
        super().__init__(f"interrupted: {len(found)} variants are done")

    def __reduce__(self) -> tuple[type[VariantsInterrupted], tuple[dict[int, Clashes]]]:
        return (type(self), (self.found,))


class VariantsError(FeelerError):
    """Some variants could not be checked; all others were."""

    def __init__(self, results: dict[int, Clashes | FeelerError]) -> None:
        self.results = results
        self.found = {i: each for i, each in results.items() if isinstance(each, Clashes)}
        """The findings of the variants that were checked, by their place in the list."""
        self.errors = {i: each for i, each in results.items() if isinstance(each, FeelerError)}
        """The error of each other variant, by its place in the list."""
        said = [f"variants[{i}]: {error}" for i, error in self.errors.items()]
        more = f"; and {len(said) - _SAID:,} more" if len(said) > _SAID else ""
        super().__init__(
            f"{len(said):,} of {plural(len(results), 'variant')} cannot be checked: {'; '.join(said[:_SAID])}{more}"
        )

    def __reduce__(self) -> tuple[type[VariantsError], tuple[dict[int, Clashes | FeelerError]]]:
        return (type(self), (self.results,))


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

    Other arguments as of `clash`, and checked before the work begins. Variants that cannot be read or checked do not
    end it: at the end, `VariantsError` has their errors, and the findings of all others. Ctrl-C ends it with
    `VariantsInterrupted`, which has the findings so far.
    """
    tasks = check_list("variants", variants, "a list of mock-ups or files")
    if not tasks:
        raise OptionError("variants is empty: give at least one mock-up or file")
    for i, variant in enumerate(tasks):
        if not isinstance(variant, (Mockup, str, os.PathLike)):
            raise OptionError(f"variants[{i}] is {shown(variant)}: give a mock-up, or the path of a file")
    check_progress(progress)
    checked_limits(clearance, contact, volume)
    options = {"clearance": clearance, "contact": contact, "rules": rules, "ignore": ignore, "volume": volume}
    pool = check_executor(executor)

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(tasks), stage or f"checking variants: {done:,} of {len(tasks):,}")

    if pool is not None:
        options["rules"] = rules_from(rules)  # read here: a worker may be in another folder, or on another machine
    tasks = [_as_workers_take_it(variant, f"variants[{i}]") for i, variant in enumerate(tasks)]
    try:
        found = spread(_variant, None, (options, None if pool is None else 1), tasks, pool, heard)
    except Interrupted as interrupted:
        done = interrupted.results
        raise VariantsInterrupted({i: each for i, each in done.items() if isinstance(each, Clashes)}) from None
    rows = [each for each in found if isinstance(each, Clashes)]
    if len(rows) < len(found):
        raise VariantsError(dict(enumerate(found)))
    return rows


def _as_workers_take_it(variant: Mockup | str | os.PathLike[str], what: str) -> Mockup | str:
    """A variant for workers: an absolute path, or of a saved scene the mock-up, whose pickle has path and hash."""
    if isinstance(variant, Mockup):
        return variant
    path = os.path.abspath(os.fspath(variant))
    try:
        mockup = load_mockup(path) if is_saved(path) else None
    except FeelerError:
        return path  # told by the worker, and so for this variant alone
    if mockup is None or mockup._saved is None:
        return path
    absent = mockup._saved.core.absent_parts
    if absent:
        told = f"{what}: the scene was saved without {len(absent):,} of its parts, which are checked, too"
        warnings.warn(f"{told}: {mockup.part_paths[absent[0]]}" + (", ..." if len(absent) > 1 else ""), stacklevel=3)
    return mockup


def _variant(
    _: None, shared: tuple[dict[str, Any], int | None], variant: Mockup | str | os.PathLike[str]
) -> Clashes | FeelerError:
    """The task of one variant: its findings, or the error that it cannot be checked for."""
    options, threads = shared
    try:
        mockup = variant if isinstance(variant, Mockup) else load_mockup(variant, progress=check_stop)
        return clash(mockup, threads=threads, progress=check_stop, **options)
    except FeelerError as error:
        return error
