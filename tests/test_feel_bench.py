"""The bench of feel: its geometry is what it says, its baselines answer as known, its judges tell right from wrong."""

from __future__ import annotations

import importlib
import itertools
import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler

poses = importlib.import_module("feel.poses")
meshes = importlib.import_module("feel.meshes")
scenes = importlib.import_module("feel.scenes")
fits = importlib.import_module("feel.fits")
puzzles = importlib.import_module("feel.puzzles")
hands = importlib.import_module("feel.hands")
faces = importlib.import_module("feel.faces")
penalty = importlib.import_module("feel.penalty")
point_shell = importlib.import_module("feel.point_shell")
goals = importlib.import_module("feel.goals")
pages = importlib.import_module("pages")
tables = importlib.import_module("feel.tables")
passing = importlib.import_module("feel.experiments.passing")
energy = importlib.import_module("feel.experiments.energy")
tessellation = importlib.import_module("feel.experiments.tessellation")

MOST_TICKS = 2000


@dataclass(frozen=True)
class Said:
    """A step of the made-up faces below."""

    world_from_proxy: Any
    force: Any = None
    torque: Any = None


class Ghost:
    """A face that follows the device through everything, without force."""

    def __init__(self, *_scene_and_tool: object, **_options: object) -> None:
        pass

    def start(self, pose: Any) -> None:
        pass

    def step(self, world_from_device: Any, dt: float = 0.001) -> Said:
        return Said(world_from_device, np.zeros(3), np.zeros(3))


class Rock(Ghost):
    """A face whose proxy stays where it began."""

    def start(self, pose: Any) -> None:
        self.pose = pose

    def step(self, world_from_device: Any, dt: float = 0.001) -> Said:
        return Said(self.pose, np.zeros(3), np.zeros(3))


class Spring(Ghost):
    """A wall at z = 0 for the device's origin, its spring `way_out` times as stiff on the way out as on the way in."""

    way_out = 1.0

    def start(self, pose: Any) -> None:
        self.height = pose[2, 3]

    def step(self, world_from_device: Any, dt: float = 0.001) -> Said:
        height = world_from_device[2, 3]
        stiffness = 1000.0 * (self.way_out if height > self.height else 1.0)
        self.height = height
        return Said(world_from_device, np.array([0.0, 0.0, stiffness * max(0.0, -height)]), np.zeros(3))


class Giving(Spring):
    """A wall that gives back half as much again."""

    way_out = 1.5


@pytest.mark.parametrize(
    "turn", [(0.3, -0.2, 0.9), (0.0, 0.0, 0.0), (1e-9, 0.0, 0.0), (0.0, math.pi, 0.0), (3.0, 0.2, 0.1)]
)
def test_rotation_vectors_come_back(turn: tuple[float, float, float]) -> None:
    matrix = poses.rotation(turn)
    assert np.allclose(matrix @ matrix.T, np.eye(3)) and np.linalg.det(matrix) > 0.0
    assert np.allclose(poses.rotation(poses.rotation_vector(matrix)), matrix, atol=1e-12)
    assert np.allclose(poses.rotation_vector(matrix), turn, atol=1e-7)


def test_shapes_are_closed_and_have_their_volumes() -> None:
    ring = scenes.thread_ring(0.02, 0.003)
    # Pappus: what of a polygon of eight corners turns about the axis, as 24 pieces with mitred ends
    section = 8 * 0.5 * 0.003**2 * math.sin(math.tau / 8)
    assert meshes.boundary_edges(ring) == 0
    assert meshes.volume(ring) == pytest.approx(section * 24 * 0.02 * math.sin(math.tau / 24), rel=1e-3)
    wire = scenes.wire(0.25, 0.0005)
    assert meshes.volume(wire) == pytest.approx(0.5 * 1.5 * 0.0005**2 * math.sqrt(3.0) * 0.5, rel=1e-9)
    for name, tool in scenes.thin_tools().items():
        assert meshes.boundary_edges(tool) == 0 and meshes.volume(tool) > 0.0, name
    # a grid through which no tool falls: the thinnest way through a tool is wider than what is between two wires
    thinnest = min(np.ptp(tool[0] @ direction) for tool in scenes.thin_tools().values() for direction in np.eye(3))
    assert thinnest > scenes.WIRE_PITCH_M
    assert meshes.boundary_edges(scenes.thin_sheet()) == 4 and len(scenes.flat_face()[1]) == pytest.approx(
        10_000, rel=0.02
    )


@pytest.mark.parametrize("name", list(scenes.CONTACTS))
def test_contacts_just_touch_at_every_tessellation(name: str) -> None:
    for triangles in (12, 3000):
        contact = scenes.contact_with(name, triangles)
        scene, tool = feeler.Scene(meshes.mockup_of(contact.mockup), threads=1), meshes.tool_of(contact.tool)
        assert meshes.boundary_edges(contact.mockup) == meshes.boundary_edges(contact.tool) == 0
        for share, is_in in ((-1e-6, False), (1e-6, True)):
            at = contact.touching.copy()
            at[:3, 3] += share * contact.push
            assert scene.is_colliding(tool, at) is is_in, (name, triangles, share)
    assert contact.triangles > 1000


# ISO 286: the least and largest clearance of each fit at 20 mm, micrometres
CLEARANCES = {"H11/c11": (110, 370), "H7/g6": (7, 41), "H7/h6": (0, 34)}


@pytest.mark.parametrize(("fit", "shape"), list(itertools.product(CLEARANCES, fits.SHAPES)))
def test_fits_have_the_clearance_of_the_standard(fit: str, shape: str) -> None:
    for share, wanted in zip((0.0, 1.0), CLEARANCES[fit], strict=True):
        pair = fits.peg_in_hole(fit, shape, share=share)
        assert pair.clearance == pytest.approx(1e-6 * wanted, abs=1e-12)
        assert meshes.boundary_edges(pair.hole) == meshes.boundary_edges(pair.peg) == 0
        scene, tool = feeler.Scene(meshes.mockup_of(pair.hole), threads=1), meshes.tool_of(pair.peg)
        half = 0.5 * pair.clearance
        assert pair.sagitta <= max(fits.FACET_SHARE * half, fits.LEAST_SAGITTA_M) * 1.01
        # turned by half a facet corners face sides: the closest that they get
        for turn in (0.0, math.pi / pair.sides) if shape == "round" else (0.0,):
            found = scene.distance(tool, poses.pose((0.0, 0.0, -0.5 * pair.depth), (0.0, 0.0, turn))).value
            assert half - 1e-9 <= found <= half + 2.0 * pair.sagitta + 1e-9, (share, turn)
        if half > 0.0:
            at_bottom = poses.pose((0.0, 0.0, -pair.depth + 1e-6))
            assert scene.is_free(tool, at_bottom) and scene.is_colliding(tool, poses.pose((0, 0, -pair.depth - 1e-6)))


@pytest.mark.parametrize("make", [puzzles.alpha, puzzles.coils, puzzles.hexagon_key])
def test_puzzles_come_apart_along_their_way_alone(make: Any) -> None:
    puzzle = make()
    assert meshes.boundary_edges(puzzle.mockup) == meshes.boundary_edges(puzzle.tool) == 0
    scene, tool = feeler.Scene(meshes.mockup_of(puzzle.mockup)), meshes.tool_of(puzzle.tool)
    assert scene.check_path(tool, puzzle.way).is_free
    # as near as the construction says; chords of the rods' curves cut inside by a little
    assert scene.distance_batch(tool, puzzle.way).values.min() == pytest.approx(puzzle.clearance, rel=5e-3)
    far = 0.3
    ways_out = 0
    for corner in itertools.product((-1.0, 0.0, 1.0), repeat=3):
        if any(corner):
            end = puzzle.way[0].copy()
            end[:3, 3] += far * np.array(corner) / np.linalg.norm(corner)
            ways_out += scene.cast(tool, puzzle.way[0], end) is None
    assert ways_out == (1 if puzzle.name == "hexagon key" else 0)


def test_hexagon_key_has_the_sizes_of_the_standards() -> None:
    for share, wanted in ((0.0, 0.5 * (8.025 - 8.0)), (1.0, 0.5 * (8.175 - 7.942))):
        assert puzzles.hexagon_key(share=share).clearance == pytest.approx(1e-3 * wanted, rel=1e-9)
    key = puzzles.hexagon_key(share=0.0).tool[0]
    assert np.ptp(key[:, 2]) == pytest.approx(0.036, abs=1e-9)
    assert np.ptp(key[:, 0]) == pytest.approx(0.1, abs=1e-9)


def test_paths_keep_their_speeds_and_close() -> None:
    start = poses.pose((0.01, 0.02, 0.03), (0.1, 0.2, 0.3))
    path = hands.straight(start, (0.0, 0.0, -1.0), (0.0, 3.0, 0.0), 50, (0.0, 0.0, 0.01))
    middles = path[:, :3, :3] @ np.array([0.0, 0.0, 0.01]) + path[:, :3, 3]
    assert np.allclose(np.diff(middles, axis=0), [0.0, 0.0, -0.001])
    turns = [poses.rotation_vector(b[:3, :3] @ a[:3, :3].T) for a, b in itertools.pairwise(path)]
    assert np.allclose(turns, [0.0, 0.003, 0.0], atol=1e-9)
    around = hands.circle(start, (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), 0.01, 0.1)
    assert np.array_equal(around[0], start) and np.array_equal(around[-1], start)
    assert around[:, 2, 3].min() == pytest.approx(0.01, abs=1e-4)
    for name, (mockup, tool, motion) in energy.closed_motions().items():
        scene = feeler.Scene(meshes.mockup_of(mockup), threads=1)
        assert np.allclose(motion[0], motion[-1], atol=1e-12), name
        assert not scene.is_colliding(meshes.tool_of(tool), motion[0]), name
        assert any(scene.is_colliding(meshes.tool_of(tool), at) for at in motion), name


def test_a_hand_is_a_mass_on_a_spring() -> None:
    grip = hands.Grip(mass_kg=0.25, stiffness_n_per_m=400.0, damping_ns_per_m=0.0)
    hand = hands.Hand(poses.pose((0.001, 0.0, 0.0)), grip)
    xs = [hand.tick(np.eye(4), np.zeros(3), np.zeros(3))[0, 3] for _ in range(1000)]
    # a period of 157.08 ms
    assert xs[156] == pytest.approx(0.001, rel=1e-2) and xs[78] == pytest.approx(-0.001, rel=1e-2)
    pushed = hands.Hand(np.eye(4), replace(grip, damping_ns_per_m=20.0), delay_ticks=3)
    first = [pushed.tick(np.eye(4), np.array([0.0, 2.0, 0.0]), np.zeros(3))[1, 3] for _ in range(MOST_TICKS)]
    assert first[2] == 0.0 < first[3] and first[-1] == pytest.approx(2.0 / 400.0, rel=1e-6)


def test_unsure_hands_are_off_as_said_and_each_seed_otherwise() -> None:
    found = []
    for seed in range(3):
        wants = hands.unsure(np.eye(4), 0.03, seed, above=0.004)
        path = np.array(list(itertools.islice(wants, 1600)))
        tilt = np.linalg.norm(poses.rotation_vector(path[0][:3, :3]))
        assert tilt == pytest.approx(math.radians(1.0)) and path[-1][2, 3] < -0.0325
        middle = path[: round(1000 / hands.SEARCH_HZ), :2, 3].mean(axis=0)
        assert np.linalg.norm(middle) == pytest.approx(0.001, abs=1e-4)
        found.append(path[0])
    assert not np.allclose(found[0], found[1]) and not np.allclose(found[1], found[2])


@pytest.mark.parametrize("kind", list(passing.KINDS))
def test_what_follows_the_device_passes_and_what_stays_does_not(kind: str) -> None:
    """The judge of passing: a ghost passes everything (an edge it may pass rightly, but not free of collisions)."""
    index = list(passing.KINDS).index(kind)
    ghost, rock = passing.one(Ghost, index), passing.one(Rock, index)
    assert ghost["kind"] == kind and ghost["colliding_steps"] > 0
    assert ghost["passed"] or kind == "edge"
    assert not rock["passed"] and rock["colliding_steps"] == 0
    assert passing.one(Ghost, index) == ghost
    summary = passing.summary([ghost, rock])
    assert summary["rows"][0]["runs"] == 2 and summary["bad"] == [ghost]


def test_a_jump_over_an_edge_counts_as_passed() -> None:
    run = passing.throw(list(passing.KINDS).index("edge"))
    up, down, beside = poses.pose((-0.1, 0.0, 0.1)), poses.pose((-0.1, 0.0, -0.1)), poses.pose((0.1, 0.0, 0.0))
    assert run.has_passed(np.array([up, down]))
    assert not run.has_passed(np.array([up, beside, down])) and not run.has_passed(np.array([up, up]))
    # The device begins beyond the edge, and pulls around it what reaches over it.
    above, below = poses.pose((0.0, 0.0, 0.1)), poses.pose((0.0, 0.0, -0.1))
    assert not run.has_passed(np.array([above, below]))
    assert run.has_passed(np.array([above, poses.pose((-0.1, 0.0, -0.1))]))


def test_energy_of_a_spring_and_of_one_that_gives() -> None:
    """A spring gives what it takes (but for the tick it holds a force), one that is stiffer on the way out more."""
    spring, giving = energy.closed(Spring), energy.closed(Giving)
    press = next(row for row in spring["rows"] if row["motion"] == "press")
    # the device's origin goes 4 mm deep
    assert press["went_in_j"] == pytest.approx(0.5 * 1000.0 * 0.004**2, rel=0.02)
    assert abs(press["gain"]) < 0.02
    given = next(row for row in giving["rows"] if row["motion"] == "press")
    assert given["gain"] == pytest.approx(0.5, abs=0.05)
    assert [g.is_met for g in goals.scorecard({"closed": giving})] == [False]


def test_release_gives_what_went_in() -> None:
    found = energy.release(Spring, delays_ticks=(0,))["rows"]
    for row in found:
        assert row["is_out"] and row["kinetic_j"] == pytest.approx(row["stored_j"], rel=0.1)
        assert row["held_n"] == pytest.approx(1000.0 * row["sunk_m"], rel=1e-3)


def box_and_plate() -> tuple[feeler.Scene, feeler.Tool]:
    plate = meshes.box((0.2, 0.2, 0.02), (0.0, 0.0, -0.01), 1)
    tool = meshes.box((0.03, 0.02, 0.04), (0.0, 0.0, 0.02), 1)
    return feeler.Scene(meshes.mockup_of(plate), threads=1), meshes.tool_of(tool)


def test_penalty_is_the_sum_over_pairs() -> None:
    # one tool triangle hanging 1 mm through one triangle of a floor: one pair, one spring
    floor = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.5, 0.0)]), np.array([(0, 1, 2)])
    blade = np.array([(0.0, 0.0, -0.001), (0.01, 0.0, 0.01), (-0.01, 0.0, 0.01)]), np.array([(0, 1, 2)])
    scene, tool = feeler.Scene(meshes.mockup_of(floor), threads=1), meshes.tool_of(blade)
    face = penalty.Penalty(scene, tool, stiffness_n_per_m=500.0)
    force, torque, pairs = face.contact_wrench(np.eye(4))
    assert pairs == 1 and np.allclose(force, [0.0, 0.0, 0.5]) and np.allclose(torque, 0.0, atol=1e-12)
    assert face.contact_wrench(poses.pose((0.0, 0.0, 0.002)))[2] == 0
    # the same floor in two triangles that meet under the blade: twice the force
    halves = np.array([(-1.0, -1.0, 0.0), (0.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.5, 0.0)])
    cut = feeler.Scene(meshes.mockup_of((halves, np.array([(0, 1, 3), (1, 2, 3)]))), threads=1)
    force, _, pairs = penalty.Penalty(cut, tool, stiffness_n_per_m=500.0).contact_wrench(np.eye(4))
    assert pairs == 2 and np.allclose(force, [0.0, 0.0, 1.0])


def test_voxels_are_filled_where_they_should_be() -> None:
    vertices, triangles = meshes.box((0.02, 0.02, 0.02), (0.0, 0.0, 0.0), 1)
    grid = point_shell.VoxelGrid(vertices, triangles, 0.001)
    points = np.array([(0.0, 0.0, 0.0), (0.00995, 0.0, 0.0), (0.013, 0.0, 0.0), (5.0, 0.0, 0.0)])
    assert grid.is_filled(grid.index(points)).tolist() == [True, True, False, False]
    assert 20**3 <= len(grid.filled) <= 22**3
    # a sheet encloses nothing: a layer, one or two voxels thick
    sheet = scenes.thin_sheet(0.01)
    layer = point_shell.VoxelGrid(*sheet, 0.001)
    assert 20**2 <= len(layer.filled) <= 2 * 22**2
    _, tool = box_and_plate()
    places, inwards = point_shell.shell_of(tool, 0.002)
    assert ((places - [0.0, 0.0, 0.02]) * inwards).sum(axis=1).max() < 0.0


@pytest.mark.parametrize("make", [penalty.Penalty, point_shell.PointShell])
def test_baselines_rest_on_a_plate_and_are_free_above(make: Any) -> None:
    scene, tool = box_and_plate()
    face = make(scene, tool)
    above = poses.pose((0.003, 0.002, 0.005))
    face.start(above)
    step = face.step(above)
    assert np.allclose(step.force, 0.0) and np.allclose(step.world_from_proxy, above)
    for depth in [*np.linspace(0.005, -0.001, 300), *([-0.001] * 500)]:
        step = face.step(poses.pose((0.003, 0.002, depth)))
    # held 1 mm deep by a spring of 1 N/mm: at least half of that, and straight up but for the stairs of voxels
    assert 0.5 < step.force[2] < 2.0 and np.linalg.norm(step.force[:2]) < 0.3 * step.force[2]
    assert -0.001 < step.world_from_proxy[2, 3] < 0.001


def test_a_hand_stays_at_rest_below_its_bound_and_swings_above() -> None:
    """The bound that is asked of sessions is where the simulated hand itself has it."""
    found = {}
    for share in (0.9, 1.3):

        class Wall(Spring):
            def step(self, world_from_device: Any, dt: float = 0.001, share: float = share) -> Said:
                stiffness = share * energy.bound_n_per_m(3)
                push = np.array([0.0, 0.0, stiffness * max(0.0, -world_from_device[2, 3])])
                return Said(world_from_device, push, np.zeros(3))

        result = energy.step_response(Wall, lambda _stiffness: None, (3,))
        found[share] = [goal.is_met for goal in goals.scorecard({"step_response": result})]
    assert found == {0.9: [True], 1.3: [False]}


def test_goals_tables_and_blocks_of_a_page() -> None:
    found = {
        "passing": passing.summary([passing.one(Ghost, 0)]),
        "forces": {"failed": "Traceback\nValueError: no"},
        "closed": energy.closed(Giving),
    }
    card = goals.scorecard(found)
    assert [goal.is_met for goal in card] == [False, False, False, False] and card[2].found == "ValueError: no"
    result = {
        "when": "2026-01-02T03:04:05+00:00",
        "commit": "0123456789",
        "dirty": False,
        "args": ["--quick"],
        "is_quick": True,
        "machine": {"cpu": "a CPU"},
        "faces": {"feeler": found},
    }
    made = tables.tables(json.loads(json.dumps(result)))
    assert "1 of 1" in made["passing"] and "% (press fast)**" in made["goals"] and "ValueError: no" in made["forces"]
    page = "# Haptics\n\n<!-- feel: passing -->\nold\n<!-- end of feel: passing -->\n\nafter\n"
    filled = tables.SECTION.filled(page, result)
    assert made["passing"] in filled and "old" not in filled and filled.endswith("\n\nafter\n")
    assert tables.SECTION.filled(filled, result) == filled
    with pytest.raises(pages.PageError, match="has no end"):
        tables.SECTION.filled(page.replace("end of feel: passing", "end of feel: passed"), result)
    with pytest.raises(pages.PageError, match="'others'"):
        tables.SECTION.filled(page.replace("passing", "others"), result)


def test_the_program_runs_and_writes(tmp_path: Path, root: Path) -> None:
    run = importlib.import_module("feel.run")
    asked = ["--quick", "--faces", "penalty", "--only", "passing,closed", "--runs", "2", str(tmp_path)]
    assert run.main(asked) == 0
    result = json.loads((tmp_path / "feel.json").read_text(encoding="utf-8"))
    assert result["faces"]["penalty"]["passing"]["runs"] == 2 and str(tmp_path) not in result["args"]
    assert "penalty: passed" in (tmp_path / "tables.md").read_text(encoding="utf-8")
