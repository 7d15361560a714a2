"""What is inside what, though nothing meets: against solid angles, and in cases whose answer is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapes import Mesh, at, box, cube, inverted, joined, mockup_of, tool_of

import feeler

Pairs = list[list[int]]


def winding(mesh: Mesh, point: npt.ArrayLike) -> int:
    """How often closed surfaces go around a point, by solid angles (van Oosterom and Strackee 1983)."""
    a, b, c = np.moveaxis(mesh[0][mesh[1]] - np.asarray(point), 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("ij,ij->i", a, np.cross(b, c))
    bottom = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    around = np.arctan2(top, bottom).sum() / (2 * np.pi)
    assert abs(around - round(around)) < 1e-6
    return round(around)


def told(found: feeler.Containment) -> tuple[Pairs, Pairs, list[int]]:
    return found.containing_pairs.tolist(), found.contained_pairs.tolist(), found.unknown.tolist()


# --- against solid angles --------------------------------------------------------------------------------------------

# By kind, the surfaces of a body in a cell of 4 m.
KINDS: dict[str, Callable[[Any, float], list[Mesh]]] = {
    "solid": lambda p, s: [cube(p, s)],
    "mirrored": lambda p, s: [inverted(cube(p, s))],
    "hollow": lambda p, s: [cube(p, s), inverted(cube(p, 0.6 * s))],
    "mirrored hollow": lambda p, s: [inverted(cube(p, s)), cube(p, 0.6 * s)],
    "core in a hollow": lambda p, s: [cube(p, s), inverted(cube(p, 0.6 * s)), cube(p, 0.3 * s)],
    "solid in a solid": lambda p, s: [cube(p, s), cube(p, 0.5 * s)],
}
PLACE = st.tuples(*[st.integers(-2, 2)] * 3)
BODY = st.tuples(st.sampled_from(sorted(KINDS)), PLACE, st.sampled_from([0.7, 1.1, 2.3, 3.9]))
"""Cells lie 4 m apart, so that the bodies of one part are apart."""
PART = st.lists(BODY, min_size=1, max_size=3, unique_by=lambda body: body[1])
TOOL_BODY = st.tuples(PLACE, st.sampled_from([0.1, 0.2, 1.7, 5.3, 13.1]), st.booleans())
TOOL_PART = st.lists(TOOL_BODY, min_size=1, max_size=2, unique_by=lambda body: body[0])


def surfaces_of(part: list[tuple[str, tuple[int, int, int], float]]) -> list[Mesh]:
    return [surface for kind, place, size in part for surface in KINDS[kind](4.0 * np.array(place), size)]


def moving_surfaces(part: list[tuple[tuple[int, int, int], float, bool]]) -> list[Mesh]:
    """Of a part of the tool; a large body alone, since what is within another of its part may be a hollow."""
    if any(size > 4 for _, size, _ in part):
        part = part[:1]
    cubes = [(cube(4.0 * np.array(place), size), is_mirrored) for place, size, is_mirrored in part]
    return [inverted(mesh) if is_mirrored else mesh for mesh, is_mirrored in cubes]


@given(
    parts=st.lists(PART, min_size=1, max_size=3),
    tool_parts=st.lists(TOOL_PART, min_size=1, max_size=2),
    shift=st.tuples(*[st.sampled_from([0.03, 0.31, 0.77, 1.13])] * 3),
    degrees=st.sampled_from([0.0, 90.0, 31.0]),
    axis=st.integers(0, 2),
)
def test_containment_is_what_solid_angles_say(
    parts: list[Any], tool_parts: list[Any], shift: Any, degrees: float, axis: int
) -> None:
    static = [surfaces_of(part) for part in parts]
    turned = [moving_surfaces(part) for part in tool_parts]
    scene = feeler.Scene(mockup_of({f"p{i}": joined(*surfaces) for i, surfaces in enumerate(static)}))
    tool = tool_of({f"t{i}": joined(*surfaces) for i, surfaces in enumerate(turned)})
    pose = at(*shift, degrees, axis)
    assume(not scene.is_colliding(tool, pose))

    def placed(mesh: Mesh) -> Mesh:
        return mesh[0] @ pose[:3, :3].T + pose[:3, 3], mesh[1]

    containing, contained = set(), set()
    for t, surfaces in enumerate(turned):
        for m, others in enumerate(static):
            if any(winding(joined(*others), placed(surface)[0][0]) for surface in surfaces):
                containing.add((t, m))
            if any(winding(placed(joined(*surfaces)), other[0][0]) for other in others):
                contained.add((t, m))
    found = scene.containment(tool, pose)
    assert told(found) == (sorted(map(list, containing)), sorted(map(list, contained)), [])
    assert found.containing.tolist() == sorted({m for _, m in containing})
    assert found.contained.tolist() == sorted({m for _, m in contained})
    assert bool(found) == bool(containing or contained) == (not scene.is_free(tool, pose))
    check = scene.check_path(tool, [pose])
    assert check.containment is not None and told(check.containment) == told(found)
    assert check.is_free == scene.is_free(tool, pose) and np.isnan(check.fractions).all()
    # What is out, or ignored, holds nothing and is not held.
    for place, others in (
        (1, scene.without(0).containment(tool, pose)),
        (0, scene.containment(tool, pose, ignore=[(0, "*")])),
    ):
        left = [[pair for pair in pairs if pair[place] != 0] for pairs in told(found)[:2]]
        assert told(others) == (*left, [])


# --- known cases -----------------------------------------------------------------------------------------------------


def test_a_pin_in_a_block(testdata: Path) -> None:
    """A pin of 10 mm in the middle of a block of 200 mm has no room, though the block's faces are 95 mm away."""
    block = feeler.load_mockup(testdata / "files" / "contain_block.obj", "mm")
    pin = feeler.load_tool(testdata / "files" / "contain_pin.obj", "mm")
    scene = feeler.Scene(block)
    found = scene.containment(pin, at())
    assert told(found) == ([[0, 0]], [], []) and bool(found)
    assert scene.distance(pin, at()).value == pytest.approx(0.095)
    assert not scene.is_colliding(pin, at()) and not scene.is_free(pin, at())
    way = [at(), at(0.05)]
    assert not scene.check_path(pin, way).is_free
    only_meetings = scene.check_path(pin, way, inside=False)
    assert only_meetings.is_free and only_meetings.containment is None
    assert scene.is_free(pin, at(0.2)) and scene.check_path(pin, [at(0.2), at(0.3)]).is_free
    # The other way round: a tool around a part.
    around = feeler.Scene(feeler.Mockup(pin.vertices, pin.faces))
    found = around.containment(feeler.Tool(block.vertices, block.faces), at())
    assert told(found) == ([], [[0, 0]], []) and bool(found)


def test_a_way_that_ends_inside_is_blocked_at_the_wall() -> None:
    scene, tool = feeler.Scene(feeler.Mockup(*cube((0, 0, 0), 2))), feeler.Tool(*cube((0, 0, 0), 0.1))
    check = scene.check_path(tool, [at(3), at(0)])
    assert not check.is_free and not check.containment and check.segments.tolist() == [0]


@pytest.fixture(scope="module")
def shells() -> feeler.Scene:
    """A block with a hollow and a second, mirrored block; an open block; a small one."""
    wide = joined(cube((0, 0, 0), 4), inverted(cube((0, 0, 0), 2)), inverted(cube((10, 0, 0), 4)))
    vertices, faces = cube((20, 0, 0), 4)
    return feeler.Scene(mockup_of({"pair": wide, "open": (vertices, faces[1:]), "small": cube((30, 0, 0), 1)}))


@pytest.mark.parametrize(
    ("x", "size", "expected"),
    [
        pytest.param(1.5, 0.1, ([[0, 0]], [], []), id="in the wall around the hollow"),
        pytest.param(0.3, 0.1, ([], [], []), id="in the hollow"),
        pytest.param(10, 0.1, ([[0, 0]], [], []), id="in the mirrored block"),
        pytest.param(20, 0.1, ([], [], [1]), id="in the open block: nobody knows"),
        pytest.param(15, 0.1, ([], [], []), id="between"),
        pytest.param(30, 3, ([], [[0, 2]], []), id="around the small one"),
        pytest.param(20, 6, ([], [[0, 1]], []), id="around the open one, which is in it all the same"),
        pytest.param(31, 0.1, ([], [], []), id="beside the small one"),
    ],
)
def test_shells_one_by_one(shells: feeler.Scene, x: float, size: float, expected: Any) -> None:
    tool = feeler.Tool(*cube((0, 0, 0), size))
    assert told(shells.containment(tool, at(x))) == expected
    assert shells.is_free(tool, at(x)) == (not expected[0] and not expected[1])
    mirrored = feeler.Tool(*inverted(cube((0, 0, 0), size)))
    assert told(shells.containment(mirrored, at(x))) == expected


def test_an_open_tool_holds_nobody_knows_what(shells: feeler.Scene) -> None:
    vertices, faces = cube((0, 0, 0), 3)
    lidless = feeler.Tool(vertices, faces[:-2])
    assert told(shells.containment(lidless, at(30))) == ([], [], [2])
    assert told(shells.containment(feeler.Tool(*cube((0, 0, 0), 0.1)), at(30))) == ([[0, 2]], [], [])
    # It can be held, though: its surface lies on one side of what it does not cross.
    inner = feeler.Tool(vertices / 30, faces[:-2])
    assert told(shells.containment(inner, at(1.5))) == ([[0, 0]], [], [])


def test_what_crosses_is_not_inside_and_what_touches_may_be() -> None:
    scene = feeler.Scene(mockup_of({"inner": cube((0, 0, 0), 4), "outer": cube((0, 0, 0), 9)}))
    for x, size, expected in [
        (2.0, 1.0, [1]),  # through a side of the inner one
        (1.5, 1.0, [0, 1]),  # flush with it from within
        (2.5, 1.0, [1]),  # and from outside
        (4.5, 1.0, []),  # through a side of the outer one
    ]:
        assert scene.containment(feeler.Tool(*cube((0, 0, 0), size)), at(x)).containing.tolist() == expected


def in_uneven_faces(cells: int = 4) -> Mesh:
    """A cube of 1 m whose faces were cut one by one: each has rows of its own, and lies a little off its place."""
    meshes = []
    for side in range(6):
        axis, sign = side // 2, 1 - 2 * (side % 2)
        rows = np.linspace(-0.5, 0.5, cells + 1 + side)
        u, v = np.meshgrid(rows, rows)
        corners = np.empty((u.size, 3))
        corners[:, axis] = 0.5 * sign + 2e-5 * (side + 1)
        corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = u.ravel(), sign * v.ravel()
        n = len(rows)
        first = np.array([i * n + j for i in range(n - 1) for j in range(n - 1)])[:, None]
        meshes.append((corners, np.concatenate([first + np.array(f) for f in ([0, 1, n + 1], [0, n + 1, n])])))
    return joined(*meshes)


SPAN = st.tuples(st.integers(-3, 2), st.integers(1, 4)).map(lambda x: (x[0], x[0] + x[1]))
SPANS = st.tuples(SPAN, SPAN, SPAN)
Spans = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]


@given(static=st.lists(SPANS, min_size=1, max_size=3), moving=st.lists(SPANS, min_size=1, max_size=2))
def test_blocks_on_a_lattice_share_an_inside_or_are_told_apart(static: list[Spans], moving: list[Spans]) -> None:
    """Whether flush, nested or crossing: what shares an inside enters, or is held; nothing else does."""

    def mesh_of(spans: Spans) -> Mesh:
        return box([low for low, _ in spans], [high for _, high in spans])

    def overlap(a: Spans, b: Spans) -> bool:
        return all(max(p[0], q[0]) < min(p[1], q[1]) for p, q in zip(a, b, strict=True))

    def within(a: Spans, b: Spans) -> bool:
        return all(q[0] <= p[0] and p[1] <= q[1] for p, q in zip(a, b, strict=True))

    scene = feeler.Scene(mockup_of({f"p{i}": mesh_of(spans) for i, spans in enumerate(static)}))
    tool = tool_of({f"t{i}": mesh_of(spans) for i, spans in enumerate(moving)})
    found = scene.containment(tool, at())
    shared = any(overlap(a, b) for a in static for b in moving)
    assert shared == (scene.is_colliding(tool, at(), touching="free") or bool(found))
    assert not (shared and scene.is_free(tool, at()))
    # What is told is true; and what is within without touching is told.
    assert all(within(moving[t], static[m]) for t, m in found.containing_pairs)
    assert all(within(static[m], moving[t]) for t, m in found.contained_pairs)
    for t, b in enumerate(moving):
        for m, a in enumerate(static):
            apart = not scene.only(m).is_colliding(feeler.Tool.of_parts(feeler.Mockup(tool), t), at())
            assert ([t, m] in found.containing_pairs.tolist()) or not (apart and within(b, a))
            assert ([t, m] in found.contained_pairs.tolist()) or not (apart and within(a, b))


def test_cracks_are_no_holes() -> None:
    tool = feeler.Tool(*cube((0.1, 0.07, -0.03), 0.1))
    vertices, faces = in_uneven_faces()
    cracked = feeler.Scene(feeler.Mockup(vertices, faces))
    assert told(cracked.containment(tool, at())) == ([[0, 0]], [], [])
    assert told(cracked.containment(tool, at(1.2))) == ([], [], [])
    # Nor where a ray would leave through one of them: from many places.
    places = np.random.default_rng(7).uniform(-0.4, 0.4, (200, 3))
    small = feeler.Tool(*cube((0, 0, 0), 1e-3))
    assert all(cracked.containment(small, at(*place)) for place in places)
    assert not any(cracked.containment(small, at(*place + np.sign(place) * 0.51)) for place in places)
    # Without a triangle it is open, and nobody knows.
    holed = feeler.Scene(feeler.Mockup(vertices, faces[1:]))
    assert told(holed.containment(tool, at())) == ([], [], [0])


def test_the_tool_is_asked_part_by_part_and_body_by_body(shells: feeler.Scene) -> None:
    three = tool_of(
        {
            "bare": cube((15, 0, 0), 0.2),
            "pair": joined(cube((15, 0, 0.5), 0.2), cube((10, 0, 0), 0.2)),
            "cup": cube((30, 0, 0), 2),
        }
    )
    assert told(shells.containment(three, at())) == ([[1, 0]], [[2, 2]], [])
    assert told(shells.containment(three, at(), ignore=[("pair", "pair")])) == ([], [[2, 2]], [])
    assert shells.is_free(three, at(), ignore=[("pair", "pair"), ("cup", "small")])
    assert not shells.is_free(three, at(), ignore=[("pair", "pair")])
    assert repr(shells.containment(three, at())) == "Containment(1 containing, 1 contained, 0 unknown)"


def test_is_free_is_neither_met_nor_inside(shells: feeler.Scene) -> None:
    tool = feeler.Tool(*cube((0, 0, 0), 0.5))
    for x in np.linspace(-3, 33, 73):
        free = not shells.is_colliding(tool, at(x)) and not shells.containment(tool, at(x))
        assert shells.is_free(tool, at(x)) == free


def test_mirrored_bodies_are_pressed_out_alike() -> None:
    """Two cubes, one turned inside out, 1 mm deep in a slab: planes upright, and none sideways."""
    slab = feeler.Scene(feeler.Mockup(*box((-0.1, -0.1, -0.05), (0.1, 0.1, 0))))
    cubes = cube((-0.02, 0, 0.004), 0.01), cube((0.02, 0, 0.004), 0.01)
    for tool in (
        feeler.Tool(*joined(cubes[0], inverted(cubes[1]))),
        tool_of({"a": cubes[0], "b": inverted(cubes[1])}),
        feeler.Tool(*joined(inverted(cubes[0]), inverted(cubes[1]))),
    ):
        contacts = slab.contacts(tool, at())
        assert len(contacts) >= 1
        deep = contacts.gaps < 0
        np.testing.assert_allclose(contacts.gaps[deep], -0.001, atol=1e-12)
        np.testing.assert_allclose(contacts.normals, np.tile([0, 0, 1], (len(contacts), 1)), atol=1e-12)
        assert deep.all()
        assert slab.penetration(tool, at()).depth == pytest.approx(0.001, rel=1e-5)


def test_poses_and_tools_are_checked(shells: feeler.Scene) -> None:
    tool = feeler.Tool(*cube((0, 0, 0), 0.5))
    for ask in (shells.containment, shells.is_free):
        for wrong in (2 * np.eye(4), np.eye(3), np.full((4, 4), np.nan), "pose", None):
            with pytest.raises(feeler.PoseError):
                ask(tool, wrong)
        with pytest.raises(feeler.MeshError):
            ask("tool", at())  # type: ignore[arg-type]


def test_a_ball_that_was_lost_in_the_beam_of_the_gearbox(gearbox: Any, faulty_gearbox: Any) -> None:
    """It is planted; no part of the gearbox itself is inside another one."""
    ball, beam = faulty_gearbox.fault["inside"].parts
    mockup = faulty_gearbox.mockup
    lost = faulty_gearbox.scene.without(ball).containment(feeler.Tool.of_parts(mockup, ball), np.eye(4))
    assert [mockup.part_paths[part] for part in lost.containing] == [beam] and not len(lost.contained)
    whole = gearbox.mockup
    for path in gearbox.mockup.part_paths[::25]:
        found = gearbox.scene.without(path).containment(feeler.Tool.of_parts(whole, path), np.eye(4))
        assert not len(found.containing) and not len(found.contained) and not len(found.unknown), path
