"""Batches of poses on an executor: cut into chunks, and joined again in their order."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import UNREADABLE
from feeler.errors import LimitError
from feeler.poses import PosesLike, plain
from feeler.progress import Progress
from feeler.spreading import Interrupted, check_executor, spread

CHUNK = 20_000
"""Poses of a task: some tenths of a second of work, so that handing it over costs little."""
_ROUNDING = 5e-7
"""Poses within this of a rotation are rigid; others are looked at by the core, which names the one that is not."""

Result = TypeVar("Result", _core.Batch, _core.DistanceBatch, _core.ClearanceBatch)


def on_executor(
    here: Callable[[], Result],
    scene: Any,
    query: tuple[str, tuple[Any, ...], dict[str, Any]],
    poses: PosesLike,
    executor: Executor,
    progress: Progress | None,
    limit: int,
) -> Result:
    """The result of a batch query of a scene.

    `here`: the query in this process. `query`: the name of the method, its arguments before the poses and after them.
    """
    check_executor(executor)
    try:
        given = np.asarray(plain(poses), dtype=np.float64)
    except UNREADABLE:
        return here()  # says what is wrong
    if given.ndim != 3 or given.shape[1:] != (4, 4) or len(given) <= CHUNK or not _are_surely_rigid(given):
        return here()
    count = math.ceil(len(given) / CHUNK)

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / count, stage or "asking poses")

    chunks = [given[i * CHUNK : (i + 1) * CHUNK] for i in range(count)]
    found: list[Result]
    try:
        found = spread(_query, scene, query, chunks, executor, heard)
    except Interrupted:
        raise KeyboardInterrupt from None
    return _joined(found, limit)


def _query(scene: Any, query: tuple[str, tuple[Any, ...], dict[str, Any]], poses: npt.NDArray[np.float64]) -> Any:
    """The task of one chunk."""
    name, before, options = query
    return getattr(scene, name)(*before, poses, **options)


def _are_surely_rigid(poses: npt.NDArray[np.float64]) -> bool:
    turns = poses[:, :3, :3]
    with np.errstate(all="ignore"):
        off = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
        is_even = np.linalg.det(turns).min(initial=1.0) > 0.0
    return bool(off < _ROUNDING and is_even and np.isfinite(poses).all() and (poses[:, 3] == [0, 0, 0, 1]).all())


def _joined(results: list[Result], limit: int) -> Result:
    """One result of those of all chunks: of their states, as pickles have them."""
    reduced: list[Any] = [result.__reduce__() for result in results]
    restore, (written_in, written_by, kind, _) = reduced[0]
    columns: list[Any] = list(zip(*(state for _, (*_, state) in reduced), strict=True))
    size = sum(array.nbytes for column in columns for array in column)
    if size > limit:
        raise LimitError(
            f"the result of all poses takes {size:,} bytes, more than the {limit:,} allowed: ask fewer poses"
        )
    if kind != "DistanceBatch":  # the first column is where the rows of each pose begin
        starts = np.cumsum([0, *(offsets[-1] for offsets in columns[0])], dtype=np.uint64)
        shifted: list[Any] = [offsets[1:] + start for offsets, start in zip(columns[0], starts[:-1], strict=True)]
        columns[0] = [np.zeros(1, dtype=np.uint64), *shifted]
    state = tuple(np.concatenate(column) for column in columns)
    joined: Result = restore(written_in, written_by, kind, state)
    return joined
