"""Rays and sections in Python: against an oracle in exact rational arithmetic, and what is refused."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracle import queried

import feeler

Vector = list[Fraction]
HalfSpace = tuple[Vector, Fraction]
Floats = npt.NDArray[np.float64]

LATTICE = st.integers(-2, 2).map(float)
NUMBER = st.one_of(LATTICE, st.floats(-2, 2), st.sampled_from([0.1, 0.3, 1e-30, -1e30, 0.1 + 0.2]))
NOTHING = np.empty((0, 4))
POINT = st.tuples(NUMBER, NUMBER, NUMBER)


def exact(v: npt.ArrayLike) -> Vector:
    return [Fraction(float(x)) for x in np.asarray(v)]


def sub(p: Vector, q: Vector) -> Vector:
    return [a - b for a, b in zip(p, q, strict=True)]


def dot(p: Vector, q: Vector) -> Fraction:
    return sum((a * b for a, b in zip(p, q, strict=True)), Fraction(0))


def cross(p: Vector, q: Vector) -> Vector:
    return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]


def met(
    origin: Vector, direction: Vector, corners: list[Vector], kept: list[tuple[Vector, Fraction]]
) -> Fraction | None:
    """The first place along the ray on the closed triangle, by cutting the line with half spaces."""
    normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))
    # Each: n . x >= d. The plane from both sides, the three borders in it, and the sections.
    spaces = [(normal, dot(normal, corners[0])), ([-x for x in normal], -dot(normal, corners[0]))]
    for i in range(3):
        inwards = cross(normal, sub(corners[(i + 1) % 3], corners[i]))
        spaces.append((inwards, dot(inwards, corners[i])))
    first, last = Fraction(0), None
    for n, d in [*spaces, *kept]:
        rate, needed = dot(n, direction), d - dot(n, origin)
        if rate == 0:
            if needed > 0:
                return None
        elif rate > 0:
            first = max(first, needed / rate)
        else:
            last = needed / rate if last is None else min(last, needed / rate)
    return first if last is None or first <= last else None


def expected(
    mockup: Any, origin: npt.ArrayLike, direction: npt.ArrayLike, sections: npt.ArrayLike
) -> tuple[int, float]:
    """Triangle and distance; -1 and infinity where nothing is met."""
    ids, triangles = queried(mockup)
    start, way = exact(origin), exact(direction)
    kept = [(exact(row[:3]), Fraction(float(row[3]))) for row in np.asarray(sections)]
    places = {
        int(t): met(start, way, [exact(p) for p in corners], kept) for t, corners in zip(ids, triangles, strict=True)
    }
    found = sorted((place, t) for t, place in places.items() if place is not None)
    if not found:
        return -1, math.inf
    place, triangle = found[0]
    return triangle, float(place) * math.hypot(*np.asarray(direction, dtype=float))


def check(scenes: list[feeler.Scene], origin: Any, direction: Any, sections: Any = NOTHING) -> None:
    triangle, distance = expected(scenes[0].mockup, origin, direction, sections)
    for scene in scenes:
        rays = scene.rays([origin], [direction], sections=sections)
        assert rays.triangles.tolist() == [triangle]
        np.testing.assert_allclose(rays.distances, [distance], rtol=1e-11)


def scenes_of(corners: Floats) -> list[feeler.Scene]:
    mockup = feeler.Mockup(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))
    size = float(np.ptp(mockup.bounds, axis=0).max()) / 5
    return [feeler.Scene(mockup), *(feeler.Scene(mockup, size, storage) for storage in ("dense", "hashed"))]


@given(st.lists(st.tuples(POINT, POINT, POINT), min_size=1, max_size=6), POINT, POINT, st.lists(POINT, max_size=2))
def test_what_is_met_first_is_exact(triangles: Any, origin: Any, direction: Any, normals: Any) -> None:
    corners = np.array(triangles, dtype=float)
    if not len(queried((corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3)))[0]):
        return
    if max(map(abs, direction)) == 0:
        return
    sections = [(*normal, 0.25 * i) for i, normal in enumerate(normals) if any(normal)]
    check(scenes_of(corners), origin, direction, np.array(sections).reshape(-1, 4))


@given(st.lists(st.tuples(*[st.tuples(LATTICE, LATTICE, LATTICE)] * 3), min_size=1, max_size=8), st.data())
def test_rays_on_a_lattice(triangles: Any, data: st.DataObject) -> None:
    corners = np.array(triangles, dtype=float)
    if not len(queried((corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3)))[0]):
        return
    scenes = scenes_of(corners)
    lattice = st.tuples(LATTICE, LATTICE, LATTICE)
    for _ in range(5):
        origin, direction, normal = (data.draw(lattice) for _ in range(3))
        if any(direction):
            check(scenes, origin, direction)
            if any(normal):
                check(scenes, origin, direction, [[*normal, data.draw(LATTICE)]])


def plate() -> feeler.Scene:
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    return feeler.Scene(feeler.Mockup(corners, [[0, 1, 2], [0, 2, 3]], [0, 1], ["right", "left"]))


def test_results_have_a_row_a_ray() -> None:
    rays = plate().rays([[0.5, 0, 3], [-0.5, 0, -2], [5, 0, 3]], [[0, 0, -9], [0, 0, 1], [0, 0, -1]])
    assert len(rays) == 3 and repr(rays) == "Rays(3 rays, 2 hit)"
    assert rays.distances.tolist() == [3, 2, math.inf]
    assert rays.triangles.tolist() == [0, 1, -1] and rays.parts.tolist() == [0, 1, -1]
    np.testing.assert_array_equal(rays.points, [[0.5, 0, 0], [-0.5, 0, 0], [np.nan] * 3])
    np.testing.assert_array_equal(rays.normals, [[0, 0, 1], [0, 0, -1], [np.nan] * 3])


def test_parts_limits_and_sections() -> None:
    scene = plate()
    origins, directions = np.tile([0.5, 0.0, 3.0], (40, 1)), np.tile([0, 0, -1], (40, 1))
    assert scene.rays(origins, directions).parts.tolist() == [0] * 40
    assert scene.without("right").rays(origins, directions).parts.tolist() == [-1] * 40
    assert scene.rays(origins[:2], directions[:2], within=2.9).triangles.tolist() == [-1, -1]
    assert scene.rays(origins[:2], directions[:2], sections=[[1, 0, 0, 0.6]]).triangles.tolist() == [-1, -1]
    assert scene.rays(origins[:2], directions[:2], sections=[[1, 0, 0, 0.5]]).triangles.tolist() == [0, 0]


@pytest.mark.parametrize("nothing", [[], np.empty((0, 3))])
def test_no_rays_are_an_empty_answer(nothing: Any) -> None:
    rays = plate().rays(nothing, nothing, sections=[])
    assert len(rays) == 0 and rays.points.shape == (0, 3)


@pytest.mark.parametrize(
    ("arguments", "options", "says"),
    [
        (([[0, 0, 0]], [[0, 0, 0]]), {}, r"directions\[0\] is .*at least 1e-100"),
        (([[0, 0, 0]], [[0, math.nan, 0]]), {}, r"directions\[0\]"),
        (([[0, 0, 0], [0, math.inf, 0]], [[0, 0, 1]] * 2), {}, r"origins\[1\] is .*finite"),
        (([0, 0, 0], [0, 0, 1]), {}, r"origins has shape \(3,\)"),
        (([["a", "b", "c"]], [[0, 0, 1]]), {}, "origins has dtype"),
        (([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]]), {}, "1 origins but 2 directions"),
        (([[0, 0, 0]], [[0, 0, 1]]), {"within": -1}, "within is -1"),
        (([[0, 0, 0]], [[0, 0, 1]]), {"within": "far"}, "within is 'far'"),
        (([[0, 0, 0]], [[0, 0, 1]]), {"sections": [[0, 0, 1]]}, r"sections has shape \(1, 3\)"),
        (([[0, 0, 0]], [[0, 0, 1]]), {"sections": [[0, 0, 0, 1]]}, r"sections\[0\] is .*not zero"),
    ],
)
def test_what_is_no_ray_is_refused(arguments: Any, options: Any, says: str) -> None:
    with pytest.raises(feeler.OptionError, match=says):
        plate().rays(*arguments, **options)


@given(st.lists(st.tuples(POINT, POINT, POINT), min_size=1, max_size=6), POINT, POINT)
def test_what_is_cut_is_exact(triangles: Any, point: Any, normal: Any) -> None:
    corners = np.array(triangles, dtype=float)
    mesh = (corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))
    ids, counted = queried(mesh)
    if not len(ids) or not any(normal):
        return
    n, q = exact(normal), exact(point)
    in_front = [[dot(n, sub(exact(p), q)) > 0 for p in t] for t in counted]
    # A corner on the plane whose neighbours are in front of it is a point, and no segment.
    on = [[dot(n, sub(exact(p), q)) == 0 for p in t] for t in counted]
    cut = [any(f) and not all(f) and not (sum(f) == 2 and any(o)) for f, o in zip(in_front, on, strict=True)]
    outline = feeler.Scene(feeler.Mockup(*mesh)).section(point, normal)
    # Ends that float64 does not tell apart are no segment either.
    assert set(outline.triangles.tolist()) <= set(ids[cut].tolist())
    for t in set(ids[cut].tolist()) - set(outline.triangles.tolist()):
        heights = [float(dot(n, sub(exact(p), q))) for p in corners[t]]
        assert min(map(abs, heights)) <= 1e-12 * max(map(abs, heights))


def test_an_outline_has_a_row_a_triangle() -> None:
    scene = plate()
    outline = scene.section([0.5, 7, 7], [2, 0, 0])
    assert len(outline) == 2 and repr(outline) == "SectionOutline(2 segments)"
    assert outline.triangles.tolist() == [0, 1] and outline.parts.tolist() == [0, 1]
    np.testing.assert_array_equal(outline.segments[0], [[0.5, 0.5, 0], [0.5, -1, 0]])
    assert scene.without("left").section([0.5, 7, 7], [2, 0, 0]).triangles.tolist() == [0]
    assert not outline.segments.flags.writeable
    assert scene.section([0, 0, 0], [0, 0, 1]).segments.shape == (0, 2, 3)


@pytest.mark.parametrize(
    ("point", "normal", "says"),
    [
        ([0, 0, 0], [0, 0, 0], "normal is .*not zero"),
        ([0, 0, math.nan], [0, 0, 1], "point is "),
        ([0, 0], [0, 0, 1], r"point is \[0, 0\]: three numbers"),
        ([0, 0, 0], 1.0, "normal is 1.0: three numbers"),
        ([0, 0, 0], [0, "x", 1], "normal is 'x': give a number"),
    ],
)
def test_what_is_no_plane_is_refused(point: Any, normal: Any, says: str) -> None:
    with pytest.raises(feeler.OptionError, match=says):
        plate().section(point, normal)
