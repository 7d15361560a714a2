"""Ways into a place: that of a removal turned round, also from where the parts lie."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from shapes import box, mockup_of

import feeler

Floats = npt.NDArray[np.float64]

# A pocket that is open above, with a peg in it, and a tray beside it, which is open above too.
POCKET = {
    "floor": box([-0.03, -0.03, -0.01], [0.03, 0.03, 0.0]),
    "left": box([-0.03, -0.03, 0.0], [-0.011, 0.03, 0.05]),
    "right": box([0.011, -0.03, 0.0], [0.03, 0.03, 0.05]),
    "front": box([-0.011, -0.03, 0.0], [0.011, -0.011, 0.05]),
    "back": box([-0.011, 0.011, 0.0], [0.011, 0.03, 0.05]),
}
TRAY = {
    "tray": box([0.1, -0.03, -0.01], [0.2, 0.03, 0.0]),
    "wall": box([0.1, -0.03, 0.0], [0.11, 0.03, 0.03]),
}
PEG = box([-0.01, -0.01, 0.001], [0.01, 0.01, 0.04])


def scene_of(**more: object) -> feeler.Scene:
    return feeler.Scene(mockup_of({"peg": PEG, **POCKET, **TRAY, **more}))


def lying() -> Floats:
    """In the tray, on its side."""
    pose = np.eye(4)
    pose[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    pose[:3, 3] = [0.15, 0.02, 0.011]
    return pose


def check(scene: feeler.Scene, found: feeler.Removal) -> None:
    """It is free by casts along its legs and along its poses, and leads to the place."""
    tool, rest = feeler.Tool.of_parts(scene.mockup, "peg"), scene.without("peg")
    np.testing.assert_allclose(found.poses[-1], np.eye(4), atol=1e-12)
    np.testing.assert_allclose(found.legs[-1].pose, np.eye(4), atol=1e-12)
    assert rest.check_path(tool, found.path, touching="free").is_free
    assert rest.check_path(tool, found.poses, touching="free").is_free
    assert sum(leg.path_length for leg in found.legs) == pytest.approx(found.path_length)


def test_a_peg_goes_down_into_its_pocket() -> None:
    scene = scene_of()
    out, found = feeler.removal(scene, "peg"), feeler.insertion(scene, "peg")
    assert found.is_found
    np.testing.assert_array_equal(found.poses, out.poses[::-1])
    assert [str(leg) for leg in found.legs] == [str(leg).replace("+z", "-z") for leg in out.legs]
    check(scene, found)


@pytest.mark.parametrize("options", [{}, {"clearance": 0.0005}])
def test_a_peg_goes_from_a_tray_into_its_pocket(options: dict[str, float]) -> None:
    scene = scene_of()
    found = feeler.insertion(scene, "peg", start=lying(), seconds=60.0, **options)  # type: ignore[arg-type]
    assert found.is_found and len(found.legs) >= 3
    np.testing.assert_allclose(found.poses[0], lying(), atol=1e-12)
    assert found.rotation == pytest.approx(np.pi / 2, abs=0.2)
    check(scene, found)


def test_a_lid_on_either_end_is_told() -> None:
    lid = box([-0.03, -0.03, 0.05], [0.03, 0.03, 0.06])
    closed = feeler.insertion(scene_of(lid=lid), "peg", start=lying(), seconds=2.0)
    assert not closed.is_found and "lid" in [each.path for each in closed.blocked_by]
    # The tray as a closed box.
    shell = {
        "sides": box([0.19, -0.03, 0.0], [0.2, 0.03, 0.03]),
        "near": box([0.11, -0.03, 0.0], [0.19, -0.025, 0.03]),
        "far": box([0.11, 0.025, 0.0], [0.19, 0.03, 0.03]),
        "cover": box([0.1, -0.03, 0.03], [0.2, 0.03, 0.04]),
    }
    shut = feeler.insertion(scene_of(**shell), "peg", start=lying(), seconds=2.0)
    assert not shut.is_found and shut.legs == () and "cover" in [each.path for each in shut.blocked_by]
    np.testing.assert_allclose(shut.poses, lying()[None], atol=1e-12)


@pytest.mark.parametrize("start", [np.diag([2.0, 1, 1, 1]), np.eye(3), np.zeros((2, 4, 4)), np.full((4, 4), np.nan)])
def test_a_start_that_is_no_pose_is_an_error(start: Floats) -> None:
    with pytest.raises(feeler.PoseError):
        feeler.insertion(scene_of(), "peg", start=start)


def test_a_goal_beside_the_place_is_reached() -> None:
    scene = scene_of()
    goal = lying()
    found = feeler.insertion(scene, "peg", start=np.eye(4), goal=goal, seconds=60.0)
    assert found.is_found
    np.testing.assert_allclose(found.poses[0], np.eye(4), atol=1e-12)
    np.testing.assert_allclose(found.poses[-1], goal, atol=1e-12)
    tool, rest = feeler.Tool.of_parts(scene.mockup, "peg"), scene.without("peg")
    assert rest.check_path(tool, found.path, touching="free").is_free
    # From outside.
    alone = feeler.insertion(scene, "peg", goal=goal)
    assert alone.is_found
    np.testing.assert_allclose(alone.poses[-1], goal, atol=1e-12)
    assert rest.check_path(tool, alone.path, touching="free").is_free


def test_a_hand_that_holds_the_part_comes_along() -> None:
    scene = scene_of()
    # A plate on the peg, wider than the pocket: it stays above it, and leaves the tray only with the peg upright.
    hand = feeler.Tool(*box([-0.02, -0.02, 0.0], [0.02, 0.02, 0.01]))
    grip = np.eye(4)
    grip[2, 3] = 0.055
    found = feeler.insertion(scene, "peg", tool=hand, grip=grip)
    assert found.is_found
    held = feeler.Tool.assembly({"peg": feeler.Tool.of_parts(scene.mockup, "peg"), "hand": (hand, grip)})
    assert scene.without("peg").check_path(held, found.path, touching="free").is_free
    low = np.eye(4)
    low[2, 3] = 0.045
    with pytest.raises(feeler.PoseError, match="collides with"):
        feeler.insertion(scene, "peg", tool=hand, grip=low)
    with pytest.raises(feeler.OptionError, match="no tool"):
        feeler.insertion(scene, "peg", grip=grip)
    # Where the tray is in the way of the hand, and not of the peg.
    in_tray = lying()
    in_tray[1, 3] = 0.05
    with pytest.raises(feeler.PoseError, match="tray"):
        feeler.insertion(scene, "peg", goal=in_tray, tool=hand, grip=grip)
    assert feeler.insertion(scene, "peg", goal=in_tray).is_found


def boxed(play: float) -> feeler.Scene:
    """A block with this play to each of six walls."""
    far = 0.01 + play
    walls = {
        f"{'xyz'[axis]}{side}": box(
            [-0.02 if a != axis else (far if side else -0.02) for a in range(3)],
            [0.02 if a != axis else (0.02 if side else -far) for a in range(3)],
        )
        for axis in range(3)
        for side in (0, 1)
    }
    return feeler.Scene(mockup_of({"core": box([-0.01] * 3, [0.01] * 3), **walls}))


def test_a_part_that_is_held_moves_within_its_play() -> None:
    scene = boxed(0.0001)
    for shift in ([0.00006, 0.0, 0.0], [-0.00005, 0.00004, 0.00006]):
        start = np.eye(4)
        start[:3, 3] = shift
        found = feeler.insertion(scene, "core", start=start)
        assert found.is_found and len(found.legs) == 1 and found.held_by == ()
        assert found.path_length == pytest.approx(np.linalg.norm(shift))
    # With a clearance the straight path is not tried. That the part is held says nothing of motions within its play.
    start[:3, 3] = [0.00006, 0.0, 0.0]
    within = feeler.insertion(scene, "core", start=start, clearance=0.00002, seconds=5.0)
    assert not within.is_found and within.held_by == () and np.isnan(within.play)
    # Farther than its play: there is no path, and that is shown.
    outside = np.eye(4)
    outside[0, 3] = 0.1
    held = feeler.insertion(scene, "core", start=outside)
    assert not held.is_found and len(held.held_by) == 6 and held.play < 0.001
    # Where it is there is nothing to do.
    there = feeler.insertion(scene, "core", start=np.eye(4))
    assert there.is_found and there.legs == () and there.path_length == 0.0


def test_progress_of_both_searches_is_one() -> None:
    told: list[float] = []
    feeler.insertion(scene_of(), "peg", start=lying(), seconds=20.0, progress=lambda share, _: told.append(share))
    assert told == sorted(told) and told[0] >= 0.0 and told[-1] <= 1.0


def test_errors_name_what_they_are_about() -> None:
    scene, hand = scene_of(), feeler.Tool(*box([-0.02, -0.02, 0.0], [0.02, 0.02, 0.01]))
    bent = np.diag([2.0, 1, 1, 1])
    for options, said in (
        ({"goal": "up"}, "goal is .up.: give real numbers"),
        ({"goal": bent}, "goal: the pose is not rigid"),
        ({"start": bent}, "start: the pose is not rigid"),
        ({"tool": hand, "grip": np.eye(3)}, "grip has shape"),
    ):
        with pytest.raises(feeler.PoseError, match=said):
            feeler.insertion(scene, "peg", **options)  # type: ignore[arg-type]
