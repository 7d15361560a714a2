"""Ways of parts that are sunk in a neighbour without a hole: never through a thin sheet of it beyond their place."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, mockup_of

import feeler

Floats = npt.NDArray[np.float64]


def revolved(profile: list[tuple[float, float]], sides: int) -> Mesh:
    """A profile of radii and heights, revolved about z; it begins and ends on the axis."""
    angles = 2 * np.pi * np.arange(sides) / sides
    rings = [np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(sides, z)]) for r, z in profile[1:-1]]
    ends = [(0.0, 0.0, profile[0][1]), (0.0, 0.0, profile[-1][1])]
    this, following = np.arange(sides), (np.arange(sides) + 1) % sides
    faces = [np.column_stack([np.full(sides, len(rings) * sides), following, this])]
    for ring in range(len(rings) - 1):
        low, high = ring * sides, (ring + 1) * sides
        faces.append(np.column_stack([low + this, low + following, high + following]))
        faces.append(np.column_stack([low + this, high + following, high + this]))
    top = (len(rings) - 1) * sides
    faces.append(np.column_stack([top + this, top + following, np.full(sides, len(rings) * sides + 1)]))
    return np.vstack([*rings, ends]), np.vstack(faces)


def pinned(seed: int, flanges: tuple[bool, bool]) -> tuple[feeler.Scene, Floats]:
    """A pin through a thin sheet without a hole, with thin flanges above and below it; and the pin's axis."""
    rng = np.random.default_rng(seed)
    radius, half = rng.uniform(0.002, 0.004), 0.016
    wide = radius + rng.uniform(0.002, 0.006)
    sheet, flange = 10 ** rng.uniform(-4.9, -4.0, 2)
    profile = [(0.0, -half), (radius, -half)]
    for has, side in zip(flanges, (-1, 1), strict=True):
        if has:
            low = side * rng.uniform(0.004, 0.012)
            high = low + flange
            profile += [(radius, low), (wide, low), (wide, high), (radius, high)]
    profile += [(radius, half), (0.0, half)]
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn = axes * np.sign(np.linalg.det(axes))
    plate, pin = box((-0.02, -0.02, -0.5 * sheet), (0.02, 0.02, 0.5 * sheet)), revolved(profile, 24)
    parts = {"pin": (pin[0] @ turn.T, pin[1]), "sheet": (plate[0] @ turn.T, plate[1])}
    return feeler.Scene(mockup_of(parts), threads=1), np.asarray(turn[:, 2])


@pytest.mark.parametrize("seed", range(4))
def test_thin_flanges_of_a_sunk_pin_go_through_no_thin_sheet(seed: int) -> None:
    scene, axis = pinned(seed, (True, True))
    way = feeler.removal(scene, "pin", directions=[axis, -axis], rounds=1, seconds=2.0, threads=1)
    assert not way.is_found


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("flanges", [(False, False), (True, False), (False, True)])
def test_a_pin_without_a_flange_on_one_side_comes_out_at_the_other(seed: int, flanges: tuple[bool, bool]) -> None:
    scene, axis = pinned(seed, flanges)
    way = feeler.removal(scene, "pin", directions=[axis, -axis], rounds=1, seconds=60.0, threads=1)
    assert way.is_found
    out = float(way.legs[-1].pose[:3, 3] @ axis)
    assert (flanges[0] and out < 0) or (flanges[1] and out > 0) or not any(flanges)
