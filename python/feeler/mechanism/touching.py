"""Where two surfaces face each other: points, normals of both, and gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.mechanism.surfaces import Surfaces
from feeler.mockup import Mockup
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SAG = 0.12
"""How far facets may be from their cylinder, as a share of its radius: 0.08 for eight of them, on each side."""
FACING = -0.8
"""Cosine of the angle between the normals of surfaces that face each other."""
AGREE = 0.966
"""The same for the smooth faces: where they are at a larger angle than 15 degrees they only pass each other."""
PER_TRIANGLE = 4
MOST_PER_TRIANGLE = 48
MOST_MORE = 12.0
MORE = 3000
"""Points in addition, over the whole area."""
MOST = 40_000
"""Points of each side, at most."""


@dataclass(frozen=True, eq=False)
class Touches:
    """Pairs of points of two sides that face each other; all arrays have one entry for each."""

    points: Floats
    child_normals: Floats
    """Out of the child: it cannot move this way."""
    parent_normals: Floats
    """Into the parent; opposite to its own normals."""
    gaps: Floats
    weights: Floats
    child_cylinder: Ints
    """-1 for none."""
    parent_cylinder: Ints
    child_part: Ints
    parent_part: Ints
    is_of_child: Bools
    """Whether the point was chosen on the child, where its normal is that of the curved face."""

    def __len__(self) -> int:
        return len(self.gaps)


@dataclass(frozen=True, eq=False)
class _Samples:
    points: Floats
    smooth: Floats
    """On the cylinder instead of its facet."""
    normals: Floats
    weights: Floats
    triangles: Ints


def touches_of(child: Surfaces, parent: Surfaces, reach: float) -> Touches:
    """The points of both sides that face the other one within `reach`, metres, before or behind it."""
    rows = [_facing(child, parent, reach), _facing(parent, child, reach)]
    (p, n, other_n, gap, w, t, s), (q, m, other_m, gap2, w2, t2, s2) = rows
    own = np.concatenate([t, s2])
    others = np.concatenate([s, t2])
    one, two = np.concatenate([n, other_m]), -np.concatenate([other_n, m])
    kept = np.einsum("ij,ij->i", one, two) > AGREE
    own, others = own[kept], others[kept]
    return Touches(
        np.concatenate([p, q])[kept],
        one[kept],
        two[kept],
        np.concatenate([gap, gap2])[kept],
        np.concatenate([w, w2])[kept],
        child.cylinder[child.patch[own]],
        parent.cylinder[parent.patch[others]],
        child.part[own],
        parent.part[others],
        np.arange(len(p) + len(q))[kept] < len(p),
    )


def _facing(side: Surfaces, other: Surfaces, reach: float) -> tuple[Floats, Floats, Floats, Floats, Floats, Ints, Ints]:
    low, high = other.corners.min(axis=(0, 1)) - reach, other.corners.max(axis=(0, 1)) + reach
    samples = _samples(side, low, high)
    radius = np.array([c.radius for c in side.cylinders] + [0.0])[side.cylinder[side.patch[samples.triangles]]]
    length = np.maximum(reach, SAG * radius)
    scene = Scene(Mockup(other.corners.reshape(-1, 3), np.arange(3 * len(other.corners)).reshape(-1, 3)))
    count = len(samples.points)
    best = np.full(count, np.inf)
    hit = np.full(count, -1, dtype=np.int64)
    where = np.zeros((count, 3))
    for sign in (1.0, -1.0):
        if not count:
            break
        rays = scene.rays(samples.points, sign * samples.normals, within=float(length.max()))
        distance, triangle = rays.distances, rays.triangles
        facing = np.einsum("ij,ij->i", other.normals[triangle], samples.normals) < FACING
        good = (triangle >= 0) & (distance <= length) & facing & (distance < best)
        best[good], hit[good], where[good] = distance[good], triangle[good], rays.points[good]
    kept = hit >= 0
    hit = hit[kept]
    points, normal = samples.smooth[kept], samples.normals[kept]
    where, facing_normal = _smoothed(other, where[kept], hit, False)
    gap = np.einsum("ij,ij->i", where - points, normal)
    return points, normal, facing_normal, gap, samples.weights[kept], samples.triangles[kept], hit


def _smoothed(side: Surfaces, points: Floats, triangles: Ints, is_facet_normal: bool) -> tuple[Floats, Floats]:
    """Points on their cylinders, and the normals of the curved faces there."""
    points, normals = points.copy(), _interpolated(side, points, triangles)
    of = side.cylinder[side.patch[triangles]]
    on = np.flatnonzero(of >= 0)
    if len(on):
        of = of[on]
        axis = np.array([c.axis for c in side.cylinders])[of]
        foot = np.array([c.point for c in side.cylinders])[of]
        radius = np.array([c.radius for c in side.cylinders])[of]
        sign = np.array([-1.0 if c.is_hole else 1.0 for c in side.cylinders])[of]
        across = points[on] - foot
        along = np.einsum("ij,ij->i", across, axis)[:, None] * axis
        across -= along
        if is_facet_normal:
            flat = side.normals[triangles[on]]
            across = sign[:, None] * (flat - np.einsum("ij,ij->i", flat, axis)[:, None] * axis)
        across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
        points[on] = foot + along + radius[:, None] * across
        normals[on] = sign[:, None] * across
    return points, normals


def _interpolated(side: Surfaces, points: Floats, triangles: Ints) -> Floats:
    """The normals between those at the corners."""
    corners, bent = side.corners[triangles], side.bent[triangles]
    shares = []
    for k in range(3):
        one, other = corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]
        shares.append(np.einsum("ij,ij->i", np.cross(one - points, other - points), side.normals[triangles]))
    weights = np.maximum(np.stack(shares, axis=1), 0.0)
    normals = np.asarray(np.einsum("ij,ijk->ik", weights, bent), dtype=np.float64)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None])


def _samples(side: Surfaces, low: Floats, high: Floats) -> _Samples:
    """Points on the triangles inside a box, many on large ones; in the middle of the width of facets of cylinders."""
    near = ((side.corners.min(axis=1) <= high) & (side.corners.max(axis=1) >= low)).all(axis=1)
    patch = side.patch
    many = np.flatnonzero(near)
    total = float(side.areas[many].sum()) if len(many) else 1.0
    # more of a triangle that is long beside the box, so that as many are inside
    below, above = side.corners[many].min(axis=1), side.corners[many].max(axis=1)
    inner = np.minimum(above, high) - np.maximum(below, low)
    share = np.prod(np.clip(inner / np.maximum(above - below, 1e-300), 1.0 / MOST_MORE, 1.0), axis=1)
    more = (MORE * side.areas[many] / max(total, 1e-300)).astype(np.int64)
    counts = np.minimum(PER_TRIANGLE + more, MOST_PER_TRIANGLE)
    counts = np.ceil(counts / np.maximum(share, 1.0 / MOST_MORE)).astype(np.int64)
    if counts.sum() > 4 * MOST:
        counts = np.maximum(counts * (4.0 * MOST / counts.sum()), 1.0).astype(np.int64)
    triangle = np.repeat(many, counts)
    turn = np.arange(len(triangle))
    a, b = (0.5 + 0.7548776662466927 * turn) % 1.0, (0.5 + 0.5698402909980532 * turn) % 1.0
    flip = a + b > 1.0
    a, b = np.where(flip, 1.0 - a, a), np.where(flip, 1.0 - b, b)
    a, b = 0.02 + 0.94 * a, 0.02 + 0.94 * b
    corner = side.corners[triangle]
    points = corner[:, 0] + a[:, None] * (corner[:, 1] - corner[:, 0]) + b[:, None] * (corner[:, 2] - corner[:, 0])
    weights = side.areas[triangle] / np.repeat(counts, counts)
    number = len(side.cylinder)
    centre = side.corners.mean(axis=1)
    area = np.bincount(patch, side.areas, number)
    sums = [np.bincount(patch, side.areas * centre[:, k], number) for k in range(3)]
    middle = np.stack(sums, axis=1).astype(np.float64)
    middle /= np.maximum(area, 1e-300)[:, None]
    # to the middle of the facet of a cylinder, where it has the direction of the cylinder
    on = np.flatnonzero(side.cylinder[patch[triangle]] >= 0)
    if len(on):
        axis = np.array([c.axis for c in side.cylinders])[side.cylinder[patch[triangle[on]]]]
        tangent = np.cross(side.normals[triangle[on]], axis)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
        off = np.einsum("ij,ij->i", middle[patch[triangle[on]]] - points[on], tangent)
        points[on] += off[:, None] * tangent
    inside = ((points >= low) & (points <= high)).all(axis=1)
    triangle, points, weights = triangle[inside], points[inside], weights[inside]
    if len(triangle) > MOST:
        step = np.linspace(0, len(triangle) - 1, MOST).astype(np.int64)
        weights = weights[step] * (len(triangle) / MOST)
        triangle, points = triangle[step], points[step]
    smooth, normals = _smoothed(side, points, triangle, True)
    return _Samples(points, smooth, normals, weights, triangle)
