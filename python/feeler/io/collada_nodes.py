"""The transforms of COLLADA nodes: any number of them, of six kinds, applied in the order of the file."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from feeler.io.collada_document import Document, Element
from feeler.io.placing import IDENTITY, Matrix, multiply
from feeler.io.rounding import PlacementErrors, errors_of

Numbers = NDArray[np.float64]


def local_matrix(document: Document, node: Element, errors: PlacementErrors, above: int) -> tuple[Matrix, int]:
    """Return parent_from_node: the product of the transforms of a node, the first one outermost; and its number among
    the errors of placements. above: that of its parent."""
    matrix, row = IDENTITY, above
    for child in node.children:
        if child.tag in _KINDS:
            count, make = _KINDS[child.tag]
            numbers = document.floats(child, count)
            try:
                made = make(numbers)
            except ValueError as error:
                raise document.fail(f"<{child.tag}> {error}", child) from None
            matrix = multiply(matrix, made)
            row = errors.add(row, made, share=_turn_error(numbers) if child.tag == "rotate" else 0.0)
    return matrix, row


def _turn_error(numbers: Numbers) -> float:
    """By how much axis and angle may be off in text, radians."""
    off, length = errors_of(numbers), float(np.linalg.norm(numbers[:3]))
    # A turn by 0 may have any axis, also none.
    return 2.0 * float(np.linalg.norm(off[:3])) / length + math.radians(float(off[3])) if numbers[3] else 0.0


def _matrix(numbers: Numbers) -> Matrix:
    """Row by row, for column vectors."""
    matrix = numbers.reshape(4, 4)
    if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise ValueError("is not an affine transform")
    return matrix


def _translate(numbers: Numbers) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = numbers
    return matrix


def _scale(numbers: Numbers) -> Matrix:
    return np.diag([*numbers.tolist(), 1.0])


def _rotate(numbers: Numbers) -> Matrix:
    """Axis and angle in degrees."""
    matrix = np.eye(4)
    if not numbers[3]:
        return matrix
    x, y, z = _unit(numbers[:3]).tolist()
    cosine, sine = _cosine_sine(float(numbers[3]))
    rest = 1 - cosine
    matrix[:3, :3] = [
        [cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine],
        [x * y * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine],
        [x * z * rest - y * sine, y * z * rest + x * sine, cosine + z * z * rest],
    ]
    return matrix


def _look_at(numbers: Numbers) -> Matrix:
    """Eye, point of interest, up: the node looks along its -z at the point, with its y up."""
    eye, interest, up = numbers.reshape(3, 3)
    back = _unit(eye - interest)
    side = _unit(np.cross(up, back))
    matrix = np.eye(4)
    matrix[:3, :] = np.stack([side, np.cross(back, side), back, eye], axis=1)
    return matrix


def _skew(numbers: Numbers) -> Matrix:
    """Angle in degrees, axis that is turned, axis along which points move (as in RenderMan)."""
    turned, along = _unit(numbers[1:4]), _unit(numbers[4:7])
    across = turned - float(turned @ along) * along
    if not float(across @ across) > 1e-24:
        raise ValueError("has two axes of one direction")
    across = _unit(across)
    flat, steep = float(turned @ across), float(turned @ along)
    cosine, sine = _cosine_sine(float(numbers[0]))
    new_flat = flat * cosine - steep * sine
    if new_flat <= 0:
        raise ValueError("has an angle that reaches the axis along which points move")
    amount = (flat * sine + steep * cosine) / new_flat - steep / flat
    matrix = np.eye(4)
    matrix[:3, :3] += amount * np.outer(along, across)
    return matrix


def _cosine_sine(degrees: float) -> tuple[float, float]:
    """Return cosine and sine; exact for quarter turns, which are common in files."""
    if math.isfinite(degrees) and degrees % 90 == 0:
        quarter = int(degrees % 360) // 90
        return (1.0, 0.0, -1.0, 0.0)[quarter], (0.0, 1.0, 0.0, -1.0)[quarter]
    radians = math.radians(degrees) if math.isfinite(degrees) else math.nan
    return math.cos(radians), math.sin(radians)


def _unit(vector: Numbers) -> Numbers:
    length = math.sqrt(float(vector @ vector))
    if not length > 0 or not math.isfinite(length):
        raise ValueError("has an axis of length zero")
    return vector / length


_KINDS: dict[str, tuple[int, Callable[[Numbers], Matrix]]] = {
    "matrix": (16, _matrix),
    "translate": (3, _translate),
    "rotate": (4, _rotate),
    "scale": (3, _scale),
    "lookat": (9, _look_at),
    "skew": (7, _skew),
}
