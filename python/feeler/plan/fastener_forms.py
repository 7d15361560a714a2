"""Less usual fasteners: plugs with a collar; hollow, short, shoulder and wing screws; dog points; carriage bolts.

`fastener_shape` examines a shape for these only if it is none of the usual ones. The proportions are those of the
standards. A form that other things have as often, such as a hexagon on a tube, is known by its name only.
"""

from __future__ import annotations

import numpy as np

from feeler.plan.fastener_drive import Recess
from feeler.plan.fastener_view import (
    BORE_TO_FLATS,
    CORNERS,
    FLAT_SOCKETS,
    HEAD_HEIGHTS,
    HEAD_TO_SHANK,
    HEADLESS_RECESS,
    MOST_HEAD,
    MOST_HEAD_WIDTH,
    PRISMS,
    SHANK_SLENDER,
    SLOT_TO_HEAD,
    THREAD_TO_FLATS,
    TOP_SHARE,
    Body,
    Found,
    View,
    article,
    bearing_of,
    mm,
    shank_of,
    thread_of,
    wing_tip,
    wings_of,
)

WIDEST_BORE = 0.85
"""The widest bore through a thread, relative to it: tubes with thinner walls carry no thread."""
NARROW_BORE = 0.42
"""The same, up to which the shape alone shows a hollow screw: unions and nipples are wider."""
COLLAR = 1.05
"""The least radius of a collar, relative to its thread: 1.2 to 1.5 in DIN 908 and DIN 910."""
COLLAR_TO_FLATS = (1.1, 1.7)
"""Radius of a collar, relative to half the width across flats of its hexagon, and, the second, to its thread."""
COLLAR_HEIGHT = 0.3
"""The greatest height of a collar, relative to its diameter: 0.1 to 0.25 in DIN 908 and DIN 910; sections of shafts are
longer."""
COLLAR_LENGTH = (0.15, 1.5)
"""Length of the thread below a collar, in diameters."""
PLUG_TO_FLATS = 1.75
"""The widest thread of a plug, relative to the width across flats of its hexagon: M52 has 30 mm in DIN 910."""
PLUG_HEIGHT = (0.2, 1.0)
"""Height of a plug's hexagon, relative to its width across flats."""
USUAL_FLANGE = 1.75
"""The greatest radius of its flange, relative to half the width across flats: 1.4 in the standards."""
SHORT = (0.15, 0.3)
"""The least length of a short screw's thread, in diameters: with a name that says so, and without."""
USUAL_TO_FLATS = (0.44, 0.72)
"""Thread diameter, relative to the width across flats, of a short or hollow bolt that the shape alone shows: 0.53 to
0.68 in the standards; less where threads are modelled with the core diameter."""
USUAL_HEAD = (0.45, 0.95)
"""Height of its head, relative to its thread's diameter: 0.6 to 0.75 in the standards, more for a core diameter."""
CONE = 0.7
"""The greatest length of a cone between two sections of a bore, relative to the difference of their radii."""
STEP = 0.8
"""A section of the thread below this share of its radius is another section, as of a shaft."""
LEAST_SECTION = 1.0
"""The least length of a section of a shaft, in diameters: points and undercuts of screws are shorter."""
SECTION = 0.93
"""Radius of a section relative to another one, below which they are two."""
THIN_END = 0.72
"""The same for a thin end: threads modelled with the core diameter have 0.79 of a fitted shank."""
HIGH_HEAD = 1.3
"""Height of a head in diameters of its shank, above which several sections make a shaft: up to 1.2 for bolts."""
THREAD_SHARES = (0.4, 0.2, 0.1)
"""Shares of the length below the head, from the tip, in which the thread is sought one after the other. With the last
one, a shoulder may be nine times as long as its thread."""
SHOULDER = (1.05, 0.93)
"""The least radius of a shoulder, relative to its thread, and the greatest, relative to its head."""
WIDEST_SHOULDER_HEAD = 3.5
"""The greatest diameter of a shoulder screw's head, relative to its thread: 2 to 2.4 in ISO 7379."""
DOG = (0.45, 0.85)
"""Radius of a dog point, relative to its thread: 0.6 to 0.75 in DIN 915."""
DOG_LENGTH = 1.2
"""The greatest length of a dog point, in its diameters: 0.7 to 0.8 in DIN 915."""
DOG_THREAD = 0.85
"""The least length of the thread above it, in diameters: heads of screws are lower."""
WING_SHANK = (0.3, 0.85)
"""Radius of a wing screw's shank, relative to its hub."""
MOST_WING = 2.0
"""The greatest height of wings, relative to their reach."""
SQUARE_NECK = (0.75, 1.15)
"""Radius of a carriage bolt's shank, relative to half the width of the square below its head: 1 in DIN 603."""
NECK_CORNER = 1.1
"""The least radius of the corners of that square, relative to the shank."""
NECK_HEIGHT = (0.2, 1.5)
"""Height of that square, in diameters of the shank: 0.5 to 0.6 in DIN 603."""
ROUND_HEAD = (1.6, 3.2)
"""Diameter of its head, relative to its shank: 2 to 2.6 in DIN 603."""
ROUND_HEIGHT = (0.15, 1.0)
"""Height of its head, in diameters of its shank: 0.5 to 0.6 in DIN 603."""

STANDOFF = (0.75, 1.15)
"""Radius of the thread in the top of a standoff, relative to that below it: the same size, as core or outside."""
STANDOFF_DEPTH = 0.7
"""The least depth of that thread, in diameters."""


def standoff(view: View) -> Found | None:
    """A hexagon with a thread below it, and a blind one of the same size in its top."""
    full = view.high - view.low
    heads = [b for b in view.outer() if b.sides == 6]
    bores = [b for b in view.inner() if not b.sides and b.high > view.high - 0.1 * full]
    if len(heads) != 1 or not bores or view.is_hollow():
        return None
    head, bore = heads[0], min(bores, key=lambda b: b.radius)
    shank = shank_of(view, head.low, head.radius)
    if shank is None or view.high - head.high > TOP_SHARE * head.height:
        return None
    radius, length = shank
    is_usual = THREAD_TO_FLATS[0] <= radius / head.radius <= THREAD_TO_FLATS[1]
    is_alike = STANDOFF[0] <= bore.radius / radius <= STANDOFF[1]
    is_blind = bore.low > head.low - 0.5 * length and bore.height >= STANDOFF_DEPTH * 2.0 * radius
    if not (is_usual and is_alike and is_blind) or _steps(view, head.low, radius):
        return None
    flats, size = 2.0 * head.radius, 2.0 * radius
    because = f"a hexagon, {mm(flats)} across flats, on a thread of {mm(size)}, with one in its top"
    return Found("bolt", size, flats, length, view.high - head.low, 0.9 * head.radius, because, PRISMS[6])


def hexagon_headed(view: View) -> Found | None:
    """A hexagon on a short or hollow thread, or on a collar that is wider than both."""
    prisms = [b for b in view.outer() if b.sides]
    # Flats of a plug may be as far from the axis as its thread.
    head = max(prisms, key=lambda b: (b.sides > 4, b.radius), default=None) or above_collar(view)
    if head is None:
        return None
    bore = _bore(view)
    full, flats = view.high - view.low, 2.0 * head.radius
    beyond = view.high - head.high
    if (beyond > TOP_SHARE * head.height and (bore or not is_domed(view, head))) or view.recesses[1] is not None:
        return None
    if not HEAD_HEIGHTS[0] <= head.height / flats <= HEAD_HEIGHTS[1]:
        return None
    if not bore and any(
        b.high > view.high - 0.1 * full and b.radius > BORE_TO_FLATS[0] * head.radius for b in view.inner()
    ):
        return None  # a bore from above: a domed nut from below
    under = head.low - view.low
    radius = widest(view, view.low, view.low + 0.4 * under)
    wide = widest(view, view.low, head.low - 0.02 * under)
    if not radius > 0.0 or bore > WIDEST_BORE * radius:
        return None
    if any(b is not head and b.sides in (4, 6) and b.radius > 1.2 * radius for b in prisms):
        return None  # a plate under it, or facets of a coarse mesh
    is_wider = wide > max(COLLAR * radius, 0.9 * head.radius)
    bearing = bearing_of(view, radius, wide) if is_wider else head.low
    length = bearing - view.low
    collar = wide if is_wider else 0.0
    is_sure = _is_bolt_shape(view, head, radius, collar, bearing, bore)
    if is_sure is None:
        return None
    is_sure = is_sure and head.sides > 4 and not any(b is not head for b in prisms if b.sides == 6)
    name = PRISMS[head.sides]
    because = f"{article(name)}, {mm(flats)} across flats, on "
    because += f"a collar of {mm(2.0 * collar)} and " if collar > radius * COLLAR and collar > head.radius else ""
    because += f"a {'hollow ' if bore else ''}thread of {mm(2.0 * radius)}"
    ring = 0.9 * max(head.radius, collar)
    return Found(
        *("bolt", 2.0 * radius, flats, length, view.high - bearing, ring, because, name),
        is_strong=is_sure,
        is_known_by_name=not is_sure,
    )


def above_collar(view: View) -> Body | None:
    """The prism that stands alone on the widest section."""
    top = float(view.z[view.r > 0.97 * float(view.r.max())].max())
    found = view.outer_above(top - 1e-3 * (view.high - view.low))
    return found if found is not None and found.sides else None


def is_domed(view: View, head: Body) -> bool:
    """Whether a head ends in a dome that leaves its flats free for a tool."""
    beyond = view.high - head.high
    if beyond >= head.height or any(b.high > head.high + 0.1 * beyond for b in view.outer()):
        return False
    above = view.r[view.z > head.high + 1e-6 * beyond]
    return bool(above.max(initial=0.0) < CORNERS[head.sides][1] * head.radius)


def _is_bolt_shape(view: View, head: Body, radius: float, collar: float, bearing: float, bore: float) -> bool | None:
    """Whether a hexagon on a thread is a fastener by its shape alone; None if a name does not make it one either.

    `collar`: its radius, 0 for none; `bearing`: where the thread ends; `bore`: radius of the bore through it, or 0.
    """
    length = bearing - view.low
    slender, to_flats = length / (2.0 * radius), radius / head.radius
    is_plain = not _steps(view, bearing, radius)
    if to_flats > THREAD_TO_FLATS[1]:
        is_plug = COLLAR_LENGTH[0] <= slender <= COLLAR_LENGTH[1] and to_flats <= PLUG_TO_FLATS
        if not is_plug or not PLUG_HEIGHT[0] <= head.height / (2.0 * head.radius) <= PLUG_HEIGHT[1]:
            return None
        has_collar = collar > COLLAR_TO_FLATS[0] * head.radius and collar < COLLAR_TO_FLATS[1] * radius
        return has_collar and head.low - bearing <= COLLAR_HEIGHT * 2.0 * collar and is_plain and not bore
    if to_flats < THREAD_TO_FLATS[0] or slender < SHORT[0]:
        return None
    if slender >= SHANK_SLENDER and not bore:
        return None  # a usual bolt, or not
    height = (view.high - bearing) / (2.0 * radius)
    is_usual = USUAL_TO_FLATS[0] <= to_flats <= USUAL_TO_FLATS[1] and USUAL_HEAD[0] <= height <= USUAL_HEAD[1]
    is_usual = is_usual and is_plain and collar < USUAL_FLANGE * head.radius
    if bore:
        is_usual = is_usual and slender >= SHANK_SLENDER and bore <= NARROW_BORE * radius
    return is_usual and slender >= SHORT[1]


def recessed(view: View) -> Found | None:
    """A recess in a collar or a head, with a bore, a shoulder, or a short thread; or in a thread with a dog point."""
    recess, outer = view.recesses[0], view.outer()
    if recess is None or not outer or any(b.sides in (4, 6) for b in outer):
        return None
    head, bore = float(view.r.max()), _bore(view)
    if (recess.drive == "slot" and not recess.width < SLOT_TO_HEAD * 2.0 * head) or (
        recess.drive != "slot" and not recess.reach < 0.85 * head
    ):
        return None
    full, under = view.high - view.low, float(view.z[view.r > 0.97 * head].min())
    if under - view.low < 0.1 * full:
        return _headless(view, recess, head, head, bore)
    # A thread may be short, below a long shoulder; and a narrow tip, short below a thread.
    found = (_on_thread(view, recess, head, bore, under, share) for share in THREAD_SHARES)
    return next(filter(None, found), None)


def _on_thread(view: View, recess: Recess, head: float, bore: float, under: float, share: float) -> Found | None:
    """As `recessed`, if the thread is within this share of the length below the head, measured from the tip."""
    outer, full, below = view.outer(), view.high - view.low, under - view.low
    radius = thread_of(view, widest(view, view.low, view.low + share * below), recess)
    if bore > WIDEST_BORE * radius:
        return None
    is_thread = view.high - under >= DOG_THREAD * 2.0 * head
    if is_thread and DOG[0] <= radius / head <= DOG[1] and below <= DOG_LENGTH * 2.0 * radius:
        return _headless(view, recess, head, radius, bore)
    shoulders = [
        b for b in outer if SHOULDER[0] * radius < b.radius < SHOULDER[1] * head and b.high < under + 0.1 * full
    ]
    shoulder = max((b.radius for b in shoulders), default=0.0)
    if shoulder and min(b.radius for b in shoulders) < 0.9 * shoulder:
        return None  # a shaft of many sections
    bearing = bearing_of(view, shoulder or radius, head)
    is_sure = _is_screw_shape(view, recess, head, radius, shoulder, bearing, bore)
    if is_sure is None:
        return None
    where = "in a round head" if head >= HEAD_TO_SHANK[0] * radius else f"in a collar of {mm(2.0 * head)}"
    where += f", on a shoulder of {mm(2.0 * shoulder)}" if shoulder else ""
    where += ", with a bore" if bore else ""
    return _screw(recess, radius, bearing - view.low, view.high - bearing, head, where, is_sure)


def _is_screw_shape(
    view: View, recess: Recess, head: float, radius: float, shoulder: float, bearing: float, bore: float
) -> bool | None:
    """As `_is_bolt_shape`, for a recess in a round head; `shoulder`: its radius, 0 for none."""
    height, wide = (view.high - bearing) / (2.0 * radius), head / radius
    slender = (bearing - view.low) / (2.0 * radius)
    is_sure = bore <= NARROW_BORE * radius and not _steps(view, bearing, radius)
    is_socket = recess.drive != "slot" and (recess.drive != "square socket" or not bore)
    if wide < HEAD_TO_SHANK[0]:
        is_plug = wide >= COLLAR and (view.high - bearing) <= 1.5 * COLLAR_HEIGHT * 2.0 * head and not shoulder
        return is_sure and is_socket if is_plug and COLLAR_LENGTH[0] <= slender <= COLLAR_LENGTH[1] else None
    if height > MOST_HEAD or wide > (WIDEST_SHOULDER_HEAD if shoulder else MOST_HEAD_WIDTH) or slender < SHORT[0]:
        return None
    # Of a short thread, the usual screw's looks take the head.
    is_short = slender < SHANK_SLENDER or bearing < view.low + 0.4 * (view.high - view.low)
    if not (shoulder or bore or is_short or view.is_hollow()):
        return None  # a usual screw, or not
    return is_sure and (is_socket or not is_short) and slender >= SHORT[1]


def _headless(view: View, recess: Recess, radius: float, tip: float, bore: float) -> Found | None:
    """A set screw, with a dog point of radius `tip` or a bore."""
    full = view.high - view.low
    if recess.reach > HEADLESS_RECESS * radius and recess.drive != "slot":
        return None
    if full < SHANK_SLENDER * 2.0 * radius or not (bore or tip < radius):
        return None
    where = "in a rod" + (f" with a point of {mm(2.0 * tip)}" if tip < radius else "") + (" and a bore" if bore else "")
    return _screw(recess, radius, full, 0.0, radius, where, bore <= NARROW_BORE * tip)


def _screw(
    recess: Recess, radius: float, length: float, height: float, ring: float, where: str, is_sure: bool
) -> Found:
    flats = recess.width if recess.drive in FLAT_SOCKETS else np.nan
    width = f", {mm(flats)} across flats," if flats == flats else ""
    because = f"{article(recess.drive)}{width} {where}"
    return Found(
        *("screw", 2.0 * radius, flats, length, height, ring, because, recess.drive),
        is_strong=is_sure,
        is_known_by_name=not is_sure,
        width=recess.width,
    )


def wing_screw(view: View) -> Found | None:
    """Two wings that rise from a hub, on a shank."""
    wings = wings_of(view.across, view.r)
    if wings is None or view.inner():
        return None
    hub, reach = wings
    wing = float(view.z[view.r > 1.2 * hub].min())
    radius = widest(view, view.low, view.low + 0.4 * (wing - view.low))
    if not WING_SHANK[0] <= radius / hub <= WING_SHANK[1]:
        return None
    bearing = bearing_of(view, radius, hub)
    length = bearing - view.low
    # Beside the plane of the wings, the hub is highest.
    tip = wing_tip(view.across, view.r)
    beside = np.abs(view.across @ np.array([-tip[1], tip[0]]))
    top = float(view.z[beside > 0.4 * hub].max())
    if length < SHANK_SLENDER * 2.0 * radius or view.high - bearing > MOST_WING * reach or wing < bearing:
        return None
    because = f"two wings on a hub of {mm(2.0 * hub)}, on a shank of {mm(2.0 * radius)}"
    highest = float(view.z[view.r > 1.2 * hub].max())
    is_risen = highest - top > 0.05 * (view.high - bearing) and highest > view.high - 0.02 * (view.high - bearing)
    ring = 0.5 * (radius + hub)
    return Found(
        *("screw", 2.0 * radius, np.nan, length, view.high - bearing, ring, because, "wings"),
        is_strong=is_risen,
        is_known_by_name=not is_risen,
    )


def carriage_bolt(view: View) -> Found | None:
    """A round head without a recess over a square neck, which its joint holds: it has no drive."""
    if view.inner() or any(view.recesses) or not any(b.directions > 6 for b in view.outer()):
        return None
    head = float(view.r.max())
    under = float(view.z[view.r > 0.9 * head].min())
    radius = widest(view, view.low, view.low + 0.3 * (under - view.low))
    if not radius > 0.0 or not ROUND_HEAD[0] <= head / radius <= ROUND_HEAD[1]:
        return None
    # The neck's flats may be as far from the axis as the shank: its corners show it.
    beside = (view.z < under - 0.02 * radius) & (view.r > NECK_CORNER * radius)
    if not beside.any():
        return None
    corner = float(view.r[beside].max())
    far = beside & (view.r > 0.98 * corner)
    turn = np.arctan2(view.across[far, 1], view.across[far, 0])
    if abs(np.exp(4j * turn).mean()) < 0.98 or abs(np.exp(1j * turn).mean()) > 0.2:
        return None
    side, low = corner / np.sqrt(2.0), float(view.z[beside].min())
    diameter, length = 2.0 * radius, under - view.low
    is_neck = SQUARE_NECK[0] <= radius / side <= SQUARE_NECK[1]
    is_neck = is_neck and NECK_HEIGHT[0] <= (under - low) / diameter <= NECK_HEIGHT[1]
    is_head = ROUND_HEIGHT[0] <= (view.high - under) / diameter <= ROUND_HEIGHT[1]
    if not (is_neck and is_head and low - view.low >= SHANK_SLENDER * diameter):
        return None
    because = f"a round head over a square neck of {mm(2.0 * side)}, on a shank of {mm(diameter)}"
    return Found("bolt", diameter, np.nan, length, view.high - under, 0.8 * head, because)


def _bore(view: View) -> float:
    """The radius of the bore right through a shape; 0 for none. A recess at an end is not a part of it."""
    if not view.is_hollow():
        return 0.0
    inner = sorted(view.inner(), key=lambda b: b.low)
    high, wide = inner[0].high, inner[0].radius
    for each in inner[1:]:
        # Between sections there may be a cone, as of a drill.
        if each.low - high > CONE * abs(each.radius - wide) + 0.02 * (view.high - view.low):
            return 0.0
        if each.high > high:
            high, wide = each.high, each.radius
    return max((b.radius for b in inner if not _is_recess(view, b)), default=0.0)


def _is_recess(view: View, inner: Body) -> bool:
    """Whether an inner body is a part of a recess at an end: as wide at most, and no longer."""
    for recess in view.recesses:
        if recess is not None and inner.radius < recess.reach:
            z = view.walls.corners[recess.walls][:, :, 2]
            slack = 0.01 * (view.high - view.low)
            if inner.low > float(z.min()) - slack and inner.high < float(z.max()) + slack:
                return True
    return False


def widest(view: View, low: float, high: float) -> float:
    """The greatest radius between two heights; 0 where no corner lies there."""
    return float(view.r[(view.z >= low) & (view.z < high)].max(initial=0.0))


def is_shaft(view: View, bearing: float, radius: float) -> bool:
    """Whether the part below a head has sections as a stepped shaft has, and no bolt: under a high head, or to a thin
    end."""
    found = [b for b in view.outer() if b.low < bearing - 1e-6 * radius and b.height >= LEAST_SECTION * 2.0 * b.radius]
    found = sorted((b for b in found if b.radius <= 1.01 * radius), key=lambda b: b.low)
    sections = [
        b for b in found if all(min(b.high, c.high) - max(b.low, c.low) < 0.1 * b.height for c in found if c is not b)
    ]
    if len(sections) < 2 or min(b.radius for b in sections) > SECTION * max(b.radius for b in sections):
        return False
    is_thin = sections[0].radius < THIN_END * max(b.radius for b in sections)
    return is_thin or view.high - bearing > HIGH_HEAD * 2.0 * radius


def _steps(view: View, bearing: float, radius: float) -> bool:
    """Whether the part below the bearing has a long section much thinner than its thread."""
    length = bearing - view.low
    return any(b.radius < STEP * radius and b.low < bearing and b.height > 0.25 * length for b in view.outer())


LESS_USUAL = (standoff, hexagon_headed, recessed, carriage_bolt)
"""The forms, in the order in which they are tried."""
