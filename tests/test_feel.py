"""The short form of the feel bench: what is aimed at without hardware is met, decided on simulated time alone."""

from __future__ import annotations

import importlib

import pytest

run = importlib.import_module("feel.run")
goals = importlib.import_module("feel.goals")


@pytest.mark.parametrize("experiment", ["passing", "forces", "sliding", "step_response", "release", "pegs", "fits"])
def test_goals_are_met(experiment: str) -> None:
    options = run.parse(["--quick", "--faces", "feeler", "--only", experiment, "--runs", "15", "--seeds", "1"])
    found = run.run(options)["faces"]["feeler"]
    card = [goal for goal in goals.scorecard(found) if not goal.is_timed]
    assert card
    missed = [f"{goal.goal}: {goal.found}, wanted {goal.wanted}" for goal in card if not goal.is_met]
    assert not missed, "\n".join(missed)
