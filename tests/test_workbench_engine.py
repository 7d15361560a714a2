"""The hand: stopped by contact, led by it, or let through; parts taken in it and put down."""

from __future__ import annotations

import numpy as np
import pytest
from workbench_scene import FACES, LEFT, PEG, PLATE, RIGHT, SHEET, Bench, at, corners, cube, stand

import feeler
from feeler.workbench.document import motion
from feeler.workbench.engine.engine import Engine
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.snapshot import Snapshot
from feeler.workbench.engine.world import World
from feeler.workbench.session.session import IDLE_TICK_S, LEAST_TICK_S

HALF = 0.03125  # of the cube


def settled(bench: Bench) -> Snapshot:
    """After half a second at rest: everything is found."""
    for _ in range(30):
        bench.tick()
    snapshot = bench.session.snapshot()
    assert snapshot is not None and snapshot.is_current
    return snapshot


@pytest.mark.parametrize("goal", [at(0.0, 0.0, -0.5), at(0.2, -0.1, -0.3)])
def test_stop_is_at_the_same_pose_at_four_speeds(goal: np.ndarray) -> None:
    poses = []
    for speed in (0.01, 0.1, 1.0, 10.0):
        bench = Bench(cube(), pose=at(0.0, 0.0, 0.1))
        bench.drag(goal, speed)
        snapshot = bench.session.snapshot()
        assert snapshot.blocked and snapshot.parts == [PLATE] and snapshot.is_free
        np.testing.assert_array_equal(snapshot.wish, goal)
        poses.append(bench.pose)
    for pose in poses:
        assert not feeler.Scene(bench.mockup).is_colliding(cube(), pose)
        np.testing.assert_allclose(pose, poses[0], rtol=0, atol=1e-6)
        assert 0 <= pose[2, 3] - HALF <= 1e-6


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_stop_with_a_turn_is_the_same_however_often_it_is_asked(turn: float) -> None:
    poses = []
    for pieces in (1, 7, 400):
        bench = Bench(cube(), pose=at(0.0, 0.0, 0.15, turn))
        for step in range(1, pieces + 1):
            bench.wish(at(0.35 * step / pieces, 0.0, 0.15, turn))
        poses.append(bench.pose)
        assert bench.session.snapshot().parts == [RIGHT]
    np.testing.assert_allclose(poses[1], poses[0], atol=1e-6)
    np.testing.assert_allclose(poses[2], poses[0], atol=1e-6)


@pytest.mark.parametrize("mode", ["stop", "glide"])
@pytest.mark.parametrize("speed", [0.5, 50.0])
def test_a_sheet_of_no_thickness_is_never_passed(mode: str, speed: float) -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.7), mode=mode)
    bench.drag(at(0.1, 0.0, 0.3), speed)
    for _ in range(60):
        bench.tick()
    assert 0.5 + HALF <= bench.pose[2, 3] < 0.5 + HALF + 1e-4
    assert bench.session.snapshot().parts == [SHEET]
    bench.drag(at(0.1, 0.0, 0.8), speed)
    for _ in range(60):
        bench.tick()
    np.testing.assert_allclose(bench.pose[:3, 3], [0.1, 0.0, 0.8], atol=2e-4)


def test_a_tool_that_rests_on_something_moves_away_and_along() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.1))
    bench.drag(at(0.0, 0.0, 0.0), 1.0)
    rest = bench.pose
    for _ in range(50):
        bench.wish(at(0.0, 0.0, -0.1))
    np.testing.assert_allclose(bench.pose, rest, atol=1e-6)
    along = rest.copy()
    along[0, 3] = 0.1
    bench.wish(along)
    np.testing.assert_array_equal(bench.pose, along)
    bench.wish(at(0.1, 0.0, 0.2))
    np.testing.assert_array_equal(bench.pose, at(0.1, 0.0, 0.2))


def test_a_tool_nearer_than_rounding_can_tell_moves_away_and_along_and_stays_free() -> None:
    pose = at(0.0, 0.0, np.nextafter(HALF, 1.0))
    bench = Bench(cube(), pose=pose)
    assert bench.session.snapshot().is_free and bench.session.snapshot().distance.value < 1e-16
    for goal in ([0.0, 0.0, -0.1], [0.05, 0.0, -0.1], [0.1, 0.0, pose[2, 3]]):
        bench.wish(at(*goal))
        assert bench.session.snapshot().is_free and bench.pose[2, 3] == pytest.approx(HALF, abs=1e-6)
    np.testing.assert_array_equal(bench.pose, bench.session.snapshot().wish)
    bench.wish(at(0.1, 0.0, 0.2))
    np.testing.assert_array_equal(bench.pose, at(0.1, 0.0, 0.2))


def test_a_tool_that_begins_in_collision_says_so_and_moves_out_but_not_deeper() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.02))
    snapshot = bench.session.snapshot()
    assert not snapshot.is_free and snapshot.depth == pytest.approx(HALF - 0.02, abs=1e-6) and snapshot.parts == [PLATE]
    bench.drag(at(0.0, 0.0, -0.2), 0.5)
    assert bench.pose[2, 3] == pytest.approx(0.02, abs=2e-5)
    # It is sunk: sideways it would tear through the plate, but for the play of its place.
    bench.drag(at(0.1, 0.0, 0.02), 0.5)
    assert 0.0 <= bench.pose[0, 3] < 0.02 * 2 * HALF * np.sqrt(3) + 1e-6
    bench.drag(at(0.0, 0.0, 0.1), 0.5)
    np.testing.assert_array_equal(bench.pose, at(0.0, 0.0, 0.1))
    bench.drag(at(0.0, 0.0, -0.2), 0.5)
    assert bench.pose[2, 3] == pytest.approx(HALF, abs=1e-6), "free once, the plate is as any other"


def test_pass_follows_the_hand_and_shows_what_is_cut() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.1), mode="pass")
    goal = at(0.3, 0.0, 0.0)
    bench.wish(goal)
    snapshot = bench.session.snapshot()
    np.testing.assert_array_equal(bench.pose, goal)
    expected = bench.scene.collide(cube(), goal)
    np.testing.assert_array_equal(snapshot.hits.pairs, expected.pairs)
    np.testing.assert_array_equal(snapshot.hits.kind_codes, expected.kind_codes)
    assert snapshot.parts == [PLATE, RIGHT] and not snapshot.blocked
    message = snapshot.message()
    places = snapshot.places
    np.testing.assert_array_equal(message.hits, np.sort(places[expected.mockup_triangles]))
    assert message.hit_count == len(expected.mockup_triangles) and message.hit_more == 0
    assert {event["part"] for event in bench.of_type("impact")} == {PLATE, RIGHT}


def test_the_depth_is_the_shortest_way_out_and_not_a_contact_planes() -> None:
    """A bar pushed through a sheet, but for its last 20 mm: its plane says 280 mm, back to where it came from."""
    bar = feeler.Tool(corners((-0.01, -0.01, -0.15), (0.01, 0.01, 0.15)), FACES, "bar")
    bench = Bench(bar, pose=at(0.0, 0.0, 0.8), mode="pass")
    bench.drag(at(0.0, 0.0, 0.37), 1.0)
    snapshot = settled(bench)
    assert snapshot.planes.gaps[0] == pytest.approx(-0.28) and snapshot.parts == [SHEET]
    assert snapshot.depth == pytest.approx(0.02, abs=1e-6) and snapshot.depth_kind == "bound"
    message = snapshot.message()
    assert message.depth == snapshot.depth and message.depth_kind == "bound"
    # Free again, it is in nothing at once; wholly inside a solid it meets nothing, and is in it.
    bench.wish(at(0.0, 0.0, 0.3))
    assert bench.session.snapshot().depth == 0.0
    bench = Bench(cube(0.03125), pose=at(0.0, 0.0, -0.03125), mode="pass")
    snapshot = settled(bench)
    assert not snapshot.hits and not snapshot.is_free and snapshot.depth == pytest.approx(0.046875, abs=1e-4)


def test_a_way_out_of_one_scene_that_leads_into_the_other_is_none() -> None:
    mockup = stand()
    scene, meshes, tool = feeler.Scene(mockup), PartTools(mockup), cube()
    pose = at(0.0, 0.0, HALF - 0.005)
    way = World(scene, meshes, {}).penetration(tool, pose, 0.002)
    assert way is not None and way.kind == "bound" and way.depth == pytest.approx(0.005, abs=1e-6)
    np.testing.assert_allclose(way.translation, [0.0, 0.0, 0.005], atol=1e-6)
    assert World(scene, meshes, {}).penetration(tool, at(0.0, 0.0, 0.1), 0.002) is None
    for above, kind in ((0.002, "estimate"), (0.006, "bound")):
        over = at(0.0, -0.28125, 2 * HALF - 0.005 + above)
        found = World(scene, meshes, {PEG: motion.row(over)}).penetration(tool, pose, 0.002)
        assert found is not None and found.kind == kind and found.depth == pytest.approx(0.005, abs=1e-6)
    # In both, it is the longer way.
    for deep, longer in ((0.008, 0.008), (0.003, 0.005)):
        within = World(scene, meshes, {PEG: motion.row(at(HALF + 0.03125 - deep, -0.28125, 0.0))})
        found = within.penetration(tool, pose, 0.002)
        assert found is not None and found.depth == pytest.approx(longer, abs=1e-6) and found.kind == "estimate"


def test_a_costly_depth_takes_a_small_share_of_the_time() -> None:
    bench = Bench()
    clock, calls = bench.clock, []

    class Slow(World):
        def penetration(self, *args: object) -> object:
            calls.append(clock.now)
            clock.now += 0.04
            return super().penetration(*args)  # type: ignore[arg-type]

    engine = Engine(clock=clock)
    engine.set(Slow(bench.scene, PartTools(bench.mockup), {}), cube(), at(0, 0, 0.01), mode="pass")
    begun = clock.now
    for step in range(1000):
        clock.now += 0.004
        engine.wish(at(0.0001 * step, 0, 0.01), step, "mouse")
        engine.tick()
    assert 2 < len(calls) <= 1 + 0.05 * (clock.now - begun) / 0.04
    for _ in range(300):
        clock.now += 0.004
        engine.tick()
    assert engine.snapshot().is_current and engine.snapshot().depth > 0.0


def test_what_it_meets_from_the_start_is_no_impact() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.0), mode="pass")
    bench.tick()
    assert not bench.of_type("impact")
    bench.wish(at(0.01, 0.0, 0.0))
    assert not bench.of_type("impact")


def test_hits_beyond_the_limit_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(cube(), pose=at(0.3, 0.0, 0.0), mode="pass")
    monkeypatch.setattr("feeler.workbench.engine.snapshot.MOST_HITS", 2)
    message = bench.session.snapshot().message()
    assert len(message.hits) == 2 and message.hit_count == 2 + message.hit_more > 2


def test_glide_slides_along_and_has_a_force() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.1), mode="glide")
    bench.drag(at(0.1, 0.1, 0.02), 0.2)
    for _ in range(60):
        bench.tick()
    snapshot = bench.session.snapshot()
    np.testing.assert_allclose(bench.pose[:2, 3], [0.1, 0.1], atol=2e-3)
    assert HALF <= bench.pose[2, 3] < HALF + 1e-4
    assert snapshot.force[2] > 1.0 and snapshot.blocked
    assert snapshot.shares().sum() == pytest.approx(np.linalg.norm(snapshot.force), rel=1e-3)
    bench.session.hand_gone()
    for _ in range(60):
        bench.tick()
    assert np.linalg.norm(bench.session.snapshot().force) < 0.1


def test_glide_has_force_from_the_beginning_where_it_begins_in_collision() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.02), mode="glide")
    for _ in range(10):
        bench.wish(at(0.0, 0.0, 0.0))
    assert bench.session.snapshot().force[2] > 1.0 and bench.pose[2, 3] == pytest.approx(0.02, abs=2e-5)
    bench.drag(at(0.0, 0.0, 0.1), 0.5)
    bench.drag(at(0.0, 0.0, 0.0), 0.5)
    for _ in range(60):
        bench.tick()
    assert bench.pose[2, 3] >= HALF and bench.session.snapshot().force[2] > 1.0


def test_an_impact_has_part_size_and_speed_and_comes_once() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.1))
    bench.drag(at(0.0, 0.0, 0.0), 0.5)
    (impact,) = bench.of_type("impact")
    assert impact["part"] == PLATE and impact["speed_m_per_s"] == pytest.approx(0.5, rel=0.05)
    assert impact["part_size_m"] == pytest.approx(np.linalg.norm([1.0, 1.0, 0.0625]))
    for _ in range(5):
        bench.wish(at(0.0, 0.0, -0.1))
    assert len(bench.of_type("impact")) == 1
    bench.wish(at(0.0, 0.0, 0.1))
    bench.drag(at(0.0, 0.0, 0.0), 0.5)
    assert len(bench.of_type("impact")) == 2


def test_the_newest_wish_wins_and_none_is_passed_over() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.1))
    bench.session.wish(at(0.0, 0.0, -0.3), 1, "mouse")
    bench.session.wish(at(0.2, 0.2, 0.1), 2, "mouse")
    bench.tick()
    np.testing.assert_array_equal(bench.pose, at(0.2, 0.2, 0.1))
    assert bench.session.snapshot().pose_seq == 2


def test_what_costs_more_than_the_budget_comes_at_a_lower_rate() -> None:
    bench = Bench(cube())
    clock = bench.clock
    calls: list[float] = []

    class Slow(World):
        def clearance(self, *args: object) -> object:
            calls.append(clock.now)
            clock.now += 0.05
            return super().clearance(*args)  # type: ignore[arg-type]

    engine = Engine(clock=clock)
    engine.set(Slow(bench.scene, PartTools(bench.mockup), {}), cube(), at(0, 0, 0.2), mode="pass")
    for step in range(100):
        clock.now += 0.01
        engine.wish(at(0.001 * step, 0, 0.2), step, "mouse")
        assert engine.tick(), "every wish is answered"
        np.testing.assert_array_equal(engine.snapshot().pose, at(0.001 * step, 0, 0.2))
    assert 2 <= len(calls) <= 12
    for _ in range(100):
        clock.now += 0.01
        engine.tick()
    assert engine.snapshot().is_current, "a hand at rest has all of it"


def test_what_is_costly_is_found_between_wishes_and_no_later_than_it_is_due() -> None:
    """Wishes at 60 Hz, rounds at 250 Hz: no wish waits for all of it, and no answer is older than its period."""
    bench = Bench(cube())
    clock = bench.clock
    found: dict[str, list[float]] = {"contacts": [], "distance": [], "clearance": [], "collide": []}

    class Timed(World):
        pass

    for name, cost in (("contacts", 0.0002), ("distance", 0.0001), ("clearance", 0.0015), ("collide", 0.0002)):

        def slow(self: World, *args: object, name: str = name, cost: float = cost) -> object:
            clock.now += cost
            found[name].append(clock.now)
            return getattr(World, name)(self, *args)

        setattr(Timed, name, slow)
    engine = Engine(clock=clock)
    engine.set(Timed(bench.scene, PartTools(bench.mockup), {}), cube(), at(0, 0, 0.2), mode="pass")
    rounds = []
    for step in range(1000):
        if step % 4 == 0:
            engine.wish(at(0.0001 * step, 0, 0.2), step, "mouse")
        begun = clock.now
        engine.tick()
        rounds.append(clock.now - begun)
        clock.now = begun + 0.004
    # The costly one has rounds of its own, and the rest fits into the others.
    assert {round(each, 4) for each in rounds[100:] if each > 0.0006} == {0.0015}
    for name, longest in (("contacts", 0.016), ("distance", 0.016), ("clearance", 0.1)):
        times = np.array(found[name][10:])
        assert len(times) > 20 and np.diff(times).max() < longest + 0.001, name


def test_the_rate_is_how_many_rounds_a_second_there_are() -> None:
    """Rounds in pairs, one short and one long: the mean of their rates would be 571 Hz."""
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2))
    for step in range(200):
        bench.wish(at(0.0001 * step, 0.0, 0.2), 0.001 if step % 2 else 0.007)
    assert bench.session.snapshot().rate_hz == pytest.approx(250.0, rel=0.06)


def test_no_two_rounds_begin_within_the_least_time_however_long_one_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that holds the engine lets a round begin late; the one after begins no sooner for it."""
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2))
    session, clock = bench.session, bench.clock
    begun: list[float] = []
    tick = session.engine.tick

    class Wake:
        """Somebody wishes at once, always."""

        def wait(self, timeout: float) -> None:
            pass

        def clear(self) -> None:
            pass

    def sleep(seconds: float) -> None:
        clock.now += seconds

    def waited_for() -> bool:
        clock.now += 0.03 if len(begun) % 3 == 1 else 0.0001
        begun.append(clock.now)
        session._is_closed = len(begun) == 30
        return tick()

    monkeypatch.setattr("feeler.workbench.session.session.time.sleep", sleep)
    monkeypatch.setattr(session, "_wake", Wake())
    monkeypatch.setattr(session.engine, "tick", waited_for)
    session._loop()
    assert len(begun) == 30 and np.diff(begun).min() >= LEAST_TICK_S - 1e-9


@pytest.mark.parametrize("mode", ["stop", "pass", "glide"])
def test_an_engine_with_nothing_to_do_waits_long_and_wakes_at_once(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2), mode=mode)
    session, engine = bench.session, bench.session.engine
    waits: list[float] = []

    class Wake:
        def wait(self, timeout: float) -> None:
            bench.clock.now += timeout
            waits.append(timeout)
            session._is_closed = len(waits) == 600

        def clear(self) -> None:
            pass

        def set(self) -> None:
            pass

    monkeypatch.setattr("feeler.workbench.session.session.time.sleep", lambda _seconds: None)
    monkeypatch.setattr(session, "_wake", Wake())
    bench.wish(at(0.0, 0.0, 0.19))
    bench.wish(at(0.0, 0.0, 0.2))
    session._loop()
    assert waits[0] == LEAST_TICK_S, "results with lower rates are due soon"
    assert waits[-1] == IDLE_TICK_S and engine.is_idle
    assert session.snapshot().is_current, "nothing is left to compute"
    rate = session.snapshot().rate_hz
    session.wish(at(0.0, 0.0, 0.25), 1, "mouse")
    assert not engine.is_idle, "a wish is due at once"
    bench.tick(LEAST_TICK_S)
    assert engine.pose[2, 3] > 0.2 and session.snapshot().rate_hz >= 0.9 * rate
    for _ in range(1000):
        bench.tick(LEAST_TICK_S)
    assert engine.is_idle and engine.pose[2, 3] == pytest.approx(0.25, abs=1e-4)
    engine.play([at(0.0, 0.0, 0.3)], lambda: None)
    assert not engine.is_idle, "a way that is played goes on"


def test_a_hand_at_rest_makes_no_news() -> None:
    bench = Bench(cube())
    for _ in range(30):
        bench.tick()
    number = bench.session.snapshot().number
    for _ in range(30):
        bench.tick()
    assert bench.session.snapshot().number == number


def test_a_gripped_part_leaves_moves_is_put_down_and_queried_where_it_lies() -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2))
    bench.command("grip", parts="stand/peg")
    assert bench.document["gripped"] == [PEG] and bench.document["held_version"] > 0
    # It stands on the plate: down it may not, up it may.
    bench.drag(at(0.0, 0.0, 0.1), 0.5)
    assert bench.pose[2, 3] == pytest.approx(0.2, abs=1e-6)
    bench.drag(at(0.0, 0.0, 0.3), 0.5)
    bench.drag(at(0.1, 0.0, 0.3), 0.5)
    bench.command("release")
    document = bench.document
    assert document["gripped"] == [] and document["out"] == []
    placed = np.array(document["moved"][str(PEG)]).reshape(4, 4)
    np.testing.assert_allclose(placed, at(0.1, 0.0, 0.1), atol=1e-12)
    (line,) = document["sequence"]
    assert line["parts"] == [PEG] and line["name"] == "peg" and line["tool"] == "cube" and line["touched"] == []
    assert len(line["way"]) > 20
    np.testing.assert_allclose(line["way"][0], at(0.0, 0.0, 0.2).ravel(), atol=1e-6)
    # The peg is now at x 0.06875 to 0.13125, y 0.25 to 0.3125, z 0.1 to 0.225: it stops the hand there.
    bench.command("place", pose=at(-0.3, 0.28, 0.15).ravel().tolist())
    bench.drag(at(0.3, 0.28, 0.15), 1.0)
    assert bench.pose[0, 3] == pytest.approx(0.06875 - HALF, abs=1e-6)
    snapshot = bench.session.snapshot()
    assert snapshot.parts == [PEG] and snapshot.distance.part == PEG
    bench.drag(at(-0.3, 0.28, 0.15), 1.0)
    bench.command("put_back", parts=[PEG])
    assert bench.document["moved"] == {}
    bench.drag(at(-0.3, 0.28, 0.05), 1.0)
    bench.drag(at(0.3, 0.28, 0.05), 1.0)
    assert bench.pose[0, 3] == pytest.approx(-0.03125 - HALF, abs=1e-6)


def test_answers_of_both_scenes_are_merged_and_none_is_lost() -> None:
    mockup = Bench().mockup
    scene, meshes = feeler.Scene(mockup), PartTools(mockup)
    shift = at(0.1, -0.2, 0.05)
    world = World(scene, meshes, {PEG: motion.row(shift), LEFT: motion.row(np.eye(4))})
    vertices = mockup.vertices.copy()
    vertices[24:32] += shift[:3, 3]
    whole = feeler.Scene(feeler.Mockup(vertices, mockup.faces, mockup.part_of_face, mockup.part_names))
    tool = cube(0.125)
    rng = np.random.default_rng(1)
    for _ in range(100):
        pose, other = (at(*rng.uniform([-0.5, -0.2, 0], [0.5, 0.4, 0.3]), rng.uniform(0, 3)) for _ in range(2))
        hits, expected = world.collide(tool, pose), whole.collide(tool, pose)
        np.testing.assert_array_equal(hits.pairs, expected.pairs)
        np.testing.assert_array_equal(hits.kind_codes, expected.kind_codes)
        assert hits.parts.tolist() == expected.parts.tolist() and world.is_colliding(tool, pose) == bool(expected)
        near, distance = world.distance(tool, pose, np.inf), whole.distance(tool, pose)
        assert near.value == distance.value and (near.value == 0 or near.part == distance.part)
        rows, clearance = world.clearance(tool, pose, 0.1), whole.clearance(tool, pose, 0.1)
        np.testing.assert_array_equal(rows.distances, clearance.distances)
        assert sorted(rows.parts.tolist()) == sorted(clearance.parts.tolist())
        impact, cast = world.cast(tool, pose, other, 1e-6), whole.cast(tool, pose, other)
        assert (impact is None) == (cast is None)
        if cast is not None:
            assert impact.fraction == pytest.approx(cast.fraction, abs=1e-5)
        planes, contacts = world.contacts(tool, pose, 0.01), whole.contacts(tool, pose, 0.01)
        np.testing.assert_allclose(planes.gaps, contacts.gaps, atol=1e-9)
    # Two scenes that number their surfaces alike are told apart.
    alone = World(scene, meshes, {PLATE: motion.row(np.eye(4))})
    own = alone.put_down[PLATE].contacts(tool, at(0.0, 0.0, 0.05), 0.01)
    planes = alone.contacts(tool, at(0.0, 0.0, 0.05), 0.01)
    assert len(own) == len(planes) and not set(planes.ids.tolist()) & set(own.ids.tolist())


def test_a_part_alone_is_gripped_without_a_tool_and_goes_out_of_the_mockup() -> None:
    bench = Bench(None)
    bench.command("grip", parts=[PEG])
    np.testing.assert_allclose(bench.pose[:3, 3], [0.0, 0.28125, 0.0625], atol=1e-3)
    start = bench.pose
    for goal in ([0.0, 0.28, 0.3], [0.0, 0.8, 0.3], [0.0, 0.8, 1.0]):
        bench.drag(at(*goal), 1.0)
    np.testing.assert_array_equal(bench.pose, at(0.0, 0.8, 1.0))
    bench.command("release")
    assert bench.document["out"] == [PEG]
    bench.command("grip", parts=[PEG])
    assert bench.document["out"] == [] and bench.document["moved"] == {}
    bench.command("undo")
    (line,) = bench.document["sequence"]
    np.testing.assert_allclose(line["way"][0], start.ravel(), atol=1e-9)
    assert line["tool"] is None and line["least_clearance"] is None, "nothing was within reach but the seat"


@pytest.mark.parametrize("mode", ["stop", "glide"])
def test_a_part_that_was_put_down_is_never_passed(mode: str) -> None:
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.2))
    bench.command("grip", parts=[PEG])
    bench.drag(at(0.0, 0.0, 0.3), 1.0)
    bench.drag(at(0.1, 0.0, 0.3), 1.0)
    bench.command("release")
    bench.drag(at(-0.3, 0.28, 0.15), 1.0)
    bench.command("set_mode", mode=mode)
    bench.drag(at(0.3, 0.28, 0.15), 1.0)
    for _ in range(60):
        bench.tick()
    snapshot = bench.session.snapshot()
    assert bench.pose[0, 3] == pytest.approx(0.06875 - HALF, abs=1e-4) and snapshot.is_free
    assert np.any(snapshot.force) == (mode == "glide") and snapshot.parts == [PEG]
    bench.drag(at(-0.3, 0.28, 0.15), 1.0)
    for _ in range(60):
        bench.tick()
    assert bench.pose[0, 3] == pytest.approx(-0.3, abs=1e-3)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_glide_slides_along_a_part_that_was_put_down_as_in_its_place(turn: float) -> None:
    """Pushed 4 mm into the left post's side and 60 mm along it: in place, and put down elsewhere, turned."""
    moved = at(0.0625, -0.3, 0.0625, turn)
    found = []
    for place in (np.eye(4), moved):
        bench = Bench(cube(), pose=at(-0.2, 0.0, 0.125))
        if place is moved:
            bench.command("grip", parts=[LEFT])
            bench.command("place", pose=motion.row(place @ bench.pose))
            bench.command("release")
            assert list(bench.document["moved"]) == [str(LEFT)]
        bench.command("set_mode", mode="glide")
        bench.drag(place @ at(-0.25 + HALF - 0.004, 0.0, 0.125), 0.2)
        bench.drag(place @ at(-0.25 + HALF - 0.004, 0.03, 0.18), 0.2)
        for _ in range(60):
            bench.tick()
        snapshot = bench.session.snapshot()
        assert snapshot.is_free and snapshot.blocked and snapshot.parts == [LEFT]
        found.append((np.linalg.inv(place) @ bench.pose, place[:3, :3].T @ snapshot.force))
    (pose, force), (other_pose, other_force) = found
    np.testing.assert_allclose(pose[:3, 3], [-0.25 + HALF + 2e-5, 0.03, 0.18], atol=1e-4)
    assert force[0] > 3.0
    np.testing.assert_allclose(other_pose, pose, atol=1e-6)
    np.testing.assert_allclose(other_force, force, atol=1e-3)


def test_the_least_clearance_is_that_of_the_way() -> None:
    bench = Bench(cube(), pose=at(0.0, -0.2, 0.3))
    bench.command("grip", parts=[PEG])
    # The peg, seated on the plate, passes the right post at 2 cm; the cube stays farther away.
    bench.drag(at(0.0, -0.2, 0.31), 1.0)
    bench.drag(at(0.25 - 0.03125 - 0.02, -0.2, 0.31), 1.0)
    bench.drag(at(0.25 - 0.03125 - 0.02, -0.2 - 0.28, 0.31), 1.0)
    bench.command("release")
    (line,) = bench.document["sequence"]
    assert line["least_clearance"] == pytest.approx(0.02, abs=1e-9)


def test_what_stopped_a_carried_part_is_touched() -> None:
    bench = Bench(None)
    bench.command("grip", parts=[PEG])
    bench.drag(at(0.0, 0.28, 0.1), 1.0)
    bench.drag(at(0.0, 0.28, 0.9), 1.0)
    bench.command("release")
    (line,) = bench.document["sequence"]
    assert line["touched"] == ["sheet"]


def test_a_release_that_moved_nothing_is_no_line() -> None:
    bench = Bench(cube())
    bench.command("grip", parts=[PEG])
    bench.command("release")
    assert bench.document["sequence"] == [] and list(bench.document["moved"]) == [str(PEG)]


def test_a_sequence_line_is_replayed_from_home_to_where_it_went() -> None:
    bench = Bench(None)
    bench.command("grip", parts=[PEG])
    bench.drag(at(0.0, 0.28, 0.3), 1.0)
    bench.drag(at(0.2, 0.28, 0.3), 1.0)
    bench.command("release")
    lines, moved = bench.document["sequence"], bench.document["moved"]
    bench.command("put_back", parts=[PEG])
    bench.command("sequence_replay", id=lines[0]["id"])
    assert bench.document["gripped"] == [PEG]
    for _ in range(600):
        bench.tick()
    assert bench.document["gripped"] == [] and bench.document["sequence"] == lines
    np.testing.assert_allclose(bench.document["moved"][str(PEG)], moved[str(PEG)], atol=1e-6)
    bench.command("undo")
    assert bench.document["gripped"] == [] and bench.document["moved"] == {}, "one step, as it was one command"
    bench.command("redo")
    np.testing.assert_allclose(bench.document["moved"][str(PEG)], moved[str(PEG)], atol=1e-6)


def test_what_was_done_during_a_replay_is_undone_alone() -> None:
    bench = Bench(None)
    bench.command("grip", parts=[PEG])
    bench.drag(at(0.0, 0.28, 0.3), 1.0)
    bench.command("release")
    bench.command("sequence_replay", id=bench.document["sequence"][0]["id"])
    bench.command("hide", parts=[LEFT])
    for _ in range(600):
        bench.tick()
    assert bench.document["gripped"] == []
    bench.command("undo")
    assert bench.document["hidden"] == [LEFT] and bench.document["gripped"] == [PEG]


def test_parts_of_a_mockup_in_any_order_with_defects_are_found() -> None:
    whole = stand()
    rng = np.random.default_rng(2)
    order = rng.permutation(whole.triangle_count)
    faces = np.concatenate([whole.faces[order], [[0, 1, 999]]])
    owners = np.concatenate([whole.part_of_face[order], [PEG]])
    mockup = feeler.Mockup(whole.vertices, faces, owners, whole.part_names, part_paths=whole.part_paths)
    meshes = PartTools(mockup)
    for part in range(5):
        tool, ids = meshes.of(part)
        expected = feeler.Tool.of_parts(mockup, [part])
        np.testing.assert_array_equal(ids, np.flatnonzero(owners == part))
        np.testing.assert_array_equal(tool.vertices, expected.vertices)
        np.testing.assert_array_equal(tool.faces, expected.faces)
        assert (tool.name, tool.part_paths) == (expected.name, expected.part_paths)
    # Put down where it was, it has the triangles that it had.
    there, scene = World(feeler.Scene(mockup), meshes, {PEG: motion.row(np.eye(4))}), feeler.Scene(mockup)
    pose = at(0.0, 0.28, 0.05)
    np.testing.assert_array_equal(there.collide(cube(), pose).pairs, scene.collide(cube(), pose).pairs)
    assert PEG in there.collide(cube(), pose).parts
    gap, expected_gap = (each.distance(cube(), at(0.0, 0.28, 0.4), 1.0) for each in (there, scene))
    assert (gap.part, owners[gap.mockup_triangle]) == (expected_gap.part, gap.part)
