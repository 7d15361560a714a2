"""A clash check as a plain loop over parts: the judge of the core's one pass.

Each pair whose boxes are near is asked on its own, the first part as a tool at its place, the second as the scene.
Depths are bounded in plain Python (point_depths.py). A pair whose bounds do not decide the verdict says so.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from point_depths import Bounds, depth_bounds, distances, farthest_inside, quartered, windings

import feeler
from feeler import Verdict
from feeler.clashes.table import SHAPES
from feeler.part_meshes import PartMeshes

Corners = npt.NDArray[np.float64]

HERE = np.eye(4)
NONE = 1e-6  # of a turn: what rounding makes of none
ROUNDOFFS = 32  # units in the last place of the largest coordinate: what contact is at least
OPPOSITE = -0.9  # the cosine between the two faces of a wall
WALL_MIDDLE = 0.98  # of half a wall's thickness: from here on a point is in its middle
NAMES = (
    *("a", "b", "verdict", "depth", "depth_error", "depth_kind", "translation", "gap", "point_a", "point_b"),
    *("triangles", "box", "is_open", "is_decided"),
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
        kind, shape = (np.bool_, ()) if name == "is_decided" else SHAPES[name]
        values = [row[name].code if name == "verdict" else row[name] for row in self.rows]
        return np.array(values, dtype=kind).reshape(-1, *shape)


def clash(
    scene: feeler.Scene,
    clearance: npt.NDArray[np.float64],
    contact: npt.NDArray[np.float64],
    *,
    class_of_part: npt.NDArray[np.uint32],
    exclude: npt.NDArray[np.uint32],
    copies_within: float = 0.0,
    threads: int | None = None,
    progress: Callable[[float, str], object] | None = None,
) -> Rows:
    """As `feeler._core.clash`, but it knows no copies that a file rounded."""
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
                progress(number / len(pairs), "finding colliding parts")
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
    """The row of two parts, or None if there is nothing to report. Its depth is a lower bound, as the core's."""
    tool, scene = tools[a], alone[b]
    hit = scene.collide(tool, HERE)
    surfaces = meshes.corners(a), meshes.corners(b)
    opened = is_open(meshes, a), is_open(meshes, b)
    rounding = ROUNDOFFS * float(np.spacing(max(np.abs(surface).max() for surface in surfaces)))
    touch = max(touch, rounding)
    row: dict[str, Any] = {
        **{"a": a, "b": b, "depth": 0.0, "depth_error": 0.0, "depth_kind": 0, "gap": 0.0, "translation": [0.0] * 3},
        **{"triangles": len(hit.pairs), "is_open": [*opened], "is_decided": True},
    }
    if len(hit.pairs):
        row["box"] = box_of_meeting(tool, scene, hit)
        point = np.mean(row["box"], axis=0)
        row["point_a"] = row["point_b"] = point.tolist()
        if same_surface(*surfaces, rounding):
            return {**row, "verdict": Verdict.DUPLICATE, "translation": way_out(scene, tool)}
        crosses = bool((hit.kinds == feeler.PairKind.CROSSING).any())
        held = not crosses and (holds(meshes, a, b) or holds(meshes, b, a))
        if not held and not scene.is_colliding(tool, HERE, touching="free"):
            return {**row, "verdict": Verdict.CONTACT}
        if all(opened):
            row.update(depth=depth_by_planes(scene, tool), depth_error=np.nan, depth_kind=1)
            verdict, is_decided = (Verdict.CLASH if row["depth"] > touch else Verdict.CONTACT), True
        else:
            depth = depth_of(row, surfaces, opened)
            own = tool.vertices[tool.faces[hit.pairs[:, 0]]]
            other = scene.mockup.vertices[scene.mockup.faces[hit.pairs[:, 1]]]
            meeting, is_crossing = np.stack([own, other], axis=1), hit.kinds == feeler.PairKind.CROSSING
            verdict, is_decided = judged(depth, meeting, is_crossing, surfaces, touch, rounding)
        if held:
            verdict, is_decided = Verdict.CONTAINED, True
        if verdict != Verdict.CONTACT:
            row["translation"] = way_out(scene, tool)
        return {**row, "verdict": verdict, "is_decided": is_decided}
    gap = scene.distance(tool, HERE)
    row.update(point_a=gap.point_on_tool.tolist(), point_b=gap.point_on_mockup.tolist(), gap=gap.value)
    row["box"] = [
        np.minimum(row["point_a"], row["point_b"]).tolist(),
        np.maximum(row["point_a"], row["point_b"]).tolist(),
    ]
    if scene.containment(tool, HERE):
        depth_of(row, surfaces, opened)
        return {**row, "verdict": Verdict.CONTAINED, "translation": way_out(scene, tool)}
    if gap.value <= touch:
        return {**row, "verdict": Verdict.CONTACT}
    return {**row, "verdict": Verdict.CLEARANCE} if gap.value <= near else None


def box_of_meeting(tool: feeler.Tool, scene: feeler.Scene, hit: feeler.Collision) -> list[list[float]]:
    """The box that the triangles of both parts that meet have in common."""
    own = tool.vertices[tool.faces[np.unique(hit.pairs[:, 0])]].reshape(-1, 3)
    other = scene.mockup.vertices[scene.mockup.faces[hit.mockup_triangles]].reshape(-1, 3)
    return [
        np.maximum(own.min(axis=0), other.min(axis=0)).tolist(),
        np.minimum(own.max(axis=0), other.max(axis=0)).tolist(),
    ]


def way_out(scene: feeler.Scene, tool: feeler.Tool) -> list[float]:
    translation = scene.penetration(tool, HERE).translation
    assert translation is not None
    return [float(x) for x in translation]


def depth_by_planes(scene: feeler.Scene, tool: feeler.Tool) -> float:
    """The gap of the deepest contact plane: two open surfaces have no inside."""
    planes = scene.contacts(tool, HERE, 0.0)
    return max(0.0, -float(planes.gaps[0])) if len(planes) else 0.0


def depth_of(row: dict[str, Any], surfaces: tuple[Any, Any], opened: tuple[bool, bool]) -> Bounds:
    """Bounds of the depth of two parts, which are noted in their row."""
    depth = depth_bounds(*surfaces, closed=(not opened[0], not opened[1]), error=0.02, most=2000)
    row.update(depth=depth.low, depth_error=depth.high - depth.low, depth_kind=int(any(opened)))
    return depth


def judged(
    depth: Bounds,
    meeting: Corners,
    is_crossing: npt.NDArray[np.bool_],
    surfaces: tuple[Any, Any],
    touch: float,
    rounding: float,
) -> tuple[Verdict, bool]:
    """Whether two parts that enter each other clash, and whether the bounds of their depth decide that."""
    if depth.low > touch:
        return Verdict.CLASH, True
    if depth.high > touch:
        return Verdict.CONTACT, False
    if touch <= rounding:
        return Verdict.CONTACT, True
    # Flush walls that meet at an edge are a limit case: a little farther in they cross, farther out they do not.
    of_low, of_high = walls_cross(meeting[is_crossing], surfaces, 0), walls_cross(meeting, surfaces, 1)
    return (Verdict.CLASH if of_high else Verdict.CONTACT), of_low == of_high


def walls_cross(meeting: Corners, surfaces: tuple[Any, Any], end: int) -> bool:
    """Whether two faces cross that are faces of thin walls: each wall reaches the middle of the other.

    meeting: `(n, 2, 3, 3)`, triangles of both parts. end: which bound of the depths counts, 0: the lower, 1: the upper.
    """
    one, other = surfaces
    # The walls of a part whose middle the other surface reaches are no thicker than this.
    reached = [2.0 * farthest_inside(*pair, error=0.005)[end] / WALL_MIDDLE for pair in ((other, one), (one, other))]
    if min(reached) <= 0.0:
        return False
    for faces in meeting:
        at = point_of_both(*faces)
        walls = [thickness(surface, face, at) for surface, face in zip(surfaces, faces, strict=True)]
        if all(wall <= most for wall, most in zip(walls, reached, strict=True)):
            return True
    return False


def point_of_both(one: Corners, other: Corners) -> Corners:
    """The middle of the line that two triangles have in common; NaN if there is none."""
    ends = []
    for triangle, plane in ((one, other), (other, one)):
        normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
        heights = (triangle - plane[0]) @ normal
        for i in range(3):
            j = (i + 1) % 3
            if heights[i] * heights[j] < 0.0:
                at = triangle[i] + heights[i] / (heights[i] - heights[j]) * (triangle[j] - triangle[i])
                sides = [np.cross(normal, plane[(k + 1) % 3] - plane[k]) @ (at - plane[k]) for k in range(3)]
                if min(sides) >= 0.0:
                    ends.append(at)
    middle: Corners = np.mean(ends, axis=0) if ends else np.full(3, np.nan)
    return middle


def thickness(surface: Corners, face: Corners, at: Corners) -> float:
    """How far behind a point of a face the nearest face is that looks the other way; infinite if there is none."""
    normal = np.cross(face[1] - face[0], face[2] - face[0])
    normal /= np.linalg.norm(normal)
    step = 1e-7 * np.linalg.norm(face[1] - face[0])
    if abs(winding(surface, at - step * normal)) < 0.5:
        normal = -normal  # of a mirrored part
    least = np.inf
    for triangle in surface:
        other = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        other /= np.linalg.norm(other)
        if abs(other @ normal) >= -OPPOSITE:
            far = (at - triangle[0]) @ other / (normal @ other)
            end = at - far * normal
            sides = [np.cross(other, triangle[(k + 1) % 3] - triangle[k]) @ (end - triangle[k]) for k in range(3)]
            if far > step and min(sides) >= 0.0:
                least = min(least, far)
    return float(least)


def same_surface(one: Corners, other: Corners, within: float) -> bool:
    """Whether both have the same surface, however it is cut: by boxes, then by points of both."""
    ends = [np.array([each.min(axis=(0, 1)), each.max(axis=(0, 1))]) for each in (one, other)]
    if np.abs(ends[0] - ends[1]).max() > within:
        return False
    for surface, onto in ((one, other), (other, one)):
        for _ in range(4):
            if distances(surface.mean(axis=1), onto).max() > within + 1e-14 * np.abs(onto).max():
                return False
            surface = quartered(surface)
    return True


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
    """How often a surface goes around a point."""
    return float(windings(point[None], triangles)[0])


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
