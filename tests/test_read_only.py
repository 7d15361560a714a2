"""Arrays of answers are read-only, as what is written into those made at each access would be lost. Reprs are short."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from shapes import box

import feeler
from feeler.short_reprs import short

BLOCK = feeler.Mockup(np.concatenate([box((0, 0, 0), (1, 1, 1))[0], box((0.9, 0, 0), (2, 1, 1))[0]]),
                      np.concatenate([box((0, 0, 0), (1, 1, 1))[1], np.asarray(box((0, 0, 0), (1, 1, 1))[1]) + 8]),
                      np.repeat([0, 1], 12), ["a", "b"])  # fmt: skip
RESULTS = (feeler.Removal, feeler.RemovalStep, feeler.Fastener, feeler.Clash, feeler.Reach, feeler.LoadReport)
TOOL = feeler.Tool(*box((0, 0, 0), (0.2, 0.2, 0.2)))


def moved(z: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    pose = np.eye(4)
    pose[2, 3] = z
    return pose


def answers() -> Iterator[object]:
    """An answer of each query, the rows of those that have some, and the objects that are asked."""
    scene = feeler.Scene(BLOCK)
    near, far = moved(0.95), moved(3.0)
    tracker = feeler.ContactTracker(scene, TOOL)
    tracker.contacts(far)
    yield from (BLOCK, TOOL, scene, scene.without("a"), tracker)
    tables: list[Any] = [
        scene.collide_batch(TOOL, [near, far]),
        scene.distance_batch(TOOL, [near, far]),
        scene.clearance(TOOL, moved(1.01), within=0.1),
        scene.clearance_batch(TOOL, [moved(1.01)], within=0.1),
        scene.check_path(TOOL, [far, near]),
        scene.contacts(TOOL, near),
        scene.rays([[0.5, 0.5, 9.0]], [[0, 0, -1.0]]),
        scene.depth(TOOL, near),
        feeler.clash(BLOCK),
        feeler.find_fasteners(BLOCK),
        feeler.access(scene, TOOL, far[None], angles=4),
        feeler.sight(scene, "b", [[9.0, 9.0, 9.0]]),
    ]
    yield from tables
    yield from (row for table in tables for row in table)
    yield from (
        scene.collide(TOOL, near),
        scene.distance(TOOL, far),
        scene.cast(TOOL, far, near),
        scene.clearance_along(TOOL, far, moved(2.0)),
        scene.penetration(TOOL, near),
        scene.containment(TOOL, moved(0.5)),
        scene.section([0.5, 0.5, 0.5], [0.0, 0.0, 1.0]),
        feeler.removal(scene, "a"),
        feeler.removal_order(scene, "a"),
        BLOCK.pack(),
    )
    yield from BLOCK.pack().pieces


def test_what_is_made_anew_cannot_be_written_into() -> None:
    found, writable = 0, set()
    for answer in answers():
        for name in dir(answer):
            if name.startswith("_"):
                continue
            first = getattr(answer, name)
            if isinstance(first, np.ndarray) and first is not getattr(answer, name):
                found += 1
                if first.flags.writeable:
                    writable.add(f"{type(answer).__name__}.{name}")
    assert found > 60 and writable == set()


def test_writing_into_a_scene_or_an_impact_raises() -> None:
    scene = feeler.Scene(BLOCK)
    with pytest.raises(ValueError, match="read-only"):
        scene.part_mask[0] = False
    hit = scene.cast(TOOL, moved(3.0), moved(0.95))
    assert hit is not None
    with pytest.raises(ValueError, match="read-only"):
        hit.pose[0, 0] = 2.0
    assert scene.part_mask.all() and hit.pose[0, 0] == 1.0


def arrays_of(answer: Any, depth: int = 3) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """The arrays of an answer and of what its fields and rows hold, by name."""
    for name in dir(answer):
        if name.startswith("_") or not isinstance(value := getattr(answer, name), (np.ndarray, tuple, *RESULTS)):
            continue
        if isinstance(value, np.ndarray):
            yield f"{type(answer).__name__}.{name}", value
        elif depth:
            for each in value if isinstance(value, tuple) else (value,):
                if isinstance(each, RESULTS):
                    yield from arrays_of(each, depth - 1)


def test_copies_and_pickles_are_as_read_only() -> None:
    found, writable = set(), set()
    for answer in answers():
        if isinstance(answer, (feeler.ContactTracker, np.ndarray)):
            continue
        for copied in (pickle.loads(pickle.dumps(answer)), copy.copy(answer), copy.deepcopy(answer)):
            for (name, before), (_, after) in zip(arrays_of(answer), arrays_of(copied), strict=True):
                if not before.flags.writeable:
                    found.add(name)
                    if after.flags.writeable:
                        writable.add(name)
    assert len(found) > 100 and writable == set()


def frozen_classes() -> dict[str, type[Any]]:
    """Public dataclasses that keep their arrays from being written into."""
    every = {
        value.__name__: value
        for room in (feeler, feeler.haptics, feeler.clashes, feeler.io, feeler.types)
        for name in room.__all__
        if dataclasses.is_dataclass(value := getattr(room, name)) and isinstance(value, type)
    }
    return {name: each for name, each in every.items() if hasattr(each.__init__, "__wrapped__")}


def test_reprs_of_answers_are_short() -> None:
    """One line each, whatever they hold."""
    truth = feeler.sample_truth("gearbox", 75_000)
    found = feeler.clash(feeler.sample("gearbox", 75_000), 0.002)
    told = [*answers(), truth, truth.fits[0], found, found.facts, found.columns, found.shapes, found.groups("part")[0]]
    told += [feeler.opening(feeler.Scene(BLOCK), (0.5, 0.5, 3), (0, 0, 1)), BLOCK.source, BLOCK.report]
    reprs = [repr(each) for each in told if not isinstance(each, np.ndarray)]
    assert len(reprs) > 45 and [text for text in reprs if len(text) > 1200 or "\n" in text] == []
    assert repr(truth).count(" in all") > 3, "lists say how long they are"


def test_texts_of_values_are_bounded() -> None:
    place = np.eye(4)
    assert short(place) == "<array (4, 4) float64>" and short(place[0]) == "array([1., 0., 0., 0.])"
    assert short(()) == "()" and short((1,)) == "(1,)" and short([1, "a"]) == "[1, 'a']" and short({}) == "{}"
    assert short(tuple(range(10**6))).endswith(", ... 1,000,000 in all)")
    assert short({number: place for number in range(9)}).endswith(", ... 9 in all}")
    for value in (
        ["x" * 1000] * 9,
        {"x" * 1000: "y" * 1000},
        "x\n" * 1000,
        [[[["x" * 90] * 9] * 9] * 9] * 9,
        place[:0],
    ):
        assert len(short(value)) < 300 and "\n" not in short(value)


def test_results_with_arrays_are_known() -> None:
    assert {"Removal", "Reach", "Depth", "Opening", "Fastener", "Seen", "RayHit", "Step"} <= frozen_classes().keys()


@pytest.mark.parametrize("kind", frozen_classes().values(), ids=frozen_classes())
def test_fields_of_a_pickle_are_read_only(kind: type[Any]) -> None:
    made: Any = object.__new__(kind)
    made.__setstate__({each.name: np.zeros(3) for each in dataclasses.fields(kind)})
    assert not any(getattr(made, each.name).flags.writeable for each in dataclasses.fields(kind))


def test_fields_of_frozen_answers_are_read_only() -> None:
    """What is written into one would be in all that have the same row."""
    mockup = feeler.sample("carcass", 10_000)
    scene = feeler.Scene(mockup, threads=1)
    bolts = feeler.find_fasteners(mockup)[:2]
    way, hole = feeler.removal(scene, bolts[0].part, seconds=5.0), feeler.opening(scene, [0, 0, 0.2], [0, 0, 1])
    row = feeler.access(scene, feeler.sample_tool("wrench"), bolts, threads=1)[0]
    for array in (bolts[0].frame, way.poses, hole.at, hole.axis, row.pose, bolts[[0]][0].frame):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 7.0


def test_rows_are_chosen_by_truths_numbers_and_slices() -> None:
    mockup = feeler.sample("carcass", 10_000)
    scene = feeler.Scene(mockup, threads=1)
    bolts = feeler.find_fasteners(mockup)[:3]
    reach = feeler.access(scene, feeler.sample_tool("wrench"), bolts, threads=1)
    tables: list[Any] = [bolts, reach, feeler.catalogue(), feeler.clash(mockup, clearance=0.01)]
    for table in tables:
        mask = np.arange(len(table)) % 2 == 0
        some: tuple[Any, ...] = (
            mask,
            mask.tolist(),
            np.flatnonzero(mask),
            np.flatnonzero(mask).tolist(),
            slice(0, None, 2),
        )
        for index in some:
            assert [str(row) for row in table[index]] == [str(row) for n, row in enumerate(table) if n % 2 == 0]
        assert str(table[np.int64(1)]) == str(table[1]) and str(table[-1]) == str(list(table)[-1])
        for wrong in ("x", None, [0.5], 1.5):
            with pytest.raises(TypeError, match="rows are chosen by"):
                table[wrong]
        with pytest.raises(IndexError, match="there is no row"):
            table[len(table)]
        with pytest.raises(feeler.OptionError, match="does not fit"):
            table[np.zeros(len(table) + 1, dtype=bool)]
    pose = np.eye(4)
    rows: list[Any] = [
        scene.rays([[0, 0, 1]], [[0, 0, -1]]),
        scene.distance_batch(feeler.sample_tool("wrench"), [pose]),
    ]
    for table in rows:
        with pytest.raises(TypeError, match="rows are chosen by a number or a slice, not by a str"):
            table["x"]
