"""Coal (formerly hpp-fcl) as its documentation advises for speed, through its own Python binding.

The model is a `BVHModelOBBRSS`; the pair of objects is bound once in a `ComputeCollision`; it returns all contacts (or
one), without computing them; no security margin; requests and result are reused, and emptied outside the clock.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any

import coal
import numpy as np
from engines import Build, Floats, Pairs, build_times

import feeler

ALL_CONTACTS = 2**31 - 1


class CoalEngine:
    """BVHModelOBBRSS against BVHModelOBBRSS."""

    name = "coal"
    queries = ("collide", "is_colliding", "distance")
    version = coal.__version__
    settings = (
        "BVHModelOBBRSS, ComputeCollision bound once per tool, num_max_contacts 2^31 - 1 (is_colliding: 1), "
        "enable_contact False, security_margin 0, distance: ComputeDistance; "
        "requests and result re-used, Transform3s made outside the clock"
    )

    def __init__(self) -> None:
        self._requests = {"collide": _request(ALL_CONTACTS), "is_colliding": _request(1)}
        self._result = coal.CollisionResult()
        self._distance_request, self._distance_result = coal.DistanceRequest(), coal.DistanceResult()
        self._distance: Any = None
        self._world = coal.Transform3s.Identity()
        self._mockup: Any = None
        self._tool: Any = None
        self._compute: Any = None

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        self._compute = self._distance = self._mockup = None
        vertices, faces = np.asfortranarray(mockup.vertices), mockup.faces.astype(np.int64)

        def build() -> None:
            self._mockup = None
            self._mockup = model(vertices, faces)

        seconds, growth, peak = build_times(build, runs)
        # memUsage is a C int, which overflows at some four million triangles.
        size = int(self._mockup.memUsage(False)) % 2**32
        return Build(self.name, runs, seconds, None, size, growth, peak)

    def prepare(self, tool: feeler.Tool) -> float:
        vertices, faces = np.asfortranarray(tool.vertices), tool.faces.astype(np.int64)
        start = time.perf_counter()
        self._tool = model(vertices, faces)
        self._compute = coal.ComputeCollision(self._tool, self._mockup)
        self._distance = coal.ComputeDistance(self._tool, self._mockup)
        return time.perf_counter() - start

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        self._result.clear()
        placed = coal.Transform3s(world_from_tool[:3, :3], world_from_tool[:3, 3])
        if query == "distance":
            self._distance_result.clear()
            request, result = self._distance_request, self._distance_result
            return functools.partial(self._distance, placed, self._world, request, result)
        return functools.partial(self._compute, placed, self._world, self._requests[query], self._result)

    def pairs(self, result: Any) -> Pairs:
        found = [(contact.b1, contact.b2) for contact in self._result.getContacts()]
        if not found:
            return np.empty((0, 2), dtype=np.uint32)
        return np.unique(np.array(found, dtype=np.uint32), axis=0)

    def answer(self, result: Any) -> bool:
        return bool(result)

    def stats(self, result: Any) -> dict[str, int]:
        return {}

    def value(self, result: Any) -> float:
        return float(result)


def _request(contacts: int) -> Any:
    request = coal.CollisionRequest()
    request.num_max_contacts = contacts
    request.enable_contact = False
    request.security_margin = 0.0
    return request


def model(vertices: Floats, faces: Any) -> Any:
    """A `BVHModelOBBRSS` of the triangles."""
    made = coal.BVHModelOBBRSS()
    made.beginModel(len(faces), len(vertices))
    made.addVertices(np.asfortranarray(vertices))
    made.addTriangles(faces)
    made.endModel()
    return made
