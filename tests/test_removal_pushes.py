"""Ways that a mechanic sees at once: up and sideways, turn and pull, through a window, along a maze. Judged by coal."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import mockup_of

import feeler
from feeler.plan.legs import path_of_json

coal = pytest.importorskip("coal", exc_type=ImportError)
m3 = pytest.importorskip("manifold3d", exc_type=ImportError)

Floats = npt.NDArray[np.float64]
Mesh = tuple[Floats, npt.NDArray[np.int64]]


def box(x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> Any:
    return m3.Manifold.cube((x1 - x0, y1 - y0, z1 - z0)).translate((x0, y0, z0))


def cylinder(radius: float, z0: float, z1: float, sides: int = 32) -> Any:
    return m3.Manifold.cylinder(z1 - z0, radius, radius, sides).translate((0, 0, z0))


def slice_of(radius: float, z0: float, z1: float, first: float, last: float) -> Any:
    """Of a disc, between two angles in degrees."""
    angle = np.radians(np.linspace(first, last, max(3, int((last - first) / 6))))
    corners = np.vstack([[0, 0], radius * np.column_stack([np.cos(angle), np.sin(angle)])])
    return m3.CrossSection([corners.tolist()]).extrude(z1 - z0).translate((0, 0, z0))


def arrays(solid: Any) -> Mesh:
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(np.int64)


def two_lugs(radius: float, z0: float, z1: float, first: float, last: float) -> Any:
    return slice_of(radius, z0, z1, first, last) + slice_of(radius, z0, z1, first + 180, last + 180)


def bayonet(push: float) -> tuple[Any, Any]:
    """Lugs in a groove, 70 degrees from the slots that lead out; with `push` in pockets, to be pushed out of first."""
    play = 0.0005
    lugs = cylinder(0.026, 0.015, 0.022) ^ two_lugs(0.05, 0.015, 0.022, -10, 10)
    part = (cylinder(0.02, 0.0, 0.06) + lugs).rotate((0, 0, 70))
    floor = 0.0145 - push
    wide = cylinder(0.026 + play, floor, 0.05)
    house = box(-0.04, 0.04, -0.04, 0.04, -0.012, 0.045) - cylinder(0.02 + play, -0.004 - push, 0.05)
    house -= wide ^ two_lugs(0.06, floor, 0.05, -13, 13)
    house -= wide ^ two_lugs(0.06, floor, 0.0225 - push, -13, 83)
    if push:
        house -= wide ^ two_lugs(0.06, floor, 0.0225, 57, 83)
    return part, house


def key() -> tuple[Any, Any]:
    bit = box(0, 0.014, -0.0015, 0.0015, 0.005, 0.015)
    part = (cylinder(0.004, 0, 0.06, 16) + bit).rotate((0, 0, 90))
    lock = box(-0.03, 0.03, -0.03, 0.03, -0.005, 0.04) - cylinder(0.0043, -0.001, 0.05)
    return part, lock - cylinder(0.0148, 0.003, 0.017) - box(0, 0.0145, -0.0019, 0.0019, 0, 0.05)


def panel() -> tuple[Any, Any]:
    """It lies flat, and has to be set up to fit through a window with 1 mm to spare."""
    room = box(-0.75, 0.75, -0.55, 0.55, -0.55, 0.55) - box(-0.7, 0.7, -0.5, 0.5, -0.5, 0.5)
    return box(-0.5, 0.5, -0.3, 0.3, -0.01, 0.01), room - box(0.6, 0.8, -0.011, 0.011, -0.301, 0.301)


def angled_slot() -> tuple[Any, Any]:
    """A pin with a head on both sides of a plate, in a slot that turns a corner."""
    pin = cylinder(0.006, -0.02, 0.02) + cylinder(0.012, 0.0105, 0.02) + cylinder(0.012, -0.02, -0.0105)
    half = 0.0062
    slot = box(-half, half, -half, 0.05, -0.02, 0.02) + box(-half, 0.2, 0.05 - half, 0.05 + half, -0.02, 0.02)
    return pin, box(-0.1, 0.1, -0.1, 0.1, -0.01, 0.01) - slot - cylinder(half, -0.02, 0.02)


def maze() -> tuple[Any, Any]:
    rows = ["#######", "#S# # #", "# # # #", "#   # #", "### # #", "#     #", "##### #"]
    walls = box(0, 7, -7, 0, -0.2, 0) + box(0, 7, -7, 0, 1, 1.2)
    for y, row in enumerate(rows):
        for x in (x for x, cell in enumerate(row) if cell == "#"):
            walls += box(x, x + 1, -y - 1, -y, 0, 1)
    return box(1.1, 1.9, -1.9, -1.1, 0.05, 0.95).scale((0.02,) * 3), walls.scale((0.02,) * 3)


def under_a_roof() -> tuple[Any, Any]:
    """A headed bolt in a hole, under a roof with one wall: up, then sideways."""
    bolt = cylinder(0.005, 0, 0.041, 24) + cylinder(0.008, 0.0401, 0.046, 6)
    plate = box(-0.03, 0.03, -0.03, 0.03, 0.01, 0.04) - cylinder(0.0051, 0, 0.05, 24)
    return bolt, plate + box(-0.05, 0.05, -0.05, 0.05, 0.2, 0.21) + box(0.045, 0.05, -0.05, 0.05, 0, 0.205)


PUZZLES = {
    "bayonet": bayonet(0.0),
    "bayonet to push": bayonet(0.004),
    "key": key(),
    "panel": panel(),
    "slot": angled_slot(),
    "maze": maze(),
    "roof": under_a_roof(),
}


def turned(rng: np.random.Generator) -> Floats:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def bvh(vertices: Floats, faces: npt.NDArray[np.int64]) -> Any:
    made = coal.BVHModelOBBRSS()
    made.beginModel(len(faces), len(vertices))
    made.addVertices(vertices)
    made.addTriangles(faces)
    made.endModel()
    return made


def samples(tool: feeler.Tool, poses: Floats, count: int) -> Floats:
    """Poses on the way: the middle of the box straight, the turn about it at constant speed."""
    middle = tool.bounds.mean(axis=0)
    out = []
    for a, b in pairwise(poses):
        turn = b[:3, :3] @ a[:3, :3].T
        axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        sine, cosine = 0.5 * np.linalg.norm(axis), 0.5 * (np.trace(turn) - 1.0)
        angle = np.arctan2(sine, cosine)
        cross = np.cross(np.eye(3), axis / max(2.0 * sine, 1e-300)) if sine > 1e-12 else np.zeros((3, 3))
        from_, to = (pose[:3, :3] @ middle + pose[:3, 3] for pose in (a, b))
        for t in np.linspace(0.0, 1.0, count):
            cross_t = np.sin(angle * t) * cross + (1.0 - np.cos(angle * t)) * (cross @ cross)
            pose = np.eye(4)
            pose[:3, :3] = (np.eye(3) + cross_t) @ a[:3, :3]
            pose[:3, 3] = from_ + t * (to - from_) - pose[:3, :3] @ middle
            out.append(pose)
    return np.array(out)


@pytest.mark.parametrize("name", PUZZLES)
def test_a_way_is_found_and_free_by_another_library(name: str) -> None:
    turn = turned(np.random.default_rng(len(name)))
    part, rest = ((v @ turn.T, f) for v, f in map(arrays, PUZZLES[name]))
    scene = feeler.Scene(mockup_of({"part": part, "rest": rest}))
    found = feeler.removal(scene, "part", seconds=60.0, threads=1)
    assert found.is_found and found.certificate.method != "straight"
    moving, still, request = bvh(*part), bvh(*rest), coal.CollisionRequest()
    tool = feeler.Tool.of_parts(scene.mockup, "part")
    way = samples(tool, found.poses, 150)
    assert np.allclose(way[-1], found.poses[-1], atol=1e-9)
    for pose in way:
        place = coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy())
        result = coal.CollisionResult()
        assert not coal.collide(moving, place, still, coal.Transform3s.Identity(), request, result)


def test_a_key_is_turned_and_pulled_by_exact_legs() -> None:
    """A turn is one screw about the lock's axis; saved and read again, the way is the same."""
    scene = feeler.Scene(mockup_of({"part": arrays(PUZZLES["key"][0]), "rest": arrays(PUZZLES["key"][1])}))
    found = feeler.removal(scene, "part", seconds=60.0, threads=1)
    turn, pull = found.legs[0], found.legs[-1]
    assert turn.screw is not None and turn.screw.pitch == 0.0
    assert np.degrees(turn.rotation) == pytest.approx(90.0, abs=10.0) and str(turn).startswith("turn ")
    assert pull.screw is None and pull.rotation == 0.0 and re.fullmatch(r"move [\d.]+ mm along [+-][xyz]", str(pull))
    assert np.allclose(turn.screw.at(np.eye(4)), turn.pose, atol=1e-12)
    assert sum(leg.path_length for leg in found.legs) == found.path_length
    assert np.array_equal(found.legs[-1].pose, found.poses[-1])
    tool, rest = feeler.Tool.of_parts(scene.mockup, "part"), scene.without("part")
    saved = json.loads(json.dumps([leg.to_dict() for leg in found.legs]))
    path = path_of_json(saved)
    assert path[1] == turn.screw and len(path) == len(found.path)
    assert rest.check_path(tool, path, touching="free").is_free
    # The way in is the same, turned round.
    into = feeler.insertion(scene, "part", seconds=60.0, threads=1)
    assert into.legs[-1].screw == turn.screw.reversed()
    np.testing.assert_allclose(into.legs[-1].screw.at(into.legs[-2].pose), np.eye(4), atol=1e-12)
    assert rest.check_path(tool, into.path, touching="free").is_free
    # Turned by half of it, it does not come out.
    half = feeler.Screw(turn.screw.axis, turn.screw.point, 0.5 * turn.screw.angle)
    out = half.at(np.eye(4))
    out[:3, 3] += found.legs[-1].pose[:3, 3] - turn.pose[:3, 3]
    assert not rest.check_path(tool, [np.eye(4), half, out], touching="free").is_free


def test_legs_are_said_as_a_person_says_them() -> None:
    def leg(screw: feeler.Screw | None, length: float, angle: float, direction: tuple[float, float, float]) -> str:
        return str(feeler.RemovalLeg(screw, np.eye(4), length, np.radians(angle), direction))

    thread = feeler.Screw((0, 0, 1), (0, 0, 0), np.radians(-900), -0.002)
    assert leg(thread, 0.005, 900, (0, 0, -1)) == "screw 2.5 turns about -z, 5 mm along it"
    assert leg(feeler.Screw((1, 0, 0), (0, 0, 0), 1.5), 0.1, 85.9, (1, 0, 0)) == "turn 85.9 degrees about +x"
    assert leg(None, 0.042, 0, (0, -1, 0)) == "move 42 mm along -y"
    assert leg(None, 1.5, 0, (0.6, 0.8, 0)) == "move 1.5 m along (0.60, 0.80, 0.00)"
    # An axis is named only where two decimals show nothing else.
    assert leg(None, 0.797, 0, (0.9994, 0.032, 0.016)) == "move 797 mm along (1.00, 0.03, 0.02)"
    assert leg(None, 0.797, 0, (-0.99999, 0.004, -0.001)) == "move 797 mm along -x"
    assert leg(None, 2e-6, 12, (0.6, 0.8, 0)) == "move 2 um and turn 12 degrees"
    assert leg(None, 1e-19, 12, (0, 0, 0)) == "turn 12 degrees in place"


@pytest.mark.parametrize("leg", [{}, {"screw": {"axis": [0, 0, 1]}}, "to", {"from": 1}])
def test_what_is_no_leg_is_said(leg: object) -> None:
    with pytest.raises(ValueError, match="a leg is"):
        path_of_json([leg])  # type: ignore[list-item]


def test_a_closed_box_is_not_left() -> None:
    room = box(-0.05, 0.05, -0.05, 0.05, -0.05, 0.05) - box(-0.04, 0.04, -0.04, 0.04, -0.04, 0.04)
    scene = feeler.Scene(mockup_of({"part": arrays(box(-0.01, 0.01, -0.01, 0.01, -0.01, 0.01)), "rest": arrays(room)}))
    found = feeler.removal(scene, "part", seconds=0.5, threads=1)
    assert not found.is_found and [each.path for each in found.blocked_by] == ["rest"]
