"""Forked children of a process whose threads are busy in feeler: they answer, and do not wait for threads they lack.

Some cases at a time are a program of their own (`forked.py`): a child that hangs is killed and takes no other along,
and they share the time that a start takes.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("forked.py")

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")

CASES = [
    "mockup",
    "tool",
    "blocks",
    "dense",
    "hashed",
    "own pool",
    "calibrated",
    "sample",
    "collide",
    "is_colliding",
    "collide_batch",
    "collide_batch, own pool",
    "clearance",
    "clearance_batch",
    "distance",
    "distances",
    "distance_batch",
    "cast",
    "check_path",
    "check_path, own pool",
    "check_path of a new mock-up",
    "is_colliding, touching free",
    "cast, touching free",
    "is_free",
    "containment",
    "rays",
    "rays, own pool",
    "section",
    "section, own pool",
    "pack",
    "pack, tool",
    "without",
    "only",
    "ignore",
    "tool of parts",
    "contacts",
    "contacts of a new mock-up",
    "penetration",
    "penetration of a new mock-up",
    "tracker",
    "optimal_voxel_size",
    "predictor",
    "piece predictor",
    "haptics",
    "haptics, running",
    "swept",
    "swept, own pool",
    "study",
    "fasteners",
    "access",
    "removal",
    "load",
]


AT_A_TIME = 6


def run(*cases: str) -> subprocess.CompletedProcess[str]:
    # Python 3.12 warns of forks with threads; that they work is what is tested.
    command = [sys.executable, "-W", "ignore::DeprecationWarning", str(PROGRAM), *cases]
    return subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)


@cache
def told_of(first: int) -> str:
    """What the program tells of the cases from one on."""
    done = run(*CASES[first : first + AT_A_TIME])
    return done.stdout + done.stderr


@pytest.mark.parametrize("case", CASES)
def test_a_forked_child_answers(case: str) -> None:
    number = CASES.index(case)
    told = told_of(number - number % AT_A_TIME)
    assert f"passed {case}" in told.splitlines(), told


def test_all_cases_are_run() -> None:
    assert run("--list").stdout.splitlines() == CASES


@pytest.mark.parametrize(
    "case", ["while topology is found", "in a progress function", "while pools are made", "grandchild", "dropped"]
)
def test_a_fork_at_a_bad_moment(case: str) -> None:
    done = run(case)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="this system does not list threads")
def test_no_query_uses_the_pool_that_a_fork_breaks() -> None:
    done = run("no global pool")
    assert done.returncode == 0, done.stdout + done.stderr
