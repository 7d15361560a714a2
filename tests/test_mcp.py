"""`feeler mcp`: a client of the package `mcp` asks a real server, in a process of its own."""

from __future__ import annotations

import base64
import fnmatch
import io
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import error_of
from shapes import box

import feeler
from feeler.agent import answers, inputs
from feeler.agent.job import Cancelled, Job
from feeler.agent.served import Opening, Served
from feeler.agent.tools import TOOLS, call
from feeler.io import write_stl
from feeler.picture import render_collision
from feeler.picture.png import write_png

pytest.importorskip("mcp", reason='needs the package mcp: pip install "feeler[mcp]"')

from anyio.from_thread import BlockingPortal, start_blocking_portal
from mcp import Client
from mcp.client.stdio import StdioServerParameters, stdio_client

from feeler.agent.protocol import MOST_CALLS

WAIT_S = 60.0
PUMP = "engine/externals/accessory_gearbox/oil_pump_1/body"
STUCK = "engine/hp_compressor/*disk*"
"""Parts for which a removal searches until its time is up."""


class Agent:
    """A client that is connected to a server."""

    def __init__(self, client: Client, portal: BlockingPortal) -> None:
        self.client, self.portal = client, portal
        self.progress: list[tuple[float, float | None, str | None]] = []

    def start(self, tool: str, arguments: dict[str, Any]) -> Future[Any]:
        """Begins a call."""

        async def heard(done: float, whole: float | None, stage: str | None) -> None:
            self.progress.append((done, whole, stage))

        async def ask() -> Any:
            return await self.client.call_tool(tool, arguments, progress_callback=heard)

        return self.portal.start_task_soon(ask)

    def ask(self, tool: str, /, **arguments: Any) -> dict[str, Any]:
        """The answer of a tool; checks what holds for all answers."""
        result = self.start(tool, arguments).result(WAIT_S)
        assert not result.is_error, result.content[0].text
        text = result.content[0].text
        assert len(text.encode()) <= answers.MOST_BYTES < 4096
        answer: dict[str, Any] = json.loads(text)
        assert answer == result.structured_content
        for name, kind in answer.get("kinds", {}).items():
            assert kind.split(":")[0].split(",")[0].split(" ")[0] in ("exact", "bound", "estimate"), (name, kind)
        return answer

    def picture(self, **arguments: Any) -> tuple[dict[str, Any], bytes]:
        """The answer of the tool `picture`, and the PNG."""
        result = self.start("picture", arguments).result(WAIT_S)
        assert not result.is_error, result.content[0].text
        text, image = result.content
        assert image.mime_type == "image/png"
        return json.loads(text.text), base64.b64decode(image.data)

    def error(self, tool: str, /, **arguments: Any) -> str:
        """What is wrong with a call."""
        result = self.start(tool, arguments).result(WAIT_S)
        assert result.is_error and len(result.content) == 1
        return str(result.content[0].text)

    def ping(self) -> None:
        """Is it still there?"""
        self.portal.start_task_soon(self.client.list_tools).result(WAIT_S)


def command(*words: str | Path) -> list[str]:
    return [sys.executable, "-m", "feeler", "mcp", *map(str, words)]


@contextmanager
def connected(log: Path, *words: str | Path) -> Iterator[Agent]:
    program, *rest = command(*words)
    environment = {name: os.environ[name] for name in ("PYTHONPATH", "FEELER_CACHE_DIR") if name in os.environ}
    parameters = StdioServerParameters(command=program, args=rest, env=environment)
    with open(log, "w", encoding="utf-8") as errors, start_blocking_portal() as portal:
        client = Client(stdio_client(parameters, errors))
        with portal.wrap_async_context_manager(client):
            yield Agent(client, portal)
    assert "Traceback" not in log.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def scene() -> feeler.Scene:
    return feeler.Scene(feeler.sample("engine", 20_000))


@pytest.fixture(scope="module")
def files(scene: feeler.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mcp")
    scene.save(folder / "engine.feeler")
    write_stl(folder / "wrench.stl", feeler.sample_tool("wrench"))
    feeler.Scene(CASE).save(folder / "case.feeler")
    return folder


@pytest.fixture(scope="module")
def wrench(files: Path) -> feeler.Tool:
    """As the server reads it."""
    return feeler.load_tool(files / "wrench.stl")


@pytest.fixture(scope="module")
def engine(files: Path) -> Iterator[Agent]:
    words = (files / "engine.feeler", "--tool", files / "wrench.stl")
    with connected(files / "engine.log", *words) as agent:
        yield agent


# A block of 0.2 m in a case of six walls, with a gap of a millimetre all around it.
GAP = 0.001
_INNER, _OUTER = 0.1 + GAP, 0.15
CASE = feeler.Mockup(
    {
        "block": feeler.Mockup(*box([-0.1] * 3, [0.1] * 3)),
        "lid": feeler.Mockup(*box([-_OUTER, -_OUTER, _INNER], [_OUTER, _OUTER, _OUTER])),
        "floor": feeler.Mockup(*box([-_OUTER, -_OUTER, -_OUTER], [_OUTER, _OUTER, -_INNER])),
        "left": feeler.Mockup(*box([-_OUTER, -_OUTER, -_INNER], [-_INNER, _OUTER, _INNER])),
        "right": feeler.Mockup(*box([_INNER, -_OUTER, -_INNER], [_OUTER, _OUTER, _INNER])),
        "front": feeler.Mockup(*box([-_INNER, -_OUTER, -_INNER], [_INNER, -_INNER, _INNER])),
        "back": feeler.Mockup(*box([-_INNER, _INNER, -_INNER], [_INNER, _OUTER, _INNER])),
    }
)


@pytest.fixture(scope="module")
def case(files: Path) -> Iterator[Agent]:
    with connected(files / "case.log", files / "case.feeler") as agent:
        yield agent


def at(*xyz: float, rotate_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    return {"at_m": list(xyz), "rotate_deg": list(rotate_deg)}


def matrix(x: float, y: float, z: float) -> Any:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def paths(scene: feeler.Scene, parts: Any) -> list[str]:
    return [scene.mockup.part_paths[int(part)] for part in parts]


# Twelve questions about the sample engine, each with its answer from elsewhere.


def test_1_how_large_is_it(engine: Agent, scene: feeler.Scene, wrench: feeler.Tool) -> None:
    answer = engine.ask("info")
    corners = scene.mockup.vertices[scene.mockup.faces].reshape(-1, 3)
    assert answer["parts"] == len(scene.mockup.part_paths) and answer["triangles"] == len(scene.mockup.faces)
    assert answer["lower_m"] == pytest.approx(corners.min(axis=0), abs=1e-9)
    assert answer["upper_m"] == pytest.approx(corners.max(axis=0), abs=1e-9)
    assert answer["mockup"] == ["engine.feeler"], "and nothing of the folder"
    assert [(tool["tool"], tool["triangles"]) for tool in answer["tools"]] == [("wrench", wrench.triangle_count)]


def test_2_what_is_in_it(engine: Agent, scene: feeler.Scene) -> None:
    every = scene.mockup.part_paths
    wanted = [path for path in every if fnmatch.fnmatchcase(path, "*pump*")]
    answer = engine.ask("parts", pattern="*pump*")
    assert [row["part"] for row in answer["rows"]] == wanted and answer["count"] == len(wanted) > 1
    assemblies = engine.ask("parts", level=2)["rows"]
    assert {row["assembly"] for row in assemblies} == {"/".join(path.split("/")[:2]) for path in every}
    assert sum(row["parts"] for row in assemblies) == len(every)


def test_3_every_part_is_on_some_page(engine: Agent, scene: feeler.Scene) -> None:
    seen: list[str] = []
    pages = 0
    while True:
        answer = engine.ask("parts", offset=len(seen))
        seen += [row["part"] for row in answer["rows"]]
        pages += 1
        left = answer.get("left_out", {}).get("rows", 0)
        assert len(seen) + left == answer["count"]
        if not left:
            break
        assert f"offset {len(seen)}" in answer["more"]
    assert seen == list(scene.mockup.part_paths) and pages > 5


def test_4_what_does_the_wrench_hit(engine: Agent, scene: feeler.Scene, wrench: feeler.Tool) -> None:
    answer = engine.ask("collide", pose=at(0.1, 0.0, 0.2))
    hit = scene.collide(wrench, matrix(0.1, 0.0, 0.2))
    depths = scene.depth(wrench, matrix(0.1, 0.0, 0.2))
    assert answer["colliding"] and not answer["free"] and answer["pairs"] == len(hit)
    assert {row["part"] for row in answer["rows"]} == set(paths(scene, hit.parts))
    assert [row["depth_m"] for row in answer["rows"]] == depths.depths.tolist()
    assert answer["kinds"]["pairs"] == "exact" and answer["kinds"]["depth_m"] == "bound: at least"
    freed = np.array([0.1, 0.0, 0.2]) + answer["separation"]["translation_m"]
    assert answer["separation"]["kind"] == "bound: at most" and not scene.is_colliding(wrench, matrix(*freed))


def test_5_what_is_near_it(engine: Agent, scene: feeler.Scene, wrench: feeler.Tool) -> None:
    answer = engine.ask("clearance", pose=at(0.0, 0.0, 3.2), within_m=0.6)
    rows = scene.nearest(wrench, matrix(0.0, 0.0, 3.2), answer["parts"] + 1)
    near = [row for row in rows if row.value <= 0.6]
    assert len(near) == answer["parts"] > 2 and answer["distance_m"] == near[0].value > 0.0
    shown = answer["rows"]
    assert [row["distance_m"] for row in shown] == [row.value for row in near][: len(shown)]
    assert [row["part"] for row in shown] == paths(scene, [row.part for row in near])[: len(shown)]
    ends = np.array([[row["point_on_body_m"], row["point_on_part_m"]] for row in shown])
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) == pytest.approx([r["distance_m"] for r in shown], abs=1e-8)


def test_6_where_does_a_path_end(engine: Agent, scene: feeler.Scene, wrench: feeler.Tool) -> None:
    answer = engine.ask("path", poses=[at(3.0, 0.0, 0.2), at(0.0, 0.0, 0.2)])
    (impact,) = answer["rows"]
    assert not answer["free"] and impact["segment"] == 0
    x = 3.0 - 3.0 * impact["fraction"]
    # Bisected with exact collisions alone.
    free, hit = 3.0, x - 2e-6
    assert scene.is_colliding(wrench, matrix(hit, 0.0, 0.2))
    for _ in range(40):
        middle = 0.5 * (free + hit)
        free, hit = (free, middle) if scene.is_colliding(wrench, matrix(middle, 0.0, 0.2)) else (middle, hit)
    assert hit <= x <= hit + 1.1e-6, "never late, early by the tolerance at most"
    assert impact["part"] in paths(scene, scene.collide(wrench, matrix(hit, 0.0, 0.2)).parts)
    assert engine.ask("path", poses=[at(3.0, 0.0, 0.2), at(2.0, 0.0, 0.2)])["free"]


def test_7_what_does_a_ray_meet(engine: Agent, scene: feeler.Scene) -> None:
    starts = [[0.3, 0.02, 9.0], [0.02, 9.0, 1.1], [9.0, 0.013, 1.5], [9.0, 9.0, 9.0]]
    ways = [[0, 0, -2], [0, -1, 0], [-1, 0, 0], [1, 0, 0]]
    asked = [{"from_m": a, "direction": d} for a, d in zip(starts, ways, strict=True)]
    answer = engine.ask("rays", rays=asked)
    for row, start, way in zip(answer["rows"], starts, ways, strict=True):
        distance, part = nearest_hit(scene.mockup, np.array(start), np.array(way, dtype=float))
        assert row["hit"] == np.isfinite(distance)
        if row["hit"]:
            assert row["distance_m"] == pytest.approx(distance, rel=1e-9)
            assert row["part"] == scene.mockup.part_paths[part]
    assert answer["hits"] == 3


def nearest_hit(mockup: feeler.Mockup, start: Any, way: Any) -> tuple[float, int]:
    """The distance along a ray and the part, from all triangles (Möller and Trumbore 1997)."""
    a, b, c = mockup.vertices[mockup.faces].transpose(1, 0, 2)
    way = way / np.linalg.norm(way)
    p = np.cross(way, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("ij,ij->i", start - a, p) / (scale := np.einsum("ij,ij->i", b - a, p))
        q = np.cross(start - a, b - a)
        v, t = q @ way / scale, np.einsum("ij,ij->i", c - a, q) / scale
        t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf)
    first = int(np.argmin(t))
    return float(t[first]), int(mockup.part_of_face[first])


def test_8_which_parts_clash(engine: Agent, scene: feeler.Scene) -> None:
    found = feeler.clash(scene.mockup, 0.0, scene=scene)
    engine.progress.clear()
    answer = engine.ask("clash", clearance_m=0.0)
    assert answer["complete"] and answer["findings"] == len(found) > 100
    assert sum(answer["verdicts"].values()) == len(found)
    shown = answer["rows"]
    assert [(row["part_a"], row["part_b"]) for row in shown] == [(r.path_a, r.path_b) for r in found[: len(shown)]]
    assert [row["depth_m"] for row in shown if "depth_m" in row] == [
        row.depth for row in found[: len(shown)] if row.depth_kind == "measured"
    ]
    assert answer["left_out"]["rows"] == len(found) - len(shown)
    assert engine.progress and all(0.0 < done <= (whole or 0.0) for done, whole, _ in engine.progress)
    last = engine.ask("clash", clearance_m=0.0, offset=len(found) - 1)["rows"]
    assert [(row["part_a"], row["part_b"]) for row in last] == [(found[-1].path_a, found[-1].path_b)]


def test_9_what_clashes_with_the_pump(engine: Agent, scene: feeler.Scene) -> None:
    found = [row for row in feeler.clash(scene.mockup, 0.002, scene=scene) if PUMP in (row.path_a, row.path_b)]
    answer = engine.ask("clash", part=PUMP)
    assert [(row["part_a"], row["part_b"]) for row in answer["rows"]] == [(row.path_a, row.path_b) for row in found]


def test_10_does_the_pump_come_out(engine: Agent, scene: feeler.Scene) -> None:
    answer = engine.ask("removal", parts=PUMP)
    found = feeler.removal(scene, PUMP)
    assert answer["found"] and answer["legs"] == [str(leg) for leg in found.legs]
    assert answer["path_length_m"] == found.path_length
    # The same way, as a path of the part: free, but for the seats at its start.
    moved = engine.ask("path", part=PUMP, touching="free", poses=[found.poses[0].tolist(), found.poses[-1].tolist()])
    assert moved["kinds"]["free"].startswith("bound")
    assert moved["free"] or {row["part"] for row in moved["rows"]} <= set(
        paths(scene, scene.without(PUMP).collide(feeler.Tool.of_parts(scene.mockup, PUMP), np.eye(4)).parts)
    )
    order = engine.ask("order", parts=PUMP)
    assert order["found"] and [row["parts"] for row in order["rows"]] == [[PUMP]]


def test_11_which_bolts_does_a_hand_reach(engine: Agent, scene: feeler.Scene) -> None:
    pattern = "engine/casings/front_frame/*"
    bolts = feeler.find_fasteners(scene, pattern)
    found = feeler.access(scene, feeler.sample_tool("hand"), bolts)
    answer = engine.ask("access", tool="sample:hand", targets=pattern)
    assert answer["complete"] and answer["targets"] == answer["tried"] == len(bolts) > 2
    assert answer["reachable"] == int(found.is_reachable.sum())
    assert {row["part"]: row["swing_deg"] for row in answer["rows"]} == {row.path: row.swing_deg for row in found}


def test_12_what_does_it_look_like(engine: Agent, scene: feeler.Scene, wrench: feeler.Tool) -> None:
    answer, png = engine.picture(pose=at(0.1, 0.0, 0.2), width_px=320, height_px=200)
    pose, drawn = matrix(0.1, 0.0, 0.2), io.BytesIO()
    hit = scene.collide(wrench, pose)
    write_png(drawn, render_collision(None, scene.mockup, wrench, pose, hit, size=(320, 200)))
    assert png == drawn.getvalue() and answer["png_bytes"] == len(png)
    assert answer["hit"]["first"] == paths(scene, hit.parts)
    plain, red = engine.picture(width_px=64, height_px=64)[1], engine.picture(part=PUMP, width_px=64, height_px=64)[1]
    assert plain != red != engine.picture(only=PUMP, width_px=64, height_px=64)[1]


# A case in which every answer is known.


def test_distances_and_depths_in_closed_form(case: Agent) -> None:
    near = case.ask("clearance", part="block", within_m=0.01)
    assert near["distance_m"] == pytest.approx(GAP, abs=1e-15) and near["parts"] == 6
    hit = case.ask("collide", part="block", pose=at(0.003, 0.0, 0.0))
    (row,) = hit["rows"]
    assert row["part"] == "right/part"
    assert row["depth_m"] <= 0.003 - GAP <= row["depth_at_most_m"] and row["depth_at_most_m"] < 1.002 * (0.003 - GAP)
    assert 0.003 - GAP <= hit["separation"]["length_m"] < 0.00201, "a bound: at most"
    outside = case.ask("collide", part="block", pose=at(0.0, 0.0, 0.5))
    assert outside["free"] and outside["pairs"] == 0 and outside["rows"] == []


def test_paths_and_rays_in_closed_form(case: Agent) -> None:
    (impact,) = case.ask("path", part="block", poses=[at(0.0, 0.0, 0.0), at(0.0, 0.0, 0.5)])["rows"]
    assert 0.0 <= GAP - 0.5 * impact["fraction"] <= 1.1e-6 and impact["normal"] == [0.0, 0.0, -1.0]
    down = [{"from_m": [0.02, 0.01, 1.0], "direction": [0, 0, -3]}]
    assert case.ask("rays", rays=down)["rows"][0]["distance_m"] == pytest.approx(1.0 - _OUTER, rel=1e-12)
    assert case.ask("rays", rays=down, without="lid")["rows"][0]["distance_m"] == pytest.approx(0.9, rel=1e-12)
    assert case.ask("rays", rays=down, within_m=0.5)["hits"] == 0


def test_what_holds_a_part_and_what_goes_first(case: Agent) -> None:
    held = case.ask("removal", parts="block", seconds=5)
    assert not held["found"] and len(held["held_by"]) >= 4, "a wall on every side, or four that suffice"
    assert GAP <= held["play_m"] < 0.01 and held["kinds"]["play_m"] == "bound: at most"
    assert case.ask("removal", parts="block", without=["lid"])["legs"][0].endswith("along +z")
    order = case.ask("order", parts="block", keep=["left", "right", "front", "back", "floor"])
    assert [len(row["parts"]) for row in order["rows"]] == [1, 1] and order["rows"][0]["parts"] == ["lid/part"]
    gaps = case.ask("clash", clearance_m=0.002, part="block")
    assert gaps["verdicts"] == {"clearance": 6}
    assert [row["gap_m"] for row in gaps["rows"]] == pytest.approx([GAP] * 6, abs=1e-15)


def test_a_body_inside_another_is_not_free(files: Path) -> None:
    around = {"ball": feeler.Mockup(*box([-1] * 3, [1] * 3))}
    served = Served(feeler.Scene(feeler.Mockup(around)), {"cube": feeler.Tool(*box([-0.1] * 3, [0.1] * 3))})
    answer = call(TOOLS["collide"], served, {"pose": at(0.0, 0.0, 0.0)}, Job()).content
    assert not answer["colliding"] and not answer["free"] and answer["inside"]["count"] == 1
    assert answer["rows"][0]["depth_m"] <= 1.1 and answer["rows"][0]["depth_at_most_m"] >= 0.9


# Long calls, and wrong ones.


def test_a_call_is_cancelled_while_others_are_answered(engine: Agent) -> None:
    engine.progress.clear()
    stuck = engine.start("removal", {"parts": STUCK, "seconds": 600})
    waiting = engine.start("removal", {"parts": STUCK, "seconds": 600, "seed": 1})
    while not engine.progress:  # it runs; a short one is answered meanwhile
        engine.ping()
        assert engine.ask("parts", pattern="*pump*")["count"] == 2
        assert not stuck.done()
    for call_ in (waiting, stuck):
        call_.cancel()
        with pytest.raises(CancelledError):
            call_.result(WAIT_S)
    assert engine.ask("removal", parts=PUMP)["found"], "calls that take long run one at a time, and this one could"


def test_a_flood_of_calls_is_refused_and_quick_ones_are_answered(engine: Agent) -> None:
    stuck = [engine.start("removal", {"parts": STUCK, "seconds": 600}) for _ in range(MOST_CALLS)]
    try:
        assert "are running or waiting" in engine.error("removal", parts=PUMP)
        assert engine.ask("info")["parts"] == 362
    finally:
        for call_ in stuck:
            call_.cancel()
    assert engine.ask("removal", parts=PUMP)["found"]


def test_a_time_limit_returns_what_was_found(engine: Agent, scene: feeler.Scene) -> None:
    found = engine.ask("removal", parts=STUCK, seconds=0.5)
    assert not found["found"] and found["out_of_time"] and found["blocked_by"] and not found["held_by"]
    part = engine.ask("clash", clearance_m=0.012, seconds=1e-6)
    assert not part["complete"] and part["kinds"]["findings"] == "bound: at least"
    assert engine.ask("clash", clearance_m=0.012)["complete"], "what is not complete is not kept"
    assert "give more seconds" in engine.error("access", tool="sample:hand", seconds=1e-6)
    job = Job(lambda: job.limit(0.0) if job.report[0] > 1.1 else None)  # the time is up while targets are tried
    some = call(TOOLS["access"], Served(scene), {"tool": "sample:hand", "targets": "*bolt*"}, job).content
    assert not some["complete"] and 0 < some["tried"] < some["targets"]


@pytest.mark.parametrize(
    ("tool", "arguments", "said"),
    [
        ("collide", {}, "no pose: give pose"),
        ("collide", {"pose": at(0, 0, 0), "part": "*fuel_pump_2*"}, "do you mean"),
        ("collide", {"pose": at(0, 0, 0), "tool": "/etc/passwd"}, "choose wrench, sample:torque"),
        ("collide", {"pose": at(0, 0, 0), "tool": "../wrench.stl"}, "other files cannot be opened"),
        ("collide", {"pose": at(0, 0, 0), "tool": "wrench", "part": PUMP}, "not both"),
        ("collide", {"pose": at(0, 0, 0), "file": "/etc/passwd"}, "no argument 'file'"),
        ("collide", {"pose": "engine.feeler"}, "pose is 'engine.feeler': give"),
        ("collide", {"pose": (2 * np.eye(4)).tolist()}, "pose is not rigid"),
        ("collide", {"pose": np.diag([1, 1, -1, 1]).tolist()}, "pose is not rigid"),
        ("collide", {"pose": {"at_m": [0, 0]}}, "pose.at_m is [0, 0]: give three coordinates"),
        ("collide", {"pose": {"at_m": [0, 0, 1e300]}}, "pose.at_m is 1e+300"),
        ("collide", {"pose": {"at_m": [0, 0, 10**400]}}, "beyond what a float64 can hold"),
        ("collide", {"pose": {"at_m": [0, 0, True]}}, "pose.at_m is True"),
        ("collide", {"pose": {"at_m": [0, 0, 0], "turn": 1}}, "pose is {"),
        ("collide", {"pose": [[1, 0, 0, 0]] * 3}, "pose is [["),
        ("collide", {"pose": at(0, 0, 0), "without": "*"}, "no part of the mock-up is left"),
        ("collide", {"pose": at(0, 0, 0), "without": ["*a*"] * 100}, "without has 100 entries: give 1 to 32"),
        ("collide", {"pose": at(0, 0, 0), "without": "*a" * 2100}, "4,200 characters"),
        ("collide", {"pose": at(0, 0, 0), "touching": "sometimes"}, "touching is 'sometimes'"),
        ("collide", {"pose": at(0, 0, 0), "depth": "yes"}, "depth is 'yes': give True or False"),
        ("collide", {"pose": at(0, 0, 0), "offset": -1}, "offset is -1"),
        ("clearance", {"pose": at(0, 0, 0), "within_m": 1e9}, "within_m is"),
        ("clash", {"clearance_m": 1.0}, "clearance_m is 1.0: give metres, 0 to 0.1"),
        ("path", {"poses": []}, "poses has 0 entries: give 1 to 1000"),
        ("path", {"poses": [at(0, 0, 0)] * 1001}, "poses has 1,001 entries"),
        ("path", {"poses": [at(0, 0, 0), {"at_m": "x"}]}, "poses[1].at_m is 'x'"),
        ("path", {}, "poses is missing: give it"),
        ("rays", {"rays": [{"from_m": [0, 0, 0], "direction": [0, 0, 0]}]}, "rays[0].direction is [0, 0, 0]"),
        ("rays", {"rays": {"from_m": [0, 0, 0]}}, "rays is {"),
        ("removal", {"parts": "*"}, "leave at least one out of it"),
        ("removal", {"parts": PUMP, "seconds": 1e6}, "seconds is 1000000.0"),
        ("removal", {"parts": PUMP, "seconds": 0}, "seconds is 0"),
        ("removal", {"parts": PUMP, "tool_pose": at(0, 0, 0)}, "give tool, too"),
        ("removal", {"parts": PUMP, "tool": "wrench", "tool_pose": at(0, 0, 1e5)}, "put it where it grips them"),
        ("removal", {"parts": PUMP, "without": PUMP}, "name others"),
        ("removal", {"parts": 3}, "parts is 3: give a name or pattern"),
        ("access", {"tool": "sample:hand", "targets": PUMP}, "looks like a fastener"),
        ("picture", {"width_px": 100_000}, "width_px is 100000: give a whole number from 64 to 1024"),
        ("picture", {"only": PUMP, "without": PUMP}, "nothing to show"),
        ("picture", {"tool": "wrench"}, "no pose"),
        ("parts", {"pattern": ""}, "pattern is ''"),
    ],
)
def test_wrong_calls_say_what_to_give(engine: Agent, tool: str, arguments: dict[str, Any], said: str) -> None:
    error = engine.error(tool, **arguments)
    assert said in error and len(error) < 600 and "Traceback" not in error


def test_a_tool_that_does_not_exist(engine: Agent) -> None:
    with pytest.raises(Exception, match="there is no tool 'write'"):
        engine.start("write", {}).result(WAIT_S)


def test_tools_are_described(engine: Agent) -> None:
    listed = engine.portal.start_task_soon(engine.client.list_tools).result(WAIT_S).tools
    assert {tool.name for tool in listed} == set(TOOLS) and len(TOOLS) == 13
    for tool in listed:
        assert tool.annotations.read_only_hint and tool.output_schema["properties"]["kinds"]
        assert tool.input_schema["additionalProperties"] is False
        assert all(each.get("description") for each in tool.input_schema["properties"].values())
    assert len(json.dumps([tool.input_schema for tool in listed])) < 23_000, "agents read it all"
    assert "never" in (engine.client.instructions or "")


# The process: its streams and its end.


def exchange(words: tuple[str | Path, ...], lines: list[bytes]) -> tuple[list[dict[str, Any]], str, int]:
    """What the server writes for some lines, until its stdin is closed."""
    run = subprocess.run(command(*words), input=b"\n".join(lines), capture_output=True, timeout=WAIT_S, check=False)
    return [json.loads(line) for line in run.stdout.splitlines()], run.stderr.decode(), run.returncode


HELLO = {
    "protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"},
}  # fmt: skip


def message(number: int, method: str, params: dict[str, Any]) -> bytes:
    return json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params}).encode()


def test_closing_stdin_ends_a_long_call(files: Path) -> None:
    stuck = {"name": "removal", "arguments": {"parts": STUCK, "seconds": 600}}
    begun = {"name": "info", "arguments": {}, "_meta": {"progressToken": 1}}
    lines = [message(1, "initialize", HELLO), message(2, "tools/call", stuck), message(3, "tools/call", begun)]
    with subprocess.Popen(command(files / "engine.feeler"), stdin=-1, stdout=-1, stderr=-1) as process:
        try:
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(b"\n".join([*lines, b""]))
            process.stdin.flush()
            while b'"id":3' not in process.stdout.readline():  # the mock-up is open, and the long call was there first
                pass
            out, err = process.communicate(timeout=WAIT_S)
        finally:
            process.kill()
    assert process.returncode == 0 and b"Traceback" not in err and b'"id":2' in out, "an error: the connection is over"


def test_garbage_is_answered_and_the_server_goes_on(files: Path) -> None:
    lines = [
        b"{",
        b"null",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"jsonrpc": "2.0"}',
        b"x" * 3_000_000,
        message(1, "initialize", HELLO),
        b'{"jsonrpc": "2.0", "id": 2, "method": "ping"}',
    ]
    lines += [b'{"jsonrpc": "2.0", "id": %s, "method": "ping"}' % each for each in (b"null", b"1.5", b"true", b"{}")]
    half = {"name": "parts", "arguments": {"pattern": "half \ud800"}}
    lines.append(message(3, "tools/call", half))
    lines.append(b'{"jsonrpc": "2.0", "id": 4, "method": "ping", "params": {"_meta": {"n": 1e999}}}')
    wrong = (b'"method": "ping", "params": []', b'"method": "ping", "params": 5', b'"method": 5')
    lines += [b'{"jsonrpc": "2.0", "id": "wrong", %s}' % each for each in wrong]
    lines += [b'{"jsonrpc": "2.0", "id": %s, "method": 5}' % each for each in (b'"\\ud800"', b"9" * 300, b"[1]")]
    said, errors, code = exchange((files / "case.feeler",), lines)
    assert code == 0 and "Traceback" not in errors
    refused = [each["error"]["code"] for each in said if each["id"] is None]
    assert refused == [*[-32700] * 5, *[-32600] * 5, *[-32700] * 3]
    known = [each for each in said if each["id"] is not None]
    assert sorted(str(each["id"]) for each in known if "error" in each) == ["3", "wrong", "wrong", "wrong"]
    assert {each["error"]["code"] for each in known if "error" in each} == {-32600}
    answers_ = {each["id"]: each["result"] for each in known if "result" in each}
    assert answers_[1]["serverInfo"]["name"] == "feeler" and answers_[2] == {}


def test_nothing_but_the_protocol_is_on_stdout(files: Path) -> None:
    """Whatever a library prints while it works goes to stderr, and it cannot read the client's messages."""
    program = (
        "import os, feeler.cli.mcp as command\n"
        "read = command.read_mockup\n"
        "def noisy(*words, **options):\n"
        "    os.write(1, b'noise of C\\n')\n"
        "    print('noise of Python', os.read(0, 9), flush=True)\n"
        "    return read(*words, **options)\n"
        "command.read_mockup = noisy\n"
        "from feeler.cli import main; main()"
    )
    asked = [message(1, "initialize", HELLO), message(2, "tools/call", {"name": "info", "arguments": {}}), b""]
    words = [sys.executable, "-c", program, "mcp", str(files / "case.feeler")]
    with subprocess.Popen(words, stdin=-1, stdout=-1, stderr=-1) as process:
        try:
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(b"\n".join(asked))
            process.stdin.flush()
            numbers = [json.loads(process.stdout.readline())["id"] for _ in asked[:2]]
            out, err = process.communicate(timeout=WAIT_S)
        finally:
            process.kill()
    assert (numbers, out, process.returncode) == ([1, 2], b"", 0)
    assert b"noise of C\n" in err and b"noise of Python b''\n" in err


def test_files_that_cannot_be_read_end_the_server(files: Path, capfd: pytest.CaptureFixture[str]) -> None:
    said, errors, code = exchange((files / "none.glb",), [])
    assert (
        (said, code) == ([], 2) and errors.startswith("feeler: ") and "none.glb" in errors and errors.count("\n") == 1
    )
    assert "none.stl" in error_of("mcp", files / "case.feeler", "--tool", files / "none.stl")
    print("the streams of this process are its own again")
    assert "own again" in capfd.readouterr().out


def test_without_the_package_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch, files: Path) -> None:
    monkeypatch.setattr("feeler.cli.mcp.find_spec", lambda name: None)
    assert 'pip install "feeler[mcp]"' in error_of("mcp", files / "case.feeler")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_a_signal_ends_it(files: Path, number: int, code: int) -> None:
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from feeler.cli import main; main()"
    )
    words = [sys.executable, "-c", program, "mcp", str(files / "case.feeler")]
    with subprocess.Popen(words, stdin=-1, stdout=-1, stderr=-1) as process:
        try:
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(b"garbage\n")
            process.stdin.flush()
            assert b"-32700" in process.stdout.readline()  # it is there
            process.send_signal(number)
            out, err = process.communicate(timeout=WAIT_S)
        finally:
            process.kill()
    assert (out, process.returncode) == (b"", code) and b"Traceback" not in err


# Pieces without a process.


def test_answers_are_cut_where_the_names_are_long() -> None:
    fields = {"rows": answers.Field("array", "", None, {"part": answers.Field("string", "", "exact")})}
    for length in (3, 30, 119, 700):
        numbers = np.repeat(np.arange(500), len(CASE.faces))
        vertices, faces = np.tile(CASE.vertices, (500, 1)), CASE.faces
        faces = np.concatenate([faces + i * len(CASE.vertices) for i in range(500)])
        paths = [f"{i:03d}" + "\u00e4[" * length for i in range(500)]
        mockup = feeler.Mockup(vertices, faces, numbers, part_paths=paths)
        rows = [{"part": answers.part_name(mockup, i)} for i in range(500)]
        answer, text = answers.finished({"note": "x" * 900, "rows": rows}, fields, "rows", 10)
        assert len(text.encode()) <= answers.MOST_BYTES and json.loads(text) == answer
        kept = len(answer["rows"])
        assert answer["left_out"] == {"rows": 500 - kept} and f"offset {10 + kept}" in answer["more"] and kept >= 10
    _, text = answers.finished({"a": ["x" * 100] * 90, "b": ["y" * 100] * 90}, {}, "rows", 0)
    assert len(text.encode()) <= answers.MOST_BYTES
    whole, _ = answers.finished({"rows": [], "nothing": float("nan"), "half": "\ud800"}, fields, "rows", 0)
    assert whole == {"rows": [], "half": "?"}


def _boxes(paths: list[str]) -> feeler.Mockup:
    """A box for each path, beside each other."""
    meshes = [box([2.0 * i, 0.0, 0.0], [2.0 * i + 1.0, 1.0, 1.0]) for i in range(len(paths))]
    faces = np.concatenate([np.asarray(faces) + 8 * i for i, (_, faces) in enumerate(meshes)])
    vertices = np.concatenate([vertices for vertices, _ in meshes])
    return feeler.Mockup(vertices, faces, np.repeat(np.arange(len(paths)), 12), part_paths=paths)


def test_every_name_in_an_answer_selects_that_part_alone() -> None:
    """Long paths that differ in the middle, patterns, a part that is an assembly too, and names like numbers."""
    hall = "plant/hall [3] * ?/" + "/".join(["main welding line north"] * 5)
    paths = [f"{hall}/station {i:02d}/fixture - revision C/{'bolt M8x25 zinc plated ' * 4}/screw" for i in range(30)]
    deep = "/".join(f"level {i}" for i in range(180)) + "/end"
    paths += ["a", "a/b", "#2", "#3 ...x", deep, "\u00e4" * 200 + "\ud800"]
    served = Served(feeler.Scene(_boxes(paths)))
    names = [answers.part_name(served.mockup, i) for i in range(len(paths))]
    assert len({*names}) == len(names) and all(len(name.encode("utf-8", "replace")) <= 120 for name in names)
    assert names[31] == "a/b" and names[30].startswith("#30 ") and names[32] == "#2"
    for part, name in enumerate(names):
        assert served.select("part", [name]).tolist() == [part]
        assert call(TOOLS["parts"], served, {"pattern": name}, Job()).content["count"] == 1
    assert served.select("part", ["#5", "#7"]).tolist() == [5, 7] and served.select("part", ["#2"]).tolist() == [32]
    assert served.select("part", [deep]).tolist() == [34] and 500 < len(deep) < inputs.MOST_CHARACTERS == 4000
    with pytest.raises(feeler.OptionError, match=r"part: no part has the path or name '#99'"):
        served.select("part", ["#99"])
    levels = call(TOOLS["parts"], served, {"level": 8}, Job()).content["rows"]
    for row in levels:
        assert call(TOOLS["parts"], served, {"pattern": row["assembly"]}, Job()).content["count"] >= row["parts"]
    assert sum(row["assembly"].startswith("#") for row in levels) > 20
    moved = call(TOOLS["collide"], served, {"part": names[3], "pose": {"at_m": [2.0, 0, 0]}}, Job()).content
    assert served.select("part", [row["part"] for row in moved["rows"]]).tolist() == [4]


def test_tools_of_the_user_and_samples_do_not_collide() -> None:
    own = feeler.Tool(*box([0] * 3, [1] * 3), name="wrench")
    served = Served(feeler.Scene(CASE), {"wrench": own})
    sample = served.tool("sample:wrench")
    assert served.tool("wrench") is own and sample is not own
    told = call(TOOLS["info"], served, {}, Job()).content
    assert [row["tool"] for row in told["tools"]] == ["wrench"]
    for name in ("wrench", *told["sample_tools"]):
        assert isinstance(served.tool(name), feeler.Tool)
    assert "sample:wrench" in told["sample_tools"]
    with pytest.raises(feeler.OptionError) as refused:
        served.tool("spanner")
    offered = str(refused.value).partition("choose ")[2].partition(";")[0].split(", ")
    assert len(offered) == 5 and all(isinstance(served.tool(name), feeler.Tool) for name in offered)


def test_errors_of_rays_name_the_argument() -> None:
    served = Served(feeler.Scene(CASE))
    good = {"from_m": [0, 0, 0], "direction": [1, 0, 0]}
    with pytest.raises(feeler.OptionError, match=r"rays\[1\]\.direction") as told:
        call(TOOLS["rays"], served, {"rays": [good, {**good, "direction": [1e-320, 0, 0]}]}, Job())
    assert "directions" not in str(told.value)


def test_an_order_that_time_cut_says_so() -> None:
    paths = [f"box_{i}" for i in range(6)]
    served = Served(feeler.Scene(_boxes(paths)))
    found = call(TOOLS["order"], served, {"parts": "box_1"}, Job()).content
    assert found["found"] and found["out_of_time"] is False
    engine = Served(feeler.Scene(feeler.sample("engine", 20_000)))
    cut = call(TOOLS["order"], engine, {"parts": STUCK, "seconds": 0.2, "keep": "engine/hp_turbine"}, Job()).content
    assert not cut["found"] and cut["out_of_time"] is True
    assert all({"part", "attempts", "reach_m"} <= row.keys() for row in cut.get("blocked_by", []))


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_is_an_end(closed: str, tmp_path: Path) -> None:
    write_stl(tmp_path / "case.stl", CASE)
    code = "from feeler.cli import main; main()"
    words = f"'{sys.executable}' -c '{code}' mcp '{tmp_path / 'case.stl'}'"
    given = "" if "<&-" in closed else "</dev/null"
    done = subprocess.run(["sh", "-c", f"{words} {given} {closed}"], capture_output=True, text=True, timeout=WAIT_S)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr


def test_calls_wait_for_the_mock_up_and_can_be_cancelled_meanwhile() -> None:
    opened = threading.Event()
    served = Served(feeler.Scene(CASE))

    def open_(progress: Any) -> Served:
        progress(0.5, "reading")
        assert opened.wait(WAIT_S)
        return served

    opening = Opening(open_)
    thread = threading.Thread(target=opening.run)
    thread.start()
    given_up = Job()
    given_up.cancel()
    with pytest.raises(KeyboardInterrupt):
        opening.served(given_up)
    heard: list[tuple[float, float, str]] = []
    job = Job(lambda: (heard.append(job.report), opened.set()))
    assert opening.served(job) is served and heard[0] == (0.5, 1.0, "reading")
    thread.join()
    assert job.report[:2] == (1.0, 2.0), "what follows has its own progress"
    with pytest.raises(Cancelled):
        call(TOOLS["info"], served, {}, given_up)


def test_a_quick_tool_that_takes_too_long_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("feeler.agent.tools.QUICK_S", 1e-9)
    with pytest.raises(feeler.OptionError, match="collide was stopped after"):
        call(TOOLS["collide"], Served(feeler.Scene(CASE)), {"part": "block"}, Job())


def bounds_of(fields: answers.Fields) -> dict[str, str]:
    """The figures of an answer that are bounds or estimates."""
    found = {name: kind.split(":")[0 if kind.startswith("est") else -1].strip() for name, kind in kinds_of(fields)}
    return {name: kind for name, kind in found.items() if not kind.startswith(("exact", "verified"))}


def kinds_of(fields: answers.Fields) -> Iterator[tuple[str, str]]:
    for name, each in fields.items():
        if each.kind is not None and not each.kind.startswith("exact"):
            yield name, each.kind
        yield from kinds_of(each.fields)


def test_the_table_of_the_documentation(root: Path) -> None:
    lines = ["| tool | question | arguments | bounds and estimates |", "|---|---|---|---|"]
    for tool in TOOLS.values():
        arguments = ", ".join(f"`{name}`" for name in tool.arguments)
        bounds = ", ".join(f"`{name}` {kind}" for name, kind in bounds_of(tool.fields).items())
        lines.append(f"| `{tool.name}` | {tool.title} | {arguments} | {bounds} |")
    table = "\n".join(lines)
    assert table in (root / "docs" / "agents.md").read_text(encoding="utf-8"), f"docs/agents.md lacks:\n{table}"


def test_each_argument_has_an_end() -> None:
    """No text, list or number of any tool is without a limit."""

    def limited(schema: dict[str, Any]) -> bool:
        if "anyOf" in schema:
            return all(map(limited, schema["anyOf"]))
        kind = schema["type"]
        if kind == "string":
            return "enum" in schema or "maxLength" in schema
        if kind == "array":
            return "maxItems" in schema and limited(schema["items"])
        if kind == "object":
            return not schema["additionalProperties"] and all(map(limited, schema["properties"].values()))
        return kind == "boolean" or "maximum" in schema or schema == {"type": "number"}  # of a matrix: checked as read

    for tool in TOOLS.values():
        assert limited(inputs.input_schema(tool.arguments)), tool.name
