"""The angles over which two triangles collide while one of them turns about the z axis: closed forms.

Two triangles begin or cease to collide where a corner of one lies in the plane of the other or two edges are coplanar.
For a rotation R about z each of these is `u . R v = w`, that is a cos t + b sin t = c, with at most two roots (Canny
1986 has the same for a cube's rotations). Between two roots nothing changes, so one test between them decides.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

FLUSH = 1e-12
"""Gaps below this share of the triangles' coordinates count as contact, because rounding opens and closes them. With a
larger value, blocked angles extend slightly too far."""
_LEVEL = 1e-9  # the largest lean from z of the normals of two triangles that can slide in one plane across z
_NEXT = np.array([1, 2, 0])


def angular_spans(triangles: Floats) -> tuple[Floats, Floats]:
    """Middle and half-width of the angles about z that each triangle `(n, 3, 3)` covers, radians; pi around the
    axis."""
    angles = np.arctan2(triangles[..., 1], triangles[..., 0])
    off = (angles - angles[:, :1] + np.pi) % (2.0 * np.pi) - np.pi
    low, high = _least(off), -_least(-off)
    # A triangle around the axis has it on one side of all edges; corners of any other are less than pi apart.
    edges = triangles[:, _NEXT, :2] - triangles[..., :2]
    side = edges[..., 0] * triangles[..., 1] - edges[..., 1] * triangles[..., 0]
    is_around = (_least(side) >= 0.0) | (_least(-side) >= 0.0) | (high - low >= np.pi)
    return angles[:, 0] + 0.5 * (low + high), np.where(is_around, np.pi, 0.5 * (high - low))


def _least(each: Floats) -> Floats:
    """The least of three along the last axis, faster than numpy's own for so short an axis."""
    return np.asarray(np.minimum(np.minimum(each[..., 0], each[..., 1]), each[..., 2]))


def blocked_turns(turning: Floats, fixed: Floats) -> tuple[Floats, Floats]:
    """For each pair of triangles, the interval of rotations about z, radians, around 0, over which they collide.

    `turning`, `fixed`: `(k, 3, 3)`, at rotation 0. Returns `low <= 0 <= high`, each `(k,)`, at most a whole turn apart;
    both are 0 if the pair does not collide at rotation 0.
    """
    middle_a, half_a = angular_spans(turning)
    middle_b, half_b = angular_spans(fixed)
    apart = (middle_b - middle_a + np.pi) % (2.0 * np.pi) - np.pi
    reach = half_a + half_b
    is_whole = reach + np.abs(apart) >= np.pi
    first = np.where(is_whole, -np.pi, np.minimum(apart - reach, 0.0))
    last = np.where(is_whole, np.pi, np.maximum(apart + reach, 0.0))
    roots = _roots(turning, fixed)
    roots = np.where((roots > first[:, None]) & (roots < last[:, None]), roots, last[:, None])
    ends = np.sort(np.concatenate([first[:, None], roots, last[:, None]], axis=1), axis=1)
    low, high = np.zeros(len(turning)), np.zeros(len(turning))
    cell = np.clip((ends <= 0.0).sum(axis=1) - 1, 0, ends.shape[1] - 2)
    rows, columns = np.nonzero(np.diff(ends, axis=1) > 0.0)
    is_met = np.zeros((len(ends), ends.shape[1] - 1), dtype=bool)
    turns = 0.5 * (ends[rows, columns] + ends[rows, columns + 1])
    is_met[rows, columns] = _meet(_turned(turning[rows], turns), fixed[rows])
    is_met |= np.diff(ends, axis=1) <= 0.0  # equal roots have nothing between them
    index = np.arange(is_met.shape[1])
    is_here = is_met[np.arange(len(cell)), cell]
    after = np.where(~is_met & (index > cell[:, None]), index, is_met.shape[1]).min(axis=1)
    before = np.where(~is_met & (index < cell[:, None]), index, -1).max(axis=1)
    each = np.arange(len(cell))
    high[is_here] = ends[each, after][is_here]
    low[is_here] = ends[each, before + 1][is_here]
    return low, high


def _roots(a: Floats, b: Floats) -> Floats:
    """The rotations at which two triangles may begin or cease to collide, `(k, m)`, radians in -pi..pi; NaN for
    none."""
    edges_a, edges_b = a[:, _NEXT] - a, b[:, _NEXT] - b
    normals_a = np.cross(edges_a[:, 0], edges_a[:, 1])
    normals_b = np.cross(edges_b[:, 0], edges_b[:, 1])
    moments_a, moments_b = np.cross(a, edges_a), np.cross(b, edges_b)
    corner_a = _form(normals_b[:, None], a)
    corner_a[2] += -np.einsum("ki,ki->k", normals_b, b[:, 0])[:, None]
    corner_b = _form(b, normals_a[:, None])
    corner_b[2] += -np.einsum("ki,ki->k", normals_a, a[:, 0])[:, None]
    crossing = _form(edges_b[:, None], moments_a[:, :, None]) + _form(moments_b[:, None], edges_a[:, :, None])
    forms = [corner_a, corner_b, crossing.reshape(3, len(a), 9)]
    lengths = [np.linalg.norm(normals, axis=1) for normals in (normals_a, normals_b)]
    is_level = [np.abs(n[:, 2]) >= (1.0 - _LEVEL) * s for n, s in zip((normals_a, normals_b), lengths, strict=True)]
    if (is_level[0] & is_level[1]).any():
        across_a = np.stack([-edges_a[..., 1], edges_a[..., 0], np.zeros(edges_a.shape[:2])], axis=-1)
        across_b = np.stack([-edges_b[..., 1], edges_b[..., 0], np.zeros(edges_b.shape[:2])], axis=-1)
        slide_a = _form(across_b[:, None], a[:, :, None])
        slide_a[2] -= np.einsum("kji,kji->kj", across_b, b)[:, None]
        slide_b = _form(b[:, None], across_a[:, :, None])
        slide_b[2] -= np.einsum("kji,kji->kj", across_a, a)[:, :, None]
        forms += [slide_a.reshape(3, len(a), 9), slide_b.reshape(3, len(a), 9)]
    cosine, sine, constant = np.concatenate(forms, axis=2)
    size = np.hypot(cosine, sine)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = -constant / size
        half = np.arccos(np.where(np.abs(ratio) <= 1.0 + 1e-12, np.clip(ratio, -1.0, 1.0), np.nan))
    phase = np.arctan2(sine, cosine)
    roots = np.concatenate([phase + half, phase - half], axis=1)
    return np.asarray((roots + np.pi) % (2.0 * np.pi) - np.pi)


def _form(u: Floats, v: Floats) -> Floats:
    """(3, ...): the coefficients of cosine, sine and 1 in u . R v."""
    return np.stack(
        [
            u[..., 0] * v[..., 0] + u[..., 1] * v[..., 1],
            u[..., 1] * v[..., 0] - u[..., 0] * v[..., 1],
            u[..., 2] * v[..., 2],
        ]
    )


def _turned(triangles: Floats, turns: Floats) -> Floats:
    cosine, sine = np.cos(turns)[:, None], np.sin(turns)[:, None]
    x, y, z = triangles[..., 0], triangles[..., 1], triangles[..., 2]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)


def _meet(a: Floats, b: Floats) -> Flags:
    """Whether two triangles `(n, 3, 3)` collide: no axis separates them (Gottschalk, Lin, Manocha 1996)."""
    edges_a, edges_b = a[:, _NEXT] - a, b[:, _NEXT] - b
    normal_a = np.cross(edges_a[:, 0], edges_a[:, 1])[:, None]
    normal_b = np.cross(edges_b[:, 0], edges_b[:, 1])[:, None]
    directions = [
        normal_a,
        normal_b,
        np.cross(edges_a[:, :, None], edges_b[:, None]).reshape(-1, 9, 3),
        np.cross(normal_a, edges_a),
        np.cross(normal_b, edges_b),
    ]
    ways = np.concatenate(directions, axis=1)
    length = np.linalg.norm(ways, axis=2)
    scale = np.maximum(np.abs(a).max(axis=(1, 2)), np.abs(b).max(axis=(1, 2)))[:, None]
    on_a, on_b = np.einsum("ndi,nci->ndc", ways, a), np.einsum("ndi,nci->ndc", ways, b)
    gap = np.maximum(_least(on_a) + _least(-on_b), _least(on_b) + _least(-on_a))
    size = np.maximum(np.linalg.norm(edges_a, axis=2).max(axis=1), np.linalg.norm(edges_b, axis=2).max(axis=1))
    degree = np.repeat([2.0, 2.0, 2.0, 3.0, 3.0], [1, 1, 9, 3, 3])
    is_direction = length > 1e-12 * size[:, None] ** degree
    return np.asarray(~(is_direction & (gap > FLUSH * scale * length)).any(axis=1))
