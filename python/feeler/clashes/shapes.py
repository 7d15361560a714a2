"""Shape and place of each part, to recognise renamed parts.

    Mockup -> Shapes (a row for each part) -> matching.py; a file has the rows of parts with findings

Shapes need a pass over all triangles, so `PartShapes` computes them when a table is first compared or saved.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.clashes.chords import chord_errors
from feeler.clashes.tracking import part_keys
from feeler.mockup import Mockup
from feeler.short_reprs import shortly

Floats = npt.NDArray[np.float64]
Hashes = npt.NDArray[np.uint64]

_TRIANGLES_AT_ONCE = 32_768  # 2.4 MB of corners: they stay in the cache
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)
"""The multipliers of splitmix64 (Steele, Lea and Flood 2014)."""
_DIGITS = 9
"""Decimals of a metre: rounding hides the order of summation, so that a file does not depend on it."""


@shortly
@dataclass(frozen=True, eq=False)
class Shapes:
    """A row for each part, metres; NaN if the shape is not known.

    keys: as in `part_keys`. paths: without the `#2` of equal paths. content: a hash of all corners of all triangles
    that does not depend on their order. box: `(n, 2, 3)`, lower and upper corner. middle: `(n, 3)`, the centroid of the
    surface. area: `(n,)`, square metres. triangles: `(n,)`, their number. chord: `(n,)`, how far the facets may be from
    the surface that they stand for, 0 for flat parts. area_error: `(n,)`, how much the area may be off by that, square
    metres. Files of older versions lack the last three: 0, and NaN.
    """

    keys: tuple[str, ...]
    paths: tuple[str, ...]
    content: Hashes
    box: Floats
    middle: Floats
    area: Floats
    triangles: npt.NDArray[np.int64]
    chord: Floats
    area_error: Floats

    @property
    def is_known(self) -> npt.NDArray[np.bool_]:
        """`(n,)`: whether the shape is known."""
        return np.isfinite(self.area)

    def rows(self, chosen: Sequence[int]) -> Shapes:
        """The chosen rows, in the given order."""
        index = np.array(chosen, dtype=np.intp)
        names = ([each[i] for i in chosen] for each in (self.keys, self.paths))
        keys, paths = map(tuple, names)
        return Shapes(keys, paths, *(getattr(self, name)[index] for name in ARRAYS))

    def with_siblings(self, keys: Iterable[str]) -> Shapes:
        """The known rows of these parts and of all parts with the same paths, sorted by key."""
        wanted = set(keys)
        paths = {path for key, path in zip(self.keys, self.paths, strict=True) if key in wanted}
        known = np.flatnonzero(self.is_known).tolist()
        return self.rows(sorted((i for i in known if self.paths[i] in paths), key=lambda i: self.keys[i]))

    def joined(self, other: Shapes) -> Shapes:
        """These rows, and the rows of `other` with new keys."""
        here = set(self.keys)
        more = other.rows([i for i, key in enumerate(other.keys) if key not in here])
        arrays = (np.concatenate([getattr(self, name), getattr(more, name)]) for name in ARRAYS)
        return Shapes(self.keys + more.keys, self.paths + more.paths, *arrays)


ARRAYS = ("content", "box", "middle", "area", "triangles", "chord", "area_error")
"""The arrays of `Shapes`, in order."""


def unknown(keys: Sequence[str], paths: Sequence[str] | None = None) -> Shapes:
    """Rows for parts of unknown shape."""
    n = len(keys)
    nothing = (np.full((n, 2, 3), np.nan), np.full((n, 3), np.nan), np.full(n, np.nan))
    counts = (np.zeros(n, dtype=np.int64), np.full(n, np.nan), np.full(n, np.nan))
    hashes = np.zeros(n, dtype=np.uint64)
    return Shapes(tuple(keys), tuple(keys if paths is None else paths), hashes, *nothing, *counts)


def shapes_of(mockup: Mockup, *, with_chords: bool = True) -> Shapes:
    """A row for each part of a mock-up. Parts without valid triangles are unknown.

    Linear in the triangles, but for a sort of their edges. with_chords: whether to sort them, for `chord` and
    `area_error`; else these are NaN.
    """
    count = mockup.part_count
    vertices = np.concatenate([mockup.vertices, np.full((1, 3), np.nan)])
    axes = np.ascontiguousarray(vertices.T)
    hashes = _hashes(vertices)
    faces, part_of_face = mockup.faces, mockup.part_of_face
    content = np.zeros(count, dtype=np.uint64)
    sums = np.zeros((4, count))
    for begin in range(0, len(faces), _TRIANGLES_AT_ONCE):
        # An index out of range means the vertex of NaN behind the last one.
        some = np.minimum(faces[begin : begin + _TRIANGLES_AT_ONCE], len(vertices) - 1)
        corners = np.ascontiguousarray(some.T, dtype=np.intp)
        part = part_of_face[begin : begin + _TRIANGLES_AT_ONCE]
        if (part[1:] < part[:-1]).any():
            order = np.argsort(part, kind="stable")
            part, corners = part[order], corners[:, order]
        starts = np.flatnonzero(np.concatenate([[True], part[1:] != part[:-1]]))
        parts = part[starts]
        total = hashes[corners[0]] + hashes[corners[1]] + hashes[corners[2]]
        content[parts] += np.add.reduceat(total, starts)
        for sum_of_part, values in zip(sums, _areas(axes, corners), strict=True):
            sum_of_part[parts] += np.add.reduceat(values, starts)
    box = np.array(mockup.part_bounds, dtype=np.float64).reshape(count, 2, 3)
    is_empty = ~(np.isfinite(box).all(axis=(1, 2)) & (box[:, 0] <= box[:, 1]).all(axis=1))
    with np.errstate(invalid="ignore", divide="ignore"):
        middle = np.where(sums[0] > 0.0, sums[1:] / (3.0 * sums[0]), box.mean(axis=1).T).T
    middle[is_empty] = box[is_empty] = np.nan
    area: Floats = np.where(is_empty, np.nan, sums[0])
    errors = np.full(count, np.nan), np.full(count, np.nan)
    if with_chords:
        errors = chord_errors(vertices, np.minimum(faces, len(vertices) - 1), part_of_face, hashes, count)
    triangles = np.bincount(part_of_face, minlength=count).astype(np.int64)
    keys = tuple(part_keys(mockup.part_paths))
    rounded = (middle.round(_DIGITS), area.round(2 * _DIGITS))
    area_error = np.array([float(f"{each:.6g}") for each in errors[1].tolist()])
    figures = (*rounded, triangles, errors[0].round(_DIGITS), area_error)
    return Shapes(keys, tuple(mockup.part_paths), content, box, *figures)


def _hashes(vertices: Floats) -> Hashes:
    """A hash of each vertex. Equal coordinates have equal hashes; 0.0 equals -0.0."""
    x, y, z = np.ascontiguousarray((vertices + 0.0).view(np.uint64).T)
    found: Hashes = (x ^ _FACTORS[2]) * _FACTORS[0]
    for coordinate, factor in ((y, _FACTORS[1]), (z, _FACTORS[2])):
        found ^= found >> np.uint64(32)
        found += coordinate
        found *= factor
    found ^= found >> np.uint64(29)
    found *= _FACTORS[0]
    found ^= found >> np.uint64(32)
    return found


def _areas(axes: Floats, corners: npt.NDArray[Any]) -> list[Floats]:
    """The area of each triangle, and the area times the sum of its corners by axis; 0 if a corner is not finite."""
    a, b, c = ([axis[corner] for axis in axes] for corner in corners)
    with np.errstate(over="ignore", invalid="ignore"):
        u, v = ([q - p for p, q in zip(a, far, strict=True)] for far in (b, c))
        normal = [u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)]
        area = 0.5 * np.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
        found = [area, *(area * (p + q + r) for p, q, r in zip(a, b, c, strict=True))]
        if np.isfinite([each.sum() for each in found]).all():
            return found
    is_sound = np.isfinite(found).all(axis=0)
    return [np.where(is_sound, each, 0.0) for each in found]


class PartShapes:
    """The shapes of the parts, computed on first use. All tables of a check share one instance."""

    def __init__(self, source: Mockup | Shapes) -> None:
        self._source = source

    def get(self) -> Shapes:
        """The shapes. Drops the reference to the mock-up."""
        if isinstance(self._source, Mockup):
            self._source = shapes_of(self._source)
        return self._source

    def __reduce__(self) -> tuple[type[PartShapes], tuple[Shapes]]:
        return (type(self), (self.get(),))
