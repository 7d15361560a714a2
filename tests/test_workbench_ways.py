"""Ways of removals in the sequence: checked, shortened, kept; and a way that guides the hand."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_workbench_cards import BLOCK, LID, POST, WALLS, answered, card_of, chest
from workbench_scene import FACES, Bench, at, corners, cube

import feeler
from feeler.errors import WorkbenchError
from feeler.workbench.document.document import Card
from feeler.workbench.report.content import report_of
from feeler.workbench.report.source import of_document
from feeler.workbench.session.record import read_record
from feeler.workbench.session.replaying import replay


def taken_out(bench: Bench, part: int, *ways: tuple[float, float, float], speed: float = 0.5) -> int:
    """Grips a part, moves it along, and puts it down; the number of the line."""
    bench.command("grip", parts=part)
    for way in ways:
        bench.drag(at(*way) @ bench.pose, speed)
    bench.command("release")
    return int(bench.document["sequence"][-1]["id"])


def told(bench: Bench, command: str, line: int) -> tuple[Card, dict[str, Any]]:
    card = answered(bench, bench.command(command, id=line)["id"])
    assert card.state == "done", card
    return card, bench.session.ask("card", {"id": card.id}) or {}


def stale(bench: Bench) -> list[bool]:
    return [card["is_stale"] for card in bench.document["cards"]]


def test_what_the_hand_did_holds_and_with_which_clearance() -> None:
    bench = Bench(mockup=chest())
    line = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.0, 0.0, 0.3))
    card, answer = told(bench, "way_check", line)
    assert card.is_good and (card.title, card.line) == ("Does the way of lid hold?", line)
    assert (
        card.sentence.startswith("The way holds at and between its ") and "nearest about 1 mm to walls" in card.sentence
    )
    (way,) = answer["ways"]
    assert way["parts"] == [LID] and way["clearance"] == pytest.approx(1e-3, rel=0.05) and "hit" not in way
    moves = np.array(way["poses"]).reshape(-1, 4, 4)
    assert np.array_equal(moves[0], np.eye(4)) and moves[-1][:3, 3] == pytest.approx([0.0, -0.05, 0.3], abs=1e-9)
    assert bench.scene.without([LID]).check_path(feeler.Tool.of_parts(bench.mockup, [LID]), moves).is_free
    with pytest.raises(WorkbenchError, match="this card has no way"):
        bench.command("way_take", id=card.id)
    with pytest.raises(WorkbenchError, match="has no shorter way"):
        bench.command("way_keep", id=card.id)


def test_a_line_has_the_clearance_of_its_newest_check() -> None:
    bench = Bench(mockup=chest())
    line = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.0, 0.0, 0.3))
    by_hand = bench.document["sequence"][0]["least_clearance"]

    def told_of_it() -> list[float | None]:
        bench.session.job("export_csv", {}).result(60)
        rows = csv.DictReader(io.StringIO(bench.session.export("sequence.csv").decode("utf-8-sig")))
        least = next(row["least clearance (mm)"] for row in rows if row["name"] == "lid")
        film = next(way for way in bench.session.job("film", {}).result(60)["ways"] if way["id"] == line)
        report = report_of(of_document(bench.session.current, bench.mockup, {})).steps
        step = next(each for each in report if each.key == f"step-{line}")
        return [float(least) / 1e3 if least else None, film["clearance"], step.clearance]

    assert told_of_it() == pytest.approx([by_hand] * 3, rel=1e-3)
    card, answer = told(bench, "way_check", line)
    assert card.clearances == (answer["ways"][0]["clearance"],)
    assert bench.document["cards"][0]["clearances"] == [pytest.approx(1e-3, rel=0.05)]
    # With the walls out before it, the lid is near nothing: the check is of before, then the new one counts.
    bench.command("set_mode", mode="pass")
    taken_out(bench, WALLS, (0.0, 0.0, 2.0))
    bench.command("sequence_move", id=line, index=1)
    assert told_of_it() == pytest.approx([by_hand] * 3, rel=1e-3)
    card, _ = told(bench, "way_check", line)
    assert card.is_good and card.clearances[0] != pytest.approx(1e-3, rel=0.05)
    assert told_of_it() == pytest.approx([card.clearances[0]] * 3, rel=1e-3, nan_ok=True)


def test_a_way_through_something_is_refused_where_it_is() -> None:
    bench = Bench(mockup=chest())
    bench.command("set_mode", mode="pass")
    line = taken_out(bench, BLOCK, (0.0, -0.2, 0.0))
    card, answer = told(bench, "way_check", line)
    assert card.is_good is False and card.sentence.startswith("The way meets lid between pose ")
    (way,), (blocker,) = answer["ways"], answer["blockers"]
    assert way["hit"]["part"] == blocker["part"] == LID and way["hit"]["point"][1] == pytest.approx(-1e-3, abs=1e-6)
    # The block is 21 mm away from the lid, on a way of 200 mm.
    assert way["hit"]["share"] == pytest.approx(0.105, abs=1e-3)
    assert np.array(blocker["pose"]).reshape(4, 4)[1, 3] == pytest.approx(-0.021, abs=1e-5)
    # Without the lid it holds; the way is asked of the mock-up as the line has it.
    taken_out(bench, LID, (0.0, 0.0, 0.3))
    assert told(bench, "way_check", line)[0].is_good is False and exported(bench) == ["does not hold", "not checked"]
    bench.command("sequence_move", id=line, index=1)
    assert stale(bench) == [True] and exported(bench) == ["not checked", "not checked"], "it is of before"
    assert told(bench, "way_check", line)[0].is_good and exported(bench) == ["not checked", "holds"]


def exported(bench: Bench) -> list[str]:
    """What the exported sequence says of checks, by line."""
    bench.session.job("export_csv", {}).result(60.0)
    text = bench.session.export("sequence.csv").decode("utf-8-sig")
    return [line["checked"] for line in csv.DictReader(io.StringIO(text))]


def test_between_the_poses_it_is_checked_as_well() -> None:
    # A sheet of no thickness between two poses of a way that jumps.
    bench = Bench()
    bench.command("way_take", ways=[{"parts": [3], "poses": [row(at(0, 0, 0)), row(at(0, 0, 1.0))], "clearance": None}])
    line = bench.document["sequence"][-1]["id"]
    card, answer = told(bench, "way_check", line)
    assert card.is_good is False and "sheet" in card.sentence and answer["ways"][0]["hit"]["part"] == 4


def row(pose: np.ndarray) -> list[float]:
    return [float(each) for each in pose.ravel()]


def test_a_check_is_of_before_when_what_it_is_about_changes() -> None:
    bench = Bench(mockup=chest())
    lid = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.0, 0.0, 0.3))
    block = taken_out(bench, BLOCK, (0.0, -0.2, 0.0))
    told(bench, "way_check", lid)
    told(bench, "way_check", block)
    assert stale(bench) == [False, False]
    # A later removal changes nothing for those before it; while it is in the hand neither.
    bench.command("grip", parts=POST)
    assert stale(bench) == [False, False]
    bench.drag(at(0.5, 0.0, 0.0) @ bench.pose, 0.5)
    bench.command("release")
    assert stale(bench) == [False, False]
    # What is moved without a line is elsewhere for all.
    number = bench.document["sequence"][-1]["id"]
    bench.command("sequence_remove", id=number)
    assert stale(bench) == [True, True]
    bench.command("undo")
    assert stale(bench) == [False, False]
    bench.command("sequence_move", id=block, index=0)
    assert stale(bench) == [True, True]
    bench.command("undo")
    bench.command("sequence_remove", id=lid)
    assert stale(bench) == [True, False], "the lid is still out"
    with pytest.raises(WorkbenchError, match="not in the sequence any more"):
        bench.command("card_again", id=bench.document["cards"][0]["id"])
    bench.command("undo")
    # Asked again, the newer answer takes the place of the older one.
    told(bench, "way_check", lid)
    assert [card["line"] for card in bench.document["cards"]] == [block, lid]


def test_a_way_is_shortened_checked_and_kept(tmp_path: Path) -> None:
    bench = Bench(mockup=chest(), record=tmp_path / "a.jsonl")
    line = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.1, 0.0, 0.0), (-0.1, 0.0, 0.0), (0.0, -0.1, 0.3))
    before = bench.document["sequence"][0]
    ends = bench.document["moved"]
    card, answer = told(bench, "way_shorten", line)
    assert card.is_good and card.sentence.startswith("The way can be shorter by ")
    (way,) = answer["ways"]
    assert len(way["poses"]) <= 4 and way["length"] < 0.9 * 0.45
    moves = np.array(way["poses"]).reshape(-1, 4, 4)
    assert bench.scene.without([LID]).check_path(feeler.Tool.of_parts(bench.mockup, [LID]), moves).is_free
    bench.command("way_keep", id=card.id)
    kept = bench.document["sequence"][0]
    assert len(kept["way"]) == len(way["poses"]) < len(before["way"])
    assert kept["least_clearance"] == way["clearance"] and kept["way"][-1] == before["way"][-1]
    assert bench.document["moved"] == ends, "to the last digit"
    now = card_of(bench, card.id)
    assert (now.question, now.title, stale(bench)) == ("way", "Does the way of lid hold?", [False])
    assert now.sentence.startswith("The way was made shorter by ")
    bench.command("undo")
    assert bench.document["sequence"][0]["way"] == before["way"] and stale(bench) == [True]
    bench.command("redo")
    assert bench.document["sequence"][0]["way"] == kept["way"] and stale(bench) == [False]
    assert told(bench, "way_check", line)[0].is_good
    bench.session.close()
    # The record has the way itself.
    entries = [each for each in read_record(tmp_path / "a.jsonl").entries if each["kind"] == "command"]
    (again,) = [each for each in entries if each["name"] == "way_keep"]
    assert again["args"]["line"] == line and "id" not in again["args"]
    other = Bench(mockup=chest())
    assert taken_out(other, LID, (0.0, -0.05, 0.0), (0.1, 0.0, 0.0), (-0.1, 0.0, 0.0), (0.0, -0.1, 0.3)) == line
    other.command("way_keep", **again["args"])
    assert other.document["sequence"][0]["way"] == kept["way"]


def test_a_shorter_way_can_be_kept_beside_the_longer_one() -> None:
    bench = Bench(mockup=chest())
    line = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.0, 0.0, 0.2), (0.0, -0.1, -0.1))
    card, _ = told(bench, "way_shorten", line)
    bench.command("way_keep", id=card.id, is_added=True)
    first, second = bench.document["sequence"]
    assert (first["id"], second["name"]) == (line, "lid, shorter") and len(second["way"]) < len(first["way"])
    assert bench.document["cards"][0]["line"] == second["id"] and stale(bench) == [False]
    bench.command("undo")
    assert len(bench.document["sequence"]) == 1


def test_a_shorter_way_goes_around_what_is_in_between() -> None:
    # A wall between begin and end: the straight motion is not free, the way over it is.
    sides = [((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), ((0.2, -1.0, -1.0), (0.21, 1.0, 0.2))]
    mockup = feeler.Mockup(
        np.concatenate([corners(*side) for side in sides]),
        np.concatenate([FACES, FACES + 8]),
        np.repeat([0, 1], 12),
        ["block", "wall"],
    )
    bench = Bench(mockup=mockup)
    line = taken_out(bench, 0, (0.0, 0.0, 0.9), (0.4, 0.0, 0.0), (0.0, 0.0, -0.9))
    card, answer = told(bench, "way_shorten", line)
    moves = np.array(answer["ways"][0]["poses"]).reshape(-1, 4, 4)
    assert card.is_good and 3 <= len(moves) <= 8 and answer["ways"][0]["length"] < 1.4
    assert bench.scene.without([0]).check_path(feeler.Tool.of_parts(mockup, [0]), moves).is_free


def test_the_last_part_has_nothing_around_it() -> None:
    mockup = feeler.Mockup(
        np.concatenate([corners((0, 0, 0), (0.1, 0.1, 0.1)), corners((0.2, 0, 0), (0.3, 0.1, 0.1))]),
        np.concatenate([FACES, FACES + 8]),
        np.repeat([0, 1], 12),
        ["a", "b"],
    )
    bench = Bench(mockup=mockup)
    first = taken_out(bench, 0, (-1.0, 0.0, 0.0))
    last = taken_out(bench, 1, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    assert told(bench, "way_check", first)[0].is_good
    card, answer = told(bench, "way_check", last)
    assert card.is_good and answer["ways"][0]["clearance"] is None
    card, answer = told(bench, "way_shorten", last)
    assert len(answer["ways"][0]["poses"]) == 2


def test_a_tool_in_hand_goes_the_way_as_well() -> None:
    # The tool passes through the post, the lid beside it does not.
    bench = Bench(cube(), mockup=chest(), pose=at(0.25, -0.1, -0.1))
    bench.command("set_mode", mode="pass")
    line = taken_out(bench, LID, (0.0, 0.0, 0.3))
    assert bench.document["sequence"][0]["tool"] == "cube"
    card, answer = told(bench, "way_check", line)
    assert card.is_good is False and answer["ways"][0]["hit"]["part"] == POST
    assert answer["facts"] == [{"name": "with", "figure": "the cube in hand"}]
    assert told(bench, "way_shorten", line)[0].is_good is False


def test_a_check_is_cancelled_between_two_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(mockup=chest())
    line = taken_out(bench, LID, (0.0, -0.05, 0.0), (0.0, 0.0, 0.3))
    number = bench.command("way_check", id=line)["id"]
    bench.command("card_cancel", id=number)
    assert card_of(bench, number).state == "cancelled"
    with pytest.raises(WorkbenchError, match="there is no 99"):
        bench.command("way_check", id=99)
    with pytest.raises(WorkbenchError, match="there is no 'way'"):
        bench.command("ask", question="way", parts=WALLS)
    bench.session.close()


def test_what_was_taken_out_before_is_not_in_the_way_of_later_lines() -> None:
    # It lies where the next one goes, inside the box of the scene: it was taken out all the same.
    bench = Bench(mockup=chest())
    ways = [
        {"parts": [LID], "poses": [row(at(0, 0, 0)), row(at(0, -0.15, 0))], "clearance": None},
        {"parts": [BLOCK], "poses": [row(at(0, 0, 0)), row(at(0, -0.4, 0))], "clearance": None},
    ]
    bench.command("way_take", ways=ways)
    for line in bench.document["sequence"]:
        assert told(bench, "way_check", line["id"])[0].is_good
    # Brought back a little, it is in the way; the block's line comes before that.
    bench.command("grip", parts=LID)
    bench.drag(at(0.0, 0.01, 0.0) @ bench.pose, 0.5)
    bench.command("release")
    assert stale(bench) == [False, False]
    lid = bench.document["sequence"][-1]["id"]
    bench.command("sequence_move", id=lid, index=1)
    block = bench.document["sequence"][-1]["id"]
    assert told(bench, "way_check", block)[0].is_good is False


# ---- a way that guides the hand ----


def guided(bench: Bench, part: int = LID) -> None:
    """The lid in the hand, guided along a way of 50 mm to the front, then 300 mm up."""
    way = [row(at(0, 0, 0)), row(at(0, -0.05, 0)), row(at(0, -0.05, 0.3))]
    bench.command("way_take", ways=[{"parts": [part], "poses": way, "clearance": None}])
    line = bench.document["sequence"][-1]["id"]
    bench.command("put_back", parts=part)
    bench.command("grip", parts=part)
    bench.command("guide", line=line)


def test_the_hand_is_drawn_to_the_way_and_can_leave_it() -> None:
    bench = Bench(mockup=chest())
    guided(bench)
    start = bench.pose.copy()
    assert bench.document["guiding"]["parts"] == [LID] and len(bench.document["guiding"]["way"]) == 3
    guide = bench.session.engine.guide
    assert guide is not None and 0.002 < guide.snap < guide.reach < 0.1
    # A little off the way: onto it. The wish of a hand is drawn straight to the nearest place.
    bench.wish(at(0.005, -0.02, 0.0) @ start)
    assert bench.pose[:3, 3] - start[:3, 3] == pytest.approx([0.0, -0.02, 0.0], abs=1e-9)
    assert bench.session.snapshot() is not None and bench.session.snapshot().wish[0, 3] == pytest.approx(start[0, 3])
    # Between the two distances: partly; from afar: not at all, and it never goes farther than the wish.
    offs = np.linspace(0.0, 1.5 * guide.reach, 60)
    drawn = [guide.drawn(at(off, -0.02, 0.0) @ start)[0, 3] - start[0, 3] for off in offs]
    assert np.all(np.diff(drawn) >= -1e-12) and np.all(np.array(drawn) <= offs + 1e-12), "the hand can pull off"
    assert drawn[-1] == pytest.approx(offs[-1]) and max(offs - drawn) < guide.reach / 2
    # What is placed by figures goes there.
    bench.command("place", pose=row(at(0.005, -0.02, 0.0) @ start))
    assert bench.pose[0, 3] - start[0, 3] == pytest.approx(0.005)


def test_contact_stays_what_it_is() -> None:
    # The way leads through the walls: the hand is drawn to it, and stops.
    bench = Bench(mockup=chest())
    way = [row(at(0, 0, 0)), row(at(0, 0.3, 0))]
    bench.command("way_take", ways=[{"parts": [LID], "poses": way, "clearance": None}])
    bench.command("put_back", parts=LID)
    bench.command("grip", parts=LID)
    bench.command("guide", line=bench.document["sequence"][-1]["id"])
    start = bench.pose.copy()
    bench.wish(at(0.0, 0.2, 0.0) @ start)
    assert bench.pose[1, 3] - start[1, 3] == pytest.approx(1e-3, abs=1e-5)
    assert bench.document["guiding"] is not None, "it is not at the end"


def test_the_guide_ends_at_the_end_and_when_the_hand_lets_go() -> None:
    bench = Bench(mockup=chest())
    guided(bench)
    start = bench.pose.copy()
    bench.drag(at(0.0, -0.05, 0.0) @ start, 0.5)
    assert bench.document["guiding"] is not None
    bench.drag(at(0.0, -0.05, 0.31) @ start, 0.5)
    assert bench.document["guiding"] is None and bench.session.engine.guide is None
    # At the end of the line it guides back.
    line = bench.document["sequence"][0]["id"]
    bench.command("guide", line=line)
    way = np.array(bench.document["guiding"]["way"]).reshape(-1, 4, 4)
    assert way[0, 2, 3] - way[-1, 2, 3] == pytest.approx(0.3)
    for end in ("guide_end", "release", "undo"):
        bench.command("guide", line=line)
        assert bench.document["guiding"] is not None
        bench.command(end)
        assert bench.document["guiding"] is None and bench.session.engine.guide is None, end
        if end == "release":
            bench.command("undo")  # and the parts are in the hand again, without a guide
            assert bench.document["gripped"] == [LID] and bench.document["guiding"] is None
    assert bench.document["gripped"] == [], "the grip is undone"


def test_nothing_draws_in_doubt() -> None:
    bench = Bench(mockup=chest())
    guided(bench)
    guide, start = bench.session.engine.guide, bench.pose
    assert guide is not None
    place, along = guide.held(at(0.005, -0.02, 0.0) @ start) or (None, None)
    assert place is not None and place[:3, 3] - start[:3, 3] == pytest.approx([0.0, -0.02, 0.0], abs=1e-9)
    assert along == pytest.approx([0.0, -0.3, 0.0])
    assert guide.held(np.full((4, 4), np.nan)) is None
    assert guide.held(at(0.5, 0.0, 0.0) @ start) is None, "the way is not near"
    wish = start.copy()
    wish[0, 3] = np.inf
    assert guide.drawn(wish) is wish
    ended = guide.held(at(0.0, -0.05, 0.3) @ start)
    assert ended is not None and not ended[1].any(), "no pull beyond the end"
    # A device feels the way, once a script has the tool no more: its wishes stay as they are.
    assert bench.session.guide_now() is None
    bench.clock.now += 60.0
    assert bench.session.guide_now() is guide
    bench.session.wish(at(0.005, -0.02, 0.0) @ start, 7, "device")
    bench.tick()
    assert bench.pose[0, 3] - start[0, 3] == pytest.approx(0.005)
    bench.session.hand_gone()
    assert bench.document["guiding"] is None


def test_a_way_of_a_card_guides_several_parts() -> None:
    bench = Bench(mockup=chest())
    way = {"parts": [LID, POST], "poses": [row(at(0, 0, 0)), row(at(0, -0.5, 0))], "clearance": None}
    bench.command("way_take", ways=[way])
    line = bench.document["sequence"][0]["id"]
    card, _ = told(bench, "way_check", line)
    assert card.is_good
    bench.command("put_back", parts=[LID, POST])
    with pytest.raises(WorkbenchError, match="lid is not in the hand"):
        bench.command("guide", card=card.id)
    for wrong in ({}, {"card": card.id, "line": line}):
        with pytest.raises(WorkbenchError, match="name a card, or a line"):
            bench.command("guide", **wrong)
    bench.command("grip", parts=[LID, POST])
    bench.command("guide", card=card.id, step=0)
    begin = np.array(bench.document["guiding"]["way"][0]).reshape(4, 4)
    assert begin == pytest.approx(bench.pose, abs=1e-12)
    # Gripped at another place to each other, no way of both fits.
    bench.command("release")
    bench.command("grip", parts=POST)
    bench.drag(at(0.1, 0.0, 0.0) @ bench.pose, 0.5)
    bench.command("grip", parts=LID)
    with pytest.raises(WorkbenchError, match="is held otherwise than on the way"):
        bench.command("guide", line=line)


def test_a_record_of_a_guided_hand_is_replayed_without_the_guide(tmp_path: Path) -> None:
    bench = Bench(mockup=chest(), record=tmp_path / "a.jsonl")
    guided(bench)
    start = bench.pose.copy()
    bench.drag(at(0.004, -0.03, 0.0) @ start, 0.5)
    bench.command("release")
    line = bench.document["sequence"][-1]
    bench.session.close()
    record = read_record(tmp_path / "a.jsonl")
    assert not {"guide", "guide_end"} & {each.get("name") for each in record.entries}
    again = replay(record, bench.mockup, feeler.Scene(bench.mockup), None)
    assert again and again.parted is None and again.ticks > 2
    moves = np.array(line["way"]).reshape(-1, 4, 4)
    assert np.ptp(moves[:, 0, 3]) < 1e-9, "it went along the way"


def test_a_guide_goes_with_its_card() -> None:
    bench = Bench(mockup=chest())
    card = answered(bench, bench.command("ask", question="removal", parts=[LID])["id"])
    bench.command("grip", parts=LID)
    bench.command("guide", card=card.id)
    assert bench.document["guiding"]["card"] == card.id
    bench.command("card_remove", id=card.id)
    assert bench.document["guiding"] is None
