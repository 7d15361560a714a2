"""Bodies on flanges and plates with holes: covers, gaskets, accessories, brackets. Millimetres, standing on z = 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..mesh import Floats, Ints, times
from ..shapes import Path, sweep
from .polygon import offset, rectangle, rounded
from .solid import Cut, Row, Solid

TRIM = 0.3
"""By how much gaskets are smaller than the faces that they seal, millimetres."""
GASKET_ROOM = 0.2
"""By how much a gasket's holes are wider than those of its flange, on each side: it spreads when it is squeezed."""
Hole = tuple[float, float, float]
"""x, y and radius of a through hole."""
Blind = tuple[float, float, tuple[Row, ...]]
"""x, y and rows (radius, depth) of a hole from the top; the last of radius 0."""
Shape = tuple[float, ...]
"""An outline: (radius,) of a circle, (x, y, corner) of a rectangle about the origin, or (x, y, corner, dx, dy)."""


def outline_of(cut: Cut, shape: Shape) -> Floats:
    """The points (n, 2) of an outline."""
    if len(shape) == 1:
        n = cut.circle(shape[0], 12)
        angle = (np.arange(n) + 0.31) * (2.0 * np.pi / n)
        return shape[0] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    x, y, corner = shape[:3]
    points = rectangle(x, y, corner, 1 if cut.plain else cut.arc(corner, np.pi / 2.0, 2))
    return points + np.array(shape[3:]) if len(shape) > 3 else points


def _at(x: float, y: float) -> Floats:
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return pose


def flanged(
    cut: Cut,
    shape: Shape,
    thick: float,
    up: tuple[Row, ...] = (),
    down: tuple[Row, ...] = (),
    bore: tuple[Row, ...] = (),
    holes: tuple[Hole, ...] = (),
    blinds: tuple[Blind, ...] = (),
) -> Solid:
    """A flange from z = 0 to `thick` with through holes, a turned body above, a turned spigot below.

    `up` begins on the flange, `down` begins under it, each (radius, z); `bore` runs from the bottom to the top, or ends
    at radius 0. `blinds` are holes from the top of the body.
    """
    solid = Solid()
    up, down, bore = (tuple(cut.sharp(rows)) for rows in (up, down, bore))
    points = outline_of(cut, shape)
    edge = min(0.8, thick / 4.0) if cut.shows(0.8) else 0.0
    if edge:
        small = offset(points, -edge)
        rings = [(small, 0.0), (points, edge), (points, thick - edge), (small, thick)]
    else:
        rings = [(points, 0.0), (points, thick)]
    low, high = solid.tube(np.stack([np.column_stack([p, np.full(len(p), z)]) for p, z in rings]))
    drilled = [solid.turned([(r, 0.0), (r, thick)], cut.circle(r), _at(x, y)) for x, y, r in holes]
    top_z = up[-1][1] if up else thick
    if up:
        foot, top = solid.turned(up, cut.circle(max(r for r, _ in up)))
        solid.face(high, foot, *(last for _, last in drilled))
    else:
        top = high
    if down:
        foot, bottom = solid.turned(down, cut.circle(max(r for r, _ in down)))
        solid.face(low, foot, *(first for first, _ in drilled))
    else:
        bottom = low
    below: list[Ints] = []
    above: list[Ints] = []
    if bore:
        first, last = solid.turned(bore, cut.circle(max(r for r, _ in bore)))
        below.append(first)
        above += [last] if len(last) else []
    above += [
        solid.turned([(r, top_z - d) for r, d in rows], cut.circle(rows[0][0]), _at(x, y))[0] for x, y, rows in blinds
    ]
    if len(top):
        solid.face(top, *above, *(() if up else [last for _, last in drilled]))
    if len(bottom):
        solid.face(bottom, *below, *(() if down else [first for first, _ in drilled]))
    return solid


class Drill(NamedTuple):
    """A hole across an extruded part, at right angles to a flat side.

    `side`: number of the outline's segment where it begins; `place`: distance from that segment's start; `z`: height;
    rows of (radius, depth). The last row has radius 0, or it is in the plane of the segment `exit`.
    """

    side: int
    place: float
    z: float
    rows: tuple[Row, ...]
    exit: int = -1


def extruded(
    cut: Cut,
    outline: tuple[tuple[float, float], ...],
    low: float,
    high: float,
    drills: tuple[Drill, ...] = (),
    holes: tuple[Hole, ...] = (),
    pits: tuple[tuple[Blind, ...], tuple[Blind, ...]] = ((), ()),
) -> Solid:
    """An outline drawn along z, with holes along z, blind ones at both ends (`pits`), and holes across."""
    solid = Solid()
    points = np.array(outline)
    bottom, top = solid.outline(points, (low, high))
    mouths: dict[int, list[Ints]] = {}
    for drill in drills:
        start = points[drill.side]
        way = points[(drill.side + 1) % len(points)] - start
        way = way / np.sqrt(times(way, way))
        pose = np.eye(4)
        pose[:3, 0], pose[:3, 2] = (*way, 0.0), (way[1], -way[0], 0.0)
        pose[:3, 1] = np.cross(pose[:3, 2], pose[:3, 0])
        pose[:3, 3] = (*(start + way * drill.place), drill.z)
        rows = [(r, -depth) for r, depth in drill.rows]
        mouth, end = solid.turned(rows, cut.circle(max(r for r, _ in rows)), pose)
        mouths.setdefault(drill.side, []).append(mouth)
        if len(end):
            mouths.setdefault(drill.exit, []).append(end)
    solid.open_wall(bottom, top, list(mouths))
    for side, loops in mouths.items():
        ahead = (side + 1) % len(points)
        solid.face(np.array([bottom[side], bottom[ahead], top[ahead], top[side]]), *loops)
    drilled = [solid.turned([(r, low), (r, high)], cut.circle(r), _at(x, y)) for x, y, r in holes]
    under = [
        solid.turned([(r, low + d) for r, d in rows], cut.circle(rows[0][0]), _at(x, y))[0] for x, y, rows in pits[0]
    ]
    over = [
        solid.turned([(r, high - d) for r, d in rows], cut.circle(rows[0][0]), _at(x, y))[0] for x, y, rows in pits[1]
    ]
    solid.face(bottom, *(first for first, _ in drilled), *under)
    solid.face(top, *(last for _, last in drilled), *over)
    return solid


def swept(
    cut: Cut, corners: tuple[tuple[float, float, float], ...], bend: float, rows: tuple[Row, ...], bore: float
) -> Solid:
    """A pipe along a polyline with round bends; `rows`: (radius, way from the end) of both ends."""
    path = bent(cut, np.array(corners), bend, rows[-1][0])
    ends = []
    for sign in (1, -1):
        point, way = path.points[0 if sign > 0 else -1], path.tangents[0 if sign > 0 else -1] * sign
        ends.append([(point + way * s, way * sign, r) for r, s in rows])
    stations = [
        *ends[0],
        *((p, t, rows[-1][0]) for p, t in zip(path.points[1:-1], path.tangents[1:-1], strict=True)),
        *ends[1][::-1],
    ]
    line = Path(np.array([p for p, _, _ in stations]), np.array([t for _, t, _ in stations]))
    n = cut.circle(rows[-1][0], 6)
    angle = (np.arange(n) + 0.4) * (2.0 * np.pi / n)
    section = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    solid = Solid()
    first, last = solid.tube(sweep(line, section, np.array([r for _, _, r in stations])))
    if bore:
        inner_first, inner_last = solid.tube(sweep(path, section * bore))
        solid.wall(first, inner_first)
        solid.wall(last, inner_last)
    else:
        solid.face(first)
        solid.face(last)
    return solid


def bent(cut: Cut, corners: Floats, radius: float, tube: float) -> Path:
    """A polyline (k, 3) with its corners bent round."""
    points, tangents = [corners[:1]], []
    legs = np.diff(corners, axis=0)
    ways = legs / np.sqrt((legs * legs).sum(axis=1))[:, None]
    tangents.append(ways[:1])
    for corner, u, v in zip(corners[1:-1], ways, ways[1:], strict=False):
        turn = float(np.arccos(np.clip(times(u, v), -1.0, 1.0)))
        inward = v - u * times(u, v)
        inward /= np.sqrt(times(inward, inward))
        angle = np.linspace(0.0, turn, cut.arc(radius + tube, turn, 2) + 1)[:, None]
        points.append(
            corner - u * radius * np.tan(turn / 2.0) + radius * (np.sin(angle) * u + (1.0 - np.cos(angle)) * inward)
        )
        tangents.append(np.cos(angle) * u + np.sin(angle) * inward)
    return Path(np.concatenate([*points, corners[-1:]]), np.concatenate([*tangents, ways[-1:]]))


def plate(
    cut: Cut,
    corners: tuple[tuple[float, float], ...],
    corner: float,
    thick: float,
    holes: tuple[Hole, ...] = (),
    blinds: tuple[Blind, ...] = (),
) -> Solid:
    """A plate from z = 0 to `thick`: a polygon with round corners, and holes."""
    solid = Solid()
    points = np.array(corners)
    if corner and not cut.plain:
        points = rounded(points, corner, cut.arc(corner, np.pi / 2.0, 2))
    edge = min(0.5, thick / 4.0) if cut.shows(0.5) else 0.0
    rings = [(points, 0.0), (points, thick)]
    if edge:
        small = offset(points, -edge)
        rings = [(small, 0.0), (points, edge), (points, thick - edge), (small, thick)]
    low, high = solid.tube(np.stack([np.column_stack([p, np.full(len(p), z)]) for p, z in rings]))
    drilled = [solid.turned([(r, 0.0), (r, thick)], cut.circle(r), _at(x, y)) for x, y, r in holes]
    pits = [
        solid.turned([(r, thick - d) for r, d in rows], cut.circle(rows[0][0]), _at(x, y))[0] for x, y, rows in blinds
    ]
    solid.face(low, *(first for first, _ in drilled))
    solid.face(high, *(last for _, last in drilled), *pits)
    return solid


def gasket(cut: Cut, shape: Shape, bore: float, thick: float, holes: Sequence[Hole]) -> Solid:
    """A flat gasket on z = 0 with a round opening and holes, a little smaller than the outline of its flange."""
    solid = Solid()
    low, high = solid.outline(offset(outline_of(cut, shape), -TRIM), (0.0, thick))
    drilled = [solid.turned([(r, 0.0), (r, thick)], cut.circle(r), _at(x, y)) for x, y, r in (*holes, (0.0, 0.0, bore))]
    solid.face(low, *(first for first, _ in drilled))
    solid.face(high, *(last for _, last in drilled))
    return solid
