"""Scenes with moved parts answer as scenes of the moved mock-up that are indexed anew."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler
from feeler.errors import OptionError, PoseError

STORAGES = ("blocks", "dense", "hashed")


def ball(rng: np.random.Generator, size: float, rows: int = 5) -> tuple[Any, Any]:
    """A closed bumpy surface around the origin."""
    columns = 7
    angles = np.linspace(0.3, np.pi - 0.3, rows)
    ring = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    points = [[np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)] for a in angles for b in ring]
    points = np.array([*points, [0, 0, 1], [0, 0, -1]]) * rng.uniform(0.7, 1.0, (rows * columns + 2, 1)) * size
    faces = []
    for i in range(columns):
        j = (i + 1) % columns
        for row in range(rows - 1):
            a, b = row * columns, (row + 1) * columns
            faces += [[a + i, b + i, b + j], [a + i, b + j, a + j]]
        faces += [[rows * columns, i, j], [rows * columns + 1, (rows - 1) * columns + j, (rows - 1) * columns + i]]
    return points, np.array(faces)


def assembly(rng: np.random.Generator, parts: int = 14, shared: bool = False) -> feeler.Mockup:
    """Balls at random places, one of them open and one without triangles."""
    vertices, faces, part_of_face, count = [], [], [], 0
    for part in range(parts):
        if part == 3:
            continue  # it has a name, but no triangles
        points, own = ball(rng, rng.uniform(0.05, 0.25))
        if part == 5:
            own = own[:-9]
        vertices.append(points + rng.uniform(-0.5, 0.5, 3))
        faces.append(own + count)
        part_of_face.append(np.full(len(own), part))
        count += len(points)
    joined = np.concatenate(faces)
    if shared:  # one triangle of part 0 hangs on a corner of part 1
        joined[0, 0] = joined[len(faces[0]), 0]
    names = [f"part_{part}" for part in range(parts)]
    return feeler.Mockup(np.concatenate(vertices), joined, np.concatenate(part_of_face), names)


def pose(rng: np.random.Generator, far: float = 0.3) -> Any:
    """A random pose."""
    made = np.eye(4)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    made[:3, :3] = turn * np.sign(np.linalg.det(turn))
    made[:3, 3] = rng.uniform(-far, far, 3)
    return made


def anew(scene: feeler.Scene) -> feeler.Scene:
    """A scene of the same mock-up, indexed anew."""
    m = scene.mockup
    made = feeler.Scene(
        feeler.Mockup(np.array(m.vertices), np.array(m.faces), m.part_of_face, m.part_names),
        scene.voxel_size,
        scene.storage,
        scene.hashing,
    )
    return made if scene.part_mask.all() else made.only(scene.part_mask)


def moved_at_random(rng: np.random.Generator, scene: feeler.Scene, share: float = 0.3) -> feeler.Scene:
    """Some parts at two poses."""
    parts = np.flatnonzero(rng.random(scene.mockup.part_count) < share).tolist() or [0]
    half = len(parts) // 2
    given = {tuple(parts[:half]): pose(rng), tuple(parts[half:]): pose(rng)}
    return scene.moved({key: value for key, value in given.items() if key})


def assert_same(one: feeler.Scene, other: feeler.Scene, tool: feeler.Tool, rng: np.random.Generator) -> int:
    """Every query answers alike; returns the number of pairs that met."""
    met = 0
    for _ in range(6):
        at, to = pose(rng, 0.5), pose(rng, 0.5)
        hit, expected = one.collide(tool, at), other.collide(tool, at)
        assert np.array_equal(hit.pairs, expected.pairs)
        assert np.array_equal(hit.kinds, expected.kinds)
        met += len(hit.pairs)
        assert one.is_colliding(tool, at) == other.is_colliding(tool, at)
        assert one.is_colliding(tool, at, touching="free") == other.is_colliding(tool, at, touching="free")
        assert one.is_free(tool, at) == other.is_free(tool, at)
        inside, wanted = one.containment(tool, at), other.containment(tool, at)
        assert repr(inside) == repr(wanted)
        near, wanted_near = one.clearance(tool, at, 0.2), other.clearance(tool, at, 0.2)
        apart = near.distances > 0  # those that meet are in any order
        assert sorted(near.parts[~apart].tolist()) == sorted(wanted_near.parts[~apart].tolist())
        assert np.array_equal(near.parts[apart], wanted_near.parts[apart])
        assert np.array_equal(near.distances, wanted_near.distances)
        assert one.distance(tool, at).value == other.distance(tool, at).value
        nearest = [(each.value, each.part) for each in one.nearest(tool, at, 4) if each.value > 0]
        assert nearest == [(each.value, each.part) for each in other.nearest(tool, at, 4) if each.value > 0]
        cast, wanted_cast = one.cast(tool, at, to), other.cast(tool, at, to)
        assert (cast is None) == (wanted_cast is None)
        if cast is not None and wanted_cast is not None:
            assert abs(cast.fraction - wanted_cast.fraction) <= 1e-5
        path, wanted_path = (each.check_path(tool, [at, to, at], inside=True) for each in (one, other))
        assert path.is_free == wanted_path.is_free
        planes, wanted_planes = one.contacts(tool, at, 0.01), other.contacts(tool, at, 0.01)
        assert len(planes) == len(wanted_planes)
        deep, wanted_deep = one.depth(tool, at), other.depth(tool, at)
        assert np.array_equal(deep.parts, wanted_deep.parts)
        assert np.allclose(deep.depths, wanted_deep.depths, rtol=1e-9, atol=1e-12)
        origins, ways = rng.uniform(-1, 1, (20, 3)), rng.normal(size=(20, 3))
        rays, wanted_rays = one.rays(origins, ways), other.rays(origins, ways)
        assert np.array_equal(rays.triangles, wanted_rays.triangles)
        point, normal = rng.uniform(-0.3, 0.3, 3), rng.normal(size=3)
        cut, wanted_cut = one.section(point, normal), other.section(point, normal)
        assert np.array_equal(cut.triangles, wanted_cut.triangles)
        assert np.array_equal(cut.segments, wanted_cut.segments)
    return met


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("shared", [False, True])
def test_each_query_answers_as_in_a_scene_indexed_anew(storage: Any, shared: bool) -> None:
    rng = np.random.default_rng([STORAGES.index(storage), shared])
    met = 0
    for _ in range(4):
        scene = feeler.Scene(assembly(rng, shared=shared), storage=storage)
        tool = feeler.Tool(*ball(rng, 0.2))
        moved = moved_at_random(rng, scene)
        moved.validate()
        met += assert_same(moved, anew(moved), tool, rng)
        # Again, from the moved scene: poses count from where the parts are modelled.
        again = moved_at_random(rng, moved)
        assert_same(again, anew(again), tool, rng)
        some = moved.only([0, 1, 2, 5, 7, 9])
        assert_same(some, anew(some), tool, rng)
        fewer = scene.only([0, 1, 2, 5, 7, 9]).moved({(1, 4): pose(rng)})
        assert_same(fewer, anew(fewer), tool, rng)
    assert met > 100


def test_vertices_move_and_all_else_stays() -> None:
    rng = np.random.default_rng(3)
    mockup = assembly(rng)
    scene = feeler.Scene(mockup)
    up, turned = pose(rng), pose(rng)
    moved = scene.moved({"part_1": up, ("part_5", 6): turned})
    m = moved.mockup
    assert m.part_names == mockup.part_names
    assert np.array_equal(m.faces, mockup.faces)
    assert np.array_equal(m.part_of_face, mockup.part_of_face)
    parts = mockup.part_of_face
    for part, at in ((1, up), (5, turned), (6, turned), (0, np.eye(4))):
        own = np.unique(mockup.faces[parts == part])
        expected = mockup.vertices[own] @ at[:3, :3].T + at[:3, 3]
        assert np.allclose(m.vertices[own], expected, rtol=0, atol=1e-15)
    fresh = anew(moved).mockup
    assert np.array_equal(m.part_bounds, fresh.part_bounds)
    assert np.array_equal(m.bounds, fresh.bounds)
    assert m.defects == fresh.defects
    assert repr(list(m.parts)) == repr(list(fresh.parts))


def test_memory_that_one_scene_leaves_serves_the_next() -> None:
    rng = np.random.default_rng(4)
    scene = feeler.Scene(assembly(rng))
    rest = np.array(scene.mockup.vertices)
    for _ in range(5):
        moved = moved_at_random(rng, scene)
        stays = moved.mockup.part_bounds.reshape(-1, 6) == scene.mockup.part_bounds.reshape(-1, 6)
        used = np.unique(scene.mockup.faces[stays.all(axis=1)[scene.mockup.part_of_face]])
        assert np.array_equal(moved.mockup.vertices[used], rest[used])
        kept = np.array(moved.mockup.vertices)
        view = moved.mockup.vertices
        del moved
        moved_at_random(rng, scene)
        assert np.array_equal(view, kept)  # a view keeps its memory
        assert np.array_equal(scene.mockup.vertices, rest)


def test_no_move_gives_the_scene_itself_and_back() -> None:
    rng = np.random.default_rng(5)
    scene = feeler.Scene(assembly(rng))
    assert scene.moved({}) is scene
    assert scene.moved({"part_1": np.eye(4)}) is scene
    moved = scene.moved({"part_1": pose(rng)})
    assert moved.moved({}).mockup is scene.mockup
    assert moved.without("part_2").moved({}).part_mask.tolist() == scene.without("part_2").part_mask.tolist()
    empty = scene.moved({"part_3": pose(rng)})  # without triangles
    assert_same(empty, scene, feeler.Tool(*ball(rng, 0.2)), rng)


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_all_parts_and_far_ones(far: float) -> None:
    rng = np.random.default_rng(6)
    scene = feeler.Scene(assembly(rng))
    tool = feeler.Tool(*ball(rng, 0.2))
    away = np.eye(4)
    away[0, 3] = far
    turned = away @ pose(rng)
    one = scene.moved({2: turned})
    assert_same(one, anew(one), tool, rng)
    there = turned.copy()
    there[:3, 3] = one.mockup.part_bounds[4:6].mean(axis=0)
    assert len(one.collide(tool, there).pairs) == len(anew(one).collide(tool, there).pairs)
    assert one.distance(tool, there).part == 2
    everything = scene.moved({tuple(range(14)): turned})
    assert_same(everything, anew(everything), tool, rng)


def test_ignored_pairs_removals_and_clashes() -> None:
    rng = np.random.default_rng(7)
    scene = feeler.Scene(assembly(rng))
    moved = scene.moved({(1, 4, 8): pose(rng)})
    other = anew(moved)
    tool = feeler.Tool(*ball(rng, 0.3))
    for _ in range(5):
        at = pose(rng, 0.3)
        ignore = [("*", "part_4"), ("*", "part_7")]
        assert np.array_equal(
            moved.collide(tool, at, ignore=ignore).pairs, other.collide(tool, at, ignore=ignore).pairs
        )
    one, anew_of = (feeler.clash(each.mockup, scene=each, threads=1) for each in (moved, other))
    assert len(one) == len(anew_of) > 2
    order = [np.lexsort((each.parts_b, each.parts_a)) for each in (one, anew_of)]
    for name in ("parts_a", "parts_b"):
        assert np.array_equal(getattr(one, name)[order[0]], getattr(anew_of, name)[order[1]])
    assert np.array_equal(one.columns.verdict[order[0]], anew_of.columns.verdict[order[1]])
    free = [feeler.removal(each, 6, rounds=2, threads=1) for each in (moved, other)]
    assert free[0].is_found == free[1].is_found


def test_pickled_and_saved(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    scene = feeler.Scene(assembly(rng)).without("part_2")
    moved, place = scene.moved({(1, 4, 8): pose(rng)}), pose(rng)
    tool = feeler.Tool(*ball(rng, 0.3))
    copy = pickle.loads(pickle.dumps(moved))
    assert copy.part_mask.tolist() == moved.part_mask.tolist()
    assert_same(moved, copy, tool, rng)
    # It knows where its parts are modelled, and what was set of its mock-up.
    assert_same(moved.moved({5: place}), copy.moved({5: place}), tool, rng)
    assert np.array_equal(copy.moved({}).mockup.vertices, scene.mockup.vertices)
    moved.mockup.part_colours = np.full((moved.mockup.part_count, 3), 0.5)
    assert pickle.loads(pickle.dumps(moved)).mockup.part_colours.tolist() == moved.mockup.part_colours.tolist()
    moved.save(tmp_path / "moved.feeler")
    opened = feeler.open_scene(tmp_path / "moved.feeler")
    opened.validate()
    assert opened.part_mask.tolist() == moved.part_mask.tolist()
    assert_same(moved, opened, tool, rng)
    # The mock-up of a file moves, too.
    again = opened.moved({(0, 5): pose(rng)})
    assert_same(again, anew(again), tool, rng)


def test_errors() -> None:
    rng = np.random.default_rng(9)
    scene = feeler.Scene(assembly(rng))
    with pytest.raises(OptionError, match="two poses"):
        scene.moved({"part_1": np.eye(4), (1, 2): np.eye(4)})
    with pytest.raises(OptionError, match="no part"):
        scene.moved({"door": np.eye(4)})
    with pytest.raises(OptionError, match="give a dict"):
        scene.moved([np.eye(4)])  # type: ignore[call-overload]
    with pytest.raises(PoseError):
        scene.moved({"part_1": 2 * np.eye(4)})
