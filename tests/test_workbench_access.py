"""Which tools of the catalogue reach fasteners, asked in the workbench: rows, the tool in its seat, older answers."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import mockup_of
from test_task import CLEAR, TAPPED, bolt, ring
from test_workbench_cards import answered, asked, bolts, card_of
from test_workbench_task_tools import OWN
from workbench_scene import FACES as BOX_FACES
from workbench_scene import Bench, at, corners

import feeler
from feeler.errors import WorkbenchError
from feeler.progress import Progress
from feeler.project.book import open_or_make
from feeler.workbench.session import access_answers
from feeler.workbench.session.answering import kept_answer
from feeler.workbench.session.session import Session

FREE = "bolt_free"
WRENCH_17 = OWN.replace("13", "17").replace("28", "34")
"""A catalogue of one open spanner that fits the bolts; it has no hand."""


def rows_of(answer: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {row["name"]: row for row in answer["reaches"]}


def roofed(height: float) -> feeler.Mockup:
    """The bolts on their plate, under a roof."""
    given = bolts()
    roof = corners((-0.3, -0.3, height), (0.3, 0.3, height + 0.01))
    return feeler.Mockup(
        np.concatenate([given.vertices, roof]),
        np.concatenate([given.faces, BOX_FACES + len(given.vertices)]),
        np.concatenate([given.part_of_face, np.full(12, 4)]).astype(np.uint32),
        [*given.part_names, "roof"],
    )


def test_each_head_has_the_first_tool_that_fits_and_reaches() -> None:
    bench = Bench(None, mockup=bolts(), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access", catalogue=True)
    assert card.title == "Which tool reaches which fasteners?" and dict(card.options) == {"catalogue": True}
    assert card.sentence == "Tools reach all 2 fasteners." and card.is_good is True
    tools = feeler.catalogue()
    heads = feeler.find_fasteners(bench.mockup)
    found = feeler.access(bench.scene, tools, heads, hand=tools.hand)
    assert [row["part"] for row in answer["reaches"]] == sorted(row["part"] for row in answer["reaches"])[::-1]
    for row, head in zip(found, heads, strict=True):
        shown = rows_of(answer)[head.path]
        assert (shown["tool"], shown["tools"]) == (row.tool, [row.tool])
        assert (shown["swing_deg"], shown["strokes"], shown["has_hand"]) == (row.swing_deg, row.strokes, True)
        assert shown["is_catalogue"] and shown["head"] == "hexagon 17 mm" and shown["pose"] == row.pose.ravel().tolist()
        # The fan is the arc of the far end over the whole swing.
        arms = np.array(shown["fan"]) - shown["point"]
        assert np.ptp(np.linalg.norm(arms[:, :2], axis=1)) < 1e-9
        steps = np.diff(np.unwrap(np.arctan2(arms[:, 1], arms[:, 0])))
        assert math.degrees(abs(steps.sum())) == pytest.approx(row.swing_deg)
    names = {row.tool for row in found}
    assert {each["name"]: each["figure"] for each in answer["facts"]} == dict.fromkeys(names, "1 fastener")
    alone, _ = asked(bench, "access", catalogue=True, parts=FREE)
    assert alone.title == "Which tool reaches bolt_free?"
    assert alone.sentence == f"The {rows_of(answer)[FREE]['tool']} reaches it."


def test_the_whole_chain_stands_in_its_seat() -> None:
    bench = Bench(None, mockup=bolts(), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access", catalogue=True)
    for number, row in enumerate(answer["reaches"]):
        ghost = bench.session.ask("reach_tool", {"id": card.id, "row": number}) or {}
        names = [path.rsplit("/", 1)[-1] for path in ghost["manifest"]["parts"]]
        assert names == ["socket", "ratchet", "grip", "hand"]
        lower, upper = np.array(ghost["manifest"]["lower"]), np.array(ghost["manifest"]["upper"])
        assert (lower < row["point"]).all() and (upper > row["point"]).all(), "it is around the head"
    with pytest.raises(WorkbenchError, match="there is no row 2"):
        bench.session.ask("reach_tool", {"id": card.id, "row": 2})


def test_a_hand_that_does_not_fit_is_said_and_what_blocks() -> None:
    """Under a roof the open spanner fits, without a hand; lower, nothing does."""
    bench = Bench(None, mockup=roofed(0.04), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access", catalogue=True, parts=FREE)
    (row,) = answer["reaches"]
    assert row["is_reachable"] and row["has_hand"] is False and card.is_good is False
    assert card.sentence == f"The {row['tool']} reaches it; a hand does not fit at its grip."
    ghost = bench.session.ask("reach_tool", {"id": card.id, "row": 0}) or {}
    assert not any(path.endswith("/hand") for path in ghost["manifest"]["parts"])
    low = Bench(None, mockup=roofed(0.002), pose=at(0, 0, 0.5))
    card, answer = asked(low, "access", catalogue=True)
    assert card.is_good is False and card.sentence == "No tool reaches any of 2 fasteners."
    assert all(4 in row["blockers"] and row["tool"] and row["tools"] == [] for row in answer["reaches"])
    assert all(row["strokes"] is None and row["has_hand"] is None for row in answer["reaches"])
    # Gloves need room, too: below what stands free of the roof by less.
    bare, gloved = (
        asked(Bench(None, mockup=roofed(0.09), pose=at(0, 0, 0.5)), "access", catalogue=True, parts=FREE, **more)[1]
        for more in ({}, {"clearance": 0.02})
    )
    assert bare["reaches"][0]["has_hand"] and bare["reaches"][0]["tool"] != gloved["reaches"][0]["tool"]


def test_opened_tools_come_before_the_catalogue() -> None:
    long = feeler.Tool(corners((-0.01, -0.01, 1e-4), (0.01, 0.01, 0.1)), BOX_FACES, "long")
    bench = Bench(long, mockup=bolts(), pose=at(0, 0, 0.5))
    _, answer = asked(bench, "access", catalogue=True)
    free, caught = rows_of(answer)[FREE], rows_of(answer)["bolt_caught"]
    assert free["tool"] == "long" and not free["is_catalogue"] and free["has_hand"] is None
    assert caught["is_catalogue"] and "ratchet" in caught["tool"]
    assert bench.session.ask("reach_tool", {"id": answer["id"], "row": answer["reaches"].index(free)}) is None
    for args, said in (
        ({"tool": "long"}, "this question has no tool"),
        ({"grip": "z"}, "this question has no grip"),
        ({"seconds": 3}, "this question has no seconds"),
        ({"tools": ["none"]}, "there is no 'none'"),
    ):
        with pytest.raises(WorkbenchError, match=said):
            bench.command("ask", question="access", catalogue=True, **args)
    with pytest.raises(WorkbenchError, match="this question has no catalogue"):
        bench.command("ask", question="removal", parts=FREE, catalogue=True)
    # Named ones instead of those that were opened.
    _, answer = asked(bench, "access", catalogue=True, tools=["wrench"], parts=FREE)
    assert answer["reaches"][0]["tool"] == "wrench"


def test_another_catalogue_asks_again_and_moved_parts_make_it_stale() -> None:
    bench = Bench(None, mockup=bolts(), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access", catalogue=True, parts=FREE)
    before = answer["reaches"][0]["tool"]
    bench.command("task_catalogue", toml=WRENCH_17, name="own.toml")
    assert answered(bench, card.id).sentence == "The ours 17 reaches it."
    row = (bench.session.ask("card", {"id": card.id}) or {})["reaches"][0]
    assert row["tool"] == "ours 17" and row["has_hand"] is None and row["fan"], "this catalogue has no hand"
    assert bench.session.ask("reach_tool", {"id": card.id, "row": 0})
    bench.command("undo")
    assert before in answered(bench, card.id).sentence
    assert [each["is_stale"] for each in bench.document["cards"]] == [False]
    bench.command("grip", parts="wall")
    assert [each["is_stale"] for each in bench.document["cards"]] == [True]


def test_it_is_cancelled_and_tells_its_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(None, mockup=bolts(), pose=at(0, 0, 0.5))
    plain, told = access_answers.access, list[float]()

    def held(*args: Any, progress: Progress, **options: Any) -> Any:
        def heard(share: float, stage: str) -> None:
            told.append(share)
            while card_of(bench, number).state != "cancelled":
                progress(share, stage)

            progress(share, stage)

        return plain(*args, progress=heard, **options)

    monkeypatch.setattr(access_answers, "access", held)
    number = int(bench.command("ask", question="access", catalogue=True)["id"])
    while not told:
        pass
    bench.command("card_cancel", id=number)
    assert answered(bench, number).state == "cancelled"


def test_a_project_keeps_the_answer(tmp_path: Path) -> None:
    mockup = bolts()

    def opened() -> Session:
        session = Session(has_threads=False, project=open_or_make(tmp_path / "a.feelproj"))
        session.open(mockup, feeler.Scene(mockup), None)
        return session

    session = opened()
    number = session.command("ask", {"question": "access", "catalogue": True})["id"]
    while session.current.cards[-1].state in ("waiting", "running"):
        time.sleep(0.005)
    answer = session.ask("card", {"id": number}) or {}
    session.close()
    session = opened()
    assert json.dumps(session.ask("card", {"id": number})) == json.dumps(answer)
    assert session.ask("reach_tool", {"id": number, "row": 1})
    session.close()


def test_answers_of_older_projects_are_read() -> None:
    bench = Bench(feeler.sample_tool("wrench"), mockup=bolts(), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access")
    facts = json.loads(json.dumps({"kind": "card", **answer}))
    new = ("is_catalogue", "strokes", "has_hand", "head")
    for row in facts["reaches"]:
        for name in new:
            del row[name]
    kept = kept_answer(card, facts, None, bench.mockup.part_count)
    assert kept is not None and len(kept.reaches) == 2
    assert all([row.get(name) for name in new] == [False, None, None, ""] for row in kept.reaches)


def test_of_a_part_the_bolts_that_hold_it_are_meant() -> None:
    parts = {"bolt": bolt(0.03), "cover": ring(CLEAR, -0.01, 0.0), "case": ring(TAPPED, -0.04, -0.01)}
    bench = Bench(None, mockup=mockup_of(parts), pose=at(0, 0, 0.5))
    expected = {row.path for row in feeler.holds(bench.scene) if "cover" in row.paths}
    _, answer = asked(bench, "access", catalogue=True, parts="cover")
    assert {row["name"] for row in answer["reaches"]} == expected != set()
    bench = Bench(None, mockup=roofed(0.4), pose=at(0, 0, 0.5))
    card, _ = asked(bench, "access", catalogue=True, parts="roof")
    assert card.sentence.endswith("no fastener was found that holds them.")
