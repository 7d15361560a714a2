"""FCL through python-fcl: `BVHModel` (OBBRSS in that binding), all contacts, none computed.

The pose is set on the tool's CollisionObject outside the clock. The binding makes a Python object for each contact
inside the call, a cost that its users pay.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import fcl
import numpy as np
from engines import Build, Floats, Pairs, build_times

import feeler

ALL_CONTACTS = 2**31 - 1


class FclEngine:
    """BVHModel against BVHModel."""

    name = "fcl"
    queries = ("collide", "is_colliding", "distance")
    version = version("python-fcl")
    settings = (
        "python-fcl, BVHModel (OBBRSS), fcl.collide, enable_contact False, num_max_contacts 2^31 - 1 "
        "(is_colliding: 1), fcl.distance, "
        "CollisionObjects made once per tool, pose and result object set outside the clock"
    )

    def __init__(self) -> None:
        self._requests = {
            "collide": fcl.CollisionRequest(num_max_contacts=ALL_CONTACTS, enable_contact=False),
            "is_colliding": fcl.CollisionRequest(num_max_contacts=1, enable_contact=False),
        }
        self._result: Any = None
        self._mockup: Any = None
        self._tool: Any = None

    def build(self, mockup: feeler.Mockup, runs: int) -> Build:
        self._tool = self._mockup = None
        vertices, faces = np.array(mockup.vertices), mockup.faces.astype(np.int64)

        def build() -> None:
            self._mockup = None
            self._mockup = collision_object(vertices, faces)

        seconds, growth, peak = build_times(build, runs)
        return Build(self.name, runs, seconds, None, None, growth, peak)

    def prepare(self, tool: feeler.Tool) -> float:
        vertices, faces = np.array(tool.vertices), tool.faces.astype(np.int64)
        start = time.perf_counter()
        self._tool = collision_object(vertices, faces)
        return time.perf_counter() - start

    def aim(self, query: str, world_from_tool: Floats) -> Callable[[], Any]:
        self._tool.setTransform(fcl.Transform(world_from_tool[:3, :3], world_from_tool[:3, 3]))
        if query == "distance":
            request, result = fcl.DistanceRequest(), fcl.DistanceResult()
            return functools.partial(fcl.distance, self._tool, self._mockup, request, result)
        self._result = fcl.CollisionResult()
        return functools.partial(fcl.collide, self._tool, self._mockup, self._requests[query], self._result)

    def pairs(self, result: Any) -> Pairs:
        found = [(contact.b1, contact.b2) for contact in self._result.contacts]
        if not found:
            return np.empty((0, 2), dtype=np.uint32)
        return np.unique(np.array(found, dtype=np.uint32), axis=0)

    def answer(self, result: Any) -> bool:
        return bool(result)

    def stats(self, result: Any) -> dict[str, int]:
        return {}

    def value(self, result: Any) -> float:
        return float(result)


def collision_object(vertices: Floats, faces: Any) -> Any:
    """A mesh in place."""
    return fcl.CollisionObject(bvh_model(vertices, faces), fcl.Transform())


def bvh_model(vertices: Floats, faces: Any) -> Any:
    """A mesh and its tree."""
    model = fcl.BVHModel()
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model
