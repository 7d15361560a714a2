"""The interface of the bench's engines, and feeler's implementation. A peer is one more class of this shape.

An engine builds its index of a mock-up, takes a tool, and is aimed at a pose outside the clock: `aim` converts the pose
to the engine's types, as a user does once per pose, and returns the bare call to time.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import feeler

Floats = npt.NDArray[np.float64]
Pairs = npt.NDArray[np.uint32]

KINDS_OF = {
    "collide": ("nominal", "near", "deep"),
    "is_colliding": ("nominal", "near"),
    "distance": ("near",),
    "contacts": ("nominal",),
    "cast": ("near",),
}
"""The queries, and their kinds of poses."""
AT_ONE_SIZE = ("contacts", "cast")
QUERIES = tuple(KINDS_OF)
ANY = ("collide", "is_colliding")  # of an engine that does not say
NOTHING_HIT = 2.0  # beyond the end of the way
LONG = 5.0  # seconds; such a build is done once


@dataclass
class Build:
    """Time and memory to build an index. Seconds are the best of `runs`."""

    engine: str
    runs: int
    one_core_s: float
    all_cores_s: float | None  # None: the engine builds on one core only
    bytes: int | None  # as the engine itself counts; None: it does not
    rss_growth_bytes: int | None  # growth of the process by the index, None where it cannot be told
    peak_growth_bytes: int | None  # the most it had grown while the index was built

    def row(self, triangles: int) -> dict[str, Any]:
        """The figures, also per triangle."""
        row = asdict(self)
        for name in ("bytes", "rss_growth_bytes", "peak_growth_bytes"):
            row[f"{name}_per_triangle"] = None if row[name] is None else row[name] / triangles
        return row


class Engine(Protocol):
    """One collision engine under measurement; its queries run on one core."""

    name: str
    version: str
    settings: str

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        """Build the index of a mock-up, `runs` times, and keep the last."""

    def prepare(self, tool: feeler.Tool) -> float:
        """Take a tool; return the seconds it took."""

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        """Prepares a query (one of `QUERIES`) at a pose, unclocked; the returned function runs it.

        For `cast` it is two poses, `(2, 4, 4)`: where the motion begins and ends.
        """

    def pairs(self, result: Any) -> Pairs:
        """`(k, 2)`: tool and mock-up triangles of the last `collide`, sorted and unique."""

    def answer(self, result: Any) -> bool:
        """The answer of the last `is_colliding`."""

    def stats(self, result: Any) -> dict[str, int]:
        """Counts of the last `collide`, stage by stage; empty if the engine has none."""

    # An engine with more queries than collisions has `queries`, and `value(result)`: the answer as one number, metres
    # for `distance`, the free share of the path for `cast` (2 where nothing is hit), planes for `contacts`.


def able(among: Sequence[Engine], query: str) -> list[Engine]:
    """The engines that can answer a query."""
    return [engine for engine in among if query in getattr(engine, "queries", ANY)]


class FeelerEngine:
    """feeler through its public Python face, with all defaults."""

    name = "feeler"
    queries = QUERIES
    version = feeler.__version__
    settings = (
        "Scene(mockup), defaults; scene.collide(tool, pose), scene.is_colliding, scene.distance, scene.contacts with "
        "its margin of 2 mm, scene.cast with its tolerance of 1 um; checks included"
    )
    scene: feeler.Scene = None  # type: ignore[assignment]
    tool: feeler.Tool

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        self.scene = None  # type: ignore[assignment]
        # Memory is measured on one core: with more threads more of it is taken while building.
        one, growth, peak = build_times(lambda: self._build(mockup, 1), runs)
        every, _, _ = build_times(lambda: self._build(mockup, None), runs)
        return Build(self.name, runs, one, every, self.scene.memory()["total"], growth, peak)

    def _build(self, mockup: feeler.Mockup, threads: int | None) -> None:
        self.scene = None  # type: ignore[assignment]
        self.scene = feeler.Scene(mockup, threads=threads)

    def prepare(self, tool: feeler.Tool) -> float:
        start = time.perf_counter()
        # A new one, so that the preparation is paid here and not within the first query.
        self.tool = feeler.Tool(tool.vertices, tool.faces, tool.name)
        return time.perf_counter() - start

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        poses = world_from_tool if query == "cast" else (world_from_tool,)
        return functools.partial(getattr(self.scene, query), self.tool, *poses)

    def pairs(self, result: Any) -> Pairs:
        return np.asarray(result.pairs)

    def answer(self, result: Any) -> bool:
        return bool(result)

    def stats(self, result: Any) -> dict[str, int]:
        return dict(result.stats)

    def value(self, result: Any) -> float:
        if isinstance(result, feeler.Distance):
            return float(result.value)
        if isinstance(result, feeler.Contacts):
            return float(len(result))
        return NOTHING_HIT if result is None else float(result.fraction)


def build_times(build: Callable[[], None], runs: int) -> tuple[float, int | None, int | None]:
    """Best wall seconds of `runs` builds; growth of the process in the first of them, and its peak.

    `build` first drops its previous index. A build that takes longer than `LONG` is not repeated. The growth is that of
    the process, the allocator's leftovers included: only a check of an engine's own figure. It is known where there
    is a /proc.
    """
    best, growth, peak = float("inf"), None, None
    for run in range(runs):
        _trim()
        before = _resident("VmRSS")
        _forget_peak()
        start = time.perf_counter()
        build()
        best = min(best, time.perf_counter() - start)
        if run == 0:
            highest = _resident("VmHWM")
            _trim()
            after = _resident("VmRSS")
            if before is not None and after is not None and highest is not None:
                growth, peak = after - before, highest - before
        if best > LONG:
            break
    return best, growth, peak


def _trim() -> None:
    """Give freed memory back to the system, where the C library can."""
    gc.collect()
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _resident(field: str) -> int | None:
    """Bytes of the process in memory: now (VmRSS), or at most (VmHWM)."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith(f"{field}:"):
                return int(line.split()[1]) * 1024
    return None


def _forget_peak() -> None:
    """Resets VmHWM to the memory in use now."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
