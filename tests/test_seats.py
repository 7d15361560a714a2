"""One rule for parts that fit: planning, the page's hand and a haptic session let the same motions through."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from shapes import box

import feeler
from feeler import haptics
from feeler._core import GuardedMove
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.world import World

FAR = 0.1


def shifted(by: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = by
    return pose


def grip_tool(scene: feeler.Scene, part: int) -> feeler.Tool:
    """A cube of 1 mm beside a part, where nothing else is: a session holds the part by it."""
    vertices, _ = _mesh(scene, part)
    for reach in np.arange(0.5, 3.0, 0.25):
        for towards in np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]):
            centre = vertices.mean(axis=0) + reach * towards * np.ptp(vertices, axis=0).max() / 2
            tool = feeler.Tool(*box(centre - 5e-4, centre + 5e-4), "grip")
            if not scene.is_colliding(tool, np.eye(4)):
                return tool
    raise AssertionError("no place to grip from")


def led(
    scene: feeler.Scene, part: int, way: list[np.ndarray], step: float, poses: list[np.ndarray] | None = None
) -> np.ndarray:
    """Where a haptic session brings a part along a way: `(4, 4)`, world_from_part. poses: gets that of each step."""
    session = haptics.Session(scene, grip_tool(scene, part))
    session.start(np.eye(4))
    session.grip(part)
    return gone(session, _mesh(scene, part)[0], way, step, poses)


def gone(
    session: haptics.Session,
    vertices: np.ndarray,
    way: list[np.ndarray],
    step: float,
    poses: list[np.ndarray] | None = None,
) -> np.ndarray:
    """Where a session that holds some vertices comes along a way."""
    centre = vertices.mean(axis=0)
    for a, b in itertools.pairwise(way):
        count = int(np.ceil(np.linalg.norm(b[:3, 3] - a[:3, 3]) / step)) + int(np.ceil(10 * turned(a, b))) + 1
        for k in range(1, count + 1):
            last = session.step(feeler.poses.between(a, b, centre, k / count))
            if poses is not None:
                poses.append(last.world_from_proxy)
    for _ in range(40):
        last = session.step(way[-1])
    return last.world_from_proxy


def turned(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arccos(np.clip((np.trace(a[:3, :3].T @ b[:3, :3]) - 1) / 2, -1, 1)))


def dragged(scene: feeler.Scene, part: int, way: list[np.ndarray]) -> np.ndarray:
    """Where the page's hand brings a part along a way, in the mode that stops."""
    meshes = PartTools(scene.mockup)
    tool, _ = meshes.of(part)
    world = World(scene, meshes, {}, [part])
    hand, pose = GuardedMove(world, tool, way[0]), way[0]
    for wish in way[1:]:
        pose = hand.go(pose, wish, 2.5e-7, 5e-7).pose
    return pose


@pytest.fixture(scope="module")
def engine() -> feeler.Scene:
    return feeler.Scene(feeler.sample("engine", triangles=20_000))


@pytest.mark.parametrize("part", [1, 9, 13, 156])
def test_a_bolt_without_a_hole_leaves_along_its_axis_alone_in_all_rooms(engine: feeler.Scene, part: int) -> None:
    # With what it meets alone, as a mechanic would look at it.
    own = feeler.Tool(*_mesh(engine, part))
    met = engine.without([part]).collide(own, np.eye(4)).parts.tolist()
    scene, around = engine.only([*met, part]), engine.only(met)
    found = feeler.removal(scene, part, seconds=2.0)
    assert found.is_found and len(found.poses) == 2
    axis = found.poses[-1][:3, 3] - found.poses[0][:3, 3]
    axis /= np.linalg.norm(axis)
    size = float(np.linalg.norm(np.ptp(own.vertices, axis=0)))
    for direction in np.concatenate([np.eye(3), -np.eye(3)]):
        assert abs(direction @ axis) < 0.8
        way = [np.eye(4), shifted(FAR * direction)]
        # The page's hand does not turn aside: it stays within the play of the place.
        assert np.linalg.norm(dragged(scene, part, way)[:3, 3]) < 0.03 * size
        # A hand with force may be led out along the axis: in the plate, the bolt leaves its place by the play alone.
        # Almost out, its end is in the place of its head, which is wider.
        poses: list[np.ndarray] = []
        led(scene, part, way, 0.001, poses)
        centre = own.vertices.mean(axis=0)
        for pose in poses:
            if around.is_colliding(own, pose):
                by = pose[:3, :3] @ centre + pose[:3, 3] - centre
                aside, out = np.linalg.norm(by - (by @ axis) * axis), by @ axis
                assert out > -0.03 * size and (aside < 0.1 * size or out > 0.4 * size)


def _mesh(scene: feeler.Scene, part: int) -> tuple[np.ndarray, np.ndarray]:
    tool, _ = PartTools(scene.mockup).of(part)
    return tool.vertices, tool.faces


def test_ways_out_are_gone_by_the_hand_and_with_force(engine: feeler.Scene) -> None:
    # Parts with a short way: to search for those of parts that have none takes all the time that it is given.
    for part in (0, 92, 253, 299, 322, 345):
        found = feeler.removal(engine, part)
        assert found.is_found and len(found.poses) == 2
        way = [pose @ np.linalg.inv(found.poses[0]) for pose in found.poses]
        for end in (dragged(engine, part, way), led(engine, part, way, 0.002)):
            np.testing.assert_allclose(end, way[-1], atol=5e-4, err_msg=engine.mockup.part_names[part])


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("carcass", (66, 87, 171, 213, 276, 297)),
        ("differential", (53, 213, 223, 233, 243, 253)),
        ("tay", (219, 345)),
    ],
)
def test_ways_out_of_other_samples_are_gone_too(name: str, parts: tuple[int, ...]) -> None:
    scene = feeler.Scene(feeler.sample(name, triangles=20_000))
    for part in parts:
        found = feeler.removal(scene, part)
        assert found.is_found and len(found.poses) <= 5
        way = [pose @ np.linalg.inv(found.poses[0]) for pose in found.poses]
        # The part is the tool, in its own place: nothing that holds it is in its way.
        vertices, own_faces = _mesh(scene, part)
        session = haptics.Session(scene.without([part]), feeler.Tool(vertices, own_faces, "own"))
        session.start(np.eye(4))
        for end in (dragged(scene, part, way), gone(session, vertices, way, 0.002)):
            np.testing.assert_allclose(end, way[-1], atol=5e-4, err_msg=scene.mockup.part_names[part])


@pytest.mark.parametrize("name", ["head", "wall"])
def test_a_thin_part_does_not_pass_what_it_is_sunk_in(name: str) -> None:
    # A cover of 1 mm, 0.4 mm deep in a screw's head above it; and a pad 50 um deep in two sheets, as thin as it.
    if name == "head":
        part = box((-0.15, -0.05, 0.0), (0.15, 0.05, 0.001))
        around = [box((-0.004, -0.004, 0.0006), (0.004, 0.004, 0.004))]
    else:
        part = box((-0.05, -0.05, 0.0), (0.05, 0.05, 0.001))
        sheet = box((-0.0508, -0.06, -0.01), (-0.04995, 0.06, 0.02))
        around = [sheet, (sheet[0] * (-1, 1, 1), sheet[1][:, ::-1])]
    meshes = [part, *around]
    vertices = np.concatenate([mesh for mesh, _ in meshes])
    faces = np.concatenate([own + 8 * n for n, (_, own) in enumerate(meshes)])
    mockup = feeler.Mockup(vertices, faces, np.repeat(np.arange(len(meshes)), 12), ["part", *"ab"][: len(meshes)])
    scene = feeler.Scene(mockup)
    ahead = np.array([0.0, 0.0, 1.0] if name == "head" else [1.0, 0.0, 0.0])
    # It can leave another way.
    found = feeler.removal(scene, 0, directions=[ahead], seconds=5.0)
    assert found.is_found and found.poses[-1][:3, 3] @ ahead < 0.02
    for reach in (3e-4, 2e-3, 1e-2):
        way = [np.eye(4), shifted(reach * ahead)]
        for end in (dragged(scene, 0, way), led(scene, 0, way, 0.3)):
            # Of the face that leads, where it meets the other at the start.
            face = end[:3, :3] @ ahead
            at = np.array([0.0, 0.0, 0.001] if name == "head" else [0.05, 0.0, 0.0])
            assert ((end[:3, :3] @ at + end[:3, 3] - at) @ face) / (face @ ahead) < 2e-5, reach


def turned_profile(profile: list[tuple[float, float]], sides: int, phase: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A solid of revolution about z: (radius, height) from the axis at the bottom to the axis at the top."""
    angles = phase + 2 * np.pi * np.arange(sides) / sides
    rings = [np.c_[r * np.cos(angles), r * np.sin(angles), np.full(sides, z)] for r, z in profile[1:-1]]
    ends = [[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]]
    index = np.arange(len(rings) * sides).reshape(-1, sides)
    after = np.roll(index, -1, axis=1)
    quads = [np.c_[index[:-1].ravel(), after[:-1].ravel(), after[1:].ravel()]]
    quads.append(np.c_[index[:-1].ravel(), after[1:].ravel(), index[1:].ravel()])
    bottom = np.c_[np.full(sides, index.size), after[0], index[0]]
    top = np.c_[np.full(sides, index.size + 1), index[-1], after[-1]]
    return np.concatenate([*rings, ends]), np.concatenate([*quads, bottom, top])


def bore(inner: float, outer: float, height: float, sides: int, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """A tube about z, from z = 0."""
    angles = phase + 2 * np.pi * np.arange(sides) / sides
    profile = [(inner, 0.0), (outer, 0.0), (outer, height), (inner, height)]
    rings = [np.c_[r * np.cos(angles), r * np.sin(angles), np.full(sides, z)] for r, z in profile]
    index = np.arange(4 * sides).reshape(4, sides)
    after, above, both = np.roll(index, -1, axis=1), np.roll(index, -1, axis=0), np.roll(index, (-1, -1), axis=(0, 1))
    first = np.c_[index.ravel(), after.ravel(), both.ravel()]
    return np.concatenate(rings), np.concatenate([first, np.c_[index.ravel(), both.ravel(), above.ravel()]])


def beside(
    own: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]
) -> tuple[feeler.Scene, haptics.Session]:
    """A scene of a part (0) among another, and a session that holds it in its place."""
    vertices, faces = np.concatenate([own[0], other[0]]), np.concatenate([own[1], other[1] + len(own[0])])
    scene = feeler.Scene(
        feeler.Mockup(vertices, faces, np.repeat([0, 1], [len(own[1]), len(other[1])]), ["own", "other"])
    )
    return scene, held(scene, own)


def held(scene: feeler.Scene, own: tuple[np.ndarray, np.ndarray]) -> haptics.Session:
    """A session that holds part 0 in its place."""
    session = haptics.Session(scene.without([0]), feeler.Tool(*own, "own"))
    session.start(np.eye(4))
    return session


@pytest.mark.parametrize("head", [0.0, 0.0085])
def test_a_bolt_through_a_plate_leaves_to_the_side_where_nothing_holds_it(head: float) -> None:
    # Its tail is out below: the contact plane knows the way down alone.
    top = [(head, 0.0), (head, 0.005)] if head else [(0.005, 0.005)]
    bolt = turned_profile([(0.0, -0.04), (0.005, -0.04), (0.005, 0.0), *top, (0.0, 0.005)], 12, 0.1)
    scene, session = beside(bolt, box((-0.1, -0.08, -0.01), (0.09, 0.1, 0.0)))
    up, down = [np.eye(4), shifted(np.array([0, 0, 0.06]))], [np.eye(4), shifted(np.array([0, 0, -0.06]))]
    np.testing.assert_allclose(dragged(scene, 0, up), up[-1], atol=1e-9)
    np.testing.assert_allclose(gone(session, bolt[0], up, 0.002), up[-1], atol=5e-4)
    assert feeler.removal(scene, 0, seconds=5.0).is_found
    assert (dragged(scene, 0, down)[2, 3] > -1e-5) == (head > 0.0)


@pytest.mark.parametrize("gap", [0.0, 1e-4, 1e-3])
def test_a_plate_without_a_hole_leaves_its_bolt_along_it_alone(gap: float) -> None:
    plate, plate_faces = box((-0.05, -0.04, -0.01), (0.06, 0.05, 0.0))
    profile = [(0.0, -0.03), (0.005, -0.03), (0.005, gap), (0.0085, gap), (0.0085, gap + 0.005), (0.0, gap + 0.005)]
    vertices, faces = turned_profile(profile, 24, 0.1)
    for frame in frames()[:3]:
        turn, place = frame[:3, :3], frame[:3, 3]
        own = plate @ turn.T + place, plate_faces
        scene, session = beside(own, (vertices @ turn.T + place, faces))
        assert [seat.kind for seat in session.start(np.eye(4)).seats] == ["sunk"]
        for way in ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)):
            aside = [np.eye(4), shifted(0.12 * (turn @ way))]
            most = 1.5e-3 if way[2] == 0.0 else gap + 1.1e-6
            for end in (dragged(scene, 0, aside), gone(held(scene, own), own[0], aside, 1e-3)):
                assert np.linalg.norm(end[:3, 3]) < most + 1e-6
        down = [np.eye(4), shifted(-0.06 * turn[:, 2])]
        for end in (dragged(scene, 0, down), gone(session, own[0], down, 0.002)):
            np.testing.assert_allclose(end, down[-1], atol=5e-4)
        found = feeler.removal(scene, 0, seconds=20.0)
        assert found.is_found and (found.poses[-1][:3, 3] - found.poses[0][:3, 3]) @ turn[:, 2] < -0.02


@pytest.mark.parametrize("below", [0.0, 1e-12, 1e-3])
def test_a_bolt_that_is_flush_with_a_solid_does_not_slide_through_it(below: float) -> None:
    profile = [(0.0, -0.04), (0.005, -0.04), (0.005, 0.0), (0.0085, 0.0), (0.0085, 0.005), (0.0, 0.005)]
    bolt = turned_profile(profile, 12, 0.1)
    scene, session = beside(bolt, box((-0.1, -0.08, -0.06), (0.09, 0.1, below)))
    aside = [np.eye(4), shifted(np.array([0.1, 0, 0]))]
    assert np.linalg.norm(dragged(scene, 0, aside)[:3, 3]) < 2e-3
    assert np.linalg.norm(gone(session, bolt[0], aside, 0.002)[:3, 3]) < 2e-3


def frames() -> list[np.ndarray]:
    """`(4, 4)`: places up to 3 km off, turned in some way."""
    rng = np.random.default_rng(57)
    found = []
    for far in (0.0, 0.1, 30.0, 3000.0):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        frame = shifted(far * rng.normal(size=3))
        frame[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
        found.append(frame)
    return [np.eye(4), *found]


@pytest.mark.parametrize(("sides", "under"), [(16, [(0.003, -0.003)]), (33, [(0.003, -0.005), (0.006, -0.005)])])
def test_a_flush_head_goes_no_deeper_in_any_frame(sides: int, under: list[tuple[float, float]]) -> None:
    # Countersunk, and flat; in a plate without a hole.
    vertices, faces = turned_profile([(0.0, -0.02), (0.003, -0.02), *under, (0.006, 0.0), (0.0, 0.0)], sides, 0.1)
    plate, plate_faces = box((-0.05, -0.04, -0.03), (0.06, 0.05, 0.0))
    face = vertices[:, 2] == 0.0
    for above, frame in zip([0.0, 1e-15, 1e-9, 0.0, 1e-12], frames(), strict=True):
        turn, place = frame[:3, :3], frame[:3, 3]
        bolt = (vertices + np.array([0.0, 0.0, above])) @ turn.T + place, faces
        scene, session = beside(bolt, (plate @ turn.T + place, plate_faces))
        assert [seat.kind for seat in session.start(np.eye(4)).seats] == ["sunk"]
        for way in ((0.0, 0.0, -1.0), (0.6, 0.0, -0.8)):
            # The hand also in steps that are shorter than any tolerance.
            small, large = ([shifted(k * step * (turn @ way)) for k in range(31)] for step in (3e-6, 1e-3))
            pressed = gone(held(scene, bolt), bolt[0], [large[0], large[10]], 1e-3)
            for end in (dragged(scene, 0, small), dragged(scene, 0, large), pressed):
                moved = (bolt[0] @ end[:3, :3].T + end[:3, 3] - bolt[0]) @ turn
                assert moved[face, 2].min() > -1.1e-6, (frame, way)
        out = [np.eye(4), shifted(0.04 * turn[:, 2])]
        for end in (dragged(scene, 0, out), gone(session, bolt[0], out, 0.002)):
            np.testing.assert_allclose(end, out[-1], atol=5e-4)
        slowly = [shifted(k * 2e-5 * turn[:, 2]) for k in range(6)]
        np.testing.assert_allclose(dragged(scene, 0, slowly), slowly[-1], atol=1e-9)
    # The planner goes out too, though in is tried first.
    found = feeler.removal(scene, 0, directions=[-turn[:, 2]], seconds=20.0)
    assert found.is_found and (found.poses[-1][:3, 3] - found.poses[0][:3, 3]) @ turn[:, 2] > 0.0


@pytest.mark.parametrize(
    ("hole", "end"), [(0.002, 0.005), (0.0034, 0.005), (0.0039, 0.005), (0.0, 0.005), (0.0, 0.0), (0.0, -0.002)]
)
def test_a_head_that_bears_on_a_plate_goes_no_deeper_whatever_its_hole(hole: float, end: float) -> None:
    # The shank has a radius of 4 mm, sunk or a fit, and ends beyond the far face, flush with it, or inside.
    below = -0.012 - end
    profile = [(0.0, below), (0.004, below), (0.004, 0.0), (0.0068, 0.0), (0.0068, 0.005), (0.0, 0.005)]
    vertices, faces = turned_profile(profile, 24)
    under = vertices[:, 2] == 0.0
    plate, plate_faces = bore(hole, 0.03, 0.012, 24, 0.0) if hole else box((-0.04, -0.04, 0.0), (0.04, 0.04, 0.012))
    plate = plate - [0.0, 0.0, 0.012]
    for frame in frames()[::2]:
        turn, place = frame[:3, :3], frame[:3, 3]
        bolt = vertices @ turn.T + place, faces
        scene, session = beside(bolt, (plate @ turn.T + place, plate_faces))
        for way in ((0.0, 0.0, -1.0), (0.6, 0.0, -0.8)):
            small, large = ([shifted(k * step * (turn @ way)) for k in range(21)] for step in (3e-6, 5e-4))
            pressed = gone(held(scene, bolt), bolt[0], [large[0], large[-1]], 5e-4)
            for last in (dragged(scene, 0, small), dragged(scene, 0, large), pressed):
                moved = (bolt[0] @ last[:3, :3].T + last[:3, 3] - bolt[0]) @ turn
                assert moved[under, 2].min() > -1.1e-6, (frame, way)
        out = [np.eye(4), shifted(0.04 * turn[:, 2])]
        for last in (dragged(scene, 0, out), gone(session, bolt[0], out, 0.002)):
            np.testing.assert_allclose(last, out[-1], atol=5e-4)
    # The planner goes out too, though in is tried first.
    found = feeler.removal(scene, 0, directions=[-turn[:, 2]], seconds=20.0)
    assert found.is_found and (found.poses[-1][:3, 3] - found.poses[0][:3, 3]) @ turn[:, 2] > 0.0


@pytest.mark.parametrize("above", [0.0, 0.012])
def test_a_sheet_of_the_same_part_is_no_solid_above_a_sunk_pin(above: float) -> None:
    # The sheet lies on the plate around the pin, or is a roof over the pin, which stops it.
    plate = box((-0.04, -0.04, -0.01), (0.04, 0.04, 0.0))
    low = 0.0041 if above == 0.0 else -0.04
    sheet = np.array([[low, -0.04, above], [0.04, -0.04, above], [0.04, 0.04, above], [low, 0.04, above]])
    pin = turned_profile([(0.0, -0.006), (0.004, -0.006), (0.004, 0.004), (0.0, 0.004)], 24, 0.1)
    for winding in ([[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]):
        other = np.concatenate([plate[0], sheet]), np.concatenate([plate[1], np.array(winding) + 8])
        scene, session = beside(pin, other)
        assert [seat.kind for seat in session.start(np.eye(4)).seats] == ["sunk"]
        out = [shifted(np.array([0.0, 0.0, 1e-3 * k])) for k in range(41)]
        free = 0.04 if above == 0.0 else above - 0.004
        for last in (dragged(scene, 0, out), gone(session, pin[0], [out[0], out[-1]], 1e-3)):
            assert last[2, 3] == pytest.approx(free, abs=1e-4)
        aside = [np.eye(4), shifted(np.array([0.01, 0.0, 0.0]))]
        for last in (dragged(scene, 0, aside), gone(held(scene, pin), pin[0], aside, 1e-3)):
            assert np.linalg.norm(last[:3, 3]) < 5e-4
        assert feeler.removal(scene, 0, directions=[[0.0, 0.0, 1.0]], seconds=20.0).is_found


def socket_screw(sides: int, corners: int) -> tuple[np.ndarray, np.ndarray]:
    """A countersunk screw, its head up to z = 0, with a socket 1.8 mm deep."""
    profile = [(0.0, -0.02), (0.003, -0.02), (0.003, -0.003), (0.006, 0.0), (0.0, 0.0)]
    vertices, faces = turned_profile(profile, sides, 0.1)
    ring, floor = np.arange(2 * sides, 3 * sides), len(vertices) - 1
    vertices[floor, 2] = -0.0018
    angles = 2 * np.pi * np.arange(corners) / corners
    rim = np.c_[0.0023 * np.cos(angles), 0.0023 * np.sin(angles), np.zeros(corners)]
    first = len(vertices)
    cap, o, i = [], 0, 0
    while o < sides or i < corners:
        inner, outer = first + i % corners, ring[o % sides]
        if i >= corners or (o < sides and 0.1 + 2 * np.pi * (o + 1) / sides <= 2 * np.pi * (i + 1) / corners):
            o += 1
            cap.append([outer, ring[o % sides], inner])
        else:
            i += 1
            cap.append([outer, first + i % corners, inner])
    for k in range(corners):
        a, b = first + k, first + (k + 1) % corners
        cap += [[a, b, b + corners], [a, b + corners, a + corners], [a + corners, b + corners, floor]]
    return np.concatenate([vertices, rim, rim - [0, 0, 0.0018]]), np.concatenate([faces[:-sides], cap])


@pytest.mark.parametrize(("sides", "corners"), [(16, 6), (33, 4)])
def test_a_socket_does_not_hold_its_screw_in_a_plate_without_a_hole(sides: int, corners: int) -> None:
    vertices, faces = socket_screw(sides, corners)
    plate, plate_faces = box((-0.05, -0.04, -0.03), (0.06, 0.05, 0.0))
    for frame in frames():
        turn, place = frame[:3, :3], frame[:3, 3]
        screw = vertices @ turn.T + place, faces
        scene, session = beside(screw, (plate @ turn.T + place, plate_faces))
        assert [seat.kind for seat in session.start(np.eye(4)).seats] == ["sunk"]
        out = [shifted(k * 1e-3 * turn[:, 2]) for k in range(31)]
        for end in (dragged(scene, 0, out), gone(session, screw[0], [out[0], out[-1]], 0.001)):
            np.testing.assert_allclose(end, out[-1], atol=5e-4)
        found = feeler.removal(scene, 0, seconds=20.0)
        assert found.is_found and (found.poses[-1][:3, 3] - found.poses[0][:3, 3]) @ turn[:, 2] > 0.02
        # Neither in nor aside.
        for way in (-turn[:, 2], turn[:, 0]):
            end = dragged(scene, 0, [np.eye(4), shifted(0.01 * way)])
            assert np.linalg.norm(end[:3, 3]) < 5e-4


def test_a_cup_does_not_go_through_a_post_that_fills_it() -> None:
    # Upside down over the post, which goes on through the cup's floor.
    cup = turned_profile([(0.0, 0.025), (0.01, 0.025), (0.01, 0.0), (0.02, 0.0), (0.02, 0.03), (0.0, 0.03)], 12, 0.1)
    post = turned_profile([(0.0, -0.02), (0.011, -0.02), (0.011, 0.05), (0.0, 0.05)], 12, 0.1)
    scene, session = beside(cup, post)
    assert [seat.kind for seat in session.start(np.eye(4)).seats] == ["sunk"]
    down = [np.eye(4), shifted(np.array([0.0, 0.0, -0.02]))]
    assert dragged(scene, 0, down)[2, 3] > -1e-3


def test_a_flush_collar_goes_no_deeper_than_it_is_beside_a_shaft_that_crosses_its_bore() -> None:
    # 17 sides in 8 of the same radius: the shaft is 0.4 mm deep in its bore.
    profile = [(0.0, -0.005), (0.01, -0.005), (0.01, 0.03), (0.015, 0.03), (0.015, 0.035), (0.0, 0.035)]
    shaft = turned_profile(profile, 17, 0.3)
    scene, session = beside(shaft, bore(0.01, 0.02, 0.03, 8, 0.0))
    down = [np.eye(4), shifted(np.array([0, 0, -0.01]))]
    assert dragged(scene, 0, down)[2, 3] > -1.1e-6
    assert gone(session, shaft[0], down, 0.001)[2, 3] > -1.1e-6
    up = [np.eye(4), shifted(np.array([0, 0, 0.06]))]
    assert dragged(scene, 0, up)[2, 3] == pytest.approx(0.06)


def test_a_pin_that_was_tilted_in_its_bore_comes_back_and_out() -> None:
    pin = turned_profile([(0.0, -0.006), (0.0099, -0.006), (0.0099, 0.03), (0.0, 0.03)], 16, 0.29)
    _, session = beside(pin, bore(0.01, 0.016, 0.02, 16, 0.75))
    tilt = np.eye(4)
    tilt[1:3, 1:3] = [[np.cos(0.8), -np.sin(0.8)], [np.sin(0.8), np.cos(0.8)]]
    for k in range(60):
        session.step(feeler.poses.between(np.eye(4), tilt, np.zeros(3), min(1.0, k / 30)))
    for _ in range(200):
        session.step(np.eye(4))
    out = [np.eye(4), shifted(np.array([0, 0, 0.06]))]
    np.testing.assert_allclose(gone(session, pin[0], out, 0.0005)[2, 3], 0.06, atol=1e-4)


def test_a_block_on_a_bracket_stops_at_the_wall_in_the_page() -> None:
    plate, wall, block = (
        box((-0.1, -0.1, -0.02), (0.1, 0.1, 0.0)),
        box((0.035, -0.1, 0.0), (0.055, 0.1, 0.06)),
        box((-0.015, -0.015, -0.015), (0.015, 0.015, 0.015)),
    )
    for gap in (0.0, 1e-15, 1e-12, 1e-6, -1e-12, -1e-6, -1e-5):
        for place in ((0.0, 0.0, 0.0), (3000.0, -2000.0, 1000.0)):
            at = np.array([0.01, 0.0, 0.015 + gap])
            vertices = np.concatenate([plate[0], wall[0], block[0] + at]) + place
            faces = np.concatenate([plate[1], wall[1] + 8, block[1] + 16])
            mockup = feeler.Mockup(vertices, faces, np.repeat([0, 1], [24, 12]), ["bracket", "block"])
            scene = feeler.Scene(mockup)
            end = dragged(scene, 1, [np.eye(4), shifted(np.array([0.03, 0.0, 0.0]))])
            assert 0.01 - 3e-6 < end[0, 3] <= 0.01 + 1e-9, (gap, place)
            down = dragged(scene, 1, [np.eye(4), shifted(np.array([0.0, 0.0, -0.01]))])
            assert -1.2e-5 < down[2, 3] <= 1e-9, (gap, place)
            up = dragged(scene, 1, [np.eye(4), shifted(np.array([0.0, 0.0, -0.01])), shifted(np.array([0, 0, 0.05]))])
            assert up[2, 3] == pytest.approx(0.05), (gap, place)
