"""Recognises fasteners by shape: axis, head, shank and bore.

The shape is examined along each axis about which it could be a fastener. Its walls (triangles along the axis) are
grouped by their distance from it. Four directions form a square, six a hexagon, twelve a 12-point hexagon; twelve or
more can also be a cylinder. Walls that face inwards are a bore or a recess (`fastener_drive`). The shape beyond the
head separates bolts from nuts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from feeler.plan.fastener_drive import outline_at
from feeler.plan.fastener_forms import LESS_USUAL, is_domed, is_shaft, wing_screw
from feeler.plan.fastener_rare import RARE
from feeler.plan.fastener_view import (
    BORE_TO_FLATS,
    CORNERS,
    FLAT_SOCKETS,
    HEAD_HEIGHTS,
    HEAD_TO_SHANK,
    HEADLESS_FLATS,
    HEADLESS_RECESS,
    MOST_HEAD,
    MOST_HEAD_WIDTH,
    PRISMS,
    SLOT_TO_HEAD,
    THREAD_TO_FLATS,
    TOP_SHARE,
    WALL_SLOPE,
    Found,
    View,
    article,
    bearing_of,
    frame_of,
    is_winged,
    mm,
    shank_of,
    thread_of,
    view_along,
    wings_of,
)

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

HOLE = 0.02
"""The least radius of a hole along the axis, relative to that of the shape."""
ALIKE = 0.03
"""Principal values that differ by less, as a share of their sum, count as equal: threads and marks change them."""
LEAST_ROUND = 0.68
"""The least width across the axis, relative to the greatest: 0.71 for a square. Only wing nuts are narrower."""
SQUARE_HEAD = (0.4, 1.1)
"""Height of a square head, relative to its shank's diameter: blocks with a boss are flatter or higher."""
SQUARE_NUT = 0.5
"""The least height of a square nut, relative to half its width: square washers are flatter."""
SQUARE_BORE = 0.4
"""The least bore of a square nut, relative to its width, unless its name says that it is a nut: pads are wider."""
BODY_TO_FLATS = (0.5, 0.95)
"""Width of the body beyond a sensor's hexagon, relative to the width across flats: a wrench goes around it."""
HEADLESS_SLENDER = 0.7
"""The least length of a set screw, in diameters."""
WING_BORE = (0.3, 0.75)
"""A wing nut's bore, relative to its hub."""
CORE = (0.75, 0.97)
"""Core diameter of a thread, relative to its shank's: 0.8 to 0.9 in the standards."""
WIDEST_STUD_M = 0.0251
"""The widest stud recognised by its two threads alone: thicker rods of this form are usually shafts."""
STUD_SLENDER = 3.0
"""The least length of a stud, in diameters."""
STEPPED = 1.1
"""A bore that is wider than another by this factor makes a step."""
THICK_NUT = 0.08
"""The least bore, relative to the width across flats, of a nut whose name says so: other thick prisms with a hole are
spacers and knobs."""
WIDE_NUT = (BORE_TO_FLATS[1], 0.92)
"""The bore of a lock nut, relative to its width across flats: 0.7 to 0.84 for sensors, up to 0.9 for cable glands."""
WIDE_NUT_HEIGHT = (0.08, 1.0)
"""Its height, relative to its width across flats: 0.1 and more for cable glands; spacers are longer."""
BORE_END = 0.2
"""How far from its ends the thread of a round nut begins at most, because of chamfers, relative to its height."""
BORE_TO_12_POINT = 0.86
"""The same limit for a 12-point nut: M8 has 10 mm across flats."""
WIDEST_FLANGE = 2.0
"""The greatest radius of a nut's flange, relative to half its width across flats: 1.4 in the standards."""
NUT_HEIGHT = (0.15, 2.05)
"""Height, relative to the width across flats: thin nuts to long ones."""
LONG_NUT_HEIGHT = (NUT_HEIGHT[1], 5.0)
"""The same of a longer nut that joins two rods."""
PRISM_HEIGHT = (0.25, 1.0)
"""The same for a prism that represents a head or a nut in a coarse mesh."""
WIDEST_WEAK_M = 0.04
"""The widest shank, and width across flats, of ambiguous shapes: larger parts of such a shape are seldom fasteners."""
STEEP_DEG = 30.0
"""Angle between the normals of the flanks of teeth and the radius, at least: facets of round heads are turned less."""
STEEP_SHARE = 0.15
"""The least share of flanks in the outline of a toothed wheel."""
END_SLOPE, FLANKS = 0.98, 0.3
"""The least cosine of the angle between the axis and the normals of ends, and the least share of flanks in the outside
of a rod with a thread: chamfers of a pin have less."""
THREAD_BELOW, THREAD_BELOW_LENGTH = (0.5, 0.96), 1.3
"""Radius of the thread of a shoulder screw, relative to its shoulder, and its length, in diameters: points of screws
are thinner or shorter."""
HEAD_HEIGHT = (0.45, 1.2)
"""Height of a round head, relative to its shank's diameter: 1 for socket heads; heads of rivets are flatter."""


_Form = Callable[[View], Found | None]

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
    width: float = np.nan
    """Of a drive without flats, as `Fastener.width`."""


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
    views: list[tuple[View, Floats]] = []
    for rough in _axes(corners, area, normals, centre):
        axis = _along_walls(area, normals, rough)
        view = view_along(corners, area, normals, centre, axis) if _is_round(vertices - centre, axis) else None
        if view is None:
            continue
        views.append((view, axis))
        found = _recognised(view, axis, centre, _USUAL)
        if found is not None and found.is_strong:
            return found
        best = best or found
    if best is not None:
        return best
    rare = [_recognised(view, axis, centre, _LESS_USUAL) for view, axis in views]
    return next((found for found in sorted(filter(None, rare), key=lambda found: not found.is_strong)), None)


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


def is_plain(vertices: Floats, faces: Ints, looks: Looks) -> bool:
    """Whether the outside of a rod has no thread: hardly any of it slopes to both ends, as flanks do."""
    corners = vertices[faces] - looks.top
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    lean = np.abs(cross @ looks.axis) / np.maximum(area, 1e-300)
    is_flank, is_wall = (lean >= WALL_SLOPE) & (lean < END_SLOPE), lean < WALL_SLOPE
    return bool(area[is_flank].sum() < FLANKS * area[is_flank | is_wall].sum())


def bore_of(vertices: Floats, faces: Ints, looks: Looks) -> float | None:
    """The diameter of the hole that goes through a shape along its axis; None if there is none."""
    local = (vertices - looks.top) @ frame_of(looks.axis).T
    flat = local[faces][:, :, :2]
    after = flat[:, [1, 2, 0]]
    sides = flat[:, :, 0] * after[:, :, 1] - flat[:, :, 1] * after[:, :, 0]
    if ((sides > 0.0).all(axis=1) | (sides < 0.0).all(axis=1)).any():
        return None  # a triangle is on the axis
    along = after - flat
    square = np.maximum(np.einsum("nki,nki->nk", along, along), 1e-300)
    share = np.clip(-np.einsum("nki,nki->nk", flat, along) / square, 0.0, 1.0)
    nearest = float(np.linalg.norm(flat + share[:, :, None] * along, axis=2).min())
    wide = float(np.hypot(local[:, 0], local[:, 1]).max())
    return 2.0 * float(np.hypot(local[:, 0], local[:, 1]).min()) if nearest > HOLE * wide else None


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


def _is_round(offset: Floats, axis: Floats) -> bool:
    """Whether a shape's corners, from its middle, spread equally in all directions across an axis, except for wings."""
    across = offset @ frame_of(axis)[:2].T
    around = across @ _AROUND.T
    widths = around.max(axis=0) - around.min(axis=0)
    if widths.min() >= LEAST_ROUND * widths.max():
        return True
    return is_winged(across, np.hypot(across[:, 0], across[:, 1]))


def _recognised(view: View, axis: Floats, centre: Floats, forms: Sequence[_Form]) -> Looks | None:
    """The first strong form among some, else the first weak one."""
    weak = None
    for sign, seen in ((1.0, view), (-1.0, view.flipped())):
        for look in forms:
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
                width=found.width,
            )
            if looks.is_strong:
                return looks
            weak = weak or looks
    return weak


def _bolt(view: View) -> Found | None:
    prisms = [b for b in view.outer() if b.sides]
    if not prisms or view.is_hollow():
        return None
    head = max(prisms, key=lambda b: (b.sides > 4, b.radius))
    full = view.high - view.low
    if any(b.high > view.high - 0.1 * full and b.radius > BORE_TO_FLATS[0] * head.radius for b in view.inner()):
        return None  # a bore from above: a domed nut from below
    shank = shank_of(view, head.low, head.radius)
    if shank is None or not THREAD_TO_FLATS[0] <= shank[0] / head.radius <= THREAD_TO_FLATS[1]:
        return None
    radius = shank[0]
    if head.sides == 4 and not any(b.directions > 6 for b in view.outer()):
        return None  # a round head that is cut as coarsely as its shank
    if any(b.sides == 4 and b is not head and b.radius > 1.2 * radius for b in prisms):
        return None  # a plate under it
    bearing = bearing_of(view, radius, head.radius)
    flats, length, height = 2.0 * head.radius, bearing - view.low, view.high - bearing
    if not HEAD_HEIGHTS[0] <= head.height / flats <= HEAD_HEIGHTS[1]:
        return None  # a plate, or a standoff
    name = PRISMS[head.sides]
    because = f"{article(name)}, {mm(flats)} across flats, on a shank of {mm(2.0 * radius)}"
    beyond = view.high - head.high
    top, is_known_by_name = None, is_shaft(view, bearing, radius)
    is_usual = head.sides != 4 or (SQUARE_HEAD[0] <= height / (2.0 * radius) <= SQUARE_HEAD[1])
    is_strong = is_usual and not is_known_by_name
    if beyond > TOP_SHARE * head.height and not is_domed(view, head):
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
    return Found(
        *(kind, 2.0 * radius, flats, length, height, ring, because, name, False, is_strong, top, is_known_by_name)
    )


def _recessed_screw(view: View) -> Found | None:
    recess, outer = view.recesses[0], view.outer()
    if recess is None or not outer or view.is_hollow():
        return None
    full = view.high - view.low
    head = float(view.r[view.z > view.high - 0.5 * full].max())
    radius = float(view.r[view.z < view.low + 0.4 * full].max())
    if radius < 0.3 * head:  # a pointed tip
        radius = max((b.radius for b in outer if b.radius < 0.75 * head), default=radius)
    if recess.drive == "hexagon socket" and any(
        b.low < view.low + 0.05 * full
        and THREAD_BELOW[0] <= b.radius / radius <= THREAD_BELOW[1]
        # A dog point is shorter, and around the core of a thread are its ridges.
        and b.height > THREAD_BELOW_LENGTH * 2.0 * b.radius
        and float(view.r[view.z < b.high - 0.05 * full].max()) < 1.03 * b.radius
        for b in outer
    ):
        return None  # a shoulder, on a thread of its own
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
        if any(b.sides and b.height > HEADLESS_FLATS * full for b in outer):
            return None  # a bar: it cannot turn in its hole
    else:
        is_high = view.high - bearing_of(view, radius, head) > MOST_HEAD * 2.0 * radius
        if is_high or full < 1.3 * radius or not HEAD_TO_SHANK[0] <= head / radius <= MOST_HEAD_WIDTH:
            return None
    if recess.drive == "slot" and not recess.width < SLOT_TO_HEAD * 2.0 * head:
        return None
    bearing = view.high if is_headless else bearing_of(view, radius, head)
    flats = recess.width if recess.drive in FLAT_SOCKETS else np.nan
    width = f", {mm(flats)} across flats," if flats == flats else ""
    where = "in a rod" if is_headless else "in a round head"
    because = f"{article(recess.drive)}{width} {where}"
    length = full if is_headless else bearing - view.low
    size = 2.0 * (radius if is_headless else thread_of(view, radius, recess))
    return Found("screw", size, flats, length, view.high - bearing, head, because, recess.drive, width=recess.width)


def _nut(
    view: View,
    to_flats: tuple[float, float] = BORE_TO_FLATS,
    to_points: float = BORE_TO_12_POINT,
    heights: tuple[float, float] = NUT_HEIGHT,
) -> Found | None:
    """A prism with a bore. to_flats: the bore, relative to the width across flats; to_points: its limit for 12 points;
    heights: relative to that width."""
    prisms = [b for b in view.outer() if b.sides]
    # Six directions may be a castle nut's slots.
    bores = [b for b in view.inner() if b.sides or b.directions != 6] or view.threads
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
    if not to_flats[0] <= least / body.radius <= (to_points if body.sides == 12 else to_flats[1]):
        return None
    if not heights[0] <= full / (2.0 * body.radius) <= heights[1] or body.height < 0.4 * full:
        return None
    if not least > 0.6 * bore.radius:
        return None  # something closes the bore
    if body.sides == 4 and full < SQUARE_NUT * body.radius:
        return None  # a square washer
    if body.sides == 4 and to_flats == BORE_TO_FLATS and least < SQUARE_BORE * body.radius:
        return None  # a pad with a hole
    flats, ring = 2.0 * body.radius, 0.5 * (bore.radius + body.radius)
    size, name = 2.0 * least, PRISMS[body.sides]
    because = f"{article(name)}, {mm(flats)} across flats, with a bore of {mm(size)}"
    above, below = (
        float(view.r[near].max()) for near in (view.z > view.high - 0.05 * full, view.z < view.low + 0.05 * full)
    )
    # A collar, as of lock nuts, is outside, and a flange on the joint. Another narrow end says little: it may be a
    # chamfer, or a cone or a ball on its seat.
    has_collar = any(
        b.radius < body.radius and min(view.high - b.low, b.height) > 0.1 * full and b.high > view.high - 0.1 * full
        for b in view.outer()
        if b is not body
    )
    has_flange = below > CORNERS[body.sides][1] * body.radius
    is_told = below >= 1.1 * above and (has_flange or has_collar)
    is_two_sided = not is_told and not is_blind and is_wide_above == is_wide_below
    if max(above, below) > WIDEST_FLANGE * body.radius:
        return None  # a plate that a nut is welded to
    if above > 1.1 * below:
        return None  # seen from the other end: a flange is on the joint's side, and a narrow end rather outside
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
    return Found("nut", size, flats, full, full, ring, because, name, is_two_sided, is_strong)


def _thick_nut(view: View) -> Found | None:
    """A nut whose bore is narrow for its width."""
    found = _nut(view, (THICK_NUT, BORE_TO_FLATS[1]))
    return None if found is None else replace(found, is_strong=False, is_known_by_name=True)


def _wide_nut(view: View) -> Found | None:
    """A low nut whose bore is wide for its width: a lock nut. Rings look so too, so its name or its thread decides."""
    found = _nut(view, WIDE_NUT, WIDE_NUT[1], WIDE_NUT_HEIGHT)
    return None if found is None else replace(found, is_strong=False, is_known_by_name=True)


def _long_nut(view: View) -> Found | None:
    """A nut that is longer than those of the standards. Spacers look so too, so its name or two rods in it decide."""
    found = _nut(view, heights=LONG_NUT_HEIGHT)
    return None if found is None else replace(found, is_strong=False, is_known_by_name=True)


def _round_nut(view: View) -> Found | None:
    """A round nut with the flanks of its thread. Flanges and bosses look alike: what is in its thread decides."""
    wide, full = float(view.r.max()), view.high - view.low
    if not view.threads or any(b.sides for b in view.outer()):
        return None
    thread = view.threads[0]
    least, end = float(view.r.min()), BORE_END * full
    is_through = least > 0.9 * thread.radius and thread.low < view.low + end and thread.high > view.high - end
    if not is_through or not BORE_TO_FLATS[0] <= least / wide <= WIDE_NUT[1] or full > NUT_HEIGHT[1] * 2.0 * wide:
        return None
    because = f"a round body of {mm(2.0 * wide)}, with a thread of {mm(2.0 * least)} right through it"
    ring = 0.5 * (least + wide)
    return Found("nut", 2.0 * least, np.nan, full, full, ring, because, "", True, False, is_known_by_name=True)


def is_round_nut(looks: Looks) -> bool:
    """Whether a shape is a round nut as far as it shows."""
    return looks.kind == "nut" and looks.is_known_by_name and np.isnan(looks.across_flats)


def is_long(looks: Looks) -> bool:
    """Whether a shape is a nut that is longer than those of the standards."""
    return looks.kind == "nut" and looks.is_known_by_name and looks.height > NUT_HEIGHT[1] * looks.across_flats


def needs_thread(looks: Looks) -> bool:
    """Whether a shape is a nut if it has threads in it."""
    return _is_wide(looks) or is_long(looks) or is_round_nut(looks)


def _is_wide(looks: Looks) -> bool:
    """Whether a shape is a lock nut as far as it shows."""
    return looks.kind == "nut" and looks.is_known_by_name and looks.size > WIDE_NUT[0] * looks.across_flats


def _wing_nut(view: View) -> Found | None:
    wings = wings_of(view.across, view.r)
    bores = [b for b in view.inner() if not b.sides or b.directions == 6] or view.threads
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
    because = f"two wings on a hub of {mm(2.0 * hub)}, with a bore of {mm(2.0 * least)}"
    size, ring = 2.0 * least, 0.5 * (bore + hub)
    return Found("nut", size, np.nan, full, full, ring, because, "wings", False, view.high > 1.02 * high)


def _stud(view: View) -> Found | None:
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
    because = f"a shank of {mm(size)} between two threads"
    return Found("stud", size, np.nan, full, np.nan, 0.7 * core.radius, because, "", True, False)


def _round_screw(view: View) -> Found | None:
    outer = [b for b in view.outer() if b.directions >= 5]
    if len(outer) < 2 or view.inner() or any(view.recesses):
        return None
    head = max(outer, key=lambda b: b.radius)
    if view.high - head.high > 0.6 * head.height:
        return None
    shank = shank_of(view, head.low, head.radius)
    if shank is None or 2.0 * shank[0] > 0.75 * WIDEST_WEAK_M:
        return None
    radius = shank[0]
    bearing = bearing_of(view, radius, head.radius)
    if is_shaft(view, bearing, radius):
        return None
    height = view.high - bearing
    wide = float(view.r[view.z > bearing + 0.2 * height].max())
    if not HEAD_TO_SHANK[0] <= wide / radius <= HEAD_TO_SHANK[1]:
        return None
    if not HEAD_HEIGHT[0] <= height / (2.0 * radius) <= HEAD_HEIGHT[1]:
        return None
    size, ring, is_toothed = 2.0 * radius, 0.9 * head.radius, _is_toothed(view, view.high - 0.5 * height)
    because = f"a round head of {mm(2.0 * wide)} on a shank of {mm(size)}"
    found = Found("screw", size, np.nan, bearing - view.low, height, ring, because, is_strong=False)
    return replace(found, is_known_by_name=is_toothed)


def _is_toothed(view: View, level: float) -> bool:
    """Whether the outside has teeth at a height, as gears, splines and pulleys have."""
    outline = outline_at(view.walls, level)
    if outline is None:
        return False
    is_steep = np.abs(outline.leans()) > STEEP_DEG
    return bool(outline.length[is_steep].sum() > STEEP_SHARE * outline.length.sum())


def _prism(view: View) -> Found | None:
    outer = view.outer()
    if len(outer) != 1 or outer[0].sides != 6 or view.inner():
        return None
    body, full = outer[0], view.high - view.low
    if not PRISM_HEIGHT[0] <= full / (2.0 * body.radius) <= PRISM_HEIGHT[1] or body.height < 0.7 * full:
        return None
    flats = 2.0 * body.radius
    if flats > WIDEST_WEAK_M:
        return None
    because, ring = f"a hexagon, {mm(flats)} across flats", 0.6 * body.radius
    return Found("prism", np.nan, flats, np.nan, full, ring, because, PRISMS[6], True, False)


_USUAL: tuple[_Form, ...] = (wing_screw, _bolt, _recessed_screw, _nut, _wing_nut, _round_screw, _stud, _prism)
_LESS_USUAL: tuple[_Form, ...] = (*LESS_USUAL, *RARE, _thick_nut, _wide_nut, _long_nut, _round_nut)
