"""Mechanisms in the workbench: sliders that stop at contact, ranges, steps of the sequence, and the hand on a joint."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from workbench_scene import FACES, corners

import feeler
from feeler.workbench.engine.joint_hand import MOST_N, Freedom, JointGuide
from feeler.workbench.session.session import Session

DOOR, WALL, KNOB, BOX = range(4)
TEXT = """
[[joint]]
name = "hinge"
kind = "revolute"
child = ["door", "knob"]
axis = [0, 0, 1]
point_m = [0, 0, 0]
limits_deg = [-90, 170]
"""


def doors() -> feeler.Mockup:
    """A door along x about the z axis, its knob, a wall that it meets, and a box farther out."""
    boxes = [
        corners((0.1, -0.01, 0.0), (1.0, 0.01, 1.0)),
        corners((-0.5, 0.5, 0.0), (0.3, 0.6, 1.0)),
        corners((0.9, 0.02, 0.4), (0.95, 0.05, 0.5)),
        corners((0.2, -0.5, 0.2), (0.4, -0.3, 0.4)),
    ]
    faces = np.concatenate([FACES + 8 * i for i in range(4)])
    return feeler.Mockup(np.concatenate(boxes), faces, np.repeat(np.arange(4), 12), ["door", "wall", "knob", "box"])


@pytest.fixture
def session() -> object:
    mockup = doors()
    with Session(has_threads=False) as opened:
        opened.open(mockup, feeler.Scene(mockup), None)
        opened.command("mechanism_open", {"name": "door.toml", "text": TEXT})
        yield opened


def known_all(session: Session) -> tuple:
    end = time.monotonic() + 60.0
    while any(each.state == "running" for each in session.current.joint_ranges):
        assert time.monotonic() < end, session.current.joint_ranges
        time.sleep(0.01)
    return session.current.joint_ranges


def known(session: Session) -> object:
    (found,) = known_all(session)
    return found


def free(session: Session) -> tuple[float, float]:
    mockup = session.scene.mockup
    joint = feeler.Joint("hinge", "revolute", None, ["door", "knob"], limits=(-math.pi / 2, math.radians(170)))
    found = feeler.Mechanism(mockup, [joint]).range("hinge")
    return found.lower, found.upper


def test_a_slider_stops_at_contact_and_shows_all_pages_where(session: Session) -> None:
    lower, upper = free(session)
    seen: list[dict] = []
    session.subscribe(seen.append)
    place = session.ask("joint_to", {"name": "hinge", "value": 2.0})
    assert place is not None and place["value"] == pytest.approx(upper, abs=1e-9) and place["stop"] == "contact"
    assert place["met"]["other"] == WALL and 0.5 < upper < 2.0
    shown = [event for event in seen if event["type"] == "joints"]
    turned = np.reshape(shown[-1]["poses"][0], (4, 4))
    assert math.atan2(turned[1, 0], turned[0, 0]) == pytest.approx(upper, abs=1e-9)
    assert not session.current.moved, "it is shown, and changes nothing"
    below = session.ask("joint_to", {"name": "hinge", "value": -1.5})
    assert below is not None and below["value"] == pytest.approx(max(lower, -1.5)) and below["met"]["other"] == BOX
    end = session.ask("joint_to", {"name": "hinge", "value": -2.0})
    assert end is not None and end["stop"] == ("contact" if lower > -1.5 else "limit"), end
    session.ask("joint_to", {"name": "hinge", "value": None})
    assert seen[-1]["poses"] is None


def test_ignored_pairs_stop_nothing(session: Session) -> None:
    stops = session.ask("joint_to", {"name": "hinge", "value": 2.0})
    text = 'ignore = [["wall", "door"], ["knob", 1]]\n' + TEXT
    session.command("mechanism_open", {"name": "door.toml", "text": text})
    passes = session.ask("joint_to", {"name": "hinge", "value": 2.0})
    assert stops is not None and stops["stop"] == "contact"
    assert passes is not None and passes["value"] == pytest.approx(2.0) and passes["stop"] is None


def test_a_move_is_one_step_of_undo_and_the_scene_stands_there(session: Session) -> None:
    session.command("joint_move", {"name": "hinge", "value": 0.4})
    assert sorted(session.current.moved) == [DOOR, KNOB]
    place = np.reshape(session.current.moved[KNOB], (4, 4))
    assert np.allclose(place[:2, :2], [[math.cos(0.4), -math.sin(0.4)], [math.sin(0.4), math.cos(0.4)]])
    assert session.current.mechanism.values["hinge"] == pytest.approx(0.4)
    before = session.current.world
    session.command("undo", {})
    assert not session.current.moved and session.current.mechanism.values["hinge"] == 0.0
    assert session.current.world != before, "answers of before are stale"
    session.command("joint_move", {"name": "hinge", "value": 3.0})
    assert session.current.mechanism.values["hinge"] == pytest.approx(free(session)[1], abs=1e-9)


def test_parts_that_are_out_stop_nothing_and_go_with_nothing(session: Session) -> None:
    upper = free(session)[1]
    far = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1]
    session.command(
        "way_take", {"ways": [{"parts": [WALL, KNOB], "poses": [list(np.eye(4).ravel()), far], "clearance": None}]}
    )
    place = session.ask("joint_to", {"name": "hinge", "value": 2.0})
    assert place is not None and place["value"] == pytest.approx(2.0) and upper < 2.0
    session.command("joint_move", {"name": "hinge", "value": 2.0})
    assert session.current.moved[KNOB] == tuple(map(float, far)), "a part that is out stays there"
    session.command("put_back", {"parts": [KNOB]})
    assert session.current.moved[KNOB] == session.current.moved[DOOR], "it goes back onto the open door"


def test_ranges_come_with_gaps_and_the_worst_position_as_a_ghost(session: Session) -> None:
    found = known(session)
    assert found.state == "done", found.trouble
    lower, upper = free(session)
    assert (found.lower, found.upper) == (pytest.approx(lower), pytest.approx(upper)) and found.above.other == WALL
    gaps = [gap for value, gap in found.curve if abs(value) < 0.2 and gap is not None]
    assert gaps and min(gaps) > 0.1 and found.worst.gap < 1e-3
    ghost = session.ask("joint_ghost", {"name": "hinge"})
    assert ghost is not None and ghost["manifest"]["triangles"] == 24
    # Another position of the joint is in the same range; a part that leaves makes another one.
    session.command("joint_move", {"name": "hinge", "value": 0.2})
    assert known(session).key == found.key
    session.command("grip", {"parts": [WALL]})
    assert session.current.joint_ranges[0].key != found.key


CROWD = """
[[joint]]
name = "a"
kind = "revolute"
child = ["p0", "p1"]
axis = [1, 2, 0.5]
point_m = [0.1, 0.2, 0]
limits_rad = [-0.4, 0.4]

[[joint]]
name = "b"
kind = "prismatic"
parent = "p0"
child = "p2"
axis = [0, 1, -1]
limits_m = [-0.3, 0.3]

[[joint]]
name = "c"
kind = "revolute"
child = "p3"
axis = [0, 0, 1]
point_m = [0, 0.1, 0]

[[coupling]]
joint = "c"
of = "a"
ratio = -1.0
"""


@pytest.mark.parametrize("seed", range(3))
def test_the_worst_position_names_the_pair_that_is_nearest_there(seed: int) -> None:
    """Of boxes at random: 0 and 1 turn, 2 slides on them, 3 turns the other way, 9 is out, the others stand."""
    rng = np.random.default_rng(seed)
    lows, sizes = rng.uniform(-0.8, 0.8, (10, 3)), rng.uniform(0.04, 0.2, (10, 3))
    boxes = [corners(low, low + size) for low, size in zip(lows, sizes, strict=True)]
    faces = np.concatenate([FACES + 8 * i for i in range(10)])
    mockup = feeler.Mockup(np.concatenate(boxes), faces, np.repeat(np.arange(10), 12), [f"p{i}" for i in range(10)])
    away = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 9, 0, 0, 0, 1]
    with Session(has_threads=False) as session:
        session.open(mockup, feeler.Scene(mockup), None)
        session.command("mechanism_open", {"name": "crowd.toml", "text": CROWD})
        ways = [{"parts": [9], "poses": [list(np.eye(4).ravel()), away], "clearance": None}]
        session.command("way_take", {"ways": ways})
        session.command("joint_move", {"name": "b", "value": 0.05})
        of_part = {part: place for place, link in enumerate(session.current.mechanism.links) for part in link.parts}
        for each in known_all(session):
            assert each.state == "done" and each.worst is not None
            scenes, tools = [], []
            for part, box in enumerate(boxes[:9]):
                pose = np.reshape(each.worst.poses[of_part[part]], (4, 4)) if part in of_part else np.eye(4)
                placed = box @ pose[:3, :3].T + pose[:3, 3]
                scenes.append(feeler.Scene(feeler.Mockup(placed, FACES)))
                tools.append(feeler.Tool(placed, FACES))
            moving = ({0, 1, 2}, {3}) if each.name == "a" else ({2},)
            gaps = {
                (one, other): scenes[other].distance(tools[one], np.eye(4)).value
                for group in moving
                for one in group
                for other in set(range(9)) - group
            }
            pair = min(gaps, key=gaps.get)
            assert set(pair) == {each.worst.part, each.worst.other}
            assert each.worst.gap == pytest.approx(gaps[pair], abs=1e-6)
            assert math.dist(*each.worst.points) == pytest.approx(gaps[pair], abs=1e-6)


def test_positions_are_lines_of_the_sequence_that_later_steps_are_asked_at(session: Session) -> None:
    session.command("joint_move", {"name": "hinge", "value": 0.5})
    session.command("joint_step", {})
    (line,) = session.current.sequence
    assert line.joint.name == "hinge" and line.joint.end == pytest.approx(0.5) and set(line.parts) == {DOOR, KNOB}
    assert line.name == f"Move hinge to {math.degrees(0.5):.4g}°"
    for part, place in line.after.items():
        assert np.allclose(place, session.current.moved[part], atol=1e-12)
    with pytest.raises(feeler.WorkbenchError, match="where the sequence has them"):
        session.command("joint_step", {})
    session.command("joint_move", {"name": "hinge", "value": 0.0})
    session.command("joint_step_go", {"id": line.id})
    assert session.current.mechanism.values["hinge"] == pytest.approx(0.5)
    film = session.job("film", {}).result(timeout=60)
    assert len(film["ways"][0]["poses"]) >= 7 and film["ways"][0]["gaps"]
    session.command("way_check", {"id": line.id})
    end = time.monotonic() + 60.0
    while session.current.cards[-1].state not in ("done", "failed"):
        assert time.monotonic() < end
        time.sleep(0.01)
    card = session.current.cards[-1]
    assert card.is_good and card.sentence == f"hinge moves freely from 0° to {math.degrees(0.5):.4g}°.", card.sentence


def test_files_that_say_something_else_are_refused_by_their_line(session: Session) -> None:
    with pytest.raises(feeler.WorkbenchError, match=r"bad\.toml, line 4: .*limits"):
        session.command(
            "mechanism_open",
            {"name": "bad.toml", "text": '[[joint]]\nname = "a"\nkind = "revolute"\nlimits = [0, 1]\nchild = "door"\n'},
        )
    assert session.current.mechanism.name == "door.toml"
    session.command("mechanism_close", {})
    assert session.current.mechanism is None and not session.current.joint_ranges


def turned(angle: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return pose


def test_a_part_in_the_hand_is_felt_on_its_joint(session: Session) -> None:
    session.command("joint_take", {"name": "hinge"})
    hand = np.array(session.engine.pose)
    assert set(session.current.gripped) == {DOOR, KNOB} and session.current.on_joint == "hinge"
    # A hand that also leaves the axis: the door turns about it, and nothing else.
    wish = turned(0.3) @ hand
    wish[:3, 3] += (0.0, 0.0, 0.4)
    session.wish(wish, 1, "mouse")
    session.engine.tick()
    assert np.allclose(session.engine.pose, turned(0.3) @ hand, atol=1e-9)
    assert not np.any(session.snapshot().torque), "free: nothing is felt"
    upper = free(session)[1]
    session.wish(turned(upper + 0.2) @ hand, 2, "mouse")
    session.engine.tick()
    assert np.allclose(session.engine.pose, turned(upper) @ hand, atol=1e-7)
    torque = np.array(session.snapshot().torque)
    assert torque[2] < -0.1 and np.allclose(torque[:2], 0.0) and np.allclose(session.snapshot().force, 0.0)
    session.command("release", {})
    assert session.current.on_joint is None and not session.current.gripped and not session.current.sequence
    assert session.current.mechanism.values["hinge"] == pytest.approx(upper, abs=1e-6)
    session.command("undo", {})
    session.command("undo", {})
    assert session.current.mechanism.values["hinge"] == 0.0 and not session.current.moved


def test_a_joint_in_the_hand_does_not_touch_its_own_seats() -> None:
    """A pin through the door is none of its contacts, nor is what the mechanism ignores; a bolt through it is one."""
    boxes = [
        corners((0.0, -0.01, 0.0), (1.0, 0.01, 1.0)),
        corners((-0.005, -0.005, -0.1), (0.005, 0.005, 1.1)),
        corners((0.5, -0.2, 0.4), (0.52, 0.2, 0.42)),
        corners((0.7, -0.2, 0.4), (0.72, 0.2, 0.42)),
    ]
    names = ["door", "pin", "bolt", "strap"]
    faces = np.concatenate([FACES + 8 * i for i in range(4)])
    mockup = feeler.Mockup(np.concatenate(boxes), faces, np.repeat(np.arange(4), 12), names)
    text = 'ignore = [["strap", "door"]]\n' + "".join(
        f'[[joint]]\nname = "{child}"\nkind = "{kind}"\nchild = "{child}"\naxis = [0, 0, 1]\n'
        for child, kind in (("door", "revolute"), ("bolt", "prismatic"), ("strap", "prismatic"))
    )
    with Session(has_threads=False) as session:
        session.open(mockup, feeler.Scene(mockup), None)
        session.command("mechanism_open", {"name": "m.toml", "text": text})
        session.command("joint_take", {"name": "door"})
        session.engine.tick()
        assert session.snapshot().parts == [2] and session.snapshot().hits.parts.tolist() == [2]
        session.command("release", {})
        far = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1]
        way = {"parts": [2], "poses": [list(np.eye(4).ravel()), far], "clearance": None}
        session.command("way_take", {"ways": [way]})
        session.command("joint_take", {"name": "door"})
        session.engine.tick()
        assert session.snapshot().is_free and session.snapshot().depth == 0.0


@pytest.mark.parametrize("pitch", [0.0, 0.01])
def test_the_projection_on_a_joint_is_the_nearest_place(pitch: float) -> None:
    axis, point = np.array([0.0, 0.0, 1.0]), np.array([0.1, 0.2, 0.0])
    bounds = np.array([[-0.2, -0.1, -0.1], [0.3, 0.1, 0.1]])
    guide = JointGuide(Freedom(True, axis, point, pitch, 0.0, -3.0, 3.0, np.eye(4)), bounds)
    for value in np.linspace(-2.5, 2.5, 11):
        assert guide.value_of(guide.at(value)) == pytest.approx(value, abs=1e-9)
    rng = np.random.default_rng(1)
    box = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
    for _ in range(20):
        wish = guide.at(rng.uniform(-2, 2))
        wish[:3, 3] += rng.normal(0, 0.02, 3)
        off = [
            float((((box @ (guide.at(v) - wish)[:3, :3].T) + (guide.at(v) - wish)[:3, 3]) ** 2).sum())
            for v in (guide.value_of(wish) + d for d in (0.0, -1e-3, 1e-3))
        ]
        assert off[0] <= min(off[1:])


def test_a_slide_pulls_back_no_harder_than_it_may_and_not_in_doubt() -> None:
    bounds = np.array([[-0.1] * 3, [0.1] * 3])
    guide = JointGuide(Freedom(False, np.array([1.0, 0, 0]), np.zeros(3), 0.0, 0.0, 0.0, 0.05, np.eye(4)), bounds)
    wish = np.eye(4)
    wish[0, 3] = 0.06
    pose, force, torque = guide.reached(wish)
    assert pose[0, 3] == pytest.approx(0.05) and force[0] == pytest.approx(-3.0) and not torque.any()
    wish[0, 3] = 5.0
    assert guide.reached(wish)[1][0] == pytest.approx(-MOST_N)
    wish[0, 3] = np.nan
    assert guide.nearest(wish) is None and not guide.reached(wish)[1].any() and guide.held(wish) is None
