"""Cotter pins, hairpins, spring and taper pins, dowels: what they hold, and how tasks take them out."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pytest
from bearing_shapes import circle, holed, placed, plate, ring, solid
from pin_shapes import castle_nut, cotter, drilled, hairpin
from shapes import Mesh, at, box, joined, mockup_of

import feeler
from feeler.plan.fastener_names import retainer_said
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance
from feeler.tasks.cotters import _Look

Floats = npt.NDArray[np.float64]


def tilted(parts: Mapping[str, Mesh], seed: int) -> feeler.Scene:
    """Somewhere, in no special direction."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = rng.uniform(-0.2, 0.2, 3)
    moved = {name: (vertices @ turn.T + shift, faces) for name, (vertices, faces) in parts.items()}
    return feeler.Scene(mockup_of(moved))


def held_by(scene: feeler.Scene, name: str) -> feeler.Hold:
    row = feeler.holds(scene).of(scene.mockup.part_paths.index(name))
    assert row is not None
    return row


def steps(scene: feeler.Scene, wanted: str) -> list[str]:
    task = feeler.task(scene, wanted, seconds=60.0)
    assert task.is_found, task.blocked
    return [f"{step.verb} {step.part}" for step in task.steps]


def secured(bent_deg: tuple[float, float], name: str, *, has_axle: bool = False) -> dict[str, Mesh]:
    """A plate under a castle nut with a pin through it, on a bolt or on the end of an axle."""
    edge = 0.0085 / math.cos(math.pi / 6.0)
    foot = ring(1e-4, 0.012, -0.06, 0.0) if has_axle else solid([(edge, -0.0064), (edge, 0.0)], 6)
    return {
        "axle" if has_axle else "bolt": joined(foot, drilled(0.005, 0.0, 0.045, 0.0013, 0.04)),
        "plate": ring(0.0055, 0.03, 0.01202, 0.028),
        "base": ring(0.0055, 0.03, 1e-5, 0.012),
        "castle_nut": castle_nut(0.017, 0.00502, 0.0281, 0.036, 0.0425, 0.0014),
        name: placed(cotter(0.00125, 0.0082, 0.008, bent_deg), at(z=0.04)),
    }


@pytest.mark.parametrize(
    ("name", "bent_deg"),
    [
        ("Splint", (90.0, 90.0)),
        ("goupille fendue", (90.0, -70.0)),
        ("cotter_pin", (0.0, 0.0)),
        ("part_7", (110.0, 90.0)),
    ],
)
def test_a_cotter_pin_goes_before_its_castle_nut(name: str, bent_deg: tuple[float, float]) -> None:
    scene = tilted(secured(bent_deg, name), len(name))
    row = held_by(scene, name)
    assert (row.kind, row.paths, row.anchor_path) == ("cotter", ("castle_nut",), "bolt"), row
    assert steps(scene, "plate") == [f"take out {name}", "undo castle_nut", "take out plate"]


def test_a_cotter_pin_through_the_end_of_an_axle() -> None:
    scene = tilted(secured((90.0, 90.0), "splint", has_axle=True), 2)
    assert held_by(scene, "splint").anchor_path == "axle"
    assert steps(scene, "plate") == ["take out splint", "undo castle_nut", "take out plate"]


def test_its_legs_are_straightened_unless_they_are_straight() -> None:
    said = []
    for bend in (90.0, 0.0):
        task = feeler.task(tilted(secured((bend, bend), "cotter"), 3), "cotter")
        (step,) = task.steps
        said.append(step.because)
    assert "straightened" in said[0] and "straightened" not in said[1] and "drawn along its axis" in said[1]


def test_a_castle_nut_stays_if_its_cotter_pin_is_kept() -> None:
    scene = tilted(secured((90.0, 90.0), "cotter"), 4)
    task = feeler.task(scene, "castle_nut", keep="cotter")
    assert not task.is_found and task.blocked[0].blockers == ("cotter",)


def clevis(pin: dict[str, Mesh]) -> dict[str, Mesh]:
    """A rod in a fork, on a pin with a head and a hole near to its end."""
    shank = joined(solid([(0.008, -0.034), (0.008, -0.03)], 24), drilled(0.005, -0.03, 0.03, 0.0016, 0.0235))
    legs = [ring(0.0051, 0.02, -0.03, -0.018), ring(0.0051, 0.02, 0.005, 0.016)]
    fork = joined(*legs, box((0.0195, -0.01, -0.03), (0.03, 0.01, 0.016)))
    washer = ring(0.0052, 0.009, 0.01605, 0.0174)
    moved = {name: placed(mesh, at(z=0.0235)) for name, mesh in pin.items()}
    return {"clevis_pin": shank, "fork": fork, "rod": ring(0.0051, 0.015, -0.0175, 0.0045), "washer": washer, **moved}


@pytest.mark.parametrize(
    "pin", [{"split_pin": cotter(0.0015, 0.0058, 0.006)}, {"r_clip": hairpin(0.0014, 0.0055)}], ids=["split", "hairpin"]
)
def test_what_goes_through_a_clevis_pin_is_out_before_it(pin: dict[str, Mesh]) -> None:
    scene, (name,) = tilted(clevis(pin), 5), pin
    row = held_by(scene, name)
    assert (row.kind, row.paths, row.anchor_path) == ("cotter", ("washer",), "clevis_pin")
    assert steps(scene, "rod") == [f"take out {name}", "take out clevis_pin", "take out rod"]


@pytest.mark.parametrize(("name", "rod"), [("split_pin", "part 3"), ("part_7", "axe"), ("R-clip", "Achse")])
def test_a_cotter_pin_goes_through_a_rod_whatever_that_is_called(name: str, rod: str) -> None:
    parts = clevis({name: hairpin(0.0014, 0.0055) if name == "R-clip" else cotter(0.0015, 0.0058, 0.006)})
    scene = tilted({rod if part == "clevis_pin" else part: mesh for part, mesh in parts.items()}, 8)
    row = held_by(scene, name)
    assert (row.kind, row.paths, row.anchor_path) == ("cotter", ("washer",), rod)
    if rod == "part 3":
        assert steps(scene, "rod") == [f"take out {name}", f"take out {rod}", "take out rod"]


@pytest.mark.parametrize("name", ["Bolzen", "Perno 10"])
def test_a_rod_is_a_pin_where_its_name_may_say_bolt(name: str) -> None:
    """With a head and a hole for a cotter pin, or plain through a hinge. With a head for a tool it is a bolt."""
    parts = clevis({"split_pin": cotter(0.0015, 0.0058, 0.006)})
    scene = tilted({name if part == "clevis_pin" else part: mesh for part, mesh in parts.items()}, 8)
    assert (held_by(scene, "split_pin").anchor_path, held_by(scene, name).kind) == (name, "pin")
    assert steps(scene, "rod") == ["take out split_pin", f"take out {name}", "take out rod"]
    scene = tilted(pinned(name, solid([(0.0025, -0.02), (0.0025, 0.02)], 24)), 6)
    assert held_by(scene, name).kind == "pin" and steps(scene, "hub") == [f"take out {name}", "take out hub"]
    hexagon = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    for named, mesh in (
        (f"{name} M8", solid([(0.004, -0.02), (0.004, 0.02)], 24)),
        (name, (hexagon.vertices, hexagon.faces.astype(np.int64))),
    ):
        (row,) = feeler.find_fasteners(tilted({named: mesh, "lump": box((1, 1, 1), (1.1, 1.1, 1.1))}, 1))
        assert row.kind == "bolt", row.because


def test_a_wire_across_a_rod_is_no_cotter_pin_if_it_can_be_drawn() -> None:
    parts = clevis({"part_7": solid([(0.0012, -0.012), (0.0012, 0.012)], 16)})
    parts["part_7"] = placed(placed(parts["part_7"], at(z=-0.0235)), at(degrees=90.0, axis=1))
    parts["part_7"] = placed(parts["part_7"], at(z=0.0235))
    scene = tilted({"part 3" if part == "clevis_pin" else part: mesh for part, mesh in parts.items()}, 9)
    assert feeler.holds(scene).of(scene.mockup.part_paths.index("part_7")) is None


def pinned(name: str, pin: Mesh) -> dict[str, Mesh]:
    """A hub on a shaft, with a hole across both."""
    halves = [ring(0.01001, 0.02, 0.0025, 0.01), ring(0.01001, 0.02, -0.01, -0.0025)]
    outer, inner = (math.asin(0.0025 / radius) for radius in (0.02, 0.01001))
    out, back = np.linspace(outer, math.pi - outer, 24), np.linspace(math.pi - inner, inner, 24)
    arc = [
        0.02 * np.stack([np.cos(out), np.sin(out)], axis=1),
        0.01001 * np.stack([np.cos(back), np.sin(back)], axis=1),
    ]
    for sign in (1.0, -1.0):
        halves.append(plate([sign * np.concatenate(arc)], -0.0025, 0.0025))
    parts = {"shaft": drilled(0.01, -0.03, 0.03, 0.0025, 0.0), "hub": joined(*halves)}
    return parts | {name: placed(pin, at(degrees=90.0, axis=1)), "bed": box((0.1, 0.1, 0.1), (0.11, 0.11, 0.11))}


def slotted() -> Mesh:
    """A tube that is open along one side."""
    turn = np.linspace(0.25, math.tau - 0.25, 20)
    sides = [
        radius * np.stack([np.cos(one), np.sin(one)], axis=1) for radius, one in ((0.0025, turn), (0.002, turn[::-1]))
    ]
    return plate([np.concatenate(sides)], -0.02, 0.02)


@pytest.mark.parametrize(
    ("name", "pin"), [("roll_pin", slotted()), ("taper_pin", solid([(0.0023, -0.021), (0.00249, 0.021)], 20))]
)
def test_a_pin_across_a_hub_holds_it(name: str, pin: Mesh) -> None:
    scene = tilted(pinned(name, pin), 6)
    row = held_by(scene, name)
    assert row.kind == "pin" and set(row.paths) == {"hub", "shaft"}
    assert steps(scene, "hub")[0] == f"take out {name}"


def test_the_halves_of_a_case_come_off_their_blind_dowels() -> None:
    mesh = hardware.hex_bolt(0.008, 0.025, Tolerance(1e-4))
    blind = [plate([circle(0.025, 32), circle(0.00301, 24, 0.015)], z, z + 0.006) for z in (-0.006, 1e-5)]
    parts = {
        "upper": joined(blind[1], ring(1e-3, 0.025, 0.006, 0.012)),
        "lower": joined(blind[0], ring(1e-3, 0.025, -0.02, -0.006)),
        "dowel": placed(solid([(0.003, -0.0058), (0.003, 0.0058)], 24), at(x=0.015)),
        "bolt": (mesh.vertices + np.array([0.0, 0.06, 0.012]), mesh.faces.astype(np.int64)),
        "foot": holed(0.001, 0.02, -0.03, 0.012, 0.0045, 0.0105, 2),
    }
    parts["foot"] = parts["foot"][0] + np.array([0.0, 0.06, 0.0]), parts["foot"][1]
    scene = tilted(parts, 7)
    row = held_by(scene, "dowel")
    assert row.kind == "dowel" and set(row.paths) == {"upper", "lower"}
    assert steps(scene, "upper") == ["take out upper"]


@pytest.mark.parametrize(
    "name", ["R-clip", "hairpin clip 3", "Federstecker", "Klappstecker", "linch_pin", "spring pin 4x20", "Spannhülse"]
)
def test_names_of_pins(name: str) -> None:
    assert retainer_said(name) == "pin"


def test_neighbours_are_those_of_all_pairs_and_few_are_looked_at() -> None:
    rng = np.random.default_rng(7)
    lows = rng.uniform(0.0, 10.0, (400, 3)) * (1.0, 0.2, 0.2)
    sizes = np.concatenate([rng.uniform(0.01, 0.3, (390, 3)), rng.uniform(1.0, 9.0, (10, 3))])
    scene = feeler.Scene(mockup_of({f"b{i}": box(lows[i], lows[i] + sizes[i]) for i in range(400)}))
    look = _Look(scene, [], set())
    meets = ((lows[:, None] <= lows + sizes) & (lows <= (lows + sizes)[:, None])).all(axis=2)
    lengths = np.linalg.norm(sizes, axis=1)
    wanted = (meets & (lengths[None, :] < lengths[:, None])).any(axis=1)
    assert [look._has_thin_neighbour(part) for part in range(400)] == wanted.tolist() and 20 < wanted.sum() < 300
    assert np.median([len(look._beside(part)) for part in range(400)]) < 40
