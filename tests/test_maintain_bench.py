"""The bench of nightly runs: what is wrong is seen, and moves stay inside the box of all parts."""

from __future__ import annotations

import importlib

import numpy as np
from night_scene import parts
from shapes import mockup_of

goals = importlib.import_module("maintain.goals")
nights = importlib.import_module("maintain.nights")
run = importlib.import_module("maintain.run")
tables = importlib.import_module("maintain.tables")


def found(name: str = "engine") -> dict[str, object]:
    """As a run finds it."""
    origin = {"when": "2026-01-01", "commit": "abc", "dirty": False, "args": [], "is_quick": False}
    busy = {"machine": {"cpu": "any"}, "load_average": None, "load_average_after": None}
    moved = {"parts": 1, "seconds": 4.0, "full_seconds": 50.0, "kept": 2, "changed": 1, "differs": []}
    rows = {
        "triangles": 1_600_000,
        "parts": 100,
        "rows": 100,
        "out": 2,
        "cut": 0,
        "with_errors": 0,
        "seconds": 50.0,
        "bytes": [1, 2],
    }
    return {**origin, **busy, **rows, "same_seconds": 1.0, "same_kept": 3, "same_differs": [], "moved": [moved]}


def test_what_is_wrong_is_seen() -> None:
    good = found()
    assert all(goal.is_met for goal in goals.scorecard({"engine": good})) and "8.0%" in tables.MAKERS["engine"](good)
    bad = {**good, "seconds": 4000.0, "same_differs": ["a"], "moved": [{**good["moved"][0], "seconds": 30.0}]}  # type: ignore[index]
    missed = [goal.goal for goal in goals.scorecard({"engine": bad}) if not goal.is_met]
    assert len(missed) == 3 and all(
        text in tables.MAKERS["engine"](bad) for text in ("**4e+03**", "**60.0%**", "**1**")
    )


def test_few_parts_move_inside_the_box_of_all() -> None:
    mockup = mockup_of(parts(30))
    poses = nights._poses(mockup, np.random.default_rng(0))
    assert len(poses) == 1 == round(0.01 * mockup.part_count)
    boxes = mockup.part_bounds.reshape(-1, 2, 3)
    for part, pose in poses.items():
        by = pose[:3, 3]
        assert 0.0 < np.abs(by).max() <= nights.SHIFT_M
        assert (boxes[part] + by >= boxes[:, 0].min(axis=0)).all() and (
            boxes[part] + by <= boxes[:, 1].max(axis=0)
        ).all()


def test_the_command_line_has_a_short_form() -> None:
    options = run.parse(["--quick"])
    assert (options.size, options.parts, options.only) == (30_000, 2, ["engine", "gearbox"])
