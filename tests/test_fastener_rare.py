"""External Torx, square heads and recesses, pipe plugs, knurled heads and crossbars, and the tools of recesses.

The sizes are those of the standards and the trade; other things with such outlines are no fasteners.
"""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

pytest.importorskip("manifold3d", reason="it draws the fasteners")
from shapes import box, mockup_of
from test_fastener_forms import check, prism, regular, rod, seen

import feeler

DRAWN = importlib.import_module("drawn_fasteners")
Solid, Shape = DRAWN.Solid, DRAWN.Shape
Floats = npt.NDArray[np.float64]
BUILT_IN = feeler.catalogue()

EXTERNAL = {"E4": (3.86, 3), "E5": (4.73, 4), "E8": (7.52, 6), "E10": (9.42, 8), "E14": (12.9, 12), "E24": (22.13, 20)}
"""Width across the points, and thread, mm."""
TORX = {"T10": 2.8, "T20": 3.95, "T25": 4.5, "T27": 5.07, "T30": 5.6, "T40": 6.75, "T50": 8.95, "T60": 13.45}
"""ISO 10664: width across the points, mm."""
NAN = float("nan")


def star(points: list[tuple[float, float]]) -> Any:
    """A polygon of radii and angles."""
    return DRAWN.polygon(np.array([(r * math.cos(t), r * math.sin(t)) for r, t in points]))


def waves(across: float, count: int) -> Any:
    """Six lobes drawn as a wave."""
    turn = np.linspace(0.0, 2.0 * np.pi, 6 * count, endpoint=False)
    return star([(across / 2.0 * (0.86 + 0.14 * math.cos(6.0 * t)), t) for t in turn.tolist()])


def arcs(across: float) -> Any:
    """Six lobes drawn as arcs, as in ISO 10664."""
    shape, radius = Shape.circle(across / 2.0, 64), 0.18 * across
    for k in range(6):
        turn = math.radians(60.0 * k + 30.0)
        shape -= Shape.circle(radius, 24).translate([0.54 * across * math.cos(turn), 0.54 * across * math.sin(turn)])
    return shape


def square(flats: float, low: float, high: float) -> Any:
    return prism(regular(4, flats / 2.0, 0.3), low, high)


def tapered(wide: float, long: float) -> Any:
    return Solid.cylinder(long, wide / 2.0 - long / 32.0, wide / 2.0, 48).translate([0, 0, -long])


def knurled(radius: float, count: int, high: float, flat: float = 0.0) -> Any:
    """Grooves of 90 degrees, with a share of the round between them."""
    step, depth = 2.0 * math.pi / count, (1.0 - flat) * math.pi * radius / count
    points: list[tuple[float, float]] = []
    for k in range(count):
        points += [(radius, (k + end * flat / 2.0) * step) for end in ((-1, 1) if flat else (0,))]
        points.append((radius - depth, (k + 0.5) * step))
    return prism(star(points), 0.0, high)


def crossbar(thread: float, bar: float, long: float, hub: float, high: float) -> Any:
    across = Solid.cylinder(long, bar / 2.0, bar / 2.0, 24, True).rotate([0, 90, 0]).translate([0, 0, 0.6 * high])
    return rod(thread / 2.0, -3.0 * thread, 0.01, 32) + rod(hub / 2.0, 0.0, high, 32) + across


def splined(count: int, core: float, wide: float, tooth: float, high: float) -> Any:
    """A splined shaft of ISO 14."""
    shape = Shape.circle(core / 2.0, 64)
    for k in range(count):
        shape += Shape.square([wide / 2.0, tooth]).translate([0, -tooth / 2.0]).rotate(360.0 * k / count)
    return prism(shape ^ Shape.circle(wide / 2.0, 96), 0.0, high)


def toothed(count: int, module: float, high: float, flank: float = 0.5) -> Any:
    """A spur gear; its teeth are steeper with a greater flank."""
    pitch, step, points = module * count / 2.0, 2.0 * math.pi / count, []
    for k in range(count):
        ends = ((-1.25, -0.36), (0.0, -0.25), (1.0, -0.25 * flank), (1.0, 0.25 * flank), (0.0, 0.25), (-1.25, 0.36))
        points += [(pitch + more * module, (k + share) * step) for more, share in ends]
    return prism(star(points), 0.0, high)


@pytest.mark.parametrize("size", list(EXTERNAL))
def test_external_torx(size: str) -> None:
    across, thread = EXTERNAL[size]
    shank, flange = rod(thread / 2.0, -3.0 * thread, 0.01, 32), rod(0.95 * thread, 0.0, 0.12 * thread, 48)
    for outline in (waves(across, 4), waves(across, 12), arcs(across)):
        head = prism(outline.rotate(13.0), 0.0, 0.75 * thread) + shank
        for solid in (head, head + flange):
            row = check(solid, "bolt", "torx", NAN, thread)
            assert row.width == pytest.approx(1e-3 * across, rel=2e-3)
    tools = BUILT_IN.fitting(row.drive, row.across_flats, row.size, row.width)
    assert tools and {chain[0].name.split(" (")[0] for chain in tools} == {f"socket {size}"}


@pytest.mark.parametrize(
    ("solid", "kind", "drive", "flats", "size"),
    [
        (square(10, 0, 10) + rod(5, -40, 0.01, 32), "bolt", "square", 10, 10),  # DIN 479
        (square(10, 2, 12) + rod(8, 0, 2.01, 32) + rod(5, -40, 0.01, 32), "bolt", "square", 10, 10),  # DIN 478
        (square(13, 0, 12) + rod(6, -30, 0.01, 32) + rod(4.5, -36, -29, 32), "bolt", "square", 13, 12),
        (square(14.3, 0, 14) + tapered(21.2, 14), "bolt", "square", 14.3, 21.2),  # ASME B16.14
        (tapered(21.2, 14) - square(9.5, -9, 1), "screw", "square socket", 9.5, 21.2),
        (rod(14, 0, 3, 48) + rod(10, -12, 0.01, 48) - square(8, -8, 4), "screw", "square socket", 8, 20),
        (rod(4.7, 0, 3, 32) + rod(2.5, -25, 0.01, 32) - square(2.82, 0.5, 9), "screw", "square socket", 2.82, 5),
    ],
)
def test_squares(solid: Any, kind: str, drive: str, flats: float, size: float) -> None:
    row = check(solid, kind, drive, flats, size)
    assert row.width == row.across_flats
    assert BUILT_IN.fitting(row.drive, row.across_flats, row.size)


def test_a_straight_pipe_plug_needs_its_name() -> None:
    for solid in (square(14.3, 0, 14) + rod(10.5, -14, 0.01, 48), rod(10.5, -14, 0, 48) - square(9.5, -9, 1)):
        assert seen(solid)[0] is None
        row = seen(solid, "Verschlussstopfen")[0]
        assert row is not None and row.drive.startswith("square") and row.confidence == 0.99


@pytest.mark.parametrize("facets", [12, 16, 31, 64])
@pytest.mark.parametrize("length", [14.0, 19.8, 20.0, 24.0])
def test_a_plain_plug_is_no_square_from_its_side(facets: int, length: float) -> None:
    """As wide as it is long, it has the outline of a square."""
    row = seen(rod(9.9, 0.0, length, facets), "plug")[0]
    assert row is None or row.drive == "", row.because


@pytest.mark.parametrize(("size", "across"), list(TORX.items()))
def test_a_torx_bit_is_chosen_by_its_recess(size: str, across: float) -> None:
    """Whatever the thread is; a recess may be a little wider than its bit."""
    for thread, wider in ((1.2 * across, 1.0), (2.4 * across, 1.04)):
        recess = prism(arcs(wider * across), 0.1 * across, 2.0 * across)
        solid = rod(thread, 0.0, 0.8 * across, 32) + rod(thread / 2.0, -4.0 * thread, 0.01, 32) - recess
        row = check(solid, "screw", "torx socket", NAN, thread)
        assert row.width == pytest.approx(1e-3 * wider * across, rel=2e-3)
        found = BUILT_IN.fitting(row.drive, row.across_flats, row.size, row.width)
        assert {chain[0].name.split(" (")[0] for chain in found} == {f"torx bit {size}"}


@pytest.mark.parametrize(
    ("drive", "width_mm", "name"),
    [
        ("slot", 0.8, "screwdriver slot 4"),
        ("slot", 1.2, "screwdriver slot 8"),
        ("slot", 2.0, "screwdriver slot 12"),
        ("cross", 0.97, "screwdriver PH 1"),
        ("cross", 1.47, "screwdriver PH 2"),
        ("cross", 1.83, "screwdriver PH 2"),
        ("cross", 2.41, "screwdriver PH 3"),
    ],
)
def test_a_screwdriver_is_chosen_by_its_recess(drive: str, width_mm: float, name: str) -> None:
    for thread in (0.003, 0.006, 0.012, NAN):
        assert BUILT_IN.fitting(drive, NAN, thread, 1e-3 * width_mm)[0][0].name == name
    assert not BUILT_IN.fitting(drive, NAN, 0.006, 0.008), "nothing fits a recess of 8 mm"
    assert BUILT_IN.fitting(drive, NAN, 0.006), "the thread decides where the mesh shows no recess"


@pytest.mark.parametrize(
    ("solid", "size"),
    [
        (knurled(10, 60, 5) + rod(2.5, -15, 0.01, 32), 5),  # DIN 653
        (knurled(12, 72, 5) + rod(6, -10, 0.01, 32) + rod(3, -26, 0.01, 32), 6),  # DIN 464
        (knurled(12, 40, 8, 0.4) + rod(3, -16, 0.01, 32), 6),
        (crossbar(8, 6, 50, 13, 15), 8),  # DIN 6304
        (crossbar(12, 10, 80, 20, 20), 12),
    ],
)
def test_screws_that_are_turned_by_hand(solid: Any, size: float) -> None:
    row = check(solid, "screw", "hand", NAN, size)
    assert [chain[0].name for chain in BUILT_IN.fitting(row.drive, row.across_flats, row.size)] == ["pliers"]


def test_a_thumb_screw_without_grooves_is_turned_by_hand_by_its_name() -> None:
    solid = rod(9.0, 0.0, 7.0, 32) + rod(4.0, -20.0, 0.1, 32)
    for name in ("thumb screw", "Rändelschraube M8", "vis moletée"):
        row = seen(solid, name)[0]
        assert row is not None and (row.kind, row.drive) == ("screw", "hand")
    row = seen(solid, "screw")[0]
    assert row is not None and row.drive == ""


def others() -> dict[str, Any]:
    """Solids of such outlines that are no fasteners."""
    rng = np.random.default_rng(4)
    found: dict[str, Any] = {}
    for n, (count, core, wide, tooth) in enumerate([(6, 11, 14, 3), (6, 21, 25, 5), (6, 23, 28, 6), (8, 32, 38, 6)]):
        for end in (0.7, 1.3):
            shank = rod(0.5 * wide * end * rng.uniform(0.9, 1.1), -3.0 * wide, 0.01, 32)
            found[f"splines {n} {end}"] = splined(count, core, wide, tooth, rng.uniform(0.5, 1.5) * wide) + shank
    for count, module, flank in ((16, 1.0, 0.5), (40, 0.5, 0.5), (60, 0.5, 0.5), (24, 1.0, 0.85)):
        for share in (0.2, 0.55):
            shank = rod(share * count * module / 2.0, -20.0, 0.01, 32)
            found[f"gear {count} {flank} {share}"] = toothed(count, module, rng.uniform(3.0, 8.0), flank) + shank
    found["a block on a post"] = square(10.4, 0, 14) + rod(5, -30, 0.01, 32)
    found["a square shaft"] = square(8, 0, 20) + rod(4, -30, 0.01, 32)
    found["a square peg on a disc"] = square(10, 0, 10) + rod(10, -5, 0.01, 48)
    found["a taper pin"] = Solid.cylinder(40.0, 3.0, 3.4, 32)
    found["a tee"] = rod(8, 0, 30, 32) + rod(4, -30, 30, 32).rotate([90, 0, 0]).translate([0, 0, 20])
    found["a knurled insert"] = knurled(4, 40, 8) - rod(2.5, -1, 9, 32)
    found["a knurled rod"] = knurled(4, 40, 20) + rod(4, -20, 0.01, 48)
    found["a six-lobed knob"] = prism(waves(40, 12), 0, 14) + rod(4, -20, 0.01, 32)
    return found


@pytest.mark.parametrize("kind", list(others()))
def test_other_things_of_these_outlines(kind: str) -> None:
    row = seen(others()[kind])[0]
    assert row is None, row.because


def test_a_task_undoes_an_external_torx_with_its_socket() -> None:
    across, thread = EXTERNAL["E10"]
    bolt = prism(waves(across, 8), 0.0, 6.0) + rod(8.0, 0.0, 1.0, 48) + rod(thread / 2.0, -24.0, 0.01, 32)
    mesh = bolt.to_mesh64()
    vertices = 1e-3 * np.asarray(mesh.vert_properties)[:, :3]
    cover, base = Solid.cube([80, 80, 10], True).translate([0, 0, -5.001]), Solid.cube([80, 80, 30], True)
    parts: dict[str, Any] = {"part 1": (vertices, np.asarray(mesh.tri_verts).astype(np.int64))}
    hole = rod(4.4, -99, 99, 32)
    for name, solid in (("cover", cover - hole), ("base", base.translate([0, 0, -25.01]) - rod(4.0, -99, 99, 32))):
        other = solid.to_mesh64()
        parts[name] = 1e-3 * np.asarray(other.vert_properties)[:, :3], np.asarray(other.tri_verts).astype(np.int64)
    scene = feeler.Scene(mockup_of(parts))
    task = feeler.task(scene, "cover", tools=BUILT_IN, keep="base")
    assert [(step.part, step.tool.split(" (")[0]) for step in task.steps] == [("part 1", "socket E10"), ("cover", "")]
    wall = feeler.Scene(mockup_of({**parts, "lid": box((-0.04, -0.04, 0.0061), (0.04, 0.04, 0.01))}))
    assert not feeler.access(wall, BUILT_IN, feeler.find_fasteners(wall))[0].is_reachable
