"""Questions about parts in the workbench: cards, their answers, what they are about, and what comes of them."""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from workbench_scene import FACES as BOX_FACES
from workbench_scene import LEFT, PATHS, PEG, PLATE, Bench, at, corners, cube

import feeler
from feeler.errors import FeelerError, WorkbenchError
from feeler.words import length_in
from feeler.workbench.document.cards import MOST_CARDS
from feeler.workbench.document.document import Card
from feeler.workbench.session import answering
from feeler.workbench.session.record import read_record

LONGEST_S = 120.0


def card_of(bench: Bench, number: int) -> Card:
    (found,) = (card for card in bench.session.current.cards if card.id == number)
    return found


def answered(bench: Bench, number: int) -> Card:
    """The card, once its question is answered."""
    end = time.monotonic() + LONGEST_S
    while card_of(bench, number).state in ("waiting", "running"):
        assert time.monotonic() < end, card_of(bench, number)
        time.sleep(0.005)
    return card_of(bench, number)


def asked(bench: Bench, question: str, **args: Any) -> tuple[Card, dict[str, Any]]:
    """A card and its whole answer."""
    number = bench.command("ask", question=question, **args)["id"]
    card = answered(bench, number)
    assert card.state == "done", card
    return card, bench.session.ask("card", {"id": number}) or {}


def boxes(*sides: tuple[tuple[float, ...], tuple[float, ...]], names: list[str]) -> feeler.Mockup:
    return feeler.Mockup(
        np.concatenate([corners(low, high) for low, high in sides]),
        np.concatenate([BOX_FACES + 8 * i for i in range(len(sides))]),
        np.repeat(np.arange(len(sides)), 12),
        names,
    )


def chest() -> feeler.Mockup:
    """A box of five walls without a front, in which lies a block, and a lid before it; beside them a post."""
    walls = [
        ((0.0, 0.0, 0.0), (0.1, 0.1, 0.01)),
        ((0.0, 0.0, 0.09), (0.1, 0.1, 0.1)),
        ((0.0, 0.0, 0.01), (0.01, 0.1, 0.09)),
        ((0.09, 0.0, 0.01), (0.1, 0.1, 0.09)),
        ((0.01, 0.09, 0.01), (0.09, 0.1, 0.09)),
    ]
    vertices = np.concatenate([corners(*wall) for wall in walls])
    faces = np.concatenate([BOX_FACES + 8 * i for i in range(5)])
    block = ((0.02, 0.02, 0.02), (0.08, 0.08, 0.08))
    lid, post = ((0.0, -0.02, 0.0), (0.1, -0.001, 0.1)), ((0.2, -0.3, 0.0), (0.3, 0.1, 0.1))
    for side in (block, lid, post):
        faces = np.concatenate([faces, BOX_FACES + len(vertices)])
        vertices = np.concatenate([vertices, corners(*side)])
    owners = np.concatenate([np.zeros(60), np.repeat([1, 2, 3], 12)]).astype(np.uint32)
    return feeler.Mockup(vertices, faces, owners, ["walls", "block", "lid", "post"])


WALLS, BLOCK, LID, POST = range(4)


def test_names_with_a_slash_are_whole_in_sentences() -> None:
    given = chest()
    names = ["hall 1/2", "block", "in/out", "post"]
    mockup = feeler.Mockup(
        given.vertices, given.faces, given.part_of_face, names, part_paths=["hall 1_2", "block", "in_out", "post"]
    )
    card, _ = asked(Bench(mockup=mockup), "removal", parts=LID)
    assert card.sentence.startswith("in/out comes out: ") and "nearest about 1 mm to hall 1/2" in card.sentence
    paths = feeler.Mockup(given.vertices, given.faces, given.part_of_face, [f"chest/{name}" for name in names])
    assert answering.shown(paths, [WALLS, BLOCK]) == ["2", "block"], "of a path, its last step"
    assert answering.shown(mockup, [WALLS, LID]) == ["hall 1/2", "in/out"]


def test_a_way_out_is_told_shown_and_true() -> None:
    bench = Bench(mockup=chest())
    card, answer = asked(bench, "removal", parts=LID)
    assert (card.is_good, card.title, card.setting) == (True, "Can lid come out?", "as loaded")
    assert card.sentence.startswith("lid comes out: ") and "nearest about 1 mm to walls" in card.sentence
    (way,) = answer["ways"]
    poses = np.array(way["poses"]).reshape(-1, 4, 4)
    assert np.array_equal(poses[0], np.eye(4)) and way["parts"] == [LID]
    rest = bench.scene.without([LID])
    lid = feeler.Tool.of_parts(bench.mockup, [LID])
    assert rest.check_path(lid, poses).is_free
    assert way["clearance"] == pytest.approx(1e-3, rel=0.05)
    shares = [each["share"] for each in way["gaps"]]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] == 1.0 and len(shares) > 20
    for gap in way["gaps"]:
        assert gap["gap"] is None or gap["gap"] >= way["clearance"] * 0.999
    assert way["gaps"][0]["gap"] == pytest.approx(1e-3) and way["gaps"][0]["part"] == WALLS
    assert way["gaps"][0]["point"][1] == pytest.approx(0.0)


@pytest.mark.parametrize(("unit", "long"), [("mm", "248 mm"), ("in", "9.7638 in"), ("m", "0.248 m")])
def test_lengths_in_words_are_those_of_the_page(unit: str, long: str) -> None:
    """In the unit of the document, with the same digits: in the sentence, in the legs and beside them."""
    bench = Bench(mockup=chest())
    bench.command("set_unit", unit=unit)
    for question in ("removal", "swept", "order"):
        card, answer = asked(bench, question, parts=LID)
        (way,) = answer["ways"]
        straight = length_in(way["length"], unit)
        assert way["legs"] == [f"move {straight} along {way['legs'][0].rpartition(' ')[2]}"]
        assert straight in card.sentence or question != "removal"
        figures = [card.sentence, *(each["figure"] for each in answer["facts"])]
        for said in re.findall(r"[0-9.]+ (mm|cm|m|in)\b", " ".join(figures)):
            assert said == unit
    assert length_in(0.248, unit) == long
    assert [length_in(each, "mm") for each in (0.0, 3.14e-6, 5e-6, -0.0)] == ["0 mm", "0.0031 mm", "0.01 mm", "0 mm"]


def test_what_holds_a_part_is_named_and_can_be_left_out() -> None:
    bench = Bench(mockup=chest())
    card, answer = asked(bench, "removal", parts="block", seconds=2.0)
    assert card.is_good is False and card.sentence.startswith("No way out was found for block in 2 s; stopped by ")
    assert {each["part"] for each in answer["blockers"]} == {WALLS, LID} and answer["ways"] == []
    card, answer = asked(bench, "removal", parts="block", without="lid")
    assert card.is_good and card.setting == "without lid"
    with pytest.raises(WorkbenchError, match="was asked without lid"):
        bench.command("way_take", id=card.id)
    assert bench.session.current.out == () and bench.session.current.sequence == ()
    # The lid was left out for that question alone.
    assert asked(bench, "removal", parts="block", seconds=2.0)[0].is_good is False


def test_what_has_to_go_first_and_its_steps() -> None:
    bench = Bench(mockup=chest())
    card, answer = asked(bench, "order", parts="block")
    (first,), last = (each["parts"] for each in answer["ways"])
    assert first in (LID, WALLS) and last == [BLOCK], "either frees it"
    assert card.sentence == f"block comes out after {bench.mockup.part_names[first]} goes: 2 steps."


def test_an_order_that_is_not_found_names_what_is_in_the_way() -> None:
    # A block in a case with a window that is too small for it.
    block = ((0.02, 0.02, 0.02), (0.08, 0.08, 0.08))
    walls = [
        ((0.0, 0.0, 0.0), (0.1, 0.1, 0.01)),
        ((0.0, 0.0, 0.09), (0.1, 0.1, 0.1)),
        ((0.0, 0.0, 0.01), (0.01, 0.1, 0.09)),
        ((0.09, 0.0, 0.01), (0.1, 0.1, 0.09)),
        ((0.01, 0.09, 0.01), (0.09, 0.1, 0.09)),
        ((0.01, 0.0, 0.01), (0.09, 0.01, 0.07)),
    ]
    mockup = feeler.Mockup(
        np.concatenate([corners(*side) for side in (block, *walls)]),
        np.concatenate([BOX_FACES + 8 * i for i in range(7)]),
        np.repeat([0, 1, 1, 1, 1, 1, 1], 12),
        ["block", "case"],
    )
    bench = Bench(mockup=mockup)
    card, answer = asked(bench, "order", parts="block", seconds=1.0)
    assert card.is_good is False and card.sentence == "No order was found in 1 s; stopped by case."
    assert [each["part"] for each in answer["blockers"]] == [1] and answer["ways"] == []


def test_the_room_of_a_way_holds_the_parts_on_it() -> None:
    bench = Bench(mockup=chest())
    card, answer = asked(bench, "swept", parts="lid")
    assert card.sentence.startswith("lid needs at most ")
    room = answer["room"]
    lower, upper = np.array(room["lower"]), np.array(room["upper"])
    for pose in np.array(answer["ways"][0]["poses"]).reshape(-1, 4, 4):
        moved = corners((0.0, -0.02, 0.0), (0.1, -0.001, 0.1)) @ pose[:3, :3].T + pose[:3, 3]
        assert (moved >= lower).all() and (moved <= upper).all()
    assert len(bench.session.card_room(card.id)) == sum(piece["bytes"] for piece in room["pieces"])
    with pytest.raises(WorkbenchError, match="has no swept volume"):
        bench.session.card_room(asked(bench, "removal", parts="lid")[0].id)


def bolts() -> feeler.Mockup:
    """A plate with two hexagon bolts on it, M10; beside the second one a wall that leaves no swing."""
    sides = [((-0.1, -0.1, -0.02), (0.2, 0.1, 0.0)), ((0.112, -0.1, 0.0001), (0.15, 0.1, 0.05))]
    vertices = [corners(*side) for side in sides]
    faces = [BOX_FACES, BOX_FACES + 8]
    owners = [np.zeros(12), np.ones(12)]
    for number, x in enumerate((-0.05, 0.1)):
        count = sum(map(len, vertices))
        mesh_vertices, mesh_faces = bolt()
        vertices.append(mesh_vertices + np.array([x, 0.0, 0.0]))
        faces.append(mesh_faces + count)
        owners.append(np.full(len(mesh_faces), 2 + number))
    names = ["plate", "wall", "bolt_free", "bolt_caught"]
    return feeler.Mockup(
        np.concatenate(vertices), np.concatenate(faces), np.concatenate(owners).astype(np.uint32), names
    )


def bolt() -> tuple[np.ndarray, np.ndarray]:
    """A hexagon head of 17 mm across flats and 6.4 mm high on a shank of 10 mm, which ends in the plate."""
    rings = [(5.0, -18.0, 24), (5.0, 0.0, 24), (17 / math.sqrt(3), 0.0, 6), (17 / math.sqrt(3), 6.4, 6)]
    vertices, starts = [], []
    for radius, z, count in rings:
        starts.append((len(vertices), count))
        turns = 2 * np.pi * np.arange(24) / 24
        for turn in turns:
            # A hexagon with the corners of 24: its sides are cut, so that rings join one to one.
            r = radius if count == 24 else radius * math.cos(np.pi / 6) / math.cos((turn % (np.pi / 3)) - np.pi / 6)
            vertices.append([r * math.cos(turn), r * math.sin(turn), z])
    faces = []
    for ring in range(3):
        for k in range(24):
            a, b = 24 * ring + k, 24 * ring + (k + 1) % 24
            faces += [[a, b, b + 24], [a, b + 24, a + 24]]
    vertices += [[0.0, 0.0, -18.0], [0.0, 0.0, 6.4]]
    for k in range(24):
        faces += [[96, (k + 1) % 24, k], [97, 72 + k, 72 + (k + 1) % 24]]
    return np.array(vertices) * 1e-3, np.array(faces)


def test_fasteners_that_a_tool_reaches(tmp_path: Path) -> None:
    bench = Bench(feeler.sample_tool("wrench"), mockup=bolts(), pose=at(0, 0, 0.5))
    card, answer = asked(bench, "access", swing_deg=30.0)
    rows = {row["name"]: row for row in answer["reaches"]}
    assert set(rows) == {"bolt_free", "bolt_caught"}, card
    assert rows["bolt_free"]["point"] == pytest.approx([-0.05, 0.0, 0.0064], abs=1e-4)
    assert rows["bolt_free"]["axis"] == pytest.approx([0.0, 0.0, 1.0])
    for row in rows.values():
        if row["fan"]:
            radii = np.linalg.norm((np.array(row["fan"]) - row["point"])[:, :2], axis=1)
            assert np.ptp(radii) < 1e-9, "the far end goes round the bolt"
    assert card.is_good is all(row["is_reachable"] for row in rows.values())
    # The tool is put into a seat at once.
    bench.command("seat", pose=rows["bolt_free"]["pose"])
    bench.tick()
    assert bench.pose.ravel().tolist() == pytest.approx(rows["bolt_free"]["pose"])
    bench.command("undo")
    assert bench.pose[2, 3] == 0.5


def test_which_of_several_tools_reach_fasteners() -> None:
    long = feeler.Tool(corners((-0.01, -0.01, 1e-4), (0.01, 0.01, 0.1)), BOX_FACES, "long")
    wide = feeler.Tool(corners((-0.1, -0.1, 1e-4), (0.1, 0.1, 0.02)), BOX_FACES, "wide")
    bench = Bench(long, mockup=bolts(), pose=at(0, 0, 0.5), tools=[wide])
    card, answer = asked(bench, "access", tools=["wide", "long", "wide"])
    assert card.title == "Which tool reaches which fasteners?" and card.options["tools"] == ["wide", "long"]
    rows = {row["name"]: row for row in answer["reaches"]}
    free, caught = rows["bolt_free"], rows["bolt_caught"]
    assert free["tool"] == "wide" and free["tools"] == ["wide", "long"], "of equal ones the first"
    assert caught["tool"] == "long" and caught["tools"] == [] and not caught["is_reachable"]
    # A square of 20 mm turns by so much before a corner meets the wall, 12 mm away.
    free_turn = 90.0 - 2.0 * math.degrees(math.acos(0.012 / math.hypot(0.01, 0.01)))
    assert caught["swing_deg"] == pytest.approx(free_turn, abs=0.01)
    assert card.is_good is False and card.sentence == "1 of 2 fasteners is reached, by the wide and long."
    figures = {fact["name"]: fact["figure"] for fact in answer["facts"]}
    assert figures == {"wide reaches": "1 of 2", "long reaches": "1 of 2"}
    alone, _ = asked(bench, "access", tool="long")
    assert alone.sentence == "The long reaches 1 of 2 fasteners."


def test_an_answer_is_about_the_mock_up_as_it_stands() -> None:
    bench = Bench(mockup=chest())
    lid, before = asked(bench, "removal", parts="lid")
    bench.command("way_take", id=lid.id)
    assert LID in bench.session.current.out
    # Its film begins where the lid lay then, not where it was laid.
    assert bench.session.ask("card", {"id": lid.id}) == before and before["ways"][0]["places"] == {}
    block, _ = asked(bench, "removal", parts="block")
    assert block.is_good and block.setting == "1 part out"
    stale = {card["id"]: card["is_stale"] for card in bench.document["cards"]}
    assert stale == {lid.id: True, block.id: False}
    with pytest.raises(WorkbenchError, match="are out already"):
        bench.command("way_take", id=lid.id)
    with pytest.raises(WorkbenchError, match="none of these parts is in the mock-up now"):
        bench.command("ask", question="removal", parts="lid")
    # Undo puts the part back, and leaves the cards.
    bench.command("undo")
    assert bench.session.current.out == () and len(bench.session.current.cards) == 2
    assert {card["id"]: card["is_stale"] for card in bench.document["cards"]} == {lid.id: False, block.id: True}
    # A part that was put down elsewhere counts there: the lid lies before another side, the post stands in the way out.
    bench.command("grip", parts="lid")
    bench.session.engine.jump(bench.pose @ at(0.5, 0.0, 0.0))
    bench.command("release")
    card, _ = asked(bench, "removal", parts="block")
    assert card.is_good and card.setting in ("1 part moved", "1 part out")
    bench.command("grip", parts="post")
    card, _ = asked(bench, "removal", parts="block")
    assert "1 part in hand left out" in card.setting


def test_parts_put_down_elsewhere_block_there() -> None:
    mockup = boxes(
        ((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)),
        ((0.5, 0.0, 0.0), (0.6, 0.1, 0.1)),
        ((-1, -1, -1), (2, 1, -0.9)),
        names=["a", "b", "c"],
    )
    bench = Bench(mockup=mockup)
    bench.command("grip", parts="b")
    bench.session.engine.jump(bench.pose @ at(-0.399, 0.0, 0.0))  # 1 mm beside a
    bench.command("release")
    card, answer = asked(bench, "removal", parts="a")
    gaps = answer["ways"][0]["gaps"]
    assert card.setting == "1 part moved" and gaps[0]["part"] == 1 and gaps[0]["gap"] == pytest.approx(1e-3)
    # The one that lies elsewhere starts from there.
    _, answer = asked(bench, "removal", parts="b")
    number = answer["id"]
    bench.command("way_take", id=number)
    line = bench.document["sequence"][-1]
    assert line["parts"] == [1]
    moved = np.array(bench.document["moved"]["1"]).reshape(4, 4)
    last = np.array(answer["ways"][0]["poses"][-1]).reshape(4, 4)
    assert moved == pytest.approx(last @ at(-0.399, 0.0, 0.0))
    bench.command("sequence_replay", id=line["id"])
    for _ in range(3000):
        bench.tick()
        if bench.session.current.replaying is None:
            break
    assert np.array(bench.document["moved"]["1"]).reshape(4, 4) == pytest.approx(moved, abs=1e-6)


def test_questions_wait_are_cancelled_and_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(mockup=chest())
    begun, go_on = threading.Event(), threading.Event()

    def slow(asked: answering.Asked, progress: Callable[[float, str], None]) -> answering.Answered:
        begun.set()
        while not go_on.wait(0.005):
            progress(0.5, "thinking")
        return answering.Answered("thought", None)

    monkeypatch.setitem(answering.ANSWERS, "removal", slow)
    first = bench.command("ask", question="removal", parts="lid")["id"]
    second = bench.command("ask", question="removal", parts="block")["id"]
    assert begun.wait(LONGEST_S)
    end = time.monotonic() + LONGEST_S
    while card_of(bench, first).stage != "thinking" and time.monotonic() < end:
        time.sleep(0.005)
    assert (card_of(bench, first).share, card_of(bench, second).state) == (0.5, "waiting")
    with pytest.raises(WorkbenchError, match="not answered yet"):
        bench.command("card_again", id=first)
    with pytest.raises(WorkbenchError, match="has no answer"):
        bench.session.ask("card", {"id": first})
    bench.command("card_cancel", id=second)
    bench.command("card_cancel", id=first)
    assert card_of(bench, first).state == card_of(bench, second).state == "cancelled"
    with pytest.raises(WorkbenchError, match="is cancelled already"):
        bench.command("card_cancel", id=second)
    begun.clear()
    bench.command("card_again", id=first)
    assert begun.wait(LONGEST_S)
    go_on.set()
    assert answered(bench, first).sentence == "thought"
    assert card_of(bench, second).state == "cancelled"
    bench.command("card_remove", id=first)
    assert [card.id for card in bench.session.current.cards] == [second]
    with pytest.raises(WorkbenchError, match="has no answer"):
        bench.session.ask("card", {"id": first})
    with pytest.raises(WorkbenchError, match="there is nothing to undo"):
        bench.command("undo")


def test_a_way_of_before_is_not_taken() -> None:
    bench = Bench(mockup=chest())
    lid, _ = asked(bench, "removal", parts="lid")
    bench.command("grip", parts="post")
    with pytest.raises(WorkbenchError, match="parts were moved since this was asked"):
        bench.command("way_take", id=lid.id)
    bench.session.engine.jump(bench.pose @ at(0.0, 0.0, -1.0))
    bench.command("release")
    with pytest.raises(WorkbenchError, match="parts were moved since this was asked"):
        bench.command("way_take", id=lid.id)
    bench.command("put_back", parts="post")
    bench.command("way_take", id=lid.id)
    assert bench.session.current.out == (LID,)


def test_removals_are_replayed_through_what_is_out() -> None:
    # Two blocks, one behind the other in a tube that is closed at one end: both end before its mouth.
    sides = [
        ((0.0, -0.1, -0.1), (0.4, 0.1, -0.052)),
        ((0.0, -0.1, 0.052), (0.4, 0.1, 0.1)),
        ((0.0, -0.1, -0.0515), (0.4, -0.052, 0.0515)),
        ((0.0, 0.052, -0.0515), (0.4, 0.1, 0.0515)),
        ((0.35, -0.0515, -0.0515), (0.4, 0.0515, 0.0515)),
        ((0.11, -0.05, -0.05), (0.2, 0.05, 0.05)),
        ((0.01, -0.05, -0.05), (0.1, 0.05, 0.05)),
    ]
    mockup = feeler.Mockup(
        np.concatenate([corners(low, high) for low, high in sides]),
        np.concatenate([BOX_FACES + 8 * i for i in range(len(sides))]),
        np.repeat([0, 0, 0, 0, 0, 1, 2], 12),
        ["tube", "inner", "outer"],
    )
    bench = Bench(mockup=mockup)
    for part in ("outer", "inner"):
        bench.command("way_take", id=asked(bench, "removal", parts=part)[0].id)
    ends = {part: np.array(pose).reshape(4, 4) for part, pose in bench.document["moved"].items()}
    gap = abs(ends["1"][0, 3] + 0.1 - ends["2"][0, 3])
    assert gap < 0.09, "they lie in each other"
    for line in list(bench.document["sequence"]):
        bench.command("sequence_replay", id=line["id"])
        for _ in range(5000):
            bench.tick()
            if bench.session.current.replaying is None:
                break
        part = str(line["parts"][0])
        assert np.array(bench.document["moved"][part]).reshape(4, 4) == pytest.approx(ends[part], abs=1e-6), line[
            "name"
        ]


def test_a_wish_that_is_not_kept_is_said() -> None:
    bench = Bench(mockup=chest())
    card, _ = asked(bench, "removal", parts="lid", clearance=0.05)
    assert card.is_good is False and card.sentence.endswith("less than the 50 mm that you asked for.")


@pytest.mark.parametrize("error", [feeler.OptionError("no such thing"), MemoryError(), ValueError("a slip")])
def test_a_question_that_fails_says_so(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def failing(*_: object) -> answering.Answered:
        raise error

    monkeypatch.setitem(answering.ANSWERS, "removal", failing)
    bench = Bench(mockup=chest())
    card = answered(bench, bench.command("ask", question="removal", parts="lid")["id"])
    assert card.state == "failed" and card.sentence and card.is_good is None
    monkeypatch.undo()
    assert asked(bench, "removal", parts="lid")[0].is_good, "the thread lives on"


def test_a_new_mock_up_and_the_end_give_up_what_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(mockup=chest())
    begun = threading.Event()

    def endless(asked: answering.Asked, progress: Callable[[float, str], None]) -> answering.Answered:
        begun.set()
        while True:
            progress(0.5, "thinking")
            time.sleep(0.001)

    monkeypatch.setitem(answering.ANSWERS, "removal", endless)
    bench.command("ask", question="removal", parts="lid")
    assert begun.wait(LONGEST_S)
    other = boxes(((0, 0, 0), (1, 1, 1)), ((2, 0, 0), (3, 1, 1)), names=["a", "b"])
    bench.session.open(other, feeler.Scene(other), None)
    assert bench.session.current.cards == ()
    begun.clear()
    bench.command("ask", question="removal", parts="a")
    assert begun.wait(LONGEST_S), "the thread was free again"
    start = time.monotonic()
    bench.session.close()
    assert time.monotonic() - start < 10.0


def test_the_order_and_its_steps_into_the_sequence_and_a_record_of_it(tmp_path: Path) -> None:
    bench = Bench(mockup=chest(), record=tmp_path / "a.jsonl")
    card, answer = asked(bench, "order", parts="block")
    number, (first,) = card.id, answer["ways"][0]["parts"]
    bench.command("way_take", id=number, steps=1)
    assert bench.session.current.out == (first,)
    bench.command("way_take", id=number)
    assert len(bench.document["sequence"]) == 2, "the rest"
    bench.command("undo")
    bench.command("undo")
    assert bench.session.current.out == ()
    bench.command("way_take", id=number)
    assert set(bench.session.current.out) == {first, BLOCK}
    assert [line["name"] for line in bench.document["sequence"]] == [bench.mockup.part_names[first], "block"]
    bench.session.close()
    entries = [each for each in read_record(tmp_path / "a.jsonl").entries if each["kind"] == "command"]
    # The record has the ways themselves, and no question.
    assert [each["name"] for each in entries] == ["way_take", "way_take", "undo", "undo", "way_take"]
    again = Bench(mockup=chest())
    for entry in entries:
        if "error" not in entry:
            again.command(entry["name"], **entry["args"])
    assert again.document["moved"] == bench.document["moved"]
    assert again.document["sequence"] == bench.document["sequence"]


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ({"question": "removal"}, "no part is named"),
        ({"question": "nonsense", "parts": 0}, "there is no 'nonsense'"),
        ({"question": "removal", "parts": [0, 1, 2, 3, 4]}, "these are all parts"),
        ({"question": "removal", "parts": "nonsense"}, "nonsense"),
        ({"question": "removal", "parts": 1, "seconds": 0}, "seconds"),
        ({"question": "removal", "parts": 1, "seconds": float("nan")}, "seconds"),
        ({"question": "removal", "parts": 1, "clearance": -1}, "clearance"),
        ({"question": "removal", "parts": 1, "tool": "wrench"}, "this question has no tool"),
        ({"question": "access", "tool": "wrench", "clearance": 0.1}, "this question has no clearance"),
        ({"question": "access"}, "the hand holds no tool"),
        ({"question": "access", "tools": []}, "not a list of tools"),
        ({"question": "access", "tools": ["wrench", "nonsense"]}, "there is no 'nonsense'"),
        ({"question": "access", "tools": ["wrench"], "tool": "hand"}, "a tool beside them"),
        ({"question": "removal", "parts": 1, "tools": ["wrench"]}, "this question has no tools"),
        ({"question": "access", "tool": "nonsense"}, "there is no 'nonsense'"),
        ({"question": "access", "tool": "wrench", "grip": "w"}, "there is no 'w'"),
        ({"question": "access", "tool": "wrench", "swing_deg": 0}, "swing_deg"),
        ({"question": "removal", "parts": PEG, "without": PEG}, "none of these parts"),
    ],
)
def test_questions_that_cannot_be(args: dict[str, Any], words: str) -> None:
    bench = Bench()
    with pytest.raises(WorkbenchError, match=words):
        bench.command("ask", **args)
    assert bench.session.current.cards == ()


@pytest.mark.parametrize(
    "ways",
    [
        [],
        "x",
        [{"parts": [LEFT], "poses": [], "clearance": None}],
        [{"parts": [LEFT], "poses": [[0.0] * 16], "clearance": None}],
        [{"parts": [99], "poses": [np.eye(4).ravel().tolist()], "clearance": None}],
        [{"parts": [LEFT], "poses": [np.eye(4).ravel().tolist()], "clearance": -1.0}],
        [{"poses": [np.eye(4).ravel().tolist()], "clearance": None}],
        [{"parts": [LEFT], "poses": [np.eye(4).ravel().tolist()], "more": 1}],
        [7],
    ],
)
def test_ways_that_cannot_be_taken(ways: Any) -> None:
    bench = Bench()
    before = bench.session.current
    with pytest.raises(WorkbenchError):
        bench.command("way_take", ways=ways)
    with pytest.raises(WorkbenchError):
        bench.command("way_take", id=3)
    assert bench.session.current is before


def test_there_are_no_more_cards_than_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(answering.ANSWERS, "removal", lambda *_: answering.Answered("no", False))
    bench = Bench()
    for _ in range(MOST_CARDS):
        bench.command("ask", question="removal", parts=PLATE)
    with pytest.raises(WorkbenchError, match="remove some first"):
        bench.command("ask", question="removal", parts=PLATE)
    bench.session.close()


def test_the_seat_wants_a_tool_alone() -> None:
    bench = Bench(cube(), pose=at(0, 0, 0.2))
    with pytest.raises(FeelerError, match="not a pose"):
        bench.command("seat", pose=[1.0] * 16)
    bench.command("seat", pose=at(0.1, 0.2, 0.3).ravel().tolist())
    assert bench.pose == pytest.approx(at(0.1, 0.2, 0.3))
    bench.command("grip", parts=PATHS[PEG])
    with pytest.raises(WorkbenchError, match="holds no tool alone"):
        bench.command("seat", pose=at(0.1, 0.2, 0.3).ravel().tolist())


@pytest.mark.parametrize("is_fine", [False, True])
def test_the_built_in_wrench_lies_flat_also_when_the_program_was_started_with_it(is_fine: bool) -> None:
    wrench = feeler.sample_tool("wrench", fine=is_fine)
    started, taken = Bench(wrench, mockup=bolts(), pose=at(0, 0, 0.5)), Bench(mockup=bolts())
    (_, first), (_, second) = asked(started, "access", tool="wrench"), asked(taken, "access", tool="wrench")
    poses = [np.array([row["pose"] for row in answer["reaches"]]) for answer in (first, second)]
    # The jaw turns about y, which points out of the joint.
    for pose in np.concatenate(poses).reshape(-1, 4, 4):
        assert pose[:3, 1] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    own = feeler.Tool(wrench.vertices * 1.01, wrench.faces, "wrench")
    _, other = asked(Bench(own, mockup=bolts(), pose=at(0, 0, 0.5)), "access", tool="wrench")
    for pose in np.array([row["pose"] for row in other["reaches"]]).reshape(-1, 4, 4):
        assert pose[:3, 2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9), "a tool of one's own along z"


def test_a_whole_group_is_called_by_its_name() -> None:
    from shapes import box, mockup_of

    shapes = [box((x, 0.0, 0.0), (x + 0.5, 1.0, 1.0)) for x in (0.0, 1.0, 2.0, 3.0)]
    made = mockup_of(dict(zip(("a", "b", "c", "d"), shapes, strict=True)))
    paths = ["top/pump/body", "top/pump/lid", "top/pump/old", "top/frame"]
    world = feeler.Mockup(made.vertices, made.faces, made.part_of_face, list("abcd"), part_paths=paths)
    bench = Bench(mockup=world)
    for parts, title in (([0, 1, 2], "Can pump come out?"), ([0, 1], "Can a and 1 more come out?")):
        number = int(bench.command("ask", question="removal", parts=parts)["id"])
        assert card_of(bench, number).title == title
        bench.command("card_cancel", id=number)
    number = int(bench.command("ask", question="task", parts=[0, 1, 2], tools=[])["id"])
    assert card_of(bench, number).title == "How is pump taken out?"
    bench.session.close()


def test_a_part_outside_of_all_others_has_a_way_to_take() -> None:
    sides = [
        ((0.0, 0.0, 0.0), (0.1, 0.1, 0.01)),
        ((0.0, 0.0, 0.01), (0.01, 0.1, 0.1)),
        ((0.02, 0.02, 0.02), (0.08, 0.08, 0.08)),
        ((0.0, 0.0, 0.101), (0.1, 0.1, 0.12)),
    ]
    bench = Bench(None, mockup=boxes(*sides, names=["floor", "wall", "block", "lid"]))
    card, answer = asked(bench, "removal", parts=["lid"])
    assert card.sentence == "lid lies outside of all other parts already, and moves away along +z."
    (way,) = answer["ways"]
    assert way["length"] == pytest.approx(0.05) and way["poses"][-1][11] == pytest.approx(0.05)
    bench.command("way_take", id=card.id)
    assert bench.document["out"] == [3] and [line["name"] for line in bench.document["sequence"]] == ["lid"]
    assert bench.document["moved"]["3"][11] == pytest.approx(0.05)
