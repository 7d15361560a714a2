"""What has to go before a part comes out."""

from __future__ import annotations

import copy
import importlib
import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapes import at, box, cube, inverted, joined, mockup_of, open_chest

import feeler
from feeler.errors import OptionError
from feeler.io.film import moments
from feeler.plan import question
from feeler.plan.as_glb import in_steps

# A chest, a lid that lies inside the rim of it, a cover on the rim, and a thing in the chest; metres.
CHEST = {
    "chest": open_chest(),
    "lid": box((0.046875, 0.046875, 0.25), (0.453125, 0.453125, 0.28125)),
    "cover": box((-0.25, -0.25, 0.375), (0.75, 0.75, 0.4375)),
    "thing": box((0.125, 0.125, 0.0625), (0.25, 0.25, 0.1875)),
}


@pytest.fixture(scope="module")
def chest() -> feeler.Scene:
    return feeler.Scene(mockup_of(CHEST), threads=1)


def names(scene: feeler.Scene, parts: tuple[int, ...]) -> list[str]:
    return [scene.mockup.part_names[part] for part in parts]


def test_what_is_over_it_goes_first(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest, "thing", seconds=10.0, threads=1, keep="chest")
    assert order.is_found and names(chest, order.parts) == ["cover", "lid", "thing"]
    # Each way is free of all that is still there.
    gone: list[int] = []
    for step in order:
        scene = chest.without(gone) if gone else chest
        tool = feeler.Tool.of_parts(chest.mockup, list(step.parts))
        check = scene.without(list(step.parts)).check_path(tool, step.removal.poses, touching="free")
        assert step.removal.is_found and check.is_free
        gone += step.parts


def test_what_comes_out_by_itself_is_one_step(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest, "cover", threads=1)
    assert order.is_found and len(order) == 1 and names(chest, order.parts) == ["cover"]


@pytest.mark.parametrize("noise", [0.0, 1e-10])
def test_a_flush_stack_comes_out_of_its_tray_in_any_pose(noise: float) -> None:
    # Three blocks one before the other, open to +y; what rounding makes of their faces is deeper than none of them.
    lengths = [0.0, 0.0395, 0.0668, 0.08]
    walls = [((-0.005, 0.0), (-0.005, 0.085), (-0.005, 0.065)), ((0.1, 0.105), (-0.005, 0.085), (-0.005, 0.065))]
    walls += [((-0.005, 0.105), (-0.005, 0.0), (-0.005, 0.065)), ((-0.005, 0.105), (-0.005, 0.085), (-0.005, 0.0))]
    walls += [((-0.005, 0.105), (-0.005, 0.085), (0.06, 0.065))]
    parts = {f"b{n}": box((0.0, lengths[n], 0.0), (0.1, lengths[n + 1], 0.06)) for n in range(3)}
    for n, wall in enumerate(walls):
        low, high = zip(*wall, strict=True)
        parts[f"wall{n}"] = box(low, high)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turn *= np.sign(np.linalg.det(turn))
        turned = {
            name: (vertices @ turn.T + noise * rng.uniform(-1.0, 1.0, vertices.shape), faces)
            for name, (vertices, faces) in parts.items()
        }
        scene = feeler.Scene(mockup_of(turned), threads=1)
        order = feeler.removal_order(scene, "b0", seconds=10.0, rounds=2, threads=1, keep="wall*")
        assert order.is_found and names(scene, order.parts) == ["b2", "b1", "b0"], seed


def test_what_is_wanted_is_not_kept(chest: feeler.Scene) -> None:
    for keep in ("thing", ["chest", "thing"]):
        with pytest.raises(feeler.OptionError, match="'thing' is wanted and kept"):
            feeler.removal_order(chest, ["thing", "lid"], threads=1, keep=keep)
    # Of several, such as an assembly, the wanted ones leave.
    order = feeler.removal_order(chest, "cover", threads=1, keep="*")
    assert order.is_found and names(chest, order.parts) == ["cover"]


def test_the_scene_says_what_is_there(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest.without("cover"), "thing", seconds=10.0, threads=1, keep="chest")
    assert order.is_found and names(chest, order.parts) == ["lid", "thing"]


def test_what_cannot_come_out_is_not_claimed_to() -> None:
    closed = feeler.Scene(closed_box(), threads=1)
    order = feeler.removal_order(closed, "inner", seconds=2.0, threads=1)
    assert not order.is_found


def test_what_stands_in_the_way_is_named() -> None:
    closed = feeler.Scene(closed_box(), threads=1)
    order = feeler.removal_order(closed, "inner", rounds=4, threads=1)
    assert names(closed, order.stuck) == ["inner"] and [each.path for each in order.blocked_by] == ["outer"]
    # The thing is stopped by the lid, the lid by the room, and the room by the chest in it, which stays.
    hollow = inverted(box((-1.0, -1.0, -0.125), (1.5, 1.5, 1.0)))
    room = joined(box((-1.125, -1.125, -0.25), (1.625, 1.625, 1.125)), hollow)
    lid = box((0.0, 0.0, 0.3125), (0.5, 0.5, 0.34375))
    scene = feeler.Scene(mockup_of({**CHEST, "lid": lid, "cover": room}), threads=1)
    order = feeler.removal_order(scene, "thing", rounds=4, threads=1, keep="chest")
    assert not order.is_found and names(scene, order.stuck) == ["cover"]
    assert [each.path for each in order.blocked_by] == ["chest"]


def test_a_part_is_looked_at_with_one_eye_on_the_caller(monkeypatch: pytest.MonkeyPatch, chest: feeler.Scene) -> None:
    monkeypatch.setattr(question, "LOOK_S", 0.0)
    told: list[str] = []

    def hear(_share: float, stage: str) -> None:
        told.append(stage)
        if told.count("what blocks thing") == 3:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        feeler.removal_order(chest, "thing", threads=1, keep="chest", progress=hear)
    assert told[-1] == "what blocks thing", "it ends within the look at one part"


def closed_box() -> feeler.Mockup:
    """A box within another that has no opening."""
    hollow = inverted(box((0.125, 0.125, 0.125), (0.875, 0.875, 0.875)))
    return mockup_of(
        {"inner": cube((0.3125, 0.3125, 0.3125), 0.125), "outer": joined(box((0, 0, 0), (1, 1, 1)), hollow)}
    )


def test_all_the_time_is_used_before_it_gives_up() -> None:
    told: list[tuple[float, str]] = []
    order = feeler.removal_order(
        *(feeler.Scene(closed_box(), threads=1), "inner"),
        seconds=1.0,
        threads=1,
        keep="outer",
        progress=lambda done, what: told.append((done, what)),
    )
    assert not order.is_found and order.seconds >= 1.0
    shares = [done for done, _ in told]
    assert shares == sorted(shares) and 0.0 <= shares[0] < 0.5 < shares[-1] <= 1.0
    assert any("inner" in what for _, what in told)


def test_an_interrupt_ends_it(chest: feeler.Scene) -> None:
    def interrupt(_done: float, what: str) -> None:
        if "what blocks" in what:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        feeler.removal_order(chest, "thing", threads=1, keep="chest", progress=interrupt)


@pytest.fixture(scope="module")
def orders() -> Any:
    pytest.importorskip("manifold3d")
    return importlib.import_module("removal.orders")


@pytest.mark.parametrize("seed", range(7))
def test_orders_of_random_assemblies_are_valid_and_short(orders: Any, seed: int) -> None:
    answer = orders.answer(seed, 20.0)  # one of each kind; all of these come apart
    assert answer.order.is_found and not answer.faults and answer.is_short


def plates_under_bolts(orders: Any) -> Any:
    """A base, a cover on it, and four bolts, one of them under a hood."""
    assemblies = importlib.import_module("removal.assemblies")
    made = assemblies.Assembly("cover", np.full((11, 11, 9), assemblies.EMPTY), 1e-4)
    made.fill(0, slice(0, 11), slice(0, 11), slice(0, 3))
    made.fill(1, slice(0, 11), slice(0, 11), slice(3, 4))
    for part, (x, y) in enumerate([(2, 2), (2, 8), (8, 2), (8, 8)], start=2):
        made.fill(part, x, y, slice(1, 4))
        made.fill(part, slice(x - 1, x + 2), slice(y - 1, y + 2), slice(4, 6))
        made.bolts[part] = (4, 3)
    inside = made.cubes[1:4, 1:4, 4:7].copy()
    made.fill(6, slice(0, 5), slice(0, 5), slice(4, 8))
    made.cubes[1:4, 1:4, 4:7] = inside
    return made


@pytest.mark.parametrize("wanted", [0, 1])
def test_bolts_go_before_what_they_join(orders: Any, wanted: int) -> None:
    made = plates_under_bolts(orders)
    made.wanted = wanted
    order = feeler.removal_order(feeler.Scene(made.mockup(), threads=1), wanted, seconds=20.0, threads=1)
    assert order.is_found and not orders.faults(made, order)
    assert set(order.parts[:-1]) == {2, 3, 4, 5, 6} and order.parts.index(6) < order.parts.index(2)
    assert order.parts[-1] == wanted and len(order) == 6


def test_interlocked_halves_leave_their_tray_together(orders: Any) -> None:
    assemblies = importlib.import_module("removal.assemblies")
    made = assemblies.Assembly("halves", np.full((12, 8, 5), assemblies.EMPTY), 1e-4)
    made.fill(2, slice(0, 12), slice(0, 8), slice(0, 5))
    # Each has a tongue under the other one.
    made.fill(0, slice(1, 6), slice(1, 7), slice(1, 5))
    made.fill(1, slice(6, 11), slice(1, 7), slice(1, 5))
    made.fill(0, slice(6, 9), slice(1, 3), slice(1, 2))
    made.fill(1, slice(3, 6), slice(4, 6), slice(1, 2))
    order = feeler.removal_order(feeler.Scene(made.mockup(), threads=1), 0, seconds=20.0, threads=1, keep=2)
    assert [step.parts for step in order] == [(0, 1)] and order.is_found and not orders.faults(made, order)


def test_what_is_kept_stays(orders: Any) -> None:
    made = plates_under_bolts(orders)
    scene = feeler.Scene(made.mockup(), threads=1)
    order = feeler.removal_order(scene, 1, seconds=2.0, threads=1, keep=[0, 3])
    # The bolt that stays is in the way up: the cover is held.
    assert not {0, 3} & set(order.parts)


def test_the_judge_sees_what_is_wrong(orders: Any) -> None:
    made = plates_under_bolts(orders)
    made.wanted = 1
    order = feeler.removal_order(feeler.Scene(made.mockup(), threads=1), 1, seconds=20.0, threads=1)
    backwards = feeler.RemovalOrder(True, order.steps[::-1], 0.0)
    assert any("is in part" in fault for fault in orders.faults(made, backwards))
    assert "the wanted part is still there" in orders.faults(made, feeler.RemovalOrder(True, order.steps[:-1], 0.0))
    assert orders.exhaustive(made) == orders.cost_of(made, order) == 6
    standing = feeler.RemovalOrder(True, order.steps[-1:], 0.0)
    assert orders.cost_of(made, standing) == 1 + 4 * orders.STANDING_COST


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_no_time_is_said(chest: feeler.Scene, seconds: float) -> None:
    with pytest.raises(OptionError, match="seconds"):
        feeler.removal_order(chest, "thing", seconds=seconds)


def test_parts_that_are_not_there_are_named(chest: feeler.Scene) -> None:
    with pytest.raises(OptionError, match="'thong'"):
        feeler.removal_order(chest, "thong")


def test_each_step_says_its_clearance_while_time_is_left(chest: feeler.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a busy machine the time of an attempt can be up when its way is found, and not measured yet."""

    def cut(*args: Any, **options: Any) -> feeler.Removal:
        way = feeler.removal(*args, **options)
        return replace(way, clearance=math.nan) if options["seconds"] < 5.0 else way

    monkeypatch.setattr(question, "removal", cut)
    order = feeler.removal_order(chest, "thing", seconds=60.0, threads=1, keep="chest")
    assert [math.isfinite(step.removal.clearance) for step in order] == [True] * 3


def test_an_order_travels(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest, "cover", threads=1)
    for other in (pickle.loads(pickle.dumps(order)), copy.deepcopy(order)):
        assert other.parts == order.parts
        np.testing.assert_array_equal(other.steps[0].removal.poses, order.steps[0].removal.poses)


def test_a_film_turns_as_the_way_does() -> None:
    poses = np.stack([np.eye(4), at(0.5, 0.25, 0.125, degrees=90)])
    middle = np.array([1.0, 2.0, 3.0])
    way = in_steps(poses, middle)
    np.testing.assert_array_equal(way[[0, -1]], poses)
    assert len(way) == 17  # a quarter turn in steps of at most 0.1 rad
    middles = way[:, :3, :3] @ middle + way[:, :3, 3]
    steps = np.diff(middles, axis=0)
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-12)
    # The farthest corner moves at one speed, also where it mostly turns.
    bounds = np.array([[-1.0, -0.2, 0.0], [3.0, 0.3, 0.1]])
    turning = np.concatenate([way, np.stack([way[-1] @ at(degrees=5 * k) for k in range(1, 9)])])
    times = moments(turning, bounds)
    corners = np.array([[x, y, z, 1.0] for x in bounds[:, 0] for y in bounds[:, 1] for z in bounds[:, 2]])
    places = (turning @ corners.T)[:, :3]
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1).max(axis=1) / np.diff(times)
    np.testing.assert_allclose(speeds, speeds[0], rtol=1e-9)
    assert times[0] == 0.0
    # Poses that are the same have moments of their own.
    still = np.concatenate([turning[:3], turning[2:]])
    assert (np.diff(moments(still, bounds)) > 0.0).all()
    assert (np.diff(moments(np.tile(np.eye(4), (3, 1, 1)), bounds)) > 0.0).all()


def test_thousands_of_passes_that_end_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of small parts in a closed box on a fast machine: the time of an attempt doubles with each."""
    order = importlib.import_module("feeler.plan.order")
    budgets = []

    def ends_at_once(search: Any, passes: int) -> bool:
        budgets.append(search._budget(passes))
        if passes == 3_000:
            raise KeyboardInterrupt
        return False

    monkeypatch.setattr(order._Search, "_try_what_is_stuck", ends_at_once)
    case = feeler.Mockup(
        {"core": cube((0.4, 0.4, 0.4), 0.2), "case": joined(cube((0, 0, 0), 1), inverted(cube((0.4, 0.4, 0.4), 0.2)))}
    )
    with pytest.raises(feeler.RemovalOrderInterrupted):
        feeler.removal_order(feeler.Scene(case), "core", keep="case", seconds=60)
    assert len(budgets) > 1_100
