"""Standard parts about their z axis, in millimetres: fasteners, ball bearings, circlips, keys, pins, rings.

Every function takes the `Cut` first and returns a `Solid` in the frame that it names.
"""

from __future__ import annotations

import numpy as np

from ..mesh import Floats, Ints
from .fits import BEARINGS, CIRCLIPS, KEYS, METRIC
from .solid import Cut, Row, Solid, placed

SEAT_RAD = 0.3
"""The angle of the first corner of hexagons, in their own frame."""
CLOSED_MM, SPREAD_PLAY_MM = 0.1, 0.1
"""The gap between a circlip and its groove's floor, and between a spread one and its shaft: as chords do not grow with
their ends, less would let it touch at few triangles."""
THREAD_PLAY_MM = 0.12
"""By how much the hole of the thread that is drawn as a helix is larger, on its radius."""


def ring_of(cut: Cut, rows: tuple[Row, ...], radius: float = 0.0, least: int = 8) -> Solid:
    """A closed profile of (radius, height) turned about z."""
    solid = Solid()
    first, last = solid.turned(rows, cut.circle(radius or max(r for r, _ in rows), least))
    solid.wall(last, first)
    return solid


def turned_part(cut: Cut, rows: tuple[Row, ...], least: int = 8) -> Solid:
    """An open profile of (radius, height) from end to end, its ends closed by discs or tips."""
    solid = Solid()
    first, last = solid.turned(rows, cut.circle(max(r for r, _ in rows), least))
    for loop in (first, last):
        if len(loop):
            solid.face(loop)
    return solid


def hexagon(flats: float, z: float) -> Floats:
    """A hexagon about z, (6, 3)."""
    angle = np.arange(6) * (np.pi / 3.0) + SEAT_RAD
    radius = flats / np.sqrt(3.0)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(6, z)], axis=1)


def hex_prism(solid: Solid, cut: Cut, flats: float, low: float, high: float, *, chamfers: str) -> tuple[Ints, Ints]:
    """Six flats from `low` to `high`, turned to a circle of the flats' width at the ends that `chamfers` names."""
    fine = cut.shows(0.06 * flats)
    rise = 0.06 * flats if fine else 0.0
    n = cut.circle(flats / 2.0)
    bottom, top = solid.tube(
        np.stack([hexagon(flats, low + rise * ("low" in chamfers)), hexagon(flats, high - rise * ("high" in chamfers))])
    )
    if fine and "low" in chamfers:
        under, _ = solid.turned([(0.475 * flats, low)], n)
        solid.wall(under, bottom)
        bottom = under
    if fine and "high" in chamfers:
        over, _ = solid.turned([(0.475 * flats, high)], n)
        solid.wall(top, over)
        top = over
    return bottom, top


def _shank(cut: Cut, radius: float, length: float, pitch: float) -> list[Row]:
    edge = 0.6 * pitch
    if not cut.shows(edge):
        return [(radius, -length), (radius, 0.0)]
    return [(radius - edge, -length), (radius, edge - length), (radius, 0.0)]


def hex_bolt(cut: Cut, size: int, length: float) -> Solid:
    """A hexagon bolt (ISO 4017): its head on z > 0, its shank down to z = -length."""
    m, solid = METRIC[size], Solid()
    rows = _shank(cut, m.size / 2.0, length, m.pitch)
    n = cut.circle(m.size / 2.0, 6)
    faced = cut.shows(0.06 * m.flats)
    if faced:  # the washer face
        rows += [(0.46 * m.flats, 0.0), (0.46 * m.flats, 0.2)]
    tip, neck = solid.turned(rows, n)
    low, high = hex_prism(solid, cut, m.flats, 0.2 if faced else 0.0, m.head, chamfers="high")
    solid.wall(neck, low)
    solid.face(tip)
    solid.face(high)
    return solid


ROUND = 12
"""Sides that the head of a cap screw has at least: fewer, and it could be taken for a hexagon to put a socket on."""


def cap_screw(cut: Cut, size: int, length: float) -> Solid:
    """A socket head cap screw (ISO 4762): its head on z > 0, its shank down to z = -length."""
    m, solid = METRIC[size], Solid()
    radius, edge = m.cap / 2.0, 0.08 * m.size
    shank, head = _shank(cut, m.size / 2.0, length, m.pitch), [(radius, 0.0)]
    head += [(radius, m.size - edge), (radius - edge, m.size)] if cut.shows(edge) else [(radius, m.size)]
    sides = cut.circle(radius)
    if sides < ROUND:
        tip, neck = solid.turned(shank, sides)
        under, rim = solid.turned(head, ROUND)
        solid.face(under, neck)
    else:
        tip, rim = solid.turned([*shank, *head], sides)
    mouth, floor = solid.tube(np.stack([hexagon(m.socket, m.size), hexagon(m.socket, 0.5 * m.size)]))
    solid.wall(rim, mouth)
    solid.face(tip)
    solid.face(floor)
    return solid


def stud(cut: Cut, size: int, low: float, high: float) -> Solid:
    """A stud from z = low to z = high, threaded at both ends."""
    m = METRIC[size]
    r, edge = m.size / 2.0, 0.6 * m.pitch
    if not cut.shows(edge):
        return turned_part(cut, ((r, low), (r, high)), 6)
    return turned_part(cut, ((r - edge, low), (r, low + edge), (r, high - edge), (r - edge, high)), 6)


def nut(cut: Cut, size: int) -> Solid:
    """A hexagon nut (ISO 4032) on z = 0; its thread is a cylinder of the tap drill's diameter."""
    m, solid = METRIC[size], Solid()
    low, high = hex_prism(solid, cut, m.flats, 0.0, m.nut, chamfers="low high")
    core, mouth = m.core / 2.0, 0.53 * m.size
    deep = mouth - core
    rows = (
        [(mouth, 0.0), (core, deep), (core, m.nut - deep), (mouth, m.nut)]
        if cut.shows(deep)
        else [(core, 0.0), (core, m.nut)]
    )
    first, last = solid.turned(
        [(r + (cut.ease + (m.size - m.core) / 2.0 if cut.ease else 0.0), z) for r, z in rows], cut.circle(mouth, 6)
    )
    solid.wall(first, low)
    solid.wall(last, high)
    return solid


def washer(cut: Cut, size: int) -> Solid:
    """A plain washer (ISO 7089) on z = 0."""
    m = METRIC[size]
    bore = m.washer_bore / 2.0 + cut.ease
    return ring_of(cut, ((bore, 0.0), (m.washer / 2.0, 0.0), (m.washer / 2.0, m.thick), (bore, m.thick)), 0.0, 6)


def seal_washer(cut: Cut, bore: float, outside: float, thick: float) -> Solid:
    """A flat ring on z = 0, of a bore and an outside diameter."""
    b, o = bore / 2.0 + cut.ease, outside / 2.0
    return ring_of(cut, ((b, 0.0), (o, 0.0), (o, thick), (b, thick)))


def o_ring(cut: Cut, radius: float, section: float) -> Solid:
    """An O-ring about z in the plane z = 0: radius of the centre line, and diameter of the section."""
    section -= 0.5 if cut.ease else 0.0
    n = cut.circle(section / 2.0, 6)
    angle = (np.arange(n) + 0.5) * (2.0 * np.pi / n)
    rows = np.stack([radius + np.cos(angle) * section / 2.0, np.sin(angle) * section / 2.0], axis=1)
    return ring_of(cut, tuple(map(tuple, rows.tolist())))


def dowel(cut: Cut, diameter: float, length: float, least: int = 8) -> Solid:
    """A dowel pin (ISO 8734) about z, centred, with `least` sides or more."""
    r, h, e = diameter / 2.0, length / 2.0, 0.1 * diameter
    return turned_part(cut, tuple(cut.sharp(((r - e, -h), (r, e - h), (r, h - e), (r - e, h)))), least)


# --- threads as helices -----------------------------------------------------------------------------------------------


def helix(
    solid: Solid,
    cut: Cut,
    radii: tuple[float, float, float],
    pitch: float,
    low: float,
    turns: int,
    pose: Floats | None = None,
) -> tuple[Ints, Ints]:
    """A right-handed thread from z = low on; returns its end loops, which step by a pitch.

    `radii`: of the root, of the crest, and of the last turn. Rows of vertices follow the thread, four a turn; the first
    turn stays on the root's cylinder.
    """
    root, crest, end = radii
    n, last = max(12, cut.circle(crest)), 4 * turns
    theta = np.arange(n + 1) * (2.0 * np.pi / n)
    row = np.arange(last + 1)
    radius = np.where((row >= 4) & (row % 4 >= 2), crest, root)
    radius[-5:] = end
    height = low + pitch * (row // 4 + np.array([0.0, 0.25, 0.25 + FLANK, 1.0 - FLANK])[row % 4])
    points = np.empty((last + 1, n + 1, 3))
    points[:, :, 0], points[:, :, 1] = radius[:, None] * np.cos(theta), radius[:, None] * np.sin(theta)
    points[:, :, 2] = height[:, None] + pitch * theta / (2.0 * np.pi)
    points = placed(points, pose)
    index = np.empty((last + 1, n + 1), dtype=np.int64)
    index[:, :n] = solid.loop(points[:, :n].reshape(-1, 3)).reshape(last + 1, n)
    index[:-4, n] = index[4:, 0]  # the seam: a turn later the thread is a pitch higher
    index[-4:, n] = solid.loop(points[-4:, n])
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, 1:].ravel(), index[1:, :-1].ravel()
    bottom = np.concatenate([index[0, :n], index[4:0:-1, 0]])
    top = np.concatenate([index[-1, :n], index[:-5:-1, n]])
    border = [np.stack([loop, np.roll(loop, -1)], axis=1) for loop in (bottom, top[::-1])]
    solid.patch(np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]), np.concatenate(border))
    return bottom, top


FLANK = 0.15
"""Height of a flank of the helix along the axis, in pitches."""
SEAM = 0.95
"""Where rings at the ends of a hole have a corner after the seam of its thread, in facets: less, and walls cross."""


def thread_depth(pitch: float) -> float:
    """Height of a thread's flanks as drawn, millimetres."""
    return 0.55 * pitch


def thread_play(cut: Cut) -> tuple[float, float, float]:
    """Of the helix: the gap normal to its flanks, no radius, and what chords take at its crest beyond that."""
    flank = FLANK * PLUG_PITCH
    play = (THREAD_PLAY_MM + cut.ease) * flank / float(np.hypot(flank, thread_depth(PLUG_PITCH)))
    return play, 0.0, max(0.0, cut.sag(PLUG_SIZE / 2.0) - THREAD_PLAY_MM - cut.ease + play)


PLUG_SIZE, PLUG_PITCH, PLUG_FLATS, PLUG_TURNS = 14.0, 1.5, 17.0, 4
PLUG_LOW = -(PLUG_TURNS + 2.5) * PLUG_PITCH


def threaded_plug(cut: Cut) -> Solid:
    """A plug M14x1.5 whose thread is a helix: its hexagon on z > 0, its thread down from there."""
    solid = Solid()
    crest, root = PLUG_SIZE / 2.0, PLUG_SIZE / 2.0 - thread_depth(PLUG_PITCH)
    bottom, top = helix(solid, cut, (root, crest, root), PLUG_PITCH, PLUG_LOW, PLUG_TURNS)
    end, _ = solid.turned([(root - 0.4 * PLUG_PITCH, PLUG_LOW - 0.5 * PLUG_PITCH)], cut.circle(root))
    solid.wall(end, bottom)
    solid.face(end)
    neck, rim = solid.turned(
        [*([] if cut.plain else [(root, -0.5)]), (root, 0.0), (0.68 * PLUG_FLATS, 0.0), (0.68 * PLUG_FLATS, 2.0)],
        cut.arc(root, 2.0 * np.pi, 8),
    )
    solid.wall(top, neck)
    under, over = hex_prism(solid, cut, PLUG_FLATS, 2.0, 9.0, chamfers="high")
    solid.wall(rim, under)
    solid.face(over)
    return solid


def threaded_hole(solid: Solid, cut: Cut, pose: Floats, depth: float, rise: float) -> tuple[Ints, Ints]:
    """The hole for `threaded_plug`, whose frame is `rise` above the face; returns its mouth and its inner end."""
    grow = THREAD_PLAY_MM + cut.ease
    crest, root = PLUG_SIZE / 2.0 + grow, PLUG_SIZE / 2.0 - thread_depth(PLUG_PITCH) + grow
    low = PLUG_LOW + rise - PLUG_PITCH
    turns = int((-0.3 - low) / PLUG_PITCH - 1.0)
    bottom, top = helix(solid, cut, (root, crest, crest), PLUG_PITCH, low, turns, pose)
    n = cut.circle(crest)
    around = np.asarray((np.arange(n) + SEAM) * (2.0 * np.pi / n), dtype=np.float64)
    end, _ = solid.swung([(root, -depth)], around, pose)
    mouth, _ = solid.swung([(crest + 0.6, 0.0)], around, pose)
    solid.wall(end, bottom, pose=pose)
    solid.wall(top, mouth, pose=pose)
    return mouth, end


# --- ball bearings ----------------------------------------------------------------------------------------------------


def _groove(cut: Cut, name: str) -> tuple[Floats, Floats, float]:
    """Offsets from the circle of the balls' centres, heights, and the sag of the raceway's arc."""
    b = BEARINGS[name]
    radius = 0.52 * b.ball
    shoulder = 0.30 * b.ball
    if cut.plain:  # two cones, off the ball
        return np.array([shoulder, 0.53 * b.ball, shoulder]), np.array([-0.5, 0.0, 0.5]) * b.width, 0.0
    reach = np.arccos((shoulder + 0.02 * b.ball) / radius)
    pieces = 2 * ((cut.arc(radius, 2.0 * reach, 2) + 1) // 2)
    angle = np.linspace(-reach, reach, pieces + 1)
    return radius * np.cos(angle) - 0.02 * b.ball, radius * np.sin(angle), radius * (1.0 - np.cos(reach / pieces))


def raceway_sag(cut: Cut, name: str) -> float:
    """How far the chords of a raceway may reach into a ball, millimetres."""
    b = BEARINGS[name]
    return float(_groove(cut, name)[2] + cut.sag(b.outside / 2.0))


def _faced(radii: Floats, heights: Floats, half: float) -> list[Row]:
    """A raceway's rows from face to face."""
    rows = list(zip(radii.tolist(), heights.tolist(), strict=True))
    ends = (rows[0][0], -half), (rows[-1][0], half)
    return [*(end for end in ends[:1] if end != rows[0]), *rows, *(end for end in ends[1:] if end != rows[-1])]


def inner_ring(cut: Cut, name: str) -> Solid:
    """A bearing's inner ring about z, centred."""
    b = BEARINGS[name]
    h, bore = b.width / 2.0, b.bore / 2.0 + cut.ease
    deep, z, _ = _groove(cut, name)
    r = b.pitch - deep
    e = 0.6 if cut.shows(0.6) else 0.0
    low = [(bore, e - h), (bore + e, -h)] if e else [(bore, -h)]
    rows = [*low, *_faced(r, z, h)]
    rows += [(bore + e, h), (bore, h - e)] if e else [(bore, h)]
    return ring_of(cut, tuple(rows), float(b.pitch))


def outer_ring(cut: Cut, name: str) -> Solid:
    """A bearing's outer ring about z, centred."""
    b = BEARINGS[name]
    h, out = b.width / 2.0, b.outside / 2.0
    deep, z, _ = _groove(cut, name)
    r = b.pitch + deep + 2.0 * cut.ease
    e = 0.6 if cut.shows(0.6) else 0.0
    low = [(out - e, -h), (out, e - h)] if e else [(out, -h)]
    race = _faced(r, z, h)
    rows = [race[0], *low, *([(out, h - e), (out - e, h)] if e else [(out, h)]), *race[:0:-1]]
    return ring_of(cut, tuple(rows))


def ball(cut: Cut, diameter: float) -> Solid:
    """A ball about the origin, its poles on z."""
    r = diameter / 2.0
    rows = cut.arc(r, np.pi, 3 if cut.plain else 4)
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, rows + 1)
    profile = [(0.0, -r), *((r * float(np.cos(a)), r * float(np.sin(a))) for a in angle[1:-1]), (0.0, r)]
    return turned_part(cut, tuple(profile), 6)


def cage(cut: Cut, name: str) -> Solid:
    """A bearing's crown cage about z: a ring at z < 0 with prongs between the balls, whose centres are at z = 0.

    The first ball lies on the x axis.
    """
    b = BEARINGS[name]
    if cut.plain:  # no prongs
        low, high, width = -0.7 * b.ball, -0.5 * b.ball - 0.3, 0.1 * b.ball
        rows = ((b.pitch - width, low), (b.pitch + width, low), (b.pitch + width, high), (b.pitch - width, high))
        return ring_of(cut, rows)
    pieces = max(2, cut.arc(b.ball / 2.0, 0.9 * np.pi) // 2 * 2)
    half = 0.495 * np.pi / pieces
    pocket = (b.ball / 2.0 + 0.3) / np.cos(half)  # chords stay off the ball
    angle = -np.pi / 2.0 + np.linspace(-1.0, 1.0, pieces + 1) * (half * pieces)
    s, z = pocket * np.cos(angle) / b.pitch, pocket * np.sin(angle)
    around = (np.arange(b.balls)[:, None] * (2.0 * np.pi / b.balls) + s).ravel()
    top = np.tile(z, b.balls)
    back = np.full(len(around), -pocket - 0.12 * b.ball)
    width = 0.15 * b.ball
    rings = [
        np.stack([r * np.cos(around), r * np.sin(around), h], axis=1)
        for r, h in ((b.pitch - width, top), (b.pitch + width, top), (b.pitch + width, back), (b.pitch - width, back))
    ]
    solid = Solid()
    first, last = solid.tube(np.stack(rings))
    solid.wall(last, first)
    return solid


# --- on shafts --------------------------------------------------------------------------------------------------------


def circlip(cut: Cut, shaft: int) -> Solid:
    """An external circlip (DIN 471) on z = 0: a ring that is open at +x, with two lugs that have holes."""
    thick, groove, _, width = CIRCLIPS[shaft]
    inner = groove / 2.0 + CLOSED_MM
    outer = inner + width
    gap, lug = 0.16, 0.42  # angles of the opening's half and of a lug's end
    far = outer + 0.45 * width
    n = cut.circle(outer)
    inside = np.linspace(2.0 * np.pi - gap, gap, n + 1)
    outside = np.linspace(lug, 2.0 * np.pi - lug, n + 1)
    line = [*((inner / np.cos(np.pi / n) * np.cos(a), inner / np.cos(np.pi / n) * np.sin(a)) for a in inside)]
    line += [(far * np.cos(a), far * np.sin(a)) for a in (gap, lug)]
    line += [(outer * np.cos(a), outer * np.sin(a)) for a in outside]
    line += [(far * np.cos(a), far * np.sin(a)) for a in (-lug, -gap)]
    solid = Solid()
    low, high = solid.outline(np.array(line), (0.0, thick))
    holes: tuple[list[Ints], list[Ints]] = ([], [])
    place, radius = (inner + far) / 2.0, 0.2 * width
    for a in () if cut.plain else ((gap + lug) / 2.0, -(gap + lug) / 2.0):
        pose = np.eye(4)
        pose[:2, 3] = place * np.cos(a), place * np.sin(a)
        first, last = solid.turned([(radius, 0.0), (radius, thick)], cut.circle(radius, 6), pose)
        holes[0].append(first)
        holes[1].append(last)
    solid.face(low, *holes[0])
    solid.face(high, *holes[1])
    return solid


def spread(shaft: int) -> float:
    """How far each point of a circlip moves away from its axis so that the ring passes over the shaft."""
    return (shaft - CIRCLIPS[shaft][1]) / 2.0 - CLOSED_MM + SPREAD_PLAY_MM


def key(cut: Cut, shaft: int, length: float) -> Solid:
    """A parallel key (DIN 6885 B): along z, centred there; its foot at y = 0, its back at y = height."""
    width, height, _ = KEYS[shaft]
    e = 0.3
    x, y, z = width / 2.0, height, length / 2.0
    solid = Solid()
    corners = np.array([[-x, 0.0], [x, 0.0], [x, y - e], [x - e, y], [e - x, y], [-x, y - e]])
    low, high = solid.outline(corners, (-z, z))
    solid.face(low)
    solid.face(high)
    return solid
