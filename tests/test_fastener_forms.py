"""Plugs, hollow, shoulder, short and wing screws, dog points and carriage bolts by the tables of their standards."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from point_depths import quartered

import feeler

pytest.importorskip("manifold3d", reason="it draws the fasteners")
DRAWN = importlib.import_module("drawn_fasteners")
Solid, lobes, prism, regular, rod = DRAWN.Solid, DRAWN.lobes, DRAWN.prism, DRAWN.regular, DRAWN.rod

Floats = npt.NDArray[np.float64]

COLLAR_SOCKETS = [(8, 12, 4), (10, 14, 5), (12, 17, 6), (16, 21, 8), (22, 27, 10), (30, 36, 17), (42, 49, 22)]
"""DIN 908: thread, collar, hexagon socket, mm."""
COLLAR_HEXAGONS = [(8, 12, 10), (10, 14, 10), (14, 19, 13), (16, 21, 17), (22, 27, 19), (30, 36, 24), (48, 55, 30)]
"""DIN 910: thread, collar, hexagon, mm."""
SHOULDERS = [
    (5, 6, 10, 3),
    (5, 6.5, 10, 3),
    (8, 10, 16, 5),
    (8, 12, 18, 6),
    (10, 13, 18, 6),
    (16, 20, 30, 10),
    (8, 10.4, 14.6, 6),
]
"""ISO 7379 and wider ones: thread, shoulder, head, hexagon socket, mm."""
DOGS = [(3, 2.0, 1.5), (4, 2.5, 2), (6, 4, 3), (8, 5.5, 4), (12, 8.5, 6)]
"""DIN 915: thread, point, hexagon socket, mm."""


def socket(flats: float, low: float, high: float) -> Any:
    return prism(regular(6, flats / 2.0, 0.3), low, high)


def collar_socket(thread: float, collar: float, flats: float) -> Any:
    body = rod(thread / 2.0, -0.9 * thread, 0.1, 32) + rod(collar / 2.0, 0.0, 0.15 * collar, 32)
    return body - socket(flats, -0.3 * thread, collar)


def collar_hexagon(thread: float, collar: float, flats: float) -> Any:
    low = 0.15 * collar
    head = prism(regular(6, flats / 2.0, 0.3), low - 0.1, low + 0.5 * flats)
    return rod(thread / 2.0, -0.8 * thread, 0.1, 32) + rod(collar / 2.0, 0.0, low, 32) + head


def shoulder(thread: float, wide: float, head: float, flats: float, long: float) -> Any:
    body = rod(thread / 2.0, -long - 1.5 * thread, -long + 0.1, 32) + rod(wide / 2.0, -long, 0.1, 32)
    return body + rod(head / 2.0, 0.0, 0.45 * head, 32) - socket(flats, 0.2 * head, head)


def dog(thread: float, point: float, flats: float) -> Any:
    body = rod(thread / 2.0, -1.5 * thread, 0.0, 32) + rod(point / 2.0, -2.0 * thread, -1.4 * thread, 32)
    return body - socket(flats, -0.5 * thread, 1.0)


def hexagon_bolt(size: float = 16.0, flats: float = 24.0, long: float = 60.0) -> Any:
    return prism(regular(6, flats / 2.0, 0.3), 0.0, 0.65 * size) + rod(size / 2.0, -long, 0.1, 32)


def cap_screw(size: float = 8.0, long: float = 25.0) -> Any:
    return rod(0.75 * size, 0.0, size, 32) + rod(size / 2.0, -long, 0.1, 32)


def recess(drive: str) -> Any:
    """For a head of 8 mm height and 12 mm diameter."""
    if drive == "slot":
        return Solid.cube([20.0, 1.6, 6.0], True).translate([0, 0, 8.0])
    if drive == "cross":
        return Solid.cube([8.0, 1.6, 8.0], True).translate([0, 0, 8.0]) + Solid.cube([1.6, 8.0, 8.0], True).translate(
            [0, 0, 8.0]
        )
    if drive == "torx socket":
        return prism(lobes(3.2, 12), 4.0, 9.0)
    return prism(regular(4, 2.6, 0.2), 4.0, 9.0) if drive == "square socket" else socket(6.0, 4.0, 9.0)


def wing_screw(thick: float = 3.0) -> Any:
    wings = Solid.cube([32.0, thick, 13.0]).translate([-16.0, -thick / 2.0, 3.0])
    return rod(6.0, 0.0, 9.0, 32) + wings + rod(4.0, -20.0, 0.1, 32)


def carriage_bolt(side: float) -> Any:
    head = Solid.sphere(11.25, 64).translate([0, 0, -6.75]).trim_by_plane([0, 0, 1], 0.0)
    return head + prism(regular(4, side / 2.0), -4.0, 0.1) + rod(4.0, -30.0, 0.1, 32)


def seen(solid: Any, name: str = "part_3", seed: int = 1) -> tuple[feeler.Fastener | None, Floats]:
    """What is found of a solid at a random pose, as drawn and with each triangle cut in four; and the outer axis."""
    mesh = solid.to_mesh64()
    corners = 1e-3 * np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts).astype(np.int64)]
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    rows = []
    for each in (corners, quartered(corners)):
        points = each.reshape(-1, 3) @ turn.T + rng.uniform(-2.0, 2.0, 3)
        faces = np.arange(len(points)).reshape(-1, 3)
        found = feeler.find_fasteners(feeler.Mockup(points, faces, np.zeros(len(faces), dtype=np.int32), [name]))
        rows.append(found[0] if len(found) else None)
    one, other = rows
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert (one.kind, one.drive) == (other.kind, other.drive)
    return one, turn[:, 2]


def check(solid: Any, kind: str, drive: str, flats: float, size: float, name: str = "part_3") -> feeler.Fastener:
    row, out = seen(solid, name)
    assert row is not None
    assert (row.kind, row.drive) == (kind, drive), row.because
    assert row.across_flats == pytest.approx(1e-3 * flats, rel=1e-3, nan_ok=True)
    assert row.size == pytest.approx(1e-3 * size, rel=1e-3) and row.axis @ out > 1.0 - 1e-6
    assert row.confidence == (0.9 if name == "part_3" else 0.99)
    return row


@pytest.mark.parametrize(("thread", "collar", "flats"), COLLAR_SOCKETS)
def test_a_plug_with_a_collar_and_a_socket(thread: float, collar: float, flats: float) -> None:
    solid = collar_socket(thread, collar, flats)
    for name in ("part_3", "drain plug"):
        row = check(solid, "screw", "hexagon socket", flats, thread, name)
    assert row.length == pytest.approx(0.9e-3 * thread, rel=1e-3)
    bored = solid - rod(0.3 * thread, -2.0 * thread, -0.5 * thread, 32)
    check(bored, "screw", "hexagon socket", flats, thread)


@pytest.mark.parametrize(("thread", "collar", "flats"), COLLAR_HEXAGONS)
def test_a_plug_with_a_collar_and_a_hexagon(thread: float, collar: float, flats: float) -> None:
    solid = collar_hexagon(thread, collar, flats)
    for name in ("part_3", "Verschlussschraube", "bouchon"):
        row = check(solid, "bolt", "hexagon", flats, thread, name)
    assert row.head_height == pytest.approx(1e-3 * (0.15 * collar + 0.5 * flats), rel=1e-3)
    check(solid - rod(0.3 * thread, -2.0 * thread, 0.0, 32), "bolt", "hexagon", flats, thread)


@pytest.mark.parametrize("bore", [0.3, 0.5, 1.0, 2.0, 3.0, 5.0, 6.5])
def test_a_bolt_with_a_bore(bore: float) -> None:
    solid = hexagon_bolt() - rod(bore, -99.0, 99.0, 32)
    row = check(solid, "bolt", "hexagon", 24, 16, "hollow bolt")
    assert row.length == pytest.approx(0.06)
    if bore < 0.4 * 8.0:
        check(solid, "bolt", "hexagon", 24, 16)
    else:
        assert seen(solid)[0] is None, "unions look alike"
        assert seen(solid, "pipe union")[0] is None


@pytest.mark.parametrize("drive", ["hexagon socket", "torx socket", "slot", "cross", "square socket"])
@pytest.mark.parametrize("bore", [0.4, 0.75, 1.5])
def test_a_vented_screw(drive: str, bore: float) -> None:
    solid = cap_screw() - recess(drive) - rod(bore, -99.0, 99.0, 32)
    flats = {"hexagon socket": 6.0, "square socket": 5.2}.get(drive, np.nan)
    check(solid, "screw", drive, flats, 8)


@pytest.mark.parametrize(("thread", "wide", "head", "flats"), SHOULDERS)
@pytest.mark.parametrize("long", [0.5, 1.0, 2.0, 4.0, 7.0])
def test_a_shoulder_screw(thread: float, wide: float, head: float, flats: float, long: float) -> None:
    solid = shoulder(thread, wide, head, flats, long * wide)
    row = check(solid, "screw", "hexagon socket", flats, thread)
    assert row.length == pytest.approx(1e-3 * (long * wide + 1.5 * thread), rel=1e-3)


@pytest.mark.parametrize(("thread", "point", "flats"), DOGS)
def test_a_set_screw_with_a_dog_point(thread: float, point: float, flats: float) -> None:
    for name in ("part_3", "Gewindestift"):
        check(dog(thread, point, flats), "screw", "hexagon socket", flats, thread, name)


@pytest.mark.parametrize(("size", "flats"), [(6, 10), (12, 18), (20, 30)])
def test_short_screws(size: float, flats: float) -> None:
    check(hexagon_bolt(size, flats, 0.4 * size), "bolt", "hexagon", flats, size)
    solid = cap_screw(size, 0.4 * size) - socket(0.8 * size, 0.5 * size, 2.0 * size)
    check(solid, "screw", "hexagon socket", 0.8 * size, size)


@pytest.mark.parametrize("name", ["part_3", "thumb screw", "Flügelschraube", "DIN 316 M8"])
def test_a_wing_screw(name: str) -> None:
    row = check(wing_screw(), "screw", "wings", np.nan, 8, name)
    assert row.length == pytest.approx(0.02) and row.head_height == pytest.approx(0.016)


@pytest.mark.parametrize("side", [8.0, 8.6])
def test_a_carriage_bolt_has_no_drive(side: float) -> None:
    for name in ("part_3", "carriage bolt"):
        row = check(carriage_bolt(side), "bolt", "", np.nan, 8, name)
    assert row.length == pytest.approx(0.03) and "square neck" in row.because


def others() -> dict[str, Any]:
    """Solids of such proportions that are no fasteners."""
    return {
        "a stub shaft": rod(5.0, -20.0, 0.1, 32) + rod(8.0, 0.0, 12.0, 32) + prism(regular(6, 5.0), 11.9, 20.0),
        "a spigot on a disc": rod(12.0, 0.0, 3.0, 32) + rod(8.0, -12.0, 0.1, 32),
        "a clutch disc": rod(11.0, 0.0, 3.0, 32) + rod(8.0, -12.0, 0.1, 32) - socket(8.0, -50.0, 50.0),
        "a bush": rod(11.0, 0.0, 3.0, 32) + rod(8.0, -12.0, 0.1, 32) - rod(3.0, -50.0, 50.0, 32),
        "a bit holder": rod(6.0, -30.0, 0.0, 32) - socket(7.0, -12.0, 1.0) - rod(2.6, -50.0, 50.0, 32),
        "a spacer": prism(regular(6, 5.0), 0.0, 25.0) - rod(2.5, -50.0, 50.0, 32),
        "a tee": rod(8.0, 0.0, 30.0, 32) + rod(4.0, -30.0, 30.0, 32).rotate([90, 0, 0]).translate([0, 0, 20.0]),
        "a square shaft": rod(4.0, -30.0, 0.1, 32) + prism(regular(4, 4.0), 0.0, 20.0),
        "a hexagon shaft": hexagon_bolt(12.0, 18.0, 30.0).translate([0, 0, 5]) + rod(4.0, -60.0, 0.0, 32),
    }


@pytest.mark.parametrize("kind", list(others()))
def test_other_things_of_these_proportions(kind: str) -> None:
    assert seen(others()[kind])[0] is None
