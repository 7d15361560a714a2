"""The shapes of a catalogue's tools.

Each in the frame of its seat: the origin on the axis, at the lower end of what is on the fastener; z out of the joint,
the handle towards x, flats towards y.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.plan.tool_solids import Solid, beam, disc, flats, inside, lathed, merged, moved, prism
from feeler.plan.tool_spec import ToolSpec

Floats = npt.NDArray[np.float64]

OPEN_DEG = 15.0
"""Angle between the jaw of an open spanner and its handle."""
JAW_PLAY = 1.01
"""Width of a jaw, relative to that of the flats."""


@dataclass(frozen=True, eq=False)  # it holds arrays
class ToolShape:
    """The solids of a tool by name, with its grip."""

    solids: tuple[tuple[str, Solid], ...]
    """The last one is held in the hand."""
    grip: Floats
    """(4, 4) tool_from_grip: the origin in the middle of the grip, z along it and away from the fastener."""
    top: float
    """Height at which the next piece of a chain goes on."""
    plug: Solid | None = None
    """What fills a ring or jaw: a part in it when the tool is off says that the tool is not off."""


def shape_of(pieces: Sequence[ToolSpec]) -> ToolShape:
    """A tool, or a chain of pieces on top of each other, the first at the fastener."""
    solids: list[tuple[str, Solid]] = []
    top, grip, plug = 0.0, np.eye(4), None
    for piece in pieces:
        shape = _MAKERS[piece.kind](piece)
        lift = np.eye(4)
        lift[2, 3] = top
        solids += [(name, moved(solid, lift)) for name, solid in shape.solids]
        top, grip, plug = top + shape.top, lift @ shape.grip, shape.plug
    return ToolShape(tuple(solids), grip, top, plug)


def cores_of(pieces: Sequence[ToolSpec]) -> list[Solid]:
    """Bodies that are inside a chain, whatever its angle about the axis: where they collide, it collides at every one.

    None of a tool without such a body.
    """
    solids: list[Solid] = []
    top = 0.0
    for piece in pieces:
        if piece.kind not in _CORES:
            return []
        for rings in _CORES[piece.kind](piece):
            solids.append(lathed([inside(r, top + z) if r > 0.0 else disc(-r, top + z) for r, z in rings]))
        top += shape_of([piece]).top
    return solids


def _core_socket(spec: ToolSpec) -> list[list[tuple[float, float]]]:
    """Radii and heights; the hole is as wide as its corners, and negative: the ring is around it."""
    outer, body, length, depth = (spec.length(name) for name in ("outer", "body", "length", "depth"))
    hole, nose = _hole_reach(spec), min(depth + 2e-3, 0.9 * length)
    if hole >= 0.49 * outer:
        return [[(body / 2, nose), (body / 2, length)]]
    rings = [(-hole, depth), (-hole, 0.0), (outer / 2, 0.0), (outer / 2, nose), (body / 2, nose), (body / 2, length)]
    return [rings]


def _core_bit(spec: ToolSpec) -> list[list[tuple[float, float]]]:
    reach, radius = spec.length("reach"), 0.5 * (spec.size or spec.length("blade"))
    body = spec.length("body") / 2
    return [[(radius, 0.0), (radius, reach)], [(body, reach), (body, spec.length("length"))]]


def _core_extension(spec: ToolSpec) -> list[list[tuple[float, float]]]:
    bar, end, high = spec.length("bar") / 2, spec.length("end") / 2, spec.size
    low = high - spec.length("end_length")
    return [[(bar, 0.0), (bar, low), (end, low), (end, high)]]


def _core_ratchet(spec: ToolSpec) -> list[list[tuple[float, float]]]:
    return [[(spec.length("head") / 2, z) for z in (0.0, spec.length("height"))]]


def _core_driver(spec: ToolSpec) -> list[list[tuple[float, float]]]:
    shaft, reach, handle = spec.length("shaft") / 2, spec.length("reach"), spec.length("handle") / 2
    return [[(shaft, 0.0), (shaft, reach), (handle, reach), (handle, reach + spec.length("grip"))]]


def fist(width: float, depth: float, height: float) -> Solid:
    """A closed hand around z, metres: its width along z, its depth across the palm (y), its height (x)."""
    a, b, bevel = 0.5 * height, 0.5 * depth, 0.25 * min(height, depth)
    outline = [(a, bevel - b), (a, b - bevel), (a - bevel, b), (bevel - a, b)]
    outline += [(-x, -y) for x, y in outline]
    return prism(outline, -0.5 * width, 0.5 * width)


def _along_x(x: float, z: float) -> Floats:
    """The frame of a grip at (x, 0, z) whose z points along x."""
    grip = np.eye(4)
    grip[:3, 0], grip[:3, 1], grip[:3, 2], grip[:3, 3] = (0, 0, -1), (0, 1, 0), (1, 0, 0), (x, 0, z)
    return grip


def _along_z(z: float) -> Floats:
    grip = np.eye(4)
    grip[2, 3] = z
    return grip


def _socket(spec: ToolSpec) -> ToolShape:
    """A nose with a hexagon or twelve points inside, and the body with the drive."""
    outer, body, length, depth = (spec.length(name) for name in ("outer", "body", "length", "depth"))
    nose = min(depth + 2e-3, 0.9 * length)
    rings = [_hole(spec, depth), _hole(spec, 0.0), disc(outer / 2, 0.0)]
    rings += [disc(outer / 2, nose), disc(body / 2, nose), disc(body / 2, length)]
    return ToolShape((("socket", lathed(rings)),), np.eye(4), length)


def _hole(spec: ToolSpec, z: float) -> Floats:
    """The ring of a socket's hole: round for an external Torx."""
    if "torx" in spec.fits:
        return disc(_hole_reach(spec), z)
    return flats(spec.size, z, 12 if "12-point" in spec.fits else 8 if "square" in spec.fits else 6)


def _hole_reach(spec: ToolSpec) -> float:
    """How far that hole reaches from the axis."""
    if "torx" in spec.fits:
        return 0.5 * JAW_PLAY * spec.size
    return spec.size / float(np.sqrt(2.0 if "square" in spec.fits else 3.0))


def _bit(spec: ToolSpec) -> ToolShape:
    reach, length = spec.length("reach"), spec.length("length")
    return ToolShape(
        (("bit", merged([_blade(spec, reach), lathed([disc(spec.length("body") / 2, z) for z in (reach, length)])])),),
        np.eye(4),
        length,
    )


def _blade(spec: ToolSpec, high: float) -> Solid:
    """A hexagon or a square by width across flats, or a round blade."""
    if spec.size > 0.0 and "square socket" in spec.fits:
        return prism(_rectangle(spec.size, spec.size), 0.0, high)
    if spec.size > 0.0:
        return lathed([flats(spec.size, z) for z in (0.0, high)])
    return lathed([disc(spec.length("blade") / 2, z) for z in (0.0, high)])


def _extension(spec: ToolSpec) -> ToolShape:
    bar, end, high = spec.length("bar") / 2, spec.length("end") / 2, spec.size
    low = high - spec.length("end_length")
    return ToolShape(
        (("extension", lathed([disc(bar, 0.0), disc(bar, low), disc(end, low), disc(end, high)])),), np.eye(4), high
    )


def _ratchet(spec: ToolSpec) -> ToolShape:
    head, height, length, grip = (spec.length(name) for name in ("head", "height", "length", "grip"))
    width, thick = spec.length("width"), spec.length("thick")
    begin = length - grip
    z = height - 0.5 * thick
    neck = _bar(0.0, begin, z, 0.6 * width, 0.8 * thick)
    return ToolShape(
        (
            ("ratchet", merged([lathed([disc(head / 2, 0.0), disc(head / 2, height)]), neck])),
            ("grip", _bar(begin, length, z, width, thick)),
        ),
        _along_x(length - 0.5 * grip, z),
        height,
    )


def _bar(begin: float, end: float, z: float, width: float, thick: float) -> Solid:
    return beam([(begin, z, width, thick), (end, z, width, thick)])


def _driver(spec: ToolSpec) -> ToolShape:
    """A straight handle on a shaft: a screwdriver for sockets."""
    return _handled("driver", lathed([disc(spec.length("shaft") / 2, z) for z in (0.0, spec.length("reach"))]), spec)


def _screwdriver(spec: ToolSpec) -> ToolShape:
    return _handled("blade", _blade(spec, spec.length("reach")), spec)


def _handled(name: str, below: Solid, spec: ToolSpec) -> ToolShape:
    low, high = spec.length("reach"), spec.length("reach") + spec.length("grip")
    handle = lathed([disc(spec.length("handle") / 2, z) for z in (low, high)])
    return ToolShape(((name, below), ("grip", handle)), _along_z(0.5 * (low + high)), high)


def _ring(spec: ToolSpec) -> ToolShape:
    """Twelve points inside; the handle leaves the head at its top and rises to its end."""
    outer, thick, length = spec.length("outer"), spec.length("thick"), spec.length("length")
    width, rise = spec.length("width"), spec.length("rise")
    points = 12 if "12-point" in spec.fits else 6
    rings = [flats(spec.size, 0.0, points), disc(outer / 2, 0.0)]
    rings += [disc(outer / 2, thick), flats(spec.size, thick, points)]
    bar = 0.5 * thick
    near, crank, far = 0.5 * (spec.size + outer) / 2, 0.5 * outer + max(rise, 0.1 * length), length
    z = thick - 0.5 * bar
    half = 0.4 * (far - crank) + crank
    neck = beam([(near, z, width, bar), (crank, z + rise, width, bar), (half, z + rise, width, bar)])
    return ToolShape(
        (("ring", merged([lathed(rings, is_ring=True), neck])), ("grip", _bar(0.98 * half, far, z + rise, width, bar))),
        _along_x(0.5 * (half + far), z + rise),
        thick,
        lathed([disc(0.45 * spec.size, z) for z in (0.0, thick)]),
    )


def _open(spec: ToolSpec) -> ToolShape:
    """A jaw that opens against x, and a handle at an angle to it."""
    size, thick = spec.size, spec.length("thick")
    inside, outside = 0.5 * JAW_PLAY * size, 0.5 * spec.length("width")
    tip, floor, back = -0.35 * size, 0.61 * size, 0.95 * size
    jaws = [
        prism([(tip, y), (back, y), (back, y + wall), (tip, y + wall)], 0.0, thick)
        for y, wall in ((inside, outside - inside), (-outside, outside - inside))
    ]
    jaws.append(prism([(floor, -outside), (back, -outside), (back, outside), (floor, outside)], 0.0, thick))
    turn = np.eye(4)
    c, s = np.cos(np.radians(OPEN_DEG)), np.sin(np.radians(OPEN_DEG))
    turn[:2, :2] = [[c, -s], [s, c]]
    far, middle = spec.length("length"), 0.5 * thick
    half = 0.4 * (far - floor) + floor
    shaft = [
        _bar(*ends, middle, spec.length("shaft"), 0.8 * thick) for ends in ((0.8 * size, half), (0.98 * half, far))
    ]
    return ToolShape(
        (("jaw", merged([*jaws, moved(shaft[0], turn)])), ("grip", moved(shaft[1], turn))),
        turn @ _along_x(0.5 * (half + far), middle),
        thick,
        lathed([disc(0.45 * size, z) for z in (0.0, thick)]),
    )


def _hex_key(spec: ToolSpec) -> ToolShape:
    """One arm up, the other across: "up" and "across" are the arm in the screw and the arm in the hand."""
    size, up, across = spec.size, spec.length("up"), spec.length("across")
    half = lathed([flats(size, z) for z in (0.4 * across, across)])
    bend = lathed([flats(size, z) for z in (-0.5 * size, 0.41 * across)])
    place = _along_x(0.0, up - 0.5 * size)
    return ToolShape(
        (("key", merged([_blade(spec, up), moved(bend, place)])), ("grip", moved(half, place))),
        _along_x(0.7 * across, up - 0.5 * size),
        up,
    )


def _pliers(spec: ToolSpec) -> ToolShape:
    """Two jaws on both sides of the wings, from above, and two handles that spread."""
    width, thick, jaw, length = (spec.length(name) for name in ("width", "thick", "jaw", "length"))
    jaws, handles = [], []
    for side in (-1.0, 1.0):
        y = side * (2e-3 + 0.5 * thick)
        jaws.append(moved(prism(_rectangle(width, thick), 0.0, jaw), _shift(0.0, y, 0.0)))
        foot = _rectangle(width, thick)
        ends = [(y, 0.98 * jaw), (side * 0.022, length)]
        handles.append(lathed([np.array([(a, b + across, z) for a, b in foot]) for across, z in ends]))
    return ToolShape((("jaws", merged(jaws)), ("grip", merged(handles))), _along_z(0.5 * (jaw + length)), length)


def _rectangle(x: float, y: float) -> list[tuple[float, float]]:
    return [(-0.5 * x, -0.5 * y), (0.5 * x, -0.5 * y), (0.5 * x, 0.5 * y), (-0.5 * x, 0.5 * y)]


def _shift(x: float, y: float, z: float) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


_MAKERS: Mapping[str, Callable[[ToolSpec], ToolShape]] = {
    "socket": _socket,
    "bit": _bit,
    "extension": _extension,
    "ratchet": _ratchet,
    "driver": _driver,
    "ring": _ring,
    "open": _open,
    "hex_key": _hex_key,
    "screwdriver": _screwdriver,
    "pliers": _pliers,
}
_CORES: Mapping[str, Callable[[ToolSpec], list[list[tuple[float, float]]]]] = {
    "socket": _core_socket,
    "bit": _core_bit,
    "extension": _core_extension,
    "ratchet": _core_ratchet,
    "driver": _core_driver,
}
