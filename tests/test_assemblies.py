"""Tools of several parts: parts of a mock-up, assemblies of tools, files; results name the tool's part that is met."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import oracle
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import at, box, cube, joined, mockup_of, tool_of

import feeler
from feeler.io import write_glb


@pytest.fixture(scope="module")
def mockup() -> feeler.Mockup:
    """A block between two walls, which it touches, and a lid above."""
    return mockup_of(
        {
            "case/left": box((-2, -1, 0), (-1, 1, 2)),
            "case/right": box((1, -1, 0), (2, 1, 2)),
            "unit/block": box((-1, -1, 0), (1, 1, 1)),
            "unit/knob": box((-0.25, -0.25, 1), (0.25, 0.25, 1.5)),
            "lid": box((-2, -1, 3), (2, 1, 3.5)),
        }
    )


@pytest.fixture(scope="module")
def scene(mockup: feeler.Mockup) -> feeler.Scene:
    return feeler.Scene(mockup)


# --- parts of a mock-up ----------------------------------------------------------------------------------------------


def test_a_tool_of_parts_is_where_they_are(mockup: feeler.Mockup) -> None:
    tool = feeler.Tool.of_parts(mockup, "unit")
    assert (tool.part_names, tool.part_paths) == (("block", "knob"), ("unit/block", "unit/knob"))
    assert tool.name == "2 parts" and tool.triangle_count == 24 and len(tool.vertices) == 16
    chosen = np.isin(mockup.part_of_face, [2, 3])
    np.testing.assert_array_equal(tool.vertices[tool.faces], mockup.vertices[mockup.faces[chosen]])
    assert tool.part_of_face.tolist() == [0] * 12 + [1] * 12
    assert [part.upper for part in tool.parts] == [(1, 1, 1), (0.25, 0.25, 1.5)]
    assert [part.triangles for part in tool.parts] == [12, 12]
    assert tool.source is mockup.source and tool.report.parts == 2


def test_how_a_tool_of_parts_is_called(mockup: feeler.Mockup) -> None:
    assert feeler.Tool.of_parts(mockup, "lid").name == "lid"
    assert feeler.Tool.of_parts(mockup, 2).name == "block"
    assert feeler.Tool.of_parts(mockup, ["unit/knob", 2], name="pump").name == "pump"
    everything = feeler.Tool.of_parts(mockup)
    assert everything.part_paths == mockup.part_paths and everything.triangle_count == 60
    # The mock-up's order, whatever the caller's.
    assert feeler.Tool.of_parts(mockup, ["lid", "left"]).part_names == ("left", "lid")


def test_what_is_no_tool_of_parts(mockup: feeler.Mockup) -> None:
    for wrong in ("lids", 5, [None], np.ones(4, dtype=bool)):
        with pytest.raises(feeler.OptionError):
            feeler.Tool.of_parts(mockup, wrong)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="no part is named"):
        feeler.Tool.of_parts(mockup, [])
    with pytest.raises(feeler.MeshError, match=r"feeler.Mockup, not of Tool"):
        feeler.Tool.of_parts(feeler.Tool(*cube((0, 0, 0), 1)), 0)  # type: ignore[arg-type]
    vertices, faces = cube((0, 0, 0), 1)
    holey = feeler.Mockup(vertices, [*faces.tolist(), [0, 0, 0]], [0] * 12 + [2], ["a", "empty", "flat"])
    with pytest.raises(feeler.MeshError, match="empty: there are no triangles"):
        feeler.Tool.of_parts(holey, "empty")
    with pytest.raises(feeler.MeshError):
        feeler.Tool.of_parts(holey, "flat")
    assert feeler.Tool.of_parts(holey, ["a", "empty"]).part_triangles.tolist() == [12, 0]


def test_defects_go_along(mockup: feeler.Mockup) -> None:
    vertices, faces = joined(cube((0, 0, 0), 1), cube((3, 0, 0), 1))
    faces = np.concatenate([faces, [[0, 1, 99], [9, 10, 4_000_000_000], [8, 8, 8]]])
    odd = feeler.Mockup(vertices, faces, [0] * 12 + [1] * 12 + [0, 1, 1], ["a", "b"])
    tool = feeler.Tool.of_parts(odd, "b")
    # Vertices of no triangle of it are left out; what pointed nowhere still does.
    assert tool.triangle_count == 14 and len(tool.vertices) == 8
    assert {kind: defect.count for kind, defect in tool.report.defects.items() if defect.count} == {
        "index_out_of_range": 1,
        "zero_area": 1,
    }


def test_a_part_that_moves_meets_what_the_mock_up_without_it_has(scene: feeler.Scene, mockup: feeler.Mockup) -> None:
    """The same as with meshes made by hand, with the numbers of the mock-up's triangles."""
    unit = feeler.Tool.of_parts(mockup, "unit")
    rest = scene.without("unit")
    chosen = np.isin(mockup.part_of_face, [2, 3])
    by_hand = feeler.Tool(mockup.vertices, mockup.faces[chosen])
    kept = np.flatnonzero(~chosen)
    static = feeler.Mockup(mockup.vertices, mockup.faces[~chosen])
    for pose in (at(), at(0.1, 0, 0), at(0, 0, 1.6), at(0, 0, 0.3, 20), at(0, 0, 9)):
        hit = rest.collide(unit, pose)
        expected = oracle.collide(static, by_hand, pose)
        assert {(int(t), int(m)): int(k) for (t, m), k in zip(hit.pairs, hit.kind_codes, strict=True)} == {
            (t, int(kept[m])): kind for (t, m), kind in expected.items()
        }
        assert not np.isin(hit.parts, [2, 3]).any()
    # Seated between the walls, and with the knob in the lid.
    assert rest.collide(unit, at()).parts.tolist() == [0, 1]
    assert rest.collide(unit, at(0, 0, 1.6)).parts.tolist() == [0, 1, 4]


# --- names in results ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def hand() -> feeler.Tool:
    """A palm, a finger 1 m above it and a thumb beside it; the second part has no triangles."""
    vertices, faces = joined(cube((0, 0, 0), 0.5), cube((0, 0, 1), 0.5), cube((1, 0, 0), 0.5))
    names = ["palm", "nothing", "finger", "thumb"]
    return feeler.Tool(vertices, faces, "hand", np.repeat([0, 2, 3], 12), names)


@pytest.fixture(scope="module", params=["blocks", "dense", "hashed"])
def floor(request: pytest.FixtureRequest) -> feeler.Scene:
    """A floor up to z = 0, and a ceiling from z = 4 on."""
    slabs = {"floor": box((-9, -9, -1), (9, 9, 0)), "ceiling": box((-9, -9, 4), (9, 9, 5))}
    return feeler.Scene(mockup_of(slabs), storage=request.param, voxel_size=0.6)


DOWN = at(0, 0, 0.24)
"""Palm and thumb 10 mm deep in the floor."""
UP = at(0, 0, 2.76)
"""The finger 10 mm deep in the ceiling."""


def test_every_result_names_the_tools_part(floor: feeler.Scene, hand: feeler.Tool) -> None:
    assert floor.collide(hand, DOWN).tool_parts.tolist() == [0, 3]
    assert floor.collide(hand, UP).tool_parts.tolist() == [2]
    assert floor.collide(hand, at(0, 0, 2)).tool_parts.tolist() == []
    assert {plane.tool_part for plane in floor.contacts(hand, DOWN)} == {0, 3}
    contacts = floor.contacts(hand, UP)
    assert contacts.tool_parts.tolist() == [2] and contacts.parts.tolist() == [1]
    assert contacts[0].tool_part == 2 and contacts.gaps[0] == pytest.approx(-0.01, abs=1e-12)

    near = at(0, 0, 0.26)
    room = floor.clearance(hand, near, within=9)
    assert (room.parts.tolist(), room.tool_parts.tolist()) == ([0, 1], [room.tool_parts[0], 2])
    assert room.tool_parts[0] in (0, 3)
    for rows in (room, floor.clearance(hand, near, within=9, triangles=True)):
        assert rows.tool_parts.tolist() == hand.part_of_face[rows.tool_triangles].tolist()
    distance = floor.distance(hand, at(0, 0, 2.74))
    assert (distance.part, distance.tool_part) == (1, 2)
    assert floor.distance(hand, at(0, 0, 2.74), within=0.001).tool_part is None
    assert [each.tool_part for each in floor.nearest(hand, at(0, 0, 2.74), 2)][:1] == [2]

    cast = floor.cast(hand, at(0, 0, 2), at(0, 0, 3))
    assert cast is not None and (cast.part, cast.tool_part) == (1, 2)
    check = floor.check_path(hand, [at(0, 0, 2), at(0, 0, 3), at(0, 0, 2)])
    assert check.tool_parts.tolist() == [2, 2] and check.first is not None and check.first.tool_part == 2


def test_batches_name_the_tools_part(floor: feeler.Scene, hand: feeler.Tool) -> None:
    poses = [UP, at(0, 0, 2.74), at(0, 0, 2), DOWN]
    values = floor.distance_batch(hand, poses, within=0.1)
    assert values.tool_parts.tolist() == [2, 2, -1, values.tool_parts[3]] and values.tool_parts[3] in (0, 3)
    assert values[1].tool_part == 2 and values[2].tool_part is None
    rows = floor.clearance_batch(hand, poses, within=0.1, triangles=True)
    assert rows.tool_parts.tolist() == hand.part_of_face[rows.tool_triangles].tolist()
    assert set(rows[3].tool_parts.tolist()) == {0, 3} and set(rows[0].tool_parts.tolist()) == {2}


@given(
    x=st.floats(-1, 1),
    z=st.sampled_from([0.25, 2.75]) | st.floats(0, 3),
    degrees=st.sampled_from([0.0, 90.0]) | st.floats(0, 360),
    axis=st.integers(0, 2),
)
def test_tool_parts_are_those_of_the_triangles(
    floor: feeler.Scene, hand: feeler.Tool, x: float, z: float, degrees: float, axis: int
) -> None:
    pose = at(x, 0, z, degrees, axis)
    hit = floor.collide(hand, pose)
    assert hit.tool_parts.tolist() == np.unique(hand.part_of_face[hit.pairs[:, 0]]).tolist()
    contacts = floor.contacts(hand, pose)
    for i, plane in enumerate(contacts):
        assert plane.tool_part == contacts.tool_parts[i]
        # A body may go on over the parts of a tool; a plane names one of them.
        assert plane.tool_part in hand.part_of_face[plane.tool_triangles]
    distance = floor.distance(hand, pose)
    assert distance.tool_part == hand.part_of_face[distance.tool_triangle]


def test_results_with_tool_parts_travel(floor: feeler.Scene, hand: feeler.Tool) -> None:
    poses = [at(0, 0, 2), at(0, 0, 3)]
    results: list[tuple[Any, str]] = [
        (floor.collide(hand, DOWN), "tool_parts"),
        (floor.contacts(hand, DOWN), "tool_parts"),
        (floor.contacts(hand, DOWN)[0], "tool_part"),
        (floor.clearance(hand, DOWN), "tool_parts"),
        (floor.clearance_batch(hand, poses), "tool_parts"),
        (floor.distance(hand, UP), "tool_part"),
        (floor.distance_batch(hand, poses), "tool_parts"),
        (floor.cast(hand, *poses), "tool_part"),
        (floor.check_path(hand, poses), "tool_parts"),
        (floor.containment(hand, at(0, 0, -0.5)), "containing_pairs"),
        (hand, "part_paths"),
    ]
    for result, name in results:
        for there in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
            assert np.asarray(getattr(there, name)).tolist() == np.asarray(getattr(result, name)).tolist()
    assert results[9][0], "there is something inside that travels"
    assert feeler.Scene(floor.mockup).collide(pickle.loads(pickle.dumps(hand)), UP).tool_parts.tolist() == [2]


# --- tools with parts ------------------------------------------------------------------------------------------------


def test_a_tool_has_one_part_unless_it_is_told() -> None:
    tool = feeler.Tool(*cube((0, 0, 0), 1), "wrench")
    assert (tool.part_names, tool.part_paths, tool.part_count) == (("wrench",), ("wrench",), 1)
    assert tool.part_of_face.tolist() == [0] * 12
    assert tool.parts[0] == tool.parts.find("wrench")[0]
    assert tool.parts[0].lower == (-0.5, -0.5, -0.5) and tool.parts[0].triangles == 12
    two = feeler.Tool(*joined(cube((0, 0, 0), 1), cube((2, 0, 0), 1)), "pair", np.repeat([0, 1], 12))
    assert two.part_names == ("part_0", "part_1")
    for wrong, words in (
        ({"part_of_face": [0] * 11}, "11 entries"),
        ({"part_of_face": [0] * 11 + [-1]}, "from -1"),
        ({"part_of_face": [0] * 11 + [1], "part_names": ["a"]}, "part"),
        ({"part_names": []}, "part_names is empty"),
        ({"part_names": "ab"}, "sequence of strings"),
        ({"part_names": ["a"], "part_paths": ["a", "b"]}, "2 entries"),
    ):
        with pytest.raises(feeler.MeshError, match=words):
            feeler.Tool(*cube((0, 0, 0), 1), **wrong)


def test_a_mock_up_is_a_tool(mockup: feeler.Mockup) -> None:
    tool = feeler.Tool(mockup)
    assert tool.part_paths == mockup.part_paths
    np.testing.assert_array_equal(tool.faces, mockup.faces)
    np.testing.assert_array_equal(tool.part_of_face, mockup.part_of_face)


def test_a_file_with_several_parts_is_a_tool_of_them(tmp_path: Path, mockup: feeler.Mockup) -> None:
    write_glb(tmp_path / "unit.glb", mockup)
    tool = feeler.load_tool(tmp_path / "unit.glb")
    world = feeler.load_mockup(tmp_path / "unit.glb")
    assert tool.part_names == mockup.part_names == ("left", "right", "block", "knob", "lid")
    assert tool.part_paths == world.part_paths and tool.part_paths[2].endswith("unit/block")
    np.testing.assert_array_equal(tool.part_of_face, world.part_of_face)
    assert tool.name == "unit"
    (tmp_path / "two.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no a\nf 1 2 3\no b\nf 1 2 4\n")
    assert feeler.load_tool(tmp_path / "two.obj", "m").part_names == ("a", "b")


# --- assemblies ------------------------------------------------------------------------------------------------------


def test_an_assembly_is_its_items_in_their_places() -> None:
    hand = tool_of({"palm": cube((0, 0, 0), 1), "digits/thumb": cube((1, 0, 0), 0.5)}, "hand")
    wrench = feeler.Tool(*cube((0, 0, 0), 0.25), "17 mm")
    place = at(0, 0, 2, 90)
    both = feeler.Tool.assembly({"hand": hand, "wrench": (wrench, place)}, name="reach")
    assert both.name == "reach" and both.part_count == 3
    assert both.part_names == ("palm", "thumb", "wrench")
    assert both.part_paths == ("hand/palm", "hand/digits/thumb", "wrench")
    assert both.part_of_face.tolist() == [0] * 12 + [1] * 12 + [2] * 12
    np.testing.assert_array_equal(both.vertices[both.faces][:24], hand.vertices[hand.faces])
    np.testing.assert_array_equal(both.vertices[both.faces][24:], oracle.at_pose(wrench.vertices[wrench.faces], place))
    assert both.parts.select("hand").tolist() == [0, 1] and both.parts.select("*/thumb").tolist() == [1]
    # An assembly of an assembly.
    more = feeler.Tool.assembly({"a": (both, at(0, 0, 1)), "b": both})
    assert more.part_paths[:3] == ("a/hand/palm", "a/hand/digits/thumb", "a/wrench") and more.name == "assembly"
    assert [part.lower[2] for part in more.parts][2::3] == [2.875, 1.875]


@given(xyz=st.tuples(*[st.floats(-2, 2)] * 3), degrees=st.floats(0, 360), axis=st.integers(0, 2), lift=st.floats(0, 1))
def test_an_assembly_meets_what_its_items_meet(
    scene: feeler.Scene, xyz: tuple[float, float, float], degrees: float, axis: int, lift: float
) -> None:
    """At the identity corners are where the items' are at their places, to the last bit, and so are the pairs."""
    item = feeler.Tool(*box((0, 0, 0), (2, 0.5, 0.25)))
    places = [at(*xyz, degrees, axis), at(0.25, 0, lift)]
    both = feeler.Tool.assembly({"a": (item, places[0]), "b": (item, places[1])})
    expected = [[t + 12 * i, m] for i, place in enumerate(places) for t, m in scene.collide(item, place).pairs.tolist()]
    hit = scene.collide(both, at())
    assert hit.pairs.tolist() == expected
    assert hit.tool_parts.tolist() == sorted({t // 12 for t, _ in expected})


def test_defects_of_items_stay_defects() -> None:
    vertices, faces = cube((0, 0, 0), 1)
    bad = feeler.Tool(vertices, np.array([*faces.tolist(), [0, 1, 8]], dtype=np.uint32))
    both = feeler.Tool.assembly({"a": bad, "b": bad})
    # 8 is beyond the first's vertices, and would be the first vertex of the second.
    assert both.report.defects["index_out_of_range"].count == 2
    assert both.report.defects["index_out_of_range"].first == (12, 25)


def test_what_is_no_assembly() -> None:
    tool = feeler.Tool(*cube((0, 0, 0), 1))
    for wrong in ({}, [tool], tool, None):
        with pytest.raises(feeler.MeshError, match="dict of tools"):
            feeler.Tool.assembly(wrong)  # type: ignore[arg-type]
    for wrong in ("tool", None, (tool,), (tool, np.eye(4), 1), feeler.Mockup(*cube((0, 0, 0), 1))):
        with pytest.raises(feeler.MeshError, match="assembly item 'a'"):
            feeler.Tool.assembly({"a": wrong})  # type: ignore[dict-item]
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    for place in (2 * np.eye(4), mirror, np.eye(3), np.full((4, 4), np.nan), np.stack([np.eye(4)] * 2), "place"):
        with pytest.raises(feeler.PoseError):
            feeler.Tool.assembly({"a": tool, "wrench": (tool, place)})
    with pytest.raises(feeler.PoseError, match="'wrench'"):
        feeler.Tool.assembly({"a": tool, "wrench": (tool, mirror)})
