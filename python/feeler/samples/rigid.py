"""Rotations as quaternions (w, x, y, z), and rigid matrices made from them."""

from __future__ import annotations

import numpy as np

from .mesh import Floats


def random_quaternion(rng: np.random.Generator) -> Floats:
    """A rotation, all equally likely."""
    return normalised(rng.normal(size=4))


def normalised(quaternion: Floats) -> Floats:
    """Quaternions (..., 4) of length one."""
    return np.asarray(quaternion / np.sqrt((quaternion * quaternion).sum(axis=-1, keepdims=True)))


def product(a: Floats, b: Floats) -> Floats:
    """The rotation `b`, then `a`; (..., 4)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def about(axis: Floats, angle: Floats | float) -> Floats:
    """The rotation by `angle` (radians) about a unit axis (3,); (..., 4)."""
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)


def between(start: Floats, end: Floats) -> Floats:
    """The shortest rotation that takes the unit vector `start` to `end`; (4,)."""
    cosine = float(start @ end)
    if cosine < -0.999999:
        side = np.eye(3)[int(np.argmin(np.abs(start)))]
        axis = np.cross(start, side)
        return normalised(np.concatenate([[0.0], axis]))
    return normalised(np.concatenate([[1.0 + cosine], np.cross(start, end)]))


def slerp(a: Floats, b: Floats, share: Floats) -> Floats:
    """Rotations (n, 4) from `a` to `b`, (4,) each, at shares (n,), the short way round."""
    cosine = float(a @ b)
    if cosine < 0.0:
        b, cosine = -b, -cosine
    if cosine > 0.9999995:
        return normalised(a + share[:, None] * (b - a))
    angle = np.arccos(min(1.0, cosine))
    return normalised(np.sin((1.0 - share) * angle)[:, None] * a + np.sin(share * angle)[:, None] * b)


def matrices(quaternions: Floats, positions: Floats) -> Floats:
    """Rigid matrices (n, 4, 4) from rotations (n, 4) and positions (n, 3), orthonormal to the last few bits."""
    w, x, y, z = np.moveaxis(normalised(quaternions), -1, 0)
    poses = np.zeros((len(w), 4, 4))
    poses[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1)
    poses[:, 1, :3] = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1)
    poses[:, 2, :3] = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
    poses[:, :3, 3] = positions
    poses[:, 3, 3] = 1.0
    return poses
