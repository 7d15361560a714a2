"""`feeler feel`: a hand in real time, from the command line."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from commands import error_of, run, run_json
from shapes import Mesh, box

import feeler
from feeler.cli import feel_check
from feeler.cli.app import app
from feeler.haptics import devices
from feeler.io import write_stl


def sized(size: tuple[float, float, float], middle: tuple[float, float, float]) -> Mesh:
    half = 0.5 * np.array(size)
    return box(middle - half, middle + half)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A plate and a block as files."""
    folder = tmp_path_factory.mktemp("feel")
    mockup, tool = folder / "plate.stl", folder / "block.stl"
    write_stl(mockup, feeler.Mockup(*sized((0.4, 0.4, 0.02), (0, 0, -0.01))))
    write_stl(tool, feeler.Mockup(*sized((0.03, 0.04, 0.05), (0, 0, 0))))
    return mockup, tool


def words(files: tuple[Path, Path], *more: str) -> list[str | Path]:
    mockup, tool = files
    return ["feel", mockup, "--tool", tool, *more]


def test_json_says_how_it_went(files: tuple[Path, Path]) -> None:
    said = run_json(*words(files, "--seconds", "0.4"))
    assert "simulated large device" in said["device"]["name"]
    stats = said["stats_s"]
    assert stats["ticks"] > 0 and stats["servo_tick"]["count"] == stats["ticks"]
    assert said["largest_force_n"] <= 60.0
    assert set(said["ticks_by_mode"]) <= {"free", "contact", "bound", "doubt", "colliding"}
    assert "priority" in said["granted"]["priority_said"] and said["troubles"] == []


def test_people_get_a_table(files: tuple[Path, Path]) -> None:
    out = run(*words(files, "--seconds", "0.3", "--collision-hz", "100")).stdout
    for word in ("servo tick", "collision tick", "lateness", "force", "touched", "Ctrl-C", "priority", "p99.9"):
        assert word in out, out


def test_a_record_can_be_replayed(files: tuple[Path, Path], tmp_path: Path) -> None:
    target = tmp_path / "feel.npz"
    said = run_json(*words(files, "--seconds", "0.3", "--record", str(target)))
    assert said["written"] == str(target)
    parted = feeler.haptics.replay(target)
    assert parted and parted.steps > 0


def test_parts_of_the_mock_up_can_be_the_tool(files: tuple[Path, Path], tmp_path: Path) -> None:
    above = tmp_path / "above.stl"
    write_stl(above, feeler.Mockup(*sized((0.03, 0.04, 0.05), (0, 0, 0.1))))
    said = run_json("feel", files[0], above, "--part", "above", "--seconds", "0.2")
    assert said["stats_s"]["ticks"] > 0
    assert all(touched["path"] == "plate" for touched in said["touched"])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--device", "joystick"], "choose simulated, spacemouse, haply, dhd, openhaptics"),
        (["--preset", "huge"], "choose desktop_3dof"),
        (["--seconds", "0"], "--seconds"),
        (["--hz", "5"], "--hz is"),
        (["--scale", "0"], "--scale"),
        (["--record", "feel.txt"], ".npz"),
        (["--collision-hz", "-1"], "--collision-hz is"),
        (["--device-option", "force_n=3"], "use --preset or another --device"),
        (["--device", "dhd", "--device-option", "force_n"], "NAME=VALUE"),
        (["--device", "dhd", "--device-option", "colour=red"], "no option colour"),
        (["--device", "haply", "--device-option", "device_id=7", "--device-option", "address=127.0.0.1:1"], "Inverse"),
        (["--device", "dhd", "--device-option", "force_n=strong"], "force_n"),
        (["--device", "haply", "--device-option", "force_n=nan"], "force_n is NaN: give newtons, 0 to 1000"),
        (["--device", "dhd", "--device-option", "library=/nowhere/libdhd.so"], "/nowhere/libdhd.so"),
    ],
)
def test_bad_input_is_one_line(files: tuple[Path, Path], more: list[str], said: str) -> None:
    assert said in error_of(*words(files, "--seconds", "0.1", *more))


def test_a_device_that_is_not_there_is_said_at_once(files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SPNAV_SOCKET", "/nowhere/spnav.sock")
    assert "spacenavd" in error_of(*words(files, "--device", "spacemouse"))


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_prints_the_last_table_and_ends_with_0(files: tuple[Path, Path]) -> None:
    # Where the tests run in the background, Ctrl-C is ignored unless the child asks for it.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    program = [sys.executable, "-c", f"{heard}from feeler.cli import main; main()", *map(str, words(files))]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        try:
            assert running.stdout is not None
            for line in running.stdout:
                if "Ctrl-C" in line:
                    break
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=60)
        finally:
            running.kill()
    assert running.returncode == 0, err
    assert "servo tick" in out and "Traceback" not in err


def test_a_check_measures_what_was_granted() -> None:
    found = run_json("feel", "--check", "--seconds", "1.5", "--preset", "desktop_6dof")
    assert found["fault"] == ""
    # On a machine that is busy the servo may run slowly, and is granted less meanwhile.
    granted = found["granted"]["stiffness_n_per_m"]
    assert granted > 1000.0 and 0.0 < found["felt_n_per_m"] < 1.05 * granted
    assert found["limits"][0].startswith("stiffness 1,920 N/m instead of 6,000: what the damping of")
    assert 0.0 < found["largest_force_n"] <= 12.0 and found["servo_hz"] > 0.0 and found["poses_hz"] > 0.0
    # Steps of 10 um, and little else.
    assert 1e-6 < found["noise_m"] < 2e-5


def test_stiffness_rate_and_noise_of_known_ticks() -> None:
    """A handle with steps of 10 um and 500 poses a second, on a plate of 1,500 N/m, without a clock."""
    hand_s, hand = feel_check.pressing_hand()
    times = np.arange(3000) / 1000.0
    exact = 0.002 + np.interp((np.arange(3000) // 2) / 500.0, hand_s, hand[:, 2, 3])
    height = np.round(exact, 5)
    depth = np.maximum(-height, 0.0)
    modes = np.where(depth > 0.0, "contact", "free")
    force = np.minimum(1500.0 * depth, 8.0)
    force[modes == "free"] = 100.0  # Nothing in the air counts.
    ticks = feel_check.Ticks(times, height, np.maximum(height, 0.0), force, modes, np.ones(3000, bool))
    assert ticks.felt(8.0) == pytest.approx(1500.0, rel=1e-9)
    assert 450.0 < ticks.poses_hz() <= 510.0
    still = ticks._replace(device=np.random.default_rng(0).normal(0.01, 5e-6, 3000), modes=np.full(3000, "free"))
    assert still.noise_m() == pytest.approx(5e-6, rel=0.05)
    assert np.isnan(ticks._replace(modes=np.full(3000, "free")).felt(8.0))


def test_people_get_the_checks_table() -> None:
    out = run("feel", "--check", "--seconds", "1.5").stdout
    for word in (
        "a plate is 2 mm below",
        "stiffness",
        "N/m measured",
        "instead of 30,000",
        "jitter",
        "p99",
        "um in the air",
    ):
        assert word in out, out


def test_a_check_brings_its_own_plate(files: tuple[Path, Path]) -> None:
    assert "leave out the mock-up" in error_of("feel", files[0], "--check")
    for more in (("--pose", "nowhere.csv"), ("--without", "pump"), ("--unit", "mm"), ("--up", "z"), ("--seed", "3")):
        assert f"leave out {more[0]}" in error_of("feel", "--check", *more)


def eventually(ask: Callable[[], bool]) -> bool:
    """Whether something is so at last: a check takes seconds of a clock, which a busy machine may not give it."""
    return any(ask() for _ in range(6))


def test_a_soft_plate_is_felt() -> None:
    """It gives less than 2 % of the largest force of the device."""

    def is_felt() -> bool:
        device = devices.Simulated("large_6dof", hand=feel_check.pressing_hand())
        found = feel_check.check(device, 1.5, stiffness=100.0)
        return found.fault == "" and abs(found.felt_n_per_m - 100.0) <= 5.0

    assert eventually(is_felt)


def test_the_scale_divides_the_stiffness_of_the_tool() -> None:
    def is_divided() -> bool:
        one, three = (
            feel_check.check(devices.Simulated("desktop_6dof", hand=feel_check.pressing_hand()), 1.5, scale=scale)
            for scale in (1.0, 3.0)
        )
        is_less = three.granted.stiffness_n_per_m < 0.6 * one.granted.stiffness_n_per_m
        return bool(is_less and np.isfinite(three.felt_n_per_m) and three.noise_m < 2e-5)

    assert eventually(is_divided)


@pytest.mark.parametrize("rate_hz", [1000, 250, 100, 60])
@pytest.mark.parametrize("noise_m", [0.0, 2e-5])
def test_the_motion_of_the_hand_is_no_noise(rate_hz: int, noise_m: float) -> None:
    """A device slower than the servo, without a clock: its poses are held for some ticks."""
    times = np.arange(8000) / 1000.0
    sample = (np.arange(8000) * rate_hz) // 1000
    noise = np.random.default_rng(1).normal(0.0, noise_m, 8000)[sample]
    height = 0.01 - 0.006 * (1.0 - np.cos(2.0 * np.pi * sample / rate_hz)) + noise
    n = len(times)
    ticks = feel_check.Ticks(times, height, height, np.zeros(n), np.full(n, "free"), np.ones(n, bool))
    assert ticks.noise_m() == pytest.approx(noise_m, rel=0.15, abs=2e-7)


def test_bursts_are_not_the_rate() -> None:
    times = np.arange(4000) / 1000.0
    tick = np.arange(4000)
    sample = np.where(tick % 200 < 40, tick, tick - tick % 200 + 39)
    height = 0.01 - 0.006 * (1.0 - np.cos(2.0 * np.pi * sample / 1000.0))
    ticks = feel_check.Ticks(times, height, height, np.zeros(4000), np.full(4000, "free"), np.ones(4000, bool))
    assert ticks.poses_hz() == pytest.approx(200.0, rel=0.25) and ticks.burst_hz() > 380.0


@pytest.mark.parametrize(
    ("felt", "said"), [(300.0, "but 300 were measured"), (np.nan, "pressed too little"), (1900.0, "^$")]
)
def test_what_is_felt_is_judged(felt: float, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feel_check.Ticks, "felt", lambda ticks, most: felt)

    def is_said() -> bool:
        found = feel_check.check(devices.Simulated("desktop_6dof", hand=feel_check.pressing_hand()), 1.0)
        return re.search(said, found.fault) is not None

    assert eventually(is_said)


@pytest.mark.parametrize(
    ("fault", "said"),
    [("lost", "does not answer \\(.* it is pulled out"), ("silent", "does not answer|answered in")],
)
def test_a_device_that_does_not_answer_is_said(fault: str, said: str) -> None:
    device = devices.Simulated("desktop_3dof", hand=feel_check.pressing_hand(), fault=(fault, 0.0, 0.0, 1e9))
    # A silent one has told one pose, which is believed for 50 ms.
    found = feel_check.check(device, 1.5)
    assert re.search(said, found.fault), found.fault


def test_a_device_without_force_is_said() -> None:
    for device in (devices.Mouse(np.eye(4)), _Weak()):
        found = feel_check.check(device, 0.3)
        assert "gives no force" in found.fault, found.fault


def test_a_plate_that_nobody_presses_is_said() -> None:
    found = feel_check.check(devices.Simulated("desktop_3dof"), 0.3)
    assert "press the handle" in found.fault and not np.isfinite(found.felt_n_per_m)


def test_what_is_wrong_is_the_exit_status(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(devices, "open_device", lambda name, **options: devices.Mouse(np.eye(4)))
    with pytest.raises(SystemExit) as ended:
        app(["feel", "--check", "--device", "spacemouse"])
    assert ended.value.code == 1
    assert "gives no force" in capsys.readouterr().out


class _Weak(devices.Own):
    """Without a motor."""

    info = devices.Info("weak", force_n=0.0)

    def read(self) -> np.ndarray:
        return np.zeros(3)

    def write(self, force: np.ndarray, torque: np.ndarray) -> None:
        pass
