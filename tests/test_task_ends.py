"""Tasks: the quickest tool of a catalogue, executors, Ctrl-C, and films."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import run, run_json
from glb_film import animations, moved_nodes
from shapes import Mesh, box, mockup_of

import feeler
from feeler.errors import OptionError
from feeler.io import write_glb
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance
from feeler.tasks.pacing import Pace
from feeler.tasks.planning import planned
from feeler.tasks.reached import Reaching
from feeler.tasks.replanning import Memory

USUAL = Tolerance(1e-4)


def ring(inner: float, low: float, high: float) -> Mesh:
    mesh = hardware.ring(inner, 0.02, high - low, USUAL)
    return mesh.vertices + np.array([0.0, 0.0, low]), mesh.faces.astype(np.int64)


def bolted(**more: Mesh) -> feeler.Scene:
    """A cover under an M8 bolt in a case."""
    bolt = hardware.hex_bolt(0.008, 0.03, USUAL)
    parts = {"bolt": (bolt.vertices, bolt.faces.astype(np.int64)), "cover": ring(0.0045, -0.01, 0.0)}
    return feeler.Scene(mockup_of({**parts, "case": ring(0.0034, -0.04, -0.01), **more}), threads=1)


def wall() -> Mesh:
    """Beside the head: a flat spanner swings little, a ratchet turns above it."""
    return box((-0.1, 0.012, 0.0001), (0.1, 0.016, 0.012))


@pytest.fixture
def lidded() -> feeler.Scene:
    return bolted(lid=box((-0.03, -0.03, 0.02), (0.03, 0.03, 0.025)))


def driver() -> feeler.Tool:
    """A rod above the head."""
    return feeler.Tool(*box((-0.002, -0.002, 0.0005), (0.002, 0.002, 0.05)), name="driver")


def spanner_first() -> feeler.Catalogue:
    built_in = feeler.catalogue()
    rows = [*built_in.where("open"), *built_in.where("socket"), *built_in.where("ratchet", "ratchet*")]
    return feeler.Catalogue(list(dict.fromkeys(rows)))


def test_the_quickest_tool_is_taken_not_the_first() -> None:
    scene, tools = bolted(wall=wall()), spanner_first()
    bolts = feeler.find_fasteners(scene)
    first = feeler.access(scene, tools, bolts, turns=16.0)[0]
    task = feeler.task(scene, "cover", tools, keep="wall")
    undo = task.steps[0]
    assert str(first.tool).startswith("open") and first.strokes is not None and first.strokes > 16
    assert undo.tool.startswith("socket 13") and undo.strokes == 16 and task.bound == pytest.approx(task.seconds)
    # Where a stroke costs nothing, they are equal.
    assert feeler.task(scene, "cover", tools, {"stroke": 0.0}, keep="wall").seconds == pytest.approx(
        task.seconds - 16 * feeler.Times().elements["stroke"].mean
    )


def test_a_tool_in_hand_is_taken_again_where_another_one_was_first() -> None:
    reaching = Reaching(bolted(), "built-in", 1)
    row = next(iter(feeler.find_fasteners(reaching.scene)))
    names = [each.tool for each in reaching.reached(row, frozenset(), 16.0).tooled]
    assert len(names) > 1 and not any("extension" in name for name in names)


def test_what_no_tool_reaches_names_none() -> None:
    scene = bolted(lid=box((-0.03, -0.03, 0.0065), (0.03, 0.03, 0.01)))
    bolts = feeler.find_fasteners(scene)
    for tool in (feeler.catalogue(), driver()):
        row = feeler.access(scene, tool, bolts)[0]
        assert not row.is_reachable and row.tool is None
    assert feeler.access(scene, driver(), bolts)[0].nearest == "driver"
    stuck = feeler.task(scene, "cover", "built-in", keep="lid")
    assert not stuck.is_found and stuck.steps == () and "no tool reaches it" in stuck.blocked[0].because


@pytest.mark.parametrize("tools", ["built-in", None])
def test_executors_give_the_same_plan(lidded: feeler.Scene, tools: Any) -> None:
    alone = feeler.task(lidded, "cover", tools)
    with ThreadPoolExecutor(2) as pool:
        assert feeler.task(lidded, "cover", tools, executor=pool).to_dict() == alone.to_dict()


def test_executors_are_asked(lidded: feeler.Scene) -> None:
    class Counting(ThreadPoolExecutor):
        count = 0

        def submit(self, *args: Any, **options: Any) -> Any:
            Counting.count += 1
            return super().submit(*args, **options)

    with Counting(2) as pool:
        feeler.task(lidded, "cover", driver(), executor=pool)
    assert Counting.count >= 2  # the ways of the lid and of the cover
    with pytest.raises(OptionError, match=r"executor is 4: a concurrent\.futures executor is needed"):
        feeler.task(lidded, "cover", executor=4)  # type: ignore[arg-type]


def interrupted(scene: feeler.Scene, stage: str) -> feeler.Task:
    """Ctrl-C where the progress says a stage."""

    def stop(_share: float, said: str) -> None:
        if said.startswith(stage):
            raise KeyboardInterrupt

    with pytest.raises(feeler.TaskInterrupted) as stopped:
        feeler.task(scene, "cover", driver(), progress=stop)
    return stopped.value.task


def test_ctrl_c_ends_with_the_best_plan_so_far(lidded: feeler.Scene, tmp_path: Path) -> None:
    whole = feeler.task(lidded, "cover", driver())
    late = interrupted(lidded, "checking the way of")
    assert not late.is_found and not late.is_complete
    assert [str(step) for step in late.steps] == [str(step) for step in whole.steps]
    assert late.seconds == pytest.approx(whole.seconds) and late.bound <= whole.bound
    assert late.said.startswith("best so far: 3 steps, ") and "its ways not checked; no plan is below" in late.said
    assert all(len(step.way) == 0 for step in late.steps)
    late.to_html(tmp_path / "late.html")
    assert "Gantt" in (tmp_path / "late.html").read_text()
    with pytest.raises(OptionError, match="no film of a task without a plan"):
        late.to_glb(tmp_path / "late.glb", lidded.mockup, driver())


def test_when_time_is_up_the_best_plan_so_far_is_said(lidded: feeler.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pace, "goes_on", lambda self: not self._what.startswith("checking"))
    late = feeler.task(lidded, "cover", driver())
    assert not late.is_found and not late.is_complete and len(late.steps) == 3
    assert late.said.startswith("best so far: 3 steps, ") and 0.0 < late.bound <= late.seconds
    assert late.notes == ("The time was up: nothing says that the ways of these steps hold.",)


def test_at_the_limit_of_sets_it_says_what_is_in_the_way(lidded: feeler.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("feeler.tasks.search.MOST_SETS", 1)
    full = feeler.task(lidded, "cover", driver())
    assert not full.is_found and not full.is_complete and "more seconds do not help" in full.notes[0]
    assert full.blocked[0].part == "cover" and full.blocked[0].blockers and full.said.startswith("no plan so far")


def test_ctrl_c_before_any_plan_says_the_bound(lidded: feeler.Scene) -> None:
    early = interrupted(lidded, "searching the quickest order")
    assert early.steps == () and math.isnan(early.seconds) and early.bound == 0.0
    assert early.said == "no plan so far"


def test_the_command_prints_the_best_so_far(
    lidded: feeler.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_glb(tmp_path / "a.glb", lidded.mockup)
    late = interrupted(lidded, "checking the way of")

    def stop(*_: Any, **__: Any) -> None:
        raise feeler.TaskInterrupted(late)

    monkeypatch.setattr(feeler, "task", stop)
    ended = run("task", tmp_path / "a.glb", "--part", "cover", "--glb", tmp_path / "film.glb", code=130)
    assert "Best so far: 3 steps" in " ".join(ended.stdout.split()) and "undo bolt" in ended.stdout
    assert ended.stderr == "feeler: interrupted: this is the best so far\n"
    assert not (tmp_path / "film.glb").exists()


def test_films_follow_the_plan(lidded: feeler.Scene, tmp_path: Path) -> None:
    task = feeler.task(lidded, "cover", {"own": driver()})
    size = task.to_glb(tmp_path / "film.glb", lidded.mockup, {"own": driver()}, speed=4.0)
    assert size == (tmp_path / "film.glb").stat().st_size
    film = animations(tmp_path / "film.glb")
    assert set(moved_nodes(film)) == {"lid", "bolt", "cover", "own"}  # the case stays still
    for step in task.steps:
        times, places = film[step.part]
        assert times[-2] == pytest.approx((step.start + step.seconds) / 4.0, abs=1e-4)
        left = np.abs(places - step.way[-1][:3, 3]).max(axis=1) < 1e-6
        assert left[-2] and np.abs(places[-1]).max() > 0.03  # out, then put aside
        before = places[times <= step.start / 4.0 + 1e-6]
        assert np.abs(before).max() < 1e-6
    undo = task.steps[1]
    times, places = film["own"]
    seat = np.abs(places - undo.tool_way[-1][:3, 3]).max(axis=1) < 1e-6
    held = times[seat]
    assert (undo.start + 0.2 * undo.seconds) / 4.0 == pytest.approx(held.min(), abs=1e-4)
    assert (undo.start + 0.6 * undo.seconds) / 4.0 == pytest.approx(held.max(), abs=1e-4)
    assert np.abs(places[[0, -1]]).max() > 0.03  # beside the parts


def test_films_refuse_other_mockups_and_tools(lidded: feeler.Scene, tmp_path: Path) -> None:
    task = feeler.task(lidded, "cover", driver())
    with pytest.raises(OptionError, match="of another mock-up"):
        task.to_glb(tmp_path / "a.glb", bolted().mockup, driver())
    with pytest.raises(OptionError, match="tools has no 'driver'"):
        task.to_glb(tmp_path / "a.glb", lidded.mockup)
    with pytest.raises(OptionError, match="speed is 0"):
        task.to_glb(tmp_path / "a.glb", lidded.mockup, driver(), speed=0.0)
    assert not (tmp_path / "a.glb").exists()


def test_the_command_writes_a_film(lidded: feeler.Scene, tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", lidded.mockup)
    words = ("--part", "cover", "--catalogue", "built-in", "--glb", tmp_path / "film.glb")
    found = run_json("task", tmp_path / "a.glb", *words)
    assert found["written"]["glb"].endswith("film.glb") and {"lid", "bolt"} <= set(animations(tmp_path / "film.glb"))


def test_edits_ask_nothing_of_the_geometry_again(lidded: feeler.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    memory, tools = Memory(), driver()
    for people in (1, 2):  # who works alone takes the shortest way
        planned(memory, lidded, "cover", tools, people=people)
    edits: list[dict[str, Any]] = [
        {"times": feeler.Times(typed={"bolt": 5.0})},
        {"times": {"stroke": 3.0}},
        {"before": [("lid", "bolt")]},
        {"people": 2},
    ]
    fresh = [feeler.task(lidded, "cover", tools, **edit).to_dict() for edit in edits]
    for name in ("cast", "collide", "without", "only"):
        monkeypatch.setattr(feeler.Scene, name, None)
    assert [planned(memory, lidded, "cover", tools, **edit).to_dict() for edit in edits] == fresh


def test_what_is_off_already_asks_little_again(lidded: feeler.Scene) -> None:
    memory, tools = Memory(), driver()
    planned(memory, lidded, "cover", tools)
    reaching = memory.reaching(lidded, tools, None, {})
    before = reaching.asked
    bare = lidded.without("lid")
    assert planned(memory, bare, "cover", tools).to_dict() == feeler.task(bare, "cover", tools).to_dict()
    assert reaching.asked == before > 0  # that the lid is out was asked before
    other = planned(memory, lidded, "cover", None)  # without tools, nothing of it serves
    assert other.to_dict() == feeler.task(lidded, "cover").to_dict()
