"""Normals of what is seen: facets of a curved surface look round, sharp edges stay sharp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CREASE_COS = np.cos(np.radians(38.0))  # neighbouring facets that bend less than this are one smooth surface
_MOST_NEIGHBOURS = 48  # a vertex with more triangles (the hub of a fan) keeps its facets flat


@dataclass(frozen=True)
class Triangles:
    """All bodies in one list. corners: indices (m, 3) into vertices; colour: (m, 3) linear light; xray: 0 to 1."""

    vertices: FloatArray
    corners: IntArray
    part: IntArray
    colour: npt.NDArray[np.float32]
    cut: npt.NDArray[np.bool_]
    xray: npt.NDArray[np.float32]


def join(bodies: list[Any]) -> Triangles:
    """The triangles of several bodies, parts numbered through."""
    vertices, corners, part, colour, cut, xray = [], [], [], [], [], []
    first_vertex = first_part = 0
    for body in bodies:
        count = len(body.faces)
        vertices.append(body.vertices)
        corners.append(body.faces.astype(np.int64) + first_vertex)
        part.append(body.part_of_face.astype(np.int64) + first_part)
        colour.append(linear_light(np.asarray(body.palette, dtype=np.float64)).astype(np.float32)[body.colour_of_face])
        cut.append(np.full(count, body.cut))
        shine = np.zeros(len(body.palette)) if body.xray is None else body.xray
        xray.append(np.asarray(shine, dtype=np.float32)[body.colour_of_face])
        first_vertex += len(body.vertices)
        first_part += len(body.paths)
    return Triangles(
        np.concatenate(vertices),
        np.concatenate(corners),
        np.concatenate(part),
        np.concatenate(colour),
        np.concatenate(cut),
        np.concatenate(xray),
    )


def linear_light(srgb: FloatArray) -> FloatArray:
    """sRGB values, 0 to 1, as amounts of light."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def closed_parts(area: FloatArray, corners: FloatArray, part: IntArray) -> npt.NDArray[np.int8]:
    """Per part: 1 where it is a closed solid facing outward, -1 facing inward, 0 where it is open.

    A closed surface's area vectors sum to zero; the sign of its volume says which way it faces.
    area: (m, 3), half the cross product of each triangle; corners: (m, 3, 3).
    """
    count = int(part.max()) + 1 if len(part) else 0
    total = np.bincount(part, np.sqrt(np.einsum("ij,ij->i", area, area)), count)
    centre = corners[:, 0]
    middle = _sums(part, centre, count)
    middle /= np.maximum(np.bincount(part, minlength=count), 1)[:, None]
    rest = _sums(part, area, count)
    volume = np.bincount(part, np.einsum("ij,ij->i", centre - middle[part], area), count)
    closed = np.sqrt(np.einsum("ij,ij->i", rest, rest)) < 1e-6 * np.maximum(total, 1e-300)
    return np.where(closed & (volume != 0), np.sign(volume), 0).astype(np.int8)


def corner_normals(triangles: Triangles, area: FloatArray, wanted: IntArray) -> tuple[FloatArray, FloatArray]:
    """Facet normals (k, 3) and corner normals (k, 3, 3) of the `wanted` triangles, unit length.

    A corner's normal is the mean, by area, of the facets around its vertex that bend less than the crease angle.
    """
    facet = _normalised(area[wanted])
    marked = np.zeros(len(triangles.vertices), dtype=bool)
    marked[triangles.corners[wanted]] = True
    near = np.flatnonzero(marked[triangles.corners].any(axis=1))
    # Corners of the triangles around, ordered by vertex: the fan of each vertex is one run.
    vertex = triangles.corners[near].ravel()
    order = np.argsort(vertex, kind="stable")
    fan_face = near[order // 3]
    fan_vertex = vertex[order]
    corner_vertex = triangles.corners[wanted].ravel()
    begin = np.searchsorted(fan_vertex, corner_vertex, side="left")
    size = np.searchsorted(fan_vertex, corner_vertex, side="right") - begin
    size[size > _MOST_NEIGHBOURS] = 0
    owner = np.repeat(np.arange(len(corner_vertex)), size)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(size) - size, size)
    neighbour = fan_face[begin[owner] + step]
    unit = _normalised(area)
    smooth = np.einsum("ij,ij->i", unit[neighbour], facet[owner // 3]) > _CREASE_COS
    owner, neighbour = owner[smooth], neighbour[smooth]
    total = _sums(owner, area[neighbour], len(corner_vertex))
    corner = _normalised(total).reshape(-1, 3, 3)
    empty = (corner == 0).all(axis=2)
    corner[empty] = np.repeat(facet[:, None], 3, axis=1)[empty]
    return facet, corner


def _sums(group: IntArray, vectors: FloatArray, count: int) -> FloatArray:
    """Sum of the vectors of each group, (count, 3)."""
    columns = [np.bincount(group, vectors[:, k], count) for k in range(3)]
    return np.stack(columns, axis=1).astype(np.float64)


def _normalised(vectors: FloatArray) -> FloatArray:
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    result: FloatArray = vectors / np.where(length > 0, length, 1.0)[:, None]
    return result
