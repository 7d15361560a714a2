"""What all tests share: hypothesis profiles, where the data is, small helpers as fixtures."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, settings

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
