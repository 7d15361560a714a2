"""A clash check as a plain loop over parts, by queries that are public: the judge of the core's one pass.

Each pair whose boxes are near is asked on its own, the first part as a tool at its place, the second as the scene.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

import feeler
from feeler import Verdict
from feeler.clashes.part_meshes import PartMeshes
from feeler.clashes.table import SHAPES

HERE = np.eye(4)
KINDS = ("exact", "bound", "estimate")
NONE = 1e-6  # of a turn: what rounding makes of none
NAMES = (
    *("a", "b", "verdict", "depth", "depth_kind", "translation", "gap", "point_a", "point_b", "triangles", "box"),
    "is_open",
)


@dataclass
class Rows:
    """What the core answers."""

    rows: list[dict[str, Any]] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    is_partial: bool = False

    def __getattr__(self, name: str) -> npt.NDArray[Any]:
        if name not in NAMES:
            raise AttributeError(name)
        kind, shape = SHAPES[name]
        return np.array([row[name] for row in self.rows], dtype=kind).reshape(-1, *shape)


def clash(
    scene: feeler.Scene,
    clearance: npt.NDArray[np.float64],
    contact: npt.NDArray[np.float64],
    *,
    class_of_part: npt.NDArray[np.uint32],
    exclude: npt.NDArray[np.uint32],
    threads: int | None = None,
    progress: Callable[[float, str], object] | None = None,
) -> Rows:
    """As `feeler._core.clash`."""
    mockup = scene.mockup
    meshes = PartMeshes(mockup)
    left_out = {tuple(sorted(pair)) for pair in exclude.tolist()}
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    there = [part for part in np.flatnonzero(scene.part_mask).tolist() if bounds[part, 0, 0] <= bounds[part, 1, 0]]
    found = Rows()
    tools: dict[int, feeler.Tool] = {}
    alone: dict[int, feeler.Scene] = {}
    pairs = list(itertools.combinations(there, 2))
    try:
        for number, (a, b) in enumerate(pairs):
            if progress is not None and number % 8 == 0:
                progress(number / len(pairs), "finding parts that meet")
            classes = int(class_of_part[a]), int(class_of_part[b])
            near, touch = float(clearance[classes]), float(contact[classes])
            if near < 0 or (a, b) in left_out or _boxes_apart(bounds[a], bounds[b]) > max(near, touch):
                continue
            for part in (a, b):
                if part not in tools:
                    tools[part] = feeler.Tool.of_parts(mockup, part)
                    alone[part] = scene.only(part)
            row = pair_of(meshes, tools, alone, a, b, near, touch)
            if row is not None:
                found.rows.append(row)
    except KeyboardInterrupt:
        found.is_partial = True
    return found


def pair_of(
    meshes: PartMeshes,
    tools: dict[int, feeler.Tool],
    alone: dict[int, feeler.Scene],
    a: int,
    b: int,
    near: float,
    touch: float,
) -> dict[str, Any] | None:
    """The row of two parts, or None where nothing is to be said of them."""
    tool, scene = tools[a], alone[b]
    hit = scene.collide(tool, HERE)
    inside = scene.containment(tool, HERE)
    row: dict[str, Any] = {
        **{"a": a, "b": b, "depth": 0.0, "depth_kind": 0, "gap": 0.0, "translation": [0.0] * 3},
        **{"triangles": len(hit.pairs), "is_open": [is_open(meshes, a), is_open(meshes, b)]},
    }
    if len(hit.pairs):
        same = same_triangles(meshes.corners(a), meshes.corners(b))
        enters = same or scene.is_colliding(tool, HERE, touching="free")
        met = np.concatenate([tool.vertices[tool.faces[np.unique(hit.pairs[:, 0])]].reshape(-1, 3)])
        other = scene.mockup.vertices[scene.mockup.faces[hit.mockup_triangles]].reshape(-1, 3)
        row["box"] = [
            np.maximum(met.min(axis=0), other.min(axis=0)).tolist(),
            np.minimum(met.max(axis=0), other.max(axis=0)).tolist(),
        ]
        point = np.mean(row["box"], axis=0)
        row["point_a"] = row["point_b"] = point.tolist()
        crosses = bool((hit.kinds == feeler.PairKind.CROSSING).any())
        held = not same and not crosses and (holds(meshes, a, b) or holds(meshes, b, a))
        if enters or held:
            planes = scene.contacts(tool, HERE, 0.0)
            way = scene.penetration(tool, HERE)
            deepest = -float(planes.gaps[0]) if len(planes) and planes.gaps[0] < 0 else 0.0
            depth = deepest or way.depth
            row.update(depth=depth, depth_kind=KINDS.index(way.kind), translation=way.translation.tolist())
        if same:
            verdict = Verdict.DUPLICATE
        elif held:
            verdict = Verdict.CONTAINED
        elif enters and row["depth"] > touch:
            verdict = Verdict.CLASH
        else:
            verdict = Verdict.CONTACT
        if verdict == Verdict.CONTACT:
            row.update(depth=0.0, depth_kind=0, translation=[0.0] * 3)
        return {**row, "verdict": verdict}
    gap = scene.distance(tool, HERE)
    row.update(point_a=gap.point_on_tool.tolist(), point_b=gap.point_on_mockup.tolist())
    row["box"] = [
        np.minimum(row["point_a"], row["point_b"]).tolist(),
        np.maximum(row["point_a"], row["point_b"]).tolist(),
    ]
    if inside:
        way = scene.penetration(tool, HERE)
        row.update(depth=way.depth, depth_kind=KINDS.index(way.kind), translation=way.translation.tolist())
        return {**row, "verdict": Verdict.CONTAINED}
    row["gap"] = gap.value
    if gap.value <= touch:
        return {**row, "verdict": Verdict.CONTACT}
    return {**row, "verdict": Verdict.CLEARANCE} if gap.value <= near else None


def same_triangles(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64]) -> bool:
    """Whether both have the same triangles, by the coordinates of their corners, in whatever order."""
    if one.shape != other.shape:
        return False

    def told(corners: npt.NDArray[np.float64]) -> list[Any]:
        return sorted(tuple(sorted(map(tuple, triangle))) for triangle in (corners + 0.0).tolist())

    return told(one) == told(other)


def holds(meshes: PartMeshes, outer: int, inner: int) -> bool:
    """Whether a closed part holds another: nothing of its surface is outside, what is just behind it is inside, and
    nothing of the outer one's (a hollow's) is within it."""
    if is_open(meshes, outer):
        return False
    surface, other = meshes.corners(outer), meshes.corners(inner)
    if any(abs(winding(surface, point)) < NONE for point in points_of(other)):
        return False
    if is_open(meshes, inner):
        return any(abs(winding(surface, point)) > 1 - NONE for point in points_of(other))
    middles, normals = other.mean(axis=1), np.cross(other[:, 1] - other[:, 0], other[:, 2] - other[:, 0])
    step = 1e-4 * np.sqrt(np.linalg.norm(normals, axis=1, keepdims=True))
    behind = [middles + sign * step * normals / np.linalg.norm(normals, axis=1, keepdims=True) for sign in (-1, 1)]
    within = [point for point in np.concatenate(behind) if abs(winding(other, point)) > 1 - NONE]
    is_behind_inside = all(abs(winding(surface, point)) > 1 - NONE for point in within)
    return is_behind_inside and not any(abs(winding(other, point)) > 1 - NONE for point in points_of(surface))


def points_of(triangles: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Corners and middles."""
    return np.unique(np.concatenate([triangles.reshape(-1, 3), triangles.mean(axis=1)]), axis=0)


def winding(triangles: npt.NDArray[np.float64], point: npt.NDArray[np.float64]) -> float:
    """How often a surface goes around a point, by solid angles (van Oosterom and Strackee 1983); on it, a share."""
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("ij,ij->i", a, np.cross(b, c))
    bottom = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    # Triangles in whose plane the point is cover nothing; of those that it is on, either side is as good.
    is_flat = np.abs(top) <= 1e-12 * la * lb * lc
    return float(np.where(is_flat, 0.0, np.arctan2(top, bottom)).sum() / (2 * np.pi))


def is_open(meshes: PartMeshes, part: int) -> bool:
    """Whether an edge of the part, by the coordinates of its ends, has no partner the other way round."""
    edges: dict[Any, int] = {}
    for triangle in (meshes.corners(part) + 0.0).tolist():
        corners = [tuple(corner) for corner in triangle]
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            edges[start, end] = edges.get((start, end), 0) + 1
    return any(edges.get((end, start), 0) != count for (start, end), count in edges.items())


def _boxes_apart(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.maximum(np.maximum(one[0] - other[1], other[0] - one[1]), 0.0)))
