"""The sample gearbox judged by others: manifold3d says which parts share volume, coal how near they are and which ways
are free. `python bench/gearbox_judge.py [SEED ...]` judges whole gearboxes; the tests use its functions.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from typing import Any

import coal
import numpy as np
import numpy.typing as npt

import feeler
from feeler.samples.accessory import Fastener, Leg, Step, Truth
from feeler.samples.accessory.assembly import Assembly
from feeler.samples.accessory.build import build
from feeler.samples.accessory.sample import ROOT, placed_meshes, truth_of, volume
from feeler.samples.accessory.solid import Cut
from feeler.samples.mesh import Mesh

manifold3d = import_module("manifold3d")  # an extra, without type information

Floats = npt.NDArray[np.float64]

GRID_M = 1e-6
"""Vertices are rounded to half a micrometre: surfaces are no better known than this."""
STEP_M = 2.5e-3
"""Between the poses at which a way is sampled."""
EASE_MM = 0.12
"""By how much holes are wider when ways are judged, so that facets and presses do not count."""
FLUSH_MM3 = 0.02
"""Volume that parts which slide on each other may share, from rounding."""


@dataclass
class Drawn:
    """Meshes by path, metres, with their truth."""

    meshes: dict[str, Mesh]
    truth: Truth


def of_sample(triangles: int, seed: int = 0, faults: Iterable[str] = ()) -> Drawn:
    """The sample as users get it."""
    names = tuple(faults)
    mockup = feeler.sample("gearbox", triangles, seed, faults=names)
    starts = np.searchsorted(mockup.part_of_face, np.arange(mockup.part_count + 1))
    meshes = {}
    for part, (a, b) in enumerate(pairwise(starts)):
        faces = mockup.faces[a:b].astype(np.int64)
        low = int(faces.min())
        meshes[mockup.part_paths[part]] = Mesh(mockup.vertices[low : int(faces.max()) + 1], faces - low)
    return Drawn(meshes, feeler.sample_truth("gearbox", triangles, seed, faults=names))


def eased(seed: int, chord_mm: float = 0.06) -> Drawn:
    """The gearbox with wider holes."""
    asm: Assembly = build(Cut(chord_mm, EASE_MM), seed)
    meshes = {f"{ROOT}/{part.path}": mesh for part, mesh in placed_meshes(asm)}
    return Drawn(meshes, truth_of(asm, {path[len(ROOT) + 1 :]: volume(mesh) for path, mesh in meshes.items()}, seed))


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
        if shared > 0.0:
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


def depth_of_vertices(a: Mesh, b: Mesh) -> float:
    """How deep a vertex of one is inside the other, metres: the largest distance to its surface."""
    deepest = 0.0
    dot = coal.Sphere(1e-9)
    for points, solid in ((a, b), (b, a)):
        low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        inside = [
            p
            for p in points.vertices[((points.vertices > low) & (points.vertices < high)).all(axis=1)]
            if _is_inside(solid, p)
        ]
        model, here = bvh(solid), coal.Transform3s()
        for p in inside:
            place = coal.Transform3s()
            place.setTranslation(p)
            deepest = max(
                deepest, float(coal.distance(dot, place, model, here, coal.DistanceRequest(), coal.DistanceResult()))
            )
    return deepest


def _is_inside(mesh: Mesh, point: Floats) -> bool:
    """By the winding number."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - point for k in range(3))
    la, lb, lc = (np.sqrt((v * v).sum(axis=1)) for v in (a, b, c))
    det = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
    return bool(np.arctan2(det, below).sum() > np.pi)


def gaps(drawn: Drawn, within: float) -> dict[tuple[str, str], float]:
    """Distances, metres, of pairs that no fit names and whose boxes are within a distance, by coal."""
    named = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits}
    models = {path: bvh(mesh) for path, mesh in drawn.meshes.items()}
    here = coal.Transform3s()
    out = {}
    for a, b in near_pairs(drawn.meshes, within):
        if frozenset((a, b)) not in named:
            result = coal.DistanceResult()
            out[a, b] = float(coal.distance(models[a], here, models[b], here, coal.DistanceRequest(), result))
    return out


# --- ways -------------------------------------------------------------------------------------------------------------


def leg_pose(leg: Leg, share: float) -> Floats:
    """What a leg has moved its parts by at a share of it, (4, 4)."""
    x, y, z = leg.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = leg.angle_rad * share
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    pose = np.eye(4)
    pose[:3, :3] = turn
    point = np.array(leg.point_m)
    pose[:3, 3] = point - turn @ point + np.array(leg.axis) * leg.distance_m * share
    return pose


def shares(leg: Leg, reach: float) -> list[float]:
    """At which shares of a leg it is sampled; `reach`: how far its parts are from the axis."""
    length = max(leg.distance_m, min(abs(leg.angle_rad) * reach, 0.4))
    count = max(3, int(np.ceil(length / STEP_M)))
    first = [min(1e-4 / leg.distance_m, 0.5 / count)] if leg.distance_m else []
    return first + [k / count for k in range(1, count + 1)]


class Ways:
    """Whether the steps of a truth are free: each with only what it says it needs taken out before."""

    def __init__(self, drawn: Drawn) -> None:
        self.drawn, self.truth = drawn, drawn.truth
        self.models = {path: bvh(mesh) for path, mesh in drawn.meshes.items()}
        low, high = bounds(drawn.meshes)
        pick = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=bool)
        self.corners = dict(zip(drawn.meshes, np.where(pick[None], high[:, None], low[:, None]), strict=True))
        self.kinds = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits}
        self.threads = {frozenset((fit.a, fit.b)) for fit in drawn.truth.fits if "thread" in fit.kind}
        door = next(joint for joint in self.truth.joints if joint.name == "door")
        self.door = frozenset(door.parts)
        self.opened = leg_pose(Leg("turn", door.axis, door.point_m, 0.0, door.high), 1.0)

    def blocked(self, step: Step) -> dict[tuple[str, str], tuple[int, float]]:
        """What is in the way of a step: by moving part and other part, the leg and the share of it."""
        out, pose = set[str](), dict[str, Floats]()
        for earlier in self.truth.needed(step):
            if earlier.removes:
                out |= set(earlier.parts)
            for leg in earlier.legs:
                for path in earlier.parts:
                    pose[path] = leg_pose(leg, 1.0) @ pose.get(path, np.eye(4))
        moving = [path for path in step.parts if path not in out]
        others = [path for path in self.models if path not in out and path not in step.parts]
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
                        if (path, others[k]) not in found and self._meet(path, here, others[k], places[k]):
                            found[path, others[k]] = (number, share)
            base = leg_pose(leg, 1.0) @ base
        return found

    def _meet(self, a: str, a_pose: Floats, b: str, b_pose: Floats) -> bool:
        result = coal.CollisionResult()
        if not coal.collide(self.models[a], _at(a_pose), self.models[b], _at(b_pose), coal.CollisionRequest(), result):
            return False
        if frozenset((a, b)) not in self.kinds:
            return True
        shared = [
            manifold(Mesh(_moved(self.drawn.meshes[p].vertices, at), self.drawn.meshes[p].faces))
            for p, at in ((a, a_pose), (b, b_pose))
        ]
        return bool((shared[0] ^ shared[1]).volume() > FLUSH_MM3)

    def in_the_way(self, fastener: Fastener) -> list[str]:
        """Parts that a socket or a hexagon key on a fastener meets in its full turn, after what goes before is out."""
        step = next(step for step in self.truth.steps if fastener.path in step.parts)
        out = {path for earlier in self.truth.needed(step) if earlier.removes for path in earlier.parts}
        radius, length = tool_of(fastener)
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


def tool_of(fastener: Fastener) -> tuple[float, float]:
    """Outer radius and length of a socket or a hexagon key, metres."""
    if fastener.tool == "hex key":
        return fastener.size_m * 0.6, 40e-3
    return fastener.size_m * 0.64 + 0.7e-3, 55e-3


def _moved(points: Floats, pose: Floats) -> Floats:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def _at(pose: Floats) -> Any:
    placed = coal.Transform3s()
    placed.setRotation(pose[:3, :3])
    placed.setTranslation(pose[:3, 3])
    return placed


def main(seeds: list[int]) -> int:
    """Judges gearboxes of these seeds; returns how many findings there are."""
    wrong = 0
    for seed in seeds:
        start = time.perf_counter()
        drawn = of_sample(200_000, seed)
        named = {frozenset((fit.a, fit.b)): fit for fit in drawn.truth.fits}
        shared = shared_volumes(drawn)
        stray = [pair for pair in shared if frozenset(pair) not in named]
        deep = []
        for a, b in shared:
            fit = named.get(frozenset((a, b)))
            if fit is not None:
                depth = depth_of_vertices(drawn.meshes[a], drawn.meshes[b])
                if depth > fit.deepest_m + GRID_M:
                    deep.append((a, b, fit.kind, depth, fit.deepest_m))
        least = gaps(drawn, 1e-3)
        tight = min(least.items(), key=lambda item: item[1])
        ways = Ways(eased(seed))
        rigid = [step for step in ways.truth.steps if step.rigid]
        blocked = {step.parts[0]: found for step in rigid if (found := ways.blocked(step))}
        unreached = [f.path for f in ways.truth.fasteners if f.tool != "open-end wrench" and ways.in_the_way(f)]
        print(f"seed {seed}: {len(drawn.meshes)} parts, {len(shared)} of {len(named)} fits share volume")
        print(f"  without a name {stray}, deeper than named {deep}")
        print(f"  least gap of {len(least)} others {tight[1] * 1e3:.3f} mm {tight[0]}")
        print(f"  {len(rigid)} steps, blocked {blocked}; no tool on {unreached}; {time.perf_counter() - start:.0f} s")
        wrong += len(stray) + len(deep) + len(blocked) + len(unreached)
    return wrong


if __name__ == "__main__":
    sys.exit(1 if main([int(word) for word in sys.argv[1:]] or [0]) else 0)
