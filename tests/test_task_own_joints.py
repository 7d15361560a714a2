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
