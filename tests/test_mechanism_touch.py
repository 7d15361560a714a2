"""Ranges of joints from where parts touch: never late, and free the other way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapes import box

import feeler
from feeler import Joint, Mechanism

Vector = tuple[float, float, float]
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def mockup(**parts: list[tuple[Vector, Vector]]) -> feeler.Mockup:
    """Parts of boxes, from the lower corner to the upper."""
    made = [(number, box(*ends)) for number, boxes in enumerate(parts.values()) for ends in boxes]
    vertices = np.concatenate([mesh[0] for _, mesh in made])
    faces = np.concatenate([np.asarray(mesh[1]) + 8 * place for place, (_, mesh) in enumerate(made)])
    return feeler.Mockup(vertices, faces, np.repeat([number for number, _ in made], 12), list(parts))


def sled(wall: tuple[Vector, Vector], *more: tuple[Vector, Vector], limits: tuple[float, float] = (-1, 1)) -> Mechanism:
    """A sled of half a metre before a wall at 0.75 m."""
    mock = mockup(sled=[((0, 0, 0), (0.5, 0.5, 0.5))], wall=[wall, *more])
    return Mechanism(mock, [Joint("x", "prismatic", None, "sled", X, limits=limits)])


@pytest.mark.parametrize("wall", [((0.75, 0, 0), (1, 0.5, 0.5)), ((0.75, 0.2, 0.2), (1, 0.25, 0.25))])
@pytest.mark.parametrize("off", [0.0, -1e-12, -1e-9, 1e-12, 1e-9])
def test_a_sled_that_touches_a_wall_goes_no_further_and_back(wall: tuple[Vector, Vector], off: float) -> None:
    moved = sled(wall)
    found = moved.range("x", {"x": 0.25 + off})
    assert found.upper == 0.25 + off and found.lower == -1.0 and found.is_certified
    assert found.above is not None and found.above.other_path == "wall" and found.below is None
    again = moved.range("x", {"x": found.upper})
    assert (again.lower, again.upper) == (found.lower, found.upper)


def test_a_wall_that_is_crossed_by_more_than_rounding_blocks_both_ways() -> None:
    found = sled(((0.75, 0, 0), (1, 0.5, 0.5))).range("x", {"x": 0.2500001})
    assert found.lower == found.upper == 0.2500001


def test_a_sled_slides_on_a_floor_up_to_a_wall_of_the_same_part_and_not_beyond() -> None:
    """The floor is beside the sled as modelled, so it is no seat."""
    mock = mockup(
        sled=[((0, 0, 0), (0.5, 0.5, 0.5))],
        frame=[((-2, 1, -0.1), (2, 2, 0)), ((0.75, 1, -0.05), (1, 2, 0.5))],
        cart=[((9, 9, 9), (9.1, 9.1, 9.1))],
    )
    joints = [
        Joint("y", "prismatic", None, "cart", (0, 1, 0)),
        Joint("x", "prismatic", "cart", "sled", X, limits=(-1, 1)),
    ]
    moved = Mechanism(mock, joints)
    for start in (0.0, 0.1, 0.25):
        found = moved.range("x", {"y": 1.1, "x": start})
        assert 0.25 - 1e-7 <= found.upper <= 0.25 and found.lower == -1.0
    # It does not sink into the floor by the way to a limit either.
    down = Mechanism(mock, [joints[0], Joint("z", "prismatic", "cart", "sled", Z, limits=(-1e-9, 1))])
    found = down.range("z", {"y": 1.1})
    assert (found.lower, found.upper) == (0.0, 1.0)


@pytest.mark.parametrize("size", [0.01, 1.0, 10.0])
@pytest.mark.parametrize("start", [0.0, 0.9, 1.0132261])
def test_a_door_that_is_set_where_it_stops_stops_there_again(size: float, start: float) -> None:
    scaled = {
        "door": [((0.1 * size, -0.01 * size, 0), (size, 0.01 * size, size))],
        "wall": [((-0.5 * size, 0.5 * size, 0.1 * size), (0.3 * size, 0.6 * size, 0.9 * size))],
    }
    moved = Mechanism(mockup(**scaled), [Joint("h", "revolute", None, "door", Z, limits=(-1, 3))])
    truth = math.atan2(0.5, 0.3) - math.asin(0.01 / math.hypot(0.5, 0.3))
    first = moved.range("h", {"h": start}).upper
    for _ in range(8):
        found = moved.range("h", {"h": first})
        assert found.upper == first <= truth and found.lower == -1.0
    assert truth - first <= 1e-6


@pytest.mark.parametrize("start", [0.0, -0.2])
def test_a_loop_that_is_set_where_it_stops_can_back_off(start: float) -> None:
    """A slider-crank before a wall."""
    crank, rod, far = 0.1, 0.3, 0.35
    along = math.sqrt(rod**2 - crank**2)
    places = {"a": (0, crank / 2, 0), "b": (along / 2, crank / 2, 0.1), "c": (along, 0, 0.2), "d": (far + 0.02, 0, 0.2)}
    cubes = {
        name: [((x - 0.01, y - 0.01, z - 0.01), (x + 0.01, y + 0.01, z + 0.01))] for name, (x, y, z) in places.items()
    }
    joints = [
        Joint("crank", "revolute", None, "a", Z),
        Joint("rod", "revolute", "a", "b", Z, (0, crank, 0)),
        Joint("slider", "prismatic", None, "c", X),
    ]
    moved = Mechanism(mockup(**cubes), joints, loops=[Joint("pin", "revolute", "b", "c", Z, (along, 0, 0))])
    truth = math.acos((far**2 + crank**2 - rod**2) / (2 * crank * far)) - math.pi / 2
    free = moved.range("crank", {"crank": start})
    for place in (free.lower, free.lower - 1e-8, truth, truth - 1e-8):
        for _ in range(2):
            found = moved.range("crank", {"crank": place})
            assert found.upper == pytest.approx(free.upper, abs=1e-6)
            assert found.lower == pytest.approx(place, abs=1e-6)
            place = found.lower
        assert found.lower == moved.range("crank", {"crank": place}).lower
