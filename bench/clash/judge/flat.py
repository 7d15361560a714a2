"""The depth of convex bodies by linear programs, and of pins in holes by plane polygons."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from .shapes import Convex, Floats

FEASIBLE = 1e-12
"""How far a corner may violate a constraint of a linear program, as a share of the size."""


def deepest_of_convex(a: Convex, b: Convex) -> float:
    """D of two convex bodies; negative if neither surface enters the other body."""
    return max(_deepest_of_faces(a, b), _deepest_of_faces(b, a))


def _deepest_of_faces(a: Convex, b: Convex) -> float:
    """The largest distance to the surface of `b`, over points of the faces of `a` inside `b`.

    Inside a convex body, the distance to the surface is the minimum of the distances to the planes of its faces. On a
    face of `a` with coordinates (u, v), its maximum is the largest t of a linear program in (u, v, t).
    """
    normals, offsets = b.planes()
    most = max(len(face) for face in a.faces)
    rows, sides = [], []
    for face, normal in zip(a.faces, a.planes()[0], strict=True):
        u = face[1] - face[0]
        u = u / np.linalg.norm(u)
        v = np.cross(normal, u)
        flat = (face - face[0]) @ np.stack([u, v], axis=1)
        along = np.roll(flat, -1, axis=0) - flat
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
        edges = np.column_stack([outward, np.zeros(len(flat))])
        beyond = (outward * flat).sum(axis=1)
        spare = most - len(face)
        planes = np.column_stack([normals @ u, normals @ v, np.ones(len(normals))])
        rows.append(np.concatenate([edges, np.repeat(edges[-1:], spare, axis=0), planes]))
        sides.append(np.concatenate([beyond, np.repeat(beyond[-1:], spare), offsets - normals @ face[0]]))
    return _greatest(np.array(rows), np.array(sides), most)


@cache
def _threes(number: int, edges: int) -> npt.NDArray[np.int64]:
    """All sets of three constraints that can bound t: at most two are edges."""
    return np.array([three for three in combinations(range(number), 3) if three[2] >= edges])


def _greatest(rows: Floats, sides: Floats, edges: int) -> float:
    """The largest t of several linear programs `rows @ (u, v, t) <= sides`, over all corners."""
    three = _threes(rows.shape[1], edges)
    a, b, c = (rows[:, three[:, i]] for i in range(3))
    p, q, r = (sides[:, three[:, i], None] for i in range(3))
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = (a * bc).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        points = (p * bc + q * ca + r * ab) / volume[..., None]
    size = float(np.abs(sides).max()) + 1e-300
    points = np.where((np.abs(volume) > 1e-9)[..., None], points, np.inf)
    with np.errstate(invalid="ignore"):
        inside = (np.einsum("fcx,fkx->fck", points, rows) <= sides[:, None] + FEASIBLE * size).all(axis=-1)
    return float(np.where(inside, points[..., 2], -np.inf).max())


def overlap_in_plane(pin: Floats, hole: Floats) -> float:
    """D of a long pin in a long hole, from their sections: plane convex polygons, counterclockwise.

    Points of the pin outside the hole lie inside the block. Their distance to the hole is convex, so it is largest at a
    corner of the pin. For points of the wall inside the pin, the distance to the pin is a minimum of linear functions,
    which is concave: bisection finds its maximum on each side of the hole.
    """
    at_corner = max(0.0, float(_distance_to_polygon(pin, hole).max()))
    normals, offsets = _sides(pin)
    first, last = hole, np.roll(hole, -1, axis=0)
    start = offsets[None] - first @ normals.T
    slope = (first - last) @ normals.T
    low, high = np.zeros(len(hole)), np.ones(len(hole))
    row = np.arange(len(hole))
    for _ in range(60):
        middle = (low + high) / 2
        active = (start + slope * middle[:, None]).argmin(axis=1)
        rises = slope[row, active] > 0
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
    on_wall = max(float((start + slope * s[:, None]).min(axis=1).max()) for s in (low, high))
    return max(at_corner, on_wall)


def _sides(polygon: Floats) -> tuple[Floats, Floats]:
    along = np.roll(polygon, -1, axis=0) - polygon
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    return normals, (normals * polygon).sum(axis=1)


def _distance_to_polygon(points: Floats, polygon: Floats) -> Floats:
    """The distance of each point to a convex polygon; 0 inside."""
    normals, offsets = _sides(polygon)
    is_outside = (points @ normals.T > offsets).any(axis=1)
    along = np.roll(polygon, -1, axis=0) - polygon
    apart = points[:, None] - polygon
    share = np.clip((apart * along).sum(axis=-1) / (along * along).sum(axis=-1), 0, 1)
    distance = np.linalg.norm(apart - share[..., None] * along, axis=-1).min(axis=1)
    found: Floats = np.where(is_outside, distance, 0.0)
    return found
