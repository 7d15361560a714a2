"""What all tests share: hypothesis profiles, where the data is, small helpers as fixtures."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import typer.testing
from hypothesis import HealthCheck, settings

import feeler
from feeler.samples import FAULTS
from feeler.samples.accessory import Leg, Step

pytest_plugins = ("browser",)

ROOT = Path(__file__).resolve().parent.parent

# `ci`, the default: the same examples on every run, no deadline (machines differ).
# HYPOTHESIS_PROFILE=explore: many new examples on each run.
_SHARED_CHECKS = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
settings.register_profile(
    "ci", derandomize=True, deadline=None, max_examples=50, database=None, suppress_health_check=_SHARED_CHECKS
)
settings.register_profile("explore", deadline=None, max_examples=2000, suppress_health_check=_SHARED_CHECKS)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Typer makes all commands anew for each call, which takes far longer than most calls.
typer.testing._get_command = cache(typer.testing._get_command)


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def testdata() -> Path:
    """The folder of small files that the tests read."""
    return ROOT / "testdata"


@pytest.fixture(scope="session")
def models() -> Path:
    """The folder of real models, too big for the repository: $FEELER_MODELS, or shared/models beside the clone."""
    named = os.environ.get("FEELER_MODELS")
    folder = Path(named) if named else ROOT.parent / "shared" / "models"
    if not folder.is_dir():
        if named:
            pytest.fail(f"FEELER_MODELS={named} is not a folder")
        pytest.skip("no real models on this machine (set FEELER_MODELS to a folder with some)")
    return folder


class Gearbox:
    """The sample gearbox with its truth and its index; `out` names what a step of the truth needs out first."""

    TRIANGLES = 75_000

    def __init__(self, faults: tuple[str, ...] = ()) -> None:
        self.mockup = feeler.sample("gearbox", self.TRIANGLES, faults=faults)
        self.truth = feeler.sample_truth("gearbox", self.TRIANGLES, faults=faults)
        self.fault = {fault.name: fault for fault in self.truth.faults}

    @cached_property
    def scene(self) -> feeler.Scene:
        return feeler.Scene(self.mockup)

    def step(self, path: str) -> Step:
        """The step that takes a part out."""
        return self.truth.way(path)[-1]

    def out(self, step: Step) -> list[str]:
        """Parts that are out before a step; of an open door, the parts that turn with it as well."""
        door = next(joint.parts for joint in self.truth.joints if joint.name == "door") if step.door_open else ()
        return [*(path for earlier in self.truth.needed(step) if earlier.removes for path in earlier.parts), *door]

    @staticmethod
    def poses(step: Step, each: int = 12) -> npt.NDArray[np.float64]:
        """The way of a step: (n, 4, 4), `each` poses a leg, and the start."""
        poses = [np.eye(4)]
        for leg in step.legs:
            start = poses[-1]
            poses += [moved(leg, (i + 1) / each) @ start for i in range(each)]
        return np.array(poses)


def moved(leg: Leg, share: float) -> npt.NDArray[np.float64]:
    """The motion of a share of a leg, (4, 4)."""
    x, y, z = leg.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle, point = share * leg.angle_rad, np.array(leg.point_m)
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    pose[:3, 3] = point - pose[:3, :3] @ point + share * leg.distance_m * np.array(leg.axis)
    return pose


@pytest.fixture(scope="session")
def gearbox() -> Gearbox:
    """The sample gearbox, without faults: for tests of meaning."""
    return Gearbox()


@pytest.fixture(scope="session")
def faulty_gearbox() -> Gearbox:
    """The sample gearbox with each of its faults."""
    return Gearbox(tuple(FAULTS))


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same on every run."""
    return np.random.default_rng(20040301)


@pytest.fixture(scope="session")
def make_pose() -> Callable[..., npt.NDArray[np.float64]]:
    """`make_pose(translation=(0, 0, 0), axis=(0, 0, 1), degrees=0)`: a (4, 4) float64 world_from_tool, metres."""

    def make(
        translation: npt.ArrayLike = (0.0, 0.0, 0.0), axis: npt.ArrayLike = (0.0, 0.0, 1.0), degrees: float = 0.0
    ) -> npt.NDArray[np.float64]:
        x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = np.radians(degrees)
        pose = np.eye(4)
        pose[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
        pose[:3, 3] = translation
        return pose

    return make
