"""The ways of the parts of a step: checked, and searched where no straight motion takes a part out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.parts import PartNumber
from feeler.plan.blocking import box_of_parts, way_out
from feeler.plan.frames import part_axes
from feeler.plan.question import Clock, Direction
from feeler.plan.removal import Allowed, Removal, not_tried, way_from
from feeler.plan.sequence import Exit
from feeler.poses import rotation
from feeler.scene import Scene
from feeler.tasks.actions import Actions
from feeler.tasks.ahead import WayAsked
from feeler.tasks.elastic import RingWay
from feeler.tasks.problem import Unit
from feeler.tasks.rings import Slip
from feeler.tasks.two_legs import two_legs

Floats = npt.NDArray[np.float64]

STRAIGHT_ROUNDS = 2
"""Rounds of the search for the way of a part whose direction is known."""
BENT_ROUNDS = 8
"""Rounds for a part that no straight motion takes out, and before it is said that others have to go for one."""
SHORTER_M = 1e-3
"""Ways that are shorter by less are not."""
PLAY_SHARE = 0.02
"""How far a part can be moved at least before it is searched for a bent way, in sizes of it."""
TURN_RAD = 0.03
"""Or how far it can be turned."""


@dataclass(frozen=True, eq=False)  # it holds arrays
class Led:
    """The way of the parts of a step."""

    is_found: bool
    poses: Floats
    """`(k, 4, 4)`, as of `Removal`."""
    said: str
    worst: int | None = None
    """The part that stopped most attempts."""

    @classmethod
    def of(cls, found: Removal) -> Led:
        """That of an answer."""
        said = "; ".join(str(leg) for leg in found.legs) or "it is clear of all other parts where it is"
        return cls(found.is_found, found.poses, said, next((each.part for each in found.blocked_by), None))

    def plain(self) -> list[Any]:
        """As scenes remember it."""
        worst = None if self.worst is None else PartNumber(self.worst)
        return [self.is_found, self.poses.tolist(), self.said, worst]

    @classmethod
    def read(cls, data: Sequence[Any]) -> Led:
        """What `plain` gave."""
        return cls(data[0], np.array(data[1]).reshape(-1, 4, 4), data[2], data[3])


@dataclass(frozen=True)
class Bent:
    """The name of a motion that a search found."""

    number: int


@dataclass(eq=False)
class Searched:
    """The ways that searches found, and where they found none."""

    bent: dict[Bent, tuple[frozenset[int], Led]] = field(default_factory=dict)
    """With the items that have to be out."""
    tried: set[tuple[int, frozenset[int]]] = field(default_factory=set)
    """Items, and the parts that were gone."""
    tried_short: set[tuple[int, frozenset[int]]] = field(default_factory=set)
    """The same, of searches of two straight legs alone."""
    led: dict[WayAsked, Led] = field(default_factory=dict)
    """The ways of parts from where they are modelled."""
    shortest: dict[tuple[Unit, tuple[int, ...], frozenset[int]], Any] = field(default_factory=dict)
    """Of a step, what leaves in it and what is gone, the direction in which it is out first."""


class Leading:
    """Leads parts out, and remembers the ways that searches found."""

    def __init__(self, actions: Actions, clock: Clock, is_shortest: bool, searched: Searched) -> None:
        """is_shortest: whether the shortest of the straight ways is taken, not one that waits for the fewest parts.
        searched: what is known, and becomes known."""
        self.is_shortest = is_shortest
        self.actions, self.clock, self.question = actions, clock, actions.question
        self._mockup = self.question.scene.mockup
        self._searched = searched

    def way(self, unit: Unit, parts: tuple[int, ...], out: frozenset[int]) -> Led:
        """The way of a step while items are out."""
        gone = self.actions.gone(out)
        self.clock.tell(f"checking the way of {self._mockup.part_names[parts[0]]}")
        if self._is_last(parts, gone):
            # Parts in each other are no farther apart if all that is left is moved.
            is_apart = len(unit.items) == 1
            return Led(is_apart, np.eye(4)[None], "nothing else is left around it" if is_apart else "")
        motion: Any = unit.motion
        if isinstance(motion, Slip):
            return self._of_ring(self.actions.rings.way(motion), parts, gone, STRAIGHT_ROUNDS, True)
        if isinstance(motion, Bent):
            before, led = self._searched.bent[motion]
            if before <= out:
                return led
        return self._led(self._asked(unit, parts, gone))

    def asked(self, unit: Unit, parts: tuple[int, ...], out: frozenset[int]) -> WayAsked | None:
        """What will be asked for the way of a step; None for what is known, and for rings."""
        gone = self.actions.gone(out)
        motion = unit.motion
        if not parts or self._is_last(parts, gone) or isinstance(motion, (Slip, Bent)):
            return None
        return self._asked(unit, parts, gone)

    def _asked(self, unit: Unit, parts: tuple[int, ...], gone: frozenset[int]) -> WayAsked:
        motion: Any = unit.motion
        is_straight = isinstance(motion, tuple) and len(motion) == 3
        rounds = STRAIGHT_ROUNDS if is_straight else BENT_ROUNDS
        direction = self._direction(unit, parts, gone) if is_straight else None
        return WayAsked(parts, gone, direction, rounds, int(self.question.options["seed"]))

    def _direction(self, unit: Unit, parts: tuple[int, ...], gone: frozenset[int]) -> Any:
        if not self.is_shortest:
            return unit.motion
        key = (unit, parts, gone)
        if key not in self._searched.shortest:
            self._searched.shortest[key] = self._shortest(unit, parts, gone)
        return self._searched.shortest[key]

    def _shortest(self, unit: Unit, parts: tuple[int, ...], gone: frozenset[int]) -> Any:
        """The direction in which parts are out first: their motion, or one that is free now that others are gone. Not
        for several people: they need not wait for those."""
        question = self.question
        rest = question.scene.without([*parts, *gone])
        tool = Tool.of_parts(self._mockup, list(parts))
        motion: Any = unit.motion
        node = self.actions.node(unit.items[0], unit.bodies[0])
        most = way_out(question.scene, tool, motion) - SHORTER_M
        found = {each: way_out(question.scene, tool, each) for each in self.actions.graph.directions(node)}
        shorter = sorted((each for each, far in found.items() if far < most), key=lambda each: round(found[each], 6))
        for each in shorter:
            self.clock.look()
            far = np.eye(4)
            far[:3, 3] = found[each] * np.array(each)
            if rest.cast(tool, np.eye(4), far, touching="free") is None:
                return each
        return motion

    def search(self, item: int, riding: frozenset[int], out: frozenset[int], is_short: bool = False) -> bool:
        """Whether a way of a part with what rides on it is found while items are out: of two straight legs, and if the
        search is not short by pushes and random trees too. The graph then knows it, with those of the items that it
        collides with. It is searched once for each set."""
        actions, question = self.actions, self.question
        gone = actions.gone(out)
        node = actions.node(item, riding)
        parts = tuple(part for part in question.parts_of([node]) if part not in gone)
        key = (node, frozenset(gone))
        tried = self._searched.tried_short if is_short else self._searched.tried
        if key in tried or key in self._searched.tried or not parts or self._is_last(parts, gone):
            return False
        self.clock.tell(f"searching a way of {self._mockup.part_names[parts[0]]}")
        if item not in actions.rings:
            rounds = 0 if is_short else BENT_ROUNDS
            asked = WayAsked(parts, gone, None, rounds, int(self.question.options["seed"]))
            led, needed = self._led(asked, actions.graph.directions(node)), frozenset[int]()
        elif is_short:
            return False
        else:
            led, needed = Led(False, np.eye(4)[None], ""), frozenset[int]()
            for way in actions.rings.ways(item):
                if way.blockers <= out:
                    led, needed = self._of_ring(way, parts, gone, BENT_ROUNDS, False), way.blockers
                    if led.is_found:
                        break
        if self.clock.goes_on():
            tried.add(key)
        if not led.is_found:
            return False
        met = frozenset(each for each in out if self._is_met(node, each, led.poses)) - {item} - riding
        name = Bent(len(self._searched.bent) + 1)
        self._searched.bent[name] = (met | needed, led)
        actions.graph.learn(node, Exit((name,), met | needed))
        return True

    def has_play(self, item: int, riding: frozenset[int], out: frozenset[int]) -> bool:
        """Whether a part can be moved a little in one of its directions while items are out: without, a longer search
        is not worth it."""
        if item in self.actions.rings:
            return True
        gone = self.actions.gone(out)
        node = self.actions.node(item, riding)
        parts = [part for part in self.question.parts_of([node]) if part not in gone]
        bounds = Tool.of_parts(self._mockup, parts).bounds
        far, graph = PLAY_SHARE * float(np.linalg.norm(bounds[1] - bounds[0])), self.actions.graph
        for direction in graph.directions(node):
            self.clock.look()
            blockers = graph.blockers_within(node, direction, far)
            if blockers is not None and blockers <= gone:
                return True
        return False

    def can_turn(self, item: int, riding: frozenset[int], out: frozenset[int]) -> bool:
        """Whether a part can be turned a little about one of its own axes while items are out, as a bayonet can."""
        gone = self.actions.gone(out)
        parts = [part for part in self.question.parts_of([self.actions.node(item, riding)]) if part not in gone]
        corners = np.concatenate([self.actions.graph.meshes.corners(part) for part in parts])
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        if not areas.sum() > 0.0:
            return False
        middle = np.average(corners.mean(axis=1), axis=0, weights=areas)
        tool, rest = Tool.of_parts(self._mockup, parts), self._left(gone).without(parts)
        for axis in part_axes(corners):
            for sign in (1.0, -1.0):
                self.clock.look()
                pose = np.eye(4)
                pose[:3, :3] = rotation(sign * TURN_RAD * axis)
                pose[:3, 3] = middle - pose[:3, :3] @ middle
                if rest.cast(tool, np.eye(4), pose, touching="free") is None:
                    return True
        return False

    def _is_met(self, node: int, other: int, poses: Floats) -> bool:
        self.clock.look()
        parts = [part for part in self.question.parts_of([other]) if self.question.scene.part_mask[part]]
        there = self.question.scene.only(parts)
        return not there.check_path(self.question.moving([node]), poses, touching="free").is_free

    def _is_last(self, parts: tuple[int, ...], gone: frozenset[int]) -> bool:
        return int(self.question.scene.part_mask.sum()) <= len(parts) + len(gone)

    def _of_ring(
        self, way: RingWay, parts: tuple[int, ...], gone: frozenset[int], rounds: int, is_straight: bool
    ) -> Led:
        """Opened until it lies free; from there on its way is searched."""
        direction = way.slipping.direction if is_straight else None
        asked = WayAsked(parts, gone, direction, rounds, int(self.question.options["seed"]))
        found = self._from(way.slipping.pose, asked)
        led = Led.of(found)
        said = f"{way.slipping}" + (f"; then {led.said}" if found.legs else "")
        return Led(led.is_found, np.concatenate([np.eye(4)[None], led.poses]), said, led.worst)

    def _led(self, asked: WayAsked, directions: Sequence[Direction] = ()) -> Led:
        """The way of parts from where they are modelled. directions: of which two are tried first."""
        if not self.clock.goes_on():
            return Led.of(not_tried(asked.seed))
        if asked not in self._searched.led:
            left = self._left(asked.gone)
            boxes = [each.tolist() for scene in (self.question.scene, left) for each in box_of_parts(scene)]
            facts = [None if asked.direction is None else list(asked.direction), asked.rounds, asked.seed, boxes]
            facts += [[list(each) for each in directions]]
            told = left._recalled("way", asked.parts, facts, lambda: self._new(asked, left, directions).plain())
            if not self.clock.goes_on():
                return Led.read(told)
            self._searched.led[asked] = Led.read(told)
        return self._searched.led[asked]

    def _new(self, asked: WayAsked, left: Scene, directions: Sequence[Direction]) -> Led:
        """As `_led`, which does not know it."""
        legs = two_legs(left, asked.parts, directions, self.clock.look) if directions else ()
        if legs:
            return Led(True, np.stack([np.eye(4), *(leg.pose for leg in legs)]), "; ".join(map(str, legs)))
        if asked.rounds == 0:
            return Led(False, np.eye(4)[None], "")
        return Led.of(self.actions.ahead.way(asked, self.question.options["threads"]))

    def _from(self, pose: Floats, asked: WayAsked) -> Removal:
        """The way of parts that are moved first."""
        if not self.clock.goes_on():
            return not_tried(asked.seed)
        scene = self._left(asked.gone)
        return way_from(
            pose,
            scene,
            list(asked.parts),
            tool=None,
            start=None,
            allowed=Allowed.of(scene, None, 0.0, True),
            clearance=0.0,
            directions=None if asked.direction is None else [asked.direction],
            seconds=self.clock.left,
            rounds=asked.rounds,
            seed=asked.seed,
            threads=self.question.options["threads"],
            progress=lambda _share, _stage: self.clock.look(),
        )

    def _left(self, gone: frozenset[int]) -> Scene:
        return self.question.scene.without(sorted(gone)) if gone else self.question.scene
