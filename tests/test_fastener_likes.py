"""What looks like a fastener, and is none: spacers with a clearance hole around a bolt, and bars with a slot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shapes import Mesh, mockup_of
from test_drawn_threads import cylinder, mesh, prism
from test_holding import tilted

import feeler

solids = pytest.importorskip("manifold3d")


def block(x: float, y: float, low: float, high: float) -> Any:
    return solids.Manifold.cube([2.0 * x, 2.0 * y, high - low]).translate([-x, -y, low])


def spaced(spacer: Any, height: float, hole: float, *, has_nut: bool = False) -> dict[str, Mesh]:
    """A plate on a spacer on a base; an M8 bolt through all, in the base's thread or in a nut below it."""
    base = block(40, 30, -20, 0) - cylinder(9.0 if has_nut else 8.0, -21, 1)
    shank = 26.0 + 6.0 + 4.0 if has_nut else 12.0 + 6.0
    head = height + 6.0
    parts = {
        "0": base,
        "1": spacer - cylinder(hole, -1, height + 1),
        "2": block(30, 20, height, head) - cylinder(9.0, height - 1, head + 1),
        "3": cylinder(8.0, head - height - shank, head) + prism(13.0, 6, head, head + 5.3),
    }
    if has_nut:
        parts["4"] = prism(13.0, 6, -26.8, -20.0) - cylinder(8.0, -30, -10)
    return {name: mesh(solid) for name, solid in parts.items()}


@pytest.mark.parametrize("has_nut", [False, True])
@pytest.mark.parametrize(("flats", "sides", "hole"), [(13.0, 6, 8.4), (17.0, 6, 9.0), (18.0, 4, 9.0), (20.0, 4, 8.2)])
def test_a_spacer_with_a_clearance_hole_is_no_nut(flats: float, sides: int, hole: float, has_nut: bool) -> None:
    for seed, height in enumerate((8.0, 12.0)):
        spacer = prism(flats, sides, 0.0, height)
        mockup = tilted(spaced(spacer, height, hole, has_nut=has_nut), seed)
        assert "1" in [row.path for row in feeler.find_fasteners(mockup)], "by its looks"
        found = feeler.holds(mockup)
        (bolt,) = (row for row in found if row.kind == "bolt")
        wanted = {"1", "2", "0"} if has_nut else {"1", "2"}
        assert (set(bolt.paths), bolt.anchor_path) == (wanted, "4" if has_nut else "0"), (seed, bolt.because)
        assert found.of(1) is None
    task = feeler.task(feeler.Scene(mockup), "2", held=found, seconds=20.0)
    assert [step.verb for step in task.steps][:1] == ["undo"] and task.steps[0].paths[0] in ("3", "4")


def test_a_nut_that_is_drawn_loosely_is_one_where_nothing_else_has_a_thread() -> None:
    parts = spaced(block(20, 20, 0, 8.0), 8.0, 9.0, has_nut=True)
    parts["4"] = mesh(prism(13.0, 6, -26.8, -20.0) - cylinder(8.3, -30, -10))
    found = feeler.holds(tilted(parts, 1))
    assert [(row.path, row.kind) for row in found] == [("3", "bolt"), ("4", "nut")]
    # A lock nut by name, on a thread in the base.
    named = {"base": "0", "lock nut": "1", "plate": "2", "bolt": "3"}
    short = spaced(prism(13.0, 6, 0.0, 6.8), 6.8, 8.3)
    found = feeler.holds(tilted({name: short[old] for name, old in named.items()}, 2))
    assert "lock nut" in [row.path for row in found]


@pytest.mark.parametrize(("width", "depth", "length"), [(6.0, 10.0, 20.0), (8.0, 20.0, 60.0), (2.0, 3.0, 20.0)])
def test_a_bar_with_a_slot_is_no_set_screw(width: float, depth: float, length: float) -> None:
    def slotted(rod: Any) -> feeler.Mockup:
        slot = block(0.5 * width, 30, length - depth, length + 1)
        return tilted({"own": mesh(rod - slot)}, 3)

    assert len(feeler.find_fasteners(slotted(block(10, 10, 0, length)))) == 0
    assert len(feeler.find_fasteners(slotted(prism(20.0, 6, 0, length)))) == 0
    if width == 2.0:
        (screw,) = feeler.find_fasteners(slotted(cylinder(20.0, 0, length, 48)))
        assert screw.drive == "slot"


def test_a_pocket_of_a_block_is_no_recess_of_a_screw() -> None:
    cut = prism(10.0, 6, 12.0, 21.0)
    found = feeler.find_fasteners(mockup_of({"own": mesh(block(10, 10, 0, 20) - cut)}))
    assert all(row.kind != "screw" for row in found)
    (screw,) = feeler.find_fasteners(mockup_of({"own": mesh(cylinder(20.0, 0, 20, 48) - cut)}))
    assert screw.drive == "hexagon socket" and np.isclose(screw.across_flats, 0.01)
