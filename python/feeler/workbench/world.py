"""The mock-up as it stands: what is in place, and the parts that were put down elsewhere, asked as one.

Parts put down elsewhere are a small scene of their own. Every answer is of both: a cast takes the earlier impact, a
distance the lesser. Parts and triangles are those of the mock-up throughout, whichever scene they are in.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from feeler._core import Cast
from feeler.ignored import IgnoredPairs
from feeler.mockup import Mockup, Tool
from feeler.poses import placed
from feeler.scene import CAST_TOLERANCE, Scene
from feeler.workbench import motion
from feeler.workbench.motion import Floats, Row
from feeler.workbench.protocol import DepthKind

Ints = npt.NDArray[np.int64]
Pairs = frozenset[tuple[int, int]]
"""Pairs of a tool's and a mock-up's part that are not asked."""
NO_PAIRS: Pairs = frozenset()
MOST_PLANES = 32


@dataclass(frozen=True)
class Hits:
    """What meets; false where nothing does.

    pairs: `(k, 2)` tool triangle and mock-up triangle, sorted by row. kinds: `(k,)`, `feeler.PairKind`. part_pairs:
    tool part and mock-up part, unique, sorted.
    """

    pairs: Ints
    kinds: npt.NDArray[np.uint8]
    part_pairs: tuple[tuple[int, int], ...]

    def __bool__(self) -> bool:
        return len(self.pairs) > 0

    @property
    def parts(self) -> list[int]:
        """Of the mock-up; unique, sorted."""
        return sorted({part for _, part in self.part_pairs})

    @property
    def mockup_triangles(self) -> Ints:
        """Unique, sorted."""
        return np.unique(self.pairs[:, 1])

    @property
    def tool_triangles(self) -> Ints:
        """Unique, sorted."""
        return np.unique(self.pairs[:, 0])


NO_HITS = Hits(np.empty((0, 2), np.int64), np.empty(0, np.uint8), ())


@dataclass(frozen=True)
class Impact:
    """Where a way ends: see `feeler.Cast`. tool_part: -1 where it is not known."""

    fraction: float
    pose: Floats
    point: Floats
    normal: Floats
    part: int
    tool_part: int


@dataclass(frozen=True)
class Near:
    """The least distance: metres, the two points `(3,)`, and the part of the mock-up."""

    value: float
    tool_point: Floats
    mockup_point: Floats
    part: int


@dataclass(frozen=True)
class WayOut:
    """The shortest translation found that frees the tool: metres `(3,)`, world, and its length.

    kind: "bound": there may be a shorter one; "estimate": the tool meets something there too; "exact": it only touches.
    """

    translation: Floats
    depth: float
    kind: DepthKind


@dataclass(frozen=True)
class Rows:
    """What is near, nearest first: distances `(k,)`, points `(k, 3)` on tool and mock-up, parts `(k,)`."""

    distances: Floats
    tool_points: Floats
    mockup_points: Floats
    parts: Ints


@dataclass(frozen=True)
class Planes:
    """Contact planes, deepest first: as of `feeler.Contacts`. omitted: how many more there are."""

    points: Floats
    normals: Floats
    gaps: Floats
    parts: Ints
    tool_parts: Ints
    ids: npt.NDArray[np.uint64]
    footing: Floats
    omitted: int

    def __len__(self) -> int:
        return len(self.gaps)


NO_ROWS = Rows(np.empty(0), np.empty((0, 3)), np.empty((0, 3)), np.empty(0, np.int64))
NO_PLANES = Planes(
    np.empty((0, 3)),
    np.empty((0, 3)),
    np.empty(0),
    np.empty(0, np.int64),
    np.empty(0, np.int64),
    np.empty(0, np.uint64),
    np.empty((0, 4, 3)),
    0,
)


class PartMeshes:
    """Parts of a mock-up as tools of their own, each made once. Thread-safe."""

    def __init__(self, mockup: Mockup) -> None:
        """Looks at every triangle once, so that no part has to."""
        self.mockup = mockup
        owners = mockup.part_of_face
        is_sorted = bool((owners[1:] >= owners[:-1]).all())
        self._order = None if is_sorted else np.argsort(owners, kind="stable")
        self._owners = None if is_sorted else owners
        self._first = np.concatenate([[0], np.cumsum(mockup.part_triangles, dtype=np.int64)])
        self._kept: dict[int, tuple[Tool, Ints]] = {}
        self._lying: dict[int, tuple[Row, Scene]] = {}

    def of(self, part: int) -> tuple[Tool, Ints]:
        """A part in the mock-up's frame, and which of the mock-up's triangles its triangles are."""
        if part not in self._kept:
            place = np.arange(self._first[part], self._first[part + 1])
            ids = place if self._order is None else self._order[place]
            faces, vertices = self.mockup.faces[ids], self.mockup.vertices
            used = np.unique(faces)
            used = used[used < len(vertices)]
            # What is out of range stays out of range.
            own = np.where(faces < len(vertices), np.searchsorted(used, faces), 2**32 - 1)
            name, path = self.mockup.part_names[part], self.mockup.part_paths[part]
            tool = Tool(vertices[used], own, name, part_paths=[path], source=self.mockup.source)
            self._kept[part] = (tool, ids)
        return self._kept[part]

    def owners(self, triangles: Ints) -> Ints:
        """The parts of some triangles. The mock-up's own list is made anew whenever it is asked for."""
        if self._owners is not None:
            return self._owners[triangles].astype(np.int64)
        return np.searchsorted(self._first, triangles, side="right") - 1

    def at(self, part: int, place: Row) -> tuple[Floats, Ints]:
        """Vertices and faces of a part at a `world_from_part`."""
        mesh, _ = self.of(part)
        faces = np.where(mesh.faces < len(mesh.vertices), mesh.faces.astype(np.int64), 2**32 - 1)
        return placed(mesh.vertices, motion.matrix(place), "a part that was put down"), faces

    def lying(self, part: int, place: Row) -> Scene:
        """The scene of a part alone at a `world_from_part`; each part's last one is kept."""
        kept = self._lying.get(part)
        if kept is None or kept[0] != place:
            vertices, faces = self.at(part, place)
            kept = (place, Scene(Mockup(vertices, faces, part_names=[self.mockup.part_names[part]])))
            self._lying[part] = kept
        return kept[1]


class _Body:
    """A scene, and which parts and triangles of the mock-up its own are; None: the same."""

    def __init__(self, scene: Scene, parts: Ints | None = None, triangles: Ints | None = None) -> None:
        self.scene = scene
        self._parts, self._triangles = parts, triangles
        self._own = None if parts is None else {part: own for own, part in enumerate(parts.tolist())}
        self._ignored: tuple[Any, IgnoredPairs | None] = (None, None)
        self._alone: dict[int, Scene] = {}

    def part(self, own: int) -> int:
        return own if self._parts is None else int(self._parts[own])

    def own(self, part: int) -> int | None:
        """The scene's number of a part of the mock-up; None where it is not there."""
        own = part if self._own is None else self._own.get(part)
        return own if own is not None and self.scene.part_mask[own] else None

    def alone(self, own: int) -> Scene:
        """The scene of one part of its own; kept, as it takes a look at every triangle to make one."""
        if own not in self._alone:
            self._alone[own] = self.scene.only([own])
        return self._alone[own]

    def parts(self, own: npt.NDArray[Any]) -> Ints:
        return own.astype(np.int64) if self._parts is None else self._parts[own]

    def triangles(self, own: npt.NDArray[Any]) -> Ints:
        return own.astype(np.int64) if self._triangles is None else self._triangles[own]

    def ignoring(self, tool: Tool, pairs: Pairs) -> IgnoredPairs | None:
        if not pairs:
            return None
        key = (id(tool), pairs)
        if self._ignored[0] != key:
            rows = [(ours, own) for ours, part in pairs if (own := self.own(part)) is not None]
            made = IgnoredPairs(tool, self.scene.mockup, np.array(rows, dtype=np.int64)) if rows else None
            self._ignored = (key, made)
        return self._ignored[1]


class World:
    """What a tool may meet. Immutable, but for what it keeps to answer faster; for one thread at a time."""

    def __init__(self, scene: Scene, meshes: PartMeshes, moved: Mapping[int, Row], gone: Iterable[int] = ()) -> None:
        """moved: `world_from_part` of parts put down elsewhere; gone: parts that are in the hand."""
        absent = sorted({*moved, *gone})
        self._bodies = [_Body(scene.without(absent) if absent else scene)]
        self.mockup = scene.mockup
        self.moved = moved
        self._meshes = meshes
        if moved:
            self._bodies.append(_moved_body(meshes, moved))

    @property
    def in_place(self) -> Scene:
        """The scene of the parts that are where they were loaded."""
        return self._bodies[0].scene

    @property
    def put_down(self) -> Scene | None:
        """The scene of the parts that lie elsewhere."""
        return self._bodies[1].scene if len(self._bodies) > 1 else None

    def each_put_down(self) -> dict[int, Scene]:
        """The parts that lie elsewhere, each with the scene of it alone."""
        return {part: self._meshes.lying(part, place) for part, place in self.moved.items()}

    def part_of_put_down(self, own: int) -> int:
        """The part of the mock-up that a part of `put_down` is."""
        return self._bodies[1].part(own)

    def triangle_of_put_down(self, own: int) -> int:
        """The triangle of the mock-up that a triangle of `put_down` is."""
        return int(self._bodies[1].triangles(np.array([own]))[0])

    def collide(self, tool: Tool, pose: Floats) -> Hits:
        """Every pair of triangles that meets."""
        pairs, kinds = [], []
        for body in self._bodies:
            hit = body.scene.collide(tool, pose)
            if not hit:
                continue
            own = hit.pairs
            pairs.append(np.column_stack([own[:, 0].astype(np.int64), body.triangles(own[:, 1])]))
            kinds.append(hit.kinds)
        if not pairs:
            return NO_HITS
        rows, their_kinds = np.concatenate(pairs), np.concatenate(kinds)
        if len(pairs) > 1:
            order = np.lexsort((rows[:, 1], rows[:, 0]))
            rows, their_kinds = rows[order], their_kinds[order]
        return Hits(rows, their_kinds, self.part_pairs(tool, rows))

    def part_pairs(self, tool: Tool, pairs: Ints) -> tuple[tuple[int, int], ...]:
        """The tool part and mock-up part of pairs of triangles `(k, 2)`: unique, sorted."""
        count = self.mockup.part_count
        met = np.unique(tool.part_of_face[pairs[:, 0]].astype(np.int64) * count + self.owners(pairs[:, 1]))
        return tuple(divmod(each, count) for each in met.tolist())

    def owners(self, triangles: Ints) -> Ints:
        """The parts of some triangles of the mock-up."""
        return self._meshes.owners(triangles)

    def is_colliding(self, tool: Tool, pose: Floats, ignore: Pairs = NO_PAIRS) -> bool:
        """Whether anything meets."""
        return any(body.scene.is_colliding(tool, pose, ignore=body.ignoring(tool, ignore)) for body in self._bodies)

    def cast(
        self, tool: Tool, start: Floats, end: Floats, ignore: Pairs = NO_PAIRS, tolerance: float = CAST_TOLERANCE
    ) -> Impact | None:
        """The first impact on the way; None if it is free."""
        first: tuple[Cast, int] | None = None
        for body in self._bodies:
            hit = body.scene.cast(tool, start, end, tolerance=tolerance, ignore=body.ignoring(tool, ignore))
            if hit is not None and (first is None or hit.fraction < first[0].fraction):
                first = (hit, body.part(hit.part))
        if first is None:
            return None
        hit, part = first
        return Impact(hit.fraction, hit.pose, hit.point, hit.normal, part, hit.tool_part)

    def distance(self, tool: Tool, pose: Floats, within: float, ignore: Pairs = NO_PAIRS) -> Near | None:
        """The least distance; None where nothing is as near as `within`."""
        best: Near | None = None
        for body in self._bodies:
            near = body.scene.distance(tool, pose, within, ignore=body.ignoring(tool, ignore))
            if near.part is None or near.point_on_tool is None or near.point_on_mockup is None:
                continue
            if best is None or near.value < best.value:
                best = Near(near.value, near.point_on_tool, near.point_on_mockup, body.part(near.part))
                within = near.value
        return best

    def is_near(self, tool: Tool, pose: Floats, pair: tuple[int, int], within: float) -> bool:
        """Whether a part of the tool and one of the mock-up are as near as `within`."""
        ours, part = pair
        others = frozenset((other, part) for other in range(tool.part_count) if other != ours)
        for body in self._bodies:
            own = body.own(part)
            if own is None:
                continue
            return body.alone(own).distance(tool, pose, within, ignore=body.ignoring(tool, others)).part is not None
        return False

    def is_containing(self, tool: Tool, pose: Floats) -> bool:
        """Whether the tool is inside something, or something inside it."""
        return any(bool(body.scene.containment(tool, pose)) for body in self._bodies)

    def way_out(self, tool: Tool, pose: Floats, margin: float) -> WayOut | None:
        """How deep the tool is in what it meets, or is inside of; None where it is in nothing.

        Whichever side it came from: a tool that is all but through a sheet is near its way out. Of parts in place and
        parts that lie elsewhere it is the longer way; "estimate" where the other is then met.
        """
        deepest: WayOut | None = None
        for body in self._bodies:
            found = body.scene.penetration(tool, pose, margin)
            if found.depth > (0.0 if deepest is None else deepest.depth):
                deepest = WayOut(found.translation, found.depth, cast(DepthKind, found.kind))
        if deepest is None or deepest.kind == "estimate" or len(self._bodies) == 1:
            return deepest
        moved = pose.copy()
        moved[:3, 3] += deepest.translation
        return replace(deepest, kind="estimate") if self.is_colliding(tool, moved) else deepest

    def clearance(self, tool: Tool, pose: Floats, within: float) -> Rows:
        """The parts nearer than `within`, nearest first."""
        rows = []
        for body in self._bodies:
            near = body.scene.clearance(tool, pose, within)
            if len(near):
                rows.append((near.distances, near.points_on_tool, near.points_on_mockup, body.parts(near.parts)))
        if not rows:
            return NO_ROWS
        distances, ours, theirs, parts = (np.concatenate(column) for column in zip(*rows, strict=True))
        order = np.argsort(distances, kind="stable")
        return Rows(distances[order], ours[order], theirs[order], parts[order])

    def contacts(self, tool: Tool, pose: Floats, margin: float, reference: Floats | None = None) -> Planes:
        """The contact planes, deepest first, at most `MOST_PLANES`."""
        found, omitted = [], 0
        for number, body in enumerate(self._bodies):
            each = body.scene.contacts(tool, pose, margin, reference)
            omitted += each.omitted
            if len(each):
                # The two scenes number their surfaces each for itself.
                ids = each.ids ^ np.uint64(number << 63)
                parts = body.parts(each.parts)
                ours = each.tool_parts.astype(np.int64)
                found.append((each.points, each.normals, each.gaps, parts, ours, ids, each.footing))
        if not found:
            return NO_PLANES
        columns = [np.concatenate(column) for column in zip(*found, strict=True)]
        order = np.argsort(columns[2], kind="stable")
        omitted += max(0, len(order) - MOST_PLANES)
        points, normals, gaps, parts, ours, ids, footing = (column[order[:MOST_PLANES]] for column in columns)
        return Planes(points, normals, gaps, parts, ours, ids, footing, omitted)


def _moved_body(meshes: PartMeshes, moved: Mapping[int, Row]) -> _Body:
    vertices, faces, owners, triangles = [], [], [], []
    count = 0
    for own, (part, place) in enumerate(moved.items()):
        corners, indices = meshes.at(part, place)
        _, ids = meshes.of(part)
        vertices.append(corners)
        faces.append(np.where(indices < len(corners), indices + count, 2**32 - 1))
        owners.append(np.full(len(ids), own, dtype=np.int64))
        triangles.append(ids)
        count += len(corners)
    names = meshes.mockup.part_names
    mockup = Mockup(
        np.concatenate(vertices), np.concatenate(faces), np.concatenate(owners), [names[part] for part in moved]
    )
    return _Body(Scene(mockup), np.array(list(moved), dtype=np.int64), np.concatenate(triangles))
