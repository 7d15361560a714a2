"""Renamed parts keep their findings if they are meshed anew, and lose them if they have another size or place."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from clash_scene import mockup_of
from shapes import Mesh, box
from test_clash_matching import bolt_at, bolts, checked, cylinder, named, shifted

import feeler
from feeler.clashes.matching import matched
from feeler.clashes.shapes import shapes_of
from feeler.errors import LoadError

BLOCK = box((-5, -5, -5), (5, 5, 0))


def ball(facets: int, radius: float = 1.0) -> Mesh:
    """A ball at (1, 2, 3) with `facets` meridians, corners on the sphere."""
    bands = max(facets // 2, 4)
    polar = np.repeat(np.pi * np.arange(1, bands) / bands, facets)
    around = np.tile(2.0 * np.pi * np.arange(facets) / facets, bands - 1)
    ring = np.column_stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)])
    vertices = np.concatenate([ring, [[0, 0, 1], [0, 0, -1]]]) * radius + [1, 2, 3]
    i, j = np.arange(facets), (np.arange(facets) + 1) % facets
    north, south, last = np.full(facets, len(ring)), np.full(facets, len(ring) + 1), (bands - 2) * facets
    faces = [np.column_stack([north, i, j]), np.column_stack([south, last + j, last + i])]
    for band in range(bands - 2):
        low = band * facets
        faces += [
            np.column_stack([low + i, low + facets + i, low + j]),
            np.column_stack([low + j, low + facets + i, low + facets + j]),
        ]
    return vertices, np.concatenate(faces)


def sleeve(facets: int, radius: float, wall: float = 0.002) -> Mesh:
    """A tube on the origin, 40 mm long."""
    angles = 2.0 * np.pi * np.arange(facets) / facets
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(facets)])
    up = np.array([0, 0, 0.04])
    rings = [ring * radius, ring * radius + up, ring * (radius + wall) + up, ring * (radius + wall)]
    i, j = np.arange(facets), (np.arange(facets) + 1) % facets
    faces = []
    for k in range(4):
        a, b = k * facets, (k + 1) % 4 * facets
        faces += [np.column_stack([a + i, b + j, a + j]), np.column_stack([a + i, b + i, b + j])]
    return np.concatenate(rings), np.concatenate(faces)


def is_same(one: Mesh, other: Mesh) -> bool:
    """Whether a part of another path is the same part."""
    ground = ("ground", box((-9, -9, -9), (-8, -8, -8)))
    before, now = (shapes_of(named([ground, (name, mesh)])) for name, mesh in (("a", one), ("b", other)))
    return bool(matched(before, now)[1][1])


def turned(mesh: Mesh, about: Sequence[float] = (0, 0, 0)) -> Mesh:
    """The mesh turned by 0.3 about z."""
    cos, sin = np.cos(0.3), np.sin(0.3)
    return (mesh[0] - about) @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + about, mesh[1]


FACETS = (8, 12, 16, 24, 48, 64)
ROUND: dict[str, Callable[[int], Mesh]] = {
    "ball": ball,
    "pin": lambda facets: cylinder(facets, (1, 2, 3), 0.1, 0.5),
    "disc": lambda facets: cylinder(facets, (1, 2, 3), 1.0, 0.02),
    "sleeve": lambda facets: shifted(sleeve(facets, 0.02), (1, 2, 3)),
}


@pytest.mark.parametrize("kind", ROUND)
def test_round_parts_may_be_meshed_anew(kind: str) -> None:
    """At any chord, and with the corners in other places."""
    meshes = [ROUND[kind](facets) for facets in FACETS]
    for one in meshes:
        for other in meshes:
            assert is_same(one, other) and is_same(one, turned(other, (1, 2, 3)))


@pytest.mark.parametrize("kind", ROUND)
@pytest.mark.parametrize("growth", [0.95, 1.05, 1.1])
def test_round_parts_of_another_size_are_other_parts(kind: str, growth: float) -> None:
    for facets in (16, 24, 64):
        vertices, faces = ROUND[kind](facets)
        grown = (vertices - [1, 2, 3]) * [growth, growth, 1.0] + [1, 2, 3], faces
        for before in (16, 24, 64):
            assert not is_same(ROUND[kind](before), grown), (before, facets)


def test_parts_with_equally_many_triangles_are_told_apart_by_less_than_their_chords() -> None:
    for facets in (8, 16, 32):
        for growth in (1.002, 1.01, 1.05):
            assert not is_same(sleeve(facets, 0.02), sleeve(facets, 0.02 * growth))
            assert not is_same(cylinder(facets, (0, 0, 0), 1, 1), cylinder(facets, (0, 0, 0), growth, 1))


CUBE = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    "other",
    [
        box((-0.54, -0.5, -0.5), (0.54, 0.5, 0.5)),
        box((-0.5, -0.5, -0.5), (0.51, 0.5, 0.5)),
        box((-0.5005, -0.5, -0.5), (0.5005, 0.5, 0.5)),
        box((-0.525, -0.525, -0.525), (0.525, 0.525, 0.525)),
        box((-0.4999, -0.5, -0.5), (0.5001, 0.5, 0.5)),
    ],
)
def test_flat_parts_of_another_size_or_place_are_other_parts(other: Mesh) -> None:
    before = checked(mockup_of({"asm/block": BLOCK, "asm/pin": CUBE}))
    before.set_status(before.ids[0], "approved")
    now = checked(mockup_of({"asm/block": BLOCK, "asm/other": other}))
    assert now.diff(before, growth=10.0).counts()["new"] == 1
    assert not is_same(CUBE, other)


def test_flat_parts_may_be_cut_otherwise_and_nudged() -> None:
    vertices, faces = CUBE
    middle = vertices[faces].mean(axis=1)
    finer = np.concatenate(
        [np.column_stack([faces[:, i], faces[:, (i + 1) % 3], 8 + np.arange(len(faces))]) for i in range(3)]
    )
    assert is_same(CUBE, shifted((np.concatenate([vertices, middle]), finer), (1e-6, -1e-6, 1e-6)))
    assert is_same(CUBE, shifted(CUBE, (1e-6, 1e-6, 0)))


def test_a_thin_washer_that_moved_is_another_part() -> None:
    washer = box((-0.012, -0.012, 0), (0.012, 0.012, 0.001))
    for by in ((0, 0, 1e-4), (1e-3, 0, 0), (1e-4, 0, 0)):
        assert not is_same(washer, shifted(washer, by))


def test_edges_are_not_chords_and_triangles_may_have_corners_of_their_own() -> None:
    """Hexagons, wedges and boxes are flat; a soup of triangles, of any orientation, is as round as its mesh."""
    vertices, faces = cylinder(16, (1, 2, 3), 0.1, 0.5)
    wedge = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0.2], [0, 1, 0], [1, 1, 0], [1, 1, 0.2]], dtype=float)
    sides = np.array([[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [0, 5, 3], [0, 2, 5]])
    soup = vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    flipped = soup[0], np.where((np.arange(len(faces)) % 3 == 0)[:, None], soup[1][:, ::-1], soup[1])
    meshes = [CUBE, cylinder(6, (0, 0, 0), 1, 1), (wedge, sides), (vertices, faces), soup, flipped]
    chord = shapes_of(named([(str(i), mesh) for i, mesh in enumerate(meshes)])).chord
    sagitta = 0.1 * (1 - np.cos(np.pi / 16))
    assert np.allclose(chord, [0, 0, 0, sagitta, sagitta, sagitta], rtol=0, atol=1e-8)


def test_chords_do_not_depend_on_where_the_triangles_are() -> None:
    """Parts whose triangles are mixed, and more triangles than are read at once."""
    mockup = named([("a", ball(256)), ("b", cylinder(8, (0, 0, 0), 1, 1)), ("c", ball(12))])
    order = np.random.default_rng(3).permutation(len(mockup.faces))
    mixed = feeler.Mockup(mockup.vertices, mockup.faces[order], mockup.part_of_face[order], mockup.part_names)
    one, two = shapes_of(mockup), shapes_of(mixed)
    assert mockup.triangle_count > 2**15
    for name in ("triangles", "chord", "area_error"):
        assert (getattr(one, name) == getattr(two, name)).all(), name
    assert 0 < one.chord[0] < one.chord[2] < one.chord[1]


def test_files_have_chords_and_older_ones_are_read(tmp_path: Path) -> None:
    """Parts of older files match within the shares of that version."""
    before = checked(bolts(0.2))
    before.set_status(before.ids[0], "approved")
    before.save(tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    assert data["shapes"][0]["chord"] > 0.0
    for name in ("triangles", "chord", "area_error"):
        for value in (-1, "x"):
            broken = json.loads(json.dumps(data))
            broken["shapes"][0][name] = value
            (tmp_path / "b.json").write_text(json.dumps(broken))
            with pytest.raises(LoadError, match=r"shapes\[0\] is not a shape"):
                feeler.load_clashes(tmp_path / "b.json")
    thicker = named(
        [("rig/plate", box((0, 0, 0), (1, 0.2, 0.01))), ("rig/pin", cylinder(24, (0.2, 0.1, -0.02), 0.0102, 0.05))]
    )
    for each in data["shapes"]:
        del each["triangles"], each["chord"], each["area_error"]
    (tmp_path / "old.json").write_text(json.dumps(data))
    for name, mockup, status in (
        ("old.json", bolts(0.2, facets=48, path="rig/pin"), "approved"),
        ("old.json", thicker, "approved"),
        ("a.json", thicker, "new"),
    ):
        now = checked(mockup)
        now.diff(feeler.load_clashes(tmp_path / name), growth=1.0)
        assert now[0].status == status
    old = feeler.load_clashes(tmp_path / "old.json")
    old.save(tmp_path / "again.json")
    assert "chord" not in (tmp_path / "again.json").read_text()


# --- patterns that move -----------------------------------------------------------------------------------------------

HOLES = (0.1, 0.3, 0.5, 0.7)


@pytest.mark.parametrize("path", ["rig/bolt", "rig/screw"])
def test_a_row_of_bolts_that_moves_to_other_holes_needs_new_approvals(path: str) -> None:
    """The plate stays, so the assembly has not moved; of equal names, and renamed with the plate."""
    before = checked(bolts(*HOLES))
    for each in before.ids:
        before.set_status(each, "approved")
    moved = [x + 0.1 for x in HOLES]
    plate = "rig/plate" if path == "rig/bolt" else "rig/slab"
    parts = [(plate, box((0, 0, 0), (1, 0.2, 0.01))), *((path, bolt_at(x)) for x in moved)]
    now = checked(named(parts))
    assert now.diff(before).counts()["new"] == 4


def test_equal_names_move_with_a_part_of_their_own_name() -> None:
    """A sub-assembly of equal bolts and a bracket moves; the plate, more parts, stays."""
    bracket = box((0.05, 0, 0.01), (0.75, 0.2, 0.015))
    still = [(f"rig/rail {i}", box((i, 1, 0), (i + 0.5, 1.2, 0.1))) for i in range(9)]

    def mockup(by: float) -> feeler.Mockup:
        group = [("rig/bracket", bracket), *(("rig/bolt", bolt_at(x)) for x in HOLES)]
        plate = ("rig/plate", box((0, 0, 0), (2, 0.2, 0.01)))
        return named([plate, *still, *((path, shifted(mesh, (by, 0, 0))) for path, mesh in group)])

    before = checked(mockup(0.0))
    for each in before.ids:
        before.set_status(each, "approved")
    for by in (0.1, 0.55):
        assert checked(mockup(by)).diff(before).counts()["new"] == 0


def test_the_motion_of_unique_parts_is_that_of_the_whole() -> None:
    """A pattern matches itself when it moves by its pitch, so its number of parts says nothing."""
    cubes = [(f"old/{i}", shifted(CUBE, (2 * i, 0, 0))) for i in range(6)]
    slab = box((0, 5, 0), (7, 6, 0.5))
    before = shapes_of(named([("old/slab", slab), *cubes]))
    moved = [(f"new/c{i}", shifted(CUBE, (2 * i + 1, 0, 0))) for i in range(6)]
    now = shapes_of(named([("new/slab", slab), *moved]))
    assert matched(before, now)[0].tolist() == [0, *[-1] * 6]
    whole = shapes_of(named([("new/slab", shifted(slab, (1, 0, 0))), *moved]))
    assert matched(before, whole)[0].tolist() == [*range(7)]
    unknown = replace(now, area=np.full(len(now.keys), np.nan))
    assert (matched(before, unknown)[0] == -1).all()


def test_parts_that_changed_below_a_renamed_root_go_by_the_rest_of_their_paths() -> None:
    """The others say how the root is called now; where a part has another name of its own, nothing does."""
    pin = shifted(CUBE, (3, 0, 0))

    def mockup(root: str, name: str, mesh: Mesh) -> feeler.Mockup:
        return mockup_of({f"{root}/block": BLOCK, f"{root}/sub/pin": CUBE, f"{root}/sub/{name}": mesh})

    before = checked(mockup("revA", "key", pin))
    for each in before.ids:
        before.set_status(each, "approved")
    for root, name, by, kept in (("revB", "key", 0.1, 2), ("revB/x", "key", 0.1, 2), ("revB", "cam", 0.1, 1)):
        now = checked(mockup(root, name, shifted(pin, (by, 0, 0))))
        assert now.diff(before).counts()["approved"] == kept
        assert sorted(now.changed) == sorted(["renamed"] * kept + [""] * (2 - kept))
