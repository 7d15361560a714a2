"""Rarer fasteners: external Torx, square heads as wide as their thread, tapered plugs, and heads turned by hand.

`fastener_shape` examines a shape for these only if it is none of the others. The proportions are those of the
standards, and leave out what looks alike: splined and square shafts, gears, pulleys, serrated rods.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from feeler.plan.fastener_drive import Outline, Recess, outline_at
from feeler.plan.fastener_forms import above_collar, is_shaft, widest
from feeler.plan.fastener_view import (
    FLAT_SOCKETS,
    SHANK_SLENDER,
    Body,
    Found,
    View,
    article,
    bearing_of,
    crossbar_of,
    mm,
)

Floats = npt.NDArray[np.float64]

LEVELS = (0.03, 0.06, 0.1, 0.16, 0.25, 0.4)
"""Where heads are cut, from the top, in heights of the shape: chamfers and domes are above."""
ROUND = 0.74
"""The least reach of a shank in any direction, relative to the greatest: 0.87 for a hexagon, 0.71 for a square."""
_WAYS = np.array([[np.cos(turn), np.sin(turn)] for turn in np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)])
LOBES = (1.22, 1.55)
"""Radius of the points of an external Torx, relative to the radius between them: about 1.39; 1.13 to 1.27
for splined shafts with six teeth (ISO 14)."""
ALIKE = 0.94
"""The least correlation of its outline with a wave of six: teeth of splines are steeper."""
TORX_TO_THREAD = (1.0, 1.6)
"""Width across its points, relative to the thread: 1.08 to 1.29, more for threads modelled with the core diameter."""
TORX_HEIGHT = (0.35, 1.5)
"""Height of such a head with its flange, in diameters of the thread."""
FLANGE = 2.0
"""The greatest radius of its flange, relative to that of its points."""
SQUARE_TO_THREAD = (0.88, 1.08)
"""Thread diameter of a square-head bolt, relative to its width across flats: 0.92 to 1 in DIN 478 to 480."""
SQUARE_HEIGHT = (0.55, 1.25)
"""Height of its head, in diameters of the thread: 1 in DIN 478 to 480."""
SQUARE_COLLAR = (1.05, 1.5)
"""Radius of its collar, relative to half the width across the corners: square pegs on wider discs are no bolts."""
TAPER = (0.02, 0.045)
"""Slope of the radius of a tapered pipe thread along its axis: 1/32 in ISO 7."""
STRAIGHT = 0.006
"""How far its walls may be from that line, relative to its radius."""
PLUG_SLENDER = (0.3, 1.6)
"""Length of a plug's thread, in its diameters."""
PLUG_TO_FLATS = (0.9, 2.0)
"""Its diameter, relative to the width across flats of its head."""
PLUG_HEIGHT = (0.4, 1.4)
"""Height of that head, in widths across flats."""
PLUG_RECESS = 0.8
"""The greatest reach of a recess in it, relative to its radius."""
TEETH = 16
"""The least number of grooves of a knurl."""
GROOVE = (0.003, 0.12)
"""Their depth, relative to the radius of the head."""
FLANK_DEG = (33.0, 54.0)
"""Angle between the normals of their flanks and the radius: 37 to 45 degrees in DIN 82; 60 and more for gears, splines,
pulleys and serrations."""
FLANK_SPREAD_DEG = 8.0
FLANK_SHARE = 0.35
"""The least share of flanks in the outline of a knurled head."""
ROUND_DEG = 20.0
"""Facets whose normals are nearer to the radius belong to the round between the grooves."""
KNURL_TO_THREAD = (1.5, 6.5)
"""Radius of a knurled head, relative to its thread: 2 to 5 in DIN 464 and DIN 653."""
KNURL_HEIGHT = (0.08, 1.25)
"""Height of that head with its collar, relative to its diameter."""
BAR_TO_THREAD = (0.4, 1.15)
"""Thickness of a crossbar, relative to the thread: 0.6 to 0.85 in DIN 6304 and DIN 6306."""
BAR_REACH = (2.5, 10.0)
"""Its length, relative to the thread: 5 to 7 there."""
BAR_ROUND = (0.75, 1.3)
"""Its thickness along the axis, relative to that across."""
HUB_TO_THREAD = (1.15, 3.0)
"""Diameter of the head that it is in, relative to the thread."""
HUB_HEIGHT = 3.5
"""The greatest height of that head, in diameters of the thread."""
BAR_SLENDER = 1.0
"""The least length of such a screw, in diameters."""


def external_torx(view: View) -> Found | None:
    """Six lobes on a shank, with a flange or without."""
    if view.inner() or any(view.recesses):
        return None
    lobed = next(((level, found) for level, found in _cuts(view) if found.is_lobed(LOBES, ALIKE)), None)
    if lobed is None:
        return None
    level, outline = lobed
    reach, radius = outline.reach, _thread(view, level)
    wide = widest(view, view.low, level)
    if not radius > 0.0 or not TORX_TO_THREAD[0] <= reach / radius <= TORX_TO_THREAD[1] or wide > FLANGE * reach:
        return None
    bearing = bearing_of(view, radius, max(wide, reach))
    length, height, size = bearing - view.low, view.high - bearing, 2.0 * radius
    if length < SHANK_SLENDER * size or not TORX_HEIGHT[0] <= height / size <= TORX_HEIGHT[1]:
        return None
    if level < bearing or is_shaft(view, bearing, radius):
        return None
    because = f"an external Torx, {mm(2.0 * reach)} across its points, on a shank of {mm(size)}"
    return Found("bolt", size, np.nan, length, height, 0.9 * max(wide, reach), because, "torx", width=2.0 * reach)


def square_headed(view: View) -> Found | None:
    """A square head as wide as its thread, with a collar or without, as in DIN 478 to 480."""
    if view.inner() or any(view.recesses):
        return None
    head, wide = _square(view), float(view.r.max())
    if head is None:
        return None
    radius, corner = _thread(view, head.low), np.sqrt(2.0) * head.radius
    if not radius > 0.0 or not SQUARE_TO_THREAD[0] <= radius / head.radius <= SQUARE_TO_THREAD[1]:
        return None
    if wide > 1.02 * corner and not SQUARE_COLLAR[0] <= wide / corner <= SQUARE_COLLAR[1]:
        return None
    bearing = bearing_of(view, radius, wide)
    length, height, size = bearing - view.low, view.high - bearing, 2.0 * radius
    if length < SHANK_SLENDER * size or not SQUARE_HEIGHT[0] <= height / size <= SQUARE_HEIGHT[1]:
        return None
    if is_shaft(view, bearing, radius):
        return None
    flats = 2.0 * head.radius
    because = f"a square, {mm(flats)} across flats, on a shank of {mm(size)}"
    return Found("bolt", size, flats, length, height, 0.9 * head.radius, because, "square")


def tapered_plug(view: View) -> Found | None:
    """A pipe plug: a square or hexagonal head, or a recess for a tool, on a short thread.

    A thread that tapers shows it; a straight one needs a name.
    """
    recess, head = view.recesses[0], None
    if view.recesses[1] is not None or view.is_hollow():
        return None
    if recess is None:
        head = _square(view) or max(
            (b for b in view.outer() if b.sides == 6 and b.high > view.high - 0.3 * b.height),
            key=lambda b: b.high,
            default=None,
        )
        if head is None or view.inner():
            return None
    top = view.high if head is None else head.low
    tapered = _tapered(view, top, recess)
    radius = _thread(view, top) if tapered is None else tapered
    if not radius > 0.0:
        return None
    size, length = 2.0 * radius, top - view.low
    if not PLUG_SLENDER[0] <= length / size <= PLUG_SLENDER[1] or float(view.r.max()) > 1.02 * max(
        radius, 0.0 if head is None else np.sqrt(2.0) * head.radius
    ):
        return None
    where = f"a {'short' if tapered is None else 'tapered'} thread of {mm(size)}"
    if recess is not None:
        if recess.drive not in FLAT_SOCKETS or recess.reach > PLUG_RECESS * radius:
            return None
        because = f"{article(recess.drive)}, {mm(recess.width)} across flats, in {where}"
        found = Found("screw", size, recess.width, length, 0.0, radius, because, recess.drive)
        return _if_named(found, tapered is None)
    assert head is not None
    flats, height = 2.0 * head.radius, view.high - top
    name = "square" if head.sides == 4 else "hexagon"
    if not PLUG_TO_FLATS[0] <= size / flats <= PLUG_TO_FLATS[1]:
        return None
    if not PLUG_HEIGHT[0] <= height / flats <= PLUG_HEIGHT[1]:
        return None
    because = f"{article(name)}, {mm(flats)} across flats, on {where}"
    return _if_named(Found("bolt", size, flats, length, height, 0.9 * radius, because, name), tapered is None)


def _if_named(found: Found, is_needed: bool) -> Found:
    """A form that other things have as often, if a name is needed."""
    return replace(found, is_strong=not is_needed, is_known_by_name=is_needed)


def knurled_screw(view: View) -> Found | None:
    """A round head with many fine grooves, on a shank: it is turned by hand."""
    if view.inner() or any(view.recesses):
        return None
    knurled = next(((level, found) for level, found in _cuts(view) if _is_knurled(found)), None)
    if knurled is None:
        return None
    level, outline = knurled
    radius, head = _thread(view, level), outline.reach
    if not radius > 0.0 or not KNURL_TO_THREAD[0] <= head / radius <= KNURL_TO_THREAD[1]:
        return None
    if float(view.r.max()) > 1.02 * head:
        return None
    bearing = bearing_of(view, radius, min(head, 2.0 * radius))
    length, height, size = bearing - view.low, view.high - bearing, 2.0 * radius
    if length < SHANK_SLENDER * size or not KNURL_HEIGHT[0] <= height / (2.0 * head) <= KNURL_HEIGHT[1]:
        return None
    if level < bearing or is_shaft(view, bearing, radius):
        return None
    because = f"a knurled head of {mm(2.0 * head)} on a shank of {mm(size)}"
    ring = 0.5 * (radius + min(head, 2.0 * radius))
    return Found("screw", size, np.nan, length, height, ring, because, "hand")


def crossbar_screw(view: View) -> Found | None:
    """A bar across a head, on a shank, as in DIN 6304 and DIN 6306: it is turned by hand."""
    bar = crossbar_of(view.across, view.r)
    if bar is None or view.inner():
        return None
    hub, reach, thick = bar
    far = view.z[view.r > 0.7 * reach]
    low, high = float(far.min()), float(far.max())
    radius = _thread(view, low)
    if not radius > 0.0 or not HUB_TO_THREAD[0] <= hub / radius <= HUB_TO_THREAD[1]:
        return None
    bearing = bearing_of(view, radius, hub)
    length, height, size = bearing - view.low, view.high - bearing, 2.0 * radius
    is_bar = BAR_ROUND[0] <= (high - low) / (2.0 * thick) <= BAR_ROUND[1] and low > bearing
    is_bar = is_bar and BAR_TO_THREAD[0] <= thick / radius <= BAR_TO_THREAD[1]
    is_bar = is_bar and BAR_REACH[0] <= reach / radius <= BAR_REACH[1] and high <= view.high + 1e-9 * reach
    if not is_bar or height > HUB_HEIGHT * size or length < BAR_SLENDER * size or is_shaft(view, bearing, radius):
        return None
    because = f"a bar of {mm(2.0 * reach)} across a head of {mm(2.0 * hub)}, on a shank of {mm(size)}"
    return Found("screw", size, np.nan, length, height, 0.5 * (radius + hub), because, "hand")


def _cuts(view: View) -> list[tuple[float, Outline]]:
    """Outlines of the outside near the upper end, with their heights."""
    full, found = view.high - view.low, []
    for share in LEVELS:
        level = view.high - (share + 1e-7) * full
        outline = outline_at(view.walls, level)
        if outline is not None:
            found.append((level, outline))
    return found


def _thread(view: View, head: float) -> float:
    """The radius of the shank below a head that ends at a height, by its lower 0.4; 0 if it is not round there."""
    below = view.low + 0.4 * (head - view.low)
    points = view.across[view.z <= below]
    reaches = (points @ _WAYS.T).max(axis=0, initial=0.0)
    if not reaches.min() >= ROUND * reaches.max():
        return 0.0
    return widest(view, view.low, below)


def _square(view: View) -> Body | None:
    """A square at the upper end, above a collar or a shank that may be as wide as its flats."""
    found = above_collar(view)
    if found is None:
        corner = float(view.r.max())
        far = view.r > 0.98 * corner
        turn = np.arctan2(view.across[far, 1], view.across[far, 0])
        if abs(np.exp(4j * turn).mean()) < 0.98 or abs(np.exp(1j * turn).mean()) > 0.2:
            return None
        found = view.outer_above(float(view.z[far].min()) - 1e-6 * (view.high - view.low))
    if found is None:
        found = _narrow_square(view)
    is_at_top = found is not None and view.high - found.high < 0.3 * found.height
    return found if found is not None and found.sides == 4 and is_at_top else None


def _narrow_square(view: View) -> Body | None:
    """A square no wider than the shank below it."""
    squares = [b for b in view.outer() if b.sides == 4]
    return max(squares, key=lambda b: b.high, default=None)


def _tapered(view: View, top: float, recess: Recess | None) -> float | None:
    """The greatest radius of the outside below a height, if it tapers as pipe threads do."""
    walls = view.walls
    z = walls.corners[..., 2]
    is_below = (walls.distance > 0.0) & (z.max(axis=1) <= top + 1e-6 * (view.high - view.low))
    if recess is not None:
        is_below[recess.walls] = False
    if not is_below.any():
        return None
    points = walls.corners[is_below].reshape(-1, 3)
    heights, r = points[:, 2], np.hypot(points[:, 0], points[:, 1])
    if np.ptp(heights) < 0.5 * (top - view.low):
        return None
    slope, start = np.polyfit(heights, r, 1)
    if not TAPER[0] <= slope <= TAPER[1] or np.abs(slope * heights + start - r).max() > STRAIGHT * float(r.max()):
        return None
    return float(r.max())


def _is_knurled(outline: Outline) -> bool:
    """Whether the outline is round with many grooves whose flanks lean as those of knurls."""
    depth = (outline.reach - float(outline.radii.min())) / outline.reach
    if not GROOVE[0] <= depth <= GROOVE[1]:
        return False
    lean, middle = outline.leans(), 0.5 * (outline.begin + outline.end)
    is_flank = np.abs(lean) > ROUND_DEG
    weight = outline.length[is_flank]
    if not weight.sum() > FLANK_SHARE * outline.length.sum():
        return False
    angles = np.abs(lean[is_flank])
    middle_deg = float(np.average(angles, weights=weight))
    spread = float(np.sqrt(np.average((angles - middle_deg) ** 2, weights=weight)))
    balance = float((np.sign(lean[is_flank]) * weight).sum() / weight.sum())
    order = np.argsort(np.arctan2(middle[:, 1], middle[:, 0]))
    signs = np.sign(lean[order][is_flank[order]])
    teeth = int((signs != np.roll(signs, 1)).sum()) // 2
    is_lean = FLANK_DEG[0] <= middle_deg <= FLANK_DEG[1] and spread <= FLANK_SPREAD_DEG
    return is_lean and abs(balance) < 0.1 and teeth >= TEETH


RARE = (external_torx, square_headed, tapered_plug, knurled_screw, crossbar_screw)
"""The forms, in the order in which they are tried."""
