"""Dirty triangles made good enough to recognise a shape: each once, and neighbours wound alike."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SAME_SHARE = 1e-6
"""Corners this near, as a share of the size, are one."""


def wound(vertices: Floats, faces: Ints) -> Ints:
    """The triangles `(m, 3)` without those that are repeated. A piece whose neighbours are wound against each other is
    wound anew, with its normals outwards; others stay as they are. `vertices` (n, 3)."""
    corners = _welded(vertices)[faces]
    _, first = np.unique(_keys(np.sort(corners, axis=1), len(vertices)), return_index=True)
    chosen = np.sort(first)
    faces, corners = faces[chosen], corners[chosen]
    pairs, is_alike = _neighbours(corners)
    if is_alike.all():
        return faces
    piece, is_turned = _turned(len(faces), pairs, is_alike)
    faces = faces.copy()
    for each in np.unique(piece[pairs[~is_alike, 0]]):
        own = np.flatnonzero(piece == each)
        turned = np.where(is_turned[own, None], faces[own][:, ::-1], faces[own])
        a, b, c = np.moveaxis(vertices[turned] - vertices[turned[0, 0]], 1, 0)
        is_outward = float(np.einsum("ij,ij->", a, np.cross(b, c))) >= 0.0
        faces[own] = turned if is_outward else turned[:, ::-1]
    return faces


def _welded(vertices: Floats) -> Ints:
    """Of each vertex the number of its place `(n,)`."""
    low = vertices.min(axis=0)
    size = float((vertices - low).max())
    if not size > 0.0:
        return np.zeros(len(vertices), dtype=np.int64)
    steps = np.round((vertices - low) / (SAME_SHARE * size)).astype(np.int64)
    _, place = np.unique(_keys(steps, round(1.0 / SAME_SHARE) + 1), return_inverse=True)
    return np.asarray(place.reshape(-1), dtype=np.int64)


def _keys(rows: Ints, count: int) -> Ints:
    """One number for each row `(n, 2 or 3)` of numbers below `count`, at most two million."""
    keys = rows[:, 0]
    for column in rows.T[1:]:
        keys = keys * count + column
    return np.asarray(keys)


def _neighbours(corners: Ints) -> tuple[Ints, npt.NDArray[np.bool_]]:
    """Pairs of triangles `(k, 2)` that alone share an edge, and whether both are wound alike."""
    ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    face = np.tile(np.arange(len(corners)), 3)
    is_edge = ends[:, 0] != ends[:, 1]
    ends, face = ends[is_edge], face[is_edge]
    is_up = ends[:, 0] < ends[:, 1]
    keys = _keys(np.sort(ends, axis=1), int(corners.max()) + 1)
    _, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    order = np.argsort(edge, kind="stable")
    order = order[count[edge[order]] == 2].reshape(-1, 2)
    return face[order], is_up[order[:, 0]] != is_up[order[:, 1]]


def _turned(count: int, pairs: Ints, is_alike: npt.NDArray[np.bool_]) -> tuple[Ints, npt.NDArray[np.bool_]]:
    """The piece of each triangle, and whether it has to be turned to be wound as the first of its piece."""
    around: list[list[tuple[int, bool]]] = [[] for _ in range(count)]
    for (a, b), alike in zip(pairs.tolist(), is_alike.tolist(), strict=True):
        around[a].append((b, alike))
        around[b].append((a, alike))
    piece, is_turned = np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=bool)
    for start in range(count):
        if piece[start] >= 0:
            continue
        piece[start], left = start, [start]
        while left:
            here = left.pop()
            for there, alike in around[here]:
                if piece[there] < 0:
                    piece[there], is_turned[there] = start, is_turned[here] ^ (not alike)
                    left.append(there)
    return piece, is_turned
