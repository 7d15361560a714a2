"""Fasteners: shapes of known kind, size and place, alone and in the samples, which know theirs."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from fastener_truth import sample_and_truth, scores, without_names
from point_depths import quartered
from shapes import at, box, cube, joined, mockup_of

import feeler
from feeler.errors import MeshError, OptionError
from feeler.part_meshes import PartMeshes
from feeler.plan.fastener_names import kind_said
from feeler.plan.same_shapes import same_shapes
from feeler.samples import hardware
from feeler.samples.mesh import Mesh
from feeler.samples.shapes import skin_loops
from feeler.samples.tessellation import Tolerance, circle, hexagon

Floats = npt.NDArray[np.float64]

FINE, USUAL, COARSE = Tolerance(1e-5), Tolerance(1e-4), Tolerance(4e-4)


def tilted(seed: int) -> Floats:
    """A pose somewhere, in no special direction."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn * np.sign(np.linalg.det(turn)), rng.uniform(-2, 2, 3)
    return pose


def placed(mesh: Mesh, pose: Floats) -> tuple[Floats, npt.NDArray[np.int64]]:
    return mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces.astype(np.int64)


def found_of(mesh: Mesh, pose: Floats, name: str = "part") -> feeler.Fastener:
    (row,) = feeler.find_fasteners(mockup_of({name: placed(mesh, pose)}))
    return row


def check_frame(row: feeler.Fastener, top: Floats, off: float = 1e-6) -> None:
    assert np.linalg.norm(row.frame[:3, 3] - top[:3, 3]) < off
    assert row.axis @ top[:3, 2] > 1 - 1e-6
    assert np.allclose(row.frame[:3, :3] @ row.frame[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(row.frame[:3, :3]) > 0


@pytest.mark.parametrize("tolerance", [FINE, USUAL, COARSE])
@pytest.mark.parametrize("seed", range(3))
def test_a_hexagon_bolt(tolerance: Tolerance, seed: int) -> None:
    pose = tilted(seed)
    row = found_of(hardware.hex_bolt(0.008, 0.03, tolerance), pose)
    check_frame(row, pose @ at(z=0.68 * 0.008))
    assert row.kind == "bolt" and row.confidence == 0.9
    assert row.size == pytest.approx(0.008, rel=1e-6)
    assert row.across_flats == pytest.approx(1.65 * 0.008, rel=1e-6)
    assert row.length == pytest.approx(0.03, rel=1e-6) and row.head_height == pytest.approx(0.68 * 0.008, rel=1e-6)
    assert row.because == "a hexagon, 13.2 mm across flats, on a shank of 8 mm"


@pytest.mark.parametrize("tolerance", [FINE, USUAL])
@pytest.mark.parametrize("seed", range(3))
def test_a_socket_head_screw(tolerance: Tolerance, seed: int) -> None:
    pose = tilted(seed)
    row = found_of(hardware.cap_screw(0.006, 0.02, tolerance), pose)
    check_frame(row, pose @ at(z=0.006))
    assert row.kind == "screw" and row.size == pytest.approx(0.006, rel=1e-6)
    assert row.across_flats == pytest.approx(0.8 * 0.006, rel=1e-6)
    assert row.length == pytest.approx(0.02, rel=1e-6) and row.head_height == pytest.approx(0.006, rel=1e-6)


def test_a_round_head_without_a_socket_is_less_sure() -> None:
    mesh = hardware.cap_screw(0.006, 0.02, Tolerance(4.2e-4))
    row = found_of(mesh, np.eye(4))
    check_frame(row, at(z=0.9 * 0.006))
    assert row.kind == "screw" and row.confidence == 0.5 and np.isnan(row.across_flats)
    assert found_of(mesh, np.eye(4), "M6 screw").confidence == 0.99


def plate_under(low: float, high: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Four blocks around a hole, as a flange under a nut."""
    sides = [
        ((-0.1, -0.1), (0.1, -0.004)),
        ((-0.1, 0.004), (0.1, 0.1)),
        ((-0.1, -0.004), (-0.004, 0.004)),
        ((0.004, -0.004), (0.1, 0.004)),
    ]
    return joined(*(box((*a, low), (*b, high)) for a, b in sides))


@pytest.mark.parametrize("tolerance", [FINE, USUAL, COARSE])
@pytest.mark.parametrize("is_under", [True, False])
def test_a_nut_points_away_from_the_joint(tolerance: Tolerance, is_under: bool) -> None:
    nut = hardware.nut(0.008, tolerance)
    plate = plate_under(-0.01, -1e-4) if is_under else plate_under(0.0064 + 1e-4, 0.02)
    for seed in range(3):
        pose = tilted(seed)
        parts = {"nut": placed(nut, pose), "plate": placed(Mesh(*plate), pose)}
        mockup = mockup_of(parts)
        for given in (mockup, feeler.Scene(mockup)):
            (row,) = feeler.find_fasteners(given)
            check_frame(row, pose @ (at(z=0.0064) if is_under else at(degrees=180.0, axis=0)))
        assert row.kind == "nut" and row.across_flats == pytest.approx(1.65 * 0.008, rel=1e-6)
        assert row.size == pytest.approx(0.008, rel=0.1) and row.length == pytest.approx(0.0064, rel=1e-6)
    (row,) = feeler.find_fasteners(feeler.Scene(mockup).without("plate"))
    assert row.part == 0
    assert not feeler.find_fasteners(feeler.Scene(mockup).without("nut"))


def test_a_finely_cut_nut_has_no_slots() -> None:
    nut = hardware.nut(0.008, USUAL)
    triangles = quartered(nut.vertices[nut.faces])
    cut = Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3))
    for low, high in ((-0.01, -1e-4), (0.0064 + 1e-4, 0.02)):
        found = [
            feeler.find_fasteners(
                mockup_of({"nut": placed(mesh, tilted(5)), "plate": placed(Mesh(*plate_under(low, high)), tilted(5))})
            )[0]
            for mesh in (nut, cut)
        ]
        assert np.allclose(found[0].axis, found[1].axis, atol=1e-9) and found[1].kind == "nut"


@pytest.mark.parametrize("kind", ["doubled", "wound at random", "inside out", "in part"])
def test_drives_of_dirty_meshes(kind: str) -> None:
    """Unshared corners, triangles twice, and neighbours that are wound against each other."""
    rng = np.random.default_rng(7)
    for mesh in (hardware.hex_bolt(0.008, 0.03, USUAL), hardware.nut(0.008, USUAL)):
        faces = mesh.faces
        if kind == "doubled":
            faces = np.concatenate([faces, np.roll(faces[::-1], 1, axis=1)])
        elif kind == "inside out":
            faces = faces[:, ::-1]
        else:
            share = 0.5 if kind == "wound at random" else 0.1
            faces = np.where(rng.random(len(faces))[:, None] < share, faces[:, ::-1], faces)
        soup = mesh.vertices[faces].reshape(-1, 3)
        dirty = Mesh(soup, np.arange(len(soup), dtype=np.int32).reshape(-1, 3))
        clean, row = found_of(mesh, tilted(2)), found_of(dirty, tilted(2))
        assert (row.kind, row.drive, row.confidence) == (clean.kind, clean.drive, clean.confidence)
        assert row.across_flats == pytest.approx(clean.across_flats) and row.length == pytest.approx(clean.length)


def test_a_flanged_nut_has_its_flange_on_the_joint() -> None:
    nut, flange = hardware.nut(0.008, USUAL), hardware.ring(0.004, 0.009, 0.001, USUAL)
    mesh = Mesh(*joined((nut.vertices + np.array([0, 0, 0.001]), nut.faces), (flange.vertices, flange.faces)))
    check_frame(found_of(mesh, tilted(4)), tilted(4) @ at(z=0.0074))
    # Whatever is near its other end.
    parts = {"nut": placed(mesh, np.eye(4)), "plate": plate_under(0.0075, 0.01)}
    (row,) = feeler.find_fasteners(mockup_of(parts))
    check_frame(row, at(z=0.0074))


def test_a_head_without_a_shank_is_buried_in_the_joint() -> None:
    """The coarsest bolt is a prism that goes a little into what it holds."""
    mesh = hardware.hex_bolt(0.006, 0.02, Tolerance(6e-3))
    plate = box((-0.1, -0.1, -0.01), (0.1, 0.1, 0.0))
    for seed in range(3):
        pose = tilted(seed)
        parts = {"a": placed(Mesh(*plate), pose), "b": placed(mesh, pose)}
        (row,) = feeler.find_fasteners(mockup_of(parts))
        check_frame(row, pose @ at(z=0.68 * 0.006))
        assert row.kind == "bolt" and row.confidence == 0.5 and np.isnan(row.size)


def test_of_a_stud_the_name_says_what_it_is() -> None:
    rod = hardware.roller(0.004, 0.05, USUAL)
    parts = {"stud": placed(rod, at(z=0.01)), "plate": box((-0.1, -0.1, -0.03), (0.1, 0.1, -0.001))}
    (row,) = feeler.find_fasteners(mockup_of(parts))
    check_frame(row, at(z=0.035))
    assert row.kind == "stud" and row.confidence == 0.6 and row.size == pytest.approx(0.008, rel=0.15)
    assert "its name says stud" in row.because
    assert not feeler.find_fasteners(mockup_of({"pin": parts["stud"], "plate": parts["plate"]}))


def test_a_default_name_leaves_it_to_the_step_above_if_that_is_of_one_part() -> None:
    """Blender's COLLADA names geometries "Cylinder.001"; a file of a screw pump is not all of screws."""
    rod, plate = placed(hardware.roller(0.004, 0.05, USUAL), at(z=0.01)), box((-0.1, -0.1, -0.03), (0.1, 0.1, -0.001))
    for name in ("Cylinder.001", "Cylinder-mesh", "geom-12", "Cube", "Solid1", "Body (2)"):
        (row,) = feeler.find_fasteners(mockup_of({f"engine/stud/{name}": rod, "engine/plate": plate}))
        assert row.kind == "stud" and "its name says stud" in row.because
        assert not feeler.find_fasteners(mockup_of({f"stud press/{name}": rod, "stud press/plate": plate}))


def test_a_rod_in_a_nut_is_a_stud() -> None:
    rod, nut = hardware.roller(0.004, 0.05, USUAL), hardware.nut(0.008, USUAL)
    pose = tilted(3)
    parts = {"Part 1": placed(rod, pose @ at(z=-0.01)), "Part 2": placed(nut, pose)}
    parts["Part 3"] = placed(Mesh(*plate_under(-0.01, -1e-4)), pose)
    stud, found = feeler.find_fasteners(mockup_of(parts))
    assert (stud.part, stud.kind, stud.drive, found.kind) == (0, "stud", "", "nut")
    assert stud.because.endswith("in the bore of Part 2") and stud.length == pytest.approx(0.05, rel=1e-6)
    check_frame(stud, pose @ at(z=0.015))
    tube = hardware.ring(0.0035, 0.004, 0.05, USUAL)
    for name, other in (("Part 1", tube), ("Part 1", hardware.roller(0.002, 0.05, USUAL)), ("pin", rod)):
        beside = {name: placed(other, pose @ at(z=-0.01)), "Part 2": placed(nut, pose)}
        assert [row.part for row in feeler.find_fasteners(mockup_of(beside))] == [1]


def test_a_sensor_is_told_by_its_name() -> None:
    """Connectors look alike: a thread, a hexagon and a round body."""
    loops = [circle(0.006, 24, -0.017), circle(0.006, 24, -0.008), hexagon(0.017, -0.008), hexagon(0.017, 0.0)]
    mesh = skin_loops([*loops, circle(0.007, 24, 0.0), circle(0.007, 24, 0.012)])
    row = found_of(mesh, tilted(2), "speed sensor")
    check_frame(row, tilted(2))
    assert (row.kind, row.drive, row.confidence) == ("bolt", "hexagon", 0.99)
    assert row.across_flats == pytest.approx(0.017, rel=1e-6)
    assert not feeler.find_fasteners(mockup_of({"receptacle": placed(mesh, tilted(2))}))


def test_a_block_with_a_hole_is_no_nut_because_its_name_says_sensor() -> None:
    """The word confirms a hexagon that is screwed in, and no nut."""
    square = [(sign * 0.01, other * 0.01) for sign, other in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    side = np.array([*square, square[0]])
    outline = [side[k] + t * (side[k + 1] - side[k]) for k in range(4) for t in np.arange(6) / 6.0]
    outside = [np.column_stack([np.array(outline), np.full(24, z)]) for z in (0.0, 0.008)]
    start = np.arctan2(outline[0][1], outline[0][0])
    turn = start + np.arange(24) * (2.0 * np.pi / 24)
    for bore in (0.0025, 0.004):
        hole = [np.column_stack([bore * np.cos(turn), bore * np.sin(turn), np.full(24, z)]) for z in (0.008, 0.0)]
        mesh = skin_loops([*outside, *hole], closed=True)
        for name in ("sensor", "speed_sensor_2", "plug"):
            assert not feeler.find_fasteners(mockup_of({name: placed(mesh, tilted(3))})), (bore, name)


DRAWN = pytest.importorskip("drawn_fasteners") if find_spec("manifold3d") else None


@pytest.mark.skipif(DRAWN is None, reason="manifold3d draws them")
@pytest.mark.parametrize("shape", [] if DRAWN is None else [*DRAWN.FASTENERS, *DRAWN.OTHERS])
def test_fasteners_as_others_draw_them(shape: str) -> None:
    """Without names: kind, drive, width and place of each, at random cuts, sizes and poses, also inside out."""
    for seed in range(8):
        made, mockup, pose = DRAWN.drawn(shape, seed)
        assert DRAWN.fault_of(made, pose, feeler.find_fasteners(mockup)) == "", f"seed {seed}"


def hollow_bolt() -> Mesh:
    """A hexagon on a tube: a union's nut."""
    outside = [circle(0.004, 24, -0.03), circle(0.004, 24), hexagon(0.0132), hexagon(0.0132, 0.005)]
    return skin_loops([*outside, circle(0.002, 24, 0.005), circle(0.002, 24, -0.03)], closed=True)


def on_a_square() -> Mesh:
    """A hexagon bolt that is one part with a square plate."""
    bolt = hardware.hex_bolt(0.008, 0.05, USUAL)
    return Mesh(*joined((bolt.vertices, bolt.faces), box((-0.02, -0.02, -0.004), (0.02, 0.02, 0.0))))


@pytest.mark.parametrize(
    "mesh",
    [
        hollow_bolt(),
        on_a_square(),
        hardware.hex_bolt(0.03, 0.05, Tolerance(6e-3)),
        Mesh(
            hardware.cap_screw(0.006, 0.02, Tolerance(4.2e-4)).vertices * 8.0,
            hardware.cap_screw(0.006, 0.02, Tolerance(4.2e-4)).faces,
        ),
        Mesh(*cube((0, 0, 0), 0.01)),
        Mesh(*box((0, 0, 0), (0.01, 0.02, 0.03))),
        hardware.washer(0.008, USUAL),
        hardware.ring(0.01, 0.012, 0.05, USUAL),
        hardware.ball(0.01, USUAL),
        hardware.roller(0.004, 0.05, USUAL),
        hardware.rivet(0.004, USUAL),
        hardware.race(0.02, 0.03, 0.01, 0.004, True, USUAL),
        hardware.union(0.004, USUAL),
        hardware.union(0.002, USUAL),
        hardware.union(0.01, FINE),
        hardware.boss(0.01, 0.01, 0.004, USUAL),
        hardware.connector(0.01, 0.05, USUAL),
        hardware.pump(0.05, 0.12, USUAL),
        hardware.saddle_clamp(0.01, USUAL),
        hardware.angle_bracket(0.05, 0.04, 0.03, USUAL),
        hardware.injector(0.1, USUAL),
        hardware.valve(0.02, USUAL),
    ],
)
def test_other_things_are_none(mesh: Mesh) -> None:
    assert len(feeler.find_fasteners(mockup_of({"part": placed(mesh, tilted(7))}))) == 0


def test_odd_meshes_are_none() -> None:
    flat = (np.zeros((3, 3)), np.array([[0, 1, 2]] * 9))
    nothing = (np.full((3, 3), np.nan), np.array([[0, 1, 2]] * 9))
    outside = (np.eye(3), np.array([[0, 1, 99]] * 9))
    huge = cube((0, 0, 0), 1e5)
    parts = {
        "bolt flat": flat,
        "bolt nan": nothing,
        "bolt huge": huge,
        "bolt": placed(hardware.hex_bolt(0.008, 0.03, USUAL), at(5.0)),
    }
    found = feeler.find_fasteners(mockup_of(parts))
    assert found.parts.tolist() == [3]
    assert not feeler.find_fasteners(mockup_of({"bolt": outside, "cube": cube((0, 0, 0), 1)}))


def test_names_are_a_second_voice() -> None:
    bolt = hardware.hex_bolt(0.008, 0.03, USUAL)
    assert found_of(bolt, np.eye(4), "M8 x 30 hex bolt").confidence == 0.99
    assert not feeler.find_fasteners(mockup_of({"pipe union": placed(bolt, np.eye(4))}))
    prism = hardware.hex_bolt(0.006, 0.02, Tolerance(6e-3))
    both = {"bolt": placed(bolt, np.eye(4)), "thing": placed(prism, at(1.0))}
    assert [row.path for row in feeler.find_fasteners(mockup_of(both))] == ["bolt"]
    both = {"bolt": placed(bolt, np.eye(4)), "Part 12": placed(prism, at(1.0))}
    assert len(feeler.find_fasteners(mockup_of(both))) == 2, "a name that programs give says nothing"
    both = {"part 1": placed(bolt, np.eye(4)), "part 2": placed(prism, at(1.0))}
    assert len(feeler.find_fasteners(mockup_of(both))) == 2


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("bolt_001", "bolt"),
        ("HexBolt-M8x30", "bolt"),
        ("cover_screw_outer", "screw"),
        ("SocketHeadCapScrew(iso4762): M2-0.4x10.0", "screw"),
        ("DIN 933 - M6 x 20", "bolt"),
        ("ISO_4032_M8", "nut"),
        ("din-934", "nut"),
        ("Sechskantmutter M8", "nut"),
        ("Écrou H", "nut"),
        ("stud_nut", "nut"),
        ("nut_stud", "stud"),
        ("bolt_hole", "other"),
        ("nut washer", "other"),
        ("screwdriver", "other"),
        ("pipe/union_2", "other"),
        ("inspection_plug", "plug"),
        ("main_sensor", "plug"),
        ("set screw, socket", "screw"),
        ("Socket Head Cap Screw M6", "screw"),
        ("SCREW_SOCKET_HEAD_M6", "screw"),
        ("washer, for bolt M8", "other"),
        ("bolt socket", "other"),
        ("donut", None),
        ("Flügelmutter M8", "nut"),
        ("Nutmutter KM4", "nut"),
        ("Verschlussschraube", "screw"),
        ("hex bolt with washer", "bolt"),
        ("plate with bolt holes", "other"),
        ("Stehbolzen", "stud"),
        ("prigioniero M8", "stud"),
        ("Schraube mit Bund", "screw"),
        ("part 933", None),
        ("", None),
    ],
)
def test_what_a_name_says(name: str, kind: str | None) -> None:
    assert kind_said(name) == kind


def test_parts_of_one_shape_are_looked_at_once() -> None:
    bolt, other = hardware.hex_bolt(0.008, 0.03, USUAL), hardware.hex_bolt(0.01, 0.03, USUAL)
    mirrored = Mesh(bolt.vertices * [1, 1, 1.5], bolt.faces)
    meshes = [placed(mesh, tilted(i)) for i, mesh in enumerate([bolt, other, bolt, mirrored, bolt, other])]
    mockup = mockup_of({f"p{i}": mesh for i, mesh in enumerate(meshes)})
    shapes = list(same_shapes(mockup, np.arange(6)))
    assert sorted(shape.parts.tolist() for shape in shapes) == [[0, 2, 4], [1, 5], [3]]
    for shape in shapes:
        for part, place in zip(shape.parts, shape.places, strict=True):
            vertices, _ = PartMeshes(mockup).mesh(int(part))
            assert np.allclose(shape.vertices @ place[:3, :3].T + place[:3, 3], vertices, atol=1e-9)


def test_triangles_of_parts_in_any_order() -> None:
    bolt = hardware.hex_bolt(0.008, 0.03, USUAL)
    mockup = mockup_of({"a": placed(bolt, tilted(1)), "b": placed(bolt, tilted(2)), "cube": cube((9, 0, 0), 1.0)})
    order = np.random.default_rng(0).permutation(mockup.triangle_count)
    soup = mockup.vertices[mockup.faces[order]].reshape(-1, 3)
    mixed = feeler.Mockup(soup, np.arange(len(soup)).reshape(-1, 3), mockup.part_of_face[order], mockup.part_names)
    for one, other in zip(feeler.find_fasteners(mockup), feeler.find_fasteners(mixed), strict=True):
        assert one.part == other.part and one.kind == other.kind
        assert np.allclose(one.frame[:, 2:], other.frame[:, 2:], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "triangles", "seed"),
    [
        ("engine", 10_000, 0),
        ("engine", 30_000, 0),
        ("engine", 100_000, 0),
        ("engine", 300_000, 1),
        ("carcass", 10_000, 0),
        ("carcass", 100_000, 2),
        ("differential", 20_000, 0),
        ("differential", 300_000, 0),
        ("turbine", 100_000, 3),
        ("externals", 20_000, 0),
        ("externals", 300_000, 1),
        ("tay", 100_000, 0),
    ],
)
def test_the_samples_know_their_bolts(name: str, triangles: int, seed: int) -> None:
    mockup, truth = sample_and_truth(name, triangles, seed)
    recall, precision = scores(feeler.find_fasteners(mockup), truth, mockup.part_paths)
    assert recall >= 0.95 and precision >= 0.95
    if triangles < 100_000:
        return  # blocks and prisms, which the names tell apart
    recall, precision = scores(feeler.find_fasteners(without_names(mockup)), truth, mockup.part_paths)
    assert recall >= 0.95 and precision >= 0.95


def test_the_gearbox_knows_its_bolts(gearbox: Any) -> None:
    """Kind, size, place and axis of all with a hexagon head, of nuts, plugs and sensors.

    A thread of helices leans the axis by some thousandths; a name may say screw where the truth says bolt.
    """
    found = {row.path: row for row in feeler.find_fasteners(gearbox.mockup)}
    asked = gearbox.truth.fasteners
    assert len(asked) > 80 and [each.path for each in asked if each.path not in found] == []
    for each in asked:
        row = found[each.path]
        assert row.kind in (each.kind, kind_said(row.path)), each.path
        assert row.drive == ("hexagon socket" if each.tool == "hex key" else "hexagon"), each.path
        assert row.across_flats == pytest.approx(each.size_m, abs=1e-5), each.path
        lean = 5e-3 if each.path == "gearbox/housing/drain_plug" else 1e-3
        assert np.linalg.norm(row.frame[:3, 3] - each.top_m) < 1e-4, each.path
        assert np.linalg.norm(row.axis - each.axis) < lean, each.path


def test_what_is_found_is_a_sequence(gearbox: Any) -> None:
    mockup = gearbox.mockup
    told: list[float] = []
    found = feeler.find_fasteners(mockup, progress=lambda fraction, _: told.append(fraction))
    assert told == sorted(told) and told[-1] == 1.0
    assert found.parts.tolist() == sorted(found.parts) and found.frames.shape == (len(found), 4, 4)
    assert np.allclose(np.linalg.norm(found.axes, axis=1), 1.0)
    assert re.match(r"Fasteners\(\d+ bolts, \d+ screws, \d+ nuts, \d+ studs\)", repr(found))
    assert repr(found[:0]) == "Fasteners(none)"
    assert found[:3] == feeler.Fasteners([found[0], found[1], found[2]]) != found[1:4]
    bolts = found.where("*bolt*")
    assert 0 < len(bolts) < len(found) and all("bolt" in row.path for row in bolts)
    assert {row.kind for row in found.where(kind="screw")} == {"screw"}
    (width,) = {round(row.across_flats, 6) for row in found.where(across_flats=0.008)}
    assert width == 0.008
    assert len(found.where(across_flats=(0.0, 1.0))) == sum(row.across_flats > 0 for row in found)
    only = feeler.find_fasteners(mockup, "gearbox/covers")
    inside = [row for row in found if row.path.startswith("gearbox/covers/")]
    assert [(row.part, row.kind) for row in only] == [(row.part, row.kind) for row in inside]
    assert np.allclose(only.frames[:, :3, 2:], [row.frame[:3, 2:] for row in inside], atol=1e-5)
    assert feeler.find_fasteners(mockup) == found


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda: feeler.find_fasteners(None), MeshError, "not of NoneType"),
        (
            lambda: feeler.find_fasteners(mockup_of({"a": cube((0, 0, 0), 1)}), "b"),
            OptionError,
            "no part has the path or name",
        ),
        (lambda: feeler.find_fasteners(mockup_of({"a": cube((0, 0, 0), 1)}), progress=1), OptionError, "progress is 1"),
        (lambda: feeler.Fasteners([]).where(kind="rivet"), OptionError, "kind is 'rivet'"),
    ],
)
def test_bad_input(ask: Callable[[], object], error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        ask()


@pytest.mark.parametrize("seed", range(6))
def test_a_wing_nut_with_thick_wings_in_any_pose(seed: int) -> None:
    """Each tip has two corners as far out as the other's: neither says where the wings are."""
    hub = hardware.ring(0.004, 0.006, 0.008, Tolerance(2e-5))
    wings = [box((x, -0.0016, 0.003), (x + 0.0105, 0.0016, 0.016)) for x in (-0.016, 0.0055)]
    corners, faces = joined((hub.vertices, hub.faces), *wings)
    turn = tilted(seed)
    mockup = mockup_of(
        {"part": (corners @ turn[:3, :3].T + turn[:3, 3], np.asarray(faces)), "lump": cube((1, 1, 1), 0.1)}
    )
    (row,) = feeler.find_fasteners(mockup)
    assert row.kind == "nut" and row.drive == "wings" and float(row.axis @ turn[:3, 2]) > 0.999
