"""Recognises fasteners by shape: axis, head, shank and bore.

The shape is examined along each axis about which it could be a fastener. Its walls (triangles along the axis) are
grouped by their distance from it. Four directions form a square, six a hexagon, twelve a 12-point hexagon; twelve or
more can also be a cylinder. Walls that face inwards are a bore or a recess (`fastener_drive`). The shape beyond the
head separates bolts from nuts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.plan.fastener_drive import Recess, Walls, recess_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

WALL_SLOPE = 0.17
"""Sine of the largest angle between a wall and the axis: 10 degrees; flanks of threads and chamfers lean more."""
SAME_RADIUS = 0.012
"""Walls whose distances differ by less than this share of the shape's radius are one body, because of rounded
coordinates and drafts."""
DIRECTION_DEG = 3.0
"""Directions of walls that differ by less are one: those of a hexagon are 60 degrees apart."""
LEAST_DIRECTION = 0.4
"""The least side of a hexagon, as a share of the mean one."""
ALIKE = 0.03
"""Principal values that differ by less, as a share of their sum, count as equal: threads and marks change them."""
LEAST_BODY = 0.02
"""Bodies with a smaller share of the walls are details."""
LEAST_GROUP = 0.002
"""Walls at one distance with a smaller share of all walls are ignored."""
LEAST_ROUND = 0.68
"""The least width across the axis, relative to the greatest: 0.71 for a square. Only wing nuts are narrower."""
LEAST_SYMMETRIC = 0.8
"""The least share of the walls in bodies about the axis: a shape with more other walls is not a fastener."""
TOP_SHARE = 0.25
"""How far a head's top may rise above its walls, as a share of their height, because of chamfers and domes; the sleeves
of pipe unions rise more."""
SHANK_SLENDER = 0.7
"""The least length of a shank, in diameters."""
CORNERS = {4: (1.3, 1.45), 6: (1.0, 1.2), 12: (1.12, 1.19)}
"""Radius of the corners, relative to that of the sides: a square, a hexagon, and two hexagons turned by 30 degrees. A
cylinder with twelve facets has 1.035; walls of slots are longer."""
PRISMS = {4: "square", 6: "hexagon", 12: "12-point"}
"""Drives with the tool on the outside."""
FLAT_SOCKETS = ("square socket", "hexagon socket", "12-point socket")
"""Recesses with a width across flats."""
SQUARE_HEAD = (0.4, 1.1)
"""Height of a square head, relative to its shank's diameter: blocks with a boss are flatter or higher."""
HEAD_HEIGHTS = (0.12, 1.5)
"""Height of a head, relative to its width across flats: 0.4 in the standards; standoffs are longer."""
SQUARE_NUT = 0.5
"""The least height of a square nut, relative to half its width: square washers are flatter."""
BODY_TO_FLATS = (0.5, 0.95)
"""Width of the body beyond a sensor's hexagon, relative to the width across flats: a wrench goes around it."""
HEADLESS_SLENDER = 0.7
"""The least length of a set screw, in diameters."""
HEADLESS_RECESS = 0.72
"""The greatest corner radius of a set screw's recess, relative to its radius: walls of tools and bushes are thinner."""
MOST_HEAD = 1.35
"""The greatest height of a round head with a recess, relative to its shank's diameter."""
MOST_HEAD_WIDTH = 3.0
"""The greatest diameter of such a head, relative to its shank's."""
SLOT_TO_HEAD = 0.25
"""The greatest width of a slot, relative to its head's diameter: 0.15 in the standards; slots of couplings are
wider."""
WING_BORE = (0.3, 0.75)
"""A wing nut's bore, relative to its hub."""
CORE = (0.75, 0.97)
"""Core diameter of a thread, relative to its shank's: 0.8 to 0.9 in the standards."""
WIDEST_STUD_M = 0.0251
"""The widest stud recognised by its two threads alone: thicker rods of this form are usually shafts."""
STUD_SLENDER = 3.0
"""The least length of a stud, in diameters."""
THREAD_TO_FLATS = (0.3, 0.88)
"""Thread diameter, relative to the width across flats: 0.5 to 0.67 in the standards, up to 0.8 for flanged heads."""
STEPPED = 1.1
"""A bore that is wider than another by this factor makes a step."""
BORE_TO_FLATS = (0.3, 0.68)
"""A nut's bore, relative to its width across flats: at most 0.67 in the standards."""
BORE_TO_12_POINT = 0.86
"""The same limit for a 12-point nut: M8 has 10 mm across flats."""
WIDEST_FLANGE = 2.0
"""The greatest radius of a nut's flange, relative to half its width across flats: 1.4 in the standards."""
NUT_HEIGHT = (0.15, 2.05)
"""Height, relative to the width across flats: thin nuts to long ones."""
PRISM_HEIGHT = (0.25, 1.0)
"""The same for a prism that represents a head or a nut in a coarse mesh."""
WIDEST_WEAK_M = 0.04
"""The widest shank, and width across flats, of ambiguous shapes: larger parts of such a shape are seldom fasteners."""
HEAD_TO_SHANK = (1.4, 2.4)
"""Diameter of a round head, relative to its shank's: 1.5 for socket heads, 2 for pan heads."""
HEAD_HEIGHT = (0.45, 1.2)
"""Height of a round head, relative to its shank's diameter: 1 for socket heads; heads of rivets are flatter."""


_TURNS = np.arange(4) * (np.pi / 4.0)
_AROUND = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=1)


@dataclass(frozen=True, eq=False)
class Looks:
    """The recognised shape, in the frame of its corners, metres; NaN if the mesh does not show a value."""

    kind: str
    """"bolt", "screw", "nut" or "stud"; if the mesh is too coarse "head" (bolt or screw) or "prism" (also nut); "rod"
    for other shapes."""
    axis: Floats
    """Unit; out of the joint, unless `is_two_sided`."""
    top: Floats
    """On the axis, at the end of the head or nut."""
    height: float
    """From there to the other end, along the axis."""
    is_two_sided: bool
    """Whether both ends look alike, so that only the surroundings show which one is outside."""
    ring: float
    """Radius of a circle about the axis on which the shape bears on the joint."""
    size: float
    across_flats: float
    length: float
    head_height: float
    is_strong: bool
    """Whether hardly any other thing has this shape."""
    because: str
    drive: str = ""
    """As `Fastener.drive`."""
    is_known_by_name: bool = False
    """Whether other things have this shape as often, so that the name decides."""


@dataclass(frozen=True)
class _Body:
    """Walls at one distance from the axis."""

    radius: float
    is_inside: bool
    directions: int
    sides: int
    """4, 6 or 12 for a square, a hexagon, or two hexagons turned by 30 degrees; 0: round."""
    low: float
    high: float
    share: float
    """Share of the area of all walls."""

    @property
    def height(self) -> float:
        return self.high - self.low


@dataclass(frozen=True, eq=False)
class _View:
    """A shape along one axis."""

    bodies: list[_Body]
    z: Floats
    """Of the corners of the triangles, along the axis, from the middle."""
    r: Floats
    across: Floats
    """(n, 2): the same corners across the axis."""
    recesses: tuple[Recess | None, Recess | None]
    """At the upper and at the lower end."""

    @property
    def low(self) -> float:
        return float(self.z.min())

    @property
    def high(self) -> float:
        return float(self.z.max())

    def flipped(self) -> _View:
        """Seen from the other end."""
        bodies = [_Body(b.radius, b.is_inside, b.directions, b.sides, -b.high, -b.low, b.share) for b in self.bodies]
        return _View(bodies, -self.z, self.r, self.across, self.recesses[::-1])

    def outer(self) -> list[_Body]:
        return [b for b in self.bodies if not b.is_inside]

    def inner(self) -> list[_Body]:
        return [b for b in self.bodies if b.is_inside]

    def is_hollow(self) -> bool:
        """Whether a bore goes right through."""
        inner, full = self.inner(), self.high - self.low
        is_open = [
            any(b.low < self.low + 0.1 * full for b in inner),
            any(b.high > self.high - 0.1 * full for b in inner),
        ]
        return all(is_open) and sum(b.height for b in inner) > 0.7 * full


def looks_of(vertices: Floats, faces: Ints) -> Looks | None:
    """The recognised shape; None if it is not like a fastener. `vertices` (n, 3), `faces` (m, 3)."""
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.sqrt(np.einsum("ij,ij->i", cross, cross))
    is_flat = double > 1e-12 * max(float(double.max(initial=0.0)), 1e-300)
    if not is_flat.any():
        return None
    corners, area, normals = corners[is_flat], double[is_flat], cross[is_flat] / double[is_flat][:, None]
    centre = np.average(corners.mean(axis=1), axis=0, weights=area)
    if float(np.einsum("ni,ni,n->", normals, corners.mean(axis=1) - centre, area)) < 0.0:
        normals = -normals  # the mesh is wound inside out
    best: Looks | None = None
    for rough in _axes(corners, area, normals, centre):
        axis = _along_walls(area, normals, rough)
        view = _view(corners, area, normals, centre, axis) if _is_round(vertices - centre, axis) else None
        if view is None:
            continue
        found = _recognised(view, axis, centre)
        if found is not None and found.is_strong:
            return found
        best = best or found
    return best


def rod_of(vertices: Floats, faces: Ints) -> Looks | None:
    """The shape as a rod or block about its best axis, for parts that a name calls a fastener.

    None if its widths across that axis differ too much.
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
    # The wider end is the head.
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
    """Axes about which the shape may be a fastener, likely ones first.

    A shape with three or more equal directions about an axis has two equal principal values of its normals and of its
    surface; the axis is that of the third. With a slot or wings the axis is still a principal one. If values are equal,
    the directions of the largest plane faces are tried.
    """
    candidates: list[Floats] = []
    others: list[Floats] = []
    is_round = False
    for spread in (np.einsum("n,ni,nj->ij", area, normals, normals), _surface_moment(corners - centre, area)):
        values, vectors = np.linalg.eigh(spread)
        near, far = sorted(np.diff(values / values.sum()).tolist())
        is_round = is_round or far < 2.0 * ALIKE
        alone = 0 if values[1] - values[0] > values[2] - values[1] else 2
        (candidates if near <= ALIKE else others).append(vectors[:, alone])
        others += [vectors[:, i] for i in range(3) if i != alone]
    if is_round:
        planes, index = np.unique(np.round(normals, 3), axis=0, return_inverse=True)
        weight = np.bincount(index.reshape(-1), weights=area)
        candidates += [planes[i] / np.linalg.norm(planes[i]) for i in np.argsort(-weight)[:8]]
    tried: list[Floats] = []
    for axis in [*candidates, *others]:
        if all(abs(axis @ other) < 1.0 - 1e-4 for other in tried):
            tried.append(axis)
            yield axis


def _along_walls(area: Floats, normals: Floats, axis: Floats) -> Floats:
    """An axis moved to be along the walls about it: moments of a few long triangles may be some degrees off."""
    for _ in range(3):
        wall = np.abs(normals @ axis) < WALL_SLOPE
        values, vectors = np.linalg.eigh(np.einsum("n,ni,nj->ij", area[wall], normals[wall], normals[wall]))
        best = vectors[:, 0] * np.sign(vectors[:, 0] @ axis)
        if values[0] > 0.1 * values[1] or best @ axis < np.cos(WALL_SLOPE):
            return axis
        axis = best
    return axis


def _surface_moment(corners: Floats, area: Floats) -> Floats:
    """The second moment (3, 3) of a surface of triangles (n, 3, 3) about the origin, up to a factor."""
    total = corners.sum(axis=1)
    return np.asarray(np.einsum("n,nki,nkj->ij", area, corners, corners) + np.einsum("n,ni,nj->ij", area, total, total))


def _frame(axis: Floats) -> Floats:
    """(3, 3): two rows across an axis, and one along it."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis])


def _is_round(offset: Floats, axis: Floats) -> bool:
    """Whether a shape's corners, from its middle, spread equally in all directions across an axis, except for wings."""
    across = offset @ _frame(axis)[:2].T
    around = across @ _AROUND.T
    widths = around.max(axis=0) - around.min(axis=0)
    if widths.min() >= LEAST_ROUND * widths.max():
        return True
    return _wings(across, np.hypot(across[:, 0], across[:, 1])) is not None


def _view(corners: Floats, area: Floats, normals: Floats, centre: Floats, axis: Floats) -> _View | None:
    """The shape along an axis; None if it is not symmetric about it."""
    frame = _frame(axis)
    points, turned = (corners - centre) @ frame.T, normals @ frame.T
    r = np.hypot(points[..., 0], points[..., 1])
    z = points[..., 2]
    rest = points.reshape(-1, 3)
    wall = np.abs(turned[:, 2]) < WALL_SLOPE
    total = float(area[wall].sum())
    if not total > 0.02 * float(area.sum()):
        return None
    across = turned[wall, :2] / np.linalg.norm(turned[wall, :2], axis=1)[:, None]
    distance = np.einsum("ij,ij->i", across, points[wall].mean(axis=1)[:, :2])
    walls = Walls(points[wall], across, distance, area[wall])
    recesses = (
        recess_of(walls, float(z.min()), float(z.max())),
        recess_of(walls.flipped(), -float(z.max()), -float(z.min())),
    )
    angle = np.degrees(np.arctan2(across[:, 1], across[:, 0]))
    farthest = r[wall].max(axis=1)
    gap = SAME_RADIUS * float(r.max())
    order = np.argsort(distance)
    groups = np.split(order, np.flatnonzero(np.diff(distance[order]) > gap) + 1)
    weights, heights = area[wall], z[wall]
    is_cut = np.zeros(len(weights), dtype=bool)
    for recess in recesses:
        if recess is not None:
            is_cut[recess.walls] = True
    whole = float(weights[~is_cut].sum())
    bodies = []
    for group in groups:
        if weights[group].sum() < LEAST_GROUP * total:
            continue
        body = _body(distance[group], angle[group], weights[group], heights[group], farthest[group], whole or total)
        if body is not None:
            bodies.append(body)
    share = sum(body.share for body in bodies if not (body.is_inside and any(recesses)))
    if share < LEAST_SYMMETRIC and _wings(rest[:, :2], r.reshape(-1)) is None:
        return None
    kept = [body for body in bodies if body.share >= LEAST_BODY]
    return _View(kept, rest[:, 2], r.reshape(-1), rest[:, :2], recesses)


def _body(
    distance: Floats, angle: Floats, weight: Floats, heights: Floats, farthest: Floats, total: float
) -> _Body | None:
    """Walls at about one distance, if they surround the axis evenly."""
    sides = np.round(angle / DIRECTION_DEG).astype(np.int64)
    # Directions of a hexagon may fall on both sides of a step's border: neighbours count as one.
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
    # A fine cylinder is one run all around.
    count = len(np.unique(sides)) if len(runs) < 3 else len(runs)
    middle = float(np.average(distance, weights=weight))
    out = float(farthest.max()) / max(abs(middle), 1e-300)
    prism = 0
    if len(runs) in CORNERS and areas.min() > LEAST_DIRECTION * areas.mean():
        low, high = CORNERS[len(runs)]
        phase = complex((weight * np.cos(len(runs) * turn)).sum(), (weight * np.sin(len(runs) * turn)).sum())
        prism = len(runs) if abs(phase) > 0.97 * weight.sum() and low <= out <= high else 0
    if count < 5 and prism != 4:
        return None
    share = float(weight.sum()) / total
    return _Body(abs(middle), middle < 0, count, prism, float(heights.min()), float(heights.max()), share)


def _wings(across: Floats, r: Floats) -> tuple[float, float] | None:
    """Radius of the hub, and of its two wings; None without wings."""
    reach = float(r.max())
    far = across[r > 0.85 * reach]
    turn = 0.5 * np.angle(np.sum((far[:, 0] + 1j * far[:, 1]) ** 2))  # the middle of both wings, not a corner of one
    tip = np.array([np.cos(turn), np.sin(turn)])
    along, beside = np.abs(across @ tip), np.abs(across @ np.array([-tip[1], tip[0]]))
    thick = float(beside[r > 0.85 * reach].max())
    sides = across @ tip
    hub = float(beside.max())
    if not (hub < 0.62 * reach and thick < 0.3 * hub and float(sides.min()) < -0.95 * reach):
        return None
    wing = along > 1.1 * hub
    return (hub, reach) if float(beside[wing].max()) < 0.6 * hub else None


def _recognised(view: _View, axis: Floats, centre: Floats) -> Looks | None:
    weak = None
    for sign, seen in ((1.0, view), (-1.0, view.flipped())):
        for look in (_bolt, _recessed_screw, _nut, _wing_nut, _round_screw, _stud, _prism):
            found = look(seen)
            if found is None:
                continue
            out = sign * axis
            top = seen.high if found.top is None else found.top
            looks = Looks(
                kind=found.kind,
                axis=out,
                top=centre + out * top,
                height=top - seen.low,
                is_two_sided=found.is_two_sided,
                ring=found.ring,
                size=found.size,
                across_flats=found.flats,
                length=found.length,
                head_height=found.head,
                is_strong=found.is_strong,
                because=found.because,
                drive=found.drive,
                is_known_by_name=found.is_known_by_name,
            )
            if looks.is_strong:
                return looks
            weak = weak or looks
    return weak


@dataclass(frozen=True)
class _Found:
    """The values for `Looks`, along the view's axis."""

    kind: str
    size: float
    flats: float
    length: float
    head: float
    ring: float
    because: str
    drive: str = ""
    is_two_sided: bool = False
    is_strong: bool = True
    top: float | None = None
    """None: the upper end."""
    is_known_by_name: bool = False


def _shank(view: _View, under: float, wide: float) -> tuple[float, float] | None:
    """Radius and length of the shape below a head that ends at `under` and has walls at `wide` from the axis."""
    length = under - view.low
    below = view.r[view.z < under - 0.35 * length]
    if not len(below) or length <= 0:
        return None
    radius = float(below.max())
    if length < SHANK_SLENDER * 2.0 * radius or not radius < wide:
        return None
    return radius, length


def _bearing(view: _View, radius: float, wide: float) -> float:
    """The height at which a head of radius `wide` bears on the joint: the end of all that is wider than the shank."""
    head = view.z[view.r > radius + 0.35 * (wide - radius)]
    return float(head.min())


def _bolt(view: _View) -> _Found | None:
    prisms = [b for b in view.outer() if b.sides]
    if not prisms or view.is_hollow():
        return None
    head = max(prisms, key=lambda b: (b.sides > 4, b.radius))
    full = view.high - view.low
    if any(b.high > view.high - 0.1 * full and b.radius > BORE_TO_FLATS[0] * head.radius for b in view.inner()):
        return None  # a bore from above: a domed nut from below
    shank = _shank(view, head.low, head.radius)
    if shank is None or not THREAD_TO_FLATS[0] <= shank[0] / head.radius <= THREAD_TO_FLATS[1]:
        return None
    radius = shank[0]
    if head.sides == 4 and not any(b.directions > 6 for b in view.outer()):
        return None  # a round head that is cut as coarsely as its shank
    if any(b.sides == 4 and b is not head and b.radius > 1.2 * radius for b in prisms):
        return None  # a plate under it
    bearing = _bearing(view, radius, head.radius)
    flats, length, height = 2.0 * head.radius, bearing - view.low, view.high - bearing
    if not HEAD_HEIGHTS[0] <= head.height / flats <= HEAD_HEIGHTS[1]:
        return None  # a plate, or a standoff
    name = PRISMS[head.sides]
    because = f"{_a(name)}, {_mm(flats)} across flats, on a shank of {_mm(2.0 * radius)}"
    beyond = view.high - head.high
    top, is_known_by_name = None, False
    is_strong = head.sides != 4 or (SQUARE_HEAD[0] <= height / (2.0 * radius) <= SQUARE_HEAD[1])
    is_domed = beyond < head.height and not any(b.high > head.high + 0.1 * beyond for b in view.outer())
    if beyond > TOP_SHARE * head.height and not is_domed:
        # A sensor: its hexagon lies between a thread and a body that a wrench goes around.
        if head.sides != 6 or beyond > 2.0 * head.height or length > 2.5 * head.height:
            return None
        body = float(view.r[view.z > head.high + 0.3 * beyond].max())
        if not BODY_TO_FLATS[0] <= body / head.radius <= BODY_TO_FLATS[1] or any(view.recesses):
            return None
        if body < 1.08 * radius:
            return None  # a pipe on both sides, or seen from the thread's end
        top = float(view.z[view.r > 1.03 * body].max())
        is_strong, is_known_by_name, height = False, True, top - bearing
        because += ", under a round body"
    # If the shank has six sides too, the head may be a round one with equally coarse facets.
    is_coarse = any(b.sides == 6 and b.radius < 0.97 * head.radius for b in prisms)
    kind = "head" if is_coarse and head.sides == 6 else "bolt"
    ring = 0.9 * head.radius
    return _Found(
        *(kind, 2.0 * radius, flats, length, height, ring, because, name, False, is_strong, top, is_known_by_name)
    )


def _recessed_screw(view: _View) -> _Found | None:
    recess, outer = view.recesses[0], view.outer()
    if recess is None or not outer or view.is_hollow():
        return None
    full = view.high - view.low
    head = float(view.r[view.z > view.high - 0.5 * full].max())
    radius = float(view.r[view.z < view.low + 0.4 * full].max())
    if radius < 0.3 * head:  # a pointed tip
        radius = max((b.radius for b in outer if b.radius < 0.75 * head), default=radius)
    # A slot may run out of the head on both sides; other recesses are inside it.
    if not recess.reach < 0.85 * head and recess.drive != "slot":
        return None
    if any(b.sides and b.radius > radius for b in outer):
        return None
    is_headless = radius > 0.9 * head
    if is_headless:
        is_thin = recess.reach > HEADLESS_RECESS * radius and recess.drive != "slot"
        if is_thin or full < HEADLESS_SLENDER * 2.0 * radius:
            return None
        if len(outer) > 1 and min(b.radius for b in outer) < 0.7 * radius:
            return None
    else:
        is_high = view.high - _bearing(view, radius, head) > MOST_HEAD * 2.0 * radius
        if is_high or full < 1.3 * radius or not HEAD_TO_SHANK[0] <= head / radius <= MOST_HEAD_WIDTH:
            return None
    if recess.drive == "slot" and not recess.width < SLOT_TO_HEAD * 2.0 * head:
        return None
    bearing = view.high if is_headless else _bearing(view, radius, head)
    flats = recess.width if recess.drive in FLAT_SOCKETS else np.nan
    width = f", {_mm(flats)} across flats," if flats == flats else ""
    where = "in a rod" if is_headless else "in a round head"
    because = f"{_a(recess.drive)}{width} {where}"
    length = full if is_headless else bearing - view.low
    return _Found("screw", 2.0 * radius, flats, length, view.high - bearing, head, because, recess.drive)


def _nut(view: _View) -> _Found | None:
    prisms = [b for b in view.outer() if b.sides]
    bores = [b for b in view.inner() if b.sides or b.directions != 6]  # six directions may be a castle nut's slots
    if not prisms or not bores:
        return None
    body, bore = max(prisms, key=lambda b: (b.sides > 4, b.radius)), min(bores, key=lambda b: b.radius)
    full = view.high - view.low
    wider = [b for b in bores if b.radius > STEPPED * bore.radius and b.height > 0.1 * full]
    is_wide_above = any(b.low > bore.low and b.high > view.high - 0.1 * full for b in wider)
    is_wide_below = any(b.high < bore.high and b.low < view.low + 0.1 * full for b in wider)
    if is_wide_above and not is_wide_below:
        return None  # a union nut or a counterbore: its wide end is on the joint's side
    # The bore of a domed nut enters from below. Chamfers leave as much at both ends.
    is_blind = view.high - bore.high > max(bore.low - view.low, 0.0) + 0.1 * full
    if is_blind and not (bore.low < view.low + 0.15 * full and bore.height > 0.35 * full):
        return None
    least = float(view.r[view.z < bore.high - 0.1 * bore.height].min())
    if not BORE_TO_FLATS[0] <= least / body.radius <= (BORE_TO_12_POINT if body.sides == 12 else BORE_TO_FLATS[1]):
        return None
    if not NUT_HEIGHT[0] <= full / (2.0 * body.radius) <= NUT_HEIGHT[1] or body.height < 0.4 * full:
        return None
    if not least > 0.6 * bore.radius:
        return None  # something closes the bore
    if body.sides == 4 and full < SQUARE_NUT * body.radius:
        return None  # a square washer
    flats, ring = 2.0 * body.radius, 0.5 * (bore.radius + body.radius)
    size, name = 2.0 * least, PRISMS[body.sides]
    because = f"{_a(name)}, {_mm(flats)} across flats, with a bore of {_mm(size)}"
    above, below = (
        float(view.r[near].max()) for near in (view.z > view.high - 0.05 * full, view.z < view.low + 0.05 * full)
    )
    is_two_sided = below < 1.1 * above and not is_blind and is_wide_above == is_wide_below
    if max(above, below) > WIDEST_FLANGE * body.radius:
        return None  # a plate that a nut is welded to
    if above > 1.1 * below:
        return None  # a flange: seen from the other end it is on the joint's side
    # Slots of a castle nut are open above: they have a floor, with corners outside the bore.
    z, r = view.z.reshape(-1, 3), view.r.reshape(-1, 3)
    is_level = (np.ptp(z, axis=1) < 1e-6 * full) & (r.max(axis=1) > 1.15 * bore.radius)
    floor = z[is_level & (np.abs(z[:, 0] - 0.5 * (view.low + view.high)) < 0.42 * full), 0]
    floor = floor[(floor > body.low + 0.02 * full) & (floor < body.high - 0.02 * full)]
    if is_two_sided and len(floor):
        if float(floor.max()) < 0.5 * (view.low + view.high):
            return None
        is_two_sided = False
    is_strong = body.sides != 4
    return _Found("nut", size, flats, full, full, ring, because, name, is_two_sided, is_strong)


def _wing_nut(view: _View) -> _Found | None:
    wings = _wings(view.across, view.r)
    bores = [b for b in view.inner() if not b.sides or b.directions == 6]
    if wings is None or not bores:
        return None
    hub, reach = wings
    bore = min(b.radius for b in bores)
    least, full = float(view.r.min()), view.high - view.low
    if not WING_BORE[0] <= least / hub <= WING_BORE[1] or not least > 0.6 * bore or full > 2.0 * reach:
        return None
    # Wings rise from the joint: outside the hub, the shape is above the hub's lower end.
    low, high = float(view.z[view.r > 1.2 * hub].min()), float(view.z[view.r <= 1.02 * hub].max())
    is_risen = view.high > high - 1e-9 and low > view.low + 0.02 * full
    if not is_risen:
        return None
    because = f"two wings on a hub of {_mm(2.0 * hub)}, with a bore of {_mm(2.0 * least)}"
    size, ring = 2.0 * least, 0.5 * (bore + hub)
    return _Found("nut", size, np.nan, full, full, ring, because, "wings", False, view.high > 1.02 * high)


def _stud(view: _View) -> _Found | None:
    """A shank between two threads drawn with the core's diameter, each with a chamfered end."""
    outer = [b for b in view.outer() if not b.sides or b.directions >= 6]
    if len(outer) != 2 or view.inner() or any(view.recesses):
        return None
    core, shank = sorted(outer, key=lambda b: b.radius)
    full = view.high - view.low
    if not CORE[0] <= core.radius / shank.radius <= CORE[1] or full < STUD_SLENDER * 2.0 * shank.radius:
        return None
    if not (core.low < shank.low - 0.05 * full and core.high > shank.high + 0.05 * full):
        return None
    ends = [float(view.r[near].max()) for near in (view.z > view.high - 1e-6 * full, view.z < view.low + 1e-6 * full)]
    if max(ends) > 0.97 * float(view.r[view.z > view.high - 0.2 * full].max()) or 2.0 * shank.radius > WIDEST_STUD_M:
        return None
    size = 2.0 * float(view.r.max())
    because = f"a shank of {_mm(size)} between two threads"
    return _Found("stud", size, np.nan, full, np.nan, 0.7 * core.radius, because, "", True, False)


def _round_screw(view: _View) -> _Found | None:
    outer = [b for b in view.outer() if b.directions >= 5]
    if len(outer) < 2 or view.inner() or any(view.recesses):
        return None
    head = max(outer, key=lambda b: b.radius)
    if view.high - head.high > 0.6 * head.height:
        return None
    shank = _shank(view, head.low, head.radius)
    if shank is None or 2.0 * shank[0] > 0.75 * WIDEST_WEAK_M:
        return None
    radius = shank[0]
    bearing = _bearing(view, radius, head.radius)
    height = view.high - bearing
    wide = float(view.r[view.z > bearing + 0.2 * height].max())
    if not HEAD_TO_SHANK[0] <= wide / radius <= HEAD_TO_SHANK[1]:
        return None
    if not HEAD_HEIGHT[0] <= height / (2.0 * radius) <= HEAD_HEIGHT[1]:
        return None
    because = f"a round head of {_mm(2.0 * wide)} on a shank of {_mm(2.0 * radius)}"
    ring = 0.9 * head.radius
    return _Found("screw", 2.0 * radius, np.nan, bearing - view.low, height, ring, because, is_strong=False)


def _prism(view: _View) -> _Found | None:
    outer = view.outer()
    if len(outer) != 1 or outer[0].sides != 6 or view.inner():
        return None
    body, full = outer[0], view.high - view.low
    if not PRISM_HEIGHT[0] <= full / (2.0 * body.radius) <= PRISM_HEIGHT[1] or body.height < 0.7 * full:
        return None
    flats = 2.0 * body.radius
    if flats > WIDEST_WEAK_M:
        return None
    because, ring = f"a hexagon, {_mm(flats)} across flats", 0.6 * body.radius
    return _Found("prism", np.nan, flats, np.nan, full, ring, because, PRISMS[6], True, False)


def _a(thing: str) -> str:
    return f"a {thing}"


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm"
