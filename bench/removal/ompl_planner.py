"""OMPL (https://ompl.kavrakilab.org): its planners, with feeler's exact test of a pose as their state checker.

They need a goal: the part anywhere well outside of the mock-up's box. They check motions at steps whose length is a
share of the space's extent: a coarse step may pass through a wall that a fine one hits. `check_path` then verifies the
path.
"""

from __future__ import annotations

import time
from importlib.metadata import version

import numpy as np
from contacts import Floats
from ompl import base, geometric, util

import feeler

from .planners import Answer, Problem

ROOM = 4.0
"""The space for the part's middle: a cube this many times as large as the whole mock-up."""


class OmplPlanner:
    """One planner of OMPL at one step."""

    def __init__(self, planner: str, step: float) -> None:
        self.planner, self.step = planner, step
        self.name = f"OMPL {planner}, step {1e3 * step:g} mm"
        self.version = version("ompl")

    def solve(self, problem: Problem, seed: int, seconds: float) -> Answer:
        """A way out, on one thread."""
        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(seed + 1)
        begun = time.perf_counter()
        setup = self._setup(problem)
        setup.solve(seconds)
        taken = time.perf_counter() - begun
        if not setup.haveExactSolutionPath():
            return Answer(taken, None)
        states = setup.getSolutionPath().getStates()
        return Answer(taken, np.array([pose_of(state) @ problem.centred for state in states]))

    def _setup(self, problem: Problem) -> geometric.SimpleSetup:
        space = base.SE3StateSpace()
        bounds = base.RealVectorBounds(3)
        reach = 0.5 * ROOM * problem.size
        for axis in range(3):
            bounds.setLow(axis, problem.middle[axis] - reach)
            bounds.setHigh(axis, problem.middle[axis] + reach)
        space.setBounds(bounds)
        setup = geometric.SimpleSetup(space)
        # The checker is given the part about its own middle, about which it turns.
        tool = feeler.Tool(problem.tool.vertices - problem.pivot, problem.tool.faces)
        setup.setStateValidityChecker(lambda state: not problem.scene.is_colliding(tool, pose_of(state)))
        information = setup.getSpaceInformation()
        information.setStateValidityCheckingResolution(self.step / space.getMaximumExtent())
        start, goal = space.allocState(), space.allocState()
        outside = problem.middle + np.array([0.9 * reach, 0.0, 0.0])
        for state, at in ((start, problem.pivot), (goal, outside)):
            state.setXYZ(*at.tolist())
            state.rotation().setIdentity()
        setup.setStartAndGoalStates(start, goal)
        setup.setPlanner(getattr(geometric, self.planner)(information))
        return setup


def pose_of(state: base.State) -> Floats:
    """A state as a pose."""
    turn = state.rotation()
    q = np.array([turn.x, turn.y, turn.z, turn.w])
    x, y, z, w = q / np.linalg.norm(q)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    pose[:3, 3] = state.getX(), state.getY(), state.getZ()
    return pose
