"""Parts that are pressed into each other along a slide go on until something stops them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from joint_shapes import Loop, circle, levels, rectangle, solid, walls
from shapes import Mesh, joined

import feeler
from feeler import Joint, Mechanism

Floats = npt.NDArray[np.float64]
KINDS = ["keyed", "joined", "dovetail", "spline", "bar"]


def keyed(radius: float, half: float, depth: float, count: int, phase: float) -> Loop:
    """A circle with a slot at x = radius, as deep, or a key, as high, of so much half width."""
    loop = circle(radius, count, phase)
    at = np.arctan2(loop[:, 1], loop[:, 0])
    edge = math.asin(half / radius)
    rest = loop[np.abs(at) > edge + 1e-9]
    rest = rest[np.argsort(np.arctan2(rest[:, 1], rest[:, 0]) % math.tau)]
    x = radius * math.cos(edge)
    return np.array([(x, half), *rest, (x, -half), (radius + depth, -half), (radius + depth, half)])


def splined(inner: float, outer: float, teeth: int, grown: float) -> Loop:
    """A shaft with teeth, all of its surfaces moved out by so much."""
    points = []
    for k in range(teeth):
        for share, radius in ((-0.27, inner), (-0.22, outer), (0.22, outer), (0.27, inner), (0.5, inner)):
            at = (k + share) * math.tau / teeth + grown / radius * (0.0 if share == 0.5 else math.copysign(1.0, share))
            points.append([(radius + grown) * math.cos(at), (radius + grown) * math.sin(at)])
    return np.array(points)


def area(one: Floats, two: Floats, three: Floats) -> Floats:
    """Twice those of triangles, negative where they run clockwise."""
    (x, y), off = two - one, three - one
    return np.asarray(x * off[..., 1] - y * off[..., 0])


def filled(points: Floats, left: list[int]) -> npt.NDArray[np.int64]:
    """The triangles of a polygon that runs counter-clockwise, without its ears one after the other."""
    found, at, tried = [], 0, 0
    while len(left) > 3:
        assert tried <= len(left)
        at %= len(left)
        one, two, three = left[at - 1], left[at], left[(at + 1) % len(left)]
        a, b, c = points[one], points[two], points[three]
        rest = points[[k for k in left if k not in (one, two, three)]]
        sides = [area(p, q, rest) >= 0.0 for p, q in ((a, b), (b, c), (c, a))]
        if area(a, b, c) > 1e-18 and not np.logical_and.reduce(sides).any():
            found.append([one, two, three])
            left.pop(at)
            tried = 0
        tried, at = tried + 1, at + 1
    return np.array([*found, left])


def plug(loops: list[Loop], heights: list[float], rng: np.random.Generator) -> Mesh:
    """Prisms on each other, of as many corners each."""
    pieces, count = [], len(loops[0])
    corner = np.arange(count)
    for k, loop in enumerate(loops):
        pieces.append(walls(loop, levels(heights[k], heights[k + 1], rng), True, rng))
        if k:
            points = np.concatenate(
                [np.column_stack([each, np.full(count, heights[k])]) for each in loops[k - 1 : k + 1]]
            )
            i, j = corner, (corner + 1) % count
            pieces.append(
                (
                    points,
                    np.concatenate([np.column_stack([i, j, j + count]), np.column_stack([i, j + count, i + count])]),
                )
            )
    for loop, height, is_up in ((loops[0], heights[0], False), (loops[-1], heights[-1], True)):
        faces = filled(loop, list(range(count)))
        pieces.append((np.column_stack([loop, np.full(count, height)]), faces if is_up else faces[:, ::-1]))
    return joined(*pieces)


def hub(outer: Loop, holes: list[Loop], heights: list[float], rng: np.random.Generator) -> Mesh:
    """A prism with holes of as many corners each behind each other."""
    pieces, count, n = [walls(outer, np.array([heights[0], heights[-1]]), True, rng)], len(holes[0]), len(outer)
    i, j = np.arange(count), (np.arange(count) + 1) % count
    for k, hole in enumerate(holes):
        pieces.append(walls(hole, levels(heights[k], heights[k + 1], rng), False, rng))
        if k:
            points = np.concatenate(
                [np.column_stack([each, np.full(count, heights[k])]) for each in holes[k - 1 : k + 1]]
            )
            pieces.append(
                (
                    points,
                    np.concatenate([np.column_stack([i, j + count, j]), np.column_stack([i, i + count, j + count])]),
                )
            )
    for hole, height, is_up in ((holes[0], heights[0], False), (holes[-1], heights[-1], True)):
        points = np.concatenate([outer, hole])
        start, end = np.unravel_index(np.argmin(np.linalg.norm(outer[:, None] - hole, axis=2)), (n, count))
        left = [int(start + k) % n for k in range(n + 1)] + [n + int(end - k) % count for k in range(count + 1)]
        faces = filled(points, left)
        pieces.append((np.column_stack([points, np.full(len(points), height)]), faces if is_up else faces[:, ::-1]))
    return joined(*pieces)


def counted(rng: np.random.Generator) -> int:
    return int(np.exp(rng.uniform(math.log(16), math.log(200))))


def sections(kind: str, size: float, press: float, rng: np.random.Generator) -> tuple[dict[str, Loop], Loop]:
    """A bar, or a shaft with its key, and the hole that it is pressed into."""
    one, two = (rng.uniform(0, 6) for _ in "ab")
    if kind in ("keyed", "joined"):
        half, high = size * rng.uniform(0.12, 0.3), size * rng.uniform(0.1, 0.25)
        play = rng.choice([0.0, rng.uniform(0.0, 5e-5)])
        hole = keyed(size + play, half, 1.05 * high + press, counted(rng), two)
        if kind == "joined":
            return {"shaft": keyed(size, half + press, high, counted(rng), one)}, hole
        x, y = np.array([size - high, size + high]), half + press
        key = np.array([[x[0], -y], [x[1], -y], [x[1], y], [x[0], y]])
        return {"shaft": keyed(size, half, -high, counted(rng), one), "key": key}, hole
    if kind == "dovetail":
        lean, x = rng.uniform(0.3, 0.6), rng.uniform(0.7, 1.0)
        bar = size * np.array([[x - lean, 0.5], [-x + lean, 0.5], [-x, -0.5], [x, -0.5]])
        return {"bar": bar}, bar * (1.0 - press / size)
    if kind == "spline":
        teeth, inner = int(rng.integers(6, 24)), size * rng.uniform(0.75, 0.9)
        return {"bar": splined(inner, size, teeth, 0.0)}, splined(inner, size, teeth, -press)
    x, y = size * rng.uniform(0.3, 1.0, 2)
    return {"bar": rectangle(x, y)}, rectangle(x - press, y - rng.choice([0.0, press]))


def placed(child: dict[str, Mesh], parent: Mesh, rng: np.random.Generator) -> tuple[Mechanism, bool, float]:
    """A slide at any place; either side moves. Whether the child does, and how far a slide is followed."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn, place = turn * np.linalg.det(turn), rng.uniform(-1.0, 1.0, 3)
    parts = {**{f"child/{name}": mesh for name, mesh in child.items()}, "parent/hub": parent}
    mock = feeler.Mockup({name: (points @ turn.T + place, faces) for name, (points, faces) in parts.items()})
    is_first = bool(rng.random() < 0.5)
    one, other = ("child*", "parent*") if is_first else ("parent*", "child*")
    bounds = mock.part_bounds.reshape(-1, 2, 3)
    far = 2.0 * float(np.linalg.norm(bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)))
    return Mechanism(mock, [Joint("slide", "prismatic", other, one, turn[:, 2], place)]), is_first, far


def check(moved: tuple[Mechanism, bool, float], lower: float, upper: float) -> None:
    """The range of a child, never late but for the play of what touches; seats rest 0.125 um before they stop."""
    mechanism, is_first, far = moved
    lower, upper = max(lower, -far), min(upper, far)
    want = (lower, upper) if is_first else (-upper, -lower)
    found = mechanism.range("slide")
    for early, end in ((found.lower - want[0], want[0]), (want[1] - found.upper, want[1])):
        assert (-1e-6 if end == 0.0 else -1e-9) <= early <= 1.3e-7


NARROW = [("joined", 13), ("keyed", 19), ("keyed", 29), ("joined", 71)]
"""Where facets beside a key are narrower than it is pressed in: moved in, they would cross."""


@pytest.mark.parametrize(("kind", "seed"), [*((kind, seed) for kind in KINDS for seed in range(6)), *NARROW])
def test_pressed_parts_slide_until_a_shoulder(kind: str, seed: int) -> None:
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    size, press = 10.0 ** rng.uniform(-2.4, -1.4), rng.choice([0.0, rng.uniform(0.0, 1e-4)], p=[0.15, 0.85])
    long = size * rng.uniform(0.6, 5.0)
    bars, hole = sections(kind, size, press, rng)
    outer = circle(size * rng.uniform(1.6, 3.0), counted(rng)) if rng.random() < 0.5 else rectangle(2 * size, 2 * size)
    has_shoulder = rng.random(2) < 0.5
    to = [0.0 if rng.random() < 0.2 else size * rng.uniform(0.01, 1.5) for _ in "ab"]
    ends = [-size * rng.uniform(0.3, 3.0), long + size * rng.uniform(0.3, 3.0)]
    if seed % 2:  # its end is inside, and goes on through all of the hole
        has_shoulder[:], ends[1] = False, long * rng.uniform(0.4, 0.95)
    ends = [-to[0] if has_shoulder[0] else ends[0], long + to[1] if has_shoulder[1] else ends[1]]
    child = {name: plug([loop], ends, rng) for name, loop in bars.items()}
    for k, (low, high) in enumerate(((ends[0] - size, ends[0]), (ends[1], ends[1] + size))):
        if has_shoulder[k]:
            child[f"shoulder_{k}"] = solid(circle(size * rng.uniform(1.3, 1.55), counted(rng)), low, high, rng)
    moved = placed(child, hub(outer, [hole], [0.0, long], rng), rng)
    check(moved, -to[1] if has_shoulder[1] else -math.inf, to[0] if has_shoulder[0] else math.inf)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("which", ["bar", "hole"])
@pytest.mark.parametrize("kind", ["bar", "spline", "joined"])
def test_a_low_step_stops_a_pressed_part(kind: str, which: str, seed: int) -> None:
    rng = np.random.default_rng([seed, len(which), KINDS.index(kind)])
    size, press, high = 10.0 ** rng.uniform(-2.4, -1.4), rng.uniform(0.0, 1e-4), 10.0 ** rng.uniform(-5.0, -3.5)
    bars, hole = sections(kind, size, press, rng)
    [(name, loop)] = bars.items()
    long, wider = size * rng.uniform(0.6, 5.0), 1.0 + 3.0 * high / size
    outer, to = circle(2.0 * size, counted(rng)), size * rng.uniform(0.01, 0.5)
    if which == "bar":
        child = plug([loop, loop * wider], [-size, long + to, long + 2.0 * size], rng)
        check(placed({name: child}, hub(outer, [hole], [0.0, long], rng), rng), -to, math.inf)
    else:
        child = plug([loop], [-size, long - to], rng)
        parent = hub(outer, [hole, hole / wider], [0.0, long, long + size], rng)
        check(placed({name: child}, parent, rng), -math.inf, to)


@pytest.mark.parametrize("seed", range(4))
def test_a_shoulder_that_is_pressed_on_goes_no_deeper(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size, press = 10.0 ** rng.uniform(-2.4, -1.4), rng.uniform(0.0, 1e-4)
    bars, hole = sections("bar", size, press, rng)
    child = {name: plug([loop], [-size, 2.0 * size], rng) for name, loop in bars.items()}
    child["shoulder"] = solid(circle(1.5 * size, 32), size - rng.uniform(1e-6, 6e-5), 2.0 * size, rng)
    mechanism, is_first, _ = placed(child, hub(circle(2.0 * size, 24), [hole], [0.0, size], rng), rng)
    found = mechanism.range("slide")
    assert (-found.lower if is_first else found.upper) < 1.2e-5
    assert (found.upper if is_first else -found.lower) > size


@pytest.mark.parametrize("seed", [3, 6, 8, 10])
def test_a_bolt_as_wide_as_its_thread_slides_in_a_hole_as_wide_as_its_core(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size, core, gap = 10.0 ** rng.uniform(-3.0, -1.8), rng.uniform(0.73, 0.86), rng.uniform(0.02, 1.0)
    sides, turned = counted(rng), rng.uniform(0, 6)
    bolt = plug(
        [circle(radius * size, sides, turned) for radius in (1.0, 1.7)],
        [-rng.uniform(0.1, 1.0) * size, (3.0 + gap) * size, (4.0 + gap) * size],
        rng,
    )
    plate = hub(rectangle(3.0 * size, 3.0 * size), [circle(core * size, counted(rng))], [0.0, 3.0 * size], rng)
    check(placed({"bolt": bolt}, plate, rng), -gap * size, math.inf)
