"""`feeler feel`: moves a tool through a mock-up with a haptic device, in real time, with a live table."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import DEVICE_DRIVERS, DEVICE_PRESETS, DeviceDriver, DevicePreset
from feeler.cli.app import command
from feeler.cli.inputs import (
    AsJson,
    Choice,
    MockupFilesOrSample,
    MockupUnit,
    Only,
    PartOption,
    Threads,
    ToolUnit,
    Up,
    Without,
    read_both,
)
from feeler.cli.options import Needs
from feeler.cli.values import COLLISION_RATE, SECONDS, SEED, SERVO_RATE, STIFFNESS, Number, Word
from feeler.errors import OptionError
from feeler.haptics import Coupling, Granted, Session, Statistics, Trace, View, devices
from feeler.progress import bar

if TYPE_CHECKING:
    from rich.console import Console, Group

Floats = npt.NDArray[np.float64]

_SAMPLE = "sample:engine"
_LOOKS_HZ = 10.0

# The simulated hand: poses of its path, number of repeats there and back, speed (of a working hand, metres a second),
# and the least time (seconds).
_POSES, _ROUNDS, _HAND_M_PER_S, _LEAST_WAY_S = 2000, 100, 0.15, 8.0
# Options of drivers that are text even if they read as a number (Haply's ids).
_TEXTS = ("address", "device", "device_id", "grip_id", "library", "preset", "socket")
# Duration of a check by default, seconds.
_CHECK_S = 8.0
# Without a known place: height above the mock-up at which the tool begins, and how far the hand presses down (metres).
_ABOVE_M, _PRESSED_M = 0.005, 0.02


@command(
    name="feel",
    examples="""
feeler feel --seconds 10
feeler feel --check --device haply --device-option force_n=3
feeler feel engine.step --tool wrench.stl --device haply --scale 3
feeler feel engine.step --part "*fuel pump*" --device spacemouse
feeler feel sample:turbine:1600000 --tool sample:wrench --seconds 20 --json
feeler feel --seconds 5 --record feel.npz
""",
)
def feel(
    mockup: MockupFilesOrSample = None,
    *,
    tool: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A file, or sample:NAME or sample:NAME:fine. Default: sample:wrench."),
    ] = None,
    part: PartOption = None,
    without: Without = None,
    only: Only = None,
    device: Annotated[
        str,
        typer.Option(metavar="DEVICE", help=f"The haptic device: simulated, {', '.join(DEVICE_DRIVERS)}."),
        Word(("simulated", *DEVICE_DRIVERS)),
    ] = "simulated",
    device_option: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="Option of the driver, such as force_n=4 or library=FILE. May be repeated."
        ),
    ] = None,
    preset: Annotated[
        str,
        typer.Option(metavar="PRESET", help=f"Preset of the simulated device: {', '.join(devices.PRESETS)}."),
        Word(tuple(devices.PRESETS)),
        Needs("--device simulated"),
    ] = "large_6dof",
    check: Annotated[
        bool,
        typer.Option("--check", help="Check a device: press it on a virtual plate, and measure the result."),
    ] = False,
    hz: Annotated[float, typer.Option(help="Rate of the servo loop, Hz."), SERVO_RATE] = 1000.0,
    collision_hz: Annotated[
        float | None,
        typer.Option(help="Rate of the search for contacts, Hz. Default: as fast as possible."),
        COLLISION_RATE,
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration. Default: until Ctrl-C."), SECONDS] = None,
    scale: Annotated[
        float, typer.Option(help="Travel of the tool for a metre of the handle."), Number(least=0.001, most=1000.0)
    ] = 1.0,
    pose: Annotated[Path | None, typer.Option(help="Start of the tool, world_from_tool. Default: outside.")] = None,
    stiffness: Annotated[
        float | None,
        typer.Option(help="Stiffness of the coupling, N/m. Default: the most that the device holds."),
        STIFFNESS,
    ] = None,
    seed: Annotated[
        int, typer.Option(help="Seed of the simulated hand's path."), SEED, Needs("--device simulated")
    ] = 0,
    record: Annotated[
        Path | None,
        typer.Option(help="Record the hand's motion and the results, step by step, for feeler.haptics.replay (.npz)."),
    ] = None,
    unit: MockupUnit = None,
    tool_unit: ToolUnit = None,
    up: Up = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Moves a tool with a haptic device, in real time: contact stops the tool, and the device returns the force.

    A servo loop and a search for contacts run in separate threads. Without a device, a simulated hand moves a simulated
    one: it comes from outside, pushes, works and leaves, repeatedly. Ctrl-C releases the force first. --check measures
    stiffness, rate, jitter and noise, and says what limits them. Exit status: 0, also after Ctrl-C; 1 a checked device
    gives no force, far less than granted, or does not answer; 2 bad input, or no device.
    """
    from feeler.cli import outputs

    if check:
        given = {
            "the mock-up": mockup,
            "--tool": tool,
            "--part": part,
            "--without": without,
            "--only": only,
            "--pose": pose,
            "--seed": seed,
            "--record": record,
            "--unit": unit,
            "--tool-unit": tool_unit,
            "--up": up,
            "--threads": threads,
        }
        if named := [name for name, value in given.items() if value]:
            raise OptionError(f"--check brings its own plate, tool and hand: leave out {', '.join(named)}")
    outputs.check_targets({"record": record}, {"record": (".npz",)}, mockup or ())
    # Before anything is loaded, so that a missing device is reported at once.
    options = _device_options(device, device_option or [])
    held: devices.Device | None = (
        None if device == "simulated" else devices.open_device(cast("DeviceDriver", device), **options)
    )
    if check:
        how = {"rate_hz": hz, "collision_hz": collision_hz, "scale": scale, "stiffness": stiffness}
        _press(held, check_word("--preset", preset, DEVICE_PRESETS), seconds, how, as_json)
        return
    moving = tool if tool is not None or part else "sample:wrench"
    world, probe = read_both(mockup or [_SAMPLE], unit, moving, tool_unit, up, part)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, tool=probe, threads=threads, progress=progress)
    scene = Choice(part, without, only).scene_of(scene)
    start, hand = _begin(scene, probe, pose, held is None, scale, seed)
    if held is None:
        held = devices.Simulated(check_word("--preset", preset, DEVICE_PRESETS), hand=hand)
    coupling = Coupling.for_device(held)
    if stiffness is not None:
        coupling = Coupling(**{**coupling.__dict__, "stiffness_n_per_m": stiffness})
    session = Session(scene, probe, coupling=coupling, collision_hz=collision_hz)
    begun = session.start(start)
    if not begun:
        outputs.warn("the tool starts inside a part: it can only leave the way it would have come in")
    session.run(held, rate_hz=hz, scale=scale)
    out = outputs.console()
    watched = _Watched(session, keeps=record is not None)
    try:
        granted = session.granted()
        if not as_json:
            _say_granted(out, held, granted)
        _watch(out, watched, seconds, is_live=not as_json and out.is_terminal)
        granted = session.granted()
    except KeyboardInterrupt:
        pass  # the force is released below, before anything else
    finally:
        stats = session.stop()
    assert stats is not None
    written = _write(record, watched, scene, probe, coupling, collision_hz)
    if as_json:
        outputs.print_json(_facts(watched, stats, held, granted, session.troubles, written))
        return
    out.print(_table(watched, stats))
    for trouble in session.troubles:
        outputs.warn(trouble)
    if written:
        outputs.say(out, f"record written to {written}")


def _device_options(device: str, given: list[str]) -> dict[str, float | str]:
    """NAME=VALUE of the command line; values become numbers if they read as one, unless the option is a text."""
    if given and device == "simulated":
        raise OptionError(
            "--device-option is for a driver, and the simulated device has none: use --preset or another --device"
        )
    options: dict[str, float | str] = {}
    for option in given:
        name, is_named, value = option.partition("=")
        if not (name and is_named):
            raise OptionError(f"--device-option is {option!r}: give NAME=VALUE")
        options[name] = value
        if name not in _TEXTS:
            with contextlib.suppress(ValueError):
                options[name] = float(value)
    return options


def _press(
    held: devices.Device | None,
    preset: DevicePreset,
    seconds: float | None,
    how: dict[str, Any],
    as_json: bool,
) -> None:
    """The check of a device; exits with status 1 if something is wrong with it."""
    from feeler.cli import feel_check, outputs
    from feeler.cli.app import FOUND

    out = outputs.console()
    device = devices.Simulated(preset, hand=feel_check.pressing_hand()) if held is None else held

    def begins() -> None:
        if not as_json:
            outputs.say(out, f"{device.name}: a plate is 2 mm below the handle")
            if held is not None:
                outputs.say(out, "Press the handle down onto it by a centimetre, and lift it again, several times")

    found = feel_check.check(device, seconds or _CHECK_S, begins=begins, **how)
    if as_json:
        from dataclasses import asdict

        outputs.print_json(asdict(found))
    else:
        feel_check.show(out, found)
    if found.fault:
        if not as_json:
            outputs.print_finding(out, found.fault)
        raise typer.Exit(FOUND)


def _begin(
    scene: feeler.Scene, probe: feeler.Tool, pose: Path | None, is_simulated: bool, scale: float, seed: int
) -> tuple[Floats, tuple[Floats, Floats] | None]:
    """The start of the tool, and the path of the simulated hand: times and poses of the handle."""
    from feeler.cli.inputs import read_poses

    above = _above(scene, probe)
    start = above if pose is None else read_poses(pose)[0]
    if not is_simulated:
        return start, None
    try:
        with bar("finding a way in") as progress:
            way = feeler.sample_path(scene, probe, _POSES, seed=seed, progress=progress)
    except OptionError:
        # There is no place where the tool just fits: press it on the mock-up from above.
        way = np.tile(above, (_POSES, 1, 1))
        way[:, 2, 3] -= _PRESSED_M * np.sin(np.linspace(0.0, np.pi, _POSES))
    if pose is None:
        start = way[0]
    # The same way there and back, repeatedly. The handle begins in the middle of its workspace.
    size = float(np.ptp(way[:, :3, 3], axis=0).max())
    handle = np.concatenate([way, way[::-1]])
    handle[:, :3, 3] = (handle[:, :3, 3] - 0.5 * (way[:, :3, 3].min(axis=0) + way[:, :3, 3].max(axis=0))) / scale
    lasts = 2.0 * max(_LEAST_WAY_S, size / _HAND_M_PER_S)
    times = np.linspace(0.0, lasts, len(handle), endpoint=False)
    return start, ((times + lasts * np.arange(_ROUNDS)[:, None]).ravel(), np.tile(handle, (_ROUNDS, 1, 1)))


def _above(scene: feeler.Scene, probe: feeler.Tool) -> Floats:
    """Upright, over the middle of the mock-up, a little above its box."""
    (low, high), (bottom, top) = scene.mockup.bounds, probe.bounds
    pose = np.eye(4)
    pose[:2, 3] = 0.5 * (low + high - bottom - top)[:2]
    pose[2, 3] = high[2] - bottom[2] + _ABOVE_M
    return pose


class _Watched:
    """Observations of a run."""

    def __init__(self, session: Session, keeps: bool) -> None:
        self.session = session
        self.traces: list[Trace] = []
        self.keeps = keeps
        self.most_n = 0.0
        self.touched: dict[int, int] = {}
        self.modes: dict[str, int] = {}
        self.view: View | None = None

    def look(self) -> None:
        """Samples the newest tick; never waits."""
        self.view = view = self.session.view()
        for part in np.unique(view.parts).tolist():
            self.touched[part] = self.touched.get(part, 0) + 1
        trace = self.session.trace()
        if len(trace):
            self.most_n = max(self.most_n, float(np.linalg.norm(trace.wrenches[:, :3], axis=1).max()))
        for mode in trace.modes:
            self.modes[mode] = self.modes.get(mode, 0) + 1
        if self.keeps:
            self.traces.append(trace)

    def names(self, parts: list[int]) -> list[str]:
        """Paths of parts."""
        paths = self.session.scene.mockup.part_paths
        return [paths[part] or f"part {part}" for part in parts]


def _watch(out: Console, watched: _Watched, seconds: float | None, is_live: bool) -> None:
    from rich.live import Live

    def loop(show: Any) -> None:
        until = None if seconds is None else time.monotonic() + seconds
        while watched.session.is_running:
            left = 1.0 if until is None else until - time.monotonic()
            time.sleep(max(0.0, min(1.0 / _LOOKS_HZ, left)))
            watched.look()
            show()
            if left <= 0:
                return

    if not is_live:
        loop(lambda: None)
        return
    with Live(console=out, refresh_per_second=_LOOKS_HZ, transient=True) as live:
        loop(lambda: live.update(_table(watched, watched.session.stats(), is_live=True)))


def _say_granted(out: Console, device: devices.Device, granted: Granted) -> None:
    from feeler.cli import outputs

    outputs.say(out, f"{device.name}; drives {' and '.join(device.driven) or 'nothing'}")
    for said in (
        granted.priority,
        granted.collision_priority and f"contacts: {granted.collision_priority}",
        granted.memory,
    ):
        if said:
            outputs.say(out, said[:1].upper() + said[1:])
    coupling = granted.coupling
    stiffness = f"{coupling.stiffness_n_per_m:,.0f} N/m and {coupling.rotational_stiffness_nm_per_rad:,.2f} Nm/rad"
    outputs.say(out, f"Coupling: {stiffness}")
    for limitation in granted.limitations:
        outputs.say(out, f"  {limitation}")
    outputs.say(out, "Ctrl-C releases the force and ends")


def _table(watched: _Watched, stats: Statistics, is_live: bool = False) -> Group:
    """Rates, times, force and touched parts."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    from feeler.cli.outputs import duration

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("")
    for heading in ("median", "p99", "p99.9", "worst"):
        table.add_column(heading, justify="right", min_width=9)
    for name, spread in (
        ("servo tick", stats.servo_tick),
        ("servo lateness", stats.servo_lateness),
        ("collision tick", stats.collision_tick),
        ("age of contacts", stats.age),
    ):
        table.add_row(name, *(duration(value) for value in (spread.median, spread.p99, spread.p999, spread.max)))
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="cyan", no_wrap=True)
    grid.add_column(overflow="fold")
    able = 1.0 / stats.collision_tick.median if stats.collision_tick.median > 0 else 0.0
    rows = [
        ("rates", f"servo {stats.servo_hz:,.0f} Hz, collision {stats.collision_hz:,.0f} Hz (it could {able:,.0f})"),
        ("ticks", f"{stats.ticks:,}, missed {stats.misses:,}, in doubt {stats.doubts:,}"),
    ]
    view = watched.view
    if view is not None and is_live:
        rows.append(("force", f"{np.linalg.norm(view.force):5.2f} N, torque {np.linalg.norm(view.torque):6.3f} Nm"))
        rows.append(("mode", view.mode + (", clutched" if view.is_clutched else "")))
        touched = watched.names(np.unique(view.parts).tolist())
    else:
        rows.append(("force", f"at most {watched.most_n:.2f} N"))
        whole = max(1, sum(watched.modes.values()))
        shares = sorted(watched.modes.items(), key=lambda item: -item[1])
        rows.append(("modes", ", ".join(f"{mode} {100 * n / whole:.0f} %" for mode, n in shares)))
        touched = watched.names(sorted(watched.touched, key=lambda part: -watched.touched[part]))
    more = f" and {len(touched) - 6} more" if len(touched) > 6 else ""
    rows.append(("touched", ", ".join(touched[:6]) + more if touched else "nothing"))
    for name, value in rows:
        grid.add_row(Text(name), Text(value))
    return Group(table, grid)


def _facts(
    watched: _Watched,
    stats: Statistics,
    device: devices.Device,
    granted: Granted,
    troubles: list[str],
    written: str | None,
) -> dict[str, Any]:
    from dataclasses import asdict

    touched = sorted(watched.touched)
    return {
        "device": {"name": device.name, "driven": list(device.driven), **device.limits},
        "granted": {
            "priority": granted.has_priority,
            "priority_said": granted.priority,
            "collision_priority": granted.has_collision_priority,
            "collision_priority_said": granted.collision_priority,
            "memory_locked": granted.is_locked,
            "memory_said": granted.memory,
        },
        "coupling": {**asdict(granted.coupling), "limitations": granted.limitations},
        "stats_s": asdict(stats),
        "largest_force_n": watched.most_n,
        "ticks_by_mode": watched.modes,
        "touched": [{"part": part, "path": path} for part, path in zip(touched, watched.names(touched), strict=True)],
        "troubles": troubles,
        "written": written,
    }


def _write(
    record: Path | None,
    watched: _Watched,
    scene: feeler.Scene,
    probe: feeler.Tool,
    coupling: Coupling,
    collision_hz: float | None,
) -> str | None:
    """Replays the hand's motion in a second session with a recorder, and saves that record."""
    if record is None:
        return None
    traces = [trace for trace in watched.traces if len(trace)]
    if not traces:
        return None
    poses = np.concatenate([trace.world_from_device for trace in traces])
    times = np.concatenate([trace.times for trace in traces])
    session = Session(scene, probe, coupling=coupling, collision_hz=collision_hz)
    with session.record(record), bar("recording") as progress:
        session.start(poses[0])
        for n in range(1, len(poses)):
            session.step(poses[n], float(np.clip(times[n] - times[n - 1], 1e-5, 1.0)))
            if n % 100 == 0:
                progress(n / len(poses), "stepping")
    return str(record)
