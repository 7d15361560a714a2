"""The cast housing: two halves, each with a flange, ribs, bosses for bearings, pads and holes. Millimetres."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..mesh import Floats, Ints, times
from .bodies import GASKET_ROOM, TRIM
from .fits import METRIC, deviation
from .layout import FLANGE, FLANGE_THICK, WALL, Half, Layout, Station, outline, side_segments
from .polygon import offset
from .solid import Cut, Row, Solid
from .standard import threaded_hole

EDGE = 1.5
RIB = 12.0


class FaceHole(NamedTuple):
    """A hole in the pads' face, or in the `outer` face beside them; rows of (radius, depth), the last of radius 0."""

    x: float
    y: float
    rows: tuple[Row, ...]
    outer: bool = False


class SideHole(NamedTuple):
    """A hole in a side: distance from the side's middle (counter-clockwise), height above the split, rows.

    The last row of a through hole has the wall's depth. No rows: the hole of the threaded plug.
    """

    side: str
    place: float
    height: float
    rows: tuple[Row, ...]


def tapped(cut: Cut, size: int, depth: float) -> tuple[Row, ...]:
    """A blind tapped hole: rows of (radius, depth)."""
    m = METRIC[size]
    core = m.core / 2.0 + (cut.ease + (m.size - m.core) / 2.0 if cut.ease else 0.0)
    mouth = core + 0.5 * m.pitch
    rows = [(mouth, 0.0), (core, mouth - core)] if cut.shows(mouth - core) else [(core, 0.0)]
    return (*rows, (core, depth), (0.0, depth + 0.55 * m.core / 2.0))


def through(cut: Cut, size: int, depth: float) -> tuple[Row, Row]:
    """A clearance hole: rows of (radius, depth)."""
    radius = METRIC[size].through / 2.0 + cut.ease
    return ((radius, 0.0), (radius, depth))


def bolt_circle(centre: Sequence[float], radius: float, count: int, start: float) -> list[tuple[float, float]]:
    """Places of bolts around a centre; `start`: the first one's angle."""
    angle = start + np.arange(count) * (2.0 * np.pi / count)
    return [(float(centre[0] + radius * np.cos(a)), float(centre[1] + radius * np.sin(a))) for a in angle]


def chain(cut: Cut, circles: Sequence[tuple[float, float, float]], width: float) -> Floats:
    """The outline (n, 2) of circles (x, y, radius) joined by bars, counter-clockwise."""

    def arc(k: int, come: float, go: float) -> Floats:
        x, y, r = circles[k]
        alpha = np.arcsin(width / 2.0 / r)
        start, stop = come + alpha, go - alpha
        stop += 2.0 * np.pi * np.ceil((start - stop) / (2.0 * np.pi))
        angle = np.linspace(start, stop, cut.arc(r, stop - start, 2) + 1)
        return np.stack([x + r * np.cos(angle), y + r * np.sin(angle)], axis=1)

    last = len(circles) - 1
    ways = [float(np.arctan2(b[1] - a[1], b[0] - a[0])) for a, b in itertools.pairwise(circles)]
    walk = [(0, ways[0], ways[0])]
    walk += [(k, ways[k - 1] + np.pi, ways[k]) for k in range(1, last)]
    walk += [(last, ways[-1] + np.pi, ways[-1] + np.pi)]
    walk += [(k, ways[k], ways[k - 1] + np.pi) for k in range(last - 1, 0, -1)]
    return np.concatenate([arc(*each) for each in walk])


def opening(station: Station) -> float:
    """Radius of the hole outside of a bearing's seat."""
    return station.bearing.outside / 2.0 - 3.0


def case(
    cut: Cut, plan: Layout, half: Half, holes: tuple[FaceHole, ...], sides: tuple[SideHole, ...], dowel: float
) -> Solid:
    """One half of the housing in its place; `dowel`: radius of the dowels' holes."""
    solid = Solid()
    pose = np.diag([1.0, 1.0, half.sign, 1.0])
    pose[2, 3] = half.start
    base = plan.base
    ribs = () if cut.plain else plan.slope_ribs if sides else plan.ribs
    fine = cut.shows(EDGE)
    edge = EDGE if fine else 0.0

    def drawn(distance: float, rib: float, heights: Sequence[float]) -> tuple[Ints, Ints]:
        return solid.outline(outline(cut, base, distance, ribs, rib), heights, pose)

    def round_holes(places: Sequence[tuple[float, float]], rows: Sequence[Row]) -> list[tuple[Ints, Ints]]:
        n = cut.circle(rows[0][0])
        return [solid.turned(rows, n, times(pose, _at(x, y))) for x, y in places]

    # the split face and the flange
    plain = outline(cut, base, WALL + FLANGE)
    if edge:
        inner = outline(cut, base, WALL + FLANGE - 1.0)
        rings = [(plain, 0.0), (plain, FLANGE_THICK - 1.0), (inner, FLANGE_THICK)]
    else:
        rings = [(plain, 0.0), (plain, FLANGE_THICK)]
    rim, lip = solid.tube(times(_at_heights(rings), pose[:3, :3].T) + pose[:3, 3])
    cavity, floor = solid.outline(outline(cut, base, 0.0), (0.0, half.floor), pose)
    core = tapped(cut, 6, 1.0)[-2][0]
    bolts = []
    for k, place in enumerate(plan.flange_bolts):
        into = half.sign > 0.0 and k in plan.tapped_bolts
        bolts += round_holes([place], ((core, 0.0), (core, FLANGE_THICK)) if into else through(cut, 6, FLANGE_THICK))
    pins = round_holes(plan.dowels, ((dowel + cut.ease, 0.0), (dowel + cut.ease, 7.2), (0.0, 8.7)))
    solid.face(rim, cavity, *(low for low, _ in bolts), *(low for low, _ in pins))
    # the walls, with the holes of the sides
    foot, _ = drawn(WALL, RIB, (FLANGE_THICK,))
    head, _ = drawn(WALL, 2.0, (half.outer - edge,))
    solid.face(lip, foot, *(high for _, high in bolts))
    outside, inside = side_segments(cut, base, ribs), side_segments(cut, base, ())
    holed = {side: plan.side(side) for side in dict.fromkeys(hole.side for hole in sides)}
    solid.wall(foot, head, [outside[number] for number, _, _ in holed.values()])
    if holed:
        cavity_walls = {number: inside[number] for number, _, _ in holed.values()}
        solid.open_wall(cavity, floor, list(cavity_walls.values()))
    for side, (number, middle, normal) in holed.items():
        mouths, ends = [], []
        for hole in (h for h in sides if h.side == side):
            frame = np.eye(4)
            frame[:3, 0], frame[:3, 2] = (-normal[1], normal[0], 0.0), (*normal, 0.0)
            frame[:3, 1] = np.cross(frame[:3, 2], frame[:3, 0])
            frame[:2, 3] = middle + hole.place * frame[:2, 0]
            frame[2, 3] = half.z(hole.height)
            if hole.rows:
                rows = [(r, -depth) for r, depth in hole.rows]
                mouth, end = solid.turned(rows, cut.circle(hole.rows[0][0]), frame)
            else:
                mouth, end = threaded_hole(solid, cut, frame, WALL, 1.5)
            mouths.append(mouth)
            ends += [end] if len(end) else []
        a, b = outside[number], (outside[number] + 1) % len(foot)
        solid.face(np.array([foot[a], foot[b], head[b], head[a]]), *mouths)
        a, b = inside[number], (inside[number] + 1) % len(cavity)
        solid.face(np.array([cavity[a], cavity[b], floor[b], floor[a]]), *ends)
    # the outer face with its pads
    top = drawn(WALL - edge, 2.0, (half.outer,))[0] if edge else head
    if edge:
        solid.wall(head, top)
    pads = chain(cut, [(s.x, s.y, s.pad) for s in plan.stations], 16.0)
    rings = [(pads, half.outer), (pads, half.pad - edge)]
    if edge:
        rings.append((offset(pads, -edge), half.pad))
    low, high = solid.tube(times(_at_heights(rings), pose[:3, :3].T) + pose[:3, 3])
    # the seats of the bearings
    bosses, mouths = [], []
    for s in plan.stations:
        seat = (s.bearing.outside + deviation("H7", s.bearing.outside)) / 2.0 + cut.ease
        out = seat + 6.0
        rows = cut.sharp([(out + 1.5, half.floor), (out, half.floor - 2.5), (out, half.boss)], 2.5)
        foot, rim = solid.turned(rows, cut.circle(out), times(pose, _at(s.x, s.y)))
        rows = [(seat + 0.6, half.boss), (seat, half.boss + 0.6)] if fine else [(seat, half.boss)]
        wide = opening(s) + deviation("H7", 2.0 * opening(s)) / 2.0 + cut.ease
        stop = half.stop(s.bearing)
        rows += [(seat, stop), (wide, stop), (wide, half.pad - edge)]
        rows += [(wide + edge, half.pad)] if fine else []
        start, end = solid.turned(rows, cut.circle(seat), times(pose, _at(s.x, s.y)))
        solid.face(rim, start)
        bosses.append(foot)
        mouths.append(end)
    solid.face(floor, *bosses)
    beside: list[Ints] = []
    for x, y, drilled, outer in holes:
        face = half.outer if outer else half.pad
        mouth = solid.turned(
            [(r, face - depth) for r, depth in drilled], cut.circle(drilled[0][0]), times(pose, _at(x, y))
        )[0]
        (beside if outer else mouths).append(mouth)
    solid.face(top, low, *beside)
    solid.face(high, *mouths)
    return solid


def _at(x: float, y: float) -> Floats:
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return pose


def _at_heights(rings: Sequence[tuple[Floats, float]]) -> Floats:
    return np.stack([np.column_stack([points, np.full(len(points), z)]) for points, z in rings])


def split_gasket(cut: Cut, plan: Layout, low: float, high: float) -> Solid:
    """The gasket between the halves, from z = low to z = high, in its place."""
    solid = Solid()
    outer = solid.outline(outline(cut, plan.base, WALL + FLANGE - TRIM), (low, high))
    inner = solid.outline(outline(cut, plan.base, TRIM), (low, high))
    loops = []
    for places, radius in ((plan.flange_bolts, METRIC[6].through / 2.0 + GASKET_ROOM), (plan.dowels, 3.3)):
        loops += [solid.turned([(radius, low), (radius, high)], cut.circle(radius), _at(x, y)) for x, y in places]
    for k in (0, 1):
        solid.face(outer[k], inner[k], *(each[k] for each in loops))
    return solid
