"""Embree's rtcCollide, configured as its documentation advises for speed; the C++ side is embree_engine.cpp.

The mock-up is a static scene of one user geometry. Build quality: MEDIUM and HIGH took the same times, for
there are no spatial splits of user geometries. The tool is a dynamic scene whose tree is refitted at each pose;
building it anew at LOW quality took two to seven times as long. The walk itself is rtcCollide's own.
"""

from __future__ import annotations

import ctypes
import functools
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import native
import numpy as np
from engines import Build, Floats, Pairs, build_times

import feeler

POINTER, SIZE = ctypes.c_void_p, ctypes.c_size_t
ONE_THREAD = b"threads=1,set_affinity=0"
MEDIUM = 1
FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "embree_new": (POINTER, (ctypes.c_char_p, ctypes.c_int, POINTER, SIZE, POINTER, SIZE)),
    "embree_free": (None, (POINTER,)),
    "embree_tool": (None, (POINTER, POINTER, SIZE, POINTER, SIZE)),
    "embree_collide": (SIZE, (POINTER, POINTER)),
    "embree_is_colliding": (ctypes.c_int, (POINTER, POINTER)),
    "embree_pairs": (ctypes.POINTER(ctypes.c_uint32), (POINTER,)),
    "embree_bytes": (ctypes.c_int64, (POINTER,)),
    "embree_version": (None, (ctypes.POINTER(ctypes.c_int),)),
}


class EmbreeEngine:
    """User geometries, one triangle a primitive; Möller's test in float in the callback."""

    name = "embree"
    settings = (
        "rtcCollide over RTC_GEOMETRY_TYPE_USER, one primitive per triangle, one thread; mock-up: static scene, "
        "RTC_BUILD_QUALITY_MEDIUM (HIGH takes the same times); tool: RTC_SCENE_FLAG_DYNAMIC, corners moved and the "
        "tree refitted at every pose, inside the clock; float Möller 1997 in the callback; "
        "is_colliding: rtcCollide cannot be stopped, so after the first contact each callback returns at once; "
        "g++ -O3 -march=native, called through ctypes"
    )

    def __init__(self) -> None:
        self._library = native.compile_cpp(Path(__file__).with_suffix(".cpp"), ["embree3"])
        native.declare(self._library, FUNCTIONS)
        three = (ctypes.c_int * 3)()
        self._library.embree_version(three)
        self.version = ".".join(map(str, three))
        self._engine: int | None = None
        self._tool: Any = None

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        vertices, faces = native.mesh(mockup.vertices, mockup.faces)
        where = (vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))

        def build(settings: bytes) -> None:
            self._free()
            self._engine = self._library.embree_new(settings, MEDIUM, *where)

        self._free()
        every = None
        if (os.cpu_count() or 1) > 1:
            every, _, _ = build_times(lambda: build(b"set_affinity=0"), runs)
            self._free()
        # Last, so that what stays is bound to one thread.
        one, growth, peak = build_times(lambda: build(ONE_THREAD), runs)
        return Build(self.name, runs, one, every, int(self._library.embree_bytes(self._engine)), growth, peak)

    def _free(self) -> None:
        if self._engine:
            self._library.embree_free(self._engine)
        self._engine = None

    def prepare(self, tool: feeler.Tool) -> float:
        vertices, faces = native.mesh(tool.vertices, tool.faces)
        start = time.perf_counter()
        self._library.embree_tool(self._engine, vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))
        return time.perf_counter() - start

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        self._pose = np.ascontiguousarray(world_from_tool)  # kept alive until the next
        call = self._library.embree_collide if query == "collide" else self._library.embree_is_colliding
        return functools.partial(call, self._engine, self._pose.ctypes.data)

    def pairs(self, result: Any) -> Pairs:
        return copied(self._library.embree_pairs(self._engine), result)

    def answer(self, result: Any) -> bool:
        return bool(result)

    def stats(self, result: Any) -> dict[str, int]:
        return {}


def copied(pointer: Any, count: int) -> Pairs:
    """Pairs that lie in a peer's memory, sorted and unique."""
    if not count:
        return np.empty((0, 2), dtype=np.uint32)
    return np.unique(np.ctypeslib.as_array(pointer, (count, 2)), axis=0)
