"""Pairs of parts that queries leave out: each query, every way to name them, and what is refused."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import oracle
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import at, box, cube, mockup_of, tool_of

import feeler
from feeler import ignored

# Each query, and whether its answer says that the tool meets or nears anything.
QUERIES: dict[str, Callable[[feeler.Scene, feeler.Tool, Any], bool]] = {
    "collide": lambda s, t, ignore: bool(s.collide(t, at(), ignore=ignore)),
    "is_colliding": lambda s, t, ignore: s.is_colliding(t, at(), ignore=ignore),
    "is_colliding free": lambda s, t, ignore: s.is_colliding(t, at(), touching="free", ignore=ignore),
    "is_free": lambda s, t, ignore: not s.is_free(t, at(), ignore=ignore),
    "containment": lambda s, t, ignore: bool(s.containment(t, at(), ignore=ignore)),
    "collide_batch": lambda s, t, ignore: len(s.collide_batch(t, [at()], ignore=ignore).pairs) > 0,
    "clearance": lambda s, t, ignore: len(s.clearance(t, at(), 9, ignore=ignore)) > 0,
    "clearance triangles": lambda s, t, ignore: len(s.clearance(t, at(), 9, True, ignore=ignore)) > 0,
    "clearance_batch": lambda s, t, ignore: len(s.clearance_batch(t, [at()], 9, ignore=ignore).parts) > 0,
    "distance": lambda s, t, ignore: math.isfinite(s.distance(t, at(), ignore=ignore).value),
    "distances": lambda s, t, ignore: len(s.nearest(t, at(), 2, ignore=ignore)) > 0,
    "distance_batch": lambda s, t, ignore: bool(np.isfinite(s.distance_batch(t, [at()], ignore=ignore).values).any()),
    "cast": lambda s, t, ignore: s.cast(t, at(), at(0, 0, 1), ignore=ignore) is not None,
    "cast free": lambda s, t, ignore: s.cast(t, at(), at(0, 0, 1), touching="free", ignore=ignore) is not None,
    "check_path": lambda s, t, ignore: not s.check_path(t, [at(), at(0, 0, 1)], inside=False, ignore=ignore).is_free,
    "check_path inside": lambda s, t, ignore: bool(s.check_path(t, [at()], ignore=ignore).containment),
    "contacts": lambda s, t, ignore: len(s.contacts(t, at(), 9.0, ignore=ignore)) > 0,
    "penetration": lambda s, t, ignore: s.penetration(t, at(), ignore=ignore).depth > 0,
}


@pytest.fixture(scope="module", params=["blocks", "dense", "hashed"])
def scene(request: pytest.FixtureRequest) -> feeler.Scene:
    """A bed that the hand is in, a shell around all, a gasket beside."""
    parts = {"bed": cube((0, 0, -0.5), 1), "seals/gasket": box((0.2, -1, -1), (0.4, 1, 1)), "shell": cube((0, 0, 0), 8)}
    return feeler.Scene(mockup_of(parts), storage=request.param, voxel_size=0.5)


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    return tool_of({"hand": cube((0, 0, 0), 0.5), "arm": box((-0.1, -0.1, 0.2), (0.1, 0.1, 1))}, "robot")


@pytest.mark.parametrize("query", QUERIES)
def test_every_query_leaves_ignored_pairs_out(scene: feeler.Scene, tool: feeler.Tool, query: str) -> None:
    ask = QUERIES[query]
    assert ask(scene, tool, None) and ask(scene, tool, [])
    assert not ask(scene, tool, [("*", "*")])
    # Pair by pair: all of them together are all there is, and the scene itself stays as it was.
    every = [(i, j) for i in range(2) for j in range(3)]
    assert not ask(scene, tool, every)
    assert not ask(scene, tool, np.array(every))
    assert not ask(scene, tool, feeler.IgnoredPairs(tool, scene.mockup, every))
    assert ask(scene, tool, None)
    # Parts that are out and pairs that are ignored add up.
    assert not ask(scene.without("shell"), tool, [("*", ["bed", "gasket"])])


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize(
    ("ignore", "words"),
    [
        ("hand", r"ignore is 'hand': give pairs"),
        (5, "ignore is 5: give pairs"),
        ([5], "ignore holds 5: give pairs"),
        (["ab"], "ignore holds 'ab'"),
        ([("hand",)], r"ignore holds \('hand',\)"),
        ([("hand", "bed", "shell")], "ignore holds"),
        ({"hand": "bed"}, "ignore holds 'hand'"),
        ([("hand", "bad")], "ignore, of the mock-up: no part has the path or name 'bad'; do you mean 'bed'?"),
        ([("hnad", "bed")], "ignore, of the tool: no part has the path or name 'hnad'; do you mean 'hand'?"),
        ([("bed", "hand")], "ignore, of the tool: .*'bed'"),
        ([(2, 0)], "ignore, of the tool: there is no part 2"),
        ([(0, 3)], "ignore, of the mock-up: there is no part 3"),
        ([("hand", None)], "ignore, of the mock-up: None names no part"),
        (np.array([[0, 3]]), "the mock-up has no part 3"),
        (np.array([[-1, 0]]), "the tool has no part -1"),
        (np.array([0, 1]), r"shape \(2,\)"),
        (np.array([[0.0, 1.0]]), "dtype float64"),
        (np.array([[True, False]]), "dtype bool"),
    ],
    ids=str,
)
def test_wrong_pairs_are_refused(scene: feeler.Scene, tool: feeler.Tool, query: str, ignore: Any, words: str) -> None:
    with pytest.raises(feeler.OptionError, match=words):
        QUERIES[query](scene, tool, ignore)


def test_what_is_named_is_ignored(scene: feeler.Scene, tool: feeler.Tool) -> None:
    def met(ignore: Any) -> list[list[int]]:
        pairs = scene.collide(tool, at(), ignore=ignore).pairs
        parts = np.column_stack([tool.part_of_face[pairs[:, 0]], scene.mockup.part_of_face[pairs[:, 1]]])
        return np.unique(parts, axis=0).tolist()

    assert met(None) == [[0, 0], [0, 1]]
    assert met([("hand", "bed")]) == met([(0, 0)]) == met([["hand", scene.mockup.parts[0]]]) == [[0, 1]]
    assert met([("hand", "*gasket*")]) == met([("*", "seals")]) == met(np.array([[0, 1]], np.uint8)) == [[0, 0]]
    assert met([("arm", "*")]) == met([(tool.parts[1], range(3))]) == [[0, 0], [0, 1]]
    assert met([("hand", ["bed", "shell"]), ("hand", 1)]) == []
    assert met(pair for pair in [("hand", "seals/gasket")]) == [[0, 0]]
    assert met([(np.array([True, False]), np.array([False, True, True]))]) == [[0, 0]]


POSES = st.builds(at, st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 360), st.integers(0, 2))
PAIRS = st.lists(st.tuples(st.integers(0, 1), st.integers(0, 2)))


@given(pairs=PAIRS, pose=POSES)
def test_ignored_pairs_are_those_of_the_judge(
    scene: feeler.Scene, tool: feeler.Tool, pairs: list[tuple[int, int]], pose: np.ndarray
) -> None:
    parts = {
        (t, m): (int(tool.part_of_face[t]), int(scene.mockup.part_of_face[m]))
        for t, m in oracle.collide(scene.mockup, tool, pose)
    }
    expected = sorted(pair for pair, of in parts.items() if of not in pairs)
    assert [tuple(pair) for pair in scene.collide(tool, pose, ignore=pairs).pairs.tolist()] == expected
    assert scene.is_colliding(tool, pose, ignore=pairs) == bool(expected)
    # One part of the tool at a time, with what is left of the mock-up for it, is another way to the same.
    least = math.inf
    for i in range(2):
        alone = feeler.Tool(tool.vertices, tool.faces[tool.part_of_face == i])
        left = scene.without([m for t, m in pairs if t == i])
        least = min(least, left.distance(alone, pose).value)
    assert scene.distance(tool, pose, ignore=pairs).value == pytest.approx(least, abs=1e-12)


def test_pairs_made_once(scene: feeler.Scene, tool: feeler.Tool) -> None:
    pairs = feeler.IgnoredPairs(tool, scene.mockup, [("hand", "*"), ("hand", "bed"), (1, 2)])
    assert pairs.pairs.tolist() == [[0, 0], [0, 1], [0, 2], [1, 2]] and len(pairs) == 4
    assert pairs.pairs.dtype == np.uint32 and not pairs.pairs.flags.writeable
    assert repr(pairs) == "IgnoredPairs(4 pairs)"
    for there in (pickle.loads(pickle.dumps(pairs)), copy.deepcopy(pairs), copy.copy(pairs)):
        assert there.pairs.tolist() == pairs.pairs.tolist() and not there.pairs.flags.writeable
        assert not scene.collide(tool, at(), ignore=there) and scene.collide(tool, at())
    assert len(feeler.IgnoredPairs(tool, scene.mockup, [])) == 0
    # It fits each tool and mock-up with so many parts, and no other.
    other = feeler.Tool(*cube((0, 0, 0), 0.5))
    with pytest.raises(feeler.OptionError, match=r"2 parts and a mock-up with 3.* make it for this tool"):
        scene.collide(other, at(), ignore=pairs)
    for wrong in ((scene.mockup, tool), (tool, scene), (tool, None)):
        with pytest.raises(feeler.MeshError, match=r"feeler\.Tool and a feeler\.Mockup"):
            feeler.IgnoredPairs(*wrong, [])  # type: ignore[arg-type]


def test_pairs_beyond_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = {f"p{i}": cube((i, 0, 0), 0.5) for i in range(20)}
    tool, mockup = tool_of(parts), mockup_of(parts)
    assert len(feeler.IgnoredPairs(tool, mockup, [("*", "*"), ("p1*", "*")])) == 400
    monkeypatch.setattr(ignored, "MOST_PAIRS", 399)
    with pytest.raises(feeler.OptionError, match="ignore names 400 pairs of parts, and 399 are the most"):
        feeler.IgnoredPairs(tool, mockup, [("*", "*")])


def test_a_wrong_tool_is_told_first(scene: feeler.Scene) -> None:
    for query in QUERIES.values():
        with pytest.raises(feeler.MeshError):
            query(scene, "tool", [("a", "b")])  # type: ignore[arg-type]


def test_a_tracker_ignores_what_it_is_told() -> None:
    block = cube((0, 0, 0), 1)
    mock, tool = mockup_of({"floor": block}), tool_of({"probe": block, "rest": block})
    scene = feeler.Scene(mock)
    assert feeler.ContactTracker(scene, tool).contacts(at(0, 0, 0.75)).is_meeting
    tracker = feeler.ContactTracker(scene, tool, ignore=[("probe", "*"), ("rest", "floor")])
    for each in (tracker, pickle.loads(pickle.dumps(tracker))):
        assert not each.contacts(at(0, 0, 0.75))
    with pytest.raises(feeler.OptionError, match="wrench"):
        feeler.ContactTracker(scene, tool, ignore=[("wrench", "*")])
