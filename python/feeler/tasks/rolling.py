"""Rows of rolling elements: equal balls or rollers, evenly around an axis."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.part_meshes import PartMeshes
from feeler.plan.frames import part_axes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

FEWEST = 5
"""Rolling elements of a row: rings of fewer equal parts are other things."""
MOST_TRIANGLES = 20_000
LARGEST_M = 0.3
ALIKE = 0.01
"""By how much the areas and the volumes of equal parts may differ, as a share."""
CONVEX = 0.02
"""By how much a corner may be outside of a face's plane, as a share of the part's size."""
BALL = 0.04
"""By how much the distances of a ball's corners from its middle may differ, as a share."""
FULL = 0.64
"""The least volume of a ball, over that of a sphere of its area, squared: 0.67 with 16 triangles, 0.60 for a hexagonal
prism."""
FLAT, ENDS = 0.98, 0.15
"""Faces whose normals have this cosine to an axis are ends; if they have this share of the area, it is no ball."""
ROUND = 0.9
"""The least width across the axis of a roller, over the greatest: 0.92 for an octagon, 0.87 for a hexagon."""
LENGTHS = (0.25, 20.0)
"""Of rollers, over their diameter."""
ON_CIRCLE = 0.05
"""How far the middle of an element may be off the circle of its row, in radii of the element."""
EVEN = 0.2
"""By how much gaps between elements may differ, as a share."""
WIDEST_GAP = 2.5
"""A row may have one wider gap, in gaps: elements without a cage leave some room."""
MERIDIONAL = 0.1
"""The greatest cosine between the axis of a roller and the direction around the row."""
_NEIGHBOURS, _MOST_FACES, _DIRECTIONS = 8, 200, 16


@dataclass(frozen=True, eq=False)
class Element:
    """The shape of a ball or a roller, metres."""

    middle: Floats
    axis: Floats | None
    """Of a roller, a unit; None: a ball."""
    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class Row:
    """Rolling elements around an axis, metres."""

    parts: tuple[int, ...]
    elements: tuple[Element, ...]
    middle: Floats
    axis: Floats
    radius: float
    """Of the circle of the middles of the elements."""

    @property
    def element(self) -> Element:
        """One of them."""
        return self.elements[0]

    @property
    def noun(self) -> str:
        """What they are, for people."""
        return "balls" if self.element.axis is None else "rollers"

    def outward(self) -> Floats:
        """From the axis to the middle of each element, (n, 3), units."""
        across = np.array([each.middle for each in self.elements]) - self.middle
        across -= (across @ self.axis)[:, None] * self.axis
        return np.asarray(across / np.linalg.norm(across, axis=1)[:, None])

    def flat(self, points: Floats) -> Floats:
        """Points (n, 3) as distances from the axis and heights, (n, 2)."""
        local = points - self.middle
        height = local @ self.axis
        return np.stack([np.linalg.norm(local - height[:, None] * self.axis, axis=1), height], axis=1)


def rows_of(mockup: Mockup, present: Bools) -> Iterator[Row]:
    """The rows of balls and rollers among the parts of a mock-up that are present, (n,)."""
    meshes = PartMeshes(mockup)
    for group in _alike(mockup, present):
        first = element_of(*meshes.mesh(group[0]))
        if first is None:
            continue
        middles = np.array([_middle(meshes.mesh(part)[0], meshes.mesh(part)[1]) for part in group])
        for chosen, middle, axis, radius in _circles(middles, ON_CIRCLE * first.radius):
            parts = tuple(group[n] for n in chosen)
            found: list[Element | None]
            if first.axis is None:  # equal areas and volumes are enough for balls
                found = [replace(first, middle=middles[n]) for n in chosen]
            else:
                found = [element_of(*meshes.mesh(part)) for part in parts]
            elements = tuple(each for each in found if each is not None)
            row = Row(parts, elements, middle, axis, radius)
            if len(elements) == len(parts) and _is_meridional(row):
                yield row


def element_of(vertices: Floats, faces: Ints) -> Element | None:
    """The ball or roller that a mesh is: a convex body that is round about an axis; None for other shapes."""
    if len(vertices) < 8 or len(faces) < 12:
        return None
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    is_face = areas > 1e-9 * size * size
    if not is_face.any():
        return None
    corners, normals = corners[is_face], normals[is_face] / areas[is_face, None]
    middle = _middle(vertices, faces)
    some = np.unique(np.linspace(0, len(corners) - 1, _MOST_FACES).astype(np.int64))
    planes = normals[some] * np.sign(np.einsum("ij,ij->i", normals[some], corners[some, 0] - middle))[:, None]
    beyond = (vertices - middle) @ planes.T - np.einsum("ij,ij->i", planes, corners[some, 0] - middle)
    if float(beyond.max()) > CONVEX * size:
        return None
    rollers = [each for axis in part_axes(corners) if (each := _roller(vertices - middle, middle, axis)) is not None]
    far = np.linalg.norm(vertices - middle, axis=1)
    is_ball = np.ptp(far) <= BALL * far.max() and _fullness(corners - middle) >= FULL
    if is_ball and not any(each.axis is not None and _is_prism(corners, each.axis) for each in rollers):
        return Element(middle, None, float(far.max()), 2.0 * float(far.max()))
    return next(iter(rollers), None)


def _roller(local: Floats, middle: Floats, axis: Floats) -> Element | None:
    """The roller about an axis that has some corners, (n, 3) from a point of the axis."""
    along = local @ axis
    across = local - along[:, None] * axis
    radius, length = float(np.linalg.norm(across, axis=1).max()), float(np.ptp(along))
    if not (LENGTHS[0] <= 0.5 * length / radius <= LENGTHS[1] and _is_round(across, axis)):
        return None
    return Element(middle + 0.5 * float(along.min() + along.max()) * axis, axis, radius, length)


def _fullness(corners: Floats) -> float:
    """The volume in triangles (n, 3, 3), squared, over that of a sphere of their area."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area, volume = 0.5 * np.linalg.norm(across, axis=1).sum(), np.einsum("ij,ij->", corners[:, 0], across) / 6.0
    return float(36.0 * math.pi * volume**2 / area**3)


def _is_prism(corners: Floats, axis: Floats) -> bool:
    """Whether triangles (n, 3, 3) have flat ends across an axis."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    is_end = np.abs(normals @ axis) >= FLAT * areas
    return float(areas[is_end].sum()) > ENDS * float(areas.sum())


def _middle(vertices: Floats, faces: Ints) -> Floats:
    """Of the surface of a mesh."""
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = float(areas.sum())
    return np.asarray(areas @ corners.mean(axis=1) / total if total > 0.0 else vertices.mean(axis=0))


def _is_round(across: Floats, axis: Floats) -> bool:
    """Whether points across an axis, (n, 3), spread equally in all directions."""
    first = across[int(np.argmax(np.linalg.norm(across, axis=1)))]
    first = first / np.linalg.norm(first)
    turn = np.arange(_DIRECTIONS) * (math.pi / _DIRECTIONS)
    ways = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * np.cross(axis, first)
    widths = np.ptp(across @ ways.T, axis=0)
    return float(widths.min()) >= ROUND * float(widths.max())


def _alike(mockup: Mockup, present: Bools) -> Iterator[list[int]]:
    """Parts of equal areas and volumes, as many as a row has at least."""
    bounds = mockup.part_bounds.reshape(-1, 2, 3)
    sides = bounds[:, 1] - bounds[:, 0]
    is_small = present & (mockup.part_triangles >= 12) & (mockup.part_triangles <= MOST_TRIANGLES)
    is_small &= (sides.max(axis=1) <= LARGEST_M) & (sides.min(axis=1) > 0.0)
    middles = np.zeros_like(sides)  # parts without triangles have infinite bounds
    middles[is_small] = bounds[is_small].mean(axis=1)
    areas, volumes = _sizes(mockup, is_small, middles)
    some = np.flatnonzero(is_small & (volumes > 0.0))
    for by_volume in _split(some, volumes[some]):
        for group in _split(by_volume, areas[by_volume]):
            if len(group) >= FEWEST:
                yield sorted(group.tolist())


def _sizes(mockup: Mockup, is_small: Bools, middles: Floats) -> tuple[Floats, Floats]:
    """The area and the volume of some parts."""
    faces, owners = mockup.faces, mockup.part_of_face
    areas, volumes = np.zeros(len(is_small)), np.zeros(len(is_small))
    step = 1_000_000
    for begin in range(0, len(faces), step):
        own = owners[begin : begin + step]
        chosen = is_small[own] & (faces[begin : begin + step] < len(mockup.vertices)).all(axis=1)
        part = own[chosen]
        corners = mockup.vertices[faces[begin : begin + step][chosen]] - middles[part][:, None]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas += np.bincount(part, 0.5 * np.linalg.norm(across, axis=1), len(is_small))
        volumes += np.bincount(part, np.einsum("ij,ij->i", corners[:, 0], across) / 6.0, len(is_small))
    return areas, np.abs(volumes)


def _split(parts: npt.NDArray[np.intp], values: Floats) -> Iterator[npt.NDArray[np.intp]]:
    """Parts by nearly equal values."""
    order = np.argsort(values, kind="stable")
    steps = np.flatnonzero(np.diff(values[order]) > ALIKE * values[order][:-1]) + 1
    yield from np.split(parts[order], steps)


def _circles(middles: Floats, within: float) -> Iterator[tuple[Ints, Floats, Floats, float]]:
    """Circles on which points (n, 3) are evenly: the points, the middle, the axis and the radius."""
    left = np.ones(len(middles), dtype=bool)
    for first in range(len(middles)):
        if not left[first] or left.sum() < FEWEST:
            continue
        far = np.where(left, np.linalg.norm(middles - middles[first], axis=1), np.inf)
        near = [n for n in np.argsort(far, kind="stable")[1 : 1 + _NEIGHBOURS].tolist() if np.isfinite(far[n])]
        best: tuple[Ints, Floats, Floats, float] | None = None
        for pair in combinations(near, 2):
            circle = _circle(middles[[first, *pair]], within)
            if circle is None:
                continue
            chosen = np.flatnonzero(left & _is_on(middles, circle, within))
            if (
                len(chosen) >= FEWEST
                and (best is None or len(chosen) > len(best[0]))
                and _is_even(middles[chosen], circle)
            ):
                best = (chosen, *circle)
        if best is not None:
            left[best[0]] = False
            yield best


def _circle(three: Floats, within: float) -> tuple[Floats, Floats, float] | None:
    """The circle through three points: its middle, its axis and its radius; None for points on a line."""
    a, b = three[1] - three[0], three[2] - three[0]
    across = np.cross(a, b)
    square = float(across @ across)
    if square <= (within * max(float(np.linalg.norm(a)), float(np.linalg.norm(b)))) ** 2:
        return None
    middle = (np.cross(across, a) * (b @ b) + np.cross(b, across) * (a @ a)) / (2.0 * square)
    return three[0] + middle, across / math.sqrt(square), float(np.linalg.norm(middle))


def _is_on(points: Floats, circle: tuple[Floats, Floats, float], within: float) -> Bools:
    middle, axis, radius = circle
    local = points - middle
    height = local @ axis
    across = np.linalg.norm(local - height[:, None] * axis, axis=1)
    return np.asarray((np.abs(height) <= within) & (np.abs(across - radius) <= within))


def _is_even(points: Floats, circle: tuple[Floats, Floats, float]) -> bool:
    """Whether points are evenly around a circle, but for one wider gap."""
    middle, axis, radius = circle
    first = (points[0] - middle) / radius
    turns = np.sort(np.arctan2((points - middle) @ np.cross(axis, first), (points - middle) @ first))
    gaps = np.sort(np.diff(np.concatenate([turns, turns[:1] + math.tau])))
    usual = float(np.median(gaps))
    is_even = gaps[0] >= (1.0 - EVEN) * usual and gaps[-2] <= (1.0 + EVEN) * usual
    return bool(is_even and gaps[-1] <= WIDEST_GAP * usual)


def _is_meridional(row: Row) -> bool:
    """Whether the axis of each roller is in a plane with that of the row."""
    around = np.cross(row.axis, row.outward())
    return all(
        each.axis is None or abs(float(each.axis @ way)) <= MERIDIONAL
        for each, way in zip(row.elements, around, strict=True)
    )
