"""Rolling bearings among the parts of a scene, by shape: what a mechanic takes off as one.

A row of equal balls or rollers touches parts on opposite sides that are round about its axis: its races. A race that
the row holds in both directions of the axis does not come apart from it; it belongs to the bearing, as do the cage, the
seals and all else between the rings. A race that slips off one way, such as the cup of a tapered bearing, is not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.scene import Scene
from feeler.tasks.rolling import Element, Row, rows_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

PLAY = 0.15
"""How far a race may be from an element, in radii of the element."""
SAG = 0.02
"""How far the chords of a race may be off it, in radii of the row."""
FACING_DEG = 150.0
"""Directions from an element to its two races: opposite, but for this."""
ROLLING = 0.64
"""The greatest cosine between the axis of a roller and the direction to its race: it rolls on its side."""
MOST, ROUND = 0.6, 0.85
"""The share of the elements that touch a race, and that of the rays around the axis that meet it as far away."""
FILLED = 0.3
"""Elements that other parts go into by more than this, in their radii, turn on pins, as planet wheels do."""
SHRUNK = (0.99, 0.97, 0.94, 0.9, 0.85, 0.78, 0.7)
"""Elements are so much narrower when it is asked whether a race slips off them: of these the first that is free."""
LOOSE = 1.2
"""How far a race moves until the row stops it, in radii of the element, if it is held."""
RING_RADIUS, RING_LENGTH = 2.2, 6.0
"""A ring is at most so large, in outer radii of the row, and so long, in lengths of an element. Larger parts with a
race, such as housings and shafts, are no part of a bearing."""
LANDS = 0.3
"""Seals may reach so deep into rings, as a share of their wall beside the row."""
CAGE = 1.2
"""How far a cage may reach beyond the elements along the axis, in radii of the element."""
SHARED = 0.2
"""The least share of the heights of the elements at which a cage is, too, unless it is as narrow as the elements:
circlips beside them are wider."""
AROUND_DEG = 75.0
"""The widest gap of a cage around the axis."""
_DIRECTIONS, _MOST_ELEMENTS, _PUSHED, _BETWEEN = 48, 12, 3, 4


@dataclass(frozen=True)
class Bearing:
    """Parts that leave as one."""

    lead: int
    """The part by which it is known: a ring, else the cage, else an element."""
    parts: tuple[int, ...]
    """The others, by index."""
    because: str


def bearings_of(scene: Scene, fasteners: Iterable[int] = ()) -> list[Bearing]:
    """The rolling bearings of a scene, by lead. fasteners: parts that are turned by tools, which are no part of one."""
    taken = set(fasteners)
    look = _Look(scene, taken)
    bodies = [
        body
        for row in rows_of(scene.mockup, scene.part_mask)
        if not taken & set(row.parts) and (body := look.body(row)) is not None
    ]
    return sorted((look.bearing(group) for group in _sharing(bodies)), key=lambda each: each.lead)


@dataclass(frozen=True, eq=False)
class _Body:
    """A row with what does not come apart from it."""

    row: Row
    races: tuple[int, ...]
    rings: tuple[int, ...]
    """The races that are held."""
    inside: tuple[int, ...]
    """Cage, seals and shields."""

    @property
    def parts(self) -> set[int]:
        return {*self.row.parts, *self.rings, *self.inside}


def _sharing(bodies: list[_Body]) -> list[list[_Body]]:
    """Bodies that share parts, together: double rows."""
    groups: list[list[_Body]] = []
    for body in bodies:
        same = [group for group in groups if any(each.parts & body.parts for each in group)]
        groups = [group for group in groups if group not in same]
        groups.append([*(each for group in same for each in group), body])
    return groups


class _Look:
    """Looks at the rows of a scene."""

    def __init__(self, scene: Scene, taken: set[int]) -> None:
        self.scene, self.meshes = scene, PartMeshes(scene.mockup)
        self.bounds = scene.mockup.part_bounds.reshape(-1, 2, 3)
        self.free = scene.part_mask.copy()
        self.free[sorted(taken)] = False

    def bearing(self, bodies: list[_Body]) -> Bearing:
        """Of bodies that share parts."""
        rings = sorted({ring for body in bodies for ring in body.rings}, key=lambda part: (-self._size(part), part))
        inside = sorted({part for body in bodies for part in body.inside}, key=lambda part: (-self._size(part), part))
        lead = next(iter([*rings, *inside, *bodies[0].row.parts]))
        parts = set[int]().union(*(body.parts for body in bodies)) - {lead}
        count, noun = sum(len(body.row.parts) for body in bodies), bodies[0].row.noun
        races = list(dict.fromkeys(part for body in bodies for part in body.races))
        between = " and ".join(repr(self.scene.mockup.part_paths[part]) for part in races)
        off = [part for part in races if part not in rings]
        said = f"a rolling bearing: {count} {noun} between {between}"
        if not off:
            said += " do not come apart"
        else:
            said += "; " + " and ".join(repr(self.scene.mockup.part_paths[part]) for part in off)
            said += f" come{'s' if len(off) == 1 else ''} off by {'itself' if len(off) == 1 else 'themselves'}"
        return Bearing(lead, tuple(sorted(parts)), said)

    def _size(self, part: int) -> float:
        return float(np.linalg.norm(self.bounds[part, 1] - self.bounds[part, 0]))

    def body(self, row: Row) -> _Body | None:
        """What a row is one with; None if it has no races: it is no bearing."""
        around = self._around(row)
        races = self._races(row, around)
        if not races:
            return None
        rings = tuple(part for part in races if self._is_ring(row, part) and self._is_held(row, part))
        return _Body(row, races, rings, self._inside(row, races, rings, around))

    def _around(self, row: Row) -> list[int]:
        """The parts near a row, without it."""
        own = list(row.parts)
        more = 2.0 * row.element.radius
        low, high = self.bounds[own, 0].min(axis=0) - more, self.bounds[own, 1].max(axis=0) + more
        near = (self.bounds[:, 0] <= high).all(axis=1) & (self.bounds[:, 1] >= low).all(axis=1) & self.free
        near[own] = False
        return [int(part) for part in np.flatnonzero(near)]

    def _races(self, row: Row, around: list[int]) -> tuple[int, ...]:
        """The parts that the elements roll on."""
        if not around or self._is_pinned(row, around):
            return ()
        some = _spread(len(row.parts))
        turn = np.arange(_DIRECTIONS) * (math.tau / _DIRECTIONS)
        out = row.outward()[some]
        ways = np.cos(turn)[None, :, None] * out[:, None] + np.sin(turn)[None, :, None] * row.axis
        starts = np.array([row.elements[n].middle for n in some])[:, None].repeat(_DIRECTIONS, axis=1)
        within = 4.0 * max(row.element.radius, row.element.length)
        own = self._sides(row, starts, ways, within)
        touched: dict[int, npt.NDArray[np.bool_]] = {}
        radius = row.element.radius
        for part in around:  # alone: parts may be in each other
            far = self._met([part], starts, ways, within)
            is_met = np.abs(far - own) <= PLAY * radius + SAG * row.radius
            is_by = is_met.mean(axis=0) >= MOST
            if is_by.any() and self._is_round(row, part, turn[is_by], far[:, is_by]):
                touched[part] = is_by
        races = [part for part in touched if _is_facing(turn, touched, part)]
        return tuple(sorted(part for part in races if not self._is_between(row, part, races)))

    def _is_pinned(self, row: Row, around: list[int]) -> bool:
        """Whether other parts are in the elements, as pins are in planet wheels that are drawn without a bore."""
        ways = np.cross(row.axis, row.outward())
        starts = np.array([each.middle for each in row.elements])
        both = np.concatenate([ways, -ways])
        far = self._met(around, np.concatenate([starts, starts]), both, 2.0 * row.element.radius)
        return float(np.mean(far < (1.0 - FILLED) * row.element.radius)) > 0.5

    def _sides(self, row: Row, starts: Floats, ways: Floats, within: float) -> Floats:
        """How far the sides that elements roll on are from their middles along rays, (n, directions); -infinite
        where these meet the ends of rollers."""
        radius, axes = row.element.radius, [row.elements[n].axis for n in _spread(len(row.parts))]
        far = np.full(starts.shape[:-1], radius)
        if row.element.axis is None:
            return far
        far[:] = self._met(list(row.parts), starts, ways, within).max(axis=0)
        for n, axis in enumerate(axes):
            far[n, np.abs(ways[n] @ axis) > ROLLING] = -np.inf
        return far

    def _is_between(self, row: Row, part: int, races: list[int]) -> bool:
        """Whether a part is between two others in distance from the axis and in height: a cage is no race."""
        boxes = {each: row.flat(self.meshes.mesh(each)[0]) for each in races}
        low, high = boxes[part].min(axis=0), boxes[part].max(axis=0)
        if not low[0] <= row.radius <= high[0]:
            return False
        others = [np.stack([flat.min(axis=0), flat.max(axis=0)]) for each, flat in boxes.items() if each != part]
        for one, other in combinations(others, 2):
            if (np.minimum(one[0], other[0]) < low).all() and (np.maximum(one[1], other[1]) > high).all():
                return True
        return False

    def _met(self, parts: list[int], starts: Floats, ways: Floats, within: float) -> Floats:
        """How far away rays first meet some parts; infinite: they do not."""
        hits = self.scene.only(parts).rays(starts.reshape(-1, 3), ways.reshape(-1, 3), within=within)
        far = np.where(np.asarray(hits.triangles) >= 0, np.asarray(hits.distances), np.inf)
        return np.asarray(far.reshape(starts.shape[:-1]))

    def _is_round(self, row: Row, part: int, turn: Floats, far: Floats) -> bool:
        """Whether a part is as far away between the elements as at them: no holes and no pockets. far: (n, k), from
        elements in the directions of turn, (k,)."""
        least = np.median(far, axis=0)
        at, usual = float(turn[int(np.argmin(least))]), float(least.min())
        out = row.outward()
        turns = (np.arange(len(out) * _BETWEEN) + 0.37) * (math.tau / (len(out) * _BETWEEN))
        ring = np.cos(turns)[:, None] * out[0] + np.sin(turns)[:, None] * np.cross(row.axis, out[0])
        height = float((row.element.middle - row.middle) @ row.axis)
        starts = row.middle + height * row.axis + row.radius * ring
        met = self._met([part], starts, math.cos(at) * ring + math.sin(at) * row.axis, 4.0 * usual)
        return float(np.mean(np.abs(met - usual) <= PLAY * row.element.radius + SAG * row.radius)) >= ROUND

    def _is_ring(self, row: Row, part: int) -> bool:
        """Whether a part is as small as a ring of a bearing."""
        flat = row.flat(self.meshes.mesh(part)[0])
        is_narrow = flat[:, 0].max() <= RING_RADIUS * (row.radius + row.element.radius)
        length = max(2.0 * row.element.radius, row.element.length, row.radius / 2.0)
        return bool(is_narrow and np.ptp(flat[:, 1]) <= RING_LENGTH * length)

    def _is_held(self, row: Row, part: int) -> bool:
        """Whether a race is stopped by the row both ways along the axis."""
        alone = self.scene.only([part])
        some = _spread(len(row.parts), _PUSHED)
        for share in SHRUNK:
            tool = self._narrower(row, some, share)
            if not alone.is_colliding(tool, np.eye(4)):
                break
        else:
            return False
        for sign in (1.0, -1.0):
            end = np.eye(4)
            end[:3, 3] = sign * LOOSE * row.element.radius * row.axis
            if alone.cast(tool, np.eye(4), end, touching="free") is None:
                return False
        return True

    def _narrower(self, row: Row, some: list[int], share: float) -> Tool:
        """Elements of a row, each narrower about its axis, as one tool."""
        vertices, faces, count = [], [], 0
        for n in some:
            own, triangles = self.meshes.mesh(row.parts[n])
            vertices.append(_scaled(own, row.elements[n], share))
            faces.append(triangles + count)
            count += len(own)
        return Tool(np.concatenate(vertices), np.concatenate(faces).astype(np.uint32), name="row")

    def _inside(self, row: Row, races: tuple[int, ...], rings: tuple[int, ...], around: list[int]) -> tuple[int, ...]:
        """The cage, the seals and all else that is between the rings."""
        own = np.concatenate([row.flat(self.meshes.mesh(part)[0]) for part in row.parts])
        low, high = own.min(axis=0), own.max(axis=0)
        reach = CAGE * row.element.radius
        box = [low - reach, high + reach]
        flats = {part: row.flat(self.meshes.mesh(part)[0]) for part in rings}
        if len(rings) > 1:
            inner, outer = min(flat[:, 0].min() for flat in flats.values()), max(f[:, 0].max() for f in flats.values())
            ends = np.concatenate(list(flats.values()))[:, 1]
            slack = 0.02 * row.element.radius
            walls = np.array([low[0] - inner, outer - high[0]]).clip(min=0.0)
            between = [
                np.array([low[0] - (1.0 - LANDS) * walls[0], ends.min() - slack]),
                np.array([high[0] + (1.0 - LANDS) * walls[1], ends.max() + slack]),
            ]
        found = []
        for part in around:
            if part in races:
                continue
            flat = row.flat(self.meshes.mesh(part)[0])
            if len(rings) > 1:
                is_in = bool((flat >= between[0]).all() and (flat <= between[1]).all())
            else:
                is_in = bool((flat >= box[0]).all() and (flat <= box[1]).all()) and self._is_cage(row, part, low, high)
            if is_in:
                found.append(part)
        return tuple(found)

    def _is_cage(self, row: Row, part: int, low: Floats, high: Floats) -> bool:
        """Whether a part is all around the axis, between and beside the elements. low, high: these, distances from the
        axis and heights."""
        vertices = self.meshes.mesh(part)[0]
        flat = row.flat(vertices)
        first, last = flat.min(axis=0), flat.max(axis=0)
        shared = np.minimum(last, high) - np.maximum(first, low)
        is_beside = shared[1] < SHARED * (high[1] - low[1])
        if not first[0] <= row.radius <= last[0] or (is_beside and (last[0] > high[0] or first[0] < low[0])):
            return False
        local = vertices - row.middle
        first = row.outward()[0]
        turns = np.sort(np.arctan2(local @ np.cross(row.axis, first), local @ first))
        gaps = np.diff(np.concatenate([turns, turns[:1] + math.tau]))
        return bool(gaps.max() <= math.radians(AROUND_DEG))


def _spread(count: int, most: int = _MOST_ELEMENTS) -> list[int]:
    """The numbers from 0 to `count`, or `most` of them, evenly spread."""
    return sorted({n * count // min(count, most) for n in range(min(count, most))})


def _is_facing(turn: npt.NDArray[Any], touched: dict[int, npt.NDArray[np.bool_]], part: int) -> bool:
    """Whether another part is met on the opposite side."""
    own = turn[touched[part]]
    for other, is_by in touched.items():
        apart = np.abs((turn[is_by][:, None] - own + math.pi) % math.tau - math.pi)
        if other != part and apart.max() >= math.radians(FACING_DEG):
            return True
    return False


def _scaled(vertices: Floats, element: Element, share: float) -> Floats:
    local = vertices - element.middle
    along = np.zeros_like(local) if element.axis is None else (local @ element.axis)[:, None] * element.axis
    return np.asarray(element.middle + along + share * (local - along))
