"""A device that moves the page's hand feels what the page shows."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from workbench_scene import PLATE, Bench, at, cube

from feeler.errors import OptionError, PoseError, SessionError
from feeler.haptics import View, devices
from feeler.workbench.engine.device import DeviceHand

LOOKS = 700
"""At each place of the hand; and `PLACES`: guards against waiting for ever, no measurement."""
PLACES = 120


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench(cube(), pose=at(0.0, 0.0, 0.04))
    yield made
    made.session.close()


def until(bench: Bench, hand: DeviceHand, is_wanted: Callable[[View], bool]) -> View:
    """A view that is wanted. Where the handle is low when the hand begins, it pushes down no more: then again."""
    for place in range(PLACES):
        for _ in range(LOOKS):
            haptics = hand.haptics
            with contextlib.suppress(SessionError):  # it ends while it is asked
                view = haptics.view() if haptics is not None else None
                if view is not None and view.number and is_wanted(view):
                    return view
            time.sleep(0.001)
        bench.command("place", pose=at(0.0, 0.0, 0.04 + 1e-6 * (place + 1)).ravel().tolist())
    raise AssertionError("what is waited for does not come")


def test_a_device_feels_what_the_page_shows(bench: Bench) -> None:
    # A handle that goes 30 mm down and up, over and over: the plate is 8.75 mm below the cube.
    times = (0.3 * np.arange(400)).tolist()
    pushed = devices.Simulated(hand=(times, [at(0.0, 0.0, -0.03 * (k % 2)) for k in range(400)]))
    hand = DeviceHand(bench.session, pushed)
    try:
        felt = until(bench, hand, lambda view: view.force[2] > 0.5)
        assert PLATE in felt.parts.tolist()
        # With the plate in the hand it moves with the cube, and nothing is below.
        bench.command("grip", parts="stand/plate")
        until(bench, hand, lambda view: view.world_from_proxy[2, 3] < 0.03 and not view.force.any())
        assert hand.haptics is not None and hand.haptics.tool.triangle_count == 24
        # Put down, it is felt again.
        bench.command("release")
        felt = until(bench, hand, lambda view: view.force[2] > 0.5)
        assert PLATE in felt.parts.tolist() and hand.haptics.tool.triangle_count == 12
        # Placed elsewhere the hand begins there.
        bench.command("place", pose=at(0.2, 0.0, 0.04).ravel().tolist())
        until(bench, hand, lambda view: view.world_from_proxy[0, 3] > 0.19)
    finally:
        hand.close()
    assert hand.haptics is None
    hand.close()


def test_a_way_draws_the_device_and_stops_where_it_ends(bench: Bench) -> None:
    # Nobody holds the handle: what moves it is the guide alone.
    hand = DeviceHand(bench.session, devices.Simulated("desktop_6dof"))
    try:
        until(bench, hand, lambda view: view.number > 10)
        guide = bench.session.engine
        bench.command("place", pose=at(0.0, 0.0, 0.1).ravel().tolist())
        until(bench, hand, lambda view: abs(view.world_from_device[2, 3] - 0.1) < 0.01)
        bench.clock.now += 60.0  # the script has the tool no more
        guide.set_guide([at(0.01, -0.05, 0.1), at(0.01, 0.05, 0.1)])
        # To the way, and along it.
        felt = until(bench, hand, lambda view: view.force.any())
        assert np.linalg.norm(felt.force) <= 1.5 + 1e-9
        felt = until(bench, hand, lambda view: view.world_from_device[1, 3] > 0.03)
        assert felt.world_from_device[0, 3] == pytest.approx(0.01, abs=4e-3)
        guide.set_guide(None)
        until(bench, hand, lambda view: not view.force.any())
        haptics = hand.haptics
        assert haptics is not None
        for pose in (np.full((4, 4), np.nan), 2 * np.eye(4)):
            with pytest.raises(PoseError):
                haptics.guide(pose)
        with pytest.raises(OptionError, match="pull"):
            haptics.guide(None, (0.0, np.nan, 0.0))
    finally:
        hand.close()
    with pytest.raises(SessionError, match="does not run"):
        haptics.guide(None)
