"""`scene.depth`: how deep a tool is in each part, against closed forms and bounds in plain Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from clash.cases import turned
from clash_scene import open_box
from point_depths import depth_bounds, quartered
from shapes import Mesh, at, box, cube, inverted, joined, mockup_of, tool_of

import feeler
from feeler import Depths
from feeler.depths import deepest, deepest_within
from feeler.errors import MeshError, OptionError, PoseError

Floats = npt.NDArray[np.float64]

HERE = np.eye(4)
# Rounding of lengths near the origin, metres.
ROUNDING = 1e-13


def scene_of(**parts: Mesh) -> feeler.Scene:
    return feeler.Scene(mockup_of(parts))


def assert_depth(found: Depths, depth: float, *, row: int = 0, rounding: float = ROUNDING) -> None:
    """The true depth is within the bounds, which are as close as promised."""
    low, error = float(found.depths[row]), float(found.errors[row])
    assert low <= depth + rounding and depth <= low + error + rounding, (low, error, depth)
    assert 0.0 <= error <= max(1e-9, 1e-3 * low)


def turn(rng: np.random.Generator) -> Floats:
    """A random rotation."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    rotation: Floats = q * np.sign(np.linalg.det(q))
    return rotation


def pose_of(rotation: Floats, translation: Any) -> Floats:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    return pose


def refined(mesh: Mesh) -> Mesh:
    """Each triangle cut in four, with a corner of its own for each triangle."""
    corners = quartered(mesh[0][mesh[1]])
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


# --- closed forms -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sunk", [1e-6, 0.01, 0.04, 0.09])
def test_a_cube_in_a_slab_is_as_deep_as_it_is_sunk(sunk: float) -> None:
    scene = scene_of(slab=box((-1, -1, -1), (1, 1, 0)))
    found = scene.depth(tool_of({"cube": cube((0, 0, 0.05), 0.1)}), at(z=-sunk))
    assert found.parts.tolist() == [0] and found.tool_parts.tolist() == [0]
    assert_depth(found, sunk)
    assert found.points_on_tool[0, 2] == pytest.approx(-sunk, abs=1e-12)
    assert found.points_on_mockup[0, 2] == pytest.approx(0.0, abs=1e-12)
    assert not found.is_estimate[0]


def test_a_cube_inside_a_slab_is_measured_to_the_nearest_side() -> None:
    scene = scene_of(slab=box((-1, -1, -1), (1, 1, 0)))
    # From 0.3 to 0.4 below the top.
    found = scene.depth(tool_of({"cube": cube((0, 0, 0), 0.1)}), at(z=-0.35))
    assert_depth(found, 0.4)
    assert not scene.collide(tool_of({"cube": cube((0, 0, 0), 0.1)}), at(z=-0.35)).pairs.size


def test_a_tool_around_a_part_is_as_deep() -> None:
    scene = scene_of(core=cube((0, 0, -0.35), 0.1))
    found = scene.depth(tool_of({"slab": box((-1, -1, -1), (1, 1, 0))}), HERE)
    assert_depth(found, 0.4)


@pytest.mark.parametrize("far", [0.0, 3000.0])
@pytest.mark.parametrize("phase", [0.0, 0.3])
def test_a_pin_pressed_into_its_hole_is_as_deep_as_it_is_too_thick(far: float, phase: float) -> None:
    sides, press = 48, 1e-5
    bore = turned(sides, [(0.01, 0.0), (0.03, 0.0), (0.03, 0.05), (0.01, 0.05), (0.01, 0.0)])
    pin = turned(sides, [(0, -0.01), (0.01 + press, -0.01), (0.01 + press, 0.06), (0, 0.06)])
    scene = scene_of(bore=(bore[0] + far, bore[1]))
    angle = phase * 360.0 / sides
    found = scene.depth(tool_of({"pin": pin}), at(far, far, far, degrees=angle))
    # A corner of the pin is this far outside the polygon of the hole. Corners of the hole are less deep in the pin.
    rounding = 64 * np.spacing(far + 1.0)
    if phase == 0.0:
        assert_depth(found, press, rounding=rounding)
    else:
        step = 2 * np.pi / sides
        off = abs(phase * step - step / 2)
        depth = (0.01 + press) * np.cos(off) - 0.01 * np.cos(step / 2)
        assert_depth(found, depth, rounding=rounding)


def test_a_tool_far_off_and_turned_is_as_deep_as_at_the_origin(rng: np.random.Generator) -> None:
    slab, pick = box((-1, -1, -1), (1, 1, 0)), cube((0, 0, 0.05), 0.1)
    for far in (3e3, 65e3):
        rotation, shift = turn(rng), far * np.array([1.0, -1.0, 1.0])
        scene = scene_of(slab=(slab[0] @ rotation.T + shift, slab[1]))
        pose = pose_of(rotation, shift + rotation @ [0.2, 0.1, -0.0375])
        rounding = 64 * float(np.spacing(far))
        assert_depth(scene.depth(tool_of({"pick": pick}), pose), 0.0375, rounding=rounding)


def test_a_bar_right_through_a_plate() -> None:
    scene = scene_of(plate=box((0, 0, 0), (1, 1, 0.1)))
    bar = tool_of({"bar": box((0.4, 0.4, -1), (0.6, 0.6, 1.1))})
    # Points of the plate are up to 0.1 from the sides of the bar, points of the bar 0.05 from those of the plate.
    assert_depth(scene.depth(bar, HERE), 0.1)


def test_a_hollow_is_outside() -> None:
    block = joined(box((0, 0, 0), (4, 4, 4)), inverted(box((1, 1, 1), (3, 3, 3))))
    scene = scene_of(block=block)
    assert len(scene.depth(tool_of({"free": cube((2, 2, 2), 1.0)}), HERE)) == 0
    # The far side of the cube is 0.25 in the wall.
    assert_depth(scene.depth(tool_of({"cube": cube((2, 2, 2), 1.0)}), at(x=0.75)), 0.25)


def test_touching_parts_have_no_depth() -> None:
    scene = scene_of(slab=box((-1, -1, -1), (1, 1, 0)))
    for angle in (0.0, 30.0):
        found = scene.depth(tool_of({"cube": cube((0, 0, 0.0625), 0.125)}), at(degrees=angle))
        assert found.parts.tolist() == [0] and found.depths.tolist() == [0.0]
        assert found.errors[0] <= 1e-9
        assert found.points_on_tool[0, 2] == found.points_on_mockup[0, 2] == 0.0
        assert np.abs(found.points_on_tool[0]).max() < 0.1
    assert len(scene.depth(tool_of({"cube": cube((0, 0, 0.0625), 0.125)}), at(z=1e-9))) == 0


def test_the_same_place_is_no_depth() -> None:
    scene = scene_of(cube=cube((0, 0, 0), 1.0))
    found = scene.depth(tool_of({"cube": refined(cube((0, 0, 0), 1.0))}), HERE)
    assert found.depths.tolist() == [0.0] and found.errors[0] <= 1e-9


def test_the_deepest_part_is_first_and_names_the_part_of_the_tool() -> None:
    scene = scene_of(
        low=box((-1, -1, -1), (1, 1, 0)), far=box((5, 5, 5), (6, 6, 6)), high=box((2, -1, -1), (4, 1, 0.03125))
    )
    feet = {"long": box((-0.25, -0.25, -0.0625), (0.25, 0.25, 1)), "wide": box((0.5, -0.25, -0.015625), (3, 0.25, 1))}
    found = scene.depth(tool_of(feet), HERE)
    assert found.parts.tolist() == [0, 2] and found.tool_parts.tolist() == [0, 1]
    assert_depth(found, 0.0625)
    assert_depth(found, 0.046875, row=1)
    assert repr(found) == "Depths(2 parts, the deepest 0.0625 m)" and len(found) == 2
    assert repr(scene.depth(tool_of(feet), at(z=9.0))) == "Depths(0 parts)"


# --- arguments --------------------------------------------------------------------------------------------------------


def test_depths_that_take_too_long_are_not_given() -> None:
    scene, tool = scene_of(slab=box((-1, -1, -1), (1, 1, 0))), tool_of({"cube": cube((0, 0, 0), 0.4)})
    assert deepest_within(scene, tool, HERE, 0.0) is None
    assert deepest(scene, tool, HERE) == {0: scene.depth(tool, HERE).depths[0]} != {0: 0.0}


def test_parts_are_ignored_or_not_there() -> None:
    scene = scene_of(low=box((-1, -1, -1), (1, 1, 0)), side=box((0.25, -1, -1), (1, 1, 1)))
    tool = tool_of(
        {"a": box((-0.25, -0.25, -0.0625), (0.28125, 0.25, 0.5)), "b": box((-0.9, -0.9, -0.5), (-0.5, -0.5, 1))}
    )
    assert scene.depth(tool, HERE).parts.tolist() == [0, 1]
    found = scene.depth(tool, HERE, ignore=[("b", "low")])
    assert found.parts.tolist() == [0, 1] and found.tool_parts.tolist() == [0, 0]
    assert_depth(found, 0.0625)
    found = scene.depth(tool, HERE, ignore=[("*", "low")])
    assert found.parts.tolist() == [1]
    assert scene.without("side").depth(tool, HERE).parts.tolist() == [0]
    assert scene.only("side").depth(tool, HERE).parts.tolist() == [1]
    assert len(scene.depth(tool, HERE, ignore=[("*", "*")])) == 0


def test_open_surfaces_have_an_estimate() -> None:
    scene = scene_of(block=box((0, 0, 0), (1, 1, 1)))
    sheet = np.array([[-1, -1, 0.25], [2, -1, 0.25], [2, 2, 0.25], [-1, 2, 0.25]]), np.array([[0, 1, 2], [0, 2, 3]])
    found = scene.depth(tool_of({"sheet": sheet}), HERE)
    assert found.is_estimate.tolist() == [True]
    assert_depth(found, 0.25)
    # A tub has no inside, so that a cube that crosses its wall is measured by the tub's points alone.
    tub = scene_of(tub=open_box((0, 0, 0), (1, 1, 1)))
    found = tub.depth(tool_of({"cube": cube((0, 0.5, 0.5), 0.25)}), at(x=0.03125))
    assert found.is_estimate.tolist() == [True]
    assert_depth(found, 0.125 - 0.03125)
    found = tub.depth(tool_of({"tub": open_box((0, 0, 0), (1, 1, 1))}), at(0.5, 0.25, 0.25))
    # The deepest point where two tubs cross: so far from the border of the nearer one.
    assert found.is_estimate.tolist() == [True] and np.isnan(found.errors).all()
    assert found.depths == pytest.approx([0.375])


def test_wrong_arguments() -> None:
    scene, tool = scene_of(slab=box((-1, -1, -1), (1, 1, 0))), tool_of({"cube": cube((0, 0, 0), 0.1)})
    asked: Any = scene.depth
    with pytest.raises(PoseError):
        asked(tool, np.full((4, 4), np.nan))
    with pytest.raises(PoseError):
        asked(tool, np.eye(3))
    with pytest.raises(PoseError):
        asked(tool, np.diag([2.0, 2.0, 2.0, 1.0]))
    with pytest.raises(OptionError, match="slob"):
        asked(tool, HERE, ignore=[("*", "slob")])
    with pytest.raises((TypeError, MeshError)):
        asked("cube", HERE)
    with pytest.raises(TypeError):
        asked(tool, HERE, [("*", "*")])


def test_columns_are_read_only_and_have_a_row_for_each_part() -> None:
    scene = scene_of(slab=box((-1, -1, -1), (1, 1, 0)))
    for pose, rows in ((HERE, 1), (at(z=3.0), 0)):
        found = scene.depth(tool_of({"cube": cube((0, 0, 0), 0.1)}), pose)
        columns = vars(found)
        assert {len(column) for column in columns.values()} == {rows}
        assert found.points_on_tool.shape == found.points_on_mockup.shape == (rows, 3)
        for column in columns.values():
            with pytest.raises(ValueError, match="read-only"):
                column[...] = 0


# --- properties -------------------------------------------------------------------------------------------------------


def shapes(rng: np.random.Generator) -> dict[str, tuple[Mesh, Mesh]]:
    """A part and a tool of each kind, which are in each other near the origin."""
    ring = turned(24, [(0.4, -0.25), (0.8, -0.25), (0.8, 0.25), (0.4, 0.25), (0.4, -0.25)])
    cone = turned(16, [(0, -0.5), (0.5, -0.5), (0.1, 0.5), (0, 0.5)])
    hollow = joined(cube((0, 0, 0), 1.0), inverted(cube((0, 0, 0), 0.5)))
    ends = rng.normal(size=(2, 3))
    return {
        "boxes": (box(ends.min(axis=0) - 0.3, ends.max(axis=0) + 0.3), cube((0, 0, 0), 0.5)),
        "cone in ring": (ring, cone),
        "hollow": (hollow, cone),
        "ring in ring": (ring, ring),
    }


@pytest.mark.parametrize("kind", ["boxes", "cone in ring", "hollow", "ring in ring"])
def test_depths_are_within_the_bounds_of_the_judge(kind: str, rng: np.random.Generator) -> None:
    part, own = shapes(rng)[kind]
    scene, tool = scene_of(part=part), tool_of({"own": own})
    deep = 0
    for _ in range(8):
        pose = pose_of(turn(rng), rng.uniform(-0.5, 0.5, 3))
        found = scene.depth(tool, pose)
        moved = own[0] @ pose[:3, :3].T + pose[:3, 3]
        bounds = depth_bounds(part[0][part[1]], moved[own[1]], error=0.02, most=1500)
        if len(found) == 0:
            assert bounds.low == 0.0
            continue
        low, error = float(found.depths[0]), float(found.errors[0])
        assert low <= bounds.high + ROUNDING and bounds.low <= low + error + ROUNDING
        assert 0.0 <= error <= max(1e-9, 1e-3 * low)
        apart = np.linalg.norm(found.points_on_tool[0] - found.points_on_mockup[0])
        assert apart == pytest.approx(low, rel=1e-9, abs=1e-12)
        deep += low > 0.01
    assert deep >= 3


@pytest.mark.parametrize("kind", ["boxes", "cone in ring", "hollow", "ring in ring"])
def test_a_motion_changes_a_depth_by_no_more_than_its_length(kind: str, rng: np.random.Generator) -> None:
    part, own = shapes(rng)[kind]
    scene, tool = scene_of(part=part), tool_of({"own": own})
    reach = np.linalg.norm(own[0], axis=1).max()
    for _ in range(12):
        pose = pose_of(turn(rng), rng.uniform(-0.4, 0.4, 3))
        for size in (1e-6, 1e-3):
            step, angle = rng.normal(size=3), size * rng.uniform() / reach
            step *= size / np.linalg.norm(step)
            small = at(degrees=np.degrees(angle), axis=int(rng.integers(3)))[:3, :3]
            # No point of the tool moves farther than the turn and the translation together.
            after = pose_of(small @ pose[:3, :3], pose[:3, 3] + step)
            most = size + angle * reach
            (one, one_error), (two, two_error) = (
                (each.depths[0], each.errors[0]) if len(each) else (0.0, 0.0)
                for each in (scene.depth(tool, pose), scene.depth(tool, after))
            )
            assert one - (two + two_error) <= most + ROUNDING and two - (one + one_error) <= most + ROUNDING


@pytest.mark.parametrize("kind", ["boxes", "cone in ring", "hollow", "ring in ring"])
def test_a_finer_triangulation_changes_no_depth(kind: str, rng: np.random.Generator) -> None:
    part, own = shapes(rng)[kind]
    coarse, fine = scene_of(part=part), scene_of(part=refined(part))
    tools = [tool_of({"own": mesh}) for mesh in (own, refined(refined(own)))]
    for _ in range(6):
        pose = pose_of(turn(rng), rng.uniform(-0.4, 0.4, 3))
        found = [scene.depth(tool, pose) for scene in (coarse, fine) for tool in tools]
        assert len({len(each) for each in found}) == 1
        if len(found[0]):
            # Intervals that all hold the same value share a point.
            lowest = min(each.depths[0] + each.errors[0] for each in found)
            assert max(each.depths[0] for each in found) <= lowest + ROUNDING


def test_which_of_both_is_the_tool_does_not_matter(rng: np.random.Generator) -> None:
    for part, own in shapes(rng).values():
        pose = pose_of(turn(rng), rng.uniform(-0.3, 0.3, 3))
        one = scene_of(part=part).depth(tool_of({"own": own}), pose)
        two = scene_of(own=own).depth(tool_of({"part": part}), np.linalg.inv(pose))
        assert len(one) == len(two)
        if len(one):
            assert one.depths[0] <= two.depths[0] + two.errors[0] + ROUNDING
            assert two.depths[0] <= one.depths[0] + one.errors[0] + ROUNDING
