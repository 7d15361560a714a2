"""Ctrl-C and SIGTERM while work is spread over processes: it ends at once, with what is done, and leaves nothing."""

from __future__ import annotations

import gc
import glob
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import feeler
from feeler import stopping
from feeler.spreading import Interrupted, spread

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")

SPAWN = multiprocessing.get_context("spawn")
# Also where the shell that runs the tests ignores Ctrl-C.
HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
PROGRAM = [sys.executable, "-c", HEARS + "from feeler.__main__ import main; main()"]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("interrupted") / "gearbox.feeler"
    feeler.Scene(feeler.sample("gearbox", 40_000)).save(path)
    return path


def _of_group(group: int) -> list[int]:
    """The processes of a group that run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text(encoding="ascii").rpartition(")")[2].split()
        except OSError:
            continue  # it ended meanwhile
        if int(words[2]) == group and words[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def _until(is_true: Any, seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while not is_true() and time.monotonic() < until:
        time.sleep(0.02)
    assert is_true()


COMMANDS = {
    "each": ("remove", "--part", "*", "--each", "--rounds", "90", "--seconds", "900"),
    "order": ("remove", "--part", "*oil_pump/body", "--order", "--rounds", "50", "--seconds", "900"),
    "access": ("access", "--tool", "sample:hand", "--angles", "3600"),
}


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize(
    ("name", "after", "sent"),
    [
        ("each", 0.0, (signal.SIGINT, signal.SIGINT)),  # while the workers start
        ("each", 3.0, (signal.SIGINT, signal.SIGINT, signal.SIGINT)),
        ("order", 3.0, (signal.SIGTERM,)),
        ("access", 1.0, (signal.SIGINT,)),
    ],
)
def test_a_command_with_workers_ends_at_once(name: str, after: float, sent: tuple[int, ...], file: Path) -> None:
    command, *words = COMMANDS[name]
    process = subprocess.Popen(
        [*PROGRAM, command, str(file), *words, "--workers", "2"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        # The command, the process that watches over shared names, and a worker.
        _until(lambda: len(_of_group(process.pid)) >= 3)
        time.sleep(after)
        began = time.monotonic()
        for number in sent:
            os.killpg(process.pid, number)
            time.sleep(0.1)
        _, errors = process.communicate(timeout=60)
        took = time.monotonic() - began
        assert process.returncode == 130, errors
        assert errors.splitlines()[-1].startswith("feeler: interrupted"), errors
        assert "Traceback" not in errors and "leaked" not in errors and "Error" not in errors, errors
        assert took < 10.0, "a loaded machine takes seconds; the work itself, minutes"
        _until(lambda: not _of_group(process.pid), 30.0)
    finally:
        if _of_group(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_what_is_done_is_written(file: Path, tmp_path: Path) -> None:
    code = HEARS + (
        "import feeler\n"
        "from feeler.cli import workers\n"
        "from feeler.__main__ import main\n"
        "from feeler.plan import removals\n"
        "spread = removals.spread\n"
        "def heard_of(function, scene, shared, tasks, pool, heard):\n"
        "    def tell(done, stage):\n"
        "        heard(done, stage)\n"
        "        print('done', flush=True)\n"
        "    return spread(function, scene, shared, tasks, pool, tell)\n"
        "removals.spread = heard_of\n"
        "main()"
    )
    out, program = tmp_path / "rows.csv", [sys.executable, "-c", code]
    process = subprocess.Popen(
        [*program, "remove", file, "--part", "*retainer*", "--each", "--seconds", "1", "--workers", "1", "--csv", out],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "done\n"
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "interrupted: these are the results so far" in errors, errors
    assert 1 <= len(out.read_text(encoding="utf-8-sig").splitlines()) - 1 < 30


def waits(_scene: None, folder: str, task: int) -> int:
    """A task that reports progress for a minute, as long ones do; the first one is short."""
    Path(folder, f"began-{task}").touch()
    until = time.monotonic() + (60.0 if task else 0.0)
    while time.monotonic() < until:
        time.sleep(0.01)
        stopping.check_stop()
    return task


@pytest.mark.parametrize("kind", ["processes", "threads", "loky"])
def test_running_tasks_are_told_to_end(kind: str, tmp_path: Path) -> None:
    pool: Any
    if kind == "loky":
        pool = pytest.importorskip("loky").get_reusable_executor(max_workers=1)
    else:
        pool = ThreadPoolExecutor(1) if kind == "threads" else ProcessPoolExecutor(1, mp_context=SPAWN)

    def stop(done: int, _stage: str) -> None:
        _until((tmp_path / "began-1").exists)
        raise KeyboardInterrupt

    with pool:
        with pytest.raises(Interrupted) as caught:
            spread(waits, None, str(tmp_path), range(5), pool, stop)
        assert caught.value.results == {0: 0}
        began = time.monotonic()
    assert time.monotonic() - began < 30.0, "the task ran on"
    assert not (tmp_path / "began-4").exists()
    assert not glob.glob(os.path.join(tempfile.gettempdir(), "feeler-stop-*"))


def test_tasks_whose_answers_are_of_no_use_are_told_to_end(tmp_path: Path) -> None:
    with ProcessPoolExecutor(2, mp_context=SPAWN) as pool:
        assert spread(waits, None, str(tmp_path), range(2), pool, is_last=lambda _: True) == [0]
        began = time.monotonic()
    assert time.monotonic() - began < 30.0


@pytest.mark.parametrize(
    "call",
    [
        "feeler.removals(scene, rounds=900, seconds=900, executor=pool)",
        "feeler.access(scene, feeler.sample_tool('hand'), found, 1.0, 3600, executor=pool)",
        "feeler.clash_variants([scene.mockup] * 50, 0.1, executor=pool)",
        "feeler.removal_order(scene, '*oil_pump/body', rounds=900, seconds=900, executor=pool)",
    ],
)
def test_ctrl_c_in_a_script_does_not_wait_for_the_tasks(call: str, file: Path) -> None:
    """Each task would take minutes."""
    scene = feeler.open_scene(file)
    found = feeler.find_fasteners(scene.mockup)
    assert len(found)
    with ProcessPoolExecutor(1, mp_context=SPAWN) as pool:
        pool.submit(os.getpid).result()  # it has begun
        began = time.monotonic() + 2.0
        threading.Timer(2.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        callbacks, gc.callbacks[:] = gc.callbacks[:], []  # an interrupt that comes in one of them is lost
        try:
            with pytest.raises(KeyboardInterrupt):
                eval(call, {"feeler": feeler, "scene": scene, "found": found, "pool": pool})
        finally:
            gc.callbacks[:] = callbacks
            signal.signal(signal.SIGINT, before)
    assert time.monotonic() - began < 15.0


def test_ctrl_c_while_modules_are_imported_is_one_line(tmp_path: Path) -> None:
    slow = tmp_path / "slow"
    slow.mkdir()
    # The first module that the program imports beyond Python's own.
    (slow / "typer.py").write_text("import sys, time; print('begun', flush=True); time.sleep(60)")
    environment = {**os.environ, "PYTHONPATH": str(slow)}
    process = subprocess.Popen(
        [*PROGRAM, "--version"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=30)[1] == "feeler: interrupted\n"
    assert process.returncode == 130


def test_the_program_begins_where_ctrl_c_is_heard(root: Path) -> None:
    assert 'feeler = "feeler.__main__:main"' in (root / "pyproject.toml").read_text(encoding="utf-8")
