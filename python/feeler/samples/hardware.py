"""Standard parts: bolts, nuts, washers, rivets, bearings, clamps, brackets, connectors, boxes, pumps.

Every function takes its sizes in metres and last a `Tolerance`, and returns a mesh in the part's own frame, which the
function names.
"""

from __future__ import annotations

import numpy as np

from .mesh import Floats, Mesh, at, merge, moved, turned
from .shapes import bent_path, box, plate, revolve, revolve_solid, rounded_box, sheet, skin, skin_loops, tube
from .tessellation import Tolerance, circle, hexagon, rounded


def hex_bolt(size: float, length: float, tol: Tolerance) -> Mesh:
    """A hexagon bolt of thread `size`: head on z > 0, shank down to z = -length, threaded where fine enough."""
    radius, flats, head = size / 2.0, 1.65 * size, 0.68 * size
    if tol.coarse:
        return skin_loops([hexagon(flats, -0.3 * head), hexagon(flats, head)])
    n = tol.circle(radius, 6)
    loops = _shank(radius, length, n, tol)
    if tol.shows(0.05 * size):
        washer = tol.circle(1.05 * size, 6)
        loops += [circle(1.05 * size, washer), circle(1.05 * size, washer, 0.12 * size)]
        loops += [hexagon(flats, 0.12 * size), hexagon(flats, head - 0.06 * size), circle(0.46 * flats, n, head)]
    else:
        loops += [hexagon(flats), hexagon(flats, head)]
    return skin_loops(loops)


def cap_screw(size: float, length: float, tol: Tolerance) -> Mesh:
    """A socket head cap screw: head on z > 0 with a hexagon socket, shank down to z = -length."""
    radius = size / 2.0
    if tol.coarse:
        return skin_loops([circle(0.75 * size, 4, -0.3 * size), circle(0.75 * size, 4, 0.9 * size)])
    n = tol.circle(0.75 * size, 6)
    loops = _shank(radius, length, n, tol)
    loops += [circle(0.75 * size, n), circle(0.75 * size, n, 0.9 * size)]
    if tol.shows(0.1 * size):
        loops += [circle(0.68 * size, n, size), hexagon(0.8 * size, size), hexagon(0.8 * size, 0.45 * size)]
    return skin_loops(loops)


def _shank(radius: float, length: float, n: int, tol: Tolerance) -> list[Floats]:
    chamfer = 0.12 * radius
    if not tol.shows(chamfer):
        return [circle(radius, n, -length), circle(radius, n)]
    loops = [circle(radius - chamfer, n, -length), circle(radius, n, -length + chamfer)]
    pitch = max(0.3 * radius, 8e-4)
    if tol.shows(0.1 * pitch):
        turns = min(30, int(0.6 * length / pitch))
        for turn in range(turns):
            z = -length + chamfer + turn * pitch
            loops.append(circle(radius - 0.35 * pitch, n, z + 0.5 * pitch))
            loops.append(circle(radius, n, z + pitch))
    return [*loops, circle(radius, n)]


def nut(size: float, tol: Tolerance) -> Mesh:
    """A hexagon nut on z = 0, about z."""
    n = tol.circle(size / 2.0, 6)
    flats, high = 1.65 * size, 0.8 * size
    if tol.coarse:
        return skin_loops([hexagon(flats), hexagon(flats, high)])
    if tol.shows(0.06 * size):
        wide = tol.circle(0.47 * flats, 6)
        return skin_loops(
            [
                circle(0.47 * flats, wide),
                hexagon(flats, 0.08 * size),
                hexagon(flats, high - 0.08 * size),
                circle(0.47 * flats, wide, high),
                circle(0.52 * size, n, high),
                circle(0.46 * size, n, high - 0.06 * size),
                circle(0.46 * size, n, 0.06 * size),
                circle(0.52 * size, n),
            ],
            closed=True,
        )
    bore = 0.48 * size
    loops = [hexagon(flats), hexagon(flats, high), circle(bore, n, high), circle(bore, n)]
    return skin_loops(loops, closed=True)


def washer(size: float, tol: Tolerance) -> Mesh:
    """A plain washer for thread `size`, on z = 0."""
    return ring(0.53 * size, 1.05 * size, 0.15 * size, tol)


def ring(inner: float, outer: float, height: float, tol: Tolerance) -> Mesh:
    """A plain ring on z = 0."""
    return revolve(np.array([[inner, 0.0], [outer, 0.0], [outer, height], [inner, height]]), tol)


def rivet(radius: float, tol: Tolerance) -> Mesh:
    """A flat-domed rivet head on z = 0, with a short stem below."""
    dome = [(0.95 * radius, 0.25 * radius), (0.6 * radius, 0.5 * radius)] if tol.shows(0.3 * radius) else []
    stem = [(0.5 * radius, -radius), (0.5 * radius, 0.0)] if tol.shows(0.4 * radius) else []
    return revolve_solid(np.array([*stem, (radius, 0.0), *(dome or [(radius, 0.4 * radius)])]), tol)


def ball(radius: float, tol: Tolerance) -> Mesh:
    """A sphere about the origin, its poles on z."""
    rows, n = tol.segments(radius, np.pi, 3), tol.circle(radius, 6)
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, rows + 1)[1:-1]
    rings = np.stack([circle(radius * np.cos(a), n, radius * np.sin(a)) for a in angle])
    body = skin(rings)
    sides = body.faces[: -2 * (n - 2)]  # without the flat caps
    south, north = rings.shape[0] * n + np.arange(2)
    here = np.arange(n)
    ahead, top = np.roll(here, -1), (rings.shape[0] - 1) * n
    fans = [
        np.stack([ahead, here, np.full(n, south)], axis=1),
        np.stack([here + top, ahead + top, np.full(n, north)], axis=1),
    ]
    poles = np.array([[0.0, 0.0, -radius], [0.0, 0.0, radius]])
    return Mesh(np.concatenate([body.vertices, poles]), np.concatenate([sides, *fans]))


def roller(radius: float, length: float, tol: Tolerance) -> Mesh:
    """A bearing roller about z, centred."""
    edge = 0.1 * radius
    half = length / 2.0
    profile = np.array([(radius - edge, -half), (radius, edge - half), (radius, half - edge), (radius - edge, half)])
    return revolve_solid(profile if tol.shows(edge) else profile[1:3] * [1.0, half / (half - edge)], tol)


def race(inner: float, outer: float, width: float, groove: float, outside: bool, tol: Tolerance) -> Mesh:
    """A ball bearing's race about z, centred; `groove`: radius of the track, in the inner or the outer wall."""
    half = width / 2.0
    corners = np.array([[inner, -half], [outer, -half], [outer, half], [inner, half]])
    if not tol.shows(groove * 0.3):
        return revolve(corners, tol)
    deep, pieces = 0.35 * groove, tol.segments(groove, 1.7, 2)
    open_half = min(0.75 * groove, 0.45 * width)
    z = np.linspace(-open_half, open_half, pieces + 1)
    sag = deep * (1.0 - (z / open_half) ** 2)
    if outside:  # the outer race: its track is cut into the inner wall, walked downwards
        track = np.stack([inner + sag[::-1], z[::-1]], axis=1)
        profile = np.concatenate([corners[:1], corners[1:3], corners[3:], track])
    else:
        track = np.stack([outer - sag, z], axis=1)
        profile = np.concatenate([corners[:2], track, corners[2:]])
    return revolve(profile, tol)


def saddle_clamp(radius: float, tol: Tolerance) -> Mesh:
    """A pipe clamp for pipe `radius`: pipe axis z, its feet towards -y at y = -(radius + 2 mm)."""
    inner, outer = radius, radius + 0.0016
    if tol.coarse:
        return moved(box(2.0 * outer + 0.012, 2.0 * outer, 0.016), at(z=-0.008))
    thick = outer - inner
    middle, foot, low = 0.5 * (inner + outer), outer + 0.013, -(radius + 0.002) + 0.5 * thick
    angle = np.linspace(np.pi, 0.0, tol.segments(outer, np.pi, 3) + 1)
    arc = middle * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    line = np.concatenate([[[-foot, low], [-middle, low]], arc, [[middle, low], [foot, low]]])
    return sheet(line, thick, 0.001, -0.008, 0.008, tol)


def clamp_foot(radius: float) -> float:
    """How far a `saddle_clamp`'s screws stand from the pipe's axis, along x."""
    return radius + 0.0016 + 0.0075


def standoff(width: float, height: float, depth: float, tol: Tolerance) -> Mesh:
    """A bracket that carries a clamp: a bent sheet, its plate under y = 0 down to y = -height; sheet along z."""
    t, w = 0.002, width / 2.0
    foot = w + 0.014
    if tol.coarse or height < 4.0 * t:
        return moved(box(width if tol.coarse else 2.0 * foot, depth, height), at(y=-height) @ turned("x", -np.pi / 2.0))
    low, top = -height + t / 2.0, -t / 2.0
    line = np.array([[-foot, low], [-w, low], [-w, top], [w, top], [w, low], [foot, low]])
    return sheet(line, t, 0.003, -depth / 2.0, depth / 2.0, tol)


def angle_bracket(width: float, height: float, depth: float, tol: Tolerance) -> Mesh:
    """An L of sheet with bolt holes: foot on z = 0 (x 0..depth), back up to z = height at x = 0; width along y."""
    t = 0.003
    foot = moved(plate(depth, width, t, 1, 2, 0.003, tol), at(x=depth / 2.0))
    back = moved(plate(height, width, t, 2, 2, 0.003, tol), turned("y", -np.pi / 2.0))
    return merge([foot, moved(back, at(x=t, z=height / 2.0))])


def boss(radius: float, height: float, bore: float, tol: Tolerance) -> Mesh:
    """A threaded boss or port on z = 0, with a fillet at its foot and a bore."""
    foot = min(0.5 * radius, 0.4 * height)
    if tol.coarse:
        return revolve_solid(np.array([[radius, -0.3 * height], [radius, height]]), tol)
    if not tol.shows(bore * 0.5):
        return revolve_solid(np.array([[radius + 0.4 * foot, -0.3 * height], [radius, height]]), tol)
    corners = np.array(
        [
            [bore, -0.3 * height], [radius + foot, -0.3 * height], [radius + foot, 0.0], [radius, foot * 0.5],
            [radius, height], [bore * 1.2, height], [bore, height - 0.2 * bore],
        ]
    )  # fmt: skip
    radii = np.array([0.0, 0.0, 0.0, foot * 0.5, 0.0008, 0.0, 0.0])
    return revolve(rounded(corners, radii, tol), tol)


def union(radius: float, tol: Tolerance) -> Mesh:
    """A pipe union about z, from z = 0 up: hexagon nut and sleeve for pipe `radius`."""
    flats = 2.0 * radius * 1.45 + 0.004
    if tol.coarse:
        return skin_loops([hexagon(flats), hexagon(flats, 0.011 + 0.6 * radius)])
    sleeve = radius * 1.2 + 0.001
    n = tol.circle(sleeve, 6)
    loops = [circle(sleeve, n, -0.004), circle(sleeve, n), hexagon(flats), hexagon(flats, 0.011 + 0.6 * radius)]
    top = 0.011 + 0.6 * radius
    loops += [circle(sleeve, n, top), circle(sleeve, n, top + 0.005), circle(radius * 1.02, n, top + 0.007)]
    return skin_loops(loops)


def connector(radius: float, length: float, tol: Tolerance) -> Mesh:
    """A round electrical connector on z = 0: flange, knurled ring, backshell."""
    steps = np.array(
        [
            (radius * 1.25, 0.0), (radius * 1.25, 0.12), (radius, 0.14), (radius, 0.3), (radius * 1.15, 0.32),
            (radius * 1.15, 0.62), (radius * 0.95, 0.65), (radius * 0.95, 0.8), (radius * 0.7, 1.0),
        ]
    ) * [1.0, length]  # fmt: skip
    coarse = steps[[0, 8]] if tol.coarse else steps[[0, 1, 4, 5, 8]]
    return revolve_solid(steps if tol.shows(0.1 * radius) else coarse, tol)


def control_box(x: float, y: float, z: float, ribs: int, tol: Tolerance) -> Mesh:
    """An electronics box on z = 0: cast body, lid with a lip, cooling ribs along y, four feet."""
    foot = 0.008
    pieces = [moved(rounded_box(x, y, z - foot, 0.008, 0.003, tol), at(z=foot))]
    if tol.shows(0.002):
        pieces.append(moved(plate(x * 1.04, y * 1.04, 0.004, 3, 2, 0.002, tol), at(z=0.7 * z)))
        for k in range(ribs):
            pieces.append(moved(box(0.0025, y * 0.9, 0.012), at(x=x * ((k + 0.5) / ribs - 0.5) * 0.9, z=z - 0.001)))
        for sx in (-0.5, 0.5):
            for sy in (-0.5, 0.5):
                pieces.append(moved(plate(0.026, 0.022, foot, 1, 1, 0.0035, tol), at(sx * (x + 0.012), sy * y * 0.8)))
    return merge(pieces)


def pump(radius: float, length: float, tol: Tolerance) -> Mesh:
    """A fuel or oil pump about z, mounting flange at z = 0, stepped round body, two ports on its side."""
    r, h = radius, length
    corners = np.array(
        [
            (0.35 * r, -0.08 * h), (0.35 * r, -0.01 * h), (1.15 * r, 0.0), (1.15 * r, 0.06 * h), (0.9 * r, 0.08 * h),
            (0.9 * r, 0.35 * h), (r, 0.37 * h), (r, 0.44 * h), (0.8 * r, 0.46 * h), (0.8 * r, 0.75 * h),
            (0.86 * r, 0.76 * h), (0.86 * r, 0.8 * h), (0.55 * r, 0.83 * h), (0.5 * r, h),
        ]
    )  # fmt: skip
    if not tol.shows(0.04 * r):
        return revolve_solid(corners[[2, 9] if tol.coarse else [2, 3, 5, 9, 13]], tol)
    body = _filleted_solid(corners, 0.03 * r, tol)
    ports = [
        moved(
            boss(0.22 * r, 0.5 * r, 0.12 * r, tol),
            turned("z", turn) @ at(0.75 * r, 0.0, z * h) @ turned("y", np.pi / 2),
        )
        for turn, z in ((0.4, 0.2), (2.3, 0.6))
    ]
    return merge([body, *ports])


def generator(radius: float, length: float, tol: Tolerance) -> Mesh:
    """A starter or generator about z, flange at z = 0, finned drum, end bell."""
    fins = 6
    if tol.coarse:
        return revolve_solid(np.array([[radius, 0.0], [0.8 * radius, length]]), tol)
    rows = [(0.5 * radius, -0.03 * length), (0.5 * radius, -0.005 * length), (1.1 * radius, 0.0)]
    rows += [(1.1 * radius, 0.05 * length), (0.85 * radius, 0.07 * length)]
    if tol.shows(0.02 * radius):
        for fin in range(fins):
            z = (0.15 + 0.08 * fin) * length
            rows += [(0.85 * radius, z), (radius, z), (radius, z + 0.03 * length), (0.85 * radius, z + 0.03 * length)]
    rows += [(0.85 * radius, 0.7 * length), (0.95 * radius, 0.72 * length), (0.95 * radius, 0.9 * length)]
    rows += [(0.7 * radius, 0.98 * length), (0.3 * radius, length)]
    return _filleted_solid(np.array(rows), 0.02 * radius, tol)


def valve(radius: float, tol: Tolerance) -> Mesh:
    """A control valve: body along z between -2 and 2 radii, actuator can on top along x."""
    r = radius
    if tol.coarse:
        return moved(box(2.0 * r, 2.0 * r, 4.0 * r), at(z=-2.0 * r))
    corners = np.array(
        [
            (r, -2.0 * r), (1.3 * r, -1.98 * r), (1.3 * r, -1.7 * r), (r, -1.65 * r),
            (1.5 * r, -0.8 * r), (1.5 * r, 0.8 * r),
            (r, 1.65 * r), (1.3 * r, 1.7 * r), (1.3 * r, 1.98 * r), (r, 2.0 * r),
        ]
    )  # fmt: skip
    body = _filleted_solid(corners if tol.shows(0.1 * r) else corners[[1, 4, 5, 8]], 0.08 * r, tol)
    can = np.array([(0.5 * r, 0.0), (0.5 * r, 2.0 * r), (1.2 * r, 2.1 * r), (1.2 * r, 4.0 * r), (0.9 * r, 4.3 * r)])
    actuator = _filleted_solid(can, 0.1 * r, tol)
    return merge([body, moved(actuator, turned("y", np.pi / 2.0))])


def injector(length: float, tol: Tolerance) -> Mesh:
    """A fuel injector: flange on z = 0 with holes, arm down through the casing, bent, with a nozzle at its end."""
    if tol.coarse:
        return moved(box(0.03, 0.03, length), at(z=-length))
    arm = bent_path(np.array([[0.0, 0.0, 0.012], [0.0, 0.0, -length], [0.0, 0.06, -length]]), 0.02, 0.008, tol)
    cone = np.array([(0.008, 0.0), (0.016, 0.002), (0.018, 0.018), (0.014, 0.03), (0.006, 0.03)])
    nozzle = moved(revolve_solid(cone, tol), at(y=0.05, z=-length) @ turned("x", -np.pi / 2.0))
    return merge([plate(0.05, 0.034, 0.006, 2, 1, 0.003, tol), tube(arm, 0.008, 0.0, tol), nozzle])


def igniter(length: float, tol: Tolerance) -> Mesh:
    """An igniter plug along z: hexagon at z = 0, tip at z = -length, lead connector above."""
    n = tol.circle(0.009, 6)
    if tol.coarse:
        return skin_loops([circle(0.007, n, -length), circle(0.009, n, 0.05)])
    loops = [circle(0.005, n, -length), circle(0.007, n, -length * 0.95), circle(0.007, n), hexagon(0.024)]
    loops += [hexagon(0.024, 0.012), circle(0.009, n, 0.012), circle(0.009, n, 0.05), circle(0.006, n, 0.055)]
    return skin_loops(loops)


def _filleted_solid(profile: Floats, radius: float, tol: Tolerance) -> Mesh:
    """A revolved solid whose inner profile corners are rounded; its flat ends keep their edges."""
    closed = np.concatenate([profile, [[0.0, profile[-1, 1]], [0.0, profile[0, 1]]]])
    radii = np.full(len(closed), radius)
    radii[[0, len(profile) - 1, -1, -2]] = 0.0
    outline = rounded(closed, radii, tol)
    return revolve_solid(outline[outline[:, 0] > 0.0], tol)
