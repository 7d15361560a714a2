"""The workbench measures itself: `feeler view --benchmark`, and the bench against its goals. Nothing here is timed."""

from __future__ import annotations

import importlib
import json
import subprocess
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PROGRAM, chromium
from chromium import FLAGS
from workbench_scene import Clock, at, cube, stand

import feeler
from feeler.errors import WorkbenchError
from feeler.workbench.net.outbox import MOST_STATES, Outbox
from feeler.workbench.session import benchmark
from feeler.workbench.session.session import Session

sync_api = pytest.importorskip("playwright.sync_api")

best = importlib.import_module("workbench.best")
experiments = importlib.import_module("workbench.experiments")
goals = importlib.import_module("workbench.goals")
pages = importlib.import_module("pages")
run = importlib.import_module("workbench.run")
tables = importlib.import_module("workbench.tables")
bench_stand = importlib.import_module("workbench.stand")

BEGIN, END = "<!-- workbench: figures -->", "<!-- end of workbench: figures -->"
OPENED = benchmark.Opened(read_s=1.5, index_s=0.5, indexed_at=1000.0)
DOCUMENT = {"mockup": {"name": "engine"}, "tool": {"name": "wrench"}}


def spread(p50: float, p99: float | None = None, count: int = 10) -> dict[str, float]:
    return {"count": count, "p50": p50, "p99": 2 * p50 if p99 is None else p99}


def cost(p50: float, calls: int = 4) -> dict[str, float]:
    return {**spread(p50), "calls": calls, "triangles": 1000}


def motion(frames_per_s: float) -> dict[str, Any]:
    timed = {"seconds": 2.0, "frames": int(2 * frames_per_s), "frames_per_s": frames_per_s}
    return {**timed, "interval_ms": spread(1000 / frames_per_s), "page_ms": spread(1.0)}


def tool_motion(frames_per_s: float, p50: float, p99: float) -> dict[str, Any]:
    answers = {"input_to_drawn_ms": spread(p50, p99), "engine_us": spread(200.0)}
    return {**motion(frames_per_s), **answers, "most_unanswered": 2, "blocked": 0.0}


def page(**others: Any) -> dict[str, Any]:
    return {
        **{"renderer": "a renderer", "browser": "a browser", "width": 640, "height": 360},
        **{"triangles": 1_600_000, "parts": 4316, "opened_ms": 999_000.0},
        **{"first_picture_ms": 1_000_500.0, "whole_picture_ms": 1_001_500.0},
        **{"camera": motion(30.0), "tool": tool_motion(60.0, 28.0, 33.0)},
        **{"camera_frame": cost(20.0), "tool_frame": cost(13.0), "whole_frame": cost(800.0, 18)},
        **{"section_frame": cost(25.0), "pick_ms": spread(0.3)},
        **{"hide_all_ms": spread(5.0), "filter_all_ms": spread(6.0)},
        **others,
    }


def written(**others: Any) -> dict[str, Any]:
    return benchmark.report(page(**others), DOCUMENT, OPENED)


def page_result() -> dict[str, Any]:
    return {
        **{"triangles": 1_600_000, "pieces": 14, "manifest_bytes": 700_000},
        **{"wire_bytes_per_triangle": 13.2, "heap_bytes_per_triangle": 18.0},
        **{"opening_cpu_s": 2.0, "tool_cpu_ms": 20.0, "free": tool_motion(60.0, 28.0, 33.0)},
        "contact": tool_motion(60.0, 29.0, 41.0),
        "stops": {"speeds_m_per_s": [0.01, 10.0], "heights_m": [0.5, 0.5], "spread_m": 2e-7},
        "reconnect": {"seconds": 0.7, "is_same": True},
        "lost_context_s": 1.5,
    }


def soak_result() -> dict[str, Any]:
    return {
        **{"seconds": 60.0, "frames_per_s": 60.0, "heap_growth_bytes": 100_000},
        **{"server_growth_bytes": 0, "most_unanswered": 2},
    }


def result() -> dict[str, Any]:
    sent = {
        **{"triangles": 1_600_000, "outline_ms": 50.0, "ray_us": 15.0},
        **{"page_bytes": 4_000_000, "page_left_out": 0, "page_written_s": 3.0, "page_opens_s": 1.8},
    }
    pictures = {"large": written(), "small": written(), "parts": written()}
    found = {**pictures, "page": page_result(), "engine": sent, "soak": soak_result()}
    return {
        **{"when": "2026-12-01T00:00:00+00:00", "commit": "0123456789", "dirty": False, "args": ["--quick"]},
        **{"is_quick": True, "machine": {"cpu": "a processor"}, "browser": "Chromium 1", "core": 1},
        **{"load_average": [0.5, 0.5, 0.5], "load_average_after": [1.5, 1.0, 1.0]},
        "bundle": {"files": 5, "gzipped_bytes": 220_000},
        "mockups": {"engine, 1.6M": found},
    }


def test_a_report_counts_from_the_later_of_indexed_and_opened() -> None:
    report = written()
    assert (report["first_picture_s"], report["whole_picture_s"]) == (0.5, 1.5)
    late = written(opened_ms=1_000_250.0)
    assert (late["first_picture_s"], late["whole_picture_s"]) == (0.25, 1.25)
    assert written(first_picture_ms=None)["first_picture_s"] is None
    assert (report["mockup"], report["tool"], report["read_s"]) == ("engine", "wrench", 1.5)
    facts = dict(benchmark.rows(report))
    assert facts["renderer"] == "a renderer" and facts["camera moving"].startswith("30.0 frames/s")
    assert facts["input to drawn"] == "p50 28.0 ms, p99 33.0 ms" and facts["first picture after"] == "0.50 s"
    assert "tool moving" not in dict(benchmark.rows(written(tool=None, tool_frame=None)))


@pytest.mark.parametrize("given", [{}, {"opened_ms": "x"}, {"opened_ms": 1.0, "first_picture_ms": 1.0}])
def test_figures_of_another_page_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(WorkbenchError, match="unexpected figures"):
        benchmark.report(given, DOCUMENT, OPENED)
    report = written()
    del report["page"]["whole_frame"]
    with pytest.raises(WorkbenchError, match="unexpected figures"):
        benchmark.rows(report)


def test_the_first_page_that_answers_counts_and_an_old_answer_does_not() -> None:
    with Session(has_threads=False) as session:
        told: list[dict[str, Any]] = []
        session.subscribe(told.append)
        first = session.benchmark()
        second = session.benchmark()
        assert [event["id"] for event in told if event["type"] == "benchmark"] == [1, 2]
        session.benchmarked(1, {"of": "the first"})
        session.benchmarked(2, {"of": "the second"})
        session.benchmarked(2, {"of": "another page"})
        assert second.result(0) == {"of": "the second"} and not first.done()


def test_the_goals_tell_met_from_missed() -> None:
    missed = [goal.goal for goal in goals.scorecard(result()) if not goal.is_met]
    assert missed == ["input to drawn, p99"]
    worse = deepcopy(result())
    found = worse["mockups"]["engine, 1.6M"]
    found["page"]["stops"]["spread_m"] = 1e-3
    found["page"]["reconnect"]["is_same"] = False
    found["page"]["heap_bytes_per_triangle"] = 21.0
    found["large"]["page"]["whole_frame"]["calls"] = 251
    found["large"]["whole_picture_s"] = None
    found["engine"] = {"failed": "Traceback\nValueError: no"}
    worse["bundle"]["gzipped_bytes"] = 250_001
    lines = [goal for goal in goals.scorecard(worse) if not goal.is_met and not goal.is_timed]
    assert [goal.goal for goal in lines] == [
        "draw calls, everything",
        "heap a triangle, bytes",
        "stops at 0.01, 10 m/s: apart",
        "document after the cut",
        "it runs",
        "bundle, gzipped",
    ]
    big = deepcopy(found["large"])
    big["page"]["triangles"], big["first_picture_s"] = 10_000_000, 1.9
    assert next(goal.is_met for goal in goals.JUDGES["large"](big))


def test_of_several_runs_each_figure_is_the_best() -> None:
    slow = written(pick_ms=spread(0.1), tool=tool_motion(20.0, 90.0, 100.0), first_picture_ms=1_000_900.0)
    chosen = best.best([slow, written()])
    assert chosen["runs"] == 2 and chosen["first_picture_s"] == 0.5
    assert chosen["page"]["pick_ms"]["p50"] == 0.1 and chosen["page"]["tool"]["input_to_drawn_ms"]["p99"] == 33.0
    assert slow["page"]["tool"]["frames_per_s"] == 20.0, "what was given is left alone"


def test_figures_are_filled_where_the_markers_are(tmp_path: Path, root: Path) -> None:
    text = f"# Workbench\n\n{BEGIN}\nwhat was here\n{END}\n\nThe end.\n"
    filled = tables.SECTION.filled(text, result())
    assert "what was here" not in filled and "| **41.0 ms** |" in filled and filled.endswith("The end.\n")
    assert tables.SECTION.filled(filled, result()) == filled
    assert tables.SECTION.filled("# Nothing\n", result()) == "# Nothing\n"
    with pytest.raises(pages.PageError, match="no end"):
        tables.SECTION.filled(text.replace(END, ""), result())
    record, there = tmp_path / "record.json", tmp_path / "page.md"
    record.write_text(json.dumps(result()))
    there.write_text(text)
    asked = [PROGRAM[0], root / "bench" / "workbench" / "figures.py", "--record", record, "--page", there]
    for extra, code in (["--check"], 1), ([], 0), (["--check"], 0):
        assert subprocess.run([*asked, *extra], capture_output=True, check=False).returncode == code
    assert there.read_text() == filled


def test_the_record_has_what_the_documentation_shows(root: Path) -> None:
    record, there = root / "bench" / "records" / "workbench.json", root / "docs" / "workbench-figures.md"
    if not (record.is_file() and there.is_file()):
        pytest.skip("no record of the workbench, or no page to show it")
    text = there.read_text(encoding="utf-8")
    assert tables.SECTION.filled(text, json.loads(record.read_text(encoding="utf-8"))) == text


def test_ten_thousand_boxes_are_ten_thousand_parts() -> None:
    mockup = experiments.boxes(250)
    assert (mockup.part_count, mockup.triangle_count) == (250, 3000)
    assert len({path.rsplit("/", 1)[0] for path in mockup.part_paths}) == 3
    assert not feeler.Scene(mockup).mockup.source.doubts


def test_a_soak_leaves_nothing_behind() -> None:
    """Ten thousand wishes in contact, and a page that is slow to acknowledge: by count, on a clock moved by hand."""
    clock = Clock()
    with Session(clock=clock, has_threads=False) as session:
        mockup = stand()
        session.open(mockup, feeler.Scene(mockup), cube(), pose=at(0.0, 0.0, 0.1))
        outbox, late, states, most = Outbox(), [], 0, 0
        events: list[dict[str, Any]] = []
        session.subscribe(lambda event: events.append(event))
        before = session.document()
        kept = session._history.undo_depth
        for k in range(10_000):
            clock.now += 1 / 60
            angle = 0.01 * k
            session.wish(at(0.1 * np.sin(angle), 0.1 * np.cos(angle), 0.02), k + 1, "api")
            session.engine.tick()
            snapshot = session.snapshot()
            assert snapshot is not None and snapshot.pose_seq == k + 1, "each wish is answered by the next tick"
            if outbox.wants_state(snapshot.number):
                outbox.sent_state(snapshot.number)
                late.append((k + 7, snapshot.number))
                states += 1
            most = max(most, len(late))
            while late and late[0][0] <= k:
                outbox.acknowledged(late.pop(0)[1])
        assert most == MOST_STATES and states > 1000
        assert session.snapshot() is not None and session.snapshot().blocked
        assert session.document() == before and session._history.undo_depth == kept, "moving alone is no change"
        assert [event["type"] for event in events] == ["impact"], "it stays in one contact"
        assert len(session.engine._touched) <= mockup.part_count
        assert session.engine._newest is None and session.engine._idle is None


def test_feeler_view_benchmark_writes_what_the_page_saw(tmp_path: Path) -> None:
    path = chromium()
    words = ["sample:engine:20000", "--tool", "sample:wrench", "--benchmark"]
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        with (
            bench_stand.viewing(*words, folder=tmp_path) as view,
            bench_stand.opened(browser, view.url, 320, 180),
        ):
            view.wait()
        browser.close()
    found = json.loads((tmp_path / benchmark.FILE).read_text(encoding="utf-8"))
    seen = found["page"]
    assert "SwiftShader" in seen["renderer"] and (seen["width"], seen["height"]) == (320, 180)
    assert seen["triangles"] == feeler.sample("engine", 20_000).triangle_count
    assert seen["camera"]["frames"] > 0 and seen["tool"]["frames"] > 0
    assert seen["tool"]["input_to_drawn_ms"]["count"] > 0 and seen["tool"]["engine_us"]["count"] > 0
    assert seen["whole_frame"]["triangles"] >= seen["triangles"] and seen["whole_frame"]["calls"] < 20
    # A kept mock-up is not drawn again: a frame of the tool is the tool and its ghost.
    assert seen["tool_frame"]["triangles"] < seen["triangles"] / 4
    assert 0.0 < found["first_picture_s"] <= found["whole_picture_s"]
    assert all(seen[name]["count"] > 0 for name in ("pick_ms", "hide_all_ms", "filter_all_ms", "section_frame"))
    assert found["read_s"] > 0.0 and (found["mockup"], found["tool"]) == ("engine", "wrench")


def test_the_bench_runs_on_a_small_mock_up(tmp_path: Path) -> None:
    chromium()
    asked = ["--quick", "--size", "20000", "--only", "page,soak", "--soak", "0", str(tmp_path)]
    assert run.main(asked) in (0, 1)
    found = json.loads((tmp_path / "workbench.json").read_text(encoding="utf-8"))
    (experiment,) = found["mockups"].values()
    page_found = experiment["page"]
    assert "failed" not in page_found, page_found
    assert page_found["stops"]["spread_m"] < 1e-6 and page_found["contact"]["blocked"] > 0.0
    assert page_found["reconnect"]["is_same"] and experiment["soak"]["most_unanswered"] >= 0
    assert 12.0 < page_found["wire_bytes_per_triangle"] < 16.0
    assert "input to drawn, p99" in (tmp_path / "tables.md").read_text(encoding="utf-8")
