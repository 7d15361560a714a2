"""The axes of parts and of whole scenes by their own faces: the same in any pose, turned along with it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

MOST_PLANES = 4
"""The most planes of a part that give it an axis: those of the most area."""
LEAST_SHARE = 0.02
"""The least share of the area of such a plane."""
SAME_PLANE = 1.0 - 1e-7
"""Faces whose normals have at least this cosine are of one plane."""
ISOLATED = 0.02
"""The least difference of a moment of normals from the others: then its axis, such as that of a cylinder, is sure."""
MOST_FACES = 4_000
"""Of a scene, or of a larger part, the faces of the most area are looked at."""
ALONG = 0.999
"""Lines with at least this cosine have one direction: a part that has no other is round."""
WELL_BESIDE = 0.6
"""The first corner that is as far from the axis as this share of the farthest one: rounding does not choose it."""
SAME_AXIS = 1.0 - 1e-8
"""An axis with this cosine to one of the world is that one: 0.1 mrad."""
_SEEDS = 12


def part_axes(corners: Floats) -> list[Floats]:
    """Units along which a part is made: the normals of its largest planes, the axis of its round faces.

    corners: `(k, 3, 3)`, of its triangles.
    """
    normals, areas = _normals(_largest(corners))
    if not areas.sum() > 0.0:
        return []
    found = _planes(normals, areas)
    moments = (normals * areas[:, None]).T @ normals / areas.sum()
    values, vectors = np.linalg.eigh(moments)
    for n in range(3):
        if min(abs(float(values[n] - values[m])) for m in range(3) if m != n) > ISOLATED:
            found.append(vectors[:, n])
    return distinct(found)


def round_axis(axes: list[Floats]) -> Floats | None:
    """The axis of a part that has no other: of a ring, a disc, a shaft. None: it has several, or none."""
    return axes[0] if axes and all(abs(float(axes[0] @ other)) >= ALONG for other in axes[1:]) else None


def across_axis(axis: Floats, points: Floats) -> list[Floats]:
    """Two units across an axis, the first towards a point: the first `(n, 3)` that is well beside the mean of all."""
    aside = points - points.mean(axis=0)
    aside -= np.outer(aside @ axis, axis)
    far = np.linalg.norm(aside, axis=1)
    if not far.max(initial=0.0) > 0.0:
        return []
    first = aside[int(np.argmax(far >= WELL_BESIDE * far.max()))]
    first = first / np.linalg.norm(first)
    return [first, np.cross(axis, first)]


def scene_axes(scene: Scene) -> list[Floats]:
    """Three axes of a scene: of the planes of the most area, the next across the first. Where there are none, by the
    corners in their order, so that a scene in another pose has the same ones, turned."""
    mockup = scene.mockup
    faces = mockup.faces[scene.part_mask[mockup.part_of_face]]
    faces = faces[(faces < len(mockup.vertices)).all(axis=1)]
    normals, areas = _normals(_largest(mockup.vertices[faces]))
    found: list[Floats] = []
    for line in _planes(normals, areas) if areas.sum() > 0.0 else []:
        if all(abs(float(line @ other)) < 1e-3 for other in found):
            found.append(line)
    if len(found) == 2:
        found.append(np.cross(found[0], found[1]))
    corners = mockup.vertices[faces[:, 0]]
    if not found and len(corners):
        away = corners - corners.mean(axis=0)
        lengths = np.linalg.norm(away, axis=1)
        if lengths.max() > 0.0:
            first = int(np.argmax(lengths >= WELL_BESIDE * lengths.max()))
            found.append(away[first] / lengths[first])
    if len(found) == 1:
        found += across_axis(found[0], corners)
    return distinct([*found[:3], *([] if len(found) >= 3 else np.eye(3))])


def distinct(lines: list[Floats]) -> list[Floats]:
    """Units, either way, none twice; those along the world exactly so."""
    found: list[Floats] = []
    for line in lines:
        unit = line / np.linalg.norm(line)
        near = [axis for axis in np.eye(3) if abs(float(axis @ unit)) >= SAME_AXIS]
        unit = near[0] if near else unit
        if all(abs(float(unit @ other)) < SAME_AXIS for other in found):
            found.append(unit)
    return found


def is_face_normal(line: Floats, corners: Floats) -> bool:
    """Whether a unit is along the normal of one of some triangles `(k, 3, 3)`."""
    return bool((np.abs(_normals(corners)[0] @ line) >= SAME_PLANE).any())


def face_normals(corners: Floats) -> Floats:
    """The unit normals `(k, 3)` of those of some triangles that have one."""
    return _normals(corners)[0]


def _normals(corners: Floats) -> tuple[Floats, Floats]:
    """Units `(k, 3)`, and areas."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    is_face = twice > 0.0
    return across[is_face] / twice[is_face, None], 0.5 * twice[is_face]


def _largest(corners: Floats) -> Floats:
    """The triangles of the most area."""
    if len(corners) <= MOST_FACES:
        return corners
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.einsum("ij,ij->i", across, across)
    return np.asarray(corners[np.argpartition(areas, -MOST_FACES)[-MOST_FACES:]])


def _planes(normals: Floats, areas: Floats) -> list[Floats]:
    """The normals of the planes of the most area, both sides as one, the largest first."""
    total, left = float(areas.sum()), np.ones(len(areas), dtype=bool)
    found: list[tuple[float, Floats]] = []
    for _ in range(_SEEDS):
        if not left.any():
            break
        seed = normals[int(np.argmax(np.where(left, areas, -1.0)))]
        cosines = normals @ seed
        is_same = left & (np.abs(cosines) >= SAME_PLANE)
        mean = (normals[is_same] * (areas[is_same] * np.sign(cosines[is_same]))[:, None]).sum(axis=0)
        found.append((float(areas[is_same].sum()), mean / np.linalg.norm(mean)))
        left &= ~is_same
    found = [each for each in found if each[0] >= LEAST_SHARE * total]
    return [line for _, line in sorted(found, key=lambda each: -each[0])[:MOST_PLANES]]
