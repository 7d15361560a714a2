"""The puzzles, by feeler and by OMPL: how often each finds a path, in what time, and whether the path is free."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import host
import numpy as np

from .planners import FeelerPlanner, Planner, Problem
from .puzzles import MOVING, PUZZLES, Puzzle

Result = dict[str, Any]


def solved(peers: Sequence[Planner], seeds: int, peer_seeds: int, seconds: float) -> Result:
    """Every puzzle by every planner, on one core; every try has a limit in seconds."""
    rows = []
    with host.on_core(host.last_core()):
        for puzzle in PUZZLES:
            problem = Problem(puzzle.make(), [MOVING])
            tries = [_tried(puzzle, problem, FeelerPlanner(), seeds, seconds)]
            for peer in peers if puzzle.has_way else ():
                tries.append(_tried(puzzle, problem, peer, peer_seeds, seconds))
            rows.append({"name": puzzle.name, "has_way": puzzle.has_way, "tries": tries})
    return {"seconds": seconds, "puzzles": rows}


def _tried(puzzle: Puzzle, problem: Problem, planner: Planner, seeds: int, seconds: float) -> Result:
    print(f"{puzzle.name}: {planner.name}", file=sys.stderr)
    answers = [planner.solve(problem, seed, seconds) for seed in range(seeds if puzzle.has_way else 1)]
    times = [answer.seconds for answer in answers]
    found = [answer for answer in answers if answer.poses is not None]
    return {
        "planner": planner.name,
        "seeds": len(answers),
        "found": len(found),
        "free": sum(problem.is_free(answer.poses) for answer in found if answer.poses is not None),
        "named": sum(answer.blocked_by[:1] == (problem.whole.mockup.part_names[0],) for answer in answers),
        "median_s": _short(float(np.median(times))),
        "worst_s": _short(max(times)),
    }


def _short(seconds: float) -> float:
    return float(f"{seconds:.4g}")
