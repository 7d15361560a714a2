"""`feeler.from_urdf`: links where the joints put them, each geometry a part."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import feeler
from feeler.interchange import shapes

QUARTER = math.pi / 2


@pytest.fixture
def arm(testdata: Path) -> Path:
    return testdata / "urdf" / "arm.urdf"


def bounds(mockup: feeler.Mockup) -> dict[str, list[list[float]]]:
    return {part.path: np.round([part.lower, part.upper], 9).tolist() for part in mockup.parts}


def volume(mockup: feeler.Mockup, part: int) -> float:
    """Positive where the triangles face outwards."""
    a, b, c = np.moveaxis(mockup.vertices[mockup.faces[mockup.part_of_face == part]], 1, 0)
    return float(np.einsum("ij,ij->", a - a[0], np.cross(b - a[0], c - a[0])) / 6)


def robot(tmp_path: Path, body: str, name: str = "robot.urdf") -> Path:
    file = tmp_path / name
    file.write_text(f'<robot name="r">{body}</robot>')
    return file


BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'


def joint(name: str, parent: str, child: str, inside: str = "", kind: str = "revolute") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def link(name: str, inside: str = BOX) -> str:
    return f'<link name="{name}">{inside}</link>'


def test_links_are_parts_at_their_neutral_places(arm: Path) -> None:
    mockup = feeler.from_urdf(arm)
    found = bounds(mockup)
    assert list(found) == ["base/plate", "base/cylinder", "arm/cylinder", "slide/wedge", "finger/sphere"]
    assert found["base/plate"] == [[-0.2, -0.15, -0.05], [0.2, 0.15, 0.05]]
    assert found["arm/cylinder"] == [[0, -0.02, 0.58], [1, 0.02, 0.62]]
    # reach is at its lower limit, 0.25, since 0 is beyond it; grip follows: 0.2 - 0.5 * 0.25 = 0.075.
    assert found["slide/wedge"] == [[0.25, 0, 0.6], [0.35, 0.1, 0.7]]
    assert found["finger/sphere"] == [[0.22, 0.045, 0.57], [0.28, 0.105, 0.63]]
    report = str(mockup.report)
    assert "unit m (URDF is in metres)" in report and "joint 'reach' is at 0.25, its limit" in report
    assert "1 link without collision geometry" in report and "wedge.stl" in report
    assert mockup.report.source.format == "URDF" and not mockup.report.not_queried
    for part in range(len(mockup.parts)):
        assert volume(mockup, part) > 0


def test_joints_move_what_hangs_on_them(arm: Path) -> None:
    found = bounds(feeler.from_urdf(arm, {"turn": QUARTER, "reach": 0.5}))
    assert found["base/plate"] == [[-0.2, -0.15, -0.05], [0.2, 0.15, 0.05]]
    assert found["arm/cylinder"] == [[-0.02, 0, 0.58], [0.02, 1, 0.62]]
    assert found["slide/wedge"] == [[-0.1, 0.5, 0.6], [0, 0.6, 0.7]]
    # The middle of the finger: 0.5 along the arm, grip 0.2 - 0.5 * 0.5 = -0.05 across it.
    assert found["finger/sphere"] == [[0.02, 0.47, 0.57], [0.08, 0.53, 0.63]]


def test_visual_geometry_and_a_scale_that_mirrors(arm: Path) -> None:
    mockup = feeler.from_urdf(arm, geometry="visual")
    assert bounds(mockup) == {
        "base/box": [[-0.5] * 3, [0.5] * 3],
        "slide/shell": [[0.15, 0, 0.6], [0.25, 0.1, 0.7]],
    }
    assert volume(mockup, 1) == pytest.approx(1e-3 / 6), "turned, so that outside stays outside"


def test_a_robot_can_be_the_tool(arm: Path) -> None:
    tool = feeler.Tool(feeler.from_urdf(arm), name="arm")
    assert tool.triangle_count == feeler.from_urdf(arm).triangle_count and tool.name == "arm"


def test_values_beyond_limits_are_taken_and_noted(arm: Path) -> None:
    mockup = feeler.from_urdf(arm, {"reach": 2})
    assert bounds(mockup)["slide/wedge"][0] == [2, 0, 0.6]
    assert "joint 'reach' is at 2, beyond its limits 0.25 to 1" in mockup.report.source.notes


def test_round_shapes_are_within_the_tolerance(tmp_path: Path) -> None:
    round_ones = (
        link("a", '<collision><geometry><cylinder radius="0.2" length="1"/></geometry></collision>')
        + link("b", '<collision><geometry><sphere radius="0.2"/></geometry></collision>')
        + joint("j", "a", "b", kind="fixed")
    )
    file = robot(tmp_path, round_ones)
    for tolerance in (1e-2, 1e-3, 1e-4):
        mockup = feeler.from_urdf(file, chord_tolerance=tolerance)
        for part, axes in ((0, 2), (1, 3)):
            corners = mockup.vertices[mockup.faces[mockup.part_of_face == part]]
            assert np.linalg.norm(corners[..., :axes], axis=-1).max() <= 0.2 + 1e-12
            shares = np.array([[i, j, 8 - i - j] for i in range(9) for j in range(9 - i)]) / 8
            inside = np.linalg.norm((shares @ corners)[..., :axes], axis=-1)
            lids = np.ptp(corners[..., 2], axis=1) < 1e-12 if part == 0 else np.zeros(len(corners), bool)
            assert inside[~lids].min() >= 0.2 - 1.001 * tolerance
        # Closed: every edge is there once in each direction.
        directed = np.concatenate([mockup.faces[:, [i, (i + 1) % 3]] for i in range(3)])
        assert len(np.unique(directed, axis=0)) == len(directed)
        assert {tuple(e) for e in directed.tolist()} == {tuple(e) for e in directed[:, ::-1].tolist()}
    coarse = feeler.from_urdf(file, chord_tolerance=1e-9)
    assert any("inside of the round one" in note for note in coarse.source.notes)
    assert shapes.segments(0.1, 1.0) == shapes.LEAST_SEGMENTS


def test_packages_are_found(arm: Path, tmp_path: Path) -> None:
    wedge = (arm.parent / "meshes" / "wedge.stl").read_bytes()

    def description(name: str) -> str:
        return link("a", f'<collision><geometry><mesh filename="{name}"/></geometry></collision>')

    package = tmp_path / "ws" / "my_robot"
    (package / "urdf").mkdir(parents=True)
    (package / "mesh files").mkdir()
    (package / "mesh files" / "w.stl").write_bytes(wedge)
    inside = robot(package / "urdf", description("package://my_robot/mesh%20files/w.stl"))
    assert feeler.from_urdf(inside).triangle_count == 4, "the package is a folder above"
    outside = robot(tmp_path, description("package://my_robot/mesh files/w.stl"))
    for dirs in ([tmp_path / "ws"], [package], {"my_robot": package}, str(package)):
        assert feeler.from_urdf(outside, package_dirs=dirs).triangle_count == 4
    with pytest.raises(feeler.MissingFileError, match=r"link 'a': its mesh 'package://my_robot/.*package_dirs"):
        feeler.from_urdf(outside)
    for name in (f"file://{package}/mesh files/w.stl", f"{package}/mesh files/w.stl", "ws/my_robot/mesh files/w.stl"):
        assert feeler.from_urdf(robot(tmp_path, description(name))).triangle_count == 4
    with pytest.raises(feeler.LoadError, match="not on this machine"):
        feeler.from_urdf(robot(tmp_path, description("https://example.org/w.stl")))


def test_parts_of_a_mesh_file_stay_parts(tmp_path: Path) -> None:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    (tmp_path / "two.obj").write_text(f"{corners}o left\nf 1 2 3\no right\nf 1 2 4\n")
    mesh = '<geometry><mesh filename="two.obj" scale="2"/></geometry>'
    file = robot(
        tmp_path, link("a", f'<collision name="hull">{mesh}</collision><collision name="hull">{mesh}</collision>')
    )
    mockup = feeler.from_urdf(file)
    assert mockup.part_paths == ("a/hull/left", "a/hull/right", "a/hull/left#2", "a/hull/right#2")
    assert mockup.bounds.tolist() == [[0, 0, 0], [2, 2, 2]], "a number in OBJ is a metre, times the scale"


def test_mimicking_joints_follow_through_others(tmp_path: Path) -> None:
    def moves(name: str, leader: str = "") -> str:
        mimic = f'<mimic joint="{leader}" multiplier="2" offset="1"/>' if leader else ""
        return f'<axis xyz="0 0 1"/>{mimic}'

    file = robot(
        tmp_path,
        "".join(link(name) for name in "abcd")
        + joint("j1", "a", "b", moves("j1"), "prismatic")
        + joint("j2", "a", "c", moves("j2", "j1"), "prismatic")
        + joint("j3", "a", "d", moves("j3", "j2"), "prismatic"),
    )
    heights = [part.lower[2] + 0.5 for part in feeler.from_urdf(file, {"j1": 3}).parts]
    assert heights == [0, 3, 7, 15]


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({"elbow": 1}, "no joint 'elbow'; those that move are turn, reach"),
        ({"grip": 1}, "'grip' follows 'reach'"),
        ({"mount": 1}, "'mount' is fixed"),
        ({"turn": "far"}, "one number"),
        ({"turn": [1, 2]}, "one number"),
        ({"turn": math.nan}, "finite"),
        ([0.1, 0.2], "a dict of joint names"),
    ],
)
def test_joints_that_cannot_be(arm: Path, joints: Any, message: str) -> None:
    with pytest.raises(feeler.OptionError, match=message):
        feeler.from_urdf(arm, joints)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"geometry": "both"}, "geometry is 'both': choose collision, visual"),
        ({"chord_tolerance": 0}, "chord_tolerance"),
        ({"chord_tolerance": math.nan}, "chord_tolerance"),
    ],
)
def test_options_are_checked(arm: Path, options: Any, message: str) -> None:
    with pytest.raises(feeler.OptionError, match=message):
        feeler.from_urdf(arm, **options)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (link("a", ""), "no link has collision geometry; try geometry='visual'"),
        ("", "no link"),
        (link("a") + link("a"), "two links have the same name"),
        (link("a") + joint("j", "a", "b"), "names the link 'b', which is not there"),
        (link("a") + link("b") + joint("j", "a", "b") + joint("k", "a", "b"), "child of two joints"),
        (link("a") + link("b") + link("c") + joint("j", "b", "c") + joint("k", "c", "b"), "in a circle of joints"),
        (link("a") + link("b") + link("c") + joint("j", "a", "b") + joint("j", "a", "c"), "two joints have the same"),
        (link("a") + link("b") + joint("j", "a", "b", kind="ball"), "type 'ball'"),
        (link("a") + link("b") + joint("j", "a", "b", '<axis xyz="0 0 0"/>'), "joint 'j': its axis is '0 0 0'"),
        (
            link("a") + link("b") + joint("j", "a", "b", '<mimic joint="k" multiplier="1" offset="0"/>'),
            "mimics 'k', which is not there",
        ),
        (
            link("a") + link("b") + joint("j", "a", "b", '<mimic joint="j" multiplier="1" offset="0"/>'),
            "mimics it in turn",
        ),
        (
            link("a", '<collision><geometry><box size="1 1"/></geometry></collision>'),
            "size of its box is '1 1': 3 finite numbers",
        ),
        (link("a", '<collision><geometry><sphere radius="-1"/></geometry></collision>'), "1 positive lengths"),
        (
            link("a", '<collision><geometry><cone radius="1"/></geometry></collision>'),
            "<cone>: box, cylinder, sphere, capsule and mesh",
        ),
        (link("a", "<collision/>"), "<collision> has no <geometry>"),
        (link("a", '<visual><geometry><mesh filename="a" scale="1 0 1"/></geometry></visual>'), "none 0"),
        (link("a", '<visual><origin xyz="0 0"/><geometry><box size="1 1 1"/></geometry></visual>'), "xyz of an origin"),
        (
            link("a", '<collision><geometry><sphere radius="big"/></geometry></collision>'),
            "radius of its sphere is 'big'",
        ),
        (link("a", '<collision><geometry><cylinder radius="1"/></geometry></collision>'), "radius and length of its"),
        (link(""), "link 0 of the file has no name"),
        (link("a") + '<joint name="j" type="fixed"/>', "does not name the links"),
        (link("a") + link("b") + joint("j", "a", "b", '<limit lower="x"/>'), "its limit is 'x'"),
        (link("a", '<collision><geometry><mesh filename=""/></geometry></collision>'), "no filename"),
        (link("a", '<xacro:macro xmlns:xacro="x"/>'), "xacro robot.urdf"),
        (link("${prefix}a"), "this is xacro"),
        (link("a") + "<", "the XML cannot be read"),
    ],
)
def test_robots_that_cannot_be(tmp_path: Path, body: str, message: str) -> None:
    with pytest.raises(feeler.LoadError, match=message):
        feeler.from_urdf(robot(tmp_path, body))


def test_files_that_are_no_urdf(tmp_path: Path) -> None:
    other = tmp_path / "other.urdf"
    other.write_text("<sdf/>")
    with pytest.raises(feeler.LoadError, match="begins with <sdf>"):
        feeler.from_urdf(other)
    other.write_text('<!DOCTYPE robot [<!ENTITY a SYSTEM "/etc/passwd">]><robot name="&a;"/>')
    with pytest.raises(feeler.LoadError, match="document type"):
        feeler.from_urdf(other)
    with pytest.raises(feeler.MissingFileError, match="does not exist"):
        feeler.from_urdf(tmp_path / "missing.urdf")
    with pytest.raises(feeler.MissingFileError, match="is a folder"):
        feeler.from_urdf(tmp_path)
    (tmp_path / "empty.stl").write_text("solid a\nendsolid a\n")
    mesh = '<collision><geometry><mesh filename="empty.stl"/></geometry></collision>'
    with pytest.raises(feeler.LoadError, match=r"link 'a': .*empty\.stl.* no triangle"):
        feeler.from_urdf(robot(tmp_path, link("a", mesh)))


def test_limits_that_say_nothing_hold_nothing(tmp_path: Path) -> None:
    for limit in ('<limit effort="1" velocity="1"/>', '<limit lower="0" upper="0"/>', ""):
        file = robot(tmp_path, link("a") + link("b") + joint("j", "a", "b", limit, "prismatic"))
        mockup = feeler.from_urdf(file, {"j": 2})
        assert mockup.parts[1].lower[0] == 1.5 and not mockup.source.notes


def test_a_capsule_is_a_cylinder_between_two_half_spheres(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    shape = '<collision><geometry><capsule radius="0.1" length="0.5"/></geometry></collision>'
    path.write_text(f"<robot name='arm'>{link('a', shape)}</robot>")
    robot = feeler.from_urdf(path, chord_tolerance=1e-4)
    np.testing.assert_allclose(robot.bounds, [[-0.1, -0.1, -0.35], [0.1, 0.1, 0.35]], atol=1e-4)
    corners = robot.vertices[robot.faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert volume == pytest.approx(np.pi * 0.01 * 0.5 + 4.0 / 3.0 * np.pi * 0.001, rel=0.004)
    axis = np.clip(robot.vertices[:, 2], -0.25, 0.25)
    off = np.linalg.norm(robot.vertices - np.column_stack([0.0 * axis, 0.0 * axis, axis]), axis=1)
    np.testing.assert_allclose(off, 0.1, atol=1e-12)
    tool = feeler.Tool(robot)
    assert feeler.Scene(feeler.Mockup(robot)).containment(tool, np.eye(4)) is not None
