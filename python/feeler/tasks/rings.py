"""Circlips, snap rings and E-clips: rings that are opened, or squeezed, out of their groove, and slipped off.

A ring in its groove has no rigid way. Its mesh is opened here: each corner moves away from the axis of the ring, or
towards it, by the same length, the least that clears the part with the groove. Opened, it is drawn along its axis until
it would lie free beside that part, or pushed off sideways if it is open wide enough, as E-clips are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mockup import Tool
from feeler.plan.frames import part_axes
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

FIT_TURNS = 12
"""Rounds of the fit of the axis; each weighs the faces that point past it less."""
FIT_SHARE = 1e-3
"""How far past the axis, in sizes of the ring, the weight of a face is half."""
SAME_FACE = 1e-6
"""Triangles whose normals and planes differ by less, radians and metres, are of one face."""
PLAY_M = 5e-5
"""A ring is opened by this much more than needed."""
MORE = (1.0, 1.1, 1.25)
"""Shares of the opening beside the groove that are tried along the whole way."""
BESIDE = (0.25, 0.5, 0.75, 1.0)
"""Where the opening is measured, in thicknesses of the ring along its axis."""
HALVINGS = 12
MOST_LOOKS = 400
"""Places along a way where it is asked whether the ring lies free."""
INSIDE = 0.25
"""The share of the width of a ring, from inside, where its opening is measured."""
WIDE_DEG = 60.0
"""A ring that is open by at least this angle can be pushed off sideways."""


@dataclass(frozen=True, eq=False)  # it holds arrays
class Ring:
    """The shape of a ring."""

    vertices: Floats
    faces: Ints
    middle: Floats
    axis: Floats
    inner: float
    """The least and the largest distance of its corners from the axis, metres."""
    outer: float
    thickness: float
    gap: Floats
    """Towards the middle of its opening."""
    gap_deg: float

    @property
    def width(self) -> float:
        """Across the ring, metres."""
        return self.outer - self.inner

    def opened(self, by: float) -> Tool:
        """The ring, each corner this much farther from its axis, metres; less than 0: nearer."""
        local = self.vertices - self.middle
        across = local - (local @ self.axis)[:, None] * self.axis
        radii = np.linalg.norm(across, axis=1)
        grown = np.maximum(radii + by, 0.0) / np.where(radii > 0.0, radii, 1.0)
        return Tool(self.vertices + across * (grown - 1.0)[:, None], self.faces.astype(np.uint32), name="ring")


@dataclass(frozen=True)
class Slip:
    """The name of a motion of a ring."""

    part: int
    number: int


@dataclass(frozen=True, eq=False)  # it holds arrays
class Slipping:
    """A ring that is opened and moved until it lies free beside its groove."""

    direction: tuple[float, float, float]
    travel: float
    """Metres."""
    opening: float
    """Metres at each side; less than 0: it is squeezed."""
    tool: Tool
    is_sideways: bool

    @property
    def pose(self) -> Floats:
        """Its end, (4, 4)."""
        found = np.eye(4)
        found[:3, 3] = self.travel * np.array(self.direction)
        return found

    def __str__(self) -> str:
        how = "squeezed" if self.opening < 0.0 else "opened"
        ended = "pushed off sideways" if self.is_sideways else "drawn along its axis"
        return f"the ring is {how} by {1e3 * abs(self.opening):.2g} mm all round, {ended} by {1e3 * self.travel:.3g} mm"


def ring_of(vertices: Floats, faces: Ints) -> Ring | None:
    """The ring that a mesh is; None if its corners have no hole around an axis."""
    if len(vertices) < 6 or len(faces) < 8:
        return None
    corners = vertices[faces]
    axis = np.linalg.eigh(np.cov((vertices - vertices.mean(axis=0)).T))[1][:, 0]
    flat = [line for line in part_axes(corners) if abs(float(line @ axis)) > 0.98]
    axis = flat[0] * np.sign(flat[0] @ axis) if flat else axis
    middle = _middle(corners, axis)
    along = (vertices - middle) @ axis
    middle = middle + 0.5 * (along.min() + along.max()) * axis
    across = (vertices - middle) - ((vertices - middle) @ axis)[:, None] * axis
    radii = np.linalg.norm(across, axis=1)
    inner, outer, thickness = float(radii.min()), float(radii.max()), float(np.ptp(along))
    if not (0.0 < inner < outer and thickness > 0.0):
        return None
    gap, gap_deg = _gap(across[radii <= inner + INSIDE * (outer - inner)], axis)
    return Ring(vertices, faces, middle, axis, inner, outer, thickness, gap, gap_deg)


def _middle(corners: Floats, axis: Floats) -> Floats:
    """A point of the axis of the round faces: the lines along their normals pass through it."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normal, axis=1)
    is_side = (areas > 0.0) & (np.abs(normal @ axis) < 0.5 * areas)
    middles = corners.mean(axis=1)
    if not is_side.any():
        return np.asarray(middles.mean(axis=0))
    normal = normal[is_side] - (normal[is_side] @ axis)[:, None] * axis
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    areas, middles = areas[is_side], middles[is_side]
    normal, middles, areas = _facets(normal, middles, areas, axis)
    beside = np.cross(axis, normal)  # the distance of a line from a point is along this
    offsets = np.einsum("ij,ij->i", beside, middles)
    size = float(np.linalg.norm(np.ptp(middles, axis=0)))
    found, weights = middles.mean(axis=0), areas
    for _ in range(FIT_TURNS):
        matrix = (beside * weights[:, None]).T @ beside + 1e-9 * areas.sum() * np.outer(axis, axis)
        right = (beside * (weights * offsets)[:, None]).sum(axis=0)
        found = np.linalg.lstsq(matrix, right, rcond=None)[0]
        weights = areas / ((beside @ found - offsets) ** 2 + (FIT_SHARE * size) ** 2)
    return np.asarray(found)


def _facets(normals: Floats, middles: Floats, areas: Floats, axis: Floats) -> tuple[Floats, Floats, Floats]:
    """The triangles of one flat face as one: the middle of each alone is beside that of the face."""
    first = normals[0]
    turn = np.arctan2(normals @ np.cross(axis, first), normals @ first)
    key = np.round(np.stack([turn, np.einsum("ij,ij->i", normals, middles)]).T / SAME_FACE)
    _, index = np.unique(key, axis=0, return_inverse=True)
    index = index.reshape(-1)
    total = np.bincount(index, areas).astype(np.float64)

    def mean(rows: Floats) -> Floats:
        return np.stack([np.bincount(index, areas * rows[:, n]) / total for n in range(3)], axis=1)

    return mean(normals), mean(middles), total


def _gap(across: Floats, axis: Floats) -> tuple[Floats, float]:
    """The middle of the widest gap around an axis, a unit, and its angle, degrees."""
    first = across[0] / np.linalg.norm(across[0])
    angles = np.sort(np.arctan2(across @ np.cross(axis, first), across @ first))
    gaps = np.diff(np.concatenate([angles, angles[:1] + math.tau]))
    widest = int(np.argmax(gaps))
    at = angles[widest] + 0.5 * gaps[widest]
    return np.cos(at) * first + np.sin(at) * np.cross(axis, first), float(np.degrees(gaps[widest]))


def slippings(ring: Ring, anchor: Scene) -> Iterator[Slipping]:
    """The ways in which a ring leaves its groove. anchor: the part with the groove, alone."""
    for axis in (ring.axis, -ring.axis):
        direction = (axis + 0.0).tolist()
        found = _along(ring, anchor, (direction[0], direction[1], direction[2]))
        if found is not None:
            yield found
    if ring.gap_deg >= WIDE_DEG:
        sideways = _sideways(ring, anchor)
        if sideways is not None:
            yield sideways


def _along(ring: Ring, anchor: Scene, direction: tuple[float, float, float]) -> Slipping | None:
    """Off the groove along the axis; None where opening it does not help."""
    openings = []
    for sign in (1.0, -1.0):
        found = _opening(ring, anchor, direction, sign)
        if found is not None:
            openings.append((found, sign))
    if not openings:
        return None
    by, sign = min(openings)
    ends = _ends(ring, anchor, direction)
    for more in MORE if by > 0.0 else MORE[:1]:
        opening = sign * (more * by + PLAY_M)
        tool = ring.opened(opening)
        for end in ends:
            way = Slipping(direction, end, opening, tool, False)
            if _is_free(anchor, way, 0.5 * ring.thickness):
                return way
    return None


def _opening(ring: Ring, anchor: Scene, direction: tuple[float, float, float], sign: float) -> float | None:
    """The least opening with which a ring leaves its groove along a direction, metres; None: more than its width."""

    def is_clear(by: float) -> bool:
        tool = ring.opened(sign * by)
        return all(_is_clear(anchor, tool, _moved(direction, share * ring.thickness)) for share in BESIDE)

    low, high = 0.0, ring.width
    if is_clear(low):
        return low
    if not is_clear(high):
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_clear(middle) else (middle, high)
    return high


def _ends(ring: Ring, anchor: Scene, direction: tuple[float, float, float]) -> list[float]:
    """Where along a direction a ring that is let go lies free, as far as it does from there on; the farthest first."""
    bounds = anchor.mockup.part_bounds.reshape(-1, 2, 3)[anchor.part_mask]
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    along = np.array(direction)
    top = float(np.where(along > 0.0, high, low) @ along)
    last = max(0.0, top - float((ring.vertices @ along).min())) + PLAY_M
    step = max(0.5 * ring.thickness, last / MOST_LOOKS)
    tool = ring.opened(0.0)
    places = [n * step for n in range(1, math.ceil(last / step) + 1)]
    is_free = [_is_clear(anchor, tool, _moved(direction, at)) for at in places]
    starts = [n for n, free in enumerate(is_free) if free and (n == 0 or not is_free[n - 1])]
    return [places[n] for n in reversed(starts)] or [last]


def _sideways(ring: Ring, anchor: Scene) -> Slipping | None:
    """Off the groove away from its opening: the part with the groove passes through that."""
    along = -ring.gap
    tool, direction = ring.opened(0.0), (along + 0.0).tolist()
    way = (direction[0], direction[1], direction[2])
    half_gap = ring.inner * math.sin(math.radians(min(180.0, ring.gap_deg) / 2.0))
    opening = max(0.0, ring.inner - half_gap) + PLAY_M
    step = 0.125 * ring.outer
    for n in range(4, 33):
        if _is_clear(anchor, tool, _moved(way, n * step)):
            return Slipping(way, n * step, opening, ring.opened(opening), True)
    return None


def _moved(direction: tuple[float, float, float], by: float) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = by * np.array(direction)
    return pose


def _is_free(anchor: Scene, way: Slipping, step: float) -> bool:
    """Whether a way is free of the part with the groove: first by places on it, since a cast along it takes long."""
    count = max(1, min(MOST_LOOKS, math.ceil(way.travel / step)))
    places = (_moved(way.direction, way.travel * (n + 1) / count) for n in range(count))
    if not all(_is_clear(anchor, way.tool, place) for place in places):
        return False
    return anchor.cast(way.tool, np.eye(4), way.pose, touching="free") is None


def _is_clear(alone: Scene, tool: Tool, pose: Floats) -> bool:
    return not alone.is_colliding(tool, pose)
