"""Answers that nightly runs remember: recalled where all is as it was, and in files that may be damaged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from night_edits import assembly, edits
from night_scene import covers, driver, lid, parts, scene_of
from shapes import box, cube
from test_maintain import facts

import feeler
from feeler.parts import PartNumber
from feeler.plan.blocking import Mover
from feeler.tasks import nightly, reached
from feeler.tasks.memory import Memory, carried
from feeler.tasks.regions import Noted, Regions, near
from feeler.tasks.snapshots import Changes, Snapshot, keys_of
from feeler.tasks.stored_answers import StoredAnswers
from feeler.tasks.watched import Recall, WatchedScene

ROWS = ["s0/cover", "s1/cover", "s1/bolt", "s0/case"]


def planned(scene: feeler.Scene, previous: Any = None, **options: Any) -> feeler.Maintenance:
    return feeler.maintain(scene, ROWS, **{"tools": driver(), "threads": 1, **options}, previous=previous)


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_rows_are_those_of_a_full_run_after_random_edits(seed: int, tmp_path: Path) -> None:
    """Parts move a little or far, go, come, and block or open ways; each run is the previous one of the next."""
    rng = np.random.default_rng(seed)
    meshes = assembly(rng)
    tools: dict[str, Any] = {"tools": driver() if seed else None}
    run = planned(scene_of(meshes), **tools)
    for n, (_, edited) in zip(range(2), edits(rng, meshes), strict=False):
        run.save(tmp_path / "last.json")
        scene, times = scene_of(edited), {"take": 8.0 + n}
        run = planned(scene, tmp_path / "last.json", times=times, **tools)
        assert all("renamed from" in hint for hint in run.hints)
        assert facts(run) == facts(planned(scene, times=times, **tools))


def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The fasteners of which `access` is asked from now on."""
    found: list[str] = []
    access = reached.access

    def counted(scene: feeler.Scene, tool: Any, rows: feeler.Fasteners, **options: Any) -> Any:
        found.append(rows[0].path)
        return access(scene, tool, rows, **options)

    monkeypatch.setattr(reached, "access", counted)
    return found


def test_only_what_looked_at_a_change_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """One row takes out all covers: a lid that comes over one bolt bears on the questions of that bolt alone."""
    rows = [{"part": tuple(covers())}]
    base = feeler.maintain(scene_of(parts()), rows, tools=driver())
    meshes = parts()
    meshes["s2/lid"] = lid(2.0)
    full = feeler.maintain(scene_of(meshes), rows, tools=driver())
    found = asked(monkeypatch)
    run = feeler.maintain(scene_of(meshes), rows, tools=driver(), previous=base)
    assert facts(run) == facts(full) and not run[0].is_kept and run[0].delta == 10.0
    assert found and set(found) == {"s2/bolt"}


def test_other_times_and_tools_ask_what_they_change(monkeypatch: pytest.MonkeyPatch) -> None:
    base = planned(scene_of(parts(2)))
    found = asked(monkeypatch)
    run = planned(scene_of(parts(2)), base, times={"take": 60.0})
    assert not found and all(row.delta > 50.0 for row in run[:2]) and not any(row.is_kept for row in run)
    other = feeler.Tool(driver().vertices * [1.0, 1.0, 1.1], driver().faces, name="driver")
    planned(scene_of(parts(2)), base, tools=other)
    assert set(found) == {"s0/bolt", "s1/bolt"}


def test_a_mistake_in_a_row_loses_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = nightly.task

    def wrong(scene: feeler.Scene, wanted: Any, *args: Any, **options: Any) -> feeler.Task:
        if wanted == [scene.mockup.part_paths.index("s1/bolt")]:
            raise AttributeError("no such thing")
        return plain(scene, wanted, *args, **options)

    monkeypatch.setattr(nightly, "task", wrong)
    run = planned(scene_of(parts(2)))
    assert [row.state for row in run] == ["out", "out", "failed", "out"]
    assert "please report it (AttributeError: no such thing)" in json.dumps(run.to_dict())


def test_parts_that_are_remembered_are_asked_for_further_directions(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a part that rides on another is, for those of the other."""
    base = planned(scene_of(parts(2)))
    opposed, further = Mover.opposed, []

    def more(self: Mover, direction: tuple[float, float, float]) -> set[int]:
        further.append(self._opposed((0.6, 0.8, 0.0), set()))
        return opposed(self, direction)

    monkeypatch.setattr(Mover, "opposed", more)
    run = planned(scene_of(parts(2)), base, times={"take": 60.0})
    assert further and all(row.state == "out" for row in run)


def test_tools_are_asked_again_where_other_strokes_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Longer tools are not looked at beyond one that is quick enough: then they may be quicker all the same."""
    scene, _, memory = known()
    limits: list[int] = []
    quickest = reached.quickest

    def counted(scene: feeler.Scene, tools: Any, row: Any, turns: float, enough: int) -> Any:
        limits.append(enough)
        return quickest(scene, tools, row, turns, enough)

    monkeypatch.setattr(reached, "quickest", counted)
    reaching = reached.Reaching(WatchedScene.of(scene, Recall(memory, lambda: True)), "built-in", 1)
    row = feeler.find_fasteners(scene)[0]
    for enough in (90, 90, 60):
        reaching.ask(row, frozenset(), 10.0, enough)
    assert limits == [90, 60]


def test_outer_parts_that_move_a_little_leave_answers_as_they_were(monkeypatch: pytest.MonkeyPatch) -> None:
    """The box of all parts is another one: rows are planned again, from what is known."""
    meshes = parts(2)
    base = planned(scene_of(meshes))
    met: list[Any] = []
    looked, beside = Mover._met, Mover._looked

    def counted(mover: Mover, *args: Any) -> Any:
        met.append(mover.parts)
        return looked(mover, *args)

    def around(mover: Mover) -> Any:
        met.append(mover.parts)
        return beside(mover)

    monkeypatch.setattr(Mover, "_met", counted)
    monkeypatch.setattr(Mover, "_looked", around)
    for by, is_known in ((-1e-3, True), (1e-3, True), (0.3, False)):
        meshes["frame/high"] = parts(2)["frame/high"][0] + by, meshes["frame/high"][1]
        scene = scene_of(meshes)
        full = planned(scene)
        met.clear()
        run = planned(scene, base)
        assert facts(run) == facts(full) and not any(row.is_kept for row in run)
        assert (not met) == is_known, by


def test_how_deep_a_part_gets_is_asked_again_where_one_of_the_two_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A peg through the cover and into the case, below a lid: depths say along which directions it leaves."""
    meshes = {**parts(1), "s0/peg": box((0.012, -0.002, -0.02), (0.016, 0.002, 0.002)), "s0/lid": lid(0.0)}
    base = feeler.maintain(scene_of(meshes), ["s0/peg"], threads=1)
    asked: list[int] = []
    measured = Mover._depths

    def counted(mover: Mover, some: list[int], pose: Any) -> Any:
        asked.extend(some)
        return measured(mover, some, pose)

    monkeypatch.setattr(Mover, "_depths", counted)
    for path, by, again in (("s0/lid", (0.0, 0.0, 1e-3), set()), ("s0/case", (0.0, 0.0, 1e-4), {"s0/case"})):
        moved = {**meshes, path: (meshes[path][0] + np.array(by), meshes[path][1])}
        scene = scene_of(moved)
        full = feeler.maintain(scene, ["s0/peg"], threads=1)
        asked.clear()
        run = feeler.maintain(scene, ["s0/peg"], threads=1, previous=base)
        assert facts(run) == facts(full) and not run[0].is_kept
        assert {scene.mockup.part_paths[part] for part in asked} == again, path


def test_a_night_without_changes_looks_for_no_fasteners(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    planned(scene_of(parts(2))).save(tmp_path / "last.json")
    looked: list[int] = []
    found = nightly.find_fasteners

    def counted(scene: feeler.Scene) -> feeler.Fasteners:
        looked.append(1)
        return found(scene)

    monkeypatch.setattr(nightly, "find_fasteners", counted)
    run = planned(scene_of(parts(2)), tmp_path / "last.json")
    assert not looked and all(row.is_kept for row in run) and not run.changes
    run.save(tmp_path / "next.json")
    assert (tmp_path / "next.json.answers").read_bytes() == (tmp_path / "last.json.answers").read_bytes()
    meshes = parts(2)
    named = {("s1/other" if path == "s1/lid" else path): mesh for path, mesh in meshes.items()}
    moved = {**meshes, "s0/lid": lid(0.6)}
    for other in (scene_of(named), scene_of(moved), scene_of(meshes).without(["s1/lid"])):
        looked.clear()
        run = planned(other, tmp_path / "last.json")
        assert (run.changes or run.renamed) and looked
    looked.clear()
    # Other times: rows are planned anew, with fasteners, among parts that are as they were.
    run = planned(scene_of(meshes), tmp_path / "last.json", times={"take": 9.0})
    assert looked and not run.changes and facts(run) == facts(planned(scene_of(meshes), times={"take": 9.0}))


def test_regions_are_near_what_bears_on_them() -> None:
    rng = np.random.default_rng(2)

    def boxes(count: int) -> Any:
        low = rng.uniform(-1.0, 1.0, (count, 3))
        return np.stack([low, low + rng.uniform(0.0, 0.3, (count, 3))], axis=1)

    rows = []
    for n in range(40):
        ways = rng.uniform(-1.0, 1.0, (2, 1, 3)) * rng.integers(0, 2, (2, 1, 3))
        rows.append(Regions(n == 0, boxes(1), np.concatenate([boxes(2), ways], axis=1), boxes(n % 2), frozenset()))
    parts = boxes(30)
    parts[0] = np.nan
    found = near(rows, parts)
    for n, row in enumerate(rows):
        for k, part in enumerate(parts):
            meets = row.meets(*part)
            assert found[n, k] or not row.bear(part, part[None]), (n, k)
            assert row.bear(part, np.stack([part, part + 9.0])) >= meets
            steps = row.sweeps[:, None, :2] + np.linspace(0.0, 1.0, 50)[None, :, None, None] * row.sweeps[:, None, 2:]
            sampled = [*row.boxes, *steps.reshape(-1, 2, 3)]
            assert meets or not any((each[0] <= part[1]).all() and (each[1] >= part[0]).all() for each in sampled)
    assert found[0].all() and found[:, 0].all() and not found.all()


def test_what_is_near_a_tool_is_not_in_its_way() -> None:
    """A part that comes near to a bolt out of reach bears on no row, nor is it said to block it."""
    meshes = parts(1)
    meshes.update({"s0/lid": lid(0.0), "s0/more": cube((0.5, 0.5, 0.5), 0.004)})
    rows = [{"part": "s0/cover", "keep": "s0/lid"}]
    base = feeler.maintain(scene_of(meshes), rows, tools=driver(), threads=1)
    meshes["s0/more"] = cube((0.1, 0.1, 0.02), 0.004)
    run, full = (feeler.maintain(scene_of(meshes), rows, tools=driver(), previous=last) for last in (base, None))
    assert run[0].is_kept and facts(run) == facts(full) and run[0].blockers == ("s0/lid",)


def test_damaged_answers_are_a_hint_and_no_wrong_row(tmp_path: Path) -> None:
    meshes = parts(1)
    last, beside = tmp_path / "last.json", tmp_path / "last.json.answers"
    feeler.maintain(scene_of(meshes), covers(1)).save(last)
    meshes["s0/lid"] = lid(0.0)
    scene = scene_of(meshes)
    full, data = feeler.maintain(scene, covers(1)), beside.read_bytes()
    for bad, said in (
        (data[:-9], "damaged, or of another run"),
        (data[:200] + b"x" + data[201:], "damaged, or of another run"),
        (b"", "damaged, or of another run"),
        (None, "missing"),
    ):
        beside.unlink() if bad is None else beside.write_bytes(bad)
        run = feeler.maintain(scene, covers(1), previous=last)
        assert facts(run) == facts(full) and said in run.hints[0] and str(beside) in run.hints[0]
    # Of another version, or not what it says.
    text = json.loads(last.read_text())
    for bad, said in ((b"feeler answers 0 of 0\n", "another version"), (b"{}", "no answers"), (data[:60], "cut off")):
        beside.write_bytes(bad)
        last.write_text(json.dumps({**text, "answers": digest(bad)}))
        run = feeler.maintain(scene, covers(1), previous=last)
        assert facts(run) == facts(full) and said in run.hints[0]
    beside.write_bytes(data)
    last.write_text(json.dumps(text))
    assert not feeler.maintain(scene, covers(1), previous=last).hints


def digest(data: bytes) -> str:
    from feeler.tasks.digests import short

    return short(data)


def known() -> tuple[feeler.Scene, Snapshot, Memory]:
    scene = scene_of(parts(2))
    fasteners = feeler.find_fasteners(scene)
    snapshot = Snapshot.of(scene, fasteners, feeler.holds(scene, fasteners))
    return scene, snapshot, Memory(keys_of(scene.mockup), snapshot)


def test_an_answer_holds_among_the_same_parts_where_it_looked() -> None:
    scene, snapshot, memory = known()
    watched = WatchedScene.of(scene, Recall(memory, lambda: True))
    asks: list[int] = []

    def ask(there: feeler.Scene) -> Any:
        def cast() -> list[Any]:
            asks.append(1)
            hit = there.cast(driver(), place(0.0, 0.3), place(0.0, -0.2))
            return [None if hit is None else PartNumber(hit.part)]

        return there._recalled("cast", [], ["driver"], cast)[0]

    bolt, cover = (scene.mockup.part_paths.index(path) for path in ("s0/bolt", "s0/cover"))
    assert ask(watched) == bolt and ask(watched) == bolt and len(asks) == 1
    assert ask(watched.without(["s1/bolt"])) == bolt and len(asks) == 1  # it did not look there
    assert ask(watched.without(["s0/bolt"])) == cover or len(asks) == 2
    assert ask(watched) == bolt and len(asks) == 2
    # In a later run.
    meshes = parts(2)
    for path, is_known in (("s1/lid", True), ("s0/bolt", False), ("s0/lid", False)):
        by = [0.0, 0.0, 1e-4] if "bolt" in path else [-0.5, 0.0, 0.05]
        moved = {**meshes, path: (meshes[path][0] + by, meshes[path][1])}
        later = scene_of(moved)
        fasteners = feeler.find_fasteners(later)
        new = Snapshot.of(later, fasteners, feeler.holds(later, fasteners))
        left = list(carried(memory, snapshot, new, Changes(snapshot, new)))
        again = Memory(keys_of(later.mockup), new)
        again.take(left)
        asks.clear()
        ask(WatchedScene.of(later, Recall(again, lambda: True)))
        assert (not asks) == is_known, path


def place(x: float, z: float) -> np.ndarray[Any, Any]:
    pose = np.eye(4)
    pose[:3, 3] = x, 0.0, z
    return pose


def test_answers_that_time_ended_are_not_kept() -> None:
    scene, _, memory = known()
    recall = Recall(memory, lambda: False)
    WatchedScene.of(scene, recall)._recalled("one", [0], [1.5], lambda: ["x"])
    assert not recall.new and not list(memory)


def test_answers_go_through_bytes() -> None:
    scene, snapshot, memory = known()
    recall = Recall(memory, lambda: True)
    watched = WatchedScene.of(scene, recall)
    watched._recalled("one", [0], [1.5], lambda: [watched.rays([[0, 0, 1.0]], [[0, 0, -1.0]]).distances, float("nan")])
    stored = StoredAnswers.of(list(snapshot.parts), memory, {"row": list(recall.used)})
    answers, rows = StoredAnswers(list(snapshot.parts), stored.data).read()
    assert len(answers) == 1 and rows == {"row": (answers[0].name,)}
    assert answers[0].met == recall.new[0].met and repr(answers[0].data) == repr(recall.new[0].data)
    assert StoredAnswers.of(list(snapshot.parts), memory, {}).read() == ([], {})


def test_scenes_of_few_parts_look_at_these_alone() -> None:
    scene, _, memory = known()
    watched = WatchedScene.of(scene, Recall(memory, lambda: True))
    watched.only(["s0/case"]).depth(driver(), place(0.0, -0.02))
    looked = watched.noted.regions()
    assert looked.asked == {"s0/case"} and not len(looked.boxes) and not len(looked.solids)
    with watched.noted.apart() as apart:
        watched.only(["s1/case"]).rays([[1.0, 0, 1.0]], [[0, 0, -1.0]])
        assert apart().asked == {"s1/case"}
    assert watched.noted.regions().asked == {"s0/case", "s1/case"}


def test_boxes_that_a_part_sweeps_are_those_around_its_triangles() -> None:
    """Not what is inside a ring."""
    scene, _, memory = known()
    watched = WatchedScene.of(scene, Recall(memory, lambda: True))
    rest = watched.without(["s0/cover", "s0/bolt"])
    cover = feeler.Tool.of_parts(scene.mockup, ["s0/cover"])
    assert rest.cast(cover, place(0.0, 0.0), place(0.0, 0.5), touching="free") is None
    looked = watched.noted.regions()
    assert looked.meets(np.array([0.01, -0.001, 0.3]), np.array([0.011, 0.001, 0.31]))
    assert not looked.meets(np.array([-0.001, -0.001, 0.3]), np.array([0.001, 0.001, 0.31]))
    assert isinstance(watched.noted, Noted)


def test_sentences_name_parts_and_tables() -> None:
    base = feeler.maintain(scene_of(parts(1)), ["s0/cover"], tools=driver())
    meshes = parts(1)
    meshes["s0/lid"] = lid(0.0)
    both = feeler.maintain(scene_of(meshes), ["s0/cover"], tools=driver(), times={"take": 60.0}, previous=base)
    assert both[0].change == "+1 min 58 s since lid moved and other times were given"
    base.options["version"] = "1 of 0.0"
    other = feeler.maintain(scene_of(meshes), ["s0/cover"], tools=driver(), seed=3, previous=base)
    assert other[0].change == "+10 s since lid moved, another version of feeler runs and the search has other limits"
