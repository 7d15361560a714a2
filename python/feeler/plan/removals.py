"""`feeler.removals`: the way of each of many parts, one after the other or on an executor."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from feeler.arguments import (
    check_flag,
    check_kind,
    check_length,
    check_list,
    check_number,
    check_progress,
    check_threads,
    check_whole,
    mask_of,
)
from feeler.errors import MeshError, OptionError
from feeler.field_docs import documented
from feeler.parts import PartsLike
from feeler.plan.removal import (
    LARGEST_ROUNDS,
    LARGEST_SEED,
    Allowed,
    Removal,
    checked_directions,
    chosen,
    not_tried,
    removal,
)
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.spreading import Interrupted, check_executor, spread
from feeler.stopping import check_stop


@documented
@dataclass(frozen=True, eq=False)
class PartsRemoval:
    """The removal of one entry of `removals`; true if a path was found."""

    parts: tuple[int, ...]
    """The parts that move together, by number."""
    paths: tuple[str, ...]
    """Their places in the assembly."""
    removal: Removal
    """The answer; one without a path where `error` says why there was no search."""
    error: str = ""
    """Why no path could be searched: none of the triangles can be queried. Empty if it was searched."""

    def __bool__(self) -> bool:
        return bool(self.removal)


class Removals(Sequence[PartsRemoval]):
    """The results of `removals`, one per entry, in their order."""

    def __init__(self, rows: Sequence[PartsRemoval], is_partial: bool = False) -> None:
        found = check_list("rows", rows, "a list of feeler.PartsRemoval")
        self._rows = tuple(check_kind("rows", row, PartsRemoval, "the rows of feeler.removals") for row in found)
        self.is_partial = check_flag("is_partial", is_partial)
        """Whether it was interrupted, so that some entries are missing."""

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> PartsRemoval: ...
    @overload
    def __getitem__(self, index: slice) -> list[PartsRemoval]: ...
    def __getitem__(self, index: int | slice) -> PartsRemoval | list[PartsRemoval]:
        return list(self._rows[index]) if isinstance(index, slice) else self._rows[index]

    def __iter__(self) -> Iterator[PartsRemoval]:
        return iter(self._rows)

    @property
    def is_found(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: for which entries there is a path."""
        return np.array([row.removal.is_found for row in self._rows], dtype=bool)

    @property
    def is_out_of_time(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: for which entries `seconds` ran out."""
        return np.array([row.removal.is_out_of_time for row in self._rows], dtype=bool)

    def __repr__(self) -> str:
        partial = ", interrupted" if self.is_partial else ""
        return f"Removals({int(self.is_found.sum()):,} of {len(self):,} found{partial})"


class RemovalsInterrupted(KeyboardInterrupt):
    """Ctrl-C; `.removals` has the answers finished by then."""

    def __init__(self, removals: Removals) -> None:
        self.removals = removals
        super().__init__(f"interrupted: {removals!r}")

    def __reduce__(self) -> tuple[type[RemovalsInterrupted], tuple[Removals]]:
        return (type(self), (self.removals,))


def removals(
    scene: Scene,
    parts: Sequence[PartsLike] | None = None,
    ignore: PartsLike | None = None,
    directions: npt.ArrayLike | None = None,
    clearance: float = 0.0,
    seconds: float = 30.0,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
    *,
    overlap: float = 0.0,
    seats: bool = True,
    rounds: int | None = None,
    executor: Executor | None = None,
) -> Removals:
    """`removal` of each entry of a list, with all other parts in place.

    - `parts`: each entry as `Parts.select` takes it, and moves as one; by default each part of the scene on its own.
    - `seconds`, `rounds`: for each entry. With `rounds`, rows do not depend on how busy a worker is, unless `seconds`
      end them (`is_out_of_time`).
    - `threads`: entries worked on at a time without an executor; default: all cores.
    - `executor`: where the work is done, one thread for each entry: any `concurrent.futures.Executor`, such as
      `ProcessPoolExecutor`, loky's, or that of a Dask client. Processes on other machines must reach the file of a
      saved scene (`Scene.save`) by the same path.
    - `progress`: called with the share of the entries done.

    Other arguments as of `removal`. The rows and their order depend neither on `threads` nor on `executor`, except
    where time ran out (`is_out_of_time`). A worker that dies is made up for, with a warning.

    An entry of which no triangle can be queried does not end it: its row has an `error`. Raises the other errors of
    `removal`, before the work begins; Ctrl-C ends it with `RemovalsInterrupted`, which has the rows found by then.
    """
    if not isinstance(scene, Scene):
        raise MeshError(f"removals needs a feeler.Scene, not {type(scene).__name__}")
    allowed = Allowed.of(scene, ignore, overlap, seats)
    options: dict[str, Any] = {
        "ignore": list(allowed.parts),
        "overlap": allowed.overlap,
        "seats": allowed.seats,
        "directions": checked_directions(directions),
        "clearance": check_length("clearance", clearance),
        "seconds": check_number("seconds", seconds, "more than 0", above=0.0, is_endless=True),
        "seed": check_whole("seed", seed, 0, LARGEST_SEED),
        "rounds": None if rounds is None else check_whole("rounds", rounds, 0, LARGEST_ROUNDS),
    }
    count = check_threads(threads) or os.cpu_count() or 1
    check_progress(progress)
    entries = _entries(scene, parts)

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(entries), stage or f"removing parts: {done:,} of {len(entries):,}")

    own = None if executor is not None else ThreadPoolExecutor(count, thread_name_prefix="feeler-removals")
    pool = check_executor(executor) or own
    assert pool is not None
    try:
        answers = dict(enumerate(spread(_removal, scene, options, entries, pool, heard)))
    except Interrupted as interrupted:
        raise RemovalsInterrupted(_rows(scene, entries, interrupted.results, options["seed"])) from None
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)
    return _rows(scene, entries, answers, options["seed"])


def _entries(scene: Scene, parts: Sequence[PartsLike] | None) -> list[tuple[int, ...]]:
    if parts is None:
        return [(int(part),) for part in np.flatnonzero(scene.part_mask)]
    if mask_of(parts) is not None:
        raise OptionError("parts is a mask: give np.flatnonzero(parts) for one entry each, or [parts] for all in one")
    given = check_list("parts", parts, "a list, each entry of which names parts that move together")
    entries = [tuple(int(part) for part in scene.mockup.parts.select(entry)) for entry in given]
    if not entries:
        raise OptionError("parts is empty: give at least one entry, or None for each part of the scene")
    for entry in entries:
        chosen(scene, entry)
    return entries


def _removal(scene: Scene, options: dict[str, Any], entry: tuple[int, ...]) -> Removal | str:
    """The task of one entry: its answer, or why there is none."""
    try:
        return removal(scene, list(entry), threads=1, progress=check_stop, **options)
    except MeshError as error:  # nothing of these parts can be queried
        return str(error)


def _rows(scene: Scene, entries: list[tuple[int, ...]], answers: dict[int, Removal | str], seed: int) -> Removals:
    paths = scene.mockup.part_paths
    rows = []
    for i, entry in enumerate(entries):
        if i in answers:
            answer, names = answers[i], tuple(paths[part] for part in entry)
            if isinstance(answer, str):
                rows.append(PartsRemoval(entry, names, not_tried(seed, is_out_of_time=False), answer))
            else:
                rows.append(PartsRemoval(entry, names, answer))
    return Removals(rows, is_partial=len(rows) < len(entries))
