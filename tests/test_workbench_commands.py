"""Commands: each checks its arguments, changes what it says, and is undone and redone without a trace."""

from __future__ import annotations

import base64
import copy
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from workbench_scene import LEFT, PATHS, PEG, PLATE, RIGHT, SHEET, Bench, at, cube, stand

import feeler
from feeler.errors import FeelerError, WorkbenchError
from feeler.workbench.document.arguments import Arguments, Maybe, Shape
from feeler.workbench.document.commands import COMMANDS
from feeler.workbench.document.document import JSON_FIELDS, Document
from feeler.workbench.document.findings import findings_of
from feeler.workbench.document.frames import check
from feeler.workbench.document.protocol import Camera, DocumentFields, Patch, Vec3, decode_from_server, encode

ROOT = Path(__file__).parent.parent


@pytest.fixture
def bench() -> Bench:
    return Bench(cube(), pose=at(0, 0, 0.2))


def test_hide_show_and_patterns(bench: Bench) -> None:
    bench.command("hide", parts="stand/posts")
    assert bench.document["hidden"] == [LEFT, RIGHT]
    bench.command("hide", parts=["*peg", SHEET])
    assert bench.document["hidden"] == [LEFT, RIGHT, PEG, SHEET]
    bench.command("show", parts=LEFT)
    assert bench.document["hidden"] == [RIGHT, PEG, SHEET]
    bench.command("hide_all")
    assert len(bench.document["hidden"]) == 5
    bench.command("show_all")
    assert bench.document["hidden"] == []


def test_isolate_again_is_the_state_before(bench: Bench) -> None:
    bench.command("hide", parts=[PEG])
    bench.command("isolate", parts="stand/posts")
    assert bench.document["isolated"] and bench.document["hidden"] == [PLATE, PEG, SHEET]
    bench.command("isolate", parts=[PLATE])
    assert bench.document["hidden"] == [LEFT, RIGHT, PEG, SHEET]
    bench.command("isolate", parts=[PLATE])
    assert not bench.document["isolated"] and bench.document["hidden"] == [PEG]


def test_a_section_box_cuts_picks_and_outlines_and_a_viewpoint_keeps_it(bench: Bench) -> None:
    ray = {"origin": [0.0, 0.0, 0.25], "direction": [0.0, 0.0, -1.0]}
    top = bench.session.ask("ray", ray)
    outlines = bench.session.job("outline", {}).result(60)
    lower, upper = [-0.25, -0.25, -0.5], [3.0, 3.0, -0.03125]
    bench.command("section_box", lower=lower, upper=upper)
    assert bench.document["section_box"] == {"lower": lower, "upper": upper, "is_on": True}
    cut = bench.session.ask("ray", ray)
    assert top["point"][2] == 0.0 and cut["point"][2] == -0.03125, "the fill is met where the box begins"
    assert cut["triangle"] == -1 and cut["part"] == PLATE
    assert bench.session.ask("ray", {**ray, "origin": [-0.4, 0.0, 0.25]}) is None, "the plate is cut away there"
    found = bench.session.job("outline", {}).result(60)
    ends = np.frombuffer(base64.b64decode(found["segments"]), dtype="<f4").reshape(-1, 3)
    assert outlines["count"] == 0 and found["count"] > 0
    assert ends.min(axis=0) == pytest.approx([-0.25, -0.25, -0.0625]), "outlines end at the other faces"
    camera = {"position": [1, 1, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov_rad": 0.5}
    number = bench.command("viewpoint_add", camera=camera)["id"]
    bench.command("section_box_switch", is_on=False)
    assert bench.session.ask("ray", ray) == top
    bench.command("section_box_remove")
    bench.command("section_add", normal=[1, 0, 0], offset=0.0)
    bench.command("viewpoint_show", id=number)
    assert bench.document["sections"] == [] and bench.document["section_box"]["upper"] == upper
    bench.command("undo")
    assert len(bench.document["sections"]) == 1 and bench.document["section_box"] is None


def test_hidden_parts_still_collide(bench: Bench) -> None:
    bench.command("hide_all")
    bench.drag(at(0, 0, 0), 1.0)
    assert bench.session.snapshot().parts == [PLATE]


def test_sections_measures_viewpoints_and_units(bench: Bench) -> None:
    number = bench.command("section_add", normal=[0, 0, 2], offset=0.1)["id"]
    assert bench.document["sections"] == [{"id": number, "normal": [0, 0, 1], "offset": 0.1, "is_on": True}]
    bench.command("section_move", id=number, normal=[1, 0, 0], offset=0.2)
    bench.command("section_switch", id=number, is_on=False)
    assert bench.document["sections"] == [{"id": number, "normal": [1, 0, 0], "offset": 0.2, "is_on": False}]
    bench.command("section_remove", id=number)
    number = bench.command("measure_add", type="parts", parts=[LEFT, RIGHT])["id"]
    (measure,) = bench.document["measures"]
    assert measure["value"] == 0.5 and measure["is_exact"] and measure["unit"] == "m"
    a, b = measure["points"]
    assert sorted([a[0], b[0]]) == [-0.25, 0.25] and a[1:] == b[1:]
    bench.command("measure_edit", id=number, name="between the posts")
    assert bench.document["measures"][0] == {**measure, "name": "between the posts"}
    bench.command("measure_edit", id=number, type="edge", points=[[0, 0, 0], [0, 3, 4]])
    assert bench.document["measures"][0]["value"] == 5.0 and not bench.document["measures"][0]["is_exact"]
    bench.command("measure_add", type="angle", points=[[1, 0, 0], [0, 0, 0], [0, 2, 0]])
    assert bench.document["measures"][1]["value"] == pytest.approx(np.pi / 2)
    bench.command("measure_remove", id=number)
    camera = {"position": [1, 1, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov_rad": 0.5, "is_parallel": True}
    number = bench.command("viewpoint_add", name="front", camera=camera)["id"]
    kept = {"id": number, "name": "front", "camera": camera, "sections": [], "section_box": None}
    assert bench.document["viewpoints"] == [kept]
    bench.command("viewpoint_remove", id=number)
    bench.command("set_unit", unit="in")
    bench.command("ghost", parts=[PEG], is_on=True)
    bench.command("explode", share=0.5)
    document = bench.document
    assert (document["unit"], document["ghost"], document["explode"]) == ("in", [PEG], 0.5)


def test_the_measure_of_a_part_that_was_moved_is_where_it_lies(bench: Bench) -> None:
    bench.command("grip", parts=[PEG])
    bench.command("place", pose=at(0, 0, 0.3).ravel().tolist())
    bench.command("place", pose=at(0.05, 0, 0.3).ravel().tolist())
    bench.command("release")
    bench.command("measure_add", type="parts", parts=[PLATE, PEG])
    (measure,) = bench.document["measures"]
    assert measure["value"] == pytest.approx(0.1, abs=1e-9)
    assert {round(point[2], 6) for point in measure["points"]} == {0.0, 0.1}


def test_place_is_where_contact_lets_the_hand_come(bench: Bench) -> None:
    result = bench.command("place", pose=at(0, 0, -0.5).ravel().tolist())
    reached = np.array(result["pose"]).reshape(4, 4)
    assert reached[2, 3] == pytest.approx(0.03125, abs=1e-6)
    np.testing.assert_array_equal(bench.pose, reached)
    assert bench.document["pose"] == result["pose"]
    bench.command("undo")
    np.testing.assert_array_equal(bench.pose, at(0, 0, 0.2))
    bench.command("redo")
    np.testing.assert_array_equal(bench.pose, reached)


def test_a_new_command_ends_what_could_be_redone(bench: Bench) -> None:
    bench.command("hide", parts=[PEG])
    bench.command("undo")
    assert bench.command("hide", parts=[LEFT])["redo_depth"] == 0
    with pytest.raises(WorkbenchError, match="nothing to redo"):
        bench.command("redo")


def test_the_measure_of_two_parts_that_were_moved(bench: Bench) -> None:
    for part, rise in ((LEFT, 0.2), (PEG, 0.01)):
        bench.command("grip", parts=[part])
        bench.command("place", pose=(bench.pose @ at(0, 0, rise)).ravel().tolist())
        bench.command("release")
    bench.command("measure_add", type="parts", parts=[PEG, LEFT])
    (measure,) = bench.document["measures"]
    apart = [0.25 - 0.03125, 0.25 - 0.0625, 0.2 - 0.135]
    assert measure["value"] == pytest.approx(np.linalg.norm(apart), abs=1e-9)
    np.testing.assert_allclose(measure["points"], [[-0.25, 0.0625, 0.2], [-0.03125, 0.25, 0.135]], atol=1e-9)


def test_undo_brings_the_hand_back_to_where_it_was(bench: Bench) -> None:
    bench.wish(at(0.1, 0, 0.2))
    bench.command("grip", parts=[PEG])
    bench.wish(at(0.1, 0, 0.4))
    bench.command("undo")
    np.testing.assert_array_equal(bench.pose, at(0.1, 0, 0.2))
    assert bench.document["gripped"] == []
    # What does not move the hand leaves it where it is.
    bench.wish(at(0.15, 0, 0.2))
    bench.command("hide", parts=[PEG])
    bench.command("undo")
    np.testing.assert_array_equal(bench.pose, at(0.15, 0, 0.2))


def test_take_another_tool(bench: Bench) -> None:
    bench.command("take_tool", name="small")
    assert bench.document["tool"] == {"name": "small", "triangles": 12}
    held = bench.of_type("held")[-1]
    assert held["version"] == bench.document["held_version"] and held["manifest"]["triangles"] == 12
    bench.command("place", pose=at(0, 0, -0.5).ravel().tolist())
    assert bench.pose[2, 3] == pytest.approx(0.03125 / 2, abs=1e-6)
    bench.command("take_tool")
    assert bench.document["tool"] is None and bench.of_type("held")[-1]["manifest"] is None
    bench.command("undo")
    assert bench.document["tool"]["name"] == "small"


def test_the_samples_can_be_taken_and_a_tool_never_begins_in_the_mockup(bench: Bench) -> None:
    assert bench.document["tools"] == ["cube", "small", "torque", "wrench", "square", "hand"]
    bench.command("place", pose=at(0, 0, -0.5).ravel().tolist())
    on_plate = bench.pose
    bench.command("take_tool", name="small")
    np.testing.assert_array_equal(bench.pose, on_plate)
    # The wrench reaches lower than the small cube: here it would be in the plate.
    bench.command("place", pose=at(0, 0, -0.5).ravel().tolist())
    on_plate = bench.pose
    bench.command("take_tool", name="wrench")
    wrench = feeler.sample_tool("wrench")
    assert bench.document["tool"] == {"name": "wrench", "triangles": wrench.triangle_count}
    assert not bench.scene.is_colliding(wrench, bench.pose)
    assert bench.pose[0, 3] + wrench.bounds[0, 0] > 0.5, "beside the sheet"
    bench.command("undo")
    assert bench.document["tool"]["name"] == "small"
    np.testing.assert_array_equal(bench.pose, on_plate)


def test_what_the_mockup_is_made_of(bench: Bench) -> None:
    bench.command("set_material", material="rubber")
    bench.wish(at(0, 0, -0.5))
    assert bench.document["material"] == "rubber" and bench.of_type("impact")[-1]["material"] == "rubber"
    bench.command("set_material")
    assert bench.document["material"] is None
    bench.command("undo")
    assert bench.document["material"] == "rubber"


@pytest.mark.parametrize(
    ("name", "args", "words"),
    [
        ("hidde", {}, "do you mean hide"),
        ("hide", {"parts": "stand/pig"}, "stand/peg"),
        ("hide", {"parts": 7}, "there is no part 7"),
        ("hide", {"parts": []}, "0 parts"),
        ("hide", {"parts": None}, "names no part"),
        ("hide", {"part": [1]}, "do you mean parts"),
        ("hide", [1], "not an object"),
        ("hide", {"parts": [1], "more": 1}, "no argument 'more'"),
        ("explode", {"share": 2}, "from 0 to 1"),
        ("explode", {"share": float("nan")}, "from 0 to 1"),
        ("explode", {"share": True}, "from 0 to 1"),
        ("set_unit", {"unit": "furlong"}, "mm"),
        ("set_mode", {"mode": "stopp"}, "do you mean stop"),
        ("section_add", {"normal": [0, 0, 0], "offset": 0}, "no direction"),
        ("section_add", {"normal": [0, 0], "offset": 0}, "not three numbers"),
        ("section_box", {"lower": [0, 0, 0], "upper": [1, 0, 1]}, "no inside"),
        ("section_box_switch", {"is_on": True}, "no section box"),
        ("section_box_remove", {}, "no section box"),
        ("viewpoint_show", {"id": 99}, "there is no 99"),
        ("section_move", {"id": 99, "normal": [0, 0, 1], "offset": 0}, "there is no 99"),
        ("place", {"pose": [1] * 16}, "not a pose"),
        ("place", {"pose": [0] * 15}, "not a pose"),
        ("place", {"pose": "home"}, "not a pose"),
        ("release", {}, "holds no part"),
        ("put_back", {"parts": [1]}, "where they were loaded"),
        ("take_tool", {"name": "smal"}, "do you mean small"),
        ("measure_add", {"type": "parts", "parts": [1]}, "name two"),
        ("measure_add", {"type": "edge", "points": [[0, 0, 0]]}, "2 points"),
        ("measure_add", {"type": "volume"}, "there is no 'volume'"),
        ("viewpoint_add", {"name": "a", "camera": {"position": [0, 0, 0]}}, "target"),
        ("finding_status", {"id": "1", "status": "new"}, "no findings"),
        ("sequence_move", {"id": 1, "index": 0}, "none at all"),
        ("set_material", {"material": "stel"}, "do you mean steel"),
        ("undo", {}, "nothing to undo"),
        ("undo", {"steps": 3}, "no argument"),
    ],
)
def test_a_wrong_command_says_what_where_and_what_to_do(bench: Bench, name: str, args: Any, words: str) -> None:
    before = bench.session.current
    with pytest.raises(WorkbenchError) as caught:
        bench.session.command(name, args)
    error = caught.value
    assert words in str(error) and error.what and error.where and error.do
    assert bench.session.current is before, "nothing has changed"
    again = pickle.loads(pickle.dumps(error))
    assert (again.what, again.where, again.do) == (error.what, error.where, error.do)


@pytest.mark.parametrize(
    ("shape", "read"),
    [
        ({"parts": int}, lambda given: given.flag("parts")),
        ({"parts": Maybe(str)}, lambda given: given.whole("parts")),
        ({"parts": Vec3 | None}, lambda given: given.points("parts", 1, 2)),
        ({"parts": Literal["mm", "cm"]}, lambda given: given.choice("parts", ("mm", "m"))),
        ({"parts": Literal["mm", "cm"]}, lambda given: given.text("parts")),
        ({"parts": Camera}, lambda given: given.raw("parts", Any)),
    ],
)
def test_a_command_reads_what_the_page_is_told_that_it_takes(shape: Shape, read: Callable[[Arguments], object]) -> None:
    with pytest.raises(TypeError, match=r"x reads parts as .*, and the table says"):
        read(Arguments("x", {"parts": None}, shape))


OFFLINE = json.loads((ROOT / "testdata" / "workbench" / "offline_commands.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", OFFLINE, ids=lambda case: case["name"])
def test_commands_do_the_same_as_in_a_page_without_a_server(case: dict[str, Any]) -> None:
    bench = Bench(cube(), pose=at(0, 0, 0.2), absent=case.get("absent"))
    for name, args in case["commands"]:
        bench.command(name, **args)
    assert {name: bench.document[name] for name in case["fields"]} == case["fields"]


PARTS = st.one_of(st.integers(0, 4), st.sampled_from(PATHS), st.lists(st.integers(0, 4), min_size=1, max_size=5))
POSES = st.tuples(*[st.floats(-0.6, 0.6)] * 3, st.floats(0, 3)).map(lambda each: at(*each).ravel().tolist())
GIVEN = {"clashes": [{"id": "1", "a": PATHS[0], "b": PATHS[1], "depth": 0.01}]}
VERSION = findings_of(GIVEN, stand().parts).table.key
MECHANISM = """
[[joint]]
name = "cube"
kind = "prismatic"
child = "stand/peg"
axis = [0, 0, 1]
point_m = [0, 0, 0]

[[joint]]
name = "small"
kind = "prismatic"
child = "sheet"
axis = [1, 0, 0]
limits_m = [-0.1, 0.2]
"""
ARGUMENTS: dict[str, st.SearchStrategy[Any]] = {
    "parts": PARTS,
    "is_on": st.booleans(),
    "catalogue": st.booleans(),
    "is_added": st.booleans(),
    "is_start": st.booleans(),
    "line": st.integers(1, 6),
    "share": st.floats(0, 1),
    "normal": st.tuples(*[st.floats(-1, 1)] * 3).map(list),
    "offset": st.floats(-1, 1),
    "lower": st.tuples(*[st.floats(-1, -0.1)] * 3).map(list),
    "upper": st.tuples(*[st.floats(0, 1)] * 3).map(list),
    "id": st.integers(1, 6),
    "index": st.integers(0, 2),
    "unit": st.sampled_from(["mm", "cm", "m", "in"]),
    "mode": st.sampled_from(["stop", "pass"]),
    "pose": POSES,
    "name": st.sampled_from(["cube", "small", "a name"]),
    "type": st.sampled_from(["parts", "point"]),
    "points": st.lists(st.tuples(*[st.floats(-1, 1)] * 3).map(list), min_size=2, max_size=2),
    "triangles": st.none(),
    "camera": st.just({"position": [1, 1, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov_rad": 0.5}),
    "status": st.sampled_from(["new", "resolved"]),
    "is_touching_hidden": st.booleans(),
    "material": st.sampled_from(["steel", "rubber", None]),
    "steps": st.none(),
    "ways": st.tuples(st.integers(0, 4), POSES).map(
        lambda way: [{"parts": [way[0]], "poses": [np.eye(4).ravel().tolist(), way[1]], "clearance": None}]
    ),
    "key": st.just("none"),
    "saved": st.none(),
    "version": st.sampled_from([VERSION, "another"]),
    "rows": st.sampled_from([[], [0], [1]]),
    "note": st.sampled_from([None, "", "by design"]),
    "group": st.sampled_from([None, 0, 1, 2]),
    "a": st.sampled_from(["*plate", "*"]),
    "b": st.just("*"),
    "clearance": st.floats(0, 1),
    "gap": st.floats(0, 1),
    "results": st.sampled_from([[], [{"id": 1}], "none"]),
    "contact": st.sampled_from([0.0, 0.001, "chord"]),
    "rules": st.sampled_from(["", '[[exclude]]\nname = "one"\na = "*peg"\n', "not toml"]),
    "findings": st.just(GIVEN),
    "text": st.sampled_from([MECHANISM, MECHANISM.replace("prismatic", "revolute"), "not toml", "[[joint]]"]),
    "value": st.floats(-0.3, 0.3),
    "edit": st.sampled_from(["off", "on", "time", "before", "free", "never"]),
    "seconds": st.floats(-1.0, 100.0),
    "later": st.integers(0, 5),
    "toml": st.sampled_from(["", "[elements]\nget = 1.0\n", "not toml"]),
}
# Undo leaves cards as they are.
STEPS = st.sampled_from(sorted(name for name, command in COMMANDS.items() if not command.is_of_cards)).flatmap(
    lambda name: st.tuples(st.just(name), st.fixed_dictionaries({a: ARGUMENTS[a] for a in COMMANDS[name].arguments}))
)


def answers(bench: Bench) -> tuple[Any, ...]:
    """What the engine says of the hand where it is."""
    bench.tick(1.0)
    snapshot = bench.session.snapshot()
    near = snapshot.distance
    return (
        snapshot.pose.tolist(),
        snapshot.mode,
        snapshot.hits.pairs.tolist(),
        snapshot.planes.gaps.tolist(),
        None if near is None else (near.value, near.part),
        snapshot.rows.distances.tolist(),
        bench.document["held_version"],
    )


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(steps=st.lists(st.one_of(STEPS, st.just(("undo", {})), st.just(("redo", {}))), max_size=25))
def test_undo_of_everything_is_the_document_and_the_answers_before(steps: list[tuple[str, Any]]) -> None:
    bench = Bench(cube(), pose=at(0, 0, 0.2))
    first, before = bench.session.current, answers(bench)
    for name, args in steps:
        try:
            bench.session.command(name, args)
        except FeelerError:
            continue
    last, after, depth = bench.session.current, answers(bench), 0
    while True:
        try:
            bench.command("undo")
        except WorkbenchError:
            break
        depth += 1
    assert bench.session.current == first and bench.session.current.to_json() == first.to_json()
    assert answers(bench) == before
    for _ in range(depth):
        bench.command("redo")
    assert bench.session.current == last and answers(bench) == after


def test_patches_and_document_are_messages_of_the_protocol(bench: Bench) -> None:
    shown: dict[str, Any] = bench.document
    bench.events.clear()
    bench.command("grip", parts=[PEG])
    bench.wish(at(0, 0, 0.4))
    bench.command("release")
    bench.command("measure_add", type="parts", parts=[LEFT, RIGHT])
    bench.command("undo")
    for event in bench.of_type("patch"):
        message = Patch(**{key: value for key, value in event.items() if key != "type"})
        assert encode(decode_from_server(encode(message))) == encode(message)
        shown |= event["fields"]
    assert shown == bench.document, "patches alone lead to the same document"
    assert check(json.loads(json.dumps(shown)), DocumentFields, "document")
    assert set(bench.document) == set(JSON_FIELDS) == set(Document().to_json())
    state = bench.session.snapshot().message()
    assert decode_from_server(encode(state)).seq == state.seq


def test_a_document_shares_what_did_not_change(bench: Bench) -> None:
    bench.command("hide", parts=[PEG])
    before = bench.session.current
    bench.command("set_unit", unit="m")
    assert bench.session.current.hidden is before.hidden and bench.session.current.gripped is before.gripped


def test_a_view_is_neither_pickled_nor_copied() -> None:
    with feeler.view(stand(), browser=False) as view:
        for make in (pickle.dumps, copy.copy):
            with pytest.raises(TypeError, match="a View cannot be pickled or copied"):
                make(view)
