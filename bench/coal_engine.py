"""Coal (formerly hpp-fcl) as its documentation advises for speed, through its own Python binding.

The model is a `BVHModelOBBRSS`; the pair of objects is bound once in a `ComputeCollision`; all contacts are asked for,
none computed; no security margin; request and result objects are re-used, and emptied outside the clock.
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
    version = coal.__version__
    settings = (
        "BVHModelOBBRSS, ComputeCollision bound once per tool, num_max_contacts 2^31 - 1, enable_contact False, "
        "security_margin 0, request and result re-used, the pose's Transform3s made outside the clock"
    )

    def __init__(self) -> None:
        self._request = coal.CollisionRequest()
        self._request.num_max_contacts = ALL_CONTACTS
        self._request.enable_contact = False
        self._request.security_margin = 0.0
        self._result = coal.CollisionResult()
        self._world = coal.Transform3s.Identity()
        self._mockup: Any = None
        self._tool: Any = None
        self._compute: Any = None

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        self._compute = self._mockup = None
        vertices, faces = np.asfortranarray(mockup.vertices), mockup.faces.astype(np.int64)

        def build() -> None:
            self._mockup = None
            self._mockup = _model(vertices, faces)

        seconds, growth = build_times(build, runs)
        return Build(self.name, runs, seconds, None, int(self._mockup.memUsage(False)), growth)

    def prepare(self, tool: feeler.Tool) -> float:
        vertices, faces = np.asfortranarray(tool.vertices), tool.faces.astype(np.int64)
        start = time.perf_counter()
        self._tool = _model(vertices, faces)
        self._compute = coal.ComputeCollision(self._tool, self._mockup)
        return time.perf_counter() - start

    def aim(self, world_from_tool: Floats) -> Callable[[], Any]:
        self._result.clear()
        placed = coal.Transform3s(world_from_tool[:3, :3], world_from_tool[:3, 3])
        return functools.partial(self._compute, placed, self._world, self._request, self._result)

    def pairs(self, result: Any) -> Pairs:
        found = [(contact.b1, contact.b2) for contact in self._result.getContacts()]
        if not found:
            return np.empty((0, 2), dtype=np.uint32)
        return np.unique(np.array(found, dtype=np.uint32), axis=0)

    def stats(self, result: Any) -> dict[str, int]:
        return {}


def _model(vertices: Floats, faces: Any) -> Any:
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(faces)
    model.endModel()
    return model
