"""Gears and shafts about their z axis, millimetres: spur gears, a bevel pair, shafts with keyways and splines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh import Floats, Ints
from .fits import KEYS, deviation
from .polygon import offset, triangulated
from .solid import Cut, Row, Solid

PRESSURE = np.deg2rad(20.0)
BACKLASH = 0.09
"""By how much two teeth that mesh are thinner on each side, both together, in modules: larger, and gears rattle."""
SPLINE_PLAY = 0.08
"""The gap all round of a spline, millimetres."""
KEY_PLAY = 0.01
"""The gap at each side of a key in its shaft, millimetres; twice that in the hub."""


def _involute(angle: Floats) -> Floats:
    return np.asarray(np.tan(angle) - angle)


def _half(teeth: float, module: float, local: Floats) -> Floats:
    """Half angles of a tooth where the flank's normal is at angles to the base circle's tangent."""
    pitch = module * teeth / 2.0
    wide = np.pi / (2.0 * teeth) - BACKLASH * module / (2.0 * pitch) + np.tan(PRESSURE) - PRESSURE
    return np.asarray(wide - _involute(local))


def mesh_play(module: float) -> float:
    """The gap normal to the flanks on each side of a tooth that is in the middle of the other gear's space."""
    return float(BACKLASH * module * np.cos(PRESSURE))


def bevel_play(teeth: int, mate: int, module: float, width: float) -> float:
    """The same of a bevel pair, at its toe, where it is least."""
    return mesh_play(module) * (1.0 - width / (module * float(np.hypot(teeth, mate)) / 2.0))


def tooth(cut: Cut, teeth: float, module: float) -> tuple[Floats, Floats]:
    """One flank from root to tip: heights above the pitch circle and half angles of the tooth, each (k,)."""
    pitch = module * teeth / 2.0
    base, tip, root = pitch * np.cos(PRESSURE), pitch + module, pitch - 1.25 * module
    start = max(base, root)
    if cut.plain:  # one straight line, inside the tooth
        local = np.arccos(np.minimum(1.0, base / np.array([start, tip])))
        half = _half(teeth, module, local)
        return np.array([root, tip]) - pitch, half
    pieces = max(2, cut.arc(2.5 * module, 1.0))
    radius = start + (tip - start) * np.linspace(0.0, 1.0, pieces + 1) ** 1.3
    local = np.arccos(np.minimum(1.0, base / radius))
    half = _half(teeth, module, local)
    if root < start - 0.02 * module:
        radius = np.concatenate([[root], radius])
        half = np.concatenate([half[:1] + 0.08 * (np.pi / teeth - half[:1]), half])
    return radius - pitch, half


def _teeth_faces(corner: Floats, per: int, teeth: int) -> Ints:
    """Triangles of all teeth of one side: each tooth's outline, its first and last corner on the root circle."""
    one = triangulated([corner[:per]])
    return np.concatenate([one + k * per for k in range(teeth)])


def spur_gear(cut: Cut, teeth: int, module: float, width: float, shaft: int, hub: float, holes: int) -> Solid:
    """A spur gear about z, centred, a tooth on the x axis; bore and keyway for `shaft`, the keyway towards +y.

    `hub`: its radius. `holes`: how many round holes lighten the web.
    """
    solid = Solid()
    height, half = tooth(cut, teeth, module)
    pitch, h = module * teeth / 2.0, width / 2.0
    r = np.concatenate([height, height[::-1]]) + pitch
    turns = np.arange(teeth)[:, None] * (2.0 * np.pi / teeth) + np.concatenate([-half, half[::-1]])
    flat = np.stack([r * np.cos(turns), r * np.sin(turns)], axis=2).reshape(-1, 2)
    edge = 0.15 * module if cut.shows(0.2 * module) else 0.0
    per = len(r)
    if edge:  # the tips and flanks are chamfered towards the axis
        inner = flat * ((np.hypot(flat[:, 0], flat[:, 1]) - edge) / np.hypot(flat[:, 0], flat[:, 1]))[:, None]
        rings = [(inner, -h), (flat, edge - h), (flat, h - edge), (inner, h)]
    else:
        rings = [(flat, -h), (flat, h)]
    low, high = solid.tube(np.stack([np.column_stack([outline, np.full(len(flat), z)]) for outline, z in rings]))
    rim = pitch - 3.0 * module
    n = cut.circle(rim)
    web = 0.28 * width
    thin = rim - hub > 2.5 * module and not cut.plain
    ends = []
    for loop, side in ((low, -1.0), (high, 1.0)):
        roots = loop.reshape(teeth, per)[:, [0, -1]].ravel()
        one = triangulated([flat[:per]])
        faces = np.concatenate([loop[one + k * per] for k in range(teeth)])
        around = np.stack([loop, np.roll(loop, -1)], axis=1).reshape(teeth, per, 2)[:, :-1].reshape(-1, 2)
        across = roots.reshape(teeth, 2)[:, ::-1]
        solid.patch(faces, np.concatenate([around, across]))
        if thin:
            rows = [
                (rim, side * h),
                (rim - 0.25 * module, side * web),
                (hub + 0.25 * module, side * web),
                (hub, side * h),
            ]
            outer, foot = solid.turned(rows[:2], n)
            inner_foot, inner = solid.turned(rows[2:], cut.circle(hub))
            solid.wall(roots, outer)
            ends.append((foot, inner_foot, inner))
        else:
            ends.append((loop[:0], loop[:0], roots))
    if thin:
        middle, radius = (rim + hub) / 2.0, 0.3 * (rim - hub)
        bores: tuple[list[Ints], list[Ints]] = ([], [])
        for k in range(holes if radius > 2.0 else 0):
            pose = np.eye(4)
            angle = (k + 0.5) * 2.0 * np.pi / holes
            pose[:2, 3] = middle * np.cos(angle), middle * np.sin(angle)
            first, last = solid.turned([(radius, -web), (radius, web)], cut.circle(radius), pose)
            bores[0].append(first)
            bores[1].append(last)
        for (foot, inner_foot, _), found in zip(ends, bores, strict=True):
            solid.face(foot, inner_foot, *found)
    bore = keyed_bore(cut, shaft)
    first, last = solid.outline(bore, (-h, h))
    solid.face(ends[0][2], first)
    solid.face(ends[1][2], last)
    return solid


def keyed_bore(cut: Cut, shaft: int) -> Floats:
    """The outline (n, 2) of a bore H7 with a keyway towards +y."""
    width, height, deep = KEYS[shaft]
    radius = (shaft + deviation("H7", shaft)) / 2.0 + cut.ease
    half = width / 2.0 + 2.0 * KEY_PLAY + cut.ease
    n = cut.circle(radius)
    mouth = np.arcsin(half / radius)
    angle = np.pi / 2.0 + np.linspace(mouth, 2.0 * np.pi - mouth, n + 1)
    back = shaft / 2.0 - deep + height + 0.25
    arc = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([arc, [[half, back], [-half, back]]])


def bevel_teeth(cut: Cut, teeth: int, mate: int, module: float, width: float) -> tuple[Floats, Floats, int]:
    """The toe's and the heel's outline of a straight bevel gear, each (n, 3), and the corners of a tooth.

    The axis is z, the apex of the pitch cone the origin, the gear on z > 0; a tooth lies in the half plane of +x. After
    Tredgold: involutes on the back cone, drawn to the apex.
    """
    cone = np.arctan2(teeth, mate)
    pitch = module * teeth / 2.0
    reach = pitch / np.sin(cone)
    height, half = tooth(cut, teeth / np.cos(cone), module)
    half = half / np.cos(cone)
    r, z = pitch + height * np.cos(cone), reach * np.cos(cone) - height * np.sin(cone)
    r, z, turn = (np.concatenate([v, v[::-1]]) for v in (r, z, half))
    turn[: len(half)] *= -1.0
    turns = np.arange(teeth)[:, None] * (2.0 * np.pi / teeth) + turn[None]
    heel = np.stack([r * np.cos(turns), r * np.sin(turns), np.broadcast_to(z, turns.shape)], axis=2).reshape(-1, 3)
    return heel * ((reach - width) / reach), heel, len(r)


def bevel_blank(solid: Solid, cut: Cut, teeth: int, mate: int, module: float, width: float) -> tuple[Ints, Ints]:
    """The teeth of a bevel gear with their toe and heel faces; returns the loops of the roots at toe and heel."""
    toe, heel, per = bevel_teeth(cut, teeth, mate, module, width)
    low, high = solid.tube(np.stack([toe, heel]))
    roots = []
    cone = np.arctan2(teeth, mate)
    slope = np.array([np.cos(cone), -np.sin(cone)])  # along the back cone, in radius and height
    for loop, points in ((low, toe), (high, heel)):
        rho = np.hypot(points[:per, 0], points[:per, 1])
        along = rho * slope[0] + points[:per, 2] * slope[1]
        flat = np.stack([along, rho * np.arctan2(points[:per, 1], points[:per, 0])], axis=1)
        one = triangulated([flat])
        ends = loop.reshape(teeth, per)[:, [0, -1]]
        around = np.stack([loop, np.roll(loop, -1)], axis=1).reshape(teeth, per, 2)[:, :-1].reshape(-1, 2)
        solid.patch(
            np.concatenate([loop[one + k * per] for k in range(teeth)]), np.concatenate([around, ends[:, ::-1]])
        )
        roots.append(ends.ravel())
    return roots[0], roots[1]


def bevel_wheel(
    cut: Cut, teeth: int, mate: int, module: float, width: float, shaft: int, front: float, back: float
) -> Solid:
    """A bevel gear with a keyed bore from z = front to z = back, its apex at the origin; the keyway towards +y."""
    solid = Solid()
    toe, heel = bevel_blank(solid, cut, teeth, mate, module, width)
    points = np.concatenate(solid._points)
    rim = float(np.hypot(points[toe, 0], points[toe, 1]).min()) - 0.8 * module
    outer = float(np.hypot(points[heel, 0], points[heel, 1]).min()) - 0.3 * module
    bore = keyed_bore(cut, shaft)
    first, last = solid.outline(bore, (front, back))
    face, _ = solid.turned([(rim, front)], cut.circle(rim))
    foot, tail = solid.turned([(outer, float(points[heel, 2].max()) + 1.5), (0.72 * outer, back)], cut.circle(outer))
    solid.wall(toe, face)
    solid.face(face, first)
    solid.wall(heel, foot)
    solid.face(tail, last)
    return solid


@dataclass(frozen=True)
class Keyway:
    """A keyway in a shaft from z = low to z = high, towards +y; `shaft`: the nominal diameter there."""

    shaft: int
    low: float
    high: float


@dataclass(frozen=True)
class Spline:
    """Straight teeth in or on the end of a shaft: tip and root radius, and how deep or long, in millimetres."""

    teeth: int
    inner: float
    outer: float
    length: float


def spline_outline(spline: Spline, grow: float) -> Floats:
    """The outline (4 teeth, 2) of a spline's teeth, all its sides moved outwards by `grow`."""
    step = 2.0 * np.pi / spline.teeth
    turn = np.array([-0.30 * step, -0.19 * step, 0.19 * step, 0.30 * step])
    radius = np.array([spline.inner, spline.outer, spline.outer, spline.inner])
    turns = np.arange(spline.teeth)[:, None] * step + turn
    corners = np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=2).reshape(-1, 2)
    return offset(corners, grow)


def shaft(
    cut: Cut,
    rows: Sequence[Row],
    keyways: tuple[Keyway, ...] = (),
    sockets: tuple[Spline | None, Spline | None] = (None, None),
    bevel: tuple[int, int, float, float] | None = None,
) -> Solid:
    """A stepped shaft about z through rows of (radius, z), z rising, with keyways and splines in its ends.

    `bevel` (teeth, mate, module, width): its low end is a bevel pinion whose apex is the origin; the first row is then
    where the shaft leaves the heel.
    """
    solid = Solid()
    rows = cut.sharp(rows)
    n = cut.circle(max(r for r, _ in rows))
    mouths = sorted(
        {
            float(np.arcsin((KEYS[k.shaft][0] / 2.0 + KEY_PLAY) / next(r for r, z in rows if z > k.high)))
            for k in keyways
        }
    )
    special = sorted({np.pi / 2.0 + s * m for m in mouths for s in (-1.0, 1.0)})
    around = (np.arange(n) + 0.37) * (2.0 * np.pi / n)
    # no vertex close to the edges of a keyway
    far = [a for a in around if all(abs((a - s + np.pi) % (2.0 * np.pi) - np.pi) > 0.35 * np.pi / n for s in special)]
    angle = np.array(sorted([*far, *special]))
    rest, loops = list(rows), []
    for keyway in sorted(keyways, key=lambda k: k.low):
        stop = next(i for i, (_, z) in enumerate(rest) if z > keyway.high)
        radius = rest[stop][0]
        first, last = solid.swung([*rest[:stop], (radius, keyway.low)], angle)
        loops += [first, last, _keyway(solid, angle, last, radius, keyway)]
        rest = rest[stop:]
    loops += solid.swung(rest, angle)
    for end, start in zip(loops[2::3], loops[3::3], strict=True):
        solid.wall(end, start)
    first, last = loops[0], loops[-1]
    if bevel is not None:
        toe, heel = bevel_blank(solid, cut, *bevel)
        solid.wall(heel, first)
        _toe(solid, cut, toe)
    for loop, socket, z, sign in ((first, sockets[0], rows[0][1], 1.0), (last, sockets[1], rows[-1][1], -1.0)):
        if socket is not None:
            mouth, floor = solid.outline(spline_outline(socket, SPLINE_PLAY + cut.ease), (z, z + sign * socket.length))
            solid.face(loop, mouth)
            solid.face(floor)
        elif bevel is None or sign < 0.0:
            solid.face(loop)
    return solid


def quill(cut: Cut, spline: Spline, radius: float, length: float) -> Solid:
    """A drive shaft about z: a spline's teeth as long as it is deep, then round up to z = length."""
    solid = Solid()
    top = spline.length
    end, root = solid.outline(spline_outline(spline, 0.0), (0.0, top))
    foot, high = solid.turned(
        cut.sharp([(radius, top), (radius, length - 0.6), (radius - 0.6, length)]), cut.arc(radius, 2.0 * np.pi, 8)
    )
    solid.face(end)
    solid.face(foot, root) if radius > spline.outer else solid.face(root, foot)
    solid.face(high)
    return solid


def _toe(solid: Solid, cut: Cut, toe: Ints) -> None:
    points = np.concatenate(solid._points)[toe]
    radius = float(np.hypot(points[:, 0], points[:, 1]).min()) * 0.8
    loop, _ = solid.turned([(radius, float(points[:, 2].min()) + 0.3)], cut.circle(radius))
    solid.wall(toe, loop)
    solid.face(loop)


def _keyway(solid: Solid, angle: Floats, ring: Ints, radius: float, keyway: Keyway) -> Ints:
    """A keyway cut from a ring of the shaft on; returns the ring where the keyway ends."""
    width, _, deep = KEYS[keyway.shaft]
    half, floor = width / 2.0 + KEY_PLAY, keyway.shaft / 2.0 - deep
    mouth = np.arcsin(half / radius)
    inside = np.flatnonzero(np.abs(angle - np.pi / 2.0) <= mouth + 1e-9)
    outside = np.r_[inside[-1] : len(angle), 0 : inside[0] + 1]
    top, _ = solid.swung([(radius, keyway.high)], angle)
    feet = []
    for loop, z in ((ring, keyway.low), (top, keyway.high)):
        foot = solid.loop(np.array([[half, floor, z], [-half, floor, z]]))
        solid.face(np.concatenate([loop[inside], foot[::-1]]))
        feet.append(np.concatenate([loop[outside], foot]))
    solid.wall(feet[0], feet[1])
    return top
