"""The sample mock-ups and tools: sizes, determinism, closed shells, gears that mesh."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

import feeler
from feeler import samples
from feeler.io.body import body_of
from feeler.io.export import write_glb
from feeler.samples import gearbox, gears, hardware, shapes, tools
from feeler.samples.mesh import VERTEX_GRID_M, Mesh, moved
from feeler.samples.tessellation import Tolerance, circle, hexagon, stitch, triangulate

NAMES = ("carcass", "differential", "turbine", "externals", "engine", "tay")
GEARBOX_GOLDEN = {40_000: "e9a2f5d62bb5ca62 0f6397deacf64603", 100_000: "f7a414ff2b67b716 0f6397deacf64603"}
"""Of vertices and faces, and of the paths, of `sample("gearbox", triangles)`."""
TOOLS = {"torque": 280, "wrench": 588, "square": 400, "hand": 4908}


def directed_edges(faces, vertex_count):
    f = np.asarray(faces, dtype=np.int64)
    start, end = f.ravel(), np.roll(f, -1, axis=1).ravel()
    return np.sort(start * vertex_count + end), np.sort(end * vertex_count + start)


def assert_closed(vertices, faces):
    """Every directed edge once, and its opposite once: closed, oriented, two triangles at each edge."""
    forth, back = directed_edges(faces, len(vertices))
    assert (np.diff(forth) > 0).all()
    assert np.array_equal(forth, back)


def volumes(vertices, faces, part, parts):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0, minlength=parts)


def areas(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.sqrt((np.cross(b - a, c - a) ** 2).sum(axis=1))


def digest(mesh):
    hashed = hashlib.sha256()
    for array in (mesh.vertices, mesh.faces):
        hashed.update(np.ascontiguousarray(array).tobytes())
    return hashed.hexdigest()


def check_mockup(mockup, triangles):
    assert 0.97 * triangles <= mockup.triangle_count <= triangles
    assert sum(d.count for d in mockup.report.defects.values()) == 0
    assert np.isfinite(mockup.vertices).all()
    names = [part.name for part in mockup.parts]
    assert len(set(names)) == len(names)
    assert len({part.path for part in mockup.parts}) == len(names)
    assert all(part.path.endswith("/" + part.name) and part.triangles > 0 for part in mockup.parts)
    vertices, faces = mockup.vertices, mockup.faces
    assert areas(vertices, faces).min() > 1e-13
    assert_closed(vertices, faces)
    assert volumes(vertices, faces, mockup.part_of_face, mockup.part_count).min() > 0.0
    assert len(np.unique(faces)) == len(vertices)
    assert np.array_equal(vertices.astype(np.float32).astype(np.float64), vertices)
    assert np.array_equal(np.rint(vertices / VERTEX_GRID_M) * VERTEX_GRID_M, vertices)


@pytest.mark.parametrize("triangles", [10_000, 100_000])
@pytest.mark.parametrize("name", NAMES)
def test_size_and_soundness(name, triangles):
    mockup = feeler.samples.sample(name, triangles)
    check_mockup(mockup, triangles)
    assert mockup.part_count >= (140 if triangles == 10_000 else 300)


@pytest.mark.parametrize(("triangles", "seed"), [(40_000, 0), (55_000, 6), (100_000, 1), (400_000, 3)])
def test_the_gearbox_is_sound(triangles, seed):
    mockup = feeler.sample("gearbox", triangles, seed)
    check_mockup(mockup, triangles)
    assert 300 <= mockup.part_count <= 600
    boxes = dict(zip(mockup.part_paths, mockup.part_bounds.reshape(-1, 2, 3), strict=True))
    assert mockup.source.up == "y"
    assert boxes["gearbox/door/panel"][1, 1] < boxes["gearbox/bracket/beam"][0, 1]


@pytest.mark.parametrize("triangles", GEARBOX_GOLDEN)
def test_the_gearbox_has_the_same_bytes_everywhere(triangles):
    mockup = feeler.sample("gearbox", triangles)
    paths = hashlib.sha256("\n".join(part.path for part in mockup.parts).encode()).hexdigest()
    assert f"{digest(mockup)[:16]} {paths[:16]}" == GEARBOX_GOLDEN[triangles]
    assert digest(feeler.sample("gearbox", triangles, seed=4)) != digest(mockup)


def test_a_gearbox_of_too_few_triangles():
    """The least number depends on the seed, and is enough."""
    for triangles in (-5, 0, 1, 10_000, 39_000):
        with pytest.raises(feeler.OptionError, match=f"triangles is {triangles}; .* at least 39[0-9]{{3}}") as told:
            feeler.sample("gearbox", triangles, seed=2)
    least = int(str(told.value).split("at least ")[1].split()[0])
    assert feeler.sample("gearbox", least, seed=2).triangle_count == least
    with pytest.raises(feeler.OptionError, match="at least"):
        feeler.sample("gearbox", least - 1, seed=2)
    with pytest.raises(feeler.OptionError, match="from about 40000 to 4000000"):
        feeler.sample("gearbox", 5_000_000)


def test_engine_at_a_million():
    mockup = samples.sample("engine", 1_000_000, seed=3)
    check_mockup(mockup, 1_000_000)
    assert 2500 <= mockup.part_count <= 5000
    extent = mockup.bounds[1] - mockup.bounds[0]
    assert 2.9 < extent[2] < 3.1
    assert (extent[:2] > 1.1).all() and (extent[:2] < 1.6).all()
    corners = mockup.vertices[mockup.faces]
    longest = np.sqrt(((corners - np.roll(corners, -1, axis=1)) ** 2).sum(axis=2)).max(axis=1)
    assert longest.max() > 2.5  # a shaft's full-length strip
    assert np.quantile(longest, 0.05) < 0.005  # bolts
    assert np.quantile(longest, 0.99) > 20 * np.quantile(longest, 0.05)  # as uneven as CAD
    for group in (
        "hp_compressor/stage_01/blade_001",
        "externals/fuel_pipe_01/clamp_001",
        "casings/lp_turbine/bolt_001",
    ):
        assert [part.path for part in mockup.parts.find("engine/" + group)] == ["engine/" + group]


@pytest.mark.parametrize("triangles", [10_001, 33_333, 271_828])
def test_odd_sizes(triangles):
    for name in ("differential", "engine"):
        count = samples.sample(name, triangles).triangle_count
        assert 0.97 * triangles <= count <= triangles


@pytest.mark.parametrize("name", NAMES)
def test_same_bytes_again_and_another_seed_differs(name):
    first, again = samples.sample(name, 20_000), samples.sample(name, 20_000)
    assert digest(first) == digest(again)
    assert [part.path for part in first.parts] == [part.path for part in again.parts]
    assert digest(samples.sample(name, 20_000, seed=1)) != digest(first)


def test_samples_leave_the_global_generator_alone():
    np.random.seed(7)
    before = np.random.random()
    np.random.seed(7)
    samples.sample("externals", 10_000, seed=2)
    assert np.random.random() == before


@pytest.mark.parametrize(
    ("name", "triangles", "seed"),
    [
        ("motor", 10_000, 0),
        ("engine", 9_999, 0),
        ("engine", 10**9, 0),
        ("engine", -1, 0),
        ("engine", 10_000.5, 0),
        ("engine", float("nan"), 0),
        ("engine", float("inf"), 0),
        ("engine", True, 0),
        ("engine", "many", 0),
        ("engine", 10_000, -1),
        ("engine", 10_000, 0.5),
        ("differential", 30_000_000, 0),
    ],
)
def test_bad_sample_options(name, triangles, seed):
    with pytest.raises(feeler.OptionError):
        samples.sample(name, triangles, seed)


def test_progress_is_told():
    seen = []
    samples.sample("engine", 100_000, progress=lambda fraction, stage: seen.append((fraction, stage)))
    assert len({fraction for fraction, stage in seen if stage == "tessellating"}) >= 5, "it takes most of the time"
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert all(isinstance(stage, str) and stage for _, stage in seen)


@pytest.mark.parametrize("fine", [False, True])
@pytest.mark.parametrize("name", TOOLS)
def test_tools(name, fine):
    tool = samples.sample_tool(name, fine)
    if fine:
        assert 49_000 <= tool.triangle_count <= 51_000
    else:
        assert abs(tool.triangle_count - TOOLS[name]) <= 0.15 * TOOLS[name]
    assert_closed(tool.vertices, tool.faces)
    assert areas(tool.vertices, tool.faces).min() > 1e-12
    assert volumes(tool.vertices, tool.faces, np.zeros(tool.triangle_count, dtype=np.int64), 1)[0] > 0.0
    length = tool.bounds[1] - tool.bounds[0]
    assert 0.2 < length[2] < 0.4
    assert tool.bounds[0, 2] <= 0.0
    assert digest(tool) == digest(samples.sample_tool(name, fine))


def test_coarse_and_fine_tools_have_the_same_surface():
    for name in TOOLS:
        coarse, fine = samples.sample_tool(name), samples.sample_tool(name, fine=True)
        assert np.abs(coarse.bounds - fine.bounds).max() < 0.004


def test_unknown_tool():
    with pytest.raises(feeler.OptionError, match="torque"):
        samples.sample_tool("hammer")


def test_names():
    assert samples.sample_names() == (*NAMES, "gearbox")
    assert samples.sample_tool_names() == tuple(TOOLS)


def test_a_tool_mesh_is_the_callers_own():
    first = tools.tool_mesh("wrench")
    first.vertices[:] = 0.0
    assert tools.tool_mesh("wrench").vertices.any()


def scene_of(mesh):
    return feeler.Scene(feeler.Mockup(mesh.vertices, mesh.faces))


def meets(a: Mesh, b: Mesh):
    return scene_of(a).is_colliding(feeler.Tool(b.vertices, b.faces), np.eye(4))


def test_spur_gears_mesh():
    tol = Tolerance(2e-6)
    module, teeth, mate = 0.003, 18, 41
    gear = gears.spur_gear(teeth, module, 0.02, 0.01, 0.2, tol)
    other = gears.spur_gear(mate, module, 0.02, 0.01, -0.2, tol)
    for turn in (0.0, 0.11, 0.29):
        for direction in (0.0, 2.0):
            distance = module * (teeth + mate) / 2.0
            here = gearbox.turned("z", turn)
            there = gearbox.at(distance * np.cos(direction), distance * np.sin(direction)) @ gearbox.turned(
                "z", gears.mate_turn(turn, teeth, mate, direction)
            )
            assert not meets(moved(gear, here), moved(other, there))
            jammed = there @ gearbox.turned("z", np.pi / mate)
            assert meets(moved(gear, here), moved(other, jammed))


def test_bevel_gears_mesh():
    tol = Tolerance(5e-6)
    ring, pinion = gearbox.drive_poses()
    wheel = gears.bevel_gear(gearbox.RING_TEETH, gearbox.PINION_TEETH, gearbox.RING_MODULE, 0.03, 0.072, tol)
    small = gears.bevel_gear(gearbox.PINION_TEETH, gearbox.RING_TEETH, gearbox.RING_MODULE, 0.03, 0.014, tol)
    assert not meets(moved(wheel, ring), moved(small, pinion))
    assert meets(moved(wheel, ring), moved(small, pinion @ gearbox.turned("z", np.pi / gearbox.PINION_TEETH)))
    placed = {
        name: moved(gears.bevel_gear(own, mate, gearbox.SPIDER_MODULE, 0.012, 0.0075, tol), pose)
        for name, ((own, mate), pose) in gearbox.bevel_poses().items()
    }
    for side in ("side_gear_1", "side_gear_2"):
        for spider in (name for name in placed if name.startswith("spider")):
            assert not meets(placed[side], placed[spider])


@pytest.mark.parametrize("chord", [2.4e-2, 6e-3, 1e-3, 2e-4, 2e-5, 1e-6])
def test_hardware_is_closed_at_every_tolerance(chord):
    tol = Tolerance(chord)
    made = [
        hardware.hex_bolt(0.008, 0.03, tol),
        hardware.cap_screw(0.006, 0.02, tol),
        hardware.nut(0.008, tol),
        hardware.ball(0.008, tol),
        hardware.race(0.05, 0.06, 0.02, 0.006, True, tol),
        hardware.race(0.05, 0.06, 0.02, 0.006, False, tol),
        hardware.saddle_clamp(0.008, tol),
        hardware.standoff(0.03, 0.03, 0.02, tol),
        hardware.angle_bracket(0.06, 0.05, 0.04, tol),
        hardware.control_box(0.2, 0.15, 0.08, 6, tol),
        hardware.pump(0.06, 0.15, tol),
        hardware.valve(0.02, tol),
    ]
    for mesh in made:
        assert_closed(mesh.vertices, mesh.faces)
        assert areas(mesh.vertices, mesh.faces).min() > 0.0
        assert volumes(mesh.vertices, mesh.faces, np.zeros(len(mesh.faces), dtype=np.int64), 1)[0] > 0.0


def test_a_flange_has_its_holes():
    tol = Tolerance(1e-4)
    profile = np.array([[0.10, 0.0], [0.13, 0.0], [0.13, 0.01], [0.10, 0.01]])
    bolts = shapes.BoltCircle(front=0, back=2, pitch_radius=0.115, hole_radius=0.005)
    plain, holed = shapes.revolve_flanged(profile, tol, [], 12), shapes.revolve_flanged(profile, tol, [bolts], 12)
    assert_closed(holed.vertices, holed.faces)
    missing = volumes(plain.vertices, plain.faces, np.zeros(len(plain.faces), dtype=np.int64), 1)[0]
    missing -= volumes(holed.vertices, holed.faces, np.zeros(len(holed.faces), dtype=np.int64), 1)[0]
    assert missing == pytest.approx(12 * np.pi * 0.005**2 * 0.01, rel=0.08)


def test_a_hollow_pipe_has_its_volume():
    tol = Tolerance(1e-6)
    corners = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.3, 0.0]])
    pipe = shapes.tube(shapes.bent_path(corners, 0.05, 0.01, tol), 0.01, 0.008, tol)
    assert_closed(pipe.vertices, pipe.faces)
    length = 0.15 + 0.25 + 0.05 * np.pi / 2.0
    volume = volumes(pipe.vertices, pipe.faces, np.zeros(len(pipe.faces), dtype=np.int64), 1)[0]
    assert volume == pytest.approx(np.pi * (0.01**2 - 0.008**2) * length, rel=2e-3)


def test_a_path_may_run_straight_through_a_corner():
    path = shapes.bent_path(np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]), 0.1, 0.01, Tolerance(1e-4))
    assert len(path.points) == 2


def test_triangulate_covers_a_polygon_with_notches():
    outline = np.array([[0, 0], [4, 0], [4, 3], [3, 3], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=np.float64)
    made = triangulate(outline)
    a, b, c = (outline[made[:, k]] for k in range(3))
    cross = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (cross > 0).all()
    assert 0.5 * cross.sum() == pytest.approx(8.0)


def test_stitch_uses_every_edge_once():
    low, high = hexagon(1.0), circle(2.0, 17, phase=0.3)
    on_low, on_high = stitch(np.arctan2(low[:, 1], low[:, 0]), np.arctan2(high[:, 1], high[:, 0]))
    assert sorted(on_low[:, 0]) == list(range(6))
    assert sorted(on_high[:, 2]) == list(range(17))


def test_chords_stay_within_the_tolerance():
    for chord in (1e-2, 1e-3, 1e-4):
        for radius in (0.01, 0.1, 1.0):
            n = Tolerance(chord).segments(radius)
            assert radius * (1.0 - np.cos(np.pi / n)) <= max(chord, 0.7 * radius) * 1.0001
            if chord < 0.5 * radius:
                assert radius * (1.0 - np.cos(np.pi / n)) <= chord * 1.0001


@pytest.mark.parametrize("seed", [51, 99, 1067])
def test_seeds_that_need_another_layout(seed: int) -> None:
    """A side too short for its mount, and a clip's post where a cover is."""
    mockup = feeler.sample("gearbox", 45_000, seed)
    assert 500 < mockup.part_count < 540
    post = feeler.Tool.of_parts(mockup, "gearbox/lines/oil_pipe/post")
    near = feeler.Scene(mockup).clearance(post, np.eye(4), 5e-4)
    assert "gearbox/covers/main_rear/cover" not in {mockup.part_paths[part] for part in near.parts.tolist()}


def test_faults_are_a_list_of_names() -> None:
    for wrong in ("pipe_clash", None, 5, [3]):
        with pytest.raises(feeler.OptionError, match="pipe_clash"):
            feeler.sample("gearbox", 45_000, faults=wrong)  # type: ignore[arg-type]
        with pytest.raises(feeler.OptionError, match="pipe_clash"):
            feeler.sample_truth("gearbox", 45_000, faults=wrong)  # type: ignore[arg-type]


def test_the_gearbox_comes_back_from_a_file_with_its_paths(tmp_path: Path) -> None:
    mockup = feeler.sample("gearbox", 45_000)
    write_glb(tmp_path / "gearbox.glb", body_of(mockup))
    assert sorted(feeler.load_mockup(tmp_path / "gearbox.glb").part_paths) == sorted(mockup.part_paths)
    write_glb(tmp_path / "other.glb", body_of(mockup))
    again = feeler.load_mockup(tmp_path / "other.glb").part_paths
    assert sorted(again) == sorted(f"other/{path}" for path in mockup.part_paths)
