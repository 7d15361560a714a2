"""Polygons of many corners, hollow or with holes: their triangles cover them once, and large ones take no age."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from loading import notes, save, soup

from feeler.io import ears, load_mockup, polygons


def doubled(triangles: np.ndarray) -> np.ndarray:
    """Twice the area of each triangle (m, 3, 2), positive if it runs counter-clockwise."""
    (ax, ay), (bx, by), (cx, cy) = np.moveaxis(triangles, 1, 0).transpose(0, 2, 1)
    return (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)


def covered(points: np.ndarray, triangles: np.ndarray, rng: np.random.Generator) -> None:
    """Checks by sampling that triangles (m, 3) of a counter-clockwise polygon (k, 2) cover it, and nothing twice."""
    corners = points[triangles]
    (ax, ay), (bx, by), (cx, cy) = np.moveaxis(corners, 1, 0).transpose(0, 2, 1)
    areas = doubled(corners)
    x, y = points.T
    whole = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    assert areas.min() >= -1e-9 * whole and areas.sum() == pytest.approx(whole, rel=1e-9)
    samples = rng.uniform(points.min(axis=0), points.max(axis=0), (300, 2))
    for px, py in samples.tolist():
        crossed = (y > py) != (np.roll(y, -1) > py)
        height = np.where(crossed, np.roll(y, -1) - y, 1.0)
        ahead = crossed & (px < x + (py - y) * (np.roll(x, -1) - x) / height)
        inside = [
            (qx - ox) * (py - oy) - (px - ox) * (qy - oy) > 0
            for ox, oy, qx, qy in ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, ax, ay))
        ]
        assert np.logical_and.reduce(inside).sum() == ahead.sum() % 2


def star(count: int, rng: np.random.Generator) -> np.ndarray:
    angle = np.sort(rng.uniform(0, 2 * np.pi, count))
    return np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.2, 1.0, (count, 1))


def wheel(count: int, _: np.random.Generator) -> np.ndarray:
    angle = np.arange(count) * 2 * np.pi / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.where(np.arange(count) % 2, 1.0, 0.8)[:, None]


def spiral(count: int, _: np.random.Generator) -> np.ndarray:
    """A strip of ten turns."""
    angle = np.linspace(0, 20 * np.pi, count // 2)
    line = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    radius = (0.1 + angle / 70)[:, None]
    return np.concatenate([(radius + 0.05) * line, (radius * line)[::-1]])


def rack(count: int, _: np.random.Generator) -> np.ndarray:
    """Teeth on a bar: once they are cut, thousands of corners lie on one line."""
    teeth = count // 4
    tooth = np.array([[0.75, 1.0], [0.5, 3.0], [0.25, 3.0], [0.0, 1.0]])
    steps = np.stack([np.arange(teeth)[::-1], np.zeros(teeth)], axis=1)
    return np.concatenate([[[-1.0, 0.0], [teeth + 1.0, 0.0]], (tooth + steps[:, None]).reshape(-1, 2)])


SHAPES = {"star": star, "wheel": wheel, "spiral": spiral, "rack": rack}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("count", [8, 40, 200, 1200, 6000])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_hollow_polygons_are_covered_once(shape, count, turn, rng):
    count = max(count, 1200) if shape == "spiral" else count  # a coarser one crosses itself
    points = SHAPES[shape](count, rng) @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    triangles, is_covered = ears.cut_ears(points.tolist())
    assert is_covered and len(triangles) == len(points) - 2
    covered(points, np.array(triangles), rng)


@pytest.mark.parametrize("shape", SHAPES)
def test_each_corner_is_tried_a_few_times(shape, rng, monkeypatch):
    """So that the time of polygons of 6,000 corners is not that of 36 million tries."""
    tries = []
    plain = ears._Bends.first_in
    monkeypatch.setattr(ears._Bends, "first_in", lambda *given: tries.append(1) or plain(*given))
    points = SHAPES[shape](6000, rng)
    ears.cut_ears(points.tolist())
    assert len(tries) < 4 * len(points)


def test_corners_on_a_coarse_grid_are_cut_as_they_can_be(rng):
    """Many corners fall together or onto edges, and polygons cross themselves; the signed area always stays."""
    for count in (5, 7, 12, 40, 150):
        for _ in range(20):
            angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
            points = np.rint(np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.integers(2, 9, (count, 1)))
            x, y = points.T
            whole = (x * np.roll(y, -1) - np.roll(x, -1) * y).sum()
            if whole <= 0:
                continue
            assert doubled(points[np.array(ears.cut_ears(points.tolist())[0])]).sum() == whole


@pytest.mark.parametrize("holes", [3, 12, 30])
def test_a_plate_with_holes_is_covered_once(holes, rng):
    """Round holes in rows, each of 6 corners: a plate of thousands of corners."""
    outline = np.array([[0.0, 0.0], [holes, 0.0], [holes, holes], [0.0, holes]])
    rings = [outline]
    for column, row in itertools.product(range(holes), range(holes)):
        angle = np.arange(6) * np.pi / 3 + 0.1 * ((7 * column + row) % 5)
        rings.append(np.stack([column + 0.5 + 0.4 * np.cos(angle), row + 0.5 + 0.4 * np.sin(angle)], axis=1))
    starts = np.cumsum([0] + [len(ring) for ring in rings])
    flat = np.concatenate(rings)
    points = np.column_stack([flat, np.zeros(len(flat))])
    lists = [np.arange(a, b) for a, b in itertools.pairwise(starts)]
    ring = polygons.bridged(lists[0], lists[1:], points)
    made = polygons.triangulate(ring, np.array([len(ring)]), points)
    assert made.rough == 0
    triangles = points[made.faces][:, :, :2]
    whole = holes**2 * (1 - 0.16 * 3 * np.sin(np.pi / 3))
    areas = doubled(triangles) / 2
    assert areas.min() > 0 and areas.sum() == pytest.approx(whole)
    middles = triangles.mean(axis=1)  # the middle of a triangle is in no hole
    assert (np.linalg.norm(middles - np.floor(middles) - 0.5, axis=1) > 0.4 * np.cos(np.pi / 6)).all()


def test_a_polygon_that_crosses_itself_is_told(tmp_path):
    """A bow tie with a longer half, as an OBJ: its triangles cannot cover it."""
    text = "v 0 0 0\nv 3 3 0\nv 3 0 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n"
    assert "1 polygon crosses itself" in notes(load_mockup(save(tmp_path, "a.obj", text)))


def test_a_wheel_of_6000_corners_as_a_file(tmp_path, rng):
    points = wheel(6000, rng)
    text = "".join(f"v {x!r} 0 {y!r}\n" for x, y in points.tolist()) + "f " + " ".join(map(str, range(1, 6001)))
    mockup = load_mockup(save(tmp_path, "a.obj", text + "\n"), unit="m")
    a, b, c = np.moveaxis(soup(mockup), 1, 0)
    areas = np.cross(b - a, c - a)[:, 1] / 2
    assert (areas < 0).all()
    assert -areas.sum() == pytest.approx(3000 * 0.8 * np.sin(2 * np.pi / 6000))
    assert mockup.report.source.notes == ("1 polygon with more than three corners was cut into triangles",)
