"""Captive screws, thick and round nuts, and hose clamps in one piece: what they hold, and how parts come out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shapes import Mesh, box, joined, prism_ring
from test_holding import FINE, USUAL, at, nut, only, plain, ring, tilted, union_nut

import feeler
from feeler.samples import hardware
from feeler.samples.shapes import skin_loops
from feeler.samples.tessellation import Tolerance, circle, hexagon
from feeler.tasks import fixings
from feeler.tasks.captive import free_travel
from feeler.tasks.times import Arithmetic, Times

COARSE = Tolerance(3e-4)
LUMP = box((0.2, 0.0, 0.0), (0.21, 0.01, 0.01))
"""Another part, so that not all that is left leaves."""


def moved(mesh: Mesh, x: float) -> Mesh:
    return mesh[0] + np.array([x, 0.0, 0.0]), mesh[1]


def captive_cover(
    thread: float, hole: float = 0.0026, tapped: float = 0.00302, tolerance: Tolerance = USUAL, pocket: float = 0.005
) -> dict[str, Mesh]:
    """A cover of 6 mm under two captive screws, which are 5 mm free before they meet it. thread: how long it is;
    pocket: the radius of the hole above it."""
    tip = -0.006 - thread
    outline = [[1e-5, tip], [0.003, tip], [0.003, -0.005], [0.0024, -0.005], [0.0024, 0.00604], [0.0045, 0.00604]]
    screw = plain(hardware.revolve(np.array([*outline, [0.0045, 0.01], [1e-5, 0.01]]), tolerance))
    hole_ring = ring(hole, 0.00002, 0.006, 0.02, tolerance)
    tapped_ring = joined(ring(tapped, tip - 0.005, -0.006, 0.02, tolerance), ring(pocket, -0.006, 0.0, 0.02, tolerance))
    places = (-0.03, 0.03)
    return {
        "base": joined(*(moved(tapped_ring, x) for x in places)),
        "cover": joined(*(moved(hole_ring, x) for x in places)),
        **{f"captive screw {n}": moved(screw, x) for n, x in enumerate(places)},
        "lump": LUMP,
    }


def verbs(task: feeler.Task) -> list[tuple[str, tuple[str, ...]]]:
    return [(step.verb, tuple(sorted(step.paths))) for step in task.steps]


@pytest.mark.parametrize("tapped", [0.00302, 0.0026])
def test_a_captive_screw_is_pushed_back_and_leaves_with_its_cover(tapped: float) -> None:
    for seed, tolerance in enumerate((USUAL, COARSE)):
        mockup = tilted(captive_cover(0.003, tapped=tapped, tolerance=tolerance), seed)
        task = feeler.task(feeler.Scene(mockup), "cover")
        screws = [("disconnect", ("captive screw 0",)), ("disconnect", ("captive screw 1",))]
        assert verbs(task) == [*screws, ("take out", ("captive screw 0", "captive screw 1", "cover"))], task.blocked
        for step in task.steps[:2]:
            drawn = float(np.linalg.norm(step.way[-1][:3, 3] - step.way[0][:3, 3]))
            assert 0.003 < drawn < 0.005


@pytest.mark.parametrize("pocket", [0.0034, 0.0038, 0.0044])
def test_a_thread_begins_at_the_floor_of_a_narrow_pocket(pocket: float) -> None:
    (_, _, last) = feeler.task(feeler.Scene(tilted(captive_cover(0.003, pocket=pocket), 2)), "cover").steps
    assert sorted(last.paths) == ["captive screw 0", "captive screw 1", "cover"]


@pytest.mark.parametrize("is_above", [True, False])
def test_a_screw_is_captive_in_the_narrow_one_of_two_parts(is_above: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """What its thread meets is asked of each part, and once for all plans of a mock-up."""
    asked = []

    def counted(*given: Any) -> float | None:
        asked.append(given)
        return free_travel(*given)

    monkeypatch.setattr(fixings, "free_travel", counted)
    parts = captive_cover(0.003)
    holes = {
        "upper": (0.0026 if is_above else 0.0034, 0.003, 0.006),
        "lower": (0.0034 if is_above else 0.0026, 2e-5, 0.003),
    }
    del parts["cover"]
    for name, (hole, low, high) in holes.items():
        parts[name] = joined(*(moved(ring(hole, low, high), x) for x in (-0.03, 0.03)))
    mockup = tilted(parts, 3)
    rows = feeler.find_fasteners(mockup)
    for _ in range(3):
        scene = feeler.Scene(mockup)
        found = fixings.Fixings(scene, rows, feeler.holds(scene, rows), Arithmetic(Times()))
        captive = {mockup.part_names[part]: found.captive_on(part) for part in found}
        narrow = mockup.part_names.index("upper" if is_above else "lower")
        assert captive == {"captive screw 0": narrow, "captive screw 1": narrow}
    assert len(asked) == 4


def test_a_captive_screw_stays_in_a_cover_that_stays() -> None:
    task = feeler.task(feeler.Scene(tilted(captive_cover(0.003), 1)), "base", keep="cover")
    assert [step.verb for step in task.steps] == ["disconnect", "disconnect", "take out"]
    assert task.steps[-1].paths == ("base",)


def test_a_captive_screw_that_meets_its_cover_before_its_thread_is_out_is_blocked() -> None:
    task = feeler.task(feeler.Scene(tilted(captive_cover(0.008), 1)), "cover")
    assert not task.is_found and "axis" in task.blocked[0].because


def test_a_screw_with_a_neck_comes_out_of_a_wide_hole() -> None:
    task = feeler.task(feeler.Scene(tilted(captive_cover(0.003, hole=0.0032), 1)), "cover")
    assert [step.verb for step in task.steps] == ["undo", "undo", "take out"]


@pytest.mark.parametrize("flats", [0.008, 0.017, 0.024])
@pytest.mark.parametrize("bore", [0.0025, 0.00252])
def test_a_thick_nut_is_on_the_rod_in_its_bore(flats: float, bore: float) -> None:
    rod = joined(ring(1e-5, -0.013, 0.0101, 0.0025, FINE), box((-0.006, -0.006, 0.0101), (0.06, 0.006, 0.016)))
    parts = {
        "plate": ring(0.0028, 0.0, 0.01),
        "lever": rod,
        "nut": union_nut(flats, bore, bore, -0.00904, -0.005, -0.00004),
        "lump": LUMP,
    }
    for seed in range(2):
        mockup = tilted(parts, seed)
        row = only(feeler.holds(mockup), "nut")
        assert (row.paths, row.anchor_path) == (("plate",), "lever"), (seed, row.because)
        (found,) = feeler.find_fasteners(mockup)
        assert found.drive == "hexagon" and abs(found.size - 2.0 * bore) < 1e-5
    assert verbs(feeler.task(feeler.Scene(tilted(parts, 1)), "plate"))[0] == ("undo", ("nut",))
    # Without such a name it may as well be a spacer.
    assert len(feeler.find_fasteners(tilted({"spacer": parts["nut"]}, 1))) == (flats == 0.008)


def test_a_round_nut_is_as_wide_as_its_bore_and_sees_nothing_beside_it() -> None:
    """Sunk in a plate: rays into its bore begin in it, and not in the plate around it."""
    parts = {
        "plate": joined(ring(0.0028, 0.0, 0.01, 0.03), ring(0.0086, -0.012, 0.0, 0.03)),
        "lever": joined(ring(1e-5, -0.013, 0.0101, 0.0025, FINE), box((-0.006, -0.006, 0.0101), (0.06, 0.006, 0.016))),
        "nut": ring(0.00252, -0.00904, -0.00004, 0.0085),
        "lump": LUMP,
    }
    for seed in range(2):
        mockup = tilted(parts, seed)
        (found,) = feeler.find_fasteners(mockup)
        row = only(feeler.holds(mockup), "nut")
        assert abs(found.size - 0.00504) < 1e-5 and found.length == pytest.approx(0.009)
        assert (row.paths, row.anchor_path) == (("plate",), "lever"), (seed, row.because)


def hose_clamp(tight: float, slit: float, closed: bool = True) -> dict[str, Mesh]:
    """A hose on a spigot under a clamp about y, whose ears are above and below a slit, with a screw along z."""
    about_y = at(x=-0.0178, z=-0.0058) @ np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])

    def pipe(inner: float, low: float, high: float, outer: float) -> Mesh:
        return plain(hardware.ring(inner, outer, high - low, USUAL), about_y @ at(z=low))

    ears = [ring(0.0022, -0.005, 0.0, 0.004, USUAL), ring(tight, -0.0105, -0.005 - slit, 0.004, USUAL)]
    return {
        "spigot": joined(pipe(0.008, -0.03, 0.03, 0.01), pipe(0.008, 0.03, 0.05, 0.04)),
        "hose": pipe(0.01002, -0.03, 0.029, 0.013),
        "hose clamp": joined(pipe(0.01303, -0.005, 0.005, 0.0145), *ears),
        **({"clamp screw": plain(hardware.hex_bolt(0.004, 0.012, USUAL))} if closed else {}),
        "lump": LUMP,
    }


@pytest.mark.parametrize("tight", [0.002, 0.00201, 0.0022])
def test_the_screw_of_a_hose_clamp_holds_the_clamp_and_the_hose(tight: float) -> None:
    """In one piece, with the thread in its second ear, or with a clearance hole in both."""
    for seed, slit in enumerate((0.0008, 0.0016, 0.0016)):
        mockup = tilted(hose_clamp(tight, slit), seed)
        row = only(feeler.holds(mockup), "clamp screw")
        assert row.paths == ("hose clamp", "hose"), row.because
        assert row.anchor_path == ("" if tight == 0.0022 else "hose clamp")
    for wanted in ("hose", "spigot"):
        task = feeler.task(feeler.Scene(mockup), wanted)
        assert verbs(task)[0] == ("undo", ("clamp screw",)), verbs(task)
        assert task.steps[-1].paths[0] == wanted


def test_a_clamp_that_springs_goes_before_its_hose() -> None:
    task = feeler.task(feeler.Scene(tilted(hose_clamp(0.0022, 0.001, closed=False), 3)), "hose")
    assert verbs(task) == [("take out", ("hose clamp",)), ("take out", ("hose",))]


def test_a_plug_in_a_part_that_is_no_clamp_holds_itself() -> None:
    parts = hose_clamp(0.002, 0.001)
    row = only(
        feeler.holds(tilted({"body": parts["hose clamp"], "screw": parts["clamp screw"], "lump": LUMP}, 1)), "screw"
    )
    assert row.paths == ("screw",) and row.anchor_path == "body"


def test_a_nut_of_usual_size_is_found_as_before() -> None:
    (found,) = feeler.find_fasteners(tilted({"part 1": nut(0.0)}, 1))
    assert found.kind == "nut" and found.confidence == 0.9


def long_nut(height: float) -> Mesh:
    """M8, 13 mm across flats, from z = 0 up."""
    loops = [hexagon(0.013, 0.0), hexagon(0.013, height), circle(0.00402, 32, height), circle(0.00402, 32, 0.0)]
    return plain(skin_loops(loops, closed=True))


def hung(joint: Mesh, name: str, low: float, *more: tuple[str, Mesh]) -> dict[str, Mesh]:
    """A rod in a ceiling, up to z = `low`, and a nut on it."""
    ceiling = ring(0.00401, -0.07, -0.05, 0.03)
    return {"ceiling": ceiling, "rod": prism_ring(0.004, 0.0, 48, -0.065, low), name: joint, **dict(more)}


@pytest.mark.parametrize(
    ("height", "name", "off", "gap"),
    [
        (0.024, "coupling nut", -0.001, 0.001),
        (0.024, "part 4", 0.002, 0.001),
        (0.03, "coupling nut", 0.0, 0.0),
        (0.03, "part 4", -0.001, 0.002),
    ],
)
def test_a_long_nut_joins_two_rods(height: float, name: str, off: float, gap: float) -> None:
    """The wanted rod is not drawn out of it; off: where the rods meet, from its middle."""
    meet = 0.5 * height + off
    wanted = ("wanted", prism_ring(0.004, 0.0, 48, meet + gap, 0.09))
    parts = hung(long_nut(height), name, meet, wanted)
    found = {}
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        row = only(feeler.holds(scene), name)
        assert set(row.paths) == {"rod", "wanted"} and row.because.startswith("it joins"), row.because
        task = feeler.task(scene, "wanted", keep="ceiling")
        assert verbs(task) == [("undo", (name,)), ("take out", ("wanted",))], task.blocked
        # It is turned off one of the rods, not along a whole one.
        assert task.steps[0].strokes < 6 * 1e3 * height / 1.25
        found[task.steps[0].strokes, task.seconds, task.bound] = seed
    assert len(found) == 1


def test_studs_by_name_in_a_long_nut_have_one_plan_in_any_pose() -> None:
    wanted = ("stud 2", prism_ring(0.004, 0.0, 48, 0.013, 0.09))
    parts = hung(long_nut(0.024), "coupling nut", 0.012, wanted)
    parts = {("stud 1" if name == "rod" else name): mesh for name, mesh in parts.items()}
    tasks = [feeler.task(feeler.Scene(tilted(parts, seed)), "stud 2", keep="ceiling") for seed in range(3)]
    assert all(verbs(task) == [("undo", ("coupling nut",)), ("take out", ("stud 2",))] for task in tasks)
    assert len({task.steps[0].strokes for task in tasks}) == 1


@pytest.mark.parametrize("low", [0.01, 0.014])
def test_a_bolt_in_a_long_nut_on_a_rod_is_undone(low: float) -> None:
    """It holds a plate, however far the rod is in the nut."""
    plate, head = ring(0.0045, 0.024, 0.028), plain(hardware.hex_bolt(0.008, 0.0135, USUAL), at(z=0.028))
    parts = hung(long_nut(0.024), "coupling nut", low, ("plate", plate), ("bolt", head))
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        assert only(feeler.holds(scene), "bolt").anchor_path == "coupling nut"
        task = feeler.task(scene, "plate", keep="ceiling")
        assert len(task.steps) == 2 and task.steps[0].verb == "undo", task.blocked


@pytest.mark.parametrize("name", ["barrel nut", "cross dowel"])
def test_a_barrel_nut_has_its_thread_across_it(name: str) -> None:
    """A panel under a screw, whose thread is in a cylinder in the shelf."""
    solids = pytest.importorskip("manifold3d")

    def rod(radius: float, low: float, high: float) -> Any:
        return solids.Manifold.cylinder(high - low, radius, radius, 32).translate((0, 0, low))

    def block(low: float, high: float, wide: float) -> Any:
        return solids.Manifold.cube((2 * wide, 2 * wide, high - low)).translate((-wide, -wide, low))

    def lain(solid: Any) -> Any:
        return solid.rotate((90, 0, 0)).translate((0, 0, -30))

    made = {
        "panel": block(0, 16, 30) - rod(3.25, -1, 17),
        "shelf": block(-100, 0, 10) - rod(3.5, -41, 1) - lain(rod(5.05, -20, 20)),
        name: lain(rod(5, -8, 8)) - rod(3.01, -40, -20),
    }
    meshes = {each: solid.to_mesh() for each, solid in made.items()}
    parts: dict[str, Mesh] = {
        each: (np.asarray(mesh.vert_properties, dtype=float)[:, :3] / 1000, np.asarray(mesh.tri_verts).astype(np.int64))
        for each, mesh in meshes.items()
    }
    parts["screw"] = plain(hardware.cap_screw(0.006, 0.05, USUAL), at(z=0.016))
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        row = only(feeler.holds(scene), "screw")
        assert row.anchor_path == name and "panel" in row.paths, row.because
        task = feeler.task(scene, "panel", keep="shelf")
        assert verbs(task) == [("undo", ("screw",)), ("take out", ("panel",))], task.blocked
        assert task.steps[0].strokes < 100  # 9 mm of M6 are in it, not 50 mm


@pytest.mark.parametrize("name", ["rivet nut", "T-nut", "part 4"])
def test_a_nut_that_is_pressed_into_a_sheet_stays_there(name: str) -> None:
    """Its front is flush, so that the plate lies on it too; its flange is behind the sheet."""
    outline = [(0.00202, 0.0), (0.00202, -0.006), (0.004, -0.006), (0.004, -0.0025), (0.003, -0.0025), (0.003, 0.0)]
    pressed = plain(skin_loops([circle(radius, 32, z) for radius, z in outline], closed=True))
    parts = {
        "wall": ring(0.00301, -0.0025, 0.0),
        "plate": ring(0.00225, 0.0, 0.005, 0.015),
        name: pressed,
        "screw": plain(hardware.cap_screw(0.004, 0.012, USUAL), at(z=0.005)),
    }
    for seed in range(2):
        scene = feeler.Scene(tilted(parts, seed))
        row = only(feeler.holds(scene), "screw")
        assert (row.paths, row.anchor_path) == (("plate",), name), row.because
        task = feeler.task(scene, "plate", keep="wall", seconds=5)
        assert verbs(task) == [("undo", ("screw",)), ("take out", ("plate",))], task.blocked
