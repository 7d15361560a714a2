"""What is true of whole meshes: each pair decided exactly, or by a plain float64 brute force where there are many.

How two triangles meet is decided in `bench/judge.py`, in whole numbers; here is which pairs there are to decide. The
brute force is another way to find that out: Möller's test in float64, which knows when it is in doubt.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from judge import COPLANAR, CROSSING, TOUCHING, at_pose, has_area, kind_of_pair

__all__ = ["COPLANAR", "CROSSING", "TOUCHING", "Found", "at_pose", "collide", "collide_floats", "kind_of_pair"]

LARGEST = 1e100

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
    good = np.array([bool(s) or has_area(t) for s, t in zip(sure, corners, strict=True)], dtype=bool)
    return ids[good], corners[good]


def boxes_meet(p: Floats, q: Floats) -> npt.NDArray[np.bool_]:
    """`(len(p), len(q))`: whether the closed boxes of the triangles share a point. Comparisons only, so exact."""
    meet = np.ones((len(p), len(q)), dtype=bool)
    for a in range(3):
        p_low, p_high = p[:, :, a].min(axis=1), p[:, :, a].max(axis=1)
        q_low, q_high = q[:, :, a].min(axis=1), q[:, :, a].max(axis=1)
        meet &= p_low[:, None] <= q_high[None, :]
        meet &= q_low[None, :] <= p_high[:, None]
    return meet


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
