"""The goals, and whether a run meets them. There are goals for times too, but no run fails because of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import section
from section import Goal, Result

BIG = 5_000_000  # triangles: from here on the goals of ten million count
FIRST_S, WHOLE_S = 0.7, 2.0
BIG_FIRST_S, BIG_WHOLE_S = 2.0, 6.0
WIRE_BYTES = 13.5  # a triangle; 13.2 of the sample engine, and what its pieces' edges share
HEAP_BYTES = 20.0
TOOL_FRAME_MS = 20.0
DRAW_CALLS = 250
INPUT_P50_MS, INPUT_P99_MS = 30.0, 40.0
ENGINE_P99_US = 1000.0
PICK_MS = 1.0
CHANGE_MS = 16.0
OUTLINE_MS = 100.0
RAY_US = 20.0
BUNDLE_BYTES = 250_000
PAGE_BYTES, PAGE_OPENS_S = 5_000_000, 2.0
STOP_SPREAD_M = 1e-6
RECONNECT_S, REBUILT_S = 1.0, 2.0
SOAK_BYTES = 10_000_000


def scorecard(found: Result) -> list[Goal]:
    """The goals of the experiments that ran: `found` has, by mock-up, experiments by name; and "bundle"."""
    goals = [
        replace(goal, experiment=f"{mockup}, {goal.experiment}")
        for mockup, experiments in found["mockups"].items()
        for goal in section.scorecard(JUDGES, experiments)
    ]
    size = found["bundle"]["gzipped_bytes"]
    return [*goals, Goal("page", "bundle, gzipped", "250 kB", f"{size / 1e3:.0f} kB", size <= BUNDLE_BYTES)]


def _timed(experiment: str, goal: str, most: float, found: float | None, unit: str, digits: int = 1) -> Goal:
    wanted = f"{most:g} {unit}"
    said = "not seen" if found is None else f"{found:.{digits}f} {unit}"
    return Goal(experiment, goal, wanted, said, found is not None and found <= most, True)


def _large(result: Result) -> Iterator[Goal]:
    page = result["page"]
    is_big = page["triangles"] >= BIG
    first, whole = (BIG_FIRST_S, BIG_WHOLE_S) if is_big else (FIRST_S, WHOLE_S)
    yield _timed("opening", "first picture", first, result["first_picture_s"], "s", 2)
    yield _timed("opening", "whole picture", whole, result["whole_picture_s"], "s", 2)
    calls = page["whole_frame"]["calls"]
    yield Goal("1280x720", "draw calls, everything", str(DRAW_CALLS), str(calls), calls <= DRAW_CALLS)
    if page["tool_frame"] is not None:
        yield _timed("1280x720", "a frame of the tool", TOOL_FRAME_MS, page["tool_frame"]["p50"], "ms")


def _small(result: Result) -> Iterator[Goal]:
    page = result["page"]
    if page["tool"] is not None:
        yield from _answers("640x360, free air", page["tool"])
    yield _timed("640x360", "part under the pointer", PICK_MS, page["pick_ms"]["p50"], "ms", 2)


def _answers(where: str, tool: Result) -> Iterator[Goal]:
    spread = tool["input_to_drawn_ms"]
    yield _timed(where, "input to drawn, p50", INPUT_P50_MS, spread["p50"], "ms")
    yield _timed(where, "input to drawn, p99", INPUT_P99_MS, spread["p99"], "ms")
    yield _timed(where, "engine, p99", ENGINE_P99_US, tool["engine_us"]["p99"], "us", 0)


def _parts(result: Result) -> Iterator[Goal]:
    page = result["page"]
    where = f"{page['parts']:,} parts"
    yield _timed(where, "hide all", CHANGE_MS, page["hide_all_ms"]["p50"], "ms")
    yield _timed(where, "filter all", CHANGE_MS, page["filter_all_ms"]["p50"], "ms")


def _page(result: Result) -> Iterator[Goal]:
    wire, heap = result["wire_bytes_per_triangle"], result["heap_bytes_per_triangle"]
    yield Goal("page", "bytes a triangle on the wire", f"{WIRE_BYTES:g}", f"{wire:.2f}", wire <= WIRE_BYTES)
    yield Goal("page", "heap a triangle, bytes", f"{HEAP_BYTES:g}", f"{heap:.1f}", heap <= HEAP_BYTES)
    yield from _answers("640x360, in contact", result["contact"])
    spread = result["stops"]["spread_m"]
    speeds = ", ".join(f"{speed:g}" for speed in result["stops"]["speeds_m_per_s"])
    met = spread <= STOP_SPREAD_M
    yield Goal("page", f"stops at {speeds} m/s: apart", "1 um", f"{1e6 * spread:.2f} um", met)
    again = result["reconnect"]
    yield _timed("page", "reconnected after a cut of 2 s", RECONNECT_S, again["seconds"], "s", 2)
    said = "the same" if again["is_same"] else "another"
    yield Goal("page", "document after the cut", "the same", said, again["is_same"])
    yield _timed("page", "lost context drawn anew", REBUILT_S, result["lost_context_s"], "s", 2)


def _soak(result: Result) -> Iterator[Goal]:
    grown = result["heap_growth_bytes"]
    what = f"heap grown in {result['seconds'] / 60:.1f} minutes"
    yield Goal("soak", what, f"{SOAK_BYTES / 1e6:g} MB", f"{grown / 1e6:.1f} MB", grown <= SOAK_BYTES)


def _engine(result: Result) -> Iterator[Goal]:
    yield _timed("engine", "outline of a section", OUTLINE_MS, result["outline_ms"], "ms")
    yield _timed("engine", "a ray", RAY_US, result["ray_us"], "us")
    if not result["page_left_out"]:
        size = result["page_bytes"]
        yield Goal("one file", "size", f"{PAGE_BYTES / 1e6:g} MB", f"{size / 1e6:.2f} MB", size <= PAGE_BYTES)
        yield _timed("one file", "opens in", PAGE_OPENS_S, result["page_opens_s"], "s", 2)


JUDGES: dict[str, Callable[[Result], Iterator[Goal]]] = {
    "large": _large,
    "small": _small,
    "parts": _parts,
    "page": _page,
    "engine": _engine,
    "soak": _soak,
}
