"""One pose: every function takes the same forms, and refuses others in the same words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import feeler
from feeler.poses import PoseLike, one_pose
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import plain_pose


class _Transform:
    def as_matrix(self) -> np.ndarray:
        return PLACE


class _Buffer:
    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        return np.asarray(PLACE, dtype=dtype)


PLACE = np.array([[0.0, -1, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, 0.5], [0, 0, 0, 1]])
FORMS = {
    "array": PLACE,
    "rows": PLACE.tolist(),
    "pair": (PLACE[:3, :3], PLACE[:3, 3]),
    "list": [PLACE[:3, :3], PLACE[:3, 3]],
    "as_matrix": _Transform(),
    "__array__": _Buffer(),
}
NO_POSES = {
    "stack": np.stack([PLACE, PLACE]),
    "none": None,
    "dict": {},
    "text": "here",
    "three": (PLACE[:3, :3], PLACE[:3, 3], 1),
    "swapped": (PLACE[:3, 3], PLACE[:3, :3]),
}
TRIANGLE = feeler.Tool([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
MOCKUP = feeler.Mockup([[0.0, 0, -9], [9, 0, -9], [0, 9, -9]], [[0, 1, 2]])
SCENE = feeler.Scene(MOCKUP)


def _targets(pose: object) -> object:
    return feeler.access(SCENE, TRIANGLE, pose, angles=4, approach=0.001)[0].pose


def _grip(pose: object) -> object:
    return feeler.access(SCENE, TRIANGLE, [np.eye(4)], angles=4, approach=0.001, grip=pose)[0].pose


def _body(pose: object) -> object:
    return feeler.io.body_of(TRIANGLE, pose=pose).vertices


def _assembly(pose: object) -> object:
    return feeler.Tool.assembly({"a": (TRIANGLE, pose)}).vertices


TAKERS = {
    "distance": lambda pose: SCENE.distance(TRIANGLE, pose).value,
    "assembly": _assembly,
    "targets": _targets,
    "grip": _grip,
    "body_of": _body,
    "nearest_rigid": feeler.nearest_rigid,
    "view": lambda pose: motion.checked(pose, "pose"),
    "place": lambda pose: motion.checked(plain_pose(pose), "pose"),
    "one_pose": one_pose,
}


@pytest.mark.parametrize("take", TAKERS.values(), ids=TAKERS)
def test_a_pose_of_each_form_is_the_same_pose(take: Callable[[object], object]) -> None:
    expected = take(FORMS["array"])
    for form, pose in FORMS.items():
        assert np.array_equal(take(pose), expected), form


@pytest.mark.parametrize("take", TAKERS.values(), ids=TAKERS)
def test_other_values_are_refused_without_the_words_of_numpy(take: Callable[[object], object]) -> None:
    for form, value in NO_POSES.items():
        if form == "stack" and take in (_targets, feeler.nearest_rigid):
            continue  # these take several
        if value is None and take in (_grip, _body):
            continue
        with pytest.raises((feeler.PoseError, feeler.OptionError, feeler.WorkbenchError)) as error:
            take(value)
        assert "inhomogeneous" not in str(error.value), form


def test_a_query_of_many_poses_says_how_pairs_are_given() -> None:
    turns, shifts = np.stack([np.eye(3)] * 3), np.zeros((3, 3))
    with pytest.raises(feeler.PoseError, match=r"list\(zip\(rotations, translations\)\)"):
        SCENE.collide_batch(TRIANGLE, (turns, shifts))
    with pytest.raises(feeler.PoseError, match=r"one pose, a pair .*: give a list of poses, \[pose\]"):
        SCENE.collide_batch(TRIANGLE, (turns[0], shifts[0]))
    assert len(SCENE.collide_batch(TRIANGLE, list(zip(turns, shifts, strict=True)))) == 3


@pytest.mark.parametrize("none", [[], ()])
def test_no_poses_are_an_empty_batch(none: list[PoseLike] | tuple[PoseLike, ...]) -> None:
    """A list comprehension may keep nothing."""
    assert feeler.nearest_rigid(none).shape == (0, 4, 4)
    for ask in (SCENE.collide_batch, SCENE.distance_batch, SCENE.clearance_batch):
        assert len(ask(TRIANGLE, none)) == 0
    with pytest.raises(feeler.PoseError):
        SCENE.collide(TRIANGLE, none)  # type: ignore[arg-type]


def test_a_stack_for_one_pose_says_how_many_it_has() -> None:
    with pytest.raises(feeler.PoseError, match=r"start has shape \(2, 4, 4\), which are 2 poses"):
        one_pose(NO_POSES["stack"], "start")
