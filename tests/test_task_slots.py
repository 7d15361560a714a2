"""What is clamped in slots, drawn along the axes, where rays meet flush faces."""

from __future__ import annotations

import itertools

import pytest
from shapes import mockup_of
from test_drawn_threads import cylinder, mesh, prism

import feeler

solids = pytest.importorskip("manifold3d")


def test_a_profile_is_held_whatever_the_order_of_the_parts() -> None:
    def block(x: float, y: float, low: float, high: float) -> object:
        return solids.Manifold.cube([2.0 * x, 2.0 * y, high - low]).translate([-x, -y, low])

    screw = cylinder(8.0, -12.0, 5.7, 32) + cylinder(13.0, 5.6, 13.6, 32) - prism(6.0, 6, 9.6, 14.0)
    parts = {
        "screw": screw,
        "slot nut": block(5.5, 10, -8, -2.4) + block(12, 10, -15.2, -8) - cylinder(8.0, -20, 1, 32),
        "bracket": block(24, 24, 0, 5.6) - cylinder(9.0, -1, 6, 32),
        "profile": block(32, 160, -64, 0) - block(5.6, 999, -8, 1) - block(12.3, 999, -20.8, -8),
    }
    meshes = {name: mesh(solid) for name, solid in parts.items()}
    for names in itertools.permutations(meshes):
        (row,) = feeler.holds(mockup_of({name: meshes[name] for name in names}))
        assert (set(row.paths), row.anchor_path) == ({"bracket", "profile"}, "slot nut"), names
