"""Tools for agents about maintenance: tasks, access by a catalogue, and what is seen."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import mockup_of

import feeler
from feeler.agent.job import Job
from feeler.agent.served import Served
from feeler.agent.tools import TOOLS, call
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

RINGS = ((0.0045, -0.01, 0.0), (0.0034, -0.04, -0.01))
"""Inner radius, lower and upper end of a cover and a case, metres."""


def bolted() -> Served:
    """A cover under an M8 bolt in a case."""
    bolt = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    rings = [hardware.ring(inner, 0.02, high - low, Tolerance(1e-4)) for inner, low, high in RINGS]
    moved = [
        (each.vertices + np.array([0.0, 0.0, low]), each.faces) for each, (_, low, _) in zip(rings, RINGS, strict=True)
    ]
    parts = {"bolt": (bolt.vertices, bolt.faces), "cover": moved[0], "case": moved[1]}
    return Served(feeler.Scene(mockup_of(parts)))


def test_a_task_is_planned_with_tools_and_times() -> None:
    served = bolted()
    plan = feeler.task(served.scene, "cover", "built-in", {"stroke": 2.0})
    found = call(TOOLS["task"], served, {"parts": "cover", "times": {"stroke": 2.0}}, Job()).content
    assert found["found"] and found["complete"] and found["said"] == plan.said and found["steps"] == 2
    assert found["seconds"] == pytest.approx(plan.seconds) and found["bound_seconds"] <= found["seconds"]
    undo, take = found["rows"]
    assert (undo["verb"], undo["tool"], undo["strokes"]) == ("undo", plan.steps[0].tool, 16)
    assert take["parts"] == ["cover"] and "tool" not in take
    bare = call(TOOLS["task"], served, {"parts": "cover", "tool": "none"}, Job()).content
    assert any("not checked" in note for note in bare["notes"]) and "tool" not in bare["rows"][0]
    stuck = call(TOOLS["task"], served, {"parts": "cover", "keep": "bolt"}, Job()).content
    assert not stuck["found"] and "kept" in stuck["blocked"][0]["because"] and stuck["rows"] == []


def test_a_task_that_time_ends_says_the_bound() -> None:
    job = Job(lambda: job.limit(0.0) if "checking the way" in job.report[2] else None)
    cut = call(TOOLS["task"], bolted(), {"parts": "cover"}, job).content
    assert not cut["found"] and not cut["complete"] and cut["steps"] == 2 and cut["bound_seconds"] > 0.0
    assert "ways not checked" in cut["said"]


def test_access_chooses_from_the_catalogue_and_heads_are_seen() -> None:
    served = bolted()
    row = call(TOOLS["access"], served, {"tool": "catalogue"}, Job()).content["rows"][0]
    assert row["reachable"] and row["tool"].startswith("socket 13")
    seen = call(TOOLS["sight"], served, {}, Job()).content
    assert seen["targets"] == 1 and seen["hidden"] == 0 and seen["rows"][0]["share"] > 0.9
    below = call(TOOLS["sight"], served, {"eyes_m": [[0.0, 0.0, -1.0]]}, Job()).content
    assert below["hidden"] == 1 and below["rows"][0]["share"] == 0.0 and below["rows"][0]["hidden_by"]
