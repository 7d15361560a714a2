"""Checks the sample gearbox by other libraries: manifold3d finds parts that share volume, coal finds their distances,
the modelled plays, the free paths and the wrench swings; distances of triangles show that no part touches itself.

The tests use its functions.

    python bench/gearbox_judge.py [SEED ...]
"""

from __future__ import annotations

import dataclasses
import itertools
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any

import coal
import numpy as np
import numpy.typing as npt
from mesh_contacts import self_contacts

from feeler.samples.accessory import FAULTS, Fastener, Fault, Fit, Joint, Leg, Step, Truth
from feeler.samples.accessory.assembly import Assembly, Part
from feeler.samples.accessory.build import build
from feeler.samples.accessory.faults import plant
from feeler.samples.accessory.sample import ROOT, placed_mesh, placed_meshes, truth_of
from feeler.samples.accessory.sample import Drawn as SampleDrawn
from feeler.samples.accessory.solid import Cut
from feeler.samples.accessory.truth import STOP_RAD, SWING_RAD, steps_before
from feeler.samples.mesh import Mesh

manifold3d = import_module("manifold3d")  # an extra, without type information

Floats = npt.NDArray[np.float64]

GRID_M = 1e-6
"""Vertices are rounded to half a micrometre: surfaces are not more accurate than this."""
NOISE_M = 1e-9
"""Two libraries measure depths in double precision: they are not more accurate than this."""
LEAST_GAP_M = 2e-4
SIZES = (40_000, 200_000)
STEP_M = 2.5e-3
"""Between the poses at which a way is sampled."""
EASE_MM = 0.12
"""By how much holes are widened when paths are checked, so that facets and presses do not count."""
LEAST_MM3 = 1e-9
"""A shared volume that flush faces may have by rounding, mm3."""
FLUSH_MM3 = 0.02
"""Volume that parts which slide on each other may share, from rounding."""
FINE_MM = 0.002
"""The chord at which plays and presses are measured: less than the least of them, 3 um."""
POINTS = 2000
"""At which the depth of a press is measured: fewer, and the deepest may be missed; more takes longer."""
MOST = 20
"""Of the pairs of one kind and play that `main` measures: more takes longer, and they are drawn by the same lines."""
LIFT_M = 0.7e-3
"""How far flush parts are pulled apart, so that the play of their cylinders is the smallest gap: more than that
play."""
RULE_M = 5e-3
"""The clearance of pipes that the fault `too_near` breaks."""


PLANTS = (*((name,) for name in FAULTS), ("pipe_clash", "too_near", "no_way_out"), tuple(FAULTS))
"""Faults that are planted together when steps are judged."""
TOOTH = float(2.0 * np.pi / 44.0)
"""About the pitch of the main shaft's gear, radians."""
SWING_STEP = float(np.deg2rad(2.5))
SWING_NOISE = float(np.deg2rad(0.1))
"""How accurately the ends of swings are found."""


@dataclass
class Drawn:
    """Meshes by path, metres, with their truth."""

    meshes: dict[str, Mesh]
    truth: Truth


def of_sample(triangles: int, seed: int = 0, faults: Iterable[str] = ()) -> Drawn:
    """The sample as users get it."""
    drawn = SampleDrawn(triangles, seed, tuple(faults))
    return _with_truth(drawn.assembly, drawn.meshes(), seed)


def _with_truth(asm: Assembly, placed: list[tuple[Part, Mesh]], seed: int) -> Drawn:
    truth = truth_of(asm, {part.path: mesh for part, mesh in placed}, seed)
    return Drawn({f"{ROOT}/{part.path}": mesh for part, mesh in placed}, truth)


def eased(seed: int, chord_mm: float = 0.1, faults: Iterable[str] = ()) -> Drawn:
    """The gearbox with wider holes."""
    asm = build(Cut(chord_mm, EASE_MM), seed)
    asm.planted = plant(asm, tuple(faults))
    return _with_truth(asm, placed_meshes(asm), seed)


@lru_cache(maxsize=2)
def faultless(seed: int) -> Drawn:
    """The gearbox with wider holes and nothing planted; kept, for many compare with it."""
    return eased(seed)


def manifold(mesh: Mesh) -> Any:
    """The solid, millimetres."""
    return manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices * 1e3, mesh.faces.astype(np.uint64)))


def bounds(meshes: dict[str, Mesh]) -> tuple[Floats, Floats]:
    """Lower and upper corners, (n, 3) each."""
    return (
        np.array([mesh.vertices.min(axis=0) for mesh in meshes.values()]),
        np.array([mesh.vertices.max(axis=0) for mesh in meshes.values()]),
    )


def near_pairs(meshes: dict[str, Mesh], distance: float) -> list[tuple[str, str]]:
    """Pairs whose boxes are as near."""
    names = list(meshes)
    low, high = bounds(meshes)
    pairs = []
    for i, name in enumerate(names):
        meets = ((low[i] - distance <= high[i + 1 :]) & (low[i + 1 :] <= high[i] + distance)).all(axis=1)
        pairs += [(name, names[i + 1 + j]) for j in np.flatnonzero(meets).tolist()]
    return pairs


def shared_volumes(drawn: Drawn) -> dict[tuple[str, str], float]:
    """Volumes in mm3 that pairs share, by manifold3d; raises where a part is no valid solid."""
    solids = {}
    for path, mesh in drawn.meshes.items():
        solids[path] = manifold(mesh)
        if solids[path].status() != manifold3d.Error.NoError or solids[path].volume() <= 0.0:
            raise AssertionError(f"{path} is no solid: {solids[path].status()}")
    out = {}
    for a, b in near_pairs(drawn.meshes, 0.0):
        shared = (solids[a] ^ solids[b]).volume()
        if shared > LEAST_MM3:
            out[a, b] = shared
    return out


def bvh(mesh: Mesh) -> Any:
    """The triangles as coal takes them, metres."""
    made = coal.BVHModelOBBRSS()
    made.beginModel(len(mesh.faces), len(mesh.vertices))
    made.addVertices(np.ascontiguousarray(mesh.vertices))
    made.addTriangles(np.ascontiguousarray(mesh.faces))
    made.endModel()
    return made


def depth(a: Mesh, b: Mesh, most: int | None = None) -> float:
    """Penetration depth of two parts, metres: the largest distance from a point of their shared volume's surface to the
    surface of the other part.

    Measured at the corners of the shared volume and along its edges, at no more than about `most` points.
    """
    shared = (manifold(a) ^ manifold(b)).to_mesh64()
    corners = np.asarray(shared.vert_properties)[:, :3] * 1e-3
    edges = np.unique(np.sort(np.asarray(shared.tri_verts)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    start, end = corners[edges[:, 0].astype(np.int64)], corners[edges[:, 1].astype(np.int64)]
    points = np.concatenate([corners, *(start + (end - start) * share for share in (0.25, 0.5, 0.75))])
    points = points[:: max(1, len(points) // most)] if most else points
    deepest, dot, here = 0.0, coal.Sphere(1e-9), coal.Transform3s()
    for solid in (bvh(a), bvh(b)):
        for p in points:
            place = coal.Transform3s()
            place.setTranslation(p)
            gap = coal.distance(dot, place, solid, here, coal.DistanceRequest(), coal.DistanceResult())
            deepest = max(deepest, float(gap))
    return deepest


def gaps(drawn: Drawn, within: float, paths: Iterable[str] = ()) -> dict[tuple[str, str], float]:
    """Distances, metres, of pairs that no fit names and whose boxes are within a distance, by coal.

    `paths`: of one of the two, where not all.
    """
    named = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits}
    wanted = set(paths) or set(drawn.meshes)
    models = {path: bvh(mesh) for path, mesh in drawn.meshes.items()}
    here = coal.Transform3s()
    out = {}
    for a, b in near_pairs(drawn.meshes, within):
        if frozenset((a, b)) not in named and wanted & {a, b}:
            result = coal.DistanceResult()
            out[a, b] = float(coal.distance(models[a], here, models[b], here, coal.DistanceRequest(), result))
    return out


# --- fits -------------------------------------------------------------------------------------------------------------


class Fits:
    """Whether pairs are drawn as their fits say, at a chord that is less than their plays."""

    def __init__(self, seed: int = 0, chord_mm: float = FINE_MM) -> None:
        self.asm, self.chord = build(Cut(chord_mm), seed), chord_mm * 1e-3
        self.truth = truth_of(self.asm, {}, seed)
        self._meshes: dict[str, Mesh] = {}

    def mesh(self, path: str) -> Mesh:
        """A part in the world, metres."""
        if path not in self._meshes:
            self._meshes[path] = placed_mesh(self.asm, self.asm.parts[path.removeprefix(f"{ROOT}/")])
        return self._meshes[path]

    def size(self, fit: Fit) -> int:
        """Triangles of the two."""
        parts = (self.asm.parts[path.removeprefix(f"{ROOT}/")] for path in (fit.a, fit.b))
        return sum(self.asm.solid(part).triangle_count for part in parts)

    def lifts(self, fit: Fit) -> list[Floats]:
        """Translations (3,) of `fit.a`, metres, that separate faces on which the two parts lie flush.

        Along the way on which one of them comes out. Where both come out as one unit, either sense may separate them.
        """
        if not fit.flush:
            return [np.zeros(3)]
        ways = [
            (fit.a in s.parts, fit.b in s.parts, np.array(s.legs[-1].axis))
            for s in self.truth.steps
            if s.legs and s.removes
        ]
        for a, b, axis in ways:
            if a != b:
                return [axis * (LIFT_M if a else -LIFT_M)]
        return [axis * lift for a, b, axis in ways if a and b for lift in (LIFT_M, -LIFT_M)]

    def gap(self, fit: Fit) -> float:
        """The least gap of a pair, metres, by coal; of a pair that is flush as well, with the planes apart."""
        here, away, found = coal.Transform3s(), coal.Transform3s(), []
        models = bvh(self.mesh(fit.a)), bvh(self.mesh(fit.b))
        for lift in self.lifts(fit):
            away.setTranslation(lift)
            result = coal.DistanceResult()
            found.append(float(coal.distance(models[0], away, models[1], here, coal.DistanceRequest(), result)))
        return max(found)

    def wrong(self, most: int | None = None) -> list[str]:
        """Plays that are not named, and presses that are not as deep.

        `most`: pairs of each kind and play, those with the fewest triangles.
        """
        found, seen = [], dict[tuple[str, int], int]()
        for fit in sorted(self.truth.fits, key=self.size) if most else self.truth.fits:
            key = fit.kind, round(fit.play_m * 1e6)
            seen[key] = seen.get(key, 0) + 1
            if fit.play_m == 0.0 or (most is not None and seen[key] > most):
                continue
            if fit.play_m > 0.0:
                drawn, chords = self.gap(fit), self.chord
            else:
                drawn = -depth(self.mesh(fit.a), self.mesh(fit.b), POINTS)
                chords = max(self.chord, fit.deepest_m + fit.play_m)
            if abs(drawn - fit.play_m) > chords + GRID_M:
                named = f"named {fit.play_m * 1e6:.1f} um, drawn {drawn * 1e6:.1f}"
                found.append(f"{fit.a} and {fit.b} ({fit.kind}): {named}")
        return found


# --- ways -------------------------------------------------------------------------------------------------------------


def leg_pose(leg: Leg, share: float) -> Floats:
    """The motion of a leg's parts at a share of it, (4, 4)."""
    x, y, z = leg.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = leg.angle_rad * share
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    pose = np.eye(4)
    pose[:3, :3] = turn
    point = np.array(leg.point_m)
    pose[:3, 3] = point - turn @ point + np.array(leg.axis) * leg.distance_m * share
    return pose


def joint_pose(joint: Joint, angle: float) -> Floats:
    """The motion of a joint's parts at an angle, (4, 4)."""
    return leg_pose(Leg("turn", joint.axis, joint.point_m, 0.0, angle), 1.0)


def shares(leg: Leg, reach: float) -> list[float]:
    """At which shares of a leg it is sampled; `reach`: how far its parts are from the axis."""
    length = max(leg.distance_m, min(abs(leg.angle_rad) * reach, 0.4))
    count = max(3, int(np.ceil(length / STEP_M)))
    first = [min(1e-4 / leg.distance_m, 0.5 / count)] if leg.distance_m else []
    return first + [k / count for k in range(1, count + 1)]


class Ways:
    """Collision checks of the steps of a truth. Before a step only the parts that its `after` names are removed."""

    def __init__(self, drawn: Drawn) -> None:
        self.drawn, self.truth = drawn, drawn.truth
        meshes = dict(drawn.meshes)
        self.models = {path: bvh(mesh) for path, mesh in meshes.items()}
        for step in self.truth.steps:
            meshes |= {} if step.rigid else {path: spread(meshes[path], step) for path in step.parts}
        low, high = bounds(meshes)
        pick = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=bool)
        self.corners = dict(zip(drawn.meshes, np.where(pick[None], high[:, None], low[:, None]), strict=True))
        self.kinds = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits}
        self.threads = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits if "thread" in fit.kind}
        self.joints = {joint.name: joint for joint in self.truth.joints}
        self.door = frozenset(self.joints["door"].parts)
        self.opened = joint_pose(self.joints["door"], self.joints["door"].high or 0.0)

    def blocked(self, step: Step, against: Iterable[str] = ()) -> dict[tuple[str, str], tuple[int, float]]:
        """Collisions of a step, by (moving part, other part): the number of the leg, and the fraction of it.

        `against`: the other parts to check, where not all.
        """
        out, pose = set[str](), dict[str, Floats]()
        for earlier in steps_before(self.truth.steps, step):
            if earlier.removes:
                out |= set(earlier.parts)
            for leg in earlier.legs:
                for path in earlier.parts:
                    pose[path] = leg_pose(leg, 1.0) @ pose.get(path, np.eye(4))
        moving = [path for path in step.parts if path not in out]
        others = [path for path in set(against) or self.models if path not in out and path not in step.parts]
        if not others:
            return {}
        places = [pose.get(path, np.eye(4)) for path in others]
        if step.door_open:
            places = [self.opened @ p if path in self.door else p for path, p in zip(others, places, strict=True)]
        boxes = np.stack([_moved(self.corners[path], p) for path, p in zip(others, places, strict=True)])
        low, high = boxes.min(axis=1), boxes.max(axis=1)
        found: dict[tuple[str, str], tuple[int, float]] = {}
        base = np.eye(4)
        for number, leg in enumerate(step.legs):
            points = np.concatenate([self.corners[path] for path in moving]) - np.array(leg.point_m)
            reach = float(np.sqrt((np.cross(points, leg.axis) ** 2).sum(axis=1)).max())
            for share in shares(leg, reach):
                for path in moving:
                    here = leg_pose(leg, share) @ base @ pose.get(path, np.eye(4))
                    box = _moved(self.corners[path], here)
                    for k in np.flatnonzero(
                        ((low <= box.max(axis=0)) & (high >= box.min(axis=0))).all(axis=1)
                    ).tolist():
                        if (path, others[k]) not in found and self._meet(path, here, others[k], places[k], step):
                            found[path, others[k]] = (number, share)
            base = leg_pose(leg, 1.0) @ base
        return found

    def latched(self, joint: Joint, path: str) -> Floats:
        """The pose (4, 4) of a part while a joint moves: joints that have to be open first are at their limits."""
        needed = (self.joints[name] for name in joint.needs)
        return next((joint_pose(j, j.high or 0.0) for j in needed if path in j.parts), np.eye(4))

    def stopped_at(self, joint: Joint, angle: float) -> list[tuple[str, str]]:
        """Collisions with a joint at an angle (radians). Joints that it needs are at their limits; those that
        follow it turn with it."""
        poses: dict[str, Floats] = {}
        turned = {joint.name: angle}
        for path in (path for name in joint.needs for path in self.joints[name].parts):
            poses[path] = self.latched(joint, path)
        moving: dict[str, str] = {}
        while turned:
            name, here = turned.popitem()
            turned |= {j.name: here * j.ratio for j in self.joints.values() if j.follows == name}
            moving |= dict.fromkeys(self.joints[name].parts, name)
            pose = joint_pose(self.joints[name], here)
            poses |= {path: pose @ poses.get(path, np.eye(4)) for path in self.joints[name].parts}
        others = list(self.models)
        places = [poses.get(path, np.eye(4)) for path in others]
        boxes = np.stack([_moved(self.corners[path], place) for path, place in zip(others, places, strict=True)])
        low, high = boxes.min(axis=1), boxes.max(axis=1)
        found = []
        for path, name in moving.items():
            box = _moved(self.corners[path], poses[path])
            for k in np.flatnonzero(((low <= box.max(axis=0)) & (high >= box.min(axis=0))).all(axis=1)).tolist():
                apart = moving.get(others[k]) != name
                if apart and self._meet(path, poses[path], others[k], places[k]):
                    found.append((path, others[k]))
        return found

    def wrong_joints(self, joints: Iterable[Joint] = (), each: int = 17) -> list[str]:
        """Joints that meet something within their limits, or no stop just beyond them; as messages.

        A train of gears through two teeth, and a turn. `joints`: where not all that follow none; `each`: angles of one.
        """
        out = []
        for joint in joints or [joint for joint in self.truth.joints if not joint.follows]:
            stops: list[tuple[str, float]] = []
            if joint.low is None or joint.high is None:
                angles = [*np.linspace(0.0, 2.0 * TOOTH, each), *np.linspace(1.0, -5.3, each // 2)]
            else:
                angles = list(np.linspace(joint.low + 1e-3, joint.high - 1e-3, each))
                stops = [("below", joint.low - STOP_RAD), ("above", joint.high + STOP_RAD)]
            for angle in angles:
                if found := self.stopped_at(joint, float(angle)):
                    out.append(f"{joint.name} at {angle:.3f} meets {found}")
            for side, angle in stops:
                if not self.stopped_at(joint, angle):
                    out.append(f"{joint.name} has no stop {side} its limits")
        return out

    def _meet(self, a: str, a_pose: Floats, b: str, b_pose: Floats, step: Step | None = None) -> bool:
        meshes, model = [self.drawn.meshes[a], self.drawn.meshes[b]], self.models[a]
        if step is not None and not step.rigid:
            meshes[0] = spread(meshes[0], step)
            model = bvh(meshes[0])
        result = coal.CollisionResult()
        if not coal.collide(model, _at(a_pose), self.models[b], _at(b_pose), coal.CollisionRequest(), result):
            return False
        if frozenset((a, b)) not in self.kinds:
            return True
        shared = [manifold(moved_mesh(mesh, at)) for mesh, at in zip(meshes, (a_pose, b_pose), strict=True)]
        return bool((shared[0] ^ shared[1]).volume() > FLUSH_MM3)

    def superfluous(self, step: Step) -> list[str]:
        """Parts in `after` that need not be removed: with them in place the step and its tools collide with nothing.

        A way that is free by less than a chord is not free. Parts that come out together are left in together. A part
        that another need takes out anyway counts as needed, and so does one that has a fit with the parts of the step:
        they hold it, or it would hang in the air.
        """
        units = {path: other.parts for other in self.truth.steps if other.removes for path in other.parts}
        fasteners = [f for f in self.truth.fasteners if f.path in step.parts]
        found = []
        for unit in dict.fromkeys(units[path] for path in step.after if path in units):
            without = dataclasses.replace(step, after=tuple(path for path in step.after if path not in unit))
            if any(set(unit) & set(earlier.parts) for earlier in steps_before(self.truth.steps, without)):
                continue
            if any(frozenset(pair) in self.kinds for pair in itertools.product(step.parts, unit)):
                continue
            if self.blocked(without) or any(self.stopped(fastener, without) for fastener in fasteners):
                continue
            if self.nearest(step, unit) > self.truth.chord_m:
                found.append(unit[0])
        return found

    def nearest(self, step: Step, unit: Iterable[str]) -> float:
        """How near a step passes parts that stay where they are, metres."""
        least, base, here = np.inf, np.eye(4), coal.Transform3s()
        for leg in step.legs:
            for share in shares(leg, 0.0):
                pose = _at(leg_pose(leg, share) @ base)
                for a, b in itertools.product(step.parts, unit):
                    asked = coal.DistanceRequest(), coal.DistanceResult()
                    least = min(least, coal.distance(self.models[a], pose, self.models[b], here, *asked))
            base = leg_pose(leg, 1.0) @ base
        return float(least)

    def stopped(self, fastener: Fastener, step: Step) -> bool:
        """Whether the tool of a fastener turns less far than the truth says, after the needs of a step are out."""
        return self.turns(fastener, step) < fastener.swing_rad - SWING_NOISE

    def turns(self, fastener: Fastener, step: Step | None = None) -> float:
        """How far the tool of a fastener turns, radians: a socket or key in full or not at all."""
        if fastener.tool == "open-end wrench":
            return self.swing(fastener, step)
        return 0.0 if self.in_the_way(fastener, step) else 2.0 * np.pi

    def wrong_swing(self, fastener: Fastener) -> str:
        """A message if the swing of a fastener is wrong; for a socket or key it names the parts in the way."""
        free = self.turns(fastener)
        if abs(free - fastener.swing_rad) <= SWING_NOISE + SWING_RAD:
            return ""
        said = f"{np.rad2deg(free):.1f}, not {np.rad2deg(fastener.swing_rad):.1f} degrees"
        met = "" if fastener.tool == "open-end wrench" else f"; it meets {self.in_the_way(fastener)}"
        return f"the tool on {fastener.path} swings {said}{met}"

    def in_the_way(self, fastener: Fastener, step: Step | None = None) -> list[str]:
        """Parts that a socket or a hexagon key on a fastener meets in its full turn, after what goes before is out."""
        step = step or next(step for step in self.truth.steps if fastener.path in step.parts)
        out = {path for earlier in steps_before(self.truth.steps, step) if earlier.removes for path in earlier.parts}
        radius, length = fastener.tool_width_m / 2.0, fastener.tool_length_m - 2e-4
        z = np.array(fastener.axis)
        x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
        x /= np.sqrt(x @ x)
        pose = np.eye(4)
        pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
        pose[:3, 3] = np.array(fastener.top_m) + z * (length / 2.0 + 2e-4)
        tool = coal.Cylinder(radius, length)
        within = {fastener.path}
        if fastener.kind == "nut":  # a socket is hollow: the bolt's end goes into it
            within |= {path for pair in self.threads if fastener.path in pair for path in pair}
        found = []
        for path, model in self.models.items():
            if path in out or path in within:
                continue
            place = self.opened if step.door_open and path in self.door else np.eye(4)
            if coal.collide(model, _at(place), tool, _at(pose), coal.CollisionRequest(), coal.CollisionResult()):
                found.append(path)
        return found

    def swing(self, fastener: Fastener, step: Step | None = None) -> float:
        """The largest swing (radians) of an open-end wrench that is put on a fastener's flats, as far as it is free.

        After what goes before is out. What the fastener holds does not turn. Sampled; the ends by bisection.
        """
        step = step or next(step for step in self.truth.steps if fastener.path in step.parts)
        out = {path for earlier in steps_before(self.truth.steps, step) if earlier.removes for path in earlier.parts}
        z, top = np.array(fastener.axis), np.array(fastener.top_m)
        arms = self.drawn.meshes[fastener.path].vertices - top
        arms -= np.outer(arms @ z, z)
        x = arms[int(np.argmax((arms * arms).sum(axis=1)))]  # a corner of the hexagon; the handle goes there
        x /= np.sqrt(x @ x)
        corners = [np.array(box) for box in fastener.tool_boxes_m]
        boxes = [(coal.Box(*(high - low)), (low + high) / 2.0) for low, high in corners]
        reach = float(np.hypot(*np.abs(corners).max(axis=(0, 1))[:2]))
        near = []
        for path, model in self.models.items():
            place = self.opened if step.door_open and path in self.door else np.eye(4)
            ends = _moved(self.corners[path], place)
            away = np.maximum(np.maximum(ends.min(axis=0) - top, top - ends.max(axis=0)), 0)
            heights = (ends - top) @ z
            is_level = (
                heights.min() < np.max(corners, axis=(0, 1))[2] and heights.max() > np.min(corners, axis=(0, 1))[2]
            )
            if path not in out and path != fastener.path and away @ away < reach * reach and is_level:
                near.append((model, _at(place)))

        def is_free(angle: float) -> bool:
            turn = leg_pose(Leg("turn", fastener.axis, (0.0, 0.0, 0.0), 0.0, angle), 1.0)[:3, :3]
            pose = np.eye(4)
            pose[:3, :3] = turn @ np.stack([x, np.cross(z, x), z], axis=1)
            for box, centre in boxes:
                pose[:3, 3] = top + pose[:3, :3] @ centre
                at = _at(pose)
                for model, place in near:
                    if coal.collide(model, place, box, at, coal.CollisionRequest(), coal.CollisionResult()):
                        return False
            return True

        def end(free: float, blocked: float) -> float:
            while abs(free - blocked) > SWING_NOISE / 2.0:
                middle = (free + blocked) / 2.0
                free, blocked = (middle, blocked) if is_free(middle) else (free, middle)
            return free

        count = round(2.0 * np.pi / SWING_STEP)
        free = [is_free(k * SWING_STEP) for k in range(count)]
        if all(free):
            return 2.0 * np.pi
        swings = [0.0]
        for k in range(0, count, count // 6):  # where it goes on the flats
            if free[k]:
                after = next(n for n in range(count) if not free[(k + n) % count])
                before = next(n for n in range(count) if not free[(k - n) % count])
                last = end((k + after - 1) * SWING_STEP, (k + after) * SWING_STEP)
                swings.append(last - end((k - before + 1) * SWING_STEP, (k - before) * SWING_STEP))
        return float(max(swings))


def spread(mesh: Mesh, step: Step) -> Mesh:
    """A circlip as its step spreads it: all its points move away from its axis."""
    axis, off = np.array(step.legs[0].axis), mesh.vertices - np.array(step.spread_about_m)
    across = off - np.outer(off @ axis, axis)
    radius = np.sqrt((across * across).sum(axis=1))[:, None]
    return Mesh(mesh.vertices + across * (step.spread_m / radius), mesh.faces)


def moved_mesh(mesh: Mesh, pose: Floats) -> Mesh:
    """A mesh at a pose."""
    return Mesh(_moved(mesh.vertices, pose), mesh.faces)


def _moved(points: Floats, pose: Floats) -> Floats:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _at(pose: Floats) -> Any:
    placed = coal.Transform3s()
    placed.setRotation(pose[:3, :3])
    placed.setTranslation(pose[:3, 3])
    return placed


def too_deep(drawn: Drawn, every: int = 1) -> list[str]:
    """Pairs that share volume and have no fit, or are deeper than their fit says; as messages.

    `every`: of the named pairs, whose depth is measured.
    """
    named = {frozenset((fit.a, fit.b)): fit for fit in drawn.truth.fits}
    shared = list(shared_volumes(drawn))
    wrong = [f"{a} and {b} have no fit" for a, b in shared if frozenset((a, b)) not in named]
    for a, b in [pair for pair in shared if frozenset(pair) in named][::every]:
        fit = named[frozenset((a, b))]
        deep = depth(drawn.meshes[a], drawn.meshes[b])
        if deep > fit.deepest_m + NOISE_M:
            wrong.append(f"{a} and {b} ({fit.kind}) are {deep * 1e6:.1f} um deep, not {fit.deepest_m * 1e6:.1f}")
    return wrong


# --- faults -----------------------------------------------------------------------------------------------------------


def unplanned(faulty: Drawn, clean: Drawn) -> list[str]:
    """Pairs that the planted faults bring closer than allowed and that neither a fit nor a fault names; as messages.

    Only of parts that the faults add or change. A part of a wrong unit may meet all.
    """
    named = {frozenset((fit.a, fit.b)) for fit in faulty.truth.fits}
    named |= {frozenset(fault.parts) for fault in faulty.truth.faults if len(fault.parts) == 2}
    wild = {fault.parts[0] for fault in faulty.truth.faults if fault.expects == "unit"}
    out = []
    for (a, b), gap in gaps(faulty, LEAST_GAP_M, changed(faulty, clean)).items():
        if gap < LEAST_GAP_M and frozenset((a, b)) not in named and not wild & {a, b}:
            out.append(f"{a} and {b} come near without a fit")
    return out


def changed(faulty: Drawn, clean: Drawn) -> set[str]:
    """Parts that the planted faults add or change."""
    return {p for p, mesh in faulty.meshes.items() if p not in clean.meshes or not _same(mesh, clean.meshes[p])}


def wrong_steps(seed: int, plants: Iterable[tuple[str, ...]] = PLANTS) -> list[str]:
    """Wrong statements of steps and swings about planted faults, as messages.

    A step that says that a fault blocks it is blocked, or needs one that is; all others are free of the parts that the
    faults add or change. Tools turn as far as the fasteners say, and not in full where they say 0.
    """
    clean, out = faultless(seed), []
    for names in plants:
        ways = Ways(eased(seed, faults=names))
        new = changed(ways.drawn, clean)
        for step in ways.truth.steps:
            found = ways.blocked(step, () if new & set(step.parts) else new)
            if found and not step.blocked_by:
                out.append(f"faults {names}: {step.parts[0]} is blocked by {found}")
            elif step.blocked_by and not found and not any(s.blocked_by for s in ways.truth.needed(step)):
                out.append(f"faults {names}: nothing blocks {step.parts[0]}")
        for fastener in ways.truth.fasteners:
            if wrong := ways.wrong_swing(fastener):
                out.append(f"faults {names}: {wrong}")
    return out


def _same(a: Mesh, b: Mesh) -> bool:
    return np.array_equal(a.vertices, b.vertices) and np.array_equal(a.faces, b.faces)


def wrong_values(faulty: Drawn) -> list[str]:
    """Faults whose `value` differs from the measured one by more than the chord error; as messages."""
    out = []
    for fault in faulty.truth.faults:
        measured = _measured(faulty, fault)
        if abs(measured - fault.value) > 1.1 * faulty.truth.chord_m + GRID_M:
            out.append(f"{fault.name}: {fault.value} is named, {measured} is drawn")
    return out


def _measured(faulty: Drawn, fault: Fault) -> float:
    meshes = [faulty.meshes[path] for path in fault.parts]
    if fault.expects in ("clash", "no hole"):
        return depth(meshes[0], meshes[1])
    if fault.expects == "floating":
        others = (gap for pair, gap in gaps(faulty, 0.03, fault.parts).items())
        return min(others)
    if fault.expects in ("too near", "no tool access", "inside"):
        here = coal.Transform3s()
        models = [bvh(mesh) for mesh in meshes]
        return float(coal.distance(models[0], here, models[1], here, coal.DistanceRequest(), coal.DistanceResult()))
    return fault.value


def near_pipes(drawn: Drawn) -> list[set[str]]:
    """Pairs nearer than the rule for pipes: a pipe and what no fit joins to it."""
    pipes = [path for path in drawn.meshes if path.endswith(("_pipe/pipe", "_hose/hose"))]
    return [set(pair) for pair, gap in gaps(drawn, RULE_M, pipes).items() if gap < RULE_M]


def wrong_faults(seed: int, triangles: int = 44_000) -> list[str]:
    """The messages of `unplanned` for pairs of faults, and for all faults at once."""
    clean = of_sample(triangles, seed)
    out = [f"{set(pair)} are nearer than the rule for pipes" for pair in near_pipes(clean)]
    for names in (*itertools.combinations(FAULTS, 2), tuple(FAULTS)):
        faulty = of_sample(triangles, seed, names)
        out += [f"faults {names}: {each}" for each in unplanned(faulty, clean) + wrong_values(faulty)]
    return out


def touching(triangles: int, seed: int = 0, makes: Iterable[str] = ()) -> list[str]:
    """Parts that come nearer to themselves than a micrometre, one of each shape; `makes`: only what these draw."""
    found, seen, wanted = [], set(), set(makes)
    drawn = SampleDrawn(triangles, seed, ())
    for part in drawn.assembly.parts.values():
        if part.shape not in seen and (not wanted or part.make.__name__ in wanted):
            seen.add(part.shape)
            mesh = drawn.solids[part.shape].mesh()
            pairs = self_contacts(mesh.vertices, mesh.faces, GRID_M * 1e3)
            if pairs:
                found.append(f"{part.path}: {len(pairs)} pairs, {min(d for _, _, d in pairs) * 1e3:.2f} um")
    return found


def main(seeds: list[int]) -> int:
    """Judges gearboxes of these seeds; returns how many findings there are."""
    wrong: list[str] = []
    for seed in seeds:
        start = time.perf_counter()
        for triangles in SIZES:
            drawn = of_sample(triangles, seed)
            least = gaps(drawn, 1e-3)
            pair, gap = min(least.items(), key=lambda item: item[1])
            print(f"seed {seed}, {triangles} triangles: {len(least)} others keep {gap * 1e3:.3f} mm: {pair}")
            wrong += too_deep(drawn) + touching(triangles, seed)
            wrong += [f"{pair} is nearer than {LEAST_GAP_M}"] if gap < LEAST_GAP_M else []
        wrong += Fits(seed).wrong(most=MOST) + wrong_faults(seed) + wrong_steps(seed)
        ways = Ways(faultless(seed))
        wrong += ways.wrong_joints()
        for step in ways.truth.steps:
            if found := ways.blocked(step):
                wrong.append(f"{step.parts[0]} is blocked by {found}")
            if step.removes and (idle := ways.superfluous(step)):
                wrong.append(f"{step.parts[0]} waits for {idle} without need")
        for fastener in ways.truth.fasteners:
            if wrong_one := ways.wrong_swing(fastener):
                wrong.append(wrong_one)
        print(f"  {len(ways.truth.steps)} steps, {time.perf_counter() - start:.0f} s")
    print("\n".join(wrong) or "nothing is wrong")
    return len(wrong)


if __name__ == "__main__":
    sys.exit(1 if main([int(word) for word in sys.argv[1:]] or [0]) else 0)
