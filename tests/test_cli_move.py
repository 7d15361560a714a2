"""`feeler move`: joints, robots, animations, files of joints, and what is written."""

from __future__ import annotations

import csv
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import run, run_json
from shapes import box

import feeler
from feeler.io.export import Motion, animated_glb, write_glb

HINGE = '[[joint]]\nname = "hinge"\nkind = "revolute"\nchild = "*door"\nlimits_deg = [0, 90]\n'
ROBOT = (
    '<robot name="r"><link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>'
    '<link name="arm"><collision><origin xyz="0.3 0 0.1"/><geometry><box size="0.5 0.04 0.04"/></geometry></collision>'
    '<visual><origin xyz="0.3 0 0.1"/><geometry><box size="0.9 0.04 0.04"/></geometry></visual></link>'
    '<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1"/></joint></robot>'
)


def mockup(*boxes: tuple[str, tuple[float, ...], tuple[float, ...]]) -> feeler.Mockup:
    made = [box(low, high) for _, low, high in boxes]  # type: ignore[arg-type]
    vertices = np.concatenate([points for points, _ in made])
    faces = np.concatenate([np.asarray(each) + 8 * i for i, (_, each) in enumerate(made)])
    return feeler.Mockup(vertices, faces, np.repeat(np.arange(len(made)), 12), [name for name, _, _ in boxes])


@pytest.fixture
def door(tmp_path: Path) -> Path:
    """A thin door along x that turns about z, a wall that it meets at 58 degrees, and joints beside it."""
    write_glb(
        tmp_path / "m.glb", mockup(("door", (0.1, -0.01, 0), (1, 0.01, 1)), ("wall", (-0.5, 0.5, 0), (0.3, 0.6, 1)))
    )
    (tmp_path / "cowl.toml").write_text(HINGE)
    return tmp_path / "m.glb"


def document(path: Path) -> dict[str, Any]:
    """The JSON of a GLB file."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    found: dict[str, Any] = json.loads(data[20 : 20 + length])
    return found


def test_the_worst_position_shows_both_parts_and_their_closest_points(door: Path, tmp_path: Path) -> None:
    words = ["move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), "--joint", "hinge=0:30"]
    facts = run_json(*words, "--glb", str(tmp_path / "w.glb"), "--csv", str(tmp_path / "g.csv"))
    assert facts["worst"]["hinge"] == pytest.approx(np.radians(30), abs=1e-3)
    shown = feeler.load_mockup(tmp_path / "w.glb")
    assert shown.part_paths == ("w/m/door", "w/m/wall", "w/closest points")
    assert shown.part_colours is not None
    assert shown.part_colours[0] == pytest.approx((0.95, 0.55, 0.1), abs=0.01)
    assert shown.part_colours[1] == pytest.approx((0.8, 0.1, 0.1), abs=0.01)
    line = shown.parts[2]
    assert np.linalg.norm(np.subtract(line.upper, line.lower)) == pytest.approx(facts["upper"], rel=0.1)
    angle = facts["worst"]["hinge"]
    assert shown.parts[0].upper[1] == pytest.approx(np.sin(angle) + 0.01 * np.cos(angle), abs=1e-3)
    rows = list(csv.reader((tmp_path / "g.csv").read_text("utf-8-sig").splitlines()))
    assert rows[0] == ["hinge_rad", "gap_m", "lower_m"]
    assert all(float(low) <= float(gap) for _, gap, low in rows[1:])


def test_the_film_moves_the_parts_of_the_joint(door: Path, tmp_path: Path) -> None:
    words = ["move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), "--joint", "hinge=0:30"]
    assert "film written to" in run(*words, "--film", str(tmp_path / "f.glb")).stdout
    tracks = feeler.load_tracks(tmp_path / "f.glb")
    assert tracks.moving == ("f/m/door",) and (tracks.start, tracks.end) == (0.0, 4.0)
    turned = tracks.poses(2.0)["f/m/door"]
    assert np.degrees(np.arctan2(turned[1, 0], turned[0, 0])) == pytest.approx(15.0, abs=1e-3)


def test_the_film_of_many_turns_turns_the_way_of_the_joint(door: Path, tmp_path: Path) -> None:
    """Between two keys nothing turns by half a turn, where players would turn it back."""
    (tmp_path / "cowl.toml").write_text(HINGE.replace("limits_deg = [0, 90]\n", ""))
    words = ["move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), "--joint", "hinge=0:36000"]
    run(*words, "--film", str(tmp_path / "f.glb"), code=1)
    tracks = feeler.load_tracks(tmp_path / "f.glb")
    turned = tracks.poses(float(tracks.times[1]))["f/m/door"]
    angle = np.degrees(np.arctan2(turned[1, 0], turned[0, 0]))
    assert angle == pytest.approx(36000 * tracks.times[1] / 4.0, abs=1e-2) and 0 < angle <= 30


def test_an_animation_is_bounded_over_its_time(door: Path, tmp_path: Path) -> None:
    mock = feeler.load_mockup(door)
    turns = np.array([feeler.Joint("j", "revolute", None, 0).pose(angle) for angle in (0.0, 0.5, 1.5)])
    (tmp_path / "a.glb").write_bytes(animated_glb(mock, [Motion(0, np.arange(3.0), turns)]))
    words = ["move", str(tmp_path / "a.glb"), "--animation", "0"]
    assert run(*words, code=1).stdout.startswith("does not hold: parts meet\nthey first meet at time = ")
    mild = np.array([np.eye(4), turns[1]])
    (tmp_path / "a.glb").write_bytes(animated_glb(mock, [Motion(0, np.arange(2.0), mild)]))
    facts = run_json(*words, "--require", "1cm", "--csv", str(tmp_path / "a.csv"), "--glb", str(tmp_path / "aw.glb"))
    assert facts["holds"] and facts["worst"] == {"time": 1.0}
    assert (tmp_path / "a.csv").read_text("utf-8-sig").startswith("time_s,gap_m,lower_m")
    assert "closest points" in json.dumps(document(tmp_path / "aw.glb"))
    assert "no animation in it" in run("move", str(door), "--animation", "0", code=2).stderr
    assert "has no animation 'open'" in run("move", str(tmp_path / "a.glb"), "--animation", "open", code=2).stderr


def test_a_robot_brings_its_joints_and_stands_among_the_other_files(door: Path, tmp_path: Path) -> None:
    robot = tmp_path / "r.urdf"
    robot.write_text(ROBOT)
    ranges = run_json("move", str(robot))["ranges"]
    assert [(each["joint"], each["lower"], each["upper"]) for each in ranges] == [("turn", -1.0, 1.0)]
    write_glb(tmp_path / "post.glb", mockup(("post", (0.4, 0.3, 0), (0.5, 0.4, 1))))
    found = run("move", str(robot), str(tmp_path / "post.glb"), "--joint", "turn=0:57", code=1)
    assert "arm/box and post/post" in found.stdout
    assert run_json("move", str(robot), str(tmp_path / "post.glb"), "--joint", "turn=-50:0")["holds"]
    shown = run_json("move", str(robot), "--geometry", "visual")
    assert shown["mockup"]["parts"] == 2 and shown["mockup"]["triangles"] == 12


def test_a_joint_that_is_held_in_a_wall_does_not_hold(door: Path, tmp_path: Path) -> None:
    """Links that do not move against each other count too, with a range of another joint or without."""
    (tmp_path / "r.urdf").write_text(
        ROBOT.replace("0.3 0 0.1", "0.5 0 0.1").replace(
            "</robot>",
            '<link name="hand"><collision><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 0.1"/></geometry>'
            '</collision></link><joint name="grip" type="revolute"><parent link="arm"/><child link="hand"/>'
            '<axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint></robot>',
        )
    )
    write_glb(tmp_path / "post.glb", mockup(("post", (0.4, 0.3, 0), (0.5, 0.4, 0.2))))
    words = ["move", str(tmp_path / "r.urdf"), str(tmp_path / "post.glb"), "--joint", "turn=40"]
    for more in ([], ["--joint", "grip=-9:9"]):
        said = run(*words, *more, "--require", "1mm", code=1).stdout
        assert "does not hold: parts meet" in said and "turn = 40 degrees" in said and "arm/box" in said
    words[-1] = "turn=10"
    assert run(*words, "--require", "1mm").stdout.startswith("holds: ")


def test_parts_that_meet_are_told_where_they_first_do(door: Path, tmp_path: Path) -> None:
    words = ["move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), "--joint", "hinge=0:90"]
    assert "they first meet at hinge = 58.0536 degrees: m/door and m/wall" in run(*words, code=1).stdout
    assert run_json(*words, code=1)["first"]["value"] == pytest.approx(np.radians(58.0537), abs=1e-5)
    # "At least 0" is true of parts that go through each other, too.
    assert run(*words, "--require", "0", code=1).stdout.startswith("does not hold: parts meet")


def test_only_the_lower_bound_says_that_it_holds(door: Path, tmp_path: Path) -> None:
    words = ["move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), "--joint", "hinge=0:58"]
    said = run(*words, "--error", "100mm", code=1).stdout
    assert said.startswith("not proven to hold: the least gap is 0 m to") and "smaller --error" in said
    assert not run_json(*words, "--error", "100mm", code=1)["holds"]
    assert run(*words, "--error", "10um").stdout.startswith("holds: the least gap is ")
    assert run(*words, "--require", "1cm", code=1).stdout.startswith("does not hold: the least gap is ")


def hinge_files(tmp_path: Path) -> Path:
    """The door of the sample gearbox and what it hangs on."""
    whole = feeler.sample("gearbox", 75_000)
    kept = whole.parts.select(["gearbox/door/*", "gearbox/bracket*"])
    tool = feeler.Tool.of_parts(whole, kept.tolist())
    made = feeler.Mockup(
        tool.vertices, tool.faces, tool.part_of_face, tool.part_names, part_paths=[p.path for p in tool.parts]
    )
    write_glb(tmp_path / "door.glb", made)
    return tmp_path / "door.glb"


def test_joints_are_found_between_given_parts_and_written_with_their_reason(tmp_path: Path) -> None:
    file, out = hinge_files(tmp_path), tmp_path / "door.toml"
    mock = feeler.load_mockup(file)
    pins = [path for path in mock.part_paths if "/pin_" in path or "/rear_" in path or "/bracket" in path]
    assert pins
    done = run(
        *("move", str(file), "--write-mechanism", str(out)),
        *("--child", "*door_leaf_1", "--child", "*door_leaf_2", "--parent", "*pin_1", "--parent", "*pin_2"),
    )
    assert "door_leaf_1: " in done.stderr and "2 joints written" in done.stderr
    text = out.read_text()
    assert text.count("[[joint]]") == 2 and text.count("because = ") == 2 and 'parent = "*pin_1"' in text
    moved = feeler.Mechanism.load(out, mock)
    assert [each.name for each in moved.joints] == ["door_leaf_1", "door_leaf_2"]
    assert np.abs(moved.joints[0].axis[0]) == pytest.approx(1.0, abs=1e-3)


def test_joints_that_are_not_found_are_told_with_what_is_free(tmp_path: Path) -> None:
    file, out = tmp_path / "m.glb", tmp_path / "m.toml"
    write_glb(file, mockup(("plate", (0, 0, 0), (1, 1, 0.1)), ("block", (0.3, 0.3, 0.1), (0.5, 0.5, 0.3))))
    words = ["move", str(file), "--write-mechanism", str(out), "--child"]
    said = run(*words, "*block", code=2).stderr
    assert "--child '*block'" in said and "free are: " in said and not out.exists()
    assert "no part matches '*lid'" in run(*words, "*lid", code=2).stderr
    assert "leaves no part to move on" in run(*words, "*", code=2).stderr
    assert "one parent for each" in run(*words, "*block", "--parent", "*", "--parent", "*", code=2).stderr


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "nothing says what moves"),
        (["--mechanism", "cowl.toml", "--write-mechanism", "x.toml"], "ends: leave out --mechanism"),
        (["--mechanism", "cowl.toml", "--animation", "0"], "both say what moves"),
        (["--mechanism", "cowl.toml", "--child", "*"], "--child is for --write-mechanism"),
        (["--mechanism", "cowl.toml", "--geometry", "visual"], "are of a robot"),
        (["--mechanism", "cowl.toml", "--film", "f.glb"], "--film is for --joint: give it, too"),
        (["--mechanism", "cowl.toml", "--joint", "lid=0:1"], "joints: hinge"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=0:1:2"], "NAME=FROM:TO, or NAME=VALUE"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=0:3mm"], "angle"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=0:120"], "limits are 0 rad (0 degrees) to"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=90:0"], "(90 degrees) to 0 rad (0 degrees): give the least"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=10", "--csv", "g.csv"], "none does: give a range"),
        (["--mechanism", "cowl.toml", "--joint", "hinge=0:9", "--glb", "x.glb", "--film", "./x.glb"], "both write"),
        (["--mechanism", "none.toml"], "does not exist"),
        (["--animation", "0", "--joint", "hinge=0:1"], "leave them out"),
        (["--write-mechanism", "x.toml", "--parent", "*"], "--parent is for --child"),
        (["--write-mechanism", "x.json"], "must end in .toml"),
    ],
)
def test_wrong_words_say_what_to_do(
    door: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    said = run("move", str(door), *words, code=2).stderr
    assert says in said and "Traceback" not in said


def test_a_table_and_a_film_show_one_joint_only(tmp_path: Path) -> None:
    """Of two ranges there is no curve: an error, not a table without rows."""
    (tmp_path / "arm.urdf").write_text(
        ROBOT.replace(
            "</robot>",
            '<link name="hand"><collision><origin xyz="0.1 0 0.1"/><geometry><box size="0.1 0.1 0.1"/></geometry>'
            '</collision></link><joint name="grip" type="prismatic"><parent link="arm"/><child link="hand"/>'
            '<origin xyz="0.6 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="1"/></joint></robot>',
        )
    )
    words = ["move", str(tmp_path / "arm.urdf"), "--joint", "turn=0:9", "--joint", "grip=0:9mm"]
    for option, target in (("--csv", tmp_path / "g.csv"), ("--film", tmp_path / "f.glb")):
        assert f"{option} shows one joint that moves" in run(*words, option, str(target), code=2).stderr
        assert not target.exists()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (HINGE.replace("limits_deg", "limits"), "say limits_deg, limits_rad or limits_m"),
        (HINGE.replace("limits_deg", "limits_m"), "a revolute joint has no limits_m"),
        (HINGE + "axis = [0, 0, 0]\n", "line 6: axis of joint 'hinge' is [0, 0, 0], of length zero"),
        (HINGE.replace("[0, 90]", "[nan, 90]"), "line 5: limits_deg is [nan, 90]: give finite numbers"),
        (HINGE.replace("[0, 90]", "[9, 1]"), "line 5: limits_deg is [9, 1]: give the least value first"),
        (HINGE.replace('"*door"', "9"), "cowl.toml, line 4: child: "),
        (HINGE.replace('"*door"', "[]"), "cowl.toml, line 4: child names no part"),
        (HINGE + "parent = []\n", "cowl.toml, line 6: parent names no part"),
        (HINGE + HINGE.replace("[[joint]]", "[[loop]]"), "cowl.toml: two joints are called 'hinge'"),
        (HINGE.replace('"*door"', '"*"'), "whole mock-up"),
        (HINGE + HINGE.replace('"hinge"', '"lid"'), "moved by two joints"),
        (
            HINGE + '[[coupling]]\njoint = "hinge"\nof = "lid"\nratio = 1\n',
            "'lid', which is no joint that moves",
        ),
    ],
)
def test_joints_that_cannot_be_are_told(door: Path, tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "cowl.toml").write_text(text)
    assert says in run("move", str(door), "--mechanism", str(tmp_path / "cowl.toml"), code=2).stderr
