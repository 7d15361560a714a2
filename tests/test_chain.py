"""Chains of joints: casts along them, and the least gap on a way between proven bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

import feeler

Z = (0, 0, 1)
STILL = np.eye(4)
FACES = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6]]
FACES += [[1, 3, 5], [3, 7, 5]]


def corners(low: tuple[float, ...], high: tuple[float, ...]) -> list[list[float]]:
    return [[(low, high)[i >> a & 1][a] for a in range(3)] for i in range(8)]


@pytest.fixture(scope="module")
def post() -> feeler.Scene:
    """A box whose left face is at x = 2."""
    return feeler.Scene(feeler.Mockup(corners((2, -0.5, -0.5), (3, 0.5, 0.5)), FACES))


@pytest.fixture(scope="module")
def tool() -> feeler.Tool:
    return feeler.Tool(corners((0.9, -0.01, -0.01), (1.0, 0.01, 0.01)), FACES)


def test_a_cast_along_a_chain_stops_where_the_closed_form_does(post: feeler.Scene, tool: feeler.Tool) -> None:
    way = feeler.Chain([feeler.Slide((2.0, 0, 0)), feeler.Screw((1, 0, 0), (0, 0, 0), 7.0)])
    hit = post.cast(tool, STILL, screw=way, tolerance=1e-9)
    assert hit is not None
    assert 0.5 - 1e-8 < hit.fraction <= 0.5
    assert np.allclose(hit.pose, way.at(STILL, hit.fraction), atol=1e-12)
    check = post.check_path(tool, [STILL, way, feeler.Slide((0, 5, 0)), STILL])
    assert check.segments.tolist() == [0, 1, 2][: len(check.segments)]
    straight = post.cast(tool, STILL, screw=feeler.Slide((2.0, 0, 0)))
    assert straight is not None
    assert straight.fraction == pytest.approx(0.5, abs=1e-5)


def test_a_chain_is_the_product_of_its_joints() -> None:
    first, second = feeler.Screw(Z, (0, 0, 0), 1.0), feeler.Screw(Z, (1, 0, 0), -0.5, 0.1)
    chain = feeler.Chain([first, feeler.Slide((0, 1, 0)), second])
    expected = first.at(feeler.Slide((0, 1, 0)).at(second.at(STILL, 0.3), 0.3), 0.3)
    assert np.allclose(chain.at(STILL, 0.3), expected, atol=1e-15)
    assert np.allclose(chain.reversed().at(chain.at(STILL)), STILL, atol=1e-15)
    assert len(chain) == 3
    assert chain.joints[0] == first
    assert chain.relative_to(feeler.Chain([first])) == feeler.Chain(chain.joints[1:])
    assert eval(repr(chain), {"Chain": feeler.Chain, "Screw": feeler.Screw, "Slide": feeler.Slide}) == chain
    for motion in (first, chain, feeler.Slide((0, 1, 0))):
        for fraction in (-0.1, 2.0, math.nan):
            with pytest.raises(feeler.OptionError, match=r"fraction is .*: give a number, 0 to 1"):
                motion.at(STILL, fraction)
    for wrong in (3, [3], [STILL]):
        with pytest.raises(feeler.OptionError, match="joints of the chain"):
            feeler.Chain(wrong)  # type: ignore[arg-type]
    with pytest.raises(feeler.OptionError, match="slide"):
        feeler.Slide((math.nan, 0, 0))


@pytest.mark.parametrize("error", [1e-2, 1e-4])
def test_the_least_gap_is_between_its_bounds(post: feeler.Scene, tool: feeler.Tool, error: float) -> None:
    # The tip turns by from -0.6 to 0.7 rad about the origin on an arm of two links that stays straight.
    start = feeler.Screw(Z, (0, 0, 0), -0.6).at(STILL)
    ways = [
        feeler.Screw(Z, (0, 0, 0), 1.3),
        feeler.Chain([feeler.Screw(Z, (0, 0, 0), 1.3), feeler.Slide((0.2, 0.1, 0)), feeler.Screw(Z, (0.5, 0, 0), 0.4)]),
        feeler.Slide((0.7, 0.3, 0.1)),
        feeler.Screw((0, 1, 0), (0, 0, 0), 0.5).at(start),
    ]
    for way in ways:
        found = post.clearance_along(tool, start, way, error)
        assert found.upper - error <= found.lower <= found.upper
        if isinstance(way, np.ndarray):
            continue
        poses = np.array([way.at(start, share) for share in np.linspace(0, 1, 2001)])
        gaps = post.distance_batch(tool, poses).values
        assert gaps.min() >= found.lower
        assert found.upper == pytest.approx(post.distance(tool, found.pose).value, abs=1e-12)
        assert np.linalg.norm(np.subtract(*found.points)) == pytest.approx(found.upper, abs=1e-12)
        assert np.allclose(way.at(start, found.fraction), found.pose, atol=1e-12)
        spans = np.searchsorted(found.edges, np.linspace(0, 1, 2001)[1:-1], side="right") - 1
        assert (gaps[1:-1] >= found.lowers[spans] - 1e-12).all()
        middle = np.array([way.at(start, share) for share in found.fractions])
        assert (post.distance_batch(tool, middle).values <= found.uppers + 1e-12).all()


def test_the_least_gap_of_a_swing_is_that_of_the_closed_form(post: feeler.Scene, tool: feeler.Tool) -> None:
    start = feeler.Screw(Z, (0, 0, 0), -0.6).at(STILL)
    found = post.clearance_along(tool, start, feeler.Screw(Z, (0, 0, 0), 1.3), 1e-6)
    closed = 2.0 - math.hypot(1.0, 0.01)  # a corner on its circle
    assert found.lower <= closed <= found.upper + 1e-12
    assert found.upper - found.lower <= 1e-6
    assert found.part == 0


def test_a_way_into_a_part_has_no_gap(post: feeler.Scene, tool: feeler.Tool) -> None:
    found = post.clearance_along(tool, STILL, feeler.Slide((3.0, 0, 0)))
    assert found.lower == found.upper == 0.0
    far = post.clearance_along(tool, STILL, feeler.Slide((0.0, 0.1, 0)), within=0.5)
    assert far.lower <= 0.5
    assert far.upper == math.inf
    assert far.part is None
    assert far.points is None
    with pytest.raises(feeler.OptionError, match="error"):
        post.clearance_along(tool, STILL, feeler.Slide((3.0, 0, 0)), 0.0)
