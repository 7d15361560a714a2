"""What fasteners hold between a nut and a shoulder, below a flanged bush, and in clamps beside others."""

from __future__ import annotations

from typing import Any

import pytest
from test_drawn_threads import cylinder, mesh, prism
from test_holding import tilted

import feeler

solids = pytest.importorskip("manifold3d")


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Any:
    return solids.Manifold.cube([b - a for a, b in zip(low, high, strict=True)]).translate(low)


def rows(parts: dict[str, Any], seed: int) -> dict[str, tuple[set[str], str]]:
    """What each fastener holds, and what it is fastened in."""
    found = feeler.holds(tilted({name: mesh(solid) for name, solid in parts.items()}, seed))
    return {row.path: (set(row.paths), row.anchor_path) for row in found}


def nut(low: float) -> Any:
    return prism(16.0, 6, low, low + 8.4) - cylinder(10.0, low - 1, low + 9, 48)


@pytest.mark.parametrize("name", ["hammer_bolt_M10", "part"])
@pytest.mark.parametrize("seed", range(3))
def test_a_nut_holds_the_rail_under_a_hammer_head(name: str, seed: int) -> None:
    slot = block((-5.2, -70, -20), (5.2, 70, 1)) + block((-10, -70, -22), (10, 70, -10))
    parts = {
        "rail": block((-20, -60, -40), (20, 60, 0)) - slot,
        "plate": block((-25, -25, 0), (25, 25, 8)) - cylinder(11.0, -1, 9, 48),
        "nut": nut(8),
        name: cylinder(10.0, -10.1, 24, 48) + block((-9, -4.9, -17), (9, 4.9, -10)),
    }
    assert rows(parts, seed)["nut"] == ({"plate", "rail"}, name)


@pytest.mark.parametrize("gap", [0.0, 3.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_nut_holds_all_plates_up_to_a_collar(gap: float, seed: int) -> None:
    """Not those that are loose on the shank."""
    ring = solids.Manifold.revolve(solids.CrossSection.circle(4, 24).translate((12, 0)), 32).rotate((90, 0, 0))
    parts = {
        "eye": cylinder(10.0, -30, 0, 48) + cylinder(20.0, 0, 4, 48) + ring.translate((0, 0, 18)),
        "upper": block((-30, -30, gap - 8), (30, 30, gap)) - cylinder(11.0, -20, 20, 48),
        "lower": block((-30, -30, -16), (30, 30, -8)) - cylinder(11.0, -20, 20, 48),
        "nut": nut(-24.4),
    }
    parts["upper"] -= block((-15, -15, -1), (15, 15, 20))
    assert rows(parts, seed)["nut"] == ({"lower"} if gap else {"lower", "upper"}, "eye")


@pytest.mark.parametrize("seed", range(3))
def test_a_bolt_with_a_nut_holds_what_is_under_the_flange_of_its_bush(seed: int) -> None:
    parts = {
        "lever": block((-15, -15, 0), (60, 15, 10)) - cylinder(16.0, -1, 11, 48),
        "bush": cylinder(16.0, 0, 10.2, 48) + cylinder(24.0, 10, 12, 48) - cylinder(10.4, -1, 13, 48),
        "frame": block((-40, -40, -10), (60, 40, 0)) - cylinder(10.4, -11, 1, 48),
        "bolt M10": prism(16.0, 6, 12, 18.4) + cylinder(10.0, -22, 12.1, 48),
        "nut": nut(-18.4),
    }
    found = rows(parts, seed)
    assert found["bolt M10"][0] == found["nut"][0] == {"bush", "lever", "frame"}


@pytest.mark.parametrize(("dog", "hole", "is_groove"), [(5.0, 5.2, False), (4.0, 4.2, False), (4.0, 4.2, True)])
@pytest.mark.parametrize("thread", [6.0, 4.917])
def test_the_thread_of_a_set_screw_is_not_around_its_point(
    dog: float, hole: float, is_groove: bool, thread: float
) -> None:
    """Its dog is free in a hole or a groove of a bar."""
    housing = block((-50, -30, -20), (50, 30, 20)) - block((-60, -10.025, -5.02), (60, 10.025, 5.02))
    cut = block((-hole / 2, -15, 2), (hole / 2, 15, 12)) if is_groove else cylinder(hole, 2, 12, 48)
    screw = cylinder(6.0, 5.2, 20.2, 48) + cylinder(dog, 2.3, 5.3, 48) - prism(3.0, 6, 17, 21)
    parts = {
        "housing": housing - cylinder(thread, 5, 35, 48),
        "bar": block((-70, -10, -5), (70, 10, 5)) - cut,
        "set screw": screw,
    }
    for seed in range(2):
        assert rows(parts, seed)["set screw"][1] == "housing"


@pytest.mark.parametrize("seed", range(3))
def test_saddles_of_crossing_pipes_hold_their_own(seed: int) -> None:
    """They are near each other, and no halves of one clamp."""

    def saddle(name: str, low: float, x: float) -> dict[str, Any]:
        pipe = (cylinder(20.0, -60, 60, 48) - cylinder(16.0, -61, 61, 48)).rotate((0, 90, 0))
        bore = cylinder(20.04, -20, 20, 48).rotate((0, 90, 0)) + block((-20, -10.02, -20), (20, 10.02, 0))
        saddle = block((-8, -26, -10), (8, 26, 14)) - bore - block((-9, 14, -7), (9, 27, 15))
        saddle -= block((-9, -27, -7), (9, -14, 15))
        wall = block((-20, -30, -22), (20, 30, -10))
        found = {f"{name}/pipe": pipe, f"{name}/wall": wall}
        for number, y in enumerate((-20.0, 20.0)):
            saddle -= cylinder(6.6, -20, 20, 32).translate((0, y, 0))
            found[f"{name}/wall"] -= cylinder(5.0, -21, 0, 32).translate((0, y, 0))
            screw = prism(10.0, 6, -7, -3) + cylinder(6.0, -19, -6.9, 32)
            found[f"{name}/screw_{number}"] = screw.translate((0, y, 0))
        found[f"{name}/clamp"] = saddle
        return {path: solid.translate((x, 0, low)) for path, solid in found.items()}

    parts = saddle("one", 0.0, 0.0)
    parts |= {path: solid.rotate((180, 0, 90)) for path, solid in saddle("other", -29.0, 0.0).items()}
    found = rows(parts, seed)
    for name in ("one", "other"):
        for number in range(2):
            assert found[f"{name}/screw_{number}"] == ({f"{name}/clamp", f"{name}/pipe"}, f"{name}/wall"), found


def slotted(length: float, low: float) -> Any:
    """A plate with a slot for a shank of 10 mm, longer by so much."""
    ends = [cylinder(11.0, low - 1, low + 11, 48).translate((x, 0, 0)) for x in (-0.5 * length, 0.5 * length)]
    return block((-40, -40, low), (40, 40, low + 10)) - solids.Manifold.batch_hull(ends)


@pytest.mark.parametrize("length", [0.0, 3.0, 10.0])
@pytest.mark.parametrize("seed", range(2))
def test_all_nuts_of_a_rod_hold_a_plate_with_a_slot(length: float, seed: int) -> None:
    """Its wall is too far from the shank for rays: the face of the nut beside it lies on it."""
    parts = {
        "slotted": slotted(length, 0),
        "upper": block((-30, -30, 10), (30, 30, 20)) - cylinder(11.0, 9, 21, 48),
        "rod": cylinder(10.0, -22, 40, 48),
        "top": nut(20),
        "bottom": nut(-8.4),
        "lock": nut(-16.8),
    }
    held = {"slotted", "upper"}
    found = rows(parts, seed)
    assert [found[each] for each in ("top", "bottom", "lock")] == [(held, "rod")] * 3


@pytest.mark.parametrize("length", [0.0, 10.0])
@pytest.mark.parametrize("seed", range(2))
def test_a_lock_nut_holds_what_the_nut_before_it_bears_on(length: float, seed: int) -> None:
    parts = {
        "slotted": slotted(length, 0),
        "upper": block((-30, -30, 10), (30, 30, 20)) - cylinder(11.0, 9, 21, 48),
        "bolt": cylinder(10.0, -22, 20, 48) + prism(16.0, 6, 20, 26.4),
        "nut": nut(-8.4),
        "lock": nut(-16.8),
    }
    found = rows(parts, seed)
    assert [found[each][0] for each in ("bolt", "nut", "lock")] == [{"slotted", "upper"}] * 3


@pytest.mark.parametrize("seed", range(2))
def test_nuts_on_a_rod_hold_the_plate_between_them_alone(seed: int) -> None:
    parts = {
        "left": block((-30, -30, 0), (30, 30, 10)) - cylinder(11.0, -1, 11, 48),
        "right": block((-30, -30, 60), (30, 30, 70)) - cylinder(11.0, 59, 71, 48),
        "rod": cylinder(10.0, -20, 90, 48),
        "a": nut(-8.4),
        "b": nut(10),
        "c": nut(51.6),
        "d": nut(70),
    }
    found = rows(parts, seed)
    assert [found[each][0] for each in "abcd"] == [{"left"}, {"left"}, {"right"}, {"right"}]


@pytest.mark.parametrize("thick", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("wide", [10.0, 8.16])
@pytest.mark.parametrize("is_drawn", [True, False])
def test_the_nut_of_a_stud_holds_a_foil_on_its_base(thick: float, wide: float, is_drawn: bool) -> None:
    """Also of a stud that is drawn as wide as the core of its thread, and where its base has no hole."""
    base = block((-30, -30, -40), (30, 30, 0))
    parts = {
        "base": base - cylinder(wide, -20, 1, 48) if is_drawn else base,
        "gasket": block((-30, -30, 0), (30, 30, thick)) - cylinder(11.0, -1, 9, 48),
        "plate": block((-30, -30, thick), (30, 30, thick + 12)) - cylinder(11.0, -1, 20, 48),
        "stud": cylinder(wide, -15, thick + 24, 48),
        "nut": prism(16.0, 6, thick + 12, thick + 20.4) - cylinder(wide, thick + 11, thick + 21, 48),
    }
    assert rows(parts, 1)["nut"] == ({"gasket", "plate"}, "stud")


@pytest.mark.parametrize("seed", range(2))
def test_a_nut_holds_nothing_on_the_other_side_of_the_thread_of_its_stud(seed: int) -> None:
    parts = {
        "base": block((-30, -30, -20), (30, 30, 0)) - cylinder(10.0, -21, 1, 48),
        "upper": block((-30, -30, 0), (30, 30, 10)) - cylinder(11.0, -1, 11, 48),
        "lower": block((-30, -30, -30), (30, 30, -20)) - cylinder(11.0, -31, -19, 48),
        "stud": cylinder(10.0, -45, 25, 48),
        "top": nut(10),
        "bottom": nut(-38.4),
    }
    found = rows(parts, seed)
    assert [found[each][0] for each in ("top", "bottom")] == [{"upper"}, {"lower"}]
