"""trimesh's collision manager, answered by feeler; MuJoCo's geometries as bodies."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from trimesh.creation import annulus, box, icosphere, torus

import feeler
from feeler.compat import meshes
from feeler.compat.mujoco import collision_manager, move
from feeler.compat.trimesh import CollisionManager, scene_to_collision

CUBE = box((1, 1, 1))


def opened(mesh: Any) -> tuple[np.ndarray, np.ndarray]:
    """The mesh without its last triangle: not closed, so not solid."""
    return mesh.vertices, mesh.faces[:-1]


def at(x: float, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    place = np.eye(4)
    place[:3, 3] = x, y, z
    return place


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def placed(rng: np.random.Generator, reach: float) -> np.ndarray:
    place = np.eye(4)
    place[:3, :3] = random_rotation(rng)
    place[:3, 3] = rng.uniform(-reach, reach, 3)
    return place


def moved(mesh: Any, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A mesh in the world, with the roundings of the contract."""
    x, y, z = np.asarray(mesh.vertices, dtype=np.float64).T
    columns = [((row[0] * x + row[1] * y) + row[2] * z) + row[3] for row in place[:3]]
    return np.column_stack(columns), np.asarray(mesh.faces)


def test_each_method_of_trimesh_s() -> None:
    manager = CollisionManager()
    manager.add_object("a", CUBE)
    manager.add_object("b", CUBE, at(5))
    assert manager.in_collision_single(CUBE) is True
    assert manager.in_collision_single(CUBE, at(-5)) is False
    assert manager.in_collision_single(CUBE, at(5.5), return_names=True) == (True, {"b"})
    hit, names, contacts = manager.in_collision_single(CUBE, at(5), return_names=True, return_data=True)
    assert hit and names == {"b"} and contacts
    for contact in contacts:
        assert contact.names == {"b", "__external"}
        assert contact.depth == pytest.approx(1.0, rel=1e-5)
        assert sorted(np.abs(contact.normal)) == pytest.approx([0, 0, 1])
        assert 0 <= contact.index("b") < 12 and 0 <= contact.index("__external") < 12
    assert manager.in_collision_internal() is False
    manager.add_object("c", CUBE, at(5, 0.5))
    assert manager.in_collision_internal(return_names=True) == (True, {("b", "c")})
    manager.set_transform("c", at(-5))
    assert manager.in_collision_internal(True, True) == (False, set(), [])
    assert manager.min_distance_internal(return_names=True) == (4.0, ("a", "b"))
    assert manager.min_distance_internal("c", return_names=True) == (4.0, ("a", "c"))
    assert manager.min_distance_single(CUBE, at(5.75)) == pytest.approx(-0.25, rel=1e-4)
    assert manager.min_distance_single(CUBE, at(2), return_name=True) == (1.0, "a")
    distance, name, data = manager.min_distance_single(CUBE, at(9, 1, 0), return_name=True, return_data=True)
    assert (distance, name, data.distance) == (3.0, "b", 3.0) and data.names == {"b", "__external"}
    assert data.point("b")[0] == 5.5 and data.point("__external")[0] == 8.5
    manager.remove_object("c")
    other = CollisionManager()
    other.add_object("x", CUBE, at(5.5))
    other.add_object("a", CUBE, at(-9))
    assert manager.in_collision_other(other) is True
    assert manager.in_collision_other(other, return_names=True) == (True, {("b", "x")})
    assert other.in_collision_other(manager, return_names=True) == (True, {("x", "b")})
    other.remove_object("x")
    distance, pair, data = manager.min_distance_other(other, return_names=True, return_data=True)
    assert (distance, pair) == (8.0, ("a", "a")) and data.distance == 8.0
    assert manager.names == ["a", "b"]
    assert repr(manager) == "<CollisionManager of 2 objects>"


def test_nothing_to_compare_is_infinitely_far() -> None:
    manager = CollisionManager()
    assert manager.min_distance_internal(return_names=True, return_data=True) == (np.inf, None, None)
    assert manager.min_distance_single(CUBE) == np.inf
    assert manager.in_collision_internal(return_names=True, return_data=True) == (False, set(), [])
    manager.add_object("one", CUBE)
    assert manager.min_distance_internal() == np.inf
    assert manager.min_distance_internal("one") == np.inf
    assert manager.min_distance_other(CollisionManager()) == np.inf
    assert manager.in_collision_other(manager) is True  # each with each: with itself, too


def test_bodies_that_all_move_meet_where_their_vertices_are() -> None:
    rng = np.random.default_rng(4)
    shapes = [
        SimpleNamespace(vertices=vertices, faces=faces)
        for vertices, faces in map(opened, (torus(1.0, 0.3, 12, 6), icosphere(1, 0.8), box((1.5, 0.4, 0.9))))
    ]
    manager = CollisionManager(threads=1)
    places = [placed(rng, 2.0) for _ in range(12)]
    kinds = [shapes[i % 3] for i in range(12)]
    for i in range(12):
        manager.add_object(i, kinds[i], places[i])
    for frame in range(4):
        pairs, triangles, least = set(), set(), np.inf
        for i in range(12):
            scene = feeler.Scene(feeler.Mockup(*moved(kinds[i], places[i])), threads=1)
            for j in range(i):
                tool = feeler.Tool(*moved(kinds[j], places[j]))
                hit = scene.collide(tool, np.eye(4))
                triangles.update((j, i, int(t), int(m)) for t, m in hit.pairs)
                if len(hit):
                    pairs.add((j, i))
                least = min(least, scene.distance(tool, np.eye(4)).value)
        hit, names, contacts = manager.in_collision_internal(return_names=True, return_data=True)
        assert (hit, names) == (bool(pairs), pairs), frame
        found = {(a, b, c.index(a), c.index(b)) for c in contacts for a, b in [sorted(c.names)]}
        assert found == triangles
        assert manager.min_distance_internal() == pytest.approx(least, abs=1e-12)
        for i in range(12):
            places[i] = places[i] @ placed(rng, 0.3)
            manager.set_transform(i, places[i])
    assert pairs


@pytest.mark.parametrize(
    "linear",
    [np.diag([2.0, 2.0, 2.0]), np.diag([-1.0, 1.0, 1.0]), np.array([[1.0, 0.4, 0], [0, 2.0, 0.1], [0, 0, 0.5]])],
    ids=["scaled", "mirrored", "sheared"],
)
def test_a_transform_may_scale_mirror_and_shear(linear: np.ndarray) -> None:
    rng = np.random.default_rng(8)
    mesh = torus(1.0, 0.3, major_sections=12, minor_sections=6)
    probe = opened(icosphere(1, 0.4))
    manager = CollisionManager()
    manager.add_object("rigid first", mesh)
    for turn in range(5):
        place = placed(rng, 1.0)
        place[:3, :3] = place[:3, :3] @ linear
        manager.add_object("stretched", mesh, place)
        manager.set_transform("rigid first", place)
        # By hand: the same triangles, where numpy puts them.
        hand = CollisionManager()
        points = mesh.vertices @ place[:3, :3].T + place[:3, 3]
        hand.add_object("by hand", (points, mesh.faces))
        for x in (0.0, 0.5, 1.0, 2.0, 4.0):
            expected = hand.min_distance_single(probe, at(x))
            for name in ("stretched", "rigid first"):
                alone = CollisionManager()
                alone.add_object("probe", probe, at(x))
                here, distance = manager, manager.min_distance_single(probe, at(x))
                assert distance == pytest.approx(expected, abs=1e-9), (turn, name)
                assert here.in_collision_single(probe, at(x)) == hand.in_collision_single(probe, at(x))
        manager.remove_object("stretched")
    manager.set_transform("rigid first", at(0))
    assert manager.min_distance_single(probe, at(3)) == pytest.approx(3 - 1.3 - 0.4, abs=1e-9)


def test_a_convex_mesh_is_solid_and_others_are_surfaces() -> None:
    small = box((0.1, 0.1, 0.1))
    apart = (CUBE.vertices[CUBE.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    for outer, meets, distance in ((CUBE, True, -0.55), (apart, True, -0.55), (opened(CUBE), False, 0.45)):
        manager = CollisionManager()
        manager.add_object("outer", outer)
        assert manager.in_collision_single(small) is meets
        assert manager.min_distance_single(small) == pytest.approx(distance, rel=2e-3)
        assert bool(manager.in_collision_single(small, return_data=True)[1]) is meets
    ring = torus(1.0, 0.3, major_sections=12, minor_sections=6)
    manager = CollisionManager()
    manager.add_object("ring", ring)
    manager.add_object("other", ring, at(1.0))
    assert manager.min_distance_internal() == 0.0


def test_contacts_travel_before_and_after_their_depth_is_asked() -> None:
    manager = CollisionManager()
    manager.add_object("a", CUBE)
    manager.add_object("b", CUBE, at(0.75))
    contact = manager.in_collision_internal(return_data=True)[1][0]
    for _ in range(2):
        for again in (pickle.loads(pickle.dumps(contact)), copy.deepcopy(contact)):
            assert (again.pair, again.depth, again.normal.tolist()) == (
                contact.pair,
                contact.depth,
                contact.normal.tolist(),
            )


def test_depth_and_normal_are_of_the_time_of_the_question() -> None:
    manager = CollisionManager()
    manager.add_object("a", CUBE)
    manager.add_object("b", CUBE, at(0.9))
    contact = manager.in_collision_internal(return_data=True)[1][0]
    manager.set_transform("b", at(0.5))
    manager.remove_object("a")
    assert contact.depth == pytest.approx(0.1, rel=1e-4)
    assert contact.pair == ("b", "a")
    assert contact.normal == pytest.approx([-1, 0, 0], abs=1e-9)


def test_plates_part_by_the_short_way() -> None:
    for place, depth in ((at(0, 1.45), 0.06), (at(0, 0, 1.4), 0.11), (at(0), 1.51)):
        manager = CollisionManager()
        manager.add_object("lying", box((3, 3, 0.02)))
        manager.add_object("upright", box((3, 0.02, 3)), place)
        assert manager.min_distance_internal() == pytest.approx(-depth, rel=1e-5)


def test_many_overlaps_are_measured_where_they_may_be_deepest() -> None:
    manager = CollisionManager(threads=1)
    for i in range(300):
        manager.add_object(i, CUBE, at(0, 0, 0 if i < 299 else 0.5))
    distance, names = manager.min_distance_internal(return_names=True)
    assert distance == pytest.approx(-1.0, rel=1e-5) and 299 not in names


def test_triangles_that_are_not_queried_are_told() -> None:
    vertices = CUBE.vertices.copy()
    vertices[CUBE.faces[0, 0]] = np.nan
    manager = CollisionManager()
    with pytest.warns(UserWarning, match=r"'bad': \d triangles non_finite: not queried"):
        manager.add_object("bad", (vertices, CUBE.faces))
    faces = CUBE.faces.copy()
    faces[0, 0] = -1
    with pytest.warns(UserWarning, match="1 triangle index_out_of_range"):
        manager.add_object("bad", (CUBE.vertices, faces))


def test_rounded_meshes_are_as_convex_as_for_trimesh() -> None:
    rng = np.random.default_rng(2)
    ball = icosphere(4, 1.0)
    rounded = (ball.vertices @ random_rotation(rng).T + 3).astype(np.float32)
    small = box((0.1, 0.1, 0.1))
    for mesh in ((rounded, ball.faces), (rounded, ball.faces[:, ::-1])):
        manager = CollisionManager()
        manager.add_object("ball", mesh)
        assert manager.in_collision_single(small, at(3, 3, 3)) is True


def test_triangles_that_both_collapse_by_rounding_meet() -> None:
    sliver = (np.array([[0, 0, 0], [2.0**-30, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    for apart, meets in ((0.0, True), (0.5, True), (1.0, True), (1.5, False)):
        manager = CollisionManager()
        manager.add_object(0, sliver, at(1e9, 1e9))
        manager.add_object(1, sliver, at(1e9, 1e9 + apart))
        assert manager.in_collision_internal() is meets
        assert manager.min_distance_internal() == max(apart - 1.0, 0.0)


def test_the_normal_leads_the_second_of_a_pair_out_of_the_first() -> None:
    ball, plate = icosphere(2, 0.5), box((3, 3, 0.2))
    for first, second in ((ball, plate), (plate, ball)):
        place = at(0.1, 0.2, 0.4)
        manager, other = CollisionManager(), CollisionManager()
        manager.add_object(0, first)
        other.add_object(1, second, place)
        for contact, pair, up in (
            (manager.in_collision_single(second, place, return_data=True)[1][0], (0, "__external"), 1),
            (manager.in_collision_other(other, return_data=True)[1][0], (0, 1), 1),
            (other.in_collision_other(manager, return_data=True)[1][0], (1, 0), -1),
        ):
            assert contact.pair == pair and contact.names == set(pair)
            assert contact.normal[2] * up > 0.99
            away = place.copy()
            away[:3, 3] += contact.normal * contact.depth * up
            assert manager.in_collision_single(second, away) is False
        # Of one manager the one that was added first is the second, as with python-fcl.
        manager.add_object(1, second, place)
        contact = manager.in_collision_internal(return_data=True)[1][0]
        assert contact.pair == (1, 0)
        manager.set_transform(0, np.diag([1.0, 1.0, 1.001, 1.0]))  # a new shape, so a new body
        assert manager.in_collision_internal(return_data=True)[1][0].pair == (1, 0)
        manager.set_transform(0, np.eye(4))
        manager.set_transform(0, at(*(contact.normal * contact.depth)))
        assert manager.in_collision_internal() is False
        assert contact.index(0) < len(first.faces) and contact.index(1) < len(second.faces)


def test_meshes_of_other_kinds() -> None:
    points = [SimpleNamespace(x=float(x), y=float(y), z=float(z)) for x, y, z in CUBE.vertices]
    vectors = [type("Vector", (tuple,), {})((p.x, p.y, p.z)) for p in points]
    freecad = SimpleNamespace(Topology=(vectors, [tuple(map(int, face)) for face in CUBE.faces]))
    mockup = feeler.Mockup(CUBE.vertices, CUBE.faces)
    for mesh in (freecad, SimpleNamespace(Mesh=freecad), mockup, (CUBE.vertices, CUBE.faces)):
        manager = CollisionManager()
        manager.add_object("mesh", mesh)
        assert manager.min_distance_single(CUBE, at(3)) == 2.0


def test_shapes_are_shared_by_content_and_dropped() -> None:
    mesh = icosphere(1, 0.123)
    manager = CollisionManager()
    manager.add_object(1, mesh)
    manager.add_object(2, (mesh.vertices.copy(), mesh.faces.copy()), at(1))
    assert manager._placed[1].shape is manager._placed[2].shape
    manager.add_object(3, (np.nextafter(mesh.vertices, 1), mesh.faces), at(2))
    assert manager._placed[3].shape is not manager._placed[1].shape
    for n in range(2 * meshes.MOST_KEPT):
        CollisionManager().in_collision_single((CUBE.vertices * (1 + n), CUBE.faces))
    assert len(meshes._kept) == meshes.MOST_KEPT
    assert len(meshes._alive) <= meshes.MOST_KEPT + 20


def test_a_scene_of_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    scene.add_geometry(box((1, 1, 1)), node_name="left")
    scene.add_geometry(box((1, 1, 1)), node_name="right", transform=at(1))
    manager, numbers = scene_to_collision(scene)
    assert sorted(numbers) == ["left", "right"]
    assert manager.in_collision_internal(return_names=True) == (True, {("left", "right")})


def test_geometries_of_mujoco() -> None:
    # As its arrays are: two meshes one after the other, and a plane, which has no mesh.
    names = ["base", "", "floor"]
    model = SimpleNamespace(
        geom_type=np.array([7, 7, 0]),
        geom_dataid=np.array([1, 0, -1]),
        mesh_vert=np.concatenate([CUBE.vertices, 2 * CUBE.vertices]).astype(np.float32),
        mesh_face=np.concatenate([CUBE.faces, CUBE.faces]).astype(np.int32),
        mesh_vertadr=np.array([0, 8]),
        mesh_vertnum=np.array([8, 8]),
        mesh_faceadr=np.array([0, 12]),
        mesh_facenum=np.array([12, 12]),
        geom=lambda i: SimpleNamespace(name=names[i]),
    )
    data = SimpleNamespace(
        geom_xpos=np.array([[0.0, 0, 0], [4, 0, 0], [0, 0, 0]]), geom_xmat=np.tile(np.eye(3).ravel(), (3, 1))
    )
    manager = collision_manager(model, data)
    assert manager.names == ["base", "geom_1"]
    assert manager.min_distance_internal() == 2.5
    data.geom_xpos[1, 0] = 1.5
    move(manager, model, data)
    assert manager.in_collision_internal(return_names=True) == (True, {("base", "geom_1")})
    for call in (lambda: collision_manager(box((1, 1, 1))), lambda: move(manager, None, data)):
        with pytest.raises(feeler.MeshError, match=r"mujoco\.MjModel"):
            call()
    other = SimpleNamespace(geom_xpos=data.geom_xpos[:2], geom_xmat=data.geom_xmat[:2])
    for call in (
        lambda: move(manager, model, None),
        lambda: move(manager, model, other),
        lambda: collision_manager(model, 5),
    ):
        with pytest.raises(feeler.MeshError, match=r"mujoco\.MjData"):
            call()
    with pytest.raises(feeler.OptionError, match="manager"):
        move(None, model, data)  # type: ignore[arg-type]
    names[0] = "geom_1"
    assert collision_manager(model, data).names == ["geom_1", "geom_1_"]


def _flat() -> np.ndarray:
    return np.diag([1.0, 1.0, 0.0, 1.0])


BAD: list[tuple[Callable[[CollisionManager], object], type[Exception], str]] = [
    (lambda m: m.remove_object("nobody"), feeler.OptionError, "'nobody' is not in the collision manager"),
    (lambda m: m.set_transform("nobody", np.eye(4)), feeler.OptionError, "'nobody' is not"),
    (lambda m: m.set_transform([], np.eye(4)), feeler.OptionError, "is not in the collision manager"),
    (lambda m: m.min_distance_internal("nobody"), feeler.OptionError, "'nobody' is not"),
    (lambda m: m.add_object("x", CUBE, np.eye(3)), feeler.PoseError, "shape"),
    (lambda m: m.add_object("x", CUBE, _flat()), feeler.PoseError, "flattens"),
    (lambda m: m.set_transform("a", _flat()), feeler.PoseError, "flattens"),
    (lambda m: m.set_transform("a", np.full((4, 4), np.nan)), feeler.PoseError, "not finite"),
    (lambda m: m.set_transform("a", at(0).T + 1), feeler.PoseError, "last row"),
    (lambda m: m.set_transform("a", "x"), feeler.PoseError, "matrix|read"),
    (lambda m: m.add_object([], CUBE), feeler.OptionError, "key of a dict"),
    (lambda m: m.set_transform("a", np.eye(4) * 1j), feeler.PoseError, "real numbers"),
    (lambda m: m.add_object("x", SimpleNamespace(Topology=5)), feeler.MeshError, "topology"),
    (lambda m: m.add_object("x", 7), feeler.MeshError, "vertices and faces"),
    (lambda m: m.add_object("x", ([], [])), feeler.MeshError, "shape|empty"),
    (lambda m: m.add_object("x", (np.full((3, 3), np.nan), [[0, 1, 2]])), feeler.MeshError, "nothing|can be queried"),
    (lambda m: m.in_collision_other(7), feeler.OptionError, "other_manager"),
    (lambda m: m.min_distance_other(None), feeler.OptionError, "other_manager"),
    (lambda m: m.in_collision_internal(return_names="yes"), feeler.OptionError, "return_names"),
    (lambda m: CollisionManager(threads=0), feeler.OptionError, "threads"),
    (lambda m: scene_to_collision(CUBE), feeler.MeshError, "scene of trimesh"),
]


@pytest.mark.parametrize(("call", "error", "words"), BAD, ids=[str(i) for i in range(len(BAD))])
def test_what_is_wrong_is_said_and_changes_nothing(
    call: Callable[[CollisionManager], object], error: type[Exception], words: str
) -> None:
    manager = CollisionManager()
    manager.add_object("a", CUBE)
    manager.add_object("b", CUBE, at(1))
    with pytest.raises(error, match=words):
        call(manager)
    assert manager.in_collision_internal(return_names=True) == (True, {("a", "b")})


@pytest.mark.parametrize("bad", [_flat(), at(1e300), np.diag([2.0, 2.0, 2.0, 1.0]) + at(1e200) - np.eye(4)])
def test_a_refused_place_leaves_the_object(bad: np.ndarray) -> None:
    for transform in (np.eye(4), np.diag([2.0, 2.0, 2.0, 1.0])):
        manager = CollisionManager()
        manager.add_object("a", CUBE, transform)
        with pytest.raises(feeler.PoseError):
            manager.add_object("a", CUBE, bad)
        with pytest.raises(feeler.PoseError):
            manager.set_transform("a", bad)
        assert manager.in_collision_single(CUBE, return_names=True) == (True, {"a"})
        manager.set_transform("a", at(9))
        assert manager.in_collision_single(CUBE) is False
        manager.remove_object("a")
        assert manager.names == []


def test_several_threads_ask_and_move_at_once() -> None:
    manager = CollisionManager()
    for i in range(20):
        manager.add_object(i, CUBE, at(2.0 * i))
    asked = CollisionManager()
    asked.add_object("q", CUBE, at(4.0))

    def work(n: int) -> bool:
        if n % 3 == 0:
            place = at(2.0 * (10 + n % 10), 0.1 * (n % 2))
            place[0, 0] = 1 + n % 4 / 8  # a new shape: its body gets another number
            manager.set_transform(10 + n % 10, place)
        names = manager.in_collision_other(asked, return_names=True)[1]
        return names == {(2, "q")} == {pair[::-1] for pair in asked.in_collision_other(manager, return_names=True)[1]}

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(300)))


def test_data_can_be_printed_and_managers_are_not_pickled() -> None:
    manager = CollisionManager()
    manager.add_object("a", CUBE)
    manager.add_object("b", CUBE, at(0.5))
    contact = manager.in_collision_internal(return_data=True)[1][0]
    assert repr(contact).startswith("<ContactData of a and b at [")
    manager.set_transform("b", at(2))
    assert repr(manager.min_distance_internal(return_data=True)[1]) == "<DistanceData of a and b, 1.0 apart>"
    with pytest.raises(TypeError, match="add its objects to a new one"):
        pickle.dumps(manager)


def test_messages_name_what_is_there() -> None:
    manager = CollisionManager()
    with pytest.raises(feeler.OptionError, match=r"give another feeler\.compat\.trimesh\.CollisionManager"):
        manager.in_collision_other(None)  # type: ignore[arg-type]
    flat = np.eye(4)
    flat[2, 2] = 0.0
    with pytest.raises(feeler.PoseError, match="flattens"):
        manager.add_object("a", CUBE, flat)
    far = np.diag([1e200, 1.0, 1.0, 1.0])
    with pytest.raises(feeler.PoseError, match=r"stretches 1e\+200 times as much .* at most 1e\+12 times"):
        manager.add_object("a", CUBE, far)
    for bad in ((np.zeros((3, 3)), [[0, 1, 2]]), (np.zeros((0, 3)), np.zeros((0, 3), int))):
        with pytest.raises(feeler.MeshError) as told:
            manager.add_object("a", bad)
            manager.in_collision_internal()
        assert "mock-up" not in str(told.value) and "mesh" in str(told.value)


def test_places_before_the_first_step_of_mujoco_are_told() -> None:
    vertices, faces = CUBE.vertices, CUBE.faces
    model = SimpleNamespace(
        geom_type=[7],
        geom_dataid=[0],
        mesh_vert=vertices,
        mesh_vertadr=[0],
        mesh_vertnum=[len(vertices)],
        mesh_face=faces,
        mesh_faceadr=[0],
        mesh_facenum=[len(faces)],
        geom=lambda _: SimpleNamespace(name="box"),
    )
    data = SimpleNamespace(geom_xmat=np.zeros((1, 9)), geom_xpos=np.zeros((1, 3)))
    with pytest.raises(feeler.PoseError, match=r"call mujoco\.mj_forward\(model, data\) first"):
        collision_manager(model, data)
    manager = collision_manager(model)
    with pytest.raises(feeler.PoseError, match="mj_forward"):
        move(manager, model, data)
    with pytest.raises(feeler.OptionError, match=r"give a feeler\.compat\.trimesh\.CollisionManager"):
        move(None, model, data)  # type: ignore[arg-type]


def ell() -> tuple[np.ndarray, np.ndarray]:
    """A closed L of three cubes, which is not convex."""
    border = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
    top = [[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]]
    sides = [[i, (i + 1) % 6, 6 + (i + 1) % 6] for i in range(6)] + [[i, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    corners = [(x, y, z) for z in (0, 1) for x, y in border]
    return np.array(corners, float), np.array(sides + top + [[a - 6, c - 6, b - 6] for a, b, c in top])


@pytest.mark.parametrize("far", [0.0, 1e5])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("turned", [False, True])
def test_flush_objects_that_are_not_convex_are_parted_by_their_depth(axis: int, far: float, turned: bool) -> None:
    standing = np.array([far, far, far]) + np.eye(3)[axis] * (2, 2, 1)[axis]
    manager = CollisionManager()
    for name, place in sorted({"lower": at(far, far, far), "upper": at(*standing)}.items(), reverse=turned):
        manager.add_object(name, ell(), place)
    contact = manager.in_collision_internal(return_data=True)[1][0]
    assert 0.0 < contact.depth < 1e-13 * max(far, 1.0)
    second = standing if contact.pair[1] == "upper" else np.full(3, far)
    manager.set_transform(contact.pair[1], at(*(second + contact.normal * contact.depth)))
    assert not manager.in_collision_internal()


@pytest.mark.parametrize("kinds", ["LL", "BL", "LB", "BB"])
@pytest.mark.parametrize("overlap", [0.0, 0.25])
def test_flush_objects_of_a_turned_assembly_are_parted_by_their_depth(kinds: str, overlap: float) -> None:
    """By rounding they touch, overlap or neither; and those that overlap are flush on another side."""
    rng = np.random.default_rng(6)
    block = box((2, 2, 1))
    shapes = {"L": ell(), "B": (block.vertices + np.array([1.0, 1.0, 0.5]), block.faces)}
    parted = 0
    for size in (1.0, 1e-3):
        for _ in range(12):
            turn = placed(rng, 1.0)
            second = turn @ at(*(np.array([0.0, 0.0, 1.0] if not overlap else [2.0 - overlap, 0.0, 0.0]) * size))
            manager = CollisionManager()
            for name, kind, pose in zip("ab", kinds, (turn, second), strict=True):
                manager.add_object(name, (shapes[kind][0] * size, shapes[kind][1]), pose)
            hit, contacts = manager.in_collision_internal(return_data=True)
            if not hit:
                continue
            contact = contacts[0]
            if overlap == 0.0 or kinds == "BB":
                assert 0.0 < contact.depth < (1.01 * overlap + 1e-8) * size
            if len({*kinds}) == 2:
                assert manager.min_distance_internal() == pytest.approx(-contact.depth, rel=1e-12)
            moved_one = {"a": turn, "b": second}[contact.pair[1]].copy()
            moved_one[:3, 3] += contact.normal * contact.depth
            manager.set_transform(contact.pair[1], moved_one)
            assert not manager.in_collision_internal()
            parted += 1
    assert parted > (16 if not overlap else 23)


def test_the_depth_of_what_slides_parts_it() -> None:
    """Two soups that a way along their faces frees at one length by rounding alone."""
    one = [[0, 0, 1], [0, -1, 1], [-1, 0, -1], [0, -1, 1], [1, 1, 1], [-1, -1, 0], [1, 0, 1], [1, 0, -1]]
    two = [[1, 0, -1], [0, 1, -1], [0, -1, 1], [1, -1, 1], [0, -1, -1], [0, -1, 0], [0, 1, 1], [1, -1, 0]]
    manager = CollisionManager()
    pose = {"one": np.diag([-1.0, 1.0, -1.0, 1.0]), "two": np.eye(4)}
    pose["one"][:3, 3] = 0, 1, 1
    pose["two"][:3] = [[1, 0, 0, -1], [0, 0, -1, -0.5], [0, 1, 0, 0]]
    manager.add_object("one", (np.array(one, float), np.array([[0, 3, 7], [6, 4, 2]])), pose["one"])
    faces = [[3, 5, 0], [5, 1, 4], [1, 0, 3], [0, 4, 1], [1, 0, 2], [6, 3, 0]]
    manager.add_object("two", (np.array(two, float), np.array(faces)), pose["two"])
    contact = manager.in_collision_internal(return_data=True)[1][0]
    away = pose[contact.pair[1]].copy()
    away[:3, 3] += contact.normal * contact.depth * (1 + 1e-9)
    manager.set_transform(contact.pair[1], away)
    assert not manager.in_collision_internal()


def test_depths_are_no_more_than_the_way_that_parts_the_boxes() -> None:
    """Of bodies that are not both convex; and the same whichever is asked for first."""
    rng = np.random.default_rng(5)
    doughnut, ring = torus(1.0, 0.3, 12, 8), annulus(0.5, 0.9, 0.4)
    longer, asked = 0, 0
    for _ in range(60):
        places = [placed(rng, 1.0), placed(rng, 1.0)]
        first, second = CollisionManager(threads=1), CollisionManager(threads=1)
        first.add_object("doughnut", doughnut, places[0])
        second.add_object("ring", ring, places[1])
        is_met, contacts = first.in_collision_other(second, return_data=True)
        if not is_met:
            continue
        asked += 1
        corners = [moved(doughnut, places[0])[0], moved(ring, places[1])[0]]
        lower, upper = ([getattr(each, name)(axis=0) for each in corners] for name in ("min", "max"))
        along = min((upper[0] - lower[1]).min(), (upper[1] - lower[0]).min())
        depth = contacts[0].depth
        assert 0 < depth <= along * (1 + 2e-6)
        longer += depth > along * (1 - 1e-9)
        away = places[1].copy()
        away[:3, 3] += contacts[0].normal * depth
        second.set_transform("ring", away)
        assert not first.in_collision_other(second)
        second.set_transform("ring", places[1])
        assert second.in_collision_other(first, return_data=True)[1][0].depth == pytest.approx(depth, rel=1e-9)
    assert asked > 20 and longer, "some are parted along an axis"
