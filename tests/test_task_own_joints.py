"""Fasteners of one part alone, and nuts on threads that are drawn with their part: what is undone, and for how long."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shapes import Mesh
from test_holding import tilted

import feeler

solids: Any = pytest.importorskip("manifold3d")


def cylinder(radius: float, low: float, high: float, sides: int = 24) -> Any:
    """About z, millimetres, as all here."""
    return solids.Manifold.cylinder(high - low, radius, radius, sides).translate((0, 0, low))


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Any:
    return solids.Manifold.cube(tuple(np.subtract(high, low).tolist())).translate(low)


def nut(low: float, radius: float = 4.02, height: float = 6.8, flats: float = 13.0) -> Any:
    body = cylinder(flats / np.sqrt(3.0), low, low + height, 6)
    return body - cylinder(radius, low - 1, low + height + 1)


def bolt(length: float) -> Any:
    """M8, with its head on z = 0."""
    return cylinder(13 / np.sqrt(3), 0, 5.3, 6) + cylinder(4, -length, 0.01)


def meshes(parts: dict[str, Any]) -> dict[str, Mesh]:
    """In metres."""
    found = {}
    for name, solid in parts.items():
        mesh = solid.to_mesh()
        vertices = np.asarray(mesh.vert_properties, dtype=float)[:, :3] / 1000
        found[name] = vertices, np.asarray(mesh.tri_verts).astype(np.int64)
    return found


def steps(task: feeler.Task) -> list[tuple[str, str]]:
    return [(step.verb, step.paths[0]) for step in task.steps]


@pytest.mark.parametrize("is_flat", [False, True])
def test_a_pinch_bolt_with_a_nut_in_a_groove_is_undone(is_flat: bool) -> None:
    """It clamps the yoke alone, and would leave with it."""

    def across(solid: Any) -> Any:
        return solid.rotate((-90, 0, 0)).translate((10.5, 0, 15))

    yoke = cylinder(14, 0, 30) + block((0, -12, 0), (24, 12, 30)) - cylinder(9.02, -1, 31)
    groove = block((6.3, -20, 9), (20, 20, 21)) if is_flat else across(cylinder(4.2, -30, 30))
    parts = {
        "shaft": cylinder(9, -60, 40) - groove,
        "yoke": yoke - across(cylinder(4.5, -40, 40)),
        "bolt": across(bolt(36).translate((0, 0, 12))),
        "nut": across(nut(-18.8)),
    }
    task = feeler.task(feeler.Scene(tilted(meshes(parts), int(is_flat))), "yoke", keep="shaft")
    assert steps(task)[:1] in ([("undo", "bolt")], [("undo", "nut")]), task.blocked
    assert steps(task)[-1] == ("take out", "yoke") and task.bound == pytest.approx(task.seconds)


def on_a_foot(out: float) -> dict[str, Any]:
    """A plate under a nut, on a thread that stands out by some millimetres beyond it."""
    plate = block((-25, -25, 0), (25, 25, 10)) - cylinder(4.5, -1, 11)
    return {
        "plate": plate,
        "nut": nut(10),
        "stud": cylinder(4, -15, 16.8 + out),
        "foot": block((-30, -30, -20), (30, 30, 0)),
    }


@pytest.mark.parametrize("out", [0.0, 1.0, 10.0, 30.0])
def test_a_thread_in_one_piece_with_its_part_is_as_long_as_a_stud(out: float) -> None:
    parts = on_a_foot(out)
    apart = {**parts, "foot": parts["foot"] - cylinder(4.01, -15.01, 1)}
    whole = {name: each for name, each in {**parts, "foot": parts["foot"] + parts["stud"]}.items() if name != "stud"}
    strokes = []
    for seed, some in enumerate((whole, apart)):
        task = feeler.task(feeler.Scene(tilted(meshes(some), seed)), "nut", keep="foot")
        assert steps(task) == [("undo", "nut")], task.blocked
        strokes.append(task.steps[0].strokes)
    assert strokes[0] == strokes[1] == np.ceil((6.8 + out) / 1.25 * 6.0)


@pytest.mark.parametrize("room", [10.0, 40.0])
def test_a_nut_needs_room_for_all_of_its_thread(room: float) -> None:
    """A knob is on a neck above it."""
    parts = on_a_foot(6.0)
    parts["foot"] += parts.pop("stud") + cylinder(2.5, 16.7, 130)
    parts["knob"] = cylinder(12, 16.8 + room, 126) - cylinder(2.52, 0, 131)
    task = feeler.task(feeler.Scene(tilted(meshes(parts), 1)), "nut", keep=["foot", "knob"])
    assert task.is_found == (room == 40.0), steps(task)
    assert task.is_found or task.blocked[0].blockers == ("knob",)


@pytest.mark.parametrize(("end", "head"), [(26.0, None), (-12.0, None), (26.0, 19.0)])
def test_a_jam_nut_holds_nothing_and_its_screw_is_in_the_part(end: float, head: float | None) -> None:
    """An adjusting screw with a slot, at its nut or at its tip, or with a head: its thread of 12 mm is in a lever."""
    screw = cylinder(4, -12, 26)
    if head is None:
        screw -= block((-0.6, -10, end - 2), (0.6, 10, end + 2))
    else:
        screw += cylinder(13 / np.sqrt(3), 26, 31, 6)
    parts = {
        "lever": block((-40, -10, 0), (12, 10, 12)) - cylinder(4.01, -1, 13),
        "screw": screw,
        "jam nut": nut(12),
        "block": block((-60, -20, -40), (-41, 20, 40)),
    }
    scene = feeler.Scene(tilted(meshes(parts), 2))
    held = {row.path: row for row in feeler.holds(scene)}
    assert (held["screw"].paths, held["screw"].anchor_path) == (("screw",), "lever"), held["screw"].because
    assert (held["jam nut"].paths, held["jam nut"].anchor_path) == (("jam nut",), "screw"), held["jam nut"].because
    task = feeler.task(scene, "screw", keep=["lever", "block"])
    assert task.is_found, task.blocked
    assert task.steps[-1].strokes >= 12 / 1.25 * 6
    through = {**parts, "lever": parts["lever"] - cylinder(4.5, -1, 13)}
    assert {row.path: row for row in feeler.holds(tilted(meshes(through), 1))}["jam nut"].anchor_path == "screw"


@pytest.mark.parametrize("has_washer", [False, True])
def test_a_nut_on_a_spindle_with_two_flats_holds_the_lever_under_its_washer(has_washer: bool) -> None:
    """Their holes are no wider than the flats, which end flush with the washer: nothing else is in the bore."""

    def flattened(radius: float, half: float, low: float, high: float) -> Any:
        return cylinder(radius, low, high) ^ block((-half, -9, low), (half, 9, high))

    top = 16.0 if has_washer else 14.0
    parts = {
        "body": block((-30, -25, -50), (30, 25, 0)) - cylinder(6.05, -40, 1),
        "spindle": cylinder(6, -39, 8) + flattened(4.6, 3.2, 7.9, top) + cylinder(3, top - 0.1, top + 10),
        "lever": block((-8, -9, 10), (90, 9, 14)) - flattened(4.65, 3.25, 9, 15),
        "nut": nut(top, 3.02, 5.2, 10.0),
    }
    if has_washer:
        parts["washer"] = cylinder(8, 14, 16) - flattened(4.65, 3.25, 13, 17)
    for seed in range(2):
        (row,) = feeler.holds(tilted(meshes(parts), seed))
        washers = (list(parts).index("washer"),) if has_washer else ()
        assert (row.paths, row.anchor_path, row.washers) == (("lever",), "spindle", washers), row


@pytest.mark.parametrize(("hole", "is_fitting"), [(7.25, False), (7.02, True)])
def test_a_fitting_in_a_wide_hole_is_held_by_its_nut(hole: float, is_fitting: bool) -> None:
    fitting = cylinder(7, -30, 30) + cylinder(19 / np.sqrt(3), -6, 0, 6) - cylinder(4, -40, 40)
    parts = {
        "wall": block((-40, -40, 0), (40, 40, 4)) - cylinder(hole, -1, 5),
        "bulkhead union": fitting,
        "nut": nut(4, 7.02, 6, 19),
    }
    rows = {row.path: row for row in feeler.holds(tilted(meshes(parts), 1))}
    assert rows["nut"].paths == ("wall",) and rows["nut"].anchor_path == "bulkhead union"
    assert ("bulkhead union" in rows) == is_fitting, rows


@pytest.mark.parametrize("is_touching", [True, False])
def test_a_nut_holds_what_is_under_the_shoulder_of_a_grommet(is_touching: bool) -> None:
    """A cover that the stud and the nut are clear of."""
    gap = 0.0 if is_touching else 1.0
    cover = block((-30, -30, 0), (30, 30, 30)) - block((-26, -26, -1), (26, 26, 27)) - cylinder(7 + gap, 20, 31)
    grommet = cylinder(7, 27, 30.1) + cylinder(10, 30 + gap, 33 + gap) - cylinder(4.5, 20, 40)
    parts = {
        "base": block((-30, -30, -30), (30, 30, 0)) - cylinder(4.01, -20, 1),
        "cover": cover,
        "stud": cylinder(4, -20, 46),
        "grommet": grommet + cylinder(7, 30, 30.5 + gap) - cylinder(4.5, 20, 40),
        "nut": nut(33 + gap),
    }
    for seed in range(2):
        rows = {row.path: row for row in feeler.holds(tilted(meshes(parts), seed))}
        expected = {"grommet", "cover"} if is_touching else {"grommet"}
        assert set(rows["nut"].paths) == expected, rows["nut"]


def plain_washer(across: float, thick: float, hole: float) -> Any:
    return cylinder(across / 2, -thick, 0, 32) - cylinder(hole / 2, -thick - 1, 1, 32)


@pytest.mark.parametrize(("across", "thick", "sunk"), [(16.0, 1.6, 0.0), (24.0, 2.0, 0.0), (28.0, 3.0, 0.4)])
def test_washers_of_long_bolts_are_washers_in_any_pose(across: float, thick: float, sunk: float) -> None:
    """Also large ones, and those that are drawn a little into their head."""
    low = sunk - thick
    parts = {
        "head": block((-20, -20, low - 90), (20, 20, low)) - cylinder(4.5, low - 91, low + 1),
        "case": block((-20, -20, low - 130), (20, 20, low - 90)) - cylinder(4, low - 115, low - 89),
        "washer": plain_washer(across, thick, 8.4).translate((0, 0, sunk)),
        "bolt": bolt(110 - low),
    }
    for seed in range(6):
        (row,) = feeler.holds(tilted(meshes(parts), seed))
        assert (row.paths, [row.washers, row.anchor_path]) == (("head",), [(2,), "case"]), seed


def test_a_square_pad_with_a_hole_is_no_nut() -> None:
    def pad(low: float) -> Any:
        return block((-14, -14, low), (14, 14, low + 8)) - cylinder(4.5, low - 1, low + 9)

    parts = {"a": pad(-8), "b": pad(-16), "c": bolt(24), "d": nut(-22.8)}
    for seed in range(2):
        held = {row.path: row.paths for row in feeler.holds(tilted(meshes(parts), seed))}
        assert held == {"c": ("a", "b"), "d": ("a", "b")}


def test_a_plate_between_others_leaves_sideways_in_any_pose() -> None:
    """Its holes are as wide as those of the plate above: the rims lie on each other, and cross by rounding."""
    ends = [(-30.0, 0.0), (30.0, 10.0), (0.0, -10.0)]
    holes = [cylinder(3.3, -60, 1).translate((x, y, 0)) for x, y in ends]
    stack = {"upper": (-8.0, 0.0), "plate": (-16.0, -8.0), "base": (-40.0, -16.0)}
    parts = {name: block((-50, -30, low), (50, 30, high)) for name, (low, high) in stack.items()}
    for hole in holes:
        parts = {name: solid - hole for name, solid in parts.items()}
    times = []
    for seed in range(5):
        task = feeler.task(feeler.Scene(tilted(meshes(parts), seed)), "plate")
        assert steps(task) == [("take out", "plate")], seed
        times.append(task.seconds)
    assert times == pytest.approx([times[0]] * len(times))


def halves_on_a_wall() -> dict[str, Any]:
    """A pipe along x in a clamp of two halves, of which two screws below the pipe fasten the lower to a wall."""
    pipe = (cylinder(10, -60, 60, 48) - cylinder(8, -61, 61, 48)).rotate((0, 90, 0))
    bore = cylinder(10.02, -20, 20, 48).rotate((0, 90, 0))
    lower = block((-12, -30, -25), (12, 30, -0.5)) - bore
    upper = block((-12, -30, 0.5), (12, 30, 16)) - bore
    wall = block((-40, -60, -40), (40, 60, -25))
    parts: dict[str, Any] = {"pipe": pipe}
    for number, y in enumerate((-22.0, 22.0)):
        lower -= cylinder(3, -26, 1).translate((0, y, 0))
        upper -= cylinder(3.3, 0, 17).translate((0, y, 0))
        parts[f"bolt_{number}"] = (cylinder(5, 16, 22, 6) + cylinder(3, -10, 16.1)).translate((0, y, 0))
    for number, x in enumerate((-6.0, 6.0)):
        lower -= (cylinder(1.7, -26, 0) + cylinder(3.2, -14, 0)).translate((x, 0, 0))
        wall -= cylinder(1.5, -36, -24).translate((x, 0, 0))
        screw = cylinder(2.75, -14, -11) + cylinder(1.5, -34, -13.9) - cylinder(1.4, -12.5, -10, 6)
        parts[f"wall_screw_{number}"] = screw.translate((x, 0, 0))
    return {**parts, "clamp_upper": upper, "clamp_lower": lower, "wall": wall}


def test_screws_of_half_a_clamp_do_not_hold_the_pipe() -> None:
    scene = feeler.Scene(tilted(meshes(halves_on_a_wall()), 3))
    held = {row.path: row.paths for row in feeler.holds(scene)}
    assert held["bolt_0"] == ("clamp_upper", "pipe") and held["wall_screw_0"] == ("clamp_lower",), held
    task = feeler.task(scene, "pipe")
    assert steps(task)[:2] == [("undo", "bolt_0"), ("undo", "bolt_1")], task.blocked
    assert steps(task)[-1] == ("take out", "pipe")


@pytest.mark.parametrize("open_deg", [180, 120])
def test_a_pipe_lies_in_half_a_clamp_and_is_held_by_a_clip(open_deg: int) -> None:
    """Half a clamp without screws and without its other half holds nothing; a clip that is open less springs."""
    rise = 30.0 * float(np.tan(np.radians(90.0 - 0.5 * open_deg)))
    mouth = solids.CrossSection([[(0.0, 0.0), (30.0, rise), (30.0, 60.0), (-30.0, 60.0), (-30.0, rise)]])
    shell = cylinder(14, -20, 20, 48) - cylinder(10.02, -21, 21, 48) - mouth.extrude(60).translate((0, 0, -30))
    parts = {
        "pipe": (cylinder(10, -60, 60, 48) - cylinder(8, -61, 61, 48)) + (cylinder(14, 50, 60) - cylinder(8, 49, 61)),
        "clamp_lower": shell,
        "lump": block((100, 100, 100), (110, 110, 110)),
    }
    for seed in range(2):
        scene = feeler.Scene(tilted(meshes(parts), seed))
        held = {row.path: row.paths for row in feeler.holds(scene)}
        assert held == ({} if open_deg == 180 else {"clamp_lower": ("pipe",)})
    if open_deg == 180:
        assert steps(feeler.task(scene, "pipe")) == [("take out", "pipe")]


def test_a_kept_clamp_leaves_with_nothing() -> None:
    parts = {name: each for name, each in halves_on_a_wall().items() if name != "wall" and "screw" not in name}
    task = feeler.task(feeler.Scene(tilted(meshes(parts), 4)), "pipe", keep="clamp_lower")
    assert task.is_found, task.blocked
    assert all("clamp_lower" not in step.paths for step in task.steps)


def test_what_a_kept_fastener_is_screwed_into_stays_with_it() -> None:
    """A set screw in a hub, a stud in its foot, and a washer, which its nut leaves behind."""
    hub = (
        cylinder(20, 0, 20, 48)
        - cylinder(8, -1, 21, 48)
        - cylinder(2.5, 0, 30).rotate((0, 90, 0)).translate((0, 0, 10))
    )
    shaft = cylinder(8, -40, 60, 48) - block((7, -5, 5), (9, 5, 15))
    screw = (cylinder(2.5, 7, 14) - cylinder(1.3, 11, 15, 6)).rotate((0, 90, 0)).translate((0, 0, 10))
    kept = feeler.task(
        feeler.Scene(tilted(meshes({"hub": hub, "shaft": shaft, "set screw": screw}), 1)), "hub", keep="set screw"
    )
    assert not kept.is_found and kept.blocked[0].because == "a fastener that holds it is kept"
    parts = on_a_foot(8.0)
    parts["washer"] = (cylinder(8, 10, 11.6) - cylinder(4.2, 9, 12)).translate((0, 0, 0))
    parts["nut"] = parts["nut"].translate((0, 0, 1.6))
    parts["foot"] -= cylinder(4.01, -15.01, 1)
    scene = feeler.Scene(tilted(meshes(parts), 2))
    assert not feeler.task(scene, "foot", keep="stud").is_found
    loose = feeler.task(scene, "nut", keep=["washer", "foot"])
    assert steps(loose) == [("undo", "nut")] and loose.steps[0].paths == ("nut",)


def keyed() -> dict[str, Any]:
    """A hub on a shaft with a parallel key in a closed keyway."""
    slot = block((-4.02, 8.5, -10.02), (4.02, 20, 10.02))
    shaft = cylinder(12.5, -50, 40, 64) + cylinder(18, -50, -12, 64) - slot
    hub = cylinder(25, -11.98, 12, 64) - cylinder(12.52, -20, 20, 64) - block((-4.02, 0, -20), (4.02, 15.8, 20))
    return {"shaft": shaft, "key": block((-4, 8.52, -10), (4, 15.5, 10)), "hub": hub}


def test_a_key_is_taken_out_of_its_shaft_not_with_it() -> None:
    for seed in range(2):
        scene = feeler.Scene(tilted(meshes(keyed()), seed))
        assert [step.paths for step in feeler.task(scene, "key").steps] == [("hub",), ("key",)]
        assert [step.paths for step in feeler.task(scene, "shaft").steps] == [("shaft", "key")]
    stays = feeler.task(scene, "key", keep="hub")
    assert [step.paths for step in stays.steps] == [("shaft", "key")]
    assert stays.notes[0] == "'key' leaves together with 'shaft': take it out of that."
