"""Tasks in the workbench: a plan in steps, its edits, and how they are kept."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import box, mockup_of
from test_task import TAPPED, bolt, driver, ring
from test_workbench_cards import LONGEST_S, answered, card_of
from workbench_scene import Bench, at

import feeler
from feeler.errors import WorkbenchError
from feeler.project.book import open_or_make
from feeler.workbench.report import as_html
from feeler.workbench.report.as_json import report_json
from feeler.workbench.report.as_xlsx import _sheets
from feeler.workbench.report.content import report_of
from feeler.workbench.report.source import of_book
from feeler.workbench.report.values import Media
from feeler.workbench.session import cards as session_cards
from feeler.workbench.session import task_answers
from feeler.workbench.session.answering import Answered, Asked, kept_answer
from feeler.workbench.session.record import digest, read_record
from feeler.workbench.session.replaying import replay
from feeler.workbench.session.session import Session

NAMES = ("left", "right", "case", "lid", "post")
LEFT, RIGHT, CASE, LID, POST = range(5)


def mockup() -> feeler.Mockup:
    """Two bolts in a case, a lid above the heads, and a post aside."""
    place = np.eye(4)
    place[0, 3] = 0.1
    case, other = ring(TAPPED, -0.04, 0.0), ring(TAPPED, -0.04, 0.0)
    faces = np.concatenate([case[1], other[1] + len(case[0])])
    parts = (
        bolt(0.03),
        bolt(0.03, place),
        (np.concatenate([case[0], other[0] + [0.1, 0.0, 0.0]]), faces),
        box((-0.03, -0.03, 0.02), (0.13, 0.03, 0.025)),
        box((0.3, 0.3, -0.04), (0.32, 0.32, 0.0)),
    )
    return mockup_of(dict(zip(NAMES, parts, strict=True)))


@pytest.fixture(scope="module")
def world() -> feeler.Mockup:
    return mockup()


def bench_of(world: feeler.Mockup) -> Bench:
    return Bench(mockup=world, tools=[driver()])


def asked(bench: Bench, **more: Any) -> int:
    number = int(bench.command("ask", question="task", parts=[LEFT, RIGHT], tools=["driver"], **more)["id"])
    card = answered(bench, number)
    assert card.state == "done", card
    return number


def steps(bench: Bench, number: int) -> list[dict[str, Any]]:
    found = bench.session.ask("card", {"id": number})
    assert found is not None
    return list(found["task"]["steps"])


def order(bench: Bench, number: int) -> list[str]:
    answered(bench, number)
    return [NAMES[step["part"]] for step in steps(bench, number)]


def test_steps_whose_way_was_not_tried_stand_where_their_parts_are(
    world: feeler.Mockup, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the time limit a task has steps, without ways."""
    planned = task_answers.planned

    def cut(*given: Any, **more: Any) -> feeler.Task:
        plan = planned(*given, **more)
        steps = tuple(replace(step, way=np.empty((0, 4, 4))) for step in plan.steps)
        return replace(plan, is_found=False, is_complete=False, steps=steps)

    monkeypatch.setattr(task_answers, "planned", cut)
    bench = bench_of(world)
    number = asked(bench)
    answer = bench.session.ask("card", {"id": number}) or {}
    assert not card_of(bench, number).is_good and len(answer["task"]["steps"]) == len(answer["ways"]) > 2
    assert all(way["poses"] == [np.eye(4).ravel().tolist()] and way["length"] == 0.0 for way in answer["ways"])


def test_a_task_is_planned_in_steps_with_tools_and_times(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    card, answer = card_of(bench, number), bench.session.ask("card", {"id": number}) or {}
    plan = feeler.task(bench.scene, ["left", "right"], {"driver": driver()})
    task = answer["task"]
    assert card.title == "How are left and 1 more taken out?" and card.is_good
    assert card.sentence == f"B{plan.said[1:]}.".replace("+-", "±") and "not below" in card.sentence
    assert [(step["verb"], NAMES[step["part"]], step["tool"]) for step in task["steps"]] == [
        (step.verb, step.part, step.tool) for step in plan.steps
    ]
    assert (task["seconds"], task["bound"]) == (plan.seconds, plan.bound) and task["people"] == 1
    assert [way["poses"] for way in answer["ways"]] == [step.way.reshape(-1, 16).tolist() for step in plan.steps]
    assert answer["ways"][0]["parts"] == [LID] and answer["ways"][1]["length"] > 0.03
    undo = task["steps"][1]
    assert undo["strokes"] == plan.steps[1].strokes and undo["arithmetic"] == plan.steps[1].arithmetic
    ghost = bench.session.ask("task_tool", {"id": number, "step": 1}) or {}
    # The driver stands above the head, in the world's frame.
    x = float(plan.steps[1].tool_way[-1][0, 3])
    assert ghost["manifest"]["lower"][0] == pytest.approx(x - 0.002) and ghost["manifest"]["lower"][2] > 0.0
    assert bench.session.ask("task_tool", {"id": number, "step": 0}) is None
    with pytest.raises(WorkbenchError, match="there is no step 9"):
        bench.session.ask("task_tool", {"id": number, "step": 9})
    bench.command("way_take", id=number)
    assert {LID, LEFT, RIGHT} == set(bench.session.current.out)


def test_edits_change_the_plan_and_undo_takes_them_back(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    first, second = order(bench, number)[1:]
    whole = card_of(bench, number).sentence
    assert bench.command("task_edit", id=number, edit="before", parts=second, later=first)["undo_depth"] == 1
    assert order(bench, number) == ["lid", second, first]
    bench.command("task_edit", id=number, edit="time", parts=second, seconds=100.0)
    assert order(bench, number) == ["lid", second, first]
    typed = steps(bench, number)[1]
    assert typed["is_typed"] and typed["seconds"] == 108.0 and "typed" in typed["arithmetic"]
    bench.command("task_edit", id=number, edit="off", parts="lid")
    assert order(bench, number) == [second, first]
    bench.command("task_edit", id=number, edit="off", parts=first)
    assert order(bench, number) == [second], "what is asked for can be off, too"
    edits = bench.document["cards"][0]["edits"]
    assert edits == {
        "off": sorted([first, "lid"]),
        "times": [[second, 100.0]],
        "before": [[second, first]],
        "table": "",
        "catalogue": "",
    }
    for expected in ([second, first], ["lid", second, first], ["lid", second, first], ["lid", first, second]):
        bench.command("undo")
        assert order(bench, number) == expected
    assert card_of(bench, number).sentence == whole and bench.document["cards"][0]["edits"]["times"] == []
    bench.command("redo")
    assert order(bench, number) == ["lid", second, first]
    # The other way round takes the first one's place, and what is given back is as before.
    bench.command("task_edit", id=number, edit="before", parts=first, later=second)
    assert bench.document["cards"][0]["edits"]["before"] == [[first, second]]
    bench.command("task_edit", id=number, edit="free", parts=first, later=second)
    bench.command("task_edit", id=number, edit="time", parts=first, seconds=1.0)
    bench.command("task_edit", id=number, edit="time", parts=first)
    bench.command("task_edit", id=number, edit="off", parts="lid")
    bench.command("task_edit", id=number, edit="on", parts="lid")
    answered(bench, number)
    assert card_of(bench, number).sentence == whole and dict(bench.session.current.task_edits) == {}


def test_what_is_not_an_edit_is_refused(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    for given, match in (
        ({"id": 99, "edit": "off", "parts": "lid"}, "there is no 99"),
        ({"id": number, "edit": "never", "parts": "lid"}, "never"),
        ({"id": number, "edit": "off", "parts": "nothing"}, "nothing"),
        ({"id": number, "edit": "time", "parts": "lid", "seconds": -1.0}, "-1"),
        ({"id": number, "edit": "before", "parts": "lid"}, "go after"),
        ({"id": number, "edit": "before", "parts": "lid", "later": "lid"}, "before itself"),
    ):
        with pytest.raises(WorkbenchError, match=match):
            bench.command("task_edit", **given)
    assert bench.session.current.cards[0].state == "done", "nothing was asked again"
    for wrong in ({"tool": "driver"}, {"clearance": 0.1}, {"people": 0}, {"tools": ["none"]}):
        with pytest.raises(WorkbenchError):
            bench.command("ask", question="task", parts=LEFT, **wrong)
    with pytest.raises(WorkbenchError, match="no people"):
        bench.command("ask", question="removal", parts=LEFT, people=2)


def test_what_nothing_frees_is_named(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    bench.command("task_edit", id=number, edit="before", parts="left", later="lid")
    card = answered(bench, number)
    answer = bench.session.ask("card", {"id": number}) or {}
    assert card.is_good is False and card.sentence.startswith("Blocked")
    assert answer["task"]["steps"] == [] == answer["ways"] and answer["task"]["seconds"] is None
    assert any("order was forced" in note for note in answer["task"]["notes"])


def test_tools_are_of_the_catalogue_unless_they_are_named(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = int(bench.command("ask", question="task", parts=LEFT)["id"])
    answered(bench, number)
    undo = next(k for k, step in enumerate(steps(bench, number)) if step["verb"] == "undo")
    step = steps(bench, number)[undo]
    assert step["tool"].startswith(("socket 13", "ring 13", "open 13"))
    ghost = bench.session.ask("task_tool", {"id": number, "step": undo}) or {}
    lower, upper = ghost["manifest"]["lower"], ghost["manifest"]["upper"]
    # About the head of the bolt, and not below its bearing face.
    assert lower[0] < 0.0 < upper[0] and lower[1] < 0.0 < upper[1] and -1e-6 < lower[2] < 0.006 < upper[2]
    number = int(bench.command("ask", question="task", parts=LEFT, tools=[])["id"])
    answered(bench, number)
    assert {step["tool"] for step in steps(bench, number)} == {""}


def test_several_people_work_at_once(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    alone, two = asked(bench), asked(bench, people=2)
    assert {step["person"] for step in steps(bench, two)} == {0, 1}
    seconds = [(bench.session.ask("card", {"id": each}) or {})["task"]["seconds"] for each in (alone, two)]
    assert seconds[1] < seconds[0]


def test_a_task_is_stale_once_parts_are_moved(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    way = [at(0, 0, 0).ravel().tolist(), at(0, 0, 1.0).ravel().tolist()]
    bench.command("way_take", ways=[{"parts": [POST], "poses": way, "clearance": None}])
    assert bench.document["cards"][0]["is_stale"]
    bench.command("card_again", id=number)
    answered(bench, number)
    assert not bench.document["cards"][0]["is_stale"]


def test_an_edit_gives_up_the_plan_that_is_searched(world: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    bench, begun = bench_of(world), threading.Event()
    seen: list[object] = []

    def slow(given: Asked, progress: Callable[[float, str], None]) -> Answered:
        seen.append(given.edits)
        begun.set()
        end = time.monotonic() + LONGEST_S
        while len(seen) < 2 and time.monotonic() < end:
            progress(0.5, "thinking")
            time.sleep(0.001)
        return Answered(f"plan {len(seen)}", True)

    monkeypatch.setattr(session_cards, "task_answer", slow)
    number = bench.command("ask", question="task", parts=LEFT)["id"]
    assert begun.wait(LONGEST_S)
    bench.command("task_edit", id=number, edit="off", parts="lid")
    assert answered(bench, number).sentence == "plan 2" and len(seen) == 2
    begun.clear()
    seen.clear()
    bench.command("card_again", id=number)
    assert begun.wait(LONGEST_S)
    bench.command("card_cancel", id=number)
    assert answered(bench, number).state == "cancelled"


def test_a_project_keeps_plan_and_edits(world: feeler.Mockup, tmp_path: Path) -> None:
    path = tmp_path / "task.feelproj"

    def opened() -> Bench:
        bench = bench_of(world)
        session = Session(has_threads=False, project=open_or_make(path))
        session.open(world, feeler.Scene(world), None, tools=[driver()])
        bench.session = session
        return bench

    bench = opened()
    number = asked(bench)
    first, second = order(bench, number)[1:]
    bench.command("task_edit", id=number, edit="before", parts=second, later=first)
    bench.command("task_edit", id=number, edit="time", parts="lid", seconds=7.0)
    plan = order(bench, number), card_of(bench, number).sentence, steps(bench, number)
    assert bench.session._saver is not None and bench.session._saver.wait(LONGEST_S)
    bench.session.close()
    bench = opened()
    assert (order(bench, number), card_of(bench, number).sentence, steps(bench, number)) == plan
    assert bench.document["cards"][0]["edits"]["times"] == [["lid", 7.0]]
    with contextlib.closing(open_or_make(path, read_only=True)) as book:
        report = report_of(of_book(book, world, content=digest(world)))
    (question,) = report.questions
    assert [(row.verb, row.path, row.edited) for row in question.task] == [
        ("take out", "lid", "time typed"),
        ("undo", second, "order forced"),
        ("undo", first, "order forced"),
    ]
    assert f"Forced: {second} before {first}." in question.notes and len(question.ways) == 3
    page = as_html.html_page(report, Media()).decode()
    assert page.count("<rect") == 3 and "7 +- 0 s, typed" in page and "0.5 min" in page
    assert "least clearance" not in page, "it was not measured"
    assert report_json(report)["questions"][0]["task"][0]["edited"] == "time typed"
    (rows,) = (rows for name, _, rows in _sheets(report) if name == "tasks")
    assert next(iter(rows))[1:4] == [1, "take out", "lid"]
    bench.command("hide", parts="post")
    assert card_of(bench, number).state == "done", "nothing is asked again"
    bench.command("task_edit", id=number, edit="free", parts=second, later=first)
    assert order(bench, number) == ["lid", first, second]
    bench.session.close()


def test_an_answer_of_a_project_that_names_no_part_is_not_taken(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    card, answer = card_of(bench, number), bench.session.ask("card", {"id": number}) or {}

    def kept(**changes: Any) -> Answered | None:
        task = {**answer["task"], **changes}
        return kept_answer(card, {"kind": "card", **answer, "task": task}, None, world.part_count)

    whole, (first, *rest) = kept(), answer["task"]["steps"]
    assert whole is not None and whole.task == answer["task"]
    assert kept(steps=[{**first, "part": 99}, *rest]) is None
    assert kept(steps=[{**first, "after": [7]}, *rest]) is None
    assert kept(steps=rest) is None, "a way without its step"
    assert kept(blocked=[{"part": None, "because": "", "blockers": [-1]}]) is None
    assert kept(seconds="long") is None


def test_a_record_repeats_edits_without_the_card(world: feeler.Mockup, tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    bench = Bench(driver(), mockup=world, record=path)
    number = asked(bench)
    bench.command("task_edit", id=number, edit="off", parts="lid")
    bench.command("undo")
    bench.command("hide", parts="post")
    answered(bench, number)
    bench.session.close()
    record = read_record(path)
    assert any("task_edit" in str(entry) for entry in path.read_text().splitlines())
    assert replay(record, world, feeler.Scene(world), driver()).parted is None
