"""The rounding error of coordinates in a file, which stores a limited number of digits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from feeler.io.raw import RawMesh

_CHUNK = 1 << 18
_FEWEST_DIGITS, _MOST_DIGITS = 6, 14
"""Numbers of fewer digits are taken for exact ones, such as 12.5; those of more for double precision."""
_NOISE = 4.0 * float(np.finfo(np.float64).eps)
"""By how much a number of a few digits may differ from its double, as a share: by rounding, here and in the reader."""


def single(vertices: NDArray[np.floating]) -> float:
    """The largest error of coordinates that were rounded to single precision."""
    largest = np.abs(vertices[np.isfinite(vertices)]).max(initial=0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        error = 0.5 * float(np.spacing(np.float32(largest)))
    return error if np.isfinite(error) else 0.0


def state_rounding(raw: RawMesh, format_name: str) -> None:
    """Sets `rounding` where the reader has not: by the numbers. Coordinates of STEP are in double precision."""
    if raw.rounding is None:
        raw.rounding = 0.0 if format_name == "STEP" else of_numbers(raw.vertices)


def of_numbers(vertices: NDArray[np.float64]) -> float:
    """The largest error of coordinates (n, 3): half a unit in the last digit of the largest one, if all of them are
    single-precision numbers or decimals of few digits; 0 for double precision."""
    if _all(vertices, lambda some: some.astype(np.float32) == some):
        return single(vertices)
    digits = next((n for n in range(1, _MOST_DIGITS + 1) if _all(vertices, partial(_has_digits, n))), 0)
    if digits < _FEWEST_DIGITS:
        return 0.0
    largest = np.abs(vertices[np.isfinite(vertices)]).max()
    return float(0.5 * 10.0 ** (np.floor(np.log10(largest)) + 1.0 - digits))


def _has_digits(digits: int, numbers: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which numbers have at most this many significant digits."""
    size = np.abs(numbers)
    with np.errstate(all="ignore"):
        unit = 10.0 ** (np.floor(np.log10(size)) + 1.0 - digits)
        rest = np.abs(np.round(size / unit) * unit - size)
    return np.asarray((size == 0.0) | (rest <= _NOISE * size))


def _all(vertices: NDArray[np.float64], is_so: Callable[[NDArray[np.float64]], NDArray[np.bool_]]) -> bool:
    """Whether something holds for all finite coordinates."""
    flat = vertices.reshape(-1)
    for begin in range(0, len(flat), _CHUNK):
        some = flat[begin : begin + _CHUNK]
        some = some[np.isfinite(some)]
        with np.errstate(over="ignore", invalid="ignore"):
            if not is_so(some).all():
                return False
    return True
