"""Sessions that run with a device: real threads, short runs, and nothing asserted that depends on how fast they are."""

from __future__ import annotations

import copy
import os
import pickle
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from shapes import Mesh, box

import feeler
from feeler.choices import DeviceDriver
from feeler.errors import DeviceError, FeelerError, OptionError, PoseError, SessionError
from feeler.haptics import Coupling, Session, View, devices, open_device

MOST_N = 12.0 * (1 + 1e-9)
LOOKS = 30_000
"""Half a minute on an idle machine: a guard against waiting for ever, no measurement."""


def sized(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Mesh:
    half = 0.5 * np.array(size)
    return box(middle - half, middle + half)


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    """A plate, its upper side at z = 0, and a small box on its own above it."""
    (a, faces), (b, more) = sized((0.4, 0.4, 0.02), (0, 0, -0.01)), sized((0.02, 0.02, 0.02), (0.1, 0, 0.03))
    parts = np.repeat([0, 1], [len(faces), len(more)])
    return feeler.Scene(
        feeler.Mockup(np.concatenate([a, b]), np.concatenate([faces, more + len(a)]), parts, ["plate", "box"])
    )


TOOL = feeler.Tool(*sized((0.03, 0.04, 0.05), (0, 0, 0)), "block")
DOWN = ([0.0, 0.05, 0.1], [pose(), pose(z=-0.01), pose(z=-0.02)])


@pytest.fixture
def session(scene: feeler.Scene) -> Iterator[Session]:
    """Started with the block 1 mm above the plate."""
    made = Session(scene, TOOL)
    made.start(pose(z=0.026))
    yield made
    made.stop()


def until(session: Session, is_wanted: Callable[[View], bool], is_free: bool = True) -> View:
    """The first view that is as wanted, with what every view promises asserted. is_free: nothing holds the tool."""
    for _ in range(LOOKS):
        view = session.view()
        assert np.linalg.norm(view.force) <= MOST_N
        if view.mode == "doubt":
            assert not view.force.any() and not view.torque.any()
        if view.number and is_free:
            assert not session.scene.is_colliding(session.tool, view.world_from_proxy)
        if view.number and is_wanted(view):
            return view
        assert session.is_running
        time.sleep(0.001)
    raise AssertionError(f"what is waited for does not come: {session.view()}")


def run(session: Session, device: devices.Device, **options: object) -> None:
    session.run(device, **{"realtime": False, **options})  # type: ignore[arg-type]


def test_a_hand_presses_the_block_on_the_plate_and_feels_it(session: Session) -> None:
    run(session, devices.Simulated(hand=DOWN))
    view = until(session, lambda view: view.mode == "contact" and view.force[2] > 1.0)
    assert view.parts.tolist() == [0] * len(view.parts) and len(view.parts)
    assert np.allclose(view.normals, [0, 0, 1], atol=1e-9)
    assert view.world_from_proxy[2, 3] > 0.025 > view.world_from_device[2, 3]
    time.sleep(0.2)
    trace = session.trace()
    assert len(trace) > 0 and (np.diff(trace.times) > 0).all() and trace.has_device.all()
    assert not any(session.scene.is_colliding(TOOL, each) for each in trace.world_from_proxy)
    assert (np.linalg.norm(trace.wrenches[:, :3], axis=1) <= MOST_N).all()
    stats = session.stop()
    assert stats is not None and stats.ticks >= len(trace) and stats.sets > 0
    assert stats.servo_tick.count == stats.ticks and stats.collision_tick.count == stats.sets
    assert stats.device_errors == 0 == stats.collision_errors
    assert stats.servo_tick.median <= stats.servo_tick.p99 <= stats.servo_tick.max


def test_stop_is_idempotent_and_the_session_goes_on_by_steps(session: Session) -> None:
    assert session.stop() is None
    with pytest.raises(SessionError, match="has not run"):
        session.stats()
    device = devices.Simulated(hand=DOWN)
    run(session, device)
    there = until(session, lambda view: view.mode == "contact").world_from_proxy
    with pytest.raises(SessionError, match="runs"):
        session.step(pose(z=0.026))
    with pytest.raises(SessionError, match="runs already"):
        run(session, device)
    session.trace()
    seen = session.view().number
    until(session, lambda view: view.number > seen + 10)
    first = session.stop()
    assert first is not None and session.stop() is first and session.stats() is first
    # The last ticks are there after the end, once.
    assert len(session.trace()) >= 10 and len(session.trace()) == 0
    assert not session.is_running
    with pytest.raises(SessionError, match="does not run"):
        session.view()
    step = session.step(there)
    assert step.mode in ("free", "contact") and step.age == 0.0
    # And by another run, with the same device.
    run(session, device)
    until(session, lambda view: view.mode == "contact")


def test_a_session_that_is_dropped_stops(scene: feeler.Scene) -> None:
    device = devices.Simulated(hand=DOWN)
    session = Session(scene, TOOL)
    session.start(pose(z=0.026))
    run(session, device)
    until(session, lambda view: view.number > 10)
    del session
    # Its device went with it: the threads had it.
    other = Session(scene, TOOL)
    other.start(pose(z=0.026))
    with pytest.raises(DeviceError, match="in use"):
        run(other, device)
    run(other, devices.Simulated(hand=DOWN))
    other.stop()


@pytest.mark.parametrize("kind", ["nan", "nonsense", "lost", "silent"])
def test_in_doubt_there_is_no_force_and_then_again(session: Session, kind: str) -> None:
    run(session, devices.Simulated(hand=DOWN, fault=(kind, 0.0, 0.3, 0.6)))
    until(session, lambda view: view.force[2] > 1.0)
    until(session, lambda view: view.mode == "doubt")
    until(session, lambda view: view.force[2] > 1.0)
    stats = session.stop()
    assert stats is not None and stats.doubts > 0
    assert (stats.device_errors > 0) == (kind in ("nonsense", "lost")) == bool(session.troubles)


@pytest.mark.parametrize(("kind", "value"), [("jump", -1.0), ("slow", 20.0)])
def test_jumps_and_slow_devices_pass_nothing(session: Session, kind: str, value: float) -> None:
    run(session, devices.Simulated(hand=DOWN, fault=(kind, value, 0.1, 0.3)))
    begin = until(session, lambda view: True).time
    until(session, lambda view: view.time > begin + 0.4 and view.mode == "contact")
    trace = session.trace()
    assert not any(session.scene.is_colliding(TOOL, each) for each in trace.world_from_proxy)
    assert (trace.world_from_proxy[:, 2, 3] > 0.025).all()


def test_three_driven_freedoms_get_force_without_torque(session: Session) -> None:
    run(session, devices.Simulated("desktop_3dof", hand=DOWN))
    until(session, lambda view: view.force[2] > 1.0)
    assert not session.trace().wrenches[:, 3:].any()
    said = session.granted().limitations
    assert (
        "rotational stiffness 0 Nm/rad instead of 2: the simulated desktop device, 3 driven freedoms drives no rotation"
        in said
    )


def test_slow_collision_ticks_hold_the_proxy_back(scene: feeler.Scene) -> None:
    session = Session(scene, TOOL, collision_hz=10)
    session.start(pose(z=0.026))
    run(session, devices.Simulated(hand=DOWN))
    until(session, lambda view: view.mode == "contact" and view.force[2] > 1.0)
    session.stop()


def test_a_collision_rate_of_hours_keeps_nobody_waiting(scene: feeler.Scene) -> None:
    """It slept for the whole period, and so did those who asked for something, or for the end."""
    session = Session(scene, TOOL, collision_hz=1e-4)
    session.start(pose(z=0.05))
    session.run(devices.Mouse(pose(z=0.05)))
    session.start(pose(z=0.06))
    stats = session.stop()
    assert stats is not None


def test_a_mouse_is_steered(session: Session) -> None:
    mouse = devices.Mouse(pose(z=0.026))
    run(session, mouse)
    mouse.set_target(pose(0.02, 0.0, 0.01))
    mouse.set_buttons(5)
    view = until(session, lambda view: view.mode == "contact" and abs(view.world_from_device[0, 3] - 0.02) < 1e-4)
    assert view.buttons == 5 and not view.force.any()
    with pytest.raises(PoseError):
        mouse.set_target(np.full((4, 4), np.nan))
    with pytest.raises(DeviceError, match="not steered"):
        devices.Simulated()._device.set_target(np.eye(4))


def test_starts_grips_and_scenes_while_it_runs(session: Session, scene: feeler.Scene) -> None:
    run(session, devices.Simulated(hand=([0.0], [pose()])))
    assert session.start(pose(z=0.1))
    until(session, lambda view: abs(view.world_from_proxy[2, 3] - 0.1) < 1e-3)
    session.grip("box")
    assert session.gripped == (1,)
    with pytest.raises(SessionError, match="holds part 1"):
        session.grip(0)
    session.release()
    assert session.gripped == ()
    with pytest.raises(SessionError, match="holds no part"):
        session.release()
    begun = session.start(pose(z=0.01))
    assert not begun and begun.way_out is not None
    assert {seat.kind for seat in begun.seats} == {"sunk"}
    until(session, lambda view: abs(view.world_from_proxy[2, 3] - 0.01) < 1e-3, is_free=False)
    assert session.set_scene(feeler.Scene(feeler.Mockup(*sized((0.1, 0.1, 0.1), (5, 0, 0)))))
    until(session, lambda view: view.mode == "free", is_free=False)
    session.stop()
    assert session.gripped == ()
    assert not session.set_scene(scene)


def test_what_is_refused(scene: feeler.Scene, session: Session) -> None:
    device = devices.Simulated()
    with pytest.raises(SessionError, match="start"):
        run(Session(scene, TOOL), device)
    with pytest.raises(OptionError, match=r"feeler\.haptics\.devices"):
        run(session, "haply")  # type: ignore[arg-type]
    bad: list[dict[str, object]] = [
        {"rate_hz": 10.0},
        {"rate_hz": float("nan")},
        {"scale": 0.0},
        {"clutch_button": 7},
    ]
    for options in bad:
        with pytest.raises(OptionError):
            run(session, device, **options)
    with pytest.raises(PoseError):
        run(session, device, world_from_device=np.ones((4, 4)))
    # After all that both are as they were.
    run(session, device)
    until(session, lambda view: view.number > 3)


def test_devices_that_are_not_there_say_what_to_do() -> None:
    with pytest.raises(DeviceError, match="spacemouse, haply, dhd, openhaptics"):
        open_device("joystick")
    with pytest.raises(DeviceError) as error:
        open_device("haply", address="127.0.0.1:1")
    assert len(str(error.value)) > 30
    with pytest.raises(DeviceError):
        open_device("dhd", library="/nowhere/libdhd.so")
    with pytest.raises(OptionError, match="no option colour"):
        open_device("haply", colour="red")
    for no_number in ("strong", True, [1.0, 2.0], 1j):
        with pytest.raises(OptionError, match=r"^force_n is .*: give newtons, 0 to 1000"):
            open_device("haply", force_n=no_number)
    with pytest.raises(OptionError, match=r"^address is 7: give a text"):
        open_device("haply", address=7)
    assert issubclass(DeviceError, FeelerError) and feeler.DeviceError is DeviceError


@pytest.mark.parametrize(
    ("driver", "option", "values"),
    [
        ("haply", "force_n", [-3.0, np.nan, np.inf, 1e9]),
        ("haply", "stiffness_n_per_m", [-5.0, 0.0, np.nan, np.inf, 1e9]),
        ("dhd", "force_n", [-3.0, np.nan, np.inf, 1e9]),
        ("dhd", "torque_nm", [-3.0, np.nan, np.inf, 1e9]),
        ("dhd", "stiffness_n_per_m", [-5.0, 0.0, np.nan, np.inf, 1e9]),
        ("openhaptics", "force_n", [-3.0, np.nan, np.inf, 1e9]),
        ("openhaptics", "stiffness_n_per_m", [-5.0, 0.0, np.nan, np.inf, 1e9]),
        *(
            ("spacemouse", option, [-1.0, 0.0, np.nan, np.inf, 1e9])
            for option in ("speed_m_per_s", "turn_rad_per_s", "full_deflection_counts", "reach_m")
        ),
        ("spacemouse", "silence_s", [-1.0, 0.0, np.nan]),
        ("spacemouse", "dead_zone", [-0.1, 1.0, np.nan, np.inf]),
    ],
)
def test_numbers_that_cannot_be_are_refused_before_a_device_is_opened(
    driver: DeviceDriver, option: str, values: list[float]
) -> None:
    for value in values:
        with pytest.raises(OptionError, match=f"^{option} is .*: give "):
            open_device(driver, **{option: value})


def test_simulated_devices_say_what_they_are() -> None:
    three, six, large = (devices.Simulated(preset) for preset in devices.PRESETS)
    assert three.driven == ("translation",) and six.driven == ("translation", "rotation") == large.sensed
    assert three.limits["torque_nm"] == 0.0 and large.limits["force_n"] == 60.0
    assert devices.Simulated(delay_s=0.004, jitter_s=0.001).limits["delay_s"] == pytest.approx(0.005)
    assert large.workspace == (0.8, 0.3, 0.4) and six.buttons == 2 and "6 driven" in repr(six)
    for options in (
        {"preset": "huge"},
        {"hand": ([0.0, 1.0], [pose()])},
        {"hand": ([1.0, 0.5], [pose(), pose()])},
        {"hand": ([[0.0]], [pose()])},
        {"hand": DOWN, "grip": "iron"},
        {"fault": ("rust", 0.0, 0.0, 1.0)},
        {"delay_s": -1.0},
    ):
        with pytest.raises(OptionError):
            devices.Simulated(**options)
    with pytest.raises(OptionError):
        devices.Mouse(pose(), frequency=0.0)


def test_a_coupling_for_a_device_is_held_by_it() -> None:
    six = devices.Simulated("desktop_6dof")
    coupling = Coupling.for_device(six)
    assert coupling.max_force_n == 12.0 and coupling.stiffness_n_per_m > 100.0
    delayed = Coupling.for_device(devices.Simulated("desktop_6dof", delay_s=0.01))
    assert delayed.stiffness_n_per_m < 0.2 * coupling.stiffness_n_per_m


def test_what_is_of_this_process_does_not_travel(session: Session) -> None:
    run(session, devices.Simulated(hand=DOWN))
    for what in (session, devices.Simulated(), devices.Mouse(pose()), session._run):
        for way in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match="cannot be pickled or copied"):
                way(what)
    view, stats, granted = session.view(), session.stats(), session.granted()
    for value in (stats, granted):
        assert pickle.loads(pickle.dumps(value)) == value
    assert pickle.loads(pickle.dumps(view)).mode == view.mode


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_child_runs_its_own_and_leaves_the_parents_alone(session: Session, scene: feeler.Scene) -> None:
    run(session, devices.Simulated(hand=DOWN))
    until(session, lambda view: view.mode == "contact")
    child = os.fork()
    if child == 0:
        status = 1
        try:
            assert not session.is_running
            for ask in (session.view, session.stats, session.stop):
                with pytest.raises(SessionError, match="forked"):
                    ask()
            own = Session(scene, TOOL)
            own.start(pose(z=0.026))
            run(own, devices.Simulated(hand=DOWN))
            until(own, lambda view: view.mode == "contact")
            own.stop()
            status = 0
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    number = session.view().number
    until(session, lambda view: view.number > number + 5)


def test_priority_and_memory_are_granted_or_the_reason_is_said(session: Session) -> None:
    session.run(devices.Simulated(hand=DOWN))
    until(session, lambda view: view.number > 3)
    granted = session.granted()
    assert "priority" in granted.priority and "priority" in granted.collision_priority and "locked" in granted.memory
    assert granted.coupling.max_force_n <= 12.0
