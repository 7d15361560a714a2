"""The tables of a run, as Markdown: the scorecard, the page's drawing rates, its weight and its robustness."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pages import markdown
from section import Result, Section, busy, scorecard_table

from . import goals


def tables(result: Result) -> dict[str, str]:
    """All tables, one behind the other, as the page has them."""
    core = "on any core" if result["core"] is None else "on one core"
    made = [
        SECTION.origin(result, result["browser"], f"SwiftShader {core}", *busy(result)),
        scorecard_table(["mock-up, experiment", "goal", "at most", "found"], 2, goals.scorecard(result)),
        drawing(result),
        standing(result),
    ]
    return {"figures": "\n\n".join(made)}


def drawing(result: Result) -> str:
    """Drawing of the page, at each size of the picture."""
    lines = []
    for mockup, experiments in result["mockups"].items():
        for name in ("large", "small", "parts"):
            found = experiments.get(name)
            if found is not None and "failed" not in found:
                lines += [[mockup, _size(found["page"]), *line] for line in _drawn(found["page"])]
    return markdown(["mock-up", "picture", "what", "p50", "p99", "draw calls"], 3, lines)


def _size(page: Mapping[str, Any]) -> str:
    return f"{page['width']}x{page['height']}"


def _drawn(page: Mapping[str, Any]) -> Iterator[list[str]]:
    for name, what in (("camera", "camera moving"), ("tool", "tool moving")):
        if page[name] is not None:
            rate = f"{what}, {page[name]['frames_per_s']:.1f} frames/s: frame to frame"
            yield [rate, *_spread(page[name]["interval_ms"]), ""]
    if page["tool"] is not None:
        yield ["input to drawn", *_spread(page["tool"]["input_to_drawn_ms"]), ""]
        yield ["engine", *_spread(page["tool"]["engine_us"], "us"), ""]
    for name, what in (
        ("tool_frame", "a frame of the tool"),
        ("camera_frame", "a frame of the camera"),
        ("section_frame", "a frame of a section dragged"),
        ("whole_frame", "a frame of everything"),
    ):
        if page[name] is not None:
            yield [what, *_spread(page[name]), str(page[name]["calls"])]
    for name, what in (
        ("pick_ms", "part under the pointer"),
        ("hide_all_ms", "all parts hidden"),
        ("filter_all_ms", "all parts filtered"),
    ):
        yield [what, *_spread(page[name]), ""]


def _spread(spread: Mapping[str, Any], unit: str = "ms") -> list[str]:
    digits = 0 if unit == "us" else 1
    return [f"{spread['p50']:.{digits}f} {unit}", f"{spread['p99']:.{digits}f} {unit}"]


def standing(result: Result) -> str:
    """Sizes and endurance of the page and the engine."""
    lines = []
    for mockup, experiments in result["mockups"].items():
        for name, rows in (("large", _opening), ("page", _weight), ("soak", _soak), ("engine", _engine)):
            found = experiments.get(name)
            if found is not None and "failed" not in found:
                lines += [[mockup, *line] for line in rows(found)]
    return markdown(["mock-up", "what", "found"], 2, lines)


def _opening(found: Result) -> Iterator[list[str]]:
    yield ["read", f"{found['read_s']:.2f} s"]
    yield ["indexed", f"{found['index_s']:.2f} s"]
    for name in ("first", "whole"):
        seconds = found[f"{name}_picture_s"]
        yield [f"{name} picture, after that", "not seen" if seconds is None else f"{seconds:.2f} s"]


def _weight(found: Result) -> Iterator[list[str]]:
    stops = found["stops"]
    yield ["pieces", f"{found['pieces']}"]
    yield ["manifest", f"{found['manifest_bytes'] / 1e3:.0f} kB"]
    yield ["wire, bytes a triangle", f"{found['wire_bytes_per_triangle']:.2f}"]
    yield ["heap of the page, bytes a triangle", f"{found['heap_bytes_per_triangle']:.1f}"]
    yield ["opened again: processor time of the browser", f"{found['opening_cpu_s']:.2f} s"]
    yield ["tool moving: processor time of the browser a frame", f"{found['tool_cpu_ms']:.1f} ms"]
    yield ["in contact: input to drawn, p50 and p99", " and ".join(_spread(found["contact"]["input_to_drawn_ms"]))]
    yield ["in contact: engine, p50 and p99", " and ".join(_spread(found["contact"]["engine_us"], "us"))]
    speeds = ", ".join(f"{speed:g}" for speed in stops["speeds_m_per_s"])
    yield [f"stops at {speeds} m/s lie apart", f"{1e6 * stops['spread_m']:.3f} um"]


def _soak(found: Result) -> Iterator[list[str]]:
    yield [f"soak of {found['seconds'] / 60:.1f} minutes: frames a second", f"{found['frames_per_s']:.1f}"]
    yield ["soak: the page's heap grew by", f"{found['heap_growth_bytes'] / 1e6:.2f} MB"]
    yield ["soak: the server's memory grew by", f"{found['server_growth_bytes'] / 1e6:.2f} MB"]
    yield ["soak: wishes unanswered, at most", f"{found['most_unanswered']}"]


def _engine(found: Result) -> Iterator[list[str]]:
    yield ["outline of a section", f"{found['outline_ms']:.1f} ms"]
    yield ["a ray", f"{found['ray_us']:.1f} us"]
    left = found["page_left_out"]
    more = f", {left:,} triangles left out" if left else ""
    yield ["one file to send", f"{found['page_bytes'] / 1e6:.2f} MB{more}, opens in {found['page_opens_s']:.2f} s"]


SECTION = Section("workbench", "workbench-figures.md", list(goals.JUDGES), tables, goals.scorecard, "mockups")
