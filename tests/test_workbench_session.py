"""The session as a server and scripts see it: events, geometry, jobs, exports, threads, and the View."""

from __future__ import annotations

import base64
import csv
import io
import subprocess
import sys
import threading
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, SHEET, Bench, at, cube, stand

import feeler
from feeler.errors import LoadError, MeshError, OptionError, WorkbenchError
from feeler.io import write_glb
from feeler.workbench.document.finding_table import FindingTable
from feeler.workbench.engine import hand, measuring
from feeler.workbench.engine.engine import Engine
from feeler.workbench.session.events import MOST_KEPT
from feeler.workbench.session.jobs import JobCancelledError, Jobs
from feeler.workbench.session.record import read_record
from feeler.workbench.session.session import Session

WAIT_S = 60.0  # for a thread that is known to come


def test_before_a_mockup_is_open_it_says_how_far_it_is() -> None:
    with Session(has_threads=False) as session:
        events: list[dict] = []
        session.subscribe(events.append)
        session.loading("index", 0.5)
        assert session.document()["loading"] == {"stage": "index", "share": 0.5}
        session.failed("no such file")
        assert session.document()["failed"] == "no such file" and session.document()["loading"] is None
        assert [event["fields"] for event in events] == [
            {"loading": {"stage": "index", "share": 0.5}},
            {"loading": None, "failed": "no such file"},
        ]
        for ask in (session.manifest, lambda: session.piece(0), lambda: session.command("hide_all", {})):
            with pytest.raises(WorkbenchError, match="no mock-up is open"):
                ask()
    with pytest.raises(OptionError, match="do you mean mm"):
        Session(unit="mmm", has_threads=False)


def test_a_mockup_with_a_sample_tool_opens_without_making_sample_tools(monkeypatch: pytest.MonkeyPatch) -> None:
    wrench, mockup = feeler.sample_tool("wrench"), stand()

    def not_now(*_: object, **__: object) -> feeler.Tool:
        raise AssertionError("the first picture waits for seconds while the fine tool is made")

    monkeypatch.setattr(hand, "sample_tool", not_now)
    with Session(has_threads=False) as session:
        session.open(mockup, feeler.Scene(mockup), wrench)
        assert session.manifest()["triangles"] == mockup.triangle_count
    monkeypatch.undo()
    own = feeler.Tool(wrench.vertices * 1.01, wrench.faces, "wrench")
    for tools, is_built_in in ({}, True), ({"wrench": wrench}, True), ({"wrench": own}, False):
        assert ("wrench" in hand.Hands(feeler.Scene(mockup), tools).built_in()) == is_built_in


def test_a_mockup_is_called_as_its_file_or_as_what_all_its_parts_lie_in(tmp_path: Path) -> None:
    write_glb(tmp_path / "stand v2.glb", stand())
    shafts = stand(["gear/a", "gear/b", "gear/c/d", "gear/c/e", "gear"])
    for mockup, name in (
        (feeler.sample("differential", 10_000), "differential"),
        (feeler.load_mockup(tmp_path / "stand v2.glb"), "stand v2.glb"),
        (shafts, "gear"),
        (stand(), "arrays"),
    ):
        with Session(has_threads=False) as session:
            session.open(mockup, feeler.Scene(mockup), None)
            assert session.document()["mockup"]["name"] == session.manifest()["name"] == name
            session.open(mockup, feeler.Scene(mockup), None, name="mine")
            assert session.document()["mockup"]["name"] == "mine"


def test_closing_does_not_wait_for_what_the_first_answers_need(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    is_warming, goes_on = threading.Event(), threading.Event()

    def warm_up(engine: Engine) -> None:
        with engine.paused():
            is_warming.set()
            goes_on.wait(WAIT_S)

    monkeypatch.setattr(Engine, "warm_up", warm_up)
    mockup = stand()
    session = Session(record=tmp_path / "a.jsonl")
    opening = threading.Thread(target=session.open, args=(mockup, feeler.Scene(mockup), cube()))
    opening.start()
    assert is_warming.wait(WAIT_S)
    closing = threading.Thread(target=session.close, daemon=True)
    closing.start()
    closing.join(WAIT_S / 2)
    is_closed = not closing.is_alive()
    goes_on.set()
    opening.join(WAIT_S)
    assert is_closed
    assert not read_record(tmp_path / "a.jsonl").is_torn


def test_events_are_numbered_and_kept_for_those_who_come_back() -> None:
    bench = Bench(cube())
    last = bench.session.last_event
    assert [event["n"] for event in bench.events] == list(range(1, last + 1))
    bench.command("hide", parts=[PEG])
    bench.command("show", parts=[PEG])
    missed = bench.session.events_since(last)
    assert [event["command"] for event in missed] == ["hide", "show"]
    assert bench.session.events_since(bench.session.last_event) == []
    assert bench.session.events_since(bench.session.last_event + 1) is None, "of another session"
    document, number = bench.session.document_and_event()
    assert document == bench.document and number == bench.session.last_event
    for _ in range(MOST_KEPT):
        bench.session.tell({"type": "notice", "level": "info", "text": "again"})
    assert bench.session.events_since(last) is None
    assert len(bench.session.events_since(bench.session.last_event - MOST_KEPT)) == MOST_KEPT


def test_a_listener_that_left_is_told_nothing() -> None:
    bench = Bench(cube())
    told: list[dict] = []
    end = bench.session.subscribe(told.append)
    bench.command("hide_all")
    end()
    bench.command("show_all")
    assert [event["command"] for event in told] == ["hide_all"]


def test_the_page_gets_the_colours_that_the_mockup_states() -> None:
    assert Bench().session.manifest()["parts"]["colours"] == [], "none is stated"
    mockup = stand()
    nan = float("nan")
    mockup.part_colours = np.array([[1, 0.5, 0], [nan] * 3, [1, 0, 0.25], [nan] * 3, [0.2, 0.4, 0.6]])
    colours = [0xFF8000, -1, 0xFF0040, -1, 0x336699]
    made = Bench(mockup=mockup)
    assert made.session.manifest()["parts"]["colours"] == colours
    plain = Bench(mockup=stand())
    assert made.document["mockup"] == plain.document["mockup"], "records of it replay with and without colours"
    left_out = Bench(mockup=mockup, absent=[PLATE]).session.manifest()
    assert left_out["parts"]["colours"] == [-1, *colours[1:]], "nothing of a part that was left out is sent"


def test_geometry_is_the_mockup_in_pieces() -> None:
    bench = Bench(cube())
    manifest = bench.session.manifest()
    assert manifest["hash"] == bench.document["mockup"]["hash"] and manifest["parts"]["paths"] == PATHS
    assert manifest["triangles"] == 50 == sum(piece["triangles"] for piece in manifest["pieces"])
    found = []
    for number, piece in enumerate(manifest["pieces"]):
        data = bench.session.piece(number)
        assert len(data) == piece["bytes"]
        v, t = piece["vertices"], piece["triangles"]
        positions = np.frombuffer(data, "<f4", 3 * v).reshape(-1, 3) + manifest["middle"]
        start = 12 * v + -(-2 * v // 4) * 4
        found.append(positions[np.frombuffer(data, "<u2", 3 * t, start).reshape(-1, 3)])
    corners = np.concatenate(found)
    places = bench.session.snapshot().places
    np.testing.assert_allclose(corners[places], bench.mockup.vertices[bench.mockup.faces], atol=1e-6)
    with pytest.raises(WorkbenchError, match="no piece 99"):
        bench.session.piece(99)
    held = bench.of_type("held")[-1]
    assert len(bench.session.held(held["version"])) == sum(piece["bytes"] for piece in held["manifest"]["pieces"])
    assert bench.session.held_manifest(held["version"]) == held["manifest"] and bench.session.held_manifest(0) is None
    with pytest.raises(WorkbenchError, match="no version 12"):
        bench.session.held(12)


def test_the_held_version_is_that_of_its_content() -> None:
    bench = Bench(cube())
    first = bench.document["held_version"]
    bench.command("grip", parts=[PEG])
    second = bench.document["held_version"]
    data = bench.session.held(second)
    bench.command("undo")
    assert bench.document["held_version"] == first != second
    bench.command("redo")
    assert bench.document["held_version"] == second and bench.session.held(second) == data


needs_rays = pytest.mark.skipif(not hasattr(feeler.Scene, "rays"), reason="the core has no rays")


@needs_rays
def test_a_ray_meets_what_is_in_sight() -> None:
    bench = Bench(cube())

    def ray(origin: list[float], direction: list[float]) -> Any:
        return bench.session.ask("ray", {"origin": origin, "direction": direction})

    down = ([0.3, 0.0, 1.0], [0, 0, -2])
    hit = ray(*down)
    assert hit["part"] == SHEET and hit["distance"] == pytest.approx(0.5) and hit["normal"] == [0, 0, 1]
    bench.command("hide", parts=[SHEET])
    hit = ray(*down)
    assert hit["part"] == RIGHT and hit["point"] == pytest.approx([0.3, 0.0, 0.25])
    assert bench.mockup.part_of_face[hit["triangle"]] == RIGHT
    bench.command("section_add", normal=[0, 0, -1], offset=-0.125)
    fill = ray(*down)
    assert fill["point"] == pytest.approx([0.3, 0.0, 0.125]), "what is cut away is not met, but the fill of the cut"
    assert fill["part"] == RIGHT and fill["triangle"] == -1
    assert ray([0.1, 0.1, 1.0], [0, 0, -1])["point"][2] == 0.0, "where nothing is cut, it is the first face"
    within = {"origin": [0.252, 0.0, 1.0], "direction": [0, 0, -1]}
    snapped = bench.session.ask("snap", within)
    assert snapped["type"] == "edge" and snapped["point"] == pytest.approx([0.25, 0.0, 0.125])
    assert np.array(snapped["corners"])[:, 2] == pytest.approx([0.125] * 3), "the outline of the cut"
    snapped = bench.session.ask("snap", {**within, "origin": [0.3, 0.0, 1.0]})
    assert snapped["type"] == "face" and snapped["point"] == pytest.approx([0.3, 0.0, 0.125])
    # The other cut bounds the first one's outline.
    bench.command("section_add", normal=[1, 0, 0], offset=0.3)
    snapped = bench.session.ask("snap", {**within, "origin": [0.302, 0.0, 1.0]})
    assert snapped["type"] == "face" and snapped["corners"][0][0] >= 0.3
    bench.command("undo")
    bench.command("undo")
    assert ray([0, 0, 1], [0, 0, 1]) is None
    snapped = bench.session.ask("snap", {"origin": [0.252, 0.0, 1.0], "direction": [0, 0, -1]})
    assert snapped["type"] == "edge" and snapped["point"] == pytest.approx([0.25, 0.0, 0.25])
    snapped = bench.session.ask("snap", {"origin": [0.252, -0.0615, 1.0], "direction": [0, 0, -1]})
    assert snapped["type"] == "vertex" and snapped["point"] == [0.25, -0.0625, 0.25]
    snapped = bench.session.ask("snap", {"origin": [0.3, -0.01, 1.0], "direction": [0, 0, -1], "within": 1e-4})
    assert snapped["type"] == "face" and snapped["point"] == pytest.approx([0.3, -0.01, 0.25])


@needs_rays
def test_a_ray_meets_a_part_where_it_was_put_down() -> None:
    bench = Bench(None)
    bench.command("hide", parts=[SHEET])
    bench.command("grip", parts=[PEG])
    held = {"origin": [0.0, 0.28, 1.0], "direction": [0, 0, -1]}
    assert bench.session.ask("ray", held)["part"] == PLATE, "what the hand holds is not in the scene"
    bench.command("place", pose=at(0.0, 0.28, 0.3).ravel().tolist())
    bench.command("place", pose=at(0.1, 0.28, 0.3).ravel().tolist())
    bench.command("release")
    hit = bench.session.ask("ray", {"origin": [0.1, 0.28, 1.0], "direction": [0, 0, -1]})
    assert hit["part"] == PEG and bench.mockup.part_of_face[hit["triangle"]] == PEG
    bench.command("hide", parts=[PEG])
    assert bench.session.ask("ray", {"origin": [0.1, 0.28, 1.0], "direction": [0, 0, -1]})["part"] == PLATE


def test_a_part_that_was_put_down_keeps_its_colour_in_pictures() -> None:
    mockup = stand()
    mockup.part_colours = np.eye(5, 3)
    bench = Bench(None, mockup=mockup)
    bench.command("grip", parts=[LEFT])
    bench.command("place", pose=at(0.1, 0.28, 0.3).ravel().tolist())
    bench.command("release")
    (lying,) = bench.session.put_down()
    assert np.array_equal(lying.part_colours, [[0, 1, 0]])


@needs_rays
def test_outlines_of_sections() -> None:
    bench = Bench(None)
    bench.command("section_add", normal=[0, 0, 1], offset=0.1)
    result = bench.session.job("outline", {}).result(WAIT_S)
    segments = np.frombuffer(base64.b64decode(result["segments"]), "<f4").reshape(-1, 2, 3)
    parts = np.frombuffer(base64.b64decode(result["parts"]), "<u4")
    assert result["count"] == len(segments) == len(parts) and set(parts.tolist()) == {LEFT, RIGHT, PEG}
    np.testing.assert_allclose(segments[:, :, 2], 0.1)
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    assert lengths[parts == PEG].sum() == pytest.approx(4 * 0.0625)
    bench.session.close()


def test_an_outline_ends_where_another_section_cuts() -> None:
    segments = np.array(
        [[[-1.0, 0, 0], [1, 0, 0]], [[-2, 1, 0], [-1, 1, 0]], [[1, 2, 0], [0.5, 2, 0]], [[3, 0, 0], [-1, 0, 0]]]
    )
    kept, parts = measuring.clipped(segments, [4, 5, 6, 7], [((1.0, 0.0, 0.0), 0.25), ((-1.0, 0.0, 0.0), -2.0)])
    assert parts == [4, 6, 7]
    np.testing.assert_allclose(kept[:, :, 0], [[0.25, 1], [1, 0.5], [2, 0.25]])
    kept, parts = measuring.clipped(segments[:0], [], [((1.0, 0.0, 0.0), 0.25)])
    assert kept.shape == (0, 2, 3) and parts == []


def test_part_and_measure_answer_without_a_change() -> None:
    bench = Bench(cube())
    before = bench.session.current
    facts = bench.session.ask("part", {"part": "stand/peg"})
    assert facts["path"] == "stand/peg" and facts["triangles"] == 12 and facts["state"] == "in place"
    assert facts["lower"] == [-0.03125, 0.25, 0.0]
    found = bench.session.ask("measure", {"type": "parts", "parts": [LEFT, RIGHT]})
    assert found["value"] == 0.5 and found["is_exact"]
    planes = [int(np.flatnonzero(bench.mockup.part_of_face == LEFT)[i]) for i in (0, 2)]
    right_angle = bench.session.ask("measure", {"type": "angle", "triangles": [0, 8]})
    assert right_angle["unit"] == "rad" and right_angle["value"] in (0.0, pytest.approx(np.pi / 2))
    assert bench.session.ask("measure", {"type": "angle", "triangles": planes})["value"] == 0.0
    assert bench.session.current is before
    with pytest.raises(WorkbenchError, match="do you mean part"):
        bench.session.ask("parts", {})


def removed(bench: Bench) -> None:
    bench.command("grip", parts=[PEG])
    start = bench.pose
    bench.drag(start @ at(0, 0, 0.3), 1.0)
    bench.drag(start @ at(0.2, 0, 0.3), 1.0)
    bench.command("release")


def test_the_sequence_is_renamed_reordered_and_removed() -> None:
    bench = Bench(None)
    removed(bench)
    bench.command("grip", parts=[RIGHT])
    bench.drag(bench.pose @ at(0, 0, 0.1), 1.0)
    bench.command("release")
    first, second = (line["id"] for line in bench.document["sequence"])
    bench.command("sequence_rename", id=first, name="=pull the peg")
    bench.command("sequence_move", id=first, index=1)
    assert [line["name"] for line in bench.document["sequence"]] == ["right", "=pull the peg"]
    bench.command("sequence_remove", id=second)
    assert [line["id"] for line in bench.document["sequence"]] == [first]
    bench.session.close()


def test_the_sequence_as_csv_html_and_film() -> None:
    bench = Bench(None)
    removed(bench)
    bench.command("sequence_rename", id=bench.document["sequence"][0]["id"], name="=pull <b>")
    stages: list[tuple[float, str]] = []
    for job in ("export_csv", "export_html", "export_glb"):
        result = bench.session.job(job, {}, lambda share, stage: stages.append((share, stage))).result(WAIT_S)
        assert len(bench.session.export(result["name"])) == result["bytes"]
    assert stages
    rows = list(csv.reader(io.StringIO(bench.session.export("sequence.csv").decode("utf-8-sig"))))
    assert rows[0][3] == "way (mm)" and rows[1][1] == "'=pull <b>", "no formula for a spreadsheet"
    assert rows[0][-1] == "end" and rows[1][-1] == "not out"
    assert rows[1][2] == "stand/peg" and float(rows[1][3]) == pytest.approx(500, rel=1e-3)
    page = bench.session.export("sequence.html").decode()
    assert "=pull &lt;b&gt;" in page and "<b>" not in page
    film = bench.session.export("sequence.glb")
    assert film[:4] == b"glTF"
    scene = trimesh.load(io.BytesIO(film), file_type="glb")
    assert len(scene.geometry) >= 2
    with pytest.raises(WorkbenchError, match="there is no 'secret'"):
        bench.session.export("secret")
    bench.session.close()


def test_the_film_ends_where_the_part_was_put_down() -> None:
    import json
    import struct

    bench = Bench(None)
    removed(bench)
    bench.session.job("export_glb", {}).result(WAIT_S)
    film = bench.session.export("sequence.glb")
    size = struct.unpack_from("<I", film, 12)[0]
    document, binary = json.loads(film[20 : 20 + size]), film[28 + size :]

    def values(accessor: int, width: int) -> np.ndarray:
        entry = document["accessors"][accessor]
        start = document["bufferViews"][entry["bufferView"]]["byteOffset"] + entry["byteOffset"]
        assert start % 4 == 0
        return np.frombuffer(binary, "<f4", entry["count"] * width, start).reshape(-1, width)

    (animation,) = document["animations"]
    by_path = {each["target"]["path"]: each for each in animation["channels"]}
    node = document["nodes"][by_path["translation"]["target"]["node"]]
    assert node["name"] == "peg"
    sampler = animation["samplers"][by_path["translation"]["sampler"]]
    times, places = values(sampler["input"], 1), values(sampler["output"], 3)
    assert (np.diff(times[:, 0]) > 0).all() and not places[0].any()
    moved = np.array(bench.document["moved"][str(PEG)]).reshape(4, 4)
    np.testing.assert_allclose(places[-1], moved[:3, 3], atol=1e-6)
    turns = values(animation["samplers"][by_path["rotation"]["sampler"]]["output"], 4)
    np.testing.assert_allclose(turns, np.tile([0, 0, 0, 1], (len(turns), 1)), atol=1e-6)
    bench.session.close()


def test_a_sequence_that_is_empty_is_not_exported() -> None:
    bench = Bench(None)
    with pytest.raises(WorkbenchError, match="take a part out first"):
        bench.session.job("export_csv", {}).result(WAIT_S)
    bench.session.close()


def test_jobs_come_one_by_one_and_are_given_up() -> None:
    jobs = Jobs()
    begun, go_on = threading.Event(), threading.Event()

    def long(progress: Any) -> None:
        begun.set()
        go_on.wait(WAIT_S)
        progress(0.5, "half")

    running = jobs.start(long, lambda share, stage: None)
    waiting = jobs.start(lambda progress: 1, lambda share, stage: None)
    failing = jobs.start(lambda progress: 1 // 0, lambda share, stage: None)
    last = jobs.start(lambda progress: 2, lambda share, stage: None)
    assert begun.wait(WAIT_S)
    assert waiting.cancel() and running.cancel()
    go_on.set()
    with pytest.raises(JobCancelledError):
        running.result(WAIT_S)
    assert waiting.cancelled()
    with pytest.raises(ZeroDivisionError):
        failing.result(WAIT_S)
    assert last.result(WAIT_S) == 2 and not last.cancel()
    jobs.close()
    with pytest.raises(WorkbenchError, match="closed"):
        jobs.start(lambda progress: 1, lambda share, stage: None)


CLASHES = {
    "version": 1,
    "clashes": [
        {"id": "a", "a": "stand/peg", "b": "stand/plate", "verdict": "touching", "depth": 0.0, "gap": 0.0},
        {"id": "b", "a": "stand/peg", "b": "nowhere", "depth": 0.001, "rule": "fasteners", "group": "g", "x": [1]},
        {"id": "c", "a": "stand/posts/left", "b": "sheet", "depth": 0.02, "group": "g", "point_a": [0, 0, "1"]},
        {"id": 4, "a": "sheet", "b": "stand/plate", "gap": 0.003, "verdict": "clearance", "status": "approved"},
        "no clash",
    ],
}


def table_of(bench: Bench) -> FindingTable:
    found = bench.session.current.findings
    assert found is not None and bench.document["findings"]["version"] == found.table.key
    return found.table


def test_findings_the_worst_first() -> None:
    bench = Bench(cube())
    bench.session.load_findings(CLASHES)
    findings, table = bench.document["findings"], table_of(bench)
    assert findings["is_touching_hidden"] and findings["status"] == {} and table.status_of("4") == "approved"
    assert findings["count"] == 4 and findings["counts"] == {"clash": 2, "touching": 1, "clearance": 1}
    assert table.ids == ("c", "b", "a", "4") and table.groups[0] == "g"
    worst, second, touching, _ = (table.row_json(row) for row in range(4))
    assert (worst["depth"], worst.get("point_a")) == (0.02, None), "a point that is none is not known"
    assert (second["x"], second["rule"], second["b"]) == ([1], "fasteners", "nowhere")
    assert table.part_of_path[list(table.paths).index("nowhere")] == -1
    assert touching["verdict"] == "touching" and table.is_touching.tolist() == [False, False, True, False]
    bench.command("finding_status", id="b", status="resolved")
    assert bench.document["findings"]["status"] == {"b": "resolved"}
    bench.command("finding_status", id="4", status="approved")
    assert bench.document["findings"]["status"] == {"b": "resolved"}, "as the file says"
    bench.command("finding_filter", is_touching_hidden=False)
    for _ in range(3):
        bench.command("undo")
    assert bench.document["findings"] == findings
    with pytest.raises(WorkbenchError, match="there is no finding 'z'"):
        bench.command("finding_status", id="z", status="new")


def test_duplicates_are_first() -> None:
    pair = {"a": "stand/peg", "b": "stand/plate", "gap": 0.0}
    clashes = [
        {**pair, "id": "deep", "verdict": "clash", "depth": 0.02},
        {**pair, "id": "same", "verdict": "duplicate", "depth": 0.0},
        {**pair, "id": "unmeasured", "verdict": "clash", "depth": None},
        {**pair, "id": "contact", "verdict": "contact", "depth": 0.03},
        {**pair, "id": "old", "depth": 0.0},
        {**pair, "id": "critical", "verdict": "clash", "depth": 0.001, "severity": "critical"},
    ]
    bench = Bench(cube())
    bench.session.load_findings({"version": 1, "clashes": clashes})
    assert table_of(bench).ids == ("critical", "same", "deep", "unmeasured", "contact", "old")
    assert table_of(bench).is_touching.tolist() == [False] * 4 + [True] * 2


def test_findings_that_a_page_opens_are_a_change_and_those_at_the_start_are_none() -> None:
    bench = Bench(cube())
    bench.command("hide", parts=[PEG])
    bench.session.load_findings(CLASHES)
    bench.command("undo")
    assert bench.document["findings"] is not None and bench.document["hidden"] == []
    other = {"clashes": [{"id": "only", "a": "sheet", "b": "stand/plate", "depth": 0.5}]}
    bench.command("findings_open", findings=other)
    assert table_of(bench).ids == ("only",)
    bench.command("undo")
    assert len(table_of(bench)) == 4
    with pytest.raises(WorkbenchError, match="holds no list"):
        bench.command("findings_open", findings={"rows": []})
    bench.command("findings_close")
    assert bench.document["findings"] is None


@pytest.mark.parametrize("text", ["", "[]", '{"clashes": 3}', '{"version": 2, "clashes": []}', "{"])
def test_what_is_no_list_of_findings_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "clash.json").write_text(text)
    with pytest.raises(LoadError, match=r"clash\.json"):
        Bench(cube()).session.load_findings(tmp_path / "clash.json")


def test_the_threads_answer_wishes_and_end() -> None:
    mockup = stand()
    with Session() as session:
        session.open(mockup, feeler.Scene(mockup), cube(), pose=at(0, 0, 0.2))
        there = threading.Event()

        def look() -> None:
            snapshot = session.snapshot()
            if snapshot is not None and snapshot.pose_seq == 7:
                there.set()

        end = session.on_snapshot(look)
        session.wish(at(0, 0, -0.2), 7, "mouse")
        assert there.wait(WAIT_S)
        end()
        assert session.snapshot().blocked and session.snapshot().parts == [PLATE]
        with pytest.raises(WorkbenchError, match="not a pose"):
            session.wish(np.zeros((4, 4)), 8, "mouse")
    session.close()


def test_commands_from_many_threads_are_one_after_the_other() -> None:
    mockup = stand()
    with Session() as session:
        session.open(mockup, feeler.Scene(mockup), cube(), pose=at(0, 0, 0.2))
        troubles: list[BaseException] = []

        def work(number: int) -> None:
            try:
                for turn in range(20):
                    session.wish(at(0.01 * number, 0, 0.2 - 0.001 * turn), turn, "mouse")
                    session.command("hide", {"parts": [number % 5]})
                    session.command(
                        "section_add" if turn < 1 else "show_all",
                        {"normal": [0, 0, 1], "offset": 0.1} if turn < 1 else {},
                    )
                    session.ask("part", {"part": number % 5})
                    session.document()
            except BaseException as error:
                troubles.append(error)

        threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(WAIT_S)
        assert not troubles and len(session.document()["sections"]) == 4
        events = session.events_since(0)
        assert [event["n"] for event in events] == list(range(1, len(events) + 1))


def test_a_failing_engine_lets_go_and_tells_once(monkeypatch: pytest.MonkeyPatch) -> None:
    mockup = stand()
    with Session() as session:
        told: list[dict] = []
        heard = threading.Event()
        session.open(mockup, feeler.Scene(mockup), cube(), pose=at(0, 0, 0.2))
        session.subscribe(lambda event: (told.append(event), heard.set()) if event["type"] == "notice" else None)
        monkeypatch.setattr("feeler.workbench.engine.engine.OFF_M", "broken")
        session.wish(at(0, 0, 0.1), 1, "mouse")
        assert heard.wait(WAIT_S)
        monkeypatch.undo()
        session.command("place", {"pose": at(0, 0, 0.1).ravel().tolist()})
        np.testing.assert_array_equal(session.engine.pose, at(0, 0, 0.1))
        assert len(told) == 1 and told[0]["level"] == "error"


class FakeServer:
    def __init__(self, session: Session, *, host: str = "127.0.0.1", port: int = 0, tls: object = None) -> None:
        self.session, self.url, self.is_closed = session, 'http://127.0.0.1:1/#t="x"', False

    def start(self) -> None:
        self.is_started = True

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("feeler.workbench.net.server")
    module.Server = FakeServer  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "feeler.workbench.net.server", module)


@pytest.mark.usefixtures("served")
def test_view_from_a_script(tmp_path: Path) -> None:
    mockup = stand()
    with feeler.view(mockup, cube(), browser=False, pose=at(0, 0, 0.2)) as view:
        assert view.url.startswith("http://127.0.0.1:1/")
        assert "&quot;x&quot;" in view._repr_html_()
        moved = threading.Event()
        seen: list[np.ndarray] = []
        view.on_pose(lambda pose: (seen.append(pose), moved.set() if pose[2, 3] < 0.1 else None))
        view.pose = at(0, 0, -0.5)
        assert view.pose[2, 3] == pytest.approx(0.03125, abs=1e-6)
        assert moved.wait(WAIT_S)
        np.testing.assert_array_equal(seen[-1], view.pose)
        view.set_mode("pass")
        assert view.session.current.mode == "pass"
        mask = np.arange(mockup.part_count) == 1
        for parts in (mockup.parts[1], [mockup.parts[1]], np.array([1]), mask, np.int64(1), 1, mockup.part_paths[1]):
            view.hide(parts)
            assert view.session.current.hidden == (1,), parts
            view.undo()
        added = view.section_add(np.array([0.0, 0.0, 1.0]), 0.1)
        view.section_switch(added["id"], False)
        assert [(each.id, each.is_on) for each in view.session.current.sections] == [(added["id"], False)]
        view.viewpoint_add({"position": (1, 1, 1), "target": (0, 0, 0), "up": (0, 0, 1), "fov_rad": 0.7})
        assert view.session.current.viewpoints[-1].name.startswith("view ")  # its own name, where none is given
        view.undo()
        view.undo()
        view.undo()
        goal = at(0.3, 0, 0.0)
        scene = view.session.scene
        view.show_hit(scene.cast(cube(), at(0, 0, 0.1), at(0.5, 0, 0.1)))
        assert view.pose[0, 3] == pytest.approx(0.25 - 0.03125, abs=1e-5)
        view.show_hit(goal)
        np.testing.assert_array_equal(view.pose, goal)
        shown = threading.Event()

        def look() -> None:
            snapshot = view.session.snapshot()
            if snapshot is not None and len(snapshot.hits.pairs) == len(hit.pairs):
                shown.set()

        hit = scene.collide(cube(), goal)
        end = view.session.on_snapshot(look)
        view.show_hit(hit)
        assert shown.wait(WAIT_S)
        end()
        assert set(view.touched) == {"stand/plate", "stand/posts/right"}
        data = view.screenshot(tmp_path / "a.png", size=(160, 100))
        assert data.startswith(b"\x89PNG") and (tmp_path / "a.png").read_bytes() == data
        # A page that answers the wish for a picture.
        view.session.pages = 1
        view.session.subscribe(
            lambda event: view.session.shot_taken(event["id"], b"png of a page") if event["type"] == "shot" else None
        )
        assert view.screenshot() == b"png of a page"
        with pytest.raises(OptionError, match="size"):
            view.screenshot(size=(0, 1))
        with pytest.raises(WorkbenchError, match="not a pose"):
            view.pose = np.zeros((4, 4))
        with pytest.raises(WorkbenchError, match="not a pose"):
            view.show_hit("a hit")
    assert view._server.is_closed
    view.close()


@pytest.mark.usefixtures("served")
def test_view_refuses_what_it_cannot_show() -> None:
    with pytest.raises(MeshError, match=r"feeler\.Scene"):
        feeler.view("engine.step")  # type: ignore[arg-type]
    with pytest.raises(MeshError, match=r"feeler\.Tool"):
        feeler.view(stand(), stand())  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="glide"):
        feeler.view(stand(), mode="slide")
    with pytest.raises(WorkbenchError, match="not a pose"):
        feeler.view(stand(), pose=np.zeros((4, 4)))
    with pytest.raises(AttributeError, match="views"):
        feeler.views  # noqa: B018


def test_import_feeler_brings_no_workbench() -> None:
    code = "import feeler, sys; print([m for m in sys.modules if 'workbench' in m or m == 'websockets'])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_a_cover_of_the_gearbox_comes_off_once_its_truth_says_so(gearbox: Any) -> None:
    """By an empty hand that pulls as the truth does; and not while the plug holds it."""
    step = gearbox.step("gearbox/covers/idler_front/cover")
    out = gearbox.mockup.parts.select(gearbox.out(step)).tolist()
    plug = gearbox.mockup.part_paths.index("gearbox/covers/idler_front/blanking_plug")
    pull = np.array(step.legs[-1].axis) * step.legs[-1].distance_m

    def pulled(absent: list[int]) -> tuple[Bench, np.ndarray]:
        bench = Bench(None, mockup=gearbox.mockup, absent=absent)
        assert bench.document["mockup"]["name"] == "gearbox"
        bench.command("grip", parts=list(step.parts))
        start = bench.pose.copy()
        goal = start.copy()
        goal[:3, 3] += pull
        bench.drag(goal, 1.0)
        way = bench.pose[:3, 3] - start[:3, 3]
        return bench, way

    bench, way = pulled(out)
    np.testing.assert_allclose(way, pull, atol=1e-9)
    bench.command("release")
    (line,) = bench.document["sequence"]
    assert line["name"] == "covers/idler_front/cover and 1 more" and line["touched"] == []
    held, way = pulled([part for part in out if part != plug])
    assert np.linalg.norm(way) < 1e-4 and plug in held.session.snapshot().parts
