"""Poses as (4, 4) arrays, rotations as vectors: direction the axis, length the angle in radians."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def rotation(vector: npt.ArrayLike) -> Floats:
    """The rotation matrix (3, 3) of a rotation vector (Rodrigues)."""
    v = np.asarray(vector, dtype=np.float64)
    angle = float(np.sqrt(v @ v))
    x, y, z = v
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-8:
        first, second = 1.0 - angle * angle / 6.0, 0.5
    else:
        first, second = np.sin(angle) / angle, (1.0 - np.cos(angle)) / (angle * angle)
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross))


def rotation_vector(matrix: Floats) -> Floats:
    """The rotation vector of a rotation matrix, at most half a turn."""
    w = 0.5 * np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    sine, cosine = float(np.sqrt(w @ w)), 0.5 * float(np.trace(matrix) - 1.0)
    angle = float(np.arctan2(sine, cosine))
    if sine > 1e-7:
        return np.asarray(w * (angle / sine))
    if cosine > 0.0:
        return np.asarray(w)
    # half a turn: the axis is the largest column of (R + 1) / 2
    columns = 0.5 * (matrix + np.eye(3))
    axis = columns[:, int(np.argmax(np.diag(columns)))]
    return np.asarray(angle * axis / np.sqrt(axis @ axis))


def pose(position: npt.ArrayLike = (0.0, 0.0, 0.0), turn: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """A pose of a position, metres, and a rotation vector, radians."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation(turn), position
    return made


def moved(world_from_tool: Floats, shift: npt.ArrayLike, turn: npt.ArrayLike, about: npt.ArrayLike) -> Floats:
    """A pose after a turn about a point of the world and a shift; its rotation is made orthogonal again."""
    centre = np.asarray(about, dtype=np.float64)
    by = rotation(turn)
    made = np.eye(4)
    u, _, vt = np.linalg.svd(by @ world_from_tool[:3, :3])
    made[:3, :3] = u @ vt
    made[:3, 3] = by @ (world_from_tool[:3, 3] - centre) + centre + np.asarray(shift, dtype=np.float64)
    return made


def placed(points: Floats, frame: Floats) -> Floats:
    """Points (n, 3) carried along by a pose."""
    return np.asarray(points @ frame[:3, :3].T + frame[:3, 3])


def random_turn(rng: np.random.Generator) -> Floats:
    """A rotation matrix, all equally likely."""
    q = rng.normal(size=4)
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
