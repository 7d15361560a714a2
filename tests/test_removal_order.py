"""What has to go before a part comes out."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from shapes import at, box, cube, inverted, joined, mockup_of, open_chest

import feeler
from feeler.errors import OptionError
from feeler.plan.as_glb import in_steps, moments

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
    assert order.found and names(chest, order.parts) == ["cover", "lid", "thing"]
    # Each way is free of all that is still there.
    gone: list[int] = []
    for step in order:
        scene = chest.without(gone) if gone else chest
        tool = feeler.Tool.of_parts(chest.mockup, list(step.parts))
        check = scene.without(list(step.parts)).check_path(tool, step.removal.poses, touching="free")
        assert step.removal.found and check.free
        gone += step.parts


def test_what_comes_out_by_itself_is_one_step(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest, "cover", threads=1)
    assert order.found and len(order) == 1 and names(chest, order.parts) == ["cover"]


def test_the_scene_says_what_is_there(chest: feeler.Scene) -> None:
    order = feeler.removal_order(chest.without("cover"), "thing", seconds=10.0, threads=1, keep="chest")
    assert order.found and names(chest, order.parts) == ["lid", "thing"]


def test_what_cannot_come_out_is_not_claimed_to() -> None:
    closed = feeler.Scene(closed_box(), threads=1)
    order = feeler.removal_order(closed, "inner", seconds=2.0, threads=1)
    assert not order.found
    assert [closed.mockup.part_names[each.part] for each in order.steps[-1].removal.blocked_by] == ["outer"]


def closed_box() -> feeler.Mockup:
    """A box within another that has no opening."""
    hollow = inverted(box((0.125, 0.125, 0.125), (0.875, 0.875, 0.875)))
    return mockup_of(
        {"inner": cube((0.3125, 0.3125, 0.3125), 0.125), "outer": joined(box((0, 0, 0), (1, 1, 1)), hollow)}
    )


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_no_time_is_said(chest: feeler.Scene, seconds: float) -> None:
    with pytest.raises(OptionError, match="seconds"):
        feeler.removal_order(chest, "thing", seconds=seconds)


def test_parts_that_are_not_there_are_named(chest: feeler.Scene) -> None:
    with pytest.raises(OptionError, match="'thong'"):
        feeler.removal_order(chest, "thong")


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
    times = moments(way)
    assert times[0] == 0.0 and (np.diff(times) > 0.0).all()
    # Of a way that leads nowhere the moments differ, too.
    assert (np.diff(moments(np.tile(np.eye(4), (3, 1, 1)))) > 0.0).all()
