"""How far the coordinates of a file may be from those that were meant, since the file has so many digits."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from feeler.io.raw import RawMesh

_CHUNK = 1 << 18
_LEAST_DIGITS, _MOST_DIGITS = 6, 12
"""Decimals of fewer digits are taken for exact ones, such as 12.5; those of more for double precision."""


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
    """The largest error of coordinates (n, 3): half a unit in the last place, if all are numbers of single precision,
    or of so many decimals; 0 for others."""
    if _all(vertices, lambda some: some.astype(np.float32) == some):
        return single(vertices)
    largest = np.abs(vertices[np.isfinite(vertices)]).max(initial=0.0)
    before = max(int(np.floor(np.log10(largest))) + 1, 0) if largest > 0.0 else 0
    for decimals in range(_MOST_DIGITS - before + 1):
        if _all(vertices, partial(_has_decimals, decimals)):
            return 0.5 * 10.0**-decimals if before + decimals >= _LEAST_DIGITS else 0.0
    return 0.0


def _has_decimals(decimals: int, numbers: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(np.round(numbers, decimals) == numbers)


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
