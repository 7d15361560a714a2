"""What holds what: joints of known bolts, nuts and plates, and the gearbox, which knows its own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pytest
from shapes import Mesh, at, box, joined, mockup_of

import feeler
from feeler.errors import OptionError
from feeler.plan.fastener_names import retainer_said
from feeler.samples import hardware
from feeler.samples import mesh as samples
from feeler.samples.tessellation import Tolerance
from feeler.tasks.fixings import Fixings
from feeler.tasks.times import Arithmetic

Floats = npt.NDArray[np.float64]

FINE, USUAL = Tolerance(2e-5), Tolerance(1e-4)
SIZE = 0.008
CLEAR, TAPPED, FITTED = 0.0045, 0.0034, 0.004
"""Radii of holes: for clearance, for a thread as its core, as wide as the shank."""


def ring(inner: float, low: float, high: float, outer: float = 0.02, tolerance: Tolerance = USUAL) -> Mesh:
    mesh = hardware.ring(inner, outer, high - low, tolerance)
    return mesh.vertices + np.array([0.0, 0.0, low]), mesh.faces.astype(np.int64)


def plain(mesh: samples.Mesh, pose: Floats | None = None) -> Mesh:
    place = np.eye(4) if pose is None else pose
    return mesh.vertices @ place[:3, :3].T + place[:3, 3], mesh.faces.astype(np.int64)


def bolt(length: float, tolerance: Tolerance = USUAL) -> Mesh:
    return plain(hardware.hex_bolt(SIZE, length, tolerance))


def nut(top: float, tolerance: Tolerance = USUAL) -> Mesh:
    """With its bearing face at z = `top`, below it."""
    return plain(hardware.nut(SIZE, tolerance), at(z=top) @ np.diag([1.0, -1.0, -1.0, 1.0]))


def tilted(parts: Mapping[str, Mesh], seed: int) -> feeler.Mockup:
    """Somewhere, in no special direction."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = rng.uniform(-2.0, 2.0, 3)
    return mockup_of({name: (vertices @ turn.T + shift, faces) for name, (vertices, faces) in parts.items()})


def only(found: feeler.Holds, name: str) -> feeler.Hold:
    (row,) = [row for row in found if row.path == name]
    return row


@pytest.mark.parametrize("tolerance", [FINE, USUAL])
@pytest.mark.parametrize("thread", [TAPPED, FITTED])
def test_a_bolt_holds_all_above_its_thread(thread: float, tolerance: Tolerance) -> None:
    parts = {
        "bolt": bolt(0.03, tolerance),
        "cover": ring(CLEAR, -0.01, 0.0, tolerance=tolerance),
        "shim": ring(CLEAR, -0.01005, -0.01, tolerance=tolerance),
        "case": ring(thread, -0.04, -0.01005, tolerance=tolerance),
        "beside": box((0.03, -0.01, -0.02), (0.05, 0.01, 0.0)),
    }
    for seed in range(3):
        row = only(feeler.holds(tilted(parts, seed)), "bolt")
        assert row.paths == ("cover", "shim") and row.anchor_path == "case", row.because
        assert row.kind == "bolt" and not row.washers and "'case'" in row.because


def test_what_is_below_the_thread_is_not_held() -> None:
    parts = {
        "bolt": bolt(0.03),
        "cover": ring(CLEAR, -0.01, 0.0),
        "case": ring(TAPPED, -0.02, -0.01),
        "tray": ring(CLEAR, -0.028, -0.022),
    }
    row = only(feeler.holds(tilted(parts, 1)), "bolt")
    assert row.paths == ("cover",) and row.anchor_path == "case"


def test_a_bolt_and_its_nut_hold_the_same() -> None:
    parts = {
        "bolt": bolt(0.03),
        "washer": plain(hardware.washer(SIZE, USUAL), at(z=-0.15 * SIZE)),
        "upper": ring(CLEAR, -0.01, -0.15 * SIZE),
        "lower": ring(CLEAR, -0.02, -0.01),
        "nut": nut(-0.02),
    }
    found = feeler.holds(tilted(parts, 2))
    head, foot = only(found, "bolt"), only(found, "nut")
    assert head.paths == foot.paths == ("upper", "lower")
    assert head.anchor_path == "nut" and head.mates == (4,) and foot.mates == (0,)
    assert head.washers == foot.washers == (1,)
    assert [row.path for row in found.holding(2)] == ["bolt", "nut"]
    assert [row.path for row in found.holding(1)] == ["bolt", "nut"]


def test_a_bolt_drawn_without_its_hole() -> None:
    parts = {
        "bolt": bolt(0.03),
        "cover": ring(CLEAR, -0.01, 0.0),
        "case": box((-0.03, -0.03, -0.05), (0.03, 0.03, -0.01)),
    }
    row = only(feeler.holds(tilted(parts, 3)), "bolt")
    assert row.paths == ("cover",) and row.anchor_path == "case" and "without a hole" in row.because


def test_a_plug_holds_itself() -> None:
    parts = {"drain_plug": bolt(0.02), "case": ring(TAPPED, -0.04, 0.0)}
    row = only(feeler.holds(tilted(parts, 4)), "drain_plug")
    assert row.paths == ("drain_plug",) and row.anchor_path == "case"


def test_a_bolt_in_clearance_holes_alone() -> None:
    parts = {"bolt": bolt(0.02), "cover": ring(CLEAR, -0.01, 0.0), "case": ring(CLEAR, -0.015, -0.01)}
    row = only(feeler.holds(tilted(parts, 5)), "bolt")
    assert row.paths == ("cover", "case") and row.anchor is None and "neither" in row.because
    deep = {**parts, "case": ring(CLEAR, -0.04, -0.01)}
    row = only(feeler.holds(tilted(deep, 5)), "bolt")
    assert row.paths == ("cover",) and row.anchor_path == "case" and "tip ends" in row.because


def test_a_head_without_a_shank_holds_what_it_lies_on() -> None:
    parts = {
        "bolt": plain(hardware.hex_bolt(SIZE, 0.001, USUAL)),
        "cover": box((-0.02, -0.02, -0.02), (0.02, 0.02, 0.0)),
    }
    row = only(feeler.holds(tilted(parts, 6)), "bolt")
    assert row.paths == ("cover",) or row.anchor_path == "cover"


def test_a_stud_stays_and_its_nut_holds() -> None:
    shank = hardware.ring(1e-5, SIZE / 2, 0.05, USUAL)
    parts = {
        "stud_1": plain(shank, at(z=-0.03)),
        "cover": ring(CLEAR, -0.0, 0.008),
        "case": ring(FITTED, -0.04, 0.0),
        "nut": plain(hardware.nut(SIZE, USUAL), at(z=0.008)),
    }
    found = feeler.holds(tilted(parts, 7))
    stud, top = only(found, "stud_1"), only(found, "nut")
    assert stud.paths == () and stud.anchor_path == "case" and stud.mates == (3,)
    assert top.paths == ("cover",) and top.anchor_path == "stud_1"


@pytest.mark.parametrize("name", ["stud_1", "rod"])
def test_a_stud_in_holes_as_wide_as_itself_is_fastened_away_from_its_nuts(name: str) -> None:
    parts = {
        name: plain(hardware.ring(1e-5, SIZE / 2, 0.03, USUAL), at(z=-0.012)),
        "cover": ring(FITTED, 0.0, 0.008),
        "case": ring(FITTED, -0.014, 0.0),
        "nut": plain(hardware.nut(SIZE, USUAL), at(z=0.008)),
    }
    for seed in range(6):
        found = feeler.holds(tilted(parts, seed))
        stud, top = only(found, name), only(found, "nut")
        assert (stud.anchor_path, top.paths) == ("case", ("cover",)), (seed, stud.because)
    # Without a nut it is fastened at the end that stands out less.
    del parts["nut"]
    rows = [only(feeler.holds(tilted(parts, seed)), name) for seed in range(6 if name == "stud_1" else 0)]
    assert all(row.anchor_path == "case" for row in rows)


@pytest.mark.parametrize("hole", [CLEAR, FITTED])
@pytest.mark.parametrize("thick", [0.008, 0.2])
def test_nuts_at_both_ends_of_a_stud_hold_all_between_them(thick: float, hole: float) -> None:
    high = hardware.nut(SIZE, USUAL).vertices[:, 2].max()
    parts = {
        "stud_1": plain(hardware.ring(1e-5, SIZE / 2, thick + 0.009 + 2.0 * high, USUAL), at(z=-0.009 - high)),
        "cover": ring(hole, 0.0, thick),
        "case": ring(hole, -0.009, 0.0),
        "nut": plain(hardware.nut(SIZE, USUAL), at(z=thick)),
        "other nut": nut(-0.009),
    }
    for seed in range(4):
        found = feeler.holds(tilted(parts, seed))
        assert only(found, "stud_1").anchor is None, only(found, "stud_1").because
        assert all(set(only(found, each).paths) == {"cover", "case"} for each in ("nut", "other nut"))


@pytest.mark.parametrize("name", ["Klemmring", "morsetto", "shaft collar", "brida de sujeci\u00f3n"])
def test_a_screw_across_the_slit_of_a_clamp_holds_what_it_clamps(name: str) -> None:
    ear = ring(TAPPED, -0.02, -0.011, 0.008), ring(CLEAR, -0.009, 0.0, 0.008)
    grip = box((-0.06, -0.008, -0.02), (-0.03, 0.008, -0.011)), box((-0.06, -0.008, -0.009), (-0.03, 0.008, 0.0))
    hinge = box((-0.07, -0.008, -0.02), (-0.06, 0.008, 0.0))
    arms = box((-0.03, -0.008, -0.02), (-0.007, 0.008, -0.011)), box((-0.03, -0.008, -0.009), (-0.007, 0.008, 0.0))
    parts = {
        "bolt": bolt(0.018),
        name: joined(*ear, *arms, *grip, hinge),
        "shaft": box((-0.0599, -0.05, -0.0109), (-0.04, 0.05, -0.0091)),
    }
    row = only(feeler.holds(tilted(parts, 3)), "bolt")
    assert row.paths == (name, "shaft") and row.anchor_path == name, row


def test_a_clamp_passes_it_on() -> None:
    parts = {
        "bolt": bolt(0.03),
        "pipe_clamp": joined(ring(CLEAR, -0.005, 0.0), box((0.0199, -0.005, -0.005), (0.03, 0.005, 0.0))),
        "case": ring(TAPPED, -0.04, -0.005),
        "pipe": box((0.0301, -0.1, -0.005), (0.04, 0.1, 0.005)),
        "far": box((0.1, -0.1, -0.005), (0.2, 0.1, 0.005)),
    }
    assert only(feeler.holds(tilted(parts, 8)), "bolt").paths == ("pipe_clamp", "pipe")


@pytest.mark.parametrize("step", ["", "/Cylinder.001"])
def test_pins_and_circlips(step: str) -> None:
    """Also if a default name of a program is below theirs."""
    shaft = hardware.revolve(
        np.array(
            [
                [1e-5, -0.05],
                [0.006, -0.05],
                [0.006, 0.0],
                [0.0055, 0.0],
                [0.0055, 0.001],
                [0.006, 0.001],
                [0.006, 0.01],
                [1e-5, 0.01],
            ]
        ),
        FINE,
    )
    parts = {
        "shaft": plain(shaft),
        "gear": ring(0.00601, -0.02, 0.0),
        f"circlip{step}": ring(0.0056, 0.0, 0.00099, 0.009, FINE),
        "arm": ring(0.0031, -0.005, 0.005, 0.01),
        "post": ring(0.0031, -0.025, -0.005, 0.01),
        f"dowel_pin{step}": plain(hardware.ring(1e-5, 0.003, 0.02, USUAL), at(z=-0.015)),
    }
    for name in ("arm", "post", f"dowel_pin{step}"):
        parts[name] = (parts[name][0] + np.array([0.1, 0.0, 0.0]), parts[name][1])
    found = feeler.holds(tilted(parts, 9))
    ring_row, pin = only(found, f"circlip{step}"), only(found, f"dowel_pin{step}")
    assert ring_row.paths == ("gear",) and ring_row.anchor_path == "shaft" and ring_row.kind == "circlip"
    assert sorted(pin.paths) == ["arm", "post"] and pin.kind == "dowel"


def test_a_table_knows_better() -> None:
    parts = {
        "bolt": bolt(0.03),
        "cover": ring(CLEAR, -0.01, 0.0),
        "case": ring(TAPPED, -0.04, -0.01),
        "wire": box((1, 1, 1), (2, 2, 2)),
    }
    mockup = mockup_of(parts)
    found = feeler.holds(mockup, table={"bolt": None, "wire": ["cover", "case"]})
    assert only(found, "bolt").paths == () and only(found, "bolt").because == "the table says so"
    assert only(found, "wire").paths == ("cover", "case") and only(found, "wire").kind == "given"
    with pytest.raises(OptionError, match="no part"):
        feeler.holds(mockup, table={"nothing": None})
    with pytest.raises(OptionError, match="two things"):
        feeler.holds(mockup, table={"bolt": "cover", "bo*": "case"})
    with pytest.raises(OptionError, match="table"):
        feeler.holds(mockup, table=[("bolt", "cover")])  # type: ignore[arg-type]


def test_parts_that_are_out_hold_and_are_held_no_more() -> None:
    parts = {"bolt": bolt(0.03), "cover": ring(CLEAR, -0.01, 0.0), "case": ring(TAPPED, -0.04, -0.01)}
    scene = feeler.Scene(mockup_of(parts))
    assert only(feeler.holds(scene.without(["cover"])), "bolt").paths == ("bolt",)
    assert len(feeler.holds(scene.without(["bolt"]))) == 0


def test_of_what_is_no_mockup() -> None:
    with pytest.raises(OptionError, match="mockup"):
        feeler.holds("engine.step")  # type: ignore[arg-type]
    other = mockup_of({"bolt": bolt(0.03)})
    small = mockup_of({"cube": box((0, 0, 0), (1, 1, 1))})
    moved = feeler.find_fasteners(mockup_of({"cube": box((5, 5, 5), (6, 6, 6)), "bolt": bolt(0.03)}))
    assert len(feeler.holds(other)) == 1
    with pytest.raises(OptionError, match="not in this mock-up"):
        feeler.holds(small, moved)


@pytest.mark.parametrize("seed", [1, 6])
def test_the_gearbox_knows_what_its_fasteners_hold(seed: int) -> None:
    triangles = {1: 100_000, 6: 150_000}[seed]
    mockup, truth = feeler.sample("gearbox", triangles, seed), feeler.sample_truth("gearbox", triangles, seed)
    found = feeler.holds(mockup)
    fixings = Fixings(feeler.Scene(mockup), feeler.Fasteners([]), found, Arithmetic(feeler.Times()))
    fittings = {row.fastener for row in found if row.kind == "fitting"}
    unions = [row for row in found if row.kind == "nut" and row.anchor in fittings]
    assert unions and all(row.anchor in fixings.joins(row.fastener) for row in unions)
    for fastener in truth.fasteners:
        row = only(found, fastener.path)
        washers = tuple(mockup.part_paths[part] for part in row.washers)
        held = [path for path in row.paths if not (washers and path == fastener.path)]  # a plug, for its washer
        assert set(held or washers) == set(fastener.holds), (fastener.path, row.because)
    kept = {keeper.path: keeper for keeper in truth.keepers if keeper.kind in ("circlip", "dowel", "hinge")}
    rings = [row for row in found if row.kind in ("circlip", "dowel") and "input_drive" not in row.path]
    assert len(rings) == 10
    for row in rings:
        assert set(row.paths) == set(kept[row.path].holds), row.path


@pytest.mark.parametrize("gap", [0.0, 0.0005, 0.005])
def test_a_lock_nut_holds_what_its_nut_holds(gap: float) -> None:
    thick = float(np.ptp(nut(0.0)[0][:, 2]))
    parts = {
        "bolt": bolt(0.045),
        "high": ring(CLEAR, -0.01, 0.0),
        "low": ring(CLEAR, -0.02, -0.01),
        "nut": nut(-0.02),
        "lock": nut(-0.02 - thick - gap),
    }
    for seed in range(2):
        found = {row.path: row for row in feeler.holds(tilted(parts, seed))}
        assert all(set(row.paths) == {"high", "low"} for row in found.values()) and len(found) == 3
        assert [found["bolt"].mates, found["nut"].mates, found["lock"].mates] == [(3,), (0,), (0,)]


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *(
            (name, "pin")
            for name in (
                "Zylinderstift",
                "Passstift 4x20",
                "DIN 7",
                "ISO-8734 4x20",
                "goupille",
                "spina_2",
                "Steckbolzen 8",
                "DIN EN 22341 8x30",
                "axe d'articulation",
                "Bolzen 8x30",
                "Bolzen mit Kopf",
                "Perno",
                "Spinotto 3",
                "coppiglia elastica",
                "Zylinderstift mit Innengewinde",
                "clavija",
            )
        ),
        *(
            (name, "circlip")
            for name in (
                "Sicherungsring",
                "DIN_471 20x1.2",
                "anneau d'arr\u00eat",
                "e-clip 5",
                "SnapRing_3",
                "Wellensicherungsring",
                "segment d'arr\u00eat",
                "anillo de retenci\u00f3n",
                "Sicherungsring vorn",
                "SicherungsringAu\u00dfen",
                "snap ring_rear",
                "retaining ring, external",
                "E-ring big",
                "circlip for shaft",
                "anello di sicurezza",
                "Anello di arresto 20",
                "anneau de retenue",
                "anillo seeger",
                "Innensicherungsring",
                "retaining ring with lugs",
                "C-clip",
            )
        ),
        *(
            (name, "clasp")
            for name in (
                "P-Clip",
                "Rohrschelle 12",
                "collier de serrage",
                "abrazadera",
                "hose clamp 3",
                "Schlauchklemme",
                "DIN 3017",
                "bride de serrage",
                "clamp_upper",
                "clamp lower half 2",
                "Rohrschelle oben",
                "P-clip (black)",
                "Doppelschelle",
                "Klemme",
                "Klemmring 2",
                "Klemmst\u00fcck",
                "Stellring geteilt",
                "DIN 705 A20",
                "shaft collar",
                "hoseclamp_3",
                "morsetto",
                "brida de sujeci\u00f3n",
                "collare di serraggio",
                "bague d'arr\u00eat",
            )
        ),
        *((name, None) for name in ("pinion", "spindle", "pin block", "ISO 4762 M8", "ISO 7", "DIN 933 M8", "ring")),
        *((name, None) for name in ("Gewindestift", "anello di tenuta", "Stehbolzen", "plate with pin")),
        *(
            (name, None)
            for name in ("Reihenklemme", "Klemmhebel", "Klemmring Deckel", "morsettiera", "collar", "O-Ring")
        ),
        *((name, None) for name in ("brida", "brida ciega", "bride", "collarín de embrague", "shaft", "bague")),
        *((name, None) for name in ("circlip cover", "circlip holder", "clamp plate", "upper half", "pin plate rear")),
    ],
)
def test_retainers_are_known_by_names_in_several_languages(name: str, kind: str | None) -> None:
    assert retainer_said(name) == kind


def along(mesh: Mesh, z: float) -> Mesh:
    """Moved along z."""
    return mesh[0] + np.array([0.0, 0.0, z]), mesh[1]


@pytest.mark.parametrize("gap", [0.0, 0.0005])
def test_lock_nuts_point_away_from_what_they_clamp(gap: float) -> None:
    thick = float(np.ptp(nut(0.0)[0][:, 2]))
    parts = {
        "stud_1": plain(hardware.ring(1e-5, SIZE / 2, 0.05, USUAL), at(z=-0.03)),
        "cover": ring(CLEAR, 0.0, 0.008),
        "case": ring(FITTED, -0.04, 0.0),
        "nut": plain(hardware.nut(SIZE, USUAL), at(z=0.008)),
        "lock_nut": plain(hardware.nut(SIZE, USUAL), at(z=0.008 + thick + gap)),
    }
    mockup = tilted(parts, 3)
    found = feeler.find_fasteners(mockup)
    nuts = [row for row in found if row.kind == "nut"]
    way = nuts[0].frame[:3, 3] - mockup.part_bounds.reshape(-1, 2, 3)[2].mean(axis=0)
    assert len(nuts) == 2 and all(row.axis @ way > 0.0 for row in nuts)
    assert all(only(feeler.holds(mockup, found), row.path).paths == ("cover",) for row in nuts)


@pytest.mark.parametrize("washed", [False, True])
def test_a_head_holds_what_it_bears_on_beside_its_shank(washed: bool) -> None:
    low = -0.15 * SIZE if washed else 0.0
    parts = {
        "bolt": bolt(0.03),
        "clip_plate": box((0.0045, -0.02, -0.008 + low), (0.03, 0.02, low)),
        "case": ring(FITTED, -0.04, -0.008 + low, 0.03),
        "near": box((-0.03, -0.02, -0.008 + low), (-0.0095, 0.02, low)),
    }
    if washed:
        parts["washer"] = plain(hardware.washer(SIZE, USUAL), at(z=low))
        parts["near"] = along(parts["near"], -0.001)
    for seed in range(2):
        row = only(feeler.holds(tilted(parts, seed)), "bolt")
        assert row.paths == ("clip_plate",) and row.anchor_path == "case", row.because
        assert len(row.washers) == washed


def grooved(name: str, ring_at: float, width: float) -> dict[str, Mesh]:
    """A shaft with a groove of a width, a gear on it, and a circlip of 1 mm."""
    outline = [[1e-5, -0.05], [0.006, -0.05], [0.006, 0.0], [0.0055, 0.0], [0.0055, width], [0.006, width]]
    shaft = hardware.revolve(np.array([*outline, [0.006, 0.01], [1e-5, 0.01]]), FINE)
    return {
        name: plain(shaft),
        "gear": ring(0.00601, -0.02, 0.0),
        "circlip": ring(0.0056, ring_at, ring_at + 0.001, 0.009, FINE),
    }


@pytest.mark.parametrize("name", ["shaft", "pin", "axle_pin"])
@pytest.mark.parametrize(("ring_at", "width"), [(0.0, 0.001), (0.0005, 0.002)])
def test_grooves_are_in_pins_too_and_wider_than_their_circlip(name: str, ring_at: float, width: float) -> None:
    row = only(feeler.holds(tilted(grooved(name, ring_at, width), 4)), "circlip")
    assert row.paths == ("gear",) and row.anchor_path == name, row.because


def test_an_open_circlip_has_its_middle_off_that_of_its_box() -> None:
    parts = grooved("shaft", 0.0, 0.001)
    vertices, faces = parts["circlip"]
    middle = vertices[faces].mean(axis=1)
    parts["circlip"] = vertices, faces[np.abs(np.arctan2(middle[:, 1], middle[:, 0])) > 0.8]
    row = only(feeler.holds(tilted(parts, 5)), "circlip")
    assert row.paths == ("gear",) and row.anchor_path == "shaft"


def test_a_fork_is_held_by_its_far_leg() -> None:
    fork = joined(ring(CLEAR, -0.01, 0.0), ring(TAPPED, -0.04, -0.02), box((0.019, -0.005, -0.04), (0.03, 0.005, 0.0)))
    parts = {"bolt": bolt(0.035), "fork": fork, "rod": ring(CLEAR, -0.019, -0.011, 0.012)}
    row = only(feeler.holds(tilted(parts, 6)), "bolt")
    assert row.paths == ("rod",) and row.anchor_path == "fork"


def test_a_thread_in_an_insert_is_in_what_the_insert_is_in() -> None:
    parts = {
        "bolt": bolt(0.03),
        "cover": ring(CLEAR, -0.01, 0.0),
        "insert": ring(FITTED, -0.025, -0.01, 0.006),
        "case": joined(ring(0.006, -0.025, -0.01), ring(CLEAR, -0.05, -0.025)),
    }
    row = only(feeler.holds(tilted(parts, 7)), "bolt")
    assert row.paths == ("cover",) and row.anchor_path == "case", row.because


def test_a_shank_drawn_as_the_core_of_its_thread() -> None:
    screw = hardware.cap_screw(SIZE, 0.03, FINE)
    vertices = screw.vertices.copy()
    vertices[vertices[:, 2] < 1e-6, :2] *= 0.82
    parts = {
        "screw": (vertices, screw.faces.astype(np.int64)),
        "cover": ring(1.1 * SIZE / 2, -0.01, 0.0),
        "case": ring(FITTED, -0.04, -0.01),
    }
    for seed in range(2):
        row = only(feeler.holds(tilted(parts, seed)), "screw")
        assert row.paths == ("cover",) and row.anchor_path == "case", row.because


def test_a_bolt_whose_axis_is_in_flush_faces_of_parts_without_holes() -> None:
    parts = {
        "bolt": bolt(0.03),
        "clamp_foot": box((-0.02, -0.02, -0.01), (0.02, 0.02, 0.0)),
        "bracket": box((-0.02, -0.02, -0.02), (0.02, 0.02, -0.01)),
    }
    for seed in range(4):
        row = only(feeler.holds(tilted(parts, seed)), "bolt")
        assert row.paths == ("clamp_foot",) and row.anchor_path == "bracket", row.because


@pytest.mark.parametrize("clip", [False, True])
def test_fittings_and_clips_hold_hoses(clip: bool) -> None:
    tube = [[0.002, -0.012], [0.004, -0.012], [0.004, 0.0], [0.007, 0.0], [0.007, 0.005], [0.0036, 0.005]]
    parts = {
        "hose_connector": plain(hardware.revolve(np.array([*tube, [0.0036, 0.025], [0.002, 0.025]]), FINE)),
        "hose": ring(0.0036, 0.008, 0.06, 0.0055),
        "case": ring(FITTED, -0.04, 0.0),
    }
    if clip:
        parts["hose_clamp"] = ring(0.0055, 0.012, 0.017, 0.007)
    found = feeler.holds(tilted(parts, 8))
    row = only(found, "hose_connector")
    assert row.kind == "fitting" and row.anchor_path == "case"
    assert row.paths == (("hose_connector",) if clip else ("hose", "hose_connector"))
    assert not clip or (only(found, "hose_clamp").paths == ("hose",) and only(found, "hose_clamp").kind == "clip")


def test_a_banjo_passes_it_on_to_its_pipe() -> None:
    parts = {
        "bolt": bolt(0.03),
        "banjo": ring(CLEAR, -0.01, 0.0, 0.01),
        "pipe": box((0.0098, -0.003, -0.008), (0.1, 0.003, -0.002)),
        "case": ring(FITTED, -0.04, -0.01),
    }
    assert set(only(feeler.holds(tilted(parts, 9)), "bolt").paths) == {"banjo", "pipe"}


def test_a_plate_with_a_welded_nut_is_no_nut() -> None:
    thick = float(np.ptp(nut(0.0)[0][:, 2]))
    plate = joined(ring(CLEAR, -0.012, -0.008, 0.03), plain(hardware.nut(SIZE, USUAL), at(z=-0.012 - thick)))
    row = only(feeler.holds(tilted({"bolt": bolt(0.024), "cover": ring(CLEAR, -0.008, 0.0), "rail": plate}, 1)), "bolt")
    assert row.paths == ("cover",) and row.anchor_path == "rail", row.because


def union_nut(flats: float, thread: float, bore: float, low: float, step: float, high: float) -> Mesh:
    """A hexagon about z whose bore is as wide as a thread below a step and as wide as a pipe above it."""
    turn = np.arange(48) * (2.0 * np.pi / 48)
    hexagon = 0.5 * flats / np.cos((turn % (np.pi / 3.0)) - np.pi / 6.0)
    full = np.ones(48)
    outline = [(hexagon, low), (hexagon, high), (bore * full, high), (bore * full, step)]
    outline += [(thread * full, step), (thread * full, low)]
    corners = [np.column_stack([r * np.cos(turn), r * np.sin(turn), np.full(48, z)]) for r, z in outline]
    a = np.arange(48)
    b, faces = (a + 1) % 48, []
    for level in range(len(outline)):
        here, there = 48 * level, 48 * ((level + 1) % len(outline))
        faces += [np.column_stack([here + a, here + b, there + b]), np.column_stack([here + a, there + b, there + a])]
    return np.concatenate(corners), np.concatenate(faces)


def test_a_union_nut_is_on_its_wide_bore_in_any_pose() -> None:
    parts = {
        "adapter": joined(ring(0.004, 0.0, 0.008, 0.012), ring(0.004, 0.008, 0.022, 0.009)),
        "pipe": joined(ring(0.004, 0.0221, 0.024, 0.0075), ring(0.004, 0.024, 0.12, 0.005)),
        "union nut": union_nut(0.024, 0.00902, 0.0053, 0.01, 0.024, 0.032),
        "case": box((-0.04, -0.04, -0.04), (0.04, 0.04, -0.0001)),
    }
    for seed in range(6):
        mockup = tilted(parts, seed)
        row = only(feeler.holds(mockup), "union nut")
        assert (row.paths, row.anchor_path) == (("pipe",), "adapter"), (seed, row.because)
        task = feeler.task(feeler.Scene(mockup), "pipe", keep="case")
        assert [step.paths for step in task.steps] == [("union nut",), ("pipe", "union nut")]


@pytest.mark.parametrize("high", [0.12, 0.3])
@pytest.mark.parametrize("is_bent", [True, False])
def test_a_union_nut_stays_on_a_pipe_with_a_bend_however_far_away(high: float, is_bent: bool) -> None:
    foot = joined(ring(0.004, 0.0221, 0.024, 0.0075), ring(0.004, 0.024, high, 0.005))
    # The far end is bent, or it is straight beside a stay that leaves room for the nut.
    bend = box((-0.005, -0.005, high), (0.08, 0.005, high + 0.01))
    parts = {
        "adapter": joined(ring(0.004, 0.0, 0.008, 0.012), ring(0.004, 0.008, 0.022, 0.009)),
        "pipe": joined(foot, bend if is_bent else box((0.02, -0.005, high), (0.08, 0.005, high + 0.01))),
        "union nut": union_nut(0.024, 0.00902, 0.0053, 0.01, 0.0241, 0.032),
        "case": box((-0.04, -0.04, -0.04), (0.04, 0.04, -0.0001)),
    }
    task = feeler.task(feeler.Scene(tilted(parts, 1)), "pipe", keep=["case", "adapter"])
    assert [step.paths for step in task.steps] == [("union nut",), ("pipe", "union nut") if is_bent else ("pipe",)]


def test_a_plug_is_undone_for_its_sealing_ring() -> None:
    parts = {
        "plug": plain(hardware.hex_bolt(SIZE, 0.015, USUAL), at(z=0.0015)),
        "seal": ring(0.0041, 0.0, 0.0015, 0.006),
        "case": ring(FITTED, -0.03, 0.0),
        "lump": box((0.1, 0.0, 0.0), (0.11, 0.01, 0.01)),
    }
    mockup = tilted(parts, 3)
    row = only(feeler.holds(mockup), "plug")
    assert (row.paths, row.washers, row.anchor_path) == (("plug",), (1,), "case") and "its washers" in row.because
    for wanted in ("seal", "plug"):
        (step,) = feeler.task(feeler.Scene(mockup), wanted).steps
        assert step.verb == "undo" and sorted(step.paths) == ["plug", "seal"]


@pytest.mark.parametrize("washed", [False, True])
@pytest.mark.parametrize("stub", [0.004, 0.006])
def test_a_nut_on_a_shaft_holds_the_wheel_that_it_bears_on(washed: bool, stub: float) -> None:
    shaft = joined(ring(0.001, -0.04, 0.0, 0.012), ring(0.001, 0.0, 0.038, stub), ring(0.001, 0.038, 0.062, 0.004))
    top = 0.0415 if washed else 0.04
    parts = {
        "shaft": shaft,
        "wheel": ring(stub + 0.00002, 0.00002, 0.04, 0.03),
        **({"washer": ring(0.0042, 0.04, top, 0.008)} if washed else {}),
        "nut": plain(hardware.nut(SIZE, USUAL), at(z=top)),
        "lump": box((0.1, 0.0, 0.0), (0.11, 0.01, 0.01)),
    }
    mockup = tilted(parts, 5)
    row = only(feeler.holds(mockup), "nut")
    assert (row.paths, row.washers, row.anchor_path) == (("wheel",), (2,) if washed else (), "shaft"), row.because


def test_names_of_bent_bolts_and_sliding_nuts_change_nothing() -> None:
    """A U-bolt has two threads, and no tool turns a T-slot nut: nuts and bolts are undone from them."""
    legs = [ring(0.001, -0.03, 0.03, 0.004) for _ in range(2)]
    u_bolt = joined(
        *((corners + np.array([x, 0.0, 0.0]), faces) for (corners, faces), x in zip(legs, (-0.03, 0.03), strict=True)),
        box((-0.034, -0.004, 0.03), (0.034, 0.004, 0.038)),
    )
    holes = [ring(CLEAR, -0.008, 0.0, 0.02) for _ in range(2)]
    plate = joined(*((v + np.array([x, 0.0, 0.0]), f) for (v, f), x in zip(holes, (-0.03, 0.03), strict=True)))
    nuts = {
        f"nut_{n}": plain(hardware.nut(SIZE, USUAL), at(x=x, z=-0.008) @ np.diag([1.0, -1.0, -1.0, 1.0]))
        for n, x in enumerate((-0.03, 0.03))
    }
    for name in ("U-bolt", "part 7"):
        found = feeler.holds(tilted({name: u_bolt, "plate": plate, **nuts}, 6))
        assert [(row.path, row.paths, row.anchor_path) for row in found] == [
            (nut, ("plate",), name) for nut in ("nut_0", "nut_1")
        ]
    block = joined(
        box((-0.012, -0.0102, -0.014), (-0.004, 0.0102, -0.002)),
        box((0.004, -0.0102, -0.014), (0.012, 0.0102, -0.002)),
        ring(FITTED, -0.014, -0.002, 0.0045),
        box((-0.004, 0.004, -0.014), (0.004, 0.0102, -0.002)),
        box((-0.004, -0.0102, -0.014), (0.004, -0.004, -0.002)),
    )
    for name in ("T-slot nut", "part 5"):
        parts = {"bolt": bolt(0.024, USUAL), "plate": ring(CLEAR, -0.0019, 0.0), name: block}
        mockup = tilted({**parts, "case": box((-0.03, -0.03, -0.05), (0.03, 0.03, -0.03))}, 6)
        (row,) = feeler.holds(mockup)
        assert (row.path, row.paths, row.anchor_path) == ("bolt", ("plate",), name), row.because
        task = feeler.task(feeler.Scene(mockup), "plate")
        assert [step.paths for step in task.steps] == [("bolt",), ("plate",)]


def slotted(low: float, high: float, half: float) -> Mesh:
    """A plate with a slot that is open towards both sides."""
    halves = [box((x - 0.015, -0.05, low), (x + 0.015, 0.05, high)) for x in (-half - 0.015, half + 0.015)]
    return joined(*halves)


@pytest.mark.parametrize("end", ["thread", "nut", "stud"])
@pytest.mark.parametrize("is_inside_out", [False, True])
def test_a_slotted_plate_below_a_foot_is_held(end: str, is_inside_out: bool) -> None:
    corners, faces = slotted(-0.015, -0.01, 0.0045)
    parts = {
        "base": ring(FITTED if end != "nut" else CLEAR, -0.03, -0.015, 0.05),
        "rail": (corners, faces[:, ::-1] if is_inside_out else faces),
        "foot": ring(CLEAR, -0.01, 0.0),
        "beside": box((0.021, -0.05, -0.01), (0.04, 0.05, 0.0)),
    }
    if end == "stud":
        parts["stud_1"] = plain(hardware.ring(1e-5, SIZE / 2, 0.04, USUAL), at(z=-0.028))
        parts["nut"] = plain(hardware.nut(SIZE, USUAL))
    else:
        parts["bolt"] = bolt(0.024 if end == "thread" else 0.045)
        parts |= {"nut": nut(-0.03)} if end == "nut" else {}
    found = feeler.holds(tilted(parts, 8))
    held = {"foot", "rail", "base"} if end == "nut" else {"foot", "rail"}
    for fastener in {"thread": ["bolt"], "nut": ["bolt", "nut"], "stud": ["nut"]}[end]:
        assert set(only(found, fastener).paths) == held, fastener


@pytest.mark.parametrize("gap", [0.0, 0.0002, 0.0005])
def test_a_bracket_and_its_t_slot_nut_hold_the_profile_between_them(gap: float) -> None:
    neck, lip, top = 0.0040, 0.006, -0.0015
    shoulder = -lip - gap
    block = joined(
        ring(FITTED, shoulder - 0.006, top, neck),
        box((-0.011, -0.01, shoulder - 0.006), (-neck, 0.01, shoulder)),
        box((neck, -0.01, shoulder - 0.006), (0.011, 0.01, shoulder)),
    )
    parts = {
        "bolt": bolt(0.016),
        "bracket": ring(CLEAR, -0.005, 0.0),
        "profile": slotted(-0.005 - lip, -0.005, neck + 0.0002),
        "T-slot nut": (block[0] + np.array([0.0, 0.0, -0.005]), block[1]),
    }
    mockup = tilted(parts, 7)
    (row,) = feeler.holds(mockup)
    assert (set(row.paths), row.anchor_path) == ({"bracket", "profile"}, "T-slot nut"), row.because
    task = feeler.task(feeler.Scene(mockup), "bracket", keep="profile")
    assert [step.paths for step in task.steps] == [("bolt",), ("bracket",)]


@pytest.mark.parametrize("name", ["shim", "washer", "part 7"])
def test_rings_between_parts_are_held_and_no_washers(name: str) -> None:
    """Only rings between a head, or a nut, and the first other part leave with the fastener."""
    threaded = {
        "bolt": plain(hardware.hex_bolt(SIZE, 0.03, USUAL), at(z=0.0116)),
        "head washer": ring(0.0042, 0.01, 0.0116, 0.008),
        "plate": ring(CLEAR, 0.001, 0.01),
        name: ring(0.0043, 0.0, 0.001, 0.01),
        "case": ring(FITTED, -0.03, 0.0),
        "lump": box((0.1, 0.0, 0.0), (0.11, 0.01, 0.01)),
    }
    mockup = tilted(threaded, 4)
    row = only(feeler.holds(mockup), "bolt")
    assert (row.paths, row.washers, row.anchor_path) == (("plate", name), (1,), "case")
    plan = feeler.task(feeler.Scene(mockup), "plate", keep="case")
    assert [sorted(step.paths) for step in plan.steps] == [["bolt", "head washer"], ["plate"]]
    through = {
        "bolt": bolt(0.03),
        "upper": ring(CLEAR, -0.01, 0.0),
        name: ring(0.0043, -0.011, -0.01, 0.01),
        "lower": ring(CLEAR, -0.02, -0.011),
        "foot washer": ring(0.0042, -0.0216, -0.02, 0.008),
        "nut": nut(-0.0216),
    }
    found = feeler.holds(tilted(through, 5))
    for fastener in ("bolt", "nut"):
        row = only(found, fastener)
        assert (set(row.paths), row.washers) == ({"upper", name, "lower"}, (4,)), row.because
