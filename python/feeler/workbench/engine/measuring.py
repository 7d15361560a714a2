"""Geometric questions that change nothing: hits of rays, snapping, distances, lengths and angles.

All of them are about visible geometry: hidden parts and parts cut away by a section do not count, and parts that were
put down elsewhere are at their new places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from feeler.poses import inverse
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import MEASURES, Document, Point, active_planes
from feeler.workbench.document.known import Measured
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.sizes import sizes_of
from feeler.workbench.engine.world import World

_PARALLEL = 1e-9
Plane = tuple[Point, float]
"""Normal and offset."""


@dataclass(frozen=True, eq=False)
class Picked:
    """The first hit of a ray. triangle, part: of the mock-up; corners: `(3, 3)`, at the triangle's present place.

    cut: the section whose fill it is, the inside of a part that it cuts; a fill has no triangle, -1.
    """

    distance: float
    point: Floats
    normal: Floats
    triangle: int
    part: int
    corners: Floats
    cut: Plane | None = None

    def to_json(self) -> dict[str, Any]:
        """In the form for the page."""
        return {
            "distance": self.distance,
            "point": self.point.tolist(),
            "normal": self.normal.tolist(),
            "part": self.part,
            "triangle": self.triangle,
        }


class Sight:
    """The visible geometry of a document: scenes without the hidden parts, made once."""

    def __init__(self, world: World, document: Document) -> None:
        self._world = world
        hidden = [part for part in document.hidden if part not in document.moved]
        in_place = world.in_place.without(hidden) if hidden else world.in_place
        there = [(part, scene) for part, scene in world.put_down.items() if part not in document.hidden]
        self._scenes: list[tuple[int | None, Scene]] = [(None, in_place), *there]
        self.planes: list[Plane] = active_planes(document)
        rows = [[*normal, offset] for normal, offset in self.planes]
        self.sections = np.array(rows, dtype=np.float64) if rows else None
        self._outlines: dict[Plane, Floats] = {}

    def pick(self, origin: Point, direction: Point) -> Picked | None:
        """The first hit of a ray; `distance` in metres, `direction` a unit vector."""
        start, way = np.array(origin), np.array(direction)
        entry = self._entry(start, way)
        seen = self._first(start, way, self.sections)
        if entry is None:
            return seen
        plane, distance = entry
        point = start + distance * way
        # The ray enters the sections' remainder inside a solid if the next face, or the last one before, is hit from
        # inside. One of them would suffice, except where parts touch: of two faces in one place either may come first.
        # The hit is then the fill.
        for met, towards in ((seen, way), (self._first(point, -way, None), -way)):
            if met is not None and _is_from_inside(met, towards):
                return Picked(distance, point, -np.array(plane[0]), -1, met.part, met.corners, plane)
        return seen

    def _first(self, origin: Floats, direction: Floats, sections: Floats | None) -> Picked | None:
        best: Picked | None = None
        for put_down, scene in self._scenes:
            rays = scene.rays(origin[None], direction[None], sections=sections)
            own = int(rays.triangles[0])
            if own < 0 or (best is not None and rays.distances[0] >= best.distance):
                continue
            triangle, part = own, int(rays.parts[0])
            if put_down is not None:
                triangle, part = self._world.triangle_of(put_down, own), put_down
            corners = scene.mockup.vertices[scene.mockup.faces[own]]
            best = Picked(float(rays.distances[0]), rays.points[0], rays.normals[0], triangle, part, corners)
        return best

    def _entry(self, origin: Floats, direction: Floats) -> tuple[Plane, float] | None:
        """The section through which a ray enters the remainder of all, and the distance; None: it begins inside, or
        misses the remainder."""
        last: tuple[Plane, float] | None = None
        leaves = math.inf
        for plane in self.planes:
            normal, offset = np.array(plane[0]), plane[1]
            before, speed = offset - float(normal @ origin), float(normal @ direction)
            if before > 0.0 and speed <= 0.0:
                return None
            if before > 0.0 and (last is None or before / speed > last[1]):
                last = (plane, before / speed)
            elif speed < 0.0:
                leaves = min(leaves, before / speed)
        return None if last is not None and last[1] > leaves else last

    def cut_lines(self, plane: Plane) -> Floats:
        """The outline of an active section, `(k, 2, 3)`, clipped by the others; computed once."""
        found = self._outlines.get(plane)
        if found is None:
            others = [each for each in self.planes if each != plane]
            found = self._outlines[plane] = clipped(*self.outline(*plane), others)[0]
        return found

    def outline(self, normal: Point, offset: float) -> tuple[Floats, list[int]]:
        """The cut of a plane through the visible geometry: segments `(k, 2, 3)`, and the part of each."""
        point = np.array(normal) * offset
        segments: list[Floats] = []
        parts: list[int] = []
        for put_down, scene in self._scenes:
            cut = scene.section(point, np.array(normal))
            segments.append(np.asarray(cut.segments, dtype=np.float64).reshape(-1, 2, 3))
            own = np.asarray(cut.parts).tolist()
            parts += own if put_down is None else [put_down] * len(own)
        return np.concatenate(segments), parts


def _is_from_inside(picked: Picked, direction: Floats) -> bool:
    a, b, c = picked.corners
    return float(np.cross(b - a, c - a) @ direction) > 0.0


def clipped(segments: Floats, parts: list[int], planes: list[Plane]) -> tuple[Floats, list[int]]:
    """Segments `(k, 2, 3)` clipped by planes `(normal, offset)`, and the part of each."""
    owners = np.array(parts, dtype=np.int64)
    for normal, offset in planes:
        heights = segments @ np.array(normal) - offset
        kept = (heights > 0.0).any(axis=1)
        segments, heights, owners = segments[kept].copy(), heights[kept], owners[kept]
        for end in (0, 1):
            below = heights[:, end] < 0.0
            low, high = heights[below, end], heights[below, 1 - end]
            share = (low / (low - high))[:, None]
            segments[below, end] += share * (segments[below, 1 - end] - segments[below, end])
    left: list[int] = owners.tolist()
    return segments, left


def snapped(picked: Picked, within: float, sight: Sight) -> dict[str, Any]:
    """The snap of a picked point: the nearest corner, else the nearest edge, within some metres; else the point itself.

    On the fill of a section it snaps to the section's outline.
    """
    if picked.cut is not None:
        return _snapped_to_outline(picked, within, sight.cut_lines(picked.cut))
    corners, point = picked.corners, picked.point
    off = np.linalg.norm(corners - point, axis=1)
    nearest = int(off.argmin())
    found = {**picked.to_json(), "type": "face", "corners": corners.tolist()}
    if off[nearest] <= within:
        return {**found, "type": "vertex", "point": corners[nearest].tolist()}
    edges = [(corners[i], corners[(i + 1) % 3]) for i in range(3)]
    feet = [_foot(point, *edge) for edge in edges]
    offs = [float(np.linalg.norm(foot - point)) for foot in feet]
    best = int(np.argmin(offs))
    if offs[best] <= within:
        edge = [corner.tolist() for corner in edges[best]]
        return {**found, "type": "edge", "point": feet[best].tolist(), "edge": edge}
    return found


def _snapped_to_outline(picked: Picked, within: float, lines: Floats) -> dict[str, Any]:
    found = {**picked.to_json(), "type": "face", "corners": picked.corners.tolist()}
    if not len(lines):
        return found
    along = lines[:, 1] - lines[:, 0]
    squared = np.maximum((along * along).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((picked.point - lines[:, 0]) * along).sum(axis=1) / squared, 0.0, 1.0)
    feet = lines[:, 0] + share[:, None] * along
    offs = np.linalg.norm(feet - picked.point, axis=1)
    best = int(offs.argmin())
    start, end = lines[best].tolist()
    found["corners"] = [start, end, end]
    if offs[best] > within:
        return found
    return {**found, "type": "edge", "point": feet[best].tolist(), "edge": [start, end]}


def measured(given: Arguments, document: Document, scene: Scene, meshes: PartTools) -> Measured:
    """The value of a measure. Raises `WorkbenchError`.

    type "point": the distance of two `points`. "edge": its length, two `points`. "angle": `points` of three (the corner
    in the middle) or of two edges (four), or the planes of two `triangles`. "parts": the distance of two `parts`,
    computed on their triangles, with the two closest points.
    """
    kind = given.choice("type", MEASURES)
    if kind == "parts":
        return _between_parts(given, document, scene, meshes)
    if kind == "angle":
        return _angle(given, document, scene)
    points = given.points("points", 2, 2)
    return Measured(kind, points, math.dist(*points), "m", False)


def _between_parts(given: Arguments, document: Document, scene: Scene, meshes: PartTools) -> Measured:
    parts = given.parts("parts", scene.mockup.parts, most=2)
    if len(parts) != 2:
        raise given.fail("parts", "one part is named", "name two")
    gone = [scene.mockup.part_paths[part] for part in parts if part in document.absent]
    if gone:
        raise given.fail("parts", f"{gone[0]} was left out of the scene", "name a part that is there")
    held = [scene.mockup.part_paths[part] for part in parts if part in document.gripped]
    if held:
        raise given.fail("parts", f"{held[0]} is in the hand", "release it first")
    one, other = parts
    at_one, at_other = (motion.matrix(document.moved.get(part, motion.HOME)) for part in parts)
    # In the frame in which the first one is at its loaded place, so that the scene's own index answers.
    near = scene.only([one]).distance(meshes.of(other)[0], inverse(at_one) @ at_other)
    if near.point_on_mockup is None or near.point_on_tool is None:
        raise given.fail("parts", "one of the two has no triangle that can be queried", "measure another part")
    ends = [_in(at_one, near.point_on_mockup), _in(at_one, near.point_on_tool)]
    return Measured("parts", tuple(ends), near.value, "m", True, (one, other))


def _angle(given: Arguments, document: Document, scene: Scene) -> Measured:
    if given.has("triangles"):
        triangles = given.raw("triangles", list[int])
        if not isinstance(triangles, (list, tuple)) or len(triangles) != 2:
            raise given.fail("triangles", "two are needed", "pick two faces")
        normals, middles = zip(*(_plane(given, each, document, scene) for each in triangles), strict=True)
        # Planes have no direction: their angle is at most a right one.
        cosine = abs(float(normals[0] @ normals[1]))
        return Measured("angle", middles, math.acos(min(1.0, cosine)), "rad", True)
    points = given.points("points", 3, 4)
    a, b, c = (np.array(each) for each in points[:3])
    first, second = (a - b, c - b) if len(points) == 3 else (b - a, np.array(points[3]) - c)
    sizes = np.linalg.norm(first), np.linalg.norm(second)
    if min(sizes) < _PARALLEL:
        raise given.fail("points", "an edge has no length", "pick points that differ")
    # By the tangent, since a cosine is inaccurate near 0 and pi.
    angle = math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second))
    return Measured("angle", points, angle if len(points) == 3 else min(angle, math.pi - angle), "rad", False)


def _plane(given: Arguments, triangle: Any, document: Document, scene: Scene) -> tuple[Floats, Point]:
    if not isinstance(triangle, int) or not 0 <= triangle < scene.mockup.triangle_count:
        raise given.fail("triangles", f"there is no triangle {triangle!r}", "pick faces of the mock-up")
    corners = scene.mockup.vertices[scene.mockup.faces[triangle]]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    size = float(np.linalg.norm(normal))
    if not size > 0.0:
        raise given.fail("triangles", f"triangle {triangle} has no area", "pick another face")
    at = motion.matrix(document.moved.get(int(scene.mockup.part_of_face[triangle]), motion.HOME))
    return at[:3, :3] @ (normal / size), _in(at, corners.mean(axis=0))


def _foot(point: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    squared = float(along @ along)
    share = 0.0 if squared == 0.0 else min(1.0, max(0.0, float((point - start) @ along) / squared))
    foot: Floats = start + share * along
    return foot


def _in(pose: Floats, point: Floats) -> Point:
    x, y, z = (pose[:3, :3] @ point + pose[:3, 3]).tolist()
    return (x, y, z)


def part_facts(part: int, document: Document, scene: Scene) -> dict[str, Any]:
    """Facts about a part."""
    found = scene.mockup.parts[part]
    has_box = math.isfinite(found.lower[0])
    if part in document.gripped:
        state = "gripped"
    elif part in document.moved:
        state = "moved"
    else:
        state = "in place" if scene.part_mask[part] else "left out"
    sizes = sizes_of(scene.mockup, part)
    return {
        "part": part,
        "name": found.name,
        "path": found.path,
        "triangles": found.triangles,
        "lower": list(found.lower) if has_box else None,
        "upper": list(found.upper) if has_box else None,
        "is_closed": sizes.volume is not None,
        "volume": sizes.volume,
        "area": sizes.area,
        "state": state,
        "is_hidden": part in document.hidden,
        "attributes": found.attributes if scene.part_mask[part] else {},
    }
