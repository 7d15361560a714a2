"""The links as tools and scenes, and how far points of a link move with each joint."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler._core import World
from feeler.ignored import IgnoredPairs
from feeler.mechanism.coupling import JointCoupling
from feeler.mechanism.joint import Joint, JointKind
from feeler.mechanism.links import Links
from feeler.mechanism.seating import TOUCH_M, Seated, Turn, seated
from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_ALWAYS = 1e-12  # metres: rounding of levers
_SAME_AXIS, _SAME_AXIS_M = 1e-9, 1e-9  # axes that differ by less are one


class Bodies:
    """The links of a mechanism as bodies that are asked."""

    def __init__(
        self,
        mockup: Mockup,
        links: Links,
        couplings: Sequence[JointCoupling] = (),
        scene: Scene | None = None,
        loops: Sequence[tuple[Joint, tuple[int, int]]] = (),
        ignore: npt.NDArray[np.uint32] | None = None,
    ) -> None:
        """ignore: `(k, 2)` pairs of parts that are skipped in all questions."""
        self.mockup, self.links = mockup, links
        self._given = scene
        self.skipped = set() if ignore is None else {(int(a), int(b)) for row in ignore for a, b in (row, row[::-1])}
        of_name = {name: link.number for link in links.links for name in link.joint.names}
        self._joined = {frozenset((link.number, link.above)) for link in links.links}
        self._joined |= {frozenset((of_name[each.joint], of_name[each.of])) for each in couplings}
        self._joined |= {frozenset(ends) for _, ends in loops}
        self._loops = {frozenset(ends): joint for joint, ends in loops}
        self._tools: dict[int, Tool] = {}
        self._scenes: dict[int, Scene] = {}
        self._touching: dict[tuple[int, int], list[tuple[int, int]]] = {}
        self._seats: dict[tuple[int, int], tuple[Seated, ...]] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Seats are found again: they know how to move on, which does not travel."""
        return {**vars(self), "_seats": {}}

    @cached_property
    def scene(self) -> Scene:
        """All parts where they are modelled."""
        return Scene(self.mockup) if self._given is None else self._given

    def parts(self, link: int) -> tuple[int, ...]:
        """The parts of a link; -1: of the frame."""
        return self.links.frame if link < 0 else self.links.links[link].parts

    def tool(self, link: int) -> Tool:
        """A link as a tool, where it is modelled."""
        if link not in self._tools:
            self._tools[link] = Tool.of_parts(self.mockup, self.parts(link))
        return self._tools[link]

    def alone(self, link: int) -> Scene:
        """A link as a scene, where it is modelled."""
        if link not in self._scenes:
            self._scenes[link] = self.scene.only(list(self.parts(link)))
        return self._scenes[link]

    def is_solid(self, link: int) -> bool:
        """Whether it has triangles that can be asked."""
        bounds = self.mockup.part_bounds.reshape(-1, 2, 3)[list(self.parts(link))]
        return bool(len(bounds)) and bool((bounds[:, 0] <= bounds[:, 1]).any())

    def is_joined(self, one: int, other: int) -> bool:
        """Whether a joint or a coupling joins two links."""
        return frozenset((one, other)) in self._joined

    def turn_between(self, one: int, other: int) -> Turn | None:
        """The axis about which two links turn against each other, by a joint of the tree or of a loop, or by several
        about one axis, such as two shafts in each other that a third part carries."""
        joints = self._joints_between(one, other)
        if not joints or any(joint.kind in (JointKind.PRISMATIC, JointKind.FIXED) for joint in joints):
            return None
        axis, point = np.array(joints[0].axis), np.array(joints[0].point)
        for joint in joints[1:]:
            off = np.cross(np.array(joint.point) - point, axis)
            if np.linalg.norm(np.cross(joint.axis, axis)) > _SAME_AXIS or np.linalg.norm(off) > _SAME_AXIS_M:
                return None
        return Turn(axis, point, all(joint.kind is JointKind.REVOLUTE for joint in joints))

    def slide_between(self, one: int, other: int) -> Floats | None:
        """The axis along which two links slide against each other, without any turn."""
        joints = self._joints_between(one, other)
        if not joints or any(joint.kind is not JointKind.PRISMATIC for joint in joints):
            return None
        axis = np.array(joints[0].axis)
        is_one = all(np.linalg.norm(np.cross(joint.axis, axis)) <= _SAME_AXIS for joint in joints[1:])
        return axis if is_one else None

    def _joints_between(self, one: int, other: int) -> list[Joint]:
        """The joints that move two links against each other: of a loop, or of the tree without those that are fixed."""
        loop = self._loops.get(frozenset((one, other)))
        if loop is not None:
            return [loop]
        up, down = self.links.between(one, other)
        joints = [self.links.links[number].joint for number in (*up, *down)]
        return [joint for joint in joints if joint.kind is not JointKind.FIXED]

    def seats(self, one: int, other: int) -> tuple[Seated, ...]:
        """The pairs of parts of two links that are seated in each other where they are modelled.

        Of links that no joint, coupling or loop joins those that only touch, or turn in each other about one axis: all
        else that crosses there is exact.
        """
        key = (one, other)
        if key not in self._seats:
            is_asked = self.is_solid(one) and self.is_solid(other)
            is_joined = self.is_joined(one, other)
            if is_asked and not is_joined:
                is_asked = math.isfinite(self.alone(other).distance(self.tool(one), np.eye(4), TOUCH_M).value)
            found = seated(self, one, other) if is_asked else ()
            self._seats[key] = tuple(
                seat
                for seat in found
                if (is_joined or seat.kind in ("touching", "round")) and (seat.part, seat.other) not in self.skipped
            )
        return self._seats[key]

    def touching(self, one: int, other: int) -> list[tuple[int, int]]:
        """The pairs of parts of two links, a number of the tool and a part, that are in contact where they are
        modelled."""
        key = (one, other)
        if key not in self._touching:
            tool, around = self.tool(one), self.alone(other)
            near = around.clearance(tool, np.eye(4), TOUCH_M)
            found = set(zip(near.tool_parts.tolist(), near.parts.tolist(), strict=True))
            found |= {(int(a), int(b)) for a, b in World(around, []).seated_parts(tool, np.eye(4))}
            own = self.parts(one)
            self._touching[key] = sorted(pair for pair in found if (own[pair[0]], pair[1]) not in self.skipped)
        return self._touching[key]

    def ignored(self, one: int, other: int, more: Iterable[tuple[int, int]] = ()) -> IgnoredPairs | None:
        """The seats of two links, and more pairs of a part of the tool and one of the mock-up, as queries skip them."""
        return self.without(one, sorted({*((seat.number, seat.other) for seat in self.seats(one, other)), *more}))

    def without(self, one: int, pairs: Sequence[tuple[int, int]]) -> IgnoredPairs | None:
        """Pairs of a part of the tool of a link and one of the mock-up, and those that are ignored, as queries skip
        them; None for none."""
        if self.skipped:
            number = {part: place for place, part in enumerate(self.parts(one))}
            skipped = {(number[part], other) for part, other in self.skipped if part in number}
            pairs = sorted(skipped.union(pairs))
        if not pairs:
            return None
        return IgnoredPairs(self.tool(one), self.mockup, np.array(pairs, dtype=np.int64))

    def mesh(self, part: int) -> tuple[Floats, Ints]:
        """The vertices and faces of a part, without faces that are none."""
        return self._meshes.mesh(part)

    @cached_property
    def _meshes(self) -> PartMeshes:
        return PartMeshes(self.mockup)

    def levers(self, one: int, other: int, reach: dict[str, float]) -> dict[str, float]:
        """By name of a number: the most by which points of one link move against the other, for a unit of it.

        reach: the largest slide of each sliding number, metres.
        """
        up, down = self.links.between(one, other)
        found: dict[str, float] = {}
        for chain, link in ((up, one), (down, other)):
            corners = self._corners(link)
            for place, number in enumerate(chain):
                joint = self.links.links[number].joint
                far = self._far(joint, [self.links.links[n].joint for n in reversed(chain[:place])], corners, reach)
                for name, turns in zip(joint.names, joint.turns, strict=True):
                    lever = far if turns else 1.0
                    if joint.kind is JointKind.SCREW:
                        lever = math.hypot(far, joint.pitch / math.tau)
                    found[name] = found.get(name, 0.0) + lever * (1.0 + 1e-12) + _ALWAYS
        return found

    def _corners(self, link: int) -> Floats:
        """The points of a link, or the corners of its box where those are many."""
        bounds = self.mockup.part_bounds.reshape(-1, 2, 3)[list(self.parts(link))]
        kept = bounds[(bounds[:, 0] <= bounds[:, 1]).all(axis=1)]
        if link >= 0 and len(kept):
            return np.asarray(self.tool(link).vertices, dtype=np.float64)
        picks = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1)
        corners: Floats = kept[:, picks, [[0], [1], [2]]].transpose(0, 2, 1).reshape(-1, 3)
        return corners

    @staticmethod
    def _far(joint: Joint, between: list[Joint], points: Floats, reach: dict[str, float]) -> float:
        """The largest distance of a link's points from a joint's axis, at any position. between: the joints from
        there to the link."""
        if not len(points):
            return 0.0
        between = [each for each in between if each.kind is not JointKind.FIXED]
        if not between:
            return float(np.linalg.norm(np.cross(points - np.array(joint.point), np.array(joint.axis)), axis=1).max())
        total, here = 0.0, np.array(joint.point)
        for each in between:
            there = np.array(each.point)
            total += float(np.linalg.norm(there - here))
            here = there
            names = zip(each.names, each.turns, strict=True)
            total += sum(reach.get(name, math.inf) for name, turns in names if not turns)
            if each.kind is JointKind.SCREW:
                total += abs(each.pitch) / math.tau * reach.get(each.name, math.inf)
        return total + float(np.linalg.norm(points - here, axis=1).max())
