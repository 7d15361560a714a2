"""Rolling bearings about z, and things that look like one, for tests; metres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from shapes import Mesh, at, box, joined

from feeler.samples.accessory.solid import Solid

Floats = npt.NDArray[np.float64]
Rows = Sequence[tuple[float, float]]


def lathe(outline: Rows, count: int = 36, spin: float = 0.0) -> Mesh:
    """A closed outline of radii and heights, turned about z."""
    turns = np.arange(count) * math.tau / count + spin
    rows = np.array(outline)
    corners = np.stack([np.outer(np.cos(turns), rows[:, 0]), np.outer(np.sin(turns), rows[:, 0])], axis=-1)
    heights = np.broadcast_to(rows[:, 1], (count, len(rows)))[..., None]
    a = np.arange(count)[:, None] * len(rows) + np.arange(len(rows))
    b, c = np.roll(a, -1, axis=1), np.roll(a, -1, axis=0)
    d = np.roll(c, -1, axis=1)
    faces = np.concatenate([np.stack([a, c, d], axis=-1).reshape(-1, 3), np.stack([a, d, b], axis=-1).reshape(-1, 3)])
    return np.concatenate([corners, heights], axis=-1).reshape(-1, 3), faces


def placed(mesh: Mesh, pose: Floats) -> Mesh:
    return mesh[0] @ pose[:3, :3].T + pose[:3, 3], mesh[1]


def ring(inner: float, outer: float, low: float, high: float, count: int = 36) -> Mesh:
    return lathe([(inner, low), (outer, low), (outer, high), (inner, high)], count)


def solid(outline: Rows, count: int = 16) -> Mesh:
    """A body about z: radii and heights from its lower end, without its ends on the axis, turned about z."""
    rows = np.array(outline)
    turns = np.arange(count) * math.tau / count
    rings = [np.column_stack([r * np.cos(turns), r * np.sin(turns), np.full(count, z)]) for r, z in rows]
    a = np.arange(count)
    b, last = (a + 1) % count, count * (len(rows) - 1)
    faces = [np.column_stack([np.full(count, last + count), b, a])]
    for low in range(0, last, count):
        high = low + count
        faces += [np.column_stack([low + a, low + b, high + b]), np.column_stack([low + a, high + b, high + a])]
    faces.append(np.column_stack([np.full(count, last + count + 1), last + a, last + b]))
    return np.concatenate([*rings, [[0.0, 0.0, rows[0, 1]], [0.0, 0.0, rows[-1, 1]]]]), np.concatenate(faces)


def rod(radius: float, low: float, high: float, count: int = 16) -> Mesh:
    return solid([(radius, low), (radius, high)], count)


def ball(radius: float, rows: int = 8, count: int = 12) -> Mesh:
    turn = np.linspace(-0.5 * math.pi, 0.5 * math.pi, rows + 1)[1:-1]
    vertices, faces = solid([(radius * math.cos(t), radius * math.sin(t)) for t in turn], count)
    vertices[-2:] = [[0.0, 0.0, -radius], [0.0, 0.0, radius]]
    return vertices, faces


def around(
    mesh: Mesh, radius: float, count: int, *, z: float = 0.0, tilt: float = 0.0, turn: float = 0.0
) -> list[Mesh]:
    """The same at each place on a circle, tilted towards the axis there, degrees, and each turned about its own."""
    found = []
    for n in range(count):
        own = at(degrees=360.0 * n / count) @ at(x=radius, z=z) @ at(degrees=tilt, axis=1) @ at(degrees=turn * (n + 1))
        found.append(placed(mesh, own))
    return found


def named(name: str, meshes: Sequence[Mesh]) -> dict[str, Mesh]:
    return {f"{name}_{n + 1}": mesh for n, mesh in enumerate(meshes)}


def groove(
    radius: float, size: float, side: float, shoulders: tuple[float, float] = (0.24, 0.24)
) -> list[tuple[float, float]]:
    """A raceway for balls: size is their diameter, side -1 that of an inner ring; shoulders at the low and the high
    end, in diameters from the pitch circle."""
    ends = [math.acos((share + 0.02) / 0.52) for share in shoulders]
    turn = np.linspace(-ends[0], ends[1], 9)
    return [(radius + side * size * (0.52 * math.cos(t) - 0.02), 0.52 * size * math.sin(t)) for t in turn]


def cage(radius: float, size: float, count: int, half: float) -> Mesh:
    """Two rings beside the elements, and bars between these."""
    wide, thick = 0.12 * size, 0.08 * size
    rings = [ring(radius - wide, radius + wide, *sorted((sign * half, sign * (half + thick)))) for sign in (1.0, -1.0)]
    bar = box((-wide, -0.04 * size, -half), (wide, 0.04 * size, half))
    turned = [placed(each, at(degrees=180.0 / count)) for each in around(bar, radius, count)]
    return joined(*rings, *turned)


def ball_bearing(
    radius: float, size: float, count: int, *, has_cage: bool = True, seals: int = 0, low: float = 0.24
) -> dict[str, Mesh]:
    """Deep grooves; low: one shoulder of the outer ring, in diameters of the balls from the pitch circle."""
    half, wall = 0.8 * size, 0.9 * size
    inner = [(radius - wall, half), (radius - wall, -half), (radius - 0.24 * size, -half)]
    inner += [*groove(radius, size, -1.0), (radius - 0.24 * size, half)]
    outer = [(radius + wall, half), (radius + wall, -half), (radius + 0.24 * size, -half)]
    outer += [*groove(radius, size, 1.0, (0.24, low)), (radius + size * low, half)]
    parts = {"inner": lathe(inner), "outer": lathe(outer, spin=0.1)}
    parts |= named("ball", around(ball(0.5 * size), radius, count, tilt=20.0, turn=35.0))
    if has_cage:
        parts["cage"] = cage(radius, size, count, 0.5 * size)
    for n, sign in zip(range(seals), (1.0, -1.0), strict=False):
        ends = sorted((sign * 0.66 * size, sign * 0.74 * size))
        parts[f"seal_{n + 1}"] = ring(radius - 0.22 * size, radius + 0.3 * size, ends[0], ends[1])
    return parts


def roller_bearing(
    radius: float, size: float, length: float, count: int, *, ribs: str, has_cage: bool = True
) -> dict[str, Mesh]:
    """Cylindrical rollers; ribs: the rings that have them at both ends: "inner", "outer", "both" or "none"."""
    half, wall = 0.5 * length + 0.3 * size, 0.8 * size
    end = 0.51 * length
    parts = {}
    for name, sign in (("inner", -1.0), ("outer", 1.0)):
        race, rib, back = (radius + sign * share * size for share in (0.501, 0.25, 0.5 + wall / size))
        flat = [(race, -half), (race, half)]
        deep = [(rib, -half), (rib, -end), (race, -end), (race, end), (rib, end), (rib, half)]
        parts[name] = lathe([*(deep if ribs in (name, "both") else flat), (back, half), (back, -half)])
    parts |= named("roller", around(rod(0.5 * size, -0.5 * length, 0.5 * length), radius, count, turn=10.0))
    if has_cage:
        parts["cage"] = cage(radius, size, count, 0.515 * length)
    return parts


def tapered_bearing(radius: float, size: float, count: int, angle: float = 12.0) -> dict[str, Mesh]:
    """The cone has ribs, the cup slips off upwards."""
    length, tilt = 1.6 * size, math.radians(angle)
    taper = math.radians(3.0)

    def place(along: float, across: float) -> tuple[float, float]:
        """From along the axis of a roller and across it to distance from the axis and height."""
        return (
            radius + along * math.sin(tilt) * -1.0 + across * math.cos(tilt),
            along * math.cos(tilt) + across * math.sin(tilt),
        )

    half, small, large = (
        0.5 * length,
        0.5 * size - 0.5 * length * math.tan(taper),
        0.5 * size + 0.5 * length * math.tan(taper),
    )
    roller = solid([(large, -half), (small, half)])
    end = half + 0.02 * size
    bore, rim = radius - 1.4 * size, radius + 1.4 * size
    cone = [place(-end, -0.2 * size), place(-end, -large * 1.005), place(end, -small * 1.005), place(end, -0.25 * size)]
    low, high = cone[0][1] - 0.2 * size, cone[-1][1] + 0.2 * size
    inner = [(bore, low), (cone[0][0], low), *cone, (cone[-1][0], high), (bore, high)]
    cup = [place(-end, large * 1.005), place(end, small * 1.005)]
    outer = [*cup, (rim, cup[1][1]), (rim, cup[0][1])]
    parts = {"cone": lathe(inner), "cup": lathe(outer)}
    parts |= named("roller", around(roller, radius, count, tilt=-angle))
    wide = 0.05 * size
    band = [place(-end * 0.7, -wide), place(-end * 0.7, wide), place(end * 0.7, wide), place(end * 0.7, -wide)]
    parts["cage"] = lathe(band)
    return parts


def double_row(radius: float, size: float, count: int) -> dict[str, Mesh]:
    """Two rows of balls between two rings."""
    half, wall = 1.5 * size, 0.9 * size
    parts = {}
    for name, sign in (("inner", -1.0), ("outer", 1.0)):
        land, back = radius + sign * 0.24 * size, radius + sign * wall
        rows = [(land, -half)]
        for z in (-0.65 * size, 0.65 * size):
            rows += [(r, h + z) for r, h in groove(radius, size, sign)]
        parts[name] = lathe([*rows, (land, half), (back, half), (back, -half)])
    for row, z in (("a", -0.65), ("b", 0.65)):
        balls = around(ball(0.5 * size), radius, count, z=z * size)
        turned = [placed(each, at(degrees=0.0 if row == "a" else 180.0 / count)) for each in balls]
        parts |= named(f"ball_{row}", turned)
    return parts


def thrust_bearing(radius: float, size: float, count: int) -> dict[str, Mesh]:
    """Balls in a cage between two washers."""
    parts = {}
    for name, sign in (("shaft_washer", 1.0), ("housing_washer", -1.0)):
        turn = np.linspace(-0.7, 0.7, 7)
        race = [(radius + 0.54 * size * math.sin(t), sign * size * (0.54 * math.cos(t) - 0.04)) for t in turn]
        ends = [(radius - 0.7 * size, race[0][1]), *race, (radius + 0.7 * size, race[0][1])]
        parts[name] = lathe([*ends, (radius + 0.7 * size, sign * 0.9 * size), (radius - 0.7 * size, sign * 0.9 * size)])
    parts |= named("ball", around(ball(0.5 * size), radius, count))
    rings = [
        ring(radius + low * size, radius + high * size, -0.1 * size, 0.1 * size)
        for low, high in ((-0.7, -0.55), (0.55, 0.7))
    ]
    bars = around(box((-0.6 * size, -0.05 * size, -0.1 * size), (0.6 * size, 0.05 * size, 0.1 * size)), radius, count)
    parts["cage"] = joined(*rings, *(placed(each, at(degrees=180.0 / count)) for each in bars))
    return parts


def plate(outlines: Sequence[Floats], low: float, high: float) -> Mesh:
    """An outline (n, 2) with holes, extruded along z."""
    solid = Solid()
    ends = [solid.outline(1e3 * outline, (1e3 * low, 1e3 * high)) for outline in outlines]
    for side in (0, 1):
        solid.face(*(each[side] for each in ends))
    mesh = solid.mesh()
    return 1e-3 * mesh.vertices, mesh.faces.astype(np.int64)


def circle(radius: float, count: int = 24, x: float = 0.0, y: float = 0.0) -> Floats:
    turn = np.arange(count) * math.tau / count
    return np.stack([x + radius * np.cos(turn), y + radius * np.sin(turn)], axis=1)


def holed(inner: float, outer: float, low: float, high: float, hole: float, radius: float, count: int) -> Mesh:
    """A ring with holes around its axis."""
    turn = np.arange(count) * math.tau / count
    holes = [circle(hole, 16, radius * math.cos(t), radius * math.sin(t)) for t in turn]
    return plate([circle(outer, 48), circle(inner, 48), *holes], low, high)


def gear(radius: float, bore: float, low: float, high: float, teeth: int, depth: float) -> Mesh:
    """A wheel with plain teeth; depth less than 0: inside, and the bore is the outside."""
    turn = np.arange(4 * teeth) * math.tau / (4 * teeth)
    radii = np.where(np.arange(4 * teeth) % 4 < 2, radius + 0.5 * depth, radius - 0.5 * depth)
    outline = np.stack([radii * np.cos(turn), radii * np.sin(turn)], axis=1)
    return plate([outline, circle(bore)] if depth > 0.0 else [circle(bore), outline], low, high)
