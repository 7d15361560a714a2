"""Times single queries."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler
from feeler.progress import Progress

_WARM_UP = 20


def warm_up(scene: feeler.Scene, tool: feeler.Tool, poses: npt.NDArray[np.float64]) -> None:
    """Runs a few queries, spread over the poses, so that buffers are allocated and the index is in the cache."""
    for pose in poses[:: max(len(poses) // _WARM_UP, 1)]:
        scene.collide(tool, pose)


def collide_each(
    scene: feeler.Scene,
    tool: feeler.Tool,
    poses: npt.NDArray[np.float64],
    progress: Progress | None = None,
) -> tuple[npt.NDArray[np.float64], list[Any]]:
    """Seconds of each `scene.collide`, (n,), on one thread, and the collisions."""
    seconds, hits = np.empty(len(poses)), []
    for number, pose in enumerate(poses):
        start = time.perf_counter()
        hit = scene.collide(tool, pose)
        seconds[number] = time.perf_counter() - start
        hits.append(hit)
        if progress is not None and number % 50 == 0:
            progress(number / len(poses), f"{number:,} of {len(poses):,} poses")
    return seconds, hits
