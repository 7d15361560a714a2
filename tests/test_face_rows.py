"""Answers in Python's own words: their truth, and their rows."""

from __future__ import annotations

import dataclasses
import importlib
import pickle
import pkgutil
from typing import Any

import numpy as np
import pytest
from shapes import box

import feeler
from feeler.haptics import Planes, Trace
from feeler.mechanism.answers import MechanismClashes, MechanismContact

# Rooms behind the commands and the formats.
INSIDE = ("_core", "__main__", "agent", "cli", "io")
YES_OR_NO = ("is_found", "is_free", "is_reachable", "is_through")

SCENE = feeler.Scene(feeler.Mockup({"low": box((0, 0, 0), (1, 1, 1)), "high": box((0, 0, 2), (1, 1, 3))}))
TOOL = feeler.Tool(*box((0, 0, 0), (0.2, 0.2, 0.2)))


def at(x: float, y: float, z: float) -> Any:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def public_classes() -> list[type[Any]]:
    """All classes that `feeler` and its public modules offer."""
    names = ["", *(m.name for m in pkgutil.iter_modules(feeler.__path__) if m.name not in INSIDE)]
    modules = [importlib.import_module(f"feeler.{name}".rstrip(".")) for name in names]
    found = [getattr(module, name) for module in modules for name in getattr(module, "__all__", ())]
    return list(dict.fromkeys(each for each in found if isinstance(each, type)))


@pytest.mark.parametrize("kind", public_classes(), ids=lambda kind: kind.__name__)
def test_what_has_a_length_can_be_indexed_and_iterated(kind: type[Any]) -> None:
    if hasattr(kind, "__len__"):
        assert hasattr(kind, "__getitem__") and hasattr(kind, "__iter__")


@pytest.mark.parametrize("kind", public_classes(), ids=lambda kind: kind.__name__)
def test_an_answer_with_a_yes_or_no_has_its_truth(kind: type[Any]) -> None:
    fields = {each.name: each.type for each in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else {}
    says = [name for name in YES_OR_NO if fields.get(name) == "bool" or name in vars(kind)]
    if says and not hasattr(kind, "__setitem__") and kind not in (feeler.Scene, feeler.Access, feeler.Removals):
        assert hasattr(kind, "__bool__"), f"{kind.__name__}.{says[0]}"


def test_the_truth_of_plans_is_whether_they_were_found() -> None:
    assert feeler.removal(SCENE, "high")
    shut = feeler.Scene(feeler.Mockup({"in": box((0, 0, 0), (1, 1, 1)), "round": box((-1, -1, -1), (2, 2, 2))}))
    for answer in (feeler.removal(shut, "in", rounds=1), *feeler.removals(shut, ["in"], rounds=1)):
        assert not answer
    order = feeler.removal_order(SCENE, "high")
    assert order and order.is_found
    assert not dataclasses.replace(order, is_found=False), "although it has steps"
    assert dataclasses.replace(order, steps=()), "although it has none"
    reach = feeler.access(SCENE, TOOL, at(0, 0, 5)[None], angles=4)[0]
    assert bool(reach) == reach.is_reachable
    assert bool(dataclasses.replace(reach, is_reachable=False)) is False
    limit = feeler.OpeningLimit("hand", "ball", 0.1, 0.0, "")
    assert feeler.OpeningFit(limit, True, 0.2) and not feeler.OpeningFit(limit, False, 0.2)


def test_the_truth_of_a_path_is_that_it_is_free() -> None:
    free = SCENE.check_path(TOOL, [at(0, 0, 4), at(0, 0, 5)])
    hit = SCENE.check_path(TOOL, [at(0, 0, 4), at(0, 0, 5), at(0, 0, 1.5)])
    assert free and not hit and len(free) == 1 and len(hit) == 2


def rows_of_all() -> dict[str, Any]:
    path = [at(0, 0, 4), at(0, 0, 5), at(0, 0, 1.5), at(0, 0, 1.4)]
    contacts = tuple(
        MechanismContact(**{each.name: float(n) for each in dataclasses.fields(MechanismContact)})  # type: ignore[arg-type]
        for n in range(3)
    )
    planes = Planes(
        np.eye(3),
        np.eye(3),
        np.arange(3.0),
        np.arange(3, dtype=np.uint32),
        np.arange(3, dtype=np.uint64),
        np.ones(3) > 0,
    )
    poses = np.repeat(np.eye(4)[None], 3, axis=0)
    trace = Trace(np.arange(3.0), poses, poses, np.ones((3, 6)), ("free", "free", "held"), np.ones(3) > 0)  # type: ignore[arg-type]
    crossing = feeler.Mockup({"a": box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (1.5, 1, 1))})
    both = feeler.Mockup(
        {"a": box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (1.5, 1, 1)), "c": box((0, 0, 0.9), (1, 1, 2))}
    )
    return {
        "Collision": SCENE.collide(TOOL, at(0.9, 0.9, 0.9)),
        "Clearance": SCENE.clearance(TOOL, at(0, 0, 1.4), within=1.0),
        "PathCheck": SCENE.check_path(TOOL, path),
        "Rays": SCENE.rays([[0.5, 0.4, 9.0], [9, 9, 9], [0.3, 0.2, 1.5]], [[0, 0, -1.0]] * 3),
        "SectionOutline": SCENE.section([0, 0, 0.5], [0, 0, 1]),
        "Depths": feeler.Scene(crossing).depth(TOOL, at(0.6, 0.5, 0.5)),
        "IgnoredPairs": feeler.IgnoredPairs(TOOL, SCENE.mockup, [("*", "*")]),
        "MechanismClashes": MechanismClashes("lid", 0.0, 1.0, contacts, ()),
        "Planes": planes,
        "Trace": trace,
        "Group": feeler.clash(both).groups("part")[0],
    }


ALL = rows_of_all()


@pytest.mark.parametrize("name", list(ALL))
def test_rows_iterate_index_and_slice(name: str) -> None:
    answer = ALL[name]
    items = [repr(each) for each in answer]
    assert len(items) == len(answer) > 1
    assert [repr(answer[np.int64(i)]) for i in range(len(answer))] == items
    assert [repr(answer[i - len(answer)]) for i in range(len(answer))] == items
    for few in (slice(None), slice(1, None), slice(None, None, -1), slice(5, 9), slice(0, 3, 2)):
        assert [repr(each) for each in answer[few]] == items[few]
    for place in (len(answer), -len(answer) - 1):
        with pytest.raises(IndexError):
            answer[place]
    with pytest.raises(TypeError):
        answer["x"]


def test_rows_hold_what_the_columns_hold() -> None:
    hit, near, check = ALL["Collision"], ALL["Clearance"], ALL["PathCheck"]
    assert [list(row) for row in hit] == hit.pairs.tolist()
    assert [row.value for row in near] == near.distances.tolist() and [row.part for row in near] == near.parts.tolist()
    assert [n for n, row in enumerate(check) if row is not None] == check.segments.tolist()
    assert [row.fraction for row in check if row] == check.fractions[check.segments].tolist()
    rays, outline, depths = ALL["Rays"], ALL["SectionOutline"], ALL["Depths"]
    assert [row is None for row in rays] == (rays.triangles < 0).tolist()
    for row, distance, point, normal, triangle, part in zip(
        rays, rays.distances, rays.points, rays.normals, rays.triangles, rays.parts, strict=True
    ):
        if row is not None:
            assert (row.distance, row.triangle, row.part) == (distance, triangle, part)
            assert row.point.tolist() == point.tolist() and row.normal.tolist() == normal.tolist()
            assert repr(pickle.loads(pickle.dumps(row))) == repr(row)
    assert np.array_equal([*outline], outline.segments)
    assert [row.depth for row in depths] == depths.depths.tolist() and {type(row.part) for row in depths} == {int}
    assert np.array_equal([row.point_on_tool for row in depths], depths.points_on_tool)
    assert isinstance(depths[1:], feeler.Depths) and not depths[1:].parts.flags.writeable
    assert [*ALL["IgnoredPairs"]] == [(0, 0), (0, 1)]
    assert [row.mode for row in ALL["Trace"]] == ["free", "free", "held"]
    assert [row.id for row in ALL["Group"]] == [row.id for row in ALL["Group"].clashes]
