"""The sample tools: torque driver, wrench, square drive, and a hand that holds a driver."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..arguments import check_flag, check_word
from ..choices import SampleToolName
from ..mockup import Tool
from ..source import Source
from .mesh import Floats, Mesh, at, merge, moved, snapped, turned
from .shapes import Path, bent_path, extrude, revolve, revolve_solid, rounded_box, skin, skin_loops, sweep
from .tessellation import Tolerance, circle, hexagon, lifted, rounded

FINE_TRIANGLES = 50_000


def sample_tool(name: SampleToolName, fine: bool = False) -> Tool:
    """A built-in tool of real size, after the paper's: metres, right-handed, z along its shaft.

    - "torque": a torque driver, 0.26 m, about 280 triangles; origin at the bit's tip, handle towards +z.
    - "wrench": a combination wrench, 0.37 m, about 590 triangles, long and thin; origin in the open jaw's middle, the
      jaw opening towards -z, the ring at +z, flat in the xz plane.
    - "square": a square drive with a cross handle, 0.28 m, about 400 triangles; origin at the square's tip.
    - "hand": a right hand around a driver, about 4,900 triangles; origin at the driver's tip, the fist at z = 0.2 m,
      the forearm towards -x.

    `fine`: the same surfaces with about 50,000 triangles. Closed shells facing outwards, the same bytes on every call.
    Raises OptionError for an unknown name.
    """
    mesh = tool_mesh(name, check_flag("fine", fine))
    note = f"{name}, fine" if fine else name
    source = Source(format="sample", unit_source="samples are metres", notes=(note,))
    return Tool(mesh.vertices, mesh.faces.astype(np.uint32), name=name, source=source)


def sample_tool_names() -> tuple[SampleToolName, ...]:
    """The names that `sample_tool` knows."""
    return tuple(_MAKERS)


def tool_mesh(name: SampleToolName, fine: bool = False) -> Mesh:
    """The result of `sample_tool` as a plain mesh; see there."""
    check_word("name", name, _MAKERS)
    mesh = _tool_mesh(name, fine)
    return Mesh(mesh.vertices.copy(), mesh.faces.copy())


@lru_cache(maxsize=8)
def _tool_mesh(name: SampleToolName, fine: bool) -> Mesh:
    make, triangles = _MAKERS[name]
    mesh = _nearest(make, FINE_TRIANGLES if fine else triangles)
    return Mesh(snapped(mesh.vertices), mesh.faces)


def _nearest(make: Callable[[Tolerance], Mesh], triangles: int) -> Mesh:
    """The tessellation with the triangle count nearest to the requested one."""
    low, high = 1e-8, 4.9e-3
    best: Mesh | None = None
    for _ in range(26):
        chord = float(np.sqrt(low * high))
        mesh = make(Tolerance(chord))
        if best is None or abs(mesh.triangle_count - triangles) < abs(best.triangle_count - triangles):
            best = mesh
        if mesh.triangle_count > triangles:
            low = chord
        else:
            high = chord
    assert best is not None
    return best


def torque_driver(tol: Tolerance) -> Mesh:
    """Hexagon bit, round shaft, torque sleeve, six-lobed handle."""
    tip = skin_loops([hexagon(0.0048), hexagon(0.0062, 0.004), hexagon(0.0062, 0.028)])
    shaft = revolve_solid(np.array([(0.006, 0.024), (0.006, 0.05), (0.004, 0.054), (0.004, 0.14)]), tol)
    sleeve = np.array([(0.009, 0.132), (0.013, 0.137), (0.013, 0.158), (0.011, 0.162)])
    return merge([tip, shaft, revolve_solid(sleeve, tol), driver_handle(0.160, 0.10, tol)])


def driver_handle(low: float, length: float, tol: Tolerance) -> Mesh:
    """A handle with six soft grooves, from z = `low` up."""
    around = tol.circle(0.018, 12, 6)
    along = tol.segments(0.35 * length, 2.2, 3)
    share = np.linspace(0.0, 1.0, along + 1)
    body = 0.0165 * (1.0 - 0.24 * np.cos(2.0 * np.pi * share) ** 2 * (1.0 - share))
    ends = np.clip(np.minimum(share, 1.0 - share) / 0.12, 0.0, 1.0)
    body = body * (0.72 + 0.28 * np.sqrt(1.0 - (1.0 - ends) ** 2))
    angle = np.arange(around) * (2.0 * np.pi / around)
    lobes = 1.0 + 0.055 * np.cos(6.0 * angle)
    rings = [
        np.stack([r * lobes * np.cos(angle), r * lobes * np.sin(angle), np.full(around, low + length * s)], axis=1)
        for r, s in zip(body, share, strict=True)
    ]
    return skin(np.stack(rings))


def wrench(tol: Tolerance) -> Mesh:
    """Open jaw, a slim shaft of I-like section, twelve-point ring."""
    jaw = _jaw(tol)
    shaft = _wrench_shaft(tol)
    return merge([jaw, shaft, _ring_end(tol)])


def _jaw(tol: Tolerance) -> Mesh:
    """The open end in the xz plane: a round head with a parallel slot towards -z."""
    radius, slot, deep = 0.0205, 0.0085, 0.011
    gap = float(np.arcsin(slot / radius))
    sweep_angle = 2.0 * np.pi - 2.0 * gap
    n = tol.segments(radius, sweep_angle, 7)
    turn = -np.pi / 2.0 + gap + np.linspace(0.0, sweep_angle, n + 1)
    arc = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    floor = np.linspace(np.pi, 0.0, tol.segments(slot, np.pi, 3) + 1)
    throat = np.stack([slot * np.cos(floor), deep * 0.5 + 0.45 * deep * np.sin(floor)], axis=1)
    outline = np.concatenate([arc, throat])
    # x, y of the outline become x and z: the sheet's own z points to -y
    return moved(extrude(outline, -0.0045, 0.0045), turned("x", np.pi / 2.0))


def _wrench_shaft(tol: Tolerance) -> Mesh:
    corners = np.array([(0.0075, -0.0028), (0.0075, 0.0028), (-0.0075, 0.0028), (-0.0075, -0.0028)])
    section = rounded(corners, 0.0022, tol)
    rows = tol.segments(0.6, 0.5, 2)
    share = np.linspace(0.0, 1.0, rows + 1)
    z = 0.014 + 0.300 * share
    width = 1.25 - 0.45 * np.sin(np.pi * share) - 0.15 * share
    return skin(np.stack([lifted(section * [w, 1.0], float(h)) for w, h in zip(width, z, strict=True)]))


def _ring_end(tol: Tolerance) -> Mesh:
    """The closed end: a ring about y with twelve points inside."""
    outer = tol.circle(0.017, 24)
    star = circle(0.0112, 24)
    star[::2, :2] *= 0.92
    edge = 0.0012
    loops = [circle(0.017 - edge, outer, -0.0055)]
    count = tol.segments(edge, np.pi / 2.0) if tol.shows(edge * 0.5) else 0
    if count:
        for angle in np.linspace(0.0, np.pi / 2.0, count + 1)[1:]:
            loops.append(circle(0.017 - edge + edge * np.sin(angle), outer, -0.0055 + edge * (1.0 - np.cos(angle))))
        for angle in np.linspace(0.0, np.pi / 2.0, count + 1):
            loops.append(circle(0.017 - edge + edge * np.cos(angle), outer, 0.0055 - edge + edge * np.sin(angle)))
    else:
        loops.append(circle(0.017 - edge, outer, 0.0055))
    loops += [lifted(star[:, :2], 0.0055), lifted(star[:, :2], -0.0055)]
    return moved(skin_loops(loops, closed=True), at(z=0.3305) @ turned("x", np.pi / 2.0))


def square_drive(tol: Tolerance) -> Mesh:
    """A square drive: tapered square end, square bar with ball detent, collar, cross handle with end caps."""
    half = 0.0032
    tip = moved(rounded_box(2 * half, 2 * half, 0.014, 0.0006, 0.0006, tol), at(z=0.014) @ turned("x", np.pi))
    bar = rounded_box(0.0127, 0.0127, 0.235, 0.0015, 0.001, tol)
    collar = revolve(
        rounded(np.array([(0.006, 0.028), (0.012, 0.028), (0.012, 0.046), (0.006, 0.046)]), 0.002, tol), tol, least=8
    )
    head = moved(rounded_box(0.03, 0.026, 0.03, 0.004, 0.003, tol), at(z=0.245))
    across = turned("y", np.pi / 2.0)
    grip = np.array([(0.0055, -0.085), (0.0055, 0.085)])
    cap = np.array([(0.006, 0.0), (0.0085, 0.002), (0.0085, 0.018), (0.006, 0.022)])
    handle = moved(revolve_solid(grip, tol, least=8), at(z=0.26) @ across)
    ends = [
        moved(revolve_solid(cap, tol, least=8), at(z=0.26) @ turned("y", side * np.pi / 2.0) @ at(z=0.075))
        for side in (-1.0, 1.0)
    ]
    return merge([tip, moved(bar, at(z=0.013)), collar, head, handle, *ends])


def hand(tol: Tolerance) -> Mesh:
    """A fist around a driver: palm, wrist, four fingers, thumb; and the driver."""
    grip = 0.2  # where the fist's middle is, along z
    pieces = [_palm(tol)]
    lengths = (0.94, 1.0, 0.97, 0.84)
    for k, size in enumerate(lengths):
        pieces.append(_finger(0.031 - 0.0205 * k, size, tol))
    pieces.append(_thumb(tol))
    blade = revolve_solid(np.array([(0.0022, 0.0), (0.0035, 0.012), (0.0035, 0.148)]), tol)
    fist = [moved(piece, at(z=grip)) for piece in pieces]
    return merge([*fist, blade, driver_handle(0.145, 0.115, tol)])


def _palm(tol: Tolerance) -> Mesh:
    """From the forearm at x = -0.16 to the knuckles: flat rounded sections across x."""
    x = np.array([-0.160, -0.130, -0.100, -0.080, -0.055, -0.025, 0.005, 0.020, 0.027])
    wide = np.array([0.030, 0.029, 0.028, 0.031, 0.041, 0.043, 0.042, 0.038, 0.030])  # half, along z
    thick = np.array([0.023, 0.022, 0.019, 0.017, 0.0175, 0.0165, 0.0125, 0.010, 0.006])  # half, along y
    middle = np.array([-0.037, -0.036, -0.035, -0.034, -0.033, -0.032, -0.031, -0.031, -0.031])
    rows = tol.segments(0.12, 1.6, 7) + 1
    at_x = np.interp(np.linspace(0.0, 1.0, rows), np.linspace(0.0, 1.0, len(x)), x)
    around = tol.circle(0.035, 10)
    angle = np.arange(around) * (2.0 * np.pi / around)
    cosine, sine = np.cos(angle), np.sin(angle)
    flat = (np.sign(cosine) * np.abs(cosine) ** 0.75, np.sign(sine) * np.abs(sine) ** 0.75)
    rings = []
    for value in at_x:
        w, t, m = (float(np.interp(value, x, row)) for row in (wide, thick, middle))
        rings.append(np.stack([np.full(around, value), m + t * flat[0], w * flat[1] - 0.001], axis=1))
    return skin(np.stack(rings))


def _finger(z: float, size: float, tol: Tolerance) -> Mesh:
    """A finger that starts at the knuckle, goes around the handle and ends over the palm's heel."""
    corners = np.array(
        [
            (0.010, -0.033, z),
            (0.046, -0.027, z),
            (0.046, 0.020, z - 0.001),
            (0.004, 0.030, z - 0.002),
            (-0.016, 0.006, z - 0.002),
        ]
    )
    corners[3:, :2] = corners[2:3, :2] + (corners[3:, :2] - corners[2:3, :2]) * size
    return _digit(corners, 0.0102 * (0.82 + 0.18 * size), tol)


def _thumb(tol: Tolerance) -> Mesh:
    """The thumb, from the wrist's side across the fingers."""
    corners = np.array([(-0.062, -0.026, 0.030), (-0.040, 0.004, 0.046), (-0.018, 0.024, 0.049), (0.016, 0.030, 0.047)])
    return _digit(corners, 0.0118, tol)


def _digit(corners: Floats, radius: float, tol: Tolerance) -> Mesh:
    """A bent capsule: thicker at its joints, thinner towards a round tip."""
    path = bent_path(corners, 0.017, radius, tol)
    length = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(path.points, axis=0) ** 2).sum(axis=1)))])
    # long straight runs get rings of their own, so that the skin can swell at the joints
    pieces = tol.segments(0.05, 1.6, 4)
    extra = np.linspace(0.0, length[-1], pieces + 1)[1:-1]
    extra = extra[np.abs(extra[:, None] - length[None]).min(axis=1) > 0.3 * length[-1] / pieces]
    where = np.sort(np.concatenate([length, extra]))
    points = np.stack([np.interp(where, length, path.points[:, k]) for k in range(3)], axis=1)
    tangents = np.stack([np.interp(where, length, path.tangents[:, k]) for k in range(3)], axis=1)
    share = where / where[-1]
    size = 1.0 - 0.2 * share + 0.05 * np.cos(6.0 * np.pi * share)
    rows = tol.segments(radius, np.pi / 2.0, 2)
    dome = np.linspace(0.0, 0.5 * np.pi, rows + 1)[1:] * 0.94
    end = points[-1] + tangents[-1] * (size[-1] * radius * np.sin(dome))[:, None]
    points = np.concatenate([points, end])
    tangents = np.concatenate([tangents, np.repeat(tangents[-1:], rows, axis=0)])
    tangents = tangents / np.sqrt((tangents**2).sum(axis=1, keepdims=True))
    size = np.concatenate([size, size[-1] * np.cos(dome)])
    section = circle(radius, tol.circle(radius, 8))[:, :2]
    return skin(sweep(Path(points, tangents), section, size))


_MAKERS: dict[SampleToolName, tuple[Callable[[Tolerance], Mesh], int]] = {
    "torque": (torque_driver, 280),
    "wrench": (wrench, 588),
    "square": (square_drive, 400),
    "hand": (hand, 4908),
}
