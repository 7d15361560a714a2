"""Rolling bearings leave as one: found by shape in any pose, told from what looks like one, and taken out by tasks."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pytest
from bearing_shapes import (
    around,
    ball,
    ball_bearing,
    circle,
    double_row,
    gear,
    holed,
    lathe,
    named,
    plate,
    ring,
    rod,
    roller_bearing,
    solid,
    tapered_bearing,
    thrust_bearing,
)
from shapes import Mesh, mockup_of

import feeler
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance
from feeler.tasks.bearings import bearings_of

Floats = npt.NDArray[np.float64]


def tilted(parts: Mapping[str, Mesh], seed: int) -> feeler.Mockup:
    """Somewhere, in no special direction."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = rng.uniform(-2.0, 2.0, 3)
    return mockup_of({name: (vertices @ turn.T + shift, faces) for name, (vertices, faces) in parts.items()})


def bodies(parts: Mapping[str, Mesh], seed: int = 1) -> list[set[str]]:
    """The names of the parts of each bearing."""
    mockup = tilted(parts, seed)
    found = bearings_of(feeler.Scene(mockup))
    return [{mockup.part_paths[part] for part in (each.lead, *each.parts)} for each in found]


@pytest.mark.parametrize("seed", range(4))
def test_random_ball_bearings_in_random_poses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = float(rng.uniform(0.003, 0.02))
    count = int(rng.integers(6, 16))
    radius = size * count / math.tau * float(rng.uniform(1.15, 1.5))
    low = float(rng.choice([0.24, 0.44]))
    parts = ball_bearing(radius, size, count, has_cage=bool(seed % 2), seals=int(rng.integers(0, 3)), low=low)
    shaft = {"shaft": rod(radius - 0.9 * size, -3.0 * size, 3.0 * size, 36)}
    case = {"case": ring(radius + 0.9 * size, radius + 2.0 * size, -2.0 * size, 2.0 * size)}
    assert bodies(shaft | parts | case, seed) == [set(parts)]


@pytest.mark.parametrize(
    ("ribs", "away"), [("inner", {"outer"}), ("outer", {"inner"}), ("both", set()), ("none", {"inner", "outer"})]
)
def test_a_ring_without_ribs_comes_off_by_itself(ribs: str, away: set[str]) -> None:
    parts = roller_bearing(0.03, 0.008, 0.009, 14, ribs=ribs)
    assert bodies(parts) == [parts.keys() - away]


def test_needles_leave_with_their_cage_and_not_with_shaft_and_wheel() -> None:
    parts = roller_bearing(0.015, 0.002, 0.02, 20, ribs="none")
    del parts["inner"], parts["outer"]
    around_them = {"shaft": rod(0.01399, -0.05, 0.05, 48), "wheel": gear(0.03, 0.01602, -0.01, 0.01, 20, 0.004)}
    washer = {"circlip": ring(0.0135, 0.0155, 0.0125, 0.0135)}
    assert bodies(parts | around_them | washer) == [set(parts)]


def test_the_cup_of_a_tapered_bearing_comes_off_by_itself() -> None:
    parts = tapered_bearing(0.03, 0.008, 14)
    assert bodies(parts) == [parts.keys() - {"cup"}]


def test_two_rows_between_two_rings_are_one() -> None:
    parts = double_row(0.02, 0.006, 9)
    assert bodies(parts) == [set(parts)]


def test_the_washers_of_a_thrust_bearing_come_off() -> None:
    parts = thrust_bearing(0.03, 0.008, 10)
    assert bodies(parts) == [parts.keys() - {"shaft_washer", "housing_washer"}]


def keyed(is_rim: bool) -> Floats:
    """A circle with eight half round pockets: for keys half in the hub, half in the rim."""
    points = []
    for k in range(8):
        turn = k * math.tau / 8.0
        middle = 0.04 * np.array([math.cos(turn), math.sin(turn)])
        for t in np.linspace(-0.5 * math.pi, 0.5 * math.pi, 9):
            out, beside = (0.004 if is_rim else -0.004) * math.cos(t), 0.004 * math.sin(t)
            across = [out * math.cos(turn) - beside * math.sin(turn), out * math.sin(turn) + beside * math.cos(turn)]
            points.append(middle + across)
        for t in np.linspace(0.1, math.tau / 8.0 - 0.1, 5):
            points.append(0.04 * np.array([math.cos(turn + t), math.sin(turn + t)]))
    return np.array(points)


def planetary(planet: Mesh, count: int) -> dict[str, Mesh]:
    """Plain wheels around a sun in a rim."""
    parts = {"sun": rod(0.0179, -0.01, 0.01, 48), "rim": ring(0.0421, 0.05, -0.01, 0.01, 48)}
    return parts | named("planet", around(planet, 0.03, count))


def pins(count: int) -> dict[str, Mesh]:
    return named("pin", around(rod(0.0039, -0.012, 0.012), 0.03, count))


def bolted() -> dict[str, Mesh]:
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    bolts = around((mesh.vertices, mesh.faces.astype(np.int64)), 0.04, 8, z=0.01)
    return {"upper": flange(0.0, 0.01), "lower": flange(-0.02, 0.0)} | named("bolt", bolts)


def flange(low: float, high: float) -> Mesh:
    return holed(0.03, 0.055, low, high, 0.0041, 0.04, 8)


DOWELS = named("dowel", around(rod(0.004, -0.02, 0.01), 0.04, 8))
NONE = {
    "bolts in flanges": bolted(),
    "dowels in flanges": {"upper": flange(0.0, 0.01), "lower": flange(-0.02, 0.0)} | DOWELS,
    "pillars": {"upper": ring(0.03, 0.055, 0.01, 0.02), "lower": ring(0.03, 0.055, -0.03, -0.02)} | DOWELS,
    "keys": {
        "hub": plate([keyed(False), circle(0.02, 48)], -0.01, 0.01),
        "rim": plate([circle(0.06, 48), keyed(True)], -0.01, 0.01),
    }
    | named("key", around(rod(0.0039, -0.01, 0.01), 0.04, 8)),
    "planets on pins": planetary(ring(0.004, 0.012, -0.01, 0.01, 24), 5) | pins(5),
    "planets drawn without a bore": planetary(rod(0.012, -0.01, 0.01, 24), 6) | pins(6),
    "planets with trunnions": planetary(
        solid([(0.004, -0.015), (0.004, -0.01), (0.012, -0.01), (0.012, 0.01), (0.004, 0.01), (0.004, 0.015)], 24), 5
    ),
    "planet wheels": {
        "sun": gear(0.0195, 0.01, -0.01, 0.01, 24, 0.002),
        "rim": gear(0.0425, 0.05, -0.01, 0.01, 56, -0.002),
    }
    | named("planet", around(gear(0.0105, 0.004, -0.01, 0.01, 14, 0.002), 0.03, 5))
    | pins(5),
    "balls on a plate": {"plate": ring(0.01, 0.06, -0.01, 0.0)} | named("ball", around(ball(0.005), 0.04, 8, z=0.005)),
}


@pytest.mark.parametrize("name", NONE)
def test_what_looks_like_a_bearing_is_none(name: str) -> None:
    assert bodies(NONE[name], 3) == []


def on_a_shaft() -> dict[str, Mesh]:
    """A bearing between a shoulder of a shaft and a circlip, in a sleeve that is open at that end."""
    parts = ball_bearing(0.02, 0.007, 8)
    bore, half = 0.02 - 0.9 * 0.007, 0.8 * 0.007
    seat, deep = bore - 2e-5, bore - 0.001
    edges = [(seat + 0.003, -0.03), (seat + 0.003, -half - 1e-5), (seat, -half - 1e-5), (seat, half + 1e-5)]
    edges += [(deep, half + 1e-5), (deep, half + 0.0013), (seat, half + 0.0013), (seat, 0.012)]
    sleeve = [
        (0.0275, -half - 1e-5),
        (0.0275, 0.02),
        (0.032, 0.02),
        (0.032, -0.04),
        (0.02, -0.04),
        (0.02, -half - 1e-5),
    ]
    opened = ring(deep + 1e-4, deep + 0.0035, half + 5e-5, half + 0.0011)
    middle = opened[0][opened[1]].mean(axis=1)
    clip = opened[0], opened[1][np.abs(np.arctan2(middle[:, 1], middle[:, 0])) > 0.3]
    return parts | {"shaft": solid(edges, 36), "sleeve": lathe(sleeve), "circlip": clip}


def test_a_bearing_comes_off_its_shaft_as_one_after_its_circlip() -> None:
    scene = feeler.Scene(tilted(on_a_shaft(), 5))
    held = feeler.holds(scene)
    row = held.of(scene.mockup.part_paths.index("outer"))
    assert row is not None and row.kind == "bearing" and len(row.parts) == 10 and "8 balls" in row.because
    task = feeler.task(scene, "ball_3", held=held, keep=["shaft", "sleeve"])
    assert task.is_found, task.blocked
    assert [len(step.parts) for step in task.steps] == [1, 11]
    assert task.steps[0].part == "circlip"


def test_a_table_knows_better() -> None:
    mockup = tilted(on_a_shaft(), 6)
    outer = mockup.part_paths.index("outer")
    found = feeler.holds(mockup, table={"outer": None}).of(outer)
    assert found is not None and found.paths == ()
    fewer = feeler.holds(mockup, table={"cage": None}).of(outer)
    assert fewer is not None and "cage" not in fewer.paths and len(fewer.paths) == 9
