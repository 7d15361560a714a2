"""Transforms of parts: 4 x 4 matrices, points and faces through them.

A vertex is transformed in float64 as ((m00*x + m01*y) + m02*z) + m03, with every operation rounded once. Mirrored parts
get their faces turned, so that the outside stays outside.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Matrix: TypeAlias = NDArray[np.float64]

IDENTITY: Matrix = np.eye(4)
IDENTITY.setflags(write=False)


def transform(points: NDArray[np.float64], matrix: Matrix) -> NDArray[np.float64]:
    """Return points (n, 3) transformed by an affine matrix, in the module's order. No BLAS: it may fuse and reorder."""
    if np.array_equal(matrix, IDENTITY):
        return points
    x, y, z = points[:, 0], points[:, 1], points[:, 2]
    moved = np.empty_like(points)
    with np.errstate(all="ignore"):
        for row in range(3):
            a, b, c, d = matrix[row].tolist()
            column = a * x
            column += b * y
            column += c * z
            column += d
            moved[:, row] = column
    return moved


def multiply(a: Matrix, b: Matrix) -> Matrix:
    """Return the matrix that applies `b` first and `a` after it."""
    if a is IDENTITY:
        return b
    if b is IDENTITY:
        return a
    with np.errstate(all="ignore"):
        product: Matrix = ((a[:, 0:1] * b[0] + a[:, 1:2] * b[1]) + a[:, 2:3] * b[2]) + a[:, 3:4] * b[3]
    return product


def is_mirrored(matrix: Matrix) -> bool:
    """Tell whether the matrix turns the inside out: a negative determinant."""
    if matrix is IDENTITY:
        return False
    (a, b, c), (d, e, f), (g, h, i) = matrix[:3, :3].tolist()
    return bool(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0)


def turned(faces: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return the faces reversed; each keeps its first corner."""
    return faces[:, [0, 2, 1]]


def facing(faces: NDArray[np.uint32], matrix: Matrix) -> NDArray[np.uint32]:
    """Return the faces of a part placed by the matrix: reversed if it mirrors."""
    return turned(faces) if is_mirrored(matrix) else faces


def shift_indices(faces: NDArray[np.uint32], base: int, vertex_count: int) -> NDArray[np.uint32]:
    """Return the faces with `base` added to each index, `OUT_OF_RANGE` kept."""
    if not base or not faces.size:
        return faces
    if int(faces.max()) < vertex_count:
        shifted: NDArray[np.uint32] = faces + np.uint32(base)
        return shifted
    return np.where(faces < vertex_count, faces + np.uint32(base), faces)
