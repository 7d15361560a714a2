"""parry3d, in its default f32; the Rust side is the crate in bench/parry.

Lengths are passed in millimetres: the tolerances of its GJK are absolute, and in metres it takes triangles a millimetre
apart for touching. The time is the same.
"""

from __future__ import annotations

import ctypes
import functools
import re
import time
from collections.abc import Callable
from typing import Any

import native
import numpy as np
from embree_engine import copied
from engines import Build, Floats, Pairs, build_times

import feeler

FOLDER = native.HERE / "parry"
POINTER, SIZE = ctypes.c_void_p, ctypes.c_size_t
FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "parry_new": (POINTER, (POINTER, SIZE, POINTER, SIZE)),
    "parry_free": (None, (POINTER,)),
    "parry_tool": (ctypes.c_int, (POINTER, POINTER, SIZE, POINTER, SIZE)),
    "parry_collide": (SIZE, (POINTER, POINTER)),
    "parry_is_colliding": (ctypes.c_int, (POINTER, POINTER)),
    "parry_cast": (ctypes.c_double, (POINTER, POINTER, POINTER, POINTER, POINTER)),
    "parry_pairs": (ctypes.POINTER(ctypes.c_uint32), (POINTER,)),
    "parry_bytes": (SIZE, (POINTER,)),
}
MILLIMETRES = 1000.0


class ParryEngine:
    """TriMesh against TriMesh."""

    name = "parry"
    queries = ("collide", "is_colliding", "cast")
    settings = (
        "parry3d, f32, millimetres; collide: both meshes' Bvh walked at once by leaf_pairs, then GJK on the two "
        "Triangles (its triangle-triangle test is not public); is_colliding: query::intersection_test of the two "
        "TriMeshes, tool first, which is the faster order; cast: its linear cast of "
        "shapes; release, lto fat, target-cpu=native, called through ctypes"
    )

    def __init__(self) -> None:
        lock = (FOLDER / "Cargo.lock").read_text(encoding="utf-8")
        found = re.search(r'name = "parry3d"\nversion = "([^"]+)"', lock)
        self.version = found[1] if found else "unknown"
        self._library = native.build_crate(FOLDER)
        native.declare(self._library, FUNCTIONS)
        self._engine: int | None = None

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        vertices, faces = native.mesh(mockup.vertices * MILLIMETRES, mockup.faces)

        def build() -> None:
            self._free()
            self._engine = self._library.parry_new(vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))

        self._free()
        seconds, growth, peak = build_times(build, runs)
        return Build(self.name, runs, seconds, None, int(self._library.parry_bytes(self._engine)), growth, peak)

    def _free(self) -> None:
        if self._engine:
            self._library.parry_free(self._engine)
        self._engine = None

    def prepare(self, tool: feeler.Tool) -> float:
        vertices, faces = native.mesh(tool.vertices * MILLIMETRES, tool.faces)
        start = time.perf_counter()
        self._library.parry_tool(self._engine, vertices.ctypes.data, len(vertices), faces.ctypes.data, len(faces))
        return time.perf_counter() - start

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        if query == "cast":
            start, end = world_from_tool
            return self.aim_cast(start, np.zeros(3), end[:3, 3] - start[:3, 3], np.zeros(3))
        self._pose = np.array(world_from_tool)  # kept alive until the next
        self._pose[:3, 3] *= MILLIMETRES
        call = self._library.parry_collide if query == "collide" else self._library.parry_is_colliding
        return functools.partial(call, self._engine, self._pose.ctypes.data)

    def aim_cast(self, world_from_tool: Floats, centre: Floats, way: Floats, turn: Floats) -> Callable[[], float]:
        """A cast, as `aim`: the point `centre` of the tool moves by `way` metres; it turns about it by `turn`."""
        self._pose = np.array(world_from_tool)
        self._pose[:3, 3] *= MILLIMETRES
        self._cast = [np.array(centre) * MILLIMETRES, np.array(way) * MILLIMETRES, np.array(turn, dtype=np.float64)]
        places = [array.ctypes.data for array in (self._pose, *self._cast)]
        call: Callable[[], float] = functools.partial(self._library.parry_cast, self._engine, *places)
        return call

    def pairs(self, result: Any) -> Pairs:
        return copied(self._library.parry_pairs(self._engine), result)

    def value(self, result: Any) -> float:
        return float(result)

    def answer(self, result: Any) -> bool:
        return bool(result)

    def stats(self, result: Any) -> dict[str, int]:
        return {}
