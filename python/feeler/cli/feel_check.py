"""`feeler feel --check`: the first test of a device. It presses on a virtual plate and measures the response."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

import feeler
from feeler.haptics import Coupling, Granted, Session, Statistics, devices

if TYPE_CHECKING:
    from rich.console import Console

Floats = npt.NDArray[np.float64]

# The target, a hard wall: full force at this depth, metres and radians.
_HARD_M, _HARD_RAD = 0.002, 0.05
# Height of the block above the plate at the start, and how far the simulated hand presses beyond the plate (metres).
_ABOVE_M, _PRESSED_M = 0.002, 0.012
# Duration of one press of the simulated hand, seconds, and the number of presses.
_PRESS_S, _PRESSES = 1.0, 100
_LOOKS_HZ = 20.0
# Shares of the reached and of the largest force between which the stiffness is measured: above noise, below saturation.
_FROM, _TO = 0.02, 0.9
# A measured stiffness below this share of the granted one is a fault.
_SHORT = 0.5
# Periods over which the device's poses are counted, seconds: for the mean, and for bursts.
_WINDOW_S, _BURST_S = 0.25, 0.1
# Poses in a row from which the noise is found, and the longest interval between two, in median ones.
_ROW, _GAP = 5, 3.0


@dataclass(frozen=True)
class Checked:
    """The results of a check."""

    device: str
    asked: Coupling
    """A hard wall."""
    granted: Coupling
    limits: tuple[str, ...]
    """Reductions because of the device, a sentence each."""
    felt_n_per_m: float
    """Measured stiffness: force over depth in the plate; NaN if it was not pressed."""
    largest_force_n: float
    servo_hz: float
    poses_hz: float
    """Mean rate of new poses from the device, while the handle moves."""
    burst_hz: float
    """Rate of new poses in the 0.1 s with the most."""
    device_hz: float
    """The device's nominal rate; 0: not known."""
    late_s: tuple[float, float]
    """Lateness of servo ticks: median and 99th percentile."""
    noise_m: float
    """Standard deviation of the handle's position in the air, steps included; NaN with too few poses."""
    resolution_m: float
    """The device's nominal resolution; 0: not known."""
    scale: float
    """Travel of the tool for a metre of the handle; the stiffnesses are those in the tool's world."""
    priority: str
    fault: str
    """The fault, in a sentence; empty: none."""


def block_and_plate(scale: float = 1.0) -> tuple[feeler.Scene, feeler.Tool, Floats]:
    """A plate of 0.4 m, or more if the hand's motion is enlarged, a block of 60 mm, and the block's start pose."""
    half = 0.2 * max(1.0, scale)
    plate = feeler.Scene(feeler.Mockup(*_cuboid((-half, -half, -0.02), (half, half, 0.0))))
    start = np.eye(4)
    start[2, 3] = 0.03 + _ABOVE_M * scale
    return plate, feeler.Tool(*_cuboid((-0.03,) * 3, (0.03,) * 3), "block"), start


def pressing_hand() -> tuple[Floats, Floats]:
    """Times and poses of the simulated hand: onto the plate and off it, repeatedly."""
    turns = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]
    once = np.tile(np.eye(4), (len(turns), 1, 1))
    once[:, 2, 3] = -0.5 * (1.0 - np.cos(turns)) * (_ABOVE_M + _PRESSED_M)
    times = (turns / (2.0 * np.pi) + np.arange(_PRESSES)[:, None]) * _PRESS_S
    return times.ravel(), np.tile(once, (_PRESSES, 1, 1))


def check(
    device: devices.Device,
    seconds: float,
    *,
    rate_hz: float = 1000.0,
    collision_hz: float | None = None,
    scale: float = 1.0,
    stiffness: float | None = None,
    begins: Callable[[], None] = lambda: None,
) -> Checked:
    """Runs with a device for some seconds and measures. begins: called when the plate can be pressed."""
    own, limits = Coupling.for_device(device), device.limits
    asked = replace(
        own,
        stiffness_n_per_m=limits["force_n"] / _HARD_M if stiffness is None else stiffness,
        rotational_stiffness_nm_per_rad=limits["torque_nm"] / _HARD_RAD,
    )
    nothing = Checked(
        device=device.name,
        asked=asked,
        granted=asked,
        limits=(),
        felt_n_per_m=np.nan,
        largest_force_n=0.0,
        servo_hz=0.0,
        poses_hz=0.0,
        burst_hz=0.0,
        device_hz=limits["rate_hz"],
        late_s=(np.nan, np.nan),
        noise_m=np.nan,
        resolution_m=limits["resolution_m"],
        scale=scale,
        priority="",
        fault="",
    )
    if "translation" not in device.driven or limits["force_n"] == 0.0:
        return replace(nothing, fault=f"{device.name} gives no force: it has no motors that this driver knows of")
    plate, block, start = block_and_plate(scale)
    session = Session(plate, block, coupling=asked, collision_hz=collision_hz)
    session.start(start)
    session.run(device, rate_hz=rate_hz, scale=scale)
    try:
        least = session.granted().coupling.stiffness_n_per_m
        begins()
        traces = []
        until = time.monotonic() + seconds
        while session.is_running and time.monotonic() < until:
            time.sleep(1.0 / _LOOKS_HZ)
            traces.append(session.trace())
            least = min(least, session.granted().coupling.stiffness_n_per_m)
        ran_on = session.is_running
        granted = session.granted()
    finally:
        stats = session.stop()
    assert stats is not None
    ticks = Ticks(
        np.concatenate([trace.times for trace in traces]),
        np.concatenate([trace.world_from_device[:, 2, 3] for trace in traces]),
        np.concatenate([trace.world_from_proxy[:, 2, 3] for trace in traces]),
        np.concatenate([trace.wrenches[:, 2] for trace in traces]),
        np.array([mode for trace in traces for mode in trace.modes]),
        np.concatenate([trace.has_device for trace in traces]),
    )
    return _measured(nothing, granted, least, stats, ticks, session.troubles, ran_on)


class Ticks(NamedTuple):
    """The ticks of a run, `(n,)` each: time (seconds), heights of handle and proxy, force upwards, mode, and whether
    the device answered."""

    times: Floats
    device: Floats
    proxy: Floats
    force: Floats
    modes: npt.NDArray[np.str_]
    told: npt.NDArray[np.bool_]

    def felt(self, max_force_n: float) -> float:
        """Stiffness, newtons per metre: force over depth in the plate; NaN if it was not pressed."""
        reached = min(self.pressed_n(), max_force_n)
        pressed = (self.modes == "contact") & (self.force > _FROM * reached) & (self.force < _TO * max_force_n)
        force, depth = self.force[pressed], (self.proxy - self.device)[pressed]
        return float((force * depth).sum() / (depth * depth).sum()) if len(force) > 20 else np.nan

    def pressed_n(self) -> float:
        """Largest force of the plate, newtons."""
        return float(self.force[self.modes == "contact"].max(initial=0.0))

    def poses_hz(self) -> float:
        """New poses per second while the handle is fast; when it is slow, one encoder step spans several poses."""
        if len(self.times) < 2:
            return 0.0
        edges = np.append(np.arange(self.times[0], self.times[-1], _WINDOW_S), self.times[-1])
        cuts = np.searchsorted(self.times, edges)
        pieces = [slice(low, high + 1) for low, high in itertools.pairwise(cuts) if high > low]
        ways = np.array([np.ptp(self.device[piece]) for piece in pieces])
        fast = [piece for piece, way in zip(pieces, ways, strict=True) if way > 0.5 * ways.max()]
        lasted = sum(float(np.ptp(self.times[piece])) for piece in fast)
        return sum(int((np.diff(self.device[piece]) != 0.0).sum()) for piece in fast) / lasted if lasted else 0.0

    def burst_hz(self) -> float:
        """New poses per second in the short period with the most."""
        moved = self.times[1:][np.diff(self.device) != 0.0]
        ends = np.searchsorted(moved, moved + _BURST_S)
        return float((ends - np.arange(len(moved))).max(initial=0) / _BURST_S)

    def noise_m(self) -> float:
        """Standard deviation of the position in the air; NaN with too few poses.

        From new poses only: a pose that is held for some ticks is one. What no cubic through the hand's motion explains
        is noise. A device samples at its own even times or when it is asked, and either time is wrong for the other, so
        the motion adds to one figure: the smaller one is the noise.
        """
        new = np.append(False, np.diff(self.device) != 0.0) & (self.modes == "free") & self.told
        if new.sum() <= _ROW:
            return np.nan
        rows = np.lib.stride_tricks.sliding_window_view
        times, heights = rows(self.times[new], _ROW), rows(self.device[new], _ROW)
        gaps = np.diff(times, axis=1)
        usual = np.median(gaps)
        near, even = (gaps < _GAP * usual).all(axis=1), (abs(gaps - usual) < 0.5 * usual).all(axis=1)
        both = [
            _unexplained(times[near] - times[near, :1], heights[near]),
            _unexplained(np.tile(np.arange(float(_ROW)), (int(even.sum()), 1)), heights[even]),
        ]
        return min((noise for noise in both if np.isfinite(noise)), default=np.nan)


def _unexplained(times: Floats, heights: Floats) -> float:
    """Standard deviation of heights `(n, k)` about polynomials of degree `k - 2` in time; NaN with too few."""
    if len(times) <= 20:
        return np.nan
    apart = times[:, :, None] - times[:, None, :] + np.eye(_ROW)
    # The weights of the divided difference of the highest order: 0 for every such polynomial.
    weights = 1.0 / apart.prod(axis=2)
    left = (weights * heights).sum(axis=1)
    return float(np.sqrt((left * left / (weights * weights).sum(axis=1)).mean()))


def _measured(
    nothing: Checked,
    granted: Granted,
    least: float,
    stats: Statistics,
    ticks: Ticks,
    troubles: list[str],
    ran_on: bool,
) -> Checked:
    coupling, name = granted.coupling, nothing.device
    felt = ticks.felt(coupling.max_force_n)
    why = f" ({troubles[0]})" if troubles else ""
    share = float(ticks.told.mean()) if len(ticks.told) else 0.0
    fault = ""
    if share == 0.0 or not ran_on:
        fault = f"{name} does not answer{why}: check its cable, its power and its maker's service, and run again"
    elif share < 0.9:
        fault = f"{name} answered in {100 * share:.0f} % of the ticks only{why}: check its cable"
    elif coupling.stiffness_n_per_m == 0.0 or coupling.max_force_n == 0.0:
        fault = f"{name} gives no force: {'; '.join(granted.limitations)}"
    elif ticks.pressed_n() == 0.0:
        fault = "the plate was not felt: run again, and press the handle straight down by a centimetre"
    elif not np.isfinite(felt):
        fault = "the plate was pressed too little to measure: run again, and press the handle down by a centimetre"
    elif felt < _SHORT * least:
        fault = (
            f"{name} was granted {least:,.0f} N/m, but {felt:,.0f} were measured: the force does not follow the "
            f"motion at a servo of {stats.servo_hz:,.0f} Hz; run again with a smaller --hz, on a machine at rest"
        )
    return replace(
        nothing,
        granted=coupling,
        limits=granted.limitations,
        felt_n_per_m=felt,
        largest_force_n=float(np.abs(ticks.force).max(initial=0.0)),
        servo_hz=stats.servo_hz,
        poses_hz=ticks.poses_hz(),
        burst_hz=ticks.burst_hz(),
        late_s=(stats.servo_lateness.median, stats.servo_lateness.p99),
        # Steps add their own; of poses that are each one step apart none would be seen.
        noise_m=float(np.maximum(ticks.noise_m() / nothing.scale, nothing.resolution_m / np.sqrt(12.0))),
        priority=granted.priority,
        fault=fault,
    )


def show(out: Console, found: Checked) -> None:
    """Prints the table."""
    from feeler.cli.outputs import duration, print_facts

    def limited(what: str) -> list[tuple[str, str]]:
        said = [("", limit) for limit in found.limits if limit.startswith(what)]
        return said or [("", "limited by nothing")]

    asked, granted = found.asked, found.granted
    felt = f"{found.felt_n_per_m:,.0f} N/m measured" if np.isfinite(found.felt_n_per_m) else "not measured"
    noise = f"{1e6 * found.noise_m:.1f} um in the air" if np.isfinite(found.noise_m) else "not measured"
    steps = f"{1e6 * found.resolution_m:.1f} um" if found.resolution_m > 0.0 else "not known"
    rows = [
        ("scale", f"{found.scale:g}: stiffness is the tool's; the hand feels it times this" * (found.scale != 1.0)),
        ("stiffness", f"{granted.stiffness_n_per_m:,.0f} N/m granted, {felt}"),
        *limited("stiffness"),
        ("force", f"{found.largest_force_n:.2f} N at most, {granted.max_force_n:.2f} N granted"),
    ]
    if asked.rotational_stiffness_nm_per_rad > 0.0:
        rows.append(("rotation", f"{granted.rotational_stiffness_nm_per_rad:,.2f} Nm/rad granted"))
        rows += limited("rotational stiffness")
    rows += [
        ("rate", f"servo {found.servo_hz:,.0f} Hz; the device sent {found.poses_hz:,.0f} new poses a second"),
        ("", f"in bursts of up to {found.burst_hz:,.0f} a second" if found.burst_hz > 2.0 * found.poses_hz else ""),
        ("", f"the device's own rate is {found.device_hz:,.0f} Hz" if found.device_hz > 0.0 else ""),
        ("jitter", f"ticks {duration(found.late_s[0])} late in the median, {duration(found.late_s[1])} at p99"),
        ("", found.priority),
        ("noise", f"position {noise}; steps of the device: {steps}"),
    ]
    print_facts(out, [(name, value) for name, value in rows if value])


def _cuboid(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[Floats, npt.NDArray[np.uint32]]:
    corners = np.array([[(high if i >> axis & 1 else low)[axis] for axis in range(3)] for i in range(8)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    return corners, np.array(faces, dtype=np.uint32)
