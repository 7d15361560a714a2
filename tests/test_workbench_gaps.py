"""The least gap along a way, as cards and films say it."""

from __future__ import annotations

import numpy as np
import pytest
from workbench_scene import FACES, corners

import feeler
from feeler.poses import between
from feeler.workbench.session.answering import CLEARANCE_ERROR, gaps_along


def boxes(*spans: tuple[tuple[float, ...], tuple[float, ...]]) -> feeler.Mockup:
    count = len(spans)
    vertices = np.concatenate([corners(low, high) for low, high in spans])
    faces = np.concatenate([FACES + 8 * part for part in range(count)])
    return feeler.Mockup(vertices, faces, np.repeat(np.arange(count), len(FACES)), [f"box {n}" for n in range(count)])


def least(mockup: feeler.Mockup, way: np.ndarray) -> float | None:
    """Of part 0 on a way."""
    scene, moving = feeler.Scene(mockup), feeler.Tool.of_parts(mockup, [0])
    gaps = gaps_along(scene.without([0]), moving, way, lambda *_: None)
    shares = [gap["share"] for gap in gaps]
    assert shares == sorted(shares) and (shares[0], shares[-1]) == (0.0, 1.0)
    return min((gap["gap"] for gap in gaps if gap["gap"] is not None), default=None)


@pytest.mark.parametrize("turn", [0.0, 0.01, 0.5, 2.0])
@pytest.mark.parametrize("side", [0.004, 0.0005])
def test_a_narrow_pass_is_seen_between_the_poses(turn: float, side: float) -> None:
    """A sheet of 20 mm passes the edge of a thin plate in one move."""
    mockup = boxes(((0.0098, 0.0, 0.0), (0.0102, 0.02, 0.02)), ((0.0703, 0.0217, -0.1), (0.0703 + side, 0.1, 0.1)))
    c, s = np.cos(turn), np.sin(turn)
    end = np.eye(4)
    end[:2, :2] = [[c, -s], [s, c]]
    end[:3, 3] = [0.12, 0.003, 0.0]
    middle = np.array([0.01, 0.01, 0.01])
    end[:3, 3] += middle - end[:3, :3] @ middle
    scene, moving = feeler.Scene(mockup).without([0]), feeler.Tool.of_parts(mockup, [0])
    poses = [between(np.eye(4), end, middle, share) for share in np.linspace(0.0, 1.0, 4001)]
    truth = float(scene.distance_batch(moving, np.array(poses)).values.min())
    found = least(mockup, np.array([np.eye(4), end]))
    assert truth > 0.0 and found is not None
    assert truth * (1.0 - 5e-3) <= found <= truth * (1.0 + 1.1 * CLEARANCE_ERROR)


def test_what_it_stands_on_is_no_neighbour() -> None:
    """A cube on a table, between walls that are 5 mm away: not the first place above the table."""
    table, wall = ((-0.1, -0.1, -0.01), (0.1, 0.1, 0.0)), ((0.025, -0.1, 0.001), (0.03, 0.1, 0.1))
    mockup = boxes(((0.0, 0.0, 0.0), (0.02, 0.02, 0.02)), table, wall)
    up = np.eye(4)
    up[2, 3] = 0.05
    assert least(mockup, np.array([np.eye(4), up])) == pytest.approx(0.005, rel=1e-6)
    found = feeler.removal(feeler.Scene(mockup), 0)
    assert found.clearance == pytest.approx(0.005, rel=0.05)
