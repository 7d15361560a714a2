"""FCL through python-fcl: a `BVHModel` for each part, all of them in FCL's own broad phase.

A colliding pair is a contact if none of its triangles' contacts is deep, else a clash as deep as the deepest of them:
FCL knows only surfaces, and how deep two triangles overlap. Pairs come from a `DynamicAABBTreeCollisionManager`, whose
callback runs `fcl.collide` or `fcl.distance` in Python.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import fcl
from fcl_engine import ALL_CONTACTS, bvh_model, collision_object

import feeler

from .checkers import CLEARANCE_M, Answer, Pairs, Whole, least, ordered, part_meshes


class FclChecker:
    """`fcl.collide`, with contacts, and `fcl.distance`."""

    name = "python-fcl"
    version = version("python-fcl")

    def pair(self, mockup: feeler.Mockup) -> Answer:
        """Of a mock-up of two parts."""
        one, other = (collision_object(*mesh) for mesh in part_meshes(mockup))
        depth = _depth(one, other, fcl.CollisionResult())
        if depth is not None:
            return Answer("clash", depth) if depth > 0.0 else Answer("contact", 0.0)
        gap = fcl.distance(one, other, fcl.DistanceRequest(), fcl.DistanceResult())
        return Answer("clearance", gap) if gap <= CLEARANCE_M else Answer("none")

    def whole(self, mockup: feeler.Mockup, repeats: int) -> Whole:
        """Of all pairs of parts. Arrays are ready before the clock starts."""
        meshes = list(part_meshes(mockup))
        indexed, broad = least(lambda: _Broad(meshes), repeats)
        seconds, pairs = {"index": indexed}, {}
        for query, work in (("verdicts", broad.meeting), ("clearance", broad.near), ("depths", broad.deep)):
            seconds[query], pairs[query] = least(work, repeats)
        return Whole(seconds, pairs)


class _Broad:
    """All parts in FCL's broad phase."""

    def __init__(self, meshes: list[tuple[Any, Any]]) -> None:
        self._models = [bvh_model(*mesh) for mesh in meshes]
        self._objects = [fcl.CollisionObject(model, fcl.Transform()) for model in self._models]
        self._manager = fcl.DynamicAABBTreeCollisionManager()
        self._manager.registerObjects(self._objects)
        self._manager.setup()
        # The callback gets wrappers of its own around the objects; results name the models that were made here.
        self._parts = {id(model): part for part, model in enumerate(self._models)}

    def _pair(self, result: Any) -> tuple[int, int]:
        return ordered(self._parts[id(result.o1)], self._parts[id(result.o2)])

    def meeting(self) -> Pairs:
        """Pairs that meet."""
        found: Pairs = set()
        request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

        def ask(one: Any, other: Any, _: Any) -> bool:
            result = fcl.CollisionResult()
            if fcl.collide(one, other, request, result):
                found.add(self._pair(result.contacts[0]))
            return False

        self._manager.collide(None, ask)
        return found

    def near(self) -> Pairs:
        """Pairs within `CLEARANCE_M`; the broad phase leaves out boxes that are farther apart."""
        found: Pairs = set()
        request = fcl.DistanceRequest()

        def ask(one: Any, other: Any, _: Any) -> tuple[bool, float]:
            result = fcl.DistanceResult()
            if fcl.distance(one, other, request, result) <= CLEARANCE_M:
                found.add(self._pair(result))
            return False, CLEARANCE_M

        self._manager.distance(None, ask)
        return found

    def deep(self) -> Pairs:
        """Pairs whose contacts are deep."""
        found: Pairs = set()

        def ask(one: Any, other: Any, _: Any) -> bool:
            result = fcl.CollisionResult()
            if (_depth(one, other, result) or 0.0) > 0.0:
                found.add(self._pair(result.contacts[0]))
            return False

        self._manager.collide(None, ask)
        return found


def _depth(one: Any, other: Any, result: Any) -> float | None:
    """The deepest of all contacts of triangles, metres; None without any."""
    request = fcl.CollisionRequest(num_max_contacts=ALL_CONTACTS, enable_contact=True)
    if not fcl.collide(one, other, request, result):
        return None
    return max(float(contact.penetration_depth) for contact in result.contacts)
