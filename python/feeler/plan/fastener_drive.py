"""The tool that fits a recess: found from the outline of the walls that face the axis, cut across at one height."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

CUT = 0.35
"""Height of that cut, as a share of the depth from the top: below chamfers, above the cone of a drill."""
SAME = 0.015
"""Walls whose distances from the axis differ by less, as a share of the recess, are one."""
ALONG_DEG = 3.0
"""Directions of walls that differ by less are one."""
MOST_DEPTH = 0.8
"""The greatest depth of a recess, as a share of the shape's height: deeper ones are bores."""
SLIVER = 1e-3
"""Triangles with a smaller share of the walls that face the axis are ignored."""
FINE_SLIVER = 0.1
"""The same share, times the number of these walls, in fine meshes."""
OPEN = 0.1
"""How near the lower end an inner wall must come to belong to a bore open there, as a share of the shape's height."""
WIDER = 1.03
"""Radius of a wall's farthest corner, relative to the bore's, beyond which it belongs to a recess."""
TOP = 0.2
"""How far below the upper end a recess may begin, as a share of its depth, because of domes and chamfers."""
LOBES = (1.12, 1.7)
"""Radius of the lobes of a Torx recess, relative to the radius between them; 1.39 in ISO 10664."""
PRISM_SIDES = {4: "square socket", 6: "hexagon socket", 12: "12-point socket"}
CORNERS = {4: (1.3, 1.45), 6: (1.05, 1.2), 12: (1.12, 1.19)}
"""Radius of the corners of these, relative to the radius of their sides: `fastener_shape.CORNERS`."""


@dataclass(frozen=True, eq=False)
class Walls:
    """Walls of a shape along an axis, in a frame with z along it."""

    corners: Floats
    """(n, 3, 3)."""
    across: Floats
    """(n, 2): unit normals across the axis, out of the solid."""
    distance: Floats
    """(n,): from the axis, along the normal; negative where a wall faces the axis."""
    area: Floats

    def flipped(self) -> Walls:
        """Seen from the other end."""
        return Walls(self.corners * [1.0, 1.0, -1.0], self.across, self.distance, self.area)


@dataclass(frozen=True, eq=False)
class Recess:
    """A recess for a tool from above."""

    drive: str
    """"hexagon socket", "square socket", "12-point socket", "torx socket", "slot" or "cross"."""
    width: float
    """Across flats; for a slot and a cross its width; for a Torx across its points."""
    reach: float
    """Its greatest distance from the axis."""
    walls: Ints
    """The walls that belong to it."""


def recess_of(walls: Walls, low: float, high: float) -> Recess | None:
    """The recess at the upper end of a shape between `low` and `high`; None if none is recognised."""
    is_inner = walls.distance < 0.0
    # Rounded coordinates can turn slivers of plane faces in any direction.
    least = min(SLIVER, FINE_SLIVER / max(int(is_inner.sum()), 1)) * walls.area[is_inner].sum()
    inner = np.flatnonzero(is_inner & (walls.area > least))
    if not len(inner):
        return None
    inner = _beside_bore(walls, inner, low + OPEN * (high - low))
    z = walls.corners[inner][:, :, 2]
    floor, depth = float(z.min()), high - float(z.min())
    if depth > MOST_DEPTH * (high - low):
        # A second recess may lie below, from the other end.
        middle = 0.5 * (low + high)
        is_upper = z.min(axis=1) > middle
        if not is_upper.any() or (~is_upper & (z.max(axis=1) > middle)).any():
            return None
        inner, z = inner[is_upper], z[is_upper]
        floor, depth = float(z.min()), high - float(z.min())
    if high - float(z.max()) > TOP * depth:
        return None
    level = high - CUT * depth - 1e-7 * depth
    is_cut = (z.min(axis=1) < level) & (z.max(axis=1) > level)
    if not is_cut.any() or floor >= level:
        return None
    begin, end = _cut(walls.corners[inner[is_cut]], level)
    outline = Outline(begin, end, walls.across[inner[is_cut]], -walls.distance[inner[is_cut]])
    found = outline.slot() or outline.cross() or outline.prism() or outline.lobes()
    if found is None:
        return None
    drive, width = found
    return Recess(drive, width, outline.reach, inner)


def outline_at(walls: Walls, level: float) -> Outline | None:
    """The outline of the outer walls at a height; None where there are none."""
    z = walls.corners[:, :, 2]
    chosen = np.flatnonzero((walls.distance > 0.0) & (z.min(axis=1) < level) & (z.max(axis=1) > level))
    if not len(chosen):
        return None
    begin, end = _cut(walls.corners[chosen], level)
    return Outline(begin, end, walls.across[chosen], walls.distance[chosen])


def _beside_bore(walls: Walls, inner: Ints, end: float) -> Ints:
    """The inner walls without those of a bore that is open below `end` and narrower than the others.

    A recess lies outside the bore that runs into it. All inner walls if none is wider than the bore.
    """
    reach = np.linalg.norm(walls.corners[inner][..., :2], axis=2).max(axis=1)
    is_open = walls.corners[inner][..., 2].min(axis=1) < end
    if not is_open.any():
        return inner
    rest = inner[reach > WIDER * float(reach[is_open].max())]
    return rest if len(rest) else inner


def _cut(corners: Floats, level: float) -> tuple[Floats, Floats]:
    """The cut of triangles (n, 3, 3) at a height: both ends of each segment, (n, 2)."""
    height = corners[..., 2] - level
    is_alone = (height > 0) == ((height > 0).sum(axis=1) == 1)[:, None]
    alone = np.argmax(is_alone, axis=1)
    each = np.arange(len(corners))
    ends = []
    for step in (1, 2):
        other = (alone + step) % 3
        share = height[each, alone] / (height[each, alone] - height[each, other])
        ends.append(corners[each, alone, :2] + share[:, None] * (corners[each, other, :2] - corners[each, alone, :2]))
    return ends[0], ends[1]


class Outline:
    """The outline of a cut: segments, the directions of their normals, and their distances from the axis."""

    def __init__(self, begin: Floats, end: Floats, normals: Floats, distance: Floats) -> None:
        self.begin, self.end, self.distance = begin, end, np.einsum("ij,ij->i", -normals, 0.5 * (begin + end))
        self.angle = np.degrees(np.arctan2(normals[:, 1], normals[:, 0]))
        self.length = np.linalg.norm(end - begin, axis=1)
        self.normals = normals
        self.radii = np.concatenate([np.linalg.norm(begin, axis=1), np.linalg.norm(end, axis=1)])
        self.reach = float(self.radii.max())

    def _directions(self, chosen: npt.NDArray[np.bool_], count: int) -> Floats | None:
        """Length of the chosen segments in each of `count` even directions; None if some lie in other directions."""
        turn = np.radians(self.angle[chosen])
        weight = self.length[chosen]
        phase = complex((weight * np.cos(count * turn)).sum(), (weight * np.sin(count * turn)).sum())
        first = np.degrees(np.angle(phase)) / count
        steps = (self.angle[chosen] - first) * count / 360.0
        nearest = np.round(steps).astype(np.int64)
        if np.abs(steps - nearest).max() > ALONG_DEG * count / 360.0:
            return None
        return np.asarray(np.bincount(nearest % count, weights=weight, minlength=count), dtype=np.float64)

    def leans(self) -> Floats:
        """Angles from the radius to the normals of the segments, degrees, (n,), -90 to 90."""
        middle = 0.5 * (self.begin + self.end)
        ahead = self.normals[:, 1] * middle[:, 0] - self.normals[:, 0] * middle[:, 1]
        far = np.maximum(np.linalg.norm(middle, axis=1), 1e-300)
        return np.asarray(np.degrees(np.arcsin(np.clip(ahead / far, -1.0, 1.0))))

    def slot(self) -> tuple[str, float] | None:
        """Two walls that face each other."""
        lengths = self._directions(np.ones(len(self.length), dtype=bool), 2)
        half = float(np.average(self.distance, weights=self.length))
        if lengths is None or lengths.min() < 0.8 * lengths.max() or lengths.min() < 4.0 * half:
            return None
        return ("slot", 2.0 * half) if self._is_one(self.distance, half) else None

    def cross(self) -> tuple[str, float] | None:
        """Two crossed slots: walls in four directions that begin off the middle."""
        half = float(self.distance.min())
        near = self.distance < half + 0.1 * self.reach
        half = float(np.average(self.distance[near], weights=self.length[near]))
        lengths = self._directions(near, 4)
        if lengths is None or lengths.min() < 0.8 * lengths.max() or self.reach < 1.8 * half:
            return None
        nearest = min(self.radii.min(), 2.0 * half)
        if not self._is_one(self.distance[near], half) or nearest < 1.25 * half or self._is_any_over_its_foot(near):
            return None
        return "cross", 2.0 * half

    def prism(self) -> tuple[str, float] | None:
        """Flats at one distance."""
        middle = float(np.average(self.distance, weights=self.length))
        if not self._is_one(self.distance, middle):
            return None
        for count, name in PRISM_SIDES.items():
            lengths = self._directions(np.ones(len(self.length), dtype=bool), count)
            low, high = CORNERS[count]
            if lengths is None or lengths.min() < 0.4 * lengths.mean() or not low <= self.reach / middle <= high:
                continue
            return name, 2.0 * middle
        return None

    def lobes(self) -> tuple[str, float] | None:
        """Six lobes of a recess."""
        return ("torx socket", 2.0 * self.reach) if self.is_lobed(LOBES, 0.9) else None

    def is_lobed(self, ratios: tuple[float, float], alike: float) -> bool:
        """Whether far and near walls alternate twelve times around the axis.

        ratios: of the greatest and the least radius; alike: the least correlation with a wave.
        """
        points = np.concatenate([self.begin, self.end, 0.5 * (self.begin + self.end)])
        r, turn = np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
        if not ratios[0] <= self.reach / max(float(r.min()), 1e-300) <= ratios[1]:
            return False
        sixth = (turn * 6.0) % (2.0 * np.pi)
        # With all lobes laid on top of each other, they must agree, and be far at one angle.
        phase = np.angle(np.sum((r - r.mean()) * np.exp(1j * sixth)))
        model = np.cos(sixth - phase)
        if np.ptp(r) == 0.0 or np.corrcoef(model, r)[0, 1] < alike:
            return False
        steps = np.round((turn - phase / 6.0) * 3.0 / np.pi).astype(np.int64) % 6
        return len(np.unique(steps)) == 6 and len(self.length) >= 18

    def _is_one(self, distance: Floats, middle: float) -> bool:
        return bool(np.abs(distance - middle).max() <= max(SAME * self.reach, 0.01 * middle))

    def _is_any_over_its_foot(self, chosen: npt.NDArray[np.bool_]) -> bool:
        """Whether a wall contains its point nearest to the axis."""
        along = np.stack([-self.normals[chosen, 1], self.normals[chosen, 0]], axis=1)
        one = np.einsum("ij,ij->i", along, self.begin[chosen])
        other = np.einsum("ij,ij->i", along, self.end[chosen])
        slack = 0.02 * self.reach
        return bool(((np.minimum(one, other) < -slack) & (np.maximum(one, other) > slack)).any())
