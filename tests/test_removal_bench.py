"""The bench of removal: its puzzles are what they say, its judging, its tables."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

goals = importlib.import_module("removal.goals")
host = importlib.import_module("host")
meshes = importlib.import_module("feel.meshes")
planners = importlib.import_module("removal.planners")
puzzles = importlib.import_module("removal.puzzles")
run = importlib.import_module("removal.run")
tables = importlib.import_module("removal.tables")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a short run of feeler alone leaves."""
    found: Path = tmp_path_factory.mktemp("removal")
    given = ["--quick", "--peers", "none", "--sizes", "10k,10k", "--seeds", "1", "--seconds", "5"]
    assert run.main([str(found), *given]) == 0
    return found


@pytest.fixture
def result(folder: Path) -> Any:
    return json.loads((folder / "removal.json").read_text(encoding="utf-8"))


def test_a_short_run_has_every_puzzle_and_the_engine(folder: Path, result: Any) -> None:
    assert [row["name"] for row in result["puzzles"]["puzzles"]] == [puzzle.name for puzzle in puzzles.PUZZLES]
    assert result["engine"]["rate"]["parts"] == run.PARTS.quick
    assert result["engine"]["access"]["targets"] == run.TARGETS.quick
    text = (folder / "tables.md").read_text(encoding="utf-8")
    assert "| closed box | feeler | 0 of 1 |" in text and "| what | goal | found |" in text


@pytest.mark.parametrize("name", [puzzle.name for puzzle in puzzles.PUZZLES])
def test_puzzles_are_closed_and_begin_free(name: str) -> None:
    mockup = puzzles.BY_NAME[name].make()
    problem = planners.Problem(mockup, [puzzles.MOVING])
    assert problem.is_free(np.eye(4)[None])
    for part in range(2):
        mesh = mockup.vertices, mockup.faces[mockup.part_of_face == part].astype(np.int64)
        assert meshes.boundary_edges(mesh) == 0 and meshes.volume(mesh) > 0.0


def test_tubes_are_as_large_as_the_known_puzzle_and_linked() -> None:
    mockup = puzzles.tubes(1.0)
    assert mockup.part_triangles.tolist() == [972, 972]
    problem = planners.Problem(mockup, [puzzles.MOVING])
    # Straight out to any side it is stopped.
    for direction in np.vstack([np.eye(3), -np.eye(3)]):
        pose = np.eye(4)
        pose[:3, 3] = 0.5 * direction
        assert problem.scene.cast(problem.tool, np.eye(4), pose) is not None


def test_the_pegs_gap_is_as_stated() -> None:
    for share in (0.01, 0.001):
        problem = planners.Problem(puzzles.peg(share), [puzzles.MOVING])
        gap = problem.scene.distance(problem.tool, np.eye(4)).value
        # Between the flats of both.
        assert gap == pytest.approx(share * puzzles.PEG_RADIUS * np.cos(np.pi / puzzles.SIDES), rel=1e-6)


def test_goals_tell_missed_from_met(result: Any) -> None:
    assert all(goal.is_met for goal in goals.scorecard(result) if not goal.is_timed)
    puzzle = result["puzzles"]["puzzles"][0]
    puzzle["tries"][0].update(found=1, free=0, median_s=1.0)
    missed = {goal.goal for goal in goals.scorecard(result) if not goal.is_met and goal.experiment == puzzle["name"]}
    assert missed >= {"ways that are free", "median"}
    box = result["puzzles"]["puzzles"][-1]
    box["tries"][0].update(named=0)
    assert any(goal.experiment == "closed box" and not goal.is_met for goal in goals.scorecard(result))


def test_tables_are_the_records(result: Any) -> None:
    text = "<!-- removal: engine -->\nold\n<!-- end of removal: engine -->"
    assert tables.SECTION.filled(text, result).count(tables.engine(result["engine"])) == 1
    record, page = tables.SECTION.record, host.ROOT / "docs" / tables.SECTION.page
    if record.is_file():
        page = page.read_text(encoding="utf-8")
        assert tables.SECTION.filled(page, json.loads(record.read_text(encoding="utf-8"))) == page


def test_ompl_finds_a_way_that_is_checked_afterwards() -> None:
    pytest.importorskip("ompl")
    kind = importlib.import_module("removal.ompl_planner").OmplPlanner
    problem = planners.Problem(puzzles.tubes(2.0), [puzzles.MOVING])
    answer = kind("KPIECE1", 0.002).solve(problem, 0, 60.0)
    assert answer.poses is not None
    np.testing.assert_allclose(answer.poses[0], np.eye(4), atol=1e-12)
