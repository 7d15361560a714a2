"""What may touch: bodies that lie on each other, slide and are seated without play, told from those that enter."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import Mesh, arrays_of, at, box, cube, inverted, joined, mockup_of, tool_of

import feeler

Floats = npt.NDArray[np.float64]


def lifted(heights: npt.ArrayLike) -> Floats:
    return np.stack([at(0, 0, z) for z in np.asarray(heights, dtype=float)])


@pytest.fixture(scope="module", params=["blocks", "dense", "hashed"])
def seat(request: pytest.FixtureRequest) -> feeler.Scene:
    """A square hole of 10 mm, 20 mm deep, between four blocks, with a bottom."""
    walls = {
        "left": box((-0.03, -0.03, -0.02), (-0.005, 0.03, 0)),
        "right": box((0.005, -0.03, -0.02), (0.03, 0.03, 0)),
        "front": box((-0.005, -0.03, -0.02), (0.005, -0.005, 0)),
        "back": box((-0.005, 0.005, -0.02), (0.005, 0.03, 0)),
        "bottom": box((-0.03, -0.03, -0.03), (0.03, 0.03, -0.02)),
    }
    return feeler.Scene(mockup_of(walls), storage=request.param, voxel_size=0.004)


@pytest.fixture(scope="module")
def pin() -> feeler.Tool:
    """Fits the hole exactly, and stands 10 mm out of it."""
    return feeler.Tool(*box((-0.005, -0.005, -0.02), (0.005, 0.005, 0.01)), "pin")


OUT = lifted(np.linspace(0, 0.05, 6))


def test_a_seated_pin_is_drawn_out_and_put_back(seat: feeler.Scene, pin: feeler.Tool) -> None:
    for poses in (OUT, OUT[::-1]):
        check = seat.check_path(pin, poses, touching="free")
        assert check.is_free and np.isnan(check.fractions).all() and check.first is None
        assert not seat.check_path(pin, poses).is_free
    for pose in OUT:
        assert not seat.is_colliding(pin, pose, touching="free")
    # Out of the hole by more than its depth nothing is touched any more.
    assert [seat.is_colliding(pin, pose) for pose in OUT] == [True, True, True, False, False, False]
    assert seat.cast(pin, OUT[0], OUT[-1], touching="free") is None
    assert not seat.containment(pin, OUT[0]), "what fits a hole is in no wall"


@pytest.mark.parametrize(
    "pose",
    [
        pytest.param(at(0, 0, 0, 1), id="turned in its hole"),
        pytest.param(at(0, 0, 0.01, 0.1, 0), id="tilted"),
        pytest.param(at(1e-9, 0, 0), id="a nanometre into a wall"),
        pytest.param(at(0, 0, -1e-9), id="a nanometre into the bottom"),
        pytest.param(at(0.001, 0, 0.001), id="aside"),
    ],
)
def test_what_does_not_fit_enters(seat: feeler.Scene, pin: feeler.Tool, pose: Floats) -> None:
    assert seat.is_colliding(pin, pose, touching="free")
    assert not seat.check_path(pin, [pose], touching="free").is_free
    # As an end of a way it is an impact too, however small: poses are decided exactly.
    for way in ([OUT[-1], pose], [pose, OUT[-1]]):
        assert seat.cast(pin, *way, touching="free") is not None


def test_the_ways_that_walls_block(seat: feeler.Scene, pin: feeler.Tool) -> None:
    for end in (at(0.01, 0, 0), at(0, -0.01, 0.01), at(0, 0, -0.001), at(0, 0, 0, 45), at(0.01, 0, 0.02)):
        hit = seat.cast(pin, at(), end, touching="free")
        # The tolerance is a micrometre, on a way of a millimetre or more.
        assert hit is not None and hit.fraction <= 0.002
    # Straight on, and through another side: the hole does not end there.
    hit = seat.cast(pin, at(0, 0, 0.01), at(0, 0, -0.01), touching="free")
    assert hit is not None and hit.fraction == pytest.approx(0.5, abs=2e-4)
    assert seat.mockup.part_names[hit.part] == "bottom"


def test_a_path_ends_where_the_pin_jams(seat: feeler.Scene, pin: feeler.Tool) -> None:
    poses = np.stack([at(), at(0, 0, 0.01), at(0, 0, 0.01, 30), at(0, 0, 0.05, 30), at(0, 0, 0.05)])
    check = seat.check_path(pin, poses, touching="free")
    assert not check.is_free and check.segments.tolist() == [1, 2]
    single = [seat.cast(pin, *pair, touching="free") for pair in pairwise(poses)]
    assert [hit is not None for hit in single] == [False, True, True, False]
    for fraction, hit in zip(check.fractions, single, strict=True):
        assert np.isnan(fraction) if hit is None else fraction == hit.fraction


def test_a_part_of_the_mock_up_is_drawn_out_of_its_seat(seat: feeler.Scene, pin: feeler.Tool) -> None:
    walls = {
        part.path: (seat.mockup.vertices[8 * part.index : 8 * part.index + 8], seat.mockup.faces[:12])
        for part in seat.mockup.parts
    }
    whole = feeler.Scene(mockup_of({**walls, "pin": (pin.vertices, pin.faces)}), storage=seat.storage)
    moving, rest = feeler.Tool.of_parts(whole.mockup, "pin"), whole.without("pin")
    assert rest.check_path(moving, OUT, touching="free").is_free
    assert not whole.check_path(moving, OUT, touching="free").is_free, "in its own place it enters itself"


# --- bodies on a lattice ---------------------------------------------------------------------------------------------

SPAN = st.tuples(st.integers(-3, 2), st.integers(1, 3)).map(lambda x: (x[0], x[0] + x[1]))
BOX = st.tuples(SPAN, SPAN, SPAN)
Spans = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]


def mesh_of(spans: Spans) -> Mesh:
    return box([low for low, _ in spans], [high for _, high in spans])


def enters(a: Spans, b: Spans) -> bool:
    """Whether the insides of two boxes share a point, and their surfaces as well."""
    overlap = all(max(p[0], q[0]) < min(p[1], q[1]) for p, q in zip(a, b, strict=True))
    within = any(
        all(outer[0] < inner[0] and inner[1] < outer[1] for inner, outer in zip(i, o, strict=True))
        for i, o in ((a, b), (b, a))
    )
    return overlap and not within


@given(static=st.lists(BOX, min_size=1, max_size=3), moving=BOX, turned=st.sampled_from([0, 90, 180, 270]))
def test_boxes_on_a_lattice_enter_where_their_insides_do(static: list[Spans], moving: Spans, turned: int) -> None:
    scene = feeler.Scene(mockup_of({f"p{i}": mesh_of(spans) for i, spans in enumerate(static)}))
    pose = at(0, 0, 0, turned)
    ends = pose[:3, :3] @ np.array(moving, dtype=float)
    there: Spans = tuple((int(min(row)), int(max(row))) for row in ends)  # type: ignore[assignment]
    tool = feeler.Tool(*mesh_of(moving))
    for i, spans in enumerate(static):
        assert scene.only(i).is_colliding(tool, pose, touching="free") == enters(there, spans), i
    expected = any(enters(there, spans) for spans in static)
    assert scene.is_colliding(tool, pose, touching="free") == expected
    # A body turned inside out by a mirror is the same body, and standing still is a way.
    mirrored = feeler.Tool(*inverted(mesh_of(moving)))
    assert scene.is_colliding(mirrored, pose, touching="free") == expected
    assert (scene.cast(tool, pose, pose, touching="free") is not None) == expected
    assert scene.check_path(tool, [pose], touching="free", inside=False).is_free == (not expected)


@given(static=BOX, moving=BOX, axis=st.integers(0, 2), steps=st.integers(-6, 6))
def test_boxes_slide_until_one_enters(static: Spans, moving: Spans, axis: int, steps: int) -> None:
    """On a straight way along an axis one box enters the other where an exact sweep does."""
    scene, tool = feeler.Scene(feeler.Mockup(*mesh_of(static))), feeler.Tool(*mesh_of(moving))
    move = np.zeros(3)
    move[axis] = steps
    hit = scene.cast(tool, at(), at(*move), touching="free")
    across = [a for a in range(3) if a != axis]
    in_the_way = all(max(static[a][0], moving[a][0]) < min(static[a][1], moving[a][1]) for a in across)
    low, high = moving[axis]
    if enters(static, moving):
        assert hit is not None and hit.fraction == 0
    elif in_the_way and (steps > 0 and high <= static[axis][0] < high + steps):
        assert hit is not None and hit.fraction == pytest.approx((static[axis][0] - high) / steps, abs=1e-4)
    elif in_the_way and (steps < 0 and low + steps < static[axis][1] <= low):
        assert hit is not None and hit.fraction == pytest.approx((static[axis][1] - low) / steps, abs=1e-4)
    elif not in_the_way:
        assert hit is None


# --- what else the rule says -----------------------------------------------------------------------------------------


def plate(z: float, size: float = 2.0, flipped: bool = False) -> Mesh:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * size / 2 + (0, 0, z)
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return corners, faces[:, ::-1] if flipped else faces


@pytest.mark.parametrize("flipped", [False, True])
def test_a_sheet_is_touched_from_one_side_and_passed_from_two(flipped: bool) -> None:
    scene = feeler.Scene(feeler.Mockup(*plate(0, 8, flipped)))
    spike = np.array([[0.3, -0.2, 0], [0.5, -0.3, 1], [0.3, 0.0, 1], [0.1, -0.3, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    one, two = feeler.Tool(spike, faces), feeler.Tool(*joined((spike, faces), (spike * [1, 1, -1], faces)))
    assert scene.is_colliding(one, at()) and not scene.is_colliding(one, at(), touching="free")
    assert scene.is_colliding(one, at(0, 0, -0.1), touching="free")
    # Two spikes, tip to tip across the sheet, do not go through it: no triangle is beside one from the other side.
    assert not scene.is_colliding(two, at(), touching="free")
    # A waist in the sheet's plane does: its triangles touch from both sides, edge by edge.
    prism = joined(box((-0.5, -0.5, 0), (0.5, 0.5, 1)))
    waist = prism[0].copy()
    waisted = np.concatenate([waist, waist[waist[:, 2] == 1] * [1, 1, -1]])
    faces = np.array([f for f in prism[1].tolist() if not (prism[0][f][:, 2] == 0).all()])
    below = {int(i): 8 + k for k, i in enumerate(np.flatnonzero(waist[:, 2] == 1))}
    lower = np.array([[below.get(i, i) for i in face[::-1]] for face in faces.tolist()])
    through = feeler.Tool(waisted, np.concatenate([faces, lower]))
    assert {k for k in scene.collide(through, at()).kinds.tolist()} <= {feeler.PairKind.TOUCHING}
    assert scene.is_colliding(through, at(), touching="free")
    # A block that lies on the sheet, or another sheet in it, only touches.
    assert not scene.is_colliding(feeler.Tool(*box((-1, -1, 0), (1, 1, 1))), at(), touching="free")
    assert not scene.is_colliding(feeler.Tool(*plate(0, 1)), at(), touching="free")


def test_bodies_that_meet_at_corners_alone_touch() -> None:
    scene, tool = feeler.Scene(feeler.Mockup(*cube((0, 0, 0), 2))), feeler.Tool(*cube((0, 0, 0), 2))
    for pose in (at(2, 2, 2), at(2, 2, 0), at(2, 0, 0), at(2, 1, 0.5)):
        assert scene.is_colliding(tool, pose) and not scene.is_colliding(tool, pose, touching="free")
    # In one place both bodies are on the same side of every face.
    assert scene.is_colliding(tool, at(), touching="free")


def test_between_poses_the_tolerance_may_be_overlapped() -> None:
    """A cube that rolls by a quarter turn, its middle at one height: a corner dips below the floor meanwhile."""
    scene = feeler.Scene(feeler.Mockup(*box((-5, -5, -1), (5, 5, 0))))
    tool = feeler.Tool(*cube((0, 0, 0), 1))
    ends = at(0, 0, 0.5), at(0.5, 0, 0.5, 90, 1)
    for tolerance in (1e-6, 1e-3, 0.1):
        hit = scene.cast(tool, *ends, touching="free", tolerance=tolerance)
        assert hit is not None and 0 < hit.fraction < 0.5
        # The corner is as deep as the tolerance at the latest, and that is no impact before.
        angle = np.pi / 2 * hit.fraction
        assert (np.cos(angle) + np.sin(angle) - 1) / 2 == pytest.approx(tolerance, rel=0.05)
        assert scene.cast(tool, ends[0], hit.pose, touching="free", tolerance=tolerance) is not None
    # Poses are decided exactly, whatever the tolerance.
    sunk = at(0, 0, 0.5 - 1e-9), at(0.5, 0, 0.5)
    for way in (sunk, sunk[::-1]):
        assert scene.cast(tool, *way, touching="free", tolerance=0.25) is not None


def test_an_oblique_seat_is_rounded_and_ignore_helps() -> None:
    """Corners at a pose are rounded, each for itself: a block on an oblique face crosses it by what that is."""
    floor = mockup_of({"ramp": box((-5, -5, -1), (5, 5, 0)), "post": box((2, -1, 0), (3, 1, 2))})
    tilted = at(0.1, 0.2, 0.3, 31, 1) @ at(0, 0, 0, 17)
    whole = feeler.Tool.assembly({"floor": (feeler.Tool(floor), tilted)})
    vertices, faces, _, _ = arrays_of({"a": (whole.vertices, whole.faces)})
    scene = feeler.Scene(feeler.Mockup(vertices, faces, whole.part_of_face, ["ramp", "post"]))
    block = tool_of({"block": box((-0.37, -0.41, 0), (0.53, 0.29, 0.7))})
    poses = [tilted @ at(x / 7, y / 9) for x in range(-5, 5) for y in range(-5, 5)]
    verdicts = [scene.is_colliding(block, pose, touching="free") for pose in poses]
    assert any(verdicts), "rounding lets some enter by 1e-17 m"
    # A nanometre above it, well within the tolerance, the way is free.
    above = [tilted @ at(0, 0, 1e-9) @ np.linalg.inv(tilted) @ pose for pose in poses[::7]]
    for way in pairwise(above):
        assert scene.only("ramp").cast(block, *way, touching="free") is None
    for pose in poses:
        assert max(-scene.contacts(block, pose).gaps, default=0.0) < 1e-12
        assert not scene.is_colliding(block, pose, touching="free", ignore=[("block", "ramp")])
        assert not scene.without("ramp").is_colliding(block, pose)
    at_the_post = tilted @ at(2, 0, 0)
    assert scene.is_colliding(block, at_the_post, touching="free", ignore=[("block", "ramp")])


@pytest.mark.parametrize("wrong", ["Free", "", "touch", None, True, 1])
def test_what_touching_may_be(seat: feeler.Scene, pin: feeler.Tool, wrong: Any) -> None:
    for ask in (
        lambda: seat.is_colliding(pin, at(), touching=wrong),
        lambda: seat.cast(pin, at(), at(), touching=wrong),
        lambda: seat.check_path(pin, [at()], touching=wrong),
    ):
        with pytest.raises(feeler.OptionError, match="choose counts, free"):
            ask()
