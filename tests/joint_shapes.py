"""Hinges, shafts, slides, threads and seats, drawn at random, with the joint that they make."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from shapes import Mesh, box, joined, mockup_of

import feeler

Floats = npt.NDArray[np.float64]
Loop = Floats


@dataclass(frozen=True)
class Drawn:
    """A mock-up of two sides, and the joint between them. kind: "error" where there is none."""

    kind: str
    child: dict[str, Mesh]
    parent: dict[str, Mesh]
    axis: Floats
    point: Floats
    off: float
    """How far the axis found may be from this one, metres."""
    pitch: float = 0.0

    @property
    def mockup(self) -> feeler.Mockup:
        return mockup_of(
            {f"model/{side}/{k}": m for side in ("child", "parent") for k, m in getattr(self, side).items()}
        )


def fault_of(drawn: Drawn, find: Callable[..., feeler.Joint]) -> str:
    """What is wrong with the joint found; empty if nothing."""
    try:
        joint = find(drawn.mockup, "model/child", "model/parent")
    except feeler.JointError as error:
        return "" if drawn.kind == "error" else f"{drawn.kind}: {error}"
    if joint.kind != drawn.kind:
        return f"{drawn.kind} is called {joint.kind}: {joint.because}"
    if drawn.kind == "fixed":
        return ""
    axis = np.array(joint.axis)
    if np.linalg.norm(np.cross(axis, drawn.axis)) > 0.002:
        return f"{drawn.kind}: the axis is off by {np.linalg.norm(np.cross(axis, drawn.axis)):.4f}"
    off = np.linalg.norm(np.cross(np.array(joint.point) - drawn.point, drawn.axis))
    if drawn.kind != "prismatic" and off > drawn.off:
        return f"{drawn.kind}: the axis is {off / drawn.off:.1f} times as far as it may be"
    if drawn.pitch and abs(joint.pitch / drawn.pitch - 1.0) > 0.02:
        return f"screw: pitch {joint.pitch} instead of {drawn.pitch}"
    return ""


# ----- bodies about z


def circle(radius: float, count: int, phase: float = 0.0) -> Loop:
    at = phase + np.arange(count) * (2 * np.pi / count)
    return radius * np.stack([np.cos(at), np.sin(at)], axis=1)


def rectangle(x: float, y: float) -> Loop:
    return np.array([[x, -y], [x, y], [-x, y], [-x, -y]])


def flattened(radius: float, flat: float, count: int, phase: float) -> Loop:
    """A circle without what lies beyond x = flat."""
    loop = circle(radius, count, phase)
    edge = np.arccos(flat / radius)
    inside = loop[loop[:, 0] < flat * 0.999]
    ends = radius * np.array([[np.cos(edge), np.sin(edge)], [np.cos(edge), -np.sin(edge)]])
    points = np.concatenate([inside, ends])
    return points[np.argsort(np.arctan2(points[:, 1], points[:, 0]))]


def splined(inner: float, outer: float, teeth: int, gap: float = 0.0) -> Loop:
    """A shaft with teeth; gap: their flanks stand off by it, outwards for a hole."""
    step = 2 * np.pi / teeth
    points = []
    for k in range(teeth):
        grow = gap / outer
        for share, radius in ((-0.25, inner), (-0.25, outer), (0.0, outer), (0.25, outer), (0.25, inner), (0.5, inner)):
            at = (k + share) * step + (grow * np.sign(share) if abs(share) == 0.25 else 0.0)
            points.append([radius * np.cos(at), radius * np.sin(at)])
    return np.array(points)


def walls(loop: Loop, levels: Floats, outwards: bool, rng: np.random.Generator) -> Mesh:
    """The wall over a loop that runs counter-clockwise, its quads cut either way."""
    count = len(loop)
    vertices = np.concatenate([np.column_stack([loop, np.full(count, z)]) for z in levels])
    faces = []
    for j in range(len(levels) - 1):
        for i in range(count):
            a, b = j * count + i, j * count + (i + 1) % count
            c, d = a + count, b + count
            quad = [[a, b, d], [a, d, c]] if rng.integers(2) else [[a, b, c], [b, d, c]]
            faces += quad if outwards else [f[::-1] for f in quad]
    return vertices, np.array(faces)


def cap(loop: Loop, z: float, up: bool) -> Mesh:
    middle = loop.mean(axis=0)
    vertices = np.concatenate([np.column_stack([loop, np.full(len(loop), z)]), [[*middle, z]]])
    n = len(loop)
    faces = np.array([[i, (i + 1) % n, n] for i in range(n)])
    return vertices, faces if up else faces[:, ::-1].copy()


def ring(outer: Loop, inner: Loop, z: float, up: bool) -> Mesh:
    """The face between two loops around the origin, of any numbers of points."""
    points = np.concatenate([outer, inner])
    n, m = len(outer), len(inner)
    at = np.arctan2(points[:, 1], points[:, 0])
    o, i = np.argsort(at[:n]), n + np.argsort(at[n:])
    turn_o = np.concatenate([at[o], at[o[:1]] + 2 * np.pi])
    turn_i = np.concatenate([at[i], at[i[:1]] + 2 * np.pi])
    a = b = 0
    faces = []
    while a < n or b < m:
        if b >= m or (a < n and turn_o[a + 1] <= turn_i[b + 1]):
            faces.append([o[a], o[(a + 1) % n], i[b % m]])
            a += 1
        else:
            faces.append([o[a % n], i[(b + 1) % m], i[b]])
            b += 1
    return np.column_stack([points, np.full(n + m, z)]), np.array(faces if up else [f[::-1] for f in faces])


def solid(loop: Loop, low: float, high: float, rng: np.random.Generator) -> Mesh:
    return joined(walls(loop, levels(low, high, rng), True, rng), cap(loop, low, False), cap(loop, high, True))


def sleeve(outer: Loop, inner: Loop, low: float, high: float, rng: np.random.Generator) -> Mesh:
    return joined(
        walls(outer, np.array([low, high]), True, rng),
        walls(inner, levels(low, high, rng), False, rng),
        ring(outer, inner, low, False),
        ring(outer, inner, high, True),
    )


def levels(low: float, high: float, rng: np.random.Generator) -> Floats:
    return np.linspace(low, high, int(rng.integers(1, 4)) + 1)


def thread(profile: Floats, pitch: float, turns: float, count: int, outwards: bool, phase: float = 0.0) -> Mesh:
    """A wall that winds around z; profile: (radius, z) over one pitch."""
    steps = int(turns * count) + 1
    at = phase + np.arange(steps) * (2 * np.pi / count)
    rows = np.concatenate([profile, profile[:1] + np.array([0.0, pitch])])
    r, z = rows[:, 0][None, :], rows[:, 1][None, :] + (pitch * at / (2 * np.pi))[:, None]
    grid = np.stack([r * np.cos(at)[:, None], r * np.sin(at)[:, None], z], axis=2)
    n = len(rows)
    faces = []
    for k in range(steps - 1):
        for j in range(n - 1):
            a, b, c, d = k * n + j, (k + 1) * n + j, k * n + j + 1, (k + 1) * n + j + 1
            quad = [[a, b, d], [a, d, c]]
            faces += quad if outwards else [f[::-1] for f in quad]
    return grid.reshape(-1, 3), np.array(faces)


def ball(radius: float, count: int, outwards: bool, low: float = -np.pi / 2, high: float = np.pi / 2) -> Mesh:
    at = np.linspace(low, high, count // 2 + 1)
    rows = []
    for lat in at:
        rows.append(
            np.column_stack([circle(radius * max(np.cos(lat), 1e-3), count), np.full(count, radius * np.sin(lat))])
        )
    faces = []
    for j in range(len(at) - 1):
        for i in range(count):
            a, b = j * count + i, j * count + (i + 1) % count
            faces += [[a, b, b + count], [a, b + count, a + count]]
    of = np.array(faces)
    return np.concatenate(rows), of if outwards else of[:, ::-1].copy()


# ----- joints


def _around(rng: np.random.Generator, radius: float) -> Loop:
    """An outside: round, or a rectangle."""
    if rng.integers(2):
        return circle(radius * rng.uniform(1.5, 3.0), int(rng.integers(8, 64)))
    return rectangle(radius * rng.uniform(1.6, 4.0), radius * rng.uniform(1.6, 4.0))


def _count(rng: np.random.Generator) -> int:
    return int(np.exp(rng.uniform(np.log(8), np.log(96))))


def shaft(rng: np.random.Generator) -> Drawn:
    """A shaft with a collar at both ends, in one bore or in two bearings."""
    play, phase = rng.uniform(-0.003, 0.03), rng.uniform(0, 6)
    length, gap = rng.uniform(0.6, 8.0), rng.uniform(0.0, 0.02)
    two = length > 3 and rng.integers(2)
    spans = [(0.0, length * 0.15), (length * 0.85, length)] if two else [(0.0, length)]
    n = _count(rng)
    outer = _around(rng, 1.0)
    blocks = {f"bearing_{k}": sleeve(outer, circle(1 + play, _count(rng)), a, b, rng) for k, (a, b) in enumerate(spans)}
    wide = circle(rng.uniform(1.2, 2.0), _count(rng))
    size = min(gap, 0.01 * length)
    rod = walls(circle(1.0, n, phase), np.array([-size, length + size]), True, rng)
    below, above = rng.uniform(0.1, 2.0, 2)
    inside = circle(1.0, n, phase)
    parts = [
        rod,
        walls(wide, np.array([-size - below, -size]), True, rng),
        cap(wide, -size - below, False),
        ring(wide, inside, -size, True),
        walls(wide, np.array([length + size, length + size + above]), True, rng),
        cap(wide, length + size + above, True),
        ring(wide, inside, length + size, False),
    ]
    return _placed(rng, "revolute", {"shaft": joined(*parts)}, blocks, max(play, 0.0))


def hinge(rng: np.random.Generator) -> Drawn:
    """Knuckles of two leaves on a pin."""
    play, gap = rng.uniform(0.0, 0.03), rng.uniform(0.002, 0.03)
    knuckles, width = int(rng.integers(3, 8)), rng.uniform(0.8, 4.0)
    sides: tuple[dict[str, Mesh], dict[str, Mesh]] = ({}, {})
    outer = rng.uniform(1.3, 2.2)
    n = _count(rng)
    pieces: tuple[list[Mesh], list[Mesh]] = ([], [])
    for k in range(knuckles):
        low, high = k * width + gap / 2, (k + 1) * width - gap / 2
        pieces[k % 2].append(sleeve(circle(outer, n), circle(1 + play, n), low, high, rng))
    reach = rng.uniform(4, 15)
    for k in range(2):
        shift = -1.0 if k else 1.0
        thick = rng.uniform(0.1, 0.4)
        leaf = solid(rectangle(reach / 2, thick), 0.0, knuckles * width, rng)
        leaf[0][:, 0] += shift * (reach / 2 + outer * 1.02)
        sides[k]["leaf"] = joined(leaf, *pieces[k])
    pin = solid(circle(1.0, _count(rng), rng.uniform(0, 6)), -0.5, knuckles * width + 0.5, rng)
    sides[int(rng.integers(2))]["pin"] = pin
    return _placed(rng, "revolute", sides[0], sides[1], play)


def door(rng: np.random.Generator) -> Drawn:
    """A panel on pins above and below, flush in a frame with an even gap all round."""
    thick, wide, high = 2.0, *rng.uniform(10.0, 60.0, 2)
    gap = float(np.exp(rng.uniform(np.log(0.002), np.log(0.05)))) * min(wide, high)
    pin, play, edge = rng.uniform(0.3, 0.7), rng.uniform(0.0, 0.03), rng.uniform(1.0, 2.0)
    n, beam = _count(rng), gap + rng.uniform(2.0, 6.0)
    panel = box((-edge, -thick / 2, 0.0), (wide - edge, thick / 2, high))
    child, parent = {"panel": panel}, {}
    left, right = -edge - gap, wide - edge + gap
    for k, (low, top, foot, tip) in enumerate(
        ((-gap - beam, -gap, 0.0, -gap - 1.0), (high + gap, high + gap + beam, high, high + gap + 1.0))
    ):
        child[f"pin_{k}"] = solid(circle(pin, n, rng.uniform(0, 6)), min(foot, tip), max(foot, tip), rng)
        parent[f"bore_{k}"] = sleeve(rectangle(edge, thick / 2), circle(pin * (1 + play), _count(rng)), low, top, rng)
        for side, (a, b) in enumerate(((left - beam, -edge), (edge, right + beam))):
            parent[f"beam_{k}_{side}"] = box((a, -thick / 2, low), (b, thick / 2, top))
    parent["post"] = box((left - beam, -thick / 2, -gap), (left, thick / 2, high + gap))
    parent["jamb"] = box((right, -thick / 2, -gap), (right + beam, thick / 2, high + gap))
    if rng.integers(2):
        parent = {"frame": joined(*parent.values())}
    return _placed(rng, "revolute", child, parent, pin * play)


def piston(rng: np.random.Generator) -> Drawn:
    """A rod through a bore."""
    play = rng.uniform(-0.003, 0.03)
    length = rng.uniform(0.6, 6.0)
    rod = solid(circle(1.0, _count(rng), rng.uniform(0, 6)), -rng.uniform(0.5, 4), length + rng.uniform(0.5, 4), rng)
    block = sleeve(_around(rng, 1.0), circle(1 + play, _count(rng)), 0.0, length, rng)
    return _placed(rng, "cylindrical", {"rod": rod}, {"block": block}, max(play, 0.0))


def taper(rng: np.random.Generator) -> Drawn:
    """A taper pin in its hole, with or without play."""
    length, play = rng.uniform(1.0, 8.0), rng.uniform(0.0, 0.02) * rng.integers(2)
    lean = float(np.exp(rng.uniform(np.log(0.01), np.log(0.3)))) * min(1.0, 2.0 / length)
    n, phase = _count(rng), rng.uniform(0, 6)
    m, other = (n, phase) if rng.integers(2) else (_count(rng), rng.uniform(0, 6))
    over = rng.uniform(0.0, 0.5)
    pin = _frustum(circle(1.0, n, phase), -over, length + over, lean)
    caps = [cap(circle(1.0 + lean * z, n, phase), z, up) for z, up in ((-over, False), (length + over, True))]
    around = _around(rng, 1.5 + lean * length)
    ends = [circle(1.0 + play + lean * z, m, other) for z in (0.0, length)]
    bore = _frustum(circle(1.0 + play, m, other), 0.0, length, lean)
    block = joined(
        walls(around, np.array([0.0, length]), True, rng),
        (bore[0], bore[1][:, ::-1].copy()),
        ring(around, ends[0], 0.0, False),
        ring(around, ends[1], length, True),
    )
    return _placed(rng, "revolute", {"pin": joined(pin, *caps)}, {"block": block}, play)


def _frustum(loop: Loop, low: float, high: float, lean: float) -> Mesh:
    """The wall over a loop of radius 1 at z = 0 that widens upwards."""
    radius = float(np.linalg.norm(loop[0]))
    rows = [np.column_stack([loop * (1.0 + lean * z / radius), np.full(len(loop), z)]) for z in (low, high)]
    n = len(loop)
    faces = [f for i in range(n) for f in ([i, (i + 1) % n, n + (i + 1) % n], [i, n + (i + 1) % n, n + i])]
    return np.concatenate(rows), np.array(faces)


def slide(rng: np.random.Generator) -> Drawn:
    """A bar in a channel, a dovetail, a D-shaft or a splined shaft."""
    play = rng.uniform(0.0, 0.02)
    length = rng.uniform(1.0, 6.0)
    outer = _around(rng, 2.0)
    match int(rng.integers(4)):
        case 0:
            x, y = rng.uniform(0.3, 1.3, 2)
            bar, hole = rectangle(x, y), rectangle(x + play, y + play)
        case 1:
            lean, x = rng.uniform(0.3, 0.6), rng.uniform(0.6, 1.0)
            bar = np.array([[x - lean, 0.5], [-x + lean, 0.5], [-x, -0.5], [x, -0.5]])
            hole = bar * (1 + play)
        case 2:
            n, flat = _count(rng), rng.uniform(0.5, 0.85)
            bar = flattened(1.0, flat, n, rng.uniform(0, 6))
            hole = flattened(1.0 + play, flat + play, _count(rng), rng.uniform(0, 6))
        case _:
            teeth, inner = int(rng.integers(4, 16)), rng.uniform(0.75, 0.9)
            bar = splined(inner, 1.0, teeth)
            hole = splined(inner + play, 1.0 + play, teeth, min(play, 0.1 / teeth))
    rod = solid(bar, -rng.uniform(0.5, 3), length + rng.uniform(0.5, 3), rng)
    block = sleeve(outer, hole, 0.0, length, rng)
    return _placed(rng, "prismatic", {"bar": rod}, {"block": block}, play)


def screw(rng: np.random.Generator) -> Drawn:
    """A bolt in its nut, with a thread that winds either way."""
    pitch, depth = rng.uniform(0.2, 0.5), rng.uniform(0.4, 0.6)
    play = rng.uniform(0.002, 0.015)
    crest = rng.uniform(0.05, 0.2)
    half = depth * pitch
    shape = np.array([[1 - half, 0.0], [1 - half, crest], [1.0, 0.5], [1.0, 0.5 + crest]])
    shape[:, 1] *= pitch
    count, turns = int(rng.integers(16, 48)), rng.uniform(3, 8)
    bolt = thread(shape, pitch, turns + 2, count, True, -2 * np.pi)
    nut = thread(shape + np.array([play, 0.0]), pitch, turns, int(rng.integers(16, 48)), False)
    if rng.integers(2):
        bolt, nut = ((points * [1, -1, 1], faces[:, ::-1].copy()) for points, faces in (bolt, nut))
        pitch = -pitch
    return _placed(rng, "screw", {"bolt": bolt}, {"nut": nut}, play, pitch)


def seat(rng: np.random.Generator) -> Drawn:
    """A hub on a D-shaft or splined shaft between two collars."""
    play = rng.uniform(0.0, 0.01)
    length = rng.uniform(0.6, 3.0)
    if rng.integers(2):
        flat = rng.uniform(0.5, 0.85)
        bar = flattened(1.0, flat, _count(rng), rng.uniform(0, 6))
        hole = flattened(1 + play, flat + play, _count(rng), rng.uniform(0, 6))
    else:
        teeth, inner = int(rng.integers(4, 16)), rng.uniform(0.75, 0.9)
        bar = splined(inner, 1.0, teeth)
        hole = splined(inner + play, 1 + play, teeth, min(play, 0.1 / teeth))
    hub = sleeve(_around(rng, 1.5), hole, 0.0, length, rng)
    gap = play / 2
    wide = circle(rng.uniform(1.3, 1.8), _count(rng))
    rod = solid(bar, -1.0, length + 1.0, rng)
    one = sleeve(wide, bar, -0.5, -gap, rng)
    other = sleeve(wide, bar, length + gap, length + 0.5, rng)
    return _placed(rng, "fixed", {"hub": hub}, {"shaft": rod, "collar": one, "circlip": other}, play)


def nothing(rng: np.random.Generator) -> Drawn:
    """A ball in its socket, a block on a table, or parts apart."""
    n = int(rng.integers(8, 32)) * 2
    match int(rng.integers(3)):
        case 0:
            child = ball(1.0, n, True)
            parent = ball(1.0 + rng.uniform(0, 0.02), int(rng.integers(8, 32)) * 2, False, -1.4, 0.6)
        case 1:
            child = solid(rectangle(*rng.uniform(0.5, 1.5, 2)), 0.0, 1.0, rng)
            parent = solid(rectangle(3.0, 3.0), -1.0, 0.0, rng)
        case _:
            child = solid(circle(1.0, n), 0.0, 1.0, rng)
            parent = solid(circle(1.0, n), -3.0, -1.5, rng)
    return _placed(rng, "error", {"one": child}, {"other": parent}, 0.0)


KINDS: dict[str, Callable[[np.random.Generator], Drawn]] = {
    each.__name__: each for each in (shaft, hinge, door, piston, taper, slide, screw, seat, nothing)
}


def drawn(kind: str, seed: int) -> Drawn:
    return KINDS[kind](np.random.default_rng([seed, *kind.encode()]))


def _placed(
    rng: np.random.Generator,
    kind: str,
    child: dict[str, Mesh],
    parent: dict[str, Mesh],
    play: float,
    pitch: float = 0.0,
) -> Drawn:
    """At a random size and place; the child off its middle by some of the play."""
    size = float(np.exp(rng.uniform(np.log(5e-4), np.log(0.5))))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = rng.uniform(-1, 1, 3) * min(1.0, 200 * size)
    off = 0.4 * play * np.array([*rng.normal(size=2) / 2, 0.0]) if kind in ("revolute", "cylindrical") else np.zeros(3)

    def moved(mesh: Mesh, by: Floats) -> Mesh:
        points = (mesh[0] + by) @ turn.T * size + shift
        return points.astype(np.float32).astype(np.float64) if rounded else points, mesh[1]

    rounded = bool(rng.integers(2)) and size > 2e-3
    return Drawn(
        kind,
        {k: moved(m, off) for k, m in child.items()},
        {k: moved(m, np.zeros(3)) for k, m in parent.items()},
        turn[:, 2],
        shift,
        (play + 0.005) * size,
        pitch * size,
    )
