"""Nuts whose thread is drawn, as a helix or as rings, with chamfers or without: found by their outside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from shapes import Mesh
from test_holding import only, tilted

import feeler

solids = pytest.importorskip("manifold3d")
SIZE, PITCH, HEIGHT = 8.0, 1.25, 6.8
CORE = SIZE - 1.0825 * PITCH


def cone(low: float, high: float, lower: float, upper: float, sides: int = 24) -> Any:
    return solids.Manifold.cylinder(high - low, lower, upper, sides).translate([0.0, 0.0, low])


def cylinder(diameter: float, low: float, high: float, sides: int = 24) -> Any:
    return cone(low, high, 0.5 * diameter, 0.5 * diameter, sides)


def prism(flats: float, sides: int, low: float, high: float) -> Any:
    return cylinder(flats / np.cos(np.pi / sides), low, high, sides)


def rings(low: float, high: float) -> Any:
    """A rod with a ridge for each pitch."""
    half, rod = 0.5 * PITCH, cylinder(CORE, low, high)
    for z in np.arange(low, high, PITCH):
        rod += cone(z, z + half, 0.5 * CORE, 0.5 * SIZE) + cone(z + half, z + PITCH, 0.5 * SIZE, 0.5 * CORE)
    return rod ^ cylinder(2.0 * SIZE, low, high)


def helix(low: float, high: float) -> Any:
    """A rod with a ridge that winds up it."""
    count, inner = 24, 0.47 * CORE
    ridge = np.array([(inner, -0.02 * PITCH), (0.5 * SIZE, 0.5 * PITCH), (inner, 1.02 * PITCH)])
    turn = np.arange(int((high - low) / PITCH + 2) * count) * (2.0 * np.pi / count)
    z = ridge[:, 1] + PITCH * (turn[:, None] / (2.0 * np.pi) - 1.0) + low
    points = np.stack([ridge[:, 0] * np.cos(turn)[:, None], ridge[:, 0] * np.sin(turn)[:, None], z], axis=2)
    end = 3 * (len(turn) - 1)
    faces = [[0, 2, 1], [end, end + 1, end + 2]]
    for k in range(0, end, 3):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            faces += [[k + a, k + b, k + 3 + b], [k + a, k + 3 + b, k + 3 + a]]
    wall = points.reshape(-1, 3).astype(np.float32)
    wound = solids.Manifold(solids.Mesh(wall, np.array(faces, dtype=np.uint32)[:, ::-1]))
    assert wound.volume() > 0.0
    return (wound + cylinder(CORE, low - PITCH, high + PITCH)) ^ cylinder(2.0 * SIZE, low, high)


def chamfered(body: Any, reach: float) -> Any:
    """Without the corners of its outside and the edges of its bore."""
    edge = 0.3 * (reach - 6.2)
    keep = (
        cone(0.0, edge, 6.2, reach)
        + cylinder(2.0 * reach, edge, HEIGHT - edge)
        + cone(HEIGHT - edge, HEIGHT, reach, 6.2)
    )
    wide, deep = 0.54 * SIZE, 0.54 * SIZE - 0.49 * CORE
    low, high = cone(-1e-3, deep, wide, wide - deep), cone(HEIGHT - deep, HEIGHT + 1e-3, wide - deep, wide)
    return (body ^ keep) - low - high


def mesh(solid: Any) -> Mesh:
    found = solid.to_mesh64()
    return 1e-3 * np.asarray(found.vert_properties)[:, :3], np.asarray(found.tri_verts).astype(np.int64)


def bolted(thread: Any, sides: int, is_chamfered: bool) -> dict[str, Mesh]:
    """A nut from 0 to its height below a plate, on a bolt; nothing has a name."""
    outside = prism(13.0, sides, 0.0, HEIGHT) if sides else cylinder(16.0, 0.0, HEIGHT, 48)
    nut = outside - thread(-PITCH, HEIGHT + PITCH)
    reach = 6.5 / np.cos(np.pi / sides) if sides else 8.0
    bolt = cylinder(0.995 * SIZE, -5.0, 20.1) + prism(13.0, 6, 20.0, 25.0)
    return {
        "part 1": mesh(chamfered(nut, reach) if is_chamfered else nut),
        "part 2": mesh(prism(60.0, 4, HEIGHT, 20.0) - cylinder(1.1 * SIZE, 0.0, 21.0)),
        "part 3": mesh(bolt),
    }


@pytest.mark.parametrize("is_chamfered", [False, True])
@pytest.mark.parametrize("sides", [6, 4, 0])
@pytest.mark.parametrize("thread", [rings, helix])
def test_a_nut_is_found_whatever_its_bore_is(thread: Any, sides: int, is_chamfered: bool) -> None:
    scene = feeler.Scene(tilted(bolted(thread, sides, is_chamfered), 1))
    found = {row.path: row for row in feeler.find_fasteners(scene)}
    nut = found["part 1"]
    assert (nut.kind, nut.drive) == ("nut", {6: "hexagon", 4: "square", 0: ""}[sides]), nut.because
    assert nut.size == pytest.approx(1e-3 * CORE, rel=0.02)
    row = only(feeler.holds(scene), "part 1")
    assert (row.paths, row.anchor_path) == (("part 2",), "part 3"), row.because
    task = feeler.task(scene, "part 2", keep="part 3")
    assert [(step.verb, step.part) for step in task.steps] == [("undo", "part 1"), ("take out", "part 2")], task.blocked


def test_a_round_body_needs_a_thread_in_it_and_room_around_it() -> None:
    """A ring with chamfers is no nut, nor an insert with a thread, nor a nut without a bolt."""
    parts = bolted(rings, 0, True)
    plain = cylinder(16.0, 0.0, HEIGHT, 48) - cylinder(1.005 * SIZE, -1.0, 8.0)
    others = {
        "a ring": {**parts, "part 1": mesh(chamfered(plain, 8.0))},
        "an insert": {**parts, "part 4": mesh(prism(40.0, 4, -1.0, HEIGHT) - cylinder(16.02, -2.0, 9.0, 48))},
        "alone": {name: each for name, each in parts.items() if name != "part 3"},
    }
    for name, each in others.items():
        assert "part 1" not in {row.path for row in feeler.find_fasteners(tilted(each, 1))}, name
