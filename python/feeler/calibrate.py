"""The cost of each step of a query on this machine: measured once, in less than a second, and kept in the user's cache.

The core predicts how often a query runs each step (`feeler._core.Predictor`); these counts times the constants give the
predicted time. A least-squares fit finds the constants from times and counters of real queries in a small test scene.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from feeler import _core

Constants = tuple[float, float, float, float, float, float]

NAMES = ("query", "tool_triangle", "voxel", "entry", "pair", "test")
"""The counted steps; the constants are seconds for one of each, in this order."""

TYPICAL: Constants = (1.2e-5, 4.0e-8, 3.0e-9, 4.0e-10, 9.0e-9, 3.5e-8)

_LAYOUT = 1  # of the file; a file with another number is measured anew
_SIZES_M = (0.008, 0.014, 0.024, 0.042, 0.072)
_POSES = 8
_ROUNDS = 3
_PULL = 0.02  # weight of the typical ratios, which decide where the measurements cannot separate the weights

_lock = threading.Lock()
_known: Constants | None = None


def _unlock() -> None:
    """In a forked process, which has no copy of the thread that holds the lock."""
    global _lock
    _lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_unlock)


def query_clock() -> Callable[[], float]:
    """The clock that times queries, seconds.

    It is the thread's processor time, which other programs do not lengthen, if its resolution is fine enough.
    """
    try:
        return time.thread_time if time.get_clock_info("thread_time").resolution <= 1e-6 else time.perf_counter
    except (AttributeError, ValueError):
        return time.perf_counter


def machine_constants() -> Constants:
    """Seconds for each step of a query: from this process, from the user's cache, or measured now."""
    global _known
    with _lock:
        if _known is None:
            _known = _read(cache_file())
        if _known is None:
            _known = measure_constants()
            _write(cache_file(), _known)
        return _known


def cache_file() -> Path:
    """The file with the constants of this machine and this version."""
    from importlib.metadata import version

    words = [version("feeler"), str(_LAYOUT), platform.node(), platform.machine(), cpu_name()]
    return _cache_folder() / f"constants-{hashlib.sha256(chr(0).join(words).encode()).hexdigest()[:16]}.json"


def measure_constants() -> Constants:
    """Measures the constants and ignores the cache."""
    mockup = _core.Mockup(*_clutter(60, 20), None, 1)
    rng = np.random.default_rng(5)
    poses = np.array([_pose(rng, 0.45) for _ in range(_POSES)])
    tools = [_core.Tool(*_tube(0.3, 0.02, around, along), None, 1) for around, along in ((8, 12), (24, 40))]
    scenes = [_core.Scene(mockup, size, "dense", 0.0, None, None, None, 2**40, None) for size in _SIZES_M]
    steps, seconds, clock = [], [], query_clock()
    for tool in tools:
        best = np.full((len(scenes), _POSES), np.inf)
        for round_ in range(_ROUNDS):
            for s, scene in enumerate(scenes):
                for p, pose in enumerate(poses):
                    start = clock()
                    hit = scene.collide(tool, pose, repeat_filter=True, box_filter=True)
                    best[s, p] = min(best[s, p], clock() - start)
                    if round_ == 0:
                        steps.append(counted(hit.stats, tool.triangle_count))
        seconds.append(best.ravel())
    return fit_constants(np.array(steps), np.concatenate(seconds))


def counted(stats: Mapping[str, int], tool_triangles: int) -> list[float]:
    """How often a query ran each step of `NAMES`, from its counters (storage dense or hashed)."""
    pairs = stats["entries_scanned"] - stats["repeats_skipped"]
    return [1.0, tool_triangles, stats["voxels_visited"], stats["entries_scanned"], pairs, stats["box_survivors"]]


def fit_constants(steps: npt.NDArray[np.float64], seconds: npt.NDArray[np.float64]) -> Constants:
    """The non-negative constants with the least sum of squared relative errors. steps: (n, 6); seconds: (n,).

    Steps that always occur together cannot be separated by time: a weak pull to the typical ratios decides there.
    """
    seconds = np.maximum(seconds, 1e-9)
    share = steps * np.array(TYPICAL) / seconds[:, None]  # of the time, at typical cost
    speed = float(np.median(1.0 / np.maximum(share.sum(axis=1), 1e-12)))
    pull = np.sqrt(_PULL * len(seconds)) * np.eye(len(TYPICAL))
    left, right = np.vstack([share, pull]), np.concatenate([np.ones(len(seconds)), speed * np.diag(pull)])
    normal, target = left.T @ left, left.T @ right
    factor = np.full(len(TYPICAL), speed)
    for _ in range(400):  # coordinate descent: a handful of unknowns, convex
        for i in range(len(factor)):
            factor[i] = max(0.0, factor[i] + (target[i] - normal[i] @ factor) / normal[i, i])
    query, triangle, voxel, entry, pair, test = (float(x) for x in factor * np.array(TYPICAL))
    return query, triangle, voxel, entry, pair, test


def _clutter(sheets: int, cells: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """Wavy sheets of triangles, at random places and angles in a cube with an edge of one metre."""
    rng = np.random.default_rng(3)
    u, v = np.meshgrid(*[np.linspace(-0.5, 0.5, cells + 1)] * 2, indexing="ij")
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    quads = np.stack([corner, corner + 1, corner + cells + 2, corner + cells + 1], axis=1)
    one = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices, faces = [], []
    for number in range(sheets):
        side = rng.uniform(0.15, 0.6)
        wave = 0.1 * np.sin(6.0 * u + rng.uniform(0, 6)) * np.cos(5.0 * v)
        pose = _pose(rng, 0.5)
        points = side * np.stack([u.ravel(), v.ravel() * rng.uniform(0.2, 1.0), wave.ravel()], axis=1)
        vertices.append(points @ pose[:3, :3].T + pose[:3, 3])
        faces.append(one + number * len(points))
    return np.concatenate(vertices), np.concatenate(faces).astype(np.uint32)


def _tube(
    length: float, radius: float, around: int, along: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
    rings = [
        np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(around, z)], axis=1)
        for z in np.linspace(-0.5 * length, 0.5 * length, along + 1)
    ]
    i, j = (a.ravel() for a in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
    a, b = i * around + j, i * around + (j + 1) % around
    faces = np.concatenate([np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)])
    return np.concatenate(rings), faces.astype(np.uint32)


def _pose(rng: np.random.Generator, reach: float) -> npt.NDArray[np.float64]:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] = -q[:, 0]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = q, rng.uniform(-reach, reach, 3)
    return pose


def _read(path: Path) -> Constants | None:
    """The constants of a file, if they are plausible."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))["seconds"]
        query, triangle, voxel, entry, pair, test = (float(values[name]) for name in NAMES)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    found = (query, triangle, voxel, entry, pair, test)
    makes_sense = all(0.0 <= value < 1.0 for value in found) and voxel + pair + test > 0.0
    return found if makes_sense else None


def _write(path: Path, constants: Constants) -> None:
    """Saves the constants if possible; a cache that cannot be written only costs a second each time."""
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"seconds": dict(zip(NAMES, constants, strict=True))}, indent=1)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.stem)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text + "\n")
            os.replace(name, path)
        except OSError:
            with contextlib.suppress(OSError):
                os.unlink(name)


def _cache_folder() -> Path:
    chosen = os.environ.get("FEELER_CACHE_DIR")
    if chosen:
        return Path(chosen)
    try:
        home = Path.home()
    except RuntimeError:  # no home
        home = Path(tempfile.gettempdir())
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "feeler"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "feeler"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "feeler"


def cpu_name() -> str:
    """The processor's name, if the system reports it."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8", errors="replace") as lines:
        for line in lines:
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()
