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


def scene_axes(scene: Scene) -> list[Floats]:
    """Three axes of a scene: of the planes of the most area, the next across the first; those of the world where there
    are none."""
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
    return distinct([*found[:3], *([] if len(found) == 3 else np.eye(3))])


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
