"""Joints that were moved, in projects, records and undo, and with two people."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from workbench_scene import FACES, corners

import feeler
from feeler.cli.view import _begin_mechanism
from feeler.project.book import open_or_make
from feeler.workbench.document.line_facts import line_length
from feeler.workbench.engine.mechanism import text_of
from feeler.workbench.session.export import sequence_csv
from feeler.workbench.session.record import read_record
from feeler.workbench.session.replaying import replay
from feeler.workbench.session.session import Session

DOOR, WALL, KNOB, DRAWER = range(4)
TEXT = """
[[joint]]
name = "hinge"
kind = "revolute"
child = ["door", "knob"]
axis = [0, 0, 1]
point_m = [0, 0, 0]

[[joint]]
name = "drawer"
kind = "prismatic"
child = "drawer"
axis = [1, 0, 0]
limits_m = [0, 0.3]
"""


def doors(shift: float = 0.0) -> feeler.Mockup:
    """A door along x about the z axis, a wall that it meets, its knob, and a drawer that it meets on the way back."""
    boxes = [
        corners((0.1, -0.01, 0.0), (1.0, 0.01, 1.0)),
        corners((-0.5 + shift, 0.5, 0.0), (0.3 + shift, 0.6, 1.0)),
        corners((0.9, 0.02, 0.4), (0.95, 0.05, 0.5)),
        corners((0.2, -0.5, 0.2), (0.4, -0.3, 0.4)),
    ]
    faces = np.concatenate([FACES + 8 * i for i in range(4)])
    return feeler.Mockup(np.concatenate(boxes), faces, np.repeat(np.arange(4), 12), ["door", "wall", "knob", "drawer"])


def opened(mockup: feeler.Mockup | None = None, **more: Any) -> Session:
    mockup = mockup or doors()
    session = Session(has_threads=False, **more)
    session.open(mockup, feeler.Scene(mockup), None)
    return session


def begun(mockup: feeler.Mockup | None = None, **more: Any) -> Session:
    session = opened(mockup, **more)
    session.command("mechanism_open", {"name": "door.toml", "text": TEXT})
    return session


def known(session: Session) -> dict[str, Any]:
    end = time.monotonic() + 60.0
    while any(each.state == "running" for each in session.current.joint_ranges):
        assert time.monotonic() < end, session.current.joint_ranges
        time.sleep(0.01)
    return {each.name: each for each in session.current.joint_ranges}


def values(session: Session) -> dict[str, float]:
    assert session.current.mechanism is not None
    return dict(session.current.mechanism.values)


def test_a_project_keeps_the_mechanism_its_position_and_its_lines(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = begun(project=open_or_make(path))
    session.command("joint_move", {"name": "drawer", "value": 0.3})
    assert values(session)["drawer"] == 0.3, "its limit, to the last digit"
    session.command("joint_move", {"name": "drawer", "value": 0.2})
    session.command("joint_move", {"name": "hinge", "value": 0.4})
    session.command("joint_step", {})
    session.command("joint_move", {"name": "hinge", "value": 0.6})
    before, moved, ranges = values(session), dict(session.current.moved), known(session)
    session.close()
    again = opened(project=open_or_make(path))
    assert values(again) == pytest.approx(before)
    assert again.current.moved.keys() == moved.keys() == {DOOR, KNOB, DRAWER}
    for part, pose in moved.items():
        assert again.current.moved[part] == pytest.approx(pose)
    assert [line.joint.name for line in again.current.sequence] == ["drawer", "hinge"]
    for name, each in known(again).items():
        assert (each.lower, each.upper) == pytest.approx((ranges[name].lower, ranges[name].upper))
    again.command("joint_step_go", {"id": again.current.sequence[1].id})
    assert values(again) == pytest.approx({"hinge": 0.4, "drawer": 0.2})
    again.command("joint_move", {"name": "hinge", "value": 3.0})
    assert values(again)["hinge"] == pytest.approx(known(again)["hinge"].upper, abs=1e-9)
    again.close()


def test_a_project_of_another_revision_stands_where_it_was_and_is_asked_anew(tmp_path: Path) -> None:
    path = tmp_path / "a.feelproj"
    session = begun(project=open_or_make(path))
    upper = known(session)["hinge"].upper
    session.command("joint_move", {"name": "hinge", "value": 0.4})
    session.close()
    again = opened(doors(shift=0.3), project=open_or_make(path))
    assert values(again)["hinge"] == pytest.approx(0.4) and known(again)["hinge"].upper < upper
    again.close()


def test_a_project_opened_with_its_file_again_stands_where_it_did() -> None:
    session = begun()
    session.command("joint_move", {"name": "hinge", "value": 0.4})
    _begin_mechanism(session, "door.toml", TEXT)
    assert values(session)["hinge"] == pytest.approx(0.4) and DOOR in session.current.moved
    _begin_mechanism(session, "door.toml", TEXT + "\n# another\n")
    assert values(session)["hinge"] == 0.0 and not session.current.moved
    session.close()


def test_a_record_with_joints_gives_the_same_again(tmp_path: Path) -> None:
    path = tmp_path / "a.rec"
    session = begun(record=path)
    known(session)
    session.ask("joint_to", {"name": "hinge", "value": 0.7})
    session.command("joint_move", {"name": "hinge", "value": 3.0})
    session.command("joint_step", {})
    session.command("joint_move", {"name": "drawer", "value": 0.1})
    session.command("joint_take", {"name": "drawer"})
    wish = np.array(session.engine.pose)
    wish[0, 3] += 0.1
    session.wish(wish, 1, "mouse")
    session.engine.tick()
    session.command("release", {})
    session.command("undo", {})
    session.command("undo", {})
    session.command("joint_step_go", {"id": session.current.sequence[0].id})
    session.command("mechanism_close", {})
    session.close()
    mockup = doors()
    found = replay(read_record(path), mockup, feeler.Scene(mockup), None)
    assert found.parted is None and found.commands == 10, found.parted


def test_a_record_of_a_door_in_the_hand_gives_the_same_bits(tmp_path: Path) -> None:
    path = tmp_path / "a.rec"
    session = begun(record=path)
    session.command("joint_move", {"name": "hinge", "value": 0.3})
    session.command("joint_take", {"name": "hinge"})
    session.engine.tick()
    for number in range(1, 40):
        wish = np.array(session.engine.pose)
        wish[:3, 3] += (-0.013, 0.007 * number, 0.01)
        session.wish(wish, number, "mouse")
        session.engine.tick()
    session.command("release", {})
    session.close()
    mockup = doors()
    found = replay(read_record(path), mockup, feeler.Scene(mockup), None)
    assert found.parted is None and found.ticks >= 40, found.parted


def test_where_a_joint_stops_does_not_depend_on_what_was_asked_before() -> None:
    """From elsewhere in its range a cast ends elsewhere by rounding."""

    def stop(first: list[tuple[str, float]]) -> float:
        session = begun()
        for name, value in first:
            session.ask("joint_to", {"name": "hinge", "value": 3.0})
            session.command("joint_move", {"name": name, "value": value})
        session.command("joint_move", {"name": "hinge", "value": 3.0})
        found = values(session)["hinge"]
        session.close()
        return found

    places = np.linspace(0.1, 0.9, 4)
    assert [stop([("hinge", at)]) for at in places] == [
        stop([("drawer", 0.1), ("hinge", at), ("drawer", 0.0)]) for at in places
    ]


ENDLESS = """
[[joint]]
name = "hinge"
kind = "revolute"
child = ["door", "knob"]

[[joint]]
name = "drawer"
kind = "prismatic"
child = "drawer"
axis = [0, -1, 0]
"""


def test_a_joint_without_limits_goes_where_it_is_told_to(tmp_path: Path) -> None:
    """More than a turn, or than twice the size of the mock-up; the check of its step says the same, and a record."""
    session = opened(doors(9.0), record=tmp_path / "a.rec")
    session.command("mechanism_open", {"name": "m.toml", "text": ENDLESS})
    session.command("joint_move", {"name": "drawer", "value": 2.0})
    session.command("joint_step", {})
    for name, value in (("hinge", math.radians(450)), ("hinge", math.radians(-900)), ("drawer", 60.0)):
        place = session.ask("joint_to", {"name": name, "value": value})
        assert (place["value"], place["stop"], place["why"]) == (value, None, "")
        session.command("joint_move", {"name": name, "value": value})
        assert values(session)[name] == value
    session.command("joint_step", {})
    for line in session.current.sequence[1:]:
        session.command("way_check", {"id": line.id})
    end = time.monotonic() + 60.0
    while any(card.state not in ("done", "failed") for card in session.current.cards):
        assert time.monotonic() < end
        time.sleep(0.01)
    told = [card.sentence for card in session.current.cards]
    assert told == ["hinge moves freely from 0° to -900°.", "drawer moves freely from 2000 mm to 60000 mm."], told
    far = session.ask("joint_to", {"name": "drawer", "value": 1e6})
    assert far["stop"] == "end" and far["why"].startswith("'drawer' has no limit: it was followed to "), far
    session.close()
    mockup = doors(9.0)
    assert replay(read_record(tmp_path / "a.rec"), mockup, feeler.Scene(mockup), None)


def test_undo_and_redo_go_through_all_positions() -> None:
    session = begun()
    for name, value in (("hinge", 0.3), ("drawer", 0.2), ("hinge", -0.2)):
        session.command("joint_move", {"name": name, "value": value})
    session.command("joint_step", {})
    after = (values(session), session.current.moved, len(session.current.sequence))
    seen = []
    for _ in range(4):
        session.command("undo", {})
        seen.append((values(session)["hinge"], values(session)["drawer"]))
    assert seen == [(-0.2, 0.2), (0.3, 0.2), (0.3, 0.0), (0.0, 0.0)] and not session.current.moved
    for _ in range(4):
        session.command("redo", {})
    assert (values(session), session.current.moved, len(session.current.sequence)) == after
    # What was undone and done otherwise is asked anew: the drawer is in the way of the door.
    lower = known(session)["hinge"].lower
    session.command("joint_move", {"name": "drawer", "value": 0.0})
    assert known(session)["hinge"].lower != lower
    session.close()


def test_the_mechanism_of_the_start_stays_whatever_is_undone(tmp_path: Path) -> None:
    session = opened(record=tmp_path / "a.rec")
    _begin_mechanism(session, "door.toml", TEXT)
    session.command("joint_move", {"name": "hinge", "value": 0.4})
    session.command("undo", {})
    with pytest.raises(feeler.WorkbenchError, match="nothing to undo"):
        session.command("undo", {})
    assert session.current.mechanism is not None and session.current.mechanism.name == "door.toml"
    # One that is opened later is a step, also one with a mistake.
    session.command("mechanism_open", {"name": "other.toml", "text": TEXT})
    for text in ("", " \n"):
        with pytest.raises(feeler.WorkbenchError, match=r"e\.toml: there is no \[\[joint\]\]"):
            session.command("mechanism_open", {"name": "e.toml", "text": text})
    session.command("undo", {})
    assert session.current.mechanism.name == "door.toml"
    session.close()
    mockup = doors()
    assert replay(read_record(tmp_path / "a.rec"), mockup, feeler.Scene(mockup), None)


def test_who_has_the_tool_moves_the_joints() -> None:
    clock = [0.0]
    session = begun(clock=lambda: clock[0])
    clock[0] = 60.0
    one, two = session.people.join(), session.people.join()
    session.command("joint_move", {"name": "hinge", "value": 0.3}, one)
    with pytest.raises(feeler.WorkbenchError, match="has the tool"):
        session.command("joint_move", {"name": "hinge", "value": 0.1}, two)
    with pytest.raises(feeler.WorkbenchError, match="has the tool"):
        session.command("mechanism_close", {}, two)
    assert values(session)["hinge"] == pytest.approx(0.3)
    session.close()


def test_a_hand_that_holds_parts_is_not_moved_by_a_slider() -> None:
    session = begun()
    session.command("joint_take", {"name": "hinge"})
    for name, args in (
        ("mechanism_open", {"name": "a.toml", "text": TEXT}),
        ("mechanism_close", {}),
        ("joint_take", {"name": "drawer"}),
    ):
        with pytest.raises(feeler.WorkbenchError, match="the hand holds parts"):
            session.command(name, args)
    session.command("release", {})
    session.close()


def test_words_that_are_no_joint_are_refused() -> None:
    session = begun()
    with pytest.raises(feeler.WorkbenchError, match="hinge"):
        session.command("joint_move", {"name": "hing", "value": 0.3})
    for value in (math.nan, math.inf):
        with pytest.raises(feeler.WorkbenchError):
            session.ask("joint_to", {"name": "hinge", "value": value})
    session.close()


def test_a_part_that_was_put_down_elsewhere_is_met_there() -> None:
    session = begun()
    session.command("joint_move", {"name": "hinge", "value": 0.3})
    session.command("grip", {"parts": [WALL]})
    pose = np.array(session.engine.pose)
    pose[0, 3] += 0.3
    session.command("set_mode", {"mode": "pass"})
    session.command("place", {"pose": pose.ravel().tolist()})
    session.command("release", {})
    there = session.current.moved[WALL]
    assert there[3] == pytest.approx(0.3)
    found = known(session)["hinge"]
    other = begun(mockup=doors(shift=0.3))
    assert found.above.other == WALL and found.upper == pytest.approx(known(other)["hinge"].upper, abs=1e-6)
    assert found.worst.points[1][0] > 0.0
    other.close()
    session.close()


def test_tables_and_reports_say_that_a_joint_moved_the_parts() -> None:
    session = begun()
    session.command("joint_move", {"name": "hinge", "value": 0.5})
    session.command("joint_move", {"name": "drawer", "value": 0.25})
    session.command("joint_step", {})
    mockup = session.scene.mockup
    rows = sequence_csv(session.current, mockup, lambda *_: None).decode("utf-8-sig").splitlines()
    assert len(rows) == 3 and all(row.endswith("moved by a joint") for row in rows[1:]), rows
    steps = session.job("report", {"pictures": 0}).result(timeout=60)
    page = session.export(steps["name"]).decode()
    assert "2 moves of joints" in page and "of ways" not in page
    assert "hinge from 0° to 28.65°" in page and "drawer from 0 mm to 250 mm" in page and "nothing near" not in page
    session.close()


def test_a_step_of_a_door_is_as_long_as_the_step_back() -> None:
    """Also of a knob on the door, whose box turns with it."""
    text = TEXT.replace('["door", "knob"]', '["door"]') + (
        '[[joint]]\nname = "turn"\nkind = "revolute"\nparent = "door"\nchild = "knob"\naxis = [0, 1, 0]\n'
        "point_m = [0.9, 0, 0.4]\n"
    )
    mockup = doors(9.0)
    session = opened(mockup)
    session.command("mechanism_open", {"name": "door.toml", "text": text})
    for moves in ((("turn", 0.5), ("hinge", 0.9)), (("turn", 0.0),), (("hinge", 0.4),), (("hinge", 0.9),)):
        for name, value in moves:
            session.command("joint_move", {"name": name, "value": value})
        session.command("joint_step", {})
    lengths = [line_length(line, mockup.part_bounds) for line in session.current.sequence]
    radius = math.hypot(0.025, 0.05)  # of the middle of the knob about its axis
    assert lengths[0] == pytest.approx(0.5 * radius, rel=1e-3) and lengths[2] == pytest.approx(lengths[0], rel=1e-9)
    assert lengths[3] == pytest.approx(lengths[4], rel=1e-9)
    session.close()


CRANK = """
[[joint]]
name = "crank"
kind = "revolute"
child = "crank"
axis = [0, 0, 1]
point_m = [0, 0, 0]
limits_rad = [-0.1, 1.1]

[[joint]]
name = "rod"
kind = "revolute"
parent = "crank"
child = "rod"
axis = [0, 0, 1]
point_m = [0.1, 0, 0]
limits_rad = [-1.5, 0.2]

[[joint]]
name = "piston"
kind = "prismatic"
child = "piston"
axis = [1, 0, 0]

[[loop]]
name = "pin"
kind = "revolute"
parent = "rod"
child = "piston"
axis = [0, 0, 1]
point_m = [0.4, 0, 0]
"""


def crank() -> Session:
    boxes = [
        corners((0.0, -0.01, 0.0), (0.1, 0.01, 0.01)),
        corners((0.1, -0.01, 0.02), (0.4, 0.01, 0.03)),
        corners((0.38, -0.02, 0.04), (0.42, 0.02, 0.05)),
    ]
    faces = np.concatenate([FACES + 8 * i for i in range(3)])
    names = ["crank", "rod", "piston"]
    session = opened(feeler.Mockup(np.concatenate(boxes), faces, np.repeat(np.arange(3), 12), names))
    session.command("mechanism_open", {"name": "crank.toml", "text": CRANK})
    return session


def piston(angle: float) -> float:
    """Where the piston of `crank` is, by the closed form of the slider-crank."""
    return 0.1 * math.cos(angle) + math.sqrt(0.09 - (0.1 * math.sin(angle)) ** 2) - 0.4


def test_a_position_of_a_loop_is_kept_by_one_of_its_joints() -> None:
    session = crank()
    session.command("joint_move", {"name": "crank", "value": 1.0})
    assert values(session)["piston"] == pytest.approx(piston(1.0), abs=1e-9)
    session.command("joint_step", {})
    lines = session.current.sequence
    assert {line.joint.name for line in lines} == {"crank"} and len(lines) == 3
    ends = {part: pose for line in lines for part, pose in line.after.items()}
    for part, pose in session.current.moved.items():
        assert ends[part] == pytest.approx(pose, abs=1e-9)
    session.command("joint_move", {"name": "crank", "value": 0.2})
    session.command("joint_step_go", {"id": lines[0].id})
    assert values(session)["piston"] == pytest.approx(piston(1.0), abs=1e-9)
    session.close()


def test_a_joint_that_others_follow_is_taken_in_the_hand() -> None:
    session = crank()
    session.command("joint_take", {"name": "crank"})
    assert set(session.current.gripped) == {0}, "the rod and the piston move otherwise"
    hand = np.array(session.engine.pose)
    turn = np.eye(4)
    turn[:2, :2] = [[math.cos(0.5), -math.sin(0.5)], [math.sin(0.5), math.cos(0.5)]]
    session.wish(turn @ hand, 1, "mouse")
    session.engine.tick()
    seen: list[dict[str, Any]] = []
    session.subscribe(seen.append)
    guide = session.engine.guide
    session.joints.follow(session.current, "crank", guide.value_of(session.engine.pose))
    assert seen[-1]["type"] == "joints" and seen[-1]["values"]["piston"] == pytest.approx(piston(0.5), abs=1e-9)
    place = next(k for k, link in enumerate(session.current.mechanism.links) if link.name == "piston")
    assert seen[-1]["poses"][place][3] == pytest.approx(piston(0.5), abs=1e-9)
    session.command("release", {})
    assert values(session)["piston"] == pytest.approx(piston(0.5), abs=1e-6)
    assert session.current.moved[2][3] == pytest.approx(piston(0.5), abs=1e-6) and not session.current.gripped
    session.command("joint_step", {})
    assert {line.joint.name for line in session.current.sequence} == {"crank"}
    with pytest.raises(feeler.WorkbenchError, match="carried by joints that move with it"):
        session.command("joint_take", {"name": "rod"})
    session.close()


def test_the_door_of_the_sample_opens_once_its_latch_is_turned() -> None:
    """Pages and Python give the same ranges; the truth of the sample has the limits."""
    mockup = feeler.sample("gearbox", 75_000)
    truth = {each.name: each for each in feeler.sample_truth("gearbox", 75_000).joints}
    leaf = [path for path in truth["door"].parts if not path.endswith("/latch")]
    door, latch = (
        feeler.Joint(name, "revolute", parent, parts, axis=truth[name].axis, point=truth[name].point_m)
        for name, parent, parts in (("door", None, leaf), ("latch", "gearbox/door/panel", ["gearbox/door/latch"]))
    )
    mechanism = feeler.Mechanism(mockup, [door, latch])
    text = text_of(mechanism)
    session = opened(mockup)
    session.command("mechanism_open", {"name": "door.toml", "text": text})
    for turned in (0.0, truth["latch"].high):
        session.command("joint_move", {"name": "latch", "value": turned})
        free = mechanism.range("door", {"latch": turned})
        place = session.ask("joint_to", {"name": "door", "value": 9.0})
        assert place["value"] == pytest.approx(free.upper, abs=1e-9) and place["met"]["part"] == free.above.part
        assert (free.upper > truth["door"].high) == (turned > 0.0)
    session.close()
