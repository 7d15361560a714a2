"""`Mechanism.from_urdf`: robots as mechanisms."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
import pytest
from shapes import box

import feeler
from feeler import Mechanism
from feeler.errors import LoadError

BOX = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
LIMIT = '<axis xyz="0 0 1"/><limit lower="-1" upper="1"/>'


def robot(tmp_path: Path, *body: str) -> Path:
    file = tmp_path / "robot.urdf"
    file.write_text(f'<robot name="r">{"".join(body)}</robot>')
    return file


def link(name: str, inside: str = BOX) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, kind: str, parent: str, child: str, inside: str = LIMIT, at: str = "0 0 0") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<origin xyz="{at}"/>{inside}</joint>'


def random_robot(tmp_path: Path, seed: int) -> tuple[Path, dict[str, float]]:
    """A tree of boxes, some without geometry, and values of its joints."""
    rng = random.Random(seed)

    def numbers(size: float) -> str:
        return " ".join(str(rng.uniform(-size, size)) for _ in range(3))

    def origin() -> str:
        return f'<origin xyz="{numbers(0.5)}" rpy="{numbers(3)}"/>'

    shape = '<geometry><box size="0.1 0.2 0.3"/></geometry>'
    body, movable = [link("l0", f"<collision>{origin()}{shape}</collision>")], []
    for i in range(1, rng.randint(3, 8)):
        body.append(link(f"l{i}", f"<collision>{origin()}{shape}</collision>" if rng.random() < 0.7 else ""))
        kind = rng.choice(["revolute", "continuous", "prismatic", "fixed"]) if i > 1 else "revolute"
        inside = "" if kind == "fixed" else f'<axis xyz="{numbers(1)}"/><limit lower="-2" upper="2"/>'
        if kind != "fixed" and movable and rng.random() < 0.3:
            inside += f'<mimic joint="{rng.choice(movable)}" multiplier="{rng.uniform(-1, 1)}" offset="0.1"/>'
        elif kind != "fixed":
            movable.append(f"j{i}")
        ends = f'<parent link="l{rng.randrange(i)}"/><child link="l{i}"/>'
        body.append(f'<joint name="j{i}" type="{kind}">{ends}{origin()}{inside}</joint>')
    return robot(tmp_path, *body), {name: rng.uniform(-0.9, 0.9) for name in movable}


def corners(mockup: feeler.Mockup) -> dict[str, np.ndarray]:
    return {
        part.path: mockup.vertices[mockup.faces[mockup.part_of_face == part.index]]
        for part in mockup.parts
        if (mockup.part_of_face == part.index).any()
    }


def test_joints_in_the_world_place_links_as_the_joints_of_the_file(tmp_path: Path) -> None:
    for seed in range(40):
        file, values = random_robot(tmp_path, seed)
        moved = corners(Mechanism.from_urdf(file).scene(values).mockup)
        expected = corners(feeler.from_urdf(file, values))
        assert moved.keys() == expected.keys()
        for path, points in moved.items():
            assert points == pytest.approx(expected[path], abs=1e-12), (seed, path)


def test_joints_keep_their_limits_and_names_and_mimics_are_couplings(testdata: Path) -> None:
    moved = Mechanism.from_urdf(testdata / "urdf" / "arm.urdf")
    assert moved.names == ("turn", "reach", "grip")
    assert [(each.parent, each.child) for each in moved.joints] == [
        (None, ("arm",)),
        (("arm",), ("slide",)),
        (("slide",), ("finger",)),
    ]
    assert moved.joints[0].point == (0.0, 0.0, 0.6) and moved.joints[0].axis == (0.0, 0.0, 1.0)
    assert moved.limits("turn") == (-3.0, 3.0) and moved.limits("reach") == (0.25, 1.0)
    assert moved.position({"reach": 0.5})["grip"] == pytest.approx(-0.05)
    # It is modelled with all joints at 0, also where 0 is beyond a limit.
    assert moved.mockup.parts[3].path == "slide/wedge" and moved.mockup.parts[3].lower[0] == 0.0
    visual = Mechanism.from_urdf(testdata / "urdf" / "arm.urdf", geometry="visual", package_dirs=[testdata / "urdf"])
    assert visual.mockup.part_paths == ("base/box", "arm", "slide/shell", "finger")


def test_links_that_are_fixed_to_each_other_are_one(tmp_path: Path) -> None:
    body = [link("a"), link("b", ""), link("c"), link("d"), link("e")]
    body += [joint("j", "revolute", "a", "b", at="1 0 0"), joint("m", "fixed", "b", "c"), joint("n", "fixed", "a", "d")]
    body += [joint("k.1", "continuous", "c", "e", '<axis xyz="0 0 2"/>', "0 1 0")]
    moved = Mechanism.from_urdf(robot(tmp_path, *body))
    assert [(each.name, each.parent, each.child) for each in moved.joints] == [
        ("j", None, ("c",)),
        ("k_1", ("c",), ("e",)),
    ]
    assert moved.limits("k_1") is None
    moved.save(tmp_path / "r.toml")
    assert Mechanism.load(tmp_path / "r.toml", moved.mockup).position({"j": 0.5}) == {"j": 0.5, "k_1": 0.0}


def test_links_without_geometry_move_what_hangs_on_them(tmp_path: Path) -> None:
    # A wrist of two axes: nothing between them. The box at 0.3 m meets the one 0.4 m up the y axis.
    body = [link("a", ""), link("b", ""), link("c"), link("w"), link("tip", "")]
    body += [joint("fix", "fixed", "a", "w", at="0 0.4 0"), joint("j", "revolute", "a", "b", '<axis xyz="0 0 1"/>')]
    body += [joint("k", "revolute", "b", "c", at="0.4 0 0"), joint("t", "revolute", "c", "tip", at="1 0 0")]
    moved = Mechanism.from_urdf(robot(tmp_path, *body))
    assert moved.mockup.part_paths == ("b", "c/box", "w/box", "tip")
    assert moved.mockup.parts[0].triangles == 0
    found = moved.range("j")
    # The box turns about the origin with its middle at 0.4: its corner (0.35, 0.05) first meets the side at y 0.35.
    assert found.above is not None and (found.above.path, found.above.other_path) == ("c/box", "w/box")
    far, up = math.hypot(0.45, 0.05), math.atan2(0.05, 0.45)
    corner = math.atan2(0.45, 0.05) - up  # the outer corner at x 0.05
    assert 0.0 < found.upper <= corner + 1e-9 and far < 0.5
    assert moved.range("t").above is None and moved.range("k").upper == 1.0
    assert [each.other_path for each in moved.clash({"j": (0.0, 1.5)}).contacts] == ["w/box"]
    assert moved.clearance({"j": (0.0, 0.2), "k": (-0.2, 0.2)}, error=1e-3).lower > 0.05
    assert moved.clash({"t": (0.0, 1.0)}).contacts == ()


def test_a_robot_stands_in_a_mockup(tmp_path: Path) -> None:
    wall = feeler.Mockup(*box((0.9, -1, -1), (1, 1, 1)), np.zeros(12, dtype=int), ["wall"])
    base = np.eye(4)
    base[:3, 3] = 0.5, 0.0, 0.0
    file = robot(tmp_path, link("a"), link("b"), joint("j", "prismatic", "a", "b", '<axis xyz="1 0 0"/>', "0 0 0.2"))
    moved = Mechanism.from_urdf(file, around=wall, world_from_base=base)
    assert moved.mockup.part_paths == ("a/box", "b/box", "wall")
    found = moved.range("j")
    assert found.upper == pytest.approx(0.35, abs=1e-7) and found.upper <= 0.35 + 1e-12
    assert found.above is not None and found.above.other_path == "wall"


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ([link("a"), link("b"), joint("j", "planar", "a", "b")], "joint 'j' is planar.*prismatic and revolute"),
        ([link("a"), link("b"), joint("j", "floating", "a", "b")], "joint 'j' is floating"),
        ([link("a"), link("b"), joint("j", "fixed", "a", "b")], "no joint moves"),
        ([link("a"), link("b"), joint("j", "revolute", "a", "b", '<axis xyz="0 0 0"/>')], "joint 'j': its axis"),
        (
            [
                *(link("a"), link("b"), link("c"), joint("j", "fixed", "a", "b")),
                joint("k", "revolute", "b", "c", '<mimic joint="j"/>'),
            ],
            "'k' mimics 'j', which is fixed",
        ),
        ([link("a"), link("b"), joint("j", "revolute", "a", "b", '<mimic joint="x"/>')], "mimics 'x', which is not"),
        (
            [
                *(link("a"), link("b"), link("c"), joint("j.", "revolute", "a", "b")),
                joint("j_", "revolute", "b", "c"),
            ],
            "same name once",
        ),
    ],
)
def test_robots_that_are_no_mechanism(tmp_path: Path, body: list[str], says: str) -> None:
    with pytest.raises(LoadError, match=says):
        Mechanism.from_urdf(robot(tmp_path, *body))


def test_a_mimic_that_does_not_follow_stands_at_its_offset(tmp_path: Path) -> None:
    slide = '<axis xyz="0 0 1"/><mimic joint="j" multiplier="0" offset="2"/>'
    body = [link("a"), link("b"), link("c"), joint("j", "revolute", "a", "b", at="1 0 0")]
    moved = Mechanism.from_urdf(robot(tmp_path, *body, joint("k", "prismatic", "a", "c", slide)))
    assert moved.names == ("j",) and moved.mockup.parts[2].lower[2] == pytest.approx(1.95)


def test_files_too_large_to_be_robots_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "large.urdf"
    with file.open("wb") as out:
        out.truncate(65 * 2**20)
    with pytest.raises(LoadError, match="more than 64 MiB"):
        Mechanism.from_urdf(file)
