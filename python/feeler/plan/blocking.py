"""Which parts block which along which straight motions: the arcs of a directional blocking graph, found when asked for.

Wilson and Latombe, "Geometric reasoning about mechanical assembly", Artificial Intelligence 71, 1994. The directions of
a part come from its contacts, from the axes of fasteners and from the world. A part that a cast meets blocks it. Parts
that are in contact with it at the start may slide and part, by the rule of `feeler.removal`, which is asked for the
pair alone.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.parts import Part
from feeler.plan.fasteners import NAMED, Fastener, find_fasteners
from feeler.plan.question import TARGET, Clock, Direction, Question
from feeler.plan.sequence import Exit, undominated
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

TOUCH_M = 1e-6
"""Parts nearer than this at the start are in contact, as for `removal`."""
NEAR_SHARE = 1e-3
"""Surfaces within this share of the size of a part suggest directions. More finds the walls of looser fits."""
OPPOSED = 1e-3
"""A touching plane blocks directions that go against it by more than this cosine."""
MOST_NORMALS, MOST_DIRECTIONS = 8, 18
"""Contact normals, and directions, of a part. More finds motions that only crowded parts have, and takes longer."""
MOST_BLOCKERS = 24
"""A direction that more parts block is left out: there are shorter ways, or none."""
SAME_COSINE = 1.0 - 1e-9

SHANK_PLAY = 1.12
"""A fastener joins the parts that its shank, this much wider, meets. Holes are up to a tenth wider than their bolts."""
UNDER_NUT = 0.15
"""How far below a nut, in diameters, is the part that it bears on."""
_SIDES = 16


class BlockingGraph:
    """The exits of each part of a scene, and of the wanted ones (`TARGET`), looked for when they are asked for."""

    def __init__(self, question: Question, clock: Clock) -> None:
        self.question, self.clock = question, clock
        self.joints = Joints(question.scene)
        allow = question.options["allow"]
        given = list(allow) if isinstance(allow, (list, tuple)) else [allow]
        names = [each for each in given if isinstance(each, (str, Part)) and each != "start"]
        self.allowed = frozenset(question.scene.mockup.parts.select(names).tolist() if names else [])
        self.has_overlap = any(isinstance(each, (int, float)) and each > 0 for each in given)
        self._exits: dict[int, list[Exit]] = {}

    def is_known(self, node: int) -> bool:
        """Whether the exits of a part were looked for."""
        return node in self._exits

    def exits(self, node: int) -> list[Exit]:
        """What blocks a part along each of its directions; those along which no kept part does."""
        if node not in self._exits:
            self._exits[node] = undominated(self._found(node)) if node not in self.question.kept else []
        return self._exits[node]

    def _found(self, node: int) -> list[Exit]:
        self.clock.tell(f"what blocks {self.question.names([node])}")
        mover = _Mover(self, node)
        holding = self.holding(node)
        found: list[Exit] = []
        for direction in mover.directions():
            if not self.clock.goes_on():
                break
            least = holding.union(map(self.question.node_of, mover.opposed(direction)))
            if any(one.blockers | one.fasteners < least for one in found):
                continue
            blockers = mover.blockers(direction)
            if blockers is not None:
                found.append(Exit((direction,), frozenset(map(self.question.node_of, blockers)), holding))
                if not blockers:
                    break
        return found

    def holding(self, node: int) -> frozenset[int]:
        """The fasteners that join a part to others, and may go."""
        fasteners = self.joints.of(self.question.parts_of([node]))
        return frozenset(map(self.question.node_of, fasteners)) - self.question.kept - {node}

    def learn(self, node: int, exit_: Exit) -> None:
        """Adds an exit that was found by other means."""
        self._exits[node] = undominated([*self.exits(node), exit_])

    def forget(self, node: int, motion: Hashable) -> list[Exit]:
        """Leaves out a motion that turned out to be blocked: what was thought to block it."""
        known = [Exit((motion,), one.blockers, one.fasteners) for one in self.exits(node) if motion in one.motions]
        left = [replace(one, motions=tuple(m for m in one.motions if m != motion)) for one in self.exits(node)]
        self._exits[node] = [one for one in left if one.motions]
        return known

    def reached(self) -> list[int]:
        """The wanted parts, those that block them, those that block these, and so on, as far as known."""
        found = [TARGET]
        for node in found:
            for one in self._exits.get(node, []):
                found += sorted((one.blockers | one.fasteners) - set(found) - self.question.kept)
        return found

    def most_gone(self) -> frozenset[int]:
        """All that is known to come out, alone or together along one motion, with the wanted parts in place."""
        gone: set[int] = set()
        motions = {motion for exits in self._exits.values() for one in exits for motion in one.motions}
        while True:
            before = len(gone)
            for motion in motions:
                needs = {
                    node: one.blockers
                    for node, exits in self._exits.items()
                    for one in exits
                    if motion in one.motions and node != TARGET and node not in gone
                }
                while blocked := [node for node, blockers in needs.items() if blockers - gone - needs.keys()]:
                    for node in blocked:
                        del needs[node]
                gone |= needs.keys()
            if len(gone) == before:
                return frozenset(gone)


class _Mover:
    """A part, or the wanted ones with what grips them, among all other parts of the scene."""

    def __init__(self, graph: BlockingGraph, node: int) -> None:
        self.graph, self.question, self.node = graph, graph.question, node
        self.parts = self.question.parts_of([node])
        self.tool = self.question.moving([node])
        self.rest = self.question.scene.without(list(self.parts))
        self.size = float(np.linalg.norm(self.tool.bounds[1] - self.tool.bounds[0]))
        touching = self.rest.clearance(self.tool, np.eye(4), TOUCH_M)
        self.contacts = self.rest.contacts(self.tool, np.eye(4), NEAR_SHARE * self.size)
        is_touching = np.abs(self.contacts.gaps) <= TOUCH_M
        flush = set(self.contacts.parts[is_touching].tolist())
        deep = set(self.contacts.parts[self.contacts.gaps < -TOUCH_M].tolist())
        met = {int(part) for part in touching.parts}
        # Casts tell of parts that touch; of those that are deeper only the rule of `removal` does.
        self.seats = sorted((met - flush | deep) - graph.allowed)

    def directions(self) -> Iterator[Direction]:
        """Those given; contact normals, the axes of fasteners and of the world, and what is along two contacts; both
        ways. Those that the fewest touching parts oppose come first."""
        normals: list[Floats] = []
        for normal in self.contacts.normals:
            if all(abs(float(normal @ other)) < SAME_COSINE for other in normals):
                normals.append(normal)
        normals = normals[:MOST_NORMALS]
        axes = [fastener.axis for fastener in self.graph.joints.among(self.parts)]
        across = [np.cross(one, other) for one, other in combinations(normals, 2)]
        asked = self.question.grip["directions"] if self.node == TARGET else None
        given = [] if asked is None else list(np.atleast_2d(np.asarray(asked, dtype=np.float64)))
        lines = [*axes, *np.eye(3), *(line for line in across if np.linalg.norm(line) > 0.1), *normals]
        all_: list[Direction] = []
        for line in [*given, *(sign * line for line in lines for sign in (1.0, -1.0))]:
            unit = line / np.linalg.norm(line)
            unit[np.abs(unit) < 1e-9] = 0.0
            if all(float(unit @ np.array(other)) < SAME_COSINE for other in all_):
                all_.append(tuple((np.round(unit, 9) + 0.0).tolist()))
        chosen = all_[:MOST_DIRECTIONS]
        return iter(sorted(chosen, key=lambda direction: len(self.opposed(direction))))

    def opposed(self, direction: Direction) -> set[int]:
        """Touching parts with a contact plane against a direction. What is deeper has no such plane to go by."""
        against = self.contacts.normals @ np.array(direction) < -OPPOSED
        touching = np.abs(self.contacts.gaps) <= TOUCH_M
        return set(self.contacts.parts[against & touching].tolist()) - self.graph.allowed

    def blockers(self, direction: Direction) -> frozenset[int] | None:
        """All parts that block it along a direction; `None` where a kept part does, or too many."""
        kept, allowed = self.question.kept, self.graph.allowed
        found = self.opposed(direction)
        if found & kept:
            return None
        for seat in self.seats:
            if seat not in found and not self._leaves(seat, direction):
                found.add(seat)
                if seat in kept:
                    return None
        far = np.eye(4)
        far[:3, 3] = self._way_out(direction) * np.array(direction)
        passed = {*found, *self.seats, *allowed}
        while len(found) <= MOST_BLOCKERS:
            ignore = [("*", sorted(passed))] if passed else None
            hit = self.rest.cast(self.tool, np.eye(4), far, touching="free", ignore=ignore)
            if hit is None:
                return frozenset(found)
            passed.add(hit.part)
            if not self.graph.has_overlap or not self._leaves(hit.part, direction):
                if hit.part in kept:
                    return None
                found.add(hit.part)
        return None

    def _leaves(self, part: int, direction: Direction) -> bool:
        return self.question.leaves(self.node, part, direction, self.graph.clock)

    def _way_out(self, direction: Direction) -> float:
        """How far along a direction the box of the tool leaves the box of all else, metres."""
        boxes = self.question.scene.mockup.part_bounds.reshape(-1, 2, 3)[self.rest.part_mask]
        lower, upper = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        low, high = self.tool.bounds
        along = np.array(direction)
        with np.errstate(divide="ignore", invalid="ignore"):
            leave = np.where(along > 0, (upper - low) / along, np.where(along < 0, (lower - high) / along, np.inf))
        return max(0.0, float(leave.min())) + TOUCH_M


class Joints:
    """The fasteners of a scene and the parts that each joins, looked at where they are asked for."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)
        self._seen: set[int] = set()
        self._rows: dict[int, Fastener] = {}
        self._joined: dict[int, frozenset[int]] = {}

    def among(self, parts: Iterable[int]) -> list[Fastener]:
        """Those parts that are fasteners."""
        new = sorted(set(parts) - self._seen)
        if new:
            self._seen.update(new)
            rows = find_fasteners(self.scene, parts=new)
            self._rows.update((row.part, row) for row in rows if row.confidence >= NAMED)
        return [self._rows[part] for part in parts if part in self._rows]

    def of(self, parts: tuple[int, ...]) -> set[int]:
        """The fasteners that join one of these parts; none where these are fasteners themselves."""
        if self.among(parts):
            return set()
        bounds = self._bounds
        lower, upper = bounds[list(parts), 0].min(axis=0), bounds[list(parts), 1].max(axis=0)
        reach = 0.1 * (upper - lower).max()
        near = ((bounds[:, 0] <= upper + reach) & (bounds[:, 1] >= lower - reach)).all(axis=1) & self.scene.part_mask
        others = [int(part) for part in np.flatnonzero(near) if part not in parts]
        return {row.part for row in self.among(others) if self.joined(row) & set(parts)}

    def joined(self, row: Fastener) -> frozenset[int]:
        """The parts that a fastener joins: those around its shank, and under its nut."""
        known = self._joined.get(row.part)
        if known is None:
            rest = self.scene.without([row.part])
            shank = _shank(row, self._bounds[row.part])
            met = {int(part) for part in rest.collide(shank, row.frame).parts}
            met |= {int(part) for part in rest.containment(shank, row.frame).containing}
            known = self._joined[row.part] = frozenset(met - {each.part for each in self.among(sorted(met))})
        return known


def _shank(row: Fastener, bounds: Floats) -> Tool:
    """What meets the parts that a fastener joins, as a prism in its frame."""
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
