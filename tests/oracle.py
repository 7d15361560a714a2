"""What is true: an exact oracle in rationals, slow and obvious, and a plain float64 brute force for larger meshes.

Both are written from the geometry alone. A triangle is the set of points spanned by its three corners. The set that two
triangles share is found by cutting one with the plane and the three sides of the other; what remains says whether they
meet, and how.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

COPLANAR, CROSSING, TOUCHING = 0, 1, 2
LARGEST = 1e100

Point = tuple[Fraction, Fraction, Fraction]
Floats = npt.NDArray[np.float64]
Found = dict[tuple[int, int], int]


def collide(mockup: Any, tool: Any, pose: npt.ArrayLike | None = None) -> Found:
    """(tool triangle, mock-up triangle) -> kind, for each pair that meets; exact. Meshes or (vertices, faces)."""
    (q_ids, q), (p_ids, p) = queried(mockup), queried(tool)
    p = at_pose(p, np.eye(4) if pose is None else np.asarray(pose))
    found = {}
    for i, j in np.argwhere(boxes_meet(p, q)):
        kind = kind_of_pair(p[i], q[j])
        if kind is not None:
            found[int(p_ids[i]), int(q_ids[j])] = kind
    return found


def collide_floats(mockup: Any, tool: Any, pose: npt.ArrayLike) -> tuple[Found, int]:
    """The same from float64 arithmetic; pairs it is in doubt about are decided exactly. Also how many those were."""
    (q_ids, q), (p_ids, p) = queried(mockup), queried(tool)
    p = at_pose(p, np.asarray(pose))
    pairs = np.argwhere(boxes_meet(p, q))
    kinds, doubtful = kinds_in_floats(p[pairs[:, 0]], q[pairs[:, 1]])
    found = {}
    for (i, j), kind, doubt in zip(pairs, kinds, doubtful, strict=True):
        true_kind = kind_of_pair(p[i], q[j]) if doubt else (CROSSING if kind else None)
        if true_kind is not None:
            found[int(p_ids[i]), int(q_ids[j])] = true_kind
    return found, int(doubtful.sum())


def queried(mesh: Any) -> tuple[npt.NDArray[np.int64], Floats]:
    """Ids and corners `(n, 3, 3)` of the triangles that count: in range, finite, not too large, with an area."""
    vertices, faces = mesh if isinstance(mesh, tuple) else (mesh.vertices, mesh.faces)
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces).astype(np.int64)
    ids = np.flatnonzero(((faces >= 0) & (faces < len(vertices))).all(axis=1))
    corners = vertices[faces[ids]]
    good = (np.abs(corners) <= LARGEST).all(axis=(1, 2))  # NaN compares false
    ids, corners = ids[good], corners[good]
    # Where floats are sure of an area there is one; the rest is looked at exactly.
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        normal, size = np.cross(u, v), np.abs(u).max(axis=1) * np.abs(v).max(axis=1)
        sure = (np.abs(normal).max(axis=1) > 1e-12 * size) & (size > 1e-250) & np.isfinite(size)
    good = np.array([bool(s) or has_area(exact(t)) for s, t in zip(sure, corners, strict=True)], dtype=bool)
    return ids[good], corners[good]


def at_pose(corners: Floats, pose: Floats) -> Floats:
    """Corners in the world, by the contract: ((r0*x + r1*y) + r2*z) + t, each operation rounded once."""
    x, y, z = (corners[..., a] for a in range(3))
    rows = [((pose[i, 0] * x + pose[i, 1] * y) + pose[i, 2] * z) + pose[i, 3] for i in range(3)]
    return np.stack(rows, axis=-1)


def boxes_meet(p: Floats, q: Floats) -> npt.NDArray[np.bool_]:
    """`(len(p), len(q))`: whether the closed boxes of the triangles share a point. Comparisons only, so exact."""
    meet = np.ones((len(p), len(q)), dtype=bool)
    for a in range(3):
        p_low, p_high = p[:, :, a].min(axis=1), p[:, :, a].max(axis=1)
        q_low, q_high = q[:, :, a].min(axis=1), q[:, :, a].max(axis=1)
        meet &= p_low[:, None] <= q_high[None, :]
        meet &= q_low[None, :] <= p_high[:, None]
    return meet


# --- exact ---------------------------------------------------------------------------------------------------------


def exact(triangle: npt.ArrayLike) -> list[Point]:
    """The corners as rationals: every float64 is one."""
    return [(Fraction(x), Fraction(y), Fraction(z)) for x, y, z in np.asarray(triangle, dtype=np.float64).tolist()]


def minus(a: Point, b: Point) -> Point:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Point, b: Point) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def normal_of(t: Sequence[Point]) -> Point:
    return cross(minus(t[1], t[0]), minus(t[2], t[0]))


def has_area(t: Sequence[Point]) -> bool:
    return any(normal_of(t))


def shared_points(p: Sequence[Point], q: Sequence[Point]) -> set[Point]:
    """Corners of the convex set that two triangles share; empty when they share nothing. `q` must have an area."""
    n = normal_of(q)
    polygon = list(p)
    for outward, corner in [(n, q[0]), ((-n[0], -n[1], -n[2]), q[0])]:  # the plane of q: two closed half-spaces
        polygon = cut(polygon, outward, corner)
    for a, b in [(0, 1), (1, 2), (2, 0)]:  # its three sides, which are upright on it and face outwards
        polygon = cut(polygon, cross(minus(q[b], q[a]), n), q[a])
    return set(polygon)


def cut(polygon: list[Point], outward: Point, corner: Point) -> list[Point]:
    """What remains of a convex polygon (also a segment or a point) in a closed half-space."""
    kept = []
    heights = [dot(outward, minus(x, corner)) for x in polygon]
    for i, (x, h) in enumerate(zip(polygon, heights, strict=True)):
        y, k = polygon[i - 1], heights[i - 1]
        if h * k < 0:
            share = h / (h - k)
            kept.append((x[0] + share * (y[0] - x[0]), x[1] + share * (y[1] - x[1]), x[2] + share * (y[2] - x[2])))
        if h <= 0:
            kept.append(x)
    return kept


def kind_of_pair(tool_triangle: npt.ArrayLike, mockup_triangle: npt.ArrayLike) -> int | None:
    """How two triangles meet, None when they do not. A tool triangle may have lost its area by rounding at its pose."""
    p, q = exact(tool_triangle), exact(mockup_triangle)
    n = normal_of(q)
    p_heights = [dot(n, minus(x, q[0])) for x in p]
    if all(h > 0 for h in p_heights) or all(h < 0 for h in p_heights):
        return None
    shared = shared_points(p, q)
    if not shared:
        return None
    if not any(p_heights):
        return COPLANAR
    m = normal_of(p)
    q_heights = [dot(m, minus(x, p[0])) for x in q]
    two_sided = all(min(h) < 0 < max(h) for h in (p_heights, q_heights))
    return CROSSING if two_sided and len(shared) > 1 else TOUCHING


# --- floats --------------------------------------------------------------------------------------------------------


def kinds_in_floats(p: Floats, q: Floats) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Whether each pair crosses by Möller's interval test, and whether that is in doubt by 1e-9 of the sizes involved.

    Without doubt a pair either crosses or is apart: every other kind of meeting is a limit case of some comparison.
    """
    with np.errstate(all="ignore"):
        scale = np.maximum(np.abs(p - q[:, :1]).max(axis=(1, 2)), np.abs(q - q[:, :1]).max(axis=(1, 2)))
        # Rounding acts on the coordinates, and what decides are lengths: both may count.
        doubt = 1e-9 * scale + 1e-13 * np.maximum(np.abs(p).max(axis=(1, 2)), np.abs(q).max(axis=(1, 2)))
        n_q, d_p, slim_q = heights(q, p)
        n_p, d_q, slim_p = heights(p, q)
        slack = doubt[:, None]
        apart = np.zeros(len(p), dtype=bool)
        for d in (d_p, d_q):
            apart |= (d > slack).all(axis=1) | (d < -slack).all(axis=1)
        flush = (np.abs(d_p) <= slack).any(axis=1) | (np.abs(d_q) <= slack).any(axis=1)
        line = np.cross(n_p, n_q)
        sine = np.linalg.norm(line, axis=1)
        line /= sine[:, None]
        low_p, high_p = interval(p - q[:, :1], d_p, line)
        low_q, high_q = interval(q - q[:, :1], d_q, line)
        gap = np.maximum(low_p, low_q) - np.minimum(high_p, high_q)
        # The smaller the angle between the planes, or the slimmer a triangle, the less sure the ends of the intervals.
        blur = doubt / np.minimum(sine, np.minimum(slim_p, slim_q))
        crossing = ~apart & (gap < -blur)
        doubtful = ~apart & (flush | ~(np.abs(gap) > blur))  # so that NaN is a doubt
    return crossing & ~doubtful, doubtful


def heights(t: Floats, points: Floats) -> tuple[Floats, Floats, Floats]:
    """Unit normals of triangles, heights of the points over their planes, and twice the area over the squared size."""
    u, v = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    normal = np.cross(u, v)
    length = np.linalg.norm(normal, axis=1)
    slimness = length / np.maximum((u * u).sum(axis=1), (v * v).sum(axis=1))
    normal = normal / length[:, None]
    return normal, np.einsum("na,nka->nk", normal, points - t[:, :1]), slimness


def interval(t: Floats, d: Floats, line: Floats) -> tuple[Floats, Floats]:
    """Where triangles with heights `d` over a plane cut the common line, as a range along it."""
    along = np.einsum("nka,na->nk", t, line)
    ends = []
    for i, j in [(0, 1), (1, 2), (2, 0)]:
        opposite = d[:, i] * d[:, j] < 0
        at = along[:, i] + (along[:, j] - along[:, i]) * d[:, i] / (d[:, i] - d[:, j])
        ends.append(np.where(opposite, at, np.nan))
    stacked = np.stack(ends)
    return np.fmin.reduce(stacked), np.fmax.reduce(stacked)
