"""Ways of removals in the sequence: whether they hold, and shorter ones.

A way holds if the hand could go it in mode stop: each motion from pose to pose is cast, and parts in contact at its
start are seats. It is asked of the mock-up as the line has it: with the lines before it done.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from feeler._core import GuardedMove, Impact
from feeler.errors import FeelerError, WorkbenchError
from feeler.mockup import Tool
from feeler.poses import between, inverse
from feeler.progress import Progress
from feeler.words import length_in, plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import BlockerFacts, Gap, WayFacts
from feeler.workbench.document.document import Card, Document, Removal, line_out, line_places
from feeler.workbench.document.joints import figure
from feeler.workbench.document.known import Way
from feeler.workbench.document.line_facts import line_steps
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.geometry import scene_bounds
from feeler.workbench.engine.hand import Hands
from feeler.workbench.engine.mechanism import Standings, given_values
from feeler.workbench.engine.world import World
from feeler.workbench.session.answering import Answered, gaps_along, nearest, part_of, shown, triple
from feeler.workbench.session.joint_free import range_from, went

TOLERANCE_M, OFF_M = 2.5e-7, 5e-7
"""As of the engine: a way that the hand has gone is not refused because it rests at contact."""
CUT_TRIES = 60
"""Shortcuts between random places that are tried."""
LEAST_SAVED = 0.01
"""A way that is shorter by less than this share is the same."""
LEAST_CUT = 1e-3
"""A shortcut saves at least this share of the way."""
_MOST_LEGS = 12  # that are told one by one
_SAME_VALUE = 1e-6  # radians or metres: the joint got there
_TURNED_RAD = math.radians(0.5)  # less is not told
_CHECK_SHARE, _SHORTEN_SHARE = 0.6, 0.7  # of the time, of the first stage


@dataclass(frozen=True, eq=False)
class Hit:
    """Where a way does not hold: after which of its poses, the last free pose, and what it met."""

    after: int
    pose: Floats
    impact: Impact


class LineWay:
    """The way of a line: what moves, as one tool, its poses, and the world around it."""

    def __init__(self, document: Document, card: Card, hands: Hands) -> None:
        """Raises `WorkbenchError` if the line is gone."""
        at = next((at for at, line in enumerate(document.sequence) if line.id == card.line), None)
        if at is None:
            raise WorkbenchError("this removal is not in the sequence any more", "cards", "ask again")
        self.line: Removal = document.sequence[at]
        self.mockup = hands.scene.mockup
        self._unit = document.unit
        self.poses = np.array([motion.matrix(each) for each in self.line.way])
        self.places = line_places(document, at)
        bounds, own = scene_bounds(hands.scene), set(self.line.parts)
        boxes = {part: np.array([self.mockup.parts[part].lower, self.mockup.parts[part].upper]) for part in self.places}
        # Parts that are out do not hinder it.
        places = self.places.items()
        out = {part for part, place in places if motion.is_outside(boxes[part], motion.matrix(place), bounds)}
        out.update(line_out(document, at))
        lying = {part: place for part, place in self.places.items() if part not in own | out}
        gone = own | out
        self.is_alone = not lying and bool(hands.scene.part_mask.sum() == len(gone))
        self._around = (hands, lying, tuple(sorted(gone)))
        tool = self.line.tool if self.line.tool in hands.names else None
        self.lost_tool = self.line.tool if tool is None else None
        back = inverse(self.poses[0])
        held = tuple((part, motion.row(back @ motion.matrix(start))) for part, start in self.line.before.items())
        self.moving: Tool = hands.assembled(tool, held)

    def length(self, metres: float) -> str:
        """A length in words."""
        return length_in(metres, self._unit)

    def world(self) -> World:
        """The world around it; made here, for its index takes time."""
        hands, lying, gone = self._around
        return World(hands.scene, hands.meshes, lying, gone)

    def moved(self, poses: Floats) -> Floats:
        """Poses of the hand as motions of the parts: the first is the identity."""
        moves = poses @ inverse(self.poses[0])
        moves[0] = np.eye(4)
        return moves


def check_way(document: Document, card: Card, hands: Hands, progress: Progress) -> Answered:
    """Whether the way of a line holds."""
    way = LineWay(document, card, hands)
    if way.line.joint is not None:
        return _joint_checked(document, way, hands, progress)
    hit, gaps = _walked(way, way.poses, progress)
    if hit is not None:
        return _refused(way, hit)
    facts = _facts(way, way.poses, gaps)
    kept = _way_of(way, facts)
    poses = plural(len(way.poses), "pose")
    near = nearest(way.mockup, kept, gaps, way.length)
    sentence = f"The way holds at and between its {poses}: {_measured(facts, way)}{near}."
    return Answered(sentence, True, (kept,), (facts,), facts=_tool_facts(way))


def shorten_way(document: Document, card: Card, hands: Hands, progress: Progress) -> Answered:
    """A shorter way of a line, of straight legs that hold."""
    way = LineWay(document, card, hands)
    if way.line.joint is not None:
        raise WorkbenchError("a joint has one way alone", "cards", "check it")
    before = _length(way.moving, way.poses)
    if way.is_alone:
        short: Floats | Hit = way.poses[[0, -1]]
    else:
        short = Shortener(way.world(), way.moving, part_of(progress, 0.0, _SHORTEN_SHARE)).shortened(way.poses)
    if isinstance(short, Hit):
        return _refused(way, short)
    hit, gaps = _walked(way, short, part_of(progress, _SHORTEN_SHARE, 1.0))
    if hit is not None:
        return _refused(way, hit)
    facts = _facts(way, short, gaps)
    kept, saved = _way_of(way, facts), 1.0 - _length(way.moving, short) / before if before > 0.0 else 0.0
    pieces = plural(len(short) - 1, "straight piece")
    if saved < LEAST_SAVED and len(short) >= len(way.poses):
        return Answered(f"No shorter way was found: it has {pieces} already.", None, (kept,), (facts,))
    by = f"shorter by {100 * saved:.0f} %" if saved >= LEAST_SAVED else "simpler"
    sentence = (
        f"The way can be {by}: {_measured(facts, way)} in {pieces} instead of {len(way.poses) - 1:,}"
        f"{nearest(way.mockup, kept, gaps, way.length)}. It was checked."
    )
    return Answered(sentence, True, (kept,), (facts,), facts=_tool_facts(way))


def _joint_checked(document: Document, way: LineWay, hands: Hands, progress: Progress) -> Answered:
    """Whether a joint goes from one value to the other, cast exactly along its motion."""
    step, state = way.line.joint, document.mechanism
    assert step is not None, "the line moves a joint"
    if state is None or state.number(step.name) is None:
        raise WorkbenchError(f"there is no joint {step.name} any more", "cards", "open its mechanism")
    progress(0.1, "casting the joint")
    at = next(at for at, line in enumerate(document.sequence) if line.id == way.line.id)
    standings = Standings(hands.scene)
    try:
        whole = standings.whole(state.text, state.name)
        poses = whole.links.poses(step.start)
        links = tuple(replace(link, pose=motion.row(poses[k])) for k, link in enumerate(state.links))
        then = replace(
            document,
            mechanism=replace(state, values=step.start, links=links),
            moved=MappingProxyType(way.places),
            out=line_out(document, at),
            gripped=MappingProxyType({}),
        )
        positions = standings.asked(then)
        others = given_values(positions, step.start, step.name)
        found = range_from(positions, step.name, {**others, step.name: step.begin})
        got = went(positions, step.name, others, found, step.end)
    except WorkbenchError:
        raise
    except FeelerError as error:
        raise WorkbenchError(str(error), "cards", "see docs/mechanisms.md") from None
    facts = _facts(way, way.poses, [])
    kept = _way_of(way, facts)
    reached, met = got.value, got.met
    begin, end = figure(step.kind, step.begin, document.unit), figure(step.kind, step.end, document.unit)
    if abs(reached - step.end) <= _SAME_VALUE:
        return Answered(f"{step.name} moves freely from {begin} to {end}.", True, (kept,), (facts,))
    sentence = f"{step.name} stops at {figure(step.kind, reached, document.unit)} on its way from {begin} to {end}"
    if met is None:
        return Answered(f"{sentence}: {got.why or 'its limit'}.", False, (kept,), (facts,))
    name = way.mockup.part_names[met.other].rpartition("/")[2]
    share = (reached - step.begin) / (step.end - step.begin)
    facts["hit"] = {"share": share, "part": met.other, "point": met.point}
    return Answered(f"{sentence}: it meets {name}.", False, (kept,), (facts,))


LINE_ANSWERS: dict[str, Callable[[Document, Card, Hands, Progress], Answered]] = {
    "way": check_way,
    "shorten": shorten_way,
}
"""By the question of a card about a line."""


class Shortener:
    """Makes a way shorter: leaps from each place to the last one that a straight motion leads to, then shortcuts
    between random places."""

    def __init__(self, world: World, moving: Tool, progress: Progress, seed: int = 0) -> None:
        self._world, self._moving, self._progress = world, moving, progress
        self._random = random.Random(seed)
        self._middle = moving.bounds.mean(axis=0)

    def shortened(self, poses: Floats) -> Floats | Hit:
        """The shorter way; where it stops, if not even the given poses lead on."""
        way = self._leapt(poses, 0.0)
        if isinstance(way, Hit):
            return way
        whole = _length(self._moving, way)
        for number in range(CUT_TRIES):
            if len(way) < 3:
                break
            self._progress(0.5 + 0.5 * number / CUT_TRIES, "trying shortcuts")
            cut = self._cut(way)
            if _length(self._moving, way) - _length(self._moving, cut) > LEAST_CUT * whole and self._holds(cut):
                way = cut
        return way

    def _leapt(self, poses: Floats, share: float) -> Floats | Hit:
        at, kept = 0, [poses[0]]
        guard = self._guard(kept)
        while at < len(poses) - 1:
            beyond = len(poses) - 1
            while True:
                self._progress(share + 0.5 * at / len(poses), "leaping ahead")
                has_seats = bool(guard.seats())
                moved = guard.go(kept[-1], poses[beyond], TOLERANCE_M, OFF_M)
                if moved.impact is None:
                    break
                if beyond == at + 1:
                    return Hit(at, moved.pose, moved.impact)
                if has_seats:  # some of which may have ended on the way that is not gone
                    guard = self._guard(kept)
                beyond = at + max(1, (beyond - at) // 2)
            kept.append(poses[beyond])
            at = beyond
        return np.array(kept)

    def _guard(self, kept: Sequence[Floats]) -> GuardedMove:
        guard = GuardedMove(self._world, self._moving, kept[0])
        for one, other in pairwise(kept):
            guard.go(one, other, TOLERANCE_M, OFF_M)
        return guard

    def _cut(self, way: Floats) -> Floats:
        """The way with a shortcut between two random places on it."""
        steps = [_step(self._moving, one, other) for one, other in pairwise(way)]
        places = sorted(self._random.uniform(0.0, sum(steps)) for _ in range(2))
        found = []
        for place in places:
            left = place
            for leg, step in enumerate(steps):
                if left < step or leg == len(steps) - 1:
                    share = min(1.0, left / step) if step > 0.0 else 0.0
                    found.append((leg, between(way[leg], way[leg + 1], self._middle, share)))
                    break
                left -= step
        (first, here), (last, there) = found
        return way if first == last else np.array([*way[: first + 1], here, there, *way[last + 1 :]])

    def _holds(self, way: Floats) -> bool:
        return (
            _hit(self._world, self._moving, way, lambda share, stage: self._progress(0.5, "trying shortcuts")) is None
        )


def _hit(world: World, moving: Tool, poses: Floats, progress: Progress) -> Hit | None:
    """The first impact on a way."""
    guard = GuardedMove(world, moving, poses[0])
    for number, (one, other) in enumerate(pairwise(poses)):
        progress(number / len(poses), f"pose {number + 1:,} of {len(poses):,}")
        moved = guard.go(one, other, TOLERANCE_M, OFF_M)
        if moved.impact is not None:
            return Hit(number, moved.pose, moved.impact)
    return None


def _walked(way: LineWay, poses: Floats, progress: Progress) -> tuple[Hit | None, list[Gap]]:
    """The first impact on a way, or the gaps along it."""
    if way.is_alone:
        return None, []
    world = way.world()
    hit = _hit(world, way.moving, poses, part_of(progress, 0.0, _CHECK_SHARE))
    if hit is not None:
        return hit, []
    return None, gaps_along(world, way.moving, poses, part_of(progress, _CHECK_SHARE, 1.0))


def _refused(way: LineWay, hit: Hit) -> Answered:
    part = hit.impact.part
    facts = _facts(way, way.poses, [])
    corners = motion.corners(way.moving.bounds)
    gone = _length(way.moving, way.poses[: hit.after + 1]) + motion.carried(way.poses[hit.after], hit.pose, corners)
    whole = _length(way.moving, way.poses)
    share = min(1.0, gone / whole) if whole > 0.0 else 0.0
    facts["hit"] = {"share": share, "part": part, "point": triple(hit.impact.point)}
    (move,) = hit.pose[None] @ inverse(way.poses[0])
    blocker: BlockerFacts = {"part": part, "attempts": 1, "is_proof": False, "pose": list(motion.row(move))}
    (name,) = shown(way.mockup, [part])
    sentence = f"The way meets {name} between pose {hit.after + 1:,} and {hit.after + 2:,} of {len(way.poses):,}."
    return Answered(sentence, False, (_way_of(way, facts),), (facts,), (blocker,), facts=_tool_facts(way))


def _way_of(way: LineWay, facts: WayFacts) -> Way:
    return Way(way.line.parts, tuple(tuple(each) for each in facts["poses"]), facts["clearance"])


def _facts(way: LineWay, poses: Floats, gaps: list[Gap]) -> WayFacts:
    known = [each["gap"] for each in gaps if each["gap"] is not None]
    moves = way.moved(poses)
    steps, turns = line_steps(way.line, moves, way.mockup.part_bounds)
    legs = [
        f"move {way.length(step)}" + (f", turn by {math.degrees(turn):.0f}°" if turn > _TURNED_RAD else "")
        for step, turn in zip(steps, turns, strict=True)
    ]
    return {
        "parts": list(way.line.parts),
        "poses": [list(motion.row(each)) for each in moves],
        "clearance": min(known, default=None),
        "legs": legs if len(legs) <= _MOST_LEGS else [],
        "length": sum(steps),
        "rotation": sum(turns),
        "gaps": gaps,
        "places": {str(part): list(place) for part, place in way.places.items()},
    }


def _measured(facts: WayFacts, way: LineWay) -> str:
    turned = f", turned by {math.degrees(facts['rotation']):.0f}°" if facts["rotation"] > _TURNED_RAD else ""
    return f"{way.length(facts['length'])}{turned}"


def _tool_facts(way: LineWay) -> tuple[tuple[str, str], ...]:
    if way.lost_tool is not None:
        return (("without", f"the {way.lost_tool}, which is not there now"),)
    return () if way.line.tool is None else (("with", f"the {way.line.tool} in hand"),)


def _length(moving: Tool, poses: Floats) -> float:
    """The travel of the fastest corner, metres."""
    return sum(_step(moving, one, other) for one, other in pairwise(poses))


def _step(moving: Tool, one: Floats, other: Floats) -> float:
    return motion.carried(one, other, motion.corners(moving.bounds))
