"""Joints as designers draw them: flush countersunk heads, lock nuts, set screws, spacers; what holds, and the plan."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, joined, mockup_of, prism_ring
from test_holding import CLEAR, FITTED, USUAL, nut, only, plain, ring, tilted, union_nut

import feeler
from feeler.samples import hardware
from feeler.samples.shapes import skin_loops
from feeler.samples.tessellation import circle, hexagon

WALLS = [
    *(((-2, -2, low), (2, 2, low + 1)) for low in (-2, 1)),
    *(((-2, low, -1), (2, low + 1, 1)) for low in (-2, 1)),
    *(((low, -1, -1), (low + 1, 1, 1)) for low in (-2, 1)),
]
"""Of a closed box."""
LUMP = box((0.2, 0.0, 0.0), (0.21, 0.01, 0.01))
"""Another part, so that not all that is left leaves."""


def moved(mesh: Mesh, x: float = 0.0, z: float = 0.0) -> Mesh:
    return mesh[0] + np.array([x, 0.0, z]), mesh[1]


def rod(radius: float, low: float, high: float, sides: int = 32) -> Mesh:
    return prism_ring(radius, 0.0, sides, low, high)


def steps(task: feeler.Task) -> list[tuple[str, tuple[str, ...]]]:
    return [(step.verb, tuple(sorted(step.paths))) for step in task.steps]


def countersunk(length: float) -> Mesh:
    """An M6 screw with its head's top at z = 0."""
    loops = [circle(0.003, 32, -length), circle(0.003, 32, -0.003), circle(0.006, 32, 0.0)]
    return plain(skin_loops([*loops, hexagon(0.004, 0.0), hexagon(0.004, -0.002)]))


@pytest.mark.parametrize("sunk", [0.0, 0.00005])
def test_what_lies_on_a_flush_countersunk_head_is_not_held_by_it(sunk: float) -> None:
    """A wheel over a disc, whose screw is below the wheel."""
    outside = [(0.02, -0.01), (0.02, 0.0), (0.00605 + sunk, 0.0)]
    hole = [(0.00605, -sunk), (0.0033, -sunk - 0.0028), (0.0033, -0.01)]
    disc = skin_loops([circle(radius, 32, z) for radius, z in (*outside, *hole)], closed=True)
    parts = {
        "disc": joined(plain(disc), moved(ring(0.0045, -0.01, 0.0), 0.041)),
        "disc screw": moved(countersunk(0.025), z=-sunk),
        "wheel": joined(box((-0.02, -0.02, 0.0), (0.02, 0.02, 0.006)), moved(ring(0.0045, 0.0, 0.006), 0.041)),
        "bolt": moved(plain(hardware.hex_bolt(0.008, 0.03, USUAL)), 0.041, 0.006),
        "base": joined(ring(0.003, -0.03, -0.01), moved(ring(FITTED, -0.03, -0.01), 0.041)),
    }
    for seed in range(3):
        found = feeler.holds(tilted(parts, seed))
        assert only(found, "disc screw").paths == ("disc",), (seed, only(found, "disc screw").because)
        assert only(found, "bolt").paths == ("wheel", "disc")
    task = feeler.task(feeler.Scene(tilted(parts, 1)), "wheel", keep="base")
    assert steps(task) == [("undo", ("bolt",)), ("take out", ("wheel",))], task.blocked


@pytest.mark.parametrize(("gap", "is_out"), [(0.0001, True), (-0.0001, False)])
def test_a_bolt_needs_no_more_room_than_its_length(gap: float, is_out: bool) -> None:
    """Below a panel that stays; its shank is 80 mm long."""
    bolt = moved(plain(hardware.hex_bolt(0.008, 0.08, USUAL)), z=0.01)
    top = float(bolt[0][:, 2].max()) + 0.08 + gap
    parts = {
        "block": ring(CLEAR, 0.0, 0.01),
        "base": ring(FITTED, -0.08, 0.0),
        "bolt": bolt,
        "panel": box((-0.1, -0.1, top), (0.1, 0.1, top + 0.01)),
    }
    for seed in range(2):
        task = feeler.task(feeler.Scene(tilted(parts, seed)), "block", keep=["base", "panel"])
        assert task.is_found is is_out, (seed, task.blocked)


@pytest.mark.parametrize("is_inside_out", [False, True])
def test_what_is_around_a_head_and_ends_below_it_is_not_held(is_inside_out: bool) -> None:
    """A foam that is drawn through the head of a bolt, down to the plate that it bears on."""
    foam = box((-0.03, -0.03, 0.0), (0.03, 0.03, 0.02))
    parts = {
        "bolt": plain(hardware.hex_bolt(0.008, 0.03, USUAL)),
        "foam": (foam[0], foam[1][:, ::-1].copy() if is_inside_out else foam[1]),
        "plate": ring(CLEAR, -0.01, 0.0),
        "base": ring(FITTED, -0.04, -0.01),
    }
    for seed in range(3):
        row = only(feeler.holds(tilted(parts, seed)), "bolt")
        assert (row.paths, row.anchor_path) == (("plate",), "base"), (seed, row.because)


@pytest.mark.parametrize(("thread", "flats", "height"), [(12, 17, 4), (20, 24, 3), (32, 36, 6)])
def test_a_lock_nut_is_told_by_the_thread_in_its_bore(thread: float, flats: float, height: float) -> None:
    """Wider in its bore than usual nuts: on a cable gland or a sensor."""
    radius, wide, high = 0.0005 * thread, 0.001 * flats, 0.001 * height
    parts = {
        "panel": ring(radius + 0.0003, 0.0, 0.003, 0.06),
        "gland": joined(ring(0.5 * radius, -0.015, 0.003, radius), ring(0.5 * radius, 0.003, 0.01, 0.6 * wide)),
        "lock nut": union_nut(wide, radius + 0.00002, radius + 0.00002, -high, -0.5 * high, 0.0),
    }
    for name in ("lock nut", "part 7"):
        named = {name: parts["lock nut"], **{key: parts[key] for key in ("panel", "gland")}}
        for seed in range(2):
            (row,) = feeler.holds(tilted(named, seed))
            assert (row.path, row.paths, row.anchor_path) == (name, ("panel",), "gland"), row.because
        task = feeler.task(feeler.Scene(tilted(named, 1)), "gland", keep="panel")
        assert steps(task) == [("undo", (name,)), ("take out", ("gland",))], task.blocked
    # Without a thread in it, it is a ring; so is one that is named so.
    loose = {**parts, "part 7": parts["lock nut"], "gland": ring(0.4 * radius, -0.015, 0.01, 0.9 * radius)}
    del loose["lock nut"]
    assert not feeler.find_fasteners(tilted(loose, 1))
    assert not feeler.find_fasteners(tilted({"panel": parts["panel"], "gland": parts["gland"], "ring": named[name]}, 1))


def through_rod(nuts: int = 2) -> dict[str, Mesh]:
    """A rod through a plate with a nut below it, and one above."""
    above = plain(hardware.nut(0.008, USUAL))
    parts = {"plate": ring(CLEAR, -0.01, 0.0, 0.04), "rod": rod(0.00384, -0.03, 0.03), "nut below": nut(-0.01)}
    return {**parts, **({"nut above": above} if nuts > 1 else {})}


@pytest.mark.parametrize(("name", "seed"), [("stud", 0), ("tie rod", 1)])
def test_a_rod_is_not_drawn_through_its_nuts(name: str, seed: int) -> None:
    """One nut is undone, the other leaves with it."""
    parts = through_rod()
    parts[name] = parts.pop("rod")
    task = feeler.task(feeler.Scene(tilted(parts, seed)), name, keep="plate")
    (first, second) = steps(task)
    assert first in (("undo", ("nut above",)), ("undo", ("nut below",)))
    left = {"nut above", "nut below"} - set(first[1])
    assert second == ("take out", tuple(sorted({name, *left}))), steps(task)
    task = feeler.task(feeler.Scene(tilted({**through_rod(1), "lump": LUMP}, 1)), "rod", keep="plate")
    assert steps(task) == [("undo", ("nut below",)), ("take out", ("rod",))]


def test_a_stud_that_is_wanted_is_turned_out_after_its_nut() -> None:
    parts = {
        "base": ring(0.00384, -0.03, 0.0, 0.04),
        "lever": ring(CLEAR, 0.0, 0.01),
        "stud": rod(0.00384, -0.02, 0.03),
        "nut": moved(plain(hardware.nut(0.008, USUAL)), z=0.01),
    }
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        task = feeler.task(scene, "stud", keep=["base", "lever"])
        assert steps(task) == [("undo", ("nut",)), ("undo", ("stud",))], task.blocked
        assert 0.0 < task.bound <= task.seconds and 60 < task.steps[1].strokes < 120
        assert steps(feeler.task(scene, ["stud", "nut"]))[-1] == ("undo", ("stud",))
        # With a part that is no fastener it stays, and it is said.
        both = feeler.task(scene, ["stud", "lever"])
        assert steps(both) == [("undo", ("nut",)), ("take out", ("lever",))]
        assert any("Studs stay" in note and "'stud'" in note for note in both.notes)


@pytest.mark.parametrize(("name", "end"), [("KM4 nut", 0.06), ("DIN 981 KM4", 0.029), ("knurled nut", 0.04)])
def test_a_round_nut_on_a_shaft_is_undone_away_from_its_wheel(name: str, end: float) -> None:
    """Its bore is wider than half of it."""
    parts = {
        "shaft": joined(rod(0.01, -0.06, end), ring(0.0099, -0.06, 0.0, 0.018)),
        "pulley": ring(0.0102, 0.0, 0.02, 0.03),
        name: ring(0.01002, 0.02, 0.028, 0.016),
    }
    for seed in range(3):
        mockup = tilted(parts, seed)
        row = only(feeler.holds(mockup), name)
        assert (row.paths, row.anchor_path) == (("pulley",), "shaft"), (seed, row.because)
    task = feeler.task(feeler.Scene(mockup), "pulley", keep="shaft")
    assert steps(task) == [("undo", (name,)), ("take out", ("pulley",))], task.blocked


def across(mesh: Mesh) -> Mesh:
    """With its axis z along x."""
    turn: npt.NDArray[np.float64] = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return mesh[0] @ turn.T, mesh[1]


def set_screw() -> Mesh:
    """M6 with a dog point of 4 mm, its tip at z = 7.2 mm and its socket at 20 mm."""
    outside = [(0.002, 0.0072), (0.002, 0.0102), (0.003, 0.0104), (0.003, 0.02)]
    return plain(skin_loops([*(circle(r, 32, z) for r, z in outside), hexagon(0.003, 0.02), hexagon(0.003, 0.016)]))


def half_hub() -> Mesh:
    """A block with a bore of 10.2 mm radius about z, and a threaded hole of M6 along x that ends 5 mm above the screw:
    the hole as a liner in a gap of two blocks."""
    walls = [ring(0.0102, -0.015, -0.0031, 0.025), ring(0.0102, 0.0031, 0.015, 0.025)]
    liner = across(prism_ring(0.0042, 0.003, 32, 0.0105, 0.0245))
    return joined(*walls, liner)


@pytest.mark.parametrize(("wanted", "kept"), [("hub", "shaft"), ("shaft", "hub")])
def test_a_set_screw_in_the_way_of_its_own_part_is_undone(wanted: str, kept: str) -> None:
    """Its point is in a groove of the shaft, which it does not touch."""
    shaft = joined(rod(0.01, -0.05, -0.004), rod(0.007, -0.004, 0.004), rod(0.01, 0.004, 0.05))
    parts = {"set screw": across(set_screw()), "hub": half_hub(), "shaft": shaft}
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        row = only(feeler.holds(scene), "set screw")
        assert (row.paths, row.anchor_path) == (("set screw",), "hub"), row.because
        task = feeler.task(scene, wanted, keep=kept)
        assert steps(task) == [("undo", ("set screw",)), ("take out", (wanted,))], task.blocked
        # It is sunk, and turned until its end is out: 13 mm, not the 3 mm of its point.
        assert task.steps[0].strokes == feeler.task(scene, "set screw").steps[0].strokes == 77


def standoff(z: float) -> Mesh:
    """M3 with a hexagon of 5.5 mm from z up to z + 10 mm, a thread 5 mm below it, and one 7 mm deep in its top."""
    outside = [circle(0.0015, 32, z - 0.005), circle(0.0015, 32, z), hexagon(0.0055, z), hexagon(0.0055, z + 0.01)]
    return plain(skin_loops([*outside, circle(0.00151, 32, z + 0.01), circle(0.00151, 32, z + 0.003)]))


@pytest.mark.parametrize("name", ["standoff", "hex spacer bolt", "part"])
def test_a_standoff_has_the_thread_of_the_screw_in_it(name: str) -> None:
    """A board on two of them, which are one on the other, and another one above it."""
    board = ring(0.0017, 0.0, 0.0016)
    parts = {
        "chassis": ring(0.0015, -0.006, 0.0),
        f"{name} 1": standoff(0.0),
        "board": moved(board, z=0.01),
        f"{name} 2": standoff(0.0116),
        "upper board": moved(board, z=0.0216),
        "screw": moved(plain(hardware.cap_screw(0.003, 0.006, USUAL)), z=0.0232),
    }
    for seed in range(2):
        found = feeler.holds(tilted(parts, seed))
        held = {row.path: (row.paths, row.anchor_path) for row in found}
        assert held == {
            "screw": (("upper board",), f"{name} 2"),
            f"{name} 2": (("board",), f"{name} 1"),
            f"{name} 1": ((f"{name} 1",), "chassis"),
        }
    task = feeler.task(feeler.Scene(tilted(parts, 1)), "board", keep="chassis")
    undone = [("undo", ("screw",)), ("take out", ("upper board",)), ("undo", (f"{name} 2",))]
    assert steps(task) == [*undone, ("take out", ("board",))], task.blocked
    # 4.4 mm of M3 are in the upper standoff.
    assert task.steps[0].strokes == pytest.approx(6 * 4.4 / 0.5, abs=2)


def test_a_hexagon_with_a_bore_right_through_it_is_no_standoff() -> None:
    loops = [circle(0.0015, 32, -0.005), circle(0.0015, 32, 0.0), hexagon(0.0055, 0.0), hexagon(0.0055, 0.01)]
    loops += [circle(0.00125, 32, 0.01), circle(0.00125, 32, -0.005)]
    assert not feeler.find_fasteners(tilted({"part": plain(skin_loops(loops, closed=True)), "lump": LUMP}, 1))


def snap_ring(inner: float, outer: float, low: float, high: float) -> Mesh:
    """A ring about z that is open by 10 degrees."""
    turn = np.radians(np.linspace(5.0, 355.0, 41))
    corners = [(radius, z) for radius, z in ((inner, low), (outer, low), (outer, high), (inner, high))]
    vertices = np.array([[r * np.cos(a), r * np.sin(a), z] for a in turn for r, z in corners])
    faces = [[0, 1, 2], [0, 2, 3], [160, 162, 161], [160, 163, 162]]
    for n in range(0, 160, 4):
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
            faces += [[n + a, n + 4 + a, n + 4 + b], [n + a, n + 4 + b, n + b]]
    return vertices, np.array(faces)


@pytest.mark.parametrize("wanted", ["bush", ["bush", "snap ring"], "housing"])
def test_a_part_leaves_with_its_snap_ring_on_the_other_side(wanted: str | list[str]) -> None:
    """The ring is in a recess of the housing, where nothing opens it, and stops the bush on its way in alone."""
    parts = {
        "housing": joined(ring(0.0301, -0.03, -0.002, 0.05), ring(0.034, -0.002, 0.0, 0.05)),
        "bush": joined(
            ring(0.015, -0.03, -0.002, 0.03), ring(0.015, -0.002, 0.0, 0.028), ring(0.015, 0.0, 0.005, 0.03)
        ),
        "snap ring": snap_ring(0.02805, 0.0335, -0.0019, -0.0001),
        "lump": LUMP,
    }
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        row = only(feeler.holds(scene), "snap ring")
        assert (row.kind, row.paths, row.anchor_path) == ("circlip", ("housing",), "bush"), row.because
        task = feeler.task(scene, wanted, keep="bush" if wanted == "housing" else "housing")
        left = ("housing",) if wanted == "housing" else ("bush", "snap ring")
        assert steps(task) == [("take out", left)], task.blocked
        assert task.bound == pytest.approx(task.seconds)


def test_a_kept_fastener_is_named_and_nuts_are_fasteners() -> None:
    scene = feeler.Scene(tilted({**through_rod(), "lump": LUMP}, 1))
    task = feeler.task(scene, "plate", keep=["nut below", "nut above", "rod"])
    assert [(row.because, row.blockers) for row in task.blocked] == [
        ("a fastener that holds it is kept", ("nut below", "nut above"))
    ]
    assert not any("looks like a fastener" in note for note in feeler.task(scene, "lump").notes)


def test_a_search_that_time_ends_without_a_plan_has_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """Time is up while bent ways are searched: there may be a plan."""

    def late(planner: Any, _found: object) -> bool:
        planner.clock.seconds = 0.0
        return False

    monkeypatch.setattr("feeler.tasks.planning._Planner._try_bent", late)
    shut = joined(*(box(*(np.array(side) * 0.02)) for side in WALLS))
    task = feeler.task(
        feeler.Scene(mockup_of({"case": shut, "ball": box((-0.01,) * 3, (0.01,) * 3)})), "ball", seconds=99
    )
    assert not task.is_found and not task.is_complete and task.bound == 0.0


def test_rims_of_holes_behind_each_other_stop_nothing() -> None:
    """Blocks on each other under bolts, along the axes: the lower one leaves sideways, and the upper one stays."""
    solids = pytest.importorskip("manifold3d")
    places = [(x, y) for x in (-18, 18) for y in (-13, 13)]

    def block(hole: float, low: float, high: float) -> Mesh:
        solid = solids.Manifold.cube((50, 40, high - low)).translate((-25, -20, low))
        for x, y in places:
            solid -= solids.Manifold.cylinder(108, hole, hole, 48).translate((x, y, -9))
        mesh = solid.to_mesh()
        return np.asarray(mesh.vert_properties, dtype=float)[:, :3] / 1000, np.asarray(mesh.tri_verts).astype(np.int64)

    bolt = plain(hardware.hex_bolt(0.006, 0.07, USUAL))
    parts = {
        "base": block(3.0, -8, 0),
        "lower": block(3.3, 0, 25),
        "upper": block(3.3, 25, 50),
        "top": block(3.3, 50, 58),
        **{f"bolt {n}": (bolt[0] + 1e-3 * np.array([x, y, 58]), bolt[1]) for n, (x, y) in enumerate(places)},
    }
    task = feeler.task(feeler.Scene(mockup_of(parts)), "lower", keep="base")
    assert len(task.steps) == 5 and steps(task)[-1] == ("take out", ("lower",)), steps(task)
    assert task.bound == pytest.approx(task.seconds)


def night(meshes: dict[str, Mesh], entry: str, previous: feeler.Maintenance | None = None) -> feeler.Maintenance:
    """With corners in single precision, as many files have them."""
    rounded = {name: (vertices.astype(np.float32).astype(float), faces) for name, (vertices, faces) in meshes.items()}
    return feeler.maintain(feeler.Scene(mockup_of(rounded)), [entry], previous=previous, threads=1)


@pytest.mark.parametrize("entry", ["unit", "unit/*"])
def test_a_row_of_an_assembly_is_compared_when_it_has_a_part_more(entry: str) -> None:
    """One more bolt, in the assembly itself."""

    def unit(count: int) -> dict[str, Mesh]:
        bolt, hole, tapped = plain(hardware.hex_bolt(0.008, 0.02, USUAL)), ring(CLEAR, -0.01, 0.0), FITTED
        places = [0.05 * n for n in range(3)]
        return {
            "base": joined(*(moved(ring(tapped, -0.03, -0.01), x) for x in places)),
            "unit/cover": joined(*(moved(hole, x) for x in places)),
            **{f"unit/bolt {n}": moved(bolt, places[n]) for n in range(count)},
        }

    first = night(unit(2), entry)
    (row,) = night(unit(3), entry, first)
    assert row.is_slower and row.change.startswith("+") and "unit/bolt 2" in [each.path for each in row.causes]
    (back,) = night(unit(2), entry, night(unit(3), entry))
    assert back.change.startswith("-") and not back.is_slower
    (other,) = night(unit(2), "unit/cover", first)
    assert other.change == "new in the list"


def test_a_bolt_that_is_turned_holds_no_other_otherwise() -> None:
    """Bolts of one shape are aligned to one of them."""
    bolt, hole, tapped = (
        plain(hardware.hex_bolt(0.008, 0.02, USUAL)),
        ring(CLEAR, -0.01, 0.0),
        ring(FITTED, -0.03, -0.01),
    )
    cosine, sine = np.cos(0.3), np.sin(0.3)
    turned = bolt[0] @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]).T, bolt[1]
    parts = {"base": tapped, "cover": hole, "bolt 1": bolt}
    both = {name: joined(mesh, moved(mesh, 0.05)) for name, mesh in parts.items() if name != "bolt 1"}
    before = night({"bolt 1": bolt, "bolt 2": moved(bolt, 0.05), **both}, "cover")
    after = night({"bolt 1": turned, "bolt 2": moved(bolt, 0.05), **both}, "cover", before)
    assert [str(change) for change in after.changes] == ["bolt 1 moved"]


@pytest.mark.parametrize("least", [7.0, 8.0])
def test_a_nut_with_a_conical_seat_leaves_away_from_its_cone(least: float) -> None:
    """A wheel nut: its narrow end is in the wheel, its hexagon outside."""
    solids = pytest.importorskip("manifold3d")

    def cone(low: float, high: float, radius: float, wider: float | None = None, sides: int = 48) -> Any:
        solid = solids.Manifold.cylinder(high - low, radius, radius if wider is None else wider, sides)
        return solid.translate((0, 0, low))

    slope = np.sqrt(3.0)  # of a seat of 60 degrees, which ends on the face of the wheel
    foot = 10.0 - (9.5 - least) * slope
    hexagonal = cone(9.8, 24, 19 / np.sqrt(3), sides=6) ^ cone(9.8, 24, 15, 9)
    made = {
        "hub": cone(-12, 0, 60) - cone(-13, 1, 12.02 / 2),
        "wheel": cone(0, 10, 80) - cone(-1, 11, 6.75) - cone(10 - 2.75 * slope, 10.0 + 0.1 * slope, 6.75, 9.6),
        "stud": cone(-12, 34, 6.0) + cone(-16, -12, 9),
        "nut": hexagonal + cone(foot + 0.2, 9.9, least, least + (9.7 - foot) / slope) - cone(-5, 40, 6.02),
    }
    meshes = {name: solid.to_mesh() for name, solid in made.items()}
    parts = {
        name: (np.asarray(mesh.vert_properties, dtype=float)[:, :3] / 1000, np.asarray(mesh.tri_verts).astype(np.int64))
        for name, mesh in meshes.items()
    }
    for seed in range(3):
        task = feeler.task(feeler.Scene(tilted(parts, seed)), "wheel", keep="hub")
        assert steps(task) == [("undo", ("nut",)), ("take out", ("wheel",))], task.blocked
        assert task.bound == pytest.approx(task.seconds)
