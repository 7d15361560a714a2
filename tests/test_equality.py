"""Classes with arrays compare by identity: `==` of arrays is an array, which has no truth value."""

from __future__ import annotations

import copy
import dataclasses
import importlib
import inspect
import pickle
import pkgutil
import re

import numpy as np
import pytest
from shapes import box

import feeler

OPTIONAL = ("feeler.__main__",)


def dataclasses_of_feeler() -> dict[str, type]:
    found = {}
    for module in pkgutil.walk_packages(feeler.__path__, "feeler."):
        if module.name in OPTIONAL:
            continue
        try:
            namespace = vars(importlib.import_module(module.name))
        except ImportError:
            continue  # it needs a package that is not installed
        for each in namespace.values():
            if inspect.isclass(each) and dataclasses.is_dataclass(each) and each.__module__ == module.name:
                found[f"{module.name}.{each.__qualname__}"] = each
    return found


def test_no_class_with_an_array_compares_its_fields() -> None:
    kinds = dataclasses_of_feeler()
    assert len(kinds) > 150
    wrong = [
        name
        for name, kind in kinds.items()
        if kind.__dataclass_params__.eq
        and any(
            re.match(r"npt\.NDArray|NDArray|Floats|Ints|FloatArray", str(each.type))
            for each in dataclasses.fields(kind)
        )
    ]
    assert wrong == []


def test_results_compare_by_identity_and_are_hashable() -> None:
    scene = feeler.Scene(feeler.Mockup([[0.0, 0, -9], [9, 0, -9], [0, 9, -9]], [[0, 1, 2]]))
    tool = feeler.Tool([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    session = feeler.haptics.Session(scene, tool)
    session.start(np.eye(4))
    step = session.step(np.eye(4))
    again = pickle.loads(pickle.dumps(step))
    assert step == step and step != again and len({step, again}) == 2


def test_values_compare_by_their_numbers() -> None:
    screw = feeler.Screw((0, 0, 1), (0, 0, 0), 1.0)
    assert screw == feeler.Screw((0, 0, 1), (0, 0, 0), 1.0)
    parts = feeler.Mockup([[0.0, 0, -9], [9, 0, -9], [0, 9, -9]], [[0, 1, 2]]).parts
    assert parts[0] == parts[0]
    with pytest.raises(feeler.OptionError):
        feeler.Screw((0, 0, 0), (0, 0, 0), 1.0)


def test_a_finding_is_equal_wherever_it_was() -> None:
    """Volumes that were not measured and translations that are not known are NaN, which is not equal to itself."""
    low, high = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    sheet = np.array([[-1.0, 0.5, 0.5], [2.0, 0.5, 0.5], [0.5, 2.0, 0.6]])
    parts = {"box": box(low, high), "other": box((0.9, 0.0, 0.0), (2.0, 1.0, 1.0)), "sheet": (sheet, [[0, 1, 2]])}
    once, again = (feeler.clash(feeler.Mockup(parts)) for _ in range(2))
    assert len(once) == 3 and all(np.isnan(each.volume) for each in once)
    for one, other in zip(once, again, strict=True):
        for same in (other, pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
            assert same == one and hash(same) == hash(one)
