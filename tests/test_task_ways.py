"""Tasks: ways in any pose, the shortest of them, bent ones, rings in grooves, the bound of several people, progress."""

from __future__ import annotations

import importlib
import math

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, box, joined, mockup_of

import feeler
from feeler.part_meshes import PartMeshes
from feeler.plan.frames import part_axes, scene_axes
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance
from feeler.tasks.pacing import Pace
from feeler.tasks.rings import ring_of, slippings

assemblies = importlib.import_module("tasks.assemblies")
judge = importlib.import_module("tasks.judge")

Floats = npt.NDArray[np.float64]
USUAL = Tolerance(1e-4)


def turn_of(seed: int) -> Floats:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def scene_of(parts: dict[str, Mesh], turn: Floats | None = None) -> feeler.Scene:
    turn = np.eye(3) if turn is None else turn
    return feeler.Scene(mockup_of({name: (corners @ turn.T, faces) for name, (corners, faces) in parts.items()}))


def ring(inner: float, low: float, high: float) -> Mesh:
    mesh = hardware.ring(inner, 0.02, high - low, USUAL)
    return mesh.vertices + np.array([0.0, 0.0, low]), mesh.faces.astype(np.int64)


def lathe(outline: list[tuple[float, float]], count: int = 48) -> Mesh:
    """A closed outline of radii and heights, turned about z."""
    turns = np.arange(count) * math.tau / count
    rows = np.array(outline)
    corners = np.stack([np.outer(np.cos(turns), rows[:, 0]), np.outer(np.sin(turns), rows[:, 0])], axis=-1)
    heights = np.broadcast_to(rows[:, 1], (count, len(rows)))
    faces = []
    for i in range(count):
        for k in range(len(rows)):
            a, b = i * len(rows) + k, i * len(rows) + (k + 1) % len(rows)
            c, d = ((i + 1) % count) * len(rows) + k, ((i + 1) % count) * len(rows) + (k + 1) % len(rows)
            faces += [[a, c, d], [a, d, b]]
    return np.concatenate([corners, heights[..., None]], axis=-1).reshape(-1, 3), np.array(faces)


def clip(inner: float, outer: float, low: float, high: float, open_deg: float = 30.0, count: int = 40) -> Mesh:
    """A flat ring about z, open towards +x."""
    half = math.radians(open_deg) / 2.0
    turns = np.linspace(half, math.tau - half, count)
    flat = np.concatenate([np.stack([r * np.cos(turns), r * np.sin(turns)], axis=1) for r in (inner, outer)])
    corners = np.concatenate([np.column_stack([flat, np.full(2 * count, z)]) for z in (low, high)])
    top, n = 2 * count, count
    faces = []
    for i in range(count - 1):
        j = i + 1
        faces += [[i, j, n + j], [i, n + j, n + i]]
        faces += [[top + i, top + n + j, top + j], [top + i, top + n + i, top + n + j]]
        faces += [[i, top + i, top + j], [i, top + j, j]]
        faces += [[n + i, n + j, top + n + j], [n + i, top + n + j, top + n + i]]
    for i, sign in ((0, 1), (count - 1, -1)):
        for face in ([i, n + i, top + n + i], [i, top + n + i, top + i]):
            faces.append(face[::sign])
    return corners, np.array(faces)


def shaft(end: float = 0.04) -> Mesh:
    """Of 20 mm, with a shoulder of 32 mm up to z = 10 mm and a groove of 19 mm at 30 mm."""
    heights = [
        (0.016, 0.0),
        (0.016, 0.01),
        (0.01, 0.01),
        (0.01, 0.03),
        (0.0095, 0.03),
        (0.0095, 0.0313),
        (0.01, 0.0313),
    ]
    return lathe([(0.0, 0.0), *heights, (0.01, end), (0.0, end)])


def geared(**more: Mesh) -> dict[str, Mesh]:
    """A gear on a shaft between its shoulder and a circlip."""
    gear = lathe([(0.0101, 0.01002), (0.03, 0.01002), (0.03, 0.02995), (0.0101, 0.02995)])
    return {"shaft": shaft(), "gear": gear, "circlip": clip(0.0096, 0.013, 0.03005, 0.03125), **more}


def hooded() -> dict[str, Mesh]:
    """A cover under a bolt, whose head is under a hood that is open along x, and a slab far above."""
    mesh = hardware.hex_bolt(0.008, 0.03, USUAL)
    walls = [box((-0.012, y, 0.0002), (0.012, y + 0.003, 0.02)) for y in (-0.012, 0.009)]
    return {
        "bolt": (mesh.vertices, mesh.faces.astype(np.int64)),
        "cover": ring(0.0045, -0.01, 0.0),
        "case": ring(0.0034, -0.04, -0.01005),
        "hood": joined(*walls, box((-0.012, -0.012, 0.02), (0.012, 0.012, 0.023))),
        "slab": box((-0.05, -0.05, 0.08), (0.05, 0.05, 0.085)),
    }


def test_an_assembly_in_any_pose_has_the_same_plan() -> None:
    answers = []
    for seed in (None, 1, 2, 3):
        scene = scene_of(hooded(), None if seed is None else turn_of(seed))
        task, kept = feeler.task(scene, "cover"), feeler.task(scene, "cover", keep=["slab", "case"])
        answers += [([step.paths for step in each.steps], each.seconds, each.bound) for each in (task, kept)]
    assert answers[0][0] == [("hood",), ("bolt",), ("cover",)]
    assert all(steps == answers[0][0] for steps, _, _ in answers)
    assert np.allclose([each[1:] for each in answers], answers[0][1:])


@pytest.mark.parametrize("seed", [5, 11])
def test_random_assemblies_have_the_same_plan_when_turned(seed: int) -> None:
    made = assemblies.random_assembly(seed)
    mockup, found = made.mockup(), []
    for turn in (np.eye(3), turn_of(seed)):
        corners = mockup.vertices @ turn.T + 0.3
        turned = feeler.Mockup(corners, mockup.faces, mockup.part_of_face, mockup.part_names)
        task = feeler.task(feeler.Scene(turned), made.wanted, assemblies.tools(), keep=sorted(made.keep))
        found.append((sorted(step.part for step in task.steps), round(task.seconds, 6), round(task.bound, 6)))
    assert found[0] == found[1]


def test_axes_of_parts_and_scenes_turn_with_them() -> None:
    parts, turn = hooded(), turn_of(4)
    for here, there in zip(_axes(scene_of(parts)), _axes(scene_of(parts, turn)), strict=True):
        assert len(here) == len(there) >= 2
        assert all(max(abs(float(turn @ one @ other)) for other in there) > 1.0 - 1e-6 for one in here)
    assert part_axes(np.zeros((3, 3, 3))) == []


def _axes(scene: feeler.Scene) -> list[list[Floats]]:
    meshes = PartMeshes(scene.mockup)
    return [scene_axes(scene), *(part_axes(meshes.corners(part)) for part in (3, 4))]


def test_a_round_gasket_leaves_sideways_in_any_pose() -> None:
    """Between the bolts of its flange, of which the one in its way goes first; nothing here has a side."""
    low, high = [(0.03, -0.02), (0.08, -0.02), (0.08, 0.0), (0.03, 0.0)], [(0.03, 0.0), (0.08, 0.0), (0.08, 0.02)]
    parts = {
        "low": lathe(low),
        "up": lathe([(r, z + 0.002) for r, z in [*high, (0.03, 0.02)]]),
        "gasket": lathe([(0.031, 0.00002), (0.045, 0.00002), (0.045, 0.00198), (0.031, 0.00198)]),
    }
    pin = lathe([(0.0, 0.0001), (0.004, 0.0001), (0.004, 0.0019), (0.0, 0.0019)], 12)
    for n in range(4):
        aside = 0.06 * np.array([math.cos(n * math.pi / 2 + 0.3), math.sin(n * math.pi / 2 + 0.3), 0.0])
        parts[f"pin_{n}"] = (pin[0] + aside, pin[1])
    for turn in (None, turn_of(1), turn_of(2)):
        task = feeler.task(scene_of(parts, turn), "gasket", keep=["low", "up"])
        assert [step.paths[-1] for step in task.steps][1:] == ["gasket"] and task.seconds == task.bound


@pytest.mark.parametrize("count", [16, 48])
def test_pins_leave_holes_of_their_diameter_in_any_pose(count: int) -> None:
    """Their facets are flush all around: by rounding some cross, as edges of any normal."""
    hole = [(0.003, 0.0), (0.02, 0.0), (0.02, 0.01), (0.003, 0.01)]
    parts = {
        "base": lathe(
            [(r, z - 0.0102) for r, z in [(0.0, -0.001), (0.02, -0.001), *hole[2:], (0.003, 0.001), (0.0, 0.001)]],
            count,
        ),
        "cover": lathe(hole, count),
        "pin": lathe([(0.0, -0.009), (0.003, -0.009), (0.003, 0.008), (0.0, 0.008)], count),
    }
    for seed in range(8):
        task = feeler.task(scene_of(parts, turn_of(seed)), "pin")
        assert [step.paths for step in task.steps] == [("pin",)], seed


def test_a_part_that_goes_up_and_then_sideways_needs_no_others_out() -> None:
    rim = [box((x, -0.03, 0.0), (x + 0.002, 0.03, 0.004)) for x in (-0.032, 0.03)]
    rim += [box((-0.03, y, 0.0), (0.03, y + 0.002, 0.004)) for y in (-0.032, 0.03)]
    parts = {
        "lid": box((-0.029, -0.029, 0.0001), (0.029, 0.029, 0.003)),
        "tray": joined(box((-0.032, -0.032, -0.01), (0.032, 0.032, 0.0)), *rim),
        "roof": box((-0.05, -0.05, 0.02), (0.05, 0.05, 0.03)),
    }
    task = feeler.task(scene_of(parts, turn_of(2)), "lid")
    assert [step.paths for step in task.steps] == [("lid",)] and task.bound == task.seconds
    assert len(task.steps[0].way) > 2 and "roof" not in task.steps[0].because
    kept = feeler.task(scene_of(parts), "lid", keep=["tray", "roof"])
    assert kept.is_found and len(kept.steps) == 1


def test_a_part_that_another_plan_leaves_in_place_has_a_bent_way() -> None:
    """The peg leaves upwards once the lid is out, which waits for a roof in its straight way; or downwards once the
    tray is out, which is quicker than roof and lid, but not than the lid alone."""
    rim = [box((x, -0.03, 0.0), (x + 0.002, 0.03, 0.004)) for x in (-0.032, 0.03)]
    rim += [box((-0.03, y, 0.0), (0.03, y + 0.002, 0.004)) for y in (-0.032, 0.03)]
    floor = [box((-0.032, -0.032, -0.02), (0.032, 0.032, -0.01)), box((-0.01, -0.032, -0.01), (0.032, 0.032, 0.0))]
    floor += [box((-0.032, -0.032, -0.01), (-0.02, 0.032, 0.0)), box((-0.02, -0.032, -0.01), (-0.01, 0.0, 0.0))]
    parts = {
        "tray": joined(*floor, box((-0.02, 0.01, -0.01), (-0.01, 0.032, 0.0)), *rim),
        "peg": box((-0.0199, 0.0001, -0.0099), (-0.0101, 0.0099, 0.0)),
        "lid": box((-0.029, -0.029, 0.0001), (0.029, 0.029, 0.003)),
        "roof": box((0.0, -0.05, 0.02), (0.05, 0.05, 0.03)),
    }
    task = feeler.task(scene_of(parts), "peg", times=feeler.Times(typed={"tray": [15.0, 1.0]}), threads=1)
    assert [step.part for step in task.steps] == ["lid", "peg"]
    assert task.bound == task.seconds


def pocket(lidded: bool) -> dict[str, Mesh]:
    """An insert in a pocket, below a lid and a bar, whose legs leave room for it beside them."""
    walls = [box((-0.06, -0.06, -0.02), (-0.012, 0.06, 0.0)), box((0.012, -0.06, -0.02), (0.06, 0.06, 0.0))]
    walls += [box((-0.012, y, -0.02), (0.012, y + 0.048, 0.0)) for y in (-0.06, 0.012)]
    legs = [box((x, -0.012, 0.00002), (x + 0.008, 0.012, 0.04)) for x in (-0.06, 0.052)]
    return {
        "base": joined(box((-0.06, -0.06, -0.04), (0.06, 0.06, -0.02)), *walls),
        "insert": box((-0.0119, -0.0119, -0.01998), (0.0119, 0.0119, -0.0001)),
        "bar": joined(*legs, box((-0.06, -0.012, 0.04), (0.06, 0.012, 0.048))),
        **({"lid": box((-0.03, -0.03, 0.00002), (0.03, 0.03, 0.008))} if lidded else {}),
    }


@pytest.mark.parametrize("kept", [["base"], ["base", "bar"]])
def test_a_bent_way_is_asked_that_is_free_once_another_part_is_out(kept: list[str]) -> None:
    for turn in (None, turn_of(6)):
        task = feeler.task(scene_of(pocket(True), turn), "insert", keep=kept)
        assert [step.paths for step in task.steps] == [("lid",), ("insert",)] and task.bound == task.seconds
    lift = task.steps[-1].way[1] - task.steps[-1].way[0]
    assert np.linalg.norm(lift[:3, 3]) < 0.04, "no higher than the bar"


def test_a_part_that_comes_out_alone_leaves_no_other_with_it() -> None:
    """A key in a slot that is closed above: sideways, then up. The body with it is bolted down."""
    mesh = hardware.hex_bolt(0.008, 0.03, USUAL)
    body = [box((-0.04, -0.02, 0.0), (0.04, 0.02, 0.01)), box((-0.04, -0.02, 0.01), (-0.02, 0.02, 0.03))]
    body += [box((0.02, -0.02, 0.01), (0.04, 0.02, 0.03)), box((-0.02, 0.0, 0.022), (0.0, 0.02, 0.03))]
    body += [
        box((-0.02, -0.02, 0.022), (0.0, 0.0, 0.03)),
        *(box((-0.02, y, 0.01), (0.02, y + 0.005, 0.022)) for y in (-0.02, 0.015)),
    ]
    flange = ring(0.0045, 0.0, 0.01)
    parts = {
        "bolt": (mesh.vertices + np.array([0.06, 0.0, 0.01]), mesh.faces.astype(np.int64)),
        "body": joined(*body, (flange[0] + np.array([0.06, 0.0, 0.0]), flange[1])),
        "key": box((-0.0199, -0.0149, 0.0101), (-0.0001, 0.0149, 0.0219)),
        "ground": joined(
            box((-0.04, -0.03, -0.03), (0.035, 0.03, -0.0001)), beside(ring(0.0034, -0.03, -0.0001), 0.06)
        ),
    }
    task = feeler.task(scene_of(parts, turn_of(5)), "key")
    assert [step.paths for step in task.steps] == [("key",)] and task.bound == task.seconds


def beside(mesh: Mesh, x: float) -> Mesh:
    return mesh[0] + np.array([x, 0.0, 0.0]), mesh[1]


def test_nothing_is_out_that_is_in_all_that_is_left() -> None:
    walls = [box((-0.02, -0.02, z), (0.02, 0.02, z + 0.005)) for z in (-0.02, 0.015)]
    walls += [box((-0.02, y, -0.015), (0.02, y + 0.005, 0.015)) for y in (-0.02, 0.015)]
    walls += [box((x, -0.015, -0.015), (x + 0.005, 0.015, 0.015)) for x in (-0.02, 0.015)]
    task = feeler.task(
        scene_of({"case": joined(*walls), "ball": box((-0.01, -0.01, -0.01), (0.01, 0.01, 0.01))}), "ball"
    )
    assert not task.is_found and task.blocked[0].because == "no way out was found"


def over_a_bolt(gap: float) -> dict[str, Mesh]:
    """A hood over the head of a bolt, below a rail; its walls end at a height above the cover."""
    mesh = hardware.hex_bolt(0.008, 0.02, USUAL)
    walls = [box((x, -0.015, gap), (x + 0.003, 0.015, 0.012)) for x in (-0.015, 0.012)]
    walls += [box((-0.015, y, gap), (0.015, y + 0.003, 0.012)) for y in (-0.015, 0.012)]
    legs = [box((-0.02, y, 0.0), (0.02, y + 0.01, 0.048)) for y in (-0.06, 0.05)]
    return {
        "bolt": (mesh.vertices, mesh.faces.astype(np.int64)),
        "cover": ring(0.0045, -0.01, 0.0),
        "case": ring(0.0034, -0.04, -0.01005),
        "hood": joined(*walls, box((-0.015, -0.015, 0.012), (0.015, 0.015, 0.015))),
        "rail": joined(*legs, box((-0.02, -0.06, 0.048), (0.02, 0.06, 0.054))),
    }


def test_a_hood_under_a_rail_needs_a_search_as_long_as_without_others() -> None:
    """It goes up until it clears the head of a bolt, and sideways below the rail."""
    parts = over_a_bolt(0.0002)
    for turn in (None, turn_of(3)):
        task = feeler.task(scene_of(parts, turn), "cover")
        assert [step.paths for step in task.steps] == [("hood",), ("bolt",), ("cover",)]
        assert feeler.task(scene_of(parts, turn), "cover", keep="rail").seconds == pytest.approx(task.seconds)


@pytest.mark.parametrize("seed", [None, 2, 5])
def test_a_hood_between_flush_walls_has_play(seed: int | None) -> None:
    """Casts along flush faces meet them by rounding: that does not keep the hood in its place."""
    sides = {
        "left": box((-0.06, -0.04, 0.0), (-0.015, 0.04, 0.02)),
        "right": box((0.015, -0.04, 0.0), (0.06, 0.04, 0.02)),
    }
    parts = over_a_bolt(0.0) | sides
    task = feeler.task(scene_of(parts, None if seed is None else turn_of(seed)), "cover")
    assert [step.paths for step in task.steps] == [("hood",), ("bolt",), ("cover",)]


def test_a_free_cover_is_lifted_not_slid() -> None:
    parts = {
        "cover": box((-0.05, -0.04, 1e-5), (0.05, 0.04, 0.01)),
        "base": box((-0.05, -0.04, -0.05), (0.05, 0.04, 0.0)),
    }
    parts["knob"] = box((0.0, 0.0, 0.2), (0.001, 0.001, 0.2001))
    for seed in (None, 3):
        turn = np.eye(3) if seed is None else turn_of(seed)
        (step,) = feeler.task(
            scene_of({**parts, "knob": box((0.01, 0.01, -0.1), (0.02, 0.02, -0.06))}, turn), "cover"
        ).steps
        way = turn.T @ step.way[-1][:3, 3]
        assert way[2] > 0.99 * np.linalg.norm(way)


def test_a_part_that_is_clear_of_all_others_has_a_sentence() -> None:
    parts = {"far": box((0.5, 0.5, 0.5), (0.6, 0.6, 0.6)), "base": box((0.0, 0.0, 0.0), (0.1, 0.1, 0.1))}
    (step,) = feeler.task(scene_of(parts), "far").steps
    assert step.because == "it is clear of all other parts where it is" and len(step.way) == 1


@pytest.mark.parametrize("seed", [None, 6])
def test_a_circlip_is_opened_and_drawn_off_its_shaft(seed: int | None) -> None:
    scene = scene_of(geared(), None if seed is None else turn_of(seed))
    task = feeler.task(scene, "gear", keep="shaft")
    assert [step.paths for step in task.steps] == [("circlip",), ("gear",)]
    first = task.steps[0]
    assert first.because.startswith("the ring is opened by 0.4") and "drawn along its axis" in first.because
    # It ends beyond the shaft, past its end and not over the shoulder.
    along = (np.eye(3) if seed is None else turn_of(seed)).T @ first.way[-1][:3, 3]
    assert along[2] > 0.009 and np.linalg.norm(along[:2]) < 1e-3 + 0.1 * along[2]


def test_a_ring_without_room_to_be_opened_stays() -> None:
    tight = lathe([(0.0131, 0.0301), (0.03, 0.0301), (0.03, 0.05), (0.0131, 0.05)])
    scene = scene_of(geared(sleeve=tight))
    stuck = feeler.task(scene, "circlip", keep=["shaft", "sleeve"])
    assert not stuck.is_found and "circlip" in {each.part for each in stuck.blocked}
    free = feeler.task(scene, "gear", keep="shaft")
    assert [step.paths for step in free.steps] == [("sleeve",), ("circlip",), ("gear",)]


def test_a_bolt_with_a_circlip_is_drawn_by_hand() -> None:
    names = geared()
    scene = scene_of({"bolt": names["shaft"], "gear": names["gear"], "circlip": names["circlip"]})
    row = feeler.find_fasteners(scene)
    task = feeler.task(scene, "bolt", fasteners=row)
    assert task.is_found and all(step.verb == "take out" for step in task.steps)


def test_a_circlip_in_a_bore_is_squeezed() -> None:
    bore = [(0.01, 0.0), (0.01, 0.02), (0.0105, 0.02), (0.0105, 0.0213), (0.01, 0.0213), (0.01, 0.03), (0.02, 0.03)]
    parts = {
        "case": lathe([*bore, (0.02, -0.01), (0.0, -0.01), (0.0, 0.0)]),
        "plug": lathe([(0.0, 0.0001), (0.0099, 0.0001), (0.0099, 0.0199), (0.0, 0.0199)]),
        "circlip": clip(0.0075, 0.0104, 0.02005, 0.02125),
    }
    task = feeler.task(scene_of(parts, turn_of(8)), "plug", keep="case")
    assert [step.paths for step in task.steps] == [("circlip",), ("plug",)]
    assert "squeezed" in task.steps[0].because


def test_a_clip_that_is_open_wide_is_pushed_off_sideways() -> None:
    parts = geared(circlip=clip(0.0096, 0.013, 0.03005, 0.03125, 130.0))
    parts["wall"] = box((-0.05, -0.05, 0.0405), (0.05, 0.05, 0.05))
    task = feeler.task(scene_of(parts, turn_of(9)), "circlip", keep=["wall", "shaft", "gear"])
    assert task.is_found and "pushed off sideways" in task.steps[0].because


def test_the_axis_of_a_ring_is_found_though_it_is_open() -> None:
    for open_deg in (10.0, 60.0, 150.0):
        corners, faces = clip(0.0096, 0.013, 0.0, 0.0012, open_deg)
        turn, shift = turn_of(7), np.array([0.1, 2.0, -1.0])
        found = ring_of(corners @ turn.T + shift, faces)
        assert found is not None and np.allclose(found.middle, turn @ [0.0, 0.0, 0.0006] + shift, atol=2e-6)
        assert abs(float(found.axis @ turn[:, 2])) > 1.0 - 1e-9 and found.gap_deg == pytest.approx(open_deg, abs=0.5)
        assert found.gap @ turn[:, 0] > 0.999 and (found.inner, found.outer) == pytest.approx((0.0096, 0.013), abs=3e-6)
    plate = box((0.0, 0.0, 0.0), (1.0, 1.0, 0.1))
    flat = ring_of(*plate)
    assert flat is None or flat.inner > 0.0
    assert ring_of(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)) is None


def test_a_ring_does_not_leave_over_a_shoulder() -> None:
    scene = scene_of(geared())
    shape = ring_of(*PartMeshes(scene.mockup).mesh(2))
    assert shape is not None
    (way,) = slippings(shape, scene.only(["shaft"]))
    assert way.direction[2] == pytest.approx(1.0) and 4e-4 < way.opening < 7e-4 and 0.009 < way.travel < 0.011


@pytest.mark.parametrize("seed", [0, 3, 8])
def test_the_bound_of_several_people_is_one(seed: int) -> None:
    made, kit = assemblies.random_assembly(seed), assemblies.tools()
    soonest = judge.Judge(made, kit, feeler.Times()).soonest(3)
    for people in (3, 10):
        task = feeler.task(feeler.Scene(made.mockup()), made.wanted, kit, keep=sorted(made.keep), people=people)
        assert task.bound <= soonest + 1e-6 <= task.seconds + 2e-6


def test_the_bound_of_many_people_has_the_longest_chain() -> None:
    task = feeler.task(scene_of(hooded()), "cover", people=10)
    # Each step waits for the one before it: ten people are no quicker.
    assert task.bound == pytest.approx(task.seconds) and len(task.steps) == 3


def test_progress_is_of_the_work_and_never_goes_back() -> None:
    shares: list[float] = []
    feeler.task(scene_of(hooded()), "cover", seconds=1e6, progress=lambda share, _what: shares.append(share))
    assert shares == sorted(shares) and shares[0] < 0.1 and shares[-1] == 1.0
    assert any(0.25 < share < 0.95 for share in shares)
    pace = Pace(math.inf)
    pace.stage(0.5, "a")
    pace.within(0.5)
    assert pace.share == 0.25
    pace.stage(1.0, "b")
    pace.within(0.5)
    pace.within(0.1)
    pace.stage(1.0, "b again")
    assert pace.share == 0.75
