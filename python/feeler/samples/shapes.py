"""Tessellated solids: skins over loops, revolved and extruded profiles, plates with holes, swept pipes.

Each function returns a closed `Mesh`, counter-clockwise from outside, in metres. One rule applies to all: loops run
counter-clockwise seen from where the stack of loops goes, which makes the skin face outwards.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .mesh import Floats, Ints, Mesh, circle_angles, unit
from .tessellation import Tolerance, circle, lifted, rounded, stitch, strip, triangulate


def _bands(lower: Ints, upper: Ints) -> Ints:
    """Two triangles for each quad between rows of vertex indices, (k, n) each, closed around."""
    lower_next, upper_next = np.roll(lower, -1, axis=1), np.roll(upper, -1, axis=1)
    first = np.stack([lower, lower_next, upper_next], axis=2).reshape(-1, 3)
    second = np.stack([lower, upper_next, upper], axis=2).reshape(-1, 3)
    return np.concatenate([first, second])


def skin(rings: Floats, *, closed: bool = False, cap: Ints | None = None) -> Mesh:
    """The skin over rings (k, n, 3) of equal length.

    `closed` joins the last ring to the first; otherwise both ends get a cap, `cap` (indices of a ring) or a zigzag.
    """
    count, n = rings.shape[:2]
    index = np.arange(count * n).reshape(count, n)
    vertices = np.ascontiguousarray(rings.reshape(-1, 3))
    if closed:
        return Mesh(vertices, _bands(index, np.roll(index, -1, axis=0)))
    end = strip(n) if cap is None else cap
    return Mesh(vertices, np.concatenate([_bands(index[:-1], index[1:]), end[:, ::-1], end + (count - 1) * n]))


def skin_loops(loops: Sequence[Floats], *, closed: bool = False) -> Mesh:
    """As `skin`, over loops around z that may differ in length; unequal neighbours are stitched by angle."""
    starts = np.cumsum([0] + [len(loop) for loop in loops])
    faces: list[Ints] = []
    for low in range(len(loops) if closed else len(loops) - 1):
        high = (low + 1) % len(loops)
        a, b = loops[low], loops[high]
        if len(a) == len(b):
            index = np.arange(len(a))[None]
            faces.append(_bands(index + starts[low], index + starts[high]))
        else:
            on_low, on_high = stitch(np.arctan2(a[:, 1], a[:, 0]), np.arctan2(b[:, 1], b[:, 0]))
            faces.append(on_low + np.array([starts[low], starts[low], starts[high]]))
            faces.append(on_high + np.array([starts[low], starts[high], starts[high]]))
    if not closed:
        faces.append(strip(len(loops[0]))[:, ::-1] + starts[0])
        faces.append(strip(len(loops[-1])) + starts[-2])
    return Mesh(np.concatenate(list(loops)), np.concatenate(faces))


def revolve(profile: Floats, tol: Tolerance, *, least: int = 6, phase: float = 0.0) -> Mesh:
    """A closed profile (k, 2) of (radius, z), counter-clockwise, turned full circle about z: a ring."""
    n = tol.circle(float(profile[:, 0].max()), least)
    return skin(_rings(profile, n, phase), closed=True)


def revolve_solid(profile: Floats, tol: Tolerance, *, least: int = 6) -> Mesh:
    """An open profile (k, 2) of (radius, z), z rising along the outside, turned about z: a solid with flat ends."""
    return skin(_rings(profile, tol.circle(float(profile[:, 0].max()), least), 0.0))


def revolve_sector(profile: Floats, start: float, angle: float, tol: Tolerance, *, least: int = 2) -> Mesh:
    """A closed profile turned by `angle` from `start`: a curved panel, its two ends closed."""
    n = tol.segments(float(profile[:, 0].max()), angle, least)
    turn = start + np.linspace(0.0, angle, n + 1)
    # the profile lies in (radius, z), which turns clockwise seen from where the sweep goes: walk it backwards
    back = profile[::-1]
    rings = np.stack(
        [
            np.cos(turn)[:, None] * back[None, :, 0],
            np.sin(turn)[:, None] * back[None, :, 0],
            np.broadcast_to(back[None, :, 1], (n + 1, len(back))),
        ],
        axis=2,
    )
    cap = len(back) - 1 - triangulate(profile)[:, ::-1]
    return skin(rings, cap=cap)


def _rings(profile: Floats, n: int, phase: float) -> Floats:
    turn = np.arange(n) * (2.0 * np.pi / n) + phase
    return np.stack(
        [
            profile[:, 0, None] * np.cos(turn)[None],
            profile[:, 0, None] * np.sin(turn)[None],
            np.broadcast_to(profile[:, 1, None], (len(profile), n)),
        ],
        axis=2,
    )


@dataclass(frozen=True)
class BoltCircle:
    """Holes through a flange: profile segments `front` and `back` (a segment starts at the point of its number) are
    its two plane faces; the holes stand at angles (s + 1/2) * 2 pi / count.
    """

    front: int
    back: int
    pitch_radius: float
    hole_radius: float


def revolve_flanged(profile: Floats, tol: Tolerance, circles: Sequence[BoltCircle], count: int) -> Mesh:
    """A closed profile turned full circle about z, with `count` through holes on each bolt circle.

    Circles whose holes the tolerance does not show, or that do not fit between the chords, stay plain.
    """
    n = tol.circle(float(profile[:, 0].max()), max(6, count), count)
    rings = _rings(profile, n, 0.0)
    rows = len(profile)
    index = np.arange(rows * n).reshape(rows, n)
    vertices: list[Floats] = [rings.reshape(-1, 3)]
    faces: list[Ints] = []
    total, plain = rows * n, np.ones(rows, dtype=bool)
    for bolts in circles:
        span = [sorted((profile[s, 0], profile[(s + 1) % rows, 0])) for s in (bolts.front, bolts.back)]
        low, high = max(span[0][0], span[1][0]), min(span[0][1], span[1][1]) * np.cos(np.pi / n)
        radius, pitch = bolts.hole_radius, bolts.pitch_radius
        fits = pitch - radius > low + 1e-4 and pitch + radius < high - 1e-4
        if not (fits and tol.shows(radius) and np.arcsin(radius / pitch) * 1.1 < np.pi / count):
            continue
        h = tol.circle(radius, 6, 2)
        hole_index: list[Ints] = []
        for segment in (bolts.front, bolts.back):
            plain[segment] = False
            hole = circle(radius, h, float(profile[segment, 1])) + np.array([pitch, 0.0, 0.0])
            turn = circle_angles(count, np.pi / count)
            vertices.append(_turned_copies(hole, turn))
            hole_index.append(total + np.arange(count * h).reshape(count, h))
            total += count * h
            ends = index[segment], index[(segment + 1) % rows]
            outer, inner = ends if profile[segment, 0] > profile[(segment + 1) % rows, 0] else ends[::-1]
            flip = profile[segment, 0] < profile[(segment + 1) % rows, 0]
            made = _holed_annulus(rings.reshape(-1, 3), outer, inner, hole_index[-1], hole, pitch, count)
            faces.append(made[:, ::-1] if flip else made)
        front_is_top = profile[bolts.front, 0] > profile[(bolts.front + 1) % rows, 0]
        top, bottom = hole_index if front_is_top else hole_index[::-1]
        faces.append(_bands(top, bottom))
    upper = np.roll(index, -1, axis=0)
    faces.insert(0, _bands(index[plain], upper[plain]))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def _turned_copies(points: Floats, turn: Floats) -> Floats:
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y, z = points.T
    copies = np.stack([cosine * x - sine * y, sine * x + cosine * y, np.broadcast_to(z, (len(turn), len(z)))], axis=2)
    return copies.reshape(-1, 3)


def _holed_annulus(
    points: Floats, outer: Ints, inner: Ints, holes: Ints, hole: Floats, pitch: float, count: int
) -> Ints:
    """Faces (facing +z) between two circles of vertices with one hole in each of `count` equal sectors."""
    n = len(outer)
    per = n // count
    r_inner = float(np.hypot(*points[inner[0], :2]))
    sees = np.arccos(min(1.0, r_inner / pitch)) * 0.85  # seen from the hole, the inner circle hides the far side
    needs = 1.25 * np.arcsin(np.hypot(*(hole[0, :2] - [pitch, 0.0])) / pitch)
    width = per
    while width > 2 and (width - 2) * np.pi / n >= needs and width * np.pi / n > max(sees, needs * 1.3):
        width -= 2
    skip = (per - width) // 2
    # the cell of the first sector, turned so that its hole lies on the x axis
    columns = np.arange(skip, skip + width + 1)
    angle = columns * (2.0 * np.pi / n) - np.pi / count
    r_outer = float(np.hypot(*points[outer[0], :2]))
    loop = np.concatenate(
        [
            r_outer * np.stack([np.cos(angle), np.sin(angle)], axis=1),
            r_inner * np.stack([np.cos(angle[::-1]), np.sin(angle[::-1])], axis=1),
        ]
    )
    from_hole = np.arctan2(loop[:, 1], loop[:, 0] - pitch)
    on_loop, on_hole = stitch(from_hole, np.arctan2(hole[:, 1], hole[:, 0] - pitch))
    sector = np.arange(count)[:, None]
    cell = np.concatenate(
        [outer[(columns[None] + sector * per) % n], inner[(columns[::-1][None] + sector * per) % n]], axis=1
    )
    faces = [
        np.stack([cell[:, on_loop[:, 0]], cell[:, on_loop[:, 1]], holes[:, on_loop[:, 2]]], axis=2).reshape(-1, 3),
        np.stack([cell[:, on_hole[:, 0]], holes[:, on_hole[:, 1]], holes[:, on_hole[:, 2]]], axis=2).reshape(-1, 3),
    ]
    rest = np.concatenate([np.arange(skip), np.arange(skip + width, per)])
    if len(rest):
        here = (rest[None] + sector * per).ravel()
        ahead = (here + 1) % n
        faces.append(np.stack([outer[here], outer[ahead], inner[ahead]], axis=1))
        faces.append(np.stack([outer[here], inner[ahead], inner[here]], axis=1))
    return np.concatenate(faces)


def box(x: float, y: float, z: float) -> Mesh:
    """A box centred on the z axis, standing on z = 0."""
    corners = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]) * [x / 2.0, y / 2.0]
    return skin(np.stack([lifted(corners, 0.0), lifted(corners, z)]))


def extrude(outline: Floats, low: float, high: float) -> Mesh:
    """A simple plane polygon (n, 2), counter-clockwise, drawn from z = low to z = high."""
    return skin(np.stack([lifted(outline, low), lifted(outline, high)]), cap=triangulate(outline))


def rounded_rectangle(x: float, y: float, radius: float, tol: Tolerance) -> Floats:
    """A rectangle (n, 2) with round corners, starting on its right side so that a zigzag closes it."""
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * [x / 2.0, y / 2.0]
    return rounded(corners, radius, tol)


def rounded_box(x: float, y: float, z: float, corner: float, edge: float, tol: Tolerance) -> Mesh:
    """A box on z = 0 with round upright corners and a round upper edge: a cast or drawn cover."""
    if not tol.shows(corner):
        return box(x, y, z)
    count = tol.segments(edge, np.pi / 2.0) if tol.shows(edge) else 0
    if count == 0:
        loop = rounded_rectangle(x, y, corner, tol)
        return skin(np.stack([lifted(loop, 0.0), lifted(loop, z)]))
    loop = rounded_rectangle(x, y, corner, tol)
    turn = np.linspace(0.0, np.pi / 2.0, count + 1)
    rings = [lifted(loop, 0.0)]
    for angle in turn:
        inset = edge * (1.0 - np.cos(angle))
        factor = np.array([(x - 2.0 * inset) / x, (y - 2.0 * inset) / y])
        rings.append(lifted(loop * factor, z - edge + edge * np.sin(angle)))
    return skin(np.stack(rings))


def sheet(line: Floats, thickness: float, bend_radius: float, low: float, high: float, tol: Tolerance) -> Mesh:
    """A sheet of metal bent along a plane polyline (k, 2), from z = low to z = high; the line is its middle.

    The bend radius is the inside one; where the tolerance does not show it, the bend is sharp but for a hair.
    """
    radius = 0.5 * thickness + (bend_radius if tol.shows(bend_radius) else 4e-4)
    path = bent_path(lifted(line, 0.0), radius, 0.5 * thickness, tol)
    normal = np.stack([-path.tangents[:, 1], path.tangents[:, 0]], axis=1) * (0.5 * thickness)
    outline = np.concatenate([path.points[:, :2] - normal, (path.points[:, :2] + normal)[::-1]])
    return skin(np.stack([lifted(outline, low), lifted(outline, high)]))


def plate(x: float, y: float, z: float, columns: int, rows: int, hole_radius: float, tol: Tolerance) -> Mesh:
    """A flat plate on z = 0 with `columns` times `rows` through holes, one in the middle of each cell."""
    radius = min(hole_radius, 0.35 * x / columns, 0.35 * y / rows)
    if not tol.shows(radius):
        return box(x, y, z)
    h = tol.circle(radius, 6, 2)
    across, up = np.linspace(-x / 2.0, x / 2.0, columns + 1), np.linspace(-y / 2.0, y / 2.0, rows + 1)
    grid = np.stack(np.meshgrid(across, up, indexing="ij"), axis=2).reshape(-1, 2)
    index = np.arange(len(grid)).reshape(columns + 1, rows + 1)
    cell = np.stack([index[1:, :-1], index[1:, 1:], index[:-1, 1:], index[:-1, :-1]], axis=2).reshape(-1, 4)
    middle = grid[cell].mean(axis=1)
    ring = circle(radius, h)[:, :2]
    holes = (middle[:, None] + ring[None]).reshape(-1, 2)
    flat = np.concatenate([grid, holes])
    hole_index = len(grid) + np.arange(len(holes)).reshape(-1, h)
    corner = grid[cell[0]] - middle[0]
    on_cell, on_hole = stitch(np.arctan2(corner[:, 1], corner[:, 0]), np.arctan2(ring[:, 1], ring[:, 0]))
    top = np.concatenate(
        [
            np.stack([cell[:, on_cell[:, 0]], cell[:, on_cell[:, 1]], hole_index[:, on_cell[:, 2]]], axis=2),
            np.stack([cell[:, on_hole[:, 0]], hole_index[:, on_hole[:, 1]], hole_index[:, on_hole[:, 2]]], axis=2),
        ],
        axis=1,
    ).reshape(-1, 3)
    rim = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
    lift = len(flat)
    vertices = np.concatenate([lifted(flat, 0.0), lifted(flat, z)])
    sides = [_bands(rim[None], rim[None] + lift), _bands(hole_index + lift, hole_index)]
    return Mesh(vertices, np.concatenate([top + lift, top[:, ::-1], *sides]))


@dataclass(frozen=True, eq=False)
class Path:
    """A line in space: points (n, 3) and unit tangents (n, 3)."""

    points: Floats
    tangents: Floats


def bent_path(corners: Floats, bend_radius: float | Floats, tube_radius: float, tol: Tolerance) -> Path:
    """A polyline (k, 3) with its corners bent round, as a pipe is: straight runs stay single pieces.

    `bend_radius`: one number or one for each corner point; it shrinks where the straight runs are too short for it.
    """
    radii = np.broadcast_to(np.asarray(bend_radius, dtype=np.float64), (len(corners),))
    legs = np.diff(corners, axis=0)
    lengths = np.sqrt((legs * legs).sum(axis=1))
    ways = legs / lengths[:, None]
    points, tangents = [corners[:1]], [ways[:1]]
    for i in range(1, len(corners) - 1):
        u, v = ways[i - 1], ways[i]
        turn = math.acos(min(1.0, max(-1.0, float(u @ v))))
        if turn < 1e-3:
            continue
        if turn < 0.5 and tol.segments(float(radii[i]), turn) == 1:
            points.append(corners[i : i + 1])
            tangents.append(unit(u + v)[None])
            continue
        radius = min(float(radii[i]), 0.49 * min(lengths[i - 1], lengths[i]) / np.tan(turn / 2.0))
        start = corners[i] - u * radius * np.tan(turn / 2.0)
        inward = unit(v - u * (u @ v))
        angle = np.linspace(0.0, turn, tol.segments(radius + tube_radius, turn) + 1)[:, None]
        points.append(start + radius * (np.sin(angle) * u + (1.0 - np.cos(angle)) * inward))
        tangents.append(np.cos(angle) * u + np.sin(angle) * inward)
    points.append(corners[-1:])
    tangents.append(ways[-1:])
    return Path(np.concatenate(points), np.concatenate(tangents))


def path_frames(path: Path) -> tuple[Floats, Floats]:
    """Two axes (n, 3) across the path at each point, turning as little as possible (parallel transport)."""
    first = path.tangents[0]
    x, y, z = unit(np.cross(first, np.eye(3)[int(np.argmin(np.abs(first)))])).tolist()
    rows = []
    for tx, ty, tz in path.tangents.tolist():  # plain floats: many short paths, and NumPy's call overhead would rule
        along = x * tx + y * ty + z * tz
        x, y, z = x - along * tx, y - along * ty, z - along * tz
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        rows.append((x, y, z))
    side = np.array(rows)
    t = path.tangents
    across = np.stack(
        [
            t[:, 1] * side[:, 2] - t[:, 2] * side[:, 1],
            t[:, 2] * side[:, 0] - t[:, 0] * side[:, 2],
            t[:, 0] * side[:, 1] - t[:, 1] * side[:, 0],
        ],
        axis=1,
    )
    return side, across


def sweep(path: Path, section: Floats, scale: Floats | None = None) -> Floats:
    """Rings (n, s, 3) of a plane section (s, 2) carried along a path, each ring scaled where `scale` (n,) is given."""
    side, across = path_frames(path)
    size = np.ones(len(path.points)) if scale is None else scale
    rings = side[:, None] * section[None, :, :1] + across[:, None] * section[None, :, 1:]
    return np.asarray(path.points[:, None] + rings * size[:, None, None])


def tube(path: Path, radius: float, bore: float, tol: Tolerance, *, least: int = 5) -> Mesh:
    """A round pipe along a path; solid where `bore` is 0 or too small for the tolerance."""
    section = circle(radius, tol.circle(radius, least))[:, :2]
    outside = sweep(path, section)
    if bore <= 0.0 or not tol.shows(bore / 3.0):
        return skin(outside)
    inside = sweep(path, section * (bore / radius))
    return skin(np.concatenate([outside, inside[::-1]]), closed=True)
