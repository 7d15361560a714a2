"""The core's one pass against the plain loop over parts (clash_twin.py): flush faces, odd turns, a gearbox."""

from __future__ import annotations

import math
from typing import Any

import clash_twin
import numpy as np
import pytest
from shapes import Mesh, at, box, inverted, joined, mockup_of

import feeler
from feeler import Verdict, _core

LIMITS = (np.array([[0.002]]), np.array([[0.0]]))
ROUNDING = 1e-13


def rows_of(answer: Any) -> dict[tuple[int, int], dict[str, Any]]:
    names = ["verdict", "gap", "triangles", "is_open", "depth", "depth_error", "depth_kind", "translation"]
    names += ["is_decided"] if isinstance(answer, clash_twin.Rows) else []
    columns = [np.asarray(getattr(answer, name)).tolist() for name in names]
    return {
        pair: dict(zip(names, row, strict=True))
        for pair, row in zip(
            zip(answer.a.tolist(), answer.b.tolist(), strict=True), zip(*columns, strict=True), strict=True
        )
    }


def same(mockup: feeler.Mockup, limits: tuple[Any, Any] = LIMITS) -> dict[tuple[int, int], dict[str, Any]]:
    """The core's rows, after comparing them with the twin's."""
    scene = feeler.Scene(mockup)
    classes = np.zeros(mockup.part_count, np.uint32)
    core = rows_of(_core.clash(scene, *limits, class_of_part=classes))
    twin = rows_of(clash_twin.clash(scene, *limits, class_of_part=classes, exclude=np.empty((0, 2), np.uint32)))
    assert core.keys() == twin.keys()
    decided = 0
    for pair, row in core.items():
        other, verdict = twin[pair], Verdict(row["verdict"])
        if other["is_decided"]:
            decided += 1
            assert verdict == Verdict(other["verdict"]), pair
        else:
            assert verdict in (Verdict.CLASH, Verdict.CONTACT), pair
        assert row["triangles"] == other["triangles"] and row["is_open"] == other["is_open"], pair
        if verdict in (Verdict.CONTACT, Verdict.CLEARANCE):
            assert row["gap"] == other["gap"] and not any(row["translation"]), pair
        assert_depth(row, other, max(limits[1][0, 0], ROUNDING), pair)
    assert decided >= 0.9 * len(core)
    return core


def assert_depth(row: dict[str, Any], other: dict[str, Any], contact: float, pair: tuple[int, int]) -> None:
    """Both lower bounds are no more than the upper bound of the other, and the core's are as close as promised."""
    verdict, is_estimate = Verdict(row["verdict"]), any(row["is_open"])
    assert row["depth_kind"] == is_estimate or not row["depth"], pair
    if verdict == Verdict.CONTACT:
        assert row["depth"] <= contact, pair
    if math.isnan(row["depth_error"]):
        assert all(row["is_open"]), pair
        return
    assert 0.0 <= row["depth_error"] <= max(1e-9, 1e-3 * row["depth"]), pair
    assert row["depth"] <= other["depth"] + other["depth_error"] + ROUNDING, pair
    assert other["depth"] <= row["depth"] + row["depth_error"] + ROUNDING, pair
    if verdict in (Verdict.DUPLICATE, Verdict.CLEARANCE):
        assert row["depth"] == 0.0 and row["depth_error"] <= ROUNDING, pair


def random_boxes(rng: np.random.Generator, number: int) -> dict[str, Mesh]:
    """Boxes on a lattice of quarters: most that meet are flush somewhere. Some are turned, open, hollow or mirrored."""
    shapes = {}
    for i in range(number):
        low = rng.integers(0, 6, 3) / 4
        mesh = box(low, low + rng.integers(1, 6, 3) / 4)
        kind = rng.integers(0, 8)
        if kind == 0:
            pose = at(*rng.uniform(0, 1, 3), degrees=float(rng.uniform(5, 85)), axis=int(rng.integers(3)))
            mesh = mesh[0] @ pose[:3, :3].T + pose[:3, 3], mesh[1]
        elif kind == 1:
            mesh = mesh[0], mesh[1][2:]
        elif kind == 2:
            middle, reach = mesh[0].mean(axis=0), np.ptp(mesh[0], axis=0)
            mesh = joined(mesh, inverted(box(middle - reach / 4, middle + reach / 4)))
        elif kind == 3:
            mesh = inverted(mesh)
        elif kind == 4 and shapes:
            mesh = shapes[str(rng.integers(0, i))]
        shapes[str(i)] = mesh
    return shapes


@pytest.mark.parametrize("seed", range(12))
def test_random_boxes(seed: int) -> None:
    found = same(mockup_of(random_boxes(np.random.default_rng(seed), 14)))
    assert len(found) > 15


def test_random_boxes_have_all_kinds() -> None:
    verdicts = set()
    for seed in range(12):
        mockup = mockup_of(random_boxes(np.random.default_rng(seed), 14))
        verdicts |= {Verdict(each) for each in feeler.clash(mockup, clearance=0.3).verdicts.tolist()}
    assert verdicts == set(Verdict)


@pytest.mark.parametrize("seed", range(4))
def test_wide_limits(seed: int) -> None:
    mockup = mockup_of(random_boxes(np.random.default_rng(seed), 10))
    # The contact is between the depths that the lattice allows, multiples of 1/8, and more than half of some walls.
    same(mockup, (np.array([[0.3]]), np.array([[0.17]])))


@pytest.mark.slow
def test_a_gearbox() -> None:
    found = same(feeler.sample("differential", 10_000))
    assert len(found) > 200
