"""Closed solids from loops of vertices: walls between loops, plane faces with holes, cones to a tip.

Patches share loops by index, so that a solid is closed when each loop is used twice. Patches may be laid in any
sense: `Solid.mesh` turns all of them outwards. Lengths are millimetres, as on a drawing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh import Floats, Ints, Mesh, times
from ..tessellation import stitch, strip
from .polygon import triangulated

Row = tuple[float, float]
"""Radius and height of a ring about an axis."""
Patch = tuple[Ints, Ints]
"""Triangles (m, 3) and the directed edges (k, 2) of their border."""
LEAST_PIECE_MM = 0.05
"""No arc is cut into shorter pieces: larger, and fine samples end sooner; smaller, and the vertex grid shows."""
SHOWN = 0.35
"""Chamfers are drawn where the chord is below this share of them: larger, and coarse samples have more triangles."""
PLAIN_MM = 0.9
"""Above this chord parts are drawn plain: larger, and no sample has so few triangles; smaller, and more look bare."""
PLAIN_SIDES = 4
"""Of the smallest circles of plain parts."""
GOLDEN = 0.6180339887
DECIMALS = 7
"""To which corners (millimetres) and angles are rounded where triangles are chosen: more, and the last bits of sines
could choose others on another machine."""


@dataclass(frozen=True)
class Cut:
    """How finely curves are cut: `chord` is the largest distance from an arc to its chord, in millimetres.

    `ease` (millimetres) widens every hole of a fit, for checks that must not see facets or presses.
    """

    chord: float
    ease: float = 0.0

    def arc(self, radius: float, angle: float, least: int = 1) -> int:
        """Pieces of an arc."""
        step = 2.0 * np.arccos(1.0 - min(0.5, self.chord / max(radius, 1e-9)))
        step = max(step, LEAST_PIECE_MM / max(radius, 1e-9))
        return max(least, int(np.ceil(abs(angle) / step - 1e-9)))

    def circle(self, radius: float, least: int = 8) -> int:
        """Pieces of a full circle."""
        return self.arc(radius, 2.0 * np.pi, PLAIN_SIDES if self.plain else least)

    @property
    def plain(self) -> bool:
        """Whether ribs, chamfers, fins, webs and the like are left out, and circles may have few sides."""
        return self.chord > PLAIN_MM

    def sharp(self, rows: Sequence[Row], largest: float = 1.6) -> list[Row]:
        """Rows of a profile from face to face, in plain parts without their chamfers."""
        out = list(rows)
        k = 0
        while self.plain and k + 1 < len(out):
            (r0, z0), (r1, z1) = out[k], out[k + 1]
            before, after = out[k - 1] if k else (r0 + 1.0, z0), out[k + 2] if k + 2 < len(out) else (r1 + 1.0, z1)
            if 0.0 < abs(r1 - r0) <= largest and 0.0 < abs(z1 - z0) <= largest and r0 > 0.0 and r1 > 0.0:
                if before[1] == z0 and after[0] == r1:
                    out[k : k + 2] = [(r1, z0)]
                elif before[0] == r0 and after[1] == z1:
                    out[k : k + 2] = [(r0, z1)]
            k += 1
        return out

    def shows(self, size: float) -> bool:
        """Whether an edge or groove of a size is drawn."""
        return self.chord < SHOWN * size

    def sag(self, radius: float) -> float:
        """The largest distance from a circle to its chords as `circle` cuts it, millimetres."""
        return float(radius * (1.0 - np.cos(np.pi / self.circle(radius, 6))))


class Solid:
    """A solid in the making."""

    def __init__(self) -> None:
        self._points: list[Floats] = []
        self._size = 0
        self._grids: list[tuple[Ints, frozenset[int]]] = []
        self._stitches: list[tuple[Ints, Ints, Floats | None]] = []
        self._tips: list[tuple[Ints, int]] = []
        self._faces: list[tuple[Ints, list[Ints]]] = []
        self._patches: list[Patch] = []
        self._phase = 0.0

    def loop(self, points: Floats) -> Ints:
        """New vertices (n, 3); returns their indices (n,)."""
        self._points.append(np.asarray(points, dtype=np.float64))
        self._size += len(points)
        return np.arange(self._size - len(points), self._size)

    def tube(self, rings: Floats) -> tuple[Ints, Ints]:
        """A wall over rings (k, n, 3); returns the first and the last loop."""
        count, n = rings.shape[:2]
        index = self.loop(rings.reshape(-1, 3)).reshape(count, n)
        if count > 1:
            self._grids.append((index, frozenset()))
        return index[0], index[-1]

    def wall(self, low: Ints, high: Ints, skip: Sequence[int] = (), pose: Floats | None = None) -> None:
        """A wall between two loops: of quads, without those numbered in `skip`, or stitched by the angle about z.

        `pose`: whose z axis, where it is not the part's.
        """
        if len(low) == len(high):
            self._grids.append((np.stack([low, high]), frozenset(skip)))
        else:
            self._stitches.append((low, high, pose))

    def open_wall(self, low: Ints, high: Ints, skip: Sequence[int]) -> None:
        """Takes quads out of the wall that `tube` laid between two loops."""
        for k, (rows, gone) in enumerate(self._grids):
            if rows[0, 0] == low[0] and rows[-1, 0] == high[0]:
                self._grids[k] = (rows, gone | frozenset(skip))

    def face(self, outer: Ints, *holes: Ints) -> None:
        """A plane face inside a loop, with holes."""
        self._faces.append((outer, list(holes)))

    def tip(self, loop: Ints, point: Sequence[float]) -> None:
        """A cone from a loop to a point."""
        self._tips.append((loop, int(self.loop(np.array([point]))[0])))

    def patch(self, faces: Ints, border: Ints) -> None:
        """Any other surface: its triangles (m, 3), all in one sense, and the directed edges (k, 2) of its border."""
        self._patches.append((faces, border))

    def phase(self) -> float:
        """Another angle each time, as a share of a facet: neighbouring circles are not cut at the same places."""
        self._phase = (self._phase + GOLDEN) % 1.0
        return self._phase

    def turned(self, rows: Sequence[Row], count: int, pose: Floats | None = None) -> tuple[Ints, Ints]:
        """A wall of revolution about the pose's z axis; returns its first and its last loop.

        A row of radius 0 at an end is a tip; the loop of that end is then empty.
        """
        angle = np.asarray((np.arange(count) + self.phase()) * (2.0 * np.pi / count), dtype=np.float64)
        return self.swung(rows, angle, pose)

    def swung(self, rows: Sequence[Row], angle: Floats, pose: Floats | None = None) -> tuple[Ints, Ints]:
        """As `turned`, with a vertex at each of the given angles."""
        radii, heights = np.array([row for row in rows if row[0] > 0.0]).T
        rings = np.stack(
            [
                radii[:, None] * np.cos(angle),
                radii[:, None] * np.sin(angle),
                np.broadcast_to(heights[:, None], (len(radii), len(angle))),
            ],
            axis=2,
        )
        first, last = self.tube(placed(rings, pose))
        for end, (radius, height) in ((0, rows[0]), (1, rows[-1])):
            if radius <= 0.0:
                self.tip((first, last)[end], placed(np.array([0.0, 0.0, height]), pose).tolist())
                first, last = (first[:0], last) if end == 0 else (first, last[:0])
        return first, last

    def outline(self, points: Floats, heights: Sequence[float], pose: Floats | None = None) -> tuple[Ints, Ints]:
        """Walls of a plane outline (n, 2) drawn through heights; returns the first and the last loop."""
        rings = np.stack([np.column_stack([points, np.full(len(points), z)]) for z in heights])
        return self.tube(placed(rings, pose))

    @property
    def triangle_count(self) -> int:
        """How many triangles `mesh` makes."""
        grids = sum(2 * ((len(rows) - 1) * rows.shape[1] - len(skip)) for rows, skip in self._grids)
        stitches = sum(len(a) + len(b) for a, b, _ in self._stitches)
        faces = sum(len(outer) + sum(len(hole) + 2 for hole in holes) - 2 for outer, holes in self._faces)
        others = sum(len(loop) for loop, _ in self._tips) + sum(len(triangles) for triangles, _ in self._patches)
        return int(grids + stitches + faces + others)

    def mesh(self) -> Mesh:
        """The solid, closed and counter-clockwise from outside. Raises ValueError where a loop is left open."""
        points = np.concatenate(self._points)
        patches = [
            *(_grid(rows, skip) for rows, skip in self._grids),
            *(_stitched(points, *stitched) for stitched in self._stitches),
            *(_fan(loop, tip) for loop, tip in self._tips),
            *(_face(points, outer, holes) for outer, holes in self._faces),
            *self._patches,
        ]
        signs = _senses([border for _, border in patches], len(points))
        faces = np.concatenate([f if sign > 0 else f[:, ::-1] for (f, _), sign in zip(patches, signs, strict=True)])
        used = np.unique(faces)
        if len(used) < len(points):
            renumbered = np.zeros(len(points), dtype=np.int64)
            renumbered[used] = np.arange(len(used))
            points, faces = points[used], renumbered[faces]
        a, b, c = (points[faces[:, k]] for k in range(3))
        if float((a * np.cross(b, c)).sum()) < 0.0:
            faces = faces[:, ::-1]
        return Mesh(points, faces)


def placed(points: Floats, pose: Floats | None) -> Floats:
    """Points (..., 3) at a pose (4, 4)."""
    return points if pose is None else times(points, pose[:3, :3].T) + pose[:3, 3]


def _edges(loop: Ints) -> Ints:
    return np.stack([loop, np.roll(loop, -1)], axis=1)


def _grid(rows: Ints, skip: frozenset[int]) -> Patch:
    a, b = rows[:-1], rows[1:]
    a_next, b_next = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    first = np.stack([a, a_next, b_next], axis=2)
    second = np.stack([a, b_next, b], axis=2)
    if not skip:
        border = np.concatenate([_edges(rows[0]), _edges(rows[-1])[:, ::-1]])
        return np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)]), border
    gone = np.zeros(rows.shape[1], dtype=bool)
    gone[list(skip)] = True
    kept = ~gone
    before, after = np.roll(gone, 1) & kept, np.roll(gone, -1) & kept
    border = np.concatenate(
        [
            _edges(rows[0])[kept],
            _edges(rows[1])[kept][:, ::-1],
            np.stack([rows[1], rows[0]], axis=1)[before],
            np.stack([a_next[0], b_next[0]], axis=1)[after],
        ]
    )
    return np.concatenate([first[0, kept], second[0, kept]]), border


def _stitched(points: Floats, a: Ints, b: Ints, pose: Floats | None) -> Patch:
    centre, across = (np.zeros(3), np.eye(3)[:, :2]) if pose is None else (pose[:3, 3], pose[:3, :2])
    angles = [np.round(np.arctan2(*(times(points[loop] - centre, across)).T[::-1]), DECIMALS) for loop in (a, b)]
    on_low, on_high = stitch(angles[0], angles[1])
    faces = np.concatenate(
        [
            np.stack([a[on_low[:, 0]], a[on_low[:, 1]], b[on_low[:, 2]]], axis=1),
            np.stack([a[on_high[:, 0]], b[on_high[:, 1]], b[on_high[:, 2]]], axis=1),
        ]
    )
    return faces, np.concatenate([_edges(a), _edges(b)[:, ::-1]])


def _fan(loop: Ints, tip: int) -> Patch:
    edges = _edges(loop)
    return np.column_stack([edges, np.full(len(loop), tip)]), edges


def _face(points: Floats, outer: Ints, holes: list[Ints]) -> Patch:
    normal = _newell(points[outer])
    axis = int(np.argmax(np.abs(normal)))
    keep = [(axis + 1) % 3, (axis + 2) % 3] if normal[axis] > 0.0 else [(axis + 2) % 3, (axis + 1) % 3]
    loops = [outer, *(hole[::-1] if float(times(_newell(points[hole]), normal)) > 0.0 else hole for hole in holes)]
    corners = [np.round(points[loop][:, keep], DECIMALS) for loop in loops]
    faces = strip(len(outer)) if not holes and _convex(corners[0]) else triangulated(corners)
    return np.concatenate(loops)[faces], np.concatenate([_edges(loop) for loop in loops])


def _convex(corners: Floats) -> bool:
    step = np.roll(corners, -1, axis=0) - corners
    ahead = np.roll(step, -1, axis=0)
    return bool((step[:, 0] * ahead[:, 1] - step[:, 1] * ahead[:, 0] > 1e-9).all())


def _newell(corners: Floats) -> Floats:
    centred = corners - corners[0]
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0))


def _senses(borders: list[Ints], size: int) -> list[int]:
    """By patch, 1 or -1: the senses in which patches that share an edge run along it in opposite directions."""
    edges = np.concatenate(borders)
    patch = np.repeat(np.arange(len(borders)), [len(border) for border in borders])
    key = edges.min(axis=1) * size + edges.max(axis=1)
    order = np.argsort(key, kind="stable")
    one, other = order[0::2], order[1::2]
    if len(order) % 2 or (key[one] != key[other]).any() or (key[one][1:] == key[one][:-1]).any():
        raise ValueError("a loop of the solid is not used by exactly two patches")
    same = np.where(edges[one, 0] == edges[other, 0], -1, 1)
    links = np.unique(np.stack([patch[one], patch[other], same], axis=1), axis=0)
    near: dict[int, list[tuple[int, int]]] = {}
    for a, b, sign in links.tolist():
        near.setdefault(a, []).append((b, sign))
        near.setdefault(b, []).append((a, sign))
    signs = [0] * len(borders)
    for start in range(len(borders)):  # one round for each shell
        waiting = [] if signs[start] else [start]
        signs[start] = signs[start] or 1
        while waiting:
            here = waiting.pop()
            for there, sign in near.get(here, []):
                if signs[there] == 0:
                    signs[there] = signs[here] * sign
                    waiting.append(there)
    return signs
