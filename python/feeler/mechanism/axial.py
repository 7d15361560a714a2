"""How far one side can slide along an axis until faces across it meet."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]

ACROSS = 0.8
"""Faces whose normals lean less than this from the axis, as a cosine, stop a slide."""
_EACH = 64
_MOST = 40_000


def axial_play(child: Floats, parent: Floats, direction: Floats, limit: float, area: float) -> tuple[float, float]:
    """How far the child can go along a direction, and against it, metres; infinite where nothing is within `limit`.

    child and parent: triangles `(m, 3, 3)`. area: faces of less than this, square metres, do not stop it.
    """
    ahead = _distance(child, parent, direction, limit, area)
    return ahead, _distance(child, parent, -direction, limit, area)


def _distance(child: Floats, parent: Floats, direction: Floats, limit: float, area: float) -> float:
    own, own_areas = _facing(child, direction)
    others, _ = _facing(parent, -direction)
    if not len(own) or not len(others):
        return np.inf
    each = int(np.clip(_MOST // len(own), 1, _EACH))
    turn = np.arange(each * len(own))
    a, b = (0.5 + 0.7548776662466927 * turn) % 1.0, (0.5 + 0.5698402909980532 * turn) % 1.0
    flip = a + b > 1.0
    a, b = np.where(flip, 1.0 - a, a), np.where(flip, 1.0 - b, b)
    of = np.repeat(np.arange(len(own)), each)
    edges = own[:, 1:] - own[:, :1]
    points = own[of, 0] + a[:, None] * edges[of, 0] + b[:, None] * edges[of, 1]
    # faces in contact may cross by rounding: begin a little behind
    back = 1e-3 * limit
    scene = Scene(Mockup(others.reshape(-1, 3), np.arange(3 * len(others)).reshape(-1, 3)))
    rays = scene.rays(points - back * direction, np.broadcast_to(direction, points.shape), within=limit + back)
    met = rays.triangles >= 0
    distances, weights = np.maximum(rays.distances[met] - back, 0.0), own_areas[of[met]] / each
    order = np.argsort(distances, kind="stable")
    total = np.cumsum(weights[order])
    return float(distances[order][np.searchsorted(total, area)]) if len(total) and total[-1] > area else np.inf


def _facing(corners: Floats, direction: Floats) -> tuple[Floats, Floats]:
    """The triangles whose normals are along a direction, and their areas as seen along it."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    along, twice = across @ direction, np.linalg.norm(across, axis=1)
    kept = (along > ACROSS * twice) & (twice > 0.0)
    return corners[kept], along[kept] / 2.0
