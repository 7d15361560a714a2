"""What a shape looks like as a fastener: its axis, its head, its shank, its bore.

A shape is looked at along each axis about which it could be one. Its walls (triangles along the axis) are put together
by their distance from it: six directions are a hexagon, more of them a cylinder, and those that face inwards a socket
or a bore. What is beyond the head tells a bolt from a nut.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

WALL_SLOPE = 0.17
"""Sine of how far a wall may lean from the axis: 10 degrees; flanks of threads and chamfers lean more."""
SAME_RADIUS = 0.012
"""Walls at distances that differ by less than this share of the shape's radius are one body: rounded coordinates, and
drafts."""
DIRECTION_DEG = 3.0
"""Directions of walls that differ by less are one: a hexagon's are 60 degrees apart."""
LEAST_DIRECTION = 0.4
"""The least side of a hexagon, as a share of the mean one."""
ALIKE = 0.03
"""Principal values that differ by less, as a share of their sum, are alike: threads and marks make a difference."""
LEAST_BODY = 0.02
"""Bodies with a smaller share of the walls are details."""
LEAST_SYMMETRIC = 0.8
"""Share of the walls that has to belong to bodies about the axis: what has other walls is no fastener."""
TOP_SHARE = 0.25
"""How far a head's top may stand out beyond its walls, as a share of their height: chamfers and domes do, sleeves of
pipe unions stand out more."""
SHANK_SLENDER = 0.8
"""The least length of a shank, in diameters."""
THREAD_TO_FLATS = (0.3, 0.88)
"""Thread diameter by width across flats: 0.5 to 0.67 in the standards, up to 0.8 for flanged heads."""
BORE_TO_FLATS = (0.3, 0.68)
"""A nut's bore by its width across flats: at most 0.67 in the standards."""
NUT_HEIGHT = (0.15, 1.6)
"""Height by width across flats: thin nuts to long ones."""
PRISM_HEIGHT = (0.25, 1.0)
"""The same of a prism that stands for a head or a nut in a coarse mesh."""
WIDEST_WEAK_M = 0.04
"""The widest shank, and width across flats, of shapes that other things have as well: larger ones are seldom
fasteners."""
HEAD_TO_SHANK = (1.25, 2.4)
"""Diameter of a round head by its shank's: 1.5 for socket heads, 2 for pan heads."""
HEAD_HEIGHT = (0.45, 1.2)
"""Height of a round head by its shank's diameter: 1 for socket heads; heads of rivets are flatter."""


@dataclass(frozen=True)
class Looks:
    """What a shape looks like, in the frame of its corners, metres; NaN where the mesh does not show it."""

    kind: str
    """"bolt", "screw" or "nut"; where the mesh does not tell "head" (bolt or screw) or "prism" (or nut); "rod": another
    shape."""
    axis: Floats
    """Unit; out of the joint, unless `is_two_sided`."""
    top: Floats
    """On the axis, where the head or the nut ends."""
    height: float
    """From there to the other end, along the axis."""
    is_two_sided: bool
    """Whether both ends look alike, so that only what is around tells which is outside."""
    ring: float
    """Radius of a circle about the axis on which the shape bears on the joint."""
    size: float
    across_flats: float
    length: float
    head_height: float
    is_strong: bool
    """Whether hardly anything else looks so."""
    because: str


@dataclass(frozen=True)
class _Body:
    """Walls at one distance from the axis."""

    radius: float
    is_inside: bool
    directions: int
    is_hexagon: bool
    low: float
    high: float
    share: float
    """Of the area of all walls."""

    @property
    def height(self) -> float:
        return self.high - self.low


@dataclass(frozen=True)
class _View:
    """A shape along one axis."""

    bodies: list[_Body]
    z: Floats
    r: Floats

    @property
    def low(self) -> float:
        return float(self.z.min())

    @property
    def high(self) -> float:
        return float(self.z.max())

    def flipped(self) -> _View:
        """From the other end."""
        bodies = [
            _Body(b.radius, b.is_inside, b.directions, b.is_hexagon, -b.high, -b.low, b.share) for b in self.bodies
        ]
        return _View(bodies, -self.z, self.r)

    def outer(self) -> list[_Body]:
        return [b for b in self.bodies if not b.is_inside]

    def inner(self) -> list[_Body]:
        return [b for b in self.bodies if b.is_inside]

    def is_hollow(self) -> bool:
        """Whether a bore goes all the way through."""
        inner = self.inner()
        if not inner:
            return False
        return sum(b.height for b in inner) > 0.7 * (self.high - self.low)


def looks_of(vertices: Floats, faces: Ints) -> Looks | None:
    """What the shape looks like; None where like no fastener. `vertices` (n, 3), `faces` (m, 3)."""
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.sqrt(np.einsum("ij,ij->i", cross, cross))
    is_flat = double > 1e-12 * max(float(double.max(initial=0.0)), 1e-300)
    if not is_flat.any():
        return None
    corners, area, normals = corners[is_flat], double[is_flat], cross[is_flat] / double[is_flat][:, None]
    centre = np.average(corners.mean(axis=1), axis=0, weights=area)
    best: Looks | None = None
    for axis in _axes(corners, area, normals, centre):
        view = _view(corners, area, normals, centre, axis)
        if view is None:
            continue
        found = _recognised(view, axis, centre)
        if found is not None and found.is_strong:
            return found
        best = best or found
    return best


def rod_of(vertices: Floats, faces: Ints) -> Looks | None:
    """The shape as a rod or block about the axis that suits it best, for parts that a name calls a fastener.

    None where it is not about as wide in both directions across that axis.
    """
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.sqrt(np.einsum("ij,ij->i", cross, cross))
    if not area.sum() > 0:
        return None
    centre = np.average(corners.mean(axis=1), axis=0, weights=area)
    spread, axes = np.linalg.eigh(_surface_moment(corners - centre, area))
    alone = 0 if spread[1] - spread[0] > spread[2] - spread[1] else 2
    axis = axes[:, alone]
    across = np.sqrt(spread[[i for i in range(3) if i != alone]])
    if not across[0] > 0.8 * across[1]:
        return None
    offset = vertices - centre
    z = offset @ axis
    r = np.sqrt(np.maximum(np.einsum("ij,ij->i", offset, offset) - z * z, 0.0))
    # The end that is wider is the head.
    low, high = float(z.min()), float(z.max())
    upper, lower = (float(r[near].max()) for near in (z > 0.8 * high + 0.2 * low, z < 0.2 * high + 0.8 * low))
    is_two_sided = abs(upper - lower) < 0.05 * max(upper, lower)
    sign = -1.0 if not is_two_sided and lower > upper else 1.0
    top = centre + axis * (high if sign > 0 else low)
    length = high - low
    return Looks(
        *("rod", sign * axis, top, length, is_two_sided, 0.5 * min(upper, lower), 2.0 * min(upper, lower)),
        *(np.nan, length, np.nan, False, "it is as wide in both directions across its axis"),
    )


def _axes(corners: Floats, area: Floats, normals: Floats, centre: Floats) -> Iterator[Floats]:
    """Axes about which the shape may be symmetric, likely ones first.

    A shape with three equal directions or more about an axis has two equal principal values of its normals and of its
    surface, and the axis is that of the third. Where all three are alike, the directions of its largest plane faces are
    tried.
    """
    candidates: list[Floats] = []
    is_round = False
    for spread in (np.einsum("n,ni,nj->ij", area, normals, normals), _surface_moment(corners - centre, area)):
        values, vectors = np.linalg.eigh(spread)
        near, far = sorted(np.diff(values / values.sum()).tolist())
        if near > ALIKE:
            return
        if far < 2.0 * ALIKE:
            is_round = True
        candidates.append(vectors[:, 0 if values[1] - values[0] > values[2] - values[1] else 2])
    if is_round:
        planes, index = np.unique(np.round(normals, 3), axis=0, return_inverse=True)
        weight = np.bincount(index.reshape(-1), weights=area)
        candidates += [planes[i] / np.linalg.norm(planes[i]) for i in np.argsort(-weight)[:8]]
    tried: list[Floats] = []
    for axis in candidates:
        if all(abs(axis @ other) < 1.0 - 1e-4 for other in tried):
            tried.append(axis)
            yield axis


def _surface_moment(corners: Floats, area: Floats) -> Floats:
    """The second moment (3, 3) of a surface of triangles (n, 3, 3) about the origin, but for a factor."""
    total = corners.sum(axis=1)
    return np.asarray(np.einsum("n,nki,nkj->ij", area, corners, corners) + np.einsum("n,ni,nj->ij", area, total, total))


def _view(corners: Floats, area: Floats, normals: Floats, centre: Floats, axis: Floats) -> _View | None:
    """The shape along an axis; None where it is not symmetric about it."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    frame = np.stack([x, np.cross(axis, x), axis])
    points, turned = (corners - centre) @ frame.T, normals @ frame.T
    r = np.hypot(points[..., 0], points[..., 1])
    z = points[..., 2]
    wall = np.abs(turned[:, 2]) < WALL_SLOPE
    total = float(area[wall].sum())
    if not total > 0.02 * float(area.sum()):
        return None
    across = turned[wall, :2] / np.linalg.norm(turned[wall, :2], axis=1)[:, None]
    distance = np.einsum("ij,ij->i", across, points[wall].mean(axis=1)[:, :2])
    angle = np.degrees(np.arctan2(across[:, 1], across[:, 0]))
    gap = SAME_RADIUS * float(r.max())
    order = np.argsort(distance)
    groups = np.split(order, np.flatnonzero(np.diff(distance[order]) > gap) + 1)
    weights, heights = area[wall], z[wall]
    bodies = []
    for group in groups:
        body = _body(distance[group], angle[group], weights[group], heights[group], total)
        if body is not None:
            bodies.append(body)
    if sum(body.share for body in bodies) < LEAST_SYMMETRIC:
        return None
    return _View([body for body in bodies if body.share >= LEAST_BODY], z.reshape(-1), r.reshape(-1))


def _body(distance: Floats, angle: Floats, weight: Floats, heights: Floats, total: float) -> _Body | None:
    """Walls at about one distance, if they go around the axis evenly."""
    sides = np.round(angle / DIRECTION_DEG).astype(np.int64)
    # Directions of a hexagon may fall beside a border of these steps: neighbours are one.
    order = np.argsort(angle)
    new = np.flatnonzero(np.diff(angle[order]) > DIRECTION_DEG) + 1
    runs = np.split(order, new)
    if len(runs) > 1 and angle[runs[0][0]] + 360.0 - angle[runs[-1][-1]] <= DIRECTION_DEG:
        runs[0] = np.concatenate([runs.pop(), runs[0]])
    areas = np.array([weight[run].sum() for run in runs])
    turn = np.radians(angle)
    lean = abs(complex((weight * np.cos(turn)).sum(), (weight * np.sin(turn)).sum())) / weight.sum()
    if lean > 0.1:
        return None
    # A fine cylinder is one run, all around.
    count = len(np.unique(sides)) if len(runs) < 3 else len(runs)
    if count < 5:
        return None
    six = complex((weight * np.cos(6 * turn)).sum(), (weight * np.sin(6 * turn)).sum())
    is_hexagon = len(runs) == 6 and abs(six) > 0.97 * weight.sum() and areas.min() > LEAST_DIRECTION * areas.mean()
    middle = float(np.average(distance, weights=weight))
    share = float(weight.sum()) / total
    return _Body(abs(middle), middle < 0, count, is_hexagon, float(heights.min()), float(heights.max()), share)


def _recognised(view: _View, axis: Floats, centre: Floats) -> Looks | None:
    weak = None
    for sign, seen in ((1.0, view), (-1.0, view.flipped())):
        for look in (_hex_bolt, _socket_screw, _nut, _round_screw, _prism):
            found = look(seen)
            if found is None:
                continue
            kind, size, flats, length, head, ring, is_two_sided, is_strong, because = found
            out = sign * axis
            looks = Looks(
                *(kind, out, centre + out * seen.high, seen.high - seen.low, is_two_sided, ring),
                *(size, flats, length, head, is_strong, because),
            )
            if is_strong:
                return looks
            weak = weak or looks
    return weak


_Found = tuple[str, float, float, float, float, float, bool, bool, str]


def _shank(view: _View, under: float, wide: float) -> tuple[float, float] | None:
    """Radius and length of what goes on below a head that ends at `under` and whose walls are `wide` off the axis."""
    length = under - view.low
    below = view.r[view.z < under - 0.35 * length]
    if not len(below) or length <= 0:
        return None
    radius = float(below.max())
    if length < SHANK_SLENDER * 2.0 * radius or not radius < wide:
        return None
    return radius, length


def _bearing(view: _View, head: _Body, radius: float) -> float:
    """Where the head bears on the joint: the end of what is wider than the shank."""
    wide = view.z[(view.r > 1.15 * radius) & (view.z < head.high)]
    return float(wide.min()) if len(wide) else head.low


def _hex_bolt(view: _View) -> _Found | None:
    hexagons = [b for b in view.outer() if b.is_hexagon]
    if not hexagons:
        return None
    head = max(hexagons, key=lambda b: b.radius)
    if view.high - head.high > TOP_SHARE * head.height or view.is_hollow():
        return None
    shank = _shank(view, head.low, head.radius)
    if shank is None or not THREAD_TO_FLATS[0] <= shank[0] / head.radius <= THREAD_TO_FLATS[1]:
        return None
    radius = shank[0]
    bearing = _bearing(view, head, radius)
    flats, length, height = 2.0 * head.radius, bearing - view.low, view.high - bearing
    # Where the shank has six sides too, the head may as well be a round one that is cut as coarsely.
    kind = "head" if any(b.radius < 0.97 * head.radius for b in hexagons) else "bolt"
    because = f"a hexagon, {_mm(flats)} across flats, on a shank of {_mm(2.0 * radius)}"
    return kind, 2.0 * radius, flats, length, height, 0.9 * head.radius, False, True, because


def _socket_screw(view: _View) -> _Found | None:
    sockets = [b for b in view.inner() if b.is_hexagon]
    outer = view.outer()
    if not sockets or not outer or view.is_hollow():
        return None
    socket = max(sockets, key=lambda b: b.radius)
    full = view.high - view.low
    if view.high - socket.high > 0.35 * socket.height + 0.02 * full or socket.height > 0.8 * full:
        return None
    head = max(outer, key=lambda b: b.radius)
    radius = float(view.r[view.z < view.low + 0.4 * full].max())
    if not 0.2 <= socket.radius / head.radius <= 0.85:
        return None
    is_headless = radius > 0.9 * head.radius
    bearing = view.high if is_headless else _bearing(view, head, radius)
    flats = 2.0 * socket.radius
    because = f"a hexagon socket, {_mm(flats)} across flats, in a round head"
    return "screw", 2.0 * radius, flats, bearing - view.low, view.high - bearing, head.radius, False, True, because


def _nut(view: _View) -> _Found | None:
    hexagons = [b for b in view.outer() if b.is_hexagon]
    bores = [b for b in view.inner() if not b.is_hexagon or b.directions == 6]
    if not hexagons or not bores:
        return None
    body, bore = max(hexagons, key=lambda b: b.radius), min(bores, key=lambda b: b.radius)
    full = view.high - view.low
    if not BORE_TO_FLATS[0] <= float(view.r.min()) / body.radius <= BORE_TO_FLATS[1]:
        return None
    if not NUT_HEIGHT[0] <= full / (2.0 * body.radius) <= NUT_HEIGHT[1] or body.height < 0.4 * full:
        return None
    if not float(view.r.min()) > 0.6 * bore.radius:
        return None  # something closes the bore
    flats, ring = 2.0 * body.radius, 0.5 * (bore.radius + body.radius)
    size = 2.0 * float(view.r.min())
    because = f"a hexagon, {_mm(flats)} across flats, with a bore of {_mm(size)}"
    above, below = (
        float(view.r[near].max()) for near in (view.z > view.high - 0.05 * full, view.z < view.low + 0.05 * full)
    )
    is_two_sided = below < 1.1 * above
    if above > 1.1 * below:
        return None  # a flange: the other way round it is on the joint's side
    return "nut", size, flats, full, full, ring, is_two_sided, True, because


def _round_screw(view: _View) -> _Found | None:
    outer = [b for b in view.outer() if b.directions >= 5]
    if len(outer) < 2 or view.inner():
        return None
    head = max(outer, key=lambda b: b.radius)
    if view.high - head.high > 0.6 * head.height:
        return None
    shank = _shank(view, head.low, head.radius)
    if shank is None or 2.0 * shank[0] > 0.75 * WIDEST_WEAK_M:
        return None
    radius = shank[0]
    bearing = _bearing(view, head, radius)
    height = view.high - bearing
    wide = float(view.r[view.z > bearing + 0.2 * height].max())
    if not HEAD_TO_SHANK[0] <= wide / radius <= HEAD_TO_SHANK[1]:
        return None
    if not HEAD_HEIGHT[0] <= height / (2.0 * radius) <= HEAD_HEIGHT[1]:
        return None
    because = f"a round head of {_mm(2.0 * wide)} on a shank of {_mm(2.0 * radius)}"
    return "screw", 2.0 * radius, np.nan, bearing - view.low, height, 0.9 * head.radius, False, False, because


def _prism(view: _View) -> _Found | None:
    outer = view.outer()
    if len(outer) != 1 or not outer[0].is_hexagon or view.inner():
        return None
    body, full = outer[0], view.high - view.low
    if not PRISM_HEIGHT[0] <= full / (2.0 * body.radius) <= PRISM_HEIGHT[1] or body.height < 0.7 * full:
        return None
    flats = 2.0 * body.radius
    if flats > WIDEST_WEAK_M:
        return None
    return "prism", np.nan, flats, np.nan, full, 0.6 * body.radius, True, False, f"a hexagon, {_mm(flats)} across flats"


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm"
