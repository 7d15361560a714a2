"""Area and volume of parts: exact values, surfaces that are open, and places far from the origin."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from shapes import box

import feeler
from feeler.workbench.engine.sizes import sizes_of


def mockup(points: object, faces: object) -> feeler.Mockup:
    return feeler.Mockup(np.asarray(points, dtype=float), np.asarray(faces))


def test_a_box() -> None:
    made = mockup(*box((1.0, 2.0, 3.0), (2.0, 4.0, 6.0)))
    assert sizes_of(made, 0).volume == pytest.approx(6.0, rel=1e-12)
    assert sizes_of(made, 0).area == pytest.approx(22.0, rel=1e-12)


@pytest.mark.parametrize("missing", range(12))
def test_a_box_without_one_triangle_has_no_volume(missing: int) -> None:
    points, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    found = sizes_of(mockup(points, np.delete(faces, missing, axis=0)), 0)
    assert found.volume is None and found.area == pytest.approx(5.5)


def test_a_triangle_the_wrong_way_round_has_no_volume_and_a_box_inside_out_has_one() -> None:
    points, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    wrong = np.array(faces)
    wrong[3] = wrong[3][::-1]
    assert sizes_of(mockup(points, wrong), 0).volume is None
    assert sizes_of(mockup(points, np.asarray(faces)[:, ::-1]), 0).volume == pytest.approx(1.0)


def test_a_cavity_is_not_material() -> None:
    outer, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    inner, _ = box((0.25, 0.25, 0.25), (0.75, 0.75, 0.75))
    hollow = mockup(np.concatenate([outer, inner]), np.concatenate([faces, np.asarray(faces)[:, ::-1] + 8]))
    assert sizes_of(hollow, 0).volume == pytest.approx(1.0 - 0.125)
    assert sizes_of(hollow, 0).area == pytest.approx(6.0 + 1.5)


def test_corners_are_the_same_if_their_numbers_are() -> None:
    points, faces = box((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0))
    soup = np.asarray(points)[np.asarray(faces)].reshape(-1, 3)
    soup[soup == 0.0] *= np.where(np.arange(np.count_nonzero(soup == 0.0)) % 2, 1.0, -1.0)  # 0.0 and -0.0
    assert sizes_of(mockup(soup, np.arange(len(soup)).reshape(-1, 3)), 0).volume == pytest.approx(4.0)


def test_far_from_the_origin_no_digits_are_lost() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3)
    near = sizes_of(mockup(sphere.vertices, sphere.faces), 0)
    far = sizes_of(mockup(sphere.vertices + 4096.0, sphere.faces), 0)
    assert near.volume == pytest.approx(sphere.volume, rel=1e-12)
    assert far.volume == pytest.approx(near.volume, rel=1e-9)
    assert far.area == pytest.approx(near.area, rel=1e-9)


def test_each_part_has_its_own() -> None:
    parts = [box((0.0, 0.0, 0.0), (k, 1.0, 1.0)) for k in (1.0, 2.0, 3.0)]
    made = feeler.Mockup(
        np.concatenate([points for points, _ in parts]),
        np.concatenate([np.asarray(faces) + 8 * k for k, (_, faces) in enumerate(parts)]),
        np.repeat(np.arange(3), 12),
        ["a", "b", "c"],
    )
    assert [sizes_of(made, part).volume for part in range(3)] == pytest.approx([1.0, 2.0, 3.0])


def test_what_is_not_finite_has_no_sizes() -> None:
    points, faces = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    wrong = np.array(points)
    wrong[0] = np.nan
    found = sizes_of(mockup(wrong, faces), 0)
    assert (found.area, found.volume) == (0.0, None)
