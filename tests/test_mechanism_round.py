"""Surfaces of revolution about the axis of a joint turn in each other, however they are cut into facets."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, joined

import feeler
from feeler import Joint, Mechanism

Floats = npt.NDArray[np.float64]
Line = Sequence[tuple[float, float]]
KINDS = ["cone", "chamfer", "countersink", "ball", "ball at an angle", "bead", "fillet", "collar", "tubes", "groove"]
FREE = (-math.tau, math.tau)


def lathe(outline: Line, sides: int, turned: float) -> Mesh:
    """A closed outline of radius and height, turned about z."""
    circle = turned + np.arange(sides) * math.tau / sides
    points = np.array([(r * math.cos(a), r * math.sin(a), z) for r, z in outline for a in circle])
    here = np.arange(sides)
    there = (here + 1) % sides
    faces: list[tuple[int, int, int]] = []
    for level, (r, _) in enumerate(outline):
        k, n = sides * level, sides * ((level + 1) % len(outline))
        last = outline[(level + 1) % len(outline)][0]
        for i, j in zip(here.tolist(), there.tolist(), strict=True):
            faces += [(k + i, k + j, n + j)] if r > 0.0 else []
            faces += [(k + i, n + j, n + i)] if last > 0.0 else []
    poles, where = np.unique(points, axis=0, return_inverse=True)
    found = where.ravel()[np.array(faces)]
    corners = poles[found]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return poles, found if volume > 0.0 else found[:, ::-1].copy()


def arc(radius: float, begin: float, end: float, pieces: int, middle: tuple[float, float] = (0.0, 0.0)) -> Line:
    """Points on a circle in the half-plane; those on the axis exactly."""
    angles = np.linspace(begin, end, pieces + 1)
    points = np.column_stack([middle[0] + radius * np.cos(angles), middle[1] + radius * np.sin(angles)])
    points[np.abs(points[:, 0]) < 1e-12, 0] = 0.0
    return [(float(r), float(z)) for r, z in points]


def rotation(rng: np.random.Generator) -> Floats:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(turn * np.linalg.det(turn))


def lines_of(kind: str, rng: np.random.Generator) -> tuple[Line, Line]:
    """The outlines of a part and of the one that it lies in, about 1 m."""
    quarter = math.pi / 2
    if kind == "cone":
        lean = rng.uniform(0.02, 0.9)
        low, high = 1.0 - lean / 2, 1.0 + lean / 2
        return [(0, -1), (low, -1), (high, 1), (0, 1)], [(2, -1), (2, 1), (high, 1), (low, -1)]
    if kind == "chamfer":
        by = rng.uniform(0.05, 0.3)
        seat = [(1 - by, -1.0), (1.0, by - 1)]
        return [(0, -1), *seat, (1, 1.5), (0, 1.5)], [(0, -1.5), (2, -1.5), (2, 1), (1, 1), *seat[::-1], (0, -1)]
    if kind == "countersink":
        return [(0, -1), (0.5, -1), (0.5, 0), (1, 0.5), (0, 0.5)], [(2, -1), (2, 0.5), (1, 0.5), (0.5, 0), (0.5, -1)]
    if kind.startswith("ball"):
        socket = arc(1.0, -quarter, rng.uniform(-0.2, 0.9), int(rng.integers(6, 20)))
        ball = arc(1.0, -quarter, quarter, int(rng.integers(6, 20)))
        return ball, [*socket[::-1], (0.0, -1.6), (1.8, -1.6), (1.8, socket[-1][1])]
    if kind == "bead":
        bead, groove = (arc(0.3, -quarter, quarter, int(rng.integers(4, 12)), (1.0, 0.0)) for _ in "ab")
        return [(0, -1), (1, -1), *bead, (1, 1), (0, 1)], [(1, -1), (2, -1), (2, 1), (1, 1), *groove[::-1]]
    if kind == "fillet":
        round_ = arc(0.3, math.pi, 1.5 * math.pi, 5, (1.3, 0.3))
        return [(0, 2), (1, 2), *round_, (1.8, 0), (1.8, -0.5), (0, -0.5)], [(2.2, 0), (2.2, 1.5), (1, 1.5), *round_]
    if kind == "collar":  # lower than the facets are high
        high = rng.uniform(0.001, 0.01)
        step = [(1.0, -0.2), (1 + high, -0.2), (1 + high, 0.2), (1.0, 0.2)]
        return [(0, -1.5), (1, -1.5), *step, (1, 1.5), (0, 1.5)], [(2, -1), (2, 1), (1, 1), *step[::-1], (1, -1)]
    if kind == "tubes":  # their walls are thinner than what a part may be pressed in
        wall = rng.uniform(0.02, 0.05)
        return [(1 - wall, -1), (1, -1), (1, 1), (1 - wall, 1)], [(1 + wall, -1), (1 + wall, 1), (1, 1), (1, -1)]
    assert kind == "groove"
    cut = [(1.4, 1), (1.4, -1), (1, -1), (1, 1)]
    return [(1, -1), (1.4, -1), (1.4, 1.5), (1, 1.5)], [(0, -1.5), (2, -1.5), (2, 1), *cut, (0, 1)]


def pair_of(kind: str, rng: np.random.Generator) -> tuple[Mesh, Mesh]:
    """Two parts of their own facets."""
    sides = rng.integers(12, 97, 2) if rng.random() < 0.6 else np.repeat(rng.integers(12, 97), 2)
    mine, its = (
        lathe(line, int(n), rng.uniform()) for line, n in zip(lines_of(kind, rng), sides.tolist(), strict=True)
    )
    return ((mine[0] @ rotation(rng).T, mine[1]) if kind == "ball at an angle" else mine), its


def turning(mine: Mesh, its: Mesh, rng: np.random.Generator, kind: str = "revolute") -> tuple[Mechanism, bool]:
    """A joint between two parts about z, at any size and place; either moves. Whether the first does."""
    turn, size, place = rotation(rng), 10.0 ** rng.uniform(-3.0, 0.0), rng.uniform(-3.0, 3.0, 3)
    mock = feeler.Mockup(
        {name: (size * mesh[0] @ turn.T + place, mesh[1]) for name, mesh in (("mine", mine), ("its", its))}
    )
    is_first = bool(rng.random() < 0.5)
    child, parent = ("mine", "its") if is_first else ("its", "mine")
    return Mechanism(mock, [Joint("j", kind, parent, child, turn[:, 2], place)]), is_first  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_parts_that_are_turned_about_the_axis_turn_in_each_other(kind: str, seed: int) -> None:
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    found = turning(*pair_of(kind, rng), rng)[0].range("j")
    assert (found.lower, found.upper, found.above) == (*FREE, None)
    assert [seat.kind for seat in found.seats] == ["round"]


@pytest.mark.parametrize("kind", KINDS)
def test_an_arm_on_them_stops_at_a_post(kind: str) -> None:
    rng = np.random.default_rng([7, KINDS.index(kind)])
    mine, its = pair_of(kind, rng)
    angle = rng.uniform(0.5, 3.0)
    post, faces = box((1.3, -0.1, 2.2), (1.6, 0.0, 3.0))
    c, s = math.cos(angle), math.sin(angle)
    post = post @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    moved, is_first = turning(
        joined(mine, box((0.0, -0.05, 2.5), (1.5, 0.05, 2.7))), joined(its, (post, np.asarray(faces))), rng
    )
    # The corner of the arm meets the face of the post, or the face of the arm the corner of the post.
    upper = min(
        angle - math.asin(0.1 / math.hypot(1.5, 0.05)) - math.atan(0.05 / 1.5),
        angle - math.atan(0.1 / 1.3) - math.asin(0.05 / math.hypot(1.3, 0.1)),
    )
    lower = angle - math.tau + math.asin(0.05 / 1.3)
    want = (lower, upper) if is_first else (-upper, -lower)
    found = moved.range("j")
    assert (found.lower, found.upper) == pytest.approx(want, abs=1e-6)
    assert want[0] <= found.lower and found.upper <= want[1]


@pytest.mark.parametrize("kind", ["cone", "ball"])
@pytest.mark.parametrize("how", ["oval", "beside the axis"])
def test_what_is_not_round_about_the_axis_jams(kind: str, how: str) -> None:
    rng = np.random.default_rng(3)
    line, around = lines_of(kind, rng)
    mine, its = lathe(line, 90, 0.0), lathe(around, 90, 0.0)
    for vertices, _ in (mine, its):
        vertices[:, 0] = 1.02 * vertices[:, 0] if how == "oval" else vertices[:, 0] + 0.02
    found = turning(mine, its, rng)[0].range("j")
    assert -0.1 < found.lower <= found.upper < 0.1


def test_a_cone_does_not_slide_through_its_seat() -> None:
    rng = np.random.default_rng(2)
    line, around = lines_of("countersink", rng)
    mock = feeler.Mockup({"mine": lathe(line, 40, 0.0), "its": lathe(around, 40, 0.0)})
    moved = Mechanism(mock, [Joint("j", "cylindrical", "its", "mine")])
    found = moved.range("j.slide")
    assert -1e-5 < found.lower <= 0.0 and found.upper > 1.0


@pytest.mark.parametrize("kind", ["cone", "ball"])
def test_parts_in_each_other_that_a_third_carries_turn_about_their_axis(kind: str) -> None:
    rng = np.random.default_rng(5)
    mine, its = pair_of(kind, rng)
    mock = feeler.Mockup({"mine": mine, "its": its, "post": box((9, 9, 9), (10, 10, 10))})
    joints = [Joint("one", "revolute", None, "mine"), Joint("other", "revolute", None, "its", point=(0, 0, 3))]
    found = Mechanism(mock, joints).range("one", {"other": 0.3})
    assert (found.lower, found.upper) == FREE
    assert [seat.kind for seat in found.seats] == ["round"]


def lugged(lugs: tuple[float, float], inner: float, outer: float, sides: int, around: float = 0.0) -> Mesh:
    """A prism whose radius is `outer` between two bearings, `inner` elsewhere; `around`: a plate with that hole."""
    begin, end = lugs
    wide = np.linspace(begin, end, max(3, int(sides * (end - begin) / math.tau)))
    rest = np.linspace(end, begin + math.tau, max(3, int(sides * (math.tau - end + begin) / math.tau)))
    bearing = np.concatenate([wide, rest])
    radius = np.concatenate([np.full(len(wide), outer), np.full(len(rest), inner)])
    line = np.column_stack([radius * np.cos(bearing), radius * np.sin(bearing)])
    edge = around * np.column_stack([np.cos(bearing), np.sin(bearing)])
    levels = [np.column_stack([each, np.full(len(line), z)]) for z in (0.0, 1.0) for each in (line, edge)]
    n = len(line)
    i = np.arange(n)
    j = (i + 1) % n
    faces = [
        np.column_stack(each)
        for a, b in ((0, 2 * n), (2 * n, 3 * n), (3 * n, n), (n, 0))
        for each in ((a + i, a + j, b + j), (a + i, b + j, b + i))
    ]
    points, where = np.unique(np.concatenate(levels), axis=0, return_inverse=True)
    found = where.ravel()[np.concatenate(faces)]
    one, two, three = (points[found[:, k]] for k in range(3))
    found = found[np.linalg.norm(np.cross(two - one, three - one), axis=1) > 1e-12]
    corners = points[found]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return points, found if volume > 0.0 else found[:, ::-1].copy()


@pytest.mark.parametrize("seed", range(4))
def test_lugs_between_round_surfaces_stop_each_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mine = lugged((0.0, 2.0), 1.0, 1.2, int(rng.integers(24, 96)))
    its = lugged((-0.783, 2.5), 1.0, 1.2, int(rng.integers(24, 96)), 2.0)
    moved, is_first = turning(mine, its, rng)
    want = (-0.783, 0.5) if is_first else (-0.5, 0.783)
    found = moved.range("j")
    assert (found.lower, found.upper) == pytest.approx(want, abs=1e-6)
    assert want[0] <= found.lower and found.upper <= want[1]


@pytest.mark.parametrize("seed", range(2))
def test_thin_tubes_in_each_other_are_a_fit_of_the_walls_between_them_alone(seed: int) -> None:
    """The inside of the one is nearly as wide as the outside of the other."""
    rng = np.random.default_rng(seed)
    mine, its = (lathe(line, 24, rng.uniform()) for line in lines_of("tubes", rng))
    moved = turning(mine, its, rng, "cylindrical")[0]
    assert [seat.kind for seat in moved.clearance({"j.turn": (0.0, 0.1)}).seats] == ["round"]


@pytest.mark.parametrize("core", [0.76, 0.8, 0.85, 0.88])
@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "screw"])
def test_a_bolt_as_wide_as_its_thread_turns_in_a_hole_as_wide_as_its_core(kind: str, core: float) -> None:
    rng = np.random.default_rng([int(100 * core), len(kind)])
    bolt = [(0.0, -0.5), (1.0, -0.5), (1.0, 3.5), (1.7, 3.5), (1.7, 4.3), (0.0, 4.3)]
    plate = [(core, 0.0), (3.0, 0.0), (3.0, 3.0), (core, 3.0)]
    sides = rng.integers(20, 64, 2).tolist()
    mine, its = (lathe(line, count, rng.uniform()) for line, count in zip((bolt, plate), sides, strict=True))
    turn, size, place = rotation(rng), 10.0 ** rng.uniform(-3.0, 0.0), rng.uniform(-3.0, 3.0, 3)
    parts = {"bolt": (size * mine[0] @ turn.T + place, mine[1]), "plate": (size * its[0] @ turn.T + place, its[1])}
    pitch = {"pitch": 0.2 * size} if kind == "screw" else {}
    joint = Joint("j", kind, "plate", "bolt", turn[:, 2], place, **pitch)  # type: ignore[arg-type]
    moved = Mechanism(feeler.Mockup(parts), [joint])
    found = moved.range("j.turn" if kind == "cylindrical" else "j")
    # The head meets the plate only after 2.5 turns; a range that is free for a whole turn is reported as one turn.
    assert (found.lower, found.upper) == pytest.approx(FREE) and [seat.kind for seat in found.seats] == ["round"]


def test_a_deep_ring_of_lugs_is_no_thread() -> None:
    """They stop each other where they do not go all around: a key of 15 % in a shaft."""
    rng = np.random.default_rng(3)
    mine, its = lugged((0.0, 2.0), 1.0, 1.15, 48), lugged((-0.783, 2.5), 1.0, 1.15, 60, 2.0)
    moved, is_first = turning(mine, its, rng)
    found = moved.range("j")
    assert (found.lower, found.upper) == pytest.approx((-0.783, 0.5) if is_first else (-0.5, 0.783), abs=1e-6)
