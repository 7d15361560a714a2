"""Devices that are written in Python: the servo thread asks them, and what they raise ends the run."""

from __future__ import annotations

import gc
import subprocess
import sys
import time
import weakref
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from feeler.cli.feel_check import block_and_plate
from feeler.errors import DeviceError, OptionError, SessionError
from feeler.haptics import Coupling, Session, devices

LOOKS = 30_000
"""Half a minute on an idle machine: a guard against waiting for ever, no measurement."""


class Handle(devices.Own):
    """Where it is told to be; keeps what it is given."""

    info = devices.Info(
        "handle", force_n=10.0, torque_nm=1.0, senses_rotation=True, buttons=2, stiffness_n_per_m=500.0, rate_hz=1000.0
    )

    def __init__(self) -> None:
        self.place: object = np.zeros(3)
        self.given: list[np.ndarray] = []
        self.releases = 0

    def read(self) -> object:
        return self.place

    def write(self, force: np.ndarray, torque: np.ndarray) -> None:
        self.given = [force, torque]

    def release(self) -> None:
        self.releases += 1
        super().release()


def session_of(device: devices.Device) -> Session:
    plate, block, start = block_and_plate()
    session = Session(plate, block, coupling=Coupling.for_device(device))
    session.start(start)
    return session


def until(is_so: Callable[[], bool]) -> None:
    for _ in range(LOOKS):
        if is_so():
            return
        time.sleep(0.001)
    raise AssertionError("what is waited for does not come")


def down(depth_m: float, turn: float = 0.0) -> np.ndarray:
    """The handle so far beyond the plate, turned about x."""
    pose = np.eye(4)
    pose[2, 3] = -0.002 - depth_m
    pose[1:3, 1:3] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    return pose


def test_force_and_torque_of_the_granted_springs_arrive() -> None:
    handle = Handle()
    session = session_of(handle)
    session.run(handle, realtime=False)
    until(lambda: session.view().number > 20)
    handle.place = (down(0.012, 0.02), 0b10)
    granted = session.granted()
    coupling = granted.coupling
    assert coupling.stiffness_n_per_m == 500.0
    # A machine that is busy may run the servo slowly.
    assert all("the servo runs at" in said for said in granted.limitations)
    wanted = [0.0, 0.0, 6.0, -0.02 * coupling.rotational_stiffness_nm_per_rad, 0.0, 0.0]
    until(lambda: np.allclose(np.concatenate(handle.given), wanted, rtol=0.02, atol=0.02))
    assert session.view().buttons == 0b10
    session.stop()
    assert handle.releases > 0 and not np.concatenate(handle.given).any()


@pytest.mark.parametrize(
    "more", [{}, {"stiffness_n_per_m": 500.0}, {"stiffness_n_per_m": 500.0, "damping_n_s_per_m": 1.0}]
)
def test_a_rate_that_is_not_given_limits_nothing(more: dict[str, float]) -> None:
    class Unrated(Handle):
        info = devices.Info("unrated", force_n=10.0, **more)  # type: ignore[arg-type]

    handle = Unrated()
    wanted = more.get("stiffness_n_per_m", 1000.0)
    assert Coupling.for_device(handle).stiffness_n_per_m == pytest.approx(wanted)
    # Nor does a workspace that is not given push.
    assert handle.workspace == (0.0, 0.0, 0.0)
    session = session_of(handle)
    session.run(handle, realtime=False)
    handle.place = np.array([0.0, 0.0, 0.3])
    until(lambda: session.view().number > 20)
    assert session.granted().coupling.stiffness_n_per_m == pytest.approx(wanted)
    assert not handle.given[0].any()
    handle.place = down(0.002)[:3, 3]
    until(lambda: handle.given[0][2] > 0.5)
    session.stop()


def test_a_handle_that_reports_seldom_is_softer_and_it_is_said() -> None:
    class Seldom(Handle):
        told = 0.0

        def read(self) -> object:
            now = time.monotonic()
            if now - self.told < 0.02:
                return None
            self.told = now
            return self.place

    handle = Seldom()
    session = session_of(handle)
    session.run(handle, realtime=False)
    until(lambda: session.view().number > 20)
    handle.place = down(0.012)[:3, 3]
    # 25 N/m, or less where the machine is busy.
    until(lambda: any("the handle reports" in said for said in session.granted().limitations))
    until(lambda: 0.0 < handle.given[0][2] < 0.8)
    session.stop()


def test_silence_lets_go_and_a_pose_brings_the_force_back() -> None:
    handle = Handle()
    session = session_of(handle)
    session.run(handle, realtime=False)
    until(lambda: session.view().number > 20)
    handle.place = down(0.005)[:3, 3]
    until(lambda: session.view().force[2] > 2.0)
    handle.place = None
    until(lambda: session.view().mode == "doubt")
    handle.place = down(0.005)[:3, 3]
    until(lambda: session.view().force[2] > 2.0)
    session.stop()


@pytest.mark.parametrize("bad", [np.nan, np.inf, "scaled"])
def test_a_pose_that_is_none_lets_go_and_the_next_brings_the_force_back(bad: float | str) -> None:
    handle = Handle()
    session = session_of(handle)
    session.run(handle, realtime=False)
    until(lambda: session.view().number > 20)
    good = down(0.005)
    handle.place = good
    until(lambda: session.view().force[2] > 2.0)
    handle.place = 2.0 * good if bad == "scaled" else np.array([0.0, 0.0, bad])
    until(lambda: session.view().mode == "doubt")
    until(lambda: not np.concatenate(handle.given).any())
    assert session.is_running
    handle.place = good
    until(lambda: session.view().force[2] > 2.0)
    statistics = session.stop()
    assert statistics is not None and statistics.device_errors > 0


class CableError(Exception):
    """What a driver may raise."""


@pytest.mark.parametrize("breaks", ["read", "write", "shape", "type"])
def test_what_it_raises_lets_go_and_ends_the_run(breaks: str) -> None:
    class Breaking(Handle):
        reads = 0
        has_failed = False

        def read(self) -> object:
            self.reads += 1
            bad = {"shape": np.zeros(2), "type": "here"}
            if self.reads < 50 or breaks == "write":
                return np.zeros(3)
            if breaks == "read":
                raise CableError("no cable")
            return bad[breaks]

        def write(self, force: np.ndarray, torque: np.ndarray) -> None:
            if breaks == "write" and self.reads == 50 and not self.has_failed:
                self.has_failed = True
                raise CableError("no cable")
            super().write(force, torque)

    handle = Breaking()
    session = session_of(handle)
    session.run(handle, realtime=False)
    until(lambda: not session.is_running)
    assert handle.releases > 0 and not np.concatenate(handle.given).any()
    said = "CableError: no cable" if breaks in ("read", "write") else "handle failed"
    with pytest.raises(SessionError, match=said):
        session.stop()
    # The session goes on with another.
    session.run(Handle(), realtime=False)
    until(lambda: session.view().number > 5)
    session.stop()


def test_one_run_at_a_time_and_nothing_is_kept() -> None:
    handle = Handle()
    first, second = session_of(handle), session_of(handle)
    first.run(handle, realtime=False)
    with pytest.raises(DeviceError, match="in use"):
        second.run(handle, realtime=False)
    first.stop()
    second.run(handle, realtime=False)
    second.stop()
    kept = weakref.ref(handle)
    del handle, first, second
    gc.collect()
    assert kept() is None


def test_what_it_says_of_itself_is_checked() -> None:
    class Nameless(devices.Own):
        pass

    with pytest.raises(OptionError, match=r"Nameless\.info"):
        _ = Nameless().name

    with pytest.raises(OptionError, match="name is empty"):
        devices.Info("")
    with pytest.raises(OptionError, match=r"force_n is -1\.0"):
        devices.Info("x", force_n=-1.0)
    handle = Handle()
    assert handle.name == "handle" and handle.driven == ("translation", "rotation") and handle.buttons == 2
    assert handle.limits["stiffness_n_per_m"] == 500.0 and handle.limits["damping_n_s_per_m"] == 0.0
    with pytest.raises(NotImplementedError):
        devices.Own().read()


def test_an_interpreter_that_ends_while_it_runs_lets_go(tmp_path: Path) -> None:
    program = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_haptics_own import Handle, session_of, until
handle = Handle()
handle.__class__.release = lambda self: print("let go", flush=True)
session = session_of(handle)
session.run(handle, realtime=False)
until(lambda: session.view().number > 5)
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert "let go" in done.stdout
