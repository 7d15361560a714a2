"""What the bench asks of an engine, and feeler's answer to it. A peer is one more class of this shape.

An engine builds its index of a mock-up, takes a tool, and is aimed at a pose outside the clock: `aim` does what a user
would do once per pose to get the numbers into the engine's types, and returns the bare call to be timed.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import gc
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import feeler

Floats = npt.NDArray[np.float64]
Pairs = npt.NDArray[np.uint32]


@dataclass
class Build:
    """What it took to build an index. Seconds are the best of `runs`."""

    engine: str
    runs: int
    one_core_s: float
    all_cores_s: float | None  # None: the engine builds on one core only
    bytes: int  # as the engine itself counts
    rss_growth_bytes: int | None  # growth of the process while the index was built, None where it cannot be told

    def row(self, triangles: int) -> dict[str, Any]:
        """The figures, also per triangle."""
        rss = self.rss_growth_bytes
        return asdict(self) | {
            "bytes_per_triangle": self.bytes / triangles,
            "rss_growth_bytes_per_triangle": None if rss is None else rss / triangles,
        }


class Engine(Protocol):
    """One collision engine under measurement; its queries run on one core."""

    name: str
    version: str
    settings: str

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        """Build the index of a mock-up, `runs` times, and keep the last."""

    def prepare(self, tool: feeler.Tool) -> float:
        """Take a tool; return the seconds it took."""

    def aim(self, world_from_tool: Floats) -> Callable[[], Any]:
        """Make ready for a pose, unclocked; what is returned finds all pairs when called."""

    def pairs(self, result: Any) -> Pairs:
        """`(k, 2)`: tool and mock-up triangles of the last call, sorted and unique."""

    def stats(self, result: Any) -> dict[str, int]:
        """What the last call did, stage by stage; empty if the engine does not tell."""


class FeelerEngine:
    """feeler through its public Python face, with all defaults."""

    name = "feeler"
    version = feeler.__version__
    settings = "Scene(mockup), defaults; scene.collide(tool, pose), checks of the pose included"
    scene: feeler.Scene
    tool: feeler.Tool

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        self.scene = None  # type: ignore[assignment]
        one, _ = build_times(lambda: feeler.Scene(mockup, threads=1), runs)
        every, growth = build_times(lambda: self._keep(feeler.Scene(mockup)), runs)
        return Build(self.name, runs, one, every, self.scene.memory()["total"], growth)

    def _keep(self, scene: feeler.Scene) -> None:
        self.scene = scene

    def prepare(self, tool: feeler.Tool) -> float:
        start = time.perf_counter()
        # A new one, so that the preparation is paid here and not within the first query.
        self.tool = feeler.Tool(tool.vertices, tool.faces, tool.name)
        return time.perf_counter() - start

    def aim(self, world_from_tool: Floats) -> Callable[[], Any]:
        return functools.partial(self.scene.collide, self.tool, world_from_tool)

    def pairs(self, result: Any) -> Pairs:
        return np.asarray(result.pairs)

    def stats(self, result: Any) -> dict[str, int]:
        return dict(result.stats)


def build_times(build: Callable[[], None], runs: int) -> tuple[float, int | None]:
    """Best wall seconds of `runs` builds, and how much the process grew in the first of them.

    The growth is what the operating system saw, allocator's leftovers included: a check of what an engine says of
    itself, no more. It is known where /proc is.
    """
    best, growth = float("inf"), None
    for run in range(runs):
        _trim()
        before = _resident()
        start = time.perf_counter()
        build()
        best = min(best, time.perf_counter() - start)
        if run == 0:
            _trim()
            after = _resident()
            growth = None if before is None or after is None else after - before
    return best, growth


def _trim() -> None:
    """Give freed memory back to the system, where the C library can."""
    gc.collect()
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _resident() -> int | None:
    with contextlib.suppress(OSError, ValueError, IndexError):
        return int(Path("/proc/self/statm").read_text().split()[1]) * _page_size()
    return None


def _page_size() -> int:
    import resource

    return resource.getpagesize()
