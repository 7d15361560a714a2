"""How far the facets of each part are from the round surfaces that they stand for.

Corners of facets lie on the surface; between two corners, the facet cuts it off by the sagitta of the chord. Where two
facets of width `w` meet at an angle `t`, it is `w / 2 tan(t / 4)`. Flat parts have none.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Hashes = npt.NDArray[np.uint64]

SMOOTH_RAD = np.radians(46.0)
"""Facets that meet at a larger angle have an edge between them. A circle of 8 chords has 45 degrees, a hexagon 60."""
_SMOOTH_SHARE, _SHARP_SHARE = 0.625, 0.85
"""Shares of (length times angle times sagitta) and of (length times sagitta) that the area may be off, along smooth and
along sharp edges. The area of a long cylinder is off by a third of the first, that of its ends by two thirds of the
second; the rest is for spheres and uneven meshes."""
_TRIANGLES_AT_ONCE, _EDGES_AT_ONCE = 32_768, 8_192
_OF_PART = np.uint64(0xD6E8FEB86659FD93)


def chord_errors(
    vertices: Floats, faces: npt.NDArray[Any], part_of_face: npt.NDArray[Any], hashes: Hashes, count: int
) -> tuple[Floats, Floats]:
    """How far each part's facets may be from its surface, `(count,)` metres, and its area from that of the surface, m².

    hashes: of each vertex, equal for equal coordinates: meshes may have their own corners for each triangle. All
    indices of faces must be valid. Time: a sort of the edges.
    """
    chord, area = np.zeros(count), np.zeros(count)
    if (part_of_face[1:] < part_of_face[:-1]).any():
        order = np.argsort(part_of_face, kind="stable")
        faces, part_of_face = faces[order], part_of_face[order]
    ends = np.flatnonzero(np.diff(part_of_face, append=-1)) + 1
    begin = 0
    while begin < len(faces):
        place = min(int(np.searchsorted(ends, begin + _TRIANGLES_AT_ONCE)), len(ends) - 1)
        if ends[place] > begin + _TRIANGLES_AT_ONCE and place and ends[place - 1] > begin:
            place -= 1
        end = int(ends[place])
        part = part_of_face[begin:end]
        error, off = _of_triangles(vertices, faces[begin:end], part, hashes)
        starts = np.flatnonzero(np.diff(part, prepend=-1))
        chord[part[starts]] = np.maximum.reduceat(error, starts)
        area[part[starts]] = np.add.reduceat(off, starts)
        begin = end
    return chord, area


def _of_triangles(
    vertices: Floats, faces: npt.NDArray[Any], part: npt.NDArray[Any], hashes: Hashes
) -> tuple[Floats, Floats]:
    """For each triangle, how far it may be from the surface, metres, and how much its area may be off, m²."""
    one, other = _neighbours(hashes[faces], part)
    length, angle, width = np.concatenate(
        [
            _edges(vertices, faces, one[i : i + _EDGES_AT_ONCE], other[i : i + _EDGES_AT_ONCE])
            for i in range(0, max(len(one), 1), _EDGES_AT_ONCE)
        ],
        axis=1,
    )
    is_smooth = angle <= SMOOTH_RAD
    sagitta = np.where(is_smooth, 0.5 * width * np.tan(0.25 * angle), 0.0)
    first, second = one // 3, other // 3
    count = len(faces)
    error = _sums(np.concatenate([first, second]), np.concatenate([sagitta, sagitta]), count)
    both = 0.5 * (error[first] + error[second])
    most = np.maximum(error[first], error[second])
    off = length * np.where(is_smooth, _SMOOTH_SHARE * angle * both, _SHARP_SHARE * most)
    return error, _sums(first, off, count)


def _sums(places: npt.NDArray[np.intp], values: Floats, count: int) -> Floats:
    """The sum of the values at each place, `(count,)`."""
    return np.asarray(np.bincount(places, values, count), dtype=np.float64)


def _neighbours(hashes: Hashes, part: npt.NDArray[Any]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Pairs of triangles of one part that share an edge which no third has; each as 3 times the triangle, plus the
    corner that is opposite to the edge. hashes: `(n, 3)` of the corners."""
    edges = (np.roll(hashes, -1, axis=1) + np.roll(hashes, 1, axis=1)) ^ (part.astype(np.uint64) * _OF_PART)[:, None]
    keys = edges.ravel()
    order = np.argsort(keys)
    is_same = np.diff(keys[order]) == 0
    before, after = np.append(False, is_same[:-1]), np.append(is_same[1:], False)
    pairs = np.flatnonzero(is_same & ~before[: len(is_same)] & ~after[: len(is_same)])
    return order[pairs], order[pairs + 1]


def _edges(vertices: Floats, faces: npt.NDArray[Any], one: npt.NDArray[np.intp], other: npt.NDArray[np.intp]) -> Floats:
    """`(3, n)`: length of each edge, the angle by which the surface turns there, and the width of the narrower facet.

    Whichever way the triangles are oriented. For triangles without area, the length is 0 and the angle pi.
    """
    flat = faces.ravel()
    row, corner = one - one % 3, one % 3
    begin, end = (vertices[flat[row + (corner + step) % 3]] for step in (1, 2))
    along = end - begin
    with np.errstate(all="ignore"):
        square = np.einsum("ij,ij->i", along, along)
        heights = []
        for apex in (one, other):
            reach = vertices[flat[apex]] - begin
            heights.append(reach - along * (np.einsum("ij,ij->i", along, reach) / square)[:, None])
        widths = [np.sqrt(np.einsum("ij,ij->i", each, each)) for each in heights]
        cosine = -np.einsum("ij,ij->i", *heights) / (widths[0] * widths[1])
        found = np.array([np.sqrt(square), np.arccos(np.clip(cosine, -1.0, 1.0)), np.minimum(*widths)])
    is_sound = np.isfinite(found).all(axis=0)
    found[:, ~is_sound] = np.array([0.0, np.pi, 0.0])[:, None]
    return found
