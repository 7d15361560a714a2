"""`find_joint`: how one group of parts moves against another, from their surfaces in contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_text
from feeler.errors import FeelerError, MeshError, OptionError
from feeler.mechanism.axial import axial_play
from feeler.mechanism.drawn_threads import drawn_threads
from feeler.mechanism.joint import Joint, JointKind
from feeler.mechanism.slipping import (
    FREE,
    LEAST_SHARE,
    TURN_PLAY_RAD,
    Way,
    ball_of,
    pitch_of,
    screws_of,
    slip,
    stopped,
    taper_of,
    turn,
    waving_of,
    way_of,
    winding_of,
)
from feeler.mechanism.surfaces import Cylinder, surfaces_of
from feeler.mechanism.touching import Touches, touches_of
from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes
from feeler.parts import PartsLike
from feeler.scene import Scene
from feeler.words import length

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

REACH = 0.012
"""Surfaces this near are in contact, as a share of the size of the space that both sides share: fits have play."""
COAXIAL_RAD = 0.05
SAME_RADIUS = 0.15
"""A shaft and its hole may differ by this share of their radius, and be out of line by it."""
FACETS_SHARE = 0.03
"""The share of facets that may seem to stop a turn of faces of revolution, such as balls in raceways."""
NEAR_SHAFT = 3.0
"""What locks a shaft within so many radii of its axis is part of the joint; what is farther is a stop elsewhere."""
KEYED = 1.3
"""Keys, flats and splines of a shaft are within so many radii of its axis. They may have play; what is farther stops
a turn only in contact, for doors have gaps to their frames."""
ROUNDING = 2.0**-21
"""Faces this near are in contact, as a share of the largest coordinate: four steps of single precision."""
FITS_SHARE = 0.1
"""Where more than this share of the surface of shafts in holes stops a turn, it is stopped."""
AXIAL_PLAY = 0.15
"""A shaft that slides no farther than this share of the span of its holes, to both sides together, is held."""
SHAFTS_SHARE = 0.1
"""Where shafts in their holes are more of the surface than this, they decide what turns."""
SLIPPING = -1.0
"""Weight of an axis that no cylinder has."""
SHOULDER = 0.02
"""Faces larger than this share of a shaft's section hold it."""
MOST_AXES = 16
MOST_TRIANGLES = 4_000_000

_STOPPED = "other faces, far from the axis, stop it both ways where it stands"


class JointError(FeelerError, ValueError):
    """Two groups of parts have no joint: they do not touch, or more is free than one joint has.

    candidates: the motions that are free, each as a `feeler.Joint`.
    """

    def __init__(self, what: str, candidates: tuple[Joint, ...] = ()) -> None:
        self.candidates = candidates
        super().__init__(what)


@dataclass(frozen=True, eq=False)
class _Axis:
    direction: Floats
    point: Floats
    weight: float
    shafts: tuple[tuple[Cylinder, Cylinder], ...] = ()
    """Pairs of cylinders of child and parent, if both have some."""


@dataclass(frozen=True, eq=False)
class _Motions:
    """What an axis allows."""

    axis: _Axis
    turning: Way
    sliding: Way
    nearly: Way | None = None
    """Of a shaft: what stops the turn where faces count that are near but not in contact, such as a frame's."""


def find_joint(mockup: Mockup | Scene, child: PartsLike, parent: PartsLike, name: str | None = None) -> Joint:
    """Finds how the parts of `child` move against those of `parent`: a joint with its axis, and its reason.

    The surfaces of both that face each other decide: a motion is free if it slides them in themselves. Shafts and their
    holes give the axis, whatever the number of their facets, with play and with a press; shoulders, keys, flats and
    threads say whether the child turns, slides, does both, or is a screw. A shoulder at one end makes a shaft a
    revolute joint, a bottom at one end does not. Results are estimates; no limits are sought.

    `mockup`: also a `Scene`, of which only the present parts count. `child` and `parent`: as `Parts.select` takes them.
    `name`: that of the joint; the last step of the path of the child's first part if None.

    Raises `JointError` if the sides do not touch, or if more than one joint is free; it says what is free, and
    `candidates` are these motions as joints. Raises `OptionError` for parts that do not exist or are on both sides.
    """
    if not isinstance(mockup, (Mockup, Scene)):
        raise MeshError(f"joints are of a feeler.Mockup or a feeler.Scene, not of {type(mockup).__name__}")
    world = mockup.mockup if isinstance(mockup, Scene) else mockup
    chosen = [world.parts.select(each).astype(np.int64) for each in (child, parent)]
    both = np.intersect1d(chosen[0], chosen[1])
    if len(both):
        raise OptionError(f"{world.part_paths[both[0]]!r} is in child and in parent: give it to one of them")
    if isinstance(mockup, Scene):
        chosen = [parts[mockup.part_mask[parts]] for parts in chosen]
    for side, parts in zip(("child", "parent"), chosen, strict=True):
        if not len(parts):
            raise OptionError(f"{side} names no part that is there: give at least one")
    if name is None:
        name = world.part_paths[chosen[0][0]].split("/")[-1].replace(".", "_").replace("=", "_").strip() or "joint"
    found = _Search(world, chosen[0], chosen[1], check_text("name", name, "the name of a joint"), child, parent)
    return found.joint()


class _Search:
    def __init__(
        self, world: Mockup, child: Ints, parent: Ints, name: str, given_child: PartsLike, given_parent: PartsLike
    ) -> None:
        self.world, self.name = world, name
        self.given, self.parts = (given_child, given_parent), (child, parent)
        sides = _sides(world, child, parent)
        if sides is None:
            raise self._error("have nothing in contact: their boxes are apart", ())
        own, others, self.size = sides
        reach = REACH * self.size
        self.travel = reach
        self.child = surfaces_of(*own, self.size)
        self.parent = surfaces_of(*others, self.size)
        if not len(self.child.corners) or not len(self.parent.corners):
            raise self._error("have nothing in contact: one has no surface", ())
        self.contact = ROUNDING * max(float(np.abs(each.corners).max()) for each in (self.child, self.parent))
        self.touches = touches_of(self.child, self.parent, reach)
        self._in_fits = np.zeros(len(self.touches), dtype=bool)

    def joint(self) -> Joint:
        if len(self.touches) < 3:
            found = self._drawn_thread()
            if found is not None:
                return found
            why = "parts drawn through each other have none there, such as a pin in a hole that is too narrow"
            raise self._error(
                f"have nothing in contact, no faces within {length(self.travel)} of each other ({why})", ()
            )
        ball = ball_of(self.touches)
        if ball is not None:
            balls = [self._joint(JointKind.REVOLUTE, axis, ball, "a ball in its socket") for axis in np.eye(3)]
            raise self._error("turn about every axis through one point: a ball joint", balls)
        shafts = [self._of_axis(axis) for axis in self._shafts()]
        found = self._thread([motions.axis for motions in shafts])
        if found is not None:
            return found
        found = None if shafts else self._drawn_thread()
        if found is not None:
            return found
        self._refuse_balls(shafts)
        for need_free in (True, False):
            for motions in shafts:
                found = self._of_shaft(motions, need_free)
                if found is not None:
                    return self._alone(found, motions)
        axes = self._axes([motions.axis for motions in shafts])
        found = self._thread(axes)
        if found is not None:
            return found
        others = [self._motions(axis) for axis in axes]
        self._refuse_balls(others)
        seen = sum(motions.axis.weight for motions in shafts) / float(self.touches.weights.sum())
        share = FACETS_SHARE if seen < SHAFTS_SHARE else LEAST_SHARE
        rounds = [m for m in others if not m.sliding.is_open and m.turning.most < share]
        rounds = [m for m in rounds if not self._fits_stop(m.axis)]
        # axes of cylinders first: they are exact
        for motions in sorted(rounds, key=lambda m: (m.axis.weight < 0.0, m.turning.most))[:1]:
            a = motions.axis
            found = self._joint(JointKind.REVOLUTE, a.direction, a.point, "faces of revolution about one axis")
            return self._alone(found, motions)
        for motions in others:
            a = motions.axis
            if motions.turning.is_free and motions.sliding.is_open and taper_of(self.touches, a.direction):
                said = "a cone in its seat, which lifts off to one side"
                return self._alone(self._joint(JointKind.REVOLUTE, a.direction, a.point, said), motions)
        for motions in others:
            if motions.turning.is_free and motions.sliding.is_free and motions.axis.weight >= 0.0:
                a = motions.axis
                found = self._joint(JointKind.CYLINDRICAL, a.direction, a.point, "a round face, no shoulders")
                return self._alone(found, motions)
        return self._slide(others)

    def _refuse_balls(self, axes: list[_Motions]) -> None:
        turning = [motions.axis for motions in axes if motions.turning.is_free]
        if any(_angle(turning[0].direction, axis.direction) > 0.3 for axis in turning[1:]):
            several = [self._joint(JointKind.REVOLUTE, a.direction, a.point, "the faces turn") for a in turning]
            raise self._error("turn about several axes, as a ball joint does", several)

    # ----- candidates

    def _shafts(self) -> list[_Axis]:
        """The axes of cylinders of both sides that are in each other, the one with the most surface first."""
        t = self.touches
        of = np.flatnonzero((t.child_cylinder >= 0) & (t.parent_cylinder >= 0))
        if not len(of):
            return []
        keys = np.stack([t.child_cylinder[of], t.parent_cylinder[of]], axis=1)
        pairs, index = np.unique(keys, axis=0, return_inverse=True)
        weights = np.bincount(index.reshape(-1), t.weights[of])
        fit = np.array([_fit(self.child.cylinders[a], self.parent.cylinders[b]) for a, b in pairs])
        self._in_fits[of] = fit[index.reshape(-1)]
        groups: list[list[tuple[Cylinder, Cylinder, float]]] = []
        for k in np.argsort(-weights, kind="stable"):
            one, other = self.child.cylinders[pairs[k, 0]], self.parent.cylinders[pairs[k, 1]]
            if not fit[k]:
                continue
            for group in groups:
                first = group[0][0]
                if _in_line(first, one):
                    group.append((one, other, float(weights[k])))
                    break
            else:
                groups.append([(one, other, float(weights[k]))])
        axes = [_common_axis(group) for group in groups]
        return sorted(axes, key=lambda axis: -axis.weight)[:MOST_AXES]

    def _axes(self, known: list[_Axis]) -> list[_Axis]:
        """Other axes: of cylinders of one side, and of the motions that slip best."""
        t = self.touches
        found: list[_Axis] = []
        for side, of in ((self.child, t.child_cylinder), (self.parent, t.parent_cylinder)):
            weights = np.bincount(of[of >= 0], t.weights[of >= 0], len(side.cylinders))
            for k in np.argsort(-weights, kind="stable")[:MOST_AXES]:
                if weights[k] > 0:
                    found.append(_Axis(side.cylinders[k].axis, side.cylinders[k].point, float(weights[k])))
        whole = [c for side in (self.child, self.parent) for c in side.cylinders]
        whole.sort(key=lambda c: -c.radius * c.length)
        found += [_Axis(c.axis, c.point, 0.0) for c in whole[:MOST_AXES]]
        for _, omega, _, point in screws_of(t):
            speed = float(np.linalg.norm(omega))
            if speed > 1e-3:
                found.append(_Axis(omega / speed, point, SLIPPING))
        new: list[_Axis] = []
        for axis in found:
            if not any(_same_line(axis, other, 0.001 * self.size) for other in [*known, *new]):
                new.append(axis)
        return new

    def _motions(self, axis: _Axis) -> _Motions:
        t = self.touches
        turning = way_of(t, turn(t, axis.direction, axis.point), TURN_PLAY_RAD)
        sliding = way_of(t, np.broadcast_to(axis.direction, t.points.shape), self.travel)
        return _Motions(axis, turning, sliding)

    def _of_axis(self, axis: _Axis) -> _Motions:
        """What a shaft in its holes allows: far from it only other fits and faces in contact stop the turn."""
        t = self.touches
        velocity = turn(t, axis.direction, axis.point)
        radius = max(max(one.radius, other.radius) for one, other in axis.shafts)
        counts = np.linalg.norm(velocity, axis=1) < KEYED * radius
        counts |= (t.child_cylinder >= 0) & (t.parent_cylinder >= 0)
        counts |= t.gaps <= self.contact
        near = self._motions(axis)
        if self._fits_stop(axis):
            return replace(near, turning=Way(1.0, 1.0))
        return replace(near, turning=way_of(t, velocity, TURN_PLAY_RAD, counts), nearly=near.turning)

    def _fits_stop(self, axis: _Axis) -> bool:
        """Whether shafts in their holes beside an axis stop a turn about it, small as they may be."""
        t = self.touches
        fits = self._in_fits
        total = float(t.weights[fits].sum())
        if not total:
            return False
        velocity = turn(t, axis.direction, axis.point)
        stops = stopped(t, slip(t, velocity), velocity, TURN_PLAY_RAD) & fits
        return float(t.weights[stops].sum()) > FITS_SHARE * total

    # ----- decisions

    def _of_shaft(self, motions: _Motions, need_free: bool) -> Joint | None:
        axis, turning, sliding = motions.axis, motions.turning, motions.sliding
        turns = turning.is_free if need_free else turning.is_open
        because = self._shaft_words(axis)
        if turns:
            if sliding.is_open and self._is_held(axis):
                said = f"{because}, held at both ends"
            elif sliding.is_free:
                return self._joint(JointKind.CYLINDRICAL, axis.direction, axis.point, f"{because}, no shoulders")
            elif not sliding.is_open:
                said = f"{because}, held at both ends"
            elif self._has_shoulder(axis):
                said = f"{because}, a shoulder at one end"
            else:
                said = f"{because}, a bottom at one end"
                return self._joint(JointKind.CYLINDRICAL, axis.direction, axis.point, said)
            nearly = motions.nearly or turning
            stop = "" if nearly.is_free else "; a stop on one side of the turn"
            stop = stop if nearly.is_open else f"; {_STOPPED}"
            return self._joint(JointKind.REVOLUTE, axis.direction, axis.point, said + stop)
        slides = sliding.is_free if need_free else sliding.is_open
        if slides and not turning.is_open:
            stop = "" if sliding.is_free else "; a stop at one end"
            said = f"{because}, with faces that keep it from turning{stop}"
            return self._joint(JointKind.PRISMATIC, axis.direction, axis.point, said)
        if need_free or not self._is_locked(axis):
            return None
        said = f"{because}; {_STOPPED}"
        return self._joint(JointKind.REVOLUTE, axis.direction, axis.point, said)

    def _is_held(self, axis: _Axis) -> bool:
        """Whether faces across the axis leave a shaft a play along it that is small beside the span of its holes."""
        ends = [
            float((c.point - axis.point) @ axis.direction) + sign * c.length / 2
            for pair in axis.shafts
            for c in [min(pair, key=lambda c: c.length)]
            for sign in (-1.0, 1.0)
        ]
        play = AXIAL_PLAY * (max(ends) - min(ends))
        sides = _sides(self.world, *self.parts, play / self.size + 2 * REACH)
        if sides is None:
            return False
        radius = min(min(one.radius, other.radius) for one, other in axis.shafts)
        area = SHOULDER * math.pi * radius**2
        return sum(axial_play(sides[0][0], sides[1][0], axis.direction, play, area)) < play

    def _is_locked(self, axis: _Axis) -> bool:
        """Whether a turn is stopped only far from the axis, by some parts forwards and by others backwards."""
        t = self.touches
        velocity = turn(t, axis.direction, axis.point)
        into = slip(t, velocity)
        stops = stopped(t, into, velocity, TURN_PLAY_RAD)
        radius = max(max(one.radius, other.radius) for one, other in axis.shafts)
        near = np.linalg.norm(velocity, axis=1) < NEAR_SHAFT * radius
        total = float(t.weights.sum())
        if float(t.weights[stops & near].sum()) > LEAST_SHARE * total:
            return False
        if ((t.child_cylinder >= 0) & (t.parent_cylinder >= 0))[stops & ~near].any():
            return False
        pairs = np.stack([t.child_part, t.parent_part], axis=1)
        forward, backward = ({tuple(p) for p in pairs[stops & ~near & side]} for side in (into > 0, into < 0))
        return not forward & backward

    def _has_shoulder(self, axis: _Axis) -> bool:
        """Whether what stops the slide lies outside the hole."""
        t = self.touches
        velocity = np.broadcast_to(axis.direction, t.points.shape)
        stops = stopped(t, slip(t, velocity), velocity, self.travel)
        across = t.points[stops] - axis.point
        across -= (across @ axis.direction)[:, None] * axis.direction
        radius = min(min(one.radius, other.radius) for one, other in axis.shafts)
        outside = np.linalg.norm(across, axis=1) > radius
        return float(t.weights[stops][outside].sum()) > 0.2 * float(t.weights[stops].sum())

    def _thread(self, axes: list[_Axis]) -> Joint | None:
        t = self.touches
        for axis in axes:
            if self._fits_stop(axis):
                continue
            pitch = pitch_of(t, axis.direction, axis.point)
            if pitch is None or abs(pitch) < 1e-6 * self.size or abs(pitch) > self.size:
                continue
            corners = [self.child.corners, self.parent.corners]
            pitch = waving_of(corners, t, axis.direction, axis.point, pitch)
            pitch = winding_of(self.child.corners, axis.direction, axis.point, pitch)
            way = way_of(t, turn(t, axis.direction, axis.point, pitch), TURN_PLAY_RAD)
            sliding = way_of(t, np.broadcast_to(axis.direction, t.points.shape), self.travel)
            if way.most < FACETS_SHARE and not sliding.is_open:
                turned = math.tau * pitch
                said = f"flanks of a thread with a pitch of {length(abs(turned))}"
                return self._joint(JointKind.SCREW, axis.direction, axis.point, said, turned)
        return None

    def _drawn_thread(self) -> Joint | None:
        """The joint of a bolt as wide as its thread in a hole as wide as its core, whose walls are not near each
        other."""
        pairs = drawn_threads(PartMeshes(self.world), self.child.cylinders, self.parent.cylinders)
        if not pairs or not all(_in_line(pairs[0][0], one) for one, _ in pairs):
            return None
        axis = _common_axis([(one, other, one.radius * one.length) for one, other in pairs])
        if not len(self.touches):
            said = f"{self._shaft_words(axis)}, no shoulders"
            return self._joint(JointKind.CYLINDRICAL, axis.direction, axis.point, said)
        motions = self._of_axis(axis)
        return self._of_shaft(motions, True) or self._of_shaft(motions, False)

    def _slide(self, others: list[_Motions]) -> Joint:
        t = self.touches
        directions = _unlike([*_crosses(t), *(motions.axis.direction for motions in others)])
        middle = t.weights @ t.points / t.weights.sum()
        free, stop = self._slides_of(directions)
        turns = [m for m in others if m.turning.is_free]
        slips = [s for s in screws_of(t) if s[0] < FREE]
        if len(free) == 1 and len(slips) <= 1 and not turns:
            return self._joint(JointKind.PRISMATIC, free[0], middle, f"flat faces along one direction{stop}")
        if not free and not turns and not slips:
            return self._joint(JointKind.FIXED, np.array([0.0, 0.0, 1.0]), middle, "faces in contact leave no motion")
        raise self._too_free(slips, free, turns)

    def _slides_of(self, directions: list[Floats]) -> tuple[list[Floats], str]:
        """Of some directions those that are free, and words for a stop. Those that no face opposes come first: others
        may only have play."""
        t = self.touches
        for travel in (self.size, self.travel):
            ways = [(d, way_of(t, np.broadcast_to(d, t.points.shape), travel)) for d in directions]
            free = [d for d, way in ways if way.is_free]
            if free:
                return _best_of(t, free), ""
        return _best_of(t, [d for d, way in ways if way.is_open]), "; a stop at one end"

    def _alone(self, joint: Joint, motions: _Motions) -> Joint:
        """The joint, if nothing else is free."""
        slips = [s for s in screws_of(self.touches) if s[0] < FREE]
        slides = joint.kind is JointKind.CYLINDRICAL or motions.sliding.is_free  # held: by faces farther away
        if len(slips) <= (2 if slides else 1):
            return joint
        raise self._too_free(slips, [], [motions])

    def _too_free(
        self, slips: list[tuple[float, Floats, Floats, Floats]], free: list[Floats], turns: list[_Motions]
    ) -> JointError:
        t = self.touches
        middle = t.weights @ t.points / t.weights.sum()
        lines = [_Axis(d, middle, 0.0) for d in [*_mean_normals(t), *free]]
        slides = [d for d in [*free, *_crosses(t), *_across(t)] if self._slides(d)]
        found = [
            self._joint(JointKind.PRISMATIC, d, middle, "the faces in contact slide along it")
            for d in _independent(slides)
        ]
        turned: list[Floats] = []
        for axis in [*(m.axis for m in turns), *lines]:
            if not all(_angle(axis.direction, other) > 0.05 for other in turned):
                continue
            if way_of(t, turn(t, axis.direction, axis.point), TURN_PLAY_RAD).is_free:
                turned.append(axis.direction)
                found.append(
                    self._joint(JointKind.REVOLUTE, axis.direction, axis.point, "the faces in contact turn about it")
                )
        count = max(len(slips), len(found))
        if count > 1:
            return self._error(f"are free in {count} ways, no joint holds them", found)
        said = "touch, and their faces agree with no joint" if not count else "move in one way that is no known joint"
        return self._error(f"{said}; give all parts that hold them, such as pins and screws, to one side", found)

    def _slides(self, direction: Floats) -> bool:
        t = self.touches
        return way_of(t, np.broadcast_to(direction, t.points.shape), self.travel).is_free

    # ----- words

    def _joint(self, kind: JointKind, axis: Floats, point: Floats, because: str, pitch: float = 0.0) -> Joint:
        child, parent = self.given
        sign = 1.0 if axis[np.argmax(np.abs(axis))] > 0.0 else -1.0
        x, y, z = (float(v) + 0.0 for v in sign * axis)
        px, py, pz = (float(v) for v in point)
        return Joint(self.name, kind, parent, child, (x, y, z), (px, py, pz), pitch=pitch, because=because)

    def _shaft_words(self, axis: _Axis) -> str:
        one, other = max(axis.shafts, key=lambda pair: pair[0].radius * pair[0].length)
        paths = self.world.part_paths
        sizes = [length(2 * one.radius), length(2 * other.radius)]
        size = sizes[0] if sizes[0] == sizes[1] else f"{sizes[0]} in {sizes[1]}"
        said = f"coaxial cylinders of {size} on {paths[one.part]!r} and {paths[other.part]!r}"
        return said if _fit(one, other) else f"{said}, a thread drawn as wide as the bolt in a hole as wide as its core"

    def _error(self, what: str, candidates: list[Joint] | tuple[Joint, ...]) -> JointError:
        said = "; ".join(
            f"{joint.kind} about {_numbers(joint.axis)} through {_numbers(joint.point)}"
            if joint.kind is JointKind.REVOLUTE
            else f"{joint.kind} along {_numbers(joint.axis)}"
            for joint in candidates[:6]
        )
        return JointError(f"child and parent {what}" + (f": {said}" if said else ""), tuple(candidates))


def _numbers(vector: tuple[float, float, float]) -> str:
    return "(" + ", ".join(f"{round(v, 4) + 0.0:g}" for v in vector) + ")"


def _sides(
    world: Mockup, child: Ints, parent: Ints, around: float = 2 * REACH
) -> tuple[tuple[Floats, Ints], tuple[Floats, Ints], float] | None:
    """The triangles of both sides near the other one, with their parts, and the size of the space they share. around:
    how near, in this size."""
    bounds = np.array([[part.lower, part.upper] for part in world.parts])
    boxes = []
    for parts in (child, parent):
        own = bounds[parts]
        own = own[~np.isnan(own).any(axis=(1, 2))]
        if not len(own):
            return None
        boxes.append(np.stack([own[:, 0].min(axis=0), own[:, 1].max(axis=0)]))
    low, high = np.maximum(boxes[0][0], boxes[1][0]), np.minimum(boxes[0][1], boxes[1][1])
    least = min(float(np.linalg.norm(box[1] - box[0])) for box in boxes)
    size = max(float(np.linalg.norm(np.maximum(high - low, 0.0))), 0.02 * least)
    margin = around * size
    if (low - margin > high + margin).any():
        return None
    meshes = PartMeshes(world)
    sides = []
    for parts in (child, parent):
        corners, owner = [], []
        for part in parts:
            if not ((bounds[part, 0] <= high + margin) & (bounds[part, 1] >= low - margin)).all():
                continue
            own = meshes.corners(int(part))
            near = ((own.min(axis=1) <= high + margin) & (own.max(axis=1) >= low - margin)).all(axis=1)
            near &= np.isfinite(own).all(axis=(1, 2))
            corners.append(own[near])
            owner.append(np.full(int(near.sum()), part))
        if not corners:
            return None
        sides.append((np.concatenate(corners), np.concatenate(owner)))
    return sides[0], sides[1], size


def _fit(one: Cylinder, other: Cylinder) -> bool:
    """Whether one is the hole of the other."""
    radius = min(one.radius, other.radius)
    return (
        one.is_hole != other.is_hole
        and abs(one.radius - other.radius) < SAME_RADIUS * radius
        and _angle(one.axis, other.axis) < COAXIAL_RAD
        and _beside(one, other) < SAME_RADIUS * radius
    )


def _in_line(one: Cylinder, other: Cylinder) -> bool:
    return _angle(one.axis, other.axis) < COAXIAL_RAD and _beside(one, other) < SAME_RADIUS * min(
        one.radius, other.radius
    )


def _angle(one: Floats, other: Floats) -> float:
    return float(np.arcsin(min(1.0, float(np.linalg.norm(np.cross(one, other))))))


def _beside(one: Cylinder, other: Cylinder) -> float:
    """How far the middle of another is from the axis of one."""
    return float(np.linalg.norm(np.cross(other.point - one.point, one.axis)))


def _same_line(one: _Axis, other: _Axis, near: float) -> bool:
    return (
        _angle(one.direction, other.direction) < 0.002
        and float(np.linalg.norm(np.cross(other.point - one.point, one.direction))) < near
    )


def _common_axis(group: list[tuple[Cylinder, Cylinder, float]]) -> _Axis:
    """The axis of shafts and holes in line: through their middles if these are far apart."""
    first = group[0][0].axis
    rows = [(c, weight) for one, other, weight in group for c in (one, other)]
    weights = np.array([weight for _, weight in rows])
    axes = np.array([c.axis * np.sign(c.axis @ first) for c, _ in rows])
    points = np.array([c.point for c, _ in rows])
    middle = weights @ points / weights.sum()
    direction = weights @ axes
    direction /= np.linalg.norm(direction)
    along = (points - middle) @ direction
    if np.ptp(along) > 4.0 * max(c.length for c, _ in rows):
        off = (points - middle) * np.sqrt(weights)[:, None]
        best = np.linalg.svd(off, full_matrices=False)[2][0]
        direction = best * np.sign(best @ direction)
    return _Axis(direction, middle, float(weights.sum()), tuple((one, other) for one, other, _ in group))


def _mean_normals(t: Touches, most: int = 8) -> list[Floats]:
    """The main directions of the normals in contact."""
    left = np.arange(len(t))
    found: list[tuple[float, Floats]] = []
    while len(left) and len(found) < most:
        first = left[np.argmax(t.weights[left])]
        like = np.abs(t.child_normals[left] @ t.child_normals[first]) > 0.995
        normals, weights = t.child_normals[left[like]], t.weights[left[like]]
        mean = (weights * np.sign(normals @ t.child_normals[first])) @ normals
        found.append((float(weights.sum()), mean / np.linalg.norm(mean)))
        left = left[~like]
    found.sort(key=lambda row: -row[0])
    total = float(t.weights.sum())
    return [normal for weight, normal in found if weight > LEAST_SHARE * total]


def _crosses(t: Touches) -> list[Floats]:
    """The directions along two faces in contact."""
    normals = _mean_normals(t)
    crosses = [np.cross(a, b) for i, a in enumerate(normals) for b in normals[i + 1 :]]
    return _unlike([c / np.linalg.norm(c) for c in crosses if np.linalg.norm(c) > 0.2])


def _across(t: Touches) -> list[Floats]:
    """Two directions along the main face in contact."""
    normal = _mean_normals(t)[0]
    one = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    one /= np.linalg.norm(one)
    return [one, np.cross(normal, one)]


def _best_of(t: Touches, directions: list[Floats], near: float = 0.3) -> list[Floats]:
    """Of directions near one another the one that slips best."""
    found: list[Floats] = []
    speeds = [float(t.weights @ slip(t, np.broadcast_to(d, t.points.shape)) ** 2) for d in directions]
    for k in np.argsort(speeds, kind="stable"):
        if all(_angle(directions[k], other) > near for other in found):
            found.append(directions[k])
    return found


def _independent(directions: list[Floats]) -> list[Floats]:
    """Directions that are no sums of earlier ones."""
    found: list[Floats] = []
    for direction in directions:
        if np.linalg.svd(np.array([*found, direction]), compute_uv=False)[-1] > 0.3 and len(found) < 3:
            found.append(direction)
    return found


def _unlike(directions: list[Floats]) -> list[Floats]:
    """Directions without those that repeat earlier ones."""
    found: list[Floats] = []
    for direction in directions:
        if all(_angle(direction, other) > 0.05 for other in found):
            found.append(direction)
    return found
