"""Loops whose axes are parallel but for rounding, as those that `find_joint` finds on coordinates of 32 bits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapes import Mesh, box, mockup_of

from feeler import Joint, Mechanism
from feeler.errors import MechanismError


def crank_rocker(seed: int, off: float) -> tuple[Mechanism, Mechanism]:
    """A four-bar turned at random, with axes that are off by so many radians, and the exact one."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    crank, rod, rocker, ground, first = 0.05, 0.2, 0.15, 0.2, 0.7
    a, d = crank * np.array([math.cos(first), math.sin(first)]), np.array([ground, 0.0])
    far = float(np.linalg.norm(d - a))
    angle = math.atan2(*(d - a)[::-1]) + math.acos((rod**2 + far**2 - rocker**2) / (2 * rod * far))
    b = a + rod * np.array([math.cos(angle), math.sin(angle)])
    places = [np.array([*each, 0.02 * number]) for number, each in enumerate((a / 2, (a + b) / 2, (b + d) / 2))]
    meshes: dict[str, Mesh] = {"frame": box((0.5, 0.5, 0.5), (0.6, 0.6, 0.6))}
    for name, place in zip(("crank", "rod", "rocker"), places, strict=True):
        vertices, faces = box(tuple(place - 0.005), tuple(place + 0.005))
        meshes[name] = (vertices @ turn.T, faces)

    def made(by: float) -> Mechanism:
        def joint(name: str, parent: str | None, child: str, at: np.ndarray) -> Joint:
            lean = rng.normal(size=2)
            axis = turn @ np.array([*(by * lean / np.linalg.norm(lean)), 1.0])
            return Joint(name, "revolute", parent, child, tuple(axis), tuple(turn @ np.array([*at, 0.0])))

        joints = [
            joint("crank", None, "crank", np.zeros(2)),
            joint("rod", "crank", "rod", a),
            joint("rocker", None, "rocker", d),
        ]
        return Mechanism(mockup_of(meshes), joints, loops=[joint("pin", "rocker", "rod", b)])

    return made(off), made(0.0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("off", [1e-9, 1e-7, 2e-6])
def test_a_loop_with_axes_that_are_parallel_but_for_rounding_turns(seed: int, off: float) -> None:
    moved, exact = crank_rocker(seed, off)
    for angle in (0.5, 3.0, 6.0, -6.0):
        found, truth = moved.position({"crank": angle}), exact.position({"crank": angle})
        assert all(found[name] == pytest.approx(truth[name], abs=max(10 * off, 1e-9)) for name in truth)
    # What is given back is a position, and the bounds along the loop are proven.
    assert moved.position(moved.position({"crank": 2.0}))["rocker"] == pytest.approx(
        exact.position({"crank": 2.0})["rocker"], abs=max(10 * off, 1e-9)
    )
    assert moved.clearance({"crank": (0.0, 0.3)}, error=1e-2).is_certified


def test_a_loop_with_axes_that_are_not_parallel_says_by_how_much() -> None:
    moved, _ = crank_rocker(0, 0.0)
    joints = list(moved.joints)
    axis = np.array(joints[1].axis)
    aside = np.cross(axis, (1.0, 0.0, 0.0))
    leaning = axis + 1e-3 * aside / np.linalg.norm(aside)
    joints[1] = Joint("rod", "revolute", "crank", "rod", tuple(leaning), joints[1].point)
    skewed = Mechanism(moved.mockup, joints, loops=moved.loops)
    with pytest.raises(MechanismError, match=r"not parallel: 'rod' is off by 0\.001 rad \(0\.0573 degrees\)"):
        skewed.position({"crank": 0.5})
    assert skewed.joints[1].axis == joints[1].axis
