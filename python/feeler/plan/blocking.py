"""The parts that block straight motions of a part: the arcs of a directional blocking graph, computed on demand.

Wilson and Latombe, "Geometric reasoning about mechanical assembly", Artificial Intelligence 71, 1994. The directions of
a part come from its contacts, from its own faces, from the axes of fasteners and from the faces of the scene. Parts hit
by casts block it; so do parts that it intersects at the start and would enter deeper. `removal` later checks each step
by its own rule.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from feeler._core import Contacts
from feeler.depths import deepest_within
from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.parts import PartNumber
from feeler.plan.fasteners import NAMED, Fastener, find_fasteners
from feeler.plan.frames import (
    SAME_PLANE,
    across_axis,
    distinct,
    face_normals,
    is_face_normal,
    part_axes,
    round_axis,
    scene_axes,
)
from feeler.plan.question import TARGET, Clock, Direction, Question
from feeler.plan.sequence import Exit, undominated
from feeler.progress import Progress
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

TOUCH_M = 1e-6
"""Parts nearer than this at the start are in contact, as in `removal`."""
NEAR_SHARE = 1e-3
"""Surfaces within this share of the size of a part suggest directions. A larger value finds the walls of looser
fits."""
STOPPED_SHARE = 1e-2
"""How far a part is cast to see whether a touching one stops it, in its sizes."""
OPPOSED = 1e-3
"""A touching plane blocks directions whose cosine against its normal exceeds this."""
ALONG = 1e-8
"""A direction whose cosine against a contact's normal is at most this is along its faces: directions have nine digits,
so a long way leads into them by rounding."""
MOST_NORMALS, FIRST_NORMALS, MOST_DIRECTIONS = 8, 3, 26
"""Contact normals, those that come before the directions along two, and directions, per part. A larger value finds more
motions of crowded parts, and takes longer."""
ROUNDING_M = 1e-9
"""Edges that are no farther apart may cross by rounding."""
BESIDE_SHARE, MOST_BESIDE = 0.1, 6
"""A round part has no sides. It is tried towards the parts that are nearer than this share of its size, at most so
many."""
MOST_BLOCKERS = 24
"""A direction with more blockers is dropped: there are shorter sequences, or none."""
FEW_BLOCKERS = 4
"""A direction is dropped if it has this many blockers more than the best one, and twice as many."""
DEEPER_M, DEEPER_SHARE = 1e-5, 0.07
"""Parts that intersect at the start may get this much deeper on the way, as in `removal`."""
DEPTH_SHARES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.3, 1.6, 2.0, 3.0)
"""Where that depth is measured, in sizes of the moving part. `removal` later finds a step that goes too deep
between."""
DEPTHS_AT_ONCE = 4
"""Parts whose depth is measured between two looks at the clock: each may take a second."""
DEPTHS_SHARE, LEAST_DEPTHS_S = 0.1, 0.25
"""The most time for these, as a share of all and in seconds: of faces that lie on each other and are cut by rounding it
may take for ever."""
SAME_COSINE = 1.0 - 1e-8
"""Directions closer than this are one: 0.1 mrad."""
SAME_LABEL = 1e-6
"""Directions of two parts that are this close, radians, are one, by which they can leave together."""

SHANK_PLAY = 1.12
"""A fastener joins the parts that its shank, this much wider, collides with. Holes are up to a tenth wider than their
bolts."""
UNDER_NUT = 0.15
"""Depth below a nut, in diameters, at which the part that it bears on is sought."""
ROOM_STEPS = 32
"""Casts go to the sides of a box of which a part of this many is a step: it stays where outer parts move a little."""
_SIDES = 16


@dataclass(frozen=True)
class FirstExits:
    """The exits of a part up to the first direction that is free."""

    exits: tuple[Exit, ...]
    done: int
    """Number of directions that were looked at."""
    fewest: int
    is_all: bool
    """Whether there are no more directions."""


class BlockingGraph:
    """The exits of each part of a scene, and of the wanted ones (`TARGET`), computed on demand.

    `computed_at_once`: computes the first exits of several parts on the workers of an executor.
    """

    def __init__(
        self,
        question: Question,
        clock: Clock,
        computed_at_once: Callable[[Sequence[int]], Mapping[int, FirstExits]] | None = None,
    ) -> None:
        self.question, self.clock = question, clock
        self.joints = Joints(question.scene, lambda share, stage: self.clock.look(share, stage))
        self.allowed = frozenset(question.options["ignore"])
        self.overlap = question.options["overlap"]
        self._computed_at_once = computed_at_once
        self._ahead: dict[int, FirstExits] = {}
        self._exits: dict[int, list[Exit]] = {}
        self._sources: dict[int, _Source] = {}
        self._holding: dict[int, frozenset[int]] = {}
        self._labels: list[Direction] = []

    @cached_property
    def axes(self) -> list[Floats]:
        """Three axes of the scene."""
        return scene_axes(self.question.scene)

    @cached_property
    def meshes(self) -> PartMeshes:
        """The triangles of each part."""
        return PartMeshes(self.question.scene.mockup)

    def _named(self, one: Exit) -> Exit:
        """An exit whose motions have the names of the same directions of other parts: these differ by rounding."""
        return replace(one, motions=tuple(self._label(motion) for motion in one.motions))

    def _label(self, motion: Any) -> Hashable:
        """The first direction that was known within `SAME_LABEL` of one."""
        if not (isinstance(motion, tuple) and len(motion) == 3 and isinstance(motion[0], float)):
            return cast(Hashable, motion)
        if self._labels:
            apart = np.abs(np.array(self._labels) - np.array(motion)).max(axis=1)
            if apart.min() <= SAME_LABEL:
                return self._labels[int(np.argmin(apart))]
        self._labels.append(motion)
        return motion

    def expect(self, nodes: Sequence[int]) -> None:
        """Computes the exits of several parts at once. Where there is an executor alone: they may not be needed. No
        answer depends on it: the parts stay unknown until they are asked for."""
        new = [node for node in nodes if not {node} & (self._exits.keys() | self._ahead.keys() | self.question.kept)]
        if self._computed_at_once is not None and len(new) > 1:
            self._ahead.update(self._computed_at_once(new))

    def first_exits(self, node: int) -> FirstExits:
        """The exits of a part up to the first free direction. The graph forgets them: it computes them for another."""
        try:
            exits, source = tuple(self.exits(node)), self._sources[node]
            return FirstExits(exits, source.done, source.fewest, source.is_all)
        finally:
            self._exits.pop(node, None)
            self._sources.pop(node, None)

    def is_known(self, node: int) -> bool:
        """Whether the exits of a part were computed."""
        return node in self._exits

    def exits(self, node: int) -> list[Exit]:
        """The blockers of a part along each of its directions, except directions blocked by a kept part. If a direction
        is free, the others wait until that one is forgotten."""
        if node not in self._exits:
            self._exits[node] = []
            if node not in self.question.kept:
                self.clock.tell(f"what blocks {self.question.names([node])}")
                first = self._ahead.pop(node, FirstExits((), 0, MOST_BLOCKERS, False))
                self._exits[node] = [self._named(one) for one in first.exits]
                self._sources[node] = _Source(self, node, first)
        source = self._sources.get(node)
        while source is not None and all(one.blockers for one in self._exits[node]):
            more = source.next(self._exits[node])
            if more is None:
                break
            self._exits[node] = undominated([*self._exits[node], self._named(more)])
        return self._exits[node]

    def blockers_within(self, node: int, direction: Direction, far: float) -> frozenset[int] | None:
        """The parts that block one of the directions of a part up to a distance, metres; None if a kept one does, or if
        its exits were not computed here. Flush parts that it only crosses by rounding are none."""
        source = self._sources.get(node)
        return None if source is None else source.within(direction, far)

    def directions(self, node: int) -> list[Direction]:
        """The directions of a part, if its exits were computed here."""
        source = self._sources.get(node)
        return [] if source is None else source.directions

    def holding(self, node: int) -> frozenset[int]:
        """The removable fasteners that join a part to others."""
        if node not in self._holding:
            fasteners = self.joints.of(self.question.parts_of([node]))
            self._holding[node] = frozenset(map(self.question.node_of, fasteners)) - self.question.kept - {node}
        return self._holding[node]

    def fastener_axes(self, parts: tuple[int, ...]) -> list[Floats]:
        """The axes of the fasteners among parts."""
        return [fastener.axis for fastener in self.joints.among(parts)]

    def obstacles(self, node: int) -> frozenset[int]:
        """What a part met along its directions up to now, before something that is kept."""
        source = self._sources.get(node)
        return frozenset() if source is None else source.obstacles

    def learn(self, node: int, exit_: Exit) -> None:
        """Adds an exit found by other means."""
        self._exits[node] = undominated([*self.exits(node), exit_])

    def forget(self, node: int, motion: Hashable) -> list[Exit]:
        """Drops a motion that turned out to be blocked; returns the blockers assumed so far."""
        known = [Exit((motion,), one.blockers, one.fasteners) for one in self.exits(node) if motion in one.motions]
        left = [replace(one, motions=tuple(m for m in one.motions if m != motion)) for one in self.exits(node)]
        self._exits[node] = [one for one in left if one.motions]
        return known

    def widened(self, node: int, most: int) -> list[Exit]:
        """The exits of a part that has none, with directions of more blockers too."""
        source = self._sources.get(node)
        if source is not None and not self._exits[node]:
            source.widen(most)
        return self.exits(node)

    def touching(self, node: int) -> frozenset[int]:
        """The parts that touch a part against the direction in which the fewest do, as far as its exits were looked
        for."""
        source = self._sources.get(node)
        against = [] if source is None else source.opposing
        return frozenset(map(self.question.node_of, min(against, key=len, default=())))

    def known(self, node: int) -> list[Exit]:
        """The exits of a part that were computed so far."""
        return self._exits.get(node, [])

    def asked(self) -> list[int]:
        """The parts of which exits are known."""
        return sorted(self._exits)

    def known_blockers(self, node: int) -> dict[int, int]:
        """The blockers of a part that are known so far, and along how many directions each stands in its way."""
        found: dict[int, int] = {}
        for one in self._exits.get(node, []):
            for other in one.blockers:
                found[other] = found.get(other, 0) + len(one.motions)
        return found

    def leaving(self, node: int) -> frozenset[int]:
        """The nodes that are out with one: it is one part, or some that leave together."""
        return frozenset([node])

    def reached(self) -> list[int]:
        """The wanted parts, those that block them, those that block these, and so on, as far as known."""
        found = [TARGET]
        for node in found:
            for one in self._exits.get(node, []):
                found += sorted((one.blockers | one.fasteners) - set(found) - self.question.kept)
        return found

    def most_gone(self) -> frozenset[int]:
        """All parts known to come out, alone or together along one motion, while the wanted parts stay."""
        gone: set[int] = set()
        motions = {motion for exits in self._exits.values() for one in exits for motion in one.motions}
        while True:
            before = len(gone)
            for motion in motions:
                needs = {
                    node: one.blockers
                    for node, exits in self._exits.items()
                    for one in exits
                    if motion in one.motions and TARGET not in self.leaving(node) and not self.leaving(node) <= gone
                }
                while True:
                    there = gone.union(*map(self.leaving, needs))
                    blocked = [node for node, blockers in needs.items() if blockers - there]
                    for node in blocked:
                        del needs[node]
                    if not blocked:
                        break
                gone = there
            if len(gone) == before:
                return frozenset(gone)


class _Source:
    """The exits of one part, direction by direction."""

    def __init__(self, graph: BlockingGraph, node: int, first: FirstExits) -> None:
        self.graph, self.node = graph, node
        self.done, self.fewest, self.is_all = first.done, first.fewest, first.is_all
        self._most = MOST_BLOCKERS
        self._mover: Mover | None = None
        self.directions: list[Direction] = []

    @property
    def opposing(self) -> list[set[int]]:
        """The parts that touch it against each direction, if there are any."""
        return [] if self._mover is None else [each for each in self._mover.opposing.values() if each]

    @property
    def obstacles(self) -> frozenset[int]:
        """See `BlockingGraph.obstacles`."""
        question = self.graph.question
        parts = set() if self._mover is None else self._mover.met - question.kept
        return frozenset(map(question.node_of, parts)) - question.kept - {self.node}

    def within(self, direction: Direction, far: float) -> frozenset[int] | None:
        """See `BlockingGraph.blockers_within`."""
        return None if self._mover is None else self._mover.blockers(direction, self._most, far)

    def widen(self, most: int) -> None:
        """Begins anew, with directions of up to `most` blockers."""
        self._most = self.fewest = most
        self.done, self.is_all = 0, False

    def next(self, known: Sequence[Exit]) -> Exit | None:
        """Another exit, unless all directions are blocked for good, dominated by known exits, or the time is up."""
        if self.is_all:
            return None
        graph, node_of = self.graph, self.graph.question.node_of
        holding = graph.holding(self.node)
        if self._mover is None:
            self._mover = Mover(graph, self.node, frozenset(graph.question.parts_of(holding)))
            self.directions = list(self._mover.opposing)
        while self.done < len(self.directions):
            if not graph.clock.goes_on():
                return None
            graph.clock.look()
            direction = self.directions[self.done]
            self.done += 1
            least = set(map(node_of, self._mover.opposed(direction)))
            if any(one.blockers < least for one in known):
                continue
            blockers = self._mover.blockers(direction, min(self._most, 2 * self.fewest + FEW_BLOCKERS))
            if blockers is not None:
                self.fewest = min(self.fewest, len(blockers))
                return Exit((direction,), frozenset(map(node_of, blockers)), holding)
        self.is_all = True
        return None


class _UnknownError(Exception):
    """An answer that is not remembered."""


class Mover:
    """A part, or the wanted ones with their tool, among all other parts of the scene."""

    def __init__(self, graph: BlockingGraph, node: int, before: frozenset[int], shape: Tool | None = None) -> None:
        """before: parts that leave before it, or may touch it. shape: instead of its own."""
        self.graph, self.question, self.node = graph, graph.question, node
        self.passed = graph.allowed | before
        self.parts = self.question.parts_of([node])
        self._shape = shape
        asked = self.question.grip["directions"] if node == TARGET else None
        self._given: list[Floats] = [] if asked is None else list(np.atleast_2d(np.asarray(asked, dtype=np.float64)))
        self._facts = [graph.overlap, [PartNumber(part) for part in sorted(self.passed)]]
        lines = [each.tolist() for each in (*self._given, *graph.axes)]
        self._corners = box_of_parts(self.question.scene)
        self._at_start: dict[int, float] = {}
        rows, *sets = self._recalled("directions", [lines], self._looked)
        self.opposing = self._ordered({tuple(direction): set(parts) for direction, parts in rows})
        """The directions to try, in their order, and the touching parts against each; none of another shape."""
        self.met: set[int] = set()
        """The parts that were met along any direction up to now."""
        self.seats, self.flush, self.doubtful = sets[0], set(sets[1]), set(sets[2])

    def _recalled(
        self, kind: str, more: list[Any], ask: Callable[[], Any], is_enough: Callable[[Any], bool] = lambda _: True
    ) -> Any:
        """A question about it, among parts that it may touch."""
        return self._remembered(kind, [*more, *self._facts], ask, is_enough)

    def _remembered(
        self, kind: str, facts: list[Any], ask: Callable[[], Any], is_enough: Callable[[Any], bool] = lambda _: True
    ) -> Any:
        """A question about it. With a gripping tool, or of another shape, none is remembered."""
        if not self._is_plain:
            return ask()
        return self.question.scene._recalled(kind, self.parts, facts, ask, is_enough)

    @property
    def _is_plain(self) -> bool:
        """Whether its shape is that of its parts."""
        return self._shape is None and not (self.node == TARGET and self.question.grip["tool"] is not None)

    @cached_property
    def bounds(self) -> Floats:
        """`(2, 3)`: its box."""
        if not self._is_plain:
            return np.array(self.tool.bounds)
        boxes = self.question.scene.mockup.part_bounds.reshape(-1, 2, 3)[list(self.parts)]
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    @cached_property
    def tool(self) -> Tool:
        """The moving parts."""
        return self.question.moving([self.node]) if self._shape is None else self._shape

    @cached_property
    def rest(self) -> Scene:
        """The scene without them."""
        return self.question.scene.without(list(self.parts))

    @cached_property
    def size(self) -> float:
        """The diagonal of their box, metres."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    @cached_property
    def contacts(self) -> Contacts:
        """Its contacts, at its place, with surfaces within `NEAR_SHARE` of its size."""
        return self.rest.contacts(self.tool, np.eye(4), NEAR_SHARE * self.size)

    def _looked(self) -> list[Any]:
        """The directions with the parts against each, and the parts that it touches or intersects at the start."""
        touching = self.rest.clearance(self.tool, np.eye(4), TOUCH_M)
        is_touching = np.abs(self.contacts.gaps) <= TOUCH_M
        flush = set(self.contacts.parts[is_touching].tolist())
        deep = set(self.contacts.parts[self.contacts.gaps < -TOUCH_M].tolist())
        met = {int(part) for part in touching.parts}
        # Casts find touching parts; measured depths find parts that intersect it.
        seats = (met - flush | deep) - self.passed
        directions, doubtful = self._directions() if self._shape is None else ([], set[int]())
        rows = [[list(direction), _numbers(self._opposed(direction, doubtful))] for direction in directions]
        return [rows, _numbers(seats), _numbers(flush), _numbers(doubtful)]

    def _directions(self) -> tuple[list[Direction], set[int]]:
        """The given directions; then the axes of the scene, of fasteners and of its own faces, contact normals, and the
        directions along two contacts, both ways. An assembly in another pose has the same ones, turned. And flush parts
        that may not hold it."""
        normals: list[Floats] = []
        for normal in self.contacts.normals:
            if all(abs(float(normal @ other)) < SAME_COSINE for other in normals):
                normals.append(normal)
        normals = normals[:MOST_NORMALS]
        own = self._own_axes()
        axes = self.graph.fastener_axes(self.parts)
        across = [np.cross(one, other) for one, other in combinations(normals, 2)]
        lines = [
            *self.graph.axes,
            *axes,
            *own,
            *normals[:FIRST_NORMALS],
            *(line for line in across if np.linalg.norm(line) > 0.1),
        ]
        lines += normals[FIRST_NORMALS:]
        all_: list[Direction] = []
        for line in [*self._given, *(sign * line for line in lines for sign in (1.0, -1.0))]:
            unit = line / np.linalg.norm(line)
            unit[np.abs(unit) < 1e-9] = 0.0
            if all(float(unit @ np.array(other)) < SAME_COSINE for other in all_):
                all_.append(tuple((np.round(unit, 9) + 0.0).tolist()))
        chosen = all_[:MOST_DIRECTIONS]
        # Normals of flush faces that cross by rounding can be anything: a part that they hold on all sides may not.
        rounding = set(
            self.contacts.parts[(np.abs(self.contacts.gaps) <= TOUCH_M) & (self.contacts.gaps < 0.0)].tolist()
        )
        for direction in chosen:
            rounding &= self._against(direction).keys()
        return chosen, rounding

    def _ordered(self, opposing: dict[Direction, set[int]]) -> dict[Direction, set[int]]:
        """Directions with the touching parts against each: those with the fewest first, of these the ways that are the
        shortest out."""
        if not opposing:
            return {}
        # To a micrometre: in another pose ways that are as long differ by rounding.
        ways = np.round(_out_of(*self._corners, self.bounds, np.array(list(opposing))), 6).tolist()
        far = dict(zip(opposing, ways, strict=True))
        return {each: opposing[each] for each in sorted(opposing, key=lambda each: (len(opposing[each]), far[each]))}

    def _own_axes(self) -> list[Floats]:
        """The axes of its own faces. A round part has one; it also has lines to what stands around it, such as the
        bolts of its flange, between which it may leave, and two that are fixed to its own corners."""
        corners = np.concatenate([self.graph.meshes.corners(part) for part in self.parts])
        found = part_axes(corners)
        axis = round_axis(found)
        if axis is None:
            return found
        middle, lines = corners.mean(axis=(0, 1)), across_axis(axis, corners[:, 0])
        near = self.rest.clearance(self.tool, np.eye(4), BESIDE_SHARE * self.size)
        to_parts: list[tuple[int, int, Floats]] = []
        for part in {int(part) for part in near.parts}:
            line = self.graph.meshes.corners(part).mean(axis=(0, 1)) - middle
            line -= float(line @ axis) * axis
            far = float(np.linalg.norm(line))
            if far > BESIDE_SHARE * self.size:
                to_parts.append((round(far * 1e6), part, line / far))
        to_parts.sort(key=lambda each: each[:2])
        return distinct([*found, *lines, *(line for _, _, line in to_parts[:MOST_BESIDE])])

    def opposed(self, direction: Direction) -> set[int]:
        """Touching parts with a contact plane against a direction."""
        return self.opposing[direction] if direction in self.opposing else self._opposed(direction, self.doubtful)

    def _opposed(self, direction: Direction, doubtful: set[int]) -> set[int]:
        """See `opposed`. Faces may only cross by rounding: depth tells whether it enters, of doubtful ones later."""
        found = self._against(direction)
        unsure = {part for part, is_sure in found.items() if not is_sure} - doubtful
        return {*found} - unsure | self._deeper(direction, unsure)

    def _against(self, direction: Direction) -> dict[int, bool]:
        """Touching parts with a contact plane against a direction, and whether that is sure: faces that lie on each
        other are. The rims of holes that are one behind the other touch, too, with the normals of their walls: an exact
        cast decides, unless it hits at the start. Deeper parts have no reliable plane."""
        against = (self.contacts.normals @ np.array(direction) < -OPPOSED) & self._is_reliable
        rows: dict[int, list[int]] = {}
        for row in np.flatnonzero(against).tolist():
            rows.setdefault(int(self.contacts.parts[row]), []).append(row)
        found: dict[int, bool] = {}
        end = self._moved(direction, STOPPED_SHARE * self.size)
        for part in rows.keys() - self.passed:
            if any(self._is_flat(row) for row in rows[part]):
                found[part] = True
            elif (hit := self.rest.only([part]).cast(self.tool, np.eye(4), end, touching="free")) is not None:
                found[part] = not _is_at_start(hit.pose)
        return found

    def _is_flat(self, row: int) -> bool:
        """Whether a contact is one of faces that look at each other along its normal."""
        contacts, normal = self.contacts, self.contacts.normals[row]
        ways = []
        for of, offsets, mesh in (
            (contacts.mockup_triangles, contacts.mockup_offsets, self.rest.mockup),
            (contacts.tool_triangles, contacts.tool_offsets, self.tool),
        ):
            along = face_normals(mesh.vertices[mesh.faces[of[offsets[row] : offsets[row + 1]]]]) @ normal
            ways.append({float(np.sign(each)) for each in along[np.abs(along) >= SAME_PLANE]})
        return any(-way in ways[1] for way in ways[0])

    @cached_property
    def _is_reliable(self) -> npt.NDArray[np.bool_]:
        """`(k,)`, of each contact: whether it touches, and its normal is sure. Edges that cross by rounding alone, as
        those of a pin do in a hole of its diameter, have any normal; casts say whether their parts are in the way."""
        contacts = self.contacts
        sure = np.abs(contacts.gaps) <= TOUCH_M
        sides = (
            (contacts.mockup_triangles, contacts.mockup_offsets, self.rest.mockup),
            (contacts.tool_triangles, contacts.tool_offsets, self.tool),
        )
        for row in np.flatnonzero(sure & (contacts.gaps <= ROUNDING_M)):
            sure[row] = any(
                is_face_normal(contacts.normals[row], mesh.vertices[mesh.faces[of[offsets[row] : offsets[row + 1]]]])
                for of, offsets, mesh in sides
            )
        return sure

    def blockers(self, direction: Direction, most: int, far: float = math.inf) -> frozenset[int] | None:
        """All other parts that block a direction, up to a distance, metres; `None` if a kept part does, if there are
        more than `most`, or if the time is up."""
        sets = (self.opposed(direction), self.seats, self.flush, self.doubtful)
        far = min(far, self._far(direction))
        facts = [list(direction), far, *map(_numbers, sets)]
        told = self._recalled(
            "along", facts, lambda: self._met(direction, most, far), lambda told: self._found(told, most)[1]
        )
        self.met.update(told[0], told[1])
        return self._found(told, most)[0]

    def _found(self, told: Sequence[Any], most: int) -> tuple[frozenset[int] | None, bool]:
        """What `blockers` says of what was met, and whether that is enough to say it."""
        kept = self.question.kept
        first, hits, is_all = told
        found = set(first)
        for part in hits:
            if found & kept or len(found) > most:
                return None, True
            found.add(part)
        if found & kept or len(found) > most:
            return None, True
        return (frozenset(found), True) if is_all else (None, False)

    def _met(self, direction: Direction, most: int, far: float) -> list[Any]:
        """The parts against a direction at the start, those that it hits on its way, and whether these are all."""
        kept = self.question.kept
        opposed = self.opposed(direction)
        found = opposed - self.doubtful
        if not found & kept and len(found) <= most:
            found |= self._deeper(direction, {*self.seats, *(opposed & self.doubtful)} - found, most - len(found))
        first, hits = _numbers(found), list[PartNumber]()
        passed = {*found, *self.seats, *self.passed, *self.doubtful}
        pose, end = np.eye(4), self._moved(direction, far)
        while not found & kept and len(found) <= most and self.graph.clock.goes_on():
            self.graph.clock.look()
            ignore = [("*", sorted(passed))] if passed else None
            # The next cast starts where the last one hit.
            hit = self.rest.cast(self.tool, pose, end, touching="free", ignore=ignore)
            if hit is None:
                return [first, hits, True]
            passed.add(hit.part)
            pose = hit.pose
            is_rounding = hit.part in self.flush and (_is_at_start(pose) or self._slides(direction, hit.part))
            if not (self.graph.overlap or is_rounding) or self._deeper(direction, {hit.part}):
                found.add(hit.part)
                hits.append(PartNumber(hit.part))
        return [first, hits, False]

    def _slides(self, direction: Direction, part: int) -> bool:
        """Whether it moves along a face of a flush part: it may come into it by rounding anywhere on its way."""
        normals = self.contacts.normals[(self.contacts.parts == part) & (np.abs(self.contacts.gaps) <= TOUCH_M)]
        return bool((np.abs(normals @ np.array(direction)) <= ALONG).any())

    def _deeper(self, direction: Direction, parts: set[int], most: int = sys.maxsize) -> set[int]:
        """The parts that it enters deeper along a direction than at the start, by samples; not all of them if the time
        is up, no others once these are more than `most`. Each depends on the two alone, so it is remembered by itself;
        those that are not known are measured a few at a time."""
        found: dict[int, bool] = {}
        for part in sorted(parts):
            with suppress(_UnknownError):
                found[part] = self._entered(direction, part, None)
        waiting = sorted(parts - found.keys())
        while waiting and sum(found.values()) <= most and self.graph.clock.goes_on():
            few, waiting = waiting[:DEPTHS_AT_ONCE], waiting[DEPTHS_AT_ONCE:]
            for part, is_deeper in self._sampled(direction, few).items():
                found[part] = self._entered(direction, part, is_deeper)
        return {part for part, is_deeper in found.items() if is_deeper}

    def _entered(self, direction: Direction, part: int, measured: bool | None) -> bool:
        """Whether it enters a part deeper. Raises `_UnknownError` if that is neither known nor measured."""
        facts = [PartNumber(part), list(direction), self._far(direction), self.graph.overlap]

        def ask() -> bool:
            if measured is None:
                raise _UnknownError
            self.rest._depends_on([part])
            return measured

        return bool(self._remembered("deeper", facts, ask))

    def _sampled(self, direction: Direction, parts: list[int]) -> dict[int, bool]:
        """Whether it enters parts deeper; of those alone that were decided before the time is up."""
        goes_on, way = self.graph.clock.goes_on, self._far(direction)
        new = self._depths([part for part in parts if part not in self._at_start], np.eye(4))
        if new is None or not goes_on():
            return {}
        self._at_start.update({part: new.get(part, 0.0) for part in parts if part not in self._at_start})
        limits = {part: DEEPER_M + (1.0 + DEEPER_SHARE) * self._at_start[part] for part in parts}
        found: dict[int, bool] = {}
        left = parts
        for share in DEPTH_SHARES:
            if not left or share * self.size > way:
                break
            depths = self._depths(left, self._moved(direction, share * self.size))
            if depths is None:
                return found
            found |= {part: True for part in left if depths.get(part, 0.0) > max(limits[part], self.graph.overlap)}
            left = [part for part in left if part not in found]
            if not goes_on():
                return found
        return found | dict.fromkeys(left, False)

    def _depths(self, parts: list[int], pose: Floats) -> dict[int, float] | None:
        """The depth in each of a few parts that it is in; None if that takes longer than its share of the time: the
        parts do not count then, until `removal` meets them."""
        if not parts:
            return {}
        clock = self.graph.clock
        clock.look()
        most = max(LEAST_DEPTHS_S, DEPTHS_SHARE * clock.seconds)
        return deepest_within(self.rest.only(parts), self.tool, pose, min(clock.left, most))

    def _moved(self, direction: Direction, by: float) -> Floats:
        pose = np.eye(4)
        pose[:3, 3] = by * np.array(direction)
        return pose

    def _far(self, direction: Direction) -> float:
        """How far it is cast: beyond all parts."""
        return float(_out_of(*room_of(*self._corners), self.bounds, np.array(direction)))


def way_out(scene: Scene, tool: Tool, direction: Direction) -> float:
    """The distance along a direction at which the box of a tool leaves the box of all parts of a scene, metres."""
    return float(_out_of(*box_of_parts(scene), np.array(tool.bounds), np.array(direction)))


def _is_at_start(pose: Floats) -> bool:
    """Whether a hit there may come from flush faces that cross by rounding, as they do in no special pose: depth tells
    whether a part enters another."""
    return float(np.abs(pose[:3, 3]).max()) <= TOUCH_M


def _out_of(lower: Floats, upper: Floats, bounds: Floats, along: Floats) -> Floats:
    """How far a box goes along directions `(..., 3)` until it is out of another: `(...)`, metres."""
    low, high = bounds
    with np.errstate(divide="ignore", invalid="ignore"):
        leave = np.where(along > 0, (upper - low) / along, np.where(along < 0, (lower - high) / along, np.inf))
    return np.asarray(np.fmax(0.0, leave.min(axis=-1)) + TOUCH_M)


def box_of_parts(scene: Scene) -> tuple[Floats, Floats]:
    """The corners of the box of all parts of a scene."""
    boxes = scene.mockup.part_bounds.reshape(-1, 2, 3)[scene.part_mask]
    return boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)


def room_of(lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """The corners of a box around a box, on steps of a power of two, metres."""
    size = float((upper - lower).max())
    if not (math.isfinite(size) and size > 0.0):
        return lower, upper
    step = 2.0 ** math.ceil(math.log2(size / ROOM_STEPS))
    return np.floor(lower / step) * step, np.ceil(upper / step) * step


def _numbers(parts: Iterable[int]) -> list[PartNumber]:
    return [PartNumber(part) for part in sorted(parts)]


class Joints:
    """The fasteners of a scene and the parts that each joins, computed on demand."""

    def __init__(self, scene: Scene, look: Progress) -> None:
        """look: called often; what it raises ends the work."""
        self.scene, self.look = scene, look
        self._bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)
        self._seen: set[int] = set()
        self._rows: dict[int, Fastener] = {}
        self._joined: dict[int, frozenset[int]] = {}

    def among(self, parts: Iterable[int]) -> list[Fastener]:
        """The parts that are fasteners."""
        new = sorted(set(parts) - self._seen)
        if new:
            rows = find_fasteners(self.scene, new, self.look)
            self._seen.update(new)
            self._rows.update((row.part, row) for row in rows if row.confidence >= NAMED)
        return [self._rows[part] for part in parts if part in self._rows]

    def of(self, parts: tuple[int, ...]) -> set[int]:
        """The fasteners that join one of these parts; none if these are fasteners themselves. Studs stay: their nuts
        are undone instead."""
        if self.among(parts):
            return set()
        bounds = self._bounds
        lower, upper = bounds[list(parts), 0].min(axis=0), bounds[list(parts), 1].max(axis=0)
        reach = 0.1 * (upper - lower).max()
        near = ((bounds[:, 0] <= upper + reach) & (bounds[:, 1] >= lower - reach)).all(axis=1) & self.scene.part_mask
        others = [int(part) for part in np.flatnonzero(near) if part not in parts]
        holding = (row for row in self.among(others) if row.kind != "stud")
        return {row.part for row in holding if self.joined(row) & set(parts)}

    def joined(self, row: Fastener) -> frozenset[int]:
        """The parts that a fastener joins: those around its shank, and under its nut."""
        known = self._joined.get(row.part)
        if known is None:
            self.look(0.0, "")
            rest = self.scene.without([row.part])
            shank = _shank(row, self._bounds[row.part])
            met = {int(part) for part in rest.collide(shank, row.frame).parts}
            met |= {int(part) for part in rest.containment(shank, row.frame).containing}
            known = self._joined[row.part] = frozenset(met - {each.part for each in self.among(sorted(met))})
        return known


def _shank(row: Fastener, bounds: Floats) -> Tool:
    """A prism around the shank, in the fastener's frame: the parts that the fastener joins collide with it."""
    size = row.size if np.isfinite(row.size) else float(np.median(bounds[1] - bounds[0]))
    length = row.length if np.isfinite(row.length) else float(np.linalg.norm(bounds[1] - bounds[0]))
    if row.kind == "nut":
        radius = 0.5 * (row.across_flats if np.isfinite(row.across_flats) else 1.6 * size)
        top, bottom = -0.5 * length, -length - UNDER_NUT * size
    else:
        head = row.head_height if np.isfinite(row.head_height) else 0.0
        radius, top, bottom = 0.5 * SHANK_PLAY * size, -head, -head - length
    turn = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    corners = np.vstack(
        [
            np.column_stack([ring, np.full(_SIDES, top)]),
            np.column_stack([ring, np.full(_SIDES, bottom)]),
            [[0.0, 0.0, top], [0.0, 0.0, bottom]],
        ]
    )
    faces = []
    for i in range(_SIDES):
        j = (i + 1) % _SIDES
        faces += [
            [i, i + _SIDES, j],
            [j, i + _SIDES, j + _SIDES],
            [i, j, 2 * _SIDES],
            [j + _SIDES, i + _SIDES, 2 * _SIDES + 1],
        ]
    return Tool(corners, faces, name="shank")
