"""Flat patches of triangles, and the runs of them that make cylinders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

FLAT_RAD = 0.002
"""Neighbours at a smaller angle are one patch: rounded coordinates tilt triangles."""
SMOOTH_RAD = 0.88
"""Neighbours at a smaller angle can be facets of one curved face: 50 degrees; those of a hexagon are 60 apart."""
PARALLEL = float(np.cos(np.radians(1.0)))
"""Cosine of the largest angle between edges of one cylinder."""
WIDER = 3.0
"""A patch this much wider than the next facet of a run is a flat face beside a fillet."""
NARROW = 1e-5
"""The least width of a facet, as a share of the whole."""
FLAT_OF_RUN = 1.6
"""A facet this much wider than the usual one of its run is a flat of a D-shaft."""
ROUND = 0.004
"""The largest mean distance of corners from their cylinder, as a share of its radius."""
TAPER = 0.003
"""The least lean of a cone's facets, as a sine; that of taper pins is 0.01."""
LEAST_ARC = 1.0
"""Runs that turn by less are no cylinders, radians."""


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A run of facets on a cylinder."""

    axis: Floats
    point: Floats
    """On the axis, in the middle of the run."""
    radius: float
    length: float
    is_hole: bool
    part: int
    patches: Ints


@dataclass(frozen=True, eq=False)
class Surfaces:
    """One side of a joint: its triangles by patches, and its cylinders."""

    corners: Floats
    """`(m, 3, 3)`"""
    normals: Floats
    areas: Floats
    part: Ints
    """The part of each triangle."""
    patch: Ints
    """The patch of each triangle."""
    bent: Floats
    """`(m, 3, 3)`: the normals at the corners, those of the curved face where the triangle is a facet of one."""
    cylinder: Ints
    """For each patch: its cylinder, or -1."""
    cylinders: list[Cylinder]


def components(count: int, a: Ints, b: Ints) -> Ints:
    """The component of each of `count` nodes, by the edges from `a` to `b`, numbered from 0."""
    label = np.arange(count)
    while True:
        low = np.minimum(label[a], label[b])
        before = label.copy()
        np.minimum.at(label, label[a], low)
        np.minimum.at(label, label[b], low)
        np.minimum.at(label, a, low)
        np.minimum.at(label, b, low)
        label = label[label]
        if np.array_equal(label, before):
            return np.asarray(np.unique(label, return_inverse=True)[1].reshape(-1), dtype=np.int64)


def surfaces_of(corners: Floats, part: Ints, scale: float) -> Surfaces:
    """The patches and cylinders of triangles `(m, 3, 3)`. scale: a length of the whole, metres."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    kept = twice > 1e-12 * scale * scale
    corners, part, twice = corners[kept], part[kept], twice[kept]
    normals = across[kept] / twice[:, None]
    count = len(corners)
    if not count:
        none = np.empty(0, dtype=np.int64)
        return Surfaces(corners, normals, twice / 2, part, none, np.empty((0, 3, 3)), none, [])
    vertices, faces = _welded(corners, part, scale)
    one, other, begin, end = _neighbours(faces)
    cosine = np.einsum("ij,ij->i", normals[one], normals[other])
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    flat = angle < FLAT_RAD
    patch = components(count, one[flat], other[flat])
    number = int(patch.max()) + 1
    area = np.bincount(patch, twice / 2, number).astype(np.float64)
    all_one, all_other, mild = one, other, angle < SMOOTH_RAD
    smooth = (angle >= FLAT_RAD) & (angle < SMOOTH_RAD) & (patch[one] != patch[other])
    one, other, begin, end = one[smooth], other[smooth], begin[smooth], end[smooth]
    centre = corners.mean(axis=1)
    convex = np.einsum("ij,ij->i", normals[one], centre[other] - centre[one]) < 0.0
    is_facet = _facets(patch[one], patch[other], area)
    cylinder = np.full(number, -1, dtype=np.int64)
    cylinders: list[Cylinder] = []
    sums = [np.bincount(patch, normals[:, k] * twice, number) for k in range(3)]
    patch_normal = np.stack(sums, axis=1).astype(np.float64)
    patch_normal /= np.maximum(np.linalg.norm(patch_normal, axis=1), 1e-300)[:, None]
    for edges in _runs(vertices[begin], vertices[end], patch[one], patch[other], convex, NARROW * scale):
        found = _cylinder_of(
            edges, vertices[begin], vertices[end], patch[one], patch[other], patch_normal, bool(convex[edges[0]])
        )
        if found is None:
            continue
        axis, point, radius, length, of = found
        of = of[cylinder[of] < 0]
        if len(of) < 3:
            continue
        cylinder[of] = len(cylinders)
        owner = int(part[one[edges[0]]])
        cylinders.append(Cylinder(axis, point, radius, length, not convex[edges[0]], owner, of))
    soft = is_facet[patch] & (cylinder[patch] < 0)
    mild &= soft[all_one] & soft[all_other]
    bent = _bent(corners, normals, faces, soft, components(count, all_one[mild], all_other[mild]))
    return Surfaces(corners, normals, twice / 2, part, patch, bent, cylinder, cylinders)


def _bent(corners: Floats, normals: Floats, faces: Ints, soft: Bools, smooth: Ints) -> Floats:
    """The normals at the corners: means over the triangles of one curved face, by their angles."""
    bent = np.repeat(normals[:, None, :], 3, axis=1)
    of = np.flatnonzero(soft)
    if not len(of):
        return bent
    ways = np.roll(corners[of], -1, axis=1) - corners[of]
    ways /= np.maximum(np.linalg.norm(ways, axis=2), 1e-300)[:, :, None]
    angles = np.arccos(np.clip(-np.einsum("ijk,ijk->ij", ways, np.roll(ways, 1, axis=1)), -1.0, 1.0)).reshape(-1)
    keys = faces[of].reshape(-1) * (int(smooth.max()) + 1) + np.repeat(smooth[of], 3)
    unique, index = np.unique(keys, return_inverse=True)
    each = np.repeat(normals[of], 3, axis=0) * angles[:, None]
    sums = [np.bincount(index.reshape(-1), each[:, k], len(unique)) for k in range(3)]
    mean = np.stack(sums, axis=1).astype(np.float64)
    mean /= np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None]
    bent[of] = mean[index.reshape(-1)].reshape(-1, 3, 3)
    return bent


def _welded(corners: Floats, part: Ints, scale: float) -> tuple[Floats, Ints]:
    flat = corners.reshape(-1, 3)
    grid = np.rint((flat - flat.min(axis=0)) / (1e-7 * scale)).astype(np.int64)
    keys = np.column_stack([np.repeat(part, 3), grid])
    order = np.lexsort(keys.T)
    new = np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    index = np.empty(len(flat), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    return flat[order[new]], index.reshape(-1, 3)


def _neighbours(faces: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """The two triangles and the two vertices of each edge that exactly two triangles share."""
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends.sort(axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends = ends[order]
    face = order // 3
    change = np.concatenate([[True], (np.diff(ends, axis=0) != 0).any(axis=1), [True]])
    first = np.flatnonzero(change)
    pairs = first[:-1][np.diff(first) == 2]
    return face[pairs], face[pairs + 1], ends[pairs, 0], ends[pairs, 1]


def _facets(one: Ints, other: Ints, area: Floats) -> Bools:
    """Patches with two smooth neighbours or more that are about as large."""
    a, b = np.concatenate([one, other]), np.concatenate([other, one])
    alike = (area[a] < 4.0 * area[b]) & (area[b] < 16.0 * area[a])
    return np.asarray(np.bincount(a[alike], minlength=len(area)) >= 2)


def _runs(start: Floats, end: Floats, one: Ints, other: Ints, convex: Bools, narrow: float) -> list[Ints]:
    """Edges between patches, in groups that are parallel and follow one another across facets."""
    count = len(start)
    if count < 3:
        return []
    way = end - start
    way /= np.linalg.norm(way, axis=1)[:, None]
    patch = np.concatenate([one, other])
    edge = np.concatenate([np.arange(count)] * 2)
    rng = np.random.default_rng(5)
    links = []
    for _ in range(3):
        # parallel edges of a patch are neighbours in the order of their share of any one direction
        share = np.abs(way @ rng.normal(size=3))[edge]
        order = np.lexsort((share, patch))
        a, b = edge[order[:-1]], edge[order[1:]]
        same = (patch[order[:-1]] == patch[order[1:]]) & (convex[a] == convex[b])
        same &= np.abs(np.einsum("ij,ij->i", way[a], way[b])) > PARALLEL
        links.append(np.stack([a[same], b[same]], axis=1))
    found = np.unique(np.sort(np.concatenate(links), axis=1), axis=0)
    if not len(found):
        return []
    a, b = found.T
    between = start[b] - start[a]
    width = np.linalg.norm(between - np.einsum("ij,ij->i", between, way[a])[:, None] * way[a], axis=1)
    least = np.full(count, np.inf)
    wide = width > narrow  # pieces of one edge are no facet
    np.minimum.at(least, a[wide], width[wide])
    np.minimum.at(least, b[wide], width[wide])
    good = width <= WIDER * np.minimum(least[a], least[b]) + narrow
    label = components(count, a[good], b[good])
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return [group for group in groups if len(group) >= 3]


def _cylinder_of(
    edges: Ints, start: Floats, end: Floats, one: Ints, other: Ints, normal: Floats, is_convex: bool
) -> tuple[Floats, Floats, float, float, Ints] | None:
    way = end[edges] - start[edges]
    way *= np.sign(way @ way[np.argmax(np.linalg.norm(way, axis=1))])[:, None]
    axis = way.sum(axis=0)
    axis /= np.linalg.norm(axis)
    patches = np.unique(np.concatenate([one[edges], other[edges]]))
    # the normals of facets of a cylinder lie in one plane: finer than the sum of edges
    lean = np.abs(normal[patches] @ axis)
    patches = patches[lean < 0.03]
    if len(patches) < 3:
        return None
    points = np.concatenate([start[edges], end[edges]])
    signed = normal[patches] @ axis
    if abs(signed.mean()) > max(TAPER, 3.0 * signed.std()):
        return None  # a cone
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    middle = points.mean(axis=0)
    x, y = (points - middle) @ u, (points - middle) @ v
    try:
        a, b, c = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones(len(x))]), x * x + y * y, rcond=None)[0]
    except np.linalg.LinAlgError:
        return None
    radius = float(np.sqrt(max(c + a * a + b * b, 0.0)))
    if not radius > 0.0:
        return None
    off = np.hypot(x - a, y - b) - radius
    if np.sqrt(np.mean(off * off)) > ROUND * radius:
        return None
    centre = middle + a * u + b * v
    bearing = np.arctan2(normal[patches] @ v, normal[patches] @ u)
    turned = np.sort(bearing)
    gaps = np.diff(np.concatenate([turned, [turned[0] + 2 * np.pi]]))
    if 2 * np.pi - gaps.max() < LEAST_ARC:
        return None
    # facets: the angle between the edges on both sides
    at = np.arctan2(y - b, x - a)
    half = np.zeros(len(patches))
    n = len(edges)
    for side in (one[edges], other[edges]):
        where = np.searchsorted(patches, side)
        where = np.minimum(where, len(patches) - 1)
        fits = patches[where] == side
        for k in (0, n):
            towards = bearing[where] + (0.0 if is_convex else np.pi)
            swing = np.abs((at[k : k + n] - towards + np.pi) % (2 * np.pi) - np.pi)
            np.maximum.at(half, where[fits], swing[fits])
    usual = float(np.median(half))
    patches = patches[(half <= FLAT_OF_RUN * usual + 1e-6) & (half < 0.6)]
    along = (points - centre) @ axis
    low, high = float(along.min()), float(along.max())
    return axis, centre + axis * (low + high) / 2, radius, high - low, patches
