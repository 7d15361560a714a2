"""The output of `feeler view --benchmark`: the page's measurements, and their circumstances.

The page measures (see `viewer/src/app/benchmark.ts`) frames a second while the camera moves and while the tool moves,
the latency from input to picture, and the cost of single frames, picks and hiding everything. This module adds the
mock-up, the software and the times known only to the server.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any

import numpy as np

from feeler.errors import WorkbenchError

FILE = "feeler-benchmark.json"
"""The output file of `feeler view --benchmark`, in the current folder."""

Figures = dict[str, Any]


@dataclass(frozen=True)
class Opened:
    """Times of opening a mock-up. indexed_at: seconds since 1970, when it was read and indexed."""

    read_s: float
    index_s: float
    indexed_at: float


def report(figures: Figures, document: Mapping[str, Any], opened: Opened) -> dict[str, Any]:
    """The whole output, as JSON. figures: the page's; document: the session's, as JSON.

    "first_picture_s" and "whole_picture_s" are seconds from when the mock-up was indexed, or the page was opened,
    whichever was later, until the picture was drawn. Raises `WorkbenchError` for unexpected figures.
    """
    from feeler import __version__

    try:
        begun = max(opened.indexed_at, figures["opened_ms"] / 1e3)
        pictures = {
            name: None if figures[f"{name}_ms"] is None else figures[f"{name}_ms"] / 1e3 - begun
            for name in ("first_picture", "whole_picture")
        }
    except (KeyError, TypeError):
        raise WorkbenchError(
            "the page sent unexpected figures", "benchmark", "reload the page, and start again"
        ) from None
    mockup, tool = document["mockup"], document["tool"]
    return {
        "feeler": __version__,
        "numpy": np.__version__,
        "when": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "mockup": mockup["name"],
        "tool": None if tool is None else tool["name"],
        "read_s": opened.read_s,
        "index_s": opened.index_s,
        "first_picture_s": pictures["first_picture"],
        "whole_picture_s": pictures["whole_picture"],
        "page": figures,
    }


def rows(written: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of the printed lines. Raises `WorkbenchError` as `report` does."""
    page = written["page"]
    try:
        found = [
            ("renderer", str(page["renderer"])),
            ("picture", f"{page['width']} × {page['height']} pixels"),
            ("mock-up", f"{written['mockup']}, {page['triangles']:,} triangles, {page['parts']:,} parts"),
            ("read and indexed in", f"{written['read_s']:.2f} s, {written['index_s']:.2f} s"),
            ("first picture after", _s(written["first_picture_s"])),
            ("whole picture after", _s(written["whole_picture_s"])),
            ("camera moving", _motion(page["camera"])),
        ]
        if page["tool"] is not None:
            found += [
                ("tool moving", _motion(page["tool"])),
                ("input to drawn", _spread(page["tool"]["input_to_drawn_ms"])),
                ("engine", _spread(page["tool"]["engine_us"], "µs")),
                ("a frame of the tool", _cost(page["tool_frame"])),
            ]
        found += [
            ("a frame of the camera", _cost(page["camera_frame"])),
            ("a frame of everything", _cost(page["whole_frame"])),
            ("a frame of a section dragged", _cost(page["section_frame"])),
            ("which part is under the pointer", _spread(page["pick_ms"])),
            ("all parts hidden", _spread(page["hide_all_ms"])),
            ("all parts filtered", _spread(page["filter_all_ms"])),
        ]
    except (KeyError, TypeError, ValueError):
        raise WorkbenchError(
            "the page sent unexpected figures", "benchmark", "reload the page, and start again"
        ) from None
    return found


def _s(seconds: float | None) -> str:
    return "not seen" if seconds is None else f"{seconds:.2f} s"


def _motion(motion: Mapping[str, Any]) -> str:
    interval = motion["interval_ms"]
    return f"{motion['frames_per_s']:.1f} frames/s (p50 {interval['p50']:.1f} ms, p99 {interval['p99']:.1f} ms)"


def _spread(spread: Mapping[str, Any], unit: str = "ms") -> str:
    return f"p50 {spread['p50']:.1f} {unit}, p99 {spread['p99']:.1f} {unit}"


def _cost(cost: Mapping[str, Any]) -> str:
    return f"{_spread(cost)}, {cost['calls']} draw calls, {cost['triangles']:,} triangles"
