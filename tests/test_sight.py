"""Sight: shares of targets behind screens, in closed form and by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import box, cube, inverted, joined, mockup_of

import feeler
from feeler.errors import OptionError
from feeler.samples import hardware
from feeler.samples.tessellation import Tolerance

EYE = [[0.0, 0.0, 10.0]]


def behind(left: float) -> feeler.Scene:
    """A plate of 1 x 1 m at z = 0, and a screen at z = 5 from x = `left` on, seen from z = 10: its shadow begins at
    2 `left`."""
    plate = box((-0.5, -0.5, -1e-3), (0.5, 0.5, 0.0))
    screen = box((left, -1.0, 4.999999), (3.0, 1.0, 5.0))
    return feeler.Scene(mockup_of({"plate": plate, "screen": screen}))


@pytest.mark.parametrize("left", [-0.2, -0.1, 0.0, 0.05, 0.22])
def test_the_share_in_front_of_a_screens_shadow(left: float) -> None:
    scene = behind(left)
    (row,) = feeler.sight(scene, ["plate"], EYE, samples=4_000)
    top = row.points[:, 2] == 0.0
    assert abs(top.mean() - 0.498) < 0.02  # the rest is below, and hidden by the plate itself
    assert np.array_equal(row.seen[0][top], row.points[top, 0] < 2.0 * left)
    assert abs(row.seen[0][top].mean() - (0.5 + 2.0 * left)) < 0.03
    assert not row.seen[0][row.points[:, 2] < -1e-9].any()
    said = dict(row.hidden_by)
    assert said["screen"] == pytest.approx((row.points[:, 0] >= 2.0 * left).mean(), abs=0.002)
    assert row.share == row.seen[0].mean() == row.shares[0]


def test_the_best_eye_and_points() -> None:
    scene = behind(0.0)
    eyes = [[0.0, 0.0, 20.0], [0.0, 0.0, 10.0], [0.0, 0.0, 2.0]]
    (row,) = feeler.sight(scene, ["plate"], eyes, samples=500)
    assert row.eye == 2 and row.share == row.shares.max() == row.shares[2]
    found = feeler.sight(scene, [[0.3, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.0, 0.0, 10.0]], EYE)
    assert [each.share for each in found] == [0.0, 1.0, 1.0] and [each.eye for each in found] == [None, 0, 0]
    assert found[0].hidden_by == (("screen", 1.0),) and found[0].part is None


def test_a_bolt_is_looked_at_from_its_head() -> None:
    """From above all of the head is seen, whichever way the mesh is wound; from below nothing; in a pot only within
    its opening."""
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    bolt = (mesh.vertices, mesh.faces.astype(np.int64))
    wall = 0.006
    pot = joined(
        *(
            box(np.minimum(a, b), np.maximum(a, b))
            for a, b in [
                ((-0.02, -0.02, -0.04), (0.02, -0.02 + wall, 0.03)),
                ((-0.02, 0.02 - wall, -0.04), (0.02, 0.02, 0.03)),
                ((-0.02, -0.02, -0.04), (-0.02 + wall, 0.02, 0.03)),
                ((0.02 - wall, -0.02, -0.04), (0.02, 0.02, 0.03)),
            ]
        )
    )
    for shape in (bolt, inverted(bolt)):
        alone = feeler.Scene(mockup_of({"bolt": shape}))
        heads = feeler.find_fasteners(alone)
        above, below, beside = [0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [2.0, 0.0, 0.02]
        (row,) = feeler.sight(alone, heads, [below, above])
        assert row.eye == 1 and row.share == 1.0 and row.shares[0] == 0.0
        potted = feeler.Scene(mockup_of({"bolt": shape, "pot": pot}))
        (row,) = feeler.sight(potted, heads, [beside, above])
        assert row.shares[0] == 0.0 and row.shares[1] == 1.0
        (row,) = feeler.sight(potted, heads, [beside])
        assert row.eye is None and row.hidden_by == (("pot", 1.0),)


def test_against_brute_force() -> None:
    rng = np.random.default_rng(3)
    parts = {f"part_{n}": cube(rng.uniform(-1, 1, 3), rng.uniform(0.1, 0.5)) for n in range(20)}
    scene = feeler.Scene(mockup_of(parts))
    eyes = rng.uniform(-3, 3, (5, 3))
    found = feeler.sight(scene, "*", eyes, samples=40)
    corners = scene.mockup.vertices[scene.mockup.faces]
    checked = 0
    for row in found:
        for eye, seen in zip(eyes, row.seen, strict=True):
            for point, is_seen in zip(row.points, seen, strict=True):
                assert is_seen == (not crossed(corners, eye, point)), (row.path, eye, point)
                checked += 1
    assert checked == 20 * 5 * 40


def crossed(corners: np.ndarray, eye: np.ndarray, point: np.ndarray) -> bool:
    """Whether a triangle is in between, after Moeller and Trumbore (1997)."""
    way = point - eye
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    cross = np.cross(way, b)
    det = np.einsum("ij,ij->i", a, cross)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = eye - corners[:, 0]
        u = np.einsum("ij,ij->i", s, cross) / det
        q = np.cross(s, a)
        v = q @ way / det
        t = np.einsum("ij,ij->i", b, q) / det
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9) & (t < 1 - 1e-9)).any())


def test_eyes_in_a_box() -> None:
    eyes = feeler.eyes_in([0, 0, 0], [1, 2, 4], 512)
    assert eyes.shape == (512, 3) and (eyes >= 0).all() and (eyes <= [1, 2, 4]).all()
    cells = {tuple(each) for each in np.floor(eyes / [0.25, 0.5, 1.0]).astype(int).tolist()}
    assert len(cells) == 64  # each of 4 x 4 x 4 cells has an eye
    assert np.array_equal(eyes[:64], feeler.eyes_in([0, 0, 0], [1, 2, 4]))
    with pytest.raises(OptionError, match="corners"):
        feeler.eyes_in([0, 0, 1], [1, 1, 0])


def test_what_is_refused() -> None:
    scene = behind(0.0)
    with pytest.raises(OptionError, match="no eyes"):
        feeler.sight(scene, "plate", np.empty((0, 3)))
    with pytest.raises(OptionError, match="no part"):
        feeler.sight(scene, "nothing", EYE)
    other = mockup_of({"cube": cube((0, 0, 0), 1.0), "bolt": mesh_of_bolt()})
    with pytest.raises(OptionError, match="another mock-up"):
        feeler.sight(scene, feeler.find_fasteners(other), EYE)


def mesh_of_bolt() -> tuple[np.ndarray, np.ndarray]:
    mesh = hardware.hex_bolt(0.008, 0.03, Tolerance(1e-4))
    return mesh.vertices, mesh.faces.astype(np.int64)
